//! Bounds on all derivatives of a fold angle over an interval, and of a product of turns by such angles.
//!
//! A series h bounds a function f on an interval of half width δ if |f⁽ʲ⁾(s)| δʲ / j! ≤ hⱼ there for
//! every j: around each s of the interval the Taylor coefficients of f are, in units of δ, no larger than
//! those of h (h is a *majorant*, as Cauchy used them). Sums, products and quotients of functions are
//! bounded by those of their series. A turn by ρ about a unit axis is exp(ρA) with ‖A‖ = 1, and
//! exp(ρ(s + t) A) = exp(ρ(s) A) exp((ρ(s + t) - ρ(s)) A), the first factor of norm 1: so a product of
//! turns is bounded by exp(Σ hᵢ(t) - hᵢ(0)) in the operator norm.

use foldpath_core::Curve;

/// Derivatives that are bounded.
pub(super) const ORDER: usize = 20;

/// Coefficients of a majorant from order 0. That of order 0 is not used, and 0.
pub(super) type Series = [f64; ORDER + 1];

/// Of the fold angle on the interval about `middle` of half width `half`. Infinite where the pair (c, n)
/// of a half angle may vanish in the interval, as far as bounds tell.
pub(super) fn of_angle(curve: &Curve<f64>, middle: f64, half: f64) -> Series {
    let mut series = [0.0; ORDER + 1];
    match curve {
        Curve::Angle(angle) => {
            let bounds = reach(taylor(angle, middle, half));
            series[1..4].copy_from_slice(&bounds[1..]);
        }
        Curve::HalfAngle { cos, sin } => {
            // dρ/dt = 2 (c n' - n c') / (c² + n²).
            let (c, n) = (taylor(cos, middle, half), taylor(sin, middle, half));
            let mut numerator = [0.0; 6];
            let mut square = [0.0; 7];
            for i in 0..4 {
                for (k, rank) in (0..4).zip([0.0, 1.0, 2.0, 3.0]) {
                    square[i + k] += c[i] * c[k] + n[i] * n[k];
                    if k > 0 {
                        numerator[i + k - 1] += 2.0 * rank * (c[i] * n[k] - n[i] * c[k]);
                    }
                }
            }
            let (p, q) = (reach(numerator), reach(square));
            let least = 2.0 * square[0] - q[0];
            let mut rate = [0.0; ORDER];
            for j in 0..ORDER {
                let later = (1..=j.min(6)).map(|k| q[k] * rate[j - k]);
                rate[j] = (p.get(j).unwrap_or(&0.0) + later.sum::<f64>()) / least;
            }
            let mut rank = 0.0;
            for (coefficient, rate) in series[1..].iter_mut().zip(rate) {
                rank += 1.0;
                *coefficient = if least > 0.0 {
                    rate / rank
                } else {
                    f64::INFINITY
                };
            }
        }
    }
    series
}

/// exp of a series without its coefficient of order 0.
pub(super) fn exponential(h: &Series) -> Series {
    let mut g = [0.0; ORDER + 1];
    g[0] = 1.0;
    let mut rank = 0.0;
    for n in 1..=ORDER {
        rank += 1.0;
        let mut sum = 0.0;
        let mut weight = 0.0;
        for k in 1..=n {
            weight += 1.0;
            sum += weight * h[k] * g[n - k];
        }
        g[n] = sum / rank;
    }
    g
}

/// Taylor coefficients at `middle`, in units of `half`, of a cubic with Bernstein coefficients `b`.
fn taylor([a, b, c, d]: &[f64; 4], middle: f64, half: f64) -> [f64; 4] {
    let mix = |a: f64, b: f64| a + (b - a) * middle;
    let (ab, bc, cd) = (mix(*a, *b), mix(*b, *c), mix(*c, *d));
    let (abc, bcd) = (mix(ab, bc), mix(bc, cd));
    [
        mix(abc, bcd),
        3.0 * (bcd - abc) * half,
        3.0 * (cd - 2.0 * bc + ab) * half.powi(2),
        (d - 3.0 * c + 3.0 * b - a) * half.powi(3),
    ]
}

/// The majorant on [-1, 1] of a polynomial with these Taylor coefficients at 0: Σ over k of (k over j) |aₖ|.
fn reach<const N: usize>(coefficients: [f64; N]) -> [f64; N] {
    let mut shifted = coefficients.map(f64::abs);
    for from in 0..N {
        for k in (from..N - 1).rev() {
            shifted[k] += shifted[k + 1];
        }
    }
    shifted
}
