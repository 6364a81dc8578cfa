//! Does every public function refuse or handle infinities, NaN and numbers too large or too small to mean anything, and
//! never return one as an answer? See also `an_undefined_star_does_not_hide_behind_the_others`,
//! `a_start_that_is_no_number_is_an_outcome`, and the refusals of trajectories, setpoints and files in their own
//! modules.

use foldpath_core::least_squares::{ClosureProblem, Limits, Options, Outcome};
use foldpath_core::{
    Curve, DenseNormalEquations, GroupId, GroupLimits, HalfAngle, Interpolation, LoopsView,
    Membership, Node, Objective, Rotation, Scalar, closure, expand, gradient, hole,
    levenberg_marquardt, project, sampling,
};
use foldpath_test_support::stars::{Stars, miura, miura_angles};
use foldpath_test_support::{Random, cast};
use nalgebra::Vector3;

/// Returns the values that are not finite.
fn none<T: Scalar>() -> [T; 3] {
    cast([f64::NAN, f64::INFINITY, f64::NEG_INFINITY])
}

/// Returns finite numbers that no fold angle has. The sine of core works in `f32` for arguments up to 12,866.
fn odd<T: Scalar>() -> Vec<T> {
    let smallest = T::EPSILON * T::lit(1e-30);
    let odd = [0.0, -0.0, 1e-30, -7.0, 1e3, -12_000.0];
    let odd = odd.map(T::lit).into_iter();
    odd.chain([smallest, -smallest]).collect()
}

fn halves<T: Scalar>(angles: &[T]) -> Vec<HalfAngle<T>> {
    let mut halves = vec![HalfAngle::default(); angles.len()];
    closure::half_angles(angles, &mut halves);
    halves
}

fn is_finite<T: Scalar>(vector: &Vector3<T>) -> bool {
    vector.iter().all(|c| c.is_finite())
}

fn closure_of_no_numbers_is_none_and_never_within_a_bound<T: Scalar>() {
    let stars = miura::<T>(60.0, false, false);
    let star = stars.view().iter().next().unwrap();
    let places = [[T::zero(); 2]; 4];
    let loops = LoopsView::new(&stars.spokes, &places, &stars.ends, 2).unwrap();
    let mut columns = [Vector3::from([T::zero(); 3]); 4];
    for bad in none::<T>() {
        for angles in [[bad, T::one()], [T::one(), bad]] {
            let halves = halves(&angles);
            assert!(!is_finite(&closure::residual(star, &halves)));
            for bound in [T::one(), T::MAX, none::<T>()[1]] {
                assert!(!closure::closes(star, &halves, bound));
            }
            let residual = closure::residual_and_jacobian(star, &halves, &mut columns);
            assert!(!is_finite(&residual.unwrap()));
            let turned = hole::residuals(loops.iter().next().unwrap(), &halves)[0];
            assert!(!is_finite(&turned));
            for objective in [Objective::Max, Objective::Sum] {
                let mut scratch = [HalfAngle::default(); 2];
                let value = objective.value(stars.view(), &angles, &mut scratch);
                assert!(!value.unwrap().is_finite());
            }
        }
        let turned = Rotation::about_crease(HalfAngle::of(bad), [T::one(), T::zero()]);
        assert!(!is_finite(&turned.rotate(&Vector3::from([T::one(); 3]))));
    }
    for value in odd::<T>() {
        let residual = closure::residual(star, &halves(&[value, T::one()]));
        assert!(is_finite(&residual) && residual.dot(&residual) <= T::lit(4.01));
    }
}

/// Both solvers, started where no sheet can be, return an outcome and angles within the limits.
fn solvers_end_within_the_limits<T: Scalar>() {
    let stars = miura::<T>(60.0, false, false);
    let infinite = none::<T>()[1];
    let huge = [T::MAX, -T::MAX, infinite, -infinite].into_iter();
    let tolerances = [
        Options::default().tolerance,
        T::lit(f64::NAN),
        T::zero(),
        -T::one(),
    ];
    for value in odd::<T>().into_iter().chain(huge) {
        for other in [T::one(), value] {
            for tolerance in tolerances {
                let options = Options {
                    tolerance,
                    max_iterations: 30,
                    ..Options::default()
                };
                for gradients in [false, true] {
                    let mut x = [value, other];
                    let outcome = solve(&stars, gradients, Limits::HalfTurn, &options, &mut x);
                    assert!(x.iter().all(|x| x.abs() <= T::PI), "{x:?}");
                    assert!(!matches!(outcome, Outcome::NotFinite | Outcome::Capacity));
                    let residual =
                        closure::residual(stars.view().iter().next().unwrap(), &halves(&x));
                    let closed = residual.dot(&residual).sqrt() <= options.tolerance;
                    assert_eq!(outcome == Outcome::Converged, closed, "{x:?} {tolerance}");
                }
            }
        }
    }
}

/// Limits that are not numbers lead to no angle that is not finite.
fn limits_that_are_no_numbers_spoil_no_angle<T: Scalar>() {
    let stars = miura::<T>(60.0, false, false);
    let nan = none::<T>()[0];
    for limits in [[(nan, nan); 2], [(nan, T::PI); 2], [(-T::PI, nan); 2]] {
        for gradients in [false, true] {
            let mut x: [T; 2] = cast([1.0, 0.8]);
            let limits = Limits::Each(&limits);
            let outcome = solve(&stars, gradients, limits, &Options::default(), &mut x);
            assert!(x.iter().all(|x| x.is_finite()), "{outcome:?} {x:?}");
        }
    }
}

