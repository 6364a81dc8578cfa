//! Do faces that lie flat on each other leave through each other? Follows a point of one face relative to the other.

use std::collections::HashMap;

use nalgebra::Vector3;

use crate::sheet::sides;
use crate::{Pose, Sheet};

/// Distance from a face, over the median edge, up to which a point lies on the face. Farther points are on one side.
const CONTACT: f64 = 1e-6;
/// Largest sine of the angle between faces that lie flat on each other.
const PARALLEL: f64 = 1e-4;
/// Distance from the sides of a face, and least width of what two faces have in common, over the median edge, from which on
/// they lie on each other.
const INSIDE: f64 = 1e-3;

impl Sheet {
    /// Returns the pairs of faces of which the second came to lie flat on the first from one side and left on the other
    /// side, in a motion through these shapes, each with the index of the shape that shows it. Faces must be convex.
    /// For every shape in which faces touch, `shapes` must hold one shortly before and one shortly after it. `torn`:
    /// tear of the sheet, over the median edge; the positions of layers are only known to this.
    #[must_use]
    pub fn passed(&self, shapes: &[Vec<Pose>], torn: f64) -> Vec<([usize; 2], usize)> {
        let contact = (CONTACT + torn) * self.median_edge();
        // For each pair that touches: a point of the second face, and `true` if that face came from above the first.
        let mut came: HashMap<[usize; 2], (Vector3<f64>, bool)> = HashMap::new();
        let mut passed = Vec::new();
        for (index, shape) in shapes.iter().enumerate() {
            let height =
                |shape: &[Pose], [a, b]: [usize; 2], point| shape[a].seen(shape[b].apply(point)).z;
            let normals: Vec<_> = shape.iter().map(Pose::normal).collect();
            let count = normals.len();
            let pairs = (0..count).flat_map(|a| (0..count).map(move |b| [a, b]));
            let parallel =
                |[a, b]: &[usize; 2]| normals[*a].cross(&normals[*b]).norm() < PARALLEL + torn;
            let flat = pairs.filter(|pair| pair[0] != pair[1] && parallel(pair));
            let flat = flat.filter_map(|pair| Some((pair, self.common(shape, pair, contact)?)));
            let flat: HashMap<_, _> = flat.collect();
            came.retain(|&pair, &mut (point, above)| {
                let height = height(shape, pair, point);
                let left = !flat.contains_key(&pair) && height.abs() > contact;
                if left && (height > 0.0) != above {
                    passed.push((pair, index));
                }
                !left
            });
            for (pair, point) in flat {
                let before = shapes[..index].iter().rev();
                let mut heights = before.map(|before| height(before, pair, point));
                if !came.contains_key(&pair)
                    && let Some(height) = heights.find(|height| height.abs() > contact)
                {
                    came.insert(pair, (point, height > 0.0));
                }
            }
        }
        passed.sort_by_key(|&(pair, index)| (index, pair));
        passed
    }

    /// Returns a point of the second face, in the flat sheet, that lies on the first.
    fn common(&self, shape: &[Pose], [a, b]: [usize; 2], contact: f64) -> Option<Vector3<f64>> {
        let unit = self.median_edge();
        let corners = || self.faces[b].iter().map(|&v| self.flat[v]);
        let seen = |point| shape[a].seen(shape[b].apply(point));
        if corners().any(|corner| seen(corner).z.abs() > contact) {
            return None;
        }
        let mut common: Vec<_> = corners().collect();
        for [p, q] in sides(&self.faces[a]) {
            let way = (self.flat[q] - self.flat[p]).normalize();
            let inside =
                |point: &Vector3<f64>| way.cross(&(seen(*point) - self.flat[p])).z - INSIDE * unit;
            common = cut(&common, inside);
        }
        let first = *common.first()?;
        let (mut area, mut around) = (0.0, 0.0);
        for (from, to) in common.iter().zip(common.iter().cycle().skip(1)) {
            area += (from - first).cross(&(to - first)).z / 2.0;
            around += (to - from).norm();
        }
        #[allow(clippy::cast_precision_loss, reason = "a few corners")]
        let middle = common.iter().sum::<Vector3<f64>>() / common.len() as f64;
        (area.abs() > INSIDE * unit * around).then_some(middle)
    }
}

/// Returns the part of a polygon on which a linear function is positive.
fn cut(polygon: &[Vector3<f64>], inside: impl Fn(&Vector3<f64>) -> f64) -> Vec<Vector3<f64>> {
    let mut part = Vec::new();
    for (from, to) in polygon.iter().zip(polygon.iter().cycle().skip(1)) {
        let [start, end] = [from, to].map(&inside);
        if start > 0.0 {
            part.push(*from);
        }
        if start * end < 0.0 {
            part.push(from + (to - from) * (start / (start - end)));
        }
    }
    part
}
