//! A controller under test. Every byte, tick and level of the stop line is followed by a check of what the controller
//! has done.

use std::collections::VecDeque;

use foldpath_controller::retained::{MEASURED, STOPPED};
use foldpath_core::acceptance::{Refusal, most_commanded};
use foldpath_core::follower::{FollowerPosition, Reason, State};
use foldpath_core::wire::cobs::Deframer;
use foldpath_core::wire::frame as wire;
use foldpath_core::wire::message::{ItemRefusal, Report, ToHost};
use foldpath_core::wire::protection::Unkeyed;
use foldpath_core::{GroupLimits, Interpolation};
use foldpath_test_support::Measure as _;

use super::stream::{Frame, Message, Sent, Stream};
use crate::path::{BOARD, CLOSURE, Device, Path, settings};

/// Number of setpoints for which a device has room.
const QUEUE: usize = 16;

/// Visible state of a follower; floating-point numbers as bits.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Look {
    state: State,
    reason: Reason,
    next: u32,
    room: usize,
    place: (u32, u32),
    rate: u32,
    angles: [Option<u32>; 4],
}

pub(crate) struct Subject<'a> {
    pub(crate) device: Device,
    pub(crate) now: u64,
    /// Session that the device told last.
    pub(crate) session: u32,
    /// Last report of that session.
    pub(crate) report: Option<Report>,
    /// Session that the device has offered.
    pub(crate) offered: Option<u32>,
    /// Setpoints that were taken, from the one at or before the place on.
    pub(crate) taken: VecDeque<Sent>,
    pub(crate) kind: Interpolation,
    pub(crate) limits: Vec<GroupLimits>,
    /// `true` if the sheet is that of Miura's fold.
    pub(crate) miura: bool,
    /// `true` if the sheet is that of Miura's fold, and every setpoint was sent unchanged.
    pub(crate) pristine: bool,
    /// Number of knots that were passed.
    pub(crate) passed: u64,
    /// Hinge that is commanded alone, and its angle; and the number of ticks in which it moved.
    alone: Option<(u32, f32)>,
    pub(crate) jogged: u64,
    /// `true` while nobody takes the device's bytes.
    pub(crate) deaf: bool,
    /// `true` if the answers that come may be old.
    behind: bool,
    path: &'a Path,
    /// Level of the stop line.
    level: bool,
    /// `true` if nobody has asked to resume since the stop line was drawn.
    drawn: bool,
    /// `true` once a hinge was measured far from its command, and once one was so or its sensor told no number.
    away: bool,
    stuck: bool,
    /// Time when the host was last heard, microseconds.
    heard: u64,
    boots: u32,
    items: Stream,
    answers: Deframer<256>,
    /// Number of items that the session has granted in all.
    granted: Option<u64>,
    /// Session of the last report.
    open: Option<u32>,
    /// Number of reports.
    reports: u64,
    /// Number of items that were acknowledged in the session.
    acknowledged: u64,
    last_tick: u64,
}

fn bits(place: FollowerPosition<f32>) -> (u32, u32) {
    (place.knot, place.into.to_bits())
}

impl<'a> Subject<'a> {
    pub(crate) fn new(path: &'a Path) -> Self {
        Self {
            device: Device::protected(settings(1), Unkeyed),
            now: 1000,
            session: 0,
            report: None,
            offered: None,
            taken: VecDeque::new(),
            kind: Interpolation::Hermite,
            limits: Vec::new(),
            miura: false,
            pristine: false,
            passed: 0,
            alone: None,
            jogged: 0,
            deaf: false,
            behind: false,
            path,
            level: false,
            drawn: false,
            away: false,
            stuck: false,
            heard: 0,
            boots: 0,
            items: Stream::default(),
            answers: Deframer::default(),
            granted: None,
            open: None,
            reports: 0,
            acknowledged: 0,
            last_tick: 0,
        }
    }

