//! Bounds the motion of the cells and faces of a folded tessellation relative to each other.

use foldpath_core::{HalfAngle, Rotation};
use nalgebra::Vector3;

use super::deviation::AngleVariation;
use super::motion::{CellConfiguration, LatticeMotion};
use super::screw::Screw;

/// Sums over the intervals of a motion that bound how far any face moves as seen from any other, at all times,
/// whether or not the sheet closes between the configurations given.
///
/// Reason: let x be a point beyond hinges 1 … n, whose angles change by δₖ, uniformly up to a `nonlinearity` of bₖ, and
/// vary by vₖ ≥ |δₖ| in total. By the bound in `deviation.rs`, x stays near the quadratic through its values at the
/// beginning, half way and at the end. Along the quadratic, x moves in an interval by no more than the chord plus twice
/// the second difference of the three values. So the motion of x is the sum of two bounds: on the motion along the
/// quadratic (`curve`), and on the deviation from it (`error`). Without levers, the same bounds hold for the rotation.
///
/// With a step S before and A after the interval, Aⁿ x - Sⁿ x is the sum over m of Aⁿ⁻ᵐ (A S⁻¹ z - z) with z =
/// Sᵐ x. Each term is bounded by the motion of one point, the next cell's centre, plus the rotation times the
/// distance of z from this centre. This distance of z is no more than the distance of x from the centre plus
/// the distance that m steps lead. The latter has two bounds: m times the distance that the first step leads,
/// and twice the distance from the axis of S plus m times its pitch. From a time within an interval on, only
/// the first bound holds, increased by the motion of the next cell's centre.
#[derive(Clone, Debug)]
pub struct LatticeMotionBounds {
    /// Largest counts of steps for which bounds are requested.
    most: [f64; 2],
    orbits: usize,
    /// For each time the sum of each term over the intervals before.
    sums: Vec<Sums<Terms>>,
    /// For each time and orbit the sum of the motion of its faces in the frame of their cell.
    own: Vec<Sums<f64>>,
    folded: Vec<CellConfiguration>,
    /// Corners of the cell at the last time.
    places: Vec<Vector3<f64>>,
}

/// Bounds on the motion of a cell some steps on: the sum of `own`, the `shifts` times the counts of steps, and
/// `turned`, which holds for all counts that may be requested.
#[derive(Clone, Copy, Debug)]
pub(super) struct Drift {
    pub(super) own: f64,
    pub(super) shifts: [f64; 2],
    pub(super) turned: f64,
}

/// Bounds on the motion along the quadratic over an interval (`curve`), and on the deviation from it (`error`).
#[derive(Clone, Copy, Debug, Default)]
struct Parts<T> {
    curve: T,
    error: T,
}

/// Bounds on the motion from the beginning until a time (`all`), and from any time of the last interval on (`last`).
#[derive(Clone, Copy, Debug, Default)]
struct Sums<T> {
    all: T,
    last: Parts<T>,
}

/// A part of a motion: a fraction of the interval before the first time, and all intervals from there up to the second.
#[derive(Clone, Copy, Debug)]
pub struct Stretch {
    /// Fraction of the interval before the first time, from 0 to 1.
    pub head: f64,
    /// The first time.
    pub from: usize,
    /// The second time.
    pub to: usize,
}

impl From<[usize; 2]> for Stretch {
    fn from([from, to]: [usize; 2]) -> Self {
        Self {
            head: 0.0,
            from,
            to,
        }
    }
}

/// Coefficients of the counts i and j of the first and the second step, and of the sums of all counts up to i and j.
#[derive(Clone, Copy, Debug, Default)]
struct Terms {
    own: f64,
    /// For each step the motion of a point of the next cell.
    shifts: [f64; 2],
    /// The rotation of each step times its own reach, and that of the first step times the reach of the second.
    reaches: [Reach; 3],
}

/// A rotation times the distance that steps lead from cell to cell. This distance has two bounds: the `length`
/// of each step, or the `width` across the axis once and the `pitch` along it for each step.
#[derive(Clone, Copy, Debug, Default)]
struct Reach {
    length: f64,
    width: f64,
    pitch: f64,
}

impl Reach {
    fn new(step: &Screw, center: Vector3<f64>, most: f64) -> Self {
        let way = step.motion().carry(&center) - center;
        let length = way.norm();
        Self {
            length,
            // If the step does not rotate, the width is infinite, and the length is as good a bound.
            width: step.width(way).min(most * length),
            pitch: step.pitch(),
        }
    }

    fn times(self, turn: f64) -> Self {
        Self::default().plus(self, turn)
    }

    /// Returns the bound added up over `ways` ways from cell to cell, with `steps` steps in total.
    fn sum(&self, steps: f64, ways: f64) -> f64 {
        let straight = steps * self.length;
        let round = ways * self.width + steps * self.pitch;
        straight.min(round)
    }
}

