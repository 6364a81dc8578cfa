//! Does acceptance bound segments of half angles everywhere, and not only at the places that it looks at?

use core::f64::consts::PI;

use foldpath_core::acceptance::{Refusal, Setpoint, SheetView};
use foldpath_core::{Curve, GroupLimits, HalfAngle, Interpolation, Node, StarView, closure};
use foldpath_test_support::stars::{Stars, miura};
use foldpath_test_support::{Random, takes};

const KIND: Interpolation = Interpolation::Homogeneous;

fn limits(speed: f64) -> [GroupLimits<f64>; 2] {
    [GroupLimits {
        lower: -PI,
        upper: PI,
        speed,
        acceleration: f64::INFINITY,
    }; 2]
}

/// Returns the angle of the minor creases of Miura's fold with sector angles of 60°.
fn minor(major: f64) -> f64 {
    2.0 * ((major / 2.0).tan() / 2.0).atan()
}

fn setpoint(number: u32, span: f64, major: f64, weight: [f64; 2]) -> Setpoint<f64, 2> {
    let node = |angle| Node {
        angle,
        rate: 0.0,
        weight,
    };
    Setpoint {
        number,
        span,
        last: false,
        nodes: [node(major), node(minor(major))].into_iter().collect(),
    }
}

/// A weight of almost 0 makes a segment jump between the places that acceptance looks at.
#[test]
fn a_jump_between_the_places_is_refused() {
    let (stars, limits) = (miura(60.0, false, false), limits(1.0));
    let sheet = SheetView {
        interpolation: KIND,
        limits: &limits,
        stars: Stars::<f64>::view(&stars),
        closure: 1e-4,
    };
    let from = setpoint(0, 0.0, 0.2, [1.0, -0.6]);
    for weight in [1e-6, 1e-7, 1e-8, 1e-9, 1e-10] {
        let to = setpoint(1, 5.0, 2.4, [weight, 0.0]);
        let verdict = takes(&sheet, Some(&from), &to);
        assert!(
            matches!(verdict, Err(Refusal::Speed(_) | Refusal::OpenBetween(_))),
            "{weight:e}: {verdict:?}"
        );
        // The vertex alone is refused as well, without a limit on the speed.
        let free = self::limits(f64::INFINITY);
        let sheet = SheetView {
            limits: &free,
            ..sheet
        };
        let verdict = takes(&sheet, Some(&from), &to);
        assert_eq!(verdict, Err(Refusal::OpenBetween(0)), "{weight:e}");
    }
}

/// Whatever is accepted keeps its speed, its range and its closure at a thousand places, for every kind of motion, with
/// rates and weights that are nearly right, or wrong.
#[test]
fn whatever_is_accepted_keeps_its_limits_everywhere() {
    for kind in [
        Interpolation::Linear,
        Interpolation::Hermite,
        Interpolation::HalfAngle,
        Interpolation::Homogeneous,
    ] {
        let mut rng = Random::new(84);
        let (mut accepted, mut refused, mut nearest) = (0, 0, [0.0_f64; 2]);
        for _ in 0..4000 {
            match keeps_its_limits(&mut rng, kind) {
                Some(reached) => {
                    accepted += 1;
                    nearest = [0, 1].map(|k| nearest[k].max(reached[k]));
                }
                None => refused += 1,
            }
        }
        println!("{kind:?}: {accepted} accepted, {refused} refused, nearest {nearest:?}");
        // A bound may be a sixteenth above its limit.
        assert!(
            nearest.iter().all(|part| *part <= 1.0 + 1.0 / 16.0),
            "{kind:?}: {nearest:?}"
        );
        // The test is worth something: it accepts motions that come near their limits.
        assert!(
            accepted > 400 && refused > 500 && nearest.iter().all(|part| *part > 0.9),
            "{kind:?}"
        );
    }
}

/// Offers a random segment; returns the largest speed and the largest residual on it, as parts of their limits, if it is
/// accepted.
fn keeps_its_limits(rng: &mut Random, kind: Interpolation) -> Option<[f64; 2]> {
    let stars = miura::<f64>(60.0, false, false);
    let star: StarView<'_, f64> = stars.view().iter().next().unwrap();
    let speed = 10_f64.powf(rng.uniform(-0.5, 1.0));
    let bound = 10_f64.powf(rng.uniform(-6.0, -1.0));
    let limits = limits(speed);
    let sheet = SheetView {
        interpolation: kind,
        limits: &limits,
        stars: stars.view(),
        closure: bound,
    };
    let weight = |rng: &mut Random| {
        let size = 10_f64.powf(rng.uniform(-3.0, 0.5));
        let weighted = kind == Interpolation::Homogeneous;
        if weighted {
            [size, size * rng.uniform(-2.0, 2.0)]
        } else {
            [1.0, 0.0]
        }
    };
    let (start, weights) = (rng.uniform(0.0, 2.5), [weight(rng), weight(rng)]);
    let step = 10_f64.powf(rng.uniform(-3.0, 0.0));
    let mut from = setpoint(0, 0.0, start, weights[0]);
    let mut to = setpoint(1, rng.uniform(0.1, 2.0), start + step, weights[1]);
    if kind != Interpolation::Homogeneous {
        // The rates of a closed motion at one speed, and at either end something added to that of one group.
        let (major, span) = (step / to.span, to.span);
        for at in [&mut from, &mut to] {
            let tangent = (at.nodes[0].angle / 2.0).tan() / 2.0;
            let square = |tangent: f64| 1.0 + tangent * tangent;
            let minor = major / 2.0 * square(2.0 * tangent) / square(tangent);
            (at.nodes[0].rate, at.nodes[1].rate) = (major, minor);
            let wrong = bound / span * rng.uniform(-20.0, 20.0);
            at.nodes[rng.below(2)].rate += if rng.chance(0.7) { wrong } else { 0.0 };
        }
    }
    takes(&sheet, Some(&from), &to).ok()?;
    let curves =
        [0, 1].map(|group| Curve::between(kind, to.span, from.nodes[group], to.nodes[group]));
    let mut reached = [0.0_f64; 2];
    for s in (0..=1000).map(|k| f64::from(k) / 1000.0) {
        for curve in &curves {
            let rate = curve.derivatives(s)[0].abs() / to.span;
            reached[0] = reached[0].max(rate / speed);
            assert!(curve.angle(s).abs() <= PI + 1e-3);
        }
        let half: [HalfAngle<f64>; 2] = [curves[0].half_angle(s), curves[1].half_angle(s)];
        let residual = closure::residual(star, &half).norm();
        reached[1] = reached[1].max(residual / (bound + 1e-9));
    }
    Some(reached)
}

