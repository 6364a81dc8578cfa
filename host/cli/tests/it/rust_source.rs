//! Tests `export --to rust`: its constants compile without `std`, and equal those of the `.traj` file.

use std::fs;
use std::path::Path;
use std::process::Command;

use crate::common::{folder, folder_with_path};
use foldpath_core::trajectory_file::TrajectoryFile;
use foldpath_test_support::Folder;

/// Program that prints the constants of the library, as the test prints those of the file.
const MAIN: &str = r#"
use foldpath_core::{StarsView, trajectory::TrajectoryView};
use path::*;

fn main() {
    let view = TrajectoryView::new(INTERPOLATION, GROUPS, SPANS, ANGLES, RATES, WEIGHTS).unwrap();
    let stars = StarsView::new(SPOKES, ENDS, GROUPS).unwrap();
    println!("{:?} {} {}", INTERPOLATION, view.len(), stars.len());
    println!("{:08x}", CLOSURE.to_bits());
    for (knot, span) in SPANS.iter().enumerate() {
        println!("{:08x}", span.to_bits());
        for group in 0..GROUPS {
            let place = knot * GROUPS + group;
            let weight = WEIGHTS.get(place).copied().unwrap_or([1.0, 0.0]);
            let node = [ANGLES[place], RATES[place], weight[0], weight[1]];
            println!("{:?}", node.map(f32::to_bits));
        }
    }
    println!("{LIMITS:?}\n{HINGES:?}\n{SPOKES:?}");
}
"#;

/// Returns the text that `MAIN` has to print.
fn expected(bytes: &[u8], stars: usize) -> String {
    let file = TrajectoryFile::read(bytes).unwrap();
    let mut text = format!("{:?} {} {stars}\n", file.interpolation(), file.len());
    text += &format!("{:08x}\n", file.closure().to_bits());
    for knot in 0..file.len() {
        text += &format!("{:08x}\n", file.span(knot).unwrap().to_bits());
        for group in 0..file.groups() {
            let node = file.node(knot, group).unwrap();
            let node = [node.angle, node.rate, node.weight[0], node.weight[1]];
            text += &format!("{:?}\n", node.map(f32::to_bits));
        }
    }
    let limits: Vec<_> = (0..file.groups()).filter_map(|g| file.limits(g)).collect();
    let hinges: Vec<_> = file.memberships().collect();
    let spokes: Vec<_> = file.spokes().map(|(spoke, _)| spoke).collect();
    text + &format!("{limits:?}\n{hinges:?}\n{spokes:?}\n")
}

/// Builds the source as a library without `std`, and runs a program on it.
fn printed(source: &str, folder: &Folder) -> String {
    let core = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../core");
    let manifest = format!(
        "[package]\nname = \"path\"\nversion = \"0.1.0\"\nedition = \"2024\"\n\n[dependencies]\n\
         foldpath-core = {{ path = {core:?} }}\n\n[workspace]\n\n[profile.dev]\ndebug = false\n"
    );
    folder.write("Cargo.toml", &manifest);
    fs::copy(core.join("../Cargo.lock"), folder.path("Cargo.lock")).unwrap();
    fs::create_dir_all(folder.path("src")).unwrap();
    folder.write("src/path.rs", source);
    folder.write(
        "src/lib.rs",
        "#![no_std]\n#![deny(warnings)]\ninclude!(\"path.rs\");\n",
    );
    folder.write("src/main.rs", MAIN);
    let mut cargo = Command::new(env!("CARGO"));
    cargo.args(["run", "--offline", "--quiet", "--target-dir"]);
    // All runs of this test share one folder, so that dependencies are built once.
    cargo.arg(Path::new(env!("CARGO_TARGET_TMPDIR")).join("rust_source"));
    cargo.current_dir(folder.path(""));
    let output = cargo.output().unwrap();
    let stderr = String::from_utf8_lossy(&output.stderr);
    assert!(output.status.success(), "{stderr}");
    String::from_utf8(output.stdout).unwrap()
}

#[test]
fn a_path_compiles_without_std_and_is_the_same() {
    for (generate, plan) in [
        ("miura --rows 3 --cols 3", "--max-accel 60"),
        ("waterbomb --rows 2 --cols 4", "--interpolation homogeneous"),
    ] {
        let folder = folder();
        folder.done(&format!("generate {generate} -o pattern.fold"));
        folder.done(&format!("plan pattern.fold {plan} -o path.fold"));
        folder.done("export path.fold --to rust -o path.rs");
        folder.done("export path.fold --to traj -o path.traj");
        let bytes = fs::read(folder.path("path.traj")).unwrap();
        let file = TrajectoryFile::read(&bytes).unwrap();
        let stars = file.spokes().filter(|(_, last)| *last).count();
        assert!(stars > 0);
        assert_eq!(
            printed(&folder.read("path.rs"), &folder),
            expected(&bytes, stars)
        );
    }
}

#[test]
fn a_title_stays_in_its_comment() {
    let folder = folder_with_path();
    let mut path = folder.read_json("path.fold");
    path["file_title"] = "a\nb\u{2028} */ fn main() {}\r".into();
    folder.write("path.fold", &path.to_string());
    folder.done("export path.fold --to rust -o path.rs");
    let text = folder.read("path.rs");
    let code: Vec<&str> = text
        .lines()
        .filter(|line| !line.starts_with("//"))
        .collect();
    assert!(text.starts_with("// a\\nb"), "{text}");
    assert!(code.iter().all(|line| !line.contains("main")), "{text}");
}
