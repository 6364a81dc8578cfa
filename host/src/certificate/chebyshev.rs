//! The largest value of an analytic function over an interval, from its values at Chebyshev points.
//!
//! A polynomial p of degree n has |p| ≤ max |p(x_j)| / cos(nπ/2m) over -1..1 for the m + 1 points
//! x_j = cos(jπ/m), m > n [EhlichZeller1964](crate#references): a trigonometric polynomial of degree n falls off
//! from its largest value no faster than cos nθ does, and no θ is farther than π/2m from a point.
//!
//! A function f with |f| ≤ M inside the Bernstein ellipse of radius ρ is such a polynomial but for
//! E = 2 M ρ^-n / (ρ - 1) ([Trefethen2013](crate#references), theorem 8.2), so
//! that |f| ≤ (max |f(x_j)| + E) / cos(nπ/2m) + E. Both hold for every component along a direction of
//! a vector, and so for its norm.

/// Number of Bernstein ellipses that are tried.
pub(super) const RADII: usize = 14;

/// Numbers of intervals between the points.
const INTERVALS: [u8; 6] = [8, 12, 16, 24, 32, 48];
/// Of these parts of the intervals one is the degree: the error of the polynomial against the quotient.
const PARTS: [u8; 5] = [2, 3, 4, 6, 8];
/// Roundings of the points, and of the bound itself, are far below: points are off by 1e-16, and no
/// closer to each other than 1e-3 of an interval that is no shorter than 1e-3.
const INFLATION: f64 = 1.0 + 1e-8;

/// A Bernstein ellipse of radius ρ.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Radius {
    /// ln ρ and ln(ρ - 1).
    log: f64,
    log_less_one: f64,
    /// (ρ^k + ρ^-k) / 2 for k from 1 to 3.
    pub(super) cosh: [f64; 3],
    /// (ρ^k - ρ^-k) / 2 for k from 1 to 3.
    pub(super) sinh: [f64; 3],
}

/// The ellipses: each of twice the radius of the one before.
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

/// Chebyshev points of one number.
#[derive(Clone, Debug)]
pub(super) struct Points {
    /// In 0..1.
    pub(super) at: Vec<f64>,
    /// Degrees, and 1 / cos(nπ/2m) for each.
    degrees: [(f64, f64); PARTS.len()],
}

impl Points {
    /// All that are used, fewest first.
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

    /// Error of the polynomial of the highest degree that these points serve.
    pub(super) fn error(&self, radii: &[Radius; RADII], growth: &[f64; RADII]) -> f64 {
        error(radii, growth, self.degrees[0].0)
    }

    /// Bound on a function over the interval whose values at the points are at most `largest`.
    pub(super) fn bound(
        &self,
        radii: &[Radius; RADII],
        growth: &[f64; RADII],
        largest: f64,
    ) -> f64 {
        let bounds = self.degrees.iter().map(|&(degree, quotient)| {
            let error = error(radii, growth, degree);
            ((largest + error) * quotient + error) * INFLATION
        });
        // A bound that is no number is none, whichever of them it is.
        bounds.fold(f64::INFINITY, f64::min)
    }
}

/// Least error of a polynomial of this degree, over the ellipses; `growth` is ln M for each.
fn error(radii: &[Radius; RADII], growth: &[f64; RADII], degree: f64) -> f64 {
    let each = radii.iter().zip(growth);
    let logs = each.map(|(rho, growth)| growth - degree * rho.log - rho.log_less_one);
    2.0 * logs.fold(f64::INFINITY, f64::min).exp()
}
