//! Places the fewest knots with one interpolation and time law. Segments that do not fit are divided, then knots that are
//! not needed are removed.

use core::time::Duration;
use std::collections::HashMap;

use foldpath_core::{Curve, Interpolation, Node};

use super::overshoot::peaks;
use super::reduced_path::ReducedPath;
use super::segment::{SegmentBuilder, TimeLaw};
use crate::certificate::{Closure, FoldingCertifier, SegmentCertifier, range};
use crate::motion::Knot;
use crate::planner::closing::solver::ClosureSolver;
use crate::planner::following::follow::Waypoint;
use crate::planner::knots::{KnotSequence, Open};
use crate::symmetry::ReducedStars;
use crate::util::parallel;

/// About the time that finding the extremes of a curve takes.
const TIME_PER_CURVE: Duration = Duration::from_nanos(300);

/// Conditions that the motion between knots has to keep.
pub(crate) struct PlacementConstraints<'a> {
    /// One star for each distinct closure condition, and the loops round holes.
    pub(crate) stars: &'a ReducedStars,
    /// Largest closure residual; with `None` any residual is allowed, and all waypoints are knots.
    pub(crate) closure: Option<f64>,
    /// Bounds that the whole sheet has to keep, if any.
    pub(crate) sheet: Option<SheetBounds<'a>>,
    /// Lower and upper bound of each group angle, radians.
    pub(crate) limits: &'a [(f64, f64)],
    /// Largest speed of a hinge, radians per second.
    pub(crate) speed: f64,
    /// Largest acceleration of a hinge, radians per second squared; infinite for any.
    pub(crate) acceleration: f64,
    /// Largest number of knots.
    pub(crate) knot_budget: usize,
}

/// Bounds on deformation and gap of the whole sheet.
#[derive(Clone)]
pub(crate) struct SheetBounds<'a> {
    pub(crate) certifier: FoldingCertifier<'a>,
    /// Bound for which knots are added as long as that helps.
    pub(crate) aim: f64,
    /// Bound that is kept in any case.
    pub(crate) bound: f64,
}

/// Places knots on a path.
pub(super) struct KnotPlacer<'a, 's> {
    path: &'a ReducedPath,
    constraints: &'a PlacementConstraints<'a>,
    solver: &'a mut ClosureSolver<'s>,
    /// Largest number of knots.
    pub(super) knot_budget: usize,
    /// Path length beyond which the motion has to keep the closure condition, to be placed at all.
    pub(super) keeps_to: f64,
    certifier: SegmentCertifier,
    sheet: Option<SheetBounds<'a>>,
    /// Configurations found on the path in addition to its waypoints.
    found: Vec<Waypoint>,
    curves: Vec<Curve<f64>>,
    /// Bounds on the closure of segments that keep the conditions, by the path lengths at their ends.
    known: HashMap<[u64; 2], Closure>,
}

/// Fraction by which a hinge may exceed its limits before time is stretched at the end.
const LIMIT_EXCESS_RATIO: f64 = 0.02;
/// Fraction by which time is stretched in addition, so that rounding the knots passes no limit.
const STRETCH_MARGIN_RATIO: f64 = 1e-5;
/// Distance of two knots, as a fraction of that of the waypoints around them, below which no knot is put between them.
const MIN_SPACING_RATIO: f64 = 1.0 / 256.0;
/// Path length from its limit within which a hinge is put to rest at the limit: while others move on, solving would
/// move it to and fro.
const RESTING_LENGTH: f64 = 1e-4;
/// Distance beyond its limit up to which a hinge counts as being at the limit, radians.
const AT_LIMIT_RAD: f64 = 1e-9;

/// Returns `true` if a hinge keeps its limits all along its curve.
fn is_within((curve, limit): (&Curve<f64>, &(f64, f64))) -> bool {
    let [lower, upper] = range(curve);
    lower >= limit.0 - AT_LIMIT_RAD && upper <= limit.1 + AT_LIMIT_RAD
}

impl<'a, 's> KnotPlacer<'a, 's> {
    pub(super) fn new(
        path: &'a ReducedPath,
        constraints: &'a PlacementConstraints<'a>,
        solver: &'a mut ClosureSolver<'s>,
    ) -> Self {
        Self {
            path,
            constraints,
            solver,
            knot_budget: constraints.knot_budget,
            keeps_to: f64::NEG_INFINITY,
            certifier: SegmentCertifier::default(),
            sheet: constraints.sheet.clone(),
            found: Vec::new(),
            curves: Vec::new(),
            known: HashMap::new(),
        }
    }

