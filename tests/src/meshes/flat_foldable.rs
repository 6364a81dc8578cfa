//! Generalised Miura sheets: quadrilateral meshes without symmetry, with flat-foldable vertices of degree 4.

use foldpath::pattern::Drawing;
use nalgebra::{Matrix2, Vector2};

use super::{alternating, first_good, grid, heading, spacings, turns_well};
use crate::Random;

/// Length of the shortest edge.
const SHORTEST: f64 = 0.25;

/// Draws a mesh as in T. Tachi, "Generalization of rigid-foldable quadrilateral-mesh origami" (2009), vertex by vertex.
///
/// Round a flat-foldable vertex of degree 4 with the sectors s₁ (right to up) and s₂ (up to left), tan(right/2) = m
/// tan(up/2) with m = sin((s₁ - s₂)/2) / sin((s₁ + s₂)/2). Up and down turn by equal angles, left and right by opposite
/// ones. Therefore column i turns by tan(u_i/2) = ± y_i t and row j by ± x_j t all along the motion, and the sheet
/// folds with one degree of freedom if m = x_j / y_i at every vertex. Given the creases to the left and down,
/// flat-foldability gives s₁, and the equation gives tan(s₂/2) = tan(s₁/2) (1 - m)/(1 + m). The creases may start from
/// two sides of the sheet in any direction.
#[must_use]
pub fn flat_foldable(random: &mut Random) -> Drawing {
    first_good(random, |random| {
        let (rows, columns) = (random.whole(2, 6), random.whole(2, 7));
        let noise = random.log_uniform(0.003, 0.2);
        let lean = random.uniform(20.0, 50.0).to_radians();
        let (x, y) = (spacings(random, columns), spacings(random, rows));
        let y_of: Vec<f64> = (0..columns)
            .map(|_| 1.0 + random.uniform(-noise, noise))
            .collect();
        let mut x_of = vec![0.0; rows];

        let mut places = vec![vec![Vector2::zeros(); rows + 1]; columns + 1];
        let mut up = vec![vec![0.0; rows]; columns];
        let mut right = vec![vec![0.0; rows]; columns];
        for column in 0..=columns {
            places[column][0] = Vector2::new(x[column], 0.0);
        }
        for row in 0..rows {
            let shift = lean.tan() * (y[row + 1] - y[row]) * alternating(row);
            places[0][row + 1] = places[0][row] + Vector2::new(shift, y[row + 1] - y[row]);
        }
        for column in &mut up[1..] {
            column[0] = core::f64::consts::FRAC_PI_2 - lean + random.uniform(-noise, noise);
        }
        for direction in &mut right[0][1..] {
            *direction = random.uniform(-noise, noise);
        }
        for row in 1..rows {
            for column in 1..columns {
                let (left, down) = (right[column - 1][row], up[column][row - 1]);
                places[column][row] =
                    meet(places[column - 1][row], left, places[column][row - 1], down)?;
                // The sector from left to down is opposite to s₁. Both of its directions are turned by π, which does
                // not matter here.
                let s1 = core::f64::consts::PI - (down - left);
                if column == 1 {
                    x_of[row] = -s1.cos() * y_of[1] * (1.0 + random.uniform(-noise, noise));
                }
                let m = x_of[row] / y_of[column];
                if s1 <= 0.0 || m.abs() >= 1.0 {
                    return None;
                }
                let s2 = 2.0 * ((s1 / 2.0).tan() * (1.0 - m) / (1.0 + m)).atan();
                up[column][row] = left + core::f64::consts::PI - s2;
                right[column][row] = up[column][row] - s1;
            }
        }
        for column in 1..columns {
            let length = y[rows] - y[rows - 1];
            places[column][rows] =
                places[column][rows - 1] + heading(up[column][rows - 1]) * length;
        }
        for row in 1..rows {
            let length = x[columns] - x[columns - 1];
            places[columns][row] =
                places[columns - 1][row] + heading(right[columns - 1][row]) * length;
        }
        places[columns][rows] =
            places[columns][rows - 1] + places[columns - 1][rows] - places[columns - 1][rows - 1];

        let t = (random.uniform(30.0, 150.0).to_radians() / 2.0).tan();
        let drawing = grid(
            &places,
            |column, _| 2.0 * (t * y_of[column]).atan() * alternating(column),
            |column, row| 2.0 * (t * x_of[row]).atan() * alternating(column),
        );
        (convex(&places) && turns_well(&drawing)).then_some(drawing)
    })
}

/// Returns the point where the ray from `a` in the direction `along_a` meets the ray from `b`; `None` if the point is
/// not at least one shortest edge ahead of both.
fn meet(a: Vector2<f64>, along_a: f64, b: Vector2<f64>, along_b: f64) -> Option<Vector2<f64>> {
    let rays = Matrix2::from_columns(&[heading(along_a), -heading(along_b)]);
    let lengths = rays.lu().solve(&(b - a))?;
    (lengths.min() >= SHORTEST).then(|| a + heading(along_a) * lengths.x)
}

/// Returns `true` if all faces of the grid are convex, counter-clockwise and not too slim.
fn convex(places: &[Vec<Vector2<f64>>]) -> bool {
    let cells = places.windows(2).flat_map(|columns| {
        let rows = 0..columns[0].len() - 1;
        rows.map(|j| {
            [
                columns[0][j],
                columns[1][j],
                columns[1][j + 1],
                columns[0][j + 1],
            ]
        })
    });
    cells.into_iter().all(|cell| {
        (0..4).all(|k| {
            let (side, next) = (
                cell[(k + 1) % 4] - cell[k],
                cell[(k + 2) % 4] - cell[(k + 1) % 4],
            );
            let sine = side.perp(&next) / (side.norm() * next.norm());
            side.norm() >= SHORTEST && sine >= 0.2
        })
    })
}
