//! Folds the whole sheet at the knots of a motion and measures its errors there.

use core::sync::atomic::{AtomicUsize, Ordering};
use core::time::Duration;

use super::certified_motion::{Certificate, Lifting};
use crate::folding::{FoldingMap, Rigidity, SpanningTree};
use crate::planner::following::judge::Judge;
use crate::planner::following::reduction::CLOSED;
use crate::planner::knots::Knot;
use crate::planner::plan::{Failure, Outcome, Plan};
use crate::planner::reason::Reason;
use crate::util::clock::Instant;
use crate::util::parallel;

/// About the time that folding and measuring the sheet takes for each face.
const TIME_PER_FACE: Duration = Duration::from_nanos(500);

/// Points of each segment at which the sheet is folded from its rim, as fractions of the segment.
const RIM_FRACTIONS: [f64; 4] = [0.25, 0.5, 0.75, 1.0];

/// Knots with the errors of the sheet at them.
pub(crate) struct MeasuredMotion {
    /// The knots; those before `late`, if time ran out.
    pub(crate) knots: Vec<Knot>,
    /// Number of the knot at which time ran out, if it did.
    pub(crate) late: Option<usize>,
    /// Largest errors of the essential crease pattern and its number of faces, if they were measured.
    pub(crate) essential: Option<(Rigidity, usize)>,
    /// Time spent folding.
    pub(crate) time: Duration,
}

impl MeasuredMotion {
    /// Returns the largest errors over all knots; the closure residual takes the place of the twist.
    pub(crate) fn worst(&self) -> Rigidity {
        let errors = self.knots.iter().map(Knot::errors);
        errors.fold(Rigidity::default(), Rigidity::worse)
    }

    /// Returns the largest closure residual over all knots, or `before` if that is larger.
    pub(crate) fn max_closure(&self, before: f64) -> f64 {
        let closure = self.knots.iter().map(|knot| knot.errors().twist);
        closure.fold(before, f64::max)
    }
}

/// Returns the failure of a sheet that breaks the bound at its knots, or is not proved to keep the bound between them.
pub(crate) fn torn(bound: f64, plan: &Plan, certificate: Option<Certificate>) -> Option<Failure> {
    let (whole, closure) = (plan.rigidity, plan.max_closure);
    let within = |errors: [f64; 3]| errors.iter().all(|error| *error <= bound);
    if within([whole.deformation, whole.gap, closure]) {
        let certified = certificate?.over(bound)?;
        return Some(Failure {
            outcome: Outcome::NotRigidlyFoldable,
            reason: Reason::NotCertified { certified, bound },
            kept: 0.0,
        });
    }
    let holds = |knot: &&Knot| {
        let errors = knot.errors();
        within([errors.deformation, errors.gap, errors.twist])
    };
    let knots = &plan.path.knots;
    let good = knots.iter().take_while(holds).last();
    let [good, last] = [good, knots.last()].map(|knot| knot.map(|knot| knot.stored.time));
    let kept = match (good, last) {
        (Some(good), Some(last)) if last > 0.0 => good / last,
        (Some(_), Some(_)) => 0.0,
        _ => 1.0,
    };
    Some(Failure {
        outcome: Outcome::NotRigidlyFoldable,
        reason: Reason::Deforms {
            whole,
            closure,
            essential: plan.essential_rigidity,
            bound,
        },
        kept,
    })
}

impl Lifting<'_> {
    /// Folds the sheet at knots and measures it there.
    pub(crate) fn measure(&self, knots: Vec<Knot>) -> MeasuredMotion {
        let start = Instant::now();
        let problem = self.problem;
        let count = knots.len();
        let judge = || {
            let mut judge = Judge::new(problem, self.reduction, false);
            judge.keep_vertices = problem.options.keep_vertices;
            judge
        };
        let done = AtomicUsize::new(0);
        let each = parallel::total_time(problem.pattern.faces().len(), TIME_PER_FACE);
        let measured = parallel::map_with(&knots, each, judge, |judge, knot| {
            if problem.is_late() {
                return None;
            }
            let mut knot = knot.clone();
            judge.judge(&mut knot);
            problem
                .watch
                .done(1 + done.fetch_add(1, Ordering::Relaxed), count);
            Some(knot)
        });
        let knots: Vec<Knot> = measured.into_iter().map_while(|knot| knot).collect();
        let late = (knots.len() < count).then_some(knots.len());
        let essential = late.is_none().then(|| {
            let angles = knots.iter().map(|knot| knot.stored.angles.as_slice());
            judge().essential(angles)
        });
        MeasuredMotion {
            knots,
            late,
            essential,
            time: start.elapsed(),
        }
    }

    /// Returns the failure of a sheet that breaks the bound when it is folded from its rim, and the time spent. From there,
    /// errors of vertices that do not close add up over a longer way.
    pub(crate) fn torn_from_rim(&self, plan: &Plan) -> (Option<Failure>, Duration) {
        if plan.max_closure <= CLOSED {
            return (None, Duration::ZERO);
        }
        let start = Instant::now();
        let pattern = self.problem.pattern;
        let tree = SpanningTree::from_outer_face(pattern);
        let mut map = FoldingMap::flat(pattern);
        let curves = plan.path.curves();
        let shapes = curves.iter().flat_map(|curves| {
            RIM_FRACTIONS.map(|s| curves.iter().map(|c| c.angle(s)).collect::<Vec<_>>())
        });
        let rigidity = shapes.fold(Rigidity::default(), |worst, angles| {
            let memberships = self.reduction.groups.memberships();
            map.fold_groups(pattern, &tree, memberships, &angles);
            worst.worse(map.rigidity(pattern, &tree))
        });
        let time = start.elapsed();
        let bound = self.problem.options.bound;
        let holds = rigidity.deformation <= bound && rigidity.gap <= bound;
        let failure = (!holds).then_some(Failure {
            outcome: Outcome::NotRigidlyFoldable,
            reason: Reason::DeformsFromRim { rigidity, bound },
            kept: 0.0,
        });
        (failure, time)
    }
}
