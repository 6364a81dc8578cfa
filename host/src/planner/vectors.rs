//! Norms, cosines and differences of vectors of angles.

/// Returns the vector of length 1 in the direction of `x`.
pub(super) fn unit(x: &[f64]) -> Vec<f64> {
    let length = norm(x).max(f64::MIN_POSITIVE);
    x.iter().map(|a| a / length).collect()
}

/// Returns the inner product of two vectors.
pub(super) fn dot(x: &[f64], y: &[f64]) -> f64 {
    x.iter().zip(y).map(|(a, b)| a * b).sum()
}

/// Adds `factor` times a vector to another one.
pub(super) fn add_scaled(sum: &mut [f64], factor: f64, x: &[f64]) {
    sum.iter_mut()
        .zip(x)
        .for_each(|(sum, x)| *sum += factor * x);
}

/// Returns the Euclidean norm.
pub(super) fn norm(x: &[f64]) -> f64 {
    dot(x, x).sqrt()
}

/// Returns the cosine of the angle between two vectors.
pub(super) fn cosine(x: &[f64], y: &[f64]) -> f64 {
    dot(x, y) / (norm(x) * norm(y))
}

/// Returns the largest absolute entry.
pub(super) fn max_norm(x: &[f64]) -> f64 {
    x.iter().fold(0.0, |max, a| f64::max(max, a.abs()))
}

/// Returns the largest absolute difference of two entries in the same place.
pub(super) fn max_difference(x: &[f64], y: &[f64]) -> f64 {
    x.iter()
        .zip(y)
        .fold(0.0, |max, (a, b)| f64::max(max, (a - b).abs()))
}

/// Returns the largest absolute angle asked for.
pub(super) fn largest(asked: &[Option<f64>]) -> f64 {
    let angles = asked.iter().flatten();
    angles.fold(0.0, |max, a| f64::max(max, a.abs()))
}

/// Returns the fraction of the angles asked for that `angles` have, 0 to 1; free ones do not count.
pub(super) fn fraction(asked: &[Option<f64>], angles: &[f64]) -> f64 {
    let pairs = asked.iter().zip(angles);
    let (dot, square) = pairs.fold((0.0, 0.0), |(dot, square), (asked, angle)| {
        let asked = asked.unwrap_or(0.0);
        (dot + asked * angle, square + asked * asked)
    });
    if square > 0.0 {
        (dot / square).clamp(0.0, 1.0)
    } else {
        0.0
    }
}

/// Returns the difference from `angles` to the angles asked for, and 0 for free ones.
pub(super) fn way_to(asked: &[Option<f64>], angles: &[f64]) -> Vec<f64> {
    let pairs = asked.iter().zip(angles);
    pairs.map(|(t, a)| t.map_or(0.0, |t| t - a)).collect()
}
