//! What goes wrong on the line and beside it, a hundred seeds each. The world checks at every tick that nothing is
//! commanded that was not sent, nothing beyond the limits, and nothing that tears the sheet.

mod common;

use common::{Path, World, below, rng};
use foldpath_core::follower::{Reason, State};
use foldpath_core::wire::cobs;
use foldpath_core::wire::frame;
use foldpath_core::wire::message::{SCHEMA, ToDevice, ToHost, VERSION};
use foldpath_core::wire::sender::{Failure, Phase};
use foldpath_firmware_sim::controller::Settings;
use foldpath_firmware_sim::faults::Faults;
use rand_core::Rng;

const SEEDS: u64 = 100;

/// A serial line of 1 Mbaud behind an adapter.
const LINE: Faults = Faults {
    drop: 0.0,
    flip: 0.0,
    double: 0.0,
    reorder: 0.0,
    delay: 1000,
    late: 5000,
    speed: 1e5,
    capacity: usize::MAX,
};
const NOISY: Faults = Faults {
    drop: 0.1,
    flip: 0.1,
    double: 0.1,
    reorder: 0.1,
    ..LINE
};

#[test]
fn a_clean_line_takes_the_time_of_the_path() {
    let path = Path::miura();
    let mut world = World::new(&path, LINE, 0);
    world.finish(4);
    // The path's two seconds and a quarter for speeding up and slowing down.
    assert!(world.now < 2_400_000, "{}", world.now);
    assert_eq!(world.hosts[0].sender().repeated(), 0);
    assert!(world.hosts[0].telemetry > 90);
    println!("closure {:e}", world.max_closure);
}

#[test]
fn noise_changes_nothing_but_the_time() {
    let path = Path::miura();
    let (mut slowest, mut repeated, mut closure) = (0, 0, 0.0_f64);
    for seed in 0..SEEDS {
        let mut world = World::new(&path, NOISY, seed);
        world.finish(30);
        slowest = slowest.max(world.now);
        repeated += world.hosts[0].sender().repeated();
        closure = closure.max(world.max_closure);
        assert!(world.up.counts().dropped > 0 && world.up.counts().flipped > 0);
    }
    println!("slowest {slowest} us, repeated {repeated}, closure {closure:e}");
}

/// Runs to a moment between 0.1 s and 2.2 s, most of which are in the midst of the motion.
fn some_time_later<'a>(path: &'a Path, faults: Faults, seed: u64) -> World<'a> {
    let mut world = World::new(path, faults, seed);
    let moment = 100_000 + below(&mut rng(900 + seed), 2_100_000);
    world.run(moment);
    world
}

#[test]
fn a_host_that_is_silent_for_two_seconds_finds_the_sheet_holding_and_goes_on() {
    let path = Path::miura();
    for seed in 0..SEEDS {
        let mut world = some_time_later(&path, NOISY, seed);
        let moved = world.state() == State::Running;
        world.hosts[0].awake = false;
        world.run(2_000_000);
        if moved && world.state() != State::Done {
            assert_eq!(world.state(), State::Holding);
            assert_eq!(world.device.follower().rate().to_bits(), 0);
            assert!(matches!(world.reason(), Reason::Silence | Reason::Underrun));
        }
        let held = world.reason() == Reason::Silence;
        world.hosts[0].awake = true;
        world.finish(30);
        assert!(!held || world.hosts[0].reasons.contains(&Reason::Silence));
    }
}

#[test]
fn a_host_that_never_comes_back_leaves_the_sheet_at_rest() {
    let path = Path::miura();
    for seed in 0..SEEDS {
        let mut world = some_time_later(&path, NOISY, seed);
        world.hosts[0].awake = false;
        world.run(600_000);
        let place = world.device.follower().place();
        assert_eq!(world.device.follower().rate().to_bits(), 0);
        world.run(3_000_000);
        assert_eq!(world.device.follower().place(), place);
        assert!(matches!(
            world.state(),
            State::Idle | State::Ready | State::Holding | State::Done
        ));
    }
}

