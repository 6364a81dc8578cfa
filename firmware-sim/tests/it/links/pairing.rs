//! Setting a key over the line of a controller: only once, at rest, and only if the board allows it.

use foldpath_controller::stored;
use foldpath_core::follower::State;
use foldpath_core::wire::driver::{Driver, Persistence};
use foldpath_core::wire::frame;
use foldpath_core::wire::key::{Key, StoredKey};
use foldpath_core::wire::message::{ToDevice, ToHost};
use foldpath_core::wire::protection::{Keyed, Protection, Unkeyed};
use foldpath_core::wire::receiver::{Identity, Receiver};
use foldpath_core::wire::sender::{Failure, Phase};
use foldpath_core::wire::{cobs, message};

use super::{KEY, OTHER};
use crate::machine::{Machine, Path};

/// Opens a session without a key and sends this key in it. Returns `true` if the controller answered the greeting.
fn pair<P: Protection>(machine: &mut Machine<2, P>, id: u32, key: &[u8]) -> bool {
    let mut buffer = [0; 64];
    let mut say = |machine: &Machine<2, P>, session, message: &ToDevice<'_>| {
        let frame = frame::seal(session, message, &mut buffer).unwrap();
        machine.bench(|bench| cobs::encode(frame, |byte| bench.received.push_back(byte)));
    };
    let hello = ToDevice::Hello {
        version: message::VERSION,
        schema: message::SCHEMA,
        id,
    };
    say(machine, 0, &hello);
    let mut deframer = cobs::Deframer::<256>::default();
    let mut offered = None;
    for byte in answers(machine) {
        let answer = deframer.push(byte).and_then(frame::open::<ToHost<'_>>);
        if let Some((0, ToHost::Welcome { session, .. })) = answer {
            offered = Some(session);
        }
    }
    let Some(session) = offered else {
        return false;
    };
    say(machine, session, &ToDevice::Pair(key));
    machine.bench(|bench| bench.sent.clear());
    // The key is stored before any answer leaves.
    machine.controller.step();
    true
}

/// Returns the bytes that a controller sends in a round.
fn answers<P: Protection>(machine: &mut Machine<2, P>) -> Vec<u8> {
    machine.bench(|bench| bench.sent.clear());
    machine.controller.step();
    machine.bench(|bench| core::mem::take(&mut bench.sent))
}

/// Returns a host that takes an operator's word that the sheet is flat.
fn host(path: &Path, id: u32, key: Option<Key>) -> Driver<'_> {
    let driver = path.driver(Persistence::None, id).confirming();
    match key {
        Some(key) => driver.with_key(key, 9),
        None => driver,
    }
}

fn follows<const G: usize, P: Protection>(
    machine: &mut Machine<G, P>,
    mut host: Driver<'_>,
) -> bool {
    machine.run(Some(&mut host), 6000);
    host.is_done()
}

#[test]
fn a_controller_without_a_key_takes_one_and_keeps_it() {
    let path = Path::new(2);
    let mut machine = Machine::<2, Keyed>::with_line(1, true);
    assert!(follows(&mut machine, host(&path, 7, None)));
    assert!(pair(&mut machine, 8, KEY.bytes()));
    assert_eq!(machine.bench(|bench| bench.key()), StoredKey::Key(KEY));
    for (nonce, flat) in [(1, false), (1, true), (2, true)] {
        // From now on it takes frames with this key alone, behind a reset and a loss of power as well.
        if flat {
            machine.cut_power(nonce);
            machine.bench(|bench| bench.stands.fill(0.0));
        }
        assert!(!pair(&mut machine, 10, OTHER.bytes()));
        let mut wrong = host(&path, 11, Some(OTHER));
        machine.run(Some(&mut wrong), 6000);
        assert_eq!(wrong.sender().phase(), Phase::Failed(Failure::NoAnswer));
        let mut none = host(&path, 12, None);
        machine.run(Some(&mut none), 6000);
        assert_eq!(none.sender().phase(), Phase::Failed(Failure::NoAnswer));
        assert_eq!(machine.bench(|bench| bench.key()), StoredKey::Key(KEY));
        if flat {
            assert!(follows(&mut machine, host(&path, 13, Some(KEY))));
        }
    }
}

