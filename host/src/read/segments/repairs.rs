//! Counts the repairs of a drawing and describes them in sentences.

/// Numbers of repairs of each kind, and the largest distances by which ends were moved.
#[derive(Default)]
pub(super) struct Repairs {
    pub(super) short: usize,
    pub(super) moved: usize,
    pub(super) farthest: f64,
    pub(super) crossings: usize,
    pub(super) passed: usize,
    pub(super) twice: usize,
    pub(super) both_ways: usize,
    pub(super) joined: usize,
    pub(super) far_joined: f64,
    pub(super) open: usize,
}

impl Repairs {
    pub(super) fn in_words(&self, tolerance: f64) -> Vec<String> {
        let &Self {
            short,
            moved,
            farthest,
            crossings,
            passed,
            twice,
            both_ways,
            joined,
            far_joined,
            open,
        } = self;
        let said = [
            (
                short,
                format!("lines shorter than the tolerance {tolerance:.3e} left out: {short}"),
            ),
            (
                moved,
                format!(
                    "ends of lines within the tolerance {tolerance:.3e} of each other joined: {moved}, \
                     moved by {farthest:.1e} at most"
                ),
            ),
            (
                crossings,
                format!("crossings without a vertex, both lines split there: {crossings}"),
            ),
            (
                passed,
                format!(
                    "lines that pass a vertex within the tolerance {tolerance:.3e} split there: {passed} \
                     places"
                ),
            ),
            (
                twice,
                format!(
                    "lines that lie on another left out: {twice} (kept is a cut before M or V, before \
                     U, before a border, before F)"
                ),
            ),
            (
                both_ways,
                format!("of them lettered M and V at one place, the first drawn kept: {both_ways}"),
            ),
            (
                joined,
                format!(
                    "open ends joined to the one vertex near them: {joined}, moved by {far_joined:.1e} at \
                     most"
                ),
            ),
            (
                open,
                format!("lines that end in the open, without faces between, left out: {open}"),
            ),
        ];
        let said = said.into_iter().filter(|(count, _)| *count > 0);
        said.map(|(_, words)| words).collect()
    }
}
