//! Cholesky factorisation of a sparse symmetric matrix, after Davis, Direct Methods for Sparse Linear Systems (2006),
//! chapter 4.
//!
//! The matrix A is permuted to P A Pᵀ = L Lᵀ by an approximate minimum degree ordering (Amestoy, Davis and Duff 1996),
//! which keeps L sparse. L is computed row by row. Row k of L is the solution of a triangular system with the rows
//! above it; its nonzeros are the nodes that lead to k in the elimination tree. These positions depend on the pattern of
//! A alone, so that they are found once for all factorisations.
//!
//! Blocks of columns (supernodes) are not worth their code here: an entry of L takes part in 5 to 60 operations on
//! sheets of up to 96 x 96 cells. No instruction is chosen at run time, so that the result has the same bits on every
//! machine.

use crate::progress::Watch;
use crate::util::csr::{Csr, group_by_key};

/// Number of multiplications after which a factorisation looks at the time: about 10 ms.
const OPERATIONS_PER_LOOK: usize = 10_000_000;

/// Pattern of L, with the places of the entries of A that each of its rows starts from.
pub(crate) struct Symbolic {
    /// The row and column of A that is eliminated at each position.
    order: Vec<u32>,
    /// For each position, the place in the values of A of its diagonal entry.
    diagonal: Vec<u32>,
    /// For each row of P A Pᵀ, the entries left of the diagonal.
    entries: Csr<Entry>,
    /// For each row of L, the columns left of the diagonal, each after all columns that it depends on.
    reach: Csr<u32>,
    /// For each column of L, the rows below the diagonal, from the top.
    columns: Csr<u32>,
}

/// An entry of the lower triangle of P A Pᵀ.
#[derive(Clone, Copy, Default)]
struct Entry {
    column: u32,
    /// Its place in the values of A.
    place: u32,
}

/// Values of L, with the workspace that computes them.
pub(crate) struct Factor {
    /// Entries below the diagonal, laid out as [`Symbolic::columns`].
    below: Vec<f64>,
    /// Reciprocals of the diagonal entries.
    reciprocals: Vec<f64>,
    /// The row that is being computed, or the right side that is being solved. Zero between factorisations.
    row: Vec<f64>,
    /// For each column, the place in `below` of its next entry.
    next: Vec<usize>,
}

impl Symbolic {
    /// Finds the ordering and the pattern of L for a matrix whose lower triangle is given by compressed sparse columns:
    /// column j has the rows `rows[column_ends[j]..column_ends[j + 1]]`, sorted, of which the first is j.
    ///
    /// Returns `None` if the matrix has too many entries to number them in 31 bits.
    pub(crate) fn new(column_ends: &[u32], rows: &[u32]) -> Option<Self> {
        let signed = |numbers: &[u32]| -> Option<Vec<i32>> {
            let numbers = numbers.iter().map(|&number| i32::try_from(number).ok());
            numbers.collect()
        };
        let n = column_ends.len().checked_sub(1)?;
        let (starts, signed_rows) = (signed(column_ends)?, signed(rows)?);
        let control = amd::Control::default();
        let ordering = amd::order(i32::try_from(n).ok()?, &starts, &signed_rows, &control);
        let (order, position, _) = ordering.ok()?;
        let unsigned = |numbers: Vec<i32>| -> Vec<u32> {
            numbers.into_iter().map(i32::unsigned_abs).collect()
        };
        let (order, position) = (unsigned(order), unsigned(position));

        let columns = column_ends.windows(2).zip(&position);
        let entries = columns.flat_map(|(range, &column)| {
            let places = range[0]..range[1];
            let position = &position;
            places.map(move |place| (position[rows[place as usize] as usize], column, place))
        });
        let below = entries.filter(|(row, column, _)| row != column);
        let below = below.map(|(row, column, place)| {
            let entry = Entry {
                column: row.min(column),
                place,
            };
            (row.max(column) as usize, entry)
        });
        let entries = group_by_key(n, below);
        let diagonal = order.iter().map(|&k| column_ends[k as usize]).collect();
        let reach = reach(&entries);
        let pairs = reach.iter().zip(0..).flat_map(|(columns, row)| {
            let columns = columns.iter();
            columns.map(move |&column| (column as usize, row))
        });
        let columns = group_by_key(n, pairs);
        Some(Self {
            order,
            diagonal,
            entries,
            reach,
            columns,
        })
    }

