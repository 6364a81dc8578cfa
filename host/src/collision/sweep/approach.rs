//! Bounds on how far the two members of a pair may approach each other: levers about the creases of the chain between
//! them.

use foldpath_core::Membership;

use super::chains::{Chain, Chains, Link};
use super::queue::{Kind, Pair};
use super::ways::Ways;
use crate::collision::hierarchy::{Hierarchy, Sphere};
use crate::collision::placed_pieces::{Axis, PlacedPieces};
use crate::collision::tolerances::CHAIN_TEAR_RATIO;
use crate::pattern::CreasePattern;
use crate::util::time_cached::TimeCached;

/// Levers: how far the points of two bodies may approach each other per radian of variation of each crease group.
#[derive(Clone, Debug, Default)]
pub(super) struct Levers {
    per_group: Vec<f64>,
    touched: Vec<u32>,
    /// Lever per radian of variation of whichever group varies most.
    pub(super) any: f64,
}

impl Levers {
    pub(super) fn new(groups: usize) -> Self {
        Self {
            per_group: vec![0.0; groups],
            ..Self::default()
        }
    }

    pub(super) fn clear(&mut self) {
        for &group in &self.touched {
            self.per_group[group as usize] = 0.0;
        }
        self.touched.clear();
        self.any = 0.0;
    }

    pub(super) fn add(&mut self, group: u32, lever: f64) {
        let sum = &mut self.per_group[group as usize];
        if *sum <= 0.0 {
            self.touched.push(group);
        }
        *sum += lever;
    }

    pub(super) fn sum(&self, mut varied: impl FnMut(usize) -> f64) -> f64 {
        let groups = self.touched.iter().map(|&group| group as usize);
        groups.map(|g| self.per_group[g] * varied(g)).sum()
    }
}

/// Chains within a cluster.
#[derive(Debug, Default)]
struct Cluster {
    /// The chains from its face to those of its children.
    chains: [Chain; 2],
    /// Bound on the sum of the tears along the chains from its face to its pieces, units of the sheet.
    tear: f64,
}

/// The chains of creases between the faces of a sheet, and levers about them.
#[derive(Debug)]
pub(super) struct Approach<'a> {
    pub(super) chains: Chains<'a>,
    /// The chains within each cluster (`clusters`), and the length of the list of links that holds them (`kept`).
    clusters: Vec<Cluster>,
    kept: usize,
    /// For each cluster a bound on how far its points move as seen from its face, per radian of variation of the group
    /// that varies most.
    spreads: TimeCached<f64>,
    /// Number of the current phase. A phase is a run of consecutive segments over which the same groups turn.
    pub(super) phase: usize,
    pub(super) levers: Levers,
}

