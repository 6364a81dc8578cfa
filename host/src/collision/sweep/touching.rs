//! Pieces in contact: whether they cross, from which sides they came, and how long a plane keeps them apart.

use super::chains::Chain;
use super::motion::Tick;
use super::queue::{Kind, Pair};
use super::{QueryOutcome, Sweep};
use crate::collision::narrow::crossing::Allowed;
use crate::collision::narrow::layers::heights;
use crate::collision::narrow::planes::{Change, Moved, Parted, Turn, parted, parted_by};
use crate::collision::narrow::side_planes::SidePlanes;
use crate::collision::tolerances::{
    KEPT_RATIO, MAX_TEAR_RATIO, PLANES_AFTER, SIDES_AFTER, TOUCHING_RATIO,
};

/// Kind of contact between two pieces.
#[derive(Clone, Copy, Debug)]
pub(super) enum Touch {
    /// They cross to this depth.
    Crosses(f64),
    /// They lay flat on each other, and have left through each other; the larger of their heights over each other.
    Through(f64),
    /// They lie flat on each other.
    Flat,
    /// They do not cross, and do not lie flat on each other.
    Nowhere,
}

/// The creases between the two pieces of a pair that turn in the current segment.
struct Between {
    /// In the order in which they turn the second piece, seen from the first, and in that in which they turn the first, seen
    /// from the second.
    turns: [Vec<Turn>; 2],
    /// Their groups, without repetition.
    groups: Vec<u32>,
    chain: Chain,
}

impl Between {
    /// Returns a bound on the error that tears along the chain make in the motion of the second piece, given a bound on the sum
    /// of the tears. They displace the piece before and after the changes, and the lines about which it turns.
    fn torn(&self, changes: &[Change], tear: f64) -> f64 {
        let turns = self.turns[0].iter();
        let turns = turns.map(|turn| changes[turn.group as usize]);
        let turned: f64 = turns.map(|change| change.by.abs() + change.off).sum();
        (2.0 + turned) * tear
    }
}

