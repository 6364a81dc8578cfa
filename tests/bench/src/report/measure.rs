//! Measures of paths: deformation and gap at knots and between them, and once by other formulas than the planners'.

use foldpath::folding::{FoldingMap, Rigidity, SpanningTree};
use foldpath::motion::Motion;
use foldpath::pattern::CreasePattern;
use foldpath_core::Membership;
use nalgebra::{Matrix4, Vector3, Vector4};

/// Largest deformation and gap at some configurations.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Deviation {
    /// Largest relative change of length of an edge or virtual edge.
    pub deformation: f64,
    /// Largest distance between two positions that faces give the same vertex, over the median edge.
    pub gap: f64,
}

/// Number of steps from a knot to the next.
const PLACES: usize = 8;

/// Returns the largest deviation at these configurations of the groups.
#[must_use]
pub fn between_knots<'c>(
    pattern: &CreasePattern,
    tree: &SpanningTree,
    memberships: &[Membership],
    configurations: impl IntoIterator<Item = &'c Vec<f64>>,
) -> Deviation {
    let mut map = FoldingMap::flat(pattern);
    let mut worst = Rigidity::default();
    for angles in configurations {
        map.fold_groups(pattern, tree, memberships, angles);
        worst = worst.worse(map.rigidity(pattern, tree));
    }
    Deviation {
        deformation: worst.deformation,
        gap: worst.gap,
    }
}

/// Returns configurations on the straight lines between knots, without the knots.
#[must_use]
pub fn straight_between(knots: &[Vec<f64>]) -> Vec<Vec<f64>> {
    let places = |pair: &[Vec<f64>]| {
        let (from, to) = (pair[0].clone(), pair[1].clone());
        (1..PLACES).map(move |place| {
            let s = part(place);
            from.iter().zip(&to).map(|(a, b)| a + s * (b - a)).collect()
        })
    };
    knots.windows(2).flat_map(places).collect()
}

/// Returns configurations between the knots of a path whose motion is known.
pub(super) fn motion_between(motion: &Motion) -> Vec<Vec<f64>> {
    let places = (0..motion.segments()).flat_map(|segment| {
        (1..PLACES).map(move |place| {
            let curves = motion.curves(segment);
            curves.map(|curve| curve.angle(part(place))).collect()
        })
    });
    places.collect()
}

#[allow(clippy::cast_precision_loss, reason = "small counts")]
fn part(place: usize) -> f64 {
    place as f64 / PLACES as f64
}

/// Returns the deviation with every crease at its fold angle (radians), by the report's own formulas: the product of
/// 4x4 folding matrices A B C B⁻¹ A⁻¹ along the tree for each face, and all pairs of faces at each vertex. Slow. Shares
/// nothing with [`FoldingMap`] but the tree, and the choice of the face that places a vertex.
#[must_use]
pub fn fold_by_matrices(
    pattern: &CreasePattern,
    tree: &SpanningTree,
    fold_angles: &[f64],
) -> Deviation {
    let mut maps = vec![Matrix4::<f64>::identity(); pattern.faces().len()];
    for step in tree.steps() {
        let angle = step
            .crease
            .map_or(0.0, |crease| fold_angles[crease.index()]);
        let chi = about_line(step.pivot.push(0.0), step.axis.y.atan2(step.axis.x), angle);
        maps[step.face.index()] = maps[step.parent.index()] * chi;
    }
    let place = |face: usize, vertex: usize| {
        let flat = pattern.vertices()[vertex];
        (maps[face] * Vector4::new(flat.x, flat.y, 0.0, 1.0)).xyz()
    };
    let mut deviation = Deviation::default();
    let mut places = Vec::with_capacity(pattern.vertices().len());
    for (vertex, faces) in pattern.corners().iter().enumerate() {
        let at: Vec<Vector3<f64>> = faces.iter().map(|f| place(f.index(), vertex)).collect();
        for (index, a) in at.iter().enumerate() {
            for b in &at[..index] {
                let gap = (a - b).norm() / pattern.median_edge();
                deviation.gap = deviation.gap.max(gap);
            }
        }
        places.push(at.first().copied().unwrap_or_default());
    }
    for [a, b] in pattern.struts() {
        let folded = (places[b.index()] - places[a.index()]).norm();
        let flat = pattern.length([a, b]);
        deviation.deformation = deviation.deformation.max((folded - flat).abs() / flat);
    }
    deviation
}

/// Returns A B C B⁻¹ A⁻¹: a rotation by `fold` about the line through a point of the sheet with the plane angle
/// `alpha`.
fn about_line(point: Vector3<f64>, alpha: f64, fold: f64) -> Matrix4<f64> {
    let a = Matrix4::new_translation(&point);
    let a_back = Matrix4::new_translation(&-point);
    let b = Matrix4::from_euler_angles(0.0, 0.0, alpha);
    let c = Matrix4::from_euler_angles(fold, 0.0, 0.0);
    a * b * c * b.transpose() * a_back
}
