//! Largest σ̇² at each point of a path's grid, by reachability analysis (TOPP-RA).
//!
//! Implements, with x = σ̇² and u = σ̈ constant between the points, Pham, Pham, "A new approach to time-optimal path
//! parameterization based on reachability analysis", IEEE Trans. Robotics 34(3), 2018, with the limits at both ends of
//! an interval, their "interpolation scheme". A backward pass finds the largest x at each point from which the rest of
//! the path can be travelled; a forward pass finds the largest x that the point before reaches.
//!
//! Differs from the source in three respects. Limits are symmetric, so that standing still is always allowed and the
//! controllable sets are [0, K], with no lower end to follow. The linear programme in two unknowns is solved by
//! Newton's method on the amount by which the lower bound on the next x exceeds the upper one, a convex, piecewise
//! linear function. A point may have derivatives from both sides, so that pieces with jumps of ρ' or ρ'' are one path.

/// Limits of each group.
#[derive(Clone, Copy, Debug)]
pub struct RateLimits<'a> {
    /// Largest speed of each group, radians per second.
    pub speeds: &'a [f64],
    /// Largest acceleration of each group, radians per second squared; infinite for none.
    pub accelerations: &'a [f64],
}

/// Largest derivative that counts as 0, as a fraction of the largest on the path.
const STILL_RATIO: f64 = 1e-8;
/// Largest number of steps of Newton's method for a controllable set. The method ends by itself after a handful, each
/// on another pair of limits; rounding may let it creep.
const MAX_NEWTON_STEPS: u32 = 64;
/// Difference of load, as a fraction of the limit, up to which a regime goes on although another limit is nearer to
/// being active: more than rounding.
const SAME_REGIME_RATIO: f64 = 1e-6;

/// The line y = offset + slope x.
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

/// Values that an interval allows for y = σ̇² at its end, given x = σ̇² at its beginning.
struct Reach {
    low: Line,
    high: Line,
    /// Largest x for any y.
    most: f64,
}

/// Active constraint of the motion: a limit of this group.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Regime {
    Speed(usize),
    Acceleration(usize, bool),
}

/// A path with its limits, all of them sound numbers.
pub(crate) struct Problem<'a> {
    /// Parameter σ of each point.
    parameters: &'a [f64],
    /// First and second derivatives ρ' and ρ'' of each group angle by σ, a row a point.
    first: &'a [f64],
    second: &'a [f64],
    limits: RateLimits<'a>,
    groups: usize,
    /// Groups with a limit on their acceleration.
    limited: Vec<usize>,
    /// Derivatives ρ' below this count as 0.
    still: f64,
    /// Largest σ̇² at each point that speeds and rests allow.
    ceiling: Vec<f64>,
}

impl<'a> Problem<'a> {
    /// Returns `None` if nothing moves, a number is not finite, or a limit is not above 0.
    pub(crate) fn new(
        parameters: &'a [f64],
        [first, second]: [&'a [f64]; 2],
        limits: RateLimits<'a>,
    ) -> Option<Self> {
        let RateLimits {
            speeds,
            accelerations,
        } = limits;
        let mut numbers = [parameters, first, second, speeds].into_iter();
        let finite = numbers.all(|numbers| numbers.iter().all(|number| number.is_finite()));
        let positive = speeds.iter().chain(accelerations).all(|limit| *limit > 0.0);
        let largest = first.iter().fold(0.0, |max, d| f64::max(max, d.abs()));
        let moves = parameters.first() < parameters.last() && largest > 0.0;
        if !(finite && positive && moves) {
            return None;
        }
        let accelerations = accelerations.iter().enumerate();
        let mut problem = Self {
            parameters,
            first,
            second,
            limits,
            groups: speeds.len(),
            limited: accelerations
                .filter(|(_, a)| a.is_finite())
                .map(|(g, _)| g)
                .collect(),
            still: STILL_RATIO * largest,
            ceiling: Vec::new(),
        };
        problem.ceiling = problem.speed_ceiling();
        problem.stop();
        Some(problem)
    }

    /// Returns ρ' of all groups at a point.
    fn first(&self, point: usize) -> &'a [f64] {
        &self.first[point * self.groups..][..self.groups]
    }

    /// Returns ρ'' of all groups at a point.
    fn second(&self, point: usize) -> &'a [f64] {
        &self.second[point * self.groups..][..self.groups]
    }

    fn span(&self, point: usize) -> f64 {
        self.parameters[point + 1] - self.parameters[point]
    }

    /// Returns the largest σ̇² at each point that the speeds allow; at points where nothing moves, that of the nearest
    /// points.
    fn speed_ceiling(&self) -> Vec<f64> {
        let of = |point: usize| {
            let rates = self.first(point).iter().zip(self.limits.speeds);
            let moving = rates.filter(|(rate, _)| rate.abs() > self.still);
            moving.fold(f64::INFINITY, |min, (rate, speed)| {
                min.min((speed / rate).powi(2))
            })
        };
        let ceiling: Vec<f64> = (0..self.parameters.len()).map(of).collect();
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

    /// Stops the motion at its ends and at corners.
    fn stop(&mut self) {
        if self.limited.is_empty() {
            return;
        }
        let last = self.parameters.len() - 1;
        let corners = (0..last).filter(|&k| self.span(k) <= 0.0 && !self.joins(k));
        let corners = corners.flat_map(|k| [k, k + 1]);
        for point in [0, last].into_iter().chain(corners).collect::<Vec<_>>() {
            // If no group moves with σ at a point, hinges rest there at any σ̇.
            if self
                .limited
                .iter()
                .any(|&g| self.first(point)[g].abs() > self.still)
            {
                self.ceiling[point] = 0.0;
            }
        }
    }

    /// Returns `true` if a point given twice, first as number `point`, has one ρ' for all groups with limited
    /// accelerations.
    fn joins(&self, point: usize) -> bool {
        let (left, right) = (self.first(point), self.first(point + 1));
        self.limited
            .iter()
            .all(|&g| (left[g] - right[g]).abs() <= self.still)
    }

    /// Returns, for each limited group and each end of the interval after `point`, the group and the (α, β) of its
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

    /// Returns the bounds on y, up to `top`, that are active at x in the interval after `point`.
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

    /// Returns the largest x at `point` from which the interval after it leads to some y up to `top`.
    fn controllable(&self, point: usize, top: f64) -> f64 {
        let mut x = self.ceiling[point];
        for _ in 0..MAX_NEWTON_STEPS {
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

    /// Returns the largest σ̇² at each point.
    pub(crate) fn fastest(&self) -> Vec<f64> {
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

    /// Returns the points at which the regime changes.
    pub(crate) fn switches(&self, squares: &[f64]) -> Vec<usize> {
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
            if same < most.0 - SAME_REGIME_RATIO {
                switches.extend(regime.map(|_| k));
                regime = most.1;
            }
        }
        switches
    }

    /// Returns the fractions of the limits that are used in the interval after `point`: of each speed on both ends, of
    /// each acceleration at either end.
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
