//! The folding map: the rigid motion of every face, and what it does to the sheet.

mod amplification;
mod fit;
mod map;
mod tree;

pub use amplification::Amplification;
pub use fit::{laid_on, sheets_laid_on};
pub use map::{FoldingMap, Pose, Rigidity, deformation};
pub use tree::SpanningTree;
