//! Loops of vertices that lock each other: the letters leave a vertex of four creases one way to leave flat, with rates in
//! fixed ratios, and round a loop of vertices the ratios multiply to something else than 1.
//!
//! Rates of four creases that satisfy the conditions to first order are a plane; that to second order (`products.rs`) leaves
//! two lines of it. If the letters allow one of these alone, the rates of the vertex are in its ratios, or all 0. The ratios of
//! all vertices are followed from crease to crease (unit propagation), in interval arithmetic, so that the directions of the
//! creases may be wrong. At a vertex that folds flat the tangents of half the angles keep the same ratios all along the motion
//! (T. Tachi, "Generalization of rigid-foldable quadrilateral-mesh origami", 2009).

use core::ops::{Add, Div, Mul, Neg, Sub};
use std::collections::{HashSet, VecDeque};

use crate::pattern::{CreasePattern, EdgeId, VertexId};

/// Creases whose rates are in ratios that contradict each other round a loop.
pub(crate) struct LockedLoop {
    /// Product of the ratios round the loop.
    pub(crate) product: f64,
    /// The vertices of the loop.
    pub(crate) vertices: Vec<VertexId>,
    /// The creases that cannot turn: those of the loop, and all whose rates are in a ratio to theirs.
    pub(crate) creases: Vec<usize>,
}

/// Logarithm of a product of ratios from which on a loop is named as what is in the way, whether that is proved or not.
pub(crate) const OTHER_RATIO: f64 = 0.02;

/// Two creases whose rates have a fixed ratio.
struct Tie {
    to: usize,
    /// Logarithm of the ratio.
    log: Interval,
    vertex: VertexId,
}

/// Returns the sets of vertices that lock each other.
///
/// `signs` has for each crease 1 (valley), -1 (mountain) or 0 (either), and `errors` the largest error of its direction,
/// radians. The logarithm of the product of the ratios has to differ from 0 by more than `margin`. Cost: O(creases).
pub(crate) fn locked_loops(
    pattern: &CreasePattern,
    signs: &[f64],
    errors: &[f64],
    margin: f64,
) -> Vec<LockedLoop> {
    let mut ties: Vec<Vec<Tie>> = Vec::new();
    ties.resize_with(signs.len(), Vec::new);
    for vertex in pattern.real_vertices() {
        let Some((creases, logs)) = rates(pattern, vertex, signs, errors) else {
            continue;
        };
        for k in 0..4 {
            let [from, to] = [k, (k + 1) % 4];
            let log = logs[to] - logs[from];
            let [from, to] = [from, to].map(|k| creases[k]);
            ties[from].push(Tie { to, log, vertex });
            ties[to].push(Tie {
                to: from,
                log: -log,
                vertex,
            });
        }
    }
    let mut turns = vec![None; signs.len()];
    let mut loops = Vec::new();
    for first in 0..signs.len() {
        if turns[first].is_none() && !ties[first].is_empty() {
            loops.extend(propagate(&ties, &mut turns, first, margin));
        }
    }
    loops
}

