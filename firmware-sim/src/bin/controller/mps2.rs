//! Arm's MPS2 board with the images AN386 and AN500, as QEMU emulates it: all that touches memory by its address.
#![allow(
    unsafe_code,
    reason = "registers, and RAM that a reset leaves as it is, are reached by address"
)]

use core::ptr;

use cortex_m::peripheral::syst::SystClkSource;
use cortex_m_rt::exception;

/// Counts of [`count`] in a microsecond.
pub(crate) const MEGAHERTZ: u32 = 25;
/// Counts after which the watchdog warns, and once more, resets: 1 s.
const PATIENCE: u32 = 1_000_000 * MEGAHERTZ;

const TIMER: usize = 0x4000_0000;
const WATCHDOG: usize = 0x4000_8000;
/// Enables the interrupts 0 to 31.
const NVIC_ISER: usize = 0xe000_e100;

/// A CMSDK UART: one byte each way, no FIFO.
#[derive(Clone, Copy)]
pub(crate) struct Uart(usize);

/// To the host.
pub(crate) const HOST: Uart = Uart(0x4000_4000);
/// The stop line.
pub(crate) const STOP: Uart = Uart(0x4000_5000);

impl Uart {
    const STATE: usize = 0x4;
    const CONTROL: usize = 0x8;
    const INTERRUPTS: usize = 0xc;
    const DIVISOR: usize = 0x10;

    /// Receives and sends, with interrupts for both.
    fn enable(self) {
        write(self.0 + Self::DIVISOR, 16);
        write(self.0 + Self::CONTROL, 0b1111);
    }

    /// The byte that has come.
    pub(crate) fn receive(self) -> Option<u8> {
        let [byte, ..] = if read(self.0 + Self::STATE) & 0b10 == 0 {
            return None;
        } else {
            read(self.0).to_le_bytes()
        };
        Some(byte)
    }

    /// Whether a byte can be sent.
    pub(crate) fn is_free(self) -> bool {
        read(self.0 + Self::STATE) & 0b01 == 0
    }

    /// Sends a byte, for which the line is free.
    pub(crate) fn send(self, byte: u8) {
        write(self.0, byte.into());
    }

    fn acknowledge(self, interrupts: u32) {
        write(self.0 + Self::INTERRUPTS, interrupts);
    }
}

/// Starts the clock, the watchdog, a tick each millisecond, and only then the lines: with none that ticks, QEMU may
/// leave received bytes lying for a second.
pub(crate) fn start() {
    write(TIMER + 0x4, u32::MAX);
    write(TIMER + 0x8, u32::MAX);
    write(TIMER, 1);
    write(WATCHDOG + 0xc00, 0x1acc_e551);
    write(WATCHDOG, PATIENCE);
    write(WATCHDOG + 0x8, 0b11);
    if let Some(mut core) = cortex_m::Peripherals::take() {
        core.SYST.set_clock_source(SystClkSource::Core);
        core.SYST.set_reload(1000 * MEGAHERTZ - 1);
        core.SYST.clear_current();
        core.SYST.enable_counter();
        core.SYST.enable_interrupt();
    }
    HOST.enable();
    STOP.enable();
    write(NVIC_ISER, 0b111);
}

/// Free-running count of a 32-bit clock of 25 MHz, which wraps after 171 s.
pub(crate) fn count() -> u32 {
    !read(TIMER + 0x4)
}

/// Keeps the watchdog from resetting for another second.
pub(crate) fn feed() {
    write(WATCHDOG + 0xc, 1);
}

/// The interrupts of the lines. The watchdog's warning is no reason to stop, and what is not expected is none either.
#[exception]
unsafe fn DefaultHandler(interrupt: i16) {
    match interrupt {
        0 => {
            HOST.acknowledge(0b10);
            crate::app::received();
        }
        1 => {
            HOST.acknowledge(0b01);
            crate::app::sent();
        }
        2 => {
            STOP.acknowledge(0b10);
            crate::app::stop();
        }
        _ => {}
    }
}

fn read(address: usize) -> u32 {
    // SAFETY: a register of this board, by the constants above.
    unsafe { ptr::read_volatile(ptr::with_exposed_provenance(address)) }
}

fn write(address: usize, value: u32) {
    // SAFETY: a register of this board, by the constants above; none makes the core touch memory.
    unsafe { ptr::write_volatile(ptr::with_exposed_provenance_mut(address), value) }
}