    fn look(&self) -> Look {
        let follower = self.device.follower();
        let mut angles = [None; 4];
        for (bits, angle) in angles.iter_mut().zip(follower.angles()) {
            *bits = Some(angle.to_bits());
        }
        let look = Look {
            state: follower.state(),
            reason: follower.reason(),
            next: follower.next(),
            room: follower.room(),
            place: bits(follower.position()),
            rate: follower.rate().to_bits(),
            angles,
        };
        let held = look.reason != Reason::None;
        match look.state {
            State::Running => assert!(matches!(
                look.reason,
                Reason::None | Reason::Lag(_) | Reason::Approach | Reason::LateTick
            )),
            State::Holding => assert!(held),
            State::Faulted => assert!(matches!(look.reason, Reason::Fault(_))),
            _ => {}
        }
        assert!((0.0..=1.0).contains(&follower.rate()));
        let moves = matches!(look.state, State::Running | State::Holding);
        assert!(moves || follower.rate().to_bits() == 0, "{look:?}");
        assert!(
            follower.rates().iter().all(|rate| rate.is_finite()),
            "{:?}",
            follower.rates()
        );
        assert!(follower.left() >= 0.0, "{}", follower.left());
        assert_eq!(look.room + self.taken.len(), QUEUE, "{look:?}");
        look
    }

    /// Hands the device a byte of the host, and checks what the byte has done.
    pub(crate) fn byte(&mut self, byte: u8) {
        let frame = self.items.push(byte);
        // Looking is slow, so that within a frame only one byte in eight is checked.
        let looks = frame.is_some() || self.now.is_multiple_of(8);
        let before = looks.then(|| self.look());
        self.device.byte(byte, self.now);
        while self.device.is_busy() {
            self.device.poll(self.now);
        }
        match frame {
            Some(Ok(frame)) => self.obeyed(before.unwrap(), frame),
            // Bytes that are no frame change nothing.
            _ => assert_eq!(before.map(|_| self.look()), before),
        }
    }

    /// Checks that a frame has done no more than it may.
    fn obeyed(&mut self, before: Look, frame: Frame) {
        let follower = self.device.follower();
        let (room, next) = (follower.room(), follower.next());
        if follower.state() == State::Idle || before.state == State::Idle {
            self.taken.clear();
        }
        if room < before.room || before.state == State::Idle && room < QUEUE {
            let Message::Setpoint(sent) = frame.message.clone() else {
                panic!("{frame:?} fills the queue");
            };
            assert_eq!(sent.number.wrapping_add(1), next);
            self.taken.push_back(sent);
        }
        let after = self.look();
        assert_eq!(room, after.room);
        if before.state == State::Idle && after.state == State::Ready {
            let (view, head) = self.device.sheet().view().unwrap();
            (self.kind, self.limits) = (head.interpolation, view.limits.to_vec());
        }
        let (open, reports) = (self.open, self.reports);
        let (last, behind) = (self.report.map_or(0, |report| report.command), self.behind);
        self.listen();
        let asks = matches!(frame.message, Message::Alive);
        if asks && !self.deaf && open == Some(frame.session) {
            assert!(self.reports > reports, "no answer");
        }
        let opened = self.deaf || self.open != open;
        let begun = Look {
            state: State::Holding,
            reason: Reason::Session,
            ..before
        };
        let from = [before, begun];
        let sessions = if opened && before.state == State::Running {
            2
        } else {
            1
        };
        let allowed = from[..sessions]
            .iter()
            .any(|from| frame_allows(&frame.message, from, &after));
        assert!(allowed, "{frame:?}: {before:?} to {after:?}");
        if let Message::Command(number, command) = frame.message
            && !(self.deaf || behind || opened)
            && before != after
        {
            // A new command is numbered one more than the command before, or more if it is to hold.
            match number.wrapping_sub(last) {
                1 => {}
                2..=127 => assert_eq!(command, 1),
                _ => panic!("command {number} after {last}"),
            }
        }
        self.heard = self.now;
        let takes_up = before.state == State::Idle && matches!(frame.message, Message::Setpoint(_));
        if takes_up || matches!(frame.message, Message::Command(_, 6 | 7)) {
            // Another hinge may be moved in between, another sheet taken up, or the place forgotten, so that an operator's word
            // counts for this one again.
            self.drives(0);
        }
        let started = before.state == State::Ready && after.state == State::Running;
        if started {
            assert!(!self.drawn);
            self.executes();
            self.begins(&before);
        }
        let known = [before, after].map(|look| look.angles != [None; 4]);
        let command = match frame.message {
            Message::Command(_, command) => Some(command),
            _ => None,
        };
        match known {
            // It is measured, or an operator has told it; the start takes it up.
            [false, true] => assert!(command == Some(0) && started, "{frame:?}"),
            // An operator takes it back, or a setpoint is the first of another sheet.
            [true, false] => {
                let other = matches!(frame.message, Message::Setpoint(_));
                assert!(command == Some(6) || other, "{frame:?}");
            }
            _ => assert_eq!(after.angles, before.angles, "{frame:?}"),
        }
        assert_eq!(after.rate, before.rate);
        if matches!(frame.message, Message::Command(_, 2)) && !self.level {
            self.drawn &= self.device.follower().is_stopped();
        }
        let report = self.report.filter(|_| room < before.room && !self.deaf);
        if let Some(report) = report {
            // The item was the one that was expected, in the open session.
            assert_eq!(self.session, frame.session);
            assert_eq!(u32::from(report.next.wrapping_sub(1)), frame.sequence);
        }
    }