    /// Returns the single configuration of a path of length 0.
    pub(super) fn alone(&mut self) -> Option<KnotSequence> {
        let angles = self.path.waypoints().first()?.angles.clone();
        Some(KnotSequence {
            interpolation: Interpolation::Hermite,
            knots: vec![Knot {
                rates: vec![0.0; angles.len()],
                angles,
                ..Knot::default()
            }],
            closure: self.closed(),
            ..KnotSequence::default()
        })
    }

    /// Places the fewest knots found with this interpolation and time law. If even the densest knots do not keep the
    /// closure condition, the bound on closure says so. Returns `None` if more knots are needed than allowed, the
    /// interpolation does not pass where the path does, or the motion does not keep the condition as far as it has to.
    pub(super) fn place(&mut self, kind: Interpolation, law: &TimeLaw) -> Option<KnotSequence> {
        self.known.clear();
        let builder = SegmentBuilder::new(self.path, kind, law);
        let waypoints = self.path.waypoints();
        let mut points = vec![waypoints.first()?.clone()];
        let mut open = vec![waypoints.last()?.clone()];
        if self.constraints.closure.is_none() {
            open.extend(self.path.inner().rev().map(|index| self.waypoint(index)));
            points.extend(open.drain(..).rev());
            self.stay_within(&builder, &mut points)?;
            return self.knots(&builder, &points);
        }
        // Knots are needed first of all at configurations where the motion rests, a phase ends, or accelerations jump.
        let mut needed: Vec<Waypoint> = self
            .path
            .inner()
            .map(|index| self.waypoint(index))
            .collect();
        needed.retain(Waypoint::stays);
        if let (TimeLaw::Optimal(law), true) = (law, self.constraints.acceleration.is_finite()) {
            let switches = law.switches().iter().map(|k| law.parameters()[*k]);
            let (start, end) = (points[0].arc_length, open[0].arc_length);
            let inner = switches.filter(|arc_length| *arc_length > start && *arc_length < end);
            needed.extend(inner.filter_map(|arc_length| self.point_at(arc_length)));
        }
        needed.sort_by(|a, b| {
            b.arc_length
                .total_cmp(&a.arc_length)
                .then(a.rests().cmp(&b.rests()))
        });
        needed.dedup_by(|a, b| {
            let same = a.arc_length.to_bits() == b.arc_length.to_bits();
            b.ends_phase |= same && a.ends_phase;
            same
        });
        open.extend(needed);
        let mut fits = true;
        while let (Some(from), Some(to)) = (points.last(), open.last()) {
            let (from, to) = (from.clone(), to.clone());
            if self.fits(&builder, &from, &to)? {
                points.extend(open.pop());
            } else if let Some(between) = self.between(&from, &to) {
                open.push(between);
            } else if from.arc_length > self.keeps_to && self.deforms_within(|sheet| sheet.bound) {
                fits = false;
                points.extend(open.pop());
            } else {
                return None;
            }
            // Halving a segment that does not fit leaves less than twice the knots needed.
            if points.len() + open.len() > self.knot_budget.saturating_mul(2) {
                return None;
            }
        }
        self.thin(&builder, &mut points)?;
        if !fits {
            self.stay_within(&builder, &mut points)?;
        }
        if points.len() > self.knot_budget {
            return None;
        }
        self.knots(&builder, &points)
    }

    /// Lets a hinge rest at two knots between which it would turn beyond its limits, as happens on a motion that closes
    /// only roughly. The hinge then turns from one angle to the other and no farther.
    fn stay_within(&mut self, builder: &SegmentBuilder<'_>, points: &mut [Waypoint]) -> Option<()> {
        // Segments of which an end was changed since they were looked at last, by the number of their end.
        let count = points.len();
        let mut changed = vec![true; count];
        while changed[1..].contains(&true) {
            for index in 1..count {
                if !core::mem::take(&mut changed[index]) {
                    continue;
                }
                self.span(builder, &points[index - 1], &points[index])?;
                for (group, pair) in self.curves.iter().zip(self.constraints.limits).enumerate() {
                    if is_within(pair) {
                        continue;
                    }
                    for k in [index - 1, index] {
                        let rate = &mut points[k].tangent[group];
                        if rate.abs() > 0.0 {
                            changed[k] = true;
                            changed[(k + 1).min(count - 1)] = true;
                        }
                        *rate = 0.0;
                    }
                    self.known.clear();
                }
            }
        }
        Some(())
    }

    /// Removes knots while the motion between those that remain keeps the conditions.
    fn thin(&mut self, builder: &SegmentBuilder<'_>, points: &mut Vec<Waypoint>) -> Option<()> {
        let mut index = 1;
        while index + 1 < points.len() {
            if !points[index].stays()
                && self.fits(builder, &points[index - 1], &points[index + 1])?
            {
                points.remove(index);
            } else {
                index += 1;
            }
        }
        Some(())
    }

