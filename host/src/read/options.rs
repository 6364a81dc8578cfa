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
    /// Letters of the colours of an SVG or DXF drawing. A colour that is not among them has its usual letter.
    pub colours: ColourLetters,
    /// Letters of the layers of a DXF drawing. A layer that is not among them has the letter of its name or its colour.
    pub layers: LayerLetters,
    /// Letter of the dashed lines of an SVG or DXF drawing. Without it, a dashed line has the letter of its colour or layer.
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
                let expected = "a drawing of lines: SVG, DXF, CP, OPX, or FOLD without faces";
                return wrong("the tolerance", expected, "an OBJ file".into());
            }
        }
        if self.frame.is_some() && format != Format::Fold {
            let expected = "a FOLD file, which has frames";
            return wrong("the frame", expected, format.described());
        }
        let is_styled = matches!(format, Format::Svg | Format::Dxf);
        if !self.colours.is_empty() && !is_styled {
            let expected = "an SVG drawing or a DXF drawing, whose lines have colours";
            return wrong("letters of colours", expected, format.described());
        }
        if !self.layers.is_empty() && format != Format::Dxf {
            let expected = "a DXF drawing, which has layers";
            return wrong("letters of layers", expected, format.described());
        }
        if self.dashes.is_some() && !is_styled {
            let expected = "an SVG drawing or a DXF drawing, which has dashed lines";
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
        write_pairs(f, self.0.iter().map(|it| (&*it.name, it.letter)))
    }
}

/// Letters of layers, parsed from text such as `CUT=B,CREASE=V`. Layers are told apart without regard to case.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct LayerLetters(Vec<(String, Letter)>);

impl LayerLetters {
    /// Returns `true` if no layer is given a letter.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.0.is_empty()
    }

    /// Returns the letter that a layer is given, if it is.
    #[cfg(feature = "dxf")]
    pub(super) fn of(&self, layer: &str) -> Option<Letter> {
        let mut layers = self.0.iter();
        let found = layers.find(|(name, _)| name.to_uppercase() == layer.to_uppercase());
        found.map(|(_, letter)| *letter)
    }

    #[cfg(feature = "dxf")]
    pub(super) fn iter(&self) -> impl Iterator<Item = &(String, Letter)> {
        self.0.iter()
    }
}

impl core::fmt::Display for LayerLetters {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        let pairs = self.0.iter().map(|(name, letter)| (&**name, *letter));
        write_pairs(f, pairs)
    }
}

impl FromStr for LayerLetters {
    type Err = LettersError;

    fn from_str(text: &str) -> Result<Self, Self::Err> {
        let mut letters: Vec<(String, Letter)> = Vec::new();
        for part in text.split(',') {
            let (name, letter) = pair(part, "LAYER=LETTER, such as CUT=B")?;
            if name.is_empty() {
                return Err(LettersError::of("the name of a layer", part));
            }
            let is_same = |known: &(String, Letter)| known.0.to_uppercase() == name.to_uppercase();
            if letters
                .iter()
                .any(|known| is_same(known) && known.1 != letter)
            {
                return Err(LettersError::of("one letter for each layer", part));
            }
            letters.push((name.into(), letter));
        }
        Ok(Self(letters))
    }
}

/// Writes names with their letters as they are parsed.
fn write_pairs<'n>(
    f: &mut core::fmt::Formatter<'_>,
    pairs: impl Iterator<Item = (&'n str, Letter)>,
) -> core::fmt::Result {
    for (index, (name, letter)) in pairs.enumerate() {
        let comma = if index > 0 { "," } else { "" };
        write!(f, "{comma}{name}={}", letter.code())?;
    }
    Ok(())
}

/// Parses a name and its letter.
fn pair<'t>(part: &'t str, expected: &'static str) -> Result<(&'t str, Letter), LettersError> {
    let pair = part.split_once('=');
    let (name, code) = pair.ok_or_else(|| LettersError::of(expected, part))?;
    let letter = Letter::from_code(code.trim());
    let letters = "a letter, one of B, M, V, F, U, C and J";
    let letter = letter.ok_or_else(|| LettersError::of(letters, code))?;
    Ok((name.trim(), letter))
}

/// The part of a text that gives no colour and no layer a letter.
#[derive(Clone, Debug, Error, PartialEq, Eq)]
#[non_exhaustive]
#[error("expected {expected}, found {found:?}")]
pub struct LettersError {
    /// Description of what the part has to be.
    pub expected: &'static str,
    /// The part as it was written.
    pub found: String,
}

impl LettersError {
    fn of(expected: &'static str, found: &str) -> Self {
        Self {
            expected,
            found: found.trim().into(),
        }
    }
}

impl FromStr for ColourLetters {
    type Err = LettersError;

    fn from_str(text: &str) -> Result<Self, Self::Err> {
        let mut letters: Vec<ColourLetter> = Vec::new();
        for part in text.split(',') {
            let (name, letter) = pair(part, "COLOUR=LETTER, such as red=V")?;
            let colour = opaque(name).ok_or_else(|| {
                let expected =
                    "a colour, by a name of CSS such as red or in digits such as #ff0000";
                LettersError::of(expected, name)
            })?;
            let twice = |known: &ColourLetter| known.colour == colour && known.letter != letter;
            if letters.iter().any(twice) {
                return Err(LettersError::of("one letter for each colour", part));
            }
            letters.push(ColourLetter {
                name: name.into(),
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
