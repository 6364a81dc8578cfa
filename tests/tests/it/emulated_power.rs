//! Is nothing forgotten by resets of the emulated board, and does nothing move after its power was cut, with 2, 11 and 94
//! groups? Each power cut is another process of the emulator, with random bytes in the memory that a reset leaves as it is.
//! `tests/run full` takes 20 moments of each kind with each number of groups.

use foldpath_core::follower::{Denial, Fault, FollowerPosition, Reason, State};
use foldpath_core::trajectory::TrajectoryView;
use foldpath_core::wire::driver::Persistence;
use foldpath_core::wire::path::PathItems;
use foldpath_core::{GroupId, GroupLimits, Interpolation, Membership, StarsView};
use foldpath_test_support::spans;
use rand_core::Rng;

use crate::image::board::{Board, pause};
use crate::image::rig::{IMAGE, Rig, Told};
use crate::image::world::rng;
use crate::image::{address_in, image, turn};

const AN386: &str = "mps2-an386";
/// Numbers of groups.
const SIZES: [usize; 3] = [2, 11, 94];
/// Bytes of the two records of the image, for 256 groups.
const RECORDS: usize = 2 * foldpath_controller::retained::size(256);

/// A path from 0 to 2 rad in two and a half seconds, on which all groups turn alike. It has three hinges for each group.
struct Flat {
    spans: Vec<f32>,
    angles: Vec<f32>,
    rates: Vec<f32>,
    limits: Vec<GroupLimits>,
    hinges: Vec<Membership>,
}

impl Flat {
    fn new(groups: usize) -> Self {
        let times = (0..21_u8).map(|knot| 0.125 * f32::from(knot));
        let hinge = |hinge: usize| Membership {
            group: GroupId(u32::try_from(hinge % groups).unwrap()),
            negative: hinge.is_multiple_of(3),
        };
        let limits = GroupLimits {
            lower: -3.0,
            upper: 3.0,
            speed: 2.5,
            acceleration: 1e9,
        };
        Self {
            angles: times.flat_map(|time| vec![0.8 * time; groups]).collect(),
            rates: vec![0.8; groups * 21],
            spans: spans(21, 0.125),
            limits: vec![limits; groups],
            hinges: (0..3 * groups).map(hinge).collect(),
        }
    }

    fn items(&self) -> PathItems<'_> {
        let (kind, groups) = (Interpolation::Hermite, self.limits.len());
        let view = TrajectoryView::new(kind, groups, &self.spans, &self.angles, &self.rates, &[]);
        let (stars, place) = (
            StarsView::new(&[], &[], groups).unwrap(),
            FollowerPosition::default(),
        );
        PathItems::new(
            view.unwrap(),
            &self.limits,
            &self.hinges,
            stars,
            1e-4,
            place,
        )
        .unwrap()
    }

    fn time(&self, place: FollowerPosition<f32>) -> f32 {
        place.knot as f32 * 0.125 + place.into
    }
}

/// Starts a board, and lets a host fold for a while, drawn from the seed.
fn folding<'a>(flat: &'a Flat, seed: u64) -> Rig<'a> {
    let moment = 50_000 + rng(3000 + seed).next_u64() % 1_200_000;
    println!(
        "{} groups, seed {seed}: at {} ms",
        flat.limits.len(),
        moment / 1000
    );
    let mut rig = Rig::new(Board::fast(AN386, IMAGE, 1 + 2 * seed, false));
    rig.greet(flat.items(), Persistence::None, true);
    rig.until(|rig| {
        rig.told
            .last()
            .is_some_and(|told| told.state == State::Running)
    });
    rig.run(moment);
    rig
}

/// Returns what the board tells now, as its host sees it.
fn known(rig: &Rig<'_>) -> (bool, bool) {
    let report = rig.report.unwrap();
    (report.known, report.stopped)
}

/// Freezes the board, and reads everything that it has said before. Returns what it told last.
fn freeze(rig: &mut Rig<'_>) -> Told {
    rig.board.freeze();
    for _ in 0..30 {
        rig.step();
        pause();
    }
    rig.last().clone()
}

fn power_is_cut(groups: usize, seed: u64) {
    let flat = Flat::new(groups);
    let rig = folding(&flat, seed);
    assert!(rig.last().angles[0] > 0.0, "{:?}", rig.last());
    drop(rig);
    let mut rig = Rig::new(Board::fast(AN386, IMAGE, 2 + 2 * seed, true));
    let mut bytes = vec![0; RECORDS];
    rng(4000 + seed).fill_bytes(&mut bytes);
    rig.board
        .fill(address_in(IMAGE, &["board", "RECORDS"]), &bytes);
    for persistence in [Persistence::Resume, Persistence::None, Persistence::Always] {
        rig.greet(flat.items(), persistence, false);
        rig.until(|rig| rig.report.is_some_and(|report| report.denied.is_some()));
        rig.run(100_000);
        // The host asks again and again.
        rig.until(|rig| rig.report.is_some_and(|report| report.denied.is_some()));
        let denied = rig.report.unwrap().denied;
        assert_eq!(denied, Some(Denial::Unknown(0)), "{persistence:?}");
        assert_eq!(known(&rig), (false, false));
        assert!(
            rig.told.iter().all(|told| told.angles.is_empty()),
            "{:?}",
            rig.last()
        );
    }
    // An operator tells that the sheet is flat again.
    rig.greet(flat.items(), Persistence::None, true);
    rig.finish();
}

