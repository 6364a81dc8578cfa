//! Tests the predictions of `info`: motions are counted by closed forms and by another decomposition.

use crate::common::{PATTERNS, folder};
use foldpath::pattern::{CreasePattern, Drawing, DrawnEdge, FlatFlaw, Letter};
use foldpath::planner::{FirstStep, Goal, Mobility, first_step, leave_flat};
use foldpath::read::read_pattern;
use foldpath::symmetry::{CreaseGroups, ReducedStars};
use foldpath_core::{HalfAngle, closure};
use nalgebra::{DMatrix, Vector2};

/// Returns a polygon with creases from its middle at these angles, degrees. All are valleys, except those in
/// `mountains`.
fn vertex(angles: &[f64], mountains: &[usize]) -> CreasePattern {
    let n = angles.len();
    let rim = angles
        .iter()
        .map(|a| Vector2::new(a.to_radians().cos(), a.to_radians().sin()));
    let spoke = |k: usize| DrawnEdge {
        ends: [n, k],
        letter: if mountains.contains(&k) {
            Letter::Mountain
        } else {
            Letter::Valley
        },
        goal: None,
    };
    let side = |k: usize| DrawnEdge {
        ends: [k, (k + 1) % n],
        letter: Letter::Boundary,
        goal: None,
    };
    let drawing = Drawing {
        vertices: rim.chain([Vector2::zeros()]).collect(),
        edges: (0..n).map(spoke).chain((0..n).map(side)).collect(),
        faces: None,
    };
    CreasePattern::new(drawing).unwrap()
}

/// Returns the Jacobian of the closure residuals of all vertices, by finite differences.
fn differences(stars: &ReducedStars, x: &[f64]) -> DMatrix<f64> {
    let residuals = |x: &[f64]| {
        let mut half_angles = vec![HalfAngle::default(); x.len()];
        closure::half_angles(x, &mut half_angles);
        let all = stars.view().iter().flat_map(|star| {
            let residual: [f64; 3] = closure::residual(star, &half_angles).into();
            residual
        });
        all.collect::<Vec<f64>>()
    };
    let step = 1e-5;
    let columns: Vec<_> = (0..x.len())
        .map(|unknown| {
            let at = |way: f64| {
                let mut moved = x.to_vec();
                moved[unknown] += way * step;
                nalgebra::DVector::from_vec(residuals(&moved))
            };
            (at(1.0) - at(-1.0)) / (2.0 * step)
        })
        .collect();
    DMatrix::from_columns(&columns)
}

/// Returns the number of singular values above the error of the finite differences.
fn rank(matrix: DMatrix<f64>) -> usize {
    let values = matrix.singular_values();
    values
        .iter()
        .filter(|value| **value > 1e-6 * values.max())
        .count()
}

/// A sheet with one vertex of n creases has n - 3 degrees of freedom.
#[test]
fn vertices_have_three_ways_to_move_less_than_creases() {
    for (angles, mountains) in [
        (&[0.0, 70.0, 180.0, 290.0][..], &[0][..]),
        (&[0.0, 60.0, 150.0, 200.0, 290.0], &[0, 2]),
        (&[0.0, 50.0, 110.0, 180.0, 250.0, 300.0], &[1, 4]),
    ] {
        let sheet = vertex(angles, mountains);
        let start: Vec<f64> = (0..angles.len())
            .map(|k| if mountains.contains(&k) { -0.4 } else { 0.4 })
            .collect();
        let left = leave_flat(&sheet, &start);
        assert!(
            left.closure < 1e-9 && left.fold_angles.iter().any(|a| a.abs() > 0.1),
            "{left:?}"
        );
        let motions = Mobility::at(&ReducedStars::of_creases(&sheet), &left.fold_angles).unwrap();
        assert_eq!(motions.drivers.len(), angles.len() - 3);
        assert_eq!(motions.moving.len(), angles.len());
    }
}

/// The number of driven hinges agrees with a singular value decomposition of finite differences. With these hinges
/// held, nothing moves any more.
#[test]
fn driven_hinges_decide_all_others() {
    for (name, ways) in [
        ("miura-5x5", Some(1)),
        ("square-twist-1x1", Some(1)),
        ("waterbomb-4x6", None),
        ("miura-3x3", Some(1)),
    ] {
        let sheet = read_pattern(format!("{PATTERNS}/{name}.fold").as_ref())
            .unwrap()
            .pattern;
        let goal = Goal::of_pattern(&sheet).unwrap();
        let x: Vec<f64> = goal
            .fold_angles
            .iter()
            .map(|angle| angle.unwrap())
            .collect();
        let stars = ReducedStars::of_creases(&sheet);
        let motions = Mobility::at(&stars, &x).unwrap();
        let jacobian = differences(&stars, &x);
        let free = x.len() - rank(jacobian.clone());
        assert_eq!(motions.drivers.len(), free, "{name}");
        assert!(ways.is_none_or(|ways| ways == free), "{name}: {free}");
        let held = jacobian.remove_columns_at(&{
            let mut drivers = motions.drivers.clone();
            drivers.sort_unstable();
            drivers
        });
        assert_eq!(rank(held), x.len() - free, "{name}: {motions:?}");
    }
}

