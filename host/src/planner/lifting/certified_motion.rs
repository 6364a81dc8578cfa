//! From the reduced path to a certified motion: places knots on the path, and bounds deformation and gap of the whole
//! sheet between them.

use foldpath_core::Curve;

use crate::certificate::{FoldingCertifier, SheetCertifier};
use crate::collision::CROSSING_DEPTH_EDGES;
use crate::planner::following::follow::Waypoint;
use crate::planner::following::reduction::{CLOSED, ROUNDING_RESIDUAL, Reduction};
use crate::planner::knots::KnotSequence;
use crate::planner::placement::knot_placement::place;
use crate::planner::placement::knot_placer::{PlacementConstraints, SheetBounds};
use crate::planner::placement::reduced_path::ReducedPath;
use crate::planner::plan::Certificate;
use crate::planner::problem::PlanningProblem;
use crate::symmetry::ReducedStars;
use crate::util::nan_max::larger;

/// Largest number of knots of a path.
const MAX_KNOTS: usize = 20_000;
/// Deformation for which the motion between knots is certified if the bound allows more, as a fraction of lengths: the
/// default bound of `check`.
pub(crate) const CERTIFIED_DEFORMATION: f64 = 1e-3;
/// Largest closure residual between knots, in multiples of the largest at a waypoint, if waypoints do not close.
const RESIDUAL_RATIO: f64 = 1.25;
/// Largest number of knots for each waypoint on such a motion.
const KNOTS_PER_WAYPOINT: usize = 4;

/// Knots that were placed, and what is proved of the motion.
#[derive(Default)]
pub(crate) struct Placement {
    /// The knots; `None` if none could be placed.
    pub(crate) knots: Option<KnotSequence>,
    /// Bounds on the motion with these knots; without knots, those on the motion that was tried last, if one was.
    pub(crate) certificate: Option<Certificate>,
}

impl Placement {
    fn new(knots: KnotSequence, certificate: Certificate) -> Self {
        Self {
            knots: Some(knots),
            certificate: Some(certificate),
        }
    }

    /// Returns `true` if the motion is proved to keep a bound.
    fn keeps(&self, bound: f64) -> bool {
        self.knots.is_some() && self.certificate.is_some_and(|c| c.over(bound).is_none())
    }

    /// Returns this placement, with the bounds of another one if it has none.
    fn or_bounds_of(self, other: &Self) -> Self {
        Self {
            certificate: self.certificate.or(other.certificate),
            ..self
        }
    }
}

/// A path that is found but not yet certified, to be lifted to the whole sheet.
pub(crate) struct Lifting<'a> {
    pub(crate) problem: &'a PlanningProblem<'a>,
    pub(crate) reduction: &'a Reduction<'a>,
    /// Waypoints, from flat.
    pub(crate) waypoints: &'a [Waypoint],
    /// The waypoints as geometry.
    pub(crate) path: ReducedPath,
    /// Closure residual up to which a local minimum counts as closed.
    pub(crate) closure_tolerance: f64,
    /// Fraction of the way to the goal that the path goes.
    pub(crate) reached: f64,
    /// Closure residual of the goal as asked, if the path may stop a little before it so that nothing crosses.
    pub(crate) open_goal: Option<f64>,
    /// Largest closure residual over the knots of the motion that this one is a part of; 0 if there is none.
    pub(crate) min_closure: f64,
}

impl<'a> Lifting<'a> {
    /// Makes the lifting of a path that leads to a goal which closes.
    pub(crate) fn new(
        problem: &'a PlanningProblem<'a>,
        reduction: &'a Reduction<'a>,
        waypoints: &'a [Waypoint],
        closure_tolerance: f64,
    ) -> Self {
        Self {
            problem,
            reduction,
            waypoints,
            path: ReducedPath::new(waypoints),
            closure_tolerance,
            reached: 1.0,
            open_goal: None,
            min_closure: 0.0,
        }
    }

