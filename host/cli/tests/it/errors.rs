//! Compares every error with a snapshot of its text: the message, the line of the file, the hint. `INSTA_UPDATE=always`
//! accepts new texts.

use std::fs::{self, File};
use std::path::{Path, PathBuf};

use crate::common::{folder, folder_with_path, pattern};
use foldpath::generate::Kresling;
use foldpath::pattern::PatternError;
use foldpath::planner::{GoalError, PlanOptions};
use foldpath::read::FileError;
use foldpath::request::{PlanRequest, Request};
use foldpath::stream::BenchError;
use foldpath::unfold::ShapeError;
use foldpath_core::follower::Denial;
use foldpath_core::trajectory::TrajectoryError;
use foldpath_core::trajectory_file;
use foldpath_test_support::{Folder, edited};

/// Returns the text with which a command is refused.
fn refused(folder: &Folder, arguments: &str) -> String {
    let answer = folder.run(arguments).with_status(2);
    assert_eq!(answer.stdout, "", "{arguments}");
    format!("$ foldpath {arguments}\n{}\n", answer.stderr.trim_end())
}

/// Returns the texts with which commands are refused; each line of `commands` is one command.
fn all_refused(folder: &Folder, commands: &str) -> String {
    let commands = commands
        .lines()
        .map(str::trim)
        .filter(|line| !line.is_empty());
    commands
        .map(|command| refused(folder, command) + "\n")
        .collect()
}

