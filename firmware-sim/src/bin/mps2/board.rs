//! Arm's MPS2 board with the images AN386 and AN500, as QEMU emulates it. A port of the controller is another file like
//! this one.
//!
//! Interrupts carry bytes between the lines and queues, and do nothing else; the main loop does all other work. The
//! hinges are a [`Plant`], whose faults come over the third line, the bench.
#![allow(
    unsafe_code,
    reason = "registers, and RAM that a reset leaves as it is, are reached by address"
)]

use core::sync::atomic::{AtomicBool, Ordering};

use cortex_m::asm;
use cortex_m::peripheral::SCB;
use cortex_m::peripheral::syst::SystClkSource;
use cortex_m_rt::{ExceptionFrame, entry, exception};
use foldpath_controller::retained::{self, Records};
use foldpath_controller::stored;
use foldpath_controller::{Application, Board, Condition, Fifo, Line, Settings};
use foldpath_core::follower::{Measurement, Target};
use foldpath_core::wire::key::{Key, StoredKey};
use foldpath_core::wire::protection::Keyed;
use foldpath_core::{GroupLimits, Membership};
use foldpath_firmware_sim::plant::Plant;

use crate::sizes::{GROUPS, HINGES, KNOTS, SPOKES};
use registers::{Clock, MEGAHERTZ, NVIC_ENABLE, NVIC_PEND, read, write};

#[path = "registers.rs"]
mod registers;

/// The controller with its line to the host: queues that interrupts fill and empty.
type Controller =
    Application<Mps2, Line<'static, 256, 64, fn()>, GROUPS, HINGES, SPOKES, KNOTS, Keyed>;

/// Address of 8 random bytes, which whoever starts the emulator puts there; this board has no other source of them.
const NONCE: usize = 0x2030_0000;

/// Address of the words of the key: memory that stands for the flash of a real board. Erased words
/// are 0.
const KEY: usize = 0x2030_0008;

/// Limits of every hinge: half a turn each way, at the speed of the drives.
const LIMITS: GroupLimits = GroupLimits {
    lower: -core::f32::consts::PI,
    upper: core::f32::consts::PI,
    speed: 6.0,
    acceleration: f32::INFINITY,
};

/// Microseconds after which the watchdog warns. After as many again it resets the board.
const PATIENCE_US: u32 = 1_000_000;

/// Registers of the memory protection unit.
const MPU_CONTROL: usize = 0xe000_ed94;
const MPU_REGION: usize = 0xe000_ed9c;
const MPU_KIND: usize = 0xe000_eda0;
/// Address of the guard, the lowest 2¹⁰ bytes of the stack, which nothing may touch.
const GUARD: u32 = 0x2000_0000;

/// Number of interrupts that have handlers. The board has more, which are not enabled.
const HANDLERS: usize = 5;
/// Numbers of the lines' interrupts.
const RECEIVED: i16 = 0;
const SENT: i16 = 1;
const STOP_RECEIVED: i16 = 2;
const BENCH_RECEIVED: i16 = 4;

/// Bytes from the host that wait for the main loop. Bytes without room are lost, and sent again.
static INCOMING: Fifo<256> = Fifo::new();
/// Bytes for the host that wait for the line.
static OUTGOING: Fifo<64> = Fifo::new();
/// `true` if the stop line was drawn since the main loop last asked.
static DRAWN: AtomicBool = AtomicBool::new(false);

/// Records that a reset leaves as they are.
// SAFETY: the section is not written at start, and every value of a byte is valid.
#[unsafe(link_section = ".uninit.records")]
static RECORDS: Records<{ Mps2::RECORD }> = Records::new();

/// The hinges, which a reset leaves as they are. The emulator's memory is 0 when it starts.
// SAFETY: as above: any bytes are a valid plant.
#[unsafe(link_section = ".uninit.plant")]
static PLANT: Plant<GROUPS> = Plant::new();

/// A CMSDK UART, which holds one byte in each direction; its address.
#[derive(Clone, Copy)]
struct Uart(usize);

/// The line to the host.
const HOST: Uart = Uart(0x4000_4000);
/// The stop line. Any byte on it draws it.
const STOP: Uart = Uart(0x4000_5000);
/// The bench.
const BENCH: Uart = Uart(0x4000_6000);

impl Uart {
    const STATE: usize = 0x4;
    const CONTROL: usize = 0x8;
    const INTERRUPTS: usize = 0xc;
    const DIVISOR: usize = 0x10;

    /// Enables reception and transmission, with interrupts for both.
    fn enable(self) {
        write(self.0 + Self::DIVISOR, 16);
        write(self.0 + Self::CONTROL, 0b1111);
    }

    /// Returns the byte that has come, if there is one.
    fn receive(self) -> Option<u8> {
        if read(self.0 + Self::STATE) & 0b10 == 0 {
            return None;
        }
        let [byte, ..] = read(self.0).to_le_bytes();
        Some(byte)
    }

    /// Returns `true` if a byte can be sent.
    fn is_free(self) -> bool {
        read(self.0 + Self::STATE) & 0b01 == 0
    }

    fn send(self, byte: u8) {
        write(self.0, byte.into());
    }

    fn acknowledge(self, interrupts: u32) {
        write(self.0 + Self::INTERRUPTS, interrupts);
    }
}

/// The stop line, the hinges and the memory of the board, and its clock.
struct Mps2(Clock);

impl Board for Mps2 {
    /// Each round of the main loop reads the clock.
    fn now(&mut self) -> u64 {
        self.0.now()
    }

    fn stop(&mut self) -> bool {
        DRAWN.swap(false, Ordering::Relaxed)
    }

