//! Faces that pass through each other: every pair looked at, one chord at a time.

use nalgebra::Vector3;

use crate::Sheet;
use crate::shape::normal;
use crate::sheet::sides;

/// A crossing less deep than this part of the median edge is contact: twice what it is to the planner, which measures
/// depth otherwise.
const CONTACT: f64 = 2e-6;

/// A face in space.
struct Panel {
    corners: Vec<Vector3<f64>>,
    normal: Vector3<f64>,
    low: Vector3<f64>,
    high: Vector3<f64>,
}

impl Sheet {
    /// All pairs of faces that share no edge and pass through each other in this shape. Faces must
    /// be convex.
    #[must_use]
    pub fn crossings(&self, positions: &[Vector3<f64>]) -> Vec<[usize; 2]> {
        self.crossings_beyond(positions, 0.0, 0.0)
    }

    /// Those of a sheet that these fold angles of the edges (radians) tear: they are there in these positions, and
    /// whichever face it is folded from. That takes faces elsewhere, and what crosses from some faces only is no deeper
    /// than the tear. Nor is by how much a fold misses the rim of layers that it was drawn along: faces that meet nowhere may
    /// be in each other by twice the `tear` (over the median edge), the most that the sheet is torn by all along its motion.
    #[must_use]
    pub fn crossings_beyond_tears(
        &self,
        angles: &[f64],
        positions: &[Vector3<f64>],
        tear: f64,
    ) -> Vec<[usize; 2]> {
        let gap = self.gap(&self.fold(angles));
        let mut crossings = self.crossings_beyond(positions, gap, tear);
        for root in 0..self.faces.len() {
            if crossings.is_empty() {
                break;
            }
            let others = self.positions(&self.fold_from(root, angles));
            let others = self.crossings_beyond(&others, gap, tear);
            crossings.retain(|pair| others.contains(pair));
        }
        crossings
    }

    /// Those where faces that meet in a vertex may cross by twice the gap (over the median edge): one is off by the
    /// gap there, and turned by about as much. Others may by twice the `tear`.
    fn crossings_beyond(&self, positions: &[Vector3<f64>], gap: f64, tear: f64) -> Vec<[usize; 2]> {
        let unit = self.median_edge();
        let contact = |a: usize, b: usize| {
            let meet = self.faces[a].iter().any(|v| self.faces[b].contains(v));
            (CONTACT + 2.0 * if meet { gap } else { tear }) * unit
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
                let contact = contact(a, b);
                // Seen from one of them alone, an edge that lies along an edge of the other is a crossing sooner.
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

    /// Whether the chord that the plane of `other` cuts from this panel runs through `other` more
    /// than `contact` inside its sides. A panel on one side of that plane, up to `contact`, has none.
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
        // Cyrus and Beck: the part of the chord on the inner side of every side.
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
