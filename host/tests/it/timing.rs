//! Tests time-optimal speeds along a path against closed forms, quadrature and integration in the phase plane.

use core::f64::consts::{FRAC_PI_2, FRAC_PI_4, FRAC_PI_8, TAU};

use crate::common::{near, placed};
use foldpath::planner::timing::{OptimalTimeLaw, RateLimits};
use rand_pcg::Pcg64;
use rand_pcg::rand_core::{Rng, SeedableRng};

/// First and second derivatives of each group's angle, as functions of the path parameter σ.
type Derivatives<'a> = &'a dyn Fn(f64) -> (Vec<f64>, Vec<f64>);

/// A path sampled on a grid, with limits.
struct Case {
    parameters: Vec<f64>,
    first: Vec<f64>,
    second: Vec<f64>,
    speeds: Vec<f64>,
    accelerations: Vec<f64>,
}

impl Case {
    fn new(speeds: &[f64], accelerations: &[f64]) -> Self {
        Self {
            parameters: Vec::new(),
            first: Vec::new(),
            second: Vec::new(),
            speeds: speeds.to_vec(),
            accelerations: accelerations.to_vec(),
        }
    }

    /// Adds a piece of the path from σ = `from` to `to`, with `intervals` intervals.
    fn piece(mut self, from: f64, to: f64, intervals: u32, path: Derivatives<'_>) -> Self {
        for k in 0..=intervals {
            let sigma = from + (to - from) * f64::from(k) / f64::from(intervals);
            let (first, second) = path(sigma);
            self.parameters.push(sigma);
            self.first.extend(first);
            self.second.extend(second);
        }
        self
    }

    fn law(&self) -> Option<OptimalTimeLaw> {
        let limits = RateLimits {
            speeds: &self.speeds,
            accelerations: &self.accelerations,
        };
        OptimalTimeLaw::time_optimal(&self.parameters, [&self.first, &self.second], limits)
    }

    fn at_rest(&self) -> OptimalTimeLaw {
        self.law().unwrap()
    }

    /// Returns the largest fractions of the limits on speed and acceleration that are used on the path itself, sampled
    /// at 10 kHz.
    fn used(&self, law: &OptimalTimeLaw, path: Derivatives<'_>) -> [f64; 2] {
        let mut used = [0.0_f64; 2];
        let place = placed(law);
        let mut time = 0.0;
        while time < law.duration() {
            let [sigma, a] = place(time);
            let v = law.speed_at(sigma);
            let (first, second) = path(sigma);
            for (g, (d, c)) in first.iter().zip(&second).enumerate() {
                used[0] = used[0].max((d * v).abs() / self.speeds[g]);
                used[1] = used[1].max((c * v * v + d * a).abs() / self.accelerations[g]);
            }
            time += 1e-4;
        }
        used
    }
}

fn within_limits(used: [f64; 2]) {
    assert!(used.iter().all(|&part| part <= 1.001), "{used:?}");
}

/// Returns the shortest time from rest to rest over a way, by high school physics.
fn trapezoid(way: f64, speed: f64, acceleration: f64) -> f64 {
    let ramp = speed * speed / acceleration;
    if ramp >= way {
        2.0 * (way / acceleration).sqrt()
    } else {
        2.0 * speed / acceleration + (way - ramp) / speed
    }
}

fn straight(_: f64) -> (Vec<f64>, Vec<f64>) {
    (vec![1.0], vec![0.0])
}

#[test]
fn one_hinge_runs_a_trapezoid_or_a_triangle() {
    for (way, speed, acceleration) in [(2.0, 1.0, 3.0), (2.0, 5.0, 3.0), (1e-3, 40.0, 0.1)] {
        let exact = trapezoid(way, speed, acceleration);
        let error = |intervals| {
            let case = Case::new(&[speed], &[acceleration]).piece(0.0, way, intervals, &straight);
            let law = case.at_rest();
            within_limits(case.used(&law, &straight));
            (law.duration() / exact - 1.0).abs()
        };
        let errors = [25, 101, 401].map(error);
        assert!(
            errors[2] <= 1e-3 && errors[2] <= 1e-12 + errors[0] / 4.0,
            "{errors:?}"
        );
    }
}

#[test]
fn one_hinge_switches_where_the_ramps_end() {
    let law = Case::new(&[1.0], &[2.0])
        .piece(0.0, 2.0, 400, &straight)
        .at_rest();
    let places: Vec<f64> = law
        .switches()
        .iter()
        .map(|&k| law.parameters()[k])
        .collect();
    assert_eq!(places.len(), 2, "{places:?}");
    near(places[0], 0.25, 0.03);
    near(places[1], 1.75, 0.03);
}

