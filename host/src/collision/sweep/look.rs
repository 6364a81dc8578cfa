//! Narrow phase of a sweep: queries pairs for their distance at a time, and for how long they stay apart.

use super::{Kind, Look, Pair, Place, Sweep, place};
use crate::collision::cells::AHEAD;
use crate::collision::chains::Chain;
use crate::collision::contact::{Change, Parted, Turn, parted};
use crate::collision::hierarchy::Sphere;
use crate::collision::layers::heights;
use crate::collision::motion::{Motion, Tick};
use crate::collision::pieces::Pieces;
use crate::collision::separation::{Sector, distance};
use crate::collision::sheet::Axis;
use crate::collision::sweep::Clearance;
use crate::pattern::FaceId;

/// Ratio of the distance of two clusters to the larger one's radius up to which the clusters are split.
const NEAR: f64 = 0.5;
/// Ratio of the distance of two pieces' spheres to the smaller one's radius up to which the pieces are measured
/// exactly.
const CLOSE: f64 = 0.5;
/// Number of tabulated times over which pairs represented by their cells have to stay apart.
const LEAP: usize = 1;
/// Number of tabulated times over which such pairs have to stay apart if they may be the nearest of all.
const FOLLOWED: usize = 6;
/// Distance in tolerances up to which pairs are treated as touching: a plane then allows a step of the square
/// root of a tolerance.
const CONTACT: f64 = 1e3;

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
        self.sheet
            .sphere(motion, &self.pieces, &self.hierarchy, node)
    }

    pub(super) fn look(&mut self, motion: &Motion, index: u32) -> Look {
        let pair = self.pairs[index as usize].clone();
        self.pairs[index as usize].above = None;
        let nodes = pair.nodes;
        match pair.kind {
            Kind::Clusters => self.look_at_clusters(motion, index, &pair),
            Kind::Far => self.look_far(motion),
            Kind::Interval => self.look_ahead(motion),
            Kind::Cells(offset) => self.look_at_cells(motion, offset),
            Kind::Pieces | Kind::Meeting => self.look_at_pieces(motion, index, &pair),
            Kind::Vertex(corners) => self.look_at_sectors(motion, index, &pair, corners),
            Kind::Joined => {
                self.counts.tested += 1;
                match self.depth(motion, nodes) {
                    depth if depth > 0.0 => Look::Crossing(depth),
                    _ if self.sheet.time == motion.end() => Look::Free,
                    _ => Look::Until(motion.next_tabulated(self.sheet.time)),
                }
            }
        }
    }

    fn look_at_clusters(&mut self, motion: &Motion, index: u32, pair: &Pair) -> Look {
        let [a, b] = pair.nodes;
        if a == b || !self.options.skip_bounds {
            return Look::Part;
        }
        let spheres = [a, b].map(|node| self.sphere(motion, node));
        let distance = spheres[0].distance(&spheres[1]);
        if distance <= NEAR * spheres[0].radius.max(spheres[1].radius) {
            return Look::Part;
        }
        let nodes = [a, b].map(|node| self.hierarchy.nodes[node as usize]);
        let chain = self.chain(index);
        self.gather(motion, &chain, |side, axis| {
            axis.distance(&spheres[side].center) + spheres[side].radius
        });
        for node in [a, b] {
            self.levers.any += self.spread(motion, node);
        }
        let time = self.sheet.time;
        let until = motion.tabulated_until(&self.levers, time, distance);
        let look = match until {
            Some(until) => self.next(motion, until, distance, true),
            None if time == motion.end() => Look::Free,
            None => return Look::Part,
        };
        self.counts.skipped_bounds += u64::from(nodes[0].pieces) * u64::from(nodes[1].pieces);
        look
    }

    /// Runs the broad phase over the next interval: adds the pieces that may meet before its end, and finds the
    /// nearest pieces at its end.
    fn look_ahead(&mut self, motion: &Motion) -> Look {
        let time = self.sheet.time;
        if time > 0 && time == motion.end() {
            return Look::Free;
        }
        if self.watch.is_over() {
            return Look::Unsure;
        }
        let Some(mut course) = self.course.take() else {
            return Look::Free;
        };
        let before = course.from;
        if time == motion.end() || !course.advance(motion, &self.pieces, &self.hierarchy) {
            // Chains of creases give better bounds than the long sums of the broad phase.
            self.course = Some(course);
            self.add_roots(time);
            return Look::Part;
        }
        let touching = self.tolerance(Kind::Pieces);
        let (pieces, hierarchy) = (&self.pieces, &self.hierarchy);
        let mut nearest = self.clearance;
        let best = |nearest: &Option<Clearance>| nearest.map_or(f64::INFINITY, |n| n.distance);
        let (mut tested, mut unseen) = (0, Vec::new());
        // The beginning of an interval is the end of the one before.
        let ends = [(0, course.from), (2, course.to)];
        let ends = if time == 0 {
            &ends[..]
        } else if motion.tabulated(course.to).is_some() {
            &ends[1..]
        } else {
            &[]
        };
        course.near(hierarchy, touching, best(&nearest), |course, pair| {
            if pieces.comparable(pair[0], pair[1]).is_none() || pieces.meet(pair[0], pair[1]) {
                return best(&nearest);
            }
            tested += 1;
            let apart = course.parted(pieces, pair, touching).unwrap_or_else(|| {
                unseen.push(pair);
                [0.0; 3]
            });
            for &(end, tick) in ends {
                if apart[end] >= best(&nearest) {
                    continue;
                }
                let distance = course.distance(pieces, pair, end);
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
        let [from, to] = [course.from, course.to];
        self.course = Some(course);
        for pair in unseen {
            self.add_unseen(pair, [before, from, to]);
        }
        self.push([0, 0], Kind::Interval, None, to);
        Look::Part
    }

    /// Wakes cells that come near each other soon.
    fn look_far(&mut self, motion: &Motion) -> Look {
        let (time, best, astray) = (self.sheet.time, self.best(), self.astray());
        let touching = self.options.tolerance * self.pattern.median_edge();
        let Some(cells) = &mut self.sheet.cells else {
            return Look::Free;
        };
        // As long as no distance is known, cells within a growing distance are woken.
        if best == f64::INFINITY {
            self.far = 2.0 * self.far + self.pattern.median_edge() / 2.0;
        }
        let near = astray + touching.max(self.far.min(best));
        let skips = self.options.skip_bounds && self.options.skip_motion;
        let near = if skips { near } else { f64::INFINITY };
        let Some(woken) = cells.wake(motion, time, near) else {
            return Look::Unsure;
        };
        let is_last = woken.is_empty() && (best.is_finite() || cells.are_all_awake());
        for offset in woken {
            self.push([0, 0], Kind::Cells(offset), None, time);
        }
        if !is_last {
            Look::Again
        } else if time == motion.end() {
            Look::Free
        } else {
            Look::Until(motion.tabulated_after(time, AHEAD))
        }
    }

    fn look_at_cells(&mut self, motion: &Motion, offset: u32) -> Look {
        let (time, best) = (self.sheet.time, self.best());
        let (bounds, astray) = (self.options.skip_bounds, self.astray());
        let touching = self.options.tolerance * self.pattern.median_edge();
        let Some(cells) = &mut self.sheet.cells else {
            return Look::Free;
        };
        let apart = cells.gap_of(motion, time, offset);
        if bounds && apart > touching && apart >= best {
            let until = cells.until(motion, time, offset, apart - astray);
            if until.map_or(time, |(until, _)| until) >= motion.tabulated_after(time, LEAP) {
                self.counts.skipped_bounds += cells.left(offset);
                return self.after_cells(motion, apart, until);
            }
        }
        let near = if bounds {
            let leap = astray + cells.moved(motion, time, LEAP, offset);
            let far = astray + cells.moved(motion, time, FOLLOWED, offset);
            leap.max(touching).max(far.min(best))
        } else {
            f64::INFINITY
        };
        let found = cells.apart(motion, time, offset, [near, best]);
        if !found.near.is_empty() {
            self.take(&found.near, time);
            return Look::Again;
        }
        let mut measured = 0;
        for faces in found.nearest {
            measured += self.measure(motion, faces);
        }
        let Some(cells) = &self.sheet.cells else {
            return Look::Free;
        };
        let until = cells.until(motion, time, offset, found.least - astray);
        self.counts.skipped_bounds += cells.left(offset).saturating_sub(measured);
        self.after_cells(motion, found.least, until)
    }

    /// Returns the next query of cells that are `apart`, given the time until which they stay apart and their
    /// motion until then.
    fn after_cells(&self, motion: &Motion, apart: f64, until: Option<(Tick, f64)>) -> Look {
        match until {
            None => Look::Free,
            Some((until, _)) if !self.options.skip_motion => {
                Look::Until(until.min(motion.next_tabulated(self.sheet.time)))
            }
            Some((until, moved)) if until == motion.end() && apart - moved >= self.best() => {
                Look::Free
            }
            Some((until, _)) => Look::Until(until),
        }
    }

    /// Measures the distance of two faces, which may be the smallest; returns the number of pairs of pieces
    /// measured.
    fn measure(&mut self, motion: &Motion, faces: [FaceId; 2]) -> u64 {
        let [first, second] = faces.map(|face| self.load(face));
        let mut measured = 0;
        for a in first {
            for b in second.clone() {
                measured += 1;
                self.counts.tested += 1;
                self.put(motion, [a, b], false);
                let placed = self.sheet.placed(&self.pieces);
                self.note(motion, [a, b], distance(&placed.piece(a), &placed.piece(b)));
            }
        }
        measured
    }

    /// Stores a distance if it is smaller than all before.
    fn note(&mut self, motion: &Motion, nodes: [u32; 2], distance: f64) {
        if distance < self.best() {
            let at = place(motion, self.sheet.time);
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

    fn look_at_pieces(&mut self, motion: &Motion, index: u32, pair: &Pair) -> Look {
        let [a, b] = pair.nodes;
        let spheres = [a, b].map(|node| self.sphere(motion, node));
        let apart = spheres[0].distance(&spheres[1]);
        let best = self.best();
        let counts = pair.kind == Kind::Pieces;
        let astray = self.astray();
        let together = self.together_until(motion, pair.nodes);
        let far = apart > astray + CLOSE * spheres[0].radius.min(spheres[1].radius);
        if self.options.skip_bounds && far && (apart >= best || !counts) {
            self.counts.skipped_bounds += 1;
            if let Some(until) = together {
                return self.next(motion, until, apart, false);
            }
            if let Some(look) = self.along_lattice(motion, index, apart - astray, counts) {
                return look;
            }
            let chain = self.chain(index);
            self.gather(motion, &chain, |side, axis| {
                axis.distance(&spheres[side].center) + spheres[side].radius
            });
            return self.after(motion, apart, apart - astray, counts);
        }
        self.counts.tested += 1;
        self.put(motion, [a, b], false);
        let placed = self.sheet.placed(&self.pieces);
        let apart = distance(&placed.piece(a), &placed.piece(b));
        let tolerance = self.tolerance(pair.kind);
        if astray > 0.0 && apart <= astray + tolerance {
            return Look::Unsure;
        }
        if let Some(depth) = self.crosses(motion, index, pair, apart) {
            return Look::Crossing(depth);
        }
        if counts {
            self.note(motion, [a, b], apart);
        }
        if let Some(until) = together {
            return self.next(motion, until, apart, false);
        }
        if let Some(look) = self.along_lattice(motion, index, apart - astray, counts) {
            return look;
        }
        let chain = self.chain(index);
        self.gather_corners(motion, &chain, [a, b]);
        let look = self.after(motion, apart, apart - astray + tolerance, counts);
        self.at_contact(motion, index, pair.kind, apart, look)
    }

    fn look_at_sectors(
        &mut self,
        motion: &Motion,
        index: u32,
        pair: &Pair,
        corners: [u32; 2],
    ) -> Look {
        let [a, b] = pair.nodes;
        self.counts.tested += 1;
        self.put(motion, [a, b], false);
        let placed = self.sheet.placed(&self.pieces);
        let faces = [placed.piece(a), placed.piece(b)];
        let sectors: [Sector; 2] =
            core::array::from_fn(|k| Sector::of(&faces[k], corners[k] as usize));
        let reach = |k: usize| {
            let apex = faces[k].corners[corners[k] as usize];
            let away = faces[k].corners.iter().map(|corner| (corner - apex).norm());
            away.fold(0.0, f64::max)
        };
        let reach = reach(0).min(reach(1));
        let angle = sectors[0].separation(&sectors[1]);
        let tolerance = self.tolerance(pair.kind);
        if let Some(depth) = self.crosses(motion, index, pair, angle * reach) {
            return Look::Crossing(depth);
        }
        if let Some(until) = self.together_until(motion, pair.nodes) {
            return self.next(motion, until, angle, false);
        }
        self.levers.clear();
        // Pairs of creases do not turn the part beyond them.
        let chain = self.chain(index);
        for link in self.chains.singles(&chain) {
            self.levers.add(link.group, 1.0);
        }
        let look = self.after(motion, angle, angle + tolerance / reach, false);
        self.at_contact(motion, index, pair.kind, angle * reach, look)
    }

    /// Returns the depth to which two placed pieces cross. Pieces that lay flat on each other also cross if
    /// they have left through each other, that is, if each is on the other side of the other than it came from;
    /// the depth is then their larger height. While pieces lie flat on each other, stores the sides that they
    /// came from.
    fn crosses(&mut self, motion: &Motion, index: u32, pair: &Pair, apart: f64) -> Option<f64> {
        let (nodes, tolerance) = (pair.nodes, self.tolerance(pair.kind));
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
            let time = self.sheet.time;
            let came = self.came_from(motion, nodes, [pair.last?, time], tolerance);
            self.sheet.time = time;
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
        nodes: [u32; 2],
        [mut from, mut to]: [Tick; 2],
        tolerance: f64,
    ) -> Option<[bool; 2]> {
        let mut time = from;
        loop {
            self.sheet.time = time;
            self.put(motion, nodes, false);
            match self.heights(nodes, tolerance) {
                Some(heights) if heights.iter().all(|h| h.abs() > tolerance) => {
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
        let placed = self.sheet.placed(&self.pieces);
        let [a, b] = nodes.map(|node| placed.piece(node));
        heights(&a, &b, tolerance)
    }

    /// Returns the next query of a pair that nearly touches: a later one, if a plane separates the pair for
    /// longer.
    fn at_contact(
        &mut self,
        motion: &Motion,
        index: u32,
        kind: Kind,
        apart: f64,
        look: Look,
    ) -> Look {
        let (time, tolerance) = (self.sheet.time, self.tolerance(kind));
        let next = motion.next_tabulated(time);
        let Look::Until(until) = look else {
            return look;
        };
        if until >= next || apart > CONTACT * tolerance {
            return look;
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
        Look::Until(reached)
    }

    /// Returns the planes that separate two pieces.
    fn parted(&mut self, motion: &Motion, index: u32, tolerance: f64) -> Vec<Parted> {
        let (chain, nodes) = (self.chain(index), self.pairs[index as usize].nodes);
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
            let axis = self.sheet.axis(motion, crease);
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
        let placed = self.sheet.placed(&self.pieces);
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

    /// Returns the depth up to which an overlap of such a pair is contact, units of the sheet.
    pub(super) fn tolerance(&self, kind: Kind) -> f64 {
        let gap = match kind {
            Kind::Meeting | Kind::Vertex(_) | Kind::Joined => self.options.gap,
            Kind::Pieces => self.options.rounding,
            Kind::Clusters | Kind::Interval | Kind::Far | Kind::Cells(_) => 0.0,
        };
        (self.options.tolerance + gap) * self.pattern.median_edge()
    }

    fn best(&self) -> f64 {
        let best = self.clearance.map(|clearance| clearance.distance);
        best.unwrap_or(f64::INFINITY)
    }

    fn put(&mut self, motion: &Motion, nodes: [u32; 2], joined: bool) {
        for node in nodes {
            self.sheet.put(motion, &self.pieces, node, joined);
        }
    }

    /// Returns the depth to which two pieces cross.
    pub(super) fn depth(&mut self, motion: &Motion, [a, b]: [u32; 2]) -> f64 {
        for piece in [a, b] {
            self.pieces.join(self.pattern, piece);
        }
        if self.sheet.cells.is_some() {
            self.hierarchy.extend(&self.pieces);
        }
        self.put(motion, [a, b], true);
        let tolerance = self.options.tolerance * self.pattern.median_edge();
        self.sheet.placed(&self.pieces).depth(a, b, tolerance)
    }

    /// Sums up the levers of a chain of creases. The lever of a crease is its distance from one end of the
    /// chain (0 or 1), as `reach` returns it: from the first end for creases up to some crease, from the second
    /// end for the others.
    fn gather(&mut self, motion: &Motion, chain: &Chain, reach: impl Fn(usize, &Axis) -> f64) {
        self.levers.clear();
        let sheet = &mut self.sheet;
        for link in self.chains.pairs(chain) {
            self.levers.add(link.group, sheet.width(motion, link));
        }
        let singles = self.chains.singles(chain);
        let Some(last) = singles.len().checked_sub(1) else {
            return;
        };
        let mut lever =
            |side: usize, k: usize| reach(side, &sheet.axis(motion, singles[k].creases[0]));
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
        if let Some(spread) = self.sheet.spread_of(node) {
            return spread;
        }
        let mut spread = 0.0_f64;
        for (side, child) in children.into_iter().enumerate() {
            let mut sum = self.spread(motion, child);
            let sphere = self.sphere(motion, child);
            let chain = &self.within[node as usize][side];
            for link in self.chains.pairs(chain) {
                sum += self.sheet.width(motion, link);
            }
            for link in self.chains.singles(chain) {
                let axis = self.sheet.axis(motion, link.creases[0]);
                sum += axis.distance(&sphere.center) + sphere.radius;
            }
            spread = spread.max(sum);
        }
        self.sheet.set_spread(node, spread);
        spread
    }

    /// Sums up the levers of a chain between two placed pieces, from the distances of their corners.
    fn gather_corners(&mut self, motion: &Motion, chain: &Chain, nodes: [u32; 2]) {
        let ranges = nodes.map(|node| self.pieces.list[node as usize].corners());
        let corners = ranges.map(|range| self.sheet.corners(range).to_vec());
        self.gather(motion, chain, |side, axis| {
            let away = corners[side].iter().map(|corner| axis.distance(corner));
            away.fold(0.0, f64::max)
        });
    }

    /// Returns the next query of a pair of pieces that are `apart`, by the bounds of the lattice; `None` if
    /// there is no lattice, or its bounds allow no step.
    fn along_lattice(&self, motion: &Motion, index: u32, apart: f64, counts: bool) -> Option<Look> {
        let time = self.sheet.time;
        if time == motion.end() {
            return Some(Look::Free);
        }
        let cells = self.sheet.cells.as_ref()?;
        let (until, moved) = cells.until_of(motion, time, self.faces(index), apart)?;
        if !self.options.skip_motion {
            return Some(Look::Until(until.min(motion.next_tabulated(time))));
        }
        let free = until == motion.end() && (!counts || apart - moved >= self.best());
        Some(if free { Look::Free } else { Look::Until(until) })
    }

    /// Returns the next query of a pair of pieces that are `apart` and may approach each other by `allowance`.
    fn after(&self, motion: &Motion, apart: f64, allowance: f64, counts: bool) -> Look {
        let time = self.sheet.time;
        if time == motion.end() {
            return Look::Free;
        }
        let until = motion.tabulated_until(&self.levers, time, allowance);
        let until = until.unwrap_or_else(|| motion.until(&self.levers, time, allowance));
        self.next(motion, until, apart, counts)
    }

    /// Returns the next query of a pair that is free until some time. A pair that is free to the end is queried
    /// there only if it may be the nearest pair at the end.
    fn next(&self, motion: &Motion, until: Tick, apart: f64, counts: bool) -> Look {
        let time = self.sheet.time;
        let until = if self.options.skip_motion {
            until
        } else {
            until.min(motion.next_tabulated(time))
        };
        let moved = || motion.moved(&self.levers, until) - motion.moved(&self.levers, time);
        let free = until == motion.end() && self.options.skip_motion;
        if free && (!counts || apart - moved() >= self.best()) {
            return Look::Free;
        }
        Look::Until(until)
    }
}
