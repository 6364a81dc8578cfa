//! Do faces of a torn sheet pass through each other in a motion? Folds the sheet along a given spanning tree at 2048
//! places of each segment and measures all pairs of faces that are near and move against each other.
//!
//! The depth of a pair is the shortest translation that parts its two faces. It is found by separating axes: the normals
//! of the faces, the normals of their sides, and the products of their sides. Faces that touch have no depth, nor do
//! faces that lie flat on each other. The places between two samples are searched if a pair comes nearer there than all
//! before.

use core::cell::OnceCell;

use foldpath::folding::SpanningTree;
use nalgebra::Vector3;
use serde_json::Value;

use crate::sheet::sides;
use crate::{Motion, Pose, Sheet, worst};

/// Number of parts of a segment. The sheet is folded at their ends.
const PARTS: usize = 2048;
/// Number of parts between the places at which all faces are looked at.
const COARSE: usize = 64;
/// Number of parts of a segment for which near pairs are chosen together.
const CHUNK: usize = 2 * COARSE;
/// Largest step, in parts, for faces that share a vertex. They are always near each other.
const SHARING: usize = 8;
/// Factor of the largest speed between two places over the mean speed.
const UNEVEN: f64 = 1.5;
/// Factor of the deviation from a straight line between two places over the distance between them.
const CURVED: f64 = 0.25;
/// Distance over the median edge beyond which pairs are not measured.
const FAR: f64 = 0.15;
/// Depth up to which two faces touch: this over the median edge, but at most a part of the shorter edge of the two.
const TOUCH: f64 = 1e-6;
const TOUCH_OF_FACE: f64 = 1e-3;
/// Depth over the size of the sheet up to which a depth is rounding.
const ROUNDING: f64 = 1e-13;
/// Sine of the angle between two sides below which their product gives no axis.
const PARALLEL: f64 = 1e-7;
/// Change of an angle, radians, up to which a hinge is still.
const STILL: f64 = 1e-13;
/// Number of steps of the search between two places.
const GOLDEN: usize = 24;

/// A sheet, its motion and the tree along which it is folded.
pub(super) struct Oracle {
    pub(super) sheet: Sheet,
    pub(super) motion: Motion,
    /// Each face with its parent and the edge between them; parents come first.
    steps: Vec<[usize; 3]>,
    /// Two faces and the edge between them that no step crosses.
    loops: Vec<[usize; 3]>,
    meetings: Vec<Meeting>,
    unit: f64,
    size: f64,
}

/// The part that two faces have in common.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Meeting {
    Nothing,
    Vertex,
    Edge,
}

/// Two faces that pass through each other.
#[derive(Clone, Copy, Debug)]
pub struct Crossing {
    /// The faces.
    pub faces: [usize; 2],
    /// Shortest translation that parts them, over the median edge.
    pub depth: f64,
    /// Number of the knot before.
    pub segment: usize,
    /// Fraction of the segment.
    pub at: f64,
    /// `true` if the faces share a vertex.
    pub share: bool,
}

/// Findings of the oracle in a motion. Lengths are over the median edge.
#[derive(Clone, Copy, Debug, Default)]
pub struct Found {
    /// The deepest crossing.
    pub crossing: Option<Crossing>,
    /// Smallest distance of faces that share no vertex, at most 0.15. It is a lower bound if the nearest points are
    /// corners.
    pub clearance: f64,
    /// Largest distance between the ends of an edge that no step of the tree crosses, as its two faces place it.
    pub gap: f64,
    /// Largest twist of such an edge: how far its two faces are from its fold angle, radians.
    pub twist: f64,
}

impl Found {
    /// Returns the tear of the sheet: the larger one of gap and twist. A twist moves points a median edge away by as
    /// much.
    #[must_use]
    pub fn tear(&self) -> f64 {
        self.gap.max(self.twist)
    }
}

/// A face in the frame of the body that it is a part of.
struct Panel {
    corners: Vec<Vector3<f64>>,
    ways: Vec<Vector3<f64>>,
    normal: Vector3<f64>,
    shortest: f64,
}

