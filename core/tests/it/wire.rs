//! The wire protocol: frames from bytes, messages as the protocol documents them, and both ends, frame by frame.

use core::num::NonZero;

use crc::{CRC_32_ISO_HDLC, Crc};
use foldpath_core::acceptance::Refusal;
use foldpath_core::follower::{Denial, Fault, FollowerPosition, Reason, State};
use foldpath_core::trajectory::TrajectoryView;
use foldpath_core::trajectory_file::{self, LagCost, TrajectoryFile};
use foldpath_core::wire::cobs::{self, Deframer};
use foldpath_core::wire::file::FileItems;
use foldpath_core::wire::frame;
use foldpath_core::wire::message::{
    Capacity, Command, Item, ItemRefusal, Report, SCHEMA, SetpointBytes, SheetHead, ToDevice,
    ToHost, VERSION,
};
use foldpath_core::wire::path::{self, PathItems};
use foldpath_core::wire::protection::Unkeyed;
use foldpath_core::wire::receiver::{Event, Identity, Receiver};
use foldpath_core::wire::sender::{Failure, Options, Phase, Sender, Source};
use foldpath_core::wire::transmit::Ring;
use foldpath_core::{GroupId, GroupLimits, Interpolation, Membership, StarsView};
use foldpath_test_support::Random;
use foldpath_test_support::stars::miura;
use rand_core::Rng;
use serde::Serialize;

fn stuffed(payload: &[u8]) -> Vec<u8> {
    let mut bytes = Vec::new();
    cobs::encode(payload, |byte| bytes.push(byte));
    bytes
}

/// Returns the frames in a stream of bytes.
fn frames(bytes: &[u8]) -> Vec<Vec<u8>> {
    let mut deframer = Deframer::<600>::default();
    let found = bytes
        .iter()
        .filter_map(|&byte| deframer.push(byte).map(<[u8]>::to_vec));
    found.collect()
}

#[test]
fn the_examples_of_the_authors_are_stuffed_as_they_say() {
    // Examples from S. Cheshire and M. Baker, "Consistent overhead byte stuffing", 1999, and from Wikipedia's article
    // on it.
    let long: Vec<u8> = (1..=254).collect();
    let cases: [(&[u8], Vec<u8>); 6] = [
        (&[0], vec![1, 1, 0]),
        (&[0, 0], vec![1, 1, 1, 0]),
        (&[0, 0x11, 0], vec![1, 2, 0x11, 1, 0]),
        (&[0x11, 0x22, 0, 0x33], vec![3, 0x11, 0x22, 2, 0x33, 0]),
        (&[0x11, 0, 0, 0], vec![2, 0x11, 1, 1, 1, 0]),
        // A last block of 254 bytes may be followed by an empty block.
        (&long, [&[255], &long[..], &[1, 0]].concat()),
    ];
    for (payload, stuffed_bytes) in cases {
        assert_eq!(stuffed(payload), stuffed_bytes);
        assert_eq!(frames(&stuffed_bytes), [payload]);
    }
    assert_eq!(frames(&[&[255], &long[..], &[0]].concat()), [long]);
}

#[test]
fn any_payload_comes_back_and_has_no_zero_on_the_line() {
    let mut rng = Random::new(91);
    for length in 1..=600 {
        let mut payload = vec![0; length];
        rng.fill_bytes(&mut payload);
        if length % 3 == 0 {
            payload.iter_mut().for_each(|byte| *byte = (*byte).max(1));
        }
        let bytes = stuffed(&payload);
        assert!(bytes.len() <= cobs::longest(length));
        assert_eq!(
            bytes.iter().position(|&byte| byte == 0),
            Some(bytes.len() - 1)
        );
        assert_eq!(frames(&bytes), [payload]);
    }
}

#[test]
fn what_is_too_long_or_cut_off_is_no_frame_and_the_next_one_is() {
    let mut deframer = Deframer::<4>::default();
    let mut push = |bytes: &[u8]| -> Vec<Vec<u8>> {
        let found = bytes
            .iter()
            .filter_map(|&byte| deframer.push(byte).map(<[u8]>::to_vec));
        found.collect()
    };
    let none: [Vec<u8>; 0] = [];
    assert_eq!(push(&stuffed(&[1, 2, 3, 4, 5])), none);
    assert_eq!(push(&stuffed(&[1, 0, 3, 0])), [[1, 0, 3, 0]]);
    assert_eq!(push(&stuffed(&[1, 2, 3, 0, 0])), none);
    assert_eq!(push(&[5, 1, 2, 0]), none);
    assert_eq!(push(&[0, 0, 1, 0]), none);
    assert_eq!(push(&stuffed(&[9])), [[9]]);
}

