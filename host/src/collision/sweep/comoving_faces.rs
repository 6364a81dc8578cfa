//! Finds comoving faces, which stay at rest relative to each other over a part of a motion, by union-find: faces joined
//! by an edge that does not turn, and faces hinged to one body about the same line that turn about it alike. Layers
//! that are folded over as one move like this.

use core::f64::consts::PI;

use foldpath_core::Membership;

use super::motion::{Motion, SEGMENT, Tick};
use crate::collision::placed_pieces::Axis;
use crate::collision::tolerances::{MAX_HINGES, MAX_PARTINGS, NEARLY_AT_REST_RATIO};
use crate::pattern::{CreaseId, CreasePattern, EdgeId, FaceId};
use crate::util::union_find::UnionFind;

/// A crease that turns, seen from one of its faces.
struct Hinge {
    face: usize,
    against: usize,
    /// The fold angle over the time looked at, as Bernstein coefficients (`course`), and a bound on its variation, at most
    /// half a turn (`turned`), radians.
    course: [f64; 4],
    turned: f64,
    /// Axis about which a positive fold angle turns the face against the other.
    line: Axis,
    /// Bound on the distance by which a tear at the crease may move the face, units of the sheet.
    torn: f64,
}

/// Faces that are at rest relative to each other from one time to another.
#[derive(Debug)]
pub(super) struct ComovingFaces {
    /// For each face the representative of its body: faces that move relative to each other by no more than a
    /// tolerance.
    pub(super) bodies: Vec<usize>,
    /// `true` if other faces move relative to each other by little more.
    pub(super) nearly: bool,
}

/// Faces that are at rest relative to each other at the current time of a sweep: what is known depends on this time, not
/// on the times before.
#[derive(Debug, Default)]
pub(super) struct ComovingNow {
    /// The current segment.
    segment: usize,
    /// Parts of the segment with the current time in them: the whole, its half, and so on while other faces nearly stay at
    /// rest. Each with its end, and the faces that stay at rest over it; empty if all groups turn.
    parts: Vec<(Tick, ComovingFaces)>,
}

impl ComovingNow {
    /// Begins a motion: nothing is known yet.
    pub(super) fn begin(&mut self) {
        self.segment = usize::MAX;
    }

    /// Returns the segment of a time if it is another than that of the time before.
    pub(super) fn entered(&self, motion: &Motion, time: Tick) -> Option<usize> {
        let segment = motion.place(time).segment;
        (segment != self.segment).then_some(segment)
    }

    /// Goes to a time. `find` finds the comoving faces from one time to another; `None` if all groups turn.
    pub(super) fn enter(
        &mut self,
        motion: &Motion,
        time: Tick,
        find: Option<impl FnMut([Tick; 2]) -> ComovingFaces>,
    ) {
        if let Some(segment) = self.entered(motion, time) {
            self.segment = segment;
            self.parts.clear();
        }
        while self.parts.last().is_some_and(|&(end, _)| end <= time) {
            self.parts.pop();
        }
        let Some(mut find) = find.filter(|_| time < motion.end()) else {
            return;
        };
        while self.parts.len() <= MAX_PARTINGS
            && self.parts.last().is_none_or(|(_, faces)| faces.nearly)
        {
            let length = SEGMENT >> self.parts.len();
            let from = time / length * length;
            let found = find([from, from + length]);
            self.parts.push((from + length, found));
        }
    }

    /// Returns the time until which two faces keep their positions relative to each other, if they do for a while.
    pub(super) fn until(&self, faces: [FaceId; 2]) -> Option<Tick> {
        let alike = |(_, found): &&(Tick, ComovingFaces)| {
            let [a, b] = faces.map(|face| found.bodies[face.index()]);
            a == b
        };
        self.parts.iter().find(alike).map(|(end, _)| *end)
    }
}