    /// Sets the level of the stop line, and checks its effect.
    pub(crate) fn stop(&mut self, drawn: bool) {
        let before = self.look();
        self.device.stop(drawn);
        let after = self.look();
        self.level = drawn;
        self.drawn |= drawn;
        assert_eq!(after.angles, before.angles);
        if drawn {
            assert_eq!(after.rate, 0);
            let held = before.state == State::Running && after.state == State::Holding;
            assert!(
                held || before.state == after.state,
                "{before:?} to {after:?}"
            );
            let faulted = after.state == State::Faulted;
            assert!(faulted || after.reason == Reason::StopLine);
            assert!(self.device.follower().is_stopped());
        } else {
            assert_eq!(after, before);
        }
    }

    /// Lets time pass until `now`, and checks the tick.
    pub(crate) fn tick(&mut self, now: u64) {
        let before = self.look();
        let is_late = now.saturating_sub(self.now) > 10_000;
        self.now = self.now.max(now);
        self.device.tick(now);
        let knot = self.device.follower().position().knot;
        // A fault that a record has kept over a reset has no path.
        let pathless = before.state == State::Faulted && self.taken.is_empty();
        let on_path = !pathless && !matches!(before.state, State::Idle | State::Ready);
        while on_path && self.taken.front().is_some_and(|sent| sent.number != knot) {
            self.taken.pop_front();
            self.passed += 1;
        }
        let after = self.look();
        let runs = after.state == State::Running;
        assert!(match after.reason {
            Reason::LateTick => is_late,
            Reason::None | Reason::Approach => !(runs && is_late),
            _ => true,
        });
        assert!(
            tick_allows(&before, &after, self.away),
            "{before:?} to {after:?}"
        );
        assert_eq!(after.next, before.next);
        let lost = self.away && after.angles == [None; 4];
        let latched = !matches!(
            before.reason,
            Reason::None | Reason::Underrun | Reason::Lag(_) | Reason::Approach | Reason::LateTick
        );
        if self.drawn
            || !matches!(before.state, State::Running | State::Holding)
            || latched && before.rate == 0
        {
            assert_eq!(after.place, before.place);
            // A hinge was measured elsewhere: from now on none is commanded.
            assert!(lost || after.angles == before.angles, "{after:?}");
        }
        let passed = now.saturating_sub(self.last_tick).min(10_000);
        if on_path && !lost {
            self.executes();
            self.moves(&before, passed);
        }
        if after.state == State::Running {
            assert!(self.now <= self.heard + 500_000, "a silent host");
        }
        self.rates(&before, &after, passed);
        self.drives(passed);
        self.last_tick = self.last_tick.max(now);
    }

