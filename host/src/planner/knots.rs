//! Knots and paths of the whole sheet: configurations with times and rates.

use std::sync::Arc;

use foldpath_core::{Curve, GroupId, Interpolation, Membership};

use super::PlanOptions;
use crate::folding::Rigidity;
use crate::motion::{self, Claims, GroupNaming, Motion, PlanAnswer};
use crate::pattern::CreasePattern;

/// One configuration of a path, with the errors measured there on the whole sheet.
#[derive(Clone, Debug, Default, PartialEq)]
pub(super) struct Knot {
    /// The configuration as it is stored. Its claims are the errors, `None` if they were not measured.
    pub(super) stored: motion::Knot,
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
            knots: self.knots.into_iter().map(|knot| knot.stored).collect(),
            phases,
        })
    }

    /// Returns the fold angle of each crease at one of the knots, radians.
    pub(super) fn crease_angles(&self, knot: &Knot) -> Vec<f64> {
        let angles = &knot.stored.angles;
        let angle = |member: &Membership| member.apply(angles[member.group.index()]);
        self.memberships.iter().map(angle).collect()
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
        let [from, to] = [0, 1].map(|end: usize| &pair[end].stored);
        let groups = (0..).map(GroupId).take(from.angles.len());
        let curve = |group| {
            let (span, from, to) = (to.time - from.time, from.node(group), to.node(group));
            Curve::between(interpolation, span, from, to)
        };
        groups.map(curve).collect()
    })
}

impl Knot {
    /// Returns the knot at these group angles, radians.
    pub(super) fn at(angles: Vec<f64>) -> Self {
        let stored = motion::Knot {
            angles,
            ..motion::Knot::default()
        };
        Self {
            stored,
            ends_phase: false,
        }
    }

    /// Stores the errors measured here; the twist is the closure residual, if that is larger.
    pub(super) fn set_errors(&mut self, errors: Rigidity) {
        let measured = |error: f64| (!error.is_nan()).then_some(error);
        self.stored.claims = Claims {
            deformation: measured(errors.deformation),
            gap: measured(errors.gap),
            closure: measured(errors.twist),
            clearance: None,
        };
    }

    /// Returns the errors measured here, NaN if they were not; the twist is the closure residual, if that is larger.
    pub(super) fn errors(&self) -> Rigidity {
        let claims = &self.stored.claims;
        Rigidity {
            deformation: claims.deformation.unwrap_or(f64::NAN),
            gap: claims.gap.unwrap_or(f64::NAN),
            twist: claims.closure.unwrap_or(f64::NAN),
        }
    }
}
