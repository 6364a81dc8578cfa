//! Finds the shortest way between two faces of a sheet, from face to face (Dijkstra's algorithm).

use core::time::Duration;
use std::collections::VecDeque;

use foldpath_core::Membership;
use nalgebra::Vector2;

use crate::collision::tolerances::{MAX_FACES_OF_DISTANCES, TURNING_COST};
use crate::pattern::{CreasePattern, EdgeId, FaceId, Step, VertexId};
use crate::util::parallel;
use crate::util::progress::Watch;

/// About the time that a search takes for each face of a sheet.
const TIME_PER_FACE: Duration = Duration::from_nanos(20);

/// A way from a face to another: the edges in order, each with the face beyond it.
pub(super) type Way = Vec<(EdgeId, FaceId)>;

/// The spanning tree along which the sheet is folded, and bounds on the tears at the edges off the tree.
#[derive(Clone, Debug)]
struct TornSheet {
    /// For each face but the roots, the step that reaches it.
    steps: Vec<Option<Step>>,
    /// For each face the number of steps from a root.
    depths: Vec<u32>,
    /// For each face the farthest face on the way to its root that belongs to the same panel: no crease is between. Ways
    /// pass from there to the next panel, so that they are short in sheets of few panels drawn as many faces.
    tops: Vec<FaceId>,
    /// `true` if no edge is off the tree, so that each way along the tree is the only one.
    is_simple: bool,
    /// For each edge off the tree its tear, once the motion is known; all others are 0.
    tears: Vec<[f64; 2]>,
}

impl TornSheet {
    fn new(pattern: &CreasePattern, closure: f64) -> Self {
        let tree = pattern.tree();
        let mut sheet = Self {
            steps: vec![None; tree.faces()],
            depths: vec![0; tree.faces()],
            tops: (0..tree.faces()).map(FaceId::new).collect(),
            is_simple: tree.loops().is_empty(),
            tears: vec![[0.0; 2]; pattern.edges().len()],
        };
        for step in tree.steps() {
            sheet.steps[step.face.index()] = Some(*step);
            sheet.depths[step.face.index()] = sheet.depths[step.parent.index()] + 1;
            if pattern.edge(step.edge).crease.is_none() {
                sheet.tops[step.face.index()] = sheet.tops[step.parent.index()];
            }
        }
        // Edges without a bound may be torn by anything.
        for step in tree.loops() {
            sheet.tears[step.edge.index()] = [f64::INFINITY; 2];
        }
        let holonomy = tree.holonomy(pattern);
        for tear in holonomy.map_or_else(Vec::new, |holonomy| holonomy.tears(closure)) {
            sheet.tears[tear.edge.index()] = [tear.turn, tear.shift];
        }
        sheet
    }

    /// Returns the creases on the way along the tree from a face to another, each with the face beyond. Between sheets the
    /// way leads from root to root, which are at rest relative to each other.
    fn way(&self, faces: [FaceId; 2]) -> Way {
        let top = |face: FaceId| self.tops[face.index()];
        let [mut from, mut to] = faces.map(top);
        let (mut way, mut back) = (Vec::new(), Vec::new());
        while from != to {
            if self.depths[from.index()] >= self.depths[to.index()] {
                let Some(step) = self.steps[from.index()] else {
                    break;
                };
                way.push((step.edge, step.parent));
                from = top(step.parent);
            } else if let Some(step) = self.steps[to.index()] {
                back.push((step.edge, to));
                to = top(step.parent);
            }
        }
        way.extend(back.into_iter().rev());
        way
    }
}

/// Ways between the faces of a sheet.
#[derive(Debug)]
pub(super) struct Ways<'a> {
    pub(super) pattern: &'a CreasePattern,
    pub(super) memberships: &'a [Membership],
    /// For each group `true` if it does not turn in the current phase; empty if all may turn.
    pub(super) still: Vec<bool>,
    /// For each face, once requested, the search of ways to it, as far as it went (`known`); not kept on large
    /// sheets (`keeps`).
    known: Vec<Search>,
    keeps: bool,
    searched: Search,
    /// `None` along a lattice, where faces are placed as in a sheet that closes.
    torn: Option<TornSheet>,
}

