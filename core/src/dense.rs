//! Dense normal equations with an LDLᵀ factor over borrowed memory, for the few unknowns that symmetry leaves.

use nalgebra::Vector3;

use crate::least_squares::{Accumulate, Gradient, NormalEquations};
use crate::{Scalar, Spoke, ldl};

/// Largest number of unknowns for which the columns of each unknown are summed before they are multiplied: with few
/// crease groups, a star has several spokes of one group.
const MAX_SUMMED_UNKNOWNS: usize = 4;

/// JᵀJ and Jᵀr as a dense lower triangle, with the factors of JᵀJ + λI.
#[derive(Debug)]
pub struct DenseNormalEquations<'a, T> {
    matrix: &'a mut [T],
    factor: &'a mut [T],
    gradient: &'a mut [T],
}

impl<'a, T: Scalar> DenseNormalEquations<'a, T> {
    /// Returns the length of `memory` that [`new`](Self::new) needs for `unknowns` unknowns: 2n² + n.
    #[must_use]
    pub const fn memory(unknowns: usize) -> usize {
        2 * unknowns * unknowns + unknowns
    }

    /// Creates equations in `unknowns` unknowns over borrowed memory; `None` if `memory` is too small.
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

    /// Adds the rows of a star, with the columns of each unknown summed before they are multiplied.
    fn add_summed(&mut self, spokes: &[Spoke<T>], columns: &[Vector3<T>], residual: &Vector3<T>) {
        let mut sums = [Vector3::repeat(T::zero()); MAX_SUMMED_UNKNOWNS];
        for (spoke, column) in spokes.iter().zip(columns) {
            if let Some(sum) = sums.get_mut(spoke.group.index()) {
                *sum += column;
            }
        }
        let n = self.gradient.len();
        let rows = self.matrix.chunks_exact_mut(n.max(1));
        for ((sum, slope), row) in sums.iter().zip(&mut *self.gradient).zip(rows) {
            *slope += sum.dot(residual);
            for (entry, other) in row.iter_mut().zip(&sums) {
                *entry += sum.dot(other);
            }
        }
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
        let n = self.gradient.len();
        if n <= MAX_SUMMED_UNKNOWNS {
            return self.add_summed(spokes, columns, residual);
        }
        Gradient(self.gradient).add(star, spokes, columns, residual);
        for (spoke, column) in spokes.iter().zip(columns) {
            let (start, diagonal) = (spoke.group.index() * n, spoke.group.index() * (n + 1));
            let Some(row) = self.matrix.get_mut(start..=diagonal) else {
                continue;
            };
            for (other, other_column) in spokes.iter().zip(columns) {
                // The row ends at the diagonal: entries right of it are not stored.
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

    fn max_diagonal(&mut self) -> T {
        let diagonal = self
            .matrix
            .iter()
            .step_by(self.gradient.len().saturating_add(1));
        diagonal.fold(T::zero(), |max, &entry| max.max(entry))
    }

    fn fix_unknown(&mut self, unknown: usize, by: T) -> T {
        let n = self.gradient.len();
        let (Some(&slope), Some(&curvature)) = (
            self.gradient.get(unknown),
            self.matrix.get(unknown * (n + 1)),
        ) else {
            return T::zero();
        };
        // The lower triangle holds the entries of this unknown in its row up to the diagonal, and in its column below.
        for (other, slope) in self.gradient.iter_mut().enumerate() {
            let place = unknown.max(other) * n + unknown.min(other);
            if let Some(entry) = self.matrix.get_mut(place) {
                *slope += *entry * by;
                *entry = T::zero();
            }
        }
        if let Some(slope) = self.gradient.get_mut(unknown) {
            *slope = T::zero();
        }
        by * (slope + T::HALF * curvature * by)
    }

    fn factorise(&mut self, damping: T) -> bool {
        for (factor, &entry) in self.factor.iter_mut().zip(&*self.matrix) {
            *factor = entry;
        }
        ldl::factorise(self.factor, self.gradient.len(), damping)
    }

    fn solve(&mut self, right_side: &mut [T]) {
        ldl::solve(self.factor, self.gradient.len(), right_side);
    }
}

/// Copies numbers one by one, as far as both slices go. `copy_from_slice` would bring a panic into the controller's image,
/// because the compiler cannot always prove that two slices have the same length.
#[inline]
pub(crate) fn copy<T: Copy>(from: &[T], to: &mut [T]) {
    for (to, &from) in to.iter_mut().zip(from) {
        *to = from;
    }
}

/// Returns the dot product of two vectors, up to the end of the shorter one.
#[inline]
pub(crate) fn dot<T: Scalar>(a: &[T], b: &[T]) -> T {
    a.iter().zip(b).fold(T::zero(), |sum, (&a, &b)| sum + a * b)
}
