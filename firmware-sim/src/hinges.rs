//! The hinges of a simulated sheet: drives that follow their commands in virtual time.
//!
//! A motor follows its command with a time constant, and no faster than its speed and torque allow. The hinge follows
//! its motor with the play between them, and measured angles are noisy. The sheet is therefore not where it is
//! commanded to be: [`Hinges::angles`] returns its true angles.

use std::vec::Vec;

use foldpath_core::Membership;
use rand_core::Rng;

/// Properties of the drives of all hinges.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Drive {
    /// Time constant with which a motor follows its command, seconds; 0 for none.
    pub lag: f64,
    /// Largest speed of a motor at full supply, radians per second.
    pub speed: f64,
    /// Largest acceleration of a motor at full supply (its torque over the inertia that it turns), radians per second
    /// squared.
    pub acceleration: f64,
    /// Angle by which a motor turns before its hinge turns back, radians.
    pub play: f64,
    /// Largest error of a measured angle, radians.
    pub noise: f64,
}

impl Default for Drive {
    /// Ideal drives, whose hinges are where they are commanded to be.
    fn default() -> Self {
        Self {
            lag: 0.0,
            speed: f64::INFINITY,
            acceleration: f64::INFINITY,
            play: 0.0,
            noise: 0.0,
        }
    }
}

/// Troubles that befall hinges.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Trouble {
    /// From now on motors have this fraction of their speed and torque.
    Supply(f64),
    /// From now on this hinge stays where it is.
    Stick(usize),
    /// This hinge comes free.
    Free(usize),
    /// From now on the measured angle of this hinge is off by this much, radians.
    Jump(usize, f64),
    /// A hand turns this hinge by this much, radians.
    Turn(usize, f64),
}

#[derive(Clone, Copy, Debug)]
struct Hinge {
    membership: Membership,
    motor: f64,
    rate: f64,
    angle: f64,
    stuck: bool,
    /// Error of the hinge's sensor, radians.
    off: f64,
}

/// The hinges of a sheet.
#[derive(Clone, Debug)]
pub struct Hinges<R> {
    drive: Drive,
    rng: R,
    hinges: Vec<Hinge>,
    supply: f64,
}

impl<R: Rng> Hinges<R> {
    /// Creates hinges of these groups and signs, all at 0, whose noise is drawn from `rng`.
    pub fn new(memberships: &[Membership], drive: Drive, rng: R) -> Self {
        let hinge = |&membership| Hinge {
            membership,
            motor: 0.0,
            rate: 0.0,
            angle: 0.0,
            stuck: false,
            off: 0.0,
        };
        Self {
            drive,
            rng,
            hinges: memberships.iter().map(hinge).collect(),
            supply: 1.0,
        }
    }

    /// Puts all hinges at these angles of the groups, radians. A hinge whose group has no angle stays.
    pub fn stand(&mut self, groups: &[f32]) {
        for hinge in &mut self.hinges {
            if let Some(angle) = groups.get(hinge.membership.group.index()) {
                hinge.angle = hinge.membership.apply(*angle).into();
                (hinge.motor, hinge.rate) = (hinge.angle, 0.0);
            }
        }
    }

    /// Applies a trouble. A hinge that does not exist is ignored.
    pub fn befall(&mut self, trouble: Trouble) {
        let mut at = |hinge: usize, happens: &dyn Fn(&mut Hinge)| {
            self.hinges.get_mut(hinge).into_iter().for_each(happens);
        };
        match trouble {
            Trouble::Supply(part) => self.supply = part,
            Trouble::Stick(hinge) => at(hinge, &|hinge| hinge.stuck = true),
            Trouble::Free(hinge) => at(hinge, &|hinge| hinge.stuck = false),
            Trouble::Jump(hinge, off) => at(hinge, &|hinge| hinge.off = off),
            Trouble::Turn(hinge, by) => at(hinge, &|hinge| {
                hinge.angle += by;
                hinge.motor += by;
            }),
        }
    }

