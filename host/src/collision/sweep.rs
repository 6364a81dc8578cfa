//! Whether faces pass through each other anywhere on a motion.
//!
//! Conservative advancement (B. Mirtich, "Impulse-based dynamic simulation of rigid body systems", 1996,
//! 2.3): two faces at a distance need no look until they may have come so far. Differs from the source
//! in the bound on their motion. Between two faces lies a chain of creases. Turn one of them alone, and
//! points of the faces come closer by no more than the angle times the distance of either point from the
//! crease; turn all of them one after the other, from the middle of the chain outwards, and these are
//! distances where the sheet is now. So a pair is free until the sum over its chain of variation of
//! angle times distance has used up its distance: whatever the motion does in between, as long as the
//! sheet closes.
//!
//! Where two faces share a vertex their distance is 0, but they lie in sectors round it, and cross only
//! if the arcs of the sectors on the unit sphere do: there the same holds for angles.
//!
//! Clusters of faces stand for all their pairs while they are far apart. Two creases of a chain that turn
//! by opposite angles about parallel lines count together, as far as they are apart.

use core::f64::consts::PI;
use std::collections::BTreeMap;
use std::time::Instant;

use foldpath_core::{Curve, Membership};

use super::cells::Cells;
use super::chains::{Chain, Chains};
use super::contact::{Change, Parted, Turn, parted};
use super::hierarchy::{Hierarchy, Sphere};
use super::motion::{Levers, Motion, Tick};
use super::pieces::{CROSSING, Pieces};
use super::scene::Crossing;
use super::separation::{Sector, distance};
use super::sheet::Sheet;
use crate::pattern::{CreasePattern, FaceId, VertexId};
use crate::symmetry::Lattice;

/// Clusters nearer to each other than this part of the larger one's radius are parted.
const NEAR: f64 = 0.5;
/// Pieces nearer to each other, by their spheres, than this part of the smaller one's radius are
/// measured exactly.
const CLOSE: f64 = 1.0;
/// Tabulated times over which pairs are to stay apart for which cells stand.
const LEAP: usize = 1;
/// The same for pairs that may be the nearest of all.
const FOLLOWED: usize = 3;
/// Pairs that are apart by no more than so many tolerances are looked at as touching: the square root of
/// a tolerance is the step that a plane then allows.
const CONTACT: f64 = 1e3;
/// Looks between two glances at the clock.
const CLOCK: u64 = 256;
/// The last free place is found to this part of a segment: 2^-20.
const LAST_FREE: Tick = 1 << 16;
/// The same for hinges that turn past half a turn.
const OVERTURNED: f64 = 1e-6;

/// Options of a [`Sweep`].
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SweepOptions {
    /// A crossing deeper than this part of the median edge counts; what is less is contact.
    pub tolerance: f64,
    /// Largest gap (over the median edge) that the motion tears into the sheet: pairs that meet in a
    /// vertex may cross by as much more. Where it tears, the bounds on motion hold up to the gaps along
    /// the chains of faces.
    pub gap: f64,
    /// How far (over the median edge) a face may be, as seen from any other, from where the lattice has it
    /// if the motion tears the sheet. Faces without a common vertex that come so near to each other are
    /// not decided along the lattice.
    pub astray: f64,
    /// Pairs are passed over while their motion cannot bring them together. Without, each is looked at at
    /// every tabulated time.
    pub skip_motion: bool,
    /// Pairs are passed over, and clusters of them together, where bounding spheres are apart.
    pub skip_bounds: bool,
    /// Pairs joined by an edge are never looked at.
    pub skip_edges: bool,
    /// Looks at pairs until the answer is [`SweepVerdict::Undecided`].
    pub max_looks: u64,
    /// When to give up likewise.
    pub deadline: Option<Instant>,
}

impl Default for SweepOptions {
    fn default() -> Self {
        Self {
            tolerance: CROSSING,
            gap: 0.0,
            astray: 0.0,
            skip_motion: true,
            skip_bounds: true,
            skip_edges: true,
            max_looks: 10_000_000,
            deadline: None,
        }
    }
}

