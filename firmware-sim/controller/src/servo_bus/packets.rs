//! Packets of the servos' bus: version 1.0 of the Dynamixel protocol, which servos of Feetech's STS series speak as well.
//!
//! A packet is `ff ff`, the number of a servo, the count of the bytes that follow, an instruction or an error, parameters,
//! and the complement of the sum of all bytes behind `ff ff`. The addresses below are those of an STS3215. Those of an
//! AX-12 are 24, 30 and 36; it turns by 300 degrees in 1,024 steps.

use core::f32::consts::PI;

/// Address of the byte that switches the drive on.
pub const TORQUE: u8 = 40;
/// Address of the goal, of two bytes.
pub const GOAL: u8 = 42;
/// Address of the present position, of two bytes.
pub const POSITION: u8 = 56;

/// Number of the packets for all servos.
const ALL: u8 = 0xfe;
const READ_DATA: u8 = 2;
const SYNC_WRITE: u8 = 0x83;

/// Steps of a servo at angle 0, and its steps for each radian.
const MIDDLE: f32 = 2048.0;
const RADIAN: f32 = 2048.0 / PI;

/// Bytes of a question to a servo (`READ`) and of its answer (`ANSWER`) of two bytes.
pub const READ: usize = 8;
/// See [`READ`].
pub const ANSWER: usize = 8;

/// Largest number of servos whose goals a packet has room for.
pub const MAX_SERVOS: usize = 80;

/// Returns the number of bytes of the goals of this number of servos.
#[must_use]
pub const fn goals_len(servos: usize) -> usize {
    8 + 3 * servos
}

/// A packet for all servos.
#[derive(Clone, Copy, Debug)]
pub struct Packet {
    bytes: [u8; goals_len(MAX_SERVOS)],
    length: usize,
}

impl Packet {
    /// Writes the same number of bytes at the same address of many servos, which take them up at the same time. `values`
    /// has the number of each servo and its bytes.
    #[must_use]
    pub fn sync_write<const N: usize>(
        address: u8,
        values: impl Iterator<Item = (u8, [u8; N])>,
    ) -> Self {
        let mut packet = Self {
            bytes: [0; goals_len(MAX_SERVOS)],
            length: 0,
        };
        // The count of bytes comes last.
        packet.add([0xff, 0xff, ALL, 0, SYNC_WRITE, address]);
        packet.add(u8::try_from(N).map_or([0], |size| [size]));
        for (servo, bytes) in values {
            packet.add([servo]);
            packet.add(bytes);
        }
        let count = u8::try_from(packet.length.saturating_sub(3)).unwrap_or(0);
        if let Some(place) = packet.bytes.get_mut(3) {
            *place = count;
        }
        packet.add([check(packet.bytes())]);
        packet
    }

    fn add<const N: usize>(&mut self, bytes: [u8; N]) {
        let room = self.bytes.get_mut(self.length..self.length + N);
        if let Some(room) = room {
            room.copy_from_slice(&bytes);
            self.length += N;
        }
    }

    /// Returns the bytes for the bus.
    #[must_use]
    pub fn bytes(&self) -> &[u8] {
        self.bytes.get(..self.length).unwrap_or(&[])
    }
}

/// Returns the question to a servo for `size` bytes at an address.
#[must_use]
pub fn read(servo: u8, address: u8, size: u8) -> [u8; READ] {
    let [a, b, c, d, e, f, g] = [0xff, 0xff, servo, 4, READ_DATA, address, size];
    [a, b, c, d, e, f, g, check(&[a, b, c, d, e, f, g])]
}

/// Returns the complement of the sum of all bytes behind `ff ff`.
fn check(packet: &[u8]) -> u8 {
    !packet
        .iter()
        .skip(2)
        .fold(0, |sum: u8, byte| sum.wrapping_add(*byte))
}

/// Answer of a servo that is being received.
#[derive(Clone, Copy, Debug, Default)]
pub struct Answer {
    bytes: [u8; ANSWER],
    length: usize,
}

