//! Enumerates the cells of a lattice of translations that are near each other, row by row, by solving a
//! quadratic inequality for each row.

use nalgebra::Vector3;

use super::motion::LatticeMotion;
use super::motion_bounds::LatticeMotionBounds;

/// The search for cells that may be near the cell at the origin while the steps are translations, or nearly so.
#[derive(Clone, Copy, Debug)]
pub(crate) struct NeighbourSearch {
    /// Translations of the two lattice steps in space.
    ways: [Vector3<f64>; 2],
    /// For each step, the largest displacement of a cell one step on from where the translation takes it.
    shifts: [f64; 2],
    /// Largest distance that counts as near.
    near: f64,
    /// Largest counts of both steps.
    most: [u32; 2],
}

impl NeighbourSearch {
    /// Creates the search for cells up to `most` steps on that may come within `near` of each other between two times
    /// of `bounds`; `motion` is folded to the first. Returns `None` if `near` is infinite, or if the steps turn by so
    /// much that translations say little.
    pub(crate) fn new(
        motion: &LatticeMotion,
        bounds: &LatticeMotionBounds,
        times: [usize; 2],
        near: f64,
        most: [u32; 2],
    ) -> Option<Self> {
        let drift = bounds.drift(times);
        let (ways, bent) = motion.ways(most);
        let radius = motion.radius();
        let slack = drift.turned + bent;
        (near.is_finite() && slack <= radius).then_some(Self {
            ways,
            shifts: drift.shifts,
            near: 2.0 * radius + near + drift.own + slack,
            most,
        })
    }

    /// Returns all counts i and j of steps with |i a + j b| - |i| s - |j| t ≤ near, one of [i, j] and [-i, -j],
    /// and perhaps a few more. Here a and b are the translations, s and t the shifts. Cost: O(number of them).
    ///
    /// In a row, for i of one sign, squaring both sides gives a quadratic inequality in i. If no real i satisfies it in
    /// one row, none does in the rows beyond: scaling i and j by a factor scales the left side by that factor.
    pub(crate) fn cells(&self) -> Vec<[i32; 2]> {
        let mut cells = Vec::new();
        let [columns, rows] = self
            .most
            .map(|most| i32::try_from(most).unwrap_or(i32::MAX));
        for row in 0..=rows {
            let ahead = self.columns(row, 1.0);
            let back = self.columns(row, -1.0);
            if ahead.is_none() && back.is_none() {
                break;
            }
            let counts = |ends: Option<[f64; 2]>| {
                let [from, to] = ends.unwrap_or([1.0, 0.0]);
                #[allow(clippy::cast_possible_truncation, reason = "saturates")]
                let [from, to] = [from.floor() as i32, to.ceil() as i32];
                from.max(0)..=to.min(columns)
            };
            cells.extend(counts(ahead).map(|column| [column, row]));
            let back = counts(back).filter(|&column| row > 0 && column > 0);
            cells.extend(back.map(|column| [-column, row]));
        }
        cells
    }

    /// Returns the first and the last real count of columns, taken in one direction, that may be near.
    fn columns(&self, row: i32, direction: f64) -> Option<[f64; 2]> {
        let [along, across] = [self.ways[0] * direction, self.ways[1] * f64::from(row)];
        let limit = self.near + self.shifts[1] * f64::from(row);
        let square = along.norm_squared() - self.shifts[0] * self.shifts[0];
        let linear = along.dot(&across) - limit * self.shifts[0];
        let constant = across.norm_squared() - limit * limit;
        if square <= 0.0 {
            return Some([0.0, f64::INFINITY]);
        }
        let discriminant = linear * linear - square * constant;
        let root = (discriminant >= 0.0).then(|| discriminant.sqrt())?;
        let ends = [-linear - root, -linear + root].map(|end| end / square);
        (ends[1] >= 0.0).then_some(ends)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use rand_pcg::Pcg64;
    use rand_pcg::rand_core::Rng;

    #[test]
    fn no_cell_that_is_near_is_left_out() {
        let mut random = Pcg64::new(5, 9);
        let mut uniform = move |low: f64, high: f64| {
            #[allow(clippy::cast_precision_loss, reason = "a random number")]
            let part = (random.next_u64() >> 11) as f64 / (1_u64 << 53) as f64;
            low + (high - low) * part
        };
        let (mut found, mut near) = (0, 0);
        for _ in 0..2000 {
            let size = 10_f64.powf(uniform(-1.5, 0.0));
            let mut way = || Vector3::from_fn(|_, _| uniform(-1.0, 1.0));
            let ways = [way() * size, way()];
            let search = NeighbourSearch {
                ways,
                shifts: [uniform(0.0, 0.3) * ways[0].norm(), uniform(0.0, 0.3)],
                near: uniform(0.2, 2.0),
                most: [12, 9],
            };
            let cells = search.cells();
            found += cells.len();
            for row in -9..=9_i32 {
                for column in -12..=12_i32 {
                    let [i, j] = [column, row].map(f64::from);
                    let off = i.abs() * search.shifts[0] + j.abs() * search.shifts[1];
                    let is_near = (ways[0] * i + ways[1] * j).norm() - off <= search.near;
                    let half = row > 0 || row == 0 && column >= 0;
                    near += usize::from(is_near && half);
                    let [i, j] = if half { [column, row] } else { [-column, -row] };
                    assert!(
                        !is_near || cells.contains(&[i, j]),
                        "{search:?} {column} {row}"
                    );
                }
            }
        }
        assert!(found < 3 * near, "{found} for {near}");
    }
}
