//! The reduced problem: crease groups as unknowns, stars and loops as closure conditions, and the goal in these terms.

use core::f64::consts::PI;
use std::sync::{Arc, OnceLock};

use super::follow::{approach, same_signs};
use crate::folding::{SpanningTree, worst_amplification};
use crate::lattice::Lattice;
use crate::pattern::{ClosureSite, CreasePattern, EdgeId};
use crate::planner::closing::solver::{ClosureSolver, Work};
use crate::planner::closing::sparse::Structure;
use crate::planner::problem::PlanningProblem;
use crate::planner::reason::WorstClosure;
use crate::planner::{Goal, PlanOptions, Vertices};
use crate::progress::Watch;
use crate::symmetry::{CreaseGroups, ReducedStars};

/// Largest number of faces for which testing all pairs of faces is faster than finding and folding a lattice.
const MAX_FACES_WITHOUT_LATTICE: usize = 20;

/// The unknowns and conditions of a plan.
pub(crate) struct Reduction<'a> {
    pub(crate) groups: CreaseGroups,
    /// Stars of all real vertices, and loops round all holes.
    pub(crate) all: ReducedStars,
    /// One star for each distinct condition.
    pub(crate) essential: ReducedStars,
    /// The stars of `all` without those that equal another one in every bit.
    distinct: ReducedStars,
    /// The distinct stars with the directions of the sheet, if those of `all` are snapped.
    rounded: Option<ReducedStars>,
    /// Largest angle by which creases may have been turned to snap the stars, radians.
    pub(crate) within: f64,
    vertices: Vertices,
    /// Lower and upper bound of each group angle, radians; empty for half a turn each way.
    limits: Vec<(f64, f64)>,
    pub(crate) watch: Watch<'a>,
    /// Spanning tree along which the whole sheet is folded.
    pub(crate) tree: &'a SpanningTree,
    /// Largest ratio of the errors of the whole sheet to the closure residuals; `None` if unknown.
    pub(crate) amplification: Option<f64>,
    /// Largest ratio that is assumed, whatever the worst case is; infinite to assume the worst case.
    expected: f64,
    /// Sparse structure of the stars to solve, once a solver has found it.
    structure: OnceLock<Option<Arc<Structure>>>,
    /// Lattice of the groups, once it was asked for.
    lattice: OnceLock<Option<Lattice>>,
}

/// A closed configuration near the goal.
pub(crate) struct ClosedGoal {
    /// Group angles, radians.
    pub(crate) angles: Vec<f64>,
    /// Largest difference from the goal as asked over all creases, radians.
    pub(crate) error: f64,
    /// Closure residual up to which a local minimum counted as closed; 0 if it had to close to the tolerance.
    pub(crate) closure_tolerance: f64,
}

impl<'a> Reduction<'a> {
    /// Makes the reduction to these groups, with the stars as they are.
    pub(crate) fn new(
        pattern: &'a CreasePattern,
        groups: CreaseGroups,
        options: &PlanOptions,
        watch: Watch<'a>,
    ) -> Self {
        let all = ReducedStars::all(pattern, &groups);
        Self::of_stars(pattern, groups, all, options, watch)
    }

    /// Makes the reduction of a problem to these groups, under its error model but for snapping.
    pub(crate) fn of(problem: &PlanningProblem<'a>, groups: CreaseGroups) -> Self {
        let reduction = Self::new(problem.pattern, groups, problem.options, problem.watch);
        // Errors of rounded coordinates do not add up. The errors of the sheet have to be measured then.
        let expected = if problem.errors.is_measured() {
            EXPECTED_AMPLIFICATION
        } else {
            f64::INFINITY
        };
        Self {
            expected,
            ..reduction
        }
    }