/// A place on a motion.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Place {
    /// The segment, from 0.
    pub segment: usize,
    /// Where in it, 0 to 1.
    pub s: f64,
}

impl Place {
    /// Whether a motion that has another verdict goes on until here.
    fn is_before(&self, verdict: &SweepVerdict) -> bool {
        match verdict {
            SweepVerdict::Free(_) => true,
            SweepVerdict::Crossing { at, .. } | SweepVerdict::Undecided { at, .. } => {
                (self.segment, self.s) < (at.segment, at.s)
            }
        }
    }
}

/// The smallest distance found between two faces that share no vertex.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Clearance {
    /// In the units of the sheet.
    pub distance: f64,
    /// The faces, the smaller first.
    pub faces: [FaceId; 2],
    /// Where on the motion.
    pub place: Place,
}

/// What a sweep found.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum SweepVerdict {
    /// No pair passes through each other, but for twice the tolerance. The clearance is the smallest
    /// distance at any time that was looked at, and the smallest of all at the end of the motion; `None` if
    /// all faces share vertices.
    Free(Option<Clearance>),
    /// A pair passes through each other.
    Crossing {
        /// The faces, and how deep they cross at that place.
        crossing: Crossing,
        /// The first place found where they do.
        at: Place,
        /// A place up to which no pair crosses; `None` if some do from the beginning.
        last_free: Option<Place>,
    },
    /// The budget is spent, or the motion is not finite.
    Undecided {
        /// The pair that was looked at last, if any.
        faces: Option<[FaceId; 2]>,
        /// No pair crosses up to here.
        at: Place,
    },
}

/// What a sweep looked at, and what it did not need to: `pairs` is the sum of all others.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct SweepCounts {
    /// Pairs of pieces of the same sheet, times the configurations at which any pair was looked at.
    pub pairs: u64,
    /// Looks that measured a distance or a depth.
    pub tested: u64,
    /// Pairs for which another stood that moves alike.
    pub skipped_symmetry: u64,
    /// Pairs that could not have come together since their last look.
    pub skipped_motion: u64,
    /// Pairs whose bounding spheres, or those of clusters that hold them, were apart.
    pub skipped_bounds: u64,
    /// Pairs joined by an edge.
    pub skipped_edges: u64,
}

/// Two clusters, or two pieces, to look at again.
#[derive(Clone, Debug)]
struct Pair {
    nodes: [u32; 2],
    kind: Kind,
    /// The creases between, once they were asked for.
    chain: Option<Chain>,
    /// When it was last looked at.
    last: Option<Tick>,
}

#[derive(Clone, Copy, Debug, PartialEq)]
enum Kind {
    Clusters,
    /// Cells whose difference has this number.
    Cells(u32),
    Pieces,
    /// Pieces that meet in a place of the flat sheet, as on both sides of a cut.
    Meeting,
    /// Pieces that share a vertex: positions of their corners there.
    Vertex([u32; 2]),
    Joined,
}

/// A look at a pair.
enum Look {
    /// Free up to this time.
    Until(Tick),
    /// Free to the end.
    Free,
    /// Crossing this deep.
    Crossing(f64),
    /// Too near to say on a torn sheet.
    Unsure,
    /// To be parted.
    Part,
    /// To be looked at again after the pairs taken from it.
    Again,
}

/// A sheet whose motions are swept for crossings.
#[derive(Clone, Debug)]
pub struct Sweep<'a> {
    pattern: &'a CreasePattern,
    memberships: Vec<Membership>,
    groups: usize,
    options: SweepOptions,
    pieces: Pieces,
    hierarchy: Hierarchy,
    sheet: Sheet<'a>,
    chains: Chains,
    /// For each cluster the chains from its face to those of its children, and their length in the list.
    within: Vec<[Chain; 2]>,
    kept: usize,
    levers: Levers,
    turns: Vec<Turn>,
    changes: Vec<Change>,
    pairs: Vec<Pair>,
    due: BTreeMap<Tick, Vec<u32>>,
    clearance: Option<Clearance>,
    counts: SweepCounts,
    looks: u64,
    /// Pairs found joined.
    joined: u64,
}

