//! The answer to a request as JSON.
#![allow(missing_docs, reason = "docs/schema/plan.json describes the keys")]

use core::fmt::Write as _;
use core::time::Duration;
use std::path::Path;

use serde::Serialize;

use super::hints::radians_hint;
use super::options::PlanRequest;
use super::plan::Planned;
use crate::collision::SweepCounts;
use crate::motion::Motion;
use crate::pattern::{EdgeId, Letter};
use crate::planner::{Attempt, Outcome};
use crate::read::fold::PatternFile;

/// Largest number of panels that bend that are named.
const MAX_BENDS: usize = 8;

/// The file that was read.
#[derive(Clone, Debug, Serialize)]
pub struct InputJson {
    /// Name of the file.
    pub file: String,
    /// Digest of its bytes, in hexadecimal digits.
    pub sha256: String,
}

impl InputJson {
    /// Names a file, with the digest of its bytes.
    #[must_use]
    pub fn of(name: &Path, bytes: &[u8]) -> Self {
        let mut sha256 = String::new();
        for byte in hmac_sha256::Hash::hash(bytes) {
            let _infallible = write!(sha256, "{byte:02x}");
        }
        Self {
            file: name.display().to_string(),
            sha256,
        }
    }

    /// Names a file without a digest, where nobody looks at it.
    #[must_use]
    pub fn without_digest(name: &Path) -> Self {
        Self {
            file: name.display().to_string(),
            sha256: String::new(),
        }
    }
}

/// The answer to a [`PlanRequest`], which serialises to the JSON object of `foldpath plan --json`. Lengths are in the units
/// of the sheet, angles in degrees, times in seconds.
#[derive(Debug, Serialize)]
pub struct PlanJson<'a> {
    pub version: &'static str,
    pub input: &'a InputJson,
    pub options: &'a PlanRequest,
    pub outcome: &'static str,
    pub reason: Option<String>,
    pub reached: f64,
    pub creases: usize,
    pub real_vertices: usize,
    pub groups: usize,
    pub essential_vertices: usize,
    pub unknowns: usize,
    pub knots: usize,
    pub max_deformation: f64,
    pub certified_deformation: Option<f64>,
    pub max_closure: f64,
    pub max_gap: f64,
    pub max_bend: f64,
    pub goal_error: f64,
    pub flat_creases: usize,
    pub min_clearance: Option<f64>,
    pub contact_tolerance: f64,
    pub undecided: Vec<String>,
    pub notes: Vec<String>,
    pub attempts: Vec<AttemptJson>,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub time: Option<TimeJson>,
    pub solver: SolverJson,
    pub collision: SweepCounts,
    pub seed: u64,
}

/// A strategy that was tried.
#[derive(Debug, Serialize)]
pub struct AttemptJson {
    pub strategy: &'static str,
    pub outcome: &'static str,
    pub reason: Option<String>,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub seconds: Option<f64>,
}

/// Times that were taken, seconds.
#[derive(Debug, Serialize)]
pub struct TimeJson {
    pub total: f64,
    pub read: f64,
    pub symmetry: f64,
    pub solve: f64,
    pub fold: f64,
    pub collision: f64,
    pub write: f64,
}

/// Work of the solver.
#[derive(Debug, Serialize)]
pub struct SolverJson {
    pub iterations: u64,
    pub evaluations: u64,
}

impl AttemptJson {
    fn of(attempt: &Attempt) -> Self {
        Self {
            strategy: attempt.strategy.name(),
            outcome: attempt.outcome.name(),
            reason: attempt.reason.as_ref().map(ToString::to_string),
            seconds: Some(attempt.seconds),
        }
    }
}

impl PlanJson<'_> {
    /// Fills in the times that only the caller knows: of reading, of writing, and of everything.
    #[must_use]
    pub fn with_times(mut self, read: Duration, write: Duration, total: Duration) -> Self {
        if let Some(time) = &mut self.time {
            time.read = read.as_secs_f64();
            time.write = write.as_secs_f64();
            time.total = total.as_secs_f64();
        }
        self
    }

    /// Leaves out the times that were taken.
    pub fn leave_out_times(&mut self) {
        self.time = None;
        for attempt in &mut self.attempts {
            attempt.seconds = None;
        }
    }
}

