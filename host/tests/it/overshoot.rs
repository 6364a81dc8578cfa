//! Tests the fractions of its limits that a trajectory uses, against closed forms and differences of sampled angles.

use crate::common::{near, placed};
use foldpath::planner::Overshoot;
use foldpath::planner::timing::{OptimalTimeLaw, RateLimits};
use foldpath_core::Interpolation;
use foldpath_core::follower::FollowerPosition;
use foldpath_core::trajectory::TrajectoryView;

#[test]
fn a_cubic_from_rest_to_rest() {
    // 3s² - 2s³ has the rate 3/2 in the middle and the second derivative 6 at its ends.
    let (way, time) = (0.8, 0.5);
    let (spans, angles) = ([0.0, time], [0.3, 0.3 + way]);
    let view = TrajectoryView::new(Interpolation::Hermite, 1, &spans, &angles, &[0.0; 2], &[]);
    let used = Overshoot::of(view.unwrap(), &[2.0], &[4.0]);
    near(used.speed, 1.5 * way / time / 2.0, 1e-14);
    near(used.acceleration, 6.0 * way / (time * time) / 4.0, 1e-14);
    near(
        used.stretch(),
        f64::max(used.speed, used.acceleration.sqrt()),
        1e-14,
    );
}

#[test]
fn a_straight_line_in_the_tangent_of_the_half_angle() {
    // ρ = 2 atan ks: ρ' = 2k / (1 + k²s²), and -ρ'' is largest at ks = 1/√3, where it is 9k²/(4√3).
    let (k, time) = (2.0_f64, 0.5);
    let angles = [0.0, 2.0 * k.atan()];
    let rates = [2.0 * k / time, 2.0 * k / (1.0 + k * k) / time];
    let spans = [0.0, time];
    let view = TrajectoryView::new(Interpolation::HalfAngle, 1, &spans, &angles, &rates, &[]);
    let used = Overshoot::of(view.unwrap(), &[1.0], &[1.0]);
    near(used.speed, 2.0 * k / time, 1e-14);
    let most = 9.0 * k * k / (4.0 * 3.0_f64.sqrt());
    near(used.acceleration, most / (time * time), 1e-12);
}

const TIMES: [f64; 4] = [0.0, 0.7, 1.0, 2.5];
const SPANS: [f64; 4] = [0.0, 0.7, 0.3, 1.5];
const ANGLES: [f64; 8] = [0.0, 0.0, 0.4, -0.9, 1.3, -1.2, 2.9, 0.4];
const RATES: [f64; 8] = [0.1, -0.2, 1.1, -1.3, 1.9, -0.2, 0.3, 2.0];
const WEIGHTS: [[f64; 2]; 8] = [
    [1.0, 0.0],
    [1.0, 0.2],
    [1.4, 0.1],
    [0.8, -0.2],
    [1.1, 0.0],
    [1.0, 0.3],
    [0.9, -0.1],
    [1.0, 0.0],
];
const SPEEDS: [f64; 2] = [2.0, 3.0];
const ACCELERATIONS: [f64; 2] = [7.0, 5.0];

/// Returns the largest fractions of the limits that are used, by differences of angles sampled within the segments.
fn of_differences(view: TrajectoryView<'_, f64>) -> [f64; 2] {
    let step = 1e-4;
    let angles = |time: f64| {
        let mut angles = [0.0; 2];
        let place = FollowerPosition {
            knot: 0,
            into: time,
        };
        view.sample(place, &mut angles);
        angles
    };
    let mut most = [0.0_f64; 2];
    for segment in TIMES.windows(2) {
        let mut time = segment[0] + step;
        while time < segment[1] - step {
            let [before, now, after] = [time - step, time, time + step].map(angles);
            for g in 0..2 {
                let rate = (after[g] - before[g]) / (2.0 * step);
                let bend = (after[g] - 2.0 * now[g] + before[g]) / (step * step);
                most[0] = most[0].max(rate.abs() / SPEEDS[g]);
                most[1] = most[1].max(bend.abs() / ACCELERATIONS[g]);
            }
            time += step;
        }
    }
    most
}

