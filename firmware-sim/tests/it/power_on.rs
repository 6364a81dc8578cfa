//! Is a board safe from the first millisecond, with 2, 11 and 94 groups: after power-on, after resets, in faults, and
//! against bytes that were recorded or forged? Does work go on afterwards?

use core::cell::RefCell;
use core::convert::Infallible;
use std::collections::VecDeque;
use std::rc::Rc;

use embedded_io::{ErrorType, Read, ReadReady, Write, WriteReady};
use foldpath_core::follower::{Denial, Fault, FollowerPosition, Reason, State};
use foldpath_core::trajectory::TrajectoryView;
use foldpath_core::wire::cobs;
use foldpath_core::wire::driver::{Driver, Persistence};
use foldpath_core::wire::message::{Command, ItemRefusal, Report};
use foldpath_core::wire::path::PathItems;
use foldpath_core::wire::sender::Options;
use foldpath_core::{GroupId, GroupLimits, Interpolation, Membership, StarsView};
use foldpath_firmware_sim::application::{Application, Board};
use foldpath_firmware_sim::controller::Condition;
use foldpath_firmware_sim::retained;
use foldpath_test_support::Random;
use rand_core::Rng;

use crate::path::{BOARD, settings};

/// Microseconds of a round of the main loop.
const ROUND: u64 = 250;
const LIMITS: GroupLimits = GroupLimits {
    lower: -3.2,
    upper: 3.2,
    speed: 2.5,
    acceleration: 1e9,
};

/// A path from 0 to 2 rad in two seconds, on which all groups turn alike. It has three hinges for each group.
struct Path {
    groups: usize,
    times: Vec<f32>,
    angles: Vec<f32>,
    rates: Vec<f32>,
    hinges: Vec<Membership>,
    limits: Vec<GroupLimits>,
}

impl Path {
    fn new(groups: usize) -> Self {
        Self::from(groups, 0.0, 1.0)
    }

    /// The path begins at an angle and has this speed, radians and radians per second.
    fn from(groups: usize, begin: f32, speed: f32) -> Self {
        let times: Vec<f32> = (0..21_u8).map(|knot| f32::from(knot) * 0.1).collect();
        let angles = times
            .iter()
            .flat_map(|time| vec![begin + speed * time; groups])
            .collect();
        let hinge = |hinge: usize| Membership {
            group: GroupId(u32::try_from(hinge % groups).unwrap()),
            negative: hinge.is_multiple_of(3),
        };
        Self {
            groups,
            angles,
            rates: vec![speed; groups * times.len()],
            times,
            hinges: (0..3 * groups).map(hinge).collect(),
            limits: vec![LIMITS; groups],
        }
    }

    fn items(&self) -> PathItems<'_> {
        let (kind, groups) = (Interpolation::Hermite, self.groups);
        let view = TrajectoryView::new(kind, groups, &self.times, &self.angles, &self.rates, &[]);
        let stars = StarsView::new(&[], &[], groups).unwrap();
        let place = FollowerPosition::default();
        PathItems::new(
            view.unwrap(),
            &self.limits,
            &self.hinges,
            stars,
            1e-4,
            place,
        )
        .unwrap()
    }

    fn driver(&self, persistence: Persistence, id: u32) -> Driver<'_> {
        Driver::new(self.items(), persistence, id, Options::default())
    }
}

/// The hardware round the controller, which a reset leaves as it is.
#[derive(Default)]
struct Bench {
    now: u64,
    stop: bool,
    received: VecDeque<u8>,
    sent: Vec<u8>,
    /// Angle that each hinge was last commanded in the last tick; `None` if it had no command.
    commands: Vec<Option<f32>>,
    conditions: Vec<Condition>,
    ticks: usize,
    records: [Vec<u8>; 2],
    /// Angle at which each hinge stands. A hinge follows its command, and stays where it is without one.
    stands: Vec<f32>,
    /// `true` if the drives let go of the hinges in a reset.
    limp: bool,
    /// Returns the measured angle of a hinge from its number, its command, and the angle at which it stands.
    sensor: Option<Sensor>,
}

