//! Tests of the controller's program on the host, in virtual time, one module for each matter.

mod faults;
mod fuzz;
mod path;
mod refusals;
mod world;
