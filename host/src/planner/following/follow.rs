//! Path following (numerical continuation) along the closed configurations: a predictor along the motion nearest to the
//! direction of the target, with the curvature of the last step, and a corrector that closes the sheet.
//!
//! The flat sheet is singular: more motions leave it to first order than the sheet can continue. So a path is followed
//! from the goal, where the motion is known, towards flat. Only if that fails is flat left along the signs of the goal,
//! see `branch.rs`.

use crate::planner::closing::solver::ClosureSolver;
use crate::planner::reason::Stop;
use crate::planner::vectors::{cosine, max_difference, max_norm, norm, unit, way_to};
use crate::progress::Watch;

/// A configuration on the path, in group angles.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Waypoint {
    /// Group angles, radians.
    pub(crate) angles: Vec<f64>,
    /// Derivative of the angles along the path, of Euclidean length 1; zero at a corner of the path, where it has to
    /// rest.
    pub(crate) tangent: Vec<f64>,
    /// `true` if this is a goal on the way, where one phase of the motion ends and another begins.
    pub(crate) ends_phase: bool,
    /// Path length from the start, once the path is measured.
    pub(crate) arc_length: f64,
}

impl Waypoint {
    /// Makes a waypoint within a phase.
    pub(crate) fn new(angles: Vec<f64>, tangent: Vec<f64>) -> Self {
        Self {
            angles,
            tangent,
            ends_phase: false,
            arc_length: 0.0,
        }
    }

    /// Returns `true` if the motion rests here, as at a corner.
    pub(crate) fn rests(&self) -> bool {
        max_norm(&self.tangent) <= 0.0
    }

    /// Returns `true` if there has to be a knot here.
    pub(crate) fn stays(&self) -> bool {
        self.rests() || self.ends_phase
    }
}

/// Target of path following.
#[derive(Clone, Copy, Debug)]
pub(crate) enum Target<'a> {
    /// The flat sheet.
    Flat(Homeward),
    /// A closed configuration.
    Closed(&'a [f64]),
    /// The configuration nearest to the angles asked for, which need not close, as far as the motion leads. A `None` is
    /// free.
    Nearest(&'a [Option<f64>]),
}

/// Way in which hinges return to flat.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Homeward {
    /// The straightest way. A hinge that is flat stays flat.
    Straight,
    /// Hinges that are turned little move more slowly, so that all arrive together.
    Together,
}

impl Target<'_> {
    /// Returns the difference from `angles` to the target.
    fn way(&self, angles: &[f64]) -> Vec<f64> {
        match self {
            Self::Flat(_) => angles.iter().map(|a| -a).collect(),
            Self::Closed(target) => target.iter().zip(angles).map(|(t, a)| t - a).collect(),
            Self::Nearest(asked) => way_to(asked, angles),
        }
    }
}

/// Outcome of path following: waypoints in the order travelled, and the reason why they end before the target, if they
/// do.
#[derive(Clone, Debug)]
pub(crate) struct Followed {
    pub(crate) waypoints: Vec<Waypoint>,
    pub(crate) stop: Option<Stop>,
}

impl Followed {
    /// Returns the path travelled the other way.
    pub(crate) fn reversed(mut self) -> Self {
        self.waypoints.reverse();
        for waypoint in &mut self.waypoints {
            for entry in &mut waypoint.tangent {
                *entry = -*entry;
            }
        }
        self
    }
}

/// Fraction of the largest step that the predictor aims for, as the corrector adds to the step.
const STEP_AIM_RATIO: f64 = 0.95;
/// Smallest step, as a fraction of the largest.
const MIN_STEP_RATIO: f64 = 1e-4;
/// Largest move of the corrector, as a fraction of the step: more means that the path bends faster than the step.
const MAX_CORRECTION_RATIO: f64 = 0.3;
/// Cosine between the direction of the target and the motion nearest to it below which the target is out of sight: the
/// motion then goes on as it came.
const MIN_SIGHT_COSINE: f64 = 0.05;
/// Cosine between two directions in a row below which the path turns a corner: one motion ends and another begins.
const CORNER_COSINE: f64 = 0.5;
/// Steps over a bifurcation, tried in the direction in which the path came, as fractions of the largest step.
const LEAP_RATIOS: [f64; 3] = [1.0, 0.5, 0.25];
/// Length of a step that is no progress, as a fraction of the largest step.
const CREEP_RATIO: f64 = 0.01;
/// Largest number of steps in a row that are no progress.
const MAX_CREEPING_STEPS: usize = 50;
/// Number of steps without coming nearer to the target after which the motion leads elsewhere: ten turns of a hinge at
/// the largest step.
const MAX_LOST_STEPS: usize = 360;
/// Distance at which the angles asked for are reached, radians.
pub(crate) const REACHED_RAD: f64 = 1e-12;
/// Distance at which the angles asked for are reached if the motion leads no nearer, radians.
const ARRIVED_RAD: f64 = 1e-8;
/// Angle below which all hinges have the same weight, as a fraction of the largest angle.
const MIN_WEIGHT_RATIO: f64 = 1e-6;
/// Largest angle of a hinge that counts as flat, radians.
const FLAT_RAD: f64 = 1e-9;
/// Distance from its limit up to which a hinge counts as being at the limit, radians.
const AT_LIMIT_RAD: f64 = 1e-3;

