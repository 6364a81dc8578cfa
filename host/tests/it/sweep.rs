//! Tests sweeps of whole motions for crossings against closed forms and dense sampling.

use core::f64::consts::PI;
use std::collections::HashMap;
use std::path::Path;

use crate::common::class_of;
use foldpath::collision::{CollisionScene, Sweep, SweepOptions, SweepVerdict};
use foldpath::folding::{FoldingMap, SpanningTree};
use foldpath::generate::Yoshimura;
use foldpath::lattice::Lattice;
use foldpath::pattern::{CreasePattern, Drawing, DrawnEdge, FaceId, Letter};
use foldpath::read::read_pattern;
use foldpath::symmetry::CreaseGroups;
use foldpath_core::{Curve, GroupId, Membership};
use nalgebra::Vector2;
use rand_pcg::Pcg64;
use rand_pcg::rand_core::Rng;

type Motion = Vec<Vec<Curve<f64>>>;

/// Returns a pattern of `patterns/`, the memberships of its creases, and its closed-form motion from flat to its goal.
/// The tangents of half the fold angles keep their ratios, except that the waterbomb's boundary lines have 3t + 4t³.
fn folded(name: &str) -> (CreasePattern, Vec<Membership>, Motion) {
    let path = format!("{}/../patterns/{name}.fold", env!("CARGO_MANIFEST_DIR"));
    to_goal(read_pattern(Path::new(&path)).unwrap().pattern, name)
}

/// Returns a pattern of the family `name` with its memberships and closed-form motion, as `folded` does.
fn to_goal(pattern: CreasePattern, name: &str) -> (CreasePattern, Vec<Membership>, Motion) {
    let groups = CreaseGroups::find(&pattern);
    let mut tangents = vec![0.0_f64; groups.len()];
    for (&edge, member) in pattern.creases().iter().zip(groups.memberships()) {
        let goal = member.apply(pattern.edge(edge).goal.unwrap());
        tangents[member.group.index()] = (goal / 2.0).tan();
    }
    let sizes = || tangents.iter().map(|tangent| tangent.abs());
    let (least, most) = (
        sizes().fold(f64::MAX, f64::min),
        sizes().fold(0.0, f64::max),
    );
    let curve = |&tangent: &f64| {
        let cubic = if name.starts_with("waterbomb") && tangent.abs() >= most {
            4.0 * least.powi(3) * tangent.signum()
        } else {
            0.0
        };
        let third = (tangent - cubic) / 3.0;
        Curve::HalfAngle {
            cos: [1.0; 4],
            sin: [0.0, third, 2.0 * third, tangent],
        }
    };
    let motion = vec![tangents.iter().map(curve).collect()];
    (pattern, groups.memberships().to_vec(), motion)
}

/// Returns the pattern of these vertices and edges. Each edge between two faces is a crease with a group of its own.
fn drawn(vertices: &[[f64; 2]], edges: &[[usize; 2]]) -> (CreasePattern, Vec<Membership>) {
    let edge = |&ends: &[usize; 2]| DrawnEdge {
        ends,
        letter: Letter::Unassigned,
        goal: None,
    };
    let drawing = Drawing {
        vertices: vertices.iter().map(|&v| Vector2::from(v)).collect(),
        edges: edges.iter().map(edge).collect(),
        ..Drawing::default()
    };
    let pattern = CreasePattern::new(drawing).unwrap();
    let own = |group| Membership {
        group: GroupId(group),
        negative: false,
    };
    let memberships = (0..).take(pattern.creases().len()).map(own).collect();
    (pattern, memberships)
}

/// Returns a strip of panels along x. The k-th edge across the strip runs from (x, 0) to (x + shear, 1).
fn strip(places: &[f64], shears: &[f64]) -> (CreasePattern, Vec<Membership>) {
    let mut vertices = Vec::new();
    let mut edges = Vec::new();
    for (k, (x, shear)) in places.iter().zip(shears).enumerate() {
        vertices.extend([[*x, 0.0], [x + shear, 1.0]]);
        edges.push([2 * k, 2 * k + 1]);
        if k > 0 {
            edges.extend([[2 * k - 2, 2 * k], [2 * k - 1, 2 * k + 1]]);
        }
    }
    drawn(&vertices, &edges)
}

/// Returns sectors round a vertex, each from one ray (degrees) to the next.
fn fan(rays: &[f64]) -> (CreasePattern, Vec<Membership>) {
    let mut vertices = vec![[0.0, 0.0]];
    let mut edges = Vec::new();
    for (k, ray) in (1..).zip(rays) {
        let (sin, cos) = ray.to_radians().sin_cos();
        vertices.push([cos, sin]);
        edges.push([0, k]);
        if k > 1 {
            edges.push([k - 1, k]);
        }
    }
    drawn(&vertices, &edges)
}

/// Returns a curve that is linear in the fold angle, between these angles (degrees).
fn line(from: f64, to: f64) -> Curve<f64> {
    let [from, to] = [from, to].map(f64::to_radians);
    let third = (to - from) / 3.0;
    Curve::Angle([from, from + third, to - third, to])
}

fn sweep(
    (pattern, memberships): &(CreasePattern, Vec<Membership>),
    motion: &Motion,
) -> SweepVerdict {
    Sweep::new(pattern, memberships, SweepOptions::default(), None).sweep(motion)
}

