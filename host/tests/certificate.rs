//! Certificates of whole segments are never below what is sampled by another way of computation, and
//! not far above it.

use foldpath::certificate::{SegmentCertifier, range, rate};
use foldpath::generate::{Miura, Waterbomb};
use foldpath::pattern::CreasePattern;
use foldpath::symmetry::{CreaseGroups, ReducedStars};
use foldpath_core::{
    Curve, GroupId, Interpolation, LoopsView, Node, Spoke, StarView, StarsView,
    local_foldability_matrix,
};
use nalgebra::Matrix3;
use rand_pcg::Pcg64;
use rand_pcg::rand_core::Rng;

const KINDS: [Interpolation; 4] = [
    Interpolation::Linear,
    Interpolation::Hermite,
    Interpolation::HalfAngle,
    Interpolation::Homogeneous,
];

/// A sheet whose motion has a closed form: the tangents of half its fold angles are polynomials of one
/// parameter t.
struct Sheet {
    name: &'static str,
    pattern: CreasePattern,
    groups: CreaseGroups,
    stars: ReducedStars,
    /// Of each group, the polynomial and its derivative.
    tangents: Vec<fn(f64) -> [f64; 2]>,
    /// The largest of the fold angles.
    largest: usize,
}

const MIURA: [fn(f64) -> [f64; 2]; 2] = [
    |t| [t, 1.0],
    |t| {
        let k = 60_f64.to_radians().cos();
        [k * t, k]
    },
];
const WATERBOMB: [fn(f64) -> [f64; 2]; 4] = [
    |t| [t, 1.0],
    |t| [2.0 * t, 2.0],
    |t| [2_f64.sqrt() * t, 2_f64.sqrt()],
    |t| [3.0 * t + 4.0 * t.powi(3), 3.0 + 12.0 * t * t],
];

impl Sheet {
    fn new(
        name: &'static str,
        pattern: CreasePattern,
        forms: &[fn(f64) -> [f64; 2]],
        t: f64,
    ) -> Self {
        let groups = CreaseGroups::find(&pattern);
        let goals: Vec<_> = pattern
            .creases()
            .iter()
            .map(|&id| pattern.edge(id).goal)
            .collect();
        let tangents = groups.reduce(&goals).into_iter().map(|angle| {
            let angle = angle.unwrap();
            let alike =
                |form: &&fn(f64) -> [f64; 2]| (form(t)[0] - (angle / 2.0).tan().abs()).abs() < 1e-9;
            assert!(
                angle > 0.0,
                "the sign of a group is that of its first crease"
            );
            *forms.iter().find(alike).unwrap()
        });
        let tangents: Vec<_> = tangents.collect();
        let largest = (0..tangents.len())
            .max_by(|&a, &b| tangents[a](1.0)[0].total_cmp(&tangents[b](1.0)[0]));
        let stars = ReducedStars::all(&pattern, &groups).essential();
        Self {
            name,
            groups,
            stars,
            largest: largest.unwrap(),
            tangents,
            pattern,
        }
    }

    fn miura(rows: usize, columns: usize) -> Self {
        let sheet = Miura {
            rows,
            columns,
            sector_angle: 60_f64.to_radians(),
            fold: 0.5,
        };
        let pattern = CreasePattern::new(sheet.drawing().unwrap()).unwrap();
        Self::new("miura", pattern, &MIURA, 1.0)
    }

    fn waterbomb(rows: usize, columns: usize) -> Self {
        let sheet = Waterbomb {
            rows,
            columns,
            fold: 0.5,
        };
        let pattern = CreasePattern::new(sheet.drawing().unwrap()).unwrap();
        let t = (Waterbomb::angles(core::f64::consts::FRAC_PI_2).middle / 2.0).tan();
        Self::new("waterbomb", pattern, &WATERBOMB, t)
    }

    /// The parameter at which the largest fold angle is this (radians).
    fn parameter(&self, angle: f64) -> f64 {
        let (mut low, mut high) = (0.0, 1e3);
        for _ in 0..200 {
            let middle = (low + high) / 2.0;
            if self.tangents[self.largest](middle)[0] < (angle / 2.0).tan() {
                low = middle;
            } else {
                high = middle;
            }
        }
        low
    }

