//! The accuracy with which a sheet has to be made: the play that its hinges need if the vertices of its panels are off by an error.
//!
//! A *play* is a small motion of a hinge other than its fold: two turns and three shifts, in a frame half way between its two
//! panels, at the middle of the hinge. With J and G the derivatives of closure by fold angles and by all play, a sheet whose
//! vertices are off by dV closes with play s if J dθ + K dV + G s = 0. A shift by the median edge counts as much as a turn by
//! a radian. The
//! sheet is taken to have the play of least sum of squares, which is a linear map of dV. The hinges that drive it stay where
//! they are: to first order, a motion N along the path changes nothing. All of this is to first order.
//!
//! - *Worst case*: with both coordinates of each vertex off by at most E, a component of the play is at most E times the sum of
//!   the absolute values of its row of the map; the corner of the box with the signs of the row attains it.
//! - *Expected*: with independent errors that are uniform in the box, the root mean square of the component is E / √3 times
//!   the Euclidean norm of its row.
//!
//! Closure round a vertex has six rows here, in turns and in shifts, because panels with play need not meet in a point.
//!
//! The map is solved from J dθ + A s = b, where A is G with its weights: s = Aᵀ λ with A Aᵀ λ + J dθ = b and Jᵀ λ = 0. The
//! last condition is added to the first by a penalty, so that one sparse matrix A Aᵀ + ρ J Jᵀ is positive definite, and is met
//! by a few updates of dθ (method of multipliers, Hestenes 1969), which correct a small damping as well (proximal point method,
//! Rockafellar 1976).

use core::time::Duration;
use std::collections::BTreeSet;

use foldpath_core::{HalfAngle, Rotation};
use foldpath_linear::cholesky::Factor;
use foldpath_linear::gram::GramStructure;
use nalgebra::{Matrix5, Vector2, Vector3};
use thiserror::Error;

use super::conditions::{Conditions, Linearised};
use super::{Closing, NoDerivative};
use crate::folding::STEP;
use crate::motion::Motion;
use crate::pattern::{CreaseId, CreasePattern, VertexId};
use crate::progress::{Stage, Watch};
use crate::util::csr::Csr;
use crate::util::nan_max::largest;
use crate::util::parallel;

/// Fold angle of the hinge that is folded most, from which on the sheet is judged, degrees. Nearer to flat, first order says
/// nothing: hinges turn by more than they are folded.
pub const FROM_DEG: f64 = 10.0;
/// Weight of the penalty on Jᵀ λ, over the square of a column of J.
const PENALTY: f64 = 1e8;
/// Number of updates of the multipliers. Each reduces Jᵀ λ by the penalty times the square of a singular value of J.
const UPDATES: usize = 2;
/// Damping over the largest square of an entry, the penalty included: conditions that neither folds nor play change get no
/// force. The updates take its effect away.
const DAMPING: f64 = 1e-12;
/// Smallest part of a play that the rest of the sheet resists, of a hinge that holds nothing that the rest does not hold.
const REDUNDANT: f64 = 1e-6;
/// Play for each length of error up to which it is rounding.
const ROUNDING: f64 = 1e-9;
/// Number of coordinates, of a few vertices, for which play is computed at once.
const BATCH: usize = 8;
/// Rows of a condition: turns and shifts.
const ROWS: usize = 6;
/// Components of the play of a hinge.
const PLAY: usize = 5;

/// A component of the play of a hinge.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum PlayKind {
    /// A turn about the line across the hinge, half way between its panels.
    TurnAcross,
    /// A turn about the common normal of its panels, half way between them.
    TurnAboutNormal,
    /// A shift along the hinge.
    ShiftAlong,
    /// A shift across the hinge: a gap.
    ShiftAcross,
    /// A shift along the normal: a step.
    ShiftAlongNormal,
}

impl PlayKind {
    /// All components, in their order.
    pub const ALL: [Self; PLAY] = [
        Self::TurnAcross,
        Self::TurnAboutNormal,
        Self::ShiftAlong,
        Self::ShiftAcross,
        Self::ShiftAlongNormal,
    ];

    /// Returns the name for people.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::TurnAcross => "turn about the line across the hinge",
            Self::TurnAboutNormal => "turn about the normal",
            Self::ShiftAlong => "shift along the hinge",
            Self::ShiftAcross => "gap",
            Self::ShiftAlongNormal => "step",
        }
    }
}

