//! Crease groups from the partial symmetries of the sheet.
//!
//! Answers an open question of [XiLien2015]: how to find crease groups without a path. Two vertices
//! with congruent stars name a planar isometry that takes one star to the other, perhaps with
//! mountain and valley exchanged. It is a partial symmetry if it maps the whole overlap of the sheet
//! with its own image on itself, letters and goal angles included; then each crease and its image
//! may turn alike. Union-find with parity turns these relations into groups and signs.
//!
//! That the symmetric motion exists is not implied: the caller checks the closure of the whole sheet
//! at the reduced configurations.

use foldpath_core::{GroupId, Membership};
use nalgebra::Vector2;

use super::isometry::{Isometry, StarImage};
use super::parity::ParitySets;
use super::places::Places;
use crate::pattern::{CreaseId, CreasePattern, Letter, VertexId};
use crate::ragged::Ragged;

/// Points this close, in median edges, and directions this close, in radians, are the same: a
/// thousand times the noise of coordinates written with nine digits, a thousandth of what is visible.
const SAME_PLACE: f64 = 1e-6;
/// Tolerances for sheets that seem irregular because their coordinates are rough. Up to a thousandth:
/// coordinates of three digits. The last only confirms the one before.
const ROUGH: [f64; 4] = [1e-5, 1e-4, 1e-3, 1e-2];
/// A sheet of no more groups than this, as tessellations have, is taken as it is if its stars agree
/// far better than asked: by this part of the tolerance.
const FEW: usize = 4;
const FAR_BETTER: f64 = 0.1;
/// Stars are compared this much more roughly than whole sheets where coordinates are rough: one star
/// alone does not say how its image lies.
const ROUGH_STAR: f64 = 2.0;
/// While an isometry is fitted, vertices this many tolerances apart are taken for one.
const REACH: f64 = 10.0;
/// Goal angles of one group are no farther apart than this, in radians: half a degree covers goals that
/// were measured or rounded.
const SAME_GOAL: f64 = 1e-2;

/// Vertices compared at most: this many, and this many times all of them. A tessellation needs a handful
/// of passes; one with a defect could ask for as many as it has vertices, and does with the groups found
/// until then.
const BUDGET: usize = 1_000_000;
const PASSES: usize = 64;

/// Which creases turn alike.
#[derive(Clone, Debug, PartialEq)]
pub struct CreaseGroups {
    memberships: Vec<Membership>,
    groups: usize,
    tolerance: f64,
}

impl CreaseGroups {
    /// The groups that the partial symmetries of the pattern give.
    ///
    /// A sheet that is symmetric only to a rougher tolerance, as rounded or measured coordinates make
    /// it, has the groups found with that tolerance, if one ten times rougher finds neither fewer
    /// groups nor fewer kinds of stars. A sheet whose shape changes little by little does: its kinds
    /// are compared with each other, not along a chain of neighbours, and the rougher, the fewer.
    ///
    /// Cost: O(vertices) for each symmetry tried, of which a tessellation needs a handful; bounded.
    #[must_use]
    pub fn find(pattern: &CreasePattern) -> Self {
        let (exact, kinds, worst) = Search::new(pattern, SAME_PLACE).run();
        let few = exact.len() <= FEW && !exact.is_trivial();
        if few && worst <= FAR_BETTER * SAME_PLACE {
            return exact;
        }
        let rough = ROUGH.map(|tolerance| Search::new(pattern, tolerance).run());
        let mut best = exact.clone();
        let mut finer = (exact, kinds);
        for rougher in rough {
            let (groups, kinds) = &finer;
            let stands = groups.len() == rougher.0.len() && *kinds == rougher.1;
            if stands && groups.len() < best.len() {
                best = groups.clone();
            }
            finer = (rougher.0, rougher.1);
        }
        best
    }

    /// The groups that symmetries of exact coordinates give.
    #[must_use]
    pub fn find_exact(pattern: &CreasePattern) -> Self {
        Search::new(pattern, SAME_PLACE).run().0
    }

    /// Tolerance to which the symmetries hold, in median edges and radians.
    #[must_use]
    pub fn tolerance(&self) -> f64 {
        self.tolerance
    }

    /// Whether the symmetries hold only roughly: more than the rounding of exact coordinates.
    #[must_use]
    pub fn is_rough(&self) -> bool {
        self.tolerance > SAME_PLACE
    }

    /// Each crease on its own: no symmetry assumed.
    #[must_use]
    pub fn trivial(pattern: &CreasePattern) -> Self {
        Self::from_sets(pattern, single(pattern), SAME_PLACE)
    }