type Sensor = fn(u32, Option<f32>, f32) -> f32;

/// A sensor that tells where the hinge stands.
const EXACT: Sensor = |_, _, stands| stands;

#[derive(Clone, Default)]
struct Shared(Rc<RefCell<Bench>>);

impl Board for Shared {
    const RECORD: usize = retained::size(94);

    fn now(&mut self) -> u64 {
        self.0.borrow().now
    }

    fn stop(&mut self) -> bool {
        self.0.borrow().stop
    }

    fn power(&mut self, condition: &Condition) {
        let mut bench = self.0.borrow_mut();
        bench.conditions.push(*condition);
        bench.commands.clear();
    }

    fn drive(&mut self, hinge: u32, _: Membership, angle: Option<f32>) -> Option<f32> {
        let mut bench = self.0.borrow_mut();
        assert_eq!(bench.commands.len(), hinge as usize);
        bench.commands.push(angle);
        let hinges = bench.stands.len().max(hinge as usize + 1);
        bench.stands.resize(hinges, 0.0);
        let stands = bench.stands[hinge as usize];
        bench.sensor.map(|sensor| sensor(hinge, angle, stands))
    }

    fn held(&mut self) -> bool {
        !self.0.borrow().limp
    }

    fn keep(&mut self, record: usize, at: usize, bytes: &[u8]) {
        let record = &mut self.0.borrow_mut().records[record];
        record.resize(Self::RECORD, 0);
        record[at..at + bytes.len()].copy_from_slice(bytes);
    }

    fn kept(&mut self, record: usize, at: usize, bytes: &mut [u8]) {
        let record = &mut self.0.borrow_mut().records[record];
        record.resize(Self::RECORD, 0);
        bytes.copy_from_slice(&record[at..at + bytes.len()]);
    }

    fn feed(&mut self) {
        self.0.borrow_mut().ticks += 1;
    }
}

impl ErrorType for Shared {
    type Error = Infallible;
}

impl ReadReady for Shared {
    fn read_ready(&mut self) -> Result<bool, Infallible> {
        Ok(!self.0.borrow().received.is_empty())
    }
}

impl Read for Shared {
    fn read(&mut self, bytes: &mut [u8]) -> Result<usize, Infallible> {
        let byte = self.0.borrow_mut().received.pop_front();
        Ok(bytes
            .iter_mut()
            .zip(byte)
            .map(|(place, byte)| *place = byte)
            .count())
    }
}

impl WriteReady for Shared {
    fn write_ready(&mut self) -> Result<bool, Infallible> {
        Ok(true)
    }
}

impl Write for Shared {
    fn write(&mut self, bytes: &[u8]) -> Result<usize, Infallible> {
        self.0.borrow_mut().sent.extend(bytes);
        Ok(bytes.len())
    }

    fn flush(&mut self) -> Result<(), Infallible> {
        Ok(())
    }
}

/// A board with a controller of at most `G` groups.
struct Machine<const G: usize> {
    bench: Shared,
    controller: Box<Application<Shared, Shared, G, 282, 16, 16>>,
    /// Bytes that hosts have sent.
    recorded: Vec<(u64, Vec<u8>)>,
    nonce: u64,
}

impl<const G: usize> Machine<G> {
    /// Switches a board on whose memory holds nothing.
    fn new(nonce: u64) -> Self {
        let bench = Shared::default();
        bench.0.borrow_mut().now = 1_000_000;
        let controller = Application::new(bench.clone(), bench.clone(), settings(nonce));
        Self {
            controller: Box::new(controller),
            bench,
            recorded: Vec::new(),
            nonce,
        }
    }

    /// Cuts the power and switches it on again: the memory holds whatever it holds, and the hinges stay.
    fn cut_power(&mut self, nonce: u64) {
        let mut rng = Random::new(nonce);
        self.bench(|bench| {
            for byte in bench.records.iter_mut().flatten() {
                [*byte, ..] = rng.next_u32().to_le_bytes();
            }
        });
        self.nonce = nonce;
        self.reset();
    }

