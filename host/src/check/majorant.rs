//! Bounds all derivatives of a fold angle over an interval, and those of a product of turns by such angles, by
//! Cauchy's method of majorants.
//!
//! A series h bounds a function f on an interval of half width δ if |f⁽ʲ⁾(s)| δʲ / j! ≤ hⱼ for every s of the
//! interval and every j: around each s, the Taylor coefficients of f, in units of δ, are no larger than those
//! of h (h is a *majorant*, as Cauchy used them). Sums, products and quotients of functions are bounded by
//! those of their series. A turn by ρ about a unit axis is exp(ρA) with ‖A‖ = 1, and exp(ρ(s + t) A) = exp(ρ(s)
//! A) exp((ρ(s + t) - ρ(s)) A), where the first factor has norm 1. So a product of turns is bounded by exp(Σ
//! hᵢ(t) - hᵢ(0)) in the operator norm.

use foldpath_core::Curve;

use super::count;

/// Highest order of the derivatives that are bounded.
pub(super) const MAX_ORDER: usize = 20;

/// Coefficients of a majorant from order 0. The coefficient of order 0 is not used, and 0.
pub(super) type Series = [f64; MAX_ORDER + 1];

/// Returns the majorant of the fold angle on the interval about `middle` of half width `half`. Infinite if the
/// bounds do not exclude that the pair (c, n) of a half angle vanishes in the interval.
pub(super) fn of_angle(curve: &Curve<f64>, middle: f64, half: f64) -> Series {
    let mut series = [0.0; MAX_ORDER + 1];
    match curve {
        Curve::Angle(angle) => {
            let bounds = reach(taylor(angle, middle, half).map(f64::abs));
            series[1..4].copy_from_slice(&bounds[1..]);
        }
        Curve::HalfAngle { cos, sin } => {
            // ρ is twice the imaginary part of log z, z = c + i n, and log (1 + w) is bounded by -log (1 - w).
            let (c, n) = (taylor(cos, middle, half), taylor(sin, middle, half));
            let z: [f64; 4] = core::array::from_fn(|k| c[k].hypot(n[k]));
            let bounds = reach(z);
            let least = 2.0 * z[0] - bounds[0];
            let w = bounds.map(|bound| {
                if least > 0.0 {
                    bound / least
                } else {
                    f64::INFINITY
                }
            });
            // Coefficients of the derivative, w' / (1 - w).
            let mut rate = [0.0; MAX_ORDER];
            for (j, order) in (0..MAX_ORDER).zip((1..=MAX_ORDER).map(count)) {
                let own = w.get(j + 1).map_or(0.0, |w| order * w);
                rate[j] = own + (1..=j.min(3)).map(|k| w[k] * rate[j - k]).sum::<f64>();
                series[j + 1] = 2.0 * rate[j] / order;
            }
        }
    }
    series
}

/// Returns exp of a series without its coefficient of order 0.
pub(super) fn exponential(h: &Series) -> Series {
    let mut g = [0.0; MAX_ORDER + 1];
    g[0] = 1.0;
    for n in 1..=MAX_ORDER {
        let terms = (1..=n).map(|k| count(k) * h[k] * g[n - k]);
        g[n] = terms.sum::<f64>() / count(n);
    }
    g
}

/// Returns the Taylor coefficients at `middle`, in units of `half`, of a cubic with these Bernstein
/// coefficients.
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

/// Returns the majorant on [-1, 1] of a cubic with Taylor coefficients at 0 of these absolute values: Σ over k
/// of (k over j) |aₖ|.
fn reach(mut shifted: [f64; 4]) -> [f64; 4] {
    for from in 0..4 {
        for k in (from..3).rev() {
            shifted[k] += shifted[k + 1];
        }
    }
    shifted
}
