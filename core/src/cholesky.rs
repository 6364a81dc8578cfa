//! Cholesky factors of small dense matrices, in place over borrowed memory.

use crate::Scalar;

/// Replaces the lower triangle of A, `n` rows of `n` numbers, by the factor L of A + λI = LLᵀ with its diagonal
/// inverted; `false` if that is not positive definite in this precision. What is above the diagonal is not looked at.
#[inline]
pub(crate) fn factorise<T: Scalar>(matrix: &mut [T], n: usize, damping: T) -> bool {
    for i in 0..n {
        let Some((above, rest)) = matrix.split_at_mut_checked(i * n) else {
            return false;
        };
        let Some((left, right)) = rest.split_at_mut_checked(i) else {
            return false;
        };
        // Forward substitution for row i of the factor.
        for (j, row) in above.chunks_exact(n).enumerate() {
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

/// Solves LLᵀx = b in place, L as [`factorise`] leaves it.
#[inline]
pub(crate) fn solve<T: Scalar>(factor: &[T], n: usize, right_side: &mut [T]) {
    // L y = b, then Lᵀ x = y, the second by columns of L so that both walk along rows.
    for (i, row) in factor.chunks_exact(n.max(1)).enumerate() {
        if let Some((done, [entry, ..])) = right_side.split_at_mut_checked(i)
            && let Some(&inverse) = row.get(i)
        {
            *entry = (*entry - dot(done, row)) * inverse;
        }
    }
    for (i, row) in factor.chunks_exact(n.max(1)).enumerate().rev() {
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

/// Product of two vectors as far as the shorter one reaches.
#[inline]
pub(crate) fn dot<T: Scalar>(a: &[T], b: &[T]) -> T {
    a.iter().zip(b).fold(T::zero(), |sum, (&a, &b)| sum + a * b)
}
