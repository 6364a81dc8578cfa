//! Plans the path of a whole sheet, from a crease pattern and a goal.
//!
//! Crease groups reduce the problem to a few unknowns, and essential vertices reduce it to a few closure conditions.
//! The path is followed from the goal, which is a regular configuration, back to the flat sheet, which is singular. As
//! few knots are placed on the path as a bound on the error between them allows. The motion is then lifted to the whole
//! sheet and judged there.
//!
//! # Stages
//!
//! Planning is a pipeline of values. Each stage is a function from one value to the next; a stage that does not lead on
//! returns the place and the size of what is in the way. No stage calls an earlier one.
//!
//! ```text
//! PlanningProblem          sheet, goal, options, error model          problem.rs
//!   | select_route           crease groups, closed goal, motion       following/
//! Route                    waypoints in group angles
//!   | ReducedPath::new       geometry alone, by path length           placement/
//!   | place                  fewest knots, with times
//! KnotSequence
//!   | certify                bounds between knots                     lifting/certified_motion.rs
//!   | measure                the whole sheet folded at the knots      lifting/measured_motion.rs
//! Lifted
//!   | sweep                  crossings over the whole motion          lifting/swept_motion.rs
//! Swept
//!   | lift                   goes nearer, ends earlier, or ends       lifting/whole_sheet.rs
//! Lifted
//!   | follow                 what was found, in one answer            strategies/pipeline.rs
//! Plan
//! ```
//!
//! # Strategies
//!
//! `strategies/driver.rs` has the table of strategies. Its rows are tried in order: some on the problem, some on a route
//! that ends before the goal, and some on the answer along a route on which something is in the way. The best answer is
//! kept, and [`Plan::attempts`] lists what was tried. ARCHITECTURE.md says of each row when it is tried and kept.
//! Nothing calls the driver but its user.
//!
//! # Before planning
//!
//! [`forecast`] says within a second what can be said of the flat sheet alone: whether it leaves flat, which creases
//! cannot turn, and what is in the way (`foldability/`).
//!
//! # Order of the files
//!
//! A file uses only files to its left:
//!
//! ```text
//! vectors < goal, knots < reason < messages, plan < options < problem
//! < closing (sparse < chord < solver)
//! < following (follow < reduction, search < nearly_closed, branch, judge < mobility, legs < completion < route <
//! route_selection)
//! < foldability (flat_cone < products < locked_loop < certificate < cause < forecast)
//! < placement (overshoot, reachability < timing < reduced_path < segment < knot_placer < knot_placement)
//! < lifting (lifted < certified_motion < measured_motion, swept_motion < whole_sheet)
//! < strategies (arrival, simple_folds < pipeline < rows < stops < fold_sequence, rings < split_phases, way_round,
//! bending, lines, advice, plates < driver)
//! ```

mod closing;
mod foldability;
mod following;
mod goal;
mod knots;
mod lifting;
mod messages;
mod options;
mod placement;
mod plan;
mod problem;
mod reason;
mod strategies;
mod vectors;

pub use crate::straighten::Straightened;
pub use closing::sparse::SparseNormalEquations;
pub use foldability::cause::{Cause, CauseKind};
pub use foldability::forecast::{Foldability, Forecast, forecast};
pub use foldpath_core::Objective;
pub use following::branch::{Departure, leave_flat};
pub use following::mobility::{FirstStep, Mobility};
pub use following::reduction::CLOSED;
pub use goal::{CHOSEN_REACH, Goal, GoalError, GoalKind};
pub use options::{
    DEFAULT_GOAL_TOLERANCE_DEG, DEFAULT_MAX_SPEED_DEG_PER_S, GOAL_TOLERANCE_DEG, HingeLimit,
    MAX_ACCELERATION_DEG_PER_S2, MAX_SPEED_DEG_PER_S, OptionsError, PlanOptions, PlateRequest,
    Search, Skips, Solver, Symmetry, Timing, Vertices,
};
pub use placement::overshoot::Overshoot;
pub use placement::timing;
pub use plan::{
    Arrival, Attempt, Certificate, CrossingSearch, Effort, FoldOrder, Outcome, Plan,
    ReducedProblem, SheetErrors, Strategy, Times,
};
pub use reason::{
    FirstSteps, GroupsDropped, HingeAtLimit, Note, ProofOrder, Reason, Stop, TimeoutAt, Undecided,
    WorstClosure,
};
pub use strategies::driver::{plan, plan_watched};
