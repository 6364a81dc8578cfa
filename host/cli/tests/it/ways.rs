//! Tests of where a session begins, which way it runs, and what it does about holds that are not its own.

use core::cell::Cell;
use std::collections::VecDeque;
use std::io;
use std::path::Path;

use crate::common::folder;
use crate::session::session;
use foldpath::stream::{
    Ending, Link, Options, Outcome, Sim, Stands, StreamPath, Summary, Telemetry, Watcher, Wish, run,
};
use foldpath_core::follower::{FollowerPosition, Reason, State};
use foldpath_core::trajectory::TrajectoryView;
use foldpath_core::trajectory_file::{LagCost, write};
use foldpath_core::wire::cobs::{self, Deframer};
use foldpath_core::wire::frame;
use foldpath_core::wire::message::ToHost;
use foldpath_core::{GroupId, GroupLimits, Interpolation, Membership, StarsView};
use foldpath_test_support::Folder;

/// Makes a folder with `path.traj` of a small Miura fold that takes about two seconds.
pub(crate) fn small() -> Folder {
    let folder = folder();
    folder.done("generate miura --rows 3 --cols 3 -o miura.fold");
    folder.done("plan miura.fold --max-speed 90 -o path.fold");
    folder.done("export path.fold --to traj -o path.traj");
    folder
}

pub(crate) fn read(folder: &Folder, name: &str) -> StreamPath {
    let bytes = std::fs::read(folder.path(name)).unwrap();
    StreamPath::read(&bytes, Path::new(name)).unwrap()
}

fn options(id: u32, resume: bool) -> Options {
    Options::default().with(|it| {
        it.id = id;
        it.resume = resume;
    })
}

fn bits(angles: &[f32]) -> Vec<u32> {
    angles.iter().map(|angle| angle.to_bits()).collect()
}

/// Returns the angles of all groups at a place on a path.
fn at(path: &StreamPath, place: FollowerPosition<f32>) -> Vec<f32> {
    let view = path.view().unwrap();
    let knot = place.knot as usize;
    if place.into <= 0.0 || knot + 1 == view.len() {
        return view.knot(knot).unwrap().angles.to_vec();
    }
    let span = view.knot(knot + 1).unwrap().span;
    let curve = |group| view.curve(knot, group).unwrap().angle(place.into / span);
    (0..path.groups()).map(curve).collect()
}

/// Every interpolation: knots have the same bits both ways. Between them the parameter counts from the other end, which
/// rounds it.
#[test]
fn the_way_back_has_the_same_angles_at_mirrored_times() {
    let folder = small();
    for kind in ["linear", "hermite", "half-angle", "homogeneous"] {
        let bound = if kind == "linear" { "--bound 0.01" } else { "" };
        folder.done(&format!(
            "plan miura.fold --interpolation {kind} {bound} -o {kind}.fold"
        ));
        folder.done(&format!("export {kind}.fold --to traj -o {kind}.traj"));
        let path = read(&folder, &format!("{kind}.traj"));
        let back = path.reverse();
        let [there, here] = [&path, &back].map(|path| path.view().unwrap());
        let last = there.len() - 1;
        for knot in 0..=last {
            let (a, b) = (there.knot(knot).unwrap(), here.knot(last - knot).unwrap());
            assert_eq!(bits(a.angles), bits(b.angles), "{kind}");
            assert!(
                a.rates
                    .iter()
                    .zip(b.rates)
                    .all(|(a, b)| a.to_bits() == (-b).to_bits())
            );
            let weights = a.weights.iter().zip(b.weights);
            assert!(
                weights
                    .into_iter()
                    .all(|(a, b)| bits(a) == bits(&[b[0], -b[1]]))
            );
        }
        let mut worst = 0.0_f32;
        for segment in 0..last {
            for group in 0..path.groups() {
                let a = there.curve(segment, group).unwrap();
                let b = here.curve(last - 1 - segment, group).unwrap();
                for step in 0..=32_u8 {
                    let s = f32::from(step) / 32.0;
                    worst = worst.max((a.angle(s) - b.angle(1.0 - s)).abs());
                }
            }
        }
        println!("{kind}: {last} segments, {worst:e} rad");
        assert!(worst < 2e-6, "{kind}: {worst:e}");
        let [one, other] = [&path, &back].map(|path| path.items().unwrap().identity());
        assert_ne!(one, other, "{kind}");
        let again = back.reverse();
        assert_eq!(again.items().unwrap().identity(), one, "{kind}");

        // The controller accepts it, and ends where the other way began.
        let mut sim = Sim::new();
        for (id, path, end) in [(1, &path, last), (2, &back, 0)] {
            let (summary, heard) = session(&mut sim, path, options(id, false), &|_| Wish::Run);
            assert_eq!(summary.outcome, Outcome::Done, "{kind}: {summary:?}");
            assert!(summary.max_closure <= f64::from(path.closure()), "{kind}");
            let stands = &heard.last().unwrap().angles;
            assert_eq!(
                bits(stands),
                bits(there.knot(end).unwrap().angles),
                "{kind}"
            );
            for told in heard.iter().filter(|told| told.state == State::Running) {
                if told.rate > 0.0 {
                    assert_eq!(bits(&told.angles), bits(&at(path, told.place)), "{kind}");
                }
            }
        }
    }
}

