//! A path and its sheet as items for the line: encodes and decodes the bytes of their numbers.

use core::num::NonZero;

use crate::follower::FollowerPosition;
use crate::trajectory::TrajectoryView;
use crate::wire::message::{Item, SetpointBytes, SheetHead};
use crate::wire::sender::Source;
use crate::{
    GroupLimits, Interpolation, Membership, Node, Spoke, StarView, StarsView, checksum_on,
};

/// Number of bytes of the limits of a group and of a spoke.
const LIMITS_BYTES: usize = 16;
const SPOKE_BYTES: usize = 10;
/// Largest number of bytes of limits, hinges and spokes in an item: 8 groups, whole codes and 12 spokes.
const MAX_LIMITS_BYTES: usize = 8 * LIMITS_BYTES;
const MAX_HINGES_BYTES: usize = 128;
const MAX_SPOKES_BYTES: usize = 12 * SPOKE_BYTES;

/// Largest number of bytes of the groups of a setpoint in an item: 26 groups, or 13 with weights. All items of a
/// setpoint but the last have as many.
pub const NODES_BYTES: usize = 208;

/// Returns the number of items of a setpoint of `groups` groups: at least 1.
#[must_use]
pub fn pieces(interpolation: Interpolation, groups: usize) -> usize {
    let bytes = 4 * interpolation.width() * groups;
    bytes.div_ceil(NODES_BYTES).max(1)
}

/// Decodes the groups of a setpoint.
pub fn nodes(interpolation: Interpolation, bytes: &[u8]) -> impl Iterator<Item = Node<f32>> {
    let (numbers, _) = bytes.as_chunks::<4>();
    let groups = numbers.chunks_exact(interpolation.width());
    groups.filter_map(|numbers| {
        let mut numbers = numbers.iter().copied().map(f32::from_le_bytes);
        Some(Node {
            angle: numbers.next()?,
            rate: numbers.next()?,
            weight: [numbers.next().unwrap_or(1.0), numbers.next().unwrap_or(0.0)],
        })
    })
}

/// Decodes the limits of a group.
#[must_use]
pub fn limits(bytes: &[u8; 16]) -> GroupLimits {
    let mut numbers = [[0; 4]; 4];
    numbers.as_flattened_mut().copy_from_slice(bytes);
    GroupLimits::from_numbers(numbers.map(f32::from_le_bytes))
}

/// Returns the number of bits of a hinge's code in a sheet of `groups` groups: the fewest that hold all numbers below
/// 2 · `groups`.
#[must_use]
pub fn hinge_bits(groups: usize) -> NonZero<usize> {
    let largest = (2 * groups).saturating_sub(1);
    NonZero::new((usize::BITS - largest.leading_zeros()) as usize).unwrap_or(NonZero::<usize>::MIN)
}

/// Decodes hinge codes of `bits` bits each, the lowest bits first. Bits left over in the last byte are dropped.
pub fn hinge_codes(bytes: &[u8], bits: NonZero<usize>) -> impl Iterator<Item = u16> {
    let code = move |hinge: usize| {
        let first = hinge * bits.get();
        // A code of at most 17 bits begins anywhere in the first of three bytes.
        let word = (0..3).fold(0, |word, k| {
            let byte = bytes.get(first / 8 + k).copied().unwrap_or(0);
            word | u32::from(byte) << (8 * k)
        });
        let [low, high, ..] = (word >> (first % 8) & !(u32::MAX << bits.get())).to_le_bytes();
        u16::from_le_bytes([low, high])
    };
    (0..8 * bytes.len() / bits).map(code)
}

/// Decodes a spoke; the flag is `true` if it is the last of its star.
#[must_use]
pub fn spoke(bytes: [u8; 10]) -> (Spoke<f32>, bool) {
    let [c, d, x0, x1, x2, x3, y0, y1, y2, y3] = bytes;
    let code = u16::from_le_bytes([c, d]);
    let direction = [[x0, x1, x2, x3], [y0, y1, y2, y3]].map(f32::from_le_bytes);
    Spoke::from_code(code.into(), direction)
}

/// Items that a [`Sender`](crate::wire::sender::Sender) sends: those of the sheet of `C`, and of its path from a place on
/// it.
#[derive(Clone, Copy, Debug)]
pub struct Items<C> {
    head: SheetHead,
    content: C,
    first: usize,
}

