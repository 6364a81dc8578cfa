//! Rigorous bounds on the motion between two knots: closure residuals of vertices and of loops round holes over a whole
//! segment, fold angles and rates, and from these the deformation, gap and twist of the whole sheet.
//!
//! Every bound holds for the exact motion of the given curves, rounding of the computation included, and for the same
//! motion evaluated in `f64` by other means. The bounds of [`FoldingCertifier`] are proved for the four spanning trees
//! along which it folds the sheet, and doubled for other trees.

mod bernstein;
mod chebyshev;
mod closure;
mod folding;
mod range;
mod sheet;

pub use closure::{Closure, SegmentCertifier};
pub use folding::FoldingCertifier;
pub use range::{range, rate};
pub use sheet::SheetCertifier;
