//! Tests the files that `foldpath export` writes for renderers and drawing programs.

use std::fs;

use crate::common::{PATTERNS, folder, folder_with_path};
use foldpath::collision::{Plates, Trims};
use foldpath::folding::{Dihedral, deformation};
use foldpath::motion::Motion;
use foldpath::pattern::Letter;
use foldpath::read::fold::read_motion;
use foldpath::read::read_pattern;
use foldpath::read::read_pattern as read_any;
use gltf::animation::util::ReadOutputs;
use gltf::mesh::Mode;
use nalgebra::Vector3;

/// Returns the positions of the vertices in an OBJ file, and its faces with vertices counted from 0.
fn obj(text: &str) -> (Vec<Vector3<f64>>, Vec<Vec<u32>>) {
    let of = |kind: &str| {
        let lines = text
            .lines()
            .map(|line| line.split_whitespace().collect::<Vec<_>>());
        let kind = kind.to_string();
        lines.filter(move |words| words.first().is_some_and(|first| *first == kind))
    };
    let places = of("v").map(|words| {
        let numbers: Vec<f64> = words[1..]
            .iter()
            .map(|word| word.parse().unwrap())
            .collect();
        Vector3::from_column_slice(&numbers)
    });
    let faces = of("f").map(|words| {
        let corners = words[1..]
            .iter()
            .map(|word| word.parse::<u32>().unwrap() - 1);
        corners.collect()
    });
    (places.collect(), faces.collect())
}

/// Returns the largest difference (radians) between given fold angles and those measured on a shape.
fn angle_error(path: &Motion, angles: &[f64], shape: &[Vector3<f64>]) -> f64 {
    let errors = Dihedral::all(&path.pattern).into_iter().map(|dihedral| {
        let assigned = dihedral.edge.map_or(0.0, |edge| angles[edge.index()]);
        (dihedral.fold_angle(shape) - assigned).abs()
    });
    errors.fold(0.0, f64::max)
}

/// Returns the fold angles of all edges at a time, by the path's own motion.
fn angles_at(path: &Motion, time: f64) -> Vec<f64> {
    let knots = &path.knots;
    let segment = knots
        .windows(2)
        .position(|pair| time <= pair[1].time)
        .unwrap();
    let [from, to] = [segment, segment + 1].map(|knot| knots[knot].time);
    let edges = (0..path.pattern.edges().len()).map(foldpath::pattern::EdgeId::new);
    let curve = |edge| path.curve(segment, edge);
    edges
        .map(|edge| curve(edge).angle((time - from) / (to - from)))
        .collect()
}

#[test]
fn an_obj_sequence_shows_the_path_at_its_knots_or_evenly_in_time() {
    let folder = folder_with_path();
    let path = read_motion(&folder.path("path.fold")).unwrap();
    let end = path.knots.last().unwrap().time;
    let knots: Vec<f64> = path.knots.iter().map(|knot| knot.time).collect();
    let evenly: Vec<f64> = (0..5).map(|k| end * f64::from(k) / 4.0).collect();
    fs::create_dir(folder.path("there")).unwrap();
    for (options, frame, times) in [
        ("-o fold.obj", "fold-0000.obj", &knots),
        ("-o seq --frames 5", "seq-0000.obj", &evenly),
        ("-o there --frames 5", "there/frame-0000.obj", &evenly),
        ("-o new/", "new/frame-0000.obj", &knots),
    ] {
        let said = folder
            .done(&format!("export path.fold --to obj {options}"))
            .stdout;
        let last = frame.replace("0000", &format!("{:04}", times.len() - 1));
        assert!(
            said.contains(&format!("written to {frame} to {last}")),
            "{said}"
        );
        for (index, &time) in times.iter().enumerate() {
            let name = frame.replace("0000", &format!("{index:04}"));
            let (shape, faces) = obj(&folder.read(&name));
            let expected = path.pattern.faces().iter();
            let expected: Vec<Vec<u32>> =
                expected.map(|f| f.iter().map(|v| v.0).collect()).collect();
            assert_eq!(faces, expected);
            assert!(deformation(&path.pattern, &shape) < 1e-12, "{name}");
            let error = angle_error(&path, &angles_at(&path, time), &shape);
            assert!(error < 1e-9, "{name}: {error:e}");
        }
        let next = frame.replace("0000", &format!("{:04}", times.len()));
        assert!(!folder.path(&next).exists(), "{next}");
    }
}

