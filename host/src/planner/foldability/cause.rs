//! Names what keeps a sheet from folding: the vertex or the part of the sheet, its place, and the size of the fault.

use core::f64::consts::PI;
use core::fmt;

use super::certificate::Lock;
use super::flat_cone::{bend, direction_errors, held_at};
use super::locked_loop::LockedLoop;
use crate::pattern::{ClosureSite, CreasePattern, EdgeId, FlatFlaw, VertexId};
use crate::planner::messages::first_of;
use crate::planner::reason::ProofOrder;
use crate::planner::{Goal, GoalKind};
use crate::util::nan_max::bounding_box;

/// Largest number of vertices or edges that a sentence names.
const MAX_NAMED: usize = 5;
/// Largest bend, radians, of two creases that are meant to be in line: 3 degrees.
const NEARLY_IN_LINE_RAD: f64 = 0.052;
/// Distance from 0 and from half a turn, radians, within which a goal angle counts as flat or folded flat.
const FLAT_RAD: f64 = 1e-6;

/// Something that keeps a sheet, or a part of it, from folding.
#[derive(Clone, Debug, PartialEq)]
pub struct Cause {
    /// What is wrong, and by how much.
    pub kind: CauseKind,
    /// The vertices at which it is wrong, the most important first.
    pub vertices: Vec<VertexId>,
    /// The edges that are kept from turning, if they are known.
    pub edges: Vec<EdgeId>,
    /// The place of the first vertex in the coordinates of the drawing.
    pub at: [f64; 2],
    /// Number of decimals of that place that tell apart vertices of the drawing.
    pub(super) decimals: usize,
}

/// Kind of a [`Cause`].
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub enum CauseKind {
    /// The goal is folded flat, and the vertex cannot fold flat.
    NotFlatFoldable(FlatFlaw),
    /// A real vertex has one crease alone, which cannot turn.
    Degree1,
    /// A real vertex has two creases that are not in line, but bend by this angle (radians); neither can turn.
    Degree2(f64),
    /// A real vertex has two creases that are nearly in line, but bend by this angle (radians); neither can turn.
    NotInLine(f64),
    /// A real vertex has two creases in line, a mountain and a valley; neither can turn.
    LettersChange,
    /// A real vertex has three creases, which cannot turn, apart from two that are in line.
    Degree3,
    /// The conditions at some vertices leave creases that cannot turn in a first step from flat along their letters.
    LockedPart,
    /// The ratios in which the letters let neighbouring creases turn multiply to this number round a loop of vertices, and
    /// not to 1; none of the creases can turn.
    LockedLoop(f64),
    /// No crease can turn along the letters: no rates but 0 satisfy the conditions at the vertices to first order.
    EmptyCone,
    /// The conditions at some vertices hold creases that could turn to first order: the sheet would not close to second
    /// order.
    SecondOrder,
}

impl CauseKind {
    /// Returns the name of the kind for programs.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::NotFlatFoldable(FlatFlaw::Odd(_)) => "odd-degree",
            Self::NotFlatFoldable(FlatFlaw::Kawasaki(_)) => "kawasaki",
            Self::NotFlatFoldable(FlatFlaw::Maekawa(..)) => "maekawa",
            Self::Degree1 => "degree-1",
            Self::Degree2(_) => "degree-2",
            Self::NotInLine(_) => "not-in-line",
            Self::LettersChange => "letters-change-on-a-line",
            Self::Degree3 => "degree-3",
            Self::LockedPart => "locked-part",
            Self::LockedLoop(_) => "locked-loop",
            Self::EmptyCone => "empty-cone",
            Self::SecondOrder => "second-order",
        }
    }
}