/// The parts of a sheet that are rigid in a segment.
struct Bodies<'a> {
    oracle: &'a Oracle,
    segment: usize,
    /// Body of each face.
    of_face: Vec<usize>,
    /// Pose of each face in the frame of its body.
    in_body: Vec<Pose>,
    panels: Vec<Panel>,
    /// For each body but the first the step by which its first face is reached.
    hinges: Vec<[usize; 3]>,
    placed: Vec<OnceCell<Vec<Pose>>>,
}

/// The nearest pairs so far.
struct Search {
    found: Found,
    /// Smallest distance so far, in units of the sheet; the depth as a negative number if faces cross.
    least: f64,
}

impl Oracle {
    /// Reads a path file, with the spanning tree of its library form.
    ///
    /// # Errors
    /// If a key is missing or of another kind.
    pub(super) fn of(file: &Value, tree: &SpanningTree) -> serde_json::Result<Self> {
        let sheet = Sheet::of(file)?;
        let step = |step: &foldpath::folding::Step| {
            [step.face.index(), step.parent.index(), step.edge.index()]
        };
        let count = sheet.faces.len();
        let mut meetings = vec![Meeting::Nothing; count * count];
        let mut of_vertex = vec![Vec::new(); sheet.flat.len()];
        for (face, corners) in sheet.faces.iter().enumerate() {
            corners.iter().for_each(|&v| of_vertex[v].push(face));
        }
        for faces in &of_vertex {
            for (&a, &b) in faces.iter().flat_map(|a| faces.iter().map(move |b| (a, b))) {
                meetings[a * count + b] = Meeting::Vertex;
            }
        }
        for side in &sheet.sides {
            if let [Some(a), Some(b)] = *side {
                meetings[a * count + b] = Meeting::Edge;
                meetings[b * count + a] = Meeting::Edge;
            }
        }
        Ok(Self {
            motion: Motion::of(file)?,
            steps: tree.steps().iter().map(step).collect(),
            loops: tree.loops().iter().map(step).collect(),
            meetings,
            unit: sheet.median_edge(),
            size: worst(sheet.flat.iter().map(|p| (p - sheet.flat[0]).norm())),
            sheet,
        })
    }

    /// Returns the edges that no step of the tree crosses.
    pub(super) fn loops(&self) -> impl Iterator<Item = usize> {
        self.loops.iter().map(|&[_, _, edge]| edge)
    }

    /// Returns the pose of each face at a place of the motion; `s` is the fraction of the segment.
    pub(super) fn poses(&self, segment: usize, s: f64) -> Vec<Pose> {
        let mut poses = vec![Pose::identity(); self.sheet.faces.len()];
        for &[face, parent, edge] in &self.steps {
            let angle = self.motion.angle(segment, s, edge);
            poses[face] = self.sheet.across(&poses[parent], edge, face, angle);
        }
        poses
    }

    fn meeting(&self, [a, b]: [usize; 2]) -> Meeting {
        self.meetings[a * self.sheet.faces.len() + b]
    }

    /// Follows the motion and returns the deepest crossing, the clearance and the tear.
    pub(super) fn judge(&self) -> Found {
        let far = FAR * self.unit;
        let mut search = Search {
            found: Found {
                clearance: FAR,
                ..Found::default()
            },
            least: far,
        };
        for segment in 0..self.motion.segments() {
            let bodies = Bodies::of(self, segment);
            if segment == 0 {
                let boxes = bodies.boxes(&[0], far);
                for pair in near(&boxes) {
                    search.look(&bodies, pair, 0.0, bodies.at(0));
                }
            }
            bodies.tears(&mut search.found);
            let chunks = (0..PARTS / CHUNK).map(|chunk| chunk * CHUNK);
            for from in chunks {
                let boxes = bodies.boxes(&[from, from + COARSE, from + CHUNK], far);
                for pair in near(&boxes) {
                    if bodies.of_face[pair[0]] != bodies.of_face[pair[1]] {
                        search.follow(&bodies, pair, from);
                    }
                }
            }
        }
        search.found
    }
}

/// Returns the fraction of a segment at the end of a part.
#[allow(clippy::cast_precision_loss, reason = "a small count")]
fn place(part: usize) -> f64 {
    part as f64 / PARTS as f64
}