    /// Resets the controller; its records stay.
    fn reset(&mut self) {
        let (bench, nonce) = (&self.bench, self.nonce);
        {
            let mut bench = bench.0.borrow_mut();
            (bench.received, bench.sent) = (VecDeque::new(), Vec::new());
            bench.commands.clear();
        }
        *self.controller = Application::new(bench.clone(), bench.clone(), settings(nonce));
    }

    fn bench<R>(&self, with: impl FnOnce(&mut Bench) -> R) -> R {
        with(&mut self.bench.0.borrow_mut())
    }

    /// Runs for some milliseconds, with a host if there is one.
    fn run(&mut self, mut host: Option<&mut Driver<'_>>, millis: u64) {
        for _ in 0..millis * 1000 / ROUND {
            let before = self.bench(|bench| {
                bench.now += ROUND;
                (bench.ticks, bench.commands.clone())
            });
            self.controller.step();
            let (now, ticked, sent) = self.bench(|bench| {
                let sent = core::mem::take(&mut bench.sent);
                (bench.now, bench.ticks > before.0, sent)
            });
            if ticked {
                self.judge(&before.1);
            }
            let Some(host) = host.as_deref_mut() else {
                continue;
            };
            for byte in sent {
                host.byte(byte, now);
            }
            let (mut scratch, mut buffer) = ([0; 256], [0; 256]);
            while let Some(frame) = host.poll(now, &mut scratch, &mut buffer) {
                let mut bytes = Vec::new();
                cobs::encode(frame, |byte| bytes.push(byte));
                self.bench(|bench| bench.received.extend(&bytes));
                self.recorded.push((now, bytes));
            }
        }
    }

    /// Checks a tick, and lets the hinges follow their commands: no hinge is commanded farther from where it stands than it
    /// may move, and none moves while a stop or a fault is latched. A hinge that had no command may be off by as much as
    /// an approach bridges.
    fn judge(&self, before: &[Option<f32>]) {
        self.bench(|bench| {
            let condition = *bench.conditions.last().unwrap();
            assert_eq!(bench.conditions.len(), bench.ticks);
            let latched = condition.stopped || condition.fault.is_some();
            for (hinge, command) in bench.commands.iter().enumerate() {
                let Some(command) = *command else { continue };
                let stands = &mut bench.stands[hinge];
                let most = match before.get(hinge) {
                    _ if latched => 0.0,
                    Some(Some(_)) => BOARD.speed * 1e-3,
                    _ => 0.1,
                };
                assert!(
                    (command - *stands).abs() <= most,
                    "{hinge}: {command} from {stands}, {condition:?}"
                );
                *stands = command;
            }
            let commanded = bench.commands.iter().flatten().count();
            assert_eq!(commanded, condition.commanded);
        });
    }

    /// Returns the angle that the first hinge is commanded, with the sign of its group.
    fn command(&self) -> Option<f32> {
        self.bench(|bench| {
            bench
                .commands
                .first()
                .copied()
                .flatten()
                .map(|angle| -angle)
        })
    }

    fn condition(&self) -> Condition {
        self.bench(|bench| *bench.conditions.last().unwrap())
    }
}

fn told(host: &Driver<'_>) -> Report {
    *host.sender().report().unwrap()
}

