//! Are sines and cosines within the stated errors, and are those of many half angles at once libm's, bit by bit?

use core::f64::consts::PI;

use foldpath_core::closure::half_angles;
use foldpath_core::{HalfAngle, Scalar};
use rand_core::Rng;
use rand_pcg::Pcg64;

/// Largest argument that has a sine and a cosine in `f32`, radians.
const LARGEST_SINE: f32 = 12_866.0;

/// Returns the largest error of sine and cosine over `angles`.
fn error(angles: impl Iterator<Item = f32>) -> f64 {
    let of = |angle: f32| {
        let (sine, cosine) = Scalar::sin_cos(angle);
        let (exact_sine, exact_cosine) = libm::sincos(angle.into());
        let errors = [
            f64::from(sine) - exact_sine,
            f64::from(cosine) - exact_cosine,
        ];
        assert!(errors.iter().all(|error| error.is_finite()), "{angle}");
        errors[0].abs().max(errors[1].abs())
    };
    angles.map(of).fold(0.0, f64::max)
}

#[test]
fn half_angles_are_within_the_stated_error() {
    // Every 512th number from 0 to the first above a quarter turn, and its opposite.
    let last = core::f32::consts::FRAC_PI_2.to_bits() + 512;
    let all = || (0..=last).step_by(512).map(f32::from_bits);
    let found = error(all().chain(all().map(|angle| -angle)));
    assert!((3e-8..8e-8).contains(&found), "{found:e}");
}

#[test]
fn a_million_angles_are_within_the_stated_error() {
    let mut rng = Pcg64::new(61, 0);
    for most in [1e-3, 3.2, 100.0, LARGEST_SINE] {
        let mut draw = || (rng.next_u32() as f32 / u32::MAX as f32 * 2.0 - 1.0) * most;
        let found = error((0..250_000).map(|_| draw()));
        assert!(found < 8e-8, "{found:e} up to {most}");
    }
}

#[test]
fn small_angles_keep_their_relative_precision_and_their_sign() {
    for exponent in 0..40 {
        let angle = -1e-3_f32 * 0.5_f32.powi(exponent);
        let (sine, _) = Scalar::sin_cos(angle);
        let exact = libm::sin(angle.into());
        assert!(
            (f64::from(sine) - exact).abs() <= 6e-8 * exact.abs(),
            "{angle:e}"
        );
    }
    assert_eq!(Scalar::sin_cos(0.0_f32).0.to_bits(), 0.0_f32.to_bits());
}

#[test]
fn what_is_too_large_or_no_number_has_neither() {
    for angle in [
        f32::NAN,
        f32::INFINITY,
        -f32::INFINITY,
        LARGEST_SINE.next_up(),
        -3e38,
    ] {
        let (sine, cosine) = Scalar::sin_cos(angle);
        assert!(sine.is_nan() && cosine.is_nan(), "{angle}");
    }
}

fn same_bits(angles: &[f64]) {
    let mut halves = [HalfAngle::default(); 100];
    assert!(angles.len() <= halves.len());
    half_angles(angles, &mut halves);
    for (rho, half) in angles.iter().zip(halves) {
        let HalfAngle { cos, sin } = HalfAngle::of(*rho);
        assert_eq!(half.sin.to_bits(), sin.to_bits(), "sine of half {rho:e}");
        assert_eq!(half.cos.to_bits(), cos.to_bits(), "cosine of half {rho:e}");
    }
}

#[test]
fn a_million_angles_have_the_bits_of_libm() {
    let mut rng = Pcg64::new(83, 0);
    let mut draw = |most: f64| (f64::from(rng.next_u32()) / f64::from(u32::MAX) * 2.0 - 1.0) * most;
    // Also beyond half a turn, where libm computes.
    for most in [1e-300, 1e-9, 1e-3, 1.0, PI, 3.3, 100.0] {
        for _ in 0..2_000 {
            same_bits(&core::array::from_fn::<f64, 77, _>(|_| draw(most)));
        }
    }
}

#[test]
fn where_the_way_changes_the_bits_are_those_of_libm() {
    // Twice the half angles from which on the argument is reduced, and left to libm.
    for edge in [
        0.0,
        2.0 * f64::from_bits(0x3fe9_21fc_0000_0000),
        2.0 * f64::from_bits(0x3ff9_21fb_0000_0000),
        PI / 2.0,
        PI,
        f64::MIN_POSITIVE,
    ] {
        let (mut below, mut above) = (edge, edge);
        for _ in 0..1_000 {
            same_bits(&[below, -below]);
            same_bits(&[above, -above, below]);
            (below, above) = (below.next_down(), above.next_up());
        }
    }
    same_bits(&[-0.0, 0.0, 5e-324]);
}

#[test]
fn what_is_no_number_has_none_and_spoils_no_other() {
    let mut halves = [HalfAngle::default(); 3];
    half_angles(&[1.0, f64::NAN, f64::INFINITY], &mut halves);
    let [good, bad, infinite] = halves;
    assert_eq!(good, HalfAngle::of(1.0));
    assert!(bad.sin.is_nan() && infinite.cos.is_nan());
}
