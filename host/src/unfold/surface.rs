//! The surface that the faces of a shape form: its connected parts, its orientation and its angle defects.

use core::f64::consts::TAU;
use std::collections::HashMap;

use nalgebra::{Vector2, Vector3};

use super::{FoldedShape, ShapeError};
use crate::folding::in_plane;
use crate::pattern::{LARGEST, Letter};
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
        let cut = matches!(self.letter, Some(Letter::Boundary | Letter::Cut));
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
    /// Unit normals in the file's order.
    normals: Vec<Vector3<f64>>,
    /// Positions of the corners in the planes of their faces, seen from above.
    pub(super) local: Vec<Vector2<f64>>,
    /// For each corner the first corner at the same point of the paper.
    points: Vec<usize>,
    /// Interior points with their angle defects, radians.
    defects: Vec<(usize, f64)>,
    /// For each part `true` if it has no boundary, and `true` if it is a disc.
    pub(super) closed: Vec<bool>,
    pub(super) discs: Vec<bool>,
}

impl Surface {
    /// Builds the surface of a shape and turns its faces to the same side.
    ///
    /// # Errors
    /// If the shape is no surface with two sides, or if its faces are not flat to within `slope`.
    pub(super) fn new(
        shape: &FoldedShape,
        slope: f64,
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
        let normals = (0..faces.len()).map(|face| shape.normal(face, slope));
        let normals = normals.collect::<Result<Vec<_>, _>>()?;
        let edges = edges(shape, notes)?;
        let mut surface = Self {
            turned: vec![false; faces.len()],
            parts: vec![usize::MAX; faces.len()],
            faces,
            first,
            edges,
            normals,
            ..Self::default()
        };
        surface.turn_alike(notes)?;
        surface.measure(shape);
        Ok(surface)
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
        let interior = (0..inside.len()).filter(|&c| inside[c] && self.points[c] == c);
        self.defects = interior.map(|c| (c, TAU - sums[c])).collect();
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
        if self.turned[face] {
            -self.normals[face]
        } else {
            self.normals[face]
        }
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

    /// Returns `true` if every part is a disc.
    pub(super) fn is_disc(&self) -> bool {
        self.discs.iter().all(|disc| *disc)
    }

    /// Returns the number of vertices that faces use. A vertex counts once for each point of the paper at its place.
    pub(super) fn vertices(&self) -> usize {
        let corners = self.points.iter().enumerate();
        corners.filter(|(corner, point)| corner == *point).count()
    }

    /// Returns the largest absolute angle defect of an interior vertex, radians.
    pub(super) fn max_defect(&self) -> f64 {
        crate::util::nan_max::largest(self.defects.iter().map(|(_, defect)| defect.abs()))
    }

    /// Returns the largest absolute angle defect (radians) that is at most `bound`: the noise of the shape.
    pub(super) fn noise(&self, bound: f64) -> f64 {
        let defects = self.defects.iter().map(|(_, defect)| defect.abs());
        crate::util::nan_max::largest(defects.filter(|defect| *defect <= bound))
    }

    /// Returns the vertex whose absolute angle defect is farthest above `bound`, and that defect. Only parts with a
    /// boundary count, as these are not cut to remove defects.
    pub(super) fn not_developable(&self, bound: f64) -> Option<(usize, f64)> {
        let corner_face = |corner: usize| self.first.partition_point(|first| *first <= corner) - 1;
        let bad = self.defects.iter().filter(|(corner, defect)| {
            // A NaN is no defect of a developable vertex either.
            (defect.abs() > bound || defect.is_nan())
                && !self.closed[self.parts[corner_face(*corner)]]
        });
        let worst = bad.max_by(|a, b| a.1.abs().total_cmp(&b.1.abs()))?;
        let vertex = self.corner_vertices().nth(worst.0)?;
        Some((vertex, worst.1))
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
