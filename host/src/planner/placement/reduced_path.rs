//! The path as geometry: closed configurations as a function of path length in group angles, independent of time.

use core::ops::Range;

use foldpath_core::{Curve, Interpolation, Node};

use super::timing::{OptimalTimeLaw, RateLimits};
use crate::planner::closing::solver::ClosureSolver;
use crate::planner::following::follow::Waypoint;
use crate::planner::vectors::{max_difference, norm};

/// Waypoints, each with the Euclidean path length in group angles to it.
pub(crate) struct ReducedPath {
    waypoints: Vec<Waypoint>,
}

/// Largest distance of a closed configuration from its prediction, as a fraction of the distance between waypoints.
const MAX_CORRECTION_RATIO: f64 = 0.1;

/// Distance from the waypoint before, as a fraction of the largest such distance, below which a waypoint is left out.
/// If a motion turns back at a limit or passes a singular configuration, tangents there are not those of a smooth path.
const MIN_SPACING_RATIO: f64 = 1.0 / 1024.0;

impl ReducedPath {
    pub(crate) fn new(waypoints: &[Waypoint]) -> Self {
        let mut waypoints = spread(waypoints);
        let mut arc_length = 0.0;
        for index in 0..waypoints.len() {
            if index > 0 {
                arc_length += arc_between(&waypoints[index - 1], &waypoints[index]);
            }
            waypoints[index].arc_length = arc_length;
        }
        Self { waypoints }
    }

    /// Returns the waypoints.
    pub(crate) fn waypoints(&self) -> &[Waypoint] {
        &self.waypoints
    }

    /// Returns the path length between a waypoint and the next.
    fn span(&self, segment: usize) -> f64 {
        self.waypoints[segment + 1].arc_length - self.waypoints[segment].arc_length
    }

    /// Returns the numbers of the waypoints between the ends.
    pub(crate) fn inner(&self) -> Range<usize> {
        1..self.waypoints.len().saturating_sub(1)
    }

    /// Returns the number of the waypoint between two path lengths that is nearest to their middle.
    pub(crate) fn waypoint_between(&self, from: f64, to: f64) -> Option<usize> {
        let middle = (from + to) / 2.0;
        let first = self.waypoints.partition_point(|w| w.arc_length <= from);
        let end = self.waypoints.partition_point(|w| w.arc_length < to);
        let distance = |index: &usize| (self.waypoints[*index].arc_length - middle).abs();
        (first..end).min_by(|a, b| distance(a).total_cmp(&distance(b)))
    }

    /// Returns, for each group, its cubic Hermite curve from the waypoint of this number to the next, by path length.
    fn curves(&self, segment: usize) -> impl Iterator<Item = Curve<f64>> {
        let [from, to] = [&self.waypoints[segment], &self.waypoints[segment + 1]];
        let span = self.span(segment);
        let node = |waypoint: &Waypoint, group: usize| Node {
            angle: waypoint.angles[group],
            rate: waypoint.tangent[group],
            weight: [1.0, 0.0],
        };
        (0..from.angles.len()).map(move |group| {
            let (from, to) = (node(from, group), node(to, group));
            Curve::between(Interpolation::Hermite, span, from, to)
        })
    }

    /// Returns the fraction of the path before a configuration on the path, 0 to 1, by the nearest point of the
    /// polyline.
    pub(crate) fn fraction(&self, angles: &[f64]) -> f64 {
        let along = |pair: &[Waypoint]| {
            let [from, to] = [&pair[0].angles, &pair[1].angles];
            let (mut dot, mut square) = (0.0, 0.0);
            for ((a, b), x) in from.iter().zip(to).zip(angles) {
                dot += (x - a) * (b - a);
                square += (b - a) * (b - a);
            }
            let s = if square > 0.0 {
                (dot / square).clamp(0.0, 1.0)
            } else {
                0.0
            };
            let mixed = from.iter().zip(to).zip(angles);
            let off = mixed.map(|((a, b), x)| (a + s * (b - a) - x).powi(2));
            (off.sum::<f64>(), s)
        };
        let segments = self.waypoints.windows(2).map(along).enumerate();
        let nearest = segments.min_by(|a, b| a.1.0.total_cmp(&b.1.0));
        match (nearest, self.waypoints.last()) {
            (Some((segment, (_, s))), Some(end)) if end.arc_length > 0.0 => {
                (self.waypoints[segment].arc_length + s * self.span(segment)) / end.arc_length
            }
            _ => 0.0,
        }
    }

