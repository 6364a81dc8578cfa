//! Colours of pictures.

use plotters::style::colors::colormaps::{ColorMap, ViridisRGB};
use plotters::style::{Color, HSLColor, RGBColor};

/// Part of the colour circle from one group to the next: the golden section, so that however many there are,
/// neighbours differ.
const HUE_STEP: f64 = 0.618_033_988_749_895;

/// Colour of a crease group.
pub(crate) fn of_group(index: usize) -> RGBColor {
    #[allow(clippy::cast_precision_loss, reason = "any hue will do")]
    let hue = (0.6 + HUE_STEP * index as f64).fract();
    let (red, green, blue) = HSLColor(hue, 0.75, 0.42).to_rgba().rgb();
    RGBColor(red, green, blue)
}

/// Colour of a number from 0, dark, to 1, bright.
pub(crate) fn ramp(part: f64) -> RGBColor {
    ViridisRGB.get_color(part.clamp(0.0, 1.0))
}

/// As `#rrggbb`.
pub(crate) fn hex(RGBColor(red, green, blue): RGBColor) -> String {
    format!("#{red:02x}{green:02x}{blue:02x}")
}
