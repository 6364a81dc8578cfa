//! The motion of a sheet as segments of curves, one for each crease group, with bounds on their variation from
//! one time to another.
//!
//! Times are ticks, 2^36 a segment, so that halves of steps are times too, without rounding.

use foldpath_core::bernstein::restrict;
use foldpath_core::{Curve, HalfAngle, Membership};

use super::Place;
use super::approach::Levers;
use super::variation::Variation;
use crate::collision::narrow::planes::Change;
use crate::collision::tolerances::{
    MAX_TABLE_ENTRIES, SMALL_PARTS, STEP_MULTIPLES, STILL_RAD, TABULATED_TIMES,
};
use crate::lattice::{AngleVariation, Stretch};
use crate::util::nan_max::larger;

/// log2 of the number of ticks in a segment.
const TICKS: u32 = 36;

/// A time, in units of 2^-36 segments.
pub(in crate::collision) type Tick = u64;

/// Length of a segment, ticks.
pub(in crate::collision) const SEGMENT: Tick = 1 << TICKS;

/// Segments of curves with their variation.
#[derive(Clone, Debug, Default)]
pub(in crate::collision) struct Motion {
    segments: usize,
    groups: usize,
    /// For each segment and group its curve, with its variation.
    variations: Vec<Variation>,
    /// For each segment and group, and after the last segment: number of segments before in which the group turns at all.
    turned_in: Vec<u32>,
    /// Ticks from one tabulated time to the next.
    stride: Tick,
    /// For each tabulated time and group the variation since the beginning, radians.
    table: Vec<f64>,
    /// For each tabulated time the sum, over the steps up to it, of the largest variation of a group in the
    /// step, radians.
    clock: Vec<f64>,
}

impl Motion {
    /// Tabulates a motion. `segments` hold a curve for each group; groups without one stay flat. Cost: O(groups
    /// x segments), and the evaluation of some ten thousand angles at most.
    pub(in crate::collision) fn new(segments: &[Vec<Curve<f64>>], groups: usize) -> Self {
        const FLAT: Curve<f64> = Curve::Angle([0.0; 4]);
        let curve = |segment: &Vec<Curve<f64>>, group| segment.get(group).copied().unwrap_or(FLAT);
        let all = segments.iter().flat_map(|segment| {
            (0..groups).map(move |group| Variation::new(curve(segment, group)))
        });
        let count = segments.len().max(1);
        let most =
            (MAX_TABLE_ENTRIES / (groups.max(1) * count)).min(TABULATED_TIMES.div_ceil(count));
        let per_segment = 1_u32 << most.max(1).ilog2();
        let mut motion = Self {
            segments: segments.len(),
            groups,
            variations: all.collect(),
            turned_in: vec![0; groups],
            stride: (1 << TICKS) / u64::from(per_segment),
            table: vec![0.0; groups],
            clock: vec![0.0],
        };
        for segment in 0..segments.len() {
            motion.tabulate(segment, per_segment);
            for entry in segment * groups..(segment + 1) * groups {
                let turns = !motion.variations[entry].rests();
                motion
                    .turned_in
                    .push(motion.turned_in[entry] + u32::from(turns));
            }
        }
        motion
    }

    fn tabulate(&mut self, segment: usize, per_segment: u32) {
        let start = self.table.len() - self.groups;
        for step in 1..=per_segment {
            let s = f64::from(step) / f64::from(per_segment);
            let mut most = 0.0_f64;
            for group in 0..self.groups {
                let until = self.variations[segment * self.groups + group].until(s);
                let varied = self.table[start + group] + until;
                most = most.max(varied - self.table[self.table.len() - self.groups]);
                self.table.push(varied);
            }
            let before = self.clock.last().copied().unwrap_or_default();
            self.clock.push(before + most);
        }
    }

    /// Returns `true` if all variation is finite.
    pub(in crate::collision) fn is_finite(&self) -> bool {
        let curves = self.variations.iter().all(Variation::is_finite);
        curves && self.table.iter().all(|varied| varied.is_finite())
    }

    /// Returns for each group `true` if it does not turn over a segment, except for rounding; an empty list if
    /// all groups turn.
    pub(in crate::collision) fn still(&self, segment: usize) -> Vec<bool> {
        let variations = self
            .variations
            .iter()
            .skip(segment * self.groups)
            .take(self.groups);
        let still: Vec<bool> = variations.map(|v| v.until(1.0) <= STILL_RAD).collect();
        if still.contains(&true) {
            still
        } else {
            Vec::new()
        }
    }

