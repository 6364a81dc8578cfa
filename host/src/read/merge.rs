//! Tidies the faces of a shape: makes corners at the same place one, and leaves out what has no area.
//!
//! Vertices are found in a uniform hash grid whose cells are as wide as the merging distance.

use std::collections::{BTreeMap, HashMap};
use std::path::Path;

use nalgebra::Vector3;

use super::FileError;
use crate::pattern::Digits;
use crate::unfold::FoldedShape;
use crate::util::nan_max::largest;
use crate::util::union_find::UnionFind;

/// Largest distance between corners that are one, as a fraction of the shape's size, for coordinates of full precision.
const SAME_PLACE_RATIO: f64 = 1e-9;

/// Largest such distance in units of the last digit, for coordinates that were rounded.
const SAME_PLACE_UNITS: f64 = 2.0;

/// Largest such distance in units of the last bit of single precision. Programs that compute in it disagree in the last bits.
const SAME_PLACE_BITS: f64 = 4.0;

/// Bound on that distance, as a fraction of the shape's size.
const MAX_SAME_PLACE_RATIO: f64 = 1e-4;

/// Vertices of a shape that may be one.
#[derive(Clone, Copy, PartialEq, Eq)]
pub(super) enum Vertices {
    /// All at the same place, as in a file whose triangles have corners of their own.
    Separate,
    /// Those at the same place in parts that no face joins. If no two faces share a vertex, all at the same place.
    OfParts,
    /// Only those between which a side has no length.
    Shared,
}

/// Rounds coordinates to single precision if any has more digits than it holds. Programs that write STL compute in single
/// precision, whatever the number of digits that they write.
fn round_to_single(shape: &mut FoldedShape) {
    let is_long = |x: &f64| {
        let short: Option<f64> = format!("{x:.6e}").parse().ok();
        short.is_some_and(|short| short.to_bits() != x.to_bits())
    };
    let mut coordinates = shape.vertices.iter().flatten();
    if coordinates.any(is_long) {
        #[allow(clippy::cast_possible_truncation, reason = "rounds")]
        for x in shape.vertices.iter_mut().flatten() {
            *x = f64::from(*x as f32);
        }
    }
}

/// Returns the distance within which corners of a shape are at the same place: the precision of its coordinates. A file
/// `in_single` precision has coordinates of that precision, whatever its digits.
fn same_place(shape: &FoldedShape, in_single: bool) -> f64 {
    let size = shape.size();
    let apart = match shape.digits(|_| false) {
        Digits::Exact => 0.0,
        Digits::Decimal(unit) => SAME_PLACE_UNITS * unit,
        Digits::Single(unit) => SAME_PLACE_BITS * unit,
    };
    let far = shape.vertices.iter().map(|point| point.amax());
    let bit = match in_single {
        true => SAME_PLACE_BITS * f64::from(f32::EPSILON) * largest(far),
        false => 0.0,
    };
    let most = MAX_SAME_PLACE_RATIO * size;
    apart.max(bit).min(most).max(SAME_PLACE_RATIO * size)
}

/// Makes vertices at the same place one, leaves out corners that a face repeats and faces without an area, and tells so in
/// `notes`. `place` names a face of the file.
///
/// # Errors
/// If no face has an area.
pub(super) fn tidied(
    path: &Path,
    mut shape: FoldedShape,
    vertices: Vertices,
    place: impl Fn(usize) -> String,
    notes: &mut Vec<String>,
) -> Result<FoldedShape, FileError> {
    if vertices == Vertices::Separate {
        round_to_single(&mut shape);
    }
    let near = same_place(&shape, vertices == Vertices::Separate);
    match vertices {
        Vertices::Separate => merge_all(&mut shape, near, notes),
        Vertices::OfParts if !shares_vertices(&shape.faces) => merge_all(&mut shape, near, notes),
        Vertices::OfParts => merge_parts(&mut shape, near, notes),
        Vertices::Shared => {}
    }
    collapse(&mut shape, near, notes);
    let mut faces = Faces {
        near,
        numbers: (0..shape.faces.len()).collect(),
        at: HashMap::new(),
        shape,
    };
    faces.drop_repeated(&place, notes);
    let dropped = faces.drop_slivers();
    if let Some(&first) = dropped.first() {
        let what = "faces without an area, left out";
        let first = place(first);
        notes.push(format!("{what}: {} (first: {first})", dropped.len()));
        if faces.shape.faces.iter().all(Vec::is_empty) {
            let expected = "a face with at least 3 different vertices and an area";
            return Err(FileError::expected(path, first, expected, "none"));
        }
    }
    let mut shape = faces.shape;
    shape.faces.retain(|cycle| !cycle.is_empty());
    Ok(shape)
}

