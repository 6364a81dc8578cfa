//! A board in virtual time, with hinges, sensors, memory that a reset leaves as it is, and a supply that can be cut.

use core::cell::RefCell;
use core::convert::Infallible;
use core::num::NonZero;
use std::collections::VecDeque;
use std::rc::Rc;

use embedded_io::{ErrorType, Read, ReadReady, Write, WriteReady};
use foldpath_controller::retained::Records;
use foldpath_controller::{Application, Board, Condition, Settings};
use foldpath_controller::{retained, stored};
use foldpath_core::follower::{FollowerPosition, Measurement, Target};
use foldpath_core::trajectory::TrajectoryView;
use foldpath_core::wire::cobs;
use foldpath_core::wire::driver::{Driver, Persistence};
use foldpath_core::wire::key::{Key, StoredKey};
use foldpath_core::wire::message::Report;
use foldpath_core::wire::path::PathItems;
use foldpath_core::wire::protection::{Protection, Unkeyed};
use foldpath_core::wire::sender::Options;
use foldpath_core::{GroupId, GroupLimits, Interpolation, Membership, StarsView};
use foldpath_test_support::{Random, spans};
use rand_core::Rng;

use crate::path::{BOARD, settings};

/// Microseconds of a round of the main loop.
pub(crate) const ROUND: u64 = 250;

pub(crate) const LIMITS: GroupLimits = GroupLimits {
    lower: -3.2,
    upper: 3.2,
    speed: 2.5,
    acceleration: 1e9,
};

/// A path from 0 to 2 rad in two seconds, on which all groups turn alike. It has three hinges for each group.
pub(crate) struct Path {
    pub(crate) groups: usize,
    pub(crate) spans: Vec<f32>,
    pub(crate) angles: Vec<f32>,
    pub(crate) rates: Vec<f32>,
    pub(crate) hinges: Vec<Membership>,
    pub(crate) limits: Vec<GroupLimits>,
}

impl Path {
    pub(crate) fn new(groups: usize) -> Self {
        Self::from(groups, 0.0, 1.0)
    }

    /// The path begins at an angle and has this speed, radians and radians per second.
    pub(crate) fn from(groups: usize, begin: f32, speed: f32) -> Self {
        let times = (0..21_u8).map(|knot| f32::from(knot) * 0.1);
        let angles = times.flat_map(|time| vec![begin + speed * time; groups]);
        let hinge = |hinge: usize| Membership {
            group: GroupId(u32::try_from(hinge % groups).unwrap()),
            negative: hinge.is_multiple_of(3),
        };
        Self {
            groups,
            angles: angles.collect(),
            rates: vec![speed; groups * 21],
            spans: spans(21, 0.1),
            hinges: (0..3 * groups).map(hinge).collect(),
            limits: vec![LIMITS; groups],
        }
    }

    pub(crate) fn items(&self) -> PathItems<'_> {
        let (kind, groups) = (Interpolation::Hermite, self.groups);
        let view = TrajectoryView::new(kind, groups, &self.spans, &self.angles, &self.rates, &[]);
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

    pub(crate) fn driver(&self, persistence: Persistence, id: u32) -> Driver<'_> {
        Driver::new(self.items(), persistence, id, Options::default())
    }
}

/// Way of a drive in a tick back to its command, radians: 6 rad/s.
const DRIVE_STEP_RAD: f32 = 6e-3;

