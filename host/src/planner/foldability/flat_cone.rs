//! The cone of first-order rates with which a sheet can leave flat, as a linear program.
//!
//! To first order, rates x of the creases leave the flat sheet closed if at every real vertex the sum of
//! x_k (cos α_k, sin α_k) is zero, α_k being the direction of crease k from the vertex (S.-M. Belcastro, T. Hull,
//! "Modelling the folding of paper into three dimensions using affine transformations", 2002). Round a hole the same sum
//! is zero over the creases that the loop crosses, and so is the sum of x_k times the moment of crease k about the
//! middle of the hole, which is the translation out of the plane. A crease with a letter has a rate of its sign. These
//! rates form a cone. Every motion that leaves flat begins with rates of the cone, so that a crease whose rate is zero
//! in the whole cone does not turn in a first step.
//!
//! Rounded coordinates make a straight line slightly bent, and a bent line cannot turn. The program therefore allows
//! each condition a small error. Its solution proves nothing; its multipliers do, as `certificate.rs` explains.

use foldpath_linear::linear_program::{LinearProgram, Variable};
use nalgebra::Vector2;

use crate::pattern::{ClosureSite, CreaseId, CreasePattern, EdgeId, VertexId};
use crate::util::csr::Csr;

/// Ratio of rates below which a crease counts as still, as for the first step of the planner.
pub(crate) const STILL_RATIO: f64 = 1e-3;
/// Smallest error, radians, that the directions of creases are allowed in full precision: far above the rounding of
/// double precision, far below any bend that is drawn on purpose.
const FULL_PRECISION_RAD: f64 = 1e-9;
/// Error, radians, that the directions of creases are allowed if the reader repaired the drawing and thereby moved
/// vertices. Also the error within which a proof that a sheet cannot fold at all has to hold, because panels that
/// deform a little, as the bound of a plan allows, bridge smaller ones.
const DRAWN_RAD: f64 = 1e-3;
/// Largest rate in a program, in units of the rate at which a crease counts as turning.
pub(crate) const MAX_RATE: f64 = 100.0;
/// Smallest error of a condition that a program allows, in the same unit. The normal equations of the program have a
/// condition number of about the square of the largest rate over this error, which has to stay far below 1e16.
pub(crate) const MIN_SLACK: f64 = 1e-4;

/// Rate in a solution above which a crease turns. Rates of solutions are 1 or more, or nearly 0.
const MIN_TURNING_RATE: f64 = 0.5;
/// Length of the vector of all c of turning creases at which multipliers are free of errors.
const PURE_RATIO: f64 = 1e-11;
/// Largest number of iterations that remove errors from multipliers; some hundred are usual.
const MAX_PURIFICATIONS: usize = 1000;

/// The coefficient of a crease in one condition.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Coefficient {
    /// The condition.
    pub(crate) row: u32,
    pub(crate) value: f64,
    /// Largest change of the value per radian by which the crease's direction is wrong.
    pub(crate) sensitivity: f64,
}

/// The conditions on the rates of a sheet at flat.
#[derive(Clone, Debug)]
pub(crate) struct FlatConditions {
    /// The coefficients of each crease.
    pub(crate) columns: Csr<Coefficient>,
    /// The vertex or hole of each condition.
    pub(crate) sites: Vec<ClosureSite>,
}

