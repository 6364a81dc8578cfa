//! Broad phase of a sweep along a lattice: pairs of cells along a motion, their distances, and how long two cells or
//! two faces stay apart. A difference of cells stands for all pairs of cells that have it.

use core::ops::{Range, RangeInclusive};

use foldpath_core::closure::residual;
use foldpath_core::{Curve, HalfAngle, LoopsView, Membership, Spoke, StarsView, norm};
use nalgebra::Vector2;

use super::disk::Disk;
use crate::certificate::SegmentCertifier;
use crate::collision::hierarchy::circle;
use crate::collision::motion::{Motion, Tick};
use crate::collision::pieces::count;
use crate::collision::tolerances::{MAX_EVALUATIONS, MAX_OFFSETS, TRANSLATION_RAD, WAKE_TIMES};
use crate::folding::Pose;
use crate::lattice::{
    Lattice, LatticeMotion, LatticeMotionBounds, NeighbourSearch, Orbit, PairClass, Stretch,
};
use crate::pattern::{CreasePattern, FaceId};

/// Pairs of cells of a lattice that is folded at one time after the other.
#[derive(Clone, Debug)]
pub(crate) struct CellPairs<'a> {
    pub(crate) lattice: &'a Lattice,
    folded: LatticeMotion,
    time: Tick,
    half_angles: Vec<HalfAngle<f64>>,
    /// Bounds on the motion of cells and faces between the tabulated times.
    bounds: LatticeMotionBounds,
    begun: bool,
    /// Largest differences of cells along both steps.
    most: [u32; 2],
    /// For each orbit: number of pieces of a face (`counts`), and a circle round a face in reduced coordinates
    /// (`circles`).
    counts: Vec<u64>,
    circles: Vec<(Vector2<f64>, f64)>,
    /// These circles in space, for cell `[0, 0]` (`disks`), and the time for which they were computed (`centered`).
    disks: Vec<Disk>,
    centered: Tick,
    /// Powers of both steps, each with its time, for all cells and for all differences of cells; `low` has the
    /// lowest exponents.
    low: [i32; 2],
    powers: [Vec<(Tick, Pose)>; 2],
    /// Differences of cells woken so far, in order of waking (`offsets`) and sorted (`known`).
    offsets: Vec<Offset>,
    known: Vec<[i32; 2]>,
    pub(crate) all_awake: bool,
    /// For each row of differences, once requested: for each pair of orbits, the columns of differences that exist.
    columns: Vec<Option<Vec<RangeInclusive<i32>>>>,
}

/// A difference of two cells, which stands for the opposite difference too.
#[derive(Clone, Debug)]
pub(crate) struct Offset {
    cell: [i32; 2],
    /// Number of pairs of pieces.
    pairs: u64,
    /// Number of pairs of pieces that are not followed one by one.
    left: u64,
    /// A bit for each pair of orbits, set if the pair is followed one by one; empty as long as none is.
    taken: Vec<u64>,
}

/// Distances between two cells, over all pairs of faces that are not followed one by one.
#[derive(Clone, Debug)]
pub(crate) struct Apart {
    /// Lower bound of the smallest distance.
    pub(crate) least: f64,
    /// Pairs of faces that may be too near to be represented by their cells.
    pub(crate) near: Vec<[FaceId; 2]>,
    /// Other pairs of faces that may be nearer than the nearest found so far.
    pub(crate) nearest: Vec<[FaceId; 2]>,
}