    /// Returns a bound on the total variation of a crease's angle from one time to another of the same segment,
    /// radians.
    pub(in crate::collision) fn turned(&self, times: [Tick; 2], crease: Membership) -> f64 {
        let (segment, [s, end]) = self.stretch(times);
        let variation = self.variation(segment, crease);
        variation.until(end) - variation.until(s)
    }

    /// Returns the Bernstein coefficients of a crease's angle from one time to another of the same segment, radians: the
    /// angle is within them. They are no numbers for half-angle curves.
    pub(in crate::collision) fn course(&self, times: [Tick; 2], crease: Membership) -> [f64; 4] {
        let (segment, stretch) = self.stretch(times);
        let sign = if crease.negative { -1.0 } else { 1.0 };
        match &self.variation(segment, crease).curve {
            Curve::Angle(angle) => restrict(angle, stretch).map(|angle| sign * angle),
            _ => [f64::NAN; 4],
        }
    }

    /// Returns `true` if a group keeps its angle, without rounding, in all segments that have a part between two times.
    pub(in crate::collision) fn rests(&self, group: usize, [from, to]: [Tick; 2]) -> bool {
        let turned_before = |segment: Tick| {
            let segment = usize::try_from(segment).unwrap_or(usize::MAX);
            self.turned_in[segment.min(self.segments) * self.groups + group]
        };
        turned_before(from >> TICKS) == turned_before(to.div_ceil(SEGMENT))
    }

    /// Returns `true` if a group keeps its angle, without rounding, from the segment of a time to the end of the motion.
    pub(super) fn rests_from(&self, group: usize, time: Tick) -> bool {
        self.rests(group, [time, self.end()])
    }

    fn variation(&self, segment: usize, crease: Membership) -> &Variation {
        &self.variations[segment * self.groups + crease.group.index()]
    }

    /// Returns the last time.
    pub(in crate::collision) fn end(&self) -> Tick {
        (self.segments as Tick) << TICKS
    }

    /// Returns the place of a time.
    pub(in crate::collision) fn place(&self, tick: Tick) -> Place {
        let segment = usize::try_from(tick >> TICKS).unwrap_or(usize::MAX);
        let segment = segment.min(self.segments.saturating_sub(1));
        let rest = tick - ((segment as Tick) << TICKS);
        #[allow(clippy::cast_precision_loss, reason = "37 bits are exact")]
        let s = rest as f64 / (1_u64 << TICKS) as f64;
        Place { segment, s }
    }

    /// Returns the segment of two times, and the parameters in it.
    fn stretch(&self, [from, to]: [Tick; 2]) -> (usize, [f64; 2]) {
        let Place { segment, s } = self.place(from);
        #[allow(clippy::cast_precision_loss, reason = "37 bits are exact")]
        let end = s + (to - from) as f64 / SEGMENT as f64;
        (segment, [s, end])
    }

    /// Returns the first place found at which a group turns past half a turn by more than `slack` radians:
    /// segment, parameter in it, group and angle.
    pub(super) fn overturned(&self, slack: f64) -> Option<(usize, f64, usize, f64)> {
        let segments = self.variations.chunks(self.groups.max(1));
        segments.enumerate().find_map(|(segment, variations)| {
            let found = variations
                .iter()
                .enumerate()
                .filter_map(|(group, variation)| {
                    let s = variation.overturned(slack)?;
                    Some((segment, s, group, variation.curve.angle(s)))
                });
            found.min_by(|a, b| a.1.total_cmp(&b.1))
        })
    }

    /// Returns half the angle of a group at a time.
    pub(in crate::collision) fn half_angle(&self, group: usize, tick: Tick) -> HalfAngle<f64> {
        let Place { segment, s } = self.place(tick);
        let variation = self.variations.get(segment * self.groups + group);
        variation.map_or_else(HalfAngle::default, |v| v.curve.half_angle(s))
    }

    /// Returns the angle of a group at a time, radians.
    pub(super) fn angle(&self, group: usize, tick: Tick) -> f64 {
        let Place { segment, s } = self.place(tick);
        let variation = self.variations.get(segment * self.groups + group);
        variation.map_or(0.0, |v| v.curve.angle(s))
    }

    /// Computes half the angle of each group at a time.
    pub(in crate::collision) fn half_angles(&self, tick: Tick, half_angles: &mut [HalfAngle<f64>]) {
        for (group, half) in half_angles.iter_mut().enumerate() {
            *half = self.half_angle(group, tick);
        }
    }

