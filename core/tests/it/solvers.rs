//! Do both solvers find closed configurations, keep to limits and report the truth? Every check runs in both
//! precisions, with memory in arrays and in `Vec`.

use core::f64::consts::PI;
use foldpath_core::least_squares::{ClosureProblem, Limits, Options, Outcome, Report};
use foldpath_core::sampling::random_near;
use foldpath_core::{DenseNormalEquations, HalfAngle, Scalar};
use foldpath_core::{gradient, levenberg_marquardt};
use foldpath_test_support::stars::{
    Stars, foldability_error, miura, miura_angles, waterbomb, waterbomb_angles,
};
use foldpath_test_support::{Random, cast};
use nalgebra::Vector3;

/// Source of a solver's memory.
trait Storage {
    /// Returns memory for at least `length` values.
    fn room<V: Copy>(value: V, length: usize) -> impl AsMut<[V]>;
}

/// Memory as on the controller: of fixed size, usually larger than the problem needs.
struct Arrays;

impl Storage for Arrays {
    fn room<V: Copy>(value: V, length: usize) -> impl AsMut<[V]> {
        assert!(length <= 40);
        [value; 40]
    }
}

/// Memory as on the host.
struct Vecs;

impl Storage for Vecs {
    fn room<V: Copy>(value: V, length: usize) -> impl AsMut<[V]> {
        vec![value; length]
    }
}

#[derive(Clone, Copy, Debug, PartialEq)]
enum Method {
    LevenbergMarquardt,
    Gradient,
}

use Method::{Gradient, LevenbergMarquardt};

const METHODS: [Method; 2] = [LevenbergMarquardt, Gradient];

impl Method {
    fn workspace(self, unknowns: usize) -> usize {
        match self {
            LevenbergMarquardt => 2 * unknowns,
            Gradient => 3 * unknowns,
        }
    }

    /// Returns options with the iterations that the method may need.
    fn options<T: Scalar>(self) -> Options<T> {
        Options {
            max_iterations: match self {
                LevenbergMarquardt => 100,
                Gradient => 1000,
            },
            ..Options::default()
        }
    }

    fn solve<T: Scalar, S: Storage>(
        self,
        stars: &Stars<T>,
        limits: Limits<'_, T>,
        options: &Options<T>,
        x: &mut [T],
    ) -> Report<T> {
        let mut workspace = S::room(T::zero(), self.workspace(stars.unknowns));
        self.solve_in::<T, S>(stars, limits, options, x, workspace.as_mut())
    }

    fn solve_in<T: Scalar, S: Storage>(
        self,
        stars: &Stars<T>,
        limits: Limits<'_, T>,
        options: &Options<T>,
        x: &mut [T],
        workspace: &mut [T],
    ) -> Report<T> {
        let (view, n) = (stars.view(), stars.unknowns);
        let mut half = S::room(HalfAngle::default(), n);
        let mut columns = S::room(Vector3::repeat(T::zero()), view.max_degree());
        let mut problem = ClosureProblem::new(view, half.as_mut(), columns.as_mut()).unwrap();
        match self {
            LevenbergMarquardt => {
                let mut memory = S::room(T::zero(), DenseNormalEquations::<T>::memory(n));
                let mut equations = DenseNormalEquations::new(n, memory.as_mut()).unwrap();
                levenberg_marquardt::solve(
                    &mut problem,
                    &mut equations,
                    limits,
                    options,
                    x,
                    workspace,
                )
            }
            Gradient => gradient::solve(&mut problem, limits, options, x, workspace),
        }
    }
}

/// Asserts that the report is true of `x`, by the 4x4 matrices, which the solvers do not use.
fn assert_honest<T: Scalar>(stars: &Stars<T>, options: &Options<T>, x: &[T], report: &Report<T>) {
    let errors = stars.view().iter().map(|star| foldability_error(star, x));
    let residual = errors.fold(0.0, f64::max) / 2_f64.sqrt();
    let rounding = 8.0 * stars.view().max_degree() as f64 * T::EPSILON.to_f64();
    let converged = report.residual <= options.tolerance;
    let said = report.residual.to_f64();
    // If a bound proves that the last point closes, the solver does not evaluate it and reports the bound.
    let more_than_is = said - residual > rounding && !converged;
    assert!(
        residual - said <= rounding && !more_than_is,
        "{report:?}, but {residual:e} at {x:?}"
    );
    assert_eq!(
        report.outcome == Outcome::Converged,
        converged,
        "{report:?}"
    );
    assert!(report.iterations <= options.max_iterations, "{report:?}");
}

