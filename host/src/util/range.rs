//! Ranges of numbers that users choose.

use core::fmt;

/// Range of a number, with its unit in words. It is written as what a message expects, such as `degrees from 0 to 180`.
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub struct Range {
    /// Unit in the plural, such as `degrees`, or what the number is, such as `a fraction`.
    pub unit: &'static str,
    /// Smallest number.
    pub least: f64,
    /// `true` if the smallest number itself is outside.
    pub is_open: bool,
    /// Largest number; the largest finite one if there is no limit.
    pub most: f64,
}

impl Range {
    /// Returns the range of all finite numbers from `least` on.
    #[must_use]
    pub const fn from(unit: &'static str, least: f64) -> Self {
        Self {
            unit,
            least,
            is_open: false,
            most: f64::MAX,
        }
    }

    /// Returns the range of all finite numbers above `least`.
    #[must_use]
    pub const fn above(unit: &'static str, least: f64) -> Self {
        Self {
            is_open: true,
            ..Self::from(unit, least)
        }
    }

    /// Returns the part of the range up to `most`.
    #[must_use]
    pub const fn up_to(self, most: f64) -> Self {
        Self { most, ..self }
    }

    /// Returns `true` if the number is in the range.
    #[must_use]
    pub fn contains(&self, number: f64) -> bool {
        (number > self.least || number >= self.least && !self.is_open) && number <= self.most
    }

    /// Returns the range in radians, if this one is in degrees.
    #[must_use]
    pub fn to_radians(self) -> Self {
        Self {
            unit: self.unit,
            least: self.least.to_radians(),
            is_open: self.is_open,
            most: self.most.to_radians(),
        }
    }

    /// Returns `true` if there is a largest number.
    #[must_use]
    pub fn is_bounded(&self) -> bool {
        self.most < f64::MAX
    }
}

impl fmt::Display for Range {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self {
            unit, least, most, ..
        } = self;
        match (self.is_open, self.is_bounded()) {
            (false, true) => write!(f, "{unit} from {least} to {most}"),
            (true, true) => write!(f, "{unit} above {least} and at most {most}"),
            (false, false) => write!(f, "{unit} from {least}"),
            (true, false) => write!(f, "{unit} above {least}"),
        }
    }
}
