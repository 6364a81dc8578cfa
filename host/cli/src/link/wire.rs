//! Lines to controllers behind TCP or a serial device.

use core::time::Duration;
use std::collections::VecDeque;
use std::io::{self, ErrorKind, Read, Write};
use std::net::TcpStream;
use std::time::Instant;

use foldpath::stream::Link;
use serialport::SerialPort;

/// Line to a controller over a stream of bytes whose reads and writes do not block.
#[derive(Debug)]
pub struct Wire<S> {
    stream: S,
    /// Returns the number of bytes that the system still holds back.
    held: fn(&S) -> u32,
    start: Instant,
    outgoing: Vec<u8>,
    incoming: VecDeque<u8>,
}

impl<S> Wire<S> {
    fn new(stream: S, held: fn(&S) -> u32) -> Self {
        Self {
            stream,
            held,
            start: Instant::now(),
            outgoing: Vec::new(),
            incoming: VecDeque::new(),
        }
    }
}

/// Returns an address with its host, which is this machine for a port alone.
pub(crate) fn with_host(address: &str) -> String {
    match address.parse::<u16>() {
        Ok(port) => format!("127.0.0.1:{port}"),
        Err(_) => address.into(),
    }
}

impl Wire<TcpStream> {
    /// Connects to `HOST:PORT`, or to a port of this machine.
    ///
    /// # Errors
    /// If nobody answers at the address.
    pub fn connect(address: &str) -> io::Result<Self> {
        Self::over(TcpStream::connect(with_host(address))?)
    }

    /// Makes a line of an open connection.
    ///
    /// # Errors
    /// If the system refuses.
    pub(super) fn over(stream: TcpStream) -> io::Result<Self> {
        stream.set_nodelay(true)?;
        stream.set_nonblocking(true)?;
        // A connection tells nothing of the bytes under way.
        Ok(Self::new(stream, |_| 0))
    }
}

impl Wire<Box<dyn SerialPort>> {
    /// Opens a serial device at a speed in baud, with eight data bits, no parity and one stop bit.
    ///
    /// # Errors
    /// If there is no such device, or the system refuses.
    pub fn open(device: &str, baud: u32) -> io::Result<Self> {
        let port = serialport::new(device, baud).timeout(Duration::ZERO);
        // Frames that wait in the system would be late, and a command would wait behind them.
        Ok(Self::new(port.open()?, |port| {
            port.bytes_to_write().unwrap_or(0)
        }))
    }
}

impl<S: Read + Write> Wire<S> {
    /// Hands over as many of the outgoing bytes as the system takes.
    fn flush(&mut self) -> io::Result<()> {
        while !self.outgoing.is_empty() {
            match self.stream.write(&self.outgoing) {
                Ok(count) => drop(self.outgoing.drain(..count)),
                Err(error) if is_pause(&error) => break,
                Err(error) => return Err(error),
            }
        }
        Ok(())
    }
}

/// Returns `true` if the error says only that nothing can be read or written at the moment.
fn is_pause(error: &io::Error) -> bool {
    use ErrorKind::{Interrupted, TimedOut, WouldBlock};
    matches!(error.kind(), WouldBlock | Interrupted | TimedOut)
}

impl<S: Read + Write> Link for Wire<S> {
    fn now(&self) -> u64 {
        u64::try_from(self.start.elapsed().as_micros()).unwrap_or(u64::MAX)
    }

    fn is_free(&self) -> bool {
        self.outgoing.is_empty() && (self.held)(&self.stream) == 0
    }

    fn write(&mut self, frame: &[u8]) -> io::Result<()> {
        self.outgoing.extend_from_slice(frame);
        self.flush()
    }

    fn read(&mut self) -> io::Result<Option<u8>> {
        if self.incoming.is_empty() {
            let mut buffer = [0; 512];
            match self.stream.read(&mut buffer) {
                Ok(0) => return Err(ErrorKind::UnexpectedEof.into()),
                Ok(count) => self.incoming.extend(buffer.iter().take(count)),
                Err(error) if is_pause(&error) => {}
                Err(error) => return Err(error),
            }
        }
        Ok(self.incoming.pop_front())
    }

    fn wait(&mut self) -> io::Result<()> {
        self.flush()?;
        std::thread::sleep(Duration::from_millis(1));
        Ok(())
    }
}