fn stops(heard: &[Telemetry]) -> Wish {
    if heard.len() < 40 {
        Wish::Run
    } else {
        Wish::Stop
    }
}

fn running(heard: &[Telemetry]) -> &Telemetry {
    heard
        .iter()
        .find(|told| told.state == State::Running)
        .unwrap()
}

/// Turns round twice in the middle, and each time goes on from where the sheet stands.
#[test]
fn an_interrupted_run_turns_back_from_where_it_stands() {
    let path = read(&small(), "path.traj");
    let back = path.reverse();
    let mut sim = Sim::new();
    let (summary, heard) = session(&mut sim, &path, options(1, false), &stops);
    assert_eq!(summary.outcome, Outcome::Stopped, "{summary:?}");
    let stood = heard.last().unwrap().clone();
    assert!(stood.angles[0] > 0.1);
    for (id, resumed, other) in [(2, &back, &path), (4, &path, &back)] {
        // Without the operator's word nothing moves.
        let (summary, heard) = session(&mut sim, resumed, options(id, false), &|_| Wish::Run);
        assert_eq!(summary.outcome, Outcome::Held, "{summary:?}");
        let before = heard.last().unwrap();
        let mirror = resumed.items().unwrap().mirrored(before.place).unwrap();
        let (summary, heard) = session(&mut sim, resumed, options(id + 1, true), &stops);
        assert_eq!(summary.outcome, Outcome::Stopped, "{summary:?}");
        let begun = running(&heard);
        assert_eq!(begun.place.knot, mirror.knot);
        assert!(
            (0.0..0.03).contains(&(begun.place.into - mirror.into)),
            "{begun:?} {mirror:?}"
        );
        let far = before
            .angles
            .iter()
            .zip(&begun.angles)
            .map(|(a, b)| (a - b).abs());
        assert!(far.fold(0.0, f32::max) < 0.02);
        assert!(other.items().unwrap().mirrored(mirror).is_some());
    }
    let (summary, heard) = session(&mut sim, &back, options(6, true), &|_| Wish::Run);
    assert_eq!(summary.outcome, Outcome::Done, "{summary:?}");
    let flat = path.view().unwrap().knot(0).unwrap().angles.to_vec();
    assert_eq!(bits(&heard.last().unwrap().angles), bits(&flat));
    // An interrupted way back goes on as well.
    let (summary, _) = session(&mut sim, &path, options(7, false), &|_| Wish::Run);
    assert_eq!(summary.outcome, Outcome::Done, "{summary:?}");
    let (summary, _) = session(&mut sim, &back, options(8, false), &stops);
    assert_eq!(summary.outcome, Outcome::Stopped, "{summary:?}");
    let (summary, _) = session(&mut sim, &back, options(9, true), &|_| Wish::Run);
    assert_eq!(summary.outcome, Outcome::Done, "{summary:?}");
}

/// A line that is cut between two times, microseconds.
struct Cut {
    sim: Sim,
    cut: core::ops::Range<u64>,
}

impl Link for Cut {
    fn now(&self) -> u64 {
        self.sim.now()
    }

    fn is_free(&self) -> bool {
        self.sim.is_free()
    }