#[test]
fn usage() {
    let folder = folder_with_path();
    folder.done("export path.fold --to traj -o path.traj");
    folder.write("goal.fold", &folder.read("miura.fold"));
    folder.write("events.txt", "0 supply 1\n");
    folder.write("designs.jsonl", "");
    folder.write(
        "drives.csv",
        "name,torque,speed\nservo,0.1,60\nmotor,0,60\n",
    );
    for name in ["sheet.svg", "sheet.cp", "shape.obj"] {
        folder.write(name, "");
    }
    let said = all_refused(
        &folder,
        "
        paln miura.fold
        plan
        plan miura.fold --symetry off
        plan miura.fold --symmetry some
        plan miura.fold --fold 0.5 --crease 4=90
        plan miura.fold --crease 4
        plan miura.fold --crease 0=90
        plan miura.fold --crease 99=90
        plan miura.fold --crease 4=-190
        plan miura.fold --crease 4=-90 --crease 4=-80
        plan miura.fold --order 4=90,3-1
        plan miura.fold --order lid
        plan miura.fold --jobs 0
        check path.fold --jobs some
        plan miura.fold --limit 4=-20
        plan miura.fold --limit 4=10..20
        plan miura.fold --limit 1=-20..20
        plan miura.fold --fold 2
        plan miura.fold --fold=-0.5
        plan miura.fold --bound 0
        plan miura.fold --bound 2
        plan miura.fold --bend 200
        plan miura.fold --bend=-1
        plan sheet.svg --tolerance 0
        plan sheet.svg --tolerance=-1
        info sheet.svg --tolerance inf
        info sheet.svg --tolerance wide
        info sheet.svg --colors red
        info sheet.svg --colors red=V,rod=M
        info sheet.svg --colors red=V,blue=X
        info sheet.svg --colors red=V,#f00=M
        info path.fold --tolerance 0.1
        info shape.obj --tolerance 0.1
        info sheet.cp --straighten maybe
        info sheet.cp --colors red=V
        export path.fold --to csv --tolerance 0.1 -o a.csv
        export path.fold --to svg --colors red=V --colour deformation -o a.svg
        plan miura.fold --thickness 0
        plan miura.fold --thickness thin
        plan miura.fold --thickness 0.1 --gap 0.1
        plan miura.fold --thickness 0.1 --panels round
        plan miura.fold --thickness 0.1 --hinge-plane side
        plan miura.fold --thickness 0.1 --margin 45
        plan miura.fold --thickness 0.1 --fold 1
        export path.fold --to stl -o panels
        export path.fold --to csv --kerf 0.1 -o a.csv
        export path.fold --to dxf --kerf 0.1 -o a.dxf
        plan miura.fold --max-speed 0
        plan miura.fold --max-speed=-1
        plan miura.fold --max-accel 0
        plan miura.fold --max-accel=-1
        plan miura.fold --max-accel inf
        plan miura.fold --timeout=-1
        check path.fold --timeout=-1
        plan miura.fold --timeout NaN
        plan miura.fold --fold NaN
        plan miura.fold --bound inf
        plan miura.fold --max-speed NaN
        check path.fold --bound NaN
        generate miura --rows 3 --cols 3 --angle NaN -o a.fold
        plan miura.fold --via miura.fold --search random
        plan miura.fold -o miura.fold
        plan miura.fold --goal goal.fold -o goal.fold
        plan miura.fold --via miura.fold --via goal.fold -o ./goal.fold
        plan miura.fold -o nowhere/path.fold
        plan nowhere/miura.fold
        generate miura --rows 3
        generate miura --rows 0 --cols 3 -o a.fold
        generate miura --rows 3 --cols 3 --angle 90 -o a.fold
        generate kresling --cols 7 -o a.fold
        check path.fold --bound 0
        check path.fold --bound 2
        tolerance path.fold
        tolerance path.fold --error 0
        tolerance path.fold --error NaN
        tolerance path.fold --error 1 --play 1
        tolerance path.fold --play=-1
        loads path.fold
        loads path.fold --areal-density 1
        loads path.fold --areal-density=-1
        loads path.fold --areal-density 1 --unit mm --gravity 0,1
        loads path.fold --areal-density 1 --unit mm --gravity 0,1,inf
        loads path.fold --areal-density 1 --unit mm --fixed 99
        loads path.fold --areal-density 1 --unit mm --fixed=-1
        loads path.fold --areal-density 1 --unit mm --spring stiff
        loads path.fold --areal-density 1 --unit mm --spring x=1
        loads path.fold --areal-density 1 --unit mm --spring 0=1
        loads path.fold --areal-density 1 --unit mm --timeout -1
        loads path.fold --areal-density 1 --unit mm --drivers 0
        loads path.fold --areal-density 1 --unit mm --tolerance 0.1
        loads path.fold --areal-density 1 --unit mm --drives nowhere.csv
        loads path.fold --areal-density 1 --unit mm --drives drives.csv
        loads path.fold --areal-density 1 --unit mm --drives designs.jsonl
        view path.fold
        view path.fold -o a.html --error 1 --play 1
        view path.fold -o a.html --error 0
        view path.fold -o a.html --areal-density 1
        view path.fold -o a.html --spring 1
        view path.fold -o a.html --layers CUT=C
        view miura.fold -o a.html --error 1
        plot path.fold -o a.svg --dashes V
        plan - --goal -
        plan - --via - --via -
        stream - --to sim --sheet -
        export path.fold --to obj -o -
        export path.fold --to mjcf -o -
        export path.fold --to mjcf -o miura.fold
        export path.fold --to traj --rate 50 -o a.traj
        export path.fold --to csv --rate 0 -o a.csv
        export path.fold --to csv --bound 0.01 -o a.csv
        export path.fold --to traj --bound 0 -o a.traj
        export path.fold --to traj --bound 0.01 --brake 0 -o a.traj
        export path.fold --to traj --bound 0.01 --resolution 0.5 -o a.traj
        export path.fold --to csv --rate 1e12 -o a.csv
        export path.fold --to csv --per group -o a.csv
        batch designs.jsonl
        batch designs.jsonl -o ./designs.jsonl
        batch nowhere.jsonl -o results.jsonl
        batch designs.jsonl -o nowhere/results.jsonl
        batch designs.jsonl -o results.jsonl --shard 3/3
        batch designs.jsonl -o results.jsonl --jobs 0
        batch designs.jsonl -o results.jsonl --timeout 0
        batch designs.jsonl -o - --resume
        batch designs.jsonl -o - --retry-errors
        export path.fold --to dwg -o a.dwg
        stream path.traj --to sim --log path.traj
        stream path.traj --to sim --sheet path.fold --log path.fold
        stream path.traj --to sim --script events.txt --log events.txt
        stream path.traj --to sim --key events.txt --log events.txt
        stream path.traj --to sim --insecure
        stream path.traj --to usb
        stream path.traj --to tcp:1
        stream path.traj --to tcp:1 --insecure --key lab.key
        stream path.traj --to sim --key nowhere.key
        stream path.traj --to sim --key events.txt
        stream - --to sim --key -
        stream path.traj --to sim --at goal
        stream path.traj --to sim --at flat --reverse
        stream path.traj --to sim --at here
        drive
        drive --to sim jgo 3
        drive --to sim watch three
        drive --to sim jog 3 at 5
        drive --to sim jog 3 to up
        drive --to sim jog 3 by 5 from
        drive --to sim channel 3 70000
        drive --to sim sign 3 up
        drive --to sim limits 3 10 5
        drive --to sim --map - show
        drive --to sim --map map.csv --rust - show
        drive --to sim --map events.txt show
        drive --to sim --key -
        drive --to tcp:1 watch 3
        pair --to tcp:1 --key lab.key
        pair --to qemu --key lab.key
        pair --to sim --key -
        pair --to sim --key events.txt
        pair --to sim --key nowhere/lab.key
        stream path.traj --to tcp:localhost
        stream path.traj --to tcp:99999
        stream path.traj --to tcp:0
        stream path.traj --to tcp::80
        stream path.traj --to tcp:::1
        stream path.traj --to tcp:localhost:port
        stream path.traj --to qemu --image nowhere
        stream path.traj --to qemu --image .
        stream path.traj --to sim --faults drop=2
        stream path.traj --to sim --faults lose=0.1
        stream path.traj --to sim --faults seed=x
        stream path.traj --to sim --drives lag
        stream path.traj --to sim --drives mass=1
        stream path.traj --to sim --drives lag=-1
        stream path.traj --to tcp:1 --drives lag=1
        completions tcsh
        ",
    );
    insta::assert_snapshot!(said);
}