/// Play that a hinge needs over a motion, for an error of 1.
#[derive(Clone, Debug)]
pub struct HingePlay {
    /// The hinge.
    pub crease: CreaseId,
    /// Its largest play over the motion, in lengths for each length of error: a shift, or a turn times the median edge.
    pub worst: f64,
    /// The component that is largest.
    pub kind: PlayKind,
    /// Time at which it is largest, seconds.
    pub at: f64,
    /// Largest root mean square of a component for independent errors that are uniform in the box, in the same unit.
    pub expected: f64,
    /// Play by the error of each vertex, for the component and the time above. The signs are those of the worst errors.
    pub by_vertex: Vec<Vector2<f64>>,
}

/// The play that a motion needs for errors of its vertices.
#[derive(Clone, Debug)]
pub struct Tolerance {
    /// For each crease, the play that it needs.
    pub hinges: Vec<HingePlay>,
    /// For each vertex, the largest play of any hinge for an error of 1 in both of its coordinates and none elsewhere.
    pub vertices: Vec<f64>,
    /// Hinges of which each may be cut or given any play without another motion of the sheet, at the first, the middle and the
    /// last of the times: the rest of the sheet holds its panels.
    pub redundant: Vec<CreaseId>,
    /// The times that were looked at, seconds: knots and moments between them, so that no hinge turns by much more than
    /// [`STEP`] from one to the next.
    pub times: Vec<f64>,
}

/// Reason why there is no answer.
#[derive(Clone, Copy, Debug, PartialEq, Error)]
#[non_exhaustive]
pub enum NoTolerance {
    /// No hinge is ever folded by [`FROM_DEG`].
    #[error(
        "no hinge is folded by {FROM_DEG} degrees at any time, and nearer to flat play is not known to first order"
    )]
    Flat,
    /// The sheet has too many creases to number their products.
    #[error("the sheet has too many creases")]
    TooLarge,
    /// The caller cancelled the call, or its time is up.
    #[error("time ran out before the play was found")]
    Cancelled,
    /// The motion does not close.
    #[error("at {time:.3} s, {cause}")]
    Open {
        /// The time, seconds.
        time: f64,
        /// The cause.
        cause: NoDerivative,
    },
}

impl Tolerance {
    /// Judges a motion.
    ///
    /// Cost: for each of some ten to fifty times, a sparse factorisation, and solves for each vertex and each hinge.
    ///
    /// # Errors
    /// If the sheet is too large, the motion stays near flat or does not close, or the watch is over.
    pub fn of(motion: &Motion, watch: Watch<'_>) -> Result<Self, NoTolerance> {
        watch.begin(Stage::Folding);
        let pattern = &motion.pattern;
        let conditions = Conditions::new(pattern).ok_or(NoTolerance::TooLarge)?;
        let structure = Structure::new(&conditions).ok_or(NoTolerance::TooLarge)?;
        let steps = motion.with_steps(STEP);
        let angles =
            (0..steps.knots.len()).map(|knot| (steps.knots[knot].time, steps.crease_angles(knot)));
        let places: Vec<(f64, Vec<f64>)> = angles
            .filter(|(_, angles)| {
                largest(angles.iter().map(|angle| angle.abs())) >= FROM_DEG.to_radians()
            })
            .collect();
        if places.is_empty() {
            return Err(NoTolerance::Flat);
        }
        let sheet = Sheet {
            conditions: &conditions,
            structure: &structure,
            places: &places,
            watch,
        };
        let judged = sheet.at_each(0..places.len(), |at| at.play())?;
        let play = judged
            .into_iter()
            .reduce(Play::with)
            .ok_or(NoTolerance::Flat)?;
        // A hinge is redundant at all moments but exceptional ones, or at none.
        let mut few = vec![0, places.len() / 2, places.len() - 1];
        few.dedup();
        let judged = sheet.at_each(few, |at| at.resisted())?;
        let resisted = judged.into_iter().reduce(|mut least, other| {
            least
                .iter_mut()
                .zip(other)
                .for_each(|(least, other)| *least = least.min(other));
            least
        });
        let resisted = resisted.unwrap_or_default();
        let redundant = (0..).map(CreaseId).zip(resisted);
        Ok(Self {
            hinges: sheet.hinges(&play)?,
            vertices: play.vertices,
            redundant: redundant
                .filter(|(_, part)| *part > REDUNDANT)
                .map(|(id, _)| id)
                .collect(),
            times: places.iter().map(|(time, _)| *time).collect(),
        })
    }

