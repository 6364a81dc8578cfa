//! Finds the essential vertices: one real vertex for every distinct closure condition in terms of the crease groups.

use std::collections::HashMap;
use std::sync::OnceLock;

use foldpath_core::{
    GroupId, HalfAngle, LoopsView, Membership, Spoke, StarView, StarsView, closure, hole,
};
use nalgebra::{Vector2, Vector3};

use super::CreaseGroups;
use super::isometry::StarImage;
use super::snapping::snap;
use crate::pattern::{CreaseId, CreasePattern, VertexId};
use crate::util::csr::Csr;
use crate::util::nan_max::largest;

/// Largest difference of sector angles that count as equal, in tolerances of the groups: two stars may each differ from
/// a third by one tolerance, and each sector has two sides.
const SAME_ANGLE_TOLERANCES: f64 = 4.0;

/// Returns the largest closure residual of stars at the unknowns `x` (radians), 0 without stars; NaN if a residual is
/// NaN.
#[must_use]
pub fn largest_star_residual(stars: StarsView<'_, f64>, x: &[f64]) -> f64 {
    let mut half_angles = vec![HalfAngle::default(); x.len()];
    closure::half_angles(x, &mut half_angles);
    let residuals = stars
        .iter()
        .map(|star| closure::residual(star, &half_angles));
    largest(residuals.map(|residual| residual.norm_squared())).sqrt()
}

/// Stars of real vertices and loops round holes, as functions of the group angles.
#[derive(Clone, Debug)]
pub struct ReducedStars {
    vertices: Vec<VertexId>,
    spokes: Csr<Spoke<f64>>,
    loops: Csr<Spoke<f64>>,
    /// The number of each loop's hole.
    holes: Vec<usize>,
    /// Position of each spoke of a loop, relative to the middle of the hole and in units of the hole's size.
    places: Vec<[f64; 2]>,
    unknowns: usize,
    /// Largest difference of sector angles that count as equal, radians.
    same_angle: f64,
    /// For each star a bound on the difference between its residual and that of the sheet's own star; empty if the
    /// stars are the sheet's own.
    rounded: Vec<f64>,
    /// Classes of equal stars, computed on first use.
    likeness: OnceLock<Likeness>,
}

/// Classes of equal stars.
#[derive(Clone, Debug)]
struct Likeness {
    /// For each star the first star that is equal to it bit by bit.
    twins: Vec<usize>,
    /// For each star the first star with the same closure condition.
    conditions: Vec<usize>,
}

impl ReducedStars {
    /// Builds the stars of all real vertices at which a hinge ends, and the loops round all holes.
    #[must_use]
    pub fn all(pattern: &CreasePattern, groups: &CreaseGroups) -> Self {
        Self::new(pattern, groups.len(), groups.tolerance(), |crease| {
            groups.of(crease)
        })
    }