    /// Computes the first and second derivative of each group's angle at a time, radians per segment and per squared segment;
    /// where two segments meet, those of the later one.
    pub(in crate::collision) fn derivatives(&self, tick: Tick, derivatives: &mut Vec<[f64; 2]>) {
        let Place { segment, s } = self.place(tick);
        let variations = &self.variations[segment * self.groups..][..self.groups];
        derivatives.clear();
        derivatives.extend(variations.iter().map(|it| it.curve.derivatives(s)));
    }

    /// Computes upper bounds on the absolute third derivative of each group's angle, radians per cubed segment, over each of the
    /// `parts` equal parts of the segment that begins at `tick`.
    pub(in crate::collision) fn third_derivatives(
        &self,
        tick: Tick,
        parts: u32,
        bounds: &mut Vec<f64>,
    ) {
        let segment = self.place(tick).segment;
        let variations = &self.variations[segment * self.groups..][..self.groups];
        bounds.clear();
        for part in 0..parts {
            let [s, end] = [part, part + 1].map(|k| f64::from(k) / f64::from(parts));
            bounds.extend(variations.iter().map(|it| it.third_derivative(s, end)));
        }
    }

    /// Computes the changes of the given groups from one time to another of the same segment: along the law of time or, if
    /// they are nearer to it, along that of the group that turns most.
    pub(in crate::collision) fn changes(
        &self,
        groups: &[u32],
        from: Tick,
        to: Tick,
        changes: &mut [Change],
    ) {
        let (segment, [s, end]) = self.stretch([from, to]);
        for &group in groups {
            let variation = &self.variations[segment * self.groups + group as usize];
            changes[group as usize] = variation.change(s, end);
        }
        let off = |changes: &[Change]| groups.iter().map(|&it| changes[it as usize].off).sum();
        let in_time: f64 = off(changes);
        let by = |group: &&u32| changes[**group as usize].by.abs();
        let lead = groups.iter().max_by(|a, b| by(a).total_cmp(&by(b)));
        let Some(&lead) = lead.filter(|_| in_time > 0.0 && groups.len() > 1) else {
            return;
        };
        let course = |group: u32| {
            let variation = &self.variations[segment * self.groups + group as usize];
            let Curve::Angle(angle) = variation.curve else {
                return [f64::NAN; 4];
            };
            let [first, ref inner @ .., last] = restrict(&angle, [s, end]);
            [0.0, inner[0] - first, inner[1] - first, last - first]
        };
        let law = course(lead).map(|turned| turned / changes[lead as usize].by);
        // On its way the leading group may not turn back.
        if !law
            .iter()
            .all(|part| (0.0..=1.0 + f64::EPSILON).contains(part))
        {
            return;
        }
        let along = |group: u32| {
            let by = changes[group as usize].by;
            let offs = course(group).into_iter().zip(law);
            let offs = offs.map(|(turned, part)| (turned - by * part).abs());
            Change {
                by,
                off: offs.fold(0.0, larger),
            }
        };
        let led: Vec<Change> = groups.iter().map(|&group| along(group)).collect();
        let by_law: f64 = led.iter().map(|change| change.off).sum();
        if by_law < in_time {
            for (&group, change) in groups.iter().zip(led) {
                changes[group as usize] = change;
            }
        }
    }

    /// Returns the first tabulated time after `tick`.
    pub(in crate::collision) fn next_tabulated(&self, tick: Tick) -> Tick {
        self.tabulated_after(tick, 1)
    }

    /// Returns the tabulated time that follows `tick` as number `count`, or the last one.
    pub(in crate::collision) fn tabulated_after(&self, tick: Tick, count: usize) -> Tick {
        ((tick / self.stride + count as Tick) * self.stride).min(self.end())
    }

    /// Returns the position of a time among the tabulated ones, if it is one of them.
    pub(in crate::collision) fn tabulated(&self, tick: Tick) -> Option<usize> {
        tick.is_multiple_of(self.stride).then(|| self.index(tick))
    }

    /// Returns the tabulated time of this position.
    pub(in crate::collision) fn tick(&self, index: usize) -> Tick {
        index as Tick * self.stride
    }

