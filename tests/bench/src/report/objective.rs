//! The report's objective, and its derivatives by forward differences.
//!
//! Implements Eq. (2) of [XiLien2015](foldpath#references): F(C) = max ‖L(v) − I‖ with the Frobenius norm. In terms of
//! the unit quaternion (w, v) of L the norm is 2√2 |v|.

use core::f64::consts::SQRT_2;

use foldpath::symmetry::ReducedStars;
use foldpath_core::{HalfAngle, StarView, closure};

use foldpath_core::Spoke;

/// Step of forward differences, radians: the square root of the machine precision.
const STEP: f64 = 1.5e-8;

/// Evaluates F at one configuration after another. Allocates memory only when it is created.
#[derive(Clone, Debug)]
pub struct ClosureObjective {
    /// Spokes of all stars, one star after the other.
    spokes: Vec<Spoke<f64>>,
    /// End of each star in `spokes`.
    ends: Vec<u32>,
    half_angles: Vec<HalfAngle<f64>>,
    /// For each unknown the stars in which it occurs, one list after the other.
    touched: Vec<u32>,
    /// End of each unknown's list in `touched`.
    touched_ends: Vec<u32>,
    /// v|² of each star.
    squares: Vec<f64>,
    /// Stars with the largest squares, the largest first.
    top: [u32; TOP],
    /// Number of values. A value with its derivatives counts as many as it would cost without reuse.
    pub evaluations: u64,
}

/// A crease occurs in at most two stars, so that one of the three largest stars does not change with it.
const TOP: usize = 3;

impl ClosureObjective {
    /// Creates the objective of these stars.
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

    /// Returns F at the unknowns `x` (radians). Cost: O(spokes).
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

    /// Returns F, and writes its forward differences to `gradient`. The numbers are those of one more value for each
    /// unknown, but only the stars in which an unknown occurs are evaluated again. Cost: O(spokes x degree) if every
    /// crease is an unknown.
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

    /// Returns |v|² of a star.
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

    /// Returns the largest square of a star that is not in this part of `touched`.
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
        // The list is sorted.
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

/// Returns ‖L − I‖ from |v|².
fn norm(square: f64) -> f64 {
    2.0 * SQRT_2 * square.sqrt()
}

fn length<T>(list: &[T]) -> u32 {
    u32::try_from(list.len()).expect("numbers of spokes are 32 bits wide")
}
