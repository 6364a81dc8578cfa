//! A request for a pattern that was read: goal and limits that it names, and what became of it.

use core::time::Duration;
use std::path::{Path, PathBuf};

use super::error::RequestError;
use super::hints::nearest_hinge;
use super::options::PlanRequest;
use super::order::Order;
use super::table::Request as _;
use super::values::{EdgeAngles, Frames};
use crate::motion::{MAX_PLATE_ANGLE_DEG, PlateSides};
use crate::pattern::{CreaseId, CreasePattern};
use crate::planner::{
    Foldability, Goal, GoalError, HingeLimit, Outcome, Plan, PlanOptions, Search, forecast,
    plan_watched,
};
use crate::progress::{Progress, Watch};
use crate::read::fold::{GoalFrames, PatternFile};
use crate::symmetry::CreaseGroups;
use crate::util::clock::Instant;

/// Largest number of causes that a plan's notes name; [`PatternInfo`](super::PatternInfo) names them all.
const MAX_CAUSES: usize = 5;

/// The name of a file in messages, and angles (radians) of the creases of a pattern that were read from frames of it.
pub type NamedGoals = (String, Vec<Vec<Option<f64>>>);

/// Goal and options of a plan for one pattern.
pub struct PlanTask {
    /// The goal.
    pub goal: Goal,
    /// Options of the planner.
    pub options: PlanOptions,
    /// Notes on limits that hold their crease flat.
    held_flat: Vec<String>,
    /// `true` if the goal is the pattern's own, or that of its letters.
    is_own_goal: bool,
    /// Description of the last step, if the hinges fold in steps.
    last_step: Option<String>,
}

impl PlanRequest {
    /// Returns goal and options for the pattern of the file `name`. The knots keep the positions of the vertices if
    /// `stores_vertices` is `true` and [`frames`](Self::frames) asks for them. `read_goal` reads the fold angles (radians) of
    /// those frames of a file that are asked for, and says how messages name that file.
    ///
    /// # Errors
    /// If an option is out of its range, the pattern has no such goal, or a goal cannot be read.
    pub fn task<E: From<RequestError>>(
        &self,
        name: &Path,
        file: &PatternFile,
        stores_vertices: bool,
        read_goal: impl Fn(&Path, &CreasePattern, GoalFrames) -> Result<NamedGoals, E>,
    ) -> Result<PlanTask, E> {
        let mut options = self.options()?;
        let (goal, last_step) = self.goal_of(name, &file.pattern, read_goal)?;
        options.keep_vertices = stores_vertices && self.frames == Frames::Full;
        options.limits = self.limits_of(&file.pattern)?;
        self.check_plates(&file.pattern, &goal)?;
        options.validate().map_err(RequestError::from)?;
        Ok(PlanTask {
            held_flat: self.held_flat(&file.pattern, &goal),
            is_own_goal: self.goal.is_none() && self.crease.is_empty(),
            last_step,
            goal,
            options,
        })
    }

    /// Returns the files with goals that the request names.
    pub fn goal_files(&self) -> impl Iterator<Item = &PathBuf> {
        let of_order = self.order.iter().filter_map(Order::file);
        self.goal.iter().chain(&self.via).chain(of_order)
    }

