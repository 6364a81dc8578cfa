//! Does a follower stop for stuck hinges, latches, leaps and bounds, move farther in no tick than it may, and go on from
//! where it stands?

use foldpath_core::follower::{Denial, Fault, FollowerPosition, Measurement, Reason, State};
use foldpath_core::{GroupId, Membership, Scalar};
use foldpath_test_support::{Measure as _, Random};

use crate::alike::{Run, TICK};

/// A stop or a hold in the middle of an approach stops it, and it goes on from there, also for another host.
#[test]
fn an_approach_is_held_and_goes_on() {
    let mut run = Run::<2>::new();
    run.load(0.5);
    run.measure(|_| 0.45);
    run.follower.start().unwrap();
    (0..300).for_each(|_| _ = run.tick());
    run.follower.stop(true);
    run.follower.stop(false);
    let stood = run.follower.angles().to_vec();
    assert!(stood[0] > 0.455 && stood[0] < 0.495, "{stood:?}");
    (0..100).for_each(|_| run.still());
    run.follower.unload().unwrap();
    run.load(0.5);
    run.follower.resume().unwrap();
    run.follower.start().unwrap();
    assert_eq!(run.follower.angles(), stood);
    run.until(State::Done);
}

/// The stop line is drawn in a fault, and a hinge fails while the stop line holds: both are told, and each has to be
/// released on its own.
#[test]
fn a_stop_and_a_fault_are_latched_apart() {
    for fault_first in [true, false] {
        let mut run = Run::<2>::new();
        run.load(0.0);
        run.follower.confirm().unwrap();
        run.follower.start().unwrap();
        (0..300).for_each(|_| _ = run.tick());
        let fault = Fault::Stalled(3);
        if fault_first {
            run.follower.fail(fault);
        }
        run.follower.stop(true);
        run.follower.stop(false);
        run.follower.fail(fault);
        assert_eq!(run.follower.state(), State::Faulted);
        assert_eq!(run.follower.reason(), Reason::Fault(fault));
        assert_eq!(
            (run.follower.fault(), run.follower.is_stopped()),
            (Some(fault), true)
        );
        (0..100).for_each(|_| run.still());
        run.follower.clear().unwrap();
        assert_eq!(run.follower.reason(), Reason::StopLine);
        run.load(run.follower.angles()[0]);
        assert_eq!(run.follower.start(), Err(Denial::Held));
        run.follower.resume().unwrap();
        assert_eq!(run.follower.start(), Ok(()));
    }
}

/// Whatever is wrong with a path, its clock or its memory: a tick that would move a group too far is a fault, and the
/// command stays.
#[test]
fn a_leap_within_a_tick_is_a_fault() {
    for seed in 0..100 {
        let mut rng = Random::new(seed);
        let mut run = Run::<11>::new();
        run.load(0.0);
        run.follower.confirm().unwrap();
        run.follower.start().unwrap();
        (0..50 + rng.below(1000)).for_each(|_| _ = run.tick());
        // The board's limits are narrower from now on; acceptance has checked the path against the limits before.
        run.follower
            .limit_speeds(|group| if group == 7 { 1e-3 } else { 2.0 });
        let before = run.follower.angles().to_vec();
        run.still();
        assert_eq!(run.follower.reason(), Reason::Fault(Fault::Leap(7)));
        assert_eq!(run.follower.angles(), before);
        (0..100).for_each(|_| run.still());
    }
}

/// One hinge is stuck. Beside it a sensor fails every other time, or less often.
#[test]
fn a_sensor_that_flickers_hides_no_stuck_hinge() {
    for (stuck, flickers) in [(1, 3), (4, 2), (0, 5), (3, 3)] {
        for period in [2, 3, 5] {
            let mut run = Run::<2>::new();
            run.load(0.0);
            run.follower.confirm().unwrap();
            run.follower.start().unwrap();
            while run.follower.state() != State::Faulted {
                run.tick();
                let command = run.follower.angles()[0];
                let fails = command > 0.46 && (run.now / TICK).is_multiple_of(period);
                run.measure(|hinge| {
                    if hinge == flickers && fails {
                        f32::NAN
                    } else if hinge == stuck {
                        command.min(0.3)
                    } else {
                        command
                    }
                });
                assert!(
                    run.now < 4_000_000,
                    "{stuck} {flickers} {:?}",
                    run.follower.reason()
                );
            }
            let Reason::Fault(Fault::Stalled(hinge)) = run.follower.reason() else {
                panic!("{:?}", run.follower.reason());
            };
            assert!(hinge == stuck || hinge == flickers);
        }
    }
}