/// Returns Miura folds: sector angle in degrees, a closed configuration, and a start near it, in radians.
fn miura_starts<T: Scalar>(count: usize) -> impl Iterator<Item = (f64, [T; 2], [T; 2])> {
    let mut rng = Random::new(11);
    (0..count).map(move |_| {
        let sector = rng.uniform(20.0, 80.0);
        let closed = cast(miura_angles(sector, rng.uniform(0.5, 2.5)));
        let mut start = closed;
        let radius = T::lit(rng.uniform(0.05, 0.3));
        random_near(&mut rng, &closed, radius, Limits::HalfTurn, &mut start);
        (sector, closed, start)
    })
}

/// Returns the error of tan(minor/2) = cos(sector) tan(major/2), multiplied out so that it stays bounded at half turns.
/// This error is below the residual: its slope is below 1, that of the residual about 2.
fn miura_error<T: Scalar>(sector: f64, x: [T; 2]) -> f64 {
    let [(sin_major, cos_major), (sin_minor, cos_minor)] = x.map(|x| (x.to_f64() / 2.0).sin_cos());
    (sin_minor * cos_major - sector.to_radians().cos() * sin_major * cos_minor).abs()
}

fn finds_the_miura_fold_again<T: Scalar, S: Storage>() {
    let method = LevenbergMarquardt;
    let options = method.options();
    for (sector, _, start) in miura_starts::<T>(300) {
        let stars = miura(sector, false, false);
        let mut x = start;
        let report = method.solve::<T, S>(&stars, Limits::HalfTurn, &options, &mut x);
        assert_eq!(
            report.outcome,
            Outcome::Converged,
            "{sector} {start:?} {report:?}"
        );
        assert!(report.iterations <= 6, "{sector} {start:?} {report:?}");
        assert_honest(&stars, &options, &x, &report);
        let error = miura_error(sector, x);
        assert!(
            error <= T::CLOSURE_TOLERANCE.to_f64(),
            "{error:e} {sector} {x:?}"
        );
    }
}

fn finds_the_waterbomb_again<T: Scalar, S: Storage>() {
    let method = LevenbergMarquardt;
    let mut rng = Random::new(12);
    let stars = waterbomb();
    let options = method.options();
    for _ in 0..300 {
        let closed: [T; 4] = cast(waterbomb_angles(rng.uniform(0.3, 0.95)));
        let mut x = closed;
        let radius = T::lit(rng.uniform(0.05, 0.3));
        random_near(&mut rng, &closed, radius, Limits::HalfTurn, &mut x);
        let start = x;
        let report = method.solve::<T, S>(&stars, Limits::HalfTurn, &options, &mut x);
        assert_eq!(report.outcome, Outcome::Converged, "{start:?} {report:?}");
        assert!(report.iterations <= 15, "{start:?} {report:?}");
        assert_honest(&stars, &options, &x, &report);
        let expected = waterbomb_angles((x[0].to_f64() / 2.0).tan());
        for (x, expected) in x.iter().zip(expected) {
            // Three factors: √2 for two residuals, 4 for a singular value above 1/4, and 2.2 because b moves 2.2
            // times as fast as m.
            let error = (x.to_f64() - expected).abs();
            assert!(
                error <= 20.0 * T::CLOSURE_TOLERANCE.to_f64(),
                "{error:e} {x:?}"
            );
        }
    }
}

fn converges_quadratically<T: Scalar, S: Storage>() {
    let method = LevenbergMarquardt;
    let mut squared = 0;
    for (sector, _, start) in miura_starts::<T>(200) {
        let stars = miura(sector, false, false);
        let residual = |max_iterations| {
            let options = Options {
                max_iterations,
                ..Options::default()
            };
            let mut x = start;
            let report = method.solve::<T, S>(&stars, Limits::HalfTurn, &options, &mut x);
            report.residual.to_f64()
        };
        let residuals: Vec<f64> = (0..6).map(residual).collect();
        for drop in residuals.windows(2) {
            let (before, after) = (drop[0], drop[1]);
            let bound = 4.0 * before * before;
            let floor = T::CLOSURE_TOLERANCE.to_f64();
            assert!(
                after <= bound.max(floor),
                "{sector} {start:?}: {residuals:?}"
            );
            squared += usize::from(before < 0.1 && bound > floor);
        }
    }
    assert!(squared >= 100, "{squared} drops show the order");
}

