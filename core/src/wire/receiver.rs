//! The controller's end of the line: takes frames in order and answers them.
//!
//! Answers are not queued. Each is built from the state at the time when it leaves, so that a full line costs nothing
//! but time.

use crate::follower::Denial;
use crate::wire::frame;
use crate::wire::key::{self, Key, Nonces};
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
    /// A key to take; call [`Receiver::propose`], or do nothing.
    Pair(Key),
    /// The host has got the telemetry of this time, the lowest 32 bits of it, up to this group.
    Seen(u32, u16),
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

/// Two halves of a host's nonce: its id, and on links with a key an upper half.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Host {
    id: u32,
    upper: u32,
}

/// A host, and the session that was offered to it or is open.
#[derive(Clone, Copy, Debug)]
struct Peer<S> {
    host: Host,
    session: u32,
    protection: S,
}

/// Answers that are due.
#[derive(Clone, Copy, Debug, Default)]
struct Due {
    report: bool,
    mismatch: Option<Host>,
    /// A host and the session that is offered to it.
    welcome: Option<(Host, u32)>,
    unknown: Option<u32>,
}

/// Course of the open session so far.
#[derive(Clone, Copy, Debug, Default)]
struct Course {
    next: u16,
    heard: u8,
    gap: Gap,
    refused: Option<ItemRefusal>,
    command: u8,
    denied: Option<Denial>,
}

/// The state machine of the controller's end.
#[derive(Clone, Debug)]
pub struct Receiver<P: Protection = Unkeyed> {
    identity: Identity,
    protection: P,
    greetings: u32,
    epoch: u32,
    offered: Option<Peer<P::Session>>,
    open: Option<Peer<P::Session>>,
    opened: bool,
    due: Due,
    course: Course,
}

/// Gap before a later item: none, seen, or seen and already told to the host.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
enum Gap {
    #[default]
    None,
    Seen,
    Said,
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
            epoch: 0,
            offered: None,
            open: None,
            opened: false,
            due: Due::default(),
            course: Course::default(),
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

    /// Tells the time, microseconds. It is called before all that happens at that time. With room for a key, a report is due
    /// when an [epoch](key::epoch) begins.
    pub fn clock(&mut self, now: u64) {
        if P::KEYED {
            let epoch = key::epoch(now);
            self.due.report |= epoch != self.epoch;
            self.epoch = epoch;
        }
    }

    /// Ends the session. A host without a key learns it from the answer to its next frame, and one with a key from silence.
    /// Either may ask for another session.
    pub fn close(&mut self) {
        (self.offered, self.open) = (None, None);
        (self.opened, self.due, self.course) = (false, Due::default(), Course::default());
    }

    /// Returns the number of the item that is expected next, modulo 2¹⁶.
    #[must_use]
    pub fn next(&self) -> u16 {
        self.course.next
    }

    /// Returns why the expected item was refused, if it was.
    #[must_use]
    pub fn refused(&self) -> Option<ItemRefusal> {
        self.course.refused
    }