    /// Curves from where the largest angle is one to where it is the other; by t, or by that angle.
    fn curves(&self, kind: Interpolation, ends: [f64; 2], by_t: bool) -> Vec<Curve<f64>> {
        let t = ends.map(|angle| self.parameter(angle));
        let span = if by_t { t[1] - t[0] } else { ends[1] - ends[0] };
        let tangents = self.tangents.iter().map(|form| {
            let [from, to] = t.map(|t| {
                let [p, dp] = form(t);
                let [q, dq] = self.tangents[self.largest](t);
                let speed = if by_t {
                    1.0
                } else {
                    (1.0 + q * q) / (2.0 * dq)
                };
                Node {
                    angle: 2.0 * p.atan(),
                    rate: 2.0 * dp / (1.0 + p * p) * speed,
                    weight: [1.0, 0.0],
                }
            });
            Curve::between(kind, span, from, to)
        });
        tangents.collect()
    }
}

/// Largest residual of each star by the report's matrices, over a thousand samples.
fn sampled(stars: StarsView<'_, f64>, curves: &[Curve<f64>]) -> Vec<f64> {
    let mut worst = vec![0.0_f64; stars.len()];
    for sample in 0..=1000 {
        let s = f64::from(sample) / 1000.0;
        let angles: Vec<f64> = curves.iter().map(|curve| curve.angle(s)).collect();
        for (worst, star) in worst.iter_mut().zip(stars.iter()) {
            let l = local_foldability_matrix(star, [0.0; 2], &angles);
            let off = l.fixed_view::<3, 3>(0, 0) - Matrix3::identity();
            *worst = worst.max(off.norm() / core::f64::consts::SQRT_2);
        }
    }
    worst
}

/// Scales both parts of a homogeneous curve, or all of an angle.
fn scaled(curve: &Curve<f64>, factor: f64) -> Curve<f64> {
    let scale = |b: &[f64; 4]| b.map(|b| b * factor);
    match curve {
        Curve::Angle(angle) => Curve::Angle(scale(angle)),
        Curve::HalfAngle { cos, sin } => Curve::HalfAngle {
            cos: scale(cos),
            sin: scale(sin),
        },
    }
}

/// Checks both sides; returns bound over sample.
fn judge(name: &str, stars: StarsView<'_, f64>, curves: &[Curve<f64>], floor: f64) -> f64 {
    let mut certifier = SegmentCertifier::default();
    let closure = certifier.closure(stars, LoopsView::none(), curves);
    let samples = sampled(stars, curves);
    let mut ratio = 0.0_f64;
    let most = samples.iter().copied().fold(0.0, f64::max);
    for (&bound, &sample) in closure.stars.iter().zip(&samples) {
        assert!(bound >= sample, "{name}: {bound:e} below {sample:e}");
        ratio = ratio.max(bound / sample.max(most / 2.0).max(floor));
    }
    // A curve that swings out far beyond its knots has coefficients far larger than its values, and
    // roundings to match.
    let swings = curves.iter().any(|curve| {
        let ends = [curve.angle(0.0), curve.angle(1.0)];
        let [low, high] = range(curve);
        ends[0].min(ends[1]) - low > 0.2 || high - ends[0].max(ends[1]) > 0.2
    });
    let floor = if swings { 1e-12 } else { 1e-13 };
    assert!(
        closure.worst() <= 10.0 * most.max(floor),
        "{name}: {:e} far above {most:e}",
        closure.worst()
    );
    ratio
}

#[test]
fn closure_of_closed_forms_is_bounded_tightly() {
    for sheet in [Sheet::miura(3, 3), Sheet::waterbomb(8, 10)] {
        for kind in KINDS {
            for by_t in [false, true] {
                let mut worst = 0.0_f64;
                for degrees in [0.1, 1.0, 5.0, 10.0, 20.0, 60.0] {
                    for start in [0.0, 7.0, 45.0, 90.0, 115.0] {
                        let ends = [start, start + degrees].map(f64::to_radians);
                        let curves = sheet.curves(kind, ends, by_t);
                        let name = format!("{} {kind:?} {start} {degrees} {by_t}", sheet.name);
                        worst = worst.max(judge(&name, sheet.stars.view(), &curves, 1e-13));
                    }
                }
                println!("{} {kind:?} by t {by_t}: {worst:.3}", sheet.name);
            }
        }
    }
}