/// Bounds that can be added and scaled.
trait Linear: Copy {
    /// Returns the sum with `other`, taken `times` times.
    fn plus(self, other: Self, times: f64) -> Self;

    /// Returns the bound from any time of its interval on, instead of from its beginning.
    fn within(self) -> Self {
        self
    }
}

impl Linear for f64 {
    fn plus(self, other: Self, times: f64) -> Self {
        self + other * times
    }
}

impl Linear for Reach {
    fn plus(self, other: Self, times: f64) -> Self {
        Self {
            length: self.length.plus(other.length, times),
            width: self.width.plus(other.width, times),
            pitch: self.pitch.plus(other.pitch, times),
        }
    }

    /// Within the interval the axis may have moved anywhere: only the length is a bound.
    fn within(self) -> Self {
        Self {
            width: 0.0,
            pitch: self.length,
            ..self
        }
    }
}

impl Linear for Terms {
    fn plus(self, other: Self, times: f64) -> Self {
        Self {
            own: self.own.plus(other.own, times),
            shifts: [0, 1].map(|k| self.shifts[k].plus(other.shifts[k], times)),
            reaches: [0, 1, 2].map(|k| self.reaches[k].plus(other.reaches[k], times)),
        }
    }

    fn within(self) -> Self {
        Self {
            reaches: self.reaches.map(Reach::within),
            ..self
        }
    }
}

impl<T: Linear> Sums<T> {
    /// Returns the sums with another interval added.
    fn and(&self, parts: Parts<T>) -> Self {
        Self {
            all: self.all.plus(parts.curve, 1.0).plus(parts.error, 1.0),
            last: Parts {
                curve: parts.curve.within(),
                error: parts.error.within(),
            },
        }
    }

    /// Returns the sum over a stretch between two times.
    ///
    /// In a part of an interval, the deviation counts twice: at its beginning and at its end.
    fn until(&self, to: &Self, head: f64) -> T {
        let whole = to.all.plus(self.all, -1.0);
        if head > 0.0 {
            whole.plus(self.last.curve, head).plus(self.last.error, 2.0)
        } else {
            whole
        }
    }
}

impl LatticeMotionBounds {
    /// Creates the bounds of a motion that begins at the configuration of `start`, for cells at most `most` steps
    /// apart.
    #[must_use]
    pub fn new(start: &LatticeMotion, most: [u32; 2]) -> Self {
        let orbits = start.folded().poses.len();
        Self {
            most: most.map(f64::from),
            orbits,
            sums: vec![Sums::default()],
            own: vec![Sums::default(); orbits],
            folded: vec![start.folded().clone()],
            places: start.places().to_vec(),
        }
    }

    /// Returns the number of times.
    #[must_use]
    pub fn times(&self) -> usize {
        self.sums.len()
    }

    /// Returns the configuration at a time.
    pub(super) fn at(&self, time: usize) -> &CellConfiguration {
        &self.folded[time]
    }

    /// Adds an interval, given the configurations half way and at its end, the change of each group angle over
    /// it, and for each step a `known` bound on its rotation (chord on the unit sphere; infinite if there is
    /// none). `motion` is folded to the end of the interval. Cost: O(orbits).
    pub fn push(
        &mut self,
        motion: &mut LatticeMotion,
        [half_way, to]: [&[HalfAngle<f64>]; 2],
        variations: &[AngleVariation],
        known: [f64; 2],
    ) {
        motion.fold(half_way);
        let middle = (
            motion.steps().map(|step| step.motion()),
            motion.places().to_vec(),
        );
        motion.fold(to);
        let (before, after) = (&self.folded[self.folded.len() - 1], motion.folded());
        let center = motion.center();
        let last = self.own.len() - self.orbits;
        let three = self.places.iter().zip(&middle.1).zip(motion.places());
        let mut three = three.map(|((from, half), to)| (from, path([*from, *half, *to])));
        let (mut most, mut radius) = (Parts::<f64>::default(), 0.0_f64);
        for (orbit, error) in (0..).zip(motion.deviations(variations)) {
            let mut curve = 0.0_f64;
            for (from, moved) in three.by_ref().take(motion.places_of(orbit)) {
                curve = curve.max(moved);
                radius = radius.max((from - center).norm_squared());
            }
            most.curve = most.curve.max(curve);
            most.error = most.error.max(error);
            let sum = self.own[last + orbit as usize].and(Parts { curve, error });
            self.own.push(sum);
        }
        // Radius of the cell at any time of the interval; the length of the steps below holds at any time, too.
        let radius = radius.sqrt() + most.curve + most.error;
        let mut steps = [(Parts::default(), Parts::default(), Reach::default()); 2];
        for (k, (shift, turn, reach)) in steps.iter_mut().enumerate() {
            let three = [
                before.steps[k].motion(),
                middle.0[k],
                after.steps[k].motion(),
            ];
            let [off, turn_off] = motion.step_deviations(k, variations);
            let curve = turn_of(three.map(|step| step.r_wf));
            // A known bound on a rotation holds from any time to any other.
            let (curve, error) = if curve + turn_off <= known[k] {
                (curve, turn_off)
            } else {
                (0.0, known[k])
            };
            *turn = Parts { curve, error };
            let moved = path(three.map(|step| step.carry(&center)));
            *shift = Parts {
                curve: moved + curve * radius,
                error: off + error * radius,
            };
            *reach = Reach::new(&before.steps[k], center, self.most[k]);
            reach.length += moved + off;
        }
        let terms = |part: fn(&Parts<f64>) -> f64| {
            let steps = steps
                .each_ref()
                .map(|(shift, turn, reach)| (part(shift), part(turn), *reach));
            Terms::new(part(&most), steps)
        };
        let sum = self.sums[self.sums.len() - 1].and(Parts {
            curve: terms(|parts| parts.curve),
            error: terms(|parts| parts.error),
        });
        self.sums.push(sum);
        self.folded.push(motion.folded().clone());
        self.places.copy_from_slice(motion.places());
    }