    /// Checks that at most one hinge is commanded while it is not known where the sheet stands, that it moves by at most
    /// 0.1 rad/s, and only while there is no path and nothing holds. Hinges of odd numbers that are none of the sheet's are
    /// measured at 0.25 rad.
    fn drives(&mut self, passed: u64) {
        let (known, hinges) = (
            self.device.follower().is_known(),
            self.device.sheet().hinges().count(),
        );
        let mut commanded = Vec::new();
        self.device.drive(|hinge, _, target| {
            commanded.extend(target.map(|target| (hinge, target.angle)));
            let measured = hinge as usize >= hinges && hinge % 2 == 1;
            measured.then_some(0.25.into())
        });
        assert_eq!(self.device.condition().commanded, commanded.len());
        if known {
            self.alone = None;
            return;
        }
        assert!(commanded.len() <= 1, "{commanded:?}");
        let before = core::mem::replace(&mut self.alone, commanded.first().copied());
        let Some((hinge, angle)) = self.alone else {
            return;
        };
        assert!(hinge < 64 && angle.abs() <= BOARD.upper + 0.1);
        let follower = self.device.follower();
        let idle = follower.state() == State::Idle && !follower.is_stopped();
        #[allow(clippy::cast_precision_loss, reason = "at most 10,000")]
        let most = if idle { 1e-7 * passed as f32 } else { 0.0 };
        if let Some((_, was)) = before.filter(|(other, _)| *other == hinge) {
            assert!(
                (angle - was).abs() <= most * 1.001 + 1e-6 * most.signum().max(0.0),
                "{was} to {angle} in {passed}"
            );
            self.jogged += u64::from(angle.to_bits() != was.to_bits());
        }
    }

    /// Checks that the rate of the clock changes by at most 4 a second, or falls by 32 because of a hinge that is elsewhere or
    /// whose sensor tells no number, and is 0 if no path is left.
    fn rates(&self, before: &Look, after: &Look, passed: u64) {
        // On other paths, far from time 0, the end of a long segment is rounded.
        if after.state == State::Faulted || !self.pristine {
            return;
        }
        let [from, to] = [before.rate, after.rate].map(f32::from_bits);
        #[allow(clippy::cast_precision_loss, reason = "at most 10,000")]
        let most = if self.stuck && to < from { 32e-6 } else { 4e-6 } * passed as f32;
        // Near the end the path time left is rounded, and the rate grows as its square root.
        // An approach has a way of its own before that of the path.
        let follower = self.device.follower();
        let dry = follower.left() <= 0.0 && !follower.is_approaching();
        let most = most + if dry || from < 0.01 { 1e-3 } else { 1e-5 };
        assert!((to - from).abs() <= most, "{from} to {to}");
        assert!(!dry || to <= 1e-3, "{to} with nothing left");
    }

    /// Checks that a start moves nothing: groups that had a command keep it, and all stand near the beginning of the path.
    fn begins(&self, before: &Look) {
        let place = self.device.follower().position();
        for (group, angle) in self.device.follower().angles().iter().enumerate() {
            if let Some(before) = before.angles[group] {
                assert_eq!(angle.to_bits(), before);
            }
            if let Some(begin) = self.sent(place, group) {
                let off = (begin - f64::from(*angle)).abs();
                assert!(off <= 0.1 + 1e-6 * (1.0 + begin.abs()), "{angle} {begin}");
            }
        }
    }

    /// Checks that the commanded angles are the ones that were sent, and within their limits.
    fn executes(&self) {
        let follower = self.device.follower();
        let (place, angles) = (follower.position(), follower.angles());
        assert_eq!(angles.len(), self.limits.len());
        assert!(!self.taken.is_empty(), "{place:?}");
        for (group, (angle, limits)) in angles.iter().zip(&self.limits).enumerate() {
            let within = limits.lower <= *angle && *angle <= limits.upper;
            if follower.is_approaching() {
                continue;
            }
            assert!(within, "{angle} beyond {limits:?}");
            let sent = self.sent(place, group);
            let range = f64::from(limits.upper) - f64::from(limits.lower);
            let tolerance = if place.into > 0.0 {
                4e-6 * (1.0 + range)
            } else {
                0.0
            };
            let off = sent.map_or(0.0, |sent| (sent - f64::from(*angle)).abs());
            assert!(off <= tolerance, "{angle} instead of {sent:?} at {place:?}");
        }
        if follower.is_approaching() {
            return;
        }
        // Whatever was altered and accepted, angles as well as rates, closes in every tick.
        if self.miura {
            let residual = self.path.residual(angles);
            let most = f64::from(most_commanded(CLOSURE, 4));
            assert!(residual <= most, "{residual:e} at {place:?}");
        }
        let at_knot = self.miura && place.into.abs().to_bits() == 0;
        if at_knot || self.pristine && self.now.is_multiple_of(4) {
            let residual = self.path.residual(angles);
            assert!(residual <= f64::from(CLOSURE), "{residual:e} at {place:?}");
        }
    }

