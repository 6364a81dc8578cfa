//! How far the cells and faces of a folded tessellation move along a motion.

use foldpath_core::HalfAngle;
use nalgebra::{Vector2, Vector3};

use super::lattice_motion::LatticeMotion;
use super::map::Pose;
use super::screw::Screw;

/// What a group angle does over an interval: its variation, and its largest distance from a straight line
/// in time, radians.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Bend {
    /// Total variation.
    pub varied: f64,
    /// At most the variation counts.
    pub off: f64,
}

/// Sums over the intervals of a motion that bound how far any face moves as seen from any other, at all
/// times, whether the sheet closes between the configurations given or not.
///
/// Why. Let x be a point beyond hinges 1 … n, whose angles change by δₖ, δₖ = λ (change over the interval)
/// up to an `off` of bₖ, and vary by vₖ. x is its value at the beginning, and its derivative times δ, and a
/// rest of no more than ½ Σⱼ Σₖ vⱼ vₖ L(max(j, k)), where Lₖ is the way from hinge k to x from pivot to
/// pivot, which no folding makes longer. At the end of the interval x is known. So in between it is no
/// farther from the straight line to there than Σⱼ Σₖ vⱼ vₖ L(max(j, k)) + Σₖ bₖ Lₖ, which is of second
/// order: what x moves is the chord and that. The same without levers holds for the rotation.
///
/// With a step S before and A after, Aⁿ x - Sⁿ x is the sum over m of Aⁿ⁻ᵐ (A S⁻¹ z - z) with z = Sᵐ x, which
/// is bounded by the motion of one point, the next cell's centre, and the turn times the distance of z from
/// it. That distance is no more than that of x from the centre and how far m steps lead: no farther than m
/// times the first, nor than twice the distance from the axis of S and m times its pitch.
#[derive(Clone, Debug)]
pub struct LatticeCourse {
    /// Largest counts of steps that are asked for.
    most: [f64; 2],
    orbits: usize,
    /// For each time the sums of each term.
    sums: Vec<Terms>,
    /// For each time and orbit the sum of what its faces move in the frame of their cell.
    own: Vec<f64>,
    folded: Vec<Folded>,
}

/// A configuration of the cell and its steps.
#[derive(Clone, Debug)]
pub(super) struct Folded {
    pub(super) poses: Vec<Pose>,
    pub(super) steps: [Screw; 2],
}

/// Factors of counts i and j of the first and the second step, and of their sums up to i and j.
#[derive(Clone, Copy, Debug, Default)]
struct Terms {
    own: f64,
    first: StepTerms,
    second: StepTerms,
    /// Turn of the first step times the reach of the second.
    across: Reach,
}

#[derive(Clone, Copy, Debug, Default)]
struct StepTerms {
    /// What a point of the next cell moves.
    shift: f64,
    reach: Reach,
}

/// A turn times how far steps lead from cell to cell: along the length of each, or across the axis once and
/// along it.
#[derive(Clone, Copy, Debug, Default)]
struct Reach {
    length: f64,
    width: f64,
    pitch: f64,
}

impl Reach {
    fn new(step: &Screw, center: Vector3<f64>, most: f64) -> Self {
        let way = step.motion().carry(&center) - center;
        let length = way.norm();
        Self {
            length,
            // Where nothing turns the width is infinite, and the length says as much.
            width: step.width(way).min(most * length),
            pitch: step.pitch(),
        }
    }

    fn times(self, turn: f64) -> Self {
        Self {
            length: self.length * turn,
            width: self.width * turn,
            pitch: self.pitch * turn,
        }
    }

    fn plus(self, other: Self) -> Self {
        Self {
            length: self.length + other.length,
            width: self.width + other.width,
            pitch: self.pitch + other.pitch,
        }
    }

    /// For `steps` in `ways` ways.
    fn sum(&self, since: &Self, steps: f64, ways: f64) -> f64 {
        let straight = steps * (self.length - since.length);
        let round = ways * (self.width - since.width) + steps * (self.pitch - since.pitch);
        straight.min(round)
    }
}

impl LatticeCourse {
    /// A course that begins at a configuration; cells that are compared are at most so many steps apart.
    #[must_use]
    pub fn new(start: &LatticeMotion, most: [u32; 2]) -> Self {
        let orbits = start.folded().poses.len();
        Self {
            most: most.map(f64::from),
            orbits,
            sums: vec![Terms::default()],
            own: vec![0.0; orbits],
            folded: vec![start.folded().clone()],
        }
    }

    /// Number of times.
    #[must_use]
    pub fn times(&self) -> usize {
        self.sums.len()
    }

    /// The configuration at a time.
    pub(super) fn at(&self, time: usize) -> &Folded {
        &self.folded[time]
    }