/// Power is cut and comes back at 20 moments. Nothing moves, whether the host goes on or begins anew, and whatever the
/// sensors say; an operator's word lets the fold begin once the sheet is flat again.
fn after_power_on_nothing_moves<const G: usize>() {
    let path = Path::new(G);
    let mut nonce = 0;
    for moment in 0..20 {
        let mut machine = Machine::<G>::new(nonce);
        let mut host = path.driver(Persistence::None, 7).confirming();
        machine.run(Some(&mut host), 600 + 75 * moment);
        let stood = machine.command().unwrap();
        assert!(stood > 0.15, "{stood}");
        for (persistence, sensor) in [
            (Persistence::Resume, None),
            (Persistence::None, None),
            (Persistence::Always, Some(EXACT)),
            (
                Persistence::None,
                Some((|hinge, _, _| if hinge == 2 { f32::NAN } else { 0.0 }) as Sensor),
            ),
        ] {
            nonce += 1;
            machine.cut_power(nonce);
            machine.bench(|bench| bench.sensor = sensor);
            let mut host = path.driver(persistence, 8);
            for _ in 0..50 {
                machine.run(Some(&mut host), 10);
                assert_eq!(machine.command(), None);
                // Every tick, the board is told that no hinge has a command.
                assert_eq!(machine.condition().commanded, 0);
            }
            let report = told(&host);
            assert_eq!((report.state, report.known), (State::Ready, false));
            let denied = host.sender().answer().unwrap().unwrap_err();
            let expected = match sensor {
                None => matches!(denied, Denial::Unknown(0)),
                Some(_) => matches!(denied, Denial::Spread(_) | Denial::Jump(0)),
            };
            assert!(expected, "{denied:?}");
        }
        // With sensors, an operator's word that is wrong is refused.
        machine.cut_power(nonce + 1);
        machine.bench(|bench| bench.sensor = Some(EXACT));
        let mut host = path.driver(Persistence::None, 9).confirming();
        machine.run(Some(&mut host), 90);
        assert_eq!(host.sender().answer(), Some(Err(Denial::Jump(0))));
        machine.run(Some(&mut host), 400);
        assert_eq!((told(&host).state, machine.command()), (State::Ready, None));
        if moment % 10 == 0 {
            machine.bench(|bench| bench.stands.fill(0.0));
            let mut host = path.driver(Persistence::None, 10).confirming();
            machine.run(Some(&mut host), 3500);
            assert_eq!(machine.condition().state, State::Done);
        }
        nonce += 2;
    }
    let mut machine = Machine::<G>::new(nonce);
    machine.bench(|bench| bench.sensor = Some(|_, command, _| command.unwrap_or(0.03)));
    let mut host = path.driver(Persistence::None, 9);
    machine.run(Some(&mut host), 200);
    // The hinges are measured at ±0.03, which is no one angle of a group.
    assert_eq!(machine.command(), None);
    machine.run(
        Some(&mut path.driver(Persistence::None, 10).confirming()),
        3500,
    );
    assert_eq!(machine.condition().state, State::Done);
}

#[test]
fn after_power_on_nothing_moves_from_an_unknown_place() {
    after_power_on_nothing_moves::<2>();
    after_power_on_nothing_moves::<11>();
    after_power_on_nothing_moves::<94>();
}

/// A warm reset at 20 moments, with the stop line drawn or not: place, angles and stop are kept, and the fold goes on.
fn a_reset_forgets_nothing<const G: usize>() {
    let path = Path::new(G);
    for moment in 0..20 {
        for stop in [false, true] {
            let mut machine = Machine::<G>::new(1);
            let mut host = path.driver(Persistence::None, 7).confirming();
            machine.run(Some(&mut host), 400 + 80 * moment);
            machine.bench(|bench| bench.stop = stop);
            machine.run(Some(&mut host), 3);
            let stood = machine.command().unwrap();
            machine.bench(|bench| bench.stop = false);
            machine.reset();
            machine.run(None, 100);
            let condition = machine.condition();
            assert_eq!((condition.stopped, condition.known), (stop, true));
            // Nobody has sent the hinges again: the board knows that none has a command.
            assert_eq!(condition.commanded, 0);
            let mut host = path.driver(Persistence::None, 8);
            machine.run(Some(&mut host), 300);
            if stop {
                assert_eq!(told(&host).reason, Reason::StopLine);
            } else {
                assert_eq!(host.sender().answer(), Some(Err(Denial::Jump(0))));
            }
            assert_eq!(machine.command(), Some(stood));
            // The first try goes on, also after a stop line.
            let mut host = path.driver(Persistence::Resume, 9);
            machine.run(Some(&mut host), 3500);
            assert_eq!(
                (told(&host).state, stop),
                (State::Done, stop),
                "{:?}",
                host.sender()
            );
        }
    }
}

