//! Leaving the flat sheet.
//!
//! Flat is singular: the closed configurations near it form a cone with several branches, and
//! derivatives do not tell them apart. A small finite step along the signs wanted, closed within the
//! orthant of these signs, lands on a branch that has them, if there is one.

use foldpath_core::least_squares::Limits;
use foldpath_core::sampling::random_near;
use rand_pcg::Pcg64;

use super::follow::{cosine, max_norm};
use super::reduction::Reduction;
use super::solver::{ClosureSolver, Work, max_closure};
use super::{PlanOptions, Vertices};
use crate::pattern::{CreasePattern, EdgeId};
use crate::symmetry::CreaseGroups;

/// Radians: largest angle of the first step. Small enough that branches are straight, large enough that
/// the second-order conditions that choose between them are far above rounding.
const FIRST_STEP: f64 = 0.1;
/// Random first steps tried beside that straight towards the goal.
const RANDOM_STEPS: usize = 8;
/// Part of the largest angle below which a hinge has not turned.
const UNTURNED: f64 = 1e-3;
/// Branches whose directions have a larger cosine are one.
const SAME_BRANCH: f64 = 0.999;
/// A branch leads to flat if its configuration at a quarter of the size has the same direction, as far as
/// this cosine.
const STRAIGHT: f64 = 0.9;
/// A first step that shrinks by more in closing has fallen back to flat.
const SHRUNK: f64 = 0.1;

/// Closed configurations a small step from flat on different branches, none against the `signs`; those
/// that turn most hinges come first, and of these the nearest to the direction of `towards`.
pub(super) fn departures(
    reduction: &Reduction,
    towards: &[f64],
    signs: &[f64],
    accepted: f64,
    options: &PlanOptions,
    work: &mut Work,
) -> Vec<Vec<f64>> {
    let mut solver = reduction.signed_solver(options, accepted, signs);
    let scale = FIRST_STEP / max_norm(towards).max(f64::MIN_POSITIVE);
    let straight: Vec<f64> = towards.iter().map(|t| t * scale).collect();
    let mut rng = Pcg64::new(u128::from(options.seed), 0);
    let mut starts = vec![straight.clone()];
    for _ in 0..RANDOM_STEPS {
        let mut start = straight.clone();
        random_near(
            &mut rng,
            &straight,
            FIRST_STEP,
            Limits::HalfTurn,
            &mut start,
        );
        starts.push(start);
    }
    let unturned = |x: &[f64]| {
        let least = UNTURNED * max_norm(x);
        let pairs = x.iter().zip(signs);
        pairs
            .filter(|(x, sign)| sign.abs() > 0.0 && x.abs() < least)
            .count()
    };
    let mut found: Vec<Vec<f64>> = Vec::new();
    for start in starts {
        let mut x = start;
        let new = leaves_flat(&mut solver, &mut x)
            && found.iter().all(|other| cosine(other, &x) < SAME_BRANCH);
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
    work.iterations += solver.work.iterations;
    work.evaluations += solver.work.evaluations;
    found
}

/// Moves `x`, a small step from flat, to a closed configuration of the same size on a branch that leads to
/// flat.
fn leaves_flat(solver: &mut ClosureSolver<'_>, x: &mut [f64]) -> bool {
    let size = max_norm(x);
    if !solver.closes(x) || max_norm(x) < SHRUNK * size {
        return false;
    }
    let mut nearer: Vec<f64> = x.iter().map(|a| a / 4.0).collect();
    solver.closes(&mut nearer) && cosine(&nearer, x) >= STRAIGHT
}

/// Where a small step from flat leads.
#[derive(Clone, Debug, PartialEq)]
pub struct Departure {
    /// A configuration near the start, radians.
    pub fold_angles: Vec<f64>,
    /// Its largest closure residual.
    pub closure: f64,
    /// Edges lettered M or V that do not turn their way there. If there are any, the branch is not the
    /// one that the letters mean.
    pub against: Vec<EdgeId>,
}

/// Leaves the flat sheet near the configuration `start` (radians, one angle for each crease) on the branch
/// whose signs are those of the letters.
///
/// Where a start lands on no such branch, its sizes are tried with the signs of the letters, then one
/// size for all creases.
#[must_use]
pub fn leave_flat(pattern: &CreasePattern, start: &[f64]) -> Departure {
    let options = PlanOptions {
        vertices: Vertices::All,
        ..PlanOptions::default()
    };
    let reduction = Reduction::new(pattern, CreaseGroups::trivial(pattern), &options, None);
    let edges = pattern.creases().iter();
    let signs: Vec<f64> = edges.map(|&id| pattern.edge(id).letter.sign()).collect();
    let mut solver = reduction.signed_solver(&options, 0.0, &signs);
    let signed = |size: &dyn Fn(f64) -> f64| -> Vec<f64> {
        let pairs = start.iter().zip(&signs);
        pairs
            .map(|(x, sign)| {
                if sign.abs() > 0.0 {
                    sign * size(*x)
                } else {
                    *x
                }
            })
            .collect()
    };
    let starts = [
        start.to_vec(),
        signed(&f64::abs),
        signed(&|_| max_norm(start)),
    ];
    let landed = starts.map(|mut x| {
        let leaves = leaves_flat(&mut solver, &mut x);
        let least = UNTURNED * max_norm(&x);
        let pairs = x.iter().zip(&signs).zip(pattern.creases());
        let against = pairs.filter(|((x, sign), _)| {
            !leaves && sign.abs() > 0.0 || *x * *sign < least * sign.abs()
        });
        let against = against.map(|(_, &edge)| edge).collect();
        Departure {
            closure: max_closure(reduction.all.view(), &x),
            fold_angles: x,
            against,
        }
    });
    let [first, ..] = &landed;
    let good = landed.iter().find(|departure| departure.against.is_empty());
    good.unwrap_or(first).clone()
}