    /// Computes L for the matrix with these values plus `damping` times the identity. Returns `false` if the matrix is
    /// not positive definite to rounding or the `watch` is over; then the factor must not be used.
    pub(crate) fn factorise(
        &self,
        values: &[f64],
        damping: f64,
        factor: &mut Factor,
        watch: Watch<'_>,
    ) -> bool {
        if watch.is_over() {
            return false;
        }
        let Factor {
            below,
            reciprocals,
            row: x,
            next,
        } = factor;
        x.fill(0.0);
        for (column, next) in next.iter_mut().enumerate() {
            *next = self.columns.range(column).start;
        }
        let mut operations = 0;
        for k in 0..self.order.len() {
            if operations >= OPERATIONS_PER_LOOK {
                operations = 0;
                if watch.is_over() {
                    return false;
                }
            }
            for entry in &self.entries[k] {
                x[entry.column as usize] = values[entry.place as usize];
            }
            let mut pivot = values[self.diagonal[k] as usize] + damping;
            for &column in &self.reach[k] {
                let column = column as usize;
                let entry = core::mem::take(&mut x[column]) * reciprocals[column];
                let start = self.columns.range(column).start;
                let end = next[column];
                operations += end - start;
                let rows = &self.columns.items()[start..end];
                for (&row, above) in rows.iter().zip(&below[start..end]) {
                    x[row as usize] -= above * entry;
                }
                pivot -= entry * entry;
                below[end] = entry;
                next[column] = end + 1;
            }
            if pivot.is_nan() || pivot <= 0.0 {
                return false;
            }
            reciprocals[k] = 1.0 / pivot.sqrt();
        }
        true
    }

    /// Replaces the right side b by the solution x of A x = b.
    pub(crate) fn solve(&self, factor: &mut Factor, right_side: &mut [f64]) {
        let x = &mut factor.row;
        for (x, &k) in x.iter_mut().zip(&self.order) {
            *x = right_side[k as usize];
        }
        for column in 0..x.len() {
            let solved = x[column] * factor.reciprocals[column];
            x[column] = solved;
            let range = self.columns.range(column);
            for (&row, entry) in self.columns[column].iter().zip(&factor.below[range]) {
                x[row as usize] -= entry * solved;
            }
        }
        for column in (0..x.len()).rev() {
            let range = self.columns.range(column);
            let entries = self.columns[column].iter().zip(&factor.below[range]);
            let sum = entries
                .rev()
                .fold(0.0, |sum, (&row, entry)| sum + entry * x[row as usize]);
            x[column] = (x[column] - sum) * factor.reciprocals[column];
        }
        for (x, &k) in x.iter().zip(&self.order) {
            right_side[k as usize] = *x;
        }
    }
}

impl Factor {
    /// Makes memory for the factor of a matrix with this pattern.
    pub(crate) fn new(symbolic: &Symbolic) -> Self {
        let n = symbolic.order.len();
        Self {
            below: vec![0.0; symbolic.columns.items().len()],
            reciprocals: vec![0.0; n],
            row: vec![0.0; n],
            next: vec![0; n],
        }
    }
}

/// Returns, for each row of L, its columns left of the diagonal, each after all columns that it depends on: those of
/// the row of the matrix, and their ancestors in the elimination tree as far as the row.
fn reach(entries: &Csr<Entry>) -> Csr<u32> {
    const ROOT: u32 = u32::MAX;
    let n = entries.len();
    let mut parent = vec![ROOT; n];
    // The row that last reached each column.
    let mut reached = vec![ROOT; n];
    let mut reach = Csr::with_capacity(n, entries.items().len());
    let (mut path, mut paths) = (Vec::new(), Vec::new());
    for (entries, row) in entries.iter().zip(0..) {
        for entry in entries {
            let mut column = entry.column;
            while column != row && reached[column as usize] != row {
                reached[column as usize] = row;
                path.push(column);
                let parent = &mut parent[column as usize];
                if *parent == ROOT {
                    *parent = row;
                }
                column = *parent;
            }
            // A path ends at a column of an earlier path, which depends on it. From the last path to the first, and
            // each from its start, is therefore an order. It is kept from its end.
            paths.extend(path.drain(..).rev());
        }
        reach.push(paths.drain(..).rev());
    }
    reach
}

