//! Which faces pass through each other? Tests every pair: the chord that the plane of one face cuts from the other is
//! clipped against the first face (M. Cyrus, J. Beck).

use nalgebra::Vector3;

use crate::Sheet;
use crate::shape::normal;
use crate::sheet::sides;

/// Depth of a crossing of a sheet without rounding, over the median edge, up to which it counts as contact: twice the
/// planner's tolerance, because the planner measures depth in another way.
pub const CONTACT: f64 = 2e-6;

/// A face in space.
struct Panel {
    corners: Vec<Vector3<f64>>,
    normal: Vector3<f64>,
    low: Vector3<f64>,
    high: Vector3<f64>,
}

impl Sheet {
    /// Returns all pairs of faces that share no edge and pass through each other in this shape. Faces must be convex.
    #[must_use]
    pub fn crossings(&self, positions: &[Vector3<f64>]) -> Vec<[usize; 2]> {
        self.crossings_beyond(positions, 0.0, [0.0, CONTACT])
    }

    /// Returns the crossings of a sheet that these fold angles of the edges (radians) tear. A pair counts only if it
    /// crosses in these positions and in the sheet folded from every other face. Another root moves the faces, and a
    /// crossing that is absent for some roots is no deeper than the tear. A fold may also miss the rim of the layers
    /// along which it was drawn. Faces that share no vertex may therefore overlap by twice `tear`, the largest tear of
    /// the sheet all along its motion, over the median edge. An overlap up to `contact`, over the median edge, is contact.
    #[must_use]
    pub fn crossings_beyond_tears(
        &self,
        angles: &[f64],
        positions: &[Vector3<f64>],
        [tear, contact]: [f64; 2],
    ) -> Vec<[usize; 2]> {
        let gap = self.gap(&self.fold(angles));
        let mut crossings = self.crossings_beyond(positions, gap, [tear, contact]);
        for root in 0..self.faces.len() {
            if crossings.is_empty() {
                break;
            }
            let others = self.positions(&self.fold_from(root, angles));
            let others = self.crossings_beyond(&others, gap, [tear, contact]);
            crossings.retain(|pair| others.contains(pair));
        }
        crossings
    }

    /// Returns the crossings that are deeper than the sheet is torn. Faces that share a vertex may overlap by twice the
    /// gap (over the median edge): one of them is off by the gap at this vertex, and turned by about as much. Other
    /// faces may overlap by twice `tear`.
    fn crossings_beyond(
        &self,
        positions: &[Vector3<f64>],
        gap: f64,
        [tear, contact]: [f64; 2],
    ) -> Vec<[usize; 2]> {
        let unit = self.median_edge();
        let admitted = |a: usize, b: usize| {
            let meet = self.faces[a].iter().any(|v| self.faces[b].contains(v));
            (contact + 2.0 * if meet { gap } else { tear }) * unit
        };
        let panel = |face: &Vec<usize>| {
            let corners: Vec<_> = face.iter().map(|&v| positions[v]).collect();
            Panel {
                normal: normal(face, positions),
                low: corners.iter().fold(corners[0], |low, p| low.inf(p)),
                high: corners.iter().fold(corners[0], |high, p| high.sup(p)),
                corners,
            }
        };
        let panels: Vec<Panel> = self.faces.iter().map(panel).collect();
        let joined = |a: usize, b: usize| {
            let across = |side: &[Option<usize>; 2]| *side == [Some(a), Some(b)];
            self.sides
                .iter()
                .any(|side| across(side) || across(&[side[1], side[0]]))
        };
        let pairs = (0..panels.len()).flat_map(|b| (0..b).map(move |a| [a, b]));
        pairs
            .filter(|&[a, b]| {
                let (panel, other) = (&panels[a], &panels[b]);
                let contact = admitted(a, b);
                // One face alone would report a crossing too soon if an edge lies along an edge of the other face.
                let both = || panel.crosses(other, contact) && other.crosses(panel, contact);
                panel.near(other) && both() && !joined(a, b)
            })
            .collect()
    }
}

impl Panel {
    fn near(&self, other: &Self) -> bool {
        (0..3).all(|k| self.low[k] <= other.high[k] && other.low[k] <= self.high[k])
    }

    /// Returns `true` if the chord that the plane of `other` cuts from this panel runs through `other`, more than
    /// `contact` inside its sides. A panel that stays on one side of that plane, up to `contact`, has no chord.
    fn crosses(&self, other: &Self, contact: f64) -> bool {
        let height = |p: &Vector3<f64>| other.normal.dot(&(p - other.corners[0]));
        let heights: Vec<f64> = self.corners.iter().map(height).collect();
        let straddles =
            heights.iter().any(|&h| h > contact) && heights.iter().any(|&h| h < -contact);
        if !straddles {
            return false;
        }
        let mut chord = Vec::new();
        for [k, l] in sides(&(0..self.corners.len()).collect::<Vec<_>>()) {
            let (p, q) = (self.corners[k], self.corners[l]);
            if (heights[k] < 0.0) != (heights[l] < 0.0) {
                chord.push(p + (q - p) * (heights[k] / (heights[k] - heights[l])));
            }
        }
        let [from, to] = chord[..] else {
            return false;
        };
        // Clips the chord against every side of the other face (Cyrus and Beck).
        let (mut enters, mut leaves) = (0.0_f64, 1.0_f64);
        for [k, l] in sides(&(0..other.corners.len()).collect::<Vec<_>>()) {
            let (p, q) = (other.corners[k], other.corners[l]);
            let inward = other.normal.cross(&(q - p)).normalize();
            let [start, end] = [from, to].map(|x| inward.dot(&(x - p)) - contact);
            match (start > 0.0, end > 0.0) {
                (false, false) => return false,
                (false, true) => enters = enters.max(start / (start - end)),
                (true, false) => leaves = leaves.min(start / (start - end)),
                (true, true) => {}
            }
        }
        (leaves - enters) * (to - from).norm() > contact
    }
}
