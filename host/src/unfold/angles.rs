//! Measures the fold angles of a shape and settles the letters of its edges.

use core::f64::consts::PI;

use super::surface::{MAX_ROUNDING_RAD, Side, Surface, SurfaceEdge};
use super::{FoldedShape, layout::edge_name};
use crate::folding::fold_angle;
use crate::pattern::Letter;
use crate::util::nan_max::largest;

/// On a shape without noise: angle (radians) below which an edge counts as flat, and distance from half a turn within
/// which the sign of an angle cannot be measured. Well above rounding errors, well below the angles of driven hinges.
const ROUNDING_RAD: f64 = 1e-7;

/// Bounds on the errors of measured angles.
#[derive(Clone, Copy)]
struct Noise {
    /// Radians; an edge without a letter is flat within this angle.
    zero: f64,
    /// Radians; within this distance from flat and from half a turn a letter counts more than the measured angle.
    doubt: f64,
}

impl Noise {
    /// Derives the bounds from the angle defects. Errors of the corners within their planes show in the defects, and
    /// about four defects affect a fold angle. At a flat or flat-folded vertex, errors out of the plane change a defect
    /// only by the square of a fold angle, so the doubt grows with the square root of the defect.
    fn of(surface: &Surface) -> Self {
        let defect = surface.noise();
        Self {
            zero: ROUNDING_RAD.max(4.0 * defect),
            doubt: ROUNDING_RAD.max(4.0 * defect).max(2.0 * defect.sqrt()),
        }
    }

    /// Returns the bounds for an edge whose angle the rounding of coordinates changes by up to `rounding`, radians.
    fn with(self, rounding: f64) -> Self {
        Self {
            zero: self.zero.max(rounding),
            doubt: self.doubt.max(rounding),
        }
    }

    /// Returns the fold angle (radians) of an edge and its letter.
    fn settle(&self, edge: &SurfaceEdge, measured: f64) -> (f64, Letter) {
        let said = edge.letter.unwrap_or(Letter::Unassigned);
        let flat = |letter| matches!(letter, Letter::Flat | Letter::Join);
        let sign = said_sign(edge);
        let against = sign.is_some_and(|sign| sign * measured < 0.0);
        let size = measured.abs();
        if size <= self.zero {
            return (0.0, edge.letter.unwrap_or(Letter::Flat));
        }
        if size <= self.doubt && (flat(said) || against) {
            return (0.0, said);
        }
        let angle = match sign {
            Some(sign) if against && PI - size <= self.doubt => PI.copysign(sign),
            None if PI - size <= self.zero => size,
            _ => measured,
        };
        let letter = if angle > 0.0 {
            Letter::Valley
        } else {
            Letter::Mountain
        };
        (angle, letter)
    }
}

/// Fold angle and letter of each edge of a surface in the pattern.
pub(super) struct Creases {
    /// Fold angles in radians, valley positive; 0 at edges with one face.
    pub(super) angles: Vec<f64>,
    pub(super) letters: Vec<Letter>,
}

impl Creases {
    /// Measures all edges between two faces. A part of the surface whose letters mostly contradict the measured signs
    /// is turned over first, because its letters were written for its other side.
    pub(super) fn measure(
        shape: &FoldedShape,
        surface: &mut Surface,
        notes: &mut Vec<String>,
    ) -> Self {
        let usual = Noise::of(surface);
        let over = against_letters(shape, surface, usual.doubt);
        if over.contains(&true) {
            notes.push(
                "the letters are those of the other side of the faces: the sheet is seen from there".into(),
            );
            surface.turn_over(shape, &over);
        }
        let (mut angles, mut letters) = (Vec::new(), Vec::new());
        let mut flat = Said::default();
        let mut assumed = Said::default();
        let mut other = Said::default();
        let mut zero = usual.zero;
        for edge in &surface.edges {
            let [Some(a), Some(b)] = edge.sides else {
                angles.push(0.0);
                letters.push(Letter::Boundary);
                continue;
            };
            let measured = measured(shape, surface, edge, [a, b]);
            let noise = match edge.letter {
                // An edge that the file letters as a hinge is one, however little it turns.
                Some(letter) if letter.is_hinge() => usual,
                _ => usual.with(rounding(
                    shape,
                    surface,
                    edge,
                    [a, b],
                    surface.length.unit(),
                )),
            };
            let (angle, letter) = noise.settle(edge, measured);
            angles.push(angle);
            letters.push(letter);
            if edge.joint().is_none() {
                continue;
            }
            if letter == Letter::Flat && edge.letter.is_none() {
                flat.add(edge);
                zero = zero.max(noise.zero);
            }
            if PI - angle.abs() <= noise.zero && said_sign(edge).is_none() {
                assumed.add(edge);
            }
            if edge
                .letter
                .is_some_and(|l| l != letter && l != Letter::Unassigned)
            {
                other.add(edge);
            }
        }
        let zero = zero.to_degrees();
        flat.say(
            notes,
            &format!("edges flat to within {zero:.1e} degrees, lettered F"),
        );
        let unknown = "edges folded by 180 degrees, which has no sign that could be measured, and without a \
                       letter, taken as valley";
        assumed.say(notes, unknown);
        other.say(
            notes,
            "edges lettered otherwise than they are folded, lettered as folded",
        );
        if angles.iter().all(|angle| angle.abs() <= 0.0) {
            notes.push("no edge of the shape is folded: the goal is the flat sheet".into());
        }
        Self { angles, letters }
    }

