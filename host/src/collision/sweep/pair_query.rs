//! Narrow phase of a sweep: queries pairs for their distance at a time, and for how long they stay apart.

use super::{Kind, Pair, Place, QueryOutcome, Sweep, place};
use crate::collision::chains::Chain;
use crate::collision::contact::{Change, Parted, Turn, parted};
use crate::collision::hierarchy::Sphere;
use crate::collision::interval_broad_phase::IntervalBroadPhase;
use crate::collision::layers::heights;
use crate::collision::motion::{Motion, Tick};
use crate::collision::pieces::Pieces;
use crate::collision::placed_pieces::Axis;
use crate::collision::separation::{Sector, distance};
use crate::collision::sweep::Clearance;
use crate::collision::tolerances::{
    APART_TIMES, MAX_TEAR_RATIO, MEASURE_RATIO, MIN_LEFT_RATIO, NEAREST_APART_TIMES, SPLIT_RATIO,
    TOUCHING_RATIO, WAKE_TIMES, WAYS_AT_ONCE,
};
use crate::pattern::FaceId;

fn clearance(pieces: &Pieces, pair: [u32; 2], distance: f64, place: Place) -> Clearance {
    let [first, second] = pair.map(|piece| pieces.list[piece as usize].face);
    Clearance {
        distance,
        faces: [first.min(second), first.max(second)],
        place,
    }
}

