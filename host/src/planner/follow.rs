//! Path following: from a closed configuration back to the flat sheet.
//!
//! The flat sheet is singular: more motions leave it than a sheet can go on with. So the path is
//! followed from the goal, where the motion is known, towards flat: a predictor along the motion
//! nearest to the way home, bent like the step before, and a corrector that closes the sheet.

use std::time::Instant;

use super::solver::ClosureSolver;

/// A configuration on the path, in group angles.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Waypoint {
    /// Group angles, radians.
    pub(super) angles: Vec<f64>,
    /// Derivative of the angles along the path from flat to goal, of Euclidean length 1.
    pub(super) tangent: Vec<f64>,
}

/// Why following stopped short of the flat sheet.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Stop {
    /// No motion leads on towards flat.
    Singular,
    /// The corrector finds no closed configuration within the smallest step.
    Closure,
    /// Out of time.
    Timeout,
    /// More knots than any sane path has.
    TooLong,
}

/// What was followed: waypoints from the goal towards flat, and why they end early if they do.
pub(super) struct Followed {
    pub(super) waypoints: Vec<Waypoint>,
    pub(super) stop: Option<Stop>,
}

/// Part of the largest step allowed that the predictor aims for: the corrector adds to the step.
const AIM: f64 = 0.95;
/// Smallest step, as a part of the largest.
const SMALLEST: f64 = 1e-4;
/// Part of a step that the corrector may move: more means that the path bends faster than the step.
const CORRECTION: f64 = 0.3;
/// Cosine between the way home and the motion nearest to it below which home is out of sight and
/// the motion goes on as it came.
const IN_SIGHT: f64 = 0.05;
/// Paths longer than this are going round in circles.
const MOST_WAYPOINTS: usize = 100_000;

/// Follows the motion from the closed configuration `goal` to flat, no angle changing by more than
/// `max_step` from one waypoint to the next.
pub(super) fn follow_to_flat(
    solver: &mut ClosureSolver<'_>,
    goal: &[f64],
    max_step: f64,
    deadline: Option<Instant>,
) -> Followed {
    let mut waypoints: Vec<Waypoint> = Vec::new();
    let mut angles = goal.to_vec();
    let mut last_step: Option<f64> = None;
    let stop = loop {
        if deadline.is_some_and(|deadline| Instant::now() >= deadline) {
            break Some(Stop::Timeout);
        }
        if waypoints.len() >= MOST_WAYPOINTS {
            break Some(Stop::TooLong);
        }
        let Some(tangent) = direction(solver, &angles, waypoints.last()) else {
            break Some(Stop::Singular);
        };
        waypoints.push(Waypoint {
            angles: angles.clone(),
            tangent: tangent.iter().map(|t| -t).collect(),
        });
        if max_norm(&angles) <= max_step {
            waypoints.push(Waypoint {
                angles: vec![0.0; angles.len()],
                tangent: tangent_at_flat(solver, &angles),
            });
            break None;
        }
        let bend = bend(&waypoints, last_step);
        match step(solver, &angles, &tangent, &bend, max_step) {
            Some((next, length)) => {
                angles = next;
                last_step = Some(length);
            }
            None => break Some(Stop::Closure),
        }
    };
    Followed { waypoints, stop }
}

/// Unit direction of the motion at `angles` towards flat.
fn direction(
    solver: &mut ClosureSolver<'_>,
    angles: &[f64],
    last: Option<&Waypoint>,
) -> Option<Vec<f64>> {
    let mut home: Vec<f64> = angles.iter().map(|a| -a).collect();
    let far = norm(&home);
    if !solver.project_on_motions(angles, &mut home) {
        return None;
    }
    let mut length = norm(&home);
    if length < IN_SIGHT * far {
        home = last?.tangent.iter().map(|t| -t).collect();
        if !solver.project_on_motions(angles, &mut home) {
            return None;
        }
        length = norm(&home);
        if length < IN_SIGHT {
            return None;
        }
    }
    for entry in &mut home {
        *entry /= length;
    }
    Some(home)
}

/// Half the change of the direction towards flat for a unit of path length, as the last step had it.
fn bend(waypoints: &[Waypoint], last_step: Option<f64>) -> Vec<f64> {
    let [.., before, here] = waypoints else {
        return vec![0.0; waypoints[0].angles.len()];
    };
    let length = last_step.unwrap_or(f64::INFINITY);
    let change = before.tangent.iter().zip(&here.tangent);
    change
        .map(|(before, here)| (before - here) / (2.0 * length))
        .collect()
}

/// One step of at most `max_step`, and its length along the path.
fn step(
    solver: &mut ClosureSolver<'_>,
    angles: &[f64],
    direction: &[f64],
    bend: &[f64],
    max_step: f64,
) -> Option<(Vec<f64>, f64)> {
    let longest = AIM * max_step / max_norm(direction);
    let mut length = longest;
    while length >= SMALLEST * longest {
        let move_by = |k: usize| length * (direction[k] + length * bend[k]);
        let predicted: Vec<f64> = (0..angles.len()).map(|k| angles[k] + move_by(k)).collect();
        let mut next = predicted.clone();
        let near = solver.closes(&mut next)
            && max_difference(&next, angles) <= max_step
            && max_difference(&next, &predicted) <= CORRECTION * length
            // No hinge passes through flat on its way to flat.
            && next.iter().zip(angles).all(|(n, a)| n * a >= 0.0);
        if near {
            return Some((next, length));
        }
        length /= 2.0;
    }
    None
}

/// Direction in which the motion leaves the flat sheet, given a configuration near flat on it: the
/// limit of secants, as no derivative tells one motion from the others there.
fn tangent_at_flat(solver: &mut ClosureSolver<'_>, near: &[f64]) -> Vec<f64> {
    // Quartered five times: 10 degrees become 2e-4 rad, where secant and tangent differ by 1e-7.
    let mut secant = near.to_vec();
    for _ in 0..5 {
        let mut closer: Vec<f64> = secant.iter().map(|a| a / 4.0).collect();
        if !solver.closes(&mut closer) || cosine(&closer, &secant) < 0.9 {
            break;
        }
        secant = closer;
    }
    let length = norm(&secant);
    secant.iter().map(|a| a / length).collect()
}

pub(super) fn norm(x: &[f64]) -> f64 {
    x.iter().map(|a| a * a).sum::<f64>().sqrt()
}

fn cosine(x: &[f64], y: &[f64]) -> f64 {
    x.iter().zip(y).map(|(a, b)| a * b).sum::<f64>() / (norm(x) * norm(y))
}

fn max_norm(x: &[f64]) -> f64 {
    x.iter().fold(0.0, |max, a| f64::max(max, a.abs()))
}

fn max_difference(x: &[f64], y: &[f64]) -> f64 {
    x.iter()
        .zip(y)
        .fold(0.0, |max, (a, b)| f64::max(max, (a - b).abs()))
}
