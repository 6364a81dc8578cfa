//! One net, drawn in many ways: rounded, in other units, turned, shifted, as FOLD and as SVG. Its closed solid touches itself
//! everywhere, so that every digit counts, and the verdict is always the same.

use core::f64::consts::PI;
use core::fmt::Write as _;

use foldpath_test_support::Folder;
use serde_json::json;

use crate::common::folder;

/// A net of equilateral triangles with sides of length 1 whose creases all turn alike.
struct Net {
    name: &'static str,
    triangles: Vec<[[f64; 2]; 3]>,
    /// Fold angle, degrees.
    angle: f64,
}

/// Returns the nets of tetrahedron and octahedron.
fn nets() -> [Net; 2] {
    let height = 0.75_f64.sqrt();
    let strip = |count: usize| -> Vec<[[f64; 2]; 3]> {
        let at = |k: usize| {
            let x = f64::from(u32::try_from(k).unwrap()) / 2.0;
            [x, if k.is_multiple_of(2) { 0.0 } else { height }]
        };
        let triangle = |k: usize| {
            if k.is_multiple_of(2) {
                [at(k), at(k + 2), at(k + 1)]
            } else {
                [at(k), at(k + 1), at(k + 2)]
            }
        };
        (0..count).map(triangle).collect()
    };
    let mut octahedron = strip(6);
    octahedron.push([[0.5, height], [1.5, height], [1.0, 2.0 * height]]);
    octahedron.push([[2.0, 0.0], [1.0, 0.0], [1.5, -height]]);
    let small = (1.0_f64 / 3.0).acos().to_degrees();
    [
        Net {
            name: "tetrahedron",
            triangles: strip(4),
            angle: 180.0 - small,
        },
        Net {
            name: "octahedron",
            triangles: octahedron,
            angle: small,
        },
    ]
}

/// Lines of a net: ends, and whether it is a crease.
type Lines = Vec<([usize; 2], bool)>;

impl Net {
    /// Returns the vertices and lines.
    fn drawn(&self) -> (Vec<[f64; 2]>, Lines) {
        let mut points: Vec<[f64; 2]> = Vec::new();
        let mut lines: Vec<([usize; 2], bool)> = Vec::new();
        for triangle in &self.triangles {
            let corners = triangle.map(|[x, y]| {
                let same = |p: &[f64; 2]| (p[0] - x).hypot(p[1] - y) < 1e-6;
                points.iter().position(same).unwrap_or_else(|| {
                    points.push([x, y]);
                    points.len() - 1
                })
            });
            for k in 0..3 {
                let mut ends = [corners[k], corners[(k + 1) % 3]];
                ends.sort_unstable();
                match lines.iter_mut().find(|line| line.0 == ends) {
                    Some(line) => line.1 = true,
                    None => lines.push((ends, false)),
                }
            }
        }
        (points, lines)
    }

    /// Returns a FOLD file of the points `place` makes of the vertices, with this fold angle in degrees.
    fn fold(&self, place: impl Fn([f64; 2]) -> Vec<f64>, angle: f64) -> String {
        let (points, lines) = self.drawn();
        let letter = |crease: bool| if crease { "V" } else { "B" };
        let file = json!({
            "file_spec": 1.2,
            "vertices_coords": points.into_iter().map(place).collect::<Vec<_>>(),
            "edges_vertices": lines.iter().map(|line| line.0).collect::<Vec<_>>(),
            "edges_assignment": lines.iter().map(|line| letter(line.1)).collect::<Vec<_>>(),
            "edges_foldAngle": lines.iter()
                .map(|line| if line.1 { angle } else { 0.0 }).collect::<Vec<_>>(),
        });
        file.to_string()
    }

    /// Returns an SVG drawing in a unit, within a group that is transformed.
    fn svg(&self, unit: &str, transform: &str, [places, of_opacity]: [i32; 2]) -> String {
        let (points, lines) = self.drawn();
        let mut text = format!(
            "<svg xmlns=\"http://www.w3.org/2000/svg\" width=\"500{unit}\" height=\"400{unit}\" \
             viewBox=\"0 0 500 400\"><g transform=\"{transform}\">"
        );
        for (ends, crease) in lines {
            let [[x1, y1], [x2, y2]] =
                ends.map(|end| points[end].map(|x| round(100.0 * x + 100.0, places)));
            let colour = if crease {
                let opacity = round(self.angle / 180.0, of_opacity);
                format!("#0000ff\" stroke-opacity=\"{opacity}")
            } else {
                "#000000".into()
            };
            writeln!(
                text,
                "<line x1=\"{x1}\" y1=\"{y1}\" x2=\"{x2}\" y2=\"{y2}\" stroke=\"{colour}\"/>"
            )
            .unwrap();
        }
        text + "</g></svg>"
    }
}

fn round(x: f64, places: i32) -> f64 {
    let unit = 10.0_f64.powi(places);
    (x * unit).round() / unit
}

/// Rounds to a number of significant digits.
fn significant(x: f64, digits: usize) -> f64 {
    format!("{x:.*e}", digits - 1).parse().unwrap()
}

