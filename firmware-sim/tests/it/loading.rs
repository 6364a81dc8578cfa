//! Are sheets and setpoints taken up whole or not at all: when a motion fails in between, when the sheet resembles the one
//! before, and when a setpoint takes longer to check than a tick?

use foldpath_controller::Controller;
use foldpath_core::acceptance::Refusal;
use foldpath_core::follower::{Denial, Fault, FollowerPosition, Reason, State};
use foldpath_core::trajectory::TrajectoryView;
use foldpath_core::wire::cobs::{self, Deframer};
use foldpath_core::wire::frame;
use foldpath_core::wire::message::{
    Command, Item, ItemRefusal, SCHEMA, SheetHead, ToDevice, ToHost, VERSION,
};
use foldpath_core::wire::path::PathItems;
use foldpath_core::wire::protection::Unkeyed;
use foldpath_core::wire::sender::Source;
use foldpath_core::{Interpolation, StarsView};

use crate::path::{LIMITS, Path, settings, vertex};
use crate::refusals::Talk;

/// Sends the sheet of a path with this number of hinges, of which `bytes` are the codes.
fn sheet_of(talk: &mut Talk, path: &Path, hinges: u16, bytes: Option<&[u8]>) {
    let items = path.items(FollowerPosition::default());
    let mut scratch = [0; 256];
    for index in 0..4 {
        let item = match (items.item(index, &mut scratch).unwrap(), bytes) {
            (Item::Sheet(head), _) => Item::Sheet(SheetHead { hinges, ..head }),
            (Item::Hinges(_), Some(bytes)) => Item::Hinges(bytes),
            (item, _) => item,
        };
        assert_eq!(talk.item(item), None);
    }
}

/// Starts a path, follows it for a while and holds it.
fn folded(path: &Path) -> Talk {
    let mut talk = Talk::new();
    talk.sheet(path);
    (0..16).for_each(|knot| assert_eq!(talk.knot(path, knot, |_, _| {}), None));
    assert_eq!(talk.command(Command::Start), None);
    (0..200).for_each(|_| talk.tick());
    assert_eq!(talk.command(Command::Hold), None);
    (0..300).for_each(|_| talk.tick());
    assert_eq!(talk.device.follower().state(), State::Holding);
    talk
}

/// The motion fails after another sheet has come, and before its first setpoint. The hinges before stay with their angles.
#[test]
fn a_failure_between_a_sheet_and_its_first_setpoint_leaves_the_hinges_before() {
    let path = Path::miura();
    let mut talk = folded(&path);
    let commands = |talk: &mut Talk| {
        let mut commands = Vec::new();
        talk.device.drive(|hinge, member, angle| {
            commands.push((hinge, member, angle));
            None
        });
        commands
    };
    let before = commands(&mut talk);
    assert_eq!(before.len(), 50);
    // Two hinges, of which both follow group 1.
    sheet_of(&mut talk, &path, 2, Some(&[0b1010]));
    talk.device.follower_mut().fail(Fault::Stalled(1));
    let refused = talk.knot(&path, 0, |_, _| {});
    assert_eq!(refused, Some(ItemRefusal::Path(Denial::State)));
    assert_eq!(commands(&mut talk), before);
    // After `Clear` and the sheet again, the two hinges have no command.
    assert_eq!(talk.command(Command::Clear), None);
    sheet_of(&mut talk, &path, 2, Some(&[0b1010]));
    assert_eq!(commands(&mut talk), before);
    assert_eq!(talk.knot(&path, 0, |_, _| {}), None);
    let after = commands(&mut talk);
    assert!(after.len() == 2 && after.iter().all(|(.., angle)| angle.is_none()));
}

/// Two sheets whose pieces have the same bytes, but another number of hinges, are two sheets.
#[test]
fn sheets_are_told_apart_by_their_counts() {
    let path = Path::miura();
    let mut talk = folded(&path);
    assert!(talk.device.follower().is_known());
    // The last byte of 50 codes of 2 bits ends with 4 bits of 0, which are two more hinges of group 0.
    sheet_of(&mut talk, &path, 52, None);
    assert_eq!(talk.knot(&path, 0, |_, _| {}), None);
    assert!(!talk.device.follower().is_known());
    assert_eq!(talk.report.unwrap().path, 0);
    // The sheet of before is recognised.
    let mut talk = folded(&path);
    talk.sheet(&path);
    assert_eq!(talk.knot(&path, 0, |_, _| {}), None);
    assert!(talk.device.follower().is_known());
}

/// A piece of a setpoint that does not fit holds no motion that does not exist.
#[test]
fn a_misfit_without_a_path_holds_nothing() {
    let path = Path::miura();
    let groups = Some(ItemRefusal::Setpoint(Refusal::Groups));
    let mut talk = Talk::new();
    talk.sheet(&path);
    assert_eq!(talk.item(Item::Nodes(&[0; 5])), groups);
    assert_eq!(talk.report.unwrap().reason, Reason::None);
    assert_eq!(talk.knot(&path, 0, |_, _| {}), None);
    assert_eq!(talk.command(Command::Start), None);
    assert_eq!(talk.item(Item::Nodes(&[0; 5])), groups);
    assert_eq!(
        talk.report.unwrap().reason,
        Reason::Refused(Refusal::Groups)
    );
}

