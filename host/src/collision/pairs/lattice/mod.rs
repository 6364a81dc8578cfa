//! Pairs of a lattice: cells that come near each other, and pairs of faces of such cells. A difference of cells stands for
//! all pairs of cells that have it.

mod cells;
mod disk;

use core::ops::{Range, RangeInclusive};
use std::collections::{HashMap, HashSet};
use std::sync::Arc;

use foldpath_core::Membership;
use nalgebra::Vector2;

use self::cells::FoldedCells;
use self::disk::Disk;
use super::{Answer, Batch, Now, PairCounts, PairSource};
use crate::collision::convex::convex_parts;
use crate::collision::hierarchy::circle;
use crate::collision::pieces::Pieces;
use crate::collision::solids::Plates;
use crate::collision::sweep::QueryOutcome;
use crate::collision::sweep::motion::{Motion, Tick};
use crate::collision::tolerances::{APART_TIMES, MAX_OFFSETS, NEAREST_APART_TIMES, WAKE_TIMES};
use crate::folding::Pose;
use crate::lattice::{Lattice, NeighbourSearch, Orbit, PairClass};
use crate::pattern::{CreasePattern, FaceId};

/// A sheet that is folded by its lattice.
#[derive(Debug)]
pub(in crate::collision) struct LatticePairs<'a> {
    cells: FoldedCells<'a>,
    /// Largest distance of a face from its position by the lattice, units of the sheet.
    deviation: f64,
    median_edge: f64,
    /// For each orbit: number of pieces of a face (`counts`), and a circle round a face in reduced coordinates
    /// (`circles`).
    counts: Vec<u64>,
    circles: Vec<(Vector2<f64>, f64)>,
    /// These circles in space, for cell `[0, 0]` (`disks`), and the time for which they were computed (`centered`).
    disks: Vec<Disk>,
    centered: Tick,
    /// The plates, if panels have a thickness, and the form of each. Faces of one orbit differ in form where a side of one
    /// is the border of the sheet.
    plates: Option<(Arc<Plates>, Vec<u32>)>,
    /// For classes of plates that were asked for, the pairs that stand for them.
    represented: HashMap<PairClass, Vec<[FaceId; 2]>>,
    /// Distance up to which cells are looked at as long as no clearance is known.
    far: f64,
    /// Differences of cells woken so far, in order of waking (`offsets`) and sorted (`known`).
    offsets: Vec<Offset>,
    known: Vec<[i32; 2]>,
    all_awake: bool,
    /// For each row of differences, once requested: for each pair of orbits, the columns of differences that exist.
    columns: Vec<Option<Vec<RangeInclusive<i32>>>>,
}

/// A difference of two cells, which stands for the opposite difference too.
#[derive(Debug)]
struct Offset {
    cell: [i32; 2],
    /// Number of pairs of pieces.
    pairs: u64,
    /// Number of pairs of pieces that are not followed one by one.
    left: u64,
    /// A bit for each pair of orbits, set if the pair is followed one by one; empty as long as none is.
    taken: Vec<u64>,
}

/// Distances between two cells, over all pairs of faces that are not followed one by one.
struct Apart {
    /// Lower bound of the smallest distance.
    least: f64,
    /// Pairs of faces that may be too near to be represented by their cells.
    near: Vec<[FaceId; 2]>,
    /// Other pairs of faces that may be nearer than the nearest found so far.
    nearest: Vec<[FaceId; 2]>,
}

impl<'a> LatticePairs<'a> {
    /// Creates the pairs of cells of a lattice. Faces may be off the lattice by `deviation`. Cost: O(faces of a cell +
    /// cells along both steps), of plates O(faces).
    pub(in crate::collision) fn new(
        pattern: &CreasePattern,
        (memberships, groups): (&[Membership], usize),
        lattice: &'a Lattice,
        deviation: f64,
        plates: Option<&Arc<Plates>>,
    ) -> Self {
        let orbits = lattice.orbits();
        let count = |orbit: &Orbit| convex_parts(pattern, orbit.representative).len() as u64;
        let height = plates.map_or(0.0, |plates| plates.reach());
        let cells = FoldedCells::new(pattern, memberships, groups, (lattice, height));
        let forms = |plates: &Arc<Plates>| {
            let coords = lattice.coords().iter();
            let origins: Vec<_> = coords
                .map(|coord| lattice.translation(coord.cell))
                .collect();
            (plates.clone(), plates.forms(pattern, &origins))
        };
        let corners = |orbit| circle(cells.folded.corners(orbit));
        Self {
            deviation,
            median_edge: pattern.median_edge(),
            counts: orbits.iter().map(count).collect(),
            circles: (0..).take(orbits.len()).map(corners).collect(),
            disks: Vec::new(),
            plates: plates.map(forms),
            represented: HashMap::new(),
            centered: Tick::MAX,
            far: 0.0,
            offsets: Vec::new(),
            known: Vec::new(),
            all_awake: false,
            columns: vec![None; cells.most[1] as usize + 1],
            cells,
        }
    }

