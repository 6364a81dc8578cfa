//! Bounds an analytic function over an interval by its values at Chebyshev points.
//!
//! A polynomial p of degree n has |p| ≤ max |p(x_j)| / cos(nπ/2m) over -1..1 for the m + 1 points x_j = cos(jπ/m),
//! m > n [EhlichZeller1964](crate#references): a trigonometric polynomial of degree n falls off from its largest value
//! no faster than cos nθ does, and no θ is farther than π/2m from a point.
//!
//! A function f with |f| ≤ M inside the Bernstein ellipse of radius ρ differs from such a polynomial by at most
//! E = 2 M ρ^-n / (ρ - 1) ([Trefethen2013](crate#references), theorem 8.2), so that
//! |f| ≤ (max |f(x_j)| + E) / cos(nπ/2m) + E. Both bounds hold for the component of a vector along any direction, and
//! so for the norm of the vector.

/// Number of Bernstein ellipses that are tried.
pub(super) const RADII: usize = 14;

/// Numbers of intervals between the points, fewest first.
const INTERVALS: [u8; 6] = [8, 12, 16, 24, 32, 48];
/// Divisors of the number of intervals that give the degree: a lower degree has a larger error E of the polynomial and
/// a smaller factor 1 / cos(nπ/2m).
const PARTS: [u8; 5] = [2, 3, 4, 6, 8];
/// Factor on each bound that covers the rounding of the points and of the bound itself, which are far below it: points
/// are off by 1e-16, and no closer to each other than 1e-3 of an interval that is no shorter than 1e-3.
const INFLATION_FACTOR: f64 = 1.0 + 1e-8;

/// A Bernstein ellipse of radius ρ.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Radius {
    /// ln ρ.
    log: f64,
    /// ln(ρ - 1).
    log_less_one: f64,
    /// (ρ^k + ρ^-k) / 2 for k from 1 to 3.
    pub(super) cosh: [f64; 3],
    /// (ρ^k - ρ^-k) / 2 for k from 1 to 3.
    pub(super) sinh: [f64; 3],
}

/// Returns the ellipses, each of twice the radius of the one before, from ρ = 2.
pub(super) fn radii() -> [Radius; RADII] {
    let mut rho = 1.0_f64;
    [(); RADII].map(|()| {
        rho *= 2.0;
        let powers = [rho, rho * rho, rho * rho * rho];
        Radius {
            log: rho.ln(),
            log_less_one: (rho - 1.0).ln(),
            cosh: powers.map(|p| (p + 1.0 / p) / 2.0),
            sinh: powers.map(|p| (p - 1.0 / p) / 2.0),
        }
    })
}

/// Chebyshev points for one number of intervals, with the degrees of polynomials that they serve.
#[derive(Clone, Debug)]
pub(super) struct Points {
    /// Points, in 0..1.
    pub(super) at: Vec<f64>,
    /// Degree n and 1 / cos(nπ/2m), for each divisor.
    degrees: [(f64, f64); PARTS.len()],
}

impl Points {
    /// Returns the sets of points for all numbers of intervals, fewest points first.
    pub(super) fn all() -> [Self; INTERVALS.len()] {
        INTERVALS.map(|m| {
            let quarter = core::f64::consts::FRAC_PI_2 / f64::from(m);
            Self {
                at: (0..=m)
                    .map(|j| (f64::from(j) * quarter).sin().powi(2))
                    .collect(),
                degrees: PARTS.map(|part| {
                    let degree = f64::from(m / part);
                    (degree, 1.0 / (degree * quarter).cos())
                }),
            }
        })
    }

    /// Returns the error of the polynomial of the highest degree that these points serve.
    pub(super) fn error(&self, radii: &[Radius; RADII], growth: &[f64; RADII]) -> f64 {
        error(radii, growth, self.degrees[0].0)
    }

    /// Returns a bound over the interval on a function whose values at the points are at most `largest`.
    pub(super) fn bound(
        &self,
        radii: &[Radius; RADII],
        growth: &[f64; RADII],
        largest: f64,
    ) -> f64 {
        let bounds = self.degrees.iter().map(|&(degree, quotient)| {
            let error = error(radii, growth, degree);
            ((largest + error) * quotient + error) * INFLATION_FACTOR
        });
        // `min` passes over a NaN, which is no bound.
        bounds.fold(f64::INFINITY, f64::min)
    }
}

/// Returns the least error E over the ellipses for a polynomial of this degree; `growth` is ln M for each ellipse.
fn error(radii: &[Radius; RADII], growth: &[f64; RADII], degree: f64) -> f64 {
    let each = radii.iter().zip(growth);
    let logs = each.map(|(rho, growth)| growth - degree * rho.log - rho.log_less_one);
    2.0 * logs.fold(f64::INFINITY, f64::min).exp()
}
