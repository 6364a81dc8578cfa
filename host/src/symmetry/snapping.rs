//! Restores stars whose coordinates were rounded: sets of spokes that nearly fold flat are made to fold flat exactly.
//!
//! A set of spokes that all turn by half a turn, while the other spokes of the star stay flat, closes if the directions
//! (angles) of the set, taken with alternating signs, add up to a multiple of π. For two spokes this is a line that
//! passes straight; for all spokes of a star it is the condition of T. Kawasaki, "On the relation between
//! mountain-creases and valley-creases of a flat origami", 1989. Every condition that nearly holds is a linear equation
//! in the corrections of the directions. The equations do not contradict each other: their right-hand sides are
//! rounding errors, and no sum of a few rounding errors is a multiple of π. The least-squares solution of least norm
//! corrects all conditions at once.

use core::f64::consts::PI;

use foldpath_core::Spoke;
use nalgebra::{DMatrix, DVector};

/// Largest number of spokes of a star for which all even sets of spokes are examined.
const MAX_SPOKES: usize = 12;
/// Narrowest sector of a star that is corrected, in multiples of the tolerance `within`.
const NARROW_TOLERANCES: f64 = 4.0;
/// Error (radians) of a direction that comes from its representation in floating point alone.
const FLOAT_ERROR_RAD: f64 = 1e-15;
/// Fraction of the largest eigenvalue below which an eigenvalue counts as zero. The equations have integer
/// coefficients.
const RANK_RATIO: f64 = 1e-9;

/// Turns the spokes by least angles such that every set of spokes folds flat exactly that nearly does, with an error of
/// at most `within` (radians) for each two spokes. Returns the angle (radians) by which each spoke is turned. A star in
/// which two spokes nearly point the same way is left as it is.
pub(super) fn snap(spokes: &mut [Spoke<f64>], within: f64) -> Vec<f64> {
    let bearings: Vec<f64> = spokes.iter().map(bearing).collect();
    let n = bearings.len();
    let sector = |k: usize| bearings[if k + 1 < n { k + 1 } else { 0 }] - bearings[k];
    let narrow = |k: usize| sector(k).rem_euclid(2.0 * PI) <= NARROW_TOLERANCES * within;
    if n < 2 || (0..n).any(narrow) {
        return vec![0.0; n];
    }
    // The normal equations Aᵀ A δ = Aᵀ b of the conditions A δ = b.
    let (mut squares, mut right) = (DMatrix::zeros(n, n), DVector::zeros(n));
    for set in sets(n) {
        let signs = set.iter().zip([1.0, -1.0].into_iter().cycle());
        let sum: f64 = signs.clone().map(|(&k, sign)| sign * bearings[k]).sum();
        let off = sum - PI * (sum / PI).round();
        #[allow(clippy::cast_precision_loss, reason = "a few spokes")]
        let most = within * set.len() as f64 / 2.0;
        if off.abs() > most {
            continue;
        }
        for (&k, sign) in signs.clone() {
            right[k] -= sign * off;
            for (&l, other) in signs.clone() {
                squares[(k, l)] += sign * other;
            }
        }
    }
    let eigen = squares.symmetric_eigen();
    let least = RANK_RATIO * eigen.eigenvalues.amax();
    let mut turns = DVector::zeros(n);
    for (value, vector) in eigen
        .eigenvalues
        .iter()
        .zip(eigen.eigenvectors.column_iter())
    {
        if *value > least {
            turns.axpy(vector.dot(&right) / value, &vector, 1.0);
        }
    }
    if turns.amax() <= FLOAT_ERROR_RAD {
        return vec![0.0; n];
    }
    for ((spoke, bearing), turn) in spokes.iter_mut().zip(bearings).zip(turns.iter()) {
        let (sin, cos) = (bearing + turn).sin_cos();
        spoke.direction = [cos, sin];
    }
    // The rounding of the new direction adds to the turn.
    turns
        .iter()
        .map(|turn| turn.abs() + FLOAT_ERROR_RAD)
        .collect()
}

