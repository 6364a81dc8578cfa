//! Planar isometries: the candidates for symmetries of the sheet.

use nalgebra::{Matrix2, Vector2};

/// x ↦ m x + t with m orthogonal, and whether it exchanges mountain and valley.
#[derive(Clone, Copy, Debug)]
pub(super) struct Isometry {
    linear: Matrix2<f64>,
    shift: Vector2<f64>,
    /// Whether mountain becomes valley: the sheet is turned over as well.
    pub(super) flips: bool,
}

impl Isometry {
    /// The isometry that takes the point `from` to `to` and the unit direction `from_dir` there to
    /// `to_dir`; of the two, the one that keeps the sense of turning unless `mirrors`.
    pub(super) fn between(
        [from, to]: [Vector2<f64>; 2],
        [from_dir, to_dir]: [Vector2<f64>; 2],
        mirrors: bool,
        flips: bool,
    ) -> Self {
        let side = |d: Vector2<f64>| Vector2::new(-d.y, d.x);
        let sense = if mirrors { -1.0 } else { 1.0 };
        let linear =
            to_dir * from_dir.transpose() + side(to_dir) * side(from_dir).transpose() * sense;
        Self {
            linear,
            shift: to - linear * from,
            flips,
        }
    }

    pub(super) fn apply(&self, point: Vector2<f64>) -> Vector2<f64> {
        self.linear * point + self.shift
    }

    pub(super) fn turn(&self, direction: Vector2<f64>) -> Vector2<f64> {
        self.linear * direction
    }

    pub(super) fn inverse(&self) -> Self {
        let linear = self.linear.transpose();
        Self {
            linear,
            shift: -(linear * self.shift),
            flips: self.flips,
        }
    }
}
