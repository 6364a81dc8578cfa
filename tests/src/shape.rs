//! Measurements on a folded shape alone: lengths, flatness of faces, fold angles.

use core::f64::consts::{PI, TAU};

use nalgebra::Vector3;

use crate::sheet::sides;
use crate::{Sheet, worst};

/// Factor by which gaps may add up along another spanning tree.
const OTHER_WAYS: f64 = 10.0;

impl Sheet {
    /// Returns the largest relative change of length of an edge or of any diagonal of a face.
    #[must_use]
    pub fn deformation(&self, positions: &[Vector3<f64>]) -> f64 {
        let strain = |a: usize, b: usize| {
            let length = |at: &[Vector3<f64>]| (at[b] - at[a]).norm();
            (length(positions) / length(&self.flat) - 1.0).abs()
        };
        let of_face = |face: &Vec<usize>| {
            let pairs = (0..face.len()).flat_map(|k| (0..k).map(move |j| (j, k)));
            worst(pairs.map(|(j, k)| strain(face[j], face[k])))
        };
        worst(self.faces.iter().map(of_face))
    }

    /// Returns the largest distance of a vertex from the plane of a face to which it belongs, over the median edge.
    #[must_use]
    pub fn unflatness(&self, positions: &[Vector3<f64>]) -> f64 {
        let height = |face: &Vec<usize>| {
            let normal = normal(face, positions);
            let heights = face
                .iter()
                .map(|&v| normal.dot(&(positions[v] - positions[face[0]])));
            worst(heights.map(f64::abs))
        };
        worst(self.faces.iter().map(height)) / self.median_edge()
    }

    /// Returns the factor by which the gap may be larger if the sheet is folded from another face, and so torn in other
    /// places. Gaps add up along other paths, and at a vertex the longest edge may be torn in place of the shortest.
    #[must_use]
    pub fn other_tree(&self, stars: &[(usize, Vec<usize>)]) -> f64 {
        let length = |&edge: &usize| {
            let [a, b] = self.edges[edge];
            (self.flat[b] - self.flat[a]).norm()
        };
        let uneven = stars.iter().map(|(_, star)| {
            let lengths = star.iter().map(length);
            lengths.clone().fold(0.0, f64::max) / lengths.fold(f64::INFINITY, f64::min)
        });
        worst(uneven).max(OTHER_WAYS)
    }

    /// Returns the height of the lowest face over one of its sides, over the median edge. A gap over this height is the
    /// error of measured fold angles.
    #[must_use]
    pub fn narrowest(&self) -> f64 {
        let height = |face: &Vec<usize>, [a, b]: [usize; 2]| {
            let way = (self.flat[b] - self.flat[a]).normalize();
            let over = |&v: &usize| way.cross(&(self.flat[v] - self.flat[a])).norm();
            face.iter().map(over).fold(0.0, f64::max)
        };
        let heights = self
            .faces
            .iter()
            .flat_map(|face| sides(face).map(move |side| height(face, side)));
        heights.fold(f64::INFINITY, f64::min) / self.median_edge()
    }

    /// Returns the largest difference between the fold angle of a crease in this shape and in `angles`, radians. A
    /// valley and a mountain of half a turn count as equal.
    #[must_use]
    pub fn angle_error(&self, positions: &[Vector3<f64>], angles: &[f64]) -> f64 {
        let normals: Vec<_> = self.faces.iter().map(|f| normal(f, positions)).collect();
        let error = |edge: usize| {
            let [Some(left), Some(right)] = self.sides[edge] else {
                return angles[edge].abs();
            };
            let ([a, b], [left, right]) = (self.edges[edge], [left, right].map(|f| normals[f]));
            let along = (positions[b] - positions[a]).normalize();
            // A valley is positive: the right face's normal leans over to the left.
            let measured = right.cross(&left).dot(&along).atan2(left.dot(&right));
            ((measured - angles[edge] + PI).rem_euclid(TAU) - PI).abs()
        };
        worst((0..self.edges.len()).map(error))
    }
}

/// Returns the unit normal of a face, by its vector area (M. Newell).
pub(crate) fn normal(face: &[usize], positions: &[Vector3<f64>]) -> Vector3<f64> {
    let origin = positions[face[0]];
    let areas = sides(face).map(|[a, b]| (positions[a] - origin).cross(&(positions[b] - origin)));
    areas.sum::<Vector3<f64>>().normalize()
}
