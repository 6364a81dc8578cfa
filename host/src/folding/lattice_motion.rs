//! Folds a tessellation by its lattice: one cell, and the rigid motions that lead from cell to cell.

use foldpath_core::{HalfAngle, Membership, Rotation, Spoke};
use nalgebra::{Vector2, Vector3};

use super::lattice_course::{Bend, Folded, LatticeCourse, Passage, Stray};
use super::map::Pose;
use super::screw::Screw;
use crate::pattern::CreasePattern;
use crate::ragged::Ragged;
use crate::symmetry::{Lattice, Link, PairClass};

/// An edge between two faces of a cell, or of neighbouring cells, moved to the cell of the first.
#[derive(Clone, Copy, Debug)]
struct Hinge {
    /// Orbit of the face that the way comes from.
    from: u32,
    /// Orbit of the face that the way leads to.
    to: u32,
    /// Group and sign of the crease; `None` if the edge stays flat.
    turns: Option<Membership>,
    /// Middle of the edge.
    pivot: Vector2<f64>,
    /// Unit direction about which a positive (valley) fold angle turns the face that the way leads to.
    axis: Vector2<f64>,
}

/// Poses of all faces of a sheet from a few hinges: one cell folded along a tree of orbits, and the rigid
/// motions S₁ and S₂ of space that the lattice steps become. If the sheet closes, these commute, and
/// `pose(orbit, [i, j])` = S₁ⁱ S₂ʲ `pose(orbit, [0, 0])`; [`Lattice`] gives the reason.
///
/// Points of the flat sheet are *reduced*: less the [`translation`](Lattice::translation) of the cell of their
/// face. The face of the first orbit in cell `[0, 0]` stays where it is. One configuration costs O(orbits), one
/// pose as much as a few rotations.
#[derive(Clone, Debug)]
pub struct LatticeMotion {
    /// Hinges to the second and every further orbit.
    tree: Vec<Hinge>,
    /// For each step a hinge that leads one cell on, and the step.
    loops: Vec<(Hinge, Vector2<f64>)>,
    /// For each orbit the corners of its faces, reduced.
    corners: Ragged<Vector2<f64>>,
    folded: Folded,
    /// Positions of `corners` in space, for the cell at the origin.
    places: Vec<Vector3<f64>>,
    ball: Ball,
    center: Vector2<f64>,
    reaches: Vec<(f64, f64)>,
    passages: Vec<Passage>,
}

/// A ball round all faces of a cell.
#[derive(Clone, Copy, Debug)]
struct Ball {
    center: Vector3<f64>,
    radius: f64,
}

impl LatticeMotion {
    /// Creates the motion of a sheet from its lattice, found for these memberships; the sheet is flat.
    #[must_use]
    pub fn new(pattern: &CreasePattern, memberships: &[Membership], lattice: &Lattice) -> Self {
        let hinge = |link: &Link| Hinge::new(pattern, memberships, lattice, link);
        let still = Screw::new(Pose::identity());
        let steps = lattice.loops().iter().zip(lattice.steps());
        let corners = lattice.orbits().iter().map(|orbit| {
            let origin = lattice.translation(lattice.place(orbit.representative).cell);
            let cycle = pattern.faces()[orbit.representative.index()].iter();
            cycle.map(move |v| pattern.vertices()[v.index()] - origin)
        });
        let mut motion = Self {
            tree: lattice.tree().iter().map(hinge).collect(),
            loops: steps.map(|(link, &step)| (hinge(link), step)).collect(),
            corners: corners.collect(),
            folded: Folded {
                poses: vec![Pose::identity(); lattice.orbits().len()],
                steps: [still; 2],
            },
            places: Vec::new(),
            ball: Ball {
                center: Vector3::zeros(),
                radius: 0.0,
            },
            center: Vector2::zeros(),
            reaches: Vec::new(),
            passages: Vec::new(),
        };
        let first = &motion.corners[0];
        #[allow(clippy::cast_precision_loss, reason = "a mean")]
        let center = first.iter().sum::<Vector2<f64>>() / first.len() as f64;
        motion.center = center;
        motion.reaches = motion.reaches();
        motion.passages = (0..motion.loops.len())
            .map(|step| motion.passage(step))
            .collect();
        motion.fold(&[]);
        motion
    }

