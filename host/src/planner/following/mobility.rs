//! First-order motions of a sheet a small step from flat: tells whether the sheet leaves flat along its assignments,
//! how many independent motions (degrees of freedom) it then has, and which hinges are good to drive.
//!
//! Flat itself is singular, so that first-order motions at flat tell nothing about the motions of the sheet.
//! Infinitesimal motions are the null space of the closure Jacobian, whose rank is that of Gaussian elimination with
//! complete pivoting.

use foldpath_core::least_squares::{Accumulate, ClosureProblem};
use foldpath_core::{HalfAngle, Spoke};
use nalgebra::{DMatrix, Vector3};

use super::branch::{UNTURNED_RATIO, branches_at_flat};
use super::reduction::Reduction;
use crate::pattern::CreasePattern;
use crate::planner::vectors::{largest, max_norm};
use crate::planner::{Goal, PlanOptions};
use crate::progress::Watch;
use crate::symmetry::{CreaseGroups, ReducedStars};
use crate::util::union_find::UnionFind;

/// Infinitesimal motions of a closed configuration.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Mobility {
    /// Number of unknowns.
    pub unknowns: usize,
    /// Unknowns whose rates determine those of all others, as many as there are independent motions; those that turn
    /// most come first.
    pub drivers: Vec<usize>,
    /// Unknowns that turn in some motion.
    pub moving: Vec<usize>,
}

/// Size below which a pivot is rounding, as a fraction of the largest entry of the Jacobian.
const RANK_RATIO: f64 = 1e-8;
/// Rate below which an unknown does not turn, as a fraction of the largest rate.
const STILL_RATIO: f64 = 1e-9;
/// Largest number of multiplications of an elimination: a few hundredths of a second.
const MAX_MULTIPLICATIONS: usize = 50_000_000;
/// Largest number of unknowns for which first steps from flat are tried.
const MAX_UNKNOWNS: usize = 300;

impl Mobility {
    /// Returns the motions at the configuration `x` (radians, an angle for each unknown), which has to close. Returns
    /// `None` if that would take long. Cost: rows of the Jacobian times the square of the unknowns.
    #[must_use]
    pub fn at(stars: &ReducedStars, x: &[f64]) -> Option<Self> {
        let basis = motions(stars, x)?;
        let largest = basis.amax();
        let turns = |row: usize| basis.row(row).amax() > STILL_RATIO * largest;
        Some(Self {
            unknowns: x.len(),
            moving: (0..x.len()).filter(|&row| turns(row)).collect(),
            drivers: leaders(basis),
        })
    }
}

/// Returns the unknowns that turn, in sets that turn independently of each other at each of these configurations
/// (union-find). Unknowns that turn at none of them are in no set. Returns `None` if that would take long.
pub(crate) fn independent_parts(
    stars: &ReducedStars,
    looks: &[Vec<f64>],
) -> Option<Vec<Vec<usize>>> {
    let unknowns = looks.first()?.len();
    let mut turns = vec![false; unknowns];
    let mut sets = UnionFind::new(unknowns);
    for look in looks {
        for motion in motions(stars, look)?.column_iter() {
            let still = STILL_RATIO * motion.amax();
            let turning = (0..unknowns).filter(|&unknown| motion[unknown].abs() > still);
            let mut first = None;
            for unknown in turning {
                turns[unknown] = true;
                sets.join_to_smaller([*first.get_or_insert(unknown), unknown]);
            }
        }
    }
    let mut parts = vec![Vec::new(); unknowns];
    for unknown in (0..unknowns).filter(|&unknown| turns[unknown]) {
        parts[sets.find(unknown)].push(unknown);
    }
    parts.retain(|part| !part.is_empty());
    Some(parts)
}

