//! Merges points that are within a tolerance of each other, in a hash grid.

use std::collections::{HashMap, HashSet};

use nalgebra::Vector2;

/// Distinct places: points within the tolerance of each other are one place.
#[derive(Default)]
pub(super) struct Places {
    pub(super) points: Vec<Vector2<f64>>,
    /// For each place the sum of the merged points, relative to the place, and their number.
    offsets: Vec<(Vector2<f64>, f64)>,
    cells: HashMap<[i64; 2], Vec<usize>>,
    /// Places at which no line ends any more.
    pub(super) retired: HashSet<usize>,
    origin: Vector2<f64>,
    pub(super) tolerance: f64,
}

impl Places {
    pub(super) fn new(tolerance: f64, origin: Vector2<f64>) -> Self {
        Self {
            origin,
            tolerance,
            ..Self::default()
        }
    }

    fn cell(&self, point: &Vector2<f64>) -> [i64; 2] {
        let scaled = (point - self.origin) / self.tolerance;
        #[allow(
            clippy::cast_possible_truncation,
            reason = "the tolerance keeps cells below 1e9 a side"
        )]
        let cell = |c: f64| c.floor() as i64;
        [cell(scaled.x), cell(scaled.y)]
    }

    /// Returns the place nearest to the point within the tolerance, if there is one; `but` is left out.
    fn near(&self, point: Vector2<f64>, but: Option<usize>) -> Option<usize> {
        let [x, y] = self.cell(&point);
        let mut nearest = (self.tolerance, None);
        for (dx, dy) in (-1..=1).flat_map(|dx| (-1..=1).map(move |dy| (dx, dy))) {
            let cell = [x.saturating_add(dx), y.saturating_add(dy)];
            let here = self.cells.get(&cell).into_iter().flatten();
            for &other in here.filter(|other| Some(**other) != but) {
                let distance = (self.points[other] - point).norm();
                let first = nearest.1.is_none();
                if distance < nearest.0 || (first && distance <= nearest.0) {
                    nearest = (distance, Some(other));
                }
            }
        }
        nearest.1
    }

    /// Returns the place nearest to the point, or a new place if none lies within the tolerance.
    pub(super) fn at(&mut self, point: Vector2<f64>) -> usize {
        if let Some(other) = self.near(point, None) {
            let offset = point - self.points[other];
            self.offsets[other].0 += offset;
            self.offsets[other].1 += 1.0;
            return other;
        }
        let new = self.points.len();
        self.points.push(point);
        self.offsets.push((Vector2::zeros(), 1.0));
        let cell = self.cell(&point);
        self.cells.entry(cell).or_default().push(new);
        new
    }

    /// Moves a place to the point and returns it. If another place lies within the tolerance of the point, retires the
    /// place and returns the other.
    pub(super) fn moved(&mut self, place: usize, point: Vector2<f64>) -> usize {
        if let Some(other) = self.near(point, Some(place)) {
            self.retire(place);
            return other;
        }
        self.leave_cell(place);
        self.points[place] = point;
        let cell = self.cell(&point);
        self.cells.entry(cell).or_default().push(place);
        place
    }

    /// Notes that no line ends at a place any more, so that no line is split there.
    pub(super) fn retire(&mut self, place: usize) {
        self.leave_cell(place);
        self.retired.insert(place);
    }

    fn leave_cell(&mut self, place: usize) {
        let cell = self.cell(&self.points[place]);
        if let Some(cell) = self.cells.get_mut(&cell) {
            cell.retain(|other| *other != place);
        }
    }

    /// Moves each place to the mean of the points merged into it, by at most one tolerance.
    pub(super) fn centre(&mut self) {
        for (point, (sum, count)) in self.points.iter_mut().zip(&self.offsets) {
            *point += sum / *count;
        }
        self.cells.clear();
        for index in 0..self.points.len() {
            let cell = self.cell(&self.points[index]);
            self.cells.entry(cell).or_default().push(index);
        }
    }
}