    /// Goes to the configuration with these half fold angles of the crease groups; groups without one are flat.
    /// The sheet has to close at this configuration. Cost: O(orbits).
    pub fn fold(&mut self, groups: &[HalfAngle<f64>]) {
        let Folded { poses, steps } = &mut self.folded;
        for hinge in &self.tree {
            poses[hinge.to as usize] = hinge.cross(&poses[hinge.from as usize], groups);
        }
        for (screw, (hinge, step)) in steps.iter_mut().zip(&self.loops) {
            let ahead = hinge.cross(&poses[hinge.from as usize], groups);
            let here = poses[hinge.to as usize];
            let r_wf = (ahead.r_wf * here.r_wf.inverse()).renormalised();
            // The origin of the face here goes to the place that the face ahead gives the step.
            let p_w = ahead.apply(*step) - r_wf.rotate(&here.p_w);
            *screw = Screw::new(Pose::new(r_wf, p_w));
        }
        self.place();
    }

    /// Places the corners of the cell, and puts a ball round them.
    fn place(&mut self) {
        self.places.clear();
        for (pose, corners) in self.folded.poses.iter().zip(self.corners.iter()) {
            self.places
                .extend(corners.iter().map(|&corner| pose.apply(corner)));
        }
        #[allow(clippy::cast_precision_loss, reason = "a mean")]
        let center = self.places.iter().sum::<Vector3<f64>>() / self.places.len() as f64;
        let away = self.places.iter().map(|p| (p - center).norm_squared());
        let radius = away.fold(0.0, f64::max).sqrt();
        self.ball = Ball { center, radius };
    }

    /// Returns the corners of the faces of an orbit in the flat sheet, reduced.
    #[must_use]
    pub fn corners(&self, orbit: u32) -> &[Vector2<f64>] {
        &self.corners[orbit as usize]
    }

    /// Returns S₁ and S₂; if there is one step only, the second is the identity.
    #[must_use]
    pub fn steps(&self) -> &[Screw; 2] {
        &self.folded.steps
    }

    /// Returns the rigid motion of space that leads from cell `[0, 0]` to this cell.
    #[must_use]
    pub fn translation(&self, cell: [i32; 2]) -> Pose {
        match cell {
            [i, 0] => self.folded.steps[0].power(i),
            [0, j] => self.folded.steps[1].power(j),
            [i, j] => self.folded.steps[0].power(i) * self.folded.steps[1].power(j),
        }
    }

    /// Returns the pose of the face of an orbit in a cell, for reduced points, whether the sheet has this face
    /// or not.
    #[must_use]
    pub fn pose(&self, orbit: u32, cell: [i32; 2]) -> Pose {
        let here = self.folded.poses[orbit as usize];
        match cell {
            [0, 0] => here,
            _ => self.translation(cell) * here,
        }
    }

    /// Returns the pose of the second face of each pair of a class as seen from the first, for reduced points:
    /// in the frame in which the first lies flat at its reduced points.
    #[must_use]
    pub fn relative(&self, class: PairClass) -> Pose {
        let [a, b] = class.orbits;
        self.pose(a, [0, 0]).inverse() * self.pose(b, class.offset)
    }

    /// Returns a lower bound of the distance between all faces of a cell and all faces of the cell `offset`
    /// steps on; 0 if the balls round them meet.
    #[must_use]
    pub fn gap_of_cells(&self, offset: [i32; 2]) -> f64 {
        self.gap_at(&self.translation(offset).carry(&self.ball.center))
    }

    /// Returns the bound of [`gap_of_cells`](Self::gap_of_cells) for a cell with this middle.
    pub(crate) fn gap_at(&self, middle: &Vector3<f64>) -> f64 {
        let Ball { center, radius } = self.ball;
        ((middle - center).norm() - 2.0 * radius).max(0.0)
    }

    /// Returns the middle of the ball round a cell.
    pub(crate) fn middle(&self) -> Vector3<f64> {
        self.ball.center
    }

    /// Returns the radius of the ball round a cell.
    pub(crate) fn radius(&self) -> f64 {
        self.ball.radius
    }

