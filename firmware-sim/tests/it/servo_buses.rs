//! Servos on buses in virtual time, byte by byte, and the life of their ports: a bus of 12, as the port to embassy has, and
//! four of 32, as the example `servo_buses` has.

use core::f32::consts::PI;
use std::collections::VecDeque;

use foldpath_controller::Power;
use foldpath_controller::servo_bus::{Buses, packets};
use foldpath_core::GroupLimits;
use foldpath_core::follower::{Measurement, Target};

use crate::port::{Rig, lives};

/// Bits a second on a bus.
const BAUD: u32 = 1_000_000;
/// Most that a servo turns in a millisecond, radians.
const TURN: f32 = 4e-3;
/// One answer in so many is lost.
const LOST: usize = 50;

#[derive(Clone, Copy, Default)]
struct Servo {
    holds: bool,
    goal: u16,
    angle: f32,
}

/// The servos of a bus, and what they have said.
struct Line<const N: usize> {
    servos: [Servo; N],
    /// Bytes of answers, and the time when each has come, microseconds.
    answers: VecDeque<(u64, u8)>,
    questions: usize,
}

impl<const N: usize> Line<N> {
    /// Takes a packet whose last byte has come at this time, microseconds.
    fn hear(&mut self, packet: &[u8], at: u64) {
        let [
            0xff,
            0xff,
            to,
            count,
            instruction,
            address,
            size,
            values @ ..,
            sum,
        ] = packet
        else {
            panic!("{packet:?}");
        };
        let (count, size) = (usize::from(*count), usize::from(*size));
        let check = |bytes: &[u8]| {
            !bytes
                .iter()
                .fold(0, |sum: u8, byte| sum.wrapping_add(*byte))
        };
        assert_eq!(
            (count, *sum),
            (packet.len() - 4, check(&packet[2..packet.len() - 1]))
        );
        if *instruction == 2 {
            assert_eq!((*address, size), (packets::POSITION, 2));
            let servo = &self.servos[usize::from(*to) - 1];
            let [low, high] = packets::steps(servo.angle).to_le_bytes();
            self.questions += 1;
            if !self.questions.is_multiple_of(LOST) {
                let body = [*to, 4, 0, low, high];
                let answer = [&[0xff, 0xff], &body[..], &[check(&body)]].concat();
                let times = (at + 50..).step_by(10);
                self.answers.extend(times.zip(answer));
            }
            return;
        }
        for value in values.chunks(1 + size) {
            let servo = &mut self.servos[usize::from(value[0]) - 1];
            match *address {
                packets::TORQUE => servo.holds = value[1] == 1,
                packets::GOAL => servo.goal = u16::from_le_bytes([value[1], value[2]]),
                _ => panic!("{address}"),
            }
        }
    }
}

struct Simulated<const BUSES: usize, const N: usize> {
    buses: Buses<BUSES, N>,
    lines: [Line<N>; BUSES],
    blocked: Option<usize>,
}

impl<const BUSES: usize, const N: usize> Simulated<BUSES, N> {
    fn new() -> Self {
        Self {
            buses: Buses::default(),
            lines: core::array::from_fn(|_| Line {
                servos: [Servo::default(); N],
                answers: VecDeque::new(),
                questions: 0,
            }),
            blocked: None,
        }
    }

    fn servos(&mut self) -> impl Iterator<Item = &mut Servo> {
        self.lines.iter_mut().flat_map(|line| &mut line.servos)
    }
}

impl<const BUSES: usize, const N: usize> Rig for Simulated<BUSES, N> {
    const LIMITS: GroupLimits = GroupLimits {
        lower: -PI * 5.0 / 6.0,
        upper: PI * 5.0 / 6.0,
        speed: 4.0,
        acceleration: f32::INFINITY,
    };
    /// A step of a servo.
    const ERROR: f32 = PI / 2048.0;

    fn power(&mut self, power: Power) {
        self.buses.switch_to(power);
    }

    fn drive(
        &mut self,
        hinge: u32,
        target: Option<Target<f32>>,
        now: u64,
    ) -> Option<Measurement<f32>> {
        self.buses.drive(hinge, target, now)
    }

    fn commit(&mut self, now: u64) {
        for (bus, line) in self.buses.iter_mut().zip(&mut self.lines) {
            let come = line.answers.iter().take_while(|(at, _)| *at <= now).count();
            let incoming: Vec<u8> = line.answers.drain(..come).map(|(_, byte)| byte).collect();
            let mut at = now;
            bus.exchange(now, BAUD, incoming.into_iter(), |packet| {
                at += 10 * packet.len() as u64;
                line.hear(packet, at);
            });
            // Nothing else is sent before the line is free again.
            assert!(at < now + 2000);
        }
        let blocked = self.blocked;
        for (hinge, servo) in self.servos().enumerate() {
            if servo.holds && Some(hinge) != blocked {
                let way = packets::angle(servo.goal) - servo.angle;
                servo.angle += way.clamp(-TURN, TURN);
            }
        }
    }

    fn angles(&self) -> Vec<f32> {
        let servos = self.lines.iter().flat_map(|line| &line.servos);
        servos.map(|servo| servo.angle).collect()
    }

    fn block(&mut self, hinge: Option<usize>) {
        self.blocked = hinge;
    }

    fn turn(&mut self, angle: f32) -> bool {
        let free = self.servos().all(|servo| !servo.holds);
        if free {
            self.servos().for_each(|servo| servo.angle = angle);
        }
        free
    }
}

#[test]
fn twelve_servos_on_a_bus_go_through_their_life() {
    lives::<_, 12>(Simulated::<1, 12>::new());
}

#[test]
fn four_buses_of_32_servos_go_through_their_life() {
    lives::<_, 128>(Simulated::<4, 32>::new());
}
