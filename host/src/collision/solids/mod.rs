//! Panels as plates: solids that keep the motion of the thin sheet, with material trimmed where it would be in the way.
//!
//! The hinge plane of a plate is the plane of the thin sheet. At height h over it, on the side on which a hinge closes, the
//! material stays back from the hinge by h tan(ρ/2), with ρ the largest fold angle of the hinge on that side along the motion
//! and a margin (T. Tachi, "Rigid-Foldable Thick Origami", Origami 5, 2011). So two neighbours lie on their sides of the plane
//! that halves the angle between them, at any fold angle up to ρ, and touch along it at ρ. With upright sides the material
//! stays back at all heights by as much as at the outermost.
//!
//! A plate is given by its outlines at a few heights, between which it is straight. It is a convex solid, or a union of such
//! ([`solid`]).

mod outline;
pub(super) mod solid;
mod thickest;

pub(crate) use thickest::thickest;
pub use thickest::{Thickest, TooThick};

use std::collections::HashMap;

use nalgebra::Vector2;
use thiserror::Error;

use self::outline::inset;
use super::convex::{convex_parts, is_convex};
use crate::motion::{MAX_PLATE_ANGLE_DEG, PlateOptions, PlateSides};
use crate::pattern::{CreasePattern, EdgeId, FaceId, VertexId};
use crate::util::union_find::UnionFind;

/// Length up to which plates of one form may differ, median edges.
const FORM_EDGES: f64 = 1e-7;

/// A sheet that cannot be made of plates.
#[derive(Clone, Copy, Debug, PartialEq, Error)]
#[non_exhaustive]
pub enum PlateError {
    /// A hinge turns farther than tapers reach.
    #[error(
        "the hinge at edge {edge} turns to {:.6} degrees: plates with a thickness turn by at most {MAX_PLATE_ANGLE_DEG}",
        angle.to_degrees()
    )]
    TurnsTooFar {
        /// Edge of the hinge.
        edge: EdgeId,
        /// Its angle, radians.
        angle: f64,
    },
    /// Nothing is left of a panel, or not of its side at an edge, once its sides stay back as they have to.
    #[error(
        "panel {face} is used up at a thickness of {thickness}: its sides stay back so far from the hinges that nothing is \
         left at edge {edge}"
    )]
    UsedUp {
        /// The first face of the panel.
        face: FaceId,
        /// The edge of which nothing is left.
        edge: EdgeId,
        /// Thickness of the plates, units of the sheet.
        thickness: f64,
    },
}

/// A panel of the sheet: faces that are joined by edges that stay flat.
#[derive(Clone, Debug)]
pub struct Plate {
    /// Its faces; the first names it.
    pub faces: Vec<FaceId>,
    /// Its corners, counter-clockwise.
    pub corners: Vec<VertexId>,
    /// The edge from each corner to the next.
    pub sides: Vec<EdgeId>,
    /// Its outline at each of the heights of [`Plates::heights`]: the place of each corner.
    pub outlines: Vec<Vec<Vector2<f64>>>,
    /// Its convex parts, each a cycle of vertices.
    pub(super) parts: Vec<Vec<VertexId>>,
}

impl Plate {
    /// Returns the places of a vertex of the plate at each of its heights. Vertices inside the plate stay where they are.
    pub(super) fn places(&self, pattern: &CreasePattern, vertex: VertexId) -> Vec<Vector2<f64>> {
        let corner = self.corners.iter().position(|corner| *corner == vertex);
        let place = |outline: &Vec<Vector2<f64>>| {
            corner.map_or(pattern.vertices()[vertex.index()], |corner| outline[corner])
        };
        self.outlines.iter().map(place).collect()
    }
}

/// The plates of a sheet for one motion.
#[derive(Clone, Debug)]
pub struct Plates {
    /// Thickness, hinge plane and sides.
    pub options: PlateOptions,
    /// Heights of the outlines over the hinge plane, in increasing order.
    pub heights: Vec<f64>,
    /// The plates.
    pub list: Vec<Plate>,
    /// The plate of each face.
    pub of_face: Vec<usize>,
    /// For each crease the tangents of half its largest angles as a mountain and as a valley, without the margin.
    tangents: Vec<[f64; 2]>,
}

