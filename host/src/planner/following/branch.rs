//! Leaves the flat sheet: branch switching at a singular configuration.
//!
//! The closed configurations near flat form a cone with several branches, which derivatives do not distinguish. A small
//! finite step, closed, lands on one of the branches. If that branch does not have the signs wanted, one hinge is held
//! at its angle, so that the sheet cannot fall back to flat, and the others are closed within the orthant of these
//! signs.

use foldpath_core::least_squares::Limits;
use foldpath_core::sampling::random_near;
use rand_pcg::Pcg64;

use super::reduction::Reduction;
use crate::pattern::{CreasePattern, EdgeId};
use crate::planner::closing::solver::{ClosureSolver, Work};
use crate::planner::vectors::{cosine, max_norm};
use crate::planner::{PlanOptions, Vertices};
use crate::progress::Watch;
use crate::symmetry::CreaseGroups;

/// Largest angle of the first step, radians. Small enough that branches are straight, large enough that the
/// second-order conditions that choose between branches are far above rounding.
const FIRST_STEP_RAD: f64 = 0.1;
/// Number of random first steps tried beside the one straight towards the goal.
const RANDOM_STEPS: usize = 8;
/// Angle below which a hinge has not turned, as a fraction of the largest angle.
pub(crate) const UNTURNED_RATIO: f64 = 1e-3;
/// Least angles of every hinge, as fractions of the largest angle, tried one after the other. Without such a limit, the
/// sheet lands on motions that turn only some of its hinges.
const MIN_TURN_RATIOS: [f64; 3] = [0.1, 0.01, 0.0];
/// Cosine between the directions of two branches above which they are the same branch.
const MIN_SAME_BRANCH_COSINE: f64 = 0.999;
/// Smallest cosine between a configuration of a branch and the one at a quarter of its size if the branch leads to
/// flat.
const MIN_STRAIGHT_COSINE: f64 = 0.9;
/// Size of a closed first step below which it has fallen back to flat, as a fraction of its size before closing.
const MIN_SIZE_RATIO: f64 = 0.1;
/// Size of a closed first step above which it has gone elsewhere, as a multiple of its size before closing.
const MAX_SIZE_RATIO: f64 = 2.0;

/// Returns closed configurations a small step from flat on different branches, none against the `signs`. Those that
/// turn most hinges come first, and among these the nearest to the direction of `towards`. Returns the work of the solver
/// too.
pub(crate) fn branches_at_flat(
    reduction: &Reduction,
    towards: &[f64],
    signs: &[f64],
    closure_tolerance: f64,
    options: &PlanOptions,
) -> (Vec<Vec<f64>>, Work) {
    let mut switcher = BranchSwitcher::new(reduction, options, closure_tolerance, signs);
    let first_step = FIRST_STEP_RAD.min(options.max_step / 2.0);
    let scale = first_step / max_norm(towards).max(f64::MIN_POSITIVE);
    let straight: Vec<f64> = towards.iter().map(|t| t * scale).collect();
    let mut rng = Pcg64::new(u128::from(options.seed), 0);
    let mut starts = vec![straight.clone()];
    for _ in 0..RANDOM_STEPS {
        let mut start = straight.clone();
        random_near(
            &mut rng,
            &straight,
            first_step,
            Limits::HalfTurn,
            &mut start,
        );
        starts.push(start);
    }
    let unturned = |x: &[f64]| {
        let least = UNTURNED_RATIO * max_norm(x);
        let pairs = x.iter().zip(signs);
        pairs
            .filter(|(x, sign)| sign.abs() > 0.0 && x.abs() < least)
            .count()
    };
    let mut found: Vec<Vec<f64>> = Vec::new();
    for start in starts {
        let mut x = start;
        let new = switcher.land(&mut x)
            && found
                .iter()
                .all(|other| cosine(other, &x) < MIN_SAME_BRANCH_COSINE);
        if new {
            found.push(x);
        }
    }
    found.sort_by(|a, b| {
        let far = |x: &[f64]| -cosine(x, towards);
        unturned(a)
            .cmp(&unturned(b))
            .then(far(a).total_cmp(&far(b)))
    });
    let mut work = switcher.free.work;
    work += switcher.held.work;
    (found, work)
}

/// Closes small steps from flat on branches with given signs.
struct BranchSwitcher<'a> {
    free: ClosureSolver<'a>,
    held: ClosureSolver<'a>,
    /// Limits between which each unknown turns in the direction of its sign.
    orthant: Vec<(f64, f64)>,
    signs: &'a [f64],
}

