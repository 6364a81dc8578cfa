//! Bounds deformation, gap and twist of the whole sheet over a segment by folding the sheet at Chebyshev points.
//!
//! A face is rotated by the product of the quaternions of the creases on its path from the root of the spanning tree,
//! and its corners are sums of the lengths on that path, rotated by these products. As in [`closure`](super::closure)
//! these are analytic functions, and the logarithms of their norms on ellipses add up along the path. So are the three
//! errors that are bounded: the distance between the positions that two faces give a vertex, the error of the square of
//! an edge's length, and the vector part of the rotation by which two faces at an edge are off its fold angle. Bounds
//! on single vertices (`sheet.rs`) have to add up, although errors of one vertex may cancel those of another; the
//! bounds here are on the sum.

use core::time::Duration;

use foldpath_core::{Curve, Membership};

use super::bernstein::Piece;
use super::chebyshev::{Points, RADII, Radius, radii};
use super::{LOOSE_RATIO, MAX_HALVINGS, Part, ROUNDING_FACTOR};
use crate::folding::{FoldingMap, Rigidity, SpanningTree, Step, rounding};
use crate::pattern::CreasePattern;
use crate::util::parallel;

/// About the time that folding and measuring the sheet at all points takes for each of its faces.
const TIME_PER_FACE: Duration = Duration::from_micros(3);

/// Polynomial error that is always small enough where the number of points is chosen.
const MAX_POLYNOMIAL_ERROR_RATIO: f64 = 1e-13;
/// Polynomial error that is small enough, as a fraction of the bound that is enough.
const POLYNOMIAL_ERROR_RATIO: f64 = 0.01;
/// Rounding of a half angle that [`rounding`] allows for, 16 ε.
const HALF_ANGLE_ROUNDING_RAD: f64 = 16.0 * f64::EPSILON;

/// For gap, deformation and twist: ln M on the ellipses, and the power of the faces' weights that values are multiplied
/// by.
type Growth = [([f64; RADII], f64); 3];

/// Bounds deformation, gap and twist of a whole sheet, as [`FoldingMap::rigidity`] measures them.
///
/// The sheet is folded along four spanning trees: from its middle and from its rim, along rows or columns of its faces.
/// A sheet that does not close is torn elsewhere by each of them. The bounds are proved for these trees, and nothing is
/// claimed for others.
#[derive(Clone, Debug)]
pub struct FoldingCertifier<'a>([Folded<'a>; 4]);

impl<'a> FoldingCertifier<'a> {
    /// Makes the certifier of a sheet whose creases turn as the groups of `memberships`. Cost: linear.
    #[must_use]
    pub fn new(pattern: &'a CreasePattern, memberships: &'a [Membership]) -> Self {
        let trees = SpanningTree::diverse(pattern);
        Self(trees.map(|tree| Folded::new(pattern, tree, memberships)))
    }

    /// Returns bounds over a segment that are at most `most`; `None` if they would be larger, or nothing can be
    /// bounded, as for curves that are not finite. Bounds below half of `most` are not refined.
    ///
    /// Cost: the sheet is folded 9 to 49 times along each tree for each part into which the segment is halved: 1 part
    /// if no path from the root to a face turns by more than some ten radians in all, at most 256.
    pub fn rigidity(&mut self, curves: &[Curve<f64>], most: f64) -> Option<Rigidity> {
        let each = parallel::total_time(self.0[0].sums.len(), TIME_PER_FACE);
        let bounds =
            parallel::try_map_mut(&mut self.0, each, |folded| folded.rigidity(curves, most))?;
        let bounds = bounds.into_iter();
        Some(bounds.fold(Rigidity::default(), Rigidity::worse))
    }
}

/// A sheet folded along one spanning tree.
#[derive(Clone, Debug)]
struct Folded<'a> {
    pattern: &'a CreasePattern,
    tree: SpanningTree,
    memberships: &'a [Membership],
    map: FoldingMap,
    rounding: Rigidity,
    /// Longest way from the root to a corner, as [`SpanningTree::reach`] has it.
    reach: f64,
    /// Length of the shortest edge or diagonal.
    shortest: f64,
    radii: [Radius; RADII],
    points: [Points; 6],
    pieces: Vec<Piece>,
    angles: Vec<f64>,
    weights: Vec<f64>,
    /// For each face, the sum of the creases' growths along its path from the root.
    growths: Vec<[f64; RADII]>,
    /// For each face, the sum of the logarithms of the creases' weights along its path from the root.
    sums: Vec<f64>,
    /// Factor on the bounds of [`rounding`].
    coarse: f64,
}

