//! Gives a controller its key, over a line that no stranger reaches.

use std::io;

use foldpath_core::wire::cobs::Deframer;
use foldpath_core::wire::frame;
use foldpath_core::wire::key::Key;
use foldpath_core::wire::message::ToDevice;
use foldpath_core::wire::sender::{Failure, Options, Phase, Sender};

use super::link::{Link, Nothing, send};

/// Time for a session to open, microseconds.
const PATIENCE_US: u64 = 2_000_000;
/// Number of attempts: the frame with the key may get lost.
const MAX_ATTEMPTS: u32 = 3;

/// Outcome of [`pair`].
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum Pairing {
    /// The controller has the key, and has answered with it.
    Paired,
    /// A controller without a key answers and does not take one: it has no room for a key, its sheet moves, or its board
    /// allows no key over this line.
    Refused,
    /// No controller answers, or only one that has another key could be there.
    NoDevice,
    /// A controller answers that speaks another version of the protocol.
    Version(Failure),
}

/// Sends a key to a controller that has none, and then opens a session with it. A controller that has this key already is
/// paired as well. The key goes over the line as it is: whoever listens has it. `nonce` is a number that no session with
/// this controller has had, nor have the next six numbers.
///
/// # Errors
/// If the line breaks.
pub fn pair(link: &mut impl Link, key: Key, nonce: u64) -> io::Result<Pairing> {
    let mut answers = false;
    for round in 0..MAX_ATTEMPTS {
        let [mut plain, keyed] = [0, 1].map(|own| {
            let nonce = nonce.wrapping_add(u64::from(2 * round + own));
            let [a, b, c, d, upper @ ..] = nonce.to_le_bytes();
            let sender = Sender::new(u32::from_le_bytes([a, b, c, d]), Options::default());
            (sender, u32::from_le_bytes(upper))
        });
        let opened = open(link, &mut plain.0)?;
        if let Phase::Failed(failure @ Failure::Version { .. }) = plain.0.phase() {
            return Ok(Pairing::Version(failure));
        }
        if opened {
            answers = true;
            let mut buffer = [0; 64];
            let message = ToDevice::Pair(key.bytes());
            if let Some(frame) = frame::seal(plain.0.session(), &message, &mut buffer) {
                send(link, frame)?;
            }
        }
        if open(link, &mut keyed.0.with_key(key, keyed.1))? {
            return Ok(Pairing::Paired);
        }
    }
    Ok(if answers {
        Pairing::Refused
    } else {
        Pairing::NoDevice
    })
}

/// Opens a session; returns `false` if there is none in time.
fn open(link: &mut impl Link, sender: &mut Sender) -> io::Result<bool> {
    let mut deframer = Deframer::<512>::default();
    let start = link.now();
    while link.now() < start + PATIENCE_US && !matches!(sender.phase(), Phase::Failed(_)) {
        let (mut scratch, mut buffer) = ([0; 64], [0; 64]);
        if link.is_free()
            && let Some(frame) = sender.poll(link.now(), &Nothing, &mut scratch, &mut buffer)
        {
            send(link, frame)?;
        }
        link.wait()?;
        while let Some(byte) = link.read()? {
            if let Some(frame) = deframer.push(byte) {
                let _ = sender.receive(frame, link.now());
            }
            if sender.phase() == Phase::Open {
                return Ok(true);
            }
        }
    }
    Ok(false)
}
