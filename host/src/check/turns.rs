//! Checks the turns of hinges between knots: none may turn against its assignment (letter), or beyond half a turn.
//!
//! A curve is halved until its control points prove for each part that the fold angle stays in its range, or a place is
//! found where it does not. The angle of a cubic stays between those of its control points. The half angle of a curve
//! (c, n) stays in the cone of its control points, as long as they lie in an open half plane.

use core::f64::consts::PI;
use std::collections::{BTreeSet, HashSet};

use foldpath_core::Curve;

use super::finding::{Failure, Moment, Undecided, WrongTurn};
use super::{MergedGroups, SAME_ANGLE_RAD};
use crate::pattern::{CreasePattern, Letter};

/// Largest number of successive halvings: parts are no shorter than 2^-40 of the segment.
const MAX_HALVINGS: u32 = 40;
/// Largest number of parts of a curve that are looked at.
const MAX_PARTS: usize = 4096;
/// Rounding errors of a control point, in the roundings of the largest coefficient.
const ROUNDING_EPSILONS: f64 = 16.0;

/// Verdict on the turn of a hinge between two knots.
enum Turn {
    Right,
    /// The hinge is at a wrong angle at this place in the segment.
    Wrong(f64, WrongTurn),
    /// The control points decide nothing at this place, as the weights vanish.
    Unknown(f64),
}

/// Finds the first hinge that turns the wrong way between two knots. If there is none, returns the first place at which
/// the angle of a hinge is not known. Panels may bend by `bend` radians.
pub(super) fn wrong_turn(
    pattern: &CreasePattern,
    motion: &MergedGroups,
    bend: f64,
) -> (Option<Failure>, Option<Undecided>) {
    // Hinges that turn alike, with the same letter, are judged once. A group may have several letters.
    let creases = pattern.creases().iter().zip(motion.groups.memberships());
    let mut seen = HashSet::new();
    let hinges: Vec<_> = creases
        .map(|(&edge, &member)| (edge, pattern.edge(edge).letter, member))
        .filter(|(_, letter, member)| seen.insert((member.group, member.negative, *letter)))
        .collect();
    let mut unknown = None;
    for (segment, curves) in motion.segments.iter().enumerate() {
        for &(edge, letter, member) in &hinges {
            let curve = signed(curves[member.group.index()], member.negative);
            let most = if letter == Letter::Bend { bend } else { PI };
            match turn(&curve, letter, most) {
                Turn::Right => {}
                Turn::Wrong(s, wrong) => {
                    let failure = Failure::Turns {
                        at: Moment::Between { segment, s },
                        edge,
                        letter,
                        wrong,
                        value: curve.angle(s),
                    };
                    return (Some(failure), None);
                }
                Turn::Unknown(s) => {
                    let at = Moment::Between { segment, s };
                    unknown.get_or_insert(Undecided::Angle { at, edge });
                }
            }
        }
    }
    (None, unknown)
}

/// Returns the curve of a hinge that turns as its group does, or the opposite way.
fn signed(curve: Curve<f64>, negative: bool) -> Curve<f64> {
    match curve {
        Curve::Angle(angle) if negative => Curve::Angle(angle.map(|b| -b)),
        Curve::HalfAngle { cos, sin } if negative => Curve::HalfAngle {
            cos,
            sin: sin.map(|b| -b),
        },
        curve => curve,
    }
}

/// Returns the largest angle by which a panel bends, radians: the largest of 17 angles of each segment.
pub(super) fn largest_bend(pattern: &CreasePattern, motion: &MergedGroups) -> f64 {
    let creases = pattern.creases().iter().zip(motion.groups.memberships());
    let bends = creases.filter(|(edge, _)| pattern.edge(**edge).letter == Letter::Bend);
    let groups: BTreeSet<usize> = bends.map(|(_, member)| member.group.index()).collect();
    let curves = motion.segments.iter();
    let curves = curves.flat_map(|curves| groups.iter().map(|&group| &curves[group]));
    let angles = curves.flat_map(|curve| (0..=16).map(|k| curve.angle(f64::from(k) / 16.0).abs()));
    angles.fold(0.0, f64::max)
}

/// Returns what is wrong with a fold angle, which may be up to `most`.
fn wrong(angle: f64, letter: Letter, most: f64) -> Option<WrongTurn> {
    if angle * letter.sign() < -SAME_ANGLE_RAD {
        Some(WrongTurn::AgainstLetter)
    } else if most < PI && angle.abs() > most + SAME_ANGLE_RAD {
        Some(WrongTurn::BeyondBend)
    } else if angle.abs() > PI + SAME_ANGLE_RAD {
        Some(WrongTurn::BeyondHalfTurn)
    } else if angle.is_nan() {
        Some(WrongTurn::NotANumber)
    } else {
        None
    }
}

