//! The sheet, the path on it, and the follower: takes the items and the commands of the open session.

use foldpath_core::acceptance::{Refusal, Setpoint};
use foldpath_core::follower::{Denial, Follower, Reason, State};
use foldpath_core::wire::message::{Command, Item, ItemRefusal, SetpointBytes};
use foldpath_core::wire::path::{self, NODES_BYTES};
use foldpath_core::{Interpolation, Node};
use heapless::Vec;

use crate::controller::Settings;
use crate::jog::Jog;
use crate::sheet::Sheet;

/// Number of parts of a segment on which the closure of an essential vertex is bounded in a round of the main loop. A
/// part takes at most some ten thousand instructions with four spokes; the cost grows with the square of the spokes.
const PARTS: u32 = 1;

/// A follower, and what the host has sent for it.
// In order, for the reason given at `Follower`.
#[derive(Debug)]
#[repr(C)]
pub(crate) struct Loader<
    const GROUPS: usize,
    const HINGES: usize,
    const SPOKES: usize,
    const KNOTS: usize,
> {
    /// Hinge that is watched or moved alone. There is none on a path.
    pub(crate) jog: Jog,
    /// `true` while a setpoint is checked.
    pub(crate) checks: bool,
    /// `true` if the path is that of the open session.
    pub(crate) loaded: bool,
    /// `true` once a motion has started, until a host asks to forget where the hinges stand.
    pub(crate) holds: bool,
    /// Numbers that tell the path and the sheet on which the groups stand from others; 0 if there was none. The path is
    /// that of the position that the follower tells.
    pub(crate) path: u32,
    pub(crate) on: u32,
    pub(crate) follower: Follower<f32, GROUPS, KNOTS>,
    /// Groups of the next setpoint that have come in earlier items.
    staged: Vec<Node<f32>, GROUPS>,
    pub(crate) sheet: Sheet<GROUPS, HINGES, SPOKES>,
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
            jog: Jog::default(),
            staged: Vec::new(),
            checks: false,
            loaded: false,
            holds: false,
            path: 0,
            on: 0,
        }
    }

    /// Begins a session: the path before is not that of the session, and a motion under way slows down and holds.
    pub(crate) fn enter(&mut self) {
        self.loaded = false;
        self.staged.clear();
        self.jog.end();
        if self.follower.is_under_way() {
            self.follower.hold(Reason::Session);
        }
    }

    /// Returns the number of items for which there is room: fewer than 2¹⁵, so that numbers of items modulo 2¹⁶ have an
    /// order. There is none while the sheet moves on the path of another host.
    // Not inlined, so that an image has it once.
    #[inline(never)]
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
        i16::try_from(room).unwrap_or(i16::MAX).cast_unsigned()
    }

    /// Watches a hinge, or moves it alone. Then it is not known any more where the sheet stands.
    #[inline(never)]
    fn jog(
        &mut self,
        (hinge, from, to): (u16, Option<f32>, Option<f32>),
        settings: &Settings,
    ) -> Result<(), Denial> {
        let follower = &mut self.follower;
        // The hinges of a sheet whose place is known are commanded: one of them alone would tear it.
        if follower.state() != State::Idle || to.is_some() && follower.is_known() {
            return Err(Denial::State);
        }
        if follower.is_stopped() {
            return Err(Denial::Held);
        }
        if usize::from(hinge) >= HINGES {
            return Err(Denial::Range);
        }
        let limits = (settings.limits)(hinge.into());
        let now = follower.now();
        self.jog
            .ask((hinge, from, to), now, &limits, &settings.follower)?;
        if to.is_some() {
            follower.forget()?;
            self.path = 0;
        }
        Ok(())
    }

    /// Carries out a command. The path of another session does not go on. The motion of a hinge that is moved alone ends with
    /// each command.
    pub(crate) fn obey(&mut self, command: Command, settings: &Settings) -> Result<(), Denial> {
        self.jog.end();
        let follower = &mut self.follower;
        match command {
            Command::Start | Command::Stand if !self.loaded => Err(Denial::State),
            // From now on the place of the follower is one on this path.
            Command::Start => {
                follower.start()?;
                (self.path, self.holds) = (self.sheet.path(), true);
                Ok(())
            }
            Command::Stand => follower.confirm(),
            Command::Hold => {
                follower.hold(Reason::HoldCommand);
                Ok(())
            }
            Command::Resume if !self.loaded && follower.is_under_way() => Err(Denial::State),
            Command::Resume => follower.resume(),
            // A path that has begun is dropped with its sheet.
            Command::Forget => {
                let begun = matches!(follower.state(), State::Holding | State::Done);
                follower.forget()?;
                (self.path, self.holds) = (0, false);
                self.jog = Jog::default();
                if begun {
                    self.sheet.clear();
                }
                Ok(())
            }
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
            Command::Jog { hinge, from, to } => self.jog((hinge, from, to), settings),
        }
    }

    /// Takes an item of a sheet whose hinges keep the limits of the board. Returns `false` if it is a setpoint that
    /// [`check_on`](Self::check_on) has to go on with.
    #[inline(never)]
    pub(crate) fn take(
        &mut self,
        item: Item<'_>,
        settings: &Settings,
    ) -> Result<bool, ItemRefusal> {
        // A sheet that an earlier session has left is no base for items of this session.
        if !(self.loaded || matches!(item, Item::Sheet(_))) {
            return Err(ItemRefusal::Incomplete);
        }
        match item {
            Item::Sheet(head) => {
                self.follower.unload().map_err(ItemRefusal::Path)?;
                self.staged.clear();
                self.sheet.begin(head, settings)?;
                self.loaded = true;
            }
            Item::Limits(bytes) => self.sheet.add_limits(bytes)?,
            Item::Hinges(bytes) => self.sheet.add_hinges(bytes)?,
            Item::Spokes(bytes) => self.sheet.add_spokes(bytes)?,
            Item::Nodes(bytes) => {
                let (view, head) = self.sheet.view().ok_or(ItemRefusal::Incomplete)?;
                let kind = view.interpolation;
                if bytes.len() != NODES_BYTES || !stage(&mut self.staged, kind, head.groups, bytes)
                {
                    return Err(self.misfit());
                }
            }
            Item::Setpoint(bytes) => {
                self.setpoint(&bytes, settings)?;
                self.checks = true;
                return self.check_on();
            }
        }
        Ok(true)
    }

    /// Begins to check a setpoint, or the rest of one. The pieces before stay if it is refused, so that the rest may be
    /// amended.
    fn setpoint(
        &mut self,
        bytes: &SetpointBytes<'_>,
        settings: &Settings,
    ) -> Result<(), ItemRefusal> {
        if !self.sheet.is_adopted() {
            self.take_up(settings)?;
        }
        let (view, head) = self.sheet.view().ok_or(ItemRefusal::Incomplete)?;
        if self.follower.state() == State::Idle {
            let loaded = self.follower.load(&view, head.place);
            loaded.map_err(ItemRefusal::Path)?;
            self.follower.limit_lag(head.most_lag);
        }
        let mut nodes = self.staged.clone();
        if !stage(&mut nodes, view.interpolation, head.groups, bytes.nodes) {
            return Err(self.misfit());
        }
        let setpoint = Setpoint {
            number: bytes.number,
            span: bytes.span,
            last: bytes.last,
            nodes,
        };
        let offered = self.follower.offer(&view, setpoint);
        offered.map_err(ItemRefusal::Setpoint)
    }

    /// Takes up the sheet that was received. If it is another sheet than before, nobody knows where it stands.
    fn take_up(&mut self, settings: &Settings) -> Result<(), ItemRefusal> {
        // A failure since the sheet began to come: the hinges before stay, because the angles before stay.
        if self.follower.state() != State::Idle {
            return Err(ItemRefusal::Path(Denial::State));
        }
        self.sheet.adopt(settings.limits)?;
        self.jog = Jog::default();
        let sheet = self.sheet.identity();
        // 0 stands for angles that the board itself has told.
        if self.on != 0 && self.on != sheet {
            self.follower.forget().map_err(ItemRefusal::Path)?;
            self.path = 0;
        }
        self.on = sheet;
        Ok(())
    }

    /// Goes on to check a setpoint; returns `true` once it is queued.
    #[inline(never)]
    pub(crate) fn check_on(&mut self) -> Result<bool, ItemRefusal> {
        let (view, _) = self.sheet.view().ok_or(ItemRefusal::Incomplete)?;
        let checked = self.follower.check_on(&view, PARTS);
        self.checks = checked == Ok(false);
        if checked == Ok(true) {
            self.staged.clear();
        }
        checked.map_err(ItemRefusal::Setpoint)
    }

    /// Holds the motion, because a setpoint does not have the numbers of each group. Without a path there is nothing to
    /// hold.
    fn misfit(&mut self) -> ItemRefusal {
        let follower = &mut self.follower;
        if follower.is_under_way() || follower.state() == State::Ready {
            follower.hold(Reason::Refused(Refusal::Groups));
        }
        ItemRefusal::Setpoint(Refusal::Groups)
    }
}