/// Returns the direction of a spoke as an angle, radians.
fn bearing(spoke: &Spoke<f64>) -> f64 {
    spoke.direction[1].atan2(spoke.direction[0])
}

/// Returns all sets of an even number of spokes, in cyclic order. For more than [`MAX_SPOKES`] spokes, returns only
/// the pairs and the set of all spokes.
fn sets(n: usize) -> Vec<Vec<usize>> {
    if n <= MAX_SPOKES {
        let even = (1..1_u32 << n).filter(|set| set.count_ones() % 2 == 0);
        return even
            .map(|set| (0..n).filter(|k| set >> k & 1 == 1).collect())
            .collect();
    }
    let pairs = (0..n).flat_map(|l| (0..l).map(move |k| vec![k, l]));
    let all = n.is_multiple_of(2).then(|| (0..n).collect());
    pairs.chain(all).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use foldpath_core::GroupId;

    /// Makes a star with these directions, degrees.
    fn star(bearings: &[f64]) -> Vec<Spoke<f64>> {
        let spoke = |bearing: &f64| {
            let (sin, cos) = bearing.to_radians().sin_cos();
            Spoke {
                group: GroupId(0),
                negative: false,
                direction: [cos, sin],
            }
        };
        bearings.iter().map(spoke).collect()
    }

    /// Returns the sets of spokes that fold flat to rounding.
    fn flat(spokes: &[Spoke<f64>]) -> Vec<Vec<usize>> {
        let closes = |set: &Vec<usize>| {
            let signs = set.iter().zip([1.0, -1.0].into_iter().cycle());
            let turns = signs.map(|(&k, sign)| sign * bearing(&spokes[k]));
            let sum = turns.sum::<f64>() / PI;
            (sum - sum.round()).abs() < 1e-14
        };
        sets(spokes.len()).into_iter().filter(closes).collect()
    }

    #[test]
    fn what_was_meant_to_fold_flat_does() {
        // A line that passes straight with two creases mirrored at it; a cross; a waterbomb; lines folded one after the
        // other.
        let meant: [&[f64]; 4] = [
            &[0.0, 50.0, 180.0, 310.0],
            &[10.0, 100.0, 190.0, 280.0],
            &[0.0, 45.0, 135.0, 180.0, 225.0, 315.0],
            &[0.0, 20.0, 65.0, 180.0, 295.0, 340.0],
        ];
        for (meant, scale) in meant
            .into_iter()
            .flat_map(|meant| [(meant, 1e-4), (meant, 1e-9)])
        {
            let off = [0.3, -0.5, 0.2, 0.9, -0.7, 0.4];
            let rounded = meant
                .iter()
                .zip(off)
                .map(|(meant, off)| meant + scale * off);
            let mut spokes = star(&rounded.collect::<Vec<_>>());
            assert_eq!(flat(&spokes), [[0; 0]; 0]);
            let turned = snap(&mut spokes, 1e-4);
            let turned = turned.into_iter().fold(0.0, f64::max).to_degrees();
            assert!(turned > 0.0 && turned <= scale, "{meant:?}: {turned:e}");
            assert!(!flat(&spokes).is_empty());
            assert_eq!(flat(&spokes), flat(&star(meant)), "{meant:?}");
        }
    }

    #[test]
    fn what_is_far_from_it_is_left_to_the_last_bit() {
        for bearings in [&[0.0, 50.0, 170.0, 300.0][..], &[0.0, 1e-4, 180.0, 270.0]] {
            let mut spokes = star(bearings);
            assert!(snap(&mut spokes, 1e-4).iter().all(|turn| *turn <= 0.0));
            let same = spokes.iter().zip(star(bearings));
            let bits = |spoke: &Spoke<f64>| spoke.direction.map(f64::to_bits);
            assert!(same.clone().all(|(a, b)| bits(a) == bits(&b)));
        }
    }
}