/// The hardware round the controller, which a reset leaves as it is.
#[derive(Default)]
pub(crate) struct Bench {
    pub(crate) now: u64,
    pub(crate) stop: bool,
    pub(crate) received: VecDeque<u8>,
    pub(crate) sent: Vec<u8>,
    /// Angle that each hinge was last commanded in the last tick; `None` if it had no command.
    pub(crate) commands: Vec<Option<f32>>,
    pub(crate) conditions: Vec<Condition>,
    pub(crate) ticks: usize,
    pub(crate) records: Records<{ retained::size(94) }>,
    /// Angle at which each hinge stands. A hinge follows its command, and stays where it is without one.
    pub(crate) stands: Vec<f32>,
    /// `true` if the drives let go of the hinges in a reset.
    pub(crate) limp: bool,
    /// Returns the measured angle of a hinge from its number, its command, and the angle at which it stands.
    pub(crate) sensor: Option<Sensor>,
    /// Hinges that are not measured.
    pub(crate) deaf: Vec<u32>,
    /// `true` if the drives follow their commands.
    pub(crate) follows: bool,
    /// `true` if something has moved hinges, and the drives have not yet led all of them back to their commands.
    pub(crate) moved: bool,
    /// Flash for the key, which is 0 when it is erased. Neither a reset nor a loss of power changes it.
    pub(crate) flash: [u32; stored::WORDS],
    /// Number of words that can still be written before the flash fails, if it fails.
    pub(crate) writes: Option<usize>,
}

impl Bench {
    /// Returns the key that is stored.
    pub(crate) fn key(&self) -> StoredKey {
        stored::open(&self.flash, 0)
    }
}

pub(crate) type Sensor = fn(u32, Option<f32>, f32) -> f32;

/// A sensor that tells where the hinge stands.
pub(crate) const EXACT: Sensor = |_, _, stands| stands;

