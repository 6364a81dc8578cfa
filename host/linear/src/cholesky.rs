//! Cholesky factorisation of a sparse symmetric matrix, after Davis, Direct Methods for Sparse Linear Systems (2006),
//! chapter 4.
//!
//! The matrix A is permuted to P A Pᵀ = L Lᵀ by an approximate minimum degree ordering (Amestoy, Davis and Duff 1996),
//! which keeps L sparse. L is computed row by row. Row k of L is the solution of a triangular system with the rows
//! above it; its nonzeros are the nodes that lead to k in the elimination tree. These positions depend on the pattern of
//! A alone, so that they are found once for all factorisations.
//!
//! The columns of a branch of the elimination tree depend on no column outside. If a factorisation takes long, several
//! branches are factorised at once, each with the parts of the rows beyond it that lie in the branch. The changes that
//! these parts make to the rest of their rows are summed up branch after branch, so that the factor has the same bits
//! for any number of threads. Source: J. W. H. Liu, "The multifrontal method for sparse matrix solution: theory and practice",
//! 1992, whose update matrices these are.
//!
//! Blocks of columns (supernodes) are not worth their code here: an entry of L takes part in 5 to 60 operations on
//! sheets of up to 96 x 96 cells. No instruction is chosen at run time, so that the result has the same bits on every
//! machine.

use core::ops::Range;
use core::time::Duration;

use crate::csr::{Csr, group_by_key};
use crate::elimination_tree::{EliminationTree, branches};
use crate::parallel;

/// Number of multiplications after which a factorisation looks at the time: about 10 ms.
const OPERATIONS_PER_LOOK: usize = 10_000_000;
/// Number of multiplications of a factorisation from which on its branches are factorised at once: about 2 ms.
const MIN_BRANCHED_OPERATIONS: u64 = 2_000_000;

/// Pattern of L, with the places of the entries of A that each of its rows starts from.
pub struct Symbolic {
    /// The row and column of A that is eliminated at each position.
    order: Vec<u32>,
    /// For each position, the place in the values of A of its diagonal entry.
    diagonal: Vec<u32>,
    /// For each row of P A Pᵀ, the entries left of the diagonal.
    entries: Csr<Entry>,
    /// For each row of L, the columns left of the diagonal, each after all columns that it depends on. Rows outside of
    /// the branches have them in ascending order, if there are branches.
    reach: Csr<u32>,
    /// For each column of L, the rows below the diagonal, from the top.
    columns: Csr<u32>,
    /// Branches of the elimination tree, from left to right, each a range of columns whose last is the root. None if a
    /// factorisation is short.
    branches: Vec<Range<usize>>,
    /// For each column `true` if it is in no branch.
    in_trunk: Vec<bool>,
    /// If there are branches, for each row outside of them, the columns of its reach that are outside of them, too.
    trunk: Option<Csr<u32>>,
}

/// Tells from time to time if a factorisation has to end.
struct Interrupt<'a> {
    /// Returns `true` once it has to end.
    is_over: &'a (dyn Fn() -> bool + Sync),
    /// Number of multiplications since this was asked.
    operations: usize,
}

/// The terms that a branch adds to the rows beyond it.
struct Update<'u> {
    /// The rows beyond the branch that its last column has entries in.
    rows: &'u [u32],
    /// Number of these rows that are computed.
    done: usize,
    /// Changes of the other rows: of the entries in the columns `rows`, row after row, each with the diagonal last.
    changes: &'u [f64],
}

/// The columns of a range, with the values of L in them.
struct Columns<'f> {
    first: usize,
    /// Place of the first entry of the range.
    start: usize,
    below: &'f mut [f64],
    reciprocals: &'f mut [f64],
    next: &'f mut [usize],
}

/// An entry of the lower triangle of P A Pᵀ.
#[derive(Clone, Copy, Default)]
struct Entry {
    column: u32,
    /// Its place in the values of A.
    place: u32,
}

/// Values of L, with the workspace that computes them.
pub struct Factor {
    /// Entries below the diagonal, laid out as [`Symbolic::columns`].
    below: Vec<f64>,
    /// Reciprocals of the diagonal entries.
    reciprocals: Vec<f64>,
    /// The row that is being computed, or the right sides that are being solved.
    row: Vec<f64>,
    /// For each column, the place in `below` of its next entry.
    next: Vec<usize>,
}

