//! Decides whether faces pass through each other anywhere on a motion, by conservative advancement.
//!
//! Conservative advancement (B. Mirtich, "Impulse-based dynamic simulation of rigid body systems", 1996, 2.3):
//! two faces at a distance need no query until they may have come so far. Differs from the source in the bound
//! on their motion. Between two faces lies a chain of creases. If one of the creases turns alone, points of the
//! faces approach each other by no more than the angle times the distance of either point from the crease. If
//! all creases turn one after the other, from the middle of the chain outwards, these are distances in the
//! sheet as it is now. So a pair is free until the sum over its chain of variation of angle times distance has
//! used up the pair's distance. This holds whatever the motion does in between, as long as the sheet closes.
//!
//! A sheet that does not quite close is folded along a spanning tree of its faces, and torn at the edges off the tree. A
//! tear is an isometry whose size the closure residuals bound (`Holonomy::tears`). It may be any such isometry at each
//! time, so that each tear along a chain uses up twice its size. If that is too much of the distance, the chain follows
//! the tree, along which nothing is torn.
//!
//! Two faces that share a vertex have distance 0, but they lie in sectors round the vertex, and cross only if the arcs
//! of the sectors on the unit sphere do. For these arcs the same bound holds with angles in place of distances.
//!
//! Pairs that share nothing pass a broad phase first, over one interval after the other: most are kept apart by a plane
//! (`interval_broad_phase.rs`), and only the others are followed by conservative advancement, until the end of the
//! interval. If intervals would have to be too short, clusters of faces stand for all their pairs while they are far
//! apart. Two creases of a chain that turn by opposite angles about parallel lines count together, with the distance of
//! the lines as lever.

mod pair_query;
mod verdict;

pub use verdict::{Clearance, Place, SweepCounts, SweepOptions, SweepVerdict};

use core::f64::consts::PI;
use core::ops::Range;
use std::collections::{BTreeMap, HashMap};

use foldpath_core::{Curve, Membership};

use super::chains::{Chain, Chains, Way};
use super::comoving_faces::{ComovingFaces, comoving_faces};
use super::contact::{Change, Turn};
use super::hierarchy::Hierarchy;
use super::interval_broad_phase::IntervalBroadPhase;
use super::lattice::CellPairs;
use super::lazy_folding::LazyFolding;
use super::motion::{Levers, Motion, SEGMENT, Tick};
use super::pieces::{Contact, Pieces};
use super::scene::Crossing;
use super::tolerances::{
    CHAIN_TEAR_RATIO, CROSSING_DEPTH_EDGES, LAST_FREE_TICKS, MAX_LOG2_PARTS, OVERTURNED_SEGMENTS,
    QUERIES_PER_CLOCK,
};
use crate::lattice::Lattice;
use crate::pattern::{CreasePattern, FaceId, VertexId};
use crate::util::progress::Watch;

/// Two clusters, or two pieces, to be queried again.
#[derive(Clone, Debug)]
struct Pair {
    nodes: [u32; 2],
    kind: Kind,
    /// The chain of creases between them, once requested, and the phase in which it was found.
    chain: Option<Chain>,
    phase: usize,
    /// The chain along the spanning tree, once requested.
    along_tree: Option<Chain>,
    /// Time of the last query.
    last: Option<Tick>,
    /// Time from which on the broad phase proves that the pair is free.
    end: Tick,
    /// Set while one piece lies flat on the other: `true` if the second came from above the first, and `true`
    /// if the first came from above the second.
    above: Option<[bool; 2]>,
}

#[derive(Clone, Copy, Debug, PartialEq)]
enum Kind {
    Clusters,
    /// All pairs of pieces that the broad phase does not prove to be apart over an interval.
    Interval,
    /// All cells that were not near each other yet.
    Far,
    /// Cells whose difference has this number.
    Cells(u32),
    Pieces,
    /// Pieces that meet in a point of the flat sheet, as on both sides of a cut.
    Meeting,
    /// Pieces that share a vertex: positions of their corners at the vertex.
    Vertex([u32; 2]),
    Joined,
}