/// The items of a path in memory.
pub type PathItems<'a> = Items<PathOnSheet<'a>>;

/// A path on a sheet, in borrowed memory.
#[derive(Clone, Copy, Debug)]
pub struct PathOnSheet<'a> {
    pub(crate) limits: &'a [GroupLimits],
    pub(crate) hinges: &'a [Membership],
    pub(crate) stars: StarsView<'a, f32>,
    pub(crate) path: TrajectoryView<'a, f32>,
}

impl<'a> PathItems<'a> {
    /// Creates the items of a path on the sheet of these groups, hinges and essential vertices.
    ///
    /// `closure` is the largest residual that the path's commanded configurations have, rounding included. Returns
    /// `None` if the numbers of groups differ, if a hinge has no group, if there are more than 2¹⁴ groups, hinges or
    /// spokes, or if `place` is not on the path.
    #[must_use]
    pub fn new(
        path: TrajectoryView<'a, f32>,
        limits: &'a [GroupLimits],
        hinges: &'a [Membership],
        stars: StarsView<'a, f32>,
        closure: f32,
        place: FollowerPosition<f32>,
    ) -> Option<Self> {
        let groups = [stars.unknowns(), path.groups()];
        let same = groups.iter().all(|&groups| groups == limits.len());
        let known = |hinge: &Membership| hinge.group.index() < limits.len();
        if !same || !hinges.iter().all(known) {
            return None;
        }
        let content = PathOnSheet {
            limits,
            hinges,
            stars,
            path,
        };
        Self::of(content, closure, content.number())?.at(place)
    }
}

#[allow(private_bounds, reason = "only this crate knows what can be sent")]
impl<C: Content> Items<C> {
    /// Creates the items of the path of this number from the first knot on, if there is one.
    pub(super) fn of(content: C, closure: f32, path: u32) -> Option<Self> {
        let small = |count: usize| u16::try_from(count).ok().filter(|&count| count <= 1 << 14);
        let place = FollowerPosition::default();
        let head = SheetHead {
            interpolation: content.interpolation(),
            groups: small(content.groups())?,
            hinges: small(content.hinges().count())?,
            spokes: small(content.spokes().count())?,
            closure,
            path,
            place,
            most_lag: f32::INFINITY,
        };
        let items = Self {
            head,
            content,
            first: 0,
        };
        items.at(place)
    }

    /// Returns the items of this path for a sheet on which the motion holds from this distance between a hinge and its command
    /// on (radians), if the controller does not do so earlier.
    #[must_use]
    pub fn with_most_lag(self, most_lag: f32) -> Self {
        let head = SheetHead {
            most_lag,
            ..self.head
        };
        Self { head, ..self }
    }

    /// Returns the number that tells this path from others, see [`SheetHead::path`].
    #[must_use]
    pub fn identity(&self) -> u32 {
        self.head.path
    }

    /// Returns the number of items of a setpoint.
    #[must_use]
    pub fn pieces(&self) -> usize {
        self.head.pieces()
    }

    /// Returns the items of this path from another place on; `None` if that place is not on it.
    #[must_use]
    pub fn at(self, place: FollowerPosition<f32>) -> Option<Self> {
        let head = SheetHead { place, ..self.head };
        let first = usize::try_from(place.knot).ok()?;
        (first < self.content.knots()).then_some(Self {
            head,
            first,
            ..self
        })
    }

    /// Returns the place on this path at which a sheet stands that is at `place` on the reverse of this path; `None` if
    /// that is not a place on it.
    #[must_use]
    pub fn mirrored(&self, place: FollowerPosition<f32>) -> Option<FollowerPosition<f32>> {
        let knot = usize::try_from(place.knot).ok()?;
        let facing = self.content.knots().checked_sub(1)?.checked_sub(knot)?;
        let at = |knot: usize, into: f32| {
            let knot = u32::try_from(knot).ok()?;
            Some(FollowerPosition { knot, into })
        };
        let Some(before) = facing.checked_sub(1).filter(|_| place.into > 0.0) else {
            return at(facing, 0.0);
        };
        let span = self.content.span(facing)?;
        at(before, (span - place.into).max(0.0))
    }