#[test]
fn each_changed_bit_of_a_frame_is_noticed() {
    let mut buffer = [0; 64];
    let message = ToDevice::Command {
        number: 3,
        command: Command::Resume,
    };
    let frame = frame::seal(0x0102_0304, &message, &mut buffer).unwrap();
    assert_eq!(frame::open(frame), Some((0x0102_0304, message)));
    for bit in 0..frame.len() * 8 {
        let mut changed = frame.to_vec();
        changed[bit / 8] ^= 1 << (bit % 8);
        assert_eq!(frame::open::<ToDevice<'_>>(&changed), None, "bit {bit}");
    }
    for length in 0..frame.len() {
        assert_eq!(frame::open::<ToDevice<'_>>(&frame[..length]), None);
    }
    // Nothing may follow the message, even if the checksum is right.
    let longer = frame::seal(7, &(message, 0_u8), &mut buffer).unwrap();
    assert_eq!(frame::open::<ToDevice<'_>>(longer), None);
    for room in 0..longer.len() {
        assert_eq!(frame::seal(7, &(message, 0_u8), &mut [0; 64][..room]), None);
    }
}

/// Returns the protocol's examples: the bytes of each message and value, and their meaning.
fn examples() -> Vec<(Vec<u8>, &'static str)> {
    fn bytes(value: impl Serialize) -> Vec<u8> {
        postcard::to_slice(&value, &mut [0; 256]).unwrap().to_vec()
    }
    let place = FollowerPosition {
        knot: 200,
        into: 0.5,
    };
    let head = SheetHead {
        interpolation: Interpolation::Hermite,
        groups: 2,
        hinges: 1104,
        spokes: 4,
        closure: 0.001,
        path: 7,
        place,
        most_lag: 0.125,
    };
    let setpoint = SetpointBytes {
        number: 300,
        span: 0.5,
        last: true,
        nodes: &[0, 0, 128, 63, 0, 0, 0, 0],
    };
    let limits: Vec<u8> = [0.0, 1.5, 0.5, 2.0_f32]
        .iter()
        .flat_map(|x| x.to_le_bytes())
        .collect();
    let spoke: Vec<u8> = [[3, 0, 0, 0], 1.0_f32.to_le_bytes(), 0.0_f32.to_le_bytes()].concat();
    let item = |item| {
        bytes(ToDevice::Item {
            sequence: 300,
            item,
        })
    };
    let (version, schema, id) = (3, 0x1234_5678, 5);
    let report = Report {
        next: 300,
        limit: 316,
        heard: 7,
        epoch: 4,
        gap: true,
        refused: Some(ItemRefusal::Room),
        command: 2,
        denied: Some(Denial::Held),
        state: State::Holding,
        reason: Reason::StopLine,
        place,
        path: 7,
        known: true,
        stopped: true,
    };
    let telemetry = ToHost::Telemetry {
        time: 1_000_000,
        state: State::Running,
        rate: 0.5,
        place,
        first: 48,
        angles: &[0, 0, 128, 63],
    };
    let measured = ToHost::Measured {
        time: 1_000_000,
        first: 300,
        target: Some(1.5),
        angles: &[0, 0, 128, 63],
    };
    let window = ToHost::Measured {
        time: 1_000_000,
        first: 48,
        target: None,
        angles: &[0, 0, 128, 63, 0, 0, 192, 127],
    };
    let jog = |from, to| {
        let hinge = 300;
        bytes(Command::Jog { hinge, from, to })
    };
    let plain = Report {
        refused: None,
        denied: None,
        ..report
    };
    vec![
        (
            bytes(ToDevice::Hello {
                version,
                schema,
                id,
            }),
            "Hello: version 3, schema 12345678, id 5",
        ),
        (
            item(Item::Sheet(head)),
            "Item 300, Sheet: Hermite, 2 groups, 1104 hinges, 4 spokes, closure 0.001, path 7, begins 0.5 s behind knot 200, most lag 0.125",
        ),
        (
            item(Item::Limits(&limits)),
            "Item 300, Limits: 16 bytes, 0 to 1.5 rad, 0.5 rad/s, 2 rad/s²",
        ),
        (
            item(Item::Hinges(&[6])),
            "Item 300, Hinges: 1 byte, of 2 groups: group 1, group 0 the opposite way",
        ),
        (
            item(Item::Spokes(&spoke[2..])),
            "Item 300, Spokes: 10 bytes, group 0, along +x",
        ),
        (
            item(Item::Setpoint(setpoint)),
            "Item 300, Setpoint: 300, span 0.5 s, the last, 8 bytes: angle 1, rate 0",
        ),
        (
            item(Item::Nodes(setpoint.nodes)),
            "Item 300, Nodes: 8 bytes: angle 1, rate 0",
        ),
        (
            bytes(ToDevice::Command {
                number: 2,
                command: Command::Hold,
            }),
            "Command 2: Hold",
        ),
        (bytes(ToDevice::Alive), "Alive"),
        (
            bytes(ToDevice::Pair(&[7; 16])),
            "Pair: 16 bytes, all of them 7",
        ),
        (
            bytes(ToDevice::Seen {
                time: 1_000_000,
                groups: 48,
            }),
            "Seen: the telemetry of 1 s, up to group 48",
        ),
        (
            bytes(ToHost::Mismatch {
                id,
                version,
                schema,
            }),
            "Mismatch: id 5, version 3, schema 12345678",
        ),
        (
            bytes(ToHost::Welcome {
                id,
                session: 6,
                nonce: 300,
                epoch: 4,
                capacity: Capacity {
                    groups: 2,
                    hinges: 1104,
                    spokes: 16,
                    knots: 64,
                },
            }),
            "Welcome: id 5, session 6, nonce 300, epoch 4, room for 2 groups, 1104 hinges, 16 spokes, 64 setpoints",
        ),
        (bytes(ToHost::Unknown), "Unknown"),
        (
            bytes(ToHost::Report(plain)),
            "Report: next 300, limit 316, 7 frames have come, epoch 4, a gap, nothing refused, command 2 carried out, Holding, StopLine, 0.5 s behind knot 200, of path 7, which is known, and stopped",
        ),
        (
            bytes(ToHost::Report(report)),
            "the same with Room refused and the command denied: Held",
        ),
        (
            bytes(telemetry),
            "Telemetry: at 1 s, Running, rate 0.5, 0.5 s behind knot 200, from group 48 on 4 bytes: angle 1",
        ),
        (
            bytes(measured),
            "Measured: at 1 s, hinge 300 alone, commanded 1.5, 4 bytes: angle 1",
        ),
        (
            bytes(window),
            "Measured: at 1 s, from hinge 48 on, 8 bytes: angle 1, and no number, as hinge 49 was not measured",
        ),
        (bytes(Interpolation::Linear), "interpolation Linear"),
        (bytes(Interpolation::Hermite), "Hermite"),
        (bytes(Interpolation::HalfAngle), "HalfAngle"),
        (bytes(Interpolation::Homogeneous), "Homogeneous"),
        (bytes(Command::Start), "command Start"),
        (bytes(Command::Hold), "Hold"),
        (bytes(Command::Resume), "Resume"),
        (bytes(Command::Unload), "Unload"),
        (bytes(Command::Clear), "Clear"),
        (bytes(Command::Stand), "Stand"),
        (bytes(Command::Forget), "Forget"),
        (jog(None, Some(1.5)), "Jog: hinge 300 to 1.5"),
        (jog(Some(1.0), Some(1.5)), "Jog: hinge 300 from 1 to 1.5"),
        (jog(None, None), "Jog: hinge 300 is watched"),
        (bytes(State::Idle), "state Idle"),
        (bytes(State::Ready), "Ready"),
        (bytes(State::Running), "Running"),
        (bytes(State::Holding), "Holding"),
        (bytes(State::Done), "Done"),
        (bytes(State::Faulted), "Faulted"),
        (bytes(Reason::None), "reason None"),
        (bytes(Reason::HoldCommand), "HoldCommand"),
        (bytes(Reason::Underrun), "Underrun"),
        (bytes(Reason::Silence), "Silence"),
        (bytes(Reason::Lag(300)), "Lag of hinge 300"),
        (bytes(Reason::StopLine), "StopLine"),
        (bytes(Reason::Session), "Session"),
        (
            bytes(Reason::Refused(Refusal::Order)),
            "Refused, of a setpoint: Order",
        ),
        (
            bytes(Reason::Fault(Fault::Stalled(300))),
            "Fault: Stalled hinge 300",
        ),
        (bytes(Reason::Approach), "Approach"),
        (bytes(Reason::Lease), "Lease"),
        (bytes(Reason::LateTick), "LateTick"),
        (bytes(Fault::Stalled(300)), "fault Stalled: hinge 300"),
        (bytes(Fault::Leap(1)), "Leap of group 1"),
        (bytes(Fault::Torn(0)), "Torn at essential vertex 0"),
        (bytes(Denial::State), "denial State"),
        (bytes(Denial::Moving), "Moving"),
        (bytes(Denial::Groups), "Groups"),
        (bytes(Denial::Empty), "Empty"),
        (bytes(Denial::Place), "Place"),
        (bytes(Denial::Jump(1)), "Jump of group 1"),
        (bytes(Denial::Held), "Held"),
        (bytes(Denial::Unknown(1)), "Unknown: group 1"),
        (bytes(Denial::Spread(1)), "Spread of group 1"),
        (bytes(Denial::Range), "Range"),
        (bytes(Denial::Nonce), "Nonce"),
        (
            bytes(ItemRefusal::Setpoint(Refusal::Order)),
            "item refused, Setpoint: Order",
        ),
        (bytes(ItemRefusal::Path(Denial::Groups)), "Path: Groups"),
        (bytes(ItemRefusal::Room), "Room"),
        (bytes(ItemRefusal::Pieces), "Pieces"),
        (bytes(ItemRefusal::Incomplete), "Incomplete"),
        (bytes(ItemRefusal::Limits(1)), "Limits of group 1"),
        (bytes(ItemRefusal::Hinge(300)), "Hinge 300"),
        (bytes(ItemRefusal::Stars), "Stars"),
        (bytes(ItemRefusal::Closure), "Closure"),
        (bytes(Refusal::State), "setpoint refused, State"),
        (bytes(Refusal::Full), "Full"),
        (bytes(Refusal::Sequence(300)), "Sequence: expected 300"),
        (bytes(Refusal::Groups), "Groups"),
        (bytes(Refusal::NotFinite(1)), "NotFinite in group 1"),
        (bytes(Refusal::HalfTurn(1)), "HalfTurn of group 1"),
        (bytes(Refusal::Weight(1)), "Weight of group 1"),
        (bytes(Refusal::Order), "Order"),
        (bytes(Refusal::Range(1)), "Range of group 1"),
        (bytes(Refusal::Speed(1)), "Speed of group 1"),
        (bytes(Refusal::Acceleration(1)), "Acceleration of group 1"),
        (bytes(Refusal::Open(0)), "Open at essential vertex 0"),
        (
            bytes(Refusal::OpenBetween(0)),
            "OpenBetween at essential vertex 0",
        ),
    ]
}

/// Returns the lines of the protocol's block of hexadecimal numbers number `block`, counted from behind the block of
/// the file.
pub(crate) fn documented(block: usize) -> Vec<&'static str> {
    let text = include_str!("../../../firmware-sim/PROTOCOL.md");
    let blocks = text.split("```hex\n").skip(2 + block);
    let block = blocks
        .map(|block| block.split("```").next().unwrap())
        .next();
    block.unwrap_or_default().lines().collect()
}

pub(crate) fn hex(bytes: &[u8]) -> String {
    bytes.iter().map(|byte| format!("{byte:02x} ")).collect()
}

/// A reader takes varints that are longer than their numbers need, up to the length of their type.
#[test]
fn varints_may_be_longer_than_their_numbers() {
    let read = |time: &[u8], groups: &[u8]| {
        let bytes = [&[5][..], time, groups].concat();
        let read = postcard::from_bytes::<ToDevice<'_>>(&bytes).ok();
        read.map(|message| format!("{message:?}"))
    };
    let short = read(&[1], &[0]);
    assert!(short.is_some());
    for time in [
        &[0x81, 0][..],
        &[0x81, 0x80, 0],
        &[0x81, 0x80, 0x80, 0x80, 0],
    ] {
        assert_eq!(read(time, &[0x80, 0x80, 0]), short);
    }
    // Six bytes, and more than 32 and 16 bits.
    assert_eq!(read(&[0x81, 0x80, 0x80, 0x80, 0x80, 0], &[0]), None);
    assert_eq!(read(&[0x81, 0x80, 0x80, 0x80, 0x10], &[0]), None);
    assert_eq!(read(&[1], &[0x80, 0x80, 4]), None);
}

#[test]
fn the_protocol_lists_every_message_as_it_is() {
    let examples = examples();
    let lines = examples
        .iter()
        .map(|(bytes, what)| format!("{}| {what}", hex(bytes)));
    let lines: Vec<String> = lines.collect();
    assert_eq!(documented(1), lines, "\n{}\n", lines.join("\n"));
    let all: Vec<u8> = examples
        .iter()
        .flat_map(|(bytes, _)| bytes.clone())
        .collect();
    let crc = Crc::<u32>::new(&CRC_32_ISO_HDLC).checksum(&all);
    assert_eq!(
        SCHEMA, crc,
        "the schema is {crc:#010x}, and the version another"
    );
}

#[test]
fn the_protocols_frame_is_on_the_line_as_it_is() {
    let mut buffer = [0; 64];
    let command = Command::Start;
    let frame = frame::seal(6, &ToDevice::Command { number: 1, command }, &mut buffer).unwrap();
    let lines = documented(0);
    let bytes: Vec<u8> = lines
        .iter()
        .flat_map(|line| line.split('|').next().unwrap().split_whitespace())
        .map(|number| u8::from_str_radix(number, 16).unwrap())
        .collect();
    assert_eq!(hex(&bytes), hex(&stuffed(frame)));
}

/// Returns a controller of this nonce.
fn numbered(nonce: u64) -> Identity {
    Identity {
        nonce,
        ..Identity::default()
    }
}

/// A source of `u64` items; each item holds its own number.
struct Numbers(u64);

impl Source for Numbers {
    fn item<'b>(&self, index: u64, scratch: &'b mut [u8]) -> Option<Item<'b>> {
        if index >= self.0 {
            return None;
        }
        let bytes = scratch.first_chunk_mut::<8>()?;
        *bytes = index.to_le_bytes();
        Some(Item::Hinges(bytes))
    }
}

