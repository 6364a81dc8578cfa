//! Worst-case bounds on the errors of the whole sheet over a segment, as the sum of what its vertices may contribute.

use super::Closure;
use crate::folding::{Holonomy, Rigidity, SpanningTree, rounding};
use crate::pattern::{CreasePattern, VertexId};
use crate::symmetry::ReducedStars;

/// Turns bounds on the closure of the essential vertices into worst-case bounds on deformation, gap and twist of a
/// whole sheet, as [`FoldingMap::rigidity`](crate::folding::FoldingMap::rigidity) measures them.
#[derive(Clone, Debug)]
pub struct SheetCertifier<'t> {
    holonomy: &'t Holonomy,
    /// Errors that rounding adds.
    rounding: Rigidity,
    /// Each vertex with a condition, the essential star that represents it, and a bound on the difference of their
    /// residuals.
    stars: Vec<(VertexId, usize, f64)>,
    /// The hole of each loop.
    holes: Vec<usize>,
    vertex_bounds: Vec<f64>,
    hole_bounds: Vec<[f64; 2]>,
}

impl<'t> SheetCertifier<'t> {
    /// Makes the certifier of a sheet folded along this tree, with the stars and loops of all its vertices and holes.
    /// Returns `None` if [`Holonomy::new`] does.
    #[must_use]
    pub fn new(
        pattern: &CreasePattern,
        tree: &'t SpanningTree,
        all: &ReducedStars,
    ) -> Option<Self> {
        let stars = all.vertices().iter().zip(all.represented());
        Some(Self {
            holonomy: tree.holonomy(pattern)?,
            rounding: rounding(pattern, tree),
            stars: stars.map(|(&v, (star, off))| (v, star, off)).collect(),
            holes: all.holes().to_vec(),
            vertex_bounds: vec![0.0; pattern.vertices().len()],
            hole_bounds: vec![[0.0; 2]; pattern.holes().len()],
        })
    }

    /// Returns a bound on the closure of all vertices and holes over a segment on which the stars of
    /// [`ReducedStars::essential`] and the loops close to within `closure`.
    #[must_use]
    pub fn closure(&self, closure: &Closure) -> f64 {
        let bounds = self.stars.iter().map(|star| of_star(closure, star));
        bounds.fold(closure.worst(), f64::max)
    }

    /// Returns bounds on deformation, gap and twist over a segment on which the stars of [`ReducedStars::essential`]
    /// and the loops close to within `closure`; infinite if an essential star or a loop is missing. Cost: linear in the
    /// size of the sheet.
    pub fn rigidity(&mut self, closure: &Closure) -> Rigidity {
        for star in &self.stars {
            self.vertex_bounds[star.0.index()] = of_star(closure, star);
        }
        for (index, &hole) in self.holes.iter().enumerate() {
            let bound = closure.loops.get(index).copied();
            self.hole_bounds[hole] = bound.unwrap_or([f64::INFINITY; 2]);
        }
        let bound = self
            .holonomy
            .rigidity(&self.vertex_bounds, &self.hole_bounds);
        Rigidity {
            deformation: bound.deformation + self.rounding.deformation,
            gap: bound.gap + self.rounding.gap,
            twist: bound.twist + self.rounding.twist,
        }
    }
}

/// Returns a bound on the closure of a vertex, from that of the star that represents it.
fn of_star(closure: &Closure, &(_, star, off): &(VertexId, usize, f64)) -> f64 {
    let bound = closure.stars.get(star).copied();
    bound.unwrap_or(f64::INFINITY) + off
}
