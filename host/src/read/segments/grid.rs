//! A uniform grid that finds the points and cells near a line.

use nalgebra::Vector2;

use crate::pattern::LARGEST;
use crate::util::csr::{Csr, group_by_key};
use crate::util::nan_max::bounding_box;

/// Square cells over the sheet. A line covers few of them.
pub(super) struct Grid {
    origin: Vector2<f64>,
    cell: f64,
    pub(super) columns: usize,
    pub(super) rows: usize,
}

impl Grid {
    /// Makes a grid over the points with about `count` cells, each at least `least` wide.
    #[allow(clippy::cast_precision_loss, reason = "a bound on work, not a result")]
    pub(super) fn new(points: &[Vector2<f64>], count: usize, least: f64) -> Self {
        let (low, high) = bounding_box(points.iter().copied()).unwrap_or_default();
        let size = high - low;
        let count = count.max(1) as f64;
        // The roots are taken one by one, because the product of the sizes might overflow.
        let cell = ((size.x / count).sqrt() * size.y.sqrt())
            .max((size.x + size.y) / count)
            .max(least)
            .max(1.0 / LARGEST);
        let mut grid = Self {
            origin: low,
            cell,
            columns: usize::MAX,
            rows: usize::MAX,
        };
        grid.columns = grid.step(size.x, usize::MAX) + 1;
        grid.rows = grid.step(size.y, usize::MAX) + 1;
        grid
    }

    /// Makes a grid with about one point in each cell, cells at least `least` wide, and returns the points in each
    /// cell.
    pub(super) fn of_points(points: &[Vector2<f64>], least: f64) -> (Self, Csr<usize>) {
        let grid = Self::new(points, points.len(), least);
        let cell_of = |point: &Vector2<f64>| {
            let from = point - grid.origin;
            grid.step(from.y, grid.rows) * grid.columns + grid.step(from.x, grid.columns)
        };
        let cells: Vec<_> = points.iter().map(cell_of).zip(0..).collect();
        let cells = group_by_key(grid.columns * grid.rows, &cells);
        (grid, cells)
    }

    fn step(&self, along: f64, cells: usize) -> usize {
        #[allow(
            clippy::cast_possible_truncation,
            clippy::cast_sign_loss,
            reason = "saturates, and is held to the grid"
        )]
        let step = (along / self.cell) as usize;
        step.min(cells - 1)
    }

    /// Calls `visit` once for each cell within `margin` of the line.
    pub(super) fn along(
        &self,
        [a, b]: [Vector2<f64>; 2],
        margin: f64,
        mut visit: impl FnMut(usize),
    ) {
        let (a, b) = (a - self.origin, b - self.origin);
        let along = b - a;
        let row = |y: f64| self.step(y, self.rows);
        let column = |x: f64| self.step(x, self.columns);
        for row in row(a.y.min(b.y) - margin)..=row(a.y.max(b.y) + margin) {
            #[allow(clippy::cast_precision_loss, reason = "rows are few")]
            let low = row as f64 * self.cell - margin;
            // The part of the line that lies in this row.
            let part = if along.y.abs() > 0.0 {
                [low, low + self.cell + 2.0 * margin].map(|y| ((y - a.y) / along.y).clamp(0.0, 1.0))
            } else {
                [0.0, 1.0]
            };
            let [p, q] = part.map(|t| a.x + t * along.x);
            // The rounding error of `part` is far below a hundredth of a cell.
            let margin = margin + 0.01 * self.cell;
            for column in column(p.min(q) - margin)..=column(p.max(q) + margin) {
                visit(row * self.columns + column);
            }
        }
    }
}
