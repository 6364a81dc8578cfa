//! The report's objective, and its derivative by differences.
//!
//! Implements Eq. (2) of [XiLien2015](foldpath#references): F(C) = max ‖L(v) − I‖ with the Frobenius norm.
//! With the unit quaternion (w, v) of L that is 2√2 |v|.

use core::f64::consts::SQRT_2;

use foldpath::symmetry::ReducedStars;
use foldpath_core::{HalfAngle, StarView, closure};

use foldpath_core::Spoke;

/// Radians: step of differences, the root of the precision.
const STEP: f64 = 1.5e-8;

/// F at one configuration after another. Allocates nothing once it is made.
#[derive(Clone, Debug)]
pub struct ClosureObjective {
    /// The stars' spokes, one star behind the other, and where each ends.
    spokes: Vec<Spoke<f64>>,
    ends: Vec<u32>,
    half_angles: Vec<HalfAngle<f64>>,
    /// For each unknown the stars that it is in, and where each list ends.
    touched: Vec<u32>,
    touched_ends: Vec<u32>,
    /// |v|² of each star.
    squares: Vec<f64>,
    /// The stars of the largest squares, the largest first.
    top: [u32; TOP],
    /// Values asked for; of one with its derivative as much as it costs without sparing.
    pub evaluations: u64,
}

/// A crease has two ends: of three stars one is beyond its reach.
const TOP: usize = 3;

impl ClosureObjective {
    /// Of stars.
    #[must_use]
    pub fn new(stars: &ReducedStars) -> Self {
        let view = stars.view();
        let mut objective = Self {
            spokes: Vec::new(),
            ends: Vec::new(),
            half_angles: vec![HalfAngle::default(); view.unknowns()],
            touched: Vec::new(),
            touched_ends: Vec::new(),
            squares: vec![0.0; view.len()],
            top: [u32::MAX; TOP],
            evaluations: 0,
        };
        let mut stars_of = vec![Vec::new(); view.unknowns()];
        for (number, star) in (0_u32..).zip(view.iter()) {
            objective.spokes.extend(star.spokes);
            objective.ends.push(length(&objective.spokes));
            for spoke in star.spokes {
                let list: &mut Vec<u32> = &mut stars_of[spoke.group.index()];
                if list.last() != Some(&number) {
                    list.push(number);
                }
            }
        }
        for list in stars_of {
            objective.touched.extend(list);
            objective.touched_ends.push(length(&objective.touched));
        }
        objective
    }

    /// F at the unknowns `x` (radians). Cost: O(spokes).
    #[must_use]
    pub fn value(&mut self, x: &[f64]) -> f64 {
        self.evaluations += 1;
        closure::half_angles(x, &mut self.half_angles);
        let mut largest = 0.0_f64;
        for star in 0..self.squares.len() {
            let square = self.square(star);
            self.squares[star] = square;
            largest = largest.max(square);
        }
        norm(largest)
    }

    /// F, and its forward differences in `gradient`: the same numbers as of one value more for each unknown,
    /// but only stars that an unknown is in are taken again. Cost: O(spokes x degree) where every crease is
    /// its own.
    #[must_use]
    pub fn value_and_gradient(&mut self, x: &[f64], gradient: &mut [f64]) -> f64 {
        let value = self.value(x);
        self.find_top();
        let mut start = 0;
        for (unknown, slope) in gradient.iter_mut().enumerate() {
            let end = self.touched_ends[unknown] as usize;
            let before = self.half_angles[unknown];
            self.half_angles[unknown] = HalfAngle::of(x[unknown] + STEP);
            let touched = start..end;
            let mut largest = self.largest_beyond(touched.clone());
            for index in touched {
                largest = largest.max(self.square(self.touched[index] as usize));
            }
            self.half_angles[unknown] = before;
            *slope = (norm(largest) - value) / STEP;
            start = end;
        }
        value
    }

    /// |v|² of a star.
    #[inline]
    fn square(&self, star: usize) -> f64 {
        let start = if star == 0 { 0 } else { self.ends[star - 1] };
        let spokes = &self.spokes[start as usize..self.ends[star] as usize];
        let misclosure = closure::misclosure(StarView { spokes }, &self.half_angles);
        misclosure.v.norm_squared()
    }

    fn find_top(&mut self) {
        self.top = [u32::MAX; TOP];
        let square = |squares: &[f64], star: u32| squares.get(star as usize).copied();
        for star in (0_u32..).take(self.squares.len()) {
            let mut rising = star;
            for place in &mut self.top {
                if square(&self.squares, rising) > square(&self.squares, *place) {
                    core::mem::swap(place, &mut rising);
                }
            }
        }
    }

    /// The largest square of a star that is not in that part of the list.
    fn largest_beyond(&self, touched: core::ops::Range<usize>) -> f64 {
        let touched = &self.touched[touched];
        let beyond = |star: &u32| !touched.contains(star);
        if touched.len() < TOP {
            let mut top = self.top.iter().filter(|&&star| star != u32::MAX);
            let first = top.find(|star| beyond(star));
            return first.map_or(0.0, |&star| self.squares[star as usize]);
        }
        if touched.len() == self.squares.len() {
            return 0.0;
        }
        // The list is in order.
        let mut largest = 0.0_f64;
        let mut inside = touched.iter().peekable();
        for (star, &square) in (0_u32..).zip(&self.squares) {
            if inside.next_if_eq(&&star).is_none() {
                largest = largest.max(square);
            }
        }
        largest
    }
}

/// ‖L − I‖ by |v|².
fn norm(square: f64) -> f64 {
    2.0 * SQRT_2 * square.sqrt()
}

fn length<T>(list: &[T]) -> u32 {
    u32::try_from(list.len()).expect("numbers of spokes are 32 bits wide")
}