    /// Returns the number of edges that are hinges.
    pub(super) fn hinges(&self) -> usize {
        let hinge = |letter: &&Letter| letter.is_hinge();
        self.letters.iter().filter(hinge).count()
    }
}

/// Number of edges to which one note applies, and the first of them.
#[derive(Default)]
struct Said {
    count: usize,
    first: Option<[usize; 2]>,
}

impl Said {
    fn add(&mut self, edge: &SurfaceEdge) {
        self.count += 1;
        self.first.get_or_insert(edge.ends);
    }

    fn say(&self, notes: &mut Vec<String>, what: &str) {
        if let Some(first) = self.first {
            notes.push(format!(
                "{what}: {} (first: {})",
                self.count,
                edge_name(first)
            ));
        }
    }
}

/// Returns the sign that the file gives an edge, by its letter or else by its angle.
fn said_sign(edge: &SurfaceEdge) -> Option<f64> {
    let signs = [
        edge.letter.map_or(0.0, Letter::sign),
        edge.angle.unwrap_or(0.0),
    ];
    let sign = signs.into_iter().find(|sign| sign.abs() > 0.0);
    sign.map(f64::signum)
}

/// Returns for each part `true` if most of its measurable signs contradict the file.
fn against_letters(shape: &FoldedShape, surface: &Surface, doubt: f64) -> Vec<bool> {
    let mut votes = vec![0_i64; surface.parts()];
    for edge in &surface.edges {
        let (Some(sides), Some(said)) = (edge.joint(), said_sign(edge)) else {
            continue;
        };
        let measured = measured(shape, surface, edge, sides);
        if measured.abs() > doubt && PI - measured.abs() > doubt {
            let part = surface.parts[sides[0].face];
            votes[part] += if said * measured > 0.0 { 1 } else { -1 };
        }
    }
    votes.into_iter().map(|votes| votes < 0).collect()
}

/// Returns the fold angle between two faces, radians.
fn measured(shape: &FoldedShape, surface: &Surface, edge: &SurfaceEdge, [a, b]: [Side; 2]) -> f64 {
    let (left, right) = if surface.is_left(a) { (a, b) } else { (b, a) };
    let [start, end] = edge.ends.map(|end| shape.vertices[end]);
    fold_angle(
        &surface.up(left.face),
        &surface.up(right.face),
        &(end - start),
    )
}

/// Returns the largest change (radians) of the fold angle at an edge by the rounding of coordinates to a unit: each face
/// turns by two units over its width.
fn rounding(
    shape: &FoldedShape,
    surface: &Surface,
    edge: &SurfaceEdge,
    sides: [Side; 2],
    unit: f64,
) -> f64 {
    if unit <= 0.0 {
        return 0.0;
    }
    let [start, end] = edge.ends.map(|end| shape.vertices[end]);
    let along = (end - start).normalize();
    let turns = sides.map(|side| {
        let corners = surface.faces[side.face].iter();
        let off = corners.map(|&v| along.cross(&(shape.vertices[v] - start)).norm());
        2.0 * unit / largest(off)
    });
    (turns[0] + turns[1]).min(MAX_ROUNDING_RAD)
}

/// Returns `true` if an edge is folded a little, but not by more than the rounding of coordinates to a unit explains.
pub(super) fn is_flat_but_for(
    shape: &FoldedShape,
    surface: &Surface,
    edge: &SurfaceEdge,
    unit: f64,
) -> bool {
    edge.joint().is_some_and(|sides| {
        let angle = measured(shape, surface, edge, sides).abs();
        angle > ROUNDING_RAD && angle <= rounding(shape, surface, edge, sides, unit)
    })
}
