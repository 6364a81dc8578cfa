//! Rigorous bounds on what happens between two knots: closure residuals of vertices and of loops round
//! holes over a whole segment, fold angles and rates; and by them deformation, gap and twist of the whole
//! sheet.
//!
//! Everything is proved of the exact motion of the given curves, roundings on the way included, and of
//! that motion evaluated in `f64` by other means. What [`FoldingCertifier`] bounds is proved of four trees along which the
//! sheet is folded, and doubled for others.

mod bernstein;
mod chebyshev;
mod closure;
mod folding;
mod range;
mod sheet;

pub(crate) use bernstein::restrict;
pub use closure::{Closure, SegmentCertifier};
pub use folding::FoldingCertifier;
pub use range::{range, rate};
pub use sheet::SheetCertifier;
