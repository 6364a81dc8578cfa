//! The Jacobian of closure by the crease pattern: how does the closure of a star or a loop change if creases are drawn
//! elsewhere?
//!
//! A crease at plane angle α turns the faces behind it by χ = Z(α) X(ρ) Z(α)⁻¹, where Z turns about the normal of the
//! sheet. To turn the crease by dα is to turn everything behind it about the normal of the face before the crease, and
//! back about the normal of the face beyond: dχ = (z χ - χ z) dα. With P the product before the crease and P' = P χ the
//! product behind it, L therefore changes as by a turn about the axis P z - P' z, so that ∂r/∂α is the derivative of
//! [`closure`](crate::closure) for this axis.
//!
//! A crease of a [loop](crate::hole) also has a place. To turn it about its place q is the same turn about the point
//! P q + p. To shift it to the left by dn (units of the loop's size) is to shift everything behind it by P n dn, and
//! back by P' n dn, with n = (-sin α, cos α, 0): it changes the translation by P n - P' n and the rotation not at all.
//!
//! The middle and the size of a loop count as fixed. At a loop that closes this makes no difference, because then no
//! point is displaced.

use nalgebra::Vector3;

use crate::closure::{derivative, positive};
use crate::hole::Motion;
use crate::{HalfAngle, LoopView, Rotation, Scalar, StarView};

/// Derivatives of the residuals of a loop by the plane angle and the place of a crease.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LoopColumn<T> {
    /// Derivative of the residual of rotation by the plane angle, per radian.
    pub turn: Vector3<T>,
    /// Derivative of the residual of translation by the plane angle, per radian.
    pub turn_moves: Vector3<T>,
    /// Derivative of the residual of translation by a shift of the crease to the left of its direction, per unit of the
    /// loop's size.
    pub shift: Vector3<T>,
}

impl<T: Scalar> Default for LoopColumn<T> {
    fn default() -> Self {
        let zero = Vector3::new(T::zero(), T::zero(), T::zero());
        Self {
            turn: zero,
            turn_moves: zero,
            shift: zero,
        }
    }
}

/// Writes the derivative of the closure residual r of a star by the plane angle of each spoke (per radian) to `columns`.
///
/// Returns `None` if `columns` does not have one entry for each spoke, or if a group has no half angle. Cost: O(degree).
pub fn star_columns<T: Scalar>(
    star: StarView<'_, T>,
    half_angles: &[HalfAngle<T>],
    columns: &mut [Vector3<T>],
) -> Option<()> {
    if columns.len() != star.spokes.len() {
        return None;
    }
    let mut product = Rotation::identity();
    for (spoke, column) in star.spokes.iter().zip(columns.iter_mut()) {
        let half = half_angles.get(spoke.group.index())?.signed(spoke.negative);
        let before = product;
        product = product.across_crease(half, spoke.direction);
        *column = normal(before) - normal(product);
    }
    let closure = positive(product);
    for column in columns {
        *column = derivative(closure, column);
    }
    Some(())
}

/// Writes the derivatives of the residuals of a loop by plane angle and place of each spoke to `columns`.
///
/// Returns `None` if `columns` does not have one entry for each spoke, or if a group has no half angle. Cost: O(degree).
pub fn loop_columns<T: Scalar>(
    cycle: LoopView<'_, T>,
    half_angles: &[HalfAngle<T>],
    columns: &mut [LoopColumn<T>],
) -> Option<()> {
    if columns.len() != cycle.spokes.len() {
        return None;
    }
    let spokes = cycle.spokes.iter().zip(cycle.places);
    let mut motion = Motion::none();
    for ((spoke, place), column) in spokes.zip(columns.iter_mut()) {
        let half = half_angles.get(spoke.group.index())?.signed(spoke.negative);
        let [x, y] = spoke.direction;
        let before = motion.turned;
        // The point about which the crease is turned, until the translation of the whole loop is known.
        column.turn_moves = motion.apply(place);
        motion.turn(half, spoke, place);
        column.turn = normal(before) - normal(motion.turned);
        column.shift = before.rotate_in_sheet([-y, x]) - motion.turned.rotate_in_sheet([-y, x]);
    }
    let closure = positive(motion.turned);
    for column in columns {
        let axis = column.turn;
        column.turn = derivative(closure, &axis);
        column.turn_moves = axis.cross(&(motion.moved - column.turn_moves));
    }
    Some(())
}

/// Returns the normal of a face that is turned by this rotation.
fn normal<T: Scalar>(turned: Rotation<T>) -> Vector3<T> {
    let Rotation { w, v } = turned;
    Vector3::new(
        (v.x * v.z + w * v.y) * T::TWO,
        (v.y * v.z - w * v.x) * T::TWO,
        T::one() - (v.x * v.x + v.y * v.y) * T::TWO,
    )
}