    /// Goes on to another configuration, with what each group angle does on the way. Cost: O(orbits).
    pub fn push(&mut self, motion: &mut LatticeMotion, to: &[HalfAngle<f64>], bends: &[Bend]) {
        motion.fold(to);
        let (before, after) = (&self.folded[self.folded.len() - 1], motion.folded());
        let center = motion.center();
        let last = self.own.len() - self.orbits;
        let (mut most, mut radius) = (0.0_f64, 0.0_f64);
        for (orbit, strayed) in motion.strayed(bends).enumerate() {
            let poses = [before.poses[orbit], after.poses[orbit]];
            let mut farthest = 0.0_f64;
            for &corner in motion.corners_of(orbit) {
                let [from, to] = poses.map(|pose| pose.apply(corner));
                farthest = farthest.max((to - from).norm_squared());
                radius = radius.max((from - center).norm_squared());
            }
            let moved = farthest.sqrt() + strayed;
            most = most.max(moved);
            self.own.push(self.own[last + orbit] + moved);
        }
        let radius = radius.sqrt();
        let mut steps = [(0.0, 0.0, Reach::default()); 2];
        for (k, (shift, turn, reach)) in steps.iter_mut().enumerate() {
            let [from, to] = [before, after].map(|folded| folded.steps[k].motion());
            let [off, turn_off] = motion.step_strayed(k, bends);
            let turned = to.r_wf * from.r_wf.inverse();
            // Of a chord on the unit sphere.
            *turn = 2.0 * turned.v.norm() + turn_off;
            *shift = (to.carry(&center) - from.carry(&center)).norm() + off + *turn * radius;
            *reach = Reach::new(&before.steps[k], center, self.most[k]);
        }
        let [
            (shift, turn, reach),
            (second_shift, second_turn, second_reach),
        ] = steps;
        let sum = self.sums[self.sums.len() - 1];
        self.sums.push(Terms {
            own: sum.own + most,
            first: StepTerms {
                shift: sum.first.shift + shift,
                reach: sum.first.reach.plus(reach.times(turn)),
            },
            second: StepTerms {
                shift: sum.second.shift + second_shift,
                reach: sum.second.reach.plus(second_reach.times(second_turn)),
            },
            across: sum.across.plus(second_reach.times(turn)),
        });
        self.folded.push(motion.folded().clone());
    }

    /// How far a cell moves, as a body that does not change itself, as seen from that so many steps
    /// back, from one time to any until another.
    fn moved(&self, [from, to]: [usize; 2], offset: [i32; 2]) -> f64 {
        if offset == [0, 0] {
            return 0.0;
        }
        let (since, until) = (&self.sums[from], &self.sums[to]);
        let [i, j] = offset.map(|count| f64::from(count).abs());
        let own = |step: &StepTerms, since: &StepTerms, n: f64| {
            let steps = n * (n + 1.0) / 2.0;
            n * (step.shift - since.shift) + step.reach.sum(&since.reach, steps, n)
        };
        own(&until.first, &since.first, i)
            + own(&until.second, &since.second, j)
            + i * until.across.sum(&since.across, j, 1.0)
    }

    /// How far any face of a cell may move as seen from any face of that so many steps back, from one
    /// time to any until another.
    #[must_use]
    pub fn cells(&self, [from, to]: [usize; 2], offset: [i32; 2]) -> f64 {
        2.0 * (self.sums[to].own - self.sums[from].own) + self.moved([from, to], offset)
    }

    /// The same for a face of the second orbit as seen from one of the first, so many steps back.
    #[must_use]
    pub fn faces(&self, [from, to]: [usize; 2], orbits: [u32; 2], offset: [i32; 2]) -> f64 {
        let own = |orbit: u32| {
            let at = |time: usize| self.own[time * self.orbits + orbit as usize];
            at(to) - at(from)
        };
        orbits.map(own).iter().sum::<f64>() + self.moved([from, to], offset)
    }
}

/// A point's way over the hinges before it: what they vary, what they bend, and the bends times the ways.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Stray {
    varied: f64,
    turn: f64,
    shift: f64,
}

impl Stray {
    /// Over `way` from the last pivot and then across a hinge.
    pub(super) fn across(self, way: f64, bend: Bend) -> Self {
        let Bend { varied, off } = bend;
        Self {
            varied: self.varied + varied,
            shift: self.to(way),
            turn: self.turn + varied * (varied + 2.0 * self.varied) + off.min(varied),
        }
    }

    /// How far a point so far from the last pivot strays.
    pub(super) fn to(self, way: f64) -> f64 {
        self.shift + self.turn * way
    }

    /// How far the rotation strays.
    pub(super) fn turn(self) -> f64 {
        self.turn
    }
}

/// A hinge on the way from a cell to the next, and the way to it from the one before.
#[derive(Clone, Copy, Debug)]
pub(super) struct Passed {
    pub(super) group: Option<usize>,
    pub(super) way: f64,
}

/// The hinges from a cell to the next, and the way from the last to its centre.
#[derive(Clone, Debug)]
pub(super) struct Passage {
    pub(super) hinges: Vec<Passed>,
    pub(super) rest: f64,
}

impl Passage {
    /// From the groups and pivots of the hinges, unfolded, from a cell's centre to the next one's.
    pub(super) fn new(
        hinges: &[(Option<usize>, Vector2<f64>)],
        center: Vector2<f64>,
        next: Vector2<f64>,
    ) -> Self {
        let mut before = center;
        let passed = hinges.iter().map(|&(group, pivot)| {
            let way = (pivot - before).norm();
            before = pivot;
            Passed { group, way }
        });
        let hinges = passed.collect();
        Self {
            hinges,
            rest: (next - before).norm(),
        }
    }
}
