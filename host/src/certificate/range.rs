//! Bounds on a fold angle and on its rate over a segment, from the control points of its parts (subdivision).

use foldpath_core::Curve;
use foldpath_core::bernstein::restrict;

use super::Part;
use super::bernstein::{least, lost, sizes};

/// Distance of a bound from an attained value that is near enough, in radians or as a fraction of the largest
/// coefficient.
const TIGHT_RAD: f64 = 1e-12;
/// Largest number of halvings: parts are no shorter than 2^-24 of the segment. Bounds converge with the square of the
/// length.
const MAX_RANGE_HALVINGS: u8 = 24;
/// Largest number of parts looked at: a few for each halving and each extreme are enough for any sound curve.
const MAX_PARTS: usize = 512;
/// Number of equal parts of a segment over which rates are bounded one by one.
const RATE_PARTS: u8 = 8;

/// Returns bounds on the fold angle (radians) over the segment, 1e-12 from its least and its largest value, and equal
/// to these if they are at the ends. The bounds are infinite if the curve is not finite.
#[must_use]
pub fn range(curve: &Curve<f64>) -> [f64; 2] {
    let ends = [curve.angle(0.0), curve.angle(1.0)];
    let mut seen = [ends[0].min(ends[1]), ends[0].max(ends[1])];
    let mut range = seen;
    let mut open = vec![Part::default()];
    let mut budget = MAX_PARTS;
    while let Some(part) = open.pop() {
        let [from, to] = part.ends();
        let Some((hull, near)) = hull(curve, [from, to]) else {
            return [f64::NEG_INFINITY, f64::INFINITY];
        };
        if hull[0] >= seen[0] && hull[1] <= seen[1] {
            continue;
        }
        budget = budget.saturating_sub(1);
        let tight = hull[0] >= seen[0] - near && hull[1] <= seen[1] + near;
        if tight || part.depth == MAX_RANGE_HALVINGS || budget == 0 {
            range = [range[0].min(hull[0] - near), range[1].max(hull[1] + near)];
        } else {
            let middle = curve.angle((from + to) / 2.0);
            seen = [seen[0].min(middle), seen[1].max(middle)];
            open.extend(part.halves());
        }
    }
    [range[0].min(seen[0]), range[1].max(seen[1])]
}

/// Returns the least and the largest angle of the control points over a part, and the distance from attained values
/// that is near enough; `None` if they are not finite.
fn hull(curve: &Curve<f64>, part: [f64; 2]) -> Option<([f64; 2], f64)> {
    let (angles, near) = match curve {
        Curve::Angle(angle) => (restrict(angle, part), TIGHT_RAD * (1.0 + sizes(angle)[0])),
        Curve::HalfAngle { cos, sin } => {
            let (cos, sin) = (restrict(cos, part), restrict(sin, part));
            if cos.iter().any(|c| *c < 0.0) {
                // With control points on both sides of the pole no angle is excluded.
                let all = 2.0 * core::f64::consts::PI;
                ([-all, all, -all, all], TIGHT_RAD)
            } else {
                let angle = |k: usize| 2.0 * sin[k].atan2(cos[k]);
                (
                    [0, 1, 2, 3].map(angle),
                    TIGHT_RAD * (1.0 + core::f64::consts::PI),
                )
            }
        }
    };
    let finite = angles.iter().all(|angle| angle.is_finite());
    let low = angles.iter().copied().fold(f64::INFINITY, f64::min);
    let high = angles.iter().copied().fold(f64::NEG_INFINITY, f64::max);
    finite.then_some(([low, high], near))
}

/// Returns a bound on |dρ/ds| (radians) over the segment; infinite if the curve is not finite or its weights vanish.
#[must_use]
pub fn rate(curve: &Curve<f64>) -> f64 {
    let parts = (0..RATE_PARTS)
        .map(|index| [index, index + 1].map(|k| f64::from(k) / f64::from(RATE_PARTS)));
    let rates = parts.map(|part| rate_over(curve, part) * f64::from(RATE_PARTS));
    let worst = rates.fold(
        0.0,
        |worst: f64, rate| {
            if rate <= worst { worst } else { rate }
        },
    );
    if worst.is_finite() {
        worst
    } else {
        f64::INFINITY
    }
}

/// Returns a bound on the derivative by a parameter that runs from 0 to 1 over the part.
fn rate_over(curve: &Curve<f64>, part: [f64; 2]) -> f64 {
    match curve {
        Curve::Angle(angle) => {
            let [size, _] = sizes(angle);
            3.0 * (sizes(&restrict(angle, part))[1] + lost(size))
        }
        Curve::HalfAngle { cos, sin } => {
            let size = sizes(cos)[0].hypot(sizes(sin)[0]);
            let (cos, sin) = (restrict(cos, part), restrict(sin, part));
            let least = least(&cos, &sin) - lost(size);
            if least <= 0.0 || least.is_nan() {
                return f64::INFINITY;
            }
            // Bernstein coefficients of (c n' - n c') / 3, times the binomials of degree 5.
            let mut turn = [0.0_f64; 6];
            for (i, chosen) in [1.0, 3.0, 3.0, 1.0].into_iter().enumerate() {
                for (j, of_two) in [1.0, 2.0, 1.0].into_iter().enumerate() {
                    let cross = cos[i] * (sin[j + 1] - sin[j]) - sin[i] * (cos[j + 1] - cos[j]);
                    turn[i + j] += chosen * of_two * cross;
                }
            }
            let binomials = [1.0, 5.0, 10.0, 10.0, 5.0, 1.0];
            let turn = turn.iter().zip(binomials).map(|(t, b)| t.abs() / b);
            let turn = turn.fold(0.0, f64::max) + 4.0 * size * lost(size);
            6.0 * turn / (least * least)
        }
    }
}