/// Rules that all steps keep.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Rules<'a> {
    /// For each unknown the direction in which it may turn: -1, 1, or 0 for both. None passes through flat on the way.
    pub(crate) signs: &'a [f64],
    /// Largest change of an unknown from one waypoint to the next, radians.
    pub(crate) max_step: f64,
    /// Receives the fraction of the way that is done.
    pub(crate) watch: Watch<'a>,
}

impl Rules<'_> {
    /// Reports that the distance `left` of `whole` remains to the target.
    pub(crate) fn tell(&self, left: f64, whole: f64) {
        self.watch.part(1.0 - left / whole);
    }

    /// Returns `true` if each hinge turns in its direction at `next`, or is flat, coming from `angles`.
    pub(crate) fn allow(&self, angles: &[f64], next: &[f64]) -> bool {
        let mut triples = next.iter().zip(angles).zip(self.signs);
        triples.all(|((next, angle), sign)| {
            let way = if angle.abs() > FLAT_RAD {
                *angle
            } else {
                *sign
            };
            next * way >= 0.0 || next.abs() <= FLAT_RAD
        })
    }
}

/// Follows the motion from the closed configuration `start` to the target by the rules. `came` is the direction in
/// which the path arrived at the start, if it did.
pub(crate) fn follow(
    solver: &mut ClosureSolver<'_>,
    start: &[f64],
    came: Option<&[f64]>,
    target: Target<'_>,
    rules: Rules<'_>,
) -> Followed {
    let max_step = rules.max_step;
    let mut waypoints: Vec<Waypoint> = Vec::new();
    let mut angles = start.to_vec();
    let mut came = came.map(<[f64]>::to_vec);
    let mut last_step: Option<f64> = None;
    let mut progress = Progress::default();
    let whole = norm(&target.way(start));
    let stop = loop {
        if solver.is_late() {
            break Some(Stop::Timeout);
        }
        let way = target.way(&angles);
        let left = norm(&way);
        let there = left <= REACHED_RAD;
        rules.tell(left, whole);
        let heading = if there {
            Err(None)
        } else {
            heading(solver, &angles, &way, came.as_deref(), target).map_err(Some)
        };
        let heading = match heading {
            Ok(heading) => heading,
            Err(stop) => {
                let tangent = came.unwrap_or_else(|| vec![0.0; angles.len()]);
                waypoints.push(Waypoint::new(angles, tangent));
                break stop;
            }
        };
        let tangent = heading.direction;
        let corner = came
            .as_ref()
            .is_some_and(|came| cosine(came, &tangent) < CORNER_COSINE);
        waypoints.push(Waypoint::new(
            angles.clone(),
            if corner {
                vec![0.0; angles.len()]
            } else {
                tangent.clone()
            },
        ));
        if max_norm(&way) <= max_step
            && let Some(last) = arrive(solver, &angles, &tangent, target, rules)
        {
            waypoints.push(last);
            break None;
        }
        let bend = match (&came, last_step) {
            (Some(came), Some(length)) if !corner => bend(came, &tangent, length),
            _ => vec![0.0; angles.len()],
        };
        let room = solver.room(&angles, &tangent);
        let at_limit = room.0 * max_norm(&tangent) <= AT_LIMIT_RAD;
        let at_limit = at_limit.then(|| at_limit_of(&angles, &[room.1])).flatten();
        let most = room.0.min(heading.length);
        let most = most.min(until_flat(&angles, &tangent));
        let next = step(solver, &angles, &tangent, &bend, most, rules).or_else(|| {
            let came = came.as_deref()?;
            let flat = vec![0.0; came.len()];
            LEAP_RATIOS
                .iter()
                .find_map(|leap| step_at(solver, &angles, came, &flat, leap * max_step, rules))
        });
        match next {
            Some((next, length)) => {
                let left = norm(&target.way(&next));
                if let Target::Nearest(asked) = target
                    && left >= norm(&way)
                {
                    let last = approach(solver, angles.clone(), asked);
                    let moved = max_difference(&last, &angles);
                    if moved > REACHED_RAD && moved <= max_step {
                        waypoints.push(Waypoint::new(last, tangent));
                    }
                    break Some(at_limit.unwrap_or(Stop::Nearest));
                }
                let moved = max_difference(&next, &angles);
                if let Some(stop) = progress.ends(left, moved / max_step) {
                    break Some(stop);
                }
                angles = next;
                last_step = Some(length);
                came = Some(tangent);
            }
            None => break Some(at_limit.unwrap_or(Stop::Closure)),
        }
    };
    // The angles asked for may lie at a limit, or in a configuration where the sheet is singular.
    let stop = stop.filter(|_| match (target, waypoints.last()) {
        (Target::Nearest(asked), Some(last)) => norm(&way_to(asked, &last.angles)) > ARRIVED_RAD,
        _ => true,
    });
    Followed { waypoints, stop }
}

