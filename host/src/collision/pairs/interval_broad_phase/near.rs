//! Boxes of clusters over an interval, and the pairs of pieces that may come near each other by these boxes.

use core::time::Duration;

use nalgebra::Vector3;

use super::IntervalBroadPhase;
use crate::collision::hierarchy::Hierarchy;
use crate::collision::pieces::Pieces;
use crate::pattern::FaceId;
use crate::util::parallel;

/// Number of pairs of pieces that are tested as one task.
const PAIRS_PER_TASK: u64 = 4096;
/// Largest number of tasks in a round, which bounds the memory that their results take.
const MAX_TASKS: usize = 256;
/// About the time that such a task takes.
const TIME_PER_TASK: Duration = Duration::from_micros(40);
/// About the time that the search for near pairs takes for each cluster of a sheet.
const TIME_PER_CLUSTER: Duration = Duration::from_nanos(500);

impl IntervalBroadPhase {
    /// Finds the pairs of pieces whose boxes are no farther apart than `touching`, or nearer than a distance: at first
    /// `within`, then the value that `take` returned last. After the first interval, pieces of one body are no pairs,
    /// because their distance stays. Calls `test`, and then `take` with what `test` returned, unless that is `None`.
    ///
    /// `take` is called for the same pairs in the same order with any number of threads. `test` may run on several threads
    /// at once, and for more pairs than `take`: they are found before the distance has become small enough to leave them
    /// out.
    pub(in crate::collision) fn near<T: Send>(
        &mut self,
        hierarchy: &Hierarchy,
        [touching, mut within]: [f64; 2],
        test: impl Fn(&Self, [u32; 2]) -> Option<T> + Sync,
        mut take: impl FnMut(&Self, [u32; 2], T) -> f64,
    ) {
        let mut open = core::mem::take(&mut self.open);
        open.clear();
        open.extend(hierarchy.root.map(|root| [root, root]));
        if !parallel::is_shared(self.boxes.len(), TIME_PER_CLUSTER) {
            self.split::<1>(hierarchy, &mut open, [touching, within], |pair, _| {
                if let Some(tested) = test(self, pair) {
                    within = take(self, pair, tested);
                }
                Some(within)
            });
            self.open = open;
            return;
        }
        // Rounds grow, because at first no distance is known that keeps them small.
        let mut round = 1;
        while !open.is_empty() {
            let mut tasks = Vec::new();
            self.split::<PAIRS_PER_TASK>(hierarchy, &mut open, [touching, within], |pair, _| {
                tasks.push(pair);
                (tasks.len() < round).then_some(within)
            });
            let near = parallel::map_with(
                &tasks,
                TIME_PER_TASK,
                Vec::new,
                |open: &mut Vec<_>, &clusters| {
                    open.push(clusters);
                    let mut near = Vec::new();
                    self.split::<1>(hierarchy, open, [touching, within], |pair, gap| {
                        near.extend(test(self, pair).map(|tested| (pair, gap, tested)));
                        Some(within)
                    });
                    near
                },
            );
            // The distance has become smaller since. Boxes of clusters contain those of their parts, so that the pairs
            // left are those found one after the other.
            for (pair, gap, tested) in near.into_iter().flatten() {
                if !is_far(gap, [touching, within]) {
                    within = take(self, pair, tested);
                }
            }
            round = (2 * round).min(MAX_TASKS);
        }
        self.open = open;
    }

    /// Computes the boxes of all clusters.
    pub(super) fn enclose(&mut self, pieces: &Pieces, hierarchy: &Hierarchy) {
        self.boxes.clear();
        for (node, cluster) in hierarchy.nodes.iter().enumerate() {
            let enclosed = match cluster.children {
                Some(children) => {
                    let [a, b] = children.map(|child| self.boxes[child as usize]);
                    [a[0].inf(&b[0]), a[1].sup(&b[1])]
                }
                None => {
                    let piece = pieces.list[node];
                    let slack = Vector3::repeat(self.deviations[piece.face.index()]);
                    let hull = pieces.hull(FaceId::new(node).0);
                    let points = self.places.iter().flat_map(|places| &places[hull.clone()]);
                    let start = [f64::INFINITY, f64::NEG_INFINITY].map(Vector3::repeat);
                    let [low, high] =
                        points.fold(start, |[low, high], p| [low.inf(p), high.sup(p)]);
                    [low - slack, high + slack]
                }
            };
            self.boxes.push(enclosed);
        }
    }

    #[inline]
    fn gap(&self, a: u32, b: u32) -> f64 {
        let [a, b] = [a, b].map(|node| &self.boxes[node as usize]);
        let apart = (b[0] - a[1]).sup(&(a[0] - b[1]));
        apart.sup(&Vector3::zeros()).norm()
    }

    /// Returns `true` after the first interval if all pieces of two clusters are on one body.
    #[inline]
    fn is_body(&self, a: u32, b: u32) -> bool {
        let is_same = |body| self.bodies[b as usize] == Some(body);
        self.from > 0 && self.bodies[a as usize].is_some_and(is_same)
    }

