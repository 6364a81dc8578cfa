//! Homogeneous polynomials in (1 - t, t), with exact coefficients or with rounded ones and a bound on their error.

use core::cmp::Ordering;

use num_bigint::{BigInt, Sign};

/// Numbers that polynomials have as coefficients.
pub(super) trait Number: Clone {
    fn of(value: i64) -> Self;
    fn plus(&self, other: &Self) -> Self;
    fn minus(&self, other: &Self) -> Self;
    fn times(&self, other: &Self) -> Self;
    /// Compares the number with 0.
    fn side(&self) -> Ordering;
}

impl Number for BigInt {
    fn of(value: i64) -> Self {
        value.into()
    }

    fn plus(&self, other: &Self) -> Self {
        self + other
    }

    fn minus(&self, other: &Self) -> Self {
        self - other
    }

    fn times(&self, other: &Self) -> Self {
        self * other
    }

    fn side(&self) -> Ordering {
        match self.sign() {
            Sign::Minus => Ordering::Less,
            Sign::NoSign => Ordering::Equal,
            Sign::Plus => Ordering::Greater,
        }
    }
}

/// A rounded number, with the sum of the magnitudes of all terms that it was made of.
#[derive(Clone, Copy, Debug)]
pub(super) struct Rounded {
    value: f64,
    size: f64,
}

impl Rounded {
    /// Bound on the error of the value over the size. A coefficient is a sum of products of fewer than 20 factors; every
    /// factor, product and sum adds half a unit in the last place at most, fewer than 100 of them on the way of a term.
    const ERROR: f64 = 128.0 * f64::EPSILON;

    /// Returns the sign; `None` if rounding may have changed it.
    pub(super) fn sign(&self) -> Option<Ordering> {
        let certain = self.value.abs() > Self::ERROR * self.size;
        certain.then(|| self.value.total_cmp(&0.0))
    }
}

impl Number for Rounded {
    fn of(value: i64) -> Self {
        #[allow(clippy::cast_precision_loss, reason = "the bound counts it")]
        let value = value as f64;
        Self {
            value,
            size: value.abs(),
        }
    }

    fn plus(&self, other: &Self) -> Self {
        Self {
            value: self.value + other.value,
            size: self.size + other.size,
        }
    }

    fn minus(&self, other: &Self) -> Self {
        Self {
            value: self.value - other.value,
            size: self.size + other.size,
        }
    }

    fn times(&self, other: &Self) -> Self {
        Self {
            value: self.value * other.value,
            size: self.size * other.size,
        }
    }

    fn side(&self) -> Ordering {
        self.value.partial_cmp(&0.0).unwrap_or(Ordering::Equal)
    }
}

/// The polynomial Σ aₖ (1 - t)ⁿ⁻ᵏ tᵏ of degree n. Up to binomial factors, the aₖ are its Bernstein coefficients.
#[derive(Clone, Debug)]
pub(super) struct Polynomial<T>(pub(super) Vec<T>);

impl<T: Number> Polynomial<T> {
    /// Returns the polynomial that is constant, of degree 0.
    pub(super) fn constant(value: i64) -> Self {
        Self(vec![T::of(value)])
    }

    /// Returns the sum of two polynomials of one degree.
    pub(super) fn plus(&self, other: &Self) -> Self {
        self.with(other, T::plus)
    }

    /// Returns the difference of two polynomials of one degree.
    pub(super) fn minus(&self, other: &Self) -> Self {
        self.with(other, T::minus)
    }

    pub(super) fn times(&self, other: &Self) -> Self {
        let mut product = vec![T::of(0); self.0.len() + other.0.len() - 1];
        for (i, a) in self.0.iter().enumerate() {
            for (j, b) in other.0.iter().enumerate() {
                product[i + j] = product[i + j].plus(&a.times(b));
            }
        }
        Self(product)
    }

    pub(super) fn scaled(&self, factor: &T) -> Self {
        Self(self.0.iter().map(|a| a.times(factor)).collect())
    }

    fn with(&self, other: &Self, by: impl Fn(&T, &T) -> T) -> Self {
        assert_eq!(self.0.len(), other.0.len(), "degrees differ");
        let pairs = self.0.iter().zip(&other.0);
        Self(pairs.map(|(a, b)| by(a, b)).collect())
    }
}

/// A quaternion, with its scalar part first.
#[derive(Clone, Debug)]
pub(super) struct Quaternion<T>(pub(super) [Polynomial<T>; 4]);

impl<T: Number> Quaternion<T> {
    pub(super) fn times(&self, other: &Self) -> Self {
        let [a, b, c, d] = &self.0;
        let [e, f, g, h] = &other.0;
        let scalar = {
            let products = [b.times(f), c.times(g), d.times(h)];
            products
                .iter()
                .fold(a.times(e), |sum, product| sum.minus(product))
        };
        let third = |x: [&Polynomial<T>; 2],
                     y: [&Polynomial<T>; 2],
                     z: [&Polynomial<T>; 2],
                     less: [&Polynomial<T>; 2]| {
            x[0].times(x[1])
                .plus(&y[0].times(y[1]))
                .plus(&z[0].times(z[1]))
                .minus(&less[0].times(less[1]))
        };
        Self([
            scalar,
            third([a, f], [b, e], [c, h], [d, g]),
            third([a, g], [c, e], [d, f], [b, h]),
            third([a, h], [d, e], [b, g], [c, f]),
        ])
    }

    pub(super) fn plus(&self, other: &Self) -> Self {
        Self(core::array::from_fn(|k| self.0[k].plus(&other.0[k])))
    }

    pub(super) fn conjugate(&self) -> Self {
        let mut conjugate = self.clone();
        for part in &mut conjugate.0[1..] {
            *part = part.scaled(&T::of(-1));
        }
        conjugate
    }
}