/// Returns the place that is so many seconds behind the beginning of a path whose knots are 0.1 s apart.
fn place(seconds: f32) -> Option<FollowerPosition<f32>> {
    let knot = (0..100_u8).rfind(|knot| f32::from(*knot) * 0.1 <= seconds)?;
    Some(FollowerPosition {
        knot: knot.into(),
        into: seconds - f32::from(knot) * 0.1,
    })
}

/// The path time stays below a bound from outside, reaches it at rest, and goes on when it grows.
#[test]
fn a_lease_bounds_the_path_time() {
    for seed in 0..100 {
        let mut rng = Random::new(seed);
        let mut run = Run::<2>::new();
        run.load(0.0);
        run.follower.confirm().unwrap();
        let mut lease = 0.0;
        run.follower.lease(place(lease));
        run.follower.start().unwrap();
        let time = |run: &Run<2>| {
            let FollowerPosition { knot, into } = run.follower.position();
            knot as f32 * 0.1 + into
        };
        let mut rate = 0.0;
        while lease < 1.5 {
            for _ in 0..rng.below(700) {
                run.tick();
                assert!(time(&run) <= lease + 1e-6, "{} {lease}", time(&run));
                // Close to the bound the rate falls as the square root of a rounded time.
                let most = if rate < 0.05 { 5e-3 } else { 4.1e-3 };
                let change = (run.follower.rate() - rate).abs();
                assert!(change <= most, "{change} {rate}");
                rate = run.follower.rate();
            }
            lease += f32::lit(rng.uniform(0.0, 0.3));
            run.follower.lease(place(lease));
        }
        run.follower.lease(place(0.0));
        (0..2000).for_each(|_| _ = run.tick());
        if run.follower.state() != State::Done {
            assert_eq!(
                (run.follower.state(), run.follower.reason()),
                (State::Holding, Reason::Lease)
            );
        }
        run.follower.lease(None);
        run.until(State::Done);
    }
}

/// The path begins from rest: the clock has come to rest at the end of the approach.
#[test]
fn a_path_begins_from_rest_behind_its_approach() {
    for off in [0.09_f32, -0.05, 0.02, 0.001] {
        let mut run = Run::<2>::new();
        run.load(0.5);
        run.measure(|_| 0.5 + off);
        run.follower.start().unwrap();
        while run.follower.is_approaching() {
            run.tick();
            assert!(run.now < 10_000_000);
        }
        let begun = run.follower.rate();
        assert!(begun <= 5e-3, "{off}: {begun}");
        let mut before = 0.0;
        for _ in 0..200 {
            let moved = run.tick();
            // Speeds up by 4 a second, from rest. Each of the four angles below 1 rad is rounded by 6e-8 rad.
            assert!(moved - before <= 4.1e-6 + 2.4e-7, "{off}: {before} {moved}");
            before = moved;
        }
        run.until(State::Done);
    }
}

/// An approach waits as well for the bound from outside.
#[test]
fn a_lease_holds_an_approach() {
    let mut run = Run::<2>::new();
    run.load(0.5);
    run.measure(|_| 0.45);
    run.follower.lease(place(0.0));
    run.follower.start().unwrap();
    (0..300).for_each(|_| run.still());
    assert_eq!(
        (run.follower.state(), run.follower.reason()),
        (State::Holding, Reason::Lease)
    );
    run.follower.lease(place(0.1));
    (0..3000).for_each(|_| _ = run.tick());
    assert!((run.follower.angles()[0] - 0.6).abs() < 1e-5);
    assert_eq!(run.follower.reason(), Reason::Lease);
}