#[test]
fn a_reset_forgets_neither_the_place_nor_the_stop_line() {
    a_reset_forgets_nothing::<2>();
    a_reset_forgets_nothing::<11>();
    a_reset_forgets_nothing::<94>();
}

/// The stop line is drawn while a hinge has stalled. Both are told and kept over a reset.
fn a_stop_in_a_fault_is_kept<const G: usize>() {
    let path = Path::new(G);
    let mut machine = Machine::<G>::new(1);
    machine.bench(|bench| {
        bench.sensor = Some(|hinge, angle, _| match angle {
            Some(angle) if hinge == 3 => angle.clamp(-0.3, 0.3),
            angle => angle.unwrap_or(0.0),
        });
    });
    let mut host = path.driver(Persistence::None, 7);
    machine.run(Some(&mut host), 3000);
    let fault = Fault::Stalled(3);
    assert_eq!(told(&host).reason, Reason::Fault(fault));
    let stood = machine.command();
    machine.bench(|bench| bench.stop = true);
    machine.run(Some(&mut host), 10);
    machine.bench(|bench| bench.stop = false);
    machine.run(Some(&mut host), 50);
    assert_eq!(
        (told(&host).reason, told(&host).stopped),
        (Reason::Fault(fault), true)
    );
    machine.reset();
    let mut host = path.driver(Persistence::None, 8);
    machine.run(Some(&mut host), 50);
    assert_eq!(
        (told(&host).reason, told(&host).stopped),
        (Reason::Fault(fault), true)
    );
    assert_eq!(
        (machine.condition().fault, machine.condition().stopped),
        (Some(fault), true)
    );
    machine.bench(|bench| bench.sensor = None);
    let mut host = path.driver(Persistence::Resume, 9);
    machine.run(Some(&mut host), 200);
    assert!(machine.command() >= stood);
    machine.run(Some(&mut host), 3500);
    assert_eq!(told(&host).state, State::Done);
}

#[test]
fn a_stop_line_that_is_drawn_in_a_fault_is_told_and_kept() {
    a_stop_in_a_fault_is_kept::<2>();
    a_stop_in_a_fault_is_kept::<11>();
    a_stop_in_a_fault_is_kept::<94>();
}

