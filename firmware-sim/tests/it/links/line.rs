//! Attacks on a motion: nothing moves that the owner of the key has not asked for, and the motion goes on.

use foldpath_controller::Controller;
use foldpath_core::follower::{FollowerPosition, Reason, State};
use foldpath_core::wire::cobs::Deframer;
use foldpath_core::wire::key::Key;
use foldpath_core::wire::protection::{Keyed, Protection, Unkeyed};
use foldpath_core::wire::sender::{Failure, Phase};
use foldpath_firmware_sim::faults::Faults;

use super::{KEY, OTHER};
use crate::faults::{LINE, NOISY};
use crate::path::{Device, Path, below, settings};
use crate::world::{Host, World, rng};

fn with_key<'a>(mut host: Host<'a>, key: Key, nonce: u32) -> Host<'a> {
    host.driver = host.driver.with_key(key, nonce);
    host
}

fn device(nonce: u64) -> Device<Keyed> {
    Controller::keyed(settings(nonce), Some(KEY))
}

fn world<'a>(path: &'a Path, faults: Faults, seed: u64) -> World<'a, Keyed> {
    let host = with_key(Host::new(path, 1000), KEY, u32::try_from(seed).unwrap());
    World::of(path, faults, seed, host, device(seed))
}

/// Hands recorded bytes to a controller, a byte each microsecond.
fn play<P: Protection>(device: &mut Device<P>, bytes: &[u8], now: u64) {
    for byte in bytes {
        device.byte(*byte, now);
    }
}

#[test]
fn a_path_goes_over_a_noisy_line_with_a_key() {
    let path = Path::miura();
    let mut world = world(&path, LINE, 1000);
    world.finish(4);
    assert!(world.now < 2_400_000, "{}", world.now);
    assert_eq!(world.hosts[0].sender().repeated(), 0);
    assert!(world.hosts[0].telemetry > 90);
    for seed in 0..20 {
        self::world(&path, NOISY, seed).finish(30);
    }
}

/// A host without a key, or with another one, gets no answer from a controller with a key; and a host with a key gets none
/// from a controller without one. Nothing moves.
#[test]
fn nobody_answers_without_the_key() {
    fn stays<P: Protection>(path: &Path, host: Host<'_>, device: Device<P>) {
        let mut world = World::of(path, LINE, 0, host, device);
        world.run(6_000_000);
        assert_eq!(world.failure(0), Some(Failure::NoAnswer));
        assert_eq!(world.state(), State::Idle);
        assert_eq!(world.down.counts().pieces, 0);
    }
    let path = Path::miura();
    stays(&path, Host::new(&path, 5), device(1));
    stays(&path, with_key(Host::new(&path, 5), OTHER, 9), device(1));
    let unkeyed: Device = Device::protected(settings(1), Unkeyed);
    stays(&path, with_key(Host::new(&path, 5), KEY, 9), unkeyed);
}

/// Every frame of the host comes again, at any time up to a second later.
#[test]
fn frames_that_are_played_back_in_a_session_change_nothing() {
    let path = Path::miura();
    for seed in 0..20 {
        let mut world = world(&path, LINE, seed);
        let mut rng = rng(700 + seed);
        let mut recorded: Vec<Vec<u8>> = Vec::new();
        while !world.hosts[0].driver.is_done() {
            assert!(world.now < 4_000_000);
            world.tap = Some(Vec::new());
            world.run(10_000);
            recorded.extend(world.tap.take().unwrap());
            for _ in 0..20 {
                let frame = below(&mut rng, recorded.len().max(1) as u64);
                if let Some(frame) = recorded.get(usize::try_from(frame).unwrap()) {
                    play(&mut world.device, frame, world.now);
                }
            }
        }
        world.finish(1);
        assert!(world.now < 2_600_000, "{}", world.now);
        assert!(world.held.is_empty(), "{:?}", world.held);
    }
}

/// Frames that are played back are no sign of life: without its host the motion holds.
#[test]
fn frames_that_are_played_back_do_not_keep_a_motion_alive() {
    let path = Path::miura();
    let mut world = world(&path, LINE, 0);
    world.tap = Some(Vec::new());
    world.run(1_000_000);
    let recorded = world.tap.take().unwrap().concat();
    assert_eq!(
        (world.state(), world.reason()),
        (State::Running, Reason::None)
    );
    world.hosts[0].awake = false;
    for _ in 0..100 {
        play(&mut world.device, &recorded, world.now);
        world.run(10_000);
    }
    assert_eq!(
        (world.state(), world.reason()),
        (State::Holding, Reason::Silence)
    );
    let place = world.device.follower().position();
    for _ in 0..20 {
        play(&mut world.device, &recorded, world.now);
        world.run(10_000);
    }
    assert_eq!(world.device.follower().position(), place);
}

