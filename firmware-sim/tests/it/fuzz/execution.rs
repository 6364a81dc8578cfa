//! One execution of the fuzzer: a controller, and a host that follows the protocol for a while and then sends anything.

use foldpath_core::follower::{FollowerPosition, State};
use foldpath_core::trajectory::TrajectoryView;
use foldpath_core::wire::cobs;
use foldpath_core::wire::frame;
use foldpath_core::wire::message::{
    Command, Item, SCHEMA, SetpointBytes, SheetHead, ToDevice, VERSION,
};
use foldpath_core::wire::path::PathItems;
use foldpath_core::wire::sender::Source;
use foldpath_core::{GroupId, GroupLimits, Interpolation, Membership, StarsView};
use foldpath_test_support::Random;
use rand_core::Rng;

use super::stream::checksum;
use super::subject::Subject;
use crate::path::{CLOSURE, LIMITS, Path, below};

/// Totals over many executions.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Tally {
    pub(crate) frames: u64,
    pub(crate) setpoints: u64,
    pub(crate) passed: u64,
    pub(crate) moved: u64,
    pub(crate) done: u64,
    pub(crate) faulted: u64,
    /// Ticks in which a hinge moved alone.
    pub(crate) jogged: u64,
}

impl Tally {
    pub(crate) fn add(&mut self, other: Self) {
        self.frames += other.frames;
        self.setpoints += other.setpoints;
        self.passed += other.passed;
        self.moved += other.moved;
        self.done += other.done;
        self.faulted += other.faulted;
        self.jogged += other.jogged;
    }
}

/// Numbers that are hard to handle.
const HARD: [f32; 22] = [
    0.0,
    -0.0,
    1.0,
    -1.0,
    f32::NAN,
    f32::INFINITY,
    f32::NEG_INFINITY,
    f32::MAX,
    f32::MIN,
    f32::MIN_POSITIVE,
    1e-45,
    f32::EPSILON,
    1e-20,
    1e20,
    -1e38,
    1e38,
    3e38,
    core::f32::consts::PI,
    -core::f32::consts::PI,
    16_777_216.0,
    1e9,
    0.02,
];

struct Execution<'a> {
    rng: Random,
    subject: Subject<'a>,
    path: &'a Path,
    sequence: u16,
    command: u8,
    /// `true` for the sheet of Miura's fold; any other sheet has no vertices.
    miura: bool,
    kind: Interpolation,
    groups: usize,
    limits: GroupLimits,
    /// Number of the first knot of the path.
    first: u32,
    /// `true` if the duration of the path overflows `f32`.
    endless: bool,
    /// `true` while the host makes no mistake on purpose.
    calm: bool,
    /// `true` if the host moves hinges alone.
    jogs: bool,
    /// The frames that were sent last.
    sent: Vec<Vec<u8>>,
    tally: Tally,
}

/// Runs execution `number` of this seed.
pub(crate) fn run(path: &Path, seed: u64, number: u64) -> Tally {
    let mut rng = Random::stream(number, seed);
    let kinds = [
        Interpolation::Linear,
        Interpolation::Hermite,
        Interpolation::HalfAngle,
        Interpolation::Homogeneous,
    ];
    let miura = below(&mut rng, 2) == 0;
    let kind = kinds[usize::try_from(below(&mut rng, 4)).unwrap()];
    let groups = usize::try_from(1 + below(&mut rng, 4)).unwrap();
    // The executions that have found faults fold by cubics of the angle.
    let fold = if (number / 4).is_multiple_of(4) {
        Interpolation::HalfAngle
    } else {
        Interpolation::Hermite
    };
    let mut execution = Execution {
        rng,
        subject: Subject::new(path),
        path,
        sequence: 0,
        command: 0,
        miura,
        kind: if miura { fold } else { kind },
        groups: if miura { 2 } else { groups },
        limits: LIMITS,
        first: 0,
        endless: false,
        calm: true,
        // The executions that have found faults are as they were before there were jogs.
        jogs: number % 4 < 2,
        sent: Vec::new(),
        tally: Tally::default(),
    };
    execution.run();
    let Execution { subject, tally, .. } = execution;
    let state = subject.device.follower().state();
    Tally {
        passed: subject.passed,
        moved: u64::from(subject.passed > 0),
        done: u64::from(state == State::Done),
        faulted: u64::from(state == State::Faulted),
        jogged: subject.jogged,
        ..tally
    }
}

