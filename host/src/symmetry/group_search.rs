//! Finds crease groups from the partial symmetries of the sheet.
//!
//! Answers an open question of [XiLien2015]: how to find crease groups without a path. Two vertices with congruent
//! stars determine a planar isometry that takes one star to the other, perhaps with mountain and valley exchanged. The
//! isometry is a partial symmetry if it maps the whole overlap of the sheet with its own image to itself, letters and
//! goal angles included; then each crease and its image may turn alike. Union-find with parity turns these relations
//! into groups and signs.
//!
//! This does not imply that the symmetric motion exists: the caller checks the closure of the whole sheet at the
//! reduced configurations.

use core::f64::consts::TAU;
use std::collections::BTreeMap;

use nalgebra::Vector2;

use super::CreaseGroups;
use super::groups::EXACT_TOLERANCE;
use super::isometry::{Isometry, StarImage};
use super::places::Places;
use super::signed_union_find::SignedUnionFind;
use crate::pattern::{CreaseId, CreasePattern, Letter, VertexId};
use crate::progress::Watch;
use crate::util::angle::turn_between;
use crate::util::csr::Csr;

/// Factor by which the tolerance for stars exceeds that for whole sheets if coordinates are rough: a single star does
/// not determine its isometry well enough.
const ROUGH_STAR_FACTOR: f64 = 2.0;
/// Largest distance, in tolerances, of a vertex from its image while an isometry is fitted.
const REACH_TOLERANCES: f64 = 10.0;
/// Largest difference of goal angles within one group, radians: half a degree covers goals that were measured or
/// rounded.
const SAME_GOAL_RAD: f64 = 1e-2;

/// Budget of compared vertices: `MIN_BUDGET_VERTICES` plus `MAX_PASSES` times their number. A tessellation needs a handful
/// of passes. A sheet with a defect could need as many passes as it has vertices; when its budget is used up, the search
/// keeps the groups found until then.
const MIN_BUDGET_VERTICES: usize = 1_000_000;
const MAX_PASSES: usize = 64;

/// Makes a set of each crease.
pub(super) fn set_of_each_crease(pattern: &CreasePattern) -> SignedUnionFind {
    let goals = pattern.creases().iter().map(|&id| pattern.edge(id).goal);
    SignedUnionFind::new(goals, SAME_GOAL_RAD)
}

/// A hinge as seen from a vertex.
#[derive(Clone, Copy)]
struct Ray {
    direction: Vector2<f64>,
    crease: CreaseId,
    letter: Letter,
    /// Goal angle, radians; NaN for none.
    goal: f64,
}

impl Ray {
    /// Returns `true` if letter and goal of this hinge allow an isometry to take it to `image`; positions are not
    /// compared.
    fn agrees(&self, image: &Self, flips: bool) -> bool {
        let letter = if flips {
            self.letter.flipped()
        } else {
            self.letter
        };
        let goal = if flips { -self.goal } else { self.goal };
        let no_goal = goal.is_nan() && image.goal.is_nan();
        letter == image.letter && (no_goal || (goal - image.goal).abs() <= SAME_GOAL_RAD)
    }
}

/// A class of vertices with congruent stars.
struct Kind {
    /// The first vertex of the class.
    vertex: VertexId,
    /// `true` if all congruences of the star with itself are known to turn hinges alike. Then a single congruence with
    /// another star yields the same relations as all of them.
    settled: bool,
}

/// The kinds found so far. A star is compared only with kinds whose smallest sector is about as large.
struct Kinds {
    all: Vec<Kind>,
    /// The kinds by the number of creases and the smallest sector, in units of `width`.
    by_sector: BTreeMap<(usize, u32), Vec<usize>>,
    /// An angle (radians) by which sectors of congruent stars differ at most.
    width: f64,
}

impl Kinds {
    /// Makes an empty set for stars whose directions differ by at most `tolerance` (the length between two unit vectors)
    /// from the image of a congruent star.
    fn new(tolerance: f64) -> Self {
        Self {
            all: Vec::new(),
            by_sector: BTreeMap::new(),
            // Two directions bound a sector. An angle exceeds its chord by less than a tenth.
            width: 2.2 * tolerance,
        }
    }

