//! Options of a follower, and their check.

use core::fmt;
use core::ops::Deref;

use crate::Scalar;
use crate::path_clock::ClockLimits;

/// Options of a [`Follower`](crate::follower::Follower), which takes them once they are [checked](Options::checked). Times
/// are microseconds.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Options<T> {
    /// Limits on the change of the path clock's rate. They add at most the hinge's speed times this to the acceleration
    /// of a hinge; [eight times](crate::follower::STUCK_BRAKE_RATIO) as much for the brake if a hinge is stuck.
    pub clock: ClockLimits<T>,
    /// Silence of the host after which the motion holds.
    pub silence: u32,
    /// Longest time that one tick lets pass. If ticks come later, the motion is slower than its path, and
    /// [says so](crate::follower::Reason::LateTick).
    pub longest_tick: u32,
    /// Distance between a hinge and its command above which the clock slows, radians.
    pub lag: T,
    /// Distance between a hinge and its command from which on the motion holds, radians. Braking moves the command on
    /// by up to speed / (16 · brake). The sheet may ask for less, see
    /// [`Follower::limit_lag`](crate::follower::Follower::limit_lag).
    pub most_lag: T,
    /// Time for which a hinge may lag by `most_lag` before the motion fails.
    pub stall: u32,
    /// Largest distance of a group from the beginning of a path at which the path may start, radians, if the angle was
    /// commanded before.
    pub jump: T,
    /// Largest such distance if the angle was measured, or if an approach was broken off, radians.
    pub reach: T,
    /// Largest difference between the measured angles of a group's hinges at which they are one angle, radians.
    pub spread: T,
    /// Time for which measured angles tell where the groups stand, microseconds. All hinges have to be measured within
    /// half of it.
    pub fresh: u32,
    /// Speed at which the groups approach the beginning of a path, radians per second.
    pub approach: T,
    /// Largest closure residual of a sheet that a controller takes (dimensionless). Nothing that a host asks for is commanded
    /// with more, but for bounds and rounding.
    pub closure: T,
}

const fn is_positive(number: f32) -> bool {
    number > 0.0 && number.is_finite()
}

impl Options<f32> {
    /// Largest [`closure`](Self::closure): beyond it a vertex is open by 6 degrees, and no check of closure means anything.
    pub const MOST_CLOSURE: f32 = 0.1;
    /// The default options, for constants.
    pub const DEFAULT: Self = Self {
        clock: ClockLimits {
            rise: 4.0,
            brake: 4.0,
        },
        silence: 500_000,
        longest_tick: 10_000,
        lag: 0.05,
        most_lag: 0.15,
        stall: 1_000_000,
        jump: 0.01,
        reach: 0.1,
        spread: 0.05,
        fresh: 1_000_000,
        approach: 0.1,
        closure: 1e-3,
    };

    /// Checks the options: each has to be finite and above 0, `most_lag` above `lag`, `reach` no smaller than `jump`, and
    /// `closure` at most [`MOST_CLOSURE`](Self::MOST_CLOSURE). In a constant, an option that is not sound does not compile:
    ///
    /// ```
    /// use foldpath_core::follower::{CheckedOptions, Options};
    ///
    /// const SLOW_DRIVES: CheckedOptions<f32> =
    ///     match (Options { lag: 0.1, most_lag: 0.2, ..Options::DEFAULT }).checked() {
    ///         Ok(options) => options,
    ///         Err(error) => panic!("{}", error.option),
    ///     };
    /// ```
    ///
    /// # Errors
    /// The first option that is not sound.
    pub const fn checked(self) -> Result<CheckedOptions<f32>, OptionError> {
        const POSITIVE: &str = "a finite number above 0";
        const TIME: &str = "a time above 0";
        let Self {
            lag,
            most_lag,
            jump,
            reach,
            ..
        } = self;
        let rules = [
            ("clock.rise", is_positive(self.clock.rise), POSITIVE),
            ("clock.brake", is_positive(self.clock.brake), POSITIVE),
            ("silence", self.silence > 0, TIME),
            ("longest_tick", self.longest_tick > 0, TIME),
            ("lag", is_positive(lag), POSITIVE),
            (
                "most_lag",
                most_lag > lag && most_lag.is_finite(),
                "a finite angle above lag",
            ),
            ("stall", self.stall > 0, TIME),
            ("jump", is_positive(jump), POSITIVE),
            (
                "reach",
                reach >= jump && reach.is_finite(),
                "a finite angle no smaller than jump",
            ),
            ("spread", is_positive(self.spread), POSITIVE),
            ("fresh", self.fresh > 0, TIME),
            ("approach", is_positive(self.approach), POSITIVE),
            (
                "closure",
                is_positive(self.closure) && self.closure <= Self::MOST_CLOSURE,
                "a residual above 0, at most 0.1",
            ),
        ];
        let mut rest: &[_] = &rules;
        while let [(option, is_kept, expected), behind @ ..] = rest {
            if !*is_kept {
                return Err(OptionError { option, expected });
            }
            rest = behind;
        }
        Ok(CheckedOptions(self))
    }
}

impl<T: Scalar> Default for Options<T> {
    fn default() -> Self {
        let default = Options::<f32>::DEFAULT;
        let number = |number: f32| T::lit(number.into());
        Self {
            clock: ClockLimits {
                rise: number(default.clock.rise),
                brake: number(default.clock.brake),
            },
            silence: default.silence,
            longest_tick: default.longest_tick,
            lag: number(default.lag),
            most_lag: number(default.most_lag),
            stall: default.stall,
            jump: number(default.jump),
            reach: number(default.reach),
            spread: number(default.spread),
            fresh: default.fresh,
            approach: number(default.approach),
            closure: number(default.closure),
        }
    }
}

/// Options that are sound: see [`Options::checked`].
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct CheckedOptions<T>(Options<T>);

impl<T: Scalar> Default for CheckedOptions<T> {
    fn default() -> Self {
        Self(Options::default())
    }
}

impl<T> Deref for CheckedOptions<T> {
    type Target = Options<T>;

    fn deref(&self) -> &Options<T> {
        &self.0
    }
}

/// An option that is not sound.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct OptionError {
    /// Name of the option.
    pub option: &'static str,
    /// Values that it may have.
    pub expected: &'static str,
}

impl fmt::Display for OptionError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}: expected {}", self.option, self.expected)
    }
}

impl core::error::Error for OptionError {}