impl<'a> CellPairs<'a> {
    /// Creates the pairs of cells of a lattice. Cost: O(faces of a cell + cells along both steps).
    pub(crate) fn new(
        pattern: &CreasePattern,
        memberships: &[Membership],
        groups: usize,
        lattice: &'a Lattice,
    ) -> Self {
        let orbits = lattice.orbits();
        let count = |orbit: &Orbit| count(pattern, orbit.representative) as u64;
        let counts: Vec<_> = orbits.iter().map(count).collect();
        let folded = LatticeMotion::new(pattern, memberships, lattice);
        let ends = lattice
            .extent()
            .map(|[low, high]| [low.min(0), high.max(0)]);
        let most = ends.map(|[low, high]| high.abs_diff(low));
        let still = (Tick::MAX, Pose::identity());
        Self {
            lattice,
            bounds: LatticeMotionBounds::new(&folded, most),
            begun: false,
            most,
            time: Tick::MAX,
            half_angles: vec![HalfAngle::default(); groups],
            circles: (0..)
                .take(orbits.len())
                .map(|orbit| circle(folded.corners(orbit)))
                .collect(),
            disks: Vec::new(),
            centered: Tick::MAX,
            low: ends.map(|[low, high]| low.saturating_sub(high)),
            powers: ends.map(|[low, high]| vec![still; 2 * high.abs_diff(low) as usize + 1]),
            offsets: Vec::new(),
            known: Vec::new(),
            all_awake: false,
            columns: vec![None; most[1] as usize + 1],
            counts,
            folded,
        }
    }