/// A search that passes from face to face. Source: E. W. Dijkstra, "A note on two problems in connexion with
/// graphs", 1959. Differs from the source in the queue: as there are two costs, two queues in order of arrival do.
#[derive(Clone, Debug, Default)]
struct Search {
    /// For each face reached its distance plus one; 0 for the others. Distances of at most `settled` are final.
    far: Vec<u32>,
    settled: u32,
    /// Faces to go on from, with their distance plus one: those reached across an edge that costs 1, and the others.
    open: [VecDeque<(u32, FaceId)>; 2],
    reached: Vec<FaceId>,
}

impl Search {
    /// Begins at one of this many faces.
    fn begin(&mut self, face: FaceId, faces: usize) {
        self.forget();
        self.far.resize(faces, 0);
        self.reach(face, 0, 1);
    }

    fn has_begun(&self) -> bool {
        !self.reached.is_empty()
    }

    fn forget(&mut self) {
        for face in self.reached.drain(..) {
            self.far[face.index()] = 0;
        }
        self.open.iter_mut().for_each(VecDeque::clear);
        self.settled = 0;
    }

    fn reach(&mut self, face: FaceId, from: u32, cost: u32) {
        let far = from + cost;
        let known = &mut self.far[face.index()];
        if *known == 0 {
            self.reached.push(face);
        } else if *known <= far {
            return;
        }
        *known = far;
        self.open[usize::from(cost > 1)].push_back((far, face));
    }

    /// Takes the nearest face to go on from.
    fn next(&mut self) -> Option<(u32, FaceId)> {
        let [first, second] = self.open.each_ref().map(|open| open.front());
        let far = |front: Option<&(u32, FaceId)>| front.map_or(u32::MAX, |front| front.0);
        let queue = usize::from(far(second) < far(first));
        self.open[queue].pop_front()
    }

    /// Returns `true` if the distance to the face is final.
    fn is_settled(&self, face: FaceId) -> bool {
        let far = self.far[face.index()];
        far > 0 && far <= self.settled
    }
}

impl<'a> Ways<'a> {
    /// Makes the ways of a sheet that is folded along its tree, and torn at edges off the tree as closure residuals of up to
    /// `closure` allow. Along a lattice (`None`) ways are requested only for faces near each other, so that distances are
    /// not kept.
    pub(super) fn new(
        pattern: &'a CreasePattern,
        memberships: &'a [Membership],
        closure: Option<f64>,
    ) -> Self {
        let faces = pattern.faces().len();
        let keeps = closure.is_some() && faces <= MAX_FACES_OF_DISTANCES;
        Self {
            pattern,
            memberships,
            still: Vec::new(),
            known: vec![Search::default(); if keeps { faces } else { 0 }],
            keeps,
            searched: Search::default(),
            torn: closure.map(|closure| TornSheet::new(pattern, closure)),
        }
    }

    /// Returns how far the sheet may be torn at an edge: an angle in radians, and a distance at the edge.
    pub(super) fn tear(&self, edge: EdgeId) -> [f64; 2] {
        let torn = self.torn.as_ref();
        torn.map_or([0.0; 2], |torn| torn.tears[edge.index()])
    }

    /// Sets the groups that do not turn from now on, one flag each; an empty list lets all groups turn. Returns
    /// `true` if this changes the flags.
    pub(super) fn keep_still(&mut self, still: Vec<bool>) -> bool {
        let others = self.still != still;
        if others {
            self.still = still;
            self.known.iter_mut().for_each(Search::forget);
        }
        others
    }

    /// Returns a shortest way from a face to another, with few creases that turn and with few bends; round a vertex, if
    /// one is given. Between sheets it is the way along the tree. Returns `None` if no way joins them. Cost: O(n log n)
    /// for n faces not farther away; the length of the way where faces are joined without loops.
    pub(super) fn find(&mut self, [from, to]: [FaceId; 2], round: Option<VertexId>) -> Option<Way> {
        let [one, other] = [from, to].map(|face| self.pattern.sheet_of_faces()[face.index()]);
        if round.is_none() && (self.is_simple() || one != other) {
            return self.along_tree([from, to]);
        }
        let kept = self.keeps && round.is_none();
        let searches = if kept {
            &mut self.known[to.index()]
        } else {
            &mut self.searched
        };
        let mut search = core::mem::take(searches);
        if !kept || !search.has_begun() {
            search.begin(to, self.pattern.faces().len());
        }
        self.search(&mut search, round, from);
        let way = self.trace(&search.far, [from, to], round);
        if kept {
            self.known[to.index()] = search;
        } else {
            self.searched = search;
        }
        way
    }

