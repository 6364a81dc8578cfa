//! The controller's end of the line: takes frames in order and answers them.
//!
//! Answers are not queued. Each is built from the state at the time when it leaves, so that a full line costs nothing
//! but time.

use crate::follower::{Denial, FollowerPosition, Reason, State};
use crate::wire::frame;
use crate::wire::key::Key;
use crate::wire::message::{
    Capacity, Command, Item, ItemRefusal, Report, SCHEMA, ToDevice, ToHost, VERSION,
};
use crate::wire::protection::{Protection, Unkeyed};
use crate::wire::sequence::ahead;

/// Factor that spreads the bits of a nonce: 2⁶⁴ over the golden ratio, made odd.
const MIX: u64 = 0x9e37_79b9_7f4a_7c15;

/// Content of a frame that the controller has to act on.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Event<'a> {
    /// The item that is expected; call [`Receiver::took`] or [`Receiver::refuse`].
    Item(Item<'a>),
    /// A command that was not heard before; call [`Receiver::answer`].
    Command(Command),
    /// A sign of life, as every other frame of the session is.
    Alive,
    /// A key to take; call [`Receiver::pair`], or do nothing.
    Pair(Key),
}

/// State of the controller for a report, which the receiver does not know itself.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Status {
    /// State of the follower.
    pub state: State,
    /// Reason why the follower does not run at full speed.
    pub reason: Reason,
    /// Position of the follower on the path.
    pub place: FollowerPosition<f32>,
    /// Number of the path on which the position is; 0 if there was none.
    pub path: u32,
    /// `true` if it is known where the sheet stands.
    pub known: bool,
    /// `true` if the stop line holds the motion.
    pub stopped: bool,
    /// Number of items for which there is room.
    pub room: u16,
}

/// The controller as it presents itself to hosts.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Identity {
    /// Number of the controller on its line; 0 if it is the only one.
    pub node: u8,
    /// Number that tells this run of the controller from all its other runs, so that frames of other runs do nothing: a
    /// random number of the hardware, or a count in memory that keeps it without power.
    pub nonce: u64,
    /// Room of the controller.
    pub capacity: Capacity,
}

/// A host, and the session that was offered to it or is open.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Peer {
    id: u32,
    session: u32,
}

/// Answers that are due.
#[derive(Clone, Copy, Debug, Default)]
struct Due {
    mismatch: Option<u32>,
    welcome: Option<Peer>,
    unknown: Option<u32>,
    report: bool,
}

/// The state machine of the controller's end.
#[derive(Clone, Debug)]
pub struct Receiver<P = Unkeyed> {
    identity: Identity,
    protection: P,
    greetings: u32,
    offered: Option<Peer>,
    open: Option<Peer>,
    opened: bool,
    due: Due,
    next: u16,
    heard: u8,
    /// Gap before a later item: none, seen, or seen and already told to the host.
    gap: Gap,
    refused: Option<ItemRefusal>,
    command: u8,
    denied: Option<Denial>,
}

#[derive(Clone, Copy, Debug, PartialEq)]
enum Gap {
    None,
    Seen,
    Said,
}

impl Receiver {
    /// Creates a receiver without a session and without a key.
    #[must_use]
    pub fn new(identity: Identity) -> Self {
        Self::protected(identity, Unkeyed)
    }
}

impl<P: Protection> Receiver<P> {
    /// Creates a receiver without a session, whose frames are protected.
    #[must_use]
    pub fn protected(identity: Identity, protection: P) -> Self {
        // Every bit of the nonce changes the upper half of the product.
        let [.., a, b, c, d] = identity.nonce.wrapping_mul(MIX).to_le_bytes();
        Self {
            identity,
            protection,
            greetings: u32::from_le_bytes([a, b, c, d]),
            offered: None,
            open: None,
            opened: false,
            due: Due::default(),
            next: 0,
            heard: 0,
            gap: Gap::None,
            refused: None,
            command: 0,
            denied: None,
        }
    }

    /// Returns the session that is open.
    #[must_use]
    pub fn session(&self) -> Option<u32> {
        self.open.map(|peer| peer.session)
    }