    /// Returns the hinge that needs most play; `None` if none needs any.
    #[must_use]
    pub fn worst(&self) -> Option<&HingePlay> {
        let hinges = self.hinges.iter().filter(|hinge| hinge.worst > 0.0);
        hinges.max_by(|a, b| a.worst.total_cmp(&b.worst).then(b.crease.cmp(&a.crease)))
    }

    /// Returns the hinges, those that need most play first.
    #[must_use]
    pub fn ranked_hinges(&self) -> Vec<&HingePlay> {
        let mut ranked: Vec<&HingePlay> = self.hinges.iter().collect();
        ranked.sort_by(|a, b| b.worst.total_cmp(&a.worst));
        ranked
    }

    /// Returns each vertex with the play that its error of 1 costs, those that cost most first.
    #[must_use]
    pub fn ranked_vertices(&self) -> Vec<(VertexId, f64)> {
        let mut ranked: Vec<(VertexId, f64)> = (0..)
            .map(VertexId)
            .zip(self.vertices.iter().copied())
            .collect();
        ranked.sort_by(|a, b| b.1.total_cmp(&a.1));
        ranked
    }

    /// Returns the largest error of each coordinate for which no hinge needs more than this play, in the same unit of length;
    /// `None` if no error needs any.
    #[must_use]
    pub fn error_for(&self, play: f64) -> Option<f64> {
        Some(play / self.worst()?.worst)
    }
}

/// A sheet with the places of its motion.
struct Sheet<'a> {
    conditions: &'a Conditions<'a>,
    structure: &'a Structure,
    /// Times (seconds) and fold angles.
    places: &'a [(f64, Vec<f64>)],
    watch: Watch<'a>,
}

/// A closed configuration.
struct AtPlace<'a> {
    place: usize,
    pattern: &'a CreasePattern,
    solver: Solver<'a>,
    /// Entries of K by row, for each coordinate of each vertex.
    errors: Vec<Vec<(usize, f64)>>,
}

/// The play of all hinges, the worst of some places.
struct Play {
    hinges: Vec<WorstPlay>,
    /// For each vertex, the play that its error costs.
    vertices: Vec<f64>,
}

/// The play of a hinge, in lengths for each length of error.
#[derive(Clone, Copy)]
struct WorstPlay {
    worst: f64,
    /// The component, and the place, at which it is largest.
    kind: usize,
    place: usize,
    expected: f64,
}

impl Play {
    /// Returns the worse of two places, hinge by hinge.
    fn with(mut self, other: Self) -> Self {
        for (hinge, other) in self.hinges.iter_mut().zip(other.hinges) {
            let expected = hinge.expected.max(other.expected);
            if other.worst > hinge.worst {
                *hinge = other;
            }
            hinge.expected = expected;
        }
        let costs = self.vertices.iter_mut().zip(other.vertices);
        costs.for_each(|(own, other)| *own = own.max(other));
        self
    }
}

impl Sheet<'_> {
    /// Does some work at some places, which threads share.
    fn at_each<T: Send>(
        &self,
        places: impl IntoIterator<Item = usize>,
        work: impl Fn(&mut AtPlace<'_>) -> T + Sync,
    ) -> Result<Vec<T>, NoTolerance> {
        let places: Vec<usize> = places.into_iter().collect();
        // One place is a good deal of work.
        let each = Duration::from_millis(1);
        let done = parallel::map(&places, each, |&place| {
            if self.watch.is_over() {
                return Err(NoTolerance::Cancelled);
            }
            let (time, angles) = &self.places[place];
            let closing = Closing::near(self.conditions, angles);
            let closing = closing.map_err(|cause| NoTolerance::Open { time: *time, cause })?;
            let hinges = hinge_entries(self.conditions, &closing.angles);
            let hinges = hinges.ok_or(NoTolerance::TooLarge)?;
            let solver = Solver::new(self.structure, &hinges).ok_or(NoTolerance::TooLarge)?;
            let errors = error_columns(self.conditions, &closing.linearised);
            Ok(work(&mut AtPlace {
                place,
                pattern: self.conditions.pattern(),
                solver,
                errors,
            }))
        });
        done.into_iter().collect()
    }

    /// Returns the play of each hinge, with its row of the map at its worst place.
    fn hinges(&self, play: &Play) -> Result<Vec<HingePlay>, NoTolerance> {
        let places: BTreeSet<usize> = play.hinges.iter().map(|hinge| hinge.place).collect();
        let found = self.at_each(places, |at| {
            let hinges = play.hinges.iter().enumerate();
            let here = hinges.filter(|(_, worst)| worst.place == at.place);
            let here: Vec<(usize, WorstPlay)> =
                here.map(|(hinge, worst)| (hinge, *worst)).collect();
            let (time, _) = self.places[at.place];
            let rows = here.into_iter().map(|(hinge, worst)| HingePlay {
                crease: CreaseId::new(hinge),
                worst: worst.worst,
                kind: PlayKind::ALL[worst.kind],
                at: time,
                expected: worst.expected,
                by_vertex: at.by_vertex(hinge, worst.kind),
            });
            rows.collect::<Vec<_>>()
        })?;
        let mut hinges: Vec<HingePlay> = found.into_iter().flatten().collect();
        hinges.sort_by_key(|hinge| hinge.crease);
        Ok(hinges)
    }
}

