//! A lock-free queue of bytes between an interrupt and the main loop, and a line of two of them.

use core::convert::Infallible;
use core::sync::atomic::{AtomicU8, AtomicUsize, Ordering};

use embedded_io::{ErrorType, Read, ReadReady, Write, WriteReady};

/// A queue of up to `N` bytes, a power of 2, for one producer and one consumer, neither of which waits.
#[derive(Debug)]
pub struct Fifo<const N: usize> {
    bytes: [AtomicU8; N],
    /// Numbers of bytes ever added (`added`) and taken (`taken`), modulo 2³².
    added: AtomicUsize,
    taken: AtomicUsize,
}

impl<const N: usize> Default for Fifo<N> {
    fn default() -> Self {
        Self::new()
    }
}

impl<const N: usize> Fifo<N> {
    /// Creates an empty queue.
    #[must_use]
    pub const fn new() -> Self {
        const { assert!(N.is_power_of_two(), "counts wrap at a power of 2") };
        Self {
            bytes: [const { AtomicU8::new(0) }; N],
            added: AtomicUsize::new(0),
            taken: AtomicUsize::new(0),
        }
    }

    /// Returns the number of bytes that wait.
    #[must_use]
    pub fn len(&self) -> usize {
        let added = self.added.load(Ordering::Acquire);
        added.wrapping_sub(self.taken.load(Ordering::Acquire))
    }

    /// Returns `true` if no byte waits.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// Returns `true` if there is no room.
    #[must_use]
    pub fn is_full(&self) -> bool {
        self.len() >= N
    }

    /// Adds a byte; returns `true` if there was room. Only the producer may call this.
    pub fn add(&self, byte: u8) -> bool {
        let added = self.added.load(Ordering::Relaxed);
        let place = self.bytes.get(added % N).filter(|_| !self.is_full());
        if let Some(place) = place {
            place.store(byte, Ordering::Relaxed);
            self.added.store(added.wrapping_add(1), Ordering::Release);
        }
        place.is_some()
    }

    /// Takes a byte, if one waits. Only the consumer may call this.
    pub fn take(&self) -> Option<u8> {
        let taken = self.taken.load(Ordering::Relaxed);
        let place = self.bytes.get(taken % N).filter(|_| !self.is_empty())?;
        let byte = place.load(Ordering::Relaxed);
        self.taken.store(taken.wrapping_add(1), Ordering::Release);
        Some(byte)
    }
}

/// The controller's end of a line that interrupts or tasks fill and empty.
#[derive(Debug)]
pub struct Line<'a, const IN: usize, const OUT: usize, W> {
    /// Bytes that wait for the controller.
    pub incoming: &'a Fifo<IN>,
    /// Bytes from the controller that wait for the line.
    pub outgoing: &'a Fifo<OUT>,
    /// Wakes what takes bytes out of `outgoing`, to which some were added.
    pub wake: W,
}

impl<const IN: usize, const OUT: usize, W> ErrorType for Line<'_, IN, OUT, W> {
    type Error = Infallible;
}

impl<const IN: usize, const OUT: usize, W> ReadReady for Line<'_, IN, OUT, W> {
    fn read_ready(&mut self) -> Result<bool, Infallible> {
        Ok(!self.incoming.is_empty())
    }
}

impl<const IN: usize, const OUT: usize, W> Read for Line<'_, IN, OUT, W> {
    fn read(&mut self, bytes: &mut [u8]) -> Result<usize, Infallible> {
        let waiting = core::iter::from_fn(|| self.incoming.take());
        let places = bytes.iter_mut().zip(waiting);
        Ok(places.map(|(place, byte)| *place = byte).count())
    }
}

impl<const IN: usize, const OUT: usize, W> WriteReady for Line<'_, IN, OUT, W> {
    fn write_ready(&mut self) -> Result<bool, Infallible> {
        Ok(!self.outgoing.is_full())
    }
}

impl<const IN: usize, const OUT: usize, W: FnMut()> Write for Line<'_, IN, OUT, W> {
    fn write(&mut self, bytes: &[u8]) -> Result<usize, Infallible> {
        let added = bytes.iter().take_while(|byte| self.outgoing.add(**byte));
        let count = added.count();
        (self.wake)();
        Ok(count)
    }

    fn flush(&mut self) -> Result<(), Infallible> {
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::Fifo;
    use std::vec::Vec;

    #[test]
    fn bytes_come_out_in_order_and_none_is_added_where_there_is_no_room() {
        let fifo = Fifo::<8>::new();
        let (mut next, mut expected) = (0_u8, 0_u8);
        for round in 0..100 {
            for _ in 0..round % 11 {
                let room = fifo.len() < 8;
                assert_eq!(fifo.add(next), room);
                next = next.wrapping_add(u8::from(room));
            }
            for _ in 0..round % 7 {
                let byte = (!fifo.is_empty()).then_some(expected);
                assert_eq!(fifo.take(), byte);
                expected = expected.wrapping_add(u8::from(byte.is_some()));
            }
        }
    }

    #[test]
    fn two_threads_pass_all_bytes_on() {
        let fifo = Fifo::<16>::new();
        let bytes: Vec<u8> = (0..200_000_u32).map(|k| k.to_le_bytes()[1]).collect();
        std::thread::scope(|scope| {
            scope.spawn(|| {
                for byte in &bytes {
                    while !fifo.add(*byte) {
                        std::thread::yield_now();
                    }
                }
            });
            for byte in &bytes {
                let taken = loop {
                    match fifo.take() {
                        Some(taken) => break taken,
                        None => std::thread::yield_now(),
                    }
                };
                assert_eq!(taken, *byte);
            }
        });
    }
}
