//! Does the controller's image keep the sheet whole whatever goes wrong round it? It runs in an emulator, with five
//! seeds for every fault. The world judges everything that the board tells: it commands nothing that was not sent,
//! nothing beyond the limits and nothing that tears the sheet. All times are times of the board.

use core::time::Duration;
use std::sync::LazyLock;
use std::thread;

use crate::image::path::Fold;
use crate::image::world::{Sight, World, moment, rng, stuffed};
use crate::image::{address, image, turn};
use foldpath_core::follower::{Fault, Reason, State};
use foldpath_core::wire::cobs::Deframer;
use foldpath_core::wire::driver::Persistence;
use foldpath_core::wire::frame;
use foldpath_core::wire::message::{Command, SCHEMA, ToDevice, ToHost, VERSION};
use foldpath_core::wire::sender::Failure;
use foldpath_firmware_sim::faults::Faults;
use rand_core::Rng;

const AN386: &str = "mps2-an386";
const SEEDS: u64 = 5;
/// Seconds of its path that a sheet may go on once its host is silent: half a second until the silence is noticed, a
/// quarter of braking, and the rest for frames on their way. A tick that a busy machine makes late counts as 10 ms, so
/// that the board's clock is no measure.
const HELD: f64 = 1.25;

static FOLD: LazyLock<Fold> = LazyLock::new(Fold::miura);

/// Runs a test with all seeds at the same time. Tests take turns, because more boards at once would wait for each
/// other.
fn seeds(test: impl Fn(u64) + Sync) {
    LazyLock::force(&FOLD);
    image("foldpath-mps2-small");
    let _turn = turn();
    thread::scope(|scope| {
        for seed in 0..SEEDS {
            let test = &test;
            scope.spawn(move || test(seed));
        }
    });
}

/// Starts a board, and a host on a line without faults that has begun to greet.
fn world(seed: u64, persistence: Persistence) -> World<'static> {
    let mut world = World::new(&FOLD, AN386, Faults::default(), seed);
    world.greet(persistence);
    world
}

#[test]
fn a_whole_fold_comes_back_bit_for_bit() {
    seeds(|seed| {
        let machine = if seed == 0 { "mps2-an500" } else { AN386 };
        let mut world = World::new(&FOLD, machine, Faults::default(), seed);
        world.greet(Persistence::None);
        world.finish();
        // Telemetry comes every 20 ms for two seconds.
        assert!(world.sights > 90, "{}", world.sights);
    });
}

#[test]
fn a_host_that_is_silent_for_two_seconds_finds_the_sheet_holding_and_goes_on() {
    seeds(|seed| {
        let mut world = world(seed, Persistence::None);
        world.run_into(moment(seed));
        let silent = world.time();
        world.hosts[0].awake = false;
        let held = held(&mut world);
        assert!(matches!(reason(&world), Reason::Silence | Reason::Underrun));
        world.until(|world| world.time() >= silent + 2_000_000);
        assert_eq!(rests(&world, State::Holding).place, held.place);
        assert_eq!(reason(&world), Reason::Silence);
        world.hosts[0].awake = true;
        world.finish();
        assert!(world.host().reasons.contains(&Reason::Silence));
    });
}

/// The host is gone and does not read either, so that the line fills and blocks. The board goes on, without a reset by
/// its watchdog, which would bite after two seconds.
#[test]
fn a_host_that_is_gone_leaves_the_sheet_at_rest_for_another() {
    seeds(|seed| {
        let mut world = world(seed, Persistence::None);
        world.run_into(moment(seed));
        world.hosts[0].awake = false;
        let held = held(&mut world);
        world.neglect(4_000_000);
        world.run(1_000_000);
        assert!(world.hole > 2_000_000, "{}", world.hole);
        let later = rests(&world, State::Holding);
        assert_eq!((later.place, later.angles), (held.place, held.angles));
        world.greet(Persistence::Resume);
        world.finish();
        assert!(world.host().reasons.contains(&Reason::Silence));
        world.hosts[0].awake = true;
        world.until(|world| world.failure(0).is_some());
        assert_eq!(world.failure(0), Some(Failure::Lost));
    });
}

