//! Writes a path as a `trajectory_msgs/JointTrajectory` of ROS in YAML.
//!
//! ROS's joint trajectory controller joins points with positions and velocities by the cubic with these positions and
//! velocities at its ends, and points without velocities by straight lines. A motion of kind `hermite` or `linear` is
//! therefore followed as it was certified. Motions of other kinds are resampled so densely that the cubics stay near
//! them. The times of a message are whole nanoseconds.
//!
//! Source: the documentation of `joint_trajectory_controller`, "Trajectory Representation"; the message definitions
//! `trajectory_msgs/JointTrajectory` and `builtin_interfaces/Duration`.

use core::fmt::Write;
use std::path::Path;

use foldpath_core::{Curve, Interpolation, Node};

use super::groups::drivers;
use super::{Export, ExportOptions, Made, Sink};
use crate::motion::{Motion, interpolation_name};
use crate::read::FileError;

/// Largest distance of the cubics from a motion that has to be resampled, radians, unless that takes more than
/// [`MAX_PARTS`].
const TOLERANCE_RAD: f64 = 1e-6;
/// Largest number of cubics for one segment of the motion.
const MAX_PARTS: u32 = 1 << 10;
/// Number of places of a cubic at which its distance from the motion is measured.
const PROBES_PER_CUBIC: u32 = 16;
/// Nanoseconds of a second.
const NANOSECONDS_PER_SECOND: f64 = 1e9;

/// Rate at which a controller sets positions, hertz.
const UPDATE_RATE_HZ: u32 = 100;

/// Hinges that are joints of a robot.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[non_exhaustive]
pub enum Joints {
    /// All hinges.
    #[default]
    All,
    /// Those that drive the sheet near flat, as `foldpath info` names them. The others follow.
    Drivers,
}

/// Makes the file.
pub(super) fn made(export: &Export<'_>, sink: &mut Sink<'_>) -> Result<Made, FileError> {
    let trajectory = JointTrajectory::with(export.motion()?, export.name, export.options)?;
    let (points, joints) = (trajectory.points.len(), trajectory.joints.len());
    let error = trajectory.resampling_error;
    let way = if error > 0.0 {
        format!("resampled to {error:.1e} radians")
    } else {
        "exact".into()
    };
    sink("", trajectory.text().into_bytes())?;
    let speed = trajectory.last_speed();
    let note = (speed > REST_RAD_PER_S).then(|| {
        format!(
            "the trajectory ends at {speed:.1e} radians per second, which the controller of ROS refuses unless it is told to allow \
             it: a path with a limit of acceleration ends at rest"
        )
    });
    Ok(Made {
        told: format!("{points} points of {joints} joints, {way}"),
        notes: note.into_iter().collect(),
    })
}

/// Makes the parameters of a controller that follows the trajectory.
pub(super) fn controllers_made(
    export: &Export<'_>,
    sink: &mut Sink<'_>,
) -> Result<Made, FileError> {
    let trajectory = JointTrajectory::with(export.motion()?, export.name, export.options)?;
    sink("", trajectory.controllers().into_bytes())?;
    let joints = trajectory.joints.len();
    Ok(Made::told(format!("a controller of {joints} joints")))
}

/// A trajectory of hinges, each a joint.
#[derive(Clone, Debug, PartialEq)]
pub struct JointTrajectory {
    /// Names of the joints, in the order of the edges: `crease_I` with the number I of the edge, unless others are given.
    pub joints: Vec<String>,
    /// Points from start to end.
    pub points: Vec<Point>,
    /// Largest distance of a joint from the motion at the same time, radians, measured at 16 places of each cubic; 0 for
    /// motions that are not resampled.
    pub resampling_error: f64,
    /// Bound on what rounding the times to nanoseconds moves a joint by, radians.
    pub rounding_error: f64,
    /// Kind of the motion.
    kind: Interpolation,
    title: String,
}

/// A point of a trajectory.
#[derive(Clone, Debug, PartialEq)]
pub struct Point {
    /// Nanoseconds since the start.
    pub time: u64,
    /// Fold angle of each joint, radians, valley positive.
    pub positions: Vec<f64>,
    /// Rate of each joint, radians per second; empty if the controller is to move on straight lines.
    pub velocities: Vec<f64>,
}

/// Angle and rate of each group at a place of the motion, and the time in seconds.
struct Sample {
    time: f64,
    nodes: Vec<Node<f64>>,
}

impl JointTrajectory {
    /// Makes the trajectory of all hinges of a motion.
    ///
    /// # Errors
    /// If two knots are at the same nanosecond.
    pub fn of(motion: &Motion, file: &Path) -> Result<Self, FileError> {
        Self::with(motion, file, &ExportOptions::default())
    }

