//! Computes the curves of a path that a plot shows.

use foldpath_core::Membership;

use crate::check::{CheckOptions, check_until_over, clearances_until_over, measure};
use crate::folding::{Dihedral, shapes};
use crate::motion::{GroupNaming, Motion};
use crate::pattern::EdgeId;
use crate::progress::{Progress, Watch};
use crate::sensitivity::Loads;

/// Number of times along a path at which curves are sampled, besides the knots. Large sheets have fewer samples, so
/// that at most `FOLDED` faces are folded in all.
const PLACES: usize = 240;
const FOLDED: usize = 20_000_000;
/// Largest number of curves of angles; the eye cannot distinguish more.
const MOST_CURVES: usize = 200;
/// Number of times at which the clearance is measured.
const CLEARANCES: usize = 120;

/// Time in seconds, and the value of a curve.
pub type Point = (f64, f64);

/// The curves of a path.
#[derive(Clone, Debug, Default)]
pub struct Curves {
    /// Name of the path.
    pub title: String,
    /// Times of the knots.
    pub knots: Vec<f64>,
    /// Fold angles (degrees) of the first 200 crease groups, or of the first 200 creases if the file has no groups.
    pub angles: Vec<Vec<Point>>,
    /// Number of crease groups, or of creases if the file has no groups.
    pub count: usize,
    /// `true` if the curves are those of crease groups.
    pub grouped: bool,
    /// Assigned and measured fold angles, degrees. Each knot has a point for each edge between two faces, and a point
    /// for each diagonal, whose assigned angle is 0.
    pub measured: Vec<Point>,
    /// Largest relative change of length.
    pub deformation: Vec<Point>,
    /// Largest gap over the median edge.
    pub gap: Vec<Point>,
    /// Segments between two knots, from and to (seconds), with a bound on deformation and gap in the segment.
    pub certified: Vec<(f64, f64, f64)>,
    /// Smallest distance between faces that share no vertex; empty if there are no such faces, or too many faces.
    pub clearance: Vec<Point>,
    /// Smallest distance met along the whole motion, if no faces pass through each other.
    pub min_clearance: Option<f64>,
    /// Torque of each driver, newton metres, with the edge of its hinge; none unless [`with_torques`](Self::with_torques) adds
    /// them.
    pub torques: Vec<(EdgeId, Vec<Point>)>,
}

impl Curves {
    /// Computes the curves of a path. Cost: that of a [`check`](crate::check), plus folding some hundred shapes.
    #[must_use]
    pub fn of_path(path: &Motion) -> Self {
        Self::of_path_watched(path, &Progress::default())
    }

    /// Computes the curves of a path and reports the progress to `progress`. Once cancelled, everything not yet
    /// measured is left out.
    #[must_use]
    pub fn of_path_watched(path: &Motion, progress: &Progress) -> Self {
        let watch = Watch::new(progress);
        let mut curves = Self {
            title: path.title.clone(),
            knots: path.knots.iter().map(|knot| knot.time).collect(),
            grouped: path.naming != GroupNaming::Unnamed,
            angles: angles(path),
            count: path.curves_shown().len(),
            measured: measured(path),
            clearance: clearance(path, watch),
            ..Self::default()
        };
        curves.judge(path, watch);
        curves
    }

    /// Adds the torques of the drivers of this path.
    #[must_use]
    pub fn with_torques(mut self, path: &Motion, loads: &Loads) -> Self {
        let drivers = loads.drivers.iter().enumerate();
        let curves = drivers.map(|(k, driver)| {
            let moments = loads.times.iter().zip(&loads.torques);
            let points = moments.map(|(time, torques)| (*time, torques[k]));
            (path.pattern.creases()[driver.index()], points.collect())
        });
        self.torques = curves.collect();
        self
    }

