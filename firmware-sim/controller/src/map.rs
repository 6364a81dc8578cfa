//! Which channel of the drives moves which hinge, and how: a text that people edit, checked by the compiler or at start.
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
//! follows a `#` are ignored.

use core::fmt;

use foldpath_core::GroupLimits;

use crate::decimal;

/// The first line of a map.
pub const HEADER: &str = "hinge,channel,zero,sign,lower,upper";
const HEADER_BYTES: &[u8] = HEADER.as_bytes();

/// The channel of a hinge.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Channel {
    /// Number of the channel.
    pub channel: u16,
    /// Angle of the channel while the hinge is flat, radians.
    pub zero: f32,
    /// `true` if the channel turns against the hinge.
    pub negative: bool,
    /// Smallest and largest angle of the hinge, radians.
    pub lower: f32,
    /// See `lower`.
    pub upper: f32,
}

/// A line of a map.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Entry {
    /// Number of the hinge, in the pattern's order.
    pub hinge: u16,
    /// Its channel.
    pub channel: Channel,
}

impl Entry {
    /// Reads a line without its comment.
    ///
    /// # Errors
    /// The first flaw. Every number of 16 bits is that of a hinge here.
    pub const fn parse(line: &str) -> Result<Self, Flaw> {
        entry(line.as_bytes(), 1 << 16)
    }
}

/// Writes the line, with the shortest decimals that mean the same numbers.
impl fmt::Display for Entry {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { hinge, channel } = self;
        let Channel {
            channel,
            zero,
            negative,
            lower,
            upper,
        } = channel;
        let sign = if *negative { '-' } else { '+' };
        write!(f, "{hinge},{channel},{zero},{sign},{lower},{upper}")
    }
}

/// The channels of hinges 0 to `N - 1`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct HingeMap<const N: usize> {
    channels: [Channel; N],
}

/// A mistake in a map, and its line, counted from 1. A hinge that has no line is reported with the number of the last line
/// plus 1.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[non_exhaustive]
pub struct MapError {
    /// Number of the line.
    pub line: u32,
    /// The mistake in it.
    pub flaw: Flaw,
}

/// A mistake in a line of a map.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[non_exhaustive]
pub enum Flaw {
    /// The first line that is not ignored is not [`HEADER`].
    Header,
    /// The line does not have six values.
    Values,
    /// The hinge is no number, or a hinge beyond those of the map.
    Hinge,
    /// The channel is no number from 0 to 65,535.
    Channel,
    /// The zero is no number.
    Zero,
    /// The sign is neither `+` nor `-`.
    Sign,
    /// The smallest angle is no number.
    Lower,
    /// The largest angle is no number.
    Upper,
    /// The smallest angle is larger than the largest.
    Order,
    /// An earlier line has this hinge.
    HingeTwice(u16),
    /// An earlier line has this channel.
    ChannelTwice(u16),
    /// No line has this hinge.
    Missing(u16),
}

impl fmt::Display for MapError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "line {}: expected {}", self.line, self.flaw)
    }
}

/// Tells what was expected.
impl fmt::Display for Flaw {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Header => write!(f, "the header {HEADER}"),
            Self::Values => f.write_str("six values with commas between them"),
            Self::Hinge => f.write_str("the number of a hinge of the sheet"),
            Self::Channel => f.write_str("a channel from 0 to 65535"),
            Self::Zero => f.write_str("zero as a decimal number of radians"),
            Self::Sign => f.write_str("a sign, + or -"),
            Self::Lower => f.write_str("lower as a decimal number of radians"),
            Self::Upper => f.write_str("upper as a decimal number of radians"),
            Self::Order => f.write_str("lower at or below upper"),
            Self::HingeTwice(hinge) => write!(f, "hinge {hinge} once"),
            Self::ChannelTwice(channel) => write!(f, "channel {channel} once"),
            Self::Missing(hinge) => write!(f, "a line for hinge {hinge}"),
        }
    }
}

impl core::error::Error for MapError {}

