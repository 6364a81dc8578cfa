//! Predicts for `foldpath info`, to first order, whether a pattern will fold and which hinges to drive. Only `plan`
//! tells for sure.

use std::path::Path;

use crate::report::{NO, YES, styled};
use foldpath::pattern::CreasePattern;
use foldpath::planner::{CauseKind, FirstStep, Foldability, Forecast, Goal, GoalKind};
use foldpath::symmetry::CreaseGroups;

/// Largest number of causes or hinges that are named.
const MAX_NAMED: usize = 5;

/// Returns lines of the summary: whether the pattern will fold, what is in the way, and which hinges to drive.
pub(crate) fn text(
    pattern: &CreasePattern,
    groups: &CreaseGroups,
    forecast: &Forecast,
    file: &Path,
) -> String {
    let (fold, drive) = match Goal::of_pattern(pattern) {
        Err(_) => {
            let fold =
                "nothing says which way: no crease is lettered M or V, and no goal angle is given";
            (fold.into(), "not known without a way".into())
        }
        Ok(goal) => {
            let fold = verdict(pattern, &goal, forecast);
            let fold = format!("{fold}; `foldpath plan {}` tells for sure", file.display());
            (fold, drive(pattern, groups, &forecast.step))
        }
    };
    let (causes, locked) = (in_the_way(forecast), locked(pattern, forecast));
    format!("  will it fold        {fold}\n{causes}{locked}  to drive            {drive}\n")
}

/// Says in words whether the pattern will fold, beginning with the verdict.
fn verdict(pattern: &CreasePattern, goal: &Goal, forecast: &Forecast) -> String {
    let way = if goal.kind == GoalKind::Letters {
        "its letters"
    } else {
        "the signs of its goal"
    };
    let leaves = format!("it leaves flat along {way}");
    let name = forecast.foldability.name();
    match forecast.foldability {
        Foldability::Unknown => return format!("{name}: too large to tell at a glance"),
        Foldability::No => {
            let no = styled(NO, name);
            return format!("{no}: it is proved that no motion leaves flat along its letters");
        }
        Foldability::Likely => {
            return format!("{}: {leaves}, and its goal closes", styled(YES, name));
        }
        Foldability::Perhaps => {}
    }
    let perhaps = styled(NO, name);
    let unfoldable = |kind| matches!(kind, CauseKind::NotFlatFoldable(_));
    match forecast.step {
        FirstStep::Unknown => format!("{perhaps}: the sheet is too large for a first step"),
        FirstStep::Stays => {
            format!("{perhaps}: no first step was found that leaves flat along {way}")
        }
        FirstStep::Bends => format!(
            "{perhaps}: no first step along {way} closes, but within what the bound of `plan` allows, as panels that \
             bend do, or rounded coordinates"
        ),
        FirstStep::Leaves { unturned, .. } if unturned > 0 => {
            let all = pattern.creases().len();
            format!("{perhaps}: {leaves}, but {unturned} of {all} hinges do not turn at first")
        }
        _ if forecast.causes.iter().any(|cause| unfoldable(cause.kind)) => {
            format!("{perhaps}, but not all the way: {leaves}, but cannot fold flat")
        }
        _ => match forecast.goal_residual {
            Some(_) if forecast.causes.is_empty() => {
                format!("{perhaps}, near its goal at best: {leaves}, but its goal does not close")
            }
            _ => format!("{perhaps}, at least a little: {leaves}"),
        },
    }
}

/// Returns a line for each of the first causes.
fn in_the_way(forecast: &Forecast) -> String {
    let named = forecast
        .causes
        .iter()
        .take(MAX_NAMED)
        .map(ToString::to_string);
    let more = forecast.causes.len().saturating_sub(MAX_NAMED);
    let more = (more > 0).then(|| format!("and {more} more, which --json lists"));
    let lines = named.chain(more).enumerate().map(|(line, cause)| {
        let head = if line == 0 { "in the way" } else { "" };
        format!("  {head:<20}{cause}\n")
    });
    lines.collect()
}

/// Returns a line on the creases that cannot turn, if there are any.
fn locked(pattern: &CreasePattern, forecast: &Forecast) -> String {
    if forecast.locked.is_empty() {
        return String::new();
    }
    let named = forecast.locked.iter().take(MAX_NAMED);
    let named: Vec<String> = named.map(|edge| edge.index().to_string()).collect();
    let (count, all) = (forecast.locked.len(), pattern.creases().len());
    let (edges, more) = (
        if count == 1 { "edge" } else { "edges" },
        if count > MAX_NAMED { ", ..." } else { "" },
    );
    let named = named.join(", ");
    format!(
        "  locked              {count} of {all} hinges cannot turn in a first step: {edges} {named}{more}\n"
    )
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
    let named: Vec<String> = edges.iter().take(MAX_NAMED).map(usize::to_string).collect();
    let named = named.join(", ");
    let more = if edges.len() > MAX_NAMED { ", ..." } else { "" };
    match edges.len() {
        0 => "no hinge".into(),
        1 => format!("1 hinge, such as edge {named}"),
        count => format!("{count} hinges, such as edges {named}{more}"),
    }
}
