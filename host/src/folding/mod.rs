//! Folds the sheet: the rigid motion of every face at a configuration (the folding map, along a spanning tree
//! of the faces), and the deformation, gap and twist that it causes.

mod amplification;
mod dihedral;
mod fit;
mod map;
mod plane;
mod rounding;
mod shapes;

pub use amplification::{amplification, worst_amplification};
pub use dihedral::Dihedral;
pub(crate) use dihedral::fold_angle;
pub(crate) use fit::vertices_of_sheets;
pub use fit::{align_rigid, align_sheets, fit};
pub use map::{BOUND, DEFAULT_BOUND, FoldingMap, deformation};
pub(crate) use plane::in_plane;
pub use rounding::rounding;
pub use shapes::{STEP, deformation_of_faces, shapes};

pub use crate::lattice::Pose;
pub use crate::pattern::{Holonomy, Rigidity, SpanningTree, Step, Tear};
