//! Cost of a hinge that is not where it is commanded to be.

use super::map::{FoldingMap, least_reach};
use super::shapes::STEP;
use crate::motion::Motion;
use crate::pattern::{SpanningTree, Step};
use crate::util::nan_max::larger;

/// Returns for each crease the gap of the sheet (median edges) for each radian by which the hinge alone is off the motion, at
/// the worst place of the motion.
///
/// The gap is what [`FoldingMap::rigidity`] and [`FoldingMap::parting`] measure along the pattern's own tree, to first order:
/// an error of the angle of a hinge on the tree turns all faces behind the hinge about its axis, away from the faces that
/// they meet across loops. One of a hinge off the tree turns the smaller of its two faces away from it. The motion is looked at
/// at its knots, and between them so often that no hinge turns by much more than [`STEP`].
///
/// Cost: for each place, the lengths of all loops of the tree, in faces.
#[must_use]
pub fn hinge_gaps(motion: &Motion) -> Vec<f64> {
    let (pattern, tree) = (&motion.pattern, motion.pattern.tree());
    let ways = Ways::new(tree);
    let mut gaps = vec![0.0; pattern.creases().len()];
    let mut map = FoldingMap::flat(pattern);
    let places = motion.with_steps(STEP);
    for place in 0..places.knots.len() {
        map.fold(pattern, tree, &places.crease_angles(place));
        for step in tree.loops() {
            let part = least_reach(pattern, step);
            if let Some(crease) = step.crease {
                gaps[crease.index()] = larger(gaps[crease.index()], part);
            }
            let ends = pattern.edge(step.edge).ends.map(|end| map.vertex(end));
            for passed in ways.around(step) {
                if let Some(crease) = passed.crease {
                    let pose = &map.poses()[passed.parent.index()];
                    let (pivot, axis) = (pose.apply(passed.pivot), pose.turn(passed.axis));
                    let [a, b] = ends.map(|end| axis.cross(&(end - pivot)).norm());
                    let gap = &mut gaps[crease.index()];
                    *gap = larger(*gap, larger(part, larger(a, b)));
                }
            }
        }
    }
    let edge = pattern.median_edge();
    gaps.iter().map(|gap| gap / edge).collect()
}

/// Ways along a tree between faces.
struct Ways<'a> {
    /// Step by which each face is reached; `None` for a root.
    by: Vec<Option<&'a Step>>,
    /// Number of steps from the root to each face.
    depth: Vec<usize>,
}

impl<'a> Ways<'a> {
    fn new(tree: &'a SpanningTree) -> Self {
        let mut this = Self {
            by: vec![None; tree.faces()],
            depth: vec![0; tree.faces()],
        };
        for step in tree.steps() {
            this.by[step.face.index()] = Some(step);
            this.depth[step.face.index()] = this.depth[step.parent.index()] + 1;
        }
        this
    }

    /// Iterates over the steps of the tree between the two faces of a step off it.
    fn around(&self, off: &Step) -> impl Iterator<Item = &'a Step> {
        let mut ends = [off.face, off.parent];
        core::iter::from_fn(move || {
            let [a, b] = ends;
            if a == b {
                return None;
            }
            let deeper = usize::from(self.depth[b.index()] > self.depth[a.index()]);
            let step = self.by[ends[deeper].index()]?;
            ends[deeper] = step.parent;
            Some(step)
        })
    }
}
