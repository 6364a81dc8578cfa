//! Finds intervals of time outside of which a polynomial keeps its sign, by Descartes' rule of signs.

use core::ops::RangeInclusive;

use num_bigint::{BigInt, Sign};

use super::polynomial::{Number as _, Polynomial, Rounded};

/// Number of halvings of the time from 0 to 1 after which an interval may contain a root.
pub(super) const HALVINGS: u32 = 40;

/// Returns `true` if rounded coefficients show that a polynomial has no root from 0 to 1.
pub(super) fn keeps_sign(polynomial: &Polynomial<Rounded>) -> bool {
    let first = polynomial.0[0].sign();
    first.is_some() && polynomial.0.iter().all(|a| a.sign() == first)
}

/// Adds the intervals that contain all roots of a polynomial from 0 to 1, in units of 2^-`HALVINGS`. Each is at most one
/// unit wide. A polynomial that is zero everywhere has none.
///
/// A polynomial has no more roots between 0 and 1 than its coefficients change their sign, by Descartes' rule for
/// t / (1 - t). Intervals with a change are halved.
pub(super) fn add_roots(polynomial: &Polynomial<BigInt>, found: &mut Vec<RangeInclusive<i64>>) {
    if polynomial.0.iter().any(|a| a.sign() != Sign::NoSign) {
        halve(&polynomial.0, 0, 1 << HALVINGS, found);
    }
}

fn halve(coefficients: &[BigInt], from: i64, width: i64, found: &mut Vec<RangeInclusive<i64>>) {
    let (first, last) = (coefficients.first(), coefficients.last());
    let is_root = |end: Option<&BigInt>| end.is_some_and(|a| a.sign() == Sign::NoSign);
    if is_root(first) {
        found.push(from..=from);
    }
    if is_root(last) {
        found.push(from + width..=from + width);
    }
    let signs = coefficients.iter().map(BigInt::sign);
    let mut signs = signs.filter(|&sign| sign != Sign::NoSign);
    let first = signs.next();
    if signs.all(|sign| Some(sign) == first) {
        return;
    }
    if width == 1 {
        found.push(from..=from + width);
        return;
    }
    // With t = t' / 2 and everything doubled, 1 - t is 2 (1 - t') + t'. The other half is the same from its end.
    let left = half(coefficients.iter());
    let mut right = half(coefficients.iter().rev());
    right.reverse();
    halve(&left, from, width / 2, found);
    halve(&right, from + width / 2, width / 2, found);
}

/// Returns the coefficients in (x, y) of a polynomial in (2x + y, y).
fn half<'a>(coefficients: impl DoubleEndedIterator<Item = &'a BigInt>) -> Vec<BigInt> {
    // Horner's rule: multiplies by 2x + y, and adds the next coefficient times a power of y.
    let mut sum: Vec<BigInt> = Vec::new();
    for a in coefficients {
        let mut next = vec![BigInt::of(0); sum.len() + 1];
        for (k, term) in sum.iter().enumerate() {
            next[k] += term << 1;
            next[k + 1] += term;
        }
        if let Some(end) = next.last_mut() {
            *end += a;
        }
        sum = next;
    }
    sum
}
