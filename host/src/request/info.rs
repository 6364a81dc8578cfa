//! A description of a crease pattern, as JSON.
#![allow(missing_docs, reason = "docs/schema/info.json describes the keys")]

use std::collections::BTreeMap;

use serde::Serialize;

use crate::folding::{SpanningTree, worst_amplification};
use crate::pattern::{CreasePattern, EdgeId, Letter};
use crate::planner::{Cause, Forecast, forecast};
use crate::progress::Watch;
use crate::symmetry::{CreaseGroups, ReducedStars, closure_of};

/// A crease pattern's parts, its crease groups, and a forecast of whether it folds.
pub struct PatternInfo {
    /// The description.
    pub json: PatternInfoJson,
    /// The crease groups.
    pub groups: CreaseGroups,
    /// The forecast.
    pub forecast: Forecast,
    /// Room that a controller needs for a path in these groups.
    pub room: Room,
}

/// The description of a crease pattern, which serialises to the JSON object of `foldpath info --json`.
#[derive(Debug, Serialize)]
pub struct PatternInfoJson {
    pub vertices: usize,
    pub edges: usize,
    pub faces: usize,
    pub sheets: usize,
    pub creases: usize,
    pub virtual_edges: usize,
    pub free_hinges: usize,
    pub real_vertices: usize,
    pub virtual_vertices: usize,
    pub letters: BTreeMap<char, usize>,
    pub groups: usize,
    pub essential_vertices: usize,
    pub closure_goal: Option<f64>,
    pub amplification: Option<f64>,
    pub repairs: Vec<String>,
    pub assumptions: Vec<String>,
    pub verdict: &'static str,
    pub causes: Vec<CauseJson>,
    pub locked_creases: Vec<usize>,
    pub flat_dof: Option<usize>,
    pub goal_dof: Option<usize>,
    pub drivers: Vec<usize>,
}

/// Room that a controller needs for a path in these crease groups.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Room {
    /// Number of crease groups.
    pub groups: usize,
    /// Number of hinges.
    pub hinges: usize,
    /// Number of spokes of all essential vertices.
    pub spokes: usize,
}

/// A cause why a pattern may not fold.
#[derive(Debug, Serialize)]
pub struct CauseJson {
    pub kind: &'static str,
    pub vertices: Vec<usize>,
    pub edges: Vec<usize>,
    pub at: [f64; 2],
    pub message: String,
}

impl CauseJson {
    fn of(cause: &Cause) -> Self {
        Self {
            kind: cause.kind.name(),
            vertices: cause.vertices.iter().map(|vertex| vertex.index()).collect(),
            edges: edges(&cause.edges),
            at: cause.at,
            message: cause.to_string(),
        }
    }
}

/// Returns the numbers of edges.
fn edges(ids: &[EdgeId]) -> Vec<usize> {
    ids.iter().map(|edge| edge.index()).collect()
}

impl PatternInfo {
    /// Describes a pattern. Once the watch is over, crease groups may be too few and the forecast may be unknown.
    #[must_use]
    pub fn of(pattern: &CreasePattern, watch: Watch<'_>) -> Self {
        let tree = SpanningTree::from_central_face(pattern);
        let groups = CreaseGroups::find_until(pattern, watch);
        let mut assumptions = pattern.assumptions().to_vec();
        if watch.is_over() {
            let note =
                "time ran out in the search for crease groups: there may be fewer than are told";
            assumptions.push(note.to_string());
        }
        let stars = ReducedStars::all(pattern, &groups).essential();
        let mut letters = BTreeMap::new();
        for edge in pattern.edges() {
            *letters.entry(edge.letter.code()).or_default() += 1;
        }
        let real_vertices = pattern.real_vertices().count();
        let free = |id: &&EdgeId| pattern.edge(**id).letter == Letter::Unassigned;
        let goals = pattern.creases().iter().map(|&id| pattern.edge(id).goal);
        let closure_goal = closure_of(pattern, &goals.collect::<Vec<_>>());
        let forecast = forecast(pattern, &groups, watch);
        let json = PatternInfoJson {
            vertices: pattern.vertices().len(),
            edges: pattern.edges().len(),
            faces: pattern.faces().len(),
            sheets: pattern.sheets(),
            creases: pattern.creases().len(),
            virtual_edges: pattern.virtual_edges(),
            free_hinges: pattern.creases().iter().filter(free).count(),
            real_vertices,
            virtual_vertices: pattern.vertices().len() - real_vertices,
            letters,
            groups: groups.len(),
            essential_vertices: stars.vertices().len(),
            closure_goal,
            amplification: worst_amplification(pattern, &tree),
            repairs: pattern.repairs().to_vec(),
            assumptions,
            verdict: forecast.foldability.name(),
            causes: forecast.causes.iter().map(CauseJson::of).collect(),
            locked_creases: edges(&forecast.locked),
            flat_dof: forecast.flat_motions(),
            goal_dof: forecast.goal_motions,
            drivers: edges(&forecast.drivers(pattern, &groups)),
        };
        let room = Room {
            groups: groups.len(),
            hinges: pattern.creases().len(),
            spokes: stars.view().iter().map(|star| star.spokes.len()).sum(),
        };
        Self {
            json,
            groups,
            forecast,
            room,
        }
    }
}
