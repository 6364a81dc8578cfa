//! Shared code of the tests that cross crates: an oracle that judges a path file on its own, and planned patterns.
//!
//! The oracle ([`Animation`], [`Sheet`]) calls nothing of foldpath. It reads the file with serde_json, turns faces by
//! rotation matrices from face 0 outwards, evaluates closure by products of the same matrices, and tests all pairs of
//! faces for crossings.
//!
//! A second opinion on each shape uses other formulas: 4x4 [`matrices`] round vertices and along another spanning tree,
//! and least squares on the vertices alone ([`Sheet::solved`]).
//!
//! [`campaign`] judges random stars, plans of seeded sheets of the [`meshes`] and spoilt paths by the thousand:
//! `cargo run --release -p foldpath-tests --example campaign -- plans --count 1000 --seed 1`.
//!
//! [`projection`] has closure conditions of sheets, and starts near closure, for tests and benchmarks of the solvers.

mod animation;
pub mod campaign;
mod crossing;
pub mod exact;
pub mod fold_spec;
mod folding;
mod hand_made;
mod judge;
mod layers;
mod lengths;
pub mod linkage;
pub mod matrices;
pub mod meshes;
mod motion;
mod newton;
mod planning;
pub mod projection;
mod second;
mod shape;
mod sheet;

pub use animation::{Animation, Frame};
pub use crossing::CONTACT;
pub use folding::Pose;
use foldpath::check::CheckOptions;
pub use foldpath_test_support::{Random, closed_form};
pub use hand_made::{HandKnot, HandMade};
pub use judge::{Verdict, judge};
pub use lengths::Solved;
pub use motion::Motion;
pub use newton::Closure;
pub use planning::{Planned, goal_angles, path_file, pattern_file};
pub use sheet::Sheet;

/// Returns the largest of `values`, 0 if there are none. Returns NaN if a value is NaN, so that it never passes a test.
#[must_use]
pub fn worst(values: impl IntoIterator<Item = f64>) -> f64 {
    values.into_iter().fold(
        0.0,
        |worst, x| if x > worst || x.is_nan() { x } else { worst },
    )
}

/// Returns `true` if `value` is above `most` or NaN.
fn exceeds(value: f64, most: f64) -> bool {
    value > most || value.is_nan()
}

/// Returns the options of a check with a bound of 1e-3, tighter than usual.
#[must_use]
pub fn strict() -> CheckOptions {
    CheckOptions::default().with(|it| it.bound = 1e-3)
}