    /// Returns the number of the knot of the first setpoint.
    #[must_use]
    pub fn first(&self) -> usize {
        self.first
    }

    /// Returns the number of items before the first setpoint, which are those of the sheet.
    #[must_use]
    pub fn head(&self) -> usize {
        self.head.items()
    }

    /// Returns the number of items.
    #[must_use]
    pub fn count(&self) -> usize {
        self.head() + (self.content.knots() - self.first) * self.pieces()
    }

    fn limit_bytes(&self) -> impl Iterator<Item = u8> {
        let numbers = self.content.limits().flat_map(|group| group.numbers());
        numbers.flat_map(f32::to_le_bytes)
    }

    fn spoke_bytes(&self) -> impl Iterator<Item = u8> {
        self.content.spokes().flat_map(|(code, direction)| {
            let [a, b, ..] = code.to_le_bytes();
            let numbers = direction.into_iter().flat_map(f32::to_le_bytes);
            [a, b].into_iter().chain(numbers)
        })
    }

    /// Returns piece number `index` of the setpoints.
    fn setpoint<'b>(&self, index: usize, scratch: &'b mut [u8]) -> Option<Item<'b>> {
        let (setpoint, piece) = (index / self.pieces(), index % self.pieces());
        let number = self.first.checked_add(setpoint)?;
        let span = self.content.span(number)?;
        let numbers = self.content.nodes(number).flat_map(|node| {
            let [weight, rate] = node.weight;
            let numbers = [node.angle, node.rate, weight, rate];
            numbers.into_iter().take(self.head.interpolation.width())
        });
        let bytes = part(
            numbers.flat_map(f32::to_le_bytes),
            (piece * NODES_BYTES, NODES_BYTES),
            scratch,
        )?;
        if piece + 1 < self.pieces() {
            return Some(Item::Nodes(bytes));
        }
        Some(Item::Setpoint(SetpointBytes {
            number: u32::try_from(number).ok()?,
            span,
            last: number + 1 == self.content.knots(),
            nodes: bytes,
        }))
    }
}

impl<C: Content> Source for Items<C> {
    fn item<'b>(&self, index: u64, scratch: &'b mut [u8]) -> Option<Item<'b>> {
        let mut index = usize::try_from(index).ok()?;
        if index == 0 {
            return Some(Item::Sheet(self.head));
        }
        index -= 1;
        for (kind, (all, most)) in (0..).zip(self.head.bytes()) {
            let count = all.div_ceil(most);
            if index < count {
                let range = (index * most, most);
                return Some(match kind {
                    0 => Item::Limits(part(self.limit_bytes(), range, scratch)?),
                    1 => Item::Hinges(part(self.content.hinge_bytes(), range, scratch)?),
                    _ => Item::Spokes(part(self.spoke_bytes(), range, scratch)?),
                });
            }
            index -= count;
        }
        self.setpoint(index, scratch)
    }
}

impl SheetHead {
    /// Returns the number of items of a setpoint.
    fn pieces(&self) -> usize {
        pieces(self.interpolation, usize::from(self.groups))
    }

    /// Returns for limits, hinges and spokes the number of their bytes in all, and the largest number of bytes in an
    /// item.
    fn bytes(&self) -> [(usize, usize); 3] {
        let bits = hinge_bits(self.groups.into());
        [
            (usize::from(self.groups) * LIMITS_BYTES, MAX_LIMITS_BYTES),
            // A multiple of `bits` bytes, so that whole codes fill whole bytes.
            (
                (usize::from(self.hinges) * bits.get()).div_ceil(8),
                MAX_HINGES_BYTES / bits * bits.get(),
            ),
            (usize::from(self.spokes) * SPOKE_BYTES, MAX_SPOKES_BYTES),
        ]
    }

    /// Returns the number of items before the first setpoint.
    fn items(&self) -> usize {
        let counts = self.bytes().map(|(all, most)| all.div_ceil(most));
        1 + counts.iter().sum::<usize>()
    }
}

