//! The cells of a tessellation along a motion: where their faces are, and how long two of them stay apart.

use foldpath_core::{HalfAngle, Membership};
use nalgebra::{Vector2, Vector3};

use super::hierarchy::circle;
use super::motion::{Motion, Tick};
use super::pieces::Pieces;
use crate::folding::{LatticeCourse, LatticeMotion, Pose};
use crate::pattern::{CreasePattern, FaceId};
use crate::symmetry::{Lattice, PairClass};

/// Looks at how far all moves until a time is taken.
const LOOKS: usize = 4;

/// A lattice that is folded at one time after the other.
#[derive(Clone, Debug)]
pub(super) struct Cells<'a> {
    pub(super) lattice: &'a Lattice,
    folded: LatticeMotion,
    time: Tick,
    half_angles: Vec<HalfAngle<f64>>,
    /// How far all moves between the tabulated times.
    course: LatticeCourse,
    begun: bool,
    /// Largest differences of cells.
    most: [u32; 2],
    /// For each orbit the number of pieces, and a circle round a face, reduced.
    counts: Vec<u64>,
    circles: Vec<(Vector2<f64>, f64)>,
    /// Where those circles are in cell `[0, 0]`, if they were asked for at this time.
    disks: Vec<Disk>,
    centered: Tick,
    /// Powers of both steps, from the lowest on, with their times.
    low: [i32; 2],
    powers: [Vec<(Tick, Pose)>; 2],
    offsets: Vec<Offset>,
}

/// A difference of cells, which stands for the opposite one too.
#[derive(Clone, Debug)]
pub(super) struct Offset {
    cell: [i32; 2],
    /// Number of pairs of pieces.
    pub(super) pairs: u64,
    /// Those that are not looked at one by one.
    pub(super) left: u64,
    /// A bit for each pair of orbits: whether it is; none as long as all are not.
    taken: Vec<u64>,
}

/// A circle in space.
#[derive(Clone, Copy, Debug)]
struct Disk {
    center: Vector3<f64>,
    normal: Vector3<f64>,
    radius: f64,
}

impl Disk {
    /// No more than the distance of two disks: that of the balls round them, or of one disk from the
    /// plane of the other.
    fn apart(&self, other: &Self) -> f64 {
        let between = other.center - self.center;
        let balls = between.norm() - self.radius - other.radius;
        let slant = self.normal.cross(&other.normal).norm();
        let over = self.normal.dot(&between).abs() - other.radius * slant;
        let under = other.normal.dot(&between).abs() - self.radius * slant;
        balls.max(over).max(under)
    }
}

/// Where all pairs of two cells stand that are not looked at one by one.
#[derive(Clone, Debug)]
pub(super) struct Apart {
    /// No more than the smallest distance.
    pub(super) least: f64,
    /// Pairs of faces that may be too near to stand with the others.
    pub(super) near: Vec<[FaceId; 2]>,
    /// Others that may be nearer than the nearest found so far.
    pub(super) nearest: Vec<[FaceId; 2]>,
}

impl<'a> Cells<'a> {
    /// Cost: O(classes of pairs).
    pub(super) fn new(
        pattern: &CreasePattern,
        memberships: &[Membership],
        groups: usize,
        pieces: &Pieces,
        lattice: &'a Lattice,
    ) -> Self {
        let orbits = lattice.orbits();
        let count = |orbit: &crate::symmetry::Orbit| pieces.of(orbit.representative).len() as u64;
        let counts: Vec<_> = orbits.iter().map(count).collect();
        let folded = LatticeMotion::new(pattern, memberships, lattice);
        let ends = |k: usize| {
            let low = orbits.iter().map(|orbit| orbit.low[k]).min();
            let high = orbits.iter().map(|orbit| orbit.high[k]).max();
            [low.unwrap_or_default(), high.unwrap_or_default()]
        };
        let ends = [ends(0), ends(1)];
        let most = ends.map(|[low, high]| high.abs_diff(low));
        let still = (Tick::MAX, Pose::identity());
        Self {
            lattice,
            course: LatticeCourse::new(&folded, most),
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
            // Both cells, and their differences.
            low: ends.map(|[low, high]| low.min(low.saturating_sub(high))),
            powers: ends.map(|[low, high]| {
                let all = 2 * high.abs_diff(low) as usize + 1;
                vec![still; all.max(low.unsigned_abs() as usize + high.unsigned_abs() as usize + 1)]
            }),
            offsets: offsets(lattice, &counts, most),
            counts,
            folded,
        }
    }