    /// Returns `true` if a session has begun since the last call.
    pub fn opened(&mut self) -> bool {
        core::mem::take(&mut self.opened)
    }

    /// Ends the session. The host learns it from the answer to its next frame, and may ask for another one.
    pub fn close(&mut self) {
        let greetings = self.greetings;
        *self = Self::protected(self.identity, self.protection.clone());
        self.greetings = greetings;
    }

    /// Returns the number of the item that is expected next, modulo 2¹⁶.
    #[must_use]
    pub fn next(&self) -> u16 {
        self.next
    }

    /// Returns why the expected item was refused, if it was.
    #[must_use]
    pub fn refused(&self) -> Option<ItemRefusal> {
        self.refused
    }

    /// Takes a frame while there is room for `room` items. The caller has to answer the event before the next frame.
    pub fn receive<'b>(&mut self, bytes: &'b [u8], room: u16) -> Option<Event<'b>> {
        let session = frame::session(self.identity.node, bytes)?;
        let message = frame::message(self.protection.take(session, bytes)?)?;
        if let ToDevice::Hello {
            version,
            schema,
            id,
        } = message
        {
            if session == 0 {
                self.greet(id, (version, schema) == (VERSION, SCHEMA));
            }
            return None;
        }
        self.admit(session)?;
        self.heard = self.heard.wrapping_add(1);
        match message {
            ToDevice::Hello { .. } => None,
            ToDevice::Pair(key) => Some(match <[u8; Key::SIZE]>::try_from(key) {
                Ok(key) => Event::Pair(Key::new(key)),
                Err(_) => Event::Alive,
            }),
            ToDevice::Alive => {
                self.due.report = true;
                Some(Event::Alive)
            }
            ToDevice::Item { sequence, item } => Some(self.item(sequence, item, room)),
            ToDevice::Command { number, command } => {
                self.due.report = true;
                let new = number == self.command.wrapping_add(1);
                Some(if new {
                    Event::Command(command)
                } else {
                    Event::Alive
                })
            }
        }
    }

    fn greet(&mut self, id: u32, understood: bool) {
        if !understood {
            self.due.mismatch = Some(id);
            return;
        }
        // A repeated greeting gets the same session again.
        let known = [self.open, self.offered].into_iter().flatten();
        let known = { known }.find(|peer| peer.id == id && self.protection.knows(peer.session));
        if let Some(peer) = known.or_else(|| self.offer(id)) {
            self.due.welcome = Some(peer);
        }
    }

    /// Offers a new session to a host, if there is one left.
    fn offer(&mut self, id: u32) -> Option<Peer> {
        let session = self.fresh(id);
        let offers = self.protection.offer(id, self.identity.nonce, session);
        offers.then(|| *self.offered.insert(Peer { id, session }))
    }

    /// Returns a new session for a host: neither 0 nor the open one.
    fn fresh(&mut self, id: u32) -> u32 {
        loop {
            self.greetings = self.greetings.wrapping_add(1);
            let session = id.wrapping_add(self.greetings);
            if session != 0 && self.session() != Some(session) {
                return session;
            }
        }
    }

    /// Returns `Some` if frames of this session count: those of the open session, and those of the offered one, whose
    /// first frame opens it.
    fn admit(&mut self, session: u32) -> Option<()> {
        if self.session() == Some(session) {
            return Some(());
        }
        let Some(peer) = self.offered.filter(|peer| peer.session == session) else {
            self.due.unknown = Some(session);
            return None;
        };
        let (greetings, due) = (self.greetings, self.due);
        self.protection.begin();
        *self = Self::protected(self.identity, self.protection.clone());
        self.greetings = greetings;
        (self.open, self.opened) = (Some(peer), true);
        self.due = Due {
            report: true,
            ..due
        };
        Some(())
    }

    fn item<'b>(&mut self, sequence: u16, item: Item<'b>, room: u16) -> Event<'b> {
        match ahead(sequence, self.next) {
            0 if room > 0 => return Event::Item(item),
            // The item came before, and its acknowledgement was lost; or there is no room.
            ..=0 => self.due.report = true,
            // Items behind a refused one are dropped: they are no gap.
            _ if self.gap == Gap::None && self.refused.is_none() => {
                self.gap = Gap::Seen;
                self.due.report = true;
            }
            _ => {}
        }
        Event::Alive
    }

    /// Notes that the item was taken.
    pub fn took(&mut self) {
        self.next = self.next.wrapping_add(1);
        (self.gap, self.refused) = (Gap::None, None);
        self.due.report = true;
    }

    /// Notes that the item was refused. It stays the one that is expected.
    pub fn refuse(&mut self, refusal: ItemRefusal) {
        self.refused = Some(refusal);
        self.due.report = true;
    }

    /// Notes that the command was carried out or denied.
    pub fn answer(&mut self, result: Result<(), Denial>) {
        self.command = self.command.wrapping_add(1);
        self.denied = result.err();
    }

    /// Takes a key and ends the session, if there is room for a key and none is there yet. Returns `true` if the key was
    /// taken.
    pub fn pair(&mut self, key: Key) -> bool {
        let taken = self.protection.pair(key);
        if taken {
            *self = Self::protected(self.identity, self.protection.clone());
        }
        taken
    }

    /// Returns a key that was taken since the last call, for memory that keeps it without power.
    pub fn new_key(&mut self) -> Option<Key> {
        self.protection.new_key()
    }

    /// Writes a frame of the open session with a message that is no answer, and returns it; `None` if there is no room. Call
    /// [`posted`](Self::posted) when it is on its way.
    pub fn post<'b>(&self, message: &ToHost<'_>, buffer: &'b mut [u8]) -> Option<&'b [u8]> {
        self.seal(self.session()?, message, buffer)
    }

    /// Notes that the frame of [`post`](Self::post) is on its way.
    pub fn posted(&mut self) {
        if let Some(session) = self.session() {
            self.protection.advance(session);
        }
    }

    fn seal<'b>(
        &self,
        session: u32,
        message: &ToHost<'_>,
        buffer: &'b mut [u8],
    ) -> Option<&'b [u8]> {
        let length = frame::write(self.identity.node, session, message, buffer)?;
        let length = self.protection.close(session, buffer, length)?;
        buffer.get(..length)
    }

    /// Makes a report due: something has changed that the host should know.
    pub fn announce(&mut self) {
        self.due.report = self.open.is_some();
    }

    /// Writes the next answer to `buffer`, if one is due. It stays due until [`sent`](Self::sent).
    pub fn poll<'b>(&mut self, status: &Status, buffer: &'b mut [u8]) -> Option<&'b [u8]> {
        let Identity {
            nonce, capacity, ..
        } = self.identity;
        if let Some(id) = self.due.mismatch {
            let (version, schema) = (VERSION, SCHEMA);
            let message = ToHost::Mismatch {
                id,
                version,
                schema,
            };
            self.seal(0, &message, buffer)
        } else if let Some(Peer { id, session }) = self.due.welcome {
            let message = ToHost::Welcome {
                id,
                session,
                nonce,
                capacity,
            };
            self.seal(0, &message, buffer)
        } else if let Some(session) = self.due.unknown {
            self.seal(session, &ToHost::Unknown, buffer)
        } else if let Some(peer) = self.open.filter(|_| self.due.report) {
            let message = ToHost::Report(self.report(status));
            self.seal(peer.session, &message, buffer)
        } else {
            None
        }
    }

    /// Notes that the answer of [`poll`](Self::poll) is on its way.
    pub fn sent(&mut self) {
        if self.due.mismatch.take().is_none()
            && self.due.welcome.take().is_none()
            && self.due.unknown.take().is_none()
        {
            self.posted();
            self.due.report = false;
            if self.gap == Gap::Seen {
                self.gap = Gap::Said;
            }
        }
    }

    fn report(&self, status: &Status) -> Report {
        Report {
            next: self.next,
            limit: self.next.wrapping_add(status.room),
            heard: self.heard,
            gap: self.gap == Gap::Seen,
            refused: self.refused,
            command: self.command,
            denied: self.denied,
            state: status.state,
            reason: status.reason,
            place: status.place,
            path: status.path,
            known: status.known,
            stopped: status.stopped,
        }
    }
}
