//! Folds the sheet: the rigid motion of every face at a configuration (the folding map, along a spanning tree
//! of the faces), and the deformation, gap and twist that it causes.

mod amplification;
mod dihedral;
mod fit;
mod holonomy;
mod lattice_course;
mod lattice_motion;
mod map;
mod plane;
mod rounding;
mod screw;
mod shapes;
mod tree;

pub use amplification::Amplification;
pub use dihedral::Dihedral;
pub(crate) use dihedral::fold_angle;
pub(crate) use fit::vertices_of_sheets;
pub use fit::{fit, laid_on, sheets_laid_on};
pub use holonomy::Holonomy;
pub use lattice_course::{Bend, LatticeCourse, Stretch};
pub(crate) use lattice_course::{Drift, Stray};
pub use lattice_motion::LatticeMotion;
pub use map::{FoldingMap, Pose, Rigidity, deformation};
pub(crate) use plane::in_plane;
pub use rounding::rounding;
pub use screw::Screw;
pub use shapes::{STEP, deformation_of_faces, shapes};
pub use tree::{SpanningTree, Step};
