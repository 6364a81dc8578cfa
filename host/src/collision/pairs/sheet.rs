//! Pairs of a whole sheet: the broad phase leaves those that may meet over one interval of the motion after the other.

use foldpath_core::Membership;

use super::interval_broad_phase::IntervalBroadPhase;
use super::{Answer, Batch, Now, PairCounts, PairSource};
use crate::collision::pieces::Pieces;
use crate::collision::sweep::motion::{Motion, Tick};
use crate::collision::sweep::{QueryOutcome, SweepOptions};
use crate::folding::{LazyFolding, Pose};
use crate::pattern::{CreasePattern, FaceId};

/// A sheet that is folded along a spanning tree.
#[derive(Debug)]
pub(in crate::collision) struct SheetPairs {
    folding: LazyFolding,
    /// `None` if all pairs are followed one by one.
    broad_phase: Option<IntervalBroadPhase>,
    /// Number of pairs of pieces that do not touch each other in the flat sheet.
    others: u64,
}

impl SheetPairs {
    pub(in crate::collision) fn new(
        pattern: &CreasePattern,
        (memberships, groups): (&[Membership], usize),
        options: &SweepOptions,
    ) -> Self {
        // Without these skips all pairs are queried one by one.
        let skips = options.skip_motion && options.skip_bounds && options.skip_edges;
        let broad_phase = || IntervalBroadPhase::new(pattern, memberships, groups);
        Self {
            folding: LazyFolding::new(pattern.tree(), memberships),
            broad_phase: skips.then(broad_phase),
            others: 0,
        }
    }

    /// Makes the source for a follower, which asks for no pairs.
    pub(in crate::collision) fn of_follower(
        pattern: &CreasePattern,
        memberships: &[Membership],
    ) -> Self {
        Self {
            folding: LazyFolding::new(pattern.tree(), memberships),
            broad_phase: None,
            others: 0,
        }
    }
}

impl PairSource for SheetPairs {
    fn begin(&mut self, motion: &Motion, pieces: &Pieces) -> Option<(Batch, Vec<[u32; 2]>)> {
        self.folding.forget();
        let broad_phase = self.broad_phase.as_mut()?;
        broad_phase.begin(motion, pieces);
        let touching = pieces.touching();
        self.others = pieces.pairs() - touching.len() as u64;
        Some((Batch::Interval, touching))
    }

    /// Runs the broad phase over the next interval: asks for the pieces that may meet before its end, and finds the
    /// nearest pieces at its end.
    fn query(&mut self, _: Batch, now: &mut Now<'_>) -> Answer {
        let (motion, time) = (now.motion, now.time);
        if time > 0 && time == motion.end() {
            return Answer::new(QueryOutcome::Free);
        }
        if now.watch.is_over() {
            return Answer::new(QueryOutcome::Undecided);
        }
        let Some(broad_phase) = &mut self.broad_phase else {
            return Answer::new(QueryOutcome::Free);
        };
        let (pieces, hierarchy) = (now.pieces, now.hierarchy);
        let before = broad_phase.from;
        if time == motion.end() || !broad_phase.advance(motion, pieces, hierarchy) {
            // Chains of creases give better bounds than the long sums of the broad phase.
            return Answer {
                clusters: true,
                ..Answer::new(QueryOutcome::Split)
            };
        }
        let touching = now.contact.largest();
        let (mut tested, mut unseen) = (0, Vec::new());
        // The beginning of an interval is the end of the one before.
        let ends = [(0, broad_phase.from), (2, broad_phase.to)];
        let ends = if time == 0 {
            &ends[..]
        } else if motion.tabulated(broad_phase.to).is_some() {
            &ends[1..]
        } else {
            &[]
        };
        let test = |broad_phase: &IntervalBroadPhase, pair: [u32; 2]| {
            let [a, b] = pair;
            let counts = pieces.comparable(a, b).is_some() && !pieces.meet(a, b);
            counts.then(|| broad_phase.parted(pieces, pair, touching))
        };
        let found = &mut *now.found;
        let within = [touching, found.best()];
        broad_phase.near(hierarchy, within, test, |broad_phase, pair, apart| {
            tested += 1;
            let apart = apart.unwrap_or_else(|| {
                unseen.push(pair);
                [0.0; 3]
            });
            for &(end, tick) in ends {
                if apart[end] < found.best() {
                    let distance = broad_phase.distance(pieces, pair, end);
                    found.note(pieces, pair, distance, motion.place(tick));
                }
            }
            found.best()
        });
        found.counts.tested += tested;
        for pair in &mut unseen {
            pair.sort_unstable();
        }
        Answer {
            batches: vec![(Batch::Interval, broad_phase.to)],
            pieces: (unseen, [before, broad_phase.from, broad_phase.to]),
            skipped: self.others.saturating_sub(tested),
            ..Answer::new(QueryOutcome::Split)
        }
    }

    fn pose(&mut self, motion: &Motion, time: Tick, face: FaceId) -> Pose {
        let half_angle = |group| motion.half_angle(group, time);
        self.folding.pose(face, time, half_angle)
    }

    fn count(&self, pieces: &Pieces) -> PairCounts {
        let all = pieces.pairs();
        PairCounts {
            all,
            representative: all,
            joined: Some(pieces.joined_pairs().len() as u64),
        }
    }
}
