//! The path of a Miura fold whose motion is known in closed form, and a controller that has room for it.

use core::f64::consts::{PI, SQRT_2};
use core::num::NonZero;

use foldpath_controller::{Controller, Settings};
use foldpath_core::follower::FollowerPosition;
use foldpath_core::trajectory::TrajectoryView;
use foldpath_core::trajectory_file;
use foldpath_core::wire::path::PathItems;
use foldpath_core::wire::protection::{Protection, Unkeyed};
use foldpath_core::{GroupId, GroupLimits, Interpolation, Membership, Scalar};
use foldpath_test_support::stars::{Stars, foldability_error, miura};
use foldpath_test_support::{Random, spans};
use rand_core::Rng;

/// `STEP`: seconds between two knots. `KNOTS`: number of knots of the path.
const STEP: f64 = 0.02;
pub(crate) const KNOTS: usize = 101;
/// `TOP`: largest fold angle of the path, radians. `LIMITS`: limits of both groups.
pub(crate) const TOP: f64 = 2.6;
pub(crate) const LIMITS: GroupLimits = GroupLimits {
    lower: -0.1,
    upper: 2.7,
    speed: 2.5,
    acceleration: 8.0,
};
/// Largest residual that a commanded configuration may have: the residual of the cubics between knots, and rounding in
/// `f32`.
pub(crate) const CLOSURE: f32 = 2e-6;
/// Limits of the board, which are wider than those of the path.
pub(crate) const BOARD: GroupLimits = GroupLimits {
    lower: -3.2,
    upper: 3.2,
    speed: 20.0,
    acceleration: f32::INFINITY,
};

/// Returns the options of a board on which any sheet may hang. A nonce is not 0, as a seed may be.
pub(crate) fn settings(nonce: u64) -> Settings {
    Settings {
        closed: false,
        nonce: NonZero::new(nonce).or(NonZero::new(1 << 40)),
        ..Settings::new([0, 1], |_| BOARD)
    }
}

/// Returns a controller that is told that both groups stand at 0, where the path begins.
#[cfg_attr(not(test), allow(dead_code, reason = "the fuzzer begins elsewhere"))]
pub(crate) fn flat<P: Protection>(mut device: Device<P>) -> Device<P> {
    let place = FollowerPosition::default();
    device
        .follower_mut()
        .stand(&[0.0; 2], place, false)
        .unwrap();
    device
}

/// A controller with room for this path.
pub(crate) type Device<P = Unkeyed> = Controller<4, 64, 32, 16, P>;

/// Returns a random whole number from 0 to `count - 1`.
pub(crate) fn below(rng: &mut Random, count: u64) -> u64 {
    rng.next_u64() % count
}

/// A path that owns its memory.
pub(crate) struct Path {
    spans: Vec<f32>,
    angles: Vec<f32>,
    rates: Vec<f32>,
    stars: Stars<f32>,
    exact: Stars<f64>,
    /// Group and sign of each hinge.
    pub(crate) hinges: Vec<Membership>,
}

impl Path {
    /// Creates the path of Miura's fold with sector angles of 60°, from flat to [`TOP`]; its rates are 0 at both ends.
    pub(crate) fn miura() -> Self {
        Self::miura_to(TOP)
    }

    /// Creates the path of that fold to another largest angle, radians.
    pub(crate) fn miura_to(top: f64) -> Self {
        let duration = STEP * (KNOTS - 1) as f64;
        let (mut angles, mut rates) = (Vec::new(), Vec::new());
        for knot in 0..KNOTS {
            let time = STEP * knot as f64;
            let (sin, cos) = (PI * time / duration).sin_cos();
            let t = (top * (1.0 - cos) / 4.0).tan();
            let rate = top * sin / 2.0 * PI / duration;
            let minor = rate * 0.5 * (1.0 + t * t) / (1.0 + t * t / 4.0);
            angles.extend([2.0 * t.atan(), 2.0 * (t / 2.0).atan()].map(f32::lit));
            rates.extend([rate, minor].map(f32::lit));
        }
        let hinge = |hinge: u32| Membership {
            group: GroupId(hinge % 2),
            negative: hinge.is_multiple_of(3),
        };
        Self {
            spans: spans(KNOTS, f32::lit(STEP)),
            angles,
            rates,
            stars: vertex(),
            exact: vertex(),
            hinges: (0..50).map(hinge).collect(),
        }
    }

    pub(crate) fn view(&self) -> TrajectoryView<'_, f32> {
        let kind = Interpolation::Hermite;
        TrajectoryView::new(kind, 2, &self.spans, &self.angles, &self.rates, &[]).unwrap()
    }

    pub(crate) fn items(&self, place: FollowerPosition<f32>) -> PathItems<'_> {
        let limits = &[LIMITS; 2];
        PathItems::new(
            self.view(),
            limits,
            &self.hinges,
            self.stars.view(),
            CLOSURE,
            place,
        )
        .unwrap()
    }

    /// Alters an angle or a rate of a knot that is neither the first nor the last, by `off`.
    pub(crate) fn alter(&mut self, rng: &mut Random, off: f64) {
        let numbers = if below(rng, 2) == 0 {
            &mut self.angles
        } else {
            &mut self.rates
        };
        let inner = numbers.len() as u64 - 4;
        numbers[2 + usize::try_from(below(rng, inner)).unwrap()] += f32::lit(off);
    }

    /// Returns the path of the way back.
    pub(crate) fn reversed(&self) -> Self {
        let reverse = |values: &[f32], sign: f32| {
            let knots = values.chunks(2).rev().flatten();
            knots.map(|value| sign * value).collect()
        };
        Self {
            spans: self.spans.clone(),
            angles: reverse(&self.angles, 1.0),
            rates: reverse(&self.rates, -1.0),
            stars: vertex(),
            exact: vertex(),
            hinges: self.hinges.clone(),
        }
    }

    /// Returns the bytes of the path's trajectory file.
    pub(crate) fn file(&self) -> Vec<u8> {
        let mut bytes = Vec::new();
        let (limits, stars) = (&[LIMITS; 2], self.stars.view());
        let sink = |piece: &[u8]| bytes.extend(piece);
        let cost = trajectory_file::LagCost::UNKNOWN;
        trajectory_file::write(
            self.view(),
            limits,
            &self.hinges,
            stars,
            CLOSURE,
            cost,
            sink,
        )
        .unwrap();
        bytes
    }

    /// Returns the closure residual of the real vertex at these angles, by the report's matrices in `f64`.
    pub(crate) fn residual(&self, angles: &[f32]) -> f64 {
        let angles = [angles[0], angles[1]].map(f64::from);
        let star = self.exact.view().iter().next().unwrap();
        foldability_error(star, &angles) / SQRT_2
    }
}

/// Returns Miura's vertex with sector angles of 60°.
pub(crate) fn vertex<T: Scalar>() -> Stars<T> {
    miura(60.0, false, false)
}
