//! The deviation of a configuration from folding the sheet rigidly, in three figures.

use crate::util::nan_max::larger;

/// Deviation of a configuration from folding the sheet rigidly.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Rigidity {
    /// Largest relative change of length of an edge or a virtual edge.
    pub deformation: f64,
    /// Largest distance between two positions that faces give the same vertex, over the median edge.
    pub gap: f64,
    /// Largest rotation, in radians, by which two faces at an edge deviate from its fold angle. Round a vertex
    /// this is its misclosure; positions alone do not show it if both ends of the edge coincide.
    pub twist: f64,
}

impl Rigidity {
    /// Returns the largest of the three.
    #[must_use]
    pub fn worst(self) -> f64 {
        larger(larger(self.deformation, self.gap), self.twist)
    }

    /// Returns the larger value of both, for each of the three.
    #[must_use]
    pub fn worse(self, other: Self) -> Self {
        Self {
            deformation: larger(self.deformation, other.deformation),
            gap: larger(self.gap, other.gap),
            twist: larger(self.twist, other.twist),
        }
    }
}
