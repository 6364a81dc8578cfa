//! A host and a board whose time passes as fast as the emulator can make it. Everything that the board tells is kept.

use std::collections::HashMap;
use std::time::Instant;

use foldpath_core::follower::{FollowerPosition, State};
use foldpath_core::wire::cobs::{self, Deframer};
use foldpath_core::wire::driver::{Driver, Persistence};
use foldpath_core::wire::frame;
use foldpath_core::wire::message::{Report, ToHost};
use foldpath_core::wire::path::PathItems;
use foldpath_core::wire::sender::{Options, Phase};

use super::board::Board;

/// The image with room for every pattern.
pub(crate) const IMAGE: &str = "foldpath-mps2";

/// Options of a host whose board has more than 30 ms of its own time in a millisecond: it speaks often. The line loses
/// nothing, and a sheet of many groups takes it a second, so that nothing is sent again before.
const HASTY: Options = Options {
    node: 0,
    max_retry: 5_000_000,
    retry: 2_000_000,
    alive: 4000,
    silence: 60_000_000,
    // The emulated line has no buffer, and telemetry is judged every 20 ms.
    slow_trip: u64::MAX,
};

/// Telemetry of one moment, all its pieces together.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Told {
    pub(crate) time: u64,
    pub(crate) state: State,
    pub(crate) rate: f32,
    pub(crate) place: FollowerPosition<f32>,
    /// Angle of each group, radians; none while it is not known where the sheet stands.
    pub(crate) angles: Vec<f32>,
}

pub(crate) struct Rig<'a> {
    pub(crate) board: Board,
    pub(crate) host: Option<Driver<'a>>,
    pub(crate) report: Option<Report>,
    /// Telemetry of the present host, in order, without what is not yet complete.
    pub(crate) told: Vec<Told>,
    /// Angle of each hinge that was measured, when it was told last, radians.
    pub(crate) measured: HashMap<u32, f32>,
    /// Telemetry that is being received.
    coming: Option<Told>,
    start: Instant,
    ear: Deframer<512>,
    outgoing: Vec<u8>,
}

impl<'a> Rig<'a> {
    pub(crate) fn new(board: Board) -> Self {
        Self {
            board,
            host: None,
            report: None,
            told: Vec::new(),
            measured: HashMap::new(),
            coming: None,
            start: Instant::now(),
            ear: Deframer::default(),
            outgoing: Vec::new(),
        }
    }

    /// Replaces the host by one that sends this path. A host that is `sure` says that the sheet stands where it begins. It resumes
    /// after every silence, because a busy machine is silent for half a second of the board's time.
    pub(crate) fn greet(&mut self, items: PathItems<'a>, persistence: Persistence, sure: bool) {
        let id = 1000 + u32::try_from(self.start.elapsed().as_micros() % 1_000_000).unwrap();
        let driver = Driver::new(items, persistence, id, HASTY).unattended();
        self.host = Some(if sure { driver.confirming() } else { driver });
        self.forget();
    }

    /// Forgets what was told.
    pub(crate) fn forget(&mut self) {
        (self.report, self.coming) = (None, None);
        self.told.clear();
        // The rest of a frame whose beginning a reset has cut off is no frame.
        self.ear = Deframer::default();
    }

    /// Lets the host and the board talk for about a millisecond.
    pub(crate) fn step(&mut self) {
        let now = u64::try_from(self.start.elapsed().as_micros()).unwrap();
        if let Some(host) = &mut self.host {
            let (mut scratch, mut buffer) = ([0; 256], [0; 256]);
            while let Some(frame) = host.poll(now, &mut scratch, &mut buffer) {
                cobs::encode(frame, |byte| self.outgoing.push(byte));
            }
        }
        let count = self.board.write(&self.outgoing);
        self.outgoing.drain(..count);
        for byte in self.board.wait() {
            if let Some(host) = &mut self.host {
                host.byte(byte, now);
            }
            if let Some(bytes) = self.ear.push(byte)
                && let Some((_, message)) = frame::open::<ToHost<'_>>(bytes)
            {
                if let ToHost::Measured { first, angles, .. } = message {
                    let (angles, _) = angles.as_chunks();
                    let angles = angles.iter().map(|bytes| f32::from_le_bytes(*bytes));
                    self.measured.extend((u32::from(first)..).zip(angles));
                }
                hear(message, &mut self.report, &mut self.coming, &mut self.told);
            }
        }
    }

    /// Runs until `so`.
    ///
    /// # Panics
    /// If the host's session fails, or if it takes two minutes.
    #[track_caller]
    pub(crate) fn until(&mut self, so: impl Fn(&Self) -> bool) {
        let begin = Instant::now();
        while !so(self) {
            self.step();
            let phase = self.host.as_ref().map(|host| host.sender().phase());
            let waits = begin.elapsed().as_secs() < 120 && !matches!(phase, Some(Phase::Failed(_)));
            assert!(waits, "{phase:?} {:?} {:?}", self.report, self.told.last());
        }
    }

    /// Runs until the fold is done and the board has told so.
    #[track_caller]
    pub(crate) fn finish(&mut self) {
        self.until(|rig| {
            let told = rig
                .told
                .last()
                .is_some_and(|told| told.state == State::Done);
            told && rig.host.as_ref().is_some_and(Driver::is_done)
        });
    }

    /// Runs for some microseconds of the board's time.
    #[track_caller]
    pub(crate) fn run(&mut self, micros: u64) {
        let time = |rig: &Self| rig.told.last().map_or(0, |told| told.time);
        self.until(|rig| !rig.told.is_empty());
        let end = time(self) + micros;
        self.until(|rig| time(rig) >= end);
    }

    pub(crate) fn last(&self) -> &Told {
        self.told.last().expect("telemetry")
    }
}

/// Takes a message: a report, or a piece of telemetry of up to 48 groups.
fn hear(
    message: ToHost<'_>,
    report: &mut Option<Report>,
    coming: &mut Option<Told>,
    told: &mut Vec<Told>,
) {
    match message {
        ToHost::Report(news) => *report = Some(news),
        ToHost::Telemetry {
            time,
            state,
            rate,
            place,
            first,
            angles,
        } => {
            if first == 0 {
                told.extend(coming.take());
                let angles = Vec::new();
                *coming = Some(Told {
                    time,
                    state,
                    rate,
                    place,
                    angles,
                });
            }
            let Some(now) = coming.as_mut().filter(|now| now.time == time) else {
                return;
            };
            // A piece was lost in a reset.
            if now.angles.len() != usize::from(first) {
                *coming = None;
                return;
            }
            let (numbers, _) = angles.as_chunks();
            now.angles
                .extend(numbers.iter().map(|bytes| f32::from_le_bytes(*bytes)));
            let pieces = numbers.len() < 48;
            if pieces {
                told.extend(coming.take());
            }
        }
        _ => {}
    }
}
