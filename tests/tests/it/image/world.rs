//! Hosts, a line with faults and a board. Everything that the board says is judged, in the board's own time.

use std::time::Instant;

use foldpath_core::follower::{FollowerPosition, Reason, State};
use foldpath_core::wire::cobs::{self, Deframer};
use foldpath_core::wire::driver::{Driver, Persistence};
use foldpath_core::wire::frame;
use foldpath_core::wire::message::{Item, Report, ToDevice, ToHost};
use foldpath_core::wire::sender::{Failure, Options, Phase};
use foldpath_firmware_sim::faults::{Faults, Line};
use rand_core::Rng;
use rand_pcg::Pcg64;

use super::board::{Board, pause};
use super::path::{CLOSURE, Fold};

/// Options of a very patient host, because the machine may be busy, and the board's time may pass six times as fast as
/// that of the machine.
const PATIENT: Options = Options {
    node: 0,
    max_retry: 500_000,
    retry: 100_000,
    alive: 20_000,
    silence: 60_000_000,
    // The emulated line has no buffer, and telemetry is judged every 20 ms.
    slow_trip: u64::MAX,
};

pub(crate) fn rng(seed: u64) -> Pcg64 {
    Pcg64::new(u128::from(seed), 7)
}

/// Draws a moment within the path, which takes more than two seconds, microseconds.
pub(crate) fn moment(seed: u64) -> u64 {
    100_000 + rng(900 + seed).next_u64() % 1_400_000
}

/// Returns a frame as its bytes on the line.
pub(crate) fn stuffed(frame: &[u8]) -> Vec<u8> {
    let mut bytes = Vec::new();
    cobs::encode(frame, |byte| bytes.push(byte));
    bytes
}

/// The library's host.
pub(crate) struct Host<'a> {
    pub(crate) driver: Driver<'a>,
    /// `true` while the host speaks and listens.
    pub(crate) awake: bool,
    pub(crate) reasons: Vec<Reason>,
}

impl Host<'_> {
    fn byte(&mut self, byte: u8, now: u64) {
        if let Some(ToHost::Report(report)) = self.driver.byte(byte, now)
            && self.reasons.last() != Some(&report.reason)
        {
            self.reasons.push(report.reason);
        }
    }

    fn poll(&mut self, now: u64) -> Option<Vec<u8>> {
        let (mut scratch, mut buffer) = ([0; 256], [0; 256]);
        let frame = self.driver.poll(now, &mut scratch, &mut buffer)?;
        Some(frame.to_vec())
    }
}

/// Content of the last telemetry.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Sight {
    pub(crate) time: u64,
    pub(crate) state: State,
    pub(crate) rate: f32,
    pub(crate) place: FollowerPosition<f32>,
    pub(crate) angles: Option<[f32; 2]>,
}

/// Hosts, line and board. Everything that the board says is judged before the line spoils it.
pub(crate) struct World<'a> {
    pub(crate) board: Board,
    pub(crate) hosts: Vec<Host<'a>>,
    pub(crate) up: Line<Pcg64>,
    pub(crate) down: Line<Pcg64>,
    /// Bytes of all frames that hosts have sent, as they are on the line.
    pub(crate) spoken: Vec<u8>,
    pub(crate) report: Option<Report>,
    /// Number of reports.
    pub(crate) reports: u64,
    pub(crate) sight: Option<Sight>,
    /// Number of pieces of telemetry that were judged.
    pub(crate) sights: u64,
    /// Number of frames of the board that are no message.
    pub(crate) garbled: u64,
    /// `true` until the next frame begins, after a reset that may have cut off the one before.
    cut: bool,
    /// Longest silence of the board, microseconds of its own time.
    pub(crate) hole: u64,
    /// `true` while nobody reads what the board says.
    deaf: bool,
    fold: &'a Fold,
    start: Instant,
    outgoing: Vec<u8>,
    incoming: Vec<u8>,
    ear: Deframer<512>,
    /// Number of the last setpoint that was sent.
    sent: Option<u32>,
}

impl<'a> World<'a> {
    pub(crate) fn new(fold: &'a Fold, machine: &str, faults: Faults, seed: u64) -> Self {
        Self {
            board: Board::start(machine),
            hosts: Vec::new(),
            up: Line::new(faults, rng(2 * seed)),
            down: Line::new(faults, rng(2 * seed + 1)),
            spoken: Vec::new(),
            report: None,
            reports: 0,
            sight: None,
            sights: 0,
            garbled: 0,
            cut: false,
            hole: 0,
            deaf: false,
            fold,
            start: Instant::now(),
            outgoing: Vec::new(),
            incoming: Vec::new(),
            ear: Deframer::default(),
            sent: None,
        }
    }

