//! A path with its sheet, in the form in which it is sent.

use std::path::Path;

use foldpath_core::acceptance::{Refusal, most_commanded, stay_closed};
use foldpath_core::follower::FollowerPosition;
use foldpath_core::trajectory::TrajectoryView;
use foldpath_core::trajectory_file::TrajectoryFile;
use foldpath_core::wire::path::PathItems;
use foldpath_core::{GroupLimits, Membership, Scalar, Spoke, StarsView};

use crate::export::traj::TrajectoryArrays;
use crate::read::FileError;
use crate::symmetry::largest_star_residual;

/// Difference (radians) up to which two angles count as the same: the rounding of half a turn to `f32`, with room for that
/// of the path from which the file was exported.
const SAME_ANGLE_RAD: f32 = 1e-6;

/// Places of a segment at which measured angles are compared with it, from 0 to 1.
const NEAREST_GRID: [f32; 9] = [0.0, 0.125, 0.25, 0.375, 0.5, 0.625, 0.75, 0.875, 1.0];
/// Difference of distances from measured angles (radians) up to which two places are as near: less than sensors err.
const SAME_PLACE_RAD: f32 = 0.005;
/// The same difference before the places are refined.
const NEAREST_STEP_RAD: f32 = 0.2;

/// The decoded content of a `.traj` file.
#[derive(Clone, Debug)]
pub struct StreamPath {
    knots: TrajectoryArrays<f32>,
    /// Times of the knots, seconds.
    times: Vec<f64>,
    /// `true` if the path is the reverse of that of the file.
    reversed: bool,
    limits: Vec<GroupLimits>,
    hinges: Vec<Membership>,
    /// Spokes of the essential vertices, the same spokes in `f64`, and for each vertex the index behind its last spoke.
    spokes: Vec<Spoke<f32>>,
    wide: Vec<Spoke<f64>>,
    ends: Vec<u32>,
    closure: f32,
    /// Distance between a hinge and its command from which on the motion has to hold, radians; infinite for that of the
    /// controller.
    most_lag: f32,
    /// Gap for each radian by which a hinge alone is off, median edges, for each hinge; empty if the file does not tell.
    gaps: Vec<f32>,
}

impl StreamPath {
    /// Reads a path from the bytes of a `.traj` file; `file` names the file in errors.
    ///
    /// # Errors
    /// If the bytes are no trajectory, or if the path has no knots or more of anything than can be sent.
    pub fn read(bytes: &[u8], file: &Path) -> Result<Self, FileError> {
        let path = file.to_path_buf();
        let traj =
            TrajectoryFile::read(bytes).map_err(|source| FileError::Trajectory { path, source })?;
        let groups = traj.groups();
        let places = (0..traj.len()).flat_map(|k| (0..groups).map(move |g| (k, g)));
        let nodes: Vec<_> = places.filter_map(|(k, g)| traj.node(k, g)).collect();
        let ends = (1..).zip(traj.spokes()).filter(|(_, (_, last))| *last);
        let spans: Vec<f32> = (0..traj.len()).filter_map(|k| traj.span(k)).collect();
        let this = Self {
            times: times(&spans),
            knots: TrajectoryArrays::new(traj.interpolation(), groups, spans, &nodes),
            reversed: false,
            limits: (0..groups).filter_map(|g| traj.limits(g)).collect(),
            hinges: traj.memberships().collect(),
            spokes: traj.spokes().map(|(spoke, _)| spoke).collect(),
            wide: traj.spokes().map(|(spoke, _)| widened(spoke)).collect(),
            ends: ends.map(|(end, _)| end).collect(),
            closure: traj.closure(),
            most_lag: traj.most_lag(),
            gaps: traj.gaps().collect(),
        };
        if this.items().is_none() {
            let expected =
                "knots of 1 to 16384 crease groups, at most as many hinges and as many spokes";
            let [knots, hinges, spokes] =
                [this.times().len(), this.hinges.len(), this.spokes.len()];
            let found =
                format!("{knots} knots of {groups} groups, {hinges} hinges, {spokes} spokes");
            return Err(FileError::expected(file, "path", expected, found));
        }
        if let Some((knot, star)) = this.first_open() {
            let place = format!("segment before knot {knot}");
            let expected = format!(
                "essential vertices that stay closed within {:e}, as the file says",
                this.closure
            );
            let found = format!("vertex {star} open by more");
            return Err(FileError::expected(file, &place, expected, found));
        }
        Ok(this)
    }

    /// Returns the first knot before which an essential vertex is not known to stay closed, and the vertex. A controller
    /// would refuse it.
    fn first_open(&self) -> Option<(usize, u16)> {
        let (view, stars) = (self.view()?, self.stars()?);
        (1..view.len()).find_map(|k| {
            match stay_closed(stars, |group| view.curve(k - 1, group), self.closure) {
                Err(Refusal::OpenBetween(star)) => Some((k, star)),
                _ => None,
            }
        })
    }