/// Finds the faces that are at rest relative to each other from one time to another of the same segment.
///
/// Groups that are `still` hardly turn in this time, and `axis` returns the line of a crease in the folded
/// sheet at the first time. No two points of the folded sheet are ever farther from each other than `length`.
pub(super) fn comoving_faces(
    pattern: &CreasePattern,
    memberships: &[Membership],
    (motion, times): (&Motion, [Tick; 2]),
    still: &[bool],
    tear: impl Fn(EdgeId) -> [f64; 2],
    mut axis: impl FnMut(CreaseId) -> Axis,
    [length, tolerance]: [f64; 2],
) -> ComovingFaces {
    let count = pattern.faces().len();
    let mut bodies = Bodies {
        sets: UnionFind::new(count),
        moved: vec![0.0; count],
        tolerance,
        nearly: false,
    };
    bodies.join_roots(pattern);
    let mut hinges = Vec::new();
    let mut torn_edges = Vec::new();
    for (index, edge) in pattern.edges().iter().enumerate() {
        let Some(faces) = edge.inner_faces() else {
            continue;
        };
        let [left, right] = faces.map(FaceId::index);
        // A tear may be another at the end than at the beginning.
        let [turn, shift] = tear(EdgeId::new(index));
        let torn = if shift > 0.0 {
            2.0 * (turn * length + shift)
        } else {
            0.0
        };
        let member = |crease: CreaseId| Some((crease, *memberships.get(crease.index())?));
        let member = edge.crease.and_then(member);
        match member {
            Some((crease, member)) if !still[member.group.index()] => {
                let Axis { point, direction } = axis(crease);
                let course = motion.course(times, member);
                let turned = motion.turned(times, member).min(PI);
                for (face, against, direction) in
                    [(left, right, direction), (right, left, -direction)]
                {
                    let line = Axis { point, direction };
                    hinges.push(Hinge {
                        face,
                        against,
                        course,
                        turned,
                        line,
                        torn,
                    });
                }
            }
            _ => {
                let turned = member.map_or(0.0, |(_, member)| motion.turned(times, member));
                if torn > 0.0 {
                    // Two faces may turn a little against each other though the crease between them is still.
                    torn_edges.push(([left, right], length * turned + torn));
                    continue;
                }
                bodies.join([left, right], length * turned);
            }
        }
    }
    for (faces, off) in torn_edges {
        bodies.join(faces, off);
    }
    while bodies.join_hinged(&mut hinges, length) {}
    ComovingFaces {
        bodies: bodies.sets.representatives(),
        nearly: bodies.nearly,
    }
}

/// Sets of faces that stay at rest relative to each other.
struct Bodies {
    sets: UnionFind,
    /// For the representative of each body a bound on how far its faces move relative to each other.
    moved: Vec<f64>,
    tolerance: f64,
    /// `true` if some bodies were not joined that move relative to each other by little more than the tolerance.
    nearly: bool,
}

impl Bodies {
    /// Joins the faces at which the sheets are held.
    fn join_roots(&mut self, pattern: &CreasePattern) {
        for roots in pattern.tree().roots().windows(2) {
            self.join([roots[0].index(), roots[1].index()], 0.0);
        }
    }

    /// Joins the bodies of two faces that move relative to each other by `more`, unless the faces of the joined body then
    /// move by more than the tolerance. Returns `true` if bodies were joined.
    fn join(&mut self, faces: [usize; 2], more: f64) -> bool {
        let bodies = faces.map(|face| self.sets.find(face));
        if bodies[0] == bodies[1] {
            return false;
        }
        let moved = self.moved[bodies[0]] + self.moved[bodies[1]] + more;
        let joins = moved <= self.tolerance;
        if joins {
            self.sets.join(bodies);
            let joined = self.sets.find(bodies[0]);
            self.moved[joined] = moved;
        } else {
            self.nearly |= more <= NEARLY_AT_REST_RATIO * self.tolerance;
        }
        joins
    }

    /// Joins bodies that are hinged to one body about the same line and turn about it alike. Returns `true` if any were
    /// joined: others may then be hinged to one body, too.
    fn join_hinged(&mut self, hinges: &mut [Hinge], length: f64) -> bool {
        for hinge in &mut *hinges {
            hinge.against = self.sets.find(hinge.against);
        }
        hinges.sort_by_key(|hinge| hinge.against);
        let by_body = hinges.chunk_by(|a, b| a.against == b.against);
        let mut found = false;
        for hinges in by_body.filter(|hinges| hinges.len() <= MAX_HINGES) {
            for (k, hinge) in hinges.iter().enumerate() {
                for other in &hinges[..k] {
                    let faces = [hinge.face, other.face];
                    if self.sets.are_joined(faces) {
                        continue;
                    }
                    // Most hinges turn about other lines.
                    let mut parts = hinge.line_parts_from(other, length);
                    if parts <= NEARLY_AT_REST_RATIO * self.tolerance {
                        parts += length * hinge.turns_unlike(other);
                        found |= self.join(faces, parts);
                    }
                }
            }
        }
        found
    }
}

impl Hinge {
    /// Returns a bound on how far the face moves relative to that of another hinge, if both turn alike against one body:
    /// what their lines are apart, and tears.
    fn line_parts_from(&self, other: &Self, length: f64) -> f64 {
        let [a, b] = [&self.line, &other.line];
        let off = a.distance(&b.point) + length * a.direction.cross(&b.direction).norm();
        self.torn + other.torn + 2.0 * other.turned * off
    }

    /// Returns a bound on the difference between the turns of two faces about one line, radians; no number if none is
    /// known.
    fn turns_unlike(&self, other: &Self) -> f64 {
        let opposite = self.line.direction.dot(&other.line.direction) < 0.0;
        let sign = if opposite { -1.0 } else { 1.0 };
        let ahead: [f64; 4] = core::array::from_fn(|k| self.course[k] - sign * other.course[k]);
        let most = |[low, high]: [f64; 2], ahead: f64| [low.min(ahead), high.max(ahead)];
        let [low, high] = ahead[1..]
            .iter()
            .fold([ahead[0]; 2], |range, &it| most(range, it));
        high - low
    }
}

