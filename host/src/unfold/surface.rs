//! The surface that the faces of a shape form: its connected parts, its orientation and its angle defects.

use core::f64::consts::TAU;
use std::collections::HashMap;

use nalgebra::{Vector2, Vector3};

use super::shape::Plane;
use super::{FoldedShape, ShapeError, angles};
use crate::folding::in_plane;
use crate::pattern::{Digits, LARGEST, Letter};
use crate::util::angle::turn_between;
use crate::util::union_find::UnionFind;

/// A side of a face along an edge.
#[derive(Clone, Copy, Debug)]
pub(super) struct Side {
    /// The face.
    pub(super) face: usize,
    /// Corner of the face, from 0, where the side begins in the file's order.
    corner: usize,
    /// `true` if the side runs from the edge's first end to its second, in the file's order.
    forward: bool,
}

/// An edge of the surface.
#[derive(Clone, Copy, Debug)]
pub(super) struct SurfaceEdge {
    /// Its ends.
    pub(super) ends: [usize; 2],
    /// The letter (FOLD assignment) in the file.
    pub(super) letter: Option<Letter>,
    /// The fold angle (radians) in the file.
    pub(super) angle: Option<f64>,
    /// The sides of the one or two faces at the edge.
    pub(super) sides: [Option<Side>; 2],
}

impl SurfaceEdge {
    /// Returns both sides, unless the edge is a boundary or a cut.
    pub(super) fn joint(&self) -> Option<[Side; 2]> {
        let cut = self.letter.is_some_and(Letter::parts);
        match self.sides {
            [Some(a), Some(b)] if !cut => Some([a, b]),
            _ => None,
        }
    }
}

/// A surface of flat faces, all oriented to the same side.
#[derive(Default)]
pub(super) struct Surface {
    pub(super) faces: Vec<Vec<usize>>,
    /// For each face the index of its first corner in the list of the corners of all faces.
    first: Vec<usize>,
    pub(super) edges: Vec<SurfaceEdge>,
    /// `true` if the order of a face's vertices runs clockwise, seen from above.
    turned: Vec<bool>,
    /// For each face the number of its part. Parts are connected components: different parts share at most points.
    pub(super) parts: Vec<usize>,
    /// Planes of the faces, with normals in the file's order.
    planes: Vec<Plane>,
    /// Positions of the corners in the planes of their faces, seen from above.
    pub(super) local: Vec<Vector2<f64>>,
    /// For each corner the first corner at the same point of the paper.
    pub(super) points: Vec<usize>,
    /// The points inside the paper.
    defects: Vec<Defect>,
    /// For each part `true` if it has no boundary, and `true` if it is a disc.
    pub(super) closed: Vec<bool>,
    discs: Vec<bool>,
    /// Largest angle defect (radians) that counts as none, and largest slope of a corner out of the plane of its face.
    pub(super) bound: f64,
    /// Precision with which the coordinates of the shape were written.
    pub(super) length: Digits,
    /// Points that are corners: their angle defects are neither within the bound nor explained by the rounding of
    /// coordinates.
    pub(super) corners: Vec<usize>,
    /// For each part `true` if it has a corner.
    pub(super) has_corners: Vec<bool>,
}

/// Angle defect of a point inside the paper.
struct Defect {
    /// The point: its first corner.
    point: usize,
    /// A full turn less the sum of the angles, radians.
    defect: f64,
    /// Largest defect (radians) that coordinates off by one make, to first and to second order.
    per_unit: [f64; 2],
}

impl Defect {
    /// Returns the largest defect (radians) that coordinates rounded to this unit make.
    fn rounding(&self, unit: f64) -> f64 {
        let [first, second] = self.per_unit;
        (unit / 2.0 * (first + second * unit / 2.0)).min(MAX_ROUNDING_RAD)
    }
}

/// Largest angle defect (radians) that is put down to the rounding of coordinates: 1 degree. A larger defect is a corner,
/// even if the coordinates have few digits.
pub(super) const MAX_ROUNDING_RAD: f64 = core::f64::consts::PI / 180.0;

