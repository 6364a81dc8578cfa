//! Fits powers to measurements.

/// Returns slope and intercept of the least-squares line of ln y over ln x.
#[must_use]
pub(super) fn exponent(points: &[(f64, f64)]) -> (f64, f64) {
    let sum = |term: fn(f64, f64) -> f64| -> f64 {
        let terms = points.iter().map(|(x, y)| term(x.ln(), y.ln()));
        terms.sum()
    };
    let n = sum(|_, _| 1.0);
    let (x, y) = (sum(|x, _| x), sum(|_, y| y));
    let slope = (n * sum(|x, y| x * y) - x * y) / (n * sum(|x, _| x * x) - x * x);
    (slope, (y - slope * x) / n)
}

#[cfg(test)]
mod tests {
    #[test]
    fn a_power_is_found() {
        let points = [2.0_f64, 5.0, 30.0].map(|x| (x, 3.0 * x.powf(1.5)));
        let (slope, height) = super::exponent(&points);
        assert!((slope - 1.5).abs() < 1e-12 && (height - 3_f64.ln()).abs() < 1e-12);
    }
}
