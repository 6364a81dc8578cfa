//! Folds the sheet: the rigid motion of every face at a configuration (the folding map, along a spanning tree
//! of the faces), and the deformation, gap and twist that it causes.
//!
//! There are two ways to fold, over the same step from face to face (`hinge.rs`): all faces at once ([`FoldingMap`]
//! and `place_all`), or the faces that are asked for (`LazyFolding`).

mod amplification;
mod boxes;
mod dihedral;
mod fit;
mod hinge;
mod hinge_gaps;
mod lazy;
mod map;
mod plane;
mod pose;
mod rounding;
mod shapes;

pub use amplification::{amplification, worst_amplification};
pub use boxes::{small_box, smallest_rectangle};
pub use dihedral::Dihedral;
pub(crate) use dihedral::fold_angle;
pub(crate) use fit::fit_sheets;
pub use fit::{align_rigid, align_sheets, fit};
pub(crate) use hinge::{Hinge, Product, half_angle, place_all};
pub use hinge_gaps::hinge_gaps;
pub(crate) use lazy::LazyFolding;
pub use map::{BOUND, DEFAULT_BOUND, FoldingMap, deformation};
pub(crate) use plane::in_plane;
pub use pose::Pose;
pub use rounding::rounding;
pub use shapes::{STEP, deformation_of_faces, shapes, shapes_with};

pub use crate::pattern::{Holonomy, Rigidity, SpanningTree, Step, Tear};
