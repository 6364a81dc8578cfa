//! Renders an SVG picture as a PNG file with resvg.
//!
//! The renderer is built without its text shaping, which takes longer to build than all other code for drawing. Plots
//! have only short labels, so [`fonts`](crate::fonts) turns them into outlines first.

use resvg::tiny_skia::{Pixmap, Transform};
use resvg::usvg::{Options, Tree};
use thiserror::Error;

use crate::fonts::{self, Font};

/// Reason why a picture cannot be rendered.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Error)]
pub(crate) enum PngError {
    /// No font was found on the system, and drawing texts needs one.
    #[error("expected a font on this system to draw texts with, found none (.svg needs none)")]
    NoFont,
    /// The text is no SVG picture, or the picture does not fit in memory.
    #[error("expected an SVG picture that fits in memory")]
    NoPicture,
}

/// Renders an SVG picture in its own size as a PNG file, with its texts in `font`.
///
/// # Errors
/// If `font` is `None`, the text is no SVG picture, or the picture does not fit in memory.
pub(crate) fn png(svg: &str, font: Option<&Font>) -> Result<Vec<u8>, PngError> {
    let font = font.ok_or(PngError::NoFont)?;
    let draw = || {
        let outlined = fonts::outlined(svg, font)?;
        let tree = Tree::from_str(&outlined, &Options::default()).ok()?;
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
        let error = png("<svg/>", None).unwrap_err();
        assert_eq!(
            error.to_string(),
            "expected a font on this system to draw texts with, found none (.svg needs none)"
        );
        let error = png("none", Font::of_system().as_ref()).unwrap_err();
        assert_eq!(
            error.to_string(),
            "expected an SVG picture that fits in memory"
        );
    }
}
