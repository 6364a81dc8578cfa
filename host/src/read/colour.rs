//! Letters of the colours of a drawing.

use super::options::{ColourLetter, ColourLetters};
use crate::colours::hex;
use crate::pattern::Letter;

/// Interpretation of a colour.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Kind {
    /// Exactly one of the simulator's colours.
    Exact(Letter),
    /// Near the colour of that name.
    Near(&'static str, Letter),
    /// Near none of the simulator's colours.
    Unknown,
    /// A colour that the caller gave a letter.
    Chosen(Letter),
    /// A colour with the hue of this one, which the caller gave a letter.
    NearChosen([u8; 3], Letter),
    /// A dashed line, and the caller gave dashes a letter.
    Dashed(Letter),
}

/// Index of black among the hues.
const BLACK: usize = 6;

/// Returns the nearest of the six full hues, which are 60 degrees apart, from red: a number below 6. Returns [`BLACK`]
/// for a colour without a channel above 64, and `None` for a colour with less than half of full brightness or half of
/// full saturation.
fn hue([red, green, blue]: [u8; 3]) -> Option<usize> {
    let most = red.max(green).max(blue);
    let chroma = most - red.min(green).min(blue);
    if most <= 64 {
        return Some(BLACK);
    }
    if most < 128 || chroma < most.div_ceil(2) {
        return None;
    }
    let [red, green, blue, full] = [red, green, blue, chroma].map(f64::from);
    // Hue in sixths of a turn from red.
    let hue = if red >= green && red >= blue {
        (green - blue) / full
    } else if green >= blue {
        2.0 + (blue - red) / full
    } else {
        4.0 + (red - green) / full
    };
    #[allow(
        clippy::cast_possible_truncation,
        clippy::cast_sign_loss,
        reason = "from 0 to 6"
    )]
    let nearest = (hue + 6.5) as usize % 6;
    Some(nearest)
}

impl Kind {
    pub(super) fn letter(self) -> Letter {
        match self {
            Self::Exact(letter)
            | Self::Near(_, letter)
            | Self::Chosen(letter)
            | Self::NearChosen(_, letter)
            | Self::Dashed(letter) => letter,
            Self::Unknown => Letter::Unassigned,
        }
    }

    /// Classifies a colour (0 to 255 for each channel). A colour that was given a letter has it. A colour whose hue is
    /// that of colours that were given letters counts as the nearest of them. Every other colour counts as the nearest of
    /// the simulator's colours; if it has no clear hue, or the hue of cyan, it is unknown.
    pub(super) fn of(colour: [u8; 3], chosen: &ColourLetters) -> Self {
        if let Some(it) = chosen.iter().find(|it| it.colour == colour) {
            return Self::Chosen(it.letter);
        }
        let Some(nearest) = hue(colour) else {
            return Self::Unknown;
        };
        let far = |it: &ColourLetter| -> u32 {
            let channels = it.colour.iter().zip(colour);
            channels.map(|(a, b)| u32::from(a.abs_diff(b)).pow(2)).sum()
        };
        let alike = chosen.iter().filter(|it| hue(it.colour) == Some(nearest));
        if let Some(it) = alike.min_by_key(|it| far(it)) {
            return Self::NearChosen(it.colour, it.letter);
        }
        // In the order of the hues.
        let (name, letter) = match nearest {
            0 => ("red", Letter::Mountain),
            1 => ("yellow", Letter::Flat),
            2 => ("green", Letter::Cut),
            4 => ("blue", Letter::Valley),
            5 => ("magenta", Letter::Unassigned),
            BLACK => ("black", Letter::Boundary),
            _ => return Self::Unknown,
        };
        let full = match nearest {
            BLACK => colour == [0; 3],
            _ => colour.iter().all(|channel| [0, 255].contains(channel)),
        };
        if full {
            Self::Exact(letter)
        } else {
            Self::Near(name, letter)
        }
    }

    /// Returns the note that `count` lines of this colour are taken as they are, unless that is plain.
    pub(super) fn note(self, colour: &str, count: usize) -> Option<String> {
        let code = self.letter().code();
        Some(match self {
            // Noted, because other programs use green for other purposes than cuts.
            Self::Exact(Letter::Cut) => {
                format!("lines of colour {colour} (green) taken as cuts (C): {count}")
            }
            Self::Exact(_) => return None,
            Self::Chosen(_) => format!(
                "lines of colour {colour} taken as {code}, the letter that the colour was given: {count}"
            ),
            Self::Dashed(_) => format!(
                "dashed lines of colour {colour} taken as {code}, the letter that dashes were given: {count}"
            ),
            Self::NearChosen(chosen, _) => format!(
                "lines of colour {colour} taken as {} ({code}), the nearest of the colours that were given \
                 letters: {count}",
                hex(chosen)
            ),
            Self::Near(name, _) => {
                format!(
                    "lines of colour {colour} taken as {name} ({code}), the nearest hue: {count}"
                )
            }
            Self::Unknown => format!(
                "lines of colour {colour}, which is none of red, blue, black, green, yellow and magenta, \
                 taken as U: {count}"
            ),
        })
    }
}