    /// Builds the stars and loops with every crease as a group of its own.
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
            spokes: Csr::with_capacity(pattern.vertices().len(), 2 * pattern.creases().len()),
            loops: Csr::default(),
            holes: Vec::new(),
            places: Vec::new(),
            unknowns,
            same_angle: SAME_ANGLE_TOLERANCES * tolerance,
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
        let (middle, size) = pattern.hole_frame(hole);
        let mut spokes = Vec::new();
        for passage in way {
            let edge = pattern.edge(passage.edge);
            let Some(crease) = edge.crease else { continue };
            let Membership { group, negative } = membership(crease);
            // A valley turns the face to the left of its direction up.
            let start = edge.ends[usize::from(edge.faces[0] != Some(passage.to))];
            spokes.push(Spoke {
                group,
                negative,
                direction: pattern.direction(passage.edge, start).into(),
            });
            let place = pattern.vertices()[passage.at.index()];
            self.places.push(((place - middle) / size).into());
        }
        if !spokes.is_empty() {
            self.loops.push(spokes);
            self.holes.push(hole);
        }
    }

    /// Keeps one star for every distinct closure condition, and every loop. Two conditions are equal if a rotation or
    /// reflection takes one star to the other, group by group, with all signs kept or all signs exchanged.
    #[must_use]
    pub fn essential(&self) -> Self {
        self.firsts(&self.likeness().conditions)
    }

    /// Keeps one star of all that are equal bit by bit, and every loop. Rounded coordinates leave a few distinct stars
    /// for each condition. The residuals of the kept stars are those of all stars, bit by bit.
    #[must_use]
    pub fn distinct(&self) -> Self {
        self.firsts(&self.likeness().twins)
    }

    /// Returns these stars with a tolerance of 0 for equal conditions: only stars whose sectors agree as computed count
    /// as equal, and any other difference counts.
    #[must_use]
    pub fn unmerged(&self) -> Self {
        Self {
            same_angle: 0.0,
            likeness: OnceLock::new(),
            ..self.clone()
        }
    }

    /// Turns the spokes by least angles such that every set of spokes folds flat exactly that folds flat up to `within`
    /// (radians) for each two spokes, such as lines that pass a vertex straight: this restores the stars from before
    /// their coordinates were rounded. Returns the stars and the largest angle (radians) by which a spoke is turned, 0
    /// if none is.
    #[must_use]
    pub fn snapped(&self, within: f64) -> (Self, f64) {
        let mut most = 0.0_f64;
        let mut rounded = Vec::with_capacity(self.spokes.len());
        let stars = self.spokes.iter().enumerate().map(|(star, spokes)| {
            let mut spokes = spokes.to_vec();
            let turns = snap(&mut spokes, within);
            most = turns.iter().copied().fold(most, f64::max);
            // A crease whose direction is off by an angle changes the residual by at most twice that angle.
            let before = self.rounded.get(star).copied().unwrap_or(0.0);
            rounded.push(before + 2.0 * turns.iter().sum::<f64>());
            spokes
        });
        let spokes = stars.collect();
        let snapped = Self {
            spokes,
            rounded,
            likeness: OnceLock::new(),
            ..self.clone()
        };
        (snapped, most)
    }

    /// Returns `true` if the stars are those of the others in every bit.
    pub(crate) fn has_stars_of(&self, other: &Self) -> bool {
        let count = self.spokes.len();
        count == other.spokes.len()
            && (0..count).all(|star| self.spokes[star] == other.spokes[star])
    }

    /// Keeps the stars that are the first of their class, and every loop.
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

    /// Returns, for each star of the sheet, the index of the star of [`essential`](Self::essential) that represents it,
    /// and a bound on the difference of their residuals at any angles. The difference comes from rounding, or from the
    /// roughness of the sheet, as stars with the same condition are equal only up to a tolerance.
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

    /// Returns the classes of equal stars. Cost: linear in the number of spokes.
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

    /// Returns the residuals of all stars, then of all loops, at the group angles `x` (radians). The residual of a star
    /// is the norm of its three numbers; that of a loop is the larger of the norms of its rotation and its translation.
    #[must_use]
    pub fn residuals(&self, x: &[f64]) -> Vec<f64> {
        let mut half_angles = vec![HalfAngle::default(); x.len()];
        closure::half_angles(x, &mut half_angles);
        self.squares(&half_angles).map(f64::sqrt).collect()
    }

    /// Returns the largest of the [`residuals`](Self::residuals), 0 for none; NaN if a residual is NaN.
    #[must_use]
    pub fn largest_residual(&self, x: &[f64]) -> f64 {
        let mut half_angles = vec![HalfAngle::default(); x.len()];
        closure::half_angles(x, &mut half_angles);
        largest(self.squares(&half_angles)).sqrt()
    }

    /// Returns the squares of the residuals.
    fn squares(&self, half_angles: &[HalfAngle<f64>]) -> impl Iterator<Item = f64> {
        let stars = self.spokes.iter().map(|spokes| StarView { spokes });
        let stars = stars.map(|star| closure::residual(star, half_angles).norm_squared());
        let loops = self.loops().iter().map(|cycle| {
            let parts = hole::residuals(cycle, half_angles);
            largest(parts.iter().map(Vector3::norm_squared))
        });
        stars.chain(loops)
    }

    /// Returns `true` if there is no closure condition.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.spokes.is_empty() && self.loops.is_empty()
    }

    /// Returns for each star the first star with the same closure condition.
    pub(super) fn conditions(&self) -> &[usize] {
        &self.likeness().conditions
    }

    /// Returns the vertex of each star.
    #[must_use]
    pub fn vertices(&self) -> &[VertexId] {
        &self.vertices
    }

    /// Returns the stars as the solvers take them.
    ///
    /// # Panics
    /// Never: stars are built from groups that exist.
    #[must_use]
    pub fn view(&self) -> StarsView<'_, f64> {
        StarsView::new(self.spokes.items(), self.spokes.ends(), self.unknowns)
            .expect("stars refer to groups that exist")
    }

    /// Returns the hole of each loop, as its number in [`CreasePattern::holes`].
    #[must_use]
    pub fn holes(&self) -> &[usize] {
        &self.holes
    }

    /// Returns the loops as the solvers take them.
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

