//! Essential vertices: one real vertex for every distinct closure condition.

use std::collections::{BTreeSet, HashMap, HashSet, VecDeque};
use std::sync::OnceLock;

use foldpath_core::{
    GroupId, HalfAngle, LoopsView, Membership, Spoke, StarView, StarsView, closure, hole,
};
use nalgebra::{Vector2, Vector3};

use super::CreaseGroups;
use super::isometry::StarImage;
use super::unrounded::unround;
use crate::numbers::largest;
use crate::pattern::{
    CreaseId, CreasePattern, Drawing, DrawnEdge, FaceId, Letter, Passage, PatternError, VertexId,
};
use crate::ragged::Ragged;

/// Sector angles this close, in tolerances of the groups, are the same: both stars may be off a third
/// one by as much, and each sector has two sides.
const SAME_ANGLE: f64 = 4.0;

/// The largest closure residual of stars at the unknowns `x` (radians), 0 for none; NaN if one is.
#[must_use]
pub fn largest_star_residual(stars: StarsView<'_, f64>, x: &[f64]) -> f64 {
    let mut half_angles = vec![HalfAngle::default(); x.len()];
    closure::half_angles(x, &mut half_angles);
    let residuals = stars
        .iter()
        .map(|star| closure::residual(star, &half_angles));
    largest(residuals.map(|residual| residual.norm_squared())).sqrt()
}

/// Stars of real vertices, and loops round holes, as functions of the group angles.
#[derive(Clone, Debug)]
pub struct ReducedStars {
    vertices: Vec<VertexId>,
    spokes: Ragged<Spoke<f64>>,
    loops: Ragged<Spoke<f64>>,
    /// For each loop the number of its hole.
    holes: Vec<usize>,
    /// For each spoke of a loop where its crease is: from the middle of the hole, over its size.
    places: Vec<[f64; 2]>,
    unknowns: usize,
    /// Sector angles this close, in radians, are the same.
    same_angle: f64,
    /// For each star by how much the residual of the sheet's own may differ; empty where they are the sheet's own.
    rounded: Vec<f64>,
    /// What stars are alike, once somebody asked.
    likeness: OnceLock<Likeness>,
}

/// What stars are alike.
#[derive(Clone, Debug)]
struct Likeness {
    /// For each star the first one that is the same bit by bit.
    twins: Vec<usize>,
    /// For each star the first one with the same closure condition.
    conditions: Vec<usize>,
}

impl ReducedStars {
    /// The stars of all real vertices that a hinge ends at, and the loops round all holes.
    #[must_use]
    pub fn all(pattern: &CreasePattern, groups: &CreaseGroups) -> Self {
        Self::new(pattern, groups.len(), groups.tolerance(), |crease| {
            groups.of(crease)
        })
    }

    /// The same where each crease is a group of its own.
    #[must_use]
    pub fn of_creases(pattern: &CreasePattern) -> Self {
        Self::new(pattern, pattern.creases().len(), 0.0, |crease| Membership {
            group: GroupId(crease.0),
            negative: false,
        })
    }

    fn new(
        pattern: &CreasePattern,
        unknowns: usize,
        tolerance: f64,
        membership: impl Fn(CreaseId) -> Membership,
    ) -> Self {
        let mut stars = Self {
            vertices: Vec::with_capacity(pattern.vertices().len()),
            spokes: Ragged::with_capacity(pattern.vertices().len(), 2 * pattern.creases().len()),
            loops: Ragged::default(),
            holes: Vec::new(),
            places: Vec::new(),
            unknowns,
            same_angle: SAME_ANGLE * tolerance,
            rounded: Vec::new(),
            likeness: OnceLock::new(),
        };
        for hole in 0..pattern.holes().len() {
            stars.add_loop(pattern, &membership, hole);
        }
        for vertex in pattern.real_vertices() {
            let star = &pattern.stars()[vertex.index()];
            if star.iter().all(|&id| pattern.edge(id).crease.is_none()) {
                continue;
            }
            stars.vertices.push(vertex);
            stars.spokes.push(star.iter().filter_map(|&id| {
                let Membership { group, negative } = membership(pattern.edge(id).crease?);
                Some(Spoke {
                    group,
                    negative,
                    direction: pattern.direction(id, vertex).into(),
                })
            }));
        }
        stars
    }