#[track_caller]
fn crossing_at(verdict: SweepVerdict) -> ([FaceId; 2], f64) {
    match verdict {
        SweepVerdict::Crossing {
            crossing,
            at,
            last_free: Some(free),
        } => {
            assert_eq!(at.segment, free.segment);
            assert!(free.s < at.s && at.s - free.s < 2e-6, "{verdict:?}");
            (crossing.faces, at.s)
        }
        _ => panic!("{verdict:?}"),
    }
}

#[track_caller]
fn clearance(verdict: SweepVerdict) -> f64 {
    match verdict {
        SweepVerdict::Free(clearance) => clearance.map_or(f64::INFINITY, |c| c.distance),
        _ => panic!("{verdict:?}"),
    }
}

#[test]
fn miura_folds_are_free_and_their_clearance_is_the_width_of_a_pleat() {
    for name in ["miura-3x3", "miura-5x5", "miura-11x11"] {
        let (pattern, memberships, motion) = folded(name);
        let found = clearance(sweep(&(pattern, memberships), &motion));
        // Two faces of a row with one panel between them are parallel. The panel has the height sin 60° and stands at
        // 10° to them. In a column it stands at the angle of the straight creases, whose half-angle tangent is half as
        // large.
        let zigzag = 60_f64.to_radians().sin() * 170_f64.to_radians().sin();
        let straight = 2.0 * (85_f64.to_radians().tan() / 2.0).atan();
        let straight = 60_f64.to_radians().sin() * straight.sin();
        assert!(found < zigzag.min(straight) + 1e-9, "{name}: {found}");
        assert!(found > 0.9 * zigzag.min(straight), "{name}: {found}");
    }
}

#[test]
fn the_waterbomb_tube_is_free_until_it_closes() {
    let (pattern, memberships, motion) = folded("waterbomb-12x22");
    assert!(clearance(sweep(&(pattern, memberships), &motion)) > 0.1);
    let (pattern, memberships, motion) = folded("waterbomb-12x22-crossing");
    let (_, s) = crossing_at(sweep(&(pattern, memberships), &motion));
    // The tube closes if the angle of boundary lines less that of middle lines is 60°: twelve squares round the tube
    // then make a full turn.
    let angles = motion[0].iter().map(|curve| curve.angle(s).abs());
    let (least, most) = angles.fold((PI, 0.0_f64), |(l, m), angle| (l.min(angle), m.max(angle)));
    let turn = (most - least).to_degrees();
    assert!((turn - 60.0).abs() < 1e-3, "{turn}");
    assert!((most.to_degrees() / 108.0 - 0.8798).abs() < 1e-2);
}

#[test]
fn a_flap_that_passes_through_within_a_segment_is_found() {
    // The strip is a box of floor, wall and roof, and a longer flap that comes in from outside. At a right angle the
    // flap stands on the rim of the floor, at the end it is inside.
    let box_ = strip(&[0.0, 2.0, 3.0, 5.0, 6.5], &[0.0; 5]);
    let motion = |end: f64| vec![vec![line(90.0, 90.0), line(90.0, 90.0), line(0.0, end)]];
    let (faces, s) = crossing_at(sweep(&box_, &motion(150.0)));
    assert_eq!(faces, [FaceId(0), FaceId(3)]);
    assert!((s - 0.6).abs() < 1e-5, "{s}");
    assert!(s > 0.6);
    let mut sampler = Sampler::new(&box_);
    let ends = [0.0, 1.0].map(|s| sampler.depth(&motion(150.0), 0, s));
    assert!(ends.iter().all(|&depth| depth <= 0.0));
    assert!(clearance(sweep(&box_, &motion(89.0))) > 0.01);
}

#[test]
fn what_rounded_coordinates_explain_is_contact() {
    // This is the box of the test above. The floor is at distance 1 from the flap's hinge, so past a right angle the
    // flap is as deep in the floor as the angle (radians) by which it has turned.
    let box_ = strip(&[0.0, 2.0, 3.0, 5.0, 6.5], &[0.0; 5]);
    let motion = vec![vec![line(90.0, 90.0), line(90.0, 90.0), line(0.0, 150.0)]];
    let (pattern, memberships) = &box_;
    for contact in [1e-9, 1e-6, 1e-5, 1e-4, 1e-3] {
        let options = SweepOptions::default().with(|it| it.contact = contact);
        let (faces, s) =
            crossing_at(Sweep::new(pattern, memberships, options, None).sweep(&motion));
        assert_eq!(faces, [FaceId(0), FaceId(3)]);
        let turned = (150.0 * s - 90.0).to_radians();
        let depth = contact * pattern.median_edge();
        let sooner = turned / depth;
        assert!(
            (0.9..2.0).contains(&sooner),
            "{contact:e}: {turned:e}, {depth:e}"
        );
        // The verdict on one configuration is the same.
        let tree = pattern.tree();
        let mut scene = CollisionScene::new(pattern);
        let mut crosses = |turned: f64| {
            let angles = [PI / 2.0, PI / 2.0, PI / 2.0 + turned];
            let map = FoldingMap::new(pattern, tree, &angles);
            scene.deepest_crossing(&map, contact).is_some()
        };
        assert!(crosses(1.01 * turned) && !crosses(0.9 * depth));
    }
}

