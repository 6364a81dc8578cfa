//! The queue of setpoints: the known part of a path, and the position on it.

use heapless::Deque;

use crate::acceptance::{Refusal, Setpoint, SheetView, most_commanded};
use crate::follower::FollowerPosition;
use crate::{Curve, Interpolation, Scalar, StarsView, closure, segment_bounds};

/// Rounding error of a commanded angle, in precisions (ε) of 1 and the range of its limits.
const COMMAND_EPSILONS: f64 = 64.0;

/// Setpoints of the path; the position lies on the segment behind the first one.
// In order, for the reason given at `Follower`.
#[derive(Clone, Debug)]
#[repr(C)]
pub(super) struct Queue<T, const GROUPS: usize, const KNOTS: usize> {
    interpolation: Interpolation,
    groups: usize,
    /// Largest closure residual at commanded angles.
    closure: T,
    /// Duration of the segment behind the first setpoint (`span`), and the part of it that has passed (`into`), seconds.
    span: T,
    into: T,
    /// Duration of all segments behind that one, seconds.
    rest: T,
    /// Seconds that rounding has kept out of `into` (compensated summation).
    carry: T,
    /// Curves of that segment.
    curves: [Curve<T>; GROUPS],
    /// Smallest angle, largest angle and largest speed of each group.
    bounds: [[T; 3]; GROUPS],
    setpoints: Deque<Setpoint<T, GROUPS>, KNOTS>,
}

impl<T: Scalar, const GROUPS: usize, const KNOTS: usize> Queue<T, GROUPS, KNOTS> {
    // Inlined for the reason given at `Follower::new`.
    #[inline(always)]
    pub(super) fn new() -> Self {
        Self {
            interpolation: Interpolation::default(),
            groups: 0,
            closure: T::zero(),
            bounds: [[T::zero(); 3]; GROUPS],
            setpoints: Deque::new(),
            curves: [Curve::Angle([T::zero(); 4]); GROUPS],
            span: T::zero(),
            into: T::zero(),
            rest: T::zero(),
            carry: T::zero(),
        }
    }

    /// Forgets all setpoints.
    pub(super) fn clear(&mut self) {
        self.setpoints.clear();
        (self.into, self.carry) = (T::zero(), T::zero());
        self.enter();
    }

    /// Begins a path on this sheet, of which the first `into` seconds behind the first setpoint have passed.
    pub(super) fn begin(&mut self, sheet: &SheetView<'_, T>, into: T) {
        self.clear();
        self.interpolation = sheet.interpolation;
        self.groups = sheet.limits.len();
        self.closure = most_commanded(sheet.closure, sheet.stars.max_degree());
        for (bounds, limits) in self.bounds.iter_mut().zip(sheet.limits) {
            *bounds = [limits.lower, limits.upper, limits.speed.min(T::MAX)];
        }
        self.into = into;
    }

    pub(super) fn setpoints(&self) -> &Deque<Setpoint<T, GROUPS>, KNOTS> {
        &self.setpoints
    }

    /// Adds a setpoint that has been checked.
    pub(super) fn push(&mut self, setpoint: Setpoint<T, GROUPS>) -> Result<(), Refusal> {
        let span = setpoint.span;
        self.setpoints
            .push_back(setpoint)
            .map_err(|_| Refusal::Full)?;
        if self.setpoints.len() > 2 {
            self.rest += span;
        } else {
            self.enter();
        }
        Ok(())
    }

    /// Returns `true` if the position is on the first segment, or at the first setpoint.
    pub(super) fn begins(&self) -> bool {
        self.into.is_zero() || self.into > T::zero() && self.into < self.span
    }

    /// Returns the position, if there is a setpoint.
    pub(super) fn position(&self) -> Option<FollowerPosition<T>> {
        self.setpoints.front().map(|first| FollowerPosition {
            knot: first.number,
            into: self.into,
        })
    }

    /// Returns the seconds from the position to a place of the path: the largest number if that is behind the last setpoint,
    /// and not above 0 if it is before the position.
    #[inline(never)]
    pub(super) fn until(&self, place: FollowerPosition<T>) -> T {
        match (self.setpoints.front(), self.setpoints.back()) {
            (Some(first), _) if place.knot < first.number => T::zero(),
            (Some(first), Some(last)) if place.knot <= last.number => {
                let way = place.into - self.into;
                if place.knot > first.number {
                    way + self.span + self.behind(place.knot)
                } else {
                    way
                }
            }
            _ => T::MAX,
        }
    }

    /// Returns the duration of the segments behind the first one up to this knot, seconds.
    #[inline(never)]
    fn behind(&self, knot: u32) -> T {
        let (mut behind, mut index) = (T::zero(), 2);
        while let Some(setpoint) = self.setpoints.get(index)
            && setpoint.number <= knot
        {
            behind += setpoint.span;
            index += 1;
        }
        behind
    }

    /// Returns the largest speed of each group, radians per second.
    pub(super) fn speeds(&self) -> impl Iterator<Item = T> {
        self.bounds.iter().map(|[.., speed]| *speed)
    }

