//! Precision of the numbers of a file, as they were written.
//!
//! Coordinates and goal angles are rounded to digits, and what follows from them is no more precise: lines that were meant
//! to pass straight through a vertex are bent a little, closed solids overlap by some digits. Numbers are asked as they
//! were written: before units, transforms and unfolding, which make long digits of short ones.

use super::CreasePattern;

/// Number of significant digits from which on a number is exact to double precision.
const FULL_DIGITS: usize = 14;
/// Number of steps of the grid of its coordinates across a sheet from which on coordinates are rounded. Fewer are those of
/// a drawing on a grid, unless it looks as if they were rounded.
const MIN_STEPS: f64 = 1e4;
/// Number of such steps in a sheet that looks as if its coordinates were rounded.
const MIN_ROUNDED_STEPS: f64 = 1e2;
/// Ratio of a number to the largest one up to which the number is a zero with the noise of a program.
const ZERO_RATIO: f64 = 1e-9;
/// Number of digits that a number of the largest decade has at least if numbers are rounded, how many fewer it may have than
/// the longest number, and number of such numbers that show to which place.
const MIN_LARGE_DIGITS: usize = 4;
const MAX_SHORTER: usize = 2;
const MIN_LARGE: usize = 2;
/// Largest difference of lengths that are equal but for rounding, in units of the last digit, and relative difference up to
/// which lengths are equal.
const TWINS_UNITS: f64 = 2.0;
const EQUAL_RATIO: f64 = 1e-9;
/// Largest part of the edges that may be equally long by chance if nearly equal lengths are to show rounding.
const MAX_TWINS_BY_CHANCE: f64 = 0.25;
/// Number of numbers among which one of full precision is looked for before all others are.
const PROBED: usize = 32;
/// Sines of the least and the largest bend of a line that is meant to be straight.
const BENT_SINES: core::ops::Range<f64> = 1e-9..1e-3;
/// Angles that are multiples of one of these are meant as they are, degrees.
const ROUND_DEG: [f64; 2] = [1.0, 2.5];

/// Precision with which numbers were written.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub enum Digits {
    /// To double precision, or on a grid.
    #[default]
    Exact,
    /// Rounded to a decimal place: the unit of that place.
    Decimal(f64),
    /// In single precision: the unit of the last digit of the largest number.
    Single(f64),
}

/// Precision of a pattern.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Precision {
    /// Precision of coordinates, in units of the sheet.
    pub length: Digits,
    /// Precision of goal angles, radians.
    pub angle: Digits,
}

impl Digits {
    /// Returns the unit of the last digit; 0 if numbers are exact.
    #[must_use]
    pub fn unit(self) -> f64 {
        match self {
            Self::Exact => 0.0,
            Self::Decimal(unit) | Self::Single(unit) => unit,
        }
    }

    /// Returns the precision of numbers with this unit; exact if it is 0.
    #[must_use]
    pub fn of_unit(unit: f64) -> Self {
        if unit > 0.0 {
            Self::Decimal(unit)
        } else {
            Self::Exact
        }
    }

    /// Returns the precision of the same numbers multiplied by a factor.
    #[must_use]
    pub fn scaled(self, factor: f64) -> Self {
        match self {
            Self::Exact => Self::Exact,
            Self::Decimal(unit) => Self::Decimal(unit * factor),
            Self::Single(unit) => Self::Single(unit * factor),
        }
    }

    /// Returns the precision that has the larger unit.
    #[must_use]
    pub fn coarser(self, other: Self) -> Self {
        if other.unit() > self.unit() {
            other
        } else {
            self
        }
    }

    /// Returns the precision of the coordinates of points, as they were written.
    ///
    /// The unit is the least decimal place in use. Coordinates count as exact if one of them has 14 significant digits or
    /// more, or if they lie on a grid that has fewer than ten thousand steps across the sheet; in a sheet that looks as if
    /// coordinates were `rounded` to this unit, a hundred. The grid is the largest on which all coordinates lie, so that it does not hang
    /// on unit and origin. Cost: about 100 ns a coordinate.
    #[must_use]
    pub fn of_coordinates<const N: usize>(
        points: impl Iterator<Item = [f64; N]> + Clone,
        rounded: impl FnOnce(f64) -> bool,
    ) -> Self {
        let all = points.clone().flatten();
        let digits = Self::written(all);
        let Self::Decimal(unit) = digits else {
            return digits;
        };
        let (mut grid, mut extent) = (0, 0.0);
        for k in 0..N {
            let (common, across) = grid_of(points.clone().map(|point| point[k]), unit);
            (grid, extent) = (divisor(grid, common), f64::max(extent, across));
        }
        #[allow(clippy::cast_precision_loss, reason = "a number of steps")]
        let steps = extent / grid.max(1) as f64;
        if steps >= MIN_STEPS || steps >= MIN_ROUNDED_STEPS && rounded(unit) {
            digits
        } else {
            Self::Exact
        }
    }

