//! Does the sheet stay whole whatever goes wrong on the line and beside it? Every fault is tried with a hundred seeds.
//! At every tick the world checks that the controller commands nothing that was not sent, nothing beyond the limits and
//! nothing that tears the sheet.

use foldpath_core::follower::{Denial, Fault, Reason, State};
use foldpath_core::wire::cobs;
use foldpath_core::wire::frame;
use foldpath_core::wire::message::{SCHEMA, ToDevice, ToHost, VERSION};
use foldpath_core::wire::protection::Unkeyed;
use foldpath_core::wire::sender::{Failure, Phase};
use foldpath_firmware_sim::faults::Faults;
use foldpath_firmware_sim::hinges::{Drive, Hinges, Trouble};
use foldpath_test_support::Measure as _;
use rand_core::Rng;

use crate::path::{CLOSURE, Device, KNOTS, LIMITS, Path, TOP, below, settings};
use crate::world::{Host, World, rng};

const SEEDS: u64 = 100;

/// A serial line of 1 Mbaud behind an adapter.
pub(crate) const LINE: Faults = Faults {
    drop: 0.0,
    flip: 0.0,
    double: 0.0,
    reorder: 0.0,
    delay: 1000,
    late: 5000,
    speed: 1e5,
    buffer: 0,
    capacity: usize::MAX,
};
pub(crate) const NOISY: Faults = Faults {
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
    // The path takes two seconds; speeding up and slowing down add a quarter.
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
        for counts in [world.up.counts(), world.down.counts()] {
            assert!(counts.dropped > 0 && counts.flipped > 0);
            assert!(counts.doubled > 0 && counts.reordered > 0);
        }
    }
    println!("slowest {slowest} us, repeated {repeated}, closure {closure:e}");
}

/// Runs to a moment between 0.1 s and 2.2 s. Most of these moments lie within the motion.
fn some_time_later<'a>(path: &'a Path, faults: Faults, seed: u64) -> World<'a> {
    let mut world = World::new(path, faults, seed);
    let moment = 100_000 + below(&mut rng(900 + seed), 2_100_000);
    world.run(moment);
    world
}

#[test]
fn a_host_that_is_silent_for_two_seconds_finds_the_sheet_holding_and_goes_on() {
    let path = Path::miura();
    let mut silent = 0;
    for seed in 0..SEEDS {
        let mut world = some_time_later(&path, NOISY, seed);
        let moved = world.state() == State::Running;
        world.hosts[0].awake = false;
        world.run(2_000_000);
        let held = moved && world.state() != State::Done;
        if held {
            assert_eq!(world.state(), State::Holding);
            assert_eq!(world.device.follower().rate().to_bits(), 0);
            assert_eq!(world.reason(), Reason::Silence);
            silent += 1;
        }
        world.hosts[0].awake = true;
        world.finish(30);
        assert!(!held || world.hosts[0].reasons.contains(&Reason::Silence));
    }
    assert!(silent > SEEDS / 2);
}

#[test]
fn a_host_that_never_comes_back_leaves_the_sheet_at_rest_and_the_next_is_told() {
    let path = Path::miura();
    let mut silent = 0;
    for seed in 0..SEEDS {
        let mut world = some_time_later(&path, NOISY, seed);
        let moved = world.device.follower().is_under_way();
        let before = world.state();
        world.hosts[0].awake = false;
        world.run(600_000);
        let place = world.device.follower().position();
        assert_eq!(world.device.follower().rate().to_bits(), 0);
        world.run(3_000_000);
        assert_eq!(world.device.follower().position(), place);
        let held = moved && world.state() != State::Done;
        if held {
            let holds = (State::Holding, Reason::Silence);
            assert_eq!((world.state(), world.reason()), holds);
            silent += 1;
        } else if !moved {
            assert_eq!(world.state(), before);
        }
        world.hosts.push(Host::new(&path, 88_888));
        world.finish(30);
        assert!(!held || world.hosts[1].reasons.contains(&Reason::Silence));
    }
    assert!(silent > SEEDS / 2);
}

