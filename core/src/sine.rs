//! Sine and cosine of `f32` in `f32` arithmetic alone.
//!
//! libm's sine and cosine compute in `f64`, which a Cortex-M4F has in software only: they take 2,105 instructions,
//! these about 60. Additions and multiplications in a fixed order, never fused, give the same bits everywhere.
//!
//! The argument is reduced to an eighth of a turn in the manner of W. J. Cody and W. Waite, "Software manual for the
//! elementary functions" (1980), with π/2 in three parts. On that interval the polynomials are those of least largest
//! error (E. Remez) for their degrees.

/// Largest argument that has a sine and a cosine here, radians: 8,191 quarter turns. The product of that number with
/// each of the first two parts of π/2 is still exact.
const MAX_RAD: f32 = 12_866.0;

/// π/2 in three parts, the first two of 11 bits each.
const QUARTER: [f32; 3] = [1.570_312_5, 4.837_513e-4, 7.549_79e-8];
/// 1.5 · 2²³: added to a small number, it leaves the nearest integer in the lowest bits.
const ROUNDER: f32 = 12_582_912.0;

/// Coefficients of (sin r − r) / r³ as a polynomial in r². Relative error of the sine below 2e-9.
const SINE: [f32; 3] = [-0.166_666_51, 0.008_331_972, -1.949_476_3e-4];
/// Coefficients of (cos r − 1 + r²/2) / r⁴ as a polynomial in r². Error of the cosine below 1e-10.
const COSINE: [f32; 3] = [0.041_666_646, -0.001_388_736, 2.443_753_3e-5];

/// Returns sine and cosine of `angle` (radians), each with an error of at most 8e-8; NaN beyond 12,866 radians.
#[inline]
#[must_use]
pub(crate) fn sine_cosine(angle: f32) -> (f32, f32) {
    if angle.is_nan() || angle.abs() > MAX_RAD {
        return (f32::NAN, f32::NAN);
    }
    let rounded = angle * core::f32::consts::FRAC_2_PI + ROUNDER;
    let quarters = rounded - ROUNDER;
    let [a, b, c] = QUARTER;
    let r = angle - quarters * a - quarters * b - quarters * c;
    let z = r * r;
    let [s0, s1, s2] = SINE;
    let sine = r + r * z * (s0 + z * (s1 + z * s2));
    let [c0, c1, c2] = COSINE;
    let cosine = 1.0 - (0.5 * z - z * z * (c0 + z * (c1 + z * c2)));
    match rounded.to_bits() & 3 {
        0 => (sine, cosine),
        1 => (cosine, -sine),
        2 => (-sine, -cosine),
        _ => (-cosine, sine),
    }
}
