//! Builds sheets of the families, files of planned paths and noise, and compares numbers.

use foldpath::export::fold::motion_text;
use foldpath::generate::{Miura, Waterbomb, Yoshimura};
use foldpath::lattice::{Lattice, PairClass};
use foldpath::motion::Motion;
use foldpath::pattern::{Drawing, FaceId};
use foldpath::planner::Plan;
use foldpath::planner::timing::OptimalTimeLaw;
use rand_pcg::Pcg64;
use rand_pcg::rand_core::Rng;

/// Returns a Miura sheet with a sector angle of 60°.
pub(crate) fn miura(rows: usize, columns: usize, fold: f64) -> Drawing {
    let sector_angle = 60_f64.to_radians();
    let sheet = Miura {
        rows,
        columns,
        sector_angle,
        fold,
    };
    sheet.drawing().unwrap()
}

/// Returns a waterbomb sheet.
pub(crate) fn waterbomb(rows: usize, columns: usize, fold: f64) -> Drawing {
    let sheet = Waterbomb {
        rows,
        columns,
        fold,
    };
    sheet.drawing().unwrap()
}

/// Returns a Yoshimura sheet with an angle of 0.9 radians.
pub(crate) fn yoshimura(rows: usize, columns: usize, fold: f64) -> Drawing {
    let sheet = Yoshimura {
        rows,
        columns,
        angle: 0.9,
        fold,
    };
    sheet.drawing().unwrap()
}

/// Returns the file of a planned motion, empty if there is none.
pub(crate) fn path_text(title: &str, plan: &Plan) -> String {
    let motion = plan.motion.clone().map(|motion| Motion {
        title: title.into(),
        ..motion
    });
    motion.as_ref().map(motion_text).unwrap_or_default()
}

/// Returns the parameter σ and the acceleration σ̈ of a time law, as functions of the time: between the points of its
/// grid the acceleration is constant.
pub(crate) fn placed(law: &OptimalTimeLaw) -> impl Fn(f64) -> [f64; 2] + '_ {
    let speeds: Vec<f64> = law.speeds().collect();
    move |time| {
        let times = law.times();
        let behind = times.partition_point(|&point| point <= time);
        let k = behind.clamp(1, times.len() - 1) - 1;
        let (from, to) = (law.parameters()[k], law.parameters()[k + 1]);
        let span = to - from;
        let acceleration = if span > 0.0 {
            (speeds[k + 1].powi(2) - speeds[k].powi(2)) / (2.0 * span)
        } else {
            0.0
        };
        let passed = (time - times[k]).min(times[k + 1] - times[k]);
        let sigma = from + passed * (speeds[k] + passed * acceleration / 2.0);
        [sigma.clamp(from, to), acceleration]
    }
}

/// Returns a random number between -1 and 1.
pub(crate) fn noise(random: &mut Pcg64) -> f64 {
    (random.next_u64() >> 11) as f64 / 2_f64.powi(52) - 1.0
}

/// Asserts that `a` differs from `b` by at most the fraction `relative` of `b`.
#[track_caller]
pub(crate) fn near(a: f64, b: f64, relative: f64) {
    assert!((a - b).abs() <= relative * b.abs(), "{a} is not {b}");
}

/// Returns the class of a pair of faces, and the pair in the order of the class; `None` for a face and itself.
pub(crate) fn class_of(lattice: &Lattice, [a, b]: [FaceId; 2]) -> Option<(PairClass, [FaceId; 2])> {
    // The first face is the one of the earlier orbit, then of the earlier row, then of the earlier column.
    let order = |face| {
        let coord = lattice.coord(face);
        (coord.orbit, coord.cell[1], coord.cell[0])
    };
    let [first, second] = if order(a) <= order(b) { [a, b] } else { [b, a] };
    let (from, to) = (lattice.coord(first), lattice.coord(second));
    let class = PairClass {
        orbits: [from.orbit, to.orbit],
        offset: [0, 1].map(|k| to.cell[k] - from.cell[k]),
    };
    (a != b).then_some((class, [first, second]))
}