impl AtPlace<'_> {
    /// Computes the play some columns of the map at a time, a column for each coordinate of a vertex.
    fn play(&mut self) -> Play {
        let edge = self.pattern.median_edge();
        let count = self.solver.hinges.len();
        let mut sums = vec![[0.0; PLAY]; count];
        let mut squares = vec![[0.0; PLAY]; count];
        let mut vertices = vec![0.0_f64; self.pattern.vertices().len()];
        let mut forces = self.solver.rows::<BATCH>();
        let batches = self.errors.chunks(BATCH);
        for (columns, costs) in batches.zip(vertices.chunks_mut(BATCH / 2)) {
            if columns.iter().all(Vec::is_empty) {
                continue;
            }
            forces.fill([0.0; BATCH]);
            for (at, column) in columns.iter().enumerate() {
                column
                    .iter()
                    .for_each(|(row, value)| forces[*row][at] -= value);
            }
            self.solver.solve(&mut forces);
            let sums = sums.iter_mut().zip(&mut squares);
            for (entries, (sums, squares)) in self.solver.hinges.iter().zip(sums) {
                for (kind, play) in play(entries, &forces).into_iter().enumerate() {
                    // A length for each length.
                    let play = play.map(|play| (play * edge).abs());
                    for play in play {
                        sums[kind] += play;
                        squares[kind] += play * play;
                    }
                    for (cost, of_vertex) in costs.iter_mut().zip(play.chunks_exact(2)) {
                        *cost = cost.max(of_vertex[0] + of_vertex[1]);
                    }
                }
            }
        }
        let worst = sums.iter().zip(&squares).map(|(sums, squares)| {
            let mut kind = 0;
            for (other, sum) in sums.iter().enumerate() {
                if *sum > sums[kind] {
                    kind = other;
                }
            }
            WorstPlay {
                worst: unless_rounding(sums[kind]),
                kind,
                place: self.place,
                expected: unless_rounding(largest(squares.iter().map(|sum| (sum / 3.0).sqrt()))),
            }
        });
        Play {
            hinges: worst.collect(),
            vertices: vertices.into_iter().map(unless_rounding).collect(),
        }
    }

    /// Returns a row of the map. The map from right sides to forces is symmetric, so that a row takes one solve.
    fn by_vertex(&mut self, hinge: usize, kind: usize) -> Vec<Vector2<f64>> {
        let edge = self.pattern.median_edge();
        let mut forces = self.solver.rows::<1>();
        let entries = &self.solver.hinges[hinge];
        entries
            .iter()
            .for_each(|(row, entry)| forces[*row][0] += entry.by_play[kind]);
        self.solver.solve(&mut forces);
        let play = |column: &Vec<(usize, f64)>| {
            let terms = column.iter().map(|(row, value)| value * forces[*row][0]);
            -edge * terms.sum::<f64>()
        };
        let pairs = self.errors.chunks_exact(2);
        pairs
            .map(|pair| Vector2::new(play(&pair[0]), play(&pair[1])))
            .collect()
    }

    /// Returns for each hinge the least part of a play that comes back as play of the whole sheet if it is forced on the hinge:
    /// the smallest eigenvalue of A_hᵀ Π A_h, where Π maps right sides to forces. It is 0 if the sheet moves with the play alone.
    fn resisted(&mut self) -> Vec<f64> {
        let solver = &mut self.solver;
        let mut forces = solver.rows::<PLAY>();
        let hinges = solver.hinges;
        let resisted = hinges.iter().map(|entries| {
            forces.fill([0.0; PLAY]);
            for (row, entry) in entries {
                for (force, by_play) in forces[*row].iter_mut().zip(entry.by_play) {
                    *force += by_play;
                }
            }
            solver.solve(&mut forces);
            // Symmetric but for rounding.
            let matrix = Matrix5::from(play(entries, &forces));
            let symmetric = (matrix + matrix.transpose()) / 2.0;
            symmetric.symmetric_eigenvalues().min()
        });
        resisted.collect()
    }
}

