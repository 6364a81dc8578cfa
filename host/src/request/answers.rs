//! The answers to requests as JSON.
#![allow(missing_docs, reason = "docs/schema describes the keys")]

use core::time::Duration;
use std::collections::BTreeMap;
use std::path::Path;

use serde::Serialize;

use super::hints::radians_hint;
use super::options::PlanRequest;
use super::order::Order;
use super::plan::Planned;
use crate::check::{PathCrossing, Verdict};
use crate::collision::SweepCounts;
use crate::folding::{FoldingMap, small_box, smallest_rectangle, worst_amplification};
use crate::motion::Motion;
use crate::pattern::{CreaseId, CreasePattern, EdgeId, Letter, Precision, Unit, VertexId};
use crate::planner::{
    Attempt, Cause, DEFAULT_MAX_SPEED_DEG_PER_S, Forecast, Outcome, Plan, forecast,
};
use crate::progress::Watch;
use crate::read::fold::PatternFile;
use crate::sensitivity::{
    Drive, HingePlay, Loads, Peak, Tolerance, skew_bound, skew_residual, skew_residual_of_sheet,
};
use crate::symmetry::{CreaseGroups, ReducedStars, closure_of};
use crate::unfold::Unfolding;
use crate::util::nan_max::largest;

/// Largest number of panels that bend that are named.
const MAX_BENDS: usize = 8;

