//! Bounds on the closure residuals of stars and loops over a whole segment.
//!
//! The misclosure of a vertex is a product of quaternions c + n (cos α, sin α, 0), one for each crease, with (c, n)
//! either the half angle (cos ρ/2, sin ρ/2) of a cubic ρ, or cubics themselves. Either way the product is an analytic
//! function of s without any pole. As a complex matrix each factor has the norm max |c ± n i|, which the Chebyshev
//! coefficients of the cubics bound on an ellipse. So [`chebyshev`](super::chebyshev) gives a bound on the vector part
//! V from its values at some points. The residual is 2 |V| over the norm of the product, of which a lower bound is
//! known. The segment is halved if weights vary much over it or angles turn far.
//!
//! The translation of a loop is a sum of differences of places rotated by products of the same quaternions, of twice
//! the degree. It is bounded in the same way.

use core::time::Duration;

use foldpath_core::{Curve, HalfAngle, LoopsView, Spoke, StarView, StarsView, closure, hole, norm};

use super::bernstein::Piece;
use super::chebyshev::{Points, RADII, Radius, radii};
use super::{LOOSE_RATIO, MAX_HALVINGS, Part, ROUNDING_FACTOR};
use crate::util::parallel;

/// About the time that bounding a curve, evaluating a curve, and bounding or evaluating the condition of a star takes.
const TIME_PER_PIECE: Duration = Duration::from_nanos(200);
const TIME_PER_SAMPLE: Duration = Duration::from_nanos(30);
const TIME_PER_STAR: Duration = Duration::from_nanos(100);

/// Error of the polynomials, as a residual, for which the number of points is chosen: below all rounding. If no number
/// of points reaches it, the largest one is used.
const MAX_POLYNOMIAL_ERROR_RAD: f64 = 1e-16;
/// Bound up to which a part is never halved, as it is rounding.
const ROUNDING_RAD: f64 = 1e-13;
/// Rounding of a product of two quaternions, in ε: each of its components sums four products of at most four roundings
/// of ε/2 each; the norm of |c|, |x|, |y| is at most √3.
const PRODUCT_ROUNDING_EPSILONS: f64 = 3.5;

/// Bounds on the closure residuals over a segment; infinite if nothing can be bounded, as for curves that are not
/// finite.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Closure {
    /// For each star, a bound on the norm of its residual r.
    pub stars: Vec<f64>,
    /// For each loop, bounds on the norms of the residuals of its rotation and of its translation.
    pub loops: Vec<[f64; 2]>,
}

impl Closure {
    /// Returns the largest of all bounds.
    #[must_use]
    pub fn worst(&self) -> f64 {
        self.bounds().fold(0.0, f64::max)
    }

    /// Takes in bounds over another part of the motion.
    pub(crate) fn take_in(&mut self, others: impl IntoIterator<Item = f64>) {
        let loops = self.loops.as_flattened_mut().iter_mut();
        for (worst, bound) in self.stars.iter_mut().chain(loops).zip(others) {
            *worst = worst.max(bound);
        }
    }

    /// Returns the bounds one after the other, in the order of the conditions.
    pub(crate) fn bounds(&self) -> impl Iterator<Item = f64> {
        let loops = self.loops.as_flattened();
        self.stars.iter().chain(loops).copied()
    }
}

/// Bounds on one residual over a part of the segment.
#[derive(Clone, Copy, Debug)]
struct Condition {
    /// ln M for each Bernstein ellipse.
    growth: [f64; RADII],
    /// Bound on the rounding error of a value.
    rounding: f64,
    /// Largest residual seen at the points.
    seen: f64,
    /// Largest product of a residual seen and the norms of its quaternions, each over its lower bound.
    largest: f64,
}

/// Workspace that certifies one segment after the other.
#[derive(Clone, Debug)]
pub struct SegmentCertifier {
    radii: [Radius; RADII],
    points: [Points; 6],
    pieces: Vec<Piece>,
    half_angles: Vec<HalfAngle<f64>>,
    /// Half angle of each group at a point, with the norm of its quaternion over the lower bound.
    samples: Vec<(HalfAngle<f64>, f64)>,
    conditions: Vec<Condition>,
    open: Vec<Part>,
    bounds: Closure,
}