    /// Returns the translation of a cell's centre by each step, and a bound on the distance of a centre up to
    /// `most` steps on from the sum of these translations, which comes from the rotation of the steps.
    pub(crate) fn ways(&self, most: [u32; 2]) -> ([Vector3<f64>; 2], f64) {
        let center = self.ball.center;
        let motions = self.folded.steps.map(|step| step.motion());
        let ways = motions.map(|motion| motion.carry(&center) - center);
        let [i, j] = most.map(f64::from);
        let [first, second] = motions.map(|motion| 2.0 * motion.r_wf.v.norm());
        let [a, b] = ways.map(|way| way.norm());
        (
            ways,
            i * first * ((i + 1.0) / 2.0 * a + j * b) + j * (j + 1.0) / 2.0 * second * b,
        )
    }

    /// Goes to the configuration that a course has at one of its times.
    pub fn fold_as(&mut self, course: &LatticeCourse, time: usize) {
        self.folded.clone_from(course.at(time));
        self.place();
    }

    pub(super) fn folded(&self) -> &Folded {
        &self.folded
    }

    /// Returns the corners of the faces of the cell in space, orbit after orbit.
    pub(super) fn places(&self) -> &[Vector3<f64>] {
        &self.places
    }

    /// Returns a point of the first orbit's face that moves with its cell.
    pub(super) fn center(&self) -> Vector3<f64> {
        self.center.push(0.0)
    }

    pub(super) fn corners_of(&self, orbit: usize) -> &[Vector2<f64>] {
        &self.corners[orbit]
    }

    /// Returns for each orbit a bound on the deviation of its corners from their quadratics, in the frame of
    /// the first orbit's face (see [`LatticeCourse`]).
    pub(super) fn strayed(&self, bends: &[Bend]) -> impl Iterator<Item = f64> {
        let mut strays = vec![Stray::default(); self.reaches.len()];
        for (hinge, &(way, _)) in self.tree.iter().zip(&self.reaches[1..]) {
            let bend = bend(hinge.group(), bends);
            strays[hinge.to as usize] = strays[hinge.from as usize].across(way, bend);
        }
        let reaches = self.reaches.iter().map(|&(_, reach)| reach);
        strays
            .into_iter()
            .zip(reaches)
            .map(|(stray, reach)| stray.to(reach))
    }

    /// Returns bounds on the deviation from their quadratics of the next cell's centre, and of the step's
    /// rotation.
    pub(super) fn step_strayed(&self, step: usize, bends: &[Bend]) -> [f64; 2] {
        let Some(passage) = self.passages.get(step) else {
            return [0.0; 2];
        };
        let hinges = passage.hinges.iter();
        let stray = hinges.fold(Stray::default(), |stray, hinge| {
            let group = hinge.spoke.map(|spoke| spoke.group.index());
            stray.across(hinge.way, bend(group, bends))
        });
        [stray.to(passage.rest), stray.turn()]
    }

    /// Returns the creases that turn the part one step on, in order, as the star of a vertex: the star closes
    /// if the step is a translation.
    pub(crate) fn turning(&self, step: usize) -> Vec<Spoke<f64>> {
        let hinges = self.passages.get(step).map(|passage| passage.hinges.iter());
        hinges
            .into_iter()
            .flatten()
            .filter_map(|hinge| hinge.spoke)
            .collect()
    }

    /// Returns for each orbit the distance to its hinge from the one before, and from the hinge to the farthest
    /// corner.
    fn reaches(&self) -> Vec<(f64, f64)> {
        let mut pivots = vec![self.center; self.corners.len()];
        let mut reaches = vec![(0.0, 0.0); self.corners.len()];
        for hinge in &self.tree {
            let to = hinge.to as usize;
            pivots[to] = hinge.pivot;
            let corners = self.corners[to].iter();
            let farthest = corners.map(|corner| (corner - hinge.pivot).norm());
            let way = (hinge.pivot - pivots[hinge.from as usize]).norm();
            reaches[to] = (way, farthest.fold(0.0, f64::max));
        }
        reaches
    }

