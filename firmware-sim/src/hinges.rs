//! The hinges of a simulated sheet: drives that follow their commands with lag, play and noise, in virtual time.
//!
//! A motor comes after its command with a time constant and no faster than it can, its hinge after the motor with
//! the play between them, and what is measured of the hinge is noisy. So the sheet is not where it is commanded, and
//! [`Hinges::torn`] says by how much it does not close there.

use std::vec::Vec;

use foldpath_core::{HalfAngle, Membership, Objective, StarsView};
use rand_core::Rng;

/// What the drives of all hinges are like.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Drive {
    /// Time constant with which a motor follows its command, seconds; 0 for none.
    pub lag: f64,
    /// Most that a motor turns in a second at full supply, radians.
    pub speed: f64,
    /// Angle by which a motor turns before its hinge turns back, radians.
    pub play: f64,
    /// Most by which a measured angle is off, radians.
    pub noise: f64,
}

#[derive(Clone, Copy, Debug)]
struct Hinge {
    membership: Membership,
    motor: f64,
    angle: f64,
    stuck: bool,
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
            angle: 0.0,
            stuck: false,
        };
        Self {
            drive,
            rng,
            hinges: memberships.iter().map(hinge).collect(),
            supply: 1.0,
        }
    }

    /// From now on motors have this part of their speed.
    pub fn supply(&mut self, part: f64) {
        self.supply = part;
    }

    /// From now on this hinge stays where it is.
    pub fn stick(&mut self, hinge: usize) {
        if let Some(hinge) = self.hinges.get_mut(hinge) {
            hinge.stuck = true;
        }
    }

    /// Follows these angles of the groups (radians) for so many seconds. A hinge whose group is not among them stays.
    pub fn follow(&mut self, groups: &[f32], seconds: f64) {
        let Drive {
            lag, speed, play, ..
        } = self.drive;
        let part = 1.0 - (-seconds / lag.max(f64::MIN_POSITIVE)).exp();
        let most = speed * self.supply * seconds;
        for hinge in self.hinges.iter_mut().filter(|hinge| !hinge.stuck) {
            let Some(angle) = groups.get(hinge.membership.group.index()) else {
                continue;
            };
            let command = f64::from(hinge.membership.apply(*angle));
            hinge.motor += ((command - hinge.motor) * part).clamp(-most, most);
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
            let angle = (hinge.angle + noise * (2.0 * part - 1.0)) as f32;
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