#[cfg(test)]
mod tests {
    use nalgebra::{DMatrix, DVector};
    use rand_pcg::Pcg64;
    use rand_pcg::rand_core::Rng;

    use super::*;
    use crate::progress::Progress;

    /// Makes a random symmetric matrix with about this many entries in a row, and a diagonal that makes it positive
    /// definite. Returns it as compressed sparse columns of the lower triangle, and dense.
    fn matrix(n: usize, in_row: usize, seed: u128) -> (Vec<u32>, Vec<u32>, Vec<f64>, DMatrix<f64>) {
        let mut random = Pcg64::new(seed, 1);
        let mut dense = DMatrix::zeros(n, n);
        for k in 0..n * in_row / 2 {
            let other = random.next_u32() as usize % n;
            let value = f64::from(random.next_u32()) / f64::from(u32::MAX) * 2.0 - 1.0;
            dense[(k % n, other)] = value;
            dense[(other, k % n)] = value;
        }
        for k in 0..n {
            dense[(k, k)] = 0.1 + dense.row(k).iter().map(|x| x.abs()).sum::<f64>();
        }
        let (mut ends, mut rows, mut values) = (vec![0], Vec::new(), Vec::new());
        for column in 0..n {
            for row in column..n {
                let value = dense[(row, column)];
                if value != 0.0 {
                    rows.push(u32::try_from(row).unwrap());
                    values.push(value);
                }
            }
            ends.push(u32::try_from(rows.len()).unwrap());
        }
        (ends, rows, values, dense)
    }

    #[test]
    fn solutions_are_those_of_a_dense_factorisation() {
        for (n, in_row) in [
            (0, 0),
            (1, 0),
            (7, 0),
            (7, 3),
            (60, 2),
            (60, 6),
            (40, 40),
            (300, 4),
        ] {
            let (ends, rows, values, dense) = matrix(n, in_row, 5);
            let symbolic = Symbolic::new(&ends, &rows).unwrap();
            let mut factor = Factor::new(&symbolic);
            // The second damping uses the memory of the first.
            for damping in [3.0, 0.0] {
                assert!(symbolic.factorise(&values, damping, &mut factor, Watch::default()));
                let right_side: Vec<f64> = (0..n).map(|k| 1.0 / (1.0 + k as f64)).collect();
                let mut solution = right_side.clone();
                symbolic.solve(&mut factor, &mut solution);
                let damped = &dense + DMatrix::identity(n, n) * damping;
                let expected = damped.cholesky().unwrap().solve(&DVector::from(right_side));
                let error = (DVector::from(solution) - expected).amax();
                assert!(error <= 1e-13, "{n} {in_row} {damping}: {error:e}");
            }
        }
    }

    #[test]
    fn a_matrix_that_is_not_positive_definite_is_refused() {
        let (ends, rows, mut values, _) = matrix(60, 4, 7);
        let symbolic = Symbolic::new(&ends, &rows).unwrap();
        let mut factor = Factor::new(&symbolic);
        assert!(symbolic.factorise(&values, 0.0, &mut factor, Watch::default()));
        let place = ends[20] as usize;
        let diagonal = core::mem::replace(&mut values[place], -1.0);
        assert!(!symbolic.factorise(&values, 0.0, &mut factor, Watch::default()));
        values[place] = f64::NAN;
        assert!(!symbolic.factorise(&values, 0.0, &mut factor, Watch::default()));
        // Neither does time that is up.
        let progress = Progress::new();
        progress.cancel();
        let over = Watch::new(&progress);
        assert!(!symbolic.factorise(&values, 0.0, &mut factor, over));
        // A failure leaves nothing behind that reaches the next factor.
        values[place] = diagonal;
        let mut solutions = [vec![1.0; 60], vec![1.0; 60]];
        assert!(symbolic.factorise(&values, 0.0, &mut factor, Watch::default()));
        symbolic.solve(&mut factor, &mut solutions[0]);
        let mut fresh = Factor::new(&symbolic);
        assert!(symbolic.factorise(&values, 0.0, &mut fresh, Watch::default()));
        symbolic.solve(&mut fresh, &mut solutions[1]);
        assert_eq!(solutions[0], solutions[1]);
    }
}