#[test]
#[cfg(target_os = "linux")]
fn stdout_that_is_full() {
    let folder = folder_with_path();
    let full = File::options().write(true).open("/dev/full").unwrap();
    let answer = folder
        .command("info miura.fold")
        .stdout(full)
        .output()
        .unwrap();
    assert_eq!(answer.status.code(), Some(2));
    insta::assert_snapshot!(String::from_utf8(answer.stderr).unwrap());
}

/// Errors in files of several lines, as people write them.
#[test]
fn lines_of_files() {
    let folder = folder_with_path();
    let sheet = "{\n  \"vertices_coords\": [[0,0],[1,0],[1,1],[0,1]],\n  \"edges_vertices\": [\n    [0,1],[1,2],\n    \
                 [2,3],[3,0], [3,12]\n  ],\n  \"edges_assignment\": [\"B\",\"B\",\"B\",\"B\",\"V\"]\n}\n";
    let changed = |from: &str, to: &str| {
        assert!(sheet.contains(from));
        sheet.replace(from, to)
    };
    let drawing = |element: &str| {
        format!(
            "<svg xmlns=\"http://www.w3.org/2000/svg\">\n<g stroke='red'>{element}</g>\n</svg>\n"
        )
    };
    let opx = |properties: &str| {
        format!(
            "<array class=\"oripa.OriLineProxy\">\n<void index=\"0\">\n<object class=\"oripa.OriLineProxy\">\n\
             {properties}</object></void></array>\n"
        )
    };
    let wide = format!(
        "{{\"ä\": \"{}\", \"vertices_coords\": [[0,0], [1, \"ö\"]], {}",
        "é".repeat(90),
        &sheet[1..].replace('\n', " ")
    );
    let files = [
        ("vertex.fold", sheet.into()),
        ("letter.fold", changed("\"V\"", "5")),
        ("count.fold", changed(",\"V\"", "")),
        ("syntax.fold", changed("[1,2],\n", "[1,2],]\n")),
        ("cut-off.fold", sheet[..70].into()),
        ("empty.fold", String::new()),
        ("list.fold", "[1, 2]".into()),
        ("windows.fold", sheet.replace('\n', "\r\n")),
        ("wide.fold", wide.replace("\"vertices_coords\": [[0,0],[1,0],[1,1],[0,1]], ", "")),
        ("control.fold", changed("[3,12]", "[3,\"\u{1b}[31m\t\"]")),
        ("fields.cp", "1 0 0 4 0\n\n2 1 2 3\n".into()),
        ("number.cp", "1 0 0 4 0\n2 0 x 1 1\n".into()),
        ("type.cp", "1 0 0 4 0\nx 0 0 1 1\n".into()),
        ("broken.svg", "<svg xmlns=\"http://www.w3.org/2000/svg\">\n  <path d=\"M0 0\"\n</svg>\n".into()),
        ("page.svg", "<html>\n</html>\n".into()),
        (
            "curve.svg",
            "<svg xmlns=\"http://www.w3.org/2000/svg\">\n  <circle id=\"hole\" r=\"3\" stroke=\"red\"/>\n</svg>\n".into(),
        ),
        ("word.svg", drawing("<line x1='fifty' y1='0' x2='50'/>")),
        ("long.svg", drawing("<line\n  x2='1e308' y1='7'/>")),
        ("longer.svg", drawing("<rect width='1e400' height='1'/>")),
        ("points.svg", drawing("<polyline points='0,0 1e1,0\n  5,x'/>")),
        ("wide-points.svg", drawing("<polygon points='0,0 1,0 1,-1e31'/>")),
        ("path.svg", drawing("<path d='M0 0l1-2h1f'/>")),
        ("short-path.svg", drawing("<path d='M0 0L1&#32;'/>")),
        ("arc.svg", drawing("<path d='M0 0A9e99 1 0 0 1 2 3'/>")),
        ("wide-path.svg", drawing("<path d='m0 0h9e29h9e29'/>")),
        ("far.cp", "1 0 0 1e51 0\n".into()),
        ("broken.opx", "<java>\n  <object\n</java>\n".into()),
        ("empty.opx", "<java>\n<object class=\"oripa.DataSet\"/>\n</java>\n".into()),
        ("number.opx", opx("<void property=\"x0\">\n<double>1,5</double>\n</void>")),
        ("type.opx", opx("<void property=\"type\"><int>M</int></void>")),
        ("other.opx", "<array class=\"oripa.OriLineProxy\">\n<void index=\"0\">\n<null/></void></array>".into()),
    ];
    let mut said = String::new();
    for (name, text) in files {
        folder.write(name, &text);
        said += &(refused(&folder, &format!("info {name}")) + "\n");
    }
    fs::write(folder.path("bytes.cp"), b"1 0 0\xff").unwrap();
    said += &refused(&folder, "info bytes.cp");
    insta::assert_snapshot!(said);
}

