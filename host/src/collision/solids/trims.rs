//! Distances by which a motion asks plates to stay back: at hinges, at borders that close, and at corners.

use std::collections::HashMap;

use foldpath_core::Membership;
use nalgebra::{Vector2, Vector3};

use super::PlateError;
use super::solid::cone_separation_up_to;
use crate::folding::{FoldingMap, Pose};
use crate::motion::{MAX_PLATE_ANGLE_DEG, Motion, PlateOptions};
use crate::pattern::{CreasePattern, EdgeId, FaceId, VertexId};

/// Distance up to which the ends of two borders lie on each other at the end of a motion, median edges.
const SEAM_EDGES: f64 = 1e-3;
/// Number of configurations at which corners are looked at, if the sheet is small and at least.
const SAMPLES: [usize; 2] = [129, 17];
/// Number of vertices of a small sheet.
const SMALL_SHEET: usize = 2000;
/// Depth of two cones in each other up to which they touch, a sine.
const TOUCHING_SINE: f64 = 1e-9;
/// Largest cut of a corner over the height at which it is made, and the number of halvings in the search for the least.
const MAX_CUT: f64 = 32.0;
const CUT_HALVINGS: u32 = 24;
/// Part by which a cut is larger than the samples ask for, as the motion goes on between them, and the unit to which it is
/// rounded up, over the height.
const CUT_MARGIN: f64 = 0.02;
const CUT_UNIT: f64 = 1.0 / 1024.0;
/// Sine of the angle between two sides up to which they are in line: such a corner is not cut.
const STRAIGHT_SINE: f64 = 1e-6;
/// Unit to which the parts of a direction are rounded to compare it with others.
const SAME_DIRECTION: f64 = 1e-9;

/// Distances by which a motion asks plates to stay back.
#[derive(Clone, Debug, Default)]
pub struct Trims {
    /// For each edge the least and the largest angle to which it closes: of a hinge over the motion, of a border that closes on
    /// another one at the end. Radians.
    ranges: Vec<[f64; 2]>,
    /// Panel, named by its first face, and corner, with the distances that the corner is cut off below and above the hinge
    /// plane, over the height.
    cuts: HashMap<(FaceId, VertexId), [f64; 2]>,
}

impl Trims {
    /// Finds what a motion asks of plates with these options.
    #[must_use]
    pub fn of(motion: &Motion, options: &PlateOptions) -> Self {
        let pattern = &motion.pattern;
        let end = motion.knots.len().checked_sub(1);
        let end = end.map(|last| motion.crease_angles(last));
        let ranges = motion.angle_ranges();
        let mut trims = Self::between(pattern, &ranges, end.as_deref());
        if options.cuts_corners {
            let [most, least] = SAMPLES;
            let count = most * SMALL_SHEET / pattern.vertices().len().max(1);
            let samples = motion.resampled(count.clamp(least, most));
            let samples = (0..samples.knots.len()).map(|knot| samples.crease_angles(knot));
            trims.cut_corners(pattern, &motion.memberships(), samples, options);
        }
        trims
    }

    /// Finds what motions ask of plates that end at these fold angles of the creases (radians), on which every crease has angles
    /// between 0 and that at the end. Corners are cut off where they would be in each other at the end.
    #[must_use]
    pub(crate) fn until(pattern: &CreasePattern, end: Vec<f64>, options: &PlateOptions) -> Self {
        let ranges = end.iter().map(|angle| [angle.min(0.0), angle.max(0.0)]);
        let mut trims = Self::between(pattern, &ranges.collect::<Vec<_>>(), Some(&end));
        trims.cut_corners(pattern, &[], [end].into_iter(), options);
        trims
    }

    fn between(pattern: &CreasePattern, ranges: &[[f64; 2]], end: Option<&[f64]>) -> Self {
        let mut trims = Self {
            ranges: vec![[0.0; 2]; pattern.edges().len()],
            cuts: HashMap::new(),
        };
        for (edge, range) in pattern.creases().iter().zip(ranges) {
            trims.ranges[edge.index()] = *range;
        }
        if let Some(end) = end {
            trims.add_seams(pattern, end);
        }
        trims
    }

    /// Returns the number of corners that are cut off.
    #[must_use]
    pub fn corners_cut(&self) -> usize {
        self.cuts.len()
    }

    /// Checks that no hinge turns farther than plates can.
    pub(super) fn are_possible(&self) -> Result<(), PlateError> {
        let limit = MAX_PLATE_ANGLE_DEG.to_radians();
        for (edge, range) in (0..).map(EdgeId).zip(&self.ranges) {
            let is_good = |angle: &&f64| angle.abs() <= limit;
            if let Some(&angle) = range.iter().find(|angle| !is_good(angle)) {
                return Err(PlateError::TurnsTooFar { edge, angle });
            }
        }
        Ok(())
    }

