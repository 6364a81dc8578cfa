//! The motion of a sheet from flat to its goal: the one model of a path.
//!
//! A motion is a sheet, groups of creases that turn alike, and *knots*: configurations of the groups at points in time.
//! Between two knots each group follows a [`Curve`] that the [`Interpolation`] determines. The planner makes motions,
//! the FOLD reader reads them, and everything that judges, draws, exports or sends a path takes one.

mod plates;

use std::sync::Arc;

use foldpath_core::{Curve, GroupId, Interpolation, Membership, Node};
use nalgebra::Vector3;

pub use plates::{
    GAP, HINGE_PLANE, MARGIN_DEG, MAX_PLATE_ANGLE_DEG, PlateOptions, PlateSides, THICKNESS,
};

use crate::pattern::{CreasePattern, EdgeId, Unit};

/// A sheet and its motion.
#[derive(Clone, Debug)]
pub struct Motion {
    /// Title for people.
    pub title: String,
    /// The flat sheet.
    pub pattern: Arc<CreasePattern>,
    /// Group and sign of each edge; `None` for an edge that stays flat.
    pub members: Vec<Option<Membership>>,
    /// The origin of the groups.
    pub naming: GroupNaming,
    /// Interpolation between knots.
    pub interpolation: Interpolation,
    /// Speed that no hinge exceeds, radians per second; `None` if none is claimed, infinite if any speed is allowed.
    pub max_speed: Option<f64>,
    /// Acceleration that no hinge exceeds, radians per second squared; `None` if none is claimed, infinite if any
    /// acceleration is allowed.
    pub max_acceleration: Option<f64>,
    /// The seed of random numbers that the motion was planned with, if it is known.
    pub seed: Option<u64>,
    /// The planner's answer when it made the motion, if it is known.
    pub answer: Option<PlanAnswer>,
    /// The knots from start to goal, at increasing times.
    pub knots: Vec<Knot>,
    /// Numbers of the knots at which another phase of the motion begins, in increasing order, without the first and the
    /// last knot.
    pub phases: Vec<usize>,
    /// The plates of which the panels are made; `None` for panels without a thickness.
    pub plates: Option<PlateOptions>,
}

/// Answer of the planner that made a motion.
#[derive(Clone, Debug, PartialEq)]
pub struct PlanAnswer {
    /// Name of the outcome, such as `planned`.
    pub outcome: String,
    /// Fraction of the way to the goal that the motion goes, 0 to 1.
    pub reached: f64,
    /// Bound on deformation and gap that the motion had to keep.
    pub bound: f64,
    /// Largest angle by which a panel bends about a diagonal, radians.
    pub bend: f64,
}

impl PlanAnswer {
    /// Returns `true` if the motion reaches its goal, within the bound and free of crossings.
    #[must_use]
    pub fn is_planned(&self) -> bool {
        self.outcome == PLANNED
    }
}

/// Name of the outcome of a motion that reaches its goal.
pub(crate) const PLANNED: &str = "planned";

/// The origin of the groups of a motion.
#[derive(Clone, Debug, PartialEq)]
pub enum GroupNaming {
    /// The groups are crease groups that the planner found or the file names, and all hinges of each group turn exactly
    /// alike.
    Named,
    /// The file names no groups: each crease has a group of its own.
    Unnamed,
    /// The file names the groups listed here, one entry for each edge, but not all hinges of each group turn exactly
    /// alike: each crease has a group of its own.
    Contradicted(Vec<Option<Membership>>),
}

/// One stored configuration.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Knot {
    /// Seconds since the start.
    pub time: f64,
    /// Fold angle of each group, radians.
    pub angles: Vec<f64>,
    /// Rate of each group, radians per second; empty if unknown.
    pub rates: Vec<f64>,
    /// Weight of the homogeneous half angle of each group and its rate per second; empty unless the interpolation is
    /// homogeneous.
    pub weights: Vec<[f64; 2]>,
    /// Positions of the vertices; empty if they are not stored.
    pub vertices: Vec<Vector3<f64>>,
    /// Errors of the sheet in this configuration, as claimed by whoever made the motion.
    pub claims: Claims,
}

