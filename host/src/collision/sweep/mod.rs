//! Decides whether faces pass through each other anywhere on a motion, by conservative advancement.
//!
//! Conservative advancement (B. Mirtich, "Impulse-based dynamic simulation of rigid body systems", 1996, 2.3):
//! two faces at a distance need no query until they may have come so far. Differs from the source in the bound
//! on their motion. Between two faces lies a chain of creases. If one of the creases turns alone, points of the
//! faces approach each other by no more than the angle times the distance of either point from the crease. If
//! all creases turn one after the other, from the middle of the chain outwards, these are distances in the
//! sheet as it is now. So a pair is free until the sum over its chain of variation of angle times distance has
//! used up the pair's distance. This holds whatever the motion does in between, as long as the sheet closes.
//!
//! A sheet that does not quite close is folded along a spanning tree of its faces, and torn at the edges off the tree. A
//! tear is an isometry whose size the closure residuals bound (`Holonomy::tears`). It may be any such isometry at each
//! time, so that each tear along a chain uses up twice its size. If that is too much of the distance, the chain follows
//! the tree, along which nothing is torn.
//!
//! Two faces that share a vertex have distance 0, but they lie in sectors round the vertex, and cross only if the arcs
//! of the sectors on the unit sphere do. For these arcs the same bound holds with angles in place of distances.
//!
//! Pairs that share nothing pass a broad phase first, over one interval after the other: most are kept apart by a plane
//! (`pairs/interval_broad_phase`), and only the others are followed by conservative advancement, until the end of the
//! interval. If intervals would have to be too short, clusters of faces stand for all their pairs while they are far
//! apart. Two creases of a chain that turn by opposite angles about parallel lines count together, with the distance of
//! the lines as lever. The pairs of a sheet are shared by the threads (`followers`).

mod approach;
pub(super) mod chains;
mod clusters;
mod comoving_faces;
mod followers;
pub(super) mod motion;
mod pair_query;
mod queue;
mod sides;
mod stall;
mod touching;
mod variation;
mod verdict;
mod ways;

pub(super) use verdict::Found;
pub use verdict::{Clearance, Place, SweepCounts, SweepOptions, SweepVerdict};

use core::f64::consts::PI;
use std::sync::Arc;

use foldpath_core::{Curve, Membership};

use self::approach::Approach;
use self::comoving_faces::{ComovingNow, comoving_faces};
use self::followers::{Ending, Record};
use self::motion::{Motion, Tick};
use self::queue::{Kind, Queue};
use self::touching::Touch;
use super::hierarchy::Hierarchy;
use super::narrow::planes::Change;
use super::pairs::{Batch, LatticePairs, PairSource, SheetPairs};
use super::pieces::{Contact, Pieces};
use super::placed_pieces::PlacedPieces;
use super::scene::Crossing;
use super::solids::Plates;
use super::tolerances::{
    CROSSING_DEPTH_EDGES, LAST_FREE_TICKS, OVERTURNED_SEGMENTS, QUERIES_PER_CLOCK,
};
use crate::lattice::Lattice;
use crate::pattern::{CreasePattern, FaceId};
use crate::util::progress::Watch;

/// Outcome of a query of a pair.
pub(super) enum QueryOutcome {
    /// Free up to this time.
    Until(Tick),
    /// Free to the end of the motion.
    Free,
    /// Apart by a distance, and apart until a time with a bound on the approach until then; free if there is no such
    /// time.
    Apart(f64, Option<(Tick, f64)>),
    /// Crossing to this depth.
    Crossing(f64),
    /// Not decided: too near on a torn sheet, too many cells, or out of time.
    Undecided,
    /// To be replaced by other pairs, such as those of its parts.
    Split,
    /// To be queried again after the pairs taken from it.
    Again,
}

