//! Lifts a path found on few unknowns to the whole sheet: certified, measured and swept for crossings. If layers touch,
//! a motion that is as far off its path as the bound allows may cross: it is then lifted again, nearer to the path. Near
//! a goal that does not close, a path may end before faces cross.

use super::certified_motion::Lifting;
use super::lifted::{Lifted, Recourse};
use super::measured_motion::torn;
use super::swept_motion::{Crossed, LEAST_BOUND_FRACTION, Swept, angles_before, place_before};
use crate::collision::{Crossing, Place};
use crate::planner::following::judge::Judge;
use crate::planner::knots::{KnotSequence, errors};
use crate::planner::plan::{Certificate, Outcome};
use crate::planner::problem::PlanningProblem;
use crate::planner::reason::{Note, Reason, TimeoutAt};
use crate::planner::vectors::max_difference;
use crate::progress::Stage;
use crate::util::nan_max::larger;

/// Factor by which the fraction of the bound that is aimed for shrinks, if the motion crosses and its path may not.
const NEARER_FACTOR: f64 = 0.01;
/// Largest distance before an inexact goal at which a path may stop so that nothing crosses, radians.
const MAX_RETREAT_RAD: f64 = 0.02;
/// Depth of contact at the end of a motion that ends before a crossing, as a fraction of that which is allowed.
const CLEAR_CONTACT_RATIO: f64 = 0.5;
/// Distances from the place of a crossing at which such a motion may end, radians, tried one after the other.
const CLEAR_ROOMS_RAD: [f64; 5] = [0.0, 1e-6, 1e-5, 1e-4, 1e-3];

/// Lifts a path to the whole sheet and judges it there. The motion between knots is certified for `bound_fraction` of
/// the bound at first.
pub(crate) fn lift(whole: &Lifting<'_>, bound_fraction: f64) -> Lifted {
    let (lifted, crossed) = whole.lift_near_enough(bound_fraction);
    let earlier = crossed.iter().flat_map(|crossed| &crossed.earlier);
    let mut shorter = earlier.zip(&crossed).filter_map(|(free, crossed)| {
        let shorter = whole.lift_shorter(bound_fraction, &lifted, crossed, free)?;
        let leads = crossed.is_at_knot || !matches!(shorter.outcome, Outcome::Crossing(_));
        leads.then_some(shorter)
    });
    let shorter = shorter.next();
    shorter.unwrap_or(lifted)
}