/// Returns the first star with the same key that is the `same` as this star, or this star if there is no earlier one.
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

/// Returns all data of a spoke as bits. Stars with equal bits have residuals that are equal to the last bit.
fn bits(spoke: &Spoke<f64>) -> [u64; 3] {
    let [x, y] = spoke.direction.map(f64::to_bits);
    let turn = u64::from(spoke.group.0) << 1 | u64::from(spoke.negative);
    [turn, x, y]
}

/// Hashes a star by its bits.
fn bits_key(star: &[Spoke<f64>]) -> u64 {
    // The digits of the golden ratio mix bits well (Fibonacci hashing).
    star.iter().flat_map(bits).fold(0, |key: u64, bits| {
        (key.rotate_left(29) ^ bits).wrapping_mul(0x9e37_79b9_7f4a_7c15)
    })
}

/// Hashes a star by its groups, independently of their order.
fn groups_key(star: &[Spoke<f64>]) -> u64 {
    // The digits of the golden ratio and of the square root of 2 mix bits well.
    let mixed = star.iter().map(|spoke| {
        let bits = (u64::from(spoke.group.0) + 1).wrapping_mul(0x9e37_79b9_7f4a_7c15);
        (bits ^ (bits >> 32)).wrapping_mul(0x6a09_e667_f3bc_c909)
    });
    mixed.fold(0, u64::wrapping_add)
}

/// Returns the matching of the spokes of star `a` with those of star `b` if both have the same closure condition.
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

/// Returns a bound on the difference of the residuals of two matching stars.
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
    // A crease whose direction is off by an angle changes the residual by at most twice that angle.
    2.0 * off.sum::<f64>()
}

/// Returns cosine and sine of the angle from one direction to another, counter-clockwise. The distance between two such
/// points is about the difference of the angles, as long as it is small.
fn sector(from: &Spoke<f64>, to: &Spoke<f64>) -> Vector2<f64> {
    let [from, to] = [from, to].map(|spoke| Vector2::from(spoke.direction));
    Vector2::new(from.dot(&to), from.perp(&to))
}

/// Returns the largest closure residual of the whole sheet at given fold angles of the creases, radians; `None` if a
/// crease has no angle.
#[must_use]
pub fn closure_of(pattern: &CreasePattern, fold_angles: &[Option<f64>]) -> Option<f64> {
    let angles = fold_angles.iter().copied().collect::<Option<Vec<f64>>>()?;
    Some(ReducedStars::of_creases(pattern).largest_residual(&angles))
}
