//! Attacks with frames: nothing is taken, and neither end changes in any way.

use foldpath_core::follower::FollowerPosition;
use foldpath_core::wire::driver::{Driver, Persistence};
use foldpath_core::wire::key::Key;
use foldpath_core::wire::message::{Command, Item, Report, ToDevice, ToHost};
use foldpath_core::wire::protection::{Keyed, Unkeyed};
use foldpath_core::wire::receiver::{Event, Identity, Receiver};
use foldpath_core::wire::sender::{Options, Sender, Source};
use rand_core::Rng;

use super::{KEY, OTHER};
use crate::path::below;
use crate::world::rng;

/// Number of forged frames. A tag of 64 bits is right by chance once in 10¹⁹ frames.
const FORGED: u64 = 1_000_000;

/// Items that hold nothing but their numbers.
struct Numbers(u64);

impl Source for Numbers {
    fn item<'b>(&self, index: u64, scratch: &'b mut [u8]) -> Option<Item<'b>> {
        let bytes = scratch.first_chunk_mut::<8>()?;
        *bytes = index.to_le_bytes();
        (index < self.0).then_some(Item::Hinges(bytes))
    }
}

/// Both ends of a line with a key, and all that went over it.
struct Line {
    now: u64,
    source: Numbers,
    sender: Sender,
    receiver: Receiver<Keyed>,
    up: Vec<Vec<u8>>,
    down: Vec<Vec<u8>>,
    events: usize,
}

/// Nonce of the first run of the controller.
const NONCE: u64 = 0x0123_4567_89ab_cdef;

fn receiver(nonce: u64) -> Receiver<Keyed> {
    let identity = Identity {
        nonce,
        ..Identity::default()
    };
    Receiver::protected(identity, Keyed::new(Some(KEY)))
}

fn host(id: u32, nonce: u32) -> Sender {
    Sender::new(id, Options::default()).with_key(KEY, nonce)
}

impl Line {
    fn new() -> Self {
        Self {
            now: 0,
            source: Numbers(20),
            sender: host(5, 9),
            receiver: receiver(NONCE),
            up: Vec::new(),
            down: Vec::new(),
            events: 0,
        }
    }

    /// A line on which 20 items and a command went through.
    fn used() -> Self {
        let mut line = Self::new();
        line.run(20);
        assert!(line.sender.command(Command::Start));
        line.run(20);
        assert_eq!(line.sender.acknowledged(), 20);
        assert_eq!(line.sender.answer(), Some(Ok(())));
        assert!(line.events > 20 && line.up.len() > 20 && line.down.len() > 5);
        line
    }

    fn said(&mut self) -> Option<Vec<u8>> {
        let (mut scratch, mut buffer) = ([0; 64], [0; 128]);
        let frame = self
            .sender
            .poll(self.now, &self.source, &mut scratch, &mut buffer);
        frame.map(<[u8]>::to_vec)
    }

    fn answered(&mut self) -> Option<Vec<u8>> {
        let status = Report {
            known: true,
            ..Report::default()
        };
        let mut buffer = [0; 128];
        self.receiver.clock(self.now);
        let frame = self.receiver.poll(&status, 5, &mut buffer)?.to_vec();
        self.receiver.sent();
        Some(frame)
    }

    /// Hands a frame to the controller; returns `true` if the controller has to act on it.
    fn hear(&mut self, frame: &[u8]) -> bool {
        self.receiver.clock(self.now);
        let event = self.receiver.receive(frame, 5);
        let acts = event.is_some();
        match event {
            Some(Event::Item(_)) => self.receiver.took(),
            Some(Event::Command(_)) => self.receiver.answer(Ok(())),
            _ => {}
        }
        self.events += usize::from(acts);
        acts
    }

    fn run(&mut self, millis: u64) {
        for _ in 0..millis {
            while let Some(frame) = self.said() {
                self.hear(&frame);
                self.up.push(frame);
            }
            while let Some(frame) = self.answered() {
                self.sender.receive(&frame, self.now);
                self.down.push(frame);
            }
            self.now += 1000;
        }
    }

    /// Asserts that the controller does not take a frame, and is as it was.
    fn refuses(&mut self, frame: &[u8]) {
        let before = format!("{:?}", self.receiver);
        assert!(!self.hear(frame), "{frame:02x?}");
        assert_eq!(format!("{:?}", self.receiver), before, "{frame:02x?}");
    }

    /// Asserts that the host does not take a frame, and is as it was.
    fn ignores(&mut self, frame: &[u8]) {
        let before = format!("{:?}", self.sender);
        assert_eq!(self.sender.receive(frame, self.now), None, "{frame:02x?}");
        assert_eq!(format!("{:?}", self.sender), before, "{frame:02x?}");
    }