impl<'a> Approach<'a> {
    /// Makes the chains of a sheet whose closure residuals are at most `closure` all along its motions; `None` along a
    /// lattice. No point that moves with a face is farther from it than `beyond`.
    pub(super) fn new(
        pattern: &'a CreasePattern,
        (memberships, groups): (&'a [Membership], usize),
        hierarchy: &Hierarchy,
        closure: Option<f64>,
        beyond: f64,
    ) -> Self {
        let mut chains = Chains::new(Ways::new(pattern, memberships, closure), beyond);
        let mut clusters: Vec<Cluster> = Vec::with_capacity(hierarchy.nodes.len());
        for node in &hierarchy.nodes {
            let mut cluster = Cluster::default();
            // Children come before their cluster.
            for (side, child) in node.children.into_iter().flatten().enumerate() {
                let faces = [node.face, hierarchy.nodes[child as usize].face];
                let chain = chains.find(faces, None).unwrap_or_default();
                cluster.tear = f64::max(cluster.tear, chain.tear + clusters[child as usize].tear);
                cluster.chains[side] = chain;
            }
            clusters.push(cluster);
        }
        Self {
            clusters,
            kept: chains.len(),
            chains,
            spreads: TimeCached::default(),
            phase: 0,
            levers: Levers::new(groups),
        }
    }

    /// Begins a motion.
    pub(super) fn begin(&mut self) {
        self.chains.truncate(self.kept);
        self.spreads.forget();
    }

    /// Makes chains cross few of the creases that turn, given for each group `true` if it does not.
    pub(super) fn keep_still(&mut self, still: Vec<bool>) {
        if self.chains.ways.keep_still(still) {
            self.phase += 1;
            self.chains.truncate(self.kept);
        }
    }

    /// Returns a chain of creases between the two members of a pair, along which tears use up only a part of `room`: the
    /// distance (units of the sheet) up to which the members may approach each other or, for pieces that share a vertex,
    /// the angle (radians).
    pub(super) fn chain_within(
        &mut self,
        sheet: &PlacedPieces<'_>,
        pair: &mut Pair,
        room: f64,
    ) -> Chain {
        let chain = self.chain(sheet, pair);
        let torn = match pair.kind {
            Kind::Vertex(_) => chain.turn,
            _ => chain.tear,
        };
        if 2.0 * torn <= CHAIN_TEAR_RATIO * room {
            return chain;
        }
        self.along_tree(sheet, pair)
    }

    /// Returns the chain of creases along the tree between the two members of a pair, on which nothing is torn.
    pub(super) fn along_tree(&mut self, sheet: &PlacedPieces<'_>, pair: &mut Pair) -> Chain {
        self.renew(pair);
        if let Some(chain) = &pair.along_tree {
            return chain.clone();
        }
        let others = !self.chains.ways.is_simple() || matches!(pair.kind, Kind::Vertex(_));
        let along_tree = others.then(|| self.chains.along_tree(sheet.faces(pair.nodes)));
        let chain = along_tree.flatten();
        let chain = chain.unwrap_or_else(|| self.chain(sheet, pair));
        pair.along_tree = Some(chain.clone());
        chain
    }

    /// Forgets the chains of a pair that were found in another phase.
    fn renew(&self, pair: &mut Pair) {
        if pair.phase != self.phase {
            (pair.chain, pair.along_tree, pair.phase) = (None, None, self.phase);
        }
    }

    /// Returns the shortest chain of creases between the two members of a pair.
    pub(super) fn chain(&mut self, sheet: &PlacedPieces<'_>, pair: &mut Pair) -> Chain {
        self.renew(pair);
        if let Some(chain) = &pair.chain {
            return chain.clone();
        }
        let round = match pair.kind {
            Kind::Vertex([corner, _]) => Some(sheet.pieces.vertex(pair.nodes[0], corner)),
            _ => None,
        };
        let faces = sheet.faces(pair.nodes);
        let chain = self.chains.find(faces, round);
        let chain = chain.unwrap_or_default();
        pair.chain = Some(chain.clone());
        chain
    }

    /// Sums up the levers of the creases of a chain that turn from now on. The lever of a crease is its distance from one end
    /// of the chain (0 or 1), as `reach` returns it: from the first end for creases up to some crease, from the second end for
    /// the others.
    fn gather(
        &mut self,
        sheet: &mut PlacedPieces<'_>,
        chain: &Chain,
        reach: impl Fn(usize, &Axis) -> f64,
    ) {
        self.levers.clear();
        let (motion, time) = (sheet.motion.clone(), sheet.time);
        let turns = |link: &&Link| !motion.rests_from(link.group as usize, time);
        for link in self.chains.pairs(chain).iter().filter(turns) {
            let width = sheet.width(link) + chain.tear;
            self.levers.add(link.group, width);
        }
        let singles: Vec<&Link> = self.chains.singles(chain).iter().filter(turns).collect();
        let Some(last) = singles.len().checked_sub(1) else {
            return;
        };
        // On a torn sheet, the lines of creases are off by the tears.
        let mut lever =
            |side: usize, k: usize| reach(side, &sheet.axis(singles[k].creases[0])) + chain.tear;
        let (mut ends, mut levers) = ([0, last], [lever(0, 0), lever(1, last)]);
        for _ in 0..singles.len() {
            let side = usize::from(levers[1] < levers[0]);
            self.levers.add(singles[ends[side]].group, levers[side]);
            if ends[0] == ends[1] {
                return;
            }
            ends[side] = if side == 0 { ends[0] + 1 } else { ends[1] - 1 };
            levers[side] = lever(side, ends[side]);
        }
    }

    /// Sums up the levers of a chain between two pieces or clusters, from the spheres round them. Points of a cluster move
    /// as seen from its face.
    pub(super) fn gather_spheres(
        &mut self,
        sheet: &mut PlacedPieces<'_>,
        chain: &Chain,
        (nodes, spheres): ([u32; 2], [Sphere; 2]),
    ) {
        self.gather(sheet, chain, |side, axis| {
            axis.distance(&spheres[side].center) + spheres[side].radius
        });
        for node in nodes {
            self.levers.any += self.spread(sheet, node);
        }
    }

    /// Sums up the levers of a chain between two placed pieces, from the distances of their corners.
    pub(super) fn gather_corners(
        &mut self,
        sheet: &mut PlacedPieces<'_>,
        chain: &Chain,
        nodes: [u32; 2],
    ) {
        let corners = nodes.map(|node| sheet.placed().hull(node).to_vec());
        self.gather(sheet, chain, |side, axis| {
            let away = corners[side].iter().map(|corner| axis.distance(corner));
            away.fold(0.0, f64::max)
        });
    }

    /// Sums up the levers of a chain on the angle between two sectors round a vertex. Pairs of creases do not turn the part
    /// beyond them.
    pub(super) fn gather_turns(&mut self, chain: &Chain) {
        self.levers.clear();
        for link in self.chains.singles(chain) {
            self.levers.add(link.group, 1.0);
        }
    }

    /// Returns a bound on the tears along the chains between all pieces of two clusters, if `chain` is between their faces.
    pub(super) fn tear(&self, chain: &Chain, [a, b]: [u32; 2]) -> f64 {
        chain.tear + self.clusters[a as usize].tear + self.clusters[b as usize].tear
    }

    /// Returns a bound on how far points of a cluster move as seen from its face, per radian of variation of
    /// the group that varies most.
    fn spread(&mut self, sheet: &mut PlacedPieces<'_>, node: u32) -> f64 {
        let Some(children) = sheet.hierarchy.nodes[node as usize].children else {
            return 0.0;
        };
        if let Some(spread) = self.spreads.get(node as usize, sheet.time) {
            return *spread;
        }
        let mut spread = 0.0_f64;
        for (side, child) in children.into_iter().enumerate() {
            let mut sum = self.spread(sheet, child);
            let sphere = sheet.sphere(child);
            let chain = &self.clusters[node as usize].chains[side];
            for link in self.chains.pairs(chain) {
                sum += sheet.width(link);
            }
            for link in self.chains.singles(chain) {
                let axis = sheet.axis(link.creases[0]);
                sum += axis.distance(&sphere.center) + sphere.radius;
            }
            spread = spread.max(sum);
        }
        self.spreads.set(node as usize, sheet.time, spread);
        spread
    }
}
