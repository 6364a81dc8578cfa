//! The conditions on the products of two rates with which a sheet can leave flat.
//!
//! Let x be rates that satisfy the conditions to first order. The rotation round a vertex is then, to second order, about the
//! normal of the sheet, by half the sum of x_j x_k (u_j × u_k) over the pairs of creases j before k, with the directions u
//! counter-clockwise (the first term of the Baker-Campbell-Hausdorff formula). It has to be 0 too: a sheet of which the
//! creases of a vertex turn upwards all round would become a cone, for which it is too wide. This is the second-order test
//! of R. Connelly and W. Whiteley, "Second-order rigidity and prestress stability for tensegrity frameworks", SIAM J.
//! Discrete Math. 9(3), 1996; the multipliers of these conditions are the self-stress.
//!
//! Products X_jk = x_j x_k have the signs of their factors, and satisfy linear conditions: the one above, and each condition
//! to first order times each rate. Multipliers of these that hold all products at 0 prove, as those of the first order do,
//! that the creases do not turn (reformulation and linearisation; H. Sherali, W. Adams, SIAM J. Discrete Math. 3(3), 1990).

use super::flat_cone::{Coefficient, FlatConditions, row};
use crate::pattern::{ClosureSite, CreasePattern, VertexId};

/// The products of the rates of some creases, and the conditions on them.
pub(crate) struct Products {
    /// The two creases of each product; the second is not before the first.
    pub(crate) pairs: Vec<[usize; 2]>,
    /// The conditions, with the products as columns. An error of a product is the sum of the errors of its creases.
    pub(crate) conditions: FlatConditions,
}

impl Products {
    /// Makes the products of the rates of `creases`, all others being 0, and the conditions at some vertices. Cost: square of
    /// the number of creases times the number of vertices.
    pub(crate) fn new(
        pattern: &CreasePattern,
        first_order: &FlatConditions,
        vertices: &[VertexId],
        creases: &[usize],
    ) -> Self {
        let is_here = |site: ClosureSite| vertices.iter().any(|&v| site == ClosureSite::Vertex(v));
        let mut sites: Vec<ClosureSite> =
            vertices.iter().copied().map(ClosureSite::Vertex).collect();
        // The first row of each condition to first order, which has a row for each crease that it is multiplied with.
        let first_row = first_order.sites.iter().map(|&site| {
            let first = is_here(site).then_some(sites.len());
            sites.extend(creases.iter().filter(|_| first.is_some()).map(|_| site));
            first
        });
        let first_row: Vec<Option<usize>> = first_row.collect();
        let first_row = first_row.as_slice();
        // The conditions on one rate, multiplied with another one.
        let multiplied = |rate: usize, other: usize| {
            let column = first_order.columns[creases[rate]].iter();
            column.filter_map(move |coefficient| {
                let first = first_row[coefficient.row as usize]?;
                Some(Coefficient {
                    row: row(first + other),
                    ..*coefficient
                })
            })
        };
        let mut pairs = Vec::new();
        let mut columns = Vec::new();
        for j in 0..creases.len() {
            for k in j..creases.len() {
                let mut column: Vec<Coefficient> = multiplied(k, j).collect();
                if j != k {
                    column.extend(multiplied(j, k));
                    let turns = vertices.iter().enumerate().filter_map(|(index, &vertex)| {
                        let value = turn_about_normal(pattern, vertex, [creases[j], creases[k]])?;
                        Some(Coefficient {
                            row: row(index),
                            value,
                            sensitivity: 1.0,
                        })
                    });
                    column.extend(turns);
                }
                pairs.push([creases[j], creases[k]]);
                columns.push(column);
            }
        }
        Self {
            pairs,
            conditions: FlatConditions {
                columns: columns.into_iter().collect(),
                sites,
            },
        }
    }
}

/// Returns `true` if some creases of a vertex have a bird's foot: three creases of one sign all round it, and one of the other.
/// Such a vertex leaves flat (Z. Abel and others, "Rigid origami vertices: conditions and forcing sets", J. Comput. Geom. 7(1),
/// 2016), so that a proof need not be looked for.
pub(crate) fn has_foot(
    pattern: &CreasePattern,
    vertex: VertexId,
    creases: &[usize],
    signs: &[f64],
) -> bool {
    let star = pattern.stars()[vertex.index()].iter();
    let ways = star.filter_map(|&edge| {
        let crease = pattern.edge(edge).crease?.index();
        let way = pattern.direction(edge, vertex);
        creases.contains(&crease).then_some((signs[crease], way))
    });
    let ways: Vec<_> = ways.collect();
    [1.0, -1.0].into_iter().any(|side| {
        let toes: Vec<_> = ways.iter().filter(|(sign, _)| sign * side > 0.0).collect();
        let next = toes.iter().cycle().skip(1);
        let mut sectors = toes.iter().zip(next);
        // The stars are counter-clockwise, so that a sector is below half a turn if the next way is to the left.
        let all_round = sectors.all(|((_, way), (_, next))| way.perp(next) > 0.0);
        toes.len() >= 3 && toes.len() < ways.len() && all_round
    })
}

/// Returns twice the angle by which two creases that turn at rate 1 turn the sheet about its normal round a vertex, to
/// second order; `None` if they do not both end there.
fn turn_about_normal(
    pattern: &CreasePattern,
    vertex: VertexId,
    creases: [usize; 2],
) -> Option<f64> {
    let star = pattern.stars()[vertex.index()].iter();
    let is_one = |crease: usize| creases.contains(&crease);
    let both = star.filter(|&&edge| {
        let crease = pattern.edge(edge).crease;
        crease.is_some_and(|crease| is_one(crease.index()))
    });
    let ways: Vec<_> = both.map(|&edge| pattern.direction(edge, vertex)).collect();
    let [first, second] = ways[..] else {
        return None;
    };
    Some(first.perp(&second))
}
