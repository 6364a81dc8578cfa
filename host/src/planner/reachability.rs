//! Largest σ̇² at each point of a path's grid, by reachability analysis.
//!
//! Implements, with x = σ̇² and u = σ̈ constant between the points, Pham, Pham, "A new approach to
//! time-optimal path parameterization based on reachability analysis", IEEE Trans. Robotics 34(3), 2018,
//! with the limits at both ends of an interval, their "interpolation scheme". Backward, the largest x at
//! each point from which the rest can be gone; forward, the largest x that the last one reaches.
//!
//! Differs from the source: limits are symmetric, so that standing still is always allowed and the
//! controllable sets are [0, K], with no lower end to follow; their linear programme in two unknowns is
//! solved by Newton's method on the convex, piecewise linear width of what is forbidden; and a point may
//! have derivatives from both sides, so that pieces with jumps of ρ' or ρ'' are one path.

use super::timing::{RateLimits, Rests, SampledPath, TimingError};

/// Derivatives below this part of the largest on the path count as 0.
const STILL: f64 = 1e-8;
/// Steps of Newton's method for a controllable set. It ends by itself after a handful, each on another
/// pair of limits; rounding may let it creep.
const STEPS: u32 = 64;
/// Part of its limit up to which a regime goes on though another is nearer to its own limit: more than
/// rounding.
const SAME_REGIME: f64 = 1e-6;

/// y = offset + slope x.
#[derive(Clone, Copy)]
struct Line {
    offset: f64,
    slope: f64,
}

impl Line {
    fn at(self, x: f64) -> f64 {
        self.offset + self.slope * x
    }
}

/// What an interval allows for y = σ̇² at its end, given x = σ̇² at its beginning.
struct Reach {
    low: Line,
    high: Line,
    /// Largest x, whatever y.
    most: f64,
}

/// What holds the motion back.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Regime {
    Speed(usize),
    Acceleration(usize, bool),
}

/// A path with its limits, checked.
pub(super) struct Problem<'a> {
    path: SampledPath<'a>,
    limits: RateLimits<'a>,
    groups: usize,
    /// Groups with a limit on their acceleration.
    limited: Vec<usize>,
    /// Derivatives ρ' below this count as 0.
    still: f64,
    /// Largest σ̇² at each point by the speeds and rests.
    ceiling: Vec<f64>,
}

impl<'a> Problem<'a> {
    pub(super) fn new(
        path: SampledPath<'a>,
        limits: RateLimits<'a>,
        rests: Rests<'_>,
    ) -> Result<Self, TimingError> {
        check(path, limits, rests)?;
        let accelerations = limits.accelerations.iter().enumerate();
        let largest = path.first.iter().fold(0.0, |max, d| f64::max(max, d.abs()));
        if path.parameters.first() >= path.parameters.last() || largest <= 0.0 {
            return Err(TimingError::NoMotion);
        }
        let mut problem = Self {
            path,
            limits,
            groups: limits.speeds.len(),
            limited: accelerations
                .filter(|(_, a)| a.is_finite())
                .map(|(g, _)| g)
                .collect(),
            still: STILL * largest,
            ceiling: Vec::new(),
        };
        problem.ceiling = problem.speed_ceiling();
        problem.stop(rests);
        Ok(problem)
    }

