//! The sheet as the host describes it, received piece by piece.
//!
//! The hinges of the sheet before stay until the new sheet is complete and its first setpoint has come, so that somebody
//! owns every drive at every time.

use core::cell::Cell;

use foldpath_core::acceptance::SheetView;
use foldpath_core::follower::Hinge;
use foldpath_core::wire::message::{ItemRefusal, SheetHead};
use foldpath_core::wire::path;
use foldpath_core::{
    GroupId, GroupLimits, Interpolation, Membership, Spoke, StarsView, checksum_on,
};
use heapless::Vec;

use crate::controller::Settings;

/// Bits of a driven hinge above its code: its sensor was heard since they were looked at, and before that.
const HEARD: u16 = 1 << 15;
const HEARD_BEFORE: u16 = 1 << 14;
/// Number of groups whose codes leave these bits free.
const MAX_GROUPS: u16 = HEARD_BEFORE >> 1;

/// A sheet of at most `GROUPS` groups, `HINGES` hinges and `SPOKES` spokes of essential vertices.
// In order, for the reason given at `Follower`.
#[derive(Clone, Debug)]
#[repr(C)]
pub struct Sheet<const GROUPS: usize, const HINGES: usize, const SPOKES: usize> {
    head: Option<SheetHead>,
    /// Checksum of what tells this sheet from others: its counts, hinges and spokes.
    sum: u32,
    /// `true` once the sheet is driven.
    adopted: bool,
    limits: Vec<GroupLimits, GROUPS>,
    spokes: Vec<Spoke<f32>, SPOKES>,
    ends: Vec<u32, SPOKES>,
    /// Code of each hinge, see [`Membership::from_code`]: of the sheet that is received, and of the sheet that is driven with
    /// the bits of its sensors.
    hinges: Vec<u16, HINGES>,
    driven: Vec<Cell<u16>, HINGES>,
    /// Number of driven hinges whose sensors were heard.
    measured: usize,
}

impl<const GROUPS: usize, const HINGES: usize, const SPOKES: usize> Default
    for Sheet<GROUPS, HINGES, SPOKES>
{
    // Inlined for the reason given at `Application::new`.
    #[inline(always)]
    fn default() -> Self {
        Self {
            head: None,
            limits: Vec::new(),
            hinges: Vec::new(),
            driven: Vec::new(),
            measured: 0,
            spokes: Vec::new(),
            ends: Vec::new(),
            sum: 0,
            adopted: false,
        }
    }
}

impl<const GROUPS: usize, const HINGES: usize, const SPOKES: usize> Sheet<GROUPS, HINGES, SPOKES> {
    /// Begins a new sheet.
    ///
    /// # Errors
    /// If there is no room, if the sheet asks for a larger closure residual than the settings allow, or if it lacks
    /// essential vertices although they ask for some.
    pub fn begin(&mut self, head: SheetHead, settings: &Settings) -> Result<(), ItemRefusal> {
        self.clear();
        let SheetHead {
            groups,
            hinges,
            spokes,
            ..
        } = head;
        let fits = [(groups, GROUPS), (hinges, HINGES), (spokes, SPOKES)];
        if fits.iter().any(|&(count, room)| usize::from(count) > room) {
            return Err(ItemRefusal::Room);
        }
        if !(0.0..=settings.follower.closure).contains(&head.closure) {
            return Err(ItemRefusal::Closure);
        }
        if settings.closed && spokes == 0 {
            return Err(ItemRefusal::Stars);
        }
        self.head = Some(head);
        for count in [groups, hinges, spokes] {
            self.sum = checksum_on(self.sum, &count.to_le_bytes());
        }
        Ok(())
    }

    /// Forgets the sheet that is received. The hinges of the sheet that is driven stay.
    #[inline(never)]
    pub fn clear(&mut self) {
        (self.head, self.sum) = (None, 0);
        self.limits.clear();
        self.hinges.clear();
        self.spokes.clear();
        self.ends.clear();
        self.adopted = false;
    }

