//! The problem that is solved: crease groups as unknowns, some stars as conditions, and the goal in
//! these terms.

use super::solver::{ClosureSolver, Work, max_closure};
use super::{Goal, PlanOptions, Symmetry, Vertices};
use crate::folding::{Amplification, SpanningTree};
use crate::pattern::CreasePattern;
use crate::symmetry::{CreaseGroups, ReducedStars};

/// The unknowns and conditions of a plan.
pub(super) struct Reduction {
    pub(super) groups: CreaseGroups,
    /// Stars of all real vertices.
    pub(super) all: ReducedStars,
    /// One star for each distinct condition.
    pub(super) essential: ReducedStars,
    vertices: Vertices,
    /// The tree along which the whole sheet is folded.
    pub(super) tree: SpanningTree,
    /// How much larger than the closure residuals errors of the whole sheet can be.
    pub(super) amplification: Option<f64>,
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

impl Reduction {
    fn new(
        pattern: &CreasePattern,
        tree: SpanningTree,
        groups: CreaseGroups,
        vertices: Vertices,
    ) -> Self {
        let all = ReducedStars::all(pattern, &groups);
        Self {
            essential: all.essential(),
            all,
            groups,
            vertices,
            amplification: Amplification::new(pattern, &tree).map(|factors| factors.worst()),
            tree,
        }
    }

    /// A solver of the stars to solve, as exact as the closed goal is.
    pub(super) fn solver(&self, options: &PlanOptions, closed: &ClosedGoal) -> ClosureSolver<'_> {
        ClosureSolver::new(self.stars().view(), options.solver, closed.accepted)
    }

    /// The essential tolerance: closure residual that no vertex may exceed. If all did reach it, the
    /// whole sheet would still keep the bound.
    pub(super) fn accepted(&self, options: &PlanOptions) -> f64 {
        #[allow(clippy::cast_precision_loss, reason = "a scale")]
        let vertices = self.all.vertices().len().max(1) as f64;
        // Round a hole nothing is known for certain: each vertex may add to the next.
        (options.bound / self.amplification.unwrap_or(vertices)).max(ROUNDING)
    }

    /// The stars to solve.
    fn stars(&self) -> &ReducedStars {
        match self.vertices {
            Vertices::Essential => &self.essential,
            Vertices::All => &self.all,
        }
    }

