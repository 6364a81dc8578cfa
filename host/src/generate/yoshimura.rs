//! Generates the Yoshimura (diamond) pattern.

use super::grid::{Grid, point};
use super::{ParameterError, check_angle, check_fold, check_sizes};
use crate::pattern::Drawing;

/// The Yoshimura pattern on `rows` x `columns` cells, each with one diagonal. Straight valleys run along y, and
/// mountain diagonals form diamonds two cells wide and high. Cells are one unit wide; the angle between diagonals and
/// straight creases determines their height.
///
/// Let γ be the angle between straight creases and diagonals, v the fold angle of the straight creases, ψ = v/2 and
/// T = sin ψ tan γ. Then the fold angle d of the diagonals satisfies cos d = cos²ψ (1 - T²)/(1 + T²) - sin²ψ, and
/// neighbouring straight creases of one line enclose the angle π - 4 atan T.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Yoshimura {
    /// Rows of cells, along y.
    pub rows: usize,
    /// Columns of cells, along x.
    pub columns: usize,
    /// Angle γ between diagonals and straight creases, radians.
    pub angle: f64,
    /// Goal: fold angle of the straight creases as a fraction of a half turn.
    pub fold: f64,
}

impl Yoshimura {
    /// Returns the pattern with its goal.
    ///
    /// # Errors
    /// If a parameter is out of its range.
    pub fn drawing(&self) -> Result<Drawing, ParameterError> {
        check_sizes(self.rows, self.columns, 1)?;
        check_fold(self.fold)?;
        check_angle(self.angle)?;
        let height = 1.0 / self.angle.tan();
        let mut grid = Grid::new(self.columns, self.rows, |column, row| {
            let mut place = point(column, row);
            place.y *= height;
            place
        });
        let straight = self.fold * core::f64::consts::PI;
        let diagonal = self.diagonal(straight);
        for row in 0..=self.rows {
            for column in 0..=self.columns {
                if row < self.rows {
                    grid.join((column, row), (column, row + 1), false, straight);
                }
                if column < self.columns && (row == 0 || row == self.rows) {
                    grid.join((column, row), (column + 1, row), false, 0.0);
                }
                if column < self.columns && row < self.rows {
                    grid.join_diagonal((column, row), (column + row) % 2 == 0, diagonal);
                }
            }
        }
        Ok(grid.into_drawing())
    }

    /// Returns the fold angle of the diagonals (negative) if the straight creases have `straight` (radians).
    #[must_use]
    pub fn diagonal(&self, straight: f64) -> f64 {
        let (sin, cos) = (straight / 2.0).sin_cos();
        let t = sin * self.angle.tan();
        // The half-angle form of the cosine above keeps its digits near flat and near folded.
        let (s2, c2, t2) = (sin * sin, cos * cos, t * t);
        let (one_minus, one_plus) = (s2 + t2, c2);
        -2.0 * (one_minus / one_plus).sqrt().atan()
    }
}