/// Adds the groups of a piece of a setpoint, of `groups` in all. Returns `false` if there are too many, or if a group is
/// cut off; nothing is added then.
#[inline(never)]
fn stage<const GROUPS: usize>(
    nodes: &mut Vec<Node<f32>, GROUPS>,
    interpolation: Interpolation,
    groups: u16,
    bytes: &[u8],
) -> bool {
    let before = nodes.len();
    let mut more = path::nodes(interpolation, bytes);
    let whole = bytes.len().is_multiple_of(4 * interpolation.width());
    let added = whole
        && more.try_for_each(|node| nodes.push(node)).is_ok()
        && nodes.len() <= usize::from(groups);
    if !added {
        nodes.truncate(before);
    }
    added
}

#[cfg(test)]
mod tests {
    use foldpath_core::Interpolation;
    use heapless::Vec;

    use super::stage;

    /// A piece has no more groups than the sheet, however large the controller is.
    #[test]
    fn pieces_fit_the_sheet() {
        let (mut nodes, kind) = (Vec::<_, 94>::new(), Interpolation::Hermite);
        assert!(!stage(&mut nodes, kind, 25, &[0; 208]));
        assert!(nodes.is_empty());
        assert!(stage(&mut nodes, kind, 26, &[0; 208]));
        assert!(!stage(&mut nodes, kind, 26, &[0; 8]));
        assert!(!stage(&mut nodes, kind, 94, &[0; 9]));
        assert_eq!(nodes.len(), 26);
    }
}
