//! Clock, watchdog and interrupts of an MPS2 board, by the addresses of their registers.

use core::ptr;

/// Counts of the clock in a microsecond.
pub(crate) const MEGAHERTZ: u32 = 25;
const TIMER: usize = 0x4000_0000;
const WATCHDOG: usize = 0x4000_8000;
/// Registers that enable interrupts 0 to 31 (`NVIC_ENABLE`) and set them pending (`NVIC_PEND`).
pub(crate) const NVIC_ENABLE: usize = 0xe000_e100;
pub(crate) const NVIC_PEND: usize = 0xe000_e200;

unsafe extern "C" {
    /// The handler that [`exception`](cortex_m_rt::exception) makes of the function of that name.
    #[link_name = "DefaultHandler"]
    safe fn default_handler();
}

/// The handlers of all interrupts that are enabled.
// SAFETY: this section is the one for the addresses of interrupt handlers.
#[unsafe(export_name = "__INTERRUPTS")]
#[unsafe(link_section = ".vector_table.interrupts")]
static INTERRUPTS: [extern "C" fn(); super::HANDLERS] = [default_handler; super::HANDLERS];

/// The time since the start.
#[derive(Default)]
pub(crate) struct Clock {
    count: u32,
    /// Counts that do not yet make a microsecond.
    rest: u32,
    pub(crate) micros: u64,
}

impl Clock {
    /// Starts the clock, and a watchdog that warns after `patience` microseconds and resets the board after as many again.
    pub(crate) fn start(patience: u32) -> Self {
        write(TIMER + 0x4, u32::MAX);
        write(TIMER + 0x8, u32::MAX);
        write(TIMER, 1);
        write(WATCHDOG + 0xc00, 0x1acc_e551);
        write(WATCHDOG, patience * MEGAHERTZ);
        write(WATCHDOG + 0x8, 0b11);
        Self::default()
    }

    /// Returns the microseconds since the start. The counter wraps after 171 s, and is to be read before.
    pub(crate) fn now(&mut self) -> u64 {
        let count = !read(TIMER + 0x4);
        let passed = count.wrapping_sub(self.count);
        let rest = self.rest + passed % MEGAHERTZ;
        (self.count, self.rest) = (count, rest % MEGAHERTZ);
        self.micros += u64::from(passed / MEGAHERTZ + rest / MEGAHERTZ);
        self.micros
    }
}

/// Feeds the watchdog.
pub(crate) fn feed() {
    write(WATCHDOG + 0xc, 1);
}

pub(crate) fn read(address: usize) -> u32 {
    // SAFETY: the address is a register of this board.
    unsafe { ptr::read_volatile(ptr::with_exposed_provenance(address)) }
}

pub(crate) fn write(address: usize, value: u32) {
    // SAFETY: the address is a register of this board; none makes the core touch memory.
    unsafe { ptr::write_volatile(ptr::with_exposed_provenance_mut(address), value) }
}