/// Judges the turn of a hinge with this letter over a segment; it may turn up to `most` radians.
fn turn(curve: &Curve<f64>, letter: Letter, most: f64) -> Turn {
    for s in [0.0, 1.0] {
        if let Some(wrong) = wrong(curve.angle(s), letter, most) {
            return Turn::Wrong(s, wrong);
        }
    }
    let size = match curve {
        Curve::Angle(angle) => largest(angle),
        Curve::HalfAngle { cos, sin } => largest(cos).max(largest(sin)),
    };
    let slack = ROUNDING_EPSILONS * f64::EPSILON * size;
    let mut open = vec![(*curve, [0.0, 1.0], 0)];
    let mut parts = 0;
    while let Some((part, [from, to], halvings)) = open.pop() {
        let ends = range(&part, slack);
        if ends.is_some_and(|ends| ends.iter().all(|&end| wrong(end, letter, most).is_none())) {
            continue;
        }
        let middle = f64::midpoint(from, to);
        if let Some(wrong) = wrong(curve.angle(middle), letter, most) {
            return Turn::Wrong(middle, wrong);
        }
        parts += 1;
        if halvings == MAX_HALVINGS || parts == MAX_PARTS {
            return Turn::Unknown(middle);
        }
        let [first, second] = halves(&part);
        open.push((second, [middle, to], halvings + 1));
        open.push((first, [from, middle], halvings + 1));
    }
    Turn::Right
}

fn largest(cubic: &[f64; 4]) -> f64 {
    cubic.iter().fold(0.0, |most, b| most.max(b.abs()))
}

/// Returns bounds on the fold angle over a curve; `None` if its control points exclude no angle. A control point is known
/// to within `slack`.
fn range(curve: &Curve<f64>, slack: f64) -> Option<[f64; 2]> {
    let ends = |angles: [f64; 4]| {
        let low = angles.iter().copied().fold(f64::INFINITY, f64::min);
        let high = angles.iter().copied().fold(f64::NEG_INFINITY, f64::max);
        [low, high]
    };
    match curve {
        Curve::Angle(angle) => {
            let [low, high] = ends(*angle);
            Some([low - slack, high + slack])
        }
        Curve::HalfAngle { cos, sin } => {
            let halves = core::array::from_fn(|k| sin[k].atan2(cos[k]));
            let norms = (0..4).map(|k| cos[k].hypot(sin[k]));
            let off = 2.0 * slack / norms.fold(f64::INFINITY, f64::min);
            let [low, high] = ends(halves);
            let cone = high - low + 2.0 * off < PI && off.is_finite();
            cone.then_some([2.0 * (low - off), 2.0 * (high + off)])
        }
    }
}

/// Returns the two halves of a curve, by de Casteljau's algorithm.
fn halves(curve: &Curve<f64>) -> [Curve<f64>; 2] {
    let split = |[a, b, c, d]: [f64; 4]| {
        let [ab, bc, cd] = [(a, b), (b, c), (c, d)].map(|(x, y)| f64::midpoint(x, y));
        let [abc, bcd] = [(ab, bc), (bc, cd)].map(|(x, y)| f64::midpoint(x, y));
        let middle = f64::midpoint(abc, bcd);
        [[a, ab, abc, middle], [middle, bcd, cd, d]]
    };
    match *curve {
        Curve::Angle(angle) => split(angle).map(Curve::Angle),
        Curve::HalfAngle { cos, sin } => {
            let [[cos, more_cos], [sin, more_sin]] = [split(cos), split(sin)];
            [
                Curve::HalfAngle { cos, sin },
                Curve::HalfAngle {
                    cos: more_cos,
                    sin: more_sin,
                },
            ]
        }
    }
}

#[cfg(test)]
mod tests {
    use foldpath_core::{Interpolation, Node};
    use rand_pcg::Pcg64;
    use rand_pcg::rand_core::Rng;

    use super::*;

    /// Number of random segments of each kind of interpolation.
    const SEGMENTS: usize = 100_000;
    /// Number of halvings after which the parts of a curve are compared with the sampled range.
    const HALVINGS: usize = 4;
    /// Number of samples of a segment, less one.
    const SAMPLES: u32 = 64;

    /// Returns a random number between -1 and 1.
    fn noise(random: &mut Pcg64) -> f64 {
        (random.next_u64() >> 11) as f64 / 2_f64.powi(52) - 1.0
    }

    /// Returns the cubic with these values and slopes at its ends, by the basis of Hermite.
    fn cubic([from, slope]: [f64; 2], [to, to_slope]: [f64; 2], s: f64) -> f64 {
        let rest = 1.0 - s;
        rest * rest * ((1.0 + 2.0 * s) * from + s * slope)
            + s * s * ((3.0 - 2.0 * s) * to - rest * to_slope)
    }

