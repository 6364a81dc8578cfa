//! Simulates a controller in this process, in virtual time, with the firmware's own code.

use std::io;

use foldpath_firmware_sim::controller::{Controller, Settings};
use foldpath_firmware_sim::faults::{Faults, Line};
use rand_pcg::Pcg64;

use super::{Link, Plant};

/// The controller with room for 32 groups, more than a frame holds; for as many hinges as the protocol counts; for the
/// spokes of a thousand vertices of degree 4; and for 64 setpoints.
type Device = Controller<32, 16_384, 4096, 64>;

/// Length of a step, microseconds. Four steps are a tick of the controller.
const STEP: u64 = 250;

/// Time between two measurements of the sheet, microseconds.
const LOOK: u64 = 20_000;

/// A controller behind a serial line of 1 Mbaud with a delay of a millisecond. Without a plant its hinges are exactly
/// at the commanded angles.
#[derive(Debug)]
pub struct Sim {
    now: u64,
    device: Box<Device>,
    up: Line<Pcg64>,
    down: Line<Pcg64>,
    outgoing: Vec<u8>,
    plant: Option<Plant>,
}

impl Sim {
    /// Starts a controller without a plant.
    #[must_use]
    pub fn new() -> Self {
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
            device: Box::new(Device::new(Settings::default())),
            up: line(),
            down: line(),
            outgoing: Vec::new(),
            plant: None,
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

    /// Returns the plant that the controller drives.
    #[must_use]
    pub fn plant(&self) -> Option<&Plant> {
        self.plant.as_ref()
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
        self.now += STEP;
        while let Some(byte) = self.up.read(self.now) {
            self.device.byte(byte, self.now);
        }
        if self.now.is_multiple_of(4 * STEP) {
            self.device.tick(self.now);
            if let Some(plant) = &mut self.plant {
                plant.turn(self.now, self.device.follower_mut());
                if self.now.is_multiple_of(LOOK) {
                    plant.look();
                }
            }
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
