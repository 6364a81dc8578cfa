//! Judges derivatives along motions by configurations that are closed anew, by the linkage of `tests/src/linkage.rs`.

use foldpath::generate::{Miura, Quad, Waterbomb, Yoshimura};
use foldpath::motion::Motion;
use foldpath::pattern::{CreasePattern, Drawing, DrawnEdge, Letter};
use foldpath::planner::{Goal, Outcome, PlanOptions, plan};
use foldpath::read::read_pattern;
use foldpath::sensitivity::{Conditions, NoDerivative, Sensitivity};
use foldpath_tests::linkage::Linkage;
use foldpath_tests::{Random, pattern_file};
use nalgebra::{Vector2, Vector3};

/// Largest difference of a derivative from central differences, for rates of about 1.
const EQUAL: f64 = 1e-6;
/// Step of central differences: rounding over it and its square are both far below [`EQUAL`].
const STEP: f64 = 1e-5;

/// Plans a sheet that folds to its goal.
pub(crate) fn planned(name: &str, pattern: &CreasePattern) -> Motion {
    let goal = Goal::of_pattern(pattern).unwrap();
    let plan = plan(pattern, &goal, &PlanOptions::default());
    assert_eq!(plan.outcome, Outcome::Planned, "{name}");
    plan.motion.unwrap()
}

/// A sheet at a closed configuration.
pub(crate) struct Case {
    name: String,
    pub(crate) pattern: CreasePattern,
    pub(crate) linkage: Linkage,
    pub(crate) angles: Vec<f64>,
}

impl Case {
    fn new(name: &str, pattern: CreasePattern, start: &[f64]) -> Self {
        let linkage = Linkage::of(&pattern);
        let angles = linkage.closed(pattern.vertices(), start, &[]);
        let residual = linkage.residual(pattern.vertices(), &angles);
        assert!(residual < 1e-6, "{name}: {residual:e}");
        Self {
            name: name.into(),
            pattern,
            linkage,
            angles,
        }
    }

    /// A sheet half way to its goal, in time.
    fn planned(name: &str, pattern: CreasePattern) -> Self {
        let goal = Goal::of_pattern(&pattern).unwrap();
        let plan = plan(&pattern, &goal, &PlanOptions::default());
        let motion = plan.motion.unwrap();
        let end = motion.knots.last().unwrap().time;
        let start = motion.at_times([0.6 * end]).crease_angles(0);
        Self::new(name, pattern, &start)
    }

    fn of_file(name: &str) -> Self {
        let pattern = read_pattern(&pattern_file(name)).unwrap().pattern;
        Self::planned(name, pattern)
    }

    /// Panels round one vertex, with creases in these directions, degrees.
    pub(crate) fn vertex(directions: &[f64], seed: u64) -> Self {
        let tip = |angle: &f64| Vector2::new(angle.to_radians().cos(), angle.to_radians().sin());
        let count = directions.len();
        let spokes = (1..=count).map(|k| crease([0, k]));
        let rim = (1..=count).map(|k| DrawnEdge::boundary([k, k % count + 1]));
        let drawing = Drawing {
            vertices: [Vector2::zeros()]
                .into_iter()
                .chain(directions.iter().map(tip))
                .collect(),
            edges: spokes.chain(rim).collect(),
            faces: None,
        };
        Self::folded(&format!("vertex of degree {count}"), drawing, seed)
    }

    /// Panels round a hole with this number of corners.
    pub(crate) fn ring(corners: usize, seed: u64) -> Self {
        let mut random = Random::new(seed);
        let mut vertices = Vec::new();
        let full = core::f64::consts::TAU;
        for radius in [1.0, 2.2] {
            for k in 0..corners {
                let angle = full * (k as f64 + random.uniform(-0.15, 0.15)) / corners as f64;
                vertices.push(Vector2::new(angle.cos(), angle.sin()) * radius);
            }
        }
        let next = |k: usize| (k + 1) % corners;
        let creases = (0..corners).map(|k| crease([k, k + corners]));
        let inner = (0..corners).map(|k| DrawnEdge::boundary([k, next(k)]));
        let outer = (0..corners).map(|k| DrawnEdge::boundary([k + corners, next(k) + corners]));
        let drawing = Drawing {
            edges: creases.chain(inner).chain(outer).collect(),
            vertices,
            faces: None,
        };
        Self::folded(&format!("ring of {corners}"), drawing, seed)
    }

