//! The line from a command to a controller: its key, the host's numbers, and the link.

use std::io;
use std::path::{Path, PathBuf};

use foldpath::stream::{Link, Sim};
use foldpath_core::wire::key::Key;
use foldpath_core::wire::sender::Failure;

use crate::args::LineArgs;
use crate::link::{Emulator, Wire, default_image};
use crate::values::Target;
use crate::{CliError, key};

/// Reads the key for a line to a controller, if there is one.
///
/// # Errors
/// If the key cannot be read, if a line over a network has none, or if another line is to go without.
pub(crate) fn key(to: &Target, line: &LineArgs, quiet: bool) -> Result<Option<Key>, CliError> {
    let key = line.key.as_deref().map(|path| key::read(path, quiet));
    let key = key.transpose()?;
    if matches!(to, Target::Tcp(_)) && key.is_none() && !line.insecure {
        let what = "--to tcp: expected --key FILE, or --insecure: without a key anybody on the network may move its \
                    hinges";
        return Err(CliError::Usage(what.into()));
    }
    if line.insecure && !matches!(to, Target::Tcp(_)) {
        let what = "--insecure: expected --to tcp; other lines need no key";
        return Err(CliError::Usage(what.into()));
    }
    Ok(key)
}

/// Opens the line to a controller; sim is one of hinges without a sheet ([`Sim::bench`]). Returns its name and the link, or
/// why there is none.
///
/// # Errors
/// If there is no image for the emulated board.
pub(crate) fn open(
    to: &Target,
    line: &LineArgs,
    key: Option<Key>,
) -> Result<(String, io::Result<Box<dyn Link>>), CliError> {
    fn boxed(link: impl Link + 'static) -> Box<dyn Link> {
        Box::new(link)
    }
    Ok(match to {
        Target::Sim => {
            let sim = Sim::bench();
            let sim = match key {
                Some(key) => sim.with_key(key),
                None => sim,
            };
            ("sim".into(), Ok(boxed(sim)))
        }
        Target::Qemu => {
            let image = image(line.image.as_deref())?;
            let name = format!("qemu-system-arm with {}", image.display());
            (name, Emulator::start(&image, key).map(boxed))
        }
        Target::Serial(device) => {
            let link = Wire::open(device, line.baud);
            (format!("serial:{device}"), link.map(boxed))
        }
        Target::Tcp(address) => (format!("tcp:{address}"), Wire::connect(address).map(boxed)),
    })
}

/// Returns the file of the emulated board's image.
///
/// # Errors
/// If there is no such file, or none is named and none can be built.
fn image(named: Option<&Path>) -> Result<PathBuf, CliError> {
    match named {
        Some(image) if image.is_file() => Ok(image.to_path_buf()),
        Some(image) => {
            let image = image.display();
            let text = format!("--image: expected the file of an image, found none at {image}");
            Err(CliError::Usage(text))
        }
        None => default_image().map_err(|text| CliError::Usage(format!("--to qemu: {text}"))),
    }
}

/// Explains why there is no session, and which options help.
pub(crate) fn no_session(failure: Failure) -> String {
    match failure {
        Failure::NoAnswer => "no controller answers; one with a key answers only to --key FILE with the same key, and one \
                              without a key only without --key"
            .into(),
        Failure::Lost => format!("{failure}; --resume goes on from where the sheet stands"),
        failure => failure.to_string(),
    }
}

/// The host of a session: numbers that other sessions are unlikely to have had, and the key.
#[derive(Clone, Copy)]
pub(crate) struct Host {
    pub(crate) id: u32,
    pub(crate) nonce: u32,
    pub(crate) key: Option<Key>,
}

impl Host {
    /// # Errors
    /// If the operating system has no random number.
    pub(crate) fn new(key: Option<Key>) -> io::Result<Self> {
        let [a, b, c, d, upper @ ..] = key::nonce()?.to_le_bytes();
        Ok(Self {
            id: u32::from_le_bytes([a, b, c, d]),
            nonce: u32::from_le_bytes(upper),
            key,
        })
    }
}
