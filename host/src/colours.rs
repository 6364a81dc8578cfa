//! Colours of crease groups and of numbers in pictures: red, green and blue from 0 to 255.

/// Fraction of the colour circle from one group to the next: the golden section, so that neighbouring groups differ in
/// hue however many groups there are.
const HUE_STEP: f64 = 0.618_033_988_749_895;
/// Saturation and lightness of the colours of groups.
const SATURATION: f64 = 0.75;
const LIGHTNESS: f64 = 0.42;

/// Returns the colour of a crease group.
pub(crate) fn of_group(index: usize) -> [u8; 3] {
    #[allow(clippy::cast_precision_loss, reason = "any hue will do")]
    let hue = (0.6 + HUE_STEP * index as f64).fract();
    // From hue, saturation and lightness: CSS Color Module Level 4, section 7.1.
    let amount = SATURATION * LIGHTNESS.min(1.0 - LIGHTNESS);
    [0.0, 8.0, 4.0].map(|channel| {
        let k = (channel + 12.0 * hue) % 12.0;
        let value = LIGHTNESS - amount * (k - 3.0).min(9.0 - k).clamp(-1.0, 1.0);
        byte(255.0 * value)
    })
}

/// Colours of the map Viridis (S. van der Walt and N. Smith, 2015) at ninths, joined by straight lines.
const VIRIDIS: [[f64; 3]; 10] = [
    [68.0, 1.0, 84.0],
    [72.0, 40.0, 120.0],
    [62.0, 73.0, 137.0],
    [49.0, 104.0, 142.0],
    [38.0, 130.0, 142.0],
    [31.0, 158.0, 137.0],
    [53.0, 183.0, 121.0],
    [110.0, 206.0, 88.0],
    [181.0, 222.0, 43.0],
    [253.0, 231.0, 37.0],
];

/// Returns the colour of a number from 0 (dark) to 1 (bright).
pub(crate) fn ramp(part: f64) -> [u8; 3] {
    let place = 9.0 * part.clamp(0.0, 1.0);
    let before = byte(place.floor()).min(8);
    let after = place - f64::from(before);
    let [low, high] = [0, 1].map(|k| VIRIDIS[usize::from(before) + k]);
    [0, 1, 2].map(|k| byte(low[k] + after * (high[k] - low[k])))
}

/// Rounds a number from 0 to 255.
#[allow(
    clippy::cast_possible_truncation,
    clippy::cast_sign_loss,
    reason = "0 to 255"
)]
fn byte(value: f64) -> u8 {
    value.round() as u8
}

/// Formats a colour as `#rrggbb`.
pub(crate) fn hex([red, green, blue]: [u8; 3]) -> String {
    format!("#{red:02x}{green:02x}{blue:02x}")
}
