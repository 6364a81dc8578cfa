//! Builds a crease pattern from a drawing: performs every check and derives all further data.

use std::collections::{BTreeMap, HashMap, HashSet};
use std::sync::{Arc, OnceLock};

use nalgebra::Vector2;

use super::model::{CreasePattern, Edge, Geometry};
use super::split::{EdgeFaces, split};
use super::trace::area;
use super::triangulate::triangulate;
use super::{
    CreaseId, Drawing, DrawnEdge, EdgeId, EdgeNames, FaceId, Letter, PatternError, VertexId,
    nesting, planarity, trace,
};
use crate::util::csr::{Csr, group_by_key};
use crate::util::nan_max::median;
use crate::util::progress::Watch;

impl CreasePattern {
    /// Builds a crease pattern from a drawing. Cost: about linear.
    ///
    /// # Errors
    /// If the drawing is not a planar graph of simple faces, or contradicts itself.
    pub fn new(drawing: Drawing) -> Result<Self, PatternError> {
        Self::watched(drawing, Watch::default())
    }

    /// Builds a crease pattern as [`new`](Self::new) does, until the watch is over.
    pub(crate) fn watched(mut drawing: Drawing, watch: Watch<'_>) -> Result<Self, PatternError> {
        check_lists(&drawing)?;
        let mut assumptions = Vec::new();
        let places = checked_places(&drawing, &mut assumptions);
        planarity::check(&drawing, &places, watch)?;
        let mut stars = sorted_stars(&drawing);
        if lacks_inner_boundaries(&drawing, &stars, &places, watch)? {
            drawing.faces = None;
            assumptions.push(
                "faces_vertices has no place for inner boundaries: faces taken from the edges"
                    .into(),
            );
        }
        let (drawn, vertices) = (drawing.edges.len(), drawing.vertices.len());
        let mut faces = counter_clockwise_faces(&mut drawing, &stars, &mut assumptions, watch)?;
        if drawing.edges.len() > drawn {
            stars = sorted_stars(&drawing);
        }
        let mut edge_faces = edge_faces(&drawing, &stars, &faces, &places)?;
        order_twins(&drawing, &mut stars, &edge_faces);
        check_stars(&drawing, &stars, &edge_faces)?;
        let slits = split(&mut drawing, &mut faces, &mut edge_faces, &mut assumptions);
        if drawing.vertices.len() > vertices {
            stars = sorted_stars(&drawing);
            order_twins(&drawing, &mut stars, &edge_faces);
        }
        let (edges, creases) = resolve_letters(&drawing, &edge_faces, &mut assumptions);

        let corners = faces
            .iter()
            .enumerate()
            .flat_map(|(face, cycle)| cycle.iter().map(move |v| (v.index(), FaceId::new(face))));
        let corners = group_by_key(drawing.vertices.len(), corners);
        let real = real_vertices(&stars, &edges);
        let (triangles, diagonals) = panels(&drawing, &faces)?;
        let lengths = drawing.edges.iter().map(|e| length(&drawing, e.ends));
        let median_edge = median(lengths).unwrap_or_default();
        let along = |e: &DrawnEdge| {
            let [a, b] = e.ends.map(|end| drawing.vertices[end]);
            (b - a).normalize()
        };
        let mut geometry = Geometry {
            directions: drawing.edges.iter().map(along).collect(),
            vertices: drawing.vertices,
            edges,
            faces,
            creases,
            stars,
            real,
            corners,
            neighbours: Csr::default(),
            triangles,
            diagonals,
            median_edge,
            sheets: Vec::new(),
            holes: Csr::default(),
            tree: OnceLock::new(),
        };
        geometry.neighbours = geometry.find_neighbours();
        geometry.sheets = geometry.find_sheets();
        geometry.holes = geometry.find_holes();
        let mut pattern = Self {
            geometry: Arc::new(geometry),
            drawn,
            slits,
            assumptions,
            repairs: Vec::new(),
            lost: None,
            near: None,
            names: EdgeNames::new(),
            y_down: false,
            straightens_within: None,
            unit: None,
            precision: OnceLock::new(),
        };
        pattern.note_sheets();
        Ok(pattern)
    }

    /// Notes what is assumed of several sheets.
    fn note_sheets(&mut self) {
        let count = self.sheets();
        if count > 1 {
            self.assume(format!(
                "{count} sheets that no edge joins: the middle face of each stays where it is drawn"
            ));
        }
    }
}

