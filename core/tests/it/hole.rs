//! Do the residuals of loops round holes equal the product of the report's folding matrices, and their Jacobian central
//! differences?

use foldpath_core::closure::{half_angles, residual};
use foldpath_core::hole::{residuals, residuals_and_jacobian};
use foldpath_core::least_squares::{ClosureProblem, Gradient};
use foldpath_core::{HalfAngle, LoopView, LoopsView, Scalar, folding_matrix, norm};
use foldpath_test_support::stars::{Stars, foldability_error};
use foldpath_test_support::{Random, cast};
use nalgebra::{Matrix4, Vector3};

/// A loop that owns its memory: the spokes of a random star, each at a point of its own.
struct Loop<T> {
    star: Stars<T>,
    places: Vec<[T; 2]>,
}

impl<T: Scalar> Loop<T> {
    fn random(rng: &mut Random, unknowns: usize, degree: usize) -> Self {
        let star = Stars::random(rng, unknowns, &[degree]);
        let mut place = || cast([rng.uniform(-1.0, 1.0), rng.uniform(-1.0, 1.0)]);
        let places = (0..degree).map(|_| place()).collect();
        Self { star, places }
    }

    fn view(&self) -> LoopsView<'_, T> {
        let Stars {
            spokes,
            ends,
            unknowns,
        } = &self.star;
        LoopsView::new(spokes, &self.places, ends, *unknowns).unwrap()
    }

    fn only(&self) -> LoopView<'_, T> {
        self.view().iter().next().unwrap()
    }
}

/// Calls `check` with 480 random loops of 1 to 16 creases and random fold angles, radians.
fn for_random_loops<T: Scalar>(seed: u64, mut check: impl FnMut(&Loop<T>, &[T])) {
    let mut rng = Random::new(seed);
    for degree in (1..=16).cycle().take(480) {
        let unknowns = 1 + rng.below(degree);
        let cycle = Loop::random(&mut rng, unknowns, degree);
        check(&cycle, &rng.angles(unknowns));
    }
}

fn half<T: Scalar>(unknowns: &[T]) -> Vec<HalfAngle<T>> {
    let mut half = vec![HalfAngle::default(); unknowns.len()];
    half_angles(unknowns, &mut half);
    half
}

/// Bound on the rounding error of a product over the loop, for points at distances of about 1.
fn rounding<T: Scalar>(degree: usize) -> f64 {
    16.0 * degree as f64 * T::EPSILON.to_f64()
}

fn is_the_product_of_folding_matrices<T: Scalar>() {
    for_random_loops::<T>(41, |cycle, angles| {
        let spokes = cycle.star.spokes.iter().zip(&cycle.places);
        let l = spokes.fold(Matrix4::<T>::identity(), |l, (spoke, &place)| {
            let [cos, sin] = spoke.direction;
            l * folding_matrix(place, sin.atan2(cos), spoke.fold_angle(angles))
        });
        let [turn, shift] = residuals(cycle.only(), &half(angles));
        let rounding = rounding::<T>(cycle.places.len());
        let star = cycle.star.view().iter().next().unwrap();
        let error = foldability_error(star, angles) / 2_f64.sqrt();
        assert!((norm(&turn).to_f64() - error).abs() <= rounding);
        for k in 0..3 {
            let difference = (l[(k, 3)] - shift[k]).abs().to_f64();
            assert!(difference <= rounding, "{difference:e} {angles:?}");
        }
    });
}

#[test]
fn a_loop_is_the_product_of_the_folding_matrices() {
    is_the_product_of_folding_matrices::<f32>();
    is_the_product_of_folding_matrices::<f64>();
}

#[test]
fn a_loop_through_one_point_is_a_star_there() {
    for_random_loops::<f64>(42, |cycle, angles| {
        let star = cycle.star.view().iter().next().unwrap();
        let place = cycle.places[0];
        let places = vec![place; cycle.places.len()];
        let view = LoopView {
            spokes: star.spokes,
            places: &places,
        };
        let [turn, shift] = residuals(view, &half(angles));
        assert_eq!(turn, residual(star, &half(angles)));
        let misclosure = foldpath_core::closure::misclosure(star, &half(angles));
        let point = Vector3::new(place[0], place[1], 0.0);
        let expected = point - misclosure.rotate(&point);
        assert!((shift - expected).norm() <= rounding::<f64>(places.len()));
    });
}