    fn add_loop(
        &mut self,
        pattern: &CreasePattern,
        membership: &impl Fn(CreaseId) -> Membership,
        hole: usize,
    ) {
        let way = &pattern.holes()[hole];
        let place = |passage: &Passage| pattern.vertices()[passage.at.index()];
        #[allow(clippy::cast_precision_loss, reason = "a mean")]
        let middle = way.iter().map(place).sum::<Vector2<f64>>() / way.len() as f64;
        let from_middle = way.iter().map(|passage| (place(passage) - middle).norm());
        let size = from_middle.fold(f64::MIN_POSITIVE, f64::max);
        let mut spokes = Vec::new();
        for passage in way {
            let edge = pattern.edge(passage.edge);
            let Some(crease) = edge.crease else { continue };
            let Membership { group, negative } = membership(crease);
            // A valley turns what is on the left of its direction up.
            let start = edge.ends[usize::from(edge.faces[0] != Some(passage.to))];
            spokes.push(Spoke {
                group,
                negative,
                direction: pattern.direction(passage.edge, start).into(),
            });
            self.places.push(((place(passage) - middle) / size).into());
        }
        if !spokes.is_empty() {
            self.loops.push(spokes);
            self.holes.push(hole);
        }
    }

    /// One star for every distinct closure condition: two are the same if a rotation or mirror image
    /// takes one to the other, group by group, with all signs kept or all exchanged. Every loop is kept.
    #[must_use]
    pub fn essential(&self) -> Self {
        self.firsts(&self.likeness().conditions)
    }

    /// The stars that differ in a bit from all before, and every loop: as coordinates are rounded, a few of
    /// each condition. Their residuals are those of all stars, each bit of them.
    #[must_use]
    pub fn distinct(&self) -> Self {
        self.firsts(&self.likeness().twins)
    }

    /// The same stars, those alike that are so to rounding: what the others differ by counts.
    #[must_use]
    pub fn told_apart(&self) -> Self {
        Self {
            same_angle: 0.0,
            likeness: OnceLock::new(),
            ..self.clone()
        }
    }

    /// The same stars with spokes turned the least so that all sets of them fold flat that do so but for `within` (radians)
    /// at each two, as lines that pass a vertex straight: as they were before coordinates were rounded. And the largest angle
    /// by which one is turned, 0 if none is.
    #[must_use]
    pub fn unrounded(&self, within: f64) -> (Self, f64) {
        let mut most = 0.0_f64;
        let mut rounded = Vec::with_capacity(self.spokes.len());
        let stars = self.spokes.iter().enumerate().map(|(star, spokes)| {
            let mut spokes = spokes.to_vec();
            let turns = unround(&mut spokes, within);
            most = turns.iter().copied().fold(most, f64::max);
            // A crease off by an angle takes the residual along by twice that at most.
            let before = self.rounded.get(star).copied().unwrap_or(0.0);
            rounded.push(before + 2.0 * turns.iter().sum::<f64>());
            spokes
        });
        let spokes = stars.collect();
        let unrounded = Self {
            spokes,
            rounded,
            likeness: OnceLock::new(),
            ..self.clone()
        };
        (unrounded, most)
    }

    /// The stars that are the first of those like them, and every loop.
    fn firsts(&self, first: &[usize]) -> Self {
        let stars = || (0..first.len()).filter(|&star| first[star] == star);
        Self {
            vertices: stars().map(|star| self.vertices[star]).collect(),
            spokes: stars().map(|star| self.spokes[star].to_vec()).collect(),
            loops: self.loops.clone(),
            holes: self.holes.clone(),
            places: self.places.clone(),
            unknowns: self.unknowns,
            same_angle: self.same_angle,
            rounded: stars()
                .filter_map(|star| self.rounded.get(star).copied())
                .collect(),
            likeness: OnceLock::new(),
        }
    }

    /// For each star the one of [`essential`](Self::essential) that stands for it, and by how much their
    /// residuals may differ at any angles, as the sheet has the first: stars that count as the same are so up to
    /// roundings, or up to the roughness of the sheet.
    #[must_use]
    pub fn represented(&self) -> Vec<(usize, f64)> {
        let Likeness { twins, conditions } = self.likeness();
        let mut stars: Vec<(usize, f64)> = Vec::with_capacity(twins.len());
        let mut count = 0;
        for (star, (&twin, &first)) in twins.iter().zip(conditions).enumerate() {
            stars.push(if twin < star {
                stars[twin]
            } else if first < star {
                let (from, to) = (&self.spokes[first], &self.spokes[star]);
                let image = same_condition(from, to, self.same_angle);
                let off = image.map_or(f64::INFINITY, |image| difference(from, to, image));
                (stars[first].0, off)
            } else {
                count += 1;
                (count - 1, 0.0)
            });
        }
        for ((_, off), rounded) in stars.iter_mut().zip(&self.rounded) {
            *off += rounded;
        }
        stars
    }