impl<'a> Folded<'a> {
    fn new(pattern: &'a CreasePattern, tree: SpanningTree, memberships: &'a [Membership]) -> Self {
        let lengths = pattern.struts().map(|ends| pattern.length(ends));
        Self {
            reach: tree.reach(pattern),
            shortest: lengths.fold(f64::INFINITY, f64::min),
            map: FoldingMap::flat(pattern),
            rounding: rounding(pattern, &tree),
            radii: radii(),
            points: Points::all(),
            pieces: Vec::new(),
            angles: Vec::new(),
            weights: Vec::new(),
            growths: vec![[0.0; RADII]; tree.faces()],
            sums: vec![0.0; tree.faces()],
            coarse: ROUNDING_FACTOR,
            pattern,
            tree,
            memberships,
        }
    }

    fn rigidity(&mut self, curves: &[Curve<f64>], most: f64) -> Option<Rigidity> {
        let enough = most / 2.0;
        let mut open = vec![Part::default()];
        let (mut seen, mut worst) = (Rigidity::default(), Rigidity::default());
        while let Some(part) = open.pop() {
            let growth = self.prepare(curves, part.ends());
            let serves = |points: &Points| {
                let mut errors = growth.iter().map(|(g, _)| points.error(&self.radii, g));
                errors.all(|error| {
                    error <= MAX_POLYNOMIAL_ERROR_RATIO.max(POLYNOMIAL_ERROR_RATIO * enough)
                })
            };
            let points = self.points.iter().position(serves);
            let last = part.depth == MAX_HALVINGS;
            if let Some(points) = points.or(last.then_some(self.points.len() - 1)) {
                let bound = self.bound(curves, part.ends(), points, &growth, &mut seen);
                let within = |found: Rigidity| found.worst() <= most;
                if !within(seen) || last && !within(bound) {
                    return None;
                }
                if last || bound.worst() <= enough || self.is_tight(bound, seen) {
                    worst = worst.worse(bound);
                    continue;
                }
            }
            open.extend(part.halves());
        }
        (worst.worst() <= most).then_some(worst)
    }

    /// Bounds the growth of the three errors over a part without folding the sheet.
    fn prepare(&mut self, curves: &[Curve<f64>], part: [f64; 2]) -> Growth {
        let piece = |curve| Piece::new(curve, part, &self.radii);
        self.pieces.clear();
        self.pieces.extend(curves.iter().map(piece));
        let mut pieces = self.pieces.iter();
        let known = pieces.all(|p| p.least > 0.0 && p.growth.iter().all(|g| !g.is_nan()));
        let roundings = self
            .pieces
            .iter()
            .map(|piece| piece.rounding / HALF_ANGLE_ROUNDING_RAD);
        self.coarse = roundings.fold(ROUNDING_FACTOR, |most, times| {
            most.max(ROUNDING_FACTOR * times)
        });
        let add = |a: [f64; RADII], b: [f64; RADII]| core::array::from_fn(|k| a[k] + b[k]);
        let larger = |a: [f64; RADII], b: [f64; RADII]| core::array::from_fn(|k| a[k].max(b[k]));
        let mut growths = core::mem::take(&mut self.growths);
        let turned = |step: &Step| {
            let piece = self.piece_of(step).map(|group| self.pieces[group].growth);
            piece.unwrap_or_default()
        };
        for step in self.tree.steps() {
            growths[step.face.index()] = add(growths[step.parent.index()], turned(step));
        }
        let face = growths.iter().copied().fold([0.0; RADII], larger);
        let across = self.tree.loops().iter().map(|step| {
            let ends = [step.face, step.parent].map(|face| growths[face.index()]);
            add(add(ends[0], ends[1]), turned(step))
        });
        let across = across.fold([0.0; RADII], larger);
        self.growths = growths;
        // If curves have weights, all positions are brought to a common denominator.
        let weighted = |curve: &Curve<f64>| matches!(curve, Curve::HalfAngle { .. });
        let weights = if curves.iter().any(weighted) {
            4.0
        } else {
            2.0
        };
        let median = self.pattern.median_edge();
        let of = |length: f64, times: f64| {
            let growth = face.map(|growth| length.ln() + times * growth);
            growth.map(|growth| if known { growth } else { f64::INFINITY })
        };
        let squares = 1.0 + (2.0 * self.reach / self.shortest).powi(2);
        [
            (of(2.0 * self.reach / median, weights), 4.0),
            (of(squares, 2.0 * weights), 8.0),
            (
                across.map(|growth| if known { growth } else { f64::INFINITY }),
                3.0,
            ),
        ]
    }

