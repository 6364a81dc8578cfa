//! Tests certificates of whole segments: no bound is below a value that is sampled by another computation, and none is
//! far above it.

use crate::common::{miura, noise};
use foldpath::certificate::{FoldingCertifier, SegmentCertifier, SheetCertifier, range, rate};
use foldpath::folding::{FoldingMap, Rigidity, SpanningTree, rounding};
use foldpath::generate::Waterbomb;
use foldpath::pattern::{CreasePattern, Drawing};
use foldpath::symmetry::{CreaseGroups, ReducedStars};
use foldpath_core::{
    Curve, GroupId, Interpolation, LoopsView, Node, Spoke, StarsView, folding_matrix,
    local_foldability_matrix,
};
use nalgebra::{Matrix3, Matrix4};
use rand_pcg::Pcg64;

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
    /// Polynomial of each group, and its derivative.
    tangents: Vec<fn(f64) -> [f64; 2]>,
    /// Index of the group with the largest fold angle.
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
        let pattern = CreasePattern::new(miura(rows, columns, 0.5)).unwrap();
        Self::new("miura", pattern, &MIURA, 1.0)
    }

    /// Returns the 5x5 Miura fold without the face in the middle.
    fn with_a_hole() -> Self {
        let sheet = Self::miura(5, 5);
        let faces = sheet.pattern.faces().iter().enumerate();
        let faces = faces.filter(|(index, _)| *index != 12);
        let drawing = Drawing {
            faces: Some(
                faces
                    .map(|(_, f)| f.iter().map(|v| v.index()).collect())
                    .collect(),
            ),
            ..miura(5, 5, 0.5)
        };
        Self::new(
            "miura with a hole",
            CreasePattern::new(drawing).unwrap(),
            &MIURA,
            1.0,
        )
    }

    fn waterbomb(rows: usize, columns: usize) -> Self {
        let sheet = Waterbomb {
            rows,
            columns,
            fold: 0.5,
        };
        let pattern = CreasePattern::new(sheet.drawing().unwrap()).unwrap();
        let [middle, ..] = Waterbomb::angles(core::f64::consts::FRAC_PI_2);
        let t = (middle / 2.0).tan();
        Self::new("waterbomb", pattern, &WATERBOMB, t)
    }

    /// Returns the parameter at which the largest fold angle is `angle` (radians).
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

    /// Returns curves between two values of the largest angle (radians). Time is proportional to t, or to that angle.
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

/// Returns the largest residual of each star over a thousand samples, by the report's matrices.
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

/// Scales both parts of a homogeneous curve, or the whole of an angle curve.
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

/// Asserts that bounds are neither below the samples nor far above them. Returns the largest bound over its sample.
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
    // A curve that swings far beyond its knots has coefficients far larger than its values, and rounding errors of that
    // size.
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

/// Returns a star of random creases, each with a group of its own.
fn random_star(degree: u32, random: &mut Pcg64) -> Vec<Spoke<f64>> {
    let spoke = |group| {
        let (sin, cos) = (3.0 * noise(random)).sin_cos();
        Spoke {
            group: GroupId(group),
            negative: noise(random) < 0.0,
            direction: [cos, sin],
        }
    };
    (0..degree).map(spoke).collect()
}

fn random_curve(kind: Interpolation, size: f64, random: &mut Pcg64) -> Curve<f64> {
    let start = 1.5 * noise(random);
    let mut node = |angle| Node {
        angle,
        rate: size * noise(random),
        weight: [1.0 + 0.5 * noise(random), 0.5 * noise(random)],
    };
    let (from, to) = (node(start), node(start));
    let to = Node {
        angle: start + size * noise(random),
        ..to
    };
    Curve::between(kind, 1.0, from, to)
}

