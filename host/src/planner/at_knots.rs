//! Judges a path at its knots alone: nothing is certified between them, which takes a small part of the time.

use std::time::Instant;

use foldpath_core::Interpolation;

use super::follow::max_difference;
use super::knots::Knot;
use super::plan::{Outcome, Plan, Planning};
use super::reduction::Reduction;
use super::reuse::Found;
use crate::certificate::{Closure, SheetCertifier};
use crate::collision::{LatticeScene, SweepOptions};
use crate::folding::Rigidity;
use crate::lattice::Lattice;
use crate::pattern::CreasePattern;
use crate::progress::Stage;
use crate::util::nan_max::larger;

impl Planning<'_> {
    /// Makes the waypoints of a path its knots, between which hinges turn evenly, and judges the whole sheet at the
    /// knots.
    pub(super) fn judge_knots(mut self, reduction: &Reduction, found: &Found<'_>) -> Plan {
        self.watch.begin(Stage::Placing);
        let start = Instant::now();
        let most = self.options.max_knots.unwrap_or(usize::MAX);
        if found.waypoints.len() > most {
            self.plan.reached = 0.0;
            let reason = format!(
                "expected at most {most} knots, found {}, no fewer of which are judged alone",
                found.waypoints.len()
            );
            return self.end(Outcome::Partial, reason);
        }
        let knots = self.knots_of(found);
        self.plan.path.interpolation = Interpolation::Linear;
        self.plan.times.place += start.elapsed();
        self.watch.begin(Stage::Folding);
        if let Err(index) = self.measure_at_knots(reduction, knots) {
            return self.late_at(index);
        }
        self.plan
            .notes
            .push("judged at its knots alone: of the motion between them nothing is known".into());
        match self.torn() {
            Some(reason) => self.end(Outcome::NotRigidlyFoldable, reason),
            None if self.options.collision => self.look_at_knots(reduction),
            None => self.plan,
        }
    }

    /// Returns the waypoints as knots, as far apart in time as the largest speed of the hinges requires.
    fn knots_of(&self, found: &Found<'_>) -> Vec<Knot> {
        let mut time = 0.0;
        let mut before: Option<&[f64]> = None;
        let knots = found.waypoints.iter().map(|waypoint| {
            let turned = before.map_or(0.0, |before| max_difference(before, &waypoint.angles));
            time += turned / self.options.max_speed;
            before = Some(&waypoint.angles);
            Knot {
                time,
                rates: vec![0.0; waypoint.angles.len()],
                angles: waypoint.angles.clone(),
                ends_phase: waypoint.ends_phase,
                ..Knot::default()
            }
        });
        knots.collect()
    }

    /// Measures the sheet at its knots or, if that suffices, bounds its errors by the closure of its essential
    /// vertices. `Err` is the number of the knot before which time ran out.
    fn measure_at_knots(
        &mut self,
        reduction: &Reduction,
        mut knots: Vec<Knot>,
    ) -> Result<(), usize> {
        let start = Instant::now();
        let bound = (!self.options.keep_vertices)
            .then(|| bound_at(&knots, self.pattern, reduction))
            .flatten();
        self.plan.times.fold += start.elapsed();
        let Some(bound) = bound.filter(|bound| bound.worst() <= self.options.bound) else {
            return self.measure(reduction, knots);
        };
        for knot in &mut knots {
            knot.deformation = bound.deformation;
            knot.gap = bound.gap;
            knot.closure = bound.twist;
        }
        self.keep(knots);
        Ok(())
    }

    /// Looks for crossings at the knots, along the lattice if faces are near enough to where the lattice has them.
    fn look_at_knots(self, reduction: &Reduction) -> Plan {
        self.watch.begin(Stage::Crossings);
        let start = Instant::now();
        let (pattern, groups) = (self.pattern, &reduction.groups);
        let lattice = self.lattice(reduction);
        let near = |lattice: &&Lattice| {
            let deviation = lattice.lattice_deviation(pattern, self.plan.max_closure);
            deviation.max(self.plan.rigidity.gap) <= SweepOptions::default().tolerance
        };
        let scene = lattice.filter(near).and_then(|lattice| {
            LatticeScene::new(pattern, groups.memberships(), groups.len(), lattice)
        });
        let Some(mut scene) = scene else {
            return self.sweep_knots(reduction, start);
        };
        let plan = self.cross_at_knots(start, |knot| scene.deepest_crossing(&knot.angles));
        Plan {
            collision: scene.counts(),
            ..plan
        }
    }
}

/// Returns a bound on the errors of the sheet over all of these knots; its twist bounds the closure, too.
fn bound_at(knots: &[Knot], pattern: &CreasePattern, reduction: &Reduction) -> Option<Rigidity> {
    let essential = &reduction.essential;
    let count = essential.vertices().len();
    let mut worst = vec![0.0; count + essential.holes().len()];
    for knot in knots {
        for (worst, residual) in worst.iter_mut().zip(essential.residuals(&knot.angles)) {
            *worst = larger(*worst, residual);
        }
    }
    let loops: Vec<_> = worst[count..]
        .iter()
        .map(|&residual| [residual; 2])
        .collect();
    let closure = Closure {
        stars: &worst[..count],
        loops: &loops,
    };
    let mut sheet = SheetCertifier::new(pattern, &reduction.tree, &reduction.all)?;
    let bound = sheet.rigidity(&closure);
    Some(Rigidity {
        twist: larger(bound.twist, sheet.closure(&closure)),
        ..bound
    })
}
