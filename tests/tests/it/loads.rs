//! Judges the torques of drives by energies of configurations that are closed anew, by the linkage of `tests/src/linkage.rs`.

use foldpath::generate::{Waterbomb, Yoshimura};
use std::sync::Arc;

use foldpath::motion::{GroupNaming, Knot, Motion};
use foldpath::pattern::{CreaseId, CreasePattern, Drawing, DrawnEdge, FaceId, Letter, Unit};
use foldpath::progress::{Progress, Watch};
use foldpath::read::read_pattern;
use foldpath::sensitivity::{Drive, Load, Loads, NoLoads, REGULAR};
use foldpath_core::{GroupId, Membership};
use foldpath_tests::linkage::Linkage;
use foldpath_tests::pattern_file;
use nalgebra::{DMatrix, Vector2};

use crate::sensitivity::{miura, pattern, planned};

/// Difference of a torque from that of energies, over the largest torque.
const EQUAL: f64 = 1e-5;
/// Turn of a driver for central differences over the angle of the hinge that is folded most: errors of third order and rounding
/// are both below [`EQUAL`].
const TURN: f64 = 3e-4;

/// Number of knots of a motion that is made here.
const STEPS: u32 = 10;

struct Case {
    name: &'static str,
    motion: Motion,
    linkage: Linkage,
}

impl Case {
    fn new(name: &'static str, pattern: CreasePattern) -> Self {
        let mut motion = planned(name, &pattern);
        motion.measured_in(Unit::Centimetre);
        let linkage = Linkage::of(&pattern);
        Self {
            name,
            motion,
            linkage,
        }
    }

    /// A sheet whose drivers turn away from a closed configuration, without a planner.
    fn driven(name: &'static str, sheet: crate::sensitivity::Case) -> Self {
        let vertices = sheet.pattern.vertices();
        let drivers = sheet.linkage.drivers(vertices, &sheet.angles);
        let mut angles = sheet.angles.clone();
        let mut knots = Vec::new();
        for step in 0..STEPS {
            knots.push(Knot {
                time: f64::from(step),
                angles: angles.clone(),
                ..Knot::default()
            });
            for (driver, by) in drivers.iter().zip([0.02, -0.015, 0.01]) {
                angles[*driver] += by;
            }
            angles = sheet.linkage.closed(vertices, &angles, &drivers);
            assert!(sheet.linkage.residual(vertices, &angles) < 1e-12, "{name}");
        }
        let mut motion = Motion::flat(name, Arc::new(sheet.pattern));
        for (k, edge) in (0..).zip(motion.pattern.creases()) {
            motion.members[edge.index()] = Some(Membership {
                group: GroupId(k),
                negative: false,
            });
        }
        motion.naming = GroupNaming::Unnamed;
        motion.knots = knots;
        motion.measured_in(Unit::Centimetre);
        Self {
            name,
            motion,
            linkage: sheet.linkage,
        }
    }

    /// Energy at the configuration with these drivers that is closest to a start, joules.
    fn energy(&self, start: &[f64], drivers: &[usize], load: &Load) -> f64 {
        let pattern = &self.motion.pattern;
        let angles = self.linkage.closed(pattern.vertices(), start, drivers);
        let fixed = load.fixed.unwrap_or(pattern.tree().roots()[0]);
        let shape = self.linkage.rigid(&angles);
        let places = self
            .linkage
            .places(pattern, pattern.vertices(), &shape, fixed.index());
        let metres = 0.01;
        let mut energy = 0.0;
        for triangle in pattern.triangles().items() {
            let [a, b, c] = triangle.map(|v| places[v.index()]);
            let area = (b - a).cross(&(c - a)).norm() / 2.0 * metres * metres;
            let middle = (a + b + c) / 3.0 * metres;
            energy -= load.areal_density * area * load.gravity.dot(&middle);
        }
        let springs = angles.iter().zip(pattern.creases()).map(|(angle, edge)| {
            let own = load.springs.iter().rev().find(|(of, _)| of == edge);
            own.map_or(load.spring, |own| own.1) * angle * angle / 2.0
        });
        energy + springs.sum::<f64>()
    }

    fn torque(&self, time: f64, drivers: &[usize], turned: usize, load: &Load) -> f64 {
        let start = self.motion.at_times([time]).crease_angles(0);
        let start = self
            .linkage
            .closed(self.motion.pattern.vertices(), &start, &[]);
        let turn = TURN
            * start
                .iter()
                .fold(0.0_f64, |most, angle| most.max(angle.abs()));
        let at = |by: f64| {
            let mut start = start.clone();
            start[drivers[turned]] += by;
            self.energy(&start, drivers, load)
        };
        (at(turn) - at(-turn)) / (2.0 * turn)
    }
}

