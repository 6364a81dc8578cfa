//! Closure conditions of sheets, and starts that are a seeded step off a closed configuration, for tests and benchmarks of
//! the solvers.

use foldpath::generate::{Miura, Quad, Resch, Waterbomb, Yoshimura};
use foldpath::pattern::{CreasePattern, Drawing};
use foldpath::planner::{Goal, SparseNormalEquations};
use foldpath::symmetry::{CreaseGroups, ReducedStars};
use foldpath_core::least_squares::{ClosureProblem, Limits, Options, Outcome, Report};
use foldpath_core::sampling::random_near;
use foldpath_core::{
    DenseNormalEquations, HalfAngle, LoopsView, Scalar, StarsView, closure, levenberg_marquardt,
};
use nalgebra::Vector3;
use rand_pcg::Pcg64;

/// Largest number of unknowns for which the planner uses dense matrices.
pub const DENSE: usize = 40;
/// Largest distance of each unknown of a start from the closed configuration, radians: the step of the report's search.
pub const STEP: f64 = 0.22;
/// Closure residual that every start exceeds. A start within the coarsest tolerance would need no work.
pub const OPEN: f64 = 0.1;
/// Number of draws for each start after which the step is made longer.
const DRAWS: usize = 100;
/// Fractions of the goal's angles at which a closed configuration is searched.
const PARTS: [f64; 5] = [0.6, 1.0, 0.8, 0.4, 0.2];
/// Number of random configurations that are tried if none of those leads to a closed one.
const TRIES: u64 = 50;
/// Angle that some crease of the closed configuration must reach, radians. The flat sheet, where every condition loses
/// rank, is the last resort.
const FOLDED: f64 = 0.3;
/// Factor by which the angles of a closed configuration near flat are folded further (`FURTHER`), and growth of their
/// norm below which the sheet no longer follows (`LEAST_GROWTH`).
const FURTHER: f64 = 1.3;
const LEAST_GROWTH: f64 = 1.05;

/// Closure conditions of a sheet, and a configuration that meets them.
#[derive(Debug)]
pub struct Problem {
    /// Family and size, such as `miura 3x3`.
    pub sheet: String,
    /// `true` if the unknowns are crease groups and the conditions those of the essential vertices; otherwise every
    /// crease is an unknown and every vertex a condition.
    pub symmetric: bool,
    stars: ReducedStars,
    closed: Vec<f64>,
}

impl Problem {
    /// Creates the problem of a sheet, with its crease groups or with every crease an unknown of its own.
    ///
    /// # Panics
    /// If a generator of the library breaks its contract.
    #[must_use]
    pub fn new(family: Family, rows: usize, columns: usize, symmetric: bool) -> Self {
        let pattern = CreasePattern::new(family.drawing(rows, columns)).expect("a pattern");
        let goal = Goal::of_pattern(&pattern).expect("a goal");
        let groups = if symmetric {
            CreaseGroups::find(&pattern)
        } else {
            CreaseGroups::trivial(&pattern)
        };
        let all = ReducedStars::all(&pattern, &groups);
        let stars = if symmetric { all.essential() } else { all };
        let asked = groups.reduce(&goal.fold_angles);
        let asked: Vec<f64> = asked.into_iter().map(|a| a.unwrap_or(0.0)).collect();
        Self {
            sheet: format!("{} {rows}x{columns}", family.name()),
            symmetric,
            closed: closed_configuration(&stars, &asked),
            stars,
        }
    }

    /// Creates the problem with every crease an unknown, round the flat sheet. The flat sheet closes, but every
    /// condition loses rank there, so that the closed configuration nearest to a start may be another one.
    ///
    /// # Panics
    /// If a generator of the library breaks its contract.
    #[must_use]
    pub fn round_flat(family: Family, rows: usize, columns: usize) -> Self {
        let mut problem = Self::new(family, rows, columns, false);
        problem.sheet.push_str(" round flat");
        problem.closed.fill(0.0);
        problem
    }

