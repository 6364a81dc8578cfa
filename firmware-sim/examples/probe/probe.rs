//! The probe: runs the real foldpath-core in `f32` on whatever machine this is compiled for.
//!
//! Two folds start flat and are followed step by step, as a planner would do, and are then played, as a controller
//! would. All results are printed bit by bit, so that two machines can be compared.

use core::fmt::Write;

use foldpath_core::follower::{FollowerPosition, State};
use foldpath_core::least_squares::{ClosureProblem, Limits, Options, Outcome, Report};
use foldpath_core::project::{Projection, means, project};
use foldpath_core::trajectory::TrajectoryView;
use foldpath_core::wire::cobs::{self, Deframer};
use foldpath_core::wire::message::Command;
use foldpath_core::wire::path::PathItems;
use foldpath_core::wire::protection::Unkeyed;
use foldpath_core::wire::sender::{self, Sender};
use foldpath_core::{
    DenseNormalEquations, GroupId, GroupLimits, HalfAngle, Interpolation, Membership, Objective,
    Scalar, Spoke, StarsView, gradient, levenberg_marquardt,
};
use heapless::Vec;
use nalgebra::Vector3;

use foldpath_controller::{Controller, FRAME, Settings};

/// Number of steps of a walk.
pub(crate) const STEPS: u16 = 25;
/// Turn of the first group in a step, 4 degrees in radians, and duration of a step, seconds: the group turns at 1
/// rad/s.
pub(crate) const STEP: f32 = core::f32::consts::PI / 45.0;

/// Number of samples in a step.
const SAMPLES: u16 = 4;
/// Largest number of groups of a fold here.
const GROUPS: usize = 4;
/// Largest number of spokes of a star here.
const DEGREE: usize = 6;
/// Number of knots of a path: the flat state, and one for each step.
const KNOTS: usize = STEPS as usize + 1;

/// Largest closure residual of the streamed paths. The first segment of the waterbomb leaves the flat state, which is
/// singular, and a cubic over a step of 4 degrees has such a residual there.
pub(crate) const OPEN: f32 = 1e-4;
/// No limits.
pub(crate) const ANY: GroupLimits = GroupLimits {
    lower: -core::f32::consts::PI,
    upper: core::f32::consts::PI,
    speed: f32::INFINITY,
    acceleration: f32::INFINITY,
};
/// Error of the measured angles, radians.
const OFF: f32 = 0.02;
/// Number of ticks after which a controller should have reached the end of the path.
const MOST_TICKS: u32 = 10_000;

/// The knots of a walk, with the angles and rates of their groups.
#[derive(Default)]
pub(crate) struct Path {
    groups: usize,
    spans: Vec<f32, KNOTS>,
    angles: Vec<f32, { KNOTS * GROUPS }>,
    rates: Vec<f32, { KNOTS * GROUPS }>,
}

impl Path {
    pub(crate) fn view(&self) -> Result<TrajectoryView<'_, f32>, Failure> {
        let (spans, angles, rates) = (&self.spans, &self.angles, &self.rates);
        let kind = Interpolation::Hermite;
        let view = TrajectoryView::new(kind, self.groups, spans, angles, rates, &[]);
        view.map_err(|_| Failure::Knot)
    }
}

/// Reason why the probe stopped.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Failure {
    /// A fold is ill-formed or larger than the memory for it.
    Size,
    /// The solver did not close a configuration.
    Open,
    /// The trajectory did not take a knot.
    Knot,
    /// The controller did not reach the end of a path.
    Stream,
    /// The output did not take a line.
    Output,
}

/// A fold with one degree of freedom: its stars, and the rates (rad/s) at which it leaves the flat state. The first
/// rate is 1.
pub(crate) struct Fold<'a> {
    name: &'a str,
    pub(crate) spokes: &'a [Spoke<f32>],
    pub(crate) ends: &'a [u32],
    pub(crate) rates: &'a [f32],
}

