//! A host, a line with faults and a controller, which run in virtual time.

use foldpath_core::follower::{FollowerPosition, Reason, State};
use foldpath_core::wire::cobs;
use foldpath_core::wire::driver::{Driver, Persistence};
use foldpath_core::wire::message::ToHost;
use foldpath_core::wire::protection::{Protection, Unkeyed};
use foldpath_core::wire::sender::{Failure, Options, Phase, Sender};
use foldpath_core::{GroupId, HalfAngle, Objective, Spoke, StarsView};
use foldpath_firmware_sim::faults::{Faults, Line};
use foldpath_firmware_sim::hinges::Hinges;
use foldpath_test_support::{Measure as _, Random};

use crate::path::{CLOSURE, Device, LIMITS, Path, flat, settings, vertex};

/// Microseconds of a step of the world; four steps are a tick.
const INSTANT: u64 = 250;

/// Returns the random generator of this seed.
pub(crate) fn rng(seed: u64) -> Random {
    Random::stream(seed, 7)
}

/// Returns the vertex between four of the hinges, with the hinges themselves as its unknowns.
fn vertex_of_hinges() -> Vec<Spoke<f64>> {
    let hinges = [3, 2, 1, 8].map(GroupId).into_iter();
    let own = |(group, spoke)| Spoke {
        group,
        negative: false,
        ..spoke
    };
    hinges.zip(vertex().spokes).map(own).collect()
}

/// Returns the angles of both groups at a place of the path, radians.
fn angles_at(path: &Path, place: FollowerPosition<f32>) -> [f32; 2] {
    let (view, knot) = (path.view(), place.knot as usize);
    let from = view.knot(knot).unwrap();
    if place.into > 0.0 {
        let s = place.into / view.knot(knot + 1).unwrap().span;
        [0, 1].map(|group| view.curve(knot, group).unwrap().angle(s))
    } else {
        [from.angles[0], from.angles[1]]
    }
}

/// The library's host at one end of the line.
pub(crate) struct Host<'a> {
    pub(crate) driver: Driver<'a>,
    /// `true` while the host polls and listens.
    pub(crate) awake: bool,
    pub(crate) reasons: Vec<Reason>,
    pub(crate) telemetry: u64,
}

impl<'a> Host<'a> {
    pub(crate) fn new(path: &'a Path, id: u32) -> Self {
        let items = path.items(FollowerPosition::default());
        Self {
            driver: Driver::new(items, Persistence::Always, id, Options::default()),
            awake: true,
            reasons: Vec::new(),
            telemetry: 0,
        }
    }

    pub(crate) fn sender(&self) -> &Sender {
        self.driver.sender()
    }

    pub(crate) fn byte(&mut self, byte: u8, now: u64) {
        match self.driver.byte(byte, now) {
            Some(ToHost::Report(report)) if self.reasons.last() != Some(&report.reason) => {
                self.reasons.push(report.reason);
            }
            Some(ToHost::Telemetry { .. }) => self.telemetry += 1,
            _ => {}
        }
    }

    /// Returns the host's next frame, encoded for the line.
    pub(crate) fn poll(&mut self, now: u64) -> Option<Vec<u8>> {
        let (mut scratch, mut buffer) = ([0; 256], [0; 256]);
        let frame = self.driver.poll(now, &mut scratch, &mut buffer)?;
        let mut bytes = Vec::new();
        cobs::encode(frame, |byte| bytes.push(byte));
        Some(bytes)
    }
}

