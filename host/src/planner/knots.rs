//! Knots and paths of the whole sheet: configurations with times and rates.

use foldpath_core::{Curve, Interpolation, Membership, Node};
use nalgebra::Vector3;

/// One stored configuration of a path, with the errors measured there on the whole sheet.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Knot {
    /// Seconds since the start.
    pub time: f64,
    /// Fold angle of each group, radians.
    pub angles: Vec<f64>,
    /// Rate of each group, radians per second.
    pub rates: Vec<f64>,
    /// Weight of each group's homogeneous half angle and its rate per second; empty unless the
    /// interpolation is homogeneous.
    pub weights: Vec<[f64; 2]>,
    /// Folded positions of the vertices; empty if they were not kept.
    pub vertices: Vec<Vector3<f64>>,
    /// Largest closure residual of a real vertex or a hole, or twist of a hinge if that is larger.
    pub closure: f64,
    /// Largest relative change of length of an edge or virtual edge.
    pub deformation: f64,
    /// Largest gap, over the median edge.
    pub gap: f64,
    /// `true` if one phase of the motion ends here and another begins.
    pub ends_phase: bool,
}

/// A path of the whole sheet from flat to goal.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Path {
    /// For each crease its group and sign.
    pub memberships: Vec<Membership>,
    /// Interpolation between knots.
    pub interpolation: Interpolation,
    /// The knots, in the order of time.
    pub knots: Vec<Knot>,
}

impl Path {
    /// Returns, for each segment between two knots, the curve of each group.
    #[must_use]
    pub fn curves(&self) -> Vec<Vec<Curve<f64>>> {
        curves(self.interpolation, &self.knots).collect()
    }
}

/// Returns, for each segment between two knots, the curve of each group.
pub(super) fn curves(
    interpolation: Interpolation,
    knots: &[Knot],
) -> impl Iterator<Item = Vec<Curve<f64>>> {
    knots.windows(2).map(move |pair| {
        let span = pair[1].time - pair[0].time;
        let groups = 0..pair[0].angles.len();
        let curve = |group| {
            let [from, to] = [0, 1].map(|end| pair[end].node(group));
            Curve::between(interpolation, span, from, to)
        };
        groups.map(curve).collect()
    })
}

impl Knot {
    fn node(&self, group: usize) -> Node<f64> {
        Node {
            angle: self.angles[group],
            rate: self.rates[group],
            weight: self.weights.get(group).copied().unwrap_or([1.0, 0.0]),
        }
    }
}