fn number(item: Item<'_>) -> u64 {
    match item {
        Item::Hinges(bytes) => u64::from_le_bytes(bytes.try_into().unwrap()),
        other => panic!("{other:?}"),
    }
}

/// Both ends of the line; the test hands over the frames.
struct Ends {
    now: u64,
    sender: Sender,
    receiver: Receiver,
    source: Numbers,
    room: u16,
    came: Vec<u64>,
    commands: Vec<Command>,
}

impl Ends {
    fn new(items: u64, room: u16) -> Self {
        Self {
            now: 0,
            sender: Sender::new(5, Options::default()),
            receiver: Receiver::protected(numbered(0), Unkeyed),
            source: Numbers(items),
            room,
            came: Vec::new(),
            commands: Vec::new(),
        }
    }

    fn open(items: u64, room: u16) -> Self {
        let mut ends = Self::new(items, room);
        while ends.sender.phase() != Phase::Open {
            ends.exchange();
        }
        ends
    }

    /// Returns the host's next frame, if it has one.
    fn said(&mut self) -> Option<Vec<u8>> {
        let (mut scratch, mut buffer) = ([0; 64], [0; 128]);
        let frame = self
            .sender
            .poll(self.now, &self.source, &mut scratch, &mut buffer);
        frame.map(<[u8]>::to_vec)
    }