impl<'a> Sweep<'a> {
    /// For each crease of the pattern its group and sign; creases without stay flat. Cost: about
    /// O(faces log faces).
    #[must_use]
    pub fn new(
        pattern: &'a CreasePattern,
        memberships: &[Membership],
        options: SweepOptions,
    ) -> Self {
        Self::build(pattern, memberships, options, None)
    }

    /// The same for a sheet that closes all along its motions, with its lattice found for the same
    /// memberships: one pair of faces stands for all that move alike. Cost: O(faces + classes of pairs).
    #[must_use]
    pub fn with_lattice(
        pattern: &'a CreasePattern,
        memberships: &[Membership],
        options: SweepOptions,
        lattice: &'a Lattice,
    ) -> Self {
        Self::build(pattern, memberships, options, Some(lattice))
    }

    fn build(
        pattern: &'a CreasePattern,
        memberships: &[Membership],
        options: SweepOptions,
        lattice: Option<&'a Lattice>,
    ) -> Self {
        let pieces = Pieces::new(pattern);
        let hierarchy = match lattice {
            Some(_) => Hierarchy::leaves(&pieces),
            None => Hierarchy::new(&pieces),
        };
        let groups = memberships.iter().map(|m| m.group.index() + 1);
        let groups = groups.max().unwrap_or_default();
        let cells =
            lattice.map(|lattice| Cells::new(pattern, memberships, groups, &pieces, lattice));
        let mut chains = Chains::new(pattern, memberships, lattice.is_some());
        let within = hierarchy.nodes.iter().map(|node| {
            let children = node.children.unwrap_or_default();
            children.map(|child| {
                let faces = [node.face, hierarchy.nodes[child as usize].face];
                let chain = node
                    .children
                    .and_then(|_| chains.find(pattern, faces, None));
                chain.unwrap_or_default()
            })
        });
        Self {
            pattern,
            memberships: memberships.to_vec(),
            groups,
            options,
            sheet: Sheet::new(pattern, memberships, groups, &pieces, &hierarchy, cells),
            within: within.collect(),
            kept: chains.len(),
            chains,
            levers: Levers::new(groups),
            turns: Vec::new(),
            changes: Vec::new(),
            pairs: Vec::new(),
            due: BTreeMap::new(),
            clearance: None,
            counts: SweepCounts::default(),
            looks: 0,
            joined: 0,
            pieces,
            hierarchy,
        }
    }

    /// What was looked at since the sheet was taken up.
    #[must_use]
    pub fn counts(&self) -> SweepCounts {
        self.counts
    }

    /// Sweeps a motion: for each segment a curve for each crease group.
    pub fn sweep(&mut self, segments: &[Vec<Curve<f64>>]) -> SweepVerdict {
        let motion = Motion::new(segments, self.groups);
        if !motion.is_finite() {
            let at = place(&motion, 0);
            return SweepVerdict::Undecided { faces: None, at };
        }
        (self.clearance, self.looks, self.joined) = (None, 0, 0);
        self.pairs.clear();
        self.due.clear();
        self.chains.truncate(self.kept);
        self.sheet.forget();
        let before = self.counts;
        if let Some(cells) = &mut self.sheet.cells {
            cells.begin(&motion);
            for offset in (0..).take(cells.offsets().len()) {
                self.push([0, 0], Kind::Cells(offset), None, 0);
            }
        }
        let roots = self.hierarchy.roots.clone();
        for root in roots {
            self.add([root, root], 0);
        }
        let mut times = 0;
        let verdict = loop {
            let Some((time, due)) = self.due.pop_first() else {
                break SweepVerdict::Free(self.clearance);
            };
            times += 1;
            if let Some(verdict) = self.look_at_all(&motion, time, due) {
                break verdict;
            }
        };
        self.count(times, before);
        match self.overturned(&motion) {
            Some((at, overturned)) if at.is_before(&verdict) => overturned,
            _ => verdict,
        }
    }