impl Symbolic {
    /// Finds the ordering and the pattern of L for a matrix whose lower triangle is given by compressed sparse columns:
    /// column j has the rows `rows[column_ends[j]..column_ends[j + 1]]`, sorted, of which the first is j.
    ///
    /// Returns `None` if the matrix has too many entries to number them in 31 bits.
    pub fn new(column_ends: &[u32], rows: &[u32]) -> Option<Self> {
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
        let matrix = (column_ends, rows);
        let short = Self::of_order(matrix, order, &position);
        let tree = EliminationTree::of(&short.columns);
        if tree.operations() < MIN_BRANCHED_OPERATIONS {
            return Some(short);
        }
        // Branches have to be ranges of columns.
        let after = tree.postorder();
        let mut renumbered = vec![0; n];
        for (number, &before) in (0..).zip(&after) {
            renumbered[before as usize] = number;
        }
        let order = after.iter().map(|&k| short.order[k as usize]).collect();
        let position: Vec<u32> = position.iter().map(|&k| renumbered[k as usize]).collect();
        let mut long = Self::of_order(matrix, order, &position);
        long.branch();
        Some(long)
    }

    /// Finds the pattern of L, given the order of elimination and the position of each row in it.
    fn of_order((column_ends, rows): (&[u32], &[u32]), order: Vec<u32>, position: &[u32]) -> Self {
        let n = order.len();
        let columns = column_ends.windows(2).zip(position);
        let entries = columns.flat_map(|(range, &column)| {
            let places = range[0]..range[1];
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
        Self {
            in_trunk: vec![true; n],
            order,
            diagonal,
            entries,
            reach,
            columns,
            branches: Vec::new(),
            trunk: None,
        }
    }

    /// Finds the branches of an order in which the columns of each branch follow each other.
    fn branch(&mut self) {
        self.branches = branches(&EliminationTree::of(&self.columns));
        for branch in &self.branches {
            self.in_trunk[branch.clone()].fill(false);
        }
        let mut trunk = Csr::default();
        for (row, &in_trunk) in self.in_trunk.iter().enumerate() {
            let columns = &mut self.reach[row];
            if in_trunk {
                columns.sort_unstable();
            }
            let columns = columns.iter().copied();
            trunk.push(columns.filter(|&column| in_trunk && self.in_trunk[column as usize]));
        }
        self.trunk = Some(trunk);
    }

    /// Computes L for the matrix with these values plus `damping` times the identity. Returns `false` if the matrix is
    /// not positive definite to rounding or `is_over` returns `true`; then the factor must not be used.
    #[must_use]
    pub fn factorise(
        &self,
        values: &[f64],
        damping: f64,
        factor: &mut Factor,
        is_over: &(dyn Fn() -> bool + Sync),
    ) -> bool {
        !is_over()
            && self
                .try_factorise(values, damping, factor, is_over)
                .is_some()
    }

    /// As [`factorise`](Self::factorise), with `None` for `false`.
    fn try_factorise(
        &self,
        values: &[f64],
        damping: f64,
        factor: &mut Factor,
        is_over: &(dyn Fn() -> bool + Sync),
    ) -> Option<()> {
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
        let mut all = Columns {
            first: 0,
            start: 0,
            below,
            reciprocals,
            next,
        };
        let mut parts = self.parts(&mut all);
        let changes = parallel::try_map_mut(&mut parts, Duration::MAX, |columns| {
            self.factorise_branch(values, damping, columns, Interrupt::new(is_over))
        })?;
        let updates = self.branches.iter().zip(&changes);
        let mut updates: Vec<_> = updates
            .map(|(branch, changes)| Update {
                rows: &self.columns[branch.end - 1],
                done: 0,
                changes,
            })
            .collect();
        let reach = self.trunk.as_ref().unwrap_or(&self.reach);
        let mut interrupt = Interrupt::new(is_over);
        for k in (0..self.order.len()).filter(|&k| self.in_trunk[k]) {
            self.start_row(k, values, x, |column| self.in_trunk[column]);
            let mut pivot = values[self.diagonal[k] as usize] + damping;
            for update in &mut updates {
                update.add_to_row(k, x, &mut pivot);
            }
            let operations = all.finish_row(self, k, &reach[k], x, pivot)?;
            interrupt.look_after(operations)?;
        }
        Some(())
    }

    /// Copies the entries of row `k` of P A Pᵀ in the columns `within` to `x`.
    fn start_row(&self, k: usize, values: &[f64], x: &mut [f64], within: impl Fn(usize) -> bool) {
        for entry in &self.entries[k] {
            let column = entry.column as usize;
            if within(column) {
                x[column] = values[entry.place as usize];
            }
        }
    }

    /// Returns the columns of each branch.
    fn parts<'f>(&self, all: &'f mut Columns<'_>) -> Vec<Columns<'f>> {
        let (mut below, mut reciprocals) = (&mut *all.below, &mut *all.reciprocals);
        let mut next = &mut *all.next;
        let (mut first, mut start) = (0, 0);
        let parts = self.branches.iter().map(|branch| {
            let entries =
                self.columns.range(branch.start).start..self.columns.range(branch.end - 1).end;
            let part = Columns {
                first: branch.start,
                start: entries.start,
                below: split_off(&mut below, start, &entries),
                reciprocals: split_off(&mut reciprocals, first, branch),
                next: split_off(&mut next, first, branch),
            };
            (first, start) = (branch.end, entries.end);
            part
        });
        parts.collect()
    }

    /// Factorises a branch and the parts of the rows beyond it that are in its columns. Returns the changes that these
    /// parts make to the rest of their rows, as [`Update::changes`]. Returns `None` if a pivot is not positive or the
    /// factorisation has to end.
    fn factorise_branch(
        &self,
        values: &[f64],
        damping: f64,
        columns: &mut Columns<'_>,
        mut interrupt: Interrupt<'_>,
    ) -> Option<Vec<f64>> {
        let branch = columns.first..columns.first + columns.next.len();
        let mut x = vec![0.0; self.order.len()];
        for k in branch.clone() {
            self.start_row(k, values, &mut x, |_| true);
            let pivot = values[self.diagonal[k] as usize] + damping;
            let operations = columns.finish_row(self, k, &self.reach[k], &mut x, pivot)?;
            interrupt.look_after(operations)?;
        }
        let rows = &self.columns[branch.end - 1];
        let mut changes = Vec::with_capacity(rows.len() * (rows.len() + 1) / 2);
        for (count, &k) in rows.iter().enumerate() {
            let k = k as usize;
            self.start_row(k, values, &mut x, |column| branch.contains(&column));
            let reach = &self.reach[k];
            let [from, to] = [branch.start, branch.end]
                .map(|end| reach.partition_point(|&column| (column as usize) < end));
            let mut pivot = 0.0;
            let operations = columns.eliminate(self, &reach[from..to], &mut x, &mut pivot);
            let taken = rows[..count]
                .iter()
                .map(|&row| core::mem::take(&mut x[row as usize]));
            changes.extend(taken);
            changes.push(pivot);
            interrupt.look_after(operations)?;
        }
        Some(changes)
    }

    /// Replaces the right side b by the solution x of A x = b.
    pub fn solve(&self, factor: &mut Factor, right_side: &mut [f64]) {
        let (right_side, _) = right_side.as_chunks_mut::<1>();
        self.solve_many(factor, right_side);
    }

    /// Replaces `N` right sides by their solutions, entry `k` of all of them being `right_sides[k]`. L is read once for all of
    /// them, which takes most of the time. Each solution has the bits of [`solve`](Self::solve).
    pub fn solve_many<const N: usize>(&self, factor: &mut Factor, right_sides: &mut [[f64; N]]) {
        let count = self.order.len();
        if factor.row.len() < N * count {
            factor.row.resize(N * count, 0.0);
        }
        let (x, _) = factor.row[..N * count].as_chunks_mut::<N>();
        for (x, &k) in x.iter_mut().zip(&self.order) {
            *x = right_sides[k as usize];
        }
        for column in 0..count {
            let reciprocal = factor.reciprocals[column];
            let solved = x[column].map(|x| x * reciprocal);
            x[column] = solved;
            let range = self.columns.range(column);
            for (&row, entry) in self.columns[column].iter().zip(&factor.below[range]) {
                for (x, solved) in x[row as usize].iter_mut().zip(solved) {
                    *x -= entry * solved;
                }
            }
        }
        for column in (0..count).rev() {
            let range = self.columns.range(column);
            let entries = self.columns[column].iter().zip(&factor.below[range]);
            let mut sums = [0.0; N];
            for (&row, entry) in entries.rev() {
                for (sum, x) in sums.iter_mut().zip(x[row as usize]) {
                    *sum += entry * x;
                }
            }
            for (x, sum) in x[column].iter_mut().zip(sums) {
                *x = (*x - sum) * factor.reciprocals[column];
            }
        }
        for (x, &k) in x.iter().zip(&self.order) {
            right_sides[k as usize] = *x;
        }
    }
}

impl<'a> Interrupt<'a> {
    fn new(is_over: &'a (dyn Fn() -> bool + Sync)) -> Self {
        Self {
            is_over,
            operations: 0,
        }
    }

    /// Counts multiplications. Returns `None` if the factorisation has to end.
    fn look_after(&mut self, operations: usize) -> Option<()> {
        self.operations += operations;
        if self.operations < OPERATIONS_PER_LOOK {
            return Some(());
        }
        self.operations = 0;
        (!(self.is_over)()).then_some(())
    }
}

impl Update<'_> {
    /// Adds the changes of row `k` to `x` and `pivot`, if this is the next row of the branch.
    fn add_to_row(&mut self, k: usize, x: &mut [f64], pivot: &mut f64) {
        if self
            .rows
            .get(self.done)
            .is_none_or(|&row| row as usize != k)
        {
            return;
        }
        let (here, rest) = self.changes.split_at(self.done + 1);
        for (&row, change) in self.rows[..self.done].iter().zip(here) {
            x[row as usize] += change;
        }
        *pivot += here[self.done];
        (self.done, self.changes) = (self.done + 1, rest);
    }
}

impl Columns<'_> {
    /// Computes row `k` of L from the row `x` of the rest of the matrix and its `pivot`. Returns the number of
    /// multiplications, or `None` if the pivot does not stay positive.
    fn finish_row(
        &mut self,
        symbolic: &Symbolic,
        k: usize,
        columns: &[u32],
        x: &mut [f64],
        mut pivot: f64,
    ) -> Option<usize> {
        let operations = self.eliminate(symbolic, columns, x, &mut pivot);
        self.reciprocals[k - self.first] = 1.0 / pivot.sqrt();
        (pivot > 0.0).then_some(operations)
    }