impl Default for SegmentCertifier {
    fn default() -> Self {
        Self {
            radii: radii(),
            points: Points::all(),
            pieces: Vec::new(),
            half_angles: Vec::new(),
            samples: Vec::new(),
            conditions: Vec::new(),
            open: Vec::new(),
            bounds: Closure::default(),
        }
    }
}

impl SegmentCertifier {
    /// Bounds the residuals of all stars and loops while each group turns along its curve. A spoke whose group has no
    /// curve stays flat.
    ///
    /// Cost: 9 to 49 evaluations for each part into which the segment is halved: 1 part if no angle turns by more than
    /// about ten degrees, at most 256. Allocates only if a sheet is larger than all before.
    pub fn closure(
        &mut self,
        stars: StarsView<'_, f64>,
        loops: LoopsView<'_, f64>,
        curves: &[Curve<f64>],
    ) -> &Closure {
        self.bounds.stars.clear();
        self.bounds.stars.resize(stars.len(), 0.0);
        self.bounds.loops.clear();
        self.bounds.loops.resize(loops.len(), [0.0; 2]);
        self.open.clear();
        self.open.push(Part::default());
        // Largest residuals seen: of rotations, and of translations.
        let mut seen = [0.0; 2];
        while let Some(part) = self.open.pop() {
            self.prepare(stars, loops, curves, part.ends());
            let points = self.enough_points();
            let known = self.pieces.iter().all(|piece| piece.least > 0.0);
            if known {
                self.evaluate(stars, loops, curves, part.ends(), points);
            }
            if part.depth == MAX_HALVINGS || known && self.is_tight(points, &mut seen) {
                self.accept(points);
            } else {
                self.open.extend(part.halves());
            }
        }
        &self.bounds
    }

    /// Bounds the curves and the growth of the conditions over a part without evaluating any condition.
    fn prepare(
        &mut self,
        stars: StarsView<'_, f64>,
        loops: LoopsView<'_, f64>,
        curves: &[Curve<f64>],
        part: [f64; 2],
    ) {
        let piece = |group: usize| Piece::new(&curves[group], part, &self.radii);
        parallel::collect(&mut self.pieces, curves.len(), TIME_PER_PIECE, piece);
        let pieces = &self.pieces;
        let star = |index: usize| rotation(spokes_of(stars, index), pieces);
        parallel::collect(&mut self.conditions, stars.len(), TIME_PER_STAR, star);
        self.conditions.extend(loops.iter().flat_map(|cycle| {
            let turn = rotation(cycle.spokes, pieces);
            [turn, translation(&turn, cycle.places)]
        }));
    }

    /// Returns the index of the fewest points that serve every condition, or else of the most points.
    fn enough_points(&self) -> usize {
        let enough = |points: &Points| {
            let mut errors = self.conditions.iter();
            errors.all(|c| points.error(&self.radii, &c.growth) <= MAX_POLYNOMIAL_ERROR_RAD)
        };
        let last = self.points.len() - 1;
        self.points.iter().position(enough).unwrap_or(last)
    }

    /// Evaluates the residuals at the points.
    fn evaluate(
        &mut self,
        stars: StarsView<'_, f64>,
        loops: LoopsView<'_, f64>,
        curves: &[Curve<f64>],
        [from, to]: [f64; 2],
        points: usize,
    ) {
        let mut conditions = core::mem::take(&mut self.conditions);
        for at in &self.points[points].at {
            let s = from + (to - from) * at;
            let pieces = &self.pieces;
            let sample = |group: usize| pieces[group].sample(&curves[group], s);
            parallel::collect(&mut self.samples, curves.len(), TIME_PER_SAMPLE, sample);
            self.half_angles.clear();
            self.half_angles
                .extend(self.samples.iter().map(|(half, _)| *half));
            let (half_angles, samples) = (&self.half_angles, &self.samples);
            let size = |spokes: &[Spoke<f64>]| -> f64 {
                let samples = spokes
                    .iter()
                    .filter_map(|spoke| samples.get(spoke.group.index()));
                samples.map(|(_, size)| size).product()
            };
            let (rotations, both) = conditions.split_at_mut(stars.len());
            parallel::change(rotations, TIME_PER_STAR, |index, condition| {
                let spokes = spokes_of(stars, index);
                let residual = norm(&closure::residual(StarView { spokes }, half_angles));
                condition.see(residual, size(spokes));
            });
            for (cycle, both) in loops.iter().zip(both.chunks_exact_mut(2)) {
                let size = size(cycle.spokes);
                let residuals = hole::residuals(cycle, half_angles);
                both[0].see(norm(&residuals[0]), size);
                both[1].see(norm(&residuals[1]), size * size);
            }
        }
        self.conditions = conditions;
    }