#[cfg(test)]
mod tests {
    use foldpath_core::{Curve, GroupId};
    use nalgebra::{Vector2, Vector3};

    use super::*;
    use crate::pattern::{Drawing, DrawnEdge, Letter};

    /// Returns a panel and, beyond a line, two flaps with a slit between them.
    fn flaps() -> CreasePattern {
        let vertices = [
            [0, 0],
            [2, 0],
            [2, 1],
            [2, 2],
            [1, 2],
            [0, 2],
            [0, 1],
            [1, 1],
        ];
        let rim = (0..7).map(|k| ([k, (k + 1) % 7], Letter::Boundary));
        let inner = [
            ([6, 7], Letter::Valley),
            ([7, 2], Letter::Valley),
            ([7, 4], Letter::Cut),
        ];
        let edge = |(ends, letter)| DrawnEdge {
            ends,
            letter,
            goal: None,
        };
        CreasePattern::new(Drawing {
            vertices: vertices
                .map(|[x, y]| Vector2::new(f64::from(x), f64::from(y)))
                .to_vec(),
            edges: rim.chain(inner).map(edge).collect(),
            ..Drawing::default()
        })
        .unwrap()
    }

    /// Returns the number of bodies of comoving faces.
    fn bodies(angles: [[f64; 4]; 2], negative: bool) -> usize {
        let pattern = flaps();
        let memberships = [(0, false), (1, negative)].map(|(group, negative)| Membership {
            group: GroupId(group),
            negative,
        });
        let motion = Motion::new(&[angles.map(Curve::Angle).to_vec()], 2);
        let axis = |crease: CreaseId| {
            let ends = pattern.edge(pattern.creases()[crease.index()]).ends;
            let [a, b] = ends.map(|end| pattern.point(end));
            Axis {
                point: a,
                direction: (b - a).normalize(),
            }
        };
        let still = angles.map(|angle| (angle[3] - angle[0]).abs() <= 0.0);
        let segment = (&motion, [0, SEGMENT]);
        let found = comoving_faces(
            &pattern,
            &memberships,
            segment,
            &still,
            |_| [0.0; 2],
            axis,
            [4.0, 1e-6],
        );
        let mut found = found.bodies;
        found.sort_unstable();
        found.dedup();
        found.len()
    }

    #[test]
    fn flaps_on_one_line_move_together_if_they_turn_alike() {
        assert_eq!(flaps().faces().len(), 3);
        let angle = [0.1, 0.4, 0.9, 1.0];
        // The flaps may begin at different angles.
        let ahead = angle.map(|a| a + 0.5);
        assert_eq!(bodies([angle, ahead], false), 2);
        assert_eq!(bodies([angle, angle.map(|a| -a)], true), 2);
        // The flaps turn by nearly the same angle.
        let near = |off: f64| bodies([angle, [0.1, 0.4, 0.9, 1.0 + off]], false);
        assert_eq!([near(1e-7), near(1e-6)], [2, 3]);
        // One flap turns the other way, or not at all.
        assert_eq!(bodies([angle, angle.map(|a| -a)], false), 3);
        assert_eq!(bodies([angle, angle], true), 3);
        assert_eq!(bodies([angle, [0.3; 4]], false), 2);
        assert_eq!(bodies([[0.1; 4], [0.3; 4]], false), 1);
    }

    #[test]
    fn lines_apart_turn_what_they_carry_apart() {
        let motion = Motion::new(&[vec![Curve::Angle([0.0, 1.0, 2.0, 3.0])]], 1);
        let member = Membership {
            group: GroupId(0),
            negative: false,
        };
        let hinge = |point: Vector3<f64>, direction: Vector3<f64>| Hinge {
            face: 0,
            against: 1,
            course: motion.course([0, SEGMENT], member),
            turned: motion.turned([0, SEGMENT], member),
            torn: 0.0,
            line: Axis { point, direction },
        };
        let first = hinge(Vector3::zeros(), Vector3::x());
        let parts = |point, direction| {
            let other = hinge(point, direction);
            first.line_parts_from(&other, 10.0) + 10.0 * first.turns_unlike(&other)
        };
        assert!(parts(Vector3::x(), Vector3::x()) < 1e-12);
        // Half a turn about lines 1e-3 apart moves points apart by 2e-3, about lines askew by 1e-3 by 20e-3.
        assert!(parts(Vector3::y() * 1e-3, Vector3::x()) >= 2e-3);
        let askew = Vector3::new(1.0, 1e-3, 0.0).normalize();
        assert!(parts(Vector3::zeros(), askew) >= 20e-3);
        // A line seen from its other end turns the other way.
        assert!(parts(Vector3::zeros(), -Vector3::x()) >= 60.0);
    }
}