/// Unwraps a result in a constant: `const MAP: HingeMap<4> = map::checked(HingeMap::parse(include_str!("map.csv")))`. A
/// text that is no map does not compile.
///
/// # Panics
/// If the text is no map. Call it only where the compiler evaluates it.
#[allow(clippy::panic, reason = "evaluated by the compiler")]
#[must_use]
pub const fn checked<const N: usize>(map: Result<HingeMap<N>, MapError>) -> HingeMap<N> {
    match map {
        Ok(map) => map,
        Err(MapError { flaw, .. }) => match flaw {
            Flaw::Header => panic!("expected the header hinge,channel,zero,sign,lower,upper"),
            Flaw::Values => panic!("expected six values in each line"),
            Flaw::Hinge => panic!("expected the number of a hinge of the sheet"),
            Flaw::Channel => panic!("expected the number of a channel"),
            Flaw::Zero => panic!("zero: expected a decimal number of radians"),
            Flaw::Sign => panic!("sign: expected + or -"),
            Flaw::Lower => panic!("lower: expected a decimal number of radians"),
            Flaw::Upper => panic!("upper: expected a decimal number of radians"),
            Flaw::Order => panic!("expected lower at or below upper"),
            Flaw::HingeTwice(_) => panic!("a hinge has two lines"),
            Flaw::ChannelTwice(_) => panic!("a channel has two lines"),
            Flaw::Missing(_) => panic!("a hinge has no line"),
        },
    }
}

impl<const N: usize> HingeMap<N> {
    /// Reads a map from its text.
    ///
    /// # Errors
    /// The first flaw, with the number of its line.
    #[allow(
        clippy::indexing_slicing,
        reason = "checked indices: constant functions have no `get` for arrays"
    )]
    pub const fn parse(text: &str) -> Result<Self, MapError> {
        const { assert!(N <= 1 << 16, "hinges have numbers of 16 bits") };
        let mut text = text.as_bytes();
        let mut channels = [Channel {
            channel: 0,
            zero: 0.0,
            negative: false,
            lower: 0.0,
            upper: 0.0,
        }; N];
        let mut known = [false; N];
        let (mut line, mut headed) = (1, false);
        while !text.is_empty() {
            let (content, behind) = split(text, b'\n');
            let (content, _) = split(content, b'#');
            text = match behind {
                Some(behind) => behind,
                None => &[],
            };
            if !content.is_empty() {
                if !headed {
                    if !matches!(content, HEADER_BYTES) {
                        return flawed(line, Flaw::Header);
                    }
                    headed = true;
                } else {
                    let Entry { hinge, channel } = match entry(content, N) {
                        Ok(entry) => entry,
                        Err(flaw) => return flawed(line, flaw),
                    };
                    if known[hinge as usize] {
                        return flawed(line, Flaw::HingeTwice(hinge));
                    }
                    let mut other = 0;
                    while other < N {
                        if known[other] && channels[other].channel == channel.channel {
                            return flawed(line, Flaw::ChannelTwice(channel.channel));
                        }
                        other += 1;
                    }
                    known[hinge as usize] = true;
                    channels[hinge as usize] = channel;
                }
            }
            line += 1;
        }
        if !headed {
            return flawed(line, Flaw::Header);
        }
        let mut hinge = 0_u16;
        while (hinge as usize) < N {
            if !known[hinge as usize] {
                return flawed(line, Flaw::Missing(hinge));
            }
            if hinge == u16::MAX {
                break;
            }
            hinge += 1;
        }
        Ok(Self { channels })
    }

    /// Returns the channel of a hinge; `None` if there is no such hinge.
    #[must_use]
    pub fn channel(&self, hinge: u32) -> Option<&Channel> {
        self.channels.get(usize::try_from(hinge).ok()?)
    }

    /// Returns the limits of a hinge for [`Settings::limits`](crate::Settings::limits), with this largest speed (radians per
    /// second) and acceleration (radians per second squared). Those of a hinge that is not in the map are no range, so that
    /// a sheet with more hinges is refused.
    ///
    /// `Settings::limits` is a function without data of its own. It reads a map that is a constant or in a `static`:
    ///
    /// ```
    /// use foldpath_controller::{HingeMap, Settings, map};
    ///
    /// const TEXT: &str = "hinge,channel,zero,sign,lower,upper\n0,3,1.5708,+,-1.6,1.6\n";
    /// static MAP: HingeMap<1> = map::checked(HingeMap::parse(TEXT));
    ///
    /// let settings = Settings::new(1, |hinge| MAP.limits(hinge, 6.0, f32::INFINITY));
    /// assert!((settings.limits)(0).are_sound() && !(settings.limits)(1).are_sound());
    /// ```
    #[must_use]
    pub fn limits(&self, hinge: u32, speed: f32, acceleration: f32) -> GroupLimits {
        let range = self.channel(hinge);
        GroupLimits {
            lower: range.map_or(f32::NAN, |channel| channel.lower),
            upper: range.map_or(f32::NAN, |channel| channel.upper),
            speed,
            acceleration,
        }
    }
}

