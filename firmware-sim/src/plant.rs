//! The hinges of an emulated board: drives with a largest speed, and at most one stuck hinge.
//!
//! All hinges of a group except the stuck one turn alike, so that a sheet of any size takes a few words. A reset leaves
//! the hinges where they are. Faults come as text over a line of their own, the bench: a number and a letter.
//!
//! | text | from now on |
//! |---|---|
//! | `30s` | the supply is at 30 %, and so is the speed of all drives |
//! | `250k` | hinge 250 stays where it is |
//! | `f` | it comes free, and turns to where it is commanded to be, or goes with its group if it has no command |

use core::sync::atomic::{AtomicU32, Ordering::Relaxed};

use foldpath_core::Membership;

/// Speed of a drive for each percent of the supply, radians per microsecond: 6 radians per second at full supply.
const RAD_PER_US_AND_PERCENT: f32 = 6e-8;
/// Longest time that one turn of a drive covers, microseconds: the clock begins anew with a reset.
const MAX_TURN_US: u32 = 10_000;

/// The drive of one or more hinges that turn alike.
#[derive(Debug)]
struct Drive {
    /// Bits of the angle, with the sign of the group, radians. While they are 0, the hinge takes the angle that is
    /// commanded.
    angle: AtomicU32,
    /// Time of the last turn, microseconds.
    turned: AtomicU32,
}

impl Drive {
    const fn new() -> Self {
        Self {
            angle: AtomicU32::new(0),
            turned: AtomicU32::new(0),
        }
    }

    /// Turns towards a command, as far as `speed` (radians per microsecond) allows since the last turn; returns the
    /// angle reached.
    fn turn(&self, command: f32, now: u32, speed: f32) -> f32 {
        let passed = now.wrapping_sub(self.turned.swap(now, Relaxed));
        #[allow(clippy::cast_precision_loss, reason = "at most 10,000")]
        let most = speed * passed.min(MAX_TURN_US) as f32;
        let angle = f32::from_bits(self.angle.load(Relaxed));
        let way = command - angle;
        let angle = if angle.to_bits() == 0 || way.abs() <= most {
            command
        } else {
            angle + most.copysign(way)
        };
        self.angle.store(angle.to_bits(), Relaxed);
        angle
    }
}

/// The hinges of `GROUPS` groups. An interrupt may tell it of faults. Memory of all zeros is a plant without faults.
///
/// Before the first fault the hinges are where they are commanded to be, and nothing measures them.
#[derive(Debug)]
pub struct Plant<const GROUPS: usize> {
    groups: [Drive; GROUPS],
    /// The hinge that is or was stuck: its drive, its number plus 1 (0 for none), and the same while it is stuck.
    odd: Drive,
    odd_one: AtomicU32,
    stuck: AtomicU32,
    /// Percent of the supply that is missing.
    missing: AtomicU32,
    /// Number in the text so far (`number`), and 1 once a text has come (`tested`).
    number: AtomicU32,
    tested: AtomicU32,
}

impl<const GROUPS: usize> Default for Plant<GROUPS> {
    fn default() -> Self {
        Self::new()
    }
}

impl<const GROUPS: usize> Plant<GROUPS> {
    /// Creates hinges without faults, which take the angles that are first commanded.
    #[must_use]
    pub const fn new() -> Self {
        Self {
            groups: [const { Drive::new() }; GROUPS],
            odd: Drive::new(),
            odd_one: AtomicU32::new(0),
            stuck: AtomicU32::new(0),
            missing: AtomicU32::new(0),
            number: AtomicU32::new(0),
            tested: AtomicU32::new(0),
        }
    }

    /// Takes a byte from the bench.
    pub fn hear(&self, byte: u8) {
        let number = self.number.load(Relaxed);
        let digit = byte.wrapping_sub(b'0');
        let next = if digit < 10 {
            number.wrapping_mul(10).wrapping_add(digit.into())
        } else {
            0
        };
        self.number.store(next, Relaxed);
        self.tested.store(1, Relaxed);
        match byte {
            b's' => self.missing.store(100 - number.min(100), Relaxed),
            b'k' => {
                self.odd.angle.store(0, Relaxed);
                self.odd_one.store(number.wrapping_add(1), Relaxed);
                self.stuck.store(number.wrapping_add(1), Relaxed);
            }
            b'f' => self.stuck.store(0, Relaxed),
            _ => {}
        }
    }

    /// Returns the angle of a hinge without a command, radians; `None` before the first fault, when no hinge has an angle
    /// of its own. A hinge that is free again goes with its group, as the panels beside it do.
    #[must_use]
    pub fn measure(&self, hinge: u32, membership: Membership) -> Option<f32> {
        let tested = self.tested.load(Relaxed) != 0;
        let odd = self.stuck.load(Relaxed) == hinge.wrapping_add(1);
        let group = self.groups.get(membership.group.index());
        let drive = if odd { Some(&self.odd) } else { group };
        let bits = drive.filter(|_| tested)?.angle.load(Relaxed);
        (bits != 0).then(|| membership.apply(f32::from_bits(bits)))
    }

