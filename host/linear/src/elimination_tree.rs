//! The elimination tree of a sparse Cholesky factor, and the branches of it that can be factorised at once.
//!
//! The parent of a column is the first row below the diagonal that is not zero. A column depends on those below it in the
//! tree alone. Source: J. W. H. Liu, "The role of elimination trees in sparse factorization", 1990.

use core::ops::Range;

use crate::csr::Csr;

/// Number of equal parts of all operations, of which a branch has no more than one.
const MIN_PARTS: u64 = 12;
/// Ratio of the largest branch to the smallest that stands alone, in operations.
const LARGEST_TO_SMALLEST_RATIO: u64 = 8;

/// The elimination tree of a factor, and the operations that its columns take.
pub(crate) struct EliminationTree {
    /// For each column its parent; `None` for roots.
    parents: Vec<Option<usize>>,
    /// For each column, the number of multiplications that it and all columns below it in the tree take part in.
    operations: Vec<u64>,
    /// For each column, the number of columns below it in the tree, and itself.
    sizes: Vec<usize>,
}

impl EliminationTree {
    /// Finds the tree of a factor, given for each column the rows below the diagonal, from the top.
    pub(crate) fn of(columns: &Csr<u32>) -> Self {
        let parents = columns
            .iter()
            .map(|rows| rows.first().map(|&row| row as usize));
        let parents: Vec<Option<usize>> = parents.collect();
        let own = columns.iter().map(|rows| (rows.len() as u64).pow(2) / 2);
        let mut operations: Vec<u64> = own.collect();
        let mut sizes = vec![1; parents.len()];
        // Columns come before their parents.
        for (column, parent) in parents.iter().enumerate() {
            if let Some(parent) = *parent {
                operations[parent] += operations[column];
                sizes[parent] += sizes[column];
            }
        }
        Self {
            parents,
            operations,
            sizes,
        }
    }

    /// Returns the number of multiplications of a factorisation.
    pub(crate) fn operations(&self) -> u64 {
        self.roots().map(|root| self.operations[root]).sum()
    }

    fn roots(&self) -> impl Iterator<Item = usize> {
        let columns = self.parents.iter().enumerate();
        columns.filter_map(|(column, parent)| parent.is_none().then_some(column))
    }

    /// Returns the columns in an order in which those of each branch follow each other, children before parents.
    pub(crate) fn postorder(&self) -> Vec<u32> {
        // For each column the position at which the next column below it goes; the last entry is for roots.
        let roots = self.parents.len();
        let mut begins = vec![0; roots + 1];
        let numbers: Vec<u32> = (0..).take(roots).collect();
        let mut order = vec![0; roots];
        for (column, &number) in numbers.iter().enumerate().rev() {
            let size = self.sizes[column];
            let next = &mut begins[self.parents[column].unwrap_or(roots)];
            let begin = *next;
            *next += size;
            begins[column] = begin;
            order[begin + size - 1] = number;
        }
        order
    }
}

/// Returns branches that have no more than a part of all operations each, as ranges of columns from left to right. The
/// columns have to be in postorder.
pub(crate) fn branches(tree: &EliminationTree) -> Vec<Range<usize>> {
    let most = tree.operations() / MIN_PARTS;
    let mut branches = Vec::new();
    let mut end = tree.parents.len();
    // From the right, a column is followed by the last of its children.
    while let Some(column) = end.checked_sub(1) {
        if tree.operations[column] > most {
            end = column;
            continue;
        }
        let start = end - tree.sizes[column];
        if tree.operations[column] >= most / LARGEST_TO_SMALLEST_RATIO {
            branches.push(start..end);
        }
        end = start;
    }
    branches.reverse();
    branches
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn branches_follow_each_other_in_postorder() {
        // Two roots, 6 and 7; columns 0, 3 and 5 lead to 6, and 1, 2 and 4 to 7.
        let parents: [&[u32]; 8] = [&[3, 6], &[4], &[4, 7], &[5], &[7], &[6], &[], &[]];
        let tree = EliminationTree::of(&parents.iter().map(|rows| rows.to_vec()).collect());
        assert_eq!(tree.sizes, [1, 1, 1, 2, 3, 3, 4, 4]);
        let order = tree.postorder();
        let mut sorted = order.clone();
        sorted.sort_unstable();
        assert_eq!(sorted, [0, 1, 2, 3, 4, 5, 6, 7]);
        let position = |column: usize| order.iter().position(|&k| k as usize == column).unwrap();
        for (column, &size) in tree.sizes.iter().enumerate() {
            let end = position(column) + 1;
            for &below in &order[end - size..end] {
                let mut above = Some(below as usize);
                while above.is_some_and(|above| above != column) {
                    above = above.and_then(|above| tree.parents[above]);
                }
                assert_eq!(above, Some(column), "{below} below {column}");
            }
        }
    }
}
