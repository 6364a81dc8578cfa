//! The unchecked drawing of a crease pattern, and the errors that checking it can find.

use nalgebra::Vector2;
use thiserror::Error;

use super::Letter;

/// An edge as drawn.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct DrawnEdge {
    /// Its ends, as positions in the list of vertices.
    pub ends: [usize; 2],
    /// The letter (FOLD assignment).
    pub letter: Letter,
    /// Its goal fold angle in radians, valley positive; `None` if the file names none.
    pub goal: Option<f64>,
}

impl DrawnEdge {
    /// Makes an edge at the border of the sheet or of a hole.
    #[must_use]
    pub fn boundary(ends: [usize; 2]) -> Self {
        Self {
            ends,
            letter: Letter::Boundary,
            goal: None,
        }
    }
}

/// A crease pattern as drawn.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Drawing {
    /// Vertices of the flat sheet.
    pub vertices: Vec<Vector2<f64>>,
    /// Edges between them.
    pub edges: Vec<DrawnEdge>,
    /// Faces as cycles of vertices, either way round; found from the edges if `None`.
    pub faces: Option<Vec<Vec<usize>>>,
}

/// Reason why a drawing is no crease pattern. The texts use FOLD's keys, so that the place can be found in a file.
#[derive(Clone, Debug, PartialEq, Error)]
#[non_exhaustive]
pub enum PatternError {
    /// The caller cancelled the call.
    #[error("the check of the drawing was cancelled")]
    Cancelled,
    /// There is nothing to fold.
    #[error("{key}: expected at least {least} entries, found {found}")]
    TooFew {
        /// The list.
        key: &'static str,
        /// Entries found.
        found: usize,
        /// Entries needed.
        least: usize,
    },
    /// A coordinate is not a number, or too large to compute with.
    #[error("vertices_coords[{vertex}]: expected coordinates from -1e50 to 1e50")]
    NotFinite {
        /// The vertex.
        vertex: usize,
    },
    /// A reference to a vertex that does not exist.
    #[error("{key}[{index}]: vertex {vertex} does not exist, expected 0 to {last}")]
    NoVertex {
        /// The list that refers to it.
        key: &'static str,
        /// Position in that list.
        index: usize,
        /// The vertex referred to.
        vertex: usize,
        /// The last vertex there is.
        last: usize,
    },
    /// An edge from a vertex to itself or to another one at the same place.
    #[error("edges_vertices[{edge}]: expected two vertices at different places")]
    NoLength {
        /// The edge.
        edge: usize,
    },
    /// Two edges join the same two vertices.
    #[error("edges_vertices[{edge}]: joins the same vertices as edge {other}")]
    Duplicate {
        /// The later edge.
        edge: usize,
        /// The earlier edge.
        other: usize,
    },
    /// Two edges cross where there is no vertex.
    #[error("edges_vertices[{edge}]: crosses edge {other} where there is no vertex")]
    Crossing {
        /// One edge.
        edge: usize,
        /// The other edge.
        other: usize,
    },
    /// A vertex lies on an edge without being one of its ends.
    #[error("edges_vertices[{edge}]: passes through vertex {vertex} without ending there")]
    OnEdge {
        /// The edge.
        edge: usize,
        /// The vertex.
        vertex: usize,
    },
    /// More edges near each other than can be compared.
    #[error(
        "edges_vertices[{edge}]: expected edges all over the sheet, found too many in one place to \
         compare each with each"
    )]
    Crowded {
        /// The edge at which the limit was exceeded.
        edge: usize,
    },
    /// A face with more corners than can be triangulated in reasonable time, or too many faces with many corners.
    #[error("faces_vertices[{face}]: expected faces of fewer corners, found {corners}")]
    Corners {
        /// The face at which the limit was exceeded.
        face: usize,
        /// The face's number of corners.
        corners: usize,
    },
    /// A face with a side that is no edge.
    #[error("faces_vertices[{face}]: no edge joins its vertices {a} and {b}")]
    NoEdge {
        /// The face.
        face: usize,
        /// One vertex of the side.
        a: usize,
        /// The other vertex of the side.
        b: usize,
    },
    /// An edge that ends in the middle of a face.
    #[error(
        "edges_vertices[{edge}]: ends inside a face, at vertex {vertex} where no other edge does; \
         expected it to part two faces"
    )]
    DeadEnd {
        /// The edge.
        edge: usize,
        /// Its end.
        vertex: usize,
    },
    /// An edge with the same face on both sides.
    #[error(
        "edges_vertices[{edge}]: has the same face on both sides; expected it to part two faces"
    )]
    OneFace {
        /// The edge.
        edge: usize,
    },
    /// A face without area, or one that touches or crosses itself.
    #[error("faces_vertices[{face}]: expected a simple polygon with an area")]
    NoArea {
        /// The face.
        face: usize,
        /// A corner of the face: the first at which the face touches itself, if there is one.
        vertex: usize,
    },
    /// More than one face on one side of an edge.
    #[error("edges_vertices[{edge}]: faces {first} and {second} lie on the same side of it")]
    Overlap {
        /// The edge.
        edge: usize,
        /// One face.
        first: usize,
        /// The other face.
        second: usize,
    },
    /// Faces that overlap round a vertex, or an edge without faces between them.
    #[error(
        "vertices_coords[{vertex}]: expected the faces round it not to overlap, and no edge without \
         faces between them"
    )]
    BrokenStar {
        /// The vertex.
        vertex: usize,
    },
    /// A goal fold angle beyond half a turn.
    #[error("edges_foldAngle[{edge}]: expected -180 to 180 degrees, found {degrees}")]
    GoalRange {
        /// The edge.
        edge: usize,
        /// The angle in degrees.
        degrees: f64,
    },
    /// A goal fold angle whose sign contradicts the letter.
    #[error(
        "edges_foldAngle[{edge}]: {degrees} degrees has the wrong sign for letter {letter}; \
         expected valley positive, mountain negative"
    )]
    GoalSign {
        /// The edge.
        edge: usize,
        /// The angle in degrees.
        degrees: f64,
        /// Its letter.
        letter: char,
    },
}
