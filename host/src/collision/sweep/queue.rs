//! The pairs that a sweep follows, in the order of the times at which they are due.

use std::collections::{BTreeMap, HashMap};

use super::chains::Chain;
use super::motion::Tick;
use super::stall::Stall;
use crate::collision::pairs::Batch;
use crate::collision::sides::Side;
use crate::pattern::FaceId;

/// Two clusters, or two pieces, to be queried again.
#[derive(Clone, Debug)]
pub(super) struct Pair {
    pub(super) nodes: [u32; 2],
    pub(super) kind: Kind,
    /// The chain of creases between them and that along the spanning tree, once requested, and the phase in which they
    /// were found.
    pub(super) chain: Option<Chain>,
    pub(super) along_tree: Option<Chain>,
    pub(super) phase: usize,
    /// Time of the last query.
    pub(super) last: Option<Tick>,
    /// Time from which on the broad phase proves that the pair is free.
    pub(super) end: Tick,
    /// Set while one piece lies flat on the other: `true` if the second came from above the first, and `true`
    /// if the first came from above the second.
    pub(super) above: Option<[bool; 2]>,
    pub(super) stall: Stall,
}

#[derive(Clone, Copy, Debug)]
pub(super) enum Kind {
    Clusters,
    /// Pairs that are looked at together.
    Batch(Batch),
    Pieces,
    /// Pieces that meet in a point of the flat sheet, as on both sides of a cut.
    Meeting,
    /// Pieces that share a vertex: positions of their corners at the vertex.
    Vertex([u32; 2]),
    /// Pieces that share a side at which the sheet may be torn.
    Side(Side),
    /// Pieces that share a side about which they turn.
    Joined,
}

/// Pairs by the times at which they are due.
#[derive(Debug, Default)]
pub(super) struct Queue {
    pairs: Vec<Pair>,
    due: BTreeMap<Tick, Vec<u32>>,
    /// Pairs of pieces that the broad phase did not prove to be apart, with their positions in `pairs`.
    pub(super) unseen: HashMap<[u32; 2], u32>,
}

impl Queue {
    /// Adds a pair, whose chain was found in a phase, and returns its number.
    pub(super) fn push(
        &mut self,
        nodes: [u32; 2],
        kind: Kind,
        (chain, phase): (Option<Chain>, usize),
        time: Tick,
    ) -> u32 {
        let index = FaceId::new(self.pairs.len()).0;
        self.pairs.push(Pair {
            nodes,
            kind,
            chain,
            phase,
            along_tree: None,
            last: None,
            end: Tick::MAX,
            above: None,
            stall: Stall::default(),
        });
        self.put(index, time);
        index
    }

    /// Makes a pair due at a time.
    pub(super) fn put(&mut self, index: u32, time: Tick) {
        self.due.entry(time).or_default().push(index);
    }

    /// Takes the pairs that are due first, and their time, if they are before another time.
    pub(super) fn next_before(&mut self, end: Tick) -> Option<(Tick, Vec<u32>)> {
        let first = self.due.first_entry()?;
        (*first.key() < end).then(|| first.remove_entry())
    }

    /// Returns the number of pairs that are due before a time.
    pub(super) fn count_before(&self, end: Tick) -> usize {
        self.due.range(..end).map(|(_, pairs)| pairs.len()).sum()
    }

    /// Takes the pairs that have become due at a time.
    pub(super) fn due_at(&mut self, time: Tick) -> Vec<u32> {
        self.due.remove(&time).unwrap_or_default()
    }
}

impl core::ops::Index<u32> for Queue {
    type Output = Pair;

    fn index(&self, index: u32) -> &Pair {
        &self.pairs[index as usize]
    }
}

impl core::ops::IndexMut<u32> for Queue {
    fn index_mut(&mut self, index: u32) -> &mut Pair {
        &mut self.pairs[index as usize]
    }
}