#[test]
fn wrong_files() {
    let folder = folder_with_path();
    folder.done("export path.fold --to traj -o path.traj");
    let svg = "<svg xmlns=\"http://www.w3.org/2000/svg\"/>";
    folder.write("drawing.xml", svg);
    folder.write("drawing.txt", "1 0 0 4 0\n");
    folder.write("shape.obj.txt", "# a shape\nv 0 0 0\n");
    folder.write("notes.txt", "fold me\n");
    for name in ["shape.stl", "shape.txt"] {
        folder.write(name, "solid shape\nendsolid shape\n");
    }
    // Neither is text.
    for name in ["photo.jpg", "photo.svg"] {
        std::fs::write(folder.path(name), b"\x89PNG\r\n\x1a\n").unwrap();
    }
    folder.write("part.step", "ISO-10303-21;\n");
    folder.write("events.txt", "0 supply 1\n1 stick 12\n");
    folder.done("generate miura --rows 2 --cols 4 -o other.fold");
    folder.done("plan other.fold -o other-path.fold");
    let said = all_refused(
        &folder,
        "
        info missing.fold
        plan .
        plan path.traj
        check miura.fold
        plot miura.fold -o a.svg
        export miura.fold --to traj -o a.traj
        stream path.fold --to sim
        stream drawing.xml --to sim
        info drawing.xml
        info drawing.txt
        info shape.obj.txt
        info notes.txt
        plan shape.stl
        info shape.txt
        info photo.jpg
        info photo.svg
        plan part.step
        plan miura.fold --goal missing.fold
        plan miura.fold --goal other.fold
        stream path.traj --to sim --script events.txt
        stream path.traj --to sim --sheet other-path.fold
        stream path.traj --to sim --sheet miura.fold
        ",
    );
    insta::assert_snapshot!(said);
}

