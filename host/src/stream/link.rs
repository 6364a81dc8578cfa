//! What a session asks of a line to a controller.

use std::io;

/// Bytes to a controller and back. Nothing waits but [`wait`](Self::wait).
pub trait Link {
    /// Microseconds since some moment before.
    fn now(&self) -> u64;

    /// Whether what was written before is gone.
    fn is_free(&self) -> bool;

    /// Sends a frame as it is on the line.
    ///
    /// # Errors
    /// If the line is broken.
    fn write(&mut self, frame: &[u8]) -> io::Result<()>;

    /// The next byte that has come.
    ///
    /// # Errors
    /// If the line is broken.
    fn read(&mut self) -> io::Result<Option<u8>>;

    /// Lets at most a millisecond pass.
    ///
    /// # Errors
    /// If the line is broken.
    fn wait(&mut self) -> io::Result<()>;

    /// Draws the stop line, if there is one to draw from here; returns whether there is.
    ///
    /// # Errors
    /// If the line is broken.
    fn stop(&mut self) -> io::Result<bool> {
        Ok(false)
    }
}

impl<L: Link> Link for &mut L {
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
