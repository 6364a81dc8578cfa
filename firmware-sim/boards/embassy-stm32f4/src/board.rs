//! The board of a port: an STM32F4DISCOVERY (STM32F407) with twelve servos on a bus. **Never tried on hardware.**
//!
//! | what | where |
//! |---|---|
//! | line to the host, 460,800 baud | USART2 on PA2 and PA3 |
//! | bus of the servos, half duplex, 1 Mbaud | USART3 on PD8, with a pull-up of 1 kΩ |
//! | stop line, drawn while high: a contact to ground that opens, or a wire that breaks | PC1 |
//! | nonce | the generator of random numbers |
//! | clock | embassy's, on TIM2, in microseconds |
//! | watchdog, half a second | IWDG |
//!
//! Four tasks run side by side: two move bytes between the line and its queues, one talks to the servos, and one runs the
//! controller. None of them waits for another. A tick hands its goals to the bus in [`Board::commit`]. A bus that is late
//! takes the newest goals.
#![allow(
    unsafe_code,
    reason = "interrupts are bound by name, and RAM that a reset leaves as it is, is a section"
)]

use core::cell::RefCell;

use cortex_m::peripheral::SCB;
use embassy_executor::Spawner;
use embassy_futures::join::join4;
use embassy_futures::yield_now;
use embassy_stm32::gpio::{Input, Pull};
use embassy_stm32::peripherals::{self, IWDG};
use embassy_stm32::rcc::{
    AHBPrescaler, APBPrescaler, Hse, HseMode, Pll, PllMul, PllPDiv, PllPreDiv, PllQDiv, PllSource,
    Sysclk,
};
use embassy_stm32::rng::{self, Rng};
use embassy_stm32::time::Hertz;
use embassy_stm32::usart::{
    self, BufferedInterruptHandler, BufferedUart, BufferedUartRx, BufferedUartTx,
    HalfDuplexReadback, OutputConfig,
};
use embassy_stm32::wdg::IndependentWatchdog;
use embassy_sync::blocking_mutex::raw::NoopRawMutex;
use embassy_sync::signal::Signal;
use embassy_time::{Duration, Instant, Ticker, with_timeout};
use embedded_io_async::{Read, Write};
use foldpath_controller::retained::{self, Records};
use foldpath_controller::servo_bus::packets::{self, Answer, POSITION};
use foldpath_controller::servo_bus::{ANSWER_US, Bus, number};
use foldpath_controller::{Application, Board, Condition, Fifo, Line, Settings};
use foldpath_core::Membership;
use foldpath_core::follower::{Measurement, Target};
use foldpath_port_embassy_stm32f4::{BAUD, GROUPS, HINGES, KNOTS, LIMITS, SPOKES};

type Controller<'a> =
    Application<Discovery<'a>, Line<'a, 512, 256, &'a dyn Fn()>, GROUPS, HINGES, SPOKES, KNOTS>;

/// Microseconds between two rounds of the controller, in which 12 bytes come.
const ROUND: u64 = 250;

embassy_stm32::bind_interrupts!(struct Interrupts {
    USART2 => BufferedInterruptHandler<peripherals::USART2>;
    USART3 => BufferedInterruptHandler<peripherals::USART3>;
    RNG => rng::InterruptHandler<peripherals::RNG>;
});

/// Records that a reset leaves as they are.
// SAFETY: the section is not written at start, and every value of a byte is valid.
#[unsafe(link_section = ".uninit.records")]
static RECORDS: Records<{ retained::size(GROUPS) }> = Records::new();

/// A signal between tasks of the one executor.
type Event = Signal<NoopRawMutex, ()>;

/// Queues between the line to the host and the controller.
#[derive(Default)]
struct Queues {
    incoming: Fifo<512>,
    outgoing: Fifo<256>,
    /// There are bytes for the host.
    filled: Event,
}