impl Execution<'_> {
    fn below(&mut self, count: usize) -> usize {
        usize::try_from(below(&mut self.rng, count as u64)).unwrap()
    }

    fn one_in(&mut self, count: usize) -> bool {
        self.below(count) == 0
    }

    /// Returns a random number from 0 to 1.
    fn part(&mut self) -> f32 {
        f32::from(u16::try_from(self.rng.next_u32() >> 16).unwrap()) / 65535.0
    }

    fn number(&mut self) -> f32 {
        match self.below(4) {
            0 => f32::from_bits(self.rng.next_u32()),
            1 => 10.0 * self.part() - 5.0,
            _ => HARD[self.below(HARD.len())],
        }
    }

    fn run(&mut self) {
        // The board knows where the sheet stands, or an operator tells it, or nobody does.
        if self.one_in(2) {
            let (angles, place) = ([0.0; 4], FollowerPosition::default());
            let follower = self.subject.device.follower_mut();
            follower
                .stand(&angles[..self.groups], place, false)
                .unwrap();
        }
        if !self.one_in(16) {
            self.hello(VERSION, SCHEMA);
            self.sheet();
            for _ in 0..self.below(17) {
                self.setpoint(false);
            }
            if !self.one_in(8) {
                if !self.one_in(8) {
                    self.command(5);
                }
                self.command(0);
                self.steady();
            }
        }
        self.calm = false;
        for _ in 0..4 + self.below(32) {
            self.anything();
        }
    }

    /// Watches or moves a hinge, which there is or not.
    fn jog(&mut self) {
        let mut angle = || match self.below(4) {
            0 => None,
            1 => Some(self.number()),
            _ => Some(self.part() - 0.5),
        };
        let (from, to) = (angle(), angle());
        let hinge = u16::try_from(self.below(66)).unwrap();
        self.say(&ToDevice::Command {
            number: self.command.wrapping_add(1),
            command: Command::Jog { hinge, from, to },
        });
    }

    fn anything(&mut self) {
        if self.jogs && self.one_in(6) {
            self.jog();
        }
        match self.below(24) {
            0..6 => self.ticks(),
            6..11 => self.setpoint(false),
            11 => self.setpoint(true),
            12 => self.mutated(),
            13 => self.resealed(),
            14 => self.noise(),
            15 => self.again(),
            16 => {
                let command = [0, 1, 2, 2, 3, 4, 5, 6][self.below(8)];
                self.command(command);
            }
            17 => self.piece(),
            18 if self.one_in(16) => self.stall(),
            18 if self.one_in(4) => self.steady(),
            18 => self.measure(),
            19 => {
                let drawn = self.one_in(2);
                self.subject.stop(drawn);
            }
            20 if self.one_in(8) => self.say(&ToDevice::Pair(&[7; 16])),
            20 => self.say(&ToDevice::Alive),
            21 => self.subject.deaf = self.one_in(2),
            22 if self.one_in(4) => self.hello(VERSION, SCHEMA),
            22 if self.one_in(4) => {
                self.subject.reset();
                self.hello(VERSION, SCHEMA);
                self.sheet();
            }
            22 => {
                let (version, schema) = (VERSION ^ 1, SCHEMA ^ self.rng.next_u32());
                self.hello(version, schema);
            }
            _ => {
                let drawn = false;
                self.subject.stop(drawn);
                self.command(2);
                self.command(5);
                self.command(0);
            }
        }
    }

    /// Sends bytes to the device, without a tick between them.
    fn send(&mut self, bytes: &[u8]) {
        self.subject.now += 1;
        for byte in bytes {
            self.subject.byte(*byte);
        }
        if let Some(report) = self.subject.report
            && self.subject.session != 0
        {
            (self.sequence, self.command) = (report.next, report.command);
        }
    }

    /// Returns the frame of this message in this session, encoded for the line.
    fn sealed(session: u32, message: &ToDevice<'_>) -> Vec<u8> {
        let (mut buffer, mut bytes) = ([0; 512], Vec::new());
        let sealed = frame::seal(session, message, &mut buffer).unwrap();
        cobs::encode(sealed, |byte| bytes.push(byte));
        bytes
    }

    fn say(&mut self, message: &ToDevice<'_>) {
        self.tally.frames += 1;
        let session = self.subject.session;
        let session = if !self.calm && self.one_in(64) {
            session ^ 1
        } else {
            session
        };
        let bytes = Self::sealed(session, message);
        if self.one_in(4) {
            self.sent.push(bytes.clone());
        }
        self.send(&bytes);
    }

    /// Greets the device, and enters the session that the device offers.
    fn hello(&mut self, version: u16, schema: u32) {
        let id = self.rng.next_u32() << 8;
        let hello = ToDevice::Hello {
            version,
            schema,
            id,
        };
        let bytes = Self::sealed(0, &hello);
        self.subject.deaf = false;
        self.send(&bytes);
        if let Some(session) = self.subject.offered.take() {
            self.subject.enter(session);
            (self.sequence, self.command) = (0, 0);
            self.say(&ToDevice::Alive);
        }
    }

    fn item(&mut self, item: Item<'_>) {
        let room = self
            .subject
            .report
            .is_none_or(|report| report.limit != report.next);
        if !room && !self.one_in(8) {
            return self.ticks();
        }
        let sequence = if !self.calm && self.one_in(32) {
            self.sequence
                .wrapping_add(u16::try_from(self.rng.next_u32() >> 16).unwrap())
        } else {
            self.sequence
        };
        self.say(&ToDevice::Item { sequence, item });
    }

    /// Sends all items of a sheet: of Miura's fold, or of groups without vertices and at times with random limits. The
    /// place at which the path begins may be invalid.
    fn sheet(&mut self) {
        if self.miura {
            (self.subject.miura, self.subject.pristine) = (true, true);
            let knot = if self.one_in(2) {
                0
            } else {
                u32::try_from(self.below(101)).unwrap()
            };
            let place = self.place(knot);
            self.first = place.knot;
            let items = self.path.items(place);
            let mut scratch = [0; 256];
            for index in 0..items.head() as u64 {
                let item = match items.item(index, &mut scratch).unwrap() {
                    Item::Sheet(head) => Item::Sheet(SheetHead {
                        interpolation: self.kind,
                        ..head
                    }),
                    item => item,
                };
                self.item(item);
            }
            return;
        }
        self.subject.pristine = false;
        self.first = if self.one_in(8) {
            u32::MAX - 3
        } else {
            u32::from(self.one_in(2))
        };
        let place = self.place(self.first);
        (self.limits, self.endless) = (LIMITS, self.one_in(8));
        if self.one_in(4) {
            self.limits = GroupLimits {
                lower: -self.part() * 3.0,
                upper: self.part() * 3.0,
                speed: if self.one_in(2) {
                    f32::INFINITY
                } else {
                    self.part() * 10.0
                },
                acceleration: if self.one_in(2) {
                    f32::INFINITY
                } else {
                    self.part() * 1e4
                },
            };
        }
        let (groups, limits) = (self.groups, [self.limits; 4]);
        let zeros = [0.0; 4];
        let stars = StarsView::new(&[], &[], groups).unwrap();
        let view = TrajectoryView::new(
            self.kind,
            groups,
            &[0.0],
            &zeros[..groups],
            &zeros[..groups],
            &[[1.0, 0.0]; 4][..groups * (self.kind.width() / 4)],
        );
        let hinges = [0, 0, 0].map(|group| Membership {
            group: GroupId(group),
            negative: false,
        });
        let at = FollowerPosition::default();
        let items = PathItems::new(
            view.unwrap(),
            &limits[..groups],
            &hinges,
            stars,
            CLOSURE,
            at,
        )
        .unwrap();
        let mut scratch = [0; 256];
        for index in 0..items.head() as u64 {
            let item = match items.item(index, &mut scratch).unwrap() {
                Item::Sheet(head) => Item::Sheet(SheetHead { place, ..head }),
                item => item,
            };
            self.item(item);
        }
    }

    /// Returns a place at a knot or behind it: the place where the sheet stands, or any.
    fn place(&mut self, knot: u32) -> FollowerPosition<f32> {
        let stood = self.subject.device.follower().position();
        match self.below(8) {
            0 => FollowerPosition {
                knot,
                into: self.number(),
            },
            1 => FollowerPosition {
                knot,
                into: 0.02 * self.part(),
            },
            2..5 if stood.knot <= 100 => stood,
            _ => FollowerPosition { knot, into: 0.0 },
        }
    }

    /// Sends the next setpoint, which is valid unless `bad`.
    fn setpoint(&mut self, bad: bool) {
        let (mut number, mut span, mut last, mut nodes) = self.proposal();
        if bad {
            self.subject.pristine = false;
            for _ in 0..=self.below(2) {
                let (place, value) = (self.below(nodes.len().max(1)), self.number());
                match self.below(9) {
                    // Changes the setpoint so little that it may pass.
                    6 => span -= 0.02 * self.part(),
                    7 | 8 => {
                        let off = [1e-4, 0.05, 0.5, 3.0][self.below(4)] * (self.part() - 0.5);
                        nodes[place..]
                            .iter_mut()
                            .take(1)
                            .for_each(|node| *node += off);
                    }
                    0 => number ^= 1 << self.below(32),
                    1 => span = value,
                    2 => last = !last,
                    3 if self.one_in(2) => nodes.truncate(place),
                    3 => nodes.extend([value; 2]),
                    4 => nodes[place..]
                        .iter_mut()
                        .take(1)
                        .for_each(|node| *node = value),
                    _ => nodes[place..].iter_mut().take(1).for_each(|node| {
                        *node = f32::from_bits(node.to_bits() ^ 1 << (number % 24))
                    }),
                }
            }
        }
        let bytes: Vec<u8> = nodes.iter().flat_map(|node| node.to_le_bytes()).collect();
        let before = self.subject.taken.len();
        self.item(Item::Setpoint(SetpointBytes {
            number,
            span,
            last,
            nodes: &bytes,
        }));
        self.tally.setpoints += u64::from(self.subject.taken.len() > before);
    }

    /// Returns a good setpoint behind those that were taken: its number, its span, `true` if it is the last, and its
    /// nodes.
    fn proposal(&mut self) -> (u32, f32, bool, Vec<f32>) {
        let before = self.subject.taken.back().cloned();
        let number = before
            .as_ref()
            .map_or(self.first, |sent| sent.number.wrapping_add(1));
        if self.miura {
            let items = self.path.items(FollowerPosition::default());
            let mut scratch = [0; 256];
            let index = items.head() as u64 + u64::from(number.min(100));
            let Some(Item::Setpoint(setpoint)) = items.item(index, &mut scratch) else {
                panic!("no setpoint");
            };
            let (nodes, _) = setpoint.nodes.as_chunks();
            let nodes = nodes.iter().copied().map(f32::from_le_bytes).collect();
            return (number, setpoint.span, setpoint.last, nodes);
        }
        let wild = self.one_in(16);
        let GroupLimits {
            lower,
            upper,
            speed,
            ..
        } = self.limits;
        let span = if self.endless {
            2e38
        } else if wild {
            self.number()
        } else {
            0.005 + 0.1 * self.part()
        };
        let mut nodes = Vec::new();
        for group in 0..self.groups {
            let width = self.kind.width();
            let old = before
                .as_ref()
                .and_then(|sent| sent.nodes.get(group * width));
            let most = speed.min(10.0) * span * 0.6;
            let angle = match old {
                Some(old) => old + (2.0 * self.part() - 1.0) * most,
                None => self.stands(group),
            };
            let (rate, grow) = if wild {
                (self.number(), self.number())
            } else {
                (0.0, 0.0)
            };
            let weight = if wild { self.number() } else { 1.0 };
            let node = [angle.max(lower).min(upper), rate, weight, grow];
            nodes.extend(&node[..width]);
        }
        (number, span, self.one_in(32), nodes)
    }

    fn stands(&self, group: usize) -> f32 {
        let angles = self.subject.device.follower().angles();
        angles.get(group).copied().unwrap_or(0.0)
    }

    fn command(&mut self, command: u8) {
        let commands = [
            Command::Start,
            Command::Hold,
            Command::Resume,
            Command::Unload,
            Command::Clear,
            Command::Stand,
            Command::Forget,
        ];
        let off = if !self.calm && self.one_in(16) {
            self.rng.next_u32()
        } else {
            1
        };
        let [off, ..] = off.to_le_bytes();
        self.say(&ToDevice::Command {
            number: self.command.wrapping_add(off),
            command: commands[usize::from(command)],
        });
    }

    /// Sends a piece of a sheet at random: of no sheet, surplus, cut off or with wild numbers.
    fn piece(&mut self) {
        let length = self.below(130);
        let mut bytes: Vec<u8> = (0..length / 4)
            .flat_map(|_| self.number().to_le_bytes())
            .collect();
        bytes.resize(length, 0);
        let head = SheetHead {
            interpolation: self.kind,
            groups: u16::try_from(self.below(6)).unwrap(),
            hinges: u16::try_from(self.below(70)).unwrap(),
            spokes: u16::try_from(self.below(40)).unwrap(),
            closure: self.number(),
            path: self.rng.next_u32(),
            place: self.place(0),
            most_lag: self.number(),
        };
        let item = match self.below(4) {
            0 => Item::Sheet(head),
            1 => Item::Limits(&bytes),
            2 => Item::Hinges(&bytes),
            _ => Item::Spokes(&bytes),
        };
        (self.subject.miura, self.subject.pristine) = (false, false);
        self.item(item);
    }

    /// Sends an earlier frame with bytes changed, added, lost or cut off.
    fn mutated(&mut self) {
        let mut bytes = self.any_sent();
        for _ in 0..=self.below(3) {
            let (place, byte) = (self.below(bytes.len().max(1)), self.byte());
            match self.below(6) {
                0 => bytes.insert(place.min(bytes.len()), byte),
                1 => drop((place < bytes.len()).then(|| bytes.remove(place))),
                2 => bytes.truncate(place),
                3 => bytes.rotate_left(place),
                4 => bytes[place..]
                    .iter_mut()
                    .take(1)
                    .for_each(|old| *old = byte),
                _ => bytes[place..]
                    .iter_mut()
                    .take(1)
                    .for_each(|old| *old ^= 1 << (byte % 8)),
            }
        }
        self.send(&bytes);
    }

    /// Sends an earlier frame with a changed message and the right checksum.
    fn resealed(&mut self) {
        let stuffed = self.any_sent();
        let mut deframer = cobs::Deframer::<256>::default();
        let frame = stuffed
            .iter()
            .find_map(|byte| deframer.push(*byte).map(<[u8]>::to_vec));
        let Some(mut frame) = frame else { return };
        frame.truncate(frame.len().saturating_sub(4));
        for _ in 0..=self.below(3) {
            let (place, byte) = (self.below(frame.len().max(1)), self.byte());
            match self.below(4) {
                0 => frame.insert(place.min(frame.len()), byte),
                1 => drop((place < frame.len()).then(|| frame.remove(place))),
                _ => frame[place..]
                    .iter_mut()
                    .take(1)
                    .for_each(|old| *old = byte),
            }
        }
        frame.extend(checksum(&frame).to_le_bytes());
        let mut bytes = Vec::new();
        cobs::encode(&frame, |byte| bytes.push(byte));
        (self.subject.miura, self.subject.pristine) = (false, false);
        self.send(&bytes);
    }

    fn noise(&mut self) {
        let zeros = self.one_in(2);
        let length = self.below(300);
        let byte = |this: &mut Self| {
            if zeros && this.one_in(8) {
                0
            } else {
                this.byte()
            }
        };
        let bytes: Vec<u8> = (0..length).map(|_| byte(self)).collect();
        self.send(&bytes);
    }

    /// Repeats an earlier frame.
    fn again(&mut self) {
        let bytes = self.any_sent();
        self.send(&bytes);
    }

    fn any_sent(&mut self) -> Vec<u8> {
        let count = self.sent.len();
        let chosen = self.below(count.max(1));
        self.sent.get(chosen).cloned().unwrap_or_default()
    }

    fn byte(&mut self) -> u8 {
        let [byte, ..] = self.rng.next_u32().to_le_bytes();
        byte
    }

    fn measure(&mut self) {
        let off = match self.below(4) {
            0 => self.number(),
            1 => 0.0,
            _ => 0.3 * self.part(),
        };
        let hinge = u32::try_from(self.below(3)).unwrap();
        self.subject.measure(hinge, off);
    }

    /// Lets a hinge lag for longer than it may, while the host is heard.
    fn stall(&mut self) {
        self.subject.measure(0, 1.0);
        for _ in 0..12 {
            self.say(&ToDevice::Alive);
            for _ in 0..12 {
                self.subject.tick(self.subject.now + 10_000);
            }
        }
    }

    /// Lets the host be heard and send setpoints as far as there is room.
    fn steady(&mut self) {
        for _ in 0..self.below(8) {
            self.setpoint(false);
            for _ in 0..16 {
                self.subject.tick(self.subject.now + 2500);
            }
        }
    }

    /// Makes ticks, most of them at a steady pace, and lets the device answer.
    fn ticks(&mut self) {
        let (count, long) = (1 + self.below(40), self.one_in(8));
        for _ in 0..count {
            let now = self.subject.now;
            let later = match self.below(8) {
                0 if long => now + 300_000,
                1 if long => now + u64::from(self.rng.next_u32()),
                2 if long => now.saturating_sub(5000),
                3 if long => now,
                _ => now + 1000 + self.rng.next_u64() % 4000,
            };
            self.subject.tick(later);
        }
        self.subject.listen();
    }
}