    fn write(&mut self, frame: &[u8]) -> io::Result<()> {
        if self.cut.contains(&self.sim.now()) {
            return Ok(());
        }
        self.sim.write(frame)
    }

    fn read(&mut self) -> io::Result<Option<u8>> {
        let byte = self.sim.read()?;
        Ok(byte.filter(|_| !self.cut.contains(&self.sim.now())))
    }

    fn wait(&mut self) -> io::Result<()> {
        self.sim.wait()
    }
}

fn told(summary: &Summary) -> String {
    let reason = summary.reason.as_ref();
    reason.map_or_else(String::new, ToString::to_string)
}

/// The line is silent for a second in the middle of the motion.
#[test]
fn a_silence_ends_a_session_that_is_watched_and_no_other() {
    let path = read(&small(), "path.traj");
    let cut = || Cut {
        sim: Sim::new(),
        cut: 1_000_000..2_000_000,
    };
    let (summary, heard) = session(&mut cut(), &path, options(1, false), &|_| Wish::Run);
    assert_eq!(summary.outcome, Outcome::Held, "{summary:?}");
    assert_eq!(summary.reason, Some(Ending::Held(Reason::Silence)));
    assert_eq!(heard.last().unwrap().state, State::Holding);
    let unattended = options(1, false).with(|it| it.unattended = true);
    let mut link = cut();
    let (summary, heard) = session(&mut link, &path, unattended, &|_| Wish::Run);
    assert_eq!(summary.outcome, Outcome::Done, "{summary:?}");
    assert!(heard.iter().any(|told| told.state == State::Holding));
}

/// Unattended or not: a stop line ends the session.
#[test]
fn nobody_undoes_a_stop_line_but_an_operator() {
    struct Pull(Sim);
    impl Link for Pull {
        fn now(&self) -> u64 {
            self.0.now()
        }
        fn is_free(&self) -> bool {
            self.0.is_free()
        }
        fn write(&mut self, frame: &[u8]) -> io::Result<()> {
            self.0.write(frame)
        }
        fn read(&mut self) -> io::Result<Option<u8>> {
            self.0.read()
        }
        fn wait(&mut self) -> io::Result<()> {
            if self.0.now() == 1_000_000 {
                self.0.stop()?;
            }
            self.0.wait()
        }
    }
    let path = read(&small(), "path.traj");
    for (unattended, resume) in [(false, false), (true, false), (true, true)] {
        let options = options(1, resume).with(|it| it.unattended = unattended);
        let mut link = Pull(Sim::new());
        let (summary, _) = session(&mut link, &path, options, &|_| Wish::Run);
        assert_eq!(summary.outcome, Outcome::Held, "{summary:?}");
        assert!(
            told(&summary).starts_with("the stop line was drawn"),
            "{summary:?}"
        );
    }
}

/// A host that has died, one that has asked to hold, and one that is taken over leave a hold. It stays, and so does the
/// path, until an operator goes on.
#[test]
fn a_hold_of_another_session_stays_until_an_operator_goes_on() {
    let path = read(&small(), "path.traj");
    let other = path.reverse();
    for (how, reason) in [
        ("asks", "a host has asked to hold"),
        ("dies", "the controller did not hear its host"),
        ("is taken over", "the sheet moved for another host"),
    ] {
        let mut sim = Sim::new();
        if how == "asks" {
            let (summary, _) = session(&mut sim, &path, options(1, false), &stops);
            assert_eq!(summary.outcome, Outcome::Stopped);
        } else {
            let gone = Cell::new(false);
            struct Dies<'a>(usize, &'a Cell<bool>);
            impl Watcher for Dies<'_> {
                fn telemetry(&mut self, _: &Telemetry) -> io::Result<()> {
                    self.0 += 1;
                    Ok(())
                }
                fn wish(&mut self) -> Wish {
                    self.1.set(self.0 >= 40);
                    if self.1.get() { Wish::Quit } else { Wish::Run }
                }
            }
            struct Mute<'a>(&'a mut Sim, &'a Cell<bool>);
            impl Link for Mute<'_> {
                fn now(&self) -> u64 {
                    self.0.now()
                }
                fn is_free(&self) -> bool {
                    self.0.is_free()
                }
                fn write(&mut self, frame: &[u8]) -> io::Result<()> {
                    // It leaves without a word, and draws no stop line.
                    if self.1.get() {
                        return Ok(());
                    }
                    self.0.write(frame)
                }
                fn read(&mut self) -> io::Result<Option<u8>> {
                    self.0.read()
                }
                fn wait(&mut self) -> io::Result<()> {
                    self.0.wait()
                }
            }
            let summary = run(
                &mut Mute(&mut sim, &gone),
                &path,
                options(1, false),
                &mut Dies(0, &gone),
            )
            .unwrap();
            assert_eq!(summary.outcome, Outcome::Stopped, "{summary:?}");
            if how == "dies" {
                (0..8000).for_each(|_| sim.wait().unwrap());
                assert_eq!(sim.device().follower().state(), State::Holding);
            }
        }
        for (id, path) in [(2, &path), (3, &other)] {
            let (summary, heard) = session(&mut sim, path, options(id, false), &|_| Wish::Run);
            assert_eq!(summary.outcome, Outcome::Held, "{how}: {summary:?}");
            // The reason that held first is told.
            assert!(told(&summary).starts_with(reason), "{how}: {summary:?}");
            assert_eq!(
                (summary.setpoints, heard.last().unwrap().state),
                (0, State::Holding)
            );
        }
        let (summary, _) = session(&mut sim, &path, options(4, true), &|_| Wish::Run);
        assert_eq!(summary.outcome, Outcome::Done, "{how}: {summary:?}");
    }
}

