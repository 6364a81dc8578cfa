//! Finds faces that lie on each other in the plane. Faces that only touch do not.

use nalgebra::Vector2;

use super::ShapeError;
use super::surface::Surface;
use crate::pattern::{CreasePattern, Drawing, DrawnEdge};
use crate::util::nan_max::bounding_box;

/// Budget of compared pairs of convex pieces: the first number for each piece, but in all at least the second. If it is
/// spent, the check of the crease pattern has the last word.
const MAX_PAIRS: [usize; 2] = [1 << 10, 1 << 24];

/// The faces of a surface, each cut into convex pieces.
pub(super) struct ConvexFaces {
    /// For each face its pieces, each as a counter-clockwise cycle of corners of the surface.
    pieces: Vec<Vec<Vec<usize>>>,
}

/// A convex piece at its place in the plane.
struct Placed {
    face: usize,
    polygon: Vec<Vector2<f64>>,
    low: Vector2<f64>,
    high: Vector2<f64>,
}

impl ConvexFaces {
    /// Cuts the faces of a surface. Convex faces stay whole.
    ///
    /// # Errors
    /// If a face crosses itself, or has too many corners.
    pub(super) fn new(surface: &Surface) -> Result<Self, ShapeError> {
        let faces = 0..surface.faces.len();
        let pieces = faces.map(|face| {
            let cycle = surface.cycle(face);
            let polygon: Vec<_> = cycle.iter().map(|&c| surface.local[c]).collect();
            if is_convex(&polygon) {
                return Ok(vec![cycle]);
            }
            let alone = alone(polygon);
            let alone = alone.map_err(|error| ShapeError::NotSimple {
                face,
                why: error.to_string(),
            })?;
            let triangles = alone.triangles().items().iter();
            let named = |triangle: &[_; 3]| {
                let corner = |v: &crate::pattern::VertexId| cycle[v.index()];
                triangle.iter().map(corner).collect()
            };
            Ok(triangles.map(named).collect())
        });
        Ok(Self {
            pieces: pieces.collect::<Result<_, _>>()?,
        })
    }

    /// Returns pairs of the given faces that lie deeper in each other than `tolerance`, at most `most` of them. `places`
    /// has the places of all corners.
    pub(super) fn overlaps(
        &self,
        faces: impl Iterator<Item = usize>,
        places: &[Vector2<f64>],
        tolerance: f64,
        most: usize,
    ) -> Vec<[usize; 2]> {
        let mut placed: Vec<Placed> = faces.flat_map(|face| self.placed(face, places)).collect();
        let (low, high) =
            bounding_box(placed.iter().flat_map(|it| [it.low, it.high])).unwrap_or_default();
        let axis = (high - low).imax();
        placed.sort_by(|a, b| a.low[axis].total_cmp(&b.low[axis]));
        let budget = MAX_PAIRS[1].max(MAX_PAIRS[0] * placed.len());
        let (mut found, mut tested) = (Vec::new(), 0);
        for (k, a) in placed.iter().enumerate() {
            let near = placed[k + 1..].iter();
            for b in near.take_while(|b| b.low[axis] < a.high[axis]) {
                tested += 1;
                if a.face != b.face && a.lies_in(b, tolerance) {
                    found.push([a.face.min(b.face), a.face.max(b.face)]);
                    if found.len() >= most {
                        return found;
                    }
                }
            }
            if tested > budget {
                break;
            }
        }
        found.sort_unstable();
        found.dedup();
        found
    }

    /// Returns `true` if a face of the first list lies deeper in one of the second than `tolerance`.
    pub(super) fn do_overlap(
        &self,
        faces: [&[usize]; 2],
        places: &[Vector2<f64>],
        tolerance: f64,
    ) -> bool {
        let [first, second] = faces.map(|faces| {
            let placed = faces.iter().flat_map(|&face| self.placed(face, places));
            placed.collect::<Vec<_>>()
        });
        let any = |a: &Placed| second.iter().any(|b| a.lies_in(b, tolerance));
        first.iter().any(any)
    }

    fn placed<'a>(
        &'a self,
        face: usize,
        places: &'a [Vector2<f64>],
    ) -> impl Iterator<Item = Placed> + use<'a> {
        self.pieces[face].iter().map(move |piece| {
            let polygon: Vec<_> = piece.iter().map(|&corner| places[corner]).collect();
            let (low, high) = bounding_box(polygon.iter().copied()).unwrap_or_default();
            Placed {
                face,
                polygon,
                low,
                high,
            }
        })
    }
}

impl Placed {
    /// Returns `true` if two pieces lie deeper in each other than `tolerance` (separating axis theorem).
    fn lies_in(&self, other: &Self, tolerance: f64) -> bool {
        let apart = |k: usize| {
            let depth = self.high[k].min(other.high[k]) - self.low[k].max(other.low[k]);
            depth <= tolerance
        };
        !apart(0) && !apart(1) && self.is_deep(other, tolerance) && other.is_deep(self, tolerance)
    }

    /// Returns `true` if no side of this piece has the other piece beyond it, to within `tolerance`.
    fn is_deep(&self, other: &Self, tolerance: f64) -> bool {
        let next = self.polygon.iter().cycle().skip(1);
        self.polygon.iter().zip(next).all(|(&a, &b)| {
            let length = (b - a).norm();
            let inside = |p: &Vector2<f64>| (b - a).perp(&(p - a)) > tolerance * length;
            other.polygon.iter().any(inside)
        })
    }
}

/// Returns `true` if a counter-clockwise polygon turns nowhere to the right and goes round once.
fn is_convex(polygon: &[Vector2<f64>]) -> bool {
    let count = polygon.len();
    let side = |k: usize| polygon[(k + 1) % count] - polygon[k % count];
    let turns = (0..count).map(|k| side(k).perp(&side(k + 1)).atan2(side(k).dot(&side(k + 1))));
    let turns: Vec<f64> = turns.collect();
    turns.iter().all(|turn| *turn >= -1e-9) && turns.iter().sum::<f64>() < 7.0
}

/// Returns the pattern of one face alone, which has its triangles.
fn alone(polygon: Vec<Vector2<f64>>) -> Result<CreasePattern, crate::pattern::PatternError> {
    let count = polygon.len();
    let sides = (0..count).map(|k| DrawnEdge::boundary([k, (k + 1) % count]));
    CreasePattern::new(Drawing {
        vertices: polygon,
        edges: sides.collect(),
        faces: Some(vec![(0..count).collect()]),
    })
}
