//! Bounds the closure residual of every vertex anywhere between two knots: dense sampling with a margin.
//!
//! The path is cut into intervals, and the misclosure L - I of every vertex is sampled at the m zeros of the
//! Chebyshev polynomial T_m in each: L as a product of matrices, with fold angles from the curves. Let p be the
//! polynomial of degree n - 1 that interpolates L - I at the zeros of T_n. Its error is at most e = gₙ 2¹⁻ⁿ,
//! where gₙ bounds the n-th derivative over n!, in units of the half width of the interval (see
//! [`super::majorant`]). And a polynomial of degree n - 1 is nowhere larger than 1 / cos((n - 1) π / 2m) times
//! the largest of its values at the m samples [EhlichZeller1964]. So with the largest sample r,
//!
//! ‖L - I‖ ≤ (r + e) / cos((n - 1) π / 2m) + e
//!
//! for every n up to m; the least of these bounds counts. The larger the residual, the smaller the n that gives
//! the least bound, and the nearer the bound to the sample; n = 1 is the margin of a Lipschitz constant.
//! Intervals in which e dominates are halved.
//!
//! [EhlichZeller1964]: H. Ehlich, K. Zeller, "Schwankung von Polynomen zwischen Gitterpunkten",
//! Math. Zeitschrift 86.

use core::f64::consts::{FRAC_PI_2, SQRT_2};
use core::time::Duration;

use foldpath_core::{Curve, Spoke};
use nalgebra::{Matrix3, Vector3};

use super::count;
use super::majorant::{MAX_ORDER, Series, exponential, of_angle};
use crate::folding::Rigidity;
use crate::pattern::{ClosureSite, CreasePattern};
use crate::symmetry::ReducedStars;
use crate::util::parallel;

/// About the time that an angle of a curve, with its sine and cosine, bounding the derivatives of a curve, and all samples
/// of a condition take.
const TIME_PER_ANGLE: Duration = Duration::from_nanos(50);
const TIME_PER_SERIES: Duration = Duration::from_nanos(500);
const TIME_PER_CONDITION: Duration = Duration::from_micros(4);

/// Effort of bounding a segment: how close a bound has to come to the samples.
#[derive(Clone, Copy, Debug)]
pub(super) struct Effort {
    /// Number of samples in an interval: m in the formula of this module.
    samples: usize,
    /// Ratio to the largest sample of the segment at which bounds are good enough.
    loose: f64,
}

impl Effort {
    /// At degree 19 the factor 1 / cos(...) of the formula is 3.1.
    pub(super) const ROUGH: Self = Self {
        samples: 24,
        loose: 2.0,
    };
    /// At degree 8 the factor is 1.005.
    pub(super) const FINE: Self = Self {
        samples: 128,
        loose: 1.01,
    };
}

/// Largest number of successive halvings of an interval (`MAX_HALVINGS`). A few intervals of a segment, at most
/// `MAX_FEW_INTERVALS`, are halved oftener (`MAX_HALVINGS_OF_FEW`), because a weight may go towards 0 in them.
const MAX_HALVINGS: u32 = 7;
const MAX_HALVINGS_OF_FEW: u32 = 14;
const MAX_FEW_INTERVALS: usize = 64;
/// Margin below which a bound is good enough.
const MARGIN_RAD: f64 = 1e-11;

/// The closure residual of a segment, over all vertices and holes, and the errors of the sheet that it allows.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct SegmentClosure {
    /// Largest residual sampled.
    pub sampled: f64,
    /// Place of this sample in the segment, from 0 to 1.
    pub at: f64,
    /// The vertex or hole with this residual.
    pub open: Option<ClosureSite>,
    /// Upper bound of all residuals.
    pub bound: f64,
    /// A vertex or hole with this bound: one of those that close worst.
    pub place: Option<ClosureSite>,
    /// Number of samples taken.
    pub samples: usize,
    /// Upper bounds of deformation, gap and twist of the whole sheet. `None` if no bound is known.
    pub rigidity: Option<Rigidity>,
}

