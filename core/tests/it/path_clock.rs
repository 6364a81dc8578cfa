//! Does the path clock take the time that closed forms of motion under constant acceleration give?

use foldpath_core::Scalar;
use foldpath_core::path_clock::{ClockLimits, PathClock};
use foldpath_test_support::Random;

/// A clock at rest whose limits stay the same.
struct Limited<T> {
    clock: PathClock<T>,
    limits: ClockLimits<T>,
}

impl<T: Scalar> Limited<T> {
    fn tick(&mut self, dt: T, goal: T, left: T) -> T {
        self.clock.tick(self.limits, dt, goal, left)
    }

    fn rate(&self) -> T {
        self.clock.rate()
    }
}

fn clock<T: Scalar>(rise: f64, brake: f64) -> Limited<T> {
    Limited {
        clock: PathClock::default(),
        limits: ClockLimits {
            rise: T::lit(rise),
            brake: T::lit(brake),
        },
    }
}

/// Runs the clock over `left` seconds of the path and returns the number of ticks. Asserts that every change of the
/// rate is within the limits and that the clock can always stop in time.
fn run<T: Scalar>(rise: f64, brake: f64, dt: f64, mut left: T) -> u32 {
    let mut clock = clock::<T>(rise, brake);
    let slack = 8.0 * T::EPSILON.to_f64();
    for tick in 1..1_000_000 {
        let before = clock.rate().to_f64();
        let passed = clock.tick(T::lit(dt), T::one(), left);
        assert!(passed >= T::zero() && passed <= left);
        left -= passed;
        let (rate, left) = (clock.rate().to_f64(), left.to_f64());
        assert!((0.0..=1.0).contains(&rate));
        assert!(rate - before <= rise * dt + slack, "{before} {rate}");
        // The path time left has a rounding error of its own size, and the rate, its root, inherits that error.
        let rounding = slack * (1.0 + left / (dt * brake * dt));
        assert!(
            before - rate <= brake * dt * (1.0 + 1e-3) + rounding,
            "{before} {rate} {left}"
        );
        assert!(rate * rate / (2.0 * brake) <= left + slack * (left + before * dt));
        if left == 0.0 && rate == 0.0 {
            return tick;
        }
    }
    panic!("{left:?} is left");
}

fn ends_in_the_time_of_the_closed_form<T: Scalar>() {
    let mut rng = Random::new(71);
    for _ in 0..300 {
        let (rise, brake) = (rng.uniform(0.5, 20.0), rng.uniform(0.5, 20.0));
        let dt = rng.uniform(2e-4, 5e-3);
        let left = rng.uniform(0.001, 4.0);
        let ticks = f64::from(run(rise, brake, dt, T::lit(left)));
        // The highest rate reached, at most 1, and the time for rising, cruising and braking.
        let top = (2.0 * left / (1.0 / rise + 1.0 / brake)).sqrt().min(1.0);
        let ends = top * (1.0 / rise + 1.0 / brake);
        let time = ends + (left - top * ends / 2.0) / top;
        let late = ticks * dt - time;
        assert!(
            late > -2.0 * dt && late < 4.0 * dt,
            "{late} of {time} at {dt}"
        );
    }
}

#[test]
fn it_stops_exactly_at_the_end_and_in_time() {
    ends_in_the_time_of_the_closed_form::<f64>();
    ends_in_the_time_of_the_closed_form::<f32>();
}

#[test]
fn a_hold_takes_the_braking_distance_and_a_resume_goes_on() {
    let (dt, brake) = (1e-3, 2.0);
    let mut clock = clock::<f64>(4.0, brake);
    let go = |clock: &mut Limited<f64>, goal, ticks| {
        (0..ticks).map(|_| clock.tick(dt, goal, 1e9)).sum::<f64>()
    };
    go(&mut clock, 1.0, 300);
    assert!((clock.rate() - 1.0).abs() < 1e-15);
    let distance = go(&mut clock, 0.0, 501);
    assert!((distance - 1.0 / (2.0 * brake)).abs() < 1e-12, "{distance}");
    assert!(clock.rate().abs() < 1e-15);
    assert!(go(&mut clock, 0.0, 10).abs() < 1e-15);
    go(&mut clock, 0.5, 125);
    assert!((clock.rate() - 0.5).abs() < 1e-12);
}

#[test]
fn more_path_lifts_the_cap_without_a_jump() {
    let mut clock = clock::<f64>(5.0, 5.0);
    let mut left: f64 = 0.02;
    let mut last = 0.0;
    for tick in 0..4000 {
        if tick % 20 == 0 && tick < 3000 {
            left += 0.02;
        }
        left -= clock.tick(1e-3, 1.0, left);
        assert!((clock.rate() - last).abs() <= 5e-3 + 1e-12);
        last = clock.rate();
    }
    assert!(left.abs() < 1e-15 && last.abs() < 1e-15);
}

#[test]
fn halting_is_at_once_and_nonsense_moves_nothing() {
    let mut running = clock::<f32>(10.0, 1.0);
    let _ = running.tick(0.1, 1.0, 100.0);
    running.clock.halt();
    assert_eq!(running.rate().to_bits(), 0);
    let nan = f32::NAN;
    for (dt, goal, left) in [
        (nan, 1.0, 9.0),
        (0.1, nan, 9.0),
        (0.1, 1.0, nan),
        (-1.0, 1.0, 9.0),
    ] {
        assert_eq!(running.tick(dt, goal, left).to_bits(), 0);
        assert_eq!(running.rate().to_bits(), 0, "{dt} {goal} {left}");
    }
}
