//! The folding map at one configuration, and how rigid the sheet is under it.

use foldpath_core::{HalfAngle, Rotation};
use nalgebra::{Vector2, Vector3};

use super::tree::{SpanningTree, Step};
use crate::pattern::{CreasePattern, VertexId};

/// Rigid motion of a face from the flat sheet (frame f) to space (frame w): x_w = r_wf x_f + p_w.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Pose {
    /// Rotation.
    pub r_wf: Rotation<f64>,
    /// Where the origin of the flat sheet goes.
    pub p_w: Vector3<f64>,
}

impl Pose {
    /// The flat sheet left where it is.
    #[must_use]
    pub fn identity() -> Self {
        Self {
            r_wf: Rotation::identity(),
            p_w: Vector3::zeros(),
        }
    }

    /// Where the point of the flat sheet goes.
    #[inline]
    #[must_use]
    pub fn apply(&self, point: Vector2<f64>) -> Vector3<f64> {
        self.carry(&point.push(0.0))
    }

    /// Where a point of space that moves with the flat sheet goes.
    #[inline]
    #[must_use]
    pub fn carry(&self, point: &Vector3<f64>) -> Vector3<f64> {
        self.r_wf.rotate(point) + self.p_w
    }

    /// The motion back.
    #[must_use]
    pub fn inverse(&self) -> Self {
        let r_wf = self.r_wf.inverse();
        let p_w = -r_wf.rotate(&self.p_w);
        Self { r_wf, p_w }
    }
}

impl core::ops::Mul for Pose {
    type Output = Self;

    /// First the other motion, then this one.
    #[inline]
    fn mul(self, other: Self) -> Self {
        Self {
            r_wf: self.r_wf * other.r_wf,
            p_w: self.carry(&other.p_w),
        }
    }
}

/// How far a configuration is from folding the sheet rigidly.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Rigidity {
    /// Largest relative change of length of an edge or a virtual edge.
    pub deformation: f64,
    /// Largest distance between two positions that faces give the same vertex, over the median
    /// edge.
    pub gap: f64,
    /// Largest turn, in radians, by which two faces at an edge are off its fold angle. Round a vertex
    /// this is its misclosure; positions alone do not see it where both ends of the edge coincide.
    pub twist: f64,
}

impl Rigidity {
    /// The worse of both in each respect.
    #[must_use]
    pub fn worse(self, other: Self) -> Self {
        Self {
            deformation: larger(self.deformation, other.deformation),
            gap: larger(self.gap, other.gap),
            twist: larger(self.twist, other.twist),
        }
    }
}

/// The larger number; NaN if either is, so that a broken map never passes for a good one.
fn larger(a: f64, b: f64) -> f64 {
    if a >= b || a.is_nan() { a } else { b }
}

/// The folding map at one configuration: a pose for each face. Reused from one configuration to
/// the next, so that a path allocates once.
#[derive(Clone, Debug)]
pub struct FoldingMap {
    poses: Vec<Pose>,
    vertices: Vec<Vector3<f64>>,
}

impl FoldingMap {
    /// Folds the sheet by the fold angles of its creases (radians). Cost: O(faces).
    #[must_use]
    pub fn new(pattern: &CreasePattern, tree: &SpanningTree, fold_angles: &[f64]) -> Self {
        let mut map = Self {
            poses: vec![Pose::identity(); tree.faces()],
            vertices: vec![Vector3::zeros(); pattern.vertices().len()],
        };
        map.fold(pattern, tree, fold_angles);
        map
    }

    /// Replaces this map by that at another configuration of the same sheet.
    pub fn fold(&mut self, pattern: &CreasePattern, tree: &SpanningTree, fold_angles: &[f64]) {
        for &root in tree.roots() {
            self.poses[root.index()] = Pose::identity();
        }
        for step in tree.steps() {
            let parent = self.poses[step.parent.index()];
            if step.crease.is_none() {
                self.poses[step.face.index()] = parent;
                continue;
            }
            let r_wf = (parent.r_wf * turn(step, fold_angles)).renormalised();
            let pivot = step.pivot.push(0.0);
            // The pivot stays where the parent takes it.
            let p_w = parent.p_w + parent.r_wf.rotate(&pivot) - r_wf.rotate(&pivot);
            self.poses[step.face.index()] = Pose { r_wf, p_w };
        }
        for (vertex, (folded, faces)) in self
            .vertices
            .iter_mut()
            .zip(pattern.corners().iter())
            .enumerate()
        {
            let flat = pattern.vertices()[vertex];
            *folded = match faces.first() {
                Some(witness) => self.poses[witness.index()].apply(flat),
                None => flat.push(0.0),
            };
        }
    }

    /// For each face its rigid motion.
    #[must_use]
    pub fn poses(&self) -> &[Pose] {
        &self.poses
    }

    /// For each vertex its folded position, as one of its faces has it.
    #[must_use]
    pub fn vertices(&self) -> &[Vector3<f64>] {
        &self.vertices
    }

    /// The folded position of a vertex.
    #[must_use]
    pub fn vertex(&self, vertex: VertexId) -> Vector3<f64> {
        self.vertices[vertex.index()]
    }

    /// How rigid the sheet is under this map, made with the same tree and fold angles. Cost:
    /// O(edges + corners).
    #[must_use]
    pub fn rigidity(
        &self,
        pattern: &CreasePattern,
        tree: &SpanningTree,
        fold_angles: &[f64],
    ) -> Rigidity {
        let twists = tree.loops().iter().map(|step| {
            let r_wa = self.poses[step.parent.index()].r_wf;
            let r_wb = self.poses[step.face.index()].r_wf;
            let r_ab = turn(step, fold_angles);
            2.0 * ((r_wa * r_ab).inverse() * r_wb).v.norm()
        });
        Rigidity {
            deformation: deformation(pattern, &self.vertices),
            gap: self.gap(pattern),
            twist: twists.fold(0.0, larger),
        }
    }

    fn gap(&self, pattern: &CreasePattern) -> f64 {
        let mut positions = Vec::new();
        let mut widest = 0.0_f64;
        for (vertex, faces) in pattern.corners().iter().enumerate() {
            let flat = pattern.vertices()[vertex];
            let folded = self.vertices[vertex];
            positions.clear();
            positions.extend(faces.iter().map(|f| self.poses[f.index()].apply(flat)));
            let reach = positions.iter().map(|p| (p - folded).norm());
            // No two are farther apart than twice the reach from the first.
            if 2.0 * reach.fold(0.0, larger) <= widest {
                continue;
            }
            for (index, a) in positions.iter().enumerate() {
                let distances = positions[..index].iter().map(|b| (a - b).norm());
                widest = distances.fold(widest, larger);
            }
        }
        widest / pattern.median_edge()
    }
}

/// Rotation of a step: that of the face it reaches as seen from its parent.
fn turn(step: &Step, fold_angles: &[f64]) -> Rotation<f64> {
    let Some(crease) = step.crease else {
        return Rotation::identity();
    };
    let half = HalfAngle::of(fold_angles[crease.index()]);
    Rotation::about_crease(half, [step.axis.x, step.axis.y])
}

/// Largest relative change of length of an edge or virtual edge, for given folded positions.
#[must_use]
pub fn deformation(pattern: &CreasePattern, vertices: &[Vector3<f64>]) -> f64 {
    let strain = |ends: [VertexId; 2]| {
        let [a, b] = ends.map(|end| vertices[end.index()]);
        ((b - a).norm() / pattern.length(ends) - 1.0).abs()
    };
    pattern.struts().map(strain).fold(0.0, larger)
}