/// Returns a basis of the infinitesimal motions at `x`, one column for each; `None` if that would take long.
fn motions(stars: &ReducedStars, x: &[f64]) -> Option<DMatrix<f64>> {
    let rows = 3 * stars.view().len() + 6 * stars.loops().len();
    if rows.checked_mul(x.len() * x.len())? > MAX_MULTIPLICATIONS {
        return None;
    }
    Some(null_space(jacobian(stars, x)?))
}

/// Entries of a Jacobian, in blocks of three rows.
#[derive(Default)]
struct Entries {
    blocks: usize,
    /// Block, unknown, and the unknown's column in the block.
    columns: Vec<(usize, usize, Vector3<f64>)>,
}

impl Accumulate<f64> for Entries {
    fn clear(&mut self) {
        *self = Self::default();
    }

    fn add(&mut self, _: usize, spokes: &[Spoke<f64>], columns: &[Vector3<f64>], _: &Vector3<f64>) {
        let entries = spokes.iter().zip(columns);
        let entries = entries.map(|(spoke, column)| (self.blocks, spoke.group.index(), *column));
        self.columns.extend(entries);
        self.blocks += 1;
    }
}

/// Returns the Jacobian of all residuals at `x`.
fn jacobian(stars: &ReducedStars, x: &[f64]) -> Option<DMatrix<f64>> {
    let (view, loops) = (stars.view(), stars.loops());
    let mut half_angles = vec![HalfAngle::default(); x.len()];
    let mut columns = vec![Vector3::zeros(); ClosureProblem::columns(view, loops)];
    let mut problem = ClosureProblem::with_loops(view, loops, &mut half_angles, &mut columns)?;
    let mut entries = Entries::default();
    problem.linearise(x, &mut entries)?;
    let mut jacobian = DMatrix::zeros(3 * entries.blocks, x.len());
    for (block, unknown, column) in entries.columns {
        let mut entry = jacobian.fixed_view_mut::<3, 1>(3 * block, unknown);
        entry += column;
    }
    Some(jacobian)
}

/// Returns a basis of the null space, one column for each motion.
fn null_space(mut a: DMatrix<f64>) -> DMatrix<f64> {
    let n = a.ncols();
    let mut order: Vec<usize> = (0..n).collect();
    let least = RANK_RATIO * a.amax();
    let mut rank = 0;
    while rank < n.min(a.nrows()) {
        let rest = a.view((rank, rank), (a.nrows() - rank, n - rank));
        let (row, column) = rest.iamax_full();
        if rest[(row, column)].abs() <= least {
            break;
        }
        a.swap_rows(rank, rank + row);
        a.swap_columns(rank, rank + column);
        order.swap(rank, rank + column);
        eliminate(&mut a, rank);
        rank += 1;
    }
    // The pivots' columns are now those of the identity: each pivot's unknown follows from the free unknowns.
    let mut basis = DMatrix::zeros(n, n - rank);
    for (motion, free) in (rank..n).enumerate() {
        basis[(order[free], motion)] = 1.0;
        for pivot in 0..rank {
            basis[(order[pivot], motion)] = -a[(pivot, free)];
        }
    }
    basis
}

/// Makes the column of a pivot on the diagonal a unit vector by row operations on all columns from there on
/// (Gauss-Jordan).
fn eliminate(a: &mut DMatrix<f64>, pivot: usize) {
    let column = a.column(pivot).clone_owned();
    for mut other in a.column_iter_mut().skip(pivot) {
        let part = other[pivot] / column[pivot];
        if part.abs() > 0.0 {
            other.axpy(-part, &column, 1.0);
            other[pivot] = part;
        }
    }
}

/// Returns rows of the basis that determine all others: repeatedly the largest row that is left when the parts along
/// the rows before are removed.
fn leaders(mut basis: DMatrix<f64>) -> Vec<usize> {
    let mut leaders = Vec::with_capacity(basis.ncols());
    for motion in 0..basis.ncols() {
        let rest = basis.columns(motion, basis.ncols() - motion);
        let (row, column) = rest.iamax_full();
        basis.swap_columns(motion, motion + column);
        leaders.push(row);
        let head = basis.column(motion) / basis[(row, motion)];
        for mut other in basis.column_iter_mut().skip(motion + 1) {
            let part = other[row];
            other.axpy(-part, &head, 1.0);
        }
    }
    leaders
}

