//! Makes the page that shows a folding path: one HTML file that needs no other file and no network.
//!
//! `page/` has its parts, with placeholders. [`page`] joins the parts and inserts the [`Scene`] as JSON. [`pattern_page`] makes
//! the page of a crease pattern.

mod pattern_page;
mod scene;

use serde::{Serialize, Serializer};

use crate::check::WorstPair;
use crate::pattern::{EdgeId, FaceId, VertexId};

pub use pattern_page::pattern_page;

const TEMPLATE: &str = include_str!("page/page.html");
const STYLE: &str = include_str!("page/page.css");
/// Each script uses those before it.
const SCRIPTS: [&str; 3] = [
    include_str!("page/fold.js"),
    include_str!("page/drawing.js"),
    include_str!("page/plots.js"),
];
/// Parts of a page with torques, and with play, for those who ask.
const TORQUES: &str = include_str!("page/torques.js");
const TOLERANCE: &str = include_str!("page/tolerance.js");
const TOLERANCE_STYLE: &str = include_str!("page/tolerance.css");
/// The last script.
const PAGE: &str = include_str!("page/page.js");
const PLACEHOLDER: &str = "/*SCENE*/";

/// The data of the page: the flat sheet and the motion of its hinges. The page folds the sheet itself, at any time,
/// face by face along the spanning tree.
#[derive(Clone, Debug, Serialize)]
pub struct Scene {
    /// Name of the sheet.
    pub title: String,
    /// The flat sheet, in its own length unit.
    #[serde(serialize_with = "flat")]
    pub vertices: Vec<[f64; 2]>,
    /// For each vertex a face that contains it, if any does.
    pub vertex_faces: Vec<Option<FaceId>>,
    /// For each face the triangles that cover it, counter-clockwise seen from the front of the paper.
    pub faces: Vec<Vec<[u32; 3]>>,
    /// The two vertices of every edge of the pattern.
    #[serde(serialize_with = "flat")]
    pub edges: Vec<[u32; 2]>,
    /// The letter (FOLD assignment) of every edge: B, M, V, F, U, J or C.
    pub letters: String,
    /// The crease group of every edge, counted from 1, negative if the edge turns against its group; 0 if it is no
    /// hinge.
    pub turns: Vec<i64>,
    /// For each sheet the root face of its spanning tree.
    pub roots: Vec<u32>,
    /// Steps of the spanning tree: a face, its parent face, the edge between them, and the edge's end (0 or 1) at which
    /// the direction starts about which a positive angle turns the face.
    #[serde(serialize_with = "flat")]
    pub tree: Vec<[u32; 4]>,
    /// The motion of the crease groups.
    pub motion: SceneMotion,
    /// Shapes along the path in order of time, the knots among them; at least one.
    pub shapes: Vec<SceneShape>,
    /// The pair of faces that comes nearest to each other, or that passes through each other; its distance is over the
    /// median edge.
    pub worst_pair: Option<WorstPair>,
    /// The plates, if the panels are plates.
    pub plates: Option<ScenePlates>,
    /// The planner's answer to a path that does not do all that was asked; `None` if it does, or the file has no answer.
    pub shortfall: Option<SceneShortfall>,
    /// Numbers of the knots at which another phase of the motion begins.
    pub phases: Vec<usize>,
    /// Number of creases, without virtual edges.
    pub creases: usize,
    /// Largest deformation of the path, as a fraction of the edge length.
    pub max_deformation: f64,
    /// Largest gap of the path, as a fraction of the median edge.
    pub max_gap: f64,
    /// Largest closure residual of the path (dimensionless, about radians).
    pub max_closure: f64,
    /// Edges of the hinges whose torques the shapes have; none unless [`with_torques`](Self::with_torques) adds them.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub drivers: Vec<EdgeId>,
    /// The play that hinges need; none unless [`with_tolerance`](Self::with_tolerance) adds it.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub tolerance: Option<SceneTolerance>,
}

/// Angles of the crease groups at the knots of a path. Lists of groups have one row for each knot.
#[derive(Clone, Debug, Serialize)]
pub struct SceneMotion {
    /// Name of the interpolation between knots, as in files.
    pub interpolation: &'static str,
    /// Number of crease groups.
    pub groups: usize,
    /// Path time of the knots in seconds.
    pub times: Vec<f64>,
    /// Fold angles of the groups, radians.
    pub angles: Vec<f64>,
    /// Rates of the groups, radians per second.
    pub rates: Vec<f64>,
    /// Weights of the groups' half angles and the rates of the weights; empty unless the interpolation is homogeneous.
    #[serde(serialize_with = "flat")]
    pub weights: Vec<[f64; 2]>,
}

