//! The servos between the controller's ticks and the tasks of the bus.

use foldpath_controller::{Hold, Power};
use foldpath_core::follower::{Measurement, Target};

use crate::HINGES;
use crate::packets::{self, GOAL, Packet, TORQUE};

/// Questions in a row without an answer after which a servo counts as gone: a fifth of a second for all servos.
const GONE: u8 = 16;

/// Goals, powers and newest positions of all servos.
#[derive(Clone, Copy, Debug, Default)]
pub struct Servos {
    goals: [Option<u16>; HINGES],
    holds: [Hold; HINGES],
    /// `power` tells the drives to hold or to rest; `told` is `true` if the bus was told last to hold.
    power: Power,
    told: Option<bool>,
    seen: [Seen; HINGES],
}

/// The newest answer of a servo.
#[derive(Clone, Copy, Debug, Default)]
struct Seen {
    /// Position that was not yet passed on, and the time of its question, microseconds. A position of `None` tells of an
    /// error.
    news: Option<(Option<u16>, u64)>,
    /// Angle of the newest position, radians.
    angle: Option<f32>,
    missed: u8,
}

/// Returns the number of the servo of a hinge on the bus: from 1 in the pattern's order.
#[must_use]
pub fn number(hinge: usize) -> u8 {
    u8::try_from(hinge + 1).unwrap_or(u8::MAX)
}

impl Servos {
    /// Switches the drives on or off with the next packet.
    pub fn switch_to(&mut self, power: Power) {
        self.power = power;
    }

    /// Sets the target of a hinge, and returns what was heard of it since the last call, at `now`, microseconds.
    pub fn drive(
        &mut self,
        hinge: u32,
        target: Option<Target<f32>>,
        now: u64,
    ) -> Option<Measurement<f32>> {
        let hinge = usize::try_from(hinge).ok()?;
        let seen = self.seen.get_mut(hinge)?;
        let goal = self.holds.get_mut(hinge)?;
        let goal = goal.command(self.power, target, seen.angle);
        *self.goals.get_mut(hinge)? = goal.map(packets::steps);
        let (steps, at) = seen.news.take()?;
        Some(Measurement {
            angle: steps.map_or(f32::NAN, packets::angle),
            age: u32::try_from(now.saturating_sub(at)).unwrap_or(u32::MAX),
        })
    }

    /// Returns the next packet for all servos, and `true` if another one follows it in this tick: the drives are switched
    /// on behind the first goals, so that no servo turns to an old one.
    pub fn packet(&mut self) -> Option<(Packet, bool)> {
        let goals = (0..).zip(self.goals);
        let goals = goals.filter_map(|(hinge, goal)| Some((number(hinge), goal?.to_le_bytes())));
        let switches = self.told != Some(self.power == Power::Hold);
        let some = self.goals.iter().any(Option::is_some);
        match (some, switches) {
            (true, _) => Some((Packet::sync_write(GOAL, goals), switches)),
            (false, true) => Some((self.switch(), false)),
            (false, false) => None,
        }
    }

    /// Returns the packet that switches the drives on or off.
    pub fn switch(&mut self) -> Packet {
        let holds = self.power == Power::Hold;
        self.told = Some(holds);
        let on = [u8::from(holds)];
        Packet::sync_write(TORQUE, (0..HINGES).map(|hinge| (number(hinge), on)))
    }

    /// Notes the answer of a servo to a question that was asked at this time, microseconds.
    pub fn answered(&mut self, hinge: usize, steps: Option<u16>, at: u64) {
        if let Some(seen) = self.seen.get_mut(hinge) {
            seen.news = Some((steps, at));
            seen.angle = steps.map(packets::angle);
            seen.missed = 0;
        }
    }

    /// Notes that a servo has not answered. One that is gone is a sensor that has failed, which holds the motion.
    pub fn missed(&mut self, hinge: usize, at: u64) {
        if let Some(seen) = self.seen.get_mut(hinge) {
            seen.missed = seen.missed.saturating_add(1);
            if seen.missed >= GONE {
                seen.news = Some((None, at));
            }
        }
    }
}

#[cfg(test)]
#[allow(
    clippy::unwrap_used,
    clippy::indexing_slicing,
    reason = "a test may panic"
)]
mod tests {
    use super::*;

    #[test]
    fn drives_are_switched_on_behind_their_first_goals() {
        let mut servos = Servos::default();
        // Off, once.
        let (off, more) = servos.packet().unwrap();
        assert_eq!((off.bytes()[5], off.bytes()[8], more), (TORQUE, 0, false));
        assert!(servos.packet().is_none());
        servos.switch_to(Power::Hold);
        let target = Target {
            angle: 0.5,
            rate: 0.0,
        };
        for hinge in 0..12 {
            assert_eq!(servos.drive(hinge, Some(target), 0), None);
        }
        let (goals, more) = servos.packet().unwrap();
        assert_eq!((goals.bytes()[5], more), (GOAL, true));
        assert_eq!(goals.bytes()[7..10], [1, 0x46, 9]);
        let on = servos.switch();
        assert_eq!((on.bytes()[5], on.bytes()[8]), (TORQUE, 1));
        assert!(!servos.packet().unwrap().1);
        // Nothing is commanded any more: a servo goes to where it was measured, and not back to its goal.
        servos.answered(0, Some(2048), 0);
        servos.drive(0, None, 0);
        let goals = servos.packet().unwrap().0;
        assert_eq!(goals.bytes()[7..13], [1, 0, 8, 2, 0x46, 9]);
    }

    #[test]
    fn a_position_is_passed_on_once_with_its_age() {
        let mut servos = Servos::default();
        servos.answered(3, Some(2048), 1000);
        let told = servos.drive(3, None, 1700).unwrap();
        assert_eq!((told.angle.to_bits(), told.age), (0, 700));
        assert_eq!(servos.drive(3, None, 2700), None);
        servos.answered(3, None, 3000);
        assert!(servos.drive(3, None, 3000).unwrap().angle.is_nan());
    }

    #[test]
    fn a_servo_that_misses_many_questions_is_gone() {
        let mut servos = Servos::default();
        for _ in 1..GONE {
            servos.missed(0, 5);
            assert_eq!(servos.drive(0, None, 6), None);
        }
        servos.missed(0, 5);
        assert!(servos.drive(0, None, 6).unwrap().angle.is_nan());
        servos.answered(0, Some(2048), 7);
        servos.missed(0, 8);
        assert!(!servos.drive(0, None, 9).unwrap().angle.is_nan());
    }
}
