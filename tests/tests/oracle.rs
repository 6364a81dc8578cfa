//! The oracle itself can say no: good paths spoilt by hand, measured by it.

use foldpath::planner::PlanOptions;
use foldpath_tests::{Animation, Frame, Planned, Sheet};
use serde_json::json;

/// What the oracle measures of a knot: closure, gap, deformation, unflatness, error of fold angles.
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

/// Two flaps, 2 long, on a panel 1 wide meet where cos(180 - rho) = 1/4.
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
    let meets = core::f64::consts::PI - 0.25_f64.acos();
    assert_eq!(crossings(meets - 1e-3), [[0; 2]; 0]);
    assert_eq!(crossings(meets + 1e-3), [[0, 2]]);
    assert_eq!(
        crossings(core::f64::consts::PI),
        [[0; 2]; 0],
        "layers in contact"
    );
}