    /// Begins a motion: tabulates how far all moves.
    pub(super) fn begin(&mut self, motion: &Motion) {
        self.time = Tick::MAX;
        self.centered = Tick::MAX;
        for (time, _) in self.powers.iter_mut().flatten() {
            *time = Tick::MAX;
        }
        for offset in &mut self.offsets {
            offset.left = offset.pairs;
            offset.taken.clear();
        }
        self.begun = false;
        self.fold(motion, 0);
        let mut course = LatticeCourse::new(&self.folded, self.most);
        let mut bends = Vec::new();
        for index in 1..motion.times() {
            motion.bends(index - 1, &mut bends);
            let tick = motion.tick(index);
            for (group, half) in self.half_angles.iter_mut().enumerate() {
                *half = motion.half_angle(group, tick);
            }
            course.push(&mut self.folded, &self.half_angles, &bends);
        }
        self.course = course;
        self.begun = true;
        self.time = Tick::MAX;
    }

    /// Differences of cells, the farthest first.
    pub(super) fn offsets(&self) -> &[Offset] {
        &self.offsets
    }

    fn fold(&mut self, motion: &Motion, time: Tick) {
        if self.time == time {
            return;
        }
        self.time = time;
        match motion.tabulated(time) {
            Some(index) if self.begun => self.folded.fold_as(&self.course, index),
            _ => {
                for (group, half) in self.half_angles.iter_mut().enumerate() {
                    *half = motion.half_angle(group, time);
                }
                self.folded.fold(&self.half_angles);
            }
        }
    }

    /// So many steps on in space.
    fn translation(&mut self, cell: [i32; 2]) -> Pose {
        let [first, second]: [Option<Pose>; 2] = core::array::from_fn(|k| {
            let power = || self.folded.steps()[k].power(cell[k]);
            let at = usize::try_from(i64::from(cell[k]) - i64::from(self.low[k]));
            let known = at.ok().and_then(|at| self.powers[k].get_mut(at));
            (cell[k] != 0).then(|| {
                let Some((time, known)) = known else {
                    return power();
                };
                if *time != self.time {
                    (*time, *known) = (self.time, power());
                }
                *known
            })
        });
        match (first, second) {
            (Some(first), Some(second)) => first * second,
            (Some(one), None) | (None, Some(one)) => one,
            (None, None) => Pose::identity(),
        }
    }

    /// The pose of a face, and the place of the flat sheet that it takes to its point.
    pub(super) fn pose(
        &mut self,
        motion: &Motion,
        time: Tick,
        face: FaceId,
    ) -> (Pose, Vector2<f64>) {
        self.fold(motion, time);
        let place = self.lattice.place(face);
        let origin = self.lattice.translation(place.cell);
        let here = self.folded.pose(place.orbit, [0, 0]);
        (self.translation(place.cell) * here, origin)
    }

    /// How far apart two cells are at least.
    pub(super) fn gap(&mut self, motion: &Motion, time: Tick, offset: u32) -> f64 {
        self.fold(motion, time);
        let offset = self.offsets[offset as usize].cell;
        let there = self.translation(offset);
        self.folded.gap_at(&there)
    }