    /// Measures deformation and gap, and bounds both over the whole motion.
    fn judge(&mut self, path: &Motion, watch: Watch<'_>) {
        let segments = path.knots.len().saturating_sub(1);
        let affordable = FOLDED / path.pattern.faces().len().max(1) / segments.max(1);
        let options = CheckOptions {
            samples: places_of(segments).min(affordable).max(1),
            ..CheckOptions::default()
        };
        let verdict = check_until_over(path, &options, watch);
        let samples = verdict.samples.iter().map(|sample| {
            let [from, to] = [sample.segment, sample.segment + 1].map(|knot| self.knots[knot]);
            (from + sample.at * (to - from), sample.rigidity)
        });
        let knots = self.knots.iter().copied().zip(&verdict.knots);
        let knots = knots.map(|(time, knot)| (time, knot.rigidity));
        let mut shapes: Vec<_> = knots.chain(samples).collect();
        shapes.sort_by(|a, b| a.0.total_cmp(&b.0));
        self.deformation = shapes
            .iter()
            .map(|(time, r)| (*time, r.deformation))
            .collect();
        self.gap = shapes.iter().map(|(time, r)| (*time, r.gap)).collect();
        let bounds = self.knots.windows(2).zip(&verdict.segments);
        let bounds = bounds.filter_map(|(ends, segment)| {
            let most = segment.rigidity?;
            Some((ends[0], ends[1], most.deformation.max(most.gap)))
        });
        self.certified = bounds.collect();
        self.min_clearance = verdict.min_clearance;
    }
}

/// Returns the number of samples inside each of `segments` segments.
fn places_of(segments: usize) -> usize {
    PLACES.checked_div(segments).unwrap_or(0).clamp(1, PLACES)
}

/// Returns the angle of each curve at the knots and between them, degrees.
fn angles(path: &Motion) -> Vec<Vec<Point>> {
    let segments = path.knots.len().saturating_sub(1);
    let steps = places_of(segments) + 1;
    #[allow(clippy::cast_precision_loss, reason = "a few hundred")]
    let place = |step: usize| step as f64 / steps as f64;
    let curve = |&(edge, member): &(EdgeId, Option<Membership>)| {
        let signed = |angle: f64| member.map_or(angle, |m| m.apply(angle)).to_degrees();
        let first = path.knots.first();
        let first = first.map(|knot| (knot.time, signed(path.node(0, edge).angle)));
        let rest = (0..segments).map(|segment| {
            let curve = path.curve(segment, edge);
            let [from, to] = [segment, segment + 1].map(|knot| path.knots[knot].time);
            let point = move |s: f64| (from + s * (to - from), signed(curve.angle(s)));
            (1..=steps).map(move |step| point(place(step)))
        });
        first.into_iter().chain(rest.flatten()).collect()
    };
    path.curves_shown()
        .iter()
        .take(MOST_CURVES)
        .map(curve)
        .collect()
}

/// Returns assigned and measured angles at the knots, degrees. Half a turn either way is the same shape, so the
/// measured angle is the one nearer to the assigned angle.
fn measured(path: &Motion) -> Vec<Point> {
    let dihedrals = Dihedral::all(&path.pattern);
    let mut points = Vec::new();
    for (knot, shape) in shapes(path).enumerate() {
        points.extend(dihedrals.iter().map(|dihedral| {
            let assigned = dihedral
                .edge
                .map_or(0.0, |edge| path.node(knot, edge).angle);
            let (assigned, measured) = (
                assigned.to_degrees(),
                dihedral.fold_angle(&shape).to_degrees(),
            );
            let turns = ((assigned - measured) / 360.0).round();
            (assigned, measured + 360.0 * turns)
        }));
    }
    points
}

/// Returns the clearance at times spaced evenly.
fn clearance(path: &Motion, watch: Watch<'_>) -> Vec<Point> {
    let shapes = path.resampled(CLEARANCES);
    let found = clearances_until_over(path, &shapes, &measure(&shapes, path.pattern.tree()), watch);
    let points = shapes.knots.iter().zip(found.shapes);
    let points = points.filter_map(|(knot, distance)| Some((knot.time, distance?)));
    points.collect()
}