/// The host hears no answer. It learns of no room, and repeats whatever was not acknowledged.
#[test]
fn a_host_that_does_not_read_blocks_nothing() {
    seeds(|seed| {
        let mut world = world(seed, Persistence::None);
        world.run_into(moment(seed));
        world.neglect(3_000_000);
        world.hosts[0].awake = false;
        world.until(|world| world.hole > 1_000_000);
        rests(&world, State::Holding);
        assert!(matches!(reason(&world), Reason::Silence | Reason::Underrun));
        world.hosts[0].awake = true;
        world.finish();
        let told = |reason: &Reason| matches!(reason, Reason::Silence | Reason::Underrun);
        assert!(world.host().reasons.iter().any(told));
    });
}

/// The stop line is drawn four times in each fold, twenty times in all.
#[test]
fn the_stop_line_stops_at_any_moment_and_the_host_is_told() {
    seeds(|seed| {
        let mut world = World::new(&FOLD, AN386, Faults::default(), seed);
        let mut rng = rng(600 + seed);
        for _ in 0..4 {
            // A host may resume after what held an earlier session.
            world.greet(Persistence::Resume);
            world.run_into(50_000 + rng.next_u64() % 400_000);
            world.board.draw_stop();
            world.until(|world| reason(world) == Reason::StopLine);
            let time = world.time();
            world.until(|world| world.time() > time);
            let stopped = rests(&world, State::Holding);
            world.run(200_000);
            let later = rests(&world, State::Holding);
            assert_eq!((later.place, later.angles), (stopped.place, stopped.angles));
            assert!(world.host().reasons.contains(&Reason::StopLine));
            world.hosts.last_mut().unwrap().awake = false;
        }
        world.greet(Persistence::Resume);
        world.finish();
    });
}

/// The supply leaves the drives less than a fifth of their speed; the path needs a quarter.
#[test]
fn a_dip_of_the_supply_slows_the_sheet_and_nobody_has_to_ask() {
    let plant = usize::try_from(address(&["mps2", "PLANT"])).unwrap();
    seeds(|seed| {
        let mut world = world(seed, Persistence::None);
        let mut rng = rng(1200 + seed);
        world.run_into(300_000 + rng.next_u64() % 700_000);
        world.board.bench(&format!("{}s", rng.next_u64() % 15));
        world.until(|world| matches!(reason(world), Reason::Lag(_)));
        world.run(200_000);
        let before = world.sight.unwrap();
        world.run(300_000);
        let after = world.sight.unwrap();
        let gone = FOLD.time(after.place) - FOLD.time(before.place);
        let passed = 1e-6 * (after.time - before.time) as f64;
        assert!(gone < 0.7 * passed, "{gone} {passed}");
        // The hinges lag behind their commands by at most the lag that holds the motion, plus the braking.
        world.freeze();
        let words = world.board.memory(plant, 16);
        let (words, _) = words.as_chunks::<4>();
        let commanded = world.sight.unwrap().angles.unwrap();
        let behind =
            [0, 1].map(|group| (commanded[group] - f32::from_le_bytes(words[2 * group])).abs());
        let farthest = behind[0].max(behind[1]);
        assert!(
            (0.05..0.15 + 0.125 * 1.5 + 0.03).contains(&farthest),
            "{behind:?}"
        );
        world.board.thaw();
        world.board.bench("100s");
        world.finish();
        let told = |reason: &Reason| matches!(reason, Reason::Lag(_));
        assert!(world.host().reasons.iter().any(told));
    });
}

#[test]
fn a_stalled_hinge_ends_in_a_fault_that_names_it() {
    seeds(|seed| {
        let mut world = world(seed, Persistence::None);
        let mut rng = rng(700 + seed);
        let hinge = u32::try_from(rng.next_u64() % 1104).unwrap();
        world.run_into(100_000 + rng.next_u64() % 1_000_000);
        world.board.bench(&format!("{hinge}k"));
        world.until(|world| reason(world) == Reason::Fault(Fault::Stalled(hinge)));
        let time = world.time();
        world.until(|world| world.time() > time);
        let stalled = rests(&world, State::Faulted);
        world.run(500_000);
        let later = rests(&world, State::Faulted);
        // A sheet of which a hinge is not where it is commanded to be is not commanded any more.
        assert_eq!((later.place, later.angles), (stalled.place, None));
        assert!(world.host().reasons.contains(&Reason::Lag(hinge)));
        assert!(
            world
                .host()
                .reasons
                .contains(&Reason::Fault(Fault::Stalled(hinge)))
        );
        assert_eq!(world.failure(0), None);
        // The hinge is freed and goes with the others.
        world.board.bench("f");
        world.hosts[0].awake = false;
        world.greet(Persistence::Always);
        world.finish();
        assert!(
            world
                .host()
                .reasons
                .contains(&Reason::Fault(Fault::Stalled(hinge)))
        );
    });
}