/// The numbers of a path and its sheet, wherever they are kept.
pub(crate) trait Content {
    /// Returns the kind of motion between knots.
    fn interpolation(&self) -> Interpolation;
    /// Returns the number of groups.
    fn groups(&self) -> usize;
    /// Returns the number of knots.
    fn knots(&self) -> usize;
    /// Iterates over the limits of each group.
    fn limits(&self) -> impl Iterator<Item = GroupLimits>;
    /// Iterates over group and sign of each hinge.
    fn hinges(&self) -> impl Iterator<Item = Membership>;
    /// Iterates over code and direction of each spoke, see [`Spoke::from_code`].
    fn spokes(&self) -> impl Iterator<Item = (u32, [f32; 2])>;
    /// Returns the seconds of a knot since the knot before; 0 at the first knot.
    fn span(&self, knot: usize) -> Option<f32>;
    /// Returns what a group does at a knot; its weight counts only if the interpolation has weights.
    fn node(&self, knot: usize, group: usize) -> Option<Node<f32>>;

    /// Iterates over what the groups do at a knot.
    fn nodes(&self, knot: usize) -> impl Iterator<Item = Node<f32>> {
        (0..self.groups()).filter_map(move |group| self.node(knot, group))
    }

    /// Encodes the codes of all hinges, one behind the other.
    fn hinge_bytes(&self) -> impl Iterator<Item = u8> {
        let bits = hinge_bits(self.groups()).get();
        let mut hinges = self.hinges();
        // Bits that are not told yet, the first of them lowest.
        let (mut word, mut filled) = (0, 0);
        core::iter::from_fn(move || {
            while filled < 8 {
                match hinges.next() {
                    Some(hinge) => {
                        word |= hinge.code() << filled;
                        filled += bits;
                    }
                    None if filled == 0 => return None,
                    None => filled = 8,
                }
            }
            let [byte, ..] = word.to_le_bytes();
            word >>= 8;
            filled -= 8;
            Some(byte)
        })
    }

    /// Returns the number that tells this path from others: the checksum of all its numbers and those of its sheet, the limits
    /// aside, or 1 if that is 0.
    fn number(&self) -> u32 {
        let kind = self.interpolation();
        let mut sum = u32::from(kind as u8);
        let mut add = |bytes: &[u8]| sum = checksum_on(sum, bytes);
        self.hinge_bytes().for_each(|byte| add(&[byte]));
        for (code, direction) in self.spokes() {
            add(&code.to_le_bytes());
            direction.iter().for_each(|x| add(&x.to_le_bytes()));
        }
        for knot in 0..self.knots() {
            if let Some(span) = self.span(knot) {
                add(&span.to_le_bytes());
            }
            let nodes = || self.nodes(knot);
            nodes().for_each(|node| add(&node.angle.to_le_bytes()));
            nodes().for_each(|node| add(&node.rate.to_le_bytes()));
            if kind.width() == 4 {
                let weights = nodes().flat_map(|node| node.weight);
                weights.for_each(|number| add(&number.to_le_bytes()));
            }
        }
        sum.max(1)
    }
}

impl Content for PathOnSheet<'_> {
    fn interpolation(&self) -> Interpolation {
        self.path.interpolation()
    }

    fn groups(&self) -> usize {
        self.path.groups()
    }

    fn knots(&self) -> usize {
        self.path.len()
    }

    fn limits(&self) -> impl Iterator<Item = GroupLimits> {
        self.limits.iter().copied()
    }

    fn hinges(&self) -> impl Iterator<Item = Membership> {
        self.hinges.iter().copied()
    }

    fn spokes(&self) -> impl Iterator<Item = (u32, [f32; 2])> {
        let codes = self.stars.iter().flat_map(StarView::codes);
        codes.map(|(code, spoke)| (code, spoke.direction))
    }

    fn span(&self, knot: usize) -> Option<f32> {
        Some(self.path.knot(knot)?.span)
    }

    fn node(&self, knot: usize, group: usize) -> Option<Node<f32>> {
        self.path.knot(knot)?.node(group)
    }
}

/// Writes `most` bytes behind the first `from` to `scratch`, or as many as there are; `None` if there is no room.
fn part(
    bytes: impl Iterator<Item = u8>,
    (from, most): (usize, usize),
    scratch: &mut [u8],
) -> Option<&[u8]> {
    let mut length = 0;
    for byte in bytes.skip(from).take(most) {
        *scratch.get_mut(length)? = byte;
        length += 1;
    }
    scratch.get(..length)
}
