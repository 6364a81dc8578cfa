//! Lifts a path found on few unknowns to the whole sheet: places knots on it, and certifies and judges the whole
//! motion.

use std::time::Instant;

use foldpath_core::Curve;

use super::course::Course;
use super::follow::Waypoint;
use super::judge::Judge;
use super::knots::{Knot, Path, curves};
use super::options::Judged;
use super::place::{Folded, Placed, Terms, place};
use super::plan::{Outcome, Plan, Planning};
use super::reduction::{CLOSED, Reduction};
use crate::certificate::{FoldingCertifier, SheetCertifier};
use crate::folding::{FoldingMap, Rigidity, SpanningTree};
use crate::progress::Stage;
use crate::symmetry::ReducedStars;
use crate::util::nan_max::larger;

/// Largest number of knots of a path.
const MOST_KNOTS: usize = 20_000;
/// Deformation for which the motion between knots is certified if the bound allows more, as a fraction: the default
/// bound of `check`.
pub(super) const CERTIFIED: f64 = 1e-3;
/// Fraction of the certified deformation that is aimed for at first, as another method of certification may be less
/// sharp.
pub(super) const FIRST_PART: f64 = 0.5;
/// Largest closure residual between knots, in multiples of the largest at a waypoint, if waypoints do not close.
const NEAR: f64 = 1.25;
/// Largest number of knots for each waypoint on such a motion.
const MORE: usize = 4;
/// Smallest fraction of the certified deformation that is aimed for.
pub(super) const LEAST_PART: f64 = 5e-5;
/// Points of each segment at which the sheet is folded from its rim, as fractions of the segment.
const PLACES: [f64; 4] = [0.25, 0.5, 0.75, 1.0];

/// A path that is found but not yet certified.
pub(super) struct Found<'a> {
    /// Waypoints, from flat.
    pub(super) waypoints: &'a [Waypoint],
    /// Closure residual up to which a local minimum counts as closed.
    pub(super) accepted: f64,
    /// Fraction of the way to the goal that the path goes.
    pub(super) reached: f64,
    /// `true` if the path may stop a little before its end so that nothing crosses.
    pub(super) retreats: bool,
    /// Fraction of the bound for which the motion between knots is certified.
    pub(super) part: f64,
    /// Path that was placed for a larger fraction, and whose sweep did not find it free of crossings.
    pub(super) before: Option<&'a Path>,
}

/// Stars, the largest closure residual between knots, the largest number of knots, and bounds on the whole sheet.
type Between<'a> = (&'a ReducedStars, Option<f64>, usize, Option<Folded<'a>>);