/// Half of the seeds draw the stop line first, and the reset must not release it.
#[test]
fn after_a_warm_reset_the_fold_goes_on_from_the_last_executed_setpoint() {
    seeds(|seed| {
        let stopped = seed % 2 == 1;
        let mut world = world(seed, Persistence::Resume);
        world.run_into(moment(seed));
        if stopped {
            world.board.draw_stop();
            world.until(|world| reason(world) == Reason::StopLine);
        }
        world.freeze();
        let before = world.sight.unwrap();
        let age = world.board.since(before.time);
        world.board.reset();
        world.until(|world| world.failure(0).is_some());
        assert_eq!(world.failure(0), Some(Failure::Lost));
        world.forget();

        let persistence = if stopped {
            Persistence::None
        } else {
            Persistence::Resume
        };
        world.greet(persistence);
        world.until(|world| world.report.is_some() && world.sight.is_some());
        let place = world.sight.unwrap().place;
        let gone = FOLD.time(place) - FOLD.time(before.place);
        // The motion went on behind the last telemetry, which a busy machine may have held up, at most at its full rate.
        let most = age.as_secs_f64() + 2e-3;
        assert!((0.0..=most).contains(&gone), "{gone} of {most}");
        if stopped {
            assert_eq!(reason(&world), Reason::StopLine);
            world.run(300_000);
            let held = world.sight.unwrap();
            assert_eq!((held.place, held.rate.to_bits()), (place, 0));
            assert_ne!(held.state, State::Running);
            world.greet(Persistence::Resume);
        }
        world.finish();
    });
}

/// Moves the content of the stack down to its guard, so that the next call or interrupt grows into the guard.
#[test]
fn a_stack_that_grows_into_its_guard_resets_the_board_and_the_fold_goes_on() {
    seeds(|seed| {
        let mut world = world(seed, Persistence::None);
        world.run_into(moment(seed));
        world.freeze();
        let before = world.sight.unwrap();
        let left = u32::try_from(rng(1400 + seed).next_u64() % 128).unwrap();
        let (start, age) = (world.board.micros(), world.board.since(before.time));
        world.board.deepen_stack(left);
        // The watchdog would take a second, as the test below shows.
        let after = world.until_reset(start);
        assert!(after < 500_000, "{after}");
        resumes(&mut world, before, age);
    });
}

#[test]
fn a_main_loop_that_hangs_resets_the_board_and_the_fold_goes_on() {
    let tick = address(&["application", "tick"]);
    seeds(|seed| {
        let mut world = world(seed, Persistence::None);
        world.run_into(moment(seed));
        world.freeze();
        let before = world.sight.unwrap();
        let (start, age) = (world.board.micros(), world.board.since(before.time));
        world.board.hang(tick);
        let after = world.until_reset(start);
        assert!((500_000..2_100_000).contains(&after), "{after}");
        resumes(&mut world, before, age);
    });
}

/// Waits until the host notices the reset of a board that was frozen so long after it told something. Another host then goes
/// on from the setpoint that was executed last.
fn resumes(world: &mut World<'_>, before: Sight, age: Duration) {
    world.until(|world| world.failure(0).is_some());
    assert_eq!(world.failure(0), Some(Failure::Lost));
    world.forget();
    world.greet(Persistence::Resume);
    world.until(|world| world.report.is_some() && world.sight.is_some());
    let gone = FOLD.time(world.sight.unwrap().place) - FOLD.time(before.place);
    // The board moves on until its stack or main loop fails.
    let most = age.as_secs_f64() + 0.1;
    assert!((0.0..=most).contains(&gone), "{gone} of {most}");
    world.finish();
}