    /// Asserts that frames of the host still come through.
    fn goes_on(&mut self) {
        self.source.0 += 5;
        self.run(600);
        assert_eq!(self.sender.acknowledged(), self.source.0);
    }
}

fn session(frame: &[u8]) -> u32 {
    u32::from_le_bytes(frame[1..5].try_into().unwrap())
}

fn greets(frame: &[u8]) -> bool {
    session(frame) == 0
}

#[test]
fn frames_that_are_played_back_in_their_session_do_nothing() {
    let mut line = Line::used();
    let (up, down) = (line.up.clone(), line.down.clone());
    let open = line.receiver.session();
    for frame in up.iter().chain(up.iter().rev()) {
        if greets(frame) {
            // The greeting is answered by the same offer.
            assert!(!line.hear(frame));
            assert_eq!(
                line.answered().as_ref(),
                down.iter().find(|frame| greets(frame))
            );
        } else {
            line.refuses(frame);
        }
    }
    down.iter().for_each(|frame| line.ignores(frame));
    assert_eq!(line.receiver.session(), open);
    line.goes_on();
}

#[test]
fn a_session_that_is_played_back_in_another_run_does_nothing() {
    let recorded = Line::used();
    // A bit of the nonce differs.
    for bit in 0..64 {
        let mut line = Line::new();
        line.receiver = receiver(NONCE ^ 1 << bit);
        for frame in &recorded.up {
            assert!(!line.hear(frame));
            // Offers are all that is said.
            while let Some(answer) = line.answered() {
                assert!(greets(&answer) && answer[5] == 1, "{answer:02x?}");
            }
        }
        assert_eq!(line.receiver.session(), None);
        // Another host does not take what the controller of that run has said.
        line.sender = host(5, 10);
        line.said().unwrap();
        recorded.down.iter().for_each(|frame| line.ignores(frame));
        line.goes_on();
    }
}

#[test]
fn a_session_that_is_over_does_not_come_back() {
    let mut line = Line::used();
    let recorded = line.up.clone();
    line.sender = host(6, 9);
    line.run(600);
    let open = line.receiver.session();
    assert!(open.is_some_and(|open| open != session(&recorded[1])));
    for _ in 0..3 {
        for frame in &recorded {
            assert!(!line.hear(frame));
            while let Some(answer) = line.answered() {
                assert!(greets(&answer), "{answer:02x?}");
            }
        }
    }
    assert_eq!(line.receiver.session(), open);
    line.goes_on();
}

#[test]
fn frames_that_are_sent_back_do_nothing() {
    let mut line = Line::used();
    let (up, down) = (line.up.clone(), line.down.clone());
    down.iter().for_each(|frame| line.refuses(frame));
    up.iter().for_each(|frame| line.ignores(frame));
    // Nor do greetings while they are expected.
    let mut fresh = Line::new();
    fresh.ignores(&up[0]);
    let hello = fresh.said().unwrap();
    fresh.ignores(&hello);
    fresh.hear(&hello);
    let welcome = fresh.answered().unwrap();
    fresh.refuses(&welcome);
    assert!(fresh.sender.receive(&welcome, 0).is_some());
    line.goes_on();
}

#[test]
fn frames_that_are_changed_cut_off_or_longer_do_nothing() {
    let mut line = Line::used();
    line.source.0 += 1;
    let frame = line.said().unwrap();
    assert!(!greets(&frame));
    for bit in 0..8 * frame.len() {
        let mut changed = frame.clone();
        changed[bit / 8] ^= 1 << (bit % 8);
        line.refuses(&changed);
    }
    for length in 0..frame.len() {
        line.refuses(&frame[..length]);
        line.refuses(&frame[length + 1..]);
        let mut without = frame.clone();
        without.remove(length);
        line.refuses(&without);
    }
    for more in 0..=255 {
        line.refuses(&[&frame[..], &[more]].concat());
    }
    assert!(line.hear(&frame));
    line.refuses(&frame);
    let answer = line.answered().unwrap();
    for bit in 0..8 * answer.len() {
        let mut changed = answer.clone();
        changed[bit / 8] ^= 1 << (bit % 8);
        line.ignores(&changed);
    }
    assert!(line.sender.receive(&answer, line.now).is_some());
    // Nor do greetings.
    let mut fresh = Line::new();
    let hello = fresh.said().unwrap();
    for bit in 0..8 * hello.len() {
        let mut changed = hello.clone();
        changed[bit / 8] ^= 1 << (bit % 8);
        fresh.refuses(&changed);
    }
    line.goes_on();
}

