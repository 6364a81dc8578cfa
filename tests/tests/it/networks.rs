//! Networks of vertices with four creases that fold flat, against an enumeration of the modes in which they leave flat.
//!
//! Each vertex has two modes, found here from the first and second order of its closure condition alone: rates x of the
//! creases with directions w, counter-clockwise, fulfil Σ xₖ wₖ = 0 and Σ xⱼ xₖ wⱼ × wₖ = 0, the latter summed over j < k.
//! A network folds along its letters if, and only if, a choice of modes gives each crease between two vertices one rate.

use core::f64::consts::{FRAC_PI_2, PI, TAU};

use foldpath::pattern::{CreasePattern, Drawing, DrawnEdge, Letter};
use foldpath::planner::{CauseKind, Foldability, Goal, Outcome, PlanOptions, forecast, plan};
use foldpath::progress::Watch;
use foldpath::symmetry::CreaseGroups;
use foldpath_tests::Random;
use nalgebra::{Matrix2, Vector2, Vector4};
use rayon::prelude::*;

/// Logarithm of the ratio of two rates of one crease, below which they agree and above which they clearly differ.
const AGREE: f64 = 1e-9;
const DIFFER: f64 = 0.2;
/// Least sector of a vertex, radians, and least rate in a mode whose largest rate is 1.
const LEAST_SECTOR: f64 = 0.3;
const LEAST_RATE: f64 = 0.05;

/// Two rows of vertices. Vertex `row * columns + column`; `turns` has a crease of each corner that ends on the border and
/// whose direction is free, off the vertical.
struct Network {
    columns: usize,
    places: Vec<Vector2<f64>>,
    turns: [f64; 4],
}

/// The four creases of a vertex, counter-clockwise, with their directions.
type Star = [(usize, f64); 4];

impl Network {
    fn random(random: &mut Random) -> Self {
        let columns = random.whole(2, 3);
        let place = |k: usize, random: &mut Random| {
            let [x, y] = [k % columns, k / columns].map(|k| k as f64);
            Vector2::new(x + random.uniform(-0.2, 0.2), y + random.uniform(-0.2, 0.2))
        };
        Self {
            columns,
            places: (0..2 * columns).map(|k| place(k, random)).collect(),
            turns: [0; 4].map(|_| random.uniform(-0.4, 0.4)),
        }
    }

    /// Pairs of vertices with a crease between them: along the rows, then across.
    fn inner(&self) -> Vec<[usize; 2]> {
        let n = self.columns;
        let along = (0..2 * n).filter(|k| k % n + 1 < n).map(|k| [k, k + 1]);
        along.chain((0..n).map(|k| [k, k + n])).collect()
    }

    /// Returns each crease that ends on the border: its vertex and its direction, in the order of the border.
    fn outer(&self) -> Vec<(usize, f64)> {
        let n = self.columns;
        let way = |from: usize, to: usize| {
            let along = self.places[to] - self.places[from];
            along.y.atan2(along.x)
        };
        // The alternate sectors of each vertex add up to half a turn.
        let corner = |vertex: usize, beside: usize, across: usize, turn: f64| {
            let down = if vertex < n { -FRAC_PI_2 } else { FRAC_PI_2 };
            let free = down + turn;
            let other = PI + way(vertex, across) + free - way(vertex, beside);
            [(vertex, free), (vertex, other)]
        };
        let middle = |vertex: usize| {
            let across = (vertex + n) % (2 * n);
            let sides = way(vertex, vertex - 1) + way(vertex, vertex + 1);
            (vertex, PI + sides - way(vertex, across))
        };
        let [[a, b], [c, d], [e, f], [g, h]] = [
            corner(0, 1, n, self.turns[0]),
            corner(n - 1, n - 2, 2 * n - 1, self.turns[1]),
            corner(2 * n - 1, 2 * n - 2, n - 1, self.turns[2]),
            corner(n, n + 1, 0, self.turns[3]),
        ];
        let mut outer = vec![b, a];
        outer.extend((1..n - 1).map(middle));
        outer.extend([c, d, f, e]);
        outer.extend((1..n - 1).rev().map(|k| middle(k + n)));
        outer.extend([g, h]);
        outer
    }