impl Planning<'_> {
    /// Lifts a path to the whole sheet and judges it there.
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
        let unproved = self.cut(reduction, &course, &mut placed);
        self.plan.path.interpolation = placed.interpolation;
        self.watch.begin(Stage::Folding);
        if let Err(index) = self.measure(reduction, placed.knots) {
            return self.late_at(index);
        }
        if let Some(reason) = self.torn().or_else(|| self.torn_from_rim(reduction)) {
            return self.end(Outcome::NotRigidlyFoldable, reason);
        }
        let Some(reason) = unproved else {
            return self.judge_motion(reduction, found, &course);
        };
        // The path ends where its proof ends, so that it is neither shortened nor brought nearer to its course.
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

    /// Looks for crossings along the motion, if asked to.
    fn judge_motion(self, reduction: &Reduction, found: &Found<'_>, course: &Course) -> Plan {
        if !self.options.collision {
            return self.plan;
        }
        if found.before != Some(&self.plan.path) {
            return self.sweep(reduction, found, course);
        }
        let nearer = self.nearer(reduction, found);
        nearer.unwrap_or_else(|| self.end(Outcome::Partial, "no other motion leads on".into()))
    }

    /// Ends a motion that closes at its knots, but is not proved to keep the bound, before the first segment that is
    /// not known to close well enough. Returns the reason why the motion then does not reach the goal.
    fn cut(
        &mut self,
        reduction: &Reduction,
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
        self.plan.reached *= course.part(end);
        Some(format!(
            "as far as {:.1} % of the goal's angles: the motion found beyond closes where it was looked at, but between \
             is certified only to {certified:.1e}, over the bound of {:.1e}",
            100.0 * self.plan.reached,
            self.options.bound
        ))
    }

    /// Places knots on the course, certified between them.
    fn place(
        &mut self,
        reduction: &Reduction,
        found: &Found<'_>,
        course: &Course,
    ) -> Option<Placed> {
        let start = Instant::now();
        self.watch.begin(Stage::Placing);
        let aim = reduction.tolerance(self.options.bound.min(CERTIFIED) * found.part);
        let open = most_open(&reduction.essential, found);
        let placed = if self.measured {
            self.place_measured(reduction, found, course)
        } else if open <= CLOSED {
            self.place_closed(reduction, found, course, aim)
        } else {
            let nearly = open <= aim / NEAR;
            let closed = nearly.then(|| self.place_closed(reduction, found, course, aim));
            let proved = closed.flatten().filter(|_| self.uncertified().is_none());
            proved.or_else(|| self.place_roughly(reduction, found, course))
        }?;
        self.plan.times.place += start.elapsed();
        Some(placed)
    }

    /// Places knots if the waypoints close: between knots the motion has to close to within `aim`.
    fn place_closed(
        &mut self,
        reduction: &Reduction,
        found: &Found<'_>,
        course: &Course,
        aim: f64,
    ) -> Option<Placed> {
        let terms = (&reduction.essential, Some(aim), self.most(), None);
        let placed = self.place_to(reduction, found, course, terms)?;
        self.certify(reduction, &reduction.all, &placed);
        Some(placed)
    }

    /// Places knots if the waypoints do not close: between knots the motion has to close nearly as well as at them.
    ///
    /// If this takes too many knots or leaves the bound unproved, it is repeated with no vertex standing for another;
    /// if that fails too, all waypoints become knots. Only if none of these is proved by the worst-case sum of the
    /// vertices' errors is the actual sum bounded, by folding the sheet.
    fn place_roughly(
        &mut self,
        reduction: &Reduction,
        found: &Found<'_>,
        course: &Course,
    ) -> Option<Placed> {
        let most = self.most();
        let few = most.min(MORE * found.waypoints.len());
        let mut near = |all: &ReducedStars, stars: &ReducedStars| {
            let terms = (stars, Some(NEAR * most_open(stars, found)), few, None);
            let placed = self.place_to(reduction, found, course, terms)?;
            Some((self.adds_up(reduction, all, &placed), placed))
        };
        let together = near(&reduction.all, &reduction.essential);
        if let Some((true, placed)) = together {
            return Some(placed);
        }
        let apart = reduction.all.unmerged();
        let stars = apart.essential();
        if let Some((true, placed)) = near(&apart, &stars) {
            return Some(placed);
        }
        let every = self.place_to(reduction, found, course, (&stars, None, most, None));
        if let Some(placed) = &every
            && self.adds_up(reduction, &apart, placed)
        {
            return every;
        }
        if let Some((_, placed)) = together
            && self.certify(reduction, &reduction.all, &placed)
        {
            return Some(placed);
        }
        let every = every?;
        self.certify(reduction, &apart, &every);
        Some(every)
    }

    /// Places knots if the sum of the vertices' errors is measured: between waypoints the sheet may deform hardly more
    /// than at them, or as much as is aimed for, within the bound.
    fn place_measured(
        &mut self,
        reduction: &Reduction,
        found: &Found<'_>,
        course: &Course,
    ) -> Option<Placed> {
        let memberships = reduction.groups.memberships();
        let mut certifier = FoldingCertifier::new(self.pattern, memberships);
        let bound = self.options.bound;
        let mut aim = bound.min(CERTIFIED) * found.part;
        for waypoint in found.waypoints {
            let still: Vec<_> = waypoint
                .angles
                .iter()
                .map(|&a| Curve::Angle([a; 4]))
                .collect();
            let here = certifier.rigidity(&still, bound)?;
            aim = larger(aim, NEAR * here.worst()).min(bound);
            if self.is_late() {
                return None;
            }
        }
        let folded = Folded {
            certifier,
            aim,
            bound,
        };
        let terms = (&reduction.essential, Some(aim), self.most(), Some(folded));
        let placed = self.place_to(reduction, found, course, terms)?;
        self.certify(reduction, &reduction.all, &placed);
        Some(placed)
    }

    /// Places at most `most` knots on the course, between which these stars close to within `closure` and the whole
    /// sheet keeps `folded`, if these are given.
    fn place_to(
        &self,
        reduction: &Reduction,
        found: &Found<'_>,
        course: &Course,
        (stars, closure, most, folded): Between<'_>,
    ) -> Option<Placed> {
        let (_, signs) = reduction.asked(self.goal);
        let limits = reduction.orthant(&signs);
        let mut solver = reduction.solver(self.options, found.accepted);
        solver.set_limits(limits.clone());
        let terms = Terms {
            stars,
            closure,
            folded,
            limits: &limits,
            speed: self.options.max_speed,
            acceleration: self.options.max_acceleration.unwrap_or(f64::INFINITY),
            most,
        };
        place(course, &terms, &mut solver, self.options)
    }

    /// Returns the largest number of knots of a path.
    fn most(&self) -> usize {
        self.options.max_knots.unwrap_or(MOST_KNOTS)
    }

    /// Ends the plan because no knots could be placed.
    fn unplaced(self) -> Plan {
        if self.is_late() {
            return self.end(Outcome::Timeout, "out of time while placing knots".into());
        }
        let most = self.most();
        let reason = format!("the bound needs more than {most} knots with this interpolation");
        self.end(Outcome::Partial, reason)
    }

    /// Turns the closure bound of every vertex into worst-case bounds on the whole sheet, and stores these in the plan;
    /// `all` are the stars of all vertices. Returns `true` if deformation and gap are within `options.bound`.
    fn adds_up(&mut self, reduction: &Reduction, all: &ReducedStars, placed: &Placed) -> bool {
        let closure = placed.closure();
        let sheet = SheetCertifier::new(self.pattern, &reduction.tree, all);
        self.plan.certified_closure = sheet.as_ref().map(|sheet| sheet.closure(&closure));
        let bounds = sheet.map(|mut sheet| sheet.rigidity(&closure));
        let known = bounds.map(|bounds| bounds.deformation.max(bounds.gap));
        self.plan.certified_deformation = known.or(Some(f64::INFINITY));
        self.uncertified().is_none()
    }

    /// Certifies as [`adds_up`](Self::adds_up) does. If the worst case is over the bound, bounds the sheet itself,
    /// folded from its middle and from its rim. Returns `true` if one of the two is within the bound.
    fn certify(&mut self, reduction: &Reduction, all: &ReducedStars, placed: &Placed) -> bool {
        if self.adds_up(reduction, all, placed) {
            return true;
        }
        let folded = self.folded(reduction, placed);
        self.plan.certified_deformation = folded.or(self.plan.certified_deformation);
        folded.is_some()
    }

    /// Returns a bound on deformation and gap of the sheet folded from its middle and from its rim, if that is within
    /// the bound and found in time.
    fn folded(&self, reduction: &Reduction, placed: &Placed) -> Option<f64> {
        let memberships = reduction.groups.memberships();
        let mut certifier = FoldingCertifier::new(self.pattern, memberships);
        let mut worst = 0.0;
        for curves in curves(placed.interpolation, &placed.knots) {
            if self.is_late() {
                return None;
            }
            let bounds = certifier.rigidity(&curves, self.options.bound)?;
            worst = larger(worst, bounds.worst());
        }
        Some(worst)
    }

    /// Returns the certified deformation if it is over the bound.
    fn uncertified(&self) -> Option<f64> {
        let over = |certified: &f64| *certified > self.options.bound || certified.is_nan();
        self.plan.certified_deformation.filter(over)
    }

    /// Folds the sheet at knots, measures it there, and keeps the knots. `Err` is the number of the knot at which time
    /// ran out.
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
            self.watch.done(index, count);
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

    /// Ends the plan because time ran out at a knot.
    pub(super) fn late_at(mut self, index: usize) -> Plan {
        self.plan.reached = 0.0;
        self.end(
            Outcome::Timeout,
            format!("out of time while judging knot {index}"),
        )
    }

    /// Stores the knots in the plan, and the largest errors measured at them.
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

    /// Returns a reason if the sheet breaks the bound at its knots, or is not proved to keep the bound between them.
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

    /// Returns a reason if the sheet breaks the bound when it is folded from its rim. From there, errors of vertices
    /// that do not close add up over a longer way.
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

/// Returns the largest residual of these stars over all waypoints.
fn most_open(stars: &ReducedStars, found: &Found<'_>) -> f64 {
    let waypoints = found.waypoints.iter();
    let open = waypoints.map(|waypoint| stars.largest_residual(&waypoint.angles));
    open.fold(0.0, larger)
}