impl Sweep<'_> {
    /// Returns the depth to which two placed pieces that are `apart` cross. While pieces lie flat on each other, stores the
    /// sides that they came from.
    pub(super) fn crosses(&mut self, index: u32, pair: &Pair, apart: f64) -> Option<f64> {
        let tolerance = self.allowed(pair).largest();
        let came = match self.touch(pair, apart) {
            Touch::Crosses(depth) | Touch::Through(depth) => {
                self.queue[index].above = pair.above;
                return Some(depth);
            }
            Touch::Nowhere => return None,
            Touch::Flat => pair.above.or_else(|| {
                let time = self.sheet.time;
                let came = self.came_from(pair, [pair.last?, time], tolerance);
                self.sheet.time = time;
                self.sheet.put(pair.nodes);
                came
            }),
        };
        self.queue[index].above = came;
        None
    }

    /// Returns how two placed pieces that are `apart` touch. Pieces that lay flat on each other have left through each other
    /// if each is on the other side of the other than it came from.
    pub(super) fn touch(&mut self, pair: &Pair, apart: f64) -> Touch {
        let allowed = self.allowed(pair);
        let tolerance = allowed.largest();
        if apart <= tolerance {
            let depth = self.sheet.depth(pair.nodes, allowed);
            if depth > 0.0 {
                return Touch::Crosses(depth);
            }
        } else if pair.above.is_none() {
            return Touch::Nowhere;
        }
        // Solids have an inside, which tells at once whether they pass through each other.
        if self.sheet.pieces.are_solid() {
            return Touch::Nowhere;
        }
        let Some(heights) = self.heights(pair.nodes, tolerance) else {
            return Touch::Nowhere;
        };
        let Some(sides) = self.sides(pair.nodes, heights, tolerance) else {
            return Touch::Flat;
        };
        if pair.above == Some(sides.map(|side| !side)) {
            Touch::Through(heights[0].abs().max(heights[1].abs()))
        } else {
            Touch::Nowhere
        }
    }

    /// Finds by bisection from which sides two pieces came that lie flat on each other at the second time, and
    /// do not cross since the first. The flags are `true` if the second was above the first, and if the first
    /// was above the second. Returns `None` if the pieces lay flat on each other all the time.
    fn came_from(
        &mut self,
        pair: &Pair,
        [mut from, mut to]: [Tick; 2],
        tolerance: f64,
    ) -> Option<[bool; 2]> {
        let (nodes, first) = (pair.nodes, from);
        let mut time = from;
        loop {
            self.sheet.time = time;
            self.sheet.put(nodes);
            // Heights are measured in the middle of sectors, whose ends may be farther apart. At the first time the
            // sectors do not touch, so that any height tells the side.
            let least = match pair.kind {
                Kind::Vertex(corners) if time == first => {
                    let [angle, reach] = self.between_sectors(nodes, corners);
                    if angle * reach > tolerance {
                        self.torn(pair)
                    } else {
                        tolerance
                    }
                }
                _ => tolerance,
            };
            match self.heights(nodes, tolerance) {
                Some(heights) => match self.sides(nodes, heights, least) {
                    None => to = time,
                    sides => return sides,
                },
                None => from = time,
            }
            if to - from <= 1 {
                return None;
            }
            time = (from + to) / 2;
        }
    }

    /// Returns which of two placed pieces is above the other, as [`came_from`](Self::came_from) does, given their heights over
    /// each other; `None` if they lie on each other up to `least`. Pieces on each other are nearly parallel, so that one
    /// height tells the other side too.
    fn sides(&self, nodes: [u32; 2], heights: [f64; 2], least: f64) -> Option<[bool; 2]> {
        let placed = self.sheet.placed();
        let [a, b] = nodes.map(|node| placed.piece(node).normal);
        let is_turned_over = a.dot(&b) < 0.0;
        let told = |own: f64, other: f64| {
            if own.abs() > least {
                own > 0.0
            } else {
                (other > 0.0) == is_turned_over
            }
        };
        let [first, second] = heights;
        (first.abs().max(second.abs()) > least).then(|| [told(first, second), told(second, first)])
    }

    /// Returns the heights of two placed pieces over each other.
    fn heights(&self, nodes: [u32; 2], tolerance: f64) -> Option<[f64; 2]> {
        let placed = self.sheet.placed();
        let [a, b] = nodes.map(|node| placed.piece(node));
        heights(&a, &b, tolerance)
    }

    /// Returns the next query of a pair that nearly touches or stands still: a later one, if a plane separates the pair for
    /// longer, or the piece hardly moves. Its points may come nearer by `allowance`, units of the sheet or, for sectors,
    /// radians.
    pub(super) fn at_contact(
        &mut self,
        index: u32,
        allowed: Allowed,
        [apart, allowance]: [f64; 2],
        outcome: QueryOutcome,
    ) -> QueryOutcome {
        let time = self.sheet.time;
        let motion = &self.sheet.motion;
        let next = motion.next_tabulated(time);
        let QueryOutcome::Until(until) = outcome else {
            return outcome;
        };
        let pair = &self.queue[index];
        let stalled = pair.stall.count;
        // Along a lattice, pieces may be elsewhere by the deviation, which no plane may use up.
        let (deviation, kept) = (self.deviation, KEPT_RATIO * apart);
        let touches = deviation <= 0.0 && apart <= TOUCHING_RATIO * allowed.largest();
        let is_sector = matches!(pair.kind, Kind::Vertex(_));
        let is_apart = kept > deviation && !is_sector;
        if until >= next || !(touches || is_apart && stalled >= PLANES_AFTER) {
            return outcome;
        }
        // The smallest distance is known up to a part of it.
        let room = if touches {
            allowed
        } else {
            Allowed::apart(kept)
        };
        let above = self.queue[index].above;
        let between = self.between(index, allowed);
        let turns = &between.turns;
        let [a, b] = self.queue[index].nodes;
        let mut changes = core::mem::take(&mut self.changes);
        let both = [([a, b], &turns[0]), ([b, a], &turns[1])];
        let placed = self.sheet.placed();
        let piece = |node: u32| placed.piece(node);
        let planes = both
            .iter()
            .zip(above.map_or([None; 2], |above| above.map(Some)));
        // Each solid with the other one, and the turns that lead from it to the other.
        let solids = placed.solids([a, b]);
        let solids = solids
            .as_ref()
            .map(|[a, b]| [(a, b, &turns[0]), (b, a, &turns[1])]);
        let planes: Vec<Parted> = match solids {
            Some(both) => both
                .into_iter()
                .map(|(fixed, moving, turns)| {
                    let planes = fixed.planes().map(|(normal, point)| (normal, point, None));
                    parted_by(planes, moving.points, turns, room)
                })
                .collect(),
            None => planes
                .map(|(([a, b], turns), above)| parted(&piece(*a), &piece(*b), turns, above, room))
                .collect(),
        };
        let mut reached = self.held(&between.groups, [until, next], &mut changes, |changes| {
            planes.iter().any(|planes| planes.hold(changes, room))
        });
        if reached < next && stalled >= SIDES_AFTER {
            // Turns may undo each other, as those about two creases that lie on each other.
            let moved = Moved::new(placed.hull(b), &turns[0]);
            reached = self.held(&between.groups, [reached, next], &mut changes, |changes| {
                let (by, tear) = if is_sector {
                    (moved.turned(changes), between.chain.turn)
                } else {
                    (moved.farthest(changes), between.chain.tear)
                };
                by + between.torn(changes, tear) <= allowance
            });
        }
        // Layers are kept apart by their planes, in the order in which they lie.
        if reached < next
            && stalled >= SIDES_AFTER
            && let Some(both) = solids
        {
            let planes = both.map(|(fixed, moving, turns)| {
                let planes = fixed.planes_before(moving, room.largest()).into_iter();
                let planes = planes.map(|(normal, point)| (normal, point, None));
                parted_by(planes, moving.points, turns, room)
            });
            reached = self.held(&between.groups, [reached, next], &mut changes, |changes| {
                planes.iter().any(|planes| planes.hold(changes, room))
            });
        } else if reached < next && above.is_none() && stalled >= SIDES_AFTER {
            let planes =
                both.map(|([a, b], turns)| SidePlanes::of(&piece(a), &piece(b), turns, room));
            reached = self.held(&between.groups, [reached, next], &mut changes, |changes| {
                planes.iter().any(|planes| planes.hold(changes, room))
            });
        }
        self.changes = changes;
        QueryOutcome::Until(reached)
    }

    /// Returns the last of some times between two, at growing distances from the first, up to which the changes of the
    /// groups from now on, by which pieces turn relative to each other, are as they have to be. `changes` has room for all
    /// groups.
    fn held(
        &self,
        groups: &[u32],
        [mut reached, next]: [Tick; 2],
        changes: &mut [Change],
        holds: impl Fn(&[Change]) -> bool,
    ) -> Tick {
        let (motion, time) = (&self.sheet.motion, self.sheet.time);
        for to in motion.halves(reached, next) {
            motion.changes(groups, time, to, changes);
            if !holds(changes) {
                break;
            }
            reached = to;
        }
        reached
    }

    /// Returns the creases between the two pieces of a pair that turn in the current segment.
    fn between(&mut self, index: u32, allowed: Allowed) -> Between {
        let pair = &mut self.queue[index];
        let chain = self
            .approach
            .chain_within(&self.sheet, pair, allowed.largest());
        let links = self.approach.chains.links(&chain);
        let (motion, time) = (&self.sheet.motion, self.sheet.time);
        let mut places: Vec<_> = links
            .iter()
            .filter(|link| !motion.rests(link.group as usize, [time, time + 1]))
            .flat_map(|link| {
                let both = link.creases.into_iter().zip(link.places);
                both.map(|(crease, (place, along))| (place, along, crease, link.group))
            })
            .collect();
        places.sort_unstable();
        places.dedup();
        let turns = places.into_iter().map(|(_, along, crease, group)| {
            let axis = self.sheet.axis(crease);
            Turn {
                group,
                point: axis.point,
                about: if along {
                    axis.direction
                } else {
                    -axis.direction
                },
            }
        });
        let turns: Vec<_> = turns.collect();
        // Seen from the other end, creases come in reverse order and turn the other way.
        let back = turns.iter().rev().map(|turn| Turn {
            about: -turn.about,
            ..*turn
        });
        let back = back.collect();
        let mut groups: Vec<u32> = turns.iter().map(|turn| turn.group).collect();
        groups.sort_unstable();
        groups.dedup();
        Between {
            turns: [turns, back],
            groups,
            chain,
        }
    }

    /// Returns the depth up to which an overlap of the two pieces of a pair is contact. If they share a vertex, they have
    /// to be placed: the distance of their positions of the vertex adds to the depth.
    pub(super) fn allowed(&self, pair: &Pair) -> Allowed {
        let torn = self.torn(pair);
        self.contact.of(&self.sheet.pieces, pair.nodes, torn)
    }

    /// Returns the largest distance between the positions that two placed pieces give a vertex that they share.
    fn torn(&self, pair: &Pair) -> f64 {
        let placed = self.sheet.placed();
        match pair.kind {
            Kind::Vertex(corners) => {
                let corner = |k: usize| placed.piece(pair.nodes[k]).corners[corners[k] as usize];
                (corner(0) - corner(1)).norm()
            }
            Kind::Side(_) => placed.torn(pair.nodes),
            _ => 0.0,
        }
    }

    /// Returns how much nearer points of two placed pieces that are `apart` may come to each other than that distance until
    /// an overlap is no longer contact.
    pub(super) fn left_of(&self, allowed: Allowed, nodes: [u32; 2], apart: f64) -> f64 {
        let approach = apart + allowed.largest();
        // The two ends of a length move by the approach at most, which turns it by twice that over the length; a plane
        // has two directions.
        let turn = 4.0 * approach / self.sheet.pieces.smaller_size(nodes);
        self.sheet.placed().left(nodes, apart, turn, allowed)
    }

    /// Returns `true` if two placed pieces are torn so far apart at their common vertex that nothing can be told of them.
    pub(super) fn is_split(&self, pair: &Pair) -> bool {
        self.torn(pair) > MAX_TEAR_RATIO * self.sheet.pieces.smaller_size(pair.nodes)
    }
}
