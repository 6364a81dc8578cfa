//! A host, a line with faults and a controller in virtual time, with a Miura fold whose motion is known in
//! closed form.
#![allow(dead_code, reason = "each test file uses its part")]

use core::f64::consts::PI;

use foldpath_core::follower::{Place, Reason, State};
use foldpath_core::trajectory::TrajectoryView;
use foldpath_core::wire::cobs;
use foldpath_core::wire::driver::{Driver, Persistence};
use foldpath_core::wire::message::ToHost;
use foldpath_core::wire::path::PathItems;
use foldpath_core::wire::sender::{Failure, Options, Phase, Sender};
use foldpath_core::{
    GroupId, GroupLimits, Interpolation, Membership, Scalar, Spoke, StarView, StarsView,
    local_foldability_matrix,
};
use foldpath_firmware_sim::controller::{Controller, Settings};
use foldpath_firmware_sim::faults::{Faults, Line};
use foldpath_firmware_sim::hinges::Hinges;
use rand_core::Rng;
use rand_pcg::Pcg64;

/// Seconds between knots, and knots of the path.
pub(crate) const STEP: f64 = 0.02;
pub(crate) const KNOTS: usize = 101;
/// Largest fold angle of the path, and the limits of both groups.
pub(crate) const TOP: f64 = 2.6;
pub(crate) const LIMITS: GroupLimits = GroupLimits {
    lower: -0.1,
    upper: 2.7,
    speed: 2.5,
    acceleration: 8.0,
};
/// Largest residual that a commanded configuration may have: that of the cubics between knots, and the floor of
/// f32.
pub(crate) const CLOSURE: f32 = 2e-6;
/// Microseconds of a step of the world, of which four are a tick.
pub(crate) const INSTANT: u64 = 250;

pub(crate) type Device = Controller<4, 64, 32, 16>;

pub(crate) fn rng(seed: u64) -> Pcg64 {
    Pcg64::new(u128::from(seed), 7)
}

pub(crate) fn below(rng: &mut impl Rng, count: u64) -> u64 {
    rng.next_u64() % count
}

/// A path in numbers of its own.
pub(crate) struct Path {
    times: Vec<f32>,
    angles: Vec<f32>,
    rates: Vec<f32>,
    spokes: Vec<Spoke<f32>>,
    exact: Vec<Spoke<f64>>,
    hinges: Vec<Membership>,
}

impl Path {
    /// Miura's fold with 60 degree sectors, there and smooth at both ends.
    pub(crate) fn miura() -> Self {
        Self::miura_to(TOP)
    }

    /// The same up to another angle.
    pub(crate) fn miura_to(top: f64) -> Self {
        let duration = STEP * (KNOTS - 1) as f64;
        let (mut times, mut angles, mut rates) = (Vec::new(), Vec::new(), Vec::new());
        for knot in 0..KNOTS {
            let time = STEP * knot as f64;
            let (sin, cos) = (PI * time / duration).sin_cos();
            let t = (top * (1.0 - cos) / 4.0).tan();
            let rate = top * sin / 2.0 * PI / duration;
            let minor = rate * 0.5 * (1.0 + t * t) / (1.0 + t * t / 4.0);
            times.push(f32::lit(time));
            angles.extend([2.0 * t.atan(), 2.0 * (t / 2.0).atan()].map(f32::lit));
            rates.extend([rate, minor].map(f32::lit));
        }
        let hinge = |hinge: u32| Membership {
            group: GroupId(hinge % 2),
            negative: hinge.is_multiple_of(3),
        };
        Self {
            times,
            angles,
            rates,
            spokes: spokes(),
            exact: spokes(),
            hinges: (0..50).map(hinge).collect(),
        }
    }

    pub(crate) fn view(&self) -> TrajectoryView<'_, f32> {
        let kind = Interpolation::Hermite;
        TrajectoryView::new(kind, 2, &self.times, &self.angles, &self.rates, &[]).unwrap()
    }

    pub(crate) fn stars(&self) -> StarsView<'_, f32> {
        StarsView::new(&self.spokes, &[4], 2).unwrap()
    }

    pub(crate) fn items(&self, place: Place<f32>) -> PathItems<'_> {
        let limits = &[LIMITS; 2];
        PathItems::new(
            self.view(),
            limits,
            &self.hinges,
            self.stars(),
            CLOSURE,
            place,
        )
        .unwrap()
    }

    pub(crate) fn hinges(&self) -> &[Membership] {
        &self.hinges
    }

    /// The vertex between four of the hinges, which are its unknowns.
    pub(crate) fn vertex() -> Vec<Spoke<f64>> {
        let hinges = [3, 2, 1, 8].map(GroupId).into_iter().zip(spokes());
        let own = |(group, spoke)| Spoke {
            group,
            negative: false,
            ..spoke
        };
        hinges.map(own).collect()
    }

    /// The angles at a place.
    pub(crate) fn at(&self, place: Place<f32>) -> [f32; 2] {
        let knot = place.knot as usize;
        if place.into > 0.0 {
            let s = place.into / (self.times[knot + 1] - self.times[knot]);
            [0, 1].map(|group| self.view().curve(knot, group).unwrap().angle(s))
        } else {
            [self.angles[2 * knot], self.angles[2 * knot + 1]]
        }
    }

    /// The closure residual of the real vertex at these angles, by the report's matrices in f64.
    pub(crate) fn residual(&self, angles: &[f32]) -> f64 {
        let angles = [angles[0], angles[1]].map(f64::from);
        let star = StarView {
            spokes: &self.exact,
        };
        let matrix = local_foldability_matrix(star, [0.0; 2], &angles);
        let entry = |i: usize, j: usize| matrix[(i, j)] - if i == j { 1.0 } else { 0.0 };
        let places = (0..3).flat_map(|i| (0..3).map(move |j| (i, j)));
        let square: f64 = places.map(|(i, j)| entry(i, j).powi(2)).sum();
        (square / 2.0).sqrt()
    }
}

