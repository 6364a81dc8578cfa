//! Does the controller refuse wrong content behind good checksums, with the right reason? Whatever is sent, it commands
//! no angle beyond the limits and no configuration that tears the sheet.

use foldpath_core::acceptance::{Refusal, most_commanded};
use foldpath_core::follower::{Denial, FollowerPosition, Reason, State};
use foldpath_core::wire::cobs::{self, Deframer};
use foldpath_core::wire::frame;
use foldpath_core::wire::message::{
    Command, Item, ItemRefusal, Report, SCHEMA, SetpointBytes, SheetHead, ToDevice, ToHost, VERSION,
};
use foldpath_core::wire::protection::Unkeyed;
use foldpath_core::wire::sender::Source;
use foldpath_test_support::Random;
use rand_core::Rng;

use crate::path::{CLOSURE, Device, LIMITS, Path, below, flat, settings};
use crate::world::rng;

/// A host that breaks the rules, on a line without faults.
pub(crate) struct Talk {
    pub(crate) device: Device,
    deframer: Deframer<512>,
    now: u64,
    session: u32,
    sequence: u16,
    command: u8,
    pub(crate) report: Option<Report>,
}

impl Talk {
    pub(crate) fn new() -> Self {
        let mut talk = Self {
            device: flat(Device::protected(settings(1), Unkeyed)),
            deframer: Deframer::default(),
            now: 1000,
            session: 0,
            sequence: 0,
            command: 0,
            report: None,
        };
        talk.greet(44);
        talk
    }

    /// Opens a session as another host.
    pub(crate) fn greet(&mut self, id: u32) {
        let (version, schema) = (VERSION, SCHEMA);
        (self.session, self.sequence, self.command) = (0, 0, 0);
        self.say(&ToDevice::Hello {
            version,
            schema,
            id,
        });
    }

    fn say(&mut self, message: &ToDevice<'_>) {
        let mut buffer = [0; 512];
        let frame = frame::seal(self.session, message, &mut buffer).unwrap();
        cobs::encode(frame, |byte| self.device.byte(byte, self.now));
        self.listen();
    }

    pub(crate) fn listen(&mut self) {
        self.device.poll(self.now);
        while let Some(byte) = self.device.take() {
            let Some(frame) = self.deframer.push(byte) else {
                continue;
            };
            match frame::open(frame) {
                Some((_, ToHost::Welcome { session, .. })) => self.session = session,
                Some((_, ToHost::Report(report))) => self.report = Some(report),
                _ => {}
            }
        }
    }

    /// Sends an item under the expected number and returns the reason if the item is refused.
    pub(crate) fn item(&mut self, item: Item<'_>) -> Option<ItemRefusal> {
        let sequence = self.sequence;
        self.say(&ToDevice::Item { sequence, item });
        let report = self.report.unwrap();
        self.sequence = report.next;
        report.refused
    }

    pub(crate) fn command(&mut self, command: Command) -> Option<Denial> {
        self.command = self.command.wrapping_add(1);
        let number = self.command;
        self.say(&ToDevice::Command { number, command });
        let report = self.report.unwrap();
        assert_eq!(report.command, number);
        report.denied
    }

    pub(crate) fn tick(&mut self) {
        self.now += 1000;
        self.device.tick(self.now);
    }

    /// Sends the sheet of a path.
    pub(crate) fn sheet(&mut self, path: &Path) {
        let items = path.items(FollowerPosition::default());
        let mut scratch = [0; 256];
        for index in 0..4 {
            let item = items.item(index, &mut scratch).unwrap();
            assert_eq!(self.item(item), None);
        }
    }