#[test]
fn sampled_angles_move_so_fast() {
    for kind in [
        Interpolation::Linear,
        Interpolation::Hermite,
        Interpolation::HalfAngle,
        Interpolation::Homogeneous,
    ] {
        let homogeneous = kind == Interpolation::Homogeneous;
        let weights: &[[f64; 2]] = if homogeneous { &WEIGHTS } else { &[] };
        let view = TrajectoryView::new(kind, 2, &SPANS, &ANGLES, &RATES, weights).unwrap();
        let [speed, acceleration] = of_differences(view);
        let used = Overshoot::of(view, &SPEEDS, &ACCELERATIONS);
        near(used.speed, speed, 2e-3);
        let difference = (used.acceleration - acceleration).abs();
        assert!(
            difference <= 2e-3 * acceleration + 1e-6,
            "{kind:?} {used:?} {acceleration}"
        );
    }
}

#[test]
fn what_does_not_move_uses_nothing() {
    let one = TrajectoryView::new(Interpolation::Hermite, 1, &[0.0], &[1.0], &[5.0], &[]).unwrap();
    assert_eq!(Overshoot::of(one, &[1.0], &[1.0]), Overshoot::default());
    let (spans, angles, rates) = ([0.0, 1.0], [1.0; 2], [0.0; 2]);
    let still = TrajectoryView::new(Interpolation::HalfAngle, 1, &spans, &angles, &rates, &[]);
    let used = Overshoot::of(still.unwrap(), &[1.0], &[f64::INFINITY]);
    assert!(used.stretch() <= 1e-15);
}

/// Returns the two angles of a Miura fold, with their first and second derivatives by the first angle.
fn miura(sigma: f64) -> [[f64; 2]; 3] {
    let k = 0.3;
    let tan = (sigma / 2.0).tan();
    let (sec, below) = (1.0 + tan * tan, 1.0 + k * k * tan * tan);
    let second = k * sec * tan / below - k.powi(3) * tan * (sec / below).powi(2);
    [
        [sigma, 2.0 * (k * tan).atan()],
        [1.0, k * sec / below],
        [0.0, second],
    ]
}

#[test]
fn knots_where_the_law_switches_keep_the_limits() {
    let (speeds, accelerations) = ([1.0, 0.5], [3.0, 3.0]);
    let parameters: Vec<f64> = (0..=2000).map(|k| 2.8 * f64::from(k) / 2000.0).collect();
    let row = |order: usize| {
        parameters
            .iter()
            .flat_map(move |&sigma| miura(sigma)[order])
            .collect()
    };
    let (first, second): (Vec<f64>, Vec<f64>) = (row(1), row(2));
    let limits = RateLimits {
        speeds: &speeds,
        accelerations: &accelerations,
    };
    let law = OptimalTimeLaw::time_optimal(&parameters, [&first, &second], limits).unwrap();
    let place = placed(&law);
    let used = |times: &[f64]| {
        let at = |&time: &f64| {
            let [sigma, _] = place(time);
            let [angles, first, _] = miura(sigma);
            (angles, first.map(|d| d * law.speed_at(sigma)))
        };
        let (angles, rates): (Vec<_>, Vec<_>) = times.iter().map(at).unzip();
        let (angles, rates) = (angles.concat(), rates.concat());
        let mut spans: Vec<f64> = times.windows(2).map(|ends| ends[1] - ends[0]).collect();
        spans.insert(0, 0.0);
        let view = TrajectoryView::new(Interpolation::Hermite, 2, &spans, &angles, &rates, &[]);
        Overshoot::of(view.unwrap(), &speeds, &accelerations)
    };
    let even: Vec<f64> = (0..=20)
        .map(|k| law.duration() * f64::from(k) / 20.0)
        .collect();
    let mut placed = even.clone();
    placed.extend(law.switches().iter().map(|&k| law.times()[k]));
    placed.sort_by(f64::total_cmp);
    assert!(used(&even).acceleration > 1.2);
    assert!(used(&placed).stretch() <= 1.01, "{:?}", used(&placed));
}
