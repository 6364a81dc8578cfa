//! Are random configurations reproducible, near their centre and evenly spread?

use foldpath_core::Scalar;
use foldpath_core::least_squares::Limits;
use foldpath_core::sampling::random_near;
use foldpath_test_support::Random;

const GROUPS: usize = 1000;

fn sample<T: Scalar>(seed: u64, center: f64, radius: f64, limits: Limits<'_, T>) -> Vec<T> {
    let mut out = vec![T::zero(); GROUPS];
    let center = [T::lit(center); GROUPS];
    random_near(
        &mut Random::new(seed),
        &center,
        T::lit(radius),
        limits,
        &mut out,
    );
    out
}

fn in_both_precisions<T: Scalar>() {
    let near = |seed| sample::<T>(seed, 1.0, 0.3, Limits::HalfTurn);
    let bits = |sample: Vec<T>| -> Vec<u64> {
        sample
            .iter()
            .map(|angle| angle.to_f64().to_bits())
            .collect()
    };
    assert_eq!(bits(near(1)), bits(near(1)));
    assert_ne!(bits(near(1)), bits(near(2)));

    let offsets: Vec<f64> = near(1).iter().map(|angle| angle.to_f64() - 1.0).collect();
    let radius = 0.3 + T::EPSILON.to_f64();
    assert!(offsets.iter().all(|offset| offset.abs() <= radius));
    // The samples use the whole range evenly: the mean of 1000 samples has a standard deviation of 0.0055.
    let (low, high) = offsets.iter().fold((0.0_f64, 0.0_f64), |(low, high), &o| {
        (low.min(o), high.max(o))
    });
    assert!(low < -0.29 && high > 0.29, "{low} {high}");
    let mean = offsets.iter().sum::<f64>() / GROUPS as f64;
    assert!(mean.abs() < 0.02, "{mean}");

    let half_turn = sample::<T>(1, 3.0, 1.0, Limits::HalfTurn);
    assert!(half_turn.iter().all(|&angle| angle <= T::PI));
    assert!(half_turn.iter().any(|&angle| angle >= T::PI));
    let limits = [(T::lit(0.9), T::lit(1.05)); GROUPS];
    let limited = sample::<T>(1, 1.0, 0.3, Limits::Each(&limits));
    assert!(
        limited
            .iter()
            .all(|angle| (T::lit(0.9)..=T::lit(1.05)).contains(angle))
    );
}

#[test]
fn samples_are_reproducible_and_near() {
    in_both_precisions::<f32>();
    in_both_precisions::<f64>();
}

#[test]
fn a_seed_gives_these_angles_on_every_machine() {
    let first = &sample::<f64>(1, 0.0, 1.0, Limits::HalfTurn)[..3];
    let expected: [f64; 3] = [
        0.14088105483466773,
        0.9146248921553197,
        -0.020479883304908797,
    ];
    assert!(
        first
            .iter()
            .map(|x| x.to_bits())
            .eq(expected.map(f64::to_bits))
    );
}
