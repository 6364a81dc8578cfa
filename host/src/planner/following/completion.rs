//! Completes the goal of driven creases: finds closed configurations in which they have their angles, and leads to one of
//! them as to a goal that names every crease.
//!
//! A motion that turns the driven creases straight to their angles often ends where another crease comes to its limit,
//! although a motion round that place leads on. From a closed configuration at the goal the way back is regular.

use foldpath_core::least_squares::Limits;
use foldpath_core::sampling::random_near;
use rand_pcg::Pcg64;

use super::follow::Followed;
use super::judge::Judge;
use super::legs::RouteFinder;
use super::reduction::{CLOSED, ClosedGoal, SAME_RAD};
use crate::planner::goal::GoalKind;
use crate::planner::reason::{Note, Stop};
use crate::planner::vectors::max_difference;
use crate::util::union_find::UnionFind;

/// Angles at which free creases start, in the directions of their letters, radians.
const STARTS_RAD: [f64; 5] = [0.0, 0.25, 0.5, 1.0, 2.0];
/// Number of random starts beside these, and the largest angle of one, radians.
const RANDOM_STARTS: usize = 16;
const MAX_RANDOM_RAD: f64 = 2.5;
/// Largest number of unknowns with random starts: on a larger sheet each takes long and is rarely good.
const MAX_RANDOM_UNKNOWNS: usize = 200;
/// Smallest difference of two configurations that are different goals, radians.
const OTHER_GOAL_RAD: f64 = 1e-3;
/// Largest number of closed configurations from which the way back is looked for.
const MAX_COMPLETIONS: usize = 6;