    /// Returns the star of each vertex; `None` if a sector is narrow or wide. Creases are numbered `inner`, then `outer`.
    fn stars(&self) -> Option<Vec<Star>> {
        let mut stars = vec![Vec::new(); self.places.len()];
        for (crease, ends) in self.inner().into_iter().enumerate() {
            for [from, to] in [ends, [ends[1], ends[0]]] {
                let along = self.places[to] - self.places[from];
                stars[from].push((crease, along.y.atan2(along.x)));
            }
        }
        for (k, (vertex, way)) in self.outer().into_iter().enumerate() {
            stars[vertex].push((self.inner().len() + k, way));
        }
        let whole = stars.into_iter().map(|mut star| {
            for (_, way) in &mut star {
                *way = way.rem_euclid(TAU);
            }
            star.sort_by(|a, b| a.1.total_cmp(&b.1));
            let sector = |k: usize| (star[(k + 1) % 4].1 - star[k].1).rem_euclid(TAU);
            let sound = (0..4).all(|k| (LEAST_SECTOR..PI - LEAST_SECTOR).contains(&sector(k)));
            sound.then_some(star)?.try_into().ok()
        });
        whole.collect()
    }

    fn pattern(&self, letters: &[Letter]) -> Option<CreasePattern> {
        let (inner, outer) = (self.inner(), self.outer());
        let mut vertices = self.places.clone();
        let mut ends = inner;
        for (vertex, way) in &outer {
            ends.push([*vertex, vertices.len()]);
            vertices.push(self.places[*vertex] + 0.6 * Vector2::new(way.cos(), way.sin()));
        }
        let rim = |k: usize| self.places.len() + k % outer.len();
        let creases = ends.into_iter().zip(letters.iter().copied());
        let border = (0..outer.len()).map(|k| ([rim(k), rim(k + 1)], Letter::Boundary));
        let drawn = |(ends, letter)| DrawnEdge {
            ends,
            letter,
            goal: None,
        };
        let drawing = Drawing {
            edges: creases.chain(border).map(drawn).collect(),
            vertices,
            faces: None,
        };
        CreasePattern::new(drawing).ok()
    }
}

/// Returns the two modes of a vertex: rates of its creases, the largest 1 in absolute value.
fn modes(star: &Star) -> Option<[Vector4<f64>; 2]> {
    let ways = star.map(|(_, way)| Vector2::new(way.cos(), way.sin()));
    let last = Matrix2::from_columns(&[ways[2], ways[3]]).try_inverse()?;
    let [one, other] = [0, 1].map(|k| {
        let rest = -(last * ways[k]);
        let mut rates = Vector4::new(0.0, 0.0, rest.x, rest.y);
        rates[k] = 1.0;
        rates
    });
    let second = |x: &Vector4<f64>, y: &Vector4<f64>| -> f64 {
        let pairs = (0..4).flat_map(|j| (j + 1..4).map(move |k| (j, k)));
        pairs
            .map(|(j, k)| x[j] * y[k] * ways[j].perp(&ways[k]))
            .sum()
    };
    let (a, b, c) = (
        second(&one, &one),
        second(&one, &other) + second(&other, &one),
        second(&other, &other),
    );
    let root = (b * b - 4.0 * a * c).max(0.0).sqrt();
    let modes = [-1.0, 1.0].map(|sign| {
        let rates = (-b + sign * root) * one + 2.0 * a * other;
        rates / rates.amax()
    });
    let sound = modes
        .iter()
        .all(|rates| rates.amin().abs() > 0.0 && rates.abs().min() > LEAST_RATE);
    sound.then_some(modes)
}

/// Returns by how much the rates of a crease differ at least, over all choices of modes that agree with the letters: the
/// logarithm of their ratio. Infinite if each choice contradicts a letter.
///
/// `letters` has 1 for a valley, -1 for a mountain and 0 for a crease that may turn either way or not at all.
fn disagreement(stars: &[Star], letters: &[f64]) -> Option<f64> {
    let modes: Vec<[Vector4<f64>; 2]> = stars.iter().map(modes).collect::<Option<_>>()?;
    let mut least = f64::INFINITY;
    for choice in 0..1_usize << stars.len() {
        let rates = |vertex: usize| modes[vertex][choice >> vertex & 1];
        for sign in [-1.0, 1.0] {
            least = least.min(worst_ratio(stars, &rates, sign, letters));
        }
    }
    Some(least)
}

