//! Pixels of a picture.

use resvg::tiny_skia::{Pixmap, Transform};
use resvg::usvg::fontdb::{Database, Family, Query};
use resvg::usvg::{Options, Tree};
use thiserror::Error;

/// Why there are no pixels.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Error)]
pub(crate) enum PngError {
    /// Texts have to be drawn, and only the system has fonts.
    #[error("expected a font on this system to draw texts with, found none (.svg needs none)")]
    NoFont,
    /// The text is no picture.
    #[error("expected an SVG picture that fits in memory")]
    NoPicture,
}

/// The fonts of this system.
#[must_use]
pub(crate) fn system_fonts() -> Database {
    let mut fonts = Database::new();
    fonts.load_system_fonts();
    fonts
}

/// A PNG file with an SVG picture in its own size; texts are in the sans-serif of `fonts`, or else in one
/// that is called so, or else in any.
///
/// # Errors
/// If there is no font, or the text is no picture.
pub(crate) fn png(svg: &str, mut fonts: Database) -> Result<Vec<u8>, PngError> {
    let query = Query {
        families: &[Family::SansSerif],
        ..Query::default()
    };
    if fonts.query(&query).is_none() {
        let families = || {
            fonts
                .faces()
                .filter_map(|face| Some(&face.families.first()?.0))
        };
        let sans = families().find(|family| family.contains("Sans"));
        let any = sans.or(families().next()).ok_or(PngError::NoFont)?.clone();
        fonts.set_sans_serif_family(any);
    }
    let options = Options {
        fontdb: fonts.into(),
        ..Options::default()
    };
    let draw = || {
        let tree = Tree::from_str(svg, &options).ok()?;
        let size = tree.size().to_int_size();
        let mut pixels = Pixmap::new(size.width(), size.height())?;
        resvg::render(&tree, Transform::default(), &mut pixels.as_mut());
        pixels.encode_png().ok()
    };
    draw().ok_or(PngError::NoPicture)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn without_a_font_or_a_picture_it_says_so() {
        let error = png("<svg/>", Database::new()).unwrap_err();
        assert_eq!(
            error.to_string(),
            "expected a font on this system to draw texts with, found none (.svg needs none)"
        );
        let error = png("none", system_fonts()).unwrap_err();
        assert_eq!(
            error.to_string(),
            "expected an SVG picture that fits in memory"
        );
    }
}
