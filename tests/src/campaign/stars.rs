//! Random stars: do closure and its Jacobian agree with products of 4x4 matrices, and are solvers right when they say
//! that a star closes or does not?

use core::f64::consts::{PI, TAU};
use core::fmt;
use core::panic::AssertUnwindSafe;
use std::collections::BTreeMap;
use std::panic::catch_unwind;

use foldpath_core::least_squares::{ClosureProblem, Limits, Options, Outcome, Report};
use foldpath_core::{
    DenseNormalEquations, GroupId, HalfAngle, Scalar, Spoke, StarView, StarsView, closure,
    gradient, levenberg_marquardt,
};
use nalgebra::{Matrix3, Matrix4, Vector2, Vector3};

use crate::matrices::{Line, product, residual, rotation, skew};
use crate::{Random, exceeds, worst};

/// `DEGREE`: largest number of creases round a vertex. `TOGETHER`: largest number of vertices that share unknowns.
const DEGREE: usize = 64;
const TOGETHER: usize = 3;
/// Largest number of iterations of the solvers.
const LM_STEPS: u32 = 100;
const GRADIENT_STEPS: u32 = 60;
/// Largest difference of a residual from the matrices' residual, in roundings a crease.
const ROUNDINGS: f64 = 4.0;
/// Cosine of half the misclosure below which the sign of the residual is not defined.
const HALF_TURN: f64 = 1e-3;

