//! Finds the precision of coordinates from their digits.

use super::CreasePattern;

/// Number of significant digits from which on coordinates are exact to double precision.
const FULL_DIGITS: usize = 14;
/// Smallest number of significant digits of a rounded coordinate. Shorter numbers are meant as they are, unless they have
/// at least `MIN_BENT_DIGITS` and lines that nearly pass straight through a vertex show that they are rounded.
const MIN_DIGITS: usize = 5;
const MIN_BENT_DIGITS: usize = 3;
/// Sines of the least and the largest bend of a line that is meant to be straight.
const BENT_SINES: core::ops::Range<f64> = 1e-9..1e-3;
/// Denominator of binary fractions that are meant as they are, as on a grid.
const GRID_PER_UNIT: f64 = 1024.0;

impl CreasePattern {
    /// Returns the unit of the last digit of the largest coordinate, in the drawing's units, if coordinates are rounded;
    /// 0 if they have full precision.
    ///
    /// Coordinates are rounded if the longest of them has 5 to 13 significant digits, or 3 or 4 digits in a sheet in which
    /// some line is bent a little at a vertex, or if all of them are numbers of single precision. Whole numbers and
    /// fractions with a denominator of up to 1024 do not count, as those of a drawing on a grid. Cost: about 100 ns for each coordinate, until one is found that has full precision.
    #[must_use]
    pub fn coordinate_unit(&self) -> f64 {
        let coordinates = || self.vertices.iter().flat_map(|point| [point.x, point.y]);
        let largest = coordinates().fold(0.0, |most: f64, x| most.max(x.abs()));
        let uneven =
            || coordinates().filter(|x| x.is_finite() && (x * GRID_PER_UNIT).fract() != 0.0);
        let mut digits = 0;
        for x in uneven() {
            digits = digits.max(significant_digits(x));
            if digits >= FULL_DIGITS {
                break;
            }
        }
        if digits < MIN_BENT_DIGITS || digits < MIN_DIGITS && !self.has_bent_line() {
            return 0.0;
        }
        if digits < FULL_DIGITS {
            #[allow(
                clippy::cast_possible_truncation,
                reason = "a double has at most 309 digits"
            )]
            let before_point = largest.log10().floor() as i32 + 1;
            #[allow(
                clippy::cast_possible_truncation,
                clippy::cast_possible_wrap,
                reason = "below 14"
            )]
            let digits = digits as i32;
            return 10.0_f64.powi(before_point - digits);
        }
        #[allow(
            clippy::cast_possible_truncation,
            reason = "asks whether anything is lost"
        )]
        let is_single = |x: f64| f64::from(x as f32).to_bits() == x.to_bits();
        if uneven().all(is_single) {
            largest * f64::from(f32::EPSILON)
        } else {
            0.0
        }
    }

    /// Returns `true` if two edges pass nearly straight through a vertex, but not quite.
    fn has_bent_line(&self) -> bool {
        self.real_vertices().any(|vertex| {
            let star = &self.stars[vertex.index()];
            let directions = || star.iter().map(|&edge| self.direction(edge, vertex));
            directions().enumerate().any(|(index, a)| {
                let mut others = directions().skip(index + 1);
                others.any(|b| a.dot(&b) < 0.0 && BENT_SINES.contains(&a.perp(&b).abs()))
            })
        })
    }
}

/// Returns the number of significant digits of a number, of which the 16th and later ones count as noise of a program
/// that rounded it.
fn significant_digits(x: f64) -> usize {
    let written = format!("{x:.14e}");
    let mantissa = written.split('e').next().unwrap_or_default();
    let mantissa = mantissa.trim_end_matches('0');
    mantissa.bytes().filter(u8::is_ascii_digit).count()
}

#[cfg(test)]
mod tests {
    use nalgebra::Vector2;

    use crate::pattern::{CreasePattern, Drawing, DrawnEdge, Letter};

    /// Returns the unit of a triangle whose last corner has this place.
    fn unit(x: f64, y: f64) -> f64 {
        let edge = |ends| DrawnEdge {
            ends,
            letter: Letter::Boundary,
            goal: None,
        };
        let drawing = Drawing {
            vertices: [[0.0, 0.0], [4.0, 0.0], [x, y]].map(Vector2::from).to_vec(),
            edges: [[0, 1], [1, 2], [2, 0]].map(edge).to_vec(),
            faces: None,
        };
        CreasePattern::new(drawing).unwrap().coordinate_unit()
    }

    #[test]
    fn digits_tell_the_precision() {
        let close = |found: f64, expected: f64| assert!((found / expected - 1.0).abs() < 1e-9);
        close(unit(2.0, 3.46411), 1e-5);
        close(unit(2.0, 34.641_016), 1e-6);
        close(unit(2.0, -1.28264e-14), 1e-5);
        close(unit(2.0, 28268.0 * 1e-5), 1e-4);
        close(unit(2.0, f64::from(3.4641016_f32)), 4.0 * 2.0_f64.powi(-23));
        // Full precision, a grid, and numbers too short to be rounded.
        for exact in [12.0_f64.sqrt(), 3.0, 2.375, 3.1, 3.464] {
            assert!(unit(2.0, exact) <= 0.0, "{exact}");
        }
    }
}