/// The sheet at one time, with its measured errors.
#[derive(Clone, Debug, Serialize)]
pub struct SceneShape {
    /// Path time in seconds.
    pub time: f64,
    /// Pose of each sheet: the rotation of its root face as a quaternion (w, x, y, z), and the position of the first
    /// vertex of the root's first triangle.
    #[serde(serialize_with = "rounded")]
    pub places: Vec<[f64; 7]>,
    /// Largest relative change of an edge's length.
    pub deformation: f64,
    /// Largest distance between the positions that the faces round a vertex give it, over the median edge.
    pub gap: f64,
    /// Largest closure residual (dimensionless, about radians).
    pub closure: f64,
    /// Smallest distance between faces that share no vertex, over the median edge; `None` if faces cross or the
    /// distance is not known.
    pub clearance: Option<f64>,
    /// Torques of the drivers at this time, newton metres, or at a time nearby if the sheet is singular; none if it is singular
    /// there as well, or if nobody asked.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub torques: Vec<f64>,
}

/// The play that the hinges of a path need for an error of its vertices. Lengths are in the unit of the sheet.
#[derive(Clone, Debug, Serialize)]
pub struct SceneTolerance {
    /// Largest error of each coordinate of each vertex; `None` if no error needs play.
    pub error: Option<f64>,
    /// Name of the unit of the sheet; empty if there is none.
    pub unit: &'static str,
    /// Shift that counts as much as a turn by a radian: the median edge.
    pub radian: f64,
    /// Fold angle of the hinge that is folded most, from which on the sheet is judged, degrees.
    pub from: f64,
    /// The hinges, those that need most play first.
    pub hinges: Vec<SceneHingePlay>,
    /// The vertices, those whose error costs most first.
    pub vertices: Vec<SceneVertexCost>,
    /// Edges of hinges of which each may be cut or given any play.
    pub redundant: Vec<EdgeId>,
}

/// The play that a hinge needs.
#[derive(Clone, Debug, Serialize)]
pub struct SceneHingePlay {
    /// Its edge.
    pub edge: EdgeId,
    /// Play in the worst case, and root mean square for random errors.
    pub worst: f64,
    /// See `worst`.
    pub expected: f64,
    /// The component that is largest in the worst case, and its time in seconds.
    pub kind: &'static str,
    /// See `kind`.
    pub at: f64,
}

/// The play that the error of one vertex needs.
#[derive(Clone, Debug, Serialize)]
pub struct SceneVertexCost {
    /// The vertex.
    pub vertex: VertexId,
    /// Largest play of any hinge.
    pub cost: f64,
}

/// The plates of a path at some thicknesses, between which their corners move on straight lines.
#[derive(Clone, Debug, Serialize)]
pub struct ScenePlates {
    /// Thickness that the file names, units of the sheet.
    pub thickness: f64,
    /// Name of the unit of the sheet; empty if there is none.
    pub unit: &'static str,
    /// Thicknesses of the forms in `points`, in increasing order; the first is next to nothing.
    pub thicknesses: Vec<f64>,
    /// For each thickness the places of all points in the frame of the flat sheet.
    #[serde(serialize_with = "rounded_lists")]
    pub points: Vec<Vec<[f64; 3]>>,
    /// For each point a face that it moves with.
    pub faces: Vec<FaceId>,
    /// The points of each triangle, counter-clockwise seen from outside.
    #[serde(serialize_with = "flat")]
    pub triangles: Vec<[u32; 3]>,
    /// For each plate the number of its triangles and of those before, and for each face the number of its plate.
    pub ends: Vec<usize>,
    /// See `ends`.
    pub of_face: Vec<usize>,
    /// Thickness up to which plates are proved to be free of crossings, and one at which they are not, if any is known.
    pub proved: f64,
    /// See `proved`.
    pub refuted: Option<f64>,
    /// Sentence on the largest thickness that is proved, and on the panels that rule out thicker plates.
    pub told: String,
}

/// The answer to a path that falls short of its goal, and the causes that are known.
#[derive(Clone, Debug, Serialize)]
pub struct SceneShortfall {
    /// The planner's answer, as in files.
    pub outcome: String,
    /// Part of the way to the goal that the path leads, 0 to 1.
    pub reached: f64,
    /// The causes that keep creases from turning along their letters, as `foldpath info` tells. A goal that does not follow the
    /// letters may have other causes.
    pub causes: Vec<SceneCause>,
}

/// Something that keeps a part of the sheet from folding.
#[derive(Clone, Debug, Serialize)]
pub struct SceneCause {
    /// The edges that cannot turn, or else those at the vertices that are to blame.
    pub edges: Vec<u32>,
    /// A sentence that names the place.
    pub message: String,
}