/// Returns a play, or 0 if it is rounding.
fn unless_rounding(play: f64) -> f64 {
    if play <= ROUNDING { 0.0 } else { play }
}

/// Derivatives of a row of a condition by the play and by the fold of a hinge.
#[derive(Clone, Copy)]
struct Entry {
    by_play: [f64; PLAY],
    by_fold: f64,
}

/// The sparse matrix A Aᵀ + ρ J Jᵀ.
struct Structure {
    gram: GramStructure,
    rows: usize,
}

impl Structure {
    fn new(conditions: &Conditions<'_>) -> Option<Self> {
        let cycles = conditions.spokes();
        let rows = ROWS * cycles.len();
        let mut of_hinges = vec![Vec::new(); conditions.pattern().creases().len()];
        for (cycle, spokes) in cycles.iter().enumerate() {
            for &(edge, _) in spokes {
                let crease = conditions.pattern().edge(edge).crease?;
                let first = u32::try_from(ROWS * cycle).ok()?;
                of_hinges[crease.index()].extend((first..).take(ROWS));
            }
        }
        let blocks: Csr<u32> = of_hinges.into_iter().collect();
        Some(Self {
            gram: GramStructure::new(rows, &blocks)?,
            rows,
        })
    }
}

/// The factorised matrix of a configuration.
struct Solver<'s> {
    structure: &'s Structure,
    hinges: &'s [Vec<(usize, Entry)>],
    factor: Factor,
    penalty: f64,
    damping: f64,
}

impl<'s> Solver<'s> {
    fn new(structure: &'s Structure, hinges: &'s [Vec<(usize, Entry)>]) -> Option<Self> {
        let gram = &structure.gram;
        let mut values = vec![0.0; gram.entries];
        let penalty = PENALTY;
        let product = |a: &(usize, Entry), b: &(usize, Entry)| {
            let play = a.1.by_play.iter().zip(&b.1.by_play).map(|(a, b)| a * b);
            play.sum::<f64>() + penalty * a.1.by_fold * b.1.by_fold
        };
        for (hinge, entries) in hinges.iter().enumerate() {
            gram.add(hinge, entries, product, &mut values);
        }
        // A hinge that a loop crosses twice cancels in the sums, which then are rounding.
        let squares = hinges.iter().flatten().map(|entry| product(entry, entry));
        let damping = DAMPING * squares.fold(f64::MIN_POSITIVE, f64::max);
        let mut factor = Factor::new(&gram.symbolic);
        let made = gram
            .symbolic
            .factorise(&values, damping, &mut factor, &|| false);
        made.then_some(Self {
            structure,
            hinges,
            factor,
            penalty,
            damping,
        })
    }

    /// Returns `N` numbers for each row, all 0.
    fn rows<const N: usize>(&self) -> Vec<[f64; N]> {
        vec![[0.0; N]; self.structure.rows]
    }

    /// Replaces right sides b by their forces λ.
    fn solve<const N: usize>(&mut self, forces: &mut [[f64; N]]) {
        let right_sides = forces.to_vec();
        let mut folds = vec![[0.0; N]; self.hinges.len()];
        for update in 0..UPDATES {
            if update > 0 {
                let damped = forces.as_flattened_mut().iter_mut();
                damped
                    .zip(right_sides.as_flattened())
                    .for_each(|(force, b)| *force = b + self.damping * *force);
            }
            for (entries, folds) in self.hinges.iter().zip(&folds) {
                for (row, entry) in entries {
                    for (force, fold) in forces[*row].iter_mut().zip(folds) {
                        *force -= entry.by_fold * fold;
                    }
                }
            }
            let symbolic = &self.structure.gram.symbolic;
            symbolic.solve_many(&mut self.factor, forces);
            if update + 1 < UPDATES {
                for (entries, folds) in self.hinges.iter().zip(&mut folds) {
                    let mut moments = [0.0; N];
                    for (row, entry) in entries {
                        for (moment, force) in moments.iter_mut().zip(forces[*row]) {
                            *moment += entry.by_fold * force;
                        }
                    }
                    for (fold, moment) in folds.iter_mut().zip(moments) {
                        *fold += self.penalty * moment;
                    }
                }
            }
        }
    }
}

