//! Finds the creases between two faces of a sheet, along a shortest chain of faces (Dijkstra's algorithm).

use core::time::Duration;
use std::collections::VecDeque;

use foldpath_core::Membership;
use nalgebra::Vector2;

use crate::collision::tolerances::{MAX_FACES_OF_DISTANCES, PARALLEL_RAD, TURNING_COST};
use crate::folding::{SpanningTree, Step, Tear};
use crate::pattern::{CreaseId, CreasePattern, EdgeId, FaceId, VertexId};
use crate::util::parallel;
use crate::util::progress::Watch;

/// About the time that a search takes for each face of a sheet.
const TIME_PER_FACE: Duration = Duration::from_nanos(20);

/// A way from a face to another: the edges in order, each with the face beyond it.
pub(in crate::collision) type Way = Vec<(EdgeId, FaceId)>;

/// A crease of a chain, or two creases that turn by opposite angles about parallel lines: the part beyond such
/// a pair does not turn, but moves on a circle whose radius is the distance of the lines.
#[derive(Clone, Copy, Debug)]
pub(in crate::collision) struct Link {
    pub(in crate::collision) group: u32,
    /// The two creases; a single crease appears twice.
    pub(in crate::collision) creases: [CreaseId; 2],
    /// For each crease its position in the chain, and `true` if a positive group angle turns the part beyond
    /// about the direction of the crease's edge.
    pub(in crate::collision) places: [(u32, bool); 2],
}

/// A chain as a range of the list of links: its single creases in order (`start..pairs`), and its pairs (`pairs..end`).
#[derive(Clone, Debug, Default)]
pub(in crate::collision) struct Chain {
    start: usize,
    pairs: usize,
    end: usize,
    /// Bounds on the difference between the positions of the faces at its ends and those that its creases give them. Torn
    /// edges on the way cause it: `tear` is for points of the faces, in units of the sheet, `turn` for directions, in
    /// radians.
    pub(in crate::collision) tear: f64,
    pub(in crate::collision) turn: f64,
}

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
    fn new(pattern: &CreasePattern, tree: &SpanningTree, tears: &[Tear]) -> Self {
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
        for tear in tears {
            sheet.tears[tear.edge.index()] = [tear.turn, tear.shift];
        }
        sheet
    }

    /// Returns the creases on the way along the tree from a face to another, each with the face beyond; `None` if the
    /// faces are in different sheets.
    fn way(&self, faces: [FaceId; 2]) -> Option<Way> {
        let top = |face: FaceId| self.tops[face.index()];
        let [mut from, mut to] = faces.map(top);
        let (mut way, mut back) = (Vec::new(), Vec::new());
        while from != to {
            if self.depths[from.index()] >= self.depths[to.index()] {
                let step = self.steps[from.index()]?;
                way.push((step.edge, step.parent));
                from = top(step.parent);
            } else {
                let step = self.steps[to.index()]?;
                back.push((step.edge, to));
                to = top(step.parent);
            }
        }
        way.extend(back.into_iter().rev());
        Some(way)
    }
}

/// A crease as a chain crosses it.
#[derive(Clone, Copy, Debug)]
struct Crossed {
    crease: CreaseId,
    member: Membership,
    place: (u32, bool),
    /// Direction with the face beyond to its left.
    axis: Vector2<f64>,
}

impl Crossed {
    /// Returns `true` if a later crease of a chain turns the part beyond it back.
    fn undone_by(&self, later: &Self) -> bool {
        let (along, across) = (self.axis.dot(&later.axis), self.axis.perp(&later.axis));
        let opposite = (self.member.negative != later.member.negative) == (along > 0.0);
        self.member.group == later.member.group && across.abs() <= PARALLEL_RAD && opposite
    }
}