    /// The first hinge that turns past half a turn: so do the faces that it joins pass through each other.
    fn overturned(&self, motion: &Motion) -> Option<(Place, SweepVerdict)> {
        let (segment, s, group, angle) = motion.overturned(self.options.tolerance)?;
        let at = Place { segment, s };
        let creases = self.pattern.creases().iter().zip(&self.memberships);
        let edges = creases.filter(|(_, member)| member.group.index() == group);
        let mut edges = edges.map(|(&edge, _)| self.pattern.edge(edge));
        let (edge, faces) = edges.find_map(|edge| Some((edge, edge.inner_faces()?)))?;
        let [from, to] = edge.ends.map(|end| self.pattern.vertices()[end.index()]);
        let width = |face: FaceId| {
            let corners = self.pattern.faces()[face.index()].iter();
            let corners = corners.map(|v| self.pattern.vertices()[v.index()] - from);
            let away = corners.map(|corner| corner.perp(&(to - from)).abs());
            away.fold(0.0, f64::max) / (to - from).norm()
        };
        let depth = (angle.abs() - PI).sin().abs() * width(faces[0]).min(width(faces[1]));
        Some((
            at,
            SweepVerdict::Crossing {
                crossing: Crossing::new(faces, depth),
                at,
                last_free: (segment > 0 || s > 0.0).then_some(Place {
                    segment,
                    s: (s - OVERTURNED).max(0.0),
                }),
            },
        ))
    }

    /// Completes the counts after so many configurations.
    fn count(&mut self, times: u64, before: SweepCounts) {
        let [alike, joined] = self.pieces.count_pairs(self.pattern.sheets());
        let [looked_at, joined] = match &self.sheet.cells {
            Some(cells) => {
                let pairs = cells.offsets().iter().map(|offset| offset.pairs);
                [pairs.sum::<u64>().min(alike), self.joined]
            }
            None => [alike, joined],
        };
        let counts = &mut self.counts;
        counts.pairs += times * alike;
        counts.skipped_symmetry += times * (alike - looked_at);
        if self.options.skip_edges {
            counts.skipped_edges += times * joined;
        }
        let looked = |c: &SweepCounts| c.tested + c.skipped_bounds + c.skipped_edges;
        let looked = looked(counts) - looked(&before);
        counts.skipped_motion += (times * looked_at).saturating_sub(looked);
    }

    /// Looks at all pairs that are due.
    fn look_at_all(
        &mut self,
        motion: &Motion,
        time: Tick,
        mut due: Vec<u32>,
    ) -> Option<SweepVerdict> {
        self.sheet.time = time;
        let mut deepest: Option<(Crossing, u32)> = None;
        while let Some(index) = due.pop() {
            if self.is_spent() {
                return Some(self.undecided(motion, index, time));
            }
            let look = self.look(motion, index);
            match look {
                Look::Free => {}
                Look::Until(later) => {
                    self.pairs[index as usize].last = Some(time);
                    self.due.entry(later).or_default().push(index);
                }
                Look::Again => {
                    due.push(index);
                    due.extend(self.due.remove(&time).unwrap_or_default());
                }
                Look::Unsure => return Some(self.undecided(motion, index, time)),
                Look::Part => {
                    self.part(index, time);
                    due.extend(self.due.remove(&time).unwrap_or_default());
                }
                Look::Crossing(depth) => {
                    let crossing = Crossing::new(self.faces(index), depth);
                    if deepest.is_none_or(|(deepest, _)| crossing.exceeds(&deepest)) {
                        deepest = Some((crossing, index));
                    }
                }
            }
        }
        deepest.map(|(crossing, index)| self.first(motion, crossing, index, time))
    }

    fn undecided(&self, motion: &Motion, index: u32, time: Tick) -> SweepVerdict {
        SweepVerdict::Undecided {
            faces: Some(self.faces(index)),
            at: place(motion, time),
        }
    }

    /// How far faces may be off in the units of the sheet.
    fn astray(&self) -> f64 {
        match self.sheet.cells {
            Some(_) => self.options.astray * self.pattern.median_edge(),
            None => 0.0,
        }
    }

    fn is_spent(&mut self) -> bool {
        self.looks += 1;
        let late = |deadline| Instant::now() >= deadline;
        self.looks > self.options.max_looks
            || self.looks % CLOCK == 1 && self.options.deadline.is_some_and(late)
    }

