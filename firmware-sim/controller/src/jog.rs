//! One hinge that is watched or moved alone, slowly, while there is no path: for the commissioning of a board.

use foldpath_core::GroupLimits;
use foldpath_core::follower::{Denial, Measurement, Options, Target};

/// Age of a measurement that there is not.
const NEVER: u32 = u32::MAX;

/// A hinge that is watched, and commanded once it was moved; or none.
///
/// It never moves from an unknown place: it begins where it was commanded before, or where it was measured, or where an
/// operator says that it stands. Once its motion has ended, for whatever reason, only another command moves it.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Jog {
    hinge: Option<u16>,
    /// Time of the last tick, microseconds.
    now: u64,
    /// Its command; `None` while it is only watched.
    target: Option<Target<f32>>,
    /// Angle where the motion ends, radians, and its speed, radians per second.
    to: f32,
    speed: f32,
    /// Newest measured angle, radians, and its age, microseconds.
    angle: f32,
    age: u32,
}

impl Jog {
    /// Watches this hinge from the tick at `now` on, microseconds, and moves it to an angle if there is one. `from` is where an operator says that it stands.
    /// Nothing has changed if this is denied.
    ///
    /// # Errors
    /// `Range` if an angle is not within the limits of the board, `Unknown` if nobody knows where the hinge stands, and
    /// `Jump` if it was measured farther than `reach` from where it is said to stand, or stands farther than `reach` beyond
    /// its limits.
    #[inline(never)]
    pub(crate) fn ask(
        &mut self,
        (hinge, from, to): (u16, Option<f32>, Option<f32>),
        now: u64,
        limits: &GroupLimits,
        options: &Options<f32>,
    ) -> Result<(), Denial> {
        let allowed = |angle: Option<f32>| angle.is_none_or(|angle| limits.allow(angle));
        if !(limits.are_sound() && allowed(from) && allowed(to)) {
            return Err(Denial::Range);
        }
        let same = self.hinge == Some(hinge);
        let mut target = self.target.filter(|_| same);
        if let Some(to) = to {
            let measured = self.measured(options.fresh).filter(|_| same);
            let commanded = target.map(|target| target.angle);
            let begin = commanded.or(measured).or(from);
            let angle = begin.ok_or(Denial::Unknown(hinge))?;
            // Each comparison is false for a NaN.
            let near = |a: f32, b: f32| (a - b).abs() <= options.reach;
            let inside = angle.max(limits.lower).min(limits.upper);
            let told = from.is_none_or(|told| near(measured.unwrap_or(told), told));
            if !(told && near(angle, inside)) {
                return Err(Denial::Jump(hinge));
            }
            target = Some(Target { angle, rate: 0.0 });
            (self.to, self.speed) = (to, options.approach.min(limits.speed));
        }
        if !same {
            self.age = NEVER;
        }
        (self.hinge, self.target, self.now) = (Some(hinge), target, now);
        Ok(())
    }

    /// Ends the motion where it is.
    pub(crate) fn end(&mut self) {
        if let Some(target) = &mut self.target {
            target.rate = 0.0;
            self.to = target.angle;
        }
    }

    /// Moves the hinge on to `now`, microseconds, or ends its motion if something `holds` it. The motion also ends if the
    /// hinge was measured at no number, or farther than `most_lag` from its command, and would move away still farther.
    #[inline(never)]
    pub(crate) fn tick(&mut self, now: u64, holds: bool, options: &Options<f32>) {
        let passed = u32::try_from(now.saturating_sub(self.now)).unwrap_or(u32::MAX);
        self.now = now;
        self.age = self.age.saturating_add(passed);
        let measured = self.measured(options.fresh);
        let Some(target) = &mut self.target else {
            return;
        };
        let way = self.to - target.angle;
        let behind = measured.unwrap_or(target.angle) - target.angle;
        // Each comparison is false for a NaN.
        let follows = behind.abs() < options.most_lag || behind * way > 0.0;
        if holds || !follows {
            return self.end();
        }
        #[allow(clippy::cast_precision_loss, reason = "rounds a time")]
        let most = self.speed * passed.min(options.longest_tick) as f32 * 1e-6;
        *target = if way.abs() <= most {
            Target {
                angle: self.to,
                rate: 0.0,
            }
        } else {
            Target {
                angle: target.angle + most.copysign(way),
                rate: self.speed.copysign(way),
            }
        };
    }

    /// Takes what the board has measured of this hinge.
    pub(crate) fn measure(&mut self, measurement: Option<Measurement<f32>>) {
        if let Some(Measurement { angle, age }) = measurement {
            (self.angle, self.age) = (angle, age);
        }
    }

    /// Returns the newest measured angle, if it is not older than `fresh` microseconds.
    pub(crate) fn measured(&self, fresh: u32) -> Option<f32> {
        let there = self.age != NEVER && self.age <= fresh;
        there.then_some(self.angle)
    }

    /// Returns the number of the hinge, if there is one.
    #[inline]
    pub(crate) fn hinge(&self) -> Option<u16> {
        self.hinge
    }

    /// Returns what the hinge is commanded; `None` while it is only watched.
    #[inline]
    pub(crate) fn target(&self) -> Option<Target<f32>> {
        self.target
    }
}
