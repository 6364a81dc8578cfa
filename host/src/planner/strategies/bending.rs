//! Panels that bend: problems in which each panel may turn a little about its diagonals.

use std::sync::Arc;

use crate::certificate::range;
use crate::motion::Motion;
use crate::pattern::{CreaseId, CreasePattern, Diagonals, Letter};
use crate::planner::{Goal, HingeLimit, PlanOptions};

/// A sheet whose panels are cut along diagonals, with the same goal and options for it.
pub(crate) struct BentSheet {
    pub(crate) pattern: Arc<CreasePattern>,
    pub(crate) goal: Goal,
    pub(crate) options: PlanOptions,
}

impl BentSheet {
    /// Cuts the panels of a sheet along diagonals. Returns `None` if no panel can bend, or the sheet is cut.
    pub(crate) fn of(
        pattern: &CreasePattern,
        goal: &Goal,
        options: &PlanOptions,
        which: Diagonals,
    ) -> Option<Self> {
        let bent = pattern.with_bends(which)?;
        let limits = options.limits.iter().map(|limit| HingeLimit {
            crease: same(pattern, &bent, limit.crease),
            ..*limit
        });
        Some(Self {
            goal: goal_of(pattern, &bent, goal),
            options: PlanOptions {
                limits: limits.collect(),
                ..options.clone()
            },
            pattern: Arc::new(bent),
        })
    }

    /// Returns the options with the panels' bends limited to `most` radians.
    pub(crate) fn bending_by(&self, most: f64) -> PlanOptions {
        let mut options = self.options.clone();
        options
            .limits
            .extend(bends(&self.pattern).map(|crease| HingeLimit {
                crease,
                lower: -most,
                upper: most,
            }));
        options
    }

    /// Returns the largest bend of a panel over a motion of this sheet, radians.
    pub(crate) fn largest_bend(&self, motion: &Motion) -> f64 {
        let edges = bends(&self.pattern).map(|crease| self.pattern.creases()[crease.index()]);
        let curves = edges.flat_map(|edge| {
            let segments = 0..motion.segments();
            segments.map(move |segment| motion.curve(segment, edge))
        });
        let most = curves.map(|curve| {
            let [low, high] = range(&curve);
            high.max(-low)
        });
        most.fold(0.0, f64::max)
    }
}

/// Returns the creases about which panels bend.
fn bends(pattern: &CreasePattern) -> impl Iterator<Item = CreaseId> {
    let creases = pattern.creases().iter().enumerate();
    let bends = creases.filter(|(_, edge)| pattern.edge(**edge).letter == Letter::Bend);
    bends.map(|(crease, _)| CreaseId::new(crease))
}

/// Returns the crease of the bent sheet that lies on the same edge.
fn same(pattern: &CreasePattern, bent: &CreasePattern, crease: CreaseId) -> CreaseId {
    let edge = pattern.creases()[crease.index()];
    bent.edge(edge).crease.unwrap_or(crease)
}

/// Returns the goal for the bent sheet: bends are free.
fn goal_of(pattern: &CreasePattern, bent: &CreasePattern, goal: &Goal) -> Goal {
    let mut fold_angles = vec![None; bent.creases().len()];
    let mut signs = vec![0.0; fold_angles.len()];
    for (crease, angle) in goal.fold_angles.iter().enumerate() {
        let to = same(pattern, bent, CreaseId::new(crease)).index();
        (fold_angles[to], signs[to]) = (*angle, goal.signs[crease]);
    }
    Goal {
        fold_angles,
        signs,
        via: goal
            .via
            .iter()
            .map(|via| goal_of(pattern, bent, via))
            .collect(),
        guide: goal
            .guide
            .as_ref()
            .map(|guide| Box::new(goal_of(pattern, bent, guide))),
        ..goal.clone()
    }
}
