//! One hinge is watched and moved alone: only when that is safe, slowly, from a place that is known. Telemetry tells what
//! was measured.

use core::cell::Cell;

use foldpath_controller::retained::{OFF_PATH, Record};
use foldpath_controller::{ALONE, Controller, Settings};
use foldpath_core::GroupLimits;
use foldpath_core::follower::{Denial, Fault, FollowerPosition, Measurement, Reason, State};
use foldpath_core::wire::cobs::{self, Deframer};
use foldpath_core::wire::frame;
use foldpath_core::wire::message::{Command, Report, SCHEMA, ToDevice, ToHost, VERSION};
use foldpath_core::wire::protection::Unkeyed;
use foldpath_core::wire::sender::Source;

use crate::path::{BOARD, Path, settings};

/// Number of hinges for which the device has room, and the hinge that is moved.
const HINGES: u16 = 64;
const HINGE: u16 = 51;

type Device = Controller<4, 64, 32, 16>;

/// A message of measured angles.
#[derive(Clone, Debug, PartialEq)]
struct Measured {
    time: u64,
    first: u16,
    target: Option<f32>,
    angles: Vec<f32>,
}

/// What the board's sensors tell of a hinge, from its number and its command, radians; with its age.
type Sensor = fn(u32, Option<f32>) -> Option<Measurement<f32>>;

/// A host and a board, tick by tick.
struct Bench {
    device: Box<Device>,
    now: u64,
    session: u32,
    sequence: u16,
    number: u8,
    deframer: Deframer<512>,
    report: Option<Report>,
    sensor: Sensor,
    /// Command of each hinge in the last tick, with its rate; no entry for a hinge that was not driven.
    commands: Vec<(u32, Option<(f32, f32)>)>,
    measured: Vec<Measured>,
    /// Times of messages of telemetry.
    telemetry: Vec<u64>,
    /// Largest change of a command in a tick, radians.
    step: f32,
}

impl Bench {
    fn new(sensor: Sensor) -> Self {
        Self::with(settings(1), sensor)
    }

    fn with(settings: Settings, sensor: Sensor) -> Self {
        let mut bench = Self {
            device: Box::new(Device::protected(settings, Unkeyed)),
            now: 1_000_000,
            session: 0,
            sequence: 0,
            number: 0,
            deframer: Deframer::default(),
            report: None,
            sensor,
            commands: Vec::new(),
            measured: Vec::new(),
            telemetry: Vec::new(),
            step: 0.0,
        };
        bench.tick();
        bench.greet(5);
        bench
    }

    fn greet(&mut self, id: u32) {
        (self.session, self.sequence, self.number) = (0, 0, 0);
        let (version, schema) = (VERSION, SCHEMA);
        self.say(&ToDevice::Hello {
            version,
            schema,
            id,
        });
        self.say(&ToDevice::Alive);
    }

    fn say(&mut self, message: &ToDevice<'_>) {
        let mut buffer = [0; 256];
        let frame = frame::seal(self.session, message, &mut buffer).unwrap();
        cobs::encode(frame, |byte| self.device.byte(byte, self.now));
        self.listen();
    }

    fn listen(&mut self) {
        self.device.poll(self.now);
        while let Some(byte) = self.device.take() {
            let Some(frame) = self.deframer.push(byte) else {
                continue;
            };
            match frame::open(frame) {
                Some((_, ToHost::Welcome { session, .. })) => self.session = session,
                Some((_, ToHost::Report(report))) => self.report = Some(report),
                Some((_, ToHost::Telemetry { time, .. })) => self.telemetry.push(time),
                Some((
                    _,
                    ToHost::Measured {
                        time,
                        first,
                        target,
                        angles,
                    },
                )) => {
                    let (angles, _) = angles.as_chunks();
                    let angles = angles.iter().copied().map(f32::from_le_bytes).collect();
                    self.measured.push(Measured {
                        time,
                        first,
                        target,
                        angles,
                    });
                }
                _ => {}
            }
        }
    }

