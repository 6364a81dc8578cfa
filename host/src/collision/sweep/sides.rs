//! Queries of pieces that share a side off the spanning tree, where the sheet may be torn.

use core::f64::consts::{FRAC_PI_2, PI};

use foldpath_core::Membership;
use nalgebra::Vector3;

use super::queue::{Kind, Pair};
use super::{QueryOutcome, Sweep};
use crate::collision::sides::{LEAN_TO_TURN_RATIO, Side};
use crate::collision::tolerances::{HINGE_TEAR_RATIO, MIN_OPENING_RATIO};
use crate::pattern::EdgeId;

/// Bound on the tear between two pieces that share a side.
#[derive(Clone, Copy, Debug)]
struct SideTear {
    /// Group and sign of the crease at the side; `None` if the edge stays flat.
    member: Option<Membership>,
    /// Angle, radians.
    turn: f64,
    /// Distance by which a point of the smaller piece may be moved, units of the sheet.
    moved: f64,
}

impl Sweep<'_> {
    /// Returns the kind of a pair of pieces that share several vertices; `None` if it needs no query, because the pieces
    /// turn about their common side but for a tear that contact allows.
    pub(super) fn classify_side(&mut self, nodes: [u32; 2], shared: &[[u32; 2]]) -> Option<Kind> {
        let allowed = self.contact.of(&self.sheet.pieces, nodes, 0.0).largest();
        let is_within = |tear: SideTear| tear.moved <= allowed;
        // No point of a piece is farther from its side than the piece is wide, which is known at once.
        let circles = nodes.map(|node| self.sheet.hierarchy.circles[node as usize]);
        let widest = 2.0 * circles[0].1.min(circles[1].1);
        if !self.side_tear(nodes, widest).is_some_and(is_within) {
            let side = Side::of(&self.sheet.pieces, nodes, shared)?;
            if !self.side_tear(nodes, side.reach).is_some_and(is_within) {
                return Some(Kind::Side(side));
            }
        }
        self.found.joined += 1;
        (!self.options.skip_edges).then_some(Kind::Joined)
    }

    /// Returns `true` if two solids turn about their common edge, each on its side of the plane that halves the angle between
    /// them, but for a tear that contact allows.
    pub(super) fn keeps_back(&mut self, nodes: [u32; 2]) -> bool {
        let allowed = self.contact.of(&self.sheet.pieces, nodes, 0.0).largest();
        let circles = nodes.map(|node| self.sheet.hierarchy.circles[node as usize]);
        let widest = 2.0 * circles[0].1.min(circles[1].1);
        let kept = self.sheet.pieces.keeps_back(self.pattern, nodes);
        let moved = kept.map(|(hinge, inside)| {
            let edges = inside.into_iter().chain([hinge]);
            edges
                .map(|edge| self.tear_at(edge, widest).moved)
                .sum::<f64>()
        });
        let thin = HINGE_TEAR_RATIO * self.sheet.pieces.thickness();
        let keeps_back = moved.is_some_and(|moved| moved <= allowed.max(thin));
        self.found.joined += u64::from(keeps_back);
        keeps_back
    }

    /// Returns the least bound on the tear at an edge that joins two pieces, of which one reaches no farther from it than
    /// `reach`; `None` if no edge joins them, as on the two
    /// sides of a slit.
    fn side_tear(&self, nodes: [u32; 2], reach: f64) -> Option<SideTear> {
        let [face, other] = self.sheet.faces(nodes);
        let neighbours = self.pattern.neighbours()[face.index()].iter();
        let edges = neighbours.filter(|(beyond, _)| *beyond == other);
        let tears = edges.map(|&(_, edge)| self.tear_at(edge, reach));
        tears.min_by(|a, b| a.moved.total_cmp(&b.moved))
    }

    /// Returns the bound on the tear at an edge between two pieces, of which one reaches no farther from it than `reach`.
    fn tear_at(&self, edge: EdgeId, reach: f64) -> SideTear {
        let [turn, shift] = if self.along_lattice {
            [self.turn, self.deviation]
        } else {
            self.approach.chains.ways.tear(edge)
        };
        let crease = self.pattern.edge(edge).crease;
        SideTear {
            member: crease.and_then(|crease| self.memberships.get(crease.index()).copied()),
            turn,
            moved: turn * reach + shift,
        }
    }

    pub(super) fn query_side(&mut self, index: u32, pair: &Pair, side: &Side) -> QueryOutcome {
        let nodes = pair.nodes;
        let tear = self.side_tear(nodes, side.reach);
        if let Some(outcome) = tear.and_then(|tear| self.open_until(side, &tear)) {
            return outcome;
        }
        // Along a lattice nothing more is known of the tear.
        if self.along_lattice {
            return QueryOutcome::Undecided;
        }
        self.found.counts.tested += 1;
        self.sheet.put(nodes);
        if self.is_split(pair) {
            return QueryOutcome::Undecided;
        }
        let member = tear.and_then(|tear| tear.member);
        let pair = Pair {
            above: self.above(pair, member),
            ..pair.clone()
        };
        self.queue[index].above = pair.above;
        if let Some(depth) = self.crosses(index, &pair, 0.0) {
            return QueryOutcome::Crossing(depth);
        }
        if let Some(until) = self.comoving_until(nodes) {
            return self.next(until, 0.0, false);
        }
        // Across the side little may turn, but it is torn; along the tree nothing is torn.
        let chains = [
            self.approach.chain(&self.sheet, &mut self.queue[index]),
            self.approach
                .along_tree(&self.sheet, &mut self.queue[index]),
        ];
        let placed = self.sheet.placed();
        // While the creases between turn by an angle, the tear grows and the lean shrinks by that angle at most.
        let spare = side.lean(&placed, nodes) - LEAN_TO_TURN_RATIO * side.turn(&placed);
        let spare = spare / (1.0 + LEAN_TO_TURN_RATIO);
        let allowed = self.allowed(&pair);
        let room = self.left_of(allowed, nodes, 0.0);
        let mut outcome = QueryOutcome::Until(self.sheet.time);
        for chain in chains {
            self.approach.gather_turns(&chain);
            let by_turn = self.after(0.0, spare - 2.0 * chain.turn, false);
            self.approach.gather_corners(&mut self.sheet, &chain, nodes);
            let by_depth = self.after(0.0, room - 2.0 * chain.tear, false);
            outcome = later(outcome, later(by_turn, by_depth));
        }
        self.at_contact(index, allowed, [0.0, room], outcome)
    }

    /// Returns the next query of two pieces whose tear has a bound, while the fold angle between them leaves them free.
    /// Returns `None` if it does not, or hardly.
    fn open_until(&mut self, side: &Side, tear: &SideTear) -> Option<QueryOutcome> {
        let opening = side.least_opening(tear.turn)?;
        let Some(member) = tear.member else {
            return Some(QueryOutcome::Free);
        };
        let room = PI - opening - self.angle(member).abs();
        if room <= MIN_OPENING_RATIO * opening {
            return None;
        }
        let levers = &mut self.approach.levers;
        levers.clear();
        levers.add(member.group.0, 1.0);
        Some(self.after(0.0, room, false))
    }

    /// Returns the fold angle of a crease at the current time, radians.
    fn angle(&self, member: Membership) -> f64 {
        let motion = &self.sheet.motion;
        let angle = motion.angle(member.group.index(), self.sheet.time);
        if member.negative { -angle } else { angle }
    }

    /// Returns from which sides two placed pieces came that are folded onto each other by more than a quarter turn: `true`
    /// if the second is above the first, and if the first is above the second. The crease between them tells or, if there
    /// is none, what was known before.
    fn above(&self, pair: &Pair, member: Option<Membership>) -> Option<[bool; 2]> {
        if let Some(member) = member {
            let angle = self.angle(member);
            return (angle.abs() > FRAC_PI_2).then_some([angle > 0.0; 2]);
        }
        let placed = self.sheet.placed();
        let [a, b] = pair.nodes.map(|node| placed.piece(node));
        let height = |corner: &Vector3<f64>| a.normal.dot(&(corner - a.corners[0]));
        let is_above = b.corners.iter().map(height).sum::<f64>() > 0.0;
        let is_folded = a.normal.dot(&b.normal) < 0.0;
        is_folded.then(|| pair.above.unwrap_or([is_above; 2]))
    }
}

/// Returns the outcome by which a pair is free for longer.
fn later(a: QueryOutcome, b: QueryOutcome) -> QueryOutcome {
    match (&a, &b) {
        (QueryOutcome::Until(first), QueryOutcome::Until(second)) if first < second => b,
        (QueryOutcome::Until(_), QueryOutcome::Free) => b,
        _ => a,
    }
}