const DIAGONAL: f32 = core::f32::consts::FRAC_1_SQRT_2;
const SIN_60: f32 = 0.866_025_4;

/// Miura's fold with 60 degree sectors. Groups: the zigzag creases, the straight ones.
pub(crate) const MIURA: Fold<'_> = Fold {
    name: "miura",
    spokes: &[
        Spoke {
            negative: true,
            ..spoke(1, [1.0, 0.0])
        },
        spoke(0, [0.5, SIN_60]),
        spoke(1, [-1.0, 0.0]),
        spoke(0, [0.5, -SIN_60]),
    ],
    ends: &[4],
    rates: &[1.0, 0.5],
};

/// The waterbomb tessellation: its centres, its corners and the crossings of its long creases.
/// Groups: m, r, d, b of the closed form m = 2 atan t, r = 2 atan 2t, d = -2 atan √2 t, b = 2r - m.
pub(crate) const WATERBOMB: Fold<'_> = Fold {
    name: "waterbomb",
    spokes: &[
        spoke(2, [DIAGONAL, DIAGONAL]),
        spoke(0, [0.0, 1.0]),
        spoke(2, [-DIAGONAL, DIAGONAL]),
        spoke(2, [-DIAGONAL, -DIAGONAL]),
        spoke(0, [0.0, -1.0]),
        spoke(2, [DIAGONAL, -DIAGONAL]),
        spoke(1, [1.0, 0.0]),
        spoke(2, [DIAGONAL, DIAGONAL]),
        spoke(3, [0.0, 1.0]),
        spoke(2, [-DIAGONAL, DIAGONAL]),
        spoke(1, [-1.0, 0.0]),
        spoke(0, [0.0, -1.0]),
        spoke(3, [0.0, 1.0]),
        spoke(3, [0.0, -1.0]),
    ],
    ends: &[6, 12, 14],
    rates: &[1.0, 2.0, -core::f32::consts::SQRT_2, 3.0],
};

pub(crate) const fn spoke(group: u32, direction: [f32; 2]) -> Spoke<f32> {
    Spoke {
        group: GroupId(group),
        negative: false,
        direction,
    }
}

/// Follows and plays all folds.
///
/// Each line names the fold and the kind of its numbers, and gives each number as the 8 hexadecimal digits of its bits:
///
/// - `gradient` and `solve`: iterations, evaluations, residual, then the angles;
/// - `knot`: the angles, then the rates;
/// - `sample`: the two objectives, then the angles;
/// - `project`: the numbers of `solve` for angles measured with an error, with the largest change before the angles;
/// - `tick`: the angles and rates commanded by a controller to which the path is sent, at every 16th tick.
///
/// Fails if a configuration does not close, or the output fails.
// Not inlined, so that its stack is free for whatever runs behind it.
#[inline(never)]
pub(crate) fn run(out: &mut impl Write) -> Result<(), Failure> {
    for fold in [MIURA, WATERBOMB] {
        let stars = StarsView::new(fold.spokes, fold.ends, fold.rates.len());
        let stars = stars.ok_or(Failure::Size)?;
        let path = follow(&fold, stars, out)?;
        play(&fold, stars, path.view()?, out)?;
        stream(&fold, stars, path.view()?, out)?;
    }
    Ok(())
}