    /// Follows these angles of the groups (radians) for `seconds` seconds. A hinge whose group has no angle stays.
    pub fn follow(&mut self, groups: &[f32], seconds: f64) {
        let Drive {
            lag,
            speed,
            acceleration,
            play,
            ..
        } = self.drive;
        let part = 1.0 - (-seconds / lag.max(f64::MIN_POSITIVE)).exp();
        // Without supply the limit is 0, even if it is infinite at full supply.
        let supplied = |most: f64| {
            if self.supply > 0.0 {
                most * self.supply
            } else {
                0.0
            }
        };
        let (fastest, strongest) = (supplied(speed), supplied(acceleration));
        let change = strongest * seconds;
        for hinge in &mut self.hinges {
            let Some(angle) = groups.get(hinge.membership.group.index()) else {
                continue;
            };
            if hinge.stuck {
                hinge.rate = 0.0;
                continue;
            }
            let way = f64::from(hinge.membership.apply(*angle)) - hinge.motor;
            // The largest rate from which the motor can still brake to rest at its command, if its torque is finite.
            let most = (change * change + 2.0 * strongest * way.abs()).sqrt() - change;
            let most = fastest.min(most);
            let wanted = (way * part / seconds).clamp(-most, most);
            hinge.rate += (wanted - hinge.rate).clamp(-change, change);
            hinge.rate = hinge.rate.clamp(-fastest, fastest);
            hinge.motor += hinge.rate * seconds;
            let (low, high) = (hinge.motor - play / 2.0, hinge.motor + play / 2.0);
            hinge.angle = hinge.angle.clamp(low, high);
        }
    }

    /// Returns number, membership and measured angle (radians) of each hinge.
    pub fn measured(&mut self) -> impl Iterator<Item = (u32, Membership, f32)> {
        let (rng, noise) = (&mut self.rng, self.drive.noise);
        (0..).zip(&self.hinges).map(move |(number, hinge)| {
            let part = f64::from(rng.next_u32()) / f64::from(u32::MAX);
            #[allow(clippy::cast_possible_truncation, reason = "rounds an angle")]
            let angle = (hinge.angle + hinge.off + noise * (2.0 * part - 1.0)) as f32;
            (number, hinge.membership, angle)
        })
    }

    /// Returns the true angle of each hinge, radians.
    #[must_use]
    pub fn angles(&self) -> Vec<f64> {
        self.hinges.iter().map(|hinge| hinge.angle).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use foldpath_core::GroupId;
    use rand_pcg::Pcg64;

    /// Returns the seconds until a hinge has turned by one radian, and how far it went beyond, radians.
    fn one_radian(drive: Drive) -> (f64, f64) {
        let membership = Membership {
            group: GroupId(0),
            negative: true,
        };
        let mut hinges = Hinges::new(&[membership], drive, Pcg64::new(0, 0));
        let (mut time, mut beyond) = (None, 0.0_f64);
        for step in 1..3000 {
            hinges.follow(&[1.0], 1e-3);
            let turned = hinges.angles().first().map_or(f64::NAN, |angle| -angle);
            beyond = beyond.max(turned - 1.0);
            if turned >= 0.999 {
                time.get_or_insert(1e-3 * f64::from(step));
            }
        }
        (time.unwrap_or(f64::NAN), beyond)
    }

    /// Half of the way to speed up and half to brake, or with the top speed in between.
    #[test]
    fn a_motor_has_its_torque_and_its_speed() {
        let strong = Drive {
            acceleration: 10.0,
            ..Drive::default()
        };
        for (drive, expected) in [
            (strong, 2.0 * 0.1_f64.sqrt()),
            (
                Drive {
                    speed: 1.0,
                    ..strong
                },
                1.0 + 0.1,
            ),
            (
                Drive {
                    speed: 0.5,
                    ..Drive::default()
                },
                2.0,
            ),
            (Drive::default(), 0.001),
        ] {
            let (time, beyond) = one_radian(drive);
            // The hinge comes to rest: the last thousandth takes its time.
            assert!((time - expected).abs() < 0.02, "{time} {expected}");
            assert!(beyond < 1e-3, "{beyond}");
        }
    }

    #[test]
    fn troubles_befall_their_hinge_alone() {
        let memberships = [0, 0, 0].map(|group| Membership {
            group: GroupId(group),
            negative: false,
        });
        let mut hinges = Hinges::new(&memberships, Drive::default(), Pcg64::new(0, 0));
        hinges.befall(Trouble::Stick(1));
        hinges.befall(Trouble::Jump(2, 0.25));
        hinges.befall(Trouble::Jump(7, 0.25));
        hinges.follow(&[0.5], 1e-3);
        assert_eq!(hinges.angles(), [0.5, 0.0, 0.5]);
        let measured: Vec<f32> = hinges.measured().map(|(.., angle)| angle).collect();
        assert_eq!(measured, [0.5, 0.0, 0.75]);
        hinges.befall(Trouble::Free(1));
        hinges.befall(Trouble::Supply(0.0));
        hinges.follow(&[1.0], 1e-3);
        assert_eq!(hinges.angles(), [0.5, 0.0, 0.5]);
        hinges.befall(Trouble::Supply(1.0));
        hinges.follow(&[1.0], 1e-3);
        assert_eq!(hinges.angles(), [1.0; 3]);
    }
}
