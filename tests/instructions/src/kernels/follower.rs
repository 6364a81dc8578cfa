//! The kernel of the follower, on Miura's fold.

use core::f64::consts::PI;
use core::hint::black_box;

use foldpath_core::acceptance::{Setpoint, SheetView};
use foldpath_core::follower::{CheckedOptions, Follower, FollowerPosition, State};
use foldpath_core::{GroupId, GroupLimits, Interpolation, Node, Spoke, StarsView};

/// `KNOTS`: number of knots of the path, which are all in the queue. `STEP`: seconds between two knots.
const KNOTS: u16 = 401;
const STEP: f64 = 0.02;
/// Microseconds of a tick.
const TICK: u64 = 1000;
/// Largest fold angle of the path, radians.
const TOP: f64 = 2.6;
/// Largest closure residual, which cubics between knots and rounding in `f32` leave.
const CLOSURE: f32 = 4e-6;

/// Returns a knot of Miura's fold by the closed form, tan(minor/2) = cos 60° tan(major/2).
fn setpoint(number: u16) -> Setpoint<f32, 2> {
    let duration = STEP * f64::from(KNOTS - 1);
    let time = STEP * f64::from(number);
    let (sin, cos) = (PI * time / duration).sin_cos();
    let major = TOP * (1.0 - cos) / 2.0;
    let rate = TOP * sin / 2.0 * PI / duration;
    let t = (major / 2.0).tan();
    let u = t / 2.0;
    #[allow(clippy::cast_possible_truncation, reason = "to f32 on purpose")]
    let node = |angle: f64, rate: f64| Node {
        angle: angle as f32,
        rate: rate as f32,
        weight: [1.0, 0.0],
    };
    let minor = node(2.0 * u.atan(), rate * 0.5 * (1.0 + t * t) / (1.0 + u * u));
    #[allow(clippy::cast_possible_truncation, reason = "to f32 on purpose")]
    let span = STEP as f32;
    Setpoint {
        number: number.into(),
        span,
        last: number + 1 == KNOTS,
        nodes: heapless::Vec::from_array([node(major, rate), minor]),
    }
}

pub(super) fn tick() -> Box<dyn FnMut()> {
    let spoke = |group, negative, degrees: f32| {
        let (sin, cos) = degrees.to_radians().sin_cos();
        Spoke {
            group: GroupId(group),
            negative,
            direction: [cos, sin],
        }
    };
    let spokes = [
        spoke(1, true, 0.0),
        spoke(0, false, 60.0),
        spoke(1, false, 180.0),
        spoke(0, false, 300.0),
    ];
    let limits = [GroupLimits {
        lower: -0.1,
        upper: 2.7,
        speed: 2.5,
        acceleration: 8.0,
    }; 2];
    let sheet = SheetView {
        interpolation: Interpolation::Hermite,
        limits: &limits,
        stars: StarsView::new(&spokes, &[4], 2).expect("a star"),
        closure: CLOSURE,
    };
    let mut follower = Box::new(Follower::<f32, 2, 512>::new(CheckedOptions::default()));
    follower
        .load(&sheet, FollowerPosition::default())
        .expect("idle");
    for number in 0..KNOTS {
        let accepted = follower.accept(&sheet, setpoint(number));
        accepted.expect("a good setpoint");
    }
    follower.confirm().expect("ready");
    follower.start().expect("ready");
    let mut now = 0;
    Box::new(move || {
        now += TICK;
        follower.heard(now);
        let stars = StarsView::accepted(&spokes, &[4], 2);
        follower.tick(stars, black_box(now));
        assert_eq!(follower.state(), State::Running);
    })
}