#[test]
fn sectors_that_pass_through_each_other_are_found() {
    // The first sector stands at 30° over the second. The third sector is shorter, turns over from outside and ends
    // under the first. It meets the corner of the first where its angle to the second is the base angle of an isosceles
    // spherical triangle.
    let sectors = fan(&[0.0, 60.0, 120.0, 150.0]);
    let motion = |end: f64| vec![vec![line(150.0, 150.0), line(0.0, end)]];
    let base = (1.0 / (60_f64.to_radians().cos() * 15_f64.to_radians().tan())).atan();
    let (faces, s) = crossing_at(sweep(&sectors, &motion(170.0)));
    assert_eq!(faces, [FaceId(0), FaceId(2)]);
    let expected = (180.0 - base.to_degrees()) / 170.0;
    assert!((s - expected).abs() < 1e-5, "{s}, not {expected}");
    let mut sampler = Sampler::new(&sectors);
    let ends = [0.0, 1.0].map(|s| sampler.depth(&motion(170.0), 0, s));
    assert!(ends.iter().all(|&depth| depth <= 0.0));
    assert!(matches!(
        sweep(&sectors, &motion(90.0)),
        SweepVerdict::Free(None)
    ));
}

#[test]
fn layers_that_touch_at_half_a_turn_are_contact() {
    let accordion = strip(&[0.0, 1.0, 2.0, 3.0, 4.0], &[0.0, 0.2, 0.0, 0.2, 0.0]);
    let turn = [180.0, -180.0, 180.0];
    let motion = vec![turn.iter().map(|&angle| line(0.0, angle)).collect()];
    let (pattern, memberships) = &accordion;
    let mut sweep = Sweep::new(pattern, memberships, SweepOptions::default(), None);
    assert!(clearance(sweep.sweep(&motion)) < 1e-6);
    assert!(sweep.counts().tested < 500, "{:?}", sweep.counts());
}

#[test]
fn flaps_that_turn_about_the_same_line_do_not_pass_through_each_other() {
    // The third panel lies on the second, so the hinge of the fourth panel lies on that of the first. The fourth panel
    // comes to lie on the first.
    let flaps = strip(&[0.0, 0.6, 1.6, 2.6, 3.1], &[0.0; 5]);
    let motion = |end: f64| {
        let still = || line(180.0, 180.0);
        vec![
            vec![line(0.0, 0.0), line(0.0, 180.0), line(0.0, 0.0)],
            vec![line(0.0, 30.0), still(), line(0.0, -60.0)],
            vec![line(30.0, 90.0), still(), line(-60.0, end)],
        ]
    };
    let (faces, s) = crossing_at(sweep(&flaps, &motion(-40.0)));
    assert_eq!(faces, [FaceId(0), FaceId(3)]);
    assert!((s - 0.375).abs() < 1e-5, "{s}");
    assert!(clearance(sweep(&flaps, &motion(-90.0))) < 1e-12);
}

#[test]
fn layers_that_turn_nearly_alike_are_followed_together() {
    let flaps = strip(&[0.0, 0.6, 1.6, 2.6, 3.1], &[0.0; 5]);
    // The fourth panel lies on the first. On the way it is ahead of the first by about `ahead` radians, or behind it if
    // `ahead` is negative.
    let looks = |ahead: f64| {
        let turns = [0.0, 0.5 + ahead, 1.0 + ahead, 1.5];
        let back = Curve::Angle(turns.map(|turn| -turn));
        let motion = vec![
            vec![line(0.0, 0.0), line(0.0, 180.0), line(0.0, 0.0)],
            vec![Curve::Angle([0.0, 0.5, 1.0, 1.5]), line(180.0, 180.0), back],
        ];
        let mut sweep = Sweep::new(&flaps.0, &flaps.1, SweepOptions::default(), None);
        (sweep.sweep(&motion), sweep.counts().tested)
    };
    let (_, alike) = looks(0.0);
    for ahead in [1e-7, 1e-6, 1e-5, 5e-5] {
        let (verdict, tested) = looks(ahead);
        assert!(clearance(verdict) < 1e-12);
        assert!(tested < 20 * alike, "{ahead:e}: {tested}, {alike} alike");
    }
    let (faces, s) = crossing_at(looks(-1e-5).0);
    assert_eq!(faces, [FaceId(0), FaceId(3)]);
    // The shorter panel, 0.5 long, turns through the other by 3 s (1 - s) 1e-5. Its depth counts from 1e-6 on.
    let part = 1e-6 / 0.5 / 3e-5;
    assert!((part..3.0 * part).contains(&s), "{s}");
}

/// The fourth panel or sector lies on the first, and is behind it on the way by an angle within contact, so that no plane is
/// between them. All hinges turn.
#[test]
fn layers_behind_each_other_within_contact_take_few_queries() {
    let panels = strip(&[0.0, 0.6, 1.6, 2.6, 3.1], &[0.0; 5]);
    let sectors = fan(&[0.0, 40.0, 100.0, 160.0, 200.0]);
    for sheet in [&panels, &sectors] {
        for behind in [0.0, 1e-8, 1e-7, 1e-6, 2e-6, 3e-6, 4e-6, 5e-6] {
            let motion = vec![
                vec![line(0.0, 0.0), line(0.0, 180.0), line(0.0, 0.0)],
                vec![
                    Curve::Angle([0.0, 0.9, 1.8, 2.7]),
                    line(180.0, 180.0 - 1e-6),
                    Curve::Angle([0.0, behind - 0.9, behind - 1.8, -2.7]),
                ],
            ];
            let mut sweep = Sweep::new(&sheet.0, &sheet.1, SweepOptions::default(), None);
            let verdict = sweep.sweep(&motion);
            assert!(
                matches!(verdict, SweepVerdict::Free(_)),
                "{behind:e}: {verdict:?}"
            );
            let tested = sweep.counts().tested;
            assert!(tested < 2000, "{behind:e}: {tested}");
        }
    }
}

