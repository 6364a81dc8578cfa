//! Crease groups: creases whose fold angles have the same absolute value all along the path.

use serde::{Deserialize, Serialize};

use crate::Scalar;

/// Number of a crease group, and so of one unknown of the symmetry-reduced problem.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize, Deserialize)]
pub struct GroupId(pub u32);

impl GroupId {
    /// Returns the group's position in arrays over groups.
    #[inline]
    #[must_use]
    pub fn index(self) -> usize {
        self.0 as usize
    }
}

/// Membership of a crease in a group: the group and the sign.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Serialize, Deserialize)]
pub struct Membership {
    /// The group whose angle the crease follows.
    pub group: GroupId,
    /// `true` if the crease's fold angle is minus that of the group.
    pub negative: bool,
}

impl Membership {
    /// Returns the hinge of a code in files and messages: twice its group, and 1 more if it turns the opposite way.
    #[must_use]
    pub fn from_code(code: u32) -> Self {
        Self {
            group: GroupId(code >> 1),
            negative: code & 1 == 1,
        }
    }

    /// Returns the code of [`from_code`](Self::from_code).
    pub(crate) fn code(self) -> u32 {
        2 * self.group.0 + u32::from(self.negative)
    }

    /// Returns the fold angle of the crease (radians) for this angle of its group.
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

/// Writes the fold angle of every crease (radians) to `creases`, given those of the groups.
///
/// Returns `false`, leaving `creases` unspecified, if there is not one membership for each crease or a group is
/// missing.
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