#[test]
fn the_parameter_does_not_matter() {
    // The path ρ = sin σ is taken over a part of its range, and over the whole range, where ρ' vanishes at the ends.
    let sine = |sigma: f64| (vec![sigma.cos()], vec![-sigma.sin()]);
    for (reach, speed) in [(1.0, 1.0), (1.0, 7.0), (FRAC_PI_2, 1.0), (FRAC_PI_2, 7.0)] {
        let exact = trapezoid(2.0 * f64::sin(reach), speed, 3.0);
        let error = |intervals| {
            let case = Case::new(&[speed], &[3.0]).piece(-reach, reach, intervals, &sine);
            let law = case.at_rest();
            within_limits(case.used(&law, &sine));
            (law.duration() / exact - 1.0).abs()
        };
        // The error is of first order in the grid, because ρ'' makes u vary within an interval.
        let errors = [400, 1600, 6400].map(error);
        assert!(errors[2] <= 1e-3, "{errors:?}");
        assert!(
            errors.windows(2).all(|pair| pair[1] <= 0.3 * pair[0]),
            "{errors:?}"
        );
    }
}

#[test]
fn the_hinge_with_the_tightest_scaled_limits_rules() {
    let ratio = -2.5;
    let both = |_: f64| (vec![1.0, ratio], vec![0.0, 0.0]);
    for (speeds, accelerations) in [
        ([1.0, 1.0], [3.0, 3.0]),
        ([1.0, 9.0], [3.0, 1.0]),
        ([1.0, 4.0], [3.0, 9.0]),
    ] {
        let speed = f64::min(speeds[0], speeds[1] / 2.5);
        let acceleration = f64::min(accelerations[0], accelerations[1] / 2.5);
        let law = Case::new(&speeds, &accelerations)
            .piece(0.0, 2.0, 400, &both)
            .at_rest();
        near(law.duration(), trapezoid(2.0, speed, acceleration), 1e-3);
    }
}

/// Returns the derivatives of the two angles of a Miura fold, whose half-angle tangents are in proportion k.
fn miura(sigma: f64) -> (Vec<f64>, Vec<f64>) {
    let k = 0.3_f64;
    let tan = (sigma / 2.0).tan();
    let (sec, below) = (1.0 + tan * tan, 1.0 + k * k * tan * tan);
    let first = k * sec / below;
    let second = k * sec * tan / below - k * sec * k * k * tan * sec / (below * below);
    (vec![1.0, first], vec![0.0, second])
}

#[test]
fn speed_limits_alone_give_the_integral_of_the_slowest_hinge() {
    let speeds = [1.0, 0.5];
    let slowest = |sigma: f64| f64::max(1.0 / speeds[0], miura(sigma).0[1].abs() / speeds[1]);
    let end = 2.8;
    let cells = 200_000;
    let width = end / f64::from(cells);
    let exact: f64 = (0..cells)
        .map(|k| slowest((f64::from(k) + 0.5) * width) * width)
        .sum();
    let error = |intervals| {
        let case = Case::new(&speeds, &[f64::INFINITY; 2]).piece(0.0, end, intervals, &miura);
        let law = case.at_rest();
        near(law.speed_at(0.0), 1.0, 1e-12);
        near(law.speed_at(end), 0.5 / miura(end).0[1], 1e-12);
        (law.duration() / exact - 1.0).abs()
    };
    assert!(error(400) <= 1e-3 && error(1600) <= error(400) / 4.0);
}

fn circle(sigma: f64) -> (Vec<f64>, Vec<f64>) {
    let (sin, cos) = sigma.sin_cos();
    (vec![-sin, cos], vec![-cos, -sin])
}

