//! The sheet folded lazily: the pose of a face at a time is computed when it is first requested, with those on the way
//! to it, and kept for that time.

use foldpath_core::{HalfAngle, Membership};

use super::hinge::{Hinge, Product};
use super::pose::Pose;
use crate::pattern::{FaceId, SpanningTree};
use crate::util::time_cached::TimeCached;

/// A sheet that is folded at one time after the other.
#[derive(Clone, Debug, Default)]
pub(crate) struct LazyFolding {
    /// For each face but the roots the hinge of the spanning tree that reaches it.
    hinges: Vec<Option<Hinge>>,
    half_angles: TimeCached<HalfAngle<f64>>,
    poses: TimeCached<Pose>,
    way: Vec<Hinge>,
}

impl LazyFolding {
    /// Makes the folding along a tree of a sheet whose creases turn as these groups; creases without one stay flat.
    pub(crate) fn new(tree: &SpanningTree, memberships: &[Membership]) -> Self {
        let mut hinges = vec![None; tree.faces()];
        for step in tree.steps() {
            hinges[step.face.index()] = Some(Hinge::of(step, memberships));
        }
        Self {
            hinges,
            ..Self::default()
        }
    }

    /// Forgets all poses, as for another motion.
    pub(crate) fn forget(&mut self) {
        self.half_angles.forget();
        self.poses.forget();
    }

    /// Returns the pose of a face at a time, given half the angle of each group at that time.
    pub(crate) fn pose(
        &mut self,
        face: FaceId,
        time: u64,
        half_angle: impl Fn(usize) -> HalfAngle<f64>,
    ) -> Pose {
        let mut way = core::mem::take(&mut self.way);
        let mut at = face.index();
        let mut pose = loop {
            if let Some(pose) = self.poses.get(at, time) {
                break *pose;
            }
            let Some(hinge) = self.hinges[at] else {
                self.poses.set(at, time, Pose::identity());
                break Pose::identity();
            };
            way.push(hinge);
            at = hinge.from as usize;
        };
        while let Some(hinge) = way.pop() {
            let half_angles = &mut self.half_angles;
            let half_angle = |member: Membership| {
                let group = member.group.index();
                let known = half_angles.get(group, time).copied();
                known.unwrap_or_else(|| {
                    let half = half_angle(group);
                    half_angles.set(group, time, half);
                    half
                })
            };
            pose = hinge.cross(&pose, half_angle, Product::Plain);
            self.poses.set(hinge.to as usize, time, pose);
        }
        self.way = way;
        pose
    }
}