impl Plates {
    /// Makes the plates for a motion on which each crease keeps to a range of angles (radians). Cost: O(faces), but for
    /// panels of very many corners.
    ///
    /// # Errors
    /// If a hinge turns too far, or a panel is used up.
    pub fn new(
        pattern: &CreasePattern,
        ranges: &[[f64; 2]],
        options: &PlateOptions,
    ) -> Result<Self, PlateError> {
        Self::of_all(pattern, ranges, options, options.thickness)
    }

    /// Makes solids that contain the plates of all thicknesses from `least` to that of the options. Tapered plates contain
    /// all thinner ones, and with a least thickness of 0, plates with upright sides are contained in tapered ones.
    ///
    /// # Errors
    /// As [`new`](Self::new).
    pub(crate) fn of_all(
        pattern: &CreasePattern,
        ranges: &[[f64; 2]],
        options: &PlateOptions,
        least: f64,
    ) -> Result<Self, PlateError> {
        let limit = MAX_PLATE_ANGLE_DEG.to_radians();
        for (&edge, range) in pattern.creases().iter().zip(ranges) {
            if let Some(&angle) = range.iter().find(|angle| !(angle.abs() <= limit)) {
                return Err(PlateError::TurnsTooFar { edge, angle });
            }
        }
        let tangents = |margin: f64| {
            let tangent = |most: f64| {
                if most > 0.0 {
                    ((most + margin) / 2.0).tan()
                } else {
                    0.0
                }
            };
            let both = move |range: &[f64; 2]| [tangent(-range[0]), tangent(range[1])];
            ranges.iter().map(both).collect::<Vec<_>>()
        };
        let trims = tangents(options.margin);
        let heights = |thickness| options.with(|it| it.thickness = thickness).heights();
        let ([below, above], [less_below, less_above]) =
            (heights(options.thickness), heights(least));
        let mut layers: Vec<(f64, [f64; 2])> = match options.sides {
            PlateSides::Taper => vec![
                (-below, [below, 0.0]),
                (0.0, [0.0; 2]),
                (above, [0.0, above]),
            ],
            PlateSides::Inset => vec![
                (-below, [below, above]),
                (-less_below, [less_below, less_above]),
                (less_above, [less_below, less_above]),
                (above, [below, above]),
            ],
        };
        layers.dedup();
        let gap = if options.sides == PlateSides::Inset {
            options.gap
        } else {
            0.0
        };
        let mut plates = Self {
            options: *options,
            heights: layers.iter().map(|(height, _)| *height).collect(),
            of_face: vec![0; pattern.faces().len()],
            list: panels(pattern),
            tangents: tangents(0.0),
        };
        for (index, plate) in plates.list.iter_mut().enumerate() {
            for face in &plate.faces {
                plates.of_face[face.index()] = index;
            }
            let crease = |side: usize| pattern.edge(plate.sides[side]).crease;
            let corners: Vec<_> = plate
                .corners
                .iter()
                .map(|v| pattern.vertices()[v.index()])
                .collect();
            for (_, [down, up]) in &layers {
                let insets = (0..corners.len()).map(|side| {
                    let trim = crease(side).map(|crease| trims[crease.index()]);
                    let turns = trim.filter(|trim| trim[0].max(trim[1]) > 0.0);
                    turns.map_or(0.0, |[mountain, valley]| {
                        (down * mountain).max(up * valley).max(gap)
                    })
                });
                let insets: Vec<f64> = insets.collect();
                let outline = inset(&corners, &insets, |side| crease(side).is_none());
                plate
                    .outlines
                    .push(outline.map_err(|side| PlateError::UsedUp {
                        face: plate.faces[0],
                        edge: plate.sides[side],
                        thickness: options.thickness,
                    })?);
            }
        }
        Ok(plates)
    }

    /// Returns the largest distance of a point of a plate from the hinge plane.
    pub(super) fn reach(&self) -> f64 {
        self.heights
            .iter()
            .fold(0.0, |most, height| f64::max(most, height.abs()))
    }

