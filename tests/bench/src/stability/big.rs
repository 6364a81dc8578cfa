//! Numbers of 192 bits, for reference values.

use core::cell::RefCell;
use core::ops::{Add, Div, Mul, Neg, Sub};

use astro_float_num::{BigFloat, Consts, RoundingMode, Sign, WORD_BIT_SIZE};

/// Bits of a mantissa: sums in which 64 bits cancel keep 128.
const BITS: usize = 192;
const ROUND: RoundingMode = RoundingMode::ToEven;

/// A number of 192 bits.
#[derive(Clone, Debug)]
pub struct Big(BigFloat);

/// Calls an elementary function with the cached constants that it needs.
fn with_constants<R>(f: impl FnOnce(&mut Consts) -> R) -> R {
    thread_local! {
        static CONSTANTS: RefCell<Option<Consts>> = const { RefCell::new(None) };
    }
    CONSTANTS.with_borrow_mut(|constants| {
        f(constants.get_or_insert_with(|| Consts::new().expect("room for constants")))
    })
}

impl Big {
    /// Converts a number, exactly.
    #[must_use]
    pub fn new(value: f64) -> Self {
        Self(BigFloat::from_f64(value, BITS))
    }

    /// Returns π.
    #[must_use]
    pub fn pi() -> Self {
        Self(with_constants(|constants| constants.pi(BITS, ROUND)))
    }

    /// Converts degrees to radians.
    #[must_use]
    pub fn degrees(degrees: &Self) -> Self {
        &(degrees * &Self::pi()) / &Self::new(180.0)
    }

    /// Returns sine and cosine.
    #[must_use]
    pub fn sin_cos(&self) -> [Self; 2] {
        with_constants(|constants| {
            [
                Self(self.0.sin(BITS, ROUND, constants)),
                Self(self.0.cos(BITS, ROUND, constants)),
            ]
        })
    }

    /// Returns the tangent.
    #[must_use]
    pub fn tan(&self) -> Self {
        let [sin, cos] = self.sin_cos();
        &sin / &cos
    }

    /// Returns the arc tangent.
    #[must_use]
    pub fn atan(&self) -> Self {
        Self(with_constants(|constants| {
            self.0.atan(BITS, ROUND, constants)
        }))
    }

    /// Returns the square root.
    #[must_use]
    pub fn sqrt(&self) -> Self {
        Self(self.0.sqrt(BITS, ROUND))
    }

    /// Returns the absolute value.
    #[must_use]
    pub fn abs(&self) -> Self {
        if self.is_negative() {
            -self
        } else {
            self.clone()
        }
    }

    /// Returns `true` if the number is below 0.
    #[must_use]
    pub fn is_negative(&self) -> bool {
        self.0.is_negative()
    }

    /// Returns the number rounded to `f64`, with an error of at most a bit or two.
    #[must_use]
    pub fn to_f64(&self) -> f64 {
        // The mantissa is a fraction from one half to 1. Its first word is the last of the list.
        let Some((words, _, sign, exponent, _)) = self.0.as_raw_parts() else {
            return f64::NAN;
        };
        let word = f64::from(exponent_of(WORD_BIT_SIZE)).exp2();
        #[allow(clippy::cast_precision_loss, reason = "rounding is what is asked for")]
        let fraction = words.iter().fold(0.0, |sum, &w| (sum + w as f64) / word);
        // Multiplies in two steps, because the power of two alone may overflow.
        let half = exponent / 2;
        let size = fraction * f64::from(half).exp2() * f64::from(exponent - half).exp2();
        if sign == Sign::Neg { -size } else { size }
    }
}

fn exponent_of(bits: usize) -> u8 {
    u8::try_from(bits).unwrap_or(u8::MAX)
}

macro_rules! operator {
    ($($trait:ident $method:ident)*) => {$(
        impl $trait for &Big {
            type Output = Big;
            fn $method(self, other: Self) -> Big {
                Big(self.0.$method(&other.0, BITS, ROUND))
            }
        }
    )*};
}

operator! { Add add Sub sub Mul mul Div div }

impl Neg for &Big {
    type Output = Big;
    fn neg(self) -> Big {
        Big(BigFloat::neg(&self.0))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_come_back() {
        for value in [
            0.0,
            1.0,
            -1.5,
            0.1,
            -1e-300,
            3e300,
            1e-9,
            core::f64::consts::PI,
        ] {
            let back = Big::new(value).to_f64();
            assert!(
                (back - value).abs() <= value.abs() * f64::EPSILON,
                "{value} {back}"
            );
        }
    }

    #[test]
    fn functions_keep_128_bits() {
        let x = Big::new(1.234_567_8);
        let [sin, cos] = x.sin_cos();
        let one = &(&sin * &sin) + &(&cos * &cos);
        let back = x.tan().atan();
        // π/4 = 4 atan 1/5 - atan 1/239 (Machin).
        let [a, b] = [5.0, 239.0].map(|n| (&Big::new(1.0) / &Big::new(n)).atan());
        let four = Big::new(4.0);
        let machin = &four * &(&(&four * &a) - &b);
        for off in [&one - &Big::new(1.0), &back - &x, &machin - &Big::pi()] {
            assert!(off.to_f64().abs() < 1e-45, "{off:?}");
        }
    }
}