    fn faces(&self, pair: u32) -> [FaceId; 2] {
        let nodes = self.pairs[pair as usize].nodes;
        nodes.map(|node| self.hierarchy.nodes[node as usize].face)
    }

    /// Adds a pair to look at.
    fn add(&mut self, nodes: [u32; 2], time: Tick) {
        if let Some((kind, chain)) = self.classify(nodes) {
            self.push(nodes, kind, chain, time);
        }
    }

    fn push(&mut self, nodes: [u32; 2], kind: Kind, chain: Option<Chain>, time: Tick) {
        let index = FaceId::new(self.pairs.len()).0;
        self.pairs.push(Pair {
            nodes,
            kind,
            chain,
            last: None,
        });
        self.due.entry(time).or_default().push(index);
    }

    /// What a pair is, and the creases between; `None` if it is never looked at.
    fn classify(&mut self, [a, b]: [u32; 2]) -> Option<(Kind, Option<Chain>)> {
        let nodes = [a, b].map(|node| self.hierarchy.nodes[node as usize]);
        let faces = nodes.map(|node| node.face);
        if a == b {
            return nodes[0].children.map(|_| (Kind::Clusters, None));
        }
        if nodes.iter().any(|node| node.children.is_some()) {
            let chain = self.chains.find(self.pattern, faces, None)?;
            return Some((Kind::Clusters, Some(chain)));
        }
        if faces[0] == faces[1] {
            return None;
        }
        let shared = self.shared(a, b);
        if self.pieces.joined(a, b) || shared.len() > 1 {
            self.joined += 1;
            // Two vertices shared are ends of a line that is a side of both: about it they turn.
            return (!self.options.skip_edges).then_some((Kind::Joined, None));
        }
        if let Some(&(vertex, corners)) = shared.first()
            && let Some(chain) = self.chains.find(self.pattern, faces, Some(vertex))
        {
            return Some((Kind::Vertex(corners), Some(chain)));
        }
        let kind = if self.pieces.meet(a, b) {
            Kind::Meeting
        } else {
            Kind::Pieces
        };
        // Along a lattice the chain is hardly ever needed.
        let chain = match &self.sheet.cells {
            Some(_) => None,
            None => Some(self.chains.find(self.pattern, faces, None)?),
        };
        Some((kind, chain))
    }

    /// The creases between the two of a pair.
    fn chain(&mut self, index: u32) -> Chain {
        if let Some(chain) = &self.pairs[index as usize].chain {
            return chain.clone();
        }
        let faces = self.faces(index);
        let chain = self.chains.find(self.pattern, faces, None);
        let chain = chain.unwrap_or_default();
        self.pairs[index as usize].chain = Some(chain.clone());
        chain
    }

    /// The vertices that two pieces share, and which corners those are.
    fn shared(&self, a: u32, b: u32) -> Vec<(VertexId, [u32; 2])> {
        let corners = |piece: u32| {
            let corners = self.pieces.list[piece as usize].corners();
            (0..).zip(&self.pieces.vertices[corners])
        };
        let both = corners(a).flat_map(|(k, v)| {
            let same = corners(b).filter(move |(_, w)| v == *w);
            same.map(move |(l, _)| (*v, [k, l]))
        });
        both.collect()
    }

    /// Puts the pairs of the children in the place of a pair of clusters.
    fn part(&mut self, index: u32, time: Tick) {
        let [a, b] = self.pairs[index as usize].nodes;
        let children = |node: u32| self.hierarchy.nodes[node as usize].children;
        if a == b {
            if let Some([left, right]) = children(a) {
                for pair in [[left, left], [left, right], [right, right]] {
                    self.add(pair, time);
                }
            }
            return;
        }
        let [first, second] = [a, b].map(|node| self.sheet.radius(node));
        let pairs = match (children(a), children(b)) {
            (Some(parts), other) if other.is_none() || first >= second => {
                parts.map(|part| [part, b])
            }
            (_, Some(parts)) => parts.map(|part| [a, part]),
            _ => return,
        };
        for pair in pairs {
            self.add(pair, time);
        }
    }