/// A whole fold that was recorded does nothing after power-on, nor in the same run: neither at once nor at its own pace.
#[test]
fn a_fold_that_is_played_back_moves_nothing() {
    let path = Path::miura();
    let mut first = world(&path, LINE, 0);
    first.tap = Some(Vec::new());
    first.finish(4);
    let recorded = first.tap.take().unwrap();
    assert!(recorded.len() > 100);
    let end = FollowerPosition {
        knot: 100,
        into: 0.0,
    };
    for frame in &recorded {
        play(&mut first.device, frame, first.now);
        first.hosts[0].awake = false;
        first.run(20_000);
        assert_eq!(first.device.follower().position(), end);
        assert_eq!(first.state(), State::Done);
    }
    for pause in [0, 20_000] {
        let mut again = world(&path, LINE, 1);
        again.hosts[0].awake = false;
        for frame in &recorded {
            play(&mut again.device, frame, again.now);
            again.run(pause);
            assert_eq!(again.state(), State::Idle);
        }
        again.run(1_000_000);
        assert_eq!(again.state(), State::Idle);
        assert_eq!(
            again.device.follower().position(),
            FollowerPosition::default()
        );
        // This controller still follows a host with the key.
        again.hosts[0] = with_key(Host::new(&path, 5), KEY, 9);
        again.finish(4);
    }
}

/// Greetings of others, which somebody has recorded, delay the beginning of a session and nothing else.
#[test]
fn greetings_that_are_played_back_do_not_end_a_session() {
    let path = Path::miura();
    let mut before = world(&path, LINE, 0);
    before.tap = Some(Vec::new());
    before.run(100_000);
    let hello = before.tap.take().unwrap().swap_remove(0);
    for seed in 1..20 {
        let mut world = world(&path, LINE, seed);
        // The device was switched on meanwhile.
        world.device = crate::path::flat(device(77 + seed));
        let mut rng = rng(800 + seed);
        for _ in 0..30 {
            play(&mut world.device, &hello, world.now);
            world.run(below(&mut rng, 40_000));
        }
        world.finish(10);
        assert_eq!(world.hosts[0].sender().phase(), Phase::Open);
        assert!(!world.held.contains(&Reason::Session));
    }
}

/// Returns the kind of the message of a frame as it goes on the line: 0 for a greeting, 1 for an item, 2 for a command, 3 for a
/// sign of life.
fn kind(bytes: &[u8]) -> u8 {
    let mut deframer = Deframer::<256>::default();
    let bytes = bytes.iter();
    bytes.fold(u8::MAX, |kind, byte| {
        deframer.push(*byte).map_or(kind, |frame| frame[5])
    })
}

/// Whatever kinds of frames somebody takes away once the operator has asked to stop, the motion holds: with a key, and
/// without one.
#[test]
fn a_stop_gets_through_or_the_line_is_silent() {
    fn holds<P: Protection>(mut world: World<'_, P>, steals: fn(&[u8]) -> bool) -> Reason {
        world.run(700_000);
        let ends = (world.state(), world.reason());
        assert_eq!(ends, (State::Running, Reason::None));
        world.steals = steals;
        world.hosts[0].driver.stop();
        world.run(1_300_000);
        let place = world.device.follower().position();
        world.run(10_000_000);
        assert_eq!(world.device.follower().position(), place);
        assert_eq!(world.state(), State::Holding);
        assert!(place.knot < 90, "{place:?}");
        world.reason()
    }
    let path = Path::miura();
    for (steals, reason) in [
        ((|_| false) as fn(&[u8]) -> bool, Reason::HoldCommand),
        (|frame| kind(frame) == 1, Reason::HoldCommand),
        (|frame| kind(frame) == 2, Reason::Silence),
        (|frame| kind(frame) == 3, Reason::HoldCommand),
        (|frame| kind(frame) != 2, Reason::HoldCommand),
        (|_| true, Reason::Silence),
    ] {
        assert_eq!(holds(world(&path, LINE, 3), steals), reason);
        assert_eq!(holds(World::new(&path, LINE, 3), steals), reason);
    }
}

