//! The board of a port: a NUCLEO-F411RE that folds the four hinges of `example/`. **Never tried on hardware.**
//!
//! | what | where |
//! |---|---|
//! | line to the host, 460,800 baud | USART2 on PA2 and PA3, which the board's debugger passes on over USB |
//! | stop line, drawn while high: a contact to ground that opens, or a wire that breaks | PC1 |
//! | servos, 1 to 2 ms every 20 ms | TIM3 on PA6, PA7, PB0 and PB1 |
//! | positions, from the servos' potentiometers | ADC1 on PA0, PA1, PA4 and PC0 |
//! | button that plays the path in flash: pressed, or kept down for two seconds to say that the sheet is flat | PC13, the user button of the board |
//! | clock | TIM5, in microseconds |
//! | watchdog, half a second | IWDG |
#![allow(
    unsafe_code,
    reason = "an interrupt is enabled, and RAM that a reset leaves as it is, is a section"
)]

use core::cell::RefCell;
use core::convert::Infallible;
use core::sync::atomic::{AtomicU8, Ordering};

use cortex_m::interrupt::Mutex;
use cortex_m::peripheral::{NVIC, SCB};
use cortex_m_rt::entry;
use embedded_io::{ErrorType, Read, ReadReady, Write, WriteReady};
use foldpath_controller::retained::{self, Records};
use foldpath_controller::{Application, Board, Condition, Fifo, Hold, Player, Power, Settings};
use foldpath_core::Membership;
use foldpath_core::follower::{Measurement, Target};
use foldpath_port_stm32f4::{
    Button, GROUPS, HINGES, KNOTS, LIMITS, PATH, Press, SPOKES, angle, pulse,
};
use stm32f4xx_hal::adc::Adc;
use stm32f4xx_hal::adc::config::{AdcConfig, SampleTime};
use stm32f4xx_hal::gpio::{Analog, Input, PA0, PA1, PA4, PC0, PC1, PC13};
use stm32f4xx_hal::pac::{self, ADC1, TIM3, TIM5, USART2, interrupt};
use stm32f4xx_hal::prelude::*;
use stm32f4xx_hal::rcc::Config;
use stm32f4xx_hal::serial::{Rx, Tx};
use stm32f4xx_hal::timer::{CounterUs, PwmChannel};
use stm32f4xx_hal::watchdog::IndependentWatchdog;

type Controller = Application<Nucleo, Line, GROUPS, HINGES, SPOKES, KNOTS>;

/// Microseconds after which the clock begins anew, 71 minutes. Each round of the main loop reads it.
const PERIOD: u32 = u32::MAX;

/// Bytes from the host that wait for the main loop.
static INCOMING: Fifo<256> = Fifo::new();
/// The receiver, which only its interrupt uses.
static RECEIVER: Mutex<RefCell<Option<Rx<USART2>>>> = Mutex::new(RefCell::new(None));

/// Press that the main loop has not yet seen: none (0), a short one (1) or a long one (2).
static ASKED: AtomicU8 = AtomicU8::new(0);

/// Records that a reset leaves as they are.
// SAFETY: the section is not written at start, and every value of a byte is valid.
#[unsafe(link_section = ".uninit.records")]
static RECORDS: Records<{ Nucleo::RECORD }> = Records::new();

#[interrupt]
fn USART2() {
    cortex_m::interrupt::free(|section| {
        if let Some(receiver) = RECEIVER.borrow(section).borrow_mut().as_mut()
            && let Ok(byte) = receiver.read()
        {
            let _ = INCOMING.add(byte);
        }
    });
}

/// The line to the host: a queue that the interrupt fills, and the transmitter, which is asked for room before each
/// byte.
struct Line(Tx<USART2>);

impl ErrorType for Line {
    type Error = Infallible;
}

impl ReadReady for Line {
    fn read_ready(&mut self) -> Result<bool, Infallible> {
        Ok(!INCOMING.is_empty())
    }
}

impl Read for Line {
    fn read(&mut self, bytes: &mut [u8]) -> Result<usize, Infallible> {
        let places = bytes
            .iter_mut()
            .zip(core::iter::from_fn(|| INCOMING.take()));
        Ok(places.map(|(place, byte)| *place = byte).count())
    }
}

impl WriteReady for Line {
    fn write_ready(&mut self) -> Result<bool, Infallible> {
        Ok(self.0.is_tx_empty())
    }
}

impl Write for Line {
    fn write(&mut self, bytes: &[u8]) -> Result<usize, Infallible> {
        Ok(bytes
            .iter()
            .map_while(|byte| self.0.write(*byte).ok())
            .count())
    }

    fn flush(&mut self) -> Result<(), Infallible> {
        Ok(())
    }
}

/// The rest of the board.
struct Nucleo {
    clock: CounterUs<TIM5>,
    count: u32,
    micros: u64,
    stop: PC1<Input>,
    button: (PC13<Input>, Button),
    servos: (
        PwmChannel<TIM3, 0>,
        PwmChannel<TIM3, 1>,
        PwmChannel<TIM3, 2>,
        PwmChannel<TIM3, 3>,
    ),
    converter: Adc<ADC1>,
    potentiometers: (PA0<Analog>, PA1<Analog>, PA4<Analog>, PC0<Analog>),
    holds: [Hold; HINGES],
    power: Power,
    watchdog: IndependentWatchdog,
}

impl Board for Nucleo {
    fn now(&mut self) -> u64 {
        let count = self.clock.now().ticks();
        self.micros += u64::from(count.wrapping_sub(self.count));
        self.count = count;
        self.micros
    }

    fn stop(&mut self) -> bool {
        self.stop.is_high()
    }

