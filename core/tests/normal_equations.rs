//! The dense normal equations against nalgebra's Cholesky factorisation.

mod common;

use common::{Stars, below, rng, uniform};
use foldpath_core::least_squares::{Accumulate, NormalEquations};
use foldpath_core::{DenseNormalEquations, Scalar};
use nalgebra::{SMatrix, SVector, Vector3};

const N: usize = 6;

fn equals_nalgebra<T: Scalar>() {
    let mut rng = rng(31);
    let mut memory = vec![T::zero(); DenseNormalEquations::<T>::memory(N)];
    let mut equations = DenseNormalEquations::new(N, &mut memory).unwrap();
    for _ in 0..200 {
        // The rows of three stars, written down twice: the second time in f64 by nalgebra.
        equations.clear();
        let (mut matrix, mut gradient) = (SMatrix::<f64, N, N>::zeros(), SVector::zeros());
        for index in 0..3 {
            let degree = 1 + below(&mut rng, 8);
            let stars = Stars::<T>::random(&mut rng, N, &[degree]);
            let mut vector = || Vector3::from_fn(|_, _| T::lit(uniform(&mut rng, -1.0, 1.0)));
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

        let damping = 0.5;
        let right_side: [T; N] = core::array::from_fn(|_| T::lit(uniform(&mut rng, -1.0, 1.0)));
        let mut solution = right_side;
        assert!(equations.factorise(T::lit(damping)));
        equations.solve(&mut solution);
        let damped = matrix + SMatrix::identity() * damping;
        let expected = damped.cholesky().unwrap();
        let expected = expected.solve(&SVector::from(right_side.map(T::to_f64)));
        let condition = (N as f64 * max + damping) / damping;
        for (ours, theirs) in solution.iter().zip(&expected) {
            let error = (ours.to_f64() - theirs).abs();
            assert!(error <= condition * N as f64 * T::EPSILON.to_f64() * expected.norm());
        }
    }
}

#[test]
fn solution_equals_nalgebras() {
    equals_nalgebra::<f32>();
    equals_nalgebra::<f64>();
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
