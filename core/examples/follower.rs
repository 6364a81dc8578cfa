//! Moves a folding sheet along a path that is compiled in, as a controller without host, files and allocator does.
//!
//! The path is a Miura fold of 3x3 panels. Another one comes from these commands:
//!
//! ```text
//! foldpath generate miura --rows 3 --cols 3 -o miura.fold
//! foldpath plan miura.fold --interpolation homogeneous --max-accel 4 -o path.fold
//! foldpath export path.fold --to rust -o core/examples/follower/path.rs
//! cargo run -p foldpath-core --example follower
//! ```
//!
//! On a board, keep all but `main`, and replace what `main` does at the comments that begin with "Board".

use foldpath_core::acceptance::{Setpoint, SheetView};
use foldpath_core::follower::{CheckedOptions, Follower, FollowerPosition, Reason, State};
use foldpath_core::trajectory::TrajectoryView;
use foldpath_core::{Node, StarsView};

#[allow(unreachable_pub, reason = "the file is generated")]
mod path {
    include!("follower/path.rs");
}

/// Number of setpoints in the queue. Two are enough; more let the follower see farther ahead when it brakes.
const QUEUE: usize = 4;
/// Time between two ticks, microseconds.
const TICK_US: u64 = 10_000;

/// A follower, and the part of the path that it has not taken yet.
struct Machine {
    trajectory: TrajectoryView<'static, f32>,
    sheet: SheetView<'static, f32>,
    follower: Follower<f32, { path::GROUPS }, QUEUE>,
    next: usize,
}

impl Machine {
    /// Checks the path and starts to move. The sheet has to stand at the first knot: nothing measures it here.
    fn start() -> Result<Self, &'static str> {
        let trajectory = TrajectoryView::new(
            path::INTERPOLATION,
            path::GROUPS,
            path::SPANS,
            path::ANGLES,
            path::RATES,
            path::WEIGHTS,
        );
        let stars = StarsView::new(path::SPOKES, path::ENDS, path::GROUPS);
        let mut machine = Self {
            trajectory: trajectory.map_err(|_| "the constants are no trajectory")?,
            sheet: SheetView {
                interpolation: path::INTERPOLATION,
                limits: path::LIMITS,
                stars: stars.ok_or("the constants are no sheet")?,
                closure: path::CLOSURE,
            },
            follower: Follower::new(CheckedOptions::default()),
            next: 0,
        };
        let begin = FollowerPosition::default();
        let loaded = machine.follower.load(&machine.sheet, begin);
        loaded.map_err(|_| "the sheet has too many groups")?;
        machine.feed();
        let confirmed = machine.follower.confirm();
        let started = confirmed.and_then(|()| machine.follower.start());
        started.map_err(|_| "the first knot was refused, or the sheet stands elsewhere")?;
        Ok(machine)
    }

    /// Fills the queue. A setpoint that is refused holds the motion, and the follower's reason says why.
    fn feed(&mut self) {
        while self.follower.room() > 0
            && let Some(setpoint) = self.setpoint(self.next)
            && self.follower.accept(&self.sheet, setpoint).is_ok()
        {
            self.next += 1;
        }
    }

    /// Returns a knot of the path as a setpoint.
    fn setpoint(&self, number: usize) -> Option<Setpoint<f32, { path::GROUPS }>> {
        let knot = self.trajectory.knot(number)?;
        let nodes = (0..path::GROUPS).filter_map(|group| {
            Some(Node {
                angle: *knot.angles.get(group)?,
                rate: *knot.rates.get(group)?,
                weight: knot.weights.get(group).copied().unwrap_or([1.0, 0.0]),
            })
        });
        Some(Setpoint {
            number: u32::try_from(number).ok()?,
            span: knot.span,
            last: number + 1 == self.trajectory.len(),
            nodes: nodes.collect(),
        })
    }

    /// Moves on to `now`, microseconds. Returns `true` until the motion ends or fails.
    fn tick(&mut self, now: u64) -> bool {
        self.feed();
        // There is no host whose silence should hold the motion.
        self.follower.heard(now);
        self.follower.tick(self.sheet.stars, now);
        let refused = matches!(self.follower.reason(), Reason::Refused(_));
        !refused && !matches!(self.follower.state(), State::Done | State::Faulted)
    }
}

fn main() -> Result<(), &'static str> {
    let mut machine = Machine::start()?;
    let mut now = 0;
    loop {
        // Board: wait for the next period of a timer, and read its clock.
        now += TICK_US;
        // Board: call `machine.follower.stop(true)` while the stop line is drawn, and `machine.follower.measure` with
        // each angle that an encoder tells.
        let moves = machine.tick(now);
        // Board: hand each hinge's commanded angle to its drive.
        let hinges = path::HINGES
            .iter()
            .filter_map(|&hinge| machine.follower.hinge(hinge));
        if now % 1_000_000 == 0 || !moves {
            let degrees: Vec<String> = hinges.map(|h| format!("{:6.1}", h.to_degrees())).collect();
            println!("{:6.2} s: {}", now as f64 * 1e-6, degrees.join(" "));
        }
        if !moves {
            break;
        }
    }
    println!(
        "{:?}, {:?}",
        machine.follower.state(),
        machine.follower.reason()
    );
    Ok(())
}
