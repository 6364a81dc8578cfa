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

mod mesh;
mod outline;
pub(super) mod solid;
mod thickest;
mod trims;

pub use mesh::{PlateMesh, SheetMesh};
pub(crate) use thickest::thickest;
pub use thickest::{Thickest, TooThick};
pub use trims::Trims;

use std::collections::HashMap;

use nalgebra::{Vector2, Vector3};
use thiserror::Error;

use self::outline::{Side, inset};
use super::convex::{convex_parts, is_convex};
use crate::motion::{MAX_PLATE_ANGLE_DEG, PlateOptions, PlateSides};
use crate::pattern::{CreasePattern, EdgeId, FaceId, VertexId};
use crate::util::nan_max::diagonal;

/// Length up to which plates of one form may differ, median edges.
const FORM_EDGES: f64 = 1e-7;

/// A sheet that cannot be made of plates.
#[derive(Clone, Copy, Debug, PartialEq, Error)]
#[non_exhaustive]
pub enum PlateError {
    /// A hinge turns farther than tapers reach.
    #[error(
        "the hinge at edge {edge} turns to {:.1} degrees: plates turn by at most {MAX_PLATE_ANGLE_DEG}",
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
        "panel {face} is used up at a thickness of {thickness:.6}: its sides stay back so far from the hinges that nothing is \
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
    /// Its outline at each of the heights of [`Plates::heights`]: for each corner the end of the side before and the start of
    /// the side behind it, which differ where the corner is cut off.
    pub outlines: Vec<Vec<[Vector2<f64>; 2]>>,
    /// Its convex parts, each a cycle of vertices.
    pub(super) parts: Vec<Vec<VertexId>>,
}

impl Plate {
    /// Returns the places of a vertex of the plate at each of its heights. Vertices inside the plate stay where they are.
    pub(super) fn places(
        &self,
        pattern: &CreasePattern,
        vertex: VertexId,
    ) -> Vec<[Vector2<f64>; 2]> {
        let corner = self.corners.iter().position(|corner| *corner == vertex);
        let inside = [pattern.vertices()[vertex.index()]; 2];
        let place =
            |outline: &Vec<[Vector2<f64>; 2]>| corner.map_or(inside, |corner| outline[corner]);
        self.outlines.iter().map(place).collect()
    }

    /// Returns the diagonal of a box round it.
    pub(super) fn width(&self) -> f64 {
        let corners: Vec<_> = self.outlines.iter().flatten().flatten().copied().collect();
        diagonal(&corners)
    }

    /// Returns the edges between two of its faces.
    pub(super) fn edges_inside(&self, pattern: &CreasePattern) -> Vec<EdgeId> {
        let inside = |face: &FaceId| {
            let neighbours = pattern.neighbours()[face.index()].iter();
            let inner =
                neighbours.filter(|(beyond, _)| self.faces.contains(beyond) && face < beyond);
            inner.map(|(_, edge)| *edge).collect::<Vec<_>>()
        };
        self.faces.iter().flat_map(inside).collect()
    }

    /// Returns one of its outlines after all sides have moved outwards by a distance; `None` if nothing is left of it.
    fn grown(&self, layer: usize, by: f64) -> Option<Vec<Vector2<f64>>> {
        let corners = self.outlines[layer].iter().flatten().copied().collect();
        let corners: Vec<Vector2<f64>> = without_repeats(corners);
        let next = corners.iter().cycle().skip(1);
        let sides = corners.iter().zip(next).map(|(from, to)| Side {
            from: *from,
            along: (to - from).normalize(),
            inset: -by,
        });
        let ends = inset(&sides.collect::<Vec<_>>(), |_| false).ok()?;
        Some(ends.into_iter().map(|[start, _]| start).collect())
    }