#[test]
fn jacobian_matches_central_differences() {
    // This step makes the truncation error h² and the rounding error ε/h equally small.
    let h = f64::EPSILON.cbrt();
    for_random_loops::<f64>(43, |cycle, angles| {
        let spokes = &cycle.star.spokes;
        let mut columns = vec![Vector3::zeros(); 2 * spokes.len()];
        let at = residuals_and_jacobian(cycle.only(), &half(angles), &mut columns).unwrap();
        assert_eq!(at, residuals(cycle.only(), &half(angles)));
        for group in 0..angles.len() {
            let shifted = |h: f64| {
                let mut angles = angles.to_vec();
                angles[group] += h;
                residuals(cycle.only(), &half(&angles))
            };
            let (above, below) = (shifted(h), shifted(-h));
            let repeated = spokes.iter().filter(|s| s.group.index() == group).count();
            // The third derivative of a product in which one angle occurs in k factors is below k³. A point is at most
            // √2 from the middle, and every factor moves it by at most about that distance.
            let reach = 4.0 * spokes.len() as f64;
            let scale = (repeated.max(1) as f64).powi(3) * reach;
            for block in 0..2 {
                let difference = (above[block] - below[block]) / (2.0 * h);
                let columns = &columns[block * spokes.len()..][..spokes.len()];
                let own = spokes.iter().zip(columns);
                let own = own.filter(|(spoke, _)| spoke.group.index() == group);
                let derivative: Vector3<f64> = own.map(|(_, column)| column).sum();
                let error = (difference - derivative).norm();
                let rounding = rounding::<f64>(spokes.len());
                assert!(
                    error <= scale * h * h + rounding / h,
                    "{error:e} in {block}"
                );
            }
        }
    });
}

/// With stars and loops together, the gradient of ½‖r‖² from the rows equals central differences of the cost.
#[test]
fn a_problem_with_loops_has_the_gradient_of_its_cost() {
    let h = f64::EPSILON.cbrt();
    let mut rng = Random::new(44);
    for _ in 0..50 {
        let unknowns = 6;
        let stars = Stars::<f64>::random(&mut rng, unknowns, &[4, 5]);
        let cycle = Loop::random(&mut rng, unknowns, 7);
        let mut x: Vec<f64> = rng.angles(unknowns);
        let mut half = vec![HalfAngle::default(); unknowns];
        let mut columns =
            vec![Vector3::zeros(); ClosureProblem::columns(stars.view(), cycle.view())];
        assert_eq!(columns.len(), 14);
        let mut problem =
            ClosureProblem::with_loops(stars.view(), cycle.view(), &mut half, &mut columns)
                .unwrap();
        let mut gradient = vec![0.0; unknowns];
        let cost = problem.linearise(&x, &mut Gradient(&mut gradient)).unwrap();
        assert_eq!(problem.cost(&x), Some(cost));
        let largest = residuals(cycle.only(), &self::half(&x)).map(|r| norm(&r));
        assert!(cost.max() >= largest[0].max(largest[1]));
        for k in 0..unknowns {
            let at = x[k];
            let mut cost_at = |value: f64| {
                x[k] = value;
                problem.cost(&x).unwrap().half_square
            };
            let difference = (cost_at(at + h) - cost_at(at - h)) / (2.0 * h);
            x[k] = at;
            // Bounds the third derivatives of 16 rows, which are products of up to 7 factors of size up to 7.
            let error = (difference - gradient[k]).abs();
            assert!(error <= 1e5 * h * h, "{error:e}");
        }
    }
}

#[test]
fn wrong_lengths_are_refused() {
    let cycle = Loop::<f64>::random(&mut Random::new(45), 2, 5);
    let Stars { spokes, ends, .. } = &cycle.star;
    assert!(LoopsView::new(spokes, &cycle.places[1..], ends, 2).is_none());
    assert!(LoopsView::new(spokes, &cycle.places, &[4], 2).is_none());
    assert!(LoopsView::new(spokes, &cycle.places, ends, 0).is_none());
    let enough = half(&[1.0, 0.5]);
    for length in [0, 5, 9, 11] {
        let mut columns = vec![Vector3::zeros(); length];
        assert!(residuals_and_jacobian(cycle.only(), &enough, &mut columns).is_none());
    }
    let mut columns = [Vector3::zeros(); 10];
    assert!(residuals_and_jacobian(cycle.only(), &[], &mut columns).is_none());
    let stars = Stars::<f64>::new(2, &[]);
    let problem = |half: &mut [_], columns: &mut [_]| {
        ClosureProblem::with_loops(stars.view(), cycle.view(), half, columns).is_some()
    };
    let mut half = enough;
    assert!(problem(&mut half, &mut columns));
    assert!(!problem(&mut half[1..], &mut columns));
    assert!(!problem(&mut half, &mut columns[1..]));
}
