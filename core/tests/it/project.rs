//! Does `project` bring measured configurations back to closed ones? Compares with curves in closed form.

use foldpath_core::least_squares::{ClosureProblem, Limits, Outcome};
use foldpath_core::project::{Projection, means, project};
use foldpath_core::{DenseNormalEquations, GroupId, Membership, Scalar};
use foldpath_test_support::stars::{Stars, miura, miura_angles, waterbomb, waterbomb_angles};
use foldpath_test_support::{Random, cast};

/// Projects a measured configuration on the closed configurations of these stars.
fn closed<T: Scalar, const N: usize>(
    stars: &Stars<T>,
    measured: [T; N],
) -> ([T; N], Projection<T>) {
    let (mut half_angles, mut columns) = ([Default::default(); N], [Default::default(); 8]);
    let problem = ClosureProblem::new(stars.view(), &mut half_angles, &mut columns);
    let mut memory = vec![T::zero(); DenseNormalEquations::<T>::memory(N)];
    let equations = DenseNormalEquations::new(N, &mut memory);
    let mut workspace = vec![T::zero(); 3 * N];
    let mut x = measured;
    let projection = project(
        &mut problem.unwrap(),
        &mut equations.unwrap(),
        Limits::HalfTurn,
        T::CLOSURE_TOLERANCE,
        &mut x,
        &mut workspace,
    );
    (x, projection)
}

fn distance(a: &[f64], b: &[f64]) -> f64 {
    let square = a.iter().zip(b).map(|(a, b)| (a - b).powi(2)).sum::<f64>();
    square.sqrt()
}

/// Returns the least distance from `point` to a curve, by bisection around the nearest of 1001 points.
fn nearest<const N: usize>(point: [f64; N], curve: impl Fn(f64) -> [f64; N], top: f64) -> f64 {
    let at = |t: f64| distance(&point, &curve(t));
    let places = (0..=1000).map(|k| top * f64::from(k) / 1000.0);
    let mut best = places.min_by(|a, b| at(*a).total_cmp(&at(*b))).unwrap();
    let mut step = top / 1000.0;
    while step > 1e-16 {
        let beside = [best - step, best + step].map(|t| t.clamp(0.0, top));
        match beside.into_iter().find(|&t| at(t) < at(best)) {
            Some(t) => best = t,
            None => step /= 2.0,
        }
    }
    at(best)
}

/// Adds noise to a known configuration and projects. The result closes and lies on the curve. Its distance to the
/// measured configuration exceeds that of the nearest point by no more than the second order of the noise.
fn comes_back<T: Scalar, const N: usize>(
    stars: &Stars<T>,
    curve: impl Fn(f64) -> [f64; N],
    [low, top]: [f64; 2],
) {
    let mut rng = Random::new(95);
    for _ in 0..300 {
        let exact = curve(rng.uniform(low, top));
        let noise = 0.02;
        let measured: [f64; N] = exact.map(|angle| angle + rng.uniform(-noise, noise));
        let (found, projection) = closed(stars, cast::<T, N>(measured));
        assert_eq!(projection.report.outcome, Outcome::Converged, "{exact:?}");
        assert!(projection.report.iterations <= 5, "{projection:?}");
        let found = found.map(Scalar::to_f64);
        let on_curve = nearest(found, &curve, top + 0.1);
        assert!(
            on_curve < 100.0 * T::CLOSURE_TOLERANCE.to_f64(),
            "{on_curve:e} {found:?}"
        );
        let least = nearest(measured, &curve, top + 0.1);
        let way = distance(&found, &measured);
        assert!(way < least + 3.0 * noise * noise, "{way} {least}");
        let moved = found.iter().zip(&measured).map(|(a, b)| (a - b).abs());
        let moved = moved.fold(0.0, f64::max);
        assert!((projection.moved.to_f64() - moved).abs() < 4.0 * T::EPSILON.to_f64() * 4.0);
    }
}

#[test]
fn a_measured_miura_comes_back() {
    let curve = |major| miura_angles(60.0, major);
    comes_back(&miura::<f64>(60.0, false, false), curve, [0.5, 2.6]);
    comes_back(&miura::<f32>(60.0, false, false), curve, [0.5, 2.6]);
}

#[test]
fn a_measured_waterbomb_comes_back() {
    comes_back(&waterbomb::<f64>(), waterbomb_angles, [0.3, 0.9]);
    comes_back(&waterbomb::<f32>(), waterbomb_angles, [0.3, 0.9]);
}

#[test]
fn work_is_bounded_and_what_is_no_number_is_said() {
    let stars = miura::<f32>(60.0, false, false);
    let (_, projection) = closed(&stars, [f32::NAN, 0.5]);
    assert_eq!(projection.report.outcome, Outcome::NotFinite);
    for degrees in 0..180_u8 {
        let (_, projection) = closed(&stars, [3.0, -f32::from(degrees).to_radians()]);
        assert!(projection.report.iterations <= 12);
    }
    let (mut x, mut half, mut columns) =
        ([0.1; 2], [Default::default(); 2], [Default::default(); 4]);
    let mut problem = ClosureProblem::new(stars.view(), &mut half, &mut columns).unwrap();
    let mut memory = [0.0; DenseNormalEquations::<f32>::memory(2)];
    let mut equations = DenseNormalEquations::new(2, &mut memory).unwrap();
    for room in 0..6 {
        let workspace = &mut [0.0; 6][..room];
        let limits = Limits::HalfTurn;
        let projection = project(
            &mut problem,
            &mut equations,
            limits,
            1e-6,
            &mut x,
            workspace,
        );
        assert_eq!(projection.report.outcome, Outcome::Capacity);
    }
}

#[test]
fn hinges_are_averaged_by_group_and_sign() {
    let member = |group, negative| Membership {
        group: GroupId(group),
        negative,
    };
    let hinges = [
        (member(0, false), 1.0),
        (member(1, true), -0.5),
        (member(0, true), -1.2),
        (member(1, false), 0.7),
        (member(0, false), 1.1),
    ];
    let (mut angles, mut counts) = ([9.0; 2], [9.0; 2]);
    let spread = means(hinges.into_iter(), &mut angles, &mut counts).unwrap();
    assert!((angles[0] - 1.1_f64).abs() < 1e-15 && (angles[1] - 0.6).abs() < 1e-15);
    assert!((spread - 0.1).abs() < 1e-15);
    assert_eq!(
        means(hinges.into_iter(), &mut [0.0; 1], &mut [0.0; 1]),
        None
    );
    assert_eq!(
        means(hinges.into_iter(), &mut [0.0; 3], &mut [0.0; 3]),
        None
    );
    assert_eq!(
        means(hinges.into_iter(), &mut [0.0; 2], &mut [0.0; 3]),
        None
    );
    let broken =
        hinges.map(|(member, angle)| (member, if angle > 1.05 { f64::NAN } else { angle }));
    means(broken.into_iter(), &mut angles, &mut counts);
    assert!(angles[0].is_nan() && !angles[1].is_nan());
}
