//! Tests unfolding of shapes to crease patterns: round trips through folding, closed shapes, shapes to which no sheet
//! folds, and files that have no shape.

use core::f64::consts::{FRAC_PI_2, PI, TAU};

use crate::common::folder;
use foldpath::folding::{FoldingMap, align_rigid};
use foldpath::generate::{Miura, Waterbomb, Yoshimura};
use foldpath::pattern::{CreasePattern, Drawing, Letter};
use foldpath::read::{parse_shape, read_file};
use foldpath::unfold::{
    Cut, FoldedShape, Outcome, Reason, ShapeEdge, ShapeError, UnfoldOptions, Unfolding, unfold,
};
use foldpath_test_support::numbers;
use nalgebra::{Rotation3, Vector2, Vector3};
use serde_json::{Value, json};

/// Number of configurations of each family.
const CONFIGURATIONS: u8 = 30;

fn worst(values: impl IntoIterator<Item = f64>) -> f64 {
    values.into_iter().fold(
        0.0,
        |worst, x| if x > worst || x.is_nan() { x } else { worst },
    )
}

/// Returns the largest distance between corresponding points, after rigid registration of one set with the other.
fn apart(a: &[Vector3<f64>], b: &[Vector3<f64>]) -> f64 {
    assert_eq!(a.len(), b.len());
    worst(align_rigid(a, b).iter().zip(b).map(|(a, b)| (a - b).norm()))
}

/// Returns the largest distance between corresponding points of flat sheets, after rigid registration. The registration
/// may not turn a sheet over.
fn apart_flat(a: &[Vector2<f64>], b: &[Vector2<f64>]) -> f64 {
    // Points above the sheet mark its upper side.
    let raised = |points: &[Vector2<f64>]| {
        let mut points: Vec<_> = points.iter().map(|p| p.push(0.0)).collect();
        let size = worst(points.iter().map(|p| (p - points[0]).norm()));
        let ends = [points[0], points[points.len() - 1]];
        points.extend(ends.map(|p| p + size * Vector3::z()));
        points
    };
    apart(&raised(a), &raised(b))
}

/// Returns a sheet folded to its own goal, in some other position and orientation, without letters.
fn folded(drawing: &Drawing) -> FoldedShape {
    let pattern = CreasePattern::new(drawing.clone()).unwrap();
    let tree = pattern.tree();
    let goal = |edge: &foldpath::pattern::EdgeId| pattern.edge(*edge).goal.unwrap();
    let angles: Vec<f64> = pattern.creases().iter().map(goal).collect();
    let map = FoldingMap::new(&pattern, tree, &angles);
    assert!(map.rigidity(&pattern, tree).worst() < 1e-12);
    let turn = Rotation3::from_euler_angles(0.3, -1.1, 2.5);
    let moved = |p: &Vector3<f64>| turn * p + Vector3::new(1.0, -2.0, 0.5);
    let faces = pattern.faces().iter();
    FoldedShape {
        vertices: map.vertices().iter().map(moved).collect(),
        faces: faces
            .map(|cycle| cycle.iter().map(|v| v.index()).collect())
            .collect(),
        edges: Vec::new(),
    }
}

fn with_letters(mut shape: FoldedShape, drawing: &Drawing) -> FoldedShape {
    let edge = |edge: &foldpath::pattern::DrawnEdge| ShapeEdge {
        ends: edge.ends,
        letter: Some(edge.letter),
        angle: None,
    };
    shape.edges = drawing.edges.iter().map(edge).collect();
    shape
}

#[track_caller]
fn unfolded(shape: &FoldedShape) -> (Drawing, Unfolding) {
    let mut unfolding = unfold(shape, &UnfoldOptions::default()).unwrap();
    assert_eq!(
        unfolding.outcome,
        Outcome::Unfolded,
        "{:?}",
        unfolding.reason
    );
    let drawing = unfolding.drawing.take().unwrap();
    (drawing, unfolding)
}

/// Returns the largest difference between the fold angles of two drawings of the same sheet, edge by edge.
fn angles_apart(a: &Drawing, b: &Drawing) -> f64 {
    let key = |ends: [usize; 2]| [ends[0].min(ends[1]), ends[0].max(ends[1])];
    let of = |edge: &foldpath::pattern::DrawnEdge| {
        let other = b
            .edges
            .iter()
            .find(|other| key(other.ends) == key(edge.ends));
        (edge.goal.unwrap_or(0.0) - other.unwrap().goal.unwrap_or(0.0)).abs()
    };
    assert_eq!(a.edges.len(), b.edges.len());
    worst(a.edges.iter().map(of))
}