    /// Groups known otherwise; `tolerance` (radians) tells sectors of stars apart.
    #[must_use]
    pub(crate) fn of_memberships(memberships: Vec<Membership>, tolerance: f64) -> Self {
        let last = memberships.iter().map(|m| m.group.index()).max();
        Self {
            groups: last.map_or(0, |last| last + 1),
            memberships,
            tolerance,
        }
    }

    /// Whether each crease is on its own.
    #[must_use]
    pub fn is_trivial(&self) -> bool {
        self.groups == self.memberships.len()
    }

    fn from_sets(pattern: &CreasePattern, mut sets: ParitySets, tolerance: f64) -> Self {
        let mut group_of_root = vec![None; pattern.creases().len()];
        let mut groups = 0;
        let mut memberships = Vec::with_capacity(pattern.creases().len());
        for crease in 0..pattern.creases().len() {
            let (root, against) = sets.find(crease);
            // The sign of a group is such that its first valley or mountain makes it positive.
            let first = |r: usize| pattern.edge(pattern.creases()[r]).letter == Letter::Mountain;
            let (group, negative) = *group_of_root[root].get_or_insert_with(|| {
                groups += 1;
                (groups - 1, first(root))
            });
            memberships.push(Membership {
                group: GroupId(group),
                negative: against ^ negative,
            });
        }
        Self {
            memberships,
            groups: groups as usize,
            tolerance,
        }
    }

    /// Number of groups: of unknowns that remain.
    #[must_use]
    pub fn len(&self) -> usize {
        self.groups
    }

    /// Whether there is no crease at all.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.groups == 0
    }

    /// For each crease its group and sign.
    #[must_use]
    pub fn memberships(&self) -> &[Membership] {
        &self.memberships
    }

    /// Group and sign of a crease.
    #[must_use]
    pub fn of(&self, crease: CreaseId) -> Membership {
        self.memberships[crease.index()]
    }

    /// Fold angles of all creases for given group angles (radians).
    ///
    /// # Panics
    /// If `angles` has fewer entries than there are groups.
    #[must_use]
    pub fn expand(&self, angles: &[f64]) -> Vec<f64> {
        let mut creases = vec![0.0; self.memberships.len()];
        let complete = foldpath_core::expand(&self.memberships, angles, &mut creases);
        assert!(complete, "an angle for each group");
        creases
    }

    /// Group angles nearest to given fold angles of the creases: means over those of each group that
    /// have one, `None` where none has.
    #[must_use]
    pub fn reduce(&self, creases: &[Option<f64>]) -> Vec<Option<f64>> {
        // Deviations from the first are summed: equal angles keep every bit.
        let mut sums = vec![(None, 0.0, 0.0); self.groups];
        for (membership, &angle) in self.memberships.iter().zip(creases) {
            let (first, sum, count) = &mut sums[membership.group.index()];
            let Some(angle) = angle.map(|angle| membership.apply(angle)) else {
                continue;
            };
            *sum += angle - *first.get_or_insert(angle);
            *count += 1.0;
        }
        let mean = |(first, sum, count): (Option<f64>, f64, f64)| Some(first? + sum / count);
        sums.into_iter().map(mean).collect()
    }
}

/// Each crease on its own.
fn single(pattern: &CreasePattern) -> ParitySets {
    let goals = pattern.creases().iter().map(|&id| pattern.edge(id).goal);
    ParitySets::new(goals, SAME_GOAL)
}

/// One hinge as seen from a vertex.
#[derive(Clone, Copy)]
struct Ray {
    direction: Vector2<f64>,
    crease: CreaseId,
    letter: Letter,
    /// Radians; NaN for none.
    goal: f64,
}

impl Ray {
    /// Whether an isometry may take this crease to `image`, places aside.
    fn agrees(&self, image: &Self, flips: bool) -> bool {
        let letter = if flips {
            self.letter.flipped()
        } else {
            self.letter
        };
        let goal = if flips { -self.goal } else { self.goal };
        let no_goal = goal.is_nan() && image.goal.is_nan();
        letter == image.letter && (no_goal || (goal - image.goal).abs() <= SAME_GOAL)
    }
}

/// Vertices with congruent stars.
struct Kind {
    /// The first of them.
    vertex: VertexId,
    /// Whether all congruences of its star with itself are known to turn hinges alike. Then one that takes
    /// it to another star tells all that the others do.
    settled: bool,
}