#[test]
fn sectors_that_lie_on_each_other_leave_in_their_order() {
    let sectors = fan(&[0.0, 60.0, 120.0, 180.0]);
    let still = || line(180.0, 180.0);
    let (turns, returns) = (|| line(0.0, 180.0), || line(180.0, 0.0));
    let motion = |last| vec![vec![turns(), line(0.0, 0.0)], vec![still(), turns()], last];
    let (faces, s) = crossing_at(sweep(&sectors, &motion(vec![returns(), still()])));
    assert_eq!(faces, [FaceId(0), FaceId(2)]);
    assert!(s < 1e-5, "{s}");
    let free = sweep(&sectors, &motion(vec![still(), returns()]));
    assert!(matches!(free, SweepVerdict::Free(None)), "{free:?}");
}

/// Ends of a panel along the strip, and `true` if its face is up.
type Place = ([i32; 2], bool);

/// State of a strip that lies flat: its creases are turned by half a turn or not at all, and of two panels that overlap
/// one is above the other. The state is followed in whole numbers, without angles.
struct Layers {
    widths: Vec<i32>,
    /// Turn of each crease: 1 for half a turn up, -1 for half a turn down, or 0.
    turned: Vec<i32>,
    /// `true` if the second panel of the pair is above the first.
    above: HashMap<[usize; 2], bool>,
}

impl Layers {
    /// Returns the place of each panel.
    fn places(&self) -> Vec<Place> {
        let (mut x, mut up) = (0, true);
        let mut place = |panel: usize| {
            if panel > 0 && self.turned[panel - 1] != 0 {
                up = !up;
            }
            let from = x;
            x += if up { 1 } else { -1 } * self.widths[panel];
            ([from.min(x), from.max(x)], up)
        };
        (0..self.widths.len()).map(&mut place).collect()
    }

    /// Turns a crease. Returns `false` if a panel that turns with it would have to pass through another panel.
    fn turn(&mut self, crease: usize, to: i32) -> bool {
        let (before, from) = (self.places(), self.turned[crease]);
        self.turned[crease] = to;
        let after = self.places();
        let (still, face_up) = before[crease];
        let hinge = still[usize::from(face_up)];
        // The panel beyond the crease leaves, and arrives, on this side of the panel that stays. All panels that turn
        // with it do so on its side of the hinge. Panels beyond the hinge go the other way.
        let upward = (from + to > 0) == face_up;
        let sides = |places: &[Place], pair: [usize; 2], panel_is_left: bool| {
            let [a, b] = pair.map(|panel| places[panel].0);
            let [low, high] = [a[0].max(b[0]), a[1].min(b[1])];
            let left = (low < high.min(hinge)).then_some(panel_is_left == upward);
            let right = (low.max(hinge) < high).then_some(panel_is_left != upward);
            left.into_iter().chain(right).collect::<Vec<_>>()
        };
        let pairs = (crease + 1..self.widths.len()).flat_map(|m| (0..=crease).map(move |p| [p, m]));
        let pairs: Vec<_> = pairs.collect();
        let next_is_left = |places: &[Place]| places[crease + 1].0[0] < hinge;
        for &pair in &pairs {
            let left = next_is_left(&before);
            if sides(&before, pair, left)
                .contains(&!self.above.get(&pair).copied().unwrap_or_default())
            {
                return false;
            }
        }
        // Panels that turn are upside down afterwards, so the order among them is reversed.
        let upside_down = self.above.iter_mut().filter(|(pair, _)| pair[0] > crease);
        upside_down.for_each(|(_, above)| *above = !*above);
        for pair in pairs {
            let left = next_is_left(&after);
            self.above.extend(
                sides(&after, pair, left)
                    .into_iter()
                    .map(|above| (pair, above)),
            );
        }
        true
    }
}

#[test]
fn panels_that_lie_on_each_other_leave_on_the_side_they_came_from() {
    let mut random = Pcg64::new(3, 8);
    let mut met = [0; 2];
    for case in 0..2000 {
        let mut below = |most: i32| {
            let most = u32::try_from(most).unwrap();
            i32::try_from(random.next_u32() % most).unwrap()
        };
        let panels = 4 + below(3);
        // With few different widths creases come to lie on each other; with many they hardly ever do.
        let unequal = if below(2) == 0 { 3 } else { 1000 };
        let widths: Vec<i32> = (0..panels).map(|_| unequal + below(unequal)).collect();
        let mut layers = Layers {
            turned: vec![0; widths.len() - 1],
            above: HashMap::new(),
            widths,
        };
        let mut place = 0.0;
        let places = layers.widths.iter().map(|&width| {
            place += f64::from(width) / f64::from(unequal);
            place
        });
        let places: Vec<f64> = [0.0].into_iter().chain(places).collect();
        let sheet = strip(&places, &vec![0.0; places.len()]);
        let mut motion = Vec::new();
        let crossed = (0..8).find(|_| {
            let crease = usize::try_from(below(panels - 1)).unwrap();
            let [before, to] = [layers.turned[crease], 2 * below(2) - 1].map(f64::from);
            let to = if before != 0.0 { 0.0 } else { to };
            let turning = |k: usize| match f64::from(layers.turned[k]) {
                from if k == crease => line(180.0 * from, 180.0 * to),
                from => line(180.0 * from, 180.0 * from),
            };
            motion.push((0..layers.turned.len()).map(turning).collect());
            #[allow(clippy::cast_possible_truncation, reason = "-1, 0 or 1")]
            let to = to as i32;
            !layers.turn(crease, to)
        });
        let verdict = sweep(&sheet, &motion);
        let found = match verdict {
            SweepVerdict::Free(_) => None,
            SweepVerdict::Crossing { at, .. } => Some(at.segment),
            _ => panic!("{case}: {verdict:?}"),
        };
        let expected = crossed.map(|_| motion.len() - 1);
        assert_eq!(
            found, expected,
            "{case}: {:?} {verdict:?} {motion:?}",
            layers.widths
        );
        met[usize::from(found.is_some())] += 1;
    }
    assert!(met.iter().all(|&met| met > 50), "{met:?}");
}