/// The word of an operator begins anew, once a hold is undone.
#[test]
fn a_path_begins_anew_where_an_operator_says() {
    let path = read(&small(), "path.traj");
    let mut sim = Sim::new();
    let (summary, _) = session(&mut sim, &path, options(1, false), &stops);
    assert_eq!(summary.outcome, Outcome::Stopped, "{summary:?}");
    for resume in [false, true] {
        let options = options(2 + u32::from(resume), resume).with(|it| it.stands = Stands::AtStart);
        let (summary, heard) = session(&mut sim, &path, options, &|_| Wish::Run);
        if resume {
            assert_eq!(summary.outcome, Outcome::Done, "{summary:?}");
            assert_eq!(
                (running(&heard).place.knot, summary.setpoints),
                (0, path.times().len() as u64)
            );
        } else {
            assert!(
                told(&summary).starts_with("a host has asked to hold"),
                "{summary:?}"
            );
        }
    }
}

/// A log that cannot be written holds the sheet, which then goes on from there.
#[test]
fn a_watcher_that_fails_holds_the_motion_first() {
    struct Fails(usize);
    impl Watcher for Fails {
        fn telemetry(&mut self, _: &Telemetry) -> io::Result<()> {
            self.0 += 1;
            assert!(self.0 <= 40, "not asked again");
            if self.0 == 40 {
                return Err(io::ErrorKind::StorageFull.into());
            }
            Ok(())
        }
        fn wish(&mut self) -> Wish {
            Wish::Run
        }
    }
    let path = read(&small(), "path.traj");
    let mut sim = Sim::new();
    let error = run(&mut sim, &path, options(1, false), &mut Fails(0)).unwrap_err();
    assert_eq!(error.kind(), io::ErrorKind::StorageFull);
    let follower = sim.device().follower();
    assert_eq!(
        (follower.state(), follower.rate().to_bits()),
        (State::Holding, 0)
    );
    let (summary, _) = session(&mut sim, &path, options(2, true), &|_| Wish::Run);
    assert_eq!(summary.outcome, Outcome::Done, "{summary:?}");
}

/// Writes a path of a group from one angle to another.
fn made(folder: &Folder, name: &str, angles: [f32; 2]) {
    let limits = [GroupLimits {
        lower: -3.0,
        upper: 3.0,
        speed: 2.0,
        acceleration: f32::INFINITY,
    }];
    let view = TrajectoryView::new(
        Interpolation::Linear,
        1,
        &[0.0, 1.0],
        &angles,
        &[0.0; 2],
        &[],
    );
    let hinges = [Membership {
        group: GroupId(0),
        negative: false,
    }];
    let stars = StarsView::new(&[], &[], 1).unwrap();
    let mut bytes = Vec::new();
    let sink = |part: &[u8]| bytes.extend_from_slice(part);
    write(
        view.unwrap(),
        &limits,
        &hinges,
        stars,
        0.0,
        LagCost::UNKNOWN,
        sink,
    )
    .unwrap();
    std::fs::write(folder.path(name), bytes).unwrap();
}

