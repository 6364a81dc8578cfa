//! The main loop of a controller, for any board.
//!
//! A board offers a serial line by the traits of [`embedded_io`], whose interrupts fill and empty queues
//! ([`Fifo`](crate::fifo::Fifo)), and everything else as a [`Board`]. Nothing here waits.

use embedded_io::{Read, ReadReady, Write, WriteReady};
use foldpath_core::Membership;
use foldpath_core::follower::Reason;

use crate::controller::{Controller, Settings};
use crate::kept::Kept;

/// Bytes of a record that the board keeps over a reset.
pub const RECORD: usize = 64;

/// Microseconds between two ticks.
pub const TICK: u64 = 1000;
/// Largest number of bytes that are decoded in a round before answers are sent.
const BURST: usize = 64;

/// The services that a controller needs of its board.
pub trait Board {
    /// Returns the microseconds since the start.
    fn now(&mut self) -> u64;
    /// Returns `true` if the stop line is drawn, or was drawn since the last call.
    fn stop(&mut self) -> bool;
    /// Commands a hinge of this group and sign its angle, radians. Returns the measured angle, radians, if there is
    /// one.
    fn drive(&mut self, hinge: u32, membership: Membership, angle: f32) -> Option<f32>;
    /// Writes one of two records that a reset leaves as they are.
    fn keep(&mut self, record: usize, bytes: &[u8; RECORD]);
    /// Reads one of the two records, whatever its memory held at the start.
    fn kept(&mut self, record: usize) -> [u8; RECORD];
    /// Keeps the watchdog from resetting the board for a while longer.
    fn feed(&mut self);
}

/// A controller on a board, with a line to its host.
#[derive(Debug)]
pub struct Application<
    B,
    L,
    const GROUPS: usize,
    const HINGES: usize,
    const SPOKES: usize,
    const KNOTS: usize,
> {
    board: B,
    line: L,
    device: Controller<GROUPS, HINGES, SPOKES, KNOTS>,
    /// Number of starts (`starts`, resets included), and number of records written (`records`).
    starts: u32,
    records: u32,
    /// Time when the next tick is due, microseconds.
    due: u64,
}

impl<B, L, const GROUPS: usize, const HINGES: usize, const SPOKES: usize, const KNOTS: usize>
    Application<B, L, GROUPS, HINGES, SPOKES, KNOTS>
where
    B: Board,
    L: Read + ReadReady + Write + WriteReady,
{
    /// Creates a controller that stands where it was before a reset, if that was kept. If the stop line held the
    /// motion, it still does.
    // Inlined, as are the constructors that it calls: otherwise the controller is built on the stack and moved from
    // there.
    #[inline(always)]
    #[must_use]
    pub fn new(mut board: B, line: L, settings: Settings) -> Self {
        let kept = latest(&mut board);
        let starts = kept.map_or(0, |kept| kept.starts.wrapping_add(1));
        let boot = settings.boot.wrapping_add(starts << 16);
        Self {
            board,
            line,
            device: Controller::new(Settings { boot, ..settings }),
            starts,
            records: kept.map_or(0, |kept| kept.count),
            due: 0,
        }
    }

    /// Runs one round of the main loop: ticks if a tick is due, decodes received bytes, and answers.
    pub fn step(&mut self) {
        if self.due == 0 {
            self.restore();
        }
        let now = self.board.now();
        self.watch();
        if now >= self.due {
            self.due = now.max(self.due + TICK);
            self.tick(now);
        }
        self.receive(now);
        self.device.poll(now);
        self.send();
    }

    /// Restores the angles and the place that the records hold. Not done in `new`, which would then build the
    /// controller on the stack and move it.
    #[inline(never)]
    fn restore(&mut self) {
        let Some(kept) = latest(&mut self.board) else {
            return;
        };
        let follower = self.device.follower_mut();
        if !kept.angles().is_empty() {
            let _ = follower.stand(kept.angles(), kept.place);
        }
        if kept.stopped {
            follower.hold(Reason::StopLine);
        }
    }

    /// Reads the stop line. A stop is kept in a record before the host is told, because a reset may come in between.
    fn watch(&mut self) {
        let drawn = self.board.stop();
        let before = self.device.follower().reason();
        self.device.stop(drawn);
        if self.device.follower().reason() != before {
            self.keep();
        }
    }

    /// Ticks and feeds the watchdog. The watchdog is fed nowhere else, so that it notices a clock or a main loop that
    /// stands.
    // Not inlined, so that `step` has the stack of one thing at a time.
    #[inline(never)]
    fn tick(&mut self, now: u64) {
        self.device.tick(now);
        self.device
            .drive(|hinge, membership, angle| self.board.drive(hinge, membership, angle));
        self.keep();
        self.board.feed();
    }

    /// Keeps the commanded angles in the older of the two records.
    #[inline(never)]
    fn keep(&mut self) {
        let follower = self.device.follower();
        self.records = self.records.wrapping_add(1);
        let Some(mut kept) = Kept::new(self.starts, self.records, follower.angles()) else {
            return;
        };
        kept.stopped = follower.reason() == Reason::StopLine;
        kept.place = follower.position();
        let record = usize::from(self.records % 2 == 1);
        self.board.keep(record, &kept.seal());
    }

    fn receive(&mut self, now: u64) {
        for _ in 0..BURST {
            let mut byte = [0];
            let ready = matches!(self.line.read_ready(), Ok(true));
            if !ready || !matches!(self.line.read(&mut byte), Ok(1)) {
                return;
            }
            let [byte] = byte;
            self.device.byte(byte, now);
            self.watch();
        }
    }

    fn send(&mut self) {
        while matches!(self.line.write_ready(), Ok(true))
            && let Some(byte) = self.device.take()
        {
            let _ = self.line.write(&[byte]);
        }
    }
}

/// Returns the newest record.
#[inline(never)]
fn latest(board: &mut impl Board) -> Option<Kept> {
    Kept::latest(&[board.kept(0), board.kept(1)])
}
