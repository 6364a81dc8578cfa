//! A link that adds faults to another link, both ways.

use std::io;

use foldpath_firmware_sim::faults::{Faults, Line};
use rand_pcg::Pcg64;

use super::Link;

/// Largest delay of an overtaken frame, microseconds.
const MAX_DELAY_US: u64 = 5000;

/// A link on which frames get lost, changed, doubled and overtaken, both ways.
#[derive(Debug)]
pub struct Faulty<L> {
    link: L,
    up: Line<Pcg64>,
    down: Line<Pcg64>,
    /// The beginning of a frame that is being received.
    incoming: Vec<u8>,
}

impl<L: Link> Faulty<L> {
    /// Adds these faults to a link, at random by `seed`.
    #[must_use]
    pub fn new(link: L, faults: Faults, seed: u64) -> Self {
        let faults = Faults {
            late: MAX_DELAY_US,
            ..faults
        };
        let rng = |way| Pcg64::new(u128::from(seed), way);
        Self {
            link,
            up: Line::new(faults, rng(0)),
            down: Line::new(faults, rng(1)),
            incoming: Vec::new(),
        }
    }

    /// Passes on the bytes that have come through.
    fn pass(&mut self) -> io::Result<()> {
        let now = self.link.now();
        let bytes: Vec<u8> = core::iter::from_fn(|| self.up.read(now)).collect();
        if bytes.is_empty() {
            return Ok(());
        }
        self.link.write(&bytes)
    }
}

impl<L: Link> Link for Faulty<L> {
    fn now(&self) -> u64 {
        self.link.now()
    }

    fn is_free(&self) -> bool {
        self.link.is_free()
    }

    fn write(&mut self, frame: &[u8]) -> io::Result<()> {
        self.up.write(frame, self.link.now());
        self.pass()
    }

    fn read(&mut self) -> io::Result<Option<u8>> {
        while let Some(byte) = self.link.read()? {
            self.incoming.push(byte);
            if byte == 0 {
                self.down.write(&self.incoming, self.link.now());
                self.incoming.clear();
            }
        }
        Ok(self.down.read(self.link.now()))
    }

    fn wait(&mut self) -> io::Result<()> {
        self.pass()?;
        self.link.wait()
    }

    fn stop(&mut self) -> io::Result<bool> {
        self.link.stop()
    }
}