    /// Returns the goal, and the description of the last step if hinges fold in steps. `name` is the name of the pattern's
    /// file, and `read_goal` reads a file that the request names.
    fn goal_of<E: From<RequestError>>(
        &self,
        name: &Path,
        pattern: &CreasePattern,
        read_goal: impl Fn(&Path, &CreasePattern, GoalFrames) -> Result<NamedGoals, E>,
    ) -> Result<(Goal, Option<String>), E> {
        let bad = |source: GoalError| match source {
            GoalError::Crease { .. } | GoalError::CreaseTwice { .. } => {
                RequestError::option("crease", source.to_string())
            }
            GoalError::Fraction(_) => RequestError::option("fold", source.to_string()),
            _ => RequestError::Goal {
                file: name.display().to_string(),
                lost: (pattern.lost_lines().copied()).filter(|_| source == GoalError::NoDirection),
                source,
            },
        };
        let chosen = |path: &Path| -> Result<Goal, E> {
            let (name, mut goals) = read_goal(path, pattern, GoalFrames::Last)?;
            let angles = goals
                .pop()
                .unwrap_or_else(|| vec![None; pattern.creases().len()]);
            let source = format!("the goal angles of {name}");
            Ok(Goal::chosen(pattern, angles, source))
        };
        let option = if self.order.is_some() { "order" } else { "via" };
        let has_phases = self.order.is_some() || !self.via.is_empty();
        if has_phases && self.search == Search::Random {
            let problem = "expected search auto or path, as the randomised search knows no phases";
            return Err(RequestError::option(option, problem).into());
        }
        let mut goal = match (&self.goal, self.fold, &self.crease[..]) {
            (Some(path), ..) => chosen(path)?,
            // The path begins at the flat sheet, and with `via` it goes back to it.
            (None, Some(fraction), _) if fraction <= 0.0 => {
                let angles = vec![Some(0.0); pattern.creases().len()];
                Goal::chosen(pattern, angles, "the flat sheet".into())
            }
            (None, Some(fraction), _) => Goal::of_letters(pattern, fraction).map_err(bad)?,
            (None, None, []) => Goal::of_pattern(pattern).map_err(bad)?,
            (None, None, driven) => {
                let driven = driven.iter().map(
                    |&EdgeAngles {
                         edge,
                         degrees: [degrees],
                     }| {
                        Ok((crease(pattern, "crease", edge)?, degrees.to_radians()))
                    },
                );
                let driven: Vec<_> = driven.collect::<Result<_, RequestError>>()?;
                Goal::of_creases(pattern, &driven).map_err(bad)?
            }
        };
        let via = self.via.iter().map(|path| chosen(path));
        goal.via = via.collect::<Result<_, _>>()?;
        let mut last_step = None;
        if let Some(order) = &self.order {
            let keyframes = |path: &Path| read_goal(path, pattern, GoalFrames::Each);
            let (stops, last) = order.stops(pattern, &goal, keyframes)?;
            (goal.via, last_step) = (stops, Some(last));
        }
        Ok((goal, last_step))
    }

    /// Checks that plates can be made as they are asked for.
    fn check_plates(&self, pattern: &CreasePattern, goal: &Goal) -> Result<(), RequestError> {
        if self.thickness.is_none() {
            return Ok(());
        }
        if self.gap > 0.0 && self.panels == PlateSides::Taper {
            let problem = "expected with --panels inset, as tapered plates meet at their hinges";
            return Err(RequestError::option("gap", problem));
        }
        let angles = pattern.creases().iter().zip(&goal.fold_angles);
        let mut far = angles.filter_map(|(edge, angle)| Some((edge, angle.map(f64::to_degrees)?)));
        match far.find(|(_, degrees)| degrees.abs() > MAX_PLATE_ANGLE_DEG) {
            None => Ok(()),
            Some((edge, degrees)) => {
                let problem = format!(
                    "expected hinges that turn by at most {MAX_PLATE_ANGLE_DEG} degrees, but the goal of edge {edge} is \
                     {degrees:.6}: tapers would have no end; two creases that are farther apart than the plates are thick \
                     lay one plate on another"
                );
                Err(RequestError::option("thickness", problem))
            }
        }
    }

    /// Returns the limits of the hinges.
    fn limits_of(&self, pattern: &CreasePattern) -> Result<Vec<HingeLimit>, RequestError> {
        let limit = |limit: &EdgeAngles<2>| {
            let [lower, upper] = limit.degrees.map(f64::to_radians);
            let crease = crease(pattern, "limit", limit.edge)?;
            Ok(HingeLimit {
                crease,
                lower,
                upper,
            })
        };
        self.limit.iter().map(limit).collect()
    }