    /// ρ' of all groups at a point.
    fn first(&self, point: usize) -> &'a [f64] {
        &self.path.first[point * self.groups..][..self.groups]
    }

    /// ρ'' of all groups at a point.
    fn second(&self, point: usize) -> &'a [f64] {
        &self.path.second[point * self.groups..][..self.groups]
    }

    fn span(&self, point: usize) -> f64 {
        self.path.parameters[point + 1] - self.path.parameters[point]
    }

    /// Largest σ̇² at each point by the speeds; that of the nearest points where nothing moves.
    fn speed_ceiling(&self) -> Vec<f64> {
        let of = |point: usize| {
            let rates = self.first(point).iter().zip(self.limits.speeds);
            let moving = rates.filter(|(rate, _)| rate.abs() > self.still);
            moving.fold(f64::INFINITY, |min, (rate, speed)| {
                min.min((speed / rate).powi(2))
            })
        };
        let ceiling: Vec<f64> = (0..self.path.parameters.len()).map(of).collect();
        let nearest = |last: &mut f64, x: f64| {
            *last = if x.is_finite() { x } else { *last };
            Some(*last)
        };
        let left: Vec<f64> = ceiling.iter().copied().scan(0.0, nearest).collect();
        let right = ceiling.iter().copied().rev().scan(0.0, nearest);
        let mut filled: Vec<f64> = right.collect();
        filled.reverse();
        filled.iter().zip(&left).map(|(a, b)| a.max(*b)).collect()
    }

    /// Stops the motion at rests and at corners.
    fn stop(&mut self, rests: Rests<'_>) {
        if self.limited.is_empty() {
            return;
        }
        let last = self.path.parameters.len() - 1;
        let ends = [rests.start.then_some(0), rests.end.then_some(last)];
        let corners = (0..last).filter(|&k| self.span(k) <= 0.0 && !self.joins(k));
        let stops: Vec<usize> = ends
            .into_iter()
            .flatten()
            .chain(corners.flat_map(|k| [k, k + 1]))
            .collect();
        for point in stops {
            // Where nothing moves by σ, hinges rest at any σ̇.
            if self
                .limited
                .iter()
                .any(|&g| self.first(point)[g].abs() > self.still)
            {
                self.ceiling[point] = 0.0;
            }
        }
        for &corner in rests.corners {
            self.ceiling[corner] = 0.0;
        }
    }

    /// Whether a point given twice, first as number `point`, has one ρ' where accelerations are limited.
    fn joins(&self, point: usize) -> bool {
        let (left, right) = (self.first(point), self.first(point + 1));
        self.limited
            .iter()
            .all(|&g| (left[g] - right[g]).abs() <= self.still)
    }

    /// For each limited group and end of the interval behind `point`: its number and (α, β) of its
    /// acceleration α x + β y.
    fn accelerations(&self, point: usize) -> impl Iterator<Item = (usize, f64, f64)> {
        let step = 1.0 / (2.0 * self.span(point));
        let (d0, d1) = (self.first(point), self.first(point + 1));
        let (c0, c1) = (self.second(point), self.second(point + 1));
        self.limited.iter().flat_map(move |&g| {
            let (u0, u1) = (d0[g] * step, d1[g] * step);
            [(g, c0[g] - u0, u0), (g, -u1, c1[g] + u1)]
        })
    }

    /// What the interval behind `point` allows at x, for y up to `top`: the limits nearest there.
    fn reach(&self, point: usize, x: f64, top: f64) -> Reach {
        let mut low = Line {
            offset: 0.0,
            slope: 0.0,
        };
        let mut high = Line {
            offset: top,
            slope: 0.0,
        };
        let mut most = f64::INFINITY;
        for (group, alpha, beta) in self.accelerations(point) {
            let limit = self.limits.accelerations[group];
            if beta.abs() * top <= f64::EPSILON * limit {
                most = most.min(limit / alpha.abs());
                continue;
            }
            let (width, slope) = (limit / beta.abs(), -alpha / beta);
            if slope * x - width > low.at(x) {
                low = Line {
                    offset: -width,
                    slope,
                };
            }
            if slope * x + width < high.at(x) {
                high = Line {
                    offset: width,
                    slope,
                };
            }
        }
        Reach { low, high, most }
    }

    /// Largest x at `point` from which the interval behind it leads to some y up to `top`.
    fn controllable(&self, point: usize, top: f64) -> f64 {
        let mut x = self.ceiling[point];
        for _ in 0..STEPS {
            let Reach { low, high, most } = self.reach(point, x, top);
            let next = if low.at(x) > high.at(x) {
                (high.offset - low.offset) / (low.slope - high.slope)
            } else {
                x
            };
            let next = next.min(most).max(0.0);
            if next.is_nan() || next >= x {
                break;
            }
            x = next;
        }
        x
    }

    /// Largest σ̇² at each point.
    pub(super) fn fastest(&self) -> Vec<f64> {
        let mut squares = self.ceiling.clone();
        if self.limited.is_empty() {
            return squares;
        }
        for k in (0..squares.len() - 1).rev() {
            let top = squares[k + 1];
            if self.span(k) > 0.0 {
                squares[k] = self.controllable(k, top);
            } else if self.joins(k) {
                squares[k] = squares[k].min(top);
            }
        }
        for k in 0..squares.len() - 1 {
            let (x, top) = (squares[k], squares[k + 1]);
            if self.span(k) > 0.0 {
                squares[k + 1] = self.reach(k, x, top).high.at(x).max(0.0);
            } else if self.joins(k) {
                squares[k + 1] = x.min(top);
            }
        }
        squares
    }

    /// Points at which the regime changes.
    pub(super) fn switches(&self, squares: &[f64]) -> Vec<usize> {
        let mut switches = Vec::new();
        let mut regime = None;
        for k in (0..squares.len() - 1).filter(|&k| self.span(k) > 0.0) {
            let (x, y) = (squares[k], squares[k + 1]);
            let loads = self.loads(k, x, y);
            let mut most = (0.0, None);
            let mut same = 0.0;
            for (load, kind) in loads {
                if load > most.0 {
                    most = (load, Some(kind));
                }
                if Some(kind) == regime {
                    same = f64::max(same, load);
                }
            }
            if same < most.0 - SAME_REGIME {
                switches.extend(regime.map(|_| k));
                regime = most.1;
            }
        }
        switches
    }

    /// Parts of the limits that are used in the interval behind `point`: of the speed on both ends, of
    /// the acceleration on each.
    fn loads(&self, point: usize, x: f64, y: f64) -> impl Iterator<Item = (f64, Regime)> {
        let (from, to) = (self.first(point), self.first(point + 1));
        let speeds = self
            .limits
            .speeds
            .iter()
            .enumerate()
            .map(move |(g, limit)| {
                let speed = f64::min(from[g].abs() * x.sqrt(), to[g].abs() * y.sqrt());
                (speed / limit, Regime::Speed(g))
            });
        let accelerations = self.accelerations(point).map(move |(g, alpha, beta)| {
            let acceleration = alpha * x + beta * y;
            let load = acceleration.abs() / self.limits.accelerations[g];
            (load, Regime::Acceleration(g, acceleration > 0.0))
        });
        speeds.chain(accelerations)
    }
}