/// A sheet whose motions are swept for crossings.
#[derive(Debug)]
pub struct Sweep<'a> {
    pattern: &'a CreasePattern,
    memberships: &'a [Membership],
    groups: usize,
    options: SweepOptions,
    contact: Contact,
    watch: Watch<'a>,
    sheet: PlacedPieces<'a>,
    approach: Approach<'a>,
    comoving: ComovingNow,
    queue: Queue,
    found: Found,
    /// Smallest distance found before the current stretch.
    best: f64,
    /// `true` while the source of pairs names those that may meet over one interval after the other.
    broad_phase: bool,
    /// Others that follow pairs of the same sheet.
    helpers: Vec<Self>,
    /// Findings over the current stretch, one time after the other, and the end of the motion in it, if it has one.
    records: Vec<Record>,
    ending: Option<(Tick, Ending)>,
    /// `true` along a lattice. Faces may then be off their positions and orientations by up to `deviation`, units of the
    /// sheet, and `turn`, radians.
    along_lattice: bool,
    deviation: f64,
    turn: f64,
    /// Upper bound of the distance between any two points of the sheet; 0 along a lattice.
    length: f64,
    /// Room for the change of each group over a step.
    changes: Vec<Change>,
    /// Number of queries of pairs on this motion, their largest number, and their number by all followers over the last
    /// stretch.
    queries: u64,
    most_queries: u64,
    last_queries: usize,
}

impl<'a> Sweep<'a> {
    /// Creates the sweep of a sheet. `memberships` has the group and sign of each crease of the pattern; creases without
    /// one stay flat. If the sheet closes all along its motions, and a lattice was found for these memberships, one pair
    /// of faces stands for all that move alike. Cost: about O(faces log faces), with a lattice O(faces) with a small factor.
    #[must_use]
    pub fn new(
        pattern: &'a CreasePattern,
        memberships: &'a [Membership],
        options: SweepOptions,
        lattice: Option<&'a Lattice>,
    ) -> Self {
        Self::of_plates(pattern, memberships, options, lattice, None)
    }