#[test]
fn a_board_that_does_not_allow_it_takes_no_key() {
    let path = Path::new(2);
    let mut machine = Machine::<2, Keyed>::with_line(1, false);
    assert!(pair(&mut machine, 8, KEY.bytes()));
    assert_eq!(machine.bench(|bench| bench.key()), StoredKey::None);
    assert!(follows(&mut machine, host(&path, 9, None)));
    // Nor does a controller that has no room for a key.
    let mut machine = Machine::<2, Unkeyed>::with_line(1, true);
    assert!(pair(&mut machine, 8, KEY.bytes()));
    assert_eq!(machine.bench(|bench| bench.key()), StoredKey::None);
    assert!(follows(&mut machine, host(&path, 9, None)));
}

#[test]
fn a_sheet_that_moves_gets_no_key() {
    let path = Path::new(2);
    let mut machine = Machine::<2, Keyed>::with_line(1, true);
    let mut first = host(&path, 7, None);
    machine.run(Some(&mut first), 1000);
    assert_eq!(machine.condition().state, State::Running);
    // The session of the pairing host holds the motion, which has not come to rest when the key comes.
    assert!(pair(&mut machine, 8, KEY.bytes()));
    assert_eq!(machine.bench(|bench| bench.key()), StoredKey::None);
    machine.run(None, 1000);
    assert_eq!(machine.condition().state, State::Holding);
    assert!(pair(&mut machine, 9, KEY.bytes()));
    assert_eq!(machine.bench(|bench| bench.key()), StoredKey::Key(KEY));
}

/// The longest frames have room for counter and tag: those of a path of 94 groups.
#[test]
fn a_path_of_94_groups_goes_over_a_link_with_a_key() {
    let path = Path::new(94);
    let mut machine = Machine::<94, Keyed>::with_line(1, false);
    machine.bench(|bench| bench.flash = stored::words(&KEY));
    machine.reset();
    assert!(follows(&mut machine, host(&path, 7, Some(KEY))));
    let longest = machine.recorded.iter().map(|(_, bytes)| bytes.len()).max();
    // A piece of a setpoint has 208 bytes of numbers.
    assert!((225..=258).contains(&longest.unwrap()), "{longest:?}");
}

/// Not even the owner of the key replaces it over the line.
#[test]
fn a_controller_with_a_key_takes_no_other_one() {
    let identity = Identity::default();
    for key in [StoredKey::Key(KEY), StoredKey::Damaged] {
        let mut receiver = Receiver::protected(identity, Keyed::with_key(key));
        let before = format!("{receiver:?}");
        receiver.propose(OTHER);
        assert!(receiver.proposed().is_none() && !receiver.pair(OTHER));
        assert_eq!(format!("{receiver:?}"), before);
    }
    let mut receiver = Receiver::protected(identity, Keyed::new(None));
    receiver.propose(OTHER);
    assert_eq!(
        (receiver.proposed(), receiver.proposed()),
        (Some(OTHER), None)
    );
    assert!(receiver.pair(OTHER) && !receiver.pair(KEY));
}

