//! Powers of a rigid motion, by its decomposition into a screw motion (Chasles).

use foldpath_core::Rotation;
use nalgebra::Vector3;

use crate::folding::Pose;

/// A rigid motion as a rotation about an axis and a translation along it (Chasles), which makes its powers as
/// cheap and as exact as the motion itself.
#[derive(Clone, Copy, Debug)]
pub struct Screw {
    motion: Pose,
    /// Unit direction of the axis; zero if the motion does not rotate.
    axis: Vector3<f64>,
    /// Sine (`sin`) and cosine (`cos`) of half the angle of rotation, and half the angle itself (`half`), at
    /// most a quarter turn.
    sin: f64,
    cos: f64,
    half: f64,
    /// Components of the origin's motion along the axis and across it.
    along: Vector3<f64>,
    across: Vector3<f64>,
}

impl Screw {
    /// Returns the motion as a screw.
    #[must_use]
    pub fn new(motion: Pose) -> Self {
        let mut r = motion.r_wf.renormalised();
        if r.w < 0.0 {
            // The quaternion of opposite sign is the same rotation; with w ≥ 0, sines of multiples of a small
            // angle keep their digits.
            (r.w, r.v) = (-r.w, -r.v);
        }
        let sin = r.v.norm();
        let axis = if sin > 0.0 {
            r.v / sin
        } else {
            Vector3::zeros()
        };
        let along = axis * axis.dot(&motion.p_w);
        Self {
            motion,
            axis,
            sin,
            cos: r.w,
            half: sin.atan2(r.w),
            along,
            across: motion.p_w - along,
        }
    }

    /// Returns the motion itself.
    #[must_use]
    pub fn motion(&self) -> Pose {
        self.motion
    }

    /// Returns the length of the translation along the axis; of the whole translation if the motion does not rotate.
    #[must_use]
    pub fn pitch(&self) -> f64 {
        if self.sin > 0.0 {
            self.along.norm()
        } else {
            self.motion.p_w.norm()
        }
    }

    /// Returns twice the distance from the axis of a point that the motion moves by `way`, or a little more;
    /// infinite if the motion does not rotate.
    #[must_use]
    pub fn width(&self, way: Vector3<f64>) -> f64 {
        let across = (way - self.axis * self.axis.dot(&way)).norm();
        if self.sin > 0.0 {
            // The second term covers what rounding may hide.
            (across + 8.0 * f64::EPSILON * way.norm()) / self.sin
        } else {
            f64::INFINITY
        }
    }

    /// Returns the motion applied n times, backwards if n is negative.
    ///
    /// With a half the angle, the origin's motions across the axis add up to the first of them, times sin(n
    /// a)/sin(a), turned by (n - 1) a. For small a this tends to n of them without loss of digits, whatever the
    /// axis: the error is n times that of the motion itself, and n² times for the rotation.
    #[must_use]
    pub fn power(&self, n: i32) -> Pose {
        let count = f64::from(n);
        if self.sin <= 0.0 {
            return Pose::new(Rotation::identity(), self.motion.p_w * count);
        }
        let (sin, cos) = (count * self.half).sin_cos();
        let ratio = sin / self.sin;
        let (turn_sin, turn_cos) = (
            sin * self.cos - cos * self.sin,
            cos * self.cos + sin * self.sin,
        );
        let turned = self.across * turn_cos + self.axis.cross(&self.across) * turn_sin;
        let r_wf = Rotation {
            w: cos,
            v: self.axis * sin,
        };
        Pose::new(r_wf, self.along * count + turned * ratio)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use core::f64::consts::PI;

    /// Returns a rotation by `angle` about the axis through `foot`, with a translation along the axis.
    fn screw(axis: Vector3<f64>, foot: Vector3<f64>, angle: f64, shift: f64) -> Pose {
        let (sin, cos) = (angle / 2.0).sin_cos();
        let r_wf = Rotation {
            w: cos,
            v: axis * sin,
        };
        let p_w = foot - r_wf.rotate(&foot) + axis * shift;
        Pose::new(r_wf, p_w)
    }

    /// The angles are whole parts of a turn, for which all multiples are known to the last digit.
    #[test]
    fn powers_turn_as_often_as_they_say() {
        let axis = Vector3::new(2.0, -3.0, 6.0) / 7.0;
        let foot = Vector3::new(0.3, 1.1, -0.4);
        for parts in [1, 2, 3, 7, 24, 999, 1000, 1_000_000] {
            let angle = 2.0 * PI / f64::from(parts);
            let motion = Screw::new(screw(axis, foot, angle, 0.75));
            for n in [-1000, -999, -24, -1, 0, 1, 2, 3, 500, 999, 1000] {
                let expected = screw(
                    axis,
                    foot,
                    2.0 * PI * f64::from(n % parts) / f64::from(parts),
                    0.75 * f64::from(n),
                );
                let point = Vector3::new(-0.6, 0.2, 1.3);
                let off = motion.power(n).carry(&point) - expected.carry(&point);
                // Exact to 1e-12 of the size of a sheet of |n| cells.
                let size = f64::from(n.abs().max(1));
                assert!(off.norm() < 1e-12 * size, "{parts} {n}: {:e}", off.norm());
            }
        }
    }

    /// Nearly no rotation, about any axis: a translation, and a bow of the third order.
    #[test]
    fn a_turn_lost_in_rounding_does_no_harm() {
        for size in [0.0, 1e-300, 1e-17, 1e-15] {
            let r_wf = Rotation {
                w: 1.0,
                v: Vector3::new(0.36, 0.48, 0.8) * size,
            };
            let p_w = Vector3::new(2.0, -0.5, 0.25);
            let power = Screw::new(Pose::new(r_wf, p_w)).power(1000);
            assert!((power.p_w - p_w * 1000.0).norm() < 3e6 * size + 1e-12);
            assert!((power.r_wf.v.norm() - 1000.0 * size).abs() < 1e-15);
        }
    }

    #[test]
    fn a_power_and_its_inverse_cancel() {
        let axis = Vector3::new(0.6, 0.0, -0.8);
        let motion = Screw::new(screw(axis, Vector3::new(1.0, 2.0, 3.0), 2.5, -0.1));
        let both = motion.power(17) * motion.power(-17);
        assert!(both.p_w.norm() < 1e-13 && both.r_wf.v.norm() < 1e-14);
        let (twice, once) = (motion.power(2), motion.motion());
        let off = twice.r_wf.inverse() * (once * once).r_wf;
        let point = Vector3::new(0.5, -1.5, 2.0);
        let way = twice.carry(&point) - once.carry(&once.carry(&point));
        assert!(way.norm() < 1e-14 && off.v.norm() < 1e-15);
    }
}
