//! The test that every port passes: a controller with the drives of the port, in virtual time, from power-on by
//! commissioning, fold, stop, fault and forget to the end of a path. Ports of other workspaces take this file by its path.

use core::cell::RefCell;
use core::convert::Infallible;
use std::collections::VecDeque;
use std::rc::Rc;

use embedded_io::{ErrorType, Read, ReadReady, Write, WriteReady};
use foldpath_controller::retained::{self, Records};
use foldpath_controller::{Application, Board, Condition, Power, Settings};
use foldpath_core::follower::{Fault, FollowerPosition, Measurement, Reason, State, Target};
use foldpath_core::trajectory::TrajectoryView;
use foldpath_core::wire::cobs;
use foldpath_core::wire::driver::{Driver, Persistence};
use foldpath_core::wire::message::{Command, Item};
use foldpath_core::wire::path::PathItems;
use foldpath_core::wire::sender::{Options, Sender, Source};
use foldpath_core::{GroupId, GroupLimits, Interpolation, Membership, StarsView};

/// Microseconds of a round of the main loop.
const ROUND: u64 = 250;
/// Angle at which the path ends, radians, and its duration, seconds.
const END: f32 = 1.0;
const DURATION: u8 = 2;
/// Milliseconds in which the drives come to rest once their commands do.
const SETTLED: u64 = 150;

/// The drives and the hinges of a port.
pub(crate) trait Rig {
    /// Limits of each hinge.
    const LIMITS: GroupLimits;
    /// Largest distance of a hinge at rest from its command, radians: the resolution of drives and sensors.
    const ERROR: f32;

    /// Takes the place of [`Board::power`].
    fn power(&mut self, power: Power);

    /// Takes the place of [`Board::drive`] at `now`, microseconds.
    fn drive(
        &mut self,
        hinge: u32,
        target: Option<Target<f32>>,
        now: u64,
    ) -> Option<Measurement<f32>>;

    /// Takes the place of [`Board::commit`] at `now`, microseconds; then the hinges turn for a millisecond.
    fn commit(&mut self, now: u64);

    /// Returns the angle of each hinge, radians.
    fn angles(&self) -> Vec<f32>;

    /// Blocks a hinge, and no other.
    fn block(&mut self, hinge: Option<usize>);

    /// Turns all hinges to an angle by hand, radians, and returns `true` if the drives let them go.
    fn turn(&mut self, angle: f32) -> bool;
}

struct Bench<R> {
    rig: R,
    now: u64,
    drawn: bool,
    received: VecDeque<u8>,
    sent: Vec<u8>,
    condition: Option<Condition>,
    records: Records<{ retained::size(1) }>,
}

struct Shared<R>(Rc<RefCell<Bench<R>>>);

impl<R: Rig> Board for Shared<R> {
    const RECORD: usize = retained::size(1);

    fn now(&mut self) -> u64 {
        self.0.borrow().now
    }

    fn stop(&mut self) -> bool {
        self.0.borrow().drawn
    }

    fn power(&mut self, condition: &Condition) {
        let mut bench = self.0.borrow_mut();
        bench.condition = Some(*condition);
        bench.rig.power(condition.power);
    }

    fn drive(
        &mut self,
        hinge: u32,
        _: Membership,
        target: Option<Target<f32>>,
    ) -> Option<Measurement<f32>> {
        let mut bench = self.0.borrow_mut();
        let now = bench.now;
        bench.rig.drive(hinge, target, now)
    }

    fn commit(&mut self) {
        let mut bench = self.0.borrow_mut();
        let now = bench.now;
        bench.rig.commit(now);
    }

    fn held(&mut self) -> bool {
        false
    }

    fn keep(&mut self, record: usize, at: usize, bytes: &[u8]) {
        self.0.borrow().records.keep(record, at, bytes);
    }

    fn kept(&mut self, record: usize, at: usize, bytes: &mut [u8]) {
        self.0.borrow().records.kept(record, at, bytes);
    }

    fn feed(&mut self) {}
}

impl<R> ErrorType for Shared<R> {
    type Error = Infallible;
}

impl<R> ReadReady for Shared<R> {
    fn read_ready(&mut self) -> Result<bool, Infallible> {
        Ok(!self.0.borrow().received.is_empty())
    }
}

impl<R> Read for Shared<R> {
    fn read(&mut self, bytes: &mut [u8]) -> Result<usize, Infallible> {
        let byte = self.0.borrow_mut().received.pop_front();
        let places = bytes.iter_mut().zip(byte);
        Ok(places.map(|(place, byte)| *place = byte).count())
    }
}

impl<R> WriteReady for Shared<R> {
    fn write_ready(&mut self) -> Result<bool, Infallible> {
        Ok(true)
    }
}

impl<R> Write for Shared<R> {
    fn write(&mut self, bytes: &[u8]) -> Result<usize, Infallible> {
        self.0.borrow_mut().sent.extend(bytes);
        Ok(bytes.len())
    }