/// Claimed errors of a configuration; `None` for an error of which nothing is claimed.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Claims {
    /// Largest relative change of length of an edge or virtual edge.
    pub deformation: Option<f64>,
    /// Largest gap, over the median edge.
    pub gap: Option<f64>,
    /// Largest closure residual of a real vertex or a hole, or twist of a hinge if that is larger.
    pub closure: Option<f64>,
    /// Smallest distance between faces that share no vertex, units of the sheet.
    pub clearance: Option<f64>,
}

/// Angle, rate and weight of an edge or group that stays flat.
pub(crate) const REST: Node<f64> = Node {
    angle: 0.0,
    rate: 0.0,
    weight: [1.0, 0.0],
};

/// Largest fold angle of a hinge that counts as flat, radians.
const FLAT_RAD: f64 = 1e-9;
/// Largest number of steps into which [`Motion::with_steps`] divides a segment.
const MAX_STEPS: f64 = 1000.0;

impl Knot {
    /// Returns angle, rate and weight of a group. The rate is 0 if rates are unknown, and the weight is 1 if there are
    /// no weights.
    ///
    /// # Panics
    /// If there is no such group.
    #[must_use]
    pub fn node(&self, group: GroupId) -> Node<f64> {
        let group = group.index();
        Node {
            angle: self.angles[group],
            rate: self.rates.get(group).copied().unwrap_or(0.0),
            weight: self.weights.get(group).copied().unwrap_or([1.0, 0.0]),
        }
    }
}

impl Motion {
    /// Returns the flat sheet, of which nothing moves.
    #[must_use]
    pub fn flat(title: &str, pattern: Arc<CreasePattern>) -> Self {
        Self {
            title: title.into(),
            members: vec![None; pattern.edges().len()],
            pattern,
            naming: GroupNaming::Named,
            interpolation: Interpolation::Linear,
            max_speed: None,
            max_acceleration: None,
            seed: None,
            answer: None,
            knots: vec![Knot::default()],
            phases: Vec::new(),
            plates: None,
        }
    }

    /// Number of groups.
    #[must_use]
    pub fn groups(&self) -> usize {
        self.knots.first().map_or(0, |knot| knot.angles.len())
    }

    /// Returns `true` if all hinges are at angle 0 at the first knot.
    #[must_use]
    pub fn begins_flat(&self) -> bool {
        let first = self.knots.first();
        first.is_some_and(|knot| knot.angles.iter().all(|angle| angle.abs() <= FLAT_RAD))
    }

    /// Number of segments between two knots.
    #[must_use]
    pub fn segments(&self) -> usize {
        self.knots.len().saturating_sub(1)
    }

    /// Returns group and sign of each edge as the file or the planner names them; empty if no groups are named.
    #[must_use]
    pub fn named_members(&self) -> &[Option<Membership>] {
        match &self.naming {
            GroupNaming::Named => &self.members,
            GroupNaming::Unnamed => &[],
            GroupNaming::Contradicted(named) => named,
        }
    }

    /// Returns group and sign of each crease.
    ///
    /// # Panics
    /// If a crease has no group; the planner and the reader give each crease one.
    #[must_use]
    pub fn memberships(&self) -> Vec<Membership> {
        let creases = self.pattern.creases().iter();
        let members = creases.map(|edge| self.members[edge.index()]);
        members
            .map(|member| member.expect("a group for each crease"))
            .collect()
    }

    /// Returns for each named group the first edge of the group with its group and sign.
    #[must_use]
    pub fn leaders(&self) -> Vec<Option<(EdgeId, Membership)>> {
        leaders(self.named_members())
    }

    /// Returns the edges whose curves show the motion of the sheet: one edge of each named group with its sign. If no
    /// groups are named, returns every crease.
    #[must_use]
    pub fn curves_shown(&self) -> Vec<(EdgeId, Option<Membership>)> {
        if self.naming == GroupNaming::Unnamed {
            let creases = self.pattern.creases().iter();
            return creases.map(|&edge| (edge, None)).collect();
        }
        let leaders = self.leaders().into_iter().flatten();
        leaders.map(|(edge, member)| (edge, Some(member))).collect()
    }

    /// Returns `true` if the motion between knots depends on rates.
    #[must_use]
    pub fn uses_rates(&self) -> bool {
        self.interpolation != Interpolation::Linear
    }