/// A controller is reset in the middle of an approach, and goes on from there.
#[test]
fn an_approach_goes_on_behind_a_reset() {
    let mut run = Run::<2>::new();
    run.load(0.5);
    run.measure(|_| 0.42);
    run.follower.start().unwrap();
    (0..300).for_each(|_| _ = run.tick());
    let (angles, place) = (run.follower.angles().to_vec(), run.follower.position());
    assert!(run.follower.is_off_path());
    let mut again = Run::<2>::new();
    again.follower.stand(&angles, place, true).unwrap();
    again.load(0.5);
    again.follower.start().unwrap();
    assert_eq!(again.follower.angles(), angles);
    again.until(State::Done);
    assert!(!again.follower.is_off_path());
}

/// The position that is told is that of the angles that are commanded, whatever fails.
#[test]
fn the_position_is_that_of_the_angles() {
    let mut run = Run::<2>::new();
    let stood = FollowerPosition {
        knot: 3,
        into: 0.05,
    };
    run.follower.stand(&[0.35; 2], stood, false).unwrap();
    run.load(0.0);
    // The path has not begun.
    run.follower.fail(Fault::Stalled(1));
    assert_eq!(run.follower.position(), stood);
    run.follower.clear().unwrap();
    assert_eq!(run.follower.position(), stood);

    let mut run = Run::<2>::new();
    run.load(0.0);
    run.follower.confirm().unwrap();
    run.follower.start().unwrap();
    (0..700).for_each(|_| _ = run.tick());
    let (place, angle) = (run.follower.position(), run.follower.angles()[0]);
    run.follower.limit_speeds(|_| 1e-3);
    run.still();
    assert_eq!(run.follower.reason(), Reason::Fault(Fault::Leap(0)));
    assert_eq!(run.follower.position(), place);
    run.follower.clear().unwrap();
    assert_eq!(run.follower.position(), place);
    assert!((place.knot as f32 * 0.1 + place.into - angle).abs() < 1e-5);
}

/// A board measures each hinge in one tick of several. The hinge that lags counts in all of them.
#[test]
fn ticks_without_a_measurement_hide_no_stuck_hinge() {
    for period in [2, 3, 10, 50] {
        for stuck in 0..6 {
            let mut run = Run::<2>::new();
            run.load(0.0);
            run.follower.confirm().unwrap();
            run.follower.start().unwrap();
            while run.follower.state() != State::Faulted {
                run.tick();
                let turn = u32::try_from(run.now / TICK).unwrap();
                let members = (0..6).map(|hinge| Membership {
                    group: GroupId(hinge % 2),
                    negative: false,
                });
                run.follower.drive_from(0, members, |hinge, _, target| {
                    let command = target.unwrap().angle;
                    let angle = if hinge == stuck {
                        command.min(0.3)
                    } else {
                        command
                    };
                    ((turn + hinge) % period == 0).then_some(angle.into())
                });
                assert!(run.now < 4_000_000, "{:?}", run.follower.reason());
            }
            assert_eq!(run.follower.reason(), Reason::Fault(Fault::Stalled(stuck)));
        }
    }
}

/// A servo on a bus tells where it was some time ago.
#[test]
fn an_old_measurement_is_compared_with_the_command_of_its_time() {
    for (age, slowed) in [(100_000, false), (0, true)] {
        let mut run = Run::<2>::new();
        run.load(0.0);
        run.follower.confirm().unwrap();
        run.follower.start().unwrap();
        let mut commands = Vec::new();
        let mut reasons = Vec::new();
        while run.follower.state() != State::Done {
            run.tick();
            let member = Membership {
                group: GroupId(0),
                negative: true,
            };
            commands.push(run.follower.hinge(member).unwrap());
            let angle = commands[commands.len().saturating_sub(101)];
            run.follower.measure(0, member, Measurement { angle, age });
            reasons.push(run.follower.reason());
            assert!(run.now < 60_000_000);
        }
        assert_eq!(reasons.contains(&Reason::Lag(0)), slowed, "{age}");
        assert!(run.follower.rates().iter().all(|rate| rate.to_bits() == 0));
    }
}