/// `Forget` drops a path that has begun, with its sheet, and its number.
#[test]
fn forget_drops_a_path_that_has_begun() {
    let path = Path::miura();
    for done in [false, true] {
        let mut talk = folded(&path);
        if done {
            assert_eq!(talk.command(Command::Resume), None);
            let mut knot = 16;
            while talk.device.follower().state() != State::Done {
                talk.tick();
                if knot < 101 && talk.device.follower().room() > 0 {
                    assert_eq!(talk.knot(&path, knot, |_, _| {}), None);
                    knot += 1;
                }
            }
        }
        assert_ne!(talk.report.unwrap().path, 0);
        assert_eq!(talk.command(Command::Forget), None);
        let report = talk.report.unwrap();
        assert_eq!((report.state, report.known), (State::Idle, false));
        assert_eq!(
            (report.place, report.path),
            (FollowerPosition::default(), 0)
        );
        let refused = talk.knot(&path, 0, |_, _| {});
        assert_eq!(refused, Some(ItemRefusal::Incomplete));
        assert_eq!(talk.device.follower().state(), State::Idle);
    }
}

/// A setpoint of homogeneous half angles on a sheet of seven vertices is checked one vertex a round, and ticks come in
/// between. It is acknowledged once it is queued.
#[test]
fn a_setpoint_of_many_vertices_delays_no_tick() {
    // On this curve tan ρ₂/2 is half of tan ρ₁/2 everywhere, as in Miura's fold.
    let spans = [0.0, 1.0_f32];
    let (mut angles, mut weights) = (Vec::new(), Vec::new());
    for major in [0.0, 0.5_f32] {
        let (sin, cos) = (0.5 * major).sin_cos();
        angles.extend([major, 2.0 * (0.5 * sin).atan2(cos)]);
        weights.extend([[1.0, 0.0], [cos.hypot(0.5 * sin), 0.0]]);
    }
    let one = vertex::<f32>();
    let spokes = one.view().iter().next().unwrap().spokes.repeat(7);
    let ends: Vec<u32> = (1..=7).map(|star| 4 * star).collect();
    let kind = Interpolation::Homogeneous;
    let rates = [0.0; 4];
    let view = TrajectoryView::new(kind, 2, &spans, &angles, &rates, &weights).unwrap();
    let (stars, limits) = (StarsView::new(&spokes, &ends, 2).unwrap(), [LIMITS; 2]);
    let place = FollowerPosition::default();
    let path = Path::miura();
    let items = PathItems::new(view, &limits, &path.hinges, stars, 1e-4, place).unwrap();
    let mut talk = Talk::new();
    let mut scratch = [0; 256];
    let head = items.head() as u64;
    for index in 0..=head {
        assert_eq!(talk.item(items.item(index, &mut scratch).unwrap()), None);
    }
    let next = talk.report.unwrap().next;
    assert_eq!(u64::from(next), head + 1);
    // The first vertex is bounded when the setpoint comes, the second before its answer.
    assert_eq!(talk.item(items.item(head + 1, &mut scratch).unwrap()), None);
    for _ in 0..5 {
        assert!(talk.device.is_busy());
        assert_eq!(talk.device.follower().room(), 15);
        assert_eq!(talk.report.unwrap().next, next);
        talk.tick();
        talk.listen();
    }
    assert!(!talk.device.is_busy());
    assert_eq!(talk.device.follower().room(), 14);
    assert_eq!(talk.report.unwrap().next, next + 1);
    // A motion that fails meanwhile takes the setpoint along.
    let mut talk = Talk::new();
    for index in 0..=head + 1 {
        assert_eq!(talk.item(items.item(index, &mut scratch).unwrap()), None);
    }
    assert!(talk.device.is_busy());
    talk.device.follower_mut().fail(Fault::Leap(0));
    talk.listen();
    let refused = Some(ItemRefusal::Setpoint(Refusal::State));
    assert_eq!(talk.report.unwrap().refused, refused);
    assert!(!talk.device.is_busy());
}

/// Numbers of items have an order only within 2¹⁵, which bounds the room that is told.
#[test]
fn no_more_room_is_told_than_numbers_can_tell() {
    type Large = Controller<1, 1, 1, 40_000>;
    let test = || {
        let mut device = Box::new(Large::protected(settings(1), Unkeyed));
        let (version, schema) = (VERSION, SCHEMA);
        let hello = ToDevice::Hello {
            version,
            schema,
            id: 1,
        };
        let (mut session, mut rooms) = (0, Vec::new());
        for message in [hello, ToDevice::Alive] {
            let mut buffer = [0; 256];
            let frame = frame::seal(session, &message, &mut buffer).unwrap();
            cobs::encode(frame, |byte| device.byte(byte, 1));
            device.poll(1);
            let mut answers = Deframer::<256>::default();
            while let Some(byte) = device.take() {
                match answers.push(byte).and_then(frame::open) {
                    Some((_, ToHost::Welcome { session: told, .. })) => session = told,
                    Some((_, ToHost::Report(report))) => {
                        rooms.push(report.limit.wrapping_sub(report.next));
                    }
                    _ => {}
                }
            }
        }
        assert_eq!(rooms, [0x7fff]);
    };
    // The queue is larger than the stack of a test.
    let thread = std::thread::Builder::new().stack_size(64 << 20);
    thread.spawn(test).unwrap().join().unwrap();
}