fn the_board_is_reset(groups: usize, seed: u64) {
    let flat = Flat::new(groups);
    let mut rig = folding(&flat, seed);
    let stops = seed % 2 == 1;
    if stops {
        rig.board.draw_stop();
        rig.until(|rig| rig.report.is_some_and(|report| report.stopped));
        rig.run(50_000);
    }
    let before = freeze(&mut rig);
    let age = rig.board.since(before.time);
    rig.board.reset();
    rig.forget();
    rig.greet(flat.items(), Persistence::None, false);
    rig.until(|rig| {
        rig.report
            .is_some_and(|report| report.state == State::Ready)
    });
    rig.run(200_000);
    assert_eq!(known(&rig), (true, stops));
    let (stood, after) = (rig.told[0].clone(), rig.last());
    let gone = flat.time(stood.place) - flat.time(before.place);
    // The motion went on behind the last telemetry, which a busy machine may have held up, at most at its full rate.
    let most = age.as_secs_f32() + 2e-3;
    assert!((0.0..=most).contains(&gone), "{gone} of {most}");
    assert_eq!((after.place, &after.angles), (stood.place, &stood.angles));
    if stops {
        assert_eq!(stood.place, before.place);
        assert_eq!(rig.report.unwrap().reason, Reason::StopLine);
    } else {
        // The path begins where the sheet no longer is.
        rig.until(|rig| rig.report.is_some_and(|report| report.denied.is_some()));
        assert_eq!(rig.report.unwrap().denied, Some(Denial::Jump(0)));
    }
    rig.greet(flat.items(), Persistence::Resume, false);
    rig.finish();
}

/// The stop line is drawn while a hinge has stalled: both are told, and both are kept over a reset, with the place on the path.
/// The stuck hinge is elsewhere, so that no hinge is commanded from then on, before the reset and after it, until the hinges
/// are measured again.
fn a_stop_in_a_fault(groups: usize, seed: u64) {
    let flat = Flat::new(groups);
    let mut rig = folding(&flat, seed);
    let fault = Reason::Fault(Fault::Stalled(4));
    rig.board.bench("4k");
    rig.until(|rig| {
        rig.report
            .is_some_and(|report| report.reason == fault && !report.known)
    });
    let is_commanded = |told: &&Told| !told.angles.is_empty();
    let stood = rig.told.iter().rfind(is_commanded).unwrap().clone();
    rig.board.draw_stop();
    rig.until(|rig| rig.report.is_some_and(|report| report.stopped));
    rig.run(50_000);
    assert_eq!(
        (rig.report.unwrap().reason, known(&rig)),
        (fault, (false, true))
    );
    let before = freeze(&mut rig);
    assert_eq!((before.place, before.angles), (stood.place, Vec::new()));
    rig.board.reset();
    rig.forget();
    rig.greet(flat.items(), Persistence::None, false);
    rig.run(100_000);
    assert_eq!(
        (rig.report.unwrap().reason, known(&rig)),
        (fault, (false, true))
    );
    assert_eq!(rig.told.iter().find(is_commanded), None);
    assert_eq!(rig.last().place, stood.place);
    rig.board.bench("f");
    rig.greet(flat.items(), Persistence::Resume, false);
    rig.until(|rig| rig.told.iter().any(|told| !told.angles.is_empty()));
    // The hinge that is free goes with the panels beside it, which stand where they were commanded last. A busy machine reads the
    // first telemetry late.
    let first = rig.told.iter().find(is_commanded).unwrap();
    for (angle, stood) in first.angles.iter().zip(&stood.angles) {
        assert!(*angle >= stood - 0.05, "{angle} {stood}");
    }
    rig.finish();
}

#[test]
#[ignore = "takes minutes: `tests/run full` runs it"]
fn resets_forget_nothing_and_nothing_moves_after_a_power_cut_at_20_moments() {
    image(IMAGE);
    let _turn = turn();
    for (size, groups) in (0..).zip(SIZES) {
        for seed in (0..20).map(|moment| 100 * size + moment) {
            power_is_cut(groups, seed);
            the_board_is_reset(groups, seed);
        }
        a_stop_in_a_fault(groups, 100 * size);
    }
}
