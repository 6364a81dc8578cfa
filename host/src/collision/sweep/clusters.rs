//! Pairs of clusters, and the pairs that take their place: of their children, down to pieces.

use super::motion::Tick;
use super::queue::{Kind, Pair};
use super::{QueryOutcome, Sweep};
use crate::collision::pairs::Batch;
use crate::collision::sweep::chains::Chain;
use crate::collision::tolerances::{SPLIT_RATIO, WAYS_AT_ONCE};
use crate::pattern::FaceId;

impl Sweep<'_> {
    pub(super) fn query_clusters(&mut self, index: u32, pair: &Pair) -> QueryOutcome {
        let [a, b] = pair.nodes;
        if a == b || !self.options.skip_bounds {
            return QueryOutcome::Split;
        }
        let spheres = pair.nodes.map(|node| self.sheet.sphere(node));
        let distance = spheres[0].distance(&spheres[1]);
        if distance <= SPLIT_RATIO * spheres[0].radius.max(spheres[1].radius) {
            return QueryOutcome::Split;
        }
        let chain = self.approach.chain(&self.sheet, &mut self.queue[index]);
        let members = (pair.nodes, spheres);
        self.approach
            .gather_spheres(&mut self.sheet, &chain, members);
        let torn = self.approach.tear(&chain, pair.nodes);
        let room = distance - 2.0 * torn;
        if torn > 0.0 && (room.is_nan() || room <= 0.0) {
            return QueryOutcome::Split;
        }
        let time = self.sheet.time;
        let until = self
            .sheet
            .motion
            .tabulated_until(&self.approach.levers, time, room);
        let outcome = match until {
            Some(until) => self.next(until, distance, true),
            None if self.sheet.is_at_end() => QueryOutcome::Free,
            None => return QueryOutcome::Split,
        };
        let nodes = pair
            .nodes
            .map(|node| self.sheet.hierarchy.nodes[node as usize]);
        self.found.counts.skipped_bounds += u64::from(nodes[0].pieces) * u64::from(nodes[1].pieces);
        outcome
    }

    /// Replaces a pair of clusters by the pairs of their children.
    pub(super) fn split(&mut self, index: u32, time: Tick) {
        let [a, b] = self.queue[index].nodes;
        let children = |node: u32| self.sheet.hierarchy.nodes[node as usize].children;
        if a == b {
            if let Some([left, right]) = children(a) {
                for pair in [[left, left], [left, right], [right, right]] {
                    self.add(pair, time);
                }
            }
            return;
        }
        let [first, second] = [a, b].map(|node| self.sheet.radius(node));
        let pairs = match (children(a), children(b)) {
            (Some(parts), other) if other.is_none() || first >= second => {
                parts.map(|part| [part, b])
            }
            (_, Some(parts)) => parts.map(|part| [a, part]),
            _ => return,
        };
        for pair in pairs {
            self.add(pair, time);
        }
    }

    /// Adds all pairs, by the cluster of all pieces.
    pub(super) fn add_root(&mut self, time: Tick) {
        if let Some(root) = self.sheet.hierarchy.root {
            self.add([root, root], time);
        }
    }

    /// Adds a batch of pairs.
    pub(super) fn add_batch(&mut self, batch: Batch, time: Tick) {
        self.queue.push(
            [0; 2],
            Kind::Batch(batch),
            (None, self.approach.phase),
            time,
        );
    }

    /// Adds a pair to be queried.
    pub(super) fn add(&mut self, nodes: [u32; 2], time: Tick) {
        if let Some((kind, chain)) = self.classify(nodes) {
            let found = (chain, self.approach.phase);
            self.queue.push(nodes, kind, found, time);
        }
    }

    /// Adds pairs of pieces that do not touch in the flat sheet, to be queried from `time` to the `end` of an interval.
    /// Returns `false` if time ran out.
    pub(super) fn add_unseen(&mut self, pairs: &[[u32; 2]], interval: [Tick; 3]) -> bool {
        for pairs in pairs.chunks(WAYS_AT_ONCE) {
            // Finding the chain of a pair takes about as long as a query.
            let is_new = |pair: &&[u32; 2]| !self.queue.unseen.contains_key(*pair);
            let new = pairs.iter().filter(is_new);
            let faces: Vec<[FaceId; 2]> = new.map(|pair| self.sheet.faces(*pair)).collect();
            let ways = self.approach.chains.ways.find_all(&faces, self.watch);
            if self.watch.is_over() {
                return false;
            }
            let mut ways = ways.into_iter();
            for pair in pairs {
                if let Some(&index) = self.queue.unseen.get(pair) {
                    self.renew(index, interval);
                    continue;
                }
                let faces = self.sheet.faces(*pair);
                let chains = &mut self.approach.chains;
                let chain = match ways.next().flatten() {
                    Some(way) => Some(chains.chain(faces[0], &way)),
                    None => chains.find(faces, None),
                };
                if chain.is_some() {
                    self.add_new(*pair, chain, interval);
                }
            }
        }
        true
    }

    /// Makes a pair of pieces due again at the beginning of an interval.
    fn renew(&mut self, index: u32, [_, time, end]: [Tick; 3]) {
        let pair = &mut self.queue[index];
        if pair.end < time && pair.stall.crosses.is_none() {
            // The broad phase has proved that they are apart, or they have been at rest relative to each other.
            let chain = self.approach.along_tree(&self.sheet, pair);
            let links = self.approach.chains.links(&chain).iter();
            let mut groups = links.map(|link| link.group as usize);
            let times = [pair.end, time];
            if !groups.all(|group| self.sheet.motion.rests(group, times)) {
                pair.above = None;
            }
        }
        pair.end = end;
        self.queue.put(index, time);
    }

    /// Adds a pair of pieces that were apart until an interval begins.
    fn add_new(&mut self, pair: [u32; 2], chain: Option<Chain>, [before, time, end]: [Tick; 3]) {
        let found = (chain, self.approach.phase);
        let index = self.queue.push(pair, Kind::Pieces, found, time);
        let added = &mut self.queue[index];
        added.end = end;
        added.last = (time > 0).then_some(before);
        self.queue.unseen.insert(pair, index);
    }

    /// Returns the kind of a pair, and the chain of creases between its two members; `None` if the pair never
    /// needs a query.
    fn classify(&mut self, [a, b]: [u32; 2]) -> Option<(Kind, Option<Chain>)> {
        let nodes = [a, b].map(|node| self.sheet.hierarchy.nodes[node as usize]);
        let faces = nodes.map(|node| node.face);
        if a == b {
            return nodes[0].children.map(|_| (Kind::Clusters, None));
        }
        if nodes.iter().any(|node| node.children.is_some()) {
            let chain = self.approach.chains.find(faces, None)?;
            return Some((Kind::Clusters, Some(chain)));
        }
        if faces[0] == faces[1] {
            return None;
        }
        let mut shared = self.sheet.pieces.shared(a, b);
        if self.sheet.pieces.are_solid() {
            if shared.len() > 1 && self.keeps_back([a, b]) {
                return None;
            }
            let pieces = &self.sheet.pieces;
            // Cones round a vertex that both solids contain; all else is a distance.
            let both = |[k, l]: &[u32; 2]| {
                let mut solids = [(a, *k), (b, *l)].into_iter();
                solids.all(|(piece, corner)| {
                    pieces.solid(piece).is_some_and(|it| it.has_apex(corner))
                })
            };
            shared.retain(both);
            shared.truncate(1);
        }
        let pieces = &self.sheet.pieces;
        if shared.len() > 1 {
            // The shared vertices are on a line that is a side of both pieces.
            return Some((self.classify_side([a, b], &shared)?, None));
        }
        let chains = &mut self.approach.chains;
        if let Some(&corners) = shared.first()
            && let Some(chain) = chains.find(faces, Some(pieces.vertex(a, corners[0])))
        {
            return Some((Kind::Vertex(corners), Some(chain)));
        }
        let kind = if pieces.meet(a, b) {
            Kind::Meeting
        } else {
            Kind::Pieces
        };
        // Along a lattice the chain is hardly ever needed.
        let chain = if self.along_lattice {
            None
        } else {
            Some(chains.find(faces, None)?)
        };
        Some((kind, chain))
    }
}
