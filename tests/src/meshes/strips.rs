//! Miura-like sheets: strips of any height, each with a lean of its own, and columns of any width.

use foldpath::pattern::Drawing;
use nalgebra::Vector2;

use super::{alternating, first_good, grid, spacings, turns_well};
use crate::Random;

/// Draws straight creases along x and zigzag creases across them. All zigzag creases have the same shape. Strip j leans
/// by θ_j from +x.
///
/// All vertices of a line are alike, except that every other column swaps mountains and valleys. Between the zigzag
/// creases of strips j - 1 and j the straight creases turn by s to the right and by -s to the left. With the zigzag's
/// quaternion (cos u/2, sin u/2 (cos θ, sin θ, 0)), the product of the two rotations by s and the one by u has no part
/// along z. Two equations remain: sin(u_j/2) sin θ_j is equal for all strips, and s_j = φ_{j-1} - φ_j with tan φ =
/// tan(u/2) cos θ. The motion has one degree of freedom. The Miura fold is θ_j = α, π - α, α, ...
#[must_use]
pub fn strips(random: &mut Random) -> Drawing {
    first_good(random, |random| {
        let size = [random.whole(2, 6), random.whole(2, 7)];
        sheet(random, size)
    })
}

/// Draws such a sheet of 8 to 16 strips and columns.
#[must_use]
pub fn wide_strips(random: &mut Random) -> Drawing {
    first_good(random, |random| {
        let size = [random.whole(8, 16), random.whole(8, 16)];
        sheet(random, size)
    })
}

/// Returns a sheet with these numbers of strips and columns, if its creases turn neither too little nor too far.
fn sheet(random: &mut Random, [rows, columns]: [usize; 2]) -> Option<Drawing> {
    let lean: Vec<f64> = (0..rows)
        .map(|row| {
            let side = alternating(row) * if random.chance(0.85) { 1.0 } else { -1.0 };
            (90.0 - side * random.uniform(12.0, 50.0)).to_radians()
        })
        .collect();
    let flattest = lean.iter().map(|lean| lean.sin()).fold(1.0, f64::min);
    let drive = flattest * (random.uniform(20.0, 150.0).to_radians() / 2.0).sin();
    let zigzag: Vec<f64> = lean
        .iter()
        .map(|l| 2.0 * (drive / l.sin()).asin())
        .collect();
    let phi = |row: usize| ((zigzag[row] / 2.0).tan() * lean[row].cos()).atan();
    let (x, y) = (spacings(random, columns), spacings(random, rows));
    let mut shift = vec![0.0; rows + 1];
    for row in 0..rows {
        shift[row + 1] = shift[row] + (y[row + 1] - y[row]) / lean[row].tan();
    }
    let place = |column: usize, row: usize| Vector2::new(x[column] + shift[row], y[row]);
    let places: Vec<Vec<_>> = (0..=columns)
        .map(|column| (0..=rows).map(|row| place(column, row)).collect())
        .collect();
    let drawing = grid(
        &places,
        |column, row| alternating(column) * zigzag[row],
        |column, row| alternating(column) * (phi(row - 1) - phi(row)),
    );
    turns_well(&drawing).then_some(drawing)
}
