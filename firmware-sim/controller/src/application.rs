//! The main loop of a controller, for any board.
//!
//! A board offers a serial line by the traits of [`embedded_io`], whose interrupts fill and empty queues
//! ([`Fifo`](crate::Fifo)), and everything else as a [`Board`]. Nothing here waits.

use core::num::NonZero;

use embedded_io::{Read, ReadReady, Write, WriteReady};
use foldpath_core::Membership;
use foldpath_core::follower::{FollowerPosition, Measurement, Target};
use foldpath_core::wire::key::{Key, StoredKey};
use foldpath_core::wire::protection::{Protection, Unkeyed};

use crate::controller::{Condition, Controller, Settings};
use crate::player::Player;
use crate::retained::{self, Bytes, HEAD, Record};

/// Microseconds between two ticks.
pub const TICK: u64 = 1000;
/// Largest number of bytes that are decoded in a round before answers are sent.
const MAX_BURST_BYTES: usize = 64;

/// The services that a controller needs of its board.
pub trait Board {
    /// Returns the microseconds since the start.
    fn now(&mut self) -> u64;
    /// Returns `true` if the stop line is drawn, or was drawn since the last call.
    fn stop(&mut self) -> bool;
    /// Holds the power of the drives or lets them rest, as [`Condition::power`] says. Called once a tick before the hinges are
    /// driven, in every state: before the first sheet, after a reset and in a fault as well.
    fn power(&mut self, condition: &Condition);
    /// Commands a hinge of this group and sign its target: the angle for a servo, the rate for a drive that takes speeds.
    /// `None` while it is not known where the hinge stands, so that it must not move: a drive that turns to its last command is
    /// commanded what [`Hold`](crate::Hold) returns. Returns the newest measurement of
    /// the hinge that was not yet returned, with its age, if there is one.
    fn drive(
        &mut self,
        hinge: u32,
        membership: Membership,
        target: Option<Target<f32>>,
    ) -> Option<Measurement<f32>>;
    /// Called once a tick after the last hinge, for drives that take all targets at once, such as servos on a bus. Such a
    /// board collects the targets in [`drive`](Self::drive), and sends them here.
    fn commit(&mut self) {}
    /// Returns `true` if the drives have held the hinges from the last tick before a reset until now, so that they stand
    /// where the record says. Called once at the start. Drives that lose their power or their pulses in a reset have not.
    fn held(&mut self) -> bool;
    /// Bytes of each of the two records that a reset leaves as they are. [`retained::size`] are needed.
    const RECORD: usize;
    /// Writes bytes from byte `at` on into record 0 or 1.
    fn keep(&mut self, record: usize, at: usize, bytes: &[u8]);
    /// Reads bytes from byte `at` on of record 0 or 1, whatever its memory held at the start.
    fn kept(&mut self, record: usize, at: usize, bytes: &mut [u8]);
    /// Returns the key that was stored, if this board has one. Called once at the start of a controller that has room for a
    /// key. A key that cannot be read any more is [`StoredKey::Damaged`] and never [`StoredKey::None`], which would open the
    /// controller to everybody; [`stored::open`](crate::stored::open) tells them apart.
    fn key(&mut self) -> StoredKey {
        StoredKey::None
    }
    /// Stores the key that a host has set, in memory that keeps it without power, and returns `true` if it can be read from
    /// there. Called at rest, and only if [`Settings::pairs`] allows it. A key is stored as a whole or not at all, wherever
    /// the power goes: [`stored::words`](crate::stored::words) are written in their order into memory that was erased before.
    /// Nothing else runs meanwhile, so that the watchdog's time is the longest that this may take.
    fn store_key(&mut self, _: &Key) -> bool {
        false
    }
    /// Keeps the watchdog from resetting the board for a while longer.
    fn feed(&mut self);
}

/// A controller on a board, with a line to its host.
// In order, for the reason given at `Follower`.
#[derive(Debug)]
#[repr(C)]
pub struct Application<
    B,
    L,
    const GROUPS: usize,
    const HINGES: usize,
    const SPOKES: usize,
    const KNOTS: usize,
    P: Protection = Unkeyed,
> {
    board: B,
    line: L,
    /// Number of starts (`starts`, resets included), and number of records written (`records`).
    starts: u32,
    records: u32,
    /// Time when the next tick is due, microseconds.
    due: u64,
    device: Controller<GROUPS, HINGES, SPOKES, KNOTS, P>,
}

impl<
    B,
    L,
    const GROUPS: usize,
    const HINGES: usize,
    const SPOKES: usize,
    const KNOTS: usize,
    P: Protection,