    /// Returns angle, rate and weight of an edge at a knot.
    ///
    /// # Panics
    /// If there is no such knot or edge.
    #[must_use]
    pub fn node(&self, knot: usize, edge: EdgeId) -> Node<f64> {
        self.members[edge.index()].map_or(REST, |member| {
            let node = self.knots[knot].node(member.group);
            // The sum turns -0 into 0, so that a flat hinge has the same sign in every group.
            Node {
                angle: member.apply(node.angle) + 0.0,
                rate: member.apply(node.rate) + 0.0,
                ..node
            }
        })
    }

    /// Returns angle, rate and weight that a group would have at a knot if it turned as one of its edges.
    pub(crate) fn group_node(&self, knot: usize, edge: EdgeId, member: Membership) -> Node<f64> {
        let node = self.node(knot, edge);
        Node {
            angle: member.apply(node.angle),
            rate: member.apply(node.rate),
            ..node
        }
    }

    /// Returns the fold angle (radians) of each crease at a knot.
    ///
    /// # Panics
    /// If there is no such knot.
    #[must_use]
    pub fn crease_angles(&self, knot: usize) -> Vec<f64> {
        let creases = self.pattern.creases().iter();
        creases.map(|&edge| self.node(knot, edge).angle).collect()
    }

    /// Returns the motion of an edge over the segment between a knot and the next, with parameter 0 at the first knot
    /// and 1 at the second.
    ///
    /// # Panics
    /// If there is no such segment or edge.
    #[must_use]
    pub fn curve(&self, segment: usize, edge: EdgeId) -> Curve<f64> {
        let nodes = [segment, segment + 1].map(|knot| self.node(knot, edge));
        Curve::between(self.interpolation, self.span(segment), nodes[0], nodes[1])
    }

    /// Returns the motion of every group over a segment; see [`curve`](Self::curve).
    ///
    /// # Panics
    /// If there is no such segment.
    pub fn curves(&self, segment: usize) -> impl Iterator<Item = Curve<f64>> {
        let (from, to) = (&self.knots[segment], &self.knots[segment + 1]);
        let (interpolation, span) = (self.interpolation, self.span(segment));
        let groups = (0..).map(GroupId).take(from.angles.len());
        groups
            .map(move |group| Curve::between(interpolation, span, from.node(group), to.node(group)))
    }

    /// Returns the duration of a segment, seconds.
    fn span(&self, segment: usize) -> f64 {
        self.knots[segment + 1].time - self.knots[segment].time
    }

    /// Returns the configuration of a segment at parameter `s`, 0 to 1, without rates and positions.
    fn between(&self, segment: usize, s: f64) -> Knot {
        Knot {
            time: self.knots[segment].time + s * self.span(segment),
            angles: self.curves(segment).map(|curve| curve.angle(s)).collect(),
            ..Knot::default()
        }
    }

    /// Returns the configuration at a time (seconds), without rates and positions; a copy of a knot at the time of that
    /// knot. Before the first knot and after the last the sheet is at rest there.
    ///
    /// # Panics
    /// If the motion has no knots; the planner and the reader give it one at least.
    #[must_use]
    pub fn at(&self, time: f64) -> Knot {
        match self.place_of(time) {
            None => self.knots[0].clone(),
            Some((segment, s)) if s <= 0.0 => self.knots[segment].clone(),
            Some((segment, s)) if s >= 1.0 => self.knots[segment + 1].clone(),
            Some((segment, s)) => self.between(segment, s),
        }
    }

    /// Returns the segment of a time (seconds), at a knot the one after it, and the parameter there, which is below 0 before the
    /// motion and above 1 after it; `None` for a motion of one knot.
    fn place_of(&self, time: f64) -> Option<(usize, f64)> {
        let last = self.segments().checked_sub(1)?;
        let after = self.knots.partition_point(|knot| knot.time <= time);
        let segment = after.saturating_sub(1).min(last);
        let s = (time - self.knots[segment].time) / self.span(segment);
        Some((segment, s))
    }

    /// Returns the rate of each group at a time (seconds), radians per second, by the derivative of its curve. At a knot the
    /// rate is that of the segment after it, and at the last knot that of the segment before. Outside of the motion the sheet
    /// is at rest.
    #[must_use]
    pub fn rates(&self, time: f64) -> Vec<f64> {
        let moving = self.place_of(time);
        let Some((segment, s)) = moving.filter(|(_, s)| (0.0..=1.0).contains(s)) else {
            return vec![0.0; self.groups()];
        };
        let span = self.span(segment);
        let curves = self.curves(segment);
        curves.map(|curve| curve.derivatives(s)[0] / span).collect()
    }