impl Sweep<'_> {
    fn sphere(&mut self, motion: &Motion, node: u32) -> Sphere {
        self.folding
            .sphere(motion, &self.pieces, &self.hierarchy, node)
    }

    pub(super) fn query(&mut self, motion: &Motion, index: u32) -> QueryOutcome {
        let pair = self.pairs[index as usize].clone();
        self.pairs[index as usize].above = None;
        let nodes = pair.nodes;
        match pair.kind {
            Kind::Clusters => self.query_clusters(motion, index, &pair),
            Kind::Far => self.query_far_cells(motion),
            Kind::Interval => self.query_interval(motion),
            Kind::Cells(offset) => self.query_cells(motion, offset),
            Kind::Pieces | Kind::Meeting => self.query_pieces(motion, index, &pair),
            Kind::Vertex(corners) => self.query_sectors(motion, index, &pair, corners),
            Kind::Joined => {
                self.counts.tested += 1;
                match self.depth(motion, nodes) {
                    depth if depth > 0.0 => QueryOutcome::Crossing(depth),
                    _ if self.folding.time == motion.end() => QueryOutcome::Free,
                    _ => QueryOutcome::Until(motion.next_tabulated(self.folding.time)),
                }
            }
        }
    }

    fn query_clusters(&mut self, motion: &Motion, index: u32, pair: &Pair) -> QueryOutcome {
        let [a, b] = pair.nodes;
        if a == b || !self.options.skip_bounds {
            return QueryOutcome::Split;
        }
        let spheres = [a, b].map(|node| self.sphere(motion, node));
        let distance = spheres[0].distance(&spheres[1]);
        if distance <= SPLIT_RATIO * spheres[0].radius.max(spheres[1].radius) {
            return QueryOutcome::Split;
        }
        let nodes = [a, b].map(|node| self.hierarchy.nodes[node as usize]);
        let chain = self.chain(index);
        self.gather(motion, &chain, |side, axis| {
            axis.distance(&spheres[side].center) + spheres[side].radius
        });
        for node in [a, b] {
            self.levers.any += self.spread(motion, node);
        }
        let torn = chain.tear + self.tears[a as usize] + self.tears[b as usize];
        let room = distance - 2.0 * torn;
        if torn > 0.0 && (room.is_nan() || room <= 0.0) {
            return QueryOutcome::Split;
        }
        let time = self.folding.time;
        let until = motion.tabulated_until(&self.levers, time, room);
        let outcome = match until {
            Some(until) => self.next(motion, until, distance, true),
            None if time == motion.end() => QueryOutcome::Free,
            None => return QueryOutcome::Split,
        };
        self.counts.skipped_bounds += u64::from(nodes[0].pieces) * u64::from(nodes[1].pieces);
        outcome
    }

    /// Runs the broad phase over the next interval: adds the pieces that may meet before its end, and finds the
    /// nearest pieces at its end.
    fn query_interval(&mut self, motion: &Motion) -> QueryOutcome {
        let time = self.folding.time;
        if time > 0 && time == motion.end() {
            return QueryOutcome::Free;
        }
        if self.watch.is_over() {
            return QueryOutcome::Undecided;
        }
        let Some(mut broad_phase) = self.broad_phase.take() else {
            return QueryOutcome::Free;
        };
        let before = broad_phase.from;
        if time == motion.end() || !broad_phase.advance(motion, &self.pieces, &self.hierarchy) {
            // Chains of creases give better bounds than the long sums of the broad phase.
            self.broad_phase = Some(broad_phase);
            self.add_roots(time);
            return QueryOutcome::Split;
        }
        let touching = self.contact.largest();
        let (pieces, hierarchy) = (&self.pieces, &self.hierarchy);
        let mut nearest = self.clearance;
        let best = |nearest: &Option<Clearance>| nearest.map_or(f64::INFINITY, |n| n.distance);
        let (mut tested, mut unseen) = (0, Vec::new());
        // The beginning of an interval is the end of the one before.
        let ends = [(0, broad_phase.from), (2, broad_phase.to)];
        let ends = if time == 0 {
            &ends[..]
        } else if motion.tabulated(broad_phase.to).is_some() {
            &ends[1..]
        } else {
            &[]
        };
        let test = |broad_phase: &IntervalBroadPhase, pair: [u32; 2]| {
            let [a, b] = pair;
            let counts = pieces.comparable(a, b).is_some() && !pieces.meet(a, b);
            counts.then(|| broad_phase.parted(pieces, pair, touching))
        };
        let within = [touching, best(&nearest)];
        broad_phase.near(hierarchy, within, test, |broad_phase, pair, apart| {
            tested += 1;
            let apart = apart.unwrap_or_else(|| {
                unseen.push(pair);
                [0.0; 3]
            });
            for &(end, tick) in ends {
                if apart[end] >= best(&nearest) {
                    continue;
                }
                let distance = broad_phase.distance(pieces, pair, end);
                if distance < best(&nearest) {
                    let at = place(motion, tick);
                    nearest = Some(clearance(pieces, pair, distance, at));
                }
            }
            best(&nearest)
        });
        self.clearance = nearest;
        self.counts.tested += tested;
        self.counts.skipped_bounds += self.others.saturating_sub(tested);
        let [from, to] = [broad_phase.from, broad_phase.to];
        self.broad_phase = Some(broad_phase);
        for pair in &mut unseen {
            pair.sort_unstable();
        }
        for pairs in unseen.chunks(WAYS_AT_ONCE) {
            // Finding the chain of a pair takes about as long as a query.
            let new: Vec<[u32; 2]> = pairs
                .iter()
                .filter(|pair| !self.unseen.contains_key(*pair))
                .copied()
                .collect();
            let faces: Vec<[FaceId; 2]> = new
                .iter()
                .map(|pair| pair.map(|piece| self.hierarchy.nodes[piece as usize].face))
                .collect();
            let ways = self.chains.ways(self.pattern, &faces, self.watch);
            if self.watch.is_over() {
                return QueryOutcome::Undecided;
            }
            let mut ways = ways.into_iter();
            for pair in pairs {
                let is_new = !self.unseen.contains_key(pair);
                let way = if is_new { ways.next().flatten() } else { None };
                self.add_unseen(*pair, [before, from, to], way);
            }
        }
        self.push([0, 0], Kind::Interval, None, to);
        QueryOutcome::Split
    }

    /// Wakes cells that come near each other soon.
    fn query_far_cells(&mut self, motion: &Motion) -> QueryOutcome {
        let (time, best, deviation) = (self.folding.time, self.best(), self.lattice_deviation());
        let touching = self.contact.base();
        let Some(cells) = &mut self.folding.cells else {
            return QueryOutcome::Free;
        };
        // As long as no distance is known, cells within a growing distance are woken.
        if best == f64::INFINITY {
            self.far = 2.0 * self.far + self.pattern.median_edge() / 2.0;
        }
        let near = deviation + touching.max(self.far.min(best));
        let skips = self.options.skip_bounds && self.options.skip_motion;
        let near = if skips { near } else { f64::INFINITY };
        let Some(woken) = cells.wake(motion, time, near) else {
            return QueryOutcome::Undecided;
        };
        let is_last = woken.is_empty() && (best.is_finite() || cells.all_awake);
        for offset in woken {
            self.push([0, 0], Kind::Cells(offset), None, time);
        }
        if !is_last {
            QueryOutcome::Again
        } else if time == motion.end() {
            QueryOutcome::Free
        } else {
            QueryOutcome::Until(motion.tabulated_after(time, WAKE_TIMES))
        }
    }

    fn query_cells(&mut self, motion: &Motion, offset: u32) -> QueryOutcome {
        let (time, best) = (self.folding.time, self.best());
        let (bounds, deviation) = (self.options.skip_bounds, self.lattice_deviation());
        let touching = self.contact.base();
        let Some(cells) = &mut self.folding.cells else {
            return QueryOutcome::Free;
        };
        let apart = cells.gap_of(motion, time, offset);
        if bounds && apart > touching && apart >= best {
            let until = cells.until(motion, time, offset, apart - deviation);
            if until.map_or(time, |(until, _)| until) >= motion.tabulated_after(time, APART_TIMES) {
                self.counts.skipped_bounds += cells.left(offset);
                return self.after_cells(motion, apart, until);
            }
        }
        let near = if bounds {
            let leap = deviation + cells.moved(motion, time, APART_TIMES, offset);
            let far = deviation + cells.moved(motion, time, NEAREST_APART_TIMES, offset);
            leap.max(touching).max(far.min(best))
        } else {
            f64::INFINITY
        };
        let found = cells.apart(motion, time, offset, [near, best]);
        if !found.near.is_empty() {
            self.take(&found.near, time);
            return QueryOutcome::Again;
        }
        let mut measured = 0;
        for faces in found.nearest {
            measured += self.measure(motion, faces);
        }
        let Some(cells) = &self.folding.cells else {
            return QueryOutcome::Free;
        };
        let until = cells.until(motion, time, offset, found.least - deviation);
        self.counts.skipped_bounds += cells.left(offset).saturating_sub(measured);
        self.after_cells(motion, found.least, until)
    }

    /// Returns the next query of cells that are `apart`, given the time until which they stay apart and their
    /// motion until then.
    fn after_cells(&self, motion: &Motion, apart: f64, until: Option<(Tick, f64)>) -> QueryOutcome {
        match until {
            None => QueryOutcome::Free,
            Some((until, _)) if !self.options.skip_motion => {
                QueryOutcome::Until(until.min(motion.next_tabulated(self.folding.time)))
            }
            Some((until, moved)) if until == motion.end() && apart - moved >= self.best() => {
                QueryOutcome::Free
            }
            Some((until, _)) => QueryOutcome::Until(until),
        }
    }

    /// Measures the distance of two faces, which may be the smallest; returns the number of pairs of pieces measured.
    fn measure(&mut self, motion: &Motion, faces: [FaceId; 2]) -> u64 {
        let [first, second] = faces.map(|face| self.load(face));
        let mut measured = 0;
        for a in first {
            for b in second.clone() {
                measured += 1;
                self.counts.tested += 1;
                self.put(motion, [a, b], false);
                let placed = self.folding.placed(&self.pieces);
                self.note(motion, [a, b], distance(&placed.piece(a), &placed.piece(b)));
            }
        }
        measured
    }

    /// Stores a distance if it is smaller than all before.
    fn note(&mut self, motion: &Motion, nodes: [u32; 2], distance: f64) {
        if distance < self.best() {
            let at = place(motion, self.folding.time);
            self.clearance = Some(clearance(&self.pieces, nodes, distance, at));
        }
    }

    /// Adds the pairs of pieces of pairs of faces.
    fn take(&mut self, pairs: &[[FaceId; 2]], time: Tick) {
        for faces in pairs {
            let [first, second] = faces.map(|face| self.load(face));
            for a in first {
                for b in second.clone() {
                    self.add([a, b], time);
                }
            }
        }
    }

    fn query_pieces(&mut self, motion: &Motion, index: u32, pair: &Pair) -> QueryOutcome {
        let [a, b] = pair.nodes;
        let spheres = [a, b].map(|node| self.sphere(motion, node));
        let apart = spheres[0].distance(&spheres[1]);
        let best = self.best();
        let counts = pair.kind == Kind::Pieces;
        let deviation = self.lattice_deviation();
        let comoving = self.comoving_until(motion, pair.nodes);
        let far = apart > deviation + MEASURE_RATIO * spheres[0].radius.min(spheres[1].radius);
        if self.options.skip_bounds && far && (apart >= best || !counts) {
            self.counts.skipped_bounds += 1;
            if let Some(until) = comoving {
                return self.next(motion, until, apart, false);
            }
            if let Some(outcome) = self.along_lattice(motion, index, apart - deviation, counts) {
                return outcome;
            }
            let chain = self.chain_within(index, apart);
            self.gather(motion, &chain, |side, axis| {
                axis.distance(&spheres[side].center) + spheres[side].radius
            });
            let allowance = apart - deviation - 2.0 * chain.tear;
            return self.after(motion, apart, allowance, counts);
        }
        self.counts.tested += 1;
        self.put(motion, [a, b], false);
        let placed = self.folding.placed(&self.pieces);
        let apart = distance(&placed.piece(a), &placed.piece(b));
        let tolerance = self.allowed(pair);
        if deviation > 0.0 && apart <= deviation + tolerance {
            return QueryOutcome::Undecided;
        }
        if let Some(depth) = self.crosses(motion, index, pair, apart) {
            return QueryOutcome::Crossing(depth);
        }
        if counts {
            self.note(motion, [a, b], apart);
        }
        if let Some(until) = comoving {
            return self.next(motion, until, apart, false);
        }
        if let Some(outcome) = self.along_lattice(motion, index, apart - deviation, counts) {
            return outcome;
        }
        let room = apart - deviation + self.left_of(tolerance, pair.nodes, apart);
        let chain = self.chain_within(index, room);
        self.gather_corners(motion, &chain, [a, b]);
        let outcome = self.after(motion, apart, room - 2.0 * chain.tear, counts);
        self.at_contact(motion, index, tolerance, apart, outcome)
    }

    fn query_sectors(
        &mut self,
        motion: &Motion,
        index: u32,
        pair: &Pair,
        corners: [u32; 2],
    ) -> QueryOutcome {
        let [a, b] = pair.nodes;
        self.counts.tested += 1;
        self.put(motion, [a, b], false);
        let [angle, reach] = self.between_sectors(pair.nodes, corners);
        let tolerance = self.allowed(pair);
        let off_lattice = if self.folding.cells.is_some() {
            self.options.lattice_turn
        } else {
            0.0
        };
        if off_lattice > 0.0 && angle <= off_lattice || self.is_split(pair) {
            return QueryOutcome::Undecided;
        }
        if let Some(depth) = self.crosses(motion, index, pair, angle * reach) {
            return QueryOutcome::Crossing(depth);
        }
        if let Some(until) = self.comoving_until(motion, pair.nodes) {
            return self.next(motion, until, angle, false);
        }
        self.levers.clear();
        // Pairs of creases do not turn the part beyond them.
        let left = self.left_of(tolerance, pair.nodes, angle);
        let room = angle - off_lattice + left / reach;
        let chain = self.chain_within(index, room);
        for link in self.chains.singles(&chain) {
            self.levers.add(link.group, 1.0);
        }
        let outcome = self.after(motion, angle, room - 2.0 * chain.turn, false);
        self.at_contact(motion, index, tolerance, angle * reach, outcome)
    }

    /// Returns the angle (radians) between the sectors of two placed pieces at their common vertex, and the distance from
    /// the vertex up to which both pieces reach.
    fn between_sectors(&self, nodes: [u32; 2], corners: [u32; 2]) -> [f64; 2] {
        let placed = self.folding.placed(&self.pieces);
        let faces = nodes.map(|node| placed.piece(node));
        let sectors: [Sector; 2] =
            core::array::from_fn(|k| Sector::of(&faces[k], corners[k] as usize));
        let reach = |k: usize| {
            let apex = faces[k].corners[corners[k] as usize];
            let away = faces[k].corners.iter().map(|corner| (corner - apex).norm());
            away.fold(0.0, f64::max)
        };
        let angle = sectors[0].separation(&sectors[1]);
        [angle, reach(0).min(reach(1))]
    }

    /// Returns the depth to which two placed pieces cross. Pieces that lay flat on each other also cross if they have
    /// left through each other, that is, if each is on the other side of the other than it came from; the depth is then
    /// their larger height. While pieces lie flat on each other, stores the sides that they came from.
    fn crosses(&mut self, motion: &Motion, index: u32, pair: &Pair, apart: f64) -> Option<f64> {
        let (nodes, tolerance) = (pair.nodes, self.allowed(pair));
        if apart <= tolerance {
            let depth = self.depth(motion, nodes);
            if depth > tolerance {
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
            let time = self.folding.time;
            let came = self.came_from(motion, pair, [pair.last?, time], tolerance);
            self.folding.time = time;
            self.put(motion, nodes, false);
            came
        });
        self.pairs[index as usize].above = came;
        None
    }

    /// Finds by bisection from which sides two pieces came that lie flat on each other at the second time, and
    /// do not cross since the first. The flags are `true` if the second was above the first, and if the first
    /// was above the second. Returns `None` if the pieces lay flat on each other all the time.
    fn came_from(
        &mut self,
        motion: &Motion,
        pair: &Pair,
        [mut from, mut to]: [Tick; 2],
        tolerance: f64,
    ) -> Option<[bool; 2]> {
        let (nodes, first) = (pair.nodes, from);
        let mut time = from;
        loop {
            self.folding.time = time;
            self.put(motion, nodes, false);
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
        let placed = self.folding.placed(&self.pieces);
        let [a, b] = nodes.map(|node| placed.piece(node));
        heights(&a, &b, tolerance)
    }

    /// Returns the next query of a pair that nearly touches: a later one, if a plane separates the pair for longer.
    fn at_contact(
        &mut self,
        motion: &Motion,
        index: u32,
        tolerance: f64,
        apart: f64,
        outcome: QueryOutcome,
    ) -> QueryOutcome {
        let time = self.folding.time;
        let next = motion.next_tabulated(time);
        let QueryOutcome::Until(until) = outcome else {
            return outcome;
        };
        if until >= next || apart > TOUCHING_RATIO * tolerance {
            return outcome;
        }
        let parted = self.parted(motion, index, tolerance);
        let mut groups: Vec<u32> = self.turns.iter().map(|turn| turn.group).collect();
        groups.sort_unstable();
        groups.dedup();
        let none = Change { by: 0.0, off: 0.0 };
        self.changes.resize(self.groups, none);
        let mut reached = until;
        for to in motion.halves(until, next) {
            motion.changes(&groups, time, to, &mut self.changes);
            let holds = |parted: &Parted| parted.holds(&self.changes, tolerance);
            if !parted.iter().any(holds) {
                break;
            }
            reached = to;
        }
        QueryOutcome::Until(reached)
    }

    /// Returns the planes that separate two pieces.
    fn parted(&mut self, motion: &Motion, index: u32, tolerance: f64) -> Vec<Parted> {
        let chain = self.chain_within(index, tolerance);
        let nodes = self.pairs[index as usize].nodes;
        let links = self.chains.links(&chain);
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
            let axis = self.folding.axis(motion, crease);
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
        let placed = self.folding.placed(&self.pieces);
        let [a, b] = nodes.map(|node| placed.piece(node));
        let above = self.pairs[index as usize].above;
        let above = [0, 1].map(|k| above.map(|above| above[k]));
        let mut all = parted(&a, &b, &self.turns, above[0], tolerance);
        // Seen from the other end, creases come in reverse order and turn the other way.
        self.turns.reverse();
        for turn in &mut self.turns {
            turn.about = -turn.about;
        }
        all.extend(parted(&b, &a, &self.turns, above[1], tolerance));
        all
    }

    /// Returns the depth up to which an overlap of the two pieces of a pair is contact, units of the sheet. If they share
    /// a vertex, they have to be placed: the distance of their positions of the vertex adds to the depth.
    pub(super) fn allowed(&self, pair: &Pair) -> f64 {
        self.contact.of(&self.pieces, pair.nodes) + self.torn(pair)
    }

    /// Returns the distance between the positions that two placed pieces give a vertex that they share.
    fn torn(&self, pair: &Pair) -> f64 {
        let Kind::Vertex(corners) = pair.kind else {
            return 0.0;
        };
        let corner = |k: usize| {
            let corners_of = self.pieces.list[pair.nodes[k] as usize].corners();
            self.folding.folded[corners_of][corners[k] as usize]
        };
        (corner(0) - corner(1)).norm()
    }

    /// Returns how much deeper two placed pieces, `apart` by a distance or an angle, may overlap until that is no longer
    /// contact: the `tolerance` less the depth to which they do.
    fn left_of(&self, tolerance: f64, nodes: [u32; 2], apart: f64) -> f64 {
        if apart > 0.0 {
            return tolerance;
        }
        let (depth, _) = self.folding.placed(&self.pieces).depth_alone(nodes, 0.0);
        (tolerance - depth).max(MIN_LEFT_RATIO * tolerance)
    }

    /// Returns `true` if two placed pieces are torn so far apart at their common vertex that nothing can be told of them.
    fn is_split(&self, pair: &Pair) -> bool {
        self.torn(pair) > MAX_TEAR_RATIO * self.pieces.smaller_size(pair.nodes)
    }

    fn best(&self) -> f64 {
        let best = self.clearance.map(|clearance| clearance.distance);
        best.unwrap_or(f64::INFINITY)
    }

    fn put(&mut self, motion: &Motion, nodes: [u32; 2], joined: bool) {
        for node in nodes {
            self.folding.put(motion, &self.pieces, node, joined);
        }
    }

    /// Returns the depth to which two pieces cross.
    pub(super) fn depth(&mut self, motion: &Motion, [a, b]: [u32; 2]) -> f64 {
        for piece in [a, b] {
            self.pieces.join(self.pattern, piece);
        }
        if self.folding.cells.is_some() {
            self.hierarchy.extend(&self.pieces);
        }
        self.put(motion, [a, b], true);
        let tolerance = self.contact.depth(&self.pieces, [a, b]);
        self.folding.placed(&self.pieces).depth(a, b, tolerance)
    }

    /// Sums up the levers of a chain of creases. The lever of a crease is its distance from one end of the chain (0 or
    /// 1), as `reach` returns it: from the first end for creases up to some crease, from the second end for the others.
    fn gather(&mut self, motion: &Motion, chain: &Chain, reach: impl Fn(usize, &Axis) -> f64) {
        self.levers.clear();
        let folding = &mut self.folding;
        for link in self.chains.pairs(chain) {
            self.levers
                .add(link.group, folding.width(motion, link) + chain.tear);
        }
        let singles = self.chains.singles(chain);
        let Some(last) = singles.len().checked_sub(1) else {
            return;
        };
        // On a torn sheet, the lines of creases are off by the tears.
        let mut lever = |side: usize, k: usize| {
            reach(side, &folding.axis(motion, singles[k].creases[0])) + chain.tear
        };
        let (mut ends, mut levers) = ([0, last], [lever(0, 0), lever(1, last)]);
        for _ in singles {
            let side = usize::from(levers[1] < levers[0]);
            self.levers.add(singles[ends[side]].group, levers[side]);
            if ends[0] == ends[1] {
                return;
            }
            ends[side] = if side == 0 { ends[0] + 1 } else { ends[1] - 1 };
            levers[side] = lever(side, ends[side]);
        }
    }

    /// Returns a bound on how far points of a cluster move as seen from its face, per radian of variation of
    /// the group that varies most.
    fn spread(&mut self, motion: &Motion, node: u32) -> f64 {
        let Some(children) = self.hierarchy.nodes[node as usize].children else {
            return 0.0;
        };
        if let Some(spread) = self.folding.spread_of(node) {
            return spread;
        }
        let mut spread = 0.0_f64;
        for (side, child) in children.into_iter().enumerate() {
            let mut sum = self.spread(motion, child);
            let sphere = self.sphere(motion, child);
            let chain = &self.within[node as usize][side];
            for link in self.chains.pairs(chain) {
                sum += self.folding.width(motion, link);
            }
            for link in self.chains.singles(chain) {
                let axis = self.folding.axis(motion, link.creases[0]);
                sum += axis.distance(&sphere.center) + sphere.radius;
            }
            spread = spread.max(sum);
        }
        self.folding.set_spread(node, spread);
        spread
    }

    /// Sums up the levers of a chain between two placed pieces, from the distances of their corners.
    fn gather_corners(&mut self, motion: &Motion, chain: &Chain, nodes: [u32; 2]) {
        let ranges = nodes.map(|node| self.pieces.list[node as usize].corners());
        let corners = ranges.map(|range| self.folding.folded[range].to_vec());
        self.gather(motion, chain, |side, axis| {
            let away = corners[side].iter().map(|corner| axis.distance(corner));
            away.fold(0.0, f64::max)
        });
    }

    /// Returns the next query of a pair of pieces that are `apart`, by the bounds of the lattice; `None` if
    /// there is no lattice, or its bounds allow no step.
    fn along_lattice(
        &self,
        motion: &Motion,
        index: u32,
        apart: f64,
        counts: bool,
    ) -> Option<QueryOutcome> {
        let time = self.folding.time;
        if time == motion.end() {
            return Some(QueryOutcome::Free);
        }
        let cells = self.folding.cells.as_ref()?;
        let (until, moved) = cells.until_of(motion, time, self.faces(index), apart)?;
        if !self.options.skip_motion {
            return Some(QueryOutcome::Until(until.min(motion.next_tabulated(time))));
        }
        let free = until == motion.end() && (!counts || apart - moved >= self.best());
        Some(if free {
            QueryOutcome::Free
        } else {
            QueryOutcome::Until(until)
        })
    }

    /// Returns the next query of a pair of pieces that are `apart` and may approach each other by `allowance`.
    fn after(&self, motion: &Motion, apart: f64, allowance: f64, counts: bool) -> QueryOutcome {
        let time = self.folding.time;
        if time == motion.end() {
            return QueryOutcome::Free;
        }
        let until = motion.tabulated_until(&self.levers, time, allowance);
        let until = until.unwrap_or_else(|| motion.until(&self.levers, time, allowance));
        self.next(motion, until, apart, counts)
    }

    /// Returns the next query of a pair that is free until some time. A pair that is free to the end is queried
    /// there only if it may be the nearest pair at the end.
    fn next(&self, motion: &Motion, until: Tick, apart: f64, counts: bool) -> QueryOutcome {
        let time = self.folding.time;
        let until = if self.options.skip_motion {
            until
        } else {
            until.min(motion.next_tabulated(time))
        };
        let moved = || motion.moved(&self.levers, until) - motion.moved(&self.levers, time);
        let free = until == motion.end() && self.options.skip_motion;
        if free && (!counts || apart - moved() >= self.best()) {
            return QueryOutcome::Free;
        }
        QueryOutcome::Until(until)
    }
}