fn families(part: f64) -> [(&'static str, Drawing); 3] {
    let yoshimura = Yoshimura {
        rows: 6,
        columns: 6,
        angle: 30_f64.to_radians(),
        fold: 0.25 * part,
    };
    let miura = Miura {
        rows: 7,
        columns: 8,
        sector_angle: 60_f64.to_radians(),
        fold: part,
    };
    let waterbomb = Waterbomb {
        rows: 6,
        columns: 8,
        fold: 0.5 * part,
    };
    [
        ("Yoshimura", yoshimura.drawing().unwrap()),
        ("Miura", miura.drawing().unwrap()),
        ("waterbomb", waterbomb.drawing().unwrap()),
    ]
}

/// The sheet is found from the shape alone, without letters, at configurations up to the end of the motion. The end of
/// the Miura fold is flat, so that the signs come from letters.
#[test]
fn a_folded_sheet_comes_back_from_anywhere_on_its_way() {
    for step in 1..=CONFIGURATIONS {
        for (name, drawing) in families(f64::from(step) / f64::from(CONFIGURATIONS)) {
            let what = format!("{name} {step}/{CONFIGURATIONS}");
            let mut shape = folded(&drawing);
            if name == "Miura" && step == CONFIGURATIONS {
                shape = with_letters(shape, &drawing);
            }
            let (back, unfolding) = unfolded(&shape);
            let size = shape.size();
            assert!(
                apart_flat(&back.vertices, &drawing.vertices) < 1e-9 * size,
                "{what}"
            );
            assert!(angles_apart(&back, &drawing) < 1e-9, "{what}");
            assert!(unfolding.max_angle_defect < 1e-12, "{what}");
            assert!(unfolding.max_closure.unwrap() < 1e-12, "{what}");
            assert!(unfolding.deviation.unwrap() < 1e-12, "{what}");
            let counts = [unfolding.vertices, unfolding.cuts, unfolding.notes.len()];
            assert_eq!(
                counts,
                [drawing.vertices.len(), 0, 0],
                "{what}: {:?}",
                unfolding.notes
            );
        }
    }
}

/// A shape that is folded flat has no side from which a fold is seen to be a valley.
#[test]
fn half_turns_without_letters_are_valleys_and_said_so() {
    let (_, drawing) = families(1.0).into_iter().nth(1).unwrap();
    let (back, unfolding) = unfolded(&folded(&drawing));
    let creases = back.edges.iter().filter(|edge| edge.goal.is_some());
    for edge in creases.clone() {
        assert_eq!(edge.letter, Letter::Valley);
        assert!((edge.goal.unwrap() - PI).abs() < 1e-12, "{edge:?}");
    }
    let all = creases.count();
    assert_eq!(
        all,
        drawing
            .edges
            .iter()
            .filter(|edge| edge.goal.is_some())
            .count()
    );
    let said = unfolding.notes.iter().any(|note| {
        note.contains("no sign that could be measured")
            && note.contains(&format!("valley: {all} (first"))
    });
    assert!(said, "{:?}", unfolding.notes);
}

/// The letters are those of a program whose faces run clockwise. The sheet is turned over, so that the letters stay
/// true.
#[test]
fn letters_of_the_other_side_turn_the_sheet_over() {
    let (_, drawing) = families(0.5).into_iter().next().unwrap();
    let mut shape = with_letters(folded(&drawing), &drawing);
    shape.faces.iter_mut().for_each(|cycle| cycle.reverse());
    let (back, unfolding) = unfolded(&shape);
    assert!(angles_apart(&back, &drawing) < 1e-9);
    assert!(apart_flat(&back.vertices, &drawing.vertices) < 1e-9);
    assert!(
        unfolding.notes[0].contains("other side"),
        "{:?}",
        unfolding.notes
    );
    // Faces of mixed orientation are turned to the side of most of them.
    shape.edges.clear();
    for face in 0..shape.faces.len() {
        if face % 3 > 0 {
            shape.faces[face].reverse();
        }
    }
    let (back, _) = unfolded(&shape);
    assert!(angles_apart(&back, &drawing) < 1e-9);
}

/// Each frame of a planned path unfolds to the pattern with the angles of that knot. Then the pattern of the last frame
/// is planned again, and its goal is the shape of which it was made.
#[test]
fn knots_of_a_planned_path_unfold_and_fold_again() {
    for family in [
        "yoshimura --rows 5 --cols 6",
        "miura --rows 4 --cols 5 --fold 1",
        "waterbomb --rows 4 --cols 6",
    ] {
        let folder = folder();
        folder.done(&format!("generate {family} -o a.fold"));
        folder.done("plan a.fold -o path.fold");
        let path = folder.read_json("path.fold");
        let frames = path["file_frames"].as_array().unwrap();
        let flat = points(&path["vertices_coords"]);
        for (index, frame) in frames.iter().enumerate() {
            let arguments = format!("unfold path.fold --frame {} -o back.fold --json", index + 1);
            let answer = folder.done(&arguments);
            let json = answer.json();
            assert_eq!(json["outcome"], "unfolded", "{family} {index}");
            assert!(
                json["max_closure"].as_f64().unwrap() < 1e-9,
                "{family}: {json}"
            );
            let back = folder.read_json("back.fold");
            assert!(
                apart(&points(&back["vertices_coords"]), &flat) < 1e-9,
                "{family}"
            );
            assert_eq!(back["edges_vertices"], path["edges_vertices"]);
            assert_eq!(back["edges_assignment"], path["edges_assignment"]);
            let [a, b] = [&back, frame].map(|file| numbers(&file["edges_foldAngle"]));
            let off = a.iter().zip(&b).map(|(a, b)| (a - b).abs().to_radians());
            assert!(worst(off) < 1e-9, "{family} {index}: {a:?} {b:?}");
        }
        // Without `--frame` the last frame is unfolded.
        folder.done("unfold path.fold -o back.fold");
        folder.done("plan back.fold -o again.fold");
        let again = folder.read_json("again.fold");
        let last = |file: &Value| {
            let frame = file["file_frames"].as_array().unwrap().last().unwrap();
            points(&frame["vertices_coords"])
        };
        let (again, shape) = (last(&again), last(&path));
        assert!(apart(&again, &shape) < 1e-6 * size(&shape), "{family}");
    }
}

/// Returns the points of a list with 2 or 3 coordinates for each point.
fn points(list: &Value) -> Vec<Vector3<f64>> {
    let point = |entry: &Value| {
        let numbers = numbers(entry);
        Vector3::new(
            numbers[0],
            numbers[1],
            numbers.get(2).copied().unwrap_or(0.0),
        )
    };
    list.as_array().unwrap().iter().map(point).collect()
}

fn size(points: &[Vector3<f64>]) -> f64 {
    worst(points.iter().map(|p| (p - points[0]).norm()))
}

fn shape(vertices: &[[f64; 3]], faces: &[&[usize]]) -> FoldedShape {
    FoldedShape {
        vertices: vertices.iter().map(|&v| v.into()).collect(),
        faces: faces.iter().map(|face| face.to_vec()).collect(),
        edges: Vec::new(),
    }
}

fn cube() -> FoldedShape {
    shape(
        &[
            [0., 0., 0.],
            [1., 0., 0.],
            [1., 1., 0.],
            [0., 1., 0.],
            [0., 0., 1.],
            [1., 0., 1.],
            [1., 1., 1.],
            [0., 1., 1.],
        ],
        &[
            &[0, 3, 2, 1],
            &[4, 5, 6, 7],
            &[0, 1, 5, 4],
            &[1, 2, 6, 5],
            &[2, 3, 7, 6],
            &[3, 0, 4, 7],
        ],
    )
}

fn area(drawing: &Drawing) -> f64 {
    let pattern = CreasePattern::new(drawing.clone()).unwrap();
    let doubled = pattern.faces().iter().map(|cycle| {
        let next = cycle.iter().cycle().skip(1);
        let at = |v: &foldpath::pattern::VertexId| drawing.vertices[v.index()];
        cycle
            .iter()
            .zip(next)
            .map(|(a, b)| at(a).perp(&at(b)))
            .sum::<f64>()
    });
    doubled.sum::<f64>() / 2.0
}

/// A net of the cube has 5 hinges, 7 cuts and 14 corners.
#[test]
fn a_closed_cube_is_cut_to_a_net() {
    let (net, unfolding) = unfolded(&cube());
    let counts = [unfolding.vertices, unfolding.creases, unfolding.cuts];
    assert_eq!(counts, [14, 5, 7]);
    assert!((area(&net) - 6.0).abs() < 1e-12);
    // All edges are mountains, seen from outside.
    let goals: Vec<f64> = net.edges.iter().filter_map(|edge| edge.goal).collect();
    assert!(
        goals.iter().all(|goal| (goal + FRAC_PI_2).abs() < 1e-12),
        "{goals:?}"
    );
    assert!((unfolding.max_angle_defect - FRAC_PI_2).abs() < 1e-12);
    assert!(unfolding.deviation.unwrap() < 1e-12);
    assert!(
        unfolding
            .notes
            .iter()
            .any(|note| note.contains(": 7 (first")),
        "{:?}",
        unfolding.notes
    );
}

/// Returns the hull of 12 points on three golden rectangles: 20 triangles, of which 5 meet at each vertex.
fn icosahedron() -> FoldedShape {
    let golden = f64::midpoint(1.0, 5_f64.sqrt());
    let corners = |k: usize| {
        let (a, b) = ([1.0, -1.0][k % 2], [golden, -golden][k / 2 % 2]);
        [[0.0, a, b], [b, 0.0, a], [a, b, 0.0]][k / 4]
    };
    let vertices: Vec<Vector3<f64>> = (0..12).map(|k| corners(k).into()).collect();
    let near = |a: usize, b: usize| ((vertices[a] - vertices[b]).norm() - 2.0).abs() < 1e-9;
    let mut faces = Vec::new();
    for a in 0..12 {
        for b in (0..a).filter(|&b| near(a, b)) {
            for c in (0..b).filter(|&c| near(a, c) && near(b, c)) {
                let up = (vertices[b] - vertices[a]).cross(&(vertices[c] - vertices[a]));
                faces.push(if up.dot(&vertices[a]) > 0.0 {
                    vec![a, b, c]
                } else {
                    vec![a, c, b]
                });
            }
        }
    }
    FoldedShape {
        vertices,
        faces,
        edges: Vec::new(),
    }
}

/// Returns unit cubes in the form of an L. The L has an inward corner, and three or more of its squares lie in one
/// plane.
fn ell() -> FoldedShape {
    let solid =
        |x: i32, y: i32, z: i32| z == 0 && [(0, 0), (1, 0), (2, 0), (0, 1)].contains(&(x, y));
    let mut shape = FoldedShape::default();
    for (x, y) in [(0, 0), (1, 0), (2, 0), (0, 1)] {
        for (axis, step) in [(0, 1), (0, -1), (1, 1), (1, -1), (2, 1), (2, -1)] {
            let mut beyond = [x, y, 0];
            beyond[axis] += step;
            if solid(beyond[0], beyond[1], beyond[2]) {
                continue;
            }
            let square = [[0, 0], [1, 0], [1, 1], [0, 1]].map(|[u, v]| {
                let mut corner = [x, y, 0];
                corner[axis] += i32::from(step > 0);
                corner[(axis + 1) % 3] += if step > 0 { u } else { v };
                corner[(axis + 2) % 3] += if step > 0 { v } else { u };
                let place = Vector3::from(corner.map(f64::from));
                let known = shape.vertices.iter().position(|p| *p == place);
                known.unwrap_or_else(|| {
                    shape.vertices.push(place);
                    shape.vertices.len() - 1
                })
            });
            shape.faces.push(square.to_vec());
        }
    }
    shape
}

/// A net of a solid with v vertices, none of them flat, has v - 1 cuts.
#[test]
fn closed_solids_are_cut_along_trees() {
    let (net, unfolding) = unfolded(&icosahedron());
    let counts = [
        unfolding.vertices,
        unfolding.faces,
        unfolding.creases,
        unfolding.cuts,
    ];
    assert_eq!(counts, [22, 20, 19, 11]);
    assert!((area(&net) - 20.0 * 3_f64.sqrt()).abs() < 1e-12);
    let bend = -(PI - (-5_f64.sqrt() / 3.0).acos());
    let goals = net.edges.iter().filter_map(|edge| edge.goal);
    assert!(goals.into_iter().all(|goal| (goal - bend).abs() < 1e-12));
    assert!(unfolding.deviation.unwrap() < 1e-12);

    let (net, unfolding) = unfolded(&ell());
    assert!((area(&net) - 18.0).abs() < 1e-12);
    assert!(unfolding.deviation.unwrap() < 1e-12);
    let valleys = net
        .edges
        .iter()
        .filter(|edge| edge.letter == Letter::Valley);
    assert!(valleys.count() <= 1);
}

/// Coordinates are rounded to seven decimals. The letters are kept, and the sheet stays in one piece.
#[test]
fn noise_neither_cuts_a_sheet_nor_bends_what_is_flat() {
    for (name, drawing) in families(0.8) {
        let mut shape = with_letters(folded(&drawing), &drawing);
        for v in &mut shape.vertices {
            *v = v.map(|c| (c * 1e7).round() / 1e7);
        }
        let (back, unfolding) = unfolded(&shape);
        assert_eq!(unfolding.cuts, 0);
        assert!(
            unfolding.max_angle_defect > 1e-9 && unfolding.max_angle_defect < 1e-5,
            "{name}"
        );
        assert!(
            apart_flat(&back.vertices, &drawing.vertices) < 3e-6,
            "{name}"
        );
        assert!(angles_apart(&back, &drawing) < 3e-6, "{name}");
        assert!(unfolding.deviation.unwrap() < 3e-6, "{name}");
        let letters =
            |drawing: &Drawing| drawing.edges.iter().map(|e| e.letter).collect::<Vec<_>>();
        assert_eq!(letters(&back), letters(&drawing), "{name}");
    }
}

/// The sides of a prism without lids are developable everywhere, but cannot lie in a plane. One cut opens each row.
#[test]
fn a_tube_is_cut_open_once_a_row() {
    let (sides, rows) = (7, 3);
    let corner = |k: usize| {
        let angle = TAU * (k % sides) as f64 / sides as f64;
        Vector3::new(angle.cos(), angle.sin(), (k / sides) as f64)
    };
    let mut tube = FoldedShape {
        vertices: (0..sides * (rows + 1)).map(corner).collect(),
        ..FoldedShape::default()
    };
    for row in 0..rows {
        for k in 0..sides {
            let (a, b) = (row * sides + k, row * sides + (k + 1) % sides);
            tube.faces.push(vec![a, b, b + sides, a + sides]);
        }
    }
    let (strip, unfolding) = unfolded(&tube);
    assert_eq!(unfolding.cuts, rows);
    assert_eq!(unfolding.vertices, (sides + 1) * (rows + 1));
    assert!(unfolding.max_angle_defect < 1e-12);
    // The strip is as wide as the circumference of the prism, and as high as the prism.
    let side = 2.0 * (PI / sides as f64).sin();
    assert!((area(&strip) - side * (sides * rows) as f64).abs() < 1e-12);
    let bends: Vec<f64> = strip.edges.iter().filter_map(|edge| edge.goal).collect();
    assert_eq!(bends.len(), rows * (sides - 1));
    let turn = -TAU / sides as f64;
    assert!(
        bends.iter().all(|bend| (bend - turn).abs() < 1e-12),
        "{bends:?}"
    );
    let flat = strip
        .edges
        .iter()
        .filter(|edge| edge.letter == Letter::Flat);
    assert_eq!(flat.count(), (rows - 1) * sides);
}

/// A ring that lies in a plane is not cut.
#[test]
fn a_flat_ring_keeps_its_hole() {
    let square = |r: f64| [[-r, -r, 0.3], [r, -r, 0.3], [r, r, 0.3], [-r, r, 0.3]];
    let vertices: Vec<[f64; 3]> = square(1.0).into_iter().chain(square(2.0)).collect();
    let faces: Vec<Vec<usize>> = (0..4)
        .map(|k| vec![k + 4, (k + 1) % 4 + 4, (k + 1) % 4, k])
        .collect();
    let faces: Vec<&[usize]> = faces.iter().map(Vec::as_slice).collect();
    let (ring, unfolding) = unfolded(&shape(&vertices, &faces));
    assert_eq!(
        [unfolding.cuts, unfolding.vertices, unfolding.creases],
        [0, 8, 0]
    );
    assert!((area(&ring) - 12.0).abs() < 1e-12);
}

/// Returns a pyramid over a polygon, open below. At its tip meet n triangles with base 2 sin(π/n) and sides √(1 + h²).
fn pyramid(sides: usize, height: f64) -> FoldedShape {
    let corner = |k: usize| {
        let angle = TAU * k as f64 / sides as f64;
        Vector3::new(angle.cos(), angle.sin(), 0.0)
    };
    let tip = Vector3::new(0.0, 0.0, height);
    FoldedShape {
        vertices: (0..sides).map(corner).chain([tip]).collect(),
        faces: (0..sides)
            .map(|k| vec![k, (k + 1) % sides, sides])
            .collect(),
        edges: Vec::new(),
    }
}

#[test]
fn a_vertex_that_no_sheet_has_is_refused_with_its_defect() {
    let (sides, height) = (5, 0.7);
    let slant = f64::hypot(1.0, height);
    let sector = 2.0 * ((PI / 5.0).sin() / slant).asin();
    let defect = TAU - 5.0 * sector;
    let uncut = UnfoldOptions::default().with(|it| it.cut = Cut::None);
    let refused = unfold(&pyramid(sides, height), &uncut).unwrap();
    assert_eq!(refused.outcome, Outcome::NotDevelopable);
    assert!((refused.max_angle_defect - defect).abs() < 1e-12);
    let reason = refused.reason.unwrap().to_string();
    assert!(reason.contains("vertex 5 at (0, 0, 0.7)"), "{reason}");
    assert!(
        reason.contains(&format!("angle defect {:.6} degrees", defect.to_degrees())),
        "{reason}"
    );
    assert!(refused.drawing.is_none() && refused.max_closure.is_none());
    // An option sets the largest defect that counts as none. This pyramid is almost flat.
    let low = pyramid(5, 1e-3);
    for (max_defect, outcome) in [(1e-6, Outcome::NotDevelopable), (1e-4, Outcome::Unfolded)] {
        for cut in [Cut::Auto, Cut::None] {
            let options = UnfoldOptions::default().with(|it| {
                it.max_defect = max_defect;
                it.cut = cut;
            });
            assert_eq!(unfold(&low, &options).unwrap().outcome, outcome);
        }
    }
}

/// An open box is cut at its four corners, from the rim to the floor if it is low. A high one is cut once from the rim, and
/// round the floor.
#[test]
fn an_open_box_is_cut_along_the_shortest_way_from_its_corners_to_the_rim() {
    for (height, length) in [(0.5, 2.0), (4.0, 7.0)] {
        let mut tray = cube();
        tray.vertices[4..]
            .iter_mut()
            .for_each(|place| place.z = height);
        tray.faces.remove(1);
        let (net, unfolding) = unfolded(&tray);
        let counts = [
            unfolding.vertices,
            unfolding.creases,
            unfolding.cuts,
            unfolding.pieces,
        ];
        assert_eq!(counts, [12, 4, 4, 1]);
        let long = |edge: &&foldpath::pattern::DrawnEdge| edge.letter == Letter::Boundary;
        let rim: f64 = net
            .edges
            .iter()
            .filter(long)
            .map(|edge| (net.vertices[edge.ends[1]] - net.vertices[edge.ends[0]]).norm())
            .sum();
        // Each cut has two sides, and the rim is four long.
        assert!((rim - 4.0 - 2.0 * length).abs() < 1e-12, "{rim}");
        assert!(unfolding.deviation.unwrap() < 1e-12);
        let uncut = UnfoldOptions::default().with(|it| it.cut = Cut::None);
        assert_eq!(
            unfold(&tray, &uncut).unwrap().outcome,
            Outcome::NotDevelopable
        );
    }
}

/// A saddle, round whose middle the angles sum to more than 360 degrees, has no net in one piece.
#[test]
fn a_saddle_is_cut_into_two_pieces() {
    let corner = |k: usize| {
        let angle = TAU * k as f64 / 8.0;
        let height = if k.is_multiple_of(2) { 0.8 } else { -0.8 };
        Vector3::new(angle.cos(), angle.sin(), height)
    };
    let saddle = FoldedShape {
        vertices: (0..8).map(corner).chain([Vector3::zeros()]).collect(),
        faces: (0..8).map(|k| vec![k, (k + 1) % 8, 8]).collect(),
        edges: Vec::new(),
    };
    let (_, unfolding) = unfolded(&saddle);
    assert_eq!(unfolding.pieces, 2);
    assert!(unfolding.deviation.unwrap() < 1e-12);
    assert!(
        unfolding.notes.iter().any(|note| note.contains("pieces")),
        "{:?}",
        unfolding.notes
    );
}

/// A ring that no plane holds stays whole with `--cut none`, and the answer is no.
#[test]
fn a_ring_that_is_not_cut_has_no_pattern() {
    let mut sleeve = cube();
    sleeve.faces.drain(..2);
    let uncut = UnfoldOptions::default().with(|it| it.cut = Cut::None);
    let refused = unfold(&sleeve, &uncut).unwrap();
    assert_eq!(refused.outcome, Outcome::NotDevelopable);
    assert!(matches!(refused.reason, Some(Reason::RingStaysOpen { .. })));
}

/// Coordinates are rounded to some decimals. Angle defects, faces and edges that are off by no more than that are taken for
/// flat, and the precision is handed down.
#[test]
fn rounding_of_coordinates_is_no_corner() {
    for (name, drawing) in families(0.8) {
        for decimals in [3] {
            let mut shape = folded(&drawing);
            let unit = 10_f64.powi(-decimals);
            for v in &mut shape.vertices {
                *v = v.map(|c| (c / unit).round() * unit);
            }
            let (back, unfolding) = unfolded(&shape);
            assert_eq!(unfolding.cuts, 0, "{name}");
            assert!(
                unfolding.max_angle_defect > UnfoldOptions::default().max_defect,
                "{name}"
            );
            assert!(
                apart_flat(&back.vertices, &drawing.vertices) < 30.0 * unit,
                "{name}"
            );
            assert!(unfolding.precision.length.unit() >= 0.99 * unit, "{name}");
            assert!(
                unfolding.notes.iter().any(|note| note.contains("rounding")),
                "{name}"
            );
        }
    }
}

/// Errors that the digits do not explain are refused with the option that would take them.
#[test]
fn errors_of_a_measured_sheet_name_the_option_that_takes_them() {
    let folder = folder();
    let (_, drawing) = families(0.8).into_iter().nth(1).unwrap();
    let mut shape = folded(&drawing);
    shape.faces = shape
        .faces
        .iter()
        .flat_map(|f| [vec![f[0], f[1], f[2]], vec![f[0], f[2], f[3]]])
        .collect();
    for (k, place) in shape.vertices.iter_mut().enumerate() {
        *place += 1e-3 / 7.0 * Vector3::new((k as f64).sin(), (3.0 * k as f64).cos(), 0.3);
    }
    folder.write("a.obj", &obj(&shape));
    let refused = folder
        .run("unfold a.obj -o a.fold --json")
        .with_status(1)
        .json();
    assert_eq!(refused["outcome"], "not_developable");
    let reason = refused["reason"].as_str().unwrap();
    let option = reason
        .split('`')
        .find(|part| part.starts_with("--max-defect"))
        .expect(reason);
    let taken = folder
        .done(&format!("unfold a.obj -o a.fold --json {option}"))
        .json();
    assert_eq!(
        json!([taken["outcome"], taken["cuts"]]),
        json!(["unfolded", 0])
    );
    // A face that is not flat by as much.
    let mut bent = cube();
    bent.vertices[6].z += 0.003_051_7;
    folder.write("b.obj", &obj(&bent));
    let refused = folder.run("unfold b.obj -o b.fold").with_status(2);
    let option = refused
        .stderr
        .split('`')
        .find(|part| part.starts_with("--max-defect"));
    folder.done(&format!(
        "unfold b.obj -o b.fold {}",
        option.expect(&refused.stderr)
    ));
}

/// Corners that a face repeats and faces without an area are left out, with the line of the first. Faces at both sides of a
/// face without an area meet then.
#[test]
fn faces_without_an_area_are_left_out_with_their_line() {
    let folder = folder();
    let sheet = "v 0 0 0\nv 1 0 0\nv 2 0 0\nv 0 1 0\nv 2 1 0.5\n";
    for (faces, note) in [
        (
            "f 1 2 3\nf 1 3 4\nf 4 3 5\n",
            "faces without an area, left out: 1 (first: line 6)",
        ),
        (
            "f 1 3 4\nf 4 3 5\nf 4 4 5\n",
            "faces without an area, left out: 1 (first: line 8)",
        ),
        (
            "f 1 3 4\nf 4 3 3 5\n",
            "corners that a face repeats, left out: 1 (first: line 7)",
        ),
        (
            "f 1 3 2 3 4\nf 4 3 5\n",
            "corners that a face repeats, left out: 2 (first: line 6)",
        ),
    ] {
        folder.write("a.obj", &format!("{sheet}{faces}"));
        let answer = folder.done("unfold a.obj -o a.fold --json");
        assert!(answer.stderr.contains(note), "{faces}: {}", answer.stderr);
        assert_eq!(answer.json()["creases"], 1, "{faces}");
    }
    // A sliver between two rows: the lower one is as long as both upper ones.
    let rows = "v 0 0 0\nv 1 0 0\nv 2 0 0\nv 0 -1 0\nv 2 -1 0\nv 0 0 1\nv 1 0 1\nv 2 0 1\n\
        f 4 5 3 1\nf 1 3 2\nf 1 2 7 6\nf 2 3 8 7\n";
    folder.write("rows.obj", rows);
    let json = folder.done("unfold rows.obj -o rows.fold --json").json();
    assert_eq!(
        json!([json["creases"], json["pieces"], json["cuts"]]),
        json!([2, 1, 0])
    );
    folder.write("all.obj", "v 0 0 0\nv 1 0 0\nv 2 0 0\nf 1 2 3\n");
    let refused = folder.run("unfold all.obj -o a.fold").with_status(2);
    let expected = "all.obj: line 4: expected a face with at least 3 different vertices and an area, found none";
    assert!(refused.tells(expected), "{}", refused.stderr);
}

/// Corners that differ in the last digits of the file are one, in each format.
#[test]
fn corners_within_the_precision_of_a_file_are_one() {
    let folder = folder();
    let turn = Rotation3::from_euler_angles(0.3, -1.1, 2.5);
    let mut off = triangles(&cube());
    for (k, corner) in off.iter_mut().flatten().enumerate() {
        *corner = turn * *corner * 80.0;
        let bit = 80.0 * f64::from(f32::EPSILON);
        corner.x += bit * (k as f64).sin();
        corner.z += bit * (k as f64).cos();
    }
    folder.write("text.stl", &stl_text(&off));
    std::fs::write(folder.path("binary.stl"), stl_binary(&off)).unwrap();
    let mut rounded = off.clone();
    for (k, corner) in rounded.iter_mut().flatten().enumerate() {
        *corner = corner.map(|c| ((c * 1e3).round() + f64::from(k % 2 == 0)) / 1e3);
    }
    folder.write("rounded.stl", &stl_text(&rounded));
    folder.write("capitals.stl", &stl_text(&off).to_uppercase());
    for name in ["text.stl", "binary.stl", "rounded.stl", "capitals.stl"] {
        let json = folder
            .done(&format!("unfold {name} -o net.fold --json"))
            .json();
        assert_eq!(
            json!([json["creases"], json["cuts"], json["pieces"]]),
            json!([5, 7, 1]),
            "{name}"
        );
    }
}

/// Walls that are modelled one by one, each of two triangles, have corners of their own. The seams are joined.
#[test]
fn parts_that_touch_along_edges_are_joined() {
    let folder = folder();
    let mut walls = String::new();
    for (index, face) in cube().faces.iter().enumerate() {
        for &v in face {
            let place = cube().vertices[v];
            walls += &format!("v {} {} {}\n", place.x, place.y, place.z);
        }
        let name = |k: usize| 4 * index + k;
        walls += &format!(
            "f {} {} {}\nf {} {} {}\n",
            name(1),
            name(2),
            name(3),
            name(1),
            name(3),
            name(4)
        );
    }
    folder.write("walls.obj", &walls);
    let json = folder.done("unfold walls.obj -o net.fold --json").json();
    assert_eq!(
        json!([json["creases"], json["cuts"], json["pieces"]]),
        json!([5, 7, 1])
    );
}

/// A line of an OBJ file goes on behind a backslash, and an error names the line of the word.
#[test]
fn lines_of_obj_files_are_continued() {
    let folder = folder();
    let text = obj(&cube()).replace(" 4//1", " \\\n 4//1");
    assert!(text.contains('\\'), "{text}");
    folder.write("a.obj", &text);
    assert_eq!(
        folder.done("unfold a.obj -o net.fold --json").json()["creases"],
        5
    );
    folder.write("b.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 \\\n2 \\\nx 3\n");
    let refused = folder.run("unfold b.obj -o net.fold").with_status(2);
    assert!(
        refused.stderr.contains("b.obj: line 6: expected a vertex"),
        "{}",
        refused.stderr
    );
}

/// Returns a spiral staircase, a strip of triangles. Two turns of it unfold to a ring that goes round twice.
fn staircase(steps: usize) -> FoldedShape {
    let place = |k: usize| {
        let (step, outer) = (k / 2, k % 2 == 1);
        let angle = TAU * step as f64 / 12.0;
        let radius = if outer { 2.0 } else { 1.0 };
        Vector3::new(
            radius * angle.cos(),
            radius * angle.sin(),
            0.05 * step as f64,
        )
    };
    let triangle = |k: usize| {
        if k.is_multiple_of(2) {
            vec![k, k + 1, k + 2]
        } else {
            vec![k, k + 2, k + 1]
        }
    };
    FoldedShape {
        vertices: (0..steps + 2).map(place).collect(),
        faces: (0..steps).map(triangle).collect(),
        edges: Vec::new(),
    }
}

#[test]
fn a_spiral_that_lies_on_itself_is_no_crease_pattern() {
    let once = unfold(&staircase(20), &UnfoldOptions::default()).unwrap();
    assert_eq!(once.outcome, Outcome::Unfolded, "{:?}", once.reason);
    let twice = unfold(&staircase(48), &UnfoldOptions::default()).unwrap();
    assert_eq!(twice.outcome, Outcome::Overlap);
    let Some(Reason::FacesOverlap { faces: [a, b], .. }) = twice.reason else {
        panic!("{:?}", twice.reason);
    };
    // The faces that the reason names lie about a turn apart.
    assert!(a.abs_diff(b) > 15, "{a} {b}");
    assert!(twice.drawing.is_none());
}

#[test]
fn parts_come_side_by_side_and_points_are_parted() {
    let mut two = cube();
    two.faces.truncate(1);
    two.faces.push(vec![4, 5, 6, 7]);
    let (drawing, unfolding) = unfolded(&two);
    assert_eq!(CreasePattern::new(drawing.clone()).unwrap().sheets(), 2);
    assert!((area(&drawing) - 2.0).abs() < 1e-12);
    assert!(
        unfolding.notes[1].contains("side by side: 2"),
        "{:?}",
        unfolding.notes
    );
    // Two faces meet only in vertex 6.
    let mut point = cube();
    point.faces = vec![vec![0, 3, 2, 1], vec![1, 2, 6, 5], vec![4, 5, 6, 7]];
    let (drawing, _) = unfolded(&point);
    assert_eq!(drawing.vertices.len(), 8);
    assert_eq!(CreasePattern::new(drawing).unwrap().sheets(), 1);
}

#[test]
fn shapes_that_are_no_surface_are_refused() {
    let band = |twist: bool| {
        let count = 8;
        let place = |k: usize| {
            let around = TAU * (k / 2) as f64 / count as f64;
            let lean = if twist { around / 2.0 } else { 0.0 };
            let out = if k.is_multiple_of(2) { 0.3 } else { -0.3 };
            let radius = 1.0 + out * lean.sin();
            Vector3::new(
                radius * around.cos(),
                radius * around.sin(),
                out * lean.cos(),
            )
        };
        let next = |k: usize| {
            let last = 2 * count;
            if k < last {
                k
            } else {
                (k - last) ^ usize::from(twist)
            }
        };
        let triangles = (0..2 * count).map(|k| {
            let face = [k, k + 1, k + 2].map(next);
            if k.is_multiple_of(2) {
                face.to_vec()
            } else {
                vec![face[0], face[2], face[1]]
            }
        });
        FoldedShape {
            vertices: (0..2 * count).map(place).collect(),
            faces: triangles.collect(),
            edges: Vec::new(),
        }
    };
    let error = |shape: &FoldedShape| unfold(shape, &UnfoldOptions::default()).unwrap_err();
    assert!(unfold(&band(false), &UnfoldOptions::default()).is_ok());
    let moebius = error(&band(true));
    assert!(matches!(moebius, ShapeError::OneSided { .. }), "{moebius}");

    let mut fin = cube();
    fin.vertices.push([0.5, -1.0, 0.5].into());
    fin.faces.push(vec![0, 1, 8]);
    let branching = ShapeError::Branching {
        ends: [1, 0],
        faces: [0, 2, 6],
    };
    assert_eq!(error(&fin), branching);

    let mut bent = cube();
    bent.vertices[6].z += 0.1;
    assert!(matches!(error(&bent), ShapeError::NotFlat { .. }));
    let mut thin = cube();
    thin.faces[2] = vec![0, 1, 0];
    assert_eq!(error(&thin), ShapeError::NoArea { face: 2 });
    let line = shape(&[[0., 0., 0.], [1., 0., 0.], [3., 0., 0.]], &[&[0, 1, 2]]);
    assert_eq!(error(&line), ShapeError::NoArea { face: 0 });
    let mut far = cube();
    far.vertices[3].x = f64::NAN;
    assert_eq!(error(&far), ShapeError::NotFinite { vertex: 3 });
    far.vertices[3].x = 1.0;
    far.faces[5][2] = 8;
    assert!(matches!(
        error(&far),
        ShapeError::NoVertex {
            vertex: 8,
            last: 7,
            ..
        }
    ));
    assert_eq!(error(&FoldedShape::default()), ShapeError::NoFaces);
}

/// Returns an OBJ file of a shape, with quirks that such files have.
fn obj(shape: &FoldedShape) -> String {
    let mut text = String::from("# by hand\nmtllib a.mtl\no thing\nvn 0 0 1\nvt 0 0\n");
    for v in &shape.vertices {
        text += &format!("v {} {} {}\n", v.x, v.y, v.z);
    }
    let count = shape.vertices.len();
    for (index, face) in shape.faces.iter().enumerate() {
        let name = |v: &usize| match index % 3 {
            0 => format!(" {}", v + 1),
            1 => format!(" {}//1", v + 1),
            _ => format!(" -{}/1/1", count - v),
        };
        text += &format!("f{}\r\n", face.iter().map(name).collect::<String>());
    }
    text
}

/// Cuts the quadrilaterals of a shape into triangles, as an STL file needs them.
fn triangles(shape: &FoldedShape) -> Vec<[Vector3<f64>; 3]> {
    let triangles = shape
        .faces
        .iter()
        .flat_map(|face| [[face[0], face[1], face[2]], [face[0], face[2], face[3]]]);
    triangles.map(|t| t.map(|v| shape.vertices[v])).collect()
}

fn stl_text(triangles: &[[Vector3<f64>; 3]]) -> String {
    let mut text = String::from("solid cube\n");
    for corners in triangles {
        text += "facet normal 0 0 0\n outer loop\n";
        for p in corners {
            text += &format!("  vertex {} {} {}\n", p.x, p.y, p.z);
        }
        text += " endloop\nendfacet\n";
    }
    text + "endsolid cube\n"
}

#[allow(
    clippy::cast_possible_truncation,
    reason = "the format is of single precision"
)]
fn stl_binary(triangles: &[[Vector3<f64>; 3]]) -> Vec<u8> {
    let mut bytes = b"solid says nothing".to_vec();
    bytes.resize(80, b' ');
    bytes.extend(u32::try_from(triangles.len()).unwrap().to_le_bytes());
    for corners in triangles {
        bytes.extend([0; 12]);
        for number in corners.iter().flatten() {
            bytes.extend((*number as f32).to_le_bytes());
        }
        bytes.extend([0; 2]);
    }
    bytes
}