impl Lifting<'_> {
    /// Lifts the path, and again nearer to it as long as the sweep finds the motion too far from the path. If nearer
    /// motions decide nothing, the answer is that of the last motion before them. Returns the crossing before which the
    /// motion ends, too, if it ends before one.
    fn lift_near_enough(&self, bound_fraction: f64) -> (Lifted, Option<Crossed>) {
        let mut farther: Vec<(Lifted, Option<Crossed>)> = Vec::new();
        let mut fraction = bound_fraction;
        let (mut found, mut crossed) = loop {
            let mut lifted = self.lift_for(fraction, farther.is_empty());
            if lifted.outcome != Outcome::Planned {
                break (lifted, None);
            }
            let before = farther.last().map(|(before, _)| before);
            match (self.sweep(&mut lifted, before), lifted.recourse) {
                (Swept::TooFar(crossed), Recourse::GoNearer(last)) => {
                    fraction = last * NEARER_FACTOR;
                    farther.push((lifted, crossed));
                }
                (swept, _) => break self.ended(lifted, swept),
            }
        };
        while let Some((mut lifted, crossing)) = farther.pop() {
            // A sheet that is torn by more than the tolerance crosses elsewhere than its path does; a nearer motion tells
            // where.
            let decides = match found.outcome {
                Outcome::Planned => true,
                Outcome::Crossing(_) => crossing.is_none() || self.sheet().is_torn(lifted.tear()),
                _ => false,
            };
            if decides {
                found.goal_error = found.goal_error.or(lifted.goal_error);
                found.stop_at(lifted.proof_stops);
                continue;
            }
            lifted.recourse = Recourse::Nothing;
            let before = farther.last().map(|(before, _)| before);
            let swept = match crossing {
                Some(crossing) => Swept::Crosses(crossing),
                None => self.sweep(&mut lifted, before),
            };
            (found, crossed) = self.ended(lifted, swept);
        }
        (found, crossed)
    }

    /// Places the motion for a fraction of the bound, certifies it and measures it. The first one counts the closure
    /// residuals of a longer motion as well.
    fn lift_for(&self, bound_fraction: f64, is_first: bool) -> Lifted {
        let placement = (self.problem).stage(Stage::Placing, || self.place_knots(bound_fraction));
        let mut lifted = Lifted {
            reached: self.reached,
            waypoints: self.waypoints.len(),
            certificate: placement.certificate,
            recourse: if self.open_goal.is_some() {
                Recourse::EndEarlier
            } else if self.is_nearest(placement.certificate) {
                Recourse::Nothing
            } else {
                Recourse::GoNearer(bound_fraction)
            },
            ..Lifted::default()
        };
        if let Some(knots) = placement.knots {
            lifted.knots = knots;
            let min_closure = if is_first { self.min_closure } else { 0.0 };
            self.certify_and_measure(&mut lifted, min_closure);
        } else if self.problem.is_late() {
            self.end_unjudged(&mut lifted, TimeoutAt::PlacingKnots);
        } else {
            let budget = self.knot_budget();
            lifted.reached = 0.0;
            lifted.end(Outcome::Partial, Reason::TooManyKnots { budget });
        }
        lifted
    }

    /// Returns `true` if a motion closes so well between its knots that to place it nearer to the path changes nothing.
    fn is_nearest(&self, certificate: Option<Certificate>) -> bool {
        let closes = certificate.and_then(|it| it.closure);
        let nearest = self.closure_for(LEAST_BOUND_FRACTION);
        !self.problem.errors.is_measured() && closes.is_some_and(|closes| closes <= nearest)
    }

    /// Ends a motion before the first segment that is not proved to keep the bound, and measures the sheet at its knots.
    fn certify_and_measure(&self, lifted: &mut Lifted, min_closure: f64) {
        lifted.proof_stops = self.end_at_proof(lifted);
        if lifted.proof_stops.is_some() {
            // The path ends where its proof ends, so that it is neither shortened nor brought nearer to the reduced path.
            lifted.recourse = Recourse::GoNearer(LEAST_BOUND_FRACTION);
        }
        let measured = self.problem.stage(Stage::Folding, || {
            self.measure(&mut lifted.knots.knots, min_closure)
        });
        match measured {
            Ok(errors) => {
                lifted.errors = errors;
                let (bound, knots) = (self.problem.options.bound, &lifted.knots);
                let torn = torn(bound, &knots.knots, &errors, lifted.certificate)
                    .or_else(|| Some((self.torn_from_rim(knots, errors.closure)?, None)));
                if let Some((reason, good)) = torn {
                    match good {
                        Some(segment) => {
                            self.end_at(lifted, Some(Place { segment, s: 0.0 }));
                        }
                        None => lifted.reached = 0.0,
                    }
                    lifted.end(Outcome::NotRigidlyFoldable, reason);
                }
            }
            Err(knot) => self.end_unjudged(lifted, TimeoutAt::JudgingKnot(knot)),
        }
    }

    /// Ends a motion that closes at its knots, but is not proved to keep the bound, before the first segment that is not
    /// known to close well enough. Returns the reason if it does.
    fn end_at_proof(&self, lifted: &mut Lifted) -> Option<Reason> {
        let bound = self.problem.options.bound;
        let certified = lifted.certificate?.over(bound)?;
        if !lifted.knots.cut() {
            return None;
        }
        lifted.certificate = Some(self.certify(&self.reduction.all, &lifted.knots));
        let end = lifted.knots.end();
        lifted.goal_error = Some(self.reduction.distance(end, self.problem.goal));
        lifted.reached *= self.path.fraction(end);
        Some(Reason::ProofStops {
            reached: lifted.reached,
            certified,
            bound,
        })
    }

    fn end_unjudged(&self, lifted: &mut Lifted, at: TimeoutAt) {
        let max_speed = self.problem.options.max_speed;
        lifted.end_unjudged(self.waypoints, max_speed, at);
    }

    /// Ends a motion as the sweep says. Returns the crossing before which it ends, too, if it ends before one.
    fn ended(&self, mut lifted: Lifted, swept: Swept) -> (Lifted, Option<Crossed>) {
        let mut before = None;
        match swept {
            Swept::Free(clearance) => lifted.crossings.clearance = clearance,
            Swept::Undecided(question) => lifted.undecided.push(question),
            Swept::Late(at) => lifted.end_late(at),
            Swept::CrossesAtKnot(crossing, knot) => {
                let before = knot.checked_sub(1);
                self.end_at(&mut lifted, before.map(|segment| Place { segment, s: 0.0 }));
                let faces = crossing.faces;
                lifted.end(
                    Outcome::Crossing(crossing),
                    Reason::CrossesAtKnot { faces, knot },
                );
            }
            Swept::Crosses(crossed) | Swept::TooFar(Some(crossed)) => {
                let fraction = self.end_at(&mut lifted, crossed.free);
                let reason = self.crosses(&crossed, fraction);
                lifted.end(Outcome::Crossing(crossed.crossing), reason);
                before = Some(crossed);
            }
            // The motion decides nothing that the one before does not.
            Swept::TooFar(None) => lifted.outcome = Outcome::Partial,
        }
        let proof_stops = lifted.proof_stops.take();
        lifted.stop_at(proof_stops);
        (lifted, before)
    }

    /// Ends a motion at the last place free of crossings, or a little before, with a knot there; or else at its first knot.
    /// Returns the fraction of the path before that place.
    fn end_at(&self, lifted: &mut Lifted, place: Option<Place>) -> f64 {
        let place = place.unwrap_or(Place { segment: 0, s: 0.0 });
        let there = angles_before(&lifted.knots, place, 0.0);
        let fraction = self.path.fraction(there.as_deref().unwrap_or_default());
        let (problem, knots) = (self.problem, &mut lifted.knots);
        if problem.is_trial {
            knots.end_at(place);
        } else if let Some(end) = knots.end_at(self.clear(knots, place)) {
            let mut judge = Judge::new(problem, self.reduction, false);
            self.measure_knot(&mut judge, end);
            // Between knots a sheet closes less well than at them.
            let here = errors(end);
            lifted.errors.rigidity = lifted.errors.rigidity.worse(here);
            lifted.errors.closure = larger(lifted.errors.closure, here.twist);
        }
        lifted.reached = self.reached * fraction;
        lifted.goal_error = Some(self.reduction.distance(lifted.knots.end(), problem.goal));
        fraction
    }

    /// Returns a place a little before one at which faces touch as deep as contact may be, where they do not yet: to read
    /// the motion from a file rounds it. Returns the place itself if they touch as deep all along.
    fn clear(&self, knots: &KnotSequence, touching: Place) -> Place {
        if touching.s <= 0.0 {
            return touching;
        }
        let problem = PlanningProblem {
            contact: self.problem.contact * CLEAR_CONTACT_RATIO,
            ..*self.problem
        };
        let mut judge = Judge::new(&problem, self.reduction, true);
        let before = |&room: &f64| place_before(knots, touching, room);
        let mut places = CLEAR_ROOMS_RAD.iter().filter_map(before);
        let clear = places.find(|&place| {
            let angles = angles_before(knots, place, 0.0);
            angles.is_some_and(|angles| judge.crossing_at(&angles).is_none())
        });
        clear.unwrap_or(touching)
    }

    /// Returns the reason of a path of which this fraction is free, before a crossing.
    fn crosses(&self, crossed: &Crossed, free: f64) -> Reason {
        let Crossing { faces, depth } = crossed.crossing;
        Reason::Crosses {
            faces,
            reached: self.reached,
            free,
            segment: crossed.free.map_or(0, |place| place.segment),
            depth: depth / self.problem.pattern.median_edge(),
        }
    }

    /// Lifts the path that ends at the group angles `free`, a little before a crossing of `longer` near an inexact goal.
    /// Returns `None` if they are far from the goal.
    fn lift_shorter(
        &self,
        bound_fraction: f64,
        longer: &Lifted,
        crossed: &Crossed,
        free: &[f64],
    ) -> Option<Lifted> {
        let (problem, reduction) = (self.problem, self.reduction);
        let short = max_difference(free, &self.waypoints.last()?.angles);
        if short > MAX_RETREAT_RAD && !problem.goes_near {
            return None;
        }
        let mut solver = reduction.solver(problem.options, self.closure_tolerance);
        let waypoints = self.path.cut(&mut solver, free.to_vec())?;
        let shorter = Lifting {
            reached: self.reached,
            min_closure: longer.errors.closure,
            ..Lifting::new(problem, reduction, &waypoints, self.closure_tolerance)
        };
        let (mut lifted, _) = shorter.lift_near_enough(bound_fraction);
        let end = waypoints.last().map_or(&[][..], |last| &last.angles);
        let error = || reduction.distance(end, problem.goal);
        lifted.goal_error.get_or_insert_with(error);
        lifted.notes.push(Note::EndsBeforeCrossing {
            residual: self.open_goal?,
            crossing: self.crosses(crossed, self.path.fraction(free)),
            short,
        });
        Some(lifted)
    }
}
