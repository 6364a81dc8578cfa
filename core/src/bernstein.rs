//! Cubics in Bernstein form: the arithmetic that curves, certificates and the search for crossings share.
//!
//! A cubic of a parameter s from 0 to 1 is given by its coefficients b₀ to b₃ (control points), in the unit of its
//! values. It is b₀ at 0 and b₃ at 1, and its values between are within the range of the coefficients (convex hull).
//! The algorithms are de Casteljau's: [Farin2002](crate#references), chapters 4 to 6.

use crate::Scalar;

/// Returns the coefficients of the cubic with values `p` and derivatives `m` by s at 0 and 1 (Hermite form).
pub fn hermite<T: Scalar>(p: [T; 2], m: [T; 2]) -> [T; 4] {
    let third = T::one() / (T::TWO + T::one());
    [p[0], p[0] + m[0] * third, p[1] - m[1] * third, p[1]]
}

/// Returns the value at `s`.
///
/// Each of the three levels of de Casteljau's algorithm errs by one rounding of the larger coefficient and two of the
/// difference of two coefficients.
pub fn value<T: Scalar>(b: &[T; 4], s: T) -> T {
    blossom(b, [s, s, s])
}

/// Returns the value and the first two derivatives by s at `s`.
pub fn jet<T: Scalar>([a, b, c, d]: &[T; 4], s: T) -> [T; 3] {
    let mix = |a: T, b: T| a + (b - a) * s;
    let (ab, bc, cd) = (mix(*a, *b), mix(*b, *c), mix(*c, *d));
    let (abc, bcd) = (mix(ab, bc), mix(bc, cd));
    let three = T::TWO + T::one();
    [
        mix(abc, bcd),
        three * (bcd - abc),
        three * T::TWO * (cd - bc - (bc - ab)),
    ]
}

/// Returns the polar form (blossom): affine in each argument, and the cubic where all arguments are equal.
fn blossom<T: Scalar>([a, b, c, d]: &[T; 4], [r, s, t]: [T; 3]) -> T {
    let mix = |a: T, b: T, s: T| a + (b - a) * s;
    let (ab, bc, cd) = (mix(*a, *b, r), mix(*b, *c, r), mix(*c, *d, r));
    mix(mix(ab, bc, s), mix(bc, cd, s), t)
}

/// Returns the coefficients of the part `from..to` of the cubic, with a parameter from 0 to 1 of its own.
pub fn restrict<T: Scalar>(b: &[T; 4], [from, to]: [T; 2]) -> [T; 4] {
    let arguments = [
        [from, from, from],
        [from, from, to],
        [from, to, to],
        [to, to, to],
    ];
    arguments.map(|arguments| blossom(b, arguments))
}

/// Returns the coefficients of both halves of the cubic. The mean of two coefficients rounds once, unlike [`restrict`].
pub fn halves<T: Scalar>([a, b, c, d]: &[T; 4]) -> [[T; 4]; 2] {
    let mean = |a: T, b: T| (a + b) / T::TWO;
    let (ab, bc, cd) = (mean(*a, *b), mean(*b, *c), mean(*c, *d));
    let (abc, bcd) = (mean(ab, bc), mean(bc, cd));
    let middle = mean(abc, bcd);
    [[*a, ab, abc, middle], [middle, bcd, cd, *d]]
}

/// Returns the differences of neighbouring coefficients: a third of the coefficients of the derivative by s, which is a
/// quadratic.
pub fn differences<T: Scalar>([a, b, c, d]: &[T; 4]) -> [T; 3] {
    [*b - *a, *c - *b, *d - *c]
}

/// Returns the largest absolute coefficient, of a polynomial of any degree: a bound on its absolute value.
pub fn max_coefficient<T: Scalar>(b: &[T]) -> T {
    b.iter().fold(T::zero(), |most, b| b.abs().max(most))
}

/// Returns the largest absolute difference of neighbouring coefficients, of a polynomial of any degree n: a bound on its
/// absolute derivative by s over n.
pub fn max_difference<T: Scalar>(b: &[T]) -> T {
    let pairs = b.iter().zip(b.iter().skip(1));
    pairs.fold(T::zero(), |most, (&a, &b)| most.max((b - a).abs()))
}
