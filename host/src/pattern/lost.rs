//! Lines of a drawing that were left out because they end in the open.

use core::fmt;

/// Lines that are no part of the pattern, because no face lies between them.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LostLines {
    /// Number of lines, as split at vertices and crossings.
    pub count: usize,
    /// Length of the longest of them, in the drawing's units. Short lines are often what goes past another line.
    pub longest: f64,
    /// Place of the first end at which no other line ends, in the drawing's own coordinates.
    pub open_end: [f64; 2],
    /// Smallest tolerance found with which no line is lost, in the drawing's units. `None` if none was found.
    pub kept_by: Option<f64>,
}

impl fmt::Display for LostLines {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { count, longest, .. } = self;
        let [x, y] = self.open_end.map(rounded);
        write!(
            f,
            "lines that end in the open, without faces between, left out: {count}, up to {longest:.1e} long, the \
             first open end at ({x}, {y}); "
        )?;
        match self.kept_by {
            Some(tolerance) => write!(f, "a tolerance of {tolerance} keeps all lines"),
            None => f.write_str("no tolerance was found that keeps all lines"),
        }
    }
}

/// Rounds a coordinate to the seven digits that drawing programs write.
pub(crate) fn rounded(coordinate: f64) -> f64 {
    let text = format!("{coordinate:.6e}");
    text.parse().unwrap_or(coordinate)
}
