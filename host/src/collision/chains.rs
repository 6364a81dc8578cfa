//! The creases between two faces of a sheet, along a shortest chain of faces.

use core::cmp::Reverse;
use std::collections::BinaryHeap;

use foldpath_core::Membership;
use nalgebra::Vector2;

use crate::pattern::{CreaseId, CreasePattern, EdgeId, FaceId, VertexId};

/// Creases whose directions differ by no more, in radians, are parallel: what they are off moves points a
/// thousand edges away by less than counts as a crossing.
const PARALLEL: f64 = 1e-10;

/// A crease of a chain, or two that turn by opposite angles about parallel lines: what is beyond both
/// then does not turn, but moves round on a circle as wide as they are apart.
#[derive(Clone, Copy, Debug)]
pub(super) struct Link {
    pub(super) group: u32,
    /// Twice the same for a crease alone.
    pub(super) creases: [CreaseId; 2],
    /// Their numbers in the chain, and whether a positive group angle turns what is beyond about the
    /// direction of the crease's edge.
    pub(super) places: [(u32, bool); 2],
}

/// A chain: its single creases in order, and its pairs.
#[derive(Clone, Debug, Default)]
pub(super) struct Chain {
    start: usize,
    pairs: usize,
    end: usize,
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
    /// Whether a later crease of a chain turns what is beyond it back.
    fn undone_by(&self, later: &Self) -> bool {
        let (along, across) = (self.axis.dot(&later.axis), self.axis.perp(&later.axis));
        let opposite = (self.member.negative != later.member.negative) == (along > 0.0);
        self.member.group == later.member.group && across.abs() <= PARALLEL && opposite
    }
}

/// Chains, one behind the other in one list.
#[derive(Clone, Debug)]
pub(super) struct Chains<'a> {
    memberships: &'a [Membership],
    /// Groups that do not turn for now.
    still: Vec<bool>,
    links: Vec<Link>,
    /// For each face, once it was asked for, how far it is from it to all others; none on large sheets.
    known: Vec<Vec<u32>>,
    keeps: bool,
    searched: Search,
    crossed: Vec<Crossed>,
    way: Vec<(EdgeId, FaceId)>,
}

/// Sheets of more faces do not keep how far it is from each face to each other: 2^24 numbers.
const MANY: usize = 1 << 12;
/// How far it is across a crease that turns; across others, 1.
const TURNING: u32 = 1 << 12;

/// A search that passes from face to face. Source: E. W. Dijkstra, "A note on two problems in connexion with graphs",
/// 1959.
#[derive(Clone, Debug, Default)]
struct Search {
    /// For each face reached how far it is, and one; 0 for the others.
    far: Vec<u32>,
    /// Faces to go on from, and how far they are, and one.
    open: BinaryHeap<Reverse<(u32, FaceId)>>,
    reached: Vec<FaceId>,
}

impl Search {
    fn forget(&mut self) {
        for face in self.reached.drain(..) {
            self.far[face.index()] = 0;
        }
        self.open.clear();
    }

    fn reach(&mut self, face: FaceId, far: u32) {
        let known = &mut self.far[face.index()];
        if *known == 0 {
            self.reached.push(face);
        } else if *known <= far {
            return;
        }
        *known = far;
        self.open.push(Reverse((far, face)));
    }
}

impl<'a> Chains<'a> {
    /// For faces that are `near` each other, or for any.
    pub(super) fn new(pattern: &CreasePattern, memberships: &'a [Membership], near: bool) -> Self {
        let faces = pattern.faces().len();
        let keeps = !near && faces <= MANY;
        Self {
            memberships,
            still: Vec::new(),
            links: Vec::new(),
            known: vec![Vec::new(); if keeps { faces } else { 0 }],
            keeps,
            searched: Search {
                far: vec![0; faces],
                ..Search::default()
            },
            crossed: Vec::new(),
            way: Vec::new(),
        }
    }

    /// From now on these groups do not turn, one flag each; none for all that may. Whether others did not before.
    pub(super) fn keep_still(&mut self, still: Vec<bool>) -> bool {
        let others = self.still != still;
        if others {
            self.still = still;
            self.known.iter_mut().for_each(Vec::clear);
        }
        others
    }