/// Hinges are commanded where they stand after `Unload`, after a fault was cleared, and while another sheet comes or is
/// refused, until the other sheet is complete.
#[test]
fn hinges_are_owned_until_another_sheet_is_complete() {
    use foldpath_core::wire::message::Item;
    use foldpath_core::wire::sender::{Sender, Source};
    /// The first items of a path.
    struct Part<'a>(PathItems<'a>, u64);
    impl Source for Part<'_> {
        fn item<'b>(&self, index: u64, scratch: &'b mut [u8]) -> Option<Item<'b>> {
            (index < self.1)
                .then(|| self.0.item(index, scratch))
                .flatten()
        }
    }
    fn talk<const G: usize>(
        machine: &mut Machine<G>,
        id: u32,
        source: &impl Source,
        command: Option<Command>,
    ) -> Report {
        let mut sender = Sender::new(id, Options::default());
        command.map(|command| sender.command(command));
        let mut deframer = cobs::Deframer::<512>::default();
        for _ in 0..400 {
            let (now, sent) = machine.bench(|bench| {
                bench.now += ROUND;
                (bench.now, core::mem::take(&mut bench.sent))
            });
            machine.controller.step();
            for byte in sent {
                if let Some(frame) = deframer.push(byte) {
                    sender.receive(frame, now);
                }
            }
            let (mut scratch, mut buffer) = ([0; 256], [0; 256]);
            while let Some(frame) = sender.poll(now, source, &mut scratch, &mut buffer) {
                cobs::encode(frame, |byte| {
                    machine.bench(|bench| bench.received.push_back(byte))
                });
            }
        }
        *sender.report().unwrap()
    }
    let path = Path::new(11);
    let mut machine = Machine::<11>::new(1);
    let mut host = path.driver(Persistence::None, 7).confirming();
    machine.run(Some(&mut host), 1000);
    host.stop();
    machine.run(Some(&mut host), 400);
    let stood = machine.bench(|bench| bench.commands.clone());
    assert_eq!(stood.iter().flatten().count(), 33);
    let still = |machine: &Machine<11>| machine.bench(|bench| bench.commands == stood);
    let nothing = Part(path.items(), 0);
    assert_eq!(
        talk(&mut machine, 8, &nothing, Some(Command::Unload)).state,
        State::Idle
    );
    assert!(still(&machine));
    // A sheet of more hinges than there is room for, and the head and limits of a sheet that fits.
    let wide = Path::new(94);
    let refused = talk(&mut machine, 9, &Part(wide.items(), 99), None).refused;
    assert_eq!(refused, Some(ItemRefusal::Room));
    assert!(still(&machine));
    let other = Path::new(5);
    talk(
        &mut machine,
        10,
        &Part(other.items(), other.items().head() as u64),
        None,
    );
    assert!(still(&machine));
    // With its first setpoint the other sheet is complete; nobody knows where it stands.
    let whole = Part(other.items(), other.items().head() as u64 + 1);
    let report = talk(&mut machine, 11, &whole, None);
    assert_eq!((report.state, report.known), (State::Ready, false));
    assert_eq!(machine.bench(|bench| bench.commands.clone()), [None; 15]);
    // It hangs flat on the board, and folds without a power cycle.
    machine.bench(|bench| bench.stands.fill(0.0));
    machine.run(
        Some(&mut other.driver(Persistence::None, 12).confirming()),
        3500,
    );
    assert_eq!(machine.condition().state, State::Done);
    // After a fault as well.
    machine.bench(|bench| bench.sensor = Some(|_, _, _| f32::NAN));
    let back = Path::from(5, 2.0, -1.0);
    machine.run(Some(&mut back.driver(Persistence::None, 13)), 2500);
    assert_eq!(machine.condition().state, State::Faulted);
    let stood = machine.bench(|bench| bench.commands.clone());
    talk(&mut machine, 14, &nothing, Some(Command::Clear));
    assert_eq!(machine.condition().state, State::Idle);
    assert_eq!(machine.bench(|bench| bench.commands.clone()), stood);
}

/// All bytes of a session that folded the sheet come again, at a board that was just switched on and at one that was
/// reset.
#[test]
fn recorded_bytes_do_nothing_in_another_run() {
    let path = Path::new(2);
    let mut machine = Machine::<2>::new(1);
    let mut host = path.driver(Persistence::None, 7).confirming();
    machine.run(Some(&mut host), 3500);
    assert_eq!(told(&host).state, State::Done);
    let recorded = machine.recorded.clone();
    let replay = |machine: &mut Machine<2>| {
        let mut before = recorded[0].0;
        for (time, bytes) in &recorded {
            // In the rhythm in which they came.
            let passed = time - before;
            before = *time;
            machine.run(None, passed.div_ceil(1000));
            machine.bench(|bench| bench.received.extend(bytes));
        }
    };
    for nonce in [2, 1 << 32, u64::MAX] {
        let mut fresh = Machine::<2>::new(nonce);
        replay(&mut fresh);
        assert_eq!(
            (fresh.condition().state, fresh.command()),
            (State::Idle, None)
        );
    }
    // A warm reset leaves the hardware's number as it was.
    machine.reset();
    replay(&mut machine);
    assert_eq!(machine.condition().state, State::Idle);
}