#[test]
fn the_stop_line_stops_at_any_moment_and_the_host_is_told() {
    let path = Path::miura();
    for seed in 0..SEEDS {
        let mut world = some_time_later(&path, NOISY, seed);
        let before = world.state();
        let angles = world.device.follower().angles().to_vec();
        world.device.stop(true);
        world.run(300_000);
        assert_eq!(world.device.follower().angles(), angles);
        assert_eq!(world.reason(), Reason::StopLine);
        if matches!(before, State::Running | State::Holding) {
            assert_eq!(world.state(), State::Holding);
        }
        world.device.stop(false);
        world.finish(30);
        assert!(world.hosts[0].reasons.contains(&Reason::StopLine));
    }
}

#[test]
fn a_new_host_takes_over_from_where_the_sheet_holds_and_the_old_one_is_told() {
    let path = Path::miura();
    let mut taken = 0;
    for seed in 0..SEEDS {
        let mut world = some_time_later(&path, NOISY, seed);
        if world.state() != State::Running {
            continue;
        }
        taken += 1;
        world.hosts.push(common::Host::new(&path, 77_777));
        world.finish(30);
        assert_eq!(world.failure(0), Some(Failure::Lost));
        assert!(world.hosts[1].reasons.contains(&Reason::Session));
    }
    assert!(taken > SEEDS / 2);
}

#[test]
fn frames_of_a_session_that_is_over_do_nothing() {
    let path = Path::miura();
    for seed in 0..SEEDS {
        let mut world = World::new(&path, LINE, seed);
        // All that the first host says in half a second is kept, and comes again much later.
        let mut kept = Vec::new();
        while world.now < 500_000 {
            if let Some(bytes) = world.hosts[0].poll(world.now) {
                world.up.write(&bytes, world.now);
                kept.extend(bytes);
            }
            world.step();
        }
        world.hosts[0].awake = false;
        world.hosts.push(common::Host::new(&path, 77_777));
        world.run(500_000 + below(&mut rng(seed), 500_000));
        let session = world.hosts[1].sender().clone();
        for chunk in kept.chunks(500) {
            for byte in chunk {
                world.device.byte(*byte, world.now);
            }
            world.run(1000);
        }
        assert_eq!(world.hosts[1].sender().phase(), session.phase());
        world.finish(10);
    }
}

#[test]
fn a_host_of_another_version_is_told_and_moves_nothing() {
    let path = Path::miura();
    for (version, schema) in [(VERSION + 1, SCHEMA), (VERSION, SCHEMA ^ 1), (0, 0)] {
        let mut world = World::new(&path, LINE, 0);
        world.hosts.clear();
        let mut buffer = [0; 64];
        let id = 5;
        let hello = ToDevice::Hello {
            version,
            schema,
            id,
        };
        let frame = frame::seal(0, &hello, &mut buffer).unwrap();
        cobs::encode(frame, |byte| world.device.byte(byte, 0));
        let mut answers = Vec::new();
        let mut deframer = cobs::Deframer::<64>::default();
        world.device.poll(0);
        while let Some(byte) = world.device.take() {
            if let Some(frame) = deframer.push(byte) {
                let (session, answer) = frame::open(frame).unwrap();
                assert_eq!(session, 0);
                assert!(matches!(answer, ToHost::Mismatch { .. }));
                answers.push((frame.to_vec(), answer == mismatch(id)));
            }
        }
        assert_eq!(answers.len(), 1);
        assert!(answers[0].1);
        assert_eq!(world.state(), State::Idle);

        // A host of ours that hears such an answer gives up and says why.
        let mut host = common::Host::new(&path, 5);
        let other = ToHost::Mismatch {
            id,
            version,
            schema,
        };
        let frame = frame::seal(0, &other, &mut buffer).unwrap();
        cobs::encode(frame, |byte| host.byte(byte, 0));
        let failure = Failure::Version { version, schema };
        assert_eq!(host.sender().phase(), Phase::Failed(failure));
        assert_eq!(host.poll(1_000_000), None);
    }
}

