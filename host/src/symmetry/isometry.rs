//! Planar isometries, the candidates for symmetries of the sheet, and their fit to pairs of points.

use nalgebra::{Matrix2, Vector2};

/// The map x ↦ m x + t with an orthogonal matrix m.
#[derive(Clone, Copy, Debug)]
pub(super) struct Isometry {
    linear: Matrix2<f64>,
    shift: Vector2<f64>,
    /// `true` if m is a reflection, which reverses the sense of turning.
    pub(super) mirrors: bool,
    /// `true` if mountain becomes valley: the isometry also turns the sheet over.
    pub(super) flips: bool,
}

impl Isometry {
    /// Returns the isometry that takes the point `from` to `to` and the unit direction `from_dir` there to `to_dir`.
    /// `mirrors` selects the reflection among the two such isometries.
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
            mirrors,
            flips,
        }
    }

    /// Returns the isometry that takes the first points of the pairs to the second with the least sum of squared
    /// distances (rigid registration in the plane). It keeps the orientation of this isometry, and is this isometry
    /// itself if there are fewer than two pairs.
    pub(super) fn fitted(&self, pairs: &[[Vector2<f64>; 2]]) -> Self {
        if pairs.len() < 2 {
            return *self;
        }
        #[allow(clippy::cast_precision_loss, reason = "a mean")]
        let count = pairs.len() as f64;
        let center = pairs.iter().fold([Vector2::zeros(); 2], |sum, pair| {
            [sum[0] + pair[0] / count, sum[1] + pair[1] / count]
        });
        // Sine and cosine of the rotation that remains after this isometry, times a common factor.
        let (mut sin, mut cos) = (0.0, 0.0);
        for [from, to] in pairs {
            let (from, to) = (self.turn(from - center[0]), to - center[1]);
            sin += from.perp(&to);
            cos += from.dot(&to);
        }
        let size = sin.hypot(cos);
        if size <= 0.0 {
            return *self;
        }
        let (sin, cos) = (sin / size, cos / size);
        let linear = Matrix2::new(cos, -sin, sin, cos) * self.linear;
        Self {
            linear,
            shift: center[1] - linear * center[0],
            ..*self
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
            ..*self
        }
    }
}

/// A matching of the spokes of a star with those of another star of the same degree.
#[derive(Clone, Copy)]
pub(super) struct StarImage {
    /// The spoke of the other star that matches the first spoke.
    pub(super) first: usize,
    pub(super) mirrored: bool,
}

impl StarImage {
    /// Returns the spoke of `star` that matches spoke `k`.
    pub(super) fn of<'s, S>(&self, k: usize, star: &'s [S]) -> &'s S {
        // Indices are cyclic: index n is index 0 again.
        let n = star.len();
        let wrapped = |k: usize| if k < n { k } else { k - n };
        let k = wrapped(k);
        &star[wrapped(self.first + if self.mirrored { wrapped(n - k) } else { k })]
    }
}
