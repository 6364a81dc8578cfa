//! Writes crease patterns and motions in the formats of other programs and of controllers.

pub mod csv;
pub mod fold;
pub mod glb;
mod groups;
pub mod joint_trajectory;
pub mod mjcf;
mod mjcf_panels;
pub mod obj_sequence;
pub mod rust;
pub mod svg_pattern;
pub mod traj;