impl<'a> BranchSwitcher<'a> {
    fn new(
        reduction: &'a Reduction<'a>,
        options: &PlanOptions,
        closure_tolerance: f64,
        signs: &'a [f64],
    ) -> Self {
        Self {
            free: reduction.solver(options, closure_tolerance),
            held: reduction.solver(options, closure_tolerance),
            orthant: reduction.orthant(signs),
            signs,
        }
    }

    /// Moves `x`, a small step from flat, to a closed configuration of about the same size that turns no hinge against
    /// its sign, on a branch that leads to flat.
    fn land(&mut self, x: &mut [f64]) -> bool {
        let start = x.to_vec();
        if self.free.closes(x) && self.is_good(x, &start) {
            return true;
        }
        let sizes = start.iter().map(|angle| angle.abs());
        let Some((largest, size)) = sizes.enumerate().max_by(|a, b| a.1.total_cmp(&b.1)) else {
            return false;
        };
        MIN_TURN_RATIOS.iter().any(|least| {
            let mut limits = self.orthant.clone();
            for ((lower, upper), sign) in limits.iter_mut().zip(self.signs) {
                if *sign > 0.0 {
                    *lower = upper.min(least * size);
                } else if *sign < 0.0 {
                    *upper = lower.max(-least * size);
                }
            }
            for ((x, start), &(lower, upper)) in x.iter_mut().zip(&start).zip(&limits) {
                *x = start.clamp(lower, upper);
            }
            limits[largest] = (x[largest], x[largest]);
            self.held.limits = limits;
            self.held.closes(x) && self.is_good(x, &start)
        })
    }

    fn is_good(&mut self, x: &[f64], start: &[f64]) -> bool {
        let mut signs = x.iter().zip(self.signs);
        let (size, first) = (max_norm(x), max_norm(start));
        if size < MIN_SIZE_RATIO * first
            || size > MAX_SIZE_RATIO * first
            || !signs.all(|(x, sign)| x * sign >= 0.0)
        {
            return false;
        }
        let mut nearer: Vec<f64> = x.iter().map(|a| a / 4.0).collect();
        self.free.closes(&mut nearer) && cosine(&nearer, x) >= MIN_STRAIGHT_COSINE
    }
}

/// Configuration near flat to which a small step leads.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Departure {
    /// Fold angles near the start, radians.
    pub fold_angles: Vec<f64>,
    /// Largest closure residual of these angles.
    pub closure: f64,
    /// Edges with assignment M or V that do not turn in its direction. If there are any, the branch is not the one that
    /// the assignments mean.
    pub against: Vec<EdgeId>,
}

/// Leaves the flat sheet near the configuration `start` (radians, one angle for each crease) on the branch whose signs
/// are those of the assignments.
///
/// If `start` lands on no such branch, its sizes are tried with the signs of the assignments, then one size for all
/// creases.
#[must_use]
pub fn leave_flat(pattern: &CreasePattern, start: &[f64]) -> Departure {
    let options = PlanOptions {
        vertices: Vertices::All,
        ..PlanOptions::default()
    };
    let reduction = Reduction::new(
        pattern,
        CreaseGroups::trivial(pattern),
        &options,
        Watch::default(),
    );
    let groups = &reduction.groups;
    let in_groups = |creases: &mut dyn Iterator<Item = f64>| -> Vec<f64> {
        let creases: Vec<_> = creases.map(Some).collect();
        groups.reduce(&creases).into_iter().flatten().collect()
    };
    let letters = |&id| pattern.edge(id).letter.sign();
    let signs = in_groups(&mut pattern.creases().iter().map(letters));
    let start = in_groups(&mut start.iter().copied());
    let mut switcher = BranchSwitcher::new(&reduction, &options, 0.0, &signs);
    let signed = |size: &dyn Fn(f64) -> f64| -> Vec<f64> {
        let pairs = start.iter().zip(&signs);
        let turned = |(x, sign): (&f64, &f64)| {
            if sign.abs() > 0.0 {
                sign * size(*x)
            } else {
                *x
            }
        };
        pairs.map(turned).collect()
    };
    let largest = max_norm(&start);
    let starts = [start.clone(), signed(&f64::abs), signed(&|_| largest)];
    let mut first = None;
    for mut x in starts {
        let leaves = switcher.land(&mut x);
        let least = UNTURNED_RATIO * max_norm(&x);
        let pairs = x.iter().zip(&signs).zip(pattern.creases());
        let against =
            pairs.filter(|((x, sign), _)| sign.abs() > 0.0 && !(leaves && *x * *sign >= least));
        let departure = Departure {
            against: against.map(|(_, &edge)| edge).collect(),
            closure: reduction.all.largest_residual(&x),
            fold_angles: groups.expand(&x),
        };
        if departure.against.is_empty() {
            return departure;
        }
        first.get_or_insert(departure);
    }
    first.unwrap_or_default()
}
