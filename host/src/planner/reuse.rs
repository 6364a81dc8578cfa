//! Reusing a path found on few unknowns on the whole sheet: knots are placed on it, and the whole motion is
//! certified and judged.

use std::time::Instant;

use foldpath_core::Membership;

use super::course::Course;
use super::follow::{Waypoint, max_difference};
use super::judge::Judge;
use super::knots::Knot;
use super::options::{Judged, Skips};
use super::place::{Placed, Terms, place};
use super::plan::{Outcome, Plan, Planning};
use super::reduction::{CLOSED, Reduction};
use crate::certificate::SheetCertifier;
use crate::collision::{Crossing, Sweep, SweepCounts, SweepOptions, SweepVerdict};
use crate::folding::{FoldingMap, Rigidity, SpanningTree};
use crate::numbers::larger;
use crate::progress::Stage;
use crate::symmetry::{Lattice, ReducedStars};

/// Knots of a path at most.
const MOST_KNOTS: usize = 20_000;
/// Deformation that the motion between knots is certified for where the bound allows more: what `check`
/// asks for by default.
const CERTIFIED: f64 = 1e-3;
/// Part of it that is aimed at first, as another route to a certificate may be less sharp.
pub(super) const FIRST_PART: f64 = 0.5;
/// Closure residual that the motion between knots that do not close may have, in the largest at a knot.
const NEAR: f64 = 1.25;
/// Knots that it may take, for each of the waypoints.
const MORE: usize = 4;
/// The least part aimed at.
const LEAST_PART: f64 = 5e-5;
/// Factor by which the motion is brought nearer to the course where it crosses and the course may not.
const NEARER: f64 = 0.01;
/// Radians by which a path may stop short of an inexact goal so that nothing crosses and all of it is proved.
const RETREAT: f64 = 0.02;
/// Radians that it then keeps from where faces meet.
const ROOM: f64 = 1e-3;
/// Faces beyond which the motion between knots is not swept without a lattice.
const MOST_FACES: usize = 4000;
/// Faces up to which a torn sheet is swept without its lattice at once: a motion nearer to its course would
/// have more knots.
const TORN_FACES: usize = 400;

/// A path to reuse.
pub(super) struct Found<'a> {
    /// From flat.
    pub(super) waypoints: &'a [Waypoint],
    /// Closure residual that counts as closed although it can be made no smaller.
    pub(super) accepted: f64,
    /// How much of the way to the goal it is.
    pub(super) reached: f64,
    /// Whether it may stop a little short of its end so that nothing crosses.
    pub(super) retreats: bool,
    /// Part of the bound that the motion between knots is certified for.
    pub(super) part: f64,
}

