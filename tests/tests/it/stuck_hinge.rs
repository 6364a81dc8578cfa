//! Does a hinge that sticks tear the sheet by no more than the user has allowed, at the speed that `export` chose? In virtual
//! time with drives that follow late and noisy sensors, and on the emulated board.

use std::path::Path;

use foldpath::export::ExportOptions;
use foldpath::export::traj::TrajFile;
use foldpath::folding::{FoldingMap, hinge_gaps};
use foldpath::motion::Motion;
use foldpath::planner::PlanOptions;
use foldpath::stream::{Options, Outcome, Plant, Sim, Stands, StreamPath, Wish};
use foldpath_core::follower::{Fault, Reason};
use foldpath_core::wire::driver::Persistence;
use foldpath_firmware_sim::hinges::{Drive, Trouble};
use foldpath_tests::{Planned, Random, path_file};

use crate::emulated_stream::session;
use crate::image::board::Board;
use crate::image::rig::{IMAGE, Rig};
use crate::image::{image, turn};

/// Plans a pattern.
fn planned(name: &str) -> Motion {
    path_file(&Planned::new(name, &PlanOptions::default()).text()).unwrap()
}

/// Returns the gap of the sheet at these angles, along its tree and at the hinges off it, median edges.
fn gap(motion: &Motion, angles: &[f64]) -> f64 {
    let (pattern, tree) = (&motion.pattern, motion.pattern.tree());
    let map = FoldingMap::new(pattern, tree, angles);
    let along = map.rigidity(pattern, tree).gap;
    along.max(map.parting(pattern, tree))
}

/// Turns each hinge alone by a small angle, at random places of the motion and at its knots.
#[test]
fn a_hinge_alone_costs_the_gap_that_is_told() {
    const OFF: f64 = 1e-3;
    for name in [
        "miura-5x5",
        "waterbomb-4x6",
        "square-twist-3x3",
        "resch-3x3",
    ] {
        let motion = planned(name);
        let told = hinge_gaps(&motion);
        let mut found = vec![0.0_f64; told.len()];
        let mut rng = Random::new(540);
        let end = motion.knots.last().unwrap().time;
        let mut times: Vec<f64> = motion.knots.iter().map(|knot| knot.time).collect();
        times.extend((0..20).map(|_| rng.uniform(0.0, end)));
        times.sort_by(f64::total_cmp);
        let places = motion.at_times(times);
        // The path has a gap of its own.
        let mut own = 0.0_f64;
        for place in 0..places.knots.len() {
            let mut angles = places.crease_angles(place);
            own = own.max(gap(&motion, &angles) / OFF);
            for hinge in 0..told.len() {
                angles[hinge] += OFF;
                found[hinge] = found[hinge].max(gap(&motion, &angles) / OFF);
                angles[hinge] -= OFF;
            }
        }
        for (hinge, (found, told)) in found.iter().zip(&told).enumerate() {
            let (least, most) = (0.9 * told - 2.0 * own, 1.01 * told + 2.0 * own);
            assert!(*found <= most, "{name} {hinge}: {found} of {told}");
            assert!(*found >= least, "{name} {hinge}: {found} of {told}");
        }
    }
}

/// A sheet, the gap that is allowed, and the drives.
struct Case {
    name: &'static str,
    motion: Motion,
    options: ExportOptions,
    bound: f64,
}

impl Case {
    fn new(name: &'static str, bound: f64) -> Self {
        let options = ExportOptions::default().with(|it| {
            it.bound = Some(bound);
            it.drives.resolution = 0.02_f64.to_radians();
        });
        Self {
            name,
            motion: planned(name),
            options,
            bound,
        }
    }

    /// Returns the path, slowed down as far as the bound requires.
    fn path(&self) -> StreamPath {
        let file = Path::new(self.name);
        let traj = TrajFile::with(&self.motion, file, &self.options).unwrap();
        StreamPath::read(&traj.bytes, file).unwrap()
    }