/// Returns the pairs of overlapping boxes.
fn near(boxes: &[[Vector3<f64>; 2]]) -> Vec<[usize; 2]> {
    let overlap = |a: &[Vector3<f64>; 2], b: &[Vector3<f64>; 2]| {
        (0..3).all(|k| a[0][k] <= b[1][k] && b[0][k] <= a[1][k])
    };
    let pairs = (0..boxes.len()).flat_map(|b| (0..b).map(move |a| [a, b]));
    pairs
        .filter(|&[a, b]| overlap(&boxes[a], &boxes[b]))
        .collect()
}

impl<'a> Bodies<'a> {
    fn of(oracle: &'a Oracle, segment: usize) -> Self {
        let (sheet, motion) = (&oracle.sheet, &oracle.motion);
        let moves = |edge: usize| {
            let angles = [0.0, 0.21, 0.5, 0.83, 1.0].map(|s| motion.angle(segment, s, edge));
            angles.iter().any(|angle| (angle - angles[0]).abs() > STILL)
        };
        let mut of_face = vec![0; sheet.faces.len()];
        let mut in_body = vec![Pose::identity(); sheet.faces.len()];
        let mut hinges = Vec::new();
        for &[face, parent, edge] in &oracle.steps {
            if moves(edge) {
                hinges.push([face, parent, edge]);
                of_face[face] = hinges.len();
            } else {
                let angle = motion.angle(segment, 0.0, edge);
                of_face[face] = of_face[parent];
                in_body[face] = sheet.across(&in_body[parent], edge, face, angle);
            }
        }
        let panel = |(face, pose): (&Vec<usize>, &Pose)| {
            let ways = sides(face).map(|[p, q]| sheet.flat[q] - sheet.flat[p]);
            let ways: Vec<_> = ways.collect();
            Panel {
                corners: face.iter().map(|&v| pose.apply(sheet.flat[v])).collect(),
                ways: ways.iter().map(|way| pose.turn(way.normalize())).collect(),
                normal: pose.normal(),
                shortest: ways.iter().map(Vector3::norm).fold(f64::INFINITY, f64::min),
            }
        };
        Self {
            oracle,
            segment,
            panels: sheet.faces.iter().zip(&in_body).map(panel).collect(),
            of_face,
            in_body,
            hinges,
            placed: vec![OnceCell::new(); PARTS + 1],
        }
    }

    /// Returns the pose of each body at a place of the segment.
    fn place(&self, s: f64) -> Vec<Pose> {
        let mut poses = vec![Pose::identity()];
        for &[face, parent, edge] in &self.hinges {
            let angle = self.oracle.motion.angle(self.segment, s, edge);
            let sheet = &self.oracle.sheet;
            let pose = sheet.across(&self.in_body[parent], edge, face, angle);
            poses.push(poses[self.of_face[parent]].after(&pose));
        }
        poses
    }

    /// Returns the pose of each body at the end of a part.
    fn at(&self, part: usize) -> &[Pose] {
        self.placed[part].get_or_init(|| self.place(place(part)))
    }

    /// Returns for each face a box round all its places from the first to the last of `parts`, and `far / 2` more on
    /// all sides.
    fn boxes(&self, parts: &[usize], far: f64) -> Vec<[Vector3<f64>; 2]> {
        let shapes: Vec<_> = around(parts).map(|part| self.at(part)).collect();
        let inside: Vec<_> = parts.iter().map(|&part| self.at(part)).collect();
        let of_face = |face: usize| {
            let (body, panel) = (self.of_face[face], &self.panels[face]);
            let mut moved = 0.0_f64;
            let mut reach = [
                Vector3::repeat(f64::INFINITY),
                Vector3::repeat(f64::NEG_INFINITY),
            ];
            for corner in &panel.corners {
                let places = shapes.windows(2);
                let steps =
                    places.map(|w| (w[0][body].apply(*corner) - w[1][body].apply(*corner)).norm());
                moved = moved.max(worst(steps));
                for shape in &inside {
                    let place = shape[body].apply(*corner);
                    reach = [reach[0].inf(&place), reach[1].sup(&place)];
                }
            }
            let more = Vector3::repeat(far / 2.0 + CURVED * moved);
            [reach[0] - more, reach[1] + more]
        };
        (0..self.panels.len()).map(of_face).collect()
    }