    /// Returns the fold angle at `s` by the definition of the interpolation.
    fn angle(kind: Interpolation, from: Node<f64>, to: Node<f64>, s: f64) -> f64 {
        let tangent = |node: Node<f64>| {
            let tan = (node.angle / 2.0).tan();
            [tan, node.rate / (1.0 + node.angle.cos())]
        };
        let weighted = |node: Node<f64>, (part, slope): (f64, f64)| {
            [
                node.weight[0] * part,
                node.weight[1] * part + node.weight[0] * slope * node.rate / 2.0,
            ]
        };
        let cos =
            |node: Node<f64>| weighted(node, ((node.angle / 2.0).cos(), -(node.angle / 2.0).sin()));
        let sin =
            |node: Node<f64>| weighted(node, ((node.angle / 2.0).sin(), (node.angle / 2.0).cos()));
        match kind {
            Interpolation::Linear => from.angle + s * (to.angle - from.angle),
            Interpolation::Hermite => cubic([from.angle, from.rate], [to.angle, to.rate], s),
            Interpolation::HalfAngle => 2.0 * cubic(tangent(from), tangent(to), s).atan(),
            Interpolation::Homogeneous => {
                2.0 * cubic(sin(from), sin(to), s).atan2(cubic(cos(from), cos(to), s))
            }
        }
    }

    /// Returns the range of all parts after some halvings; `None` if the control points of a part exclude no angle.
    fn range_of_parts(curve: &Curve<f64>, slack: f64, halvings: usize) -> Option<[f64; 2]> {
        if halvings == 0 {
            return range(curve, slack);
        }
        let [first, second] = halves(curve).map(|half| range_of_parts(&half, slack, halvings - 1));
        let ([a, b], [c, d]) = (first?, second?);
        Some([a.min(c), b.max(d)])
    }

    /// The range of each of many random segments contains the angles by the definition, undivided and in 16 parts. In
    /// 16 parts, it is wider than the sampled range by less than 1 % in the median.
    #[test]
    fn ranges_contain_the_angle_closely() {
        for kind in [
            Interpolation::Linear,
            Interpolation::Hermite,
            Interpolation::HalfAngle,
            Interpolation::Homogeneous,
        ] {
            let random = &mut Pcg64::new(7, 0);
            let mut excess = Vec::with_capacity(SEGMENTS);
            let mut unbounded = 0;
            for segment in 0..SEGMENTS {
                // Some segments are short and some have weights that nearly vanish, at an end or between the ends.
                let scale = 10_f64.powf(2.0 * noise(random) - 2.0).min(1.0);
                let base = 2.0 * noise(random);
                let mut node = || {
                    let weight = if segment % 4 == 0 {
                        10_f64.powf(6.0 * noise(random) - 6.0)
                    } else {
                        1.0 + 0.9 * noise(random)
                    };
                    let grow = if segment % 4 == 1 { -4.0 } else { 1.0 };
                    Node {
                        angle: base + scale * noise(random),
                        rate: 3.0 * scale * noise(random),
                        weight: [weight, grow * weight * noise(random)],
                    }
                };
                let (from, to) = (node(), node());
                let curve = Curve::between(kind, 1.0, from, to);
                let size = match &curve {
                    Curve::Angle(angle) => largest(angle),
                    Curve::HalfAngle { cos, sin } => largest(cos).max(largest(sin)),
                };
                let slack = ROUNDING_EPSILONS * f64::EPSILON * size;
                let samples =
                    (0..=SAMPLES).map(|k| angle(kind, from, to, f64::from(k) / f64::from(SAMPLES)));
                let [mut low, mut high] = [f64::INFINITY, f64::NEG_INFINITY];
                samples.for_each(|x| (low, high) = (low.min(x), high.max(x)));
                for halvings in [0, HALVINGS] {
                    let Some([least, most]) = range_of_parts(&curve, slack, halvings) else {
                        unbounded += usize::from(halvings == HALVINGS);
                        continue;
                    };
                    // The definition is computed with rounding as well, large where weights vanish.
                    let rounding = 1e-9 * (1.0 + most - least);
                    assert!(
                        least <= low + rounding && high - rounding <= most,
                        "{kind:?} {from:?} {to:?}: {low} to {high} is not in {least} to {most}"
                    );
                    if halvings == HALVINGS {
                        excess.push((most - least) / (high - low) - 1.0);
                    }
                }
            }
            excess.sort_by(f64::total_cmp);
            let median = excess[excess.len() / 2];
            assert!(median < 0.01, "{kind:?}: {median}");
            assert!(unbounded < SEGMENTS / 20, "{kind:?}: {unbounded}");
        }
    }
}