fn what_closes_for_certain_is_not_evaluated<T: Scalar, S: Storage>() {
    let method = LevenbergMarquardt;
    let mut rng = Random::new(16);
    let mut spared = 0;
    for run in 0..3000 {
        let (stars, closed) = match run % 2 {
            0 => (
                waterbomb(),
                waterbomb_angles(rng.uniform(0.3, 0.95)).to_vec(),
            ),
            _ => (miura(60.0, false, false), miura_angles(60.0, 1.5).to_vec()),
        };
        let closed: Vec<T> = closed.into_iter().map(T::lit).collect();
        let mut x = closed.clone();
        let radius = T::lit(rng.uniform(0.001, 0.5));
        random_near(&mut rng, &closed, radius, Limits::HalfTurn, &mut x);
        // Some steps reach one of these limits, and some the limit on their length.
        let near = |angle| (angle - T::lit(0.1), angle + T::lit(rng.uniform(0.0, 0.5)));
        let limits: Vec<(T, T)> = closed.iter().copied().map(near).collect();
        let finest = T::CLOSURE_TOLERANCE.to_f64().log10();
        let options = Options {
            tolerance: T::lit(10_f64.powf(rng.uniform(finest, 0.0))),
            acceptable: T::zero(),
            max_step: T::lit(rng.uniform(0.1, 1.0)),
            ..method.options()
        };
        let report = method.solve::<T, S>(&stars, Limits::Each(&limits), &options, &mut x);
        assert_honest(&stars, &options, &x, &report);
        assert_within(&limits, &x);
        spared += usize::from(report.iterations > 0 && report.evaluations <= report.iterations);
    }
    assert!(spared > 1000, "{spared} of 3000");
}

fn no_step_makes_it_worse<T: Scalar, S: Storage>() {
    let method = LevenbergMarquardt;
    let mut rng = Random::new(15);
    let stars = miura(60.0, false, false);
    for _ in 0..300 {
        let start = rng.angles::<T>(2);
        let mut before = T::MAX;
        for max_iterations in 0..20 {
            let options = Options {
                max_iterations,
                ..Options::default()
            };
            let mut x = start.clone();
            let report = method.solve::<T, S>(&stars, Limits::HalfTurn, &options, &mut x);
            assert!(
                report.residual <= before,
                "{start:?} {max_iterations}: {report:?}"
            );
            before = report.residual;
        }
    }
}

fn both_solvers_agree<T: Scalar, S: Storage>() {
    for (sector, _, start) in miura_starts::<T>(300) {
        let stars = miura(sector, false, false);
        let [damped, steepest] = METHODS.map(|method| {
            let options = method.options();
            let mut x = start;
            let report = method.solve::<T, S>(&stars, Limits::HalfTurn, &options, &mut x);
            assert_eq!(
                report.outcome,
                Outcome::Converged,
                "{sector} {start:?} {report:?}"
            );
            assert_honest(&stars, &options, &x, &report);
            x
        });
        let error = miura_error(sector, steepest);
        assert!(
            error <= T::CLOSURE_TOLERANCE.to_f64(),
            "{error:e} {sector} {steepest:?}"
        );
        // Both methods reach points of the motion near the start, but not the same point.
        let apart = damped
            .iter()
            .zip(&steepest)
            .map(|(a, b)| (*a - *b).abs().to_f64());
        assert!(apart.fold(0.0, f64::max) <= 0.15, "{damped:?} {steepest:?}");
    }
}