/// The stop line is drawn twenty times in each run: in motion, while braking and at rest.
#[test]
fn the_stop_line_stops_at_any_moment_and_the_host_is_told() {
    let path = Path::miura();
    let mut moving = 0;
    for seed in 0..SEEDS {
        let mut world = some_time_later(&path, NOISY, seed);
        let mut rng = rng(600 + seed);
        for _ in 0..20 {
            world.run(below(&mut rng, 400_000));
            let (before, rate) = (world.state(), world.device.follower().rate());
            let place = world.device.follower().position();
            let angles = world.device.follower().angles().to_vec();
            moving += u64::from(rate > 0.0);
            world.device.stop(true);
            assert_eq!(world.device.follower().rate().to_bits(), 0);
            assert!(
                world
                    .device
                    .follower()
                    .rates()
                    .iter()
                    .all(|rate| rate.to_bits() == 0)
            );
            world.run(below(&mut rng, 200_000));
            if matches!(before, State::Running | State::Holding | State::Done) {
                assert_eq!(world.device.follower().position(), place);
                assert_eq!(world.device.follower().angles(), angles);
            }
            assert_eq!(world.reason(), Reason::StopLine);
            if matches!(before, State::Running | State::Holding) {
                assert_eq!(world.state(), State::Holding);
            }
            world.device.stop(false);
        }
        // In a hundred milliseconds at least one report comes through.
        world.device.stop(true);
        world.run(300_000);
        world.device.stop(false);
        world.finish(30);
        assert!(world.hosts[0].reasons.contains(&Reason::StopLine));
    }
    assert!(moving > 3 * SEEDS, "{moving}");
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
        world.hosts.push(Host::new(&path, 77_777));
        world.finish(30);
        assert_eq!(world.failure(0), Some(Failure::Lost));
        assert!(world.hosts[1].reasons.contains(&Reason::Session));
    }
    assert!(taken > SEEDS / 2);
}

