//! Sparse matrices AᵀA that are sums over the blocks of rows of A.
//!
//! Two unknowns are coupled only if a block has both, so that each pair of entries of a block has a fixed place in the
//! matrix. The places and the elimination order are found once; all else is arithmetic.

use crate::cholesky::Symbolic;
use crate::csr::Csr;

/// Place of an entry above the diagonal, which is not stored.
const ABOVE: u32 = u32::MAX;

/// Sparse structure of a matrix AᵀA: the lower triangle in compressed sparse columns.
pub struct GramStructure {
    /// Place of the diagonal entry of each unknown: the first of its column.
    pub diagonal: Vec<u32>,
    /// Number of entries of the lower triangle.
    pub entries: usize,
    /// Elimination order and pattern of the Cholesky factor.
    pub symbolic: Symbolic,
    /// For each block, the places of the products of its entries, row after row.
    places: Csr<u32>,
}

impl GramStructure {
    /// Finds the structure for `n` unknowns, given the unknowns of each block's entries. Returns `None` if there are too
    /// many entries to number them in 31 bits.
    #[must_use]
    pub fn new(n: usize, blocks: &Csr<u32>) -> Option<Self> {
        // Column and row of each entry as one number, which is sorted faster.
        let entry = |column: u32, row: u32| u64::from(column) << 32 | u64::from(row);
        let mut entries: Vec<u64> = (0..u32::try_from(n).ok()?).map(|k| entry(k, k)).collect();
        for unknowns in blocks.iter() {
            for &a in unknowns {
                let below = unknowns.iter().filter(|&&b| b > a);
                entries.extend(below.map(|&b| entry(a, b)));
            }
        }
        entries.sort_unstable();
        entries.dedup();
        #[allow(clippy::cast_possible_truncation, reason = "the lower half")]
        let rows: Vec<u32> = entries.iter().map(|&entry| entry as u32).collect();
        let mut column_ends = vec![0; n + 1];
        for entry in entries {
            column_ends[(entry >> 32) as usize + 1] += 1;
        }
        for column in 0..n {
            column_ends[column + 1] += column_ends[column];
        }
        let place = |column: u32, row: u32| {
            if row < column {
                return None;
            }
            let range =
                column_ends[column as usize] as usize..column_ends[column as usize + 1] as usize;
            let offset = rows[range.clone()].binary_search(&row).ok()?;
            u32::try_from(range.start + offset).ok()
        };
        let places = blocks.iter().map(|unknowns| {
            let pairs = unknowns
                .iter()
                .flat_map(|a| unknowns.iter().map(move |b| (a, b)));
            let pairs = pairs.map(|(&a, &b)| place(b, a).unwrap_or(ABOVE));
            pairs.collect::<Vec<_>>()
        });
        Some(Self {
            places: places.collect(),
            diagonal: column_ends[..n].to_vec(),
            entries: rows.len(),
            symbolic: Symbolic::new(&column_ends, &rows)?,
        })
    }

    /// Adds a block to the matrix with these values. `product` multiplies two of the block's entries, such as two columns
    /// of three rows.
    pub fn add<T>(
        &self,
        block: usize,
        entries: &[T],
        product: impl Fn(&T, &T) -> f64,
        values: &mut [f64],
    ) {
        let pairs = entries
            .iter()
            .flat_map(|a| entries.iter().map(move |b| (a, b)));
        for ((a, b), &place) in pairs.zip(&self.places[block]) {
            if place != ABOVE {
                values[place as usize] += product(a, b);
            }
        }
    }

    /// Returns the largest diagonal entry of the matrix with these values, 0 if there is none.
    #[must_use]
    pub fn max_diagonal(&self, values: &[f64]) -> f64 {
        let diagonal = self.diagonal.iter().map(|&place| values[place as usize]);
        diagonal.fold(0.0, f64::max)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn blocks_add_up_to_the_lower_triangle() {
        // The second block has unknown 0 twice, as a star whose spokes share an unknown.
        let blocks: Csr<u32> = [vec![2, 0], vec![0, 1, 0]].into_iter().collect();
        let structure = GramStructure::new(3, &blocks).unwrap();
        let mut values = vec![0.0; structure.entries];
        for (block, entries) in [&[2.0, 3.0][..], &[1.0, 5.0, 7.0]].into_iter().enumerate() {
            structure.add(block, entries, |a, b| a * b, &mut values);
        }
        // Column after column: (0, 0), (1, 0), (2, 0), (1, 1), (2, 2).
        assert_eq!(values, [9.0 + 64.0, 40.0, 6.0, 25.0, 4.0]);
        assert_eq!(structure.diagonal, [0, 3, 4]);
        assert_eq!(structure.max_diagonal(&values).to_bits(), 73_f64.to_bits());
    }
}