    /// Takes up the sheet that was received, if it is complete: its limits are narrowed by those of the board for each
    /// hinge, and its hinges are driven from now on. Cost: some ten operations for each hinge.
    ///
    /// # Errors
    /// If the sheet is not complete, if the limits of the board are not sound, or if they leave nothing of the limits of
    /// a group.
    pub fn adopt(&mut self, board: fn(u32) -> GroupLimits) -> Result<(), ItemRefusal> {
        self.view().ok_or(ItemRefusal::Incomplete)?;
        for (hinge, code) in (0..).zip(&self.hinges) {
            let Membership { group, negative } = Membership::from_code((*code).into());
            let board = board(hinge);
            if let Some(limits) = self.limits.get_mut(group.index()) {
                *limits = narrowed(*limits, board, negative);
                if !(board.are_sound() && limits.are_sound()) {
                    return Err(ItemRefusal::Limits(number(group.index())));
                }
            }
        }
        const {
            assert!(
                GROUPS <= MAX_GROUPS as usize,
                "the codes of so many groups leave no bits for the sensors"
            );
        }
        // Not `clone_from`, which would build another copy on the stack.
        self.driven.clear();
        for code in &self.hinges {
            let _ = self.driven.push(Cell::new(*code));
        }
        (self.adopted, self.measured) = (true, 0);
        Ok(())
    }

    /// Returns `true` if the hinges of the sheet that was received are driven.
    #[must_use]
    pub fn is_adopted(&self) -> bool {
        self.adopted
    }

    /// Returns a number that tells the sheet that was received from others: a checksum that is not 0.
    #[must_use]
    pub fn identity(&self) -> u32 {
        self.sum.max(1)
    }

    /// Adds the next limits. Either all limits of a piece are taken or none, as with all pieces.
    ///
    /// # Errors
    /// If there are too many, or if they are cut off or not valid.
    pub fn add_limits(&mut self, bytes: &[u8]) -> Result<(), ItemRefusal> {
        let (head, pieces) = (self.head()?, whole(bytes)?);
        room(self.limits.len(), pieces, head.groups)?;
        for (group, bytes) in (number(self.limits.len())..).zip(pieces) {
            if !path::limits(bytes).are_sound() {
                return Err(ItemRefusal::Limits(group));
            }
        }
        push(&mut self.limits, pieces.iter().map(path::limits))
    }

    /// Adds the next hinges.
    ///
    /// # Errors
    /// If there are too many, or if they are cut off or without a group.
    pub fn add_hinges(&mut self, bytes: &[u8]) -> Result<(), ItemRefusal> {
        let head = self.head()?;
        let bits = path::hinge_bits(head.groups.into());
        let left = usize::from(head.hinges).saturating_sub(self.hinges.len());
        let count = left.min(8 * bytes.len() / bits);
        let ends = count == left || count * bits.get() == 8 * bytes.len();
        if !ends || (count * bits.get()).div_ceil(8) != bytes.len() {
            return Err(ItemRefusal::Pieces);
        }
        let codes = || path::hinge_codes(bytes, bits).take(count);
        for (hinge, code) in (number(self.hinges.len())..).zip(codes()) {
            if Membership::from_code(code.into()).group.index() >= usize::from(head.groups) {
                return Err(ItemRefusal::Hinge(hinge));
            }
        }
        self.sum = checksum_on(self.sum, bytes);
        push(&mut self.hinges, codes())
    }

    /// Adds the next spokes.
    ///
    /// # Errors
    /// If there are too many, if they are cut off, or if the vertices are not valid once the last spoke has come.
    pub fn add_spokes(&mut self, bytes: &[u8]) -> Result<(), ItemRefusal> {
        let (head, pieces) = (self.head()?, whole(bytes)?);
        let before = (self.spokes.len(), self.ends.len());
        room(before.0, pieces, head.spokes)?;
        for (count, bytes) in (before.0 + 1..).zip(pieces) {
            let (spoke, last) = path::spoke(*bytes);
            let end = last.then_some(number(count).into());
            push(&mut self.spokes, core::iter::once(spoke))?;
            push(&mut self.ends, end.into_iter())?;
        }
        let complete = number(self.spokes.len()) == head.spokes;
        if complete && StarsView::new(&self.spokes, &self.ends, head.groups.into()).is_none() {
            self.spokes.truncate(before.0);
            self.ends.truncate(before.1);
            return Err(ItemRefusal::Stars);
        }
        self.sum = checksum_on(self.sum, bytes);
        Ok(())
    }

    /// Returns the kind of motion between setpoints.
    pub(crate) fn interpolation(&self) -> Interpolation {
        self.head.map(|head| head.interpolation).unwrap_or_default()
    }

    /// Returns the number that tells the path on this sheet from others; 0 without a sheet.
    pub(crate) fn path(&self) -> u32 {
        self.head.map_or(0, |head| head.path)
    }

    fn head(&self) -> Result<SheetHead, ItemRefusal> {
        self.head.ok_or(ItemRefusal::Incomplete)
    }