/// Follows the ratios from a crease to all that depend on it. Returns the loop if they contradict each other: the way back
/// from both ends of the tie that contradicts.
fn propagate(
    ties: &[Vec<Tie>],
    turns: &mut [Option<Interval>],
    first: usize,
    margin: f64,
) -> Option<LockedLoop> {
    let mut came: Vec<Option<(usize, VertexId)>> = vec![None; turns.len()];
    let mut open = VecDeque::from([first]);
    let (mut reached, mut wrong) = (vec![first], None);
    let margin = Interval::of(-margin, margin);
    turns[first] = Some(Interval::of(0.0, 0.0));
    while let Some(crease) = open.pop_front() {
        let here = turns[crease].unwrap_or(Interval::of(0.0, 0.0));
        for tie in &ties[crease] {
            let there = here + tie.log;
            match turns[tie.to] {
                None => {
                    turns[tie.to] = Some(there);
                    came[tie.to] = Some((crease, tie.vertex));
                    reached.push(tie.to);
                    open.push_back(tie.to);
                }
                Some(known) if !(there - known + margin).contains_zero() => {
                    wrong = wrong.or(Some((crease, tie, (there - known).middle().exp())));
                }
                Some(_) => {}
            }
        }
    }
    let (from, tie, product) = wrong?;
    let back = |crease: usize| -> Vec<VertexId> {
        let step = |(crease, _): &(usize, VertexId)| came[*crease];
        let way = core::iter::successors(came[crease], step);
        way.map(|(_, vertex)| vertex).collect()
    };
    let [mut one, mut other] = [back(from), back(tie.to)];
    // The ways run together before they come to the first crease.
    while one.last().is_some() && one.last() == other.last() {
        one.pop();
        other.pop();
    }
    let mut vertices = vec![tie.vertex];
    vertices.extend(one.into_iter().chain(other));
    let mut seen = HashSet::new();
    vertices.retain(|vertex| seen.insert(*vertex));
    reached.sort_unstable();
    Some(LockedLoop {
        product,
        vertices,
        creases: reached,
    })
}

/// Returns the creases of a vertex counter-clockwise, and the logarithms of their rates up to a common summand. `None` if the
/// vertex has other than four creases, or the letters leave it more than one line of rates, or none, or that is not certain.
fn rates(
    pattern: &CreasePattern,
    vertex: VertexId,
    signs: &[f64],
    errors: &[f64],
) -> Option<([usize; 4], [Interval; 4])> {
    let star = pattern.stars()[vertex.index()].iter().copied();
    let star: Vec<EdgeId> = star.filter(|&edge| !pattern.joins_parts(edge)).collect();
    let star: [EdgeId; 4] = star.try_into().ok()?;
    let mut creases = [0; 4];
    for (crease, edge) in creases.iter_mut().zip(star) {
        *crease = pattern.edge(edge).crease?.index();
    }
    let ways = star.map(|edge| pattern.direction(edge, vertex));
    // The sines of the angles from one crease to another.
    let sines: [[Interval; 4]; 4] = core::array::from_fn(|a| {
        core::array::from_fn(|b| {
            let (sine, off) = (
                ways[a].perp(&ways[b]),
                errors[creases[a]] + errors[creases[b]],
            );
            Interval::of(sine - off, sine + off)
        })
    });
    let letters = creases.map(|crease| signs[crease]);
    let mut pairs = [[0, 1], [0, 2], [0, 3], [1, 2], [1, 3], [2, 3]];
    let sine = |[a, b]: [usize; 2]| ways[a].perp(&ways[b]).abs();
    pairs.sort_by(|a, b| sine(*b).total_cmp(&sine(*a)));
    let mut found = pairs
        .iter()
        .filter_map(|&pair| only_line(&sines, letters, pair));
    let logs = found.next()?.map(Interval::log_of_size);
    Some((creases, logs))
}

/// Returns rates on the only line of rates that the letters allow, if that is certain. The rates of the creases `p` and `q`
/// follow from those of the other two by the conditions to first order.
fn only_line(
    sines: &[[Interval; 4]; 4],
    letters: [f64; 4],
    [p, q]: [usize; 2],
) -> Option<[Interval; 4]> {
    let mut others = (0..4).filter(|k| ![p, q].contains(k));
    let [a, b] = [others.next()?, others.next()?];
    // Each rate is a number plus another one times the rate of b, that of a being 1.
    let [zero, one] = [0.0, 1.0].map(|x| Interval::of(x, x));
    let mut constant = [zero; 4];
    let mut linear = [zero; 4];
    (constant[a], linear[b]) = (one, one);
    for (k, other) in [(p, q), (q, p)] {
        let of = |from: usize| sines[other][from] / sines[k][other];
        (constant[k], linear[k]) = (of(a), of(b));
    }
    // The condition to second order, a quadratic equation for the rate of b.
    let [mut free, mut half, mut square] = [zero; 3];
    for j in 0..4 {
        for k in j + 1..4 {
            free = free + sines[j][k] * constant[j] * constant[k];
            half = half + sines[j][k] * (constant[j] * linear[k] + linear[j] * constant[k]);
            square = square + sines[j][k] * linear[j] * linear[k];
        }
    }
    let half = half * Interval::of(0.5, 0.5);
    let root = (half * half - free * square).root()?;
    let sum = if half.middle() < 0.0 {
        half - root
    } else {
        half + root
    };
    let mut allowed = None;
    for rate in [-sum / square, -free / sum] {
        let rates: [Interval; 4] = core::array::from_fn(|k| constant[k] + linear[k] * rate);
        let mut ways = [1.0, -1.0]
            .into_iter()
            .map(|way| is_allowed(&rates, letters, way));
        match (ways.next()?, ways.next()?) {
            (Some(false), Some(false)) => {}
            (Some(true), _) | (_, Some(true)) if allowed.is_none() => allowed = Some(rates),
            _ => return None,
        }
    }
    allowed
}