    /// Returns the configurations at these times (seconds, increasing) as knots of a motion.
    #[must_use]
    pub fn at_times(&self, times: impl IntoIterator<Item = f64>) -> Self {
        let at = |time| Knot {
            time,
            ..self.at(time)
        };
        self.with_knots(times.into_iter().map(at).collect())
    }

    /// Returns `count` configurations (at least two) of the motion, evenly spaced in time from the first knot to the
    /// last, as knots of a motion. A configuration that falls on a knot is a copy of that knot. A motion of one knot
    /// stays unchanged.
    #[must_use]
    pub fn resampled(&self, count: usize) -> Self {
        let [first, .., last] = self.knots.as_slice() else {
            return self.clone();
        };
        let count = count.max(2);
        #[allow(clippy::cast_precision_loss, reason = "of what fits in memory")]
        let fraction = |index: usize| index as f64 / (count - 1) as f64;
        let configuration =
            |index: usize| self.at(first.time + fraction(index) * (last.time - first.time));
        self.with_knots((0..count).map(configuration).collect())
    }

    /// Returns this motion with further configurations between its knots, without rates and positions, so that no hinge
    /// turns by much more than `step` (radians) from one configuration to the next.
    #[must_use]
    pub fn with_steps(&self, step: f64) -> Self {
        let mut knots: Vec<Knot> = self.knots.iter().take(1).cloned().collect();
        for (segment, pair) in self.knots.windows(2).enumerate() {
            let turned = |curve: Curve<f64>| {
                let parts = [0.0, 0.25, 0.5, 0.75, 1.0].map(|s| curve.angle(s));
                parts
                    .windows(2)
                    .map(|ends| (ends[1] - ends[0]).abs())
                    .sum::<f64>()
            };
            let most = self.curves(segment).map(turned).fold(0.0, f64::max);
            let parts = (most / step).ceil().clamp(1.0, MAX_STEPS);
            let mut part = 1.0;
            while part < parts {
                knots.push(self.between(segment, part / parts));
                part += 1.0;
            }
            knots.push(pair[1].clone());
        }
        self.with_knots(knots)
    }

    /// Sets the unit of lengths.
    pub fn measured_in(&mut self, unit: Unit) {
        Arc::make_mut(&mut self.pattern).measured_in(Some(unit));
    }

    /// Returns this motion with lengths in another unit; `None` if its own unit is not known.
    #[must_use]
    pub fn in_unit(&self, unit: Unit) -> Option<Self> {
        let factor = self.pattern.unit()?.metres() / unit.metres();
        let mut motion = self.clone();
        motion.pattern = Arc::new(self.pattern.scaled(factor, unit)?);
        motion.plates = self.plates.map(|plates| plates.scaled(factor));
        for knot in &mut motion.knots {
            knot.vertices.iter_mut().for_each(|at| *at *= factor);
        }
        Some(motion)
    }

    /// Returns this motion with other knots and without phases.
    fn with_knots(&self, knots: Vec<Knot>) -> Self {
        Self {
            title: self.title.clone(),
            pattern: Arc::clone(&self.pattern),
            members: self.members.clone(),
            naming: self.naming.clone(),
            answer: self.answer.clone(),
            knots,
            phases: Vec::new(),
            ..*self
        }
    }
}

/// Returns for each group the first edge of the group with its group and sign.
pub(crate) fn leaders(members: &[Option<Membership>]) -> Vec<Option<(EdgeId, Membership)>> {
    let indices = members.iter().flatten().map(|m| m.group.index());
    let mut leaders = vec![None; indices.max().map_or(0, |last| last + 1)];
    for (edge, member) in members.iter().enumerate() {
        if let Some(member) = *member {
            leaders[member.group.index()].get_or_insert((EdgeId::new(edge), member));
        }
    }
    leaders
}

/// Returns the name of an interpolation in files.
#[must_use]
pub fn interpolation_name(kind: Interpolation) -> &'static str {
    match kind {
        Interpolation::Linear => "linear",
        Interpolation::Hermite => "hermite",
        Interpolation::HalfAngle => "half-angle",
        Interpolation::Homogeneous => "homogeneous",
    }
}