/// The `gltf` crate checks references, kinds and required keys when it reads a file.
#[test]
fn a_glb_is_valid_and_plays_the_path() {
    let folder = folder_with_path();
    folder.done("plan miura.fold --frames angles -o bare.fold");
    let path = read_motion(&folder.path("path.fold")).unwrap();
    for (file, options, frames) in [
        ("path.fold", "--frames 7", Some(7)),
        ("path.fold", "", None),
        ("bare.fold", "--frames 7", Some(7)),
    ] {
        folder.done(&format!("export {file} --to glb -o a.glb {options}"));
        let bytes = fs::read(folder.path("a.glb")).unwrap();
        let glb = gltf::Gltf::from_slice(&bytes).unwrap();
        let data = glb.blob.as_deref().unwrap();
        let buffer = |_: gltf::Buffer<'_>| Some(data);
        let mesh = glb.meshes().next().unwrap();
        let primitives: Vec<_> = mesh.primitives().collect();
        let modes: Vec<Mode> = primitives.iter().map(gltf::Primitive::mode).collect();
        assert_eq!(modes, [Mode::Triangles, Mode::Triangles, Mode::Lines]);

        // Front and back have the same triangles with opposite orientations, and each is seen from one side only.
        let corners = |primitive: &gltf::Primitive<'_>| -> Vec<u32> {
            primitive
                .reader(buffer)
                .read_indices()
                .unwrap()
                .into_u32()
                .collect()
        };
        let [front, back, edges] = [0, 1, 2].map(|k| corners(&primitives[k]));
        assert_eq!(front.len(), 3 * path.pattern.triangles().items().len());
        let turned = back.chunks(3).flat_map(|t| [t[0], t[2], t[1]]);
        assert!(turned.eq(front.iter().copied()));
        assert_eq!(edges.len(), 2 * path.pattern.edges().len());
        assert!(glb.materials().all(|material| !material.double_sided()));

        let places = |positions: &mut dyn Iterator<Item = [f32; 3]>| -> Vec<Vector3<f64>> {
            positions.map(|p| Vector3::from(p.map(f64::from))).collect()
        };
        let reader = primitives[0].reader(buffer);
        let base = places(&mut reader.read_positions().unwrap());
        let moves: Vec<_> = reader
            .read_morph_targets()
            .map(|(moves, ..)| places(&mut moves.unwrap()))
            .collect();
        let animation = glb.animations().next().unwrap();
        let channel = animation.channels().next().unwrap();
        let reader = channel.reader(buffer);
        let times: Vec<f32> = reader.read_inputs().unwrap().collect();
        let Some(ReadOutputs::MorphTargetWeights(weights)) = reader.read_outputs() else {
            panic!("weights");
        };
        let weights: Vec<f32> = weights.into_f32().collect();
        assert_eq!(weights.len(), times.len() * moves.len());
        assert!(frames.is_none_or(|frames| times.len() == frames));
        let mut before: Option<Vec<f64>> = None;
        for (key, &time) in times.iter().enumerate() {
            let weights = &weights[key * moves.len()..][..moves.len()];
            let mut shape = base.clone();
            for (weight, moves) in weights.iter().zip(&moves) {
                for (place, way) in shape.iter_mut().zip(moves) {
                    *place += way * f64::from(*weight);
                }
            }
            let time = f64::from(time).min(path.knots.last().unwrap().time);
            let angles = angles_at(&path, time);
            let error = angle_error(&path, &angles, &shape);
            assert!(error < 1e-5, "{file}, key {key}: {error:e}");
            let turned = before
                .iter()
                .flatten()
                .zip(&angles)
                .map(|(a, b)| (a - b).abs());
            let turned = turned.fold(0.0, f64::max);
            assert!(frames.is_some() || turned < 0.11, "{key}: {turned}");
            before = Some(angles);
        }
        let end = f64::from(*times.last().unwrap());
        assert!((end - path.knots.last().unwrap().time).abs() < 1e-5);
    }
}

