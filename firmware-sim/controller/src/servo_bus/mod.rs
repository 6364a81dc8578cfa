//! Servos on buses: they take all goals in one packet and turn at the same time, and one at a time tells where it stands.
//!
//! [`Bus`] has the state of the servos of a bus. Its [`exchange`](Bus::exchange) is for a main loop; a board whose tasks wait
//! for the bus takes [packets](Bus::packet) and tells [answers](Bus::answered) by itself. [`Buses`] are several buses that
//! work side by side. A measurement is as old as a round over all servos of its bus.

pub mod packets;

use foldpath_core::follower::{Measurement, Target};

use crate::{Hold, Power};
use packets::{Answer, GOAL, MAX_SERVOS, POSITION, Packet, TORQUE};

/// Questions in a row without an answer after which a servo counts as gone.
const GONE: u8 = 16;
/// Longest time that a servo may take for its answer, microseconds. With its return delay set to 0 it takes less than 50.
pub const ANSWER_US: u64 = 250;

/// Goals, powers and newest positions of the `N` servos of a bus, which has nothing else on it.
#[derive(Clone, Debug)]
pub struct Bus<const N: usize> {
    goals: [Option<u16>; N],
    holds: [Hold; N],
    power: Power,
    /// `true` if a drive was switched on last (`on`), or is to be on (`wanted`); `None` if it is left as it is.
    on: [Option<bool>; N],
    wanted: [Option<bool>; N],
    seen: [Seen; N],
    /// Servo that was asked last and is not heard yet, and the time of the question, microseconds.
    question: Option<(usize, u64)>,
    /// Servo that is asked next.
    next: usize,
    /// Time when the last packets and the answer to them are over, microseconds.
    busy_until: u64,
    answer: Answer,
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

/// Returns the number of a servo on its bus: from 1.
#[must_use]
pub fn number(servo: usize) -> u8 {
    u8::try_from(servo + 1).unwrap_or(u8::MAX)
}

impl<const N: usize> Default for Bus<N> {
    fn default() -> Self {
        const {
            assert!(
                N > 0 && N <= MAX_SERVOS,
                "no packet has the goals of so many servos"
            );
        }
        Self {
            goals: [None; N],
            holds: [Hold::default(); N],
            power: Power::Rest,
            on: [None; N],
            wanted: [None; N],
            seen: [Seen::default(); N],
            question: None,
            next: 0,
            busy_until: 0,
            answer: Answer::default(),
        }
    }
}

impl<const N: usize> Bus<N> {
    /// Lets the drives hold or rest from the next packet on. A drive is switched on with its first goal, so that a hinge that is
    /// moved alone switches on no other; one that has no goal yet is left as it is, as after a reset in which it held.
    pub fn switch_to(&mut self, power: Power) {
        self.power = power;
    }

    /// Sets the target of a servo, and returns what was heard of it since the last call, at `now`, microseconds.
    pub fn drive(
        &mut self,
        servo: usize,
        target: Option<Target<f32>>,
        now: u64,
    ) -> Option<Measurement<f32>> {
        let seen = self.seen.get_mut(servo)?;
        let goal = self.holds.get_mut(servo)?;
        let goal = goal.command(self.power, target, seen.angle);
        *self.goals.get_mut(servo)? = goal.map(packets::steps);
        let (steps, at) = seen.news.take()?;
        Some(Measurement {
            angle: steps.map_or(f32::NAN, packets::angle),
            age: u32::try_from(now.saturating_sub(at)).unwrap_or(u32::MAX),
        })
    }

    /// Returns the next packet for all servos that were driven since the last one, and `true` if another one follows it in this
    /// tick: drives are switched on behind their first goals, so that no servo turns to an old one.
    pub fn packet(&mut self) -> Option<(Packet, bool)> {
        let goals = core::mem::replace(&mut self.goals, [None; N]);
        for ((wanted, on), goal) in self.wanted.iter_mut().zip(self.on).zip(goals) {
            *wanted = match (self.power, goal) {
                (Power::Rest, _) => Some(false),
                (Power::Hold, Some(_)) => Some(true),
                (Power::Hold, None) => on,
            };
        }
        let switches = self.wanted != self.on;
        let some = goals.iter().any(Option::is_some);
        let goals = (0..).zip(goals);
        let goals = goals.filter_map(|(servo, goal)| Some((number(servo), goal?.to_le_bytes())));
        match (some, switches) {
            (true, _) => Some((Packet::sync_write(GOAL, goals), switches)),
            (false, true) => Some((self.switch(), false)),
            (false, false) => None,
        }
    }

    /// Returns the packet that switches drives on or off.
    pub fn switch(&mut self) -> Packet {
        let before = core::mem::replace(&mut self.on, self.wanted);
        let servos = (0..).zip(self.wanted.iter().zip(before));
        let changed = servos.filter(|(_, (wanted, before))| *wanted != before);
        let values =
            changed.filter_map(|(servo, (on, _))| Some((number(servo), [u8::from((*on)?)])));
        Packet::sync_write(TORQUE, values)
    }

    /// Notes the answer of a servo to a question that was asked at this time, microseconds.
    pub fn answered(&mut self, servo: usize, steps: Option<u16>, at: u64) {
        if let Some(seen) = self.seen.get_mut(servo) {
            seen.news = Some((steps, at));
            seen.angle = steps.map(packets::angle);
            seen.missed = 0;
        }
    }

    /// Notes that a servo has not answered. One that is gone is a sensor that has failed, which holds the motion.
    pub fn missed(&mut self, servo: usize, at: u64) {
        if let Some(seen) = self.seen.get_mut(servo) {
            seen.missed = seen.missed.saturating_add(1);
            if seen.missed >= GONE {
                seen.news = Some((None, at));
            }
        }
    }

