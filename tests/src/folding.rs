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
                let [a, b] = self.edges[edge];
                beyond[left].push((right, [a, b], angles[edge]));
                beyond[right].push((left, [b, a], angles[edge]));
            }
        }
        let mut poses: Vec<Option<Pose>> = vec![None; self.faces.len()];
        let mut next = VecDeque::from([(
            root,
            Pose {
                r_wf: Rotation3::identity(),
                p_w: Vector3::zeros(),
            },
        )]);
        while let Some((face, pose)) = next.pop_front() {
            if poses[face].is_some() {
                continue;
            }
            poses[face] = Some(pose);
            for &(other, [a, b], angle) in &beyond[face] {
                // Seen from above, the other face lies to the right of the direction from a to b. A valley lifts it,
                // which is a rotation about the opposite direction.
                let axis = (self.flat[b] - self.flat[a]).normalize();
                let r_wf = pose.r_wf * Rotation3::new(-axis * angle);
                let p_w = pose.apply(self.flat[a]) - r_wf * self.flat[a];
                next.push_back((other, Pose { r_wf, p_w }));
            }
        }
        poses
            .into_iter()
            .map(|pose| pose.expect("one sheet"))
            .collect()
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
