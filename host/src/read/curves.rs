//! Curves of borders, windows, cuts and marks become chords. A crease has to be straight: rigid panels turn about a line.

use kurbo::{CubicBez, ParamCurve, ParamCurveArclen, ParamCurveNearest, Point};
use nalgebra::Vector2;

use super::segments::MAX_LINES;
use crate::pattern::rounded;
use crate::util::nan_max::diagonal;

/// Largest distance of a curve from its chords, as a fraction of the drawing's diagonal. A circle as wide as the sheet has
/// about seventy chords, and the corner of a carton some four.
const CHORD_RATIO: f64 = 5e-4;

/// Largest distance of the end of another line from the curve on which it is meant to end, as a fraction of the diagonal. The
/// curve gets a corner there, so that the line meets a chord's end.
const MEETS_RATIO: f64 = 1e-4;

/// Accuracy of lengths and of places on a curve, in the largest distance between curve and chord.
const ACCURACY_RATIO: f64 = 1e-3;

/// Largest coordinate that is noise, as a fraction of the size of the curve.
const NOISE_RATIO: f64 = 1e-9;

/// Number of places on a curve that are told apart.
const PARTS: f64 = (1_u32 << 30) as f64;

/// Largest number of comparisons of ends with curves. Ends that are not compared are joined to the chords like any others.
const MAX_COMPARED: usize = 1 << 24;

/// Expected shape of a crease.
pub(super) const STRAIGHT_CREASE: &str = "a straight crease, as rigid panels turn about a line";

/// A cubic Bézier curve: its start, its two control points and its end.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Curve(pub(super) [Vector2<f64>; 4]);

/// A piece of an outline.
#[cfg(feature = "svg")]
pub(super) enum Piece {
    Line([Vector2<f64>; 2]),
    Curve(Curve),
}

#[cfg(feature = "dxf")]
impl Piece {
    /// Returns its ends, and between them the control points of a curve.
    pub(super) fn hull(&self) -> &[Vector2<f64>] {
        match self {
            Self::Line(ends) => ends,
            Self::Curve(Curve(hull)) => hull,
        }
    }

    /// Returns the same points, to be changed.
    pub(super) fn hull_mut(&mut self) -> &mut [Vector2<f64>] {
        match self {
            Self::Line(ends) => ends,
            Self::Curve(Curve(hull)) => hull,
        }
    }

    /// Returns the line between the ends of a curve that runs along it within a distance, and the piece itself otherwise.
    pub(super) fn straight(&self, within: f64) -> Self {
        match *self {
            Self::Curve(curve) if curve.is_straight(within) => Self::Line([curve.0[0], curve.0[3]]),
            Self::Curve(curve) => Self::Curve(curve),
            Self::Line(ends) => Self::Line(ends),
        }
    }
}

/// Curves of one drawing that become chords.
pub(super) struct Chords {
    /// Largest distance between a curve and its chords.
    tolerance: f64,
    meets: f64,
    /// The ends of all lines, by their x.
    ends: Vec<Vector2<f64>>,
    curves: usize,
    chords: usize,
    compared: usize,
}

impl Curve {
    /// Returns `true` if the curve is the line between its ends, within this distance.
    pub(super) fn is_straight(&self, within: f64) -> bool {
        let Self([from, a, b, to]) = *self;
        let length = (to - from).norm();
        let along = (to - from) / length.max(f64::MIN_POSITIVE);
        [a, b].iter().all(|control| {
            let offset = control - from;
            let part = offset.dot(&along);
            offset.perp(&along).abs() <= within
                && (offset - along * part).norm() <= within
                && part >= -within
                && part <= length + within
        })
    }

    /// Describes the curve by its length and its ends. `drawn` takes a place to the drawing's own coordinates.
    pub(super) fn in_words(&self, drawn: impl Fn(Vector2<f64>) -> [f64; 2]) -> String {
        let Self([from, .., to]) = *self;
        let size = diagonal(&self.0);
        // Sines leave noise where a coordinate is 0.
        let shown = |c: f64| {
            if c.abs() < NOISE_RATIO * size {
                0.0
            } else {
                rounded(c)
            }
        };
        let [[x, y], [u, v]] = [from, to].map(|at| drawn(at).map(shown));
        let length = self.bezier().arclen(ACCURACY_RATIO * size);
        format!("a curve {length:.3e} long from ({x}, {y}) to ({u}, {v})")
    }

    fn bezier(&self) -> CubicBez {
        let [a, b, c, d] = self.0.map(|at| Point::new(at.x, at.y));
        CubicBez::new(a, b, c, d)
    }
}

/// Returns the number of chords between equally spaced parameters that are within `tolerance` of a curve (G. Wang, "The
/// subdivision method for finding the intersection between two Bézier curves or surfaces", 1984). Square roots are the same
/// on every machine.
fn chords_of(curve: &CubicBez, tolerance: f64) -> usize {
    let bend = |a: Point, b: Point, c: Point| ((c - b) - (b - a)).hypot2().sqrt();
    let most = bend(curve.p0, curve.p1, curve.p2).max(bend(curve.p1, curve.p2, curve.p3));
    let count = (0.75 * most / tolerance).sqrt().ceil().max(1.0);
    #[allow(
        clippy::cast_possible_truncation,
        clippy::cast_sign_loss,
        reason = "positive, and saturates"
    )]
    let count = count as usize;
    count
}