    /// Makes the trajectory of the hinges that these options name.
    ///
    /// # Errors
    /// If two knots are at the same nanosecond, there are more or fewer names than hinges, or it is not known which hinges drive
    /// the sheet.
    pub fn with(motion: &Motion, file: &Path, options: &ExportOptions) -> Result<Self, FileError> {
        let (samples, resampling_error) = samples(motion);
        let start = samples.first().map_or(0.0, |sample| sample.time);
        let creases = motion.pattern.creases();
        let mut names: Vec<String> = match &options.names {
            Some(names) => names.of_hinges(creases.len())?.map(Into::into).collect(),
            None => (creases.iter().map(|edge| format!("crease_{edge}"))).collect(),
        };
        let is_joint = match options.joints {
            Joints::All => vec![true; creases.len()],
            Joints::Drivers => {
                let drivers = drivers(&motion.pattern);
                if drivers.is_empty() {
                    let expected = "a sheet whose drivers are known";
                    return Err(FileError::expected(file, "the pattern", expected, "none"));
                }
                creases.iter().map(|edge| drivers.contains(edge)).collect()
            }
        };
        let mut chosen = is_joint.iter();
        names.retain(|_| chosen.next() == Some(&true));
        let points = samples.iter().map(|sample| {
            let of_crease = |number: fn(&Node<f64>) -> f64| -> Vec<f64> {
                let members = motion.memberships().into_iter().zip(&is_joint);
                let members = members.filter(|(_, is_joint)| **is_joint);
                let numbers = members.map(|(member, _)| {
                    member.apply(number(&sample.nodes[member.group.index()])) + 0.0
                });
                numbers.collect()
            };
            Point {
                time: nanoseconds(sample.time - start),
                positions: of_crease(|node| node.angle),
                velocities: if motion.uses_rates() {
                    of_crease(|node| node.rate)
                } else {
                    Vec::new()
                },
            }
        });
        let points: Vec<Point> = points.collect();
        if let Some(at) = points
            .windows(2)
            .position(|pair| pair[0].time >= pair[1].time)
        {
            let (place, expected) = (
                "foldpath:time",
                "knots that are at least a nanosecond apart",
            );
            let found = format!("two after {} s", samples[at].time);
            return Err(FileError::expected(file, place, expected, found));
        }
        Ok(Self {
            joints: names,
            points,
            resampling_error,
            rounding_error: fastest(motion) * 0.5 / NANOSECONDS_PER_SECOND,
            kind: motion.interpolation,
            title: motion.title.clone(),
        })
    }

    /// Returns the largest speed of a joint at the end, radians per second; 0 for a trajectory without speeds.
    fn last_speed(&self) -> f64 {
        let last = self.points.last().into_iter();
        let speeds = last.flat_map(|point| &point.velocities);
        speeds.fold(0.0, |most, speed| most.max(speed.abs()))
    }

    /// Returns the YAML of a `joint_trajectory_controller` for these joints, which sends positions.
    ///
    /// Source: the documentation of `joint_trajectory_controller`, "Details about parameters".
    #[must_use]
    pub fn controllers(&self) -> String {
        let title = self.title.escape_debug();
        let joints = self.joints.iter().map(|joint| quoted(joint));
        let joints = joints.collect::<Vec<_>>().join(", ");
        let speed = self.last_speed();
        format!(
            "# Parameters of ros2_control for {title}\n\
             controller_manager:\n  ros__parameters:\n    update_rate: {UPDATE_RATE_HZ}\n    \
             joint_trajectory_controller:\n      type: joint_trajectory_controller/JointTrajectoryController\n\n\
             joint_trajectory_controller:\n  ros__parameters:\n    joints: [{joints}]\n    \
             command_interfaces: [position]\n    state_interfaces: [position]\n    \
             # The trajectory ends at {speed:.1e} radians per second.\n    \
             allow_nonzero_velocity_at_trajectory_end: {}\n",
            speed > REST_RAD_PER_S
        )
    }

    /// Returns the YAML of the message.
    #[must_use]
    pub fn text(&self) -> String {
        let mut text = format!(
            "# trajectory_msgs/JointTrajectory of {}\n\
             # Fold angles in radians, valley positive. Kind of the motion: {}.\n\
             # Resampling moves a joint by {:.1e} radians at most (measured), times in whole nanoseconds by {:.1e}.\n\
             header:\n  stamp: {{sec: 0, nanosec: 0}}\n  frame_id: ''\njoint_names:\n",
            self.title.escape_debug(),
            interpolation_name(self.kind),
            self.resampling_error,
            self.rounding_error,
        );
        // Writing to memory cannot fail.
        for joint in &self.joints {
            let _complete = writeln!(text, "- {}", quoted(joint));
        }
        text += "points:\n";
        for point in &self.points {
            let _complete = writeln!(text, "- positions: [{}]", list(&point.positions));
            let _complete = writeln!(text, "  velocities: [{}]", list(&point.velocities));
            let second = 1_000_000_000;
            let (sec, nanosec) = (point.time / second, point.time % second);
            let _complete = writeln!(
                text,
                "  time_from_start: {{sec: {sec}, nanosec: {nanosec}}}"
            );
        }
        text
    }
}