    /// Returns sheet and kind of unknowns as text.
    #[must_use]
    pub fn name(&self) -> String {
        let kind = if self.symmetric { "groups" } else { "full" };
        format!("{}, {kind}", self.sheet)
    }

    /// Returns the number of unknowns.
    #[must_use]
    pub fn unknowns(&self) -> usize {
        self.closed.len()
    }

    /// Returns the closure conditions.
    #[must_use]
    pub fn stars(&self) -> StarsView<'_, f64> {
        self.stars.view()
    }

    /// Returns the largest angle of the closed configuration, radians; 0 round the flat sheet.
    #[must_use]
    pub fn folded(&self) -> f64 {
        max_norm(&self.closed)
    }

    /// Returns configurations a random step off the closed one, equal for all methods. None of them nearly closes: the
    /// step is doubled as often as it opens the sheet too little.
    #[must_use]
    pub fn starts(&self, count: usize) -> Vec<Vec<f64>> {
        let mut rng = Pcg64::new(2015, 2);
        let mut x = vec![0.0; self.closed.len()];
        let steps = core::iter::successors(Some(STEP), |step| Some(2.0 * step));
        let draws = steps.flat_map(|step| core::iter::repeat_n(step, DRAWS * count));
        let open = draws.filter_map(|step| {
            random_near(&mut rng, &self.closed, step, Limits::HalfTurn, &mut x);
            (self.closure(&x) > OPEN).then(|| x.clone())
        });
        open.take(count).collect()
    }

    /// Returns the largest closure residual of a vertex at `x`, in f64.
    #[must_use]
    pub fn closure(&self, x: &[f64]) -> f64 {
        largest_residual(self.stars(), x)
    }
}

/// Returns the largest closure residual; infinite if a residual is not finite.
fn largest_residual(stars: StarsView<'_, f64>, x: &[f64]) -> f64 {
    let mut half = vec![HalfAngle::default(); x.len()];
    closure::half_angles(x, &mut half);
    let squares = stars.iter().map(|star| {
        let residual = closure::residual(star, &half);
        residual.dot(&residual)
    });
    let largest = squares.fold(0.0, |most: f64, square| {
        if square.is_finite() {
            most.max(square)
        } else {
            f64::INFINITY
        }
    });
    largest.sqrt()
}

fn closed_configuration(stars: &ReducedStars, asked: &[f64]) -> Vec<f64> {
    let flat = vec![0.0; asked.len()];
    let near_flat = |seed: u64, radius| {
        let mut x = flat.clone();
        let mut rng = Pcg64::new(seed.into(), 1);
        random_near(&mut rng, &flat, radius, Limits::HalfTurn, &mut x);
        x
    };
    let near_goal = PARTS.map(|part| asked.iter().map(|a| a * part).collect::<Vec<f64>>());
    let random = (0..TRIES).map(|seed| near_flat(seed, 1.5));
    let mut starts = near_goal.into_iter().chain(random);
    let found = starts.find_map(|mut x| {
        let closed = close(stars.view(), &mut x);
        (closed && max_norm(&x) >= FOLDED).then_some(x)
    });
    let found = found.or_else(|| {
        let folded = folded_further(stars, near_flat(0, STEP))?;
        (max_norm(&folded) >= FOLDED).then_some(folded)
    });
    found.unwrap_or(flat)
}

/// Returns the closed configuration near `x`, folded further step by step as far as the sheet follows. With hundreds of
/// conditions, random angles far from flat lead to no closed configuration.
fn folded_further(stars: &ReducedStars, mut x: Vec<f64>) -> Option<Vec<f64>> {
    let square = |x: &[f64]| x.iter().map(|a| a * a).sum::<f64>();
    if !close(stars.view(), &mut x) {
        return None;
    }
    loop {
        let mut further: Vec<f64> = x.iter().map(|a| a * FURTHER).collect();
        let closed = close(stars.view(), &mut further);
        if !closed || square(&further) < LEAST_GROWTH * LEAST_GROWTH * square(&x) {
            return Some(x);
        }
        x = further;
    }
}

