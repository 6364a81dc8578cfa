//! Values of arguments that are parsed from text.

use core::str::FromStr;

use foldpath_firmware_sim::faults::Faults;
use foldpath_firmware_sim::hinges::Drive;

use foldpath::Vector3;

/// Value `I/N` of `--shard`: one part of N, numbered from 0.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Shard {
    pub(crate) index: u32,
    pub(crate) of: u32,
}

impl Default for Shard {
    fn default() -> Self {
        Self { index: 0, of: 1 }
    }
}

impl FromStr for Shard {
    type Err = &'static str;

    fn from_str(text: &str) -> Result<Self, Self::Err> {
        let parse = || {
            let (index, of) = text.split_once('/')?;
            let shard = Self {
                index: index.parse().ok()?,
                of: of.parse().ok()?,
            };
            (shard.index < shard.of).then_some(shard)
        };
        parse().ok_or("expected I/N, a part from 0 to N-1 of N parts")
    }
}

/// Controller, and the line to it.
#[derive(Clone, Debug)]
pub(crate) enum Target {
    Sim,
    Qemu,
    Serial(String),
    Tcp(String),
}

impl FromStr for Target {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        match text.split_once(':') {
            None if text == "sim" => Ok(Self::Sim),
            None if text == "qemu" => Ok(Self::Qemu),
            Some(("serial", device)) if !device.is_empty() => Ok(Self::Serial(device.into())),
            Some(("tcp", address)) if is_address(address) => Ok(Self::Tcp(address.into())),
            Some(("tcp", _)) => {
                Err("expected tcp:HOST:PORT or tcp:PORT, the port a number from 1 to 65535".into())
            }
            _ => Err("expected sim, qemu, serial:DEVICE, tcp:HOST:PORT or tcp:PORT".into()),
        }
    }
}

/// Returns `true` if `text` is `HOST:PORT` or a port alone. A host that contains colons has to be in brackets.
fn is_address(text: &str) -> bool {
    let (host, port) = match text.rsplit_once(':') {
        Some((host, port)) => (Some(host), port),
        None => (None, text),
    };
    let known = |host: &str| {
        let bare = host
            .strip_prefix('[')
            .and_then(|host| host.strip_suffix(']'));
        !host.is_empty() && (bare.is_some() || !host.contains(':'))
    };
    host.is_none_or(known) && port.parse::<u16>().is_ok_and(|port| port > 0)
}

/// Properties `KEY=VALUE,KEY=VALUE`, and the seed from which chance is drawn, which is one of the pairs.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Seeded<T> {
    pub(crate) value: T,
    pub(crate) seed: u64,
}

/// Properties that are numbers from 0 on.
pub(crate) trait Properties: Default + 'static {
    /// The largest number, and the range in words.
    const MOST: (f64, &str);
    /// The properties by their names.
    const ALL: &[Property<Self>];
}

/// A property by its name.
type Property<T> = (&'static str, fn(&mut T) -> &mut f64);

impl Properties for Faults {
    const MOST: (f64, &str) = (1.0, "0 to 1");
    const ALL: &[Property<Self>] = &[
        ("drop", |it| &mut it.drop),
        ("flip", |it| &mut it.flip),
        ("double", |it| &mut it.double),
        ("reorder", |it| &mut it.reorder),
    ];
}

impl Properties for Drive {
    const MOST: (f64, &str) = (f64::INFINITY, "0 or more");
    const ALL: &[Property<Self>] = &[
        ("lag", |it| &mut it.lag),
        ("speed", |it| &mut it.speed),
        ("acceleration", |it| &mut it.acceleration),
        ("play", |it| &mut it.play),
        ("noise", |it| &mut it.noise),
    ];
}

impl<T: Properties> FromStr for Seeded<T> {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let mut this = Self::default();
        let (most, range) = T::MOST;
        for pair in text.split(',') {
            let Some((key, value)) = pair.split_once('=') else {
                return Err(format!("expected KEY=VALUE, found {pair}"));
            };
            if key == "seed" {
                let seed = value.parse();
                this.seed = seed.map_err(|_| format!("seed: expected a number, found {value}"))?;
                continue;
            }
            let Some((_, property)) = T::ALL.iter().find(|(name, _)| *name == key) else {
                let names: Vec<&str> = T::ALL.iter().map(|(name, _)| *name).collect();
                let names = names.join(", ");
                return Err(format!("expected {names} or seed, found {key}"));
            };
            let number = value.parse().ok();
            let number = number.filter(|number| (0.0..=most).contains(number));
            *property(&mut this.value) =
                number.ok_or_else(|| format!("{key}: expected {range}, found {value}"))?;
        }
        Ok(this)
    }
}

/// Value `X,Y,Z` of `--gravity`.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Gravity(pub(crate) Vector3<f64>);

impl FromStr for Gravity {
    type Err = &'static str;

    fn from_str(text: &str) -> Result<Self, Self::Err> {
        let numbers: Option<Vec<f64>> = text
            .split(',')
            .map(|part| part.trim().parse().ok())
            .collect();
        match numbers.as_deref() {
            Some([x, y, z]) if [x, y, z].iter().all(|it| it.abs() <= 1e6) => {
                Ok(Self(Vector3::new(*x, *y, *z)))
            }
            _ => Err("expected X,Y,Z, three numbers from -1e6 to 1e6"),
        }
    }
}

/// Value `NM_PER_RAD` of `--spring`, or `I=NM_PER_RAD` for the hinge at edge I.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Spring {
    pub(crate) edge: Option<u32>,
    pub(crate) stiffness: f64,
}

impl FromStr for Spring {
    type Err = &'static str;

    fn from_str(text: &str) -> Result<Self, Self::Err> {
        let (edge, number) = match text.split_once('=') {
            Some((edge, number)) => {
                let edge = edge.trim().parse();
                (
                    Some(edge.map_err(|_| "expected I=NUMBER, with the number of an edge")?),
                    number,
                )
            }
            None => (None, text),
        };
        let stiffness = zero_or_above(number.trim())?;
        Ok(Self { edge, stiffness })
    }
}

/// Largest number that an argument may be.
const LARGEST: f64 = 1e12;

/// Parses a number above 0.
pub(crate) fn above_zero(text: &str) -> Result<f64, &'static str> {
    let number = zero_or_above(text).ok().filter(|number| *number > 0.0);
    number.ok_or("expected a number above 0, at most 1e12")
}

/// Parses a number that is not negative.
pub(crate) fn zero_or_above(text: &str) -> Result<f64, &'static str> {
    let number = text
        .parse()
        .ok()
        .filter(|number| (0.0..=LARGEST).contains(number));
    number.ok_or("expected a number from 0 to 1e12")
}