    fn command(&mut self, command: Command) -> Result<(), Denial> {
        self.number = self.number.wrapping_add(1);
        let number = self.number;
        self.say(&ToDevice::Command { number, command });
        let report = self.report.unwrap();
        assert_eq!(report.command, number);
        report.denied.map_or(Ok(()), Err)
    }

    fn jog(&mut self, hinge: u16, from: Option<f32>, to: Option<f32>) -> Result<(), Denial> {
        self.command(Command::Jog { hinge, from, to })
    }

    /// Ticks as a board does, and checks that no hinge that had a command moves farther than it may.
    fn tick(&mut self) {
        self.now += 1000;
        self.device.tick(self.now);
        let before = core::mem::take(&mut self.commands);
        let (commands, sensor) = (&mut self.commands, self.sensor);
        self.device.drive(|hinge, membership, target| {
            commands.push((hinge, target.map(|target| (target.angle, target.rate))));
            assert!(hinge < 50 || membership == ALONE);
            sensor(hinge, target.map(|target| target.angle))
        });
        let commanded = self.commands.iter().filter(|(_, to)| to.is_some()).count();
        assert_eq!(self.device.condition().commanded, commanded);
        for (hinge, to) in &self.commands {
            let was = before.iter().find(|(other, _)| other == hinge);
            if let (Some((_, Some((was, _)))), Some((to, _))) = (was, to) {
                self.step = self.step.max((to - was).abs());
            }
        }
        self.listen();
    }

    /// Ticks for some milliseconds, while the host is heard.
    fn run(&mut self, millis: u64) {
        for milli in 0..millis {
            if milli % 100 == 0 {
                self.say(&ToDevice::Alive);
            }
            self.tick();
        }
    }

    fn angle(&self, hinge: u16) -> Option<f32> {
        let command = self
            .commands
            .iter()
            .find(|(other, _)| *other == u32::from(hinge));
        command?.1.map(|(angle, _)| angle)
    }

    /// Sends the sheet of a path and its first setpoints.
    fn load(&mut self, path: &Path) {
        let items = path.items(FollowerPosition::default());
        let (mut scratch, first) = ([0; 256], self.sequence);
        for index in 0..items.head() as u64 + 16 {
            let (sequence, item) = (self.sequence, items.item(index, &mut scratch).unwrap());
            self.say(&ToDevice::Item { sequence, item });
            self.sequence = self.report.unwrap().next;
            assert_eq!(
                u64::from(self.sequence - first),
                index + 1,
                "{:?}",
                self.report
            );
        }
    }
}

const BLIND: Sensor = |_, _| None;
/// A sensor of hinge 51 alone, which follows its command and stands at 0.3 without one.
const ONE: Sensor =
    |hinge, command| (hinge == u32::from(HINGE)).then(|| command.unwrap_or(0.3).into());

#[test]
fn a_hinge_moves_slowly_from_where_it_was_measured() {
    let mut bench = Bench::new(ONE);
    assert_eq!(
        bench.jog(HINGE, None, Some(0.5)),
        Err(Denial::Unknown(HINGE))
    );
    assert_eq!(bench.angle(HINGE), None);
    assert_eq!(bench.jog(HINGE, None, None), Ok(()));
    bench.run(50);
    // Watched, and not commanded.
    assert_eq!(bench.commands, [(HINGE.into(), None)]);
    let told = bench.measured.last().unwrap();
    assert_eq!(
        (told.first, told.target, &told.angles[..]),
        (HINGE, None, &[0.3][..])
    );
    assert_eq!(bench.jog(HINGE, None, Some(0.5)), Ok(()));
    bench.tick();
    assert!((bench.angle(HINGE).unwrap() - 0.3001).abs() < 1e-6);
    assert_eq!(bench.commands[0].1.unwrap().1.to_bits(), 0.1_f32.to_bits());
    bench.run(1000);
    let half = bench.angle(HINGE).unwrap();
    assert!((half - 0.4001).abs() < 1e-4, "{half}");
    bench.run(1050);
    let rests = [(u32::from(HINGE), Some((0.5, 0.0)))];
    assert_eq!(bench.commands, rests);
    let told = bench.measured.last().unwrap();
    assert_eq!((told.target, &told.angles[..]), (Some(0.5), &[0.5][..]));
    assert!(bench.step <= 1.01e-4, "{}", bench.step);
    // And back, from its command, whatever the sensor tells.
    assert_eq!(bench.jog(HINGE, None, Some(-0.1)), Ok(()));
    bench.run(7000);
    assert_eq!(bench.angle(HINGE), Some(-0.1));
    assert!(bench.step <= 1.01e-4);
}

