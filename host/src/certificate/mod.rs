//! Rigorous bounds on the motion between two knots: closure residuals of vertices and of loops round holes over a whole
//! segment, fold angles and rates, and from these the deformation, gap and twist of the whole sheet.
//!
//! Every bound holds for the exact motion of the given curves, rounding of the computation included, and for the same
//! motion evaluated in `f64` by other means. The bounds of [`FoldingCertifier`] are proved for the four spanning trees
//! along which it folds the sheet, and for no other.

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

/// Largest number of halvings of a segment: parts are no shorter than 2^-8 of it.
const MAX_HALVINGS: u8 = 8;
/// Ratio of a bound to the largest error seen in the segment above which a part is halved: bounds are larger than what
/// they bound by no more than this.
pub(crate) const LOOSE_RATIO: f64 = 1.5;
/// A part of a segment: number `index` of the equal parts that `depth` halvings make.
#[derive(Clone, Copy, Debug, Default)]
struct Part {
    depth: u8,
    index: u32,
}

impl Part {
    /// Returns the ends of the part, from 0 to 1.
    fn ends(self) -> [f64; 2] {
        let length = 1.0 / f64::from(1_u32 << self.depth);
        [self.index, self.index + 1].map(|end| f64::from(end) * length)
    }

    /// Returns both halves, the second first, as on a stack.
    fn halves(self) -> [Self; 2] {
        [1, 0].map(|side| Self {
            depth: self.depth + 1,
            index: 2 * self.index + side,
        })
    }
}

/// Factor on rounding: it counts once for the values here, and once for those who evaluate the same motion.
const ROUNDING_FACTOR: f64 = 2.0;