fn solve<T: Scalar>(
    stars: &Stars<T>,
    gradients: bool,
    limits: Limits<'_, T>,
    options: &Options<T>,
    x: &mut [T],
) -> Outcome {
    let (mut halves, mut columns) = (
        [HalfAngle::default(); 2],
        [Vector3::from([T::zero(); 3]); 4],
    );
    let mut problem = ClosureProblem::new(stars.view(), &mut halves, &mut columns).unwrap();
    let mut workspace = [T::zero(); 8];
    let report = if gradients {
        gradient::solve(&mut problem, limits, options, x, &mut workspace)
    } else {
        let mut memory = vec![T::zero(); DenseNormalEquations::<T>::memory(2)];
        let mut equations = DenseNormalEquations::new(2, &mut memory).unwrap();
        levenberg_marquardt::solve(
            &mut problem,
            &mut equations,
            limits,
            options,
            x,
            &mut workspace,
        )
    };
    report.outcome
}

/// A direction that is not finite is reported as no motion.
fn motions_of_no_numbers_are_none<T: Scalar>() {
    let stars = miura::<T>(60.0, false, false);
    let (mut halves, mut columns) = (
        [HalfAngle::default(); 2],
        [Vector3::from([T::zero(); 3]); 4],
    );
    let mut problem = ClosureProblem::new(stars.view(), &mut halves, &mut columns).unwrap();
    let mut memory = vec![T::zero(); DenseNormalEquations::<T>::memory(2)];
    let mut equations = DenseNormalEquations::new(2, &mut memory).unwrap();
    let closed: [T; 2] = cast(miura_angles(60.0, 1.0));
    problem.linearise(&closed, &mut equations).unwrap();
    for bad in none::<T>() {
        let mut direction = [bad, T::one()];
        assert!(!levenberg_marquardt::project_on_motions(
            &mut equations,
            &mut direction
        ));
        problem.linearise(&[bad, T::one()], &mut equations).unwrap();
        assert!(!levenberg_marquardt::project_on_motions(
            &mut equations,
            &mut [T::one(); 2]
        ));
        problem.linearise(&closed, &mut equations).unwrap();
    }
}

/// A measured angle that is not finite leaves its group, and only its group, without an angle. The spread of the hinges
/// about their means is then not finite either.
fn means_of_no_numbers_are_none<T: Scalar>() {
    let member = |group| Membership {
        group: GroupId(group),
        negative: false,
    };
    for bad in none::<T>() {
        let hinges = [
            (member(0), T::one()),
            (member(1), bad),
            (member(1), T::one()),
        ];
        let (mut angles, mut counts) = ([T::zero(); 2], [T::zero(); 2]);
        let spread = project::means(hinges.into_iter(), &mut angles, &mut counts).unwrap();
        assert!(angles[0].is_finite() && !angles[1].is_finite());
        assert!(!spread.is_finite(), "{spread}");
    }
}

fn curves_samples_and_groups_say_what_is_none<T: Scalar>() {
    let good = Node {
        angle: T::one(),
        rate: T::one(),
        weight: [T::one(), T::zero()],
    };
    let kinds = [
        Interpolation::Linear,
        Interpolation::Hermite,
        Interpolation::HalfAngle,
        Interpolation::Homogeneous,
    ];
    for bad in none::<T>() {
        for kind in kinds {
            let node = Node { angle: bad, ..good };
            let curve = Curve::between(kind, T::one(), good, node);
            assert!(!curve.angle(T::HALF).is_finite(), "{kind:?} {bad}");
        }
        let limits = |lower, upper, speed| GroupLimits {
            lower,
            upper,
            speed,
            acceleration: T::one(),
        };
        assert!(!limits(bad, T::one(), T::one()).are_sound());
        assert!(!limits(-T::one(), bad, T::one()).are_sound());
        assert!(!limits(-T::one(), T::one(), T::one()).allow(bad));
        let member = Membership {
            group: GroupId(0),
            negative: true,
        };
        let mut creases = [T::zero()];
        assert!(expand(&[member], &[bad], &mut creases));
        assert!(!creases[0].is_finite());
    }
    let nan = none::<T>()[0];
    let mut out = [T::zero(); 2];
    sampling::random_near(
        &mut Random::new(1),
        &[nan, T::one()],
        T::one(),
        Limits::HalfTurn,
        &mut out,
    );
    assert!(!out[0].is_finite() && out[1].abs() <= T::TWO);
}

/// Instantiates the checks for both precisions.
macro_rules! suite {
    ($($check:ident)*) => {
        mod f32 { $(#[test] fn $check() { super::$check::<f32>(); })* }
        mod f64 { $(#[test] fn $check() { super::$check::<f64>(); })* }
    };
}

suite! {
    closure_of_no_numbers_is_none_and_never_within_a_bound
    solvers_end_within_the_limits
    limits_that_are_no_numbers_spoil_no_angle
    motions_of_no_numbers_are_none
    means_of_no_numbers_are_none
    curves_samples_and_groups_say_what_is_none
}