impl Channel {
    /// Returns the angle of the channel at which the hinge has this angle, radians.
    #[must_use]
    pub fn raw(&self, angle: f32) -> f32 {
        if self.negative {
            self.zero - angle
        } else {
            self.zero + angle
        }
    }

    /// Returns the angle of the hinge at this angle of the channel, radians.
    #[must_use]
    pub fn angle(&self, raw: f32) -> f32 {
        if self.negative {
            self.zero - raw
        } else {
            raw - self.zero
        }
    }
}

/// Writes the text that [`HingeMap::parse`] reads.
impl<const N: usize> fmt::Display for HingeMap<N> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        writeln!(f, "{HEADER}")?;
        for (hinge, channel) in (0..=u16::MAX).zip(self.channels) {
            writeln!(f, "{}", Entry { hinge, channel })?;
        }
        Ok(())
    }
}

const fn flawed<const N: usize>(line: u32, flaw: Flaw) -> Result<HingeMap<N>, MapError> {
    Err(MapError { line, flaw })
}

/// Returns the text before the first such byte, without the spaces at its ends, and the text behind that byte if there is
/// one.
const fn split(text: &[u8], byte: u8) -> (&[u8], Option<&[u8]>) {
    let mut rest = text;
    while let [first, behind @ ..] = rest {
        if *first == byte {
            let (before, _) = text.split_at(text.len() - rest.len());
            return (before.trim_ascii(), Some(behind));
        }
        rest = behind;
    }
    (text.trim_ascii(), None)
}

/// Unwraps a value, or returns the flaw of the line without it: constant functions have no `?`.
macro_rules! or {
    ($value:expr, $flaw:expr) => {
        match $value {
            Some(value) => value,
            None => return Err($flaw),
        }
    };
}

/// Reads a line: the number of a hinge below `hinges`, and its channel.
const fn entry(line: &[u8], hinges: usize) -> Result<Entry, Flaw> {
    let (hinge, rest) = split(line, b',');
    let (channel, rest) = split(or!(rest, Flaw::Values), b',');
    let (zero, rest) = split(or!(rest, Flaw::Values), b',');
    let (sign, rest) = split(or!(rest, Flaw::Values), b',');
    let (lower, rest) = split(or!(rest, Flaw::Values), b',');
    let (upper, None) = split(or!(rest, Flaw::Values), b',') else {
        return Err(Flaw::Values);
    };
    let hinge = or!(decimal::whole(hinge), Flaw::Hinge);
    if hinge as usize >= hinges {
        return Err(Flaw::Hinge);
    }
    let channel = or!(decimal::whole(channel), Flaw::Channel);
    let zero = or!(decimal::number(zero), Flaw::Zero);
    let negative = match sign {
        b"-" | b"-1" => true,
        b"+" | b"1" | b"+1" => false,
        _ => return Err(Flaw::Sign),
    };
    let lower = or!(decimal::number(lower), Flaw::Lower);
    let upper = or!(decimal::number(upper), Flaw::Upper);
    if lower > upper {
        return Err(Flaw::Order);
    }
    let channel = Channel {
        channel,
        zero,
        negative,
        lower,
        upper,
    };
    Ok(Entry { hinge, channel })
}

#[cfg(test)]
#[allow(
    clippy::unwrap_used,
    clippy::indexing_slicing,
    reason = "a test may panic"
)]
mod tests {
    use std::string::ToString;
    use std::{format, vec::Vec};

    use super::{Flaw, HEADER, HingeMap, MapError, checked};

    const TEXT: &str = "# Servos.\r\n\r\nhinge,channel,zero,sign,lower,upper\r\n\
        1 , 7, -0.25 ,-, -1.5,0.1# the second\r\n0,3,1.57,+,-1.6,1.6\r\n#\n  2,0,0,-1,0,0";
    /// Read by the compiler.
    const MAP: HingeMap<3> = checked(HingeMap::parse(TEXT));

    #[test]
    fn a_map_is_read_by_the_compiler_and_comes_back_from_its_text() {
        assert_eq!(HingeMap::parse(TEXT), Ok(MAP));
        let text = MAP.to_string();
        assert_eq!(
            text,
            format!("{HEADER}\n0,3,1.57,+,-1.6,1.6\n1,7,-0.25,-,-1.5,0.1\n2,0,0,-,0,0\n")
        );
        let again = HingeMap::<3>::parse(&text).unwrap();
        assert_eq!((again, again.to_string()), (MAP, text));
    }