    /// Returns the precision of angles in radians, which may have been written in degrees, radians or half turns: as the one
    /// in which all have few digits and that is the least precise. Whole degrees
    /// and multiples of 2.5 are meant as they are.
    #[must_use]
    pub fn of_angles(angles: impl Iterator<Item = f64>) -> Self {
        let is_round = |angle: f64| {
            let multiples = ROUND_DEG.map(|round| angle.to_degrees() / round);
            multiples
                .iter()
                .any(|multiple| (multiple - multiple.round()).abs() < 1e-9)
        };
        // Tessellations have few different angles.
        let mut uneven: Vec<f64> = angles
            .filter(|angle| angle.is_finite())
            .map(f64::abs)
            .collect();
        uneven.sort_unstable_by(f64::total_cmp);
        uneven.dedup_by(|a, b| a.to_bits() == b.to_bits());
        uneven.retain(|angle| !is_round(*angle));
        let degree = 1_f64.to_radians();
        let written = [degree, 1.0, core::f64::consts::PI].map(|unit| {
            let digits = Self::written(uneven.iter().map(|angle| angle / unit));
            digits.scaled(unit)
        });
        let decimal = written
            .into_iter()
            .filter(|digits| matches!(digits, Self::Decimal(_)));
        decimal.reduce(Self::coarser).unwrap_or(written[0])
    }

    /// Returns the precision of numbers by the least decimal place in use. Programs that write a number of significant
    /// digits give small numbers more places than large ones: there the last digit of the largest number counts.
    fn written(numbers: impl Iterator<Item = f64> + Clone) -> Self {
        let finite = numbers.filter(|x| x.is_finite()).map(f64::abs);
        let largest = finite.clone().fold(0.0, f64::max);
        let numbers = finite.filter(|x| *x > ZERO_RATIO * largest);
        #[allow(
            clippy::cast_possible_truncation,
            reason = "asks whether anything is lost"
        )]
        let is_single = |x: f64| f64::from(x as f32).to_bits() == x.to_bits();
        let is_full = |x: f64| last_place(x).0 >= FULL_DIGITS;
        let step = numbers.clone().count() / PROBED + 1;
        let mut some = numbers.clone().step_by(step);
        if some.any(|x| !is_single(x) && is_full(x)) {
            return Self::Exact;
        }
        // Tessellations have few different numbers, and to find the digits of one takes long.
        let mut numbers: Vec<f64> = numbers.collect();
        numbers.sort_unstable_by(f64::total_cmp);
        numbers.dedup_by(|a, b| a.to_bits() == b.to_bits());
        let mut written = Vec::with_capacity(numbers.len());
        let (mut least, mut longest) = (None, 0);
        for &x in &numbers {
            let (digits, place) = last_place(x);
            if digits >= FULL_DIGITS {
                return if numbers.iter().all(|&x| is_single(x)) {
                    Self::Single(largest * f64::from(f32::EPSILON))
                } else {
                    Self::Exact
                };
            }
            least = least.max(Some(place));
            longest = longest.max(digits);
            written.push((digits, place));
        }
        let Some(least) = least else {
            return Self::Exact;
        };
        let decade = largest.log10().floor();
        let large = numbers.partition_point(|x| x.log10().floor() < decade);
        // Whole numbers beside long ones do not show to which place the largest numbers are rounded.
        let mut rounded = written[large..].to_vec();
        rounded
            .retain(|&(digits, _)| digits >= MIN_LARGE_DIGITS && digits + MAX_SHORTER >= longest);
        let place = if rounded.len() >= MIN_LARGE && rounded.iter().all(|&(_, place)| place < least)
        {
            let (digits, place) = last_place(largest);
            place + count(longest) - count(digits)
        } else {
            least
        };
        Self::Decimal(10.0_f64.powi(-place))
    }
}

