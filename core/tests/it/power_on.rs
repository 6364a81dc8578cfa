//! Is a follower safe from the first millisecond: does it start from no unknown place, whatever it is told and measures?

use foldpath_core::acceptance::SheetView;
use foldpath_core::follower::{
    CheckedOptions, Denial, Fault, Follower, FollowerPosition, Reason, State,
};
use foldpath_core::{GroupId, Interpolation, Membership, Scalar, StarsView};
use foldpath_test_support::{Measure as _, Random};

use crate::alike::{LIMITS, Run};

/// A path begins at 0. The hinges stand at 2 rad, or nobody knows where they stand.
fn starts_from_no_unknown_place<const G: usize>() {
    let mut run = Run::<G>::new();
    run.load(0.0);
    assert!(!run.follower.is_known());
    assert_eq!(run.follower.start(), Err(Denial::Unknown(0)));
    run.measure(|_| 2.0);
    assert_eq!(run.follower.start(), Err(Denial::Jump(0)));
    // One hinge of the last group stands elsewhere, or its sensor fails.
    let odd = 3 * u32::try_from(G).unwrap() - 1;
    for wrong in [0.06, f32::NAN, f32::INFINITY] {
        run.measure(|hinge| if hinge == odd { wrong } else { 0.0 });
        let group = u16::try_from(G - 1).unwrap();
        assert_eq!(run.follower.start(), Err(Denial::Spread(group)), "{wrong}");
    }
    // Each start needs measurements of its own.
    assert_eq!(run.follower.start(), Err(Denial::Unknown(0)));
    assert!(run.follower.angles().is_empty());
    run.still();
    assert_eq!(run.follower.state(), State::Ready);
}

#[test]
fn no_motion_starts_from_an_unknown_place() {
    starts_from_no_unknown_place::<2>();
    starts_from_no_unknown_place::<11>();
    starts_from_no_unknown_place::<94>();
}

#[test]
fn a_measured_sheet_approaches_its_path_slowly() {
    let mut rng = Random::new(85);
    for _ in 0..100 {
        let off = f32::lit(rng.uniform(-0.09, 0.09));
        let mut run = Run::<11>::new();
        run.load(0.5);
        run.measure(|_| 0.5 + off + f32::lit(rng.uniform(-0.01, 0.01)));
        run.follower.start().unwrap();
        let approach = CheckedOptions::<f32>::default().approach;
        assert_eq!(run.follower.reason(), Reason::Approach);
        let first = run.follower.angles()[0];
        assert!((first - 0.5 - off).abs() < 0.011, "{first}");
        let mut ticks = 0;
        while run.follower.reason() == Reason::Approach {
            let moved = run.tick();
            ticks += 1;
            assert_eq!(run.follower.state(), State::Running);
            // The tick that ends the approach begins the path.
            if run.follower.reason() == Reason::Approach {
                assert!(moved <= approach * 1e-3 + 1e-6);
                assert_eq!(run.follower.position(), FollowerPosition::default());
            }
        }
        assert!(ticks as f32 * 1e-3 >= (off.abs() - 0.011) / approach);
        run.until(State::Done);
        assert!((run.follower.angles()[10] - 2.0).abs() < 1e-6);
    }
}

#[test]
fn an_operator_tells_where_the_sheet_stands_and_may_take_it_back() {
    let mut run = Run::<11>::new();
    assert_eq!(run.follower.confirm(), Err(Denial::State));
    run.load(0.5);
    run.follower.confirm().unwrap();
    // Nothing is commanded before the start.
    run.still();
    assert!(run.follower.angles().is_empty() && !run.follower.is_known());
    run.follower.start().unwrap();
    assert_eq!(run.follower.angles(), [0.5; 11]);
    // The word of somebody does not overrule a command.
    assert_eq!(run.follower.confirm(), Err(Denial::State));
    assert_eq!(run.follower.forget(), Err(Denial::Moving));
    run.until(State::Done);
    run.load(0.5);
    assert_eq!(run.follower.start(), Err(Denial::Jump(0)));
    run.follower.forget().unwrap();
    assert_eq!(
        (run.follower.state(), run.follower.is_known()),
        (State::Ready, false)
    );
    run.follower.confirm().unwrap();
    run.follower.start().unwrap();
    run.until(State::Done);
}

