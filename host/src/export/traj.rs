//! Writes `.traj` files: a path in group angles, rounded to `f32`, as a controller stores and follows it.

use core::f64::consts::PI;
use std::path::Path;

use foldpath_core::trajectory::TrajectoryView;
use foldpath_core::trajectory_file::{FileError as WriteError, write};
use foldpath_core::{GroupLimits, Interpolation, Membership, Scalar, Spoke, StarsView};

use super::groups::HingeGroups;
use super::{Export, Made, Sink};
use crate::motion::Motion;
use crate::pattern::CreasePattern;
use crate::planner::Overshoot;
use crate::read::FileError;
use crate::symmetry::{CreaseGroups, ReducedStars, largest_star_residual};
use crate::util::nan_max::largest;

/// A path encoded as a `.traj` file.
#[derive(Clone, Debug, PartialEq)]
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
}

/// Makes the file.
pub(super) fn made(export: &Export<'_>, sink: &mut Sink<'_>) -> Result<Made, FileError> {
    let file = TrajFile::of(export.motion()?, export.name)?;
    let room = format!(
        "a controller needs room for {} groups, {} hinges and {} spokes",
        file.groups, file.hinges, file.spokes
    );
    let told = file.told();
    sink("", file.bytes)?;
    Ok(Made {
        told,
        notes: vec![room],
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

    /// Rounds the path of `file` to `f32`. The rounded path keeps the limits on speed and acceleration: its duration is
    /// stretched only as far as that requires. For a limit that the file does not state, the largest value along the
    /// path is used.
    ///
    /// # Errors
    /// If a hinge does not turn as its group does, if the path exceeds its own limits, or if controllers cannot follow
    /// a knot.
    pub fn of(motion: &Motion, file: &Path) -> Result<Self, FileError> {
        let groups = HingeGroups::of(motion, file)?;
        let exact = Arrays::of(motion, &groups);
        let ones = vec![1.0; exact.groups];
        let found = Overshoot::of(exact.view(file)?, &ones, &ones);
        let speed = limit(motion.max_speed, found.speed);
        let acceleration = limit(motion.max_acceleration, found.acceleration);
        for (key, limit, found) in [
            ("foldpath:maxSpeed", speed, found.speed),
            ("foldpath:maxAcceleration", acceleration, found.acceleration),
        ] {
            if found > limit.to_f64() * (1.0 + MAX_EXCESS_RATIO) {
                return Err(FileError::Expected {
                    path: file.to_path_buf(),
                    place: key.into(),
                    expected: format!("at least the path's {}", found.to_degrees()),
                    found: limit.to_f64().to_degrees().to_string(),
                });
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
        let mut stretch = 1.0;
        for _ in 0..MAX_ROUNDS {
            let rounded = Rounded::of(&exact, stretch);
            let view = rounded.wide.view(file)?;
            let excess = Overshoot::of(view, &speeds, &accelerations).stretch();
            if excess <= 1.0 {
                return rounded.write(&motion.pattern, groups.hinges, limits, file);
            }
            stretch *= excess;
        }
        Err(FileError::Expected {
            path: file.to_path_buf(),
            place: "file_frames".into(),
            expected: "knots far enough apart for numbers of 32 bits".into(),
            found: format!("a path {stretch} times as slow still passes its limits"),
        })
    }
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

/// The numbers of a motion, in the arrays that core's view of a trajectory takes.
struct Arrays {
    interpolation: Interpolation,
    groups: usize,
    /// Seconds.
    times: Vec<f64>,
    /// One row for each knot, radians.
    angles: Vec<f64>,
    /// One row for each knot, radians per second.
    rates: Vec<f64>,
    /// One row for each knot; empty unless the interpolation is homogeneous.
    weights: Vec<[f64; 2]>,
}

impl Arrays {
    fn of(motion: &Motion, groups: &HingeGroups) -> Self {
        let nodes = || (0..motion.knots.len()).flat_map(|knot| groups.nodes(motion, knot));
        let weighted = motion.interpolation == Interpolation::Homogeneous;
        Self {
            interpolation: motion.interpolation,
            groups: groups.len(),
            times: motion.knots.iter().map(|knot| knot.time).collect(),
            angles: nodes().map(|node| node.angle).collect(),
            rates: nodes().map(|node| node.rate).collect(),
            weights: nodes()
                .filter(|_| weighted)
                .map(|node| node.weight)
                .collect(),
        }
    }

    /// Returns the motion as a trajectory of core.
    ///
    /// # Errors
    /// If a controller cannot follow a knot; the error names the place.
    fn view(&self, file: &Path) -> Result<TrajectoryView<'_, f64>, FileError> {
        let view = TrajectoryView::new(
            self.interpolation,
            self.groups,
            &self.times,
            &self.angles,
            &self.rates,
            &self.weights,
        );
        view.map_err(|error| unfit(file, &error))
    }
}

/// Makes the error of a trajectory that a controller cannot follow.
fn unfit(file: &Path, error: &dyn core::error::Error) -> FileError {
    let expected = "knots that a controller can follow";
    FileError::expected(file, "file_frames", expected, error.to_string())
}

/// A path rounded to `f32`, and the rounded numbers widened to `f64`.
struct Rounded {
    times: Vec<f32>,
    angles: Vec<f32>,
    rates: Vec<f32>,
    weights: Vec<[f32; 2]>,
    wide: Arrays,
}

impl Rounded {
    /// Rounds a path that is stretched in time by the factor `stretch`.
    fn of(exact: &Arrays, stretch: f64) -> Self {
        let start = exact.times.first().copied().unwrap_or(0.0);
        let round = |numbers: &[f64], factor: f64| -> Vec<f32> {
            numbers.iter().map(|x| f32::lit(x * factor)).collect()
        };
        let times: Vec<f64> = exact.times.iter().map(|time| time - start).collect();
        let times = round(&times, stretch);
        let angles = round(&exact.angles, 1.0);
        let rates = round(&exact.rates, 1.0 / stretch);
        let weights = exact.weights.iter();
        let weights: Vec<[f32; 2]> = weights
            .map(|[weight, rate]| [f32::lit(*weight), f32::lit(rate / stretch)])
            .collect();
        let widen = |numbers: &[f32]| numbers.iter().map(|x| x.to_f64()).collect();
        let wide = Arrays {
            interpolation: exact.interpolation,
            groups: exact.groups,
            times: widen(&times),
            angles: widen(&angles),
            rates: widen(&rates),
            weights: weights.iter().map(|w| w.map(Scalar::to_f64)).collect(),
        };
        Self {
            times,
            angles,
            rates,
            weights,
            wide,
        }
    }

    /// Returns the largest sampled closure residual of the rounded path, plus the residual that rounding adds.
    fn closure(&self, stars: StarsView<'_, f64>, file: &Path) -> Result<f32, FileError> {
        let view = self.wide.view(file)?;
        let segments = 0..self.times.len().saturating_sub(1);
        let places = segments
            .flat_map(|segment| (0..=SAMPLES_PER_SEGMENT).map(move |sample| (segment, sample)));
        let residuals = places.map(|(segment, sample)| {
            let s = f64::from(sample) / f64::from(SAMPLES_PER_SEGMENT);
            let curves = (0..self.wide.groups).filter_map(|group| view.curve(segment, group));
            let angles: Vec<f64> = curves.map(|curve| curve.angle(s)).collect();
            largest_star_residual(stars, &angles)
        });
        Ok(f32::lit(largest(residuals) + MIN_CLOSURE_RAD))
    }

    fn write(
        &self,
        pattern: &CreasePattern,
        hinges: Vec<Membership>,
        limits: GroupLimits,
        file: &Path,
    ) -> Result<TrajFile, FileError> {
        let view = TrajectoryView::new(
            self.wide.interpolation,
            self.wide.groups,
            &self.times,
            &self.angles,
            &self.rates,
            &self.weights,
        );
        let view = view.map_err(|error| unfit(file, &error))?;
        let limits = vec![limits; self.wide.groups];
        let groups = CreaseGroups::of_memberships(hinges.clone(), SAME_SECTOR_RAD / 4.0);
        let stars = ReducedStars::all(pattern, &groups);
        let closure = self.closure(stars.distinct().view(), file)?;
        let (spokes, ends) = spokes(stars.essential().view());
        let stars = StarsView::new(&spokes, &ends, self.wide.groups);
        let stars = stars.ok_or_else(|| unfit(file, &WriteError::Spoke(0)))?;
        let mut bytes = Vec::new();
        let sink = |part: &[u8]| bytes.extend_from_slice(part);
        write(view, &limits, &hinges, stars, closure, sink).map_err(|error| unfit(file, &error))?;
        Ok(TrajFile {
            bytes,
            groups: self.wide.groups,
            hinges: hinges.len(),
            spokes: spokes.len(),
            knots: self.times.len(),
            duration: self.wide.times.last().copied().unwrap_or(0.0),
        })
    }
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
