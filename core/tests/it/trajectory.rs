//! Trajectories: their samples between knots, and the input that they refuse.

use foldpath_core::Interpolation::Hermite;
use foldpath_core::follower::FollowerPosition;
use foldpath_core::trajectory::{Knot, TrajectoryError, TrajectoryView};
use foldpath_core::{Curve, Interpolation, Node, Scalar};
use foldpath_test_support::{Random, cast};

/// Returns a cubic polynomial and its derivative at `t`.
fn cubic([a, b, c, d]: [f64; 4], t: f64) -> (f64, f64) {
    let value = a + t * (b + t * (c + t * d));
    (value, b + t * (2.0 * c + t * 3.0 * d))
}

/// Returns the place that is so many seconds behind the first knot.
fn behind_first<T>(into: T) -> FollowerPosition<T> {
    FollowerPosition { knot: 0, into }
}

fn reproduces_cubics<T: Scalar>() {
    let mut rng = Random::new(51);
    for _ in 0..100 {
        let curves: [[f64; 4]; 2] =
            core::array::from_fn(|_| core::array::from_fn(|_| rng.uniform(-1.0, 1.0)));
        let times = [-1.0, -0.25, 0.5, 0.75, 2.0]; // exact in binary
        let knots = times.map(|t| curves.map(|curve| cubic(curve, t)));
        let angles: Vec<T> = knots.as_flattened().iter().map(|k| T::lit(k.0)).collect();
        let rates: Vec<T> = knots.as_flattened().iter().map(|k| T::lit(k.1)).collect();
        let spans: [T; 5] = cast([0.0, 0.75, 0.75, 0.25, 1.25]);
        let view = TrajectoryView::new(Hermite, 2, &spans, &angles, &rates, &[]).unwrap();
        for t in (0..=96).map(|step| -1.0 + f64::from(step) / 32.0) {
            let mut sampled = [T::zero(); 2];
            view.sample(behind_first(T::lit(t - times[0])), &mut sampled);
            for (sampled, curve) in sampled.iter().zip(curves) {
                let error = (sampled.to_f64() - cubic(curve, t).0).abs();
                // The angles are below 15, the rates times the duration below 20.
                assert!(
                    error <= 4.0 * 20.0 * T::EPSILON.to_f64(),
                    "{error:e} at {t}"
                );
            }
        }
    }
}

#[test]
fn cubics_are_sampled_exactly() {
    reproduces_cubics::<f32>();
    reproduces_cubics::<f64>();
}

const SPANS: [f64; 2] = [0.0, 1.0];
const ANGLES: [f64; 4] = [0.1, 0.2, 0.3, 0.4];
const RATES: [f64; 4] = [1.0, 2.0, 3.0, 4.0];

#[test]
fn times_outside_get_the_nearest_knot() {
    let view = TrajectoryView::new(Hermite, 2, &SPANS, &ANGLES, &RATES, &[]).unwrap();
    for (time, knot) in [
        (-1e9, 0),
        (-0.001, 0),
        (0.0, 0),
        (1.0, 1),
        (1.001, 1),
        (1e9, 1),
    ] {
        let mut sampled = [0.0; 2];
        view.sample(behind_first(time), &mut sampled);
        let expected = view.knot(knot).unwrap().angles.iter().map(|a| a.to_bits());
        assert!(
            sampled.iter().map(|a| a.to_bits()).eq(expected),
            "at {time}"
        );
    }
    let mut untouched = [7.0];
    let empty = TrajectoryView::<f64>::new(Hermite, 1, &[], &[], &[], &[]).unwrap();
    empty.sample(behind_first(0.0), &mut untouched);
    assert_eq!(untouched.map(f64::to_bits), [7_f64.to_bits()]);
}

#[test]
fn a_view_lists_its_knots() {
    let view = TrajectoryView::new(Hermite, 2, &SPANS, &ANGLES, &RATES, &[]).unwrap();
    assert_eq!((view.len(), view.groups(), view.is_empty()), (2, 2, false));
    let second = Knot {
        span: 1.0,
        angles: &[0.3, 0.4],
        rates: &[3.0, 4.0],
        weights: &[],
    };
    assert_eq!(view.knot(1), Some(second));
    assert_eq!(view.knot(2), None);
    assert_eq!(view.knot(usize::MAX), None);
}

#[test]
fn a_view_refuses_bad_knots() {
    let error = |spans: [f64; 2], angles: &[f64], rates: &[f64]| {
        TrajectoryView::new(Hermite, 2, &spans, angles, rates, &[]).unwrap_err()
    };
    assert_eq!(
        error(SPANS, &ANGLES[..3], &RATES),
        TrajectoryError::Width(1)
    );
    assert_eq!(
        error(SPANS, &ANGLES, &RATES[..1]),
        TrajectoryError::Width(0)
    );
    let surplus = [0.0; 5];
    assert_eq!(error(SPANS, &surplus, &RATES), TrajectoryError::Width(2));
    assert_eq!(error(SPANS, &ANGLES, &surplus), TrajectoryError::Width(2));
    assert_eq!(
        error([0.0, 0.0], &ANGLES, &RATES),
        TrajectoryError::Order(1)
    );
    assert_eq!(
        error([0.0, -0.5], &ANGLES, &RATES),
        TrajectoryError::Order(1)
    );
    assert_eq!(
        error([0.5, 1.0], &ANGLES, &RATES),
        TrajectoryError::Order(0)
    );
    for bad in [f64::NAN, f64::INFINITY] {
        let last = [0.0, 0.0, 0.0, bad];
        assert_eq!(
            error([0.0, bad], &ANGLES, &RATES),
            TrajectoryError::NotFinite(1)
        );
        assert_eq!(
            error([bad, 1.0], &ANGLES, &RATES),
            TrajectoryError::NotFinite(0)
        );
        assert_eq!(error(SPANS, &last, &RATES), TrajectoryError::NotFinite(1));
        assert_eq!(error(SPANS, &ANGLES, &last), TrajectoryError::NotFinite(1));
    }
}

