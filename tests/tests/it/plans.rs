//! Are the plans of all patterns of `patterns/` right? Every path is written, then judged by an oracle that shares no
//! code with the planner, by `check`, and by the report's counts.

use foldpath::check::{CheckOptions, check};
use foldpath::planner::{Outcome, Plan, PlanOptions, Timing};
use foldpath::read::read_pattern;
use foldpath_core::Interpolation;
use foldpath_tests::closed_form::Waterbomb;
use foldpath_tests::{
    Animation, Frame, Planned, goal_angles, path_file, pattern_file, strict, worst,
};
use nalgebra::Vector4;

/// The report's counts of a pattern.
struct Counts {
    creases: usize,
    real_vertices: usize,
    groups: usize,
    essential_vertices: usize,
}

/// Returns the counts of m rows and n columns of parallelograms.
fn miura(m: usize, n: usize) -> Counts {
    Counts {
        creases: (m - 1) * n + m * (n - 1),
        real_vertices: (m - 1) * (n - 1),
        groups: 2,
        essential_vertices: 1,
    }
}

fn waterbomb(creases: usize, real_vertices: usize) -> Counts {
    Counts {
        creases,
        real_vertices,
        groups: 4,
        essential_vertices: 3,
    }
}

/// Returns the counts of m rows and n columns of cells with a diagonal each. Vertices of degree 2, halfway along the
/// straight creases, count as a closure condition of their own, as on the waterbomb.
fn yoshimura(m: usize, n: usize) -> Counts {
    Counts {
        creases: m * (n - 1) + m * n,
        real_vertices: (m - 1) * (n - 1),
        groups: 2,
        essential_vertices: 2,
    }
}

/// Returns the counts of m rows and n columns of twists: four sides each, and pleats of two creases on each side of a
/// tile.
fn square_twist(m: usize, n: usize, groups: usize, essential_vertices: usize) -> Counts {
    Counts {
        creases: 4 * m * n + 2 * (m * (n + 1) + n * (m + 1)),
        real_vertices: 4 * m * n,
        groups,
        essential_vertices,
    }
}

const RIGID: f64 = 1e-9;
const CLOSED: f64 = 1e-10;
const GOAL_DEGREES: f64 = 1e-6;
/// Largest certified value for the motion between knots: half of the default bound of `check`.
const CERTIFIED: f64 = 5e-4;
/// Largest number of knots of these motions. Before the motion between knots was certified, there was a knot every 10
/// degrees.
const FEW: usize = 20;
/// Smallest and largest value of a motion's highest speed, over the speed limit.
const SPEED: [f64; 2] = [0.97, 1.0 + 1e-6];
/// Tolerance of angles measured on positions that are rigid to 1e-9, radians.
const SAME_ANGLE: f64 = 1e-8;

#[test]
fn the_patterns_of_the_report_are_planned() {
    for (name, counts) in [
        ("miura-3x3", miura(3, 3)),
        ("miura-5x5", miura(5, 5)),
        ("miura-11x11", miura(11, 11)),
        ("miura-24x24", miura(24, 24)),
        ("waterbomb-4x6", waterbomb(50, 15)),
        ("waterbomb-8x10", waterbomb(182, 63)),
        ("waterbomb-12x22", waterbomb(626, 231)),
        ("yoshimura-12x12", yoshimura(12, 12)),
        ("square-twist-1x1", square_twist(1, 1, 2, 1)),
        ("square-twist-3x3", square_twist(3, 3, 6, 2)),
    ] {
        println!("{name}");
        let planned = Planned::new(name, &PlanOptions::default());
        count(&planned, &counts);
        believe(&planned.plan);
        let text = planned.text();
        let path = Animation::parse(&text).unwrap();
        judge(&path, &goal_angles(name));
        assert!(path.frames.len() <= FEW, "{} knots", path.frames.len());
        let [least, most] = SPEED.map(|part| part * PlanOptions::default().max_speed);
        let fastest = fastest(&path);
        assert!(least <= fastest && fastest <= most, "{fastest} rad/s");
        check_agrees(&planned.plan, &text);
    }
}