fn stays_within_limits<T: Scalar, S: Storage>() {
    let mut rng = Random::new(13);
    let mut converged = 0;
    for (sector, closed, start) in miura_starts::<T>(300) {
        let room = |angle| {
            let below = T::lit(rng.uniform(0.02, 0.1));
            (angle - below, angle + T::lit(0.1))
        };
        let limits = closed.map(room);
        let stars = miura(sector, false, false);
        for method in METHODS {
            let mut x = start;
            let options = method.options();
            let report = method.solve::<T, S>(&stars, Limits::Each(&limits), &options, &mut x);
            assert_honest(&stars, &options, &x, &report);
            assert_within(&limits, &x);
            converged += usize::from(report.outcome == Outcome::Converged);
        }
    }
    // All converge here; `moves_along_an_active_limit` at the end has the hard cases of active limits.
    assert!(converged == 600, "{converged} of 600");
}

fn limits_that_exclude_every_solution<T: Scalar, S: Storage>() {
    // The limits exclude every solution because both angles of a Miura fold have the same sign.
    let limits: [(T, T); 2] = [(1.0, 1.2), (-0.5, -0.2)].map(|(a, b)| (T::lit(a), T::lit(b)));
    for method in METHODS {
        for start in [[1.1, -0.3], [1.0, -0.5], [-3.0, 3.0]] {
            let mut x: [T; 2] = cast(start);
            let stars = miura(60.0, false, false);
            let options = method.options();
            let report = method.solve::<T, S>(&stars, Limits::Each(&limits), &options, &mut x);
            assert_honest(&stars, &options, &x, &report);
            assert_within(&limits, &x);
            let given_up = [Outcome::Stalled, Outcome::IterationLimit];
            assert!(given_up.contains(&report.outcome), "{method:?} {report:?}");
        }
    }
}

fn assert_within<T: Scalar>(limits: &[(T, T)], x: &[T]) {
    let within = |(x, limits): (&T, &(T, T))| limits.0 <= *x && *x <= limits.1;
    assert!(x.iter().zip(limits).all(within), "{x:?} {limits:?}");
}

fn stays_honest_from_anywhere<T: Scalar, S: Storage>() {
    let mut rng = Random::new(14);
    let options = LevenbergMarquardt.options();
    let stars = miura(60.0, false, false);
    let corners = [-T::PI, T::zero(), T::PI];
    let corners = corners.iter().flat_map(|&a| corners.map(|b| vec![a, b]));
    let starts: Vec<Vec<T>> = corners.chain((0..10_000).map(|_| rng.angles(2))).collect();
    let mut converged = 0;
    for start in &starts {
        let mut x = start.clone();
        let report = LevenbergMarquardt.solve::<T, S>(&stars, Limits::HalfTurn, &options, &mut x);
        assert_honest(&stars, &options, &x, &report);
        assert_within(&[(-T::PI, T::PI); 2], &x);
        converged += usize::from(report.outcome == Outcome::Converged);
    }
    // In `f32` a few runs stall where the rotation of a star is half a turn off and the residual is largest.
    assert!(
        converged * 1000 >= starts.len() * 998,
        "{converged} of {}",
        starts.len()
    );
}

fn iteration_limit_is_kept<T: Scalar, S: Storage>() {
    let stars = miura(60.0, false, false);
    for method in METHODS {
        for max_iterations in 0..=2 {
            let mut x: [T; 2] = cast([2.0, 0.3]);
            let options = Options {
                max_iterations,
                ..Options::default()
            };
            let report = method.solve::<T, S>(&stars, Limits::HalfTurn, &options, &mut x);
            assert_eq!(report.outcome, Outcome::IterationLimit);
            assert_eq!(report.iterations, max_iterations);
            assert_honest(&stars, &options, &x, &report);
        }
    }
}

fn too_little_memory_is_an_outcome<T: Scalar, S: Storage>() {
    let stars = miura(60.0, false, false);
    let closed: [T; 2] = cast(miura_angles(60.0, 1.0));
    for method in METHODS {
        let options = method.options();
        let solve = |x: &mut [T], workspace: usize| {
            let mut workspace = vec![T::zero(); workspace];
            let limits = Limits::HalfTurn;
            let report = method.solve_in::<T, S>(&stars, limits, &options, x, &mut workspace);
            report.outcome
        };
        let enough = method.workspace(2);
        for workspace in 0..enough {
            assert_eq!(solve(&mut closed.clone(), workspace), Outcome::Capacity);
        }
        assert_eq!(solve(&mut closed.clone(), enough), Outcome::Converged);
        for length in [0, 1, 3] {
            let mut x = vec![T::one(); length];
            assert_eq!(solve(&mut x, 3 * enough), Outcome::Capacity);
            assert_eq!(x, vec![T::one(); length]);
        }
    }
}