    /// Hands a frame to the receiver. Takes every item, and denies `Command::Clear` alone.
    fn hear(&mut self, frame: &[u8]) {
        match self.receiver.receive(frame, self.room) {
            Some(Event::Item(item)) => {
                self.came.push(number(item));
                self.receiver.took();
            }
            Some(Event::Command(command)) => {
                self.commands.push(command);
                let denied = command == Command::Clear;
                self.receiver
                    .answer(if denied { Err(Denial::State) } else { Ok(()) });
            }
            _ => {}
        }
    }

    /// Returns the controller's next answer, if one is due.
    fn answered(&mut self) -> Option<Vec<u8>> {
        let status = Report {
            known: true,
            ..Report::default()
        };
        let mut buffer = [0; 128];
        let frame = self.receiver.poll(&status, self.room, &mut buffer);
        let frame = frame.map(<[u8]>::to_vec);
        if frame.is_some() {
            self.receiver.sent();
        }
        frame
    }

    /// Exchanges all frames that are due, both ways, and lets 1 ms pass.
    fn exchange(&mut self) {
        while let Some(frame) = self.said() {
            self.hear(&frame);
        }
        while let Some(frame) = self.answered() {
            self.sender.receive(&frame, self.now);
        }
        self.now += 1000;
    }
}