    /// Computes the next entries of L in these `columns`, from the row `x`, takes them out of the rest of `x`, and takes
    /// their squares from the `pivot`. Returns the number of multiplications.
    fn eliminate(
        &mut self,
        symbolic: &Symbolic,
        columns: &[u32],
        x: &mut [f64],
        pivot: &mut f64,
    ) -> usize {
        let mut operations = 0;
        for &column in columns {
            let column = column as usize;
            let local = column - self.first;
            let entry = core::mem::take(&mut x[column]) * self.reciprocals[local];
            let (start, end) = (symbolic.columns.range(column).start, self.next[local]);
            operations += end - start;
            let rows = &symbolic.columns.items()[start..end];
            let above = &self.below[start - self.start..end - self.start];
            for (&row, above) in rows.iter().zip(above) {
                x[row as usize] -= above * entry;
            }
            *pivot -= entry * entry;
            self.below[end - self.start] = entry;
            self.next[local] = end + 1;
        }
        operations
    }
}

/// Splits a range off the items that begin with number `first`, and keeps those behind it.
fn split_off<'f, T>(items: &mut &'f mut [T], first: usize, range: &Range<usize>) -> &'f mut [T] {
    let all = core::mem::take(items);
    let (_, all) = all.split_at_mut(range.start - first);
    let (part, rest) = all.split_at_mut(range.len());
    *items = rest;
    part
}