    /// Takes a frame while there is room for `room` items. The caller has to answer the event before the next frame.
    pub fn receive<'b>(&mut self, bytes: &'b [u8], room: u16) -> Option<Event<'b>> {
        let session = frame::session(self.identity.node, bytes)?;
        let mut greeting = None;
        let covered = if session == 0 {
            let (upper, covered) = self.protection.greeting(bytes)?;
            greeting = Some(upper);
            covered
        } else {
            let open = self.session() == Some(session);
            let peer = if open {
                &mut self.open
            } else {
                &mut self.offered
            };
            match peer {
                Some(peer) if peer.session == session => {
                    P::take(&mut peer.protection, bytes, self.epoch)?
                }
                _ => self.protection.plain(bytes)?,
            }
        };
        let message = frame::message(covered)?;
        if let Some(upper) = greeting {
            if let ToDevice::Hello {
                version,
                schema,
                id,
            } = message
            {
                self.greet(Host { id, upper }, (version, schema) == (VERSION, SCHEMA));
            }
            return None;
        }
        self.admit(session)?;
        let course = &mut self.course;
        course.heard = course.heard.wrapping_add(1);
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
            ToDevice::Seen { time, groups } => Some(Event::Seen(time, groups)),
            ToDevice::Item { sequence, item } => Some(self.item(sequence, item, room)),
            ToDevice::Command { number, command } => {
                self.due.report = true;
                // A `Hold` does not wait for the command before it, which counts no more then.
                let new = match number.wrapping_sub(course.command) {
                    1 => true,
                    2..=127 => command == Command::Hold,
                    _ => false,
                };
                Some(if new {
                    course.command = number;
                    Event::Command(command)
                } else {
                    Event::Alive
                })
            }
        }
    }

    #[inline(never)]
    fn greet(&mut self, host: Host, understood: bool) {
        if !understood {
            self.due.mismatch = Some(host);
            return;
        }
        // A repeated greeting gets the same session again.
        let known = [&self.open, &self.offered].into_iter().flatten();
        let known = { known }.find(|peer| peer.host == host);
        let session = known.map(|peer| peer.session);
        if let Some(session) = session.or_else(|| self.offer(host)) {
            self.due.welcome = Some((host, session));
        }
    }

    /// Offers a new session to a host, if there is one left.
    fn offer(&mut self, host: Host) -> Option<u32> {
        let session = self.fresh(host.id);
        let nonces = Nonces {
            host: u64::from(host.upper) << 32 | u64::from(host.id),
            device: self.identity.nonce,
        };
        let protection = self.protection.offer(nonces, session, self.epoch)?;
        self.offered = Some(Peer {
            host,
            session,
            protection,
        });
        Some(session)
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
        (self.open, self.offered) = (Some(peer), None);
        (self.opened, self.due.report) = (true, true);
        self.course = Course::default();
        Some(())
    }

    fn item<'b>(&mut self, sequence: u16, item: Item<'b>, room: u16) -> Event<'b> {
        match ahead(sequence, self.course.next) {
            0 if room > 0 => return Event::Item(item),
            // The item came before, and its acknowledgement was lost; or there is no room.
            ..=0 => self.due.report = true,
            // Items behind a refused one are dropped: they are no gap.
            _ if self.course.gap == Gap::None && self.course.refused.is_none() => {
                self.course.gap = Gap::Seen;
                self.due.report = true;
            }
            _ => {}
        }
        Event::Alive
    }

    /// Notes that the item was taken.
    #[inline(never)]
    pub fn took(&mut self) {
        self.course.next = self.course.next.wrapping_add(1);
        (self.course.gap, self.course.refused) = (Gap::None, None);
        self.due.report = true;
    }

    /// Notes that the item was refused. It stays the one that is expected.
    pub fn refuse(&mut self, refusal: ItemRefusal) {
        self.course.refused = Some(refusal);
        self.due.report = true;
    }

    /// Notes that the command was carried out or denied.
    pub fn answer(&mut self, result: Result<(), Denial>) {
        self.course.denied = result.err();
    }

    /// Keeps a key until it was asked for, if there is room for a key and none is there yet.
    pub fn propose(&mut self, key: Key) {
        self.protection.propose(key);
    }

    /// Returns a key that was proposed since the last call, for memory that keeps it without power. Once it is there, it has
    /// to be [taken](Self::pair).
    pub fn proposed(&mut self) -> Option<Key> {
        self.protection.proposed()
    }

    /// Takes a key and ends the session, if there is room for a key and none is there yet. Returns `true` if the key was
    /// taken.
    pub fn pair(&mut self, key: Key) -> bool {
        let taken = self.protection.pair(key);
        if taken {
            (self.open, self.offered) = (None, None);
            self.due = Due::default();
        }
        taken
    }

    /// Writes a frame of the open session with a message that is no answer, and returns it; `None` if there is no room. Call
    /// [`posted`](Self::posted) when it is on its way.
    pub fn post<'b>(&self, message: &ToHost<'_>, buffer: &'b mut [u8]) -> Option<&'b [u8]> {
        self.seal(self.session()?, 0, message, buffer)
    }

    /// Notes that the frame of [`post`](Self::post) is on its way.
    pub fn posted(&mut self) {
        if let Some(peer) = &mut self.open {
            P::advance(&mut peer.protection);
        }
    }

    /// Writes a frame of the open session, or an answer for the host with this upper half of its nonce.
    #[inline(never)]
    fn seal<'b>(
        &self,
        session: u32,
        upper: u32,
        message: &ToHost<'_>,
        buffer: &'b mut [u8],
    ) -> Option<&'b [u8]> {
        let length = frame::write(self.identity.node, session, message, buffer)?;
        let open = self.open.as_ref().filter(|peer| peer.session == session);
        let length = match open {
            Some(peer) => P::close(&peer.protection, buffer, length)?,
            None => self.protection.close_greeting(upper, buffer, length)?,
        };
        buffer.get(..length)
    }

    /// Makes a report due: something has changed that the host should know.
    pub fn announce(&mut self) {
        self.due.report = self.open.is_some();
    }

    /// Returns `true` if the next answer is a report, which goes before all others. The others are for hosts that have no
    /// session, and should leave room on the line.
    #[must_use]
    pub fn reports(&self) -> bool {
        self.due.report && self.open.is_some()
    }

    /// Writes the next answer to `buffer`, if one is due. It stays due until [`sent`](Self::sent). A report says what
    /// `status` says of the follower and of its path, and that there is room for `room` items.
    pub fn poll<'b>(
        &mut self,
        status: &Report,
        room: u16,
        buffer: &'b mut [u8],
    ) -> Option<&'b [u8]> {
        let Identity {
            nonce, capacity, ..
        } = self.identity;
        if let Some(session) = self.session()
            && self.due.report
        {
            let message = ToHost::Report(self.report(status, room));
            self.seal(session, 0, &message, buffer)
        } else if let Some(Host { id, upper }) = self.due.mismatch {
            let (version, schema) = (VERSION, SCHEMA);
            let message = ToHost::Mismatch {
                id,
                version,
                schema,
            };
            self.seal(0, upper, &message, buffer)
        } else if let Some((Host { id, upper }, session)) = self.due.welcome {
            let message = ToHost::Welcome {
                id,
                session,
                nonce,
                epoch: key::low_byte(self.epoch),
                capacity,
            };
            self.seal(0, upper, &message, buffer)
        } else {
            self.seal(self.due.unknown?, 0, &ToHost::Unknown, buffer)
        }
    }

    /// Notes that the answer of [`poll`](Self::poll) is on its way.
    pub fn sent(&mut self) {
        if self.reports() {
            self.posted();
            self.due.report = false;
            if self.course.gap == Gap::Seen {
                self.course.gap = Gap::Said;
            }
        } else if self.due.mismatch.take().is_none() && self.due.welcome.take().is_none() {
            self.due.unknown = None;
        }
    }

    fn report(&self, status: &Report, room: u16) -> Report {
        Report {
            next: self.course.next,
            limit: self.course.next.wrapping_add(room),
            heard: self.course.heard,
            epoch: key::low_byte(self.epoch),
            gap: self.course.gap == Gap::Seen,
            refused: self.course.refused,
            command: self.course.command,
            denied: self.course.denied,
            ..*status
        }
    }
}
