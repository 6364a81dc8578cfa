//! Files. Only this module knows their formats.

mod error;
pub mod fold;
mod output;

pub use error::FileError;
pub use output::write_whole;
