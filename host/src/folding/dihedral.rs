//! Fold angles measured on folded positions, independently of the angles by which the sheet was folded.

use std::collections::HashMap;

use nalgebra::Vector3;

use crate::pattern::{CreasePattern, EdgeId, VertexId};

/// Two triangles of the sheet with a common side.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Dihedral {
    /// The side, from its first end to its second.
    pub ends: [VertexId; 2],
    /// The corners left and right of the side.
    pub corners: [VertexId; 2],
    /// The edge of the pattern that the side is; `None` for a diagonal, which a rigid panel keeps flat.
    pub edge: Option<EdgeId>,
}

impl Dihedral {
    /// Returns the dihedrals at all edges between two faces, in the order of the edges, then those at diagonals.
    #[must_use]
    pub fn all(pattern: &CreasePattern) -> Vec<Self> {
        let triangles = pattern.triangles().items().iter();
        let sides = triangles.flat_map(|&[a, b, c]| [([a, b], c), ([b, c], a), ([c, a], b)]);
        let beyond: HashMap<_, _> = sides.collect();
        let at = |ends: [VertexId; 2], edge| {
            let [a, b] = ends;
            let corners = [*beyond.get(&[a, b])?, *beyond.get(&[b, a])?];
            Some(Self {
                ends,
                corners,
                edge,
            })
        };
        let edges = (0..).map(EdgeId).zip(pattern.edges());
        let edges = edges.filter_map(|(id, edge)| at(edge.ends, Some(id)));
        let diagonals = pattern.diagonals().iter();
        edges
            .chain(diagonals.filter_map(|&ends| at(ends, None)))
            .collect()
    }

    /// Returns the fold angle between the triangles for these positions of the vertices: radians from -π to π,
    /// valley positive; 0 if a triangle has no area.
    ///
    /// # Panics
    /// If a vertex has no position.
    #[must_use]
    pub fn fold_angle(&self, vertices: &[Vector3<f64>]) -> f64 {
        let [a, b] = self.ends.map(|end| vertices[end.index()]);
        let [left, right] = self.corners.map(|corner| vertices[corner.index()] - a);
        let side = b - a;
        let angle = fold_angle(&side.cross(&left), &right.cross(&side), &side);
        if angle.is_nan() { 0.0 } else { angle }
    }
}

/// Returns the fold angle at a side from the normals left and right of the side, of any length: radians from -π to π,
/// valley positive. Sine and cosine are both used, so that digits are lost neither near 0 nor near half a turn.
pub(crate) fn fold_angle(left: &Vector3<f64>, right: &Vector3<f64>, side: &Vector3<f64>) -> f64 {
    let sine = right.cross(left).dot(side) / side.norm();
    sine.atan2(right.dot(left))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::folding::FoldingMap;
    use crate::generate::Miura;

    /// Angles enter the folding map as half angles, and are measured by cross products.
    #[test]
    fn a_closed_sheet_shows_the_angles_that_it_was_folded_by() {
        let miura = Miura {
            rows: 3,
            columns: 4,
            sector_angle: 1.1,
            fold: 0.7,
        };
        let pattern = CreasePattern::new(miura.drawing().unwrap()).unwrap();
        let goal = |edge: &EdgeId| pattern.edge(*edge).goal.unwrap();
        let goals: Vec<f64> = pattern.creases().iter().map(goal).collect();
        let tree = pattern.tree();
        let map = FoldingMap::new(&pattern, tree, &goals);
        let all = Dihedral::all(&pattern);
        assert_eq!(
            all.len(),
            pattern.creases().len() + pattern.diagonals().len()
        );
        for dihedral in all {
            let assigned = dihedral.edge.map_or(0.0, |edge| goal(&edge));
            let measured = dihedral.fold_angle(map.vertices());
            assert!(
                (measured - assigned).abs() < 1e-12,
                "{dihedral:?}: {measured}"
            );
        }
    }

    #[test]
    fn a_triangle_without_area_has_no_angle() {
        let dihedral = Dihedral {
            ends: [VertexId(0), VertexId(0)],
            corners: [VertexId(1), VertexId(1)],
            edge: None,
        };
        let places = [Vector3::zeros(), Vector3::x()];
        assert!(dihedral.fold_angle(&places).abs() <= 0.0);
    }
}