/// Plates are closed solids that keep their volume in every shape.
#[test]
fn a_glb_of_plates_has_their_volume() {
    let folder = folder_with_path();
    folder.done("plan miura.fold --thickness 0.1 -o plates.fold");
    folder.done("export plates.fold --to glb -o a.glb --frames 5");
    let path = read_motion(&folder.path("plates.fold")).unwrap();
    let options = path.plates.unwrap();
    let plates = Plates::new(&path.pattern, &Trims::of(&path, &options), &options).unwrap();
    let volumes = (0..plates.list.len()).map(|plate| plates.mesh(plate).volume());
    let expected: f64 = volumes.sum();

    let bytes = fs::read(folder.path("a.glb")).unwrap();
    let glb = gltf::Gltf::from_slice(&bytes).unwrap();
    let data = glb.blob.as_deref().unwrap();
    let mesh = glb.meshes().next().unwrap();
    let primitives: Vec<_> = mesh.primitives().collect();
    let modes: Vec<Mode> = primitives.iter().map(gltf::Primitive::mode).collect();
    assert_eq!(modes, [Mode::Triangles, Mode::Lines]);
    let reader = primitives[0].reader(|_| Some(data));
    let corners: Vec<u32> = reader.read_indices().unwrap().into_u32().collect();
    let places = |positions: &mut dyn Iterator<Item = [f32; 3]>| -> Vec<Vector3<f64>> {
        positions.map(|p| Vector3::from(p.map(f64::from))).collect()
    };
    let base = places(&mut reader.read_positions().unwrap());
    let mut shapes = vec![base.clone()];
    for (moves, ..) in reader.read_morph_targets() {
        let moves = places(&mut moves.unwrap());
        shapes.push(base.iter().zip(moves).map(|(at, way)| at + way).collect());
    }
    assert_eq!(shapes.len(), 5);
    for shape in shapes {
        let corner = |k: u32| shape[k as usize];
        let triangles = corners
            .chunks(3)
            .map(|t| [corner(t[0]), corner(t[1]), corner(t[2])]);
        let volume: f64 = triangles.map(|[a, b, c]| a.cross(&b).dot(&c) / 6.0).sum();
        assert!(
            (volume - expected).abs() < 1e-5 * expected,
            "{volume} {expected}"
        );
    }
}

/// A drawing by letters has all data of the pattern. Read back, it has the same edges, letters, goal angles and crease
/// groups, and is larger by a round factor.
#[test]
fn a_drawing_by_letters_is_read_back_as_the_pattern() {
    let folder = folder_with_path();
    let named = |name: &str| format!("{PATTERNS}/{name}.fold");
    for file in [
        folder.path("path.fold").display().to_string(),
        folder.path("miura.fold").display().to_string(),
        named("waterbomb-4x6"),
        named("yoshimura-12x12"),
        named("square-twist-3x3"),
        named("resch-3x3"),
        named("kresling-2x6"),
    ] {
        folder.done(&format!("export {file} --to svg -o a.svg"));
        let pattern = read_pattern(file.as_ref()).unwrap().pattern;
        let drawn = read_any(&folder.path("a.svg")).unwrap().pattern;
        assert_eq!(drawn.repairs(), [""; 0], "{file}");
        assert_eq!(drawn.edges().len(), pattern.edges().len(), "{file}");
        assert_eq!(drawn.faces().len(), pattern.faces().len(), "{file}");
        let scale = drawn.median_edge() / pattern.median_edge();
        let digits = scale / 10_f64.powf(scale.log10().floor());
        assert!(
            [1.0, 2.0, 5.0, 10.0]
                .iter()
                .any(|d| (digits - d).abs() < 1e-4),
            "{file}: {scale}"
        );
        let corner = |p: &foldpath::pattern::CreasePattern| {
            p.vertices()
                .iter()
                .copied()
                .reduce(|a, b| a.inf(&b))
                .unwrap()
        };
        let (from, to) = (corner(&pattern), corner(&drawn));
        for edge in pattern.edges() {
            let middle = |p: &foldpath::pattern::CreasePattern, e: &foldpath::pattern::Edge| {
                let [a, b] = e.ends.map(|end| p.vertices()[end.index()]);
                0.5 * (a + b)
            };
            let place = (middle(&pattern, edge) - from) * scale;
            let twin = drawn
                .edges()
                .iter()
                .find(|e| (middle(&drawn, e) - to - place).norm() < 0.01);
            let twin = twin.unwrap_or_else(|| panic!("{file}: {edge:?}"));
            let letter = match edge.letter {
                Letter::Join => Letter::Flat,
                letter => letter,
            };
            assert_eq!(twin.letter, letter, "{file}");
            let goal = |goal: Option<f64>| goal.filter(|_| letter.sign().abs() > 0.0);
            match (goal(edge.goal), goal(twin.goal)) {
                (Some(a), Some(b)) => assert!((a - b).abs() < 1e-6, "{file}: {a}, {b}"),
                (a, b) => assert_eq!(a, b, "{file}"),
            }
        }
    }
}