    /// Returns `true` if every bound is near the largest residual of its kind seen in the segment. `seen` has these for
    /// rotations and for translations, and takes in those of this part.
    fn is_tight(&self, points: usize, seen: &mut [f64; 2]) -> bool {
        let stars = self.bounds.stars.len();
        let kind = |index: usize| usize::from(index >= stars && (index - stars) % 2 == 1);
        let conditions = || self.conditions.iter().enumerate();
        for (index, condition) in conditions() {
            let seen = &mut seen[kind(index)];
            *seen = seen.max(condition.seen);
        }
        conditions().all(|(index, condition)| {
            let bound =
                self.points[points].bound(&self.radii, &condition.growth, condition.largest);
            bound <= (LOOSE_RATIO * seen[kind(index)]).max(ROUNDING_RAD)
        })
    }

    /// Takes the bounds over a part into the bounds over the segment.
    fn accept(&mut self, points: usize) {
        let points = &self.points[points];
        let bound = |c: &Condition| points.bound(&self.radii, &c.growth, c.largest);
        self.bounds.take_in(self.conditions.iter().map(bound));
    }
}

impl Condition {
    /// Takes in a residual at one of the points. `size` is the product of the norms of its quaternions, each over its
    /// lower bound.
    fn see(&mut self, residual: f64, size: f64) {
        let residual = residual + self.rounding;
        self.seen = self.seen.max(residual);
        let weighted = residual * size;
        self.largest = if weighted.is_nan() {
            f64::INFINITY
        } else {
            self.largest.max(weighted)
        };
    }
}

/// Returns the spokes of a star.
fn spokes_of(stars: StarsView<'_, f64>, index: usize) -> &[Spoke<f64>] {
    stars.get(index).map_or(&[], |star| star.spokes)
}

/// Bounds the growth and the rounding of the rotation of a star or a loop.
fn rotation(spokes: &[Spoke<f64>], pieces: &[Piece]) -> Condition {
    let mut growth = [core::f64::consts::LN_2; RADII];
    let mut rounding = 0.0;
    for spoke in spokes {
        let Some(piece) = pieces.get(spoke.group.index()) else {
            continue;
        };
        for (sum, growth) in growth.iter_mut().zip(piece.growth) {
            *sum += growth;
        }
        let [x, y] = spoke.direction;
        rounding +=
            piece.rounding + PRODUCT_ROUNDING_EPSILONS * f64::EPSILON + (x * x + y * y - 1.0).abs();
    }
    Condition {
        growth,
        // The residual r is twice the vector part.
        rounding: ROUNDING_FACTOR * 2.0 * rounding,
        seen: 0.0,
        largest: 0.0,
    }
}

/// Bounds the growth and the rounding of the translation of a loop with this rotation.
fn translation(turn: &Condition, places: &[[f64; 2]]) -> Condition {
    let reach: f64 = places.iter().map(|[x, y]| x.hypot(*y)).sum();
    // Two rotated places for each spoke, each rotated by quaternions on both sides.
    let growth = |growth: f64| 2.0 * (growth - core::f64::consts::LN_2) + (2.0 * reach).ln();
    // A rotated place is off by twice the error of the quaternion. Each sum adds a rounding or two of all terms before.
    let sums =
        ROUNDING_FACTOR * (24.0 + 4.0 * places.iter().map(|_| 1.0).sum::<f64>()) * f64::EPSILON;
    Condition {
        growth: turn.growth.map(growth),
        rounding: reach * (2.0 * turn.rounding + sums),
        ..*turn
    }
}