/// Outcome of a query of a pair.
enum QueryOutcome {
    /// Free up to this time.
    Until(Tick),
    /// Free to the end of the motion.
    Free,
    /// Crossing to this depth.
    Crossing(f64),
    /// Not decided: too near on a torn sheet, too many cells, or out of time.
    Undecided,
    /// To be replaced by other pairs, such as those of its parts.
    Split,
    /// To be queried again after the pairs taken from it.
    Again,
}

/// A sheet whose motions are swept for crossings.
#[derive(Clone, Debug)]
pub struct Sweep<'a> {
    pattern: &'a CreasePattern,
    memberships: &'a [Membership],
    groups: usize,
    options: SweepOptions,
    contact: Contact,
    watch: Watch<'a>,
    pieces: Pieces,
    hierarchy: Hierarchy,
    folding: LazyFolding<'a>,
    chains: Chains<'a>,
    /// For each cluster the chains from its face to those of its children (`within`), and the length of the
    /// list of links that holds them (`kept`).
    within: Vec<[Chain; 2]>,
    kept: usize,
    /// For each cluster a bound on the sum of the tears along the chains from its face to its pieces, units of the
    /// sheet.
    tears: Vec<f64>,
    /// Upper bound of the distance between any two points of the sheet; 0 along a lattice.
    length: f64,
    levers: Levers,
    turns: Vec<Turn>,
    changes: Vec<Change>,
    /// Number of the current phase. A phase is a run of consecutive segments over which the same groups turn.
    phase: usize,
    /// The current segment, and for each face the representative of the faces that stay at rest relative to it over the
    /// whole segment (`bodies`); empty if none do.
    segment: usize,
    bodies: Vec<usize>,
    /// `partners`: for each face the representative of the faces that stay at rest relative to it over the current
    /// sub-interval of the segment; `apart`: end of this sub-interval; `parts`: log2 of the number of sub-intervals.
    partners: Vec<usize>,
    apart: Tick,
    parts: u32,
    pairs: Vec<Pair>,
    due: BTreeMap<Tick, Vec<u32>>,
    /// The broad phase, if there is no lattice.
    broad_phase: Option<IntervalBroadPhase>,
    /// Pairs of pieces that the broad phase did not prove to be apart, with their positions in `pairs`.
    unseen: HashMap<[u32; 2], u32>,
    /// Number of pairs of pieces that do not touch each other in the flat sheet.
    others: u64,
    clearance: Option<Clearance>,
    counts: SweepCounts,
    queries: u64,
    /// Number of pairs found to share a side.
    joined: u64,
    /// Distance up to which cells are queried as long as no clearance is known.
    far: f64,
}

