//! Knots and paths of the whole sheet: configurations with times and rates.

use std::sync::Arc;

use foldpath_core::{Curve, Interpolation, Membership, Node};
use nalgebra::Vector3;

use super::PlanOptions;
use crate::motion::{self, Claims, GroupNaming, Motion, PlanAnswer};
use crate::pattern::CreasePattern;

/// One stored configuration of a path, with the errors measured there on the whole sheet.
#[derive(Clone, Debug, Default, PartialEq)]
pub(super) struct Knot {
    /// Seconds since the start.
    pub(super) time: f64,
    /// Fold angle of each group, radians.
    pub(super) angles: Vec<f64>,
    /// Rate of each group, radians per second.
    pub(super) rates: Vec<f64>,
    /// Weight of each group's homogeneous half angle and its rate per second; empty unless the
    /// interpolation is homogeneous.
    pub(super) weights: Vec<[f64; 2]>,
    /// Folded positions of the vertices; empty if they were not kept.
    pub(super) vertices: Vec<Vector3<f64>>,
    /// Largest closure residual of a real vertex or a hole, or twist of a hinge if that is larger. This error and the
    /// next two are NaN if they were not measured.
    pub(super) closure: f64,
    /// Largest relative change of length of an edge or virtual edge.
    pub(super) deformation: f64,
    /// Largest gap, over the median edge.
    pub(super) gap: f64,
    /// `true` if one phase of the motion ends here and another begins.
    pub(super) ends_phase: bool,
}

/// A path of the whole sheet from flat to goal.
#[derive(Clone, Debug, Default, PartialEq)]
pub(super) struct Path {
    /// For each crease its group and sign.
    pub(super) memberships: Vec<Membership>,
    /// Interpolation between knots.
    pub(super) interpolation: Interpolation,
    /// The knots, in the order of time.
    pub(super) knots: Vec<Knot>,
}

impl Path {
    /// Returns the path as a motion of the sheet; `None` if it has no knots.
    pub(super) fn into_motion(
        self,
        pattern: Arc<CreasePattern>,
        options: &PlanOptions,
        answer: PlanAnswer,
    ) -> Option<Motion> {
        if self.knots.is_empty() {
            return None;
        }
        let inner = 1..self.knots.len() - 1;
        let phases = inner.filter(|&knot| self.knots[knot].ends_phase).collect();
        let edges = pattern.edges().iter();
        let members = edges.map(|edge| Some(self.memberships[edge.crease?.index()]));
        Some(Motion {
            title: String::new(),
            members: members.collect(),
            pattern,
            naming: GroupNaming::Named,
            interpolation: self.interpolation,
            max_speed: Some(options.max_speed),
            // A hinge that turns evenly from knot to knot changes its speed at once.
            max_acceleration: match self.interpolation {
                Interpolation::Linear => Some(f64::INFINITY),
                _ => Some(options.max_acceleration.unwrap_or(f64::INFINITY)),
            },
            seed: Some(options.seed),
            answer: Some(answer),
            knots: self.knots.into_iter().map(Knot::into_stored).collect(),
            phases,
        })
    }

    /// Returns, for each segment between two knots, the curve of each group.
    pub(super) fn curves(&self) -> Vec<Vec<Curve<f64>>> {
        curves(self.interpolation, &self.knots).collect()
    }
}

/// Returns, for each segment between two knots, the curve of each group.
pub(super) fn curves(
    interpolation: Interpolation,
    knots: &[Knot],
) -> impl Iterator<Item = Vec<Curve<f64>>> {
    knots.windows(2).map(move |pair| {
        let span = pair[1].time - pair[0].time;
        let groups = 0..pair[0].angles.len();
        let curve = |group| {
            let [from, to] = [0, 1].map(|end| pair[end].node(group));
            Curve::between(interpolation, span, from, to)
        };
        groups.map(curve).collect()
    })
}

/// Returns an error of the sheet; `None` if it was not measured.
fn measured(error: f64) -> Option<f64> {
    (!error.is_nan()).then_some(error)
}

impl Knot {
    fn into_stored(self) -> motion::Knot {
        motion::Knot {
            time: self.time,
            angles: self.angles,
            rates: self.rates,
            weights: self.weights,
            vertices: self.vertices,
            claims: Claims {
                deformation: measured(self.deformation),
                gap: measured(self.gap),
                closure: measured(self.closure),
                clearance: None,
            },
        }
    }

    fn node(&self, group: usize) -> Node<f64> {
        Node {
            angle: self.angles[group],
            rate: self.rates[group],
            weight: self.weights.get(group).copied().unwrap_or([1.0, 0.0]),
        }
    }
}
