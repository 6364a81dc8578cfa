//! Folds a tessellation by its lattice: one cell, and the rigid motions that lead from cell to cell.

use foldpath_core::{HalfAngle, Membership, Spoke};
use nalgebra::{Vector2, Vector3};

use super::deviation::{AngleVariation, DeviationBound};
use super::motion_bounds::LatticeMotionBounds;
use super::orbits::{Lattice, Link};
use super::screw::Screw;
use crate::folding::{Hinge, Pose, Product, half_angle, place_all};
use crate::pattern::CreasePattern;
use crate::util::csr::Csr;

/// A configuration of the cell and its steps.
#[derive(Clone, Debug)]
pub(super) struct CellConfiguration {
    /// Pose of each orbit's face in cell `[0, 0]`.
    pub(super) poses: Vec<Pose>,
    /// S₁ and S₂; the second is the identity if there is one step only.
    pub(super) steps: [Screw; 2],
}

/// Poses of all faces of a sheet from a few hinges: one cell folded along a tree of orbits, and the rigid
/// motions S₁ and S₂ of space that the lattice steps become. If the sheet closes, these commute, and
/// the face of an orbit in cell `[i, j]` has the pose S₁ⁱ S₂ʲ `pose(orbit)`; [`Lattice`] gives the reason.
///
/// Points of the flat sheet are *reduced*: less the [`translation`](Lattice::translation) of the cell of their
/// face. The face of the first orbit in cell `[0, 0]` stays where it is. One configuration costs O(orbits), one
/// pose as much as a few rotations.
#[derive(Clone, Debug)]
pub struct LatticeMotion {
    /// Hinges between faces of a cell, from orbit to orbit, to the second and every further orbit. Pivots are the middles
    /// of the edges, reduced as the face before.
    tree: Vec<Hinge>,
    /// For each step a hinge that leads one cell on, and the step.
    loops: Vec<(Hinge, Vector2<f64>)>,
    /// For each orbit the corners of its faces, reduced.
    corners: Csr<Vector2<f64>>,
    folded: CellConfiguration,
    /// Largest distance of a point from the plane of its face, for plates; 0 for faces without a thickness.
    height: f64,
    /// Positions of `corners` in space, for the cell at the origin; of plates, those at both heights.
    places: Vec<Vector3<f64>>,
    ball: Ball,
    center: Vector2<f64>,
    reaches: Vec<(f64, f64)>,
    /// For each step the path to the next cell.
    paths: Vec<PathToNextCell>,
}

/// A ball round all faces of a cell.
#[derive(Clone, Copy, Debug, Default)]
struct Ball {
    center: Vector3<f64>,
    radius: f64,
}

/// A hinge on the way from a cell to the next, and the distance to it from the hinge before, both in the flat sheet.
#[derive(Clone, Copy, Debug)]
struct PathHinge {
    /// The hinge as a spoke of a star; `None` if it stays flat.
    spoke: Option<Spoke<f64>>,
    way: f64,
}

/// The hinges from a cell to the next, and the distance from the last hinge to the next cell's centre.
#[derive(Clone, Debug)]
struct PathToNextCell {
    hinges: Vec<PathHinge>,
    rest: f64,
}

impl LatticeMotion {
    /// Creates the motion of a sheet from its lattice, found for these memberships; the sheet is flat.
    #[must_use]
    pub fn new(pattern: &CreasePattern, memberships: &[Membership], lattice: &Lattice) -> Self {
        let hinge = |link: &Link| hinge(pattern, memberships, lattice, link);
        let still = Screw::new(Pose::identity());
        let steps = lattice.loops().iter().zip(lattice.steps());
        let corners = lattice.orbits().iter().map(|orbit| {
            let origin = lattice.translation(lattice.coord(orbit.representative).cell);
            let cycle = pattern.faces()[orbit.representative.index()].iter();
            cycle.map(move |v| pattern.vertices()[v.index()] - origin)
        });
        let corners: Csr<_> = corners.collect();
        #[allow(clippy::cast_precision_loss, reason = "a mean")]
        let center = corners[0].iter().sum::<Vector2<f64>>() / corners[0].len() as f64;
        let mut motion = Self {
            tree: lattice.tree().iter().map(hinge).collect(),
            loops: steps.map(|(link, &step)| (hinge(link), step)).collect(),
            corners,
            folded: CellConfiguration {
                poses: vec![Pose::identity(); lattice.orbits().len()],
                steps: [still; 2],
            },
            height: 0.0,
            places: Vec::new(),
            ball: Ball::default(),
            center,
            reaches: Vec::new(),
            paths: Vec::new(),
        };
        motion.reaches = motion.reaches();
        motion.paths = (0..motion.loops.len())
            .map(|step| motion.path_to_next(step))
            .collect();
        motion.fold(&[]);
        motion
    }

