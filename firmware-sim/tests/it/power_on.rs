//! Is a board safe from the first millisecond, with 2, 11 and 94 groups: after power-on, and against bytes that were
//! recorded or forged?

use foldpath_controller::Settings;
use foldpath_core::follower::{Denial, Reason, State};
use foldpath_core::wire::driver::Persistence;
use foldpath_core::wire::message::ItemRefusal;

use crate::machine::{EXACT, Machine, Path, Sensor, told};
use crate::path::{BOARD, settings};

/// Power is cut and comes back at 20 moments. Nothing moves, whether the host goes on or begins anew, and whatever the
/// sensors say; an operator's word lets the fold begin once the sheet is flat again.
fn after_power_on_nothing_moves<const G: usize>() {
    let path = Path::new(G);
    let mut nonce = 1;
    for moment in 0..20 {
        let mut machine = Machine::<G>::new(nonce);
        let mut host = path.driver(Persistence::None, 7).confirming();
        machine.run(Some(&mut host), 600 + 75 * moment);
        let stood = machine.command().unwrap();
        assert!(stood > 0.15, "{stood}");
        for (persistence, sensor) in [
            (Persistence::Resume, None),
            (Persistence::None, None),
            (Persistence::Always, Some(EXACT)),
            (
                Persistence::None,
                Some((|hinge, _, _| if hinge == 2 { f32::NAN } else { 0.0 }) as Sensor),
            ),
        ] {
            nonce += 1;
            machine.cut_power(nonce);
            machine.bench(|bench| bench.sensor = sensor);
            let mut host = path.driver(persistence, 8);
            for _ in 0..50 {
                machine.run(Some(&mut host), 10);
                assert_eq!(machine.command(), None);
                // Every tick, the board is told that no hinge has a command.
                assert_eq!(machine.condition().commanded, 0);
            }
            let report = told(&host);
            assert_eq!((report.state, report.known), (State::Ready, false));
            let denied = host.sender().answer().unwrap().unwrap_err();
            let expected = match sensor {
                None => matches!(denied, Denial::Unknown(0)),
                Some(_) => matches!(denied, Denial::Spread(_) | Denial::Jump(0)),
            };
            assert!(expected, "{denied:?}");
        }
        // With sensors, an operator's word that is wrong is refused.
        machine.cut_power(nonce + 1);
        machine.bench(|bench| bench.sensor = Some(EXACT));
        let mut host = path.driver(Persistence::None, 9).confirming();
        machine.run(Some(&mut host), 90);
        assert_eq!(host.sender().answer(), Some(Err(Denial::Jump(0))));
        machine.run(Some(&mut host), 400);
        assert_eq!((told(&host).state, machine.command()), (State::Ready, None));
        if moment % 10 == 0 {
            machine.bench(|bench| bench.stands.fill(0.0));
            let mut host = path.driver(Persistence::None, 10).confirming();
            machine.run(Some(&mut host), 3500);
            assert_eq!(machine.condition().state, State::Done);
        }
        nonce += 2;
    }
    let mut machine = Machine::<G>::new(nonce);
    machine.bench(|bench| bench.sensor = Some(|_, command, _| command.unwrap_or(0.03)));
    let mut host = path.driver(Persistence::None, 9);
    machine.run(Some(&mut host), 200);
    // The hinges are measured at ±0.03, which is no one angle of a group.
    assert_eq!(machine.command(), None);
    machine.run(
        Some(&mut path.driver(Persistence::None, 10).confirming()),
        3500,
    );
    assert_eq!(machine.condition().state, State::Done);
}

#[test]
fn after_power_on_nothing_moves_from_an_unknown_place() {
    after_power_on_nothing_moves::<2>();
    after_power_on_nothing_moves::<11>();
    after_power_on_nothing_moves::<94>();
}

/// All bytes of a session that folded the sheet come again, at a board that was just switched on and at one that was
/// reset. They fold the sheet only if the source of nonces gave the same number at both power-ons, which a board has to
/// exclude.
#[test]
fn recorded_bytes_do_nothing_in_another_run() {
    let path = Path::new(2);
    let mut machine = Machine::<2>::new(1);
    let mut host = path.driver(Persistence::None, 7).confirming();
    machine.run(Some(&mut host), 3500);
    assert_eq!(told(&host).state, State::Done);
    let recorded = machine.recorded.clone();
    let replay = |machine: &mut Machine<2>| {
        let mut before = recorded[0].0;
        for (time, bytes) in &recorded {
            // In the rhythm in which they came.
            let passed = time - before;
            before = *time;
            machine.run(None, passed.div_ceil(1000));
            machine.bench(|bench| bench.received.extend(bytes));
        }
    };
    for nonce in [2, 1 << 32, u64::MAX] {
        let mut fresh = Machine::<2>::new(nonce);
        replay(&mut fresh);
        assert_eq!(
            (fresh.condition().state, fresh.command()),
            (State::Idle, None)
        );
    }
    let mut same = Machine::<2>::new(1);
    replay(&mut same);
    assert_eq!(same.condition().state, State::Done);
    // A warm reset leaves the hardware's number as it was.
    machine.reset();
    replay(&mut machine);
    assert_eq!(machine.condition().state, State::Idle);
}