/// Panels rest on each other while others turn, and then leave through each other. These motions were missed once.
#[test]
fn panels_that_lay_on_each_other_for_long_are_not_forgotten() {
    for (widths, turns, faces) in [
        // The last panel sticks out over the fourth, and only rounding keeps them apart.
        (
            &[1.347, 1.309, 1.411, 1.791, 1.616, 1.666],
            &[(4, 1), (4, 0), (4, 1), (2, -1), (1, 1), (3, 1)][..],
            [3, 5],
        ),
        // The centers of both panels coincide to the last bit.
        (
            &[4.0, 3.0, 4.0, 3.0, 3.0, 3.0],
            &[(4, -1), (3, -1), (2, -1), (1, 1), (2, 0), (0, -1), (4, 0)],
            [3, 5],
        ),
    ] {
        let mut place = 0.0;
        let next = widths.iter().map(|width| {
            place += width;
            place
        });
        let places: Vec<f64> = core::iter::once(0.0).chain(next).collect();
        let sheet = strip(&places, &vec![0.0; places.len()]);
        let mut turned = [0.0; 5];
        let motion: Motion = turns
            .iter()
            .map(|&(crease, to)| {
                let before = turned;
                turned[crease] = 180.0 * f64::from(to);
                before
                    .iter()
                    .zip(turned)
                    .map(|(&from, to)| line(from, to))
                    .collect()
            })
            .collect();
        let verdict = sweep(&sheet, &motion);
        let SweepVerdict::Crossing { crossing, at, .. } = verdict else {
            panic!("{widths:?}: {verdict:?}");
        };
        assert_eq!(crossing.faces, faces.map(FaceId), "{verdict:?}");
        assert_eq!(at.segment, turns.len() - 1, "{verdict:?}");
    }
}

#[test]
fn a_hinge_that_turns_past_half_a_turn_is_found() {
    let pair = strip(&[0.0, 1.0, 2.0], &[0.0; 3]);
    let motion = |over: f64| vec![vec![Curve::Angle([0.0, PI + over, PI + over, PI])]];
    let (faces, s) = crossing_at(sweep(&pair, &motion(1.0)));
    assert_eq!(faces, [FaceId(0), FaceId(1)]);
    let angle = motion(1.0)[0][0].angle(s);
    assert!(angle > PI && angle < PI + 1e-5, "{angle}");
    assert!(clearance(sweep(&pair, &motion(-0.1))).is_infinite());
    let half = |cos: f64| {
        vec![vec![Curve::HalfAngle {
            cos: [1.0, 0.5, 0.1, cos],
            sin: [0.0, 0.5, 0.9, 1.0],
        }]]
    };
    assert!(clearance(sweep(&pair, &half(0.0))).is_infinite());
    let (_, s) = crossing_at(sweep(&pair, &half(-0.1)));
    let angle = half(-0.1)[0][0].angle(s);
    assert!(angle > PI && angle < PI + 1e-5, "{angle}");
}

/// A folded sheet that is tested for crossings at one place of a motion after the other.
struct Sampler<'a> {
    pattern: &'a CreasePattern,
    memberships: &'a [Membership],
    tree: &'a SpanningTree,
    scene: CollisionScene,
}

impl<'a> Sampler<'a> {
    fn new((pattern, memberships): &'a (CreasePattern, Vec<Membership>)) -> Self {
        Self {
            pattern,
            memberships,
            tree: pattern.tree(),
            scene: CollisionScene::new(pattern),
        }
    }

    /// Returns the depth of the deepest crossing; 0 if there is none.
    fn depth(&mut self, motion: &Motion, segment: usize, s: f64) -> f64 {
        let angle = |m: &Membership| m.apply(motion[segment][m.group.index()].angle(s));
        let angles: Vec<f64> = self.memberships.iter().map(angle).collect();
        let map = FoldingMap::new(self.pattern, self.tree, &angles);
        let crossing = self.scene.deepest_crossing(&map, 1e-6);
        crossing.map_or(0.0, |crossing| crossing.depth)
    }
}

/// Returns a random number from `low` to `high`.
fn uniform(random: &mut Pcg64, [low, high]: [f64; 2]) -> f64 {
    low + (high - low) * f64::from(random.next_u32()) / f64::from(u32::MAX)
}

