//! Runs `foldpath info`, which describes a crease pattern.

use std::collections::BTreeMap;
use std::time::Instant;

use serde::Serialize;

use crate::args::{Info, timeout};
use crate::hints::radians;
use crate::report::lost_lines;
use crate::standard::Input;
use crate::{Answer, outlook, print, print_json, print_notes};
use foldpath::folding::{Amplification, SpanningTree};
use foldpath::pattern::{EdgeId, Letter};
use foldpath::planner::{CLOSED, Cause, forecast};
use foldpath::progress::Watch;
use foldpath::read::fold::PatternFile;
use foldpath::symmetry::{CreaseGroups, ReducedStars, closure_of};

#[derive(Serialize)]
struct InfoJson {
    vertices: usize,
    edges: usize,
    faces: usize,
    sheets: usize,
    creases: usize,
    virtual_edges: usize,
    free_hinges: usize,
    real_vertices: usize,
    virtual_vertices: usize,
    letters: BTreeMap<char, usize>,
    groups: usize,
    essential_vertices: usize,
    closure_goal: Option<f64>,
    amplification: Option<f64>,
    repairs: Vec<String>,
    assumptions: Vec<String>,
    verdict: &'static str,
    causes: Vec<CauseJson>,
    locked_creases: Vec<usize>,
    flat_dof: Option<usize>,
    goal_dof: Option<usize>,
    drivers: Vec<usize>,
}

#[derive(Serialize)]
struct CauseJson {
    kind: &'static str,
    vertices: Vec<usize>,
    edges: Vec<usize>,
    at: [f64; 2],
    message: String,
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

pub(crate) fn run(args: &Info, quiet: bool) -> Answer {
    let deadline = timeout(args.timeout)?.and_then(|time| Instant::now().checked_add(time));
    let watch = Watch::default().until(deadline);
    let options = args.reading.options()?;
    let input = Input::of(&args.pattern)?;
    let file = input.pattern(&input.pattern_bytes()?, &options)?;
    drop(input);
    let pattern = &file.pattern;
    let tree = SpanningTree::from_central_face(pattern);
    let groups = CreaseGroups::find_until(pattern, watch);
    let mut assumptions = pattern.assumptions().to_vec();
    if watch.is_over() {
        let timeout =
            "--timeout ended the search for crease groups: there may be fewer than are told";
        assumptions.push(timeout.to_string());
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
    let info = InfoJson {
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
        amplification: Amplification::new(pattern, &tree).map(|factors| factors.worst()),
        repairs: pattern.repairs().to_vec(),
        assumptions,
        verdict: forecast.foldability.name(),
        causes: forecast.causes.iter().map(CauseJson::of).collect(),
        locked_creases: edges(&forecast.locked),
        flat_dof: forecast.flat_motions(),
        goal_dof: forecast.goal_motions,
        drivers: edges(&forecast.drivers(pattern, &groups)),
    };
    if args.report.json {
        print_json(&info)?;
        return Ok(true);
    }
    print_notes(quiet, &info.repairs);
    print_notes(quiet, &info.assumptions);
    print_notes(quiet, radians(pattern, closure_goal).as_slice());
    let text = summary(&file, &info);
    print(&(text + &outlook::text(pattern, &groups, &forecast, &args.pattern)))?;
    Ok(true)
}

fn summary(file: &PatternFile, info: &InfoJson) -> String {
    let letters = info
        .letters
        .iter()
        .map(|(code, count)| format!("{count} {code}"));
    let letters = letters.collect::<Vec<_>>().join(", ");
    let goal = match info.closure_goal {
        None if info.letters.keys().any(|code| "MV".contains(*code)) => {
            "not for every crease: plan folds to what is named, or else along the letters"
                .to_string()
        }
        None => "none, and no letters that say a way".to_string(),
        Some(closure) if closure <= CLOSED => format!("closes (residual {closure:.1e})"),
        Some(closure) => format!("does not close (residual {closure:.1e})"),
    };
    let count =
        |count: usize, one: &str| format!(", {count} {one}{}", if count > 1 { "s" } else { "" });
    let mut parts = String::new();
    if info.sheets > 1 {
        parts += &count(info.sheets, "sheet");
    }
    let holes = file.pattern.holes().len();
    if holes > 0 {
        parts += &count(holes, "hole");
    }
    let lost = file.pattern.lost_lines().map(lost_lines);
    let lost = lost.map_or_else(String::new, |lost| {
        format!("  lost lines          {lost}\n")
    });
    let amplification = info.amplification.map_or_else(
        || "unknown".to_string(),
        |factor| format!("{factor:.4}: errors of the sheet per closure residual of a vertex"),
    );
    format!(
        "{}\n{lost}  \
         sheet               {} faces, {} vertices ({} real, {} virtual), {} edges ({letters}){parts}\n  \
         hinges              {} creases, {} of them free; {} virtual edges stay flat\n  \
         crease groups       {}\n  \
         essential vertices  {}\n  \
         amplification       {amplification}\n  \
         goal                {goal}\n",
        file.title,
        info.faces,
        info.vertices,
        info.real_vertices,
        info.virtual_vertices,
        info.edges,
        info.creases,
        info.free_hinges,
        info.virtual_edges,
        info.groups,
        info.essential_vertices,
    )
}