impl fmt::Display for Cause {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let decimals = self.decimals;
        let [x, y] = self
            .at
            .map(|at| format!("{at:.decimals$}").parse().unwrap_or(at) + 0.0);
        let vertex = self.vertices.first().copied().unwrap_or_default();
        write!(f, "vertex {vertex} at ({x}, {y}): ")?;
        let edges = named("edge", &self.edges);
        let others = self.vertices.get(1..).unwrap_or_default();
        let with = if others.is_empty() {
            String::new()
        } else {
            format!(" together with {}", named("vertex", others))
        };
        match self.kind {
            CauseKind::NotFlatFoldable(FlatFlaw::Odd(count)) => {
                write!(f, "{count} creases, an odd number, which cannot fold flat")
            }
            CauseKind::NotFlatFoldable(FlatFlaw::Kawasaki(sum)) => write!(
                f,
                "Kawasaki: every other sector adds up to {} degrees, not 180",
                off_by(sum.to_degrees(), 180.0)
            ),
            CauseKind::NotFlatFoldable(FlatFlaw::Maekawa(mountains, valleys)) => write!(
                f,
                "Maekawa: {mountains} mountains and {valleys} valleys, which should differ by 2"
            ),
            CauseKind::Degree1 => write!(f, "{edges} ends inside the sheet and cannot turn"),
            CauseKind::Degree2(bend) => write!(
                f,
                "two creases alone that are not in line ({:.1} degrees off) cannot turn: {edges}",
                bend.to_degrees()
            ),
            CauseKind::NotInLine(bend) => write!(
                f,
                "two creases that are nearly in line, but {} degrees off, cannot turn: {edges}",
                six_digits(bend.to_degrees())
            ),
            CauseKind::LettersChange => write!(
                f,
                "the letter changes from M to V along a straight line, which cannot turn: {edges}"
            ),
            CauseKind::Degree3 => write!(f, "of three creases alone, these cannot turn: {edges}"),
            CauseKind::LockedPart => write!(
                f,
                "its conditions{with} let these not turn along their letters in a first step from flat: {edges}"
            ),
            CauseKind::LockedLoop(product) => write!(
                f,
                "round a loop{with} the ratios in which its creases turn multiply to {:.3}, not 1, so that these cannot \
                 turn: {edges}",
                product
            ),
            CauseKind::SecondOrder => write!(
                f,
                "its conditions{with} let these not turn along their letters, as the sheet would not close to second \
                 order: {edges}"
            ),
            CauseKind::EmptyCone => write!(
                f,
                "its conditions{with} let no crease turn along its letter in a first step from flat"
            ),
        }
    }
}

/// Returns the number of decimals with which a coordinate has six digits of the size of the sheet, wherever the sheet lies.
fn decimals(pattern: &CreasePattern) -> usize {
    let (low, high) = bounding_box(pattern.vertices().iter().copied()).unwrap_or_default();
    let digits = 5.0 - (high - low).amax().max(f64::MIN_POSITIVE).log10().floor();
    #[allow(
        clippy::cast_possible_truncation,
        clippy::cast_sign_loss,
        reason = "0 to 300"
    )]
    let decimals = digits.clamp(0.0, 300.0) as usize;
    decimals
}

/// Returns the number with six significant digits.
fn six_digits(x: f64) -> f64 {
    format!("{x:.5e}").parse().unwrap_or(x)
}

/// Writes an angle with as many decimals as its difference from another angle needs, at least one.
fn off_by(degrees: f64, other: f64) -> String {
    let decimals = (1..9).find(|&decimals| {
        let unit = 0.1_f64.powi(decimals);
        (degrees - other).abs() >= unit
    });
    #[allow(clippy::cast_sign_loss, reason = "1 to 8")]
    let decimals = decimals.unwrap_or(8) as usize;
    format!("{degrees:.decimals$}")
}

/// Names the first ids, and counts the others.
fn named(what: &str, ids: &[impl fmt::Display]) -> String {
    let plural = match (what, ids.len()) {
        (_, 1) => what.to_string(),
        ("vertex", _) => "vertices".into(),
        _ => format!("{what}s"),
    };
    format!("{plural} {}", first_of(ids, MAX_NAMED))
}

