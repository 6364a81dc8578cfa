//! Foresees from the flat sheet alone whether a pattern folds.

use super::cause::{Cause, CauseKind, at_vertices, of_lock, of_loop};
use super::certificate::{Lock, Locks, MAX_CREASES, cannot_leave};
use super::flat_cone::direction_errors;
use super::locked_loop::{OTHER_RATIO, locked_loops};
use crate::pattern::{ClosureSite, CreasePattern, Digits, EdgeId, Precision};
use crate::planner::Goal;
use crate::planner::following::mobility::{FirstStep, Mobility, first_step};
use crate::planner::following::reduction::CLOSED;
use crate::planner::reason::ProofOrder;
use crate::progress::Watch;
use crate::straighten::{Straightened, straightened};
use crate::symmetry::{CreaseGroups, ReducedStars, closure_of};

/// Expectation of whether a pattern folds to its goal. Only a plan tells for sure.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Foldability {
    /// It leaves flat with all its creases, its goal closes, and nothing is known to be in the way.
    Likely,
    /// Some of that does not hold, or is not known.
    Perhaps,
    /// It is proved that no motion leaves flat along the letters.
    No,
    /// The sheet is too large, the time was up, or nothing says which way to fold.
    Unknown,
}

impl Foldability {
    /// Returns the name for programs.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::Likely => "likely",
            Self::Perhaps => "perhaps",
            Self::No => "no",
            Self::Unknown => "unknown",
        }
    }
}

/// Statements on a pattern that need no plan.
#[derive(Clone, Debug, PartialEq)]
pub struct Forecast {
    /// Expectation of whether it folds.
    pub foldability: Foldability,
    /// Causes that keep the sheet or a part of it from folding.
    pub causes: Vec<Cause>,
    /// The creases that are proved not to turn in a first step from flat, each turning its way: along its letter, or
    /// else towards its goal. Coordinates may be off by their last digit. Empty if the sheet is too large.
    pub locked: Vec<EdgeId>,
    /// A small step from flat towards the goal.
    pub step: FirstStep,
    /// Number of independent motions at the goal to first order; `None` if the goal does not name every crease, does not
    /// close or is too large.
    pub goal_motions: Option<usize>,
    /// Largest closure residual of the goal's angles, if they name every crease.
    pub goal_residual: Option<f64>,
    /// The moves that straightened the pattern, if these statements are on the straightened pattern; `None` if they are on the
    /// pattern as it is drawn.
    pub straightened: Option<Straightened>,
}

/// Foresees whether a pattern folds to its own goal, or else along its letters. If little is to be hoped for of the sheet
/// as it is drawn, and the reader allowed it to be straightened, the forecast is that of the straightened one.
///
/// The call ends soon after the deadline of `watch`. Cost: below a second, whatever the size of the sheet.
#[must_use]
pub fn forecast(pattern: &CreasePattern, groups: &CreaseGroups, watch: Watch<'_>) -> Forecast {
    let written = pattern.precision();
    let as_drawn = forecast_as_drawn(pattern, groups, written, watch);
    let is_doubtful = matches!(as_drawn.foldability, Foldability::Perhaps | Foldability::No);
    let within = pattern.straightens_within().filter(|_| is_doubtful);
    let straight = within.and_then(|within| straightened(pattern, within, watch));
    let Some((straight, how)) = straight else {
        return as_drawn;
    };
    let groups = CreaseGroups::find_until(&straight, watch);
    let mut forecast = forecast_as_drawn(&straight, &groups, written, watch);
    forecast.straightened = Some(how);
    let is_better = match forecast.foldability {
        Foldability::Likely => true,
        Foldability::Perhaps => as_drawn.foldability == Foldability::No,
        Foldability::No | Foldability::Unknown => false,
    };
    if is_better { forecast } else { as_drawn }
}