    /// What stars are alike. Cost: linear in the spokes.
    fn likeness(&self) -> &Likeness {
        self.likeness.get_or_init(|| {
            let [mut by_bits, mut by_groups] = [HashMap::new(), HashMap::new()];
            let mut twins = Vec::with_capacity(self.spokes.len());
            let mut conditions: Vec<usize> = Vec::with_capacity(self.spokes.len());
            for (star, spokes) in self.spokes.iter().enumerate() {
                let same_bits = |other: usize| {
                    let other = self.spokes[other].iter();
                    spokes.iter().map(bits).eq(other.map(bits))
                };
                let twin = first_alike(&mut by_bits, bits_key(spokes), star, same_bits);
                twins.push(twin);
                conditions.push(if twin < star {
                    conditions[twin]
                } else {
                    first_alike(&mut by_groups, groups_key(spokes), star, |other| {
                        same_condition(&self.spokes[other], spokes, self.same_angle).is_some()
                    })
                });
            }
            Likeness { twins, conditions }
        })
    }

    /// Residuals of all stars, then of all loops, at the group angles `x` (radians): norms of a star's
    /// three, and of the rotation and the translation of a loop's.
    #[must_use]
    pub fn residuals(&self, x: &[f64]) -> Vec<f64> {
        let mut half_angles = vec![HalfAngle::default(); x.len()];
        closure::half_angles(x, &mut half_angles);
        self.squares(&half_angles).map(f64::sqrt).collect()
    }

    /// The largest of the [`residuals`](Self::residuals), 0 for none; NaN if one is.
    #[must_use]
    pub fn largest_residual(&self, x: &[f64]) -> f64 {
        let mut half_angles = vec![HalfAngle::default(); x.len()];
        closure::half_angles(x, &mut half_angles);
        largest(self.squares(&half_angles)).sqrt()
    }

    /// Squares of the residuals.
    fn squares(&self, half_angles: &[HalfAngle<f64>]) -> impl Iterator<Item = f64> {
        let stars = self.spokes.iter().map(|spokes| StarView { spokes });
        let stars = stars.map(|star| closure::residual(star, half_angles).norm_squared());
        let loops = self.loops().iter().map(|cycle| {
            let parts = hole::residuals(cycle, half_angles);
            largest(parts.iter().map(Vector3::norm_squared))
        });
        stars.chain(loops)
    }

    /// Whether there is no condition.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.spokes.is_empty() && self.loops.is_empty()
    }

    /// The vertices, in the order of the stars.
    #[must_use]
    pub fn vertices(&self) -> &[VertexId] {
        &self.vertices
    }

    /// The stars as the solvers take them.
    ///
    /// # Panics
    /// Never: stars are built from groups that exist.
    #[must_use]
    pub fn view(&self) -> StarsView<'_, f64> {
        StarsView::new(self.spokes.items(), self.spokes.ends(), self.unknowns)
            .expect("stars refer to groups that exist")
    }

    /// The hole of each loop, as its number in [`CreasePattern::holes`].
    #[must_use]
    pub fn holes(&self) -> &[usize] {
        &self.holes
    }

    /// The loops as the solvers take them.
    ///
    /// # Panics
    /// Never: loops are built from groups that exist.
    #[must_use]
    pub fn loops(&self) -> LoopsView<'_, f64> {
        let (spokes, ends) = (self.loops.items(), self.loops.ends());
        LoopsView::new(spokes, &self.places, ends, self.unknowns)
            .expect("loops refer to groups that exist")
    }
}

/// The first star that is the `same` as this, of those with the same key; this if none before is.
fn first_alike(
    firsts: &mut HashMap<u64, Vec<usize>>,
    key: u64,
    star: usize,
    same: impl Fn(usize) -> bool,
) -> usize {
    let firsts = firsts.entry(key).or_default();
    let before = firsts.iter().copied().find(|&before| same(before));
    before.unwrap_or_else(|| {
        firsts.push(star);
        star
    })
}

