//! Tests `-`, which stands for stdin or stdout wherever a file is named.

use crate::common::{folder, folder_with_path};
use foldpath_test_support::Folder;

/// Returns what a command prints that reads `input` from stdin and must succeed.
fn piped(folder: &Folder, arguments: &str, input: &str) -> String {
    let answer = folder.run_with(arguments, input.as_bytes());
    answer.with_status(0).stdout
}

#[test]
fn every_command_writes_to_stdout_what_it_writes_to_a_file() {
    let folder = folder_with_path();
    folder.done("export path.fold --to traj -o path.traj");
    let [pattern, path] = ["miura.fold", "path.fold"].map(|name| folder.read(name));
    for (command, input) in [
        ("generate miura --rows 3 --cols 3", ""),
        ("plan IN", &pattern),
        ("unfold IN", &path),
        ("plot IN", &path),
        ("export IN --to csv", &path),
        ("export IN --to csv --rate 10", &path),
        ("export IN --to joint-trajectory", &path),
        ("export IN --to svg", &path),
        ("export IN --to svg --colour groups", &path),
    ] {
        folder.write("in.fold", input);
        // The ending says the format of a picture.
        folder.done(&format!("{} -o out.svg", command.replace("IN", "in.fold")));
        let written = folder.read("out.svg");
        let answer = folder.run_with(
            &format!("{} -o -", command.replace("IN", "-")),
            input.as_bytes(),
        );
        let answer = answer.with_status(0);
        assert_eq!(answer.stdout, written, "{command}");
        assert!(
            answer.stderr.contains("<stdout>"),
            "{command}: {}",
            answer.stderr
        );
        let command = command.replace("IN", "-");
        let quiet = folder.run_with(&format!("{command} -o - --quiet"), input.as_bytes());
        assert_eq!(
            (quiet.stdout, quiet.stderr),
            (written, String::new()),
            "{command}"
        );
    }
    let page = piped(&folder, "view - -o -", &path);
    assert!(page.starts_with("<!doctype html>") && page.contains("Miura 3x3"));
    let log = folder.done("stream path.traj --to sim --log -");
    assert!(
        log.stdout.starts_with("t_us,state,sequence,group_0"),
        "{log:?}"
    );
    assert!(log.stderr.contains("log          <stdout>"), "{log:?}");
}

#[test]
fn commands_form_a_pipe() {
    let folder = folder();
    let pattern = piped(&folder, "generate miura --rows 4 --cols 4 -o -", "");
    let path = piped(&folder, "plan - -o -", &pattern);
    assert!(piped(&folder, "check -", &path).starts_with("Miura 4x4: holds"));
    assert!(piped(&folder, "info -", &path).contains("24 creases"));
    let json = folder.run_with("plan - --json", pattern.as_bytes()).json();
    assert_eq!(
        (&json["outcome"], &json["input"]["file"]),
        (&"planned".into(), &"<stdin>".into())
    );
    folder.write("miura.fold", &pattern);
    assert_eq!(
        folder.done("plan miura.fold --json").json()["input"]["sha256"],
        json["input"]["sha256"]
    );
    // The goal, a goal on the way, the sheet and the script may come from stdin too.
    folder.write("path.fold", &path);
    folder.done("export path.fold --to traj -o path.traj");
    assert!(
        piped(&folder, "plan miura.fold --goal -", &pattern).contains("the goal angles of <stdin>")
    );
    piped(&folder, "plan miura.fold --via - --fold 0", &pattern);
    assert!(
        piped(&folder, "stream path.traj --to sim --sheet -", &path)
            .contains("sheet        deformation")
    );
    piped(
        &folder,
        "stream path.traj --to sim --script -",
        "0 supply 1\n",
    );
}

