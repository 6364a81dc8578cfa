//! The problem that is solved: crease groups as unknowns, some stars as conditions, and the goal in
//! these terms.

use core::cell::OnceCell;
use core::f64::consts::PI;
use std::rc::Rc;

use super::follow::{approach, same_signs};
use super::solver::{ClosureSolver, Work};
use super::sparse::Structure;
use super::{Goal, PlanOptions, Vertices};
use crate::folding::{Amplification, SpanningTree};
use crate::pattern::{CreasePattern, EdgeId};
use crate::progress::Watch;
use crate::symmetry::{CreaseGroups, Lattice, ReducedStars};

/// Faces up to which all pairs are looked at sooner than their lattice is found and folded.
const FEW_FACES: usize = 20;

/// The unknowns and conditions of a plan.
pub(super) struct Reduction<'a> {
    pub(super) groups: CreaseGroups,
    /// Stars of all real vertices, loops round all holes.
    pub(super) all: ReducedStars,
    /// One star for each distinct condition.
    pub(super) essential: ReducedStars,
    /// Those of all stars that differ in some bit.
    distinct: ReducedStars,
    /// The same of the stars as the sheet has them, if these are not.
    rounded: Option<ReducedStars>,
    /// Radians by which creases may have been turned for that.
    pub(super) within: f64,
    vertices: Vertices,
    /// Lower and upper bound of each group angle, radians; empty for half a turn each way.
    limits: Vec<(f64, f64)>,
    pub(super) watch: Watch<'a>,
    /// The tree along which the whole sheet is folded.
    pub(super) tree: SpanningTree,
    /// How much larger than the closure residuals errors of the whole sheet can be.
    pub(super) amplification: Option<f64>,
    /// How much larger they are taken to be, at most.
    expected: f64,
    /// The structure of sparse equations of the stars to solve, once a solver has found it.
    structure: OnceCell<Option<Rc<Structure>>>,
    /// The lattice of the groups, if it was asked for.
    lattice: OnceCell<Option<Lattice>>,
}

/// What stands in the way.
pub(super) struct Blame {
    /// A vertex or a hole, in words.
    pub(super) place: String,
    pub(super) edges: Vec<EdgeId>,
    pub(super) residual: f64,
}

/// A closed configuration near the goal.
pub(super) struct ClosedGoal {
    /// Group angles, radians.
    pub(super) angles: Vec<f64>,
    /// Largest difference from the goal asked for over all creases, radians.
    pub(super) error: f64,
    /// Closure residual that counts as closed although it can be made no smaller; 0 for none.
    pub(super) accepted: f64,
}

impl<'a> Reduction<'a> {
    pub(super) fn new(
        pattern: &CreasePattern,
        groups: CreaseGroups,
        options: &PlanOptions,
        watch: Watch<'a>,
    ) -> Self {
        let all = ReducedStars::all(pattern, &groups);
        Self::of_stars(pattern, groups, all, options, watch)
    }

    /// The same of other stars.
    fn of_stars(
        pattern: &CreasePattern,
        groups: CreaseGroups,
        all: ReducedStars,
        options: &PlanOptions,
        watch: Watch<'a>,
    ) -> Self {
        let tree = SpanningTree::from_central_face(pattern);
        Self {
            essential: all.essential(),
            distinct: all.distinct(),
            rounded: None,
            within: 0.0,
            all,
            vertices: options.vertices,
            limits: group_limits(&groups, options),
            groups,
            watch,
            amplification: Amplification::new(pattern, &tree).map(|factors| factors.worst()),
            tree,
            expected: f64::INFINITY,
            structure: OnceCell::new(),
            lattice: OnceCell::new(),
        }
    }

    /// The same where errors of vertices are not taken to add up, as those of rounded coordinates do not: what they add up
    /// to is to be measured.
    pub(super) fn measured(self) -> Self {
        Self {
            expected: EXPECTED,
            ..self
        }
    }

