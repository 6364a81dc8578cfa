//! Data structures and functions that know nothing of origami.

pub(crate) mod angle;
pub(crate) mod clock;
pub(crate) mod hull;
pub(crate) mod nan_max;
pub mod progress;
pub mod range;
pub(crate) mod time_cached;
pub(crate) mod union_find;

pub use foldpath_linear::{csr, parallel};

/// Gives options of type `T` a method that changes some of them: code in other packages cannot write such a struct out,
/// because it may get more fields.
macro_rules! changed_one_by_one {
    ($T:ty) => {
        impl $T {
            /// Returns these options with some of them changed:
            #[doc = concat!("`", stringify!($T), "::default().with(|it| it.field = value)`.")]
            #[must_use]
            pub fn with(mut self, change: impl FnOnce(&mut Self)) -> Self {
                change(&mut self);
                self
            }
        }
    };
}
pub(crate) use changed_one_by_one;