/// Outcome of a small step from flat, along the signs of a goal.
#[derive(Clone, Debug, PartialEq)]
pub enum FirstStep {
    /// The sheet leaves flat, as nearly closed as the precision of its coordinates tells.
    Leaves {
        /// Number of creases that turn at the goal but not in this step.
        unturned: usize,
        /// Motions that keep the symmetry, in crease groups; `None` if that would take long, or if rounded coordinates
        /// hide them.
        symmetric: Option<Mobility>,
        /// All motions, in creases; `None` likewise.
        single: Option<Mobility>,
    },
    /// The sheet leaves flat only as nearly closed as the default bound allows.
    Bends,
    /// No way to leave flat was found.
    Stays,
    /// There are too many unknowns for an immediate answer.
    Unknown,
}

/// Leaves flat in the direction of the goal: in crease groups or else, if the sheet is small, crease by crease. Vertices
/// count as closed if their residual is no more than `rounding` explains.
pub(crate) fn first_step(
    pattern: &CreasePattern,
    groups: &CreaseGroups,
    goal: &Goal,
    rounding: f64,
    watch: Watch<'_>,
) -> FirstStep {
    let options = PlanOptions::default();
    // A sheet that leaves flat has a motion. If none is found, rounded coordinates have raised the rank.
    let motions = |stars: &ReducedStars, x: &[f64]| {
        Mobility::at(stars, x).filter(|motions| !motions.drivers.is_empty())
    };
    let mut tried = FirstStep::Unknown;
    for groups in [groups.clone(), CreaseGroups::trivial(pattern)] {
        if groups.len() > MAX_UNKNOWNS || watch.is_over() {
            continue;
        }
        let reduction = Reduction::new(pattern, groups, &options, watch);
        let (asked, signs) = reduction.asked(goal);
        let most = largest(&asked);
        let towards = asked.iter().zip(&signs);
        let towards: Vec<f64> = towards
            .map(|(asked, sign)| asked.unwrap_or(sign * most))
            .collect();
        let leave =
            |tolerance: f64| branches_at_flat(&reduction, &towards, &signs, tolerance, &options).0;
        let within = reduction.closure_tolerance(&options);
        // A part of the sheet may leave flat exactly where rounded coordinates hold the rest.
        let mut tolerances = vec![0.0, rounding.min(within)];
        tolerances.dedup();
        let steps = tolerances.into_iter().map(leave);
        for x in steps.filter_map(|found| found.into_iter().next()) {
            let creases = reduction.groups.expand(&x);
            let least = UNTURNED_RATIO * max_norm(&x);
            let asked = goal.fold_angles.iter().zip(&goal.signs);
            let asked = asked.map(|(angle, sign)| angle.unwrap_or(*sign));
            let unturned = asked.zip(&creases);
            let unturned = unturned.filter(|(asked, x)| asked.abs() > 0.0 && x.abs() < least);
            let unturned = unturned.count();
            let is_better = match tried {
                FirstStep::Leaves { unturned: most, .. } => unturned < most,
                _ => true,
            };
            if is_better {
                tried = FirstStep::Leaves {
                    unturned,
                    symmetric: motions(&reduction.essential, &x),
                    single: motions(&ReducedStars::of_creases(pattern), &creases),
                };
            }
            if unturned == 0 {
                return tried;
            }
        }
        if matches!(tried, FirstStep::Leaves { .. }) {
            continue;
        }
        let bends = !leave(within).is_empty();
        tried = if bends || tried == FirstStep::Bends {
            FirstStep::Bends
        } else {
            FirstStep::Stays
        };
    }
    tried
}
