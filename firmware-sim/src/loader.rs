//! The sheet, the path on it, and the follower: takes the items and the commands of the open session.

use foldpath_core::acceptance::{Refusal, Setpoint};
use foldpath_core::follower::{Denial, Follower, Reason, State};
use foldpath_core::wire::message::{Command, Item, ItemRefusal, SetpointBytes};
use foldpath_core::wire::path::{self, NODES_BYTES};
use foldpath_core::{GroupLimits, Interpolation, Node};
use heapless::Vec;

use crate::sheet::Sheet;

/// A follower, and what the host has sent for it.
#[derive(Debug)]
pub(crate) struct Loader<
    const GROUPS: usize,
    const HINGES: usize,
    const SPOKES: usize,
    const KNOTS: usize,
> {
    pub(crate) sheet: Sheet<GROUPS, HINGES, SPOKES>,
    pub(crate) follower: Follower<f32, GROUPS, KNOTS>,
    /// Groups of the next setpoint that have come in earlier items.
    staged: Vec<Node<f32>, GROUPS>,
    /// `true` if the path is that of the open session.
    pub(crate) loaded: bool,
    /// Numbers that tell the path and the sheet on which the groups stand from others; 0 if there was none. The path is
    /// that of the position that the follower tells.
    pub(crate) path: u32,
    pub(crate) on: u32,
}

impl<const GROUPS: usize, const HINGES: usize, const SPOKES: usize, const KNOTS: usize>
    Loader<GROUPS, HINGES, SPOKES, KNOTS>
{
    // Inlined for the reason given at `Application::new`.
    #[inline(always)]
    pub(crate) fn new(follower: Follower<f32, GROUPS, KNOTS>) -> Self {
        Self {
            sheet: Sheet::default(),
            follower,
            staged: Vec::new(),
            loaded: false,
            path: 0,
            on: 0,
        }
    }

    /// Begins a session: the path before is not that of the session, and a motion under way slows down and holds.
    pub(crate) fn enter(&mut self) {
        self.loaded = false;
        self.staged.clear();
        if self.follower.is_under_way() {
            self.follower.hold(Reason::Session);
        }
    }

    /// Returns the number of items for which there is room. There is none while the sheet moves on the path of another
    /// host.
    pub(crate) fn room(&self) -> u16 {
        let follower = &self.follower;
        let ready = follower.is_under_way() || follower.state() == State::Ready;
        let room = if self.loaded && ready {
            let kind = self.sheet.interpolation();
            let pieces = path::pieces(kind, follower.groups());
            let staged = path::pieces(kind, self.staged.len() + 1) - 1;
            (follower.room() * pieces).saturating_sub(staged)
        } else if follower.rate() > 0.0 {
            0
        } else {
            KNOTS
        };
        u16::try_from(room).unwrap_or(u16::MAX)
    }

    /// Carries out a command. The path of another session does not go on.
    pub(crate) fn obey(&mut self, command: Command) -> Result<(), Denial> {
        let follower = &mut self.follower;
        match command {
            Command::Start | Command::Stand if !self.loaded => Err(Denial::State),
            // From now on the place of the follower is one on this path.
            Command::Start => {
                follower.start()?;
                self.path = self.sheet.path();
                Ok(())
            }
            Command::Stand => {
                follower.confirm()?;
                self.path = self.sheet.path();
                Ok(())
            }
            Command::Hold => {
                follower.hold(Reason::Asked);
                Ok(())
            }
            Command::Resume if !self.loaded && follower.is_under_way() => Err(Denial::State),
            Command::Resume => follower.resume(),
            Command::Forget => follower.forget(),
            Command::Unload => {
                follower.unload()?;
                self.sheet.clear();
                Ok(())
            }
            Command::Clear => {
                follower.clear()?;
                self.sheet.clear();
                Ok(())
            }
        }
    }

    /// Takes an item of a sheet whose hinges keep the limits of the board, see [`Sheet::begin`] and [`Sheet::adopt`].
    #[inline(never)]
    pub(crate) fn take(
        &mut self,
        item: Item<'_>,
        limits: fn(u32) -> GroupLimits,
        closure: f32,
        closed: bool,
    ) -> Result<(), ItemRefusal> {
        match item {
            Item::Sheet(head) => {
                self.follower.unload().map_err(ItemRefusal::Path)?;
                self.staged.clear();
                self.sheet.begin(head, closure, closed)?;
            }
            // A sheet that an earlier session has left is no base for items of this session.
            _ if !self.loaded => return Err(ItemRefusal::Incomplete),
            Item::Limits(bytes) => self.sheet.add_limits(bytes)?,
            Item::Hinges(bytes) => self.sheet.add_hinges(bytes)?,
            Item::Spokes(bytes) => self.sheet.add_spokes(bytes)?,
            Item::Nodes(bytes) => {
                let (view, _) = self.sheet.view().ok_or(ItemRefusal::Incomplete)?;
                let kind = view.interpolation;
                let whole = bytes.len() == NODES_BYTES;
                if !whole || stage(&mut self.staged, kind, bytes).is_none() {
                    return Err(self.misfit());
                }
            }
            Item::Setpoint(bytes) => self.setpoint(&bytes, limits)?,
        }
        self.loaded = true;
        Ok(())
    }

    /// Takes a setpoint, or the rest of one. The pieces before stay if it is refused, so that the rest may be amended.
    fn setpoint(
        &mut self,
        bytes: &SetpointBytes<'_>,
        limits: fn(u32) -> GroupLimits,
    ) -> Result<(), ItemRefusal> {
        let new = self.sheet.adopt(limits)?;
        let (view, head) = self.sheet.view().ok_or(ItemRefusal::Incomplete)?;
        // 0 stands for angles that the board itself has told.
        let other = self.on != 0 && self.on != self.sheet.identity();
        if new && other {
            self.follower.forget().map_err(ItemRefusal::Path)?;
        }
        self.on = self.sheet.identity();
        if self.follower.state() == State::Idle {
            let loaded = self.follower.load(&view, head.place);
            loaded.map_err(ItemRefusal::Path)?;
        }
        let mut nodes = self.staged.clone();
        if stage(&mut nodes, view.interpolation, bytes.nodes).is_none() {
            return Err(self.misfit());
        }
        let accepted = self.follower.accept(
            &view,
            Setpoint {
                number: bytes.number,
                time: bytes.time,
                last: bytes.last,
                nodes,
            },
        );
        accepted.map_err(ItemRefusal::Setpoint)?;
        self.staged.clear();
        Ok(())
    }

    /// Holds the motion, because a setpoint does not have the numbers of each group.
    fn misfit(&mut self) -> ItemRefusal {
        self.follower.hold(Reason::Refused(Refusal::Groups));
        ItemRefusal::Setpoint(Refusal::Groups)
    }
}

/// Adds the groups of a piece of a setpoint; `None` if there are too many, or if a group is cut off.
fn stage<const GROUPS: usize>(
    nodes: &mut Vec<Node<f32>, GROUPS>,
    interpolation: Interpolation,
    bytes: &[u8],
) -> Option<()> {
    let before = nodes.len();
    let mut more = path::nodes(interpolation, bytes);
    let whole = bytes.len().is_multiple_of(4 * interpolation.width());
    let added = whole && more.try_for_each(|node| nodes.push(node)).is_ok();
    if !added {
        nodes.truncate(before);
    }
    added.then_some(())
}
