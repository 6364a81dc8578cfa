//! The lattice of a tessellation: which faces of a sheet move alike, and how one cell of the sheet folds all of it.
//!
//! A tessellation repeats. This drawing has a Miura of four rows and four columns of faces, made of four kinds of
//! faces, A, B, C and D. A letter stands for the kind of a face, and two digits for its cell:
//!
//! ```text
//!     ____________________________
//!    / C01  / D01  / C11  / D11  /
//!   /______/______/______/______/
//!   \ A01  \ B01  \ A11  \ B11  \
//!    \______\______\______\______\       ^
//!    / C00  / D00  / C10  / D10  /       |  step t2
//!   /______/______/______/______/        |
//!   \ A00  \ B00  \ A10  \ B10  \        +---------->
//!    \______\______\______\______\          step t1
//! ```
//!
//! - A **step** is a translation of the flat sheet that takes faces to faces, and hinges to hinges that turn alike: of
//!   the same crease group and sign. [`Lattice::find`] looks for two independent steps, t₁ and t₂; a strip has one.
//! - An **orbit** is a set of faces that steps take to each other. This sheet has four: A00, A10, A01 and A11 are the
//!   faces of the orbit A.
//! - A **cell** has one face of each orbit. Its numbers i and j say that it lies i t₁ + j t₂ from cell `[0, 0]`, which
//!   is A00, B00, C00 and D00. A cell at the border may lack some of its faces.
//! - The **coordinate** of a face ([`LatticeCoord`]) is its orbit and its cell.
//! - A **link** ([`Link`]) is an edge between two adjacent faces. The links of the *tree*, such as A00-B00, A00-C00 and
//!   B00-D00, lead to all orbits of a cell. The links of the *loops*, such as B00-A10 and C00-A01, lead one step on.
//! - A **class of pairs** ([`PairClass`]) is two orbits and an **offset**, the difference of the two cells. A00-D10 and
//!   A01-D11 are the pairs of orbits A and D with the offset `[1, 0]`. All pairs of a class move alike.
//!
//! # How cells move
//!
//! When the sheet folds, the step t₁ becomes a rigid motion S₁ of space, and t₂ becomes S₂. The face of an orbit in
//! cell `[i, j]` has the pose S₁ⁱ S₂ʲ P, where P is the pose of that orbit's face in cell `[0, 0]`. So the hinges of
//! the tree and of the loops place all faces ([`LatticeMotion`]), at the same cost for four faces as for a million. S₁
//! and S₂ are translations while a Miura folds; other sheets roll up, and then a [`Screw`] has the powers of S₁ and S₂.
//! [`Lattice`] proves these statements and says what they require.
//!
//! [`LatticeMotionBounds`] bounds the motion of each cell as seen from any other, and so tells if cells can come near each
//! other between two times. If the steps are translations, few cells can be near a given one, and
//! their offsets are found without looking at the others.
//!
//! # Files
//!
//! Steps are found in `translations.rs`; `survey.rs` walks over the sheet and gives each face its coordinate, and
//! `orbits.rs` and `pair_classes.rs` answer questions about the result. `screw.rs` and `motion.rs` fold one cell and move
//! it. `deviation.rs` and `motion_bounds.rs` bound the motion between two times, and `neighbours.rs`
//! finds the cells that may come near each other.
//!
//! Absent: crossings of faces. `collision` asks for classes, poses and bounds, and sweeps one pair of each class.

mod deviation;
mod motion;
mod motion_bounds;
mod neighbours;
mod orbits;
mod pair_classes;
mod screw;
mod survey;
mod translations;

pub use deviation::AngleVariation;
pub(crate) use deviation::CUBIC_RATIO;
pub use motion::LatticeMotion;
pub use motion_bounds::{LatticeMotionBounds, Stretch};
pub(crate) use neighbours::NeighbourSearch;
pub use orbits::{Lattice, LatticeCoord, Link, Orbit};
pub use pair_classes::PairClass;
pub use screw::Screw;
