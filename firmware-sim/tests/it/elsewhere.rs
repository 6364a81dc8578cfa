//! Is nothing commanded that is not there, whatever moves the hinges, and do the drives hold or rest as one rule says?

use foldpath_controller::Power;
use foldpath_core::follower::{Fault, Reason, State};
use foldpath_core::wire::driver::Persistence;

use crate::machine::{EXACT, Machine, Path, told};

/// Folds until `millis` milliseconds have passed. Each hinge is measured.
fn folding(path: &Path, millis: u64) -> Machine<2> {
    let mut machine = Machine::<2>::new(1);
    machine.bench(|bench| bench.sensor = Some(EXACT));
    assert_eq!(machine.bench(|bench| bench.conditions.len()), 0);
    let mut host = path.driver(Persistence::None, 7);
    machine.run(Some(&mut host), millis);
    assert!(machine.command().is_some());
    machine
}

/// The supply of the drives is gone while the stop line holds, and a load takes the sheet away. When the supply returns,
/// nothing is commanded, and the drives hold where they are.
#[test]
fn when_the_supply_returns_no_hinge_jumps() {
    let path = Path::new(2);
    let mut machine = folding(&path, 1500);
    machine.bench(|bench| bench.stop = true);
    machine.run(None, 100);
    machine.bench(|bench| bench.stop = false);
    machine.bench(|bench| bench.stands.iter_mut().for_each(|stands| *stands *= 0.1));
    // The sheet is commanded for as long as an error of a sensor may last.
    machine.bench(|bench| bench.follows = false);
    machine.run(None, 25);
    machine.bench(|bench| bench.follows = true);
    machine.run(None, 100);
    let condition = machine.condition();
    assert_eq!((machine.command(), condition.known), (None, false));
    assert_eq!((condition.power, condition.stopped), (Power::Hold, true));
    assert!(matches!(condition.fault, Some(Fault::Stalled(_))));
}

/// A hand turns hinges of a sheet that has come to the end of its path.
#[test]
fn a_hinge_that_a_hand_turns_is_let_be() {
    let path = Path::new(2);
    let mut machine = folding(&path, 4000);
    assert_eq!(machine.condition().state, State::Done);
    machine.bench(|bench| (bench.stands[3] += 0.16, bench.follows = false));
    machine.run(None, 25);
    machine.bench(|bench| bench.follows = true);
    machine.run(None, 25);
    let condition = machine.condition();
    assert_eq!((machine.command(), condition.known), (None, false));
    assert_eq!((condition.state, condition.fault), (State::Done, None));
    assert_eq!(condition.power, Power::Hold);
}

/// A sensor that was heard and falls silent holds the motion, and its hinge is named. A hinge without a sensor does not.
#[test]
fn a_sensor_that_falls_silent_holds_the_motion() {
    let path = Path::new(2);
    for silent in [false, true] {
        let mut machine = Machine::<2>::new(1);
        machine.bench(|bench| bench.sensor = Some(EXACT));
        if !silent {
            machine.bench(|bench| bench.deaf = vec![4]);
        }
        let mut host = path.driver(Persistence::None, 7);
        machine.run(Some(&mut host), 400);
        machine.bench(|bench| bench.deaf = vec![4]);
        machine.run(Some(&mut host), 4500);
        let condition = machine.condition();
        let hinges = path.hinges.len();
        if silent {
            let stalled = Reason::Fault(Fault::Stalled(4));
            assert_eq!((told(&host).reason, condition.reason), (stalled, stalled));
        } else {
            assert_eq!(
                (condition.state, condition.measured),
                (State::Done, hinges - 1)
            );
        }
    }
}

/// A controller ignores the record that another image has left over a reset.
#[test]
fn the_record_of_another_image_does_not_count() {
    let path = Path::new(2);
    for image in [0, 5] {
        let mut machine = Machine::<2>::new(1);
        let mut host = path.driver(Persistence::None, 7).confirming();
        machine.run(Some(&mut host), 1500);
        assert!(machine.command().is_some());
        machine.image = image;
        machine.reset();
        let mut host = path.driver(Persistence::Resume, 8);
        machine.run(Some(&mut host), 500);
        assert_eq!(machine.command().is_some(), image == 0);
        let rests = machine.condition().power == Power::Rest;
        assert_eq!(rests, image != 0);
    }
}

/// The drives rest until a motion starts, and again once a host asks to forget where the sheet stands.
#[test]
fn drives_rest_before_the_first_motion_and_hold_from_then_on() {
    let path = Path::new(2);
    let mut machine = Machine::<2>::new(1);
    machine.run(None, 20);
    assert_eq!(machine.condition().power, Power::Rest);
    let mut host = path.driver(Persistence::None, 7);
    machine.run(Some(&mut host), 300);
    // Loaded, and nobody knows where it stands.
    assert_eq!(
        (machine.command(), machine.condition().power),
        (None, Power::Rest)
    );
    let mut host = path.driver(Persistence::None, 8).confirming();
    machine.run(Some(&mut host), 4000);
    assert_eq!(machine.condition().state, State::Done);
    let conditions = machine.bench(|bench| core::mem::take(&mut bench.conditions));
    machine.bench(|bench| bench.ticks = 0);
    let first = conditions.iter().position(|one| one.commanded > 0).unwrap();
    assert!(
        conditions[..first]
            .iter()
            .all(|one| one.power == Power::Rest)
    );
    assert!(
        conditions[first..]
            .iter()
            .all(|one| one.power == Power::Hold)
    );
}
