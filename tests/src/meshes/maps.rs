//! Sheets with straight creases: parallel ones (rolls and pleats), and two crossing families (maps).

use core::f64::consts::PI;

use foldpath::pattern::Drawing;
use nalgebra::Vector2;

use super::{alternating, grid, spacings};
use crate::Random;

/// Draws a map of up to 4 x 4 panels. All pleats are folded flat; then the lines across them turn, through all layers,
/// by any angles of any signs, or stay flat.
///
/// If straight lines cross, neither of them can turn unless the other is flat or folded flat. The motion therefore has
/// to pass through bifurcations.
#[must_use]
pub fn map(random: &mut Random) -> Drawing {
    let [columns, rows] = [(); 2].map(|()| random.whole(2, 4));
    let (x, y) = (spacings(random, columns), spacings(random, rows));
    let column = |&x: &f64| y.iter().map(|&y| Vector2::new(x, y)).collect();
    let places: Vec<Vec<_>> = x.iter().map(column).collect();
    let across: Vec<f64> = y.iter().map(|_| across(random)).collect();
    let pleat = random.sign() * PI;
    grid(
        &places,
        |column, _| alternating(column) * pleat,
        |column, row| alternating(column) * across[row],
    )
}

/// Draws a strip of 3 to 6 panels. One kind is rolled up or pleated, with no panel folded quite onto its neighbour. In
/// the other kind each panel is narrower than the one before and the strip is rolled up flat, so that every panel has
/// to be folded after the narrower ones, over which it comes to lie.
#[must_use]
pub fn roll(random: &mut Random) -> Drawing {
    let columns = random.whole(3, 6);
    let (mut x, mut goals) = (
        spacings(random, columns),
        vec![random.sign() * PI; columns + 1],
    );
    if random.chance(0.5) {
        let wide_first = random.chance(0.5);
        let wider = |k: usize| 1.1_f64.powi(i32::try_from(k).unwrap_or(0));
        let width = |k: usize| wider(if wide_first { columns - k } else { k });
        x = (0..=columns).map(|k| (0..k).map(width).sum()).collect();
    } else {
        let pleated = random.chance(0.5);
        for goal in &mut goals {
            let sign = if pleated { random.sign() } else { 1.0 };
            *goal = sign * random.uniform(0.5, 3.1);
        }
    }
    let column = |&x: &f64| vec![Vector2::new(x, 0.0), Vector2::new(x, 1.0)];
    let places: Vec<Vec<_>> = x.iter().map(column).collect();
    grid(&places, |column, _| goals[column], |_, _| 0.0)
}

/// Draws a strip of three panels, the outer two wider than half of the middle one, folded onto it: one of them has to be
/// folded before the other.
#[must_use]
pub fn gate(random: &mut Random) -> Drawing {
    let widths = [(); 2].map(|()| random.uniform(0.55, 0.95));
    let lines = [0.0, widths[0], widths[0] + 1.0, widths[0] + 1.0 + widths[1]];
    let column = |&x: &f64| vec![Vector2::new(x, 0.0), Vector2::new(x, 1.0)];
    let places: Vec<Vec<_>> = lines.iter().map(column).collect();
    let side = random.sign() * PI;
    grid(&places, |_, _| side, |_, _| 0.0)
}

/// Draws the angle by which a line turns, radians.
fn across(random: &mut Random) -> f64 {
    if random.chance(0.2) {
        0.0
    } else {
        random.sign() * random.uniform(0.1, 2.5)
    }
}
