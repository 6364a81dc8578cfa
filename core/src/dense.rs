//! Dense normal equations: Cholesky over borrowed memory, for the few unknowns that symmetry
//! leaves.

use nalgebra::Vector3;

use crate::least_squares::{Accumulate, Gradient, NormalEquations};
use crate::{Scalar, Spoke};

/// JᵀJ and Jᵀr as a dense lower triangle, with its Cholesky factor.
#[derive(Debug)]
pub struct DenseNormalEquations<'a, T> {
    matrix: &'a mut [T],
    factor: &'a mut [T],
    gradient: &'a mut [T],
}

impl<'a, T: Scalar> DenseNormalEquations<'a, T> {
    /// Length of `memory` that [`new`](Self::new) needs for `unknowns` unknowns: 2n² + n.
    #[must_use]
    pub const fn memory(unknowns: usize) -> usize {
        2 * unknowns * unknowns + unknowns
    }

    /// Equations in `unknowns` unknowns over borrowed memory; `None` if that is too small.
    pub fn new(unknowns: usize, memory: &'a mut [T]) -> Option<Self> {
        let square = unknowns.checked_mul(unknowns)?;
        let (matrix, rest) = memory.split_at_mut_checked(square)?;
        let (factor, rest) = rest.split_at_mut_checked(square)?;
        let gradient = rest.get_mut(..unknowns)?;
        Some(Self {
            matrix,
            factor,
            gradient,
        })
    }
}

impl<T: Scalar> Accumulate<T> for DenseNormalEquations<'_, T> {
    fn clear(&mut self) {
        self.matrix.fill(T::zero());
        self.gradient.fill(T::zero());
    }

    #[inline]
    fn add(
        &mut self,
        star: usize,
        spokes: &[Spoke<T>],
        columns: &[Vector3<T>],
        residual: &Vector3<T>,
    ) {
        Gradient(self.gradient).add(star, spokes, columns, residual);
        let n = self.gradient.len();
        for (spoke, column) in spokes.iter().zip(columns) {
            let (start, diagonal) = (spoke.group.index() * n, spoke.group.index() * (n + 1));
            let Some(row) = self.matrix.get_mut(start..=diagonal) else {
                continue;
            };
            for (other, other_column) in spokes.iter().zip(columns) {
                // Right of the diagonal the row ends.
                if let Some(entry) = row.get_mut(other.group.index()) {
                    *entry += column.dot(other_column);
                }
            }
        }
    }
}

impl<T: Scalar> NormalEquations<T> for DenseNormalEquations<'_, T> {
    fn unknowns(&self) -> usize {
        self.gradient.len()
    }

    fn gradient(&self) -> &[T] {
        self.gradient
    }

    fn max_diagonal(&self) -> T {
        let diagonal = self
            .matrix
            .iter()
            .step_by(self.gradient.len().saturating_add(1));
        diagonal.fold(T::zero(), |max, &entry| max.max(entry))
    }

    fn hold(&mut self, unknown: usize) {
        let n = self.gradient.len();
        let column = self.matrix.iter_mut().skip(unknown).step_by(n.max(1));
        column.for_each(|entry| *entry = T::zero());
        if let Some(row) = self.matrix.get_mut(unknown * n..(unknown + 1) * n) {
            row.fill(T::zero());
        }
        if let Some(slope) = self.gradient.get_mut(unknown) {
            *slope = T::zero();
        }
    }

    fn factorise(&mut self, damping: T) -> bool {
        let n = self.gradient.len();
        if n == 0 {
            return true;
        }
        for (factor, &entry) in self.factor.iter_mut().zip(&*self.matrix) {
            *factor = entry;
        }
        for i in 0..n {
            let Some((above, rest)) = self.factor.split_at_mut_checked(i * n) else {
                return false;
            };
            let Some((left, right)) = rest.split_at_mut_checked(i) else {
                return false;
            };
            // Forward substitution for row i of the factor, whose diagonal is stored inverted.
            for (j, row) in above.chunks_exact(n.max(1)).enumerate() {
                let Some((done, open)) = left.split_at_mut_checked(j) else {
                    return false;
                };
                if let (Some(entry), Some(&inverse)) = (open.first_mut(), row.get(j)) {
                    *entry = (*entry - dot(done, row)) * inverse;
                }
            }
            let Some(diagonal) = right.first_mut() else {
                return false;
            };
            let pivot = *diagonal + damping - dot(left, left);
            if pivot.is_finite() && pivot > T::zero() {
                *diagonal = T::one() / pivot.sqrt();
            } else {
                return false;
            }
        }
        true
    }

    fn solve(&mut self, right_side: &mut [T]) {
        let n = self.gradient.len();
        if n == 0 {
            return;
        }
        // L y = b, then Lᵀ x = y, the second by columns of L so that both walk along rows.
        for (i, row) in self.factor.chunks_exact(n.max(1)).enumerate() {
            if let Some((done, [entry, ..])) = right_side.split_at_mut_checked(i)
                && let Some(&inverse) = row.get(i)
            {
                *entry = (*entry - dot(done, row)) * inverse;
            }
        }
        for (i, row) in self.factor.chunks_exact(n.max(1)).enumerate().rev() {
            if let Some((open, [entry, ..])) = right_side.split_at_mut_checked(i)
                && let Some(&inverse) = row.get(i)
            {
                *entry *= inverse;
                let solved = *entry;
                for (other, &factor) in open.iter_mut().zip(row) {
                    *other -= factor * solved;
                }
            }
        }
    }
}

/// Product of two vectors as far as the shorter one reaches.
#[inline]
pub(crate) fn dot<T: Scalar>(a: &[T], b: &[T]) -> T {
    a.iter().zip(b).fold(T::zero(), |sum, (&a, &b)| sum + a * b)
}