/// Returns `true` if any vertex belongs to two faces, or if there are fewer than two faces.
fn shares_vertices(faces: &[Vec<usize>]) -> bool {
    let last = faces.iter().flatten().max().map_or(0, |last| last + 1);
    let mut seen = vec![false; last];
    let mut twice = |&vertex: &usize| core::mem::replace(&mut seen[vertex], true);
    faces.len() < 2 || faces.iter().flatten().any(&mut twice)
}

/// Merges all vertices at the same place and numbers them in the order in which the faces refer to them.
fn merge_all(shape: &mut FoldedShape, near: f64, notes: &mut Vec<String>) {
    let mut places = Places::new(near);
    let mut names = vec![usize::MAX; shape.vertices.len()];
    let mut corners = 0_usize;
    for corner in shape.faces.iter_mut().flatten() {
        let name = &mut names[*corner];
        if *name == usize::MAX {
            *name = places.name(shape.vertices[*corner]);
            corners += 1;
        }
        *corner = *name;
    }
    for end in shape.edges.iter_mut().flat_map(|edge| &mut edge.ends) {
        let name = &mut names[*end];
        if *name == usize::MAX {
            *name = places.name(shape.vertices[*end]);
        }
        *end = *name;
    }
    places.say(corners, notes);
    shape.vertices = places.points;
}

/// Merges vertices at the same place that belong to different parts of the shape, unless an edge then has more than two
/// faces. Tells of other vertices at the same place.
fn merge_parts(shape: &mut FoldedShape, near: f64, notes: &mut Vec<String>) {
    let count = shape.vertices.len();
    let mut parts = UnionFind::new(count);
    for cycle in &shape.faces {
        for pair in cycle.windows(2) {
            parts.join([pair[0], pair[1]]);
        }
    }
    let mut used = vec![false; count];
    for &corner in shape.faces.iter().flatten() {
        used[corner] = true;
    }
    let mut places = Places::new(near);
    let mut at: BTreeMap<usize, Vec<usize>> = BTreeMap::new();
    for vertex in (0..count).filter(|&vertex| used[vertex]) {
        let place = places.name(shape.vertices[vertex]);
        at.entry(place).or_default().push(vertex);
    }
    let mut names: Vec<usize> = (0..count).collect();
    let (mut merged, mut apart) = (0_usize, None);
    for vertices in at.values().filter(|vertices| vertices.len() > 1) {
        let mut of_parts: Vec<_> = vertices.iter().map(|&v| parts.find(v)).collect();
        of_parts.sort_unstable();
        of_parts.dedup();
        if of_parts.len() < vertices.len() {
            apart = apart.or(Some([vertices[0], vertices[1]]));
            continue;
        }
        for &vertex in vertices {
            names[vertex] = vertices[0];
        }
        merged += vertices.len() - 1;
    }
    let renamed = |cycle: &Vec<usize>| cycle.iter().map(|&v| names[v]).collect();
    let faces: Vec<Vec<usize>> = shape.faces.iter().map(renamed).collect();
    if merged > 0 && !has_branching(&faces) {
        shape.faces = faces;
        for end in shape.edges.iter_mut().flat_map(|edge| &mut edge.ends) {
            *end = names[*end];
        }
        notes.push(format!(
            "vertices of parts that no face joins, at the same place to within {near:.1e}, made one: {merged} less; what \
             merely touches is joined thereby"
        ));
    }
    // A file with creases is one of a sheet, whose layers lie on each other.
    if let (Some([a, b]), true) = (apart, shape.edges.is_empty()) {
        notes.push(format!(
            "different vertices at the same place, such as {a} and {b}, counted from 0: taken for different points of the \
             paper"
        ));
    }
}

/// Returns `true` if more than two faces meet at an edge.
fn has_branching(faces: &[Vec<usize>]) -> bool {
    let mut counts: HashMap<[usize; 2], usize> = HashMap::new();
    faces.iter().flat_map(|cycle| sides(cycle)).any(|side| {
        let count = counts.entry(key(side)).or_default();
        *count += 1;
        *count > 2
    })
}

