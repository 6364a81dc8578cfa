//! Lines of a drawing that pass near each other, as where they were meant to meet.

use core::fmt;

use super::lost::rounded;

/// Lines that pass near each other without a common vertex.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct NearLines {
    /// Number of vertices that lie near a line.
    pub count: usize,
    /// Distance of the nearest of them from its line, in the drawing's units.
    pub apart: f64,
    /// Its place, in the drawing's own coordinates.
    pub at: [f64; 2],
    /// A tolerance with which all of them meet their lines and no line becomes too short, in the drawing's units.
    /// `None` if none was found.
    pub joined_by: Option<f64>,
}

impl fmt::Display for NearLines {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { count, apart, .. } = self;
        let [x, y] = self.at.map(rounded);
        let places = if *count == 1 { "place" } else { "places" };
        write!(
            f,
            "lines that pass near each other without meeting: {count} {places}, the nearest {apart:.1e} apart at ({x}, \
             {y}); "
        )?;
        match self.joined_by {
            Some(tolerance) => write!(f, "a tolerance of {tolerance} joins them"),
            None => f.write_str("no tolerance was found that joins them"),
        }
    }
}
