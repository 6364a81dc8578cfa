//! Union-find: tells which items are connected, directly or through other items.
//!
//! Sets are joined without ranks, and paths are halved (R. Tarjan, J. van Leeuwen, "Worst-case analysis of set union
//! algorithms", J. ACM 31(2), 1984).

/// Disjoint sets of the items 0, 1, 2, ...
pub(crate) struct UnionFind {
    /// The parent of each item; the representative of a set is its own parent.
    parents: Vec<usize>,
}

impl UnionFind {
    /// Makes `count` sets of one item each.
    pub(crate) fn new(count: usize) -> Self {
        Self {
            parents: (0..count).collect(),
        }
    }

    /// Returns the representative of the set that contains `item`, halving the path to it.
    pub(crate) fn find(&mut self, item: usize) -> usize {
        let parents = &mut self.parents;
        let mut here = item;
        while parents[here] != here {
            parents[here] = parents[parents[here]];
            here = parents[here];
        }
        here
    }

    /// Joins the sets of two items. The representative of the second item's set becomes that of the joined set. Returns
    /// `true` if the items were in different sets.
    pub(crate) fn join(&mut self, pair: [usize; 2]) -> bool {
        let [a, b] = pair.map(|item| self.find(item));
        self.parents[a] = b;
        a != b
    }

    /// Joins the sets of two items. If all sets are joined by this function, the smallest item of each represents it.
    pub(crate) fn join_to_smaller(&mut self, pair: [usize; 2]) {
        let [a, b] = pair.map(|item| self.find(item));
        self.parents[a.max(b)] = a.min(b);
    }

    /// Returns `true` if two items are in the same set.
    pub(crate) fn are_joined(&mut self, [a, b]: [usize; 2]) -> bool {
        self.find(a) == self.find(b)
    }

    /// Returns the representative of each item's set.
    pub(crate) fn representatives(mut self) -> Vec<usize> {
        (0..self.parents.len())
            .map(|item| self.find(item))
            .collect()
    }
}
