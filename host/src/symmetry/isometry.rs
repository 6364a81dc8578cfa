//! Planar isometries: the candidates for symmetries of the sheet.

use nalgebra::{Matrix2, Vector2};

/// x ↦ m x + t with m orthogonal, and whether it exchanges mountain and valley.
#[derive(Clone, Copy, Debug)]
pub(super) struct Isometry {
    linear: Matrix2<f64>,
    shift: Vector2<f64>,
    /// Whether it reverses the sense of turning.
    pub(super) mirrors: bool,
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
            mirrors,
            flips,
        }
    }

    /// The isometry nearest to this one that takes the first points of the pairs to the second as well
    /// as possible, in the sense of least squares. This one if there are fewer than two.
    pub(super) fn fitted(&self, pairs: &[[Vector2<f64>; 2]]) -> Self {
        if pairs.len() < 2 {
            return *self;
        }
        #[allow(clippy::cast_precision_loss, reason = "a mean")]
        let count = pairs.len() as f64;
        let center = pairs.iter().fold([Vector2::zeros(); 2], |sum, pair| {
            [sum[0] + pair[0] / count, sum[1] + pair[1] / count]
        });
        // What turn remains after this one.
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

/// How the spokes of a star lie on those of another of as many.
#[derive(Clone, Copy)]
pub(super) struct StarImage {
    /// The spoke on which the first one lies.
    pub(super) first: usize,
    pub(super) mirrored: bool,
}

impl StarImage {
    /// The spoke of `star` on which spoke `k` lies.
    pub(super) fn of<'s, S>(&self, k: usize, star: &'s [S]) -> &'s S {
        // Positions from n on are those from 0 once more.
        let n = star.len();
        let wrapped = |k: usize| if k < n { k } else { k - n };
        let k = wrapped(k);
        &star[wrapped(self.first + if self.mirrored { wrapped(n - k) } else { k })]
    }
}
