//! The folding map: the rigid motion of every face, and what it does to the sheet.

mod amplification;
mod fit;
mod holonomy;
mod map;
mod rounding;
mod tree;

pub use amplification::Amplification;
pub use fit::{laid_on, sheets_laid_on};
pub use holonomy::Holonomy;
pub use map::{FoldingMap, Pose, Rigidity, deformation};
pub use rounding::rounding;
pub use tree::SpanningTree;