    /// Returns the way back: the knots and the spans between them in reverse order, their rates negated. The angles are those
    /// of this path at mirrored times. The reverse of the reverse is this path.
    #[must_use]
    pub fn reverse(&self) -> Self {
        let (groups, knots) = (self.groups(), &self.knots);
        // The first knot has the span 0 both ways.
        let mut spans = knots.spans.clone();
        if let Some((_, spans)) = spans.split_first_mut() {
            spans.reverse();
        }
        Self {
            times: times(&spans),
            knots: TrajectoryArrays {
                spans,
                angles: reversed_rows(&knots.angles, groups, |angle| angle),
                rates: reversed_rows(&knots.rates, groups, |rate| -rate),
                weights: reversed_rows(&knots.weights, groups, |[weight, rate]| [weight, -rate]),
                ..*knots
            },
            reversed: !self.reversed,
            ..self.clone()
        }
    }

    /// Returns `true` if the path is the [reverse](Self::reverse) of that of the file.
    #[must_use]
    pub fn is_reversed(&self) -> bool {
        self.reversed
    }

    /// Returns `true` if the path begins flat: with all angles at 0, but for rounding.
    #[must_use]
    pub fn begins_flat(&self) -> bool {
        let begin = self.knots.angles.iter().take(self.groups());
        begin.into_iter().all(|angle| angle.abs() <= SAME_ANGLE_RAD)
    }

    /// Returns `true` if the path begins at the goal, but for rounding: at the last knot of the path of the file.
    #[must_use]
    pub fn begins_at_goal(&self) -> bool {
        let (groups, angles) = (self.groups(), &self.knots.angles);
        let begin = angles.iter().take(groups);
        let goal = angles.iter().skip(angles.len().saturating_sub(groups));
        let same = |(a, b): (&f32, &f32)| (a - b).abs() <= SAME_ANGLE_RAD;
        self.reversed || begin.zip(goal).all(same)
    }

    /// Returns the number of crease groups.
    #[must_use]
    pub fn groups(&self) -> usize {
        self.limits.len()
    }

    /// Returns the times of the knots, seconds.
    #[must_use]
    pub fn times(&self) -> &[f64] {
        &self.times
    }

    /// Returns the group and sign of each hinge.
    #[must_use]
    pub fn hinges(&self) -> &[Membership] {
        &self.hinges
    }

    /// Returns the limits of each group.
    #[must_use]
    pub fn limits(&self) -> &[GroupLimits] {
        &self.limits
    }

    /// Returns the largest closure residual that the controller accepts: that of the path, rounding included.
    #[must_use]
    pub fn closure(&self) -> f32 {
        self.closure
    }

    /// Returns the gap of the sheet (median edges) if one hinge alone is off its command by `angle`, radians; `None` if the file
    /// does not tell what the hinge costs.
    #[must_use]
    pub fn gap(&self, hinge: usize, angle: f32) -> Option<f64> {
        let gap = self.gaps.get(hinge)?;
        Some((gap * angle.abs()).to_f64())
    }

    /// Returns the largest closure residual of an essential vertex at these group angles (radians); 0 if `angles` has
    /// not one angle for each group.
    #[must_use]
    pub fn residual(&self, angles: &[f32]) -> f64 {
        let angles: Vec<f64> = angles.iter().map(|angle| angle.to_f64()).collect();
        let stars = StarsView::new(&self.wide, &self.ends, self.groups());
        let stars = stars.filter(|_| angles.len() == self.groups());
        stars.map_or(0.0, |stars| largest_star_residual(stars, &angles))
    }

    /// Returns the largest closure residual that a controller may tell of a place on the path: with what its own bounds and
    /// rounding add.
    #[must_use]
    pub fn max_reported_closure(&self) -> f64 {
        let stars = self.stars();
        let spokes = stars.map_or(0, |stars| stars.max_degree());
        most_commanded(self.closure, spokes).to_f64()
    }