pub(crate) fn load(gravity: [f64; 3], spring: f64, fixed: Option<u32>) -> Load {
    Load {
        areal_density: 0.8,
        fixed: fixed.map(FaceId),
        gravity: gravity.into(),
        spring,
        springs: Vec::new(),
    }
}

fn cases() -> Vec<Case> {
    let of_file = |name: &str| read_pattern(&pattern_file(name)).unwrap().pattern;
    let waterbomb = Waterbomb {
        rows: 2,
        columns: 3,
        fold: 0.7,
    };
    let yoshimura = Yoshimura {
        rows: 4,
        columns: 3,
        angle: 35_f64.to_radians(),
        fold: 0.6,
    };
    vec![
        Case::new("miura 2x2", miura(2, 2, 60.0)),
        Case::new("miura 3x3", miura(3, 3, 60.0)),
        Case::new("miura 4x4", miura(4, 4, 50.0)),
        Case::new("square twist", of_file("square-twist-1x1")),
        Case::new("waterbomb", pattern(waterbomb.drawing())),
        Case::new("yoshimura", pattern(yoshimura.drawing())),
        Case::driven(
            "vertex of degree 5",
            crate::sensitivity::Case::vertex(&[0.0, 70.0, 130.0, 200.0, 290.0], 2),
        ),
        Case::driven(
            "vertex of degree 6",
            crate::sensitivity::Case::vertex(&[0.0, 50.0, 120.0, 170.0, 230.0, 300.0], 3),
        ),
        Case::driven("ring of 8", crate::sensitivity::Case::ring(8, 5)),
    ]
}

#[test]
fn torques_are_slopes_of_the_energy() {
    let loads = [
        load([0.0, 0.0, -9.81], 0.0, None),
        load([3.0, -7.0, 2.0], 0.0, Some(1)),
        load([0.0, 5.0, -3.0], 2e-4, Some(0)),
        load([0.0, 0.0, 0.0], 1e-3, None),
    ];
    for case in cases() {
        // One hinge has a spring of its own, and one has none, whatever was said of it before.
        let creases = case.motion.pattern.creases();
        let mut single = load([0.0, 0.0, -9.81], 1e-4, None);
        single.springs = vec![(creases[0], 7e-4), (creases[1], 3e-3), (creases[1], 0.0)];
        for load in loads.iter().chain([&single]) {
            let found = match Loads::least(&case.motion, load, Watch::default()) {
                Ok(found) => found,
                Err(no) => panic!("{}: {no}", case.name),
            };
            let drivers: Vec<usize> = found.drivers.iter().map(|id| id.index()).collect();
            // A sheet that is held in its middle may be in balance, with no torque at all: then rounding is of the weight.
            let area = case.linkage.unit.powi(2) * case.motion.pattern.faces().len() as f64 * 1e-4;
            let weight = load.areal_density * area * load.gravity.norm() * case.linkage.unit * 0.01;
            let peak = found.peak.torque.abs().max(0.02 * weight);
            for k in (0..found.times.len()).step_by(4) {
                for (turned, torque) in found.torques[k].iter().enumerate() {
                    let expected = case.torque(found.times[k], &drivers, turned, load);
                    assert!(
                        (torque - expected).abs() <= EQUAL * peak,
                        "{}: {torque:e} is not {expected:e} at {}, peak {peak:e}",
                        case.name,
                        found.times[k]
                    );
                }
            }
            println!(
                "{}: {} drivers, peak {:.3e} Nm, regularity {:.1e}, {} times, {} left out",
                case.name,
                drivers.len(),
                found.peak.torque,
                found.regularity,
                found.times.len(),
                found.left_out
            );
        }
    }
}