fn check(
    path: SampledPath<'_>,
    limits: RateLimits<'_>,
    rests: Rests<'_>,
) -> Result<(), TimingError> {
    let (points, groups) = (path.parameters.len(), limits.speeds.len());
    let values = points.checked_mul(groups);
    let whole = [path.first.len(), path.second.len()]
        .iter()
        .all(|&len| Some(len) == values);
    let inside = rests.corners.iter().all(|&corner| corner < points);
    if points < 2 || groups == 0 || !whole || limits.accelerations.len() != groups || !inside {
        return Err(TimingError::Shape);
    }
    let sound = |(speed, acceleration): (&f64, &f64)| {
        *speed > 0.0 && speed.is_finite() && *acceleration > 0.0
    };
    if let Some(group) = limits
        .speeds
        .iter()
        .zip(limits.accelerations)
        .position(|pair| !sound(pair))
    {
        return Err(TimingError::Limit(group));
    }
    let finite = |values: &[f64]| values.iter().all(|v| v.is_finite());
    let rows = path.first.chunks(groups).zip(path.second.chunks(groups));
    let sound = |((first, second), sigma): ((&[f64], &[f64]), &f64)| {
        finite(first) && finite(second) && sigma.is_finite()
    };
    if let Some(point) = rows.zip(path.parameters).position(|row| !sound(row)) {
        return Err(TimingError::NotFinite(point));
    }
    match path
        .parameters
        .windows(2)
        .position(|pair| pair[1] < pair[0])
    {
        Some(point) => Err(TimingError::Order(point + 1)),
        None => Ok(()),
    }
}