    /// Returns the tangents of half the largest angles of an edge and a margin (radians), as a mountain and as a valley; zeros
    /// where it does not turn.
    pub(super) fn tangents(&self, edge: EdgeId, margin: f64) -> [f64; 2] {
        let [low, high] = self.ranges[edge.index()];
        [-low, high].map(|most| {
            if most > 0.0 {
                ((most + margin) / 2.0).tan()
            } else {
                0.0
            }
        })
    }

    /// Returns how far a corner of a panel, named by its first face, is cut off below and above the hinge plane, over the
    /// height.
    pub(super) fn cut(&self, panel: FaceId, corner: VertexId) -> [f64; 2] {
        self.cuts.get(&(panel, corner)).copied().unwrap_or_default()
    }

    /// Finds the borders that lie on each other at the end of the motion, but not in the flat sheet.
    fn add_seams(&mut self, pattern: &CreasePattern, end: &[f64]) {
        let map = FoldingMap::new(pattern, pattern.tree(), end);
        let near = SEAM_EDGES * pattern.median_edge();
        let mut borders: Vec<(f64, Border)> = (0..)
            .map(EdgeId)
            .take(pattern.edges().len())
            .filter_map(|edge| Border::of(pattern, &map, edge))
            .map(|border| (border.ends[0].x + border.ends[1].x, border))
            .collect();
        borders.sort_by(|a, b| a.0.total_cmp(&b.0));
        for (k, (x, a)) in borders.iter().enumerate() {
            let others = borders[k + 1..].iter();
            for (_, b) in others.take_while(|(other, _)| other - x <= 2.0 * near) {
                if a.lies_on(b, pattern, near) {
                    for (border, other) in [(a, b), (b, a)] {
                        let angle = border.angle_to(other);
                        if angle.abs() <= MAX_PLATE_ANGLE_DEG.to_radians() {
                            let range = &mut self.ranges[border.edge.index()];
                            *range = [range[0].min(angle), range[1].max(angle)];
                        }
                    }
                }
            }
        }
    }

    /// Cuts off corners of panels that share a vertex and no hinge at it, where they would pass through each other at one of
    /// these configurations, given as fold angles of the creases (radians). `memberships` has group and sign of each crease, by
    /// which they turn alike; creases without one turn as they like.
    fn cut_corners(
        &mut self,
        pattern: &CreasePattern,
        memberships: &[Membership],
        configurations: impl Iterator<Item = Vec<f64>>,
        options: &PlateOptions,
    ) {
        let has_sides = [options.hinge_plane > 0.0, options.hinge_plane < 1.0];
        let mut apart = self.corners_apart(pattern, memberships, options.margin);
        let mut map = FoldingMap::flat(pattern);
        for angles in configurations {
            map.fold(pattern, pattern.tree(), &angles);
            for pair in &mut apart {
                let poses = pair.corners.map(|corner| &map.poses()[corner.face.index()]);
                self.cut_apart(pair, poses, has_sides);
            }
        }
    }

    /// Returns the pairs of corners of panels that share a vertex, but no hinge at it. One pair stands for those at other
    /// vertices that are placed and move alike.
    fn corners_apart(
        &self,
        pattern: &CreasePattern,
        memberships: &[Membership],
        margin: f64,
    ) -> Vec<CornersApart> {
        let first_faces = first_faces(pattern);
        let panel = |corner: &Corner| first_faces[corner.face.index()];
        let member = |edge: EdgeId| {
            let crease = pattern.edge(edge).crease;
            crease.map(|crease| (memberships.get(crease.index()).copied()).ok_or(crease))
        };
        let mut classes: Vec<Vec<Vec<Corner>>> = Vec::new();
        let mut class_of = HashMap::new();
        for vertex in (0..).map(VertexId).take(pattern.vertices().len()) {
            let corner = |&face: &FaceId| {
                Corner::of(pattern, face, vertex, |edge| self.tangents(edge, margin))
            };
            let faces = pattern.corners()[vertex.index()].iter();
            let mut corners: Vec<Corner> = faces.filter_map(corner).collect();
            corners.sort_by_key(Corner::place);
            let key = |corner: &Corner| (corner.place(), corner.edges.map(member));
            let key: Vec<_> = corners.iter().map(key).collect();
            let class = *class_of.entry(key).or_insert_with(|| {
                classes.push(Vec::new());
                classes.len() - 1
            });
            classes[class].push(corners);
        }
        let mut apart = Vec::new();
        for class in &classes {
            let first = &class[0];
            for [a, b] in (0..first.len()).flat_map(|a| (0..a).map(move |b| [a, b])) {
                let are_joined = (first[a].edges.iter()).any(|edge| first[b].edges.contains(edge));
                let of_other_panels = class
                    .iter()
                    .map(|corners| [corners[a], corners[b]])
                    .filter(|[a, b]| !are_joined && panel(a) != panel(b));
                let keys: Vec<_> = of_other_panels
                    .map(|pair| pair.map(|corner| (panel(&corner), corner.vertex)))
                    .collect();
                if !keys.is_empty() {
                    apart.push(CornersApart {
                        corners: [first[a], first[b]],
                        keys,
                        parting: Vector3::zeros(),
                    });
                }
            }
        }
        apart
    }