/// Returns the shortest time round the circle with accelerations up to 1 and no other limit. One hinge after the other
/// is at its limit, so that all pieces have a constant acceleration.
fn round_the_circle() -> f64 {
    // From rest, hinge 2 speeds up at its limit, x = 2 sin σ / cos² σ, until hinge 1 reaches its limit.
    let (mut low, mut high) = (0.0_f64, 1.0_f64);
    for _ in 0..60 {
        let middle = (low + high) / 2.0;
        let (sin, cos) = middle.sin_cos();
        let pull = 2.0 * sin / cos.powi(3) + sin / cos;
        (low, high) = if pull < 1.0 {
            (middle, high)
        } else {
            (low, middle)
        };
    }
    let first = low;
    let speed = (2.0 * first.sin()).sqrt() / first.cos();
    let ramp = (2.0 * first.sin()).sqrt();
    // Then hinge 1 speeds up at its limit, sin² σ x / 2 = c - cos σ, until hinge 2 has to slow down towards the
    // quarter, at which its speed is 0: cos² σ x / 2 = 1 - sin σ.
    let c = first.cos() + (first.sin() * speed).powi(2) / 2.0;
    let over = |sigma: f64| {
        (c - sigma.cos()) / sigma.sin().powi(2) - (1.0 - sigma.sin()) / sigma.cos().powi(2)
    };
    let (mut low, mut high) = (first, 1.5);
    for _ in 0..60 {
        let middle = (low + high) / 2.0;
        (low, high) = if over(middle) < 0.0 {
            (middle, high)
        } else {
            (low, middle)
        };
    }
    let [at_first, at_second] = [first.sin() * speed, (2.0 * (c - low.cos())).sqrt()];
    let slowing = (2.0 * (1.0 - low.sin())).sqrt();
    // In the two quarters in the middle, x = 1 / cos² (δ/2) at a distance δ from the nearest end of a quarter.
    2.0 * (ramp + (at_second - at_first) + slowing) + 2.0 * 4.0 * FRAC_PI_8.sin()
}

#[test]
fn hinges_take_turns_at_their_limits_round_a_circle() {
    let exact = round_the_circle();
    let error = |intervals| {
        let case = Case::new(&[100.0; 2], &[1.0; 2]).piece(0.0, TAU, intervals, &circle);
        let law = case.at_rest();
        within_limits(case.used(&law, &circle));
        law.duration() / exact - 1.0
    };
    let errors = [400, 1600, 6400].map(error);
    assert!(
        errors.iter().all(|&error| error > 0.0) && errors[2] <= 1e-4,
        "{errors:?}"
    );
    assert!(
        errors.windows(2).all(|pair| pair[1] <= 0.3 * pair[0]),
        "{errors:?}"
    );
}

#[test]
fn hinges_turn_back_without_chattering() {
    // In the middle of the circle one hinge turns back at each multiple of a quarter. The inertia is zero there, and x
    // = 1.
    for intervals in [397, 400, 1603] {
        let case = Case::new(&[100.0; 2], &[1.0; 2]).piece(0.0, TAU, intervals, &circle);
        let law = case.at_rest();
        let grid: Vec<(f64, f64)> = law.parameters().iter().copied().zip(law.speeds()).collect();
        let middle = |&(sigma, _): &(f64, f64)| sigma > FRAC_PI_2 && sigma < 3.0 * FRAC_PI_2;
        for &(sigma, v) in grid.iter().filter(|point| middle(point)) {
            let turn = (sigma / FRAC_PI_2).round() * FRAC_PI_2;
            near(v * v, ((sigma - turn) / 2.0).cos().powi(-2), 0.02);
        }
        let squares = grid
            .iter()
            .filter(|point| middle(point))
            .map(|(_, v)| v * v);
        let squares: Vec<f64> = squares.collect();
        let variation: f64 = squares
            .windows(2)
            .map(|pair| (pair[1] - pair[0]).abs())
            .sum();
        near(variation, 4.0 * (FRAC_PI_8.cos().powi(-2) - 1.0), 0.05);
    }
}

/// Group angles that are the sum of a line and a wave each, with limits, drawn from a seed.
struct Waves {
    /// Slope, height, frequency and phase of each group.
    groups: Vec<[f64; 4]>,
    case: Case,
}

impl Waves {
    fn new(seed: u64, speed: f64, intervals: u32) -> Self {
        let mut random = Pcg64::seed_from_u64(seed);
        let mut next = || f64::from(random.next_u32()) / f64::from(u32::MAX);
        let groups: Vec<[f64; 4]> = (0..1 + seed % 4)
            .map(|_| {
                [
                    2.0 * next() - 1.0,
                    2.0 * next(),
                    0.5 + 3.0 * next(),
                    6.0 * next(),
                ]
            })
            .collect();
        let speeds: Vec<f64> = groups.iter().map(|_| speed * (0.5 + next())).collect();
        let accelerations: Vec<f64> = groups.iter().map(|_| 0.5 + next()).collect();
        let mut waves = Self {
            groups,
            case: Case::new(&[], &[]),
        };
        let case = Case::new(&speeds, &accelerations);
        waves.case = case.piece(0.0, 3.0, intervals, &|sigma| waves.derivatives(sigma));
        waves
    }