    /// Lets a hinge stick at a time of this path (seconds) in virtual time. Returns the largest gap until the motion has
    /// failed.
    fn in_virtual_time(&self, path: &StreamPath, hinge: usize, at: f64) -> f64 {
        let drive = Drive {
            lag: self.options.drives.delay,
            noise: self.options.drives.resolution / 2.0,
            ..Drive::default()
        };
        let file = Path::new(self.name);
        #[allow(
            clippy::cast_possible_truncation,
            clippy::cast_sign_loss,
            reason = "less than a minute"
        )]
        let script = vec![((1e6 * at) as u64, Trouble::Stick(hinge))];
        let plant = Plant::new(path, drive, 7, script);
        let plant = plant.with_sheet(path, self.motion.clone(), file).unwrap();
        let mut sim = Sim::driving(plant);
        let options = Options::default().with(|it| it.stands = Stands::Measured);
        let (summary, _) = session::session(&mut sim, path, options, &|_| Wish::Run);
        assert_eq!(summary.outcome, Outcome::Faulted, "{hinge} {summary:?}");
        sim.plant().unwrap().rigidity().unwrap().gap
    }
}

/// Lets hinges stick, each at a time that is drawn from `seed`, and returns the largest of their gaps over the allowed one.
fn worst(case: &Case, path: &StreamPath, hinges: &[usize], seed: u64) -> f64 {
    let mut rng = Random::new(seed);
    let end = *path.times().last().unwrap();
    let gaps = hinges.iter().map(|hinge| {
        let at = rng.uniform(0.2, 0.8) * end;
        case.in_virtual_time(path, *hinge, at) / case.bound
    });
    gaps.fold(0.0, f64::max)
}

/// Returns some hinges of a path.
fn some(path: &StreamPath, count: usize, seed: u64) -> Vec<usize> {
    let mut rng = Random::new(seed);
    let hinges = path.hinges().len();
    (0..count).map(|_| rng.below(hinges)).collect()
}

#[test]
fn a_stuck_hinge_in_virtual_time_keeps_the_bound() {
    for (case, hinges) in [
        (Case::new("miura-5x5", 0.05), None),
        (Case::new("miura-24x24", 0.1), Some(12)),
    ] {
        let slow = case.path();
        let hinges = hinges.map_or_else(
            || (0..slow.hinges().len()).collect(),
            |count| some(&slow, count, 541),
        );
        let found = worst(&case, &slow, &hinges, 542);
        println!(
            "{}: {found:.2} of the bound, in {:?} s",
            case.name,
            slow.times().last()
        );
        assert!(found <= 1.0, "{}: {found}", case.name);
        // At the speed of the path itself a stuck hinge tears farther.
        let file = Path::new(case.name);
        let fast = TrajFile::of(&case.motion, file).unwrap();
        let fast = StreamPath::read(&fast.bytes, file).unwrap();
        let found = worst(&case, &fast, &hinges[..3], 542);
        assert!(found > 1.5, "{}: {found} without a bound", case.name);
    }
}

/// Lets a hinge stick at a time of the path (microseconds) on an emulated board, and returns the gap once the motion has
/// failed.
fn on_a_board(case: &Case, path: &StreamPath, hinge: usize, at: u64) -> f64 {
    let mut rig = Rig::new(Board::strong("mps2-an386", IMAGE, 540 + at));
    // Resumes if this machine was so slow that the board took its host for gone.
    rig.greet(path.items().unwrap(), Persistence::Always, true);
    rig.until(|rig| rig.told.last().is_some_and(|told| told.rate > 0.0));
    rig.run(at);
    rig.board.bench(&format!("{hinge}k"));
    let number = u32::try_from(hinge).unwrap();
    let fault = Reason::Fault(Fault::Stalled(number));
    rig.until(|rig| rig.report.is_some_and(|report| report.reason == fault));
    let since = rig.last().time;
    rig.until(|rig| rig.last().time > since && rig.measured.contains_key(&number));
    let commanded = rig.last().angles.clone();
    let angles = path.hinges().iter();
    let mut angles: Vec<f64> = angles
        .map(|of| f64::from(of.apply(commanded[of.group.index()])))
        .collect();
    angles[hinge] = rig.measured[&number].into();
    gap(&case.motion, &angles)
}

#[test]
fn a_stuck_hinge_on_an_emulated_board_keeps_the_bound() {
    image(IMAGE);
    let _turn = turn();
    for (case, count) in [
        (Case::new("miura-5x5", 0.05), 6),
        (Case::new("miura-24x24", 0.1), 3),
    ] {
        let path = case.path();
        let mut rng = Random::new(543);
        for hinge in some(&path, count, 544) {
            let at = 1_000_000 + rng.below(2_000_000) as u64;
            let found = on_a_board(&case, &path, hinge, at) / case.bound;
            println!("{} hinge {hinge}: {found:.2} of the bound", case.name);
            assert!(
                found > 0.0 && found <= 1.0,
                "{} {hinge}: {found}",
                case.name
            );
        }
    }
}
