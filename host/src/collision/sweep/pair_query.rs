//! Queries of a sweep: of a pair for its distance at a time and for how long it stays apart, and of batches of pairs.

use nalgebra::Vector3;

use super::motion::Tick;
use super::queue::{Kind, Pair};
use super::{QueryOutcome, Sweep};
use crate::collision::narrow::separation::Sector;
use crate::collision::pairs::{Answer, Batch, Now};
use crate::collision::placed_pieces::PlacedPieces;
use crate::collision::tolerances::MEASURE_RATIO;
use crate::pattern::FaceId;

impl Sweep<'_> {
    pub(super) fn query(&mut self, index: u32) -> QueryOutcome {
        let pair = self.queue[index].clone();
        self.queue[index].above = None;
        match pair.kind {
            Kind::Clusters => self.query_clusters(index, &pair),
            Kind::Batch(batch) => self.query_batch(batch),
            Kind::Pieces | Kind::Meeting => self.query_pieces(index, &pair),
            Kind::Vertex(corners) => self.query_sectors(index, &pair, corners),
            Kind::Side(side) => self.query_side(index, &pair, &side),
            Kind::Joined => {
                self.found.counts.tested += 1;
                match self.sheet.depth(pair.nodes, self.allowed(&pair)) {
                    depth if depth > 0.0 => QueryOutcome::Crossing(depth),
                    _ if self.sheet.is_at_end() => QueryOutcome::Free,
                    _ => QueryOutcome::Until(self.next_tabulated()),
                }
            }
        }
    }

    /// Asks the source of pairs about a batch.
    pub(super) fn ask(&mut self, batch: Batch) -> Answer {
        let mut now = Now {
            motion: &self.sheet.motion,
            time: self.sheet.time,
            pieces: &self.sheet.pieces,
            hierarchy: &self.sheet.hierarchy,
            contact: self.contact,
            options: &self.options,
            found: &mut self.found,
            watch: self.watch,
        };
        self.sheet.source.query(batch, &mut now)
    }

    /// Asks about a batch of cells of a lattice, and adds the pairs that it names.
    fn query_batch(&mut self, batch: Batch) -> QueryOutcome {
        let time = self.sheet.time;
        let answer = self.ask(batch);
        let mut measured = 0;
        for faces in answer.measure {
            measured += self.measure(faces);
        }
        self.found.counts.skipped_bounds += answer.skipped.saturating_sub(measured);
        for (batch, time) in answer.batches {
            self.add_batch(batch, time);
        }
        for faces in answer.faces {
            self.take(faces, time);
        }
        match answer.outcome {
            QueryOutcome::Apart(_, None) => QueryOutcome::Free,
            QueryOutcome::Apart(apart, Some(until)) => self.until(until, apart, true),
            outcome => outcome,
        }
    }

    /// Measures the distance of two faces, which may be the smallest; returns the number of pairs of pieces measured.
    fn measure(&mut self, faces: [FaceId; 2]) -> u64 {
        let [first, second] = self.sheet.load(faces);
        let mut measured = 0;
        for a in first {
            for b in second.clone() {
                measured += 1;
                self.found.counts.tested += 1;
                self.sheet.put([a, b]);
                let apart = self.sheet.placed().distance([a, b]);
                let place = self.sheet.place();
                self.found.note(&self.sheet.pieces, [a, b], apart, place);
            }
        }
        measured
    }

    /// Adds the pairs of pieces of a pair of faces.
    fn take(&mut self, faces: [FaceId; 2], time: Tick) {
        let [first, second] = self.sheet.load(faces);
        for a in first {
            for b in second.clone() {
                self.add([a, b], time);
            }
        }
    }

    fn query_pieces(&mut self, index: u32, pair: &Pair) -> QueryOutcome {
        let nodes = pair.nodes;
        let spheres = nodes.map(|node| self.sheet.sphere(node));
        let apart = spheres[0].distance(&spheres[1]);
        let counts = matches!(pair.kind, Kind::Pieces);
        let deviation = self.deviation;
        let comoving = self.comoving_until(nodes);
        let far = apart > deviation + MEASURE_RATIO * spheres[0].radius.min(spheres[1].radius);
        if self.options.skip_bounds && far && (apart >= self.best() || !counts) {
            self.found.counts.skipped_bounds += 1;
            if let Some(until) = comoving {
                return self.next(until, apart, false);
            }
            if let Some(outcome) = self.by_lattice(index, apart - deviation, counts) {
                return outcome;
            }
            let pair = &mut self.queue[index];
            let chain = self.approach.chain_within(&self.sheet, pair, apart);
            let members = (nodes, spheres);
            self.approach
                .gather_spheres(&mut self.sheet, &chain, members);
            let allowance = apart - deviation - 2.0 * chain.tear;
            return self.after(apart, allowance, counts);
        }
        self.found.counts.tested += 1;
        self.sheet.put(nodes);
        let placed = self.sheet.placed();
        let apart = match placed.solids(nodes) {
            Some([a, b]) => a.separation(&b),
            None => placed.distance(nodes),
        };
        let allowed = self.allowed(pair);
        if deviation > 0.0 && apart <= deviation + allowed.largest() {
            return QueryOutcome::Undecided;
        }
        if let Some(depth) = self.crosses(index, pair, apart) {
            return QueryOutcome::Crossing(depth);
        }
        if counts && apart <= self.found.best() {
            let place = self.sheet.place();
            let apart = if self.sheet.pieces.are_solid() {
                self.sheet.placed().distance(nodes)
            } else {
                apart
            };
            self.found.note(&self.sheet.pieces, nodes, apart, place);
        }
        if let Some(until) = comoving {
            return self.next(until, apart, false);
        }
        if let Some(outcome) = self.by_lattice(index, apart - deviation, counts) {
            return outcome;
        }
        let room = apart - deviation + self.left_of(allowed, nodes, apart);
        let pair = &mut self.queue[index];
        let chain = self.approach.chain_within(&self.sheet, pair, room);
        self.approach.gather_corners(&mut self.sheet, &chain, nodes);
        let outcome = self.after(apart, room - 2.0 * chain.tear, counts);
        self.at_contact(index, allowed, [apart, room], outcome)
    }

    fn query_sectors(&mut self, index: u32, pair: &Pair, corners: [u32; 2]) -> QueryOutcome {
        self.found.counts.tested += 1;
        self.sheet.put(pair.nodes);
        let [angle, reach] = self.between_sectors(pair.nodes, corners);
        let allowed = self.allowed(pair);
        if self.turn > 0.0 && angle <= self.turn || self.is_split(pair) {
            return QueryOutcome::Undecided;
        }
        if let Some(depth) = self.crosses(index, pair, angle * reach) {
            return QueryOutcome::Crossing(depth);
        }
        if let Some(until) = self.comoving_until(pair.nodes) {
            return self.next(until, angle, false);
        }
        let turn = angle + allowed.largest() / reach;
        let left = self.sheet.placed().left(pair.nodes, angle, turn, allowed);
        let room = angle - self.turn + left / reach;
        let pair = &mut self.queue[index];
        let chain = self.approach.chain_within(&self.sheet, pair, room);
        self.approach.gather_turns(&chain);
        let outcome = self.after(angle, room - 2.0 * chain.turn, false);
        self.at_contact(index, allowed, [angle * reach, room], outcome)
    }

    /// Returns the angle (radians) between the sectors of two placed pieces at their common vertex, and the distance from
    /// the vertex up to which both pieces reach.
    pub(super) fn between_sectors(&self, nodes: [u32; 2], corners: [u32; 2]) -> [f64; 2] {
        let placed = self.sheet.placed();
        let faces = nodes.map(|node| placed.piece(node));
        if let Some([a, b]) = placed.solids(nodes) {
            let angle = a.angle(&b, corners);
            let away = |k: usize, points: &[Vector3<f64>]| {
                let apex = faces[k].corners[corners[k] as usize];
                let away = points.iter().map(|point| (point - apex).norm());
                away.fold(0.0, f64::max)
            };
            return [angle, away(0, a.points).min(away(1, b.points))];
        }
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

    /// Returns the smallest distance that is used to tell that others do not matter: along a lattice the smallest so far, and
    /// otherwise the smallest before the stretch.
    fn best(&self) -> f64 {
        if self.along_lattice {
            self.found.best()
        } else {
            self.best
        }
    }

    /// Returns the time until which two pieces keep their positions relative to each other, if they do for a while.
    pub(super) fn comoving_until(&self, nodes: [u32; 2]) -> Option<Tick> {
        let known = self.options.skip_motion;
        known
            .then(|| self.comoving.until(self.sheet.faces(nodes)))
            .flatten()
    }

    /// Returns the next query of a pair of pieces that are `apart`, by the bounds of the lattice; `None` if
    /// there is no lattice, or its bounds allow no step.
    fn by_lattice(&self, index: u32, apart: f64, counts: bool) -> Option<QueryOutcome> {
        if self.sheet.is_at_end() {
            return Some(QueryOutcome::Free);
        }
        let PlacedPieces {
            source,
            motion,
            time,
            ..
        } = &self.sheet;
        let until = source.until(motion, *time, self.faces(index), apart)?;
        Some(self.until(until, apart, counts))
    }

    /// Returns the next query of members that are `apart` until a time, given a bound on their approach until then.
    fn until(&self, (until, moved): (Tick, f64), apart: f64, counts: bool) -> QueryOutcome {
        if !self.options.skip_motion {
            return QueryOutcome::Until(until.min(self.next_tabulated()));
        }
        if until == self.sheet.motion.end() && (!counts || apart - moved >= self.best()) {
            return QueryOutcome::Free;
        }
        QueryOutcome::Until(until)
    }

    /// Returns the next query of a pair of pieces that are `apart` and may approach each other by `allowance`.
    pub(super) fn after(&self, apart: f64, allowance: f64, counts: bool) -> QueryOutcome {
        if self.sheet.is_at_end() {
            return QueryOutcome::Free;
        }
        let (motion, time) = (&self.sheet.motion, self.sheet.time);
        let levers = &self.approach.levers;
        let until = motion.tabulated_until(levers, time, allowance);
        let until = until.unwrap_or_else(|| motion.until(levers, time, allowance));
        self.next(until, apart, counts)
    }

    /// Returns the next query of a pair that is free until some time. A pair that is free to the end is queried
    /// there only if it may be the nearest pair at the end.
    pub(super) fn next(&self, until: Tick, apart: f64, counts: bool) -> QueryOutcome {
        let (motion, time) = (&self.sheet.motion, self.sheet.time);
        let until = if self.options.skip_motion {
            until
        } else {
            until.min(self.next_tabulated())
        };
        let levers = &self.approach.levers;
        let moved = || motion.moved(levers, until) - motion.moved(levers, time);
        let free = until == motion.end() && self.options.skip_motion;
        if free && (!counts || apart - moved() >= self.best()) {
            return QueryOutcome::Free;
        }
        QueryOutcome::Until(until)
    }

    fn next_tabulated(&self) -> Tick {
        self.sheet.motion.next_tabulated(self.sheet.time)
    }
}