impl SegmentClosure {
    /// A segment to which the check did not come.
    pub(super) const UNJUDGED: Self = Self {
        sampled: 0.0,
        at: 0.0,
        open: None,
        bound: f64::INFINITY,
        place: None,
        samples: 0,
        rigidity: None,
    };

    /// Returns `true` if the check came to the segment.
    pub(super) fn is_judged(&self) -> bool {
        self.samples > 0
    }

    /// Returns the largest of all bounds; infinite if one is not known.
    #[must_use]
    pub fn error(&self) -> f64 {
        let sheet = self.rigidity.map_or(f64::INFINITY, Rigidity::worst);
        sheet.max(self.bound)
    }
}

/// Bounds the closure residuals of all stars and holes over a segment. Returns the summary, and the bounds of
/// stars, then those of holes. Bounds are not refined further once a residual larger than `decided` is sampled.
/// Cost: O(samples · stars).
pub(super) fn certify(
    pattern: &CreasePattern,
    stars: &ReducedStars,
    curves: &[Curve<f64>],
    effort: &Effort,
    decided: f64,
) -> (SegmentClosure, Vec<f64>) {
    let conditions = conditions(pattern, stars);
    let all: Vec<usize> = (0..conditions.len()).collect();
    let mut segment = Segment {
        curves,
        bounds: vec![0.0; conditions.len()],
        conditions,
        effort,
        decided,
        found: SegmentClosure::default(),
        short: 0,
    };
    segment.refine(0.5, 0.5, &all, 0);
    (segment.found, segment.bounds)
}

/// A vertex or a hole, and the creases met on the way round it.
struct Condition<'a> {
    place: ClosureSite,
    spokes: &'a [Spoke<f64>],
    /// Points of the creases round a hole; empty for a vertex.
    places: &'a [[f64; 2]],
    /// Ratio of the bounds on the derivatives of the residual to those on the derivatives of the rotation.
    lever: f64,
    /// Part of the residual that rounding may hide.
    hidden: f64,
}

fn conditions<'a>(pattern: &CreasePattern, stars: &'a ReducedStars) -> Vec<Condition<'a>> {
    // The Frobenius norm is at most √3 times the operator norm, and the residual is the Frobenius norm over √2.
    let turn = 1.5_f64.sqrt();
    let vertices = stars.vertices().iter().zip(stars.view().iter());
    let vertices = vertices.map(|(&vertex, star)| Condition {
        place: ClosureSite::Vertex(vertex),
        spokes: star.spokes,
        places: &[],
        lever: turn,
        hidden: count(star.spokes.len()) * ROUNDING_EPSILONS * f64::EPSILON,
    });
    let holes = stars.holes().iter().zip(stars.loops().iter());
    let holes = holes.map(|(&hole, way)| {
        // t = q₁ + Σ P (q_k - q_k-1) - P q, with P the products of the first turns: the derivatives of each P
        // are bounded as those of the product of all.
        let points = || {
            way.places
                .iter()
                .map(|&place| nalgebra::Vector2::from(place))
        };
        let steps = points().zip(points().skip(1)).map(|(a, b)| (b - a).norm());
        let last = points().next_back().map_or(0.0, |q| q.norm());
        Condition {
            place: pattern.hole_site(hole),
            spokes: way.spokes,
            places: way.places,
            lever: turn.max(steps.sum::<f64>() + last),
            hidden: 2.0 * count(way.spokes.len()) * ROUNDING_EPSILONS * f64::EPSILON,
        }
    });
    vertices.chain(holes).collect()
}

/// Rounding errors, in ε, for each factor of the product: of sine and cosine of an angle near π, of an entry of
/// the matrix, and of the product.
const ROUNDING_EPSILONS: f64 = 32.0;