    /// Whether each group does not turn for now; empty if all may.
    pub(super) fn still(&self) -> &[bool] {
        &self.still
    }

    /// Length of the list of links.
    pub(super) fn len(&self) -> usize {
        self.links.len()
    }

    /// Forgets all links of the list behind this length.
    pub(super) fn truncate(&mut self, len: usize) {
        self.links.truncate(len);
    }

    /// All links of a chain.
    pub(super) fn links(&self, chain: &Chain) -> &[Link] {
        &self.links[chain.start..chain.end]
    }

    /// The single creases of a chain in order.
    pub(super) fn singles(&self, chain: &Chain) -> &[Link] {
        &self.links[chain.start..chain.pairs]
    }

    /// The pairs of a chain.
    pub(super) fn pairs(&self, chain: &Chain) -> &[Link] {
        &self.links[chain.pairs..chain.end]
    }

    /// A shortest chain from a face to another of the same sheet, across few creases that turn, and with few bends; round
    /// a vertex, if one is given. Cost: O(n log n) for n faces not farther away.
    pub(super) fn find(
        &mut self,
        pattern: &CreasePattern,
        [from, to]: [FaceId; 2],
        round: Option<VertexId>,
    ) -> Option<Chain> {
        let whole = round.is_none() && self.keeps;
        if !whole || self.known[to.index()].is_empty() {
            self.search(pattern, to, round, (!whole).then_some(from));
            if whole {
                self.known[to.index()] = self.searched.far.clone();
            }
        }
        let far = if whole {
            &self.known[to.index()]
        } else {
            &self.searched.far
        };
        if far[from.index()] == 0 {
            return None;
        }
        let start = self.links.len();
        let mut way = core::mem::take(&mut self.way);
        let (mut face, mut heading) = (from, Vector2::zeros());
        self.crossed.clear();
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
        for (place, &(edge, beyond)) in (0..).zip(&way) {
            self.cross(pattern, edge, beyond, place);
        }
        way.clear();
        self.way = way;
        let pairs = self.links.len();
        // Those left single come before the pairs.
        let singles = self.crossed.iter().map(|crossed| Link {
            group: crossed.member.group.0,
            creases: [crossed.crease; 2],
            places: [crossed.place; 2],
        });
        self.links.extend(singles);
        self.links[start..].rotate_left(pairs - start);
        Some(Chain {
            start,
            pairs: self.links.len() - (pairs - start),
            end: self.links.len(),
        })
    }

    /// Finds how far it is to `to` from all faces round a vertex or everywhere: from all, or up to one.
    fn search(
        &mut self,
        pattern: &CreasePattern,
        to: FaceId,
        round: Option<VertexId>,
        from: Option<FaceId>,
    ) {
        let mut search = core::mem::take(&mut self.searched);
        search.forget();
        search.reach(to, 1);
        while let Some(Reverse((far, face))) = search.open.pop() {
            if from == Some(face) {
                break;
            }
            if far > search.far[face.index()] {
                continue;
            }
            for &(beyond, edge) in &pattern.neighbours()[face.index()] {
                if ends_at(pattern, edge, round) {
                    search.reach(beyond, far + self.across(pattern, edge));
                }
            }
        }
        self.searched = search;
    }

    /// How far it is across an edge.
    fn across(&self, pattern: &CreasePattern, edge: EdgeId) -> u32 {
        let crease = pattern.edge(edge).crease;
        let member = crease.and_then(|crease| self.memberships.get(crease.index()));
        let still = member.and_then(|member| self.still.get(member.group.index()));
        if still == Some(&false) { TURNING } else { 1 }
    }

    /// Goes across an edge to the face beyond.
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

/// Whether an edge ends at a vertex, if one is given.
fn ends_at(pattern: &CreasePattern, edge: EdgeId, vertex: Option<VertexId>) -> bool {
    vertex.is_none_or(|vertex| pattern.edge(edge).ends.contains(&vertex))
}