    /// Places knots on the path, certified between them for a fraction of the bound.
    pub(crate) fn place_knots(&self, bound_fraction: f64) -> Placement {
        let (problem, reduction) = (self.problem, self.reduction);
        let closure = self.closure_for(bound_fraction);
        let open = self.max_residual(&reduction.essential);
        if problem.errors.is_measured() {
            self.measured(self.aim(bound_fraction)).unwrap_or_default()
        } else if open <= CLOSED {
            let kept = self.closure_of_plates().filter(|kept| *kept < closure);
            let closed = kept.and_then(|kept| self.closed(kept));
            let closed = closed.or_else(|| self.closed(closure));
            closed.unwrap_or_default()
        } else {
            let nearly = open <= closure / RESIDUAL_RATIO;
            let closed = nearly.then(|| self.closed(closure)).flatten();
            let closed = closed.unwrap_or_default();
            if closed.keeps(problem.options.bound) {
                closed
            } else {
                self.nearly_closed().or_bounds_of(&closed)
            }
        }
    }

    /// Returns the deformation that is aimed for between knots, for a fraction of the bound.
    fn aim(&self, bound_fraction: f64) -> f64 {
        self.problem.options.bound.min(CERTIFIED_DEFORMATION) * bound_fraction
    }

    /// Returns the closure residual that vertices may reach between knots, for a fraction of the bound.
    pub(crate) fn closure_for(&self, bound_fraction: f64) -> f64 {
        self.reduction.tolerance(self.aim(bound_fraction))
    }

    /// Returns the closure residual within which plates keep to the lattice so nearly that it tells whether they cross, if they
    /// have one: neighbours touch at each hinge, so that no tear leaves them apart.
    fn closure_of_plates(&self) -> Option<f64> {
        let pattern = self.problem.pattern;
        self.problem.options.plates.as_ref()?;
        let lattice = self.reduction.lattice(pattern)?;
        let closure = CROSSING_DEPTH_EDGES / lattice.lattice_deviation(pattern, 1.0);
        (closure > ROUNDING_RESIDUAL).then_some(closure)
    }

    /// Places knots if the waypoints close: between knots the motion has to close to within `closure`.
    fn closed(&self, closure: f64) -> Option<Placement> {
        let knots = self.place(
            &self.reduction.essential,
            Some(closure),
            None,
            self.knot_budget(),
        )?;
        let certificate = self.certify(&self.reduction.all, &knots);
        Some(Placement::new(knots, certificate))
    }

    /// Places knots if the waypoints do not close: between knots the motion has to close nearly as well as at them.
    ///
    /// If this takes too many knots or leaves the bound unproved, it is repeated with no vertex standing for another;
    /// if that fails too, all waypoints become knots. Only if none of these is proved by the worst-case sum of the
    /// vertices' errors is the actual sum bounded, by folding the sheet.
    fn nearly_closed(&self) -> Placement {
        let (bound, reduction) = (self.problem.options.bound, self.reduction);
        let knot_budget = self.knot_budget();
        let few = knot_budget.min(KNOTS_PER_WAYPOINT * self.waypoints.len());
        let near = |all: &ReducedStars, stars: &ReducedStars| -> Placement {
            let open = self.max_residual(stars);
            let knots = self.place(stars, Some(RESIDUAL_RATIO * open), None, few);
            knots.map_or_else(Placement::default, |knots| {
                let certificate = self.bound_from_vertices(all, &knots);
                Placement::new(knots, certificate)
            })
        };
        let together = near(&reduction.all, &reduction.essential);
        if together.keeps(bound) {
            return together;
        }
        let apart = reduction.all.unmerged();
        let stars = apart.essential();
        let singly = near(&apart, &stars);
        if singly.keeps(bound) {
            return singly;
        }
        let every = self.place(&stars, None, None, knot_budget);
        if let Some(knots) = &every {
            let certificate = self.bound_from_vertices(&apart, knots);
            if certificate.over(bound).is_none() {
                return Placement {
                    certificate: Some(certificate),
                    knots: every,
                };
            }
        }
        let mut last = singly.certificate;
        if let Some(knots) = together.knots {
            let certificate = self.certify(&reduction.all, &knots);
            if certificate.over(bound).is_none() {
                return Placement::new(knots, certificate);
            }
            last = Some(certificate);
        }
        match every {
            Some(knots) => {
                let certificate = self.certify(&apart, &knots);
                Placement::new(knots, certificate)
            }
            None => Placement {
                certificate: last,
                knots: None,
            },
        }
    }