/// Every set of drivers, by ranks and solutions of dense matrices that are made here.
#[test]
fn no_other_set_of_drivers_has_a_smaller_peak() {
    for case in cases() {
        let load = load([0.0, 0.0, -9.81], 1e-5, None);
        let found = Loads::least(&case.motion, &load, Watch::default()).unwrap();
        let size = found.drivers.len();
        assert!(found.is_least, "{}: {size} drivers", case.name);
        if size > 3 {
            continue;
        }
        let hinges = case.motion.pattern.creases().len();
        let mut sets: Vec<Vec<usize>> = vec![Vec::new()];
        for _ in 0..size {
            let longer = sets.iter().flat_map(|set| {
                let from = set.last().map_or(0, |last| last + 1);
                (from..hinges).map(move |next| [set.as_slice(), &[next]].concat())
            });
            sets = longer.collect();
        }
        let (mut regular, mut least) = (0, f64::INFINITY);
        for set in &sets {
            let ids: Vec<CreaseId> = set.iter().map(|&k| CreaseId::new(k)).collect();
            let Ok(other) = Loads::of(&case.motion, &load, &ids) else {
                continue;
            };
            regular += 1;
            least = least.min(other.peak.torque.abs());
            assert!(other.regularity >= REGULAR);
        }
        let peak = found.peak.torque.abs();
        assert!(
            peak <= least * (1.0 + 1e-6),
            "{}: {peak} {least}",
            case.name
        );
        println!(
            "{}: {regular} of {} sets drive it, least peak {peak:.3e} Nm",
            case.name,
            sets.len()
        );
        // Sets that drive the sheet at a time have as many independent rows as drivers among the motions of the linkage.
        let time = found.times[found.times.len() / 2];
        let start = case.motion.at_times([time]).crease_angles(0);
        let vertices = case.motion.pattern.vertices();
        let angles = case.linkage.closed(vertices, &start, &[]);
        let motions = case.linkage.motions(vertices, &angles);
        for set in sets.iter().step_by(sets.len().div_ceil(50)) {
            let ids: Vec<CreaseId> = set.iter().map(|&k| CreaseId::new(k)).collect();
            let drives = Loads::of(&case.motion, &load, &ids).is_ok();
            let rows: DMatrix<f64> = motions.select_rows(set);
            let least = rows.singular_values().min();
            assert!(
                !drives || least >= REGULAR * 0.999,
                "{}: {set:?} {least}",
                case.name
            );
        }
    }
}

/// Drivers beyond the degrees of freedom share the load: together they do the work of the energy, with the least sum of squares.
#[test]
fn more_drivers_share_the_load() {
    for (rows, columns) in [(2, 2), (3, 3)] {
        let case = Case::new("miura", miura(rows, columns, 60.0));
        let load = load([1.0, 0.0, -9.81], 1e-5, Some(0));
        let vertices = case.motion.pattern.vertices();
        let hinges = case.motion.pattern.creases().len();
        let mut before = f64::INFINITY;
        for size in 1..=3 {
            let found = Loads::least_of(&case.motion, &load, Some(size), Watch::default()).unwrap();
            assert_eq!(found.drivers.len(), size);
            assert!(found.is_least && found.regularity >= REGULAR);
            let peak = found.peak.torque.abs();
            assert!(peak < before, "{size}: {peak} {before}");
            before = peak;
            let drivers: Vec<usize> = found.drivers.iter().map(|id| id.index()).collect();
            for k in (0..found.times.len()).step_by(5) {
                let start = case.motion.at_times([found.times[k]]).crease_angles(0);
                let angles = case.linkage.closed(vertices, &start, &[]);
                let motion = case.linkage.motions(vertices, &angles);
                let rates: Vec<f64> = drivers.iter().map(|&driver| motion[(driver, 0)]).collect();
                let work: f64 = rates
                    .iter()
                    .zip(&found.torques[k])
                    .map(|(a, b)| a * b)
                    .sum();
                let slope = case.torque(found.times[k], &drivers[..1], 0, &load) * rates[0];
                assert!((work - slope).abs() <= EQUAL * peak, "{work:e} {slope:e}");
                // With one degree of freedom the least torques are in proportion to the rates.
                for (rate, torque) in rates.iter().zip(&found.torques[k]) {
                    let expected = slope * rate / rates.iter().map(|it| it * it).sum::<f64>();
                    assert!(
                        (torque - expected).abs() <= EQUAL * peak,
                        "{torque:e} {expected:e}"
                    );
                }
            }
            // No other set of two does with less.
            if size == 2 {
                for a in 0..hinges {
                    for b in 0..a {
                        let ids = [b, a].map(CreaseId::new);
                        let other = Loads::of(&case.motion, &load, &ids).unwrap();
                        assert!(other.peak.torque.abs() >= peak * (1.0 - 1e-6));
                    }
                }
            }
        }
        let none = Loads::least_of(&case.motion, &load, Some(0), Watch::default());
        let size = NoLoads::Size {
            size: 0,
            freedom: 1,
            hinges,
        };
        assert_eq!(none.err(), Some(size));
    }
}

