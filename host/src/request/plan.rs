//! A request for a pattern that was read, and what became of it.

use core::time::Duration;
use std::path::Path;

use super::error::RequestError;
use super::goal::NamedGoal;
use super::names::Frames;
use super::options::PlanRequest;
use super::table::Request as _;
use crate::pattern::CreasePattern;
use crate::planner::{Foldability, Goal, Outcome, Plan, PlanOptions, forecast, plan_watched};
use crate::progress::{Progress, Watch};
use crate::read::fold::PatternFile;
use crate::symmetry::CreaseGroups;
use crate::util::clock::Instant;

/// Largest number of causes that a plan's notes name; [`PatternInfo`](super::PatternInfo) names them all.
const MAX_CAUSES: usize = 5;

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
}

impl PlanRequest {
    /// Returns goal and options for the pattern of the file `name`. The knots keep the positions of the vertices if
    /// `stores_vertices` is `true` and [`frames`](Self::frames) asks for them. `read_goal` reads the fold angles (radians) of
    /// a file that the request names, and says how messages name that file.
    ///
    /// # Errors
    /// If an option is out of its range, the pattern has no such goal, or a goal cannot be read.
    pub fn task<E: From<RequestError>>(
        &self,
        name: &Path,
        file: &PatternFile,
        stores_vertices: bool,
        read_goal: impl Fn(&Path, &CreasePattern) -> Result<NamedGoal, E>,
    ) -> Result<PlanTask, E> {
        let mut options = self.options()?;
        let goal = self.goal_of(name, &file.pattern, read_goal)?;
        options.keep_vertices = stores_vertices && self.frames == Frames::Full;
        options.limits = self.limits_of(&file.pattern)?;
        options.validate().map_err(RequestError::from)?;
        Ok(PlanTask {
            held_flat: self.held_flat(&file.pattern, &goal),
            is_own_goal: self.goal.is_none() && self.crease.is_empty(),
            goal,
            options,
        })
    }
}

impl PlanTask {
    /// Takes the time that reading took from the time that is allowed.
    #[must_use]
    pub fn after(mut self, read: Duration) -> Self {
        let timeout = self.options.timeout;
        self.options.timeout = timeout.map(|time| time.saturating_sub(read));
        self
    }

    /// Plans. The motion gets the title of the file.
    #[must_use]
    pub fn run(self, file: &PatternFile, progress: &Progress) -> Planned {
        let timeout = self.options.timeout;
        let deadline = timeout.and_then(|time| Instant::now().checked_add(time));
        let mut plan = plan_watched(&file.pattern, &self.goal, &self.options, progress);
        if let Some(motion) = &mut plan.motion {
            motion.title.clone_from(&file.title);
        }
        let watch = Watch::new(progress).until(deadline);
        Planned {
            in_the_way: if self.is_own_goal {
                in_the_way(&file.pattern, plan.outcome, watch)
            } else {
                Vec::new()
            },
            held_flat: self.held_flat,
            goal: self.goal,
            plan,
        }
    }
}

/// The answer to a request.
pub struct Planned {
    /// The goal.
    pub goal: Goal,
    /// The plan.
    pub plan: Plan,
    /// A note for each limit that holds its crease flat.
    pub(super) held_flat: Vec<String>,
    /// A note for each cause, if the answer is no.
    pub(super) in_the_way: Vec<String>,
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
