//! The page that shows a folding path: one HTML file that needs nothing else.
//!
//! `page/` has its parts, with placeholders; [`page`] puts them together, and the [`Scene`] there as JSON.

mod scene;

use serde::{Serialize, Serializer};

const TEMPLATE: &str = include_str!("page/page.html");
const STYLE: &str = include_str!("page/page.css");
/// Each uses those before.
const SCRIPTS: [&str; 4] = [
    include_str!("page/fold.js"),
    include_str!("page/drawing.js"),
    include_str!("page/plots.js"),
    include_str!("page/page.js"),
];
const PLACEHOLDER: &str = "/*SCENE*/";

/// What the page shows: the flat sheet and how its hinges turn. The page folds the sheet itself, at any time,
/// panel by panel along the spanning tree.
#[derive(Clone, Debug, Serialize)]
pub struct Scene {
    /// Name of the sheet.
    pub title: String,
    /// The flat sheet, in its own length unit.
    #[serde(serialize_with = "flat")]
    pub vertices: Vec<[f64; 2]>,
    /// For each vertex the face that takes it along, if any does.
    pub vertex_faces: Vec<Option<u32>>,
    /// For each face the triangles that cover it, counter-clockwise seen from the front of the paper.
    pub faces: Vec<Vec<[u32; 3]>>,
    /// The two vertices of every edge of the pattern.
    #[serde(serialize_with = "flat")]
    pub edges: Vec<[u32; 2]>,
    /// The FOLD assignment of every edge: of B, M, V, F, U, J, C.
    pub letters: String,
    /// The crease group of every edge, from 1, negative if it turns the opposite way; 0 if it is no hinge.
    pub turns: Vec<i64>,
    /// For each sheet the face that the others hang on.
    pub roots: Vec<u32>,
    /// Steps of the spanning tree: a face, the one that it hangs on, the edge between them, and the end of it
    /// (0 or 1) from where the direction leads about which a positive angle turns the face.
    #[serde(serialize_with = "flat")]
    pub tree: Vec<[u32; 4]>,
    /// The motion of the crease groups.
    pub motion: SceneMotion,
    /// Shapes on the path, its knots among them; at least one, in the order of time.
    pub shapes: Vec<SceneShape>,
    /// The worst pair of faces.
    pub worst_pair: Option<ScenePair>,
    /// Numbers of the knots at which another phase of the motion begins.
    pub phases: Vec<usize>,
    /// Number of creases, virtual edges not counted.
    pub creases: usize,
    /// Largest deformation of the path, as a fraction of the edge length.
    pub max_deformation: f64,
    /// Largest gap of the path, as a fraction of the median edge.
    pub max_gap: f64,
    /// Largest closure residual of the path (dimensionless, about radians).
    pub max_closure: f64,
}

/// Crease groups at the knots of a path. Lists of groups have a row a knot, one behind the other.
#[derive(Clone, Debug, Serialize)]
pub struct SceneMotion {
    /// How they move between knots, by its name in files.
    pub interpolation: &'static str,
    /// Number of crease groups.
    pub groups: usize,
    /// Path time of the knots in seconds.
    pub times: Vec<f64>,
    /// Fold angles of the groups, radians.
    pub angles: Vec<f64>,
    /// Their rates, radians per second.
    pub rates: Vec<f64>,
    /// Weights of their half angles and the rates of these; empty unless the interpolation is homogeneous.
    #[serde(serialize_with = "flat")]
    pub weights: Vec<[f64; 2]>,
}

/// The sheet at one time, and what was measured there.
#[derive(Clone, Debug, Serialize)]
pub struct SceneShape {
    /// Path time in seconds.
    pub time: f64,
    /// Where each sheet is: the rotation of its root as a quaternion (w, x, y, z), and the place of the first
    /// vertex of the root's first triangle.
    #[serde(serialize_with = "rounded")]
    pub places: Vec<[f64; 7]>,
    /// Largest change of an edge's length, as a fraction of it.
    pub deformation: f64,
    /// Largest distance between a vertex's places by the faces round it, over the median edge.
    pub gap: f64,
    /// Largest closure residual (dimensionless, about radians).
    pub closure: f64,
    /// Smallest distance between faces that share no vertex, over the median edge; `None` where faces cross
    /// or that is not known.
    pub clearance: Option<f64>,
}

/// The two faces that come nearest to each other, or pass through each other.
#[derive(Clone, Debug, Serialize)]
pub struct ScenePair {
    /// The faces.
    pub faces: [u32; 2],
    /// Path time in seconds.
    pub time: f64,
    /// How far apart they are then, or how deep they cross, over the median edge.
    pub distance: f64,
    /// Whether they pass through each other.
    pub crosses: bool,
}

/// The page that shows `scene`.
///
/// # Panics
///
/// Never: a scene has only numbers, texts and lists, which JSON can always hold.
#[must_use]
pub fn page(scene: &Scene) -> String {
    let json = serde_json::to_string(scene).expect("a scene is plain data");
    // Only a `<` could end the script element that holds the scene.
    let scene = json.replace('<', "\\u003c");
    let parts = TEMPLATE.replacen("/*STYLE*/", STYLE, 1);
    let parts = parts.replacen("/*SCRIPT*/", &SCRIPTS.concat(), 1);
    parts.replacen(PLACEHOLDER, &scene, 1)
}

/// Writes tuples as one list of numbers.
fn flat<T: Serialize, S: Serializer, const N: usize>(
    list: &[[T; N]],
    to: S,
) -> Result<S::Ok, S::Error> {
    to.collect_seq(list.as_flattened())
}

/// The same as f32, which is half as long.
#[expect(clippy::cast_possible_truncation, reason = "rounding is the purpose")]
fn rounded<S: Serializer, const N: usize>(list: &[[f64; N]], to: S) -> Result<S::Ok, S::Error> {
    to.collect_seq(list.as_flattened().iter().map(|&x| x as f32))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn triangle(title: &str) -> Scene {
        Scene {
            title: title.to_owned(),
            vertices: vec![[0.0, 0.0], [1.0 / 3.0, 0.0], [0.0, 1.0]],
            vertex_faces: vec![Some(0); 3],
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
            }],
            worst_pair: None,
            phases: vec![],
            creases: 0,
            max_deformation: 0.0,
            max_gap: 0.0,
            max_closure: 0.0,
        }
    }

    /// The JSON in a page, as the browser's HTML parser would find it.
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
