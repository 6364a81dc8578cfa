//! Telemetry of the groups: a moment of the follower, which is sent in pieces.

use foldpath_core::follower::{Follower, FollowerPosition, State};
use foldpath_core::wire::message::ToHost;

/// Largest number of groups in a message of telemetry.
const MAX_TOLD_GROUPS: usize = 48;

/// Telemetry that is being sent, in pieces.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Snapshot<const GROUPS: usize> {
    pub(crate) time: u64,
    state: State,
    rate: f32,
    place: FollowerPosition<f32>,
    angles: [[u8; 4]; GROUPS],
    groups: usize,
    /// Number of groups that were sent; `None` if all were.
    sent: Option<usize>,
}

impl<const GROUPS: usize> Snapshot<GROUPS> {
    #[inline(always)]
    pub(crate) fn none() -> Self {
        Self {
            time: 0,
            state: State::Idle,
            rate: 0.0,
            place: FollowerPosition::default(),
            angles: [[0; 4]; GROUPS],
            groups: 0,
            sent: None,
        }
    }

    /// Takes the state of a follower.
    pub(crate) fn take<const KNOTS: usize>(
        &mut self,
        follower: &Follower<f32, GROUPS, KNOTS>,
        now: u64,
    ) {
        (self.time, self.state) = (now, follower.state());
        (self.rate, self.place) = (follower.rate(), follower.position());
        self.groups = 0;
        for (bytes, angle) in self.angles.iter_mut().zip(follower.angles()) {
            *bytes = angle.to_le_bytes();
            self.groups += 1;
        }
        self.sent = Some(0);
    }

    /// Returns `true` if all pieces were sent.
    pub(crate) fn is_sent(&self) -> bool {
        self.sent.is_none()
    }

    /// Returns the number of groups that were sent.
    pub(crate) fn groups_sent(&self) -> usize {
        self.sent.unwrap_or(self.groups)
    }

    /// Returns the next piece, if there is one.
    pub(crate) fn message(&self) -> Option<ToHost<'_>> {
        let sent = self.sent?;
        let end = self.groups.min(sent + MAX_TOLD_GROUPS);
        Some(ToHost::Telemetry {
            time: self.time,
            state: self.state,
            rate: self.rate,
            place: self.place,
            first: u16::try_from(sent).ok()?,
            angles: self.angles.get(sent..end)?.as_flattened(),
        })
    }

    /// Notes that the piece is on its way.
    pub(crate) fn sent(&mut self) {
        let next = self.sent.map(|sent| sent + MAX_TOLD_GROUPS);
        self.sent = next.filter(|next| *next < self.groups);
    }
}