    /// Returns its outline at one height after its sides and corners have moved inwards by these distances.
    fn outline(
        &self,
        pattern: &CreasePattern,
        insets: impl Fn(EdgeId) -> f64,
        cuts: impl Fn(VertexId) -> f64,
    ) -> Result<Vec<[Vector2<f64>; 2]>, EdgeId> {
        let count = self.corners.len();
        let place = |k: usize| pattern.vertices()[self.corners[k % count].index()];
        let mut sides = Vec::with_capacity(count);
        // For each side its number among the edges; `None` for one that cuts a corner off.
        let mut edges = Vec::with_capacity(count);
        for k in 0..count {
            let (from, along) = (place(k), (place(k + 1) - place(k)).normalize());
            let cut = cuts(self.corners[k]);
            if cut > 0.0 {
                let before = (from - place(k + count - 1)).normalize();
                if let Some(across) = (before + along).try_normalize(0.0) {
                    sides.push(Side {
                        from,
                        along: across,
                        inset: cut,
                    });
                    edges.push(None);
                }
            }
            sides.push(Side {
                from,
                along,
                inset: insets(self.sides[k]),
            });
            edges.push(Some(k));
        }
        let turns =
            |side: usize| edges[side].is_some_and(|k| pattern.edge(self.sides[k]).crease.is_some());
        let ends = inset(&sides, |side| !turns(side)).map_err(|side| {
            let edge = (edges[side]).or_else(|| edges[(side + 1) % edges.len()]);
            self.sides[edge.unwrap_or(0)]
        })?;
        let mut outline = vec![[Vector2::zeros(); 2]; count];
        for ([start, end], edge) in ends.into_iter().zip(&edges) {
            if let Some(k) = *edge {
                outline[k][1] = start;
                outline[(k + 1) % count][0] = end;
            }
        }
        Ok(outline)
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
    /// Distances by which the motion asks the plates to stay back.
    trims: Trims,
}

impl Plates {
    /// Makes the plates for a motion that needs these trims. Cost: O(faces), but for panels of very many corners.
    ///
    /// # Errors
    /// If a hinge turns too far, or a panel is used up.
    pub fn new(
        pattern: &CreasePattern,
        trims: &Trims,
        options: &PlateOptions,
    ) -> Result<Self, PlateError> {
        Self::of_all(pattern, trims, options, options.thickness)
    }

    /// Makes solids that contain the plates of all thicknesses from `least` to that of the options. Tapered plates contain
    /// all thinner ones, and with a least thickness of 0, plates with upright sides are contained in tapered ones.
    ///
    /// # Errors
    /// As [`new`](Self::new).
    pub(crate) fn of_all(
        pattern: &CreasePattern,
        trims: &Trims,
        options: &PlateOptions,
        least: f64,
    ) -> Result<Self, PlateError> {
        trims.are_possible()?;
        let heights = |thickness| options.with(|it| it.thickness = thickness).heights();
        let (all, less) = (heights(options.thickness), heights(least));
        let [below, above] = all;
        // For each layer its height, and how far the material reaches each way that its sides stay back for.
        let mut layers = match options.sides {
            PlateSides::Taper => vec![
                (-below, [below, 0.0]),
                (0.0, [0.0; 2]),
                (above, [0.0, above]),
            ],
            PlateSides::Inset => vec![
                (-below, all),
                (-less[0], less),
                (less[1], less),
                (above, all),
            ],
        };
        layers.dedup();
        let gap = match options.sides {
            PlateSides::Taper => 0.0,
            PlateSides::Inset => options.gap,
        };
        let mut plates = Self {
            options: *options,
            heights: layers.iter().map(|(height, _)| *height).collect(),
            of_face: vec![0; pattern.faces().len()],
            list: panels(pattern),
            trims: trims.clone(),
        };
        for (index, plate) in plates.list.iter_mut().enumerate() {
            for face in &plate.faces {
                plates.of_face[face.index()] = index;
            }
            for (_, [down, up]) in &layers {
                let back = |[below, above]: [f64; 2]| (down * below).max(up * above);
                let side = |edge: EdgeId| {
                    let tangents = trims.tangents(edge, options.margin);
                    let is_hinge = tangents[0].max(tangents[1]) > 0.0;
                    if is_hinge {
                        back(tangents).max(gap)
                    } else {
                        0.0
                    }
                };
                let cut = |vertex: VertexId| back(trims.cut(plate.faces[0], vertex));
                let outline =
                    plate
                        .outline(pattern, side, cut)
                        .map_err(|edge| PlateError::UsedUp {
                            face: plate.faces[0],
                            edge,
                            thickness: options.thickness,
                        })?;
                plate.outlines.push(outline);
            }
        }
        Ok(plates)
    }

    /// Returns the outline of a plate at one of the heights after its sides have moved outwards by a distance; `None` if nothing
    /// is left of it.
    #[must_use]
    pub fn grown(&self, plate: usize, layer: usize, by: f64) -> Option<Vec<Vector2<f64>>> {
        self.list[plate].grown(layer, by)
    }