    fn flush(&mut self) -> Result<(), Infallible> {
        Ok(())
    }
}

/// A host: takes bytes, and gives frames.
trait Host {
    fn byte(&mut self, byte: u8, now: u64);
    fn frame<'b>(&mut self, now: u64, buffer: &'b mut [u8]) -> Option<&'b [u8]>;
}

impl Host for Driver<'_> {
    fn byte(&mut self, byte: u8, now: u64) {
        Driver::byte(self, byte, now);
    }

    fn frame<'b>(&mut self, now: u64, buffer: &'b mut [u8]) -> Option<&'b [u8]> {
        self.poll(now, &mut [0; 256], buffer)
    }
}

/// A host without a path.
struct Operator {
    sender: Sender,
    deframer: cobs::Deframer<512>,
}

struct Nothing;

impl Source for Nothing {
    fn item<'b>(&self, _: u64, _: &'b mut [u8]) -> Option<Item<'b>> {
        None
    }
}

impl Host for Operator {
    fn byte(&mut self, byte: u8, now: u64) {
        if let Some(frame) = self.deframer.push(byte) {
            self.sender.receive(frame, now);
        }
    }

    fn frame<'b>(&mut self, now: u64, buffer: &'b mut [u8]) -> Option<&'b [u8]> {
        self.sender.poll(now, &Nothing, &mut [0; 64], buffer)
    }
}

/// A controller with the drives of a port.
struct Machine<R, const HINGES: usize> {
    bench: Rc<RefCell<Bench<R>>>,
    controller: Box<Application<Shared<R>, Shared<R>, 1, HINGES, 1, 16>>,
}

impl<R: Rig, const HINGES: usize> Machine<R, HINGES> {
    fn new(rig: R) -> Self {
        let bench = Rc::new(RefCell::new(Bench {
            rig,
            now: 1_000_000,
            drawn: false,
            received: VecDeque::new(),
            sent: Vec::new(),
            condition: None,
            records: Records::new(),
        }));
        let settings = Settings {
            closed: false,
            ..Settings::new([1, 2], |_| R::LIMITS)
        };
        let [board, line] = [Shared(Rc::clone(&bench)), Shared(Rc::clone(&bench))];
        Self {
            bench,
            controller: Box::new(Application::new(board, line, settings)),
        }
    }

    /// Runs for some milliseconds, with a host if there is one. Asserts that no hinge turns while the drives are to rest.
    fn run(&mut self, mut host: Option<&mut dyn Host>, millis: u64) {
        for _ in 0..millis * 1000 / ROUND {
            let before = self.angles();
            self.bench.borrow_mut().now += ROUND;
            self.controller.step();
            if self.condition().power == Power::Rest {
                assert_eq!(self.angles(), before, "a hinge turns while its drive rests");
            }
            let mut bench = self.bench.borrow_mut();
            let (now, sent) = (bench.now, core::mem::take(&mut bench.sent));
            let Some(host) = host.as_deref_mut() else {
                continue;
            };
            sent.iter().for_each(|byte| host.byte(*byte, now));
            let mut buffer = [0; 256];
            while let Some(frame) = host.frame(now, &mut buffer) {
                cobs::encode(frame, |byte| bench.received.push_back(byte));
            }
        }
    }

    /// Runs with a host until a condition holds, for at most some milliseconds.
    #[track_caller]
    fn until(&mut self, host: &mut dyn Host, millis: u64, holds: impl Fn(&Self) -> bool) {
        for _ in 0..millis {
            if holds(self) {
                return;
            }
            self.run(Some(&mut *host), 1);
        }
        panic!("{:?}, {:?}", self.condition(), self.angles());
    }

    /// Gives the controller a command of an operator, and asserts that it is carried out.
    fn command(&mut self, operator: &mut Operator, command: Command) {
        while !operator.sender.command(command) {
            self.run(Some(operator), 1);
        }
        self.until(operator, 1000, |_| true);
        while operator.sender.answer().is_none() {
            self.run(Some(operator), 1);
        }
        assert_eq!(operator.sender.answer(), Some(Ok(())), "{command:?}");
    }

    /// Asserts that the hinges stay where they are, but for what the drives have not done yet.
    fn rests(&mut self, host: &mut dyn Host) {
        self.run(Some(&mut *host), SETTLED);
        let before = self.angles();
        self.run(Some(host), 300);
        assert_eq!(self.angles(), before);
    }

    fn rig<T>(&self, with: impl FnOnce(&mut R) -> T) -> T {
        with(&mut self.bench.borrow_mut().rig)
    }

    fn angles(&self) -> Vec<f32> {
        self.rig(|rig| rig.angles())
    }

    fn condition(&self) -> Condition {
        self.bench.borrow().condition.expect("a tick")
    }
}

