//! Knots on the way from a reduced path to a motion of the whole sheet: configurations with times and rates.

use std::sync::Arc;

use foldpath_core::{Curve, GroupId, Interpolation, Membership};

use super::PlanOptions;
use crate::certificate::Closure;
use crate::collision::Place;
use crate::folding::Rigidity;
use crate::motion::{Claims, Knot, Motion};
use crate::pattern::CreasePattern;

/// Knots, the interpolation between them, and bounds on the motion.
#[derive(Clone, Debug, Default)]
pub(super) struct KnotSequence {
    pub(super) interpolation: Interpolation,
    /// The knots, in the order of time. Their claims are the errors measured there, `None` until they are measured.
    pub(super) knots: Vec<Knot>,
    /// Numbers of the knots at which a phase of the motion ends. A motion that ends before its goal may end at one.
    pub(super) phases: Vec<usize>,
    /// Bounds on the closure over the whole motion.
    pub(super) closure: Closure,
    /// First segment that does not keep the closure condition, if any.
    pub(super) open: Option<Open>,
}

/// The first segment of a motion that does not keep the closure condition.
#[derive(Clone, Debug)]
pub(super) struct Open {
    pub(super) segment: usize,
    /// Path length to the start of the segment.
    pub(super) arc_length: f64,
    /// Bounds on the closure before the segment.
    pub(super) before: Closure,
}

impl KnotSequence {
    /// Returns the group angles at the last knot, radians; empty if there are no knots.
    pub(super) fn end(&self) -> &[f64] {
        self.knots.last().map_or(&[], |last| &last.angles)
    }

    /// Returns `true` if another sequence moves the sheet in the same way.
    pub(super) fn moves_as(&self, other: &Self) -> bool {
        let [this, other] = [self, other].map(|one| (one.interpolation, &one.knots, &one.phases));
        this == other
    }

    /// Keeps only the first `knots` knots.
    pub(super) fn truncate(&mut self, knots: usize) {
        self.knots.truncate(knots);
        self.phases.retain(|&knot| knot < knots);
    }

    /// Keeps only the motion before a place, with a knot there, at which nothing is measured yet. Returns that knot;
    /// `None` if a knot is there already.
    pub(super) fn end_at(&mut self, place: Place) -> Option<&mut Knot> {
        let end = self.knot_at(place);
        self.truncate(place.segment + 1);
        self.knots.push(end?);
        self.knots.last_mut()
    }

    /// Returns the configuration at a place between two knots as a knot.
    fn knot_at(&self, Place { segment, s }: Place) -> Option<Knot> {
        let (from, to) = (
            self.knots.get(segment)?.time,
            self.knots.get(segment + 1)?.time,
        );
        let span = to - from;
        let time = from + s * span;
        if time <= from {
            return None;
        }
        let nodes: Vec<_> = (self.curves().nth(segment)?.iter())
            .map(|curve| curve.node(s, span))
            .collect();
        Some(Knot {
            time,
            angles: nodes.iter().map(|node| node.angle).collect(),
            rates: nodes.iter().map(|node| node.rate).collect(),
            weights: if self.interpolation == Interpolation::Homogeneous {
                nodes.iter().map(|node| node.weight).collect()
            } else {
                Vec::new()
            },
            ..Knot::default()
        })
    }

    /// Keeps only the segments before the first that breaks the closure condition. Returns `true` if there is one.
    pub(super) fn cut(&mut self) -> bool {
        let Some(open) = self.open.take() else {
            return false;
        };
        self.truncate(open.segment + 1);
        self.closure = open.before;
        true
    }

    /// Returns, for each segment between two knots, the curve of each group.
    pub(super) fn curves(&self) -> impl Iterator<Item = Vec<Curve<f64>>> {
        self.knots.windows(2).map(|pair| {
            let [from, to] = [&pair[0], &pair[1]];
            let groups = (0..).map(GroupId).take(from.angles.len());
            let curve = |group| {
                let (span, from, to) = (to.time - from.time, from.node(group), to.node(group));
                Curve::between(self.interpolation, span, from, to)
            };
            groups.map(curve).collect()
        })
    }

    /// Returns the motion of a sheet whose creases are in these groups; `None` if there are no knots. Its title is empty,
    /// and its phases may end with the last knot.
    pub(super) fn into_motion(
        self,
        pattern: Arc<CreasePattern>,
        memberships: &[Membership],
        options: &PlanOptions,
    ) -> Option<Motion> {
        if self.knots.is_empty() {
            return None;
        }
        let edges = pattern.edges().iter();
        let members = edges.map(|edge| Some(memberships[edge.crease?.index()]));
        Some(Motion {
            members: members.collect(),
            interpolation: self.interpolation,
            max_speed: Some(options.max_speed),
            // A hinge that turns evenly from knot to knot changes its speed at once.
            max_acceleration: match self.interpolation {
                Interpolation::Linear => Some(f64::INFINITY),
                _ => Some(options.max_acceleration.unwrap_or(f64::INFINITY)),
            },
            knots: self.knots,
            phases: self.phases,
            ..Motion::flat("", pattern)
        })
    }
}

/// Returns errors measured at a knot as its claims; the twist is the closure residual, if that is larger.
pub(super) fn claims(errors: Rigidity) -> Claims {
    let measured = |error: f64| (!error.is_nan()).then_some(error);
    Claims {
        deformation: measured(errors.deformation),
        gap: measured(errors.gap),
        closure: measured(errors.twist),
        clearance: None,
    }
}

/// Returns the errors measured at a knot, NaN if they were not; the twist is the closure residual, if that is larger.
pub(super) fn errors(knot: &Knot) -> Rigidity {
    let claims = &knot.claims;
    Rigidity {
        deformation: claims.deformation.unwrap_or(f64::NAN),
        gap: claims.gap.unwrap_or(f64::NAN),
        twist: claims.closure.unwrap_or(f64::NAN),
    }
}
