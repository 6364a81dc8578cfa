//! The creases on the way between two faces of a sheet.

use foldpath_core::Membership;
use nalgebra::Vector2;

use super::ways::{Way, Ways, direction};
use crate::collision::tolerances::PARALLEL_RAD;
use crate::pattern::{CreaseId, EdgeId, FaceId, VertexId};

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
pub(super) struct Chain {
    start: usize,
    pairs: usize,
    end: usize,
    /// Bounds on the difference between the positions of the faces at its ends and those that its creases give them. Torn
    /// edges on the way cause it: `tear` is for points of the faces, in units of the sheet, `turn` for directions, in
    /// radians.
    pub(super) tear: f64,
    pub(super) turn: f64,
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
#[derive(Debug)]
pub(super) struct Chains<'a> {
    pub(super) ways: Ways<'a>,
    links: Vec<Link>,
    crossed: Vec<Crossed>,
    /// Largest distance of a point that moves with a face from the face, units of the sheet.
    beyond: f64,
}

impl<'a> Chains<'a> {
    /// Makes an empty list of chains between faces, of which no point that moves with one is farther from it than `beyond`.
    pub(super) fn new(ways: Ways<'a>, beyond: f64) -> Self {
        Self {
            ways,
            beyond,
            links: Vec::new(),
            crossed: Vec::new(),
        }
    }

    /// Returns the length of the list of links.
    pub(super) fn len(&self) -> usize {
        self.links.len()
    }

    /// Removes all links of the list behind this length.
    pub(super) fn truncate(&mut self, len: usize) {
        self.links.truncate(len);
    }

    /// Returns all links of a chain.
    pub(super) fn links(&self, chain: &Chain) -> &[Link] {
        &self.links[chain.start..chain.end]
    }

    /// Returns the single creases of a chain, in order.
    pub(super) fn singles(&self, chain: &Chain) -> &[Link] {
        &self.links[chain.start..chain.pairs]
    }

    /// Returns the pairs of a chain.
    pub(super) fn pairs(&self, chain: &Chain) -> &[Link] {
        &self.links[chain.pairs..chain.end]
    }

    /// Returns the chain on the way that [`Ways::find`] returns.
    pub(super) fn find(&mut self, faces: [FaceId; 2], round: Option<VertexId>) -> Option<Chain> {
        let way = self.ways.find(faces, round)?;
        Some(self.chain(faces[0], &way))
    }

    /// Returns the chain on the way along the spanning tree, on which nothing is torn.
    pub(super) fn along_tree(&mut self, faces: [FaceId; 2]) -> Option<Chain> {
        let way = self.ways.along_tree(faces)?;
        Some(self.chain(faces[0], &way))
    }

    /// Makes the chain from a face along a way.
    pub(super) fn chain(&mut self, from: FaceId, way: &Way) -> Chain {
        let start = self.links.len();
        self.crossed.clear();
        for (place, &(edge, beyond)) in (0..).zip(way) {
            self.cross(edge, beyond, place);
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
        let [tear, turn] = self.torn_along(from, way);
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
    fn torn_along(&self, from: FaceId, way: &Way) -> [f64; 2] {
        let pattern = self.ways.pattern;
        let is_torn = |&(edge, _): &(EdgeId, FaceId)| self.ways.tear(edge)[1] > 0.0;
        let Some(&(_, to)) = way.last().filter(|_| way.iter().any(is_torn)) else {
            return [0.0; 2];
        };
        let pivot = |edge: EdgeId| pattern.vertices()[pattern.edge(edge).ends[0].index()];
        let away = |face: FaceId, from: Vector2<f64>| {
            let corners = pattern.faces()[face.index()].iter();
            let away = corners.map(|v| (pattern.vertices()[v.index()] - from).norm());
            away.fold(0.0, f64::max) + self.beyond
        };
        let ends = [way[0].0, way[way.len() - 1].0].map(pivot);
        let legs = way
            .windows(2)
            .map(|pair| (pivot(pair[1].0) - pivot(pair[0].0)).norm());
        let total: f64 = away(from, ends[0]) + legs.clone().sum::<f64>() + away(to, ends[1]);
        let mut before = away(from, ends[0]);
        let mut sum = [0.0; 2];
        for (&(edge, _), leg) in way.iter().zip(legs.chain([0.0])) {
            let [turn, shift] = self.ways.tear(edge);
            if shift > 0.0 {
                sum[0] += shift + turn * before.min(total - before);
                sum[1] += turn;
            }
            before += leg;
        }
        sum
    }

    /// Crosses an edge to the face beyond: appends its crease, or pairs it with the last one.
    fn cross(&mut self, edge: EdgeId, beyond: FaceId, place: u32) {
        let Ways {
            pattern,
            memberships,
            ..
        } = self.ways;
        let Some(crease) = pattern.edge(edge).crease else {
            return;
        };
        let Some(&member) = memberships.get(crease.index()) else {
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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::generate::Miura;
    use crate::pattern::CreasePattern;
    use crate::symmetry::CreaseGroups;
    use crate::util::progress::Watch;

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
            let mut chains = Chains::new(Ways::new(&pattern, groups.memberships(), None), 0.0);
            chains.ways.keep_still(still);
            for threads in [1, 3] {
                let pool = rayon::ThreadPoolBuilder::new().num_threads(threads);
                let pool = pool.build().unwrap();
                let ways = pool.install(|| chains.ways.find_all(&pairs, Watch::default()));
                assert_eq!(ways.len(), pairs.len());
                for (faces, way) in pairs.iter().zip(ways) {
                    let one = chains.find(*faces, None).unwrap();
                    let other = chains.chain(faces[0], &way.unwrap());
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
