//! Writes `.traj` files: a path in group angles, rounded to `f32`, as a controller stores and follows it.

use core::f64::consts::PI;
use std::path::Path;

use foldpath_core::trajectory::{TrajectoryError, TrajectoryView};
use foldpath_core::trajectory_file::{FileError as WriteError, LagCost, write};
use foldpath_core::{GroupLimits, Interpolation, Membership, Node, Scalar, Spoke, StarsView};

use super::groups::HingeGroups;
use super::stuck_hinge::{Drives, Slowed, StuckHinges, TooCoarse};
use super::{Export, ExportOptions, Made, Sink};
use crate::folding::hinge_gaps;
use crate::motion::Motion;
use crate::pattern::CreasePattern;
use crate::planner::Overshoot;
use crate::read::FileError;
use crate::symmetry::{CreaseGroups, ReducedStars, largest_star_residual};
use crate::util::nan_max::largest;

/// A path encoded as a `.traj` file.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct TrajFile {
    /// The bytes of the file.
    pub bytes: Vec<u8>,
    /// Number of crease groups.
    pub groups: usize,
    /// Number of hinges.
    pub hinges: usize,
    /// Number of spokes of all essential vertices.
    pub spokes: usize,
    /// Number of knots.
    pub knots: usize,
    /// Seconds from the first knot to the last.
    pub duration: f64,
    /// Distance between a hinge and its command from which on the motion has to hold, radians; infinite for that of the
    /// controller.
    pub most_lag: f64,
    /// Gap of the sheet for each radian by which a hinge alone is off, median edges, for each hinge.
    pub gaps: Vec<f64>,
    /// Largest gap that one stuck hinge costs, median edges, and the number of the hinge; `None` without hinges.
    pub stuck: Option<(usize, f64)>,
}

/// Makes the file.
pub(super) fn made(export: &Export<'_>, sink: &mut Sink<'_>) -> Result<Made, FileError> {
    let motion = export.motion()?;
    let file = TrajFile::with(motion, export.name, export.options)?;
    let room = format!(
        "a controller needs room for {} groups, {} hinges and {} spokes",
        file.groups, file.hinges, file.spokes
    );
    let told = file.told();
    let stuck = file.told_of_stuck_hinges(motion, export.options);
    sink("", file.bytes)?;
    Ok(Made {
        told,
        notes: [Some(room), stuck].into_iter().flatten().collect(),
    })
}

/// Returns the crease group and sign of each hinge of a path, in the order of the creases, which is the order of hinges
/// in a `.traj` file.
///
/// # Errors
/// If a hinge has no group.
pub fn memberships(motion: &Motion, file: &Path) -> Result<Vec<Membership>, FileError> {
    Ok(HingeGroups::of(motion, file)?.hinges)
}

/// Relative excess over its limits up to which a path is accepted. The path is then slowed down to keep the limits, as
/// it is for the excess that rounding causes.
const MAX_EXCESS_RATIO: f64 = 0.01;
/// Largest number of times that a path is slowed down; every change of speed rounds its times and rates differently.
const MAX_ROUNDS: usize = 16;
/// Largest difference (radians) between sectors of two vertices that counts as rounding of their coordinates.
const SAME_SECTOR_RAD: f64 = 1e-6;
/// Closure residual of a closed configuration in `f32`: the rounding of the stored numbers and of the controller's
/// arithmetic.
const MIN_CLOSURE_RAD: f64 = 2e-6;
/// Number of places in each segment at which the closure residual is sampled, besides its beginning.
const SAMPLES_PER_SEGMENT: u8 = 16;

impl TrajFile {
    /// Describes the file.
    pub(super) fn told(&self) -> String {
        format!(
            "{} knots of {} groups, {} hinges, {:.3} s",
            self.knots, self.groups, self.hinges, self.duration
        )
    }