#[test]
fn items_come_once_each_and_in_order_with_the_numbers_wrapping_round() {
    let mut ends = Ends::open(70_000, 100);
    while ends.sender.acknowledged() < 70_000 {
        ends.exchange();
    }
    assert!(ends.came.iter().copied().eq(0..70_000));
    assert_eq!(ends.sender.repeated(), 0);
}

#[test]
fn no_more_is_sent_than_there_is_room_for() {
    let mut ends = Ends::open(50, 3);
    let sent: Vec<_> = core::iter::from_fn(|| ends.said()).collect();
    assert_eq!(sent.len(), 3);
    sent.iter().for_each(|frame| ends.hear(frame));
    ends.room = 0;
    let report = ends.answered().unwrap();
    ends.sender.receive(&report, ends.now);
    assert_eq!((ends.sender.acknowledged(), ends.said()), (3, None));
    // An item for which there is no room is dropped, but is no gap.
    ends.hear(&sent[0]);
    let report = ends.answered().unwrap();
    assert!(matches!(
        frame::open(&report),
        Some((
            _,
            ToHost::Report(Report {
                next: 3,
                limit: 3,
                gap: false,
                ..
            })
        ))
    ));
    ends.room = 1;
    ends.receiver.announce();
    let report = ends.answered().unwrap();
    ends.sender.receive(&report, ends.now);
    assert!(ends.said().is_some() && ends.said().is_none());
}

#[test]
fn a_gap_is_reported_once_and_answered_once() {
    let mut ends = Ends::open(50, 20);
    let sent: Vec<_> = core::iter::from_fn(|| ends.said()).collect();
    assert_eq!(sent.len(), 20);
    let mut gaps = Vec::new();
    for frame in sent.iter().take(4).chain(sent.iter().skip(5)) {
        ends.hear(frame);
        while let Some(report) = ends.answered() {
            if let Some((_, ToHost::Report(Report { gap: true, .. }))) = frame::open(&report) {
                gaps.push(report.clone());
            }
            ends.sender.receive(&report, ends.now);
        }
    }
    assert_eq!(gaps.len(), 1);
    // The gap is not told again, whatever else is asked.
    let mut buffer = [0; 64];
    let session = ends.receiver.session().unwrap();
    let alive = frame::seal(session, &ToDevice::Alive, &mut buffer).unwrap();
    ends.hear(alive);
    let report = ends.answered().unwrap();
    let said = frame::open(&report);
    assert!(matches!(
        said,
        Some((_, ToHost::Report(Report { gap: false, .. })))
    ));
    let again: Vec<_> = core::iter::from_fn(|| ends.said()).collect();
    assert_eq!(again.len(), 20);
    // The report arrives twice, but the items are not sent a third time.
    ends.sender.receive(&gaps[0], ends.now);
    assert_eq!(ends.said(), None);
    again.iter().for_each(|frame| ends.hear(frame));
    assert!(ends.came.iter().copied().eq(0..24));
}

/// A late report must not take back the acknowledgements of later reports, nor acknowledge items that were not sent.
#[test]
fn a_late_report_after_a_rewind_changes_nothing() {
    let mut ends = Ends::open(50, 20);
    let sent: Vec<_> = core::iter::from_fn(|| ends.said()).collect();
    ends.hear(&sent[0]);
    let early = ends.answered().unwrap();
    sent[1..8].iter().for_each(|frame| ends.hear(frame));
    let middle = ends.answered().unwrap();
    sent[10..].iter().for_each(|frame| ends.hear(frame));
    let gap = ends.answered().unwrap();
    ends.sender.receive(&gap, ends.now);
    assert_eq!(ends.sender.acknowledged(), 8);
    for late in [&early, &middle, &early] {
        ends.sender.receive(late, ends.now);
        assert_eq!(ends.sender.acknowledged(), 8);
    }
    ends.exchange();
    ends.exchange();
    assert!(ends.came.iter().copied().eq(0..ends.came.len() as u64) && ends.came.len() >= 20);
}

