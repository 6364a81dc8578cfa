//! The board: four buses of 32 servos each on UART 1 to 4 of an MPS2 board, and the host on UART 0.
//!
//! Interrupts carry bytes between the lines and their queues. A tick hands all goals to the buses and asks one servo of each
//! where it stands; with 32 servos this takes two ticks at 1 Mbaud.
#![allow(unsafe_code, reason = "registers are reached by address")]

use core::f32::consts::PI;

use cortex_m_rt::exception;
use foldpath_controller::servo_bus::Buses;
use foldpath_controller::{Board, Condition, Fifo, retained};
use foldpath_core::follower::{Measurement, Target};
use foldpath_core::{GroupLimits, Membership};

use crate::skeleton::{INCOMING, OUTGOING, RECORDS};
use registers::{Clock, MEGAHERTZ, NVIC_ENABLE, NVIC_PEND, read, write};

#[path = "../../src/bin/mps2/registers.rs"]
mod registers;

const BUSES: usize = 4;
const SERVOS: usize = 32;
/// Bits a second on each bus.
const BAUD: u32 = 1_000_000;

/// Number of hinges, each with a servo, and room for groups, spokes of essential vertices, and setpoints.
pub(crate) const HINGES: usize = BUSES * SERVOS;
pub(crate) const GROUPS: usize = 32;
pub(crate) const SPOKES: usize = 256;
pub(crate) const KNOTS: usize = 32;

/// Limits of every hinge: 5/6 of a half turn each way, at the speed of a small servo on a bus.
pub(crate) const LIMITS: GroupLimits = GroupLimits {
    lower: -PI * 5.0 / 6.0,
    upper: PI * 5.0 / 6.0,
    speed: 4.0,
    acceleration: f32::INFINITY,
};

/// Pin of the stop line in the inputs of the first port: low while the line is released.
const INPUTS: usize = 0x4001_0000;
const STOP: u32 = 1;
/// Number of interrupts that have handlers.
const HANDLERS: usize = 22;
/// Addresses of the lines, and the numbers of their interrupts for bytes that have come; the next one is for bytes sent.
const LINES: [(usize, i16); BUSES + 1] = [
    (0x4000_4000, 0),
    (0x4000_5000, 2),
    (0x4000_6000, 4),
    (0x4000_7000, 18),
    (0x4000_9000, 20),
];
/// Two words of a source of random numbers, which a real board has to have.
const RANDOM: usize = 0x2030_0000;

/// Bytes from and for each bus.
static HEARD: [Fifo<64>; BUSES] = [const { Fifo::new() }; BUSES];
static SAID: [Fifo<512>; BUSES] = [const { Fifo::new() }; BUSES];

pub(crate) struct MyBoard {
    buses: Buses<BUSES, SERVOS>,
    clock: Clock,
}

impl MyBoard {
    /// Starts clock, watchdog and lines. Returns the board, and two numbers of its source of nonces.
    pub(crate) fn start() -> (Self, [u64; 2]) {
        let clock = Clock::start(500_000);
        for (line, interrupt) in LINES {
            let baud = if interrupt == 0 { 460_800 } else { BAUD };
            write(line + 0x10, 1_000_000 * MEGAHERTZ / baud);
            write(line + 0x8, 0b1111);
            write(NVIC_ENABLE, 0b11 << interrupt);
        }
        let draws = [RANDOM, RANDOM + 4].map(|address| read(address).into());
        let buses = Buses::default();
        (Self { buses, clock }, draws)
    }

    /// Sends bytes for the host.
    pub(crate) fn wake() {
        write(NVIC_PEND, 0b10);
    }
}

impl Board for MyBoard {
    const RECORD: usize = retained::size(GROUPS);

    fn now(&mut self) -> u64 {
        self.clock.now()
    }

    fn stop(&mut self) -> bool {
        read(INPUTS) & STOP != 0
    }

    fn power(&mut self, condition: &Condition) {
        self.buses.switch_to(condition.power);
    }

    fn drive(
        &mut self,
        hinge: u32,
        _: Membership,
        target: Option<Target<f32>>,
    ) -> Option<Measurement<f32>> {
        self.buses.drive(hinge, target, self.clock.micros)
    }

    fn commit(&mut self) {
        let lines = HEARD.iter().zip(&SAID).zip(LINES.iter().skip(1));
        for (bus, ((heard, said), (_, interrupt))) in self.buses.iter_mut().zip(lines) {
            let incoming = core::iter::from_fn(|| heard.take());
            bus.exchange(self.clock.micros, BAUD, incoming, |packet| {
                for byte in packet {
                    let _ = said.add(*byte);
                }
            });
            write(NVIC_PEND, 0b10 << interrupt);
        }
    }

    /// Nobody has asked the servos whether their drives have held.
    fn held(&mut self) -> bool {
        false
    }

    fn keep(&mut self, record: usize, at: usize, bytes: &[u8]) {
        RECORDS.keep(record, at, bytes);
    }

    fn kept(&mut self, record: usize, at: usize, bytes: &mut [u8]) {
        RECORDS.kept(record, at, bytes);
    }

    fn feed(&mut self) {
        registers::feed();
    }
}

/// Handles the interrupts of the lines.
#[exception]
unsafe fn DefaultHandler(interrupt: i16) {
    for (place, (line, first)) in LINES.into_iter().enumerate() {
        if interrupt == first {
            write(line + 0xc, 0b10);
            if read(line + 0x4) & 0b10 != 0 {
                let [byte, ..] = read(line).to_le_bytes();
                let _ = match place.checked_sub(1).and_then(|bus| HEARD.get(bus)) {
                    Some(heard) => heard.add(byte),
                    None => INCOMING.add(byte),
                };
            }
        } else if interrupt == first + 1 {
            write(line + 0xc, 0b01);
            let bus = place.checked_sub(1).and_then(|bus| SAID.get(bus));
            let free = read(line + 0x4) & 0b01 == 0;
            let byte = free.then(|| bus.map_or_else(|| OUTGOING.take(), Fifo::take));
            if let Some(byte) = byte.flatten() {
                write(line, byte.into());
            }
        }
    }
}
