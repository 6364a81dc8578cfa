//! The step by which every folding places a face: from the face before, across the edge between the two.

use foldpath_core::{HalfAngle, Membership, Rotation};
use nalgebra::Vector2;

use super::pose::Pose;
use crate::pattern::{CreaseId, Step};

/// An edge across which a face is placed from another one.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Hinge {
    /// Position of the pose of the face before.
    pub(crate) from: u32,
    /// Position of the pose of the face beyond.
    pub(crate) to: u32,
    /// Group and sign of the crease; `None` if the edge stays flat.
    pub(crate) turns: Option<Membership>,
    /// A point of the edge in the flat sheet.
    pub(crate) pivot: Vector2<f64>,
    /// Unit direction along the edge about which a positive (valley) fold angle turns the face beyond.
    pub(crate) axis: Vector2<f64>,
}

/// Formula for the product of a face's rotation and that about a crease. All formulas are equal, but for rounding.
#[derive(Clone, Copy, Debug)]
pub(crate) enum Product {
    /// Without the terms that are 0, and renormalised: lengths stay 1 along any number of faces.
    Measured,
    /// The general product, renormalised.
    Renormalised,
    /// The general product alone.
    Plain,
}

impl Product {
    /// Returns the pose of the face beyond a crease at this fold angle, given that of the face before. The crease runs
    /// through `pivot` along `axis` in the flat sheet.
    #[inline]
    pub(super) fn cross(
        self,
        before: &Pose,
        pivot: Vector2<f64>,
        axis: Vector2<f64>,
        half: HalfAngle<f64>,
    ) -> Pose {
        let general = || before.r_wf * Rotation::about_crease(half, axis.into());
        let r_wf = match self {
            Self::Measured => before.r_wf.across_crease(half, axis.into()).renormalised(),
            Self::Renormalised => general().renormalised(),
            Self::Plain => general(),
        };
        // The pivot stays where the face before takes it.
        Pose::about(r_wf, pivot, before.apply(pivot))
    }
}

impl Hinge {
    /// Returns the hinge that a step of a spanning tree crosses. `memberships` has group and sign of each crease;
    /// creases without one stay flat.
    pub(crate) fn of(step: &Step, memberships: &[Membership]) -> Self {
        let member = |crease: CreaseId| memberships.get(crease.index()).copied();
        Self {
            from: step.parent.0,
            to: step.face.0,
            turns: step.crease.and_then(member),
            pivot: step.pivot,
            axis: step.axis,
        }
    }

    /// Returns the pose of the face beyond, given that of the face before, and half the angle of the group that turns.
    #[inline]
    pub(crate) fn cross(
        &self,
        before: &Pose,
        half_angle: impl FnOnce(Membership) -> HalfAngle<f64>,
        product: Product,
    ) -> Pose {
        let Some(member) = self.turns else {
            return *before;
        };
        let half = half_angle(member).signed(member.negative);
        product.cross(before, self.pivot, self.axis, half)
    }

    /// Returns the group of the crease, if it turns.
    pub(crate) fn group(&self) -> Option<usize> {
        self.turns.map(|member| member.group.index())
    }
}

/// Places all faces beyond these hinges by half the angles of the groups; groups without one are flat. Each hinge leads
/// from a face that is placed already. Cost: O(hinges).
#[inline]
pub(crate) fn place_all(
    poses: &mut [Pose],
    hinges: &[Hinge],
    half_angles: &[HalfAngle<f64>],
    product: Product,
) {
    for hinge in hinges {
        let before = &poses[hinge.from as usize];
        let half_angle = |member| half_angle(half_angles, member);
        poses[hinge.to as usize] = hinge.cross(before, half_angle, product);
    }
}

/// Returns half the angle of a crease's group; flat if the group has none.
#[inline]
pub(crate) fn half_angle(half_angles: &[HalfAngle<f64>], member: Membership) -> HalfAngle<f64> {
    let half = half_angles.get(member.group.index());
    half.copied().unwrap_or_default()
}