/// Returns a random strip, fan, or square with strips on its sides.
fn random_pattern(random: &mut Pcg64) -> (CreasePattern, Vec<Membership>) {
    let count = 4 + random.next_u32() as usize % 4;
    match random.next_u32() % 3 {
        0 => {
            let mut x = 0.0;
            let mut place = |random: &mut Pcg64| {
                x += uniform(random, [0.6, 1.8]);
                x
            };
            let places: Vec<f64> = (0..count).map(|_| place(random)).collect();
            let shears: Vec<f64> = places
                .iter()
                .map(|_| uniform(random, [-0.25, 0.25]))
                .collect();
            strip(&places, &shears)
        }
        1 => {
            let widths: Vec<f64> = (0..count).map(|_| uniform(random, [20.0, 120.0])).collect();
            let scale = (350.0 / widths.iter().sum::<f64>()).min(1.0);
            let mut ray = 0.0;
            let next = widths.iter().map(|width| {
                ray += width * scale;
                ray
            });
            fan(&[vec![0.0], next.collect()].concat())
        }
        _ => star(random),
    }
}

/// Returns a unit square with a strip of two panels on each side.
fn star(random: &mut Pcg64) -> (CreasePattern, Vec<Membership>) {
    let square = [[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]];
    let (mut vertices, mut edges) = (square.to_vec(), Vec::new());
    for k in 0..4 {
        let mut side = [k, (k + 1) % 4];
        edges.push(side);
        let [from, to] = side.map(|v| Vector2::from(square[v]));
        let out = Vector2::new(to.y - from.y, from.x - to.x);
        let mut away = 0.0;
        for _ in 0..2 {
            away += uniform(random, [0.5, 1.5]);
            let next = [vertices.len(), vertices.len() + 1];
            vertices.extend([from, to].map(|end| <[f64; 2]>::from(end + out * away)));
            edges.extend([[side[0], next[0]], [side[1], next[1]], next]);
            side = next;
        }
    }
    drawn(&vertices, &edges)
}

/// Returns two joined segments of smooth curves, with angles below half a turn at their control points.
fn random_motion(random: &mut Pcg64, groups: usize) -> Motion {
    let most = 0.95 * PI;
    let mut start = vec![0.0; groups];
    let mut segment = |random: &mut Pcg64| {
        let curve = |from: &mut f64| {
            let mut next = || uniform(random, [-most, most]);
            let [a, b, to] = [next(), next(), next()];
            let from = core::mem::replace(from, to);
            if random.next_u32().is_multiple_of(2) {
                return Curve::Angle([from, a, b, to]);
            }
            let half = [from, a, b, to].map(|angle| (angle / 2.0).sin_cos());
            Curve::HalfAngle {
                cos: half.map(|half| half.1),
                sin: half.map(|half| half.0),
            }
        };
        start.iter_mut().map(curve).collect()
    };
    vec![segment(random), segment(random)]
}

#[test]
fn sweeps_agree_with_dense_sampling() {
    const SAMPLES: u32 = 2000;
    let mut random = Pcg64::new(5, 7);
    let mut met = [0; 3];
    for case in 0..60 {
        let sheet = random_pattern(&mut random);
        let motion = random_motion(&mut random, sheet.1.len());
        let mut sampler = Sampler::new(&sheet);
        let verdict = sweep(&sheet, &motion);
        let places = (0..2).flat_map(|segment| {
            (0..=SAMPLES).map(move |k| (segment, f64::from(k) / f64::from(SAMPLES)))
        });
        let mut places =
            places.map(|(segment, s)| (segment, s, sampler.depth(&motion, segment, s)));
        let sampled = places.find(|(_, _, depth)| *depth > 1e-4);
        drop(places);
        match verdict {
            SweepVerdict::Free(_) => assert_eq!(sampled, None, "{case}"),
            SweepVerdict::Crossing {
                crossing,
                at,
                last_free,
            } => {
                let depth = sampler.depth(&motion, at.segment, at.s);
                assert!(depth >= crossing.depth - 1e-12, "{case}: {verdict:?}");
                if let Some(free) = last_free {
                    assert!(
                        sampler.depth(&motion, free.segment, free.s) <= 0.0,
                        "{case}"
                    );
                }
                if let Some((segment, s, _)) = sampled {
                    let no_later = (at.segment, at.s) <= (segment, s);
                    assert!(no_later, "{case}: {verdict:?} {sampled:?}");
                }
                met[usize::from(sampled.is_none())] += 1;
            }
            _ => panic!("{case}: {verdict:?}"),
        }
        met[2] += 1;
    }
    assert!(met[0] > 20 && met[2] - met[0] - met[1] > 10, "{met:?}");
}

