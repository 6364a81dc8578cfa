//! Measures how near to its limits on speed and acceleration a trajectory runs between its knots.

use foldpath_core::Curve;
use foldpath_core::bernstein::differences;
use foldpath_core::trajectory::{Knot, TrajectoryView};

/// Largest fractions of their limits that a trajectory uses: above 1, a limit is exceeded.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Overshoot {
    /// Largest |ρ̇| over its limit.
    pub speed: f64,
    /// Largest |ρ̈| over its limit.
    pub acceleration: f64,
}

impl Overshoot {
    /// Measures a trajectory against the limits of its groups on speed (radians per second) and acceleration (radians
    /// per second squared; infinite for none).
    ///
    /// Exact for cubics of the angle. For half angles, the largest of 17 samples a segment is taken, moved to the top
    /// of the parabolas through that sample and its neighbours. Rates that jump, as at the knots of a linear
    /// interpolation, do not count as acceleration. A trajectory of one knot uses nothing.
    ///
    /// Cost: for each segment and group a few operations, or 27 evaluations of a curve.
    #[must_use]
    pub fn of(view: TrajectoryView<'_, f64>, speeds: &[f64], accelerations: &[f64]) -> Self {
        let mut worst = Self::default();
        let knots = (0..view.len()).filter_map(|knot| view.knot(knot));
        for (segment, Knot { span, .. }) in knots.skip(1).enumerate() {
            for (group, (speed, acceleration)) in speeds.iter().zip(accelerations).enumerate() {
                let Some(curve) = view.curve(segment, group) else {
                    break;
                };
                let [rate, second] = peaks(&curve);
                worst.speed = worst.speed.max(rate / span / speed);
                let second = second / (span * span) / acceleration;
                worst.acceleration = worst.acceleration.max(second);
            }
        }
        worst
    }

    /// Returns the largest speed of each group of a trajectory, radians per second; as exact as [`of`](Self::of).
    #[must_use]
    pub fn speeds(view: TrajectoryView<'_, f64>) -> Vec<f64> {
        let mut speeds = vec![0.0_f64; view.groups()];
        let knots = (0..view.len()).filter_map(|knot| view.knot(knot));
        for (segment, Knot { span, .. }) in knots.skip(1).enumerate() {
            for (group, speed) in speeds.iter_mut().enumerate() {
                let curve = view.curve(segment, group);
                let rate = curve.map_or(0.0, |curve| peaks(&curve)[0]);
                *speed = speed.max(rate / span);
            }
        }
        speeds
    }

    /// Returns the factor by which time has to be stretched to just keep the limits; below 1 it may shrink.
    #[must_use]
    pub fn stretch(&self) -> f64 {
        self.speed.max(self.acceleration.sqrt())
    }
}

/// Returns the largest absolute first and second derivative on a segment, by its parameter from 0 to 1.
pub(crate) fn peaks(curve: &Curve<f64>) -> [f64; 2] {
    let at = |s: f64| curve.derivatives(s).map(f64::abs);
    match curve {
        Curve::Angle(angle) => {
            let ([first, bend], [last, end_bend]) = (at(0.0), at(1.0));
            // A third of the rate is the quadratic of Bernstein coefficients p, q, r.
            let [p, q, r] = differences(angle);
            let top = (p - q) / (p - 2.0 * q + r);
            let inside = if top > 0.0 && top < 1.0 {
                at(top)[0]
            } else {
                0.0
            };
            [first.max(last).max(inside), bend.max(end_bend)]
        }
        Curve::HalfAngle { .. } => {
            let samples = core::array::from_fn(|k| at(place(k)));
            [0, 1].map(|which| highest(samples.map(|sample| sample[which]), |s| at(s)[which]))
        }
    }
}

/// Number of intervals between the samples of a curve.
const INTERVALS: u32 = 16;
/// Number of parabolas drawn through a peak: three leave an error of 1e-7 in a second derivative, five leave 1e-12.
const PARABOLAS: u32 = 5;

#[allow(clippy::cast_precision_loss, reason = "at most 16")]
fn place(k: usize) -> f64 {
    k as f64 / f64::from(INTERVALS)
}

/// Returns the largest value of a function over 0..1, from its samples, by successive parabolic interpolation.
fn highest(samples: [f64; INTERVALS as usize + 1], f: impl Fn(f64) -> f64) -> f64 {
    let top = (0..samples.len())
        .max_by(|&a, &b| samples[a].total_cmp(&samples[b]))
        .unwrap_or(0);
    // A peak between the first two or the last two samples is sought beside the neighbour of the outermost sample.
    let middle = top.clamp(1, samples.len() - 2);
    let mut points = [middle - 1, middle, middle + 1].map(|k| (place(k), samples[k]));
    let mut highest = samples[top];
    for _ in 0..PARABOLAS {
        let Some(s) = vertex(points).filter(|s| (0.0..=1.0).contains(s)) else {
            break;
        };
        let value = f(s);
        highest = highest.max(value);
        let lowest = if points[0].1 <= points[2].1 { 0 } else { 2 };
        points[lowest] = (s, value);
        points.sort_by(|a, b| a.0.total_cmp(&b.0));
    }
    highest
}

/// Returns the place at which the parabola through three points is highest; `None` if it has no maximum.
fn vertex([(a, fa), (b, fb), (c, fc)]: [(f64, f64); 3]) -> Option<f64> {
    let (left, right) = ((fb - fa) / (b - a), (fc - fb) / (c - b));
    let bend = (right - left) / (c - a);
    (bend < 0.0).then(|| (a + b) / 2.0 - left / (2.0 * bend))
}