impl FlatConditions {
    /// Makes two conditions for each real vertex and three for each hole. Cost: linear.
    pub(crate) fn new(pattern: &CreasePattern) -> Self {
        let mut sites = Vec::new();
        let mut columns = vec![Vec::new(); pattern.creases().len()];
        let mut add = |edge: EdgeId, coefficients: &[Coefficient]| {
            let Some(crease) = pattern.edge(edge).crease else {
                return;
            };
            for new in coefficients {
                let column: &mut Vec<Coefficient> = &mut columns[crease.index()];
                match column.iter_mut().find(|old| old.row == new.row) {
                    Some(old) => old.value += new.value,
                    None => column.push(*new),
                }
            }
        };
        let along = |first: usize, direction: Vector2<f64>| {
            [(0, direction.x), (1, direction.y)].map(|(k, value)| Coefficient {
                row: row(first + k),
                value,
                sensitivity: 1.0,
            })
        };
        for vertex in pattern.real_vertices() {
            let first = sites.len();
            sites.extend([ClosureSite::Vertex(vertex); 2]);
            for &edge in &pattern.stars()[vertex.index()] {
                add(edge, &along(first, pattern.direction(edge, vertex)));
            }
        }
        for (hole, passages) in pattern.holes().iter().enumerate() {
            let first = sites.len();
            sites.extend([pattern.hole_site(hole); 3]);
            let (middle, size) = pattern.hole_frame(hole);
            for passage in passages {
                let direction = pattern.direction(passage.edge, passage.at);
                add(passage.edge, &along(first, direction));
                let from_middle = (pattern.vertices()[passage.at.index()] - middle) / size;
                // A direction that is wrong by an angle means ends that are wrong by half a length times this angle.
                let lever = from_middle.norm()
                    + pattern.length(pattern.edge(passage.edge).ends) / (2.0 * size);
                let turning = Coefficient {
                    row: row(first + 2),
                    value: from_middle.perp(&direction),
                    sensitivity: lever,
                };
                add(passage.edge, &[turning]);
            }
        }
        Self {
            columns: columns.into_iter().collect(),
            sites,
        }
    }

    /// Makes the program that turns as many of the `active` creases as possible: maximise the sum of t_k subject to
    /// the conditions on the rates, 0 ≤ t_k ≤ 1, t_k ≤ |rate| ≤ [`MAX_RATE`]. A crease without sign has a rate
    /// of either sign and no t. Each condition is allowed `slack` times the sum of the errors of its creases'
    /// directions. Returns for each condition the row that it has in the program too.
    fn program(
        &self,
        active: &[usize],
        signs: &[f64],
        errors: &[f64],
        slack: f64,
    ) -> (LinearProgram, Vec<Option<usize>>) {
        let mut rows = vec![None; self.sites.len()];
        let mut sizes: Vec<RowSize> = Vec::new();
        let mut program = LinearProgram::default();
        for &crease in active {
            let sign = signs[crease];
            let signed = sign.abs() > 0.0;
            let mut column = Vec::new();
            for coefficient in &self.columns[crease] {
                let row = *rows[coefficient.row as usize].get_or_insert_with(|| {
                    sizes.push(RowSize::default());
                    sizes.len() - 1
                });
                sizes[row].allowed += slack * errors[crease] * coefficient.sensitivity;
                sizes[row].entries += coefficient.value.abs();
                let value = if signed { sign } else { 1.0 } * coefficient.value;
                column.push((self::row(row), value));
            }
            let variable = |cost: f64, upper: f64| Variable {
                column: column.clone(),
                cost,
                upper,
                start: upper / 2.0,
            };
            if signed {
                program.variables.push(variable(-1.0, 1.0));
                program.variables.push(variable(0.0, MAX_RATE));
            } else {
                program.variables.push(variable(0.0, 2.0 * MAX_RATE));
            }
        }
        for size in &mut sizes {
            size.allowed = size.allowed.max(MIN_SLACK);
        }
        program.right_side = sizes.iter().map(|size| size.allowed).collect();
        let slacks = start_rates(&mut program, active, signs, &sizes);
        let slacks = slacks.iter().zip(&sizes).zip(0..);
        let slacks = slacks.map(|((slack, size), row)| Variable {
            column: vec![(row, 1.0)],
            cost: 0.0,
            upper: 2.0 * size.allowed,
            start: *slack,
        });
        program.variables.extend(slacks);
        (program, rows)
    }