#[test]
fn what_is_not_acknowledged_is_sent_again_after_a_while() {
    let mut ends = Ends::open(2, 20);
    let retry = Options::default().retry;
    let first: Vec<_> = core::iter::from_fn(|| ends.said()).collect();
    ends.now += retry - 1;
    assert_eq!(ends.said(), None);
    ends.now += 1;
    let second: Vec<_> = core::iter::from_fn(|| ends.said()).collect();
    assert_eq!((first.len(), &first), (2, &second));
    assert_eq!(ends.sender.repeated(), 2);
}

#[test]
fn a_command_is_carried_out_once_however_often_it_comes_and_its_end_is_told() {
    let mut ends = Ends::open(0, 5);
    for round in 0..600_usize {
        let command = if round % 2 == 0 {
            Command::Start
        } else {
            Command::Clear
        };
        assert!(ends.sender.command(command));
        assert!(!ends.sender.command(command));
        let frame = ends.said().unwrap();
        ends.hear(&frame);
        ends.answered().unwrap(); // lost
        assert_eq!(ends.sender.answer(), None);
        ends.now += Options::default().retry;
        let again = ends.said().unwrap();
        assert_eq!(frame, again);
        ends.hear(&again);
        let report = ends.answered().unwrap();
        ends.sender.receive(&report, ends.now);
        let denied = if round % 2 == 0 {
            Ok(())
        } else {
            Err(Denial::State)
        };
        assert_eq!(ends.sender.answer(), Some(denied));
        assert_eq!(ends.commands.len(), round + 1);
    }
}

#[test]
fn a_refused_item_is_told_until_another_comes_in_its_place() {
    let mut ends = Ends::open(10, 5);
    let sent: Vec<_> = core::iter::from_fn(|| ends.said()).collect();
    ends.hear(&sent[0]);
    assert!(matches!(
        ends.receiver.receive(&sent[1], 4),
        Some(Event::Item(_))
    ));
    ends.receiver.refuse(ItemRefusal::Pieces);
    sent[2..].iter().for_each(|frame| ends.hear(frame));
    let report = ends.answered().unwrap();
    ends.sender.receive(&report, ends.now);
    let report = *ends.sender.report().unwrap();
    assert_eq!(
        (report.next, report.gap, report.refused),
        (1, false, Some(ItemRefusal::Pieces))
    );
    ends.now += Options::default().retry;
    let alive = ends.said();
    assert!(alive.is_none_or(|frame| matches!(frame::open(&frame), Some((_, ToDevice::Alive)))));
    ends.sender.amend();
    ends.exchange();
    ends.exchange();
    assert!(ends.came.iter().copied().eq(0..10));
    assert_eq!(ends.sender.report().unwrap().refused, None);
}

#[test]
fn a_session_begins_with_its_first_frame_and_not_with_a_late_greeting() {
    let mut ends = Ends::new(20, 5);
    let hello = ends.said().unwrap();
    ends.hear(&hello);
    assert_eq!(ends.receiver.session(), None);
    ends.exchange();
    ends.exchange();
    let session = ends.receiver.session().unwrap();
    assert!(ends.receiver.opened() && !ends.receiver.opened());
    // Repeats the greeting of this host, then brings that of a host that never goes on.
    ends.hear(&hello);
    let mut buffer = [0; 64];
    let other = ToDevice::Hello {
        version: VERSION,
        schema: SCHEMA,
        id: 9,
    };
    let other = frame::seal(0, &other, &mut buffer).unwrap().to_vec();
    ends.hear(&other);
    assert_eq!(ends.receiver.session(), Some(session));
    (0..10).for_each(|_| ends.exchange());
    assert!(ends.came.iter().copied().eq(0..20) && !ends.receiver.opened());
}

/// The sum of id and count would be the number of the open session, or 0; both must be avoided.
#[test]
fn no_two_hosts_share_a_session() {
    let mut ends = Ends::open(20, 5);
    let open = ends.receiver.session().unwrap();
    for id in [open.wrapping_sub(2), 0_u32.wrapping_sub(4)] {
        let mut buffer = [0; 64];
        let hello = ToDevice::Hello {
            version: VERSION,
            schema: SCHEMA,
            id,
        };
        let hello = frame::seal(0, &hello, &mut buffer).unwrap().to_vec();
        ends.hear(&hello);
        let answer = ends.answered().unwrap();
        let Some((0, ToHost::Welcome { session, .. })) = frame::open(&answer) else {
            panic!("no welcome");
        };
        assert!(session != open && session != 0, "{session}");
    }
}

#[test]
fn a_host_whose_session_is_over_is_told() {
    let mut ends = Ends::open(20, 5);
    ends.receiver = Receiver::protected(numbered(1), Unkeyed);
    let frame = ends.said().unwrap();
    ends.hear(&frame);
    assert!(ends.came.is_empty());
    let answer = ends.answered().unwrap();
    ends.sender.receive(&answer, ends.now);
    assert_eq!(ends.sender.phase(), Phase::Failed(Failure::Lost));
    assert_eq!(ends.said(), None);
}

