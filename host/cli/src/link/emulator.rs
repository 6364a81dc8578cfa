//! Runs a controller in QEMU.

use core::time::Duration;
use std::env;
use std::io::{self, ErrorKind, Write};
use std::net::{TcpListener, TcpStream};
use std::path::{Path, PathBuf};
use std::process::{Child, Command, Stdio};
use std::thread::sleep;
use std::time::Instant;

use foldpath::stream::Link;
use foldpath_controller::stored;
use foldpath_core::wire::key::Key;
use tempfile::NamedTempFile;

use super::Wire;
use crate::key::nonce;

const TARGET: &str = "thumbv7em-none-eabihf";
/// Name of the image.
const NAME: &str = "foldpath-mps2";
/// Arguments of the cargo command that builds the image.
const BUILD: [&str; 10] = [
    "build",
    "--locked",
    "--profile",
    "firmware",
    "--target",
    TARGET,
    "-p",
    "foldpath-firmware-sim",
    "--bin",
    NAME,
];
/// Environment variables with settings for the host that must not affect the build for the board.
const FOR_THE_HOST: [&str; 4] = [
    "CARGO_BUILD_TARGET",
    "CARGO_ENCODED_RUSTFLAGS",
    "RUSTC_WRAPPER",
    "RUSTFLAGS",
];
/// Longest time that the emulator may take to open its lines.
const PATIENCE: Duration = Duration::from_secs(10);

/// Returns the controller's image of this workspace, and builds it if it is missing. Cargo prints its progress on stderr.
///
/// # Errors
/// If the image cannot be built. Outside the workspace, the text names the command that builds it.
pub fn default_image() -> Result<PathBuf, String> {
    let command = format!("cargo {}", BUILD.join(" "));
    let here = env::current_dir().map_err(|error| error.to_string())?;
    let root = here
        .ancestors()
        .find(|folder| folder.join("firmware-sim/Cargo.toml").is_file())
        .ok_or_else(|| {
            format!(
                "no image: expected --image FILE, which `{command}` builds in foldpath's folder"
            )
        })?;
    let target = env::var_os("CARGO_TARGET_DIR").map_or_else(|| root.join("target"), PathBuf::from);
    let target = std::path::absolute(target).map_err(|error| error.to_string())?;
    let image = |folder: &Path| folder.join(TARGET).join("firmware").join(NAME);
    let places = [image(&target), image(&target.join("fw"))];
    if let Some(found) = places.iter().find(|place| place.is_file()) {
        return Ok(found.clone());
    }
    let mut cargo = Command::new(env::var_os("CARGO").unwrap_or_else(|| "cargo".into()));
    cargo.args(BUILD).arg("--target-dir").arg(&target);
    cargo
        .current_dir(root)
        .stdin(Stdio::null())
        .stdout(Stdio::null());
    for setting in FOR_THE_HOST {
        cargo.env_remove(setting);
    }
    let status = cargo.status();
    let [image, _] = places;
    match status {
        Ok(status) if status.success() && image.is_file() => Ok(image),
        Ok(status) => Err(format!("no image: `{command}` ended with {status}")),
        Err(error) => Err(format!("no image: `{command}`: {error}")),
    }
}

/// An emulated board that runs an image. The emulator ends when this value is dropped.
#[derive(Debug)]
pub struct Emulator {
    line: Wire<TcpStream>,
    stop: TcpStream,
    /// The emulator reads it when it starts. It goes after the process.
    _memory: NamedTempFile,
    _process: Process,
}

impl Emulator {
    /// Starts `qemu-system-arm` with the image. The first serial line carries messages, the second is the stop line. The key is
    /// put where the image expects it.
    ///
    /// # Errors
    /// If there is no QEMU or no image, or the emulator ends at once.
    pub fn start(image: &Path, key: Option<Key>) -> io::Result<Self> {
        // An image that cannot be read fails here, because QEMU would say only that it cannot load the image.
        std::fs::File::open(image)?;
        let listeners = [listen()?, listen()?];
        let mut command = Command::new("qemu-system-arm");
        command.args(["-machine", "mps2-an386", "-display", "none"]);
        command.args(["-monitor", "none"]);
        for (number, listener) in listeners.iter().enumerate() {
            let port = listener.local_addr()?.port();
            command.arg("-chardev");
            command.arg(format!("socket,id=line{number},host=127.0.0.1,port={port}"));
            command.args(["-serial", &format!("chardev:line{number}")]);
        }
        let memory = memory(key)?;
        let file = memory.path().display().to_string().replace(',', ",,");
        command.arg("-device");
        command.arg(format!("loader,file={file},addr=0x20300000,force-raw=on"));
        command.args(["-semihosting-config", "enable=on,target=native"]);
        command.arg("-kernel").arg(image);
        command.stdin(Stdio::null()).stdout(Stdio::null());
        #[cfg(unix)]
        {
            // In a process group of its own the emulator gets no Ctrl-C. Ctrl-C is for the host, which has to brake
            // first.
            use std::os::unix::process::CommandExt;
            command.process_group(0);
        }
        let mut process = Process(command.spawn()?);
        let [line, stop] = &listeners;
        Ok(Self {
            line: Wire::over(process.accept(line)?)?,
            stop: process.accept(stop)?,
            _memory: memory,
            _process: process,
        })
    }
}

/// Returns a file with the board's random number and the words of its key, for the addresses where it expects them. The
/// file is private to its owner; the arguments of a process are not.
fn memory(key: Option<Key>) -> io::Result<NamedTempFile> {
    let words = key.map_or([0; stored::WORDS], |key| stored::words(&key));
    let mut file = NamedTempFile::new()?;
    file.write_all(&nonce()?.to_le_bytes())?;
    for word in words {
        file.write_all(&word.to_le_bytes())?;
    }
    file.flush()?;
    Ok(file)
}

fn listen() -> io::Result<TcpListener> {
    let listener = TcpListener::bind(("127.0.0.1", 0))?;
    listener.set_nonblocking(true)?;
    Ok(listener)
}

/// A process that is killed when this value is dropped.
#[derive(Debug)]
struct Process(Child);

impl Process {
    /// Waits until the process connects to `listener`, and returns the connection.
    fn accept(&mut self, listener: &TcpListener) -> io::Result<TcpStream> {
        let start = Instant::now();
        loop {
            match listener.accept() {
                Ok((stream, _)) => return Ok(stream),
                Err(error) if error.kind() == ErrorKind::WouldBlock => {}
                Err(error) => return Err(error),
            }
            if let Some(status) = self.0.try_wait()? {
                return Err(io::Error::other(format!("the emulator ended: {status}")));
            }
            if start.elapsed() > PATIENCE {
                return Err(ErrorKind::TimedOut.into());
            }
            sleep(Duration::from_millis(1));
        }
    }
}

impl Drop for Process {
    fn drop(&mut self) {
        let _ended = self.0.kill();
        let _status = self.0.wait();
    }
}

impl Link for Emulator {
    fn now(&self) -> u64 {
        self.line.now()
    }

    fn is_free(&self) -> bool {
        self.line.is_free()
    }

    fn write(&mut self, frame: &[u8]) -> io::Result<()> {
        self.line.write(frame)
    }

    fn read(&mut self) -> io::Result<Option<u8>> {
        self.line.read()
    }

    fn wait(&mut self) -> io::Result<()> {
        self.line.wait()
    }

    fn stop(&mut self) -> io::Result<bool> {
        self.stop.write_all(&[1])?;
        Ok(true)
    }
}
