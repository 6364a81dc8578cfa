//! Whether a sheet may fold flat at each vertex: the theorems of Kawasaki and Maekawa.
//!
//! Source: E. Demaine, J. O'Rourke, "Geometric Folding Algorithms", 2007, sections 12.2.1 and 12.2.2. Both are
//! necessary; that layers do not pass through each other is more.

use core::f64::consts::PI;

use super::{CreasePattern, Letter, VertexId};

/// Why a vertex cannot fold flat.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum FlatFlaw {
    /// It has this odd number of hinges.
    Odd(usize),
    /// Every other sector adds up to this angle (radians) in place of half a turn.
    Kawasaki(f64),
    /// Numbers of mountains and valleys, which have to differ by 2.
    Maekawa(usize, usize),
}

/// Radians: sectors of vertices in rounded coordinates add up to half a turn this nearly.
const SAME_ANGLE: f64 = 1e-3;

impl CreasePattern {
    /// The real vertices that cannot fold flat with all their mountains and valleys, and why. Vertices of hinges that
    /// may turn either way are not judged. Cost: linear.
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
        let sectors = directions.zip(next).step_by(2).map(|(from, to)| {
            let angle = from.perp(&to).atan2(from.dot(&to));
            if angle < 0.0 { angle + 2.0 * PI } else { angle }
        });
        let sum: f64 = sectors.sum();
        if (sum - PI).abs() > SAME_ANGLE {
            return Some(FlatFlaw::Kawasaki(sum));
        }
        (mountains.abs_diff(valleys) != 2).then_some(FlatFlaw::Maekawa(mountains, valleys))
    }
}