#[test]
fn what_is_skipped_changes_no_verdict() {
    let mut random = Pcg64::new(9, 1);
    let mut cases: Vec<_> = (0..20)
        .map(|_| {
            let sheet = random_pattern(&mut random);
            let motion = random_motion(&mut random, sheet.1.len());
            (sheet, motion)
        })
        .collect();
    for name in ["miura-3x3", "waterbomb-4x6"] {
        let (pattern, memberships, motion) = folded(name);
        cases.push(((pattern, memberships), motion));
    }
    for (case, ((pattern, memberships), motion)) in cases.iter().enumerate() {
        let all = SweepOptions::default();
        let verdict = Sweep::new(pattern, memberships, all, None).sweep(motion);
        for options in [
            all.with(|it| it.skip_motion = false),
            all.with(|it| it.skip_bounds = false),
            all.with(|it| it.skip_edges = false),
            all.with(|it| {
                it.skip_motion = false;
                it.skip_bounds = false;
                it.skip_edges = false;
            }),
        ] {
            let mut sweep = Sweep::new(pattern, memberships, options, None);
            let other = sweep.sweep(motion);
            match (verdict, other) {
                (SweepVerdict::Free(a), SweepVerdict::Free(b)) => {
                    let [a, b] = [a, b].map(|c| c.map_or(f64::INFINITY, |c| c.distance));
                    assert!(a >= b || a - b < 0.1 * b, "{case}: {a} {b}");
                }
                (SweepVerdict::Crossing { at: a, .. }, SweepVerdict::Crossing { at: b, .. }) => {
                    let same = a.segment == b.segment && (a.s - b.s).abs() < 1e-5;
                    assert!(same, "{case}: {verdict:?} {other:?}");
                }
                _ => panic!("{case}: {verdict:?} {other:?}"),
            }
            let c = sweep.counts();
            let skipped = c.skipped_symmetry + c.skipped_motion + c.skipped_bounds;
            assert_eq!(c.pairs, c.tested + skipped + c.skipped_edges);
        }
    }
}

#[test]
fn with_a_lattice_a_few_pairs_stand_for_all() {
    for name in [
        "miura-5x5",
        "miura-11x11",
        "waterbomb-8x10",
        "waterbomb-12x22-crossing",
    ] {
        let (pattern, memberships, motion) = folded(name);
        let lattice = Lattice::find(&pattern, &memberships).unwrap();
        let all = SweepOptions::default();
        let verdict = Sweep::new(&pattern, &memberships, all, None).sweep(&motion);
        for skip_motion in [true, false] {
            let options = all.with(|it| it.skip_motion = skip_motion);
            let mut sweep = Sweep::new(&pattern, &memberships, options, Some(&lattice));
            match (verdict, sweep.sweep(&motion)) {
                (SweepVerdict::Free(Some(a)), SweepVerdict::Free(Some(b))) => {
                    assert!(
                        (a.distance - b.distance).abs() < 1e-9,
                        "{name}: {a:?} {b:?}"
                    );
                }
                (
                    SweepVerdict::Crossing {
                        crossing: a,
                        at: here,
                        ..
                    },
                    SweepVerdict::Crossing {
                        crossing: b,
                        at: there,
                        ..
                    },
                ) => {
                    assert!(
                        (here.s - there.s).abs() < 1e-5,
                        "{name}: {here:?} {there:?}"
                    );
                    let [a, b] = [a, b].map(|c| class_of(&lattice, c.faces).unwrap().0);
                    assert_eq!(a, b, "{name}");
                }
                pair => panic!("{name}: {pair:?}"),
            }
            let c = sweep.counts();
            let skipped = c.skipped_symmetry + c.skipped_motion + c.skipped_bounds;
            assert_eq!(c.pairs, c.tested + skipped + c.skipped_edges, "{name}");
            assert!(2 * c.skipped_symmetry > c.pairs, "{name}: {c:?}");
        }
    }
}

/// Strips close to tubes and pass through themselves within a small part of the time between two tabulated times.
#[test]
fn without_the_motion_skip_no_time_is_passed_over_along_a_lattice() {
    let places: Vec<f64> = (0..31).map(f64::from).collect();
    let (pattern, mut memberships) = strip(&places, &[0.0; 31]);
    for member in &mut memberships {
        member.group = GroupId(0);
    }
    let lattice = Lattice::find(&pattern, &memberships).unwrap();
    for most in [20.0, 40.0, 80.0, 120.0, 160.0] {
        let found = [true, false].map(|skip_motion| {
            let options = SweepOptions::default().with(|it| it.skip_motion = skip_motion);
            let mut sweep = Sweep::new(&pattern, &memberships, options, Some(&lattice));
            crossing_at(sweep.sweep(&[vec![line(0.0, most)]])).1
        });
        assert!((found[1] - found[0]).abs() < 1e-5, "{most}: {found:?}");
    }
}

/// The lattice of this sheet is oblique to the sheet, and its second step turns. Only a few of the cell differences in
/// their bounding box occur.
#[test]
fn a_lattice_oblique_to_its_sheet_is_swept() {
    let sheet = Yoshimura {
        rows: 128,
        columns: 3,
        angle: core::f64::consts::FRAC_PI_4,
        fold: 0.28,
    };
    let pattern = CreasePattern::new(sheet.drawing().unwrap()).unwrap();
    let (pattern, memberships, motion) = to_goal(pattern, "yoshimura");
    let lattice = Lattice::find(&pattern, &memberships).unwrap();
    let options = SweepOptions::default();
    let verdict = Sweep::new(&pattern, &memberships, options, Some(&lattice)).sweep(&motion);
    let SweepVerdict::Crossing {
        at,
        last_free: Some(free),
        ..
    } = verdict
    else {
        panic!("{verdict:?}");
    };
    let sheet = (pattern, memberships);
    let mut sampler = Sampler::new(&sheet);
    assert!(sampler.depth(&motion, at.segment, at.s + 1e-3) > 1e-4);
    assert!(sampler.depth(&motion, free.segment, free.s) < 1e-5);
}

