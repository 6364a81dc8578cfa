//! Does a week on a cyclic path go at the speed of the path, from flash and from a host?
//!
//! A tick passes 100 ms, the longest that these options allow, so that the week is whole and takes seconds.

use core::f64::consts::TAU;

use foldpath_controller::{PlayRefusal, Player, Settings};
use foldpath_core::acceptance::Refusal;
use foldpath_core::follower::{FollowerPosition, Options, State};
use foldpath_core::trajectory::TrajectoryView;
use foldpath_core::trajectory_file::{LagCost, write};
use foldpath_core::wire::cobs;
use foldpath_core::wire::driver::{Driver, Persistence};
use foldpath_core::wire::message::ItemRefusal;
use foldpath_core::wire::path::PathItems;
use foldpath_core::wire::protection::Unkeyed;
use foldpath_core::wire::sender;
use foldpath_core::{GroupId, GroupLimits, Interpolation, Membership, Scalar, StarsView};
use foldpath_test_support::spans;

use crate::path::{BOARD, Device, settings};

/// Microseconds of a tick.
const TICK: u64 = 100_000;
/// Seconds between two knots, and knots of a cycle.
const SPAN: f64 = 0.45;
const CYCLE: u32 = 32;
/// Number of segments of 168 hours.
const SEGMENTS: u32 = 168 * 3600 * 100 / 45;
/// Largest speed of the sine of 1 rad, radians per second.
const TOP_SPEED: f64 = TAU / (SPAN * CYCLE as f64);

const HINGES: [Membership; 1] = [Membership {
    group: GroupId(0),
    negative: false,
}];

/// A hinge that swings for 168 hours, and reaches 99.9 % of its largest speed.
struct Week {
    spans: Vec<f32>,
    angles: Vec<f32>,
    rates: Vec<f32>,
    limits: [GroupLimits; 1],
}

/// Returns angle and rate of the hinge behind this number of segments of a cycle.
fn swing(segments: f64) -> [f64; 2] {
    let (sin, cos) = (TAU * segments / f64::from(CYCLE)).sin_cos();
    [sin, TOP_SPEED * cos]
}

impl Week {
    fn new() -> Self {
        let of = |part: usize| {
            let knots = (0..=SEGMENTS).map(|knot| f32::lit(swing((knot % CYCLE).into())[part]));
            knots.collect()
        };
        let speed = f32::lit(TOP_SPEED / 0.999);
        Self {
            spans: spans(SEGMENTS as usize + 1, f32::lit(SPAN)),
            angles: of(0),
            rates: of(1),
            limits: [GroupLimits { speed, ..BOARD }],
        }
    }

    fn view(&self) -> TrajectoryView<'_, f32> {
        let kind = Interpolation::Hermite;
        TrajectoryView::new(kind, 1, &self.spans, &self.angles, &self.rates, &[]).unwrap()
    }

    fn file(&self) -> Vec<u8> {
        let (mut bytes, cost) = (Vec::new(), LagCost::UNKNOWN);
        let stars = StarsView::new(&[], &[], 1).unwrap();
        let sink = |piece: &[u8]| bytes.extend(piece);
        write(self.view(), &self.limits, &HINGES, stars, 1e-4, cost, sink).unwrap();
        bytes
    }

    fn items(&self) -> PathItems<'_> {
        let (stars, place) = (StarsView::new(&[], &[], 1), FollowerPosition::default());
        PathItems::new(
            self.view(),
            &self.limits,
            &HINGES,
            stars.unwrap(),
            1e-4,
            place,
        )
        .unwrap()
    }
}

fn device() -> Device {
    let options = Options {
        longest_tick: TICK.try_into().unwrap(),
        ..Options::DEFAULT
    };
    let settings = Settings {
        follower: options.checked().unwrap(),
        telemetry: 3_600_000_000,
        ..settings(1)
    };
    Device::protected(settings, Unkeyed)
}

/// Checks that the hinge is where the sine has it and as fast, within 0.1 % of its largest speed.
fn swings(device: &Device) {
    let follower = device.follower();
    let FollowerPosition { knot, into } = follower.position();
    if let (&[angle], &[rate]) = (follower.angles(), follower.rates())
        && follower.rate() >= 1.0
    {
        let [exact, speed] = swing(f64::from(knot % CYCLE) + f64::from(into) / SPAN);
        let off = (f64::from(angle) - exact).abs();
        assert!(off <= 1e-5, "{off} rad behind knot {knot}");
        let off = (f64::from(rate) - speed).abs();
        assert!(off <= 1e-3 * TOP_SPEED, "{off} rad/s behind knot {knot}");
    }
}

/// Asserts that the path took its time: 168 hours, and a start and an end at less than full rate.
fn took_a_week([begun, done]: [u64; 2]) {
    let seconds = (done - begun) as f64 / 1e6 - SPAN * f64::from(SEGMENTS);
    assert!((0.0..1.0).contains(&seconds), "{seconds} s too long");
}

/// Plays a path from flash, and looks at the controller in each tick. Returns the microseconds of the beginning and the end of
/// the motion.
fn played(week: &Week, look: impl Fn(&Device)) -> Result<[u64; 2], PlayRefusal> {
    let file = week.file();
    let (mut device, mut player) = (device(), Player::new(&file, None).unwrap());
    player.press_flat();
    let (mut now, mut begun) = (0, 0);
    while device.follower().state() != State::Done {
        if !device.follower().is_under_way() {
            begun = now;
        }
        now += TICK;
        device.play(&mut player, now);
        if let Some(refusal) = player.refused() {
            return Err(refusal);
        }
        device.tick(now);
        look(&device);
    }
    Ok([begun, now])
}

#[test]
fn a_week_is_played_at_its_speed() {
    took_a_week(played(&Week::new(), swings).unwrap());
}

#[test]
fn a_week_is_streamed_at_its_speed() {
    let (mut device, week) = (device(), Week::new());
    let options = sender::Options::default();
    let mut host = Driver::new(week.items(), Persistence::None, 9, options).confirming();
    let (mut scratch, mut buffer) = ([0; 256], [0; 256]);
    let (mut now, mut begun) = (0, 0);
    while device.follower().state() != State::Done {
        if !device.follower().is_under_way() {
            begun = now;
        }
        now += TICK;
        while let Some(frame) = host.poll(now, &mut scratch, &mut buffer) {
            cobs::encode(frame, |byte| device.byte(byte, now));
        }
        device.poll(now);
        device.tick(now);
        swings(&device);
        device.poll(now);
        while let Some(byte) = device.take() {
            host.byte(byte, now);
        }
        assert_eq!(
            host.sender().report().and_then(|report| report.refused),
            None
        );
        assert_eq!(host.held(), None);
    }
    took_a_week([begun, now]);
}

/// The control of the two tests above: spans that are differences of times in `f32`, as in files of version 3, take on the
/// spacing of the times. The hinge then passes its limit within hours.
#[test]
fn times_would_not_last_a_day() {
    let mut week = Week::new();
    let time = |knot: usize| f32::lit(SPAN * knot as f64);
    for (knot, span) in week.spans.iter_mut().enumerate().skip(1) {
        *span = time(knot) - time(knot - 1);
    }
    let refusal = played(&week, |device| {
        assert!(device.follower().position().knot < 86_400 * 100 / 45);
    });
    let speed = ItemRefusal::Setpoint(Refusal::Speed(0));
    assert_eq!(refusal, Err(PlayRefusal::Item(speed)));
}
