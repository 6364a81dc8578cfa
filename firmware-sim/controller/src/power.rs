//! The power of the drives: one rule for all boards.

use foldpath_core::follower::Target;

/// Tells the drives to hold the hinges or to let them go.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum Power {
    /// Let the hinges go, so that a hand can move them: before the first command, and after a host has asked to forget where
    /// the sheet stands.
    #[default]
    Rest,
    /// Hold the hinges: from the first command on, at rest, in a fault, after a stop, and while it is not known any more where
    /// the sheet stands.
    Hold,
}

/// The command of a drive that turns to what it was commanded last, such as a servo.
///
/// While the controller commands nothing, the drive is to stay where it is, and not to turn back to an old command once a
/// lost supply returns or a hand lets go: its new command is the angle where it was measured last.
#[derive(Clone, Copy, Debug, Default)]
pub struct Hold {
    /// Command of the drive, radians, and `true` if it is one of the controller.
    command: Option<(f32, bool)>,
}

impl Hold {
    /// Returns the angle that the drive is to be commanded now (radians), or `None` if it is to rest. `measured` is the
    /// newest measured angle, if there is one.
    pub fn command(
        &mut self,
        power: Power,
        target: Option<Target<f32>>,
        measured: Option<f32>,
    ) -> Option<f32> {
        let measured = measured.filter(|angle| angle.is_finite());
        self.command = match (power, target, self.command) {
            (_, Some(target), _) => Some((target.angle, true)),
            (Power::Rest, None, _) => None,
            (Power::Hold, None, Some((_, false))) => self.command,
            // Without a sensor there is no better angle than that of the last command.
            (Power::Hold, None, before) => measured.map(|angle| (angle, false)).or(before),
        };
        self.command.map(|(angle, _)| angle)
    }
}

#[cfg(test)]
mod tests {
    use foldpath_core::follower::Target;

    use super::{Hold, Power};

    #[test]
    fn a_drive_stays_where_it_is_measured_once_nothing_is_commanded() {
        let mut hold = Hold::default();
        let target = |angle| Some(Target { angle, rate: 0.0 });
        assert_eq!(hold.command(Power::Rest, None, Some(0.3)), None);
        assert_eq!(hold.command(Power::Hold, target(0.5), Some(0.3)), Some(0.5));
        for measured in [None, Some(f32::NAN)] {
            assert_eq!(hold.command(Power::Hold, None, measured), Some(0.5));
        }
        assert_eq!(hold.command(Power::Hold, None, Some(-0.8)), Some(-0.8));
        // It gives way to no load.
        assert_eq!(hold.command(Power::Hold, None, Some(-0.9)), Some(-0.8));
        assert_eq!(hold.command(Power::Hold, target(0.1), None), Some(0.1));
        assert_eq!(hold.command(Power::Rest, None, Some(0.1)), None);
        assert_eq!(hold.command(Power::Hold, None, None), None);
    }
}