#[test]
fn the_cube_is_the_same_from_every_format() {
    let folder = folder();
    folder.write("cube.obj", &obj(&cube()));
    let triangles = triangles(&cube());
    folder.write("text.stl", &stl_text(&triangles));
    std::fs::write(folder.path("binary.STL"), stl_binary(&triangles)).unwrap();
    let fold = json!({
        "frame_classes": ["foldedForm"],
        "vertices_coords": cube().vertices.iter().map(|v| [v.x, v.y, v.z]).collect::<Vec<_>>(),
        "faces_vertices": cube().faces,
    });
    folder.write("cube.fold", &fold.to_string());
    // Faces that share no vertices are joined at corners with the same position.
    let mut soup = String::new();
    for (index, corners) in triangles.iter().enumerate() {
        for p in corners {
            soup += &format!("v {} {} {}\n", p.x, p.y, p.z);
        }
        soup += &format!("f {} {} {}\n", 3 * index + 1, 3 * index + 2, 3 * index + 3);
    }
    folder.write("soup.obj", &soup);
    for (name, faces) in [
        ("cube.obj", 6),
        ("cube.fold", 6),
        ("text.stl", 12),
        ("binary.STL", 12),
        ("soup.obj", 12),
    ] {
        let answer = folder.done(&format!("unfold {name} -o net.fold --json"));
        let json = answer.json();
        let expected = json!(["unfolded", null, 14, faces, 5, 7, 1]);
        let keys = [
            "outcome", "reason", "vertices", "faces", "creases", "cuts", "pieces",
        ];
        assert_eq!(json!(keys.map(|key| &json[key])), expected, "{name}");
        assert_eq!(json["max_angle_defect"], 90.0, "{name}");
        assert!(json["max_closure"].as_f64().unwrap() < 1e-12, "{name}");
        assert!(
            answer.stderr.contains("cut along edges"),
            "{name}: {}",
            answer.stderr
        );
        assert_eq!(
            answer.stderr.contains("made one: 36 are 8"),
            faces == 12,
            "{name}: {}",
            answer.stderr
        );
        // Other commands can read the pattern, and its goal is the cube: corners that were one vertex of the cube are
        // not apart.
        let planned = folder.done("plan net.fold -o path.fold");
        assert!(
            planned.stdout.contains("planned"),
            "{name}: {}",
            planned.stdout
        );
        let path = folder.read_json("path.fold");
        let end =
            points(&path["file_frames"].as_array().unwrap().last().unwrap()["vertices_coords"]);
        let corners = end.iter().enumerate();
        let new = |&(k, p): &(usize, &Vector3<f64>)| end[..k].iter().all(|q| (p - q).norm() > 1e-9);
        let distinct: Vec<&Vector3<f64>> = corners.filter(new).map(|(_, p)| p).collect();
        assert_eq!(distinct.len(), 8, "{name}");
        let far = worst(
            distinct
                .iter()
                .flat_map(|p| distinct.iter().map(move |q| (*p - *q).norm())),
        );
        assert!((far - 3_f64.sqrt()).abs() < 1e-9, "{name}");
    }
}