/// The stars do not close at all. Each crease has a curve of its own; some stars have curves of all kinds.
#[test]
fn closure_of_random_stars_is_bounded_tightly() {
    let mut random = Pcg64::new(17, 1);
    let mut certifier = SegmentCertifier::default();
    let (mut most, mut sum, mut count) = (0.0_f64, 0.0, 0.0);
    for degree in 3..=8 {
        for size in [1e-9, 1e-4, 0.02, 0.2, 1.0] {
            for sample in 0..20 {
                let star = random_star(degree, &mut random);
                let mixed = |k: u32| KINDS[((k * (sample % 2) + sample / 2) % 4) as usize];
                let curves: Vec<_> = (0..degree)
                    .map(|k| random_curve(mixed(k), size, &mut random))
                    .collect();
                let ends = [degree];
                let stars = StarsView::new(&star, &ends, degree as usize).unwrap();
                let bound = certifier.closure(stars, LoopsView::none(), &curves).worst();
                let seen = sampled(stars, &curves)[0];
                assert!(bound >= seen, "{degree} {size:e}: {bound} below {seen}");
                assert!(
                    bound <= 1.6 * seen,
                    "{degree} {size:e}: {bound} far above {seen}"
                );
                most = most.max(bound / seen);
                sum += bound / seen;
                count += 1.0;
            }
        }
    }
    println!("most {most:.3}, mean {:.3}", sum / count);
    assert!(sum / count < 1.3);
}

/// A homogeneous half angle does not depend on its scale, and a tiny motion is bounded like a large one.
#[test]
fn scale_does_not_matter() {
    for sheet in [Sheet::miura(3, 3), Sheet::waterbomb(8, 10)] {
        for degrees in [1.0, 10.0, 40.0] {
            let ends = [30.0, 30.0 + degrees].map(f64::to_radians);
            for kind in [Interpolation::HalfAngle, Interpolation::Homogeneous] {
                let curves = sheet.curves(kind, ends, false);
                for factor in [1e-9, 1e6, 1e60] {
                    let curves: Vec<_> = curves.iter().map(|c| scaled(c, factor)).collect();
                    judge(sheet.name, sheet.stars.view(), &curves, 1e-13);
                }
            }
            for kind in [Interpolation::Linear, Interpolation::Hermite] {
                let curves = sheet.curves(kind, ends, false);
                let curves: Vec<_> = curves.iter().map(|c| scaled(c, 1e-9)).collect();
                judge(sheet.name, sheet.stars.view(), &curves, 1e-13);
            }
        }
    }
}

/// The whole motion from flat to flat-folded is one segment without error.
#[test]
fn whole_motions_are_certified() {
    let line = |c: [f64; 2], n: [f64; 2]| {
        let line =
            |[from, to]: [f64; 2]| [from, (2.0 * from + to) / 3.0, (from + 2.0 * to) / 3.0, to];
        Curve::HalfAngle {
            cos: line(c),
            sin: line(n),
        }
    };
    let sheet = Sheet::miura(3, 3);
    let slopes = sheet.tangents.iter().map(|form| form(1.0)[0]);
    let curves: Vec<_> = slopes.map(|k| line([1.0, 0.0], [0.0, k])).collect();
    judge("miura", sheet.stars.view(), &curves, 1e-13);
    let mut certifier = SegmentCertifier::default();
    let bound = certifier
        .closure(sheet.stars.view(), LoopsView::none(), &curves)
        .worst();
    assert!(bound <= 1e-13, "{bound:e}");
    // This motion passes through flat to both sides: the angle turns by a whole turn.
    let curves: Vec<_> = sheet
        .tangents
        .iter()
        .map(|form| {
            let k = form(1.0)[0];
            Curve::HalfAngle {
                cos: [0.0, 1.0, 1.0, 0.0],
                sin: [-k, -k, k, k],
            }
        })
        .collect();
    judge("miura", sheet.stars.view(), &curves, 1e-13);
}

#[test]
fn what_is_no_number_has_no_bound() {
    let sheet = Sheet::miura(3, 3);
    let mut certifier = SegmentCertifier::default();
    let sound = sheet.curves(Interpolation::HalfAngle, [0.5, 0.6], false);
    for bad in [
        Curve::Angle([0.0, f64::NAN, 0.0, 0.0]),
        Curve::Angle([0.0, f64::INFINITY, 0.0, 0.0]),
        Curve::HalfAngle {
            cos: [0.0; 4],
            sin: [0.0; 4],
        },
        Curve::HalfAngle {
            cos: [1.0, f64::NAN, 1.0, 1.0],
            sin: [0.0; 4],
        },
        Curve::HalfAngle {
            cos: [-1.0, -1.0, 1.0, 1.0],
            sin: [0.0; 4],
        },
    ] {
        let curves = [bad, sound[1]];
        let closure = certifier.closure(sheet.stars.view(), LoopsView::none(), &curves);
        assert!(closure.worst() == f64::INFINITY, "{bad:?}");
        assert!(rate(&bad) == f64::INFINITY, "{bad:?}");
    }
}

