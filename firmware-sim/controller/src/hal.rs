//! Adapters of [`embedded_hal`] 1.0: a stop line and a servo of any chip that has such pins and channels.

use core::fmt;

use embedded_hal::digital::InputPin;
use embedded_hal::pwm::SetDutyCycle;

/// A stop line over a contact that opens when it is drawn, between ground and a pin with a pull-up: the pin is low while
/// the line is released. A broken wire, a button that is pressed and a pin that cannot be read all draw it.
#[derive(Debug)]
pub struct NormallyClosed<P> {
    pin: P,
}

impl<P: InputPin> NormallyClosed<P> {
    /// Creates a stop line over a pin that has a pull-up.
    pub fn new(pin: P) -> Self {
        Self { pin }
    }

    /// Returns `true` if the line is drawn now. A pulse that is shorter than a round of the main loop needs an interrupt
    /// that remembers it.
    pub fn is_drawn(&mut self) -> bool {
        !matches!(self.pin.is_low(), Ok(true))
    }
}

/// A servo on a channel of pulses, which holds the pulse that was commanded last.
#[derive(Debug)]
pub struct Servo<C> {
    channel: C,
    period: f32,
    zero: f32,
    radian: f32,
}

/// Reason why a servo keeps its pulse.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[non_exhaustive]
pub enum ServoError<E> {
    /// The angle is no number, or its pulse is not between 0 and the period.
    Angle,
    /// The channel has failed.
    Channel(E),
}

impl<E: fmt::Debug> fmt::Display for ServoError<E> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Angle => write!(
                f,
                "expected an angle whose pulse is shorter than the period"
            ),
            Self::Channel(error) => write!(f, "the channel of the servo has failed: {error:?}"),
        }
    }
}

impl<E: fmt::Debug> core::error::Error for ServoError<E> {}

impl<C: SetDutyCycle> Servo<C> {
    /// Creates a servo on a channel with pulses of this `period`, which has a pulse of the length `zero` at 0 rad and one
    /// that is longer by `radian` at 1 rad, all in microseconds. `radian` is below 0 for a servo that turns the other way.
    /// The channel is left as it is.
    pub fn new(channel: C, period: f32, zero: f32, radian: f32) -> Self {
        Self {
            channel,
            period,
            zero,
            radian,
        }
    }

    /// Commands an angle, radians.
    ///
    /// # Errors
    /// If the angle is refused, or if the channel fails; the servo then keeps its pulse as far as the channel does.
    pub fn command(&mut self, angle: f32) -> Result<(), ServoError<C::Error>> {
        let part = (self.zero + self.radian * angle) / self.period;
        // False for a NaN.
        if !(part > 0.0 && part < 1.0) {
            return Err(ServoError::Angle);
        }
        let most = self.channel.max_duty_cycle();
        #[allow(
            clippy::cast_possible_truncation,
            clippy::cast_sign_loss,
            reason = "from 0 to the largest duty"
        )]
        let duty = (part * f32::from(most) + 0.5) as u16;
        let set = self.channel.set_duty_cycle(duty.min(most));
        set.map_err(ServoError::Channel)
    }

    /// Ends the pulses, so that the servo lets its hinge go.
    ///
    /// # Errors
    /// If the channel fails.
    pub fn rest(&mut self) -> Result<(), ServoError<C::Error>> {
        let set = self.channel.set_duty_cycle_fully_off();
        set.map_err(ServoError::Channel)
    }
}

#[cfg(test)]
mod tests {
    use embedded_hal::digital::{self, InputPin};
    use embedded_hal::pwm::{self, SetDutyCycle};

    use super::{NormallyClosed, Servo, ServoError};

    #[derive(Clone, Copy, Debug, PartialEq, Eq)]
    struct Broken;

    impl digital::Error for Broken {
        fn kind(&self) -> digital::ErrorKind {
            digital::ErrorKind::Other
        }
    }

    impl pwm::Error for Broken {
        fn kind(&self) -> pwm::ErrorKind {
            pwm::ErrorKind::Other
        }
    }

    /// A pin that is low, high or cannot be read.
    struct Pin(Result<bool, Broken>);

    impl digital::ErrorType for Pin {
        type Error = Broken;
    }

    impl InputPin for Pin {
        fn is_high(&mut self) -> Result<bool, Broken> {
            self.0.map(|low| !low)
        }

        fn is_low(&mut self) -> Result<bool, Broken> {
            self.0
        }
    }

    /// A channel of 20,000 steps, which can fail.
    struct Channel(Result<u16, Broken>);

    impl pwm::ErrorType for Channel {
        type Error = Broken;
    }

    impl SetDutyCycle for Channel {
        fn max_duty_cycle(&self) -> u16 {
            20_000
        }

        fn set_duty_cycle(&mut self, duty: u16) -> Result<(), Broken> {
            self.0 = Ok(self.0.map(|_| duty)?);
            Ok(())
        }
    }

    #[test]
    fn an_open_contact_and_an_error_draw_the_stop_line() {
        for (read, drawn) in [(Ok(true), false), (Ok(false), true), (Err(Broken), true)] {
            assert_eq!(NormallyClosed::new(Pin(read)).is_drawn(), drawn);
        }
    }

    #[test]
    fn a_servo_keeps_its_pulse_when_an_angle_is_refused() {
        let mut servo = Servo::new(Channel(Ok(0)), 20_000.0, 1500.0, 600.0);
        for (angle, pulse) in [(0.0, 1500), (1.0, 2100), (-1.5, 600), (0.501, 1801)] {
            assert_eq!(servo.command(angle), Ok(()));
            assert_eq!(servo.channel.0, Ok(pulse));
            for wrong in [
                f32::NAN,
                f32::INFINITY,
                f32::NEG_INFINITY,
                -2.5,
                31.0,
                f32::MAX,
            ] {
                assert_eq!(servo.command(wrong), Err(ServoError::Angle), "{wrong}");
                assert_eq!(servo.channel.0, Ok(pulse));
            }
        }
        assert_eq!(servo.rest(), Ok(()));
        assert_eq!(servo.channel.0, Ok(0));
        let mut broken = Servo::new(Channel(Err(Broken)), 20_000.0, 1500.0, 600.0);
        assert_eq!(broken.command(0.0), Err(ServoError::Channel(Broken)));
    }
}