/// Errors of drawings that are no crease pattern, and of goals that are no goal, in a file of one long line.
#[test]
fn patterns_and_goals() {
    let folder = folder();
    let document = pattern();
    let edges = document["edges_vertices"].as_array().unwrap().len();
    let mut nearly = vec![0.0; edges];
    nearly[2] = 1e-12;
    let nearly = format!("/edges_foldAngle = {nearly:?}");
    let free = format!(
        "/edges_foldAngle = ; /edges_assignment = {:?}",
        vec!["U"; edges]
    );
    let mut said = String::new();
    for edits in [
        "/vertices_coords = []",
        "/edges_vertices/3/0 = 99",
        "/edges_vertices/3 = [2,2]",
        "/edges_vertices/3 = [1,0]",
        "/edges_vertices/3 = [0,6]",
        "/edges_vertices/3 = [0,2]",
        "/vertices_coords/5 = [1.5,0.866,0.1]",
        "/vertices_coords/5 = [1.5]",
        "/vertices_coords/5/0 = 1e60",
        "/edges_vertices = ; /faces_vertices =",
        "/edges_foldAngle/2 = 200",
        "/edges_foldAngle/2 = -10",
        "/edges_foldAngle = [0,0,null]",
        "/edges_foldAngle = []",
        "/file_frames = [{\"frame_classes\":[\"foldedForm\"],\"edges_foldAngle\":[0,0]}]; /edges_foldAngle =",
        "/file_frames = [{\"frame_classes\":[\"foldedForm\"],\"edges_foldAngle\":[1,2]}]",
        "/file_frames = [{\"frame_inherit\":true}]",
        "/file_frames = [{\"frame_inherit\":true,\"frame_parent\":2}]",
        "/file_frames = [{\"frame_inherit\":true,\"frame_parent\":1}]",
        "/file_frames = [{\"frame_inherit\":true,\"frame_parent\":3},{},{\"frame_inherit\":true,\"frame_parent\":4},\
         {\"frame_inherit\":true,\"frame_parent\":3}]",
        "/faces_vertices/0/0 = 44",
        "/faces_vertices/0 = [4,0,2,5]",
        "/faces_vertices/0 = [4,0]",
        "/faces_vertices/9 = [4,0,1,5]",
        "/faces_vertices = [[4,0,1,2,6,5]]",
        "/faces_vertices = ; /edges_foldAngle = ; /vertices_coords/16 = [0.7,0.4]; /edges_vertices/24 = [0,16]; \
         /edges_assignment/24 = \"V\"",
        "/faces_vertices = ; /edges_foldAngle = ; /vertices_coords/16 = [0.6,0.3]; /vertices_coords/17 = [0.8,0.3]; \
         /vertices_coords/18 = [0.7,0.5]; /edges_vertices/24 = [16,17]; /edges_vertices/25 = [17,18]; \
         /edges_vertices/26 = [18,16]; /edges_vertices/27 = [0,16]; /edges_assignment/24 = \"V\"; \
         /edges_assignment/25 = \"V\"; /edges_assignment/26 = \"V\"; /edges_assignment/27 = \"M\"",
        &nearly,
        &free,
    ] {
        folder.write("bad.fold", &edited(&document, edits).to_string());
        let shown: String = edits.chars().take(80).collect();
        said += &format!("# {shown}\n{}\n", refused(&folder, "plan bad.fold"));
    }
    insta::assert_snapshot!(said);
}

/// Errors of paths.
#[test]
fn paths() {
    let folder = folder_with_path();
    let document = folder.read_json("path.fold");
    let mut said = String::new();
    for edits in [
        "/file_frames/3/edges_foldAngle =",
        "/file_frames/3/edges_foldAngle/2 = null",
        "/file_frames/2/foldpath:time = 5; /file_frames/3/foldpath:time = 5",
        "/foldpath:interpolation = \"spline\"",
        "/foldpath:edges_group/2 = 24",
        "/foldpath:edges_sign/2 = 7",
        "/foldpath:maxSpeed = 0",
    ] {
        folder.write("bad.fold", &edited(&document, edits).to_string());
        said += &format!("# {edits}\n{}\n", refused(&folder, "check bad.fold"));
    }
    for edits in [
        "/foldpath:maxSpeed = 1",
        "/foldpath:edges_group/2 = null",
        "/file_frames/1/edges_foldAngle/2 = 1",
    ] {
        folder.write("bad.fold", &edited(&document, edits).to_string());
        said += &format!(
            "# {edits}\n{}\n",
            refused(&folder, "export bad.fold --to traj -o a.traj")
        );
    }
    insta::assert_snapshot!(said);
}