    /// Adds a host, which greets the board and goes on after every silence. The first host says that the sheet stands where
    /// the path begins.
    pub(crate) fn greet(&mut self, persistence: Persistence) {
        let id = 1000 + 7 * u32::try_from(self.hosts.len()).unwrap();
        let driver = Driver::new(self.fold.items(), persistence, id, PATIENT);
        let mut driver = driver.unattended();
        if self.hosts.is_empty() {
            driver = driver.confirming();
        }
        self.hosts.push(Host {
            driver,
            awake: true,
            reasons: Vec::new(),
        });
    }

    pub(crate) fn host(&self) -> &Host<'a> {
        self.hosts.last().unwrap()
    }

    /// Makes one round of all hosts, the line and the board.
    pub(crate) fn step(&mut self) {
        let now = u64::try_from(self.start.elapsed().as_micros()).unwrap();
        for host in self.hosts.iter_mut().filter(|host| host.awake) {
            while let Some(frame) = host.poll(now) {
                if let Some((_, message)) = frame::open::<ToDevice<'_>>(&frame)
                    && let ToDevice::Item { item, .. } = message
                    && let Item::Setpoint(setpoint) = item
                {
                    self.sent = self.sent.max(Some(setpoint.number));
                }
                let bytes = stuffed(&frame);
                self.up.write(&bytes, now);
                self.spoken.extend(bytes);
            }
        }
        while let Some(byte) = self.up.read(now) {
            self.outgoing.push(byte);
        }
        let count = self.board.write(&self.outgoing);
        self.outgoing.drain(..count);
        let bytes = if self.deaf {
            Vec::new()
        } else {
            self.board.read()
        };
        // Bytes pass one at a time, and polling for each of them would take time from the emulator.
        pause();
        for byte in bytes {
            self.incoming.push(byte);
            if byte == 0 {
                let piece = core::mem::take(&mut self.incoming);
                self.hear(&piece);
                self.down.write(&piece, now);
            }
        }
        while let Some(byte) = self.down.read(now) {
            for host in self.hosts.iter_mut().filter(|host| host.awake) {
                host.byte(byte, now);
            }
        }
    }

    /// Writes bytes behind those that wait for the line.
    pub(crate) fn inject(&mut self, bytes: &[u8]) {
        self.outgoing.extend(bytes);
    }

    fn hear(&mut self, piece: &[u8]) {
        for byte in piece {
            if self.cut {
                self.cut = *byte != 0;
                continue;
            }
            let Some(frame) = self.ear.push(*byte) else {
                continue;
            };
            let message = frame::open::<ToHost<'_>>(frame);
            let Some((_, message)) = message else {
                // An unwanted reset has cut off the frame.
                self.garbled += 1;
                continue;
            };
            match message {
                ToHost::Report(report) => {
                    self.report = Some(report);
                    self.reports += 1;
                }
                ToHost::Telemetry {
                    time,
                    state,
                    rate,
                    place,
                    first: 0,
                    angles,
                } => {
                    let (numbers, rest) = angles.as_chunks();
                    assert!(rest.is_empty());
                    let numbers: Vec<f32> =
                        numbers.iter().map(|n| f32::from_le_bytes(*n)).collect();
                    let angles = (!numbers.is_empty()).then(|| numbers.try_into().unwrap());
                    let silent = self
                        .sight
                        .map_or(0, |sight| time.saturating_sub(sight.time));
                    self.hole = self.hole.max(silent);
                    let before = self.sight.replace(Sight {
                        time,
                        state,
                        rate,
                        place,
                        angles,
                    });
                    self.judge(before);
                }
                _ => {}
            }
        }
    }

    /// Checks what has to hold of all that is commanded, whatever goes wrong.
    fn judge(&mut self, before: Option<Sight>) {
        let sight = self.sight.unwrap();
        let Some(angles) = sight.angles else {
            return;
        };
        self.sights += 1;
        // Nothing is executed that was not sent, and every command equals that of a follower on this machine.
        let reached = sight.place.knot + u32::from(sight.place.into > 0.0);
        assert!(Some(reached) <= self.sent, "{sight:?} {:?}", self.sent);
        let followed = self.fold.follow(sight.place);
        assert_eq!(angles.map(f32::to_bits), followed.map(f32::to_bits));
        assert!(self.fold.residual(angles) <= CLOSURE, "{sight:?}");
        for (angle, limits) in angles.iter().zip(self.fold.limits()) {
            assert!(limits.allow(*angle), "{sight:?}");
        }
        let Some((before, Some(stood))) = before.map(|before| (before, before.angles)) else {
            return;
        };
        // The limit holds in the time of the board, plus a tick that may be missing.
        let passed = sight.time.checked_sub(before.time);
        let passed = passed.unwrap_or_else(|| panic!("reset: {before:?} {sight:?}"));
        let passed = 1e-6 * passed as f64 + 1e-3;
        for ((angle, stood), limits) in angles.iter().zip(stood).zip(self.fold.limits()) {
            let moved = (f64::from(*angle) - f64::from(stood)).abs();
            assert!(moved <= f64::from(limits.speed) * passed, "{sight:?}");
        }
        let gone = self.fold.time(sight.place) - self.fold.time(before.place);
        assert!((0.0..=passed).contains(&gone), "{before:?} {sight:?}");
    }

    /// Runs until `so` returns `true`.
    pub(crate) fn until(&mut self, so: impl Fn(&Self) -> bool) {
        while !so(self) {
            self.step();
        }
    }

    /// Returns the board's time, 0 before it has told one.
    pub(crate) fn time(&self) -> u64 {
        self.sight.map_or(0, |sight| sight.time)
    }

    /// Runs for `micros` microseconds of the board's time.
    pub(crate) fn run(&mut self, micros: u64) {
        let end = self.time() + micros;
        self.until(|world| world.time() >= end);
    }

    /// Runs for `micros` microseconds of the board's time, in which nobody reads what the board says.
    pub(crate) fn neglect(&mut self, micros: u64) {
        let start = self.board.micros();
        self.deaf = true;
        while self.board.micros() - start < micros {
            for _ in 0..10 {
                self.step();
            }
        }
        self.deaf = false;
    }

    /// Runs until the board is reset. Returns the last reading of its clock before the reset, in microseconds after
    /// `start`.
    pub(crate) fn until_reset(&mut self, start: u64) -> u64 {
        let mut last = start;
        loop {
            self.step();
            let now = self.board.micros();
            if now < last {
                return last - start;
            }
            last = now;
        }
    }

    /// Freezes the board and reads everything that it has said.
    pub(crate) fn freeze(&mut self) {
        self.board.freeze();
        let mut quiet = 0;
        while quiet < 100 {
            let bytes = self.board.read();
            quiet = if bytes.is_empty() { quiet + 1 } else { 0 };
            pause();
            self.incoming.extend(bytes);
            let whole = self.incoming.iter().rposition(|byte| *byte == 0);
            let rest = self.incoming.split_off(whole.map_or(0, |place| place + 1));
            let pieces = core::mem::replace(&mut self.incoming, rest);
            self.hear(&pieces);
        }
    }

    /// Forgets everything from before a reset: the frame that was cut off, and the clock, which has begun anew.
    pub(crate) fn forget(&mut self) {
        self.incoming.clear();
        // The next bytes may be the rest of a frame whose beginning was forgotten.
        (self.garbled, self.cut) = (0, true);
        self.ear.push(0);
        (self.report, self.sight) = (None, None);
    }

    /// Runs until a moment within the motion. A busy machine may have held the motion for a while.
    pub(crate) fn run_into(&mut self, micros: u64) {
        self.until(|world| world.sight.is_some_and(|s| s.state == State::Running));
        self.run(micros);
        self.until(|world| {
            let Sight { state, rate, .. } = world.sight.unwrap();
            assert_ne!(state, State::Done);
            state == State::Running && rate > 0.0
        });
    }

    /// Runs until the last host knows that the fold is done and the board has said so.
    pub(crate) fn finish(&mut self) {
        loop {
            self.step();
            let host = self.host();
            let phase = host.driver.sender().phase();
            assert!(!matches!(phase, Phase::Failed(_)), "{phase:?}");
            assert_eq!(host.driver.off_path(), None);
            let done = self.sight.is_some_and(|sight| sight.state == State::Done);
            if done && host.driver.is_done() {
                break;
            }
        }
        let sight = self.sight.unwrap();
        assert_eq!((sight.place, sight.angles.unwrap()), self.fold.end());
        assert_eq!(sight.rate.to_bits(), 0);
        assert_eq!(self.garbled, 0);
    }

    pub(crate) fn failure(&self, host: usize) -> Option<Failure> {
        match self.hosts[host].driver.sender().phase() {
            Phase::Failed(failure) => Some(failure),
            _ => None,
        }
    }
}

impl Drop for World<'_> {
    fn drop(&mut self) {
        if std::thread::panicking() {
            let phases: Vec<_> = self.hosts.iter().map(|h| h.driver.sender()).collect();
            eprintln!("{:?}\n{:?}\n{phases:?}", self.sight, self.report);
        }
    }
}
