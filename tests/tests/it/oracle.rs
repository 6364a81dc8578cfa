//! Does the oracle reject bad paths? Good paths are spoilt by hand and measured by the oracle.

use core::f64::consts::PI;

use foldpath::planner::PlanOptions;
use foldpath_tests::{Animation, CONTACT, Frame, Planned, Random, Sheet};
use serde_json::json;

/// Returns the oracle's measures of a knot: closure, gap, deformation, unflatness and error of fold angles.
fn measure(sheet: &Sheet, frame: &Frame) -> [f64; 5] {
    [
        sheet.closure(&frame.angles),
        sheet.gap(&sheet.fold(&frame.angles)),
        sheet.deformation(&frame.vertices),
        sheet.unflatness(&frame.vertices),
        sheet.angle_error(&frame.vertices, &frame.angles),
    ]
}

#[test]
fn each_measure_sees_what_is_its_to_see() {
    type Spoil = fn(&mut Frame);
    let cases: [(&str, Spoil, [bool; 5]); 4] = [
        ("nothing", |_| {}, [false, false, false, false, false]),
        (
            "an angle off",
            |frame| frame.angles[2] += 0.01,
            [true, true, false, false, true],
        ),
        (
            "a vertex moved",
            |frame| frame.vertices[5].z += 0.01,
            [false, false, true, true, true],
        ),
        (
            "the shape mirrored",
            |frame| {
                frame
                    .vertices
                    .iter_mut()
                    .for_each(|vertex| vertex.z *= -1.0)
            },
            [false, false, false, false, true],
        ),
    ];
    let text = Planned::new("miura-3x3", &PlanOptions::default()).text();
    for (what, spoil, expected) in cases {
        let Animation {
            sheet, mut frames, ..
        } = Animation::parse(&text).unwrap();
        let middle = frames.len() / 2;
        let frame = &mut frames[middle];
        spoil(frame);
        let seen = measure(&sheet, frame);
        assert_eq!(seen.map(|error| error > 1e-9), expected, "{what}: {seen:?}");
    }
}

/// Two flaps 2 long, on a panel 1 wide, meet at cos(180° - ρ) = 1/4.
#[test]
fn flaps_cross_just_beyond_where_they_meet() {
    let strip = json!({
        "vertices_coords": [[-2.0, 0.0], [0.0, 0.0], [1.0, 0.0], [3.0, 0.0],
                            [-2.0, 1.0], [0.0, 1.0], [1.0, 1.0], [3.0, 1.0]],
        "edges_vertices": [[0, 1], [1, 2], [2, 3], [4, 5], [5, 6], [6, 7], [0, 4], [1, 5], [2, 6], [3, 7]],
        "faces_vertices": [[0, 1, 5, 4], [1, 2, 6, 5], [2, 3, 7, 6]],
    });
    let sheet = Sheet::of(&strip).unwrap();
    let crossings = |rho: f64| {
        let mut angles = vec![0.0; 10];
        (angles[7], angles[8]) = (rho, rho);
        sheet.crossings(&sheet.positions(&sheet.fold(&angles)))
    };
    let meets = PI - 0.25_f64.acos();
    assert_eq!(crossings(meets - 1e-3), [[0; 2]; 0]);
    assert_eq!(crossings(meets + 1e-3), [[0, 2]]);
    assert_eq!(crossings(PI), [[0; 2]; 0], "layers in contact");
}

/// Layers of a measured map of 3x3 panels, turned together. Layers that share no vertex overlap by the tear if the
/// sheet is folded from some faces; this is no crossing. The outer columns, which are two long, really cross if they
/// are folded over the middle one.
#[test]
fn what_crosses_as_folded_from_some_faces_is_a_tear() {
    let places = || (0..4).flat_map(|row| (0..4).map(move |column| [row, column]));
    let edge = |[row, column]: [usize; 2], rows: usize, columns: usize| {
        [4 * row + column, 4 * (row + rows) + column + columns]
    };
    let across = places().filter(|place| place[1] < 3);
    let along = places().filter(|place| place[0] < 3);
    let edges: Vec<[usize; 2]> = (across.map(|place| edge(place, 0, 1)))
        .chain(along.map(|place| edge(place, 1, 0)))
        .collect();
    let panels = edges.iter().filter(|&&[a, b]| b == a + 1 && a < 12);
    let faces: Vec<[usize; 4]> = panels.map(|&[a, b]| [a, b, b + 4, a + 4]).collect();
    let angles = |angle: fn([usize; 2]) -> f64| edges.iter().map(|&e| angle(e)).collect();
    let layers: Vec<f64> = angles(|[a, b]| match (b - a, a / 4, a % 4) {
        (4, _, 1) => -PI,
        (4, _, 2) => PI,
        (1, 2, 1) => -1.5,
        (1, 2, _) => 1.5,
        _ => 0.0,
    });
    let flaps: Vec<f64> = angles(|[a, b]| match (b - a, a % 4) {
        (4, 1 | 2) => 2.0,
        _ => 0.0,
    });
    let mut torn = 0;
    for seed in 0..100 {
        let mut random = Random::new(seed);
        let mut place = |x: f64, y: f64| [x, y].map(|x| x + random.uniform(-1e-5, 1e-5));
        let flat = [0.0, 1.5, 3.0, 4.5].map(|y| [-2.0, 0.0, 1.0, 3.0].map(|x| place(x, y)));
        let sheet = Sheet::of(&json!({
            "vertices_coords": flat.concat(), "edges_vertices": edges, "faces_vertices": faces,
        }))
        .unwrap();
        let poses = sheet.fold(&layers);
        let (positions, tear) = (sheet.positions(&poses), sheet.gap(&poses));
        torn += sheet.crossings(&positions).len();
        assert_eq!(
            sheet.crossings_beyond_tears(&layers, &positions, [tear, CONTACT]),
            [[0; 2]; 0],
            "{seed}"
        );
        let poses = sheet.fold(&flaps);
        let (positions, tear) = (sheet.positions(&poses), sheet.gap(&poses));
        let crossings = sheet.crossings_beyond_tears(&flaps, &positions, [tear, CONTACT]);
        for row in 0..3 {
            let flaps = [3 * row, 3 * row + 2];
            assert!(crossings.contains(&flaps), "{seed}: {crossings:?}");
        }
    }
    assert!(torn > 0, "nothing to tell apart");
}
