//! Simulates a controller in this process, in virtual time, with the firmware's own code.

use core::num::NonZero;
use std::io;

use foldpath_core::GroupLimits;
use foldpath_core::follower::State;
use foldpath_core::wire::key::Key;
use foldpath_core::wire::protection::Keyed;
use foldpath_firmware_sim::controller::{Controller, Settings};
use foldpath_firmware_sim::faults::{Faults, Line};
use rand_pcg::Pcg64;

use super::{Link, Plant};

/// The controller with room for 256 groups, for as many hinges as the protocol counts, for the spokes of a thousand
/// vertices of degree 4, and for 64 setpoints.
pub type SimDevice = Controller<256, MAX_HINGES, 4096, 64, Keyed>;

/// Number of hinges for which the controller has room.
const MAX_HINGES: usize = 16_384;

/// Limits of every simulated hinge: half a turn each way, and a speed that no drive has.
const LIMITS: GroupLimits = GroupLimits {
    lower: -core::f32::consts::PI,
    upper: core::f32::consts::PI,
    speed: 100.0,
    acceleration: f32::INFINITY,
};

/// Length of a step and of a tick of the controller, microseconds.
const STEP_US: u64 = 250;
const TICK_US: u64 = 4 * STEP_US;
/// Longest time that a controller in real time makes up for, microseconds, and number of bytes that may wait for its line.
const MOST_MISSED_US: u64 = 1_000_000;
const MOST_WAITING: usize = 4096;

/// Time between two measurements of the sheet, microseconds.
const LOOK_US: u64 = 20_000;

/// A controller behind a serial line of 1 Mbaud with a delay of a millisecond, or behind [another](Self::with_line). Without a
/// plant its hinges are exactly at the commanded angles, and before the first command they are where the first path begins.
#[derive(Debug)]
pub struct Sim {
    now: u64,
    device: Box<SimDevice>,
    up: Line<Pcg64>,
    down: Line<Pcg64>,
    outgoing: Vec<u8>,
    plant: Option<Plant>,
    /// Angles of hinges that are moved one by one, radians.
    hinges: Vec<f32>,
}

impl Sim {
    /// Starts a controller without a plant and without a key. It takes a key.
    #[must_use]
    pub fn new() -> Self {
        Self::keyed(None, 1)
    }

    /// Starts a controller without a plant that has this key, if there is one, and this nonce.
    fn keyed(key: Option<Key>, nonce: u64) -> Self {
        let line = || {
            let faults = Faults {
                delay: 1000,
                speed: 1e5,
                ..Faults::default()
            };
            Line::new(faults, Pcg64::new(0, 0))
        };
        Self {
            now: 0,
            device: Box::new(SimDevice::keyed(
                Settings {
                    // Any sheet hangs on simulated hinges.
                    closed: false,
                    // The line stays in this process.
                    pairs: true,
                    nonce: NonZero::new(nonce),
                    ..Settings::new([0, 1], |_| LIMITS)
                },
                key,
            )),
            up: line(),
            down: line(),
            outgoing: Vec::new(),
            plant: None,
            hinges: Vec::new(),
        }
    }

    /// Starts a controller that drives a plant.
    #[must_use]
    pub fn driving(plant: Plant) -> Self {
        Self {
            plant: Some(plant),
            ..Self::new()
        }
    }

    /// Starts a controller of hinges without a sheet, which stand at 0, move as they are commanded, and are measured.
    #[must_use]
    pub fn bench() -> Self {
        Self {
            hinges: vec![0.0; MAX_HINGES],
            ..Self::new()
        }
    }

    /// Starts a controller as [`bench`](Self::bench) does, with this key, if there is one, and with this nonce: a random number
    /// that tells this run from all others. It runs in the time of its caller: see [`pass`](Self::pass).
    #[must_use]
    pub fn serving(key: Option<Key>, nonce: u64) -> Self {
        Self {
            hinges: vec![0.0; MAX_HINGES],
            ..Self::keyed(key, nonce)
        }
    }