    /// Returns the place of the path that is nearest to these measured angles of the hinges (radians, NaN for none): where the
    /// group that is farthest from the mean of its hinges is nearest to it. It is the place nearest to `told` if
    /// others are as near. `None` if no hinge was measured.
    #[must_use]
    pub fn nearest(
        &self,
        measured: &[f32],
        told: FollowerPosition<f32>,
    ) -> Option<FollowerPosition<f32>> {
        let view = self.view()?;
        let means = self.group_means(measured);
        if means.is_empty() {
            return None;
        }
        let distance = |(k, s): (usize, f32)| {
            let off = means.iter().map(|(group, mean)| {
                let curve = view.curve(k, *group);
                curve.map_or(f32::INFINITY, |curve| (curve.angle(s) - mean).abs())
            });
            off.fold(0.0, f32::max)
        };
        let times = self.times();
        let time = |(k, s): (usize, f32)| {
            let ends = times.get(k).zip(times.get(k + 1));
            ends.map_or(0.0, |(from, to)| from + s.to_f64() * (to - from))
        };
        let told = times.get(usize::try_from(told.knot).ok()?)? + told.into.to_f64();
        let segments = times.len().saturating_sub(1);
        let grid = (0..segments).flat_map(|k| NEAREST_GRID.map(|s| (k, s)));
        let far: Vec<f32> = grid.clone().map(distance).collect();
        let at = |index: usize| far.get(index).copied().unwrap_or(f32::INFINITY);
        let least = far.iter().copied().fold(f32::INFINITY, f32::min);
        let is_least = |index: usize| {
            let beside = at(index.wrapping_sub(1)).min(at(index + 1));
            at(index) <= beside && at(index) <= least + NEAREST_STEP_RAD
        };
        let minima = grid.enumerate().filter(|(index, _)| is_least(*index));
        let refined = minima.map(|(_, (k, s))| (k, refined(s, |s| distance((k, s)))));
        let refined: Vec<_> = refined.map(|place| (place, distance(place))).collect();
        let least = refined.iter().map(|(_, far)| *far).reduce(f32::min)?;
        let alike = refined
            .iter()
            .filter(|(_, far)| *far <= least + SAME_PLACE_RAD);
        let off = |place| (time(place) - told).abs();
        let ((k, s), _) = alike.min_by(|(a, _), (b, _)| off(*a).total_cmp(&off(*b)))?;
        let (knot, into) = if *s >= 1.0 {
            (k + 1, 0.0)
        } else {
            (*k, s * self.knots.spans.get(k + 1)?)
        };
        let knot = u32::try_from(knot).ok()?;
        Some(FollowerPosition { knot, into })
    }

    /// Returns each group of which hinges were measured, and the mean of their angles, radians.
    fn group_means(&self, measured: &[f32]) -> Vec<(usize, f32)> {
        let mut sums = vec![(0.0, 0.0); self.groups()];
        for (membership, angle) in self.hinges.iter().zip(measured) {
            let sum = sums.get_mut(membership.group.index());
            if let Some((sum, count)) = sum.filter(|_| angle.is_finite()) {
                *sum += membership.apply(*angle);
                *count += 1.0;
            }
        }
        let measured = sums
            .iter()
            .enumerate()
            .filter(|(_, (_, count))| *count > 0.0);
        measured
            .map(|(group, (sum, count))| (group, sum / count))
            .collect()
    }

    /// Returns the stars of the essential vertices.
    #[must_use]
    pub fn stars(&self) -> Option<StarsView<'_, f32>> {
        StarsView::new(&self.spokes, &self.ends, self.groups())
    }

    /// Returns the path as a trajectory of core.
    #[must_use]
    pub fn view(&self) -> Option<TrajectoryView<'_, f32>> {
        self.knots.view().ok()
    }

    /// Returns the path as the sequence of items to send, from its start.
    #[must_use]
    pub fn items(&self) -> Option<PathItems<'_>> {
        let (limits, hinges) = (&self.limits, &self.hinges);
        let items = PathItems::new(
            self.view()?,
            limits,
            hinges,
            self.stars()?,
            self.closure,
            FollowerPosition::default(),
        )?;
        Some(items.with_most_lag(self.most_lag))
    }
}

/// Returns the place near `s`, between the places of the grid beside it, at which `distance` is least.
fn refined(s: f32, distance: impl Fn(f32) -> f32) -> f32 {
    let (mut from, mut to) = ((s - 0.125).max(0.0), (s + 0.125).min(1.0));
    for _ in 0..24 {
        let [a, b] = [1.0, 2.0].map(|part| from + (to - from) * part / 3.0);
        if distance(a) <= distance(b) {
            to = b;
        } else {
            from = a;
        }
    }
    // The ends are knots, at which rounding leaves nothing.
    let inner = (from + to) / 2.0;
    let ends = [0.0, 1.0]
        .into_iter()
        .filter(|end| (end - s).abs() <= 0.125);
    ends.fold(inner, |best, end| {
        if distance(end) <= distance(best) {
            end
        } else {
            best
        }
    })
}

/// Returns the times of knots with these spans, seconds.
fn times(spans: &[f32]) -> Vec<f64> {
    let sums = spans.iter().scan(0.0, |time, span| {
        *time += span.to_f64();
        Some(*time)
    });
    sums.collect()
}

/// Returns rows of `width` numbers in reverse order, each number changed by `turn`.
fn reversed_rows<T: Copy>(numbers: &[T], width: usize, turn: impl Fn(T) -> T) -> Vec<T> {
    let rows = numbers.chunks(width.max(1)).rev();
    rows.flatten().copied().map(turn).collect()
}

/// Converts a spoke to `f64` and normalises its direction again.
fn widened(spoke: Spoke<f32>) -> Spoke<f64> {
    let [x, y] = spoke.direction.map(Scalar::to_f64);
    let length = x.hypot(y);
    Spoke {
        group: spoke.group,
        negative: spoke.negative,
        direction: [x / length, y / length],
    }
}
