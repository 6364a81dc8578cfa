//! Paths: configurations of the whole sheet with times and rates.

use foldpath_core::{Interpolation, Membership};
use nalgebra::Vector3;

use super::follow::Waypoint;

/// One stored configuration of a path, with what was measured there on the whole sheet.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Knot {
    /// Seconds since the start.
    pub time: f64,
    /// Fold angle of each group, radians.
    pub angles: Vec<f64>,
    /// Rate of each group, radians per second.
    pub rates: Vec<f64>,
    /// Folded positions of the vertices; empty if they were not kept.
    pub vertices: Vec<Vector3<f64>>,
    /// Largest closure residual of a real vertex or a hole, or twist of a hinge if that is larger.
    pub closure: f64,
    /// Largest relative change of length of an edge or virtual edge.
    pub deformation: f64,
    /// Largest gap, over the median edge.
    pub gap: f64,
}

/// A path of the whole sheet from flat to goal.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Path {
    /// For each crease its group and sign.
    pub memberships: Vec<Membership>,
    /// How the motion between knots is made.
    pub interpolation: Interpolation,
    /// The knots, in the order of time.
    pub knots: Vec<Knot>,
}

/// Knots with times, of waypoints from flat to goal: the Euclidean length of the path in group angles is
/// its parameter, so that every hinge moves smoothly, and the fastest hinge of all knots moves at
/// `max_speed` (radians per second).
pub(super) fn timed(waypoints: &[Waypoint], max_speed: f64) -> Vec<Knot> {
    let entries = waypoints.iter().flat_map(|w| &w.tangent);
    let fastest = entries.fold(0.0, |max, t| f64::max(max, t.abs()));
    let speed = if fastest > 0.0 {
        max_speed / fastest
    } else {
        max_speed
    };
    let mut knots: Vec<Knot> = Vec::with_capacity(waypoints.len());
    let mut length = 0.0;
    let mut before: Option<&Waypoint> = None;
    for waypoint in waypoints {
        length += before.map_or(0.0, |before| arc_length(before, waypoint));
        before = Some(waypoint);
        knots.push(Knot {
            time: length / speed,
            angles: waypoint.angles.clone(),
            rates: waypoint.tangent.iter().map(|t| t * speed).collect(),
            ..Knot::default()
        });
    }
    knots
}

/// Length of the path between two waypoints: that of the circular arc with their chord whose ends
/// enclose the angle of their tangents, fourth order in the chord.
fn arc_length(from: &Waypoint, to: &Waypoint) -> f64 {
    let squares = |a: &[f64], b: &[f64]| a.iter().zip(b).map(|(a, b)| (a - b).powi(2)).sum::<f64>();
    let chord = squares(&from.angles, &to.angles).sqrt();
    // The tangents have length 1: their difference is twice the sine of half the angle. At a corner, where
    // one is zero, that makes 60 degrees and 5 % more length, which a start from rest takes.
    let sine = (squares(&from.tangent, &to.tangent).sqrt() / 2.0).min(1.0);
    if sine > 0.0 {
        chord * sine.asin() / sine
    } else {
        chord
    }
}