impl CreasePattern {
    /// Returns the precision with which the pattern was written: what its reader told, or what the digits of its own
    /// coordinates and goal angles tell. Cost: about 100 ns a number when it is first requested.
    #[must_use]
    pub fn precision(&self) -> Precision {
        *self.precision.get_or_init(|| {
            let points = self.vertices().iter().map(|point| [point.x, point.y]);
            Precision {
                length: Digits::of_coordinates(points, |unit| self.looks_rounded(unit)),
                angle: Digits::of_angles(self.goals()),
            }
        })
    }

    /// Sets the precision with which the pattern was written.
    pub(crate) fn written_with(&mut self, precision: Precision) {
        self.precision = precision.into();
    }

    /// Sets the precision with which the coordinates were written; goal angles are asked as they are.
    pub(crate) fn lengths_written_with(&mut self, length: Digits) {
        let angle = Digits::of_angles(self.goals());
        self.written_with(Precision { length, angle });
    }

    /// Returns the goal angles of the edges that have one, radians.
    pub(crate) fn goals(&self) -> impl Iterator<Item = f64> + Clone {
        self.edges().iter().filter_map(|edge| edge.goal)
    }

    /// Returns `true` if coordinates look as if they were rounded to this unit: lines are bent a little, or many lengths are
    /// nearly equal.
    pub(crate) fn looks_rounded(&self, unit: f64) -> bool {
        self.has_bent_line() || self.has_unequal_twins(unit)
    }

    /// Returns `true` if at least half of the edges are as long as others but for rounding to this unit, and far fewer would
    /// be by chance.
    fn has_unequal_twins(&self, unit: f64) -> bool {
        let mut lengths: Vec<f64> = self
            .edges()
            .iter()
            .map(|edge| self.length(edge.ends))
            .collect();
        lengths.sort_unstable_by(f64::total_cmp);
        let equal = |a: &f64, b: &f64| b - a <= EQUAL_RATIO * b;
        let groups: Vec<&[f64]> = lengths.chunk_by(equal).collect();
        let near = |a: &[f64], b: &[f64]| b[0] - a[a.len() - 1] <= TWINS_UNITS * unit;
        let is_twin = |k: usize| {
            let after = groups.get(k + 1).is_some_and(|next| near(groups[k], next));
            after || k > 0 && near(groups[k - 1], groups[k])
        };
        let twins = groups.iter().enumerate().filter(|(k, _)| is_twin(*k));
        let twins: usize = twins.map(|(_, group)| group.len()).sum();
        let longest = lengths.last().copied().unwrap_or_default();
        #[allow(clippy::cast_precision_loss, reason = "a number of edges")]
        let by_chance = 2.0 * TWINS_UNITS * unit * groups.len() as f64 / longest;
        2 * twins >= lengths.len() && by_chance <= MAX_TWINS_BY_CHANCE
    }

    /// Returns `true` if two edges pass nearly straight through a vertex, but not quite.
    fn has_bent_line(&self) -> bool {
        self.real_vertices().any(|vertex| {
            let star = self.stars()[vertex.index()].iter();
            let drawn = star.filter(|edge| !self.joins_parts(**edge));
            let directions = || drawn.clone().map(|&edge| self.direction(edge, vertex));
            directions().enumerate().any(|(index, a)| {
                let mut others = directions().skip(index + 1);
                others.any(|b| a.dot(&b) < 0.0 && BENT_SINES.contains(&a.perp(&b).abs()))
            })
        })
    }
}

/// Returns the number of significant digits of a number, and the place of the last one: 2 for hundredths. The 16th and
/// later digits count as noise of a program that rounded it.
fn last_place(x: f64) -> (usize, i32) {
    let written = format!("{x:.14e}");
    let (mantissa, exponent) = written.split_once('e').unwrap_or_default();
    let mantissa = mantissa.trim_end_matches('0');
    let digits = mantissa.bytes().filter(u8::is_ascii_digit).count();
    let exponent: i32 = exponent.parse().unwrap_or_default();
    (digits, count(digits) - 1 - exponent)
}

/// Converts a number of digits.
fn count(digits: usize) -> i32 {
    i32::try_from(digits).unwrap_or_default()
}