    /// Adds a kind with the star of its vertex.
    fn push(&mut self, kind: Kind, star: &[Ray]) {
        let key = self.key(star);
        self.by_sector.entry(key).or_default().push(self.all.len());
        self.all.push(kind);
    }

    /// Returns, in their order, the kinds that may be congruent with a star.
    fn alike(&self, star: &[Ray]) -> Vec<usize> {
        let (degree, sector) = self.key(star);
        let sectors = (degree, sector.saturating_sub(1))..=(degree, sector + 1);
        let mut alike: Vec<usize> = self
            .by_sector
            .range(sectors)
            .flat_map(|(_, kinds)| kinds)
            .copied()
            .collect();
        alike.sort_unstable();
        alike
    }

    /// Returns the number of creases of a star, and its smallest sector in units of the width.
    fn key(&self, star: &[Ray]) -> (usize, u32) {
        let following = star.iter().cycle().skip(1);
        let sectors = star
            .iter()
            .zip(following)
            .map(|(a, b)| turn_between(a.direction, b.direction));
        let least = sectors.fold(TAU, f64::min);
        #[allow(
            clippy::cast_possible_truncation,
            clippy::cast_sign_loss,
            reason = "at most 2π in units of 2e-6"
        )]
        let units = (least / self.width) as u32;
        (star.len(), units)
    }
}

/// Searches for isometries that are partial symmetries.
pub(super) struct GroupSearch<'a> {
    pattern: &'a CreasePattern,
    tolerance: f64,
    places: Places<'a>,
    rays: Csr<Ray>,
    real: Vec<VertexId>,
    sets: SignedUnionFind,
    /// Relations that the current isometry implies, and the inner vertices that it maps, with their images.
    found: Vec<(CreaseId, CreaseId)>,
    mapped: Vec<(VertexId, VertexId)>,
    /// Sets of vertices that symmetries take to each other.
    orbits: SignedUnionFind,
    /// For each vertex the number of the last isometry that took another vertex to it.
    image_of: Vec<u32>,
    /// For each crease the number of the last isometry for which its image was recorded, from either of its ends.
    noted: Vec<u32>,
    isometries: u32,
    /// Square of the largest difference between directions that counted as equal.
    worst: f64,
    /// Number of vertices that may still be compared.
    budget: usize,
    watch: Watch<'a>,
}

impl<'a> GroupSearch<'a> {
    pub(super) fn new(pattern: &'a CreasePattern, tolerance: f64, watch: Watch<'a>) -> Self {
        let stars = pattern.stars();
        let mut rays = Csr::with_capacity(stars.len(), stars.items().len());
        for (vertex, star) in stars.iter().enumerate() {
            rays.push(star.iter().filter_map(|&id| {
                let edge = pattern.edge(id);
                Some(Ray {
                    direction: pattern.direction(id, VertexId::new(vertex)),
                    crease: edge.crease?,
                    letter: edge.letter,
                    goal: edge.goal.unwrap_or(f64::NAN),
                })
            }));
        }
        let real = pattern.real_vertices();
        let real = real.filter(|v| !rays[v.index()].is_empty()).collect();
        Self {
            pattern,
            tolerance,
            places: Places::new(pattern, tolerance * pattern.median_edge()),
            rays,
            real,
            sets: set_of_each_crease(pattern),
            found: Vec::with_capacity(pattern.creases().len()),
            mapped: Vec::with_capacity(pattern.vertices().len()),
            orbits: SignedUnionFind::new(pattern.vertices().iter().map(|_| None), 0.0),
            image_of: vec![0; pattern.vertices().len()],
            noted: vec![0; pattern.creases().len()],
            isometries: 0,
            worst: 0.0,
            budget: MIN_BUDGET_VERTICES + MAX_PASSES * pattern.vertices().len(),
            watch,
        }
    }