    /// Returns the separation of two faces: their distance, or a lower bound of it, or the depth as a negative number.
    fn separation(&self, [a, b]: [usize; 2], poses: &[Pose]) -> f64 {
        let between = poses[self.of_face[a]]
            .inverse()
            .after(&poses[self.of_face[b]]);
        let (panel, other) = (&self.panels[a], &self.panels[b]);
        let corners: Vec<_> = other.corners.iter().map(|p| between.apply(*p)).collect();
        let ways: Vec<_> = other.ways.iter().map(|way| between.turn(*way)).collect();
        let normal = between.turn(other.normal);
        let origin = panel.corners[0];
        let range = |corners: &[Vector3<f64>], axis: &Vector3<f64>| {
            let along = corners.iter().map(|p| axis.dot(&(p - origin)));
            along.fold([f64::INFINITY, f64::NEG_INFINITY], |[low, high], x| {
                [low.min(x), high.max(x)]
            })
        };
        let mut most = f64::NEG_INFINITY;
        let mut part = |axis: &Vector3<f64>| {
            let ([low, high], [least, last]) = (range(&panel.corners, axis), range(&corners, axis));
            most = most.max((least - high).max(low - last));
        };
        part(&panel.normal);
        part(&normal);
        panel
            .ways
            .iter()
            .for_each(|way| part(&panel.normal.cross(way)));
        ways.iter().for_each(|way| part(&normal.cross(way)));
        for way in &panel.ways {
            for other in &ways {
                let axis = way.cross(other);
                let size = axis.norm();
                if size > PARALLEL {
                    part(&(axis / size));
                }
            }
        }
        most
    }

    /// Returns how far two faces are off each other at the vertices that they share.
    fn parted(&self, [a, b]: [usize; 2], poses: &[Pose]) -> f64 {
        let sheet = &self.oracle.sheet;
        let pose = |face: usize| poses[self.of_face[face]].after(&self.in_body[face]);
        let (first, second) = (pose(a), pose(b));
        let shared = sheet.faces[a].iter().filter(|v| sheet.faces[b].contains(v));
        worst(shared.map(|&v| (first.apply(sheet.flat[v]) - second.apply(sheet.flat[v])).norm()))
    }

    /// Returns the largest distance that a corner of the second face moves in the frame of the first in one part, from
    /// `from` on for the length of a chunk.
    fn speed(&self, [a, b]: [usize; 2], from: usize) -> f64 {
        let seen = |part: usize| {
            let poses = self.at(part);
            poses[self.of_face[a]]
                .inverse()
                .after(&poses[self.of_face[b]])
        };
        let shapes: Vec<_> = around(&[from, from + CHUNK]).map(seen).collect();
        let steps = shapes.windows(2).flat_map(|w| {
            let corners = self.panels[b].corners.iter();
            corners.map(move |p| (w[0].apply(*p) - w[1].apply(*p)).norm())
        });
        #[allow(clippy::cast_precision_loss, reason = "a small count")]
        let parts = COARSE as f64;
        UNEVEN * worst(steps) / parts
    }

    /// Measures the tears at the edges that no step of the tree crosses.
    fn tears(&self, found: &mut Found) {
        let sheet = &self.oracle.sheet;
        for part in (0..=PARTS).step_by(COARSE) {
            let poses = self.at(part);
            let pose = |face: usize| poses[self.of_face[face]].after(&self.in_body[face]);
            for &[face, parent, edge] in &self.oracle.loops {
                let angle = self.oracle.motion.angle(self.segment, place(part), edge);
                let (is, should) = (pose(face), sheet.across(&pose(parent), edge, face, angle));
                let apart = sheet.edges[edge]
                    .map(|v| (is.apply(sheet.flat[v]) - should.apply(sheet.flat[v])).norm());
                found.gap = found.gap.max(worst(apart) / self.oracle.unit);
                found.twist = found.twist.max(is.twist(&should));
            }
        }
    }
}

