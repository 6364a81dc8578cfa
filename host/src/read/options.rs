//! Options of reading drawings: the tolerance, and the letters of colours and dashes.

use core::str::FromStr;
use std::path::Path;

use thiserror::Error;

use super::{FileError, Format};
use crate::pattern::{Letter, Unit};
use crate::util::range::Range;

/// Distance within which lines of a drawing are meant to meet, in the drawing's own units.
pub const TOLERANCE: Range = Range::above("a finite length", 0.0);

/// Options of reading a crease pattern. The default takes every choice from the file.
#[derive(Clone, Debug, Default, PartialEq)]
#[non_exhaustive]
pub struct ReadOptions {
    /// Format of the file. Without it, the ending of the name says the format.
    pub format: Option<Format>,
    /// Largest distance between lines of a drawing that are meant to meet, in the drawing's own units; positive and
    /// finite. Without it, the tolerance follows from the lengths of the lines.
    pub tolerance: Option<f64>,
    /// Patterns that are straightened.
    pub straighten: Straighten,
    /// Unit of lengths, for a file that names none.
    pub unit: Option<Unit>,
    /// Frame of a FOLD file with the pattern; the key frame is 0. Without it, the first frame of class `creasePattern` is
    /// read, or else the key frame.
    pub frame: Option<usize>,
    /// Letters of the colours of an SVG drawing. A colour that is not among them has its usual letter.
    pub colours: ColourLetters,
    /// Letter of the dashed lines of an SVG drawing. Without it, a dashed line has the letter of its colour.
    pub dashes: Option<Letter>,
}

crate::util::changed_one_by_one!(ReadOptions);

/// Patterns whose vertices are moved a little, by at most twice a tolerance, so that lines that are nearly straight or
/// parallel are so exactly, and so that vertices and holes fold flat that nearly do. The tolerance is that of drawings,
/// 10⁻³ of the median edge but at most 10⁻⁴ of the diagonal, or the unit to which coordinates are rounded if that is more.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[non_exhaustive]
pub enum Straighten {
    /// Those that do not fold as they are.
    #[default]
    Auto,
    /// All in which a vertex is off, before anything else is done with them; within [`ReadOptions::tolerance`] if there is
    /// one.
    On,
    /// None.
    Off,
}

impl ReadOptions {
    /// Checks that a file of this format can be read with these options.
    ///
    /// # Errors
    /// If the tolerance is no positive length, or the format has no use for an option.
    pub(super) fn check(&self, path: &Path, format: Format) -> Result<(), FileError> {
        let wrong = |place: &str, expected: &str, found: String| {
            Err(FileError::expected(path, place, expected, found))
        };
        // An STL file is no drawing, and the reader of FOLD says so.
        let format = match format {
            Format::Stl => Format::Fold,
            format => format,
        };
        if let Some(tolerance) = self.tolerance {
            if !TOLERANCE.contains(tolerance) {
                let expected = format!("{TOLERANCE}, in the units of the drawing");
                return wrong("the tolerance", &expected, tolerance.to_string());
            }
            if format == Format::Obj {
                let expected = "a drawing of lines: SVG, CP, OPX, or FOLD without faces";
                return wrong("the tolerance", expected, "an OBJ file".into());
            }
        }
        if self.frame.is_some() && format != Format::Fold {
            let expected = "a FOLD file, which has frames";
            return wrong("the frame", expected, format.described());
        }
        if !self.colours.is_empty() && format != Format::Svg {
            let expected = "an SVG drawing, whose lines have colours";
            return wrong("letters of colours", expected, format.described());
        }
        if self.dashes.is_some() && format != Format::Svg {
            let expected = "an SVG drawing, which has dashed lines";
            return wrong("the letter of dashes", expected, format.described());
        }
        Ok(())
    }
}

/// Letters of colours, parsed from text such as `red=V,blue=M,#00ff00=V`. Colours have their names or forms of CSS.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct ColourLetters(Vec<ColourLetter>);

/// A colour (0 to 255 for each channel) with its letter.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) struct ColourLetter {
    /// The colour as it was written.
    pub(super) name: String,
    pub(super) colour: [u8; 3],
    pub(super) letter: Letter,
}