impl RouteFinder<'_> {
    /// Leads from `from`, or else from flat, to a closed configuration in which the driven creases have their angles.
    /// Returns `None` if the goal is not one of driven creases, or no way is found to any such configuration.
    pub(super) fn complete(&mut self, from: Option<&[f64]>) -> Option<Followed> {
        let goal = self.problem.goal;
        if goal.kind != GoalKind::Driven || !self.reduction.allows(goal) {
            return None;
        }
        let completions = self.completions();
        let way = self.way_to_first(from, &completions);
        match (&way, completions.len()) {
            (Some(way), found @ 2..) if way.stop.is_none() => {
                self.notes.push(Note::OtherCompletions(found - 1));
            }
            (None, 1..) => self.known_goal = self.free_goal(&completions[0].angles),
            _ => {}
        }
        way
    }

    /// Returns a configuration if no faces cross there.
    fn free_goal(&self, angles: &[f64]) -> Option<Vec<f64>> {
        let collision = self.problem.options.collision;
        let crossing = Judge::new(&self.problem, self.reduction, collision).crossing_at(angles);
        crossing.is_none().then(|| angles.to_vec())
    }

    /// Returns closed configurations in which the driven creases have their angles, and no crease turns against its
    /// letter. Those free of crossings come first, among these those that leave the fewest lettered creases flat, and
    /// then those of which the lettered crease that turns the least turns the most: letters ask each crease to turn.
    fn completions(&mut self) -> Vec<ClosedGoal> {
        let mut solver = self.solver(0.0);
        for (limit, asked) in solver.limits.iter_mut().zip(&self.asked) {
            if let Some(asked) = *asked {
                *limit = (asked, asked);
            }
        }
        let mut found: Vec<Vec<f64>> = Vec::new();
        let joined = self.joined_to_driven();
        for mut angles in self.starts(&joined) {
            let closes = solver.closes(&mut angles)
                && self.reduction.closure(&angles) <= CLOSED
                && self.reduction.distance(&angles, self.problem.goal) <= SAME_RAD;
            let mut known = found.iter();
            if closes && known.all(|other| max_difference(other, &angles) > OTHER_GOAL_RAD) {
                found.push(angles);
            }
        }
        self.work += solver.work;
        let collision = self.problem.options.collision;
        let mut judge = Judge::new(&self.problem, self.reduction, collision);
        let goal = self.problem.goal;
        let unturned = |angles: &[f64]| goal.flat(&self.signs, angles).count();
        let least = |angles: &[f64]| {
            let lettered = (0..angles.len()).filter(|&k| joined[k] && self.signs[k].abs() > 0.0);
            lettered.fold(f64::INFINITY, |least, k| least.min(angles[k].abs()))
        };
        found.sort_by(|a, b| least(b).total_cmp(&least(a)));
        found.sort_by_cached_key(|angles| (judge.crossing_at(angles).is_some(), unturned(angles)));
        found.truncate(MAX_COMPLETIONS);
        let goal = |angles: Vec<f64>| ClosedGoal {
            error: self.reduction.distance(&angles, self.problem.goal),
            angles,
            closure_tolerance: 0.0,
        };
        found.into_iter().map(goal).collect()
    }

    /// Returns for each crease group `true` if it is driven, or a chain of closure conditions joins it to one that is. The
    /// others stay at rest.
    fn joined_to_driven(&self) -> Vec<bool> {
        let mut sets = UnionFind::new(self.asked.len());
        let stars = self.reduction.essential.view().iter();
        let stars = stars.map(|star| star.spokes);
        let loops = self.reduction.essential.loops();
        let conditions = stars.chain(loops.iter().map(|hole| hole.spokes));
        for spokes in conditions {
            for pair in spokes.windows(2) {
                sets.join([pair[0].group.index(), pair[1].group.index()]);
            }
        }
        let driven = (0..self.asked.len()).filter(|&group| self.asked[group].is_some());
        let driven: Vec<usize> = driven.map(|group| sets.find(group)).collect();
        let of_group = (0..self.asked.len()).map(|group| driven.contains(&sets.find(group)));
        of_group.collect()
    }

    /// Returns configurations from which to close: the driven creases at their angles, those that are `joined` to them
    /// turned in the directions of their letters by equal angles, or at random.
    fn starts(&mut self, joined: &[bool]) -> Vec<Vec<f64>> {
        let start = |free: &dyn Fn(usize) -> f64| -> Vec<f64> {
            let asked = self.asked.iter().enumerate();
            let free = |k: usize| if joined[k] { free(k) } else { 0.0 };
            asked
                .map(|(k, asked)| asked.unwrap_or_else(|| free(k)))
                .collect()
        };
        let alike = STARTS_RAD.iter();
        let mut starts: Vec<Vec<f64>> =
            alike.map(|size| start(&|k| self.signs[k] * size)).collect();
        if self.asked.len() <= MAX_RANDOM_UNKNOWNS {
            let mut rng = Pcg64::new(u128::from(self.problem.options.seed), 0);
            let flat = vec![0.0; self.asked.len()];
            let mut drawn = flat.clone();
            for _ in 0..RANDOM_STARTS {
                random_near(
                    &mut rng,
                    &flat,
                    MAX_RANDOM_RAD,
                    Limits::HalfTurn,
                    &mut drawn,
                );
                let signed = |k: usize| match self.signs[k] {
                    sign if sign.abs() > 0.0 => sign * drawn[k].abs(),
                    _ => drawn[k],
                };
                starts.push(start(&signed));
            }
            self.is_random = true;
        }
        starts
    }

    /// Returns the way to the first of some closed configurations to which there is one: straight, backwards, or else
    /// forwards.
    fn way_to_first(
        &mut self,
        from: Option<&[f64]>,
        completions: &[ClosedGoal],
    ) -> Option<Followed> {
        let ends = |way: &Followed| matches!(way.stop, None | Some(Stop::Timeout));
        let flat = vec![0.0; self.asked.len()];
        let mut ways = completions.iter().map(|target| match from {
            Some(from) => self.between(from, target),
            None => {
                let straight = self.straight_way(&flat, &target.angles);
                straight.unwrap_or_else(|| self.backwards(target))
            }
        });
        let way = ways.find(ends);
        way.or_else(|| {
            let mut ways = completions.iter().map(|target| self.forwards(Some(target)));
            ways.find(ends).filter(|_| from.is_none())
        })
    }
}