/// Returns whether the signs of the rates, times `way`, are those of the letters; `None` if that is not certain.
fn is_allowed(rates: &[Interval; 4], letters: [f64; 4], way: f64) -> Option<bool> {
    let sides = rates.iter().zip(letters).map(|(rate, letter)| {
        let along = *rate * Interval::of(way * letter, way * letter);
        let is_along = along.low > 0.0;
        (is_along || along.high < 0.0).then_some(is_along)
    });
    let sides: Vec<Option<bool>> = sides.collect();
    if sides.contains(&Some(false)) {
        return Some(false);
    }
    sides.iter().all(Option::is_some).then_some(true)
}

/// A number that is between two others; everything is, if one of them is not a number.
#[derive(Clone, Copy, Debug)]
struct Interval {
    low: f64,
    high: f64,
}

impl Interval {
    fn of(low: f64, high: f64) -> Self {
        Self { low, high }
    }

    /// Returns the smallest interval of some numbers, widened by their rounding.
    fn round<const N: usize>(numbers: [f64; N]) -> Self {
        let mut all = Self::of(f64::INFINITY, f64::NEG_INFINITY);
        for number in numbers {
            if number.is_nan() {
                return Self::of(f64::NEG_INFINITY, f64::INFINITY);
            }
            all = Self::of(all.low.min(number), all.high.max(number));
        }
        Self::of(all.low.next_down(), all.high.next_up())
    }

    fn contains_zero(self) -> bool {
        !(self.low > 0.0 || self.high < 0.0)
    }

    fn middle(self) -> f64 {
        (self.low + self.high) / 2.0
    }

    /// Returns the square root; `None` if the number may be 0 or negative.
    fn root(self) -> Option<Self> {
        (self.low > 0.0).then(|| Self::round([self.low.sqrt(), self.high.sqrt()]))
    }

    /// Returns the logarithm of the absolute value. The interval has to be on one side of 0.
    fn log_of_size(self) -> Self {
        // Logarithms are right to within two units in the last place.
        let Self { low, high } = Self::round([self.low.abs().ln(), self.high.abs().ln()]);
        Self::of(low.next_down(), high.next_up())
    }
}

impl Neg for Interval {
    type Output = Self;
    fn neg(self) -> Self {
        Self::of(-self.high, -self.low)
    }
}

impl Add for Interval {
    type Output = Self;
    fn add(self, other: Self) -> Self {
        Self::round([self.low + other.low, self.high + other.high])
    }
}

impl Sub for Interval {
    type Output = Self;
    fn sub(self, other: Self) -> Self {
        self + -other
    }
}

impl Mul for Interval {
    type Output = Self;
    fn mul(self, other: Self) -> Self {
        Self::round([
            self.low * other.low,
            self.low * other.high,
            self.high * other.low,
            self.high * other.high,
        ])
    }
}

impl Div for Interval {
    type Output = Self;
    fn div(self, other: Self) -> Self {
        if other.contains_zero() {
            return Self::of(f64::NEG_INFINITY, f64::INFINITY);
        }
        Self::round([
            self.low / other.low,
            self.low / other.high,
            self.high / other.low,
            self.high / other.high,
        ])
    }
}