    /// Returns the rates of a solution of [`program`](Self::program), one for each active crease, and the multipliers
    /// of all conditions: the stress that holds the locked creases. `None` if there are too many creases.
    pub(crate) fn solve(
        &self,
        active: &[usize],
        signs: &[f64],
        errors: &[f64],
        slack: f64,
    ) -> Option<(Vec<f64>, Vec<f64>)> {
        let (program, rows) = self.program(active, signs, errors, slack);
        let solution = program.solve()?;
        let rates = active.iter().zip(first_variables(active, signs));
        let rates = rates.map(|(&crease, first)| {
            let sign = signs[crease];
            if sign.abs() > 0.0 {
                sign * (solution.x[first] + solution.x[first + 1])
            } else {
                solution.x[first] - MAX_RATE
            }
        });
        let rates: Vec<f64> = rates.collect();
        let multiplier = |row: &Option<usize>| row.map_or(0.0, |row| -solution.y[row]);
        let mut multipliers: Vec<f64> = rows.iter().map(multiplier).collect();
        let turning = active.iter().zip(&rates).filter(|(crease, rate)| {
            let signed = signs[**crease].abs() > 0.0;
            !signed || rate.abs() > MIN_TURNING_RATE
        });
        let turning: Vec<usize> = turning.map(|(crease, _)| *crease).collect();
        self.purify(&turning, &mut multipliers);
        Some((rates, multipliers))
    }

    /// Removes the error of a program's solution from its multipliers: changes them as little as possible so that they
    /// are orthogonal to the columns of the `turning` creases, by conjugate gradients (CGLS; Björck, "Numerical Methods
    /// for Least Squares Problems", 1996, algorithm 7.4.1). The multipliers are the residual of that algorithm.
    fn purify(&self, turning: &[usize], multipliers: &mut [f64]) {
        let gradient = |y: &[f64]| -> Vec<f64> {
            let along = |&crease: &usize| {
                let column = self.columns[crease].iter();
                column.map(|c| c.value * y[c.row as usize]).sum()
            };
            turning.iter().map(along).collect()
        };
        let square = |v: &[f64]| v.iter().map(|x| x * x).sum::<f64>();
        let mut rest = gradient(multipliers);
        let mut way = rest.clone();
        let mut size = square(&rest);
        for _ in 0..MAX_PURIFICATIONS {
            if size < PURE_RATIO * PURE_RATIO {
                break;
            }
            let mut change = vec![0.0; multipliers.len()];
            for (&crease, part) in turning.iter().zip(&way) {
                for c in &self.columns[crease] {
                    change[c.row as usize] += part * c.value;
                }
            }
            let step = size / square(&change).max(f64::MIN_POSITIVE);
            for (y, change) in multipliers.iter_mut().zip(&change) {
                *y -= step * change;
            }
            rest = gradient(multipliers);
            let next = square(&rest);
            for (way, rest) in way.iter_mut().zip(&rest) {
                *way = rest + next / size * *way;
            }
            size = next;
        }
    }
}

/// Sizes of a row of the program.
#[derive(Clone, Copy, Debug, Default)]
struct RowSize {
    /// The error allowed.
    allowed: f64,
    /// Sum of the sizes of the entries.
    entries: f64,
}

/// Starts the search from rates so small that the errors allowed exceed them, which satisfy all conditions, and moves the
/// origin of rates of either sign to the right sides. Returns what the errors allowed exceed them by.
fn start_rates(
    program: &mut LinearProgram,
    active: &[usize],
    signs: &[f64],
    sizes: &[RowSize],
) -> Vec<f64> {
    let mut slacks = program.right_side.clone();
    for (&crease, first) in active.iter().zip(first_variables(active, signs)) {
        if signs[crease].abs() <= 0.0 {
            // The variable is the rate plus `MAX_RATE`.
            for &(row, value) in &program.variables[first].column {
                program.right_side[row as usize] += MAX_RATE * value;
            }
            continue;
        }
        for variable in &mut program.variables[first..first + 2] {
            let most = variable.column.iter().map(|&(row, _)| {
                let size = sizes[row as usize];
                size.allowed / (4.0 * size.entries)
            });
            variable.start = most.fold(variable.start, f64::min);
            for &(row, value) in &variable.column {
                slacks[row as usize] -= value * variable.start;
            }
        }
    }
    slacks
}

