//! Plans how a flat sheet with many hinges folds into a goal shape while every panel stays rigid and
//! no panel passes through another.
//!
//! # From file to motion
//!
//! 1. [`read`] reads a [`pattern`] from FOLD, SVG, DXF, CP or OPX: a planar graph of creases with the goal's
//!    fold angles.
//! 2. [`symmetry`] finds *crease groups* (creases that turn alike) and *essential vertices* (one for
//!    each distinct closure condition). A Miura fold of any size has 2 groups and 1 such vertex.
//! 3. [`planner`] follows the motion in group angles from the goal back to the flat sheet with [`foldpath_core`]'s
//!    solvers, lifts it to the whole sheet, and answers with a [`Motion`](motion::Motion).
//! 4. [`folding`] folds the sheet at every knot and measures deformation and gaps; [`collision`] looks for faces that
//!    pass through each other, at one configuration or over a whole motion.
//! 5. [`certificate`] bounds closure over the whole motion between knots, and with it deformation and gap.
//! 6. [`unfold`](mod@unfold) makes a crease pattern of a folded shape.
//! 7. [`check`](mod@check) judges a motion afresh; [`view`] makes a page of it, [`plot`](mod@plot) draws its curves,
//!    [`export`] writes it in other formats, and [`stream`] sends it to a controller.
//! 8. [`sensitivity`] has the derivatives of a motion, the play that inexact panels need, and the torques of drives.
//! 9. [`request`] has the options of all this by their names, and the answers as JSON, for programs that ask by text.
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
//! assert_eq!((plan.reduced.groups, plan.reduced.essential_vertices), (2, 1));
//! assert!(plan.errors.rigidity.deformation < 1e-12);
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```
//!
//! # Judging, showing and exporting a motion
//!
//! [`check`](check::check) judges a motion from its knots alone, and everything that shows or drives a sheet takes the
//! same motion. The path file is a FOLD animation that other programs can read:
//!
//! ```
//! use std::path::Path;
//!
//! use foldpath::check::{CheckOptions, check};
//! use foldpath::export::{fold, glb, traj::TrajFile};
//! use foldpath::generate::Miura;
//! use foldpath::pattern::CreasePattern;
//! use foldpath::planner::{Goal, PlanOptions, plan};
//! use foldpath::read::fold::parse_motion;
//! use foldpath::{plot, view};
//!
//! # let miura = Miura { rows: 4, columns: 4, sector_angle: 60_f64.to_radians(), fold: 0.9 };
//! # let pattern = CreasePattern::new(miura.drawing()?)?;
//! let plan = plan(&pattern, &Goal::of_pattern(&pattern)?, &PlanOptions::default());
//! let mut motion = plan.motion.ok_or("no motion")?;
//! motion.title = "Miura".into();
//! let verdict = check(&motion, &CheckOptions::default());
//! assert!(verdict.holds(), "{:?}", verdict.failures);
//!
//! let page: String = view::page(&view::Scene::of_path(&motion));
//! let curves: String = plot::svg(&plot::Curves::of_path(&motion));
//! // Names of files are for messages: nothing is read or written here.
//! let name = Path::new("path.fold");
//! let animation: Vec<u8> = glb::content(&motion, name)?;
//! let for_controllers: Vec<u8> = TrajFile::of(&motion, name)?.bytes;
//! assert!(for_controllers.len() < 1000);
//! let file: String = fold::motion_text(&motion);
//! assert_eq!(parse_motion(name, file.as_bytes())?.knots.len(), motion.knots.len());
//! # assert!(page.contains("Miura") && curves.starts_with("<svg") && animation.starts_with(b"glTF"));
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```
//!
//! # To a controller
//!
//! [`stream::run`] sends a path over a [`stream::Link`]: to a device, to an emulated board, or to [`stream::Sim`],
//! which runs the same controller in this process and in virtual time:
//!
//! ```
//! use std::io;
//! use std::path::Path;
//!
//! use foldpath::stream::{self, Options, Outcome, Sim, StreamPath, Telemetry, Wish};
//!
//! /// Looks on, and stops nothing.
//! struct Watch;
//!
//! impl stream::Watcher for Watch {
//!     fn telemetry(&mut self, told: &Telemetry) -> io::Result<()> {
//!         assert!(told.angles.iter().all(|angle| angle.abs() <= core::f32::consts::PI));
//!         Ok(())
//!     }
//!     fn wish(&mut self) -> Wish {
//!         Wish::Run
//!     }
//! }
//!
//! # use foldpath::export::traj::TrajFile;
//! # use foldpath::{generate::Miura, pattern::CreasePattern, planner::{Goal, PlanOptions, plan}};
//! # let miura = Miura { rows: 3, columns: 3, sector_angle: 60_f64.to_radians(), fold: 0.9 };
//! # let pattern = CreasePattern::new(miura.drawing()?)?;
//! # let plan = plan(&pattern, &Goal::of_pattern(&pattern)?, &PlanOptions::default());
//! # let motion = plan.motion.ok_or("no motion")?;
//! # let name = Path::new("path.traj");
//! # let bytes = TrajFile::of(&motion, name)?.bytes;
//! let path = StreamPath::read(&bytes, name)?;
//! let options = Options::default().with(|it| it.id = 1);
//! let summary = stream::run(&mut Sim::new(), &path, options, &mut Watch)?;
//! assert_eq!(summary.outcome, Outcome::Done);
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```
//!
//! # From a folded shape back to a pattern
//!
//! [`unfold`](unfold::unfold) makes the crease pattern of a folded shape, with the fold angles measured on that shape:
//!
//! ```
//! use foldpath::folding::FoldingMap;
//! use foldpath::generate::Miura;
//! use foldpath::pattern::CreasePattern;
//! use foldpath::unfold::{FoldedShape, Outcome, UnfoldOptions, unfold};
//!
//! let miura = Miura { rows: 4, columns: 4, sector_angle: 60_f64.to_radians(), fold: 0.9 };
//! let pattern = CreasePattern::new(miura.drawing()?)?;
//! let angles: Vec<f64> = pattern.creases().iter().filter_map(|edge| pattern.edge(*edge).goal).collect();
//! let folded = FoldingMap::new(&pattern, pattern.tree(), &angles);
//!
//! let shape = FoldedShape {
//!     vertices: folded.vertices().to_vec(),
//!     faces: pattern.faces().iter().map(|face| face.iter().map(|v| v.index()).collect()).collect(),
//!     edges: Vec::new(),
//! };
//! let unfolding = unfold(&shape, &UnfoldOptions::default())?;
//! assert_eq!(unfolding.outcome, Outcome::Unfolded);
//! assert!(unfolding.max_angle_defect < 1e-12);
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```
//!
//! # Guaranteed
//!
//! A path called planned is closed, within the bound on deformation and gap, and free of crossings *all along its
//! motion*, as far as the plan's `certified_deformation` and `clearance` say: the first is a bound with rounding
//! included, the second is given if the search for crossings was completed. No hinge exceeds its limits of speed and
//! acceleration.
//!
//! Pattern, goal, options and seed determine the answer, byte by byte, unless time runs out. The number of threads does
//! not: large work is shared by the threads of the rayon pool that the caller is in (`rayon::ThreadPool::install`), or
//! else of rayon's own, which has a thread for each core.
//!
//! # Limits
//!
//! Errors are the rounding errors of `f64`, which grow with the distance across the sheet and from the origin: a 24x24
//! Miura deforms by 5e-14, one of 1,000x1,000 by 9e-11, a sheet 10⁹ edges from the origin by 3e-7, as far as rounded
//! coordinates allow. `plan` adds a note about everything that it cannot certify. Angles below 10⁻⁹ radians count as
//! flat, and coordinates beyond 10⁵⁰ are refused. `host/FORMAT.md` lists all limits, `BENCHMARKS.md` how they were
//! found.
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
pub mod collision;
mod colours;
pub mod export;
pub mod folding;
pub mod generate;
pub mod lattice;
pub mod motion;
pub mod pattern;
pub mod planner;
#[cfg(feature = "plot")]
pub mod plot;
pub mod read;
pub mod request;
pub mod sensitivity;
mod straighten;
#[cfg(feature = "stream")]
pub mod stream;
pub mod symmetry;
pub mod unfold;
pub mod util;
pub mod view;

pub use nalgebra::{Vector2, Vector3};
pub use util::progress;