/// Makes the ends of sides without length one.
fn collapse(shape: &mut FoldedShape, near: f64, notes: &mut Vec<String>) {
    let mut ends = UnionFind::new(shape.vertices.len());
    let mut collapsed = 0_usize;
    for [a, b] in shape.faces.iter().flat_map(|cycle| sides(cycle)) {
        let apart = (shape.vertices[b] - shape.vertices[a]).norm();
        if apart <= near && !ends.are_joined([a, b]) {
            ends.join_to_smaller([a, b]);
            collapsed += 1;
        }
    }
    if collapsed == 0 {
        return;
    }
    notes.push(format!(
        "sides of faces no longer than {near:.1e}, whose ends are made one: {collapsed}"
    ));
    let names = ends.representatives();
    let corners = shape.faces.iter_mut().flatten();
    let edges = shape.edges.iter_mut().flat_map(|edge| &mut edge.ends);
    corners
        .chain(edges)
        .for_each(|corner| *corner = names[*corner]);
    shape.edges.retain(|edge| edge.ends[0] != edge.ends[1]);
}

fn key([a, b]: [usize; 2]) -> [usize; 2] {
    [a.min(b), a.max(b)]
}

/// Returns the sides of a face.
fn sides(cycle: &[usize]) -> impl Iterator<Item = [usize; 2]> {
    let next = cycle.iter().cycle().skip(1);
    cycle.iter().zip(next).map(|(&a, &b)| [a, b])
}

/// Faces from which some are left out; these are empty.
struct Faces {
    shape: FoldedShape,
    /// Width up to which a face has no area.
    near: f64,
    numbers: Vec<usize>,
    /// Faces at each side.
    at: HashMap<[usize; 2], Vec<usize>>,
}

impl Faces {
    /// Leaves out corners that repeat the one before, and ways to a corner and straight back.
    fn drop_repeated(&mut self, place: &impl Fn(usize) -> String, notes: &mut Vec<String>) {
        let (mut corners, mut first) = (0, None);
        for &face in &self.numbers {
            let cycle = &mut self.shape.faces[face];
            let before = cycle.len();
            while let Some(corner) = repeated(cycle) {
                cycle.remove(corner);
            }
            if cycle.len() < before && cycle.len() > 2 {
                corners += before - cycle.len();
                first = first.or(Some(face));
            }
        }
        if let Some(first) = first {
            let what = "corners that a face repeats, left out";
            notes.push(format!("{what}: {corners} (first: {})", place(first)));
        }
    }

    /// Leaves out faces that are no wider than the precision of the coordinates, and returns their numbers. Faces beyond
    /// the sides of such a face meet afterwards: each gets the corners that lie on its side.
    fn drop_slivers(&mut self) -> Vec<usize> {
        let numbers = core::mem::take(&mut self.numbers);
        let slivers: Vec<usize> = numbers
            .into_iter()
            .filter(|&face| self.is_sliver(face))
            .collect();
        if slivers.is_empty() {
            return slivers;
        }
        for (face, cycle) in self.shape.faces.iter().enumerate() {
            for side in sides(cycle) {
                self.at.entry(key(side)).or_default().push(face);
            }
        }
        for &sliver in &slivers {
            let cycle = core::mem::take(&mut self.shape.faces[sliver]);
            for side in sides(&cycle) {
                if let Some(faces) = self.at.get_mut(&key(side)) {
                    faces.retain(|face| *face != sliver);
                }
            }
            for side in sides(&cycle) {
                let between = self.between(side, &cycle);
                if !between.is_empty() {
                    self.insert(side, &between);
                }
            }
        }
        slivers
    }

    /// Returns `true` if a face has no area to within the precision of its coordinates.
    fn is_sliver(&self, face: usize) -> bool {
        let cycle = &self.shape.faces[face];
        let Some(&origin) = cycle.first().filter(|_| cycle.len() > 2) else {
            return true;
        };
        let arm = |v: usize| self.shape.vertices[v] - self.shape.vertices[origin];
        let twice_area: Vector3<f64> = sides(cycle).map(|[a, b]| arm(a).cross(&arm(b))).sum();
        let longest = largest(sides(cycle).map(|[a, b]| (arm(b) - arm(a)).norm()));
        let extent = longest.max(largest(cycle.iter().map(|&v| arm(v).norm())));
        twice_area.norm() <= self.near * extent
    }

