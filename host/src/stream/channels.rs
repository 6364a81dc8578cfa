//! Edits the map from hinges to channels: a text that people edit as well.
//!
//! ```text
//! # Servos of the left half.
//! hinge,channel,zero,sign,lower,upper
//! 0,3,1.5708,+,-1.6,1.6
//! 1,0,1.4,-,-1.6,0
//! ```
//!
//! Each line gives a hinge, in the pattern's order, its channel, the angle of the channel at which the hinge is flat
//! (`zero`, radians), `+` if the channel turns with the hinge and `-` if it turns against it, and the smallest and largest
//! angle of the hinge (radians, valley positive). Lines may come in any order; spaces round values, blank lines and what
//! follows a `#` are ignored. The map may lack hinges, because it grows while a board is commissioned. Lines that do not
//! change stay as they are.

use core::fmt::{self, Write as _};
use std::path::Path;

pub use foldpath_firmware_sim::controller::Channel;

use crate::read::FileError;

/// The first line of a map.
const HEADER: &str = "hinge,channel,zero,sign,lower,upper";

/// A map that people and [`Bench`](super::Bench) fill.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Channels {
    lines: Vec<Line>,
}

#[derive(Clone, Debug, PartialEq)]
struct Line {
    text: String,
    /// `None` for the header, a comment or an empty line.
    entry: Option<(u16, Channel)>,
}

/// Reads a line without its comment.
///
/// # Errors
/// What was expected instead.
fn parse_entry(content: &str) -> Result<(u16, Channel), &'static str> {
    let values: Vec<&str> = content.split(',').map(str::trim).collect();
    let [hinge, channel, zero, sign, lower, upper] = values[..] else {
        return Err("six values with commas between them");
    };
    let number = |text: &str| text.parse().ok().filter(|number: &f32| number.is_finite());
    let hinge = hinge
        .parse()
        .map_err(|_| "the number of a hinge of the sheet")?;
    let channel = Channel {
        channel: channel.parse().map_err(|_| "a channel from 0 to 65535")?,
        zero: number(zero).ok_or("zero as a number of radians")?,
        negative: match sign {
            "-" | "-1" => true,
            "+" | "1" | "+1" => false,
            _ => return Err("a sign, + or -"),
        },
        lower: number(lower).ok_or("lower as a number of radians")?,
        upper: number(upper).ok_or("upper as a number of radians")?,
    };
    if channel.lower > channel.upper {
        return Err("lower at or below upper");
    }
    Ok((hinge, channel))
}

/// Formats a line, with the shortest decimals that mean the same numbers.
fn line_of(hinge: u16, channel: Channel) -> String {
    let Channel {
        channel,
        zero,
        negative,
        lower,
        upper,
    } = channel;
    let sign = if negative { '-' } else { '+' };
    format!("{hinge},{channel},{zero},{sign},{lower},{upper}")
}

impl Channels {
    /// Parses the text of a map; `file` names it in errors.
    ///
    /// # Errors
    /// If a line has another form, or gives a hinge or a channel for the second time.
    pub fn parse(text: &str, file: &Path) -> Result<Self, FileError> {
        let mut this = Self::default();
        let mut headed = false;
        for (number, text) in (1..).zip(text.lines()) {
            let content = text.split('#').next().unwrap_or_default().trim();
            let wrong = |expected: String| {
                FileError::expected(file, format!("line {number}"), expected, content)
            };
            let entry = if content.is_empty() {
                None
            } else if headed {
                let (hinge, channel) = parse_entry(content).map_err(|it| wrong(it.into()))?;
                if this.get(hinge).is_some() {
                    return Err(wrong(format!("hinge {hinge} once")));
                }
                if this.owner(channel.channel).is_some() {
                    return Err(wrong(format!("channel {} once", channel.channel)));
                }
                Some((hinge, channel))
            } else if content == HEADER {
                headed = true;
                None
            } else {
                return Err(wrong(format!("the header {HEADER}")));
            };
            let text = text.to_string();
            this.lines.push(Line { text, entry });
        }
        Ok(this)
    }

    /// Iterates over the hinges and their channels, in the order of the lines.
    pub fn iter(&self) -> impl Iterator<Item = (u16, Channel)> {
        self.lines.iter().filter_map(|line| line.entry)
    }

    /// Returns the channel of a hinge, if the map has it.
    #[must_use]
    pub fn get(&self, hinge: u16) -> Option<Channel> {
        self.iter().find(|row| row.0 == hinge).map(|row| row.1)
    }

    /// Returns the hinge of a channel, if the map has one.
    #[must_use]
    pub fn owner(&self, channel: u16) -> Option<u16> {
        let mut rows = self.iter();
        rows.find(|row| row.1.channel == channel).map(|row| row.0)
    }

    /// Sets the channel of a hinge. Its line is written anew, without a comment that it had.
    pub fn set(&mut self, hinge: u16, channel: Channel) {
        if self.get(hinge) == Some(channel) {
            return;
        }
        let line = Line {
            text: line_of(hinge, channel),
            entry: Some((hinge, channel)),
        };
        let mine = |line: &&mut Line| line.entry.is_some_and(|entry| entry.0 == hinge);
        if let Some(old) = self.lines.iter_mut().find(mine) {
            *old = line;
            return;
        }
        if self.lines.iter().all(|line| line.text.trim() != HEADER) {
            let text = HEADER.to_string();
            self.lines.push(Line { text, entry: None });
        }
        self.lines.push(line);
    }

