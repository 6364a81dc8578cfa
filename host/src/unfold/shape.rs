//! A folded shape read from a file, and the errors that checking it can find.

use nalgebra::Vector3;
use thiserror::Error;

use crate::pattern::{Digits, LARGEST, Letter};
use crate::util::nan_max::{diagonal, largest};

/// Smallest area of a face, as a fraction of its squared extent.
const NO_AREA_RATIO: f64 = 1e-12;

/// Data that a file names for an edge of a folded shape.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ShapeEdge {
    /// The ends, as positions in the list of vertices.
    pub ends: [usize; 2],
    /// The letter (FOLD assignment), if the file names one.
    pub letter: Option<Letter>,
    /// The fold angle in radians, valley positive, if the file names one. Only its sign is used, and only where the
    /// sign cannot be measured.
    pub angle: Option<f64>,
}

/// A folded shape of flat faces.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct FoldedShape {
    /// Vertices in space.
    pub vertices: Vec<Vector3<f64>>,
    /// Faces as cycles of vertices. Most of them run counter-clockwise seen from above.
    pub faces: Vec<Vec<usize>>,
    /// Edges that the file names; all other edges follow from the faces.
    pub edges: Vec<ShapeEdge>,
}

impl FoldedShape {
    /// Returns the diagonal of the bounding box of the vertices.
    #[must_use]
    pub fn size(&self) -> f64 {
        diagonal(&self.vertices)
    }

    /// Returns the precision with which the coordinates were written, as [`Digits::of_coordinates`] does.
    pub(crate) fn digits(&self, rounded: impl FnOnce(f64) -> bool) -> Digits {
        let points = self.vertices.iter().map(|&point| point.into());
        Digits::of_coordinates::<3>(points, rounded)
    }

    /// Checks that the shape has faces, finite vertices, and no reference to a vertex that does not exist.
    pub(crate) fn check(&self) -> Result<(), ShapeError> {
        if self.faces.is_empty() {
            return Err(ShapeError::NoFaces);
        }
        let infinite = |p: &Vector3<f64>| p.iter().any(|c| c.is_nan() || c.abs() > LARGEST);
        if let Some(vertex) = self.vertices.iter().position(infinite) {
            return Err(ShapeError::NotFinite { vertex });
        }
        let count = self.vertices.len();
        let known = |what, index, list: &[usize]| match list.iter().find(|v| **v >= count) {
            Some(&vertex) => Err(ShapeError::NoVertex {
                what,
                index,
                vertex,
                last: count.saturating_sub(1),
            }),
            None => Ok(()),
        };
        for (index, edge) in self.edges.iter().enumerate() {
            known("edge", index, &edge.ends)?;
        }
        for (face, cycle) in self.faces.iter().enumerate() {
            known("face", face, cycle)?;
        }
        Ok(())
    }

    /// Returns the plane of a face, whose normal follows from the order of the face's vertices (Newell's method).
    pub(super) fn plane(&self, face: usize) -> Result<Plane, ShapeError> {
        let cycle = &self.faces[face];
        let mut sorted = cycle.clone();
        sorted.sort_unstable();
        if cycle.len() < 3 || sorted.windows(2).any(|pair| pair[0] == pair[1]) {
            return Err(ShapeError::NoArea { face });
        }
        #[allow(clippy::cast_precision_loss, reason = "a mean")]
        let count = cycle.len() as f64;
        let center = cycle
            .iter()
            .map(|&v| self.vertices[v] / count)
            .sum::<Vector3<f64>>();
        let arm = |k: usize| self.vertices[cycle[k % cycle.len()]] - center;
        let corners = 0..cycle.len();
        let twice_area: Vector3<f64> = corners.clone().map(|k| arm(k).cross(&arm(k + 1))).sum();
        let extent = largest(corners.clone().map(|k| arm(k).norm()));
        let area = twice_area.norm();
        if area <= NO_AREA_RATIO * extent * extent {
            return Err(ShapeError::NoArea { face });
        }
        let normal = twice_area / area;
        let off = |k: usize| arm(k).dot(&normal).abs();
        let worst = corners
            .max_by(|&a, &b| off(a).total_cmp(&off(b)))
            .unwrap_or(0);
        Ok(Plane {
            normal,
            extent,
            vertex: cycle[worst],
            off: off(worst),
        })
    }
}

