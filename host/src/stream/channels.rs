//! Edits the map from hinges to channels, which boards read as a [`HingeMap`](foldpath_firmware_sim::controller::HingeMap). Other than
//! that, this map may lack hinges: it grows while a board is commissioned. Lines that do not change stay as they are.

use core::fmt;
use std::path::Path;

pub use foldpath_firmware_sim::controller::map::Channel;
use foldpath_firmware_sim::controller::map::{Entry, Flaw, HEADER};

use crate::read::FileError;

/// A map that people and [`Bench`](super::Bench) fill.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Channels {
    lines: Vec<Line>,
}

#[derive(Clone, Debug, PartialEq)]
struct Line {
    text: String,
    /// `None` for the header, a comment or an empty line.
    entry: Option<Entry>,
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
            let wrong = |flaw: Flaw| {
                FileError::expected(file, format!("line {number}"), flaw.to_string(), content)
            };
            let entry = if content.is_empty() {
                None
            } else if headed {
                let entry = Entry::parse(content).map_err(wrong)?;
                let (hinge, channel) = (entry.hinge, entry.channel.channel);
                if this.get(hinge).is_some() {
                    return Err(wrong(Flaw::HingeTwice(hinge)));
                }
                if this.owner(channel).is_some() {
                    return Err(wrong(Flaw::ChannelTwice(channel)));
                }
                Some(entry)
            } else if content == HEADER {
                headed = true;
                None
            } else {
                return Err(wrong(Flaw::Header));
            };
            let text = text.to_string();
            this.lines.push(Line { text, entry });
        }
        Ok(this)
    }

    /// Iterates over the hinges and their channels, in the order of the lines.
    pub fn iter(&self) -> impl Iterator<Item = (u16, Channel)> {
        let entries = self.lines.iter().filter_map(|line| line.entry);
        entries.map(|Entry { hinge, channel }| (hinge, channel))
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
        let entry = Entry { hinge, channel };
        let line = Line {
            text: entry.to_string(),
            entry: Some(entry),
        };
        let mine = |line: &&mut Line| line.entry.is_some_and(|entry| entry.hinge == hinge);
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
    use foldpath_firmware_sim::controller::HingeMap;

    const TEXT: &str = "# left half\n\nhinge,channel,zero,sign,lower,upper\n1 , 7,-0.25,-,-1.5,0.1 # second\n0,3,1.5708,+,-1.6,1.6\n";

    fn parse(text: &str) -> Result<Channels, String> {
        Channels::parse(text, Path::new("map.csv")).map_err(|error| error.to_string())
    }

    /// What is written is what boards read.
    #[test]
    fn what_does_not_change_stays_as_it_is() {
        let mut map = parse(TEXT).unwrap();
        assert_eq!(map.to_string(), TEXT);
        assert_eq!(
            parse(&TEXT.replace('\n', "\r\n")).unwrap().to_string(),
            TEXT
        );
        let board = HingeMap::<2>::parse(TEXT).unwrap();
        for hinge in [0, 1] {
            assert_eq!(map.get(hinge).as_ref(), board.channel(hinge.into()));
        }
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
        let board = HingeMap::<4>::parse(&text).unwrap();
        assert_eq!(
            (board.channel(0), board.channel(3)),
            (Some(&turned), Some(&new))
        );
        let mut first = Channels::default();
        first.set(0, new);
        assert_eq!(
            HingeMap::<1>::parse(&first.to_string()).unwrap().channel(0),
            Some(&new)
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
                "line 2: expected zero as a decimal number of radians",
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
