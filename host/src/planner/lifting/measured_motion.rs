//! Folds the whole sheet at the knots of a motion and measures its errors there.

use core::sync::atomic::{AtomicUsize, Ordering};
use core::time::Duration;

use super::certified_motion::Lifting;
use crate::folding::{FoldingMap, Rigidity, SpanningTree};
use crate::motion::Knot;
use crate::planner::following::judge::Judge;
use crate::planner::following::reduction::CLOSED;
use crate::planner::knots::{KnotSequence, claims, errors};
use crate::planner::plan::{Certificate, SheetErrors};
use crate::planner::reason::Reason;
use crate::util::parallel;

/// About the time that folding and measuring the sheet takes for each face.
const TIME_PER_FACE: Duration = Duration::from_nanos(500);

/// Points of each segment at which the sheet is folded from its rim, as fractions of the segment.
const RIM_FRACTIONS: [f64; 4] = [0.25, 0.5, 0.75, 1.0];

/// Returns the reason why a sheet breaks the bound at its knots, with the number of the last knot before, or why it is not
/// proved to keep the bound between them.
pub(crate) fn torn(
    bound: f64,
    knots: &[Knot],
    found: &SheetErrors,
    certificate: Option<Certificate>,
) -> Option<(Reason, Option<usize>)> {
    let (whole, closure) = (found.rigidity, found.closure);
    let within = |errors: [f64; 3]| errors.iter().all(|error| *error <= bound);
    if within([whole.deformation, whole.gap, closure]) {
        let certified = certificate?.over(bound)?;
        return Some((Reason::NotCertified { certified, bound }, None));
    }
    let holds = |knot: &&Knot| {
        let errors = errors(knot);
        within([errors.deformation, errors.gap, errors.twist])
    };
    let good = knots.iter().take_while(holds).count();
    let essential = found.essential_rigidity;
    let reason = Reason::Deforms {
        whole,
        closure,
        essential,
        bound,
    };
    Some((reason, Some(good.saturating_sub(1))))
}

impl Lifting<'_> {
    /// Folds the sheet at knots, stores its errors there, and returns the largest, with a closure residual of at least
    /// `min_closure`. `Err` has the number of the knot at which time ran out.
    pub(crate) fn measure(
        &self,
        knots: &mut Vec<Knot>,
        min_closure: f64,
    ) -> Result<SheetErrors, usize> {
        let problem = self.problem;
        let count = knots.len();
        let judge = || Judge::new(problem, self.reduction, false);
        let done = AtomicUsize::new(0);
        let each = parallel::total_time(problem.pattern.faces().len(), TIME_PER_FACE);
        let measured = parallel::map_with(knots, each, judge, |judge, knot| {
            if problem.is_late() {
                return None;
            }
            let mut knot = knot.clone();
            self.measure_knot(judge, &mut knot);
            problem
                .watch
                .done(1 + done.fetch_add(1, Ordering::Relaxed), count);
            Some(knot)
        });
        *knots = measured.into_iter().map_while(|knot| knot).collect();
        if knots.len() < count {
            return Err(knots.len());
        }
        let angles = knots.iter().map(|knot| knot.angles.as_slice());
        let (essential_rigidity, essential_faces) = judge().essential(angles);
        let all = knots.iter().map(errors);
        let closure = all.clone().map(|errors| errors.twist);
        Ok(SheetErrors {
            rigidity: all.fold(Rigidity::default(), Rigidity::worse),
            closure: closure.fold(min_closure, f64::max),
            essential_rigidity,
            essential_faces,
        })
    }

    /// Folds the sheet at a knot, and stores its errors there.
    pub(crate) fn measure_knot(&self, judge: &mut Judge<'_>, knot: &mut Knot) {
        knot.claims = claims(judge.errors_at(&knot.angles));
        if self.problem.options.keep_vertices {
            knot.vertices = judge.vertices().to_vec();
        }
    }

    /// Returns the reason why a sheet breaks the bound when it is folded from its rim. From there, errors of vertices
    /// that do not close add up over a longer way. `closure` is the largest closure residual at the knots.
    pub(crate) fn torn_from_rim(&self, knots: &KnotSequence, closure: f64) -> Option<Reason> {
        if closure <= CLOSED {
            return None;
        }
        let pattern = self.problem.pattern;
        let tree = SpanningTree::from_outer_face(pattern);
        let mut map = FoldingMap::flat(pattern);
        let shapes = knots.curves().flat_map(|curves| {
            RIM_FRACTIONS.map(|s| curves.iter().map(|c| c.angle(s)).collect::<Vec<_>>())
        });
        let rigidity = shapes.fold(Rigidity::default(), |worst, angles| {
            let memberships = self.reduction.groups.memberships();
            map.fold_groups(pattern, &tree, memberships, &angles);
            worst.worse(map.rigidity(pattern, &tree))
        });
        let bound = self.problem.options.bound;
        let holds = rigidity.deformation <= bound && rigidity.gap <= bound;
        (!holds).then_some(Reason::DeformsFromRim { rigidity, bound })
    }
}
