//! The folded sheet in terms of its lattice: one cell, and the motions that lead from cell to cell.

use foldpath_core::{HalfAngle, Membership, Rotation};
use nalgebra::{Vector2, Vector3};

use super::cell_drift::{CellDrift, PlacedHinge, Way};
use super::map::Pose;
use super::screw::Screw;
use crate::pattern::CreasePattern;
use crate::ragged::Ragged;
use crate::symmetry::{Lattice, Link, PairClass};

/// An edge between two faces of a cell, or of neighbouring cells, moved to the cell of the first.
#[derive(Clone, Copy, Debug)]
struct Hinge {
    /// Orbit that the way comes from.
    from: u32,
    /// Orbit that it leads to.
    to: u32,
    /// `None` if the edge stays flat.
    turns: Option<Membership>,
    /// Middle of the edge.
    pivot: Vector2<f64>,
    /// Unit direction about which a positive (valley) fold angle turns the face that the way leads to.
    axis: Vector2<f64>,
}

/// Poses of all faces of a sheet from a few hinges: one cell folded along a tree of orbits, and the rigid
/// motions that the lattice steps become, S₁ and S₂. Where the sheet closes, these commute, and
/// `pose(orbit, [i, j])` = S₁ⁱ S₂ʲ `pose(orbit, [0, 0])`: see [`Lattice`] for why.
///
/// Points of the flat sheet are *reduced*: less the [`translation`](Lattice::translation) of the cell of
/// their face. The face of the first orbit in cell `[0, 0]` stays where it is. One configuration costs
/// O(orbits), one pose as much as a few rotations.
#[derive(Clone, Debug)]
pub struct LatticeMotion {
    /// Ways to the second and every further orbit.
    tree: Vec<Hinge>,
    /// For each step the hinge that leads one cell on, and the step.
    loops: Vec<(Hinge, Vector2<f64>)>,
    /// For each orbit the corners of its faces, reduced.
    corners: Ragged<Vector2<f64>>,
    poses: Vec<Pose>,
    steps: [Screw; 2],
    ball: Ball,
}

/// A ball round all faces of a cell.
#[derive(Clone, Copy, Debug)]
struct Ball {
    center: Vector3<f64>,
    radius: f64,
}