/// Returns the largest disagreement of one choice of modes. The first vertex turns with the scale `sign`.
fn worst_ratio(
    stars: &[Star],
    rates: &dyn Fn(usize) -> Vector4<f64>,
    sign: f64,
    letters: &[f64],
) -> f64 {
    let mut known: Vec<Option<f64>> = vec![None; letters.len()];
    let mut scales = vec![None; stars.len()];
    scales[0] = Some(sign);
    let mut worst = 0.0_f64;
    while let Some(vertex) = (0..stars.len()).find(|&v| {
        scales[v] != Some(0.0)
            && (scales[v].is_some() || stars[v].iter().any(|(crease, _)| known[*crease].is_some()))
    }) {
        let (star, own) = (&stars[vertex], rates(vertex));
        let shared = (0..4).find_map(|k| known[star[k].0].map(|rate| rate / own[k]));
        let scale = scales[vertex].or(shared).expect("a rate that is known");
        // Zero says that the vertex is done.
        scales[vertex] = Some(0.0);
        for (k, (crease, _)) in star.iter().enumerate() {
            let rate = scale * own[k];
            if rate * letters[*crease] < 0.0 {
                return f64::INFINITY;
            }
            match known[*crease] {
                Some(before) if before * rate < 0.0 => return f64::INFINITY,
                Some(before) => worst = worst.max((rate / before).ln().abs()),
                None => known[*crease] = Some(rate),
            }
        }
    }
    worst
}

/// Signs of the rates of all creases in a random choice of modes whose signs agree, as letters.
fn lettered(stars: &[Star], creases: usize, random: &mut Random) -> Option<Vec<f64>> {
    let mut letters = vec![0.0; creases];
    for star in stars {
        let modes = modes(star)?;
        let first = random.whole(0, 1);
        let fits = |rates: &Vector4<f64>| (0..4).all(|k| letters[star[k].0] * rates[k] >= 0.0);
        let choices = [first, 1 - first].map(|k| modes[k]);
        let both = choices.into_iter().flat_map(|rates| [rates, -rates]);
        let chosen = both.into_iter().find(|rates| fits(rates))?;
        for k in 0..4 {
            letters[star[k].0] = chosen[k].signum();
        }
    }
    Some(letters)
}

/// Turns the free crease of a corner until the rates agree round the loop of vertices beside it, if they can.
fn mended(network: &mut Network, corner: usize, letters: &[f64]) -> Option<()> {
    let n = network.columns;
    let left = matches!(corner, 0 | 3);
    let columns = if left { [0, 1] } else { [n - 2, n - 1] };
    let mut signed = |turn: f64| -> Option<f64> {
        network.turns[corner] = turn;
        let stars = network.stars()?;
        // The rates of both creases across, each followed along both rows.
        let ratio = |vertex: usize| -> Option<f64> {
            let star = &stars[vertex];
            let fits = |rates: &&Vector4<f64>| {
                let signs: Vec<f64> = (0..4).map(|k| rates[k] * letters[star[k].0]).collect();
                signs.iter().all(|s| *s > 0.0) || signs.iter().all(|s| *s < 0.0)
            };
            let modes = modes(star)?;
            let rates = modes.iter().find(fits)?;
            let inner = network.inner();
            let of = |ends: [usize; 2]| {
                let crease = inner.iter().position(|pair| *pair == ends)?;
                let place = star.iter().position(|(c, _)| *c == crease)?;
                Some(rates[place].abs())
            };
            let row = vertex / n * n;
            let along = of([row + columns[0], row + columns[1]])?;
            let across = of([vertex % n, vertex % n + n])?;
            Some((across / along).ln())
        };
        let [a, b] = columns;
        Some(ratio(a)? - ratio(b)? - ratio(a + n)? + ratio(b + n)?)
    };
    let steps: Vec<f64> = (0..=40).map(|k| -0.8 + 0.04 * f64::from(k)).collect();
    for pair in steps.windows(2) {
        let (mut low, mut high) = (pair[0], pair[1]);
        let (Some(at_low), Some(at_high)) = (signed(low), signed(high)) else {
            continue;
        };
        if at_low * at_high > 0.0 {
            continue;
        }
        for _ in 0..60 {
            let middle = (low + high) / 2.0;
            if signed(middle)? * at_low > 0.0 {
                low = middle;
            } else {
                high = middle;
            }
        }
        signed(high)?;
        return Some(());
    }
    None
}

