//! Numbers of a text, read by the compiler or without `core`'s large tables: exactly rounded.

/// Largest number of significant digits, and of digits behind the point. 10¹⁹ is below 2⁶⁴.
const MAX_DIGITS: u32 = 19;

/// Reads a whole number of 16 bits.
pub(crate) const fn whole(mut text: &[u8]) -> Option<u16> {
    if text.is_empty() {
        return None;
    }
    let mut value = 0_u16;
    while let [byte, rest @ ..] = text {
        let digit = byte.wrapping_sub(b'0');
        if digit > 9 {
            return None;
        }
        value = match value.checked_mul(10) {
            Some(value) => match value.checked_add(digit as u16) {
                Some(value) => value,
                None => return None,
            },
            None => return None,
        };
        text = rest;
    }
    Some(value)
}

/// Reads a decimal number with or without a sign and a point, and returns the nearest `f32`, of two equally near ones the
/// even one, as the standard library does. `None` if it is no such number, if it has an exponent, or if it has more than 19
/// digits behind the point or from its first digit that is not 0 on.
pub(crate) const fn number(text: &[u8]) -> Option<f32> {
    let (negative, mut text) = match text {
        [b'-', rest @ ..] => (true, rest),
        [b'+', rest @ ..] => (false, rest),
        _ => (false, text),
    };
    let (mut value, mut digits, mut decimals) = (0_u64, 0, 0);
    let (mut any, mut point) = (false, false);
    while let [byte, rest @ ..] = text {
        let digit = byte.wrapping_sub(b'0');
        if digit <= 9 {
            any = true;
            digits += (value > 0 || digit > 0) as u32;
            decimals += point as u32;
            if digits > MAX_DIGITS || decimals > MAX_DIGITS {
                return None;
            }
            value = 10 * value + digit as u64;
        } else if *byte == b'.' && !point {
            point = true;
        } else {
            return None;
        }
        text = rest;
    }
    if !any {
        return None;
    }
    let size = quotient(value, 10_u64.pow(decimals));
    Some(if negative { -size } else { size })
}

/// Returns the `f32` nearest to a quotient of two numbers below 2⁶⁴, of which the second is not 0.
#[allow(
    clippy::cast_possible_truncation,
    reason = "the mantissa has 24 bits, and the exponent is within 200"
)]
const fn quotient(value: u64, by: u64) -> f32 {
    if value == 0 {
        return 0.0;
    }
    // With the highest bit set, the quotient has at least 64 bits. The bits below its lowest one only decide whether it is
    // a tie.
    let value = value as u128;
    let shift = value.leading_zeros();
    let (whole, rest) = ((value << shift) / by as u128, (value << shift) % by as u128);
    let drop = 128 - whole.leading_zeros() - 24;
    let (mantissa, half) = ((whole >> drop) as u32, 1_u128 << (drop - 1));
    let behind = whole & ((half << 1) - 1);
    let up = behind > half || behind == half && (rest > 0 || mantissa & 1 == 1);
    // A mantissa of 24 ones that is rounded up carries into the exponent, as it should.
    let exponent = 127 + 23 + drop - shift;
    f32::from_bits(((exponent - 1) << 23) + mantissa + up as u32)
}

#[cfg(test)]
#[allow(clippy::unwrap_used, reason = "a test may panic")]
mod tests {
    use std::format;
    use std::string::{String, ToString};

    use super::{number, whole};

    fn read(text: &str) -> Option<f32> {
        number(text.as_bytes())
    }

    fn same(text: &str) {
        let expected: f32 = text.parse().unwrap();
        let found = read(text).map(f32::to_bits);
        assert_eq!(found, Some(expected.to_bits()), "{text}");
    }

    /// Decimals of all lengths, and decimals on, just above and just below the middle between two numbers.
    #[test]
    fn decimals_are_rounded_as_the_standard_library_rounds_them() {
        let mut state = 1_u64;
        let mut random = || {
            state ^= state << 13;
            state ^= state >> 7;
            state ^= state << 17;
            state
        };
        for _ in 0..100_000 {
            let digits = (random() % 10_u64.pow(19)).to_string();
            let digits = digits.get(..1 + usize::try_from(random() % 19).unwrap() % digits.len());
            let point = random() % 20;
            let mut text: String = if random() % 2 == 0 { "-" } else { "" }.into();
            for (place, digit) in (0..).zip(digits.unwrap().chars()) {
                if place == point {
                    text.push('.');
                }
                text.push(digit);
            }
            same(&text);
            same(&format!("0.{}", &text.replace(['-', '.'], "")));
        }
        for _ in 0..100_000 {
            // The middle between two neighbours from 4 to 8, to 18 digits behind the point, and with another last digit.
            let low = f32::from_bits(0x4080_0000 + u32::try_from(random() % (1 << 23)).unwrap());
            let middle = f64::from(low) / 2.0 + f64::from(low.next_up()) / 2.0;
            let text = format!("{middle:.18}");
            same(&text);
            let mut digits = text.into_bytes();
            let last = digits.last_mut().unwrap();
            *last = b'0' + u8::try_from(random() % 10).unwrap();
            same(&String::from_utf8(digits).unwrap());
        }
        // Ties: numbers above 2²⁴ that are odd.
        for odd in (16_777_217..16_778_217).step_by(2) {
            same(&format!("{odd}"));
            same(&format!("{odd}.0000000001"));
        }
        for text in [
            "0",
            "-0",
            "0.0",
            ".5",
            "5.",
            "+1.5",
            "16777215.5",
            "9999999999999999999",
        ] {
            same(text);
        }
        same("0.0000000000000000001");
        for text in [
            "", "-", ".", "1e3", "nan", "inf", "1,5", "1 2", "--1", "1.2.3", "0x1",
        ] {
            assert_eq!(read(text), None, "{text}");
        }
        assert_eq!(read("12345678901234567890"), None);
        assert_eq!(read("0.12345678901234567890"), None);
    }

    #[test]
    fn whole_numbers_have_16_bits() {
        let read = |text: &str| whole(text.as_bytes());
        assert_eq!(
            (read("0"), read("65535"), read("007")),
            (Some(0), Some(65_535), Some(7))
        );
        for text in ["", "65536", "-1", "+1", "1.0", "99999999999999999999"] {
            assert_eq!(read(text), None, "{text}");
        }
    }
}
