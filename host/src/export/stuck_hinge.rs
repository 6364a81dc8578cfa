//! How slow does a path have to be, so that a hinge that sticks tears the sheet no farther than a user allows?
//!
//! A hinge that sticks is known as stuck once it is farther from its command than one that follows: farther than the drive's
//! resolution and the way of its delay. The motion then brakes, and the command moves on until it rests. With the speed v of
//! the hinge, the lag at rest is at most h + v T with the lag h from which on the motion holds, and T the time between two
//! measurements, and until the controller has seen them, and half of the time of braking. A lag that is common to all
//! hinges tears nothing while the sheet moves: it counts because a hinge that sticks looks like one that follows late.

use foldpath_core::Membership;
use foldpath_core::follower::{Options, STUCK_BRAKE_RATIO};

/// Time from a measurement to the first tick that brakes, and until the rate of that tick counts, seconds.
const TICKS_S: f64 = 0.002;
/// Lag from which on the motion holds, at least, in lags of a hinge that follows: half of it slows the motion.
const MIN_HOLD_RATIO: f64 = 2.0;

/// Resolution of the drives of those who tell none, degrees: a step of 12 bits, and some play.
pub const USUAL_RESOLUTION_DEG: f64 = 0.1;

/// Properties of the drives of a sheet, of their sensors and of their controller.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Drives {
    /// Largest angle by which a hinge at rest is off its command, or measured there: step, play, error of the sensor;
    /// radians.
    pub resolution: f64,
    /// Longest time between two measurements of a hinge, seconds.
    pub period: f64,
    /// Time by which a hinge follows its command late, seconds.
    pub delay: f64,
    /// Loss of the path clock's rate in a second when a host asks to hold, as the controller's options have it.
    pub brake: f64,
}

impl Drives {
    /// The drives of those who tell none: smart servos on a bus, and the controller's usual options.
    pub const USUAL: Self = Self {
        resolution: USUAL_RESOLUTION_DEG * core::f64::consts::PI / 180.0,
        period: 0.02,
        delay: 0.02,
        brake: 4.0,
    };

    /// Returns the time for which the command of a stuck hinge moves on at its speed, seconds.
    fn blind(&self) -> f64 {
        self.period + TICKS_S + 1.0 / (2.0 * STUCK_BRAKE_RATIO * self.brake)
    }
}

impl Default for Drives {
    fn default() -> Self {
        Self::USUAL
    }
}

/// Speed of a path at which a stuck hinge costs no more than a gap.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Slowed {
    /// Factor by which the path takes longer, 1 or more.
    pub(super) stretch: f64,
    /// Distance between a hinge and its command from which on the motion has to hold, radians.
    pub(super) most_lag: f64,
}

impl Slowed {
    /// The speed of the path itself, and the lag of the controller.
    pub(super) const NOT: Self = Self {
        stretch: 1.0,
        most_lag: f64::INFINITY,
    };
}

/// Hinge whose drive is too coarse for a gap at any speed.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct TooCoarse {
    /// Number of the hinge.
    pub(super) hinge: usize,
    /// Resolution below which the gap can be kept, radians.
    pub(super) resolution: f64,
    /// Gap that can be kept above this one with the drive that there is, median edges.
    pub(super) gap: f64,
}

/// The hinges of a path, one of which may stick.
pub(super) struct StuckHinges<'a> {
    /// Gap for each radian by which a hinge alone is off, median edges, for each hinge.
    pub(super) gaps: Vec<f64>,
    /// Group and sign of each hinge.
    pub(super) hinges: &'a [Membership],
    /// Largest speed of each group on the path, radians per second.
    pub(super) speeds: Vec<f64>,
    pub(super) drives: Drives,
}

impl StuckHinges<'_> {
    /// Iterates over the gap of each hinge for a radian, and the way of its command until the motion rests, radians.
    fn ways(&self) -> impl Iterator<Item = (f64, f64)> {
        let blind = self.drives.blind();
        let speed = |of: &Membership| self.speeds.get(of.group.index()).copied().unwrap_or(0.0);
        let ways = self.hinges.iter().map(move |of| speed(of) * blind);
        self.gaps.iter().copied().zip(ways)
    }

    /// Finds the speed at which a stuck hinge costs a gap of at most `bound` median edges.
    ///
    /// # Errors
    /// If a drive is too coarse.
    pub(super) fn slowed(&self, bound: f64) -> Result<Slowed, TooCoarse> {
        let rest = MIN_HOLD_RATIO * self.drives.resolution;
        let fastest = self.speeds.iter().copied().fold(0.0, f64::max);
        let late = MIN_HOLD_RATIO * fastest * self.drives.delay;
        let costly = self.gaps.iter().copied().enumerate();
        if let Some((hinge, gap)) = costly.reduce(|a, b| if b.1 > a.1 { b } else { a })
            && bound <= rest * gap
        {
            return Err(TooCoarse {
                hinge,
                resolution: bound / gap / MIN_HOLD_RATIO,
                gap: rest * gap,
            });
        }
        let slower = self
            .ways()
            .map(|(gap, way)| (way + late) / (bound / gap - rest));
        let stretch = slower.fold(1.0, f64::max);
        let left = self.ways().map(|(gap, way)| bound / gap - way / stretch);
        Ok(Slowed {
            stretch,
            most_lag: left.fold(f64::INFINITY, f64::min),
        })
    }

    /// Returns the hinge that costs the largest gap if it sticks, and this gap in median edges; `None` without hinges.
    pub(super) fn worst(&self, slowed: &Slowed) -> Option<(usize, f64)> {
        let holds = slowed.most_lag.min(Options::default().most_lag);
        let gap = |(gap, way)| gap * (holds + way / slowed.stretch);
        let gaps = self.ways().map(gap).enumerate();
        gaps.reduce(|a, b| if b.1 > a.1 { b } else { a })
    }
}