/// Plane through the middle of a face.
#[derive(Clone, Copy)]
pub(super) struct Plane {
    pub(super) normal: Vector3<f64>,
    /// Largest distance of a corner of the face from its middle.
    extent: f64,
    /// The corner that is farthest from the plane, and its distance.
    vertex: usize,
    off: f64,
}

impl Plane {
    /// Returns the largest slope of a corner out of the plane, radians.
    pub(super) fn slope(&self) -> f64 {
        self.off / self.extent
    }

    /// Returns `true` if the rounding of coordinates to this unit explains that corners are off the plane, which is at most
    /// a slope of `most` radians.
    pub(super) fn is_rounded_to(&self, unit: f64, most: f64) -> bool {
        self.off <= 2.0 * unit && self.slope() <= most
    }

    /// Makes the error that the face is not flat.
    pub(super) fn not_flat(&self, face: usize) -> ShapeError {
        ShapeError::NotFlat {
            face,
            vertex: self.vertex,
            off: self.off,
            slope: self.slope(),
        }
    }
}

/// Reason why a shape cannot be unfolded at all. Faces, edges and vertices are counted from 0.
#[derive(Clone, Debug, PartialEq, Error)]
#[non_exhaustive]
pub enum ShapeError {
    /// The caller cancelled the call.
    #[error("unfolding was cancelled")]
    Cancelled,
    /// There is nothing to unfold.
    #[error("the shape: expected at least one face")]
    NoFaces,
    /// A coordinate is not a number, or too large to compute with.
    #[error("vertex {vertex}: expected coordinates from -1e50 to 1e50")]
    NotFinite {
        /// The vertex.
        vertex: usize,
    },
    /// A reference to a vertex that does not exist.
    #[error("{what} {index}: vertex {vertex} does not exist, expected 0 to {last}")]
    NoVertex {
        /// The kind of element that refers to the vertex.
        what: &'static str,
        /// Position of the element in its list.
        index: usize,
        /// The vertex referred to.
        vertex: usize,
        /// The last vertex there is.
        last: usize,
    },
    /// A face with fewer than three different vertices, or without an area.
    #[error("face {face}: expected at least 3 different vertices and an area")]
    NoArea {
        /// The face.
        face: usize,
    },
    /// A face that is not flat.
    #[error("face {face}: expected a flat face, found vertex {vertex} {off:.3e} out of its plane")]
    NotFlat {
        /// The face.
        face: usize,
        /// The vertex.
        vertex: usize,
        /// The vertex's distance from the plane.
        off: f64,
        /// The distance over the extent of the face: the slope that would have to count as flat, radians.
        slope: f64,
    },
    /// A face whose sides cross each other, or with too many corners.
    #[error("face {face}: expected a polygon whose sides do not cross: {why}")]
    NotSimple {
        /// The face.
        face: usize,
        /// The defect of the face alone.
        why: String,
    },
    /// More than two faces at an edge.
    #[error(
        "the edge from vertex {} to {}: expected at most 2 faces, found {}, {} and {}",
        ends[0], ends[1], faces[0], faces[1], faces[2]
    )]
    Branching {
        /// Its ends.
        ends: [usize; 2],
        /// Three of its faces.
        faces: [usize; 3],
    },
    /// A surface with one side.
    #[error(
        "faces {first} and {second}: expected a surface with two sides, but going round it from one to the \
         other comes out on its back (a Möbius strip)"
    )]
    OneSided {
        /// One face.
        first: usize,
        /// Its neighbour.
        second: usize,
    },
    /// An edge without length.
    #[error("the edge from vertex {} to {}: expected two different places", ends[0], ends[1])]
    NoLength {
        /// Its ends.
        ends: [usize; 2],
    },
    /// The flat faces form no crease pattern.
    #[error("the flat pattern: {0}")]
    Pattern(String),
}