fn mismatch(id: u32) -> ToHost<'static> {
    let (version, schema) = (VERSION, SCHEMA);
    ToHost::Mismatch {
        id,
        version,
        schema,
    }
}

#[test]
fn random_bytes_do_nothing() {
    let path = Path::miura();
    for seed in 0..SEEDS {
        let mut rng = rng(300 + seed);
        let mut bytes = [0; 1000];
        let mut idle = World::new(&path, LINE, seed);
        idle.hosts[0].awake = false;
        let mut busy = World::new(&path, LINE, seed);
        for _ in 0..100 {
            rng.fill_bytes(&mut bytes);
            for byte in bytes {
                idle.device.byte(byte, idle.now);
                busy.device.byte(byte, busy.now);
            }
            idle.run(1000);
            busy.run(10_000);
        }
        assert_eq!(idle.state(), State::Idle);
        assert!(idle.device.take().is_none());
        busy.finish(30);
    }
}

/// The host does not read: the device's buffer fills, telemetry gives way, nothing waits.
#[test]
fn a_host_that_does_not_read_blocks_nothing() {
    let path = Path::miura();
    for seed in 0..SEEDS {
        let mut world = some_time_later(&path, NOISY, seed);
        world.drains = false;
        world.run(3_000_000);
        assert_eq!(world.device.follower().rate().to_bits(), 0);
        world.drains = true;
        world.finish(30);
    }
}

#[test]
fn stalls_and_overruns_cost_time_alone() {
    let path = Path::miura();
    for seed in 0..SEEDS {
        let narrow = Faults {
            capacity: 130,
            ..NOISY
        };
        let mut world = some_time_later(&path, narrow, seed);
        let mut rng = rng(500 + seed);
        for _ in 0..3 {
            let until = world.now + below(&mut rng, 400_000);
            if below(&mut rng, 2) == 0 {
                world.up.stall(until);
            } else {
                world.down.stall(until);
            }
            world.run(500_000);
        }
        world.finish(30);
    }
}

#[test]
fn after_a_reset_the_fold_goes_on_from_the_last_place_executed() {
    let path = Path::miura();
    for seed in 0..SEEDS {
        let mut world = some_time_later(&path, NOISY, seed);
        let place = world.device.follower().place();
        let angles = world.device.follower().angles().to_vec();
        let boot = 1;
        world.device = common::Device::new(Settings {
            boot,
            ..Settings::default()
        });
        if angles.is_empty() {
            continue;
        }
        world.device.follower_mut().stand(&angles, place).unwrap();
        world.run(300_000);
        assert_eq!(world.failure(0), Some(Failure::Lost));
        assert_eq!(world.device.follower().angles(), angles);
        world.hosts.push(common::Host::new(&path, 99_999));
        world.finish(30);
    }
}

#[test]
fn a_stalled_hinge_ends_in_a_fault_that_names_it() {
    let path = Path::miura();
    for seed in 0..SEEDS {
        let mut world = World::new(&path, NOISY, seed);
        let mut rng = rng(700 + seed);
        let hinge = u32::try_from(below(&mut rng, 50)).unwrap();
        let moment = 500_000 + below(&mut rng, 1_000_000);
        let mut stuck = None;
        for _ in 0..40_000 {
            world.step();
            let members: Vec<_> = world.device.sheet().hinges().collect();
            if let Some(&member) = members.get(hinge as usize) {
                let command = world.device.follower().hinge(member);
                let Some(command) = command else { continue };
                let at = *stuck.get_or_insert(command);
                if world.now < moment {
                    stuck = None;
                }
                world.device.follower_mut().measure(hinge, member, at);
            }
            if world.state() == State::Faulted {
                break;
            }
        }
        assert_eq!(world.state(), State::Faulted);
        assert_eq!(world.reason(), Reason::Stalled(hinge));
        world.run(500_000);
        assert!(world.hosts[0].reasons.contains(&Reason::Stalled(hinge)));
        // The host leaves the fault behind.
        assert_eq!(world.state(), State::Idle);
    }
}