    /// Describes what a stuck hinge costs, if there are hinges.
    pub(super) fn told_of_stuck_hinges(
        &self,
        motion: &Motion,
        options: &ExportOptions,
    ) -> Option<String> {
        let (hinge, gap) = self.stuck?;
        let edge = motion.pattern.creases().get(hinge)?;
        let Drives {
            resolution,
            period,
            delay,
            brake,
        } = options.drives;
        let drives = format!(
            "with drives that keep a hinge within {:.3} degrees and follow {delay} s late, a measurement every {period} s, and a brake of {brake} a second",
            resolution.to_degrees()
        );
        let slowed = if self.most_lag.is_finite() {
            format!(
                "; a lag of {:.3} degrees holds the motion",
                self.most_lag.to_degrees()
            )
        } else {
            String::new()
        };
        Some(format!(
            "a hinge that sticks tears the sheet by at most {gap:.2e} median edges before the motion rests, at edge {edge}, {drives}{slowed}"
        ))
    }

    /// Rounds the path of `file` to `f32`. The rounded path keeps the limits on speed and acceleration: its duration is
    /// stretched only as far as that requires. For a limit that the file does not state, the largest value along the
    /// path is used.
    ///
    /// # Errors
    /// If a hinge does not turn as its group does, if the path exceeds its own limits, or if controllers cannot follow
    /// a knot.
    pub fn of(motion: &Motion, file: &Path) -> Result<Self, FileError> {
        Self::with(motion, file, &ExportOptions::default())
    }

    /// Rounds the path as [`of`](Self::of) does, and slows it down as far as the bound of these options requires, on the gap
    /// that one stuck hinge may cost.
    ///
    /// # Errors
    /// As for [`of`](Self::of), and if a drive is too coarse for the bound.
    pub fn with(motion: &Motion, file: &Path, options: &ExportOptions) -> Result<Self, FileError> {
        let groups = HingeGroups::of(motion, file)?;
        let exact = TrajectoryArrays::of(motion, &groups);
        let unfit = |error: &dyn core::error::Error| {
            let expected = "knots that a controller can follow";
            FileError::expected(file, "file_frames", expected, error.to_string())
        };
        let ones = vec![1.0; exact.groups];
        let view = exact.view().map_err(|error| unfit(&error))?;
        let found = Overshoot::of(view, &ones, &ones);
        let speed = limit(motion.max_speed, found.speed);
        let acceleration = limit(motion.max_acceleration, found.acceleration);
        for (key, limit, found) in [
            ("foldpath:maxSpeed", speed, found.speed),
            ("foldpath:maxAcceleration", acceleration, found.acceleration),
        ] {
            if found > limit.to_f64() * (1.0 + MAX_EXCESS_RATIO) {
                let expected = format!("at least the path's {}", found.to_degrees());
                let found = limit.to_f64().to_degrees().to_string();
                return Err(FileError::expected(file, key, expected, found));
            }
        }
        let [speeds, accelerations] =
            [speed, acceleration].map(|limit| vec![limit.to_f64(); exact.groups]);
        let limits = GroupLimits {
            lower: f32::lit(-PI),
            upper: f32::lit(PI),
            speed,
            acceleration,
        };
        let hinges = StuckHinges {
            gaps: hinge_gaps(motion),
            hinges: &groups.hinges,
            speeds: Overshoot::speeds(view),
            drives: options.drives,
        };
        let slowed = match options.bound {
            Some(bound) => hinges
                .slowed(bound)
                .map_err(|coarse| told_as_too_coarse(coarse, motion, file, bound, options))?,
            None => Slowed::NOT,
        };
        let mut stretch = slowed.stretch;
        for _ in 0..MAX_ROUNDS {
            let rounded = exact.rounded(stretch);
            let wide = rounded.widened();
            let wide = wide.view().map_err(|error| unfit(&error))?;
            let excess = Overshoot::of(wide, &speeds, &accelerations).stretch();
            if excess <= 1.0 {
                let rounded = rounded.view().map_err(|error| unfit(&error))?;
                let file = Self {
                    most_lag: slowed.most_lag,
                    stuck: hinges.worst(&slowed),
                    gaps: hinges.gaps,
                    ..Self::default()
                };
                let file = file.encoded(rounded, wide, &motion.pattern, &groups.hinges, limits);
                return file.map_err(|error| unfit(&error));
            }
            stretch *= excess;
        }
        let expected = "knots far enough apart for numbers of 32 bits";
        let found = format!("a path {stretch} times as slow still passes its limits");
        Err(FileError::expected(file, "file_frames", expected, found))
    }

