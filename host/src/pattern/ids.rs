//! Newtype ids of the parts of a crease pattern: positions in its lists, which the types keep from being mixed up.

use serde::Serialize;

macro_rules! id {
    ($name:ident, $what:literal) => {
        #[doc = concat!("Names ", $what, " of a crease pattern: its position, from 0.")]
        #[derive(Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize)]
        pub struct $name(pub u32);

        impl $name {
            /// Makes the id of position `index`.
            ///
            /// # Panics
            /// If `index` is 2³² or more. No list of a crease pattern is so long: readers refuse such files.
            #[must_use]
            pub fn new(index: usize) -> Self {
                Self(u32::try_from(index).expect("fewer than 2^32 parts"))
            }

            /// Returns the position.
            #[must_use]
            pub fn index(self) -> usize {
                self.0 as usize
            }
        }

        impl core::fmt::Display for $name {
            fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
                self.0.fmt(f)
            }
        }
    };
}

id!(VertexId, "a vertex");
id!(EdgeId, "an edge");
id!(FaceId, "a face");
id!(CreaseId, "a crease");

/// Place of a closure condition.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ClosureSite {
    /// A real vertex.
    Vertex(VertexId),
    /// The hole whose boundary passes this vertex.
    Hole(VertexId),
}

impl core::fmt::Display for ClosureSite {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        match self {
            Self::Vertex(vertex) => write!(f, "vertex {vertex}"),
            Self::Hole(vertex) => write!(f, "the hole at vertex {vertex}"),
        }
    }
}