/// A motion that held by itself is on its way to go on when the operator asks to stop, and nothing that the controller
/// says comes through any more.
#[test]
fn a_stop_does_not_wait_for_the_answer_to_a_command() {
    let path = Path::miura();
    let mut world = world(&path, LINE, 4);
    world.run(700_000);
    world.hosts[0].awake = false;
    world.run(1_000_000);
    assert_eq!(world.reason(), Reason::Silence);
    world.hosts[0].awake = true;
    world.tap = Some(Vec::new());
    world.steals = |frame| kind(frame) == 2;
    world.run(50_000);
    // `Resume` is on its way, and gets there; no answer does.
    assert!(
        world
            .tap
            .take()
            .unwrap()
            .iter()
            .any(|frame| kind(frame) == 2)
    );
    assert_eq!(world.reason(), Reason::Silence);
    world.hosts[0].driver.stop();
    world.steals = |_| false;
    let mut place = world.device.follower().position();
    for _ in 0..20 {
        // The host hears nothing.
        while world.down.read(world.now + 1_000_000).is_some() {}
        world.run(100_000);
        place = world.device.follower().position();
    }
    assert_eq!(world.state(), State::Holding);
    world.run(1_000_000);
    assert_eq!(world.device.follower().position(), place);
}

/// Time of an epoch, microseconds.
const EPOCH: u64 = 1 << 21;

/// Frames that somebody keeps back while the host hears all that the controller says, to deliver them later: one by one,
/// so that they would be signs of life for long. Even when the bits of the epoch have come again they do nothing.
#[test]
fn frames_that_are_kept_back_move_nothing() {
    let path = Path::miura();
    for later in [
        3 * EPOCH,
        60_000_000,
        127 * EPOCH,
        128 * EPOCH,
        255 * EPOCH,
        256 * EPOCH,
        257 * EPOCH,
        512 * EPOCH,
        3_600_000_000,
    ] {
        let mut world = world(&path, LINE, 5);
        world.run(700_000);
        assert_eq!(world.state(), State::Running);
        world.tap = Some(Vec::new());
        world.steals = |_| true;
        world.run(2_500_000);
        assert_eq!(
            (world.state(), world.reason()),
            (State::Holding, Reason::Silence)
        );
        // The host asked to go on and hears no answer.
        world.hosts[0].driver.stop();
        world.run(1_000_000);
        world.hosts[0].awake = false;
        let kept = world.tap.take().unwrap();
        assert!(kept.iter().any(|frame| kind(frame) == 2) && kept.len() > 20);
        let place = world.device.follower().position();
        // The clock goes on as it does on a board: no round is missed.
        let end = world.now + later - 3_500_000;
        while world.now < end {
            world.now = (world.now + 100_000).min(end);
            world.device.tick(world.now);
            world.device.poll(world.now);
            while world.device.take().is_some() {}
        }
        for frames in kept.chunks(3) {
            frames
                .iter()
                .for_each(|frame| play(&mut world.device, frame, world.now));
            world.run(100_000);
            assert_eq!(world.state(), State::Holding);
        }
        assert_eq!(world.device.follower().position(), place, "{later}");
    }
}

/// A frame moves something for two epochs at most.
#[test]
fn frames_are_late_by_two_epochs_at_most() {
    let path = Path::miura();
    for (later, moves) in [(100_000, true), (EPOCH - 1000, true), (2 * EPOCH, false)] {
        let mut world = world(&path, LINE, 6);
        world.run(700_000);
        world.steals = |_| true;
        world.run(600_000);
        assert_eq!(world.reason(), Reason::Silence);
        world.run(500_000);
        world.tap = Some(Vec::new());
        world.run(250_000);
        let kept = world.tap.take().unwrap();
        world.hosts[0].awake = false;
        assert!(kept.iter().any(|frame| kind(frame) == 2));
        world.run(later);
        kept.iter()
            .for_each(|frame| play(&mut world.device, frame, world.now));
        // The command to go on was taken.
        assert_eq!(world.state() == State::Running, moves, "{later}");
    }
}

