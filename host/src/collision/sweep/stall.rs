//! Looks ahead for pairs that stand still: that are queried again and again at hardly later times. Such pieces often pass
//! into each other so slowly that contact turns into a crossing only much later.

use super::motion::Tick;
use super::queue::{Kind, Pair};
use super::touching::Touch;
use super::{Sweep, SweepVerdict};
use crate::collision::Crossing;
use crate::collision::tolerances::{LAST_FREE_TICKS, LOOK_AHEAD_AFTER, MAX_SHORT_STEPS};

/// A run of short steps of a pair: of steps that ended before the next tabulated time.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Stall {
    /// Number of short steps in a row, and half of those in the run before.
    pub(super) count: u32,
    /// Time at which the pair was found to cross, and before which it is not queried any more.
    pub(super) crosses: Option<Tick>,
}

impl Sweep<'_> {
    /// Returns the time at which to query a pair next that is free until `later`: that time or, if the pair stands still
    /// and crosses later on, the time at which it was found to cross. Returns `None` if the pair stands still for so long
    /// that it is given up.
    pub(super) fn past_stall(&mut self, index: u32, later: Tick) -> Option<Tick> {
        let time = self.sheet.time;
        let next = self.sheet.motion.next_tabulated(time);
        let pair = &mut self.queue[index];
        // At a torn side, the angle of the crease may leave pieces free whose places do not.
        let is_followed = matches!(pair.kind, Kind::Pieces | Kind::Meeting | Kind::Vertex(_));
        if later >= next || !is_followed {
            pair.stall.count /= 2;
            return Some(later);
        }
        pair.stall.count += 1;
        if !pair.stall.count.is_multiple_of(LOOK_AHEAD_AFTER) {
            return Some(later);
        }
        let crosses = self.look_ahead(index);
        self.sheet.time = time;
        let stall = &mut self.queue[index].stall;
        stall.crosses = crosses;
        crosses.or_else(|| (stall.count < MAX_SHORT_STEPS).then_some(later))
    }

    /// Looks at a pair at the tabulated times from now on, and returns the first at which it crosses.
    fn look_ahead(&mut self, index: u32) -> Option<Tick> {
        let mut pair = self.queue[index].clone();
        let mut time = self.sheet.time;
        while time < self.sheet.motion.end() {
            let before = time;
            time = self.sheet.motion.next_tabulated(time);
            self.put(&pair, time);
            if self.is_split(&pair) {
                return None;
            }
            match self.touch(&pair, 0.0) {
                Touch::Crosses(_) => return Some(time),
                Touch::Through(_) => match self.through(&pair, [before, time]) {
                    Some(time) => return Some(time),
                    None => pair.above = None,
                },
                Touch::Nowhere => pair.above = None,
                Touch::Flat => {}
            }
        }
        None
    }

    /// Looks at a pair of solids, of which not all facets are known, now and at the tabulated times to come, and returns the
    /// first crossing that is certain.
    pub(super) fn certain_ahead(&mut self, index: u32) -> Option<SweepVerdict> {
        let pair = self.queue[index].clone();
        let now = self.sheet.time;
        let mut time = now;
        let found = loop {
            self.put(&pair, time);
            if self.is_split(&pair) {
                break None;
            }
            if let Touch::Crosses(depth) = self.touch(&pair, 0.0) {
                let depth = self.sheet.placed().least_depth(pair.nodes, depth);
                if depth > self.allowed(&pair).largest() {
                    break Some(SweepVerdict::Crossing {
                        crossing: Crossing::new(self.faces(index), depth),
                        at: self.sheet.motion.place(time),
                        last_free: pair.last.map(|last| self.sheet.motion.place(last)),
                    });
                }
            }
            if time >= self.sheet.motion.end() {
                break None;
            }
            time = self.sheet.motion.next_tabulated(time);
        };
        self.sheet.time = now;
        found
    }

    /// Returns the time at which two pieces leave through each other that lie flat on each other at the first time and have
    /// left by the second; `None` if they may have parted in between, and come round each other's sides.
    fn through(&mut self, pair: &Pair, [mut flat, mut through]: [Tick; 2]) -> Option<Tick> {
        while through - flat > LAST_FREE_TICKS {
            let middle = flat.midpoint(through);
            self.put(pair, middle);
            match self.touch(pair, 0.0) {
                Touch::Flat => flat = middle,
                Touch::Through(_) | Touch::Crosses(_) => through = middle,
                Touch::Nowhere => return None,
            }
        }
        Some(through)
    }

    fn put(&mut self, pair: &Pair, time: Tick) {
        self.sheet.time = time;
        self.sheet.put(pair.nodes);
    }
}