    /// Makes the reduction with these stars.
    fn of_stars(
        pattern: &'a CreasePattern,
        groups: CreaseGroups,
        all: ReducedStars,
        options: &PlanOptions,
        watch: Watch<'a>,
    ) -> Self {
        let tree = pattern.tree();
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
            amplification: worst_amplification(pattern, tree),
            tree,
            expected: f64::INFINITY,
            structure: OnceLock::new(),
            lattice: OnceLock::new(),
        }
    }

    /// Returns the reduction to stars that fold flat exactly where they nearly do, and the largest angle (radians) by
    /// which a crease is turned for that.
    ///
    /// With `coarse`, the angle up to which creases may be turned is the largest with which the goal closes, otherwise
    /// little more than the smallest; either is within what the bound allows. Returns `None` if no crease is turned by
    /// more than rounding, or if `coarse` turns them as far as it is without.
    pub(crate) fn snapped(
        &self,
        pattern: &'a CreasePattern,
        goal: &Goal,
        options: &PlanOptions,
        coarse: bool,
    ) -> Option<(Self, f64)> {
        let most = self.closure_tolerance(options);
        let asked = self.groups.reduce(&goal.fold_angles);
        let within =
            |coarse| snapping_angle(&self.all, &asked, most, coarse).unwrap_or(SNAP_RATIO * most);
        let told = within(false);
        let within = if coarse { within(true) } else { told };
        let (all, turned) = self.all.snapped(within);
        if coarse && (within <= told || all.has_stars_of(&self.all.snapped(told).0)) {
            return None;
        }
        let groups = self.groups.clone();
        let snapped = || Self {
            rounded: Some(self.distinct.clone()),
            within,
            expected: self.expected,
            ..Self::of_stars(pattern, groups, all, options, self.watch)
        };
        (turned > ROUNDING_RESIDUAL).then(|| (snapped(), turned))
    }

    /// Returns the lattice along which to look for crossings, if the groups have one and the sheet has more than a few
    /// faces.
    pub(crate) fn lattice(&self, pattern: &CreasePattern) -> Option<&Lattice> {
        let lattice = || Lattice::find(pattern, self.groups.memberships());
        // Without crease groups no two hinges turn alike, so that there is no lattice.
        (!self.groups.is_trivial() && pattern.faces().len() > MAX_FACES_WITHOUT_LATTICE)
            .then(|| self.lattice.get_or_init(lattice).as_ref())
            .flatten()
    }

    /// Makes a solver of the stars to solve. A local minimum of the residual counts as closed up to `closure_tolerance`.
    pub(crate) fn solver(
        &self,
        options: &PlanOptions,
        closure_tolerance: f64,
    ) -> ClosureSolver<'_> {
        let mut solver = ClosureSolver::new(
            self.stars(),
            options.solver,
            closure_tolerance,
            &self.structure,
            self.watch,
        );
        solver.limits.clone_from(&self.limits);
        solver
    }

    /// Returns limits between which each group turns in the direction of its sign or stays flat.
    pub(crate) fn orthant(&self, signs: &[f64]) -> Vec<(f64, f64)> {
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

    /// Returns `true` if the limits allow a goal.
    pub(crate) fn allows(&self, goal: &Goal) -> bool {
        let asked = self.groups.reduce(&goal.fold_angles);
        let mut pairs = asked.iter().zip(&self.limits);
        pairs.all(|(asked, (lower, upper))| {
            asked.is_none_or(|asked| asked >= lower - SAME_RAD && asked <= upper + SAME_RAD)
        })
    }

    /// Returns the goal in group angles, and for each group the sign with which it turns: of its goal angle, or else of
    /// its assignments.
    pub(crate) fn asked(&self, goal: &Goal) -> (Vec<Option<f64>>, Vec<f64>) {
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

    /// Returns the vertex or hole with the largest residual at the group angles `x`, with its hinges.
    pub(crate) fn worst(&self, pattern: &CreasePattern, x: &[f64]) -> Option<WorstClosure> {
        let residuals = self.all.residuals(x).into_iter().enumerate();
        let (worst, residual) = residuals.max_by(|a, b| a.1.total_cmp(&b.1))?;
        let vertices = self.all.vertices();
        let (site, edges): (_, Vec<EdgeId>) = match vertices.get(worst) {
            Some(&vertex) => (
                ClosureSite::Vertex(vertex),
                pattern.stars()[vertex.index()].to_vec(),
            ),
            None => {
                let hole = self.all.holes()[worst - vertices.len()];
                let way = pattern.holes()[hole].iter();
                (
                    pattern.hole_site(hole),
                    way.map(|passage| passage.edge).collect(),
                )
            }
        };
        let hinge = |edge: &EdgeId| pattern.edge(*edge).crease.is_some();
        Some(WorstClosure {
            site,
            edges: edges.into_iter().filter(hinge).collect(),
            residual,
        })
    }

    /// Returns the essential tolerance: the closure residual that no vertex may exceed.
    pub(crate) fn closure_tolerance(&self, options: &PlanOptions) -> f64 {
        self.tolerance(options.bound)
    }

    /// Returns the closure residual that all vertices may reach while the whole sheet keeps a bound.
    pub(crate) fn tolerance(&self, bound: f64) -> f64 {
        #[allow(clippy::cast_precision_loss, reason = "a scale")]
        let vertices = self.all.vertices().len().max(1) as f64;
        // If the amplification is unknown, the error of each vertex may add to that of the next.
        let worst = self.amplification.unwrap_or(vertices);
        (bound / worst.min(self.expected)).max(ROUNDING_RESIDUAL)
    }

    /// Returns the stars to solve.
    fn stars(&self) -> &ReducedStars {
        match self.vertices {
            Vertices::Essential => &self.essential,
            // Residuals that are equal in every bit add no condition.
            Vertices::All => &self.distinct,
        }
    }

    /// Returns the largest closure residual of all stars and loops.
    pub(crate) fn closure(&self, angles: &[f64]) -> f64 {
        self.distinct.largest_residual(angles)
    }

    /// Returns the largest closure residual of all stars and loops with the directions of the sheet.
    pub(crate) fn closure_of_sheet(&self, angles: &[f64]) -> f64 {
        let stars = self.rounded.as_ref().unwrap_or(&self.distinct);
        stars.largest_residual(angles)
    }

    /// Returns the largest difference of a crease between a configuration and a goal, radians.
    pub(crate) fn distance(&self, angles: &[f64], goal: &Goal) -> f64 {
        let creases = self.groups.expand(angles);
        let asked = creases.iter().zip(&goal.fold_angles);
        let errors = asked.filter_map(|(a, b)| Some((a - (*b)?).abs()));
        errors.fold(0.0, f64::max)
    }

    /// Moves the goal to the closed configuration near it. Returns `None` if there is none near, or the nearest turns a
    /// crease against the goal. If no configuration closes exactly because coordinates are rounded, returns one at a
    /// local minimum of the residual.
    pub(crate) fn close_goal(
        &self,
        goal: &Goal,
        options: &PlanOptions,
    ) -> (Option<ClosedGoal>, Work) {
        let (exact, mut work) = self.close_goal_to(0.0, goal, options);
        if goal.is_direction()
            && exact
                .as_ref()
                .is_some_and(|closed| self.is_flat_somewhere(closed, goal))
        {
            let (turned, more) = self.close_turned(goal, options);
            work += more;
            if turned.is_some() {
                return (turned, work);
            }
        }
        if exact
            .as_ref()
            .is_some_and(|closed| closed.error <= NEARBY_RAD)
        {
            return (exact, work);
        }
        let (rough, more) = self.close_goal_to(self.closure_tolerance(options), goal, options);
        work += more;
        let closed = match (exact, rough) {
            (Some(exact), Some(rough)) if exact.error <= rough.error => Some(exact),
            (exact, rough) => rough.or(exact),
        };
        (closed, work)
    }

    /// Returns `true` if a lettered crease is flat in a closed configuration.
    fn is_flat_somewhere(&self, closed: &ClosedGoal, goal: &Goal) -> bool {
        let (_, signs) = self.asked(goal);
        goal.flat(&signs, &closed.angles).next().is_some()
    }

    /// Moves letters that are a direction to an exactly closed configuration near it in which each lettered crease is
    /// turned.
    fn close_turned(&self, goal: &Goal, options: &PlanOptions) -> (Option<ClosedGoal>, Work) {
        let (_, signs) = self.asked(goal);
        let least = TURNED_RATIO * goal.least_turn();
        let limits = self.orthant(&signs).into_iter().zip(&signs);
        let limits = limits.map(|((lower, upper), sign)| match *sign {
            s if s > 0.0 => (lower.max(least).min(upper), upper),
            s if s < 0.0 => (lower, upper.min(-least).max(lower)),
            _ => (lower, upper),
        });
        let (closed, work) = self.close_within(limits.collect(), 0.0, goal, options);
        (
            closed.filter(|closed| self.closure(&closed.angles) <= CLOSED),
            work,
        )
    }

    /// As [`close_goal`](Self::close_goal), where a local minimum of the residual up to `closure_tolerance` counts as closed.
    pub(crate) fn close_goal_to(
        &self,
        closure_tolerance: f64,
        goal: &Goal,
        options: &PlanOptions,
    ) -> (Option<ClosedGoal>, Work) {
        let (_, signs) = self.asked(goal);
        self.close_within(self.orthant(&signs), closure_tolerance, goal, options)
    }

    /// As [`close_goal_to`](Self::close_goal_to), with these limits on the groups.
    fn close_within(
        &self,
        limits: Vec<(f64, f64)>,
        closure_tolerance: f64,
        goal: &Goal,
        options: &PlanOptions,
    ) -> (Option<ClosedGoal>, Work) {
        let (asked, signs) = self.asked(goal);
        // A goal that closes but for rounding is not solved for: no step leads nearer, and where the sheet is singular, as
        // folded flat, the solver would look for a configuration farther off.
        let as_asked: Option<Vec<f64>> = asked.iter().copied().collect();
        let is_allowed =
            |(angle, (lower, upper)): (&f64, &(f64, f64))| lower <= angle && angle <= upper;
        let as_asked = as_asked.filter(|angles| {
            angles.iter().zip(&limits).all(is_allowed) && self.closure(angles) <= ROUNDING_RESIDUAL
        });
        let mut solver = self.solver(options, closure_tolerance);
        solver.limits = limits;
        let closes = |angles: &Vec<f64>| self.closure(angles) <= self.closure_tolerance(options);
        let nearest = || nearest_closed(&mut solver, &asked, &signs).filter(closes);
        let closed = as_asked.or_else(nearest).map(|angles| ClosedGoal {
            error: self.distance(&angles, goal),
            angles,
            closure_tolerance,
        });
        (closed, solver.work)
    }
}

/// Returns the limits of the groups: for each group the angles that all its hinges allow.
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

/// Expected ratio of the errors of a sheet with rounded coordinates to its closure residuals.
pub(crate) const EXPECTED_AMPLIFICATION: f64 = 4.0;
/// Turn of each lettered crease with which a configuration is looked for that leaves none flat, over the least turn that
/// counts.
const TURNED_RATIO: f64 = 2.0;
/// Distance up to which an exactly closed configuration is the goal that was meant, radians.
const NEARBY_RAD: f64 = 0.02;
/// Angle (radians) by which a crease may be turned if the goal does not tell, as a fraction of the closure residual
/// allowed.
const SNAP_RATIO: f64 = 0.25;
/// Number of powers of [`SNAP_FACTOR`] that are tried, as fractions of the residual allowed, for the angle by which
/// creases are off.
const SNAP_POWERS: i32 = 10;
/// Ratio of an angle that is tried to the next larger one.
const SNAP_FACTOR: f64 = 0.25;
/// Number of powers of [`SNAP_FACTOR`] by which lines may be off by more than the goal is.
const LINE_POWERS: i32 = 2;
/// Closure residual that rounding may leave at a vertex of many creases.
pub(crate) const ROUNDING_RESIDUAL: f64 = 1e-12;
/// Starts tried one after the other, as fractions of the goal. At a flat-folded goal itself hinges stand at their
/// limits, so that no way may lead from there to the closed configuration near it, although the goal closes but for
/// rounding.
const START_RATIOS: [f64; 6] = [1.0, 0.999, 0.99, 0.95, 0.9, 0.8];
/// Angle from flat at which free hinges start, in the directions of their assignments, if flat itself leads nowhere,
/// radians.
const AJAR_RAD: f64 = 0.5;

/// Returns the closed configuration nearest to `asked` in which no hinge turns against its sign, as far as descent from
/// there finds it. Free hinges (`None`) start flat, or else ajar, and follow.
fn nearest_closed(
    solver: &mut ClosureSolver<'_>,
    asked: &[Option<f64>],
    signs: &[f64],
) -> Option<Vec<f64>> {
    let free = asked.iter().any(Option::is_none);
    let ajar = [0.0, AJAR_RAD];
    let starts = ajar[..=usize::from(free)].iter();
    let mut starts = starts.flat_map(|ajar| START_RATIOS.map(|part| (part, *ajar)));
    let start = starts.find_map(|(part, ajar)| {
        let pairs = asked.iter().zip(signs);
        let start = pairs.map(|(asked, sign)| asked.map_or(sign * ajar, |asked| asked * part));
        let mut angles: Vec<f64> = start.collect();
        (solver.closes(&mut angles) && same_signs(&angles, asked)).then_some(angles)
    })?;
    Some(approach(solver, start, asked))
}

/// Largest closure residual of a goal that counts as exact: above the rounding of angles in degrees.
pub const CLOSED: f64 = 1e-9;
/// Largest difference of angles that are equal but for rounding, radians.
pub(crate) const SAME_RAD: f64 = 1e-7;

/// Returns the angle (radians), at most `most`, by which creases are off because coordinates are rounded; `None` if the
/// goal closes as it is, closes with no such angle, or lacks an angle.
///
/// The angle is little more than the smallest with which the goal closes, as a larger one may let the sheet fold flat
/// where it was not meant to. With `coarse`, it is the largest with which the goal closes.
pub(crate) fn snapping_angle(
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
    let mut tried = (0..=SNAP_POWERS).rev().map(|k| most * SNAP_FACTOR.powi(k));
    let closes_within = |within: &f64| closes(&stars.snapped(*within).0);
    let within = tried.find(closes_within)?;
    // Lines that are part of the goal may be off by more than the goal is.
    let more = (0..=if coarse { SNAP_POWERS } else { LINE_POWERS }).rev();
    let mut more = more.map(|k| most.min(within * SNAP_FACTOR.powi(-k)));
    more.find(closes_within)
}
