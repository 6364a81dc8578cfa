//! Benchmarks of the kernels that every solver step runs: `cargo bench -p foldpath-core --bench closure`.

use core::array;

use divan::black_box;
use foldpath_core::least_squares::{ClosureProblem, Limits, Options};
use foldpath_core::{
    DenseNormalEquations, GroupId, HalfAngle, Scalar, Spoke, StarView, StarsView, closure,
    levenberg_marquardt,
};
use nalgebra::Vector3;

fn main() {
    divan::main();
}

/// A star of four creases, each its own unknown, as in full-DOF planning.
fn star<T: Scalar>() -> [Spoke<T>; 4] {
    let (sin, cos) = 60_f64.to_radians().sin_cos();
    let directions = [[1.0, 0.0], [cos, sin], [-1.0, 0.0], [cos, -sin]];
    array::from_fn(|k| Spoke {
        group: GroupId([0, 1, 2, 3][k]),
        negative: false,
        direction: directions[k].map(T::lit),
    })
}

const ANGLES: [f64; 4] = [-0.9, 1.4, 0.9, 1.4];

#[divan::bench(types = [f32, f64])]
fn half_angles_residual_and_jacobian_of_degree_4<T: Scalar>(bencher: divan::Bencher<'_, '_>) {
    let spokes = star::<T>();
    let angles = ANGLES.map(T::lit);
    let mut half = [HalfAngle::default(); 4];
    let mut columns = [Vector3::new(T::zero(), T::zero(), T::zero()); 4];
    bencher.bench_local(|| {
        closure::half_angles(black_box(&angles), &mut half);
        let star = StarView { spokes: &spokes };
        black_box(closure::residual_and_jacobian(star, &half, &mut columns))
    });
}

#[divan::bench(types = [f32, f64])]
fn levenberg_marquardt_to_the_tolerance_4_unknowns<T: Scalar>(bencher: divan::Bencher<'_, '_>) {
    let spokes = star::<T>();
    let stars = StarsView::new(&spokes, &[4], 4).unwrap();
    let mut half = [HalfAngle::default(); 4];
    let mut columns = [Vector3::new(T::zero(), T::zero(), T::zero()); 4];
    let mut memory = [T::zero(); DenseNormalEquations::<f64>::memory(4)];
    let mut workspace = [T::zero(); 8];
    bencher.bench_local(|| {
        let mut problem = ClosureProblem::new(stars, &mut half, &mut columns).unwrap();
        let mut equations = DenseNormalEquations::new(4, &mut memory).unwrap();
        let mut x = ANGLES.map(T::lit);
        let options = Options::default();
        let limits = Limits::HalfTurn;
        let work = &mut workspace;
        levenberg_marquardt::solve(&mut problem, &mut equations, limits, &options, &mut x, work)
    });
}