/// All that a spoke is, so that spokes that are equal turn residuals alike to the last bit.
fn bits(spoke: &Spoke<f64>) -> [u64; 3] {
    let [x, y] = spoke.direction.map(f64::to_bits);
    let turn = u64::from(spoke.group.0) << 1 | u64::from(spoke.negative);
    [turn, x, y]
}

/// A number that stars of the same bits share, and others hardly ever do.
fn bits_key(star: &[Spoke<f64>]) -> u64 {
    // Digits of the golden ratio mix bits well.
    star.iter().flat_map(bits).fold(0, |key: u64, bits| {
        (key.rotate_left(29) ^ bits).wrapping_mul(0x9e37_79b9_7f4a_7c15)
    })
}

/// A number that stars with the same groups share, whatever their order, and others hardly ever do.
fn groups_key(star: &[Spoke<f64>]) -> u64 {
    // Digits of the golden ratio and of the root of 2 mix bits well.
    let mixed = star.iter().map(|spoke| {
        let bits = (u64::from(spoke.group.0) + 1).wrapping_mul(0x9e37_79b9_7f4a_7c15);
        (bits ^ (bits >> 32)).wrapping_mul(0x6a09_e667_f3bc_c909)
    });
    mixed.fold(0, u64::wrapping_add)
}

/// How star `a` lies on star `b`, if both are the same condition.
fn same_condition(a: &[Spoke<f64>], b: &[Spoke<f64>], same_angle: f64) -> Option<StarImage> {
    let n = a.len();
    let matches = |image: &StarImage, flipped: bool| {
        let same_crease = |k: usize| {
            let (from, to) = (&a[k], image.of(k, b));
            from.group == to.group && (from.negative == to.negative) != flipped
        };
        let same_sector = |k: usize| {
            let [from, to] = [image.of(k, b), image.of(k + 1, b)];
            let image = if image.mirrored {
                sector(to, from)
            } else {
                sector(from, to)
            };
            let difference = sector(&a[k], &a[if k + 1 < n { k + 1 } else { 0 }]) - image;
            difference.norm_squared() <= same_angle * same_angle
        };
        (0..n).all(same_crease) && (0..n).all(same_sector)
    };
    let both = [false, true];
    let images = (0..n).flat_map(|first| both.map(|mirrored| StarImage { first, mirrored }));
    let mut images = images.filter(|_| n == b.len());
    images.find(|image| both.iter().any(|&flipped| matches(image, flipped)))
}

/// How far the residuals of two stars may differ of which one lies on the other.
fn difference(a: &[Spoke<f64>], b: &[Spoke<f64>], image: StarImage) -> f64 {
    let turned = |[x, y]: [f64; 2]| Vector2::new(x, if image.mirrored { -y } else { y });
    let from = turned(a[0].direction);
    let to = Vector2::from(image.of(0, b).direction);
    let (cos, sin) = (from.dot(&to), from.perp(&to));
    let off = a.iter().enumerate().map(|(k, spoke)| {
        let a = turned(spoke.direction);
        let laid = Vector2::new(cos * a.x - sin * a.y, sin * a.x + cos * a.y);
        (laid - Vector2::from(image.of(k, b).direction)).norm() + 8.0 * f64::EPSILON
    });
    // A crease off by an angle takes the residual along by twice that at most.
    2.0 * off.sum::<f64>()
}

/// Cosine and sine of the angle from one direction to another, counter-clockwise. Two angles differ by
/// the distance of these, as far as they are small.
fn sector(from: &Spoke<f64>, to: &Spoke<f64>) -> Vector2<f64> {
    let [from, to] = [from, to].map(|spoke| Vector2::from(spoke.direction));
    Vector2::new(from.dot(&to), from.perp(&to))
}

/// The essential crease pattern: a small part of the sheet, without holes at its vertices, in which
/// a vertex for each essential condition of `all` its stars is real. Returned with the creases of the
/// whole sheet that its creases are.
///
/// # Errors
/// Never for a valid pattern; the error of the part that could not be cut out.
pub fn essential_pattern(
    pattern: &CreasePattern,
    all: &ReducedStars,
) -> Result<(CreasePattern, Vec<CreaseId>), PatternError> {
    let mut faces = essential_faces(pattern, all);
    // Two faces that meet in a point: the part grows until none do.
    while let Some(vertex) = meeting_point(pattern, &faces) {
        faces.extend(&pattern.corners()[vertex.index()]);
    }
    cut_out(pattern, &faces)
}