/// A network with its letters, and whether it folds along them; `None` if that is not clear.
fn network(random: &mut Random, folds: bool, all: bool) -> Option<(CreasePattern, bool)> {
    let mut network = Network::random(random);
    let stars = network.stars()?;
    let creases = network.inner().len() + network.outer().len();
    let mut letters = lettered(&stars, creases, random)?;
    if folds {
        mended(&mut network, 3, &letters)?;
        if network.columns == 3 {
            mended(&mut network, 2, &letters)?;
        }
    }
    if !all {
        for letter in &mut letters {
            *letter *= f64::from(u8::from(random.chance(0.6)));
        }
    }
    let off = disagreement(&network.stars()?, &letters)?;
    let clear = !(AGREE..=DIFFER).contains(&off);
    let names: Vec<Letter> = letters
        .iter()
        .map(|letter| match *letter {
            l if l > 0.0 => Letter::Valley,
            l if l < 0.0 => Letter::Mountain,
            _ => Letter::Unassigned,
        })
        .collect();
    let lettered = names.iter().any(|letter| *letter != Letter::Unassigned);
    (clear && lettered).then_some(())?;
    Some((network.pattern(&names)?, off < AGREE))
}

#[test]
fn networks_fold_if_their_modes_agree() {
    let mut random = Random::new(1);
    let options = PlanOptions::default().with(|it| it.bound = 1e-3);
    // With letters on all creases and on some: networks that fold, those of them that are planned, networks that do not.
    let mut counts = [[0; 3]; 2];
    while counts
        .iter()
        .map(|[free, _, locked]| free + locked)
        .sum::<usize>()
        < 300
    {
        let (some, wanted) = (random.chance(0.3), random.chance(0.6));
        let Some((pattern, folds)) = network(&mut random, wanted, !some) else {
            continue;
        };
        let goal = Goal::of_letters(&pattern, 0.1).unwrap();
        let planned = plan(&pattern, &goal, &options).outcome == Outcome::Planned;
        let foreseen = forecast(&pattern, &CreaseGroups::find(&pattern), Watch::default());
        let mut kinds = foreseen.causes.iter().map(|cause| &cause.kind);
        let count = &mut counts[usize::from(some)];
        if folds {
            count[0] += 1;
            count[1] += usize::from(planned);
            assert_ne!(foreseen.foldability, Foldability::No, "{count:?}");
            assert!(!kinds.any(|kind| matches!(kind, CauseKind::LockedLoop(_))));
        } else {
            count[2] += 1;
            assert!(!planned, "{count:?}");
            assert_ne!(foreseen.foldability, Foldability::Likely, "{count:?}");
            assert!(some || kinds.any(|kind| matches!(kind, CauseKind::LockedLoop(_))));
        }
    }
    println!("[fold, planned, locked] with letters on all creases, and on some: {counts:?}");
    let [[free, planned, _], [some_free, some_planned, _]] = counts;
    assert_eq!(planned, free);
    // Letters on some creases leave a choice of modes, of which the planner may take a wrong one.
    assert!(2 * some_planned >= some_free, "{counts:?}");
}

/// Number of networks that lock with rigid panels, and of those that fold half way with panels that bend by this, degrees.
const LOCKED: u64 = 30;
const LOCKED_PLANNED: usize = 28;
const BEND_DEG: f64 = 60.0;

/// Networks that lock are led half way by bending their panels, and the answer is the attempt that leads farthest.
#[test]
fn locked_networks_fold_as_far_as_the_best_attempt() {
    let options = PlanOptions::default().with(|it| it.bend = BEND_DEG.to_radians());
    let planned = (0..LOCKED).into_par_iter().filter(|&seed| {
        let mut random = Random::stream(seed, 63);
        let drawn = core::iter::repeat_with(|| network(&mut random, false, true));
        let (pattern, _) = drawn.flatten().find(|(_, folds)| !folds).unwrap();
        let goal = Goal::of_letters(&pattern, 0.5).unwrap();
        let plan = plan(&pattern, &goal, &options);
        let attempts = plan.attempts.iter().map(|attempt| attempt.reached);
        let farthest = attempts.fold(0.0, f64::max);
        assert!(
            plan.reached >= farthest,
            "network {seed}: {} of {farthest}",
            plan.reached
        );
        plan.outcome == Outcome::Planned
    });
    let planned = planned.count();
    println!("{planned} of {LOCKED} locked networks planned");
    assert!(planned >= LOCKED_PLANNED, "{planned}");
}
