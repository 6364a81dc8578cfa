//! Feeds a follower with a controller's file: does it command nothing beyond the limits?

use foldpath_core::acceptance::{Setpoint, SheetView};
use foldpath_core::follower::{CheckedOptions, Follower, FollowerPosition, State};
use foldpath_core::trajectory_file::TrajectoryFile;
use foldpath_core::{GroupLimits, Spoke, StarsView};

/// Largest number of groups (`GROUPS`), and length of the queue of setpoints (`KNOTS`).
const GROUPS: usize = 32;
const KNOTS: usize = 64;
/// `TICK`: microseconds of a tick. `TICKS`: number of ticks after which the run ends.
const TICK: u64 = 4_000;
const TICKS: u64 = 20_000;
/// Relative rounding error by which a command may exceed its limits.
const ROUNDING: f32 = 1e-5;

/// Returns `true` if the follower goes to the end of the path in these bytes, and `false` if it refuses the path. Every
/// command must be within the limits.
///
/// # Errors
/// A description of what is wrong with a command, or with the file.
pub(super) fn follow(bytes: &[u8]) -> Result<bool, String> {
    let file = TrajectoryFile::read(bytes).map_err(|error| format!("exported, but {error}"))?;
    let limits: Vec<GroupLimits> = (0..file.groups()).filter_map(|g| file.limits(g)).collect();
    let mut ends = Vec::new();
    let mut spokes: Vec<Spoke<f32>> = Vec::new();
    for (spoke, last) in file.spokes() {
        spokes.push(spoke);
        if last {
            ends.push(u32::try_from(spokes.len()).map_err(|error| error.to_string())?);
        }
    }
    let stars = StarsView::new(&spokes, &ends, file.groups()).ok_or("exported without stars")?;
    let sheet = SheetView {
        interpolation: file.interpolation(),
        limits: &limits,
        stars,
        closure: file.closure(),
    };
    if file.groups() > GROUPS || file.is_empty() {
        return Ok(false);
    }
    let mut follower = Follower::<f32, GROUPS, KNOTS>::new(CheckedOptions::default());
    if follower.load(&sheet, FollowerPosition::default()).is_err() {
        return Ok(false);
    }
    let (mut next, mut now) = (0, 0);
    for _ in 0..TICKS {
        while next < file.len() && follower.room() > 0 {
            if follower.accept(&sheet, setpoint(&file, next)?).is_err() {
                return Ok(false);
            }
            next += 1;
        }
        if follower.state() == State::Ready
            && follower.confirm().and_then(|()| follower.start()).is_err()
        {
            return Ok(false);
        }
        now += TICK;
        follower.heard(now);
        follower.tick(sheet.stars, now);
        for (group, (angle, limits)) in follower.angles().iter().zip(&limits).enumerate() {
            let margin = ROUNDING * (1.0 + angle.abs());
            if !(limits.lower - margin..=limits.upper + margin).contains(angle) {
                return Err(format!("group {group} commanded to {angle}"));
            }
        }
        for (group, (rate, limits)) in follower.rates().iter().zip(&limits).enumerate() {
            if rate.is_nan() || rate.abs() > limits.speed * (1.0 + ROUNDING) {
                return Err(format!("group {group} commanded at a rate of {rate}"));
            }
        }
        match follower.state() {
            State::Done => return Ok(true),
            State::Running => {}
            // Nothing was done to hold the motion.
            other => return Err(format!("{other:?}: {:?}", follower.reason())),
        }
    }
    // Long paths are not followed to their end.
    Ok(true)
}

fn setpoint(file: &TrajectoryFile<'_>, knot: usize) -> Result<Setpoint<f32, GROUPS>, String> {
    let nodes = (0..file.groups()).map(|group| file.node(knot, group).ok_or("no such knot"));
    Ok(Setpoint {
        number: u32::try_from(knot).map_err(|error| error.to_string())?,
        span: file.span(knot).ok_or("no such knot")?,
        last: knot + 1 == file.len(),
        nodes: nodes.collect::<Result<_, _>>()?,
    })
}