impl LatticeMotion {
    /// The motion of a sheet from its lattice, found for these memberships; the sheet is flat.
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
            poses: vec![Pose::identity(); lattice.orbits().len()],
            steps: [still; 2],
            ball: Ball {
                center: Vector3::zeros(),
                radius: 0.0,
            },
        };
        motion.fold(&[]);
        motion
    }

    /// Goes to the configuration with these half fold angles of the crease groups; those that are not
    /// given are flat. The sheet has to close there. Cost: O(orbits).
    pub fn fold(&mut self, groups: &[HalfAngle<f64>]) {
        for hinge in &self.tree {
            self.poses[hinge.to as usize] = hinge.cross(&self.poses[hinge.from as usize], groups);
        }
        for (screw, (hinge, step)) in self.steps.iter_mut().zip(&self.loops) {
            let ahead = hinge.cross(&self.poses[hinge.from as usize], groups);
            let here = self.poses[hinge.to as usize];
            let r_wf = (ahead.r_wf * here.r_wf.inverse()).renormalised();
            // The origin of the face here goes to where the step of the flat sheet is ahead.
            let p_w = ahead.apply(*step) - r_wf.rotate(&here.p_w);
            *screw = Screw::new(Pose::new(r_wf, p_w));
        }
        self.ball = self.ball();
    }

    fn ball(&self) -> Ball {
        let folded = || {
            let orbits = self.poses.iter().zip(self.corners.iter());
            orbits.flat_map(|(pose, corners)| corners.iter().map(|&corner| pose.apply(corner)))
        };
        #[allow(clippy::cast_precision_loss, reason = "a mean")]
        let count = self.corners.items().len() as f64;
        let center = folded().sum::<Vector3<f64>>() / count;
        let farthest = folded().map(|p| (p - center).norm_squared());
        let radius = farthest.fold(0.0, f64::max).sqrt();
        Ball { center, radius }
    }

    /// Corners of the faces of an orbit in the flat sheet, reduced.
    #[must_use]
    pub fn corners(&self, orbit: u32) -> &[Vector2<f64>] {
        &self.corners[orbit as usize]
    }

    /// S₁ and S₂; where there is one step only, the second rests.
    #[must_use]
    pub fn steps(&self) -> &[Screw; 2] {
        &self.steps
    }

    /// So many steps on in space.
    #[must_use]
    pub fn translation(&self, cell: [i32; 2]) -> Pose {
        match cell {
            [i, 0] => self.steps[0].power(i),
            [0, j] => self.steps[1].power(j),
            [i, j] => self.steps[0].power(i) * self.steps[1].power(j),
        }
    }

    /// The pose of the face of an orbit in a cell, whether the sheet has it or not, for reduced points.
    #[must_use]
    pub fn pose(&self, orbit: u32, cell: [i32; 2]) -> Pose {
        let here = self.poses[orbit as usize];
        match cell {
            [0, 0] => here,
            _ => self.translation(cell) * here,
        }
    }

    /// The pose of the second face of each pair of a class, for reduced points, as seen from the first:
    /// in the frame in which that lies flat where its reduced points are.
    #[must_use]
    pub fn relative(&self, class: PairClass) -> Pose {
        let [a, b] = class.orbits;
        self.pose(a, [0, 0]).inverse() * self.pose(b, class.offset)
    }

    /// A lower bound of the distance between all faces of a cell and all faces of that so many cells on;
    /// 0 where the balls round them meet.
    #[must_use]
    pub fn gap_of_cells(&self, offset: [i32; 2]) -> f64 {
        let Ball { center, radius } = self.ball;
        let there = self.translation(offset).carry(&center);
        ((there - center).norm() - 2.0 * radius).max(0.0)
    }

    /// How far cells can move against each other while each group angle changes by no more than its part
    /// of `changes` (radians; those that are not given do not change) from the configuration at hand.
    /// Cost: O(orbits).
    #[must_use]
    pub fn drift(&self, changes: &[f64]) -> CellDrift {
        let Ball { center, radius } = self.ball;
        let mut drift = CellDrift {
            own: self.own_drift(changes),
            radius,
            ways: [Way::default(); 2],
        };
        for (k, way) in drift.ways.iter_mut().enumerate().take(self.loops.len()) {
            *way = Way::new(&self.chain(k), &self.steps[k], center, changes);
        }
        drift
    }

    /// How far a corner of a cell can move in the frame of the first orbit's face: each hinge on the way
    /// to it moves it by no more than its change times the way from there.
    fn own_drift(&self, changes: &[f64]) -> f64 {
        // For each orbit the sum of the changes, and of each times the way, up to the hinge it hangs on.
        let mut sums = vec![(0.0, 0.0, Vector2::zeros()); self.poses.len()];
        for hinge in &self.tree {
            let (turn, shift, pivot) = sums[hinge.from as usize];
            let way = (hinge.pivot - pivot).norm();
            let turned = turn + hinge.change(changes);
            sums[hinge.to as usize] = (turned, shift + turn * way, hinge.pivot);
        }
        let drifts = sums.iter().zip(self.corners.iter());
        let drifts = drifts.map(|((turn, shift, pivot), corners)| {
            let ways = corners.iter().map(|corner| (corner - pivot).norm());
            shift + turn * ways.fold(0.0, f64::max)
        });
        drifts.fold(0.0, f64::max)
    }

    /// The hinges on the way from the first orbit's face to the same a step on, where they are in space.
    fn chain(&self, step: usize) -> Vec<PlacedHinge> {
        let (closing, _) = &self.loops[step];
        let up = |mut orbit: u32| {
            let mut hinges = Vec::new();
            while let Some(before) = orbit.checked_sub(1) {
                let hinge = &self.tree[before as usize];
                hinges.push(hinge);
                orbit = hinge.from;
            }
            hinges
        };
        let here = Pose::identity();
        let there = self.steps[step].motion();
        let out = up(closing.from).into_iter().rev().chain([closing]);
        let out = out.map(|hinge| hinge.placed(&here, self, 1.0));
        // Ways back are crossed from the other side.
        let back = up(closing.to).into_iter();
        out.chain(back.map(|hinge| hinge.placed(&there, self, -1.0)))
            .collect()
    }
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

    /// The pose of the face beyond, for points reduced as those of the face that the way comes from.
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

    /// Largest change of its fold angle.
    fn change(&self, changes: &[f64]) -> f64 {
        let change = self.group().and_then(|group| changes.get(group));
        change.map_or(0.0, |change| change.abs())
    }

    /// The hinge in space, in a cell to which a motion leads, crossed in the sense of `sense`.
    fn placed(&self, cell: &Pose, motion: &LatticeMotion, sense: f64) -> PlacedHinge {
        let pose = *cell * motion.poses[self.from as usize];
        let negative = self.turns.is_some_and(|membership| membership.negative);
        let sign = if negative { -sense } else { sense };
        PlacedHinge {
            group: self.group(),
            pivot: pose.apply(self.pivot),
            axis: pose.r_wf.rotate(&self.axis.push(0.0)) * sign,
        }
    }
}
