//! The objective that all peers minimise: ½‖r‖² over all stars, with its residuals and its derivatives.
//!
//! A peer is stopped at the first configuration whose closure is within the tolerance, or when its time is over,
//! whatever its own stopping tests say. No peer pays for a step that it does not need.

use core::time::Duration;
use std::time::Instant;

use foldpath_core::{HalfAngle, StarsView, closure};
use nalgebra::Vector3;

/// Step of a forward difference, radians: the square root of the machine precision.
const DIFFERENCE: f64 = 1.5e-8;
/// Number of spokes that are evaluated between two readings of the clock.
const SPOKES_PER_LOOK: usize = 2_000;

/// Error value that stops a peer: closure is within the tolerance, or time is over.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Stopped;

/// Evaluates the objective, counts evaluations, and keeps the best configuration.
#[derive(Debug)]
pub(super) struct Evaluator<'a> {
    stars: StarsView<'a, f64>,
    half: Vec<HalfAngle<f64>>,
    columns: Vec<Vector3<f64>>,
    probe: Vec<f64>,
    square_of_tolerance: f64,
    deadline: Instant,
    evaluations_per_look: u32,
    /// Number of evaluations since the last reading of the clock.
    unlooked: u32,
    stopped: bool,
    best_square: f64,
    /// Configuration with the smallest closure residual so far.
    pub(super) best: Vec<f64>,
    /// Number of evaluations without derivatives.
    pub(super) values: u64,
    /// Number of evaluations of a gradient or a Jacobian.
    pub(super) derivatives: u64,
}

impl<'a> Evaluator<'a> {
    /// Creates an evaluator; its time runs from [`start`](Self::start) on.
    pub(super) fn new(stars: StarsView<'a, f64>, tolerance: f64) -> Self {
        let n = stars.unknowns();
        let spokes: usize = stars.iter().map(|star| star.spokes.len()).sum();
        Self {
            half: vec![HalfAngle::default(); n],
            columns: vec![Vector3::zeros(); stars.max_degree()],
            probe: vec![0.0; n],
            square_of_tolerance: tolerance * tolerance,
            deadline: Instant::now(),
            evaluations_per_look: u32::try_from(SPOKES_PER_LOOK / spokes.max(1)).unwrap_or(1),
            unlooked: 0,
            stopped: false,
            best_square: f64::INFINITY,
            best: vec![0.0; n],
            values: 0,
            derivatives: 0,
            stars,
        }
    }

    /// Starts the clock, and returns the time of the start.
    pub(super) fn start(&mut self, limit: Duration) -> Instant {
        let now = Instant::now();
        self.deadline = now + limit;
        now
    }

    /// Returns the number of residuals.
    pub(super) fn rows(&self) -> usize {
        3 * self.stars.len()
    }

    /// Returns the objective.
    pub(super) fn value(&mut self, x: &[f64]) -> Result<f64, Stopped> {
        self.values += 1;
        let (sum, largest) = self.squares(x);
        self.see(x, largest)?;
        Ok(0.5 * sum)
    }

    /// Writes the gradient to `gradient` and returns the objective.
    pub(super) fn gradient(&mut self, x: &[f64], gradient: &mut [f64]) -> Result<f64, Stopped> {
        self.derivatives += 1;
        gradient.fill(0.0);
        closure::half_angles(x, &mut self.half);
        let (mut sum, mut largest) = (0.0, 0.0_f64);
        for star in self.stars.iter() {
            let columns = &mut self.columns[..star.spokes.len()];
            let residual = closure::residual_and_jacobian(star, &self.half, columns);
            let residual = residual.unwrap_or_default();
            for (spoke, column) in star.spokes.iter().zip(columns) {
                gradient[spoke.group.index()] += column.dot(&residual);
            }
            let square = residual.dot(&residual);
            sum += square;
            largest = larger(largest, square);
        }
        self.see(x, largest)?;
        Ok(0.5 * sum)
    }

    /// Writes the gradient by forward differences to `gradient` and returns the objective, as for a user without
    /// derivatives.
    pub(super) fn differences(&mut self, x: &[f64], gradient: &mut [f64]) -> Result<f64, Stopped> {
        let value = self.value(x)?;
        let mut probe = core::mem::take(&mut self.probe);
        probe.copy_from_slice(x);
        for (k, slope) in gradient.iter_mut().enumerate() {
            probe[k] = x[k] + DIFFERENCE;
            self.values += 1;
            let (sum, _) = self.squares(&probe);
            *slope = (0.5 * sum - value) / (probe[k] - x[k]);
            probe[k] = x[k];
            if self.is_late() {
                self.stopped = true;
                break;
            }
        }
        self.probe = probe;
        if self.stopped {
            Err(Stopped)
        } else {
            Ok(value)
        }
    }

    /// Writes all residuals to `out`.
    pub(super) fn residuals(&mut self, x: &[f64], out: &mut [f64]) -> Result<(), Stopped> {
        self.values += 1;
        closure::half_angles(x, &mut self.half);
        let mut largest = 0.0_f64;
        for (star, out) in self.stars.iter().zip(out.chunks_exact_mut(3)) {
            let residual = closure::residual(star, &self.half);
            out.copy_from_slice(residual.as_slice());
            largest = larger(largest, residual.dot(&residual));
        }
        self.see(x, largest)
    }

    /// Hands the derivatives of all residuals to `add`, each with its row and unknown. If two spokes share an unknown,
    /// their entries have to be added.
    pub(super) fn jacobian(&mut self, x: &[f64], mut add: impl FnMut(usize, usize, f64)) {
        self.derivatives += 1;
        closure::half_angles(x, &mut self.half);
        for (index, star) in self.stars.iter().enumerate() {
            let columns = &mut self.columns[..star.spokes.len()];
            if closure::residual_and_jacobian(star, &self.half, columns).is_none() {
                continue;
            }
            for (spoke, column) in star.spokes.iter().zip(columns) {
                for (row, &entry) in column.iter().enumerate() {
                    add(3 * index + row, spoke.group.index(), entry);
                }
            }
        }
    }

    /// Returns the sum and the largest of the stars' squared residuals.
    fn squares(&mut self, x: &[f64]) -> (f64, f64) {
        closure::half_angles(x, &mut self.half);
        let squares = self.stars.iter().map(|star| {
            let residual = closure::residual(star, &self.half);
            residual.dot(&residual)
        });
        squares.fold((0.0, 0.0), |(sum, most), square| {
            (sum + square, larger(most, square))
        })
    }

    fn see(&mut self, x: &[f64], largest: f64) -> Result<(), Stopped> {
        if self.stopped {
            return Err(Stopped);
        }
        if largest < self.best_square {
            self.best_square = largest;
            self.best.copy_from_slice(x);
        }
        self.stopped = largest <= self.square_of_tolerance || self.is_late();
        if self.stopped { Err(Stopped) } else { Ok(()) }
    }

    fn is_late(&mut self) -> bool {
        self.unlooked += 1;
        if self.unlooked < self.evaluations_per_look {
            return false;
        }
        self.unlooked = 0;
        Instant::now() >= self.deadline
    }
}

/// Returns the larger square; infinite if either is not finite, so that it never counts as closed.
fn larger(a: f64, b: f64) -> f64 {
    if a.is_finite() && b.is_finite() {
        a.max(b)
    } else {
        f64::INFINITY
    }
}