    fn derivatives(&self, sigma: f64) -> (Vec<f64>, Vec<f64>) {
        let first = |&[slope, a, w, phase]: &[f64; 4]| slope + a * w * (w * sigma + phase).cos();
        let second = |&[_, a, w, phase]: &[f64; 4]| -a * w * w * (w * sigma + phase).sin();
        (
            self.groups.iter().map(first).collect(),
            self.groups.iter().map(second).collect(),
        )
    }
}

impl Case {
    /// Returns the largest fraction of a limit on acceleration or speed that is used at the ends of the interval after
    /// point k, with σ̇² = x at its beginning and y at its end.
    fn load(&self, k: usize, x: f64, y: f64) -> f64 {
        let groups = self.speeds.len();
        let u = (y - x) / (2.0 * (self.parameters[k + 1] - self.parameters[k]));
        let mut load = 0.0_f64;
        for (point, x) in [(k, x), (k + 1, y)] {
            for g in 0..groups {
                let (d, c) = (
                    self.first[point * groups + g],
                    self.second[point * groups + g],
                );
                load = load.max((c * x + d * u).abs() / self.accelerations[g]);
                load = load.max(d.abs() * x.sqrt() / self.speeds[g]);
            }
        }
        load
    }
}

#[test]
fn no_point_can_be_faster() {
    for seed in 0..40 {
        let waves = Waves::new(seed, if seed < 20 { 100.0 } else { 1.0 }, 500);
        let law = waves.case.at_rest();
        within_limits(waves.case.used(&law, &|sigma| waves.derivatives(sigma)));
        let x: Vec<f64> = law.speeds().map(|v| v * v).collect();
        for k in 1..x.len() - 1 {
            let load = |x1: f64| {
                f64::max(
                    waves.case.load(k - 1, x[k - 1], x1),
                    waves.case.load(k, x1, x[k + 1]),
                )
            };
            assert!(
                load(x[k]) <= 1.0 + 1e-9,
                "seed {seed}, point {k}: {}",
                load(x[k])
            );
            assert!(
                load(1.01 * x[k]) > 1.0 + 1e-6,
                "seed {seed}, point {k}: {}",
                load(1.01 * x[k])
            );
        }
    }
}

/// Returns the shortest time of all motions on a lattice of values of σ̇², by dynamic programming.
fn least_time(case: &Case, lattice: &[f64]) -> f64 {
    let last = case.parameters.len() - 1;
    let mut to_go: Vec<f64> = lattice
        .iter()
        .map(|&x| if x > 0.0 { f64::INFINITY } else { 0.0 })
        .collect();
    for k in (0..last).rev() {
        let span = case.parameters[k + 1] - case.parameters[k];
        let least = |&x: &f64| {
            let reachable = lattice
                .iter()
                .zip(&to_go)
                .filter(|&(&y, _)| case.load(k, x, y) <= 1.0);
            let times = reachable.map(|(y, to_go)| 2.0 * span / (x.sqrt() + y.sqrt()) + to_go);
            times.fold(f64::INFINITY, f64::min)
        };
        to_go = lattice.iter().map(least).collect();
    }
    to_go[0]
}

#[test]
fn dynamic_programming_finds_nothing_faster() {
    for seed in [1, 5, 22, 31] {
        let waves = Waves::new(seed, 2.0, 50);
        let law = waves.case.at_rest();
        let top = law.speeds().fold(0.0, f64::max).powi(2) * 1.02;
        let lattice: Vec<f64> = (0..=400)
            .map(|k| top * (f64::from(k) / 400.0).powi(2))
            .collect();
        let least = least_time(&waves.case, &lattice);
        assert!(law.duration() <= least && law.duration() >= 0.99 * least);
    }
}

#[test]
fn the_motion_stops_where_the_path_turns_a_corner() {
    let there = |_: f64| (vec![1.0, 0.0], vec![0.0, 0.0]);
    let aside = |_: f64| (vec![0.0, 2.0], vec![0.0, 0.0]);
    let corner = Case::new(&[1.0, 1.0], &[3.0, 3.0])
        .piece(0.0, 1.0, 500, &there)
        .piece(1.0, 2.0, 500, &aside);
    let law = corner.at_rest();
    let exact = [trapezoid(1.0, 1.0, 3.0), trapezoid(2.0, 1.0, 3.0)];
    near(law.duration(), exact[0] + exact[1], 1e-3);
    near(law.time_at(1.0), exact[0], 1e-3);
    assert!(law.speed_at(1.0) <= 0.0);
    // If only the first hinge has a limit on its acceleration, the other hinge need not start from rest.
    let half = Case {
        accelerations: vec![3.0, f64::INFINITY],
        ..corner
    };
    near(half.at_rest().duration(), exact[0] + 2.0, 1e-3);
}