impl Factor {
    /// Makes memory for the factor of a matrix with this pattern.
    pub fn new(symbolic: &Symbolic) -> Self {
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
                assert!(symbolic.factorise(&values, damping, &mut factor, &|| false));
                let right_side: Vec<f64> = (0..n).map(|k| 1.0 / (1.0 + k as f64)).collect();
                let mut solution = right_side.clone();
                symbolic.solve(&mut factor, &mut solution);
                // Several at once have the same bits.
                let mut many: Vec<[f64; 3]> = right_side.iter().map(|b| [1.0, *b, -b]).collect();
                symbolic.solve_many(&mut factor, &mut many);
                assert!(
                    many.iter()
                        .zip(&solution)
                        .all(|(x, one)| x[1..] == [*one, -one])
                );
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
        assert!(symbolic.factorise(&values, 0.0, &mut factor, &|| false));
        let place = ends[20] as usize;
        let diagonal = core::mem::replace(&mut values[place], -1.0);
        assert!(!symbolic.factorise(&values, 0.0, &mut factor, &|| false));
        values[place] = f64::NAN;
        assert!(!symbolic.factorise(&values, 0.0, &mut factor, &|| false));
        // Neither does time that is up.
        assert!(!symbolic.factorise(&values, 0.0, &mut factor, &|| true));
        // A failure leaves nothing behind that reaches the next factor.
        values[place] = diagonal;
        let mut solutions = [vec![1.0; 60], vec![1.0; 60]];
        assert!(symbolic.factorise(&values, 0.0, &mut factor, &|| false));
        symbolic.solve(&mut factor, &mut solutions[0]);
        let mut fresh = Factor::new(&symbolic);
        assert!(symbolic.factorise(&values, 0.0, &mut fresh, &|| false));
        symbolic.solve(&mut fresh, &mut solutions[1]);
        assert_eq!(solutions[0], solutions[1]);
    }

