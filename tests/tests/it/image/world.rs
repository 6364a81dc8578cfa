//! Hosts, a line with faults and a board, whose every word is judged in the board's own time.

use std::time::Instant;

use foldpath_core::follower::{Place, Reason, State};
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

/// A host's patience is not tested here: the machine may be busy, and the board's time goes up to six times as fast as
/// that of a machine which is not.
const PATIENT: Options = Options {
    retry: 100_000,
    alive: 20_000,
    silence: 60_000_000,
};

pub(crate) fn rng(seed: u64) -> Pcg64 {
    Pcg64::new(u128::from(seed), 7)
}

/// Microseconds in the midst of the path, which takes more than two seconds.
pub(crate) fn moment(seed: u64) -> u64 {
    100_000 + rng(900 + seed).next_u64() % 1_400_000
}

/// A message as it is on the line.
pub(crate) fn stuffed(frame: &[u8]) -> Vec<u8> {
    let mut bytes = Vec::new();
    cobs::encode(frame, |byte| bytes.push(byte));
    bytes
}

/// The library's host.
pub(crate) struct Host<'a> {
    pub(crate) driver: Driver<'a>,
    /// Whether it speaks and listens.
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

/// What telemetry said last.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Sight {
    pub(crate) time: u64,
    pub(crate) state: State,
    pub(crate) rate: f32,
    pub(crate) place: Place<f32>,
    pub(crate) angles: Option<[f32; 2]>,
}

/// All of it. Everything that the board says is judged before the line's faults befall it.
pub(crate) struct World<'a> {
    pub(crate) board: Board,
    pub(crate) hosts: Vec<Host<'a>>,
    pub(crate) up: Line<Pcg64>,
    pub(crate) down: Line<Pcg64>,
    /// All frames of hosts, as they are on the line.
    pub(crate) spoken: Vec<u8>,
    pub(crate) report: Option<Report>,
    /// Number of reports.
    pub(crate) reports: u64,
    pub(crate) sight: Option<Sight>,
    /// Telemetry that was judged.
    pub(crate) sights: u64,
    /// What the board said that is no message.
    pub(crate) garbled: u64,
    /// The longest that it said nothing, in its own time.
    pub(crate) hole: u64,
    /// Whether nobody takes what it says.
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

    /// A host comes.
    pub(crate) fn greet(&mut self, persistence: Persistence) {
        let id = 1000 + 7 * u32::try_from(self.hosts.len()).unwrap();
        self.hosts.push(Host {
            driver: Driver::new(self.fold.items(), persistence, id, PATIENT),
            awake: true,
            reasons: Vec::new(),
        });
    }

    pub(crate) fn host(&self) -> &Host<'a> {
        self.hosts.last().unwrap()
    }

    /// One round of everything.
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
        // Bytes come and go one by one: whoever looks for each takes the emulator's time.
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

    /// Writes bytes behind what waits for the line.
    pub(crate) fn inject(&mut self, bytes: &[u8]) {
        self.outgoing.extend(bytes);
    }

    fn hear(&mut self, piece: &[u8]) {
        for byte in piece {
            let Some(frame) = self.ear.push(*byte) else {
                continue;
            };
            let message = frame::open::<ToHost<'_>>(frame);
            let Some((_, message)) = message else {
                // Cut off by a reset that was not asked for.
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

    /// What has to be true of all that is commanded, whatever went wrong.
    fn judge(&mut self, before: Option<Sight>) {
        let sight = self.sight.unwrap();
        let Some(angles) = sight.angles else {
            return;
        };
        self.sights += 1;
        // Nothing is executed that was not sent, and what is, is what this machine makes of it.
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
        // In the time of the board, of which a tick may be missing.
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

    /// Runs until something is so.
    pub(crate) fn until(&mut self, so: impl Fn(&Self) -> bool) {
        while !so(self) {
            self.step();
        }
    }

    /// The board's time, once it has told one.
    pub(crate) fn time(&self) -> u64 {
        self.sight.map_or(0, |sight| sight.time)
    }

    /// Runs for so many microseconds of the board's time.
    pub(crate) fn run(&mut self, micros: u64) {
        let end = self.time() + micros;
        self.until(|world| world.time() >= end);
    }

    /// Runs for so many microseconds of the board's time, in which nobody takes what it says.
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

    /// Runs until the board is reset; returns how many microseconds behind `start`, on its clock, it still was not.
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

    /// Freezes the board and hears all that it has said.
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

    /// The board was reset: what it was about to say was cut off, and its clock began anew.
    pub(crate) fn forget(&mut self) {
        self.incoming.clear();
        self.garbled = 0;
        self.ear.push(0);
        (self.report, self.sight) = (None, None);
    }

    /// Runs until a moment in the midst of the motion, which a busy machine may have held for a while.
    pub(crate) fn run_into(&mut self, micros: u64) {
        self.until(|world| world.sight.is_some_and(|s| s.state == State::Running));
        self.run(micros);
        self.until(|world| {
            let Sight { state, rate, .. } = world.sight.unwrap();
            assert_ne!(state, State::Done);
            state == State::Running && rate > 0.0
        });
    }

    /// Runs until the last host knows that the fold is done, and the board has told so.
    pub(crate) fn finish(&mut self) {
        loop {
            self.step();
            let host = self.host();
            let phase = host.driver.sender().phase();
            assert!(!matches!(phase, Phase::Failed(_)), "{phase:?}");
            assert_eq!(host.driver.astray(), None);
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
