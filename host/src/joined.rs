//! What hangs together: each item leads to one that stands for all it is joined to.

/// The one that stands for all those that `one` is joined to, with the way there made shorter.
pub(crate) fn root(roots: &mut [usize], one: usize) -> usize {
    let mut here = one;
    while roots[here] != here {
        roots[here] = roots[roots[here]];
        here = roots[here];
    }
    here
}

/// Joins two, and all that they are joined to.
pub(crate) fn join(roots: &mut [usize], pair: [usize; 2]) {
    let [a, b] = pair.map(|one| root(roots, one));
    roots[a] = b;
}

/// Whether two are joined.
pub(crate) fn are_joined(roots: &mut [usize], pair: [usize; 2]) -> bool {
    let [a, b] = pair.map(|one| root(roots, one));
    a == b
}
