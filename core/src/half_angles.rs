//! Sines and cosines of half the fold angles, several `f64` at once.
//!
//! A hinge turns by at most half a turn, so that half its angle stays within a quarter turn. There libm's sine and
//! cosine are two polynomials and one step of argument reduction, and each of their branches can be a choice between
//! two results. Compilers therefore compute several angles at once, in about half the time. The operations are libm's,
//! one by one, and every bit of the results is libm's. Angles at which libm reduces the argument in another way, such
//! as half a turn itself, are left to libm.
//!
//! The polynomials and the parts of π/2 are those of fdlibm (Sun Microsystems, 1993), as in libm.

use crate::HalfAngle;

/// Half angles below this size, radians, are computed here: π/2 with its last 32 bits set to 0.
const END_RAD: f64 = f64::from_bits(0x3ff9_21fb_0000_0000);
/// Half angles below this size, radians, need no argument reduction: the first number above π/4 whose last 32 bits are
/// 0.
const REDUCED_FROM_RAD: f64 = f64::from_bits(0x3fe9_21fc_0000_0000);
/// π/2 in two parts, the first of 33 bits.
const QUARTER: [f64; 2] = [
    f64::from_bits(0x3ff9_21fb_5440_0000),
    f64::from_bits(0x3dd0_b461_1a62_6331),
];

/// Coefficients of sin r, from the term r³ on.
const SINE: [f64; 6] = [
    f64::from_bits(0xbfc5_5555_5555_5549),
    f64::from_bits(0x3f81_1111_1110_f8a6),
    f64::from_bits(0xbf2a_01a0_19c1_61d5),
    f64::from_bits(0x3ec7_1de3_57b1_fe7d),
    f64::from_bits(0xbe5a_e5e6_8a2b_9ceb),
    f64::from_bits(0x3de5_d93a_5acf_d57c),
];
/// Coefficients of cos r, from the term r⁴ on.
const COSINE: [f64; 6] = [
    f64::from_bits(0x3fa5_5555_5555_554c),
    f64::from_bits(0xbf56_c16c_16c1_5177),
    f64::from_bits(0x3efa_01a0_19cb_1590),
    f64::from_bits(0xbe92_7e4f_809c_52ad),
    f64::from_bits(0x3e21_ee9e_bdb4_b1c4),
    f64::from_bits(0xbda8_fae9_be88_38d4),
];

/// Writes the half angles of `angles` (radians) to `out`, up to the end of the shorter slice.
pub(crate) fn of_f64(angles: &[f64], out: &mut [HalfAngle<f64>]) {
    let mut all_near = true;
    for (half, rho) in out.iter_mut().zip(angles) {
        let angle = 0.5 * rho;
        all_near &= angle.abs() < END_RAD;
        *half = within_quarter(angle);
    }
    if !all_near {
        far_ones(angles, out);
    }
}

/// Recomputes by libm each half angle that is not below [`END_RAD`]. This loop is separate, so that the other one has
/// no branch.
#[cold]
#[inline(never)]
fn far_ones(angles: &[f64], out: &mut [HalfAngle<f64>]) {
    for (half, &rho) in out.iter_mut().zip(angles) {
        let near = (0.5 * rho).abs() < END_RAD;
        if !near {
            *half = HalfAngle::of(rho);
        }
    }
}

/// Writes the half angles of `angles` in any precision, one at a time, by the sine and cosine of the type.
pub(crate) fn one_by_one<T: crate::Scalar>(angles: &[T], out: &mut [HalfAngle<T>]) {
    for (half, &rho) in out.iter_mut().zip(angles) {
        *half = HalfAngle::of(rho);
    }
}

/// Returns cosine and sine of an angle whose size is below [`END_RAD`]. The result for other angles is meaningless.
#[inline(always)]
fn within_quarter(angle: f64) -> HalfAngle<f64> {
    let size = angle.abs();
    let far = size >= REDUCED_FROM_RAD;
    let [high, low] = QUARTER;
    let reduced = (size - high) - low;
    let rest = ((size - high) - reduced) - low;
    // The angle is r + t, with t below the precision of r.
    let (r, t) = if far { (reduced, rest) } else { (size, 0.0) };
    let z = r * r;
    let w = z * z;

    let [s1, s2, s3, s4, s5, s6] = SINE;
    let p = s2 + z * (s3 + z * s4) + z * w * (s5 + z * s6);
    let v = z * r;
    let sine = r + v * (s1 + z * p);
    let sine_of_sum = r - ((z * (0.5 * t - v * p) - t) - v * s1);

    let [c1, c2, c3, c4, c5, c6] = COSINE;
    let q = z * (c1 + z * (c2 + z * c3)) + w * w * (c4 + z * (c5 + z * c6));
    let half_square = 0.5 * z;
    let most = 1.0 - half_square;
    let cosine = most + (((1.0 - most) - half_square) + (z * q - r * t));

    let (sin, cos) = if far {
        (cosine, -sine_of_sum)
    } else {
        (sine, cosine)
    };
    HalfAngle {
        cos,
        sin: sin.copysign(angle),
    }
}
