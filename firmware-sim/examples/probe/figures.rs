//! Measures the cost of the controller's work, in counts of whatever clock is given: on the emulated board,
//! instructions.

use core::fmt::Write;
use core::hint::black_box;

use foldpath_core::follower::{FollowerPosition, State};
use foldpath_core::least_squares::{ClosureProblem, Limits};
use foldpath_core::project::project;
use foldpath_core::trajectory::TrajectoryView;
use foldpath_core::wire::cobs;
use foldpath_core::wire::key::Key;
use foldpath_core::wire::message::Command;
use foldpath_core::wire::path::PathItems;
use foldpath_core::wire::protection::{Keyed, Protection, Unkeyed};
use foldpath_core::wire::sender::{Options, Sender};
use foldpath_core::{
    DenseNormalEquations, GroupId, HalfAngle, Membership, Scalar, Spoke, StarView, StarsView,
    closure,
};
use nalgebra::Vector3;

use crate::probe::{self, ANY, Failure, MIURA, OPEN, WATERBOMB};
use foldpath_controller::retained::{self, HEAD};
use foldpath_controller::{Controller, Settings};

/// Number of ticks over which a mean is taken.
const TICKS: u32 = 256;
/// Number of hinges of the largest sheet, a Miura fold of 24 x 24 faces.
const HINGES: usize = 1104;

static MEMBERSHIPS: [Membership; HINGES] = [Membership {
    group: GroupId(1),
    negative: true,
}; HINGES];

/// A clock, and the counts that reading it takes.
struct Meter<C> {
    count: C,
    overhead: u32,
}

impl<C: FnMut() -> u32> Meter<C> {
    fn new(count: C) -> Self {
        let mut meter = Self { count, overhead: 0 };
        meter.overhead = meter.measure(|| ());
        meter
    }

    /// Returns the counts that `work` takes.
    fn measure<R>(&mut self, work: impl FnOnce() -> R) -> u32 {
        let before = (self.count)();
        black_box(work());
        let passed = (self.count)().wrapping_sub(before);
        passed.saturating_sub(self.overhead)
    }
}

/// Prints the figures, one on each line: `cost`, the name of the work, and the counts.
/// Fails if a configuration does not close, a path does not run, or the output fails.
pub(crate) fn run(out: &mut impl Write, count: impl FnMut() -> u32) -> Result<(), Failure> {
    let mut meter = Meter::new(count);
    let mut tell = |what: &str, cost: u32| {
        let line = writeln!(out, "cost {what} {cost}");
        line.map_err(|_| Failure::Output)
    };
    tell("closure-of-degree-4", closes(&mut meter)?)?;
    tell("levenberg-marquardt-step-of-6-unknowns", step(&mut meter)?)?;
    let stars = StarsView::new(MIURA.spokes, MIURA.ends, MIURA.rates.len());
    let stars = stars.ok_or(Failure::Size)?;
    let path = probe::follow(&MIURA, stars, &mut Nowhere)?;
    for (hinges, what) in [
        (6, "tick-of-6-hinges"),
        (64, "tick-of-64-hinges"),
        (HINGES, "tick-of-1104-hinges"),
    ] {
        let costs = stream::<Unkeyed>(&mut meter, stars, path.view()?, hinges, None)?;
        let [tick, record, setpoint] = costs;
        tell(what, tick)?;
        if hinges == HINGES {
            tell("record-of-2-groups", record)?;
        }
        if hinges == HINGES {
            tell("setpoint-from-its-frame-to-the-answer", setpoint)?;
        }
    }
    let key = Key::new([0x5a; Key::SIZE]);
    let keyed = stream::<Keyed>(&mut meter, stars, path.view()?, HINGES, Some(key));
    let [_, _, setpoint] = keyed?;
    tell("setpoint-with-a-key-from-its-frame-to-the-answer", setpoint)?;
    let bytes = [0x5a; 256];
    for (length, what) in [(40, "tag-of-40-bytes"), (256, "tag-of-256-bytes")] {
        let frame = black_box(bytes.get(..length).unwrap_or(&[]));
        tell(what, meter.measure(|| key.tag(frame)))?;
    }
    Ok(())
}

/// An output that discards everything.
struct Nowhere;

impl Write for Nowhere {
    fn write_str(&mut self, _: &str) -> core::fmt::Result {
        Ok(())
    }
}

/// Measures the test of whether a vertex closes, from its four angles.
fn closes(meter: &mut Meter<impl FnMut() -> u32>) -> Result<u32, Failure> {
    let mut spokes = [probe::spoke(0, [1.0, 0.0]); 4];
    for (group, (spoke, miura)) in (0..).zip(spokes.iter_mut().zip(MIURA.spokes)) {
        *spoke = Spoke {
            group: GroupId(group),
            ..*miura
        };
    }
    let angles = black_box([0.5, 1.0, 0.5, 1.0]);
    let mut half_angles = [HalfAngle::default(); 4];
    Ok(meter.measure(|| {
        closure::half_angles(&angles, &mut half_angles);
        closure::closes(StarView { spokes: &spokes }, &half_angles, black_box(OPEN))
    }))
}

