//! Tests a session over a slow serial line: 9,600 baud behind an adapter that waits for 16 ms, with 1 % of the frames lost, and
//! over one with an adapter that takes 4,096 bytes each way before it sends them.

use core::cell::Cell;
use std::io;
use std::path::Path;

use crate::common::folder;
use crate::session;
use foldpath::stream::{Link, Options, Outcome, Sim, StreamPath, Wish};
use foldpath_core::follower::{Reason, State};
use foldpath_firmware_sim::faults::Faults;

/// Lines that are tried, each with faults of its own.
const SEEDS: u64 = 40;

/// A controller behind a slow line, and the times of what happens to it, microseconds.
struct Slow<'a> {
    sim: Sim,
    now: &'a Cell<u64>,
    begun: Option<u64>,
    done: Option<u64>,
    held: Option<u64>,
    rested: Option<u64>,
    /// Largest number of bytes that waited on the line to the controller, and on the line back.
    waited: [f64; 2],
}

/// Bytes that the adapter takes.
const BUFFERS: [u32; 2] = [0, 4096];

impl<'a> Slow<'a> {
    fn fast(now: &'a Cell<u64>) -> Self {
        Self {
            sim: Sim::new(),
            now,
            begun: None,
            done: None,
            held: None,
            rested: None,
            waited: [0.0; 2],
        }
    }

    fn new(now: &'a Cell<u64>, seed: u64, buffer: u32) -> Self {
        let line = Faults {
            drop: 0.01,
            delay: 16_000,
            speed: 960.0,
            buffer,
            ..Faults::default()
        };
        Self {
            sim: Sim::new().with_line(line, seed),
            ..Self::fast(now)
        }
    }
}

impl Link for Slow<'_> {
    fn now(&self) -> u64 {
        self.sim.now()
    }

    fn is_free(&self) -> bool {
        self.sim.is_free()
    }

    fn write(&mut self, frame: &[u8]) -> io::Result<()> {
        self.sim.write(frame)
    }

    fn read(&mut self) -> io::Result<Option<u8>> {
        self.sim.read()
    }

    fn wait(&mut self) -> io::Result<()> {
        self.sim.wait()?;
        let now = self.sim.now();
        self.now.set(now);
        let waiting = self.sim.waiting();
        for (most, now) in self.waited.iter_mut().zip(waiting) {
            *most = most.max(now);
        }
        let follower = self.sim.device().follower();
        match follower.state() {
            State::Running => _ = self.begun.get_or_insert(now),
            State::Done => _ = self.done.get_or_insert(now),
            _ => {}
        }
        // If the word to hold was lost, the motion holds because the host says nothing else.
        if matches!(follower.reason(), Reason::HoldCommand | Reason::Silence) {
            self.held.get_or_insert(now);
            if follower.rate() <= 0.0 {
                self.rested.get_or_insert(now);
            }
        }
        Ok(())
    }
}

fn miura() -> StreamPath {
    let folder = folder();
    folder.done("generate miura --rows 24 --cols 24 -o miura.fold");
    folder.done("plan miura.fold -o path.fold");
    folder.done("export path.fold --to traj -o path.traj");
    let bytes = std::fs::read(folder.path("path.traj")).unwrap();
    StreamPath::read(&bytes, Path::new("path.traj")).unwrap()
}

fn options(seed: u64) -> Options {
    Options::default().with(|it| it.id = 7 + u32::try_from(seed).unwrap())
}

/// The session sends a sheet of 1104 hinges and its setpoints, and waits for the end. The motion is that of the controller,
/// from its start to its end. A frame that got lost costs a part of a second, so that one session in ten may take longer.
#[test]
fn a_fold_over_a_slow_line_takes_three_tenths_longer_than_its_motion() {
    let path = miura();
    let now = Cell::new(0);
    let mut fast = Slow::fast(&now);
    session::session(&mut fast, &path, options(0), &|_| Wish::Run);
    let motion = (fast.done.unwrap() - fast.begun.unwrap()) as f64 / 1e6;
    // A line with a buffer is compared with the bare one.
    let mut base = motion;
    for buffer in BUFFERS {
        let mut waited = [0.0_f64; 2];
        let mut times: Vec<f64> = (0..SEEDS)
            .map(|seed| {
                let now = Cell::new(0);
                let mut link = Slow::new(&now, seed, buffer);
                let (summary, _) =
                    session::session(&mut link, &path, options(seed), &|_| Wish::Run);
                assert_eq!(summary.outcome, Outcome::Done, "{seed}: {summary:?}");
                // Nothing is sent again but what may have got lost, and behind a buffer the first items, which it takes at once.
                let most = if buffer == 0 { 6 } else { 12 };
                assert!(summary.retransmitted <= most, "{seed}: {summary:?}");
                for (most, now) in waited.iter_mut().zip(link.waited) {
                    *most = most.max(now);
                }
                summary.duration as f64 / 1e6
            })
            .collect();
        times.sort_by(f64::total_cmp);
        let [middle, most, worst] = [1, 2, 3].map(|part| {
            let part = [times.len() / 2, times.len() * 9 / 10, times.len()][part - 1];
            times[part.min(times.len() - 1)]
        });
        let end = path.times().last().unwrap();
        println!(
            "buffer of {buffer} bytes: path {end:.3} s, motion {motion:.3} s, session: median {middle:.3} s, nine in ten \
             {most:.3} s, worst {worst:.3} s of {SEEDS}; at most {waited:.0?} bytes waited on the line"
        );
        assert!(
            most <= 1.3 * base && worst <= 1.5 * base,
            "{times:?} of {base}"
        );
        base = most;
        assert!(waited.iter().all(|bytes| *bytes <= 500.0), "{waited:?}");
    }
}

/// The clock brakes from 1 to 0 at 4 a second, in 250 ms.
#[test]
fn a_hold_over_a_slow_line_is_at_rest_within_half_a_second_of_its_arrival() {
    let path = miura();
    let runs = BUFFERS.map(|buffer| (0..SEEDS).map(move |seed| (seed, buffer)));
    let mut pairs: Vec<[u64; 2]> = runs
        .into_iter()
        .flatten()
        .map(|(seed, buffer)| {
            let now = Cell::new(0);
            let mut link = Slow::new(&now, seed, buffer);
            // At different times within a round of the line, and of telemetry.
            let press = 3_500_000 + 7_300 * seed;
            let wish = |_: &[_]| {
                if now.get() < press {
                    Wish::Run
                } else {
                    Wish::Stop
                }
            };
            let (summary, heard) = session::session(&mut link, &path, options(seed), &wish);
            assert_eq!(summary.outcome, Outcome::Stopped, "{seed}: {summary:?}");
            assert!(heard.iter().any(|told| told.state == State::Running));
            let [held, rested] = [link.held, link.rested].map(Option::unwrap);
            [rested - held, rested - press]
        })
        .collect();
    for (what, index) in [("arrival of the hold", 0), ("press of the key", 1)] {
        pairs.sort_by_key(|pair| pair[index]);
        let [middle, worst] = [pairs.len() / 2, pairs.len() - 1].map(|k| pairs[k][index] / 1000);
        println!(
            "at rest after the {what}: median {middle} ms, worst {worst} ms of {} lines",
            pairs.len()
        );
        assert!(worst <= [500, 1000][index], "{pairs:?}");
    }
}