/// A host asks for limits that no board has, and for a leap of 100 rad in a millisecond.
#[test]
fn no_message_widens_the_limits_of_the_board() {
    for (lower, upper, speed) in [
        (-1e6, 1e6, f32::INFINITY),
        (-3.0, 3.0, 1e9),
        (5.0, 9.0, 1.0),
    ] {
        let mut path = Path::new(2);
        for limits in &mut path.limits {
            (limits.lower, limits.upper, limits.speed) = (lower, upper, speed);
        }
        // From 0 to 2 rad in a millisecond.
        path.times = path.times.iter().map(|time| time * 5e-4).collect();
        path.rates = path.rates.iter().map(|_| 2e3).collect();
        let mut machine = Machine::<2>::new(1);
        let mut host = path.driver(Persistence::None, 7).confirming();
        machine.run(Some(&mut host), 1000);
        assert!(told(&host).refused.is_some(), "{:?}", told(&host));
        assert!(machine.command().is_none_or(|angle| angle.abs() < 1e-6));
    }
}

/// A board that asks for essential vertices takes no sheet without.
#[test]
fn a_sheet_with_vertices_needs_its_spokes() {
    use foldpath_firmware_sim::controller::Settings;
    let path = Path::new(2);
    let bench = Shared::default();
    let settings = Settings {
        closed: true,
        ..settings(1)
    };
    let controller = Application::new(bench.clone(), bench.clone(), settings);
    let mut machine = Machine::<2> {
        controller: Box::new(controller),
        bench,
        recorded: Vec::new(),
        nonce: 1,
    };
    let mut host = path.driver(Persistence::None, 7).confirming();
    machine.run(Some(&mut host), 300);
    assert_eq!(told(&host).refused, Some(ItemRefusal::Stars));
}

/// The stop line is drawn and let go in the middle of a fold; the first `--resume` goes on.
#[test]
fn the_first_resume_after_a_stop_line_goes_on() {
    for moment in 0..20 {
        let path = Path::new(2);
        let mut machine = Machine::<2>::new(1);
        let mut host = path.driver(Persistence::None, 7).confirming();
        machine.run(Some(&mut host), 400 + 80 * moment);
        machine.bench(|bench| bench.stop = true);
        machine.run(Some(&mut host), 20);
        machine.bench(|bench| bench.stop = false);
        machine.run(Some(&mut host), 700);
        let mut host = path.driver(Persistence::Resume, 8);
        for _ in 0..3500 {
            machine.run(Some(&mut host), 1);
            assert_ne!(host.sender().answer(), Some(Err(Denial::Held)));
        }
        assert_eq!(told(&host).state, State::Done);
    }
}

/// The way back is another path: nobody takes a place on the one for a place on the other.
#[test]
fn a_place_belongs_to_its_path() {
    let (path, back) = (Path::new(2), Path::from(2, 2.0, -1.0));
    let mut machine = Machine::<2>::new(1);
    let mut host = path.driver(Persistence::None, 7).confirming();
    machine.run(Some(&mut host), 1000);
    host.stop();
    machine.run(Some(&mut host), 400);
    let mut other = back.driver(Persistence::Resume, 8);
    machine.run(Some(&mut other), 300);
    assert!(other.astray().is_some());
    let mut host = path.driver(Persistence::Resume, 9);
    machine.run(Some(&mut host), 3000);
    assert_eq!(told(&host).state, State::Done);
    let mut other = back.driver(Persistence::None, 10);
    machine.run(Some(&mut other), 3500);
    assert_eq!(told(&other).state, State::Done);
    assert!(machine.command().unwrap().abs() < 1e-6);
}

/// 94 groups take four items a setpoint, and the controller tells its room.
#[test]
fn setpoints_of_any_number_of_groups_come_in_pieces() {
    let path = Path::new(94);
    let mut machine = Machine::<94>::new(1);
    let mut host = path.driver(Persistence::None, 7).confirming();
    assert_eq!(path.items().pieces(), 4);
    machine.run(Some(&mut host), 3500);
    assert_eq!(told(&host).state, State::Done);
    assert_eq!((host.setpoints(), host.is_done()), (21, true));
    let capacity = host.sender().capacity().unwrap();
    assert_eq!(
        (capacity.groups, capacity.hinges, capacity.knots),
        (94, 282, 16)
    );
    assert_eq!(host.sender().repeated(), 0);
}