/// Results for the stars.
#[derive(Debug, Default)]
pub struct Stars {
    /// Number of stars that were judged.
    pub stars: u64,
    /// Number of problems, of one to three stars each, that were solved.
    pub problems: u64,
    /// Largest error of a residual and of an entry of the Jacobian, in roundings a crease.
    pub errors: [f64; 2],
    /// Number of runs by solver and outcome.
    pub outcomes: BTreeMap<(&'static str, String), u64>,
    /// Failures, with seeds.
    pub failures: Vec<(u64, String)>,
}

/// Some stars in common unknowns, and the start of the solvers.
#[derive(Debug)]
struct Problem {
    degrees: Vec<usize>,
    unknowns: usize,
    spokes: Vec<(GroupId, bool, [f64; 2])>,
    start: Vec<f64>,
    limits: Option<Vec<(f64, f64)>>,
}

/// Judges problems with the seeds from `seed` on, until at least `count` stars were judged.
#[must_use]
pub fn run(seed: u64, count: u64) -> Stars {
    let mut tally = Stars::default();
    let mut seed = seed;
    while tally.stars < count {
        let problem = Problem::draw(&mut Random::new(seed));
        let judged = catch_unwind(AssertUnwindSafe(|| {
            let mut found = Vec::new();
            tally.judge::<f64>("f64", &problem, &mut found);
            tally.judge::<f32>("f32", &problem, &mut found);
            found
        }));
        match judged {
            Ok(found) => tally
                .failures
                .extend(found.into_iter().map(|words| (seed, words))),
            Err(_) => tally.failures.push((seed, "panicked".into())),
        }
        tally.stars += problem.degrees.len() as u64;
        tally.problems += 1;
        seed += 1;
    }
    tally
}

impl Problem {
    fn draw(random: &mut Random) -> Self {
        let together = random.whole(1, TOGETHER);
        let mut degrees = Vec::new();
        for _ in 0..together {
            let most = if random.chance(0.02) { DEGREE } else { 8 };
            degrees.push(random.whole(1, most));
        }
        let creases: usize = degrees.iter().sum();
        let unknowns = random.whole(1, creases);
        let own = unknowns == creases;
        let mut spokes = Vec::new();
        for degree in &degrees {
            for direction in directions(random, *degree) {
                let group = if own {
                    spokes.len()
                } else {
                    random.whole(0, unknowns - 1)
                };
                let group = GroupId(u32::try_from(group).expect("few"));
                let (sin, cos) = direction.sin_cos();
                spokes.push((group, random.chance(0.5), [cos, sin]));
            }
        }
        let kind = random.whole(0, 9);
        let start = (0..unknowns).map(|_| start(random, kind)).collect();
        let limits = random.chance(0.3).then(|| {
            let bounds = (0..unknowns).map(|_| {
                let lower = -random.uniform(0.0, PI);
                let width = if random.chance(0.1) {
                    0.0
                } else {
                    random.uniform(0.0, PI)
                };
                (lower, lower + width)
            });
            bounds.collect()
        });
        Self {
            degrees,
            unknowns,
            spokes,
            start,
            limits,
        }
    }
}

/// Draws directions of creases, radians, counter-clockwise.
fn directions(random: &mut Random, degree: usize) -> Vec<f64> {
    let mut directions: Vec<f64> = match random.whole(0, 3) {
        // Sectors of any size.
        0 => (0..degree).map(|_| random.uniform(0.0, TAU)).collect(),
        // Sectors down to a billionth of a degree.
        1 => {
            let mut at = random.uniform(0.0, TAU);
            let sectors = (0..degree).map(|_| random.log_uniform(1e-11, PI));
            let sectors: Vec<f64> = sectors.collect();
            let whole: f64 = sectors.iter().sum();
            let turned = sectors.iter().map(|sector| {
                at += sector * TAU / whole;
                at
            });
            turned.collect()
        }
        // Multiples of 15 degrees, some of them equal.
        2 => {
            let fifteen = || f64::from(u8::try_from(random.whole(0, 23)).expect("few"));
            core::iter::repeat_with(fifteen)
                .take(degree)
                .map(|k| k * 15_f64.to_radians())
                .collect()
        }
        // Flat-foldable if the degree is even: alternate sectors add up to half a turn.
        _ => {
            let mut at = random.uniform(0.0, TAU);
            let share: Vec<f64> = (0..degree).map(|_| random.uniform(0.1, 1.0)).collect();
            let sum = |first: usize| share.iter().skip(first).step_by(2).sum::<f64>();
            let halves = [sum(0), sum(1)];
            let turned = share.iter().enumerate().map(|(k, share)| {
                at += share * PI / halves[k % 2];
                at
            });
            turned.collect()
        }
    };
    directions.sort_by(f64::total_cmp);
    directions
}

/// Draws a fold angle to start from, radians.
fn start(random: &mut Random, kind: usize) -> f64 {
    match kind {
        0 => random.sign() * random.log_uniform(1e-300, 1e-3),
        1 => random.sign() * (PI - random.log_uniform(1e-16, 1e-3)),
        2 => random.sign() * PI * if random.chance(0.5) { 1.0 } else { 0.0 },
        3 => random.uniform(-20.0, 20.0),
        4 if random.chance(0.2) => {
            let broken = [f64::NAN, f64::INFINITY, -f64::INFINITY, 1e300, -1e30];
            broken[random.whole(0, broken.len() - 1)]
        }
        5 => random.uniform(-0.5, 0.5),
        _ => random.uniform(-PI, PI),
    }
}

/// The stars of a problem, in the precision `T`.
struct InPrecision<T> {
    spokes: Vec<Spoke<T>>,
    ends: Vec<u32>,
    unknowns: usize,
}

impl<T: Scalar> InPrecision<T> {
    fn of(problem: &Problem) -> Self {
        let mut end = 0;
        let ends = problem.degrees.iter().map(|&degree| {
            end += u32::try_from(degree).expect("few");
            end
        });
        let spokes = problem.spokes.iter();
        Self {
            ends: ends.collect(),
            spokes: spokes
                .map(|&(group, negative, direction)| Spoke {
                    group,
                    negative,
                    direction: direction.map(T::lit),
                })
                .collect(),
            unknowns: problem.unknowns,
        }
    }

    fn view(&self) -> StarsView<'_, T> {
        StarsView::new(&self.spokes, &self.ends, self.unknowns).expect("stars")
    }

    fn stars(&self) -> impl Iterator<Item = &[Spoke<T>]> {
        let mut from = 0;
        self.ends.iter().map(move |&end| {
            let spokes = &self.spokes[from..end as usize];
            from = end as usize;
            spokes
        })
    }

    /// Returns the largest residual by 4x4 matrices.
    fn residual(&self, x: &[T]) -> f64 {
        worst(self.stars().map(|star| residual(&product(turns(star, x)))))
    }
}

/// Returns creases and fold angles of a star for the matrices.
fn turns<T: Scalar>(star: &[Spoke<T>], x: &[T]) -> impl Iterator<Item = (Line, f64)> {
    star.iter().map(|spoke| {
        let [cos, sin] = spoke.direction.map(|part| part.to_f64());
        let length = cos.hypot(sin);
        let line = Line {
            place: Vector2::zeros(),
            direction: [cos / length, sin / length],
        };
        let angle = x[spoke.group.index()].to_f64();
        (line, if spoke.negative { -angle } else { angle })
    })
}

/// Configuration that a solver has found, and its report.
struct Solved<'a, T> {
    report: Report<T>,
    x: &'a [T],
}