impl Surface {
    /// Builds the surface of a shape and turns its faces to the same side.
    ///
    /// # Errors
    /// If the shape is no surface with two sides, or if its faces are not flat to within `bound`, radians.
    pub(super) fn new(
        shape: &FoldedShape,
        bound: f64,
        notes: &mut Vec<String>,
    ) -> Result<Self, ShapeError> {
        shape.check()?;
        let faces = shape.faces.clone();
        let mut corners = 0;
        let first = faces.iter().map(|cycle| {
            corners += cycle.len();
            corners - cycle.len()
        });
        let first = first.collect();
        let planes = (0..faces.len()).map(|face| shape.plane(face));
        let planes = planes.collect::<Result<Vec<_>, _>>()?;
        let edges = edges(shape, notes)?;
        let mut surface = Self {
            turned: vec![false; faces.len()],
            parts: vec![usize::MAX; faces.len()],
            faces,
            first,
            edges,
            planes,
            bound,
            ..Self::default()
        };
        surface.turn_alike(notes)?;
        surface.measure(shape);
        surface.length = shape.digits(|unit| surface.looks_rounded(shape, unit));
        surface.check_flat()?;
        surface.find_corners();
        Ok(surface)
    }

    /// Returns `true` if the shape looks as if its coordinates were rounded to this unit: rounding explains every face that is
    /// not quite flat and every small angle defect, and there is one of these, or an edge that is not quite flat.
    fn looks_rounded(&self, shape: &FoldedShape, unit: f64) -> bool {
        let small = |error: f64| error > self.bound && error <= MAX_ROUNDING_RAD;
        let bent = self
            .planes
            .iter()
            .filter(|plane| plane.slope() > self.bound);
        let odd = self.defects.iter().filter(|it| small(it.defect.abs()));
        let is_rounded = |plane: &Plane| plane.is_rounded_to(unit, MAX_ROUNDING_RAD);
        let mut any = false;
        let explained = bent.inspect(|_| any = true).all(is_rounded);
        let explained = explained
            && odd
                .inspect(|_| any = true)
                .all(|it| it.defect.abs() <= it.rounding(unit));
        let is_bent = |edge| angles::is_flat_but_for(shape, self, edge, unit);
        explained && (any || self.edges.iter().any(is_bent))
    }

    /// Checks that all faces are flat, to within the bound or the rounding of coordinates.
    fn check_flat(&self) -> Result<(), ShapeError> {
        let unit = self.length.unit();
        let is_flat = |plane: &Plane| {
            plane.slope() <= self.bound || plane.is_rounded_to(unit, MAX_ROUNDING_RAD)
        };
        let bent = self.planes.iter().enumerate();
        let bent = bent.filter(|(_, plane)| !is_flat(plane));
        let worst = bent.max_by(|a, b| a.1.slope().total_cmp(&b.1.slope()));
        worst.map_or(Ok(()), |(face, plane)| Err(plane.not_flat(face)))
    }

    /// Turns all faces of each part to the side of most of them. Fails on a one-sided part.
    fn turn_alike(&mut self, notes: &mut Vec<String>) -> Result<(), ShapeError> {
        let neighbours = self.neighbours();
        let mut parts = 0;
        let mut turned = 0_usize;
        for start in 0..self.faces.len() {
            if self.parts[start] != usize::MAX {
                continue;
            }
            self.parts[start] = parts;
            let mut part = vec![start];
            let mut next = 0;
            while let Some(&face) = part.get(next) {
                next += 1;
                for &(other, alike) in &neighbours[face] {
                    let turn = self.turned[face] ^ !alike;
                    if self.parts[other] == usize::MAX {
                        self.parts[other] = parts;
                        self.turned[other] = turn;
                        part.push(other);
                    } else if self.turned[other] != turn {
                        return Err(ShapeError::OneSided {
                            first: face.min(other),
                            second: face.max(other),
                        });
                    }
                }
            }
            let backs = part.iter().filter(|face| self.turned[**face]).count();
            if 2 * backs > part.len() {
                part.iter().for_each(|&face| self.turned[face] ^= true);
            }
            turned += backs.min(part.len() - backs);
            parts += 1;
        }
        if turned > 0 {
            notes.push(format!(
                "faces that run the other way round than their neighbours, turned over: {turned}"
            ));
        }
        self.closed = vec![true; parts];
        self.discs = vec![false; parts];
        Ok(())
    }