/// Returns the page that shows `scene`.
///
/// # Panics
///
/// Never: a scene has only numbers, texts and lists, which JSON can always hold.
#[must_use]
pub fn page(scene: &Scene) -> String {
    let json = serde_json::to_string(scene).expect("a scene is plain data");
    // Only a `<` could end the script element that holds the scene.
    let json = json.replace('<', "\\u003c");
    let asked = |text: &'static str, is_asked: bool| if is_asked { text } else { "" };
    let has_play = scene.tolerance.is_some();
    let style = [STYLE, asked(TOLERANCE_STYLE, has_play)].concat();
    let torques = asked(TORQUES, !scene.drivers.is_empty());
    let scripts = [&SCRIPTS.concat(), torques, asked(TOLERANCE, has_play), PAGE].concat();
    let parts = TEMPLATE.replacen("/*STYLE*/", &style, 1);
    let parts = parts.replacen("/*SCRIPT*/", &scripts, 1);
    parts.replacen(PLACEHOLDER, &json, 1)
}

/// Writes tuples as one list of numbers.
fn flat<T: Serialize, S: Serializer, const N: usize>(
    list: &[[T; N]],
    to: S,
) -> Result<S::Ok, S::Error> {
    to.collect_seq(list.as_flattened())
}

/// Writes tuples as one list of `f32`, which is half as long.
#[expect(clippy::cast_possible_truncation, reason = "rounding is the purpose")]
fn rounded<S: Serializer, const N: usize>(list: &[[f64; N]], to: S) -> Result<S::Ok, S::Error> {
    to.collect_seq(list.as_flattened().iter().map(|&x| x as f32))
}

/// Writes lists of tuples as [`rounded`] does, one list each.
#[expect(clippy::cast_possible_truncation, reason = "rounding is the purpose")]
fn rounded_lists<S: Serializer, const N: usize>(
    lists: &[Vec<[f64; N]>],
    to: S,
) -> Result<S::Ok, S::Error> {
    let list = |list: &Vec<[f64; N]>| -> Vec<f32> {
        list.as_flattened().iter().map(|&x| x as f32).collect()
    };
    to.collect_seq(lists.iter().map(list))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn triangle(title: &str) -> Scene {
        Scene {
            title: title.to_owned(),
            vertices: vec![[0.0, 0.0], [1.0 / 3.0, 0.0], [0.0, 1.0]],
            vertex_faces: vec![Some(FaceId(0)); 3],
            faces: vec![vec![[0, 1, 2]]],
            edges: vec![[0, 1]],
            letters: "B".to_owned(),
            turns: vec![0],
            roots: vec![0],
            tree: vec![],
            motion: SceneMotion {
                interpolation: "linear",
                groups: 0,
                times: vec![0.0],
                angles: vec![],
                rates: vec![],
                weights: vec![],
            },
            shapes: vec![SceneShape {
                time: 0.0,
                places: vec![[1.0, 0.0, 0.0, 0.0, 1.0 / 3.0, 0.0, 0.0]],
                deformation: 0.0,
                gap: 0.0,
                closure: 0.0,
                clearance: None,
                torques: vec![],
            }],
            worst_pair: None,
            plates: None,
            shortfall: None,
            phases: vec![],
            creases: 0,
            max_deformation: 0.0,
            max_gap: 0.0,
            max_closure: 0.0,
            drivers: vec![],
            tolerance: None,
        }
    }

    /// Returns the JSON in a page, as the browser's HTML parser would find it.
    fn scene_in(page: &str) -> serde_json::Value {
        let start = r#"<script id="scene" type="application/json">"#;
        let (_, rest) = page.split_once(start).expect("the page has a scene");
        let (json, _) = rest.split_once("</script>").expect("the scene ends");
        serde_json::from_str(json).expect("the scene is JSON")
    }

    #[test]
    fn no_title_breaks_out_of_the_script() {
        for title in [
            "</script><script>alert(1)</script>",
            "<!--<script>",
            PLACEHOLDER,
        ] {
            let page = page(&triangle(title));
            assert_eq!(scene_in(&page)["title"], title);
            assert_eq!(page.matches("<script").count(), 2);
        }
    }

    #[test]
    fn page_refers_to_nothing_outside() {
        let page = page(&triangle("x"));
        for way_out in [
            "http:", "https:", "//cdn", "@import", "url(", "src=", "href=",
        ] {
            assert!(!page.contains(way_out), "{way_out}");
        }
    }

    #[test]
    fn the_sheet_is_written_exactly_and_its_place_rounded() {
        let page = page(&triangle("x"));
        assert!(page.contains(r#""vertices":[0.0,0.0,0.3333333333333333,0.0,0.0,1.0]"#));
        assert!(page.contains(r#""places":[1.0,0.0,0.0,0.0,0.33333334,0.0,0.0]"#));
    }
}
