//! Tests the theorems of Kawasaki and Maekawa at each vertex: can the vertex fold flat?
//!
//! Source: E. Demaine, J. O'Rourke, "Geometric Folding Algorithms", 2007, sections 12.2.1 and 12.2.2. Both conditions
//! are necessary, but they do not exclude layers that pass through each other.

use core::f64::consts::PI;

use super::{CreasePattern, Letter, VertexId};
use crate::util::angle::turn_between;

/// Reason why a vertex cannot fold flat.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum FlatFlaw {
    /// The vertex has this odd number of hinges.
    Odd(usize),
    /// Every other sector adds up to this angle (radians) instead of half a turn.
    Kawasaki(f64),
    /// The vertex has these numbers of mountains and valleys, which have to differ by 2.
    Maekawa(usize, usize),
}

/// Largest difference (radians) from half a turn of the sum of every other sector at a flat-foldable vertex with
/// rounded coordinates.
const SAME_ANGLE_RAD: f64 = 1e-3;

impl CreasePattern {
    /// Returns the real vertices that cannot fold flat with all their mountains and valleys, each with the reason.
    /// Vertices with hinges that may turn either way are not judged. Cost: linear.
    #[must_use]
    pub fn flat_flaws(&self) -> Vec<(VertexId, FlatFlaw)> {
        let vertices = self.real_vertices();
        let flawed = vertices.filter_map(|vertex| Some((vertex, self.flat_flaw(vertex)?)));
        flawed.collect()
    }

    fn flat_flaw(&self, vertex: VertexId) -> Option<FlatFlaw> {
        let star = self.stars()[vertex.index()].iter();
        let hinges: Vec<_> = star
            .copied()
            .filter(|&edge| self.edge(edge).crease.is_some())
            .collect();
        let count = |letter| {
            hinges
                .iter()
                .filter(|&&edge| self.edge(edge).letter == letter)
                .count()
        };
        let (mountains, valleys) = (count(Letter::Mountain), count(Letter::Valley));
        if hinges.is_empty() || mountains + valleys < hinges.len() {
            return None;
        }
        if hinges.len() % 2 == 1 {
            return Some(FlatFlaw::Odd(hinges.len()));
        }
        let directions = hinges.iter().map(|&edge| self.direction(edge, vertex));
        let next = directions.clone().cycle().skip(1);
        let sectors = directions.zip(next).step_by(2);
        let sectors = sectors.map(|(from, to)| turn_between(from, to));
        let sum: f64 = sectors.sum();
        if (sum - PI).abs() > SAME_ANGLE_RAD {
            return Some(FlatFlaw::Kawasaki(sum));
        }
        (mountains.abs_diff(valleys) != 2).then_some(FlatFlaw::Maekawa(mountains, valleys))
    }
}