/// A host asks for limits that no board has, and for a leap of 100 rad in a millisecond.
#[test]
fn no_message_widens_the_limits_of_the_board() {
    for (lower, upper, speed) in [
        (-1e6, 1e6, f32::INFINITY),
        (-3.0, 3.0, 1e9),
        (5.0, 9.0, 1.0),
    ] {
        let mut path = Path::new(2);
        for limits in &mut path.limits {
            (limits.lower, limits.upper, limits.speed) = (lower, upper, speed);
        }
        // From 0 to 2 rad in a millisecond.
        path.spans = path.spans.iter().map(|span| span * 5e-4).collect();
        path.rates = path.rates.iter().map(|_| 2e3).collect();
        let mut machine = Machine::<2>::new(1);
        let mut host = path.driver(Persistence::None, 7).confirming();
        machine.run(Some(&mut host), 1000);
        assert!(told(&host).refused.is_some(), "{:?}", told(&host));
        assert!(machine.command().is_none_or(|angle| angle.abs() < 1e-6));
    }
}

/// A board that asks for essential vertices takes no sheet without.
/// A source that gives the same number twice does not vary: what somebody recorded could come again. Hinges can be watched.
#[test]
fn without_a_nonce_that_varies_nothing_moves() {
    for (draws, denied) in [
        ([0, 0], true),
        ([u64::MAX; 2], true),
        ([7, 7], true),
        ([7, 8], false),
        ([1 << 32, 0], false),
    ] {
        let drawn = Settings::new(draws, |_| BOARD);
        assert_eq!(drawn.nonce.is_none(), denied);
        let mut machine = Machine::<2>::with_settings(Settings {
            closed: false,
            ..drawn
        });
        let path = Path::new(2);
        let mut host = path.driver(Persistence::None, 7).confirming();
        machine.run(Some(&mut host), 4000);
        let report = told(&host);
        if denied {
            assert_eq!(
                (report.state, report.denied),
                (State::Ready, Some(Denial::Nonce))
            );
            assert_eq!(machine.command(), None);
        } else {
            assert!(host.is_done());
        }
    }
}

#[test]
fn a_sheet_with_vertices_needs_its_spokes() {
    let path = Path::new(2);
    let mut machine = Machine::<2>::with_settings(Settings {
        closed: true,
        ..settings(1)
    });
    let mut host = path.driver(Persistence::None, 7).confirming();
    machine.run(Some(&mut host), 300);
    assert_eq!(told(&host).refused, Some(ItemRefusal::Stars));
}

/// 94 groups take four items a setpoint, and the controller tells its room.
#[test]
fn setpoints_of_any_number_of_groups_come_in_pieces() {
    let path = Path::new(94);
    let mut machine = Machine::<94>::new(1);
    let mut host = path.driver(Persistence::None, 7).confirming();
    assert_eq!(path.items().pieces(), 4);
    machine.run(Some(&mut host), 3500);
    assert_eq!(told(&host).state, State::Done);
    assert_eq!((host.setpoints(), host.is_done()), (21, true));
    let capacity = host.sender().capacity().unwrap();
    assert_eq!(
        (capacity.groups, capacity.hinges, capacity.knots),
        (94, 282, 16)
    );
    assert_eq!(host.sender().repeated(), 0);
}

/// `Stand` commands nothing by itself, and is denied while something holds.
#[test]
fn a_word_moves_nothing_and_passes_no_stop() {
    let path = Path::new(2);
    let mut machine = Machine::<2>::new(1);
    machine.bench(|bench| bench.stop = true);
    let mut host = path.driver(Persistence::None, 7).confirming();
    machine.run(Some(&mut host), 200);
    machine.bench(|bench| bench.stop = false);
    machine.run(Some(&mut host), 300);
    assert_eq!(host.sender().answer(), Some(Err(Denial::Held)));
    assert_eq!((machine.command(), told(&host).known), (None, false));
    assert_eq!(told(&host).reason, Reason::StopLine);
}