/// Makes a struct for JSON and the function `of` that fills it, so that each key stands once, with its type and its value.
/// Statements in a block of their own come before the keys.
macro_rules! answers {
    ($(
        $(#[$about:meta])*
        $Name:ident $(<$life:lifetime>)? of ($($argument:ident: $Argument:ty),*) {$($before:tt)*} {
            $($(#[$how:meta])* $key:ident: $Type:ty = $value:expr;)*
        }
    )*) => {$(
        $(#[$about])*
        #[derive(Debug, Serialize)]
        pub struct $Name $(<$life>)? {
            $($(#[$how])* pub $key: $Type,)*
        }

        impl $(<$life>)? $Name $(<$life>)? {
            #[must_use]
            pub fn of($($argument: $Argument),*) -> Self {
                $($before)*
                Self { $($key: $value,)* }
            }
        }
    )*};
}

answers! {
    /// The file that was read, with the digest of its bytes in hexadecimal digits. Without bytes there is no digest.
    InputJson of (name: &Path, bytes: Option<&[u8]>) {
        let digest = bytes.map(hmac_sha256::Hash::hash);
    } {
        file: String = name.display().to_string();
        sha256: String = digest.iter().flatten().map(|byte| format!("{byte:02x}")).collect();
    }

    /// The answer to a [`PlanRequest`], which serialises to the JSON object of `foldpath plan --json`. Lengths are in the
    /// units of the sheet, angles in degrees, times in seconds. `times` are those of reading, of writing, and of everything;
    /// without them, the answer has no times.
    PlanJson<'a> of (
        planned: &Planned, request: &'a PlanRequest, input: &'a InputJson, file: &PatternFile,
        times: Option<[Duration; 3]>
    ) {
        let (plan, pattern) = (&planned.plan, &file.pattern);
    } {
        version: &'static str = env!("CARGO_PKG_VERSION");
        input: &'a InputJson = input;
        options: &'a PlanRequest = request;
        outcome: &'static str = plan.outcome.name();
        reason: Option<String> = plan.reason.as_ref().map(ToString::to_string);
        reached: f64 = plan.reached;
        creases: usize = pattern.creases().len();
        real_vertices: usize = pattern.real_vertices().count();
        groups: usize = plan.reduced.groups;
        essential_vertices: usize = plan.reduced.essential_vertices;
        unknowns: usize = plan.reduced.groups;
        knots: usize = plan.knots().len();
        max_deformation: f64 = plan.errors.rigidity.deformation;
        certified_deformation: Option<f64> = plan.certified_deformation();
        max_closure: f64 = plan.errors.closure;
        max_gap: f64 = plan.errors.rigidity.gap;
        max_bend: f64 = plan.max_bend.to_degrees();
        goal_error: f64 = plan.arrival.error.to_degrees();
        flat_creases: usize = plan.arrival.flat_creases;
        min_clearance: Option<f64> = plan.crossings.clearance.map(|clearance| clearance.distance);
        contact_tolerance: f64 = plan.crossings.contact_tolerance;
        undecided: Vec<String> = sentences(&plan.undecided);
        notes: Vec<String> = notes(planned, request, file);
        #[serde(skip_serializing_if = "Option::is_none")]
        orders: Option<Vec<String>> = request.orders.map(|_| {
            let orders = plan.orders.iter();
            orders.map(|order| Order::of(order, pattern, &planned.goal).to_string()).collect()
        });
        attempts: Vec<AttemptJson> = (plan.attempts.iter())
            .map(|attempt| AttemptJson::of(attempt, times.is_some())).collect();
        #[serde(skip_serializing_if = "Option::is_none")]
        time: Option<TimeJson> = times.map(|times| TimeJson::of(plan, times));
        solver: SolverJson = SolverJson::of(plan);
        collision: SweepCounts = plan.crossings.counts;
        seed: u64 = request.seed;
        unit: Option<&'static str> = pattern.unit().map(Unit::name);
        precision: PrecisionJson = PrecisionJson::of(pattern.precision());
        thickness: Option<f64> = plan.thickness;
        max_thickness: Option<[f64; 2]> = plan.max_thickness;
    }

    /// Figures by which designs are ranked, in a result of `foldpath batch`: of the flat sheet, and of the thin sheet at the end
    /// of its motion. Sides of boxes begin with the longest.
    FiguresJson of (motion: &Motion) {
        let pattern = &motion.pattern;
        let folded = motion.crease_angles(motion.knots.len() - 1);
        let folded = FoldingMap::new(pattern, pattern.tree(), &folded);
        let flat_box = smallest_rectangle(pattern.vertices());
        let folded_box = small_box(pattern, folded.vertices());
        let ratio = flat_box[0] * flat_box[1] / (folded_box[0] * folded_box[1]);
        let angles = motion.knots.iter().flat_map(|knot| &knot.angles);
    } {
        flat_box: [f64; 2] = flat_box;
        folded_box: [f64; 3] = folded_box;
        packing_ratio: Option<f64> = Some(ratio).filter(|ratio| ratio.is_finite());
        largest_angle: f64 = largest(angles.map(|angle| angle.abs())).to_degrees();
    }

    /// Units of the last digit of a pattern's numbers: of its coordinates, and of its goal angles in degrees. Exact numbers
    /// have none.
    PrecisionJson of (precision: Precision) {
        let [length, angle] = [precision.length, precision.angle].map(|digits| {
            Some(digits.unit()).filter(|unit| *unit > 0.0)
        });
    } {
        length: Option<f64> = length;
        angle: Option<f64> = angle.map(f64::to_degrees);
    }

    /// A strategy that was tried.
    AttemptJson of (attempt: &Attempt, is_timed: bool) {} {
        strategy: &'static str = attempt.strategy.name();
        outcome: &'static str = attempt.outcome.name();
        reason: Option<String> = attempt.reason.as_ref().map(ToString::to_string);
        #[serde(skip_serializing_if = "Option::is_none")]
        seconds: Option<f64> = is_timed.then_some(attempt.seconds);
    }

    /// Times that were taken, seconds.
    TimeJson of (plan: &Plan, times: [Duration; 3]) {
        let ([read, write, total], stages) = (times, plan.effort.times);
    } {
        total: f64 = total.as_secs_f64();
        read: f64 = read.as_secs_f64();
        symmetry: f64 = stages.symmetry.as_secs_f64();
        solve: f64 = stages.solve.as_secs_f64();
        fold: f64 = (stages.place + stages.fold).as_secs_f64();
        collision: f64 = stages.collision.as_secs_f64();
        write: f64 = write.as_secs_f64();
    }

    /// Work of the solver.
    SolverJson of (plan: &Plan) {} {
        iterations: u64 = plan.effort.iterations;
        evaluations: u64 = plan.effort.evaluations;
    }

    /// A verdict on a motion, which serialises to the JSON object of `foldpath check --json`. Angles are in degrees, lengths
    /// in the units of the sheet.
    CheckJson of (motion: &Motion, verdict: &Verdict) {
        let reasons = match &verdict.failures[..] {
            [] => sentences(&verdict.undecided),
            failures => sentences(failures),
        };
        let rigidity = verdict.rigidity();
    } {
        outcome: &'static str = verdict.outcome().name();
        reason: Option<String> = (!verdict.holds()).then(|| reasons.join("; "));
        start: &'static str = if motion.begins_flat() { "flat" } else { "folded" };
        undecided: Vec<String> = sentences(&verdict.undecided);
        knots: usize = motion.knots.len();
        max_deformation: f64 = rigidity.deformation;
        max_gap: f64 = rigidity.gap;
        max_closure: f64 = verdict.closure();
        max_bend: f64 = verdict.max_bend.to_degrees();
        certified_deformation: Option<f64> = verdict.certified().map(|most| most.deformation);
        certified_of: String = certified_of(&motion.pattern);
        crossings: Vec<CrossingJson> = verdict.crossings.iter().map(CrossingJson::of).collect();
        min_clearance: Option<f64> = verdict.min_clearance;
        contact_tolerance: f64 = verdict.contact_tolerance;
        max_speed: f64 = verdict.rates.speed.to_degrees();
        max_acceleration: Option<f64> = verdict.rates.acceleration.map(f64::to_degrees);
    }

    /// The play that a motion needs, which serialises to the JSON object of `foldpath tolerance --json`. Lengths are in the units
    /// of the sheet, times in seconds. `error` is the largest error of each coordinate of each vertex; `None` if no error needs
    /// play.
    ToleranceJson of (motion: &Motion, tolerance: &Tolerance, error: Option<f64>) {
        let scale = error.unwrap_or(0.0);
        let edge = |crease: CreaseId| motion.pattern.creases()[crease.index()].index();
    } {
        error: Option<f64> = error;
        unit: Option<&'static str> = motion.pattern.unit().map(Unit::name);
        max_play: f64 = scale * tolerance.worst().map_or(0.0, |hinge| hinge.worst);
        at: f64 = tolerance.worst().map_or(0.0, |hinge| hinge.at);
        hinges: Vec<HingePlayJson> = (tolerance.ranked_hinges().into_iter())
            .map(|hinge| HingePlayJson::of(edge(hinge.crease), hinge, scale)).collect();
        vertices: Vec<VertexCostJson> = (tolerance.ranked_vertices().into_iter())
            .map(|(vertex, cost)| VertexCostJson::of(vertex.index(), cost, scale)).collect();
        redundant: Vec<usize> = tolerance.redundant.iter().map(|&crease| edge(crease)).collect();
    }

    /// The play of a hinge.
    HingePlayJson of (edge: usize, hinge: &HingePlay, error: f64) {} {
        edge: usize = edge;
        worst: f64 = hinge.worst * error;
        expected: f64 = hinge.expected * error;
    }

    /// The play that the error of a vertex costs.
    VertexCostJson of (vertex: usize, cost: f64, error: f64) {} {
        vertex: usize = vertex;
        cost: f64 = cost * error;
    }

    /// The torques of a motion, which serialises to the JSON object of `foldpath loads --json`. Torques are in newton metres,
    /// times in seconds.
    LoadsJson of (motion: &Motion, loads: &Loads, drives: &[Drive]) {
        let edge = |crease: CreaseId| motion.pattern.creases()[crease.index()].index();
    } {
        drivers: Vec<usize> = loads.drivers.iter().map(|&crease| edge(crease)).collect();
        times: Vec<f64> = loads.times.clone();
        torques: Vec<Vec<f64>> = loads.torques.clone();
        peak: PeakJson = PeakJson::of(edge(loads.peak.driver), &loads.peak);
        regularity: f64 = loads.regularity;
        is_least: bool = loads.is_least;
        fits: Vec<FitJson> = drives.iter().map(|drive| FitJson::of(loads, drive)).collect();
    }

    /// The largest torque.
    PeakJson of (driver: usize, peak: &Peak) {} {
        driver: usize = driver;
        torque: f64 = peak.torque;
        at: f64 = peak.at;
    }

    /// A kind of drive, and if it fits.
    FitJson of (loads: &Loads, drive: &Drive) {
        let at = loads.stalls_at(drive);
    } {
        drive: String = drive.name.clone();
        fits: bool = at.is_none();
        at: Option<f64> = at;
    }

    /// The answer to unfolding a shape, which serialises to the JSON object of `foldpath unfold --json`. The reason is that of
    /// the outcome, in a sentence.
    UnfoldJson of (unfolding: &Unfolding, reason: Option<String>) {} {
        outcome: &'static str = unfolding.outcome.name();
        reason: Option<String> = reason;
        vertices: usize = unfolding.vertices;
        faces: usize = unfolding.faces;
        creases: usize = unfolding.creases;
        cuts: usize = unfolding.cuts;
        pieces: usize = unfolding.pieces;
        max_angle_defect: f64 = unfolding.max_angle_defect.to_degrees();
        max_closure: Option<f64> = unfolding.max_closure;
    }

    /// Two faces that pass through each other.
    CrossingJson of (found: &PathCrossing) {} {
        faces: [u32; 2] = found.crossing.faces.map(|face| face.0);
        between_knots: [usize; 2] = found.between_knots;
        at: f64 = found.at;
    }

    /// A description of a crease pattern, which serialises to the JSON object of `foldpath info --json`, with what it is made
    /// of. Once the watch is over, crease groups may be too few and the forecast may be unknown.
    PatternInfo of (pattern: &CreasePattern, watch: Watch<'_>) {
        let crease_groups = CreaseGroups::find_until(pattern, watch);
        let mut assumptions = pattern.assumptions().to_vec();
        if watch.is_over() {
            let note = "time ran out in the search for crease groups: there may be fewer than are told";
            assumptions.push(note.to_string());
        }
        let stars = ReducedStars::all(pattern, &crease_groups).essential();
        let mut letters = BTreeMap::new();
        for edge in pattern.edges() {
            *letters.entry(edge.letter.code()).or_default() += 1;
        }
        let real_vertices = pattern.real_vertices().count();
        let free = |id: &&EdgeId| pattern.edge(**id).letter == Letter::Unassigned;
        let goals = pattern.creases().iter().map(|&id| pattern.edge(id).goal);
        let closure_goal = closure_of(pattern, &goals.collect::<Vec<_>>());
        let forecast = forecast(pattern, &crease_groups, watch);
        let amplification = worst_amplification(pattern, pattern.tree());
        let residual = skew_residual_of_sheet(pattern, DEFAULT_MAX_SPEED_DEG_PER_S.to_radians());
        assumptions.extend(forecast.straightened.map(|how| format!("the forecast is that of the sheet {how}")));
    } {
        vertices: usize = pattern.vertices().len();
        edges: EdgesInfo = EdgesInfo::Count(pattern.edges().len());
        faces: usize = pattern.faces().len();
        sheets: usize = pattern.sheets();
        creases: usize = pattern.creases().len();
        virtual_edges: usize = pattern.virtual_edges();
        free_hinges: usize = pattern.creases().iter().filter(free).count();
        real_vertices: usize = real_vertices;
        virtual_vertices: usize = pattern.vertices().len() - real_vertices;
        letters: BTreeMap<char, usize> = letters;
        groups: usize = crease_groups.len();
        essential_vertices: usize = stars.vertices().len();
        closure_goal: Option<f64> = closure_goal;
        amplification: Option<f64> = amplification;
        repairs: Vec<String> = pattern.repairs().to_vec();
        assumptions: Vec<String> = assumptions;
        verdict: &'static str = forecast.foldability.name();
        causes: Vec<CauseJson> = forecast.causes.iter().map(CauseJson::of).collect();
        locked_creases: Vec<usize> = edges(&forecast.locked);
        flat_dof: Option<usize> = forecast.flat_motions();
        goal_dof: Option<usize> = forecast.goal_motions;
        drivers: Vec<usize> = edges(&forecast.drivers(pattern, &crease_groups));
        skew_bound: Option<f64> = residual.zip(amplification).and_then(|(residual, factor)| skew_bound(residual, factor));
        /// Number of spokes of all essential vertices, for which a controller needs room.
        #[serde(skip)]
        spokes: usize = stars.view().iter().map(|star| star.spokes.len()).sum();
        #[serde(skip)]
        crease_groups: CreaseGroups = crease_groups;
        #[serde(skip)]
        forecast: Forecast = forecast;
    }

    /// An edge of a pattern. `ends` are in the drawing's own coordinates, `goal` is in degrees.
    EdgeInfo of (pattern: &CreasePattern, number: usize, names: &[&str]) {
        let edge = &pattern.edges()[number];
    } {
        edge: usize = number;
        vertices: [usize; 2] = edge.ends.map(VertexId::index);
        ends: [[f64; 2]; 2] = edge.ends.map(|end| pattern.drawn_place(end));
        letter: char = edge.letter.code();
        goal: Option<f64> = edge.goal.map(f64::to_degrees);
        names: Vec<String> = names.iter().map(ToString::to_string).collect();
    }

    /// A cause why a pattern may not fold.
    CauseJson of (cause: &Cause) {} {
        kind: &'static str = cause.kind.name();
        vertices: Vec<usize> = cause.vertices.iter().map(|vertex| vertex.index()).collect();
        edges: Vec<usize> = edges(&cause.edges);
        at: [f64; 2] = cause.at;
        message: String = cause.to_string();
    }
}

impl PatternInfo {
    /// Replaces the bound on the skew, which is that of any motion at the usual speed, by that of this motion of the sheet.
    pub fn moved_by(&mut self, motion: &Motion) {
        let both = skew_residual(motion).zip(self.amplification);
        self.skew_bound = both.and_then(|(residual, factor)| skew_bound(residual, factor));
    }
}

/// The edges of a pattern.
#[derive(Debug, Serialize)]
#[serde(untagged)]
pub enum EdgesInfo {
    /// The number of edges.
    Count(usize),
    /// Each of them.
    List(Vec<EdgeInfo>),
}

impl EdgesInfo {
    /// Lists the edges in the order of their numbers.
    #[must_use]
    pub fn list(pattern: &CreasePattern) -> Self {
        let names = pattern.names_of_edges().into_iter().enumerate();
        Self::List(
            names
                .map(|(number, names)| EdgeInfo::of(pattern, number, &names))
                .collect(),
        )
    }
}

/// Returns the numbers of edges.
fn edges(ids: &[EdgeId]) -> Vec<usize> {
    ids.iter().map(|edge| edge.index()).collect()
}

fn sentences(findings: &[impl ToString]) -> Vec<String> {
    findings.iter().map(ToString::to_string).collect()
}

/// Returns remarks on a plan for the user, one sentence each.
fn notes(planned: &Planned, request: &PlanRequest, file: &PatternFile) -> Vec<String> {
    let plan = &planned.plan;
    let mut notes = [file.pattern.repairs(), file.pattern.assumptions()].concat();
    notes.extend(plan.notes.iter().map(ToString::to_string));
    notes.extend_from_slice(&planned.remarks);
    notes.extend(plan.motion.iter().flat_map(bends));
    if request.goal.is_none() && request.fold.is_none() && request.crease.is_empty() {
        let closure = match plan.outcome {
            Outcome::GoalNotClosed => f64::INFINITY,
            _ => plan.arrival.goal_closure,
        };
        notes.extend(radians_hint(&file.pattern, Some(closure)));
    }
    notes
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

/// Says which folding of a sheet is certified: on a sheet that does not quite close, others are torn elsewhere.
fn certified_of(pattern: &CreasePattern) -> String {
    let roots: Vec<_> = pattern
        .tree()
        .roots()
        .iter()
        .map(ToString::to_string)
        .collect();
    match &roots[..] {
        [root] => format!("the sheet folded from face {root} outwards"),
        _ => format!("the sheets folded from faces {} outwards", roots.join(", ")),
    }
}
