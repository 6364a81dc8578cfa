//! A second opinion on a folded shape, by other formulas than those of [`Sheet::fold`]: 4x4 matrices round vertices and
//! along another spanning tree, and least squares on the vertices alone.

use nalgebra::Vector3;

use crate::{Random, Sheet, worst};

/// `ROUNDING`: rounding error of the matrices, over the median edge. `LEAST_SQUARES`: error of least squares, over the
/// median edge. Its equations are as precise, but the sheet magnifies errors of the solution.
const ROUNDING: f64 = 1e-9;
const LEAST_SQUARES: f64 = 1e-6;
/// Largest number of times that two paths from face to face wind round a vertex.
const WINDINGS: f64 = 2.0;
/// Number of vertices beyond which least squares take too long.
const VERTICES: usize = 120;

/// A shape, given by the fold angles of the edges, radians.
pub(crate) struct Shape<'a> {
    pub(crate) sheet: &'a Sheet,
    pub(crate) stars: &'a [(usize, Vec<usize>)],
    pub(crate) angles: &'a [f64],
    /// The face that stays.
    pub(crate) root: usize,
}

impl Shape<'_> {
    /// Compares these `positions`, whose gap is given, with the other formulas, and reports each difference to `limit`.
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
            root,
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
        // Paths on different sides of a hole differ by a gap.
        let gap = sheet.other_tree(stars) * gap;
        let torn = WINDINGS * self.apart() + gap;
        let others = sheet.positions_by_matrices(root, angles);
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
                // A tear of an edge rotates everything beyond it by the tear over the length of the edge.
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

    /// Returns the largest difference, over the median edge, between the positions of a face along two paths that
    /// enclose every vertex once: the sum of all residuals, each times the largest lever arm.
    pub(crate) fn apart(&self) -> f64 {
        let residuals = self.stars.iter().map(|star| {
            let star = core::slice::from_ref(star);
            self.sheet.closure_round(star, self.angles)
        });
        residuals.sum::<f64>() * self.span()
    }

    /// Returns the length of the shortest edge, over the median edge.
    fn shortest(&self) -> f64 {
        let Sheet { flat, edges, .. } = self.sheet;
        let lengths = edges.iter().map(|&[a, b]| (flat[b] - flat[a]).norm());
        lengths.fold(f64::INFINITY, f64::min) / self.sheet.median_edge()
    }

    /// Returns the diagonal of the flat sheet's bounding box, over the median edge.
    fn span(&self) -> f64 {
        let flat = &self.sheet.flat;
        let low = flat.iter().fold(flat[0], |low, p| low.inf(p));
        let high = flat.iter().fold(flat[0], |high, p| high.sup(p));
        (high - low).norm() / self.sheet.median_edge()
    }
}