/// Returns a weighted knot of one group.
fn node(angle: f64, rate: f64, weight: [f64; 2]) -> Node<f64> {
    Node {
        angle,
        rate,
        weight,
    }
}

const KINDS: [Interpolation; 4] = [
    Interpolation::Linear,
    Interpolation::Hermite,
    Interpolation::HalfAngle,
    Interpolation::Homogeneous,
];

#[test]
fn curves_pass_through_their_knots_with_their_rates() {
    let mut rng = Random::new(52);
    let mut draw = |most: f64| rng.uniform(-most, most);
    for _ in 0..1000 {
        let span = 1.5 + draw(1.0);
        let nodes = [(); 2].map(|()| node(draw(2.5), draw(1.0), [1.5 + draw(1.0), draw(0.3)]));
        for kind in KINDS {
            let curve = Curve::between(kind, span, nodes[0], nodes[1]);
            for (s, node) in [(0.0, nodes[0]), (1.0, nodes[1])] {
                assert!((curve.angle(s) - node.angle).abs() < 1e-14, "{kind:?}");
                let slope = if kind == Interpolation::Linear {
                    nodes[1].angle - nodes[0].angle
                } else {
                    node.rate * span
                };
                assert!((curve.derivatives(s)[0] - slope).abs() < 1e-12, "{kind:?}");
                let half = curve.half_angle(s);
                assert!((half.cos - (node.angle / 2.0).cos()).abs() < 1e-14);
                assert!((half.sin - (node.angle / 2.0).sin()).abs() < 1e-14);
            }
        }
    }
}

#[test]
fn derivatives_are_those_of_the_angle() {
    let mut rng = Random::new(53);
    let mut draw = |most: f64| rng.uniform(-most, most);
    let h = 1e-4;
    for _ in 0..200 {
        let nodes = [(); 2].map(|()| node(draw(2.0), draw(1.0), [1.5 + draw(0.5), draw(0.3)]));
        let s = 0.5 + draw(0.4);
        for kind in KINDS {
            let curve = Curve::between(kind, 0.7, nodes[0], nodes[1]);
            let [before, here, after] = [s - h, s, s + h].map(|s| curve.angle(s));
            let [first, second] = curve.derivatives(s);
            let size = 1.0 + first.abs() + second.abs();
            assert!(((after - before) / (2.0 * h) - first).abs() < 1e-4 * size);
            let bend = (after - 2.0 * here + before) / (h * h);
            assert!((bend - second).abs() < 1e-4 * size, "{kind:?}");
        }
    }
}

#[test]
fn one_homogeneous_segment_folds_a_miura_flat() {
    // c = 1 - s and n = k s lead from flat to half a turn, with k = 1 for one group and k = cos 60° for the other. Then
    // tan(ρ₁/2) = cos 60° tan(ρ₀/2) all along.
    let curve = |k: f64| {
        let flat = node(0.0, 2.0 * k, [1.0, -1.0]);
        let folded = node(core::f64::consts::PI, 2.0 / k, [k, k]);
        Curve::between(Interpolation::Homogeneous, 1.0, flat, folded)
    };
    let (zigzag, straight) = (curve(1.0), curve(0.5));
    for s in (0..=100).map(|k| f64::from(k) / 100.0) {
        let [zigzag, straight] = [zigzag, straight].map(|curve| curve.half_angle(s));
        let open = zigzag.cos * straight.sin - 0.5 * zigzag.sin * straight.cos;
        assert!(open.abs() < 1e-15, "{open:e} at {s}");
    }
    assert!((zigzag.angle(1.0) - core::f64::consts::PI).abs() < 1e-15);
}

#[test]
fn a_view_refuses_what_its_interpolation_cannot_pass_through() {
    let (spans, rates) = ([0.0, 1.0], [0.0; 2]);
    let view = |kind, angles: &[f64; 2], weights: &[[f64; 2]]| {
        TrajectoryView::new(kind, 1, &spans, angles, &rates, weights).map(|_| ())
    };
    let half_turn = [0.0, core::f64::consts::PI];
    let half_angle = Interpolation::HalfAngle;
    assert_eq!(
        view(half_angle, &half_turn, &[]),
        Err(TrajectoryError::HalfTurn(1))
    );
    assert_eq!(view(Hermite, &half_turn, &[]), Ok(()));
    let homogeneous = Interpolation::Homogeneous;
    assert_eq!(view(homogeneous, &half_turn, &[[1.0, 0.0]; 2]), Ok(()));
    assert_eq!(
        view(homogeneous, &half_turn, &[[1.0, 0.0], [0.0, 1.0]]),
        Err(TrajectoryError::Weight(1))
    );
    for (kind, weights) in [(homogeneous, 0), (Hermite, 2)] {
        let weights = &[[1.0, 0.0]; 2][..weights];
        assert!(matches!(
            view(kind, &half_turn, weights),
            Err(TrajectoryError::Width(_))
        ));
    }
}
