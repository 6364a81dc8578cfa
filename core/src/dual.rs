//! Normal equations in the space of the residuals, for sheets with more unknowns than residuals.
//!
//! With J the M x n Jacobian, (JᵀJ + λI)⁻¹Jᵀ = Jᵀ(JJᵀ + λI)⁻¹, so that a step needs a factor of M x M numbers only. A
//! vertex has three residuals, however many creases meet there.

use nalgebra::Vector3;

use crate::dense::dot;
use crate::least_squares::{Accumulate, NormalEquations, count};
use crate::{Scalar, Spoke, ldl};

/// Jᵀ and the factors of JJᵀ + λI for M residuals: three for each star, six for each loop.
#[derive(Debug)]
pub struct DualNormalEquations<'a, T, const M: usize> {
    /// Derivatives of the residuals by each unknown.
    columns: &'a mut [[T; M]],
    gradient: &'a mut [T],
    factor: [[T; M]; M],
    residuals: [T; M],
    added: usize,
    damping: T,
}

impl<'a, T: Scalar, const M: usize> DualNormalEquations<'a, T, M> {
    /// Creates equations in `unknowns` unknowns over borrowed memory, with one column and one entry of the gradient for
    /// each; `None` if that memory is too small.
    pub fn new(unknowns: usize, columns: &'a mut [[T; M]], gradient: &'a mut [T]) -> Option<Self> {
        Some(Self {
            columns: columns.get_mut(..unknowns)?,
            gradient: gradient.get_mut(..unknowns)?,
            factor: [[T::zero(); M]; M],
            residuals: [T::zero(); M],
            added: 0,
            damping: T::zero(),
        })
    }
}

impl<T: Scalar, const M: usize> Accumulate<T> for DualNormalEquations<'_, T, M> {
    fn clear(&mut self) {
        self.columns.fill([T::zero(); M]);
        self.gradient.fill(T::zero());
        self.added = 0;
    }

    #[inline]
    fn add(
        &mut self,
        _star: usize,
        spokes: &[Spoke<T>],
        columns: &[Vector3<T>],
        residual: &Vector3<T>,
    ) {
        let row = self.added;
        self.added += residual.len();
        if let Some(residuals) = three(&mut self.residuals, row) {
            *residuals = (*residual).into();
        }
        for (spoke, column) in spokes.iter().zip(columns) {
            let unknown = spoke.group.index();
            let sum = self.columns.get_mut(unknown);
            if let Some([x, y, z]) = sum.and_then(|sum| three(sum, row))
                && let Some(slope) = self.gradient.get_mut(unknown)
            {
                *x += column.x;
                *y += column.y;
                *z += column.z;
                *slope += column.dot(residual);
            }
        }
    }
}

impl<T: Scalar, const M: usize> NormalEquations<T> for DualNormalEquations<'_, T, M> {
    fn unknowns(&self) -> usize {
        self.gradient.len()
    }

    fn gradient(&self) -> &[T] {
        self.gradient
    }

    fn max_diagonal(&mut self) -> T {
        let squares = self.columns.iter().map(|column| dot(column, column));
        squares.fold(T::zero(), T::max)
    }

    fn fix_unknown(&mut self, unknown: usize, by: T) -> T {
        let Some(fixed) = self.columns.get_mut(unknown) else {
            return T::zero();
        };
        let fixed = core::mem::replace(fixed, [T::zero(); M]);
        for (residual, &derivative) in self.residuals.iter_mut().zip(&fixed) {
            *residual += derivative * by;
        }
        for (slope, column) in self.gradient.iter_mut().zip(&*self.columns) {
            *slope += dot(column, &fixed) * by;
        }
        let slope = self.gradient.get_mut(unknown);
        let slope = slope.map_or(T::zero(), |slope| core::mem::replace(slope, T::zero()));
        by * (slope + T::HALF * dot(&fixed, &fixed) * by)
    }

    /// Also returns `false` if there are more or fewer than M residuals.
    fn factorise(&mut self, damping: T) -> bool {
        self.damping = damping;
        self.factor = [[T::zero(); M]; M];
        for column in &*self.columns {
            for (i, (row, &a)) in self.factor.iter_mut().zip(column).enumerate() {
                for (entry, &b) in row.iter_mut().zip(column).take(i + 1) {
                    *entry += a * b;
                }
            }
        }
        self.added == M && ldl::factorise(self.factor.as_flattened_mut(), M, damping)
    }

    /// Evaluates r + J·step from the rows: the factor leaves more of the residuals that no unknown changes than of the
    /// others.
    fn residual_bound(&mut self, step: &[T], _models: [T; 2]) -> T {
        let mut residuals = self.residuals;
        let mut size = dot(&residuals, &residuals).sqrt();
        for (column, &step) in self.columns.iter().zip(step) {
            for (residual, &derivative) in residuals.iter_mut().zip(column) {
                *residual += derivative * step;
            }
            size += dot(column, column).sqrt() * step.abs();
        }
        let rounding = count::<T>(step.len()) * T::EPSILON * size;
        dot(&residuals, &residuals).sqrt() + rounding
    }

    fn step(&mut self, step: &mut [T]) {
        let mut residuals = self.residuals;
        ldl::solve(self.factor.as_flattened(), M, &mut residuals);
        for (step, column) in step.iter_mut().zip(&*self.columns) {
            *step = -dot(column, &residuals);
        }
    }

    /// Uses (JᵀJ + λI)⁻¹b = (b − Jᵀ(JJᵀ + λI)⁻¹Jb) / λ; the rounding error is ε‖b‖/λ.
    fn solve(&mut self, right_side: &mut [T]) {
        let mut sums = [T::zero(); M];
        for (column, &b) in self.columns.iter().zip(&*right_side) {
            for (sum, &derivative) in sums.iter_mut().zip(column) {
                *sum += derivative * b;
            }
        }
        ldl::solve(self.factor.as_flattened(), M, &mut sums);
        for (b, column) in right_side.iter_mut().zip(&*self.columns) {
            *b = (*b - dot(column, &sums)) / self.damping;
        }
    }
}

/// Returns three entries, from number `start` on.
fn three<T, const M: usize>(entries: &mut [T; M], start: usize) -> Option<&mut [T; 3]> {
    entries.get_mut(start..)?.first_chunk_mut()
}