    fn folded(name: &str, drawing: Drawing, seed: u64) -> Self {
        let pattern = CreasePattern::new(drawing).unwrap();
        let linkage = Linkage::of(&pattern);
        let mut random = Random::new(seed);
        // Takes the first closed configuration near a random one whose creases are all folded.
        loop {
            let start: Vec<f64> = pattern
                .creases()
                .iter()
                .map(|_| random.uniform(-1.2, 1.2))
                .collect();
            let angles = linkage.closed(pattern.vertices(), &start, &[]);
            let closes = linkage.residual(pattern.vertices(), &angles) < 1e-12;
            if closes
                && angles
                    .iter()
                    .all(|angle| (0.15..2.5).contains(&angle.abs()))
            {
                return Self::new(name, pattern, &angles);
            }
        }
    }

    fn random_change(&self, seed: u64) -> Vec<Vector2<f64>> {
        let mut random = Random::new(seed);
        let mut number = || self.linkage.unit * random.uniform(-1.0, 1.0);
        let vertices = self.pattern.vertices().iter();
        vertices.map(|_| Vector2::new(number(), number())).collect()
    }
}

fn crease(ends: [usize; 2]) -> DrawnEdge {
    DrawnEdge {
        ends,
        letter: Letter::Unassigned,
        goal: None,
    }
}

pub(crate) fn pattern(drawing: Result<Drawing, impl core::fmt::Debug>) -> CreasePattern {
    CreasePattern::new(drawing.unwrap()).unwrap()
}

pub(crate) fn miura(rows: usize, columns: usize, degrees: f64) -> CreasePattern {
    let miura = Miura {
        rows,
        columns,
        sector_angle: degrees.to_radians(),
        fold: 0.8,
    };
    pattern(miura.drawing())
}

fn cases() -> Vec<Case> {
    vec![
        Case::vertex(&[0.0, 80.0, 190.0, 260.0], 1),
        Case::vertex(&[0.0, 70.0, 130.0, 200.0, 290.0], 2),
        Case::vertex(&[0.0, 50.0, 120.0, 170.0, 230.0, 300.0], 3),
        Case::ring(7, 4),
        Case::ring(8, 5),
        Case::planned("miura 3x3", miura(3, 3, 60.0)),
        Case::planned("miura 4x4", miura(4, 4, 50.0)),
        Case::planned("miura 2x5", miura(2, 5, 75.0)),
        Case::planned(
            "waterbomb 2x4",
            pattern(
                Waterbomb {
                    rows: 2,
                    columns: 4,
                    fold: 0.7,
                }
                .drawing(),
            ),
        ),
        Case::planned(
            "yoshimura 3x4",
            pattern(
                Yoshimura {
                    rows: 4,
                    columns: 4,
                    angle: 35_f64.to_radians(),
                    fold: 0.6,
                }
                .drawing(),
            ),
        ),
        Case::planned(
            "quad 2x2",
            pattern(
                Quad {
                    rows: 2,
                    columns: 2,
                    fold: 0.1,
                }
                .drawing(),
            ),
        ),
        Case::of_file("square-twist-1x1"),
    ]
}

fn dot(a: &[Vector3<f64>], b: &[Vector3<f64>]) -> f64 {
    a.iter().zip(b).map(|(a, b)| a.dot(b)).sum()
}