    /// A servo without pulses is limp, and one with pulses holds. Looks at the button, as this is called each millisecond.
    fn power(&mut self, condition: &Condition) {
        self.power = condition.power;
        let (pin, button) = &mut self.button;
        match button.look(pin.is_low()) {
            Some(Press::Short) => ASKED.store(1, Ordering::Relaxed),
            Some(Press::Long) => ASKED.store(2, Ordering::Relaxed),
            None => {}
        }
    }

    fn drive(
        &mut self,
        hinge: u32,
        _: Membership,
        target: Option<Target<f32>>,
    ) -> Option<Measurement<f32>> {
        let place = usize::try_from(hinge).unwrap_or(usize::MAX);
        let (hold, power) = (self.holds.get_mut(place)?, self.power);
        let (servos, pots) = (&mut self.servos, &self.potentiometers);
        let (converter, time) = (&mut self.converter, SampleTime::Cycles_84);
        // The read waits for the conversion, which takes 5 microseconds.
        macro_rules! turn {
            ($servo:tt) => {{
                let measured = angle(converter.convert(&pots.$servo, time));
                let command = hold.command(power, target, Some(measured));
                servos.$servo.set_duty(command.map_or(0, pulse));
                measured
            }};
        }
        let measured = match hinge {
            0 => turn!(0),
            1 => turn!(1),
            2 => turn!(2),
            3 => turn!(3),
            _ => return None,
        };
        Some(measured.into())
    }

    /// The servos have no pulses in a reset, and are limp without them. Their potentiometers tell where they stand.
    fn held(&mut self) -> bool {
        false
    }

    const RECORD: usize = retained::size(GROUPS);

    fn keep(&mut self, record: usize, at: usize, bytes: &[u8]) {
        RECORDS.keep(record, at, bytes);
    }

    fn kept(&mut self, record: usize, at: usize, bytes: &mut [u8]) {
        RECORDS.kept(record, at, bytes);
    }

    fn feed(&mut self) {
        self.watchdog.feed();
    }
}

impl Nucleo {
    /// Returns a number that differs from start to start: this part has no random numbers but the noise in the lowest
    /// bits of its converter, of which each reading adds less than a bit.
    fn nonce(&mut self) -> u64 {
        (0..1024).fold(0, |nonce: u64, _| {
            let reading = self
                .converter
                .convert(&self.potentiometers.0, SampleTime::Cycles_3);
            (nonce.rotate_left(7) ^ u64::from(reading)).wrapping_mul(0x9e37_79b9_7f4a_7c15)
        })
    }
}

/// Sets up the board with its clocks, timers and pins, and the line to the host.
fn start(device: pac::Peripherals) -> Option<(Nucleo, Line)> {
    let mut rcc = device.RCC.freeze(Config::hsi().sysclk(84.MHz()));
    let (a, b, c) = (
        device.GPIOA.split(&mut rcc),
        device.GPIOB.split(&mut rcc),
        device.GPIOC.split(&mut rcc),
    );
    let mut clock = device.TIM5.counter_us(&mut rcc);
    clock.start(PERIOD.micros()).ok()?;
    let line = device
        .USART2
        .serial::<u8>((a.pa2, a.pa3), 460_800.bps(), &mut rcc)
        .ok()?;
    let (transmitter, mut receiver) = line.split();
    receiver.listen();
    cortex_m::interrupt::free(|section| {
        RECEIVER.borrow(section).replace(Some(receiver));
    });
    let (_, (first, second, third, fourth)) =
        device.TIM3.pwm::<1_000_000>(20_000.micros(), &mut rcc);
    let mut servos = (
        first.with(a.pa6),
        second.with(a.pa7),
        third.with(b.pb0),
        fourth.with(b.pb1),
    );
    servos.0.enable();
    servos.1.enable();
    servos.2.enable();
    servos.3.enable();
    let mut watchdog = IndependentWatchdog::new(device.IWDG);
    watchdog.start(500.millis());
    let nucleo = Nucleo {
        clock,
        count: 0,
        micros: 0,
        stop: c.pc1.into_pull_up_input(),
        button: (c.pc13.into_pull_up_input(), Button::default()),
        servos,
        converter: Adc::new(device.ADC1, true, AdcConfig::default(), &mut rcc),
        potentiometers: (
            a.pa0.into_analog(),
            a.pa1.into_analog(),
            a.pa4.into_analog(),
            c.pc0.into_analog(),
        ),
        holds: [Hold::default(); HINGES],
        power: Power::Rest,
        watchdog,
    };
    Some((nucleo, Line(transmitter)))
}

#[entry]
fn main() -> ! {
    static mut CONTROLLER: Option<Controller> = None;
    if let Some((mut nucleo, line)) = pac::Peripherals::take().and_then(start) {
        let settings = Settings::new([nucleo.nonce(), nucleo.nonce()], |_| LIMITS);
        let controller = CONTROLLER.insert(Application::new(nucleo, line, settings));
        // SAFETY: nothing relies on this interrupt being masked.
        unsafe { NVIC::unmask(pac::Interrupt::USART2) };
        // A test reads the path on the host.
        let mut player = Player::new(PATH, None).ok();
        loop {
            controller.step();
            if let Some(player) = &mut player {
                match ASKED.swap(0, Ordering::Relaxed) {
                    1 => player.press(),
                    2 => player.press_flat(),
                    _ => {}
                }
                controller.play(player);
            }
        }
    }
    SCB::sys_reset()
}

/// Resets the board after a panic, of which this hardware library has some; the angles commanded last are kept.
#[panic_handler]
fn panic(_: &core::panic::PanicInfo<'_>) -> ! {
    SCB::sys_reset()
}
