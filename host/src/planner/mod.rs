//! Plans the path of a whole sheet, from a crease pattern and a goal.
//!
//! Crease groups reduce the problem to a few unknowns, and essential vertices reduce it to a few closure conditions.
//! The path is followed from the goal, which is a regular configuration, back to the flat sheet, which is singular. As
//! few knots are placed on the path as a bound on the error between them allows. The motion is then lifted to the whole
//! sheet and judged there.

mod branch;
mod certified_motion;
mod cholesky;
mod chord;
mod driver;
mod fold_sequence;
mod follow;
mod goal;
mod judge;
mod knot_placement;
mod knots;
mod measured_motion;
mod messages;
mod mobility;
mod options;
mod overshoot;
mod pipeline;
mod plan;
mod problem;
mod reachability;
mod reason;
mod reduced_path;
mod reduction;
mod route;
mod route_selection;
mod search;
mod simple_folds;
mod solver;
mod sparse;
mod swept_motion;
pub mod timing;
mod vectors;
mod whole_sheet;

pub use branch::{Departure, leave_flat};
pub use driver::{plan, plan_watched};
pub use foldpath_core::Objective;
pub use goal::{CHOSEN_REACH, Goal, GoalError, GoalKind};
pub use knots::{Knot, Path};
pub use mobility::{FirstStep, Mobility, first_step};
pub use options::{
    HingeLimit, Judged, OptionsError, PlanOptions, Search, Skips, Solver, Symmetry, Timing,
    Vertices,
};
pub use overshoot::Overshoot;
pub use plan::{Attempt, Outcome, Plan, Strategy, Times};
pub use reason::{ClosureSite, GroupsDropped, Note, Reason, Stop, TimeoutAt, WorstClosure};
pub use reduction::{CLOSED, closure_of};
pub use sparse::SparseNormalEquations;