fn drawings(net: &Net) -> Vec<(&'static str, String)> {
    let exact = |p: [f64; 2]| p.to_vec();
    let scaled = |by: f64, shift: f64, places: i32| {
        move |p: [f64; 2]| p.map(|x| round(by * x + shift, places)).to_vec()
    };
    let turned = |p: [f64; 2]| {
        let (sin, cos) = 0.3_f64.sin_cos();
        [p[0] * cos - p[1] * sin, p[0] * sin + p[1] * cos]
    };
    let angle = net.angle;
    let radians = |places: i32| round(angle.to_radians(), places).to_degrees();
    #[allow(
        clippy::cast_possible_truncation,
        reason = "as a program in single precision"
    )]
    let single = |p: [f64; 2]| p.map(|x| f64::from((100.0 * x) as f32)).to_vec();
    vec![
        ("exact.fold", net.fold(exact, angle)),
        ("angle-2.fold", net.fold(exact, round(angle, 2))),
        ("angle-3.fold", net.fold(exact, round(angle, 3))),
        ("angle-6.fold", net.fold(exact, round(angle, 6))),
        ("radians-4.fold", net.fold(exact, radians(4))),
        ("radians-6.fold", net.fold(exact, radians(6))),
        ("places-1.fold", net.fold(scaled(100.0, 0.0, 1), angle)),
        ("places-2.fold", net.fold(scaled(100.0, 0.0, 2), angle)),
        ("places-5.fold", net.fold(scaled(100.0, 0.0, 5), angle)),
        (
            "small.fold",
            net.fold(scaled(0.01, 0.0, 6), round(angle, 4)),
        ),
        ("far.fold", net.fold(scaled(100.0, 1e5, 3), round(angle, 3))),
        (
            "digits-6.fold",
            net.fold(
                |p| p.map(|x| significant(100.0 * x + 1.0, 6)).to_vec(),
                significant(angle, 6),
            ),
        ),
        ("single.fold", net.fold(single, angle)),
        (
            "turned.fold",
            net.fold(|p| scaled(100.0, 0.0, 3)(turned(p)), round(angle, 3)),
        ),
        (
            "in-space.fold",
            net.fold(
                |p| {
                    let [x, y] = turned(p).map(|x| 100.0 * x);
                    [x, y * 0.6, y * 0.8].map(|x| round(x, 4)).to_vec()
                },
                round(angle, 3),
            ),
        ),
        ("px.svg", net.svg("", "", [3, 6])),
        ("mm.svg", net.svg("mm", "", [3, 6])),
        ("mm-2.svg", net.svg("mm", "", [2, 4])),
        ("turned.svg", net.svg("mm", "rotate(17)", [3, 6])),
        (
            "shifted.svg",
            net.svg("cm", "translate(1000,-2000)", [3, 6]),
        ),
        ("scaled.svg", net.svg("", "scale(0.35277)", [3, 5])),
    ]
}

fn verdict(folder: &Folder, name: &str) -> String {
    let answer = folder.run(&format!("plan {name} --json -o {name}.path.fold"));
    let plan = answer.json();
    let outcome = plan["outcome"].as_str().unwrap().to_string();
    if outcome == "planned" {
        folder.done(&format!("check {name}.path.fold"));
    }
    format!("{outcome} (contact {})", plan["contact_tolerance"])
}

#[test]
fn a_net_is_planned_however_it_is_drawn() {
    let folder = folder();
    let mut refused = Vec::new();
    for net in nets() {
        for (name, text) in drawings(&net) {
            let name = format!("{}-{name}", net.name);
            folder.write(&name, &text);
            let verdict = verdict(&folder, &name);
            if !verdict.starts_with("planned") {
                refused.push(format!("{name}: {verdict}"));
            }
        }
    }
    assert!(refused.is_empty(), "{refused:#?}");
}

/// A net that overlaps when closed, because its angle is wrong by more than its digits say, is refused however it is drawn.
#[test]
fn a_net_with_a_wrong_angle_is_refused_however_it_is_drawn() {
    let folder = folder();
    for mut net in nets() {
        net.angle += 1.0;
        for (name, text) in drawings(&net) {
            folder.write(name, &text);
            let verdict = verdict(&folder, name);
            assert!(
                verdict.starts_with("crossing"),
                "{} {name}: {verdict}",
                net.name
            );
        }
    }
}

/// A shape that is unfolded hands its precision down to its net, and the net to its path.
#[test]
fn an_unfolded_shape_is_planned_however_it_is_drawn() {
    let folder = folder();
    let height = (2.0_f64 / 3.0).sqrt();
    let corner = |k: u8| {
        let (sin, cos) = (2.0 * PI * f64::from(k) / 3.0 + 0.1).sin_cos();
        [cos, sin, 0.0].map(|x| x / 3.0_f64.sqrt())
    };
    let corners = [corner(0), corner(1), corner(2), [0.0, 0.0, height]];
    for (scale, places) in [(1.0, 15), (1.0, 4), (100.0, 2), (100.0, 6), (0.01, 6)] {
        let mut text = String::new();
        for corner in corners {
            let [x, y, z] = corner.map(|x| round(scale * x, places));
            writeln!(text, "v {x} {y} {z}").unwrap();
        }
        text += "f 1 3 2\nf 1 2 4\nf 2 3 4\nf 3 1 4\n";
        folder.write("shape.obj", &text);
        folder.done("unfold shape.obj -o net.fold --max-defect 1");
        let verdict = verdict(&folder, "net.fold");
        assert!(
            verdict.starts_with("planned"),
            "{scale} {places}: {verdict}"
        );
    }
}