/// Two hosts greet the same controller: frames of one do nothing in the session of the other, whatever their session is
/// changed to.
#[test]
fn sessions_do_not_mix() {
    let mut line = Line::new();
    line.run(20);
    let (mut second, mut theirs) = (host(6, 9), Vec::new());
    core::mem::swap(&mut line.sender, &mut second);
    // The second host has an offer and has said something, but the first one's session is still open.
    while theirs.len() < 2 {
        line.now += 100_000;
        let frame = line.said().unwrap();
        if greets(&frame) {
            line.hear(&frame);
            let offer = line.answered().unwrap();
            assert!(line.sender.receive(&offer, line.now).is_some());
        }
        theirs.push(frame);
    }
    let offered = session(&theirs[1]);
    core::mem::swap(&mut line.sender, &mut second);
    line.now = 20_000;
    let open = line.receiver.session().unwrap();
    assert_ne!(open, offered);
    let moved = |frame: &[u8], to: u32| [&frame[..1], &to.to_le_bytes(), &frame[5..]].concat();
    line.refuses(&moved(&theirs[1], open));
    for frame in line.up.clone() {
        line.refuses(&moved(&frame, offered));
    }
    line.goes_on();
    // The frame was good in its own session.
    assert!(line.hear(&theirs[1]));
    assert_eq!(line.receiver.session(), Some(offered));
}

#[test]
fn a_wrong_key_does_nothing() {
    let mut line = Line::used();
    line.sender = Sender::new(6, Options::default()).with_key(OTHER, 9);
    let hello = line.said().unwrap();
    line.refuses(&hello);
    line.sender = Sender::new(6, Options::default());
    let hello = line.said().unwrap();
    line.refuses(&hello);
    // A host with a key does not listen to a controller without one.
    let mut unkeyed = Receiver::protected(Identity::default(), Unkeyed);
    line.sender = host(6, 9);
    assert_eq!(unkeyed.receive(&line.said().unwrap(), 5), None);
}

/// Returns a frame with this counter and the tag of `key`, by the words of `PROTOCOL.md` alone.
/// It is of epoch 0.
fn frame(session: u32, message: &ToDevice<'_>, counter: u32, key: &Key) -> Vec<u8> {
    let mut bytes = vec![0];
    bytes.extend(session.to_le_bytes());
    let mut buffer = [0; 128];
    // A frame without a key has the same beginning.
    let plain = foldpath_core::wire::frame::seal(session, message, &mut buffer).unwrap();
    bytes.extend(&plain[5..plain.len() - 4]);
    if session != 0 {
        bytes.push(0);
    }
    bytes.extend(counter.to_le_bytes());
    let tag = key.tag(&bytes);
    bytes.extend(tag.to_le_bytes());
    bytes
}

/// Returns the key of a direction in a session, by the words of `PROTOCOL.md` alone.
fn session_key(direction: u8, host: u64, device: u64, session: u32) -> Key {
    let half = |half: u8| {
        let mut bytes = vec![direction, half];
        bytes.extend(host.to_le_bytes());
        bytes.extend(device.to_le_bytes());
        bytes.extend(session.to_le_bytes());
        KEY.tag(&bytes).to_le_bytes()
    };
    Key::new([half(0), half(1)].concat().try_into().unwrap())
}

/// Somebody with the key uses the last counter up; after that nothing comes through, and no counter begins anew.
#[test]
fn counters_do_not_begin_anew() {
    let mut line = Line::used();
    let open = line.receiver.session().unwrap();
    let key = session_key(1, 9 << 32 | 5, NONCE, open);
    let alive = |counter| frame(open, &ToDevice::Alive, counter, &key);
    line.refuses(&alive(1));
    line.refuses(&alive(0));
    assert!(line.hear(&alive(u32::MAX - 1)));
    assert!(line.hear(&alive(u32::MAX)));
    for counter in [0, 1, 1000, u32::MAX - 1, u32::MAX] {
        line.refuses(&alive(counter));
    }
    line.now += 600_000;
    let frame = line.said().unwrap();
    line.refuses(&frame);
    // A new session goes on.
    line.sender = host(6, 9);
    line.run(600);
    assert_eq!(line.sender.acknowledged(), line.source.0);
}