/// Walks from the flat state: predicts with the rates, corrects with a solver, and turns the rates into the motion that
/// the new configuration allows.
pub(crate) fn follow(
    fold: &Fold<'_>,
    stars: StarsView<'_, f32>,
    out: &mut impl Write,
) -> Result<Path, Failure> {
    let n = stars.unknowns();
    let (mut angles, mut rates, mut other) = ([0.0; GROUPS], [0.0; GROUPS], [0.0; GROUPS]);
    let angles = angles.get_mut(..n).ok_or(Failure::Size)?;
    let rates = rates.get_mut(..n).ok_or(Failure::Size)?;
    let other = other.get_mut(..n).ok_or(Failure::Size)?;
    copy(fold.rates, rates);

    let mut half_angles = [HalfAngle::default(); GROUPS];
    let mut columns = [Vector3::default(); DEGREE];
    let problem = ClosureProblem::new(stars, &mut half_angles, &mut columns);
    let mut problem = problem.ok_or(Failure::Size)?;
    let mut memory = [0.0; DenseNormalEquations::<f32>::memory(GROUPS)];
    let equations = DenseNormalEquations::new(n, &mut memory);
    let mut equations = equations.ok_or(Failure::Size)?;
    let mut workspace = [0.0; 3 * GROUPS];
    let (limits, options) = (Limits::HalfTurn, Options::default());

    let mut path = Path {
        groups: n,
        ..Path::default()
    };
    for step in 0..=STEPS {
        if step > 0 {
            for (angle, rate) in angles.iter_mut().zip(&*rates) {
                *angle += rate * STEP;
            }
            copy(angles, other);
            let report = gradient::solve(&mut problem, limits, &options, other, &mut workspace);
            line(out, fold, "gradient", words(&report).chain(bits(other)))?;
            let report = levenberg_marquardt::solve(
                &mut problem,
                &mut equations,
                limits,
                &options,
                angles,
                &mut workspace,
            );
            line(out, fold, "solve", words(&report).chain(bits(angles)))?;
            if report.outcome != Outcome::Converged {
                return Err(Failure::Open);
            }
            problem.linearise(angles, &mut equations);
            if !levenberg_marquardt::project_on_motions(&mut equations, rates) {
                return Err(Failure::Open);
            }
            let first = rates.first().copied().ok_or(Failure::Size)?;
            for rate in rates.iter_mut() {
                *rate /= first;
            }
        }
        line(out, fold, "knot", bits(angles).chain(bits(rates)))?;
        let span = path.spans.push(f32::from(step.min(1)) * STEP);
        let nodes = path
            .angles
            .extend_from_slice(angles)
            .and(path.rates.extend_from_slice(rates));
        span.map_err(|_| Failure::Knot)
            .and(nodes.map_err(|_| Failure::Knot))?;
    }
    Ok(path)
}

/// Samples the motion between the knots and its closure residuals.
fn play(
    fold: &Fold<'_>,
    stars: StarsView<'_, f32>,
    path: TrajectoryView<'_, f32>,
    out: &mut impl Write,
) -> Result<(), Failure> {
    let mut angles = [0.0; GROUPS];
    let angles = angles.get_mut(..path.groups()).ok_or(Failure::Size)?;
    let mut scratch = [HalfAngle::default(); GROUPS];
    for tick in 0..=STEPS * SAMPLES {
        let place = FollowerPosition {
            knot: 0,
            into: f32::from(tick) * STEP / f32::from(SAMPLES),
        };
        path.sample(place, angles);
        let mut value = |objective: Objective| {
            let value = objective.value(stars, angles, &mut scratch);
            value.ok_or(Failure::Size)
        };
        let values = [value(Objective::Max)?, value(Objective::Sum)?];
        line(out, fold, "sample", bits(&values).chain(bits(angles)))?;
    }
    Ok(())
}

