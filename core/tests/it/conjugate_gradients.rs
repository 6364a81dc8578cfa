//! Does the truncated conjugate-gradient step come close to the step of nalgebra's Cholesky factorisation?

use foldpath_core::{Scalar, conjugate_gradients};
use foldpath_test_support::Random;
use nalgebra::{SMatrix, SVector};

const N: usize = 8;

/// Returns JᵀJ of a random Jacobian with `rows` rows and N columns, and a gradient in the range of JᵀJ.
fn equations(rows: usize, seed: u64) -> (SMatrix<f64, N, N>, SVector<f64, N>) {
    let mut rng = Random::new(seed);
    let mut matrix = SMatrix::<f64, N, N>::zeros();
    let mut gradient = SVector::<f64, N>::zeros();
    for _ in 0..rows {
        let row = SVector::<f64, N>::from_fn(|_, _| rng.uniform(-1.0, 1.0));
        matrix += row * row.transpose();
        gradient += row * rng.uniform(-1.0, 1.0);
    }
    (matrix, gradient)
}

fn solution<T: Scalar>(
    matrix: &SMatrix<f64, N, N>,
    damping: f64,
    gradient: &SVector<f64, N>,
) -> SVector<f64, N> {
    let matrix = matrix.map(T::lit);
    let apply = |way: &[T], image: &mut [T]| {
        let way = SVector::<T, N>::from_column_slice(way);
        let product = matrix * way;
        image.copy_from_slice(product.as_slice());
        product.dot(&way)
    };
    let gradient: [T; N] = gradient.map(T::lit).into();
    let [mut step, mut rest, mut way, mut image] = [[T::lit(7.0); N]; 4];
    let scratch = [&mut rest[..], &mut way[..], &mut image[..]];
    conjugate_gradients::solve(apply, T::lit(damping), &gradient, &mut step, scratch);
    SVector::from(step.map(T::to_f64))
}

fn reduces_the_model_nearly_the_most<T: Scalar>() {
    for seed in 0..200 {
        let rows = 1 + usize::try_from(seed).unwrap() % (N - 1);
        let (matrix, gradient) = equations(rows, seed);
        for damping in [1e-3, 1.0] {
            let step = solution::<T>(&matrix, damping, &gradient);
            let damped = matrix + SMatrix::identity() * damping;
            let promise = |d: &SVector<f64, N>| -gradient.dot(d) - 0.5 * d.dot(&(damped * d));
            let best = promise(&damped.cholesky().unwrap().solve(&-gradient));
            let part = promise(&step) / best;
            assert!(
                (0.9..=1.0 + 1e-5).contains(&part),
                "{seed} {damping}: {part}"
            );
            // The step has no part in the null space, which holds the infinitesimal motions.
            let svd = matrix.symmetric_eigen();
            for (value, vector) in svd.eigenvalues.iter().zip(svd.eigenvectors.column_iter()) {
                if value.abs() < 1e-10 {
                    let along = vector.dot(&step).abs();
                    let rounding = 1e3 * T::EPSILON.to_f64() * step.norm();
                    assert!(along <= rounding, "{seed} {damping}: {along:e}");
                }
            }
        }
    }
}

#[test]
fn an_inexact_step_reduces_the_model_nearly_the_most() {
    reduces_the_model_nearly_the_most::<f32>();
    reduces_the_model_nearly_the_most::<f64>();
}

#[test]
fn where_nothing_is_open_nothing_moves() {
    let (matrix, _) = equations(3, 1);
    let step = solution::<f64>(&matrix, 0.0, &SVector::zeros());
    assert_eq!(step, SVector::<f64, N>::zeros());
}

#[test]
fn what_is_no_number_is_not_propagated() {
    let (matrix, gradient) = equations(3, 2);
    let step = solution::<f64>(&(matrix * f64::NAN), 1.0, &gradient);
    assert_eq!(step, SVector::<f64, N>::zeros());
}