/// Chains, one behind the other in one list of links.
#[derive(Clone, Debug)]
pub(in crate::collision) struct Chains<'a> {
    memberships: &'a [Membership],
    /// For each group `true` if it does not turn in the current phase; empty if all may turn.
    pub(in crate::collision) still: Vec<bool>,
    links: Vec<Link>,
    /// For each face, once requested, the distance to it from every other face (`known`); not kept on large
    /// sheets (`keeps`).
    known: Vec<Vec<u32>>,
    keeps: bool,
    searched: Search,
    crossed: Vec<Crossed>,
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
    fn new(faces: usize) -> Self {
        Self {
            far: vec![0; faces],
            ..Self::default()
        }
    }

    /// Begins at a face.
    fn begin(&mut self, face: FaceId) {
        for face in self.reached.drain(..) {
            self.far[face.index()] = 0;
        }
        self.open.iter_mut().for_each(VecDeque::clear);
        self.settled = 0;
        self.reach(face, 0, 1);
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

impl<'a> Chains<'a> {
    /// Creates an empty list of chains of a sheet that is folded along a tree and torn at edges off the tree. Without a
    /// tree, chains are requested only for faces near each other, so that distances are not kept.
    pub(in crate::collision) fn new(
        pattern: &CreasePattern,
        memberships: &'a [Membership],
        folded: Option<(&SpanningTree, &[Tear])>,
    ) -> Self {
        let faces = pattern.faces().len();
        let keeps = folded.is_some() && faces <= MAX_FACES_OF_DISTANCES;
        Self {
            memberships,
            still: Vec::new(),
            links: Vec::new(),
            known: vec![Vec::new(); if keeps { faces } else { 0 }],
            keeps,
            searched: Search::new(faces),
            crossed: Vec::new(),
            torn: folded.map(|(tree, tears)| TornSheet::new(pattern, tree, tears)),
        }
    }

    /// Returns how far the sheet may be torn at an edge: an angle in radians, and a distance at the edge.
    pub(in crate::collision) fn tear(&self, edge: EdgeId) -> [f64; 2] {
        let torn = self.torn.as_ref();
        torn.map_or([0.0; 2], |torn| torn.tears[edge.index()])
    }

    /// Sets the groups that do not turn from now on, one flag each; an empty list lets all groups turn. Returns
    /// `true` if this changes the flags.
    pub(in crate::collision) fn keep_still(&mut self, still: Vec<bool>) -> bool {
        let others = self.still != still;
        if others {
            self.still = still;
            self.known.iter_mut().for_each(Vec::clear);
        }
        others
    }

    /// Returns the length of the list of links.
    pub(in crate::collision) fn len(&self) -> usize {
        self.links.len()
    }

    /// Removes all links of the list behind this length.
    pub(in crate::collision) fn truncate(&mut self, len: usize) {
        self.links.truncate(len);
    }

    /// Returns all links of a chain.
    pub(in crate::collision) fn links(&self, chain: &Chain) -> &[Link] {
        &self.links[chain.start..chain.end]
    }

    /// Returns the single creases of a chain, in order.
    pub(in crate::collision) fn singles(&self, chain: &Chain) -> &[Link] {
        &self.links[chain.start..chain.pairs]
    }

    /// Returns the pairs of a chain.
    pub(in crate::collision) fn pairs(&self, chain: &Chain) -> &[Link] {
        &self.links[chain.pairs..chain.end]
    }

    /// Returns a shortest chain from a face to another of the same sheet, with few creases that turn and with
    /// few bends; round a vertex, if one is given. Returns `None` if no chain joins them. Cost: O(n log n) for
    /// n faces not farther away; the length of the chain where faces are joined without loops.
    pub(in crate::collision) fn find(
        &mut self,
        pattern: &CreasePattern,
        [from, to]: [FaceId; 2],
        round: Option<VertexId>,
    ) -> Option<Chain> {
        if round.is_none() && self.torn.as_ref().is_some_and(|torn| torn.is_simple) {
            return self.along_tree(pattern, [from, to]);
        }
        let mut search = core::mem::take(&mut self.searched);
        let way = if round.is_none() && self.keeps {
            if self.known[to.index()].is_empty() {
                search.begin(to);
                self.search(pattern, &mut search, None, None);
                self.known[to.index()] = search.far.clone();
            }
            self.trace(pattern, &self.known[to.index()], [from, to], round)
        } else {
            search.begin(to);
            self.search(pattern, &mut search, round, Some(from));
            self.trace(pattern, &search.far, [from, to], round)
        };
        self.searched = search;
        Some(self.chain(pattern, from, &way?))
    }

    /// Returns for each pair of faces the way that [`find`](Self::find) takes, if a search for it is needed. Pairs with
    /// the same second face share a search, and the threads share the searches. Once the watch is over, ways are missing.
    pub(in crate::collision) fn ways(
        &self,
        pattern: &CreasePattern,
        pairs: &[[FaceId; 2]],
        watch: Watch<'_>,
    ) -> Vec<Option<Way>> {
        let mut ways = vec![None; pairs.len()];
        if self.keeps || self.torn.as_ref().is_some_and(|torn| torn.is_simple) {
            return ways;
        }
        let mut order: Vec<usize> = (0..pairs.len()).collect();
        order.sort_by_key(|&index| pairs[index][1]);
        let same_end = |a: &usize, b: &usize| pairs[*a][1] == pairs[*b][1];
        let groups: Vec<&[usize]> = order.chunk_by(same_end).collect();
        let faces = pattern.faces().len();
        let each = parallel::total_time(faces, TIME_PER_FACE);
        let begin = || Search::new(faces);
        let found = parallel::map_with(&groups, each, begin, |search, group| {
            search.begin(pairs[group[0]][1]);
            let ways = group.iter().map(|&index| {
                if watch.is_over() {
                    return None;
                }
                self.search(pattern, search, None, Some(pairs[index][0]));
                self.trace(pattern, &search.far, pairs[index], None)
            });
            ways.collect::<Vec<_>>()
        });
        for (&index, way) in order.iter().zip(found.into_iter().flatten()) {
            ways[index] = way;
        }
        ways
    }

    /// Returns the shortest way from a face to the one that distances are measured from, with few bends.
    fn trace(
        &self,
        pattern: &CreasePattern,
        far: &[u32],
        [from, to]: [FaceId; 2],
        round: Option<VertexId>,
    ) -> Option<Way> {
        if far[from.index()] == 0 {
            return None;
        }
        let mut way = Vec::new();
        let (mut face, mut heading) = (from, Vector2::zeros());
        while face != to {
            let ahead = pattern.neighbours()[face.index()].iter().copied();
            let ahead = ahead.filter(|&(next, edge)| {
                let there = far[next.index()];
                there > 0
                    && there + self.across(pattern, edge) == far[face.index()]
                    && ends_at(pattern, edge, round)
            });
            let bend = |edge: EdgeId| direction(pattern, edge).perp(&heading).abs();
            let (next, edge) = ahead.min_by(|a, b| bend(a.1).total_cmp(&bend(b.1)))?;
            heading = direction(pattern, edge);
            way.push((edge, next));
            face = next;
        }
        Some(way)
    }

    /// Returns the chain from a face to another along the spanning tree, on which nothing is torn. Returns `None` if no
    /// chain joins them, or there is no tree. Cost: O(length of the chain).
    pub(in crate::collision) fn along_tree(
        &mut self,
        pattern: &CreasePattern,
        faces: [FaceId; 2],
    ) -> Option<Chain> {
        let way = self.torn.as_ref()?.way(faces)?;
        Some(self.chain(pattern, faces[0], &way))
    }

    /// Makes the chain from a face along a way.
    pub(in crate::collision) fn chain(
        &mut self,
        pattern: &CreasePattern,
        from: FaceId,
        way: &[(EdgeId, FaceId)],
    ) -> Chain {
        let start = self.links.len();
        self.crossed.clear();
        for (place, &(edge, beyond)) in (0..).zip(way) {
            self.cross(pattern, edge, beyond, place);
        }
        let pairs = self.links.len();
        // The creases left single come before the pairs.
        let singles = self.crossed.iter().map(|crossed| Link {
            group: crossed.member.group.0,
            creases: [crossed.crease; 2],
            places: [crossed.place; 2],
        });
        self.links.extend(singles);
        self.links[start..].rotate_left(pairs - start);
        let [tear, turn] = self.torn_along(pattern, from, way);
        Chain {
            start,
            pairs: self.links.len() - (pairs - start),
            end: self.links.len(),
            tear,
            turn,
        }
    }

    /// Sums up the tears along a way, for points of the faces at its ends and for their directions. A tear turns the part
    /// of the chain before it or the part beyond it: whichever is shorter counts. From an edge of the chain, no point of
    /// the first face is ever farther than the way through the faces between.
    fn torn_along(
        &self,
        pattern: &CreasePattern,
        from: FaceId,
        way: &[(EdgeId, FaceId)],
    ) -> [f64; 2] {
        let is_torn = |&(edge, _): &(EdgeId, FaceId)| self.tear(edge)[1] > 0.0;
        let Some(&(_, to)) = way.last().filter(|_| way.iter().any(is_torn)) else {
            return [0.0; 2];
        };
        let pivot = |edge: EdgeId| pattern.vertices()[pattern.edge(edge).ends[0].index()];
        let away = |face: FaceId, from: Vector2<f64>| {
            let corners = pattern.faces()[face.index()].iter();
            let away = corners.map(|v| (pattern.vertices()[v.index()] - from).norm());
            away.fold(0.0, f64::max)
        };
        let ends = [way[0].0, way[way.len() - 1].0].map(pivot);
        let legs = way
            .windows(2)
            .map(|pair| (pivot(pair[1].0) - pivot(pair[0].0)).norm());
        let total: f64 = away(from, ends[0]) + legs.clone().sum::<f64>() + away(to, ends[1]);
        let mut before = away(from, ends[0]);
        let mut sum = [0.0; 2];
        for (&(edge, _), leg) in way.iter().zip(legs.chain([0.0])) {
            let [turn, shift] = self.tear(edge);
            if shift > 0.0 {
                sum[0] += shift + turn * before.min(total - before);
                sum[1] += turn;
            }
            before += leg;
        }
        sum
    }

    /// Goes on with a search until the distance to a face is final, or those to all faces are; round a vertex, if one is
    /// given.
    fn search(
        &self,
        pattern: &CreasePattern,
        search: &mut Search,
        round: Option<VertexId>,
        until: Option<FaceId>,
    ) {
        while !until.is_some_and(|until| search.is_settled(until)) {
            let Some((far, face)) = search.next() else {
                return;
            };
            search.settled = far;
            if far > search.far[face.index()] {
                continue;
            }
            for &(beyond, edge) in &pattern.neighbours()[face.index()] {
                if ends_at(pattern, edge, round) {
                    search.reach(beyond, far, self.across(pattern, edge));
                }
            }
        }
    }

    /// Returns the cost of crossing an edge.
    fn across(&self, pattern: &CreasePattern, edge: EdgeId) -> u32 {
        let crease = pattern.edge(edge).crease;
        let member = crease.and_then(|crease| self.memberships.get(crease.index()));
        let still = member.and_then(|member| self.still.get(member.group.index()));
        if still == Some(&false) {
            TURNING_COST
        } else {
            1
        }
    }

    /// Crosses an edge to the face beyond: appends its crease, or pairs it with the last one.
    fn cross(&mut self, pattern: &CreasePattern, edge: EdgeId, beyond: FaceId, place: u32) {
        let Some(crease) = pattern.edge(edge).crease else {
            return;
        };
        let Some(&member) = self.memberships.get(crease.index()) else {
            return;
        };
        let left = pattern.edge(edge).faces[0] == Some(beyond);
        let direction = direction(pattern, edge);
        let crossed = Crossed {
            crease,
            member,
            place: (place, left != member.negative),
            axis: if left { direction } else { -direction },
        };
        match self.crossed.last() {
            Some(last) if last.undone_by(&crossed) => {
                self.links.push(Link {
                    group: member.group.0,
                    creases: [last.crease, crease],
                    places: [last.place, crossed.place],
                });
                self.crossed.pop();
            }
            _ => self.crossed.push(crossed),
        }
    }
}

fn direction(pattern: &CreasePattern, edge: EdgeId) -> Vector2<f64> {
    pattern.direction(edge, pattern.edge(edge).ends[0])
}

/// Returns `true` if the edge ends at the vertex, or no vertex is given.
fn ends_at(pattern: &CreasePattern, edge: EdgeId, vertex: Option<VertexId>) -> bool {
    vertex.is_none_or(|vertex| pattern.edge(edge).ends.contains(&vertex))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::generate::Miura;
    use crate::symmetry::CreaseGroups;

    #[test]
    fn ways_found_together_are_those_found_one_by_one() {
        let miura = Miura {
            rows: 20,
            columns: 15,
            sector_angle: 1.0,
            fold: 0.5,
        };
        let pattern = CreasePattern::new(miura.drawing().unwrap()).unwrap();
        let groups = CreaseGroups::trivial(&pattern);
        let faces = pattern.faces().len();
        // Ends repeat, near ones come after far ones, and some creases cost more than others.
        let face = |k: usize| FaceId::new(k % faces);
        let pairs: Vec<_> = (0..600)
            .map(|k| [face(7 * k), face(11 * (k % 13))])
            .collect();
        let still = (0..groups.len()).map(|group| group % 3 != 0);
        for still in [Vec::new(), still.collect()] {
            let mut chains = Chains::new(&pattern, groups.memberships(), None);
            chains.keep_still(still);
            for threads in [1, 3] {
                let pool = rayon::ThreadPoolBuilder::new().num_threads(threads);
                let pool = pool.build().unwrap();
                let ways = pool.install(|| chains.ways(&pattern, &pairs, Watch::default()));
                assert_eq!(ways.len(), pairs.len());
                for (faces, way) in pairs.iter().zip(ways) {
                    let one = chains.find(&pattern, *faces, None).unwrap();
                    let other = chains.chain(&pattern, faces[0], &way.unwrap());
                    let [one, other] = [one, other].map(|chain| {
                        let links = chains.links(&chain).iter();
                        links
                            .map(|link| (link.creases, link.places))
                            .collect::<Vec<_>>()
                    });
                    assert_eq!(one, other, "{faces:?}");
                }
            }
        }
    }
}