    /// Returns a note for each limit that leaves its crease no room at all in the direction in which the crease is to
    /// turn. No outcome says so.
    fn held_flat(&self, pattern: &CreasePattern, goal: &Goal) -> Vec<String> {
        let note = |&EdgeAngles {
                        edge: index,
                        degrees: [lower, upper],
                    }: &EdgeAngles<2>| {
            let edge = pattern.edges().get(index)?;
            let asked = goal.fold_angles[edge.crease?.index()];
            let (way, what) = match (edge.letter.sign(), asked) {
                (_, Some(asked)) if asked.abs() <= 0.0 => return None,
                (sign, _) if sign.abs() > 0.0 => (sign, format!("lettered {}", edge.letter.code())),
                (_, asked) => {
                    let degrees = asked?.to_degrees();
                    (degrees, format!("whose goal is {degrees:.6} degrees"))
                }
            };
            let (room, side) = if way < 0.0 {
                (lower < 0.0, "below")
            } else {
                (upper > 0.0, "above")
            };
            (!room).then(|| {
                format!(
                    "edge {index}, {what}, turns to angles {side} 0, of which its limit of {lower}..{upper} degrees \
                     leaves none: it stays flat"
                )
            })
        };
        self.limit.iter().filter_map(note).collect()
    }
}

/// Returns the crease of an edge that an option names.
pub(super) fn crease(
    pattern: &CreasePattern,
    option: &str,
    edge: usize,
) -> Result<CreaseId, RequestError> {
    let found = pattern.edges().get(edge);
    found.and_then(|edge| edge.crease).ok_or_else(|| {
        let found = match found {
            Some(edge) => format!("it is lettered {}", edge.letter.code()),
            None => format!("edges go from 0 to {}", pattern.edges().len() - 1),
        };
        RequestError::Option {
            option: option.into(),
            problem: format!("edge {edge}: expected a hinge between two faces, but {found}"),
            hint: nearest_hinge(pattern, edge),
        }
    })
}

impl PlanTask {
    /// Plans, in the time that is left after `spent`. The motion gets the title of the file.
    #[must_use]
    pub fn run(mut self, file: &PatternFile, spent: Duration, progress: &Progress) -> Planned {
        let timeout = self.options.timeout.map(|time| time.saturating_sub(spent));
        self.options.timeout = timeout;
        let deadline = timeout.and_then(|time| Instant::now().checked_add(time));
        let mut plan = plan_watched(&file.pattern, &self.goal, &self.options, progress);
        if let Some(motion) = &mut plan.motion {
            motion.title.clone_from(&file.title);
        }
        let mut remarks = self.held_flat;
        let is_yes = matches!(plan.outcome, Outcome::Planned | Outcome::Undecided);
        if let (Some(last), Some(motion), false) = (&self.last_step, &plan.motion, is_yes) {
            let step = self.goal.via.get(motion.phases.len());
            let step = step.map_or(last, |stop| &stop.source);
            remarks.push(format!("the path ends in {step}"));
        }
        if self.is_own_goal {
            let (start, watch) = (Instant::now(), Watch::new(progress).until(deadline));
            remarks.extend(in_the_way(&file.pattern, plan.outcome, watch));
            plan.effort.times.solve += start.elapsed();
        }
        Planned {
            goal: self.goal,
            plan,
            remarks,
        }
    }
}

/// The answer to a request.
pub struct Planned {
    /// The goal.
    pub goal: Goal,
    /// The plan.
    pub plan: Plan,
    /// A note for each limit that holds its crease flat and, if the answer is no, for each cause.
    pub(super) remarks: Vec<String>,
}

impl Planned {
    /// Returns `true` if a strategy was ended by the timeout.
    #[must_use]
    pub fn ran_out_of_time(&self) -> bool {
        let attempts = self.plan.attempts.iter().map(|attempt| attempt.outcome);
        attempts
            .chain([self.plan.outcome])
            .any(|outcome| outcome == Outcome::Timeout)
    }
}

/// Returns what the flat sheet alone tells of the reasons for a no, in notes.
fn in_the_way(pattern: &CreasePattern, outcome: Outcome, watch: Watch<'_>) -> Vec<String> {
    if !Outcome::FALLS_SHORT.contains(&outcome) {
        return Vec::new();
    }
    let groups = CreaseGroups::find_until(pattern, watch);
    let forecast = forecast(pattern, &groups, watch);
    let proof = (forecast.foldability == Foldability::No)
        .then(|| "it is proved that no motion leaves flat along the letters".to_string());
    let causes = forecast.causes.iter().take(MAX_CAUSES);
    let causes = causes.map(|cause| format!("in the way: {cause}"));
    proof.into_iter().chain(causes).collect()
}