struct Search<'a> {
    pattern: &'a CreasePattern,
    tolerance: f64,
    places: Places<'a>,
    rays: Ragged<Ray>,
    real: Vec<VertexId>,
    sets: ParitySets,
    /// Relations that the isometry at hand implies, and the inner vertices that it takes to another.
    found: Vec<(CreaseId, CreaseId)>,
    mapped: Vec<(VertexId, VertexId)>,
    /// Vertices that symmetries take to each other.
    orbits: ParitySets,
    /// For each vertex the last isometry, by its number, that took another to it.
    image_of: Vec<u32>,
    /// For each crease the last isometry of which its image was noted, as seen from one end or the other.
    noted: Vec<u32>,
    isometries: u32,
    /// Square of the largest difference between directions that were taken for one.
    worst: f64,
    /// Vertices that may still be compared.
    budget: usize,
}

impl<'a> Search<'a> {
    fn new(pattern: &'a CreasePattern, tolerance: f64) -> Self {
        let stars = pattern.stars();
        let mut rays = Ragged::with_capacity(stars.len(), stars.items().len());
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
            sets: single(pattern),
            found: Vec::with_capacity(pattern.creases().len()),
            mapped: Vec::with_capacity(pattern.vertices().len()),
            orbits: ParitySets::new(pattern.vertices().iter().map(|_| None), 0.0),
            image_of: vec![0; pattern.vertices().len()],
            noted: vec![0; pattern.creases().len()],
            isometries: 0,
            worst: 0.0,
            budget: BUDGET + PASSES * pattern.vertices().len(),
        }
    }

    /// The groups, the number of kinds of stars, and the largest difference between directions that
    /// were taken for one.
    fn run(mut self) -> (CreaseGroups, usize, f64) {
        let mut kinds: Vec<Kind> = Vec::new();
        for index in 0..self.real.len() {
            let vertex = self.real[index];
            if kinds.iter().any(|kind| self.is_told(kind, vertex)) {
                continue;
            }
            let mut known = false;
            for kind in &mut kinds {
                if self.rays[kind.vertex.index()].len() == self.rays[vertex.index()].len() {
                    known |= self.try_all(kind, vertex);
                }
            }
            if !known {
                let settled = false;
                let mut kind = Kind { vertex, settled };
                self.try_all(&mut kind, vertex);
                kinds.push(kind);
            }
        }
        let groups = CreaseGroups::from_sets(self.pattern, self.sets, self.tolerance);
        (groups, kinds.len(), self.worst.sqrt())
    }

    /// Whether symmetries of exact coordinates that were found before take the kind to this vertex, which tells all
    /// there is to tell.
    fn is_told(&mut self, kind: &Kind, vertex: VertexId) -> bool {
        let [from, to] = [kind.vertex, vertex].map(VertexId::index);
        let exact = self.tolerance <= SAME_PLACE;
        exact && kind.settled && self.orbits.related(from, to, false)
    }

    /// Tries every isometry that takes the star of the kind to that of a vertex, as long as any may tell
    /// something new. Returns whether the stars are congruent at all.
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
                if !known && self.tolerance > SAME_PLACE {
                    isometry = self.fitted(isometry, from);
                }
                if !known && self.budget > 0 && self.is_symmetry(&isometry) {
                    known = self.join(flips);
                }
                all_known &= known;
            }
        }
        kind.settled |= congruent && all_known;
        congruent
    }

    /// Radians by which a star may differ from the image of another that a single direction gives.
    fn star_tolerance(&self) -> f64 {
        if self.tolerance > SAME_PLACE {
            ROUGH_STAR * self.tolerance
        } else {
            self.tolerance
        }
    }

    /// The isometry fitted to the vertices round `from`, then to those round these, until all of the
    /// sheet counts: an error of direction grows with the distance.
    fn fitted(&mut self, mut isometry: Isometry, from: VertexId) -> Isometry {
        let vertices = self.pattern.vertices();
        let reach = REACH * self.tolerance * self.pattern.median_edge();
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

    /// Whether the isometry takes the star of `from` to that of `to`; notes the pairs of creases.
    /// Round a vertex on the border only what is inside the sheet is compared.
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
        // Neighbours have neighbours as images: after each the next one is looked at first.
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

    /// Whether the isometry maps the overlap of the sheet with its image on itself; notes the pairs
    /// of creases, which may contradict each other or what is known.
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
                    // A star that the border cuts is not all of it.
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
                // Compared already where it was mapped, unless no hinge ends there.
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

    /// Joins the pairs of one isometry, all or none: they may contradict each other where letters do
    /// not say, or take goal angles too far apart. Returns whether they are.
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
