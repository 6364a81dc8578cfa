//! A follower of groups that all turn alike, for tests of what holds and starts it.

use foldpath_core::acceptance::{Setpoint, SheetView};
use foldpath_core::follower::{CheckedOptions, Follower, FollowerPosition, State};
use foldpath_core::{GroupId, GroupLimits, Interpolation, Membership, Node, StarsView};
use foldpath_test_support::Measure as _;

pub(crate) const TICK: u64 = 1000;

pub(crate) const LIMITS: GroupLimits = GroupLimits {
    lower: -3.2,
    upper: 3.2,
    speed: 2.0,
    acceleration: 1e4,
};

/// A follower of `G` groups without vertices. All groups turn alike, at 1 rad/s from `begin`.
pub(crate) struct Run<const G: usize> {
    pub(crate) follower: Box<Follower<f32, G, 16>>,
    pub(crate) limits: [GroupLimits; G],
    pub(crate) now: u64,
}

impl<const G: usize> Run<G> {
    pub(crate) fn new() -> Self {
        Self {
            follower: Box::new(Follower::new(CheckedOptions::default())),
            limits: [LIMITS; G],
            now: 0,
        }
    }

    pub(crate) fn load(&mut self, begin: f32) {
        let sheet = SheetView {
            interpolation: Interpolation::Hermite,
            limits: &self.limits,
            stars: StarsView::new(&[], &[], G).unwrap(),
            closure: 1e-4,
        };
        let place = FollowerPosition::default();
        self.follower.load(&sheet, place).unwrap();
        for number in 0..16_u8 {
            let time = f32::from(number) * 0.1;
            let node = Node {
                angle: begin + time,
                rate: 1.0,
                weight: [1.0, 0.0],
            };
            let setpoint = Setpoint {
                number: number.into(),
                span: 0.1,
                last: number == 15,
                nodes: core::iter::repeat_n(node, G).collect(),
            };
            self.follower.accept(&sheet, setpoint).unwrap();
        }
    }

    /// Measures three hinges of each group, of which one turns the opposite way, at these angles.
    pub(crate) fn measure(&mut self, mut angle: impl FnMut(u32) -> f32) {
        for hinge in 0..3 * u32::try_from(G).unwrap() {
            let membership = Membership {
                group: GroupId(hinge % u32::try_from(G).unwrap()),
                negative: hinge.is_multiple_of(3),
            };
            let angle = membership.apply(angle(hinge));
            self.follower.measure(hinge, membership, angle);
        }
    }

    /// Ticks, and returns the largest angle by which a group moved, radians.
    pub(crate) fn tick(&mut self) -> f32 {
        let before = self.follower.angles().to_vec();
        self.now += TICK;
        self.follower.heard(self.now);
        let stars = StarsView::new(&[], &[], G).unwrap();
        self.follower.tick(stars, self.now);
        let moved = before.iter().zip(self.follower.angles());
        moved.fold(0.0, |most, (a, b)| most.max((a - b).abs()))
    }

    /// Ticks, and asserts that nothing moves.
    pub(crate) fn still(&mut self) {
        assert_eq!(self.tick().to_bits(), 0);
    }

    pub(crate) fn until(&mut self, state: State) {
        while self.follower.state() != state {
            assert!(self.tick() <= LIMITS.speed * 1e-3 + 1e-5);
            assert!(self.now < 20_000_000, "{:?}", self.follower.reason());
        }
    }
}
