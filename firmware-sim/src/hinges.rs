//! The hinges of a simulated sheet: drives that follow their commands in virtual time.
//!
//! A motor comes after its command with a time constant, no faster and with no more torque than it has, its hinge
//! after the motor with the play between them, and what is measured of the hinge is noisy. So the sheet is not where
//! it is commanded, and [`Hinges::torn`] says by how much it does not close there.

use std::vec::Vec;

use foldpath_core::{HalfAngle, Membership, Objective, StarsView};
use rand_core::Rng;

/// What the drives of all hinges are like.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Drive {
    /// Time constant with which a motor follows its command, seconds; 0 for none.
    pub lag: f64,
    /// Most that a motor turns in a second at full supply, radians.
    pub speed: f64,
    /// Torque of a motor at full supply over what it turns, radians per second squared.
    pub acceleration: f64,
    /// Angle by which a motor turns before its hinge turns back, radians.
    pub play: f64,
    /// Most by which a measured angle is off, radians.
    pub noise: f64,
}

impl Default for Drive {
    /// Drives whose hinges are where they are commanded.
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

/// What befalls hinges.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Trouble {
    /// From now on motors have this part of their speed and torque.
    Supply(f64),
    /// From now on this hinge stays where it is.
    Stick(usize),
    /// It comes loose.
    Free(usize),
    /// From now on this hinge is measured to be so many radians from where it is.
    Jump(usize, f64),
}

#[derive(Clone, Copy, Debug)]
struct Hinge {
    membership: Membership,
    motor: f64,
    rate: f64,
    angle: f64,
    stuck: bool,
    /// By how much its sensor is off.
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
    /// Hinges of these groups and signs, all at 0, whose noise is drawn from `rng`.
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

    /// Something happens. A hinge that there is not is left alone.
    pub fn befall(&mut self, trouble: Trouble) {
        let mut at = |hinge: usize, happens: &dyn Fn(&mut Hinge)| {
            self.hinges.get_mut(hinge).into_iter().for_each(happens);
        };
        match trouble {
            Trouble::Supply(part) => self.supply = part,
            Trouble::Stick(hinge) => at(hinge, &|hinge| hinge.stuck = true),
            Trouble::Free(hinge) => at(hinge, &|hinge| hinge.stuck = false),
            Trouble::Jump(hinge, off) => at(hinge, &|hinge| hinge.off = off),
        }
    }

    /// Follows these angles of the groups (radians) for so many seconds. A hinge whose group is not among them stays.
    pub fn follow(&mut self, groups: &[f32], seconds: f64) {
        let Drive {
            lag,
            speed,
            acceleration,
            play,
            ..
        } = self.drive;
        let part = 1.0 - (-seconds / lag.max(f64::MIN_POSITIVE)).exp();
        // Without supply an infinite speed is none either.
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
            // As fast as it can still brake from afterwards, if its torque is finite.
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

    /// Number, membership and angle (radians) of each hinge, as measured.
    pub fn measured(&mut self) -> impl Iterator<Item = (u32, Membership, f32)> {
        let (rng, noise) = (&mut self.rng, self.drive.noise);
        (0..).zip(&self.hinges).map(move |(number, hinge)| {
            let part = f64::from(rng.next_u32()) / f64::from(u32::MAX);
            #[allow(clippy::cast_possible_truncation, reason = "rounds an angle")]
            let angle = (hinge.angle + hinge.off + noise * (2.0 * part - 1.0)) as f32;
            (number, hinge.membership, angle)
        })
    }

    /// The true angle of each hinge, radians.
    #[must_use]
    pub fn angles(&self) -> Vec<f64> {
        self.hinges.iter().map(|hinge| hinge.angle).collect()
    }

    /// The largest closure residual of the true angles at these vertices, whose unknowns are the hinges; infinite if
    /// they have others.
    #[must_use]
    pub fn torn(&self, stars: StarsView<'_, f64>) -> f64 {
        let mut scratch = std::vec![HalfAngle::default(); self.hinges.len()];
        let value = Objective::Max.value(stars, &self.angles(), &mut scratch);
        value.map_or(f64::INFINITY, |value| value / core::f64::consts::SQRT_2)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use foldpath_core::GroupId;
    use rand_pcg::Pcg64;

    /// Seconds until a hinge has turned by one radian; the most it was beyond.
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

    /// With half the way to speed up and half the way to brake, or with a speed that it keeps between.
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
            // It comes to rest: the last thousandth takes its time.
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
