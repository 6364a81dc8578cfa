//! What `foldpath info` says of the future: will it fold, and what would I drive? To first order: `plan` knows.

use core::f64::consts::PI;
use std::path::Path;

use super::report::{NO, YES, styled};
use crate::pattern::{CreaseId, CreasePattern, FlatFlaw, VertexId};
use crate::planner::{FirstStep, Goal, GoalKind, first_step};
use crate::symmetry::CreaseGroups;

/// Vertices and hinges that are named.
const NAMED: usize = 5;
/// Closure residual up to which a goal closes.
const CLOSED: f64 = 1e-9;
/// Radians: hinges this near half a turn are folded flat.
const FLAT: f64 = 1e-6;

/// Two lines of the summary.
pub(super) fn text(
    pattern: &CreasePattern,
    groups: &CreaseGroups,
    closure: Option<f64>,
    file: &Path,
) -> String {
    let (fold, drive) = match Goal::of_pattern(pattern) {
        Err(_) => {
            let fold =
                "nothing says which way: no crease is lettered M or V, and no goal angle is given"
                    .into();
            (fold, "not known without a way".into())
        }
        Ok(goal) => {
            let step = first_step(pattern, groups.clone(), &goal);
            let fold = verdict(pattern, &goal, step.as_ref(), closure);
            let fold = format!("{fold}; `foldpath plan {}` tells for sure", file.display());
            (fold, drive(pattern, groups, step.as_ref()))
        }
    };
    format!("  will it fold        {fold}\n  to drive            {drive}\n")
}

/// Whether it will fold.
fn verdict(
    pattern: &CreasePattern,
    goal: &Goal,
    step: Option<&FirstStep>,
    closure: Option<f64>,
) -> String {
    let letters = goal.kind == GoalKind::Letters;
    let way = if letters { "letters" } else { "goal" };
    let Some(step) = step else {
        return "too many unknowns to tell at a glance".into();
    };
    if step.symmetric.is_none() {
        let no = styled(NO, "hardly");
        return format!("{no}: no first step was found that leaves flat along its {way}");
    }
    let leaves = format!("it leaves flat along its {way}");
    let asked = goal.fold_angles.iter().flatten();
    let flat = letters
        || asked
            .clone()
            .all(|angle| angle.abs() > PI - FLAT || angle.abs() < FLAT);
    let flaws = if flat {
        pattern.flat_flaws()
    } else {
        Vec::new()
    };
    match closure {
        _ if !flaws.is_empty() => {
            format!(
                "{}: {leaves}, but cannot fold flat: {}",
                styled(NO, "not all the way"),
                named(&flaws)
            )
        }
        Some(closure) if closure > CLOSED => {
            format!(
                "{}: {leaves}, but its goal does not close",
                styled(NO, "near its goal at best")
            )
        }
        Some(_) => format!("{}: {leaves}, and its goal closes", styled(YES, "likely")),
        None => format!("{}: {leaves}", styled(YES, "at least a little")),
    }
}

/// The first flaws, in words.
fn named(flaws: &[(VertexId, FlatFlaw)]) -> String {
    let named = flaws.iter().take(NAMED).map(|(vertex, flaw)| {
        let flaw = match flaw {
            FlatFlaw::Kawasaki(sum) if sum.is_nan() => "an odd number of creases".into(),
            FlatFlaw::Kawasaki(sum) => {
                format!(
                    "Kawasaki: every other sector adds up to {:.1} degrees, not 180",
                    sum.to_degrees()
                )
            }
            FlatFlaw::Maekawa(mountains, valleys) => {
                format!(
                    "Maekawa: {mountains} mountains and {valleys} valleys, which should differ by 2"
                )
            }
        };
        format!("vertex {} ({flaw})", vertex.index())
    });
    let more = flaws.len().saturating_sub(NAMED);
    let more = if more > 0 {
        format!(" and {more} more")
    } else {
        String::new()
    };
    named.collect::<Vec<_>>().join(", ") + &more
}

/// What to drive.
fn drive(pattern: &CreasePattern, groups: &CreaseGroups, step: Option<&FirstStep>) -> String {
    let Some(symmetric) = step.and_then(|step| step.symmetric.as_ref()) else {
        return "not known without a first step".into();
    };
    let edge = |crease: usize| pattern.creases()[crease].index();
    let first = |group: usize| {
        let mut members = groups.memberships().iter();
        edge(
            members
                .position(|member| member.group.index() == group)
                .unwrap_or(0),
        )
    };
    let leading: Vec<usize> = symmetric
        .drivers
        .iter()
        .map(|&group| first(group))
        .collect();
    let count = leading.len();
    let single = step.and_then(|step| step.single.as_ref());
    let all = pattern.creases().len();
    match single {
        Some(single) if single.drivers.len() == count => {
            format!(
                "{} decide{} all {} that turn",
                hinges(&leading),
                s(count),
                single.moving.len()
            )
        }
        Some(single) => {
            let drivers: Vec<usize> = single.drivers.iter().map(|&crease| edge(crease)).collect();
            let turning = single.moving.len();
            let kept = groups.len();
            format!(
                "{} decide all {turning} that turn; where the symmetry of its {kept} crease groups is kept, {}",
                hinges(&drivers),
                hinges(&leading)
            )
        }
        None => {
            let turns = |crease: usize| {
                let id = CreaseId(u32::try_from(crease).unwrap_or(u32::MAX));
                symmetric.moving.contains(&groups.of(id).group.index())
            };
            let turning = (0..all).filter(|&crease| turns(crease)).count();
            format!(
                "{} decide{} all {turning} that turn where the symmetry of its {} crease groups is kept; it may move \
                 in more ways without",
                hinges(&leading),
                s(count),
                groups.len()
            )
        }
    }
}

/// The ending of a verb.
fn s(count: usize) -> &'static str {
    if count == 1 { "s" } else { "" }
}

/// Hinges by their edges, in words.
fn hinges(edges: &[usize]) -> String {
    let named: Vec<String> = edges.iter().take(NAMED).map(usize::to_string).collect();
    let named = named.join(", ");
    let more = if edges.len() > NAMED { ", ..." } else { "" };
    match edges.len() {
        0 => "no hinge".into(),
        1 => format!("1 hinge, edge {named} for one,"),
        count => format!("{count} hinges, edges {named}{more} for instance,"),
    }
}
