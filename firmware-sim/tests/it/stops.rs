//! How fast and how far does a motion go on after each kind of stop? This command prints the table of the README:
//! `cargo nextest run --release -p foldpath-firmware-sim what_stops --no-capture`.

use foldpath_core::follower::{FollowerPosition, Reason};
use foldpath_core::wire::driver::{Driver, Persistence};
use foldpath_test_support::spans;

use crate::machine::{Machine, Path, Sensor};

/// Follows a path at 1 rad/s for a second, lets something happen, and prints how long and how far the hinges still move,
/// milliseconds and milliradians. `happens` returns the host that is heard from then on.
fn stops<'a>(
    what: &str,
    path: &'a Path,
    persistence: Persistence,
    happens: impl Fn(&mut Machine<2>, Driver<'a>) -> Option<Driver<'a>>,
) -> (u64, f32) {
    let mut machine = Machine::<2>::new(1);
    let mut host = path.driver(persistence, 7).confirming();
    while machine.command().is_none_or(|angle| angle < 0.7) {
        machine.run(Some(&mut host), 1);
    }
    let before = machine.command();
    let mut host = happens(&mut machine, host);
    let begun = machine.command().or(before).unwrap();
    let (mut stood, mut last) = (begun, 0);
    for milli in 1..=3000 {
        machine.run(host.as_mut(), 1);
        let Some(angle) = machine.command() else {
            continue;
        };
        if angle.to_bits() != stood.to_bits() {
            (stood, last) = (angle, milli);
        }
    }
    let far = 1e3 * (stood - begun);
    println!("| {what} | {last} ms | {far:.0} mrad |");
    (last, far)
}

#[test]
fn what_stops_a_motion_how_fast_and_how_far() {
    let path = Path::new(2);
    let none = Persistence::None;
    // The tick that follows stops; in the millisecond before it the motion may have been under way.
    let line = stops("the stop line", &path, none, |machine, host| {
        machine.bench(|bench| bench.stop = true);
        Some(host)
    });
    assert!(line.0 <= 1 && line.1 <= 1.1, "{line:?}");
    let reset = stops("a reset of the board", &path, none, |machine, _| {
        machine.reset();
        None
    });
    assert_eq!(reset, (0, 0.0));
    // The clock brakes from 1 to 0 at 4 a second: in 250 ms, on 125 ms of the path. One round and the line come on top.
    let asked = stops("`Hold`, as by Ctrl-C", &path, none, |_, mut host| {
        host.stop();
        Some(host)
    });
    assert!(
        (249..=253).contains(&asked.0) && (123.0..=128.0).contains(&asked.1),
        "{asked:?}"
    );
    // The silence is noticed 500 ms after the last frame, which comes 50 ms before the end of the host or later.
    let silent = stops("a host that is gone", &path, none, |_, _| None);
    assert!(
        (698..=753).contains(&silent.0) && (573.0..=628.0).contains(&silent.1),
        "{silent:?}"
    );
    // The session of another host begins with its greeting, an exchange later.
    let other = stops("another host that greets", &path, none, |_, _| {
        Some(path.driver(none, 99))
    });
    assert!(
        (249..=256).contains(&other.0) && (123.0..=131.0).contains(&other.1),
        "{other:?}"
    );
    let mut wrong = Path::new(2);
    wrong.spans = spans(41, 0.05);
    let times = (0..41_u8).map(|knot| f32::from(knot) * 0.05);
    wrong.angles = times.flat_map(|time| [time; 2]).collect();
    wrong.rates = vec![1.0; wrong.angles.len()];
    *wrong.angles.last_mut().unwrap() = 9.0;
    let refused = stops(
        "a setpoint that is refused",
        &wrong,
        none,
        |machine, mut host| {
            while machine.condition().reason == Reason::None {
                machine.run(Some(&mut host), 1);
            }
            assert!(matches!(machine.condition().reason, Reason::Refused(_)));
            Some(host)
        },
    );
    assert!(
        (248..=253).contains(&refused.0) && (122.0..=128.0).contains(&refused.1),
        "{refused:?}"
    );
    // At 1 rad/s the path time is the angle. The clock brakes so that it rests at the bound, 300 ms of the path away: 175 ms
    // at full rate, and the 250 ms of braking.
    let lease = stops(
        "a lease that ends 300 ms of the path ahead",
        &path,
        none,
        |machine, host| {
            let time = machine.command().unwrap() + 0.3;
            // The knots are 0.1 s apart.
            let knot = (0..21_u8)
                .rfind(|knot| f32::from(*knot) * 0.1 <= time)
                .unwrap();
            let place = FollowerPosition {
                knot: knot.into(),
                into: time - f32::from(knot) * 0.1,
            };
            machine.controller.lease(Some(place));
            Some(host)
        },
    );
    assert!(
        (423..=430).contains(&lease.0) && (299.0..=300.1).contains(&lease.1),
        "{lease:?}"
    );
    // A hinge slows the clock when it lags by 0.05 rad, and holds it from 0.15 rad on.
    let stuck = stops(
        "a stuck hinge, once it is stuck",
        &path,
        none,
        |machine, host| {
            let sensor: Sensor = |hinge, command, stands| {
                let angle = command.unwrap_or(stands);
                if hinge == 1 {
                    angle.clamp(-0.7, 0.7)
                } else {
                    angle
                }
            };
            machine.bench(|bench| bench.sensor = Some(sensor));
            Some(host)
        },
    );
    assert!(stuck.1 > 150.0 && stuck.1 < 150.0 + 125.0, "{stuck:?}");
}
