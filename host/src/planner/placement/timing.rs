//! Time-optimal speed along a given path.
//!
//! A path is geometry: group angles ρ(σ). The motion along it is σ(t), the same parameter for all
//! hinges, found here as the fastest one with |ρ̇ᵢ| and |ρ̈ᵢ| within limits. With x = σ̇² and u = σ̈ the
//! hinges move at
//!
//! ```text
//! ρ̇ᵢ² = ρᵢ'² x,   ρ̈ᵢ = ρᵢ'' x + ρᵢ' u,   dx/dσ = 2u,
//! ```
//!
//! linear in x and u (Bobrow, Dubowsky, Gibson, "Time-optimal control of robotic manipulators along
//! specified paths", Int. J. Robotics Research 4(3), 1985; Shin, McKay, IEEE Trans. Automatic Control
//! 30(6), 1985). `reachability.rs` finds the largest x at each point of a grid.

use super::reachability::Problem;
pub use super::reachability::RateLimits;

/// Motion along a path: σ̇² is linear in σ between the points of the grid.
#[derive(Clone, Debug, PartialEq)]
pub struct OptimalTimeLaw {
    parameters: Vec<f64>,
    /// σ̇² at each point.
    squares: Vec<f64>,
    times: Vec<f64>,
    switches: Vec<usize>,
}

impl OptimalTimeLaw {
    /// Computes the fastest motion along a path within limits. The path is sampled at `parameters`, values of σ in
    /// increasing order; `derivatives` are the first and second derivatives ρ' and ρ'' of each group angle by σ, a row a
    /// point. A point with different derivatives on its two sides is given twice, with the left ones first. The motion
    /// passes such a point without stopping if the two ρ' agree.
    ///
    /// Hinges with a limit on their acceleration rest at both
    /// ends. Returns `None` if nothing moves, a number is not finite, a limit is not above 0, or the motion would rest at
    /// one point and the next with no point between them to move at.
    ///
    /// Cost: proportional to points times groups. The duration exceeds the least one to first order in the grid where
    /// ρ' varies, since the limits hold at both ends of each interval with one u; within the intervals the limits are
    /// exceeded to second order. At a point where ρ' vanishes for all groups, limits on the speed alone allow an
    /// infinite σ̇: the motion takes the σ̇ of the nearest point, and is the farther from the fastest the faster ρ'
    /// goes to 0.
    ///
    /// # Panics
    /// If the lengths of the slices do not agree.
    #[must_use]
    pub fn time_optimal(
        parameters: &[f64],
        derivatives: [&[f64]; 2],
        limits: RateLimits<'_>,
    ) -> Option<Self> {
        let problem = Problem::new(parameters, derivatives, limits)?;
        let squares = problem.fastest();
        let mut times = vec![0.0; squares.len()];
        for (k, (sigma, x)) in parameters.windows(2).zip(squares.windows(2)).enumerate() {
            let span = duration(sigma[1] - sigma[0], x[0], x[1]);
            if !span.is_finite() {
                return None;
            }
            times[k + 1] = times[k] + span;
        }
        Some(Self {
            parameters: parameters.to_vec(),
            switches: problem.switches(&squares),
            squares,
            times,
        })
    }

    /// Returns the parameter σ of each point of the grid.
    #[must_use]
    pub fn parameters(&self) -> &[f64] {
        &self.parameters
    }

    /// Returns the time at each point of the grid, seconds since the start.
    #[must_use]
    pub fn times(&self) -> &[f64] {
        &self.times
    }

    /// Returns the speed σ̇ at each point of the grid, per second.
    pub fn speeds(&self) -> impl ExactSizeIterator<Item = f64> {
        self.squares.iter().map(|x| x.sqrt())
    }

    /// Returns the points of the grid at which another limit, or the same limit in the other direction, becomes the
    /// active constraint.
    #[must_use]
    pub fn switches(&self) -> &[usize] {
        &self.switches
    }

    /// Returns the seconds from start to end.
    #[must_use]
    pub fn duration(&self) -> f64 {
        self.times.last().copied().unwrap_or(0.0)
    }

    /// Returns the seconds since the start at σ, which is clamped to the path. Cost: a binary search.
    #[must_use]
    pub fn time_at(&self, sigma: f64) -> f64 {
        let (k, sigma) = interval(&self.parameters, sigma);
        self.times[k]
            + duration(
                sigma - self.parameters[k],
                self.squares[k],
                self.square(k, sigma),
            )
    }

    /// Returns the speed σ̇ at σ, per second; at a point given twice, just after it. Cost: a binary search.
    #[must_use]
    pub fn speed_at(&self, sigma: f64) -> f64 {
        let (k, sigma) = interval(&self.parameters, sigma);
        self.square(k, sigma).sqrt()
    }

    /// Returns σ̇² at σ in the interval after point k.
    fn square(&self, k: usize, sigma: f64) -> f64 {
        let (from, to) = (self.parameters[k], self.parameters[k + 1]);
        if to > from {
            let part = (sigma - from) / (to - from);
            self.squares[k] * (1.0 - part) + self.squares[k + 1] * part
        } else {
            self.squares[k + 1]
        }
    }
}

/// Returns the interval of a non-decreasing grid that contains a value, by the point at which it begins, and the value
/// clamped to the grid. A NaN is taken to the first point.
fn interval(grid: &[f64], value: f64) -> (usize, f64) {
    let (first, last) = (grid[0], grid[grid.len() - 1]);
    let value = value.max(first).min(last);
    let behind = grid.partition_point(|&point| point <= value);
    (behind.clamp(1, grid.len() - 1) - 1, value)
}

/// Returns the seconds for a distance `span` in σ on which σ̇² changes linearly from `from` to `to`.
fn duration(span: f64, from: f64, to: f64) -> f64 {
    if span > 0.0 {
        2.0 * span / (from.sqrt() + to.sqrt())
    } else {
        0.0
    }
}