/// Errors of the libraries that no file causes, or that need bytes changed together with their checksum.
#[test]
fn errors_of_the_libraries() {
    use trajectory_file::FileError as Traj;
    let pattern = PatternError::NotFinite { vertex: 3 };
    let options = PlanOptions::default().with(|it| it.bound = -1.0);
    let options = options.validate().unwrap_err();
    let io = FileError::Io {
        path: PathBuf::from("a.fold"),
        source: std::io::ErrorKind::StorageFull.into(),
    };
    let mut said = format!("{pattern}\n{options}\n{io}\n{}\n", GoalError::Fraction(2.0));
    let parameter = Kresling {
        rows: 1,
        columns: 5,
    }
    .drawing()
    .unwrap_err();
    let unknown = PlanRequest::default().set("boud", &1.into()).unwrap_err();
    let line = BenchError::Line(std::io::ErrorKind::BrokenPipe.into());
    let denied = BenchError::Denied {
        denial: Denial::Moving,
        state: None,
        hinges: 0,
    };
    let request = PlanRequest {
        fold: Some(0.5),
        goal: Some("a.fold".into()),
        ..PlanRequest::default()
    };
    let excluded = request.options().unwrap_err();
    said += &format!("{parameter}\n{unknown}\n{excluded}\n{line}\n{denied}\n");
    let crowded = PatternError::Crowded { edge: 3 };
    let corners = PatternError::Corners {
        face: 2,
        corners: 70_000,
    };
    let shape = FileError::Shape {
        path: PathBuf::from("a.obj"),
        source: ShapeError::NoFaces,
    };
    said += &format!("{crowded}\n{corners}\n{shape}\n");
    for error in [
        ShapeError::NoFaces,
        ShapeError::NotFinite { vertex: 3 },
        ShapeError::NoVertex {
            what: "face",
            index: 2,
            vertex: 9,
            last: 7,
        },
        ShapeError::NoArea { face: 2 },
        ShapeError::NotSimple {
            face: 5,
            why: "its sides cross".into(),
        },
        ShapeError::NotFlat {
            face: 2,
            vertex: 3,
            off: 0.25,
            slope: 0.1,
        },
        ShapeError::Branching {
            ends: [1, 2],
            faces: [0, 3, 5],
        },
        ShapeError::OneSided {
            first: 1,
            second: 2,
        },
        ShapeError::NoLength { ends: [1, 2] },
        ShapeError::Pattern("vertex 3: expected finite coordinates".into()),
    ] {
        said += &format!("{error}\n");
    }
    let knots = [
        TrajectoryError::Width(3),
        TrajectoryError::Order(3),
        TrajectoryError::NotFinite(3),
        TrajectoryError::HalfTurn(3),
        TrajectoryError::Weight(3),
    ];
    let others = [
        Traj::Magic,
        Traj::Version(9),
        Traj::Truncated(70),
        Traj::Trailing(70),
        Traj::Number(70),
        Traj::Interpolation(9),
        Traj::Groups,
        Traj::Checksum,
        Traj::Limits(1),
        Traj::Hinge(4),
        Traj::Spoke(5),
        Traj::Closure,
        Traj::Angle { knot: 3, group: 1 },
    ];
    for source in others.into_iter().chain(knots.map(Traj::Knot)) {
        let path = PathBuf::from("a.traj");
        said += &format!("{}\n", FileError::Trajectory { path, source });
    }
    insta::assert_snapshot!(said);
}

#[test]
fn cancelled_calls_of_the_library() {
    let path = PathBuf::from("a.fold");
    let errors: [&dyn core::error::Error; 3] = [
        &FileError::Cancelled { path },
        &PatternError::Cancelled,
        &ShapeError::Cancelled,
    ];
    let said: String = errors.iter().map(|error| format!("{error}\n")).collect();
    insta::assert_snapshot!(said);
}

