//! Generates a quadrilateral tessellation that does not fold.

use nalgebra::Vector2;

use super::grid::{Grid, point};
use super::{ParameterError, check, check_sizes};
use crate::pattern::Drawing;

/// Quad, the case of [XiLien2015](crate#references) that is not rigidly foldable: `rows` x `columns` slender
/// parallelograms with one crease each along the long diagonal, in three crease groups, all valleys.
///
/// It cannot fold. Round a folded vertex the creases are the corners of a spherical polygon whose perimeter is that of
/// a great circle. If all creases turn the same way, this polygon is convex, and so it is a great circle or two halves
/// of great circles: at most two creases turn, and these continue each other. So with valleys alone at most one family
/// of creases leaves the flat sheet at any vertex, and a closed configuration with these letters differs from the goal
/// by at least the second largest goal angle, 0.21 radians, for a sheet of any size.
///
/// So the goal does not close. Yet its closure residual is only 0.0076, and the sheet tears nearly at right angles to
/// its edges, which are all almost parallel; that hardly changes their lengths. With all angles scaled from flat to the
/// goal, a 3x3 sheet deforms by less than 0.1 %, although gaps of 3.5 % show what edge lengths hide. The errors of all
/// vertices have the same direction, and a 24x24 sheet deforms by more than 400 %. The numbers for 3x3 and 24x24
/// are for the default goal, a fold of 0.0675.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Quad {
    /// Rows of parallelograms, along their long side.
    pub rows: usize,
    /// Columns of parallelograms, along their short side.
    pub columns: usize,
    /// Goal: fold angle of the diagonals as a fraction of a half turn.
    pub fold: f64,
}

impl Quad {
    /// Ratio of the long side to the short side.
    const LONG_SIDE_RATIO: f64 = 1.85;
    /// Angle between the sides, radians.
    const SHARP_RAD: f64 = 0.1;
    /// Goal angles of the short and the long sides, as fractions of that of the diagonals.
    const SHORT_FOLD_RATIO: f64 = 0.83;
    const LONG_FOLD_RATIO: f64 = 0.99;

    /// Returns the pattern with its goal.
    ///
    /// # Errors
    /// If a parameter is out of its range.
    pub fn drawing(&self) -> Result<Drawing, ParameterError> {
        check_sizes(self.rows, self.columns, 1)?;
        let small = "a fraction above 0 and at most 0.1";
        let is_small = (f64::MIN_POSITIVE..=0.1).contains(&self.fold);
        check(is_small, "fold", self.fold, small)?;
        let (sin, cos) = Self::SHARP_RAD.sin_cos();
        let long = Vector2::new(cos, sin) * Self::LONG_SIDE_RATIO;
        let mut grid = Grid::new(self.columns, self.rows, |column, row| {
            let cell = point(column, row);
            Vector2::new(cell.x, 0.0) + long * cell.y
        });
        let diagonal = self.fold * core::f64::consts::PI;
        for row in 0..=self.rows {
            for column in 0..=self.columns {
                let (right, up) = (column < self.columns, row < self.rows);
                if up {
                    let angle = diagonal * Self::LONG_FOLD_RATIO;
                    grid.join((column, row), (column, row + 1), false, angle);
                }
                if right {
                    let angle = diagonal * Self::SHORT_FOLD_RATIO;
                    grid.join((column, row), (column + 1, row), false, angle);
                }
                if right && up {
                    grid.join((column, row), (column + 1, row + 1), false, diagonal);
                }
            }
        }
        Ok(grid.into_drawing())
    }
}
