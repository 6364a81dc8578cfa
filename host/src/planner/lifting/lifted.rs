//! The motion of the whole sheet that a path is lifted to, as far as it leads, with what is known of it.

use foldpath_core::Interpolation;

use crate::motion::Knot;
use crate::planner::following::follow::Waypoint;
use crate::planner::knots::KnotSequence;
use crate::planner::plan::{Certificate, CrossingSearch, Outcome, SheetErrors};
use crate::planner::reason::{Note, Reason, TimeoutAt, Undecided};
use crate::planner::vectors::max_difference;

/// A motion of the whole sheet, the answer so far, and measurements.
#[derive(Clone, Debug, Default)]
pub(crate) struct Lifted {
    pub(crate) outcome: Outcome,
    /// Reason why the outcome is not `Planned`.
    pub(crate) reason: Option<Reason>,
    /// Fraction of the way to the goal that the motion goes.
    pub(crate) reached: f64,
    pub(crate) knots: KnotSequence,
    /// Number of waypoints of the path.
    pub(crate) waypoints: usize,
    pub(crate) certificate: Option<Certificate>,
    pub(crate) errors: SheetErrors,
    /// Largest difference of a fold angle at the end from the goal, radians, if the motion ends before its path does.
    pub(crate) goal_error: Option<f64>,
    pub(crate) crossings: CrossingSearch,
    pub(crate) notes: Vec<Note>,
    pub(crate) undecided: Vec<Undecided>,
    /// Reason why the motion ends before its path does, if it is not proved beyond.
    pub(crate) proof_stops: Option<Reason>,
    pub(crate) recourse: Recourse,
}

/// Reaction that is possible if faces cross on a motion.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(crate) enum Recourse {
    /// Nothing: the motion ends where faces cross.
    #[default]
    Nothing,
    /// The path may end a little before its goal.
    EndEarlier,
    /// The motion, placed for this fraction of the bound, may be placed nearer to the path: if layers touch, a motion that
    /// is as far off the path as the bound allows may cross.
    GoNearer(f64),
}

impl Lifted {
    /// Ends the motion, as a stage does not lead on.
    pub(crate) fn end(&mut self, outcome: Outcome, reason: Reason) {
        (self.outcome, self.reason) = (outcome, Some(reason));
    }

    /// Ends the motion, as time ran out.
    pub(crate) fn end_late(&mut self, at: TimeoutAt) {
        if !self.knots.knots.is_empty() {
            self.undecided.push(Undecided::OutOfTime(at));
        }
        self.end(Outcome::Timeout, Reason::OutOfTime(at));
    }

    /// Ends the motion as time ran out before it was judged: it goes through the waypoints that were found, as far apart
    /// in time as the largest speed of the hinges (radians per second) requires. The errors of the sheet are not measured.
    pub(crate) fn end_unjudged(&mut self, waypoints: &[Waypoint], max_speed: f64, at: TimeoutAt) {
        self.knots = KnotSequence::default();
        // A single waypoint is the flat sheet, and no path.
        if waypoints.len() > 1 {
            self.knots = unmeasured(waypoints, max_speed);
        }
        self.end_late(at);
    }

    /// Ends a motion that leads as far as another one is proved there, if that one is not proved beyond.
    pub(crate) fn stop_at(&mut self, proof_stops: Option<Reason>) {
        if self.outcome == Outcome::Planned && proof_stops.is_some() {
            (self.outcome, self.reason) = (Outcome::Partial, proof_stops);
        }
    }

    /// Returns `true` if the motion can be placed nearer to its path, for at least `least` of the bound.
    pub(crate) fn goes_nearer(&self, least: f64) -> bool {
        matches!(self.recourse, Recourse::GoNearer(fraction) if fraction > least)
    }

    /// Returns how far the sheet may be torn, in median edges: the deformation that is proved or the gap that was measured.
    pub(crate) fn tear(&self) -> f64 {
        let certified = self.certificate.map_or(0.0, |c| c.deformation);
        certified.max(self.errors.rigidity.gap)
    }

    /// Returns the bound on the closure residuals over the whole motion, if it is known.
    pub(crate) fn certified_closure(&self) -> Option<f64> {
        self.certificate?.closure
    }
}

/// Returns the waypoints as knots of a linear motion with hinges no faster than `max_speed`, radians per second.
fn unmeasured(waypoints: &[Waypoint], max_speed: f64) -> KnotSequence {
    let mut time = 0.0;
    let mut before: Option<&[f64]> = None;
    let knots = waypoints.iter().map(|waypoint| {
        let turned = before.map_or(0.0, |before| max_difference(before, &waypoint.angles));
        time += turned / max_speed;
        before = Some(&waypoint.angles);
        Knot {
            time,
            angles: waypoint.angles.clone(),
            rates: vec![0.0; waypoint.angles.len()],
            ..Knot::default()
        }
    });
    let phases = (0..waypoints.len()).filter(|&index| waypoints[index].ends_phase);
    KnotSequence {
        interpolation: Interpolation::Linear,
        knots: knots.collect(),
        phases: phases.collect(),
        ..KnotSequence::default()
    }
}
