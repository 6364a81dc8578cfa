//! Tests that answers and files are the same for any number of threads.

use crate::common::folder;
use foldpath_test_support::Folder;
use serde_json::Value;

/// Runs a command with 1, 2 and 3 threads, and asserts that the answers are the same but for the times. Returns the
/// answer.
#[track_caller]
fn alike(folder: &Folder, command: &str, output: Option<&str>) -> Value {
    let [one, two, three] = [1, 2, 3].map(|jobs| {
        let answer = folder.run(&format!("{command} --jobs {jobs} --json --quiet"));
        let mut answer = answer.json();
        answer.as_object_mut().unwrap().remove("time");
        for attempt in answer["attempts"].as_array_mut().into_iter().flatten() {
            attempt.as_object_mut().unwrap().remove("seconds");
        }
        (answer, output.map(|output| folder.read(output)))
    });
    assert_eq!(one.0, two.0, "{command}");
    assert_eq!(one.0, three.0, "{command}");
    assert!(one.1 == two.1 && one.1 == three.1, "{command}: {output:?}");
    one.0
}

#[test]
fn a_sheet_whose_every_crease_is_an_unknown() {
    let folder = folder();
    folder.done("generate miura --rows 64 --cols 64 --fold 0.8 -o m.fold");
    // Many conditions are bounded, and branches of the matrix are factorised, at once.
    let plan = "plan m.fold --symmetry off --collision off -o p.fold";
    let plan = alike(&folder, plan, Some("p.fold"));
    assert_eq!(plan["outcome"], "planned", "{plan}");
    assert_eq!(plan["unknowns"], 8064);
}

#[test]
fn a_search_for_crossings_among_all_pairs() {
    let folder = folder();
    folder.done("generate miura --rows 24 --cols 24 --fold 0.8 -o m.fold");
    let plan = alike(
        &folder,
        "plan m.fold --symmetry off -o p.fold",
        Some("p.fold"),
    );
    assert_eq!(plan["outcome"], "planned", "{plan}");
    assert!(
        plan["collision"]["tested"].as_u64() > Some(10_000),
        "{plan}"
    );
}

#[test]
fn a_large_sheet_that_rolls_up() {
    let folder = folder();
    // The sheet has too many faces to keep the distances between all of them.
    folder.done("generate yoshimura --rows 48 --cols 48 -o y.fold");
    alike(
        &folder,
        "plan y.fold --fold 0.05 --keep -o p.fold",
        Some("p.fold"),
    );
    folder.done("check p.fold");
}

#[test]
fn a_torn_path() {
    let folder = folder();
    folder.done("generate miura --rows 40 --cols 40 --fold 0.5 -o m.fold");
    folder.done("plan m.fold --interpolation hermite -o p.fold");
    let mut path = folder.read_json("p.fold");
    for key in ["foldpath:edges_group", "foldpath:edges_sign"] {
        path.as_object_mut().unwrap().remove(key);
    }
    for (knot, frame) in path["file_frames"]
        .as_array_mut()
        .unwrap()
        .iter_mut()
        .enumerate()
    {
        let angles = frame["edges_foldAngle"].as_array_mut().unwrap().iter_mut();
        for (edge, angle) in angles.enumerate() {
            if let Some(degrees) = angle.as_f64().filter(|degrees| degrees.abs() > 0.0) {
                let off = ((knot * 31 + edge * 17) % 101) as f64 / 100.0 - 0.5;
                *angle = (degrees + 2e-6 * off).into();
            }
        }
        let frame = frame.as_object_mut().unwrap();
        frame.retain(|key, _| !key.starts_with("foldpath:c") && key != "vertices_coords");
        for claim in ["foldpath:deformation", "foldpath:gap"] {
            frame.remove(claim);
        }
    }
    folder.write("torn.fold", &path.to_string());
    let check = alike(&folder, "check torn.fold", None);
    assert_eq!(check["outcome"], "holds", "{check}");
}
