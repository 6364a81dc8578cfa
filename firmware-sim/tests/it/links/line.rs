//! Attacks on a motion: nothing moves that the owner of the key has not asked for, and the motion goes on.

use foldpath_controller::Controller;
use foldpath_core::follower::{FollowerPosition, Reason, State};
use foldpath_core::wire::key::Key;
use foldpath_core::wire::protection::{Keyed, Protection};
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
        assert_eq!(world.failure(0), Some(Failure::Silent));
        assert_eq!(world.state(), State::Idle);
        assert_eq!(world.down.counts().pieces, 0);
    }
    let path = Path::miura();
    stays(&path, Host::new(&path, 5), device(1));
    stays(&path, with_key(Host::new(&path, 5), OTHER, 9), device(1));
    let unkeyed: Device = Device::new(settings(1));
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