impl Planning<'_> {
    /// Reuses a path on the whole sheet and judges it there.
    pub(super) fn judge(mut self, reduction: &Reduction, found: &Found<'_>) -> Plan {
        self.plan.reached = found.reached;
        self.plan.waypoints = found.waypoints.len();
        if self.options.judged == Judged::Knots {
            return self.judge_knots(reduction, found);
        }
        let course = Course::new(found.waypoints);
        let Some(mut placed) = self.place(reduction, found, &course) else {
            self.plan.reached = 0.0;
            return self.unplaced();
        };
        let unproved = self.cut(reduction, found, &course, &mut placed);
        self.plan.path.interpolation = placed.interpolation;
        self.options.begin(Stage::Folding);
        if let Err(index) = self.measure(reduction, placed.knots) {
            return self.late_at(index);
        }
        if let Some(reason) = self.torn().or_else(|| self.torn_from_rim(reduction)) {
            return self.end(Outcome::NotRigidlyFoldable, reason);
        }
        let Some(reason) = unproved else {
            return self.judge_motion(reduction, found, &course);
        };
        // Its end is what is proved.
        let found = Found {
            retreats: false,
            part: LEAST_PART,
            ..*found
        };
        let mut plan = self.judge_motion(reduction, &found, &course);
        if plan.outcome == Outcome::Planned {
            (plan.outcome, plan.reason) = (Outcome::Partial, Some(reason));
        }
        plan
    }

    /// Looks for crossings, if asked to.
    fn judge_motion(self, reduction: &Reduction, found: &Found<'_>, course: &Course) -> Plan {
        if self.options.collision {
            self.sweep(reduction, found, course)
        } else {
            self.plan
        }
    }

    /// Ends a motion that closes at its knots, but is not proved to keep the bound, before the first segment that is not
    /// known to close well enough. Says why it does not reach the goal then; an inexact goal near its end is reached.
    fn cut(
        &mut self,
        reduction: &Reduction,
        found: &Found<'_>,
        course: &Course,
        placed: &mut Placed,
    ) -> Option<String> {
        let certified = self.uncertified()?;
        if !placed.cut() {
            return None;
        }
        self.certify(reduction, &reduction.all, placed);
        let end = &placed.knots.last()?.angles;
        self.plan.goal_error = reduction.distance(end, self.goal);
        let short = max_difference(end, &found.waypoints.last()?.angles);
        if found.retreats && short <= RETREAT {
            self.retreat(
                &format!("the motion is certified only to {certified:.1e}"),
                short,
            );
            return None;
        }
        self.plan.reached *= course.part(end);
        Some(format!(
            "as far as {:.1} % of the goal's angles: the motion found beyond closes where it was looked at, but between \
             is certified only to {certified:.1e}, over the bound of {:.1e}",
            100.0 * self.plan.reached,
            self.options.bound
        ))
    }

    /// Notes why the path ends these radians short of a goal that does not close.
    fn retreat(&mut self, why: &str, short: f64) {
        self.plan.notes.push(format!(
            "the goal itself does not close (residual {:.1e}), and near it {why}: the path ends {:.3} degrees before",
            self.plan.goal_closure,
            short.to_degrees(),
        ));
    }

    /// Places knots on the course, certified between them.
    fn place(
        &mut self,
        reduction: &Reduction,
        found: &Found<'_>,
        course: &Course,
    ) -> Option<Placed> {
        let start = Instant::now();
        self.options.begin(Stage::Placing);
        let stars = &reduction.essential;
        let placed = if most_open(stars, found) <= CLOSED {
            let aim = reduction.tolerance(self.options.bound.min(CERTIFIED) * found.part);
            let placed =
                self.place_to(reduction, found, course, (stars, Some(aim), self.most()))?;
            self.certify(reduction, &reduction.all, &placed);
            placed
        } else {
            self.place_roughly(reduction, found, course)?
        };
        self.plan.times.place += start.elapsed();
        Some(placed)
    }

    /// The same where waypoints do not close: between knots the motion is to close nearly as well. If that takes too many
    /// or leaves the bound unproved, no vertex stands for another; else all waypoints are knots.
    fn place_roughly(
        &mut self,
        reduction: &Reduction,
        found: &Found<'_>,
        course: &Course,
    ) -> Option<Placed> {
        let most = self.most();
        let few = most.min(MORE * found.waypoints.len());
        let mut near = |all: &ReducedStars, stars: &ReducedStars| {
            let terms = (stars, Some(NEAR * most_open(stars, found)), few);
            let placed = self.place_to(reduction, found, course, terms)?;
            self.certify(reduction, all, &placed);
            self.uncertified().is_none().then_some(placed)
        };
        let placed = near(&reduction.all, &reduction.essential);
        if placed.is_some() {
            return placed;
        }
        let apart = reduction.all.told_apart();
        let stars = apart.essential();
        let placed = near(&apart, &stars);
        if placed.is_some() {
            return placed;
        }
        let placed = self.place_to(reduction, found, course, (&stars, None, most))?;
        self.certify(reduction, &apart, &placed);
        Some(placed)
    }

    /// Places at most so many knots on the course, between which these stars close to within what is given with them.
    fn place_to(
        &self,
        reduction: &Reduction,
        found: &Found<'_>,
        course: &Course,
        (stars, closure, most): (&ReducedStars, Option<f64>, usize),
    ) -> Option<Placed> {
        let (_, signs) = reduction.asked(self.goal);
        let limits = reduction.orthant(&signs);
        let mut solver = reduction.solver(self.options, found.accepted);
        solver.set_limits(limits.clone());
        let terms = Terms {
            stars,
            closure,
            limits: &limits,
            speed: self.options.max_speed,
            acceleration: self.options.max_acceleration.unwrap_or(f64::INFINITY),
            most,
        };
        place(course, &terms, &mut solver, self.options)
    }

    /// Knots of a path at most.
    fn most(&self) -> usize {
        self.options.max_knots.unwrap_or(MOST_KNOTS)
    }

    /// No knots could be placed.
    fn unplaced(self) -> Plan {
        if self.is_late() {
            return self.end(Outcome::Timeout, "out of time while placing knots".into());
        }
        let most = self.most();
        let reason = format!("the bound needs more than {most} knots with this interpolation");
        self.end(Outcome::Partial, reason)
    }

    /// Takes the bounds on closure to bounds on the whole sheet, of which these are all stars.
    fn certify(&mut self, reduction: &Reduction, all: &ReducedStars, placed: &Placed) {
        let closure = placed.closure();
        let sheet = SheetCertifier::new(self.pattern, &reduction.tree, all);
        self.plan.certified_closure = sheet.as_ref().map(|sheet| sheet.closure(&closure));
        self.plan.certified_deformation = sheet.map(|mut sheet| {
            let bounds = sheet.rigidity(&closure);
            bounds.deformation.max(bounds.gap)
        });
    }

    /// What the sheet may deform or tear by for all that is proved, if that is over the bound.
    fn uncertified(&self) -> Option<f64> {
        let over = |certified: &f64| *certified > self.options.bound || certified.is_nan();
        self.plan.certified_deformation.filter(over)
    }

    /// Folds the sheet at knots, measures it there, and keeps them. `Err` says at which time ran out.
    pub(super) fn measure(
        &mut self,
        reduction: &Reduction,
        mut knots: Vec<Knot>,
    ) -> Result<(), usize> {
        let mut judge = Judge::new(self.pattern, reduction, false);
        judge.keep_vertices = self.options.keep_vertices;
        let count = knots.len();
        let late = knots.iter_mut().enumerate().find_map(|(index, knot)| {
            if self.is_late() {
                return Some(index);
            }
            if let Some(progress) = self.options.progress {
                progress.done(index, count);
            }
            judge.judge(knot);
            None
        });
        knots.truncate(late.unwrap_or(count));
        if late.is_none() {
            let angles = knots.iter().map(|knot| knot.angles.as_slice());
            (self.plan.essential_rigidity, self.plan.essential_faces) = judge.essential(angles);
        }
        self.plan.times.fold += judge.fold;
        self.keep(knots);
        late.map_or(Ok(()), Err)
    }

    /// Time ran out at a knot.
    pub(super) fn late_at(mut self, index: usize) -> Plan {
        self.plan.reached = 0.0;
        self.end(
            Outcome::Timeout,
            format!("out of time while judging knot {index}"),
        )
    }

    /// Keeps the knots, and what was measured at them.
    pub(super) fn keep(&mut self, knots: Vec<Knot>) {
        for knot in &knots {
            self.plan.rigidity = self.plan.rigidity.worse(Rigidity {
                deformation: knot.deformation,
                gap: knot.gap,
                twist: knot.closure,
            });
            self.plan.max_closure = self.plan.max_closure.max(knot.closure);
        }
        self.plan.path.knots = knots;
    }

    /// What the search for crossings is asked.
    fn sweep_options(&self) -> SweepOptions {
        let skips = self.options.skips;
        let certified = self.plan.certified_deformation.unwrap_or(0.0);
        let gap = certified.max(self.plan.rigidity.gap);
        let usual = SweepOptions::default();
        SweepOptions {
            gap,
            deadline: self.deadline,
            progress: self.options.progress,
            // Who wants to look at everything may.
            max_looks: if skips == Skips::default() {
                usual.max_looks
            } else {
                u64::MAX
            },
            skip_motion: skips.motion,
            skip_bounds: skips.bounds,
            skip_edges: skips.edges,
            ..usual
        }
    }

    /// The lattice along which to look for crossings, if there is one and it may be used.
    pub(super) fn lattice<'r>(&self, reduction: &'r Reduction) -> Option<&'r Lattice> {
        let used = self.options.skips.symmetry;
        used.then(|| reduction.lattice(self.pattern)).flatten()
    }

    /// Looks for crossings along the lattice, if the sheet is where that has it.
    fn sweep_lattice(
        &self,
        lattice: &Lattice,
        memberships: &[Membership],
        options: SweepOptions,
    ) -> Option<(SweepVerdict, SweepCounts)> {
        let torn = options.gap > SweepOptions::default().tolerance;
        let closure = self.plan.certified_closure.unwrap_or(f64::INFINITY);
        let astray = if torn {
            lattice.astray(self.pattern, closure)
        } else {
            0.0
        };
        let options = SweepOptions { astray, ..options };
        let mut sweep = (astray < SweepOptions::FAR_ASTRAY)
            .then(|| Sweep::with_lattice(self.pattern, memberships, options, lattice))?;
        let verdict = sweep.sweep(&self.plan.path.curves());
        let decided = match verdict {
            SweepVerdict::Free(_) => true,
            // Too many cells may meet: more than the pairs that do.
            SweepVerdict::Undecided { faces: None, .. } => false,
            // On a torn sheet what nearly touches by the lattice may not by the folding map.
            _ => !torn,
        };
        decided.then(|| (verdict, sweep.counts()))
    }

    /// Looks for crossings anywhere on the motion, and ends the path before the first.
    fn sweep(mut self, reduction: &Reduction, found: &Found<'_>, course: &Course) -> Plan {
        let mut start = Instant::now();
        self.options.begin(Stage::Crossings);
        let lattice = self.lattice(reduction);
        self.plan.times.symmetry += start.elapsed();
        start = Instant::now();
        let options = self.sweep_options();
        let memberships = reduction.groups.memberships();
        let along = lattice.and_then(|lattice| self.sweep_lattice(lattice, memberships, options));
        let (verdict, counts) = if let Some(found) = along {
            found
        } else {
            self.plan.times.collision += start.elapsed();
            let faces = self.pattern.faces().len();
            let torn = options.gap > SweepOptions::default().tolerance;
            if lattice.is_some()
                && torn
                && faces > TORN_FACES
                && let Some(plan) = self.nearer(reduction, found)
            {
                return plan;
            }
            if faces > MOST_FACES {
                return self.sweep_no_more_than_knots(reduction);
            }
            start = Instant::now();
            let mut sweep = Sweep::new(self.pattern, memberships, options);
            (sweep.sweep(&self.plan.path.curves()), sweep.counts())
        };
        self.plan.collision = counts;
        self.plan.times.collision += start.elapsed();
        match verdict {
            SweepVerdict::Free(clearance) => {
                if let Some((index, crossing)) = self.crossed_knot(reduction, options.gap) {
                    if let Some(plan) = self.nearer(reduction, found) {
                        return plan;
                    }
                    let before = index.checked_sub(1);
                    let crossed = Crossed {
                        crossing,
                        segment: before.unwrap_or(0),
                        free: before.map(|before| self.plan.path.knots[before].angles.clone()),
                    };
                    return self.crossed(reduction, found, course, crossed);
                }
                self.plan.clearance = clearance;
                self.plan
            }
            SweepVerdict::Undecided { .. } if self.is_late() => {
                self.plan.reached = 0.0;
                let reason = "out of time while looking for crossings".into();
                self.end(Outcome::Timeout, reason)
            }
            SweepVerdict::Undecided { faces: None, .. } => self.sweep_no_more_than_knots(reduction),
            SweepVerdict::Undecided { faces, at } => {
                let faces = faces.map_or(String::new(), |[a, b]| format!(" of faces {a} and {b}"));
                self.plan.notes.push(format!(
                    "crossings are not decided: the search gave up at the pair{faces} between knots {} \
                     and {}",
                    at.segment,
                    at.segment + 1
                ));
                self.plan
            }
            SweepVerdict::Crossing {
                crossing,
                last_free,
                ..
            } => {
                // A sheet that is torn by more crosses elsewhere than its course does.
                let torn = options.gap > SweepOptions::default().tolerance;
                let nearer = self.nearer(reduction, found);
                if let Some(plan) = nearer.filter(|plan| torn || plan.outcome == Outcome::Planned) {
                    return plan;
                }
                let curves = self.plan.path.curves();
                let free: Option<Vec<f64>> = last_free.map(|place| {
                    let curves = curves[place.segment].iter();
                    let rates = curves
                        .clone()
                        .map(|curve| curve.derivatives(place.s)[0].abs());
                    let fastest = rates.fold(f64::MIN_POSITIVE, f64::max);
                    let room = if found.retreats { ROOM / fastest } else { 0.0 };
                    let s = (place.s - room).max(0.0);
                    curves.map(|curve| curve.angle(s)).collect()
                });
                let segment = last_free.map_or(0, |place| place.segment);
                self.crossed(
                    reduction,
                    found,
                    course,
                    Crossed {
                        crossing,
                        segment,
                        free,
                    },
                )
            }
        }
    }

    /// The first knot at which faces cross, of a motion that may tear the sheet by `gap`. By as much faces round a
    /// vertex may lie across each other in it, but not at its knots, which are hardly torn.
    fn crossed_knot(&mut self, reduction: &Reduction, gap: f64) -> Option<(usize, Crossing)> {
        let torn = gap > SweepOptions::default().tolerance;
        if !torn || self.pattern.faces().len() > MOST_FACES {
            return None;
        }
        let start = Instant::now();
        let mut judge = Judge::new(self.pattern, reduction, false);
        let alike = self.plan.max_closure <= CLOSED;
        let crossed = judge.first_crossing(&self.plan.path.knots, alike);
        self.plan.times.collision += start.elapsed();
        crossed
    }

    /// Looks for crossings at the knots alone, and says so.
    fn sweep_no_more_than_knots(self, reduction: &Reduction) -> Plan {
        let faces = self.pattern.faces().len();
        let mut plan = self.sweep_knots(reduction, Instant::now());
        if plan.outcome == Outcome::Planned {
            plan.notes.push(format!(
                "crossings were looked for at knots only: too many faces ({faces}) for the motion between them"
            ));
        }
        plan
    }

    /// Looks for crossings at the knots alone, among all faces, since `start`.
    pub(super) fn sweep_knots(self, reduction: &Reduction, start: Instant) -> Plan {
        let mut judge = Judge::new(self.pattern, reduction, true);
        let plan = self.cross_at_knots(start, |knot| judge.crossing_at(knot));
        Plan {
            collision: judge.counts(),
            ..plan
        }
    }

    /// Ends the path before the first knot at which faces cross, begun to be looked for at `start`.
    pub(super) fn cross_at_knots(
        mut self,
        start: Instant,
        mut crossing_at: impl FnMut(&Knot) -> Option<Crossing>,
    ) -> Plan {
        let knots = core::mem::take(&mut self.plan.path.knots);
        // Flat faces lie beside each other.
        let turned = |(_, knot): &(usize, &Knot)| knot.angles.iter().any(|&angle| angle != 0.0);
        let found = knots
            .iter()
            .enumerate()
            .filter(turned)
            .find_map(|(index, knot)| {
                if self.is_late() {
                    return Some((index, None));
                }
                Some((index, Some(crossing_at(knot)?)))
            });
        self.plan.path.knots = knots;
        self.plan.times.collision += start.elapsed();
        match found {
            Some((index, Some(crossing))) => self.crossed_at(index, crossing),
            Some((index, None)) => self.late_at(index),
            None => self.plan,
        }
    }

    /// Ends the path before a knot at which faces cross.
    pub(super) fn crossed_at(mut self, index: usize, crossing: Crossing) -> Plan {
        let last = self.plan.path.knots.last().map_or(1.0, |last| last.time);
        let before = index
            .checked_sub(1)
            .map_or(0.0, |before| self.plan.path.knots[before].time);
        self.plan.reached *= before / last;
        self.plan.path.knots.truncate(index);
        let [a, b] = crossing.faces;
        let reason = format!("faces {a} and {b} pass through each other at knot {index}");
        self.end(Outcome::Crossing(crossing), reason)
    }

    /// The plan with the motion nearer to the course, unless it is as near as it gets or that decides nothing: where
    /// layers touch, what is off the course by what the bound allows may cross.
    fn nearer(&self, reduction: &Reduction, found: &Found<'_>) -> Option<Plan> {
        if found.part <= LEAST_PART || found.retreats {
            return None;
        }
        let mut planning = Planning {
            plan: self.plan.clone(),
            ..*self
        };
        planning.plan.rigidity = Rigidity::default();
        planning.plan.max_closure = 0.0;
        let nearer = Found {
            part: found.part * NEARER,
            ..*found
        };
        let plan = planning.judge(reduction, &nearer);
        matches!(plan.outcome, Outcome::Planned | Outcome::Crossing(_)).then_some(plan)
    }

    /// Ends the path before a crossing. An inexact goal near that is reached all the same; otherwise says
    /// why it is not.
    fn crossed(
        mut self,
        reduction: &Reduction,
        found: &Found<'_>,
        course: &Course,
        crossed: Crossed,
    ) -> Plan {
        let Crossed {
            crossing,
            segment,
            free,
        } = crossed;
        let [a, b] = crossing.faces;
        let part = free.as_ref().map_or(0.0, |free| course.part(free));
        let reason = format!(
            "faces {a} and {b} pass through each other beyond {:.2} % of the path (between knots {segment} \
             and {}: {:.1e} median edges deep)",
            100.0 * found.reached * part,
            segment + 1,
            crossing.depth / self.pattern.median_edge()
        );
        let goal = found.waypoints.last().map_or(&[][..], |last| &last.angles);
        let short = free
            .as_ref()
            .map_or(f64::INFINITY, |free| max_difference(free, goal));
        if let Some(free) = free.filter(|_| found.retreats && short <= RETREAT)
            && let Some(waypoints) =
                course.cut(&mut reduction.solver(self.options, found.accepted), free)
        {
            self.retreat(&reason, short);
            let end = waypoints.last().map_or(&[][..], |last| &last.angles);
            self.plan.goal_error = reduction.distance(end, self.goal);
            self.plan.rigidity = Rigidity::default();
            let shorter = Found {
                waypoints: &waypoints,
                retreats: false,
                ..*found
            };
            return self.judge(reduction, &shorter);
        }
        self.plan.reached = found.reached * part;
        self.plan.path.knots.truncate(segment + 1);
        self.end(Outcome::Crossing(crossing), reason)
    }

    /// Why the sheet does not keep the bound at its knots, or is not proved to between them, if so.
    pub(super) fn torn(&mut self) -> Option<String> {
        let bound = self.options.bound;
        let (whole, essential) = (self.plan.rigidity, self.plan.essential_rigidity);
        let within = |errors: [f64; 3]| errors.iter().all(|error| *error <= bound);
        if within([whole.deformation, whole.gap, self.plan.max_closure]) {
            let certified = self.uncertified()?;
            self.plan.reached = 0.0;
            return Some(format!(
                "the sheet keeps the bound at the knots, but between them it is certified only to {certified:.1e}, \
                 over the bound of {bound:.1e}"
            ));
        }
        let knots = &self.plan.path.knots;
        let holds = |knot: &&Knot| within([knot.deformation, knot.gap, knot.closure]);
        let good = knots.iter().take_while(holds).last();
        if let (Some(good), Some(last)) = (good, knots.last()) {
            self.plan.reached *= if last.time > 0.0 {
                good.time / last.time
            } else {
                0.0
            };
        }
        Some(format!(
            "the whole sheet deforms by {:.3e} with gaps of {:.3e} and closure {:.3e}, over the bound \
             {bound:.3e}; its essential crease pattern by {:.3e} with gaps of {:.3e}",
            whole.deformation,
            whole.gap,
            self.plan.max_closure,
            essential.deformation,
            essential.gap
        ))
    }

    /// Why the sheet does not keep the bound where it is folded from its rim, if so: there errors of vertices that do not
    /// close add up farther.
    fn torn_from_rim(&mut self, reduction: &Reduction) -> Option<String> {
        if self.plan.max_closure <= CLOSED {
            return None;
        }
        let start = Instant::now();
        let tree = SpanningTree::from_outer_face(self.pattern);
        let mut map = FoldingMap::flat(self.pattern);
        let curves = self.plan.path.curves();
        let shapes = curves.iter().flat_map(|curves| {
            PLACES.map(|s| curves.iter().map(|c| c.angle(s)).collect::<Vec<_>>())
        });
        let worst = shapes.fold(Rigidity::default(), |worst, angles| {
            map.fold_groups(self.pattern, &tree, reduction.groups.memberships(), &angles);
            worst.worse(map.rigidity(self.pattern, &tree))
        });
        self.plan.times.fold += start.elapsed();
        let bound = self.options.bound;
        if worst.deformation <= bound && worst.gap <= bound {
            return None;
        }
        self.plan.reached = 0.0;
        Some(format!(
            "folded from a face at its rim, the sheet deforms by {:.3e} with gaps of {:.3e}, over the bound {bound:.3e}",
            worst.deformation, worst.gap
        ))
    }
}

/// Places in each segment at which the sheet is folded from its rim.
const PLACES: [f64; 4] = [0.25, 0.5, 0.75, 1.0];

/// How badly these stars close at the worst of the waypoints.
fn most_open(stars: &ReducedStars, found: &Found<'_>) -> f64 {
    let waypoints = found.waypoints.iter();
    let open = waypoints.map(|waypoint| stars.largest_residual(&waypoint.angles));
    open.fold(0.0, larger)
}

/// Where a path has to end.
struct Crossed {
    crossing: Crossing,
    /// The segment it ends in.
    segment: usize,
    /// The last group angles free of crossings, if any are.
    free: Option<Vec<f64>>,
}
