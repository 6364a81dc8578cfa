//! Does the closure residual equal the product of the report's folding matrices? Does its Jacobian equal central
//! differences? Does it vanish on foldings that are known in closed form?

use core::f64::consts::PI;
use foldpath_core::closure::{closes, half_angles, misclosure, residual, residual_and_jacobian};
use foldpath_core::{HalfAngle, Scalar, StarView, local_foldability_matrix, norm};
use foldpath_test_support::stars::{
    Stars, foldability_error, miura, miura_angles, waterbomb, waterbomb_angles,
};
use foldpath_test_support::{Random, cast};
use nalgebra::{Vector3, Vector4};

/// Calls `check` with 600 random stars of degree 1 to 12 and random fold angles, radians.
fn for_random_stars<T: Scalar>(seed: u64, mut check: impl FnMut(StarView<'_, T>, &[T])) {
    let mut rng = Random::new(seed);
    for degree in (1..=12).cycle().take(600) {
        let unknowns = 1 + rng.below(degree);
        let stars = Stars::random(&mut rng, unknowns, &[degree]);
        let angles = rng.angles(unknowns);
        check(stars.view().iter().next().unwrap(), &angles);
    }
}

fn half<T: Scalar>(unknowns: &[T]) -> Vec<HalfAngle<T>> {
    let mut half = vec![HalfAngle::default(); unknowns.len()];
    half_angles(unknowns, &mut half);
    half
}

/// Bound on the rounding error of a product over the star, whose factors have entries of about 1.
fn rounding<T: Scalar>(star: StarView<'_, T>) -> f64 {
    8.0 * star.spokes.len() as f64 * T::EPSILON.to_f64()
}

fn quaternions_equal_folding_matrices<T: Scalar>() {
    for_random_stars::<T>(1, |star, angles| {
        let expected = misclosure(star, &half(angles)).matrix();
        for witness in [[T::zero(); 2], cast([3.0, -2.0])] {
            let matrix = local_foldability_matrix(star, witness, angles);
            for (i, j) in (0..3).flat_map(|i| (0..3).map(move |j| (i, j))) {
                let difference = (matrix[(i, j)] - expected[(i, j)]).abs().to_f64();
                assert!(difference <= rounding(star), "{star:?} {angles:?}");
            }
            // The vertex is a fixed point of the matrix. Its distance from the origin, about 4, scales the rounding
            // error.
            let vertex = Vector4::new(witness[0], witness[1], T::zero(), T::one());
            let moved = matrix * vertex - vertex;
            assert!(
                moved
                    .iter()
                    .all(|d| d.abs().to_f64() <= 4.0 * rounding(star))
            );
        }
    });
}

#[test]
fn quaternion_form_equals_the_folding_matrices() {
    quaternions_equal_folding_matrices::<f32>();
    quaternions_equal_folding_matrices::<f64>();
}

fn residual_is_the_frobenius_norm<T: Scalar>() {
    for_random_stars::<T>(2, |star, angles| {
        let residual = norm(&residual(star, &half(angles))).to_f64() * 2_f64.sqrt();
        let difference = (residual - foldability_error(star, angles)).abs();
        assert!(difference <= rounding(star), "{difference:e} {star:?}");
    });
}

#[test]
fn residual_times_root_two_is_the_frobenius_norm_of_l_minus_identity() {
    residual_is_the_frobenius_norm::<f32>();
    residual_is_the_frobenius_norm::<f64>();
}

#[test]
fn residual_of_a_half_turn_is_two() {
    let stars = Stars::<f64>::new(1, &[&[(30.0, 0, false)]]);
    for rho in [PI, -PI] {
        let residual = residual(stars.view().iter().next().unwrap(), &half(&[rho]));
        assert!((norm(&residual) - 2.0).abs() <= 2.0 * f64::EPSILON);
    }
}

#[test]
fn a_star_closes_within_its_residual_and_within_no_bound_below_zero() {
    for_random_stars::<f64>(73, |star, angles| {
        let half = half(angles);
        let residual = norm(&residual(star, &half));
        assert!(closes(star, &half, residual * (1.0 + 1e-12)));
        for bound in [residual * (1.0 - 1e-12), -residual, -3.0, f64::NAN] {
            assert!(!closes(star, &half, bound), "{bound}");
        }
    });
}

#[test]
fn residual_turns_the_short_way() {
    // Two creases of equal direction turn the sheet by the sum of their angles. Past half a turn the residual is that
    // of the shorter rotation, which goes the other way.
    let stars = Stars::<f64>::new(1, &[&[(0.0, 0, false), (0.0, 0, false)]]);
    for (rho, turned) in [
        (1.0, 2.0),
        (-1.0, -2.0),
        (3.0, 6.0 - 2.0 * PI),
        (-2.0, 2.0 * PI - 4.0),
    ] {
        let residual = residual(stars.view().iter().next().unwrap(), &half(&[rho]));
        let expected = Vector3::new(2.0 * (turned / 2.0_f64).sin(), 0.0, 0.0);
        assert!(
            (residual - expected).norm() <= 8.0 * f64::EPSILON,
            "{rho}: {residual}"
        );
    }
}

#[test]
fn jacobian_matches_central_differences() {
    // This step makes the truncation error h² and the rounding error ε/h equally small.
    let h = f64::EPSILON.cbrt();
    for_random_stars::<f64>(3, |star, angles| {
        let degree = star.spokes.len();
        let mut columns = vec![Vector3::zeros(); degree];
        let at = residual_and_jacobian(star, &half(angles), &mut columns).unwrap();
        assert_eq!(at, residual(star, &half(angles)));
        for group in 0..angles.len() {
            let shifted = |h: f64| {
                let mut angles = angles.to_vec();
                angles[group] += h;
                residual(star, &half(&angles))
            };
            let difference = (shifted(h) - shifted(-h)) / (2.0 * h);
            let spokes = star.spokes.iter().zip(&columns);
            let derivative: Vector3<f64> = spokes
                .filter(|(spoke, _)| spoke.group.index() == group)
                .map(|(_, column)| column)
                .sum();
            // The third derivative of a product in which one angle occurs in k factors is below k³.
            let repeated = star.spokes.iter().filter(|s| s.group.index() == group);
            let scale = (repeated.count().max(1) as f64).powi(3);
            let error = (difference - derivative).norm();
            assert!(
                error <= scale * h * h + rounding(star) / h,
                "{error:e} {star:?} {angles:?}"
            );
        }
    });
}

#[test]
fn jacobian_refuses_wrong_lengths() {
    let stars = miura::<f64>(60.0, false, false);
    let star = stars.view().iter().next().unwrap();
    let enough = half(&[1.0, 0.5]);
    for length in [0, 3, 5] {
        let mut columns = vec![Vector3::zeros(); length];
        assert!(residual_and_jacobian(star, &enough, &mut columns).is_none());
    }
    let mut columns = [Vector3::zeros(); 4];
    assert!(residual_and_jacobian(star, &enough[..1], &mut columns).is_none());
}

fn miura_closes<T: Scalar>() {
    for sector in (10..=80).step_by(5).map(f64::from) {
        for major in (-1799..=1799)
            .step_by(7)
            .map(|tenth| f64::from(tenth) / 10.0)
        {
            let angles: [T; 2] = cast(miura_angles(sector, major.to_radians()));
            for (mirrored, negated) in [(false, false), (false, true), (true, false), (true, true)]
            {
                let stars = miura(sector, mirrored, negated);
                let residual = residual(stars.view().iter().next().unwrap(), &half(&angles));
                let error = norm(&residual) / T::EPSILON;
                assert!(
                    error <= T::lit(8.0),
                    "{error} roundings at {sector} {major} degrees"
                );
            }
        }
    }
}

#[test]
fn miura_closed_form_closes() {
    miura_closes::<f32>();
    miura_closes::<f64>();
}

fn waterbomb_closes<T: Scalar>() {
    let stars = waterbomb();
    for t in (0..=200).map(|t| f64::from(t) / 200.0) {
        let angles: [T; 4] = cast(waterbomb_angles(t));
        for star in stars.view().iter() {
            let error = norm(&residual(star, &half(&angles))) / T::EPSILON;
            assert!(error <= T::lit(12.0), "{error} roundings at t = {t}");
        }
    }
}

#[test]
fn waterbomb_closed_form_closes() {
    waterbomb_closes::<f32>();
    waterbomb_closes::<f64>();
}