/// A sheet with another number of groups is taken without a power cycle, and its place is not known.
#[test]
fn another_sheet_stands_at_an_unknown_place() {
    let mut follower = Box::new(Follower::<f32, 94, 4>::new(CheckedOptions::default()));
    follower
        .stand(&[1.0; 2], FollowerPosition::default(), false)
        .unwrap();
    let limits = [LIMITS; 94];
    let sheet = SheetView {
        interpolation: Interpolation::Hermite,
        limits: &limits,
        stars: StarsView::new(&[], &[], 94).unwrap(),
        closure: 1e-4,
    };
    follower.load(&sheet, FollowerPosition::default()).unwrap();
    assert!(!follower.is_known());
}

/// Somebody's word moves nothing by itself, does not pass a latched stop or hold, and is refused if a hinge was measured
/// elsewhere. Hinges that were measured nearby start from where they were measured.
#[test]
fn a_word_is_no_start() {
    let mut run = Run::<11>::new();
    run.follower.stop(true);
    run.load(0.5);
    assert_eq!(run.follower.confirm(), Err(Denial::Held));
    run.follower.stop(false);
    assert_eq!(run.follower.confirm(), Err(Denial::Held));
    run.follower.resume().unwrap();
    run.follower.hold(Reason::HoldCommand);
    assert_eq!(run.follower.confirm(), Err(Denial::Held));
    run.follower.resume().unwrap();
    for wrong in [0.5 + 0.11, 0.5 - 0.11, f32::NAN] {
        run.measure(|hinge| if hinge == 7 { wrong } else { 0.5 });
        assert_eq!(run.follower.confirm(), Err(Denial::Jump(7)));
        // Old measurements are forgotten.
        (0..1100).for_each(|_| run.still());
    }
    run.measure(|hinge| if hinge % 11 == 7 { 0.44 } else { 0.5 });
    run.follower.confirm().unwrap();
    assert!(run.follower.angles().is_empty());
    // The stop line comes between the word and the start.
    run.follower.stop(true);
    run.follower.stop(false);
    assert_eq!(run.follower.start(), Err(Denial::Held));
    run.follower.resume().unwrap();
    run.follower.start().unwrap();
    let angles = run.follower.angles();
    assert!((angles[7] - 0.44).abs() < 1e-6 && (angles[6] - 0.5).abs() < 1e-6);
    run.until(State::Done);
}

/// The word counts for the path for which it was given.
#[test]
fn a_word_does_not_outlive_its_path() {
    let mut run = Run::<2>::new();
    run.load(0.5);
    run.follower.confirm().unwrap();
    run.load(0.0);
    assert_eq!(run.follower.start(), Err(Denial::Unknown(0)));
    run.follower.confirm().unwrap();
    run.follower.forget().unwrap();
    assert_eq!(run.follower.start(), Err(Denial::Unknown(0)));
}

/// The sheet is moved by hand after it was measured, and measured no more.
#[test]
fn old_measurements_tell_nothing() {
    let mut run = Run::<11>::new();
    run.load(0.5);
    run.measure(|_| 0.5);
    (0..1100).for_each(|_| run.still());
    assert_eq!(run.follower.start(), Err(Denial::Unknown(0)));
    // A sheet that was moved an hour ago stands at one angle now.
    run.measure(|_| 1.5);
    (0..1100).for_each(|_| run.still());
    run.measure(|_| 0.5);
    assert_eq!(run.follower.start(), Ok(()));
}

/// A board measures each hinge once in half a second. All of its measurements count at every time, so that a wrong word is
/// always refused and a start needs no luck.
#[test]
fn a_board_may_take_its_time_to_measure() {
    for wrong in [false, true] {
        let mut run = Run::<11>::new();
        run.load(0.5);
        for tick in 0..3000_u32 {
            let member = Membership {
                group: GroupId(tick / 40 % 11),
                negative: false,
            };
            let angle = if wrong { 1.5 } else { 0.5 };
            run.follower.measure(tick / 40 % 11, member, angle);
            run.still();
            if tick > 500 {
                let mut copy = run.follower.clone();
                let expected = if wrong { Err(Denial::Jump(0)) } else { Ok(()) };
                assert_eq!(copy.confirm(), expected, "{tick}");
                assert_eq!(copy.start(), expected, "{tick}");
            }
        }
    }
}