#[test]
fn a_silent_controller_is_given_up() {
    let mut ends = Ends::open(0, 5);
    ends.now += 600_000;
    assert!(ends.said().is_some());
    ends.now += Options::default().silence;
    assert!(ends.said().is_some());
    ends.now += 1;
    assert_eq!(ends.said(), None);
    assert_eq!(ends.sender.phase(), Phase::Failed(Failure::Silent));
}

#[test]
fn a_ring_takes_whole_frames_and_keeps_its_reserve() {
    let mut ring = Ring::<20>::default();
    let frame = [7, 0, 7, 7];
    assert!(ring.add(&frame, 14));
    assert!(!ring.add(&frame, 9));
    assert!(ring.add(&frame, 8));
    assert!(!ring.add(&[0; 7], 0));
    let bytes: Vec<u8> = core::iter::from_fn(|| ring.take()).collect();
    assert_eq!(bytes, stuffed(&frame).repeat(2));
    assert!(ring.is_empty());
}

#[test]
fn random_bytes_are_neither_frames_nor_panics() {
    let mut rng = Random::new(92);
    let mut receiver = Receiver::protected(numbered(0), Unkeyed);
    let mut sender = Sender::new(5, Options::default());
    let mut deframer = Deframer::<64>::default();
    let mut buffer = [0; 64];
    for _ in 0..200_000 {
        if let Some(frame) = deframer.push(u8::try_from(rng.below(256)).unwrap()) {
            assert_eq!(receiver.receive(frame, 5), None);
            assert_eq!(sender.receive(frame, 0), None);
        }
    }
    // With a good checksum the random bytes are decoded as messages.
    for _ in 0..200_000 {
        let mut body = [0; 24];
        rng.fill_bytes(&mut body);
        body[0] %= 8;
        let length = 1 + rng.below(23);
        // A serialised list would begin with its length, so that the bytes are appended as they are.
        let mut frame = [0, 0, 0, 0].to_vec();
        frame.extend(&body[..length]);
        let crc = Crc::<u32>::new(&CRC_32_ISO_HDLC).checksum(&frame);
        frame.extend(crc.to_le_bytes());
        if let Some(Event::Item(_)) = receiver.receive(&frame, 5) {
            receiver.took();
        }
        let _ = sender.receive(&frame, 0);
        let status = Report {
            known: true,
            ..Report::default()
        };
        if receiver.poll(&status, 5, &mut buffer).is_some() {
            receiver.sent();
        }
    }
    assert!(ends_meet(&mut receiver));
}

/// Returns `true` if the receiver still takes a host's items.
fn ends_meet(receiver: &mut Receiver) -> bool {
    let mut ends = Ends::new(20, 5);
    ends.receiver = receiver.clone();
    ends.sender = Sender::new(77, Options::default());
    for _ in 0..200 {
        ends.exchange();
    }
    ends.came.iter().copied().eq(0..20)
}

#[test]
fn codes_of_hinges_take_as_few_bits_as_they_can() {
    let bits = [
        (0, 1),
        (1, 1),
        (2, 2),
        (3, 3),
        (4, 3),
        (5, 4),
        (1 << 14, 15),
    ];
    for (groups, expected) in bits {
        assert_eq!(path::hinge_bits(groups).get(), expected, "{groups} groups");
    }
    // Worked out by hand: 5, 2, 7 and 0 in three bits each are 000 111 010 101, the lowest bits last.
    let codes: Vec<u16> = path::hinge_codes(&[0b1101_0101, 0b0000_0001], width(3)).collect();
    assert_eq!(codes, [5, 2, 7, 0, 0]);
}

