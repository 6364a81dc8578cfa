//! Pieces in contact: whether they cross, from which sides they came, and how long a plane keeps them apart.

use super::motion::Tick;
use super::queue::{Kind, Pair};
use super::{QueryOutcome, Sweep};
use crate::collision::narrow::crossing::Allowed;
use crate::collision::narrow::layers::heights;
use crate::collision::narrow::planes::{Change, Parted, Turn, parted};
use crate::collision::tolerances::{MAX_TEAR_RATIO, TOUCHING_RATIO};

impl Sweep<'_> {
    /// Returns the depth to which two placed pieces cross. Pieces that lay flat on each other also cross if they have
    /// left through each other, that is, if each is on the other side of the other than it came from; the depth is then
    /// their larger height. While pieces lie flat on each other, stores the sides that they came from.
    pub(super) fn crosses(&mut self, index: u32, pair: &Pair, apart: f64) -> Option<f64> {
        let (nodes, allowed) = (pair.nodes, self.allowed(pair));
        let tolerance = allowed.largest();
        if apart <= tolerance {
            let depth = self.sheet.depth(nodes, allowed);
            if depth > 0.0 {
                return Some(depth);
            }
        } else if pair.above.is_none() {
            return None;
        }
        let heights = self.heights(nodes, tolerance)?;
        let most = heights[0].abs().max(heights[1].abs());
        if most > tolerance {
            let mut sides = heights.into_iter().zip(pair.above?);
            let through = sides.all(|(height, above)| (height > 0.0) != above);
            return through.then_some(most);
        }
        let came = pair.above.or_else(|| {
            let time = self.sheet.time;
            let came = self.came_from(pair, [pair.last?, time], tolerance);
            self.sheet.time = time;
            self.sheet.put(nodes);
            came
        });
        self.queue[index].above = came;
        None
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
                Some(heights) if heights.iter().all(|h| h.abs() > least) => {
                    return Some(heights.map(|height| height > 0.0));
                }
                Some(_) => to = time,
                None => from = time,
            }
            if to - from <= 1 {
                return None;
            }
            time = (from + to) / 2;
        }
    }

    /// Returns the heights of two placed pieces over each other.
    fn heights(&self, nodes: [u32; 2], tolerance: f64) -> Option<[f64; 2]> {
        let placed = self.sheet.placed();
        let [a, b] = nodes.map(|node| placed.piece(node));
        heights(&a, &b, tolerance)
    }

    /// Returns the next query of a pair that nearly touches: a later one, if a plane separates the pair for longer.
    pub(super) fn at_contact(
        &mut self,
        index: u32,
        allowed: Allowed,
        apart: f64,
        outcome: QueryOutcome,
    ) -> QueryOutcome {
        let time = self.sheet.time;
        let motion = &self.sheet.motion;
        let next = motion.next_tabulated(time);
        let QueryOutcome::Until(until) = outcome else {
            return outcome;
        };
        if until >= next || apart > TOUCHING_RATIO * allowed.largest() {
            return outcome;
        }
        let parted = self.parted(index, allowed);
        let mut groups: Vec<u32> = self.turns.iter().map(|turn| turn.group).collect();
        groups.sort_unstable();
        groups.dedup();
        let none = Change { by: 0.0, off: 0.0 };
        self.changes.resize(self.groups, none);
        let mut reached = until;
        let motion = &self.sheet.motion;
        for to in motion.halves(until, next) {
            motion.changes(&groups, time, to, &mut self.changes);
            let holds = |parted: &Parted| parted.holds(&self.changes, allowed);
            if !parted.iter().any(holds) {
                break;
            }
            reached = to;
        }
        QueryOutcome::Until(reached)
    }

    /// Returns the planes that separate two pieces.
    fn parted(&mut self, index: u32, allowed: Allowed) -> Vec<Parted> {
        let pair = &mut self.queue[index];
        let chain = self
            .approach
            .chain_within(&self.sheet, pair, allowed.largest());
        let nodes = pair.nodes;
        let links = self.approach.chains.links(&chain);
        let mut places: Vec<_> = links
            .iter()
            .flat_map(|link| {
                let both = link.creases.into_iter().zip(link.places);
                both.map(|(crease, (place, along))| (place, along, crease, link.group))
            })
            .collect();
        places.sort_unstable();
        places.dedup();
        self.turns.clear();
        for (_, along, crease, group) in places {
            let axis = self.sheet.axis(crease);
            self.turns.push(Turn {
                group,
                point: axis.point,
                about: if along {
                    axis.direction
                } else {
                    -axis.direction
                },
            });
        }
        let placed = self.sheet.placed();
        let [a, b] = nodes.map(|node| placed.piece(node));
        let above = self.queue[index].above;
        let above = [0, 1].map(|k| above.map(|above| above[k]));
        let mut all = parted(&a, &b, &self.turns, above[0], allowed);
        // Seen from the other end, creases come in reverse order and turn the other way.
        self.turns.reverse();
        for turn in &mut self.turns {
            turn.about = -turn.about;
        }
        all.extend(parted(&b, &a, &self.turns, above[1], allowed));
        all
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