    /// The drives of this board have no power to switch: without a command they hold where they are.
    fn power(&mut self, _: &Condition) {}

    fn drive(
        &mut self,
        hinge: u32,
        membership: Membership,
        target: Option<Target<f32>>,
    ) -> Option<Measurement<f32>> {
        let Some(Target { angle, .. }) = target else {
            return PLANT.measure(hinge, membership).map(Into::into);
        };
        #[allow(clippy::cast_possible_truncation, reason = "differences matter")]
        let now = self.0.micros as u32;
        PLANT.drive(hinge, membership, angle, now).map(Into::into)
    }

    /// The emulated drives hold where they are, in a reset as well.
    fn held(&mut self) -> bool {
        true
    }

    const RECORD: usize = retained::size(GROUPS);

    fn keep(&mut self, record: usize, at: usize, bytes: &[u8]) {
        RECORDS.keep(record, at, bytes);
    }

    fn kept(&mut self, record: usize, at: usize, bytes: &mut [u8]) {
        RECORDS.kept(record, at, bytes);
    }

    fn key(&mut self) -> StoredKey {
        let mut words = [0; stored::WORDS];
        for (address, word) in (KEY..).step_by(4).zip(&mut words) {
            *word = read(address);
        }
        stored::open(&words, 0)
    }

    fn store_key(&mut self, key: &Key) -> bool {
        for (address, word) in (KEY..).step_by(4).zip(stored::words(key)) {
            write(address, word);
        }
        self.key() == StoredKey::Key(*key)
    }

    fn feed(&mut self) {
        registers::feed();
    }
}

/// Starts the guard of the stack, the clock, the watchdog and a wake-up each millisecond.
fn start() -> Clock {
    // The region of 2^(9 + 1) bytes allows no access. All other memory, and all memory in the fault's handler, is as
    // without protection.
    write(MPU_REGION, GUARD | 1 << 4);
    write(MPU_KIND, 1 << 28 | 9 << 1 | 1);
    write(MPU_CONTROL, 0b101);
    asm::dsb();
    asm::isb();
    let clock = Clock::start(PATIENCE_US);
    if let Some(mut core) = cortex_m::Peripherals::take() {
        core.SYST.set_clock_source(SystClkSource::Core);
        core.SYST.set_reload(1000 * MEGAHERTZ - 1);
        core.SYST.clear_current();
        core.SYST.enable_counter();
        core.SYST.enable_interrupt();
    }
    clock
}

/// Memory of the controller. The discriminants make `None` all zeros, so that its initial value takes no flash.
#[allow(clippy::large_enum_variant, reason = "there is one, for ever")]
#[repr(u8)]
enum Memory {
    None,
    Some(Controller),
}

#[entry]
fn main() -> ! {
    static mut MEMORY: Memory = Memory::None;
    let clock = start();
    let draws = [NONCE, NONCE + 4].map(|address| read(address).into());
    let settings = Settings {
        // The emulated hinges hang on any sheet.
        closed: false,
        // Whoever reaches the sockets of the emulator could read its memory as well.
        pairs: true,
        ..Settings::new(draws, |_| LIMITS)
    };
    let line = Line {
        incoming: &INCOMING,
        outgoing: &OUTGOING,
        // Only the interrupt takes bytes from the queue, so set it pending.
        wake: (|| write(NVIC_PEND, 1 << SENT)) as fn(),
    };
    *MEMORY = Memory::Some(Application::new(Mps2(clock), line, settings));
    // The lines come last: while nothing ticks, QEMU may leave received bytes lying for a second.
    HOST.enable();
    STOP.enable();
    BENCH.enable();
    write(NVIC_ENABLE, 0b10111);
    loop {
        if let Memory::Some(controller) = MEMORY {
            controller.step();
            if controller.is_busy() {
                continue;
            }
        }
        // A pending interrupt ends the wait although interrupts are masked here; its handler runs behind this closure.
        cortex_m::interrupt::free(|_| {
            if INCOMING.is_empty() && !DRAWN.load(Ordering::Relaxed) {
                asm::wfi();
            }
        });
    }
}

/// Handles the interrupts of the lines. The watchdog's warning and unexpected interrupts are ignored.
#[exception]
unsafe fn DefaultHandler(interrupt: i16) {
    match interrupt {
        RECEIVED => {
            HOST.acknowledge(0b10);
            if let Some(byte) = HOST.receive() {
                let _ = INCOMING.add(byte);
            }
        }
        SENT => {
            HOST.acknowledge(0b01);
            if HOST.is_free()
                && let Some(byte) = OUTGOING.take()
            {
                HOST.send(byte);
            }
        }
        STOP_RECEIVED => {
            STOP.acknowledge(0b10);
            if STOP.receive().is_some() {
                DRAWN.store(true, Ordering::Relaxed);
            }
        }
        BENCH_RECEIVED => {
            BENCH.acknowledge(0b10);
            if let Some(byte) = BENCH.receive() {
                PLANT.hear(byte);
            }
        }
        _ => {}
    }
}

/// Wakes the main loop.
#[exception]
fn SysTick() {}

/// Resets the board after a fault, such as that of a stack that has grown into its guard.
#[exception]
unsafe fn HardFault(_: &ExceptionFrame) -> ! {
    SCB::sys_reset()
}

// SAFETY: there is no such function, so that the image links only if nothing in it can panic.
unsafe extern "C" {
    safe fn something_can_panic() -> !;
}

#[panic_handler]
fn panic(_: &core::panic::PanicInfo<'_>) -> ! {
    something_can_panic()
}