/// The content of stdin says its format.
#[test]
fn drawings_and_shapes_come_from_stdin() {
    let folder = folder_with_path();
    let svg = piped(&folder, "export - --to svg -o -", &folder.read("path.fold"));
    let sheet = "9 faces, 16 vertices";
    assert!(piped(&folder, "info -", &svg).contains(sheet));
    let with_prolog = format!("\u{feff}<?xml version=\"1.0\"?>\n<!-- a drawing -->\n{svg}");
    assert!(piped(&folder, "info -", &with_prolog).contains(sheet));
    assert!(piped(&folder, "info - --colors red=V", &svg).contains(sheet));
    let cp = "1 0 0 1 0\n1 1 0 1 1\n1 1 1 0 1\n1 0 1 0 0\n2 0 0 1 1\n";
    assert!(piped(&folder, "info -", cp).contains("2 faces, 4 vertices"));
    let line = |ends: [i32; 4], kind: i32| {
        let places = ["x0", "y0", "x1", "y1"].iter().zip(ends);
        let places = places
            .map(|(name, at)| format!("<void property=\"{name}\"><double>{at}</double></void>"));
        let places: String = places.collect();
        format!(
            "<void index=\"0\"><object class=\"oripa.OriLineProxy\"><void property=\"type\"><int>{kind}</int></void>\
             {places}</object></void>"
        )
    };
    let sides = [[0, 0, 1, 0], [1, 0, 1, 1], [1, 1, 0, 1], [0, 1, 0, 0]].map(|side| line(side, 1));
    let lines = sides.concat() + &line([0, 0, 1, 1], 2);
    let opx = format!(
        "<?xml version=\"1.0\"?>\n<java>\n<array class=\"oripa.OriLineProxy\">{lines}</array></java>"
    );
    assert!(piped(&folder, "info -", &opx).contains("2 faces, 4 vertices"));

    let obj = "# a tent\nv 0 0 0\nv 1 0 0\nv 1 1 0.5\nv 0 1 0.5\nv 1 2 0\nv 0 2 0\nf 1 2 3 4\nf 4 3 5 6\n";
    assert!(piped(&folder, "unfold - -o -", obj).contains("edges_foldAngle"));
    let corner = |x: f32, y: f32, z: f32| [x, y, z].map(f32::to_le_bytes).concat();
    let triangles = [
        [
            corner(0.0, 0.0, 0.0),
            corner(1.0, 0.0, 0.0),
            corner(1.0, 1.0, 0.5),
        ],
        [
            corner(0.0, 0.0, 0.0),
            corner(1.0, 1.0, 0.5),
            corner(0.0, 1.0, 0.0),
        ],
    ];
    let mut stl = vec![b' '; 80];
    stl.extend(2_u32.to_le_bytes());
    for triangle in triangles {
        stl.extend([[0; 12].to_vec(), triangle.concat(), vec![0; 2]].concat());
    }
    let unfolded = folder.run_with("unfold - -o -", &stl).with_status(0);
    assert!(unfolded.stdout.contains("edges_foldAngle"));
    let text = "solid a\nfacet normal 0 0 1\nouter loop\nvertex 0 0 0\nvertex 1 0 0\nvertex 0 1 0\nendloop\n\
                endfacet\nendsolid a\n";
    assert!(piped(&folder, "unfold - -o -", text).contains("vertices_coords"));
}

#[test]
fn errors_name_stdin_and_nothing_is_written() {
    let folder = folder_with_path();
    // A file of this name has nothing to do with stdin.
    folder.write("<stdin>", "{\n\n");
    let mut said = String::new();
    for (arguments, input) in [
        ("info -", "{\"a\": [1, 2}"),
        ("info -", ""),
        (
            "plan - -o -",
            "{\n\"vertices_coords\": [[0, 0], [1, \"b\"]],\n\"edges_vertices\": []\n}",
        ),
        (
            "plan - -o -",
            "{\"vertices_coords\": [[0,0],[1,0],[0,1]], \"edges_vertices\": [[0,1],[1,2],[2,7]]}",
        ),
        ("check -", &folder.read("miura.fold")),
        ("info - --colors red=V", &folder.read("miura.fold")),
        ("info -", "1 0 0 x 1\n"),
        ("unfold - -o - --frame 2", "v 0 0 0\n"),
        ("unfold - -o -", "v 0 0 0\nv 1 0 0\nv 1 1 0\nf 1 2 9\n"),
        ("stream - --to sim", "{}"),
        ("stream - --to sim --log -", ""),
        ("plan miura.fold --goal - -o -", "[]"),
    ] {
        let answer = folder.run_with(arguments, input.as_bytes()).with_status(2);
        assert_eq!(answer.stdout, "", "{arguments}");
        said += &format!("$ foldpath {arguments}\n{}\n\n", answer.stderr.trim_end());
    }
    insta::assert_snapshot!(said);
    let error = folder
        .run_with("check - --json", b"{\n]")
        .with_status(2)
        .json();
    let place = ["file", "line"].map(|key| error["error"][key].clone());
    assert_eq!(place, [serde_json::json!("<stdin>"), serde_json::json!(2)]);
    // An answer that is no writes nothing either.
    let quad = folder.run("generate quad --rows 3 --cols 3 -o -").stdout;
    let refused = folder
        .run_with("plan - -o -", quad.as_bytes())
        .with_status(1);
    assert_eq!(refused.stdout, "");
    assert!(refused.stderr.contains("nothing written"), "{refused:?}");
}

#[test]
fn stdout_takes_one_thing() {
    let folder = folder_with_path();
    folder.done("export path.fold --to traj -o path.traj");
    for (arguments, option) in [
        ("plan miura.fold -o -", "-o"),
        ("unfold path.fold -o -", "-o"),
        ("stream path.traj --to sim --log -", "--log"),
    ] {
        let answer = folder.run(&format!("{arguments} --json")).with_status(2);
        let expected = format!("{option}: expected a file, as --json writes its answer to stdout");
        assert_eq!(answer.json()["error"]["message"], expected, "{arguments}");
    }
    // A file that is named `-` has a folder in its name.
    folder.done("generate miura --rows 3 --cols 3 -o ./-");
    assert!(folder.done("info ./-").stdout.contains("12 creases"));
}

#[test]
#[cfg(target_os = "linux")]
fn a_reader_that_has_gone_is_no_error() {
    let folder = folder_with_path();
    let mut child = folder.command("view path.fold -o -");
    let mut child = child.stdout(std::process::Stdio::piped()).spawn().unwrap();
    drop(child.stdout.take());
    assert!(child.wait().unwrap().success());
}
