//! Generates the waterbomb tessellation on the report's grid.

use super::grid::{Grid, point};
use super::{ParameterError, check_fold, check_sizes};
use crate::pattern::Drawing;

/// The waterbomb tessellation on `rows` x `columns` unit squares. It consists of units of 2x2 squares; neighbouring
/// columns of units are shifted by one square. Every grid point is a vertex, including those of degree 2 on the sides
/// of units.
///
/// As in [XiLien2015](crate#references), the first number counts the squares round the tube that the sheet folds to:
/// rows follow each other along x, columns along y.
///
/// The symmetric motion has one parameter t and four crease groups: middle lines m = 2 atan t, cross lines
/// r = 2 atan 2t, diagonals d = -2 atan √2 t (the only mountains), and boundary lines b = 2r - m, which turn most.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Waterbomb {
    /// Squares along x, round the tube.
    pub rows: usize,
    /// Squares along y, along the tube.
    pub columns: usize,
    /// Goal: fold angle of the boundary lines as a fraction of a half turn.
    pub fold: f64,
}

impl Waterbomb {
    /// Returns the pattern with its goal.
    ///
    /// # Errors
    /// If a parameter is out of its range.
    pub fn drawing(&self) -> Result<Drawing, ParameterError> {
        check_sizes(self.rows, self.columns, 2)?;
        check_fold(self.fold)?;
        let [middle, cross, diagonal, boundary] = Self::angles(self.fold * core::f64::consts::PI);
        let (columns, rows) = (self.rows, self.columns);
        let mut grid = Grid::new(columns, rows, point);
        // The band of units over rows 2k and 2k + 1 starts at an odd column if k is odd.
        let at_unit_side = |column: usize, row: usize| (column + row / 2).is_multiple_of(2);
        for row in 0..=rows {
            for column in 0..=columns {
                if row < rows {
                    let up = (column, row + 1);
                    let angle = if at_unit_side(column, row) {
                        boundary
                    } else {
                        middle
                    };
                    grid.join((column, row), up, false, angle);
                }
                let side = row == 0 || row == rows;
                if column < columns && (row % 2 == 0 || side) {
                    grid.join((column, row), (column + 1, row), false, cross);
                }
                if column < columns && row < rows {
                    // The diagonal leads towards the centre of the unit, which is halfway up the band.
                    let rises = at_unit_side(column, row) == (row % 2 == 0);
                    grid.join_diagonal((column, row), rises, diagonal);
                }
            }
        }
        Ok(grid.into_drawing())
    }

    /// Returns the fold angles (radians) of middle lines, cross lines, diagonals and boundary lines if the boundary lines
    /// have `boundary` (radians, 0 to π).
    #[must_use]
    pub fn angles(boundary: f64) -> [f64; 4] {
        // 4t³ + 3t = tan(b/2) is solved by the hyperbolic form of the triple angle, 4 sinh³ x + 3 sinh x = sinh 3x.
        let t = ((boundary / 2.0).tan().asinh() / 3.0).sinh();
        let diagonal = -2.0 * (core::f64::consts::SQRT_2 * t).atan();
        [2.0 * t.atan(), 2.0 * (2.0 * t).atan(), diagonal, boundary]
    }
}