/// Hosts, both directions of the line and a controller, which run together in virtual time.
pub(crate) struct World<'a, P: Protection = Unkeyed> {
    pub(crate) now: u64,
    pub(crate) hosts: Vec<Host<'a>>,
    pub(crate) up: Line<Random>,
    pub(crate) down: Line<Random>,
    pub(crate) device: Device<P>,
    /// `true` while the line takes the device's bytes.
    pub(crate) drains: bool,
    pub(crate) path: &'a Path,
    pub(crate) max_closure: f64,
    pub(crate) ticks: u64,
    /// Hinges that follow the commanded angles and are measured.
    pub(crate) hinges: Option<Hinges<Random>>,
    /// Largest distance of a hinge from its command, radians.
    pub(crate) farthest: f64,
    /// Largest closure residual of the vertex between four of the hinges.
    pub(crate) torn: f64,
    /// Reasons that held the motion until somebody asked to resume, or ended it.
    pub(crate) held: Vec<Reason>,
    /// Frames of the hosts as they go on the line, while somebody listens.
    pub(crate) tap: Option<Vec<Vec<u8>>>,
    /// Returns `true` for frames of hosts, as they go on the line, that somebody takes away.
    pub(crate) steals: fn(&[u8]) -> bool,
    outgoing: Vec<u8>,
    before: Option<[f32; 2]>,
    rates: [f32; 2],
}

impl<'a> World<'a> {
    pub(crate) fn new(path: &'a Path, faults: Faults, seed: u64) -> Self {
        let host = Host::new(path, 1000 + u32::try_from(seed).unwrap() * 7);
        Self::of(
            path,
            faults,
            seed,
            host,
            Device::protected(settings(seed), Unkeyed),
        )
    }
}

impl<'a, P: Protection> World<'a, P> {
    /// Creates a world of this host and this controller, whose sheet is flat.
    pub(crate) fn of(
        path: &'a Path,
        faults: Faults,
        seed: u64,
        host: Host<'a>,
        device: Device<P>,
    ) -> Self {
        Self {
            now: 0,
            hosts: vec![host],
            up: Line::new(faults, rng(2 * seed)),
            down: Line::new(faults, rng(2 * seed + 1)),
            device: flat(device),
            drains: true,
            path,
            max_closure: 0.0,
            ticks: 0,
            hinges: None,
            farthest: 0.0,
            torn: 0.0,
            held: Vec::new(),
            tap: None,
            steals: |_| false,
            outgoing: Vec::new(),
            before: None,
            rates: [0.0; 2],
        }
    }

    pub(crate) fn state(&self) -> State {
        self.device.follower().state()
    }

    pub(crate) fn reason(&self) -> Reason {
        self.device.follower().reason()
    }

    /// Advances the world by a quarter of a millisecond.
    pub(crate) fn step(&mut self) {
        self.now += INSTANT;
        for host in &mut self.hosts {
            while host.awake && self.up.is_free(self.now) {
                let Some(bytes) = host.poll(self.now) else {
                    break;
                };
                if !(self.steals)(&bytes) {
                    self.up.write(&bytes, self.now);
                }
                if let Some(tap) = &mut self.tap {
                    tap.push(bytes);
                }
            }
        }
        while let Some(byte) = self.down.read(self.now) {
            for host in self.hosts.iter_mut().filter(|host| host.awake) {
                host.byte(byte, self.now);
            }
        }
        while let Some(byte) = self.up.read(self.now) {
            self.device.byte(byte, self.now);
        }
        if self.now.is_multiple_of(4 * INSTANT) {
            self.device.tick(self.now);
            self.look();
            self.turn();
        }
        self.device.poll(self.now);
        while self.drains && self.down.is_free(self.now) {
            let Some(byte) = self.device.take() else {
                break;
            };
            self.outgoing.push(byte);
            if byte == 0 {
                self.down.write(&self.outgoing, self.now);
                self.outgoing.clear();
            }
        }
    }

    /// Lets the hinges follow the commanded angles, and measures them.
    fn turn(&mut self) {
        let Some(hinges) = &mut self.hinges else {
            return;
        };
        hinges.follow(self.device.follower().angles(), 1e-3);
        for (hinge, membership, angle) in hinges.measured() {
            self.device.follower_mut().measure(hinge, membership, angle);
            if let Some(command) = self.device.follower().hinge(membership) {
                self.farthest = self.farthest.max((command - angle).abs().into());
            }
        }
        let vertex = vertex_of_hinges();
        let stars = StarsView::new(&vertex, &[4], self.path.hinges.len()).unwrap();
        let mut scratch = vec![HalfAngle::default(); self.path.hinges.len()];
        let torn = Objective::Max.value(stars, &hinges.angles(), &mut scratch);
        self.torn = self.torn.max(torn.unwrap() / core::f64::consts::SQRT_2);
    }