/// Returns the play of a hinge under some forces, component by component: its part of Aᵀ λ.
fn play<const N: usize>(entries: &[(usize, Entry)], forces: &[[f64; N]]) -> [[f64; N]; PLAY] {
    let mut play = [[0.0; N]; PLAY];
    for (row, entry) in entries {
        for (sums, by) in play.iter_mut().zip(entry.by_play) {
            for (sum, force) in sums.iter_mut().zip(forces[*row]) {
                *sum += by * force;
            }
        }
    }
    play
}

/// Returns the point about which shifts of each condition are measured: its vertex, or the middle of its hole.
fn centres(conditions: &Conditions<'_>) -> Vec<Vector2<f64>> {
    let (pattern, stars) = (conditions.pattern(), conditions.stars());
    let vertices = stars
        .vertices()
        .iter()
        .map(|vertex| pattern.vertices()[vertex.index()]);
    let holes = stars.holes().iter().map(|&hole| pattern.hole_frame(hole).0);
    vertices.chain(holes).collect()
}

/// Returns the derivatives of the rows that each hinge changes, in the order of [`Structure`].
fn hinge_entries(conditions: &Conditions<'_>, angles: &[f64]) -> Option<Vec<Vec<(usize, Entry)>>> {
    let pattern = conditions.pattern();
    let edge_unit = pattern.median_edge();
    let mut hinges = vec![Vec::new(); angles.len()];
    let cycles = conditions.spokes().iter().zip(centres(conditions));
    for (cycle, (spokes, centre)) in cycles.enumerate() {
        let mut turned = Rotation::identity();
        let mut moved = Vector3::zeros();
        for &(id, from) in spokes {
            let edge = pattern.edge(id);
            let crease = edge.crease?.index();
            let along = pattern.direction(id, from);
            let [a, b] = edge.ends.map(|end| pattern.vertices()[end.index()]);
            let middle = ((a + b) / 2.0 - centre) / edge_unit;
            let at = turned.rotate_in_sheet(middle.into()) + moved;
            let half = HalfAngle::of(angles[crease] / 2.0);
            let between = turned.across_crease(half, along.into());
            let across = Vector2::new(-along.y, along.x);
            let x = between.rotate_in_sheet(along.into());
            let y = between.rotate_in_sheet(across.into());
            // Seen from its other end, a hinge is crossed the other way, with the same normal.
            let sign = if from == edge.ends[0] { 1.0 } else { -1.0 };
            let z = x.cross(&y) * sign;
            let turns = [x, y, z].map(|axis| (axis, at.cross(&axis)));
            let none = Vector3::zeros();
            let columns = [turns[1], turns[2], (none, x), (none, y), (none, z)];
            for row in 0..ROWS {
                let of = |(turn, shift): &(Vector3<f64>, Vector3<f64>)| match row {
                    0..3 => turn[row],
                    _ => shift[row - 3],
                };
                let entry = Entry {
                    by_play: columns.each_ref().map(of),
                    by_fold: of(&turns[0]),
                };
                hinges[crease].push((ROWS * cycle + row, entry));
            }
            turned = between.across_crease(half, along.into());
            moved = at - turned.rotate_in_sheet(middle.into());
        }
    }
    Some(hinges)
}

/// Returns the entries of K by row, for each coordinate of each vertex, with shifts over the median edge.
fn error_columns(conditions: &Conditions<'_>, linearised: &Linearised) -> Vec<Vec<(usize, f64)>> {
    let pattern = conditions.pattern();
    let mut columns = vec![Vec::new(); 2 * pattern.vertices().len()];
    let stars = conditions.stars();
    let count = stars.vertices().len();
    for (block, entries) in linearised.by_vertex.iter().enumerate() {
        // A star has a block of turns, a loop one of turns and one of shifts.
        let past = block.saturating_sub(count);
        let (cycle, part) = match block < count {
            true => (block, 0),
            false => (count + past / 2, past % 2),
        };
        let scale = match part {
            0 => 1.0,
            _ => hole_scale(pattern, stars.holes()[past / 2]),
        };
        for (coordinate, column) in entries {
            let first = ROWS * cycle + 3 * part;
            let rows = (first..).zip(column.iter().map(|value| value * scale));
            columns[*coordinate as usize].extend(rows);
        }
    }
    columns
}

/// Returns the size of a hole over the median edge.
fn hole_scale(pattern: &CreasePattern, hole: usize) -> f64 {
    pattern.hole_frame(hole).1 / pattern.median_edge()
}