fn count(planned: &Planned, counts: &Counts) {
    let (pattern, plan) = (&planned.file.pattern, &planned.plan);
    assert_eq!(pattern.creases().len(), counts.creases);
    assert_eq!(pattern.real_vertices().count(), counts.real_vertices);
    assert_eq!(plan.reduced.groups, counts.groups);
    assert_eq!(plan.reduced.essential_vertices, counts.essential_vertices);
}

/// Checks the numbers that the planner reports.
fn believe(plan: &Plan) {
    assert_eq!(plan.outcome, Outcome::Planned, "{:?}", plan.reason);
    assert!(plan.errors.rigidity.deformation <= RIGID);
    assert!(plan.errors.rigidity.gap <= RIGID);
    assert!(plan.errors.closure <= CLOSED);
    assert!(plan.certified_closure().unwrap() <= CERTIFIED);
    assert!(plan.certified_deformation().unwrap() <= CERTIFIED);
    assert!(plan.arrival.error.to_degrees() <= GOAL_DEGREES);
}

/// Checks the numbers that the oracle measures on the written path.
fn judge(path: &Animation, goal: &[f64]) {
    let sheet = &path.sheet;
    for (index, frame) in path.frames.iter().enumerate() {
        let poses = sheet.fold(&frame.angles);
        for (what, value, limit) in [
            ("closure", sheet.closure(&frame.angles), CLOSED),
            ("gap", sheet.gap(&poses), RIGID),
            (
                "deformation by angles",
                sheet.deformation(&sheet.positions(&poses)),
                RIGID,
            ),
            (
                "deformation by positions",
                sheet.deformation(&frame.vertices),
                RIGID,
            ),
            (
                "unflatness of faces",
                sheet.unflatness(&frame.vertices),
                RIGID,
            ),
            (
                "fold angle of positions",
                sheet.angle_error(&frame.vertices, &frame.angles),
                SAME_ANGLE,
            ),
        ] {
            assert!(value <= limit, "knot {index}: {what} {value:e}");
        }
        assert_eq!(
            sheet.crossings(&frame.vertices),
            [[0; 2]; 0],
            "knot {index}"
        );
    }
    let [first, .., last] = &path.frames[..] else {
        panic!("two knots at least");
    };
    assert!(
        worst(first.angles.iter().map(|a| a.abs())) <= 0.0,
        "begins flat"
    );
    let missed = last.angles.iter().zip(goal);
    let missed = worst(missed.map(|(angle, goal)| (angle.to_degrees() - goal).abs()));
    assert!(missed <= GOAL_DEGREES, "{missed} degrees from the goal");
    for pair in path.frames.windows(2) {
        assert!(pair[0].time < pair[1].time);
    }
}

/// Returns the largest speed of a hinge, radians per second, by differences of sampled angles.
fn fastest(path: &Animation) -> f64 {
    const PLACES: u32 = 200;
    let of_segment = |(segment, pair): (usize, &[Frame])| {
        let step = (pair[1].time - pair[0].time) / f64::from(PLACES);
        let shape = |k: u32| {
            path.motion
                .angles(segment, f64::from(k) / f64::from(PLACES))
        };
        let turn = |k: u32| {
            let (from, to) = (shape(k), shape(k + 1));
            worst(from.iter().zip(&to).map(|(from, to)| (to - from).abs()))
        };
        worst((0..PLACES).map(turn)) / step
    };
    worst(path.frames.windows(2).enumerate().map(of_segment))
}

/// Asserts that `check` finds the knots rigid to rounding, and nothing worse than certified between them.
fn check_agrees(plan: &Plan, text: &str) {
    let file = path_file(text).unwrap();
    let knots = check(&file, &CheckOptions::knots_alone(RIGID));
    assert_eq!(knots.findings(), [""; 0]);
    assert!(knots.closure() <= CLOSED);
    let verdict = check(&file, &strict());
    assert_eq!(verdict.findings(), [""; 0]);
    let most = plan.certified_deformation().unwrap() + RIGID;
    assert!(verdict.rigidity().deformation <= most);
    assert!(verdict.rigidity().gap <= most);
    assert!(verdict.closure() <= plan.certified_closure().unwrap() + CLOSED);
}