/// Miura's vertex with 60 degree sectors.
fn spokes<T: Scalar>() -> Vec<Spoke<T>> {
    let spoke = |(degrees, group, negative): (f64, u32, bool)| {
        let (sin, cos) = degrees.to_radians().sin_cos();
        Spoke {
            group: GroupId(group),
            negative,
            direction: [T::lit(cos), T::lit(sin)],
        }
    };
    let creases = [
        (0.0, 1, true),
        (60.0, 0, false),
        (180.0, 1, false),
        (300.0, 0, false),
    ];
    creases.map(spoke).to_vec()
}

/// The library's host at one end of the line.
pub(crate) struct Host<'a> {
    pub(crate) driver: Driver<'a>,
    /// Whether it polls and listens.
    pub(crate) awake: bool,
    pub(crate) reasons: Vec<Reason>,
    pub(crate) telemetry: u64,
}

impl<'a> Host<'a> {
    pub(crate) fn new(path: &'a Path, id: u32) -> Self {
        let items = path.items(Place::default());
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

    /// The next frame for the line.
    pub(crate) fn poll(&mut self, now: u64) -> Option<Vec<u8>> {
        let (mut scratch, mut buffer) = ([0; 256], [0; 256]);
        let frame = self.driver.poll(now, &mut scratch, &mut buffer)?;
        let mut bytes = Vec::new();
        cobs::encode(frame, |byte| bytes.push(byte));
        Some(bytes)
    }
}

/// All of it.
pub(crate) struct World<'a> {
    pub(crate) now: u64,
    pub(crate) hosts: Vec<Host<'a>>,
    pub(crate) up: Line<Pcg64>,
    pub(crate) down: Line<Pcg64>,
    pub(crate) device: Device,
    /// Whether the device's bytes are taken from it.
    pub(crate) drains: bool,
    pub(crate) path: &'a Path,
    pub(crate) max_closure: f64,
    pub(crate) ticks: u64,
    /// Hinges that follow what is commanded, and are measured; the farthest that one was off, and the most that the
    /// vertex between four of them was torn.
    pub(crate) hinges: Option<Hinges<Pcg64>>,
    pub(crate) farthest: f64,
    pub(crate) torn: f64,
    /// All that held the motion until it was asked to go on, or ended it.
    pub(crate) held: Vec<Reason>,
    outgoing: Vec<u8>,
    before: Option<[f32; 2]>,
    rates: [f32; 2],
}

impl<'a> World<'a> {
    pub(crate) fn new(path: &'a Path, faults: Faults, seed: u64) -> Self {
        Self {
            now: 0,
            hosts: vec![Host::new(path, 1000 + u32::try_from(seed).unwrap() * 7)],
            up: Line::new(faults, rng(2 * seed)),
            down: Line::new(faults, rng(2 * seed + 1)),
            device: Device::new(Settings::default()),
            drains: true,
            path,
            max_closure: 0.0,
            ticks: 0,
            hinges: None,
            farthest: 0.0,
            torn: 0.0,
            held: Vec::new(),
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

    /// A quarter of a millisecond.
    pub(crate) fn step(&mut self) {
        self.now += INSTANT;
        for host in &mut self.hosts {
            while host.awake && self.up.is_free(self.now) {
                let Some(bytes) = host.poll(self.now) else {
                    break;
                };
                self.up.write(&bytes, self.now);
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

    /// The hinges follow, and are measured.
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
        let vertex = Path::vertex();
        let stars = StarsView::new(&vertex, &[4], self.path.hinges().len()).unwrap();
        self.torn = self.torn.max(hinges.torn(stars));
    }

    /// What has to be true at every tick, whatever went wrong.
    fn look(&mut self) {
        self.ticks += 1;
        let follower = self.device.follower();
        let reason = follower.reason();
        if !matches!(reason, Reason::None | Reason::Underrun | Reason::Lag(_))
            && self.held.last() != Some(&reason)
        {
            self.held.push(reason);
        }
        let angles = follower.angles();
        if angles.is_empty() {
            return;
        }
        let angles = [angles[0], angles[1]];
        // Nothing is executed that was not sent.
        let sent = self.path.at(follower.place());
        assert_eq!(
            angles.map(f32::to_bits),
            sent.map(f32::to_bits),
            "{:?}",
            follower.place()
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
        // Only the stop line, a fault and a reset do not brake.
        if follower.rate() > 0.0 {
            let most = (LIMITS.acceleration + 4.0 * LIMITS.speed) * 1.001e-3;
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

    /// Whether a host was told of each thing that held the motion.
    fn told(&self) {
        let told = |reason| self.hosts.iter().any(|host| host.reasons.contains(reason));
        let untold = self.held.iter().find(|reason| !told(reason));
        assert_eq!(untold, None);
    }

    /// Runs until the last host knows that the path is done, and looks whether hosts were told what held it.
    pub(crate) fn finish(&mut self, seconds: u64) {
        let end = self.now + seconds * 1_000_000;
        while self.now < end {
            self.step();
            if self.hosts.last().is_some_and(|host| host.driver.is_done()) {
                let last = Place {
                    knot: 100,
                    into: 0.0,
                };
                assert_eq!(self.device.follower().place(), last);
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
            self.device.follower().place()
        );
    }

    pub(crate) fn failure(&self, host: usize) -> Option<Failure> {
        match self.hosts[host].sender().phase() {
            Phase::Failed(failure) => Some(failure),
            _ => None,
        }
    }
}
