//! Derivatives of a rigid motion: how do fold angles and folded vertices change with the drivers and with the pattern?
//!
//! On a closed configuration θ of a pattern V, motions and changes of the pattern that keep closure satisfy
//! J dθ + K dV = 0 to first order. The *drivers* are hinges whose angles determine all others. Their *motions* N are the
//! solutions of J dθ = 0 with one driver turning by 1 and the others at rest. With the drivers at rest,
//! dθ = -J⁺ K dV. Most tessellations have more conditions than rank, so that a pattern that is changed at will does not fold
//! any more: the residual (I - J J⁺) K dV says by how much, and such a change is refused.
//!
//! At a *singular* configuration, as flat or where a motion branches, more motions keep closure to first order than near by.
//! Derivatives do not exist there, and [`Sensitivity::at`] refuses. It recognises them by a closed configuration close by, at
//! which fewer motions keep closure.
//!
//! ```
//! use foldpath::generate::Miura;
//! use foldpath::pattern::CreasePattern;
//! use foldpath::sensitivity::{Conditions, Sensitivity};
//! use nalgebra::Vector2;
//!
//! let miura = Miura { rows: 2, columns: 2, sector_angle: 60_f64.to_radians(), fold: 0.5 };
//! let pattern = CreasePattern::new(miura.drawing()?)?;
//! let angles: Vec<f64> = pattern.creases().iter().filter_map(|&edge| pattern.edge(edge).goal).collect();
//! let conditions = Conditions::new(&pattern).ok_or("too large")?;
//! let mut at = Sensitivity::at(&conditions, &angles)?;
//! assert_eq!(at.drivers().len(), 1);
//! // The derivative by the y of the inner vertex, with the driver at rest.
//! let mut change = vec![Vector2::zeros(); 9];
//! change[4].y = 1.0;
//! let rates = at.jvp(&change, &[0.0])?;
//! assert!(rates.angles[at.drivers()[0].index()].abs() < 1e-12);
//! // The same number by the product from the other side.
//! let mut of_first = vec![0.0; 4];
//! of_first[0] = 1.0;
//! let gradient = at.vjp(&of_first, &[]);
//! assert!((gradient.vertices[4].y - rates.angles[0]).abs() < 1e-9);
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```
//!
//! [`Tolerance`] answers how exactly a sheet has to be made, [`Loads`] how strong its drives have to be, and [`skew_bound`] how
//! far apart in time its boards may be.

mod conditions;
mod loads;
mod null_space;
mod places;
mod skew;
mod tolerance;

use nalgebra::{DMatrix, Vector2, Vector3};
use thiserror::Error;

pub use conditions::Conditions;
use conditions::{Linearised, NormalFactor, magnitude, times, transposed};
pub use loads::{Drive, Load, Loads, NoLoads, Peak, REGULAR, STANDARD_GRAVITY};
use null_space::NullSpace;
use places::{FoldedSheet, PatternRates};
pub use skew::{skew_bound, skew_residual, skew_residual_of_sheet};
pub use tolerance::{FROM_DEG, HingePlay, NoTolerance, PlayKind, Tolerance};

use crate::motion::Motion;
use crate::pattern::CreaseId;
use crate::util::nan_max::largest;

/// Singular values of J up to this one count as 0: a few roundings of J, and what closure to rounded coordinates leaves.
const NULL: f64 = 1e-7;
/// Singular values up to this many residuals count as 0 as well: conditions that fail to close by an error have derivatives
/// that are wrong by as much.
const NULL_RESIDUALS: f64 = 30.0;
/// Ratio of the smallest regular singular value to the largest that counts as 0. In between nothing can be said.
const REGULAR_RATIO: f64 = 100.0;
/// Largest residual of a configuration that counts as closed.
const CLOSED: f64 = 1e-5;
/// Largest number of Newton steps that close a configuration.
const MAX_STEPS: usize = 20;
/// Largest step that ends them, radians.
const LAST_STEP_RAD: f64 = 1e-13;
/// Largest turn of a hinge by which a configuration may be off closure, radians.
const MAX_CLOSING_RAD: f64 = 0.1;
/// Turn of the hinge that turns most, from a configuration to the one at which it is compared, radians.
const PROBE_RAD: f64 = 1e-3;
/// Largest difference of a driver from the angle that it was given, radians.
const DRIVEN_RAD: f64 = 1e-12;
/// Largest turn of a driver in one step towards the angle that it was given, radians: half of [`MAX_CLOSING_RAD`].
const MAX_DRIVEN_STEP_RAD: f64 = 0.05;
/// Part of a change's effect on closure that may be left: rounding.
const LEFT_RATIO: f64 = 1e-6;

/// Part of a sum of products that may be rounding.
const ROUNDING_RATIO: f64 = 1e-12;

/// Derivatives of a sheet at a closed configuration.
pub struct Sensitivity<'c> {
    conditions: &'c Conditions<'c>,
    angles: Vec<f64>,
    linearised: Linearised,
    factor: NormalFactor<'c>,
    null_space: NullSpace,
    drivers: Vec<CreaseId>,
    /// N: a row for each crease, a column for each driver.
    motions: DMatrix<f64>,
    /// Largest residual of the conditions.
    residual: f64,
}

/// Rates of a sheet.
#[derive(Clone, Debug, PartialEq)]
pub struct Rates {
    /// Rate of each crease's fold angle, radians.
    pub angles: Vec<f64>,
    /// Rate of each folded vertex as its first face places it, units of the sheet. The first face of the spanning tree keeps
    /// its pose.
    pub places: Vec<Vector3<f64>>,
}

/// Gradient of a number.
#[derive(Clone, Debug, PartialEq)]
pub struct Gradient {
    /// By each vertex of the pattern. It holds for changes with which the pattern still folds.
    pub vertices: Vec<Vector2<f64>>,
    /// By the angle of each driver.
    pub drivers: Vec<f64>,
}

/// Reason why there is no derivative.
#[derive(Clone, Copy, Debug, PartialEq, Error)]
#[non_exhaustive]
pub enum NoDerivative {
    /// The configuration is not closed, and no closed one is close by.
    #[error("the configuration does not close (residual {residual:.1e})")]
    Open {
        /// Largest closure residual.
        residual: f64,
    },
    /// More motions keep closure to first order than at configurations close by.
    #[error(
        "the configuration is singular (smallest singular value {value:.1e}): the drivers do not determine the other hinges \
         there, as in the flat sheet"
    )]
    Singular {
        /// The smallest singular value of the Jacobian that is not 0 close by.
        value: f64,
    },
    /// The change leads to a pattern that does not fold.
    #[error(
        "the changed pattern does not fold: of its effect on closure, {of:.1e} radians, {residual:.1e} are left"
    )]
    LeavesFoldability {
        /// Norm of what no motion takes up, radians.
        residual: f64,
        /// Norm of the effect of the change on closure, radians.
        of: f64,
    },
    /// The hinges that were given do not drive the sheet.
    #[error(
        "the drivers that are given do not determine the other hinges: expected {size} hinges that do"
    )]
    NotDrivers {
        /// Number of drivers that the sheet needs.
        size: usize,
    },
}

/// A closed configuration with its conditions.
struct Closing<'c> {
    angles: Vec<f64>,
    linearised: Linearised,
    factor: NormalFactor<'c>,
    /// Largest residual.
    residual: f64,
}

impl<'c> Closing<'c> {
    /// Closes a configuration by least moves.
    fn near(conditions: &'c Conditions<'_>, start: &[f64]) -> Result<Self, NoDerivative> {
        let mut angles = start.to_vec();
        for step in 0..=MAX_STEPS {
            let open = NoDerivative::Open { residual: f64::NAN };
            let linearised = conditions.at(&angles).ok_or(open)?;
            let residual = largest(linearised.residuals.iter().map(Vector3::norm));
            let open = NoDerivative::Open { residual };
            let mut factor = conditions.factorise(&linearised.by_angle).ok_or(open)?;
            let mut moves = transposed(&linearised.by_angle, &linearised.residuals, angles.len());
            factor.solve(&mut moves);
            let longest = largest(moves.iter().map(|by| by.abs()));
            if longest <= LAST_STEP_RAD || step == MAX_STEPS {
                let closed = Self {
                    angles,
                    linearised,
                    factor,
                    residual,
                };
                return if residual <= CLOSED {
                    Ok(closed)
                } else {
                    Err(open)
                };
            }
            angles
                .iter_mut()
                .zip(moves)
                .for_each(|(angle, by)| *angle -= by);
            let turned = angles.iter().zip(start).map(|(a, b)| (a - b).abs());
            // NaN is not near.
            let is_near = largest(turned) <= MAX_CLOSING_RAD;
            if !is_near {
                return Err(open);
            }
        }
        Err(NoDerivative::Open { residual: f64::NAN })
    }

    /// Returns the singular value up to which all count as 0.
    fn tolerance(&self) -> f64 {
        NULL.max(NULL_RESIDUALS * self.residual)
    }

    /// Finds the motions that keep closure to first order.
    fn null_space(&mut self) -> NullSpace {
        let tolerance = self.tolerance();
        NullSpace::find(
            &self.linearised,
            &mut self.factor,
            self.angles.len(),
            tolerance,
        )
    }

    /// Returns the reason why derivatives do not exist here, if there is one.
    fn flaw(&self, null_space: &NullSpace, conditions: &'c Conditions<'_>) -> Option<NoDerivative> {
        let NullSpace { next, values, .. } = null_space;
        let is_clear = *next > REGULAR_RATIO * self.tolerance();
        if !is_clear {
            return Some(NoDerivative::Singular { value: *next });
        }
        let dimension = null_space.dimension();
        if dimension == 0 {
            return None;
        }
        // Close by, along a random motion that keeps closure here.
        let motion = null_space.random_motion();
        let there = self.angles.iter().zip(motion.iter());
        let there: Vec<f64> = there.map(|(angle, by)| angle + PROBE_RAD * by).collect();
        let there = Self::near(conditions, &there);
        let kept = there.map_or(0, |mut there| there.null_space().dimension());
        (kept < dimension).then(|| NoDerivative::Singular {
            value: values.get(kept).copied().unwrap_or(0.0),
        })
    }
}

impl<'c> Sensitivity<'c> {
    /// Returns the derivatives at the closed configuration nearest to these fold angles (radians, one for each crease).
    ///
    /// Cost: a few sparse factorisations of JᵀJ, and inverse iterations with a vector for each degree of freedom.
    ///
    /// # Errors
    /// If no closed configuration is close by, or it is singular.
    pub fn at(conditions: &'c Conditions<'c>, angles: &[f64]) -> Result<Self, NoDerivative> {
        let mut closed = Closing::near(conditions, angles)?;
        let null_space = closed.null_space();
        if let Some(flaw) = closed.flaw(&null_space, conditions) {
            return Err(flaw);
        }
        let drivers = independent_rows(&null_space.basis);
        let chosen = null_space.basis.select_rows(&drivers);
        let inverse = chosen.try_inverse().ok_or(NoDerivative::Singular {
            value: null_space.next,
        })?;
        Ok(Self {
            motions: &null_space.basis * inverse,
            drivers: drivers.into_iter().map(CreaseId::new).collect(),
            conditions,
            angles: closed.angles,
            linearised: closed.linearised,
            factor: closed.factor,
            null_space,
            residual: closed.residual,
        })
    }

    /// Returns the derivatives at a time of a motion (seconds); see [`at`](Self::at). The motion is closed to rounding first:
    /// between its knots it is closed within its bound.
    ///
    /// # Errors
    /// As for [`at`](Self::at).
    ///
    /// # Panics
    /// If the conditions are those of another sheet with more creases.
    pub fn of_motion(
        conditions: &'c Conditions<'c>,
        motion: &Motion,
        time: f64,
    ) -> Result<Self, NoDerivative> {
        let there = motion.at_times([time]);
        Self::at(conditions, &there.crease_angles(0))
    }

    /// Returns the derivatives at the closed configuration at which the drivers have these angles (radians), found by Newton's
    /// method from the fold angles of `start`. The drivers of the result are these.
    ///
    /// Cost: that of [`at`](Self::at) a few times.
    ///
    /// # Errors
    /// As for [`at`](Self::at), or if these hinges do not determine the others.
    pub fn driven(
        conditions: &'c Conditions<'c>,
        start: &[f64],
        drivers: &[CreaseId],
        angles: &[f64],
    ) -> Result<Self, NoDerivative> {
        let mut start = start.to_vec();
        let mut residual = f64::NAN;
        for _ in 0..=MAX_STEPS {
            let at = Self::at(conditions, &start)?.driven_by(drivers)?;
            residual = at.residual;
            let there = drivers.iter().zip(angles);
            let off: Vec<f64> = there
                .map(|(driver, angle)| angle - at.angles[driver.index()])
                .collect();
            let most = largest(off.iter().map(|by| by.abs()));
            if most <= DRIVEN_RAD {
                return Ok(at);
            }
            let part = (MAX_DRIVEN_STEP_RAD / most).min(1.0);
            let step = &at.motions * nalgebra::DVector::from_vec(off) * part;
            start.clone_from(&at.angles);
            start
                .iter_mut()
                .zip(step.iter())
                .for_each(|(x, by)| *x += by);
        }
        Err(NoDerivative::Open { residual })
    }

    /// Returns the same derivatives with other drivers.
    ///
    /// # Errors
    /// If these hinges do not determine the others.
    pub fn driven_by(self, drivers: &[CreaseId]) -> Result<Self, NoDerivative> {
        let size = self.drivers.len();
        let wrong = NoDerivative::NotDrivers { size };
        let rows: Vec<usize> = drivers.iter().map(|driver| driver.index()).collect();
        if rows.len() != size || rows.iter().any(|&row| row >= self.angles.len()) {
            return Err(wrong);
        }
        let chosen = self.null_space.basis.select_rows(&rows);
        let is_regular = size == 0 || chosen.singular_values().min() >= REGULAR;
        let inverse = chosen.try_inverse().filter(|_| is_regular).ok_or(wrong)?;
        Ok(Self {
            motions: &self.null_space.basis * inverse,
            drivers: drivers.to_vec(),
            ..self
        })
    }

    /// Returns the fold angle of each crease, radians.
    #[must_use]
    pub fn angles(&self) -> &[f64] {
        &self.angles
    }

    /// Returns the drivers: creases whose angles determine all others, chosen for the largest pivots.
    #[must_use]
    pub fn drivers(&self) -> &[CreaseId] {
        &self.drivers
    }

    /// Returns N: the motions that keep closure, a row for each crease and a column for each driver. The rows of the drivers
    /// are the identity.
    #[must_use]
    pub fn motions(&self) -> &DMatrix<f64> {
        &self.motions
    }

    /// Returns the smallest singular value of J that is not 0; infinite without conditions.
    #[must_use]
    pub fn smallest_singular_value(&self) -> f64 {
        self.null_space.next
    }

    /// Returns the rates of angles and places for a change of the pattern's vertices (units of the sheet, one for each vertex)
    /// and of the drivers' angles (radians).
    ///
    /// # Errors
    /// If the changed pattern does not fold.
    ///
    /// # Panics
    /// If there are fewer changes than vertices or drivers.
    pub fn jvp(
        &mut self,
        vertices: &[Vector2<f64>],
        drivers: &[f64],
    ) -> Result<Rates, NoDerivative> {
        let mut changes: Vec<f64> = vertices.iter().flat_map(|v| [v.x, v.y]).collect();
        // Squares of changes of any size neither overflow nor vanish. A change that is no number is refused.
        let size = largest(changes.iter().map(|change| change.abs()));
        if size > 0.0 || size.is_nan() {
            changes.iter_mut().for_each(|change| *change /= size);
        }
        let effect = times(&self.linearised.by_vertex, &changes);
        let n = self.angles.len();
        let mut angles = vec![0.0; n];
        let of = effect.iter().map(Vector3::norm_squared).sum::<f64>().sqrt();
        if of > 0.0 || of.is_nan() {
            let right_side = transposed(&self.linearised.by_angle, &effect, n);
            let project = |x: &mut [f64]| self.null_space.project_out(x);
            let by_angle = &self.linearised.by_angle;
            angles = self.factor.pseudo_solve(by_angle, &right_side, project);
            angles.iter_mut().for_each(|angle| *angle = -*angle);
            let left = times(&self.linearised.by_angle, &angles).into_iter();
            let left = left
                .zip(&effect)
                .map(|(by, effect)| (by + effect).norm_squared());
            let residual = left.sum::<f64>().sqrt();
            // A change that turns or scales the sheet has no effect but for rounding.
            let largest = magnitude(&self.linearised.by_vertex, &changes);
            let rounding = (ROUNDING_RATIO + NULL_RESIDUALS * self.residual) * largest;
            let folds = residual <= LEFT_RATIO * of + rounding;
            if !folds {
                return Err(NoDerivative::LeavesFoldability {
                    residual: residual * size,
                    of: of * size,
                });
            }
            angles.iter_mut().for_each(|angle| *angle *= size);
        }
        // The drivers turn as they are asked to.
        for (k, driver) in self.drivers.iter().enumerate() {
            let by = drivers[k] - angles[driver.index()];
            let column = self.motions.column(k);
            // Rows of other drivers are 0 in this column.
            angles
                .iter_mut()
                .zip(column.iter())
                .for_each(|(angle, n)| *angle += by * n);
        }
        let given = PatternRates {
            angles,
            vertices: vertices.to_vec(),
        };
        let sheet = FoldedSheet::new(self.conditions.pattern(), &self.angles);
        Ok(Rates {
            places: sheet.rates(&given),
            angles: given.angles,
        })
    }

    /// Returns the gradient of what has these gradients by the angles of creases and by the folded vertices; an empty list
    /// stands for zeros.
    ///
    /// # Panics
    /// If a list is neither empty nor has one entry for each crease or vertex.
    #[must_use]
    pub fn vjp(&mut self, by_angles: &[f64], by_places: &[Vector3<f64>]) -> Gradient {
        let pattern = self.conditions.pattern();
        let n = self.angles.len();
        let mut by_angle = vec![0.0; n];
        let mut vertices = vec![Vector2::zeros(); pattern.vertices().len()];
        if !by_places.is_empty() {
            assert_eq!(
                by_places.len(),
                vertices.len(),
                "a gradient for each vertex"
            );
            let sheet = FoldedSheet::new(pattern, &self.angles);
            PatternRates {
                angles: by_angle,
                vertices,
            } = sheet.gradient(by_places);
        }
        if !by_angles.is_empty() {
            assert_eq!(by_angles.len(), n, "a gradient for each crease");
            by_angle
                .iter_mut()
                .zip(by_angles)
                .for_each(|(sum, by)| *sum += by);
        }
        let drivers = self
            .motions
            .tr_mul(&nalgebra::DVectorView::from_slice(&by_angle, n));
        for (driver, by) in self.drivers.iter().zip(drivers.iter()) {
            by_angle[driver.index()] -= by;
        }
        let project = |x: &mut [f64]| self.null_space.project_out(x);
        let jacobian = &self.linearised.by_angle;
        let solved = self.factor.pseudo_solve(jacobian, &by_angle, project);
        let multipliers = times(jacobian, &solved);
        let by = transposed(&self.linearised.by_vertex, &multipliers, 2 * vertices.len());
        for (vertex, by) in vertices.iter_mut().zip(by.chunks_exact(2)) {
            *vertex -= Vector2::new(by[0], by[1]);
        }
        Gradient {
            vertices,
            drivers: drivers.iter().copied().collect(),
        }
    }
}

/// Returns as many rows of a matrix as it has columns, each with the largest part that is orthogonal to those before
/// (Gram-Schmidt with pivoting).
fn independent_rows(basis: &DMatrix<f64>) -> Vec<usize> {
    let mut left = basis.clone();
    let mut rows = Vec::new();
    for _ in 0..basis.ncols() {
        let lengths = left.row_iter().map(|row| row.norm_squared());
        // The first of rows that are equal but for rounding.
        let longest = lengths.clone().fold(0.0, f64::max);
        let pivot = lengths
            .enumerate()
            .find(|(_, it)| *it >= longest * (1.0 - 1e-6));
        let Some((pivot, _)) = pivot else { break };
        rows.push(pivot);
        let unit = left.row(pivot).transpose() / longest.sqrt().max(f64::MIN_POSITIVE);
        let parts = &left * &unit;
        left -= parts * unit.transpose();
    }
    rows
}
