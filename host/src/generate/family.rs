//! A family of patterns with its parameters, as the command line and JSON name them.

use serde::Deserialize;

use super::{
    Kresling, Letters, Miura, ParameterError, Quad, Resch, SquareTwist, Waterbomb, Yoshimura,
};
use crate::pattern::Drawing;

/// A family of patterns with its parameters: angles in degrees, folds as fractions of a half turn. A parameter that is not
/// given has the default of the command line, of [`defaults`].
#[derive(Clone, Copy, Debug, PartialEq, Deserialize)]
#[serde(tag = "family", rename_all = "kebab-case", deny_unknown_fields)]
#[allow(missing_docs, reason = "the fields are those of the generators")]
pub enum Family {
    /// [`Miura`].
    Miura {
        rows: usize,
        cols: usize,
        angle: Option<f64>,
        fold: Option<f64>,
    },
    /// [`Waterbomb`].
    Waterbomb {
        rows: usize,
        cols: usize,
        fold: Option<f64>,
    },
    /// [`Yoshimura`].
    Yoshimura {
        rows: usize,
        cols: usize,
        angle: Option<f64>,
        fold: Option<f64>,
    },
    /// [`Quad`].
    Quad {
        rows: Option<usize>,
        cols: Option<usize>,
        fold: Option<f64>,
    },
    /// [`SquareTwist`].
    SquareTwist {
        rows: Option<usize>,
        cols: Option<usize>,
        angle: Option<f64>,
        letters: Option<Letters>,
        fold: Option<f64>,
    },
    /// [`Resch`].
    Resch {
        rows: Option<usize>,
        cols: Option<usize>,
    },
    /// [`Kresling`].
    Kresling {
        rows: Option<usize>,
        cols: Option<usize>,
    },
}

/// Parameters that are not given: degrees, fractions of a half turn, and numbers of rows or columns.
#[allow(missing_docs, reason = "the names say it")]
pub mod defaults {
    pub const MIURA_ANGLE: f64 = 60.0;
    pub const MIURA_FOLD: f64 = 0.9;
    pub const WATERBOMB_FOLD: f64 = 0.5;
    pub const YOSHIMURA_ANGLE: f64 = 30.0;
    pub const YOSHIMURA_FOLD: f64 = 0.25;
    pub const QUAD_SIZE: usize = 24;
    pub const QUAD_FOLD: f64 = 0.0675;
    pub const TWIST_SIZE: usize = 1;
    pub const TWIST_ANGLE: f64 = 60.0;
    pub const TWIST_FOLD: f64 = 0.5;
    pub const RESCH_SIZE: usize = 3;
    pub const KRESLING_RINGS: usize = 2;
    pub const KRESLING_SIDES: usize = 6;
}

impl Family {
    /// Returns a title for people, such as `Miura 11x11`.
    #[must_use]
    pub fn title(&self) -> String {
        use defaults::{KRESLING_RINGS, KRESLING_SIDES, QUAD_SIZE, RESCH_SIZE, TWIST_SIZE};
        let (name, rows, cols) = match *self {
            Self::Miura { rows, cols, .. } => ("Miura", rows, cols),
            Self::Waterbomb { rows, cols, .. } => ("Waterbomb", rows, cols),
            Self::Yoshimura { rows, cols, .. } => ("Yoshimura", rows, cols),
            Self::Quad { rows, cols, .. } => {
                ("Quad", rows.unwrap_or(QUAD_SIZE), cols.unwrap_or(QUAD_SIZE))
            }
            Self::SquareTwist { rows, cols, .. } => (
                "Square twist",
                rows.unwrap_or(TWIST_SIZE),
                cols.unwrap_or(TWIST_SIZE),
            ),
            Self::Resch { rows, cols } => (
                "Resch",
                rows.unwrap_or(RESCH_SIZE),
                cols.unwrap_or(RESCH_SIZE),
            ),
            Self::Kresling { rows, cols } => (
                "Kresling",
                rows.unwrap_or(KRESLING_RINGS),
                cols.unwrap_or(KRESLING_SIDES),
            ),
        };
        format!("{name} {rows}x{cols}")
    }

    /// Returns the drawing of the pattern.
    ///
    /// # Errors
    /// If a parameter is out of its range.
    pub fn drawing(&self) -> Result<Drawing, ParameterError> {
        use defaults::*;
        match *self {
            Self::Miura {
                rows,
                cols: columns,
                angle,
                fold,
            } => Miura {
                rows,
                columns,
                sector_angle: angle.unwrap_or(MIURA_ANGLE).to_radians(),
                fold: fold.unwrap_or(MIURA_FOLD),
            }
            .drawing(),
            Self::Waterbomb {
                rows,
                cols: columns,
                fold,
            } => Waterbomb {
                rows,
                columns,
                fold: fold.unwrap_or(WATERBOMB_FOLD),
            }
            .drawing(),
            Self::Yoshimura {
                rows,
                cols: columns,
                angle,
                fold,
            } => Yoshimura {
                rows,
                columns,
                angle: angle.unwrap_or(YOSHIMURA_ANGLE).to_radians(),
                fold: fold.unwrap_or(YOSHIMURA_FOLD),
            }
            .drawing(),
            Self::Quad { rows, cols, fold } => Quad {
                rows: rows.unwrap_or(QUAD_SIZE),
                columns: cols.unwrap_or(QUAD_SIZE),
                fold: fold.unwrap_or(QUAD_FOLD),
            }
            .drawing(),
            Self::SquareTwist {
                rows,
                cols,
                angle,
                letters,
                fold,
            } => SquareTwist {
                rows: rows.unwrap_or(TWIST_SIZE),
                columns: cols.unwrap_or(TWIST_SIZE),
                angle: angle.unwrap_or(TWIST_ANGLE).to_radians(),
                letters: letters.unwrap_or(Letters::Foldable),
                fold: fold.unwrap_or(TWIST_FOLD),
            }
            .drawing(),
            Self::Resch { rows, cols } => Resch {
                rows: rows.unwrap_or(RESCH_SIZE),
                columns: cols.unwrap_or(RESCH_SIZE),
            }
            .drawing(),
            Self::Kresling { rows, cols } => Kresling {
                rows: rows.unwrap_or(KRESLING_RINGS),
                columns: cols.unwrap_or(KRESLING_SIDES),
            }
            .drawing(),
        }
    }
}
