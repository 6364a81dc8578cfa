//! Segments of a motion: the curves between two configurations of a path, under a time law.

use core::f64::consts::PI;

use foldpath_core::{Curve, Interpolation, Node};

use super::reduced_path::ReducedPath;
use super::timing::OptimalTimeLaw;
use crate::planner::following::follow::Waypoint;
use crate::planner::vectors::max_norm;

/// Distance from half a turn, radians, below which the digits that an angle is written with leave too few digits of its
/// half angle's tangent to prove again what is proved of the tangent.
const BLUNT_RAD: f64 = 1e-4;
/// Cosine of half an angle below which the angle is half a turn.
const FOLDED_FLAT_COSINE: f64 = 1e-6;

/// Time law along the path.
pub(super) enum TimeLaw {
    /// As fast as speed and acceleration of the hinges allow.
    Optimal(OptimalTimeLaw),
    /// Time is proportional to the angle of this group.
    Angle(usize),
    /// Time is proportional to the tangent of half the angle of this group.
    HalfAngle(usize),
    /// Time is proportional to the path length in group angles.
    ArcLength,
}

impl TimeLaw {
    /// Returns the time at a configuration, and the speed there: path length per time.
    pub(super) fn at(&self, point: &Waypoint) -> [f64; 2] {
        match self {
            Self::Optimal(law) => [
                law.time_at(point.arc_length),
                law.speed_at(point.arc_length),
            ],
            Self::Angle(lead) => [point.angles[*lead].abs(), 1.0 / point.tangent[*lead].abs()],
            Self::HalfAngle(lead) => {
                let tangent = (point.angles[*lead] / 2.0).tan();
                let rate = point.tangent[*lead] * (1.0 + tangent * tangent) / 2.0;
                [tangent.abs(), 1.0 / rate.abs()]
            }
            Self::ArcLength => [point.arc_length, 1.0],
        }
    }
}

/// Makes the curves between configurations.
pub(super) struct SegmentBuilder<'a> {
    pub(super) kind: Interpolation,
    pub(super) law: &'a TimeLaw,
    /// Group whose half angle's cosine all groups share in homogeneous half angles; `None` for tangents of half angles.
    lead: Option<usize>,
}

impl<'a> SegmentBuilder<'a> {
    pub(super) fn new(path: &ReducedPath, kind: Interpolation, law: &'a TimeLaw) -> Self {
        let last = &path.waypoints()[path.waypoints().len() - 1];
        let widest = |group: &usize| last.angles[*group].abs();
        let lead = match law {
            TimeLaw::Angle(lead) => Some(*lead),
            TimeLaw::HalfAngle(_) => None,
            _ => (0..last.angles.len()).max_by(|a, b| widest(a).total_cmp(&widest(b))),
        };
        Self { kind, law, lead }
    }

    /// Makes the curves between two configurations, and returns the time between them. Returns `None` if a
    /// configuration is not on its curve, or time stands still there or runs backwards.
    pub(super) fn curves(
        &self,
        from: &Waypoint,
        to: &Waypoint,
        curves: &mut Vec<Curve<f64>>,
    ) -> Option<f64> {
        let span = self.law.at(to)[0] - self.law.at(from)[0];
        curves.clear();
        let nodes = self.nodes(from).zip(self.nodes(to));
        curves.extend(nodes.map(|(from, to)| Curve::between(self.kind, span, from, to)));
        let passes = span > 0.0
            && [from, to].into_iter().all(|point| {
                let tangents = self.kind == Interpolation::HalfAngle;
                let sharp = !tangents || max_norm(&point.angles) < PI - BLUNT_RAD;
                sharp && self.law.at(point)[1].is_finite()
            });
        passes.then_some(span)
    }

    /// Returns one node for each group.
    pub(super) fn nodes<'n>(&'n self, point: &'n Waypoint) -> impl Iterator<Item = Node<f64>> + 'n {
        let speed = self.law.at(point)[1];
        (0..point.angles.len()).map(move |group| Node {
            angle: point.angles[group],
            rate: point.tangent[group] * speed,
            weight: if self.kind == Interpolation::Homogeneous {
                self.weight(point, group, speed)
            } else {
                [1.0, 0.0]
            },
        })
    }

    /// Returns the weight of a homogeneous half angle and the rate of the weight. The cosines of all groups are the
    /// same function of time, that of the lead, so that groups whose tangents of half angles keep their ratio move
    /// exactly.
    fn weight(&self, point: &Waypoint, group: usize, speed: f64) -> [f64; 2] {
        let (sin, cos) = (point.angles[group] / 2.0).sin_cos();
        let turn = point.tangent[group] * speed / 2.0;
        let (lead_cos, lead_rate) = match self.lead {
            Some(lead) => {
                let (sin, cos) = (point.angles[lead] / 2.0).sin_cos();
                (cos, -sin * point.tangent[lead] * speed / 2.0)
            }
            None => (1.0, 0.0),
        };
        if cos.abs() < FOLDED_FLAT_COSINE || lead_cos.abs() < FOLDED_FLAT_COSINE {
            // Both cosines vanish, and their ratio is that of the rates.
            let ratio = self.lead.map_or(1.0, |lead| {
                (point.tangent[lead] / point.tangent[group]).abs()
            });
            let sound = ratio.is_finite() && ratio > 0.0;
            return [if sound { ratio } else { 1.0 }, 0.0];
        }
        let weight = lead_cos / cos;
        [weight, (lead_rate + weight * turn * sin) / cos]
    }
}
