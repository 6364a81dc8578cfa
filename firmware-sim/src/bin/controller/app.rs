//! The controller on its board. Interrupts tick it, receive into a ring, and send from one; the main loop decodes and
//! answers. Nothing waits: what an interrupt shares with the main loop is locked for one byte at a time.

use core::cell::RefCell;

use cortex_m_rt::{entry, exception};
use critical_section::Mutex;
use foldpath_firmware_sim::controller::{Controller, Settings};
use heapless::Deque;

use crate::mps2;

/// Bytes that wait for the main loop at the most. What finds no room is lost, and sent again.
const RECEIVED: usize = 256;
/// Bytes that are decoded before something is said.
const BURST: usize = 64;

/// Two groups, and the hinges of a Miura fold of 24 x 24 faces.
type Device = Controller<2, 1104, 16, 16>;

struct App {
    device: Device,
    clock: Clock,
    received: Deque<u8, RECEIVED>,
    /// Whether there was a tick since the watchdog was fed.
    ticked: bool,
}

/// The memory of the controller. Its numbers make all of `Empty` zero, which takes no flash.
#[repr(u8)]
enum Slot {
    Empty,
    Full(App),
}

static APP: Mutex<RefCell<Slot>> = Mutex::new(RefCell::new(Slot::Empty));

/// Microseconds since the start, which do not wrap if asked for at least every 171 s.
#[derive(Default)]
struct Clock {
    count: u32,
    rest: u32,
    micros: u64,
}

impl Clock {
    fn now(&mut self) -> u64 {
        let count = mps2::count();
        let passed = count.wrapping_sub(self.count);
        let rest = self.rest + passed % mps2::MEGAHERTZ;
        self.count = count;
        self.rest = rest % mps2::MEGAHERTZ;
        self.micros += u64::from(passed / mps2::MEGAHERTZ + rest / mps2::MEGAHERTZ);
        self.micros
    }
}

impl App {
    /// Decodes a received byte; returns whether there was one.
    fn decode(&mut self) -> bool {
        let byte = self.received.pop_front();
        if let Some(byte) = byte {
            self.device.byte(byte, self.clock.now());
        }
        byte.is_some()
    }

    /// Answers, and feeds the watchdog if the ticks go on too.
    fn answer(&mut self) {
        self.device.poll(self.clock.now());
        self.send();
        if core::mem::take(&mut self.ticked) {
            mps2::feed();
        }
    }

    /// Sends a byte if the line is free, which interrupts when it is again.
    fn send(&mut self) {
        if mps2::HOST.is_free()
            && let Some(byte) = self.device.take()
        {
            mps2::HOST.send(byte);
        }
    }
}

/// Does something with the controller, which no interrupt does meanwhile.
fn with<R>(act: impl FnOnce(&mut App) -> R) -> Option<R> {
    critical_section::with(|section| {
        match &mut *APP.borrow(section).try_borrow_mut().ok()? {
            Slot::Empty => None,
            Slot::Full(app) => Some(act(app)),
        }
    })
}

#[entry]
fn main() -> ! {
    critical_section::with(|section| {
        if let Ok(mut app) = APP.borrow(section).try_borrow_mut() {
            *app = Slot::Full(App {
                device: Device::new(Settings::default()),
                clock: Clock::default(),
                received: Deque::new(),
                ticked: false,
            });
        }
    });
    mps2::start();
    loop {
        let mut decoded = 0;
        while decoded < BURST && with(App::decode) == Some(true) {
            decoded += 1;
        }
        with(App::answer);
        // A pending interrupt ends the wait, though it is taken only behind it.
        with(|app| {
            if app.received.is_empty() {
                cortex_m::asm::wfi();
            }
        });
    }
}

/// A byte of the host has come.
pub(crate) fn received() {
    with(|app| {
        if let Some(byte) = mps2::HOST.receive() {
            let _ = app.received.push_back(byte);
        }
    });
}

/// The line to the host is free.
pub(crate) fn sent() {
    with(App::send);
}

/// The stop line says something: 0 lets it go, anything else draws it.
pub(crate) fn stop() {
    if let Some(byte) = mps2::STOP.receive() {
        with(|app| app.device.stop(byte != 0));
    }
}

#[exception]
fn SysTick() {
    with(|app| {
        app.device.tick(app.clock.now());
        app.ticked = true;
    });
}

/// Nothing in the image panics: a test looks for this message in it. The watchdog would reset.
#[panic_handler]
fn panic(_: &core::panic::PanicInfo<'_>) -> ! {
    loop {
        for byte in *b"the controller panicked\n" {
            mps2::HOST.send(byte);
        }
    }
}