    /// The same of stars that fold flat where they nearly do, and by how much (radians) their creases are turned for it;
    /// `None` if none is by more than rounding, within what the bound allows. If `coarse`, as much is taken for rounding as
    /// the goal closes with; `None` if that is no more than it tells.
    pub(super) fn unrounded(
        &self,
        pattern: &CreasePattern,
        goal: &Goal,
        options: &PlanOptions,
        coarse: bool,
    ) -> Option<(Self, f64)> {
        let most = self.accepted(options);
        let asked = self.groups.reduce(&goal.fold_angles);
        let within = |coarse| rounding(&self.all, &asked, most, coarse).unwrap_or(ROUNDED * most);
        let told = within(false);
        let within = if coarse { within(true) } else { told };
        if coarse && within <= told {
            return None;
        }
        let (all, turned) = self.all.unrounded(within);
        let groups = self.groups.clone();
        let unrounded = || Self {
            rounded: Some(self.distinct.clone()),
            within,
            expected: self.expected,
            ..Self::of_stars(pattern, groups, all, options, self.watch)
        };
        (turned > ROUNDING).then(|| (unrounded(), turned))
    }

    /// The lattice of the groups along which to look for crossings, if the sheet has one and more than a few faces.
    pub(super) fn lattice(&self, pattern: &CreasePattern) -> Option<&Lattice> {
        let lattice = || Lattice::find(pattern, self.groups.memberships());
        // Hinges that are each on their own turn alike nowhere.
        (!self.groups.is_trivial() && pattern.faces().len() > FEW_FACES)
            .then(|| self.lattice.get_or_init(lattice).as_ref())
            .flatten()
    }