#[test]
fn derivatives_are_those_of_configurations_closed_anew_at_equal_driver_angles() {
    for (seed, case) in (100..).zip(cases()) {
        let Case {
            name,
            pattern,
            linkage,
            angles,
        } = &case;
        let conditions = Conditions::new(pattern).unwrap();
        let mut at =
            Sensitivity::at(&conditions, angles).unwrap_or_else(|no| panic!("{name}: {no}"));
        let vertices = pattern.vertices();
        let freedom = linkage.freedom(vertices, angles, &[]);
        assert_eq!(at.drivers().len(), freedom, "{name}");
        let drivers: Vec<usize> = at.drivers().iter().map(|driver| driver.index()).collect();
        let change = linkage.foldable(vertices, angles, &case.random_change(seed));
        let mut random = Random::new(seed);
        let turned: Vec<f64> = drivers.iter().map(|_| random.uniform(-1.0, 1.0)).collect();
        let rates = at
            .jvp(&change, &turned)
            .unwrap_or_else(|no| panic!("{name}: {no}"));
        let root = pattern.tree().roots()[0].index();
        let anew = |step: f64| {
            let moved: Vec<_> = vertices
                .iter()
                .zip(&change)
                .map(|(v, by)| v + by * step)
                .collect();
            let mut start = angles.clone();
            for (driver, by) in drivers.iter().zip(&turned) {
                start[*driver] += by * step;
            }
            let closed = linkage.closed(&moved, &start, &drivers);
            let places = linkage.places(pattern, &moved, &linkage.rigid(&closed), root);
            (closed, places)
        };
        let ((after, places_after), (before, places_before)) = (anew(STEP), anew(-STEP));
        let angle_rates = after
            .iter()
            .zip(&before)
            .map(|(a, b)| (a - b) / (2.0 * STEP));
        let angle_rates: Vec<f64> = angle_rates.collect();
        let place_rates = places_after
            .iter()
            .zip(&places_before)
            .map(|(a, b)| (a - b) / (2.0 * STEP));
        let place_rates: Vec<_> = place_rates.collect();
        let scale = angle_rates
            .iter()
            .fold(1.0_f64, |most, rate| most.max(rate.abs()));
        let worst = angle_rates
            .iter()
            .zip(&rates.angles)
            .map(|(a, b)| (a - b).abs());
        let worst = worst.fold(0.0_f64, f64::max) / scale;
        let off = place_rates
            .iter()
            .zip(&rates.places)
            .map(|(a, b)| (a - b).norm());
        let off = off.fold(0.0_f64, f64::max) / (scale * linkage.unit);
        println!(
            "{name}: {freedom} drivers, smallest singular value {:.1e}, rates up to {scale:.1}, off by {worst:.1e} radians, {off:.1e} edges",
            at.smallest_singular_value()
        );
        assert!(worst <= EQUAL && off <= EQUAL, "{name}: {worst:e} {off:e}");

        // The product from the other side, with random gradients.
        let mut random = Random::new(seed + 1);
        let by_angles: Vec<f64> = angles.iter().map(|_| random.uniform(-1.0, 1.0)).collect();
        let mut number = || random.uniform(-1.0, 1.0) / linkage.unit;
        let by_places: Vec<_> = vertices
            .iter()
            .map(|_| Vector3::new(number(), number(), number()))
            .collect();
        let gradient = at.vjp(&by_angles, &by_places);
        let expected = by_angles
            .iter()
            .zip(&angle_rates)
            .map(|(a, b)| a * b)
            .sum::<f64>()
            + dot(&by_places, &place_rates);
        let found = gradient
            .vertices
            .iter()
            .zip(&change)
            .map(|(a, b)| a.dot(b))
            .sum::<f64>()
            + gradient
                .drivers
                .iter()
                .zip(&turned)
                .map(|(a, b)| a * b)
                .sum::<f64>();
        let sum = (angles.len() + vertices.len()) as f64 * scale;
        assert!(
            (found - expected).abs() <= EQUAL * sum,
            "{name}: {found} {expected}"
        );
    }
}

