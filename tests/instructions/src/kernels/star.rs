//! Kernels of core on a star of four creases, each with an unknown of its own, as in planning without crease groups.

use core::hint::black_box;

use foldpath_core::least_squares::{ClosureProblem, Limits, Options, Outcome};
use foldpath_core::{
    DenseNormalEquations, GroupId, HalfAngle, Scalar, Spoke, StarView, StarsView, closure,
    gradient as descent, levenberg_marquardt as lm,
};
use nalgebra::Vector3;

/// Fold angles that do not close, radians.
const ANGLES: [f64; 4] = [-0.9, 1.4, 0.9, 1.4];
/// Number of steps of the gradient solver. One more step would reach the solution.
const STEPS: u32 = 10;

fn star<T: Scalar>() -> [Spoke<T>; 4] {
    let mut group = 0;
    [0.0_f64, 60.0, 180.0, 300.0].map(|degrees| {
        let (sin, cos) = degrees.to_radians().sin_cos();
        group += 1;
        Spoke {
            group: GroupId(group - 1),
            negative: false,
            direction: [cos, sin].map(T::lit),
        }
    })
}

fn columns<T: Scalar>() -> [Vector3<T>; 4] {
    [(); 4].map(|()| Vector3::new(T::zero(), T::zero(), T::zero()))
}

pub(super) fn closure<T: Scalar>() -> Box<dyn FnMut()> {
    let (spokes, angles) = (star::<T>(), ANGLES.map(T::lit));
    let (mut half, mut columns) = ([HalfAngle::default(); 4], columns::<T>());
    Box::new(move || {
        closure::half_angles(black_box(&angles), &mut half);
        let star = StarView { spokes: &spokes };
        black_box(closure::residual_and_jacobian(star, &half, &mut columns));
    })
}

pub(super) fn levenberg_marquardt<T: Scalar>() -> Box<dyn FnMut()> {
    let spokes = star::<T>();
    let (mut half, mut columns) = ([HalfAngle::default(); 4], columns::<T>());
    let mut memory = [T::zero(); DenseNormalEquations::<f64>::memory(4)];
    let mut work = [T::zero(); 8];
    Box::new(move || {
        let stars = StarsView::new(&spokes, &[4], 4).expect("a star");
        let mut problem = ClosureProblem::new(stars, &mut half, &mut columns).expect("room");
        let mut equations = DenseNormalEquations::new(4, &mut memory).expect("room");
        let mut x = black_box(ANGLES).map(T::lit);
        let (limits, options) = (Limits::HalfTurn, Options::default());
        let report = lm::solve(
            &mut problem,
            &mut equations,
            limits,
            &options,
            &mut x,
            &mut work,
        );
        assert_eq!(report.outcome, Outcome::Converged);
    })
}

pub(super) fn gradient() -> Box<dyn FnMut()> {
    let spokes = star::<f64>();
    let (mut half, mut columns) = ([HalfAngle::default(); 4], columns());
    let mut work = [0.0; 12];
    Box::new(move || {
        let stars = StarsView::new(&spokes, &[4], 4).expect("a star");
        let mut problem = ClosureProblem::new(stars, &mut half, &mut columns).expect("room");
        let mut x = black_box(ANGLES);
        let options = Options {
            tolerance: 0.0,
            max_iterations: STEPS,
            ..Options::default()
        };
        let report = descent::solve(&mut problem, Limits::HalfTurn, &options, &mut x, &mut work);
        assert_eq!(report.iterations, STEPS, "{report:?}");
    })
}
