//! Random strips, and strips that end where two panels touch or miss each other by little.

use foldpath_test_support::Random;

use super::chain::Chain;
use super::panels::meet;
use super::polynomial::Rounded;
use super::{Hinge, Strip, TURNS, UNITS, resized};

/// Directions of hinges whose length is a whole number: x, y, length.
const DIRECTIONS: [[i64; 3]; 5] = [
    [0, 1, 1],
    [7, 24, 25],
    [9, 40, 41],
    [11, 60, 61],
    [5, 12, 13],
];
/// Largest fold angle, radians.
const MAX_ANGLE_RAD: f64 = 3.0;
/// Number of times the interval is halved in which two panels begin to meet.
const HALVINGS: usize = 60;

impl Strip {
    /// Makes a random strip with this number of hinges, at most four, and a random motion from near flat.
    pub fn random(random: &mut Random, hinges: usize) -> Self {
        loop {
            let strip = Self::drawn(random, hinges);
            if strip.is_convex() {
                return strip;
            }
        }
    }

    /// Makes a random strip of which two panels meet at the end of the motion if the last hinge turns on by `gap`
    /// radians, below 0 for panels that meet already. The motion before may cross as well.
    pub fn nearly_touching(random: &mut Random, hinges: usize, gap: f64) -> Self {
        loop {
            let mut strip = Self::random(random, hinges);
            let bend = random.uniform(-MAX_ANGLE_RAD, MAX_ANGLE_RAD);
            let mut range = [0.0, bend];
            if strip.ends_meeting(range[0]) || !strip.ends_meeting(range[1]) {
                continue;
            }
            for _ in 0..HALVINGS {
                let middle = f64::midpoint(range[0], range[1]);
                range[usize::from(strip.ends_meeting(middle))] = middle;
            }
            strip.turn_last_to(range[0] - gap * bend.signum());
            return strip;
        }
    }

    fn drawn(random: &mut Random, count: usize) -> Self {
        let mut x = 0;
        let mut next = |random: &mut Random| {
            x += units(random.uniform(0.4, 1.6));
            [x, units(random.uniform(-0.1, 0.1))]
        };
        let mut end = |random: &mut Random| {
            let [x, y] = next(random);
            let [shear, height] =
                [(-0.3, 0.3), (0.7, 1.3)].map(|(a, b)| units(random.uniform(a, b)));
            [[x, y], [x + shear, y + height]]
        };
        let mut across = vec![end(random)];
        let mut hinges = Vec::new();
        for _ in 0..count {
            let [below, _] = end(random);
            let [x, y, length] = DIRECTIONS[random.below(DIRECTIONS.len())];
            let x = if random.chance(0.5) { x } else { -x };
            let times = UNITS / length;
            across.push([below, [below[0] + times * x, below[1] + times * y]]);
            let turns = [0.3, MAX_ANGLE_RAD].map(|most| turned(random, most));
            hinges.push(Hinge {
                start: below,
                along: [-x, -y],
                length,
                cos: turns.map(|turn| turn[0]),
                sin: turns.map(|turn| turn[1]),
            });
        }
        across.push(end(random));
        Self { across, hinges }
    }

    /// Sets the fold angle (radians) of the last hinge at the end of the motion.
    fn turn_last_to(&mut self, angle: f64) {
        if let Some(last) = self.hinges.last_mut() {
            [last.cos[1], last.sin[1]] = turns(angle, 1.0);
        }
    }

    /// Returns `true` if two panels meet at the end with this angle (radians) of the last hinge, but for rounding.
    fn ends_meeting(&mut self, angle: f64) -> bool {
        self.turn_last_to(angle);
        let count = self.hinges.len() + 1;
        let panels: Vec<_> = (0..count).map(|k| resized(&self.corners(k), 0.0)).collect();
        let mut pairs = (0..count).flat_map(|a| (a + 2..count).map(move |b| (a, b)));
        pairs.any(|(a, b)| {
            let pose = Chain::<Rounded>::new(&self.hinges[a..b]).pose();
            meet(&panels[a], &panels[b], &pose.at(1, 0))
        })
    }
}

/// Returns a random multiple of cosine and sine of half a random angle, at most `most` radians.
fn turned(random: &mut Random, most: f64) -> [i64; 2] {
    let angle = random.uniform(-most, most);
    turns(angle, random.uniform(0.5, 1.0))
}

/// Returns cosine and sine of half an angle (radians) times `weight`.
fn turns(angle: f64, weight: f64) -> [i64; 2] {
    let (sin, cos) = (angle / 2.0).sin_cos();
    #[allow(
        clippy::cast_possible_truncation,
        clippy::cast_precision_loss,
        reason = "41 bits"
    )]
    [cos, sin].map(|part| (weight * part * TURNS as f64).round() as i64)
}

fn units(length: f64) -> i64 {
    #[allow(
        clippy::cast_possible_truncation,
        clippy::cast_precision_loss,
        reason = "small numbers"
    )]
    let units = (length * UNITS as f64).round() as i64;
    units
}
