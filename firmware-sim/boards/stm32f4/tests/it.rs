//! Does the example of this port fit its sizes, and does the controller follow it with the servos of this board? Nothing
//! of this was tried on hardware: servos and potentiometers are numbers here.

#[path = "../../../tests/it/port.rs"]
mod port;

use core::cell::RefCell;
use core::convert::Infallible;
use std::collections::VecDeque;
use std::rc::Rc;

use embedded_io::{ErrorType, Read, ReadReady, Write, WriteReady};
use foldpath_controller::retained;
use foldpath_controller::{Application, Board, Condition, Hold, Player, Power, Settings};
use foldpath_core::follower::{FollowerPosition, Measurement, Reason, State, Target};
use foldpath_core::trajectory::TrajectoryView;
use foldpath_core::trajectory_file::TrajectoryFile;
use foldpath_core::wire::cobs;
use foldpath_core::wire::driver::{Driver, Persistence};
use foldpath_core::wire::path::PathItems;
use foldpath_core::wire::sender::Options;
use foldpath_core::{GroupLimits, Membership, Spoke, StarsView};
use foldpath_port_stm32f4::{
    Button, GROUPS, HINGES, KNOTS, LIMITS, PATH, Press, SPOKES, angle, pulse,
};
use port::Rig as _;

/// Microseconds of a round of the main loop.
const ROUND: u64 = 250;
/// Most that a servo turns in a millisecond, radians: 60 degrees in 0.13 s, as small servos have it.
const TURN: f32 = 8e-3;

/// Four servos that turn towards their pulses, and potentiometers.
#[derive(Default)]
struct Servos {
    power: Power,
    pulses: [Option<u16>; HINGES],
    holds: [Hold; HINGES],
    stands: [f32; HINGES],
    /// Number of a potentiometer whose wire is broken, and of a hinge that is blocked.
    broken: Option<usize>,
    blocked: Option<usize>,
}

impl port::Rig for Servos {
    const LIMITS: GroupLimits = LIMITS;
    /// A microsecond of a pulse.
    const ERROR: f32 = LIMITS.upper / 500.0;

    fn power(&mut self, power: Power) {
        self.power = power;
    }

    fn drive(
        &mut self,
        hinge: u32,
        target: Option<Target<f32>>,
        _: u64,
    ) -> Option<Measurement<f32>> {
        let hinge = hinge as usize;
        let reading = if self.broken == Some(hinge) {
            0
        } else {
            let reading = (2048.0 + 0.8 * 2048.0 * self.stands[hinge] / LIMITS.upper).round();
            #[allow(
                clippy::cast_possible_truncation,
                clippy::cast_sign_loss,
                reason = "from 0 to 4095"
            )]
            let reading = reading as u16;
            reading
        };
        let measured = angle(reading);
        let command = self.holds[hinge].command(self.power, target, Some(measured));
        self.pulses[hinge] = command.map(pulse);
        Some(measured.into())
    }

    fn commit(&mut self, _: u64) {
        for (hinge, (stands, pulse)) in self.stands.iter_mut().zip(self.pulses).enumerate() {
            let goal = pulse.map(|pulse| (f32::from(pulse) - 1500.0) / 500.0 * LIMITS.upper);
            let way = goal.map_or(0.0, |goal| (goal - *stands).clamp(-TURN, TURN));
            *stands += if self.blocked == Some(hinge) {
                0.0
            } else {
                way
            };
        }
    }

    fn angles(&self) -> Vec<f32> {
        self.stands.to_vec()
    }

    fn block(&mut self, hinge: Option<usize>) {
        self.blocked = hinge;
    }

    fn turn(&mut self, angle: f32) -> bool {
        let free = self.pulses == [None; HINGES];
        if free {
            self.stands = [angle; HINGES];
        }
        free
    }
}

/// The board.
#[derive(Default)]
struct Bench {
    now: u64,
    drawn: bool,
    received: VecDeque<u8>,
    sent: Vec<u8>,
    servos: Servos,
    condition: Option<Condition>,
    records: [Vec<u8>; 2],
}

#[derive(Clone, Default)]
struct Shared(Rc<RefCell<Bench>>);

impl Board for Shared {
    const RECORD: usize = retained::size(GROUPS);

    fn now(&mut self) -> u64 {
        self.0.borrow().now
    }

    fn stop(&mut self) -> bool {
        self.0.borrow().drawn
    }

    fn power(&mut self, condition: &Condition) {
        let mut bench = self.0.borrow_mut();
        bench.condition = Some(*condition);
        bench.servos.power(condition.power);
    }

    fn drive(
        &mut self,
        hinge: u32,
        _: Membership,
        target: Option<Target<f32>>,
    ) -> Option<Measurement<f32>> {
        self.0.borrow_mut().servos.drive(hinge, target, 0)
    }

    fn commit(&mut self) {
        self.0.borrow_mut().servos.commit(0);
    }

