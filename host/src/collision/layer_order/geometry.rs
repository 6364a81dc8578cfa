//! Finds the rules that the order of the faces has to keep, from where each face lies in the plane.

use core::f64::consts::FRAC_PI_2;

use nalgebra::Vector2;

use super::search::{Literal, Rule};
use crate::collision::convex::is_convex;
use crate::folding::FoldingMap;
use crate::pattern::{CreasePattern, Edge, EdgeId, FaceId, VertexId};

/// A sheet that lies flat.
pub(super) struct FlatSheet<'a> {
    pattern: &'a CreasePattern,
    map: FoldingMap,
    fold_angles: &'a [f64],
    margin: f64,
    layers: Vec<Layer>,
}

/// Faces of the sheet, numbered from 0, and the edges between them.
pub(super) struct Stack<'a> {
    margin: f64,
    numbers: Vec<FaceId>,
    layers: Vec<&'a Layer>,
    hinges: Vec<FlatHinge>,
    /// The pairs of faces that overlap, sorted.
    pairs: Vec<[usize; 2]>,
    /// First pair of each face, and the number of all.
    starts: Vec<usize>,
}

/// A face where it lies.
struct Layer {
    /// The convex polygon, counter-clockwise, made smaller by the margin all round; empty if nothing is left, or the face
    /// is not convex.
    inner: Vec<Vector2<f64>>,
    bounds: [Vector2<f64>; 2],
    is_face_up: bool,
}

/// An edge between two faces where it lies.
struct FlatHinge {
    faces: [usize; 2],
    ends: [Vector2<f64>; 2],
    /// Fold angle, radians.
    angle: f64,
}

impl FlatHinge {
    fn is_folded(&self) -> bool {
        self.angle.abs() > FRAC_PI_2
    }
}

impl<'a> FlatSheet<'a> {
    /// Takes a sheet folded by a map. Points closer than `margin`, units of the sheet, may be in another order.
    pub(super) fn new(
        pattern: &'a CreasePattern,
        map: FoldingMap,
        fold_angles: &'a [f64],
        margin: f64,
    ) -> Self {
        let faces = 0..pattern.faces().len();
        let layers = faces.map(|face| Layer::new(pattern, &map, face, margin));
        Self {
            layers: layers.collect(),
            pattern,
            map,
            fold_angles,
            margin,
        }
    }

    /// Takes some of the faces, and of these edges those between them.
    pub(super) fn stack(
        &self,
        faces: impl IntoIterator<Item = FaceId>,
        edges: impl IntoIterator<Item = EdgeId>,
    ) -> Stack<'_> {
        let mut numbers: Vec<FaceId> = faces.into_iter().collect();
        numbers.sort_unstable();
        numbers.dedup();
        let edges = edges.into_iter();
        let hinges = edges.filter_map(|edge| self.hinge(self.pattern.edge(edge), &numbers));
        let hinges = hinges.collect();
        let layers: Vec<&Layer> = numbers.iter().map(|it| &self.layers[it.index()]).collect();
        let mut pairs = Vec::new();
        let mut starts = Vec::with_capacity(layers.len() + 1);
        for (a, one) in layers.iter().enumerate() {
            starts.push(pairs.len());
            let others = layers.iter().enumerate().skip(a + 1);
            let over = others.filter(|(_, other)| one.overlaps(other));
            pairs.extend(over.map(|(b, _)| [a, b]));
        }
        starts.push(pairs.len());
        Stack {
            margin: self.margin,
            numbers,
            layers,
            hinges,
            pairs,
            starts,
        }
    }

    /// Returns an edge between two of some faces, sorted, where it lies.
    fn hinge(&self, edge: &Edge, numbers: &[FaceId]) -> Option<FlatHinge> {
        let faces = edge.inner_faces().filter(|_| !edge.letter.parts())?;
        let number = |face: FaceId| numbers.binary_search(&face).ok();
        let pose = &self.map.poses()[faces[0].index()];
        let place = |vertex: VertexId| pose.apply(self.pattern.vertices()[vertex.index()]).xy();
        Some(FlatHinge {
            faces: [number(faces[0])?, number(faces[1])?],
            ends: edge.ends.map(place),
            angle: edge
                .crease
                .map_or(0.0, |crease| self.fold_angles[crease.index()]),
        })
    }
}