/// OBJ file as Freeform Origami writes it, with a comment for each side of a face. Its types are 0 for boundary, 1 for
/// diagonal, 2 for valley and 3 for mountain.
const CREASES: &str = "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nf 1 2 4\nf 2 3 4\n\
    #e 1 2 0 0 0\n#e 2 4 3 -180 0\n#e 4 1 0 0 0\n#e 2 3 0 0 0\n#e 3 4 0 0 0\n#e 4 2 3 -180 0\n#e 1 3 1 0 0\n";

#[test]
fn creases_in_comments_of_an_obj_file_are_read() {
    let folder = folder();
    // The sheet is folded flat along the diagonal, so corner 3 lies on corner 1.
    folder.write("folded.obj", &CREASES.replace("v 1 1 0", "v 0 0 0"));
    let answer = folder.done("unfold folded.obj -o flat.fold");
    assert_eq!(answer.stderr, "");
    let flat = folder.read_json("flat.fold");
    let mountain: Vec<usize> = (0..5)
        .filter(|&k| flat["edges_assignment"][k] == "M")
        .collect();
    assert_eq!(mountain, [1]);
    assert_eq!(flat["edges_foldAngle"][1], -180.0);
    assert_eq!(flat["vertices_coords"].as_array().unwrap().len(), 4);
    // The flat sheet is itself a crease pattern.
    folder.write("flat.obj", CREASES);
    let info = folder.done("info flat.obj --json").json();
    assert_eq!(
        json!([&info["letters"], &info["faces"]]),
        json!([{"B": 4, "M": 1}, 2])
    );
    assert_eq!(info["closure_goal"], 0.0);
    folder.done("plan flat.obj -o path.fold");
    let end = folder.read_json("path.fold")["file_frames"]
        .as_array()
        .unwrap()
        .last()
        .unwrap()
        .clone();
    assert!(numbers(&end["edges_foldAngle"]).contains(&-180.0));
    // Without comments every crease is free. A shape that is not flat is no crease pattern.
    let plain: String = CREASES
        .lines()
        .filter(|line| !line.starts_with('#'))
        .map(|line| format!("{line}\n"))
        .collect();
    folder.write("plain.obj", &plain);
    let info = folder.done("info plain.obj --json").json();
    assert_eq!(info["letters"], json!({"B": 4, "U": 1}));
    folder.write("bent.obj", &CREASES.replace("v 1 1 0", "v 1 1 1"));
    let bent = folder.run("info bent.obj").with_status(2);
    let expected = "bent.obj: the vertices: expected a flat crease pattern (a folded shape has to be \
                    unfolded first), found vertices that lie in no common plane";
    assert!(bent.tells(expected), "{}", bent.stderr);
}