    /// Returns the hinges on the way from the first orbit's face to its image one step on.
    fn passage(&self, step: usize) -> Passage {
        let (closing, shift) = &self.loops[step];
        let up = |mut orbit: u32| {
            let mut hinges = Vec::new();
            while let Some(before) = orbit.checked_sub(1) {
                let hinge = &self.tree[before as usize];
                hinges.push((hinge.spoke(), hinge.pivot));
                orbit = hinge.from;
            }
            hinges
        };
        let mut hinges = up(closing.from);
        hinges.reverse();
        hinges.push((closing.spoke(), closing.pivot));
        let back = up(closing.to).into_iter();
        // Crossed the other way, a hinge turns the part beyond back.
        hinges.extend(back.map(|(spoke, pivot)| {
            let spoke = spoke.map(|spoke| Spoke {
                negative: !spoke.negative,
                ..spoke
            });
            (spoke, pivot + shift)
        }));
        Passage::new(&hinges, self.center, self.center + shift)
    }
}

fn bend(group: Option<usize>, bends: &[Bend]) -> Bend {
    let bend = group.and_then(|group| bends.get(group));
    bend.copied().unwrap_or_default()
}

impl Hinge {
    fn new(
        pattern: &CreasePattern,
        memberships: &[Membership],
        lattice: &Lattice,
        link: &Link,
    ) -> Self {
        let edge = pattern.edge(link.edge);
        let [from, to] = [link.from, link.to].map(|face| lattice.place(face));
        // A positive turn about the edge's direction lifts its left side.
        let start = usize::from(edge.faces[0] != Some(link.to));
        let ends = edge.ends.map(|end| pattern.vertices()[end.index()]);
        Self {
            from: from.orbit,
            to: to.orbit,
            turns: edge.crease.map(|crease| memberships[crease.index()]),
            pivot: (ends[0] + ends[1]) / 2.0 - lattice.translation(from.cell),
            axis: pattern.direction(link.edge, edge.ends[start]),
        }
    }

    /// Returns the pose of the face beyond, for points reduced as those of the face that the way comes from.
    fn cross(&self, parent: &Pose, groups: &[HalfAngle<f64>]) -> Pose {
        let Some(membership) = self.turns else {
            return *parent;
        };
        let half = groups.get(membership.group.index());
        let half = half.copied().unwrap_or_default();
        let half = half.signed(membership.negative);
        let turn = Rotation::about_crease(half, [self.axis.x, self.axis.y]);
        let r_wf = (parent.r_wf * turn).renormalised();
        // The pivot stays where the parent takes it.
        Pose::about(r_wf, self.pivot, parent.apply(self.pivot))
    }

    fn group(&self) -> Option<usize> {
        self.turns.map(|membership| membership.group.index())
    }

    fn spoke(&self) -> Option<Spoke<f64>> {
        self.turns.map(|Membership { group, negative }| Spoke {
            group,
            negative,
            direction: self.axis.into(),
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::generate::Waterbomb;
    use crate::symmetry::CreaseGroups;

    #[test]
    fn cells_are_near_where_translations_take_them() {
        let sheet = Waterbomb {
            rows: 8,
            columns: 10,
            fold: 0.2,
        };
        let pattern = CreasePattern::new(sheet.drawing().unwrap()).unwrap();
        let groups = CreaseGroups::find(&pattern);
        let lattice = Lattice::find(&pattern, groups.memberships()).unwrap();
        let mut angles = vec![HalfAngle::default(); groups.len()];
        for (&id, member) in pattern.creases().iter().zip(groups.memberships()) {
            let goal = member.apply(pattern.edge(id).goal.unwrap());
            angles[member.group.index()] = HalfAngle::of(goal);
        }
        let mut motion = LatticeMotion::new(&pattern, groups.memberships(), &lattice);
        motion.fold(&angles);
        for most in [[1, 0], [0, 1], [1, 1], [3, 2]] {
            let (ways, bent) = motion.ways(most);
            let [columns, rows] = most.map(u32::cast_signed);
            for [i, j] in (-columns..=columns).flat_map(|i| (-rows..=rows).map(move |j| [i, j])) {
                let center = motion.ball.center;
                let way = motion.translation([i, j]).carry(&center) - center;
                let straight = ways[0] * f64::from(i) + ways[1] * f64::from(j);
                let off = (way - straight).norm();
                assert!(off <= bent + 1e-12, "{most:?} {i} {j}: {off} {bent}");
            }
        }
    }
}
