//! x
pub mod collision;
pub mod folding;
pub mod generate;
pub mod pattern;
pub mod planner;
pub mod ragged;
pub mod symmetry;