/// Returns the first of the held hinges that has reached its limit. A hinge that is held at flat, as it would turn
/// against its assignment, has reached no limit of its own.
fn at_limit_of(angles: &[f64], held: &[usize]) -> Option<Stop> {
    let turned = held.iter().find(|&&k| angles[k].abs() > AT_LIMIT_RAD);
    turned.map(|&unknown| Stop::Limit(unknown))
}

/// Count of the steps, and of those that lead nowhere.
#[derive(Default)]
struct Progress {
    steps: usize,
    /// Smallest distance to the target so far, and the number of steps after which it was reached.
    nearest: Option<(f64, usize)>,
    creeping: usize,
}

impl Progress {
    /// Counts a step that leaves the distance `left` to the target and has the length `part`, as a fraction of the
    /// largest step. Returns the reason to stop, if there is one.
    fn ends(&mut self, left: f64, part: f64) -> Option<Stop> {
        self.steps += 1;
        self.creeping = if part < CREEP_RATIO {
            self.creeping + 1
        } else {
            0
        };
        match self.nearest {
            Some((nearest, at)) if left >= nearest => {
                (self.steps > at + MAX_LOST_STEPS).then_some(Stop::TooLong)
            }
            _ => {
                self.nearest = Some((left, self.steps));
                None
            }
        }
        .or((self.creeping > MAX_CREEPING_STEPS).then_some(Stop::Closure))
    }
}

/// Direction of a motion, and how far to go.
struct Heading {
    /// Direction, of unit length.
    direction: Vec<f64>,
    /// Distance along the direction at which the target is nearest; infinite if that does not matter.
    length: f64,
}

/// Returns the infinitesimal motion at `angles` nearest to the direction of the target.
fn heading(
    solver: &mut ClosureSolver<'_>,
    angles: &[f64],
    way: &[f64],
    came: Option<&[f64]>,
    target: Target<'_>,
) -> Result<Heading, Stop> {
    if let Target::Nearest(asked) = target {
        return towards(solver, angles, asked);
    }
    let mut direction = way.to_vec();
    let together = matches!(target, Target::Flat(Homeward::Together));
    let weights = together.then(|| {
        let least = MIN_WEIGHT_RATIO * max_norm(angles);
        let weights = angles.iter().map(|angle| angle.abs().max(least).sqrt());
        weights.collect::<Vec<f64>>()
    });
    let held = solver.project_weighted(angles, &mut direction, weights.as_deref());
    let mut held = held.ok_or(Stop::Singular)?;
    if norm(&direction) < MIN_SIGHT_COSINE * norm(way) {
        direction = match came {
            Some(came) => {
                let mut on = came.to_vec();
                held = solver
                    .project_on_motions(angles, &mut on)
                    .ok_or(Stop::Singular)?;
                on
            }
            None => vec![0.0; way.len()],
        };
        if norm(&direction) < MIN_SIGHT_COSINE {
            return Err(at_limit_of(angles, &held).unwrap_or(Stop::Singular));
        }
    }
    let length = norm(&direction);
    Ok(Heading {
        direction: direction.iter().map(|d| d / length).collect(),
        length: f64::INFINITY,
    })
}

