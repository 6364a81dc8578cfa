//! The flat sheet of a FOLD file, and the adjacency of its edges and faces.

use nalgebra::{Rotation3, Vector3};
use serde_json::{Value, from_value};

use crate::worst;

/// A flat sheet in the plane z = 0.
pub struct Sheet {
    /// Positions of the vertices.
    pub flat: Vec<Vector3<f64>>,
    /// Ends of the edges.
    pub edges: Vec<[usize; 2]>,
    /// Faces as counter-clockwise cycles of vertices.
    pub faces: Vec<Vec<usize>>,
    /// For each edge the face to the left of the direction from its first end to its second, then the face to the
    /// right.
    pub sides: Vec<[Option<usize>; 2]>,
}

impl Sheet {
    /// Reads the sheet of the key frame.
    ///
    /// # Errors
    /// If a key is missing or of another kind.
    pub fn of(file: &Value) -> serde_json::Result<Self> {
        let flat: Vec<[f64; 2]> = from_value(file["vertices_coords"].clone())?;
        let edges: Vec<[usize; 2]> = from_value(file["edges_vertices"].clone())?;
        let faces: Vec<Vec<usize>> = from_value(file["faces_vertices"].clone())?;
        let face_along =
            |a, b| (0..faces.len()).find(|&face| sides(&faces[face]).any(|side| side == [a, b]));
        Ok(Self {
            flat: flat.iter().map(|&[x, y]| Vector3::new(x, y, 0.0)).collect(),
            sides: edges
                .iter()
                .map(|&[a, b]| [face_along(a, b), face_along(b, a)])
                .collect(),
            edges,
            faces,
        })
    }

    /// Returns the median length of the edges.
    #[must_use]
    pub fn median_edge(&self) -> f64 {
        let length = |&[a, b]: &[usize; 2]| (self.flat[b] - self.flat[a]).norm();
        let mut lengths: Vec<f64> = self.edges.iter().map(length).collect();
        lengths.sort_by(f64::total_cmp);
        lengths[lengths.len() / 2]
    }

    /// Returns the number of creases, which are the edges between two faces.
    #[must_use]
    pub fn creases(&self) -> usize {
        self.sides
            .iter()
            .filter(|s| s[0].and(s[1]).is_some())
            .count()
    }

    /// Returns the interior vertices, each with its edges counter-clockwise.
    #[must_use]
    pub fn stars(&self) -> Vec<(usize, Vec<usize>)> {
        let star = |vertex: usize| {
            let at = |&edge: &usize| self.edges[edge].contains(&vertex);
            let mut star: Vec<usize> = (0..self.edges.len()).filter(at).collect();
            let bearing = |edge: usize| {
                let way = self.way(edge, vertex);
                way.y.atan2(way.x)
            };
            star.sort_by(|&a, &b| bearing(a).total_cmp(&bearing(b)));
            (vertex, star)
        };
        let inner = |(_, star): &(usize, Vec<usize>)| {
            let between_faces = |&edge: &usize| self.sides[edge].iter().all(Option::is_some);
            !star.is_empty() && star.iter().all(between_faces)
        };
        (0..self.flat.len()).map(star).filter(inner).collect()
    }

    /// Returns the largest closure residual ‖L − I‖ / √2 of an interior vertex at these fold angles of the edges
    /// (radians).
    #[must_use]
    pub fn closure(&self, angles: &[f64]) -> f64 {
        self.closure_round(&self.stars(), angles)
    }

    /// Returns the largest closure residual of these stars.
    #[must_use]
    pub fn closure_round(&self, stars: &[(usize, Vec<usize>)], angles: &[f64]) -> f64 {
        let residual = |(vertex, star): &(usize, Vec<usize>)| {
            let turns = star.iter().map(|&edge| {
                let axis = self.way(edge, *vertex).normalize();
                Rotation3::new(axis * angles[edge])
            });
            let l = turns.fold(Rotation3::identity(), |l, turn| l * turn);
            (l.matrix() - Rotation3::identity().matrix()).norm() / core::f64::consts::SQRT_2
        };
        worst(stars.iter().map(residual))
    }

    /// Returns the vector from `vertex` to the other end of `edge`.
    fn way(&self, edge: usize, vertex: usize) -> Vector3<f64> {
        let [a, b] = self.edges[edge];
        self.flat[a + b - vertex] - self.flat[vertex]
    }
}

/// Returns the sides of a face as [from, to], counter-clockwise.
pub(crate) fn sides(face: &[usize]) -> impl Iterator<Item = [usize; 2]> {
    (0..face.len()).map(|k| [face[k], face[(k + 1) % face.len()]])
}
