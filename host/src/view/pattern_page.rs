//! Makes the page that shows a crease pattern: its drawing with the numbers of the edges, beside it names, crease groups and
//! what keeps it from folding, which light their edges.

use serde::Serialize;

use super::SceneCause;
use super::scene::{scene_cause, turn};
use crate::export::svg_pattern::numbered;
use crate::pattern::CreasePattern;
use crate::planner::forecast;
use crate::progress::Watch;
use crate::symmetry::CreaseGroups;

const STYLE: &str = include_str!("page/pattern.css");
const SCRIPT: &str = include_str!("page/pattern.js");

/// The data of the page.
#[derive(Serialize)]
struct PatternScene<'a> {
    title: &'a str,
    /// The forecast, as `foldpath info` tells it, and what is in the way.
    verdict: &'static str,
    causes: Vec<SceneCause>,
    /// Edges that cannot turn in a first step from flat.
    locked: Vec<usize>,
    edges: Vec<SceneEdge<'a>>,
}

#[derive(Serialize)]
struct SceneEdge<'a> {
    letter: char,
    /// Goal angle in degrees, if the drawing names one.
    goal: Option<f64>,
    /// The crease group, as in [`Scene::turns`](super::Scene::turns).
    group: i64,
    names: Vec<&'a str>,
}

/// Makes the page that shows a crease pattern: its drawing with the numbers of the edges, names, crease groups and the causes
/// that [`forecast`] finds, each of which lights its edges. Once `watch` is over, crease groups may be too few and the forecast
/// unknown.
///
/// # Panics
///
/// Never: a scene has only numbers, texts and lists, which JSON can always hold.
#[must_use]
pub fn pattern_page(title: &str, pattern: &CreasePattern, watch: Watch<'_>) -> String {
    let groups = CreaseGroups::find_until(pattern, watch);
    let forecast = forecast(pattern, &groups, watch);
    let edges = pattern.edges().iter().zip(pattern.names_of_edges());
    let edges = edges.map(|(edge, names)| SceneEdge {
        letter: edge.letter.code(),
        goal: edge.goal.map(f64::to_degrees),
        group: turn(edge.crease.map(|crease| groups.of(crease))),
        names,
    });
    let causes = forecast.causes.iter();
    let scene = PatternScene {
        title,
        verdict: forecast.foldability.name(),
        causes: causes.map(|cause| scene_cause(pattern, cause)).collect(),
        locked: forecast.locked.iter().map(|edge| edge.index()).collect(),
        edges: edges.collect(),
    };
    let json = serde_json::to_string(&scene).expect("a scene is plain data");
    // Only a `<` could end the script element that holds the scene.
    let json = json.replace('<', "\\u003c");
    let sheet = numbered(title, pattern);
    format!(
        "<!DOCTYPE html>\n<html lang=\"en\">\n<meta charset=\"utf-8\">\n\
         <meta name=\"viewport\" content=\"width=device-width, initial-scale=1\">\n<title>crease pattern</title>\n\
         <style>\n{STYLE}</style>\n<main>\n{sheet}</main>\n<aside tabindex=\"0\" aria-label=\"Edges\"></aside>\n\
         <script id=\"scene\" type=\"application/json\">{json}</script>\n<script>\n{SCRIPT}</script>\n</html>\n"
    )
}