#[test]
fn bad_files_are_refused_with_the_place() {
    let folder = folder();
    let tetra = "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nf 1 3 2\n";
    let cases = [
        (
            "a.obj",
            "",
            "the file: expected an OBJ file with faces (f A B C ...), found none",
        ),
        (
            "a.obj",
            "v 0 0\n",
            "line 1: expected a vertex, v and 3 coordinates, found \"v 0 0\"",
        ),
        (
            "a.obj",
            "v 0 x 1\n",
            "line 1: expected a coordinate from -1e50 to 1e50, found \"x\"",
        ),
        (
            "a.obj",
            "v 0 nan 1\n",
            "line 1: expected a coordinate from -1e50 to 1e50, found \"nan\"",
        ),
        (
            "a.obj",
            "v 0 1e60 1\n",
            "line 1: expected a coordinate from -1e50 to 1e50, found \"1e60\"",
        ),
        (
            "a.obj",
            "v 0 0 0\nf 1 2\n",
            "line 2: expected a face, f and at least 3 vertices, found \"f 1 2\"",
        ),
        (
            "a.obj",
            "v 0 0 0\nf 1 0 1\n",
            "line 2: expected a vertex, counted from 1, or from -1 to -1 backwards, found \"0\"",
        ),
        (
            "a.obj",
            "v 0 0 0\nf 1 -2 1\n",
            "line 2: expected a vertex, counted from 1, or from -1 to -1 backwards, found \"-2\"",
        ),
        (
            "a.obj",
            "v 0 0 0\nf 1/a 1 x/1\n",
            "line 2: expected a vertex, counted from 1, or from -1 to -1 backwards, found \"x/1\"",
        ),
        (
            "a.obj",
            "v 0 0 0\nf 1 2 3\n",
            "line 2: expected vertices from 1 to 1, found \"2\"",
        ),
        (
            "a.obj",
            &format!("{tetra}#e 1 9 2 0 0\n"),
            "line 6: expected vertices from 1 to 4, found \"9\"",
        ),
        (
            "a.obj",
            &format!("{tetra}#e 1 2 7 0 0\n"),
            "line 6: expected a type, 0 boundary, 1 diagonal, 2 valley or 3 mountain, found \"7\"",
        ),
        (
            "a.obj",
            &format!("{tetra}#e 1 2 3 x 0\n"),
            "line 6: expected an angle in degrees, found \"x\"",
        ),
        (
            "a.obj",
            &format!("{tetra}f 1 2 4\nf 1 2 3\n"),
            "the edge from vertex 1 to 0: expected at most 2 faces, found 0, 1 and 2",
        ),
        (
            "a.stl",
            "",
            "the file: expected an STL file: text that begins with \"solid\", or 84 bytes and 50 for each triangle, found 0 bytes",
        ),
        (
            "a.stl",
            "solid\nendsolid\n",
            "the file: expected at least one triangle, found none",
        ),
        (
            "a.stl",
            "solid\nouter loop\nvertex 0 0\n",
            "line 3: expected a corner, vertex and 3 numbers, found \"vertex 0 0\"",
        ),
        (
            "a.stl",
            "solid\nouter loop\nvertex 0 0 0\nendloop\n",
            "line 4: expected 3 corners (vertex) before endloop, found \"endloop\"",
        ),
        (
            "a.stl",
            "solid\nbox\n",
            "line 2: expected solid, facet, outer loop, vertex, endloop, endfacet or endsolid, found \"box\"",
        ),
        (
            "a.stl",
            "solid\nvertex nan 0 0\nvertex 0 1 0\nvertex 0 0 1\n",
            "triangle 0: expected coordinates from -1e50 to 1e50, found [NaN, 0.0, 0.0]",
        ),
        (
            "a.fold",
            "{}",
            "vertices_coords: expected a list, found nothing",
        ),
        (
            "a.fold",
            r#"{"vertices_coords":[[0,0,0],[1,0,0],[0,1,0]]}"#,
            "faces_vertices: expected the faces of the shape, found nothing",
        ),
        (
            "a.fold",
            r#"{"vertices_coords":[[0,0,0],[1,0,0],[0,1,0]],"faces_vertices":[[0,1,3]]}"#,
            "face 0: vertex 3 does not exist, expected 0 to 2",
        ),
        (
            "a.fold",
            r#"{"vertices_coords":[[0,0],[1,0],[0,1]],"faces_vertices":[[0,1,2]],"file_frames":[{"frame_classes":["foldedForm"],"frame_inherit":true,"frame_parent":0}]}"#,
            "file_frames[0].vertices_coords: expected the folded positions of the vertices, found nothing",
        ),
    ];
    let mut wrong = Vec::new();
    for (name, text, message) in cases {
        folder.write(name, text);
        let answer = folder.run(&format!("unfold {name} -o out.fold"));
        let told = answer.tells(&format!("{name}: {message}"));
        if !told || answer.status != Some(2) || !answer.stdout.is_empty() {
            wrong.push(format!(
                "{text}\n  expected {message}\n  found {answer:?}\n"
            ));
        }
    }
    assert!(wrong.is_empty(), "{}", wrong.concat());
    for (arguments, message) in [
        (
            "unfold a.obj --frame 1 -o out.fold",
            "a.obj: frame 1: expected a FOLD file, which has frames, found an OBJ file",
        ),
        (
            "unfold a.fold --frame 7 -o out.fold",
            "a.fold: file_frames[6]: expected a frame, found none",
        ),
        (
            "unfold a.obj -o a.obj",
            "-o: a.obj is an input file, expected another",
        ),
        (
            "unfold a.obj --max-defect 0 -o b",
            "--max-defect: expected degrees above 0 and at most 10, found 0",
        ),
    ] {
        let answer = folder.run(arguments).with_status(2);
        assert!(answer.tells(message), "{}", answer.stderr);
    }
    // If the answer is no, no file is written either.
    folder.write("pyramid.obj", &obj(&pyramid(4, 1.0)));
    let json = folder
        .run("unfold pyramid.obj -o out.fold --json --cut none")
        .with_status(1)
        .json();
    assert_eq!(
        json!([&json["outcome"], &json["max_closure"]]),
        json!(["not_developable", null])
    );
    assert_eq!(folder.names(), ["a.fold", "a.obj", "a.stl", "pyramid.obj"]);
}

