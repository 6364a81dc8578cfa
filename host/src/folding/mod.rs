//! The folding map: the rigid motion of every face, and what it does to the sheet.

mod amplification;
mod dihedral;
mod fit;
mod holonomy;
mod lattice_course;
mod lattice_motion;
mod map;
mod rounding;
mod screw;
mod tree;

pub use amplification::Amplification;
pub use dihedral::Dihedral;
pub use fit::{fit, laid_on, sheets_laid_on};
pub use holonomy::Holonomy;
pub(crate) use lattice_course::Drift;
pub use lattice_course::{Bend, LatticeCourse, Stretch};
pub use lattice_motion::LatticeMotion;
pub use map::{FoldingMap, Pose, Rigidity, deformation};
pub use rounding::rounding;
pub use screw::Screw;
pub use tree::SpanningTree;
