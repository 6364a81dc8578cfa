//! Patterns drawn again: with vertices in other places, with further edges, or without edges of no length.

use nalgebra::Vector2;

use super::{CreasePattern, Drawing, DrawnEdge, EdgeId, PatternError, Unit, VertexId, places};
use crate::util::progress::Watch;

impl CreasePattern {
    /// Returns the drawing of the pattern, cut as it is: each side of a cut has its own vertices and edges.
    pub(crate) fn drawing(&self) -> Drawing {
        let edges = self.edges().iter().map(|edge| DrawnEdge {
            ends: edge.ends.map(VertexId::index),
            letter: edge.letter,
            goal: edge.goal,
        });
        let faces = self.faces().iter();
        let corners = |face: &[VertexId]| face.iter().map(|corner| corner.index()).collect();
        Drawing {
            vertices: self.vertices().to_vec(),
            edges: edges.collect(),
            faces: Some(faces.map(corners).collect()),
        }
    }

    /// Makes a pattern of a drawing that was made of this one by [`drawing`](Self::drawing) and changed: what was told of
    /// this pattern, its precision included, holds for the new one. The edges of this pattern come first in the drawing.
    ///
    /// # Errors
    /// If the drawing is no crease pattern.
    pub(crate) fn redrawn(&self, drawing: Drawing, watch: Watch<'_>) -> Result<Self, PatternError> {
        let mut pattern = Self::watched(drawing, watch)?;
        pattern.assumptions.clone_from(&self.assumptions);
        pattern.repairs.clone_from(&self.repairs);
        pattern.lost.clone_from(&self.lost);
        pattern.near = self.near;
        pattern.names.clone_from(&self.names);
        pattern.slits.clone_from(&self.slits);
        pattern.drawn = self.drawn;
        pattern.y_down = self.y_down;
        pattern.straightens_within = self.straightens_within;
        pattern.unit = self.unit;
        pattern.written_with(self.precision());
        Ok(pattern)
    }

    /// Returns the pattern with all lengths multiplied by a factor, in another unit. Returns `None` if coordinates become too
    /// large or too small.
    pub(crate) fn scaled(&self, factor: f64, unit: Unit) -> Option<Self> {
        let mut drawing = self.drawing();
        drawing.vertices.iter_mut().for_each(|at| *at *= factor);
        let mut pattern = self.redrawn(drawing, Watch::default()).ok()?;
        let mut precision = self.precision();
        precision.length = precision.length.scaled(factor);
        pattern.written_with(precision);
        pattern.unit = Some(unit);
        Some(pattern)
    }

    /// Returns `true` if the sheet is cut, so that some edges or vertices of the drawing are there twice.
    pub(super) fn is_cut(&self) -> bool {
        let places = places(self.vertices());
        let is_twice = places.iter().enumerate().any(|(vertex, at)| vertex != *at);
        is_twice || !self.slits.is_empty() || self.sheets() > 1
    }

    /// Notes that only the first `edges` edges are those of the file; the others are chords of its curves.
    pub(crate) fn add_chords(&mut self, edges: usize) {
        self.drawn = self.drawn.min(edges);
    }

    /// Makes a pattern as [`redrawn`](Self::redrawn) does, without the edges that have `no_length`: both of their ends
    /// become one vertex, and edges are counted anew. Returns `None` if the drawing is no pattern.
    pub(crate) fn contracted(
        &self,
        mut drawing: Drawing,
        no_length: impl Fn([Vector2<f64>; 2]) -> bool,
        watch: Watch<'_>,
    ) -> Option<Self> {
        let count = drawing.vertices.len();
        let mut joined: Vec<usize> = (0..count).collect();
        let points = &drawing.vertices;
        for edge in &drawing.edges {
            if no_length(edge.ends.map(|end| points[end])) {
                let [a, b] = edge.ends.map(|end| joined[end]);
                let [kept, gone] = [a.min(b), a.max(b)];
                joined
                    .iter_mut()
                    .filter(|it| **it == gone)
                    .for_each(|it| *it = kept);
            }
        }
        let kept: Vec<usize> = (0..count)
            .filter(|&vertex| joined[vertex] == vertex)
            .collect();
        let new = |vertex: usize| kept.partition_point(|&it| it < joined[vertex]);
        for edge in &mut drawing.edges {
            edge.ends = edge.ends.map(new);
        }
        let is_kept = |edge: &DrawnEdge| edge.ends[0] != edge.ends[1];
        let before: Vec<usize> = (0..drawing.edges.len())
            .filter(|&edge| is_kept(&drawing.edges[edge]))
            .collect();
        drawing.edges.retain(is_kept);
        for face in drawing.faces.iter_mut().flatten() {
            face.iter_mut().for_each(|corner| *corner = new(*corner));
            face.dedup();
            if face.len() > 1 && face.first() == face.last() {
                face.pop();
            }
        }
        drawing.vertices = kept.iter().map(|&vertex| points[vertex]).collect();
        let mut pattern = self.redrawn(drawing, watch).ok()?;
        let now = |edge: usize| before.partition_point(|&it| it < edge);
        pattern.drawn = now(self.drawn);
        let slits = self.slits.iter().map(|slit| slit.index());
        let slits = slits.filter(|slit| before.binary_search(slit).is_ok());
        pattern.slits = slits.map(|slit| EdgeId::new(now(slit))).collect();
        for edges in pattern.names.values_mut() {
            edges.retain(|edge| before.binary_search(&edge.index()).is_ok());
            edges
                .iter_mut()
                .for_each(|edge| *edge = EdgeId::new(now(edge.index())));
        }
        pattern.assume("edges are counted anew, as edges of no length were left out".into());
        Some(pattern)
    }

    /// Returns how far lines may be off that are meant to be straight, parallel or to fold flat, if the reader allows to
    /// move vertices by as much when the sheet does not fold as it is drawn.
    #[must_use]
    pub(crate) fn straightens_within(&self) -> Option<f64> {
        self.straightens_within
    }

    /// Sets how far lines may be off.
    pub(crate) fn straighten_within(&mut self, tolerance: Option<f64>) {
        self.straightens_within = tolerance;
    }
}
