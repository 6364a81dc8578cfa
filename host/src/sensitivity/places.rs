//! Rates of the folded sheet: how faces and vertices move with fold angles and with the vertices of the pattern, forwards and
//! in reverse.
//!
//! The face beyond a crease has the pose T χ of the face before, with χ as in
//! [`plane_angle`](foldpath_core::plane_angle). Its motion is that of the face before, a turn about the crease by dρ, turns by
//! dα about the normal of the face before and back about the own normal, both through the crease, and the shift of the crease
//! by its pivot. The reverse mode carries forces and moments from the leaves of the tree to its root.

use nalgebra::{Vector2, Vector3};

use super::conditions::plane_angle_by_ends;
use crate::folding::{FoldingMap, Pose, Step};
use crate::pattern::{CreasePattern, FaceId, VertexId};

/// Motion of a rigid body that takes a point x of space to x + turn × x + shift, or a moment about the origin and a force.
#[derive(Clone, Copy, Debug)]
pub(super) struct Twist {
    pub(super) turn: Vector3<f64>,
    pub(super) shift: Vector3<f64>,
}

impl Twist {
    pub(super) fn zero() -> Self {
        Self {
            turn: Vector3::zeros(),
            shift: Vector3::zeros(),
        }
    }

    /// Adds a turn about an axis through a point.
    fn turn_about(&mut self, axis: Vector3<f64>, point: Vector3<f64>) {
        self.turn += axis;
        self.shift += point.cross(&axis);
    }

    /// Returns the moment about a point of these moment and force.
    fn moment_about(&self, point: Vector3<f64>) -> Vector3<f64> {
        self.turn - point.cross(&self.shift)
    }

    /// Adds a force that acts at a point.
    pub(super) fn push(&mut self, force: Vector3<f64>, point: Vector3<f64>) {
        self.turn += point.cross(&force);
        self.shift += force;
    }
}

/// A folded sheet whose faces are placed along the pattern's tree.
pub(super) struct FoldedSheet<'a> {
    pattern: &'a CreasePattern,
    map: FoldingMap,
}

/// Rates of, or gradients by, fold angles and vertices of the pattern.
pub(super) struct PatternRates {
    /// By each crease.
    pub(super) angles: Vec<f64>,
    /// By each vertex of the pattern.
    pub(super) vertices: Vec<Vector2<f64>>,
}

impl<'a> FoldedSheet<'a> {
    pub(super) fn new(pattern: &'a CreasePattern, angles: &[f64]) -> Self {
        let map = FoldingMap::new(pattern, pattern.tree(), angles);
        Self { pattern, map }
    }

    pub(super) fn pose(&self, face: FaceId) -> &Pose {
        &self.map.poses()[face.index()]
    }

    /// Returns the rate of each vertex as its first face places it, for these rates of fold angles and vertices of the
    /// pattern. The first face of the tree keeps its pose.
    pub(super) fn rates(&self, given: &PatternRates) -> Vec<Vector3<f64>> {
        let pattern = self.pattern;
        let mut twists = vec![Twist::zero(); pattern.faces().len()];
        for step in pattern.tree().steps() {
            let mut twist = twists[step.parent.index()];
            if let Some(crease) = step.crease {
                let at = Crossing::of(self, step);
                let turned: f64 = at
                    .ends
                    .iter()
                    .map(|(vertex, by)| by.dot(&given.vertices[vertex.index()]))
                    .sum();
                let axis = at.axis * given.angles[crease.index()] + at.normals * turned;
                twist.turn_about(axis, at.pivot);
                let shift = given.vertices[at.start.index()];
                let [before, beyond] = [step.parent, step.face].map(|face| self.pose(face));
                twist.shift += before.turn(shift) - beyond.turn(shift);
            }
            twists[step.face.index()] = twist;
        }
        let vertices = self.map.vertices().iter().zip(pattern.corners().iter());
        let rates = vertices.zip(&given.vertices).map(|((at, faces), &moved)| {
            faces.first().map_or(moved.push(0.0), |face| {
                let Twist { turn, shift } = twists[face.index()];
                turn.cross(at) + shift + self.pose(*face).turn(moved)
            })
        });
        rates.collect()
    }

    /// Returns the gradient by fold angles and vertices of the pattern of what has this gradient by the folded vertices.
    pub(super) fn gradient(&self, by_places: &[Vector3<f64>]) -> PatternRates {
        let pattern = self.pattern;
        let mut wrenches = vec![Twist::zero(); pattern.faces().len()];
        let mut vertices = vec![Vector2::zeros(); pattern.vertices().len()];
        let places = self.map.vertices().iter().zip(pattern.corners().iter());
        for (((at, faces), force), own) in places.zip(by_places).zip(&mut vertices) {
            match faces.first() {
                Some(face) => {
                    wrenches[face.index()].push(*force, *at);
                    *own += self.flat_part(*face, force);
                }
                None => *own += force.xy(),
            }
        }
        let mut gradient = self.carried(&mut wrenches);
        let own = gradient.vertices.iter_mut().zip(&vertices);
        own.for_each(|(sum, own)| *sum += own);
        gradient
    }

    /// Returns the gradient of what has these moments and forces on the faces, without the motion of vertices within their
    /// faces. Leaves the sum of each sheet at its root.
    pub(super) fn carried(&self, wrenches: &mut [Twist]) -> PatternRates {
        let pattern = self.pattern;
        let mut gradient = PatternRates {
            angles: vec![0.0; pattern.creases().len()],
            vertices: vec![Vector2::zeros(); pattern.vertices().len()],
        };
        for step in pattern.tree().steps().iter().rev() {
            let wrench = wrenches[step.face.index()];
            if let Some(crease) = step.crease {
                let at = Crossing::of(self, step);
                let moment = wrench.moment_about(at.pivot);
                gradient.angles[crease.index()] += at.axis.dot(&moment);
                for (vertex, by) in at.ends {
                    gradient.vertices[vertex.index()] += by * at.normals.dot(&moment);
                }
                let [before, beyond] =
                    [step.parent, step.face].map(|face| self.flat_part(face, &wrench.shift));
                gradient.vertices[at.start.index()] += before - beyond;
            }
            let parent = &mut wrenches[step.parent.index()];
            parent.turn += wrench.turn;
            parent.shift += wrench.shift;
        }
        gradient
    }

    /// Returns the part of a vector of space in the plane of a face, in coordinates of the flat sheet.
    fn flat_part(&self, face: FaceId, vector: &Vector3<f64>) -> Vector2<f64> {
        let [x, y] = [Vector2::x(), Vector2::y()].map(|axis| self.pose(face).turn(axis));
        Vector2::new(x.dot(vector), y.dot(vector))
    }
}

/// A crease of the folded sheet.
struct Crossing {
    /// The vertex through which it runs.
    start: VertexId,
    pivot: Vector3<f64>,
    axis: Vector3<f64>,
    /// Normal of the face before less that of the face beyond.
    normals: Vector3<f64>,
    /// Gradient of the plane angle by the crease's ends.
    ends: [(VertexId, Vector2<f64>); 2],
}

impl Crossing {
    fn of(sheet: &FoldedSheet<'_>, step: &Step) -> Self {
        let edge = sheet.pattern.edge(step.edge);
        let start = edge.ends[usize::from(edge.faces[0] != Some(step.face))];
        let [before, beyond] = [step.parent, step.face].map(|face| sheet.pose(face));
        Self {
            start,
            pivot: before.apply(step.pivot),
            axis: before.turn(step.axis),
            normals: before.normal() - beyond.normal(),
            ends: plane_angle_by_ends(sheet.pattern, step.edge, start),
        }
    }
}