/// Returns the largest grid, in units, on which all of these numbers lie from the first one on, and their extent in units.
fn grid_of(numbers: impl Iterator<Item = f64>, unit: f64) -> (u64, f64) {
    let mut first = None;
    let (mut grid, mut low, mut high) = (0, f64::INFINITY, f64::NEG_INFINITY);
    for x in numbers.filter(|x| x.is_finite()) {
        let from = *first.get_or_insert(x);
        let steps = ((x - from) / unit).round();
        (low, high) = (low.min(steps), high.max(steps));
        #[allow(
            clippy::cast_possible_truncation,
            clippy::cast_sign_loss,
            reason = "below 2^53, or saturated"
        )]
        let steps = steps.abs() as u64;
        grid = divisor(grid, steps);
    }
    (grid, (high - low).max(0.0))
}

/// Returns the greatest common divisor; the other number if one is 0.
fn divisor(mut a: u64, mut b: u64) -> u64 {
    while b > 0 {
        (a, b) = (b, a % b);
    }
    a
}

#[cfg(test)]
mod tests {
    use super::Digits;

    /// Returns the unit of a triangle whose last corner has this place.
    fn unit(x: f64, y: f64) -> f64 {
        let points = [[0.0, 0.0], [4.0, 0.0], [x, y]];
        Digits::of_coordinates(points.into_iter(), |_| false).unit()
    }

    fn close(found: f64, expected: f64) {
        assert!(
            (found / expected - 1.0).abs() < 1e-9,
            "{found}, not {expected}"
        );
    }

    #[test]
    fn the_least_decimal_place_is_the_unit() {
        close(unit(2.0, 3.46411), 1e-5);
        close(unit(2.0, 34.641_016), 1e-6);
        close(unit(400.0, 0.000_123_45), 1e-8);
        close(
            unit(2.0, f64::from(3.464_101_6_f32)),
            4.0 * 2.0_f64.powi(-23),
        );
        // Full precision, grids, and numbers too short to be rounded.
        for exact in [12.0_f64.sqrt(), 3.0, 2.375, 3.1, 3.464, -1.28264e-14] {
            assert!(unit(2.0, exact) <= 0.0, "{exact}");
        }
    }

    #[test]
    fn small_numbers_with_as_many_digits_say_nothing_of_large_ones() {
        let points = [[123.456, 0.0], [98.7654, 0.001_234_56], [45.6789, 301.777]];
        close(
            Digits::of_coordinates(points.into_iter(), |_| false).unit(),
            1e-3,
        );
    }

    #[test]
    fn scale_shift_and_noise_change_nothing() {
        let points = [[0.0, 0.0], [4.0, 0.0], [2.0, 3.4641], [1.2345, 0.5]];
        let unit = |scale: f64, shift: f64| {
            let moved = points.map(|point| point.map(|x| x * scale + shift));
            Digits::of_coordinates(moved.into_iter(), |_| false).unit()
        };
        close(unit(1.0, 0.0), 1e-4);
        close(unit(10.0, 0.0), 1e-3);
        close(unit(1e4, 0.0), 1.0);
        close(unit(1.0, 1e5), 1e-4);
        // The largest numbers are whole, which says nothing of the others.
        let rows = [[1.012, 0.0], [3.734_356, 1.0], [6.409_735, -1.0]];
        let far = rows.map(|[x, y]| [x + 1e3, y - 2e4]);
        close(
            Digits::of_coordinates(far.into_iter(), |_| false).unit(),
            1e-6,
        );
        let grid = |scale: f64| {
            let grid = (0..40).map(|k| [f64::from(k % 7) * scale, f64::from(k / 7) * scale]);
            Digits::of_coordinates(grid, |_| true)
        };
        for scale in [1.0, 0.1, 0.375, 25.4, 100.0] {
            assert_eq!(grid(scale), Digits::Exact);
        }
    }

    #[test]
    fn angles_are_asked_as_they_were_written() {
        let unit = |angles: &[f64]| Digits::of_angles(angles.iter().copied()).unit();
        let degrees = |angles: &[f64]| {
            let radians: Vec<f64> = angles.iter().map(|angle| angle.to_radians()).collect();
            unit(&radians)
        };
        close(degrees(&[70.53, -180.0]), 0.01_f64.to_radians());
        close(degrees(&[70.5, 109.47]), 0.01_f64.to_radians());
        close(degrees(&[70.5]), 0.1_f64.to_radians());
        close(unit(&[0.9553, 1.231]), 1e-4);
        close(
            unit(&[0.3918 * core::f64::consts::PI]),
            1e-4 * core::f64::consts::PI,
        );
        for exact in [90.0, 67.5, 180.0, 0.0, 70.528_779_365_509_31] {
            assert!(degrees(&[exact]) <= 0.0, "{exact}");
        }
    }
}