> Application<B, L, GROUPS, HINGES, SPOKES, KNOTS, P>
where
    B: Board,
    L: Read + ReadReady + Write + WriteReady,
{
    /// Creates a controller that stands where it was before a reset, if that was kept. If the stop line held the
    /// motion or the motion had failed, that is still so. Does not compile if the board's records are too small.
    ///
    /// With room for a key ([`Keyed`](foldpath_core::wire::protection::Keyed)) the controller has the key that the board
    /// has stored. If there is none, it takes frames of any host, and takes a key if [`Settings::pairs`] allows it. If the key
    /// is damaged, it takes nothing.
    // Inlined, as are the constructors that it calls: otherwise the controller is built on the stack and moved from
    // there.
    #[inline(always)]
    #[must_use]
    pub fn new(mut board: B, line: L, settings: Settings) -> Self {
        const {
            assert!(
                B::RECORD >= retained::size(GROUPS),
                "a record has no room for the angles of all groups"
            );
        }
        let kept = latest::<GROUPS>(&mut board, settings.image);
        let key = if P::KEYED {
            board.key()
        } else {
            StoredKey::None
        };
        let protection = P::with_key(key);
        let starts = kept.map_or(0, |kept| kept.starts.wrapping_add(1));
        // A warm reset may leave the board's own number as it was. If that is a count below the number of the chip, both
        // stay apart from these bits.
        let starts_apart = |nonce: NonZero<u64>| nonce.get() ^ u64::from(starts.reverse_bits());
        let nonce = settings
            .nonce
            .and_then(|nonce| NonZero::new(starts_apart(nonce)));
        Self {
            board,
            line,
            device: Controller::protected(Settings { nonce, ..settings }, protection),
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

    /// Bounds the path from outside by a place on it, so that several controllers stay together: see
    /// [`Follower::lease`](foldpath_core::follower::Follower::lease).
    pub fn lease(&mut self, place: Option<FollowerPosition<f32>>) {
        self.device.follower_mut().lease(place);
    }

    /// Plays a path from flash if a button asks for it; to be called after each [`step`](Self::step) by a board that has
    /// such a [`Player`].
    pub fn play(&mut self, player: &mut Player<'_>) {
        // Before the first step it is not restored where the sheet stands.
        if self.due > 0 {
            let now = self.board.now();
            self.device.play(player, now);
        }
    }

    /// Returns `true` if [`step`](Self::step) has work left, so that the board should call it again without waiting for an
    /// interrupt.
    #[must_use]
    pub fn is_busy(&self) -> bool {
        self.device.is_busy()
    }

    /// Restores the angles and the place that the records hold. Not done in `new`, which would then build the
    /// controller on the stack and move it.
    #[inline(never)]
    fn restore(&mut self) {
        if let Some(kept) = latest(&mut self.board, self.device.settings.image) {
            let held = self.board.held();
            self.device.restore(&kept, held);
        }
    }

    /// Reads the stop line. A stop is kept in a record before the host is told, because a reset may come in between.
    #[inline(never)]
    fn watch(&mut self) {
        let drawn = self.board.stop();
        let before = self.device.follower().is_stopped();
        self.device.stop(drawn);
        if self.device.follower().is_stopped() != before {
            self.keep();
        }
    }

    /// Ticks and feeds the watchdog. The watchdog is fed nowhere else, so that it notices a clock or a main loop that
    /// stands.
    // Not inlined, so that `step` has the stack of one thing at a time.
    #[inline(never)]
    fn tick(&mut self, now: u64) {
        self.device.tick(now);
        self.board.power(&self.device.condition());
        self.device
            .drive(|hinge, membership, target| self.board.drive(hinge, membership, target));
        self.board.commit();
        self.keep();
        self.board.feed();
    }

    /// Keeps the commanded angles in the older of the two records.
    #[inline(never)]
    fn keep(&mut self) {
        self.records = self.records.wrapping_add(1);
        let kept = self.device.record(self.starts, self.records);
        let mut bytes: Bytes<GROUPS> = ([0; HEAD], [[0; 4]; GROUPS]);
        let groups = kept.seal(self.device.settings.image, &mut bytes);
        let record = usize::from(self.records % 2 == 1);
        let (head, angles) = bytes;
        self.board.keep(record, 0, &head);
        let angles = angles.get(..groups).unwrap_or(&[]);
        self.board.keep(record, HEAD, angles.as_flattened());
    }

    fn receive(&mut self, now: u64) {
        for _ in 0..MAX_BURST_BYTES {
            let mut byte = [0];
            if self.device.is_busy() {
                return;
            }
            let ready = matches!(self.line.read_ready(), Ok(true));
            if !ready || !matches!(self.line.read(&mut byte), Ok(1)) {
                return;
            }
            let [byte] = byte;
            self.device.byte(byte, now);
            // A controller that answers with its key has stored it.
            if let Some(key) = self.device.proposed_key()
                && self.board.store_key(&key)
            {
                self.device.pair(key);
            }
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
fn latest<const GROUPS: usize>(board: &mut impl Board, image: u32) -> Option<Record<GROUPS>> {
    let mut bytes: Bytes<GROUPS> = ([0; HEAD], [[0; 4]; GROUPS]);
    let [a, b] = [0, 1].map(|record| {
        let (head, angles) = &mut bytes;
        board.kept(record, 0, head);
        board.kept(record, HEAD, angles.as_flattened_mut());
        Record::open(image, &bytes)
    });
    Record::latest(a, b)
}