impl Stars {
    fn judge<T: Scalar>(&mut self, precision: &str, problem: &Problem, found: &mut Vec<String>) {
        let stars = InPrecision::<T>::of(problem);
        let x: Vec<T> = problem.start.iter().map(|&x| T::lit(x)).collect();
        let sane = problem.start.iter().all(|x| x.abs() < 100.0);
        if sane {
            for star in stars.stars() {
                self.compare(precision, star, &x, found);
            }
        }
        let limits: Option<Vec<(T, T)>> = problem.limits.as_ref().map(|limits| {
            let limits = limits.iter();
            limits.map(|&(a, b)| (T::lit(a), T::lit(b))).collect()
        });
        let limits = limits
            .as_ref()
            .map_or(Limits::HalfTurn, |l| Limits::Each(l));
        let view = stars.view();
        let n = problem.unknowns;
        let mut half = vec![HalfAngle::default(); n];
        let zero = Vector3::new(T::zero(), T::zero(), T::zero());
        let mut columns = vec![zero; view.max_degree()];
        let mut work = vec![T::zero(); 3 * n];
        let mut memory = vec![T::zero(); DenseNormalEquations::<T>::memory(n)];
        let names = if precision == "f64" {
            ["LM dense f64", "gradient f64"]
        } else {
            ["LM dense f32", "gradient f32"]
        };
        for solver in names {
            let mut at = x.clone();
            let mut closing = ClosureProblem::new(view, &mut half, &mut columns).expect("room");
            let options = Options {
                max_iterations: LM_STEPS,
                ..Options::default()
            };
            let report = if solver.starts_with("gradient") {
                let options = Options {
                    max_iterations: GRADIENT_STEPS,
                    ..options
                };
                gradient::solve(&mut closing, limits, &options, &mut at, &mut work)
            } else {
                let mut equations = DenseNormalEquations::new(n, &mut memory).expect("room");
                let work = &mut work;
                levenberg_marquardt::solve(
                    &mut closing,
                    &mut equations,
                    limits,
                    &options,
                    &mut at,
                    work,
                )
            };
            let solved = Solved { report, x: &at };
            let outcome = format!("{:?}", report.outcome);
            *self.outcomes.entry((solver, outcome)).or_default() += 1;
            let wrong = solved.wrong(&stars, limits, &problem.start, &options);
            found.extend(wrong.map(|words| format!("{solver}: {words}")));
        }
    }

    /// Compares closure and Jacobian of a star with those of the matrices.
    fn compare<T: Scalar>(
        &mut self,
        precision: &str,
        star: &[Spoke<T>],
        x: &[T],
        found: &mut Vec<String>,
    ) {
        let mut half = vec![HalfAngle::default(); x.len()];
        closure::half_angles(x, &mut half);
        let zero = Vector3::new(T::zero(), T::zero(), T::zero());
        let mut columns = vec![zero; star.len()];
        let view = StarView { spokes: star };
        let r = closure::residual_and_jacobian(view, &half, &mut columns).expect("room");
        if r != closure::residual(view, &half) {
            found.push(format!("{precision}: the residual depends on the Jacobian"));
        }
        let wide = |v: &Vector3<T>| Vector3::new(v.x.to_f64(), v.y.to_f64(), v.z.to_f64());
        let r = wide(&r);
        let turns: Vec<(Line, f64)> = turns(star, x).collect();
        let l = product(turns.iter().copied());
        let roundings = T::EPSILON.to_f64() * (star.len() as f64 + 4.0);
        let half_turn = (1.0 - r.norm_squared() / 4.0).max(0.0).sqrt();
        // The norm of L - I gives 2 sin(θ/2); the skew part of L gives the axis times sin θ.
        let by_norm = (r.norm() - residual(&l)).abs();
        let by_skew = (r * half_turn - skew(&rotation(&l))).norm();
        // Near half a turn the norm of r hardly changes, but `half_turn`, the root of a small difference, has a large
        // error. The comparison is therefore weighted by `half_turn`, or left out.
        let by_skew = if half_turn < HALF_TURN {
            0.0
        } else {
            by_skew * half_turn
        };
        let error = worst([by_norm, by_skew]) / roundings;
        self.errors[0] = worst([self.errors[0], error]);
        if exceeds(error, ROUNDINGS) {
            found.push(format!(
                "{precision}: residual {r:?} off the matrices' by {error} roundings"
            ));
        }
        let before: Vec<Matrix4<f64>> = prefixes(&turns);
        for (k, (line, angle)) in turns.iter().enumerate() {
            let rest = product(turns[k + 1..].iter().copied());
            let change = rotation(&(before[k] * line.turning(*angle) * rest));
            let sign = if star[k].negative { -1.0 } else { 1.0 };
            let column = wide(&columns[k]) * sign;
            // The derivative is d‖L − I‖² = 2 (L − I) : dL, with ‖L − I‖² = 2 r·r.
            let square = (rotation(&l) - Matrix3::identity()).dot(&change) * 2.0;
            let by_norm = (4.0 * r.dot(&column) - square).abs() / 4.0;
            // The derivative is d(r c), with c = √(1 − r·r / 4).
            let by_skew = if half_turn < HALF_TURN {
                0.0
            } else {
                let skewed = column * half_turn - r * (r.dot(&column) / (4.0 * half_turn));
                // An error of r leads to an error of c that is larger by 1/c. Dividing by c magnifies it by 1/c or more
                // again.
                (skewed - skew(&change)).norm() * half_turn.powi(3)
            };
            let error = worst([by_norm, by_skew]) / roundings;
            self.errors[1] = worst([self.errors[1], error]);
            if exceeds(error, ROUNDINGS) {
                found.push(format!(
                    "{precision}: column {k} off the matrices' by {error} roundings"
                ));
            }
        }
    }
}