    /// Returns the least and largest differences between cells of two orbits, for each step.
    fn reach(&self, orbits: [usize; 2]) -> [[i32; 2]; 2] {
        let [a, b] = orbits.map(|orbit| &self.cells.lattice.orbits()[orbit]);
        [0, 1].map(|k| [b.low[k] - a.high[k], b.high[k] - a.low[k]])
    }

    /// Returns the number of pairs of pieces whose cells have this difference.
    fn pairs(&mut self, [column, row]: [i32; 2]) -> u64 {
        let orbits = self.counts.len();
        let within = [column, row] == [0, 0];
        let columns = columns(&mut self.columns, self.cells.lattice, row);
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
    fn wake(&mut self, motion: &Motion, time: Tick, near: f64) -> Option<Range<u32>> {
        let first = self.offsets.len();
        if !self.all_awake {
            self.cells.fold(motion, time);
            let FoldedCells {
                folded,
                bounds,
                most,
                lattice,
                ..
            } = &self.cells;
            let from = motion.tabulated(time).unwrap_or_default();
            let times = [from, (from + WAKE_TIMES).min(bounds.times() - 1)];
            let search = NeighbourSearch::new(folded, bounds, times, near, *most);
            let mut woken = match search {
                Some(search) => {
                    let mut cells = search.cells();
                    cells.retain(|cell| self.known.binary_search(cell).is_err());
                    cells.retain(|&cell| self.pairs(cell) > 0);
                    cells.retain(|&cell| {
                        self.cells.gap(cell) - self.cells.bounds.cells(times, cell) <= near
                    });
                    cells
                }
                None => {
                    self.all_awake = true;
                    lattice.offsets(MAX_OFFSETS)?
                }
            };
            let lattice = self.cells.lattice;
            let length = |cell: &[i32; 2]| lattice.translation(*cell).norm_squared();
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

    /// Wakes cells that come near each other soon.
    fn query_far(&mut self, now: &Now<'_>) -> Answer {
        let (motion, time, best) = (now.motion, now.time, now.found.best());
        // As long as no distance is known, cells within a growing distance are woken.
        if best == f64::INFINITY {
            self.far = 2.0 * self.far + self.median_edge / 2.0;
        }
        let near = self.deviation + now.contact.largest().max(self.far.min(best));
        let skips = now.options.skip_bounds && now.options.skip_motion;
        let near = if skips { near } else { f64::INFINITY };
        let Some(woken) = self.wake(motion, time, near) else {
            return Answer::new(QueryOutcome::Undecided);
        };
        let is_last = woken.is_empty() && (best.is_finite() || self.all_awake);
        let outcome = if !is_last {
            QueryOutcome::Again
        } else if time == motion.end() {
            QueryOutcome::Free
        } else {
            QueryOutcome::Until(motion.tabulated_after(time, WAKE_TIMES))
        };
        Answer {
            batches: woken.map(|offset| (Batch::Cells(offset), time)).collect(),
            ..Answer::new(outcome)
        }
    }

    /// Looks at two cells: names the pairs of faces that are too near to be represented by them, or else tells how long
    /// the cells stay apart.
    fn query_cells(&mut self, offset: u32, now: &Now<'_>) -> Answer {
        let (motion, time, best) = (now.motion, now.time, now.found.best());
        let (bounds, deviation) = (now.options.skip_bounds, self.deviation);
        let touching = now.contact.largest();
        self.cells.fold(motion, time);
        let cell = self.offsets[offset as usize].cell;
        let apart = self.cells.gap(cell);
        if bounds && apart > touching && apart >= best {
            let until = self.cells.until(motion, cell, apart - deviation);
            if until.map_or(time, |(until, _)| until) >= motion.tabulated_after(time, APART_TIMES) {
                return Answer {
                    skipped: self.offsets[offset as usize].left,
                    ..Answer::new(QueryOutcome::Apart(apart, until))
                };
            }
        }
        let near = if bounds {
            let leap = deviation + self.cells.moved(motion, APART_TIMES, cell);
            let far = deviation + self.cells.moved(motion, NEAREST_APART_TIMES, cell);
            leap.max(touching).max(far.min(best))
        } else {
            f64::INFINITY
        };
        let found = self.apart(offset, [near, best]);
        if !found.near.is_empty() {
            return Answer {
                faces: found.near,
                ..Answer::new(QueryOutcome::Again)
            };
        }
        let until = self.cells.until(motion, cell, found.least - deviation);
        Answer {
            measure: found.nearest,
            skipped: self.offsets[offset as usize].left,
            ..Answer::new(QueryOutcome::Apart(found.least, until))
        }
    }

    /// Bounds the distances between the faces of two cells. Pairs of faces no farther apart than `near` are
    /// followed one by one from now on, and pairs nearer than `best` are named.
    fn apart(&mut self, offset: u32, [near, best]: [f64; 2]) -> Apart {
        self.put_disks();
        let index = offset as usize;
        let cell = self.offsets[index].cell;
        let there = self.cells.translation(cell);
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
                    self.represent(class, &mut apart.nearest);
                }
                apart.least = apart.least.min(distance);
            }
        }
        apart
    }

