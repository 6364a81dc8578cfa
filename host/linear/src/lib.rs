//! Linear algebra and linear programs with sparse matrices: what the planner of foldpath computes with, and what knows
//! nothing of folding.
//!
//! - [`csr`]: lists of lists in two arrays.
//! - [`cholesky`]: factors of sparse symmetric positive definite matrices, after an ordering that keeps them sparse. The
//!   elimination tree of a factor tells which of its parts can be computed at once.
//! - [`gram`]: sparse matrices AᵀA that are sums over blocks of rows, such as those of normal equations.
//! - [`linear_program`]: linear programs whose variables have bounds.
//! - [`parallel`]: work that threads share.
//!
//! ```
//! use foldpath_linear::cholesky::{Factor, Symbolic};
//!
//! // [4 2; 2 3], of which the lower triangle is stored column by column.
//! let symbolic = Symbolic::new(&[0, 2, 3], &[0, 1, 1]).ok_or("too many entries")?;
//! let mut factor = Factor::new(&symbolic);
//! assert!(symbolic.factorise(&[4.0, 2.0, 3.0], 0.0, &mut factor, &|| false));
//! let mut solution = [8.0, 8.0];
//! symbolic.solve(&mut factor, &mut solution);
//! assert!((solution[0] - 1.0).abs() < 1e-15 && (solution[1] - 2.0).abs() < 1e-15);
//! # Ok::<(), &str>(())
//! ```
//!
//! # Guaranteed
//!
//! Input determines the answer, bit by bit, on every machine that rounds `f64` as IEEE 754 says and with any number of
//! threads. No clock is read: the caller lends a function that tells when a long factorisation has to end.

pub mod cholesky;
pub mod csr;
mod elimination_tree;
pub mod gram;
pub mod linear_program;
pub mod parallel;