/// Returns the infinitesimal motion at `angles` nearest to the direction of the angles asked for, and the distance
/// along the motion at which they are nearest.
fn towards(
    solver: &mut ClosureSolver<'_>,
    angles: &[f64],
    asked: &[Option<f64>],
) -> Result<Heading, Stop> {
    let way = way_to(asked, angles);
    let mut direction = way.clone();
    let held = solver.project_on_motions(angles, &mut direction);
    let held = held.ok_or(Stop::Singular)?;
    let length = norm(&direction);
    let pairs = direction.iter().zip(asked);
    // Square of the part of the motion that is asked for, which is small for one hinge among thousands.
    let asked_for = pairs.filter_map(|(d, asked)| asked.map(|_| (d / length).powi(2)));
    let square = asked_for.sum::<f64>();
    // The projection p of the direction w has w·p = p·p.
    if length <= f64::EPSILON || length < MIN_SIGHT_COSINE * norm(&way) * square.sqrt() {
        return Err(at_limit_of(angles, &held).unwrap_or(Stop::Nearest));
    }
    Ok(Heading {
        direction: direction.iter().map(|d| d / length).collect(),
        length: length / square,
    })
}

/// Returns the waypoint at the target, if the target is one step from `angles` in this direction.
fn arrive(
    solver: &mut ClosureSolver<'_>,
    angles: &[f64],
    direction: &[f64],
    target: Target<'_>,
    rules: Rules<'_>,
) -> Option<Waypoint> {
    match target {
        Target::Flat(_) => {
            let tangent = tangent_at_flat(solver, angles);
            Some(Waypoint::new(
                vec![0.0; angles.len()],
                tangent.iter().map(|t| -t).collect(),
            ))
        }
        Target::Closed(target) => {
            let way: Vec<f64> = target.iter().zip(angles).map(|(t, a)| t - a).collect();
            if cosine(&way, direction) < AHEAD_COSINE {
                return None;
            }
            // The direction is projected backwards, as a hinge may arrive at its limit.
            let mut back: Vec<f64> = way.iter().map(|w| -w).collect();
            solver.project_on_motions(target, &mut back)?;
            let length = norm(&back);
            (length > 0.0)
                .then(|| Waypoint::new(target.to_vec(), back.iter().map(|t| -t / length).collect()))
        }
        Target::Nearest(asked) => {
            let last = approach(solver, angles.to_vec(), asked);
            let reached = norm(&way_to(asked, &last)) <= REACHED_RAD;
            if !reached || max_difference(&last, angles) > rules.max_step {
                return None;
            }
            let mut tangent = direction.to_vec();
            solver.project_on_motions(&last, &mut tangent)?;
            let length = norm(&tangent);
            (length > MIN_SIGHT_COSINE)
                .then(|| Waypoint::new(last, tangent.iter().map(|t| t / length).collect()))
        }
    }
}

/// Cosine between the straight way to a configuration near by and the motion above which the configuration lies on that
/// motion.
const AHEAD_COSINE: f64 = 0.8;

/// Largest number of steps to the angles asked for along the closed configurations. Convergence is quadratic, at a rate
/// set by how far the motion bends over the distance, so that few steps are needed.
const MAX_APPROACH_STEPS: usize = 50;

/// Returns the closed configuration nearest to the angles asked for, as far as descent along the closed configurations
/// from `angles` finds it. No hinge turns against the angle asked of it.
pub(crate) fn approach(
    solver: &mut ClosureSolver<'_>,
    mut angles: Vec<f64>,
    asked: &[Option<f64>],
) -> Vec<f64> {
    for _ in 0..MAX_APPROACH_STEPS {
        let far = norm(&way_to(asked, &angles));
        if far <= REACHED_RAD {
            break;
        }
        let Ok(heading) = towards(solver, &angles, asked) else {
            break;
        };
        let way = heading.direction.iter().map(|d| d * heading.length);
        let mut nearer: Vec<f64> = angles.iter().zip(way).map(|(x, d)| x + d).collect();
        let closed = solver.closes(&mut nearer) && same_signs(&nearer, asked);
        if !closed || norm(&way_to(asked, &nearer)) >= far {
            break;
        }
        angles = nearer;
    }
    angles
}

