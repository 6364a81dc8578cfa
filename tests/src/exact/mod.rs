//! Judges motions of strips of panels for crossings in exact arithmetic.
//!
//! A [`Strip`] is a chain of convex panels. The tangent of half of every fold angle is a quotient of two linear functions
//! of time, so that the pose of one panel seen from another is a dual quaternion with one degree for each hinge
//! (`chain.rs`). The height of a corner of one panel over the other, and the reciprocal product of an edge of each
//! \[Plücker coordinates\], are then polynomials of twice that degree: for four hinges of degree 8. As long as none of
//! them changes its sign, the panels meet all the time or never. So time is cut at all roots, which Descartes' rule of
//! signs isolates to 2^-40 (`roots.rs`), and in every part between two roots one time is looked at (`panels.rs`).
//! Coordinates are integers and times are binary fractions, so that nothing is rounded.
//!
//! Roots nearer to each other than 2^-39 are not told apart. In that time no point of a strip moves by as much as
//! `GROWTH`, so [`Truth::Free`] is said only of panels that do not meet even if they are larger by that.

mod chain;
mod panels;
mod polynomial;
mod random;
mod roots;

use foldpath::pattern::{CreasePattern, Drawing, DrawnEdge, Letter};
use foldpath_core::Curve;
use nalgebra::Vector2;
use num_bigint::BigInt;

use chain::Chain;
use panels::meet;
use polynomial::Rounded;
use roots::{HALVINGS, add_roots, keeps_sign};

/// Corner in homogeneous coordinates: x and y times a weight, and the weight.
type Point = [i64; 3];

/// Units of length in 1.
pub const UNITS: i64 = 1 << 10;
/// Units of the cosine and sine of half angles in 1.
pub const TURNS: i64 = 1 << 40;
/// Units of a corner's weight in 1, for a polygon that is shrunk or grown.
const WEIGHT: i64 = 1 << 36;
/// Growth of panels that are free even so, over the distance of a side from the panel's middle.
const GROWTH: f64 = 1e-9;

/// A hinge of a strip.
#[derive(Clone, Debug)]
pub struct Hinge {
    /// A point of its line, units.
    pub start: [i64; 2],
    /// Direction of its line, with the next panel to its left; a valley fold lifts that panel.
    pub along: [i64; 2],
    /// Length of `along`, which is a whole number.
    pub length: i64,
    /// Multiple of the cosine of half the fold angle at both ends of the time, above 0.
    pub cos: [i64; 2],
    /// Sine of half the fold angle at both ends of the time, times the same number as its cosine.
    pub sin: [i64; 2],
}

/// A strip of convex panels with four corners, each joined to the next by a hinge.
#[derive(Clone, Debug)]
pub struct Strip {
    /// Corners of the edges across the strip, below and above, in units: the two ends, and the hinges between them.
    pub across: Vec<[[i64; 2]; 2]>,
    /// The hinges.
    pub hinges: Vec<Hinge>,
}

/// Verdict of exact arithmetic on the motion of a strip.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Truth {
    /// No two panels that are not joined meet.
    Free,
    /// Two panels meet even if both are shrunk by the contact tolerance.
    Crosses,
    /// Panels touch, or overlap by no more than the contact tolerance.
    Touches,
}

impl Strip {
    /// Judges the motion. `contact` is the depth up to which panels may overlap, in units of length 1.
    ///
    /// # Panics
    /// If a panel is not convex.
    #[must_use]
    pub fn judge(&self, contact: f64) -> Truth {
        let count = self.hinges.len() + 1;
        let pairs = (0..count).flat_map(|a| (a + 2..count).map(move |b| [a, b]));
        let mut truth = Truth::Free;
        for pair in pairs {
            match self.judge_pair(pair, contact) {
                Truth::Crosses => return Truth::Crosses,
                Truth::Touches => truth = Truth::Touches,
                Truth::Free => {}
            }
        }
        truth
    }

    fn judge_pair(&self, pair: [usize; 2], contact: f64) -> Truth {
        let hinges = &self.hinges[pair[0]..pair[1]];
        let sized = |sign: f64, by: f64| {
            pair.map(|panel| {
                let corners = self.corners(panel);
                let middle = middle_distance(&corners);
                resized(&corners, sign * (by / middle).max(GROWTH))
            })
        };
        if !meets(hinges, &sized(1.0, 0.0)) {
            Truth::Free
        } else if meets(hinges, &sized(-1.0, contact)) {
            Truth::Crosses
        } else {
            Truth::Touches
        }
    }

    /// Returns the corners of a panel, counter-clockwise, in units.
    fn corners(&self, panel: usize) -> [[i64; 2]; 4] {
        let [[a, d], [b, c]] = [self.across[panel], self.across[panel + 1]];
        [a, b, c, d]
    }

