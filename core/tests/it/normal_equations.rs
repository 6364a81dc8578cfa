//! Do the dense normal equations give the step of nalgebra's Cholesky factorisation?

use foldpath_core::least_squares::{Accumulate, NormalEquations};
use foldpath_core::{DenseNormalEquations, Scalar};
use foldpath_test_support::Random;
use foldpath_test_support::stars::Stars;
use nalgebra::{SMatrix, SVector, Vector3};

const STARS: usize = 3;

/// Compares the equations in N unknowns; several spokes of a star may share an unknown.
fn equals_nalgebra<T: Scalar, const N: usize>() {
    let mut memory = vec![T::zero(); DenseNormalEquations::<T>::memory(N)];
    let mut equations = DenseNormalEquations::new(N, &mut memory).unwrap();
    let mut rng = Random::new(31);
    for _ in 0..200 {
        // The rows of three stars are added up twice: by core, and in `f64` by nalgebra.
        equations.clear();
        let (mut matrix, mut gradient) =
            (SMatrix::<f64, N, N>::zeros(), SVector::<f64, N>::zeros());
        for index in 0..STARS {
            let degree = 1 + rng.below(8);
            let stars = Stars::<T>::random(&mut rng, N, &[degree]);
            let mut vector = || Vector3::from_fn(|_, _| T::lit(rng.uniform(-1.0, 1.0)));
            let columns: Vec<Vector3<T>> = (0..degree).map(|_| vector()).collect();
            let residual = vector();
            equations.add(index, &stars.spokes, &columns, &residual);
            let mut jacobian = SMatrix::<f64, 3, N>::zeros();
            for (spoke, column) in stars.spokes.iter().zip(&columns) {
                let mut sum = jacobian.column_mut(spoke.group.index());
                sum += column.map(T::to_f64);
            }
            matrix += jacobian.transpose() * jacobian;
            gradient += jacobian.transpose() * residual.map(T::to_f64);
        }
        // An entry adds up at most 3 · 8 · 8 products of size 3.
        let rounding = 200.0 * T::EPSILON.to_f64();
        for (ours, theirs) in equations.gradient().iter().zip(&gradient) {
            assert!((ours.to_f64() - theirs).abs() <= rounding);
        }
        let max = matrix.diagonal().max();
        assert!((equations.max_diagonal().to_f64() - max).abs() <= rounding);

        let held = rng.below(N);
        let by = rng.uniform(-1.0, 1.0);
        let growth = equations.fix_unknown(held, T::lit(by)).to_f64();
        let expected = by * (gradient[held] + 0.5 * matrix[(held, held)] * by);
        assert!((growth - expected).abs() <= rounding);
        gradient += matrix.column(held) * by;
        matrix.row_mut(held).fill(0.0);
        matrix.column_mut(held).fill(0.0);
        gradient[held] = 0.0;
        let damping = 0.5;
        assert!(equations.factorise(T::lit(damping)));
        let damped = matrix + SMatrix::identity() * damping;
        let cholesky = damped.cholesky().unwrap();
        let condition = (N as f64 * max + damping) / damping;
        let compare = |ours: [T; N], expected: SVector<f64, N>| {
            for (ours, theirs) in ours.iter().zip(&expected) {
                let error = (ours.to_f64() - theirs).abs();
                let bound = condition * N as f64 * T::EPSILON.to_f64() * expected.norm();
                assert!(error <= bound, "{error:e}");
            }
        };
        let mut step = [T::zero(); N];
        equations.step(&mut step);
        compare(step, cholesky.solve(&-gradient));
        let right_side: [T; N] = core::array::from_fn(|_| T::lit(rng.uniform(-1.0, 1.0)));
        let mut solution = right_side;
        equations.solve(&mut solution);
        let right_side = SVector::from(right_side.map(T::to_f64));
        compare(solution, cholesky.solve(&right_side));
    }
}

#[test]
fn solution_equals_nalgebras() {
    equals_nalgebra::<f32, 3>();
    equals_nalgebra::<f64, 3>();
    equals_nalgebra::<f32, 6>();
    equals_nalgebra::<f64, 6>();
}

#[test]
fn a_matrix_that_is_not_positive_definite_is_refused() {
    let mut memory = [0.0; DenseNormalEquations::<f64>::memory(2)];
    let mut equations = DenseNormalEquations::new(2, &mut memory).unwrap();
    let stars = Stars::new(2, &[&[(0.0, 0, false), (90.0, 1, false)]]);
    let mut factorise = |entry: f64, damping| {
        equations.clear();
        let columns = [Vector3::new(entry, 0.0, 0.0), Vector3::new(0.0, 2.0, 0.0)];
        equations.add(0, &stars.spokes, &columns, &Vector3::zeros());
        equations.factorise(damping)
    };
    assert!(factorise(1.0, 0.0));
    assert!(factorise(0.0, 1.0));
    assert!(!factorise(0.0, 0.0), "singular");
    assert!(!factorise(1.0, -2.0), "indefinite");
    assert!(!factorise(f64::NAN, 1.0), "not a number");
}

#[test]
fn memory_is_checked() {
    let mut memory = vec![0.0; DenseNormalEquations::<f64>::memory(3)];
    assert!(DenseNormalEquations::new(3, &mut memory).is_some());
    assert!(DenseNormalEquations::new(3, &mut memory[1..]).is_none());
    assert!(DenseNormalEquations::new(usize::MAX, &mut memory).is_none());
    let mut nothing = DenseNormalEquations::<f64>::new(0, &mut []).unwrap();
    assert!(nothing.factorise(0.0));
    nothing.solve(&mut []);
}