/// Closed ends and a closed middle say nothing of an S between them.
#[test]
fn an_s_between_closed_places_is_refused() {
    let (stars, limits) = (miura(60.0, false, false), limits(10.0));
    for kind in [Interpolation::Hermite, Interpolation::HalfAngle] {
        let sheet = SheetView {
            interpolation: kind,
            limits: &limits,
            stars: Stars::<f64>::view(&stars),
            closure: 1e-4,
        };
        for (rate, closes) in [(0.0, true), (1e-5, true), (1e-2, false), (0.8, false)] {
            let s = |number, span| {
                let mut knot = setpoint(number, span, 1.2, [1.0, 0.0]);
                knot.nodes[1].rate = rate;
                knot
            };
            let verdict = takes(&sheet, Some(&s(0, 0.0)), &s(1, 2.0));
            let expected = if closes {
                Ok(())
            } else {
                Err(Refusal::OpenBetween(0))
            };
            assert_eq!(verdict, expected, "{kind:?} {rate}");
        }
    }
}

/// A follower checks the vertices of a segment a few at a time; a setpoint is queued once all are checked, with the same
/// verdict as at once.
#[test]
fn vertices_are_checked_in_parts() {
    use foldpath_core::follower::{CheckedOptions, Follower, FollowerPosition};
    let one: Stars<f64> = miura(60.0, false, false);
    let spokes = one.view().iter().next().unwrap().spokes.repeat(7);
    let ends: Vec<u32> = (1..=7).map(|star| 4 * star).collect();
    let limits = limits(f64::INFINITY);
    let sheet = SheetView {
        interpolation: KIND,
        limits: &limits,
        stars: foldpath_core::StarsView::new(&spokes, &ends, 2).unwrap(),
        closure: 1e-2,
    };
    let closed = setpoint(1, 5.0, 0.3, [1.0, 0.0]);
    // It jumps between the places at which every setpoint is looked at.
    let open = setpoint(1, 5.0, 2.4, [1e-8, 0.0]);
    for (next, weight, is_closed) in [(closed, [1.0, 0.0], true), (open, [1.0, -0.6], false)] {
        let mut whole = Follower::<f64, 2, 4>::new(CheckedOptions::default());
        whole.load(&sheet, FollowerPosition::default()).unwrap();
        whole.accept(&sheet, setpoint(0, 0.0, 0.2, weight)).unwrap();
        let mut parts = whole.clone();
        let expected = whole.accept(&sheet, next.clone());
        assert_eq!(expected.is_ok(), is_closed);
        parts.offer(&sheet, next).unwrap();
        let mut rounds = 0;
        let found = loop {
            assert_eq!(parts.room(), 3);
            rounds += 1;
            match parts.check_on(&sheet, 2) {
                Ok(false) => {}
                Ok(true) => break Ok(()),
                Err(refusal) => break Err(refusal),
            }
        };
        assert_eq!(found, expected);
        assert_eq!(parts.room(), whole.room());
        // Each vertex of the closed segment takes one part, and a round has two. The open segment is halved five times
        // before the answer, which takes 6 to 63 parts.
        let bounds = if expected.is_ok() { 4..=4 } else { 3..=32 };
        assert!(bounds.contains(&rounds), "{rounds}");
        assert_eq!(parts.check_on(&sheet, 2), Err(Refusal::State));
    }
}

/// A path is dropped while its setpoint is checked: the setpoint is not queued.
#[test]
fn a_path_that_is_dropped_takes_its_unchecked_setpoint_along() {
    use foldpath_core::follower::{CheckedOptions, Fault, Follower, FollowerPosition};
    let (stars, limits) = (miura(60.0, false, false), limits(10.0));
    let sheet = SheetView {
        interpolation: KIND,
        limits: &limits,
        stars: Stars::<f64>::view(&stars),
        closure: 1e-4,
    };
    for fails in [false, true] {
        let mut follower = Follower::<f64, 2, 4>::new(CheckedOptions::default());
        follower.load(&sheet, FollowerPosition::default()).unwrap();
        follower
            .offer(&sheet, setpoint(0, 0.0, 0.2, [1.0, 0.0]))
            .unwrap();
        if fails {
            follower.fail(Fault::Stalled(0));
        } else {
            follower.unload().unwrap();
        }
        assert_eq!(follower.check_on(&sheet, 9), Err(Refusal::State));
        assert_eq!(follower.room(), 4);
    }
}