    /// Sends a knot of a path, changed by `change`.
    pub(crate) fn knot(
        &mut self,
        path: &Path,
        knot: u64,
        change: impl Fn(&mut SetpointBytes<'_>, &mut Vec<u8>),
    ) -> Option<ItemRefusal> {
        let mut scratch = [0; 256];
        let items = path.items(FollowerPosition::default());
        let Some(Item::Setpoint(setpoint)) = items.item(4 + knot, &mut scratch) else {
            panic!("no knot {knot}");
        };
        let (mut head, mut nodes) = (setpoint, setpoint.nodes.to_vec());
        change(&mut head, &mut nodes);
        let setpoint = SetpointBytes {
            number: head.number,
            span: head.span,
            last: head.last,
            nodes: &nodes,
        };
        let refused = self.item(Item::Setpoint(setpoint));
        if !self.device.is_busy() {
            return refused;
        }
        // It takes several rounds to be checked.
        while self.device.is_busy() {
            self.listen();
        }
        self.listen();
        let report = self.report.unwrap();
        self.sequence = report.next;
        report.refused
    }
}

fn set(nodes: &mut [u8], place: usize, value: f32) {
    nodes[4 * place..4 * place + 4].copy_from_slice(&value.to_le_bytes());
}

fn scale(nodes: &mut [u8], place: usize, factor: f32) {
    let number = nodes[4 * place..].first_chunk().unwrap();
    set(nodes, place, f32::from_le_bytes(*number) * factor);
}

#[test]
fn pieces_of_a_sheet_are_refused_with_their_reasons() {
    use ItemRefusal::{Closure, Hinge, Incomplete, Limits, Path as OfPath, Pieces, Room, Stars};
    let path = Path::miura();
    let items = path.items(FollowerPosition::default());
    let mut scratch = [0; 256];
    let Some(Item::Sheet(head)) = items.item(0, &mut scratch) else {
        panic!("no sheet");
    };
    let mut talk = Talk::new();
    assert_eq!(talk.item(Item::Limits(&[0; 16])), Some(Incomplete));
    assert_eq!(talk.knot(&path, 0, |_, _| {}), Some(Incomplete));
    for (head, refusal) in [
        (SheetHead { groups: 5, ..head }, Room),
        (SheetHead { hinges: 65, ..head }, Room),
        (SheetHead { spokes: 33, ..head }, Room),
        (
            SheetHead {
                closure: f32::NAN,
                ..head
            },
            Closure,
        ),
        (
            SheetHead {
                closure: 0.01,
                ..head
            },
            Closure,
        ),
    ] {
        assert_eq!(talk.item(Item::Sheet(head)), Some(refusal));
    }
    assert_eq!(talk.item(Item::Sheet(head)), None);
    assert_eq!(talk.knot(&path, 0, |_, _| {}), Some(Incomplete));
    let limits: Vec<u8> = [0.0, 1.0, 1.0, 1.0_f32]
        .iter()
        .flat_map(|x| x.to_le_bytes())
        .collect();
    assert_eq!(talk.item(Item::Limits(&limits[..15])), Some(Pieces));
    assert_eq!(talk.item(Item::Limits(&[0; 16])), Some(Limits(0)));
    assert_eq!(talk.item(Item::Limits(&limits)), None);
    // A refused item leaves nothing behind.
    let unsound = [limits.clone(), vec![0; 16]].concat();
    assert_eq!(talk.item(Item::Limits(&unsound)), Some(Pieces));
    assert_eq!(talk.item(Item::Limits(&limits)), None);
    assert_eq!(talk.item(Item::Limits(&limits)), Some(Pieces));
    // 50 hinges of 2 bits each take 13 bytes.
    assert_eq!(talk.item(Item::Hinges(&[0; 14])), Some(Pieces));
    assert_eq!(talk.item(Item::Hinges(&[0; 4])), None);
    assert_eq!(talk.item(Item::Hinges(&[0; 10])), Some(Pieces));
    assert_eq!(talk.item(Item::Hinges(&[0; 9])), None);
    assert_eq!(talk.item(Item::Hinges(&[0])), Some(Pieces));
    let three = SheetHead { groups: 3, ..head };
    assert_eq!(talk.item(Item::Sheet(three)), None);
    // 8 hinges of 3 bits each take 3 bytes; an item of 2 bytes would cut a hinge.
    assert_eq!(talk.item(Item::Hinges(&[0, 0])), Some(Pieces));
    assert_eq!(talk.item(Item::Hinges(&[6 << 3, 0, 0])), Some(Hinge(1)));
    assert_eq!(talk.item(Item::Hinges(&[5 << 3, 0, 0])), None);
    let spoke = |group: u8, last: u8, x: f32| {
        let code = [4 * group + 2 * last, 0];
        [&code[..], &x.to_le_bytes(), &0_f32.to_le_bytes()].concat()
    };
    for bad in [spoke(0, 0, 1.0), spoke(0, 1, 1.1), spoke(2, 1, 1.0)] {
        assert_eq!(
            talk.item(Item::Sheet(SheetHead { spokes: 1, ..head })),
            None
        );
        assert_eq!(talk.item(Item::Spokes(&bad)), Some(Stars));
    }
    // No other sheet is taken while a path moves.
    talk.sheet(&path);
    assert_eq!(talk.knot(&path, 0, |_, _| {}), None);
    assert_eq!(talk.knot(&path, 1, |_, _| {}), None);
    assert_eq!(talk.command(Command::Start), None);
    talk.tick();
    talk.tick();
    assert_eq!(talk.item(Item::Sheet(head)), Some(OfPath(Denial::Moving)));
}

#[test]
fn commands_are_denied_with_their_reasons() {
    let path = Path::miura();
    let mut talk = Talk::new();
    assert_eq!(talk.command(Command::Start), Some(Denial::State));
    assert_eq!(talk.command(Command::Clear), Some(Denial::State));
    assert_eq!(talk.command(Command::Unload), None);
    talk.sheet(&path);
    assert_eq!(talk.command(Command::Start), Some(Denial::State));
    assert_eq!(talk.knot(&path, 0, |_, _| {}), None);
    talk.device.stop(true);
    assert_eq!(talk.command(Command::Resume), Some(Denial::Held));
    talk.device.stop(false);
    assert_eq!(talk.command(Command::Start), Some(Denial::Held));
    assert_eq!(talk.command(Command::Resume), None);
    assert_eq!(talk.command(Command::Start), None);
    (1..10).for_each(|knot| assert_eq!(talk.knot(&path, knot, |_, _| {}), None));
    talk.tick();
    assert_eq!(talk.command(Command::Unload), Some(Denial::Moving));
    assert_eq!(talk.command(Command::Hold), None);
    assert_eq!(talk.report.unwrap().reason, Reason::HoldCommand);
}

/// Remains of a session do not become the path of the next session: not by an empty piece, not by a setpoint that would
/// fit behind the last one, not by a command.
#[test]
fn a_new_session_builds_on_nothing_of_the_one_before() {
    use ItemRefusal::Incomplete;
    let path = Path::miura();
    for started in [false, true] {
        let mut talk = Talk::new();
        talk.sheet(&path);
        (0..4).for_each(|knot| assert_eq!(talk.knot(&path, knot, |_, _| {}), None));
        if started {
            assert_eq!(talk.command(Command::Start), None);
            (0..20).for_each(|_| talk.tick());
        }
        talk.greet(55);
        let room = talk.device.follower().room();
        talk.say(&ToDevice::Alive);
        (0..500).for_each(|_| talk.tick());
        talk.say(&ToDevice::Alive);
        assert_eq!(talk.item(Item::Limits(&[])), Some(Incomplete));
        assert_eq!(talk.item(Item::Hinges(&[])), Some(Incomplete));
        assert_eq!(talk.knot(&path, 4, |_, _| {}), Some(Incomplete));
        assert_eq!(talk.command(Command::Start), Some(Denial::State));
        if started {
            assert_eq!(talk.command(Command::Resume), Some(Denial::State));
            assert_eq!(talk.report.unwrap().reason, Reason::Session);
        }
        assert!(talk.device.follower().room() >= room);
        let angles = talk.device.follower().angles().to_vec();
        (0..100).for_each(|_| talk.tick());
        assert_eq!(talk.device.follower().angles(), angles);
        talk.sheet(&path);
        assert_eq!(talk.device.follower().state(), State::Idle);
    }
}

/// A resume that the host sent after a hold may arrive after the stop line was drawn.
#[test]
fn a_resume_that_was_sent_before_the_stop_line_does_not_undo_it() {
    let path = Path::miura();
    let mut talk = Talk::new();
    talk.sheet(&path);
    (0..10).for_each(|knot| assert_eq!(talk.knot(&path, knot, |_, _| {}), None));
    assert_eq!(talk.command(Command::Start), None);
    talk.tick();
    assert_eq!(talk.command(Command::Hold), None);
    talk.device.stop(true);
    talk.device.stop(false);
    assert_eq!(talk.command(Command::Resume), Some(Denial::Held));
    assert_eq!(talk.device.follower().state(), State::Holding);
    assert_eq!(talk.report.unwrap().reason, Reason::StopLine);
    assert_eq!(talk.command(Command::Resume), None);
    assert_eq!(talk.device.follower().state(), State::Running);
}

/// If nobody reads, telemetry stops before it takes the room of an answer.
#[test]
fn telemetry_leaves_room_for_answers() {
    let path = Path::miura();
    let mut talk = Talk::new();
    talk.sheet(&path);
    for _ in 0..2000 {
        talk.tick();
        talk.device.poll(talk.now);
    }
    for number in 1..=4 {
        let mut buffer = [0; 64];
        let command = Command::Hold;
        let message = ToDevice::Command { number, command };
        let frame = frame::seal(talk.session, &message, &mut buffer).unwrap();
        cobs::encode(frame, |byte| talk.device.byte(byte, talk.now));
        talk.device.poll(talk.now);
    }
    talk.listen();
    assert_eq!(talk.report.unwrap().command, 4);
}

/// A function that spoils a setpoint, and the refusal that it must cause.
type Bad = (fn(&mut SetpointBytes<'_>, &mut Vec<u8>), Refusal);

#[test]
fn a_bad_setpoint_is_refused_holds_the_motion_and_may_be_amended() {
    let cases: [Bad; 9] = [
        (|head, _| head.number = 9, Refusal::Sequence(8)),
        (|_, nodes| nodes.truncate(15), Refusal::Groups),
        (|_, nodes| nodes.extend([0; 48]), Refusal::Groups),
        (|_, nodes| set(nodes, 1, f32::NAN), Refusal::NotFinite(0)),
        (|head, _| head.span = 0.0, Refusal::Order),
        (|_, nodes| set(nodes, 2, 2.8), Refusal::Range(1)),
        (|_, nodes| set(nodes, 2, 0.001), Refusal::Open(0)),
        (|_, nodes| scale(nodes, 3, 1.01), Refusal::OpenBetween(0)),
        (|head, _| head.span = 0.01, Refusal::Acceleration(0)),
    ];
    let path = Path::miura();
    for (change, refusal) in cases {
        let mut talk = Talk::new();
        talk.sheet(&path);
        (0..8).for_each(|knot| assert_eq!(talk.knot(&path, knot, |_, _| {}), None));
        assert_eq!(talk.command(Command::Start), None);
        (0..100).for_each(|_| talk.tick());
        let sequence = talk.sequence;
        assert_eq!(
            talk.knot(&path, 8, change),
            Some(ItemRefusal::Setpoint(refusal))
        );
        let report = talk.report.unwrap();
        assert_eq!(
            (report.state, report.reason),
            (State::Holding, Reason::Refused(refusal))
        );
        assert_eq!(report.next, sequence);
        assert_eq!(talk.knot(&path, 8, |_, _| {}), None);
        (0..500).for_each(|_| talk.tick());
        assert_eq!(talk.device.follower().rate().to_bits(), 0);
        assert_eq!(talk.command(Command::Resume), None);
        talk.tick();
        assert!(talk.device.follower().rate() > 0.0);
    }
}

/// Does anything that a host can do in an open session, and moves the stop line.
fn anything(rng: &mut Random, talk: &mut Talk, path: &Path, knot: &mut u64) {
    match below(rng, 40) {
        0 => {
            let commands = [
                Command::Start,
                Command::Hold,
                Command::Resume,
                Command::Unload,
            ];
            let command = commands[usize::try_from(below(rng, 4)).unwrap()];
            talk.command(command);
        }
        1 => {
            let mut bytes = vec![0; usize::try_from(below(rng, 130)).unwrap()];
            rng.fill_bytes(&mut bytes);
            let item = match below(rng, 3) {
                0 => Item::Limits(&bytes),
                1 => Item::Hinges(&bytes),
                _ => Item::Spokes(&bytes),
            };
            talk.item(item);
        }
        2 => talk.device.stop(below(rng, 2) == 0),
        3..8 => {
            // Changes bits of a setpoint. Most results are refused; a change of a last digit may pass.
            let (bit, more) = (below(rng, 128), below(rng, 3));
            let seed = rng.next_u64();
            let refused = talk.knot(path, *knot, |head, nodes| {
                nodes[usize::try_from(bit / 8).unwrap()] ^= 1 << (bit % 8);
                if more == 0 {
                    head.span = f32::from_bits(head.span.to_bits() ^ (1 << (seed % 32)));
                }
            });
            *knot += u64::from(refused.is_none());
        }
        _ => {
            let refused = talk.knot(path, *knot, |_, _| {});
            *knot += u64::from(refused.is_none());
        }
    }
    *knot = (*knot).min(100);
}

#[test]
fn whatever_is_sent_nothing_is_torn_or_beyond_its_limits() {
    let path = Path::miura();
    let mut moved_far = 0;
    for seed in 0..100 {
        let mut rng = rng(800 + seed);
        let mut talk = Talk::new();
        talk.sheet(&path);
        let mut knot = 0;
        let mut before: Option<[f32; 2]> = None;
        for tick in 0..4000 {
            let full = talk.device.follower().room() == 0;
            if !full && below(&mut rng, 4) == 0 {
                anything(&mut rng, &mut talk, &path, &mut knot);
            }
            match talk.device.follower().state() {
                State::Idle => {
                    talk.sheet(&path);
                    knot = 0;
                }
                State::Ready if knot > 1 => {
                    talk.device.stop(false);
                    talk.command(Command::Resume);
                    talk.command(Command::Start);
                }
                State::Holding if tick % 50 == 0 => {
                    talk.device.stop(false);
                    talk.command(Command::Resume);
                }
                _ => {}
            }
            talk.tick();
            let follower = talk.device.follower();
            let &[a, b] = follower.angles() else { continue };
            let residual = path.residual(&[a, b]);
            assert!(
                residual <= most_commanded(CLOSURE, 4).into(),
                "{residual:e} {seed} {tick}"
            );
            let before = before.replace([a, b]).unwrap_or([a, b]);
            for (angle, before) in [a, b].into_iter().zip(before) {
                assert!((LIMITS.lower..=LIMITS.upper).contains(&angle));
                let most = f64::from(LIMITS.speed) * 1e-3 + 1e-5;
                assert!((f64::from(angle) - f64::from(before)).abs() <= most);
            }
            moved_far += u32::from(a > 0.5);
        }
    }
    assert!(moved_far > 1000, "{moved_far}");
}
