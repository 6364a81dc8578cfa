//! Which channel of the drives moves which hinge, and how. `foldpath drive --rust` writes the channels of all hinges as a
//! constant.

use foldpath_core::GroupLimits;

/// The channel of a hinge.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Channel {
    /// Number of the channel.
    pub channel: u16,
    /// Angle of the channel while the hinge is flat, radians.
    pub zero: f32,
    /// `true` if the channel turns against the hinge.
    pub negative: bool,
    /// Smallest and largest angle of the hinge, radians.
    pub lower: f32,
    /// See `lower`.
    pub upper: f32,
}

impl Channel {
    /// Returns the angle of the channel at which the hinge has this angle, radians.
    #[must_use]
    pub fn raw(&self, angle: f32) -> f32 {
        if self.negative {
            self.zero - angle
        } else {
            self.zero + angle
        }
    }

    /// Returns the angle of the hinge at this angle of the channel, radians.
    #[must_use]
    pub fn angle(&self, raw: f32) -> f32 {
        if self.negative {
            self.zero - raw
        } else {
            raw - self.zero
        }
    }

    /// Returns the limits of a hinge of these channels for [`Settings::limits`](crate::Settings::limits), with this largest
    /// speed (radians per second) and acceleration (radians per second squared). Those of a hinge that has no channel are
    /// no range, so that a sheet with more hinges is refused.
    ///
    /// ```
    /// use foldpath_controller::{Channel, Settings};
    ///
    /// // In a file of its own, which `foldpath drive --map map.csv --rust channels.rs` writes:
    /// pub const CHANNELS: &[Channel] = &[
    ///     Channel { channel: 3, zero: 1.5708, negative: false, lower: -1.6, upper: 1.6 },
    /// ];
    ///
    /// let settings = Settings::new([1, 2], |hinge| Channel::limits(CHANNELS, hinge, 6.0, f32::INFINITY));
    /// assert!((settings.limits)(0).are_sound() && !(settings.limits)(1).are_sound());
    /// ```
    #[must_use]
    pub fn limits(channels: &[Self], hinge: u32, speed: f32, acceleration: f32) -> GroupLimits {
        let index = usize::try_from(hinge).unwrap_or(usize::MAX);
        let channel = channels.get(index);
        let [lower, upper] = channel.map_or([f32::NAN; 2], |it| [it.lower, it.upper]);
        GroupLimits {
            lower,
            upper,
            speed,
            acceleration,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::Channel;

    #[test]
    fn angles_go_to_channels_and_back() {
        let first = Channel {
            channel: 3,
            zero: 1.57,
            negative: false,
            lower: -1.5,
            upper: 0.1,
        };
        let second = Channel {
            zero: -0.25,
            negative: true,
            ..first
        };
        assert_eq!(first.raw(0.5).to_bits(), (1.57_f32 + 0.5).to_bits());
        assert_eq!(second.raw(0.5).to_bits(), (-0.75_f32).to_bits());
        assert_eq!(second.angle(-0.75).to_bits(), 0.5_f32.to_bits());
        assert!((first.angle(first.raw(0.5)) - 0.5).abs() < 1e-6);
    }
}
