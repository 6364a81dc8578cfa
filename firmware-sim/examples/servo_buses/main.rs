//! An example of a port with 128 servos on four buses, for the registers of Arm's MPS2 board. It links, and was never tried
//! on hardware. `board.rs` has the board; this file is the same for every board, and a skeleton to begin with.
#![cfg_attr(target_os = "none", no_std, no_main)]
#![deny(clippy::unwrap_used, clippy::expect_used, clippy::panic)]
#![deny(clippy::indexing_slicing)]

#[cfg(target_os = "none")]
mod board;

#[cfg(target_os = "none")]
#[allow(unsafe_code, reason = "a section of RAM, and a missing function")]
mod skeleton {
    use cortex_m::peripheral::SCB;
    use cortex_m_rt::{ExceptionFrame, entry, exception};
    use foldpath_controller::retained::Records;
    use foldpath_controller::{Application, Board, Fifo, Line, Settings};

    use crate::board::{GROUPS, HINGES, KNOTS, LIMITS, MyBoard, SPOKES};

    type Controller =
        Application<MyBoard, Line<'static, 256, 256, fn()>, GROUPS, HINGES, SPOKES, KNOTS>;

    /// Bytes from the host and for the host, between the interrupts of the line and the main loop.
    pub(crate) static INCOMING: Fifo<256> = Fifo::new();
    pub(crate) static OUTGOING: Fifo<256> = Fifo::new();
    /// Records that a reset leaves as they are.
    // SAFETY: the section is not written at start, and every value of a byte is valid.
    #[unsafe(link_section = ".uninit.records")]
    pub(crate) static RECORDS: Records<{ MyBoard::RECORD }> = Records::new();

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
        let (board, draws) = MyBoard::start();
        let line = Line {
            incoming: &INCOMING,
            outgoing: &OUTGOING,
            wake: MyBoard::wake as fn(),
        };
        let settings = Settings::new(draws, |_| LIMITS);
        *MEMORY = Memory::Some(Application::new(board, line, settings));
        loop {
            if let Memory::Some(controller) = MEMORY {
                controller.step();
            }
        }
    }

    /// Resets the board after a fault, such as that of a stack that has grown out of RAM.
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
}

#[cfg(not(target_os = "none"))]
fn main() {
    println!("This program is for a microcontroller: firmware-sim/PORTING.md says more.");
}