#[test]
fn the_word_of_an_operator_has_to_fit_the_path() {
    let folder = small();
    made(&folder, "folded.traj", [0.5, 1.0]);
    made(&folder, "still.traj", [1e-7, 0.0]);
    for arguments in [
        "path.traj --at flat",
        "path.traj --at start",
        "path.traj --at goal --reverse",
        "path.traj --at start --reverse",
        "path.traj --reverse",
        "path.traj --at measured --drives lag=0.001",
        "path.traj --at measured --reverse --drives lag=0.001",
        "folded.traj --at start",
        "folded.traj --at goal --reverse",
        "still.traj --at flat",
        "still.traj --at goal",
    ] {
        let json = folder
            .done(&format!("stream {arguments} --to sim --json"))
            .json();
        assert_eq!(json["outcome"], "done", "{arguments}: {json}");
    }
    for (arguments, message) in [
        (
            "path.traj --at goal",
            "--at goal: the path does not begin at the goal, but flat; say --at flat, or turn the path round by --reverse",
        ),
        (
            "path.traj --at flat --reverse",
            "--at flat: the path, with --reverse, does not begin flat, but at the goal; say --at goal, or leave --reverse out",
        ),
        (
            "folded.traj --at flat",
            "--at flat: the path does not begin flat, but folded, with group 0 at 28.648 degrees; say --at start if it \
             stands there, or --at measured",
        ),
        (
            "folded.traj --at goal",
            "--at goal: the path does not begin at the goal, but folded",
        ),
    ] {
        let answer = folder
            .run(&format!("stream {arguments} --to sim --log log.csv"))
            .with_status(2);
        assert!(answer.begins(message), "{answer:?}");
    }
    assert!(!folder.names().contains(&"log.csv".into()));
}

/// A controller that tells angles on the path that tear the sheet, as firmware with a fault in it would: the motion is held,
/// and the session ends with that.
#[test]
fn angles_that_tear_the_sheet_end_the_session() {
    struct Liar {
        sim: Sim,
        deframer: Deframer<512>,
        ready: VecDeque<u8>,
    }
    impl Link for Liar {
        fn now(&self) -> u64 {
            self.sim.now()
        }
        fn is_free(&self) -> bool {
            self.sim.is_free()
        }
        fn write(&mut self, frame: &[u8]) -> io::Result<()> {
            self.sim.write(frame)
        }
        fn read(&mut self) -> io::Result<Option<u8>> {
            while self.ready.is_empty() {
                let Some(byte) = self.sim.read()? else { break };
                let Some(bytes) = self.deframer.push(byte) else {
                    continue;
                };
                let (session, mut message) = frame::open::<ToHost<'_>>(bytes).unwrap();
                let mut changed = Vec::new();
                if let ToHost::Telemetry { place, angles, .. } = &mut message
                    && place.knot > 2
                    && !angles.is_empty()
                {
                    changed.extend_from_slice(angles);
                    let first = f32::from_le_bytes(*changed.first_chunk().unwrap());
                    changed[..4].copy_from_slice(&(first + 1e-3).to_le_bytes());
                    *angles = &changed;
                }
                let mut buffer = [0; 512];
                let sealed = frame::seal(session, &message, &mut buffer).unwrap();
                cobs::encode(sealed, |byte| self.ready.push_back(byte));
            }
            Ok(self.ready.pop_front())
        }
        fn wait(&mut self) -> io::Result<()> {
            self.sim.wait()
        }
    }
    let path = read(&small(), "path.traj");
    let mut liar = Liar {
        sim: Sim::new(),
        deframer: Deframer::default(),
        ready: VecDeque::new(),
    };
    let (summary, _) = session(&mut liar, &path, options(1, false), &|_| Wish::Run);
    assert_eq!(summary.outcome, Outcome::Faulted, "{summary:?}");
    assert!(
        matches!(summary.reason, Some(Ending::Torn(closure)) if closure > 1e-4),
        "{summary:?}"
    );
    assert_eq!(liar.sim.device().follower().state(), State::Holding);
}