impl Planned {
    /// Returns the answer for JSON. Its total time is that of planning; see [`PlanJson::with_times`].
    #[must_use]
    pub fn json<'a>(
        &self,
        request: &'a PlanRequest,
        input: &'a InputJson,
        file: &PatternFile,
    ) -> PlanJson<'a> {
        let (plan, pattern) = (&self.plan, &file.pattern);
        let times = plan.times;
        let fold = times.place + times.fold;
        PlanJson {
            version: env!("CARGO_PKG_VERSION"),
            input,
            options: request,
            outcome: plan.outcome.name(),
            reason: plan.reason.as_ref().map(ToString::to_string),
            reached: plan.reached,
            creases: pattern.creases().len(),
            real_vertices: pattern.real_vertices().count(),
            groups: plan.groups,
            essential_vertices: plan.essential_vertices,
            unknowns: plan.unknowns,
            knots: plan.knots().len(),
            max_deformation: plan.rigidity.deformation,
            certified_deformation: plan.certified_deformation,
            max_closure: plan.max_closure,
            max_gap: plan.rigidity.gap,
            max_bend: plan.max_bend.to_degrees(),
            goal_error: plan.goal_error.to_degrees(),
            flat_creases: plan.flat_creases,
            min_clearance: plan.clearance.map(|clearance| clearance.distance),
            contact_tolerance: plan.contact_tolerance,
            undecided: plan.undecided.iter().map(ToString::to_string).collect(),
            notes: self.notes(request, file),
            attempts: plan.attempts.iter().map(AttemptJson::of).collect(),
            time: Some(TimeJson {
                total: (times.symmetry + times.solve + fold + times.collision).as_secs_f64(),
                read: 0.0,
                symmetry: times.symmetry.as_secs_f64(),
                solve: times.solve.as_secs_f64(),
                fold: fold.as_secs_f64(),
                collision: times.collision.as_secs_f64(),
                write: 0.0,
            }),
            solver: SolverJson {
                iterations: plan.iterations,
                evaluations: plan.evaluations,
            },
            collision: plan.collision,
            seed: request.seed,
        }
    }

    /// Returns remarks for the user, one sentence each.
    fn notes(&self, request: &PlanRequest, file: &PatternFile) -> Vec<String> {
        let plan = &self.plan;
        let mut notes = [file.pattern.repairs(), file.pattern.assumptions()].concat();
        notes.extend(plan.notes.iter().map(ToString::to_string));
        notes.extend_from_slice(&self.held_flat);
        notes.extend_from_slice(&self.in_the_way);
        notes.extend(plan.motion.iter().flat_map(bends));
        if request.goal.is_none() && request.fold.is_none() && request.crease.is_empty() {
            let open = plan.outcome == Outcome::GoalNotClosed;
            let closure = if open {
                f64::INFINITY
            } else {
                plan.goal_closure
            };
            notes.extend(radians_hint(&file.pattern, Some(closure)));
        }
        notes
    }
}

/// Returns a note for each panel that bends, those that bend most first.
fn bends(motion: &Motion) -> Vec<String> {
    let edges = motion.pattern.edges().iter().enumerate();
    let mut bends: Vec<(f64, String)> = edges
        .filter(|(_, edge)| edge.letter == Letter::Bend)
        .map(|(index, edge)| {
            let angles =
                (0..motion.knots.len()).map(|knot| motion.node(knot, EdgeId::new(index)).angle);
            let most = angles.map(f64::abs).fold(0.0, f64::max).to_degrees();
            let [from, to] = edge.ends;
            let line = format!("from vertex {from} to vertex {to} (edge {index})");
            (
                most,
                format!("a panel bends by {most:.2} degrees about its diagonal {line}"),
            )
        })
        .filter(|(most, _)| *most > 0.0)
        .collect();
    bends.sort_by(|a, b| b.0.total_cmp(&a.0));
    let more = bends.len().saturating_sub(MAX_BENDS);
    let named = bends.into_iter().take(MAX_BENDS).map(|(_, note)| note);
    let more = (more > 0).then(|| format!("{more} more panels bend, by less"));
    named.chain(more).collect()
}
