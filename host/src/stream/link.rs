//! The interface between a session and a line to a controller.

use std::io;

use foldpath_core::wire::cobs;
use foldpath_core::wire::message::Item;
use foldpath_core::wire::sender::Source;

/// A byte stream to a controller and back. No function blocks but [`wait`](Self::wait).
pub trait Link {
    /// Returns the time in microseconds since some fixed moment.
    fn now(&self) -> u64;

    /// Returns `true` if all bytes written before have been sent.
    fn is_free(&self) -> bool;

    /// Sends a frame, given as its bytes on the line.
    ///
    /// # Errors
    /// If the line is broken.
    fn write(&mut self, frame: &[u8]) -> io::Result<()>;

    /// Returns the next byte that was received, or `None` if there is none yet.
    ///
    /// # Errors
    /// If the line is broken.
    fn read(&mut self) -> io::Result<Option<u8>>;

    /// Waits for at most a millisecond.
    ///
    /// # Errors
    /// If the line is broken.
    fn wait(&mut self) -> io::Result<()>;

    /// Draws the stop line, if this link can. Returns `true` if the stop line was drawn.
    ///
    /// # Errors
    /// If the line is broken.
    fn stop(&mut self) -> io::Result<bool> {
        Ok(false)
    }
}

impl<L: Link + ?Sized> Link for &mut L {
    fn now(&self) -> u64 {
        (**self).now()
    }

    fn is_free(&self) -> bool {
        (**self).is_free()
    }

    fn write(&mut self, frame: &[u8]) -> io::Result<()> {
        (**self).write(frame)
    }

    fn read(&mut self) -> io::Result<Option<u8>> {
        (**self).read()
    }

    fn wait(&mut self) -> io::Result<()> {
        (**self).wait()
    }

    fn stop(&mut self) -> io::Result<bool> {
        (**self).stop()
    }
}

/// Writes a frame to a link; returns its number of bytes on the line.
pub(super) fn send(link: &mut impl Link, frame: &[u8]) -> io::Result<u64> {
    let mut bytes = Vec::new();
    cobs::encode(frame, |byte| bytes.push(byte));
    link.write(&bytes)?;
    Ok(bytes.len() as u64)
}

/// A host that sends no items.
pub(super) struct Nothing;

impl Source for Nothing {
    fn item<'b>(&self, _: u64, _: &'b mut [u8]) -> Option<Item<'b>> {
        None
    }
}