/// Ranges contain all samples and are reached. Rates bound all derivatives.
#[test]
fn ranges_and_rates_hold_all_samples() {
    let mut random = Pcg64::new(23, 1);
    let mut loosest = 1.0_f64;
    for kind in KINDS {
        for size in [1e-6, 0.1, 1.0] {
            for _ in 0..50 {
                let curve = random_curve(kind, size, &mut random);
                let [low, high] = range(&curve);
                let most = rate(&curve);
                let (mut least, mut largest, mut fastest) = (f64::INFINITY, -f64::INFINITY, 0.0);
                for sample in 0..=4000 {
                    let s = f64::from(sample) / 4000.0;
                    least = curve.angle(s).min(least);
                    largest = curve.angle(s).max(largest);
                    fastest = curve.derivatives(s)[0].abs().max(fastest);
                }
                assert!(low <= least && largest <= high, "{curve:?}");
                // The largest value lies between samples, above them by less than the square of their distance.
                assert!(
                    high - largest < 1e-6 * size + 1e-11,
                    "{curve:?} {high} {largest}"
                );
                assert!(least - low < 1e-6 * size + 1e-11, "{curve:?} {low} {least}");
                assert!(fastest <= most, "{curve:?}: {fastest} over {most}");
                loosest = loosest.max(most / fastest);
            }
        }
    }
    println!("rates at most {loosest:.3} times the fastest");
    assert!(loosest < 1.5);
}

/// Tests two bounds on deformation, gap and twist of the whole folded sheet, whether or not it closes to rounding
/// errors. Sampled values are below the bound from the closure of the essential vertices. They are also below half the
/// bound from folding the whole sheet, which is near them.
#[test]
fn errors_of_the_folded_sheet_are_certified() {
    let mut loosest = 0.0_f64;
    for sheet in [
        Sheet::miura(3, 3),
        Sheet::miura(11, 11),
        Sheet::miura(24, 24),
        Sheet::with_a_hole(),
        Sheet::waterbomb(4, 6),
        Sheet::waterbomb(8, 10),
    ] {
        let tree = sheet.pattern.tree();
        let all = ReducedStars::all(&sheet.pattern, &sheet.groups);
        // Rounding errors of a loop's translation are bounded more coarsely.
        let within = if all.loops().is_empty() { 1e3 } else { 1e4 };
        let mut closure = SegmentCertifier::default();
        let mut certifier = SheetCertifier::new(&sheet.pattern, tree, &all).unwrap();
        let memberships = sheet.groups.memberships();
        let mut folded = FoldingCertifier::new(&sheet.pattern, memberships);
        let trees = SpanningTree::diverse(&sheet.pattern);
        let lost = trees
            .each_ref()
            .map(|tree| rounding(&sheet.pattern, tree).worst());
        let lost = lost.into_iter().fold(0.0, f64::max);
        let mut map = FoldingMap::new(
            &sheet.pattern,
            tree,
            &vec![0.0; sheet.pattern.creases().len()],
        );
        for (kind, by_t, degrees) in [
            (Interpolation::HalfAngle, true, 10.0),
            (Interpolation::HalfAngle, true, 60.0),
            (Interpolation::Homogeneous, false, 10.0),
            (Interpolation::Hermite, false, 1.0),
            (Interpolation::Hermite, false, 10.0),
            (Interpolation::Linear, false, 0.1),
            (Interpolation::Linear, false, 10.0),
        ] {
            let ends = [60_f64, 60.0 + degrees].map(f64::to_radians);
            let curves = sheet.curves(kind, ends, by_t);
            let closed = closure.closure(sheet.stars.view(), sheet.stars.loops(), &curves);
            let bound = certifier.rigidity(closed);
            let (mut worst, mut all) = (Rigidity::default(), Rigidity::default());
            for sample in 0..=200 {
                let s = f64::from(sample) / 200.0;
                let x: Vec<f64> = curves.iter().map(|curve| curve.angle(s)).collect();
                let angles = sheet.groups.expand(&x);
                map.fold(&sheet.pattern, tree, &angles);
                worst = worst.worse(map.rigidity(&sheet.pattern, tree));
                for tree in &trees {
                    map.fold(&sheet.pattern, tree, &angles);
                    all = all.worse(map.rigidity(&sheet.pattern, tree));
                }
            }
            let near = folded
                .rigidity(&curves, 1.7 * all.worst() + 12.0 * lost)
                .unwrap();
            for (near, seen) in [
                (near.deformation, all.deformation),
                (near.gap, all.gap),
                (near.twist, all.twist),
            ] {
                assert!(
                    (seen..=1.6 * seen + 16.0 * lost).contains(&near),
                    "{} {kind:?}: {near:e} is not near {seen:e}, {lost:e} lost",
                    sheet.name
                );
            }
            for (bound, seen) in [
                (bound.deformation, worst.deformation),
                (bound.gap, worst.gap),
                (bound.twist, worst.twist),
            ] {
                assert!(
                    bound >= seen,
                    "{} {kind:?}: {bound:e} below {seen:e}",
                    sheet.name
                );
                assert!(
                    bound <= within * seen,
                    "{} {kind:?}: {bound:e} far above {seen:e}",
                    sheet.name
                );
                loosest = loosest.max(bound / seen);
            }
        }
    }
    println!("at most {loosest:.0} times what is sampled");
}

