//! Rigid motions of space, and of faces from the flat sheet to space.

use foldpath_core::Rotation;
use nalgebra::{Vector2, Vector3};

/// Rigid motion of a face from the flat sheet (frame f) to space (frame w): x_w = r_wf x_f + p_w.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Pose {
    /// Rotation.
    pub r_wf: Rotation<f64>,
    /// Position of the flat sheet's origin in space.
    pub p_w: Vector3<f64>,
    /// Images of the flat sheet's axes under `r_wf`.
    axes_w: [Vector3<f64>; 2],
}

impl Pose {
    /// Returns the pose that leaves the flat sheet where it is.
    #[must_use]
    pub fn identity() -> Self {
        Self {
            r_wf: Rotation::identity(),
            p_w: Vector3::zeros(),
            axes_w: [Vector3::x(), Vector3::y()],
        }
    }

    /// Returns the pose with this rotation that takes the origin of the flat sheet to `p_w`.
    #[inline]
    #[must_use]
    pub fn new(r_wf: Rotation<f64>, p_w: Vector3<f64>) -> Self {
        Self::about(r_wf, Vector2::zeros(), p_w)
    }

    /// Returns the pose with this rotation that takes the point `pivot` of the flat sheet to `pivot_w`.
    #[inline]
    #[must_use]
    pub fn about(r_wf: Rotation<f64>, pivot: Vector2<f64>, pivot_w: Vector3<f64>) -> Self {
        let Rotation { w, v } = r_wf;
        let axes_w = [
            Vector3::new(
                1.0 - 2.0 * (v.y * v.y + v.z * v.z),
                2.0 * (v.x * v.y + w * v.z),
                2.0 * (v.x * v.z - w * v.y),
            ),
            Vector3::new(
                2.0 * (v.x * v.y - w * v.z),
                1.0 - 2.0 * (v.x * v.x + v.z * v.z),
                2.0 * (v.y * v.z + w * v.x),
            ),
        ];
        let p_w = pivot_w - axes_w[0] * pivot.x - axes_w[1] * pivot.y;
        Self { r_wf, p_w, axes_w }
    }

    /// Returns the position in space of a point of the flat sheet.
    #[inline]
    #[must_use]
    pub fn apply(&self, point: Vector2<f64>) -> Vector3<f64> {
        self.turn(point) + self.p_w
    }

    /// Returns the direction in space of a direction of the flat sheet.
    #[inline]
    pub(crate) fn turn(&self, direction: Vector2<f64>) -> Vector3<f64> {
        self.axes_w[0] * direction.x + self.axes_w[1] * direction.y
    }

    /// Returns the unit normal of the face in space.
    pub(crate) fn normal(&self) -> Vector3<f64> {
        self.axes_w[0].cross(&self.axes_w[1])
    }

    /// Returns the new position of a point of space that moves with the flat sheet.
    #[inline]
    #[must_use]
    pub fn carry(&self, point: &Vector3<f64>) -> Vector3<f64> {
        self.r_wf.rotate(point) + self.p_w
    }
}

impl core::ops::Mul for Pose {
    type Output = Self;

    /// Returns the composition of two motions: first `other`, then this one.
    #[inline]
    fn mul(self, other: Self) -> Self {
        Self::new(self.r_wf * other.r_wf, self.carry(&other.p_w))
    }
}
