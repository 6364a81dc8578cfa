//! Bounds on the errors of the whole sheet over a segment, from folding it at some points.
//!
//! A face is turned by the product of the quaternions of the creases on its way from the root, and its corners lie
//! where these take the lengths of that way. As in [`closure`](super::closure) all this is analytic, of a norm on
//! ellipses that adds up along the way; and so are what two faces miss each other by at a vertex, how much the square
//! of an edge's length is off, and the vector part of what two faces at an edge are off its fold angle. Bounds on vertices
//! know nothing of how errors of one undo those of another; this is what they add up to.

use foldpath_core::{Curve, Membership};

use super::bernstein::Piece;
use super::chebyshev::{Points, RADII, Radius, radii};
use crate::folding::{FoldingMap, Rigidity, SpanningTree, Step, rounding};
use crate::pattern::CreasePattern;

/// The error of the polynomials where it can be had, and as a part of what is enough.
const ERROR: f64 = 1e-13;
const PART: f64 = 0.01;
/// A part of the segment is halved while a bound is this many times what was seen in the segment.
const LOOSE: f64 = 1.5;
/// Parts are no shorter than 2^-8 of the segment.
const HALVINGS: u8 = 8;
/// Rounding counts twice: in the values here, and for those who evaluate the same motion.
const TWICE: f64 = 2.0;
/// Roundings of a half angle, in ε, that [`rounding`] allows.
const HALF_ANGLE: f64 = 16.0 * f64::EPSILON;
/// By how much more than along four trees a sheet may be torn along others, which no proof knows.
const OTHER_TREES: f64 = 2.0;

/// Gap, deformation and twist: each with ln M on the ellipses, and how many weights of faces it is to be multiplied by.
type Growth = [([f64; RADII], f64); 3];

/// Bounds deformation, gap and twist of a whole sheet, as [`FoldingMap::rigidity`] measures them where it is folded from
/// its middle and from its rim, along rows or columns of its faces: one that does not close is torn elsewhere each time.
/// Gives twice what is proved of these, for others.
#[derive(Clone, Debug)]
pub struct FoldingCertifier<'a>([Folded<'a>; 4]);

impl<'a> FoldingCertifier<'a> {
    /// Of a sheet whose creases turn as the groups of `memberships`. Cost: linear.
    #[must_use]
    pub fn new(pattern: &'a CreasePattern, memberships: &'a [Membership]) -> Self {
        let trees = SpanningTree::diverse(pattern);
        Self(trees.map(|tree| Folded::new(pattern, tree, memberships)))
    }

    /// Bounds over a segment that are no more than `most`; `None` if they are, or nothing can be said, as of curves that
    /// are not finite. Those below half of it are not made finer.
    ///
    /// Cost: the sheet is folded 9 to 49 times each way, times the number of parts that the segment is halved
    /// into: 1 where no way from the root to a face turns by more than some ten radians in all, at most 256.
    pub fn rigidity(&mut self, curves: &[Curve<f64>], most: f64) -> Option<Rigidity> {
        let most = most / OTHER_TREES;
        let worse = |worst: Rigidity, folded: &mut Folded<'_>| {
            Some(worst.worse(folded.rigidity(curves, most)?))
        };
        let worst = self.0.iter_mut().try_fold(Rigidity::default(), worse)?;
        Some(Rigidity {
            deformation: OTHER_TREES * worst.deformation,
            gap: OTHER_TREES * worst.gap,
            twist: OTHER_TREES * worst.twist,
        })
    }
}

/// A sheet folded from one face.
#[derive(Clone, Debug)]
struct Folded<'a> {
    pattern: &'a CreasePattern,
    tree: SpanningTree,
    memberships: &'a [Membership],
    map: FoldingMap,
    rounding: Rigidity,
    /// As of [`SpanningTree::reach`], and the shortest distance that panels hold.
    reach: f64,
    shortest: f64,
    radii: [Radius; RADII],
    points: [Points; 6],
    pieces: Vec<Piece>,
    angles: Vec<f64>,
    weights: Vec<f64>,
    /// For each face the sum along its way.
    growths: Vec<[f64; RADII]>,
    sums: Vec<f64>,
    /// How often rounding counts.
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
            coarse: TWICE,
            pattern,
            tree,
            memberships,
        }
    }

    fn rigidity(&mut self, curves: &[Curve<f64>], most: f64) -> Option<Rigidity> {
        let enough = most / 2.0;
        let mut open = vec![(0_u8, 0_u32)];
        let (mut seen, mut worst) = (Rigidity::default(), Rigidity::default());
        while let Some((depth, index)) = open.pop() {
            let length = 1.0 / f64::from(1_u32 << depth);
            let part = [f64::from(index), f64::from(index + 1)].map(|end| end * length);
            let growth = self.prepare(curves, part);
            let serves = |points: &Points| {
                let mut errors = growth.iter().map(|(g, _)| points.error(&self.radii, g));
                errors.all(|error| error <= ERROR.max(PART * enough))
            };
            let points = self.points.iter().position(serves);
            let last = depth == HALVINGS;
            if let Some(points) = points.or(last.then_some(self.points.len() - 1)) {
                let bound = self.bound(curves, part, points, &growth, &mut seen);
                let within = |found: Rigidity| found.worst() <= most;
                if !within(seen) || last && !within(bound) {
                    return None;
                }
                if last || bound.worst() <= enough || self.is_tight(bound, seen) {
                    worst = worst.worse(bound);
                    continue;
                }
            }
            open.extend([(depth + 1, 2 * index + 1), (depth + 1, 2 * index)]);
        }
        (worst.worst() <= most).then_some(worst)
    }

    /// What is known of a part without folding the sheet.
    fn prepare(&mut self, curves: &[Curve<f64>], part: [f64; 2]) -> Growth {
        let piece = |curve| Piece::new(curve, part, &self.radii);
        self.pieces.clear();
        self.pieces.extend(curves.iter().map(piece));
        let mut pieces = self.pieces.iter();
        let known = pieces.all(|p| p.least > 0.0 && p.growth.iter().all(|g| !g.is_nan()));
        let roundings = self.pieces.iter().map(|piece| piece.rounding / HALF_ANGLE);
        self.coarse = roundings.fold(TWICE, |most, times| most.max(TWICE * times));
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
        // Where curves have weights, all places are made multiples of the same.
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

    /// The group of the crease that a step crosses, or the crease's own number, if it turns.
    fn piece_of(&self, step: &Step) -> Option<usize> {
        let crease = step.crease?.index();
        let group = self.memberships.get(crease).map(|of| of.group.index());
        let group = group.unwrap_or(crease);
        (group < self.pieces.len()).then_some(group)
    }

    /// Bounds over a part, from as many points; notes the most that is seen there.
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

    /// What a sheet may have for values of the functions, if this is measured of it.
    fn values(&self, found: Rigidity) -> [f64; 3] {
        let deformation = found.deformation + self.coarse * self.rounding.deformation;
        [
            found.gap + self.coarse * self.rounding.gap,
            deformation * (2.0 + deformation),
            (found.twist + self.coarse * self.rounding.twist) / 2.0,
        ]
    }

    /// The largest sum along the way to a face, or across one more crease, of the logarithms of weights over their least.
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

    /// Whether every bound is near what was seen in the segment.
    fn is_tight(&self, bound: Rigidity, seen: Rigidity) -> bool {
        let tight = |bound: f64, seen: f64, rounding: f64| {
            bound <= LOOSE * (seen + self.coarse * rounding) + ERROR
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
