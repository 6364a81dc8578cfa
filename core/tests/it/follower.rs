//! Does the follower keep to its path, its limits and the closure of the sheet, whatever slows or holds it? The path is
//! Miura's fold, whose motion is known in closed form.

use core::f64::consts::PI;

use foldpath_core::acceptance::{Refusal, Setpoint, SheetView};
use foldpath_core::follower::{
    CheckedOptions, Denial, Fault, Follower, FollowerPosition, Options, Reason, State,
};
use foldpath_core::path_clock::ClockLimits;
use foldpath_core::trajectory::TrajectoryView;
use foldpath_core::{
    GroupId, GroupLimits, HalfAngle, Interpolation, Membership, Node, Objective, Scalar, StarsView,
};
use foldpath_test_support::stars::{Stars, miura, miura_angles};
use foldpath_test_support::{Measure as _, Random, cast, takes};

/// `STEP`: seconds between two knots. `KNOTS`: number of knots of the path. `TICK`: microseconds of a tick.
const STEP: f64 = 0.02;
const KNOTS: u32 = 101;
const TICK: u64 = 1000;
/// Largest fold angle of the path, radians.
const TOP: f64 = 2.6;
/// Largest closure residual allowed: the residual of the cubics between knots, and rounding in `f32`.
const CLOSURE: f64 = 4e-6;
const LIMITS: GroupLimits<f64> = GroupLimits {
    lower: -0.1,
    upper: 2.7,
    speed: 2.5,
    acceleration: 8.0,
};

type Miura<T> = Follower<T, 2, 16>;

/// Returns the angles (radians) and rates of both groups at `time`, by the closed form. The path takes two seconds.
fn closed_form(time: f64) -> [[f64; 2]; 2] {
    let duration = STEP * f64::from(KNOTS - 1);
    let (sin, cos) = (PI * time / duration).sin_cos();
    let [major, minor] = miura_angles(60.0, TOP * (1.0 - cos) / 2.0);
    let rate = TOP * sin / 2.0 * PI / duration;
    let [t, u] = [major, minor].map(|angle| (angle / 2.0).tan());
    [
        [major, minor],
        [rate, rate * 0.5 * (1.0 + t * t) / (1.0 + u * u)],
    ]
}

fn setpoint<T: Scalar>(number: u32) -> Setpoint<T, 2> {
    let time = f64::from(number) * STEP;
    let [angles, rates] = closed_form(time);
    let node = |group: usize| Node {
        angle: T::lit(angles[group]),
        rate: T::lit(rates[group]),
        weight: cast([1.0, 0.0]),
    };
    Setpoint {
        number,
        span: T::lit(STEP),
        last: number + 1 == KNOTS,
        nodes: heapless::Vec::from_array([node(0), node(1)]),
    }
}

/// A sheet that owns its memory.
struct Sheet<T> {
    stars: Stars<T>,
    limits: [GroupLimits<T>; 2],
}

impl<T: Scalar> Sheet<T> {
    fn new() -> Self {
        let limits = GroupLimits {
            lower: T::lit(LIMITS.lower),
            upper: T::lit(LIMITS.upper),
            speed: T::lit(LIMITS.speed),
            acceleration: T::lit(LIMITS.acceleration),
        };
        Self {
            stars: miura(60.0, false, false),
            limits: [limits; 2],
        }
    }

    fn view(&self) -> SheetView<'_, T> {
        SheetView {
            interpolation: Interpolation::Hermite,
            limits: &self.limits,
            stars: self.stars.view(),
            closure: T::lit(CLOSURE),
        }
    }

    fn residual(&self, angles: &[T]) -> f64 {
        let mut scratch = [HalfAngle::default(); 2];
        let value = Objective::Max.value(self.stars.view(), angles, &mut scratch);
        value.unwrap().to_f64() / 2_f64.sqrt()
    }
}

/// Returns a sheet of one group without vertices.
fn lone<'a, T: Scalar>(
    interpolation: Interpolation,
    limits: &'a [GroupLimits<T>; 1],
    none: &'a Stars<T>,
) -> SheetView<'a, T> {
    SheetView {
        interpolation,
        limits,
        stars: none.view(),
        closure: T::zero(),
    }
}

/// A follower, and the host that feeds it with setpoints.
struct Run<T: Scalar> {
    sheet: Sheet<T>,
    follower: Miura<T>,
    now: u64,
    /// `host`: `true` while the follower hears the host. `sent`: number of knots that the host sends.
    host: bool,
    sent: u32,
}

impl<T: Scalar> Run<T> {
    fn ready(options: CheckedOptions<T>) -> Self {
        let mut run = Self {
            sheet: Sheet::new(),
            follower: Follower::new(options),
            now: 0,
            host: true,
            sent: KNOTS,
        };
        run.follower
            .load(&run.sheet.view(), FollowerPosition::default())
            .unwrap();
        run.feed();
        run.follower.confirm().unwrap();
        run
    }

    fn started() -> Self {
        let mut run = Self::ready(CheckedOptions::default());
        run.follower.start().unwrap();
        run
    }

    fn feed(&mut self) {
        while self.follower.room() > 0 && self.follower.next() < self.sent {
            let next = setpoint(self.follower.next());
            self.follower.accept(&self.sheet.view(), next).unwrap();
        }
    }

    /// Makes one tick and asserts that the sheet is closed and no faster than its limits.
    fn tick(&mut self) {
        self.now += TICK;
        if self.host {
            self.follower.heard(self.now);
            self.feed();
        }
        self.follower.tick(self.sheet.stars.view(), self.now);
        let angles = self.follower.angles();
        if self.follower.is_known() {
            assert!(self.sheet.residual(angles) <= CLOSURE, "{angles:?}");
        }
        for (rate, limits) in self.follower.rates().iter().zip(&self.sheet.limits) {
            assert!(rate.abs() <= limits.speed);
        }
    }

