//! The motions that keep closure to first order: the null space of J, by inverse iteration on a block of vectors.
//!
//! Implements subspace iteration with Rayleigh-Ritz steps (Golub and Van Loan, "Matrix Computations", 4th edition, section 8.2)
//! on the inverse of JᵀJ + μ. The Ritz values are singular values of J times the block, so that they have the accuracy of J
//! rather than that of JᵀJ.

use nalgebra::{DMatrix, DVector};
use rand_pcg::Pcg64Mcg;
use rand_pcg::rand_core::Rng;

use super::conditions::{Blocks, Linearised, NormalFactor, times};

/// Number of vectors with which the search begins.
const FIRST_BLOCK: usize = 4;
/// Largest number of iterations for a block.
const MAX_ITERATIONS: usize = 12;
/// Relative change of the smallest regular Ritz value that ends the iteration.
const SETTLED_RATIO: f64 = 1e-6;
/// Seed of the first vectors.
const SEED: u128 = 60;

/// The null space of J and the smallest singular value outside of it.
pub(super) struct NullSpace {
    /// Orthonormal basis, a column for each vector.
    pub(super) basis: DMatrix<f64>,
    /// The smallest singular value above the tolerance; infinite if there is none.
    pub(super) next: f64,
    /// All singular values that were found, in ascending order: those of the null space, then a few more.
    pub(super) values: Vec<f64>,
}

impl NullSpace {
    /// Finds the null space: singular values up to `tolerance` count as 0.
    pub(super) fn find(
        linearised: &Linearised,
        factor: &mut NormalFactor<'_>,
        unknowns: usize,
        tolerance: f64,
    ) -> Self {
        let mut random = Pcg64Mcg::new(SEED);
        let mut size = FIRST_BLOCK.min(unknowns);
        loop {
            let mut block = DMatrix::from_fn(unknowns, size, |_, _| uniform(&mut random));
            let mut values = Vec::new();
            let mut before = f64::INFINITY;
            for _ in 0..MAX_ITERATIONS {
                factor.solve_columns(&mut block);
                (block, values) = ritz(&linearised.by_angle, block);
                let next = values.iter().copied().find(|value| *value > tolerance);
                let next = next.unwrap_or(f64::INFINITY);
                if (next - before).abs() <= SETTLED_RATIO * next {
                    break;
                }
                before = next;
            }
            let dimension = values
                .iter()
                .take_while(|value| **value <= tolerance)
                .count();
            if dimension == size && size < unknowns {
                size = (2 * size).min(unknowns);
                continue;
            }
            return Self {
                next: values.get(dimension).copied().unwrap_or(f64::INFINITY),
                basis: block.columns(0, dimension).into_owned(),
                values,
            };
        }
    }

    /// Returns the number of motions that keep closure.
    pub(super) fn dimension(&self) -> usize {
        self.basis.ncols()
    }

    /// Removes the part of a vector that lies in the null space.
    pub(super) fn project_out(&self, x: &mut [f64]) {
        let x = &mut nalgebra::DVectorViewMut::from_slice(x, x.len());
        let inside = self.basis.tr_mul(&*x);
        x.gemv(-1.0, &self.basis, &inside, 1.0);
    }

    /// Returns a random motion that keeps closure, whose largest component is 1.
    pub(super) fn random_motion(&self) -> DVector<f64> {
        let mut random = Pcg64Mcg::new(SEED + 1);
        let weights = DVector::from_fn(self.dimension(), |_, _| uniform(&mut random));
        let motion = &self.basis * weights;
        let most = motion.amax();
        motion / most.max(f64::MIN_POSITIVE)
    }
}

/// Returns a number between -1 and 1.
fn uniform(random: &mut Pcg64Mcg) -> f64 {
    let bits = f64::from(random.next_u32());
    bits / f64::from(u32::MAX) * 2.0 - 1.0
}

/// Returns orthonormal right singular vectors of J within the span of a block, with the singular values in ascending order.
fn ritz(by_angle: &Blocks, block: DMatrix<f64>) -> (DMatrix<f64>, Vec<f64>) {
    let orthonormal = block.qr().q();
    let rows = 3 * by_angle.len();
    let size = orthonormal.ncols();
    let mut product = DMatrix::zeros(rows.max(size), size);
    for (column, x) in orthonormal.column_iter().enumerate() {
        for (row, value) in times(by_angle, x.as_slice()).iter().flatten().enumerate() {
            product[(row, column)] = *value;
        }
    }
    let svd = product.qr().r().svd(false, true);
    let Some(v) = svd.v_t.map(|v_t| v_t.transpose()) else {
        return (orthonormal, vec![f64::NAN; size]);
    };
    let mut order: Vec<usize> = (0..size).collect();
    order.sort_by(|&a, &b| svd.singular_values[a].total_cmp(&svd.singular_values[b]));
    let v = v.select_columns(&order);
    let values = order.iter().map(|&k| svd.singular_values[k]).collect();
    (orthonormal * v, values)
}
