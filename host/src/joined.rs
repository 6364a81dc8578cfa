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