    /// Makes the faces plates, of which no point is farther from the plane of its face than `height`.
    #[must_use]
    pub(crate) fn with_height(mut self, height: f64) -> Self {
        self.height = height;
        for (_, reach) in &mut self.reaches {
            *reach += height;
        }
        self.place();
        self
    }

    /// Goes to the configuration with these half fold angles of the crease groups; groups without one are flat.
    /// The sheet has to close at this configuration. Cost: O(orbits).
    pub fn fold(&mut self, groups: &[HalfAngle<f64>]) {
        let CellConfiguration { poses, steps } = &mut self.folded;
        let product = Product::Renormalised;
        place_all(poses, &self.tree, groups, product);
        for (screw, (hinge, step)) in steps.iter_mut().zip(&self.loops) {
            let half_angle = |member| half_angle(groups, member);
            let ahead = hinge.cross(&poses[hinge.from as usize], half_angle, product);
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
            if self.height > 0.0 {
                let up = pose.normal() * self.height;
                let middle = self.places.len() - corners.len();
                for corner in middle..self.places.len() {
                    let at = self.places[corner];
                    self.places[corner] = at + up;
                    self.places.push(at - up);
                }
            }
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

    /// Returns the pose of the face of an orbit in cell `[0, 0]`, for reduced points.
    #[must_use]
    pub fn pose(&self, orbit: u32) -> Pose {
        self.folded.poses[orbit as usize]
    }

    /// Returns a lower bound of the distance between all faces of the cell and all faces of a cell with this middle; 0
    /// if the balls round them meet.
    #[must_use]
    pub fn gap_at(&self, middle: &Vector3<f64>) -> f64 {
        let Ball { center, radius } = self.ball;
        ((middle - center).norm() - 2.0 * radius).max(0.0)
    }

    /// Returns the middle of the ball round the cell.
    #[must_use]
    pub fn middle(&self) -> Vector3<f64> {
        self.ball.center
    }

    /// Returns the radius of the ball round a cell.
    pub(super) fn radius(&self) -> f64 {
        self.ball.radius
    }

    /// Returns the translation of a cell's centre by each step, and a bound on the distance of a centre up to
    /// `most` steps on from the sum of these translations, which comes from the rotation of the steps.
    pub(super) fn ways(&self, most: [u32; 2]) -> ([Vector3<f64>; 2], f64) {
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

    /// Goes to the configuration at one of the times of a motion with these bounds.
    pub fn fold_as(&mut self, bounds: &LatticeMotionBounds, time: usize) {
        self.folded.clone_from(bounds.at(time));
        self.place();
    }

    pub(super) fn folded(&self) -> &CellConfiguration {
        &self.folded
    }

    /// Returns the number of points of an orbit among [`places`](Self::places).
    pub(super) fn places_of(&self, orbit: u32) -> usize {
        let corners = self.corners(orbit).len();
        if self.height > 0.0 {
            2 * corners
        } else {
            corners
        }
    }

    /// Returns the corners of the faces of the cell in space, orbit after orbit.
    pub(super) fn places(&self) -> &[Vector3<f64>] {
        &self.places
    }

    /// Returns a point of the first orbit's face that moves with its cell.
    pub(super) fn center(&self) -> Vector3<f64> {
        self.center.push(0.0)
    }

    /// Returns for each orbit a bound on the deviation of its corners from their quadratics, in the frame of
    /// the first orbit's face (see [`LatticeMotionBounds`]).
    pub(super) fn deviations(&self, variations: &[AngleVariation]) -> impl Iterator<Item = f64> {
        let mut deviations = vec![DeviationBound::default(); self.reaches.len()];
        for (hinge, &(way, _)) in self.tree.iter().zip(&self.reaches[1..]) {
            let variation = variation_of(hinge.group(), variations);
            deviations[hinge.to as usize] = deviations[hinge.from as usize].across(way, variation);
        }
        let reaches = self.reaches.iter().map(|&(_, reach)| reach);
        deviations
            .into_iter()
            .zip(reaches)
            .map(|(deviation, reach)| deviation.at(reach))
    }

    /// Returns bounds on the deviation from their quadratics of the next cell's centre, and of the step's rotation.
    pub(super) fn step_deviations(&self, step: usize, variations: &[AngleVariation]) -> [f64; 2] {
        let Some(path) = self.paths.get(step) else {
            return [0.0; 2];
        };
        let hinges = path.hinges.iter();
        let deviation = hinges.fold(DeviationBound::default(), |deviation, hinge| {
            let group = hinge.spoke.map(|spoke| spoke.group.index());
            deviation.across(hinge.way, variation_of(group, variations))
        });
        [deviation.at(path.rest), deviation.rotation()]
    }

    /// Returns the creases that turn the part one step on, in order, as the star of a vertex: the star closes
    /// if the step is a translation.
    pub(crate) fn turning(&self, step: usize) -> Vec<Spoke<f64>> {
        let hinges = self.paths.get(step).map(|path| path.hinges.iter());
        hinges
            .into_iter()
            .flatten()
            .filter_map(|hinge| hinge.spoke)
            .collect()
    }

    /// Returns for each orbit the distance to its hinge from the one before, and from the hinge to the farthest corner.
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

    /// Returns the path from the first orbit's face to its image one step on.
    fn path_to_next(&self, step: usize) -> PathToNextCell {
        let (closing, shift) = &self.loops[step];
        let up = |mut orbit: u32| {
            let mut hinges = Vec::new();
            while let Some(before) = orbit.checked_sub(1) {
                let hinge = &self.tree[before as usize];
                hinges.push((spoke(hinge), hinge.pivot));
                orbit = hinge.from;
            }
            hinges
        };
        let mut hinges = up(closing.from);
        hinges.reverse();
        hinges.push((spoke(closing), closing.pivot));
        let back = up(closing.to).into_iter();
        // Crossed the other way, a hinge turns the part beyond back.
        hinges.extend(back.map(|(spoke, pivot)| {
            let spoke = spoke.map(|spoke| Spoke {
                negative: !spoke.negative,
                ..spoke
            });
            (spoke, pivot + shift)
        }));
        let mut before = self.center;
        let mut way_to = |pivot: Vector2<f64>| {
            let way = (pivot - before).norm();
            before = pivot;
            way
        };
        let hinges = hinges.into_iter().map(|(spoke, pivot)| PathHinge {
            spoke,
            way: way_to(pivot),
        });
        PathToNextCell {
            hinges: hinges.collect(),
            rest: way_to(self.center + shift),
        }
    }
}

/// Returns the variation of a group, 0 if there is no group.
fn variation_of(group: Option<usize>, variations: &[AngleVariation]) -> AngleVariation {
    let variation = group.and_then(|group| variations.get(group));
    variation.copied().unwrap_or_default()
}

/// Returns the edge between two faces of a cell, or of neighbouring cells, moved to the cell of the first.
fn hinge(
    pattern: &CreasePattern,
    memberships: &[Membership],
    lattice: &Lattice,
    link: &Link,
) -> Hinge {
    let edge = pattern.edge(link.edge);
    let [from, to] = [link.from, link.to].map(|face| lattice.coord(face));
    // A positive turn about the edge's direction lifts its left side.
    let start = usize::from(edge.faces[0] != Some(link.to));
    let ends = edge.ends.map(|end| pattern.vertices()[end.index()]);
    Hinge {
        from: from.orbit,
        to: to.orbit,
        turns: edge.crease.map(|crease| memberships[crease.index()]),
        pivot: (ends[0] + ends[1]) / 2.0 - lattice.translation(from.cell),
        axis: pattern.direction(link.edge, edge.ends[start]),
    }
}

/// Returns a hinge that turns as the spoke of a star.
fn spoke(hinge: &Hinge) -> Option<Spoke<f64>> {
    hinge.turns.map(|Membership { group, negative }| Spoke {
        group,
        negative,
        direction: hinge.axis.into(),
    })
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
                let [first, second] = motion.steps();
                let there = first.power(i).carry(&second.power(j).carry(&center));
                let way = there - center;
                let straight = ways[0] * f64::from(i) + ways[1] * f64::from(j);
                let off = (way - straight).norm();
                assert!(off <= bent + 1e-12, "{most:?} {i} {j}: {off} {bent}");
            }
        }
    }
}