/// Largest absolute value of a coordinate; its inverse is the length of the shortest edge.
pub(crate) const LARGEST: f64 = 1e50;

fn length(drawing: &Drawing, [a, b]: [usize; 2]) -> f64 {
    (drawing.vertices[b] - drawing.vertices[a]).norm()
}

fn check_lists(drawing: &Drawing) -> Result<(), PatternError> {
    let least = 3;
    for (key, found) in [
        ("vertices_coords", drawing.vertices.len()),
        ("edges_vertices", drawing.edges.len()),
    ] {
        if found < least {
            return Err(PatternError::TooFew { key, found, least });
        }
    }
    // The limit keeps squares and products of coordinates finite and above zero.
    let infinite = |p: &Vector2<f64>| p.iter().any(|c| c.is_nan() || c.abs() > LARGEST);
    if let Some(vertex) = drawing.vertices.iter().position(infinite) {
        return Err(PatternError::NotFinite { vertex });
    }
    let last = drawing.vertices.len() - 1;
    let known = |key, index, cycle: &[usize]| match cycle.iter().find(|&&v| v > last) {
        Some(&vertex) => Err(PatternError::NoVertex {
            key,
            index,
            vertex,
            last,
        }),
        None => Ok(()),
    };
    let duplicate = first_duplicate(drawing);
    for (edge, drawn) in drawing.edges.iter().enumerate() {
        known("edges_vertices", edge, &drawn.ends)?;
        if length(drawing, drawn.ends) < 1.0 / LARGEST {
            return Err(PatternError::NoLength { edge });
        }
        if let Some((_, other)) = duplicate.filter(|(later, _)| *later == edge) {
            return Err(PatternError::Duplicate { edge, other });
        }
        check_goal(edge, drawn.letter, drawn.goal)?;
    }
    for (face, cycle) in drawing.faces.iter().flatten().enumerate() {
        known("faces_vertices", face, cycle)?;
    }
    Ok(())
}

/// Returns the first edge that joins the same vertices as an earlier edge, and that earlier edge.
fn first_duplicate(drawing: &Drawing) -> Option<(usize, usize)> {
    let count = drawing.vertices.len();
    let edges = drawing.edges.iter().enumerate();
    let ends = edges.map(|(edge, drawn)| {
        let [a, b] = drawn.ends;
        (a.min(b), (a.max(b), edge))
    });
    let ends = ends.filter(|(_, (high, _))| *high < count);
    let mut by_low = group_by_key(count, ends);
    let mut first = None;
    for low in 0..count {
        let list = &mut by_low[low];
        list.sort_unstable();
        for pair in list.windows(2).filter(|pair| pair[0].0 == pair[1].0) {
            let [earlier, later] = [pair[0].1, pair[1].1];
            first = first.filter(|(first, _)| *first < later);
            first.get_or_insert((later, earlier));
        }
    }
    first
}

/// Checks that a hinge with this letter can turn to the goal angle (radians).
///
/// # Errors
/// If the angle is beyond half a turn or contradicts the letter.
pub(crate) fn check_goal(
    edge: usize,
    letter: Letter,
    goal: Option<f64>,
) -> Result<(), PatternError> {
    let Some(goal) = goal else {
        return Ok(());
    };
    let degrees = goal.to_degrees();
    // 180 degrees converted to radians and back may come out slightly above half a turn.
    if degrees.is_nan() || degrees.abs() > 180.0 * (1.0 + 4.0 * f64::EPSILON) {
        return Err(PatternError::GoalRange { edge, degrees });
    }
    if goal * letter.sign() < 0.0 {
        return Err(PatternError::GoalSign {
            edge,
            degrees,
            letter: letter.code(),
        });
    }
    Ok(())
}

/// Returns the edges at each vertex, counter-clockwise from direction -π.
fn sorted_stars(drawing: &Drawing) -> Csr<EdgeId> {
    let edges = drawing.edges.iter().enumerate();
    let ends = edges.flat_map(|(edge, drawn)| {
        let [a, b] = drawn.ends;
        let along = drawing.vertices[b] - drawing.vertices[a];
        let edge = EdgeId::new(edge);
        [(a, (turn(along), edge)), (b, (turn(-along), edge))]
    });
    let mut stars = group_by_key(drawing.vertices.len(), ends);
    for vertex in 0..stars.len() {
        stars[vertex].sort_unstable_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)));
    }
    stars.map(|(_, edge)| edge)
}