#[test]
fn without_a_sensor_an_operator_says_where_the_hinge_stands() {
    let mut bench = Bench::new(BLIND);
    assert_eq!(bench.jog(3, None, Some(0.0)), Err(Denial::Unknown(3)));
    assert_eq!(bench.jog(3, Some(0.2), Some(0.0)), Ok(()));
    bench.tick();
    assert!((bench.angle(3).unwrap() - 0.1999).abs() < 1e-6);
    bench.run(2100);
    assert_eq!(bench.angle(3), Some(0.0));
    let told = bench.measured.last().unwrap();
    assert!(told.target == Some(0.0) && told.angles.len() == 1 && told.angles[0].is_nan());
    // It goes on from there; another hinge is another jog, and the first has no command then.
    assert_eq!(bench.jog(3, None, Some(0.01)), Ok(()));
    bench.run(200);
    assert_eq!(bench.jog(4, None, Some(0.0)), Err(Denial::Unknown(4)));
    bench.tick();
    assert_eq!(bench.angle(3), Some(0.01));
    assert_eq!(bench.jog(4, Some(0.0), Some(0.1)), Ok(()));
    bench.tick();
    assert_eq!((bench.commands.len(), bench.angle(3)), (1, None));
    assert_eq!(bench.jog(3, None, Some(0.0)), Err(Denial::Unknown(3)));
}

#[test]
fn a_word_that_a_sensor_contradicts_is_refused() {
    let mut bench = Bench::new(ONE);
    bench.jog(HINGE, None, None).unwrap();
    bench.run(10);
    assert_eq!(
        bench.jog(HINGE, Some(0.41), Some(0.5)),
        Err(Denial::Jump(HINGE))
    );
    assert_eq!(
        bench.jog(HINGE, Some(0.19), Some(0.5)),
        Err(Denial::Jump(HINGE))
    );
    assert_eq!(bench.jog(HINGE, Some(0.39), Some(0.5)), Ok(()));
    bench.tick();
    // From where it was measured.
    assert!((bench.angle(HINGE).unwrap() - 0.3001).abs() < 1e-6);
    for (sensor, hinge) in [
        ((|_, _| Some(f32::NAN.into())) as Sensor, 5),
        // Beyond the limits of the board by more than 0.1 rad.
        (|_, _| Some(3.31.into()), 6),
    ] {
        bench.sensor = sensor;
        bench.jog(hinge, None, None).unwrap();
        bench.run(10);
        assert_eq!(bench.jog(hinge, None, Some(0.5)), Err(Denial::Jump(hinge)));
        assert_eq!(
            bench.jog(hinge, Some(0.5), Some(0.5)),
            Err(Denial::Jump(hinge))
        );
    }
    // An old measurement is none.
    bench.sensor = |_, _| {
        Some(Measurement {
            angle: 0.0,
            age: 1_000_001,
        })
    };
    bench.jog(7, None, None).unwrap();
    bench.run(10);
    assert_eq!(bench.jog(7, None, Some(0.5)), Err(Denial::Unknown(7)));
    bench.sensor = |_, _| Some(0.0.into());
    bench.run(2);
    bench.sensor = BLIND;
    bench.run(990);
    assert_eq!(bench.jog(7, None, Some(0.5)), Ok(()));
    bench.jog(8, None, None).unwrap();
    bench.sensor = |_, _| Some(0.0.into());
    bench.run(2);
    bench.sensor = BLIND;
    bench.run(1010);
    assert_eq!(bench.jog(8, None, Some(0.5)), Err(Denial::Unknown(8)));
}