    /// Cuts two corners off by as much as it takes for them to be apart where they are.
    fn cut_apart(&mut self, pair: &mut CornersApart, poses: [&Pose; 2], has_sides: [bool; 2]) {
        let CornersApart {
            corners,
            keys,
            parting,
        } = pair;
        // The sides of each plate to which the other one has risen.
        let sides = [0, 1].map(|k| corners[k].side_of(&corners[1 - k], [poses[k], poses[1 - k]]));
        let known = keys[0].map(|(panel, vertex)| self.cut(panel, vertex));
        let with = |cut: f64| {
            [0, 1].map(|k| {
                let mut cuts = known[k];
                cuts[sides[k]] = cuts[sides[k]].max(cut);
                cuts
            })
        };
        let mut overlap = |cut: f64| {
            let cuts = with(cut);
            let [a, b] = [0, 1].map(|k| corners[k].cone(cuts[k], has_sides, poses[k]));
            cone_separation_up_to(&a, &b, parting, -TOUCHING_SINE) < -TOUCHING_SINE
        };
        if !overlap(0.0) || overlap(MAX_CUT) {
            return;
        }
        let [mut low, mut high] = [0.0, MAX_CUT];
        for _ in 0..CUT_HALVINGS {
            let middle = f64::midpoint(low, high);
            if overlap(middle) {
                low = middle;
            } else {
                high = middle;
            }
        }
        // Equal corners of a sheet get equal cuts, whatever rounding does.
        let cut = (high * (1.0 + CUT_MARGIN) / CUT_UNIT).ceil() * CUT_UNIT;
        let cuts = with(cut);
        for k in (0..2).filter(|k| corners[*k].may_be_cut) {
            self.cuts.extend(keys.iter().map(|keys| (keys[k], cuts[k])));
        }
    }
}

/// Corners of two panels at a vertex that they share.
struct CornersApart {
    corners: [Corner; 2],
    /// Panels and vertex of these corners and of all that they stand for.
    keys: Vec<[(FaceId, VertexId); 2]>,
    /// Normal of the last plane between them, if one was found.
    parting: Vector3<f64>,
}

/// Returns for each face the first face of its panel.
fn first_faces(pattern: &CreasePattern) -> Vec<FaceId> {
    let mut first = vec![FaceId::default(); pattern.faces().len()];
    for panel in pattern.panels() {
        for face in &panel {
            first[face.index()] = panel[0];
        }
    }
    first
}

/// A border edge of a folded sheet.
struct Border {
    edge: EdgeId,
    /// Its ends in space, with its face to the left in the flat sheet.
    ends: [Vector3<f64>; 2],
    vertices: [VertexId; 2],
    /// Direction away from its face, within the plane of the face, and normal of the face.
    outward: Vector3<f64>,
    normal: Vector3<f64>,
}

impl Border {
    fn of(pattern: &CreasePattern, map: &FoldingMap, edge: EdgeId) -> Option<Self> {
        let data = pattern.edge(edge);
        let (face, vertices) = match data.faces {
            [Some(face), None] => (face, data.ends),
            [None, Some(face)] => (face, [data.ends[1], data.ends[0]]),
            _ => return None,
        };
        let pose = &map.poses()[face.index()];
        let along = pattern.direction(edge, vertices[0]);
        Some(Self {
            edge,
            vertices,
            ends: vertices.map(|end| pose.apply(pattern.vertices()[end.index()])),
            outward: pose.turn(Vector2::new(along.y, -along.x)),
            normal: pose.normal(),
        })
    }

    /// Returns `true` if two borders lie on each other, within a distance, and did not in the flat sheet.
    fn lies_on(&self, other: &Self, pattern: &CreasePattern, near: f64) -> bool {
        let is_near = |turned: bool| {
            let end = |k: usize| other.ends[if turned { 1 - k } else { k }];
            (0..2).all(|k| (self.ends[k] - end(k)).norm() <= near)
        };
        let place = |vertex: VertexId| pattern.vertices()[vertex.index()];
        let middle = |border: &Self| {
            let [a, b] = border.vertices.map(place);
            (a + b) / 2.0
        };
        let was_there = (middle(self) - middle(other)).norm() <= near;
        !was_there && (is_near(true) || is_near(false))
    }