    /// Returns the groups, the number of kinds of stars, and the largest difference between directions that counted as
    /// equal.
    pub(super) fn run(mut self) -> (CreaseGroups, usize, f64) {
        let mut kinds = Kinds::new(self.star_tolerance());
        for index in 0..self.real.len() {
            if self.watch.is_over() {
                break;
            }
            let vertex = self.real[index];
            let star = &self.rays[vertex.index()];
            let alike = kinds.alike(star);
            let told = |&kind: &usize| self.is_told(&kinds.all[kind], vertex);
            if alike.iter().any(told) {
                continue;
            }
            let mut known = false;
            for kind in alike {
                known |= self.try_all(&mut kinds.all[kind], vertex);
            }
            if !known {
                let settled = false;
                let mut kind = Kind { vertex, settled };
                self.try_all(&mut kind, vertex);
                kinds.push(kind, &self.rays[vertex.index()]);
            }
        }
        let groups = CreaseGroups::from_sets(self.pattern, self.sets, self.tolerance);
        (groups, kinds.all.len(), self.worst.sqrt())
    }

    /// Returns `true` if symmetries of exact coordinates found before take the kind's vertex to this vertex: then no
    /// further isometry between them can give a new relation.
    fn is_told(&mut self, kind: &Kind, vertex: VertexId) -> bool {
        let [from, to] = [kind.vertex, vertex].map(VertexId::index);
        let exact = self.tolerance <= EXACT_TOLERANCE;
        exact && kind.settled && self.orbits.related(from, to, false)
    }

    /// Tries every isometry that takes the star of the kind to the star of a vertex, as long as any may give a new
    /// relation. Returns `true` if the stars are congruent at all.
    fn try_all(&mut self, kind: &mut Kind, to: VertexId) -> bool {
        let from = kind.vertex;
        let [mut congruent, mut all_known] = [false, true];
        let degree = self.rays[to.index()].len();
        let turned_over = [(false, false), (false, true), (true, false), (true, true)];
        for (mirrored, flips) in turned_over {
            for first in 0..degree {
                let image = StarImage { first, mirrored };
                let [rays, images] = [from, to].map(|v| &self.rays[v.index()]);
                let mut pairs = rays
                    .iter()
                    .enumerate()
                    .map(|(k, ray)| (ray, image.of(k, images)));
                if !pairs.clone().all(|(ray, image)| ray.agrees(image, flips)) {
                    continue;
                }
                let sets = &mut self.sets;
                let mut known = pairs.all(|(ray, image)| {
                    sets.related(ray.crease.index(), image.crease.index(), flips)
                });
                if known && congruent {
                    continue;
                }
                let mut isometry = Isometry::between(
                    [from, to].map(|v| self.pattern.vertices()[v.index()]),
                    [rays[0].direction, image.of(0, images).direction],
                    mirrored,
                    flips,
                );
                if !self.maps_star(&isometry, from, to, self.star_tolerance()) {
                    continue;
                }
                congruent = true;
                if known && kind.settled {
                    return true;
                }
                if !known && self.may_compare() {
                    if self.tolerance > EXACT_TOLERANCE {
                        isometry = self.fitted(isometry, from);
                    }
                    known = self.is_symmetry(&isometry) && self.join(flips);
                }
                all_known &= known;
            }
        }
        kind.settled |= congruent && all_known;
        congruent
    }

    /// Returns `true` as long as there is budget and time for comparing vertices.
    fn may_compare(&self) -> bool {
        self.budget > 0 && !self.watch.is_over()
    }

    /// Returns the largest difference (radians) between a star and the image of another star under an isometry that a
    /// single direction determines.
    fn star_tolerance(&self) -> f64 {
        if self.tolerance > EXACT_TOLERANCE {
            ROUGH_STAR_FACTOR * self.tolerance
        } else {
            self.tolerance
        }
    }

    /// Fits the isometry to the vertices near `from`, then within twice the distance and so on, until it is fitted to
    /// the whole sheet: the error that a wrong direction causes grows with the distance.
    fn fitted(&mut self, mut isometry: Isometry, from: VertexId) -> Isometry {
        let vertices = self.pattern.vertices();
        let reach = REACH_TOLERANCES * self.tolerance * self.pattern.median_edge();
        let center = vertices[from.index()];
        let mut radius = 2.0 * self.pattern.median_edge();
        let mut pairs = Vec::new();
        loop {
            self.budget = self.budget.saturating_sub(vertices.len());
            pairs.clear();
            let mut beyond = false;
            for &flat in vertices {
                if (flat - center).norm_squared() > radius * radius {
                    beyond = true;
                } else if let Some(to) = self.places.vertex_within(isometry.apply(flat), reach) {
                    pairs.push([flat, vertices[to.index()]]);
                }
            }
            isometry = isometry.fitted(&pairs);
            if !beyond || self.budget == 0 {
                return isometry;
            }
            radius *= 2.0;
        }
    }

