//! Skew: how far apart in time may the parts of a sheet be that are driven by clocks of their own?
//!
//! If each hinge of a vertex is up to half of the skew Δ ahead of or behind the time of the path, the closure residual there is
//! Δ |Σ ± aᵢ ωᵢ| / 2 at most to first order, with the columns aᵢ of the Jacobian, the rates ωᵢ of the hinges, and the worst
//! signs. The amplification of the sheet makes a deformation or gap of it.

use core::time::Duration;

use nalgebra::Vector3;

use super::Conditions;
use crate::folding::{DEFAULT_BOUND, STEP};
use crate::motion::Motion;
use crate::pattern::CreasePattern;
use crate::util::nan_max::largest;
use crate::util::parallel;

/// Largest number of hinges in a condition of which all signs are tried; for more the norms are added up.
const MAX_SIGNED: usize = 12;

/// Returns the largest closure residual that a skew makes along a motion at its own speed, over the skew: 1 a second. `None` if
/// the sheet has too many creases.
///
/// Cost: the Jacobian at the knots and between them, about every 0.1 radians of the hinge that turns most.
#[must_use]
pub fn skew_residual(motion: &Motion) -> Option<f64> {
    let conditions = Conditions::new(&motion.pattern)?;
    let members = motion.memberships();
    let moments = motion.with_steps(STEP);
    let numbers: Vec<usize> = (0..moments.knots.len()).collect();
    let worst = parallel::map(&numbers, Duration::from_millis(1), |&moment| {
        let by_groups = motion.rates(moments.knots[moment].time);
        let rate = |crease: u32| by_groups[members[crease as usize].group.index()].abs();
        let at = conditions.at(&moments.crease_angles(moment))?;
        let rates = at.by_angle.iter().map(|columns| {
            let columns = columns
                .iter()
                .map(|(crease, column)| column * rate(*crease));
            worst_signs(&columns.collect::<Vec<_>>())
        });
        Some(largest(rates))
    });
    let worst: Option<Vec<f64>> = worst.into_iter().collect();
    Some(largest(worst?) / 2.0)
}

/// Returns a bound on [`skew_residual`] of every motion of a sheet whose hinges turn by up to `speed`, radians per second: the
/// columns of a vertex have length 1. `None` for sheets with holes, whose columns have any length.
#[must_use]
pub fn skew_residual_of_sheet(pattern: &CreasePattern, speed: f64) -> Option<f64> {
    let hinges = pattern.real_vertices().map(|vertex| {
        let star = pattern.stars()[vertex.index()].iter();
        star.filter(|&&edge| pattern.edge(edge).crease.is_some())
            .count()
    });
    #[allow(clippy::cast_precision_loss, reason = "the hinges of a vertex")]
    let most = hinges.max().unwrap_or(0) as f64;
    pattern.holes().is_empty().then_some(most * speed / 2.0)
}

/// Returns the skew (seconds) up to which deformation and gap stay within [`DEFAULT_BOUND`], of the residual over the skew and
/// the amplification of the sheet; `None` if no skew matters.
#[must_use]
pub fn skew_bound(residual: f64, amplification: f64) -> Option<f64> {
    let skew = DEFAULT_BOUND / (amplification * residual);
    skew.is_finite().then_some(skew)
}

/// Returns the largest norm of a sum of vectors with any signs.
fn worst_signs(vectors: &[Vector3<f64>]) -> f64 {
    let [first, others @ ..] = vectors else {
        return 0.0;
    };
    if vectors.len() > MAX_SIGNED {
        return vectors.iter().map(Vector3::norm).sum();
    }
    let sums = (0..1_u32 << others.len()).map(|signs| {
        let signed = others.iter().enumerate();
        let sum = signed.fold(*first, |sum, (k, vector)| match signs >> k & 1 {
            0 => sum + vector,
            _ => sum - vector,
        });
        sum.norm()
    });
    largest(sums)
}

#[cfg(test)]
mod tests {
    use super::worst_signs;
    use nalgebra::Vector3;

    #[test]
    fn signs_are_the_worst() {
        let [x, y] = [Vector3::x(), Vector3::y()];
        assert!((worst_signs(&[x, -x, y, y]) - 8_f64.sqrt()).abs() < 1e-15);
        assert!((worst_signs(&vec![x; 20]) - 20.0).abs() < 1e-12);
        assert!(worst_signs(&[]) <= 0.0);
    }
}
