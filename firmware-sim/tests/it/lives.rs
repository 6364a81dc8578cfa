//! Whole lives of controllers: power cuts, resets, other images, stops, faults, hosts that come and go, paths with altered
//! angles and rates, drives without supply, hands that turn hinges, buttons that play a path from flash, frames that are forged
//! or played back, with and without a key. Whatever happens, on every tick no hinge moves before its place is known, none while
//! a stop or a fault is latched, none faster than its path and its board allow, the commanded angles close within the residual
//! of the sheet and what bounds and rounding add, no hinge is commanded for long that is measured elsewhere, and the host is
//! told why nothing moves.
//!
//! The fuzzer (`fuzz/`) has a model of single frames; here the whole main loop runs, with its records and its hinges.

use foldpath_controller::{Condition, PlayRefusal, Player, stored};
use foldpath_core::acceptance::most_commanded;
use foldpath_core::follower::{Denial, FollowerPosition, Reason, State};
use foldpath_core::wire::cobs;
use foldpath_core::wire::driver::{Driver, Persistence};
use foldpath_core::wire::frame;
use foldpath_core::wire::key::Key;
use foldpath_core::wire::message::{Command, ToDevice};
use foldpath_core::wire::protection::{Keyed, Protection, Unkeyed};
use foldpath_core::wire::sender::{Options, Phase};
use foldpath_test_support::Random;
use rand_core::Rng;

use crate::machine::{EXACT, Machine, Sensor};
use crate::path::{CLOSURE, LIMITS, Path, below};

/// Lives that the test runs; `examples/fuzz.rs` runs as many as are asked for.
#[cfg_attr(
    not(test),
    allow(dead_code, reason = "the fuzzer is asked for a number")
)]
const LIVES: u64 = 200;
/// Largest distance of a commanded hinge from where it is measured (radians) at rest, and in a motion: PROTOCOL.md, hinges that
/// are elsewhere. It may be exceeded for 20 ms, and one tick until it is measured.
const MOST_OFF: [f32; 2] = [0.15, 0.15 + LIMITS.speed / 8.0 + 0.05];
const ELSEWHERE_MS: u64 = 21;
const KEY: Key = Key::new([0x3c; Key::SIZE]);

/// Sensors: none, exact ones, one that has failed, and a hinge that is stuck.
const SENSORS: [Option<Sensor>; 4] = [
    None,
    Some(EXACT),
    Some(|hinge, _, stands| if hinge == 7 { f32::NAN } else { stands }),
    Some(|hinge, _, stands| {
        if hinge == 5 {
            stands.clamp(-0.4, 0.4)
        } else {
            stands
        }
    }),
];

/// Counts over many lives.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Tally {
    ticks: u64,
    moved: u64,
    done: u64,
    faulted: u64,
    stopped: u64,
    cuts: u64,
    resets: u64,
    forged: u64,
    told: u64,
    /// Ticks in which a hinge moved on a path that a button plays.
    played: u64,
    /// Stops and faults that a button undid.
    released: u64,
    /// Times when something moved hinges, and times when their place was forgotten because of it.
    moved_away: u64,
    lost: u64,
    /// Hosts with altered paths, and setpoints of these that were refused.
    altered: u64,
    refused: u64,
}

impl Tally {
    pub(crate) fn add(&mut self, one: Self) {
        self.ticks += one.ticks;
        self.moved += one.moved;
        self.done += one.done;
        self.faulted += one.faulted;
        self.stopped += one.stopped;
        self.cuts += one.cuts;
        self.resets += one.resets;
        self.forged += one.forged;
        self.told += one.told;
        self.played += one.played;
        self.released += one.released;
        self.moved_away += one.moved_away;
        self.lost += one.lost;
        self.altered += one.altered;
        self.refused += one.refused;
    }
}