#[test]
fn angles_beyond_the_limits_of_the_board_are_denied() {
    fn limits(hinge: u32) -> GroupLimits {
        match hinge {
            9 => GroupLimits {
                lower: 0.0,
                upper: 0.5,
                ..BOARD
            },
            10 => GroupLimits {
                speed: 0.02,
                ..BOARD
            },
            11 => GroupLimits {
                lower: f32::NAN,
                ..BOARD
            },
            _ => BOARD,
        }
    }
    let settings = Settings {
        limits,
        ..settings(1)
    };
    let mut bench = Bench::with(settings, BLIND);
    for (hinge, from, to) in [
        (9, 0.0, 0.51),
        (9, -0.01, 0.1),
        (9, 0.0, f32::NAN),
        (9, f32::NAN, 0.1),
        (9, 0.0, f32::INFINITY),
        (11, 0.0, 0.0),
        (HINGES, 0.0, 0.1),
        (u16::MAX, 0.0, 0.1),
    ] {
        assert_eq!(
            bench.jog(hinge, Some(from), Some(to)),
            Err(Denial::Range),
            "{hinge} {from} {to}"
        );
        bench.tick();
        assert_eq!(bench.device.condition().commanded, 0);
    }
    assert_eq!(bench.jog(HINGES, None, None), Err(Denial::Range));
    assert_eq!(bench.jog(HINGES - 1, Some(0.0), Some(0.1)), Ok(()));
    // A slower hinge moves at its own speed.
    assert_eq!(bench.jog(10, Some(0.0), Some(1.0)), Ok(()));
    bench.run(1000);
    assert!(
        (bench.angle(10).unwrap() - 0.02).abs() < 1e-5,
        "{:?}",
        bench.angle(10)
    );
    assert!(bench.step <= 2.01e-5);
}

/// Whatever ends the motion, it ends in the tick in which it comes, and does not go on by itself.
#[test]
fn a_motion_ends_where_it_is() {
    let moving = || {
        let mut bench = Bench::new(BLIND);
        bench.jog(3, Some(0.0), Some(1.0)).unwrap();
        bench.run(500);
        bench
    };
    type Ends = fn(&mut Bench);
    let ends: [(&str, Ends); 8] = [
        ("hold", |bench| bench.command(Command::Hold).unwrap()),
        ("resume", |bench| bench.command(Command::Resume).unwrap()),
        ("denied", |bench| {
            bench.command(Command::Start).unwrap_err();
        }),
        ("denied jog", |bench| {
            bench.jog(4, None, Some(0.0)).unwrap_err();
        }),
        ("watch", |bench| bench.jog(3, None, None).unwrap()),
        ("session", |bench| bench.greet(99)),
        ("stop", |bench| bench.device.stop(true)),
        ("fault", |bench| {
            bench.device.follower_mut().fail(Fault::Stalled(7))
        }),
    ];
    for (what, end) in ends {
        let mut bench = moving();
        let before = bench.angle(3).unwrap();
        assert!((before - 0.05).abs() < 1e-4);
        end(&mut bench);
        bench.run(100);
        assert_eq!(bench.commands, [(3, Some((before, 0.0)))], "{what}");
        bench.device.stop(false);
        bench.run(100);
        assert_eq!(bench.angle(3), Some(before), "{what}");
        if what == "stop" {
            assert_eq!(bench.jog(3, None, Some(0.0)), Err(Denial::Held));
            assert_eq!(bench.jog(3, None, None), Err(Denial::Held));
            // The denial has told the host of the stop line.
            assert_eq!(bench.command(Command::Resume), Ok(()));
            bench.run(10);
            assert_eq!(bench.angle(3), Some(before));
        }
        if what == "fault" {
            assert_eq!(bench.jog(3, None, Some(0.0)), Err(Denial::State));
            assert_eq!(bench.command(Command::Clear), Ok(()));
            bench.run(10);
            assert_eq!(bench.angle(3), Some(before));
        }
        assert_eq!(bench.jog(3, None, Some(0.0)), Ok(()), "{what}");
        bench.tick();
        assert!(bench.angle(3).unwrap() < before);
    }
    // Silence: nothing moves later than 500 ms after the last frame.
    let mut bench = moving();
    bench.say(&ToDevice::Alive);
    (0..500).for_each(|_| bench.tick());
    let before = bench.angle(3).unwrap();
    assert!((before - 0.1).abs() < 1e-3, "{before}");
    (0..500).for_each(|_| bench.tick());
    assert!((bench.angle(3).unwrap() - before).abs() < 2e-4);
    let before = bench.angle(3);
    bench.run(100);
    assert_eq!(bench.angle(3), before);
}