/// Moves bytes from the host into their queue. A byte without room is lost, and its frame is sent again.
async fn receive(mut line: BufferedUartRx<'_>, queues: &Queues) {
    loop {
        let mut bytes = [0; 32];
        // An overrun or noise costs a frame.
        let count = line.read(&mut bytes).await.unwrap_or(0);
        for byte in bytes.iter().take(count) {
            let _ = queues.incoming.add(*byte);
        }
    }
}

/// Moves bytes for the host out of their queue.
async fn send(mut line: BufferedUartTx<'_>, queues: &Queues) {
    loop {
        queues.filled.wait().await;
        while let Some(byte) = queues.outgoing.take() {
            let _ = line.write_all(&[byte]).await;
        }
    }
}

/// The servos, which the controller commands and the bus serves.
#[derive(Default)]
struct Shared {
    servos: RefCell<Bus<HINGES>>,
    /// A tick has set all goals.
    committed: Event,
}

/// Sends the goals of each tick, and asks one servo where it stands.
async fn serve(mut bus: BufferedUart<'_>, shared: &Shared) {
    for hinge in (0..HINGES).cycle() {
        shared.committed.wait().await;
        let packet = shared.servos.borrow_mut().packet();
        if let Some((packet, switches)) = packet {
            let _ = bus.write_all(packet.bytes()).await;
            if switches {
                let switch = shared.servos.borrow_mut().switch();
                let _ = bus.write_all(switch.bytes()).await;
            }
        }
        let (told, at) = ask(&mut bus, number(hinge), POSITION).await;
        let mut servos = shared.servos.borrow_mut();
        match told {
            Some(bytes) => servos.answered(hinge, bytes.map(u16::from_le_bytes), at),
            None => servos.missed(hinge, at),
        }
    }
}

/// Asks a servo for two bytes. Returns its answer, with `None` for an error, if it has answered, and the time of the
/// question, microseconds.
async fn ask(bus: &mut BufferedUart<'_>, servo: u8, address: u8) -> (Option<Option<[u8; 2]>>, u64) {
    let _ = bus.write_all(&packets::read(servo, address, 2)).await;
    let _ = bus.flush().await;
    let at = Instant::now().as_micros();
    let mut answer = Answer::default();
    let hear = async {
        loop {
            let mut byte = [0];
            if let Ok(1) = bus.read(&mut byte).await
                && let Some((from, told)) = answer.push(byte[0])
                && from == servo
            {
                return told;
            }
        }
    };
    // The answer's own bytes take as long again as its wait.
    let patience = Duration::from_micros(ANSWER_US + 10 * packets::ANSWER as u64);
    (with_timeout(patience, hear).await.ok(), at)
}

/// The board as the controller sees it.
struct Discovery<'a> {
    shared: &'a Shared,
    stop: Input<'a>,
    watchdog: IndependentWatchdog<'a, IWDG>,
    /// `true` if the servos have held in a reset.
    held: bool,
}

impl Board for Discovery<'_> {
    fn now(&mut self) -> u64 {
        Instant::now().as_micros()
    }

    fn stop(&mut self) -> bool {
        self.stop.is_high()
    }

    fn power(&mut self, condition: &Condition) {
        self.shared.servos.borrow_mut().switch_to(condition.power);
    }

    fn drive(
        &mut self,
        hinge: u32,
        _: Membership,
        target: Option<Target<f32>>,
    ) -> Option<Measurement<f32>> {
        let mut servos = self.shared.servos.borrow_mut();
        let hinge = usize::try_from(hinge).ok()?;
        servos.drive(hinge, target, Instant::now().as_micros())
    }

    fn commit(&mut self) {
        self.shared.committed.signal(());
    }

    fn held(&mut self) -> bool {
        self.held
    }

    const RECORD: usize = retained::size(GROUPS);

    fn keep(&mut self, record: usize, at: usize, bytes: &[u8]) {
        RECORDS.keep(record, at, bytes);
    }

    fn kept(&mut self, record: usize, at: usize, bytes: &mut [u8]) {
        RECORDS.kept(record, at, bytes);
    }

    fn feed(&mut self) {
        self.watchdog.pet();
    }
}