impl<'a> Sweep<'a> {
    /// Creates the sweep of a sheet. `memberships` has the group and sign of each crease of the pattern; creases without
    /// one stay flat. If the sheet closes all along its motions, and a lattice was found for these memberships, one pair
    /// of faces stands for all that move alike. Cost: about O(faces log faces), with a lattice O(faces) with a small factor.
    #[must_use]
    pub fn new(
        pattern: &'a CreasePattern,
        memberships: &'a [Membership],
        options: SweepOptions,
        lattice: Option<&'a Lattice>,
    ) -> Self {
        let (pieces, hierarchy) = if lattice.is_some() {
            // Pieces are made when they are requested.
            let pieces = Pieces::none(pattern);
            let hierarchy = Hierarchy::leaves(&pieces);
            (pieces, hierarchy)
        } else {
            let pieces = Pieces::new(pattern);
            let hierarchy = Hierarchy::new(&pieces);
            (pieces, hierarchy)
        };
        let groups = memberships.iter().map(|m| m.group.index() + 1);
        let groups = groups.max().unwrap_or_default();
        let tree = lattice.is_none().then(|| pattern.tree());
        // Without these skips all pairs are queried one by one.
        let skips = options.skip_motion && options.skip_bounds && options.skip_edges;
        let broad_phase = tree.filter(|_| skips);
        let broad_phase = broad_phase
            .map(|tree| IntervalBroadPhase::new(pattern, &hierarchy, memberships, groups, tree));
        let cells = lattice.map(|lattice| CellPairs::new(pattern, memberships, groups, lattice));
        let holonomy = tree.and_then(|tree| tree.holonomy(pattern));
        let tears = holonomy.map_or_else(Vec::new, |holonomy| holonomy.tears(options.closure));
        let folded = tree.map(|tree| (tree, &tears[..]));
        let mut chains = Chains::new(pattern, memberships, folded);
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
        let within: Vec<[Chain; 2]> = within.collect();
        let mut tears = Vec::with_capacity(within.len());
        for (node, chains) in hierarchy.nodes.iter().zip(&within) {
            // Children come before their cluster.
            let parts = node.children.unwrap_or_default().into_iter().zip(chains);
            let parts = parts.filter(|_| node.children.is_some());
            let tear = parts.map(|(child, chain)| chain.tear + tears[child as usize]);
            tears.push(tear.fold(0.0, f64::max));
        }
        Self {
            pattern,
            memberships,
            groups,
            contact: Contact::new(pattern.median_edge(), options.contact),
            options,
            watch: Watch::default(),
            folding: LazyFolding::new(pattern, memberships, groups, tree, cells),
            broad_phase,
            unseen: HashMap::new(),
            others: 0,
            within,
            kept: chains.len(),
            tears,
            length: tree.map_or(0.0, |tree| 2.0 * tree.reach(pattern)),
            chains,
            levers: Levers::new(groups),
            turns: Vec::new(),
            changes: Vec::new(),
            phase: 0,
            segment: 0,
            bodies: Vec::new(),
            partners: Vec::new(),
            apart: 0,
            parts: 0,
            pairs: Vec::new(),
            due: BTreeMap::new(),
            clearance: None,
            counts: SweepCounts::default(),
            queries: 0,
            joined: 0,
            far: 0.0,
            pieces,
            hierarchy,
        }
    }

    /// Reports how much of the motion is free, and answers [`SweepVerdict::Undecided`] once the call is over.
    #[must_use]
    pub fn watched(self, watch: Watch<'a>) -> Self {
        Self { watch, ..self }
    }

    /// Returns the numbers of pairs tested and skipped since the sweep was created.
    #[must_use]
    pub fn counts(&self) -> SweepCounts {
        self.counts
    }

    /// Sweeps a motion, given a curve for each crease group in each segment.
    pub fn sweep(&mut self, segments: &[Vec<Curve<f64>>]) -> SweepVerdict {
        let motion = Motion::new(segments, self.groups);
        if !motion.is_finite() {
            let at = place(&motion, 0);
            return SweepVerdict::Undecided { faces: None, at };
        }
        (self.clearance, self.queries, self.joined, self.far) = (None, 0, 0, 0.0);
        self.pairs.clear();
        self.due.clear();
        self.chains.truncate(self.kept);
        self.folding.forget();
        self.segment = usize::MAX;
        self.enter(&motion, 0);
        let before = self.counts;
        if let Some(cells) = &mut self.folding.cells {
            cells.begin(&motion);
            self.push([0, 0], Kind::Far, None, 0);
        }
        if let Some(broad_phase) = &mut self.broad_phase {
            broad_phase.begin(&motion, &self.pieces);
            self.unseen.clear();
            self.push([0, 0], Kind::Interval, None, 0);
            let touching = self.pieces.touching();
            let pairs = self.pieces.pairs(self.pattern.sheets());
            self.others = pairs - touching.len() as u64;
            for pair in touching {
                self.add(pair, 0);
            }
        } else {
            self.add_roots(0);
        }
        let mut times = 0;
        let verdict = loop {
            let Some((time, due)) = self.due.pop_first() else {
                break SweepVerdict::Free(self.clearance);
            };
            times += 1;
            #[allow(clippy::cast_precision_loss, reason = "a part of the motion")]
            self.watch.part(time as f64 / motion.end() as f64);
            if let Some(verdict) = self.query_all(&motion, time, due) {
                break verdict;
            }
        };
        self.count(times, before);
        match self.overturned(&motion) {
            Some((at, overturned)) if at.is_before(&verdict) => overturned,
            _ => verdict,
        }
    }

