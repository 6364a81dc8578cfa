//! Builds sheets of the families, files of planned paths and noise, and compares numbers.

use foldpath::export::fold::motion_text;
use foldpath::generate::{Miura, Waterbomb, Yoshimura};
use foldpath::motion::Motion;
use foldpath::pattern::Drawing;
use foldpath::planner::Plan;
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

/// Returns a random number between -1 and 1.
pub(crate) fn noise(random: &mut Pcg64) -> f64 {
    (random.next_u64() >> 11) as f64 / 2_f64.powi(52) - 1.0
}

/// Asserts that `a` differs from `b` by at most the fraction `relative` of `b`.
#[track_caller]
pub(crate) fn near(a: f64, b: f64, relative: f64) {
    assert!((a - b).abs() <= relative * b.abs(), "{a} is not {b}");
}