    /// Returns a number for the form of each face's plate: plates of one form differ by a translation of the sheet. `origins`
    /// has a point of each face that moves with it.
    pub(super) fn forms(&self, pattern: &CreasePattern, origins: &[Vector2<f64>]) -> Vec<u32> {
        let unit = FORM_EDGES * pattern.median_edge();
        let mut known: HashMap<Vec<[i64; 2]>, u32> = HashMap::new();
        let forms = origins.iter().zip(&self.of_face).map(|(origin, &plate)| {
            let outlines = self.list[plate].outlines.iter();
            let mut places: Vec<Vec<[i64; 2]>> = outlines
                .map(|outline| {
                    #[allow(
                        clippy::cast_possible_truncation,
                        reason = "lengths of a sheet, in a small unit"
                    )]
                    let place = |at: &Vector2<f64>| {
                        [at.x - origin.x, at.y - origin.y].map(|x| (x / unit).round() as i64)
                    };
                    let mut places: Vec<_> = outline.iter().map(place).collect();
                    // Equal plates may begin at different corners.
                    let least = (0..places.len()).min_by_key(|&k| places[k]).unwrap_or(0);
                    places.rotate_left(least);
                    places
                })
                .collect();
            let next = FaceId::new(known.len()).0;
            *known
                .entry(places.drain(..).flatten().collect())
                .or_insert(next)
        });
        forms.collect()
    }

    /// Returns `true` if every panel is a single face.
    pub(super) fn are_faces(&self) -> bool {
        self.list.len() == self.of_face.len()
    }

    /// Returns the tangents of half the largest angles of an edge, as a mountain and as a valley; zeros if it stays flat.
    pub(super) fn tangents(&self, pattern: &CreasePattern, edge: EdgeId) -> [f64; 2] {
        let crease = pattern.edge(edge).crease;
        crease.map_or([0.0; 2], |crease| self.tangents[crease.index()])
    }
}

/// Returns the panels of a sheet: faces joined across edges that stay flat or, if such a set has no single border, its faces
/// one by one.
fn panels(pattern: &CreasePattern) -> Vec<Plate> {
    let mut sets = UnionFind::new(pattern.faces().len());
    for edge in pattern.edges().iter().filter(|edge| edge.crease.is_none()) {
        if let Some(faces) = edge.inner_faces() {
            sets.join_to_smaller(faces.map(FaceId::index));
        }
    }
    let mut of_set: Vec<Vec<FaceId>> = vec![Vec::new(); pattern.faces().len()];
    for (face, first) in sets.representatives().into_iter().enumerate() {
        of_set[first].push(FaceId::new(face));
    }
    let of_set = of_set.into_iter().filter(|faces| !faces.is_empty());
    of_set
        .flat_map(|faces| match panel(pattern, &faces) {
            Some(plate) => vec![plate],
            None => faces
                .iter()
                .filter_map(|&face| panel(pattern, &[face]))
                .collect(),
        })
        .collect()
}

/// Returns the panel of some faces; `None` if its border is not a single polygon.
fn panel(pattern: &CreasePattern, faces: &[FaceId]) -> Option<Plate> {
    let mut rim: Vec<(VertexId, (VertexId, EdgeId))> = Vec::new();
    for &face in faces {
        let cycle = &pattern.faces()[face.index()];
        for (&from, &to) in cycle.iter().zip(cycle.iter().cycle().skip(1)) {
            let edge = *pattern.stars()[from.index()].iter().find(|&&edge| {
                let edge = pattern.edge(edge);
                edge.faces.contains(&Some(face)) && edge.ends.contains(&to)
            })?;
            let inner = pattern.edge(edge).inner_faces();
            if !inner.is_some_and(|both| both.iter().all(|face| faces.contains(face))) {
                rim.push((from, (to, edge)));
            }
        }
    }
    rim.sort_unstable_by_key(|(from, _)| *from);
    let (mut corners, mut sides) = (Vec::new(), Vec::new());
    let mut at = rim.first()?.0;
    while corners.first() != Some(&at) {
        let here = rim.partition_point(|(from, _)| *from < at);
        let (from, (to, edge)) = *rim.get(here)?;
        if from != at || corners.len() == rim.len() {
            return None;
        }
        corners.push(at);
        sides.push(edge);
        at = to;
    }
    if corners.len() != rim.len() {
        return None;
    }
    let parts = if is_convex(pattern, &corners) {
        vec![corners.clone()]
    } else {
        faces
            .iter()
            .flat_map(|&face| convex_parts(pattern, face))
            .collect()
    };
    Some(Plate {
        faces: faces.to_vec(),
        corners,
        sides,
        outlines: Vec::new(),
        parts,
    })
}
