//! Point location on the sheet: finds the vertex at a point, and tests if a point lies inside the sheet.

use nalgebra::Vector2;

use crate::pattern::{CreasePattern, VertexId};
use crate::util::csr::{Csr, group_by_key};
use crate::util::nan_max::bounding_box;

/// A uniform grid over the sheet with about one vertex in each cell.
pub(super) struct Places<'a> {
    pattern: &'a CreasePattern,
    tolerance: f64,
    low: Vector2<f64>,
    high: Vector2<f64>,
    /// Number of cells in a unit of length.
    per_length: f64,
    columns: usize,
    rows: usize,
    cells: Csr<VertexId>,
    /// For each row of the grid the edges of the border that reach into it, wider by the tolerance.
    border: Csr<[Vector2<f64>; 2]>,
}

impl<'a> Places<'a> {
    /// Makes the grid. Points within `tolerance` of each other count as equal.
    pub(super) fn new(pattern: &'a CreasePattern, tolerance: f64) -> Self {
        let vertices = pattern.vertices();
        let (low, high) = bounding_box(vertices.iter().copied()).unwrap_or_default();
        let extent = high - low;
        #[allow(clippy::cast_precision_loss, reason = "sizes a grid")]
        let count = vertices.len() as f64;
        let cell = (extent.x * extent.y / count)
            .sqrt()
            .max(extent.max() / count);
        let mut places = Self {
            pattern,
            tolerance,
            low,
            high,
            per_length: 1.0 / cell,
            columns: 0,
            rows: 0,
            cells: Csr::default(),
            border: Csr::default(),
        };
        places.columns = places.step(extent.x) + 1;
        places.rows = places.step(extent.y) + 1;
        let pairs: Vec<_> = vertices
            .iter()
            .enumerate()
            .map(|(index, v)| {
                let [column, row] = [v.x - low.x, v.y - low.y].map(|d| places.step(d));
                (row * places.columns + column, VertexId::new(index))
            })
            .collect();
        places.cells = group_by_key(places.columns * places.rows, &pairs);
        let open = pattern.edges().iter().filter(|e| e.inner_faces().is_none());
        let open = open.filter(|e| e.faces.iter().any(Option::is_some));
        let border: Vec<_> = open
            .map(|e| e.ends.map(|end| vertices[end.index()]))
            .flat_map(|[a, b]| {
                let [low, high] = [a.y.min(b.y) - tolerance, a.y.max(b.y) + tolerance];
                (places.row(low)..=places.row(high)).map(move |row| (row, [a, b]))
            })
            .collect();
        places.border = group_by_key(places.rows, &border);
        places
    }

    /// Returns the number of whole cells in a distance, which must not be negative.
    #[allow(
        clippy::cast_possible_truncation,
        clippy::cast_sign_loss,
        reason = "a small number that is not negative: the distance is within the sheet"
    )]
    fn step(&self, distance: f64) -> usize {
        (distance * self.per_length) as usize
    }

    /// Returns the row of the grid of an ordinate; rows beyond the sheet are the first or last.
    fn row(&self, y: f64) -> usize {
        self.step((y - self.low.y).max(0.0)).min(self.rows - 1)
    }

    /// Returns `true` if the point lies outside the sheet's bounding box.
    fn far(&self, point: Vector2<f64>) -> bool {
        let t = self.tolerance;
        (0..2).any(|k| point[k] < self.low[k] - t || point[k] > self.high[k] + t)
    }

    /// Returns the vertex at `point`, if there is one.
    pub(super) fn vertex_at(&self, point: Vector2<f64>) -> Option<VertexId> {
        self.vertex_within(point, self.tolerance)
    }

    /// Returns a vertex within `tolerance` of `point`, if there is one.
    pub(super) fn vertex_within(&self, point: Vector2<f64>, tolerance: f64) -> Option<VertexId> {
        if self.far(point) {
            return None;
        }
        let range = |k: usize, cells: usize| {
            let at = |d: f64| {
                self.step((point[k] + d - self.low[k]).max(0.0))
                    .min(cells - 1)
            };
            at(-tolerance)..=at(tolerance)
        };
        let near = |v: &VertexId| {
            (self.pattern.vertices()[v.index()] - point).norm_squared() <= tolerance * tolerance
        };
        let columns = range(0, self.columns);
        for row in range(1, self.rows) {
            for column in columns.clone() {
                let cell = &self.cells[row * self.columns + column];
                if let Some(vertex) = cell.iter().copied().find(near) {
                    return Some(vertex);
                }
            }
        }
        None
    }

    /// Returns `true` if `point` lies inside the sheet and not on its border (ray casting). Cost: linear in the
    /// border edges of a row of the grid.
    pub(super) fn is_inside(&self, point: Vector2<f64>) -> bool {
        if self.far(point) {
            return false;
        }
        let mut inside = false;
        for &[a, b] in &self.border[self.row(point.y)] {
            let (along, to) = (b - a, point - a);
            let s = (to.dot(&along) / along.norm_squared()).clamp(0.0, 1.0);
            if (to - along * s).norm() <= self.tolerance {
                return false;
            }
            // Counts the crossings of the border to the right of the point.
            if (a.y > point.y) != (b.y > point.y) && to.x < along.x * to.y / along.y {
                inside = !inside;
            }
        }
        inside
    }
}