/// Measures a step of the solver at a vertex of six groups: factorisation, solve, and evaluation of the new point.
fn step(meter: &mut Meter<impl FnMut() -> u32>) -> Result<u32, Failure> {
    let mut spokes = [probe::spoke(0, [1.0, 0.0]); 6];
    for (group, (spoke, waterbomb)) in (0..).zip(spokes.iter_mut().zip(WATERBOMB.spokes)) {
        *spoke = Spoke {
            group: GroupId(group),
            ..*waterbomb
        };
    }
    let stars = StarsView::new(&spokes, &[6], 6).ok_or(Failure::Size)?;
    let (mut half_angles, mut columns) = ([HalfAngle::default(); 6], [Vector3::default(); 6]);
    let problem = ClosureProblem::new(stars, &mut half_angles, &mut columns);
    let mut problem = problem.ok_or(Failure::Size)?;
    let mut memory = [0.0; DenseNormalEquations::<f32>::memory(6)];
    let equations = DenseNormalEquations::new(6, &mut memory);
    let mut equations = equations.ok_or(Failure::Size)?;
    // The closed form of this vertex, perturbed a little.
    let (m, d) = (0.8, -1.077);
    let mut angles = black_box([d + 0.02, m, d, d, m, d - 0.01]);
    // Counts for the linearisation at the start, which is not part of a step.
    let start = meter.measure(|| problem.linearise(&angles, &mut equations));
    let mut steps = 0;
    let cost = meter.measure(|| {
        let closure = f32::CLOSURE_TOLERANCE;
        let workspace = &mut [0.0; 18];
        let done = project(
            &mut problem,
            &mut equations,
            Limits::HalfTurn,
            closure,
            &mut angles,
            workspace,
        );
        steps = done.report.iterations;
    });
    let cost = cost.saturating_sub(start);
    cost.checked_div(steps).ok_or(Failure::Open)
}

/// Ticks and drives all hinges, which are where they are commanded to be. Not inlined, as in the main loop of a board.
#[inline(never)]
fn tick<P: Protection>(device: &mut Controller<2, HINGES, 4, 16, P>, now: u64) {
    device.tick(now);
    device.drive(|_, _, target| target.map(|target| target.angle.into()));
}

/// Measures a tick that drives this number of `hinges`, the record that the tick keeps, and the reception, check and
/// answer of a setpoint, over a link with a key if there is one; returns the mean of each.
// Not inlined, so that the stack of one thing at a time is in use.
#[inline(never)]
fn stream<P: Protection>(
    meter: &mut Meter<impl FnMut() -> u32>,
    stars: StarsView<'_, f32>,
    path: TrajectoryView<'_, f32>,
    hinges: usize,
    key: Option<Key>,
) -> Result<[u32; 3], Failure> {
    let hinges = MEMBERSHIPS.get(..hinges).ok_or(Failure::Size)?;
    let limits = [ANY; 2];
    let items = PathItems::new(
        path,
        &limits,
        hinges,
        stars,
        OPEN,
        FollowerPosition::default(),
    );
    let items = items.ok_or(Failure::Size)?;
    let mut sender = Sender::new(1, Options::default());
    if let Some(key) = key {
        sender = sender.with_key(key, 1);
    }
    let mut answers = cobs::Deframer::<256>::default();
    let settings = Settings::new([1, 0], |_| ANY);
    let mut device =
        Controller::<2, HINGES, 4, 16, P>::protected(settings, P::with_key(key.into()));
    let (mut scratch, mut buffer) = ([0; 256], [0; 256]);
    let (mut ticks, mut setpoints, mut told) = ((0, 0), (0, 0), false);
    let (mut records, mut record): (_, retained::Bytes<2>) = ((0, 0), ([0; HEAD], [[0; 4]; 2]));
    for now in (1..=3000).map(|tick| 1000 * tick) {
        let room = device.follower().room();
        let cost = meter.measure(|| tick(&mut device, now));
        if device.follower().state() == State::Running {
            ticks = (ticks.0 + cost, ticks.1 + 1);
            let cost = meter.measure(|| device.record(1, ticks.1).seal(0, &mut record));
            records = (records.0 + cost, records.1 + 1);
        }
        let frame = sender.poll(now, &items, &mut scratch, &mut buffer);
        let mut bytes = heapless::Vec::<u8, 300>::new();
        if let Some(frame) = frame {
            cobs::encode(frame, |byte| {
                let _ = bytes.push(byte);
            });
        }
        let cost = meter.measure(|| {
            bytes.iter().for_each(|byte| device.byte(*byte, now));
            device.poll(now);
        });
        // Leaves out frames at times of telemetry, and the first setpoint, for which no segment is checked.
        if device.follower().room() < room && room < 16 && !now.is_multiple_of(20_000) {
            setpoints = (setpoints.0 + cost, setpoints.1 + 1);
        }
        while let Some(byte) = device.take() {
            if let Some(frame) = answers.push(byte) {
                sender.receive(frame, now);
            }
        }
        let full = device.follower().state() == State::Ready && device.follower().room() == 0;
        if full {
            told |= sender.command(if told { Command::Start } else { Command::Stand });
        }
        if ticks.1 == TICKS {
            let mean = |(sum, count): (u32, u32)| sum.checked_div(count).ok_or(Failure::Stream);
            return Ok([mean(ticks)?, mean(records)?, mean(setpoints)?]);
        }
    }
    Err(Failure::Stream)
}
