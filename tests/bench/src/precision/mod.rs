//! Run time against error, of projections to closure and of whole paths.
//!
//! A *projection* moves a configuration, which is a seeded step off a closed one, back to closure. foldpath's solvers
//! and general-purpose peers get the same starts and the same objective, ½‖r‖² over the same stars. All of them stop at
//! the first configuration whose largest ‖r(v)‖ is within the tolerance. Peers evaluate residuals and derivatives by
//! foldpath's own kernels.

mod argmin_peers;
mod evaluator;
mod measure;
mod method;
mod minpack_peer;
mod nlopt_peers;
mod ours;
mod path;
mod picture;
mod section;
mod tables;

pub use foldpath_tests::projection::{Family, OPEN, Problem, STEP, residuals_by_iteration};
pub use measure::{Cell, Effort, measure, tolerances};
pub use method::{Method, Run, Solver};
pub use path::{PathCell, PathEffort, Route, bounds, measure_paths};
pub use section::{Form, write};