    /// Returns the group of the crease that a step crosses, or without groups the crease's own number, if it turns.
    fn piece_of(&self, step: &Step) -> Option<usize> {
        let crease = step.crease?.index();
        let group = self.memberships.get(crease).map(|of| of.group.index());
        let group = group.unwrap_or(crease);
        (group < self.pieces.len()).then_some(group)
    }

    /// Bounds the errors over a part from their values at the set of points of index `points`. `seen` takes in the
    /// largest values.
    fn bound(
        &mut self,
        curves: &[Curve<f64>],
        [from, to]: [f64; 2],
        points: usize,
        growth: &Growth,
        seen: &mut Rigidity,
    ) -> Rigidity {
        let mut largest = [0.0_f64; 3];
        for at in 0..self.points[points].at.len() {
            let s = from + (to - from) * self.points[points].at[at];
            self.angles.clear();
            self.angles
                .extend(curves.iter().map(|curve| curve.angle(s)));
            let (pattern, tree) = (self.pattern, &self.tree);
            self.map
                .fold_groups(pattern, tree, self.memberships, &self.angles);
            let found = self.map.rigidity(pattern, tree);
            *seen = seen.worse(found);
            let weight = self.weight(curves, s);
            let values = self.values(found);
            for ((largest, value), (_, times)) in largest.iter_mut().zip(values).zip(growth) {
                let weighted = value * (times * weight).exp();
                *largest = if weighted.is_nan() {
                    f64::INFINITY
                } else {
                    largest.max(weighted)
                };
            }
        }
        let mut bounds = growth.iter().zip(largest);
        let mut next = || {
            let bound = bounds.next().map(|((growth, _), largest)| {
                self.points[points].bound(&self.radii, growth, largest)
            });
            bound.unwrap_or(f64::INFINITY)
        };
        let (gap, square, turn) = (next(), next(), next());
        Rigidity {
            gap,
            deformation: if square < 1.0 {
                1.0 - (1.0 - square).sqrt()
            } else {
                square
            },
            twist: 2.0 * turn,
        }
    }

    /// Returns the values of the three analytic functions for a sheet with these measured errors, rounding included.
    fn values(&self, found: Rigidity) -> [f64; 3] {
        let deformation = found.deformation + self.coarse * self.rounding.deformation;
        [
            found.gap + self.coarse * self.rounding.gap,
            deformation * (2.0 + deformation),
            (found.twist + self.coarse * self.rounding.twist) / 2.0,
        ]
    }

    /// Returns the largest sum, along the path to a face or for one crease alone, of the logarithms of weights over
    /// their lower bounds.
    fn weight(&mut self, curves: &[Curve<f64>], s: f64) -> f64 {
        self.weights.clear();
        let pairs = self.pieces.iter().zip(curves);
        self.weights
            .extend(pairs.map(|(piece, curve)| piece.sample(curve, s).1.ln()));
        let one = self.weights.iter().copied().fold(0.0, f64::max);
        if one <= 0.0 {
            return 0.0;
        }
        for step in self.tree.steps() {
            let turned = self.piece_of(step).map_or(0.0, |group| self.weights[group]);
            self.sums[step.face.index()] = self.sums[step.parent.index()] + turned;
        }
        self.sums.iter().copied().fold(one, f64::max)
    }

    /// Returns `true` if every bound is near the largest error seen in the segment.
    fn is_tight(&self, bound: Rigidity, seen: Rigidity) -> bool {
        let tight = |bound: f64, seen: f64, rounding: f64| {
            bound <= LOOSE_RATIO * (seen + self.coarse * rounding) + MAX_POLYNOMIAL_ERROR_RATIO
        };
        tight(bound.gap, seen.gap, self.rounding.gap)
            && tight(
                bound.deformation,
                seen.deformation,
                self.rounding.deformation,
            )
            && tight(bound.twist, seen.twist, self.rounding.twist)
    }
}