impl Answer {
    /// Takes a byte. Returns the number of a servo and the two bytes that it told with the last byte of its answer, or
    /// `None` for these bytes if the servo tells of an error, such as of overload or heat.
    pub fn push(&mut self, byte: u8) -> Option<(u8, Option<[u8; 2]>)> {
        let expected = match self.length {
            0 | 1 => byte == 0xff,
            // A third `ff` is the second byte of a packet that begins one byte later.
            2 if byte == 0xff => return None,
            3 => byte == 4,
            _ => true,
        };
        if !expected {
            *self = Self::default();
            return None;
        }
        if let Some(place) = self.bytes.get_mut(self.length) {
            *place = byte;
            self.length += 1;
        }
        if self.length < ANSWER {
            return None;
        }
        let [_, _, servo, _, error, low, high, sum] = self.bytes;
        let told = self.bytes;
        *self = Self::default();
        let whole = told.get(..ANSWER - 1).map(check) == Some(sum);
        whole.then_some((servo, (error == 0).then_some([low, high])))
    }
}

/// Returns the steps of a servo at this angle, radians.
#[must_use]
pub fn steps(angle: f32) -> u16 {
    let steps = (MIDDLE + RADIAN * angle).clamp(0.0, 4095.0);
    #[allow(
        clippy::cast_possible_truncation,
        clippy::cast_sign_loss,
        reason = "from 0 to 4095"
    )]
    let steps = (steps + 0.5) as u16;
    steps
}

/// Returns the angle of a servo at these steps, radians.
#[must_use]
pub fn angle(steps: u16) -> f32 {
    (f32::from(steps) - MIDDLE) / RADIAN
}

#[cfg(test)]
#[allow(
    clippy::unwrap_used,
    clippy::indexing_slicing,
    reason = "a test may panic"
)]
mod tests {
    use std::vec::Vec;

    use super::*;

    /// The examples of Robotis' description of the protocol: the temperature of servo 1, and its answer of one byte made
    /// one of two.
    #[test]
    fn packets_are_those_of_the_description() {
        assert_eq!(
            read(1, 0x2b, 1),
            [0xff, 0xff, 0x01, 0x04, 0x02, 0x2b, 0x01, 0xcc]
        );
        let packet = Packet::sync_write(0x1e, [(0, [0x10, 0]), (1, [0x20, 2])].into_iter());
        assert_eq!(
            packet.bytes(),
            [
                0xff, 0xff, 0xfe, 0x0a, 0x83, 0x1e, 2, 0, 0x10, 0, 1, 0x20, 2, 0x21
            ]
        );
        let all = Packet::sync_write(GOAL, (0..12).map(|servo| (servo, [0; 2])));
        assert_eq!(all.bytes().len(), goals_len(12));
    }

    fn hear(bytes: &[u8]) -> Vec<(u8, Option<[u8; 2]>)> {
        let mut answer = Answer::default();
        bytes.iter().filter_map(|byte| answer.push(*byte)).collect()
    }

    #[test]
    fn answers_are_found_between_noise() {
        let good = [0xff, 0xff, 3, 4, 0, 0x12, 8, !33];
        assert_eq!(hear(&good), [(3, Some([0x12, 8]))]);
        for noise in [&[0xff][..], &[0xff, 0xff], &[7, 0xff, 0xff, 3, 9], &[0]] {
            assert_eq!(hear(&[noise, &good].concat()), [(3, Some([0x12, 8]))]);
        }
        // Overloaded.
        assert_eq!(hear(&[0xff, 0xff, 3, 4, 32, 0, 0, !39]), [(3, None)]);
        for at in 0..8 {
            for bit in 0..8 {
                let mut bad = good;
                bad[at] ^= 1 << bit;
                assert_eq!(hear(&bad), [], "{at} {bit}");
            }
        }
    }

    #[test]
    fn steps_are_a_twentieth_of_a_degree() {
        assert_eq!([-9.0, 0.0, 9.0].map(steps), [0, 2048, 4095]);
        for step in 0..4096 {
            assert_eq!(steps(angle(step)), step);
        }
    }
}