/// Files that are cut off or have changed bytes lead to an answer or an error, never to a panic.
#[test]
fn no_file_makes_it_panic() {
    let folder = tempfile::tempdir().unwrap();
    let files: [(&str, Vec<u8>); 4] = [
        ("a.obj", obj(&cube()).into_bytes()),
        ("b.obj", CREASES.into()),
        ("a.stl", stl_text(&triangles(&cube())).into_bytes()),
        ("b.stl", stl_binary(&triangles(&cube()))),
    ];
    let mut seed = 1_u64;
    let mut random = move |below: usize| {
        // The generator is xorshift of G. Marsaglia.
        seed ^= seed << 13;
        seed ^= seed >> 7;
        seed ^= seed << 17;
        usize::try_from(seed % 1_000_003).unwrap() % below
    };
    let mut answers = [0; 2];
    for round in 0..1500 {
        let (name, bytes) = &files[round % files.len()];
        let mut bytes = bytes.clone();
        for _ in 0..=random(4) {
            let at = random(bytes.len());
            match random(4) {
                0 => bytes.truncate(at + 1),
                1 => drop(bytes.remove(at)),
                _ => bytes[at] = b"0123456789-.e/ vf#\n\xff\0"[random(21)],
            }
            if bytes.is_empty() {
                break;
            }
        }
        let path = folder.path().join(name);
        std::fs::write(&path, &bytes).unwrap();
        let read = read_file(&path).and_then(|bytes| parse_shape(&path, &bytes, None, None));
        let answer = read.is_ok_and(|file| unfold(&file.shape, &UnfoldOptions::default()).is_ok());
        answers[usize::from(answer)] += 1;
        let _pattern = foldpath::read::read_pattern(&path);
    }
    assert!(answers[0] > 200 && answers[1] > 50, "{answers:?}");
}