#[test]
fn flat_sheets_and_branches_have_no_derivative() {
    for (name, pattern) in [
        ("miura", miura(3, 3, 60.0)),
        (
            "vertex",
            Case::vertex(&[0.0, 80.0, 190.0, 260.0], 1).pattern,
        ),
    ] {
        let conditions = Conditions::new(&pattern).unwrap();
        let flat = vec![0.0; pattern.creases().len()];
        match Sensitivity::at(&conditions, &flat).err() {
            Some(NoDerivative::Singular { value }) => assert!(value < 1e-6, "{name}: {value}"),
            other => panic!("{name}: {other:?}"),
        }
    }
    // Two straight lines that cross: once one is folded, the other stays flat, unless the first is folded all the way.
    let crossed = Case::vertex(&[0.0, 80.0, 190.0, 260.0], 1);
    let mut lines = crossed.pattern.vertices().to_vec();
    for (tip, degrees) in lines[1..].iter_mut().zip([0.0_f64, 90.0, 180.0, 270.0]) {
        *tip = Vector2::new(degrees.to_radians().cos(), degrees.to_radians().sin());
    }
    let drawing = Drawing {
        vertices: lines,
        edges: (1..=4)
            .map(|k| crease([0, k]))
            .chain((1..=4).map(|k| DrawnEdge::boundary([k, k % 4 + 1])))
            .collect(),
        faces: None,
    };
    let pattern = CreasePattern::new(drawing).unwrap();
    let conditions = Conditions::new(&pattern).unwrap();
    let half_turn = core::f64::consts::PI;
    assert!(Sensitivity::at(&conditions, &[1.0, 0.0, 1.0, 0.0]).is_ok());
    let folded = Sensitivity::at(&conditions, &[half_turn, 0.0, half_turn, 0.0]);
    assert!(matches!(folded.err(), Some(NoDerivative::Singular { .. })));
    let open = Sensitivity::at(&conditions, &[1.0, 0.5, 1.0, -0.5]);
    assert!(matches!(open.err(), Some(NoDerivative::Open { .. })));
}

#[test]
fn a_change_that_breaks_a_miura_is_refused_with_what_is_left() {
    let case = Case::planned("miura 3x3", miura(3, 3, 60.0));
    let conditions = Conditions::new(&case.pattern).unwrap();
    let mut at = Sensitivity::at(&conditions, &case.angles).unwrap();
    let change = case.random_change(7);
    let Err(NoDerivative::LeavesFoldability { residual, of }) = at.jvp(&change, &[0.0]) else {
        panic!("a random change breaks a Miura");
    };
    assert!(residual > 1e-3 * of && residual <= of, "{residual} {of}");
    // The residual is that of the nearest configuration of the changed pattern.
    let anew = |step: f64| {
        let moved: Vec<_> = case
            .pattern
            .vertices()
            .iter()
            .zip(&change)
            .map(|(v, by)| v + by * step)
            .collect();
        let closed = case.linkage.closed(&moved, &case.angles, &[]);
        case.linkage.residual(&moved, &closed) / step
    };
    assert!(anew(1e-5) > 1e-3, "{}", anew(1e-5));
    let kept = case
        .linkage
        .foldable(case.pattern.vertices(), &case.angles, &change);
    assert!(at.jvp(&kept, &[0.0]).is_ok());
}

/// A change that turns, moves and scales the whole sheet turns no hinge, and moves all that is folded alike.
#[test]
fn a_sheet_that_is_turned_and_scaled_folds_as_before() {
    let case = Case::planned("miura 3x3", miura(3, 3, 60.0));
    let conditions = Conditions::new(&case.pattern).unwrap();
    let mut at = Sensitivity::at(&conditions, &case.angles).unwrap();
    let vertices = case.pattern.vertices().iter();
    let change = vertices.map(|v| v * 0.3 + Vector2::new(-v.y, v.x) * 0.7 + Vector2::new(5.0, 2.0));
    let change: Vec<_> = change.collect();
    let rates = at.jvp(&change, &[0.0]).unwrap();
    assert!(rates.angles.iter().all(|rate| rate.abs() < 1e-12));
    let root = case.pattern.tree().roots()[0].index();
    let flat = case.pattern.vertices();
    let places = case
        .linkage
        .places(&case.pattern, flat, &case.linkage.rigid(&case.angles), root);
    for (rate, at) in rates.places.iter().zip(&places) {
        let expected =
            at * 0.3 + Vector3::new(-at.y, at.x, 0.0) * 0.7 + Vector3::new(5.0, 2.0, 0.0);
        assert!((rate - expected).norm() < 1e-9, "{rate} {expected}");
    }
}
