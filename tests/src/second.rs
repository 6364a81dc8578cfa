//! A second opinion on a folded shape, by other formulas than [`Sheet::fold`]'s: 4x4 matrices round vertices and
//! along another tree, and vertices alone by least squares.

use nalgebra::Vector3;

use crate::{Random, Sheet, worst};

/// Rounding, over the median edge: of matrices, and of least squares, whose equations are as good but whose
/// solution loses what the sheet magnifies.
const ROUNDING: f64 = 1e-9;
const LEAST_SQUARES: f64 = 1e-6;
/// How often two ways from face to face may wind round a vertex.
const WINDINGS: f64 = 2.0;
/// Vertices beyond which least squares take too long.
const VERTICES: usize = 120;

/// A shape given by the fold angles of the edges, radians.
pub(crate) struct Shape<'a> {
    pub(crate) sheet: &'a Sheet,
    pub(crate) stars: &'a [(usize, Vec<usize>)],
    pub(crate) angles: &'a [f64],
}

impl Shape<'_> {
    /// Tells `limit` by how much these `positions`, whose gap is given, differ from what the other formulas have.
    pub(crate) fn compare(
        &self,
        positions: &[Vector3<f64>],
        gap: f64,
        random: &mut Random,
        limit: &mut impl FnMut(&str, f64, f64),
    ) {
        let Self {
            sheet,
            stars,
            angles,
        } = *self;
        let apart = |others: &[Vector3<f64>]| {
            let ways = positions.iter().zip(others).map(|(a, b)| (a - b).norm());
            worst(ways) / sheet.median_edge()
        };
        let [turn, shift] = sheet.closure_by_matrices(stars, angles);
        let closure = sheet.closure_round(stars, angles);
        limit(
            "closure by 4x4 matrices off by",
            (turn - closure).abs(),
            ROUNDING,
        );
        limit("a vertex moved on the way round it by", shift, ROUNDING);
        // Ways round a hole differ by a gap.
        let gap = sheet.other_tree(stars) * gap;
        let torn = WINDINGS * self.apart() + gap;
        let others = sheet.positions_by_matrices(angles);
        limit(
            "positions off those of another tree by",
            apart(&others),
            torn + ROUNDING,
        );
        if sheet.flat.len() > VERTICES {
            return;
        }
        match sheet.solved(angles, positions, random) {
            Some(solved) => {
                limit("left of least squares", solved.left, torn + ROUNDING);
                // What an edge is torn by turns what is beyond it by that over its length.
                let turned = gap / self.shortest();
                let most = torn + turned * self.span() + LEAST_SQUARES;
                limit(
                    "positions off least squares by",
                    apart(&solved.positions),
                    most,
                );
            }
            None => limit("least squares without a solution", f64::NAN, 0.0),
        }
    }

    /// By how much ways to the same face differ that enclose all vertices once, over the median edge: by their residuals, each
    /// times a lever arm.
    pub(crate) fn apart(&self) -> f64 {
        let residuals = self.stars.iter().map(|star| {
            let star = core::slice::from_ref(star);
            self.sheet.closure_round(star, self.angles)
        });
        residuals.sum::<f64>() * self.span()
    }

    /// The shortest edge, over the median one.
    fn shortest(&self) -> f64 {
        let Sheet { flat, edges, .. } = self.sheet;
        let lengths = edges.iter().map(|&[a, b]| (flat[b] - flat[a]).norm());
        lengths.fold(f64::INFINITY, f64::min) / self.sheet.median_edge()
    }

    /// From one corner of the flat sheet's box to the other, over the median edge.
    fn span(&self) -> f64 {
        let flat = &self.sheet.flat;
        let low = flat.iter().fold(flat[0], |low, p| low.inf(p));
        let high = flat.iter().fold(flat[0], |high, p| high.sup(p));
        (high - low).norm() / self.sheet.median_edge()
    }
}
