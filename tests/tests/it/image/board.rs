//! An emulator that runs the controller's image, and its lines.

use core::time::Duration;
use std::io::{ErrorKind, Read, Write};
use std::os::unix::net::{UnixListener, UnixStream};
use std::path::Path;
use std::process::{Child, Command, Stdio};
use std::thread::sleep;

use tempfile::TempDir;

use super::image;

/// Names of the emulator's sockets: the line to the host, the stop line, the test bench, and the monitor.
const SOCKETS: [&str; 4] = ["line", "stop", "bench", "monitor"];
/// First address above the stack.
const STACK_TOP: u32 = 0x2001_8000;
/// First address above the guard, which is 1 KiB long.
const GUARD_END: u32 = 0x2000_0400;

/// A running board.
pub(crate) struct Board {
    emulator: Child,
    line: UnixStream,
    stop: UnixStream,
    bench: UnixStream,
    monitor: UnixStream,
    folder: TempDir,
}

impl Board {
    /// Starts an emulator of `machine`. An instruction takes 2⁵ ns, about a cycle of the board's clock. With real time
    /// instead, the board's watchdog would bite while the emulator waits for this machine.
    pub(crate) fn start(machine: &str) -> Self {
        let nonce = 1 + u64::from(std::process::id());
        Self::run(
            machine,
            "foldpath-mps2-small",
            &["-icount", "shift=5"],
            nonce,
        )
    }

    /// Starts an emulator of `machine` whose time passes as fast as it can: 30 to 60 times as fast as that of this machine.
    /// The board has not begun if it is `frozen`.
    pub(crate) fn fast(machine: &str, image: &str, nonce: u64, frozen: bool) -> Self {
        let mut arguments = vec!["-icount", "shift=6,sleep=off"];
        arguments.extend(frozen.then_some("-S"));
        Self::run(machine, image, &arguments, nonce)
    }

    /// Starts an emulator of `machine` as [`fast`](Self::fast) does, with four times as many instructions in a second: enough to
    /// measure 1,104 hinges in each tick.
    pub(crate) fn strong(machine: &str, image: &str, nonce: u64) -> Self {
        Self::run(machine, image, &["-icount", "shift=4,sleep=off"], nonce)
    }

    /// Starts an emulator of `machine` with these further `arguments`, and with this nonce at the address where the board
    /// expects its random number.
    fn run(machine: &str, name: &str, arguments: &[&str], nonce: u64) -> Self {
        let folder = tempfile::tempdir().unwrap();
        let path = |name: &str| folder.path().join(name);
        let listeners = SOCKETS.map(|name| UnixListener::bind(path(name)).unwrap());
        let mut command = Command::new("timeout");
        command.args(["--foreground", "--kill-after=5", "300"]);
        command.args(["qemu-system-arm", "-machine", machine]);
        command.args(["-display", "none", "-monitor", "none"]);
        for name in SOCKETS {
            let socket = path(name);
            command.arg("-chardev");
            command.arg(format!("socket,id={name},path={}", socket.display()));
        }
        for name in &SOCKETS[..3] {
            command.args(["-serial", &format!("chardev:{name}")]);
        }
        // This is the monitor for people. The monitor for programs has a thread, which the emulator would wake at each
        // byte of a line.
        command.args(["-mon", "chardev=monitor,mode=readline"]);
        command.args(arguments);
        command
            .arg("-device")
            .arg(format!("loader,addr=0x20300000,data={nonce:#x},data-len=8"));
        command.arg("-kernel").arg(image(name));
        let mut emulator = command
            .stdin(Stdio::null())
            .spawn()
            .expect("timeout starts");
        let [line, stop, bench, monitor] =
            listeners.map(|listener| accept(&listener, &mut emulator));
        line.set_nonblocking(true).unwrap();
        let mut board = Self {
            emulator,
            line,
            stop,
            bench,
            monitor,
            folder,
        };
        board.answer();
        board
    }

    /// Returns the bytes that have come.
    pub(crate) fn read(&mut self) -> Vec<u8> {
        let mut bytes = [0; 4096];
        match self.line.read(&mut bytes) {
            Ok(0) => panic!("the emulator has ended"),
            Ok(count) => bytes[..count].to_vec(),
            Err(error) if error.kind() == ErrorKind::WouldBlock => Vec::new(),
            Err(error) => panic!("{error}"),
        }
    }