/// Speed at the end up to which the controller of ROS takes a joint for resting: the precision of single numbers.
const REST_RAD_PER_S: f64 = f32::EPSILON as f64;

/// Returns a name as YAML has it: in quotation marks unless it is one of ours, as `on` would be no text.
fn quoted(name: &str) -> String {
    if name.starts_with("crease_") {
        name.into()
    } else {
        format!("'{name}'")
    }
}

/// Formats numbers for YAML, in which a number with an exponent but without a point would be a text.
fn list(numbers: &[f64]) -> String {
    let numbers = numbers.iter().map(|number| {
        let text = number.to_string();
        if text.contains('.') {
            text
        } else {
            text + ".0"
        }
    });
    numbers.collect::<Vec<_>>().join(", ")
}

/// Returns a time in whole nanoseconds.
#[allow(
    clippy::cast_possible_truncation,
    clippy::cast_sign_loss,
    reason = "a negative time is 0, and one beyond 500 years the largest number"
)]
fn nanoseconds(seconds: f64) -> u64 {
    (seconds * NANOSECONDS_PER_SECOND).round() as u64
}

/// Returns the largest speed of a hinge at the knots and at places between them, radians per second.
fn fastest(motion: &Motion) -> f64 {
    let mut most = 0.0_f64;
    for (segment, pair) in motion.knots.windows(2).enumerate() {
        let span = pair[1].time - pair[0].time;
        for curve in motion.curves(segment) {
            for probe in 0..=PROBES_PER_CUBIC {
                let [rate, _] = curve.derivatives(f64::from(probe) / f64::from(PROBES_PER_CUBIC));
                most = most.max((rate / span).abs());
            }
        }
    }
    most
}

/// Returns the points of the trajectory, and by how much the cubics between them are off the motion, radians.
fn samples(motion: &Motion) -> (Vec<Sample>, f64) {
    let groups = motion.groups();
    let at_knot = |knot: usize| Sample {
        time: motion.knots[knot].time,
        nodes: (0..)
            .take(groups)
            .map(|group| motion.knots[knot].node(foldpath_core::GroupId(group)))
            .collect(),
    };
    let exact = matches!(
        motion.interpolation,
        Interpolation::Hermite | Interpolation::Linear
    );
    let mut samples = Vec::new();
    let mut error = 0.0_f64;
    for segment in 0..motion.segments() {
        samples.push(at_knot(segment));
        if exact {
            continue;
        }
        let curves: Vec<Curve<f64>> = motion.curves(segment).collect();
        let [from, to] = [segment, segment + 1].map(|knot| motion.knots[knot].time);
        let mut parts = 1;
        let mut off = distance(&curves, parts);
        while off > TOLERANCE_RAD && parts < MAX_PARTS {
            parts *= 2;
            off = distance(&curves, parts);
        }
        error = error.max(off);
        for part in 1..parts {
            let s = f64::from(part) / f64::from(parts);
            samples.push(Sample {
                time: from + s * (to - from),
                nodes: curves
                    .iter()
                    .map(|curve| node(curve, s, to - from))
                    .collect(),
            });
        }
    }
    samples.extend(motion.knots.len().checked_sub(1).map(at_knot));
    (samples, error)
}

/// Returns angle and rate of a curve at `s`, 0 to 1, of a segment of `span` seconds.
fn node(curve: &Curve<f64>, s: f64, span: f64) -> Node<f64> {
    let [rate, _] = curve.derivatives(s);
    Node {
        angle: curve.angle(s),
        rate: rate / span,
        weight: [1.0, 0.0],
    }
}

/// Returns the largest distance of these curves from the cubics that replace them in so many equal parts, radians.
fn distance(curves: &[Curve<f64>], parts: u32) -> f64 {
    let mut most = 0.0_f64;
    let width = 1.0 / f64::from(parts);
    for curve in curves {
        for part in 0..parts {
            let start = f64::from(part) * width;
            let ends = [start, start + width].map(|s| node(curve, s, 1.0));
            let cubic = Curve::between(Interpolation::Hermite, width, ends[0], ends[1]);
            for probe in 1..PROBES_PER_CUBIC {
                let s = f64::from(probe) / f64::from(PROBES_PER_CUBIC);
                most = most.max((cubic.angle(s) - curve.angle(start + s * width)).abs());
            }
        }
    }
    most
}
