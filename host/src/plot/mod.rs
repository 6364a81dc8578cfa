//! Plots of a path: the kinds of figures in [XiLien2015](crate#references), and the certified bounds.
//!
//! A plot has four panels, one below the other. All but the second are against the time of the path:
//!
//! 1. fold angles of the crease groups (Figures 6 to 8 of the source);
//! 2. fold angles measured on the folded shapes against those assigned, virtual edges among them (Figure 4);
//! 3. deformation and gap, with the bound that holds for the whole motion between two knots (Figure 3);
//! 4. clearance, the smallest distance between faces that share no vertex.
//!
//! [`Curves`] has the numbers, [`svg`] draws them.

mod curves;
mod panels;

pub use curves::{Curves, Point};
pub use panels::svg;
