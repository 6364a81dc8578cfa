//! The creases between two faces of a sheet, along the shortest chain of faces.

use std::collections::VecDeque;

use crate::pattern::{CreaseId, CreasePattern, EdgeId, FaceId, VertexId};
use crate::ragged::Ragged;

/// Chains of creases, one behind the other in one list.
#[derive(Clone, Debug)]
pub(super) struct Chains {
    neighbours: Ragged<(FaceId, EdgeId)>,
    creases: Vec<CreaseId>,
    /// For each face the search that found it last, and the face and edge that it was found from.
    found: Vec<(u32, FaceId, EdgeId)>,
    searches: u32,
    open: VecDeque<FaceId>,
}

/// A chain: its part of the list.
pub(super) type Chain = core::ops::Range<u32>;

impl Chains {
    pub(super) fn new(pattern: &CreasePattern) -> Self {
        Self {
            neighbours: pattern.neighbours(),
            creases: Vec::new(),
            found: vec![Default::default(); pattern.faces().len()],
            searches: 0,
            open: VecDeque::new(),
        }
    }

    /// Forgets all chains.
    pub(super) fn clear(&mut self) {
        self.creases.clear();
    }

    /// The creases of a chain in order.
    pub(super) fn creases(&self, chain: &Chain) -> &[CreaseId] {
        &self.creases[chain.start as usize..chain.end as usize]
    }

    /// The shortest chain from a face to another of the same sheet: round a vertex, if one is given.
    /// Cost: O(faces not farther away).
    pub(super) fn find(
        &mut self,
        pattern: &CreasePattern,
        [from, to]: [FaceId; 2],
        round: Option<VertexId>,
    ) -> Option<Chain> {
        self.searches += 1;
        self.open.clear();
        self.open.push_back(to);
        self.found[to.index()] = (self.searches, to, EdgeId::default());
        while self.found[from.index()].0 != self.searches {
            let face = self.open.pop_front()?;
            for &(beyond, edge) in &self.neighbours[face.index()] {
                let fits = round.is_none_or(|v| pattern.edge(edge).ends.contains(&v));
                if fits && self.found[beyond.index()].0 != self.searches {
                    self.found[beyond.index()] = (self.searches, face, edge);
                    self.open.push_back(beyond);
                }
            }
        }
        let start = FaceId::new(self.creases.len()).0;
        let mut face = from;
        while face != to {
            let (_, next, edge) = self.found[face.index()];
            self.creases.extend(pattern.edge(edge).crease);
            face = next;
        }
        Some(start..FaceId::new(self.creases.len()).0)
    }
}