    /// Checks what has to hold at every tick, whatever goes wrong.
    fn look(&mut self) {
        self.ticks += 1;
        let follower = self.device.follower();
        let reason = follower.reason();
        if !matches!(
            reason,
            Reason::None | Reason::Underrun | Reason::Lag(_) | Reason::Approach
        ) && self.held.last() != Some(&reason)
        {
            self.held.push(reason);
        }
        let angles = follower.angles();
        if angles.is_empty() {
            return;
        }
        let angles = [angles[0], angles[1]];
        // Nothing is executed that was not sent.
        let sent = angles_at(self.path, follower.position());
        assert_eq!(
            angles.map(f32::to_bits),
            sent.map(f32::to_bits),
            "{:?}",
            follower.position()
        );
        let residual = self.path.residual(&angles);
        self.max_closure = self.max_closure.max(residual);
        assert!(residual <= f64::from(CLOSURE), "{residual:e} at {angles:?}");
        let before = self.before.replace(angles).unwrap_or(angles);
        for ((angle, before), rate) in angles.iter().zip(before).zip(follower.rates()) {
            assert!((LIMITS.lower..=LIMITS.upper).contains(angle));
            assert!(rate.abs() <= LIMITS.speed);
            let moved = (f64::from(*angle) - f64::from(before)).abs();
            assert!(moved <= f64::from(LIMITS.speed) * 1e-3 + 1e-6, "{moved}");
        }
        let rates = [follower.rates()[0], follower.rates()[1]];
        let before = core::mem::replace(&mut self.rates, rates);
        // Every stop brakes, harder for a stuck hinge, except for a stop line, a fault or a reset.
        if follower.rate() > 0.0 {
            let brake = if matches!(reason, Reason::Lag(_)) {
                32.0
            } else {
                4.0
            };
            let most = (LIMITS.acceleration + brake * LIMITS.speed) * 1.001e-3;
            let jumps = |(rate, before): (f32, f32)| (rate - before).abs() > most;
            let mut pairs = rates.into_iter().zip(before);
            assert!(!pairs.any(jumps), "{before:?} to {rates:?}");
        }
    }

    pub(crate) fn run(&mut self, micros: u64) {
        let end = self.now + micros;
        while self.now < end {
            self.step();
        }
    }

    /// Asserts that a host was told of every reason that held the motion.
    fn told(&self) {
        let told = |reason| self.hosts.iter().any(|host| host.reasons.contains(reason));
        let untold = self.held.iter().find(|reason| !told(reason));
        assert_eq!(untold, None);
    }

    /// Runs until the last host knows that the path is done, and checks that hosts were told of every reason that held
    /// it.
    pub(crate) fn finish(&mut self, seconds: u64) {
        let end = self.now + seconds * 1_000_000;
        while self.now < end {
            self.step();
            if self.hosts.last().is_some_and(|host| host.driver.is_done()) {
                let last = FollowerPosition {
                    knot: 100,
                    into: 0.0,
                };
                assert_eq!(self.device.follower().position(), last);
                assert_eq!(self.state(), State::Done);
                self.told();
                return;
            }
        }
        let host = self.hosts.last().unwrap();
        panic!(
            "not done: {:?} {:?} {:?} {:?}",
            self.state(),
            self.reason(),
            host.sender(),
            self.device.follower().position()
        );
    }

    pub(crate) fn failure(&self, host: usize) -> Option<Failure> {
        match self.hosts[host].sender().phase() {
            Phase::Failed(failure) => Some(failure),
            _ => None,
        }
    }
}