struct Life<'a, P: Protection> {
    rng: Random,
    path: &'a Path,
    /// Paths with altered angles and rates.
    altered: &'a [Path],
    machine: Machine<2, P>,
    host: Option<Driver<'a>>,
    /// The player of a board with buttons, and the one with which it starts.
    player: Option<Player<'a>>,
    fresh: Option<Player<'a>>,
    key: Option<Key>,
    /// `false` if a reset, a button, or a greeting that was played back, may have ended the host's session.
    hears: bool,
    /// `true` once the commanded angles have closed since the path was last started.
    closed: bool,
    before: (Option<State>, [Option<f32>; 2]),
    /// `true` while all hinges have exact sensors.
    exact: bool,
    /// Milliseconds for which a commanded hinge was too far from where it stands, and for which no command has changed.
    off: u64,
    rests: u64,
    /// A hinge that a hand holds, and the angle.
    hand: Option<(usize, f32)>,
    tally: Tally,
}

impl<'a, P: Protection> Life<'a, P> {
    fn new(
        [path, altered @ ..]: &'a [Path; PATHS],
        seed: u64,
        key: Option<Key>,
        player: Option<Player<'a>>,
    ) -> Self {
        let mut machine = Machine::<2, P>::with_line(seed << 20, false);
        if let Some(key) = key {
            machine.bench(|bench| bench.flash = stored::words(&key));
        }
        machine.reset();
        // Two boards of three have exact sensors at first.
        let exact = !seed.is_multiple_of(3);
        if exact {
            machine.bench(|bench| bench.sensor = Some(EXACT));
        }
        Self {
            rng: Random::stream(seed, 11),
            path,
            altered,
            machine,
            host: None,
            player,
            fresh: player,
            key,
            hears: false,
            closed: false,
            before: (None, [None; 2]),
            exact,
            off: 0,
            rests: 0,
            hand: None,
            tally: Tally::default(),
        }
    }

    fn below(&mut self, count: u64) -> u64 {
        below(&mut self.rng, count)
    }

    /// Runs for some milliseconds, and judges each.
    fn run(&mut self, millis: u64) {
        for _ in 0..millis {
            if let Some((hinge, angle)) = self.hand {
                self.machine.bench(|bench| {
                    (bench.stands[hinge], bench.moved) = (angle, true);
                });
            }
            self.machine.run(self.host.as_mut(), 1);
            if let Some(player) = &mut self.player {
                self.machine.controller.play(player);
            }
            let condition = self.machine.condition();
            // Hinges 1 and 2 are of both groups, with the signs of their groups.
            let angles = self.machine.bench(|bench| {
                let hinge = |hinge: usize| bench.commands.get(hinge).copied().flatten();
                [hinge(2), hinge(1)]
            });
            assert!(condition.known || angles == [None; 2], "{condition:?}");
            let (state, before) =
                core::mem::replace(&mut self.before, (Some(condition.state), angles));
            let starts = state != Some(State::Running) && state != Some(State::Holding);
            self.closed &= !(starts && condition.state == State::Running);
            for (angle, before) in angles.iter().zip(before) {
                let (Some(angle), Some(before)) = (*angle, before) else {
                    continue;
                };
                let moved = (angle - before).abs();
                assert!(
                    moved <= LIMITS.speed * 1.001e-3 + 1e-6,
                    "{moved} {condition:?}"
                );
                let latched = condition.stopped || condition.fault.is_some();
                assert!(!latched || moved.to_bits() == 0, "{moved} {condition:?}");
                self.tally.moved += u64::from(moved > 0.0);
                let plays = self.player.is_some_and(|player| player.is_playing());
                self.tally.played += u64::from(moved > 0.0 && plays);
            }
            if let [Some(major), Some(minor)] = angles {
                let residual = self.path.residual(&[major, minor]);
                let closes = residual <= most_commanded(CLOSURE, 4).into();
                self.closed |= closes && condition.reason != Reason::Approach;
                assert!(!self.closed || closes, "{residual:e} {condition:?}");
            }
            self.rests = if angles == before { self.rests + 1 } else { 0 };
            self.is_together(&condition);
            self.tally.ticks += 1;
        }
    }