/// Foresees whether a pattern folds as it is drawn, to a goal that is off by no more than numbers `written` so explain: moves
/// that straightened the pattern explain first steps, but no goal that they spoil.
fn forecast_as_drawn(
    pattern: &CreasePattern,
    groups: &CreaseGroups,
    written: Precision,
    watch: Watch<'_>,
) -> Forecast {
    let goal = Goal::of_pattern(pattern).ok();
    let creases = || pattern.creases().iter().map(|&id| pattern.edge(id));
    let letters: Vec<f64> = creases().map(|edge| edge.letter.sign()).collect();
    let asked: Vec<f64> = match &goal {
        Some(goal) => {
            let asked = goal.fold_angles.iter().zip(&letters);
            asked
                .map(|(angle, letter)| angle.unwrap_or(*letter))
                .collect()
        }
        None => letters.clone(),
    };
    // The way in which each crease turns: its letter says more than its goal angle, which may be 0.
    let signs = letters.iter().zip(&asked).map(|(letter, asked)| {
        let said = [letter, asked].into_iter().find(|sign| sign.abs() > 0.0);
        said.map_or(0.0, |sign| sign.signum())
    });
    let ways: Vec<f64> = signs.collect();
    let mut forecast = Forecast {
        foldability: Foldability::Unknown,
        causes: at_vertices(pattern, &ways, goal.as_ref()),
        locked: Vec::new(),
        step: FirstStep::Unknown,
        goal_motions: None,
        goal_residual: None,
        straightened: None,
    };
    let loops = locked_loops(pattern, &letters, &direction_errors(pattern), OTHER_RATIO);
    let loops = loops.iter().map(|locked| of_loop(pattern, locked));
    forecast.causes.extend(loops);
    let Some(goal) = goal.filter(|_| !watch.is_over()) else {
        return forecast;
    };
    let rounding = explained_closure(pattern, pattern.precision().length, Digits::Exact);
    forecast.step = first_step(pattern, groups, &goal, rounding, watch);
    let all_turn = matches!(forecast.step, FirstStep::Leaves { unturned: 0, .. })
        && ways.iter().all(|way| way.abs() > 0.0);
    let (mut judged, mut rigid) = (false, false);
    if !all_turn && !watch.is_over() && letters.len() <= MAX_CREASES {
        let moves: Vec<bool> = asked.iter().map(|asked| asked.abs() > 0.0).collect();
        judged = true;
        rigid = forecast.add_locks(pattern, &ways, &letters, &moves);
    }
    forecast.goal_residual = closure_of(pattern, &goal.fold_angles);
    let is_within = |most: f64| forecast.goal_residual.is_some_and(|it| it <= most);
    let explained = explained_closure(pattern, written.length, written.angle);
    let nearly_closes = is_within(CLOSED + explained);
    if is_within(CLOSED) && !watch.is_over() {
        let angles: Vec<f64> = goal.fold_angles.iter().flatten().copied().collect();
        let motions = Mobility::at(&ReducedStars::of_creases(pattern), &angles);
        forecast.goal_motions = motions.map(|motions| motions.drivers.len());
    }
    forecast.foldability = match forecast.step {
        _ if rigid => Foldability::No,
        FirstStep::Unknown if !judged => Foldability::Unknown,
        FirstStep::Leaves { unturned: 0, .. } if nearly_closes && forecast.causes.is_empty() => {
            Foldability::Likely
        }
        _ => Foldability::Perhaps,
    };
    forecast
}

/// Returns the largest closure residual that the last digits of coordinates and fold angles make of angles that close:
/// the turn about each crease round a vertex or hole may be wrong by the errors of its ends, and by that of its own angle.
fn explained_closure(pattern: &CreasePattern, length: Digits, angle: Digits) -> f64 {
    // Numbers have no more digits than a double.
    let coordinates = pattern.vertices().iter().map(|point| point.amax());
    let unit = length.unit() + f64::EPSILON * coordinates.fold(0.0, f64::max);
    let error = |edge: EdgeId| 4.0 * unit / pattern.length(pattern.edge(edge).ends) + angle.unit();
    let vertices = pattern.real_vertices().map(|vertex| {
        let star = pattern.stars()[vertex.index()].iter();
        star.map(|&edge| error(edge)).sum::<f64>()
    });
    let holes = pattern.holes().iter();
    let holes = holes.map(|way| way.iter().map(|passage| error(passage.edge)).sum::<f64>());
    vertices.chain(holes).fold(0.0, f64::max)
}

