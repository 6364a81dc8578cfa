//! The probe's board: runs the probe, prints through semihosting, and hands the exit status to the debugger.
//!
//! It then counts the cost of the controller's work. The counts are instructions if the emulator runs with
//! `-icount shift=10`.

use core::fmt::Write;

use cortex_m::peripheral::SYST;
use cortex_m::peripheral::syst::SystClkSource;
use cortex_m_rt::entry;
use cortex_m_semihosting::{debug, hio};

use crate::{figures, probe};

/// The handler of interrupt 0. The probe enables no interrupt, so that the table ends here.
// SAFETY: this section is the one for the addresses of interrupt handlers.
#[allow(unsafe_code, reason = "interrupts are found by their address")]
#[unsafe(export_name = "__INTERRUPTS")]
#[unsafe(link_section = ".vector_table.interrupts")]
static INTERRUPTS: [extern "C" fn(); 1] = [interrupt];

extern "C" fn interrupt() {}

/// Counts after which the core's clock begins anew.
const CYCLE: u32 = 1 << 24;

#[entry]
fn main() -> ! {
    if let Some(mut core) = cortex_m::Peripherals::take() {
        core.SYST.set_clock_source(SystClkSource::Core);
        core.SYST.set_reload(CYCLE - 1);
        core.SYST.clear_current();
        core.SYST.enable_counter();
    }
    let status = hio::hstdout().and_then(|mut out| {
        let done = probe::run(&mut out).and_then(|()| figures::run(&mut out, instructions()));
        done.map_err(|_| ())
    });
    exit(status)
}

/// Counts instructions of 2¹⁰ ns each by the clock of 25 MHz, which has to be read at least once in each of its cycles.
fn instructions() -> impl FnMut() -> u32 {
    let (mut before, mut sum) = (SYST::get_current(), 0_u64);
    move || {
        let now = SYST::get_current();
        sum += u64::from(before.wrapping_add(CYCLE).wrapping_sub(now) % CYCLE);
        before = now;
        u32::try_from(sum * 40 / 1024).unwrap_or(u32::MAX)
    }
}

/// Never runs: nothing in the image panics, and a test looks for this message in it.
#[panic_handler]
fn panic(_: &core::panic::PanicInfo<'_>) -> ! {
    if let Ok(mut out) = hio::hstdout() {
        let _ = out.write_str("the probe panicked\n");
    }
    exit(debug::EXIT_FAILURE)
}

fn exit(status: debug::ExitStatus) -> ! {
    loop {
        debug::exit(status);
    }
}
