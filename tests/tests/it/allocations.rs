//! Does any kernel allocate in its loop? Once its memory is there, a thousand calls must not allocate.
//!
//! Covered: closure and Jacobian, both solvers in both precisions (Levenberg-Marquardt over dense and over sparse
//! equations, to convergence and to its last iteration), projection on motions, folding map, deformation, gap, and
//! repeated queries of a scene for crossings and clearance. Not covered: work that a plan does once for each sheet or
//! each waypoint (groups, trees, knots, certificates, the sweep over a motion), which allocates.

use core::hint::black_box;

use allocation_counter::measure;
use foldpath::collision::CollisionScene;
use foldpath::folding::{FoldingMap, deformation};
use foldpath::generate::Miura;
use foldpath::pattern::CreasePattern;
use foldpath::planner::{Goal, SparseNormalEquations};
use foldpath::symmetry::{CreaseGroups, ReducedStars};
use foldpath_core::least_squares::{
    ClosureProblem, FactorReuse, Limits, NormalEquations, Options, Outcome,
};
use foldpath_core::{
    DenseNormalEquations, GroupId, HalfAngle, LoopsView, Scalar, Spoke, StarView, StarsView,
    closure, gradient, levenberg_marquardt,
};
use nalgebra::Vector3;

/// Returns the number of allocations of `times` calls, after one call that may allocate memory for all.
fn allocations(times: usize, mut call: impl FnMut(usize)) -> u64 {
    call(0);
    let counted = measure(|| (0..times).for_each(&mut call));
    counted.count_total
}

#[test]
fn the_counter_counts() {
    // Without `black_box` an optimised program would leave the allocation out.
    assert_eq!(allocations(10, |k| drop(black_box(vec![k]))), 10);
}

fn sheet() -> CreasePattern {
    let miura = Miura {
        rows: 9,
        columns: 8,
        sector_angle: 60_f64.to_radians(),
        fold: 0.7,
    };
    CreasePattern::new(miura.drawing().unwrap()).unwrap()
}

/// Returns the stars of all vertices and the goal, with every crease an unknown.
fn full(pattern: &CreasePattern) -> (ReducedStars, Vec<f64>) {
    let goal = Goal::of_pattern(pattern).unwrap();
    let groups = CreaseGroups::trivial(pattern);
    let angles = groups.reduce(&goal.fold_angles);
    let stars = ReducedStars::all(pattern, &groups);
    (stars, angles.into_iter().map(Option::unwrap).collect())
}

/// Returns a Miura vertex with two groups.
fn star<T: Scalar>() -> [Spoke<T>; 4] {
    let (sin, cos) = 60_f64.to_radians().sin_cos();
    let directions = [[1.0, 0.0], [cos, sin], [-1.0, 0.0], [cos, -sin]];
    core::array::from_fn(|k| Spoke {
        group: GroupId([1, 0, 1, 0][k]),
        negative: k == 0,
        direction: directions[k].map(T::lit),
    })
}

/// Returns a start that differs a little from call to call.
fn start<T: Scalar>(call: usize) -> [T; 2] {
    let k = f64::from(u32::try_from(call % 97).unwrap());
    [T::lit(1.0 + 1e-3 * k), T::lit(0.7 - 2e-3 * k)]
}

fn small_solvers_do_not_allocate<T: Scalar>() {
    let spokes = star::<T>();
    let stars = StarsView::new(&spokes, &[4], 2).unwrap();
    let mut half = vec![HalfAngle::default(); 2];
    let mut columns = vec![Vector3::repeat(T::zero()); 4];
    let mut memory = vec![T::zero(); DenseNormalEquations::<T>::memory(2)];
    let mut work = vec![T::zero(); 6];
    let mut converged = 0;
    let count = allocations(1000, |call| {
        let mut x = start::<T>(call);
        closure::half_angles(&x, &mut half);
        let view = StarView { spokes: &spokes };
        let residual = closure::residual_and_jacobian(view, &half, &mut columns).unwrap();
        assert!(residual.x.is_finite());

        let mut problem = ClosureProblem::new(stars, &mut half, &mut columns).unwrap();
        let mut equations = DenseNormalEquations::new(2, &mut memory).unwrap();
        let options = Options::default();
        let limits = Limits::HalfTurn;
        let report = levenberg_marquardt::solve(
            &mut problem,
            &mut equations,
            limits,
            &options,
            &mut x,
            &mut work,
        );
        converged += usize::from(report.outcome == Outcome::Converged);

        let mut direction = [T::one(), T::zero()];
        assert!(problem.linearise(&x, &mut equations).is_some());
        assert!(levenberg_marquardt::project_on_motions(
            &mut equations,
            &mut direction
        ));

        let mut x = start::<T>(call);
        let options = Options {
            max_iterations: 1000,
            ..options
        };
        let report = gradient::solve(&mut problem, limits, &options, &mut x, &mut work);
        converged += usize::from(report.outcome == Outcome::Converged);
    });
    assert_eq!(count, 0);
    assert_eq!(converged, 2 * 1001);
}

#[test]
fn small_solvers_do_not_allocate_in_f64() {
    small_solvers_do_not_allocate::<f64>();
}