    /// As on the board: servos have no pulses in a reset.
    fn held(&mut self) -> bool {
        false
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

    fn feed(&mut self) {}
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
            .map(|(at, byte)| *at = byte)
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

/// The path of a `.traj` file, which owns its memory.
struct Path {
    file: TrajectoryFile<'static>,
    spans: Vec<f32>,
    angles: Vec<f32>,
    rates: Vec<f32>,
    limits: Vec<GroupLimits>,
    hinges: Vec<Membership>,
    spokes: Vec<Spoke<f32>>,
    ends: Vec<u32>,
}

impl Path {
    fn example() -> Self {
        let file = TrajectoryFile::read(PATH).unwrap();
        let places = (0..file.len()).flat_map(|knot| (0..file.groups()).map(move |g| (knot, g)));
        let nodes: Vec<_> = places
            .map(|(knot, g)| file.node(knot, g).unwrap())
            .collect();
        let spokes = || file.spokes().enumerate();
        Self {
            spans: (0..file.len())
                .map(|knot| file.span(knot).unwrap())
                .collect(),
            angles: nodes.iter().map(|node| node.angle).collect(),
            rates: nodes.iter().map(|node| node.rate).collect(),
            limits: (0..file.groups())
                .map(|g| file.limits(g).unwrap())
                .collect(),
            hinges: file.memberships().collect(),
            spokes: spokes().map(|(_, (spoke, _))| spoke).collect(),
            ends: spokes()
                .filter(|(_, (_, last))| *last)
                .map(|(at, _)| u32::try_from(at).unwrap() + 1)
                .collect(),
            file,
        }
    }

    fn driver(&self, id: u32, persistence: Persistence) -> Driver<'_> {
        let groups = self.file.groups();
        let (kind, none) = (self.file.interpolation(), &[][..]);
        let view = TrajectoryView::new(kind, groups, &self.spans, &self.angles, &self.rates, none);
        let stars = StarsView::new(&self.spokes, &self.ends, groups).unwrap();
        let (closure, place) = (self.file.closure(), FollowerPosition::default());
        let items = PathItems::new(
            view.unwrap(),
            &self.limits,
            &self.hinges,
            stars,
            closure,
            place,
        );
        Driver::new(items.unwrap(), persistence, id, Options::default())
    }
}

/// The controller of the port, and its bench.
struct Machine {
    bench: Shared,
    controller: Box<Application<Shared, Shared, GROUPS, HINGES, SPOKES, KNOTS>>,
}

impl Machine {
    fn new() -> Self {
        let bench = Shared::default();
        bench.0.borrow_mut().now = 1_000_000;
        let mut machine = Self {
            controller: Box::new(Self::controller(&bench, 1)),
            bench,
        };
        machine.run(None, 2);
        machine
    }

    fn controller(
        bench: &Shared,
        nonce: u64,
    ) -> Application<Shared, Shared, GROUPS, HINGES, SPOKES, KNOTS> {
        Application::new(
            bench.clone(),
            bench.clone(),
            Settings::new([nonce, 0], |_| LIMITS),
        )
    }

    fn run(&mut self, mut host: Option<&mut Driver<'_>>, millis: u64) {
        for _ in 0..millis * 1000 / ROUND {
            self.bench.0.borrow_mut().now += ROUND;
            self.controller.step();
            let mut bench = self.bench.0.borrow_mut();
            let (now, sent) = (bench.now, core::mem::take(&mut bench.sent));
            let Some(host) = host.as_deref_mut() else {
                continue;
            };
            for byte in sent {
                host.byte(byte, now);
            }
            let (mut scratch, mut buffer) = ([0; 256], [0; 256]);
            while let Some(frame) = host.poll(now, &mut scratch, &mut buffer) {
                cobs::encode(frame, |byte| bench.received.push_back(byte));
            }
        }
    }

    fn bench<R>(&self, with: impl FnOnce(&mut Bench) -> R) -> R {
        with(&mut self.bench.0.borrow_mut())
    }