/// Both residuals of loops round holes are compared, on random motions, with samples by products of rigid motions.
#[test]
fn loops_are_bounded_too() {
    let mut random = Pcg64::new(29, 1);
    let mut certifier = SegmentCertifier::default();
    let mut loosest = 0.0_f64;
    for degree in [1, 3, 8, 20] {
        for kind in KINDS {
            for size in [1e-4, 0.05, 0.3] {
                let spokes = random_star(degree, &mut random);
                let mut place = |_| [noise(&mut random), noise(&mut random)];
                let places: Vec<[f64; 2]> = (0..degree).map(&mut place).collect();
                let curves: Vec<_> = (0..degree)
                    .map(|_| random_curve(kind, size, &mut random))
                    .collect();
                let ends = [degree];
                let loops = LoopsView::new(&spokes, &places, &ends, degree as usize).unwrap();
                let none: [Spoke<f64>; 0] = [];
                let stars = StarsView::new(&none, &[], 0).unwrap();
                let bound = certifier.closure(stars, loops, &curves).loops[0];
                let mut seen = [0.0_f64; 2];
                for sample in 0..=1000 {
                    let s = f64::from(sample) / 1000.0;
                    let residuals = moved(&spokes, &places, &curves, s);
                    seen = [seen[0].max(residuals[0]), seen[1].max(residuals[1])];
                }
                for (bound, seen) in bound.into_iter().zip(seen) {
                    assert!(
                        bound >= seen,
                        "{degree} {kind:?} {size}: {bound} below {seen}"
                    );
                    let seen = seen.max(1e-13);
                    assert!(
                        bound <= 2.0 * seen,
                        "{degree} {kind:?} {size}: {bound} above {seen}"
                    );
                    loosest = loosest.max(bound / seen);
                }
            }
        }
    }
    println!("at most {loosest:.2} times what is sampled");
}

/// Returns ‖L − I‖ / √2 and the shift of the origin, by folding matrices about the places.
fn moved(spokes: &[Spoke<f64>], places: &[[f64; 2]], curves: &[Curve<f64>], s: f64) -> [f64; 2] {
    let factors = spokes.iter().zip(places).map(|(spoke, place)| {
        let [cos, sin] = spoke.direction;
        let angle = curves[spoke.group.index()].angle(s);
        let angle = if spoke.negative { -angle } else { angle };
        folding_matrix(*place, sin.atan2(cos), angle)
    });
    let l: Matrix4<f64> = factors.product();
    let off = l.fixed_view::<3, 3>(0, 0) - Matrix3::identity();
    let shift = l.fixed_view::<3, 1>(0, 3).norm();
    [off.norm() / core::f64::consts::SQRT_2, shift]
}
