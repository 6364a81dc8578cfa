//! Tests of core through its public interface, one module for each matter.

mod closure;
mod conjugate_gradients;
mod follower;
mod hole;
mod motions;
mod nonsense;
mod normal_equations;
mod objective;
mod path_clock;
mod project;
mod sampling;
mod solvers;
mod star;
mod trajectory;
mod trajectory_file;
mod wire;