    fn ticks(&mut self, count: usize) {
        (0..count).for_each(|_| self.tick());
    }

    /// Ticks until the follower reaches `state`.
    fn until(&mut self, state: State) {
        for _ in 0..20_000 {
            self.tick();
            if self.follower.state() == state {
                return;
            }
        }
        panic!("{state:?} is never reached: {:?}", self.follower.reason());
    }

    fn time(&self) -> f64 {
        let FollowerPosition { knot, into } = self.follower.position();
        f64::from(knot) * STEP + into.to_f64()
    }

    fn bits(&self) -> Vec<u64> {
        let angles = self.follower.angles().iter();
        angles.map(|angle| angle.to_f64().to_bits()).collect()
    }
}

fn follows_the_whole_path<T: Scalar>() {
    let mut run = Run::<T>::started();
    let mut before = closed_form(0.0)[0];
    let mut rates_before = [0.0; 2];
    // Ticks of the whole path: its own 2 s, 1/4 s more because rising and braking run at half speed on average, and a
    // few ticks to spare.
    let dt = 1e-3;
    for tick in 0..2250 + 4 {
        run.tick();
        let [exact, _] = closed_form(run.time());
        for (group, angle) in run.follower.angles().iter().enumerate() {
            let angle = angle.to_f64();
            assert!(
                (angle - exact[group]).abs() < 2e-6,
                "{tick} {angle} {exact:?}"
            );
            let rate = (angle - before[group]) / dt;
            let noise = 4.0 * T::EPSILON.to_f64() / dt;
            assert!(rate.abs() <= LIMITS.speed + noise, "{tick} {rate}");
            let bend = (rate - rates_before[group]) / dt;
            let most = LIMITS.acceleration + LIMITS.speed * 4.0;
            assert!(bend.abs() <= most + 2.0 * noise / dt, "{tick} {bend}");
            (before[group], rates_before[group]) = (angle, rate);
        }
    }
    assert_eq!(run.follower.state(), State::Done);
    let last: Setpoint<T, 2> = setpoint(KNOTS - 1);
    let last = last.nodes.iter().map(|node| node.angle.to_f64().to_bits());
    assert!(run.bits().into_iter().eq(last));
    assert_eq!(
        run.follower.position(),
        FollowerPosition {
            knot: KNOTS - 1,
            into: T::zero()
        }
    );
}

#[test]
fn the_whole_path_is_followed_to_its_end() {
    follows_the_whole_path::<f32>();
    follows_the_whole_path::<f64>();
}

#[test]
fn what_is_commanded_lies_on_the_trajectory() {
    let knots: Vec<Setpoint<f32, 2>> = (0..KNOTS).map(setpoint).collect();
    let mut spans: Vec<f32> = knots.iter().map(|knot| knot.span).collect();
    spans[0] = 0.0;
    let of = |part: fn(&Node<f32>) -> f32| -> Vec<f32> {
        knots
            .iter()
            .flat_map(|knot| knot.nodes.iter().map(part))
            .collect()
    };
    let (angles, rates) = (of(|node| node.angle), of(|node| node.rate));
    let view =
        TrajectoryView::new(Interpolation::Hermite, 2, &spans, &angles, &rates, &[]).unwrap();
    let mut run = Run::<f32>::started();
    while run.follower.state() != State::Done {
        run.tick();
        let place = run.follower.position();
        let FollowerPosition { knot, into } = place;
        let mut sampled = [0.0; 2];
        view.sample(place, &mut sampled);
        let pairs = sampled.iter().zip(run.follower.angles());
        for (sampled, commanded) in pairs {
            assert!((sampled - commanded).abs() < 1e-6, "at {place:?}");
        }
        let from = view.knot(knot as usize).unwrap();
        for (group, commanded) in run.follower.rates().iter().enumerate() {
            let sampled = match view.curve(knot as usize, group) {
                Some(curve) => {
                    let span = spans[knot as usize + 1];
                    curve.derivatives(into / span)[0] / span
                }
                None => from.rates[group],
            };
            let rate = run.follower.rate();
            assert!((sampled * rate - commanded).abs() < 1e-4, "at {place:?}");
        }
    }
}

#[test]
fn hinges_turn_as_their_groups_and_signs_say() {
    let mut run = Run::<f64>::started();
    run.ticks(900);
    let member = |group, negative| Membership {
        group: GroupId(group),
        negative,
    };
    let [[major, minor], _] = closed_form(run.time());
    let hinge = |group, negative| run.follower.hinge(member(group, negative)).unwrap();
    assert!((hinge(0, false) - major).abs() < 1e-6);
    assert!((hinge(1, true) + minor).abs() < 1e-6);
    assert_eq!(run.follower.hinge(member(2, false)), None);
}

#[test]
fn an_empty_queue_stops_at_its_last_setpoint_and_goes_on_with_the_next() {
    for sent in [1, 2, 3, 17, 50, 99] {
        let mut run = Run::<f32>::ready(CheckedOptions::default());
        // The queue was filled before; whatever it holds counts as sent.
        run.sent = sent.max(run.follower.next());
        let end = run.sent - 1;
        run.follower.start().unwrap();
        let mut rate = 0.0;
        for _ in 0..4000 {
            run.tick();
            assert!((run.follower.rate() - rate).abs() <= 4e-3 * 1.01, "{rate}");
            rate = run.follower.rate();
            assert!(run.time() <= f64::from(end) * STEP + 1e-9);
        }
        assert_eq!(run.follower.state(), State::Holding);
        assert_eq!(run.follower.reason(), Reason::Underrun);
        assert_eq!(
            run.follower.position(),
            FollowerPosition {
                knot: end,
                into: 0.0
            }
        );
        let last: Setpoint<f32, 2> = setpoint(end);
        assert!(
            run.follower
                .angles()
                .iter()
                .eq(last.nodes.iter().map(|node| &node.angle))
        );
        assert!(run.follower.rates().iter().all(|rate| rate.to_bits() == 0));
        run.sent = KNOTS;
        run.until(State::Done);
    }
}