/// Returns the pseudo-angle of a direction (diamond angle): it grows with the angle from -2 at -π to 2 at π, where it
/// is -2 again.
fn turn(direction: Vector2<f64>) -> f64 {
    let x = direction.x / (direction.x.abs() + direction.y.abs());
    match direction.y {
        y if y < 0.0 => x - 1.0,
        _ if x > -1.0 => 1.0 - x,
        _ => -2.0,
    }
}

/// Returns the faces that the drawing names, or else those that its edges enclose, counter-clockwise.
fn counter_clockwise_faces(
    drawing: &mut Drawing,
    stars: &Csr<EdgeId>,
    assumptions: &mut Vec<String>,
    watch: Watch<'_>,
) -> Result<Csr<VertexId>, PatternError> {
    let mut faces = match drawing.faces.take() {
        Some(faces) => {
            let faces = faces.into_iter();
            faces.map(|f| f.into_iter().map(VertexId::new)).collect()
        }
        None => trace::faces(drawing, stars, assumptions, watch)?,
    };
    if faces.is_empty() {
        return Err(PatternError::TooFew {
            key: "faces_vertices",
            found: 0,
            least: 1,
        });
    }
    for face in 0..faces.len() {
        let cycle = &mut faces[face];
        let area = area(drawing, cycle.iter().copied());
        if cycle.len() < 3 || area.abs() <= 0.0 {
            return Err(no_area(face, cycle));
        }
        if area < 0.0 {
            cycle.reverse();
        }
    }
    Ok(faces)
}

/// Returns `true` if a drawing names faces that cannot be all of them: a face that goes along an edge twice to an inner
/// boundary, or a face in which other edges lie. Vertices that share a place say that the sheet is cut, and its faces are
/// taken as they are.
fn lacks_inner_boundaries(
    drawing: &Drawing,
    stars: &Csr<EdgeId>,
    places: &[usize],
    watch: Watch<'_>,
) -> Result<bool, PatternError> {
    let Some(faces) = &drawing.faces else {
        return Ok(false);
    };
    if places.iter().enumerate().any(|(vertex, &at)| vertex != at) {
        return Ok(false);
    }
    let mut met = HashSet::new();
    let repeats = |face: &Vec<usize>| {
        met.clear();
        let is_simple = face.iter().all(|&corner| met.insert(corner));
        // A face that names a corner twice in a row is wrong.
        let mut sides = face.iter().zip(face.iter().cycle().skip(1));
        !is_simple && sides.all(|(a, b)| a != b)
    };
    if faces.iter().any(repeats) {
        return Ok(true);
    }
    let components = nesting::components(drawing, stars, watch)?;
    if components.len() < 2 {
        return Ok(false);
    }
    // The sides of faces, each with the face on its left.
    let mut sides = HashSet::new();
    for face in faces {
        let is_clockwise = area(drawing, face.iter().copied().map(VertexId::new)) < 0.0;
        for (&a, &b) in face.iter().zip(face.iter().cycle().skip(1)) {
            sides.insert(if is_clockwise { [b, a] } else { [a, b] });
        }
    }
    // An edge without a face above it is on the outline of another component, which is asked in its turn.
    let lies_in_face = |below: usize| {
        let [a, b] = drawing.edges[below / 2].ends;
        sides.contains(&if below.is_multiple_of(2) {
            [a, b]
        } else {
            [b, a]
        })
    };
    let mut below = components.iter().filter_map(|component| component.below);
    Ok(below.any(lies_in_face))
}

/// Returns for each vertex the first vertex at its place. Vertices may share a place only if the drawing names its
/// faces, as on the two sides of a cut: then only the faces determine which parts are connected.
fn checked_places(drawing: &Drawing, assumptions: &mut Vec<String>) -> Vec<usize> {
    if drawing.faces.is_none() {
        return (0..drawing.vertices.len()).collect();
    }
    let places = places(&drawing.vertices);
    let places_of = places.iter().enumerate();
    let mut again = places_of.filter(|(vertex, place)| vertex != *place);
    if let Some((first, _)) = again.next() {
        assumptions.push(format!(
            "vertices at the place of another, the sheet taken as cut there: {} (first: vertex {first})",
            again.count() + 1
        ));
    }
    places
}

/// Returns for each vertex the first vertex at its place.
pub(crate) fn places(vertices: &[Vector2<f64>]) -> Vec<usize> {
    let mut first_at = HashMap::with_capacity(vertices.len());
    let places = vertices.iter().enumerate().map(|(vertex, point)| {
        // Adding 0 turns a negative zero into zero.
        let bits = [point.x, point.y].map(|c| (c + 0.0).to_bits());
        *first_at.entry(bits).or_insert(vertex)
    });
    places.collect()
}

