//! The closure residual of a star and its analytic Jacobian.
//!
//! Round a vertex, the unit quaternions (cos ρ/2, sin ρ/2 (cos α, sin α, 0)) of its creases are
//! multiplied counter-clockwise. Their product L is the rotation part of the report's local
//! foldability matrix, and the star closes where it is the identity, Eq. (1) of
//! [XiLien2015](crate#references).
//!
//! The residual is r = 2 sgn(w) v of L = (w, v). Its norm is 2 |sin θ/2| for a misclosure by the
//! angle θ, which is ‖L − I‖ (Frobenius) over √2; unlike the skew part of L it does not vanish at a
//! half turn.
//!
//! With P the product before crease k and a = P·axis, ∂L/∂ρ = ½ (0, a) L, so that
//! ∂r/∂ρ = w a + a × v with (w, v) sign-fixed. That is exact and costs O(degree).

use nalgebra::Vector3;

use crate::{HalfAngle, Rotation, Scalar, StarView};

/// The rotation by which the star fails to close.
///
/// `half_angles` has one entry for each unknown, see [`half_angles`]; a spoke whose group is not
/// there counts as flat. Cost: 12 multiplications a spoke.
#[inline]
#[must_use]
pub fn misclosure<T: Scalar>(star: StarView<'_, T>, half_angles: &[HalfAngle<T>]) -> Rotation<T> {
    let mut product = Rotation::identity();
    for spoke in star.spokes {
        if let Some(half) = half_angles.get(spoke.group.index()) {
            product = product.across_crease(half.signed(spoke.negative), spoke.direction);
        }
    }
    product
}

/// The closure residual r (dimensionless, about radians): zero exactly where the star closes.
#[inline]
#[must_use]
pub fn residual<T: Scalar>(star: StarView<'_, T>, half_angles: &[HalfAngle<T>]) -> Vector3<T> {
    let closure = positive(misclosure(star, half_angles));
    closure.v * T::TWO
}

/// Whether the closure residual is at most `bound`; a bound below 0 allows none.
#[inline]
#[must_use]
pub fn closes<T: Scalar>(star: StarView<'_, T>, half_angles: &[HalfAngle<T>], bound: T) -> bool {
    let residual = residual(star, half_angles);
    bound >= T::zero() && residual.dot(&residual) <= bound * bound
}

/// The closure residual, and its derivative by the fold angle of each spoke in `columns`.
///
/// Returns `None` if `columns` has not the length of the star or a group is missing.
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
    // Before the first crease nothing is turned.
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

/// ∂r/∂ρ of a turn about the `axis` a where the product is L = (w, v), sign-fixed.
#[inline]
pub(crate) fn derivative<T: Scalar>(product: Rotation<T>, axis: &Vector3<T>) -> Vector3<T> {
    *axis * product.w + axis.cross(&product.v)
}

/// Fills `out` with the half angles of the `unknowns` (radians), as far as both reach.
///
/// Done once for each evaluation, so that a crease group costs one sine and cosine, however many
/// creases it has.
pub fn half_angles<T: Scalar>(unknowns: &[T], out: &mut [HalfAngle<T>]) {
    T::half_angles(unknowns, out);
}

/// Of the two quaternions of a rotation, the one with w >= 0.
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