#[test]
fn a_silent_host_holds_until_it_asks_to_go_on() {
    let mut run = Run::<f32>::ready(
        Options {
            silence: 250_000,
            ..Options::default()
        }
        .checked()
        .unwrap(),
    );
    run.follower.start().unwrap();
    run.ticks(500);
    run.host = false;
    run.ticks(248);
    assert_eq!(run.follower.state(), State::Running);
    run.ticks(5);
    assert_eq!(run.follower.state(), State::Holding);
    assert_eq!(run.follower.reason(), Reason::Silence);
    run.ticks(300);
    let stands = run.bits();
    run.host = true;
    run.ticks(100);
    assert_eq!(run.bits(), stands);
    run.follower.resume().unwrap();
    run.until(State::Done);
}

#[test]
fn a_soft_stop_brakes_along_the_path() {
    let mut run = Run::<f64>::started();
    run.ticks(1000);
    let before = run.time();
    run.follower.hold(Reason::HoldCommand);
    run.ticks(300);
    // Braking from the full rate 1 at 4 per second passes 1/(2 · 4) = 1/8 s of the path.
    assert!((run.time() - before - 0.125).abs() < 1e-9);
    assert_eq!(run.follower.reason(), Reason::HoldCommand);
    assert_eq!(
        run.follower
            .load(&run.sheet.view(), FollowerPosition::default()),
        Ok(())
    );
    assert_eq!(run.follower.state(), State::Ready);
}

#[test]
fn a_moving_sheet_takes_no_other_path() {
    let mut run = Run::<f64>::started();
    run.ticks(10);
    assert_eq!(
        run.follower
            .load(&run.sheet.view(), FollowerPosition::default()),
        Err(Denial::Moving)
    );
    assert_eq!(run.follower.unload(), Err(Denial::Moving));
    assert_eq!(run.follower.start(), Err(Denial::State));
    // A follower that is started but has not moved yet refuses as well.
    let mut run = Run::<f64>::started();
    assert_eq!(run.follower.unload(), Err(Denial::Moving));
    run.follower.hold(Reason::HoldCommand);
    assert_eq!(run.follower.unload(), Ok(()));
}

#[test]
fn the_stop_line_stops_at_once_and_stays() {
    let mut rng = Random::new(81);
    for _ in 0..100 {
        let mut run = Run::<f32>::started();
        run.ticks(1 + rng.below(2200));
        let stands = run.bits();
        run.follower.stop(true);
        assert_eq!(run.follower.rate().to_bits(), 0);
        run.ticks(50);
        assert_eq!(run.follower.resume(), Err(Denial::Held));
        run.follower.stop(false);
        run.ticks(50);
        assert_eq!(run.bits(), stands);
        assert_eq!(
            (run.follower.state(), run.follower.reason()),
            (State::Holding, Reason::StopLine)
        );
        run.follower.resume().unwrap();
        run.tick();
        let first = run.follower.angles().iter().zip(&stands);
        for (angle, stood) in first {
            let moved = (f64::from(*angle) - f64::from_bits(*stood)).abs();
            assert!(moved < LIMITS.speed * 4e-3 * 1e-3, "{moved}");
        }
        run.until(State::Done);
    }
}

#[test]
fn the_stop_line_is_heard_in_every_state() {
    let mut idle = Miura::<f32>::new(CheckedOptions::default());
    idle.stop(true);
    idle.stop(false);
    let sheet = Sheet::new();
    idle.load(&sheet.view(), FollowerPosition::default())
        .unwrap();
    idle.accept(&sheet.view(), setpoint(0)).unwrap();
    assert_eq!(idle.confirm(), Err(Denial::Held));
    assert_eq!(idle.start(), Err(Denial::Held));
    idle.resume().unwrap();
    idle.confirm().unwrap();
    assert_eq!((idle.state(), idle.start()), (State::Ready, Ok(())));
    let mut done = Run::<f32>::started();
    done.until(State::Done);
    done.follower.stop(true);
    assert_eq!(
        (done.follower.state(), done.follower.reason()),
        (State::Done, Reason::StopLine)
    );
    assert_eq!(done.follower.resume(), Err(Denial::Held));
}

/// Measures one hinge that follows its command with at most the given speed, radians a tick, and that sticks at an
/// angle. Returns the rates of the path clock, tick by tick.
fn lagging(run: &mut Run<f32>, speed: f32, sticks: f32) -> Vec<f32> {
    let member = Membership {
        group: GroupId(1),
        negative: true,
    };
    let mut at = 0.0_f32;
    let mut rates = Vec::new();
    for _ in 0..20_000 {
        run.tick();
        let command = run.follower.hinge(member).unwrap();
        let step = (command - at).clamp(-speed, speed);
        at = (at + step).max(-sticks);
        run.follower.measure(7, member, at);
        run.follower.measure(
            3,
            Membership {
                negative: false,
                ..member
            },
            -command,
        );
        rates.push(run.follower.rate());
        if matches!(run.follower.state(), State::Done | State::Faulted) {
            break;
        }
    }
    rates
}