    /// Makes the Laplacian of a square grid, plus a tenth of the identity, as compressed sparse columns.
    fn grid(size: u32) -> (Vec<u32>, Vec<u32>, Vec<f64>) {
        let (mut ends, mut rows, mut values) = (vec![0], Vec::new(), Vec::new());
        for column in 0..size * size {
            let right = (column % size + 1 < size).then_some(column + 1);
            let above = Some(column + size).filter(|&above| above < size * size);
            rows.push(column);
            values.push(4.1 + f64::from(column % 5));
            let others = [right, above].into_iter().flatten();
            for row in others {
                rows.push(row);
                values.push(-1.0);
            }
            ends.push(u32::try_from(rows.len()).unwrap());
        }
        (ends, rows, values)
    }

    #[test]
    fn branches_factorised_at_once_solve_the_system_with_the_same_bits_for_any_number_of_threads() {
        let (ends, rows, values) = grid(130);
        let symbolic = Symbolic::new(&ends, &rows).unwrap();
        assert!(symbolic.branches.len() >= 4, "{:?}", symbolic.branches);
        let n = ends.len() - 1;
        let right_side: Vec<f64> = (0..n).map(|k| 1.0 / (1.0 + k as f64)).collect();
        let solutions = [1, 2, 3].map(|threads| {
            let pool = rayon::ThreadPoolBuilder::new().num_threads(threads);
            pool.build().unwrap().install(|| {
                let mut factor = Factor::new(&symbolic);
                // The second factor uses the memory of the first.
                for damping in [2.0, 0.5] {
                    assert!(symbolic.factorise(&values, damping, &mut factor, &|| false));
                }
                let mut solution = right_side.clone();
                symbolic.solve(&mut factor, &mut solution);
                solution
            })
        });
        assert_eq!(solutions[0], solutions[1]);
        assert_eq!(solutions[0], solutions[2]);
        let mut image: Vec<f64> = solutions[0].iter().map(|x| 0.5 * x).collect();
        for column in 0..n {
            for place in ends[column] as usize..ends[column + 1] as usize {
                let row = rows[place] as usize;
                image[row] += values[place] * solutions[0][column];
                if row != column {
                    image[column] += values[place] * solutions[0][row];
                }
            }
        }
        let errors = image.iter().zip(&right_side).map(|(a, b)| (a - b).abs());
        let error = errors.fold(0.0, f64::max);
        assert!(error <= 1e-14, "{error:e}");
    }

    #[test]
    fn branches_that_are_not_positive_definite_are_refused() {
        let (ends, rows, mut values) = grid(130);
        let symbolic = Symbolic::new(&ends, &rows).unwrap();
        let mut factor = Factor::new(&symbolic);
        let trunk = (0..ends.len() - 1).find(|&k| symbolic.in_trunk[k]).unwrap();
        let first = symbolic.branches[0].start;
        for k in [first, trunk] {
            let place = symbolic.diagonal[k] as usize;
            let diagonal = core::mem::replace(&mut values[place], -9.0);
            assert!(!symbolic.factorise(&values, 0.0, &mut factor, &|| false));
            values[place] = diagonal;
            assert!(symbolic.factorise(&values, 0.0, &mut factor, &|| false));
        }
        assert!(!symbolic.factorise(&values, 0.0, &mut factor, &|| true));
    }
}