/// Moves `x` to closure, as far as rounding allows. Returns `true` if `x` then closes.
fn close(stars: StarsView<'_, f64>, x: &mut [f64]) -> bool {
    solve(stars, &Options::default(), x).outcome == Outcome::Converged
}

/// Returns the largest closure residual at `start`, and after each iteration of Levenberg-Marquardt in f64 from there,
/// down to rounding.
///
/// # Panics
/// If the solver takes more than 2^32 iterations.
#[must_use]
pub fn residuals_by_iteration(stars: StarsView<'_, f64>, start: &[f64]) -> Vec<f64> {
    let mut residuals = Vec::new();
    loop {
        let options = Options {
            tolerance: f64::CLOSURE_TOLERANCE,
            // The solver must not accept a residual above the tolerance.
            acceptable: 0.0,
            max_iterations: u32::try_from(residuals.len()).expect("a few"),
            ..Options::default()
        };
        let report = solve(stars, &options, &mut start.to_vec());
        residuals.push(report.residual);
        if report.outcome != Outcome::IterationLimit {
            return residuals;
        }
    }
}

/// Solves by Levenberg-Marquardt, with the linear algebra that the planner uses for this number of unknowns.
fn solve(stars: StarsView<'_, f64>, options: &Options<f64>, x: &mut [f64]) -> Report<f64> {
    let mut half = vec![HalfAngle::default(); x.len()];
    let mut columns = vec![Vector3::zeros(); stars.max_degree()];
    let mut work = vec![0.0; 2 * x.len()];
    let problem = ClosureProblem::new(stars, &mut half, &mut columns);
    let (mut problem, limits) = (problem.expect("room for all"), Limits::HalfTurn);
    let sparse = (x.len() > DENSE).then(|| SparseNormalEquations::new(stars, LoopsView::none()));
    if let Some(mut sparse) = sparse.flatten() {
        return levenberg_marquardt::solve(
            &mut problem,
            &mut sparse,
            limits,
            options,
            x,
            &mut work,
        );
    }
    let mut memory = vec![0.0; DenseNormalEquations::<f64>::memory(x.len())];
    let mut dense = DenseNormalEquations::new(x.len(), &mut memory).expect("room for all");
    levenberg_marquardt::solve(&mut problem, &mut dense, limits, options, x, &mut work)
}

fn max_norm(x: &[f64]) -> f64 {
    x.iter().fold(0.0, |most, x| most.max(x.abs()))
}

/// Families of patterns.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Family {
    /// Miura with a sector angle of 60 degrees.
    Miura,
    /// The report's waterbomb.
    Waterbomb,
    /// Yoshimura at 30 degrees.
    Yoshimura,
    /// Resch's triangles.
    Resch,
    /// The report's quadrilaterals, which fold only a little and in odd ways.
    Quad,
}

impl Family {
    /// Returns the name of the family.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::Miura => "miura",
            Self::Waterbomb => "waterbomb",
            Self::Yoshimura => "yoshimura",
            Self::Resch => "resch",
            Self::Quad => "quad",
        }
    }

    /// Returns the pattern with its goal.
    ///
    /// # Panics
    /// If the generator refuses the size.
    #[must_use]
    pub fn drawing(self, rows: usize, columns: usize) -> Drawing {
        let drawing = match self {
            Self::Miura => Miura {
                rows,
                columns,
                sector_angle: 60_f64.to_radians(),
                fold: 170.0 / 180.0,
            }
            .drawing(),
            Self::Waterbomb => Waterbomb {
                rows,
                columns,
                fold: 0.522_504_840_831_969,
            }
            .drawing(),
            Self::Yoshimura => Yoshimura {
                rows,
                columns,
                angle: 30_f64.to_radians(),
                fold: 0.5,
            }
            .drawing(),
            Self::Resch => Resch { rows, columns }.drawing(),
            Self::Quad => Quad {
                rows,
                columns,
                fold: 0.0675,
            }
            .drawing(),
        };
        drawing.expect("a size that the generator takes")
    }
}
