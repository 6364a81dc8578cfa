//! Plots of a path: what the figures of [XiLien2015](crate#references) show of theirs, and what is certified.
//!
//! Four panels, one below the other, against the time of the path but for the second:
//!
//! 1. fold angles of the crease groups (its Figures 6 to 8);
//! 2. fold angles measured on the folded shapes against those assigned, virtual edges among them (Figure 4);
//! 3. deformation and gap, with the bound that holds for all of the motion between two knots (Figure 3);
//! 4. clearance, the smallest distance between faces that share no vertex.
//!
//! [`Curves`] has the numbers, [`svg`] draws them.

mod curves;
mod panels;

pub use curves::{Curves, Point};
pub use panels::svg;
