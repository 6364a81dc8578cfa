//! What is projected: sheets near a closed configuration, and starts a seeded step off it.

use foldpath::generate::{Miura, Quad, Resch, Waterbomb, Yoshimura};
use foldpath::pattern::{CreasePattern, Drawing};
use foldpath::planner::Goal;
use foldpath::symmetry::{CreaseGroups, ReducedStars};
use foldpath_core::closure;
use foldpath_core::least_squares::Limits;
use foldpath_core::sampling::random_near;
use foldpath_core::{HalfAngle, StarsView};
use rand_pcg::Pcg64;

use super::ours::close;

/// Radians by which each unknown is off a closed configuration at most: the step of the report's search.
pub const STEP: f64 = 0.22;
/// Closure residual that a start exceeds: at one within the coarsest tolerance there is nothing to do.
pub(super) const OPEN: f64 = 0.1;
/// Draws for each start, after which the step is made longer.
const DRAWS: usize = 100;
/// Parts of the goal's angles from which a closed configuration is looked for.
const PARTS: [f64; 5] = [0.6, 1.0, 0.8, 0.4, 0.2];
/// Random configurations tried where none of those leads to one.
const TRIES: u64 = 50;
/// Radians that some angle of it has to have: the flat sheet, where every condition loses rank, is the last
/// resort.
const FOLDED: f64 = 0.3;
/// Factor by which the angles of a closed configuration near flat are folded further, and the growth of their norm below
/// which they do not follow any more.
const FURTHER: f64 = 1.3;
const LEAST_GROWTH: f64 = 1.05;

/// Closure conditions of a sheet, and a configuration that meets them.
#[derive(Debug)]
pub struct Problem {
    /// Family and size, such as `miura 3x3`.
    pub sheet: String,
    /// Whether the unknowns are crease groups, and the conditions those of the essential vertices.
    pub symmetric: bool,
    stars: ReducedStars,
    closed: Vec<f64>,
}

impl Problem {
    /// The sheet of a family with every crease an unknown of its own, or with its crease groups.
    ///
    /// # Panics
    /// If a generator of the library does not keep what it promises.
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

    /// The same with every crease an unknown of its own, round the flat sheet: it closes, but every condition loses rank
    /// there, and what closes nearest to a start may be another configuration.
    ///
    /// # Panics
    /// If a generator of the library does not keep what it promises.
    #[must_use]
    pub fn round_flat(family: Family, rows: usize, columns: usize) -> Self {
        let mut problem = Self::new(family, rows, columns, false);
        problem.sheet.push_str(" round flat");
        problem.closed.fill(0.0);
        problem
    }

    /// Sheet and unknowns in words.
    #[must_use]
    pub fn name(&self) -> String {
        let kind = if self.symmetric { "groups" } else { "full" };
        format!("{}, {kind}", self.sheet)
    }

    /// Number of unknowns.
    #[must_use]
    pub fn unknowns(&self) -> usize {
        self.closed.len()
    }

    /// The conditions.
    #[must_use]
    pub fn stars(&self) -> StarsView<'_, f64> {
        self.stars.view()
    }

    /// Largest angle of the closed configuration, radians: 0 round the flat sheet.
    #[must_use]
    pub fn folded(&self) -> f64 {
        max_norm(&self.closed)
    }

    /// Configurations a random step off the closed one, the same for every method, none of them nearly closed: the step
    /// is twice as long, and again, where it opens too little.
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

    /// Largest closure residual of a vertex at `x`, in f64.
    #[must_use]
    pub fn closure(&self, x: &[f64]) -> f64 {
        largest_residual(self.stars(), x)
    }
}

/// Largest closure residual; infinite for what is no number.
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

/// The closed configuration near `x`, folded further step by step as far as it follows. Random angles far from flat lead
/// to none where there are hundreds of conditions on them.
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

fn max_norm(x: &[f64]) -> f64 {
    x.iter().fold(0.0, |most, x| most.max(x.abs()))
}

/// Families of patterns.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Family {
    /// Miura, sector angle 60 degrees.
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
    /// Its name.
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

    /// The pattern with its goal.
    ///
    /// # Panics
    /// If the generator does not take the size.
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
