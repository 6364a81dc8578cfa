//! The watch over hinges that lag behind their commands.

use crate::Scalar;
use crate::follower::Options;

/// Number of lagging hinges that are remembered.
const MAX_REMEMBERED: usize = 4;

/// Time for which a hinge has to be measured elsewhere until that counts, microseconds: longer than an error of one
/// measurement.
const ELSEWHERE_US: u32 = 20_000;

/// A hinge and its distance from its command when it was last measured, radians; 0 for no hinge.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Lag<T> {
    pub(super) hinge: u32,
    pub(super) distance: T,
}

/// The hinges that were farthest from their commands when they were last measured.
///
/// A hinge is remembered until it is measured again, at whatever pace. So neither a sensor that fails now and then nor
/// ticks in which a hinge is not measured hide a hinge that is stuck, unless four others lag farther. A sensor that tells no
/// angle is remembered apart, so that it hides no hinge that is measured.
#[derive(Clone, Copy, Debug)]
pub(super) struct LagWatch<T> {
    /// Distance above which a hinge slows the motion (`slows`), and from which on it holds the motion (`holds`), radians.
    pub(super) slows: T,
    pub(super) holds: T,
    worst: [Lag<T>; MAX_REMEMBERED],
    /// A hinge whose sensor tells no angle, if there is one.
    failed: Option<u32>,
    /// `true` if a hinge is remembered.
    any: bool,
    /// Time for which a hinge was stuck, less the time for which none was, microseconds.
    stuck: u32,
    /// Time for which a hinge has been elsewhere, microseconds.
    elsewhere: u32,
}

impl<T: Scalar> LagWatch<T> {
    /// Creates a watch that remembers nothing, by the distances of these options.
    pub(super) fn new(options: &Options<T>) -> Self {
        Self {
            slows: options.lag,
            holds: options.most_lag,
            worst: [Lag::default(); MAX_REMEMBERED],
            failed: None,
            any: false,
            stuck: 0,
            elsewhere: 0,
        }
    }

    /// Forgets all hinges.
    #[inline(never)]
    pub(super) fn clear(&mut self) {
        let none = Lag::default();
        (self.worst, self.failed, self.any) = ([none; MAX_REMEMBERED], None, false);
        (self.stuck, self.elsewhere) = (0, 0);
    }

    /// Returns the farthest hinge. One whose sensor tells no angle is at the largest distance.
    #[inline]
    pub(super) fn farthest(&self) -> Lag<T> {
        match self.failed {
            _ if !self.any => Lag::default(),
            Some(hinge) => Lag {
                hinge,
                distance: T::MAX,
            },
            None => self.farthest_measured(),
        }
    }

    /// Returns the farthest of the hinges that are measured.
    #[inline(never)]
    pub(super) fn farthest_measured(&self) -> Lag<T> {
        let farther = |a: Lag<T>, b: &Lag<T>| if b.distance > a.distance { *b } else { a };
        self.worst.iter().fold(Lag::default(), farther)
    }

    /// Returns the largest distance of a hinge from its command (radians) that need not be [noted](Self::note): below 0 while
    /// a hinge is remembered.
    #[inline]
    pub(super) fn unremarkable(&self) -> T {
        if self.any { -T::one() } else { self.slows }
    }

    /// Notes the distance of a hinge from its command, radians; returns what [`unremarkable`](Self::unremarkable) does then.
    /// The hinge lags if the distance is more than `slows`. If the distance is no number, or [`Scalar::MAX`], the hinge's
    /// sensor has failed. The hinge is remembered in its own place, or else in that of the nearest hinge, if it is farther. A
    /// hinge that does not lag is forgotten.
    #[inline(never)]
    pub(super) fn note(&mut self, hinge: u32, distance: T) -> T {
        let is_measured = distance < T::MAX;
        if !is_measured {
            self.failed = self.failed.or(Some(hinge));
        } else if self.failed == Some(hinge) {
            self.failed = None;
        }
        let distance = if is_measured && distance > self.slows {
            distance
        } else {
            T::zero()
        };
        let mine = |place: &&mut Lag<T>| place.hinge == hinge && place.distance > T::zero();
        if let Some(place) = self.worst.iter_mut().find(mine) {
            place.distance = distance;
        } else {
            let nearer = |a: &Lag<T>, b: &Lag<T>| a.distance.partial_cmp(&b.distance);
            let nearest = self
                .worst
                .iter_mut()
                .min_by(|a, b| nearer(a, b).unwrap_or(core::cmp::Ordering::Equal));
            if let Some(place) = nearest.filter(|place| distance > place.distance) {
                *place = Lag { hinge, distance };
            }
        }
        self.any = self.failed.is_some() || self.farthest_measured().distance > T::zero();
        if !self.any {
            self.elsewhere = 0;
        }
        self.unremarkable()
    }

    /// Lets `passed` microseconds pass, in which a hinge was stuck or not; returns the time for which it was stuck, less
    /// the time for which it was not.
    pub(super) fn pass(&mut self, stuck: bool, passed: u32) -> u32 {
        self.stuck = if stuck {
            self.stuck.saturating_add(passed)
        } else {
            self.stuck.saturating_sub(passed)
        };
        self.stuck
    }

    /// Lets `passed` microseconds pass, in which a hinge was `elsewhere` or none; returns `true` once one has been for long.
    #[inline]
    pub(super) fn stays(&mut self, elsewhere: bool, passed: u32) -> bool {
        self.elsewhere = if elsewhere {
            self.elsewhere.saturating_add(passed)
        } else {
            0
        };
        self.elsewhere >= ELSEWHERE_US
    }

    /// Forgets for how long a hinge was stuck.
    pub(super) fn restart(&mut self) {
        self.stuck = 0;
    }
}
