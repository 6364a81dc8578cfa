//! Rings: the part of a net that people close first, as the tube of a carton before its lids.
//!
//! Parallel creases close a ring if, folded alone, they bring a border of the sheet to another edge that lies apart from
//! it in the flat sheet: the two borders of a sleeve, or a border and the crease of a glue flap. The flaps that hang on the ring
//! close its openings. A crease beyond another one there, as that of a tuck on a lid, may have to turn past its goal, so that the
//! tuck clears the ring while the lid turns, and then return.

use core::cmp::Reverse;
use core::f64::consts::PI;

use fixedbitset::FixedBitSet;
use nalgebra::Vector3;

use super::stops::{Leg, between, set};
use crate::folding::FoldingMap;
use crate::pattern::{CreasePattern, EdgeId};
use crate::planner::PlanOptions;
use crate::planner::following::reduction::CLOSED;

/// Largest sine of the angle between two creases that count as parallel.
const PARALLEL_RATIO: f64 = 1e-3;
/// Largest distance at which two edges meet, over the length of the border that is one of them. Flaps of die-lines are set
/// back by the thickness of the board.
const MEETS_RATIO: f64 = 0.05;
/// Least length of a border that closes a ring, over the longest crease of the ring. Rounded corners have short borders.
const BORDER_RATIO: f64 = 0.5;

/// The creases of a net, by what they do for its rings.
pub(super) struct Rings {
    /// The creases that close rings.
    pub(super) body: FixedBitSet,
    /// Creases of flaps on which nothing else turns.
    flaps: FixedBitSet,
    /// Creases of flaps on which others turn.
    lids: FixedBitSet,
    /// Creases beyond those of lids.
    pub(super) outer: FixedBitSet,
}

impl Rings {
    /// Finds the rings that creases close on a leg of a sheet whose hinges turn freely, those that close best first. Leaves
    /// out rings beside which nothing turns.
    pub(super) fn of(pattern: &CreasePattern, leg: &Leg) -> Vec<Self> {
        let mut left = leg.turned_creases();
        let mut bodies = Vec::new();
        while let Some(first) = left.ones().next() {
            let class = parallel(pattern, &left, first);
            left.difference_with(&class);
            bodies.extend(ring(pattern, leg, &class));
        }
        bodies.sort_by_key(|(gap, body)| (*gap, Reverse(body.count_ones(..))));
        let bodies = bodies.into_iter();
        bodies
            .filter_map(|(_, body)| Self::with_body(pattern, leg, body))
            .collect()
    }

    /// Tells the creases beside a ring apart. Returns `None` if there are none.
    fn with_body(pattern: &CreasePattern, leg: &Leg, body: FixedBitSet) -> Option<Self> {
        let turned = leg.turned_creases();
        let first = body.ones().next().filter(|_| body != turned)?;
        let first_face = pattern.edge(pattern.creases()[first]).faces[0]?;
        let [mut flaps, mut lids, mut outer] = [(); 3].map(|()| set(&leg.end, []));
        for crease in turned.difference(&body) {
            let edge = pattern.edge(pattern.creases()[crease]);
            let ways = edge.faces.into_iter().flatten();
            let ways = ways.map(|face| between(pattern, [first_face, face]));
            let beyond = ways.max_by_key(|way| way.count_ones(..));
            let mut before = &beyond.unwrap_or_default() & &turned;
            before.difference_with(&body);
            before.remove(crease);
            if before.is_clear() {
                flaps.insert(crease);
            } else {
                outer.insert(crease);
                lids.union_with(&before);
            }
        }
        lids.difference_with(&outer);
        flaps.difference_with(&lids);
        Some(Self {
            body,
            flaps,
            lids,
            outer,
        })
    }

    /// Returns phases in which people close a carton: the rings, flaps on which nothing turns, what is at the ends of lids,
    /// and lids.
    pub(super) fn phases(&self) -> Vec<FixedBitSet> {
        let phases = [&self.body, &self.flaps, &self.outer, &self.lids];
        let phases = phases.into_iter().filter(|phase| !phase.is_clear());
        phases.cloned().collect()
    }

