//! Colours of crease groups and of numbers in pictures.

use plotters::style::colors::colormaps::{ColorMap, ViridisRGB};
use plotters::style::{Color, HSLColor, RGBColor};

/// Fraction of the colour circle from one group to the next: the golden section, so that neighbouring groups differ in
/// hue however many groups there are.
const HUE_STEP: f64 = 0.618_033_988_749_895;

/// Returns the colour of a crease group.
pub(crate) fn of_group(index: usize) -> RGBColor {
    #[allow(clippy::cast_precision_loss, reason = "any hue will do")]
    let hue = (0.6 + HUE_STEP * index as f64).fract();
    let (red, green, blue) = HSLColor(hue, 0.75, 0.42).to_rgba().rgb();
    RGBColor(red, green, blue)
}

/// Returns the colour of a number from 0 (dark) to 1 (bright), of the Viridis map.
pub(crate) fn ramp(part: f64) -> RGBColor {
    ViridisRGB.get_color(part.clamp(0.0, 1.0))
}

/// Formats a colour as `#rrggbb`.
pub(crate) fn hex(RGBColor(red, green, blue): RGBColor) -> String {
    format!("#{red:02x}{green:02x}{blue:02x}")
}