/// Returns the causes at single vertices: too few creases, and, if the goal is folded flat, the theorems of Kawasaki and
/// Maekawa. Cost: linear.
pub(super) fn at_vertices(
    pattern: &CreasePattern,
    signs: &[f64],
    goal: Option<&Goal>,
) -> Vec<Cause> {
    let errors = direction_errors(pattern);
    let none_held = vec![false; signs.len()];
    let mut causes = Vec::new();
    for vertex in pattern.real_vertices() {
        let star = pattern.stars()[vertex.index()].iter();
        let creases = star.filter_map(|&edge| {
            let crease = pattern.edge(edge).crease?;
            Some((crease.index(), pattern.direction(edge, vertex)))
        });
        let creases: Vec<_> = creases.collect();
        let kind = match creases[..] {
            [_] => CauseKind::Degree1,
            [(a, from), (b, to)] => match bend(from, to) {
                bend if bend <= errors[a] + errors[b] => CauseKind::LettersChange,
                bend if bend < NEARLY_IN_LINE_RAD => CauseKind::NotInLine(bend),
                bend => CauseKind::Degree2(bend),
            },
            [_, _, _] => CauseKind::Degree3,
            _ => continue,
        };
        let held = held_at(pattern, vertex, signs, &errors, &none_held);
        if held.is_empty() {
            continue;
        }
        let edges = held.iter().map(|crease| pattern.creases()[crease.index()]);
        causes.push(Cause {
            kind,
            vertices: vec![vertex],
            edges: edges.collect(),
            at: pattern.drawn_place(vertex),
            decimals: decimals(pattern),
        });
    }
    if goal.is_some_and(is_folded_flat) {
        let known: Vec<VertexId> = causes
            .iter()
            .flat_map(|cause| cause.vertices.clone())
            .collect();
        let flaws = pattern.flat_flaws().into_iter();
        let new = flaws.filter(|(vertex, _)| known.binary_search(vertex).is_err());
        causes.extend(new.map(|(vertex, flaw)| Cause {
            kind: CauseKind::NotFlatFoldable(flaw),
            vertices: vec![vertex],
            edges: Vec::new(),
            at: pattern.drawn_place(vertex),
            decimals: decimals(pattern),
        }));
    }
    causes
}

/// Makes the cause of creases that are proved to be locked, which is of this kind if first order decides.
pub(super) fn of_lock(pattern: &CreasePattern, lock: &Lock, kind: CauseKind) -> Cause {
    let kind = match lock.order {
        ProofOrder::First => kind,
        ProofOrder::Second => CauseKind::SecondOrder,
    };
    let vertices = lock.sites.iter().map(|site| match site {
        ClosureSite::Vertex(vertex) | ClosureSite::Hole(vertex) => *vertex,
    });
    of_creases(pattern, kind, vertices.collect(), &lock.creases)
}

/// Makes the cause of creases that a loop of vertices locks.
pub(super) fn of_loop(pattern: &CreasePattern, locked: &LockedLoop) -> Cause {
    let kind = CauseKind::LockedLoop(locked.product);
    of_creases(pattern, kind, locked.vertices.clone(), &locked.creases)
}

/// Makes a cause at some vertices that keeps some creases from turning.
fn of_creases(
    pattern: &CreasePattern,
    kind: CauseKind,
    vertices: Vec<VertexId>,
    creases: &[usize],
) -> Cause {
    let edges = creases.iter().map(|&crease| pattern.creases()[crease]);
    Cause {
        kind,
        at: pattern.drawn_place(vertices.first().copied().unwrap_or_default()),
        decimals: decimals(pattern),
        edges: edges.collect(),
        vertices,
    }
}

/// Returns `true` if the goal is a flat-folded sheet: letters, or angles that are all 0 or half a turn.
fn is_folded_flat(goal: &Goal) -> bool {
    let mut asked = goal.fold_angles.iter().flatten();
    goal.kind == GoalKind::Letters
        || asked.all(|angle| angle.abs() > PI - FLAT_RAD || angle.abs() < FLAT_RAD)
}