    /// Checks that hinges with sensors are where they are commanded to be, or were so until a moment ago.
    fn is_together(&mut self, condition: &Condition) {
        let off = self.machine.bench(|bench| {
            let hinges = bench.commands.iter().zip(&bench.stands);
            let off =
                hinges.filter_map(|(command, stands)| Some((command.as_ref()? - stands).abs()));
            off.fold(0.0, f32::max)
        });
        let moves = matches!(condition.state, State::Running | State::Holding);
        // Brakes, and a hold that lasts only as long as its cause, count as a motion.
        let rests = !moves || self.rests > 500 && !condition.reason.passes();
        let most = MOST_OFF[usize::from(!rests)];
        self.off = if self.exact && off > most + 1e-3 {
            self.off + 1
        } else {
            0
        };
        assert!(self.off <= ELSEWHERE_MS, "{off} {condition:?}");
    }

    /// Lets an operator lay the sheet flat.
    fn lays_flat(&mut self) {
        self.machine.bench(|bench| {
            bench.stands.fill(0.0);
            bench.moved = true;
        });
    }

    /// Takes the supply of the drives away for a while, in which a load moves the sheet, or lets a hand turn a hinge.
    fn moves_hinges(&mut self) {
        let hinges = self.machine.bench(|bench| bench.stands.len()) as u64;
        if hinges == 0 {
            return;
        }
        let known = self.machine.condition().known;
        let millis = 1 + self.below(400);
        if self.below(2) == 0 {
            let part = 0.1 * self.below(15) as f32;
            self.machine.bench(|bench| {
                (bench.follows, bench.moved) = (false, true);
                bench.stands.iter_mut().for_each(|stands| *stands *= part);
            });
            self.run(millis);
            self.machine.bench(|bench| bench.follows = true);
        } else {
            let hinge = usize::try_from(self.below(hinges)).unwrap();
            let turn = 0.1 * (self.below(13) as f32 - 6.0);
            let stands = self.machine.bench(|bench| bench.stands[hinge]);
            self.hand = Some((hinge, stands + turn));
            self.run(millis);
            self.hand = None;
        }
        self.tally.moved_away += 1;
        self.tally.lost += u64::from(known && !self.machine.condition().known);
    }

    /// Resets the board with another image or hinge map, to which the record of the one before tells nothing.
    fn changes_image(&mut self) {
        self.machine.image = self.rng.next_u32();
        self.machine.bench(|bench| bench.limp = false);
        self.machine.reset();
        self.starts_again();
        self.run(2);
        let condition = self.machine.condition();
        assert!(
            !condition.known && condition.commanded == 0,
            "{condition:?}"
        );
        self.tally.resets += 1;
    }

    /// Looks whether the host, if it has a session, is told what holds the motion.
    fn is_told(&mut self) {
        self.run(200);
        let condition = self.machine.condition();
        self.run(40);
        let report = self
            .host
            .as_ref()
            .and_then(|host| host.sender().report().copied());
        self.tally.refused += u64::from(report.is_some_and(|report| report.refused.is_some()));
        let open = |host: &Driver<'_>| host.sender().phase() == Phase::Open;
        let open = self.hears && self.host.as_ref().is_some_and(open);
        // The condition is that of the last tick, and the report may be of a moment behind it.
        self.run(2);
        let after = self.machine.condition();
        let Some(report) = report.filter(|_| open && condition == after) else {
            return;
        };
        let told = (report.state, report.reason, report.stopped, report.known);
        let is = (after.state, after.reason, after.stopped, after.known);
        assert_eq!(told, is);
        if after.fault.is_some() || after.stopped || after.state == State::Holding {
            assert_ne!(report.reason, Reason::None);
            self.tally.told += 1;
        }
    }