    /// Makes the curves between two configurations, and returns the time between them. Returns `None` if there are no
    /// such curves, or time is up.
    fn span(
        &mut self,
        builder: &SegmentBuilder<'_>,
        from: &Waypoint,
        to: &Waypoint,
    ) -> Option<f64> {
        if self.solver.is_late() {
            return None;
        }
        builder.curves(from, to, &mut self.curves)
    }

    /// Returns `true` if the motion between two configurations keeps the conditions; `None` if there are no curves
    /// between them, or time is up.
    fn fits(
        &mut self,
        builder: &SegmentBuilder<'_>,
        from: &Waypoint,
        to: &Waypoint,
    ) -> Option<bool> {
        let span = self.span(builder, from, to)?;
        let constraints = self.constraints;
        let (curves, limits) = (&self.curves, constraints.limits);
        let within = parallel::all(curves.len().min(limits.len()), TIME_PER_CURVE, |group| {
            is_within((&curves[group], &limits[group]))
        });
        let optimal = matches!(builder.law, TimeLaw::Optimal(_));
        if !within || optimal && self.exceeds_limits(builder, from, to, span) {
            return Some(false);
        }
        let Some(max_residual) = constraints.closure else {
            return Some(true);
        };
        // Most segments that do not close well enough show it in the middle.
        let middle: Vec<f64> = self.curves.iter().map(|curve| curve.angle(0.5)).collect();
        if constraints.stars.largest_residual(&middle) > max_residual {
            return Some(false);
        }
        let bounds = self.bounds();
        let closes = bounds.worst() <= max_residual;
        let fits = closes && self.deforms_within(|sheet| sheet.aim);
        if fits {
            self.known.insert(key(from, to), bounds);
        }
        Some(fits)
    }