/// Returns for each crease the product of the matrices before it.
fn prefixes(turns: &[(Line, f64)]) -> Vec<Matrix4<f64>> {
    let before = turns.iter().scan(Matrix4::identity(), |l, (line, angle)| {
        let here = *l;
        *l *= line.turned(*angle);
        Some(here)
    });
    before.collect()
}

impl<T: Scalar> Solved<'_, T> {
    /// Returns everything that is wrong with the solver's report.
    fn wrong(
        &self,
        stars: &InPrecision<T>,
        limits: Limits<'_, T>,
        start: &[f64],
        options: &Options<T>,
    ) -> impl Iterator<Item = String> {
        let Self { report, x, .. } = self;
        let mut found = Vec::new();
        let broken = start.iter().any(|x| x.is_nan());
        if (report.outcome == Outcome::NotFinite) != broken {
            found.push(format!("{:?} from {start:?}", report.outcome));
        }
        if report.outcome == Outcome::Capacity {
            found.push("too little room, where there is enough".into());
        }
        if !broken {
            if x.iter().any(|x| !x.is_finite()) {
                found.push(format!("{x:?} from numbers"));
            }
            let outside = x.iter().enumerate().find(|&(k, &x)| {
                let (lower, upper) = limits.of(k);
                !(lower..=upper).contains(&x)
            });
            found.extend(outside.map(|(k, x)| format!("unknown {k} beyond its limits at {x}")));
            let degree = stars.stars().map(<[_]>::len).max().unwrap_or(0);
            let rounding = ROUNDINGS * T::EPSILON.to_f64() * (degree as f64 + 4.0);
            let left = stars.residual(x);
            let (said, tolerance) = (report.residual.to_f64(), options.tolerance.to_f64());
            let closed = report.outcome == Outcome::Converged;
            // If a bound proves that the last point closes, the solver does not evaluate it and reports the bound.
            if exceeds(left - said, rounding) || !closed && exceeds(said - left, rounding) {
                found.push(format!("residual {said:e}, by matrices {left:e}"));
            }
            if closed && exceeds(left, tolerance + rounding) {
                found.push(format!("closed, they say, with a residual of {left:e}"));
            }
            if !closed && said <= tolerance {
                found.push(format!("not closed, they say, with a residual of {said:e}"));
            }
        }
        found.into_iter()
    }
}

impl fmt::Display for Stars {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self {
            stars, problems, ..
        } = self;
        let [residual, jacobian] = self.errors;
        writeln!(
            f,
            "{stars} random stars of degree 1 to {DEGREE} in {problems} problems, each in f64 and f32. Residuals \
             within {residual:.2} roundings a crease of those by 4x4 matrices, Jacobians within {jacobian:.2}; \
             {} failures.\n",
            self.failures.len()
        )?;
        writeln!(f, "| solver | outcome | problems |\n|---|---|---|")?;
        for ((solver, outcome), count) in &self.outcomes {
            writeln!(f, "| {solver} | {outcome} | {count} |")?;
        }
        for (seed, words) in self.failures.iter().take(20) {
            writeln!(f, "\nstars, seed {seed}: {words}")?;
        }
        Ok(())
    }
}
