//! Cuts out the essential crease pattern: the smallest part of the sheet in which the essential vertices are real.

use std::collections::{BTreeSet, HashSet, VecDeque};

use super::ReducedStars;
use crate::pattern::{
    CreaseId, CreasePattern, Drawing, DrawnEdge, FaceId, Letter, PatternError, VertexId,
};

/// Cuts out the essential crease pattern: a small part of the sheet in which a vertex for each essential condition of
/// `all` is real, without point contacts of its faces. Returns the part and, for each of its creases, the crease of the
/// whole sheet.
///
/// # Errors
/// Never for a valid pattern; otherwise the error of building the part.
pub fn essential_pattern(
    pattern: &CreasePattern,
    all: &ReducedStars,
) -> Result<(CreasePattern, Vec<CreaseId>), PatternError> {
    let mut faces = essential_faces(pattern, all);
    // Two faces of the part that meet in a point would split its vertex there, so the part grows until none do.
    while let Some(vertex) = meeting_point(pattern, &faces) {
        faces.extend(&pattern.corners()[vertex.index()]);
    }
    cut_out(pattern, &faces)
}

/// Returns a vertex at which the faces of the part are not one fan.
fn meeting_point(pattern: &CreasePattern, part: &BTreeSet<FaceId>) -> Option<VertexId> {
    let broken = |vertex: &VertexId| {
        let faces = pattern.corners()[vertex.index()].iter();
        let star = pattern.stars()[vertex.index()].iter();
        let inner = star.filter_map(|&edge| pattern.edge(edge).inner_faces());
        let joints = inner.filter(|faces| faces.iter().all(|face| part.contains(face)));
        joints.count() + 1 < faces.filter(|face| part.contains(face)).count()
    };
    let corners = part.iter().flat_map(|face| &pattern.faces()[face.index()]);
    corners.copied().find(broken)
}

/// Returns the faces round one vertex for each condition, found by breadth-first search from the first vertex, and the
/// faces round the vertices on the search tree's paths to them.
fn essential_faces(pattern: &CreasePattern, all: &ReducedStars) -> BTreeSet<FaceId> {
    let conditions = all.conditions();
    let Some(&start) = all.vertices().first() else {
        return (0..pattern.faces().len().min(1)).map(FaceId::new).collect();
    };
    let mut condition_at = vec![None; pattern.vertices().len()];
    for (vertex, &condition) in all.vertices().iter().zip(conditions) {
        condition_at[vertex.index()] = Some(condition);
    }
    let first = |index: &usize| conditions[*index] == *index;
    let mut missing: HashSet<usize> = (0..conditions.len()).filter(first).collect();
    let mut faces = BTreeSet::new();
    let mut taken = vec![false; pattern.vertices().len()];
    let mut before = vec![None; pattern.vertices().len()];
    before[start.index()] = Some(start);
    let mut open = VecDeque::from([start]);
    while let Some(vertex) = open.pop_front() {
        let condition = condition_at[vertex.index()];
        if condition.is_some_and(|condition| missing.remove(&condition)) {
            // Walks back to the start until it meets a vertex that an earlier walk took.
            let mut way = Some(vertex).filter(|v| !taken[v.index()]);
            while let Some(vertex) = way {
                taken[vertex.index()] = true;
                faces.extend(&pattern.corners()[vertex.index()]);
                way = before[vertex.index()].filter(|back: &VertexId| !taken[back.index()]);
            }
            if missing.is_empty() {
                break;
            }
        }
        for &edge in &pattern.stars()[vertex.index()] {
            let next = pattern.edge(edge).other_end(vertex);
            if before[next.index()].is_none() {
                before[next.index()] = Some(vertex);
                open.push_back(next);
            }
        }
    }
    faces
}

type Part = (CreasePattern, Vec<CreaseId>);

/// Makes the pattern of these faces alone.
fn cut_out(pattern: &CreasePattern, faces: &BTreeSet<FaceId>) -> Result<Part, PatternError> {
    let mut drawing = Drawing {
        faces: Some(Vec::new()),
        ..Drawing::default()
    };
    let mut new_vertex = vec![None; pattern.vertices().len()];
    let mut vertices = Vec::new();
    for face in faces {
        let cycle = pattern.faces()[face.index()].iter().map(|&vertex| {
            *new_vertex[vertex.index()].get_or_insert_with(|| {
                vertices.push(vertex);
                vertices.len() - 1
            })
        });
        let cycle = cycle.collect();
        drawing.faces.get_or_insert_default().push(cycle);
    }
    drawing.vertices = vertices
        .iter()
        .map(|v| pattern.vertices()[v.index()])
        .collect();
    let round = |vertex: &VertexId| pattern.stars()[vertex.index()].iter().copied();
    let edges: BTreeSet<_> = vertices.iter().flat_map(round).collect();
    let mut creases = Vec::new();
    for edge in edges {
        let edge = pattern.edge(edge);
        let sides = edge.faces.iter().flatten().filter(|f| faces.contains(f));
        let sides = sides.count();
        let ends = edge.ends.map(|end| new_vertex[end.index()]);
        if let (1.., [Some(a), Some(b)]) = (sides, ends) {
            drawing.edges.push(DrawnEdge {
                ends: [a, b],
                letter: if sides == 2 {
                    edge.letter
                } else {
                    Letter::Boundary
                },
                goal: edge.goal.filter(|_| sides == 2),
            });
            creases.extend(edge.crease.filter(|_| sides == 2));
        }
    }
    Ok((CreasePattern::new(drawing)?, creases))
}