/// All that is known but the key: session, counter, messages that move the sheet, and tags of earlier frames.
#[test]
fn a_million_forged_frames_do_nothing() {
    let mut line = Line::used();
    let open = line.receiver.session().unwrap();
    let mut rng = rng(600);
    let tags: Vec<[u8; 8]> = line
        .up
        .iter()
        .chain(&line.down)
        .map(|frame| *frame.last_chunk().unwrap())
        .collect();
    let before = format!("{:?}", line.receiver);
    let commands = [
        Command::Start,
        Command::Resume,
        Command::Stand,
        Command::Clear,
    ];
    for count in 0..FORGED {
        let number = u8::try_from(below(&mut rng, 256)).unwrap();
        let command = commands[usize::try_from(count % 4).unwrap()];
        let message = match count % 3 {
            0 => ToDevice::Command { number, command },
            1 => ToDevice::Alive,
            _ => ToDevice::Pair(&[7; Key::SIZE]),
        };
        let guess = Key::new(core::array::from_fn(|_| rng.next_u32().to_le_bytes()[0]));
        let session = [open, 0, open.wrapping_add(1)][usize::try_from(below(&mut rng, 3)).unwrap()];
        let counter = 1 + u32::try_from(below(&mut rng, 100)).unwrap();
        let mut forged = frame(session, &message, counter, &guess);
        if count % 5 == 0 {
            let known = tags[usize::try_from(below(&mut rng, tags.len() as u64)).unwrap()];
            *forged.last_chunk_mut().unwrap() = known;
        }
        assert_eq!(line.receiver.receive(&forged, 5), None, "{forged:02x?}");
    }
    assert_eq!(format!("{:?}", line.receiver), before);
    let report = line
        .down
        .iter()
        .rfind(|frame| !greets(frame))
        .unwrap()
        .clone();
    let before = format!("{:?}", line.sender);
    for _ in 0..FORGED / 10 {
        let mut forged = report.clone();
        let counter = (1000 + rng.next_u32() % 1000).to_le_bytes();
        let (_, end) = forged.split_last_chunk_mut::<12>().unwrap();
        end[..4].copy_from_slice(&counter);
        rng.fill_bytes(&mut end[4..]);
        assert_eq!(line.sender.receive(&forged, line.now), None);
    }
    assert_eq!(format!("{:?}", line.sender), before);
    line.goes_on();
}

/// An offer that somebody keeps back, or plays back, leads the host to no counter that it has used.
#[test]
fn offers_that_are_played_back_repeat_no_frame() {
    let mut line = Line::new();
    let patient = Options {
        silence: 60_000_000,
        ..Options::default()
    };
    line.sender = Sender::new(5, patient).with_key(KEY, 9);
    let hello = line.said().unwrap();
    line.hear(&hello);
    let first = line.answered().unwrap();
    // Another greeting drops the offer.
    let mut other = host(77, 9);
    let (mut scratch, mut buffer) = ([0; 64], [0; 128]);
    let theirs = other
        .poll(0, &line.source, &mut scratch, &mut buffer)
        .unwrap()
        .to_vec();
    line.hear(&theirs);
    line.answered().unwrap();
    let mut seen = Vec::<[u8; 8]>::new();
    let mut counters = Vec::new();
    for round in 0..20 {
        let offer = if round % 2 == 0 {
            first.clone()
        } else {
            line.hear(&hello);
            line.answered().unwrap()
        };
        let Some(ToHost::Welcome { .. }) = line.sender.receive(&offer, line.now) else {
            panic!("the offer is for this host");
        };
        // The host says something, hears nothing, and greets again.
        loop {
            line.now += 100_000;
            let Some(frame) = line.said() else { continue };
            if greets(&frame) {
                break;
            }
            let (rest, tag) = frame.split_last_chunk::<8>().unwrap();
            seen.push(*tag);
            counters.push(u32::from_le_bytes(*rest.last_chunk().unwrap()));
        }
    }
    assert!(counters.len() > 20);
    assert!(
        counters.is_sorted_by(|one, next| one < next),
        "{counters:?}"
    );
    seen.sort_unstable();
    assert!(seen.windows(2).all(|pair| pair[0] != pair[1]));
}

/// A frame with a key has the same message as one without a key, and differs at its end alone.
#[test]
fn a_key_changes_nothing_but_the_end_of_a_frame() {
    let path = crate::path::Path::miura();
    let items = path.items(FollowerPosition::default());
    let plain = Driver::new(items, Persistence::None, 5, Options::default());
    let keyed = plain.clone().with_key(KEY, 9);
    let hello = |mut driver: Driver<'_>| {
        let (mut scratch, mut buffer) = ([0; 256], [0; 256]);
        driver.poll(0, &mut scratch, &mut buffer).unwrap().to_vec()
    };
    let (plain, keyed) = (hello(plain), hello(keyed));
    assert_eq!(plain.len() + 8, keyed.len());
    assert_eq!(plain[..plain.len() - 4], keyed[..plain.len() - 4]);
}