/// Returns the first variable of each active crease: two for a crease with sign, one for any other.
fn first_variables(active: &[usize], signs: &[f64]) -> impl Iterator<Item = usize> {
    active.iter().scan(0, |next, &crease| {
        let first = *next;
        *next += if signs[crease].abs() > 0.0 { 2 } else { 1 };
        Some(first)
    })
}

/// Returns the number of a condition.
pub(crate) fn row(index: usize) -> u32 {
    u32::try_from(index).expect("fewer than 2^32 vertices")
}

/// Returns for each crease the largest error of its direction, radians, that follows from the precision of the
/// coordinates.
pub(crate) fn direction_errors(pattern: &CreasePattern) -> Vec<f64> {
    let unit = pattern.precision().length.unit();
    let least = if pattern.repairs().is_empty() {
        FULL_PRECISION_RAD
    } else {
        DRAWN_RAD
    };
    let error = |&edge: &EdgeId| least + 2.0 * unit / pattern.length(pattern.edge(edge).ends);
    pattern.creases().iter().map(error).collect()
}

/// Returns for each crease the largest error of its direction, radians, with which a proof has to hold that a sheet cannot
/// fold at all: the error that follows from the precision, and at least [`DRAWN_RAD`].
pub(crate) fn drawn_errors(pattern: &CreasePattern) -> Vec<f64> {
    let errors = direction_errors(pattern).into_iter();
    errors.map(|error| error.max(DRAWN_RAD)).collect()
}

/// Returns the creases that the structure of single vertices holds at 0, whatever the size of the fold angles: a real
/// vertex with one crease, with two that are not in line or have opposite signs, or with three. Of three creases the
/// two that are in line, if there are any, can turn.
///
/// A vertex whose other creases are held counts the rest of its creases (unit propagation). Three creases are rigid
/// because their sectors are a spherical triangle whose sides add up to a full turn.
pub(crate) fn held_by_few(pattern: &CreasePattern, signs: &[f64], errors: &[f64]) -> Vec<bool> {
    let mut held = vec![false; signs.len()];
    let mut open: Vec<VertexId> = pattern.real_vertices().collect();
    while let Some(vertex) = open.pop() {
        let still = held_at(pattern, vertex, signs, errors, &held);
        for CreaseId(crease) in still {
            let crease = crease as usize;
            if !core::mem::replace(&mut held[crease], true) {
                let ends = pattern.edge(pattern.creases()[crease]).ends;
                open.extend(ends.into_iter().filter(|&end| pattern.is_real(end)));
            }
        }
    }
    held
}

/// Returns the creases that one vertex holds, given those that are `held` anyway.
pub(crate) fn held_at(
    pattern: &CreasePattern,
    vertex: VertexId,
    signs: &[f64],
    errors: &[f64],
    held: &[bool],
) -> Vec<CreaseId> {
    let star = pattern.stars()[vertex.index()].iter();
    let creases = star.filter_map(|&edge| {
        let crease = pattern.edge(edge).crease?;
        (!held[crease.index()]).then(|| (crease, pattern.direction(edge, vertex)))
    });
    let creases: Vec<(CreaseId, Vector2<f64>)> = creases.collect();
    let in_line = |a: usize, b: usize| {
        let [(a, from), (b, to)] = [creases[a], creases[b]];
        bend(from, to) <= errors[a.index()] + errors[b.index()]
    };
    let all = || creases.iter().map(|(crease, _)| *crease).collect();
    match creases.len() {
        1 => all(),
        2 => {
            let opposite = signs[creases[0].0.index()] * signs[creases[1].0.index()] < 0.0;
            if !in_line(0, 1) || opposite {
                all()
            } else {
                Vec::new()
            }
        }
        3 => match [(0, 1, 2), (1, 2, 0), (2, 0, 1)]
            .iter()
            .find(|(a, b, _)| in_line(*a, *b))
        {
            Some(&(_, _, third)) => vec![creases[third].0],
            None => all(),
        },
        _ => Vec::new(),
    }
}

/// Returns the angle, radians, by which the way against one direction and then along the other bends.
pub(crate) fn bend(from: Vector2<f64>, to: Vector2<f64>) -> f64 {
    from.perp(&-to).atan2(from.dot(&-to)).abs()
}