/// The first host sends another path than the one that is followed, and vanishes before it starts that path.
#[test]
fn frames_of_a_session_that_is_over_do_nothing() {
    let (path, other) = (Path::miura(), Path::miura_to(TOP / 2.0));
    for seed in 0..SEEDS {
        let mut world = World::new(&path, LINE, seed);
        world.hosts = vec![Host::new(&other, 1000)];
        let mut kept = Vec::new();
        while world.device.follower().room() > 4 {
            if let Some(bytes) = world.hosts[0].poll(world.now) {
                world.up.write(&bytes, world.now);
                kept.push(bytes);
            }
            world.step();
        }
        assert_eq!(world.state(), State::Ready);
        world.hosts[0].awake = false;
        world.hosts.push(Host::new(&path, 77_777));
        // Frames of the first host come again, between and inside those of the second host.
        let mut rng = rng(seed);
        for _ in 0..30 {
            world.run(below(&mut rng, 40_000));
            let first = usize::try_from(below(&mut rng, kept.len() as u64)).unwrap();
            for byte in kept[first..].iter().take(8).flatten() {
                world.device.byte(*byte, world.now);
            }
        }
        world.finish(10);
        assert_eq!(world.failure(1), None);
        assert!(!world.held.contains(&Reason::Session));
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

        // This project's host gives up when it hears such an answer, and tells the reason.
        let mut host = Host::new(&path, 5);
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

/// A host of another version does not disturb the host whose session is open.
#[test]
fn a_host_of_another_version_disturbs_nobody() {
    let path = Path::miura();
    for seed in 0..SEEDS {
        let mut world = some_time_later(&path, NOISY, seed);
        let mut rng = rng(400 + seed);
        for _ in 0..20 {
            let mut buffer = [0; 64];
            let hello = ToDevice::Hello {
                version: VERSION + 1,
                schema: rng.next_u32(),
                id: rng.next_u32(),
            };
            let frame = frame::seal(0, &hello, &mut buffer).unwrap();
            let mut bytes = vec![0];
            cobs::encode(frame, |byte| bytes.push(byte));
            world.up.write(&bytes, world.now);
            world.run(below(&mut rng, 50_000));
        }
        world.finish(30);
        assert_eq!(world.failure(0), None);
        assert!(!world.held.contains(&Reason::Session));
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

/// A line of 9,600 baud behind an adapter that waits for 16 ms. Nothing is sent again but what got lost, and a hold
/// brings the sheet to rest at once.
#[test]
fn a_slow_line_is_not_filled_with_repetitions() {
    let path = Path::miura();
    for (drop, seeds) in [(0.0, 4), (0.01, 20)] {
        let slow = Faults {
            drop,
            delay: 16_000,
            speed: 960.0,
            ..LINE
        };
        for seed in 0..seeds {
            let mut world = World::new(&path, slow, seed);
            world.run(3_000_000 + below(&mut rng(700 + seed), 2_000_000));
            world.hosts[0].driver.stop();
            let asked = world.now;
            while world.device.follower().rate() > 0.0 || world.state() == State::Ready {
                world.step();
                assert!(world.now < asked + 500_000, "{:?}", world.hosts[0].sender());
            }
            world.hosts.clear();
            world
                .hosts
                .push(Host::new(&path, 50_000 + u32::try_from(seed).unwrap()));
            world.finish(30);
            let repeated = world.hosts[0].sender().repeated();
            assert!(
                repeated <= if drop > 0.0 { 60 } else { 2 },
                "{drop} {repeated}"
            );
        }
    }
}

/// If the host does not read, the buffer of the device fills, telemetry gives way, and nothing waits.
#[test]
fn a_host_that_does_not_read_blocks_nothing() {
    let path = Path::miura();
    let mut dried = 0;
    for seed in 0..SEEDS {
        let mut world = some_time_later(&path, LINE, seed);
        let moved = world.state() == State::Running;
        world.drains = false;
        world.run(3_000_000);
        assert_eq!(world.device.follower().rate().to_bits(), 0);
        let dry = moved && world.state() == State::Holding;
        // The host learns of no room, and repeats whatever was not acknowledged. The controller hears these
        // repetitions, so that the host counts as present.
        assert!(!dry || world.reason() == Reason::Underrun);
        dried += u64::from(dry);
        world.drains = true;
        world.finish(30);
        assert_eq!(world.held, []);
        assert!(!dry || world.hosts[0].reasons.contains(&Reason::Underrun));
    }
    assert!(dried > SEEDS / 2, "{dried}");
}

#[test]
fn stalls_and_overruns_cost_time_alone() {
    let path = Path::miura();
    let mut overrun = 0;
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
        overrun += world.up.counts().overrun + world.down.counts().overrun;
    }
    assert!(overrun > 100 * SEEDS, "{overrun}");
}

#[test]
fn after_a_reset_the_fold_goes_on_from_the_last_place_executed() {
    let path = Path::miura();
    for seed in 0..SEEDS {
        let mut world = some_time_later(&path, NOISY, seed);
        let place = world.device.follower().position();
        let angles = world.device.follower().angles().to_vec();
        let open = world.hosts[0].sender().phase() == Phase::Open;
        reset(&mut world);
        // A host whose session was not open yet greets again, and does not notice.
        if !open {
            continue;
        }
        // The line loses a fifth of what is said, and the host repeats itself at the pace of the line.
        world.run(1_500_000);
        assert_eq!(world.failure(0), Some(Failure::Lost));
        assert_eq!(world.device.follower().angles(), angles);
        world.hosts.push(Host::new(&path, 99_999));
        world.finish(30);
        // The second host sends no setpoint again that was executed, except the knot before the place.
        let sent = world.hosts[1].driver.setpoints();
        assert_eq!(sent, KNOTS as u64 - u64::from(place.knot));
    }
}

/// Resets the controller. Its board has kept the record of the last tick.
fn reset(world: &mut World<'_>) {
    let record = world.device.record(1, 1);
    world.device = Device::protected(settings(1 << 40), Unkeyed);
    world.device.restore(&record, true);
}

/// Drives that are a little faster than the path asks for.
const DRIVE: Drive = Drive {
    lag: 0.005,
    speed: 4.0,
    acceleration: 200.0,
    play: 0.002,
    noise: 0.001,
};

fn with_hinges<'a>(path: &'a Path, drive: Drive, seed: u64) -> World<'a> {
    let mut world = World::new(path, NOISY, seed);
    world.hinges = Some(Hinges::new(&path.hinges, drive, rng(1100 + seed)));
    world
}

/// Measures how torn the sheet is while the follower runs. Every hinge of the vertex is off its command by its lag and
/// half its play, and turns a part of the sheet by no more than that.
#[test]
fn real_hinges_tear_the_sheet_by_no_more_than_they_are_off() {
    let path = Path::miura();
    let exact = Drive::default();
    let lagging = Drive {
        lag: 0.005,
        ..exact
    };
    let playing = Drive {
        play: 0.002,
        ..exact
    };
    let of = |drive, seed| {
        let mut world = with_hinges(&path, drive, seed);
        world.finish(30);
        (world.torn, world.farthest)
    };
    for seed in 0..10 {
        let (torn, off) = of(exact, seed);
        assert!(
            torn <= f64::from(CLOSURE) && off <= 1e-6,
            "{torn:e} {off:e}"
        );
        // At the speed v a motor with the time constant T lags by v T.
        let (torn, off) = of(lagging, seed);
        assert!(off > 0.9 * 0.005 * 2.0 && off <= 0.0055 * 2.5, "{off}");
        // All hinges lag alike, so that the sheet is where it was commanded to be a moment ago.
        assert!(torn <= 0.02 * off, "{torn} {off}");
        let (torn, off) = of(playing, seed);
        assert!((off - 0.001).abs() < 1e-5, "{off}");
        assert!(torn > 1e-4 && torn <= 4.0 * off, "{torn} {off}");
        let (torn, off) = of(DRIVE, seed);
        println!("torn {torn:.5}, off {off:.5}");
        assert!(torn <= 4.0 * off && off < 0.05, "{torn} {off}");
    }
}

#[test]
fn a_dip_of_the_supply_slows_the_sheet_and_nobody_has_to_ask() {
    let path = Path::miura();
    let mut slowed = 0;
    for seed in 0..SEEDS {
        let mut world = with_hinges(&path, DRIVE, seed);
        let mut rng = rng(1200 + seed);
        world.run(600_000 + below(&mut rng, 1_000_000));
        world
            .hinges
            .as_mut()
            .unwrap()
            .befall(Trouble::Supply(below(&mut rng, 20) as f64 / 100.0));
        world.run(100_000 + below(&mut rng, 700_000));
        world.hinges.as_mut().unwrap().befall(Trouble::Supply(1.0));
        let lagged = matches!(world.reason(), Reason::Lag(_));
        slowed += u64::from(lagged);
        world.run(200_000);
        assert_eq!(world.held, []);
        world.finish(30);
        let told = |reason: &Reason| matches!(reason, Reason::Lag(_));
        assert!(!lagged || world.hosts[0].reasons.iter().any(told));
        // The largest lag that holds the motion, and the motion during braking.
        let most = 0.15 + 0.125 * f64::from(LIMITS.speed) + DRIVE.noise;
        assert!(world.farthest <= most, "{}", world.farthest);
    }
    assert!(slowed > SEEDS / 2, "{slowed}");
}

/// The supply dips so deep that the controller is reset. Its hinges stay where they are: near the commands that the record
/// has kept, and the fold goes on, or far from them, and nothing pulls them there.
#[test]
fn a_dip_that_resets_the_controller_ends_where_the_hinges_stand() {
    let path = Path::miura();
    let mut denied = 0;
    for seed in 0..SEEDS {
        let mut world = with_hinges(&path, DRIVE, seed);
        let mut rng = rng(1300 + seed);
        world.run(400_000 + below(&mut rng, 1_500_000));
        world.hinges.as_mut().unwrap().befall(Trouble::Supply(0.0));
        world.run(below(&mut rng, 300_000));
        reset(&mut world);
        world.run(100_000);
        let stood = world.hinges.as_ref().unwrap().angles();
        world.hinges.as_mut().unwrap().befall(Trouble::Supply(1.0));
        world.hosts.push(Host::new(&path, 99_999));
        world.run(3_000_000);
        let sender = world.hosts.last().unwrap().sender();
        if matches!(sender.report().unwrap().denied, Some(Denial::Jump(_))) {
            denied += 1;
            assert_eq!(world.hinges.as_ref().unwrap().angles(), stood);
        } else {
            world.finish(30);
        }
        assert_eq!(world.failure(0), Some(Failure::Lost));
    }
    assert!((1..SEEDS).contains(&denied), "{denied}");
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
                if let Some(command) = command {
                    let at = *stuck.get_or_insert(command);
                    if world.now < moment {
                        stuck = None;
                    }
                    world.device.follower_mut().measure(hinge, member, at);
                }
            }
            if world.state() == State::Faulted {
                break;
            }
        }
        assert_eq!(world.state(), State::Faulted);
        assert_eq!(world.reason(), Reason::Fault(Fault::Stalled(hinge)));
        world.run(500_000);
        assert!(
            world.hosts[0]
                .reasons
                .contains(&Reason::Fault(Fault::Stalled(hinge)))
        );
        // The host clears the fault.
        assert_eq!(world.state(), State::Idle);
    }
}