    /// Returns a bound on the motion of a cell, as a rigid body, as seen from the cell `offset` steps back.
    fn moved(terms: &Terms, offset: [i32; 2]) -> f64 {
        if offset == [0, 0] {
            return 0.0;
        }
        let [i, j] = offset.map(|count| f64::from(count).abs());
        let shifts = i * terms.shifts[0] + j * terms.shifts[1];
        shifts + terms.turned([i, j])
    }

    fn terms(&self, stretch: Stretch) -> Terms {
        self.sums[stretch.from].until(&self.sums[stretch.to], stretch.head)
    }

    /// Returns the bounds on the motion of cells over a stretch: see [`cells`](Self::cells).
    pub(super) fn drift(&self, stretch: impl Into<Stretch>) -> Drift {
        let terms = self.terms(stretch.into());
        Drift {
            own: 2.0 * terms.own,
            shifts: terms.shifts,
            turned: terms.turned(self.most),
        }
    }

    /// Returns a bound on the motion of any face of a cell as seen from any face of the cell `offset` steps
    /// back, from the beginning of a stretch to any time before its end.
    #[must_use]
    pub fn cells(&self, stretch: impl Into<Stretch>, offset: [i32; 2]) -> f64 {
        let terms = self.terms(stretch.into());
        2.0 * terms.own + Self::moved(&terms, offset)
    }

    /// Returns the bound of [`cells`](Self::cells) for a face of the second orbit as seen from a face of the
    /// first orbit, `offset` steps back.
    #[must_use]
    pub fn faces(&self, stretch: impl Into<Stretch>, orbits: [u32; 2], offset: [i32; 2]) -> f64 {
        let stretch = stretch.into();
        let own = |orbit: u32| {
            let [from, to] = [stretch.from, stretch.to]
                .map(|time| &self.own[time * self.orbits + orbit as usize]);
            from.until(to, stretch.head)
        };
        let moved = match offset {
            [0, 0] => 0.0,
            _ => Self::moved(&self.terms(stretch), offset),
        };
        orbits.map(own).iter().sum::<f64>() + moved
    }
}

impl Terms {
    /// Returns the terms of one kind, given those of each step: shift, rotation and reach.
    fn new(own: f64, [first, second]: [(f64, f64, Reach); 2]) -> Self {
        Self {
            own,
            shifts: [first.0, second.0],
            reaches: [
                first.2.times(first.1),
                second.2.times(second.1),
                second.2.times(first.1),
            ],
        }
    }

    /// Returns a bound on the motion of a cell some steps on that comes from rotations of the steps.
    fn turned(&self, [i, j]: [f64; 2]) -> f64 {
        let [first, second, across] = &self.reaches;
        let own = |reach: &Reach, n: f64| reach.sum(n * (n + 1.0) / 2.0, n);
        own(first, i) + own(second, j) + i * across.sum(j, 1.0)
    }
}

/// Returns a bound on the motion of a point over an interval, along the quadratic through three places.
fn path([from, half, to]: [Vector3<f64>; 3]) -> f64 {
    let second = from - half * 2.0 + to;
    (to - from).norm() + 2.0 * second.norm()
}

/// Returns the bound of `path` for a point at distance 1 from the centre of a rotation.
///
/// As seen from half way, a rotation is 1 + 2w[v]ₓ + 2[v]ₓ².
fn turn_of([from, half, to]: [Rotation<f64>; 3]) -> f64 {
    let whole = to * from.inverse();
    let [a, b] = [from, to].map(|end| end * half.inverse());
    let second = (a.v * a.w + b.v * b.w).norm() + a.v.norm_squared() + b.v.norm_squared();
    2.0 * whole.v.norm() + 4.0 * second
}
