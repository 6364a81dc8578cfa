//! Writes crease patterns and paths.
//!
//! One key, and in paths one frame, a line: large files stay readable and differ line by line.

use foldpath_core::Interpolation;
use serde::Serialize;

use super::animation::interpolation_name;
use crate::pattern::{CreasePattern, Drawing};
use crate::planner::Path;

/// Keys and values of a FOLD object, in order.
#[derive(Default)]
struct Object(Vec<String>);

impl Object {
    fn set(&mut self, key: &str, value: &(impl Serialize + ?Sized)) -> &mut Self {
        // Numbers, strings and lists of them: nothing that JSON cannot hold.
        let value = serde_json::to_string(value).unwrap_or_else(|_| "null".into());
        self.0.push(format!("\"{key}\":{value}"));
        self
    }

    fn set_lines(&mut self, key: &str, lines: &[String]) -> &mut Self {
        self.0
            .push(format!("\"{key}\":[\n{}\n]", lines.join(",\n")));
        self
    }

    fn text(&self) -> String {
        format!("{{\n{}\n}}\n", self.0.join(",\n"))
    }

    fn line(&self) -> String {
        format!("{{{}}}", self.0.join(","))
    }
}

/// Radians as the number of degrees that is written: 180 for π, and no negative zero.
fn degrees(radians: f64) -> f64 {
    radians.to_degrees() + 0.0
}

/// A crease pattern with its goal angles as a FOLD file.
#[must_use]
pub fn pattern_text(title: &str, drawing: &Drawing) -> String {
    let mut file = Object::default();
    header(&mut file, title, "singleModel");
    let vertices: Vec<[f64; 2]> = drawing.vertices.iter().map(|&v| v.into()).collect();
    let edges: Vec<[usize; 2]> = drawing.edges.iter().map(|e| e.ends).collect();
    let letters: Vec<char> = drawing.edges.iter().map(|e| e.letter.code()).collect();
    let goals = drawing.edges.iter().map(|e| e.goal.map_or(0.0, degrees));
    file.set("vertices_coords", &vertices)
        .set("edges_vertices", &edges)
        .set("edges_assignment", &letters)
        .set("edges_foldAngle", &goals.collect::<Vec<_>>());
    file.text()
}

fn header(file: &mut Object, title: &str, class: &str) {
    file.set("file_spec", &1.2)
        .set(
            "file_creator",
            concat!("foldpath ", env!("CARGO_PKG_VERSION")),
        )
        .set("file_classes", &[class])
        .set("file_title", title)
        .set("frame_classes", &["creasePattern"])
        .set("frame_attributes", &["2D"]);
}

/// Writes paths of one sheet.
pub struct PathWriter<'a> {
    /// The file's title.
    pub title: &'a str,
    /// The flat sheet.
    pub pattern: &'a CreasePattern,
    /// Whether to write the positions of the vertices in every knot.
    pub vertices: bool,
    /// The seed that the path was planned with.
    pub seed: u64,
}

impl PathWriter<'_> {
    /// The path as a FOLD animation.
    #[must_use]
    pub fn text(&self, path: &Path) -> String {
        let pattern = self.pattern;
        let mut file = Object::default();
        header(&mut file, self.title, "animation");
        let vertices: Vec<[f64; 2]> = pattern.vertices().iter().map(|&v| v.into()).collect();
        let edges = pattern.edges();
        let ends: Vec<[u32; 2]> = edges.iter().map(|e| e.ends.map(|v| v.0)).collect();
        let letters: Vec<char> = edges.iter().map(|e| e.letter.code()).collect();
        let faces = pattern.faces().iter();
        let faces: Vec<Vec<u32>> = faces.map(|f| f.iter().map(|v| v.0).collect()).collect();
        let membership = edges
            .iter()
            .map(|e| Some(path.memberships[e.crease?.index()]));
        let groups = membership.clone().map(|m| m.map(|m| m.group.0));
        let signs = membership.map(|m| m.map_or(0, |m| if m.negative { -1 } else { 1 }));
        file.set("vertices_coords", &vertices)
            .set("edges_vertices", &ends)
            .set("edges_assignment", &letters)
            .set("faces_vertices", &faces)
            .set(
                "foldpath:interpolation",
                interpolation_name(path.interpolation),
            )
            .set("foldpath:edges_group", &groups.collect::<Vec<_>>())
            .set("foldpath:edges_sign", &signs.collect::<Vec<_>>())
            .set("foldpath:seed", &self.seed);
        let frames: Vec<String> = path
            .knots
            .iter()
            .map(|knot| self.frame(path, knot))
            .collect();
        file.set_lines("file_frames", &frames);
        file.text()
    }

    fn frame(&self, path: &Path, knot: &crate::planner::Knot) -> String {
        let spread = |groups: &[f64]| -> Vec<f64> {
            let edges = self.pattern.edges().iter();
            edges
                .map(|edge| {
                    let crease = edge.crease.map(|crease| path.memberships[crease.index()]);
                    degrees(crease.map_or(0.0, |m| m.apply(groups[m.group.index()])))
                })
                .collect()
        };
        let mut frame = Object::default();
        frame
            .set("frame_classes", &["foldedForm"])
            .set("frame_attributes", &["3D"])
            .set("frame_parent", &0)
            .set("frame_inherit", &true)
            .set("foldpath:time", &knot.time);
        if self.vertices {
            let vertices: Vec<[f64; 3]> = knot.vertices.iter().map(|&v| v.into()).collect();
            frame.set("vertices_coords", &vertices);
        }
        frame
            .set("edges_foldAngle", &spread(&knot.angles))
            .set("foldpath:edges_foldAngleRate", &spread(&knot.rates));
        if path.interpolation == Interpolation::Homogeneous {
            let [weights, rates] = [0, 1].map(|part| self.weights(path, knot, part));
            frame
                .set("foldpath:edges_weight", &weights)
                .set("foldpath:edges_weightRate", &rates);
        }
        frame
            .set("foldpath:deformation", &knot.deformation)
            .set("foldpath:gap", &knot.gap)
            .set("foldpath:closure", &knot.closure)
            .set("foldpath:clearance", &None::<f64>);
        frame.line()
    }

    /// For each edge its weight (part 0) or the rate of that (part 1); `None` where it is no hinge.
    fn weights(&self, path: &Path, knot: &crate::planner::Knot, part: usize) -> Vec<Option<f64>> {
        let edges = self.pattern.edges().iter();
        edges
            .map(|edge| {
                let group = path.memberships[edge.crease?.index()].group;
                Some(knot.weights.get(group.index())?[part])
            })
            .collect()
    }
}