    /// Returns the rest of the interval between tabulated times that contains a time; empty at a tabulated time.
    pub(in crate::collision) fn rest(&self, tick: Tick) -> Stretch {
        let next = self.index(tick + self.stride - 1);
        let rest = self.tick(next) - tick;
        #[allow(clippy::cast_precision_loss, reason = "37 bits are exact")]
        Stretch {
            head: rest as f64 / self.stride as f64,
            from: next,
            to: next,
        }
    }

    /// Returns about the last time after `tick` and before the next tabulated one until which points have
    /// `moved` by no more than `allowance`, and the bound on their motion until then. Returns `None` if that
    /// time is less than a small part of the interval after `tick`.
    pub(in crate::collision) fn before_next(
        &self,
        tick: Tick,
        allowance: f64,
        moved: impl Fn(Stretch) -> f64,
    ) -> Option<(Tick, f64)> {
        if tick >= self.end() {
            return None;
        }
        let next = self.index(tick) + 1;
        let until = |part: u32| {
            let head = f64::from(part) / f64::from(SMALL_PARTS);
            moved(Stretch {
                head,
                from: next,
                to: next,
            })
        };
        let [one, two] = [1, 2].map(until);
        let (steady, each) = (2.0 * one - two, two - one);
        let most = f64::from(SMALL_PARTS - 1);
        #[allow(
            clippy::cast_possible_truncation,
            clippy::cast_sign_loss,
            reason = "a number of parts, put between two"
        )]
        let part = ((allowance - steady) / each).clamp(0.0, most) as u32;
        let (later, by) = (
            tick + Tick::from(part) * (self.stride / Tick::from(SMALL_PARTS)),
            until(part),
        );
        (part > 0 && by <= allowance && later <= self.next_tabulated(tick)).then_some((later, by))
    }

    /// Returns the time half way from a tabulated one to the next.
    pub(in crate::collision) fn half_way(&self, index: usize) -> Tick {
        self.tick(index) + self.stride / 2
    }

    /// Returns the curves of the groups over each segment, with the position of the segment's last tabulated time.
    pub(in crate::collision) fn segments(&self) -> impl Iterator<Item = (usize, Vec<Curve<f64>>)> {
        let all = self.variations.chunks(self.groups.max(1)).enumerate();
        all.map(|(segment, variations)| {
            let curves = variations.iter().map(|variation| variation.curve);
            (
                self.index(((segment + 1) as Tick) << TICKS),
                curves.collect(),
            )
        })
    }

    /// Computes the variation of each group from a tabulated time to the next.
    pub(in crate::collision) fn angle_variations(
        &self,
        index: usize,
        variations: &mut Vec<AngleVariation>,
    ) {
        let Place { segment, s } = self.place(self.tick(index));
        let end = s + 1.0 / self.per_segment();
        variations.clear();
        variations.extend((0..self.groups).map(|group| {
            let row = |index: usize| self.table[index * self.groups + group];
            let variation = &self.variations[segment * self.groups + group];
            AngleVariation {
                total: row(index + 1) - row(index),
                nonlinearity: variation.bulge(s, end),
            }
        }));
    }

    #[allow(clippy::cast_precision_loss, reason = "a power of two")]
    fn per_segment(&self) -> f64 {
        ((1 << TICKS) / self.stride) as f64
    }

    fn index(&self, tick: Tick) -> usize {
        usize::try_from(tick / self.stride).unwrap_or(usize::MAX)
    }

    /// Returns a bound on how far points have moved since the beginning of the motion. The difference between
    /// two times is a bound on their motion in between.
    pub(super) fn moved(&self, levers: &Levers, tick: Tick) -> f64 {
        if tick.is_multiple_of(self.stride) {
            return self.moved_tabulated(levers, self.index(tick));
        }
        let Place { segment, s } = self.place(tick);
        let start = segment * self.index(1 << TICKS) * self.groups;
        levers.sum(|group| {
            let until = self.variations[segment * self.groups + group].until(s);
            self.table[start + group] + until
        })
    }

    fn moved_tabulated(&self, levers: &Levers, index: usize) -> f64 {
        let row = &self.table[index * self.groups..];
        levers.sum(|group| row[group]) + levers.any * self.clock[index]
    }

    /// Returns the last tabulated time until which points move no farther than `allowance` from where they are
    /// at `from`, if there is one after `from`.
    pub(super) fn tabulated_until(
        &self,
        levers: &Levers,
        from: Tick,
        allowance: f64,
    ) -> Option<Tick> {
        let limit = self.moved(levers, from) + allowance;
        let (mut low, mut high) = (self.index(from), self.clock.len());
        while high - low > 1 {
            let middle = (low + high) / 2;
            if self.moved_tabulated(levers, middle) <= limit {
                low = middle;
            } else {
                high = middle;
            }
        }
        let until = low as Tick * self.stride;
        (until > from).then_some(until)
    }

    /// Returns times after `from` up to `next`, at growing distances.
    pub(in crate::collision) fn halves(
        &self,
        from: Tick,
        next: Tick,
    ) -> impl Iterator<Item = Tick> + use<> {
        let mut unit = 1 << (from % self.stride).trailing_zeros().min(TICKS);
        let mut at = from;
        core::iter::from_fn(move || {
            let more = at < next;
            at = ((at / unit + 1) * unit).min(next);
            unit *= 2;
            more.then_some(at)
        })
    }

    /// Returns a time after `from` until which points move no farther than `allowance`: within a constant
    /// factor the last such time before the next tabulated one, and at least one tick later.
    pub(super) fn until(&self, levers: &Levers, from: Tick, allowance: f64) -> Tick {
        let (start, next) = (self.moved(levers, from), self.next_tabulated(from));
        #[allow(
            clippy::cast_possible_truncation,
            clippy::cast_sign_loss,
            clippy::cast_precision_loss,
            reason = "a first guess, put right below"
        )]
        let guess = (allowance / (self.moved(levers, next) - start) * (next - from) as f64) as u64;
        let mut unit = 1 << guess.clamp(1, self.stride).ilog2();
        loop {
            let places = (1..=STEP_MULTIPLES).rev().map(|k| (from / unit + k) * unit);
            let reached = places
                .filter(|&tick| tick < next)
                .find(|&tick| self.moved(levers, tick) - start <= allowance);
            if let Some(tick) = reached {
                return tick;
            }
            if unit == 1 {
                return from + 1;
            }
            unit = (unit / 4).max(1);
        }
    }
}