    /// Returns the angle of a group at a place of the path that was taken, from the sent setpoints; `None` between
    /// knots if half angles are interpolated.
    fn sent(&self, place: FollowerPosition<f32>, group: usize) -> Option<f64> {
        let width = self.kind.width();
        let node = |sent: &Sent| {
            let numbers = &sent.nodes[width * group..][..2];
            [f64::from(numbers[0]), f64::from(numbers[1])]
        };
        let from = self.taken.front()?;
        assert_eq!(from.number, place.knot);
        let [p, u] = node(from);
        if place.into.abs().to_bits() == 0 {
            return Some(p);
        }
        let to = &self.taken[1];
        let ([q, v], span) = (node(to), f64::from(to.span));
        let s = f64::from(place.into) / span;
        assert!((0.0..=1.0).contains(&s), "{place:?} of {span}");
        let hermite = || {
            let (r, t) = (1.0 - s, s);
            let basis = [(1.0 + 2.0 * t) * r * r * p, t * r * r * span * u];
            let other = [t * t * (3.0 - 2.0 * t) * q, -t * t * r * span * v];
            basis.iter().chain(&other).sum::<f64>()
        };
        let angle = match self.kind {
            Interpolation::Linear => p + (q - p) * s,
            Interpolation::Hermite => hermite(),
            _ => return None,
        };
        let limits = &self.limits[group];
        Some(angle.clamp(limits.lower.into(), limits.upper.into()))
    }

    /// Checks that no group is faster than it may be: than the limit of the path, and than that of the board. Speeds of
    /// half angles are bounded within a sixteenth.
    fn moves(&self, before: &Look, passed: u64) {
        let half = !matches!(self.kind, Interpolation::Linear | Interpolation::Hermite);
        let slack = if half { 17.0 / 16.0 } else { 1.0001 };
        let angles = self.device.follower().angles().iter().zip(&before.angles);
        for (group, ((angle, before), limits)) in angles.zip(&self.limits).enumerate() {
            let before = f32::from_bits(before.unwrap());
            let moved = (f64::from(*angle) - f64::from(before)).abs();
            let range = f64::from(limits.upper) - f64::from(limits.lower);
            // A group that no hinge follows moves nothing, so that the board has no limit for it.
            let mut hinges = self.device.sheet().hinges();
            let followed = hinges.any(|hinge| hinge.group.index() == group);
            let board = if followed { BOARD.speed } else { f32::MAX };
            let speed = f64::from(limits.speed.min(board));
            #[allow(clippy::cast_precision_loss, reason = "at most 10,000")]
            let most = speed * passed as f64 * 1e-6 * slack;
            assert!(
                moved <= most + 8e-6 * (1.0 + range),
                "{moved} after {before}"
            );
        }
    }

    /// Lets the device answer.
    pub(crate) fn listen(&mut self) {
        let before = self.look();
        self.behind |= self.deaf;
        self.device.poll(self.now);
        assert_eq!(self.look(), before);
        while !self.deaf
            && let Some(byte) = self.device.take()
        {
            // An answer that found no room before may find room now.
            self.device.poll(self.now);
            let Some(frame) = self.answers.push(byte) else {
                continue;
            };
            let frame = frame.to_vec();
            self.answered(&frame);
        }
        self.behind &= self.deaf;
    }

    fn answered(&mut self, frame: &[u8]) {
        let Some((session, message)) = wire::open(frame) else {
            panic!("no frame: {frame:?}");
        };
        match message {
            ToHost::Report(report) => self.reported(session, report),
            ToHost::Telemetry { rate, angles, .. } => {
                assert!((0.0..=1.0).contains(&rate) && angles.len() <= 16);
            }
            ToHost::Welcome { session, .. } => self.offered = Some(session),
            _ => {}
        }
    }

    /// Begins the accounts of this session.
    pub(crate) fn enter(&mut self, session: u32) {
        (self.session, self.report) = (session, None);
        (self.granted, self.acknowledged) = (None, 0);
    }