    /// Returns the first hinge below a mapped one that the map lacks.
    #[must_use]
    pub fn missing(&self) -> Option<u16> {
        let last = self.iter().map(|row| row.0).max()?;
        (0..last).find(|hinge| self.get(*hinge).is_none())
    }

    /// Formats the channels of all hinges as a constant in Rust, for the image of a board. The source needs
    /// `foldpath-controller` and no `std`.
    ///
    /// # Errors
    /// If the map [lacks](Self::missing) a hinge; the error is its number.
    pub fn rust(&self) -> Result<String, u16> {
        if let Some(hinge) = self.missing() {
            return Err(hinge);
        }
        let mut rows: Vec<(u16, Channel)> = self.iter().collect();
        rows.sort_by_key(|row| row.0);
        let mut text = format!(
            "// Channels of {} hinges. Written by `foldpath drive --rust`.\n\n\
             /// Channel of each hinge, in the pattern's order. Angles are in radians.\n\
             #[allow(clippy::approx_constant)]\n\
             pub const CHANNELS: &[foldpath_controller::Channel] = &[\n",
            rows.len()
        );
        for (_, channel) in rows {
            // `Debug` of numbers and booleans writes literals that mean the same value; writing to memory cannot fail.
            let _complete = writeln!(text, "    foldpath_controller::{channel:?},");
        }
        text += "];\n";
        Ok(text)
    }
}

/// Writes the text of the map, with LF at the end of each line.
impl fmt::Display for Channels {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        self.lines
            .iter()
            .try_for_each(|line| writeln!(f, "{}", line.text))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const TEXT: &str = "# left half\n\nhinge,channel,zero,sign,lower,upper\n1 , 7,-0.25,-,-1.5,0.1 # second\n0,3,1.5708,+,-1.6,1.6\n";

    fn parse(text: &str) -> Result<Channels, String> {
        Channels::parse(text, Path::new("map.csv")).map_err(|error| error.to_string())
    }

    #[test]
    fn what_does_not_change_stays_as_it_is() {
        let mut map = parse(TEXT).unwrap();
        assert_eq!(map.to_string(), TEXT);
        assert_eq!(
            parse(&TEXT.replace('\n', "\r\n")).unwrap().to_string(),
            TEXT
        );
        assert_eq!(
            map.get(1),
            Some(Channel {
                channel: 7,
                zero: -0.25,
                negative: true,
                lower: -1.5,
                upper: 0.1,
            })
        );
        let turned = Channel {
            negative: true,
            ..map.get(0).unwrap()
        };
        map.set(0, turned);
        let new = Channel {
            channel: 9,
            zero: 0.1,
            negative: false,
            lower: -1.0,
            upper: 1.0,
        };
        map.set(3, new);
        assert_eq!(map.missing(), Some(2));
        map.set(2, Channel { channel: 8, ..new });
        assert_eq!(
            (map.missing(), map.owner(9), map.owner(4)),
            (None, Some(3), None)
        );
        let text =
            TEXT.replace("0,3,1.5708,+", "0,3,1.5708,-") + "3,9,0.1,+,-1,1\n2,8,0.1,+,-1,1\n";
        assert_eq!(map.to_string(), text);
        assert_eq!(parse(&text).unwrap().get(3), Some(new));
        let mut first = Channels::default();
        first.set(0, new);
        assert_eq!(first.to_string(), format!("{HEADER}\n0,9,0.1,+,-1,1\n"));
    }

    #[test]
    fn the_rust_source_has_each_hinge_in_its_place() {
        let text = parse(TEXT).unwrap().rust().unwrap();
        let lines: Vec<&str> = text.lines().filter(|line| line.contains("zero")).collect();
        assert_eq!(
            lines,
            [
                "    foldpath_controller::Channel { channel: 3, zero: 1.5708, negative: false, lower: -1.6, upper: 1.6 },",
                "    foldpath_controller::Channel { channel: 7, zero: -0.25, negative: true, lower: -1.5, upper: 0.1 },",
            ]
        );
        assert_eq!(
            parse(&TEXT.replace("\n1 ,", "\n2 ,")).unwrap().rust(),
            Err(1)
        );
    }

    #[test]
    fn a_wrong_line_is_named() {
        let line = |row: &str| parse(&format!("{HEADER}\n{row}")).unwrap_err();
        for (row, message) in [
            (
                "0,1,0,+,0",
                "line 2: expected six values with commas between them, found 0,1,0,+,0",
            ),
            (
                "-1,1,0,+,0,1",
                "line 2: expected the number of a hinge of the sheet",
            ),
            ("0,x,0,+,0,1", "line 2: expected a channel from 0 to 65535"),
            (
                "0,1,inf,+,0,1",
                "line 2: expected zero as a number of radians",
            ),
            ("0,1,0,v,0,1", "line 2: expected a sign, + or -"),
            ("0,1,0,+,1,0", "line 2: expected lower at or below upper"),
            ("0,1,0,+,0,1\n0,2,0,+,0,1", "line 3: expected hinge 0 once"),
            (
                "0,1,0,+,0,1\n1,1,0,+,0,1",
                "line 3: expected channel 1 once",
            ),
        ] {
            let found = line(row);
            assert!(found.starts_with(&format!("map.csv: {message}")), "{found}");
        }
        let found = parse("0,1,0,+,0,1").unwrap_err();
        assert!(
            found.contains("line 1: expected the header hinge,"),
            "{found}"
        );
    }
}