    /// Takes the bytes that have come from the bus, and gives `send` the packets that are due: the goals of all servos, and the
    /// question to the next one. To be called once a tick, at `now`, microseconds, for a bus with this number of bits a second.
    /// Nothing is due while the packets before or their answer are under way, so that many servos take several ticks. The bus
    /// must not give back what was sent.
    pub fn exchange(
        &mut self,
        now: u64,
        baud: u32,
        incoming: impl Iterator<Item = u8>,
        mut send: impl FnMut(&[u8]),
    ) {
        for byte in incoming {
            if let Some((from, bytes)) = self.answer.push(byte)
                && let Some((servo, at)) = self.question
                && from == number(servo)
            {
                self.question = None;
                self.answered(servo, bytes.map(u16::from_le_bytes), at);
            }
        }
        if now < self.busy_until {
            return;
        }
        if let Some((servo, at)) = self.question.take() {
            self.missed(servo, at);
        }
        let mut count = 0;
        let mut put = |bytes: &[u8]| {
            count += bytes.len() as u64;
            send(bytes);
        };
        if let Some((packet, switches)) = self.packet() {
            put(packet.bytes());
            if switches {
                put(self.switch().bytes());
            }
        }
        let servo = self.next;
        self.next = (servo + 1) % N;
        put(&packets::read(number(servo), POSITION, 2));
        // Ten bits a byte.
        let micros = |bytes: u64| (10_000_000 * bytes).div_ceil(u64::from(baud.max(1)));
        self.question = Some((servo, now + micros(count)));
        self.busy_until = now + micros(count + packets::ANSWER as u64) + ANSWER_US;
    }
}

/// Buses side by side, with `N` servos each. Hinge h has servo h modulo `N` of bus h / `N`.
#[derive(Clone, Debug)]
pub struct Buses<const BUSES: usize, const N: usize>([Bus<N>; BUSES]);

impl<const BUSES: usize, const N: usize> Default for Buses<BUSES, N> {
    fn default() -> Self {
        Self(core::array::from_fn(|_| Bus::default()))
    }
}

impl<const BUSES: usize, const N: usize> Buses<BUSES, N> {
    /// Switches all drives on or off.
    pub fn switch_to(&mut self, power: Power) {
        self.0.iter_mut().for_each(|bus| bus.switch_to(power));
    }

    /// Sets the target of a hinge, as [`Bus::drive`] does that of a servo.
    pub fn drive(
        &mut self,
        hinge: u32,
        target: Option<Target<f32>>,
        now: u64,
    ) -> Option<Measurement<f32>> {
        let hinge = usize::try_from(hinge).ok()?;
        self.0.get_mut(hinge / N)?.drive(hinge % N, target, now)
    }

    /// Iterates over the buses, each of which has to [exchange](Bus::exchange) once a tick.
    pub fn iter_mut(&mut self) -> impl Iterator<Item = &mut Bus<N>> {
        self.0.iter_mut()
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
        let mut servos = Bus::<12>::default();
        // Off, once.
        let (off, more) = servos.packet().unwrap();
        assert_eq!((off.bytes()[5], off.bytes()[8], more), (TORQUE, 0, false));
        assert!(servos.packet().is_none());
        servos.switch_to(Power::Hold);
        let target = Target {
            angle: 0.5,
            rate: 0.0,
        };
        let drive_all = |servos: &mut Bus<12>| {
            for servo in 0..12 {
                assert_eq!(servos.drive(servo, Some(target), 0), None);
            }
        };
        drive_all(&mut servos);
        let (goals, more) = servos.packet().unwrap();
        assert_eq!((goals.bytes()[5], more), (GOAL, true));
        assert_eq!(goals.bytes()[7..10], [1, 0x46, 9]);
        let on = servos.switch();
        assert_eq!((on.bytes()[5], on.bytes()[8]), (TORQUE, 1));
        drive_all(&mut servos);
        assert!(!servos.packet().unwrap().1);
        // Nothing is commanded any more: a servo goes to where it was measured, and not back to its goal.
        servos.answered(0, Some(2048), 0);
        for servo in [0, 1] {
            servos.drive(servo, None, 0);
        }
        let goals = servos.packet().unwrap().0;
        assert_eq!(goals.bytes()[7..13], [1, 0, 8, 2, 0x46, 9]);
    }

    /// Those of others may have held in a reset, or have goals from another life.
    #[test]
    fn one_servo_that_is_driven_switches_on_no_other() {
        let mut servos = Bus::<3>::default();
        servos.switch_to(Power::Hold);
        assert!(servos.packet().is_none());
        let target = Target::default();
        servos.drive(1, Some(target), 0);
        assert!(servos.packet().unwrap().1);
        assert_eq!(servos.switch().bytes()[5..9], [TORQUE, 1, 2, 1]);
        servos.switch_to(Power::Rest);
        let (off, _) = servos.packet().unwrap();
        assert_eq!(off.bytes()[5..13], [TORQUE, 1, 1, 0, 2, 0, 3, 0]);
    }

    #[test]
    fn a_position_is_passed_on_once_with_its_age() {
        let mut servos = Bus::<12>::default();
        servos.answered(3, Some(2048), 1000);
        let told = servos.drive(3, None, 1700).unwrap();
        assert_eq!((told.angle.to_bits(), told.age), (0, 700));
        assert_eq!(servos.drive(3, None, 2700), None);
        servos.answered(3, None, 3000);
        assert!(servos.drive(3, None, 3000).unwrap().angle.is_nan());
    }

    #[test]
    fn a_servo_that_misses_many_questions_is_gone() {
        let mut servos = Bus::<12>::default();
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