fn a_start_that_is_no_number_is_an_outcome<T: Scalar, S: Storage>() {
    let (nan, infinity) = (T::lit(f64::NAN), T::lit(f64::INFINITY));
    let stars = miura(60.0, false, false);
    for method in METHODS {
        let options = method.options();
        let solve = |limits, mut x: [T; 2]| {
            let report = method.solve::<T, S>(&stars, limits, &options, &mut x);
            (report.outcome, x)
        };
        for x in [[nan, T::one()], [T::one(), nan]] {
            assert_eq!(solve(Limits::HalfTurn, x).0, Outcome::NotFinite);
        }
        let unlimited = [(-infinity, infinity); 2];
        for x in [[infinity, T::one()], [T::one(), -infinity]] {
            assert_eq!(solve(Limits::Each(&unlimited), x).0, Outcome::NotFinite);
            // Limits clamp an infinite start like any other.
            let (outcome, x) = solve(Limits::HalfTurn, x);
            assert_ne!(outcome, Outcome::NotFinite);
            assert_within(&[(-T::PI, T::PI); 2], &x);
        }
        // Unknown 2 belongs to no crease, so that all stars close at any value of it.
        let flat = Stars::new(3, &[&[(0.0, 0, false), (90.0, 1, false)]]);
        let mut x = [T::zero(), T::zero(), nan];
        let report = method.solve::<T, S>(&flat, Limits::HalfTurn, &options, &mut x);
        assert_eq!(report.outcome, Outcome::NotFinite);
    }
}

/// Instantiates the checks for both precisions and both kinds of memory.
macro_rules! suite {
    ($($check:ident)*) => {
        mod f32_in_arrays { $(#[test] fn $check() { super::$check::<f32, super::Arrays>(); })* }
        mod f64_in_arrays { $(#[test] fn $check() { super::$check::<f64, super::Arrays>(); })* }
        mod f32_in_vecs { $(#[test] fn $check() { super::$check::<f32, super::Vecs>(); })* }
        mod f64_in_vecs { $(#[test] fn $check() { super::$check::<f64, super::Vecs>(); })* }
    };
}

suite! {
    finds_the_miura_fold_again
    finds_the_waterbomb_again
    converges_quadratically
    what_closes_for_certain_is_not_evaluated
    no_step_makes_it_worse
    both_solvers_agree
    stays_within_limits
    limits_that_exclude_every_solution
    stays_honest_from_anywhere
    iteration_limit_is_kept
    too_little_memory_is_an_outcome
    a_start_that_is_no_number_is_an_outcome
}

#[test]
fn a_gradient_step_too_short_to_move_is_no_stall() {
    let stars = waterbomb();
    let mut x: [f32; 4] = [1.536_099_6, 2.176_539_7, -1.937_379, 2.846_196_2];
    let options = Gradient.options();
    let report = Gradient.solve::<f32, Vecs>(&stars, Limits::HalfTurn, &options, &mut x);
    assert_eq!(report.outcome, Outcome::Converged, "{report:?}");
}

#[test]
fn moves_along_an_active_limit() {
    // The major angle reaches -π. The motion from there along the limit to (-π, π), which closes, is free.
    let half_turn = [(-PI, PI); 2];
    // The minor angle reaches its lower limit. A closed configuration lies 0.06 rad away.
    let tight = [(0.41, 0.60), (0.36, 0.49)];
    let cases = [
        (60.0, half_turn, [-3.04, 1.14]),
        (39.0, tight, [0.43, 0.31]),
    ];
    for (sector, limits, start) in cases {
        let stars = miura(sector, false, false);
        for method in METHODS {
            let mut x = start;
            let options = method.options();
            let limits = Limits::Each(&limits);
            let report = method.solve::<f64, Vecs>(&stars, limits, &options, &mut x);
            assert_eq!(
                report.outcome,
                Outcome::Converged,
                "{method:?} {report:?} {x:?}"
            );
        }
    }
}
