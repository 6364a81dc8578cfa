//! Disks round faces in space, and lower bounds of their distances.

use nalgebra::{Vector2, Vector3};

use crate::folding::Pose;

/// A disk in space or, for plates, what is no farther than `height` from a disk.
#[derive(Clone, Copy, Debug)]
pub(super) struct Disk {
    center: Vector3<f64>,
    normal: Vector3<f64>,
    radius: f64,
    height: f64,
}

impl Disk {
    /// Returns the disk inside a circle of the flat sheet that moves with a face.
    pub(super) fn new(pose: &Pose, (center, radius): (Vector2<f64>, f64), height: f64) -> Self {
        Self {
            height,
            center: pose.apply(center),
            normal: pose.r_wf.rotate(&Vector3::z()),
            radius,
        }
    }

    /// Returns the disk moved with its cell.
    pub(super) fn carried(&self, by: &Pose) -> Self {
        Self {
            center: by.carry(&self.center),
            normal: by.r_wf.rotate(&self.normal),
            ..*self
        }
    }

    /// Returns a lower bound of the distance between two disks: the distance of the balls round them, or of one
    /// disk from the plane of the other.
    pub(super) fn apart(&self, other: &Self) -> f64 {
        let between = other.center - self.center;
        let balls = between.norm() - self.radius - other.radius;
        let slant = self.normal.cross(&other.normal).norm();
        let over = self.normal.dot(&between).abs() - other.radius * slant;
        let under = other.normal.dot(&between).abs() - self.radius * slant;
        balls.max(over).max(under) - self.height - other.height
    }
}
