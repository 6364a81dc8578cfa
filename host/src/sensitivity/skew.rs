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
    use super::{skew_bound, skew_residual, skew_residual_of_sheet, worst_signs};
    use crate::generate::{Miura, Waterbomb};
    use crate::motion::Motion;
    use crate::pattern::{CreasePattern, Drawing};
    use crate::planner::{Goal, PlanOptions, plan};
    use nalgebra::Vector3;

    fn planned(drawing: Drawing) -> Motion {
        let pattern = CreasePattern::new(drawing).unwrap();
        let goal = Goal::of_pattern(&pattern).unwrap();
        let options = PlanOptions::default().with(|it| it.max_speed = 1.0);
        plan(&pattern, &goal, &options).motion.unwrap()
    }

    #[test]
    fn signs_are_the_worst() {
        let [x, y] = [Vector3::x(), Vector3::y()];
        assert!((worst_signs(&[x, -x, y, y]) - 8_f64.sqrt()).abs() < 1e-15);
        assert!((worst_signs(&vec![x; 20]) - 20.0).abs() < 1e-12);
        assert!(worst_signs(&[]) <= 0.0);
    }

    /// Figures of a second program, which tries all signs at 60 times with Jacobians in Python.
    #[test]
    fn a_miura_has_the_residual_of_its_axes() {
        let g = 60_f64.to_radians();
        for (fold, expected) in [(0.5, 1.256_733), (0.9, 1.337_977)] {
            let miura = Miura {
                rows: 2,
                columns: 2,
                sector_angle: g,
                fold,
            };
            let motion = planned(miura.drawing().unwrap());
            let found = skew_residual(&motion).unwrap();
            assert!((found - expected).abs() < 1e-3, "{found} {expected}");
            let bound = skew_residual_of_sheet(&motion.pattern, 1.0).unwrap();
            assert!((bound - 2.0).abs() < 1e-15 && found <= bound + 1e-9);
            // Twice as fast is half the skew.
            let mut fast = motion.clone();
            for knot in &mut fast.knots {
                knot.time /= 2.0;
                knot.rates.iter_mut().for_each(|rate| *rate *= 2.0);
                knot.weights.iter_mut().for_each(|[_, rate]| *rate *= 2.0);
            }
            let twice = skew_residual(&fast).unwrap();
            assert!((twice / found - 2.0).abs() < 1e-9, "{twice} {found}");
        }
    }

    #[test]
    fn a_waterbomb_bears_less_than_its_degrees_allow() {
        let waterbomb = Waterbomb {
            rows: 4,
            columns: 6,
            fold: 0.5,
        };
        let motion = planned(waterbomb.drawing().unwrap());
        let found = skew_residual(&motion).unwrap();
        let bound = skew_residual_of_sheet(&motion.pattern, 1.0).unwrap();
        assert!((bound - 3.0).abs() < 1e-15 && found <= bound, "{found}");
        assert!((found - 1.3208).abs() < 5e-3, "{found}");
        assert!((skew_bound(2.0, 50.0).unwrap() - 1e-4).abs() < 1e-18);
        assert_eq!(skew_bound(0.0, 50.0), None);
    }
}
