//! Crease groups: a partition of the creases into groups that turn alike.

use foldpath_core::{GroupId, Membership};

use super::group_search::{GroupSearch, set_of_each_crease};
use super::signed_union_find::SignedUnionFind;
use crate::pattern::{CreaseId, CreasePattern, Letter};
use crate::progress::Watch;

/// Tolerance for equal points, in median edges, and for equal directions, in radians: a thousand times the noise of
/// coordinates with nine digits, and a thousandth of what is visible.
pub(super) const EXACT_TOLERANCE: f64 = 1e-6;
/// Tolerances for sheets that seem irregular because their coordinates are rough. The largest in use is a thousandth,
/// for coordinates of three digits; the last tolerance only confirms the one before it.
const ROUGH_TOLERANCES: [f64; 4] = [1e-5, 1e-4, 1e-3, 1e-2];
/// A sheet with at most this number of groups, as tessellations have, is accepted without trying rough tolerances if its
/// stars agree to within the fraction [`FAR_BETTER_RATIO`] of the tolerance.
const MAX_FEW_GROUPS: usize = 4;
const FAR_BETTER_RATIO: f64 = 0.1;

/// A partition of the creases into groups that turn alike, with the sign of each crease in its group.
#[derive(Clone, Debug, PartialEq)]
pub struct CreaseGroups {
    memberships: Vec<Membership>,
    groups: usize,
    tolerance: f64,
}

impl CreaseGroups {
    /// Finds the groups that follow from the partial symmetries of the pattern.
    ///
    /// A sheet whose rounded or measured coordinates make it symmetric only to a rougher tolerance gets the groups
    /// found with that tolerance, if a tolerance ten times rougher finds neither fewer groups nor fewer kinds of stars.
    /// A sheet whose shape changes gradually fails this test: kinds of stars are compared with each other and not along
    /// a chain of neighbours, so each rougher tolerance finds fewer of them.
    ///
    /// Cost: O(vertices) for each symmetry tried, of which a tessellation needs a handful; bounded by a budget.
    #[must_use]
    pub fn find(pattern: &CreasePattern) -> Self {
        Self::find_until(pattern, Watch::default())
    }

    /// Finds the groups as [`find`](Self::find) does; once `watch` is over, returns those found until then.
    #[must_use]
    pub fn find_until(pattern: &CreasePattern, watch: Watch<'_>) -> Self {
        let (exact, kinds, worst) = GroupSearch::new(pattern, EXACT_TOLERANCE, watch).run();
        let few = exact.len() <= MAX_FEW_GROUPS && !exact.is_trivial();
        if few && worst <= FAR_BETTER_RATIO * EXACT_TOLERANCE {
            return exact;
        }
        let mut best = exact.clone();
        let mut finer = (exact, kinds);
        for tolerance in ROUGH_TOLERANCES {
            let rougher = GroupSearch::new(pattern, tolerance, watch).run();
            if watch.is_over() {
                break;
            }
            let (groups, kinds) = &finer;
            let stands = groups.len() == rougher.0.len() && *kinds == rougher.1;
            if stands && groups.len() < best.len() {
                best = groups.clone();
            }
            finer = (rougher.0, rougher.1);
        }
        best
    }

    /// Finds the groups that follow from the symmetries of exact coordinates.
    #[must_use]
    pub fn find_exact(pattern: &CreasePattern) -> Self {
        GroupSearch::new(pattern, EXACT_TOLERANCE, Watch::default())
            .run()
            .0
    }

    /// Returns the tolerance to which the symmetries hold, in median edges and radians.
    #[must_use]
    pub fn tolerance(&self) -> f64 {
        self.tolerance
    }

    /// Returns `true` if the symmetries hold only to a tolerance rougher than the rounding of exact coordinates.
    #[must_use]
    pub fn is_rough(&self) -> bool {
        self.tolerance > EXACT_TOLERANCE
    }

    /// Makes a group of each crease: no symmetry is assumed.
    #[must_use]
    pub fn trivial(pattern: &CreasePattern) -> Self {
        Self::from_sets(pattern, set_of_each_crease(pattern), EXACT_TOLERANCE)
    }

    /// Makes groups from known memberships; `tolerance` (radians) is the largest difference of equal sectors.
    #[must_use]
    pub(crate) fn of_memberships(memberships: Vec<Membership>, tolerance: f64) -> Self {
        let last = memberships.iter().map(|m| m.group.index()).max();
        Self {
            groups: last.map_or(0, |last| last + 1),
            memberships,
            tolerance,
        }
    }

    /// Returns `true` if each crease is a group of its own.
    #[must_use]
    pub fn is_trivial(&self) -> bool {
        self.groups == self.memberships.len()
    }

    /// Returns these groups, each parted into the creases that turn with it and those that turn against it: the groups that
    /// are left without symmetries that exchange mountain and valley.
    #[must_use]
    pub(crate) fn parted_by_sign(&self) -> Self {
        let mut number_of = vec![[None; 2]; self.groups];
        let mut groups = 0;
        let mut part = |membership: &Membership| {
            let group = &mut number_of[membership.group.index()][usize::from(membership.negative)];
            let group = *group.get_or_insert_with(|| {
                groups += 1;
                GroupId(groups - 1)
            });
            Membership {
                group,
                negative: membership.negative,
            }
        };
        let memberships = self.memberships.iter().map(&mut part).collect();
        Self::of_memberships(memberships, self.tolerance)
    }

    pub(super) fn from_sets(
        pattern: &CreasePattern,
        mut sets: SignedUnionFind,
        tolerance: f64,
    ) -> Self {
        let mut group_of_root = vec![None; pattern.creases().len()];
        let mut groups = 0;
        let mut memberships = Vec::with_capacity(pattern.creases().len());
        for crease in 0..pattern.creases().len() {
            let (root, against) = sets.find(crease);
            // The first crease of a group sets the group's sign: a mountain turns against its group, so that folding by
            // its letter makes the group angle positive.
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

    /// Returns the number of groups, which are the remaining unknowns.
    #[must_use]
    pub fn len(&self) -> usize {
        self.groups
    }

    /// Returns `true` if there are no creases.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.groups == 0
    }

    /// Returns the group and sign of each crease.
    #[must_use]
    pub fn memberships(&self) -> &[Membership] {
        &self.memberships
    }

    /// Returns the group and sign of a crease.
    #[must_use]
    pub fn of(&self, crease: CreaseId) -> Membership {
        self.memberships[crease.index()]
    }

    /// Returns the fold angles of all creases (radians) for group angles.
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

    /// Returns the group angles nearest to given fold angles of the creases: the mean over the creases of each group
    /// that have an angle, and `None` for a group without any.
    #[must_use]
    pub fn reduce(&self, creases: &[Option<f64>]) -> Vec<Option<f64>> {
        // Sums deviations from the first angle, so that the mean of equal angles is exact.
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

    /// Returns the group angles nearest to the fold angles of all creases, as [`reduce`](Self::reduce) does.
    pub(crate) fn reduce_all(&self, creases: &[f64]) -> Vec<f64> {
        let creases: Vec<_> = creases.iter().copied().map(Some).collect();
        self.reduce(&creases).into_iter().flatten().collect()
    }
}