    /// Returns for each face the faces beyond its edges, with `true` if the vertices of both run the same way round.
    pub(super) fn neighbours(&self) -> Vec<Vec<(usize, bool)>> {
        let mut neighbours = vec![Vec::new(); self.faces.len()];
        for [a, b] in self.edges.iter().filter_map(SurfaceEdge::joint) {
            let alike = a.forward != b.forward;
            neighbours[a.face].push((b.face, alike));
            neighbours[b.face].push((a.face, alike));
        }
        neighbours
    }

    /// Turns whole parts over.
    pub(super) fn turn_over(&mut self, shape: &FoldedShape, over: &[bool]) {
        for (turned, &part) in self.turned.iter_mut().zip(&self.parts) {
            *turned ^= over[part];
        }
        self.measure(shape);
        self.find_corners();
    }

    /// Measures the faces in their planes, seen from above, and the angles round vertices.
    fn measure(&mut self, shape: &FoldedShape) {
        self.local = (0..self.faces.len())
            .flat_map(|face| {
                let corners = self.faces[face].iter().map(|&v| &shape.vertices[v]);
                in_plane(corners, &self.up(face))
            })
            .collect();
        let joined = vec![true; self.edges.len()];
        self.points = self.points_where(&joined);
        let mut sums = vec![0.0; self.local.len()];
        let mut inside = vec![true; self.local.len()];
        for face in 0..self.faces.len() {
            for corner in 0..self.faces[face].len() {
                sums[self.points[self.first[face] + corner]] += self.sector(face, corner);
            }
        }
        // Euler characteristic of each part: points - edges + faces.
        let mut euler = vec![0_isize; self.closed.len()];
        for face in 0..self.faces.len() {
            euler[self.parts[face]] += 1;
            for corner in self.first[face]..self.first[face] + self.faces[face].len() {
                euler[self.parts[face]] += isize::from(self.points[corner] == corner);
            }
        }
        for edge in &self.edges {
            if let Some([a, _]) = edge.joint() {
                euler[self.parts[a.face]] -= 1;
                continue;
            }
            for side in edge.sides.iter().flatten() {
                let part = self.parts[side.face];
                euler[part] -= 1;
                self.closed[part] = false;
                for end in self.corners(*side) {
                    inside[self.points[end]] = false;
                }
            }
        }
        for (disc, (euler, closed)) in self.discs.iter_mut().zip(euler.iter().zip(&self.closed)) {
            *disc = *euler == 1 && !closed;
        }
        let per_unit = self.levers(shape, &inside);
        let interior = (0..inside.len()).filter(|&c| inside[c] && self.points[c] == c);
        let defects = interior.map(|point| Defect {
            point,
            defect: TAU - sums[point],
            per_unit: per_unit[point],
        });
        self.defects = defects.collect();
    }

    /// Returns for each point that is `inside` the largest change of the sum of its angles, for vertices that are off by
    /// one in each coordinate: to first and to second order.
    ///
    /// The gradient of an angle with respect to the end of one of its sides lies in the plane of the face, is perpendicular
    /// to the side, and is as long as the inverse of the side. The gradients of both angles at a side are summed before
    /// their size counts: they cancel where both faces lie in a plane.
    fn levers(&self, shape: &FoldedShape, inside: &[bool]) -> Vec<[f64; 2]> {
        let mut levers = vec![[0.0; 2]; self.local.len()];
        let mut gradients = Vec::new();
        for face in 0..self.faces.len() {
            let (up, cycle) = (self.up(face), self.cycle(face));
            let vertex = |k: usize| {
                let corner = cycle[k % cycle.len()];
                self.faces[face][corner - self.first[face]]
            };
            for (k, &corner) in cycle.iter().enumerate() {
                let point = self.points[corner];
                if !inside[point] {
                    continue;
                }
                let here = vertex(k);
                for (end, sign) in [(vertex(k + 1), 1.0), (vertex(k + cycle.len() - 1), -1.0)] {
                    let side = shape.vertices[end] - shape.vertices[here];
                    let gradient = sign * side.cross(&up) / side.norm_squared();
                    gradients.push(((point, end), gradient));
                    gradients.push(((point, here), -gradient));
                    levers[point][1] += 4.0 / side.norm_squared();
                }
            }
        }
        gradients.sort_by_key(|(ends, _)| *ends);
        for same in gradients.chunk_by(|a, b| a.0 == b.0) {
            let sum: Vector3<f64> = same.iter().map(|(_, gradient)| gradient).sum();
            levers[same[0].0.0][0] += sum.abs().sum();
        }
        levers
    }