    fn greets(&mut self) {
        let ways = [Persistence::None, Persistence::Resume, Persistence::Always];
        let persistence = ways[usize::try_from(self.below(3)).unwrap()];
        let id = self.rng.next_u32();
        let is_altered = self.below(4) == 0;
        let path = if is_altered {
            &self.altered[usize::try_from(self.below(self.altered.len() as u64)).unwrap()]
        } else {
            self.path
        };
        self.tally.altered += u64::from(is_altered);
        let items = path.items(FollowerPosition::default());
        let mut host = Driver::new(items, persistence, id, Options::default());
        if let Some(key) = self.key {
            host = host.with_key(key, self.rng.next_u32());
        }
        let known = self.machine.condition().known;
        // An operator lays a limp sheet flat, and says so.
        if !known && self.below(4) != 0 {
            self.lays_flat();
            host = host.confirming();
        }
        (self.host, self.hears) = (Some(host), true);
    }

    /// Sends frames that were recorded before, changed or not, noise, and commands of this session or another.
    fn forges(&mut self) {
        self.hears &= self.key.is_some();
        for _ in 0..1 + self.below(20) {
            let recorded = self.machine.recorded.len() as u64;
            let pick = usize::try_from(self.below(recorded.max(1))).unwrap();
            let mut bytes = match self.machine.recorded.get(pick) {
                Some((_, bytes)) => bytes.clone(),
                None => vec![1, 2, 3, 0],
            };
            match self.below(4) {
                0 => {}
                1 => {
                    let at = usize::try_from(self.below(bytes.len() as u64)).unwrap();
                    bytes[at] ^= 1 << self.below(8);
                }
                2 => self.rng.fill_bytes(&mut bytes),
                _ => {
                    let session = self.host.as_ref().map_or(0, |host| host.sender().session());
                    let commands = [
                        Command::Start,
                        Command::Resume,
                        Command::Clear,
                        Command::Unload,
                    ];
                    let command = commands[usize::try_from(self.below(4)).unwrap()];
                    let number = self.rng.next_u32().to_le_bytes()[0];
                    let message = ToDevice::Command { number, command };
                    let mut buffer = [0; 64];
                    let sealed = frame::seal(session, &message, &mut buffer).unwrap();
                    bytes.clear();
                    cobs::encode(sealed, |byte| bytes.push(byte));
                }
            }
            self.machine.bench(|bench| bench.received.extend(&bytes));
            self.tally.forged += 1;
            self.run(1);
        }
    }

    /// Forgets what a reset of the board ends.
    fn starts_again(&mut self) {
        self.hears = false;
        self.before = (None, [None; 2]);
        (self.off, self.rests) = (0, 0);
        self.player = self.fresh;
    }

    /// Presses a button, and runs for a while. Nothing undoes a stop line or a fault but the release.
    fn presses(&mut self, mut player: Player<'a>) {
        let before = self.machine.condition();
        let latched = before.stopped || before.fault.is_some();
        let releases = self.below(if latched { 2 } else { 4 }) == 0;
        match self.below(3) {
            _ if releases => player.release(),
            0 => player.press(),
            // An operator lays a limp sheet flat, and says so.
            _ => {
                if !before.known {
                    self.lays_flat();
                }
                player.press_flat();
            }
        }
        self.player = Some(player);
        self.run(5);
        let refused = self.player.and_then(|player| player.refused());
        // A button that is heard ends the session of a silent host.
        self.hears &= refused == Some(PlayRefusal::Host);
        if releases {
            self.tally.released += u64::from(latched && refused.is_none());
        } else if latched {
            let held = PlayRefusal::Denied(Denial::Held);
            assert!(
                matches!(refused, Some(PlayRefusal::Host | PlayRefusal::Fault(_)))
                    || refused == Some(held),
                "{refused:?} {before:?}"
            );
        }
        let millis = self.below(300);
        self.run(millis);
        self.is_told();
    }