    /// Returns the essential vertices that were received, which are valid once the sheet is complete.
    pub(crate) fn stars(&self) -> StarsView<'_, f32> {
        let groups = self.head.map_or(0, |head| head.groups);
        StarsView::accepted(&self.spokes, &self.ends, groups.into())
    }

    /// Returns the sheet and the place on its path at which to begin, if the sheet is complete.
    // Not inlined, so that an image has it once.
    #[inline(never)]
    #[must_use]
    pub fn view(&self) -> Option<(SheetView<'_, f32>, SheetHead)> {
        let head = self.head?;
        let counts = [self.limits.len(), self.hinges.len(), self.spokes.len()];
        let complete = counts.map(number) == [head.groups, head.hinges, head.spokes];
        let view = SheetView {
            interpolation: head.interpolation,
            limits: &self.limits,
            stars: self.stars(),
            closure: head.closure,
        };
        complete.then_some((view, head))
    }

    /// Iterates over group and sign of each hinge that is driven.
    pub fn hinges(&self) -> impl ExactSizeIterator<Item = Membership> {
        self.driven().map(|hinge| hinge.membership())
    }

    /// Iterates over the hinges that are driven.
    pub(crate) fn driven(&self) -> impl ExactSizeIterator<Item = Driven<'_>> {
        self.driven.iter().map(|code| Driven(code, code.get()))
    }

    /// Returns the number of driven hinges that were measured.
    pub(crate) fn measured(&self) -> usize {
        self.measured
    }

    /// Returns the first hinge that was measured before, and not since the last call. Not inlined, so that other ticks do not
    /// pay for it.
    #[inline(never)]
    pub(crate) fn silent(&mut self) -> Option<u32> {
        self.measured = 0;
        let mut silent = None;
        for (hinge, code) in (0..).zip(&self.driven) {
            let bits = code.get();
            if bits & HEARD != 0 {
                code.set(bits & !HEARD | HEARD_BEFORE);
            } else if bits & HEARD_BEFORE != 0 {
                silent = silent.or(Some(hinge));
            }
            self.measured += usize::from(bits & (HEARD | HEARD_BEFORE) != 0);
        }
        silent
    }
}

/// A hinge that is driven, and its code.
pub(crate) struct Driven<'a>(&'a Cell<u16>, u16);

impl Hinge for Driven<'_> {
    #[inline]
    fn membership(&self) -> Membership {
        // As `Membership::from_code` does, without the bits above.
        Membership {
            group: GroupId(u32::from(self.1 >> 1 & (MAX_GROUPS - 1))),
            negative: self.1 & 1 == 1,
        }
    }

    #[inline]
    fn heard(&self) {
        self.0.set(self.1 | HEARD);
    }
}

/// Returns limits that a group keeps and that one of its hinges keeps, which turns the opposite way if `negative`.
fn narrowed(group: GroupLimits, hinge: GroupLimits, negative: bool) -> GroupLimits {
    let (lower, upper) = if negative {
        (-hinge.upper, -hinge.lower)
    } else {
        (hinge.lower, hinge.upper)
    };
    GroupLimits {
        lower: group.lower.max(lower),
        upper: group.upper.min(upper),
        speed: group.speed.min(hinge.speed),
        acceleration: group.acceleration.min(hinge.acceleration),
    }
}

/// Splits bytes into pieces of `N` bytes; fails if a piece is cut off.
fn whole<const N: usize>(bytes: &[u8]) -> Result<&[[u8; N]], ItemRefusal> {
    let (pieces, rest) = bytes.as_chunks();
    if rest.is_empty() {
        Ok(pieces)
    } else {
        Err(ItemRefusal::Pieces)
    }
}

/// Fails if these pieces are more than the sheet still lacks.
fn room<T>(have: usize, pieces: &[T], most: u16) -> Result<(), ItemRefusal> {
    if have + pieces.len() > usize::from(most) {
        return Err(ItemRefusal::Pieces);
    }
    Ok(())
}

/// Adds pieces; fails if there is no room.
fn push<T, const N: usize>(
    pieces: &mut Vec<T, N>,
    mut more: impl Iterator<Item = T>,
) -> Result<(), ItemRefusal> {
    more.try_for_each(|piece| pieces.push(piece).map_err(|_| ItemRefusal::Room))
}

/// Returns a count below 2¹⁶ in the type in which it is sent.
fn number(count: usize) -> u16 {
    u16::try_from(count).unwrap_or(u16::MAX)
}