    /// Returns the way from a face to another along the spanning tree, on which nothing is torn. Returns `None` if there
    /// is no tree. Cost: O(length of the way).
    pub(super) fn along_tree(&self, faces: [FaceId; 2]) -> Option<Way> {
        Some(self.torn.as_ref()?.way(faces))
    }

    /// Returns `true` if the way along the tree is the only one.
    pub(super) fn is_simple(&self) -> bool {
        self.torn.as_ref().is_some_and(|torn| torn.is_simple)
    }

    /// Returns for each pair of faces the way that [`find`](Self::find) returns, if a search for it is needed. Pairs with
    /// the same second face share a search, and the threads share the searches. Once the watch is over, ways are missing.
    pub(super) fn find_all(&self, pairs: &[[FaceId; 2]], watch: Watch<'_>) -> Vec<Option<Way>> {
        let mut ways = vec![None; pairs.len()];
        if self.keeps || self.is_simple() {
            return ways;
        }
        let mut order: Vec<usize> = (0..pairs.len()).collect();
        order.sort_by_key(|&index| pairs[index][1]);
        let same_end = |a: &usize, b: &usize| pairs[*a][1] == pairs[*b][1];
        let groups: Vec<&[usize]> = order.chunk_by(same_end).collect();
        let faces = self.pattern.faces().len();
        let each = parallel::total_time(faces, TIME_PER_FACE);
        let found = parallel::map_with(&groups, each, Search::default, |search, group| {
            search.begin(pairs[group[0]][1], faces);
            let ways = group.iter().map(|&index| {
                if watch.is_over() {
                    return None;
                }
                self.search(search, None, pairs[index][0]);
                self.trace(&search.far, pairs[index], None)
            });
            ways.collect::<Vec<_>>()
        });
        for (&index, way) in order.iter().zip(found.into_iter().flatten()) {
            ways[index] = way;
        }
        ways
    }

    /// Returns the shortest way from a face to the one that distances are measured from, with few bends.
    fn trace(&self, far: &[u32], [from, to]: [FaceId; 2], round: Option<VertexId>) -> Option<Way> {
        if far[from.index()] == 0 {
            return None;
        }
        let mut way = Vec::new();
        let (mut face, mut heading) = (from, Vector2::zeros());
        while face != to {
            let ahead = self.pattern.neighbours()[face.index()].iter().copied();
            let ahead = ahead.filter(|&(next, edge)| {
                let there = far[next.index()];
                there > 0
                    && there + self.across(edge) == far[face.index()]
                    && ends_at(self.pattern, edge, round)
            });
            let bend = |edge: EdgeId| direction(self.pattern, edge).perp(&heading).abs();
            let (next, edge) = ahead.min_by(|a, b| bend(a.1).total_cmp(&bend(b.1)))?;
            heading = direction(self.pattern, edge);
            way.push((edge, next));
            face = next;
        }
        Some(way)
    }

    /// Goes on with a search until the distance to a face is final; round a vertex, if one is given.
    fn search(&self, search: &mut Search, round: Option<VertexId>, until: FaceId) {
        while !search.is_settled(until) {
            let Some((far, face)) = search.next() else {
                return;
            };
            search.settled = far;
            if far > search.far[face.index()] {
                continue;
            }
            for &(beyond, edge) in &self.pattern.neighbours()[face.index()] {
                if ends_at(self.pattern, edge, round) {
                    search.reach(beyond, far, self.across(edge));
                }
            }
        }
    }

    /// Returns the cost of crossing an edge.
    fn across(&self, edge: EdgeId) -> u32 {
        let crease = self.pattern.edge(edge).crease;
        let member = crease.and_then(|crease| self.memberships.get(crease.index()));
        let still = member.and_then(|member| self.still.get(member.group.index()));
        if still == Some(&false) {
            TURNING_COST
        } else {
            1
        }
    }
}

/// Returns the direction of an edge from its first end to the second.
pub(super) fn direction(pattern: &CreasePattern, edge: EdgeId) -> Vector2<f64> {
    pattern.direction(edge, pattern.edge(edge).ends[0])
}

/// Returns `true` if the edge ends at the vertex, or no vertex is given.
fn ends_at(pattern: &CreasePattern, edge: EdgeId, vertex: Option<VertexId>) -> bool {
    vertex.is_none_or(|vertex| pattern.edge(edge).ends.contains(&vertex))
}
