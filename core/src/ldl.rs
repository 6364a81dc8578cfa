//! Dense LDLᵀ factorisation in place over borrowed memory: Cholesky without square roots, which a Cortex-M4F would
//! compute in software.

use crate::Scalar;
use crate::dense::dot;

/// Factorises A + λI = LDLᵀ in place; A is the lower triangle of `n` rows of `n` numbers.
///
/// L replaces the triangle; its diagonal of ones is not stored, and the diagonal holds the inverse of D. Entries above
/// the diagonal are not read. Returns `false` if A + λI is not positive definite in this precision.
#[inline]
pub(crate) fn factorise<T: Scalar>(matrix: &mut [T], n: usize, damping: T) -> bool {
    for i in 0..n {
        let Some((above, rest)) = matrix.split_at_mut_checked(i * n) else {
            return false;
        };
        let Some((left, right)) = rest.split_at_mut_checked(i) else {
            return false;
        };
        // Forward substitution for row i of LD.
        for (j, row) in above.chunks_exact(n.max(1)).enumerate() {
            if let Some((done, [entry, ..])) = left.split_at_mut_checked(j) {
                *entry -= dot(done, row);
            }
        }
        let Some(diagonal) = right.first_mut() else {
            return false;
        };
        let mut pivot = *diagonal + damping;
        for (entry, (j, row)) in left
            .iter_mut()
            .zip(above.chunks_exact(n.max(1)).enumerate())
        {
            if let Some(&inverse) = row.get(j) {
                let scaled = *entry * inverse;
                pivot -= *entry * scaled;
                *entry = scaled;
            }
        }
        if pivot.is_finite() && pivot > T::zero() {
            *diagonal = T::one() / pivot;
        } else {
            return false;
        }
    }
    true
}

/// Solves LDLᵀx = b in place, with the factors that [`factorise`] leaves.
#[inline]
pub(crate) fn solve<T: Scalar>(factor: &[T], n: usize, right_side: &mut [T]) {
    let rows = factor.chunks_exact(n.max(1)).enumerate();
    for (i, row) in rows.clone() {
        if let Some((done, [entry, ..])) = right_side.split_at_mut_checked(i) {
            *entry -= dot(done, row);
        }
    }
    for (entry, (i, row)) in right_side.iter_mut().zip(rows.clone()) {
        if let Some(&inverse) = row.get(i) {
            *entry *= inverse;
        }
    }
    // Back substitution by columns of L, so that this walks along stored rows too.
    for (i, row) in rows.rev() {
        if let Some((open, [solved, ..])) = right_side.split_at_mut_checked(i) {
            for (other, &factor) in open.iter_mut().zip(row) {
                *other -= factor * *solved;
            }
        }
    }
}