impl Chords {
    /// Prepares the chords of a drawing with these points, the control points of curves among them, in which lines end at
    /// these places.
    pub(super) fn new(points: &[Vector2<f64>], mut ends: Vec<Vector2<f64>>) -> Self {
        let size = diagonal(points);
        ends.sort_by(|a, b| a.x.total_cmp(&b.x).then(a.y.total_cmp(&b.y)));
        ends.dedup();
        Self {
            tolerance: CHORD_RATIO * size,
            meets: MEETS_RATIO * size,
            ends,
            curves: 0,
            chords: 0,
            compared: 0,
        }
    }

    /// Prepares the chords of the curves of a drawing of these pieces.
    #[cfg(feature = "svg")]
    pub(super) fn of_pieces<'p>(pieces: impl Iterator<Item = &'p Piece>) -> Self {
        let (mut points, mut ends) = (Vec::new(), Vec::new());
        for piece in pieces {
            match piece {
                Piece::Line([from, to]) | Piece::Curve(Curve([from, .., to])) => {
                    ends.extend([*from, *to]);
                }
            }
            if let Piece::Curve(Curve(hull)) = piece {
                points.extend(hull);
            }
        }
        points.extend(&ends);
        Self::new(&points, ends)
    }

    /// Returns the ends of the lines that a piece becomes, from its start to its end. Returns `None` if the drawing has too
    /// many chords.
    #[cfg(feature = "svg")]
    pub(super) fn lines_of(&mut self, piece: &Piece) -> Option<Vec<[Vector2<f64>; 2]>> {
        match piece {
            Piece::Line(ends) => Some(vec![*ends]),
            Piece::Curve(curve) => Some(self.of(curve)?.windows(2).map(|p| [p[0], p[1]]).collect()),
        }
    }

    /// Returns the places from the start of a curve to its end between which its chords run. Returns `None` if the drawing
    /// has too many chords.
    pub(super) fn of(&mut self, curve: &Curve) -> Option<Vec<Vector2<f64>>> {
        let Curve([from, .., to]) = *curve;
        let mut places = vec![from];
        let whole = curve.bezier();
        let mut start = 0.0;
        for (part, place) in self.met(curve).into_iter().chain([(1.0, to)]) {
            let piece = whole.subsegment(start..part);
            let count = chords_of(&piece, self.tolerance).min(MAX_LINES);
            self.chords += count;
            if self.chords > MAX_LINES {
                return None;
            }
            #[allow(clippy::cast_precision_loss, reason = "at most MAX_LINES")]
            let inner = (1..count).map(|k| piece.eval(k as f64 / count as f64));
            places.extend(inner.map(|at| Vector2::new(at.x, at.y)));
            places.push(place);
            start = part;
        }
        places.dedup();
        self.curves += 1;
        Some(places)
    }

    /// Returns the ends of lines on a curve, apart from its own ends, each with its parameter, in their order.
    fn met(&mut self, curve: &Curve) -> Vec<(f64, Vector2<f64>)> {
        let hull = curve.0;
        let (mut low, mut high) = (hull[0], hull[0]);
        for at in hull {
            (low, high) = (low.inf(&at), high.sup(&at));
        }
        let near = Vector2::repeat(self.meets);
        let (low, high) = (low - near, high + near);
        let first = self.ends.partition_point(|end| end.x < low.x);
        let candidates = self.ends[first..].iter().take_while(|end| end.x <= high.x);
        let mut met = Vec::new();
        for &end in candidates {
            self.compared += 1;
            if self.compared > MAX_COMPARED {
                break;
            }
            let is_own = [hull[0], hull[3]]
                .iter()
                .any(|own| (own - end).norm() <= self.meets);
            if is_own || end.y < low.y || end.y > high.y {
                continue;
            }
            let accuracy = ACCURACY_RATIO * self.meets;
            let nearest = curve.bezier().nearest(Point::new(end.x, end.y), accuracy);
            if nearest.distance_sq <= self.meets * self.meets {
                // The solver of cubics rounds otherwise on another machine; the last digits of its answer are left out.
                let part = (nearest.t * PARTS).round() / PARTS;
                met.push((part, end));
            }
        }
        met.sort_by(|a, b| a.0.total_cmp(&b.0));
        met.dedup_by(|a, b| (a.1 - b.1).norm() <= self.meets);
        met
    }

    /// Returns a note of the curves that became chords, if there are any.
    pub(super) fn note(&self) -> Option<String> {
        let Self {
            curves,
            chords,
            tolerance,
            ..
        } = self;
        (*curves > 0).then(|| {
            format!("curves drawn as chords: {curves}, by {chords} chords that are within {tolerance:.1e} of them")
        })
    }
}