impl Stack<'_> {
    /// Returns the number of faces.
    pub(super) fn faces(&self) -> usize {
        self.numbers.len()
    }

    /// Returns a face of the sheet by its number here.
    pub(super) fn face(&self, number: usize) -> FaceId {
        self.numbers[number]
    }

    /// Returns the number of pairs of faces that overlap.
    pub(super) fn pairs(&self) -> usize {
        self.pairs.len()
    }

    /// Returns the faces of a pair.
    pub(super) fn faces_of(&self, pair: usize) -> [usize; 2] {
        self.pairs[pair]
    }

    /// Returns the statement that face `a` is above face `b`; `None` if they do not overlap.
    fn above(&self, a: usize, b: usize) -> Option<Literal> {
        let [low, high] = [a.min(b), a.max(b)];
        let range = self.starts[low]..self.starts[low + 1];
        let at = self.pairs[range.clone()].binary_search(&[low, high]).ok()?;
        Some(Literal {
            pair: range.start + at,
            is_reversed: a > b,
        })
    }

    /// Returns all that is known of the order; `None` if there are more rules than `most`.
    pub(super) fn rules(&self, most: usize) -> Option<Vec<Rule>> {
        let mut rules = Vec::new();
        if self.pairs.len() > most {
            return None;
        }
        self.add_letters(&mut rules);
        self.add_covered(&mut rules);
        self.add_collinear(&mut rules);
        self.add_triples(&mut rules, most);
        (rules.len() <= most).then_some(rules)
    }

    /// A valley folds the second face over the front of the first.
    fn add_letters(&self, rules: &mut Vec<Rule>) {
        for hinge in self.hinges.iter().filter(|hinge| hinge.is_folded()) {
            let [a, b] = hinge.faces;
            let is_above = (hinge.angle > 0.0) == self.layers[a].is_face_up;
            rules.extend(self.above(b, a).map(|above| Rule::is(above, is_above)));
        }
    }

    /// A face that covers a part of a hinge is above both of its faces, or below both.
    fn add_covered(&self, rules: &mut Vec<Rule>) {
        for hinge in &self.hinges {
            for (face, layer) in self.layers.iter().enumerate() {
                if hinge.faces.contains(&face) || !layer.covers(hinge, self.margin) {
                    continue;
                }
                let [a, b] = hinge.faces.map(|other| self.above(face, other));
                rules.extend(a.zip(b).map(|(a, b)| Rule::alike(a, b)));
            }
        }
    }

    /// Two hinges with a part of a line in common.
    fn add_collinear(&self, rules: &mut Vec<Rule>) {
        for (k, one) in self.hinges.iter().enumerate() {
            for other in &self.hinges[k + 1..] {
                let are_apart = one.faces.iter().all(|face| !other.faces.contains(face));
                if !are_apart || !one.is_along(other, self.margin) {
                    continue;
                }
                let [[a, b], [c, d]] = [one.faces, other.faces];
                let above = [[a, c], [b, d], [a, d], [b, c]].map(|[x, y]| self.above(x, y));
                match (one.is_folded(), other.is_folded()) {
                    // Each face is between the other two, or neither is. Faces on opposite sides do not overlap.
                    (true, true) => {
                        if let [Some(ac), Some(bd), Some(ad), Some(bc)] = above {
                            rules.push(Rule::even([ac, bd, ad, bc]));
                        }
                    }
                    (false, false) => {
                        let [ac, bd, ad, bc] = above;
                        rules.extend(ac.zip(bd).map(|(x, y)| Rule::alike(x, y)));
                        rules.extend(ad.zip(bc).map(|(x, y)| Rule::alike(x, y)));
                    }
                    (true, false) => {
                        let [ac, bd, ad, bc] = above;
                        rules.extend(ac.zip(bc).map(|(x, y)| Rule::alike(x, y)));
                        rules.extend(ad.zip(bd).map(|(x, y)| Rule::alike(x, y)));
                    }
                    (false, true) => {
                        let [ac, bd, ad, bc] = above;
                        rules.extend(ac.zip(ad).map(|(x, y)| Rule::alike(x, y)));
                        rules.extend(bd.zip(bc).map(|(x, y)| Rule::alike(x, y)));
                    }
                }
            }
        }
    }

    /// Three faces with a point in common. Ends once there are more rules than `most`.
    fn add_triples(&self, rules: &mut Vec<Rule>, most: usize) {
        for (pair, &[a, b]) in self.pairs.iter().enumerate() {
            let common = self.layers[a].common(self.layers[b]);
            for other in pair + 1..self.starts[a + 1] {
                let [_, c] = self.pairs[other];
                let Some(bc) = self.above(b, c) else { continue };
                if !clipped(common.clone(), &self.layers[c].inner).is_empty() {
                    let [ab, ca] = [(pair, false), (other, true)]
                        .map(|(pair, is_reversed)| Literal { pair, is_reversed });
                    rules.push(Rule::not_alike([ab, bc, ca]));
                }
            }
            if rules.len() > most {
                return;
            }
        }
    }
}