    #[test]
    fn angles_go_to_channels_and_back() {
        let channel = |hinge| *MAP.channel(hinge).unwrap();
        assert_eq!((channel(0).channel, channel(1).channel), (3, 7));
        assert_eq!(channel(0).raw(0.5).to_bits(), (1.57_f32 + 0.5).to_bits());
        assert_eq!(channel(1).raw(0.5).to_bits(), (-0.75_f32).to_bits());
        assert_eq!(channel(1).angle(-0.75).to_bits(), 0.5_f32.to_bits());
        assert!((channel(0).angle(channel(0).raw(0.5)) - 0.5).abs() < 1e-6);
        assert_eq!(MAP.channel(3), None);
        let limits = MAP.limits(1, 6.0, f32::INFINITY);
        assert_eq!(
            (limits.lower.to_bits(), limits.upper.to_bits()),
            ((-1.5_f32).to_bits(), 0.1_f32.to_bits())
        );
        assert!(limits.are_sound() && !MAP.limits(3, 6.0, 1.0).are_sound());
    }

    #[test]
    fn what_is_wrong_is_told_with_its_line() {
        let cases: [(&[&str], u32, Flaw); 19] = [
            (&["hinge,channel"], 1, Flaw::Header),
            (&[], 2, Flaw::Header),
            (&["# nothing"], 2, Flaw::Header),
            (&[HEADER, "0,1,0,+,0"], 2, Flaw::Values),
            (&[HEADER, "0,1,0,+,0,1,"], 2, Flaw::Values),
            (&[HEADER, "0,1,0,+,0,1#", "x"], 3, Flaw::Values),
            (&[HEADER, "", "2,1,0,+,0,1"], 3, Flaw::Hinge),
            (&[HEADER, "-1,1,0,+,0,1"], 2, Flaw::Hinge),
            (&[HEADER, "0,65536,0,+,0,1"], 2, Flaw::Channel),
            (&[HEADER, "0,1,zero,+,0,1"], 2, Flaw::Zero),
            (&[HEADER, "0,1,nan,+,0,1"], 2, Flaw::Zero),
            (&[HEADER, "0,1,0,*,0,1"], 2, Flaw::Sign),
            (&[HEADER, "0,1,0,+,,1"], 2, Flaw::Lower),
            (&[HEADER, "0,1,0,+,0,1e2"], 2, Flaw::Upper),
            (&[HEADER, "0,1,0,+,0,inf"], 2, Flaw::Upper),
            (&[HEADER, "0,1,0,+,1,0.5"], 2, Flaw::Order),
            (
                &[HEADER, "0,1,0,+,0,1", "0,2,0,+,0,1"],
                3,
                Flaw::HingeTwice(0),
            ),
            (
                &[HEADER, "0,1,0,+,0,1", "1,1,0,+,0,1"],
                3,
                Flaw::ChannelTwice(1),
            ),
            (&[HEADER, "0,1,0,+,0,1"], 3, Flaw::Missing(1)),
        ];
        for (lines, line, flaw) in cases {
            for end in ["\n", "\r\n"] {
                let text: Vec<_> = lines.iter().map(|line| format!("{line}{end}")).collect();
                let line = if lines.is_empty() { 1 } else { line };
                let error = MapError { line, flaw };
                assert_eq!(
                    HingeMap::<2>::parse(&text.concat()),
                    Err(error),
                    "{lines:?}"
                );
                assert!(error.to_string().starts_with(&format!("line {line}: ")));
            }
        }
    }

    /// No text makes the parser panic.
    #[test]
    fn changed_texts_are_maps_or_flaws() {
        let mut state = 3_u32;
        let mut random = |below: usize| {
            state = state.wrapping_mul(747_796_405).wrapping_add(2_891_336_453);
            (state >> 8) as usize % below
        };
        for _ in 0..20_000 {
            let mut text: Vec<u8> = TEXT.bytes().collect();
            for _ in 0..=random(3) {
                let place = random(text.len());
                let byte = b"0129.,+-#\n\r xe"[random(14)];
                match random(3) {
                    0 => text[place] = byte,
                    1 => text.insert(place, byte),
                    _ => drop(text.remove(place)),
                }
            }
            let text = std::string::String::from_utf8(text).unwrap();
            if let Ok(map) = HingeMap::<3>::parse(&text) {
                assert_eq!(HingeMap::parse(&map.to_string()), Ok(map));
            }
        }
    }
}