struct Segment<'a> {
    curves: &'a [Curve<f64>],
    conditions: Vec<Condition<'a>>,
    bounds: Vec<f64>,
    effort: &'a Effort,
    decided: f64,
    found: SegmentClosure,
    /// Number of intervals that come from `MAX_HALVINGS` halvings or more.
    short: usize,
}

impl Segment<'_> {
    /// Bounds the `open` conditions on the interval about `middle` of half width `half`.
    fn refine(&mut self, middle: f64, half: f64, open: &[usize], halvings: u32) {
        let samples = self.effort.samples;
        self.found.samples += samples;
        let nodes = (0..samples).map(|k| middle - half * zero_of_chebyshev(k, samples));
        let nodes: Vec<f64> = nodes.collect();
        let curves = self.curves;
        let each = parallel::total_time(curves.len(), TIME_PER_ANGLE);
        let turns: Vec<Vec<[f64; 2]>> = parallel::map(&nodes, each, |&s| {
            let angles = curves.iter().map(|curve| curve.angle(s));
            angles.map(|angle| angle.sin_cos().into()).collect()
        });
        let series = parallel::map(curves, TIME_PER_SERIES, |curve| {
            of_angle(curve, middle, half)
        });
        let conditions = &self.conditions;
        let judged = parallel::map(open, TIME_PER_CONDITION, |&index| {
            let condition = &conditions[index];
            let (mut sampled, mut at) = (0.0, middle);
            for (&s, turns) in nodes.iter().zip(&turns) {
                let residual = condition.residual(turns);
                if residual > sampled || residual.is_nan() {
                    (sampled, at) = (residual, s);
                }
            }
            (sampled, at, condition.bound(samples, sampled, &series))
        });
        let mut bounds = Vec::with_capacity(open.len());
        for (&index, (sampled, at, bound)) in open.iter().zip(judged) {
            if sampled > self.found.sampled || sampled.is_nan() {
                (self.found.sampled, self.found.at) = (sampled, at);
                self.found.open = Some(self.conditions[index].place);
            }
            bounds.push((index, bound));
        }
        let sampled = self.found.sampled;
        let enough = self.effort.loose * sampled + MARGIN_RAD;
        self.short += usize::from(halvings >= MAX_HALVINGS);
        let most = if self.short > MAX_FEW_INTERVALS {
            MAX_HALVINGS
        } else {
            MAX_HALVINGS_OF_FEW
        };
        let give_up = halvings >= most || sampled > self.decided || sampled.is_nan();
        let (done, rest): (Vec<_>, Vec<_>) = bounds
            .into_iter()
            .partition(|&(_, bound)| give_up || bound <= enough);
        for (index, bound) in done {
            self.bounds[index] = self.bounds[index].max(bound);
            if bound > self.found.bound || bound.is_nan() {
                self.found.bound = bound;
                self.found.place = Some(self.conditions[index].place);
            }
        }
        if rest.is_empty() {
            return;
        }
        let rest: Vec<usize> = rest.into_iter().map(|(index, _)| index).collect();
        let half = half / 2.0;
        self.refine(middle - half, half, &rest, halvings + 1);
        self.refine(middle + half, half, &rest, halvings + 1);
    }
}

/// Returns zero number k of the Chebyshev polynomial of degree `of`.
fn zero_of_chebyshev(k: usize, of: usize) -> f64 {
    ((2.0 * count(k) + 1.0) / count(of) * FRAC_PI_2).cos()
}

