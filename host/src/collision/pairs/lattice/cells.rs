//! The cells of a lattice, folded at one time after the other, and bounds on how far they move relative to each other.

use foldpath_core::closure::residual;
use foldpath_core::{Curve, HalfAngle, LoopsView, Membership, Spoke, StarsView, norm};

use crate::certificate::SegmentCertifier;
use crate::collision::sweep::motion::{Motion, Tick};
use crate::collision::tolerances::{MAX_EVALUATIONS, TRANSLATION_RAD};
use crate::folding::Pose;
use crate::lattice::{Lattice, LatticeMotion, LatticeMotionBounds, Stretch};
use crate::pattern::{CreasePattern, FaceId};
use crate::util::time_cached::TimeCached;

/// The cells of a lattice at one time after the other.
#[derive(Debug)]
pub(super) struct FoldedCells<'a> {
    pub(super) lattice: &'a Lattice,
    pub(super) folded: LatticeMotion,
    pub(super) time: Tick,
    half_angles: Vec<HalfAngle<f64>>,
    /// Bounds on the motion of cells and faces between the tabulated times.
    pub(super) bounds: LatticeMotionBounds,
    begun: bool,
    /// Largest differences of cells along both steps.
    pub(super) most: [u32; 2],
    /// Powers of both steps, from those backwards by `most` steps on.
    powers: [TimeCached<Pose>; 2],
    poses: TimeCached<Pose>,
}