    /// Returns the fold angle of the hinge that this border and another one would be, valley positive.
    fn angle_to(&self, other: &Self) -> f64 {
        let beyond = -other.outward;
        beyond.dot(&self.normal).atan2(beyond.dot(&self.outward))
    }
}

/// A corner of a face at a vertex.
#[derive(Clone, Copy)]
struct Corner {
    face: FaceId,
    vertex: VertexId,
    /// The edges before and behind the corner.
    edges: [EdgeId; 2],
    /// Unit directions from the vertex along these edges, and inwards from the lines of the edges.
    along: [Vector2<f64>; 2],
    inward: [Vector2<f64>; 2],
    /// For each edge how far the plate stays back from it below and above the hinge plane, over the height.
    back: [[f64; 2]; 2],
    /// `true` if the corner is convex and not straight.
    may_be_cut: bool,
}

impl Corner {
    fn of(
        pattern: &CreasePattern,
        face: FaceId,
        vertex: VertexId,
        tangents: impl Fn(EdgeId) -> [f64; 2],
    ) -> Option<Self> {
        let edges = pattern.stars()[vertex.index()].iter().copied();
        let of_face = edges.filter(|&edge| pattern.edge(edge).faces.contains(&Some(face)));
        let mut of_face: Vec<EdgeId> = of_face.collect();
        // The edge behind the corner has the face to its left.
        let leaves = |edge: &EdgeId| {
            let edge = pattern.edge(*edge);
            edge.faces[usize::from(edge.ends[0] != vertex)] == Some(face)
        };
        of_face.sort_by_key(leaves);
        let edges: [EdgeId; 2] = of_face.try_into().ok()?;
        let along = edges.map(|edge| pattern.direction(edge, vertex));
        let [before, behind] = along;
        let sine = behind.perp(&before);
        Some(Self {
            face,
            vertex,
            edges,
            along,
            inward: [
                Vector2::new(before.y, -before.x),
                Vector2::new(-behind.y, behind.x),
            ],
            back: edges.map(tangents),
            may_be_cut: sine > STRAIGHT_SINE,
        })
    }

    /// Returns numbers that are equal for corners which differ by a translation of the sheet.
    #[allow(clippy::cast_possible_truncation, reason = "rounded to a part of 1")]
    fn place(&self) -> ([i64; 4], [u64; 4]) {
        let [a, b] = self.along;
        let [c, d] = self.back;
        (
            [a.x, a.y, b.x, b.y].map(|part| (part / SAME_DIRECTION).round() as i64),
            [c[0], c[1], d[0], d[1]].map(f64::to_bits),
        )
    }

    /// Returns the side of this corner's plate to which another one has risen: 0 below, 1 above.
    fn side_of(&self, other: &Self, [pose, other_pose]: [&Pose; 2]) -> usize {
        let middle = other_pose.turn(other.along[0] + other.along[1]);
        usize::from(middle.dot(&pose.normal()) > 0.0)
    }

    /// Returns directions that span the plate as seen from the vertex, if the corner is cut off by so much below and above.
    fn cone(&self, cuts: [f64; 2], exists: [bool; 2], pose: &Pose) -> Vec<Vector3<f64>> {
        // Two directions in the hinge plane, and at most two on each side of it.
        let mut cone = Vec::with_capacity(6);
        cone.extend(self.along.map(|along| pose.turn(along)));
        let up = pose.normal();
        for (side, height) in [(0, -1.0), (1, 1.0)] {
            if exists[side] {
                let places = self.places(side, cuts[side]).into_iter().flatten();
                cone.extend(places.map(|at| (pose.turn(at) + up * height).normalize()));
            }
        }
        cone
    }

    /// Returns where the sides of the plate meet at height 1, seen from the vertex: one place, or two if the corner is cut off.
    fn places(&self, side: usize, cut: f64) -> [Option<Vector2<f64>>; 2] {
        let lines = [0, 1].map(|k| (self.inward[k], self.back[k][side]));
        let meet = |[(a, p), (b, q)]: [(Vector2<f64>, f64); 2]| {
            let sine = a.perp(&b);
            (sine.abs() > STRAIGHT_SINE)
                .then(|| Vector2::new(p * b.y - q * a.y, q * a.x - p * b.x) / sine)
        };
        let Some(corner) = meet(lines) else {
            return [Some(lines[0].0 * lines[0].1.max(lines[1].1)), None];
        };
        let inward = self.along[0] + self.along[1];
        match inward.try_normalize(0.0).filter(|_| self.may_be_cut) {
            Some(inward) if inward.dot(&corner) < cut => {
                lines.map(|line| meet([line, (inward, cut)]))
            }
            _ => [Some(corner), None],
        }
    }
}