/// Returns the coarse places from one before the first of `parts` to one after the last.
fn around(parts: &[usize]) -> impl Iterator<Item = usize> + use<> {
    let first = parts.first().copied().unwrap_or(0).saturating_sub(COARSE);
    let last = parts.last().copied().unwrap_or(0) + COARSE;
    (first..=last.min(PARTS)).step_by(COARSE)
}

impl Search {
    /// Measures a pair and keeps it if it is nearer than all before. Returns its separation.
    fn look(&mut self, bodies: &Bodies<'_>, pair: [usize; 2], s: f64, poses: &[Pose]) -> f64 {
        let oracle = bodies.oracle;
        let meeting = oracle.meeting(pair);
        if meeting == Meeting::Edge {
            return f64::INFINITY;
        }
        let separation = bodies.separation(pair, poses);
        if separation >= self.least {
            return separation;
        }
        let shortest = pair.map(|face| bodies.panels[face].shortest);
        let of_face = TOUCH_OF_FACE * shortest[0].min(shortest[1]);
        let touch = (TOUCH * oracle.unit).min(of_face);
        let touch = touch.max(ROUNDING * oracle.size);
        let share = meeting == Meeting::Vertex;
        if separation < -touch {
            let torn = if share {
                2.0 * bodies.parted(pair, poses)
            } else {
                0.0
            };
            if separation < -touch - torn {
                self.least = separation;
                self.found.crossing = Some(Crossing {
                    faces: pair,
                    depth: -separation / oracle.unit,
                    segment: bodies.segment,
                    at: s,
                    share,
                });
            }
        }
        if !share {
            self.least = self.least.min(separation.max(0.0));
            self.found.clearance = self.found.clearance.min(self.least.max(0.0) / oracle.unit);
        }
        separation
    }

    /// Follows a pair for the length of a chunk. Its steps are so long that it cannot become nearer than the nearest
    /// pair before their ends, but no shorter than a part.
    fn follow(&mut self, bodies: &Bodies<'_>, pair: [usize; 2], from: usize) {
        let oracle = bodies.oracle;
        let meeting = oracle.meeting(pair);
        if meeting == Meeting::Edge {
            return;
        }
        let speed = bodies.speed(pair, from).max(f64::MIN_POSITIVE);
        let shortest_step = if meeting == Meeting::Vertex {
            SHARING
        } else {
            1
        };
        let mut nearest = (f64::INFINITY, from);
        let mut part = from;
        loop {
            let separation = self.look(bodies, pair, place(part), bodies.at(part));
            if separation < nearest.0 {
                nearest = (separation, part);
            }
            if part == from + CHUNK {
                break;
            }
            let least = if meeting == Meeting::Vertex {
                self.least.min(0.0)
            } else {
                self.least
            };
            let free = 1.001 * separation - least;
            #[allow(
                clippy::cast_possible_truncation,
                clippy::cast_sign_loss,
                reason = "from 0 to a chunk"
            )]
            let step = (free / speed).clamp(0.0, CHUNK as f64) as usize;
            part = (part + step.max(shortest_step)).min(from + CHUNK);
        }
        #[allow(clippy::cast_precision_loss, reason = "a small count")]
        let reach = speed * shortest_step as f64;
        if nearest.0 - reach < self.least && meeting == Meeting::Nothing {
            self.refine(bodies, pair, nearest.1);
        }
    }

    /// Searches for the nearest place of a pair between the ends of the parts next to one (golden section).
    fn refine(&mut self, bodies: &Bodies<'_>, pair: [usize; 2], part: usize) {
        let golden = (5.0_f64.sqrt() - 1.0) / 2.0;
        let (mut low, mut high) = (place(part.saturating_sub(1)), place((part + 1).min(PARTS)));
        let mut look = |s: f64| self.look(bodies, pair, s, &bodies.place(s));
        let inner =
            |low: f64, high: f64| [high - golden * (high - low), low + golden * (high - low)];
        let mut places = inner(low, high);
        let mut values = places.map(&mut look);
        for _ in 0..GOLDEN {
            if values[0] < values[1] {
                high = places[1];
                places = inner(low, high);
                values = [look(places[0]), values[0]];
            } else {
                low = places[0];
                places = inner(low, high);
                values = [values[1], look(places[1])];
            }
        }
    }
}