/// A crease that stays flat at the goal is drawn too, although it is invisible.
#[test]
fn a_drawing_keeps_creases_of_angle_0_and_is_opaque_without_angles() {
    let folder = folder();
    let square = |angles: &str| {
        format!(
            r#"{{"vertices_coords":[[1e6,0],[1000001,0],[1000001,1],[1e6,1]],
            "edges_vertices":[[0,1],[1,2],[2,3],[3,0],[0,2]],
            "edges_assignment":["B","B","B","B","M"]{angles}}}"#
        )
    };
    folder.write("letters.fold", &square(""));
    folder.done("export letters.fold --to svg -o a.svg");
    assert!(!folder.read("a.svg").contains("opacity"));
    let two = r#"{"vertices_coords":[[0,0],[1,0],[2,0],[2,1],[1,1],[0,1]],
        "edges_vertices":[[0,1],[1,2],[2,3],[3,4],[4,5],[5,0],[1,4],[0,4]],
        "edges_assignment":["B","B","B","B","B","B","V","M"],
        "edges_foldAngle":[0,0,0,0,0,0,90,0]}"#;
    folder.write("two.fold", two);
    folder.done("export two.fold --to svg -o b.svg");
    let drawn = read_any(&folder.path("b.svg")).unwrap().pattern;
    let mut goals: Vec<_> = drawn
        .creases()
        .iter()
        .map(|&e| drawn.edge(e).goal.unwrap())
        .collect();
    goals.sort_by(f64::total_cmp);
    let quarter = core::f64::consts::FRAC_PI_2;
    assert!(
        goals[0].abs() <= 0.0 && (goals[1] - quarter).abs() < 1e-6,
        "{goals:?}"
    );
}

#[test]
fn drawings_by_groups_and_by_deformation_say_what_they_show() {
    let folder = folder_with_path();
    let said = |arguments: &str| {
        folder
            .done(&format!("export {arguments} --to svg -o a.svg"))
            .stdout
    };
    assert!(said("path.fold --colour groups").contains("2 crease groups of the path"));
    let text = folder.read("a.svg");
    // Twelve creases have two colours; half of each group turn against the group. There are twelve borders.
    assert_eq!(text.matches("<path d=\"M").count(), 12 + 12 + 2);
    assert_eq!(text.matches("stroke=\"#999999\"").count(), 12);
    assert!(text.contains(">      0: 0.0 to 162.0<"), "{text}");
    assert!(said("miura.fold --colour groups").contains("2 crease groups of the pattern"));
    assert!(folder.read("a.svg").contains(": 0.0 to 162.0<"));

    // At one knot one corner is moved by a hundredth. The face of this corner is bright, all other faces are dark.
    let mut torn = folder.read_json("path.fold");
    let last = torn["file_frames"].as_array().unwrap().len() - 1;
    let corner = &mut torn["file_frames"][last]["vertices_coords"][0];
    *corner = serde_json::json!([corner[0].as_f64().unwrap() + 0.01, corner[1], corner[2]]);
    folder.write("torn.fold", &torn.to_string());
    assert!(said("torn.fold --colour deformation").contains("9 faces by deformation"));
    let text = folder.read("a.svg");
    let [dark, bright] = ["#440154", "#fde725"].map(|colour| {
        let areas = text.lines().filter(|line| line.starts_with("<polygon"));
        areas.filter(|line| line.contains(colour)).count()
    });
    assert_eq!((dark, bright), (8, 1), "{text}");
}