#[test]
fn a_drive_stalls_where_its_torque_at_that_speed_does_not_do() {
    let case = Case::new("miura 3x3", miura(3, 3, 60.0));
    // Held in the middle, the sheet is in balance.
    let found = |fixed: Option<u32>| {
        let load = load([0.0, 0.0, -9.81], 0.0, fixed);
        Loads::least(&case.motion, &load, Watch::default()).unwrap()
    };
    assert!(found(None).peak.torque.abs() <= 0.0);
    let found = found(Some(0));
    let peak = found.peak.torque.abs();
    let drive = |stall_torque: f64, speed: f64| Drive {
        name: "drive".into(),
        stall_torque,
        speed,
    };
    assert_eq!(found.stalls_at(&drive(peak * 1.001, 1e9)), None);
    let weak = found.stalls_at(&drive(peak * 0.999, 1e9)).unwrap();
    assert!((weak - found.peak.at).abs() < 1e-12);
    // A drive that is too slow stalls as soon as it has to lift at speed.
    let fastest = found
        .speeds
        .iter()
        .flatten()
        .fold(0.0_f64, |most, it| most.max(it.abs()));
    assert!(fastest > 0.1);
    assert!(found.stalls_at(&drive(peak * 1e3, fastest * 0.5)).is_some());
}

#[test]
fn loads_that_have_no_answer_say_why() {
    let mut case = Case::new("miura 3x3", miura(3, 3, 60.0));
    let weight = load([0.0, 0.0, -9.81], 0.0, Some(99));
    let no_face = Loads::least(&case.motion, &weight, Watch::default()).err();
    assert_eq!(
        no_face,
        Some(NoLoads::NoFace {
            face: FaceId(99),
            faces: 9
        })
    );
    let weight = load([0.0, 0.0, -9.81], 0.0, None);
    let cancelled = Progress::new();
    cancelled.cancel();
    let none = Loads::least(&case.motion, &weight, Watch::new(&cancelled));
    assert_eq!(none.err(), Some(NoLoads::Cancelled));
    let none = Loads::of(&case.motion, &weight, &[]);
    assert_eq!(none.err(), Some(NoLoads::NoDrivers { size: 1 }));
    case.motion.pattern = Arc::new(miura(3, 3, 60.0));
    assert_eq!(
        Loads::least(&case.motion, &weight, Watch::default()).err(),
        Some(NoLoads::NoUnit)
    );
    let mut flat = Motion::flat("flat", Arc::new(miura(3, 3, 60.0)));
    flat.measured_in(Unit::Metre);
    assert!(matches!(
        Loads::least(&flat, &weight, Watch::default()),
        Err(NoLoads::NoMotion { .. })
    ));
    // A panel that hangs on a held one by a hinge: the closed form.
    let arm = Drawing {
        vertices: [
            [0.0, 0.0],
            [1.0, 0.0],
            [3.0, 0.0],
            [3.0, 1.0],
            [1.0, 1.0],
            [0.0, 1.0],
        ]
        .map(Vector2::from)
        .to_vec(),
        edges: vec![
            DrawnEdge {
                ends: [1, 4],
                letter: Letter::Valley,
                goal: Some(2.0),
            },
            DrawnEdge::boundary([0, 1]),
            DrawnEdge::boundary([1, 2]),
            DrawnEdge::boundary([2, 3]),
            DrawnEdge::boundary([3, 4]),
            DrawnEdge::boundary([4, 5]),
            DrawnEdge::boundary([5, 0]),
        ],
        faces: None,
    };
    let arm = Case::new("arm", CreasePattern::new(arm).unwrap());
    let held = arm
        .motion
        .pattern
        .faces()
        .iter()
        .position(|face| face.iter().any(|v| v.0 == 0))
        .unwrap();
    let weight = load([0.0, 0.0, -10.0], 0.0, u32::try_from(held).ok());
    let found = Loads::least(&arm.motion, &weight, Watch::default()).unwrap();
    // 0.8 kg/m² on 2 cm by 1 cm, its middle 1 cm from the hinge: 1.6e-5 Nm when it is level.
    for (time, torques) in found.times.iter().zip(&found.torques) {
        let angle = arm.motion.at_times([*time]).crease_angles(0)[0];
        assert!(
            (torques[0] - 1.6e-5 * angle.cos()).abs() < 1e-12,
            "{angle}: {torques:?}"
        );
    }
    assert!((found.peak.torque - 1.6e-5).abs() < 1e-9);
}