    fn sphere(&mut self, motion: &Motion, node: u32) -> Sphere {
        self.sheet
            .sphere(motion, &self.pieces, &self.hierarchy, node)
    }

    fn look(&mut self, motion: &Motion, index: u32) -> Look {
        let pair = self.pairs[index as usize].clone();
        let nodes = pair.nodes;
        match pair.kind {
            Kind::Clusters => self.look_at_clusters(motion, index, &pair),
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

    fn look_at_cells(&mut self, motion: &Motion, offset: u32) -> Look {
        let (time, best) = (self.sheet.time, self.best());
        let (bounds, astray) = (self.options.skip_bounds, self.astray());
        let Some(cells) = &mut self.sheet.cells else {
            return Look::Free;
        };
        let mut apart = cells.gap(motion, time, offset);
        let leap = astray + cells.moved(motion, time, LEAP, offset);
        let near = if bounds {
            leap.max(self.options.tolerance * self.pattern.median_edge())
        } else {
            f64::INFINITY
        };
        let mut measured = 0;
        if apart <= near || apart < best {
            let far = astray + cells.moved(motion, time, FOLLOWED, offset);
            let near = near.max(far.min(best));
            let found = cells.apart(motion, time, offset, [near, best]);
            apart = found.least;
            if !found.near.is_empty() {
                self.take(&found.near, time);
                return Look::Again;
            }
            for faces in found.nearest {
                measured += self.measure(motion, faces);
            }
        }
        let best = self.best();
        let Some(cells) = &self.sheet.cells else {
            return Look::Free;
        };
        let left = cells.offsets()[offset as usize].left;
        self.counts.skipped_bounds += left.saturating_sub(measured);
        match cells.until(motion, time, offset, apart - astray) {
            None => Look::Free,
            Some(_) if !self.options.skip_motion => Look::Until(motion.next_tabulated(time)),
            Some((until, moved)) if until == motion.end() && apart - moved >= best => Look::Free,
            Some((until, _)) => Look::Until(until),
        }
    }

    /// Measures the distance of two faces, if it may be the smallest; returns how many pairs of pieces
    /// were measured.
    fn measure(&mut self, motion: &Motion, faces: [FaceId; 2]) -> u64 {
        let [first, second] = faces.map(|face| self.pieces.of(face));
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

    /// Notes a distance that is smaller than all before.
    fn note(&mut self, motion: &Motion, nodes: [u32; 2], distance: f64) {
        if distance < self.best() {
            let [first, second] = nodes.map(|node| self.pieces.list[node as usize].face);
            self.clearance = Some(Clearance {
                distance,
                faces: [first.min(second), first.max(second)],
                place: place(motion, self.sheet.time),
            });
        }
    }

    /// Adds the pairs of pieces of pairs of faces.
    fn take(&mut self, pairs: &[[FaceId; 2]], time: Tick) {
        for faces in pairs {
            let [first, second] = faces.map(|face| self.pieces.of(face));
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
        let far = apart > astray + CLOSE * spheres[0].radius.min(spheres[1].radius);
        if self.options.skip_bounds && far && (apart >= best || !counts) {
            self.counts.skipped_bounds += 1;
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
        if apart <= tolerance {
            let depth = self.depth(motion, [a, b]);
            if depth > tolerance {
                return Look::Crossing(depth);
            }
        }
        if counts {
            self.note(motion, [a, b], apart);
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
        if angle * reach <= tolerance {
            let depth = self.depth(motion, [a, b]);
            if depth > tolerance {
                return Look::Crossing(depth);
            }
        }
        self.levers.clear();
        // Pairs of creases do not turn what is beyond.
        let chain = self.chain(index);
        for link in self.chains.singles(&chain) {
            self.levers.add(link.group, 1.0);
        }
        let look = self.after(motion, angle, angle + tolerance / reach, false);
        self.at_contact(motion, index, pair.kind, angle * reach, look)
    }

    /// The next look at a pair that nearly touches: later, if a plane parts it for longer.
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

    /// The planes that part two pieces.
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
        let mut all = parted(&a, &b, &self.turns, tolerance);
        // Seen from the other end, creases come the other way round and turn the other way.
        self.turns.reverse();
        for turn in &mut self.turns {
            turn.about = -turn.about;
        }
        all.extend(parted(&b, &a, &self.turns, tolerance));
        all
    }

    /// What is less deep between such pairs is contact.
    fn tolerance(&self, kind: Kind) -> f64 {
        let gap = match kind {
            Kind::Meeting | Kind::Vertex(_) | Kind::Joined => self.options.gap,
            Kind::Clusters | Kind::Cells(_) | Kind::Pieces => 0.0,
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

    /// How deep two pieces cross.
    fn depth(&mut self, motion: &Motion, [a, b]: [u32; 2]) -> f64 {
        self.put(motion, [a, b], true);
        let tolerance = self.options.tolerance * self.pattern.median_edge();
        self.sheet.placed(&self.pieces).depth(a, b, tolerance)
    }

    /// Sums up the levers of a chain of creases, each the distance from one end of the chain (0 or 1) as
    /// `reach` says: those up to some crease that of the first, the others that of the second.
    fn gather(
        &mut self,
        motion: &Motion,
        chain: &Chain,
        reach: impl Fn(usize, &super::sheet::Axis) -> f64,
    ) {
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

    /// How far points of a cluster may move, as seen from its face, for each radian that the group varies
    /// which varies most.
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

    /// The same for two pieces that are in their places.
    fn gather_corners(&mut self, motion: &Motion, chain: &Chain, nodes: [u32; 2]) {
        let ranges = nodes.map(|node| self.pieces.list[node as usize].corners());
        let corners = ranges.map(|range| self.sheet.corners(range).to_vec());
        self.gather(motion, chain, |side, axis| {
            let away = corners[side].iter().map(|corner| axis.distance(corner));
            away.fold(0.0, f64::max)
        });
    }

    /// When to look again at a pair of pieces that are `apart`, as the lattice says; `None` if that is not
    /// after the next tabulated time.
    fn along_lattice(&self, motion: &Motion, index: u32, apart: f64, counts: bool) -> Option<Look> {
        let time = self.sheet.time;
        if time == motion.end() {
            return Some(Look::Free);
        }
        let cells = self.sheet.cells.as_ref()?;
        let (until, moved) = cells.until_of(motion, time, self.faces(index), apart)?;
        if !self.options.skip_motion {
            return Some(Look::Until(motion.next_tabulated(time)));
        }
        let free = until == motion.end() && (!counts || apart - moved >= self.best());
        Some(if free { Look::Free } else { Look::Until(until) })
    }

    /// When to look again at a pair of pieces that are `apart` and may come nearer by `allowance`.
    fn after(&self, motion: &Motion, apart: f64, allowance: f64, counts: bool) -> Look {
        let time = self.sheet.time;
        if time == motion.end() {
            return Look::Free;
        }
        let until = motion.tabulated_until(&self.levers, time, allowance);
        let until = until.unwrap_or_else(|| motion.until(&self.levers, time, allowance));
        self.next(motion, until, apart, counts)
    }

    /// The next look at a pair that is free until some time; at the end only if the pair may be the
    /// nearest there.
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

    /// The verdict on a crossing found at a time: the place is narrowed down from the last look at the
    /// pair.
    fn first(&mut self, motion: &Motion, found: Crossing, index: u32, time: Tick) -> SweepVerdict {
        let pair = self.pairs[index as usize].clone();
        let tolerance = self.tolerance(pair.kind);
        let (mut crossing, mut high) = (found, time);
        let mut low = pair.last;
        while let Some(free) = low
            && high - free > LAST_FREE
        {
            self.sheet.time = (free + high) / 2;
            let depth = self.depth(motion, pair.nodes);
            if depth > tolerance {
                (crossing, high) = (Crossing::new(found.faces, depth), self.sheet.time);
            } else {
                low = Some(self.sheet.time);
            }
        }
        SweepVerdict::Crossing {
            crossing,
            at: place(motion, high),
            last_free: low.map(|low| place(motion, low)),
        }
    }
}

fn place(motion: &Motion, tick: Tick) -> Place {
    let (segment, s) = motion.place(tick);
    Place { segment, s }
}