    /// Returns `true` if the isometry takes the star of `from` to that of `to`, and records the pairs of creases. If a
    /// vertex is on the border, only the part inside the sheet is compared.
    fn maps_star(
        &mut self,
        isometry: &Isometry,
        from: VertexId,
        to: VertexId,
        tolerance: f64,
    ) -> bool {
        let (rays, images) = (&self.rays[from.index()], &self.rays[to.index()]);
        let whole = [from, to].map(|v| self.pattern.is_real(v));
        if whole == [true, true] && rays.len() != images.len() {
            return false;
        }
        let mut matched = 0;
        // Neighbours in one star have neighbouring images, so the search continues at the next image.
        let mut next = 0;
        for ray in rays {
            let direction = isometry.turn(ray.direction);
            let off = |image: &Ray| (image.direction - direction).norm_squared();
            let found = (0..images.len()).find_map(|_| {
                let image = &images[next];
                next = match (isometry.mirrors, next) {
                    (false, last) if last + 1 == images.len() => 0,
                    (false, at) => at + 1,
                    (true, 0) => images.len() - 1,
                    (true, at) => at - 1,
                };
                (off(image) <= tolerance * tolerance).then_some(image)
            });
            match found {
                Some(image) if ray.agrees(image, isometry.flips) => {
                    self.worst = self.worst.max(off(image));
                    let noted = &mut self.noted[ray.crease.index()];
                    if *noted != self.isometries {
                        *noted = self.isometries;
                        self.found.push((ray.crease, image.crease));
                    }
                    matched += 1;
                }
                Some(_) => return false,
                None if whole[1] => return false,
                None => {}
            }
        }
        !whole[0] || matched == images.len()
    }

    /// Returns `true` if the isometry maps the overlap of the sheet with its image to itself. Records the pairs of
    /// creases, which may contradict each other or known relations.
    fn is_symmetry(&mut self, isometry: &Isometry) -> bool {
        self.found.clear();
        self.mapped.clear();
        self.isometries += 1;
        for index in 0..self.real.len() {
            self.budget = self.budget.saturating_sub(1);
            let vertex = self.real[index];
            let image = isometry.apply(self.pattern.vertices()[vertex.index()]);
            let fits = match self.places.vertex_at(image) {
                Some(to) => {
                    self.image_of[to.index()] = self.isometries;
                    // A star on the border is incomplete and does not determine an orbit.
                    if self.pattern.is_real(to) {
                        self.mapped.push((vertex, to));
                    }
                    self.maps_star(isometry, vertex, to, self.tolerance)
                }
                None => !self.places.is_inside(image),
            };
            if !fits {
                return false;
            }
        }
        let inverse = isometry.inverse();
        for index in 0..self.real.len() {
            let vertex = self.real[index];
            if self.image_of[vertex.index()] == self.isometries {
                continue;
            }
            let origin = inverse.apply(self.pattern.vertices()[vertex.index()]);
            let fits = match self.places.vertex_at(origin) {
                // The pair was compared when `from` was mapped, unless no hinge ends at `from`.
                Some(from) if self.pattern.is_real(from) => !self.rays[from.index()].is_empty(),
                Some(from) => self.maps_star(isometry, from, vertex, self.tolerance),
                None => !self.places.is_inside(origin),
            };
            if !fits {
                return false;
            }
        }
        true
    }

    /// Joins the pairs of one isometry, all or none: they may contradict each other where letters leave the sign open,
    /// or bring together goal angles that are too far apart. Returns `true` if the pairs were joined.
    fn join(&mut self, flips: bool) -> bool {
        let mut joined = self.sets.clone();
        let consistent = |&(a, b): &(CreaseId, CreaseId)| joined.join(a.index(), b.index(), flips);
        let joins = self.found.iter().all(consistent);
        if joins {
            self.sets = joined;
            for &(from, to) in &self.mapped {
                self.orbits.join(from.index(), to.index(), false);
            }
        }
        joins
    }
}
