//! Every pattern of `patterns/`, planned, written and judged by an oracle that shares no code with
//! the planner, by `check`, and against the report's counts.

use foldpath::check::{CheckOptions, check};
use foldpath::formats::fold::read_pattern;
use foldpath::planner::{Outcome, Plan, PlanOptions};
use foldpath_tests::closed_form::Waterbomb;
use foldpath_tests::{Animation, Frame, Planned, goal_angles, path_file, pattern_file, worst};

/// What the report counts.
struct Counts {
    creases: usize,
    real_vertices: usize,
    groups: usize,
    essential_vertices: usize,
}

/// m rows and n columns of parallelograms.
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

/// m rows and n columns of cells with a diagonal each. Degree-2 vertices, halfway along the straight
/// creases, count as a condition of their own, as on the waterbomb.
fn yoshimura(m: usize, n: usize) -> Counts {
    Counts {
        creases: m * (n - 1) + m * n,
        real_vertices: (m - 1) * (n - 1),
        groups: 2,
        essential_vertices: 2,
    }
}

/// m rows and n columns of twists: four sides each, and pleats of two creases on each side of a tile.
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
const STEP_DEGREES: f64 = 10.0;
/// Angles measured on positions that are rigid to 1e-9, radians.
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
        judge(&Animation::parse(&text).unwrap(), &goal_angles(name));
        check_agrees(&text);
    }
}

fn count(planned: &Planned, counts: &Counts) {
    let (pattern, plan) = (&planned.file.pattern, &planned.plan);
    assert_eq!(pattern.creases().len(), counts.creases);
    assert_eq!(pattern.real_vertices().count(), counts.real_vertices);
    assert_eq!(plan.groups, counts.groups);
    assert_eq!(plan.unknowns, counts.groups);
    assert_eq!(plan.essential_vertices, counts.essential_vertices);
}

/// The numbers that the planner reports.
fn believe(plan: &Plan) {
    assert_eq!(plan.outcome, Outcome::Planned, "{:?}", plan.reason);
    assert!(plan.rigidity.deformation <= RIGID);
    assert!(plan.rigidity.gap <= RIGID);
    assert!(plan.max_closure <= CLOSED);
    assert!(plan.goal_error.to_degrees() <= GOAL_DEGREES);
}

/// The same numbers, measured by the oracle on what was written.
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
    for (index, pair) in path.frames.windows(2).enumerate() {
        let turns = pair[0].angles.iter().zip(&pair[1].angles);
        let turn = worst(turns.map(|(from, to)| (to - from).abs().to_degrees()));
        assert!(turn <= STEP_DEGREES, "{turn} degrees after knot {index}");
        assert!(pair[0].time < pair[1].time);
    }
}

fn check_agrees(text: &str) {
    let verdict = check(&path_file(text).unwrap(), &CheckOptions::default());
    assert_eq!(verdict.failures, [""; 0]);
    assert!(verdict.rigidity().deformation <= RIGID);
    assert!(verdict.rigidity().gap <= RIGID);
    assert!(verdict.closure() <= CLOSED);
}

#[test]
fn the_waterbomb_has_758_edges_with_its_virtual_ones() {
    let pattern = read_pattern(&pattern_file("waterbomb-12x22"))
        .unwrap()
        .pattern;
    assert_eq!(pattern.creases().len() + pattern.virtual_edges(), 758);
}

/// A tube of 12 squares closes where b - m = 720/12 degrees: there its sides touch, and beyond they
/// cross.
#[test]
fn the_waterbomb_tube_meets_itself_where_it_closes() {
    let name = "waterbomb-12x22-crossing";
    let plan = Planned::new(name, &PlanOptions::default()).plan;
    let Outcome::Crossing(crossing) = plan.outcome else {
        panic!("{:?}", plan.outcome);
    };
    let through = PlanOptions {
        collision: false,
        ..PlanOptions::default()
    };
    let through = Planned::new(name, &through);
    let path = Animation::parse(&through.text()).unwrap();
    let sheet = &path.sheet;

    // The faces named cross at the first knot beyond the fraction, and none at the knots before.
    let end = path.frames.last().unwrap().time;
    let next = path
        .frames
        .partition_point(|f| f.time <= plan.reached * end);
    let (before, beyond) = (&path.frames[next - 1], &path.frames[next]);
    let named = crossing.faces.map(|face| face.index());
    assert!(sheet.crossings(&beyond.vertices).contains(&named));
    for frame in &path.frames[..next] {
        assert_eq!(sheet.crossings(&frame.vertices), [[0; 2]; 0]);
    }

    // In the closed form the sheet is free just before the fraction and crosses just beyond.
    let share = (plan.reached * end - before.time) / (beyond.time - before.time);
    let largest = |frame: &Frame| worst(frame.angles.iter().copied());
    let boundary = largest(before) + share * (largest(beyond) - largest(before));
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
}