    /// Creates the sweep of a sheet whose panels are plates, if there are some, and otherwise that of faces without a
    /// thickness.
    pub(super) fn of_plates(
        pattern: &'a CreasePattern,
        memberships: &'a [Membership],
        options: SweepOptions,
        lattice: Option<&'a Lattice>,
        plates: Option<&Arc<Plates>>,
    ) -> Self {
        let groups = memberships.iter().map(|m| m.group.index() + 1);
        let groups = groups.max().unwrap_or_default();
        let along_lattice = lattice.is_some();
        // Along a lattice, pieces are made when they are requested.
        let (pieces, hierarchy) = if along_lattice {
            let pieces = Pieces::none(pattern, plates);
            let hierarchy = Hierarchy::leaves(&pieces);
            (pieces, hierarchy)
        } else {
            let pieces = Pieces::new(pattern, plates);
            let hierarchy = Hierarchy::new(&pieces);
            (pieces, hierarchy)
        };
        let deviation = options.lattice_deviation * pattern.median_edge();
        let hinges = (memberships, groups);
        let source: Box<dyn PairSource + 'a> = match lattice {
            Some(lattice) => Box::new(LatticePairs::new(
                pattern, hinges, lattice, deviation, plates,
            )),
            None => Box::new(SheetPairs::new(pattern, hinges, &options)),
        };
        let closure = (!along_lattice).then_some(options.closure);
        let length = closure.map_or(0.0, |_| {
            2.0 * (pattern.tree().reach(pattern) + pieces.height())
        });
        let closes_within = options.closure_as_contact * options.closure;
        let loose = closes_within * length + options.left_out * pattern.median_edge();
        Self {
            pattern,
            memberships,
            groups,
            contact: Contact::new(pattern.median_edge(), options.contact).loosely(loose),
            watch: Watch::default(),
            approach: Approach::new(pattern, hinges, &hierarchy, closure, pieces.beyond()),
            sheet: PlacedPieces::new(pattern, (pieces, hierarchy), source, along_lattice),
            comoving: ComovingNow::default(),
            queue: Queue::default(),
            found: Found::default(),
            best: f64::INFINITY,
            broad_phase: false,
            helpers: Vec::new(),
            records: Vec::new(),
            ending: None,
            along_lattice,
            deviation: if along_lattice { deviation } else { 0.0 },
            turn: if along_lattice {
                options.lattice_turn
            } else {
                0.0
            },
            length,
            changes: vec![Change { by: 0.0, off: 0.0 }; groups],
            queries: 0,
            most_queries: 0,
            last_queries: 0,
            options,
        }
    }

    /// Reports how much of the motion is free, and answers [`SweepVerdict::Undecided`] once the call is over.
    #[must_use]
    pub fn watched(self, watch: Watch<'a>) -> Self {
        Self { watch, ..self }
    }

    /// Returns the numbers of pairs tested and skipped since the sweep was created.
    #[must_use]
    pub fn counts(&self) -> SweepCounts {
        self.found.counts
    }

    /// Sweeps a motion, given a curve for each crease group in each segment.
    pub fn sweep(&mut self, segments: &[Vec<Curve<f64>>]) -> SweepVerdict {
        let motion = Motion::new(segments, self.groups);
        if !motion.is_finite() {
            let at = motion.place(0);
            return SweepVerdict::Undecided { faces: None, at };
        }
        let before = self.found.counts;
        self.found.joined = 0;
        let first = self.begin(Arc::new(motion));
        let touching = self.add_first(first);
        let mut times = 0;
        let verdict = self.follow_all(touching, &mut times);
        let pairs = self.sheet.source.count(&self.sheet.pieces);
        self.found.complete(times, &before, &pairs, &self.options);
        match self.overturned() {
            Some((at, overturned)) if at.is_before(&verdict) => overturned,
            _ => verdict,
        }
    }

    /// Goes to the beginning of a motion. Returns what the source of pairs asks for there.
    fn begin(&mut self, motion: Arc<Motion>) -> Option<(Batch, Vec<[u32; 2]>)> {
        self.found.clearance = None;
        self.queries = 0;
        self.queue = Queue::default();
        self.approach.begin();
        self.comoving.begin();
        self.sheet.begin(motion)
    }

    /// Adds the pairs that are due at the beginning of a motion. Returns those that followers share.
    fn add_first(&mut self, first: Option<(Batch, Vec<[u32; 2]>)>) -> Vec<[u32; 2]> {
        self.broad_phase = matches!(first, Some((Batch::Interval, _)));
        match first {
            Some((Batch::Interval, touching)) => return touching,
            Some((batch, pairs)) => {
                self.add_batch(batch, 0);
                for pair in pairs {
                    self.add(pair, 0);
                }
            }
            None => {
                self.enter(0);
                self.add_root(0);
            }
        }
        Vec::new()
    }

    /// Returns the first place at which a hinge turns past half a turn: the faces that it joins then pass
    /// through each other.
    fn overturned(&self) -> Option<(Place, SweepVerdict)> {
        let (segment, s, group, angle) = self.sheet.motion.overturned(CROSSING_DEPTH_EDGES)?;
        let at = Place { segment, s };
        let creases = self.pattern.creases().iter().zip(self.memberships);
        let edges = creases.filter(|(_, member)| member.group.index() == group);
        let mut edges = edges.map(|(&edge, _)| self.pattern.edge(edge));
        let (edge, faces) = edges.find_map(|edge| Some((edge, edge.inner_faces()?)))?;
        let [from, to] = edge.ends.map(|end| self.pattern.vertices()[end.index()]);
        let width = |face: FaceId| {
            let corners = self.pattern.faces()[face.index()].iter();
            let corners = corners.map(|v| self.pattern.vertices()[v.index()] - from);
            let away = corners.map(|corner| corner.perp(&(to - from)).abs());
            away.fold(0.0, f64::max) / (to - from).norm()
        };
        let depth = (angle.abs() - PI).sin().abs() * width(faces[0]).min(width(faces[1]));
        Some((
            at,
            SweepVerdict::Crossing {
                crossing: Crossing::new(faces, depth),
                at,
                last_free: (segment > 0 || s > 0.0).then_some(Place {
                    segment,
                    s: (s - OVERTURNED_SEGMENTS).max(0.0),
                }),
            },
        ))
    }

    /// Queries all pairs that are due. Returns what ends the motion here.
    fn query_all(&mut self, time: Tick, mut due: Vec<u32>) -> Option<Ending> {
        self.enter(time);
        let mut ending: Option<Ending> = None;
        let mut end = |new: Ending| {
            if ending.as_ref().is_none_or(|old| new.precedes(old)) {
                ending = Some(new);
            }
        };
        while let Some(index) = due.pop() {
            if self.is_over() {
                end(self.undecided(index));
                break;
            }
            let crosses = self.queue[index].stall.crosses;
            if crosses.is_some_and(|at| time < at) {
                continue;
            }
            let outcome = self.query(index);
            if crosses.is_some() && !matches!(outcome, QueryOutcome::Crossing(_)) {
                end(self.undecided(index));
                continue;
            }
            match outcome {
                QueryOutcome::Free | QueryOutcome::Apart(..) => {}
                QueryOutcome::Until(later) => {
                    let Some(later) = self.past_stall(index, later) else {
                        end(self.undecided(index));
                        continue;
                    };
                    let pair = &mut self.queue[index];
                    pair.last = Some(time);
                    if later < pair.end || pair.stall.crosses.is_some() {
                        self.queue.put(index, later);
                    }
                }
                QueryOutcome::Again => {
                    due.push(index);
                    due.extend(self.queue.due_at(time));
                }
                QueryOutcome::Undecided => end(self.undecided(index)),
                // An overlap of solids of which not all facets are known proves nothing.
                QueryOutcome::Crossing(_)
                    if !self.sheet.placed().are_exact(self.queue[index].nodes) =>
                {
                    let found = self.certain_ahead(index).map(Ending::Certain);
                    end(found.unwrap_or_else(|| self.undecided(index)));
                }
                QueryOutcome::Split => {
                    self.split(index, time);
                    due.extend(self.queue.due_at(time));
                }
                QueryOutcome::Crossing(depth) => {
                    let crossing = Crossing::new(self.faces(index), depth);
                    end(Ending::Crosses(crossing, index));
                }
            }
        }
        ending
    }

    /// Goes to a time. At the beginning of another segment, makes chains cross few creases that turn. Finds the comoving
    /// faces from this time on.
    fn enter(&mut self, time: Tick) {
        self.sheet.time = time;
        if self.along_lattice {
            return;
        }
        let motion = self.sheet.motion.clone();
        if let Some(segment) = self.comoving.entered(&motion, time) {
            self.approach.keep_still(motion.still(segment));
        }
        let lengths = [self.length, self.contact.base()];
        let (ways, sheet) = (&self.approach.chains.ways, &mut self.sheet);
        let find = |times: [Tick; 2]| {
            sheet.time = times[0];
            comoving_faces(
                self.pattern,
                self.memberships,
                (&motion, times),
                &ways.still,
                |edge| ways.tear(edge),
                |crease| sheet.axis(crease),
                lengths,
            )
        };
        let some_are_still = !ways.still.is_empty();
        self.comoving
            .enter(&motion, time, some_are_still.then_some(find));
        self.sheet.time = time;
    }

    fn undecided(&self, index: u32) -> Ending {
        let one = !matches!(self.queue[index].kind, Kind::Batch(Batch::Far));
        Ending::Undecided(one.then(|| self.faces(index)))
    }

    fn is_over(&mut self) -> bool {
        self.queries += 1;
        self.queries % QUERIES_PER_CLOCK == 1 && self.watch.is_over()
    }

    fn faces(&self, pair: u32) -> [FaceId; 2] {
        self.sheet.faces(self.queue[pair].nodes)
    }

    /// Returns the verdict on a crossing found at a time; the place is narrowed down by bisection from the last
    /// query of the pair.
    fn first(&mut self, found: Crossing, index: u32, time: Tick) -> SweepVerdict {
        let pair = self.queue[index].clone();
        let (mut crossing, mut high) = (found, time);
        let mut low = pair.last;
        while let Some(free) = low
            && high - free > LAST_FREE_TICKS
        {
            self.sheet.time = (free + high) / 2;
            self.sheet.put(pair.nodes);
            let time = self.sheet.time;
            match self.touch(&pair, 0.0) {
                Touch::Crosses(depth) | Touch::Through(depth) => {
                    (crossing, high) = (Crossing::new(found.faces, depth), time);
                }
                Touch::Flat | Touch::Nowhere => low = Some(time),
            }
        }
        SweepVerdict::Crossing {
            crossing,
            at: self.sheet.motion.place(high),
            last_free: low.map(|low| self.sheet.motion.place(low)),
        }
    }
}
