//! Union-find: tells which items are connected, directly or through other items.
//!
//! `roots` has one entry for each item, its parent; the representative of a set is its own parent. The caller begins
//! with every item as a set of its own, `roots[k] == k`. Sets are joined without ranks, and paths are halved
//! (R. Tarjan, J. van Leeuwen, "Worst-case analysis of set union algorithms", J. ACM 31(2), 1984).

/// Returns the representative of the set that contains `one`, halving the path to it.
pub(crate) fn root(roots: &mut [usize], one: usize) -> usize {
    let mut here = one;
    while roots[here] != here {
        roots[here] = roots[roots[here]];
        here = roots[here];
    }
    here
}

/// Joins the sets of two items. The representative of the second item's set becomes that of the joined set.
pub(crate) fn join(roots: &mut [usize], pair: [usize; 2]) {
    let [a, b] = pair.map(|one| root(roots, one));
    roots[a] = b;
}

/// Returns `true` if two items are in the same set.
pub(crate) fn are_joined(roots: &mut [usize], pair: [usize; 2]) -> bool {
    let [a, b] = pair.map(|one| root(roots, one));
    a == b
}
