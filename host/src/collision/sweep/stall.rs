//! What a sweep does about a pair that stands still: one that is queried again and again at hardly later times.

use super::Sweep;
use super::motion::Tick;
use super::queue::{Kind, Pair};
use crate::collision::narrow::separation::distance;
use crate::collision::tolerances::{LAST_FREE_TICKS, LOOK_AHEAD_AFTER, TOUCHING_RATIO};

/// A run of short steps of a pair: of steps that ended before the next tabulated time.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Stall {
    /// Number of short steps in a row.
    pub(super) count: u32,
    /// Time at which the first began.
    since: Tick,
    /// `true` if the pair was found to cross at the time of its next query, and not followed up to there.
    pub(super) crosses: bool,
}

impl Sweep<'_> {
    /// Returns the time at which to query a pair next that is free until `later`. That is the time itself, unless the pair
    /// stands still and crosses later on: then the time at which it was found to cross. Returns `None` if the pair stays in
    /// contact for longer than the queries that are left suffice for.
    pub(super) fn past_stall(&mut self, index: u32, later: Tick) -> Option<Tick> {
        let time = self.sheet.time;
        let next = self.sheet.motion.next_tabulated(time);
        let stall = &mut self.queue[index].stall;
        if later >= next {
            *stall = Stall::default();
            return Some(later);
        }
        if stall.count == 0 {
            stall.since = time;
        }
        stall.count += 1;
        let Stall { count, since, .. } = *stall;
        if count % LOOK_AHEAD_AFTER != 0
            || matches!(self.queue[index].kind, Kind::Clusters | Kind::Batch(_))
        {
            return Some(later);
        }
        let ahead = self.look_ahead(index);
        self.sheet.time = time;
        match ahead {
            Ahead::Crosses(at) => {
                self.queue[index].stall.crosses = true;
                Some(at)
            }
            Ahead::Touches { until } => {
                let left = self.options.max_queries.saturating_sub(self.queries);
                #[allow(clippy::cast_precision_loss, reason = "an estimate")]
                let needed = (until - time) as f64 / (later - since) as f64 * f64::from(count);
                #[allow(clippy::cast_precision_loss, reason = "an estimate")]
                let suffices = needed <= left as f64;
                suffices.then_some(later)
            }
        }
    }

    /// Looks at a pair at the tabulated times from now on, up to the first at which it crosses.
    fn look_ahead(&mut self, index: u32) -> Ahead {
        let pair = self.queue[index].clone();
        let (mut touching, mut apart) = (self.sheet.time, None);
        let mut time = touching;
        while time < self.sheet.motion.end() {
            time = self.sheet.motion.next_tabulated(time);
            self.sheet.time = time;
            self.sheet.put(pair.nodes);
            if self.is_split(&pair) {
                break;
            }
            if self.sheet.depth(pair.nodes, self.allowed(&pair)) > 0.0 {
                return Ahead::Crosses(time);
            }
            match apart {
                None if self.touches(&pair) => touching = time,
                None => apart = Some(time),
                Some(_) => {}
            }
        }
        let mut apart = apart.unwrap_or(touching);
        while apart - touching > LAST_FREE_TICKS {
            let middle = touching.midpoint(apart);
            self.sheet.time = middle;
            self.sheet.put(pair.nodes);
            if self.touches(&pair) {
                touching = middle;
            } else {
                apart = middle;
            }
        }
        Ahead::Touches { until: touching }
    }

    /// Returns `true` if two placed pieces are so near to each other that their next step follows from what separates
    /// them.
    fn touches(&self, pair: &Pair) -> bool {
        let placed = self.sheet.placed();
        let apart = match pair.kind {
            Kind::Vertex(corners) => {
                let [angle, reach] = self.between_sectors(pair.nodes, corners);
                angle * reach
            }
            Kind::Side(_) | Kind::Joined => 0.0,
            _ => distance(&placed.piece(pair.nodes[0]), &placed.piece(pair.nodes[1])),
        };
        apart <= TOUCHING_RATIO * self.allowed(pair).largest()
    }
}

/// What was seen of a pair that stands still.
enum Ahead {
    /// It crosses at a time.
    Crosses(Tick),
    /// It crosses at none of the times looked at, and nearly touches up to a time.
    Touches { until: Tick },
}
