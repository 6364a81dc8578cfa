//! Rotations as unit quaternions, the form that the solvers compute with.
//!
//! nalgebra's quaternions need its `RealField`, which [`Scalar`](crate::Scalar) avoids on purpose. This file has the
//! small part of their algebra that folding needs.

use nalgebra::{Matrix3, Vector3};

use crate::Scalar;

/// A rotation `r_ab`: takes coordinates in frame b to coordinates in frame a.
///
/// Stored as the unit quaternion (w, v) = (cos θ/2, axis · sin θ/2). Composition reads `r_ac = r_ab * r_bc`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Rotation<T> {
    /// Scalar part, cos θ/2.
    pub w: T,
    /// Vector part, axis · sin θ/2.
    pub v: Vector3<T>,
}

impl<T: Scalar> Rotation<T> {
    /// Returns the identity.
    #[must_use]
    pub fn identity() -> Self {
        Self {
            w: T::one(),
            v: Vector3::new(T::zero(), T::zero(), T::zero()),
        }
    }

    /// Returns the rotation about an axis in the plane of the sheet, given cosine and sine of half the angle and the
    /// axis' direction (cos α, sin α).
    #[inline]
    #[must_use]
    pub fn about_crease(half: HalfAngle<T>, direction: [T; 2]) -> Self {
        let [x, y] = direction;
        Self {
            w: half.cos,
            v: Vector3::new(half.sin * x, half.sin * y, T::zero()),
        }
    }

    /// Returns this rotation times that about a crease, see [`about_crease`](Self::about_crease). This is the general
    /// product without the terms of the axis' z, which is 0.
    #[inline]
    #[must_use]
    pub fn across_crease(self, half: HalfAngle<T>, direction: [T; 2]) -> Self {
        let HalfAngle { cos, sin } = half;
        let (x, y) = (sin * direction[0], sin * direction[1]);
        let Self { w, v } = self;
        Self {
            w: w * cos - v.x * x - v.y * y,
            v: Vector3::new(
                v.x * cos + w * x - v.z * y,
                v.y * cos + w * y + v.z * x,
                v.z * cos + v.x * y - v.y * x,
            ),
        }
    }

    /// Returns this rotation scaled back to length 1, which repeated products lose by rounding.
    #[inline]
    #[must_use]
    pub fn renormalised(self) -> Self {
        let scale = T::one() / (self.w * self.w + self.v.dot(&self.v)).sqrt();
        Self {
            w: self.w * scale,
            v: self.v * scale,
        }
    }

    /// Returns the rotation by the opposite angle.
    #[inline]
    #[must_use]
    pub fn inverse(self) -> Self {
        Self {
            w: self.w,
            v: -self.v,
        }
    }

    /// Returns `vector` rotated.
    #[inline]
    #[must_use]
    pub fn rotate(self, vector: &Vector3<T>) -> Vector3<T> {
        let t = self.v.cross(vector) * T::TWO;
        vector + t * self.w + self.v.cross(&t)
    }

    /// Returns the vector (`x`, `y`, 0) rotated: [`rotate`](Self::rotate) without the terms of the vector's z.
    #[inline]
    #[must_use]
    pub fn rotate_in_sheet(self, [x, y]: [T; 2]) -> Vector3<T> {
        let v = self.v;
        let t = Vector3::new(-v.z * y, v.z * x, v.x * y - v.y * x) * T::TWO;
        let moved = t * self.w;
        Vector3::new(x + moved.x, y + moved.y, moved.z) + v.cross(&t)
    }

    /// Returns this rotation as a 3x3 matrix.
    #[must_use]
    pub fn matrix(self) -> Matrix3<T> {
        let unit = |x, y, z| self.rotate(&Vector3::new(x, y, z));
        let (zero, one) = (T::zero(), T::one());
        Matrix3::from_columns(&[
            unit(one, zero, zero),
            unit(zero, one, zero),
            unit(zero, zero, one),
        ])
    }
}

impl<T: Scalar> core::ops::Mul for Rotation<T> {
    type Output = Self;

    #[inline]
    fn mul(self, other: Self) -> Self {
        Self {
            w: self.w * other.w - self.v.dot(&other.v),
            v: other.v * self.w + self.v * other.w + self.v.cross(&other.v),
        }
    }
}

/// Cosine and sine of half a fold angle; the default is flat.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct HalfAngle<T> {
    /// cos ρ/2.
    pub cos: T,
    /// sin ρ/2.
    pub sin: T,
}

impl<T: Scalar> Default for HalfAngle<T> {
    fn default() -> Self {
        Self {
            cos: T::one(),
            sin: T::zero(),
        }
    }
}

impl<T: Scalar> HalfAngle<T> {
    /// Returns the half angle of the fold angle `rho` (radians).
    #[inline]
    #[must_use]
    pub fn of(rho: T) -> Self {
        let (sin, cos) = (rho * T::HALF).sin_cos();
        Self { cos, sin }
    }

    /// Returns the half angle of the opposite fold angle if `negative`, else this one.
    #[inline]
    #[must_use]
    pub fn signed(self, negative: bool) -> Self {
        Self {
            cos: self.cos,
            sin: if negative { -self.sin } else { self.sin },
        }
    }
}