    /// Takes pairs of clusters from `open` and splits them. Calls `found` for each pair that contains no more than `PAIRS`
    /// pairs of pieces and whose boxes are no farther apart than `touching` or nearer than `within`, with the distance of
    /// the boxes. `found` returns the next value of `within`, or `None` to end the search for now.
    #[inline]
    fn split<const PAIRS: u64>(
        &self,
        hierarchy: &Hierarchy,
        open: &mut Vec<[u32; 2]>,
        [touching, mut within]: [f64; 2],
        mut found: impl FnMut([u32; 2], f64) -> Option<f64>,
    ) {
        while let Some([a, b]) = open.pop() {
            let gap = if a == b { 0.0 } else { self.gap(a, b) };
            if is_far(gap, [touching, within]) || self.is_body(a, b) {
                continue;
            }
            let [first, second] = [a, b].map(|node| &hierarchy.nodes[node as usize]);
            // A single piece is no pair with itself.
            let few = u64::from(first.pieces) * u64::from(second.pieces) <= PAIRS;
            if few && (a != b || first.children.is_some()) {
                let Some(next) = found([a, b], gap) else {
                    return;
                };
                within = next;
            } else if a == b {
                if let Some([left, right]) = first.children {
                    open.extend([[left, right], [left, left], [right, right]]);
                }
            } else {
                // Splits the larger cluster. If the larger one is a single piece, so is the other.
                let (larger, other) = if first.pieces >= second.pieces {
                    (first, b)
                } else {
                    (second, a)
                };
                let parts = larger.children.into_iter().flatten();
                open.extend(parts.map(|part| [part, other]));
            }
        }
    }
}

/// Returns `true` if boxes with this distance are farther apart than `touching` and no nearer than `within`.
fn is_far(gap: f64, [touching, within]: [f64; 2]) -> bool {
    gap > touching && gap >= within
}

/// Finds for each cluster the body that has all its pieces, if one has, given the body of each face.
pub(super) fn find_bodies(
    bodies: &mut Vec<Option<FaceId>>,
    of_faces: &[FaceId],
    hierarchy: &Hierarchy,
) {
    bodies.clear();
    for node in &hierarchy.nodes {
        // Children come before their cluster.
        bodies.push(match node.children {
            None => Some(of_faces[node.face.index()]),
            Some(children) => {
                let [a, b] = children.map(|child| bodies[child as usize]);
                a.filter(|_| a == b)
            }
        });
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::collision::sweep::motion::Motion;
    use crate::generate::Miura;
    use crate::pattern::CreasePattern;
    use crate::symmetry::CreaseGroups;
    use foldpath_core::Curve;

    /// The distance shrinks while pairs are taken, so that pairs found in advance have to be left out.
    #[test]
    fn pairs_and_their_order_do_not_depend_on_the_number_of_threads() {
        let miura = Miura {
            rows: 40,
            columns: 40,
            sector_angle: 1.0,
            fold: 0.5,
        };
        let pattern = CreasePattern::new(miura.drawing().unwrap()).unwrap();
        let groups = CreaseGroups::trivial(&pattern);
        let segments = [0.0, 1.0].map(|part| {
            let curves = (0..groups.len()).map(|k| {
                let turn = 0.002 * (k % 7) as f64;
                Curve::Angle([0.0, 0.3, 0.9, 1.0].map(|s| (part + s) * turn))
            });
            curves.collect::<Vec<_>>()
        });
        let motion = Motion::new(&segments, groups.len());
        let pieces = Pieces::new(&pattern, None);
        let hierarchy = Hierarchy::new(&pieces);
        let found = |threads: usize| {
            let members = groups.memberships();
            let mut broad_phase = IntervalBroadPhase::new(&pattern, members, groups.len());
            broad_phase.begin(&motion, &pieces);
            let pool = rayon::ThreadPoolBuilder::new().num_threads(threads);
            pool.build().unwrap().install(|| {
                let mut found = Vec::new();
                for _ in 0..2 {
                    assert!(broad_phase.advance(&motion, &pieces, &hierarchy));
                    assert_eq!(
                        parallel::is_shared(broad_phase.boxes.len(), TIME_PER_CLUSTER),
                        threads > 1
                    );
                    let mut within = f64::INFINITY;
                    let parted = |broad_phase: &IntervalBroadPhase, pair: [u32; 2]| {
                        let counts = !pieces.meet(pair[0], pair[1]);
                        counts.then(|| broad_phase.parted(&pieces, pair, 1e-9))
                    };
                    broad_phase.near(&hierarchy, [1e-9, within], parted, |_, pair, apart| {
                        // Shrinks within rounds, too.
                        within = (within - 1e-3).clamp(0.7, 3.0);
                        found.push((pair, apart));
                        within
                    });
                }
                found
            })
        };
        let one = found(1);
        assert!(one.len() > 2_000 && one.iter().any(|(_, apart)| apart.is_some()));
        for threads in [2, 3] {
            assert!(found(threads) == one, "{threads}");
        }
    }
}