#[cfg(test)]
mod tests {
    use rand_pcg::Pcg64;
    use rand_pcg::rand_core::Rng;

    use super::*;

    /// All groups keep to the same part of their changes, that of time or that of one of them, as nearly as the changes say.
    /// Groups that turn by one law keep to it without an error.
    #[test]
    fn groups_keep_to_one_part_of_their_changes() {
        let mut random = Pcg64::new(56, 3);
        let mut noise = || f64::from(random.next_u32()) / f64::from(u32::MAX) * 2.0 - 1.0;
        let mut led = 0;
        for case in 0..1000 {
            let law = [0.0, noise().abs() / 3.0, 1.0 - noise().abs() / 3.0, 1.0];
            let one_law = case % 2 == 0;
            let groups = 2 + case % 4;
            let curves: Vec<Curve<f64>> = (0..groups)
                .map(|_| {
                    let (from, by) = (noise(), noise());
                    Curve::Angle(law.map(|part| {
                        let other = if one_law || part == 0.0 {
                            0.0
                        } else {
                            0.1 * noise()
                        };
                        from + by * (part + other)
                    }))
                })
                .collect();
            let motion = Motion::new(core::slice::from_ref(&curves), groups);
            let step = SEGMENT / 4 * (1 + case as Tick % 4);
            let mut changes = vec![Change { by: 0.0, off: 0.0 }; groups];
            let numbers: Vec<u32> = (0..groups)
                .map(|group| u32::try_from(group).unwrap())
                .collect();
            motion.changes(&numbers, 0, step, &mut changes);
            let turned = |group: usize, part: f64| {
                let end = step as f64 / SEGMENT as f64;
                curves[group].angle(part * end) - curves[group].angle(0.0)
            };
            let keeps = |lead: Option<usize>| {
                (0..=20).map(|k| f64::from(k) / 20.0).all(|time| {
                    let part = lead.map_or(time, |lead| turned(lead, time) / changes[lead].by);
                    let near = |group: usize| {
                        let off = turned(group, time) - changes[group].by * part;
                        off.abs() <= changes[group].off + 1e-12
                    };
                    (-1e-12..=1.0 + 1e-12).contains(&part) && (0..groups).all(near)
                })
            };
            let is_led = (0..groups).any(|lead| keeps(Some(lead)));
            assert!(keeps(None) || is_led, "{case}: {changes:?}");
            led += u32::from(is_led && !keeps(None));
            if one_law {
                assert!(
                    changes.iter().all(|change| change.off < 1e-15),
                    "{case}: {changes:?}"
                );
            }
        }
        assert!(led > 400, "{led}");
    }
}
