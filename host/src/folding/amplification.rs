//! Bounds the ratio of the errors of a folded sheet to the closure residuals of its vertices.

use crate::pattern::{CreasePattern, EdgeId, Passage, Rigidity, SpanningTree};

/// Returns bounds on gap, deformation and twist of the whole sheet folded along this tree, each per closure residual: no
/// error is larger than its factor times the largest residual |r(v)| of a real vertex. `None` as for
/// [`Holonomy::new`](super::Holonomy::new). Cost: linear. Answers an open question of [XiLien2015](crate#references):
/// which essential bound a bound on the whole sheet requires.
///
/// The factors are the bounds that [`Holonomy`](super::Holonomy), where the reasons are given, has for
/// residuals of 1. The factor of the gap is no less than the length of the longest crease at a real vertex over
/// the median edge: folded from another face, the sheet may be torn at that crease. A sheet with holes also has
/// a residual |r(v)| of rotation and a residual |t| of translation, in units of its size, for each hole.
///
/// The factors hold for every configuration. The table has each factor, and the largest ratio of an error to
/// its bound found in `host/tests/it/amplification.rs`:
///
/// | sheet | gap, factor: filled | deformation, factor: filled | twist, factor: filled |
/// |---|---|---|---|
/// | Miura 3x3 | 1: 1.00 | 2: 0.43 | 1: 1.00 |
/// | Miura 11x11 | 15: 0.44 | 30: 0.14 | 5: 0.69 |
/// | Miura 24x24 | 78: 0.34 | 156: 0.13 | 12: 0.61 |
/// | waterbomb 12x22 | 66: 0.21 | 121: 0.08 | 11: 0.26 |
#[must_use]
pub fn amplification(pattern: &CreasePattern, tree: &SpanningTree) -> Option<Rigidity> {
    let turns = |edge: &EdgeId| pattern.edge(*edge).crease.is_some();
    let one = |turns: bool| if turns { 1.0 } else { 0.0 };
    let stars = pattern.stars().iter();
    let vertices: Vec<_> = stars.map(|star| one(star.iter().any(turns))).collect();
    let ways = pattern.holes().iter();
    let turn = |way: &[Passage]| way.iter().any(|passage| turns(&passage.edge));
    let holes: Vec<_> = ways.map(|way| [one(turn(way)); 2]).collect();
    let bounds = tree.holonomy(pattern)?.rigidity(&vertices, &holes);
    let creases = pattern.real_vertices();
    let creases = creases.flat_map(|vertex| pattern.stars()[vertex.index()].iter());
    let lengths = creases.filter(|edge| turns(edge));
    let lengths = lengths.map(|&edge| pattern.length(pattern.edge(edge).ends));
    let longest = lengths.fold(0.0, f64::max) / pattern.median_edge();
    Some(Rigidity {
        gap: bounds.gap.max(longest),
        ..bounds
    })
}

/// Returns the largest of the factors of [`amplification`]; at least 1, as a residual is an error in itself.
#[must_use]
pub fn worst_amplification(pattern: &CreasePattern, tree: &SpanningTree) -> Option<f64> {
    amplification(pattern, tree).map(|factors| factors.worst().max(1.0))
}
