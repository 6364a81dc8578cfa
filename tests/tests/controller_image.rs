//! The controller's image in an emulator, with a host that streams a planned fold to it.

use std::fs;
use std::io::{ErrorKind, Read, Write};
use std::os::unix::net::{UnixListener, UnixStream};
use std::process::{Child, Command, Stdio};
use std::thread::sleep;
use std::time::{Duration, Instant};

use foldpath_core::wire::cobs::{self, Deframer};
use foldpath_core::wire::message::Item;
use foldpath_core::wire::path::PathItems;
use foldpath_core::wire::sender::{Options, Phase, Sender, Source};
use image::{TIME_LIMIT, image};
use tempfile::TempDir;

mod image;

/// An emulator that runs the image, and its lines.
struct Board {
    emulator: Child,
    line: UnixStream,
    #[allow(dead_code, reason = "an open line that is let go")]
    stop: UnixStream,
    start: Instant,
    _folder: TempDir,
}

impl Board {
    fn start(machine: &str) -> Self {
        let folder = tempfile::tempdir().unwrap();
        let names = ["line", "stop"];
        let listeners = names.map(|name| UnixListener::bind(folder.path().join(name)).unwrap());
        let mut command = Command::new("timeout");
        command.args(["--foreground", "--kill-after=5", TIME_LIMIT]);
        command.args(["qemu-system-arm", "-machine", machine]);
        command.args(["-display", "none", "-monitor", "none"]);
        for name in names {
            let path = folder.path().join(name);
            command.arg("-chardev");
            command.arg(format!("socket,id={name},path={}", path.display()));
            command.args(["-serial", &format!("chardev:{name}")]);
        }
        command.arg("-kernel").arg(image("foldpath-controller"));
        let mut emulator = command.stdin(Stdio::null()).spawn().expect("timeout starts");
        let [line, stop] = listeners.map(|listener| accept(&listener, &mut emulator));
        line.set_nonblocking(true).unwrap();
        Self {
            emulator,
            line,
            stop,
            start: Instant::now(),
            _folder: folder,
        }
    }

    /// Microseconds on the host's clock.
    fn now(&self) -> u64 {
        u64::try_from(self.start.elapsed().as_micros()).unwrap()
    }

    /// The bytes that have come.
    fn read(&mut self) -> Vec<u8> {
        let mut bytes = [0; 512];
        match self.line.read(&mut bytes) {
            Ok(0) => panic!("the emulator has ended"),
            Ok(count) => bytes[..count].to_vec(),
            Err(error) if error.kind() == ErrorKind::WouldBlock => Vec::new(),
            Err(error) => panic!("{error}"),
        }
    }

    /// Sends bytes as the line takes them.
    fn write(&mut self, mut bytes: &[u8]) {
        while !bytes.is_empty() {
            match self.line.write(bytes) {
                Ok(count) => bytes = &bytes[count..],
                Err(error) if error.kind() == ErrorKind::WouldBlock => pause(),
                Err(error) => panic!("{error}"),
            }
        }
    }
}

impl Drop for Board {
    fn drop(&mut self) {
        // `timeout` hands this on to the emulator, which the end of `timeout` alone would leave running.
        let id = self.emulator.id().to_string();
        let _ = Command::new("kill").args(["-TERM", &id]).status();
        let _ = self.emulator.wait();
    }
}

fn pause() {
    sleep(Duration::from_micros(500));
}

/// The emulator's end of a line, unless it has ended.
fn accept(listener: &UnixListener, emulator: &mut Child) -> UnixStream {
    listener.set_nonblocking(true).unwrap();
    loop {
        match listener.accept() {
            Ok((stream, _)) => return stream,
            Err(error) if error.kind() == ErrorKind::WouldBlock => pause(),
            Err(error) => panic!("{error}"),
        }
        if let Some(status) = emulator.try_wait().unwrap() {
            panic!("the emulator ended: {status}; `tests/run` installs it");
        }
    }
}

/// A path that is not known yet has no items.
struct Begin<'a>(Option<PathItems<'a>>);

impl Source for Begin<'_> {
    fn item<'b>(&self, index: u64, scratch: &'b mut [u8]) -> Option<Item<'b>> {
        self.0.as_ref()?.item(index, scratch)
    }
}

/// A host on the line of a board.
struct Host<'a> {
    sender: Sender,
    source: Begin<'a>,
    deframer: Deframer<512>,
}

impl Host<'_> {
    fn new(id: u32) -> Self {
        Self {
            sender: Sender::new(id, Options::default()),
            source: Begin(None),
            deframer: Deframer::default(),
        }
    }

    /// Sends and hears what there is.
    fn step(&mut self, board: &mut Board) {
        let (mut scratch, mut buffer) = ([0; 256], [0; 256]);
        let now = board.now();
        let frame = self
            .sender
            .poll(now, &self.source, &mut scratch, &mut buffer);
        if let Some(frame) = frame {
            let mut bytes = Vec::new();
            cobs::encode(frame, |byte| bytes.push(byte));
            board.write(&bytes);
        }
        let bytes = board.read();
        if frame.is_none() && bytes.is_empty() {
            pause();
        }
        let now = board.now();
        for byte in bytes {
            if let Some(frame) = self.deframer.push(byte) {
                self.sender.receive(frame, now);
            }
        }
        let phase = self.sender.phase();
        assert!(!matches!(phase, Phase::Failed(_)), "{phase:?}");
    }
}

#[test]
fn boots_and_answers() {
    for machine in ["mps2-an386", "mps2-an500"] {
        let mut board = Board::start(machine);
        let mut host = Host::new(5);
        while host.sender.report().is_none() {
            host.step(&mut board);
        }
        assert_eq!(host.sender.phase(), Phase::Open);
    }
}

/// What a real part would have to offer.
#[test]
fn the_image_is_small() {
    use object::{Object, ObjectSection};
    let bytes = fs::read(image("foldpath-controller")).unwrap();
    let elf = object::File::parse(&*bytes).unwrap();
    let size = |names: &[&str]| -> u64 {
        let sections = names.iter().filter_map(|name| elf.section_by_name(name));
        sections.map(|section| section.size()).sum()
    };
    let flash = size(&[".vector_table", ".text", ".rodata", ".data"]);
    let ram = size(&[".data", ".bss", ".uninit"]);
    assert!((1..=32 * 1024).contains(&flash), "{flash}");
    assert!((1..=6 * 1024).contains(&ram), "{ram}");
}
