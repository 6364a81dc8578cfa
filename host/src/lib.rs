//! Plans how a flat sheet with many hinges folds into a goal shape while every panel stays rigid and
//! no panel passes through another.
//!
//! # From file to path
//!
//! 1. [`formats`] reads a [`pattern`] from FOLD, SVG or CP: a planar graph of creases with the goal's
//!    fold angles.
//! 2. [`symmetry`] finds *crease groups* (creases that turn alike) and *essential vertices* (one for
//!    each distinct closure condition). A Miura fold of any size has 2 groups and 1 such vertex.
//! 3. [`planner`] follows the motion in group angles from the goal back to the flat sheet with
//!    [`foldpath_core`]'s solvers, and reuses it on the whole sheet.
//! 4. [`folding`] folds the sheet at every knot and measures deformation and gaps; [`collision`]
//!    looks for faces that pass through each other, at one configuration or over a whole motion.
//! 5. [`certificate`] bounds closure, and with it deformation and gap, between the knots too.
//! 6. [`unfold`](mod@unfold) makes a crease pattern of a shape that is folded already.
//! 7. [`check`](mod@check) judges a written path afresh; [`view`] makes a page of it, [`plot`](mod@plot)
//!    draws its curves; [`stream`] sends it to a
//!    controller.
//!
//! ```
//! use foldpath::generate::Miura;
//! use foldpath::pattern::CreasePattern;
//! use foldpath::planner::{Goal, Outcome, PlanOptions, plan};
//!
//! let miura = Miura { rows: 8, columns: 8, sector_angle: 60_f64.to_radians(), fold: 0.9 };
//! let pattern = CreasePattern::new(miura.drawing()?)?;
//! let plan = plan(&pattern, &Goal::of_pattern(&pattern)?, &PlanOptions::default());
//! assert_eq!(plan.outcome, Outcome::Planned);
//! assert_eq!((plan.groups, plan.essential_vertices), (2, 1));
//! assert!(plan.rigidity.deformation < 1e-12);
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```
//!
//! # Guaranteed
//!
//! A path called planned is closed, within the bound on deformation and gap, and free of crossings
//! *all along its motion*, as far as the plan's `certified_deformation` and `clearance` say: the first is
//! a bound with roundings included, the second stands where the search for crossings came to its end.
//! No hinge is faster, or accelerates more, than it may.
//!
//! # Limits
//!
//! Errors are those of `f64` times the way: a 24x24 Miura deforms by 5e-14, one of 1,000x1,000 by 9e-11, a sheet 10⁹
//! edges from the origin by 3e-7, as far as rounded coordinates allow. What cannot be certified, `plan` notes. Angles
//! below 10⁻⁹ radians are flat, coordinates beyond 10⁵⁰ refused. `host/FORMAT.md` has all limits, `BENCHMARKS.md` how
//! they were found.
//!
//! # References
//!
//! - **EhlichZeller1964**: H. Ehlich, K. Zeller, "Schwankung von Polynomen zwischen Gitterpunkten", Math.
//!   Zeitschrift 86.
//! - **Trefethen2013**: L. N. Trefethen, "Approximation Theory and Approximation Practice", SIAM.
//! - **XiLien2015**: Z. Xi, J.-M. Lien, "Folding and unfolding origami tessellation by reusing
//!   folding path", GMU-CS-TR-2015-2.

pub mod certificate;
pub mod check;
pub mod cli;
pub mod collision;
mod colours;
pub mod folding;
pub mod formats;
pub mod generate;
mod numbers;
pub mod pattern;
pub mod planner;
pub mod plot;
pub mod progress;
pub mod ragged;
pub mod shapes;
pub mod stream;
pub mod symmetry;
pub mod unfold;
pub mod view;