    /// Encodes a rounded path, which is widened again in `wide`.
    fn encoded(
        self,
        rounded: TrajectoryView<'_, f32>,
        wide: TrajectoryView<'_, f64>,
        pattern: &CreasePattern,
        hinges: &[Membership],
        limits: GroupLimits,
    ) -> Result<Self, WriteError> {
        let limits = vec![limits; rounded.groups()];
        let groups = CreaseGroups::of_memberships(hinges.to_vec(), SAME_SECTOR_RAD / 4.0);
        let stars = ReducedStars::all(pattern, &groups);
        let closure = closure(wide, stars.distinct().view());
        let (spokes, ends) = spokes(stars.essential().view());
        let stars = StarsView::new(&spokes, &ends, rounded.groups());
        let stars = stars.ok_or(WriteError::Spoke(0))?;
        let mut bytes = Vec::new();
        let sink = |part: &[u8]| bytes.extend_from_slice(part);
        let gaps: Vec<f32> = self.gaps.iter().copied().map(f32::lit).collect();
        let cost = LagCost {
            // Rounded down, so that the bound is kept.
            most_lag: f32::lit(self.most_lag).next_down(),
            gaps: &gaps,
        };
        write(rounded, &limits, hinges, stars, closure, cost, sink)?;
        Ok(Self {
            bytes,
            groups: rounded.groups(),
            hinges: hinges.len(),
            spokes: spokes.len(),
            knots: rounded.len(),
            duration: (0..wide.len())
                .filter_map(|knot| Some(wide.knot(knot)?.span))
                .sum(),
            ..self
        })
    }
}

/// Returns the error of a drive that is too coarse for a bound.
fn told_as_too_coarse(
    coarse: TooCoarse,
    motion: &Motion,
    file: &Path,
    bound: f64,
    options: &ExportOptions,
) -> FileError {
    let TooCoarse {
        hinge,
        resolution,
        gap,
    } = coarse;
    let edge = motion.pattern.creases().get(hinge);
    let edge = edge.map_or_else(String::new, |edge| format!("edge {edge}"));
    let expected = format!(
        "a drive that keeps this hinge within less than {:.4} degrees, for a gap of at most {bound} median edges if it sticks",
        resolution.to_degrees()
    );
    let found = format!(
        "{:.4} degrees, which cost a gap of more than {gap:.2e} at any speed; a finer drive or a bound above that would do",
        options.drives.resolution.to_degrees()
    );
    FileError::expected(file, edge, expected, found)
}

/// Rounds a limit to `f32`. A limit stated by the file (`known`) is rounded down, so that keeping the rounded limit
/// keeps the stated one; a measured limit is rounded up.
fn limit(known: Option<f64>, found: f64) -> f32 {
    let exact = known.unwrap_or(if found > 0.0 { found } else { f64::INFINITY });
    let nearest = f32::lit(exact);
    match known {
        Some(_) if nearest.to_f64() > exact => nearest.next_down(),
        None if nearest.to_f64() < exact => nearest.next_up(),
        _ => nearest,
    }
}

/// The numbers of a trajectory, in the arrays over which core's view of it lies.
#[derive(Clone, Debug)]
pub(crate) struct TrajectoryArrays<T> {
    pub(crate) interpolation: Interpolation,
    pub(crate) groups: usize,
    /// Seconds since the knot before, 0 at the first.
    pub(crate) spans: Vec<T>,
    /// One row for each knot, radians.
    pub(crate) angles: Vec<T>,
    /// One row for each knot, radians per second.
    pub(crate) rates: Vec<T>,
    /// One row for each knot; empty unless the interpolation is homogeneous.
    pub(crate) weights: Vec<[T; 2]>,
}

impl<T: Scalar> TrajectoryArrays<T> {
    /// Makes the arrays of these nodes, which come row after row.
    pub(crate) fn new(
        interpolation: Interpolation,
        groups: usize,
        spans: Vec<T>,
        nodes: &[Node<T>],
    ) -> Self {
        let is_weighted = interpolation == Interpolation::Homogeneous;
        let weighted = nodes.iter().filter(|_| is_weighted);
        Self {
            interpolation,
            groups,
            spans,
            angles: nodes.iter().map(|node| node.angle).collect(),
            rates: nodes.iter().map(|node| node.rate).collect(),
            weights: weighted.map(|node| node.weight).collect(),
        }
    }

