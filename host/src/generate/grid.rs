//! Builds drawings whose vertices form a grid.

use nalgebra::Vector2;

use crate::pattern::{Drawing, DrawnEdge, Letter};

/// A drawing under construction with (columns + 1) x (rows + 1) vertices.
pub(super) struct Grid {
    columns: usize,
    rows: usize,
    drawing: Drawing,
}

impl Grid {
    /// Makes the vertices, row after row, at the points that `place` gives for (column, row).
    pub(super) fn new(
        columns: usize,
        rows: usize,
        place: impl Fn(usize, usize) -> Vector2<f64>,
    ) -> Self {
        let places = (0..=rows).flat_map(|row| (0..=columns).map(move |column| (column, row)));
        Self {
            columns,
            rows,
            drawing: Drawing {
                vertices: places.map(|(column, row)| place(column, row)).collect(),
                ..Drawing::default()
            },
        }
    }

    /// Joins two vertices (column, row) by a crease whose goal fold angle has the given size in radians; `mountain`
    /// selects its letter. If both vertices lie on the same side of the grid, joins them by a boundary.
    pub(super) fn join(
        &mut self,
        from: (usize, usize),
        to: (usize, usize),
        mountain: bool,
        fold_angle: f64,
    ) {
        let on_side = |a: usize, b: usize, last: usize| a == b && (a == 0 || a == last);
        let boundary = on_side(from.0, to.0, self.columns) || on_side(from.1, to.1, self.rows);
        let (letter, goal) = match (boundary, mountain) {
            (true, _) => (Letter::Boundary, None),
            (false, true) => (Letter::Mountain, Some(-fold_angle.abs())),
            (false, false) => (Letter::Valley, Some(fold_angle.abs())),
        };
        let index = |(column, row)| row * (self.columns + 1) + column;
        self.drawing.edges.push(DrawnEdge {
            ends: [index(from), index(to)],
            letter,
            goal,
        });
    }

    /// Joins opposite corners of a cell (column, row) by a mountain. The mountain leads up to the right if it `rises`, and
    /// otherwise down.
    pub(super) fn join_diagonal(
        &mut self,
        (column, row): (usize, usize),
        rises: bool,
        fold_angle: f64,
    ) {
        let (from, to) = if rises {
            (row, row + 1)
        } else {
            (row + 1, row)
        };
        self.join((column, from), (column + 1, to), true, fold_angle);
    }

    pub(super) fn into_drawing(self) -> Drawing {
        self.drawing
    }
}

#[allow(
    clippy::cast_precision_loss,
    reason = "grids have at most thousands of rows"
)]
pub(super) fn point(x: usize, y: usize) -> Vector2<f64> {
    Vector2::new(x as f64, y as f64)
}
