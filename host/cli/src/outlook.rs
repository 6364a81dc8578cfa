//! Predicts for `foldpath info`, to first order, whether a pattern will fold and which hinges to drive. Only `plan`
//! tells for sure.

use core::f64::consts::PI;
use std::path::Path;

use crate::report::{NO, YES, styled};
use foldpath::pattern::{CreasePattern, FlatFlaw, VertexId};
use foldpath::planner::{CLOSED, FirstStep, Goal, GoalKind, first_step};
use foldpath::symmetry::CreaseGroups;

/// Largest number of vertices or hinges that are named.
const NAMED: usize = 5;
/// Distance from 0 and from half a turn, radians, within which a goal angle counts as flat or folded flat.
const FLAT: f64 = 1e-6;

/// Returns two lines of the summary: whether the pattern will fold, and which hinges to drive.
pub(crate) fn text(
    pattern: &CreasePattern,
    groups: &CreaseGroups,
    closure: Option<f64>,
    file: &Path,
) -> String {
    let (fold, drive) = match Goal::of_pattern(pattern) {
        Err(_) => {
            let fold =
                "nothing says which way: no crease is lettered M or V, and no goal angle is given";
            (fold.into(), "not known without a way".into())
        }
        Ok(goal) => {
            let step = first_step(pattern, groups, &goal);
            let fold = verdict(pattern, &goal, &step, closure);
            let fold = format!("{fold}; `foldpath plan {}` tells for sure", file.display());
            (fold, drive(pattern, groups, &step))
        }
    };
    format!("  will it fold        {fold}\n  to drive            {drive}\n")
}

/// Says in words whether the pattern will fold.
fn verdict(pattern: &CreasePattern, goal: &Goal, step: &FirstStep, closure: Option<f64>) -> String {
    let letters = goal.kind == GoalKind::Letters;
    let way = if letters {
        "its letters"
    } else {
        "the signs of its goal"
    };
    let leaves = format!("it leaves flat along {way}");
    match step {
        FirstStep::Unknown => return "too large to tell at a glance".into(),
        FirstStep::Stays => {
            let no = styled(NO, "hardly");
            return format!("{no}: no first step was found that leaves flat along {way}");
        }
        FirstStep::Bends => {
            let perhaps = styled(NO, "perhaps");
            return format!(
                "{perhaps}: no first step along {way} closes, but within what the bound of `plan` allows, as panels that \
                 bend do, or rounded coordinates"
            );
        }
        FirstStep::Leaves { unturned: 0, .. } => {}
        FirstStep::Leaves { unturned, .. } => {
            let (perhaps, all) = (styled(NO, "perhaps"), pattern.creases().len());
            return format!(
                "{perhaps}: {leaves}, but {unturned} of {all} hinges do not turn at first"
            );
        }
    }
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
            let part = styled(NO, "not all the way");
            format!("{part}: {leaves}, but cannot fold flat: {}", named(&flaws))
        }
        Some(closure) if closure > CLOSED => {
            let near = styled(NO, "near its goal at best");
            format!("{near}: {leaves}, but its goal does not close")
        }
        Some(_) => format!("{}: {leaves}, and its goal closes", styled(YES, "likely")),
        None => format!("{}: {leaves}", styled(YES, "at least a little")),
    }
}

/// Names the first flaws in words.
fn named(flaws: &[(VertexId, FlatFlaw)]) -> String {
    let named = flaws.iter().take(NAMED).map(|(vertex, flaw)| {
        let flaw = match flaw {
            FlatFlaw::Odd(hinges) => format!("{hinges} creases, an odd number"),
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

/// Says in words which hinges to drive.
fn drive(pattern: &CreasePattern, groups: &CreaseGroups, step: &FirstStep) -> String {
    let FirstStep::Leaves {
        symmetric: Some(symmetric),
        single,
        ..
    } = step
    else {
        return "not known without a first step".into();
    };
    let edge = |crease: usize| pattern.creases()[crease].index();
    let members = || groups.memberships().iter();
    let first = |group: usize| members().position(|member| member.group.index() == group);
    // Without symmetry the unknowns are the creases themselves.
    let alone = symmetric.unknowns != groups.len();
    let leading = symmetric
        .drivers
        .iter()
        .filter_map(|&driver| if alone { Some(driver) } else { first(driver) });
    let leading: Vec<usize> = leading.map(edge).collect();
    let count = groups.len();
    match single {
        Some(single) => {
            let drivers: Vec<usize> = single.drivers.iter().map(|&crease| edge(crease)).collect();
            let text = drives(&drivers, single.moving.len());
            if leading.len() == drivers.len() || leading.is_empty() {
                return text;
            }
            format!(
                "{text}; {} where its {count} crease groups keep together",
                hinges(&leading)
            )
        }
        None => {
            let turns = |group: usize| symmetric.moving.contains(&group);
            let moving = members()
                .filter(|member| turns(member.group.index()))
                .count();
            format!(
                "{}, as long as its {count} crease groups keep together: without, it may have more ways to move",
                drives(&leading, moving)
            )
        }
    }
}

/// Names the driving hinges, and the number of the hinges that follow: `moving` hinges turn in all.
fn drives(edges: &[usize], moving: usize) -> String {
    let follow = moving.saturating_sub(edges.len());
    match follow {
        0 => hinges(edges),
        1 => format!("{}: 1 follows", hinges(edges)),
        _ => format!("{}: {follow} follow", hinges(edges)),
    }
}

/// Names hinges by their edges, in words.
fn hinges(edges: &[usize]) -> String {
    let named: Vec<String> = edges.iter().take(NAMED).map(usize::to_string).collect();
    let named = named.join(", ");
    let more = if edges.len() > NAMED { ", ..." } else { "" };
    match edges.len() {
        0 => "no hinge".into(),
        1 => format!("1 hinge, such as edge {named}"),
        count => format!("{count} hinges, such as edges {named}{more}"),
    }
}