    /// Begins a motion: tabulates the bounds on the motion of cells and faces.
    pub(crate) fn begin(&mut self, motion: &Motion) {
        self.time = Tick::MAX;
        self.centered = Tick::MAX;
        for (time, _) in self.powers.iter_mut().flatten() {
            *time = Tick::MAX;
        }
        self.offsets.clear();
        self.known.clear();
        self.all_awake = false;
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

    /// Returns the number of pieces of the sheet, and the number of representative pairs (those for which no
    /// other pair stands).
    pub(crate) fn count(&self) -> [u64; 2] {
        let orbits = self.counts.len();
        let pieces = self.lattice.coords().iter();
        let pieces = pieces.map(|coord| self.counts[coord.orbit as usize]);
        let pairs = (0..orbits).flat_map(|b| (0..=b).map(move |a| [a, b]));
        let pairs = pairs.map(|[a, b]| {
            let [columns, rows] = self
                .reach([a, b])
                .map(|[low, high]| u64::from(high.abs_diff(low)) + 1);
            let offsets = if a == b {
                columns * rows / 2
            } else {
                columns * rows
            };
            self.counts[a] * self.counts[b] * offsets
        });
        let pairs = if self.all_awake {
            self.offsets.iter().map(|offset| offset.pairs).sum()
        } else {
            pairs.sum()
        };
        [pieces.sum(), pairs]
    }

    /// Returns the least and largest differences between cells of two orbits, for each step.
    fn reach(&self, orbits: [usize; 2]) -> [[i32; 2]; 2] {
        let [a, b] = orbits.map(|orbit| &self.lattice.orbits()[orbit]);
        [0, 1].map(|k| [b.low[k] - a.high[k], b.high[k] - a.low[k]])
    }

    /// Returns the number of pairs of pieces whose cells have this difference.
    fn pairs(&mut self, [column, row]: [i32; 2]) -> u64 {
        let orbits = self.counts.len();
        let within = [column, row] == [0, 0];
        let columns = columns(&mut self.columns, self.lattice, row);
        let first = (0..orbits).flat_map(|a| (0..orbits).map(move |b| [a, b]));
        let there = first
            .zip(columns)
            .filter(|([a, b], there)| there.contains(&column) && (!within || a < b));
        there
            .map(|([a, b], _)| self.counts[a] * self.counts[b])
            .sum()
    }

    /// Wakes the differences of cells that may come within `near` of each other from a tabulated time to the
    /// [`WAKE_TIMES`]th next, except those woken before. Returns their numbers, which are consecutive; the nearest
    /// comes last. Wakes all differences if steps turn, or if `near` is infinite. Returns `None` if there are too many.
    pub(crate) fn wake(&mut self, motion: &Motion, time: Tick, near: f64) -> Option<Range<u32>> {
        let first = self.offsets.len();
        if !self.all_awake {
            self.fold(motion, time);
            let from = motion.tabulated(time).unwrap_or_default();
            let times = [from, (from + WAKE_TIMES).min(self.bounds.times() - 1)];
            let search = NeighbourSearch::new(&self.folded, &self.bounds, times, near, self.most);
            let mut woken = match search {
                Some(search) => {
                    let mut cells = search.cells();
                    cells.retain(|cell| self.known.binary_search(cell).is_err());
                    cells.retain(|&cell| self.pairs(cell) > 0);
                    cells.retain(|&cell| self.gap(cell) - self.bounds.cells(times, cell) <= near);
                    cells
                }
                None => {
                    self.all_awake = true;
                    self.lattice.offsets(MAX_OFFSETS)?
                }
            };
            let length = |cell: &[i32; 2]| self.lattice.translation(*cell).norm_squared();
            woken.sort_by(|a, b| length(b).total_cmp(&length(a)));
            for cell in woken {
                self.enter(cell);
            }
        }
        let numbers = [first, self.offsets.len()].map(|number| FaceId::new(number).0);
        (self.offsets.len() <= MAX_OFFSETS).then_some(numbers[0]..numbers[1])
    }

    fn enter(&mut self, cell: [i32; 2]) {
        let (pairs, known) = (self.pairs(cell), self.known.binary_search(&cell));
        if let Err(at) = known
            && pairs > 0
        {
            self.known.insert(at, cell);
            self.offsets.push(Offset {
                cell,
                pairs,
                left: pairs,
                taken: Vec::new(),
            });
        }
    }

    fn fold(&mut self, motion: &Motion, time: Tick) {
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
    fn translation(&mut self, [column, row]: [i32; 2]) -> Pose {
        match [column, row] {
            [0, 0] => Pose::identity(),
            [_, 0] => *self.power(0, column),
            [0, _] => *self.power(1, row),
            _ => *self.power(0, column) * *self.power(1, row),
        }
    }

    /// Returns a power of one step at the current time.
    fn power(&mut self, step: usize, count: i32) -> &Pose {
        let at = i64::from(count) - i64::from(self.low[step]);
        let at = usize::try_from(at).unwrap_or(usize::MAX);
        let (time, power) = &mut self.powers[step][at];
        if *time != self.time {
            (*time, *power) = (self.time, self.folded.steps()[step].power(count));
        }
        power
    }

    /// Returns the pose of a face, and the point of the flat sheet that the pose takes to its `p_w`.
    pub(crate) fn pose(
        &mut self,
        motion: &Motion,
        time: Tick,
        face: FaceId,
    ) -> (Pose, Vector2<f64>) {
        self.fold(motion, time);
        let coord = self.lattice.coord(face);
        let origin = self.lattice.translation(coord.cell);
        let here = self.folded.pose(coord.orbit);
        (self.translation(coord.cell) * here, origin)
    }

    /// Returns a lower bound of the distance between two cells whose difference has this number.
    pub(crate) fn gap_of(&mut self, motion: &Motion, time: Tick, offset: u32) -> f64 {
        self.fold(motion, time);
        self.gap(self.offsets[offset as usize].cell)
    }

    fn gap(&mut self, cell: [i32; 2]) -> f64 {
        let center = self.folded.middle();
        let there = self.power(1, cell[1]).carry(&center);
        let there = self.power(0, cell[0]).carry(&there);
        self.folded.gap_at(&there)
    }

    /// Bounds the distances between the faces of two cells. Pairs of faces no farther apart than `near` are
    /// followed one by one from now on, and pairs nearer than `best` are named.
    pub(crate) fn apart(
        &mut self,
        motion: &Motion,
        time: Tick,
        offset: u32,
        [near, best]: [f64; 2],
    ) -> Apart {
        self.fold(motion, time);
        self.put_disks();
        let index = offset as usize;
        let cell = self.offsets[index].cell;
        let there = self.translation(cell);
        let mut apart = Apart {
            least: f64::INFINITY,
            near: Vec::new(),
            nearest: Vec::new(),
        };
        let orbits = self.disks.len();
        for b in 0..orbits {
            let disk = self.disks[b].carried(&there);
            let end = if cell == [0, 0] { b } else { orbits };
            for a in 0..end {
                let bit = a * orbits + b;
                let taken = self.offsets[index].taken.get(bit / 64);
                if taken.is_some_and(|word| word >> (bit % 64) & 1 == 1) {
                    continue;
                }
                let distance = disk.apart(&self.disks[a]);
                if distance <= near {
                    self.take(index, [a, b], &mut apart.near);
                    continue;
                }
                if distance < best {
                    let class = PairClass::of_orbits([a, b], cell);
                    apart.nearest.extend(self.lattice.pair_of(class));
                }
                apart.least = apart.least.min(distance);
            }
        }
        apart
    }

    /// Places the circles round faces in space.
    fn put_disks(&mut self) {
        if self.centered == self.time {
            return;
        }
        self.centered = self.time;
        let disks = (0..)
            .zip(&self.circles)
            .map(|(orbit, &circle)| Disk::new(&self.folded.pose(orbit), circle));
        self.disks.clear();
        self.disks.extend(disks);
    }

    fn take(&mut self, index: usize, [a, b]: [usize; 2], near: &mut Vec<[FaceId; 2]>) {
        let orbits = self.circles.len();
        let offset = &mut self.offsets[index];
        if offset.taken.is_empty() {
            offset.taken = vec![0; (orbits * orbits).div_ceil(64)];
        }
        let bit = a * orbits + b;
        offset.taken[bit / 64] |= 1 << (bit % 64);
        let class = PairClass::of_orbits([a, b], offset.cell);
        if let Some(faces) = self.lattice.pair_of(class) {
            offset.left = offset.left.saturating_sub(self.counts[a] * self.counts[b]);
            near.push(faces);
        }
    }

    /// Returns the number of pairs of pieces of two cells that are not followed one by one.
    pub(crate) fn left(&self, offset: u32) -> u64 {
        self.offsets[offset as usize].left
    }

    /// Returns a bound on how far two cells may approach each other within the next `count` tabulated times.
    pub(crate) fn moved(&self, motion: &Motion, time: Tick, count: usize, offset: u32) -> f64 {
        let mut stretch = motion.rest(time);
        stretch.to = (stretch.to + count).min(self.bounds.times() - 1);
        self.bounds
            .cells(stretch, self.offsets[offset as usize].cell)
    }

    /// Returns about the last time until which two cells approach each other by no more than `allowance`, and
    /// the bound on their approach until then. The time is a tabulated one, or one before the next tabulated
    /// time. Returns `None` if no such time after `time` is found.
    pub(crate) fn until(
        &self,
        motion: &Motion,
        time: Tick,
        offset: u32,
        allowance: f64,
    ) -> Option<(Tick, f64)> {
        let offset = self.offsets[offset as usize].cell;
        self.last(motion, time, allowance, |stretch| {
            self.bounds.cells(stretch, offset)
        })
    }

    /// Returns what [`until`](Self::until) does, for two faces.
    pub(crate) fn until_of(
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

/// Returns, for each pair of orbits, the columns of differences that exist in this row of differences.
fn columns<'a>(
    known: &'a mut [Option<Vec<RangeInclusive<i32>>>],
    lattice: &Lattice,
    row: i32,
) -> &'a [RangeInclusive<i32>] {
    known[row.unsigned_abs() as usize].get_or_insert_with(|| {
        let orbits = lattice.orbits().iter();
        let pairs = orbits.flat_map(|a| lattice.orbits().iter().map(move |b| [a, b]));
        pairs
            .map(|pair| lattice.columns_between(pair, row))
            .collect()
    })
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
