//! The board: runs the probe, prints through semihosting, and hands its end to the debugger.

use core::fmt::Write;

use cortex_m_rt::entry;
use cortex_m_semihosting::{debug, hio};
use foldpath_firmware_sim::probe;

#[entry]
fn main() -> ! {
    let status = hio::hstdout().and_then(|mut out| probe::run(&mut out).map_err(|_| ()));
    exit(status)
}

/// Nothing in the image panics: a test looks for this message in it.
#[panic_handler]
fn panic(_: &core::panic::PanicInfo<'_>) -> ! {
    if let Ok(mut out) = hio::hstdout() {
        let _ = out.write_str("foldpath-firmware-sim panicked\n");
    }
    exit(debug::EXIT_FAILURE)
}

fn exit(status: debug::ExitStatus) -> ! {
    loop {
        debug::exit(status);
    }
}