#[test]
fn small_solvers_do_not_allocate_in_f32() {
    small_solvers_do_not_allocate::<f32>();
}

/// With every crease an unknown: whole solves, and solves that are cut off after each number of iterations.
#[test]
fn large_solvers_do_not_allocate() {
    let pattern = sheet();
    let (stars, angles) = full(&pattern);
    let view = stars.view();
    let n = angles.len();
    let mut half = vec![HalfAngle::default(); n];
    let mut columns = vec![Vector3::zeros(); view.max_degree()];
    let mut work = vec![0.0; 3 * n];
    let mut problem = ClosureProblem::new(view, &mut half, &mut columns).unwrap();
    let mut sparse = SparseNormalEquations::new(view, LoopsView::none()).unwrap();
    let mut memory = vec![0.0; DenseNormalEquations::<f64>::memory(n)];
    let mut dense = DenseNormalEquations::new(n, &mut memory).unwrap();
    let mut x = vec![0.0; n];
    let off = |call: usize, x: &mut [f64]| {
        for (k, (x, angle)) in x.iter_mut().zip(&angles).enumerate() {
            let noise = f64::from(u32::try_from((k * 31 + call * 17) % 101).unwrap()) / 50.0 - 1.0;
            *x = angle + 0.2 * noise;
        }
    };
    fn solve(
        problem: &mut ClosureProblem<'_, f64>,
        equations: &mut impl NormalEquations<f64>,
        (factor_reuse, max_iterations): (FactorReuse, u32),
        x: &mut [f64],
        work: &mut [f64],
    ) -> Outcome {
        let options = Options {
            max_iterations,
            factor_reuse,
            ..Options::default()
        };
        let limits = Limits::HalfTurn;
        levenberg_marquardt::solve(problem, equations, limits, &options, x, work).outcome
    }
    let none = [1, 2, 3, 100].map(|iterations| (FactorReuse::None, iterations));
    let chord = [1, 100].map(|iterations| (FactorReuse::Chord, iterations));
    for form in none.into_iter().chain(chord) {
        let (mut converged, mut cut_off) = (0, 0);
        let count = allocations(20, |call| {
            off(call, &mut x);
            let outcome = solve(&mut problem, &mut sparse, form, &mut x, &mut work);
            converged += usize::from(outcome == Outcome::Converged);
            cut_off += usize::from(outcome == Outcome::IterationLimit);
        });
        assert_eq!(count, 0, "sparse, {form:?}");
        let expected = if form.1 == 100 { (21, 0) } else { (0, 21) };
        assert_eq!((converged, cut_off), expected, "{form:?}");
    }
    let count = allocations(2, |call| {
        off(call, &mut x);
        let outcome = solve(
            &mut problem,
            &mut dense,
            (FactorReuse::None, 3),
            &mut x,
            &mut work,
        );
        assert_eq!(outcome, Outcome::IterationLimit);
        off(call, &mut x);
        let options = Options {
            max_iterations: 100,
            ..Options::default()
        };
        let report = gradient::solve(&mut problem, Limits::HalfTurn, &options, &mut x, &mut work);
        assert!(report.iterations > 1);
    });
    assert_eq!(count, 0, "dense and gradient");
}

#[test]
fn the_folded_sheet_is_measured_without_allocating() {
    let pattern = sheet();
    let (_, angles) = full(&pattern);
    let tree = pattern.tree();
    let mut map = FoldingMap::new(&pattern, tree, &angles);
    let mut part = angles.clone();
    let mut worst = 0.0_f64;
    let count = allocations(200, |call| {
        let scale = 1.0 - 1e-4 * f64::from(u32::try_from(call).unwrap());
        for (part, angle) in part.iter_mut().zip(&angles) {
            *part = angle * scale;
        }
        map.fold(&pattern, tree, &part);
        worst = worst.max(map.rigidity(&pattern, tree).worst());
        worst = worst.max(deformation(&pattern, map.vertices()));
    });
    assert_eq!(count, 0);
    assert!(worst > 0.0);
}

#[test]
fn a_scene_is_asked_again_without_allocating() {
    let pattern = sheet();
    let (_, angles) = full(&pattern);
    let tree = pattern.tree();
    let groups = CreaseGroups::find(&pattern);
    let goal = groups.reduce(&angles.iter().copied().map(Some).collect::<Vec<_>>());
    let goal: Vec<f64> = goal.into_iter().map(Option::unwrap).collect();
    // The Miura motion: tangents of the half angles are proportional.
    let fold = |part: f64| {
        let at = |angle: &f64| 2.0 * (part * (angle / 2.0).tan()).atan();
        groups.expand(&goal.iter().map(at).collect::<Vec<f64>>())
    };
    let maps: Vec<FoldingMap> = (1..=50)
        .map(|k| FoldingMap::new(&pattern, tree, &fold(f64::from(k) / 50.0)))
        .collect();
    let mut scene = CollisionScene::new(&pattern);
    // The first round allocates the hierarchy's stack.
    let round = |scene: &mut CollisionScene| {
        for map in &maps {
            assert_eq!(scene.deepest_crossing(map, 1e-6), None);
        }
    };
    assert_eq!(allocations(3, |_| round(&mut scene)), 0);
    assert!(scene.counts().tested > 0);
}
