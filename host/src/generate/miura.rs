//! Generates the Miura fold.

use super::grid::{Grid, point};
use super::{ParameterError, check_angle, check_fold, check_sizes};
use crate::pattern::Drawing;

/// The Miura fold of `rows` x `columns` parallelograms with unit sides. Straight creases run along x, zigzag creases
/// across them. The zigzag creases have the larger fold angle. With the sector angle α,
/// tan(straight/2) = cos α · tan(zigzag/2).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Miura {
    /// Rows of faces, along y.
    pub rows: usize,
    /// Columns of faces, along x.
    pub columns: usize,
    /// Acute angle of the parallelograms, radians.
    pub sector_angle: f64,
    /// Goal: fold angle of the zigzag creases as a fraction of a half turn.
    pub fold: f64,
}

impl Miura {
    /// Returns the pattern with its goal.
    ///
    /// # Errors
    /// If a parameter is out of its range.
    pub fn drawing(&self) -> Result<Drawing, ParameterError> {
        check_sizes(self.rows, self.columns, 1)?;
        check_fold(self.fold)?;
        check_angle(self.sector_angle)?;
        let (sin, cos) = self.sector_angle.sin_cos();
        let mut grid = Grid::new(self.columns, self.rows, |column, row| {
            let mut place = point(column, row);
            place.x += if row % 2 == 1 { cos } else { 0.0 };
            place.y *= sin;
            place
        });
        let zigzag = self.fold * core::f64::consts::PI;
        let straight = self.straight(zigzag);
        for row in 0..=self.rows {
            for column in 0..=self.columns {
                let mountain = column % 2 == 0;
                if row < self.rows {
                    grid.join((column, row), (column, row + 1), mountain, zigzag);
                }
                if column < self.columns {
                    // At a vertex where the zigzag bends towards +x, the acute sectors lie on that side, and the
                    // straight crease between them turns against the zigzag.
                    let against = row % 2 == 0;
                    let mountain = mountain ^ against;
                    grid.join((column, row), (column + 1, row), mountain, straight);
                }
            }
        }
        Ok(grid.into_drawing())
    }

    /// Returns the fold angle of the straight creases if the zigzag creases have `zigzag` (radians).
    #[must_use]
    pub fn straight(&self, zigzag: f64) -> f64 {
        2.0 * (self.sector_angle.cos() * (zigzag / 2.0).tan()).atan()
    }
}