/// Runs the controller for ever.
async fn control(mut controller: Controller<'_>) {
    let mut ticker = Ticker::every(Duration::from_micros(ROUND));
    loop {
        controller.step();
        if controller.is_busy() {
            yield_now().await;
        } else {
            ticker.next().await;
        }
    }
}

/// Clocks of 168 MHz, and of 48 MHz for random numbers, from the crystal of 8 MHz.
fn clocks() -> embassy_stm32::Config {
    let mut config = embassy_stm32::Config::default();
    config.rcc.hse = Some(Hse {
        freq: Hertz(8_000_000),
        mode: HseMode::Oscillator,
    });
    config.rcc.pll_src = PllSource::HSE;
    config.rcc.pll = Some(Pll {
        prediv: PllPreDiv::DIV4,
        mul: PllMul::MUL168,
        divp: Some(PllPDiv::DIV2),
        divq: Some(PllQDiv::DIV7),
        divr: None,
    });
    config.rcc.ahb_pre = AHBPrescaler::DIV1;
    config.rcc.apb1_pre = APBPrescaler::DIV4;
    config.rcc.apb2_pre = APBPrescaler::DIV2;
    config.rcc.sys = Sysclk::PLL1_P;
    config
}

#[embassy_executor::main]
async fn main(_spawner: Spawner) {
    let p = embassy_stm32::init(clocks());
    let mut random = Rng::new(p.RNG, Interrupts);
    let draws = [random.next_u64(), random.next_u64()];

    let mut config = usart::Config::default();
    config.baudrate = 460_800;
    let (mut sent, mut received) = ([0; 64], [0; 256]);
    let line = BufferedUart::new(
        p.USART2,
        p.PA3,
        p.PA2,
        &mut sent,
        &mut received,
        Interrupts,
        config,
    );
    config.baudrate = BAUD;
    // A servo may answer while the pin would still be driven high.
    config.tx_config = OutputConfig::OpenDrain;
    // Each byte of an answer is passed on at once.
    config.eager_reads = Some(1);
    let (mut asked, mut answered) = ([0; 128], [0; 64]);
    let bus = BufferedUart::new_half_duplex(
        p.USART3,
        p.PD8,
        Interrupts,
        &mut asked,
        &mut answered,
        config,
        HalfDuplexReadback::NoReadback,
    );
    let (Ok(line), Ok(mut bus)) = (line, bus) else {
        SCB::sys_reset()
    };
    let held = hold(&mut bus).await;

    let (queues, shared) = (Queues::default(), Shared::default());
    let (transmitter, receiver) = line.split();
    let mut watchdog = IndependentWatchdog::new(p.IWDG, 500_000);
    watchdog.unleash();
    let board = Discovery {
        shared: &shared,
        stop: Input::new(p.PC1, Pull::Up),
        watchdog,
        held,
    };
    let wake = || queues.filled.signal(());
    let line = Line {
        incoming: &queues.incoming,
        outgoing: &queues.outgoing,
        wake: &wake as &dyn Fn(),
    };
    let settings = Settings::new(draws, |_| LIMITS);
    join4(
        receive(receiver, &queues),
        send(transmitter, &queues),
        serve(bus, &shared),
        control(Application::new(board, line, settings)),
    )
    .await;
}

/// Returns `true` if all servos say that their drives are on: then they have had power and have held since they were told
/// their last goals.
async fn hold(bus: &mut BufferedUart<'_>) -> bool {
    for hinge in 0..HINGES {
        let (told, _) = ask(bus, number(hinge), packets::TORQUE).await;
        if !matches!(told, Some(Some([1, _]))) {
            return false;
        }
    }
    true
}

/// Resets the board after a panic, of which this hardware library has some; the angles commanded last are kept, and the
/// servos hold.
#[panic_handler]
fn panic(_: &core::panic::PanicInfo<'_>) -> ! {
    SCB::sys_reset()
}