#[test]
fn a_slow_hinge_slows_all_and_a_stalled_one_is_named() {
    let quick = lagging(&mut Run::started(), 1.0, 9.0).len();
    let mut run = Run::started();
    let rates = lagging(&mut run, 4e-4, 9.0);
    assert_eq!(run.follower.state(), State::Done);
    assert!(rates.len() > quick + 1000, "{} {quick}", rates.len());
    assert!(
        rates[1000..rates.len() - 400]
            .iter()
            .all(|rate| *rate > 0.05)
    );

    let mut run = Run::started();
    lagging(&mut run, 1.0, 0.8);
    assert_eq!(
        (run.follower.state(), run.follower.reason()),
        (State::Faulted, Reason::Fault(Fault::Stalled(7)))
    );
    let command = run.follower.angles()[1];
    let options = Options::<f32>::default();
    let held = 0.8 + options.most_lag;
    let braked = f32::lit(LIMITS.speed) / (2.0 * options.clock.brake);
    assert!((held..held + braked).contains(&command), "{command}");
    // The hinge is not where it is commanded to be. It is no longer commanded, nor is any other.
    run.ticks(100);
    assert!(!run.follower.is_known() && run.follower.angles().is_empty());
    let refused = run.follower.accept(&run.sheet.view(), setpoint(60));
    assert_eq!(refused, Err(Refusal::State));
    assert_eq!(
        run.follower.resume().map(|()| run.follower.state()),
        Ok(State::Faulted)
    );
    run.follower.clear().unwrap();
    assert_eq!(run.follower.state(), State::Idle);
}

#[test]
fn a_hinge_that_catches_up_is_forgiven_and_a_sensor_without_a_number_is_not() {
    let member = Membership {
        group: GroupId(0),
        negative: false,
    };
    let mut run = Run::<f32>::started();
    run.ticks(700);
    let command = run.follower.hinge(member).unwrap();
    run.follower.measure(2, member, command + 0.2);
    run.ticks(400);
    assert_eq!(
        (run.follower.state(), run.follower.reason()),
        (State::Holding, Reason::Lag(2))
    );
    assert_eq!(run.follower.rate().to_bits(), 0);
    let command = run.follower.hinge(member).unwrap();
    run.follower.measure(2, member, command);
    run.tick();
    assert_eq!(
        (run.follower.state(), run.follower.reason()),
        (State::Running, Reason::None)
    );
    // The hinge lags several times, each time for less than the time after which a lag is a fault, and follows for as
    // long.
    for _ in 0..3 {
        run.follower.measure(2, member, command - 0.25);
        run.ticks(600);
        assert_eq!(run.follower.reason(), Reason::Lag(2));
        let command = run.follower.hinge(member).unwrap();
        run.follower.measure(2, member, command);
        let free = run.follower.clone();
        run.ticks(2);
        assert_eq!(run.follower.reason(), Reason::None);
        // Nobody measures the hinge while the command moves on.
        run.follower = free;
        run.follower.hold(Reason::HoldCommand);
        run.ticks(2);
        run.follower.resume().unwrap();
    }
    assert_eq!(run.follower.state(), State::Running);
    run.follower.measure(5, member, f32::NAN);
    run.ticks(1001);
    assert_eq!(
        (run.follower.state(), run.follower.reason()),
        (State::Faulted, Reason::Fault(Fault::Stalled(5)))
    );
}