    /// Places the circles round faces in space.
    fn put_disks(&mut self) {
        if self.centered == self.cells.time {
            return;
        }
        self.centered = self.cells.time;
        let height = self
            .plates
            .as_ref()
            .map_or(0.0, |(plates, _)| plates.reach());
        let disks = (0..)
            .zip(&self.circles)
            .map(|(orbit, &circle)| Disk::new(&self.cells.folded.pose(orbit), circle, height));
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
        let (pairs, before) = (self.counts[a] * self.counts[b], near.len());
        self.represent(class, near);
        if near.len() > before {
            let offset = &mut self.offsets[index];
            offset.left = offset.left.saturating_sub(pairs);
        }
    }

    /// Adds the pairs of faces that stand for all of a class: one or, of plates, one for each two forms.
    fn represent(&mut self, class: PairClass, pairs: &mut Vec<[FaceId; 2]>) {
        let lattice = self.cells.lattice;
        let Some((_, forms)) = &self.plates else {
            pairs.extend(lattice.pair_of(class));
            return;
        };
        let of_class = self.represented.entry(class).or_insert_with(|| {
            let mut seen = HashSet::new();
            let mut of_class: Vec<_> = lattice.pairs_of(class).collect();
            of_class.retain(|pair| seen.insert(pair.map(|face| forms[face.index()])));
            of_class
        });
        pairs.extend_from_slice(of_class);
    }
}

impl PairSource for LatticePairs<'_> {
    fn begin(&mut self, motion: &Motion, _: &Pieces) -> Option<(Batch, Vec<[u32; 2]>)> {
        self.centered = Tick::MAX;
        self.far = 0.0;
        self.offsets.clear();
        self.known.clear();
        self.all_awake = false;
        self.cells.begin(motion);
        Some((Batch::Far, Vec::new()))
    }

    fn query(&mut self, batch: Batch, now: &mut Now<'_>) -> Answer {
        match batch {
            Batch::Cells(offset) => self.query_cells(offset, now),
            Batch::Far | Batch::Interval => self.query_far(now),
        }
    }

    fn pose(&mut self, motion: &Motion, time: Tick, face: FaceId) -> Pose {
        self.cells.pose(motion, time, face)
    }

    fn until(
        &self,
        motion: &Motion,
        time: Tick,
        faces: [FaceId; 2],
        allowance: f64,
    ) -> Option<(Tick, f64)> {
        self.cells.until_of(motion, time, faces, allowance)
    }

    fn count(&self, _: &Pieces) -> PairCounts {
        let orbits = self.counts.len();
        let pieces = self.cells.lattice.coords().iter();
        let pieces: u64 = pieces.map(|coord| self.counts[coord.orbit as usize]).sum();
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
            pairs.sum::<u64>()
        };
        let all = pieces * pieces.saturating_sub(1) / 2;
        PairCounts {
            all,
            representative: pairs.min(all),
            joined: None,
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