/// Sends the path over a line without faults to a controller, which runs it at full speed.
fn stream(
    fold: &Fold<'_>,
    stars: StarsView<'_, f32>,
    path: TrajectoryView<'_, f32>,
    out: &mut impl Write,
) -> Result<(), Failure> {
    let limits = [ANY; GROUPS];
    let limits = limits.get(..path.groups()).ok_or(Failure::Size)?;
    let place = FollowerPosition::default();
    let items = PathItems::new(path, limits, &[], stars, OPEN, place).ok_or(Failure::Size)?;
    let mut sender = Sender::new(1, sender::Options::default());
    let mut answers = Deframer::<{ FRAME }>::default();
    let mut device =
        Controller::<GROUPS, 1, 16, 8>::protected(Settings::new([1, 0], |_| ANY), Unkeyed);
    let (mut scratch, mut buffer) = ([0; 256], [0; 256]);
    let (mut now, mut told) = (0, false);
    for tick in 0_u32.. {
        now += 1000;
        if let Some(frame) = sender.poll(now, &items, &mut scratch, &mut buffer) {
            cobs::encode(frame, |byte| device.byte(byte, now));
        }
        device.tick(now);
        device.poll(now);
        while let Some(byte) = device.take() {
            if let Some(frame) = answers.push(byte) {
                sender.receive(frame, now);
            }
        }
        let state = device.follower().state();
        if state == State::Ready && device.follower().room() == 0 {
            told |= sender.command(if told { Command::Start } else { Command::Stand });
        }
        let (angles, rates) = (device.follower().angles(), device.follower().rates());
        if tick.is_multiple_of(16) && state == State::Running {
            line(out, fold, "tick", bits(angles).chain(bits(rates)))?;
        }
        if state == State::Done {
            line(out, fold, "tick", bits(angles).chain(bits(rates)))?;
            return measure(fold, stars, angles, out);
        }
        if tick == MOST_TICKS {
            break;
        }
    }
    Err(Failure::Stream)
}

/// Projects a configuration that was measured with an error back to a closed one.
fn measure(
    fold: &Fold<'_>,
    stars: StarsView<'_, f32>,
    angles: &[f32],
    out: &mut impl Write,
) -> Result<(), Failure> {
    let (mut measured, mut counts) = ([0.0; GROUPS], [0.0; GROUPS]);
    let measured = measured.get_mut(..angles.len()).ok_or(Failure::Size)?;
    let counts = counts.get_mut(..angles.len()).ok_or(Failure::Size)?;
    let hinges = (0..).zip(angles).map(|(group, &angle)| {
        let membership = Membership {
            group: GroupId(group),
            negative: group == 1,
        };
        (membership, membership.apply(angle + OFF))
    });
    means(hinges, measured, counts).ok_or(Failure::Size)?;
    let mut half_angles = [HalfAngle::default(); GROUPS];
    let mut columns = [Vector3::default(); DEGREE];
    let problem = ClosureProblem::new(stars, &mut half_angles, &mut columns);
    let mut memory = [0.0; DenseNormalEquations::<f32>::memory(GROUPS)];
    let equations = DenseNormalEquations::new(angles.len(), &mut memory);
    let Projection { report, moved } = project(
        &mut problem.ok_or(Failure::Size)?,
        &mut equations.ok_or(Failure::Size)?,
        Limits::HalfTurn,
        f32::CLOSURE_TOLERANCE,
        measured,
        &mut [0.0; 3 * GROUPS],
    );
    let words = words(&report).chain([moved.to_bits()]);
    line(out, fold, "project", words.chain(bits(measured)))?;
    let closed = report.outcome == Outcome::Converged;
    closed.then_some(()).ok_or(Failure::Open)
}

fn copy(from: &[f32], to: &mut [f32]) {
    for (from, to) in from.iter().zip(to) {
        *to = *from;
    }
}

fn bits(numbers: &[f32]) -> impl Iterator<Item = u32> {
    numbers.iter().map(|number| number.to_bits())
}

fn words(report: &Report<f32>) -> impl Iterator<Item = u32> + use<> {
    let residual = report.residual.to_bits();
    [report.iterations, report.evaluations, residual].into_iter()
}

fn line(
    out: &mut impl Write,
    fold: &Fold<'_>,
    what: &str,
    words: impl Iterator<Item = u32>,
) -> Result<(), Failure> {
    let print = || {
        write!(out, "{} {what}", fold.name)?;
        for word in words {
            write!(out, " {word:08x}")?;
        }
        writeln!(out)
    };
    print().map_err(|_| Failure::Output)
}