    fn happens(&mut self) {
        if let Some(player) = self.player
            && self.below(3) == 0
        {
            // A button counts only after a second of silence.
            if self.below(2) == 0 {
                self.host = None;
                self.run(1100);
            }
            return self.presses(player);
        }
        match self.below(16) {
            12..15 => self.moves_hinges(),
            15 => self.changes_image(),
            0..3 => self.greets(),
            3 => self.host = None,
            4 => {
                let nonce = self.rng.next_u64();
                self.machine.cut_power(nonce);
                self.starts_again();
                self.tally.cuts += 1;
            }
            5 | 6 => {
                let limp = self.below(3) == 0;
                self.machine.bench(|bench| bench.limp = limp);
                self.machine.reset();
                self.starts_again();
                self.tally.resets += 1;
            }
            7 => {
                self.machine.bench(|bench| bench.stop = true);
                let millis = 1 + self.below(100);
                self.run(millis);
                assert!(self.machine.condition().stopped);
                self.machine.bench(|bench| bench.stop = false);
                self.tally.stopped += 1;
            }
            8 => {
                let sensor = usize::try_from(self.below(4)).unwrap();
                (self.exact, self.off) = (sensor == 1, 0);
                self.machine.bench(|bench| bench.sensor = SENSORS[sensor]);
            }
            9 => {
                if let Some(host) = &mut self.host {
                    host.stop();
                }
            }
            _ => return self.forges(),
        }
        let whole = self.below(6) == 0;
        let millis = if whole { 2600 } else { 50 + self.below(500) };
        self.run(millis);
        self.is_told();
    }

    fn live(mut self) -> Tally {
        self.run(2);
        self.greets();
        for _ in 0..6 + self.below(12) {
            self.happens();
            let state = self.machine.condition().state;
            self.tally.done += u64::from(state == State::Done);
            self.tally.faulted += u64::from(state == State::Faulted);
        }
        self.tally
    }
}

/// The path of Miura's fold, and altered ones: each has a few angles and rates that are off by a little, or by much.
const PATHS: usize = 9;

fn paths() -> [Path; PATHS] {
    let mut rng = Random::stream(0, 12);
    core::array::from_fn(|number| {
        let mut path = Path::miura();
        for _ in 0..number {
            let off = [1e-5, 1e-3, 0.05, 0.5][number % 4] * rng.uniform(-1.0, 1.0);
            path.alter(&mut rng, off);
        }
        path
    })
}

/// Lives the lives of these seeds.
pub(crate) fn live(seeds: core::ops::Range<u64>) -> Tally {
    let paths = paths();
    let (there, back) = (paths[0].file(), paths[0].reversed().file());
    let player = Player::new(&there, Some(&back)).unwrap();
    let mut sum = Tally::default();
    for seed in seeds {
        // A failure names its seed.
        let result = std::panic::catch_unwind(|| {
            let player = (seed % 4 >= 2).then_some(player);
            if seed % 2 == 0 {
                Life::<Unkeyed>::new(&paths, seed, None, player).live()
            } else {
                Life::<Keyed>::new(&paths, seed, Some(KEY), player).live()
            }
        });
        sum.add(result.unwrap_or_else(|_| panic!("the life of seed {seed}")));
    }
    sum
}

#[test]
fn in_no_life_does_a_hinge_move_that_must_not() {
    let sum = live(0..LIVES);
    println!("{sum:?}");
    assert!(
        sum.moved > 100 * LIVES && sum.done > LIVES / 10 && sum.faulted > LIVES / 10,
        "{sum:?}"
    );
    assert!(
        sum.stopped > LIVES / 2 && sum.cuts > LIVES / 2 && sum.resets > LIVES,
        "{sum:?}"
    );
    assert!(sum.forged > 10 * LIVES && sum.told > LIVES / 2, "{sum:?}");
    assert!(
        sum.played > 10 * LIVES && sum.released > LIVES / 40,
        "{sum:?}"
    );
    assert!(sum.moved_away > LIVES && sum.lost > LIVES / 10, "{sum:?}");
    assert!(
        sum.altered > LIVES / 2 && sum.refused > LIVES / 10,
        "{sum:?}"
    );
}