/// For a sheet like the 24x24 Miura only the angles of its groups travel.
#[test]
fn a_path_in_items_is_whole_and_a_hundredth_of_its_hinges() {
    let (knots, hinges) = (300_u16, 1104_u16);
    let spans: Vec<f32> = (0..knots).map(|knot| f32::from(knot.min(1))).collect();
    let angles: Vec<f32> = (0..2 * knots).map(|k| f32::from(k) * 1e-3).collect();
    let rates: Vec<f32> = angles.iter().map(|angle| -angle).collect();
    let view = TrajectoryView::new(Interpolation::Hermite, 2, &spans, &angles, &rates, &[]);
    let member = |hinge| Membership {
        group: GroupId(u32::from(hinge % 2_u16)),
        negative: hinge % 3 == 0,
    };
    let members: Vec<Membership> = (0..hinges).map(member).collect();
    let stars = miura::<f32>(60.0, false, false);
    let limits = [0.5, 1.5].map(|upper| GroupLimits {
        lower: 0.0,
        upper,
        speed: 1.0,
        acceleration: f32::INFINITY,
    });
    let place = FollowerPosition {
        knot: 7,
        into: 0.25,
    };
    let new =
        |members, place| PathItems::new(view.unwrap(), &limits, members, stars.view(), 1e-6, place);
    let items = new(&members, place).unwrap();
    let (mut scratch, mut buffer) = ([0; 256], [0; 256]);
    let (mut bytes, mut count) = (0, 0);
    let (mut came_limits, mut came_hinges, mut came_spokes) = (vec![], vec![], vec![]);
    let (mut came_angles, mut came_rates) = (vec![], vec![]);
    for index in 0.. {
        let Some(item) = items.item(index, &mut scratch) else {
            break;
        };
        count += 1;
        let sequence = u16::try_from(index).unwrap();
        let frame = frame::seal(0x1234_5678, &ToDevice::Item { sequence, item }, &mut buffer);
        bytes += stuffed(frame.unwrap()).len();
        match item {
            Item::Sheet(head) => assert_eq!((head.hinges, head.place), (hinges, place)),
            Item::Limits(bytes) => came_limits.extend(bytes.as_chunks().0.iter().map(path::limits)),
            Item::Hinges(bytes) => {
                let left = usize::from(hinges) - came_hinges.len();
                came_hinges.extend(
                    path::hinge_codes(bytes, width(2))
                        .take(left)
                        .map(|code| Membership::from_code(code.into())),
                );
            }
            Item::Spokes(bytes) => {
                came_spokes.extend(bytes.as_chunks().0.iter().map(|b| path::spoke(*b)));
            }
            Item::Nodes(_) => panic!("two groups fit into one item"),
            Item::Setpoint(setpoint) => {
                assert_eq!(setpoint.last, index + 1 == items.count() as u64);
                for node in path::nodes(Interpolation::Hermite, setpoint.nodes) {
                    came_angles.push(node.angle);
                    came_rates.push(node.rate);
                }
            }
        }
    }
    assert_eq!(count, items.count());
    assert_eq!(
        (came_limits, came_hinges),
        (limits.to_vec(), members.clone())
    );
    let spokes = stars.spokes.iter().map(|spoke| (*spoke, false));
    let mut spokes: Vec<_> = spokes.collect();
    spokes[3].1 = true;
    assert_eq!(came_spokes, spokes);
    assert_eq!(
        (&came_angles[..], &came_rates[..]),
        (&angles[14..], &rates[14..])
    );
    let each_hinge = usize::from(knots - 7) * usize::from(hinges) * 8;
    assert!(bytes * 100 <= each_hinge, "{bytes} of {each_hinge}");

    let beyond = FollowerPosition {
        knot: 300,
        into: 0.0,
    };
    assert!(new(&members, beyond).is_none());
    let lost = Membership {
        group: GroupId(u32::MAX),
        negative: false,
    };
    assert!(new(&[lost], place).is_none());
}

/// A file gives the same items as the path that was written to it, of groups that fill several items, with and without
/// weights, from any knot on.
#[test]
fn a_file_gives_the_items_of_its_path() {
    let (knots, groups) = (5_u16, 31_u16);
    let spans: Vec<f32> = (0..knots).map(|knot| f32::from(knot.min(1))).collect();
    let angles: Vec<f32> = (0..groups * knots).map(|k| f32::from(k) * 1e-3).collect();
    let rates: Vec<f32> = angles.iter().map(|angle| -angle).collect();
    let weights: Vec<[f32; 2]> = angles.iter().map(|angle| [1.0 + angle, *angle]).collect();
    let member = |hinge| Membership {
        group: GroupId(u32::from(hinge % groups)),
        negative: hinge % 3 == 0,
    };
    let members: Vec<Membership> = (0..301).map(member).collect();
    let limits: Vec<GroupLimits> = (1..=groups)
        .map(|group| GroupLimits {
            lower: -1.0,
            upper: f32::from(group),
            speed: 1.0,
            acceleration: f32::INFINITY,
        })
        .collect();
    let vertex = miura::<f32>(60.0, false, false).spokes;
    let spokes: Vec<_> = [&vertex[..], &vertex[..], &vertex[..], &vertex[..]].concat();
    let stars = StarsView::new(&spokes, &[4, 8, 12, 16], groups.into()).unwrap();
    let mut identities = Vec::new();
    for (kind, weights) in [
        (Interpolation::Hermite, &[][..]),
        (Interpolation::Homogeneous, &weights[..]),
    ] {
        let view = TrajectoryView::new(kind, groups.into(), &spans, &angles, &rates, weights);
        let view = view.unwrap();
        let mut bytes = Vec::new();
        let sink = |piece: &[u8]| bytes.extend(piece);
        let cost = LagCost {
            most_lag: 0.125,
            gaps: &[],
        };
        trajectory_file::write(view, &limits, &members, stars, 1e-6, cost, sink).unwrap();
        let file = FileItems::new(TrajectoryFile::read(&bytes).unwrap()).unwrap();
        for knot in 0..u32::from(knots) {
            let place = FollowerPosition { knot, into: 0.25 };
            let items = PathItems::new(view, &limits, &members, stars, 1e-6, place).unwrap();
            let items = items.with_most_lag(cost.most_lag);
            let file = file.at(place).unwrap();
            assert_eq!(file.identity(), items.identity());
            for index in 0..=items.count() as u64 {
                let (mut a, mut b) = ([0; 256], [0; 256]);
                let item = items.item(index, &mut a);
                assert_eq!(file.item(index, &mut b), item, "{kind:?} {knot} {index}");
                assert_eq!(item.is_some(), index < items.count() as u64);
            }
        }
        identities.push(file.identity());
        let beyond = FollowerPosition {
            knot: knots.into(),
            into: 0.0,
        };
        assert!(file.at(beyond).is_none());
    }
    assert_ne!(identities[0], identities[1]);
}

fn width(count: usize) -> NonZero<usize> {
    NonZero::new(count).unwrap()
}
