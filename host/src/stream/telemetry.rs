//! Telemetry: what a controller reports of its motion.

use foldpath_core::follower::{FollowerPosition, State};

use super::StreamPath;

/// Commanded state at a moment, as the controller reported it.
#[derive(Clone, Debug, PartialEq)]
pub struct Telemetry {
    /// Microseconds on the controller's clock.
    pub time: u64,
    /// State of the follower.
    pub state: State,
    /// Rate of the path clock: seconds of the path in a second.
    pub rate: f32,
    /// Position on the path.
    pub place: FollowerPosition<f32>,
    /// Commanded angle of each group, radians.
    pub angles: Vec<f32>,
    /// Measured angles of some hinges at that moment. Those of all hinges come round and round.
    pub measured: Measured,
    /// Hinge among them that was farthest from its command.
    pub lag: Option<Lag>,
    /// Number of items that were sent again until then.
    pub retransmitted: u64,
    /// Smoothed time of a round trip on the line, microseconds.
    pub round_trip: Option<u64>,
}

/// Measured angles of hinges.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Measured {
    /// Number of the first hinge.
    pub first: usize,
    /// Angle of each hinge, radians, with the sign of the hinge itself; NaN if it was not measured.
    pub angles: Vec<f32>,
}

/// Distance of a hinge from its command of the same moment.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Lag {
    /// Number of the hinge.
    pub hinge: usize,
    /// Distance, radians.
    pub angle: f32,
}

impl Telemetry {
    /// Returns the hinge that was measured farthest from its command, if one was measured.
    pub(super) fn worst_lag(&self, path: &StreamPath) -> Option<Lag> {
        let hinges = path.hinges().iter().enumerate().skip(self.measured.first);
        let lags = hinges.zip(&self.measured.angles);
        let lags = lags.filter_map(|((hinge, membership), measured)| {
            let commanded = membership.apply(*self.angles.get(membership.group.index())?);
            let angle = (measured - commanded).abs();
            (!angle.is_nan()).then_some(Lag { hinge, angle })
        });
        lags.reduce(|a, b| if b.angle > a.angle { b } else { a })
    }
}