    /// Lowers the largest speed of each group to that of `speed`, radians per second.
    pub(super) fn limit_speeds(&mut self, speed: impl Fn(usize) -> T) {
        for (group, [.., most]) in self.bounds.iter_mut().enumerate() {
            *most = most.min(speed(group));
        }
    }

    /// Returns the first group that would move farther than its speed allows in `dt` seconds, rounding aside.
    pub(super) fn leap(&self, from: &[T; GROUPS], to: &[T; GROUPS], dt: T) -> Option<u16> {
        let dt = dt * segment_bounds::slack();
        let ends = from.iter().zip(to).zip(&self.bounds).take(self.groups);
        let leaps = |(from, to): (&T, &T), [lower, upper, speed]: &[T; 3]| {
            let noise = T::lit(COMMAND_EPSILONS) * T::EPSILON * (T::one() + (*upper - *lower));
            // The comparison is false for a NaN, which is a leap as well.
            let near = (*to - *from).abs() <= *speed * dt + noise;
            !near
        };
        let mut groups = (0..=u16::MAX).zip(ends);
        groups
            .find(|(_, (ends, bounds))| leaps(*ends, bounds))
            .map(|(group, _)| group)
    }

    /// Returns the number of the star whose `turn` it is if it does not close at these angles, within what bounds and
    /// rounding leave to accepted segments. The turn goes to the next star.
    pub(super) fn torn(
        &self,
        stars: StarsView<'_, T>,
        turn: &mut u16,
        angles: &[T; GROUPS],
    ) -> Option<u16> {
        let number = if usize::from(*turn) < stars.len() {
            *turn
        } else {
            0
        };
        let star = stars.get(number.into())?;
        *turn = number.wrapping_add(1);
        (!closure::closes_at(star, angles, self.closure)).then_some(number)
    }

    /// Returns the seconds from the position to the last setpoint, at most the largest number.
    // Not inlined, so that an image has it once.
    #[inline(never)]
    pub(super) fn left(&self) -> T {
        let left = self.span - self.into + self.rest;
        left.max(T::zero()).min(T::MAX)
    }

    /// Advances the position by `step` seconds, at most to the last setpoint.
    pub(super) fn advance(&mut self, step: T) {
        if step <= T::zero() {
            return;
        }
        // The path time left may be less than the rounding of the position.
        let left = self.left();
        let arrived = left - step <= T::EPSILON * left.max(self.into);
        // Behind a knot the position is resolved more finely, so that the carry may be larger than a short step; the
        // position never goes back.
        let (before, step) = (self.into, step + self.carry);
        self.into = (self.into + step).max(before);
        self.carry = step - (self.into - before);
        while self.setpoints.len() > 1 && (arrived || self.into >= self.span) {
            self.into -= self.span;
            self.setpoints.pop_front();
            self.enter();
        }
        if self.setpoints.len() < 2 {
            (self.into, self.carry) = (T::zero(), T::zero());
        }
    }

    /// Makes the curves of the segment behind the first setpoint. Its duration is 0 if there is no such segment.
    fn enter(&mut self) {
        (self.span, self.rest) = (T::zero(), T::zero());
        if let (Some(from), Some(to)) = (self.setpoints.front(), self.setpoints.get(1)) {
            self.span = to.span;
            let ends = from.nodes.iter().zip(&to.nodes);
            for (curve, (from, to)) in self.curves.iter_mut().zip(ends) {
                *curve = Curve::between(self.interpolation, self.span, *from, *to);
            }
            // Summed anew, so that no rounding error outlasts the queue.
            self.rest = self.behind(u32::MAX);
        }
    }

    /// Writes the angles at the position into `angles`, clamped to their bounds, which rounding could leave between knots.
    pub(super) fn angles(&self, mut angles: [T; GROUPS]) -> [T; GROUPS] {
        if self.into > T::zero() {
            let s = self.into / self.span;
            let curves = self.curves.iter().zip(&self.bounds).take(self.groups);
            for (angle, (curve, [lower, upper, _])) in angles.iter_mut().zip(curves) {
                *angle = curve.angle(s).max(*lower).min(*upper);
            }
        } else if let Some(first) = self.setpoints.front() {
            for (angle, node) in angles.iter_mut().zip(&first.nodes) {
                *angle = node.angle;
            }
        }
        angles
    }

    /// Returns the rates at the position, clamped to each group's speed; `clock` is the seconds of the path in a second.
    #[inline(never)]
    pub(super) fn rates(&self, clock: T) -> [T; GROUPS] {
        let mut rates = [T::zero(); GROUPS];
        if self.span > T::zero() {
            let s = self.into / self.span;
            let curves = self.curves.iter().zip(&self.bounds).take(self.groups);
            for (rate, (curve, [.., speed])) in rates.iter_mut().zip(curves) {
                // On a very short segment, rounding alone makes a fast rate.
                let [slope, _] = curve.derivatives(s);
                *rate = (slope * clock / self.span).max(-*speed).min(*speed);
            }
        }
        rates
    }
}