    /// A solver of the stars to solve; a local minimum of the residual counts as closed if it is
    /// `accepted`.
    pub(super) fn solver(&self, options: &PlanOptions, accepted: f64) -> ClosureSolver<'_> {
        let mut solver =
            ClosureSolver::new(self.stars(), options.solver, accepted, &self.structure);
        solver.set_limits(self.limits.clone());
        solver.watched(self.watch)
    }

    /// Limits for configurations that turn each group the way of `signs` or leave it flat.
    pub(super) fn orthant(&self, signs: &[f64]) -> Vec<(f64, f64)> {
        let limits = signs.iter().enumerate().map(|(group, &sign)| {
            let (lower, upper) = self.limits.get(group).copied().unwrap_or((-PI, PI));
            match sign {
                s if s > 0.0 => (0.0, upper),
                s if s < 0.0 => (lower, 0.0),
                _ => (lower, upper),
            }
        });
        limits.collect()
    }

    /// Whether the limits allow a goal.
    pub(super) fn allows(&self, goal: &Goal) -> bool {
        let asked = self.groups.reduce(&goal.fold_angles);
        let mut pairs = asked.iter().zip(&self.limits);
        pairs.all(|(asked, (lower, upper))| {
            asked.is_none_or(|asked| asked >= lower - SAME && asked <= upper + SAME)
        })
    }

    /// The goal in group angles, and for each group the way it turns: of its goal angle, or else of its
    /// letters.
    pub(super) fn asked(&self, goal: &Goal) -> (Vec<Option<f64>>, Vec<f64>) {
        let asked = self.groups.reduce(&goal.fold_angles);
        let letters: Vec<_> = goal.signs.iter().map(|&sign| Some(sign)).collect();
        let letters = self.groups.reduce(&letters);
        let signs = asked.iter().zip(letters).map(|(asked, letter)| {
            let way = asked.filter(|asked| asked.abs() > 0.0).or(letter);
            way.filter(|way| way.abs() > 0.0).map_or(0.0, f64::signum)
        });
        let signs = signs.collect();
        (asked, signs)
    }

    /// What closes worst at the group angles `x`: its hinges and its residual.
    pub(super) fn worst(&self, pattern: &CreasePattern, x: &[f64]) -> Option<Blame> {
        let residuals = self.all.residuals(x).into_iter().enumerate();
        let (worst, residual) = residuals.max_by(|a, b| a.1.total_cmp(&b.1))?;
        let vertices = self.all.vertices();
        let (place, edges): (_, Vec<EdgeId>) = match vertices.get(worst) {
            Some(&vertex) => (
                format!("vertex {}", vertex.index()),
                pattern.stars()[vertex.index()].to_vec(),
            ),
            None => {
                let way = &pattern.holes()[self.all.holes()[worst - vertices.len()]];
                let at = way.first().map_or(0, |passage| passage.at.index());
                (
                    format!("the hole at vertex {at}"),
                    way.iter().map(|passage| passage.edge).collect(),
                )
            }
        };
        let hinge = |edge: &EdgeId| pattern.edge(*edge).crease.is_some();
        Some(Blame {
            place,
            edges: edges.into_iter().filter(hinge).collect(),
            residual,
        })
    }

    /// The essential tolerance: closure residual that no vertex may exceed.
    pub(super) fn accepted(&self, options: &PlanOptions) -> f64 {
        self.tolerance(options.bound)
    }

    /// Closure residual that all vertices may reach while the whole sheet keeps a bound.
    pub(super) fn tolerance(&self, bound: f64) -> f64 {
        #[allow(clippy::cast_precision_loss, reason = "a scale")]
        let vertices = self.all.vertices().len().max(1) as f64;
        // Where nothing is known for certain, each vertex may add to the next.
        let worst = self.amplification.unwrap_or(vertices);
        (bound / worst.min(self.expected)).max(ROUNDING)
    }

    /// The stars to solve.
    fn stars(&self) -> &ReducedStars {
        match self.vertices {
            Vertices::Essential => &self.essential,
            // Residuals that are the same, bit for bit, say nothing more.
            Vertices::All => &self.distinct,
        }
    }

    /// Largest closure residual of all stars.
    pub(super) fn closure(&self, angles: &[f64]) -> f64 {
        self.distinct.largest_residual(angles)
    }

    /// The same of the stars as the sheet has them.
    pub(super) fn closure_of_sheet(&self, angles: &[f64]) -> f64 {
        let stars = self.rounded.as_ref().unwrap_or(&self.distinct);
        stars.largest_residual(angles)
    }

    /// Largest difference, over all creases, of a configuration from a goal, radians.
    pub(super) fn distance(&self, angles: &[f64], goal: &Goal) -> f64 {
        let creases = self.groups.expand(angles);
        let asked = creases.iter().zip(&goal.fold_angles);
        let errors = asked.filter_map(|(a, b)| Some((a - (*b)?).abs()));
        errors.fold(0.0, f64::max)
    }

    /// The goal, moved to the closed configuration near it. `None` if there is none near, or the
    /// nearest turns a crease against the goal. Where none closes exactly, as coordinates are rounded,
    /// one that closes as well as can be.
    pub(super) fn close_goal(
        &self,
        goal: &Goal,
        options: &PlanOptions,
        work: &mut Work,
    ) -> Option<ClosedGoal> {
        let exact = self.close_goal_to(0.0, goal, options, work);
        if exact.as_ref().is_some_and(|closed| closed.error <= NEARBY) {
            return exact;
        }
        let rough = self.close_goal_to(self.accepted(options), goal, options, work);
        match (exact, rough) {
            (Some(exact), Some(rough)) if exact.error <= rough.error => Some(exact),
            (exact, rough) => rough.or(exact),
        }
    }

    /// The same where a local minimum of the residual counts as closed if it is `accepted`.
    pub(super) fn close_goal_to(
        &self,
        accepted: f64,
        goal: &Goal,
        options: &PlanOptions,
        work: &mut Work,
    ) -> Option<ClosedGoal> {
        let (asked, signs) = self.asked(goal);
        let mut solver = self.solver(options, accepted);
        solver.set_limits(self.orthant(&signs));
        let found = nearest_closed(&mut solver, &asked, &signs);
        *work += solver.work;
        let angles = found.filter(|angles| self.closure(angles) <= self.accepted(options))?;
        Some(ClosedGoal {
            error: self.distance(&angles, goal),
            angles,
            accepted,
        })
    }
}

/// Limits of the groups: what all hinges of each may do.
fn group_limits(groups: &CreaseGroups, options: &PlanOptions) -> Vec<(f64, f64)> {
    if options.limits.is_empty() {
        return Vec::new();
    }
    let mut limits = vec![(-PI, PI); groups.len()];
    for limit in &options.limits {
        let membership = groups.of(limit.crease);
        let (lower, upper) = if membership.negative {
            (-limit.upper, -limit.lower)
        } else {
            (limit.lower, limit.upper)
        };
        let group = &mut limits[membership.group.index()];
        *group = (group.0.max(lower), group.1.min(upper));
    }
    limits
}