    /// Places knots if the sum of the vertices' errors is measured: between waypoints the sheet may deform hardly more
    /// than at them, or as much as is aimed for, within the bound.
    fn measured(&self, mut aim: f64) -> Option<Placement> {
        let memberships = self.reduction.groups.memberships();
        let mut certifier = FoldingCertifier::new(self.problem.pattern, memberships);
        let bound = self.problem.options.bound;
        for waypoint in self.waypoints {
            let angles = waypoint.angles.iter();
            let still: Vec<_> = angles.map(|&a| Curve::Angle([a; 4])).collect();
            let here = certifier.rigidity(&still, bound)?;
            aim = larger(aim, RESIDUAL_RATIO * here.worst()).min(bound);
            if self.problem.is_late() {
                return None;
            }
        }
        let sheet = SheetBounds {
            certifier,
            aim,
            bound,
        };
        let knots = self.place(
            &self.reduction.essential,
            Some(aim),
            Some(sheet),
            self.knot_budget(),
        )?;
        let certificate = self.certify(&self.reduction.all, &knots);
        Some(Placement::new(knots, certificate))
    }

    /// Places at most `knot_budget` knots on the path. Between them these stars and loops close to within `closure`,
    /// `None` for any residual, and the whole sheet keeps the bounds of `sheet`, if there are any.
    fn place(
        &self,
        stars: &ReducedStars,
        closure: Option<f64>,
        sheet: Option<SheetBounds<'_>>,
        knot_budget: usize,
    ) -> Option<KnotSequence> {
        let (reduction, options) = (self.reduction, self.problem.options);
        let (_, signs) = reduction.asked(self.problem.goal);
        let limits = reduction.orthant(&signs);
        let mut solver = reduction.solver(options, self.closure_tolerance);
        solver.limits.clone_from(&limits);
        let constraints = PlacementConstraints {
            stars,
            closure,
            sheet,
            limits: &limits,
            speed: options.max_speed,
            acceleration: options.max_acceleration.unwrap_or(f64::INFINITY),
            knot_budget,
        };
        place(&self.path, &constraints, &mut solver, options)
    }

    /// Returns the largest number of knots of a path.
    pub(crate) fn knot_budget(&self) -> usize {
        self.problem.options.max_knots.unwrap_or(MAX_KNOTS)
    }

    /// Returns the largest residual of these stars over all waypoints.
    fn max_residual(&self, stars: &ReducedStars) -> f64 {
        let waypoints = self.waypoints.iter();
        let open = waypoints.map(|waypoint| stars.largest_residual(&waypoint.angles));
        open.fold(0.0, larger)
    }

    /// Turns the closure bound of every vertex into worst-case bounds on the whole sheet; `all` are the stars of all
    /// vertices.
    fn bound_from_vertices(&self, all: &ReducedStars, knots: &KnotSequence) -> Certificate {
        let sheet = SheetCertifier::new(self.problem.pattern, self.reduction.tree, all);
        Certificate {
            closure: sheet.as_ref().map(|sheet| sheet.closure(&knots.closure)),
            deformation: sheet.map_or(f64::INFINITY, |mut sheet| {
                let bounds = sheet.rigidity(&knots.closure);
                bounds.deformation.max(bounds.gap)
            }),
        }
    }

    /// Bounds the sheet as [`bound_from_vertices`](Self::bound_from_vertices) does. If the worst case is over the bound,
    /// bounds the sheet itself, folded from its middle and from its rim.
    pub(crate) fn certify(&self, all: &ReducedStars, knots: &KnotSequence) -> Certificate {
        let certificate = self.bound_from_vertices(all, knots);
        if certificate.over(self.problem.options.bound).is_none() {
            return certificate;
        }
        let folded = self.bound_whole_sheet(knots);
        Certificate {
            deformation: folded.unwrap_or(certificate.deformation),
            ..certificate
        }
    }

    /// Returns a bound on deformation and gap of the sheet folded from its middle and from its rim, if that is within
    /// the bound and found in time.
    fn bound_whole_sheet(&self, knots: &KnotSequence) -> Option<f64> {
        let memberships = self.reduction.groups.memberships();
        let mut certifier = FoldingCertifier::new(self.problem.pattern, memberships);
        let mut worst = 0.0;
        for curves in knots.curves() {
            if self.problem.is_late() {
                return None;
            }
            let bounds = certifier.rigidity(&curves, self.problem.options.bound)?;
            worst = larger(worst, bounds.worst());
        }
        Some(worst)
    }
}