/// A hinge that is blocked, or whose sensor turns the wrong way or fails, is not pushed on; but it can be moved back.
#[test]
fn a_hinge_that_does_not_follow_is_not_pushed_on() {
    let sensors: [(Sensor, f32); 3] = [
        (
            |_, command| Some(command.unwrap_or(0.0).min(0.1).into()),
            0.25,
        ),
        (|_, command| Some((-command.unwrap_or(0.0)).into()), 0.075),
        (
            |_, command| {
                let angle = command.unwrap_or(0.0);
                Some(if angle > 0.2 { f32::NAN } else { angle }.into())
            },
            0.2,
        ),
    ];
    for (sensor, expected) in sensors {
        let mut bench = Bench::new(sensor);
        bench.jog(3, None, None).unwrap();
        bench.run(10);
        bench.jog(3, None, Some(1.0)).unwrap();
        bench.run(4000);
        let angle = bench.angle(3).unwrap();
        assert!((angle - expected).abs() < 5e-4, "{angle} {expected}");
        if expected > 0.2 {
            bench.jog(3, None, Some(0.0)).unwrap();
            bench.run(3000);
            assert_eq!(bench.angle(3), Some(0.0));
        }
    }
}

/// On a sheet: `State` while there is a path or it is known where the sheet stands. Once a hinge was moved, nothing is
/// known, after a reset as well; another sheet takes the hinge over.
#[test]
fn a_jog_and_a_sheet_keep_apart() {
    let path = Path::miura();
    let mut bench = Bench::new(BLIND);
    bench.load(&path);
    assert_eq!(bench.jog(3, Some(0.0), Some(0.1)), Err(Denial::State));
    assert_eq!(bench.jog(3, None, None), Err(Denial::State));
    bench.command(Command::Stand).unwrap();
    bench.command(Command::Start).unwrap();
    assert_eq!(bench.jog(3, Some(0.0), Some(0.1)), Err(Denial::State));
    bench.run(200);
    bench.command(Command::Hold).unwrap();
    bench.run(300);
    bench.command(Command::Unload).unwrap();
    bench.tick();
    // The hinges are held: one alone does not move, but may be watched.
    let held = bench.commands.clone();
    assert!(held.len() == 50 && held.iter().all(|(_, to)| to.is_some()));
    assert_eq!(bench.jog(3, Some(0.0), Some(0.1)), Err(Denial::State));
    assert_eq!(bench.jog(3, None, None), Ok(()));
    bench.tick();
    assert_eq!(bench.commands, held);
    assert_ne!(bench.report.unwrap().path, 0);
    bench.command(Command::Forget).unwrap();
    assert_eq!(bench.jog(3, Some(0.0), Some(0.1)), Ok(()));
    bench.run(200);
    let report = bench.report.unwrap();
    assert_eq!(
        (report.state, report.known, report.path),
        (State::Idle, false, 0)
    );
    assert_eq!(report.place, FollowerPosition::default());
    // The other hinges of the sheet are called, and not commanded.
    let commanded: Vec<u32> = bench
        .commands
        .iter()
        .filter(|(_, to)| to.is_some())
        .map(|(h, _)| *h)
        .collect();
    assert_eq!((bench.commands.len(), commanded), (50, vec![3]));
    let kept: Record<4> = bench.device.record(1, 1);
    assert_eq!(
        (kept.angles(), kept.path, kept.has(OFF_PATH)),
        (&[][..], 0, false)
    );
    let mut other = Device::protected(settings(2), Unkeyed);
    other.restore(&kept, true);
    assert!(!other.follower().is_known());
    // The next sheet, be it the same, owns its hinges: nothing is commanded before it starts.
    bench.command(Command::Resume).unwrap();
    bench.load(&path);
    bench.tick();
    assert!(bench.commands.iter().all(|(_, to)| to.is_none()));
    assert_eq!(bench.command(Command::Start), Err(Denial::Unknown(0)));
    bench.command(Command::Stand).unwrap();
    bench.command(Command::Start).unwrap();
    bench.run(100);
    assert_eq!(bench.report.unwrap().reason, Reason::None);
    assert_eq!(bench.device.condition().commanded, 50);
}