    /// Returns the angle of a face at one of its corners, radians, from 0 to a full turn.
    fn sector(&self, face: usize, corner: usize) -> f64 {
        let (first, count) = (self.first[face], self.faces[face].len());
        let at = |corner: usize| self.local[first + corner % count];
        let here = at(corner);
        let (mut from, mut to) = (at(corner + 1) - here, at(corner + count - 1) - here);
        if self.turned[face] {
            core::mem::swap(&mut from, &mut to);
        }
        turn_between(from, to)
    }

    /// Returns for each corner the first corner at the same point, if the paper is whole across the edges with `joined`
    /// (by union-find).
    pub(super) fn points_where(&self, joined: &[bool]) -> Vec<usize> {
        let count = self.faces.iter().map(Vec::len).sum();
        let mut points = UnionFind::new(count);
        let edges = self.edges.iter().zip(joined).filter(|(_, joined)| **joined);
        for [a, b] in edges.filter_map(|(edge, _)| edge.joint()) {
            for (a, b) in self.corners(a).into_iter().zip(self.corners(b)) {
                points.join_to_smaller([a, b]);
            }
        }
        points.representatives()
    }

    /// Returns the corners of a side's face at the first and the second end of its edge.
    pub(super) fn corners(&self, side: Side) -> [usize; 2] {
        let first = self.first[side.face];
        let start = first + side.corner;
        let end = first + (side.corner + 1) % self.faces[side.face].len();
        if side.forward {
            [start, end]
        } else {
            [end, start]
        }
    }

    /// Returns `true` if the face lies to the left of its edge, from the first end to the second, seen from above.
    pub(super) fn is_left(&self, side: Side) -> bool {
        side.forward ^ self.turned[side.face]
    }

    /// Returns the unit normal of a face on its upper side.
    pub(super) fn up(&self, face: usize) -> Vector3<f64> {
        let Plane { normal, .. } = self.planes[face];
        if self.turned[face] { -normal } else { normal }
    }

    /// Returns the indices of a face's corners, counter-clockwise seen from above.
    pub(super) fn cycle(&self, face: usize) -> Vec<usize> {
        let mut cycle = self.corner_range(face).collect::<Vec<_>>();
        if self.turned[face] {
            cycle.reverse();
        }
        cycle
    }

    /// Returns the indices of a face's corners in the file's order.
    pub(super) fn corner_range(&self, face: usize) -> core::ops::Range<usize> {
        self.first[face]..self.first[face] + self.faces[face].len()
    }

    /// Returns the vertex of the shape at each corner.
    pub(super) fn corner_vertices(&self) -> impl Iterator<Item = usize> {
        self.faces.iter().flatten().copied()
    }

    /// Returns the number of parts.
    pub(super) fn parts(&self) -> usize {
        self.closed.len()
    }

    /// Returns `true` if a part is a plain sheet: a disc without corners.
    pub(super) fn is_plain(&self, part: usize) -> bool {
        self.discs[part] && !self.has_corners[part]
    }

    /// Returns the number of vertices that faces use. A vertex counts once for each point of the paper at its place.
    pub(super) fn vertices(&self) -> usize {
        let corners = self.points.iter().enumerate();
        corners.filter(|(corner, point)| corner == *point).count()
    }

    /// Returns the largest absolute angle defect of an interior vertex, radians.
    pub(super) fn max_defect(&self) -> f64 {
        crate::util::nan_max::largest(self.defects.iter().map(|it| it.defect.abs()))
    }

    /// Finds the corners.
    fn find_corners(&mut self) {
        let corners = self.defects.iter().filter(|it| self.is_corner(it));
        self.corners = corners.map(|it| it.point).collect();
        self.has_corners = vec![false; self.parts()];
        for &corner in &self.corners {
            let part = self.part_of(corner);
            self.has_corners[part] = true;
        }
    }

    /// A NaN is no defect of a developable vertex either.
    fn is_corner(&self, it: &Defect) -> bool {
        let within = self.bound.max(it.rounding(self.length.unit()));
        it.defect.abs() > within || it.defect.is_nan()
    }