#[test]
fn a_host_of_another_version_is_told_and_moves_nothing() {
    seeds(|seed| {
        let mut world = World::new(&FOLD, AN386, Faults::default(), seed);
        let mut rng = rng(seed);
        let id = rng.next_u32();
        let (version, schema) = if seed == 0 {
            (VERSION, SCHEMA ^ 1)
        } else {
            (VERSION + 1 + u16::try_from(seed).unwrap(), rng.next_u32())
        };
        let hello = ToDevice::Hello {
            version,
            schema,
            id,
        };
        let mut buffer = [0; 64];
        let mut ear = Deframer::<64>::default();
        let greeting = stuffed(frame::seal(0, &hello, &mut buffer).unwrap());
        let mut sent = 0;
        let answer = 'answered: loop {
            sent += world.board.write(&greeting[sent..]);
            for byte in world.board.read() {
                if let Some(frame) = ear.push(byte) {
                    break 'answered frame.to_vec();
                }
            }
        };
        let (version, schema) = (VERSION, SCHEMA);
        let mismatch = ToHost::Mismatch {
            id,
            version,
            schema,
        };
        assert_eq!(frame::open(&answer), Some((0, mismatch)));
        // The host has no session, so that its next command is not accepted.
        let start = ToDevice::Command {
            number: 1,
            command: Command::Start,
        };
        world.inject(&stuffed(frame::seal(id, &start, &mut buffer).unwrap()));
        world.greet(Persistence::None);
        world.until(|world| world.report.is_some());
        assert_eq!(world.report.unwrap().state, State::Idle);
        world.finish();
    });
}

#[test]
fn frames_of_a_session_that_is_over_do_nothing() {
    seeds(|seed| {
        let mut world = world(seed, Persistence::None);
        world.run_into(moment(seed));
        let stale = world.spoken.clone();
        world.hosts[0].awake = false;
        world.greet(Persistence::Resume);
        world.until(|world| world.host().driver.is_started());
        for piece in stale.split_inclusive(|byte| *byte == 0) {
            world.inject(piece);
            world.step();
        }
        world.finish();
        assert!(world.host().reasons.contains(&Reason::Session));
    });
}

/// Sends random bytes, half of them before a host comes and half of them between its frames.
fn random_bytes_do_nothing(each: usize) {
    seeds(|seed| {
        let mut world = World::new(&FOLD, AN386, Faults::default(), seed);
        let mut rng = rng(seed);
        let mut noise = vec![0; each];
        rng.fill_bytes(&mut noise);
        let (before, between) = noise.split_at(each / 2);
        world.inject(before);
        world.inject(&[0]);
        world.greet(Persistence::None);
        world.until(|world| world.host().driver.is_started());
        for piece in between.chunks(500) {
            world.inject(&[piece, &[0]].concat());
            let reports = world.reports;
            world.until(|world| world.reports > reports);
        }
        world.finish();
        // The clock of the board runs on while a busy machine lets the emulator wait.
        let waits = [Reason::Silence, Reason::Underrun, Reason::LateTick];
        let reasons = &world.host().reasons;
        let is_wait = |reason: &Reason| *reason == Reason::None || waits.contains(reason);
        assert!(reasons.iter().all(is_wait), "{reasons:?}");
    });
}

#[test]
fn two_hundred_thousand_random_bytes_do_nothing() {
    random_bytes_do_nothing(40_000);
}

#[test]
#[ignore = "takes a minute"]
fn a_million_random_bytes_do_nothing() {
    random_bytes_do_nothing(200_000);
}

#[test]
fn noise_changes_nothing_but_the_time() {
    let noisy = Faults {
        drop: 0.1,
        flip: 0.1,
        double: 0.1,
        reorder: 0.1,
        delay: 1000,
        late: 5000,
        ..Faults::default()
    };
    seeds(|seed| {
        let mut world = World::new(&FOLD, AN386, noisy, seed);
        world.greet(Persistence::None);
        world.finish();
        for line in [&world.up, &world.down] {
            let counts = line.counts();
            let faults = [
                counts.dropped,
                counts.flipped,
                counts.doubled,
                counts.reordered,
            ];
            assert!(faults.iter().all(|count| *count > 0), "{counts:?}");
        }
        assert!(world.host().driver.sender().repeated() > 0);
    });
}

/// Returns the last telemetry. Asserts that it tells of a sheet at rest in this state.
#[track_caller]
fn rests(world: &World<'_>, state: State) -> Sight {
    let sight = world.sight.unwrap();
    assert_eq!((sight.state, sight.rate.to_bits()), (state, 0), "{sight:?}");
    sight
}

/// Runs until a sheet whose host is silent is at rest, and returns what it told last.
fn held(world: &mut World<'_>) -> Sight {
    let silent = world.sight.unwrap();
    world.until(|world| {
        let Sight { state, rate, .. } = world.sight.unwrap();
        state == State::Holding && rate <= 0.0
    });
    let held = rests(world, State::Holding);
    let gone = FOLD.time(held.place) - FOLD.time(silent.place);
    assert!(gone <= HELD, "{silent:?} {held:?}");
    held
}

/// Returns the reason that was reported last.
fn reason(world: &World<'_>) -> Reason {
    world.report.map_or(Reason::None, |report| report.reason)
}