    /// Returns `true` if the whole sheet deforms by no more than `most` over the present curves, or no bound on it is
    /// asked for.
    fn deforms_within(&mut self, most: fn(&SheetBounds<'_>) -> f64) -> bool {
        let Some(sheet) = &mut self.sheet else {
            return true;
        };
        let most = most(sheet);
        sheet.certifier.rigidity(&self.curves, most).is_some()
    }

    /// Returns bounds on the closure over the present curves.
    fn bounds(&mut self) -> Closure {
        let stars = self.constraints.stars;
        let (stars, loops) = (stars.view(), stars.loops());
        self.certifier.closure(stars, loops, &self.curves).clone()
    }

    /// Returns the bounds of a motion in which nothing moves.
    fn closed(&self) -> Closure {
        Closure {
            stars: vec![0.0; self.constraints.stars.vertices().len()],
            loops: vec![[0.0; 2]; self.constraints.stars.holes().len()],
        }
    }

    /// Returns `true` if hinges of the present curves, made between these configurations, are too fast, and more knots
    /// between could mend that. They cannot if a hinge is too fast at one of the two: while one hinge rests at its
    /// limit, others may be faster than the time law allows.
    fn exceeds_limits(
        &self,
        builder: &SegmentBuilder<'_>,
        from: &Waypoint,
        to: &Waypoint,
        span: f64,
    ) -> bool {
        let limit_ratio = self.limit_ratio(builder.kind, span) / (1.0 + LIMIT_EXCESS_RATIO);
        let mut rates = builder.nodes(from).chain(builder.nodes(to));
        limit_ratio > 1.0
            && rates.all(|node| node.rate.abs() < limit_ratio * self.constraints.speed)
    }

    /// Returns the factor by which time has to be stretched so that the hinges of the present curves keep their limits.
    fn limit_ratio(&self, kind: Interpolation, span: f64) -> f64 {
        let peaks = parallel::map(&self.curves, TIME_PER_CURVE, peaks);
        let most = peaks.iter().fold([0.0; 2], |most, peaks| {
            [0, 1].map(|k| f64::max(most[k], peaks[k]))
        });
        let speed = most[0] / (span * self.constraints.speed);
        if kind == Interpolation::Linear {
            return speed;
        }
        speed.max((most[1] / (span * span * self.constraints.acceleration)).sqrt())
    }

    /// Returns the waypoint of this number, which is not an end.
    fn waypoint(&mut self, index: usize) -> Waypoint {
        let point = self.path.waypoints()[index].clone();
        self.within_limits(point)
    }

    /// Corrects a configuration between the ends. A hinge at its limit has just reached the limit or is about to leave
    /// it, so that its rate is 0.
    fn within_limits(&mut self, mut point: Waypoint) -> Waypoint {
        let hinges = point.angles.iter().zip(&point.tangent);
        let limits = hinges.zip(self.constraints.limits);
        let at_limit = limits.map(|((angle, rate), (lower, upper))| {
            let near = AT_LIMIT_RAD.max(RESTING_LENGTH * rate.abs());
            let mut limits = [*lower, *upper].into_iter();
            limits.find(|limit| (angle - limit).abs() <= near)
        });
        let at_limit: Vec<Option<f64>> = at_limit.collect();
        let mut rates = at_limit.iter().zip(&point.tangent);
        if rates.any(|(limit, rate)| limit.is_some() && rate.abs() > 0.0) {
            let angles = point.angles.iter().zip(&at_limit);
            let angles: Vec<f64> = angles.map(|(a, limit)| limit.unwrap_or(*a)).collect();
            let held = self.solver.project_on_motions(&angles, &mut point.tangent);
            if held.is_none() {
                point.tangent.fill(0.0);
            }
            let rates = point.tangent.iter_mut().zip(&at_limit);
            rates
                .filter(|(_, limit)| limit.is_some())
                .for_each(|(rate, _)| *rate = 0.0);
        }
        point
    }

    /// Returns a configuration between two others, if they are far enough apart.
    fn between(&mut self, from: &Waypoint, to: &Waypoint) -> Option<Waypoint> {
        if let Some(index) = self.path.waypoint_between(from.arc_length, to.arc_length) {
            return Some(self.waypoint(index));
        }
        let middle = (from.arc_length + to.arc_length) / 2.0;
        let waypoints = self.path.waypoints();
        let next = waypoints.partition_point(|waypoint| waypoint.arc_length <= middle);
        let around =
            waypoints.get(next)?.arc_length - waypoints.get(next.checked_sub(1)?)?.arc_length;
        if to.arc_length - from.arc_length <= MIN_SPACING_RATIO * around {
            return None;
        }
        self.point_at(middle)
    }

    /// Returns the closed configuration at a path length.
    fn point_at(&mut self, arc_length: f64) -> Option<Waypoint> {
        let known = self
            .found
            .iter()
            .find(|point| point.arc_length.to_bits() == arc_length.to_bits());
        if let Some(point) = known {
            return Some(point.clone());
        }
        let point = self.path.closed(self.solver, arc_length)?;
        let point = self.within_limits(point);
        self.found.push(point.clone());
        Some(point)
    }

    /// Makes the knots at these configurations, with time stretched so that no hinge is too fast.
    fn knots(&mut self, builder: &SegmentBuilder<'_>, points: &[Waypoint]) -> Option<KnotSequence> {
        let (mut closure, mut open) = (self.closed(), None);
        let most = self.constraints.closure.unwrap_or(f64::INFINITY);
        let mut stretch = 0.0;
        for (segment, pair) in points.windows(2).enumerate() {
            let span = self.span(builder, &pair[0], &pair[1])?;
            let known = self.known.remove(&key(&pair[0], &pair[1]));
            let deforms = known.is_none() && !self.deforms_within(|sheet| sheet.bound);
            let here = known.unwrap_or_else(|| self.bounds());
            if open.is_none() && (deforms || here.worst() > most) {
                open = Some(Open {
                    segment,
                    arc_length: pair[0].arc_length,
                    before: closure.clone(),
                });
            }
            closure.take_in(here.bounds());
            stretch = f64::max(stretch, self.limit_ratio(builder.kind, span));
        }
        stretch *= 1.0 + STRETCH_MARGIN_RATIO;
        let start = builder.law.at(&points[0])[0];
        let knots = points.iter().map(|point| {
            let nodes: Vec<Node<f64>> = builder.nodes(point).collect();
            let homogeneous = builder.kind == Interpolation::Homogeneous;
            let weights = nodes.iter().filter(|_| homogeneous);
            Knot {
                time: (builder.law.at(point)[0] - start) * stretch,
                angles: point.angles.clone(),
                rates: nodes.iter().map(|node| node.rate / stretch).collect(),
                weights: weights
                    .map(|node| [node.weight[0], node.weight[1] / stretch])
                    .collect(),
                ..Knot::default()
            }
        });
        let phases = (0..points.len()).filter(|&index| points[index].ends_phase);
        Some(KnotSequence {
            interpolation: builder.kind,
            knots: knots.collect(),
            phases: phases.collect(),
            closure,
            open,
        })
    }
}

/// Returns the key of the segment between two configurations.
fn key(from: &Waypoint, to: &Waypoint) -> [u64; 2] {
    [from, to].map(|point| point.arc_length.to_bits())
}