impl<'a> FoldedCells<'a> {
    /// Makes the cells of a lattice. Cost: O(faces of a cell + cells along both steps).
    pub(super) fn new(
        pattern: &CreasePattern,
        memberships: &[Membership],
        groups: usize,
        (lattice, height): (&'a Lattice, f64),
    ) -> Self {
        let folded = LatticeMotion::new(pattern, memberships, lattice).with_height(height);
        let ends = lattice
            .extent()
            .map(|[low, high]| [low.min(0), high.max(0)]);
        let most = ends.map(|[low, high]| high.abs_diff(low));
        Self {
            lattice,
            bounds: LatticeMotionBounds::new(&folded, most),
            begun: false,
            most,
            time: Tick::MAX,
            half_angles: vec![HalfAngle::default(); groups],
            powers: [(); 2].map(|()| TimeCached::default()),
            poses: TimeCached::default(),
            folded,
        }
    }

    /// Begins a motion: tabulates the bounds on the motion of cells and faces.
    pub(super) fn begin(&mut self, motion: &Motion) {
        self.time = Tick::MAX;
        self.powers.iter_mut().for_each(TimeCached::forget);
        self.poses.forget();
        self.begun = false;
        self.fold(motion, 0);
        let mut bounds = LatticeMotionBounds::new(&self.folded, self.most);
        let stars = [0, 1].map(|step| self.folded.turning(step));
        let mut certifier = SegmentCertifier::default();
        let [mut half_way, mut to] = [(); 2].map(|()| self.half_angles.clone());
        let mut variations = Vec::new();
        let mut index = 0;
        for (last, curves) in motion.segments() {
            let turns = stars
                .each_ref()
                .map(|star| turn(&mut certifier, star, &curves));
            while index < last {
                motion.angle_variations(index, &mut variations);
                motion.half_angles(motion.half_way(index), &mut half_way);
                index += 1;
                motion.half_angles(motion.tick(index), &mut to);
                bounds.push(&mut self.folded, [&half_way, &to], &variations, turns);
            }
        }
        self.bounds = bounds;
        self.begun = true;
        self.time = Tick::MAX;
    }

    /// Goes to a time.
    pub(super) fn fold(&mut self, motion: &Motion, time: Tick) {
        if self.time == time {
            return;
        }
        self.time = time;
        match motion.tabulated(time) {
            Some(index) if self.begun => self.folded.fold_as(&self.bounds, index),
            _ => {
                motion.half_angles(time, &mut self.half_angles);
                self.folded.fold(&self.half_angles);
            }
        }
    }

    /// Returns the rigid motion of space that leads `column` and `row` steps on.
    pub(super) fn translation(&mut self, [column, row]: [i32; 2]) -> Pose {
        match [column, row] {
            [0, 0] => Pose::identity(),
            [_, 0] => self.power(0, column),
            [0, _] => self.power(1, row),
            _ => self.power(0, column) * self.power(1, row),
        }
    }

    /// Returns a power of one step at the current time.
    fn power(&mut self, step: usize, count: i32) -> Pose {
        let at = self.most[step].saturating_add_signed(count) as usize;
        let power = self.powers[step].get(at, self.time).copied();
        power.unwrap_or_else(|| {
            let power = self.folded.steps()[step].power(count);
            self.powers[step].set(at, self.time, power);
            power
        })
    }

    /// Returns the pose of a face.
    pub(super) fn pose(&mut self, motion: &Motion, time: Tick, face: FaceId) -> Pose {
        if let Some(pose) = self.poses.get(face.index(), time) {
            return *pose;
        }
        self.fold(motion, time);
        let coord = self.lattice.coord(face);
        let reduced = self.translation(coord.cell) * self.folded.pose(coord.orbit);
        let origin = self.lattice.translation(coord.cell);
        let pose = Pose::about(reduced.r_wf, origin, reduced.p_w);
        self.poses.set(face.index(), time, pose);
        pose
    }

    /// Returns a lower bound of the distance between two cells with this difference.
    pub(super) fn gap(&mut self, cell: [i32; 2]) -> f64 {
        let center = self.folded.middle();
        let there = self.power(1, cell[1]).carry(&center);
        let there = self.power(0, cell[0]).carry(&there);
        self.folded.gap_at(&there)
    }

    /// Returns a bound on how far two cells may approach each other within the next `count` tabulated times.
    pub(super) fn moved(&self, motion: &Motion, count: usize, cell: [i32; 2]) -> f64 {
        let mut stretch = motion.rest(self.time);
        stretch.to = (stretch.to + count).min(self.bounds.times() - 1);
        self.bounds.cells(stretch, cell)
    }

    /// Returns about the last time until which two cells approach each other by no more than `allowance`, and
    /// the bound on their approach until then. The time is a tabulated one, or one before the next tabulated
    /// time. Returns `None` if no such time after the current one is found.
    pub(super) fn until(
        &self,
        motion: &Motion,
        cell: [i32; 2],
        allowance: f64,
    ) -> Option<(Tick, f64)> {
        let moved = |stretch| self.bounds.cells(stretch, cell);
        self.last(motion, self.time, allowance, moved)
    }

    /// Returns the time as [`until`](Self::until) does, for two faces from a given time on.
    pub(super) fn until_of(
        &self,
        motion: &Motion,
        time: Tick,
        faces: [FaceId; 2],
        allowance: f64,
    ) -> Option<(Tick, f64)> {
        let [from, to] = faces.map(|face| self.lattice.coord(face));
        let offset = [0, 1].map(|k| to.cell[k] - from.cell[k]);
        self.last(motion, time, allowance, |stretch| {
            self.bounds.faces(stretch, [from.orbit, to.orbit], offset)
        })
    }

    fn last(
        &self,
        motion: &Motion,
        time: Tick,
        allowance: f64,
        moved: impl Fn(Stretch) -> f64,
    ) -> Option<(Tick, f64)> {
        let rest = motion.rest(time);
        let moved_to = |to: usize| moved(Stretch { to, ..rest });
        let (mut low, mut high) = (rest.from, self.bounds.times());
        let mut reached = (rest.head > 0.0).then(|| moved_to(low));
        if reached.is_some_and(|by| by > allowance) {
            return motion.before_next(time, allowance, moved);
        }
        let mut next = high - 1;
        // The motion is about uniform, and a time somewhat before the last is as good.
        let mut evaluations = 0;
        while next > low && (evaluations < MAX_EVALUATIONS || reached.is_none()) {
            evaluations += 1;
            let by = moved_to(next);
            if by <= allowance {
                (low, reached) = (next, Some(by));
            } else {
                high = next;
            }
            #[allow(
                clippy::cast_possible_truncation,
                clippy::cast_sign_loss,
                clippy::cast_precision_loss,
                reason = "a guess, put between two times"
            )]
            let guess = rest
                .from
                .saturating_add((allowance / by * (next - rest.from) as f64) as usize);
            if high - low < 2 {
                break;
            }
            next = guess.clamp(low + 1, high - 1);
        }
        match reached {
            Some(by) => Some((motion.tick(low), by)),
            None => motion.before_next(time, allowance, moved),
        }
    }
}

/// Returns a bound on how far a sequence of creases turns the part beyond it from one time of a segment to
/// another (chord on the unit sphere); infinite if the creases do not always turn it back.
fn turn(certifier: &mut SegmentCertifier, creases: &[Spoke<f64>], curves: &[Curve<f64>]) -> f64 {
    let end: Vec<_> = curves.iter().map(|curve| curve.half_angle(1.0)).collect();
    let ends = [FaceId::new(creases.len()).0];
    match StarsView::new(creases, &ends, curves.len()) {
        Some(stars)
            if stars
                .iter()
                .all(|star| norm(&residual(star, &end)) <= TRANSLATION_RAD) =>
        {
            2.0 * certifier.closure(stars, LoopsView::none(), curves).worst()
        }
        _ => f64::INFINITY,
    }
}