    /// Returns the largest absolute angle defect (radians) that counts as none: the noise of the shape.
    pub(super) fn noise(&self) -> f64 {
        let noise = self.defects.iter().filter(|it| !self.is_corner(it));
        crate::util::nan_max::largest(noise.map(|it| it.defect.abs()))
    }

    /// Returns for each part `true` if it may be a sheet that was measured or computed with errors, rather than a shape with
    /// corners: it has a boundary, and its largest angle defect and the sum of its defects are small.
    pub(super) fn nearly_plain(&self) -> Vec<bool> {
        let mut parts = vec![[0.0; 2]; self.parts()];
        for it in &self.defects {
            let [sum, largest] = &mut parts[self.part_of(it.point)];
            *sum += it.defect;
            *largest = crate::util::nan_max::larger(*largest, it.defect.abs());
        }
        let small = |[sum, largest]: [f64; 2]| sum.abs().max(largest) <= MAX_ROUNDING_RAD;
        let parts = parts.into_iter().zip(&self.closed);
        parts
            .map(|(defects, closed)| !closed && small(defects))
            .collect()
    }

    /// Returns the vertex at the worst corner of the parts for which `counts` returns `true`, and its angle defect.
    pub(super) fn worst_corner(&self, counts: impl Fn(usize) -> bool) -> Option<(usize, f64)> {
        let bad = self.defects.iter();
        let bad = bad.filter(|it| self.is_corner(it) && counts(self.part_of(it.point)));
        let worst = bad.max_by(|a, b| a.defect.abs().total_cmp(&b.defect.abs()))?;
        let vertex = self.corner_vertices().nth(worst.point)?;
        Some((vertex, worst.defect))
    }

    /// Returns the points inside the paper.
    pub(super) fn inner_points(&self) -> impl Iterator<Item = usize> {
        self.defects.iter().map(|it| it.point)
    }

    /// Returns the part of the face with this corner.
    pub(super) fn part_of(&self, corner: usize) -> usize {
        self.parts[self.first.partition_point(|first| *first <= corner) - 1]
    }
}

/// Returns the edges that the shape names and faces have, in the shape's order, then all other edges.
fn edges(shape: &FoldedShape, notes: &mut Vec<String>) -> Result<Vec<SurfaceEdge>, ShapeError> {
    let key = |a: usize, b: usize| (a.min(b), a.max(b));
    let mut index = HashMap::with_capacity(shape.edges.len());
    let mut edges = Vec::with_capacity(shape.edges.len());
    for named in &shape.edges {
        let [a, b] = named.ends;
        index.entry(key(a, b)).or_insert_with(|| {
            edges.push(SurfaceEdge {
                ends: named.ends,
                letter: named.letter,
                angle: named.angle,
                sides: [None; 2],
            });
            edges.len() - 1
        });
    }
    for (face, cycle) in shape.faces.iter().enumerate() {
        for (corner, &a) in cycle.iter().enumerate() {
            let b = cycle[(corner + 1) % cycle.len()];
            let edge = *index.entry(key(a, b)).or_insert_with(|| {
                edges.push(SurfaceEdge {
                    ends: [a, b],
                    letter: None,
                    angle: None,
                    sides: [None; 2],
                });
                edges.len() - 1
            });
            let edge = &mut edges[edge];
            let side = Side {
                face,
                corner,
                forward: edge.ends[0] == a,
            };
            match edge.sides {
                [None, _] => edge.sides[0] = Some(side),
                [Some(_), None] => edge.sides[1] = Some(side),
                [Some(first), Some(second)] => {
                    return Err(ShapeError::Branching {
                        ends: edge.ends,
                        faces: [first.face, second.face, face],
                    });
                }
            }
        }
    }
    let named = edges.len();
    edges.retain(|edge| edge.sides[0].is_some());
    if edges.len() < named {
        notes.push(format!(
            "edges without a face, left out: {}",
            named - edges.len()
        ));
    }
    for edge in &edges {
        let [a, b] = edge.ends.map(|end| shape.vertices[end]);
        if (b - a).norm() < 1.0 / LARGEST {
            return Err(ShapeError::NoLength { ends: edge.ends });
        }
    }
    Ok(edges)
}