    /// Returns the first place at which a hinge turns past half a turn: the faces that it joins then pass
    /// through each other.
    fn overturned(&self, motion: &Motion) -> Option<(Place, SweepVerdict)> {
        let (segment, s, group, angle) = motion.overturned(CROSSING_DEPTH_EDGES)?;
        let at = Place { segment, s };
        let creases = self.pattern.creases().iter().zip(self.memberships);
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
                    s: (s - OVERTURNED_SEGMENTS).max(0.0),
                }),
            },
        ))
    }

    /// Completes the counts after `times` configurations.
    fn count(&mut self, times: u64, before: SweepCounts) {
        let [alike, representative, joined] = if let Some(cells) = &self.folding.cells {
            let [pieces, pairs] = cells.count();
            let alike = pieces * pieces.saturating_sub(1) / 2;
            [alike, pairs.min(alike), self.joined]
        } else {
            let pairs = self.pieces.pairs(self.pattern.sheets());
            [pairs, pairs, self.pieces.joined_pairs()]
        };
        let counts = &mut self.counts;
        if self.options.skip_edges {
            counts.skipped_edges += times * joined;
        }
        let handled = |c: &SweepCounts| c.tested + c.skipped_bounds + c.skipped_edges;
        let handled = handled(counts) - handled(&before);
        // Without this skip, pairs are passed over only at times between the tabulated ones, at which only
        // pairs in contact are queried.
        let skipped_motion = (times * representative).saturating_sub(handled);
        let skipped_motion = if self.options.skip_motion {
            skipped_motion
        } else {
            0
        };
        let skipped_symmetry = times * (alike - representative);
        counts.skipped_motion += skipped_motion;
        counts.skipped_symmetry += skipped_symmetry;
        counts.pairs += handled + skipped_motion + skipped_symmetry;
    }

    /// Queries all pairs that are due.
    fn query_all(
        &mut self,
        motion: &Motion,
        time: Tick,
        mut due: Vec<u32>,
    ) -> Option<SweepVerdict> {
        self.enter(motion, time);
        let mut deepest: Option<(Crossing, u32)> = None;
        while let Some(index) = due.pop() {
            if self.is_spent() {
                return Some(self.undecided(motion, index, time));
            }
            match self.query(motion, index) {
                QueryOutcome::Free => {}
                QueryOutcome::Until(later) => {
                    self.pairs[index as usize].last = Some(time);
                    if later >= self.pairs[index as usize].end {
                        continue;
                    }
                    self.due.entry(later).or_default().push(index);
                }
                QueryOutcome::Again => {
                    due.push(index);
                    due.extend(self.due.remove(&time).unwrap_or_default());
                }
                QueryOutcome::Undecided => return Some(self.undecided(motion, index, time)),
                QueryOutcome::Split => {
                    self.split(index, time);
                    due.extend(self.due.remove(&time).unwrap_or_default());
                }
                QueryOutcome::Crossing(depth) => {
                    let crossing = Crossing::new(self.faces(index), depth);
                    if deepest.is_none_or(|(deepest, _)| crossing.exceeds(&deepest)) {
                        deepest = Some((crossing, index));
                    }
                }
            }
        }
        deepest.map(|(crossing, index)| self.first(motion, crossing, index, time))
    }

    /// Goes to a time. At the beginning of another segment, makes chains cross few creases that turn, and finds
    /// the comoving faces of the segment. If some faces may be comoving over a part of the segment only, finds those
    /// that are from this time on.
    fn enter(&mut self, motion: &Motion, time: Tick) {
        self.folding.time = time;
        let (segment, _) = motion.place(time);
        if self.folding.cells.is_some() || self.segment == segment && time < self.apart {
            return;
        }
        let end = motion.end_of(segment);
        if self.segment != segment {
            (self.segment, self.parts, self.apart) = (segment, 0, end);
            self.phase += usize::from(self.chains.keep_still(motion.still(segment)));
            self.bodies.clear();
            self.partners.clear();
            if self.chains.still.is_empty() {
                return;
            }
            let found = self.comoving(motion, [time, end]);
            self.bodies = found.bodies;
            if !found.nearly {
                return;
            }
        }
        if time == motion.end() {
            return;
        }
        self.parts = self.parts.saturating_sub(1).max(1);
        loop {
            let part = SEGMENT >> self.parts;
            self.apart = (time / part + 1) * part;
            let found = self.comoving(motion, [time, self.apart]);
            self.partners = found.bodies;
            if !found.nearly || self.parts == MAX_LOG2_PARTS {
                break;
            }
            self.parts += 1;
        }
    }

    /// Finds the comoving faces from the present time to another.
    fn comoving(&mut self, motion: &Motion, times: [Tick; 2]) -> ComovingFaces {
        let tolerance = self.contact.base();
        let (chains, folding) = (&self.chains, &mut self.folding);
        comoving_faces(
            self.pattern,
            self.memberships,
            (motion, times),
            &chains.still,
            |edge| chains.tear(edge),
            |crease| folding.axis(motion, crease),
            [self.length, tolerance],
        )
    }

    /// Returns the time until which two pieces keep their positions relative to each other, if they do for a while.
    fn comoving_until(&self, motion: &Motion, nodes: [u32; 2]) -> Option<Tick> {
        let faces = nodes.map(|node| self.hierarchy.nodes[node as usize].face.index());
        let alike = |bodies: &[usize]| {
            let [a, b] = faces.map(|face| bodies.get(face));
            a.is_some() && a == b
        };
        if !self.options.skip_motion {
            return None;
        }
        let whole = alike(&self.bodies).then(|| motion.end_of(self.segment));
        whole.or_else(|| alike(&self.partners).then_some(self.apart))
    }

    fn undecided(&self, motion: &Motion, index: u32, time: Tick) -> SweepVerdict {
        let one = !matches!(self.pairs[index as usize].kind, Kind::Far | Kind::Interval);
        SweepVerdict::Undecided {
            faces: one.then(|| self.faces(index)),
            at: place(motion, time),
        }
    }

    /// Returns the largest distance of a face from its position by the lattice, units of the sheet; 0 without a
    /// lattice.
    fn lattice_deviation(&self) -> f64 {
        match self.folding.cells {
            Some(_) => self.options.lattice_deviation * self.pattern.median_edge(),
            None => 0.0,
        }
    }

    fn is_spent(&mut self) -> bool {
        self.queries += 1;
        self.queries > self.options.max_queries
            || self.queries % QUERIES_PER_CLOCK == 1 && self.watch.is_over()
    }

    fn faces(&self, pair: u32) -> [FaceId; 2] {
        let nodes = self.pairs[pair as usize].nodes;
        nodes.map(|node| self.hierarchy.nodes[node as usize].face)
    }

    /// Returns the pieces of a face.
    fn load(&mut self, face: FaceId) -> Range<u32> {
        let pieces = self.pieces.load(self.pattern, face);
        if self.folding.cells.is_some() {
            self.hierarchy.extend(&self.pieces);
        }
        pieces
    }

    /// Adds a pair to be queried.
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
            phase: self.phase,
            along_tree: None,
            last: None,
            end: Tick::MAX,
            above: None,
        });
        self.due.entry(time).or_default().push(index);
    }

    /// Adds all pairs of each sheet, by its root cluster.
    fn add_roots(&mut self, time: Tick) {
        let roots = self.hierarchy.roots.clone();
        for root in roots {
            self.add([root, root], time);
        }
    }

    /// Adds a pair of pieces that do not touch in the flat sheet, to be queried from `time` to the `end` of an interval;
    /// up to `time` they were apart. `way` is the way between their faces, if it is known.
    fn add_unseen(&mut self, pair: [u32; 2], [before, time, end]: [Tick; 3], way: Option<Way>) {
        if let Some(&index) = self.unseen.get(&pair) {
            let pair = &mut self.pairs[index as usize];
            if pair.end < time {
                pair.above = None;
            }
            pair.end = end;
            self.due.entry(time).or_default().push(index);
            return;
        }
        let faces = pair.map(|piece| self.hierarchy.nodes[piece as usize].face);
        let chain = match way {
            Some(way) => Some(self.chains.chain(self.pattern, faces[0], &way)),
            None => self.chains.find(self.pattern, faces, None),
        };
        if chain.is_none() {
            return;
        }
        let index = FaceId::new(self.pairs.len()).0;
        self.push(pair, Kind::Pieces, chain, time);
        let added = &mut self.pairs[index as usize];
        added.end = end;
        added.last = (time > 0).then_some(before);
        self.unseen.insert(pair, index);
    }

    /// Returns the kind of a pair, and the chain of creases between its two members; `None` if the pair never
    /// needs a query.
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
        if shared.len() > 1 {
            self.joined += 1;
            // The shared vertices are the ends of a line that is a side of both pieces: they turn about it.
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
        let chain = match &self.folding.cells {
            Some(_) => None,
            None => Some(self.chains.find(self.pattern, faces, None)?),
        };
        Some((kind, chain))
    }

    /// Returns a chain of creases between the two members of a pair, along which tears use up only a part of `room`: the
    /// distance (units of the sheet) up to which the members may approach each other or, for pieces that share a vertex,
    /// the angle (radians).
    fn chain_within(&mut self, index: u32, room: f64) -> Chain {
        let chain = self.chain(index);
        let pair = &self.pairs[index as usize];
        let torn = match pair.kind {
            Kind::Vertex(_) => chain.turn,
            _ => chain.tear,
        };
        if 2.0 * torn <= CHAIN_TEAR_RATIO * room {
            return chain;
        }
        if let Some(along_tree) = &pair.along_tree {
            return along_tree.clone();
        }
        let along_tree = self.chains.along_tree(self.pattern, self.faces(index));
        let along_tree = along_tree.unwrap_or(chain);
        self.pairs[index as usize].along_tree = Some(along_tree.clone());
        along_tree
    }

    /// Returns the shortest chain of creases between the two members of a pair.
    fn chain(&mut self, index: u32) -> Chain {
        let pair = &self.pairs[index as usize];
        let nodes = pair.nodes;
        if let Some(chain) = &pair.chain
            && pair.phase == self.phase
        {
            return chain.clone();
        }
        let round = match pair.kind {
            Kind::Vertex(_) => self
                .shared(nodes[0], nodes[1])
                .first()
                .map(|(vertex, _)| *vertex),
            _ => None,
        };
        let faces = self.faces(index);
        let chain = self.chains.find(self.pattern, faces, round);
        let chain = chain.unwrap_or_default();
        let pair = &mut self.pairs[index as usize];
        (pair.chain, pair.phase) = (Some(chain.clone()), self.phase);
        chain
    }

    /// Returns the vertices that two pieces share, and the positions of their corners at them.
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

    /// Replaces a pair of clusters by the pairs of their children.
    fn split(&mut self, index: u32, time: Tick) {
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
        let [first, second] = [a, b].map(|node| self.folding.radius(node));
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

    /// Returns the verdict on a crossing found at a time; the place is narrowed down by bisection from the last
    /// query of the pair.
    fn first(&mut self, motion: &Motion, found: Crossing, index: u32, time: Tick) -> SweepVerdict {
        let pair = self.pairs[index as usize].clone();
        let (mut crossing, mut high) = (found, time);
        let mut low = pair.last;
        while let Some(free) = low
            && high - free > LAST_FREE_TICKS
        {
            self.folding.time = (free + high) / 2;
            let depth = self.depth(motion, pair.nodes);
            if depth > self.allowed(&pair) {
                (crossing, high) = (Crossing::new(found.faces, depth), self.folding.time);
            } else {
                low = Some(self.folding.time);
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