/// Returns a square of side 2 with a strip on half of each side, at its right end seen from the middle. The strips are
/// longer than half a side by `more`, and turned up together, so that the sides of neighbouring strips meet in a point if
/// `more` is 0. The square is turned in its plane, so that places are rounded.
fn pinwheel(random: &mut Pcg64, more: f64) -> (CreasePattern, Vec<Membership>) {
    let (sin, cos) = uniform(random, [0.0, PI]).sin_cos();
    let (mut vertices, mut edges) = (Vec::new(), Vec::new());
    for k in 0..4 {
        let length = uniform(random, [2.1, 4.0]);
        let corners = [
            [1.0, -1.0],
            [1.0, more],
            [1.0 + length, more],
            [1.0 + length, -1.0],
        ];
        vertices.extend(corners.map(|[x, y]| {
            let quarters = [[x, y], [-y, x], [-x, -y], [y, -x]];
            let [x, y] = quarters[k];
            [cos * x - sin * y, sin * x + cos * y]
        }));
        let [a, b, c, d] = core::array::from_fn(|corner| 4 * k + corner);
        edges.extend([[a, b], [b, c], [c, d], [d, a], [b, (4 * k + 4) % 16]]);
    }
    drawn(&vertices, &edges)
}

/// Sides of strips that turn up together cross in a point, which slides along both from their ends on.
#[test]
fn sides_that_slide_along_each_other_take_few_queries() {
    let mut random = Pcg64::new(4, 4);
    for case in 0..10 {
        for (more, crosses) in [(0.0, false), (-1e-3, false), (1e-3, true)] {
            let sheet = pinwheel(&mut random, more);
            let turn = line(0.0, uniform(&mut random, [150.0, 179.0]));
            let alike = vec![vec![turn; 4]];
            let mut sweep = Sweep::new(&sheet.0, &sheet.1, SweepOptions::default(), None);
            let verdict = sweep.sweep(&alike);
            assert_eq!(
                matches!(verdict, SweepVerdict::Crossing { .. }),
                crosses,
                "{case} {more}: {verdict:?}"
            );
            assert!(
                crosses || matches!(verdict, SweepVerdict::Free(_)),
                "{case}: {verdict:?}"
            );
            let tested = sweep.counts().tested;
            assert!(tested < 10_000, "{case} {more}: {tested}");
        }
    }
}

/// Returns a strip of unit squares.
fn squares(count: usize) -> (CreasePattern, Vec<Membership>) {
    let places: Vec<f64> = (0..=count).map(|k| k as f64).collect();
    strip(&places, &vec![0.0; count + 1])
}

/// Returns a motion of a strip's creases from flat: in each segment one crease turns to an angle (degrees), the others rest.
fn one_by_one(creases: usize, turns: &[(usize, f64)]) -> Motion {
    let mut at = vec![0.0; creases];
    let segment = |&(crease, to): &(usize, f64)| {
        let from = core::mem::replace(&mut at[crease], to);
        let mut curves: Vec<_> = at.iter().map(|&angle| line(angle, angle)).collect();
        curves[crease] = line(from, to);
        curves
    };
    turns.iter().map(segment).collect()
}

/// The end square is folded over, again and again, to one side or the other: most of the sheet rests all the time, and what
/// rests is not queried.
#[test]
fn rolls_take_queries_by_the_square_of_their_length() {
    let mut random = Pcg64::new(5, 5);
    let mut tested = |count: usize| {
        let sheet = squares(count);
        let side = |crease| {
            let up = random.next_u32().is_multiple_of(2);
            (crease, if up { 180.0 } else { -180.0 })
        };
        let motion = one_by_one(count - 1, &(0..count - 1).map(side).collect::<Vec<_>>());
        let mut sweep = Sweep::new(&sheet.0, &sheet.1, SweepOptions::default(), None);
        let verdict = sweep.sweep(&motion);
        assert!(
            matches!(verdict, SweepVerdict::Free(_)),
            "{count}: {verdict:?}"
        );
        sweep.counts().tested
    };
    let counts = [16, 32, 64].map(&mut tested);
    println!("{counts:?}");
    assert!(
        counts[1] < 5 * counts[0] && counts[2] < 5 * counts[1],
        "{counts:?}"
    );
}

/// A square comes to lie on another and rests there while other creases turn for any number of segments. It may leave on the
/// side that it came from, and not through the other.
#[test]
fn layers_that_rested_leave_on_the_side_they_came_from() {
    for side in [180.0, -180.0] {
        for rests in [0, 1, 2, 7] {
            for (leaves, crosses) in [(-side / 2.0, false), (side / 2.0, true)] {
                // Squares 0 and 1 are folded onto 3 and 2; others turn back and forth; then square 0 turns on 1.
                let others = (0..rests).map(|k| (4 + k % 2, if k % 4 < 2 { 40.0 } else { 0.0 }));
                let turns = [(1, side)].into_iter().chain(others).chain([(0, leaves)]);
                let motion = one_by_one(7, &turns.collect::<Vec<_>>());
                let verdict = sweep(&squares(8), &motion);
                let case = format!("{side} {rests} {leaves}: {verdict:?}");
                if crosses {
                    let (faces, _) = crossing_at(verdict);
                    assert_eq!(faces, [FaceId(0), FaceId(3)], "{case}");
                } else {
                    assert!(matches!(verdict, SweepVerdict::Free(_)), "{case}");
                }
            }
        }
    }
}