    /// Returns a radius of which a ball round a point, in the frame of the flat sheet, lies in a plate; 0 or less if none is
    /// known.
    pub(super) fn room(&self, plate: usize, at: &Vector3<f64>) -> f64 {
        let plate = &self.list[plate];
        let layers = self.heights.windows(2).zip(plate.outlines.windows(2));
        // Largest distance by which a corner, and with it the border of a section, moves from one height to another, over the
        // difference of heights.
        let slopes = layers.clone().flat_map(|(heights, outlines)| {
            let corners = outlines[0].iter().zip(&outlines[1]);
            let moved = corners.flat_map(|(a, b)| [b[0] - a[0], b[1] - a[1]]);
            moved.map(|moved| moved.norm() / (heights[1] - heights[0]))
        });
        let slope = slopes.fold(0.0, f64::max);
        let inside = layers.filter_map(|(heights, outlines)| {
            let part = (at.z - heights[0]) / (heights[1] - heights[0]);
            let section = || {
                let corners = outlines[0].iter().zip(&outlines[1]);
                let corners =
                    corners.flat_map(|(a, b)| [a[0].lerp(&b[0], part), a[1].lerp(&b[1], part)]);
                corners.collect::<Vec<_>>()
            };
            (0.0..=1.0)
                .contains(&part)
                .then(|| depth_within(&section(), &at.xy()))
        });
        let inside = inside.fold(f64::NEG_INFINITY, f64::max) / slope.hypot(1.0);
        let [low, high] = [self.heights[0], self.heights[self.heights.len() - 1]];
        inside.min(at.z - low).min(high - at.z)
    }

    /// Returns the number of the outline on the hinge plane or, if there is none, of the first above it.
    #[must_use]
    pub fn hinge_layer(&self) -> usize {
        let mut heights = self.heights.iter();
        heights.position(|height| *height >= 0.0).unwrap_or(0)
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
        let mut known: HashMap<Vec<[i64; 4]>, u32> = HashMap::new();
        let forms = origins.iter().zip(&self.of_face).map(|(origin, &plate)| {
            let outlines = self.list[plate].outlines.iter();
            let mut places: Vec<Vec<[i64; 4]>> = outlines
                .map(|outline| {
                    #[allow(
                        clippy::cast_possible_truncation,
                        reason = "lengths of a sheet, in a small unit"
                    )]
                    let place = |[a, b]: &[Vector2<f64>; 2]| {
                        [
                            a.x - origin.x,
                            a.y - origin.y,
                            b.x - origin.x,
                            b.y - origin.y,
                        ]
                        .map(|x| (x / unit).round() as i64)
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
    pub(super) fn tangents(&self, edge: EdgeId) -> [f64; 2] {
        self.trims.tangents(edge, 0.0)
    }
}

/// Returns the distance of a point from the border of a closed polygon; below 0 if it is not inside.
fn depth_within(corners: &[Vector2<f64>], at: &Vector2<f64>) -> f64 {
    let sides = corners.iter().zip(corners.iter().cycle().skip(1));
    let mut is_inside = false;
    let mut nearest = f64::INFINITY;
    for (from, to) in sides {
        let along = to - from;
        let way = (at - from).dot(&along) / along.norm_squared().max(f64::MIN_POSITIVE);
        nearest = nearest.min((from + along * way.clamp(0.0, 1.0) - at).norm());
        if (from.y > at.y) != (to.y > at.y) {
            let x = from.x + along.x * (at.y - from.y) / along.y;
            is_inside ^= x > at.x;
        }
    }
    if is_inside { nearest } else { -nearest }
}

/// Returns a closed ring without members that are equal to the one before.
fn without_repeats<T: PartialEq>(mut ring: Vec<T>) -> Vec<T> {
    ring.dedup();
    while ring.len() > 1 && ring.first() == ring.last() {
        ring.pop();
    }
    ring
}

/// Returns the panels of a sheet: faces joined across edges that stay flat or, if such a set has no single border, its faces
/// one by one.
fn panels(pattern: &CreasePattern) -> Vec<Plate> {
    let of_set = pattern.panels();
    let one_by_one = |faces: &Vec<FaceId>| {
        let faces = faces.iter();
        faces.filter_map(|&face| panel(pattern, &[face])).collect()
    };
    let plates = of_set
        .iter()
        .map(|faces| panel(pattern, faces).map_or_else(|| one_by_one(faces), |plate| vec![plate]));
    plates.flatten().collect()
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
