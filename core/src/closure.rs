//! The closure residual of a star and its analytic Jacobian: does a vertex close, and how does that change with its
//! fold angles?
//!
//! Round a vertex, the unit quaternions (cos ρ/2, sin ρ/2 (cos α, sin α, 0)) of its creases are multiplied
//! counter-clockwise. Their product L is the rotation part of the report's local foldability matrix, and the star
//! closes if L is the identity, Eq. (1) of [XiLien2015](crate#references).
//!
//! The residual is r = 2 sgn(w) v of L = (w, v). Its norm is 2 |sin θ/2| for a misclosure by the angle θ, which is
//! ‖L − I‖ (Frobenius) over √2. Unlike the skew part of L, the residual does not vanish at a half turn.
//!
//! With P the product before crease k and a = P·axis, ∂L/∂ρ = ½ (0, a) L, so that ∂r/∂ρ = w a + a × v with (w, v)
//! sign-fixed. This Jacobian is exact and costs O(degree).

use nalgebra::Vector3;

use crate::curve::half_angle;
use crate::{HalfAngle, Rotation, Scalar, StarView};

/// Returns the rotation by which the star fails to close.
///
/// `half_angles` has one entry for each unknown, see [`half_angles`]; a spoke whose group has no entry counts as flat.
/// Cost: 12 multiplications per spoke.
#[inline]
#[must_use]
pub fn misclosure<T: Scalar>(star: StarView<'_, T>, half_angles: &[HalfAngle<T>]) -> Rotation<T> {
    product(star, |group| half_angles.get(group).copied())
}

/// Returns the product of the folds of a star, given the half angle of each group; a group without one is flat.
#[inline]
fn product<T: Scalar>(
    star: StarView<'_, T>,
    half: impl Fn(usize) -> Option<HalfAngle<T>>,
) -> Rotation<T> {
    let mut product = Rotation::identity();
    for spoke in star.spokes {
        if let Some(half) = half(spoke.group.index()) {
            product = product.across_crease(half.signed(spoke.negative), spoke.direction);
        }
    }
    product
}

/// Returns the closure residual r (dimensionless, about radians), which is zero exactly if the star closes.
#[inline]
#[must_use]
pub fn residual<T: Scalar>(star: StarView<'_, T>, half_angles: &[HalfAngle<T>]) -> Vector3<T> {
    let closure = positive(misclosure(star, half_angles));
    closure.v * T::TWO
}

/// Returns `true` if the norm of the closure residual is at most `bound`; always `false` for a bound below 0.
#[inline]
#[must_use]
pub fn closes<T: Scalar>(star: StarView<'_, T>, half_angles: &[HalfAngle<T>], bound: T) -> bool {
    is_within(residual(star, half_angles), bound)
}

/// Returns what [`closes`] does, for the fold angles of the unknowns, radians.
// Not inlined, so that sine and cosine are not copied into each tick.
#[inline(never)]
pub(crate) fn closes_at<T: Scalar>(star: StarView<'_, T>, angles: &[T], bound: T) -> bool {
    let product = product(star, |group| angles.get(group).copied().map(half_angle));
    // The sign of the quaternion does not change the length of its vector.
    is_within(product.v * T::TWO, bound)
}

#[inline]
fn is_within<T: Scalar>(residual: Vector3<T>, bound: T) -> bool {
    bound >= T::zero() && residual.dot(&residual) <= bound * bound
}

/// Returns the closure residual and writes its derivative by the unknown of each spoke to `columns`.
///
/// The sign of a `negative` spoke is therefore included. Returns `None` if `columns` does not have one entry for each
/// spoke, or if a group is missing.
#[inline]
pub fn residual_and_jacobian<T: Scalar>(
    star: StarView<'_, T>,
    half_angles: &[HalfAngle<T>],
    columns: &mut [Vector3<T>],
) -> Option<Vector3<T>> {
    if columns.len() != star.spokes.len() {
        return None;
    }
    let mut spokes = star.spokes.iter().zip(columns.iter_mut());
    let mut product = Rotation::identity();
    // Before the first crease the product is the identity: its column is the axis itself.
    if let Some((spoke, column)) = spokes.next() {
        let half = *half_angles.get(spoke.group.index())?;
        let [x, y] = spoke.axis();
        *column = Vector3::new(x, y, T::zero());
        product = Rotation::about_crease(half, [x, y]);
    }
    for (spoke, column) in spokes {
        let half = *half_angles.get(spoke.group.index())?;
        let axis = spoke.axis();
        *column = product.rotate_in_sheet(axis);
        product = product.across_crease(half, axis);
    }
    let Rotation { w, v } = positive(product);
    for column in columns {
        *column = derivative(Rotation { w, v }, column);
    }
    Some(v * T::TWO)
}

/// Returns ∂r/∂ρ of a turn about the `axis` a, where the product of the star is L = (w, v), sign-fixed.
#[inline]
pub(crate) fn derivative<T: Scalar>(product: Rotation<T>, axis: &Vector3<T>) -> Vector3<T> {
    *axis * product.w + axis.cross(&product.v)
}

/// Writes the half angles of the `unknowns` (radians) to `out`; stops at the end of the shorter slice.
///
/// Called once per evaluation, so that a crease group costs one sine and one cosine however many creases it has.
pub fn half_angles<T: Scalar>(unknowns: &[T], out: &mut [HalfAngle<T>]) {
    T::half_angles(unknowns, out);
}

/// Returns the one with w >= 0 of the two quaternions that stand for a rotation.
#[inline]
pub(crate) fn positive<T: Scalar>(rotation: Rotation<T>) -> Rotation<T> {
    if rotation.w < T::zero() {
        Rotation {
            w: -rotation.w,
            v: -rotation.v,
        }
    } else {
        rotation
    }
}
