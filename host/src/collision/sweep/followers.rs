//! Pairs of a whole sheet are shared by followers: each follows some of them over a stretch of the motion, on a thread of its
//! own, and then all that they found is put together. A stretch is some intervals of the broad phase.
//!
//! The answer is the same for any number of followers. A pair is followed by itself: of what is found of others, it uses
//! only the smallest distance known before the stretch. When some pair ends the motion, other followers may have gone on for
//! longer than that; what they found later is left out.

use core::time::Duration;

use super::approach::Approach;
use super::comoving_faces::ComovingNow;
use super::motion::{SEGMENT, Tick};
use super::queue::{Kind, Queue};
use super::verdict::Found;
use super::{QueryOutcome, Sweep, SweepVerdict};
use crate::collision::hierarchy::Hierarchy;
use crate::collision::pairs::{Batch, SheetPairs};
use crate::collision::placed_pieces::PlacedPieces;
use crate::collision::scene::Crossing;
use crate::collision::tolerances::{MAX_FOLLOWED_PIECES, MAX_FOLLOWERS};
use crate::pattern::FaceId;
use crate::util::parallel;

/// About the time that a sweep takes for each piece in each segment of a motion.
const TIME_PER_PIECE: Duration = Duration::from_nanos(200);
/// About the time that a query of a pair takes.
const TIME_PER_QUERY: Duration = Duration::from_micros(2);
/// Largest number of intervals in a stretch. The first stretch is one interval, and each is twice as long as the one before,
/// so that little is looked at behind the end.
const MAX_INTERVALS: usize = 64;
/// Number of pairs that may meet from which on a stretch has no more intervals.
const MAX_UNSEEN: usize = 4096;

/// End of the motion for a follower.
#[derive(Clone, Copy, Debug)]
pub(super) enum Ending {
    /// Two faces cross, those of the pair with this number.
    Crosses(Crossing, u32),
    /// Faces cross, here or later on.
    Certain(SweepVerdict),
    /// Nothing is known of these faces, or of any.
    Undecided(Option<[FaceId; 2]>),
}

impl Ending {
    /// Returns `true` if this one is told of two at the same time: the deepest crossing if there is one.
    pub(super) fn precedes(&self, other: &Self) -> bool {
        match (self, other) {
            (Self::Crosses(a, _), Self::Crosses(b, _)) => a.exceeds(b),
            (Self::Certain(a), Self::Certain(b)) => a.faces() < b.faces(),
            (Self::Undecided(a), Self::Undecided(b)) => a < b,
            (Self::Crosses(..), _) | (Self::Certain(_), Self::Undecided(_)) => true,
            _ => false,
        }
    }
}

/// Findings of a follower up to a time, at which it had queried all pairs that were due.
#[derive(Clone, Copy, Debug)]
pub(super) struct Record {
    time: Tick,
    found: Found,
    queries: u64,
    /// The first of the pairs that were due, in the order of their faces.
    faces: Option<[FaceId; 2]>,
}

/// An interval of the motion.
struct Interval {
    from: Tick,
    to: Tick,
    /// Pairs of pieces that touch in the flat sheet, at the beginning of the motion.
    touching: Vec<[u32; 2]>,
    /// Other pairs that may meet in the interval, and a time before it at which they are apart.
    unseen: Vec<[u32; 2]>,
    before: Tick,
}

