//! Places knots on a path: as few as the bound on closure between them and the limits on angle, speed and acceleration of
//! the hinges allow, with the interpolation and time law that need the fewest.

use foldpath_core::Interpolation;

use super::knot_placer::{KnotPlacer, PlacementConstraints};
use super::reduced_path::ReducedPath;
use super::segment::TimeLaw;
use crate::planner::closing::solver::ClosureSolver;
use crate::planner::knots::KnotSequence;
use crate::planner::options::{PlanOptions, Timing};

/// Places knots on a path, with the interpolation asked for or the one that needs the fewest.
///
/// Homogeneous half angles, which other programs do not know, are taken only if they save most of the knots, or keep the
/// closure condition farther. Returns `None` if no interpolation keeps the conditions with the largest number of knots.
pub(crate) fn place(
    path: &ReducedPath,
    constraints: &PlacementConstraints<'_>,
    solver: &mut ClosureSolver<'_>,
    options: &PlanOptions,
) -> Option<KnotSequence> {
    let mut placer = KnotPlacer::new(path, constraints, solver);
    if path.waypoints().len() < 2 {
        return placer.alone();
    }
    let all = [
        Interpolation::HalfAngle,
        Interpolation::Hermite,
        Interpolation::Homogeneous,
    ];
    let kinds = match &options.interpolation {
        Some(kind) => core::slice::from_ref(kind),
        // Without conditions hinges turn evenly. If nothing closes, no interpolation is nearer to closing, and Hermite
        // is the best to follow.
        None if constraints.stars.is_empty() || constraints.sheet.is_some() => &all[1..2],
        None => &all,
    };
    let optimal = (options.pace == Timing::Optimal).then(|| [fastest(path, constraints)]);
    let mut best: Option<KnotSequence> = None;
    for &kind in kinds {
        if let Some(best) = best.as_ref().filter(|best| best.open.is_none()) {
            if best.knots.len() <= FEW_KNOTS {
                break;
            }
            placer.knot_budget = match kind {
                Interpolation::Homogeneous => best.knots.len() / HOMOGENEOUS_SAVING,
                _ => best.knots.len() - 1,
            };
        }
        let sparse;
        let laws: &[TimeLaw] = if let Some(optimal) = &optimal {
            optimal
        } else {
            sparse = sparse_laws(path, kind);
            &sparse
        };
        for law in laws {
            placer.keeps_to = best.as_ref().map_or(f64::NEG_INFINITY, |best| {
                let kept = kept_to(best);
                match kind {
                    Interpolation::Homogeneous => kept,
                    // As far is far enough.
                    _ => kept.next_down(),
                }
            });
            let Some(placed) = placer.place(kind, law) else {
                continue;
            };
            let better = best.as_ref().is_none_or(|best| is_better(&placed, best));
            if better {
                if placed.open.is_none() {
                    placer.knot_budget = placer.knot_budget.min(placed.knots.len());
                }
                best = Some(placed);
            }
        }
    }
    best
}

/// Returns `true` if a motion keeps the closure condition farther than the best so far or, if it does as far, has fewer knots
/// or takes less time.
fn is_better(new: &KnotSequence, best: &KnotSequence) -> bool {
    let time = |motion: &KnotSequence| motion.knots.last().map_or(0.0, |last| last.time);
    let [new_time, best_time] = [new, best].map(time);
    let order = kept_to(best).total_cmp(&kept_to(new));
    let order = order.then(new.knots.len().cmp(&best.knots.len()));
    order.then(new_time.total_cmp(&best_time)).is_lt()
}

/// Returns the path length up to which a motion keeps the closure condition; infinity if it does to its end.
fn kept_to(motion: &KnotSequence) -> f64 {
    let open = motion.open.as_ref();
    open.map_or(f64::INFINITY, |open| open.arc_length)
}

/// Returns the fastest time law of a path.
fn fastest(path: &ReducedPath, constraints: &PlacementConstraints<'_>) -> TimeLaw {
    let groups = constraints.limits.len();
    let parts = (MAX_GRID_ANGLES / groups.max(1)).clamp(1, MAX_INTERVALS);
    let law = path.fastest(parts, constraints.speed, constraints.acceleration);
    law.map_or(TimeLaw::ArcLength, TimeLaw::Optimal)
}

/// Returns the time laws with which an interpolation may need few knots.
fn sparse_laws(path: &ReducedPath, kind: Interpolation) -> Vec<TimeLaw> {
    let leads = 0..path.waypoints()[0].angles.len().min(MAX_LEADS);
    match kind {
        Interpolation::HalfAngle => leads.map(TimeLaw::HalfAngle).collect(),
        Interpolation::Homogeneous => {
            let angles = leads.clone().map(TimeLaw::Angle);
            angles.chain(leads.map(TimeLaw::HalfAngle)).collect()
        }
        Interpolation::Linear | Interpolation::Hermite => vec![TimeLaw::ArcLength],
    }
}

/// Number of knots that is few enough to try no other interpolation.
const FEW_KNOTS: usize = 12;
/// Factor by which homogeneous half angles have to reduce the number of knots.
const HOMOGENEOUS_SAVING: usize = 4;
/// Largest number of intervals between two waypoints on which the fastest motion is computed.
const MAX_INTERVALS: usize = 8;
/// Number of group angles between two waypoints above which there are fewer intervals.
const MAX_GRID_ANGLES: usize = 4096;
/// Largest number of groups that are tried as the one to whose angle or half angle time is proportional.
const MAX_LEADS: usize = 8;