/// Asserts that each hinge stands at an angle, radians.
#[track_caller]
fn stand<R: Rig>(angles: &[f32], at: impl Fn(usize) -> f32) {
    for (hinge, angle) in angles.iter().enumerate() {
        assert!((angle - at(hinge)).abs() <= R::ERROR, "{hinge}: {angle}");
    }
}

/// Puts a port with `HINGES` hinges through its life.
pub(crate) fn lives<R: Rig, const HINGES: usize>(rig: R) {
    let last = HINGES - 1;
    let sign = |hinge: usize| if hinge.is_multiple_of(2) { 1.0 } else { -1.0 };
    let knots = 0..=10 * DURATION;
    let times: Vec<f32> = knots.map(|knot| f32::from(knot) / 10.0).collect();
    let speed = END / f32::from(DURATION);
    let angles: Vec<f32> = times.iter().map(|time| speed * time).collect();
    let rates = vec![speed; times.len()];
    let mut spans = vec![0.1; times.len()];
    spans[0] = 0.0;
    let hinge = |hinge: usize| Membership {
        group: GroupId(0),
        negative: sign(hinge) < 0.0,
    };
    let hinges: Vec<Membership> = (0..HINGES).map(hinge).collect();
    let kind = Interpolation::Hermite;
    let view = TrajectoryView::new(kind, 1, &spans, &angles, &rates, &[]).expect("a path");
    let stars = StarsView::new(&[], &[], 1).expect("no vertices");
    let limits = [R::LIMITS];
    let host = |id, persistence| {
        let place = FollowerPosition::default();
        let items = PathItems::new(view, &limits, &hinges, stars, 1e-4, place);
        Driver::new(items.expect("a path"), persistence, id, Options::default())
    };
    let mut machine = Machine::<R, HINGES>::new(rig);

    // Power-on: nothing moves.
    machine.run(None, 300);
    assert_eq!(machine.condition().power, Power::Rest);

    // Commissioning: one hinge moves, and no other.
    let mut operator = Operator {
        sender: Sender::new(1, Options::default()),
        deframer: cobs::Deframer::default(),
    };
    for (one, to) in [(0, 0.1), (0, 0.0), (last, 0.1), (last, 0.0)] {
        let hinge = u16::try_from(one).expect("few hinges");
        for to in [None, Some(to)] {
            let from = None;
            machine.command(&mut operator, Command::Jog { hinge, from, to });
            machine.run(Some(&mut operator), 200);
        }
        machine.run(Some(&mut operator), 1500);
        stand::<R>(
            &machine.angles(),
            |hinge| if hinge == one { to } else { 0.0 },
        );
    }
    machine.command(&mut operator, Command::Forget);
    machine.run(Some(&mut operator), 20);
    assert_eq!(machine.condition().power, Power::Rest);

    // A fold, and a stop in its middle.
    let mut first = host(2, Persistence::None);
    machine.until(&mut first, 5000, |machine| machine.angles()[0] > 0.3 * END);
    assert_eq!(machine.condition().measured, HINGES);
    machine.bench.borrow_mut().drawn = true;
    machine.rests(&mut first);
    assert_eq!(machine.condition().reason, Reason::StopLine);
    assert!(machine.angles()[0] < 0.5 * END);
    machine.bench.borrow_mut().drawn = false;
    machine.rests(&mut first);

    // Another host goes on, and a hinge is stuck: all others stop, and hold where they are.
    let mut second = host(3, Persistence::Resume);
    machine.until(&mut second, 5000, |machine| machine.angles()[0] > 0.5 * END);
    machine.rig(|rig| rig.block(Some(last)));
    machine.until(&mut second, 5000, |machine| {
        machine.condition().state == State::Faulted
    });
    let fault = Fault::Stalled(u32::try_from(last).expect("few hinges"));
    assert_eq!(machine.condition().fault, Some(fault));
    machine.rests(&mut second);
    assert_eq!(
        (machine.condition().power, machine.condition().commanded),
        (Power::Hold, 0)
    );
    assert!(!machine.rig(|rig| rig.turn(0.0)));

    // Forget: the drives let go, and a hand turns the hinges back.
    let mut operator = Operator {
        sender: Sender::new(4, Options::default()),
        deframer: cobs::Deframer::default(),
    };
    for command in [Command::Clear, Command::Forget, Command::Resume] {
        machine.command(&mut operator, command);
    }
    machine.run(Some(&mut operator), 20);
    assert_eq!(machine.condition().power, Power::Rest);
    machine.rig(|rig| rig.block(None));
    assert!(machine.rig(|rig| rig.turn(0.0)));

    // The whole path, from where the hinges are measured.
    let mut third = host(5, Persistence::None);
    machine.until(&mut third, 8000, |machine| {
        machine.condition().state == State::Done
    });
    machine.rests(&mut third);
    stand::<R>(&machine.angles(), |hinge| sign(hinge) * END);
}