impl Layer {
    fn new(pattern: &CreasePattern, map: &FoldingMap, face: usize, margin: f64) -> Self {
        let cycle = &pattern.faces()[face];
        let pose = &map.poses()[face];
        let is_face_up = pose.normal().z > 0.0;
        let mut corners: Vec<Vector2<f64>> = cycle
            .iter()
            .map(|v| pose.apply(pattern.vertices()[v.index()]).xy())
            .collect();
        if !is_face_up {
            corners.reverse();
        }
        let inner = if is_convex(pattern, cycle) {
            sides(&corners).fold(corners.clone(), |inner, side| cut(&inner, side, margin))
        } else {
            Vec::new()
        };
        let fold = |by: fn(&Vector2<f64>, &Vector2<f64>) -> Vector2<f64>| {
            let mut all = inner.iter().copied();
            let first = all.next().unwrap_or_default();
            all.fold(first, |a, b| by(&a, &b))
        };
        Self {
            bounds: [fold(Vector2::inf), fold(Vector2::sup)],
            inner,
            is_face_up,
        }
    }

    fn bounds_meet(&self, [low, high]: &[Vector2<f64>; 2]) -> bool {
        let [from, to] = &self.bounds;
        !self.inner.is_empty()
            && (0..2).all(|axis| from[axis] <= high[axis] && low[axis] <= to[axis])
    }

    fn overlaps(&self, other: &Self) -> bool {
        self.bounds_meet(&other.bounds) && !self.common(other).is_empty()
    }

    /// Returns what two faces have in common.
    fn common(&self, other: &Self) -> Vec<Vector2<f64>> {
        clipped(self.inner.clone(), &other.inner)
    }

    /// Returns `true` if a part of a hinge longer than `margin` is inside this face.
    fn covers(&self, hinge: &FlatHinge, margin: f64) -> bool {
        let [from, to] = hinge.ends;
        if !self.bounds_meet(&[from.inf(&to), from.sup(&to)]) {
            return false;
        }
        // A line is a polygon with two corners. What is left of it begins with the corner nearest to its start.
        let part = clipped(vec![from, to], &self.inner);
        part.iter().any(|corner| (corner - part[0]).norm() > margin)
    }
}

impl FlatHinge {
    /// Returns `true` if two hinges lie on a line up to `margin`, and overlap there by more than four margins.
    fn is_along(&self, other: &Self, margin: f64) -> bool {
        let way = self.ends[1] - self.ends[0];
        let length = way.norm();
        let off = other
            .ends
            .map(|end| way.perp(&(end - self.ends[0])) / length);
        let at = other
            .ends
            .map(|end| way.dot(&(end - self.ends[0])) / length);
        let common = f64::min(at[0].max(at[1]), length) - f64::max(at[0].min(at[1]), 0.0);
        // Both are on the line of the first one, so that their faces are on either side of both.
        off.iter().all(|off| off.abs() <= margin) && common > 4.0 * margin
    }
}

/// Returns the sides of a polygon.
fn sides(corners: &[Vector2<f64>]) -> impl Iterator<Item = [Vector2<f64>; 2]> + '_ {
    let next = corners.iter().cycle().skip(1);
    corners.iter().zip(next).map(|(a, b)| [*a, *b])
}

/// Returns the part of a convex polygon within another one, counter-clockwise; empty if there is none.
fn clipped(polygon: Vec<Vector2<f64>>, by: &[Vector2<f64>]) -> Vec<Vector2<f64>> {
    if by.is_empty() {
        return Vec::new();
    }
    sides(by).fold(polygon, |rest, side| cut(&rest, side, 0.0))
}

/// Returns the part of a convex polygon that is to the left of a line by more than `margin`.
fn cut(polygon: &[Vector2<f64>], [a, b]: [Vector2<f64>; 2], margin: f64) -> Vec<Vector2<f64>> {
    let way = b - a;
    let left = |point: &Vector2<f64>| way.perp(&(point - a)) - margin * way.norm();
    let mut rest = Vec::with_capacity(polygon.len() + 1);
    for [from, to] in sides(polygon) {
        let (start, end) = (left(&from), left(&to));
        if start > 0.0 {
            rest.push(from);
        }
        if (start > 0.0) != (end > 0.0) {
            rest.push(from + (to - from) * (start / (start - end)));
        }
    }
    rest
}
