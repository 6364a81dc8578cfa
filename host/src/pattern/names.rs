//! Names that a drawing has for its edges.

use std::collections::BTreeMap;

use super::{CreasePattern, EdgeId};

/// Names with the edges that each stands for, in the order of their numbers.
pub type EdgeNames = BTreeMap<String, Vec<EdgeId>>;

impl CreasePattern {
    /// Returns the names that the drawing has for edges: ids of shapes and groups in SVG, layers in DXF. An edge may have
    /// several names, and a name several edges.
    #[must_use]
    pub fn names(&self) -> &EdgeNames {
        &self.names
    }

    /// Records the names of edges.
    pub(crate) fn name_edges(&mut self, names: EdgeNames) {
        self.names = names;
    }

    /// Returns the names of each edge, in alphabetical order.
    #[must_use]
    pub fn names_of_edges(&self) -> Vec<Vec<&str>> {
        let mut of_edges = vec![Vec::new(); self.edges().len()];
        for (name, edges) in &self.names {
            for edge in edges {
                of_edges[edge.index()].push(&**name);
            }
        }
        of_edges
    }
}
