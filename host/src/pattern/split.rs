//! Splits vertices and edges where faces are not connected: along cuts, and at vertices where faces meet in a point
//! alone.

use std::collections::{HashMap, HashSet};

use super::{Drawing, DrawnEdge, EdgeId, FaceId, Letter, VertexId};
use crate::util::csr::{Csr, group_by_key};

/// The faces to the left and right of each edge.
pub(super) type EdgeFaces = Vec<[Option<FaceId>; 2]>;

/// Gives each fan of faces round a vertex its own vertex, and each side of a cut its own edge. The first fan and the
/// left side keep the drawn vertex and edge; new ones are appended behind all drawn ones. Adds notes of the splits to
/// `assumptions`. Returns the cuts along a single edge inside the sheet, which are hinges.
pub(super) fn split(
    drawing: &mut Drawing,
    faces: &mut Csr<VertexId>,
    edge_faces: &mut EdgeFaces,
    assumptions: &mut Vec<String>,
) -> Vec<EdgeId> {
    let drawn = drawing.edges.len();
    let fans = Fans::new(drawing, faces, edge_faces);
    let ends_in = |ends: [usize; 2], face: FaceId| ends.map(|end| fans.vertex(face, end));
    let (mut cuts, mut slits) = (Vec::new(), Vec::new());
    for edge in 0..drawn {
        let ends = drawing.edges[edge].ends;
        let [left, right] = edge_faces[edge];
        if let Some(face) = left.or(right) {
            drawing.edges[edge].ends = ends_in(ends, face);
        }
        let ([Some(_), Some(right)], true) = ([left, right], drawing.edges[edge].letter.parts())
        else {
            continue;
        };
        let other = ends_in(ends, right);
        if other == drawing.edges[edge].ends {
            // Both faces still share both ends: they can only turn about the line between these.
            drawing.edges[edge].letter = Letter::Unassigned;
            drawing.edges[edge].goal = None;
            slits.push(edge);
            continue;
        }
        cuts.push(edge);
        drawing.edges.push(DrawnEdge::boundary(other));
        edge_faces[edge] = [left, None];
        edge_faces.push([None, Some(right)]);
    }
    for face in 0..faces.len() {
        for corner in &mut faces[face] {
            *corner = VertexId::new(fans.vertex(FaceId::new(face), corner.index()));
        }
    }
    for &vertex in &fans.sources {
        drawing.vertices.push(drawing.vertices[vertex]);
    }
    let mut say = |list: &[usize], what: &str, part: &str| {
        if let Some(first) = list.first() {
            assumptions.push(format!("{what}: {} (first: {part} {first})", list.len()));
        }
    };
    let added = "the sheet is cut along edges lettered B or C between two faces";
    say(&cuts, added, "edge");
    let hinge = "cuts along a single edge inside the sheet, where the faces still hold both ends, \
                 taken as free hinges";
    say(&slits, hinge, "edge");
    say(
        &fans.points,
        "vertices where faces meet in a point alone, parted there",
        "vertex",
    );
    slits.into_iter().map(EdgeId::new).collect()
}

/// The fans of all vertices. A fan is a chain of faces round one vertex, each joined to the next by an edge.
#[derive(Default)]
struct Fans {
    /// The new vertex of a face, by the face and the drawn vertex that it replaces.
    moved: HashMap<(FaceId, usize), usize>,
    /// For each new vertex the drawn vertex that it replaces.
    sources: Vec<usize>,
    /// Vertices that were split although no cut ends there.
    points: Vec<usize>,
}

impl Fans {
    fn new(drawing: &Drawing, faces: &Csr<VertexId>, edge_faces: &EdgeFaces) -> Self {
        let vertices = drawing.vertices.len();
        let mut cut = vec![false; vertices];
        // A single fan of n faces has n - 1 joints, or n if it closes round the vertex.
        let mut missing = vec![-1_i64; vertices];
        for corner in faces.items() {
            missing[corner.index()] += 1;
        }
        for (edge, faces) in drawing.edges.iter().zip(edge_faces) {
            if faces.contains(&None) {
                continue;
            }
            for end in edge.ends {
                if edge.letter.parts() {
                    cut[end] = true;
                } else {
                    missing[end] -= 1;
                }
            }
        }
        let mut fans = Self::default();
        if missing.iter().all(|missing| *missing <= 0) {
            return fans;
        }
        let corners = (0..).zip(faces.iter());
        let corners = corners
            .flat_map(|(face, cycle)| cycle.iter().map(move |v| (v.index(), FaceId(face))))
            .filter(|(vertex, _)| missing[*vertex] > 0);
        let corners = group_by_key(vertices, corners);
        let joints = drawing.edges.iter().zip(edge_faces);
        let joints = joints
            .filter(|(edge, _)| !edge.letter.parts())
            .filter_map(|(edge, faces)| Some((edge.ends, [faces[0]?, faces[1]?])))
            .flat_map(|(ends, faces)| ends.map(|end| (end, faces)));
        let joints = group_by_key(vertices, joints);
        for vertex in 0..vertices {
            if missing[vertex] > 0 {
                fans.part(vertices, vertex, &corners[vertex], &joints[vertex]);
                if !cut[vertex] {
                    fans.points.push(vertex);
                }
            }
        }
        fans
    }

    /// Gives every fan at `vertex` but the first its own vertex.
    fn part(&mut self, drawn: usize, vertex: usize, faces: &[FaceId], joints: &[[FaceId; 2]]) {
        let mut beyond: HashMap<FaceId, Vec<FaceId>> = HashMap::new();
        for &[a, b] in joints {
            beyond.entry(a).or_default().push(b);
            beyond.entry(b).or_default().push(a);
        }
        let mut left: HashSet<FaceId> = faces.iter().copied().collect();
        let mut first = true;
        for &start in faces {
            if !left.remove(&start) {
                continue;
            }
            let mut fan = vec![start];
            let mut next = 0;
            while let Some(face) = fan.get(next) {
                next += 1;
                let others = beyond.get(face).into_iter().flatten();
                fan.extend(others.filter(|other| left.remove(other)));
            }
            if !first {
                let own = drawn + self.sources.len();
                self.sources.push(vertex);
                self.moved
                    .extend(fan.into_iter().map(|face| ((face, vertex), own)));
            }
            first = false;
        }
    }

    /// Returns the vertex of `face` that replaces the vertex `drawn`.
    fn vertex(&self, face: FaceId, drawn: usize) -> usize {
        if self.moved.is_empty() {
            return drawn;
        }
        self.moved.get(&(face, drawn)).copied().unwrap_or(drawn)
    }
}
