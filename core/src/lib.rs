//! Rigid-origami kinematics and solvers without an allocator, shared by foldpath's planner on the host and the
//! controller in the machine.
//!
//! # The problem
//!
//! A flat sheet of rigid panels joined by hinges folds by turning each hinge by its *fold angle* ρ (π minus the
//! dihedral angle; valley positive, mountain negative). Round an interior vertex the panels must meet again: the
//! product of the rotations about its creases, taken counter-clockwise, must be the identity. This is one *closure*
//! condition for each vertex. A *configuration* (all fold angles) that meets every condition folds the sheet without
//! bending a panel.
//!
//! In a tessellation most of these conditions coincide. Creases whose fold angles have the same absolute value all
//! along the motion form a *crease group*. With one unknown for each group and one *star* for each distinct condition,
//! a Miura fold of any size has two unknowns and one star.
//!
//! Round a hole the panels must meet again too: a [loop](hole) is the closure condition along a closed path round the
//! hole, which also needs the places of the creases.
//!
//! A controller moves a sheet along a planned path with a [`follower`], which a host feeds over a [`wire`].
//!
//! # A closed vertex in one page
//!
//! ```
//! use foldpath_core::least_squares::{ClosureProblem, Limits, Options, Outcome};
//! use foldpath_core::{DenseNormalEquations, GroupId, Spoke, StarsView, levenberg_marquardt};
//!
//! // A Miura vertex with 60 degree sectors: group 0 are the zigzag creases, group 1 the straight.
//! let spoke = |group, negative, degrees: f64| {
//!     let (sin, cos) = degrees.to_radians().sin_cos();
//!     Spoke { group: GroupId(group), negative, direction: [cos, sin] }
//! };
//! let spokes = [
//!     spoke(1, true, 0.0),
//!     spoke(0, false, 60.0),
//!     spoke(1, false, 180.0),
//!     spoke(0, false, 300.0),
//! ];
//! let stars = StarsView::new(&spokes, &[4], 2).unwrap();
//!
//! let (mut half_angles, mut columns) = ([Default::default(); 2], [Default::default(); 4]);
//! let mut problem = ClosureProblem::new(stars, &mut half_angles, &mut columns).unwrap();
//! let mut memory = [0.0; DenseNormalEquations::<f64>::memory(2)];
//! let mut equations = DenseNormalEquations::new(2, &mut memory).unwrap();
//!
//! let mut angles = [1.0, 0.6]; // does not close yet
//! let report = levenberg_marquardt::solve(
//!     &mut problem,
//!     &mut equations,
//!     Limits::HalfTurn,
//!     &Options::default(),
//!     &mut angles,
//!     &mut [0.0; 4],
//! );
//! assert_eq!(report.outcome, Outcome::Converged);
//! let [zigzag, straight] = angles.map(|angle| (angle / 2.0).tan());
//! assert!((straight - 60_f64.to_radians().cos() * zigzag).abs() < 1e-12);
//! ```
//!
//! # Guaranteed
//!
//! No allocation, no clock, no files, no `unsafe`, no recursion, and no trigonometry but libm's and this crate's own:
//! the same `f32` program gives the same bits on the host and on the controller. The caller lends all memory; too
//! little memory is a reported outcome. Nothing here panics.
//!
//! # Not guaranteed
//!
//! A closed configuration may still pass panels through each other; the host has to check for crossings.
//!
//! # How exact
//!
//! A residual is within 3e-15 (`f64`) or 1.2e-6 (`f32`) of its exact value for stars of up to 64 creases at any angles,
//! and within a few roundings for stars of four creases. Solvers stop at residuals of 1e-14 and 5e-6, so that fold
//! angles below these values count as closed and stay as they are: in `f32`, fold angles below 1e-6 radians are as good
//! as flat. A 24x24 Miura folded by such angles deforms by at most 5e-14 (`f64`) and 3e-5 (`f32`), one of 1,000x1,000
//! by 9e-11 and 7e-2. Angles that are infinite or NaN give residuals that are NaN; the sine of an `f32` beyond 12,866
//! radians is NaN.
//!
//! # References
//!
//! - **XiLien2015**: Z. Xi, J.-M. Lien, "Folding and unfolding origami tessellation by reusing
//!   folding path", GMU-CS-TR-2015-2.
//! - **Nielsen1999**: H. B. Nielsen, "Damping parameter in Marquardt's method", IMM-REP-1999-05.
//! - **YamashitaFukushima2001**: N. Yamashita, M. Fukushima, "On the rate of convergence of the
//!   Levenberg-Marquardt method", Computing Suppl. 15.
//! - **BarzilaiBorwein1988**: J. Barzilai, J. M. Borwein, "Two-point step size gradient methods",
//!   IMA J. Numer. Anal. 8.
//! - **Raydan1997**: M. Raydan, "The Barzilai and Borwein gradient method for the large scale
//!   unconstrained minimization problem", SIAM J. Optim. 7.
//! - **Fan2012**: J. Fan, "The modified Levenberg-Marquardt method for nonlinear equations with cubic convergence", Math.
//!   Comp. 81.
//! - **GillMurraySaundersWright1990**: P. E. Gill, W. Murray, M. A. Saunders, M. H. Wright, "A Schur-complement method for
//!   sparse quadratic programming", in: Reliable numerical computation.
//! - **Farin2002**: G. Farin, "Curves and surfaces for CAGD", 5th edition, Morgan Kaufmann.
//! - **Kelley1995**: C. T. Kelley, "Iterative methods for linear and nonlinear equations", SIAM.
//! - **AumassonBernstein2012**: J.-P. Aumasson, D. J. Bernstein, "SipHash: a fast short-input PRF", INDOCRYPT 2012.
//! - **RFC6298**: V. Paxson et al., "Computing TCP's retransmission timer", 2011.
#![no_std]
#![deny(clippy::unwrap_used, clippy::expect_used, clippy::panic)]
#![deny(clippy::indexing_slicing)]

pub mod acceptance;
pub mod bernstein;
mod checksum;
pub mod closure;
mod curve;
#[cfg(feature = "solvers")]
mod dense;
mod folding_matrix;
pub mod follower;
#[cfg(feature = "solvers")]
pub mod gradient;
mod group;
mod half_angles;
pub mod hole;
#[cfg(feature = "solvers")]
mod ldl;
#[cfg(feature = "solvers")]
pub mod least_squares;
#[cfg(feature = "solvers")]
pub mod levenberg_marquardt;
mod limits;
mod numbers;
mod objective;
pub mod path_clock;
#[cfg(feature = "solvers")]
pub mod plane_angle;
#[cfg(feature = "solvers")]
pub mod project;
mod rotation;
#[cfg(feature = "solvers")]
pub mod sampling;
mod scalar;
mod segment_bounds;
mod sine;
mod star;
pub mod trajectory;
pub mod trajectory_file;
pub mod wire;

pub use checksum::{checksum, checksum_on};
pub use curve::{Curve, Interpolation, Node};
#[cfg(feature = "solvers")]
pub use dense::DenseNormalEquations;
pub use folding_matrix::{folding_matrix, local_foldability_matrix};
pub use group::{GroupId, Membership, expand};
pub use hole::{LoopView, LoopsView};
pub use limits::GroupLimits;
pub use objective::{Objective, norm};
pub use rotation::{HalfAngle, Rotation};
pub use scalar::Scalar;
pub use star::{Spoke, StarView, StarsView};