    /// Largest closure residual of the whole sheet.
    pub(super) fn closure(&self, angles: &[f64]) -> f64 {
        max_closure(self.all.view(), angles)
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
    fn close_goal(
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
        let asked = self.groups.reduce(&goal.fold_angles);
        let mut solver = ClosureSolver::new(self.stars().view(), options.solver, accepted);
        let found = nearest_closed(&mut solver, &asked);
        work.iterations += solver.work.iterations;
        work.evaluations += solver.work.evaluations;
        let angles = found.filter(|angles| self.closure(angles) <= self.accepted(options))?;
        Some(ClosedGoal {
            error: self.distance(&angles, goal),
            angles,
            accepted,
        })
    }
}

/// Radians: an exactly closed configuration this near is the goal that was meant.
const NEARBY: f64 = 0.02;
/// Closure residual that rounding may leave at a vertex of many creases.
const ROUNDING: f64 = 1e-12;
/// Starts tried one after the other, as parts of the goal: at a flat-folded goal itself, where hinges
/// stand at their limits, a goal that closes but for rounding may have no way to the closed one near it.
const STARTS: [f64; 6] = [1.0, 0.999, 0.99, 0.95, 0.9, 0.8];
/// Steps towards the goal along the closed configurations. Each squares with the bend of the motion
/// over the distance, so that few are needed.
const APPROACHES: usize = 50;
/// Radians: a goal this near is reached.
const NEAR: f64 = 1e-12;

/// The closed configuration nearest to `asked` that turns no hinge against it, as far as descent from
/// there finds it. Free hinges (`None`) start flat and follow.
fn nearest_closed(solver: &mut ClosureSolver<'_>, asked: &[Option<f64>]) -> Option<Vec<f64>> {
    let same_signs = |x: &[f64]| {
        x.iter()
            .zip(asked)
            .all(|(a, b)| a * b.unwrap_or(0.0) >= 0.0)
    };
    let mut angles = STARTS.into_iter().find_map(|part| {
        let mut angles: Vec<f64> = asked.iter().map(|a| a.unwrap_or(0.0) * part).collect();
        (solver.closes(&mut angles) && same_signs(&angles)).then_some(angles)
    })?;
    let way_from = |x: &[f64]| -> Vec<f64> {
        x.iter()
            .zip(asked)
            .map(|(x, a)| a.map_or(0.0, |a| a - x))
            .collect()
    };
    let distance = |x: &[f64]| way_from(x).iter().map(|d| d * d).sum::<f64>();
    for _ in 0..APPROACHES {
        let mut way = way_from(&angles);
        if distance(&angles) <= NEAR * NEAR || !solver.project_on_motions(&angles, &mut way) {
            break;
        }
        let mut nearer: Vec<f64> = angles.iter().zip(&way).map(|(x, d)| x + d).collect();
        let closed = solver.closes(&mut nearer) && same_signs(&nearer);
        if !closed || distance(&nearer) >= distance(&angles) {
            break;
        }
        angles = nearer;
    }
    Some(angles)
}

/// The reduction by crease groups if the whole sheet closes under it at the goal, else that without
/// symmetry, with a note why.
pub(super) fn reduce(
    pattern: &CreasePattern,
    goal: &Goal,
    options: &PlanOptions,
    work: &mut Work,
    notes: &mut Vec<String>,
) -> (Reduction, Option<ClosedGoal>) {
    let mut tree = SpanningTree::from_central_face(pattern);
    if options.symmetry == Symmetry::Auto {
        let found = CreaseGroups::find(pattern);
        let fine = found.is_rough().then(|| CreaseGroups::find_exact(pattern));
        // Groups of a finer symmetry fold the sheet more exactly, if they do at all.
        let finer = fine.clone().filter(|g| g.len() < pattern.creases().len());
        // A goal far away is not what was asked for: with every crease free, one may be nearer. Nor is
        // one beside a goal that closes as it stands, all creases on their own.
        let symmetric = found.len() < pattern.creases().len();
        let exact =
            symmetric && closure_of(pattern, &goal.fold_angles).is_some_and(|c| c <= CLOSED);
        let reach = if exact { SAME } else { goal.reach };
        let tries = [(finer, true), (Some(found), false), (fine, false)];
        for (groups, exactly) in tries {
            let Some(groups) = groups else { continue };
            let (count, rough, tolerance) = (groups.len(), groups.is_rough(), groups.tolerance());
            let reduction = Reduction::new(pattern, tree, groups, options.vertices);
            let closed = reduction.close_goal(goal, options, work);
            let trivial = count == pattern.creases().len();
            let near = |c: &ClosedGoal| c.error <= reach && !(exactly && c.accepted > 0.0);
            if trivial || closed.as_ref().is_some_and(near) {
                if rough {
                    notes.push(format!(
                        "{count} crease groups: the sheet is symmetric only to {tolerance:.0e} of its \
                         median edge"
                    ));
                }
                return (reduction, closed);
            }
            if !exactly {
                notes.push(format!(
                    "{count} crease groups dropped: the goal does not close under them"
                ));
            }
            tree = reduction.tree;
        }
    }
    let groups = CreaseGroups::trivial(pattern);
    let reduction = Reduction::new(pattern, tree, groups, options.vertices);
    let closed = reduction.close_goal(goal, options, work);
    (reduction, closed)
}

/// Closure residual up to which a goal counts as exact: above the rounding of angles in degrees.
pub(super) const CLOSED: f64 = 1e-9;
/// Radians: angles this near are the same, but for rounding.
const SAME: f64 = 1e-7;

/// Largest closure residual of given fold angles of the creases, over the whole sheet; `None` if a
/// crease has none.
#[must_use]
pub fn closure_of(pattern: &CreasePattern, fold_angles: &[Option<f64>]) -> Option<f64> {
    let groups = CreaseGroups::trivial(pattern);
    let angles = groups
        .reduce(fold_angles)
        .into_iter()
        .collect::<Option<Vec<f64>>>()?;
    let stars = ReducedStars::all(pattern, &groups);
    Some(max_closure(stars.view(), &angles))
}
