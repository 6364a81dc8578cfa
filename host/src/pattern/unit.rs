//! Units of length, by the names that FOLD gives them.

use super::CreasePattern;

/// Unit of the lengths of a drawing.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Unit {
    /// Nanometres.
    Nanometre,
    /// Micrometres.
    Micrometre,
    /// Millimetres.
    Millimetre,
    /// Centimetres.
    Centimetre,
    /// Metres.
    Metre,
    /// Inches.
    Inch,
    /// Points of DTP, of which 72 are an inch.
    Point,
}

impl Unit {
    /// All units.
    pub const ALL: [Self; 7] = [
        Self::Nanometre,
        Self::Micrometre,
        Self::Millimetre,
        Self::Centimetre,
        Self::Metre,
        Self::Inch,
        Self::Point,
    ];

    /// Returns the name in FOLD's `frame_unit`.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Self::Nanometre => "nm",
            Self::Micrometre => "um",
            Self::Millimetre => "mm",
            Self::Centimetre => "cm",
            Self::Metre => "m",
            Self::Inch => "in",
            Self::Point => "pt",
        }
    }

    /// Returns the unit with this name.
    #[must_use]
    pub fn from_name(name: &str) -> Option<Self> {
        Self::ALL.into_iter().find(|unit| unit.name() == name)
    }

    /// Returns its length in metres.
    #[must_use]
    pub const fn metres(self) -> f64 {
        match self {
            Self::Nanometre => 1e-9,
            Self::Micrometre => 1e-6,
            Self::Millimetre => 1e-3,
            Self::Centimetre => 1e-2,
            Self::Metre => 1.0,
            Self::Inch => 0.0254,
            Self::Point => 0.0254 / 72.0,
        }
    }
}

impl CreasePattern {
    /// Returns the unit of the lengths of the pattern, if the drawing or its reader tells one.
    #[must_use]
    pub fn unit(&self) -> Option<Unit> {
        self.unit
    }

    /// Sets the unit of lengths.
    pub(crate) fn measured_in(&mut self, unit: Option<Unit>) {
        self.unit = unit;
    }
}
