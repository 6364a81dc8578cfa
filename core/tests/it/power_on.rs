//! Is a follower safe from the first millisecond: does it move from no unknown place, farther in no tick than it may, and
//! never while a stop or a fault is latched?

use foldpath_core::acceptance::{Setpoint, SheetView};
use foldpath_core::follower::{Denial, Fault, Follower, FollowerPosition, Options, Reason, State};
use foldpath_core::{GroupId, GroupLimits, Interpolation, Membership, Node, Scalar, StarsView};
use foldpath_test_support::Random;

const TICK: u64 = 1000;
const LIMITS: GroupLimits = GroupLimits {
    lower: -3.2,
    upper: 3.2,
    speed: 2.0,
    acceleration: 1e4,
};

/// A follower of `G` groups without vertices. All groups turn alike, at 1 rad/s from `begin`.
struct Run<const G: usize> {
    follower: Box<Follower<f32, G, 16>>,
    limits: [GroupLimits; G],
    now: u64,
}

impl<const G: usize> Run<G> {
    fn new() -> Self {
        Self {
            follower: Box::new(Follower::new(Options::default())),
            limits: [LIMITS; G],
            now: 0,
        }
    }

    fn load(&mut self, begin: f32) {
        let sheet = SheetView {
            interpolation: Interpolation::Hermite,
            limits: &self.limits,
            stars: StarsView::new(&[], &[], G).unwrap(),
            closure: 1e-4,
        };
        let place = FollowerPosition::default();
        self.follower.load(&sheet, place).unwrap();
        for number in 0..16_u8 {
            let time = f32::from(number) * 0.1;
            let node = Node {
                angle: begin + time,
                rate: 1.0,
                weight: [1.0, 0.0],
            };
            let setpoint = Setpoint {
                number: number.into(),
                time,
                last: number == 15,
                nodes: core::iter::repeat_n(node, G).collect(),
            };
            self.follower.accept(&sheet, setpoint).unwrap();
        }
    }

    /// Measures three hinges of each group, of which one turns the opposite way, at these angles.
    fn measure(&mut self, mut angle: impl FnMut(u32) -> f32) {
        for hinge in 0..3 * u32::try_from(G).unwrap() {
            let membership = Membership {
                group: GroupId(hinge % u32::try_from(G).unwrap()),
                negative: hinge.is_multiple_of(3),
            };
            let angle = membership.apply(angle(hinge));
            self.follower.measure(hinge, membership, angle);
        }
    }

    /// Ticks, and returns the largest angle by which a group moved, radians.
    fn tick(&mut self) -> f32 {
        let before = self.follower.angles().to_vec();
        self.now += TICK;
        self.follower.heard(self.now);
        self.follower.tick(self.now);
        let moved = before.iter().zip(self.follower.angles());
        moved.fold(0.0, |most, (a, b)| most.max((a - b).abs()))
    }

    /// Ticks, and asserts that nothing moves.
    fn still(&mut self) {
        assert_eq!(self.tick().to_bits(), 0);
    }

    fn until(&mut self, state: State) {
        while self.follower.state() != state {
            assert!(self.tick() <= LIMITS.speed * 1e-3 + 1e-5);
            assert!(self.now < 20_000_000, "{:?}", self.follower.reason());
        }
    }
}

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
        let approach = Options::<f32>::default().approach;
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
    let mut follower = Box::new(Follower::<f32, 94, 4>::new(Options::default()));
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

/// The path time stays below a bound from outside, reaches it at rest, and goes on when it grows.
#[test]
fn a_lease_bounds_the_path_time() {
    for seed in 0..100 {
        let mut rng = Random::new(seed);
        let mut run = Run::<2>::new();
        run.load(0.0);
        run.follower.confirm().unwrap();
        let mut lease = 0.0;
        run.follower.lease(Some(lease));
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
            run.follower.lease(Some(lease));
        }
        run.follower.lease(Some(0.0));
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
    run.follower.hold(Reason::Asked);
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
    run.follower.lease(Some(0.0));
    run.follower.start().unwrap();
    (0..300).for_each(|_| run.still());
    assert_eq!(
        (run.follower.state(), run.follower.reason()),
        (State::Holding, Reason::Lease)
    );
    run.follower.lease(Some(0.1));
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
    assert!(run.follower.is_astray());
    let mut again = Run::<2>::new();
    again.follower.stand(&angles, place, true).unwrap();
    again.load(0.5);
    again.follower.start().unwrap();
    assert_eq!(again.follower.angles(), angles);
    again.until(State::Done);
    assert!(!again.follower.is_astray());
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
                run.follower.drive(members, |hinge, _, command| {
                    let command = command.unwrap();
                    let angle = if hinge == stuck {
                        command.min(0.3)
                    } else {
                        command
                    };
                    ((turn + hinge) % period == 0).then_some(angle)
                });
                assert!(run.now < 4_000_000, "{:?}", run.follower.reason());
            }
            assert_eq!(run.follower.reason(), Reason::Fault(Fault::Stalled(stuck)));
        }
    }
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