/// Returns the variants of errors in a source text, each with the format of its `#[error("...")]`.
fn formats(source: &str) -> Vec<(String, String)> {
    let attributes = source.split("#[error(").skip(1);
    attributes
        .filter_map(|text| {
            let text = text.trim_start().strip_prefix('"')?;
            let (format, rest) = text.split_once('"')?;
            let after = rest.split_once(")]").map_or(rest, |(_, after)| after);
            let name = after
                .trim_start()
                .trim_start_matches("pub ")
                .trim_start_matches("struct ");
            let name: String = name.chars().take_while(|c| c.is_alphanumeric()).collect();
            let lines = format.split("\\\n").map(str::trim_start);
            Some((name, lines.collect()))
        })
        .collect()
}

/// Returns the words of a format between its values.
fn words(format: &str) -> Vec<&str> {
    let parts = format.split(['{', '}']).step_by(2).map(str::trim);
    parts.filter(|part| part.len() > 2).collect()
}

/// Returns `true` if a line of the snapshots has all the words in this order.
fn is_told(snapshots: &str, words: &[&str]) -> bool {
    snapshots.lines().any(|line| {
        let mut rest = Some(line);
        for word in words {
            rest = rest.and_then(|rest| Some(rest.split_once(word)?.1));
        }
        rest.is_some()
    })
}

/// Adds the texts of all source files in a folder.
fn sources(folder: &Path, found: &mut Vec<String>) {
    for entry in fs::read_dir(folder).unwrap() {
        let path = entry.unwrap().path();
        if path.is_dir() {
            sources(&path, found);
        } else if path.extension().is_some_and(|ending| ending == "rs") {
            found.push(fs::read_to_string(&path).unwrap());
        }
    }
}

/// Errors whose format has no words of its own, each with a part of its text in some snapshot.
const WORDLESS: [(&str, &str); 17] = [
    ("NoMotion", "at 0.000 s, the configuration does not close"),
    ("Open", "at 1.500 s, the configuration does not close"),
    ("PlatesNotMade", "plates turn by at most 170"),
    ("Io", "missing.fold: No such file or directory"),
    ("Expected", "expected a string, found 5"),
    ("Trajectory", "a.traj: byte 0: expected the magic number"),
    ("Piped", "foldpath: <stdin>:1:12: expected a FOLD file"),
    (
        "Pattern",
        "edges_vertices[3]: joins the same vertices as edge",
    ),
    ("Shape", "a.obj: the shape: expected at least one face"),
    ("Goal", "bad.fold: edges_assignment: no crease is lettered"),
    ("Usage", "-o: miura.fold is an input file"),
    (
        "Option",
        "foldpath: --limit: expected MIN..MAX within -180..180 degrees",
    ),
    ("Request", "expected a hinge between two faces"),
    ("OptionsError", "bound: expected a fraction above 0"),
    ("ParameterError", "cols: expected an even number of sides"),
    ("Line", "the line: broken pipe"),
    ("Denied", "the sheet still moves"),
];

/// Errors of the command's own modules that no command line causes. Unit tests have their whole texts.
const TOLD_IN_UNIT_TESTS: [&str; 2] = ["NoFont", "NoPicture"];

#[test]
fn every_error_has_a_snapshot() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    let mut files = Vec::new();
    for folder in ["src", "../src"] {
        sources(&root.join(folder), &mut files);
    }
    let source = files.concat();
    let unit_tests = files.iter().filter_map(|f| f.split_once("#[cfg(test)]"));
    let unit_tests: String = unit_tests.map(|(_, tests)| tests).collect();
    // This test has the whole texts of all that a check finds.
    let checked = fs::read_to_string(root.join("../tests/it/messages.rs")).unwrap();
    let mut snapshots: String = checked.split("\\\n").map(str::trim_start).collect();
    for entry in fs::read_dir(root.join("tests/it/snapshots")).unwrap() {
        snapshots += &fs::read_to_string(entry.unwrap().path()).unwrap();
    }
    let formats = formats(&source);
    assert!(formats.len() > 25, "{formats:?}");
    let missing = formats.iter().filter(|(name, format)| {
        let words = words(format);
        let told = match WORDLESS.iter().find(|(wordless, _)| wordless == name) {
            Some((_, part)) => snapshots.contains(part),
            None if TOLD_IN_UNIT_TESTS.contains(&name.as_str()) => is_told(&unit_tests, &words),
            None => !words.is_empty() && is_told(&snapshots, &words),
        };
        !told
    });
    let missing: Vec<_> = missing.collect();
    assert!(missing.is_empty(), "no snapshot of {missing:#?}");
}
