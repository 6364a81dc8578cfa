//! The method of the technical report from which foldpath starts, and the report's tables and figures.
//!
//! [XiLien2015](foldpath#references), section 4, finds a path by an adaptive randomised search. A random configuration
//! round the current one, biased to the goal, is pushed towards closure by NLopt on F(C) = max ‖L(v) − I‖. It is
//! accepted if the sheet deforms within the bound, does not cross itself, and is nearer to the goal. [`search()`]
//! implements this on foldpath's folding map and collision scene. [`tune`] looks for the algorithm and the number of
//! evaluations that are best for a row of a table, as the report does.
//!
//! [`print()`] writes the report's tables and figures with foldpath's answers beside them.

mod cases;
mod figures;
mod measure;
mod objective;
mod ours;
mod picture;
mod search;
mod sheet;
mod tables;
mod tune;

use std::io::{self, Write};
use std::path::Path;

pub use cases::{Case, Extent};
pub use measure::{Deviation, between_knots, fold_by_matrices, straight_between};
pub use objective::ClosureObjective;
pub use search::{Accept, Algorithm, End, Run, Settings, search};
pub use sheet::{Freedom, Sheet};
pub use tune::{Tuned, Tuning, tune};

/// Measures everything, writes the section as Markdown, and writes data and plots to a folder.
///
/// # Errors
/// If something cannot be written.
pub fn print(extent: Extent, out: &mut impl Write, folder: &Path) -> io::Result<()> {
    std::fs::create_dir_all(folder)?;
    tables::print(extent, out, folder)?;
    figures::print(extent, out, folder)
}