/// Returns `true` if no hinge turns against the angle asked of it.
pub(crate) fn same_signs(angles: &[f64], asked: &[Option<f64>]) -> bool {
    let mut pairs = angles.iter().zip(asked);
    pairs.all(|(angle, asked)| angle * asked.unwrap_or(0.0) >= 0.0)
}

/// Returns half the change of the direction for a unit of path length, from the last step, which had this length.
fn bend(before: &[f64], here: &[f64], length: f64) -> Vec<f64> {
    let change = before.iter().zip(here);
    change
        .map(|(before, here)| (here - before) / (2.0 * length))
        .collect()
}

/// Takes one step of at most the largest length and about as long as `most`, halved until the step is good. Returns the
/// configuration and the length along the path.
fn step(
    solver: &mut ClosureSolver<'_>,
    angles: &[f64],
    direction: &[f64],
    bend: &[f64],
    most: f64,
    rules: Rules<'_>,
) -> Option<(Vec<f64>, f64)> {
    let max_step = rules.max_step;
    let mut part =
        (most * max_norm(direction) / (STEP_AIM_RATIO * max_step)).clamp(MIN_STEP_RATIO, 1.0);
    while part >= MIN_STEP_RATIO {
        let taken = step_at(solver, angles, direction, bend, part * max_step, rules);
        if taken.is_some() || solver.is_late() {
            return taken;
        }
        part /= 2.0;
    }
    None
}

/// Takes one step whose largest entry is about `size`, if the corrector closes it near the prediction.
fn step_at(
    solver: &mut ClosureSolver<'_>,
    angles: &[f64],
    direction: &[f64],
    bend: &[f64],
    size: f64,
    rules: Rules<'_>,
) -> Option<(Vec<f64>, f64)> {
    let length = STEP_AIM_RATIO * size / max_norm(direction);
    let move_by = |k: usize| length * (direction[k] + length * bend[k]);
    // A hinge that would pass through flat stops at flat, which often sets other hinges free.
    let stays = |from: f64, to: f64| if from * to < 0.0 { 0.0 } else { to };
    let predicted = (0..angles.len()).map(|k| stays(angles[k], angles[k] + move_by(k)));
    let predicted: Vec<f64> = predicted.collect();
    let mut next = predicted.clone();
    let near = solver.closes(&mut next)
        && max_difference(&next, angles) <= rules.max_step
        && max_difference(&next, &predicted) <= MAX_CORRECTION_RATIO * length
        && rules.allow(angles, &next);
    near.then_some((next, length))
}

/// Returns how far `angles` can go along `direction` until a hinge that is turned becomes flat.
fn until_flat(angles: &[f64], direction: &[f64]) -> f64 {
    let turned = angles
        .iter()
        .zip(direction)
        .filter(|(a, d)| a.abs() > FLAT_RAD && *a * *d < 0.0);
    turned.fold(f64::INFINITY, |least, (a, d)| least.min(-a / d))
}

/// Returns the direction in which the motion leaves the flat sheet, given a configuration near flat on that motion. The
/// direction is the limit of secants, as no derivative at flat distinguishes this motion from others.
///
/// The mirror image of a motion at the flat sheet is a motion, so that secants have only even powers of their length.
/// Their limit is extrapolated as in Romberg's method. Shorter secants would be rounding.
pub(crate) fn tangent_at_flat(solver: &mut ClosureSolver<'_>, near: &[f64]) -> Vec<f64> {
    let mut closed = near.to_vec();
    let mut limit: Vec<Vec<f64>> = vec![unit(near)];
    for _ in 1..MAX_SECANTS {
        let mut closer: Vec<f64> = closed.iter().map(|a| a / 4.0).collect();
        // Rounded coordinates may lead the sheet back to flat, which has no direction.
        let on = solver.closes(&mut closer) && cosine(&closer, &closed) >= 0.9;
        if !on {
            break;
        }
        let mut row = vec![unit(&closer)];
        let mut ratio = 1.0;
        for before in &limit {
            ratio *= 16.0;
            let finer = row.last().unwrap_or(before);
            let pairs = finer.iter().zip(before);
            row.push(pairs.map(|(f, b)| f + (f - b) / (ratio - 1.0)).collect());
        }
        (limit, closed) = (row, closer);
    }
    unit(limit.last().map_or(near, |limit| limit))
}

/// Number of secants from which the tangent at flat is extrapolated.
const MAX_SECANTS: usize = 4;