    /// Returns the bytes that come within a millisecond.
    pub(crate) fn wait(&mut self) -> Vec<u8> {
        self.line.set_nonblocking(false).unwrap();
        let patience = Some(Duration::from_millis(1));
        self.line.set_read_timeout(patience).unwrap();
        let bytes = self.read();
        self.line.set_nonblocking(true).unwrap();
        bytes
    }

    /// Sends bytes and returns the number of bytes that the line took.
    pub(crate) fn write(&mut self, bytes: &[u8]) -> usize {
        match self.line.write(bytes) {
            Ok(count) => count,
            Err(error) if error.kind() == ErrorKind::WouldBlock => 0,
            Err(error) => panic!("{error}"),
        }
    }

    /// Draws the stop line.
    pub(crate) fn draw_stop(&mut self) {
        self.stop.write_all(b"!").unwrap();
    }

    /// Makes hinges fail; the plant defines the texts.
    pub(crate) fn bench(&mut self, text: &str) {
        self.bench.write_all(text.as_bytes()).unwrap();
    }

    /// Stops the time of the board.
    pub(crate) fn freeze(&mut self) {
        self.order("stop");
    }

    /// Lets the time of the board go on.
    pub(crate) fn thaw(&mut self) {
        self.order("cont");
    }

    /// Resets a frozen board, whose memory stays as it is, and lets its time go on.
    pub(crate) fn reset(&mut self) {
        self.order("system_reset");
        self.thaw();
    }

    /// Returns the microseconds of the board's clock modulo 171.8 s, from the count of its timer.
    pub(crate) fn micros(&mut self) -> u64 {
        u64::from(self.passed()) / 25
    }

    /// Returns how long ago the board told this time, which was less than 171.8 s ago.
    pub(crate) fn since(&mut self, micros: u64) -> Duration {
        let then = u32::try_from(25 * micros % (1 << 32)).unwrap();
        let passed = self.passed().wrapping_sub(then);
        Duration::from_micros(u64::from(passed) / 25)
    }

    /// Returns the time that the timer counts, at 25 MHz, modulo 2³². The timer runs down, and is 0 before it starts.
    fn passed(&mut self) -> u32 {
        let answer = self.monitor("xp /1wx 0x40000004");
        let (_, count) = answer.split_once(": 0x").expect("an address and a word");
        let count = u32::from_str_radix(&count[..8], 16).unwrap();
        if count == 0 { 0 } else { u32::MAX - count }
    }

    /// Returns `size` bytes of the board's memory.
    pub(crate) fn memory(&mut self, address: usize, size: usize) -> Vec<u8> {
        let file = self.folder.path().join("memory");
        let name = Path::display(&file);
        self.order(&format!("pmemsave {address} {size} \"{name}\""));
        std::fs::read(file).unwrap()
    }

    /// Moves everything on the stack of a frozen board down, as if calls went deep, to `left` bytes above the guard,
    /// and lets its time go on.
    pub(crate) fn deepen_stack(&mut self, left: u32) {
        const PART: usize = 1024;
        let mut debugger = self.debugger();
        let old = u32::from_str_radix(&debugger.ask("pd"), 16)
            .unwrap()
            .swap_bytes();
        assert!((GUARD_END..STACK_TOP).contains(&old), "{old:x}");
        let size = STACK_TOP - old;
        // The stack pointer is a multiple of 8, and frames on the stack record whether it was one of 4.
        let new = GUARD_END + left / 8 * 8 + old % 8;
        assert!(new + size <= old);
        let bytes = debugger.ask(&format!("m{old:x},{size:x}"));
        // The emulator takes orders of at most 4 kB.
        for (part, digits) in (0..).zip(bytes.as_bytes().chunks(2 * PART)) {
            let (at, digits) = (new as usize + part * PART, str::from_utf8(digits).unwrap());
            debugger.tell(&format!("M{at:x},{:x}:{digits}", digits.len() / 2));
        }
        debugger.tell(&format!("Pd={:08x}", new.swap_bytes()));
        debugger.tell("D");
    }

    /// Makes a function of a frozen board jump to itself at its beginning, and lets the board's time go on.
    pub(crate) fn hang(&mut self, function: u64) {
        let mut debugger = self.debugger();
        debugger.tell(&format!("M{function:x},2:fee7"));
        debugger.tell("D");
    }