/// The drives are limp in a reset, and the sheet moves a little by itself. With sensors the fold goes on from where the
/// sheet stands; without, nobody knows where that is.
fn limp_drives_tell_no_place<const G: usize>() {
    let path = Path::new(G);
    for (moment, (senses, off)) in [(true, 0.02), (true, -0.05), (true, 0.3), (false, 0.05)]
        .into_iter()
        .enumerate()
    {
        let mut machine = Machine::<G>::new(1);
        let mut host = path.driver(Persistence::None, 7).confirming();
        machine.run(Some(&mut host), 600 + 200 * moment as u64);
        let stood = machine.command().unwrap();
        machine.bench(|bench| {
            bench.limp = true;
            bench.sensor = senses.then_some(EXACT);
            for (hinge, stands) in bench.stands.iter_mut().enumerate() {
                *stands += path.hinges[hinge].apply(off);
            }
        });
        machine.reset();
        machine.run(None, 50);
        assert!(!machine.condition().known);
        // A second reset does not make the place known again.
        machine.reset();
        let mut host = path.driver(Persistence::Resume, 8);
        machine.run(Some(&mut host), 200);
        let goes_on = senses && off < 0.1;
        if !goes_on {
            machine.run(Some(&mut host), 300);
            let denied = host.sender().answer().unwrap().unwrap_err();
            let expected = if senses {
                matches!(denied, Denial::Jump(0) | Denial::Unknown(0))
            } else {
                denied == Denial::Unknown(0)
            };
            assert!(expected, "{denied:?}");
            assert_eq!((told(&host).state, machine.command()), (State::Ready, None));
            continue;
        }
        let command = machine.command().unwrap();
        assert!((command - stood - off).abs() < 0.02, "{command} {stood}");
        machine.run(Some(&mut host), 4000);
        assert_eq!(told(&host).state, State::Done);
    }
}

#[test]
fn drives_that_were_limp_in_a_reset_tell_no_place() {
    limp_drives_tell_no_place::<2>();
    limp_drives_tell_no_place::<11>();
    limp_drives_tell_no_place::<94>();
}

/// A reset, or the end of the host's patience, comes in the middle of an approach.
#[test]
fn an_approach_is_stopped_by_its_host_and_goes_on_behind_a_reset() {
    let path = Path::from(11, 0.08, 1.0);
    for moment in 0..20 {
        let mut machine = Machine::<11>::new(1);
        machine.bench(|bench| bench.sensor = Some(EXACT));
        let mut host = path.driver(Persistence::None, 7);
        machine.run(Some(&mut host), 150 + 35 * moment);
        assert_eq!(told(&host).reason, Reason::Approach, "{moment}");
        host.stop();
        machine.run(Some(&mut host), 400);
        assert_eq!(
            (told(&host).state, told(&host).reason),
            (State::Holding, Reason::Asked)
        );
        let stood = machine.command().unwrap();
        machine.run(Some(&mut host), 100);
        assert_eq!(machine.command(), Some(stood));
        assert!(stood < 0.08);
        if moment % 2 == 0 {
            machine.reset();
        }
        let mut host = path.driver(Persistence::Resume, 8);
        machine.run(Some(&mut host), 5000);
        assert_eq!(told(&host).state, State::Done, "{:?}", told(&host));
    }
}

/// `Stand` commands nothing by itself, and is denied while something holds.
#[test]
fn a_word_moves_nothing_and_passes_no_stop() {
    let path = Path::new(2);
    let mut machine = Machine::<2>::new(1);
    machine.bench(|bench| bench.stop = true);
    let mut host = path.driver(Persistence::None, 7).confirming();
    machine.run(Some(&mut host), 200);
    machine.bench(|bench| bench.stop = false);
    machine.run(Some(&mut host), 300);
    assert_eq!(host.sender().answer(), Some(Err(Denial::Held)));
    assert_eq!((machine.command(), told(&host).known), (None, false));
    assert_eq!(told(&host).reason, Reason::StopLine);
}
