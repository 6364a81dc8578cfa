//! Folding matrices in the report's 4x4 homogeneous form.
//!
//! Implements section 3.2 of [XiLien2015](crate#references): the folding matrix χ = A B C B⁻¹ A⁻¹ and the local
//! foldability matrix L(v) = Π χ. The solvers run on the quaternion form in [`closure`](crate::closure); a test shows
//! that both are equal.

use nalgebra::Matrix4;

use crate::{Scalar, StarView};

/// Returns the folding matrix χ of crossing a crease counter-clockwise about its `witness` vertex.
///
/// `alpha` is the plane angle of the crease seen from the witness, `rho` its fold angle, both in radians; `witness` is
/// a point in the sheet's plane.
#[must_use]
pub fn folding_matrix<T: Scalar>(witness: [T; 2], alpha: T, rho: T) -> Matrix4<T> {
    let [x, y] = witness;
    let (sin_alpha, cos_alpha) = alpha.sin_cos();
    translation(x, y)
        * about_z(cos_alpha, sin_alpha)
        * about_x(rho)
        * about_z(cos_alpha, -sin_alpha)
        * translation(-x, -y)
}

/// Returns the local foldability matrix L of a star whose vertex lies at `witness`.
///
/// L is the product of the folding matrices of the star's creases, counter-clockwise; the star closes if L is the
/// identity. `unknowns` holds the fold angles (radians) of the groups that the star refers to; a spoke whose group is
/// out of range counts as flat.
#[must_use]
pub fn local_foldability_matrix<T: Scalar>(
    star: StarView<'_, T>,
    witness: [T; 2],
    unknowns: &[T],
) -> Matrix4<T> {
    star.spokes
        .iter()
        .fold(Matrix4::identity(), |product, spoke| {
            let [cos, sin] = spoke.direction;
            product * folding_matrix(witness, sin.atan2(cos), spoke.fold_angle(unknowns))
        })
}

fn translation<T: Scalar>(x: T, y: T) -> Matrix4<T> {
    let (o, i) = (T::zero(), T::one());
    Matrix4::new(i, o, o, x, o, i, o, y, o, o, i, o, o, o, o, i)
}

fn about_z<T: Scalar>(cos: T, sin: T) -> Matrix4<T> {
    let (o, i) = (T::zero(), T::one());
    Matrix4::new(cos, -sin, o, o, sin, cos, o, o, o, o, i, o, o, o, o, i)
}

fn about_x<T: Scalar>(rho: T) -> Matrix4<T> {
    let (sin, cos) = rho.sin_cos();
    let (o, i) = (T::zero(), T::one());
    Matrix4::new(i, o, o, o, o, cos, -sin, o, o, sin, cos, o, o, o, o, i)
}