    /// Writes bytes into the memory of a frozen board, and lets its time go on.
    pub(crate) fn fill(&mut self, address: u64, bytes: &[u8]) {
        let mut debugger = self.debugger();
        for (part, bytes) in (0..).zip(bytes.chunks(1024)) {
            let digits: String = bytes.iter().map(|byte| format!("{byte:02x}")).collect();
            let at = address + 1024 * part;
            debugger.tell(&format!("M{at:x},{:x}:{digits}", bytes.len()));
        }
        debugger.tell("D");
    }

    fn debugger(&mut self) -> Debugger {
        let socket = self.folder.path().join("debugger");
        let listener = UnixListener::bind(&socket).unwrap();
        self.monitor(&format!("gdbserver unix:{}", socket.display()));
        let mut debugger = Debugger(accept(&listener, &mut self.emulator));
        // The emulator allows no change of a single register before the registers were listed.
        debugger.ask("qXfer:features:read:target.xml:0,1000");
        debugger
    }

    /// Gives the emulator a command that has no answer.
    fn order(&mut self, command: &str) {
        assert_eq!(self.monitor(command), "", "{command}");
    }

    /// Gives the emulator a command and returns its answer.
    fn monitor(&mut self, command: &str) -> String {
        writeln!(self.monitor, "{command}").unwrap();
        self.answer()
    }

    /// Returns the monitor's text behind the echo of a command, up to its next prompt.
    fn answer(&mut self) -> String {
        let mut bytes = Vec::new();
        while !bytes.ends_with(b"(qemu) ") {
            let mut piece = [0; 4096];
            let count = self.monitor.read(&mut piece).unwrap();
            assert!(count > 0, "the emulator has ended");
            bytes.extend(&piece[..count]);
        }
        let text = String::from_utf8_lossy(&bytes[..bytes.len() - 7]);
        let (_, answer) = text.split_once("\r\n").unwrap();
        answer.to_owned()
    }
}

/// A connection in GDB's remote protocol.
struct Debugger(UnixStream);

impl Debugger {
    /// Sends a command and returns the answer.
    fn ask(&mut self, command: &str) -> String {
        let sum = |text: &str| text.bytes().fold(0_u8, u8::wrapping_add);
        write!(self.0, "${command}#{:02x}", sum(command)).unwrap();
        let mut answer = Vec::new();
        // An answer consists of an acknowledgement, `$`, the text, `#`, and the checksum.
        while answer.iter().rev().nth(2) != Some(&b'#') {
            let mut byte = [0];
            self.0.read_exact(&mut byte).unwrap();
            answer.extend(byte);
        }
        self.0.write_all(b"+").unwrap();
        let answer = String::from_utf8_lossy(&answer);
        let (_, answer) = answer.split_once('$').unwrap();
        answer[..answer.len() - 3].to_owned()
    }

    #[track_caller]
    fn tell(&mut self, command: &str) {
        assert_eq!(self.ask(command), "OK", "{command}");
    }
}

impl Drop for Board {
    fn drop(&mut self) {
        let _ = self.monitor.write_all(b"quit\n");
        for _ in 0..1000 {
            if let Ok(Some(_)) = self.emulator.try_wait() {
                return;
            }
            pause();
        }
        // `timeout` forwards this signal to the emulator. Ending `timeout` alone would leave the emulator running.
        let id = self.emulator.id().to_string();
        let _ = Command::new("kill").args(["-TERM", &id]).status();
        let _ = self.emulator.wait();
    }
}

/// Waits for a millisecond.
pub(crate) fn pause() {
    sleep(Duration::from_millis(1));
}

/// Accepts the emulator's end of a line. Panics if the emulator has ended.
fn accept(listener: &UnixListener, emulator: &mut Child) -> UnixStream {
    listener.set_nonblocking(true).unwrap();
    loop {
        match listener.accept() {
            Ok((stream, _)) => {
                stream.set_nonblocking(false).unwrap();
                return stream;
            }
            Err(error) if error.kind() == ErrorKind::WouldBlock => pause(),
            Err(error) => panic!("{error}"),
        }
        if let Some(status) = emulator.try_wait().unwrap() {
            panic!("the emulator ended: {status}; `tests/run` installs it");
        }
    }
}