    /// Returns `true` if every panel is convex, and no corner is nearly straight.
    #[must_use]
    pub fn is_convex(&self) -> bool {
        (0..=self.hinges.len()).all(|panel| {
            let corners = self.corners(panel);
            (0..4).all(|k| {
                let [a, b, c] = [k, k + 1, k + 2].map(|k| corners[k % 4]);
                let [u, v] = [[b, a], [c, b]].map(|[p, q]| [p[0] - q[0], p[1] - q[1]]);
                u[0] * v[1] - u[1] * v[0] > UNITS * UNITS / 64
            })
        })
    }

    /// Returns the crease pattern, in which crease k is hinge k.
    ///
    /// # Panics
    /// If it is none.
    #[must_use]
    pub fn pattern(&self) -> CreasePattern {
        #[allow(clippy::cast_precision_loss, reason = "units are small numbers")]
        let place = |at: &[i64; 2]| Vector2::from(at.map(|units| units as f64 / UNITS as f64));
        let edge = |ends: [usize; 2]| DrawnEdge {
            ends,
            letter: Letter::Unassigned,
            goal: None,
        };
        let count = self.across.len();
        let across = (0..count).map(|k| edge([2 * k, 2 * k + 1]));
        let along = (0..2 * count - 2).map(|k| edge([k, k + 2]));
        let drawing = Drawing {
            vertices: self.across.iter().flatten().map(place).collect(),
            edges: across.chain(along).collect(),
            ..Drawing::default()
        };
        CreasePattern::new(drawing).expect("a strip")
    }

    /// Returns the curve of each hinge.
    #[must_use]
    pub fn curves(&self) -> Vec<Curve<f64>> {
        #[allow(clippy::cast_precision_loss, reason = "turns have 41 bits")]
        let line = |[from, to]: [i64; 2]| {
            let [from, to] = [from, to].map(|turns| turns as f64 / TURNS as f64);
            let third = (to - from) / 3.0;
            [from, from + third, to - third, to]
        };
        let curve = |hinge: &Hinge| Curve::HalfAngle {
            cos: line(hinge.cos),
            sin: line(hinge.sin),
        };
        self.hinges.iter().map(curve).collect()
    }
}

/// Returns the least distance of a side of a panel from the mean of its corners, in units of length 1.
#[allow(clippy::cast_precision_loss, reason = "units are small numbers")]
fn middle_distance(corners: &[[i64; 2]; 4]) -> f64 {
    let corner = |k: usize| Vector2::from(corners[k % 4].map(|units| units as f64 / UNITS as f64));
    let middle = (corner(0) + corner(1) + corner(2) + corner(3)) / 4.0;
    let sides = (0..4).map(|k| {
        let side = corner(k + 1) - corner(k);
        side.perp(&(middle - corner(k))) / side.norm()
    });
    sides.fold(f64::INFINITY, f64::min)
}

/// Returns a panel that is larger by this fraction about the mean of its corners.
fn resized(corners: &[[i64; 2]; 4], by: f64) -> [Point; 4] {
    #[allow(
        clippy::cast_precision_loss,
        clippy::cast_possible_truncation,
        reason = "36 bits"
    )]
    let by = (by * WEIGHT as f64).round() as i64;
    let sum = [0, 1].map(|k| corners.iter().map(|corner| corner[k]).sum::<i64>());
    corners.map(|corner| {
        let [x, y] = [0, 1].map(|k| WEIGHT * sum[k] + (WEIGHT + by) * (4 * corner[k] - sum[k]));
        [x, y, 4 * WEIGHT]
    })
}

/// Returns `true` if two panels meet at some time. The hinges lead from the first panel to the second.
fn meets(hinges: &[Hinge], [first, second]: &[[Point; 4]; 2]) -> bool {
    let exact = Chain::<BigInt>::new(hinges).pose();
    let rounded = Chain::<Rounded>::new(hinges).pose();
    let mut roots = Vec::new();
    for corner in second {
        if !keeps_sign(&rounded.height(corner)) {
            add_roots(&exact.height(corner), &mut roots);
        }
    }
    for corner in first {
        if !keeps_sign(&rounded.height_back(corner)) {
            add_roots(&exact.height_back(corner), &mut roots);
        }
    }
    for a in 0..4 {
        for b in 0..4 {
            let first = [&first[a], &first[(a + 1) % 4]];
            let second = [&second[b], &second[(b + 1) % 4]];
            if !keeps_sign(&rounded.passing(first, second)) {
                add_roots(&exact.passing(first, second), &mut roots);
            }
        }
    }
    roots.sort_unstable_by_key(|root| *root.start());
    // Times between roots, in units of half a root's width: the middle of each gap.
    let mut times = vec![0];
    let mut free_from = 0_i64;
    for root in roots {
        if *root.start() > free_from {
            times.push(free_from + root.start());
        }
        free_from = free_from.max(*root.end());
    }
    times.extend([free_from + (1 << HALVINGS), 2 << HALVINGS]);
    times
        .iter()
        .any(|&time| meet(first, second, &exact.at(time, HALVINGS + 1)))
}