    /// Returns the fold angles (radians) at the end of a leg if the creases beyond others turn past it by an angle, as far as
    /// their limits allow.
    pub(super) fn past(&self, leg: &Leg, by_rad: f64, options: &PlanOptions) -> Vec<f64> {
        let mut angles = leg.end.clone();
        for crease in self.outer.ones() {
            let limits = options.limits.iter();
            let limits = limits.filter(|limit| limit.crease.index() == crease);
            let (lower, upper) = limits.fold((-PI, PI), |(lower, upper), limit| {
                (limit.lower.max(lower), limit.upper.min(upper))
            });
            let past = leg.end[crease] + by_rad.copysign(leg.turn(crease));
            angles[crease] = past.min(upper).max(lower);
        }
        angles
    }
}

/// Returns those of some creases that are parallel to one of them.
fn parallel(pattern: &CreasePattern, creases: &FixedBitSet, to: usize) -> FixedBitSet {
    let is_parallel = |&crease: &usize| {
        let creases = pattern.creases();
        are_parallel(pattern, creases[crease], creases[to])
    };
    set(pattern.creases(), creases.ones().filter(is_parallel))
}

fn are_parallel(pattern: &CreasePattern, a: EdgeId, b: EdgeId) -> bool {
    let [u, v] = [a, b].map(|edge| pattern.direction(edge, pattern.edge(edge).ends[0]));
    u.perp(&v).abs() <= PARALLEL_RATIO
}

/// Returns the creases of the rings that some parallel creases close if they fold alone, and the least distance at which
/// edges meet there, in thousandths of the length of the border that is one of them.
fn ring(pattern: &CreasePattern, leg: &Leg, class: &FixedBitSet) -> Option<(u64, FixedBitSet)> {
    let creases = || class.ones().map(|crease| pattern.creases()[crease]);
    let length = |edge: EdgeId| pattern.length(pattern.edge(edge).ends);
    let longest = creases().map(length).fold(0.0, f64::max);
    let along = creases().next()?;
    let edges = (0..).map(EdgeId).take(pattern.edges().len());
    let edges: Vec<EdgeId> = edges
        .filter(|&edge| {
            length(edge) >= BORDER_RATIO * longest && are_parallel(pattern, edge, along)
        })
        .collect();
    let angles = leg.angles(class);
    let bent = angles
        .iter()
        .enumerate()
        .filter(|(_, angle)| angle.abs() > CLOSED);
    let bent = set(&leg.end, bent.map(|(crease, _)| crease));
    let folded = FoldingMap::new(pattern, pattern.tree(), &angles);
    let flat = FoldingMap::flat(pattern);
    let borders = edges
        .iter()
        .filter(|&&edge| pattern.edge(edge).inner_faces().is_none());
    let pairs = borders.flat_map(|border| edges.iter().map(move |other| [*border, *other]));
    let mut ring = set(&leg.end, []);
    let mut least = f64::INFINITY;
    for pair in pairs {
        if least == 0.0 && ring == *class {
            break;
        }
        let [gap, apart] = [&folded, &flat].map(|map| gap(pattern, map, pair) / length(pair[0]));
        if gap <= MEETS_RATIO && apart > MEETS_RATIO {
            let [own, others] = pair.map(|edge| pattern.edge(edge).faces.into_iter().flatten());
            let ways = own.flat_map(|own| others.clone().map(move |other| [own, other]));
            let mut way = set(&leg.end, []);
            ways.for_each(|faces| way.union_with(&between(pattern, faces)));
            way.intersect_with(&bent);
            // A single crease closes nothing, and what was folded before took part in a ring with other creases.
            if way.is_subset(class) && way.count_ones(..) > 1 {
                least = least.min(gap);
                ring.union_with(&way);
            }
        }
    }
    #[allow(
        clippy::cast_possible_truncation,
        clippy::cast_sign_loss,
        reason = "at most 50"
    )]
    (!ring.is_clear()).then(|| ((1e3 * least).round() as u64, ring))
}

/// Returns the largest distance of the middle of one of two edges from the other edge.
fn gap(pattern: &CreasePattern, map: &FoldingMap, edges: [EdgeId; 2]) -> f64 {
    let [a, b] = edges.map(|edge| pattern.edge(edge).ends.map(|end| map.vertex(end)));
    let middle = |[from, to]: [Vector3<f64>; 2]| (from + to) / 2.0;
    distance(middle(a), b).max(distance(middle(b), a))
}

/// Returns the distance of a point from a line segment.
fn distance(point: Vector3<f64>, [a, b]: [Vector3<f64>; 2]) -> f64 {
    let (way, to) = (b - a, point - a);
    let part = (way.dot(&to) / way.norm_squared()).clamp(0.0, 1.0);
    (to - part * way).norm()
}
