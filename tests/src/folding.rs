//! The folding map of the oracle: faces turn about their edges one after another, breadth first from a root face.

use std::collections::VecDeque;

use nalgebra::{Rotation3, Vector3};

use crate::{Sheet, worst};

/// Rigid motion of a face from the flat sheet f to space w: x_w = r_wf x_f + p_w.
#[derive(Clone, Copy)]
pub struct Pose {
    r_wf: Rotation3<f64>,
    p_w: Vector3<f64>,
}

impl Pose {
    pub(crate) fn identity() -> Self {
        Self {
            r_wf: Rotation3::identity(),
            p_w: Vector3::zeros(),
        }
    }

    pub(crate) fn apply(&self, flat: Vector3<f64>) -> Vector3<f64> {
        self.r_wf * flat + self.p_w
    }

    pub(crate) fn normal(&self) -> Vector3<f64> {
        self.r_wf * Vector3::z()
    }

    /// Returns a point of space in the flat coordinates of the face.
    pub(crate) fn seen(&self, place: Vector3<f64>) -> Vector3<f64> {
        self.r_wf.inverse() * (place - self.p_w)
    }

    /// Returns a direction of the flat sheet as it lies in space.
    pub(crate) fn turn(&self, way: Vector3<f64>) -> Vector3<f64> {
        self.r_wf * way
    }

    /// Returns the motion that applies `first` and then this one.
    pub(crate) fn after(&self, first: &Self) -> Self {
        Self {
            r_wf: self.r_wf * first.r_wf,
            p_w: self.apply(first.p_w),
        }
    }

    /// Returns the motion that undoes this one.
    pub(crate) fn inverse(&self) -> Self {
        let r_wf = self.r_wf.inverse();
        Self {
            p_w: -(r_wf * self.p_w),
            r_wf,
        }
    }

    /// Returns the residual ‖R - I‖ / √2 of the rotation from this pose to another.
    pub(crate) fn twist(&self, other: &Self) -> f64 {
        (self.r_wf.matrix() - other.r_wf.matrix()).norm() / core::f64::consts::SQRT_2
    }
}

impl Sheet {
    /// Returns the pose of each face at these fold angles of the edges (radians); face 0 stays.
    ///
    /// # Panics
    /// If the sheet is not connected.
    #[must_use]
    pub fn fold(&self, angles: &[f64]) -> Vec<Pose> {
        self.fold_from(0, angles)
    }

    /// Returns the poses as [`fold`](Self::fold) does, but with face `root` at rest. A sheet that these angles tear
    /// then gapes in other places.
    ///
    /// # Panics
    /// If the sheet is not connected.
    #[must_use]
    pub fn fold_from(&self, root: usize, angles: &[f64]) -> Vec<Pose> {
        let mut beyond = vec![Vec::new(); self.faces.len()];
        for (edge, sides) in self.sides.iter().enumerate() {
            if let [Some(left), Some(right)] = *sides {
                beyond[left].push((right, edge));
                beyond[right].push((left, edge));
            }
        }
        let mut poses: Vec<Option<Pose>> = vec![None; self.faces.len()];
        let mut next = VecDeque::from([(root, Pose::identity())]);
        while let Some((face, pose)) = next.pop_front() {
            if poses[face].is_some() {
                continue;
            }
            poses[face] = Some(pose);
            for &(other, edge) in &beyond[face] {
                next.push_back((other, self.across(&pose, edge, other, angles[edge])));
            }
        }
        poses
            .into_iter()
            .map(|pose| pose.expect("one sheet"))
            .collect()
    }

    /// Returns the pose of face `other`, which lies across `edge` from a face with pose `pose`, if the edge is folded by
    /// `angle`.
    pub(crate) fn across(&self, pose: &Pose, edge: usize, other: usize, angle: f64) -> Pose {
        let [mut a, mut b] = self.edges[edge];
        if self.sides[edge][0] == Some(other) {
            core::mem::swap(&mut a, &mut b);
        }
        // Seen from above, the other face lies to the right of the direction from a to b. A valley lifts it, which is a
        // rotation about the opposite direction.
        let axis = (self.flat[b] - self.flat[a]).normalize();
        let r_wf = pose.r_wf * Rotation3::new(-axis * angle);
        let p_w = pose.apply(self.flat[a]) - r_wf * self.flat[a];
        Pose { r_wf, p_w }
    }

    /// Returns for each vertex its positions by all faces round it.
    fn opinions(&self, poses: &[Pose]) -> Vec<Vec<Vector3<f64>>> {
        let mut opinions = vec![Vec::new(); self.flat.len()];
        for (face, pose) in self.faces.iter().zip(poses) {
            for &vertex in face {
                opinions[vertex].push(pose.apply(self.flat[vertex]));
            }
        }
        opinions
    }

    /// Returns for each vertex its position by the first of its faces.
    #[must_use]
    pub fn positions(&self, poses: &[Pose]) -> Vec<Vector3<f64>> {
        self.opinions(poses)
            .iter()
            .map(|of_vertex| of_vertex[0])
            .collect()
    }

    /// Returns the largest distance between two positions that faces give the same vertex, over the median edge.
    #[must_use]
    pub fn gap(&self, poses: &[Pose]) -> f64 {
        let widest = |p: Vec<Vector3<f64>>| {
            worst(p.iter().flat_map(|a| p.iter().map(move |b| (a - b).norm())))
        };
        worst(self.opinions(poses).into_iter().map(widest)) / self.median_edge()
    }
}