/// A vertex round which the faces of the part are not one fan.
fn meeting_point(pattern: &CreasePattern, part: &BTreeSet<FaceId>) -> Option<VertexId> {
    let broken = |vertex: &VertexId| {
        let faces = pattern.corners()[vertex.index()].iter();
        let star = pattern.stars()[vertex.index()].iter();
        let inner = star.filter_map(|&edge| pattern.edge(edge).inner_faces());
        let joints = inner.filter(|faces| faces.iter().all(|face| part.contains(face)));
        joints.count() + 1 < faces.filter(|face| part.contains(face)).count()
    };
    let corners = part.iter().flat_map(|face| &pattern.faces()[face.index()]);
    corners.copied().find(broken)
}

/// Faces round one vertex for each condition, the vertices as near to the first as can be, with the
/// faces round the vertices between.
fn essential_faces(pattern: &CreasePattern, all: &ReducedStars) -> BTreeSet<FaceId> {
    let conditions = &all.likeness().conditions[..];
    let Some(&start) = all.vertices.first() else {
        return (0..pattern.faces().len().min(1)).map(FaceId::new).collect();
    };
    let mut condition_at = vec![None; pattern.vertices().len()];
    for (vertex, &condition) in all.vertices.iter().zip(conditions) {
        condition_at[vertex.index()] = Some(condition);
    }
    let first = |index: &usize| conditions[*index] == *index;
    let mut missing: HashSet<usize> = (0..conditions.len()).filter(first).collect();
    let mut faces = BTreeSet::new();
    let mut taken = vec![false; pattern.vertices().len()];
    let mut before = vec![None; pattern.vertices().len()];
    before[start.index()] = Some(start);
    let mut open = VecDeque::from([start]);
    while let Some(vertex) = open.pop_front() {
        let condition = condition_at[vertex.index()];
        if condition.is_some_and(|condition| missing.remove(&condition)) {
            // The way back to the start, as far as no other took it before.
            let mut way = Some(vertex).filter(|v| !taken[v.index()]);
            while let Some(vertex) = way {
                taken[vertex.index()] = true;
                faces.extend(&pattern.corners()[vertex.index()]);
                way = before[vertex.index()].filter(|back: &VertexId| !taken[back.index()]);
            }
            if missing.is_empty() {
                break;
            }
        }
        for &edge in &pattern.stars()[vertex.index()] {
            let next = pattern.edge(edge).other_end(vertex);
            if before[next.index()].is_none() {
                before[next.index()] = Some(vertex);
                open.push_back(next);
            }
        }
    }
    faces
}

type Part = (CreasePattern, Vec<CreaseId>);

/// The pattern of these faces alone.
fn cut_out(pattern: &CreasePattern, faces: &BTreeSet<FaceId>) -> Result<Part, PatternError> {
    let mut drawing = Drawing {
        faces: Some(Vec::new()),
        ..Drawing::default()
    };
    let mut new_vertex = vec![None; pattern.vertices().len()];
    let mut vertices = Vec::new();
    for face in faces {
        let cycle = pattern.faces()[face.index()].iter().map(|&vertex| {
            *new_vertex[vertex.index()].get_or_insert_with(|| {
                vertices.push(vertex);
                vertices.len() - 1
            })
        });
        let cycle = cycle.collect();
        drawing.faces.get_or_insert_default().push(cycle);
    }
    drawing.vertices = vertices
        .iter()
        .map(|v| pattern.vertices()[v.index()])
        .collect();
    let round = |vertex: &VertexId| pattern.stars()[vertex.index()].iter().copied();
    let edges: BTreeSet<_> = vertices.iter().flat_map(round).collect();
    let mut creases = Vec::new();
    for edge in edges {
        let edge = pattern.edge(edge);
        let sides = edge.faces.iter().flatten().filter(|f| faces.contains(f));
        let sides = sides.count();
        let ends = edge.ends.map(|end| new_vertex[end.index()]);
        if let (1.., [Some(a), Some(b)]) = (sides, ends) {
            drawing.edges.push(DrawnEdge {
                ends: [a, b],
                letter: if sides == 2 {
                    edge.letter
                } else {
                    Letter::Boundary
                },
                goal: edge.goal.filter(|_| sides == 2),
            });
            creases.extend(edge.crease.filter(|_| sides == 2));
        }
    }
    Ok((CreasePattern::new(drawing)?, creases))
}