impl Condition<'_> {
    /// Returns the residual for given sines and cosines of the group angles: ‖L - I‖ / √2 of the rotation, or
    /// round a hole the translation if that is larger.
    fn residual(&self, turns: &[[f64; 2]]) -> f64 {
        let mut l = Matrix3::identity();
        let mut moved = Vector3::zeros();
        let mut places = self.places.iter();
        for spoke in self.spokes {
            let [sin, cos] = turns[spoke.group.index()];
            let turn = turn(
                spoke.direction,
                if spoke.negative { -sin } else { sin },
                cos,
            );
            if let Some(&[x, y]) = places.next() {
                let place = Vector3::new(x, y, 0.0);
                moved += l * (place - turn * place);
            }
            l *= turn;
        }
        let residual = (l - Matrix3::identity()).norm() / SQRT_2;
        if moved.norm() > residual {
            moved.norm()
        } else {
            residual
        }
    }

    /// Returns the least of the bounds over all n, given the number of samples, the largest of them, and the
    /// bounds on the derivatives of the groups.
    fn bound(&self, samples: usize, sampled: f64, groups: &[Series]) -> f64 {
        let mut sum = [0.0; MAX_ORDER + 1];
        for spoke in self.spokes {
            let of_group = &groups[spoke.group.index()];
            sum.iter_mut().zip(of_group).for_each(|(sum, h)| *sum += h);
        }
        let sampled = sampled + self.hidden;
        let derivatives = exponential(&sum);
        let mut half_power = 2.0;
        let bounds = (0..MAX_ORDER).map(|degree| {
            half_power *= 0.5;
            let error = self.lever * derivatives[degree + 1] * half_power;
            let factor = (count(degree) / count(samples) * FRAC_PI_2).cos();
            (sampled + error) / factor + error + self.hidden
        });
        bounds.fold(f64::INFINITY, f64::min)
    }
}

/// Returns the rotation about the direction (x, y) of the sheet by an angle with this sine and cosine
/// (Rodrigues).
fn turn([x, y]: [f64; 2], sin: f64, cos: f64) -> Matrix3<f64> {
    let versine = 1.0 - cos;
    let across = x * y * versine;
    Matrix3::new(
        cos + x * x * versine,
        across,
        y * sin,
        across,
        cos + y * y * versine,
        -x * sin,
        -y * sin,
        x * sin,
        cos,
    )
}

#[cfg(test)]
mod tests {
    use nalgebra::Vector2;

    use super::*;
    use crate::pattern::{Drawing, DrawnEdge, Letter};

    /// A cross folds along one line, while the hinges of the other line stay flat and have the same weights as
    /// those of the first.
    #[test]
    fn weights_that_nearly_vanish_are_bounded() {
        let places = [[0.0, 0.0], [1.0, 0.0], [0.0, 1.0], [-1.0, 0.0], [0.0, -1.0]];
        let rim = (1..=4).map(|k| ([k, k % 4 + 1], Letter::Boundary));
        let spokes = (1..=4).map(|k| ([0, k], Letter::Valley));
        let edges = rim.chain(spokes).map(|(ends, letter)| DrawnEdge {
            ends,
            letter,
            goal: None,
        });
        let drawing = Drawing {
            vertices: places.map(Vector2::from).to_vec(),
            edges: edges.collect(),
            ..Drawing::default()
        };
        let pattern = CreasePattern::new(drawing).unwrap();
        let stars = ReducedStars::of_creases(&pattern);
        let [moving, still] = [[0.0, 0.55, 1.0, 1.0], [0.0; 4]].map(|sin| Curve::HalfAngle {
            cos: [1.0, 1.0, 0.5, 0.002],
            sin,
        });
        for effort in [Effort::ROUGH, Effort::FINE] {
            let (segment, _) = certify(
                &pattern,
                &stars,
                &[moving, still, moving, still],
                &effort,
                1e-3,
            );
            assert!(segment.bound <= 2e-11, "{segment:?}");
            // This says nothing about a whole sheet.
            assert!(segment.error().is_infinite(), "{segment:?}");
        }
        // One hinge of the line turns differently from the other: hopeless, and soon known.
        let (segment, _) = certify(
            &pattern,
            &stars,
            &[moving, still, still, still],
            &Effort::ROUGH,
            1e3,
        );
        assert!(segment.bound >= 1.0, "{segment:?}");
        assert!(segment.samples <= 24 * 600, "{segment:?}");
    }
}