/// The power goes, or the flash fails, between any two words of a key: then there is no key, and the controller does not
/// answer as if there were one.
#[test]
fn a_key_is_stored_as_a_whole_or_not_at_all() {
    let path = Path::new(2);
    for written in 0..=stored::WORDS {
        let mut machine = Machine::<2, Keyed>::with_line(1, true);
        machine.bench(|bench| bench.writes = Some(written));
        assert!(pair(&mut machine, 8, KEY.bytes()));
        let whole = written == stored::WORDS;
        let expected = Some(KEY).filter(|_| whole);
        assert_eq!(machine.bench(|bench| bench.key()), expected.into());
        for power in [true, false] {
            let keyed = path
                .driver(Persistence::None, 20 + u32::from(power))
                .with_key(KEY, 9);
            let mut keyed = Some(keyed);
            machine.run(keyed.as_mut(), 1000);
            let phase = keyed.map(|host| host.sender().phase());
            assert_eq!(phase == Some(Phase::Open), whole, "{written}");
            let mut plain = path.driver(Persistence::None, 30 + u32::from(power));
            machine.run(Some(&mut plain), 1000);
            assert_eq!(plain.sender().phase() == Phase::Open, !whole, "{written}");
            machine.cut_power(2);
        }
        // Another attempt begins with erased memory.
        machine.bench(|bench| (bench.flash, bench.writes) = ([0; stored::WORDS], None));
        machine.reset();
        assert!(pair(&mut machine, 9, KEY.bytes()));
        assert_eq!(machine.bench(|bench| bench.key()), StoredKey::Key(KEY));
    }
}

/// Each bit of a stored key that changes is noticed, and the controller takes nothing from anybody.
#[test]
fn a_damaged_key_opens_nothing() {
    let words = stored::words(&KEY);
    assert_eq!(stored::open(&words, 0), StoredKey::Key(KEY));
    assert_eq!(stored::open(&words, u32::MAX), StoredKey::Key(KEY));
    for bit in 0..32 * stored::WORDS {
        let mut damaged = words;
        damaged[bit / 32] ^= 1 << (bit % 32);
        assert_eq!(stored::open(&damaged, 0), StoredKey::Damaged, "bit {bit}");
    }
    let path = Path::new(2);
    let mut machine = Machine::<2, Keyed>::with_line(1, true);
    machine.bench(|bench| bench.flash = [1; stored::WORDS]);
    machine.reset();
    assert!(!pair(&mut machine, 8, OTHER.bytes()));
    for key in [None, Some(KEY), Some(OTHER)] {
        let mut host = host(&path, 9, key);
        machine.run(Some(&mut host), 1000);
        assert_eq!(host.sender().phase(), Phase::Greeting);
    }
}

#[test]
fn a_key_of_another_length_is_none() {
    let mut machine = Machine::<2, Keyed>::with_line(1, true);
    for length in [0, 1, 15, 17, 32] {
        // Greetings are not answered at once one after the other.
        machine.run(None, 60);
        assert!(pair(
            &mut machine,
            8 + u32::try_from(length).unwrap(),
            &[7; 32][..length]
        ));
        assert_eq!(machine.bench(|bench| bench.key()), StoredKey::None);
    }
}

/// Boards that count their starts below the numbers of their chips, whether warm resets count or not, never have a number
/// twice.
#[test]
fn no_two_runs_of_any_chip_have_the_same_nonce() {
    let mut seen = Vec::new();
    for chip in 1..4_u64 {
        for count in 1..4 {
            let mut machine = Machine::<2, Keyed>::with_line(chip << 32 | count, true);
            for _ in 0..4 {
                // Records are written in ticks.
                machine.run(None, 5);
                let mut buffer = [0; 64];
                let hello = ToDevice::Hello {
                    version: message::VERSION,
                    schema: message::SCHEMA,
                    id: 8,
                };
                let frame = frame::seal(0, &hello, &mut buffer).unwrap();
                machine.bench(|bench| cobs::encode(frame, |byte| bench.received.push_back(byte)));
                let mut deframer = cobs::Deframer::<256>::default();
                let answers = answers(&mut machine);
                let nonce = answers.iter().find_map(|byte| {
                    let frame = deframer.push(*byte)?;
                    match frame::open(frame) {
                        Some((0, ToHost::Welcome { nonce, .. })) => Some(nonce),
                        _ => None,
                    }
                });
                seen.push(nonce.unwrap());
                machine.reset();
            }
        }
    }
    let count = seen.len();
    seen.sort_unstable();
    seen.dedup();
    assert_eq!((count, seen.len()), (36, 36));
}
