//! Crease groups: creases whose fold angles have the same absolute value all along the path.

use serde::{Deserialize, Serialize};

use crate::Scalar;

/// Names a crease group, and with it one unknown of the symmetry-reduced problem.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize, Deserialize)]
pub struct GroupId(pub u32);

impl GroupId {
    /// Position in arrays over groups.
    #[inline]
    #[must_use]
    pub fn index(self) -> usize {
        self.0 as usize
    }
}

/// A crease's part in its group: the group and the sign.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Membership {
    /// The group whose angle the crease follows.
    pub group: GroupId,
    /// Whether it follows with the opposite sign.
    pub negative: bool,
}

impl Membership {
    /// The fold angle of the crease (radians), given that of its group.
    #[inline]
    #[must_use]
    pub fn apply<T: Scalar>(self, group_angle: T) -> T {
        if self.negative {
            -group_angle
        } else {
            group_angle
        }
    }
}

/// Writes the fold angle of every crease, given those of the groups (radians).
///
/// Returns `false`, leaving `creases` unspecified, if the lengths differ or a group is missing.
#[must_use]
pub fn expand<T: Scalar>(memberships: &[Membership], groups: &[T], creases: &mut [T]) -> bool {
    memberships.len() == creases.len()
        && memberships.iter().zip(creases).all(|(membership, crease)| {
            let angle = groups.get(membership.group.index());
            angle
                .map(|&angle| *crease = membership.apply(angle))
                .is_some()
        })
}
