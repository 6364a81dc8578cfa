//! Tests of the library, one module for each subject.

mod amplification;
mod bends;
mod between;
mod certificate;
mod clearance;
mod common;
mod crossing;
mod folding;
mod fuzz;
mod generators;
mod lattice;
mod messages;
mod mistaken;
mod module_order;
mod nonsense;
mod overshoot;
mod planner_order;
mod plates;
mod progress;
mod second_order;
mod skew;
mod sweep;
mod symmetry;
mod timing;