    /// Where the faces of two cells stand; pairs no farther apart than `near` are taken to be looked at
    /// one by one, and those nearer than `best` are named.
    pub(super) fn apart(
        &mut self,
        motion: &Motion,
        time: Tick,
        offset: u32,
        [near, best]: [f64; 2],
    ) -> Apart {
        self.fold(motion, time);
        if self.centered != time {
            self.centered = time;
            let disks = (0..).zip(&self.circles).map(|(orbit, &(center, radius))| {
                let pose = self.folded.pose(orbit, [0, 0]);
                Disk {
                    center: pose.apply(center),
                    normal: pose.r_wf.rotate(&Vector3::z()),
                    radius,
                }
            });
            self.disks.clear();
            self.disks.extend(disks);
        }
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
            let here = self.disks[b];
            let disk = Disk {
                center: there.carry(&here.center),
                normal: there.r_wf.rotate(&here.normal),
                ..here
            };
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
                    let class = class(cell, [a, b]);
                    apart.nearest.extend(self.lattice.pair_of(class));
                }
                apart.least = apart.least.min(distance);
            }
        }
        apart
    }

    fn take(&mut self, index: usize, [a, b]: [usize; 2], near: &mut Vec<[FaceId; 2]>) {
        let orbits = self.circles.len();
        let offset = &mut self.offsets[index];
        if offset.taken.is_empty() {
            offset.taken = vec![0; (orbits * orbits).div_ceil(64)];
        }
        let bit = a * orbits + b;
        offset.taken[bit / 64] |= 1 << (bit % 64);
        let class = class(offset.cell, [a, b]);
        if let Some(faces) = self.lattice.pair_of(class) {
            offset.left = offset.left.saturating_sub(self.counts[a] * self.counts[b]);
            near.push(faces);
        }
    }

    /// By how much cells may come closer until some tabulated times later.
    pub(super) fn moved(&self, motion: &Motion, time: Tick, count: usize, offset: u32) -> f64 {
        let from = motion.tabulated(time).unwrap_or_default();
        let to = (from + count).min(self.course.times() - 1);
        let offset = self.offsets[offset as usize].cell;
        self.course.cells([from, to], offset)
    }

    /// About the last tabulated time until which two cells come closer by no more than `allowance`, if one comes
    /// after `time`, and by how much they may.
    pub(super) fn until(
        &self,
        motion: &Motion,
        time: Tick,
        offset: u32,
        allowance: f64,
    ) -> Option<(Tick, f64)> {
        let offset = self.offsets[offset as usize].cell;
        self.last(motion, time, allowance, |times| {
            self.course.cells(times, offset)
        })
    }

    /// The same for two faces.
    pub(super) fn until_of(
        &self,
        motion: &Motion,
        time: Tick,
        faces: [FaceId; 2],
        allowance: f64,
    ) -> Option<(Tick, f64)> {
        let [from, to] = faces.map(|face| self.lattice.place(face));
        let offset = [0, 1].map(|k| to.cell[k] - from.cell[k]);
        self.last(motion, time, allowance, |times| {
            self.course.faces(times, [from.orbit, to.orbit], offset)
        })
    }

    fn last(
        &self,
        motion: &Motion,
        time: Tick,
        allowance: f64,
        moved: impl Fn([usize; 2]) -> f64,
    ) -> Option<(Tick, f64)> {
        let from = motion.tabulated(time)?;
        let (mut low, mut high) = (from, self.course.times());
        let (mut next, mut reached) = (high - 1, None);
        // Motion is about even, and a time somewhat before the last is as good.
        let mut looks = 0;
        while next > low && (looks < LOOKS || reached.is_none()) {
            looks += 1;
            let by = moved([from, next]);
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
            let guess = from.saturating_add((allowance / by * (next - from) as f64) as usize);
            if high - low < 2 {
                break;
            }
            next = guess.clamp(low + 1, high - 1);
        }
        reached.map(|by| (motion.tick(low), by))
    }
}

/// The class of pairs of a face of orbit `a` and one of orbit `b` so many cells on.
fn class([column, row]: [i32; 2], [a, b]: [usize; 2]) -> PairClass {
    let (orbits, offset) = if a <= b {
        ([a, b], [column, row])
    } else {
        ([b, a], [-column, -row])
    };
    PairClass {
        orbits: orbits.map(|orbit| FaceId::new(orbit).0),
        offset,
    }
}

/// All differences of cells, the farthest in the flat sheet first.
fn offsets(lattice: &Lattice, counts: &[u64], [columns, rows]: [u32; 2]) -> Vec<Offset> {
    let width = 2 * columns as usize + 1;
    let mut pairs = vec![0; width * (rows as usize + 1)];
    let class_pairs = |class: &PairClass| {
        let [a, b] = class.orbits.map(|orbit| counts[orbit as usize]);
        a * b
    };
    for class in lattice.pair_classes() {
        let [column, row] = class.offset;
        let back = (row, column) < (0, 0);
        let column = i64::from(if back { -column } else { column }) + i64::from(columns);
        let at = row.unsigned_abs() as usize * width + usize::try_from(column).unwrap_or_default();
        pairs[at] += class_pairs(&class);
    }
    let places = (0..).take(rows as usize + 1).flat_map(|row| {
        let columns = i32::try_from(columns).unwrap_or_default();
        (-columns..=columns).map(move |column| [column, row])
    });
    let offsets = places.zip(pairs).filter(|&(_, pairs)| pairs > 0);
    let mut offsets: Vec<_> = offsets
        .map(|(cell, pairs)| Offset {
            cell,
            pairs,
            left: pairs,
            taken: Vec::new(),
        })
        .collect();
    let length = |offset: &Offset| lattice.translation(offset.cell).norm_squared();
    offsets.sort_by(|a, b| length(b).total_cmp(&length(a)));
    offsets
}