#[test]
fn a_point_given_twice_is_passed_if_only_the_second_derivative_jumps() {
    // The path is a line that continues as a quarter of a circle and then as another line. The limits on speed bind
    // everywhere except at the ends, where the limits on acceleration bind: all pieces have closed forms.
    let line = |_: f64| (vec![0.0, 1.0], vec![0.0, 0.0]);
    let back = |_: f64| (vec![-1.0, 0.0], vec![0.0, 0.0]);
    let case = Case::new(&[0.3; 2], &[1.0; 2])
        .piece(-1.0, 0.0, 500, &line)
        .piece(0.0, FRAC_PI_2, 500, &circle)
        .piece(FRAC_PI_2, FRAC_PI_2 + 1.0, 500, &back);
    let law = case.at_rest();
    near(law.speed_at(0.0), 0.3, 1e-12);
    near(law.time_at(0.0), 0.3 / 2.0 + 1.0 / 0.3, 1e-3);
    near(law.speed_at(FRAC_PI_2), 0.3, 1e-12);
    let arc = law.time_at(FRAC_PI_2) - law.time_at(0.0);
    near(arc, 2.0 * FRAC_PI_4.sin() / 0.3, 1e-3);
}

#[test]
fn time_and_parameter_are_inverse() {
    let case = Case::new(&[0.95; 2], &[1.0; 2]).piece(0.0, TAU, 300, &circle);
    let law = case.at_rest();
    let place = placed(&law);
    for k in 1..1000 {
        let sigma = TAU * f64::from(k) / 1000.0;
        let time = law.time_at(sigma);
        assert!((place(time)[0] - sigma).abs() <= 1e-12 * TAU);
        let step = 1e-6;
        let speed = (place(time + step)[0] - place(time - step)[0]) / (2.0 * step);
        assert!(
            (speed - law.speed_at(sigma)).abs() <= 1e-5,
            "{speed} at {sigma}"
        );
    }
    assert!(law.time_at(-1.0) <= 0.0);
    near(law.time_at(1e9), law.duration(), 1e-15);
    assert!(law.time_at(f64::NAN).is_finite());
}

#[test]
fn there_is_no_law_without_motion_or_with_unsound_numbers() {
    let good = || Case::new(&[1.0], &[1.0]).piece(0.0, 1.0, 4, &straight);
    assert!(good().law().is_some());
    let changes: [fn(&mut Case); 9] = [
        |c| c.speeds[0] = f64::INFINITY,
        |c| c.speeds[0] = f64::NAN,
        |c| c.accelerations[0] = 0.0,
        |c| c.accelerations[0] = f64::NAN,
        |c| c.second[2] = f64::NAN,
        |c| c.parameters[4] = f64::INFINITY,
        |c| c.first.fill(0.0),
        |c| c.parameters.fill(0.5),
        |c| c.parameters.clear(),
    ];
    for (index, change) in changes.iter().enumerate() {
        let mut case = good();
        change(&mut case);
        assert!(case.law().is_none(), "{index}");
    }
    // Both points rest, and there is none between them to move at.
    let two = Case::new(&[1.0], &[1.0]).piece(0.0, 1.0, 1, &straight);
    assert!(two.law().is_none());
}

#[test]
fn numbers_of_any_size_are_no_panic() {
    let mut random = Pcg64::seed_from_u64(7);
    let mut any = |scale: i32| {
        let exponent = f64::from(random.next_u32() % 601) - 300.0;
        let sign = [0.0, 1.0, -1.0, 1.0][random.next_u32() as usize % 4];
        sign * 10_f64.powf(exponent * f64::from(scale) / 100.0)
    };
    let mut laws = 0;
    for round in 0..4000 {
        let scale = [1, 10, 100][round % 3];
        let mut case = Case::new(
            &[any(scale).abs(), any(scale).abs()],
            &[any(scale).abs(), any(scale).abs()],
        );
        case.parameters = (0..7).map(|_| any(scale)).collect();
        case.parameters.sort_by(f64::total_cmp);
        case.first = (0..14).map(|_| any(scale)).collect();
        case.second = (0..14).map(|_| any(scale)).collect();
        let Some(law) = case.law() else {
            continue;
        };
        laws += 1;
        assert!(law.duration().is_finite() && law.duration() >= 0.0);
        assert!(law.speeds().all(|v| v.is_finite()));
        let sigma = 0.6 * case.parameters[0] + 0.4 * case.parameters[6];
        assert!(!law.time_at(sigma).is_nan() && !law.speed_at(sigma).is_nan());
    }
    assert!(laws > 300, "{laws}");
}
