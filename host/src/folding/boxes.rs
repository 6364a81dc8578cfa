//! Boxes round the flat and the folded sheet, whichever way the sheet lies.

use nalgebra::{Matrix3, SymmetricEigen, Vector2, Vector3};

use crate::pattern::CreasePattern;
use crate::util::hull::convex_hull;

/// Number of panels, the largest ones, on which a box may lie.
const MAX_PANELS: usize = 64;
/// Height over the longest side below which boxes of no height are compared by their other sides.
const FLAT_RATIO: f64 = 1e-6;
/// Difference of the components of two unit normals that are one.
const SAME_NORMAL: f64 = 1e-6;

/// Returns the sides of the smallest rectangle round points, the longer one first; zeros without points.
///
/// One of its sides lies on a side of the convex hull (H. Freeman and R. Shapira, "Determining the minimum-area encasing
/// rectangle for an arbitrary closed curve", 1975). Cost: O(n log n) for n points, and the square of the corners of the hull.
#[must_use]
pub fn smallest_rectangle(points: &[Vector2<f64>]) -> [f64; 2] {
    let hull = convex_hull(points.to_vec(), 0.0);
    let sides = hull.iter().zip(hull.iter().cycle().skip(1));
    let directions = sides.filter_map(|(a, b)| (b - a).try_normalize(0.0));
    let rectangles = directions.map(|along| {
        let across = Vector2::new(-along.y, along.x);
        [along, across].map(|axis| extent(hull.iter().map(|corner| corner.dot(&axis))))
    });
    let area = |sides: &[f64; 2]| sides[0] * sides[1];
    let least = rectangles.min_by(|a, b| area(a).total_cmp(&area(b)));
    let [a, b] = least.unwrap_or_default();
    [a.max(b), a.min(b)]
}

/// Returns the sides of a small box round folded vertices, the longest first: the smallest of those that lie on one of the 64
/// largest panels or along a principal axis of the vertices. A box is at most as large as that along the principal axes.
#[must_use]
pub fn small_box(pattern: &CreasePattern, places: &[Vector3<f64>]) -> [f64; 3] {
    let boxes = heights(pattern, places).into_iter().map(|height| {
        let across = height.cross(&Vector3::ith(height.iamin(), 1.0)).normalize();
        let along = height.cross(&across);
        let flat = places
            .iter()
            .map(|at| Vector2::new(at.dot(&across), at.dot(&along)));
        let [a, b] = smallest_rectangle(&flat.collect::<Vec<_>>());
        let mut sides = [a, b, extent(places.iter().map(|at| at.dot(&height)))];
        sides.sort_by(|a, b| b.total_cmp(a));
        sides
    });
    let size = |[a, b, c]: &[f64; 3]| {
        let least = FLAT_RATIO * a;
        a * b.max(least) * c.max(least)
    };
    let least = boxes.min_by(|a, b| size(a).total_cmp(&size(b)));
    least.unwrap_or_default()
}

/// Returns unit vectors: the principal axes of points, and the normals of large panels.
fn heights(pattern: &CreasePattern, places: &[Vector3<f64>]) -> Vec<Vector3<f64>> {
    #[allow(clippy::cast_precision_loss, reason = "a number of vertices")]
    let middle = places.iter().sum::<Vector3<f64>>() / places.len().max(1) as f64;
    let spread = places
        .iter()
        .map(|at| (at - middle) * (at - middle).transpose());
    let axes = SymmetricEigen::new(spread.sum::<Matrix3<f64>>()).eigenvectors;
    let mut found: Vec<Vector3<f64>> = axes.column_iter().map(Into::into).collect();
    let normals = pattern.faces().iter().map(|face| {
        let corner = |k: usize| places[face[k % face.len()].index()] - middle;
        let parts = (0..face.len()).map(|k| corner(k).cross(&corner(k + 1)));
        parts.sum::<Vector3<f64>>()
    });
    let mut normals: Vec<Vector3<f64>> = normals.collect();
    normals.sort_by(|a, b| b.norm_squared().total_cmp(&a.norm_squared()));
    for normal in normals.iter().take(MAX_PANELS) {
        let Some(normal) = normal.try_normalize(0.0) else {
            continue;
        };
        let is_known = |one: &Vector3<f64>| one.cross(&normal).amax() < SAME_NORMAL;
        if !found.iter().any(is_known) {
            found.push(normal);
        }
    }
    found
}

/// Returns the difference of the largest and the smallest of some numbers.
fn extent(numbers: impl Iterator<Item = f64>) -> f64 {
    let ends = numbers.fold(None, |ends: Option<[f64; 2]>, number| {
        let [least, most] = ends.unwrap_or([number; 2]);
        Some([least.min(number), most.max(number)])
    });
    ends.map_or(0.0, |[least, most]| most - least)
}

#[cfg(test)]
mod tests {
    use super::{small_box, smallest_rectangle};
    use crate::folding::FoldingMap;
    use crate::generate::Miura;
    use crate::pattern::{CreasePattern, Drawing, DrawnEdge};
    use nalgebra::{Rotation2, Rotation3, Vector2, Vector3};