/// A flaw of a setpoint: its name, the function that makes it, and the refusal that it must cause.
type Bad = (&'static str, fn(&mut Setpoint<f64, 2>), Refusal);

#[test]
fn bad_setpoints_are_refused_and_hold_the_motion() {
    let cases: [Bad; 13] = [
        ("number", |s| s.number = 7, Refusal::Sequence(16)),
        ("before", |s| s.number = 15, Refusal::Sequence(16)),
        ("one angle", |s| s.nodes.truncate(1), Refusal::Groups),
        ("span", |s| s.span = f64::NAN, Refusal::NotFinite(0)),
        (
            "angle",
            |s| s.nodes[1].angle = f64::INFINITY,
            Refusal::NotFinite(1),
        ),
        (
            "rate",
            |s| s.nodes[0].rate = f64::NAN,
            Refusal::NotFinite(0),
        ),
        ("weight", |s| s.nodes[1].weight[0] = 0.0, Refusal::Weight(1)),
        ("order", |s| s.span = 0.0, Refusal::Order),
        ("range", |s| s.nodes[0].angle = 2.71, Refusal::Range(0)),
        ("range", |s| s.nodes[1].angle = -0.2, Refusal::Range(1)),
        ("open", |s| s.nodes[1].angle += 2e-5, Refusal::Open(0)),
        ("rate", |s| s.nodes[1].rate *= 1.01, Refusal::OpenBetween(0)),
        ("bend", |s| s.span -= STEP * 0.4, Refusal::Acceleration(0)),
    ];
    for (what, change, refusal) in cases {
        let mut run = Run::<f64>::started();
        run.sent = 16;
        run.ticks(110);
        let mut bad = setpoint(16);
        change(&mut bad);
        assert_eq!(
            run.follower.accept(&run.sheet.view(), bad),
            Err(refusal),
            "{what}"
        );
        assert_eq!((run.follower.next(), run.follower.room()), (16, 1));
        assert_eq!(run.follower.reason(), Reason::Refused(refusal));
        run.ticks(600);
        assert_eq!(
            (run.follower.state(), run.follower.rate().to_bits()),
            (State::Holding, 0)
        );
        run.sent = KNOTS;
        run.ticks(10);
        assert_eq!(run.follower.state(), State::Holding);
        run.follower.resume().unwrap();
        run.until(State::Done);
        let after = run.follower.accept(&run.sheet.view(), setpoint(KNOTS));
        assert_eq!(after, Err(Refusal::State));
    }
}

#[test]
fn a_full_queue_refuses_without_holding() {
    let mut run = Run::<f64>::started();
    assert_eq!(run.follower.room(), 0);
    let next = setpoint(run.follower.next());
    assert_eq!(
        run.follower.accept(&run.sheet.view(), next),
        Err(Refusal::Full)
    );
    assert_eq!(run.follower.reason(), Reason::None);
    let mut idle = Miura::<f64>::new(CheckedOptions::default());
    assert_eq!(
        idle.accept(&run.sheet.view(), setpoint(0)),
        Err(Refusal::State)
    );
}

/// Accepts eleven knots of a motion under constant acceleration, in one group without a star.
fn accelerates<T: Scalar>(acceleration: f64, speed: f64) -> Result<(), Refusal> {
    moves::<T>(acceleration, speed, 0.02, -3.0)
}

fn moves<T: Scalar>(acceleration: f64, speed: f64, step: f64, from: f64) -> Result<(), Refusal> {
    let limits = [GroupLimits {
        lower: -T::PI,
        upper: T::PI,
        speed: T::lit(1.0),
        acceleration: T::lit(5.0),
    }];
    let none = Stars::<T>::new(1, &[]);
    let sheet = SheetView {
        interpolation: Interpolation::Hermite,
        limits: &limits,
        stars: none.view(),
        closure: T::zero(),
    };
    let mut before = None;
    for number in 0..=10_u32 {
        let time = f64::from(number) * step;
        let node = Node {
            angle: T::lit(from + speed * time - acceleration * time * time / 2.0),
            rate: T::lit(speed - acceleration * time),
            weight: cast([1.0, 0.0]),
        };
        let next = Setpoint::<T, 1> {
            number,
            span: T::lit(step),
            last: false,
            nodes: heapless::Vec::from_array([node]),
        };
        takes(&sheet, before.as_ref(), &next)?;
        before = Some(next);
    }
    Ok(())
}

#[test]
fn a_motion_at_its_limits_is_accepted_and_one_beyond_is_not() {
    assert_eq!(accelerates::<f64>(5.0, 1.0), Ok(()));
    assert_eq!(accelerates::<f32>(5.0, 1.0), Ok(()));
    assert_eq!(
        accelerates::<f64>(5.0 * (1.0 + 1e-9), 0.9),
        Err(Refusal::Acceleration(0))
    );
    assert_eq!(accelerates::<f32>(5.1, 0.9), Err(Refusal::Acceleration(0)));
    assert_eq!(accelerates::<f64>(5.0, 1.0 + 1e-9), Err(Refusal::Speed(0)));
    assert_eq!(accelerates::<f32>(5.0, 1.002), Err(Refusal::Speed(0)));
}

/// Linear segments make no use of rates, however large, so that rates cannot break a limit.
#[test]
fn rates_beside_a_line_widen_no_limit() {
    let none = Stars::<f32>::new(1, &[]);
    let limits = [GroupLimits {
        lower: 0.0,
        upper: 1.0,
        speed: 1.0,
        acceleration: 1.0,
    }];
    let sheet = lone(Interpolation::Linear, &limits, &none);
    let knot = |number: u8, rate| Setpoint::<f32, 1> {
        number: number.into(),
        span: 0.1,
        last: number == 1,
        nodes: heapless::Vec::from_array([Node {
            angle: number.into(),
            rate,
            weight: [1.0, 0.0],
        }]),
    };
    for rate in [0.0, 1e20] {
        let taken = takes(&sheet, Some(&knot(0, 0.0)), &knot(1, rate));
        assert_eq!(taken, Err(Refusal::Speed(0)));
    }
}

/// A knot is not refused because its angles and rates are rounded to `f32`, however close the knots are.
#[test]
fn rounding_passes_no_limit_of_acceptance() {
    let mut rng = Random::new(83);
    for _ in 0..2000 {
        let step = 10_f64.powf(rng.uniform(-3.0, -1.0));
        // The motion goes from full speed, or from rest, to full speed the other way, if there is time for that.
        let from = rng.uniform(-2.0, 3.0);
        let speed = if from > 0.0 { 0.0 } else { 1.0 };
        let acceleration = 5.0_f64.min((1.0 + speed) / (10.0 * step));
        assert_eq!(moves::<f32>(acceleration, speed, step, from), Ok(()));
    }
}

/// A cubic that turns back between two setpoints is refused if its extremum lies outside the limits.
#[test]
fn an_angle_that_turns_back_on_the_way_is_found() {
    let none = Stars::<f64>::new(1, &[]);
    let check = |upper, rates: [f64; 2], end| {
        let limits = [GroupLimits {
            lower: -1.0,
            upper,
            speed: 1e3,
            acceleration: 1e3,
        }];
        let sheet = lone(Interpolation::Hermite, &limits, &none);
        let at = |number: u32, angle, rate| Setpoint::<f64, 1> {
            number,
            span: 1.0,
            last: false,
            nodes: heapless::Vec::from_array([Node {
                angle,
                rate,
                weight: [1.0, 0.0],
            }]),
        };
        takes(&sheet, Some(&at(0, 0.0, rates[0])), &at(1, end, rates[1]))
    };
    // s (1 - s)² is largest at s = 1/3, where it is 4/27.
    let (third, refused) = (4.0 / 27.0, Err(Refusal::Range(0)));
    assert_eq!(check(third + 1e-12, [1.0, 0.0], 0.0), Ok(()));
    assert_eq!(check(third - 1e-12, [1.0, 0.0], 0.0), refused);
    assert_eq!(check(third - 1e-12, [0.0, -1.0], 0.0), refused);
    // s - 3/4 s², a cubic without cubic term, is largest at s = 2/3, where it is 1/3.
    assert_eq!(check(1.0 / 3.0 + 1e-12, [1.0, -0.5], 0.25), Ok(()));
    assert_eq!(check(1.0 / 3.0 - 1e-12, [1.0, -0.5], 0.25), refused);
}

/// A reset forgets everything but the place on the path and the angles last commanded.
#[test]
fn after_a_reset_the_path_goes_on_from_the_place_last_commanded() {
    let mut rng = Random::new(82);
    for _ in 0..50 {
        let mut run = Run::<f32>::started();
        run.ticks(1 + rng.below(2200));
        let (place, angles) = (run.follower.position(), run.follower.angles().to_vec());
        let mut again = Run::<f32>::started();
        again.follower = Follower::new(CheckedOptions::default());
        again.follower.stand(&angles, place, false).unwrap();
        assert_eq!(again.follower.position(), place);
        again.follower.load(&again.sheet.view(), place).unwrap();
        again.feed();
        again.follower.start().unwrap();
        assert_eq!(again.bits(), run.bits());
        again.until(State::Done);

        let mut elsewhere = Miura::<f32>::new(CheckedOptions::default());
        elsewhere
            .stand(&[angles[0], angles[1] + 0.02], place, false)
            .unwrap();
        elsewhere.load(&run.sheet.view(), place).unwrap();
        for number in place.knot..KNOTS.min(place.knot + 2) {
            elsewhere
                .accept(&run.sheet.view(), setpoint(number))
                .unwrap();
        }
        assert_eq!(elsewhere.start(), Err(Denial::Jump(1)));
    }
}

#[test]
fn a_place_that_is_not_on_the_first_segment_is_no_beginning() {
    for into in [-0.001, STEP * 1.01, f64::NAN] {
        let mut run = Run::<f64>::started();
        run.follower = Follower::new(CheckedOptions::default());
        run.follower
            .load(&run.sheet.view(), FollowerPosition { knot: 4, into })
            .unwrap();
        assert_eq!(run.follower.start(), Err(Denial::Empty));
        run.feed();
        assert_eq!(run.follower.start(), Err(Denial::Place));
    }
}

#[test]
fn a_group_that_is_measured_at_no_number_is_not_moved() {
    for nowhere in [f64::NAN, f64::INFINITY] {
        let mut run = Run::<f64>::ready(CheckedOptions::default());
        let begin = setpoint::<f64>(0).nodes[0].angle;
        run.follower = Follower::new(CheckedOptions::default());
        run.follower
            .stand(&[begin, nowhere], FollowerPosition::default(), false)
            .unwrap();
        run.follower
            .load(&run.sheet.view(), FollowerPosition::default())
            .unwrap();
        run.feed();
        assert_eq!(run.follower.start(), Err(Denial::Jump(1)));
        assert_eq!(run.follower.state(), State::Ready);
    }
}

/// Braking every hinge on its own, from the same moment and with its own acceleration, tears the sheet. Holding along
/// the path does not.
#[test]
fn holding_along_the_path_keeps_closure_and_braking_hinge_by_hinge_does_not() {
    let mut torn = 0.0_f64;
    let mut kept = 0.0_f64;
    let causes = [Reason::HoldCommand, Reason::Silence, Reason::Underrun];
    let moments = (300..2000).step_by(100);
    for (moment, cause) in moments.flat_map(|moment| causes.map(|cause| (moment, cause))) {
        let mut run = Run::<f64>::started();
        run.ticks(moment);
        let mut angles = [run.follower.angles()[0], run.follower.angles()[1]];
        let mut rates = [run.follower.rates()[0], run.follower.rates()[1]];
        match cause {
            Reason::Silence => run.host = false,
            Reason::Underrun => run.sent = 0,
            cause => run.follower.hold(cause),
        }
        for _ in 0..800 {
            run.tick();
            kept = kept.max(run.sheet.residual(run.follower.angles()));
            for (angle, rate) in angles.iter_mut().zip(&mut rates) {
                let brake: f64 = LIMITS.acceleration * 1e-3;
                *rate -= rate.clamp(-brake, brake);
                *angle += *rate * 1e-3;
            }
            torn = torn.max(run.sheet.residual(&angles));
        }
        assert_eq!(run.follower.rate().to_bits(), 0);
        let told = run.follower.reason();
        let dry = told == Reason::Underrun || run.follower.state() == State::Done;
        assert!(told == cause || dry, "{told:?}");
    }
    assert!(kept < 1e-7, "{kept:e}");
    assert!(torn > 1.8_f64.to_radians(), "{torn}");
}

/// A tick that comes late does not count whole, and the reason says so.
#[test]
fn late_ticks_slow_the_motion_and_are_told() {
    for (millis, reason, rate) in [(10, Reason::None, 1.0), (20, Reason::LateTick, 0.5)] {
        let mut run = Run::<f32>::started();
        run.ticks(400);
        let (begun, now) = (run.time(), run.now);
        for _ in 0..10 {
            run.now += (millis - 1) * TICK;
            run.tick();
            assert_eq!(run.follower.reason(), reason);
        }
        let passed = 1e-6 * (run.now - now) as f64;
        let gone = (run.time() - begun).to_f64();
        assert!((gone - rate * passed).abs() < 1e-3, "{gone} in {passed}");
        run.tick();
        assert_eq!(run.follower.reason(), Reason::None);
    }
}

#[test]
fn options_that_are_not_sound_are_refused_by_name() {
    type Change = fn(&mut Options<f32>, f32);
    let numbers: [(&str, Change); 9] = [
        ("clock.rise", |it, value| it.clock.rise = value),
        ("clock.brake", |it, value| it.clock.brake = value),
        ("lag", |it, value| it.lag = value),
        ("most_lag", |it, value| it.most_lag = value),
        ("jump", |it, value| it.jump = value),
        ("reach", |it, value| it.reach = value),
        ("spread", |it, value| it.spread = value),
        ("approach", |it, value| it.approach = value),
        ("closure", |it, value| it.closure = value),
    ];
    let times: [(&str, Change); 4] = [
        ("silence", |it, _| it.silence = 0),
        ("longest_tick", |it, _| it.longest_tick = 0),
        ("stall", |it, _| it.stall = 0),
        ("fresh", |it, _| it.fresh = 0),
    ];
    let name = |options: Options<f32>| options.checked().unwrap_err().option;
    for (option, change) in numbers {
        for value in [f32::NAN, f32::INFINITY, f32::NEG_INFINITY, 0.0, -0.1] {
            let mut options = Options::default();
            change(&mut options, value);
            assert_eq!(name(options), option, "{value}");
        }
    }
    for (option, change) in times {
        let mut options = Options::default();
        change(&mut options, 0.0);
        assert_eq!(name(options), option);
    }
    let open = Options {
        closure: 0.11,
        ..Options::DEFAULT
    };
    assert_eq!(name(open), "closure");
    let contradictory = Options {
        lag: 0.15,
        ..Options::DEFAULT
    };
    let error = contradictory.checked().unwrap_err();
    assert_eq!(
        error.to_string(),
        "most_lag: expected a finite angle above lag"
    );
    let open = Options {
        closure: 0.11,
        ..Options::DEFAULT
    };
    assert_eq!(name(open), "closure");
    let contradictory = Options {
        jump: 0.2,
        ..Options::DEFAULT
    };
    assert_eq!(name(contradictory), "reach");
    assert_eq!(*Options::DEFAULT.checked().unwrap(), Options::default());
}

#[test]
fn slow_clocks_and_lost_ticks_neither_jump_nor_stick() {
    let limits = ClockLimits {
        rise: 0.5,
        brake: 0.5,
    };
    let mut run = Run::<f32>::ready(
        Options {
            clock: limits,
            ..Options::default()
        }
        .checked()
        .unwrap(),
    );
    run.follower.start().unwrap();
    run.ticks(200);
    let before = run.time();
    run.now += 5_000_000;
    run.follower.heard(run.now + TICK);
    run.tick();
    // A single tick passes at most 10 ms of world time, however late it comes.
    assert!(run.time() - before < 0.01 * 0.2, "{}", run.time() - before);
    let now = run.now;
    run.now = 17;
    run.tick();
    run.now = now;
    run.until(State::Done);
}

/// Follows a whole Miura motion from flat towards flat-folded, through knots with these spans, and returns the largest residual.
fn exact<T: Scalar>(kind: Interpolation, knots: &[(f64, [Node<f64>; 2])], top: f64) -> f64 {
    let mut sheet = Sheet::<T>::new();
    for limits in &mut sheet.limits {
        (limits.lower, limits.upper) = (T::zero(), T::PI);
        (limits.speed, limits.acceleration) = (T::lit(50.0), T::lit(1e4));
    }
    let view = SheetView {
        interpolation: kind,
        closure: T::CLOSURE_TOLERANCE,
        ..sheet.view()
    };
    let mut follower = Miura::<T>::new(CheckedOptions::default());
    follower.load(&view, FollowerPosition::default()).unwrap();
    for (number, (span, nodes)) in (0..).zip(knots) {
        let nodes = nodes.map(|node| Node {
            angle: T::lit(node.angle),
            rate: T::lit(node.rate),
            weight: node.weight.map(T::lit),
        });
        let next = Setpoint {
            number,
            span: T::lit(*span),
            last: number as usize + 1 == knots.len(),
            nodes: heapless::Vec::from_array(nodes),
        };
        follower.accept(&view, next).unwrap();
    }
    follower.confirm().unwrap();
    follower.start().unwrap();
    let mut worst = 0.0_f64;
    for now in 1..3000 {
        follower.heard(now * TICK);
        follower.tick(view.stars, now * TICK);
        worst = worst.max(sheet.residual(follower.angles()));
    }
    assert_eq!(follower.state(), State::Done);
    assert!((follower.angles()[0].to_f64() - top).abs() < 1e-6);
    worst
}

#[test]
fn half_angles_follow_the_whole_motion_without_leaving_it() {
    // Both tangents of half angles are proportional to time, so that they are straight lines.
    let straight = |k: i32| {
        let t = f64::from(k);
        let node = |slope: f64| Node {
            angle: 2.0 * (slope * t).atan(),
            rate: 2.0 * slope / (1.0 + slope * slope * t * t),
            weight: [1.0, 0.0],
        };
        (1.0, [node(1.0), node(0.5)])
    };
    let knots = [0, 1, 2].map(straight);
    let half = Interpolation::HalfAngle;
    let top = 2.0 * 2_f64.atan();
    assert!(exact::<f64>(half, &knots, top) < 1e-15 * 8.0);
    assert!(exact::<f32>(half, &knots, top) < 2e-6);
    // The homogeneous segment (c, n) = (1 - s, k s) goes from flat to flat-folded in two seconds.
    let ends = |k: f64| {
        let flat = Node {
            angle: 0.0,
            rate: k,
            weight: [1.0, -0.5],
        };
        let folded = Node {
            angle: PI,
            rate: 1.0 / k,
            weight: [k, k / 2.0],
        };
        [flat, folded]
    };
    let (major, minor) = (ends(1.0), ends(0.5));
    let knots = [(0.0, [major[0], minor[0]]), (2.0, [major[1], minor[1]])];
    let homogeneous = Interpolation::Homogeneous;
    assert!(exact::<f64>(homogeneous, &knots, PI) < 1e-15 * 8.0);
    assert!(exact::<f32>(homogeneous, &knots, PI) < 2e-6);
}

/// Far into a long segment the spacing of `f32` numbers around the place is 1/16 of a tick. The ticks must still add
/// up.
#[test]
fn a_long_segment_takes_its_time() {
    let none = Stars::<f32>::new(1, &[]);
    let limits = [GroupLimits {
        lower: 0.0,
        upper: 1.0,
        speed: 1.0,
        acceleration: 1.0,
    }];
    let sheet = lone(Interpolation::Linear, &limits, &none);
    let mut follower = Follower::<f32, 1, 2>::new(CheckedOptions::default());
    let place = FollowerPosition {
        knot: 0,
        into: 1000.0,
    };
    follower.load(&sheet, place).unwrap();
    for number in 0..2_u8 {
        let setpoint = Setpoint {
            number: number.into(),
            span: 2000.0,
            last: number == 1,
            nodes: heapless::Vec::from_array([Node {
                angle: number.into(),
                rate: 0.0,
                weight: [1.0, 0.0],
            }]),
        };
        follower.accept(&sheet, setpoint).unwrap();
    }
    follower.confirm().unwrap();
    follower.start().unwrap();
    for now in 1..=10_000 {
        follower.heard(now * TICK);
        follower.tick(sheet.stars, now * TICK);
    }
    // Ten seconds of the path, less 1/8 s for speeding up.
    let into = follower.position().into;
    assert!((into - 1009.875).abs() < 5e-4, "{into}");
}

/// The duration of the path overflows `f32`; the path must not end at once.
#[test]
fn a_path_longer_than_all_numbers_is_followed_at_its_pace() {
    let none = Stars::<f32>::new(1, &[]);
    let limits = [GroupLimits {
        lower: 0.0,
        upper: 1.0,
        speed: 1.0,
        acceleration: f32::INFINITY,
    }];
    let sheet = lone(Interpolation::Linear, &limits, &none);
    let mut follower = Follower::<f32, 1, 4>::new(CheckedOptions::default());
    follower.load(&sheet, FollowerPosition::default()).unwrap();
    for number in 0..3_u8 {
        let setpoint = Setpoint {
            number: number.into(),
            span: 3e38,
            last: number == 2,
            nodes: heapless::Vec::from_array([Node {
                angle: f32::from(number) / 2.0,
                rate: 0.0,
                weight: [1.0, 0.0],
            }]),
        };
        follower.accept(&sheet, setpoint).unwrap();
    }
    follower.confirm().unwrap();
    follower.start().unwrap();
    for now in 1..=1000 {
        follower.heard(now * TICK);
        follower.tick(sheet.stars, now * TICK);
        assert_eq!(follower.state(), State::Running);
    }
    assert_eq!(follower.position().knot, 0);
    // One second of the path, less 1/8 s for speeding up.
    assert!((follower.position().into - 0.875).abs() < 1e-3);
    assert!(follower.angles()[0] < 1e-30 && follower.left().is_finite());
}

/// The limits allow a single angle. The way through the tangent of the half angle rounds, but the command must not
/// leave the limits.
#[test]
fn rounding_leaves_no_limit() {
    let none = Stars::<f32>::new(1, &[]);
    for step in 1..200_u8 {
        let angle = f32::from(step) * 0.0157;
        let limits = [GroupLimits {
            lower: angle,
            upper: angle,
            speed: 1.0,
            acceleration: 1.0,
        }];
        let sheet = lone(Interpolation::HalfAngle, &limits, &none);
        let mut follower = Follower::<f32, 1, 2>::new(CheckedOptions::default());
        follower.load(&sheet, FollowerPosition::default()).unwrap();
        for number in 0..2_u8 {
            let still = Setpoint {
                number: number.into(),
                span: 1.0,
                last: number == 1,
                nodes: heapless::Vec::from_array([Node {
                    angle,
                    rate: 0.0,
                    weight: [1.0, 0.0],
                }]),
            };
            follower.accept(&sheet, still).unwrap();
        }
        follower.confirm().unwrap();
        follower.start().unwrap();
        for now in 1..100 {
            follower.tick(sheet.stars, now * TICK);
            assert_eq!(follower.angles()[0].to_bits(), angle.to_bits());
        }
    }
}

/// A vertex that would be torn stops the motion before the command goes out, whatever was accepted: here the sheet is
/// another one than the path was checked for. Vertices are looked at in turn, so that the motion may go on for as many ticks
/// as there are vertices.
#[test]
fn a_vertex_that_would_be_torn_fails_the_motion() {
    for torn in 0..5_u16 {
        let mut run = Run::<f64>::started();
        run.ticks(300);
        let spokes = run.sheet.stars.view().get(0).unwrap().spokes;
        let mut spokes = spokes.repeat(5);
        let [x, y] = spokes[4 * usize::from(torn)].direction;
        spokes[4 * usize::from(torn)].direction = [x * 0.8 - y * 0.6, x * 0.6 + y * 0.8];
        let ends = [4, 8, 12, 16, 20];
        let stars = StarsView::new(&spokes, &ends, 2).unwrap();
        let mut ticks = 0;
        let (before, place) = loop {
            let before = run.follower.angles().to_vec();
            let place = run.follower.position();
            run.now += TICK;
            run.follower.heard(run.now);
            run.follower.tick(stars, run.now);
            ticks += 1;
            if run.follower.state() == State::Faulted {
                break (before, place);
            }
            assert!(ticks < 5);
        };
        assert_eq!(run.follower.fault(), Some(Fault::Torn(torn)));
        assert_eq!(run.follower.angles(), before);
        assert_eq!(run.follower.position(), place);
        assert_eq!(run.follower.rates(), [0.0; 2]);
    }
}
