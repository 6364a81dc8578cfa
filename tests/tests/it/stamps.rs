//! Strips and combs of stamps, with any letters: the oracle and `check` judge the paths.

use foldpath::check::check;
use foldpath::export::fold::motion_text;
use foldpath::pattern::{CreasePattern, Drawing, DrawnEdge, Letter};
use foldpath::planner::{Goal, Outcome, PlanOptions, plan};
use foldpath_tests::{Animation, CONTACT, Random, judge, path_file, strict};
use nalgebra::Vector2;

/// Returns a strip of unit squares along x, with a strip of `teeth` more squares on every second of them.
fn comb(squares: usize, teeth: usize, random: &mut Random) -> Drawing {
    let mut cells = Vec::new();
    for column in 0..squares {
        let top = if column % 2 == 0 { teeth } else { 0 };
        cells.extend((0..=top).map(|row| (column, row)));
    }
    let vertex = |(x, y): (usize, usize)| x * (teeth + 2) + y;
    #[allow(clippy::cast_precision_loss, reason = "a small number")]
    let vertices = (0..(squares + 1) * (teeth + 2)).map(|index| {
        let (x, y) = (index / (teeth + 2), index % (teeth + 2));
        Vector2::new(x as f64, y as f64)
    });
    let mut sides = std::collections::BTreeMap::new();
    for (x, y) in cells {
        let corners = [(x, y), (x + 1, y), (x + 1, y + 1), (x, y + 1)].map(vertex);
        for k in 0..4 {
            let [a, b] = [corners[k], corners[(k + 1) % 4]];
            *sides.entry([a.min(b), a.max(b)]).or_insert(0) += 1;
        }
    }
    let edges = sides.into_iter().map(|(ends, faces)| DrawnEdge {
        ends,
        letter: match faces {
            1 => Letter::Boundary,
            _ if random.below(2) == 0 => Letter::Mountain,
            _ => Letter::Valley,
        },
        goal: None,
    });
    let edges: Vec<DrawnEdge> = edges.collect();
    // Vertices that no square has are left out.
    let vertices: Vec<Vector2<f64>> = vertices.collect();
    let mut numbers = vec![None; vertices.len()];
    let mut drawing = Drawing::default();
    for mut edge in edges {
        edge.ends = edge.ends.map(|end| {
            *numbers[end].get_or_insert_with(|| {
                drawing.vertices.push(vertices[end]);
                drawing.vertices.len() - 1
            })
        });
        drawing.edges.push(edge);
    }
    drawing
}

/// Asserts that a sheet is planned, and that `check` and the oracle have nothing to say of its path.
fn assert_planned(name: &str, drawing: Drawing) {
    let pattern = CreasePattern::new(drawing).unwrap();
    let goal = Goal::of_pattern(&pattern).unwrap();
    let options = PlanOptions::default();
    let plan = plan(&pattern, &goal, &options);
    assert_eq!(plan.outcome, Outcome::Planned, "{name}: {:?}", plan.reason);
    let text = motion_text(plan.motion.as_ref().unwrap());
    let verdict = check(&path_file(&text).unwrap(), &strict());
    assert_eq!(verdict.findings(), [""; 0], "{name}");
    let path = Animation::parse(&text).unwrap();
    let angles: Vec<_> = pattern.edges().iter().map(|edge| edge.goal).collect();
    let judged = judge(&path, &angles, &plan, options.bound, CONTACT);
    assert_eq!(judged.disagreements, [""; 0], "{name}");
}

#[test]
fn strips_and_combs_of_stamps_are_planned_whatever_their_letters() {
    let mut random = Random::new(56);
    for (squares, teeth, cases) in [(12, 0, 3), (24, 0, 1), (36, 0, 1), (5, 3, 3), (9, 3, 1)] {
        for case in 0..cases {
            let name = format!("{squares} squares, teeth of {teeth}, case {case}");
            assert_planned(&name, comb(squares, teeth, &mut random));
        }
    }
}

/// Returns a strip that rolls up by quarter turns, each panel a little longer than the one before.
fn roll(panels: usize) -> Drawing {
    #[allow(clippy::cast_precision_loss, reason = "a small number")]
    let widths = (0..panels).map(|panel| 1.0 + 0.02 * panel as f64);
    let ends = widths.scan(0.0, |end, width| {
        *end += width;
        Some(*end)
    });
    let ends: Vec<f64> = core::iter::once(0.0).chain(ends).collect();
    let count = ends.len();
    let vertices = (0..2 * count).map(|k| Vector2::new(ends[k % count], f64::from(k >= count)));
    let along = (0..2 * count).filter(|k| (k + 1) % count != 0);
    let rim = along
        .map(|k| [k, k + 1])
        .chain([[0, count], [count - 1, 2 * count - 1]]);
    let hinges = (1..panels).map(|k| DrawnEdge {
        ends: [k, count + k],
        letter: Letter::Valley,
        goal: Some(core::f64::consts::FRAC_PI_2),
    });
    Drawing {
        vertices: vertices.collect(),
        edges: rim.map(DrawnEdge::boundary).chain(hinges).collect(),
        faces: None,
    }
}

/// Only the innermost panel can turn first, and only the outermost last.
#[test]
fn strips_that_roll_up_are_planned() {
    for panels in [12, 20, 48] {
        assert_planned(&format!("{panels} panels"), roll(panels));
    }
}
