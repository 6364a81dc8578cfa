//! The map that `foldpath drive` edits, and its file.

use core::f32::consts::PI;
use core::fmt;
use std::collections::BTreeMap;
use std::io::ErrorKind;
use std::path::{Path, PathBuf};

use serde::Serialize;

use crate::CliError;
use crate::output::write_whole;
use crate::standard::is_standard;
use foldpath::read::FileError;
use foldpath::stream::{Channel, Channels};

/// A hinge and its channel as people read them: angles are in degrees.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub(super) struct Row {
    pub(super) hinge: u16,
    channel: u16,
    zero: f64,
    sign: char,
    lower: f64,
    upper: f64,
}

impl Row {
    fn new(hinge: u16, channel: Channel) -> Self {
        let degrees = |angle: f32| f64::from(angle).to_degrees();
        Self {
            hinge,
            channel: channel.channel,
            zero: degrees(channel.zero),
            sign: if channel.negative { '-' } else { '+' },
            lower: degrees(channel.lower),
            upper: degrees(channel.upper),
        }
    }
}

impl fmt::Display for Row {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self {
            hinge,
            channel,
            zero,
            sign,
            lower,
            upper,
        } = self;
        write!(
            f,
            "hinge {hinge}: channel {channel}, zero {zero:.3} degrees, sign {sign}, limits {lower:.3} to {upper:.3} degrees"
        )
    }
}

/// A map and its file.
pub(super) struct MapFile {
    pub(super) path: Option<PathBuf>,
    /// File of the map's Rust source.
    rust: Option<PathBuf>,
    map: Channels,
    /// Channels with which the controller runs: those of the file as it was read, and those of hinges that are new.
    running: BTreeMap<u16, Channel>,
    pub(super) changed: bool,
}

impl MapFile {
    /// Reads the map of a file, which need not be there. `rust` is where its Rust source is to go.
    ///
    /// # Errors
    /// If the file cannot be read, or is no map.
    pub(super) fn read(path: Option<&Path>, rust: Option<&Path>) -> Result<Self, CliError> {
        for (option, path) in [("--map", path), ("--rust", rust)] {
            if path.is_some_and(is_standard) {
                let text = format!("{option}: expected the name of a file, found -");
                return Err(CliError::Usage(text));
            }
        }
        let map = match path.map(|path| (path, std::fs::read_to_string(path))) {
            None => Channels::default(),
            Some((path, Ok(text))) => Channels::parse(&text, path)?,
            Some((_, Err(error))) if error.kind() == ErrorKind::NotFound => Channels::default(),
            Some((path, Err(error))) => return Err(FileError::io(path)(error).into()),
        };
        Ok(Self {
            path: path.map(Path::to_path_buf),
            rust: rust.map(Path::to_path_buf),
            running: map.iter().collect(),
            map,
            changed: false,
        })
    }

    /// Writes the file, and its Rust source if that has a file. Each is written whole or not at all. Returns what to say:
    /// an error if the source was asked for and the map lacks a hinge.
    ///
    /// # Errors
    /// If the system refuses.
    pub(super) fn save(&mut self) -> Result<Result<String, String>, CliError> {
        let Some(path) = &self.path else {
            return Ok(Ok(String::new()));
        };
        write_whole(path, self.map.to_string().as_bytes())?;
        self.changed = false;
        let count = self.map.iter().count();
        let said = format!("{count} hinges written to {}", path.display());
        let lacks = |hinge| {
            format!(
                "{said}; hinge {hinge} has no channel yet, and a board needs one for each hinge"
            )
        };
        let Some(rust) = &self.rust else {
            let missing = self.map.missing();
            return Ok(Ok(missing.map_or(said.clone(), lacks)));
        };
        match self.map.rust() {
            Ok(source) => {
                write_whole(rust, source.as_bytes())?;
                Ok(Ok(format!("{said} and {}", rust.display())))
            }
            Err(hinge) => {
                let said = lacks(hinge);
                Ok(Err(format!("{said}; {} was not written", rust.display())))
            }
        }
    }

    pub(super) fn rows(&self) -> Vec<Row> {
        let rows = self
            .map
            .iter()
            .map(|(hinge, channel)| Row::new(hinge, channel));
        let mut rows: Vec<Row> = rows.collect();
        rows.sort_by_key(|row| row.hinge);
        rows
    }

    pub(super) fn get(&self, hinge: u16) -> Option<Channel> {
        self.map.get(hinge)
    }

    fn set(&mut self, hinge: u16, channel: Channel) -> Row {
        self.changed |= self.map.get(hinge) != Some(channel);
        self.map.set(hinge, channel);
        self.running.entry(hinge).or_insert(channel);
        Row::new(hinge, channel)
    }

    fn edit(&mut self, hinge: u16, edit: impl FnOnce(&mut Channel)) -> Result<Row, String> {
        let mut channel = self.get(hinge).ok_or_else(|| lacks(hinge))?;
        edit(&mut channel);
        Ok(self.set(hinge, channel))
    }

    /// Gives a hinge a channel. A hinge that is new to the map is flat at 0 and may turn half a turn each way.
    pub(super) fn channel(&mut self, hinge: u16, number: u16) -> Result<Row, String> {
        if let Some(owner) = self.map.owner(number).filter(|owner| *owner != hinge) {
            return Err(format!("channel {number} is that of hinge {owner}"));
        }
        let mut channel = self.get(hinge).unwrap_or(Channel {
            channel: number,
            zero: 0.0,
            negative: false,
            lower: -PI,
            upper: PI,
        });
        channel.channel = number;
        Ok(self.set(hinge, channel))
    }

    /// Says that a hinge is flat at this angle (radians), as the controller now has it.
    pub(super) fn zero(&mut self, hinge: u16, angle: f32) -> Result<Row, String> {
        let raw = self.running.get(&hinge).map(|channel| channel.raw(angle));
        self.edit(hinge, |channel| channel.zero = raw.unwrap_or(channel.zero))
    }

    pub(super) fn sign(&mut self, hinge: u16, negative: bool) -> Result<Row, String> {
        self.edit(hinge, |channel| channel.negative = negative)
    }

    /// Returns what is wrong with an angle (radians, as the controller now has it) that is beyond the limits of a hinge.
    pub(super) fn beyond(&self, hinge: u16, angle: f32) -> Option<String> {
        let (channel, running) = (self.get(hinge)?, self.running.get(&hinge)?);
        let angle = channel.angle(running.raw(angle));
        let row = Row::new(hinge, channel);
        let degrees = f64::from(angle).to_degrees();
        // As far as an angle is told.
        let within = degrees >= row.lower - 1e-3 && degrees <= row.upper + 1e-3;
        (!within).then(|| {
            let Row { lower, upper, .. } = row;
            format!(
                "hinge {hinge}: expected an angle within its limits in the map, {lower:.3} to {upper:.3} degrees, found {degrees:.3}"
            )
        })
    }

    pub(super) fn limits(&mut self, hinge: u16, [lower, upper]: [f32; 2]) -> Result<Row, String> {
        self.edit(hinge, |channel| {
            (channel.lower, channel.upper) = (lower, upper)
        })
    }
}

pub(super) fn lacks(hinge: u16) -> String {
    format!("the map has no hinge {hinge}; `channel {hinge} CHANNEL` gives it a channel")
}