impl Sweep<'_> {
    /// Follows all pairs to the end of the motion, over one interval after the other, given the pairs of pieces that touch in
    /// the flat sheet. Adds the number of times at which some pair was queried to `times`.
    pub(super) fn follow_all(
        &mut self,
        mut touching: Vec<[u32; 2]>,
        times: &mut u64,
    ) -> SweepVerdict {
        self.find_helpers();
        let (mut from, mut intervals) = (0, 1);
        while from < Tick::MAX {
            let mut queried = Vec::new();
            let mut stretch = match self.next_stretch(from, intervals, &mut queried) {
                Ok(stretch) => stretch,
                Err(verdict) => return verdict,
            };
            if let Some(first) = stretch.first_mut() {
                first.touching = core::mem::take(&mut touching);
            }
            let verdict = self.follow_over(&stretch, &mut queried);
            *times += queried.len() as u64;
            if let Some(verdict) = verdict {
                return verdict;
            }
            from = stretch.last().map_or(Tick::MAX, |it| it.to);
            intervals = (2 * intervals).min(MAX_INTERVALS);
        }
        SweepVerdict::Free(self.found.clearance)
    }

    /// Returns the stretch that begins at a time, of this many intervals at most, and adds the times at which the broad phase
    /// looked at pairs. Fails if time runs out.
    fn next_stretch(
        &mut self,
        from: Tick,
        intervals: usize,
        queried: &mut Vec<Tick>,
    ) -> Result<Vec<Interval>, SweepVerdict> {
        let (mut stretch, mut next, mut pairs) = (Vec::new(), from, 0);
        loop {
            if self.broad_phase {
                queried.push(next);
            }
            let Some(interval) = self.next_interval(next) else {
                let at = self.sheet.motion.place(from);
                return Err(SweepVerdict::Undecided { faces: None, at });
            };
            next = interval.to;
            pairs += interval.unseen.len();
            stretch.push(interval);
            if !self.broad_phase || stretch.len() >= intervals || pairs >= MAX_UNSEEN {
                return Ok(stretch);
            }
        }
    }

    /// Makes a helper for each thread but one, if the work is worth it, and lets the helpers begin the motion.
    fn find_helpers(&mut self) {
        let pieces = self.sheet.pieces.list.len();
        let segments = usize::try_from(self.sheet.motion.end() / SEGMENT).unwrap_or(usize::MAX);
        let work = pieces.saturating_mul(segments);
        let is_shared = self.broad_phase && parallel::is_shared(work, TIME_PER_PIECE);
        let count = if is_shared {
            let affordable = MAX_FOLLOWERS.min(MAX_FOLLOWED_PIECES / pieces).max(1);
            parallel::threads().min(affordable) - 1
        } else {
            0
        };
        self.helpers.truncate(count);
        while self.helpers.len() < count {
            self.helpers.push(self.helper());
        }
        let motion = &self.sheet.motion;
        for helper in &mut self.helpers {
            helper.begin(motion.clone());
        }
    }

    /// Makes a follower of the same sheet, for pairs of pieces.
    fn helper(&self) -> Self {
        let hinges = (self.memberships, self.groups);
        let pieces = self.sheet.pieces.clone();
        let (clusters, closure) = (Hierarchy::default(), Some(self.options.closure));
        let source = Box::new(SheetPairs::of_follower(self.pattern, self.memberships));
        let hierarchy = self.sheet.hierarchy.clone();
        Self {
            approach: Approach::new(self.pattern, hinges, &clusters, closure, pieces.beyond()),
            sheet: PlacedPieces::new(self.pattern, (pieces, hierarchy), source, false),
            comoving: ComovingNow::default(),
            queue: Queue::default(),
            found: Found::default(),
            changes: self.changes.clone(),
            helpers: Vec::new(),
            records: Vec::new(),
            ..*self
        }
    }

    /// Returns the interval that begins at a time; `None` if it was not looked at.
    fn next_interval(&mut self, from: Tick) -> Option<Interval> {
        let mut next = Interval {
            from,
            to: Tick::MAX,
            touching: Vec::new(),
            unseen: Vec::new(),
            before: from,
        };
        if self.broad_phase {
            self.sheet.time = from;
            let answer = self.ask(Batch::Interval);
            self.found.counts.skipped_bounds += answer.skipped;
            if matches!(answer.outcome, QueryOutcome::Undecided) {
                return None;
            }
            if let Some((_, to)) = answer.batches.first() {
                next.to = *to;
                let (unseen, [before, ..]) = answer.pieces;
                (next.unseen, next.before) = (unseen, before);
                return Some(next);
            }
            self.broad_phase = false;
            if answer.clusters {
                self.add_root(from);
            }
        }
        if from < self.sheet.motion.end() {
            next.to = (from / SEGMENT + 1) * SEGMENT;
        }
        Some(next)
    }

    /// Follows all pairs over a stretch, and adds the times at which some were queried. Returns the verdict if one ends the
    /// motion.
    fn follow_over(
        &mut self,
        stretch: &[Interval],
        queried: &mut Vec<Tick>,
    ) -> Option<SweepVerdict> {
        let [from, to] = [stretch.first()?.from, stretch.last()?.to];
        let (found, expected) = (self.found, self.last_queries);
        let mut helpers = core::mem::take(&mut self.helpers);
        let mut followers: Vec<&mut Self> = vec![&mut *self];
        followers.extend(&mut helpers);
        let count = followers.len();
        let queries: u64 = followers.iter().map(|it| it.queries).sum();
        let new = stretch.iter().map(|it| it.touching.len() + it.unseen.len());
        let mut pairs: usize = new.sum();
        for follower in &mut followers {
            follower.best = found.best();
            follower.found.clearance = found.clearance;
            follower.begin_records(from, queries);
            pairs += follower.queue.count_before(to);
        }
        // Pairs are queried about as often as over the stretch before.
        let most = pairs.max(expected);
        let each = parallel::total_time(most.div_ceil(count), TIME_PER_QUERY);
        parallel::change(&mut followers, each, |number, follower| {
            let mut intervals = stretch.iter();
            let ending = intervals.find_map(|it| follower.follow(it, [number, count]));
            follower.ending = ending;
        });
        let verdict = settle(&mut followers, queried);
        let all: u64 = followers.iter().map(|it| it.queries).sum();
        self.last_queries = usize::try_from(all - queries).unwrap_or(usize::MAX);
        for helper in &mut helpers {
            if let Some(clearance) = helper.found.clearance {
                self.found.note_clearance(clearance);
            }
            self.found.counts += core::mem::take(&mut helper.found.counts);
        }
        self.helpers = helpers;
        verdict
    }

    /// Begins to record what is found over a stretch, after this number of queries by all followers.
    fn begin_records(&mut self, time: Tick, queries: u64) {
        let left = self.options.max_queries.saturating_sub(queries);
        self.most_queries = self.queries.saturating_add(left);
        self.records.clear();
        self.record(time, None);
    }

    fn record(&mut self, time: Tick, faces: Option<[FaceId; 2]>) {
        self.records.push(Record {
            time,
            found: self.found,
            queries: self.queries,
            faces,
        });
    }

    /// Follows those pairs over an interval that fall to this one of all followers. Returns what ends the motion, and when.
    fn follow(
        &mut self,
        interval: &Interval,
        [number, count]: [usize; 2],
    ) -> Option<(Tick, Ending)> {
        let own = |pair: &&[u32; 2]| follower_of(**pair, count) == number;
        let Interval { from, to, .. } = *interval;
        if !interval.touching.is_empty() || !interval.unseen.is_empty() {
            self.enter(from);
            for pair in interval.touching.iter().filter(own) {
                self.add(*pair, from);
            }
            let unseen: Vec<[u32; 2]> = interval.unseen.iter().filter(own).copied().collect();
            if !self.add_unseen(&unseen, [interval.before, from, to]) {
                return Some((from, Ending::Undecided(None)));
            }
        }
        let end = self.sheet.motion.end();
        while self.queries <= self.most_queries
            && let Some((time, due)) = self.queue.next_before(to)
        {
            #[allow(clippy::cast_precision_loss, reason = "a part of the motion")]
            self.watch.part(time as f64 / end as f64);
            let pairs = due.iter().map(|&pair| &self.queue[pair]);
            let pairs = pairs.filter(|pair| !matches!(pair.kind, Kind::Batch(_)));
            let faces = pairs.map(|pair| self.sheet.faces(pair.nodes)).min();
            let ending = self.query_all(time, due);
            self.record(time, faces);
            if let Some(ending) = ending {
                return Some((time, ending));
            }
        }
        None
    }

    fn verdict(&mut self, ending: Ending, time: Tick) -> SweepVerdict {
        match ending {
            Ending::Crosses(crossing, pair) => self.first(crossing, pair, time),
            Ending::Certain(verdict) => verdict,
            Ending::Undecided(faces) => {
                let at = self.sheet.motion.place(time);
                SweepVerdict::Undecided { faces, at }
            }
        }
    }
}