/// Returns the faces to the left and right of each edge.
fn edge_faces(
    drawing: &Drawing,
    stars: &Csr<EdgeId>,
    faces: &Csr<VertexId>,
    places: &[usize],
) -> Result<EdgeFaces, PatternError> {
    // Searches the smaller of the two stars: over the edges of a planar graph these searches add up to linear time.
    let between = |a: usize, b: usize| {
        let [star, other] = [a, b].map(|vertex| &stars[vertex]);
        let star = if star.len() <= other.len() {
            star
        } else {
            other
        };
        let mut edges = star.iter().map(|edge| edge.index());
        edges.find(|&edge| [[a, b], [b, a]].contains(&drawing.edges[edge].ends))
    };
    let mut edge_faces = vec![[None; 2]; drawing.edges.len()];
    let shared = places.iter().enumerate().any(|(vertex, &at)| vertex != at);
    let mut sides = HashMap::new();
    for (face, cycle) in faces.iter().enumerate() {
        let shifted = cycle.iter().cycle().skip(1);
        for (a, b) in cycle.iter().zip(shifted) {
            let [a, b] = [a, b].map(|vertex| vertex.index());
            let edge = between(a, b).ok_or(PatternError::NoEdge { face, a, b })?;
            let side = usize::from(drawing.edges[edge].ends[0] != a);
            let place: &mut Option<FaceId> = &mut edge_faces[edge][side];
            let mut before = place.replace(FaceId::new(face));
            if shared {
                before = before.or(sides.insert([places[a], places[b]], FaceId::new(face)));
            }
            if let Some(first) = before {
                return Err(PatternError::Overlap {
                    edge,
                    first: first.index(),
                    second: face,
                });
            }
        }
    }
    Ok(edge_faces)
}

fn resolve_letters(
    drawing: &Drawing,
    edge_faces: &EdgeFaces,
    assumptions: &mut Vec<String>,
) -> (Vec<Edge>, Vec<EdgeId>) {
    let mut creases = Vec::new();
    let mut edges = Vec::with_capacity(drawing.edges.len());
    let mut outer: BTreeMap<Letter, (usize, usize)> = BTreeMap::new();
    let mut left_out = Vec::new();
    for (index, (drawn, &faces)) in drawing.edges.iter().zip(edge_faces).enumerate() {
        let mut letter = drawn.letter;
        let mut crease = None;
        if faces.iter().all(Option::is_some) {
            if letter.is_hinge() {
                crease = Some(CreaseId::new(creases.len()));
                creases.push(EdgeId::new(index));
            }
        } else if letter != Letter::Boundary {
            let (_, count) = outer.entry(letter).or_insert((index, 0_usize));
            *count += 1;
            letter = Letter::Boundary;
        }
        if crease.is_none() && drawn.goal.is_some_and(|goal| goal.abs() > 0.0) {
            left_out.push(index);
        }
        edges.push(Edge {
            ends: drawn.ends.map(VertexId::new),
            letter,
            faces,
            crease,
            goal: drawn.goal.filter(|_| crease.is_some()),
        });
    }
    for (letter, (first, count)) in outer {
        assumptions.push(format!(
            "edges lettered {} with a face on one side at most, taken as boundary: {count} (first: \
             edge {first})",
            letter.code()
        ));
    }
    if let Some(first) = left_out.first() {
        assumptions.push(format!(
            "goal angles of edges that are no hinges left out: {} (first: edge {first})",
            left_out.len()
        ));
    }
    (edges, creases)
}

/// Returns the faces to the left and right of an edge, looking along it from a vertex.
fn sides(
    drawing: &Drawing,
    edge_faces: &EdgeFaces,
    vertex: usize,
    edge: EdgeId,
) -> [Option<FaceId>; 2] {
    let [left, right] = edge_faces[edge.index()];
    if drawing.edges[edge.index()].ends[0] == vertex {
        [left, right]
    } else {
        [right, left]
    }
}

/// Orders the edges of a star that have the same direction, as the two sides of a cut have at the cut's end. In
/// counter-clockwise order the cut then lies between them.
fn order_twins(drawing: &Drawing, stars: &mut Csr<EdgeId>, edge_faces: &EdgeFaces) {
    for vertex in 0..stars.len() {
        let star = &mut stars[vertex];
        let far_end = |edge: EdgeId| {
            let [a, b] = drawing.edges[edge.index()].ends;
            drawing.vertices[if a == vertex { b } else { a }]
        };
        for k in 1..star.len() {
            let [a, b] = [star[k - 1], star[k]];
            if far_end(a) == far_end(b) && sides(drawing, edge_faces, vertex, a)[0].is_some() {
                star.swap(k - 1, k);
            }
        }
    }
}