#[test]
fn first_steps_tell_sheets_apart() {
    let step = |name: &str| {
        let sheet = read_pattern(format!("{PATTERNS}/{name}.fold").as_ref())
            .unwrap()
            .pattern;
        first_step(
            &sheet,
            &CreaseGroups::find(&sheet),
            &Goal::of_pattern(&sheet).unwrap(),
        )
    };
    for name in [
        "miura-24x24",
        "waterbomb-8x10",
        "yoshimura-12x12",
        "square-twist-3x3",
    ] {
        match step(name) {
            FirstStep::Leaves {
                unturned: 0,
                symmetric: Some(motions),
                ..
            } => {
                assert_eq!(motions.drivers.len(), 1, "{name}");
            }
            other => panic!("{name}: {other:?}"),
        }
    }
    for name in ["square-twist-unfoldable", "kresling-2x6"] {
        let step = step(name);
        assert!(
            matches!(step, FirstStep::Stays | FirstStep::Bends),
            "{name}: {step:?}"
        );
    }
    // All creases are valleys: only straight lines through the whole sheet turn.
    let quad = step("quad-3x3");
    assert!(
        matches!(quad, FirstStep::Leaves { unturned: 1.., .. }),
        "{quad:?}"
    );
}

/// The theorems of Kawasaki and Maekawa, and an odd number of creases, on vertices that break one of them.
#[test]
fn vertices_that_cannot_fold_flat_are_named() {
    let flat = vertex(&[0.0, 60.0, 130.0, 250.0], &[0]);
    assert_eq!(flat.flat_flaws(), []);
    let [(at, FlatFlaw::Kawasaki(sum))] = vertex(&[0.0, 60.0, 130.0, 230.0], &[0]).flat_flaws()[..]
    else {
        panic!()
    };
    assert_eq!(at.index(), 4);
    // The sectors are 60, 70, 100 and 130 degrees.
    let sums = [160.0, 200.0];
    assert!(
        sums.iter()
            .any(|degrees: &f64| (sum - degrees.to_radians()).abs() < 1e-12),
        "{sum}"
    );
    let flaws = vertex(&[0.0, 60.0, 130.0, 250.0], &[0, 1]).flat_flaws();
    assert!(
        matches!(flaws[..], [(_, FlatFlaw::Maekawa(2, 2))]),
        "{flaws:?}"
    );
    let odd = vertex(&[0.0, 60.0, 150.0, 200.0, 290.0], &[0]).flat_flaws();
    assert!(matches!(odd[..], [(_, FlatFlaw::Odd(5))]), "{odd:?}");
}

#[test]
fn info_says_what_will_be() {
    let folder = folder();
    let info = |file: &str| folder.done(&format!("info {file}")).stdout;
    let miura = info(&format!("{PATTERNS}/miura-5x5.fold"));
    assert!(
        miura.contains("will it fold        likely: it leaves flat"),
        "{miura}"
    );
    assert!(
        miura.contains("to drive            1 hinge, such as edge ")
            && miura.contains(": 39 follow\n"),
        "{miura}"
    );
    let waterbomb = info(&format!("{PATTERNS}/waterbomb-4x6.fold"));
    assert!(
        waterbomb.contains("hinges, such as edges")
            && waterbomb.contains("; 1 hinge, such as edge"),
        "{waterbomb}"
    );
    let locked = info(&format!("{PATTERNS}/square-twist-unfoldable.fold"));
    assert!(locked.contains("hardly: no first step"), "{locked}");
    // The angles of this goal are written in radians.
    folder.done("generate miura --rows 3 --cols 3 -o miura.fold");
    let mut document = folder.read_json("miura.fold");
    for angle in document["edges_foldAngle"].as_array_mut().unwrap() {
        *angle = serde_json::json!(angle.as_f64().unwrap().to_radians());
    }
    folder.write("radians.fold", &document.to_string());
    for (command, said) in [("info", true), ("plan", true), ("info --quiet", false)] {
        let answer = folder.run(&format!("{command} radians.fold"));
        assert_eq!(
            answer.stderr.contains("if they are radians"),
            said,
            "{command}: {answer:?}"
        );
    }
    assert!(!folder.done("info miura.fold").stderr.contains("radians"));
    // One vertex with four creases that satisfies neither theorem. The file has letters, but no goal angles.
    for letter in ["V", "U"] {
        let text = format!(
            "{{\"vertices_coords\":[[1,0],[0,1],[-1,0.2],[0,-1],[0,0]],\
             \"edges_vertices\":[[0,1],[1,2],[2,3],[3,0],[4,0],[4,1],[4,2],[4,3]],\
             \"edges_assignment\":[\"B\",\"B\",\"B\",\"B\",\"{letter}\",\"{letter}\",\"{letter}\",\"{letter}\"]}}"
        );
        folder.write("star.fold", &text);
        let said = info("star.fold");
        let expected = if letter == "V" {
            "2 of 4 hinges do not turn at first"
        } else {
            "nothing says which way"
        };
        assert!(said.contains(expected), "{said}");
    }
    // No two creases are in line. If the one mountain is one of the two creases that can be the only mountain, all
    // creases turn.
    let star = folder
        .read("star.fold")
        .replacen("[0,1]", "[0.1,1]", 1)
        .replace("\"U\"", "\"V\"");
    let said = (0..4).map(|mountain| {
        let (head, letters) = star.split_at(star.find("\"V\"").unwrap() + 4 * mountain);
        folder.write(
            "one.fold",
            &(head.to_string() + &letters.replacen("\"V\"", "\"M\"", 1)),
        );
        info("one.fold")
    });
    let part =
        |said: &String| said.contains("not all the way: ") && said.contains("vertex 4 (Kawasaki");
    assert!(
        said.clone().any(|said| part(&said)),
        "{:?}",
        said.collect::<Vec<_>>()
    );
}