    /// Returns the trajectory as core takes it.
    ///
    /// # Errors
    /// If a controller cannot follow a knot.
    pub(crate) fn view(&self) -> Result<TrajectoryView<'_, T>, TrajectoryError> {
        TrajectoryView::new(
            self.interpolation,
            self.groups,
            &self.spans,
            &self.angles,
            &self.rates,
            &self.weights,
        )
    }
}

impl TrajectoryArrays<f64> {
    fn of(motion: &Motion, groups: &HingeGroups) -> Self {
        let knots = 0..motion.knots.len();
        let nodes: Vec<_> = knots.flat_map(|knot| groups.nodes(motion, knot)).collect();
        let spans = motion
            .knots
            .windows(2)
            .map(|ends| ends[1].time - ends[0].time);
        let spans = core::iter::once(0.0)
            .chain(spans)
            .take(motion.knots.len())
            .collect();
        Self::new(motion.interpolation, groups.len(), spans, &nodes)
    }

    /// Returns the trajectory stretched in time by the factor `stretch` and rounded to `f32`.
    fn rounded(&self, stretch: f64) -> TrajectoryArrays<f32> {
        let slower = 1.0 / stretch;
        let weights = self.weights.iter();
        TrajectoryArrays {
            interpolation: self.interpolation,
            groups: self.groups,
            spans: self
                .spans
                .iter()
                .map(|span| f32::lit(span * stretch))
                .collect(),
            angles: self.angles.iter().copied().map(f32::lit).collect(),
            rates: self.rates.iter().map(|x| f32::lit(x * slower)).collect(),
            weights: weights
                .map(|[weight, rate]| [f32::lit(*weight), f32::lit(rate / stretch)])
                .collect(),
        }
    }
}

impl TrajectoryArrays<f32> {
    fn widened(&self) -> TrajectoryArrays<f64> {
        let widen = |numbers: &[f32]| numbers.iter().map(|x| x.to_f64()).collect();
        let weights = self.weights.iter();
        TrajectoryArrays {
            interpolation: self.interpolation,
            groups: self.groups,
            spans: widen(&self.spans),
            angles: widen(&self.angles),
            rates: widen(&self.rates),
            weights: weights.map(|pair| pair.map(Scalar::to_f64)).collect(),
        }
    }
}

/// Returns the largest sampled closure residual of a rounded path, widened again, plus the residual that rounding adds.
fn closure(wide: TrajectoryView<'_, f64>, stars: StarsView<'_, f64>) -> f32 {
    let segments = 0..wide.len().saturating_sub(1);
    let places =
        segments.flat_map(|segment| (0..=SAMPLES_PER_SEGMENT).map(move |sample| (segment, sample)));
    let residuals = places.map(|(segment, sample)| {
        let s = f64::from(sample) / f64::from(SAMPLES_PER_SEGMENT);
        let curves = (0..wide.groups()).filter_map(|group| wide.curve(segment, group));
        let angles: Vec<f64> = curves.map(|curve| curve.angle(s)).collect();
        largest_star_residual(stars, &angles)
    });
    f32::lit(largest(residuals) + MIN_CLOSURE_RAD)
}

/// Rounds the spokes of all stars to `f32`. Returns the spokes and, for each star, the index behind its last spoke.
fn spokes(stars: StarsView<'_, f64>) -> (Vec<Spoke<f32>>, Vec<u32>) {
    let rounded = |spoke: &Spoke<f64>| Spoke {
        group: spoke.group,
        negative: spoke.negative,
        direction: spoke.direction.map(f32::lit),
    };
    let spokes = stars.iter().flat_map(|star| star.spokes).map(rounded);
    let ends = stars.iter().scan(0, |end, star| {
        *end += u32::try_from(star.spokes.len()).unwrap_or(u32::MAX);
        Some(*end)
    });
    (spokes.collect(), ends.collect())
}
