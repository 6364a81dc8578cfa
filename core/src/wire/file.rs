//! A trajectory file as items, read in place from flash: no copy of the path is in memory.

use crate::trajectory_file::TrajectoryFile;
use crate::wire::path::{Content, Items};
use crate::{GroupLimits, Interpolation, Membership, Node};

/// The items of a trajectory file, from a place on its path: the same as those of
/// [`PathItems`](crate::wire::path::PathItems) of the same path, with the same number of the path.
pub type FileItems<'a> = Items<TrajectoryFile<'a>>;

impl<'a> FileItems<'a> {
    /// Creates the items of a file from the beginning of its path on. Returns `None` if there are more than 2¹⁴ groups,
    /// hinges or spokes, or no knot.
    #[must_use]
    pub fn new(file: TrajectoryFile<'a>) -> Option<Self> {
        let items = Self::of(file, file.closure(), file.path())?;
        Some(items.with_most_lag(file.most_lag()))
    }
}

impl Content for TrajectoryFile<'_> {
    fn knots(&self) -> usize {
        self.len()
    }

    fn limits(&self) -> impl Iterator<Item = GroupLimits> {
        (0..self.groups()).filter_map(|group| self.limits(group))
    }

    fn hinges(&self) -> impl Iterator<Item = Membership> {
        self.memberships()
    }

    fn spokes(&self) -> impl Iterator<Item = (u32, [f32; 2])> {
        let spokes = self.spokes();
        spokes.map(|(spoke, last)| (spoke.code(last), spoke.direction))
    }

    fn interpolation(&self) -> Interpolation {
        self.interpolation()
    }

    fn groups(&self) -> usize {
        self.groups()
    }

    fn span(&self, knot: usize) -> Option<f32> {
        self.span(knot)
    }

    fn node(&self, knot: usize, group: usize) -> Option<Node<f32>> {
        self.node(knot, group)
    }
}
