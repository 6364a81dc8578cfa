//! Do the report's objectives equal their values by the 4x4 matrices?

use foldpath_core::{HalfAngle, Objective, Scalar, StarsView};
use foldpath_test_support::Random;
use foldpath_test_support::stars::{Stars, foldability_error};

fn values_of_the_matrices<T: Scalar>() {
    let mut rng = Random::new(21);
    for _ in 0..200 {
        let degrees: Vec<usize> = (0..6).map(|_| 1 + rng.below(12)).collect();
        let stars = Stars::random(&mut rng, 5, &degrees);
        let angles = rng.angles::<T>(5);
        let errors = stars
            .view()
            .iter()
            .map(|star| foldability_error(star, &angles));
        let (max, sum) = errors.fold((0.0_f64, 0.0), |(max, sum), e| (max.max(e), sum + e));
        let rounding = 8.0 * degrees.iter().sum::<usize>() as f64 * T::EPSILON.to_f64();
        for (objective, expected) in [(Objective::Max, max), (Objective::Sum, sum)] {
            // The scratch is longer than needed and holds stale values, neither of which may matter.
            let mut scratch = [HalfAngle::of(T::one()); 7];
            let value = objective
                .value(stars.view(), &angles, &mut scratch)
                .unwrap();
            let difference = (value.to_f64() - expected).abs();
            assert!(
                difference <= rounding,
                "{objective:?}: {value} is not {expected}"
            );
        }
    }
}

#[test]
fn max_and_sum_equal_the_direct_evaluation() {
    values_of_the_matrices::<f32>();
    values_of_the_matrices::<f64>();
}

#[test]
fn no_star_is_closed() {
    let none = StarsView::<f64>::new(&[], &[], 0).unwrap();
    for objective in [Objective::Max, Objective::Sum] {
        assert!(objective.value(none, &[], &mut []).unwrap().abs() <= 0.0);
    }
}

#[test]
fn a_short_configuration_is_refused() {
    let stars = Stars::<f64>::new(2, &[&[(0.0, 0, false), (90.0, 1, false)]]);
    let mut scratch = [HalfAngle::default(); 2];
    let value = Objective::Max.value(stars.view(), &[0.1], &mut scratch);
    assert!(value.is_none());
}

#[test]
fn short_scratch_is_refused() {
    let stars = Stars::<f64>::new(2, &[&[(0.0, 0, false), (90.0, 1, false)]]);
    let mut scratch = [HalfAngle::default(); 1];
    assert!(
        Objective::Max
            .value(stars.view(), &[0.1, 0.2], &mut scratch)
            .is_none()
    );
}

#[test]
fn an_undefined_star_does_not_hide_behind_the_others() {
    let stars: Vec<[(f64, u32, bool); 1]> = (0..3).map(|group| [(0.0, group, false)]).collect();
    let stars = Stars::<f64>::new(3, &stars.iter().map(|s| &s[..]).collect::<Vec<_>>());
    for undefined in 0..3 {
        let mut angles = [0.5; 3];
        angles[undefined] = f64::NAN;
        for objective in [Objective::Max, Objective::Sum] {
            let value = objective.value(stars.view(), &angles, &mut [HalfAngle::default(); 3]);
            assert!(value.unwrap().is_nan());
        }
    }
}