impl Forecast {
    /// Returns the hinges whose angles determine those of all others in a small step from flat, as long as crease groups
    /// keep together if [`flat_motions`](Self::flat_motions) is `None`. Empty if they are not known.
    #[must_use]
    pub fn drivers(&self, pattern: &CreasePattern, groups: &CreaseGroups) -> Vec<EdgeId> {
        let FirstStep::Leaves {
            symmetric, single, ..
        } = &self.step
        else {
            return Vec::new();
        };
        match (single, symmetric) {
            (Some(single), _) => {
                let drivers = single.drivers.iter();
                drivers.map(|&crease| pattern.creases()[crease]).collect()
            }
            (None, Some(symmetric)) => {
                let members = groups.memberships().iter();
                let drivers = symmetric.drivers.iter();
                let first = |&group: &usize| {
                    members
                        .clone()
                        .position(|member| member.group.index() == group)
                };
                let first = drivers.filter_map(first);
                first.map(|crease| pattern.creases()[crease]).collect()
            }
            (None, None) => Vec::new(),
        }
    }

    /// Returns the number of independent motions a small step from flat along the letters, if it is known.
    #[must_use]
    pub fn flat_motions(&self) -> Option<usize> {
        match &self.step {
            FirstStep::Leaves { single, .. } => {
                single.as_ref().map(|motions| motions.drivers.len())
            }
            _ => None,
        }
    }

    /// Finds the locked creases and their causes. Returns `true` if it is proved that none of the creases that are to
    /// move can leave flat.
    fn add_locks(
        &mut self,
        pattern: &CreasePattern,
        ways: &[f64],
        letters: &[f64],
        moves: &[bool],
    ) -> bool {
        let Some(locks) = Locks::find(pattern, ways) else {
            return false;
        };
        // Proving that nothing moves is worth its time only if every crease that is to move is locked.
        let mut all = locks.locked.iter().zip(moves);
        let proof = if all.all(|(locked, moves)| *locked || !moves) {
            cannot_leave(pattern, letters, moves)
        } else {
            None
        };
        let locked = locks.locked.iter().zip(moves).zip(pattern.creases());
        let locked = locked.filter(|((locked, moves), _)| **locked || **moves && proof.is_some());
        self.locked = locked.map(|(_, &edge)| edge).collect();
        let (proofs, kind) = match &proof {
            Some(proof) => (proof, CauseKind::EmptyCone),
            None => (&locks.proofs, CauseKind::LockedPart),
        };
        let at_vertices = self.causes.clone();
        let is_explained = |cause: &Cause| {
            let mut known = at_vertices.iter().filter(|known| !known.edges.is_empty());
            cause.kind != CauseKind::EmptyCone
                && known.any(|known| cause.vertices.contains(&known.vertices[0]))
        };
        let causes = proofs.iter().map(|lock| of_lock(pattern, lock, kind));
        let new: Vec<Cause> = causes.filter(|cause| !is_explained(cause)).collect();
        // What locks creases comes before what shows up only when folded flat.
        let is_lock = |cause: &Cause| !cause.edges.is_empty();
        let place = self
            .causes
            .iter()
            .take_while(|cause| is_lock(cause))
            .count();
        self.causes.splice(place..place, new);
        if proof.is_some() && self.causes.is_empty() {
            // All creases are without sign, and independent of each other.
            let sites = pattern
                .real_vertices()
                .take(1)
                .map(ClosureSite::Vertex)
                .collect();
            let creases = (0..moves.len()).filter(|&crease| moves[crease]).collect();
            let order = ProofOrder::First;
            let lock = Lock {
                creases,
                sites,
                order,
            };
            self.causes.push(of_lock(pattern, &lock, kind));
        }
        proof.is_some()
    }
}