#[test]
fn titles_break_no_drawing_and_no_comment() {
    let folder = folder_with_path();
    let mut path = folder.read_json("path.fold");
    path["file_title"] = "</title><script>&\u{1}\nv 1 2 3".into();
    folder.write("a.fold", &path.to_string());
    folder.done("export a.fold --to svg -o a.svg");
    assert!(
        folder
            .read("a.svg")
            .contains("<title>&lt;/title&gt;&lt;script&gt;&amp;  v 1 2 3</title>")
    );
    read_any(&folder.path("a.svg")).unwrap();
    folder.done("export a.fold --to obj -o a.obj");
    assert_eq!(obj(&folder.read("a-0000.obj")).0.len(), 16);
}

#[test]
fn what_cannot_be_exported_is_refused_and_nothing_written() {
    let folder = folder_with_path();
    let mut far = folder.read_json("path.fold");
    far["file_frames"][1]["vertices_coords"][3][0] = 1e39.into();
    folder.write("far.fold", &far.to_string());
    folder.write("plain", "");
    let before = folder.names();
    for (arguments, expected) in [
        (
            "path.fold --to csv -o a --frames 9",
            "--frames: expected --to obj or --to glb, found --to csv",
        ),
        (
            "path.fold --to glb -o a --colour groups",
            "--colour: expected --to svg, found --to glb",
        ),
        (
            "far.fold --to glb -o a",
            "far.fold: vertices_coords[3]: expected coordinates that single precision holds, for \
             .glb, found larger ones",
        ),
        (
            "miura.fold --to svg --colour deformation -o a",
            "miura.fold: file_frames: expected at least one knot (of a path; `foldpath plan` makes \
             one of a crease pattern), found none",
        ),
        (
            "path.fold --to obj -o none/a.obj",
            "none/a-0000.obj: entity not found",
        ),
        (
            "path.fold --to obj -o plain/",
            "plain/: File exists (os error 17)",
        ),
    ] {
        let answer = folder.run(&format!("export {arguments}")).with_status(2);
        assert!(answer.tells(expected), "{}", answer.stderr);
        assert_eq!(folder.names(), before, "{arguments}");
    }
    let answer = folder
        .run("export path.fold --to glb -o a --frames 1")
        .with_status(2);
    assert!(
        answer.tells("--frames: expected a number of frames from 2 to 2000, found 1"),
        "{}",
        answer.stderr
    );
    fs::rename(folder.path("path.fold"), folder.path("a-0001.obj")).unwrap();
    let answer = folder
        .run("export a-0001.obj --to obj -o a.obj")
        .with_status(2);
    let expected = "-o: a-0001.obj is an input file, expected another";
    assert!(answer.tells(expected), "{}", answer.stderr);
}

/// The numbers in a drawing are those of `info --edges` and `--crease`. They are no lines when the drawing is read again.
#[test]
fn drawings_show_the_numbers_of_edges() {
    let folder = folder();
    folder.write(
        "a.cp",
        "1 0 0 2 0\n1 2 0 2 1\n1 2 1 0 1\n1 0 1 0 0\n2 1 0 1 1\n",
    );
    folder.done("export a.cp --to svg --numbers -o a.svg");
    folder.done("view a.cp -o a.html");
    let edges = folder.done("info a.cp --json").json()["edges"]
        .as_u64()
        .unwrap();
    for name in ["a.svg", "a.html"] {
        let text = folder.read(name);
        for edge in 0..edges {
            assert!(text.contains(&format!(">{edge}</text>")), "{name}: {edge}");
        }
        assert!(!text.contains(&format!(">{edges}</text>")), "{name}");
    }
    let again = folder.done("info a.svg --json").json();
    assert_eq!(again["edges"].as_u64(), Some(edges));
    let refused = folder
        .run("export a.cp --to csv --numbers -o a.csv")
        .with_status(2);
    assert!(
        refused.tells("--numbers: expected --to svg, found --to csv"),
        "{}",
        refused.stderr
    );
    folder.write("b.cp", "1 0 0 x 0\n");
    folder.run("view b.cp -o b.html").with_status(2);
}