/// How much larger than closure residuals errors of a sheet with rounded coordinates are expected to be.
pub(super) const EXPECTED: f64 = 4.0;
/// Radians: an exactly closed configuration this near is the goal that was meant.
const NEARBY: f64 = 0.02;
/// Part of the closure residual allowed by which a crease may be turned where the goal does not tell, radians.
const ROUNDED: f64 = 0.25;
/// Parts of it that are tried as what creases are off: powers of the second up to the first.
const FINER: i32 = 10;
const FINE: f64 = 0.25;
/// Powers by which lines may be off by more than the goal is.
const MORE: i32 = 2;
/// Closure residual that rounding may leave at a vertex of many creases.
const ROUNDING: f64 = 1e-12;
/// Starts tried one after the other, as parts of the goal: at a flat-folded goal itself, where hinges
/// stand at their limits, a goal that closes but for rounding may have no way to the closed one near it.
const STARTS: [f64; 6] = [1.0, 0.999, 0.99, 0.95, 0.9, 0.8];
/// Radians: free hinges start this far from flat, the way of their letters, where flat itself leads
/// nowhere.
const AJAR: f64 = 0.5;

/// The closed configuration nearest to `asked` that turns no hinge against its sign, as far as descent
/// from there finds it. Free hinges (`None`) start flat, or ajar, and follow.
fn nearest_closed(
    solver: &mut ClosureSolver<'_>,
    asked: &[Option<f64>],
    signs: &[f64],
) -> Option<Vec<f64>> {
    let free = asked.iter().any(Option::is_none);
    let ajar = [0.0, AJAR];
    let starts = ajar[..=usize::from(free)].iter();
    let mut starts = starts.flat_map(|ajar| STARTS.map(|part| (part, *ajar)));
    let start = starts.find_map(|(part, ajar)| {
        let pairs = asked.iter().zip(signs);
        let start = pairs.map(|(asked, sign)| asked.map_or(sign * ajar, |asked| asked * part));
        let mut angles: Vec<f64> = start.collect();
        (solver.closes(&mut angles) && same_signs(&angles, asked)).then_some(angles)
    })?;
    Some(approach(solver, start, asked))
}

/// Closure residual up to which a goal counts as exact: above the rounding of angles in degrees.
pub const CLOSED: f64 = 1e-9;
/// Radians: angles this near are the same, but for rounding.
pub(super) const SAME: f64 = 1e-7;

/// Radians by which creases are off as coordinates are rounded, `most` at most, if a goal closes but for that. More may
/// have the sheet fold flat where it was not meant to: if `coarse`, as much as the goal closes with.
pub(super) fn rounding(
    stars: &ReducedStars,
    goal: &[Option<f64>],
    most: f64,
    coarse: bool,
) -> Option<f64> {
    let goal = goal.iter().copied().collect::<Option<Vec<f64>>>()?;
    let closes = |stars: &ReducedStars| stars.largest_residual(&goal) <= CLOSED;
    if closes(stars) {
        return None;
    }
    let mut tried = (0..=FINER).rev().map(|k| most * FINE.powi(k));
    let closes_within = |within: &f64| closes(&stars.unrounded(*within).0);
    let within = tried.find(closes_within)?;
    // Lines that are part of the goal may be off by more than it is.
    let more = (0..=if coarse { FINER } else { MORE }).rev();
    let mut more = more.map(|k| most.min(within * FINE.powi(-k)));
    more.find(closes_within)
}

/// Largest closure residual of given fold angles of the creases, over the whole sheet; `None` if a
/// crease has none.
#[must_use]
pub fn closure_of(pattern: &CreasePattern, fold_angles: &[Option<f64>]) -> Option<f64> {
    let angles = fold_angles.iter().copied().collect::<Option<Vec<f64>>>()?;
    Some(ReducedStars::of_creases(pattern).largest_residual(&angles))
}
