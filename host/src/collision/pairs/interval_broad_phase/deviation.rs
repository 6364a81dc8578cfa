//! Bounds how far a point beyond some hinges deviates from a quadratic curve over an interval of a motion.
//!
//! The deviation of a point from the quadratic through its places at the beginning, half way and at the end is at most a small
//! part of the largest third derivative of its place. A bound on that follows the hinges on the way to the point. It begins with
//! the angular velocity and acceleration that each face has at the beginning of the interval. In a tessellation, hinges turn one
//! way and back: a face far away turns no faster than one hinge does, and a sum over all hinges would be far too large.
//!
//! Let w be the angular velocity of a face, w' and w'' its derivatives by time (in intervals), and h the angle of the next hinge
//! about a unit axis a that moves with the face. Beyond the hinge the angular velocity is w + h' a and its derivative
//! w' + h'' a + h' w × a. Its second derivative differs from w'' by no more than |h'''| + 2 |h''| |w| + |h'| (|w'| + |w|²). A
//! point at distance L from a pivot, which moves with the face, has a third derivative of no more than that of the pivot and
//! L (|w''| + 3 |w| |w'| + |w|³).

use nalgebra::Vector3;

use crate::lattice::CUBIC_RATIO;

/// Angular velocity of a face at a time, radians per segment, and its derivative.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Turning {
    velocity: Vector3<f64>,
    acceleration: Vector3<f64>,
    /// Their norms.
    norms: [f64; 2],
}

impl Turning {
    /// Returns the turning beyond a hinge with this axis in space, whose angle has these first and second derivatives.
    pub(super) fn across(&self, axis: Vector3<f64>, [first, second]: [f64; 2]) -> Self {
        let velocity = self.velocity + axis * first;
        let acceleration = self.acceleration + axis * second + self.velocity.cross(&axis) * first;
        Self {
            velocity,
            acceleration,
            norms: [velocity.norm(), acceleration.norm()],
        }
    }
}

/// Bounds on the motion of a face over an interval, with time in intervals.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct MotionBound {
    /// Angular velocity, and its first and second derivative.
    turning: [f64; 3],
    /// Third derivative of the place of the last pivot, units of the sheet.
    pivot: f64,
}

impl MotionBound {
    /// Returns the bounds beyond a hinge at distance `way` from the last pivot, given bounds on the first three derivatives of
    /// its angle, and the turning beyond it at the beginning of the interval, which is this part of a segment.
    pub(super) fn across(&self, way: f64, rates: [f64; 3], beyond: &Turning, part: f64) -> Self {
        let ([first, second, third], [most, change, bend]) = (rates, self.turning);
        let bend = bend + third + 2.0 * second * most + first * (change + most * most);
        let [velocity, acceleration] = [beyond.norms[0] * part, beyond.norms[1] * part * part];
        Self {
            turning: [
                velocity + acceleration + bend / 2.0,
                acceleration + bend,
                bend,
            ],
            pivot: self.third_derivative(way),
        }
    }

    /// Returns a bound on the third derivative of the place of a point at this distance from the last pivot.
    fn third_derivative(&self, distance: f64) -> f64 {
        let [most, change, bend] = self.turning;
        self.pivot + distance * (bend + 3.0 * most * change + most.powi(3))
    }

    /// Returns a bound on the deviation of a point at this distance from the last pivot from its quadratic, units of the sheet.
    pub(super) fn deviation(&self, distance: f64) -> f64 {
        CUBIC_RATIO * self.third_derivative(distance)
    }
}
