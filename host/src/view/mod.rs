//! The page that shows a folding path: one HTML file that needs nothing else.
//!
//! `page.html` is the page with a placeholder; [`page`] puts the [`Scene`] there as JSON.

mod scene;

use serde::{Serialize, Serializer};

const TEMPLATE: &str = include_str!("page.html");
const PLACEHOLDER: &str = "/*SCENE*/";

/// What the page shows.
#[derive(Clone, Debug, Serialize)]
pub struct Scene {
    /// Name of the sheet.
    pub title: String,
    /// The flat sheet, in its own length unit.
    #[serde(serialize_with = "points")]
    pub vertices: Vec<[f64; 2]>,
    /// The faces as polygons, counter-clockwise seen from the front of the paper.
    pub faces: Vec<Vec<u32>>,
    /// Triangles that cover the faces, which need not be convex; counter-clockwise like them.
    pub triangles: Vec<[u32; 3]>,
    /// Every edge of the pattern.
    pub edges: Vec<SceneEdge>,
    /// Shapes on the path, its knots among them; at least one, in the order of time.
    pub knots: Vec<SceneKnot>,
    /// Number of knots of the path.
    pub path_knots: usize,
    /// Number of creases, virtual edges not counted.
    pub creases: usize,
    /// Number of crease groups.
    pub groups: usize,
    /// Largest deformation of the path, as a fraction of the edge length.
    pub max_deformation: f64,
    /// Largest gap of the path, as a fraction of the median edge.
    pub max_gap: f64,
    /// Largest closure residual of the path (dimensionless, about radians).
    pub max_closure: f64,
}

/// An edge of the pattern.
#[derive(Clone, Debug, Serialize)]
pub struct SceneEdge {
    /// Its two vertices.
    pub ends: [u32; 2],
    /// Its FOLD assignment: one of B, M, V, F, U, J, C.
    pub letter: String,
}

/// The sheet at one time.
#[derive(Clone, Debug, Serialize)]
pub struct SceneKnot {
    /// Path time in seconds.
    pub time: f64,
    /// The folded vertices in the order of [`Scene::vertices`], where the path has them. The page
    /// shows the flat pattern instead unless every knot has them.
    #[serde(serialize_with = "maybe_points")]
    pub vertices: Option<Vec<[f64; 3]>>,
    /// Fold angle of each group in degrees.
    #[serde(serialize_with = "numbers")]
    pub group_angles: Vec<f64>,
    /// Largest change of an edge's length, as a fraction of it.
    pub deformation: f64,
    /// Largest distance between a vertex's places by the faces round it, over the median edge.
    pub gap: f64,
    /// Largest closure residual (dimensionless, about radians).
    pub closure: f64,
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
    TEMPLATE.replacen(PLACEHOLDER, &json.replace('<', "\\u003c"), 1)
}

/// Writes points as one list of coordinates.
fn points<S: Serializer, const N: usize>(points: &[[f64; N]], to: S) -> Result<S::Ok, S::Error> {
    numbers(points.as_flattened(), to)
}

fn maybe_points<S: Serializer>(points: &Option<Vec<[f64; 3]>>, to: S) -> Result<S::Ok, S::Error> {
    match points {
        Some(points) => self::points(points, to),
        None => to.serialize_none(),
    }
}

/// Writes numbers as f32, because WebGL draws no finer and the file becomes half as long.
#[expect(clippy::cast_possible_truncation, reason = "rounding is the purpose")]
fn numbers<S: Serializer>(numbers: &[f64], to: S) -> Result<S::Ok, S::Error> {
    to.collect_seq(numbers.iter().map(|&x| x as f32))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn triangle(title: &str) -> Scene {
        Scene {
            title: title.to_owned(),
            vertices: vec![[0.0, 0.0], [1.0 / 3.0, 0.0], [0.0, 1.0]],
            faces: vec![vec![0, 1, 2]],
            triangles: vec![[0, 1, 2]],
            edges: vec![SceneEdge {
                ends: [0, 1],
                letter: "B".to_owned(),
            }],
            knots: vec![SceneKnot {
                time: 0.0,
                vertices: None,
                group_angles: vec![],
                deformation: 0.0,
                gap: 0.0,
                closure: 0.0,
            }],
            path_knots: 1,
            creases: 0,
            groups: 0,
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
    fn coordinates_are_written_flat_with_the_digits_of_f32() {
        let page = page(&triangle("x"));
        assert!(page.contains(r#""vertices":[0.0,0.0,0.33333334,0.0,0.0,1.0]"#));
        assert!(page.contains(r#""vertices":null"#));
    }
}