    #[test]
    fn rectangles_do_not_depend_on_how_the_sheet_lies() {
        let corners = [[0.0, 0.0], [3.0, 0.0], [3.0, 2.0], [1.0, 1.5], [0.0, 2.0]];
        for turn in [0.0, 0.3, 1.0, 2.5] {
            let points = corners.map(|[x, y]| Rotation2::new(turn) * Vector2::new(x, y));
            let [a, b] = smallest_rectangle(&points);
            assert!(
                (a - 3.0).abs() < 1e-12 && (b - 2.0).abs() < 1e-12,
                "{a} {b}"
            );
        }
        // Points in a line, one point, none.
        let line = [0.0, 1.0, 5.0].map(|x| Vector2::new(x, 2.0 * x));
        let [length, width] = smallest_rectangle(&line);
        assert!((length - 125.0_f64.sqrt()).abs() < 1e-12 && width < 1e-12);
        assert!(
            smallest_rectangle(&line[..1])
                .iter()
                .all(|side| *side <= 0.0)
        );
        assert!(smallest_rectangle(&[]).iter().all(|side| *side <= 0.0));
    }

    /// The closed form of M. Schenk and S. Guest, "Geometry of Miura-folded metamaterials", 2013: panels with sides of length 1
    /// and sector angle g are inclined by t, half the fold angle of the zigzag creases.
    #[test]
    fn the_box_of_a_miura_is_that_of_its_closed_form() {
        let g = 60_f64.to_radians();
        for fold in [0.3, 0.7, 0.95] {
            let miura = Miura {
                rows: 6,
                columns: 8,
                sector_angle: g,
                fold,
            };
            let pattern = CreasePattern::new(miura.drawing().unwrap()).unwrap();
            let goals = pattern.creases().iter();
            let angles: Vec<f64> = goals
                .map(|&edge| pattern.edge(edge).goal.unwrap())
                .collect();
            let map = FoldingMap::new(&pattern, pattern.tree(), &angles);
            let t = fold * core::f64::consts::FRAC_PI_2;
            let height = t.sin() * g.sin();
            let slope = t.cos() * g.tan();
            let offset = 1.0 / (1.0 + slope * slope).sqrt();
            let width = 8.0 * (1.0 - height * height).sqrt() + offset;
            let mut expected = [width, 6.0 * slope * offset, height];
            expected.sort_by(|a, b| b.total_cmp(a));
            for turn in [Vector3::zeros(), Vector3::new(0.4, -1.0, 2.0)] {
                let places = map.vertices().iter();
                let places: Vec<_> = places.map(|at| Rotation3::new(turn) * at).collect();
                let sides = small_box(&pattern, &places);
                for (side, expected) in sides.iter().zip(expected) {
                    assert!(
                        (side - expected).abs() < 1e-9,
                        "{fold}: {sides:?} {expected:?}"
                    );
                }
            }
        }
    }

    /// A cube that is folded from its net lies on its sides, although its principal axes are any.
    #[test]
    fn the_box_of_a_cube_is_the_cube() {
        let at = [
            [1, 0],
            [2, 0],
            [0, 1],
            [1, 1],
            [2, 1],
            [3, 1],
            [4, 1],
            [0, 2],
            [1, 2],
            [2, 2],
            [3, 2],
            [4, 2],
            [1, 3],
            [2, 3],
        ];
        let vertices = at.map(|[x, y]| Vector2::new(f64::from(x), f64::from(y)));
        let creases = [[3, 4], [3, 8], [4, 9], [5, 10], [8, 9]];
        let border = [
            [0, 1],
            [1, 4],
            [4, 5],
            [5, 6],
            [6, 11],
            [11, 10],
            [10, 9],
            [9, 13],
            [13, 12],
            [12, 8],
            [8, 7],
            [7, 2],
            [2, 3],
            [3, 0],
        ];
        let valley = |ends| DrawnEdge {
            ends,
            letter: crate::pattern::Letter::Valley,
            goal: Some(core::f64::consts::FRAC_PI_2),
        };
        let drawing = Drawing {
            vertices: vertices.to_vec(),
            edges: creases
                .map(valley)
                .into_iter()
                .chain(border.map(DrawnEdge::boundary))
                .collect(),
            faces: None,
        };
        let pattern = CreasePattern::new(drawing).unwrap();
        let angles = vec![core::f64::consts::FRAC_PI_2; pattern.creases().len()];
        let map = FoldingMap::new(&pattern, pattern.tree(), &angles);
        let turned: Vec<_> = map
            .vertices()
            .iter()
            .map(|at| Rotation3::new(Vector3::new(1.0, 0.2, -0.7)) * at)
            .collect();
        let sides = small_box(&pattern, &turned);
        assert!(
            sides.iter().all(|side| (side - 1.0).abs() < 1e-9),
            "{sides:?}"
        );
    }
}