    fn condition(&self) -> Condition {
        self.bench(|bench| bench.condition.unwrap())
    }
}

/// Returns the farthest distance of a hinge from its angle at the end of the path, radians.
fn off(path: &Path, machine: &Machine) -> f32 {
    let end = &path.angles[path.angles.len() - path.file.groups()..];
    let hinges = path
        .hinges
        .iter()
        .zip(machine.bench(|bench| bench.servos.stands));
    hinges
        .map(|(hinge, stands)| (hinge.apply(end[hinge.group.index()]) - stands).abs())
        .fold(0.0, f32::max)
}

#[test]
fn the_example_fits_its_sizes_and_folds() {
    let path = Path::example();
    let sizes = [path.file.groups(), path.hinges.len(), path.spokes.len()];
    assert_eq!(sizes, [GROUPS, HINGES, SPOKES]);
    let mut machine = Machine::new();
    let mut host = path.driver(7, Persistence::None);
    // The potentiometers tell where the sheet stands: nobody has to say so.
    for _ in 0..4000 {
        machine.run(Some(&mut host), 1);
        let reason = machine.condition().reason;
        assert!(
            matches!(reason, Reason::None | Reason::Approach),
            "{reason:?}"
        );
    }
    assert_eq!(
        machine.condition().state,
        State::Done,
        "{:?}",
        host.sender()
    );
    assert!(path.spans.iter().sum::<f32>() > 1.5);
    // Half a microsecond of a pulse.
    assert!(off(&path, &machine) <= 0.5 * LIMITS.upper / 500.0 + 1e-6);
}

#[test]
fn the_port_goes_through_its_life() {
    port::lives::<_, HINGES>(Servos::default());
}

/// A stop line that is drawn stops in the tick that reads it; after a reset, in which servos are limp, the fold goes on from
/// where the potentiometers find the sheet.
#[test]
fn the_example_stops_and_goes_on_behind_a_reset() {
    let path = Path::example();
    for moment in 0..8 {
        let mut machine = Machine::new();
        let mut host = path.driver(7, Persistence::None);
        machine.run(Some(&mut host), 700 + 150 * moment);
        machine.bench(|bench| bench.drawn = true);
        machine.run(Some(&mut host), 1);
        let pulses = machine.bench(|bench| bench.servos.pulses);
        machine.run(Some(&mut host), 200);
        assert_eq!(machine.bench(|bench| bench.servos.pulses), pulses);
        assert_eq!(machine.condition().reason, Reason::StopLine);
        machine.bench(|bench| {
            (bench.drawn, bench.servos.pulses) = (false, [None; HINGES]);
            bench.received.clear();
            bench.sent.clear();
        });
        *machine.controller = Machine::controller(&machine.bench, 1);
        machine.run(None, 100);
        let condition = machine.condition();
        assert!(condition.stopped && !condition.known);
        assert_eq!(machine.bench(|bench| bench.servos.pulses), [None; HINGES]);
        let mut host = path.driver(8, Persistence::Resume);
        machine.run(Some(&mut host), 5000);
        assert_eq!(
            machine.condition().state,
            State::Done,
            "{:?}",
            host.sender()
        );
    }
}

#[test]
fn a_broken_wire_of_a_potentiometer_holds_the_motion() {
    let path = Path::example();
    let mut machine = Machine::new();
    let mut host = path.driver(7, Persistence::None);
    machine.run(Some(&mut host), 1000);
    machine.bench(|bench| bench.servos.broken = Some(2));
    machine.run(Some(&mut host), 500);
    assert_eq!(machine.condition().reason, Reason::Lag(2));
    let pulses = machine.bench(|bench| bench.servos.pulses);
    machine.run(Some(&mut host), 300);
    assert_eq!(machine.bench(|bench| bench.servos.pulses), pulses);
    machine.bench(|bench| bench.servos.broken = None);
    machine.run(Some(&mut host), 3000);
    assert_eq!(machine.condition().state, State::Done);
}

#[test]
fn pulses_and_readings_have_their_bounds() {
    assert_eq!(
        [-9.0, -LIMITS.upper, 0.0, LIMITS.upper, 9.0, f32::NAN].map(pulse),
        [1000, 1000, 1500, 2000, 2000, 0]
    );
    assert_eq!(angle(2048).to_bits(), 0);
    assert!((angle(2048 + 1638) - LIMITS.upper).abs() < 1e-3);
    assert!(
        [0, 102, 3994, 4095]
            .map(angle)
            .iter()
            .all(|angle| angle.is_nan())
    );
}

#[test]
fn the_button_plays_the_example_from_flash() {
    let path = Path::example();
    let mut machine = Machine::new();
    let mut player = Player::new(PATH, None).unwrap();
    let mut button = Button::default();
    // One second without a press, and then a press of a tenth of a second whose contacts bounce.
    for millis in 0..8000 {
        let bounces = millis == 990 || millis == 994;
        let down = bounces || (1000..1100).contains(&millis);
        match button.look(down) {
            Some(Press::Short) => player.press(),
            Some(Press::Long) => player.press_flat(),
            None => {}
        }
        machine.run(None, 1);
        machine.controller.play(&mut player);
        if millis < 1100 {
            assert_eq!(machine.condition().state, State::Idle);
        }
    }
    assert_eq!(machine.condition().state, State::Done);
    assert!(off(&path, &machine) <= 0.5 * LIMITS.upper / 500.0 + 1e-6);
}

#[test]
fn presses_are_told_once() {
    let mut button = Button::default();
    let mut presses = |down: bool, millis: u32| -> Vec<Press> {
        (0..millis).filter_map(|_| button.look(down)).collect()
    };
    assert_eq!(presses(true, 19), []);
    assert_eq!(presses(false, 5), []);
    assert_eq!(presses(true, 20), []);
    assert_eq!(presses(false, 5), [Press::Short]);
    assert_eq!(presses(true, 1999), []);
    assert_eq!(presses(true, 5000), [Press::Long]);
    assert_eq!(presses(false, 50), []);
}
