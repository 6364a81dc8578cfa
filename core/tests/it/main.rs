//! Tests of core through its public interface, with one module for each subject.

mod alike;
mod closure;
mod follower;
mod holds;
mod hole;
mod key;
mod motions;
mod nonsense;
mod normal_equations;
mod objective;
mod path_clock;
mod plane_angle;
mod power_on;
mod project;
mod rotation;
mod sampling;
mod segment_bounds;
mod solvers;
mod star;
mod trajectory;
mod trajectory_file;
mod trigonometry;
mod wire;