    /// Turns a hinge towards its command at `now`, microseconds; returns its angle, or `None` before the first fault. Both
    /// angles are in radians.
    #[inline]
    pub fn drive(&self, hinge: u32, membership: Membership, command: f32, now: u32) -> Option<f32> {
        let tested = self.tested.load(Relaxed) != 0;
        tested.then(|| self.turn(hinge, membership, command, now))
    }

    #[inline(never)]
    fn turn(&self, hinge: u32, membership: Membership, command: f32, now: u32) -> f32 {
        let odd = self.odd_one.load(Relaxed) == hinge.wrapping_add(1);
        let group = self.groups.get(membership.group.index());
        let Some(drive) = group.map(|group| if odd { &self.odd } else { group }) else {
            return command;
        };
        let stuck = odd && self.stuck.load(Relaxed) != 0;
        let missing = self.missing.load(Relaxed).min(100);
        let percent = if stuck { 0 } else { 100 - missing };
        #[allow(clippy::cast_precision_loss, reason = "at most 100")]
        let speed = RAD_PER_US_AND_PERCENT * percent as f32;
        membership.apply(drive.turn(membership.apply(command), now, speed))
    }
}

#[cfg(test)]
mod tests {
    use foldpath_core::{GroupId, Membership};

    use super::Plant;

    fn member(group: u32, negative: bool) -> Membership {
        let group = GroupId(group);
        Membership { group, negative }
    }

    fn tell(plant: &Plant<2>, text: &str) {
        text.bytes().for_each(|byte| plant.hear(byte));
    }

    /// Ticks from `from` to `to` milliseconds; returns the final angles of two hinges of each group.
    fn run(plant: &Plant<2>, commands: [f32; 2], (from, to): (u32, u32)) -> [f32; 4] {
        let [first, second] = commands;
        let mut angles = [0.0; 4];
        for now in (from..to).map(|milli| 1000 * (milli + 1)) {
            let hinges = [
                (0, false, first),
                (1, true, -second),
                (0, true, -first),
                (1, false, second),
            ];
            for ((hinge, (group, negative, command)), angle) in (0..).zip(hinges).zip(&mut angles) {
                let measured = plant.drive(hinge, member(group, negative), command, now);
                *angle = measured.unwrap_or(command);
            }
        }
        angles
    }

    fn near(angles: [f32; 4], expected: [f32; 4]) {
        let mut pairs = angles.iter().zip(expected);
        assert!(pairs.all(|(a, b)| (a - b).abs() < 1e-5), "{angles:?}");
    }

    #[test]
    fn without_a_fault_hinges_are_where_they_are_commanded() {
        let plant = Plant::new();
        near(run(&plant, [0.0, 0.0], (0, 1)), [0.0; 4]);
        near(run(&plant, [3.0, 1.0], (1, 2)), [3.0, -1.0, -3.0, 1.0]);
    }

    #[test]
    fn drives_turn_at_the_speed_that_the_supply_leaves_them() {
        let plant = Plant::new();
        tell(&plant, "30s");
        run(&plant, [0.5, 0.5], (0, 1));
        // 1.8 rad/s for 100 ms; the second group has less far to go.
        let angles = run(&plant, [1.0, 0.4], (1, 101));
        near(angles, [0.68, -0.4, -0.68, 0.4]);
        tell(&plant, "0s");
        near(run(&plant, [1.0, 1.0], (101, 200)), angles);
        tell(&plant, "100s");
        near(
            run(&plant, [1.0, 1.0], (200, 210)),
            [0.74, -0.46, -0.74, 0.46],
        );
        // The clock begins anew, which moves no hinge.
        near(run(&plant, [1.0, 1.0], (0, 1)), [0.8, -0.52, -0.8, 0.52]);
    }

    #[test]
    fn one_hinge_sticks_and_comes_free() {
        let plant = Plant::new();
        run(&plant, [0.5, 0.5], (0, 1));
        tell(&plant, "2k");
        run(&plant, [0.5, 0.5], (1, 2));
        near(run(&plant, [0.6, 0.6], (2, 102)), [0.6, -0.6, -0.5, 0.6]);
        tell(&plant, "f");
        near(run(&plant, [0.6, 0.6], (102, 112)), [0.6, -0.6, -0.56, 0.6]);
        near(run(&plant, [0.6, 0.6], (112, 122)), [0.6, -0.6, -0.6, 0.6]);
    }
}