/// Checks that consecutive edges round a vertex have the same face, or no face, between them.
fn check_stars(
    drawing: &Drawing,
    stars: &Csr<EdgeId>,
    edge_faces: &EdgeFaces,
) -> Result<(), PatternError> {
    for (vertex, star) in stars.iter().enumerate() {
        let sides = |edge: EdgeId| sides(drawing, edge_faces, vertex, edge);
        let next = star.iter().cycle().skip(1);
        if star
            .iter()
            .zip(next)
            .any(|(&a, &b)| sides(a)[0] != sides(b)[1])
        {
            return Err(PatternError::BrokenStar { vertex });
        }
    }
    Ok(())
}

/// Returns for each vertex `true` if it is inside the sheet: it has edges, and all have faces on both sides.
fn real_vertices(stars: &Csr<EdgeId>, edges: &[Edge]) -> Vec<bool> {
    let inside = |star: &[EdgeId]| {
        let mut edges = star.iter().map(|edge| &edges[edge.index()]);
        !star.is_empty() && edges.all(|edge| edge.inner_faces().is_some())
    };
    stars.iter().map(inside).collect()
}

/// Largest sum of the squared numbers of corners over all faces: triangulation takes as many steps, some seconds.
const MAX_TRIANGULATION_STEPS: usize = 1 << 30;

type Panels = (Csr<[VertexId; 3]>, Vec<[VertexId; 2]>);

fn panels(drawing: &Drawing, faces: &Csr<VertexId>) -> Result<Panels, PatternError> {
    let mut triangles = Csr::default();
    let mut diagonals = Vec::new();
    let mut steps = 0;
    for (face, cycle) in faces.iter().enumerate() {
        steps += cycle.len() * cycle.len();
        if steps > MAX_TRIANGULATION_STEPS {
            let corners = cycle.len();
            return Err(PatternError::Corners { face, corners });
        }
        let polygon: Vec<_> = cycle.iter().map(|v| drawing.vertices[v.index()]).collect();
        let cut = triangulate(&polygon).ok_or_else(|| no_area(face, cycle))?;
        let last = cut.len() - 1;
        // Each triangle but the last was cut off along the side between its first and third corner.
        for &[a, _, c] in &cut[..last] {
            diagonals.push([a, c].map(|corner| cycle[corner]));
        }
        triangles.push(cut.into_iter().map(|t| t.map(|c| cycle[c])));
    }
    Ok((triangles, diagonals))
}

fn no_area(face: usize, cycle: &[VertexId]) -> PatternError {
    let mut met = HashSet::new();
    let again = cycle.iter().find(|vertex| !met.insert(vertex.index()));
    let vertex = again.or(cycle.first()).map_or(0, |vertex| vertex.index());
    PatternError::NoArea { face, vertex }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn turns_are_in_the_order_of_angles() {
        let angles = (-180..180).map(|degrees: i32| f64::from(degrees).to_radians());
        let turns: Vec<f64> = angles
            .map(|angle| turn(3.0 * Vector2::new(angle.cos(), angle.sin())))
            .collect();
        assert!(turns.is_sorted_by(|a, b| a < b), "{turns:?}");
        // π and -π are one direction, for either sign of zero.
        let [left, back] = [0.0, -0.0].map(|y| turn(Vector2::new(-1.0, y)).to_bits());
        assert_eq!(left, back);
        assert_eq!(left, turns[0].to_bits());
    }

    /// The fifth edge repeats the second, and the sixth repeats the first; the error names the fifth.
    #[test]
    fn the_first_edge_that_is_drawn_twice_is_named() {
        let ends = [[0, 1], [1, 2], [2, 3], [3, 0], [2, 1], [0, 1]];
        let edge = |ends| DrawnEdge {
            ends,
            letter: Letter::Boundary,
            goal: None,
        };
        let drawing = Drawing {
            vertices: [[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]]
                .map(Vector2::from)
                .to_vec(),
            edges: ends.map(edge).to_vec(),
            faces: None,
        };
        let refused = CreasePattern::new(drawing).unwrap_err();
        assert_eq!(refused, PatternError::Duplicate { edge: 4, other: 1 });
    }
}