/// Returns the number of the follower to which a pair falls. Ways to a face are searched together, so that all pairs with the
/// same second piece fall to one follower.
fn follower_of([_, second]: [u32; 2], count: usize) -> usize {
    let mixed = u64::from(second).wrapping_mul(0x9e37_79b9_7f4a_7c15);
    (mixed >> 32) as usize % count
}

/// Finds what ends the motion first, if anything does, and leaves out what was found later. Adds the times at which pairs
/// were queried.
fn settle(followers: &mut [&mut Sweep<'_>], queried: &mut Vec<Tick>) -> Option<SweepVerdict> {
    let spent = spent(followers);
    let endings = followers.iter().filter_map(|follower| follower.ending);
    let times = endings.map(|(time, _)| time);
    let last = times.chain(spent.map(|(time, _)| time)).min();
    for follower in &mut *followers {
        let records = follower.records.iter();
        let told: Vec<&Record> = records
            .take_while(|it| last.is_none_or(|last| it.time <= last))
            .collect();
        queried.extend(told.iter().skip(1).map(|it| it.time));
        if let Some(record) = told.last() {
            follower.found = record.found;
        }
    }
    queried.sort_unstable();
    queried.dedup();
    let last = last?;
    if let Some((time, faces)) = spent
        && time == last
    {
        let at = followers.first()?.sheet.motion.place(time);
        return Some(SweepVerdict::Undecided { faces, at });
    }
    let endings = followers.iter().enumerate().filter_map(|(number, it)| {
        let (_, ending) = it.ending.filter(|(time, _)| *time == last)?;
        Some((number, ending))
    });
    let (number, ending) = endings.reduce(|first, other| {
        if other.1.precedes(&first.1) {
            other
        } else {
            first
        }
    })?;
    Some(followers.get_mut(number)?.verdict(ending, last))
}

/// Returns the time at which all followers together had made more queries than they may, if they had, and the faces of a
/// pair that was due then.
fn spent(followers: &[&mut Sweep<'_>]) -> Option<(Tick, Option<[FaceId; 2]>)> {
    let most = followers.first()?.options.max_queries;
    let all: u64 = followers.iter().map(|it| it.queries).sum();
    if all <= most {
        return None;
    }
    let records = followers.iter().map(|it| &it.records[..]);
    let first = records.clone().filter_map(<[Record]>::first);
    let mut sum: u64 = first.map(|it| it.queries).sum();
    let steps = records.flat_map(|it| it.windows(2));
    let steps = steps.map(|it| (it[1].time, it[1].faces, it[1].queries - it[0].queries));
    let mut steps: Vec<_> = steps.collect();
    steps.sort_unstable();
    let exceeds = |&&(_, _, queries): &&(_, _, u64)| {
        sum += queries;
        sum > most
    };
    let &(time, ..) = steps.iter().find(exceeds)?;
    // Those at the same time are ordered by their faces.
    let &(_, faces, _) = steps.iter().find(|it| it.0 == time)?;
    Some((time, faces))
}

#[cfg(test)]
mod tests {
    use core::f64::consts::PI;

    use foldpath_core::Curve;
    use nalgebra::Vector2;
    use rand_pcg::Pcg64;
    use rand_pcg::rand_core::Rng as _;

    use super::*;
    use crate::collision::SweepOptions;
    use crate::pattern::{CreasePattern, Drawing, DrawnEdge, Letter};
    use crate::symmetry::CreaseGroups;

    /// Returns a strip of squares.
    fn strip(squares: usize) -> CreasePattern {
        #[allow(clippy::cast_precision_loss, reason = "a small number")]
        let place = |k: usize| Vector2::new((k / 2) as f64, (k % 2) as f64);
        let edge = |ends| DrawnEdge {
            ends,
            letter: Letter::Unassigned,
            goal: None,
        };
        let across = (0..=squares).map(|k| edge([2 * k, 2 * k + 1]));
        let along = (0..2 * squares).map(|k| edge([k, k + 2]));
        let drawing = Drawing {
            vertices: (0..2 * squares + 2).map(place).collect(),
            edges: across.chain(along).collect(),
            faces: None,
        };
        CreasePattern::new(drawing).unwrap()
    }

    /// Returns a motion through these angles of all hinges.
    fn through(stops: &[Vec<f64>]) -> Vec<Vec<Curve<f64>>> {
        let between = |pair: &[Vec<f64>]| {
            let ends = pair[0].iter().zip(&pair[1]);
            let curves = ends.map(|(from, to)| {
                let at = |part: f64| from + part * (to - from);
                Curve::Angle([0.0, 1.0 / 3.0, 2.0 / 3.0, 1.0].map(at))
            });
            curves.collect()
        };
        stops.windows(2).map(between).collect()
    }

    /// Strips that are rolled up and folded as accordions, whose layers touch, and others that are folded at random, some of
    /// which cross, all with few and many queries.
    #[test]
    fn answers_do_not_depend_on_the_number_of_followers() {
        let mut random = Pcg64::new(11, 1);
        let mut noise = || f64::from(random.next_u32()) / f64::from(u32::MAX) * 2.0 - 1.0;
        let mut answers = [0; 3];
        for round in 0..8 {
            let (hinges, segments) = (29, 200);
            let pattern = strip(hinges + 1);
            let groups = CreaseGroups::trivial(&pattern);
            let goal: Vec<f64> = (0..hinges)
                .map(|k| match round {
                    0 => PI * [1.0, -1.0][k % 2],
                    1 => 0.4 * PI,
                    _ => f64::from(round) * 0.4 * noise(),
                })
                .collect();
            let stop = |number: usize| {
                let angle = |(k, goal): (usize, &f64)| {
                    #[allow(clippy::cast_precision_loss, reason = "a small number")]
                    let part =
                        (number as f64 / segments as f64 * 2.0 - k as f64 / 29.0).clamp(0.0, 1.0);
                    part * goal
                };
                goal.iter().enumerate().map(angle).collect::<Vec<_>>()
            };
            let stops: Vec<Vec<f64>> = (0..=segments).map(stop).collect();
            let motion = through(&stops);
            for most in [200, 10_000_000] {
                let answer = |threads: usize| {
                    let pool = rayon::ThreadPoolBuilder::new().num_threads(threads);
                    pool.build().unwrap().install(|| {
                        let options = SweepOptions::default().with(|it| it.max_queries = most);
                        let members = groups.memberships();
                        let mut sweep = Sweep::new(&pattern, members, options, None);
                        let verdict = sweep.sweep(&motion);
                        assert_eq!(sweep.helpers.len(), threads - 1);
                        // Another motion of the same sheet.
                        let back: Vec<_> = stops.iter().rev().step_by(2).cloned().collect();
                        (
                            verdict,
                            sweep.counts(),
                            sweep.sweep(&through(&back)),
                            sweep.counts(),
                        )
                    })
                };
                let one = answer(1);
                answers[match one.0 {
                    SweepVerdict::Free(_) => 0,
                    SweepVerdict::Crossing { .. } => 1,
                    SweepVerdict::Undecided { .. } => 2,
                }] += 1;
                for threads in [2, 3, 8] {
                    assert_eq!(answer(threads), one, "{round} {most} {threads}");
                }
            }
        }
        assert!(answers.iter().all(|count| *count > 1), "{answers:?}");
    }
}