    /// Returns the corners of a sliver that lie between the ends of one of its sides, in the order from the first end.
    fn between(&self, [a, b]: [usize; 2], cycle: &[usize]) -> Vec<usize> {
        let [from, to] = [a, b].map(|end| self.shape.vertices[end]);
        let squared = (to - from).norm_squared();
        let fraction = |v: usize| (self.shape.vertices[v] - from).dot(&(to - from)) / squared;
        let others = cycle.iter().copied().filter(|v| ![a, b].contains(v));
        let mut between: Vec<usize> = others
            .filter(|&v| (0.0..1.0).contains(&fraction(v)))
            .collect();
        between.sort_by(|&v, &w| fraction(v).total_cmp(&fraction(w)));
        between.dedup();
        between
    }

    /// Inserts corners into the faces at a side, in the order from its first end.
    fn insert(&mut self, [a, b]: [usize; 2], between: &[usize]) {
        for face in self.at.remove(&key([a, b])).unwrap_or_default() {
            let cycle = &mut self.shape.faces[face];
            let is_side = |(_, side): &(usize, [usize; 2])| key(*side) == key([a, b]);
            let Some((at, [start, _])) = sides(cycle).enumerate().find(is_side) else {
                continue;
            };
            let mut new: Vec<usize> = between
                .iter()
                .copied()
                .filter(|v| !cycle.contains(v))
                .collect();
            if start != a {
                new.reverse();
            }
            cycle.splice(at + 1..at + 1, new.iter().copied());
            let chain = [
                &[if start == a { a } else { b }],
                &new[..],
                &[if start == a { b } else { a }],
            ]
            .concat();
            for side in chain.windows(2) {
                self.at
                    .entry(key([side[0], side[1]]))
                    .or_default()
                    .push(face);
            }
        }
    }
}

/// Returns a corner of a cycle that is the same as the one before, or between two that are the same.
fn repeated(cycle: &[usize]) -> Option<usize> {
    let count = cycle.len();
    let at = |k: usize| cycle[k % count];
    let again = (0..count).find(|&k| count > 1 && at(k) == at(k + count - 1));
    let back = || (0..count).find(|&k| count > 2 && at(k + 1) == at(k + count - 1));
    again.or_else(back)
}

/// Distinct places in space, in a hash grid whose cells are as wide as the merging distance `near`.
#[derive(Default)]
struct Places {
    near: f64,
    cells: HashMap<[i64; 3], Vec<usize>>,
    /// Numbers of the places by the bits of their coordinates: a fast path, as coincident vertices mostly have equal
    /// bits.
    exact: HashMap<[u64; 3], usize>,
    points: Vec<Vector3<f64>>,
    /// Largest distance between two points that were merged.
    widest: f64,
}

impl Places {
    fn new(near: f64) -> Self {
        Self {
            near,
            ..Self::default()
        }
    }

    /// Notes how many of the `corners` were merged.
    fn say(&self, corners: usize, notes: &mut Vec<String>) {
        if self.points.len() < corners {
            notes.push(format!(
                "vertices at the same place to within {:.1e} made one: {corners} are {} (farthest apart \
                 {:.1e}); what merely touches is joined thereby",
                self.near,
                self.points.len(),
                self.widest,
            ));
        }
    }

    /// Returns the number of a place, adding the place if it is new.
    fn name(&mut self, point: Vector3<f64>) -> usize {
        let bits = point.map(f64::to_bits).into();
        if let Some(&known) = self.exact.get(&bits) {
            return known;
        }
        let name = self.near_name(point);
        self.exact.insert(bits, name);
        name
    }

    /// Returns the number of a place whose coordinates have not occurred before bit by bit.
    fn near_name(&mut self, point: Vector3<f64>) -> usize {
        #[allow(
            clippy::cast_possible_truncation,
            reason = "saturates: shared cells cost time alone"
        )]
        let cell = point.map(|c| (c / self.near.max(f64::MIN_POSITIVE)).floor() as i64);
        for around in 0..27 {
            let step = |k: u32| i64::from(around / 3_u32.pow(k) % 3) - 1;
            let key = [0, 1, 2].map(|k| cell[k as usize].saturating_add(step(k)));
            for &known in self.cells.get(&key).into_iter().flatten() {
                let apart = (self.points[known] - point).norm();
                if apart <= self.near {
                    self.widest = self.widest.max(apart);
                    return known;
                }
            }
        }
        self.points.push(point);
        let name = self.points.len() - 1;
        self.cells.entry(cell.into()).or_default().push(name);
        name
    }
}
