//! A trajectory file as items, read in place from flash: no copy of the path is in memory.

use crate::follower::FollowerPosition;
use crate::trajectory_file::TrajectoryFile;
use crate::wire::message::{Item, SheetHead};
use crate::wire::path::{self, Content};
use crate::wire::sender::Source;
use crate::{GroupLimits, Membership, Node};

/// The items of a trajectory file, from a place on its path: the same as those of
/// [`PathItems`](crate::wire::path::PathItems) of the same path, with the same number of the path.
#[derive(Clone, Copy, Debug)]
pub struct FileItems<'a> {
    head: SheetHead,
    file: TrajectoryFile<'a>,
    first: usize,
}

impl<'a> FileItems<'a> {
    /// Creates the items of a file from the beginning of its path on. Returns `None` if there are more than 2¹⁴ groups,
    /// hinges or spokes, or no knot. Cost: a checksum over all numbers of the file.
    #[must_use]
    pub fn new(file: TrajectoryFile<'a>) -> Option<Self> {
        let small = |count: usize| u16::try_from(count).ok().filter(|&count| count <= 1 << 14);
        let head = SheetHead {
            interpolation: file.interpolation(),
            groups: small(file.groups())?,
            hinges: small(file.hinges())?,
            spokes: small(file.spokes().count())?,
            closure: file.closure(),
            path: 0,
            place: FollowerPosition::default(),
        };
        let mut items = Self {
            head,
            file,
            first: 0,
        };
        if file.is_empty() {
            return None;
        }
        items.head.path = path::identity(&items);
        Some(items)
    }

    /// Returns the items from another place on; `None` if that place is not on the path.
    #[must_use]
    pub fn at(self, place: FollowerPosition<f32>) -> Option<Self> {
        let head = SheetHead { place, ..self.head };
        let first = usize::try_from(place.knot).ok()?;
        (first < self.file.len()).then_some(Self {
            head,
            first,
            ..self
        })
    }

    /// Returns the number that tells this path from others, see [`SheetHead::path`].
    #[must_use]
    pub fn identity(&self) -> u32 {
        self.head.path
    }

    /// Returns the file.
    #[must_use]
    pub fn file(&self) -> &TrajectoryFile<'a> {
        &self.file
    }
}

impl Content for FileItems<'_> {
    fn head(&self) -> &SheetHead {
        &self.head
    }

    fn knots(&self) -> usize {
        self.file.len()
    }

    fn limits(&self) -> impl Iterator<Item = GroupLimits> {
        (0..self.file.groups()).filter_map(|group| self.file.limits(group))
    }

    fn hinges(&self) -> impl Iterator<Item = Membership> {
        self.file.memberships()
    }

    fn spokes(&self) -> impl Iterator<Item = (u32, [f32; 2])> {
        let spokes = self.file.spokes();
        spokes.map(|(spoke, last)| (spoke.code(last), spoke.direction))
    }

    fn time(&self, knot: usize) -> Option<f32> {
        self.file.time(knot)
    }

    fn node(&self, knot: usize, group: usize) -> Option<Node<f32>> {
        self.file.node(knot, group)
    }
}

impl Source for FileItems<'_> {
    fn item<'b>(&self, index: u64, scratch: &'b mut [u8]) -> Option<Item<'b>> {
        path::item(self, self.first, index, scratch)
    }
}