#[derive(Clone, Default)]
pub(crate) struct Shared(Rc<RefCell<Bench>>);

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

    fn drive(
        &mut self,
        hinge: u32,
        _: Membership,
        target: Option<Target<f32>>,
    ) -> Option<Measurement<f32>> {
        let angle = target.map(|target| target.angle);
        let mut bench = self.0.borrow_mut();
        assert_eq!(bench.commands.len(), hinge as usize);
        bench.commands.push(angle);
        let hinges = bench.stands.len().max(hinge as usize + 1);
        bench.stands.resize(hinges, 0.0);
        let stands = bench.stands[hinge as usize];
        let sensor = bench.sensor.filter(|_| !bench.deaf.contains(&hinge));
        let measured = sensor.map(|sensor| sensor(hinge, angle, stands));
        measured.map(Into::into)
    }

    fn held(&mut self) -> bool {
        !self.0.borrow().limp
    }

    fn keep(&mut self, record: usize, at: usize, bytes: &[u8]) {
        self.0.borrow().records.keep(record, at, bytes);
    }

    fn kept(&mut self, record: usize, at: usize, bytes: &mut [u8]) {
        self.0.borrow().records.kept(record, at, bytes);
    }

    fn key(&mut self) -> StoredKey {
        stored::open(&self.0.borrow().flash, 0)
    }

    fn store_key(&mut self, key: &Key) -> bool {
        {
            let mut bench = self.0.borrow_mut();
            let Bench {
                flash,
                writes,
                sent,
                ..
            } = &mut *bench;
            assert_eq!(flash[stored::WORDS - 1], 0);
            // No answer that tells of the key has left before.
            assert!(sent.is_empty());
            let left = writes.unwrap_or(stored::WORDS);
            for (place, word) in flash.iter_mut().zip(stored::words(key)).take(left) {
                *place = word;
            }
        }
        self.key() == StoredKey::Key(*key)
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
pub(crate) struct Machine<const G: usize, P: Protection = Unkeyed> {
    pub(crate) bench: Shared,
    pub(crate) controller: Box<Application<Shared, Shared, G, 282, 16, 16, P>>,
    /// Bytes that hosts have sent.
    pub(crate) recorded: Vec<(u64, Vec<u8>)>,
    pub(crate) nonce: u64,
    /// `true` if the line may set a key.
    pub(crate) pairs: bool,
    /// Number of the image from the next reset on.
    pub(crate) image: u32,
}

impl<const G: usize> Machine<G> {
    /// Switches a board on whose memory holds nothing.
    pub(crate) fn new(nonce: u64) -> Self {
        Self::with_line(nonce, false)
    }
}

impl<const G: usize, P: Protection> Machine<G, P> {
    /// Switches a board on whose memory holds nothing, and whose line may set a key or not.
    pub(crate) fn with_line(nonce: u64, pairs: bool) -> Self {
        Self::with_settings(Settings {
            pairs,
            ..settings(nonce)
        })
    }

    /// Switches a board on whose memory holds nothing, with these settings until its first reset.
    pub(crate) fn with_settings(settings: Settings) -> Self {
        let bench = Shared::default();
        {
            let mut bench = bench.0.borrow_mut();
            (bench.now, bench.follows) = (1_000_000, true);
        }
        let (nonce, pairs) = (settings.nonce.map_or(0, NonZero::get), settings.pairs);
        let controller = Application::new(bench.clone(), bench.clone(), settings);
        Self {
            controller: Box::new(controller),
            bench,
            recorded: Vec::new(),
            nonce,
            pairs,
            image: 0,
        }
    }

    /// Cuts the power and switches it on again: the memory holds whatever it holds, and the hinges stay.
    pub(crate) fn cut_power(&mut self, nonce: u64) {
        let mut rng = Random::new(nonce);
        self.bench(|bench| {
            let mut bytes = [0; retained::size(94)];
            for record in 0..2 {
                rng.fill_bytes(&mut bytes);
                bench.records.keep(record, 0, &bytes);
            }
        });
        self.nonce = nonce;
        self.reset();
    }

    /// Resets the controller; its records stay.
    pub(crate) fn reset(&mut self) {
        let (bench, nonce) = (&self.bench, self.nonce);
        {
            let mut bench = bench.0.borrow_mut();
            (bench.received, bench.sent) = (VecDeque::new(), Vec::new());
            bench.commands.clear();
        }
        let settings = Settings {
            pairs: self.pairs,
            image: self.image,
            ..settings(nonce)
        };
        *self.controller = Application::new(bench.clone(), bench.clone(), settings);
    }

    pub(crate) fn bench<R>(&self, with: impl FnOnce(&mut Bench) -> R) -> R {
        with(&mut self.bench.0.borrow_mut())
    }

    /// Runs for some milliseconds, with a host if there is one.
    pub(crate) fn run(&mut self, mut host: Option<&mut Driver<'_>>, millis: u64) {
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

    /// Checks a tick, and lets the hinges follow their commands. Unless something has moved hinges, no hinge is commanded farther from where it stands than it
    /// may move, and none moves while a stop or a fault is latched. A hinge that had no command may be off by as much as
    /// an approach bridges.
    pub(crate) fn judge(&self, before: &[Option<f32>]) {
        self.bench(|bench| {
            let condition = *bench.conditions.last().unwrap();
            assert_eq!(bench.conditions.len(), bench.ticks);
            let follows = bench.follows;
            let latched = condition.stopped || condition.fault.is_some();
            let commanded = bench.commands.iter().flatten().count();
            let mut away = !follows || commanded < bench.stands.len();
            for (hinge, command) in bench.commands.iter().enumerate() {
                let Some(command) = *command else { continue };
                if !follows {
                    continue;
                }
                let stands = &mut bench.stands[hinge];
                let most = match before.get(hinge) {
                    _ if latched => 0.0,
                    Some(Some(_)) => BOARD.speed * 1e-3,
                    _ => 0.1,
                };
                let off = command - *stands;
                assert!(
                    bench.moved || off.abs() <= most,
                    "{hinge}: {command} from {stands}, {condition:?}"
                );
                *stands = if off.abs() > most {
                    away = true;
                    *stands + DRIVE_STEP_RAD.copysign(off)
                } else {
                    command
                };
            }
            bench.moved &= away;
            assert_eq!(commanded, condition.commanded);
        });
    }

    /// Returns the angle that the first hinge is commanded, with the sign of its group.
    pub(crate) fn command(&self) -> Option<f32> {
        self.bench(|bench| {
            bench
                .commands
                .first()
                .copied()
                .flatten()
                .map(|angle| -angle)
        })
    }

    pub(crate) fn condition(&self) -> Condition {
        self.bench(|bench| *bench.conditions.last().unwrap())
    }
}

pub(crate) fn told(host: &Driver<'_>) -> Report {
    *host.sender().report().unwrap()
}