/// An offer that was kept back does not end the session of another host.
#[test]
fn an_offer_that_is_kept_back_begins_no_session() {
    let path = Path::miura();
    for (later, ends) in [(10_000, true), (3 * EPOCH, false), (256 * EPOCH, false)] {
        let mut world = world(&path, LINE, 7);
        world.finish(4);
        // The second host hears its offer, and what it says then is kept.
        world.hosts.push(with_key(Host::new(&path, 5), KEY, 9));
        world.hosts[0].awake = false;
        world.tap = Some(Vec::new());
        world.steals = |frame| kind(frame) != 0;
        world.run(200_000);
        assert_eq!(world.hosts[1].sender().phase(), Phase::Offered);
        let kept = world.tap.take().unwrap();
        world.hosts.truncate(1);
        world.hosts[0].awake = true;
        world.steals = |_| false;
        world.run(later);
        let mine = |world: &World<'_, Keyed>| world.hosts[0].sender().phase() == Phase::Open;
        assert!(mine(&world));
        kept.iter()
            .filter(|frame| kind(frame) != 0)
            .for_each(|frame| play(&mut world.device, frame, world.now));
        world.run(6_000_000);
        assert_eq!(mine(&world), !ends, "{later}");
    }
}

/// A host notices that nothing of what it says comes through, although it hears the controller.
#[test]
fn a_host_that_is_not_heard_gives_up() {
    let path = Path::miura();
    let mut world = world(&path, LINE, 8);
    world.run(700_000);
    world.steals = |_| true;
    let telemetry = world.hosts[0].telemetry;
    world.run(4_900_000);
    assert_eq!(world.hosts[0].sender().phase(), Phase::Open);
    world.run(400_000);
    assert_eq!(world.failure(0), Some(Failure::Silent));
    assert!(world.hosts[0].telemetry > telemetry + 100);
}

/// A session of more than 256 epochs goes on, and so does one whose line was silent for some.
#[test]
fn a_long_session_goes_on() {
    let path = Path::miura();
    let mut world = world(&path, LINE, 9);
    world.run(700_000);
    for silence in [1, 3_000_000, 4_500_000] {
        world.steals = |_| true;
        world.run(silence);
        world.steals = |_| false;
        world.run(500_000);
        assert_eq!(world.hosts[0].sender().phase(), Phase::Open);
    }
    world.finish(10);
    world.run(300 * EPOCH);
    assert_eq!(world.hosts[0].sender().phase(), Phase::Open);
    assert_eq!(world.state(), State::Done);
}

/// Returns the greeting of a host, as somebody has recorded it, and a world whose controller was switched on later.
fn recorded(path: &Path, faults: Faults, seed: u64) -> (Vec<u8>, World<'_, Keyed>) {
    let mut before = world(path, faults, 0);
    before.tap = Some(Vec::new());
    before.run(100_000);
    let hello = before.tap.take().unwrap().swap_remove(0);
    let mut world = world(path, faults, seed);
    world.device = crate::path::flat(device(77 + seed));
    (hello, world)
}

/// Recorded greetings come faster than the line can carry the answers.
#[test]
fn a_flood_of_greetings_does_not_end_a_session() {
    let path = Path::miura();
    for (speed, pause) in [(11_520.0, 3000), (1e5, 500), (1e5, 250)] {
        let faults = Faults { speed, ..LINE };
        let (hello, mut world) = recorded(&path, faults, 1);
        world.run(300_000);
        assert_eq!(world.hosts[0].sender().phase(), Phase::Open);
        let telemetry = world.hosts[0].telemetry;
        while !world.hosts[0].driver.is_done() {
            assert!(world.now < 8_000_000, "{:?}", world.hosts[0].sender());
            play(&mut world.device, &hello, world.now);
            world.run(pause);
        }
        assert!(world.held.is_empty(), "{:?}", world.held);
        let telemetry = world.hosts[0].telemetry - telemetry;
        assert!(telemetry > 20, "{telemetry}");
    }
}

/// Recorded greetings can keep a session from beginning. The host gives up then.
#[test]
fn a_session_that_does_not_begin_is_given_up() {
    let path = Path::miura();
    let faults = Faults {
        delay: 25_000,
        ..LINE
    };
    for pause in [10_000, 20_000, 40_000] {
        let (hello, mut world) = recorded(&path, faults, 2);
        while world.now < 5_300_000 {
            play(&mut world.device, &hello, world.now);
            world.run(pause);
        }
        let phase = world.hosts[0].sender().phase();
        let over = matches!(phase, Phase::Open | Phase::Failed(Failure::NoAnswer));
        assert!(over, "{pause}: {phase:?}");
    }
}
