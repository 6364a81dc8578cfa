//! Tests that cross crates, with one module for each subject.

mod at_knots;
mod between_knots;
mod birds_feet;
mod branches;
mod browser;
mod campaign;
mod certified;
mod claims;
mod closed_forms;
mod controller_figures;
mod controller_image;
mod emulated_stream;
mod external;
mod firmware;
mod fold_spec;
mod image;
mod meshes;
mod oracle;
mod physics;
mod plans;
mod reuse;
mod rounded;
mod skips;
mod traps;
mod wrong_paths;