/// Whatever moves a hinge while nothing is commanded to move: from then on no hinge is commanded, and a motion begins where
/// the hinges are measured.
#[test]
fn a_hinge_that_is_moved_at_rest_is_not_pulled_back() {
    for [under_way, sensor_fails] in [[false; 2], [false, true], [true, false], [true; 2]] {
        let mut run = Run::<2>::new();
        run.load(0.5);
        run.follower.confirm().unwrap();
        run.follower.start().unwrap();
        if under_way {
            (0..300).for_each(|_| _ = run.tick());
            run.follower.stop(true);
            run.follower.stop(false);
        } else {
            run.until(State::Done);
        }
        let stood = run.follower.angles().to_vec();
        // An error of one measurement is no motion.
        run.measure(|hinge| stood[0] + if hinge == 1 { 1.0 } else { 0.0 });
        run.tick();
        run.measure(|_| stood[0]);
        (0..100).for_each(|_| run.still());
        assert_eq!(run.follower.angles(), stood);
        // A sensor that fails hides no other hinge.
        let fails = |hinge| sensor_fails && hinge == 1;
        run.measure(|hinge| {
            if fails(hinge) {
                f32::NAN
            } else {
                stood[0] - 0.16
            }
        });
        (0..21).for_each(|_| _ = run.tick());
        assert!(!run.follower.is_known() && run.follower.angles().is_empty());
        if under_way {
            let stalled = Some(Fault::Stalled(0));
            assert_eq!(run.follower.fault(), stalled);
            run.follower.clear().unwrap();
            run.follower.resume().unwrap();
        }
        run.load(0.5);
        run.measure(|_| 0.41);
        run.follower.start().unwrap();
        let begun = run.follower.angles()[0];
        assert!((begun - 0.41).abs() < 1e-6, "{begun}");
        run.until(State::Done);
    }
}

/// A lost supply takes a hinge farther from its command than brakes explain: nothing pulls it back once the supply returns.
#[test]
fn a_hinge_that_is_taken_away_in_a_motion_is_not_pulled_back() {
    let mut run = Run::<2>::new();
    run.load(0.5);
    run.follower.confirm().unwrap();
    run.follower.start().unwrap();
    (0..500).for_each(|_| _ = run.tick());
    run.measure(|_| 0.2);
    (0..21).for_each(|_| _ = run.tick());
    assert_eq!(run.follower.fault(), Some(Fault::Stalled(0)));
    assert!(run.follower.angles().is_empty());
}

/// Angles that were kept over a reset do not count before the sensors had their time, and not at all against them.
#[test]
fn sensors_come_before_what_was_kept_over_a_reset() {
    for off in [0.0, 0.16] {
        let mut run = Run::<2>::new();
        run.follower
            .stand(&[0.5; 2], FollowerPosition::default(), false)
            .unwrap();
        run.follower.withhold();
        run.load(0.5);
        for _ in 0..500 {
            assert!(!run.follower.is_known() && run.follower.angles().is_empty());
            run.measure(|hinge| 0.5 - if hinge == 1 { off } else { 0.0 });
            run.tick();
        }
        assert_eq!(run.follower.is_known(), off <= 0.0);
        let started = run.follower.start();
        assert_eq!(started.is_ok(), off <= 0.0, "{started:?}");
    }
}

/// Errors of the sensors are not commanded: a motion begins on the path, or straight before it.
#[test]
fn errors_of_sensors_are_not_commanded() {
    let mut rng = Random::new(86);
    for off in [0.0, -0.04, 0.06] {
        let mut run = Run::<11>::new();
        run.load(0.5);
        run.measure(|_| 0.5 + off + f32::lit(rng.uniform(-0.02, 0.02)));
        run.follower.start().unwrap();
        let angles = run.follower.angles();
        // All groups turn alike on this path.
        assert!(angles.iter().all(|angle| (angle - angles[0]).abs() < 1e-6));
        assert!((angles[0] - 0.5 - off).abs() < 0.02, "{angles:?}");
    }
}