/// What is known only by its place on a path is forgotten as well.
#[test]
fn a_jog_forgets_the_place_that_a_reset_has_left() {
    let mut bench = Bench::new(BLIND);
    let mut kept = Record::<4>::default();
    (kept.path, kept.sheet, kept.place.knot, kept.flags) = (77, 5, 9, OFF_PATH);
    bench.device.restore(&kept, true);
    bench.jog(3, None, None).unwrap();
    bench.run(1);
    assert_eq!(
        (bench.report.unwrap().path, bench.report.unwrap().place.knot),
        (77, 9)
    );
    bench.jog(3, Some(0.0), Some(0.1)).unwrap();
    bench.run(1);
    assert_eq!(
        (bench.report.unwrap().path, bench.report.unwrap().place.knot),
        (0, 0)
    );
    assert!(!bench.device.record(1, 1).has(OFF_PATH));
}

/// The windows go round the sheet, each of the tick of the telemetry before it. What was not measured is no number.
#[test]
fn telemetry_tells_what_was_measured_in_turn() {
    thread_local!(static TICK: Cell<u32> = const { Cell::new(0) });
    let path = Path::miura();
    let mut bench = Bench::new(BLIND);
    bench.load(&path);
    bench.command(Command::Stand).unwrap();
    bench.command(Command::Start).unwrap();
    bench.run(100);
    assert!(bench.measured.is_empty() && bench.telemetry.len() >= 4);
    // Every hinge but each third tells where it is, with the number of the tick behind it.
    bench.sensor = |hinge, command| {
        let tick = TICK.get();
        #[allow(clippy::cast_precision_loss, reason = "small")]
        let angle = command? + tick as f32 * 1e-5;
        (hinge % 3 != 0).then_some(angle.into())
    };
    bench.telemetry.clear();
    for tick in 0..200 {
        TICK.set(tick);
        if tick % 50 == 0 {
            bench.say(&ToDevice::Alive);
        }
        bench.tick();
        let commands = bench.commands.clone();
        let Some(told) = bench.measured.pop() else {
            continue;
        };
        assert_eq!(bench.telemetry.last(), Some(&told.time));
        assert_eq!((told.time, told.target), (bench.now, None));
        assert!(told.first == 0 || told.first == 48, "{told:?}");
        assert_eq!(told.angles.len(), if told.first == 0 { 48 } else { 2 });
        for (hinge, angle) in (usize::from(told.first)..).zip(&told.angles) {
            let (_, command) = commands[hinge];
            #[allow(clippy::cast_precision_loss, reason = "small")]
            let expected = command.unwrap().0 + tick as f32 * 1e-5;
            assert_eq!(angle.is_nan(), hinge % 3 == 0);
            assert!(angle.is_nan() || angle.to_bits() == expected.to_bits());
        }
    }
    assert_eq!(bench.telemetry.len(), 10);
}