#[test]
fn the_waterbomb_has_758_edges_with_its_virtual_ones() {
    let pattern = read_pattern(&pattern_file("waterbomb-12x22"))
        .unwrap()
        .pattern;
    assert_eq!(pattern.creases().len() + pattern.virtual_edges(), 758);
}

/// A tube of 12 squares closes at b - m = 720/12 degrees. Its sides touch in this configuration and cross beyond it.
#[test]
fn the_waterbomb_tube_meets_itself_where_it_closes() {
    let name = "waterbomb-12x22-crossing";
    // Interpolation in half angles, proportional to one of them, gives this motion without error.
    let exact = PlanOptions::default().with(|it| {
        it.interpolation = Some(Interpolation::HalfAngle);
        it.pace = Timing::Sparse;
    });
    let plan = Planned::new(name, &exact).plan;
    let Outcome::Crossing(crossing) = plan.outcome else {
        panic!("{:?}", plan.outcome);
    };
    let through = exact.with(|it| it.collision = false);
    let text = Planned::new(name, &through).text();
    let path = Animation::parse(&text).unwrap();
    let sheet = &path.sheet;

    // The faces that the planner and `check` name cross just beyond the place that `check` names; no faces cross before
    // it.
    let verdict = check(&path_file(&text).unwrap(), &strict());
    let found = verdict.crossings[0];
    let segment = found.between_knots[0];
    let shape = |s: f64| path.motion.angles(segment, s);
    let crossings = |angles: &[f64]| sheet.crossings(&sheet.positions(&sheet.fold(angles)));
    let beyond = crossings(&shape(found.at + 1e-3));
    for faces in [crossing.faces, found.crossing.faces] {
        let named = faces.map(|face| face.index());
        assert!(beyond.contains(&named), "{named:?}: {beyond:?}");
    }
    let none: [[usize; 2]; 0] = [];
    for frame in &path.frames[..=segment] {
        assert_eq!(crossings(&frame.angles), none);
    }
    assert_eq!(crossings(&shape(found.at - 1e-3)), none);

    // In the closed form the sheet is free just before that place and crosses just beyond it.
    let boundary = worst(shape(found.at));
    let crosses = |t: f64| {
        let closed = Waterbomb::at(t);
        let angle = |ends: &[usize; 2]| closed.of_crease(ends.map(|v| sheet.flat[v].xy().into()));
        let angles: Vec<f64> = sheet.edges.iter().map(angle).collect();
        !sheet
            .crossings(&sheet.positions(&sheet.fold(&angles)))
            .is_empty()
    };
    let (mut free, mut crossed) = (0.0, 1.0);
    while crossed - free > 1e-6 {
        let t = (free + crossed) / 2.0;
        *(if crosses(t) { &mut crossed } else { &mut free }) = t;
    }
    let first = Waterbomb::at(free);
    let closing = (first.boundary - first.middle).to_degrees();
    assert!((closing - 720.0 / 12.0).abs() <= 1e-3, "b - m = {closing}");
    assert!((first.middle.to_degrees() - 36.0).abs() <= 0.1);
    let early = (boundary - first.boundary).to_degrees();
    assert!(early.abs() <= 0.05, "{early} degrees of b beyond");

    // The plan reaches the fraction of the path, in the angles of the four groups, that the closed form allows.
    let way = |to: f64| {
        let at = |k: u32| {
            let w = Waterbomb::at(to * f64::from(k) / 1000.0);
            Vector4::new(w.middle, w.cross, w.diagonal, w.boundary)
        };
        (0..1000).map(|k| (at(k + 1) - at(k)).norm()).sum::<f64>()
    };
    let goal = worst(path.frames.last().unwrap().angles.iter().copied());
    let (mut short, mut far) = (free, 2.0);
    while far - short > 1e-9 {
        let t = (short + far) / 2.0;
        *(if Waterbomb::at(t).boundary > goal {
            &mut far
        } else {
            &mut short
        }) = t;
    }
    let reached = way(free) / way(far);
    assert!(
        (plan.reached - reached).abs() <= 1e-3,
        "{} {reached}",
        plan.reached
    );
}