impl ColourLetters {
    /// Returns `true` if no colour is given a letter.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.0.is_empty()
    }

    #[cfg(feature = "svg")]
    pub(super) fn iter(&self) -> impl Iterator<Item = &ColourLetter> {
        self.0.iter()
    }
}

impl core::fmt::Display for ColourLetters {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        for (index, ColourLetter { name, letter, .. }) in self.0.iter().enumerate() {
            let comma = if index > 0 { "," } else { "" };
            write!(f, "{comma}{name}={}", letter.code())?;
        }
        Ok(())
    }
}

/// The part of a text that gives no colour a letter.
#[derive(Clone, Debug, Error, PartialEq, Eq)]
#[non_exhaustive]
#[error("expected {expected}, found {found:?}")]
pub struct ColourLettersError {
    /// Description of what the part has to be.
    pub expected: &'static str,
    /// The part as it was written.
    pub found: String,
}

impl FromStr for ColourLetters {
    type Err = ColourLettersError;

    fn from_str(text: &str) -> Result<Self, Self::Err> {
        let mut letters: Vec<ColourLetter> = Vec::new();
        for part in text.split(',') {
            let wrong = |expected, found: &str| ColourLettersError {
                expected,
                found: found.trim().into(),
            };
            let pair = part.split_once('=');
            let (name, code) = pair.ok_or_else(|| wrong("COLOUR=LETTER, such as red=V", part))?;
            let colour = opaque(name.trim()).ok_or_else(|| {
                let expected =
                    "a colour, by a name of CSS such as red or in digits such as #ff0000";
                wrong(expected, name)
            })?;
            let letter = Letter::from_code(code.trim())
                .ok_or_else(|| wrong("a letter, one of B, M, V, F, U, C and J", code))?;
            let twice = |known: &ColourLetter| known.colour == colour && known.letter != letter;
            if letters.iter().any(twice) {
                return Err(wrong("one letter for each colour", part));
            }
            letters.push(ColourLetter {
                name: name.trim().into(),
                colour,
                letter,
            });
        }
        Ok(Self(letters))
    }
}

/// Parses an opaque colour by its name or its digits. Without the feature `svg` there are no colours.
#[cfg(not(feature = "svg"))]
fn opaque(_: &str) -> Option<[u8; 3]> {
    None
}

/// Parses an opaque colour by its name or its digits.
#[cfg(feature = "svg")]
fn opaque(text: &str) -> Option<[u8; 3]> {
    let colour: svgtypes::Color = text.parse().ok()?;
    // Forms with commas, such as rgb(0, 0, 0), cannot be told from a list.
    (colour.alpha == 255 && !text.contains('(')).then_some([colour.red, colour.green, colour.blue])
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn colours_are_parsed() {
        let letters: ColourLetters = "red=v, Blue=M,#0f0=V,#00FF01=c".parse().unwrap();
        let found: Vec<_> = letters.iter().map(|it| (it.colour, it.letter)).collect();
        let expected = [
            ([255, 0, 0], Letter::Valley),
            ([0, 0, 255], Letter::Mountain),
            ([0, 255, 0], Letter::Valley),
            ([0, 255, 1], Letter::Cut),
        ];
        assert_eq!(found, expected);
        assert_eq!(letters.to_string(), "red=V,Blue=M,#0f0=V,#00FF01=C");
        assert_eq!(letters.to_string().parse(), Ok(letters));
    }

    #[test]
    fn the_wrong_part_is_named() {
        for (text, found) in [
            ("", ""),
            ("red", "red"),
            ("red=V,", ""),
            ("red=V,rod=M", "rod"),
            ("red=V,#12=M", "#12"),
            ("red=V,transparent=M", "transparent"),
            ("red=V,blue=X", "X"),
            ("red=V,blue=", ""),
            ("red=V,blue=MV", "MV"),
            ("red=V,#f00=M", "#f00=M"),
            ("rgb(1=V", "rgb(1"),
        ] {
            let error = text.parse::<ColourLetters>().unwrap_err();
            assert_eq!(error.found, found, "{text}");
        }
    }
}