    /// Hands bytes to the controller, without the simulated line, and lets it run until `now`, microseconds since its start.
    /// Appends its bytes for the line to `outgoing`, unless many wait there. Time that would take more than a second to make up
    /// for is skipped.
    pub fn pass(&mut self, now: u64, incoming: &[u8], outgoing: &mut Vec<u8>) {
        if now > self.now + MOST_MISSED_US {
            self.now = now;
        }
        for byte in incoming {
            self.hear(*byte);
        }
        while self.now + TICK_US <= now {
            self.now += TICK_US;
            self.tick();
            self.device.poll(self.now);
        }
        while outgoing.len() < MOST_WAITING
            && let Some(byte) = self.device.take()
        {
            outgoing.push(byte);
        }
    }

    /// Hands a byte to the controller.
    fn hear(&mut self, byte: u8) {
        self.device.byte(byte, self.now);
        // There is no memory to store a key in: the controller is gone at the end of the process.
        if let Some(key) = self.device.proposed_key() {
            self.device.pair(key);
        }
    }

    /// Lets the controller tick, and its hinges follow.
    fn tick(&mut self) {
        self.device.tick(self.now);
        let waits = self.device.follower().state() == State::Ready;
        let unmeasured = self.plant.is_none() && self.hinges.is_empty();
        if unmeasured && waits && !self.device.follower().is_known() {
            // Denied until the first setpoints have come.
            let _ = self.device.follower_mut().confirm();
        }
        if let Some(plant) = &mut self.plant {
            plant.turn(self.now, &mut self.device);
            if self.now.is_multiple_of(LOOK_US) {
                plant.look();
            }
        }
        if !self.hinges.is_empty() {
            let hinges = &mut self.hinges;
            self.device.drive(|hinge, _, target| {
                let angle = hinges.get_mut(usize::try_from(hinge).ok()?)?;
                *angle = target.map_or(*angle, |target| target.angle);
                Some((*angle).into())
            });
        }
    }

    /// Starts the controller anew with a key.
    #[must_use]
    pub fn with_key(self, key: Key) -> Self {
        Self {
            plant: self.plant,
            hinges: self.hinges,
            up: self.up,
            down: self.down,
            ..Self::keyed(Some(key), 1)
        }
    }

    /// Puts the controller behind a line with these faults both ways, which are drawn from `seed`.
    #[must_use]
    pub fn with_line(self, faults: Faults, seed: u64) -> Self {
        let line = |way| Line::new(faults, Pcg64::new(u128::from(seed), way));
        Self {
            up: line(0),
            down: line(1),
            ..self
        }
    }

    /// Returns the numbers of bytes that wait on the line to the controller, and on the line back.
    #[must_use]
    pub fn waiting(&self) -> [f64; 2] {
        [&self.up, &self.down].map(|line| line.waiting(self.now))
    }

    /// Returns the controller.
    #[must_use]
    pub fn device(&self) -> &SimDevice {
        &self.device
    }

    /// Returns the plant that the controller drives.
    #[must_use]
    pub fn plant(&self) -> Option<&Plant> {
        self.plant.as_ref()
    }

    /// Returns the plant, to let troubles befall it.
    pub fn plant_mut(&mut self) -> Option<&mut Plant> {
        self.plant.as_mut()
    }
}

impl Default for Sim {
    fn default() -> Self {
        Self::new()
    }
}

impl Link for Sim {
    fn now(&self) -> u64 {
        self.now
    }

    fn is_free(&self) -> bool {
        self.up.is_free(self.now)
    }

    fn write(&mut self, frame: &[u8]) -> io::Result<()> {
        self.up.write(frame, self.now);
        Ok(())
    }

    fn read(&mut self) -> io::Result<Option<u8>> {
        Ok(self.down.read(self.now))
    }

    fn wait(&mut self) -> io::Result<()> {
        self.now += STEP_US;
        while let Some(byte) = self.up.read(self.now) {
            self.hear(byte);
        }
        if self.now.is_multiple_of(TICK_US) {
            self.tick();
        }
        self.device.poll(self.now);
        while self.down.is_free(self.now)
            && let Some(byte) = self.device.take()
        {
            self.outgoing.push(byte);
            if byte == 0 {
                self.down.write(&self.outgoing, self.now);
                self.outgoing.clear();
            }
        }
        Ok(())
    }

    fn stop(&mut self) -> io::Result<bool> {
        self.device.stop(true);
        Ok(true)
    }
}