    /// Cuts the path at a configuration near its end. Returns the waypoints before that configuration, and the
    /// configuration itself, closed.
    pub(crate) fn cut(
        &self,
        solver: &mut ClosureSolver<'_>,
        mut end: Vec<f64>,
    ) -> Option<Vec<Waypoint>> {
        let last = self.waypoints.last()?;
        if !solver.closes(&mut end) {
            return None;
        }
        let short = max_difference(&end, &last.angles);
        let before = |w: &&Waypoint| max_difference(&w.angles, &last.angles) > short;
        let mut waypoints: Vec<Waypoint> =
            self.waypoints.iter().take_while(before).cloned().collect();
        let mut tangent = last.tangent.clone();
        solver.project_on_motions(&end, &mut tangent)?;
        let length = norm(&tangent);
        if waypoints.is_empty() || length <= 0.0 {
            return None;
        }
        waypoints.push(Waypoint::new(
            end,
            tangent.iter().map(|entry| entry / length).collect(),
        ));
        Some(waypoints)
    }

    /// Computes the fastest motion along the path, sampled on `parts` intervals of each segment, with hinges that
    /// keep these limits (radians per second, and per second squared). Returns `None` if there is none.
    pub(crate) fn fastest(
        &self,
        parts: usize,
        max_speed: f64,
        max_acceleration: f64,
    ) -> Option<OptimalTimeLaw> {
        let (mut arc_lengths, mut first, mut second) = (Vec::new(), Vec::new(), Vec::new());
        for segment in 0..self.waypoints.len().saturating_sub(1) {
            let span = self.span(segment);
            let curves: Vec<Curve<f64>> = self.curves(segment).collect();
            // Both ends of a segment are sampled, as second derivatives jump at waypoints.
            for part in 0..=parts {
                #[allow(clippy::cast_precision_loss, reason = "few parts")]
                let s = part as f64 / parts as f64;
                arc_lengths.push(self.waypoints[segment].arc_length + s * span);
                for curve in &curves {
                    let [once, twice] = curve.derivatives(s);
                    first.push(once / span);
                    second.push(twice / (span * span));
                }
            }
        }
        let groups = self.waypoints.first().map_or(0, |w| w.angles.len());
        let limits = RateLimits {
            speeds: &vec![max_speed; groups],
            accelerations: &vec![max_acceleration; groups],
        };
        OptimalTimeLaw::time_optimal(&arc_lengths, [&first, &second], limits)
    }

    /// Returns the closed configuration at a path length, if it is found near the prediction.
    pub(crate) fn closed(
        &self,
        solver: &mut ClosureSolver<'_>,
        arc_length: f64,
    ) -> Option<Waypoint> {
        let after = self
            .waypoints
            .partition_point(|w| w.arc_length <= arc_length);
        let segment = after
            .checked_sub(1)?
            .min(self.waypoints.len().checked_sub(2)?);
        let span = self.span(segment);
        let s = (arc_length - self.waypoints[segment].arc_length) / span;
        let curves = self.curves(segment);
        let (predicted, mut tangent): (Vec<f64>, Vec<f64>) = curves
            .map(|curve| (curve.angle(s), curve.derivatives(s)[0] / span))
            .unzip();
        let mut angles = predicted.clone();
        let near = solver.closes(&mut angles)
            && max_difference(&angles, &predicted) <= MAX_CORRECTION_RATIO * span;
        if !near {
            return None;
        }
        let size = norm(&tangent);
        solver.project_on_motions(&angles, &mut tangent)?;
        let projected = norm(&tangent);
        (projected >= size / 2.0).then(|| {
            for entry in &mut tangent {
                *entry *= size / projected;
            }
            Waypoint {
                arc_length,
                ..Waypoint::new(angles, tangent)
            }
        })
    }
}

/// Returns the waypoints that are not too near to the one before. The ends, corners and ends of phases always stay.
fn spread(waypoints: &[Waypoint]) -> Vec<Waypoint> {
    let pairs = waypoints.windows(2);
    let widest = pairs.map(|pair| arc_between(&pair[0], &pair[1]));
    let least = MIN_SPACING_RATIO * widest.fold(0.0, f64::max);
    let mut kept: Vec<Waypoint> = Vec::with_capacity(waypoints.len());
    for (index, waypoint) in waypoints.iter().enumerate() {
        let near = |last: &Waypoint| arc_between(last, waypoint) < least;
        if index + 1 == waypoints.len() || waypoint.stays() || !kept.last().is_some_and(near) {
            kept.push(waypoint.clone());
        }
    }
    kept
}

/// Returns the length of the path between two waypoints: that of the circular arc over their chord whose ends enclose
/// the angle of their tangents. The error is of fourth order in the chord.
fn arc_between(from: &Waypoint, to: &Waypoint) -> f64 {
    let squares = |a: &[f64], b: &[f64]| a.iter().zip(b).map(|(a, b)| (a - b).powi(2)).sum::<f64>();
    let chord = squares(&from.angles, &to.angles).sqrt();
    // The tangents have length 1, so that their difference is twice the sine of half the angle. At a corner one of them
    // is zero: this makes 60 degrees and 5 % more length, which a start from rest takes.
    let sine = (squares(&from.tangent, &to.tangent).sqrt() / 2.0).min(1.0);
    if sine > 0.0 {
        chord * sine.asin() / sine
    } else {
        chord
    }
}