    fn reported(&mut self, session: u32, report: Report) {
        if self.session != session {
            self.enter(session);
        }
        self.open = Some(session);
        self.reports += 1;
        let came = report
            .next
            .wrapping_sub(self.report.map_or(0, |old| old.next));
        self.acknowledged += u64::from(came);
        let room = report.limit.wrapping_sub(report.next);
        assert!(usize::from(room) <= QUEUE, "{report:?}");
        // No room is granted to a path that has to wait for the path of an earlier session.
        let other = self.acknowledged == 0 && self.device.follower().rate() > 0.0;
        assert!(!other || self.behind || room == 0, "{report:?}");
        let granted = self.acknowledged + u64::from(room);
        // The credit never shrinks, and a host that keeps to it is never refused for lack of room.
        if let Some(before) = self.granted {
            assert!(granted >= before, "{before} {report:?} {:?}", self.report);
        }
        assert_ne!(report.refused, Some(ItemRefusal::Setpoint(Refusal::Full)));
        self.granted = Some(granted);
        self.report = Some(report);
    }

    /// Measures a hinge at `off` radians from its command.
    pub(crate) fn measure(&mut self, hinge: u32, off: f32) {
        let member = self.device.sheet().hinges().nth(hinge as usize);
        let Some(member) = member else { return };
        // A hinge whose place is not known is measured near the beginning of the path.
        let begin = self.taken.front().map(|sent| sent.nodes[0]);
        let command = self.device.follower().hinge(member).or(begin);
        if let Some(angle) = command {
            self.device
                .follower_mut()
                .measure(hinge, member, angle + off);
            // False for a NaN, which tells of a sensor that has failed.
            self.away |= off.abs() >= 0.149;
            self.stuck |= self.away || off.is_nan();
        }
    }

    /// Resets the board, which keeps the place and the angles.
    pub(crate) fn reset(&mut self) {
        let record = self.device.record(self.boots, self.boots);
        self.boots += 1;
        self.device = Device::protected(settings(u64::from(self.boots) << 40), Unkeyed);
        self.device.restore(&record, true);
        (self.answers, self.items) = (Deframer::default(), Stream::default());
        self.enter(0);
        self.taken.clear();
        self.alone = None;
        self.level = false;
        (self.last_tick, self.heard, self.now) = (0, 0, 1000);
        let follower = self.device.follower();
        assert_eq!(
            (follower.is_stopped(), follower.fault()),
            (record.has(STOPPED), record.fault)
        );
        // Sensors come before what was kept.
        if record.has(MEASURED) {
            assert!(!follower.is_known());
        } else {
            assert_eq!(follower.angles(), record.angles());
        }
        self.drawn = record.has(STOPPED);
    }
}

/// Returns `true` if `PROTOCOL.md` allows a frame to change the state in this way.
fn frame_allows(message: &Message, from: &Look, to: &Look) -> bool {
    use State::{Done, Faulted, Holding, Idle, Ready, Running};
    let stays = from.state == to.state;
    let changes = (from.state, to.state);
    match message {
        Message::Nothing | Message::Hello => from == to,
        Message::Alive | Message::Piece => stays && from.next == to.next,
        Message::Sheet | Message::Command(_, 3) => {
            stays || matches!(changes, (Ready | Holding | Done, Idle)) && from.rate == 0
        }
        Message::Setpoint(_) => {
            let refused = matches!(to.reason, Reason::Refused(_));
            stays || changes == (Idle, Ready) || changes == (Running, Holding) && refused
        }
        Message::Command(_, 0) => stays || changes == (Ready, Running),
        Message::Command(_, 1) => stays || changes == (Running, Holding),
        Message::Command(_, 2) => stays || changes == (Holding, Running),
        Message::Command(_, 4) => stays || changes == (Faulted, Idle),
        Message::Command(_, 6) => {
            stays || matches!(changes, (Holding | Done, Idle)) && from.rate == 0
        }
        Message::Command(_, 5 | 7) => stays,
        Message::Nodes => {
            let refused = matches!(to.reason, Reason::Refused(_));
            stays || changes == (Running, Holding) && refused
        }
        Message::Command(..) => from == to,
    }
}

/// Returns `true` if `PROTOCOL.md` allows a tick to change the state in this way.
fn tick_allows(from: &Look, to: &Look, away: bool) -> bool {
    use State::{Done, Faulted, Holding, Running};
    let waited = matches!(from.reason, Reason::Underrun | Reason::Lag(_));
    match (from.state, to.state) {
        (from, to) if from == to => true,
        (Running, Holding | Done) | (Holding, Done) => true,
        (Running | Holding, Faulted) => away || matches!(from.reason, Reason::Lag(_)),
        (Holding, Running) => waited,
        _ => false,
    }
}
