//! Finds faces from edges by walking round the left side of each directed edge (half-edge traversal).
//!
//! A cycle of directed edges is the outer boundary of a region, or the outline of a component of the drawing, walked with
//! the component on the right. The outline of a component that lies in a region is an inner boundary of this region: of a
//! panel with a window, a flap or a slot.

use std::collections::HashSet;

use nalgebra::Vector2;

use super::nesting::components;
use super::parts::{Panel, Parts, parts};
use super::{Drawing, DrawnEdge, EdgeId, Letter, PatternError, VertexId};
use crate::util::csr::Csr;
use crate::util::progress::Watch;
use crate::util::union_find::UnionFind;

/// Finds the faces of a planar drawing, counter-clockwise. `stars` has the edges at each vertex, counter-clockwise. The
/// outside is left out, and so are windows and pieces that fall out (see [`Regions::falls_out`]). A panel with inner
/// boundaries is cut into faces without any; the lines between them, lettered J, are added behind the edges of the
/// drawing, and a note of them to `assumptions`.
///
/// # Errors
/// If a crease has the same panel on both sides, if the drawing is too large, or if the caller cancels.
pub(super) fn faces(
    drawing: &mut Drawing,
    stars: &Csr<EdgeId>,
    assumptions: &mut Vec<String>,
    watch: Watch<'_>,
) -> Result<Csr<VertexId>, PatternError> {
    let regions = Regions::new(drawing, stars, watch)?;
    let lines = regions.lines_within(drawing, stars)?;
    let falls_out = regions.falls_out(drawing);
    let mut inner = vec![Vec::new(); regions.cycles.len()];
    for (cycle, home) in regions.homes.iter().enumerate() {
        if let Some(home) = home.filter(|home| *home != cycle) {
            inner[home].push(cycle);
        }
    }
    let origin = |half: usize| drawing.edges[half / 2].ends[half % 2];
    let mut faces = Csr::default();
    let mut joins = Vec::new();
    let (mut panels, mut met) = (0, HashSet::new());
    for (region, cycle) in regions.cycles.iter().enumerate() {
        if regions.homes[region] != Some(region) || falls_out[region] {
            continue;
        }
        met.clear();
        let is_simple =
            inner[region].is_empty() && cycle.iter().all(|&half| met.insert(origin(half)));
        if is_simple {
            faces.push(cycle.iter().map(|&half| VertexId::new(origin(half))));
            continue;
        }
        let cycles = core::iter::once(region).chain(inner[region].iter().copied());
        let halves = cycles.flat_map(|cycle| regions.cycles[cycle].iter().copied());
        let (panel, vertices) = panel(drawing, halves, |edge| lines.contains(&edge));
        let no_area = PatternError::NoArea {
            face: faces.len(),
            vertex: vertices[0],
        };
        let Parts {
            faces: cut,
            joins: between,
        } = parts(&panel).ok_or(no_area)?;
        panels += 1;
        for face in cut {
            faces.push(
                face.into_iter()
                    .map(|corner| VertexId::new(vertices[corner])),
            );
        }
        joins.extend(
            between
                .into_iter()
                .map(|ends| ends.map(|end| vertices[end])),
        );
        if watch.is_over() {
            return Err(PatternError::Cancelled);
        }
    }
    if panels > 0 {
        assumptions.push(format!(
            "panels with a window, a flap or a line inside, or that touch themselves: {panels}; each counts as \
             several faces, joined by lines that stay flat (J): {}",
            joins.len()
        ));
    }
    let cuts = |edge: &&usize| drawing.edges[**edge].letter.parts();
    let mut cuts: Vec<usize> = lines.iter().filter(cuts).copied().collect();
    cuts.sort_unstable();
    if let Some(first) = cuts.first() {
        assumptions.push(format!(
            "cuts with one panel on both sides, which part nothing, taken as lines that stay flat (F): {} (first: \
             edge {first})",
            cuts.len()
        ));
    }
    for edge in cuts {
        drawing.edges[edge].letter = Letter::Flat;
        drawing.edges[edge].goal = None;
    }
    drawing
        .edges
        .extend(joins.into_iter().map(|ends| DrawnEdge {
            ends,
            letter: Letter::Join,
            goal: None,
        }));
    Ok(faces)
}

/// Returns the panel with these directed edges on its boundaries, and its vertices. `is_line` tells the edges that have the
/// panel on both sides.
fn panel(
    drawing: &Drawing,
    halves: impl Iterator<Item = usize>,
    is_line: impl Fn(usize) -> bool,
) -> (Panel, Vec<usize>) {
    let halves: Vec<usize> = halves.collect();
    let ends = |half: usize| {
        let [a, b] = drawing.edges[half / 2].ends;
        if half.is_multiple_of(2) {
            [a, b]
        } else {
            [b, a]
        }
    };
    let mut vertices: Vec<usize> = halves.iter().map(|&half| ends(half)[0]).collect();
    vertices.sort_unstable();
    vertices.dedup();
    let number = |vertex: usize| vertices.partition_point(|&it| it < vertex);
    let of = |half: usize| ends(half).map(number);
    let (lines, boundary): (Vec<usize>, Vec<usize>) =
        halves.into_iter().partition(|&half| is_line(half / 2));
    let once = |half: &usize| half.is_multiple_of(2);
    let panel = Panel {
        vertices: vertices.iter().map(|&v| drawing.vertices[v]).collect(),
        boundary: boundary.into_iter().map(of).collect(),
        lines: lines.into_iter().filter(once).map(of).collect(),
    };
    (panel, vertices)
}

/// The regions into which the edges of a drawing divide the plane. Directed edge 2e runs from the first end of edge e to
/// the second, directed edge 2e + 1 runs back.
struct Regions {
    /// The cycles of directed edges, each with its region on the left.
    cycles: Csr<usize>,
    /// For each directed edge its cycle.
    cycle_of: Vec<usize>,
    /// For each cycle the one that is the outer boundary of its region; `None` for the outside of the sheet.
    homes: Vec<Option<usize>>,
}

impl Regions {
    fn new(drawing: &Drawing, stars: &Csr<EdgeId>, watch: Watch<'_>) -> Result<Self, PatternError> {
        const NONE: usize = usize::MAX;
        let leaving = |edge: EdgeId, vertex: usize| {
            2 * edge.index() + usize::from(drawing.edges[edge.index()].ends[0] != vertex)
        };
        let mut next = vec![NONE; 2 * drawing.edges.len()];
        for (vertex, star) in stars.iter().enumerate() {
            // At the end of an edge, the face to the left continues along the next edge clockwise.
            let clockwise = star
                .iter()
                .skip(1)
                .zip(star)
                .chain(star.first().zip(star.last()));
            for (&edge, &before) in clockwise {
                next[leaving(edge, vertex) ^ 1] = leaving(before, vertex);
            }
        }
        let mut cycle_of = vec![NONE; next.len()];
        let mut cycles: Csr<usize> = Csr::default();
        for start in 0..next.len() {
            if cycle_of[start] != NONE {
                continue;
            }
            let cycle = cycles.len();
            let mut half = start;
            cycles.push(core::iter::from_fn(|| {
                let here = half;
                half = next[here];
                let new = cycle_of[here] == NONE;
                cycle_of[here] = cycle;
                new.then_some(here)
            }));
        }
        let origin = |half: usize| VertexId::new(drawing.edges[half / 2].ends[half % 2]);
        let is_outer = |(index, cycle): (usize, &[usize])| {
            let area = area(drawing, cycle.iter().map(|&half| origin(half)));
            (area > 0.0).then_some(index)
        };
        let mut homes: Vec<_> = cycles.iter().enumerate().map(is_outer).collect();
        let components = components(drawing, stars, watch)?;
        // From left to right: a component lies in the region above an edge whose component has its region already.
        for component in &components {
            let Some(&edge) = stars[component.first].last() else {
                continue;
            };
            // All edges of this vertex lead to the right, and the outline is to the left of the last of them.
            homes[cycle_of[leaving(edge, component.first)]] =
                component.below.and_then(|below| homes[cycle_of[below]]);
        }
        Ok(Self {
            cycles,
            cycle_of,
            homes,
        })
    }

    /// Returns the region to the left of a directed edge; `None` for the outside.
    fn of(&self, half: usize) -> Option<usize> {
        self.homes[self.cycle_of[half]]
    }

    /// Returns the regions to the left and right of an edge.
    fn sides(&self, edge: usize) -> [Option<usize>; 2] {
        [self.of(2 * edge), self.of(2 * edge + 1)]
    }

    /// Returns the edges with the same region on both sides.
    ///
    /// # Errors
    /// If one of them is a crease; preferably one that ends in the open is named.
    fn lines_within(
        &self,
        drawing: &Drawing,
        stars: &Csr<EdgeId>,
    ) -> Result<HashSet<usize>, PatternError> {
        let within = |edge: &usize| {
            let [left, right] = self.sides(*edge);
            left.is_some() && left == right
        };
        let lines: HashSet<usize> = (0..drawing.edges.len()).filter(within).collect();
        let is_crease = |edge: &usize| drawing.edges[*edge].letter.is_hinge();
        let creases =
            || (0..drawing.edges.len()).filter(|edge| lines.contains(edge) && is_crease(edge));
        let ends = creases().find_map(|edge| {
            let alone = |&end: &usize| stars[end].len() == 1;
            let vertex = drawing.edges[edge].ends.into_iter().find(alone)?;
            Some(PatternError::DeadEnd { edge, vertex })
        });
        let inside = || creases().next().map(|edge| PatternError::OneFace { edge });
        ends.or_else(inside).map_or(Ok(lines), Err)
    }

    /// Returns for each cycle `true` if its region is no part of the sheet. A region falls out if it is a window: its outer
    /// boundary has the letter B and other regions all along. Regions without a crease among them that other edges join
    /// fall out together if they are cut off all round and one sheet surrounds them: nothing holds them, and they do not
    /// fold.
    fn falls_out(&self, drawing: &Drawing) -> Vec<bool> {
        let count = self.cycles.len();
        let mut sheets = UnionFind::new(count);
        for (edge, drawn) in drawing.edges.iter().enumerate() {
            if let ([Some(left), Some(right)], false) = (self.sides(edge), drawn.letter.parts()) {
                sheets.join([left, right]);
            }
        }
        let mut is_window = vec![true; count];
        // For each sheet, by its representative.
        let mut around = vec![Around::Nothing; count];
        for (edge, drawn) in drawing.edges.iter().enumerate() {
            for half in [2 * edge, 2 * edge + 1] {
                let Some(here) = self.of(half) else { continue };
                let beyond = self.of(half ^ 1);
                let on_outer_boundary = self.cycle_of[half] == here;
                is_window[here] &= match drawn.letter {
                    Letter::Boundary => beyond.is_some(),
                    letter => letter.parts() && !on_outer_boundary,
                };
                let [sheet, other] = [Some(here), beyond].map(|it| it.map(|it| sheets.find(it)));
                let around = &mut around[sheet.unwrap_or(here)];
                *around = match (*around, other) {
                    (met, other) if other == sheet && !drawn.letter.is_hinge() => met,
                    (Around::Nothing, Some(one)) if other != sheet => Around::Sheet(one),
                    (Around::Sheet(one), Some(again)) if one == again => Around::Sheet(one),
                    _ => Around::Others,
                };
            }
        }
        let mut falls_out = |cycle: usize| {
            is_window[cycle] || matches!(around[sheets.find(cycle)], Around::Sheet(_))
        };
        (0..count).map(&mut falls_out).collect()
    }
}

/// The neighbours of a sheet beyond its edges.
#[derive(Clone, Copy, PartialEq)]
enum Around {
    Nothing,
    /// One other sheet, by its representative.
    Sheet(usize),
    /// Several others, or the outside; or the sheet has a crease.
    Others,
}

/// Returns the signed area of a cycle of vertices, positive counter-clockwise.
pub(super) fn area(drawing: &Drawing, cycle: impl Iterator<Item = VertexId> + Clone) -> f64 {
    let places = cycle.map(|vertex| drawing.vertices[vertex.index()]);
    twice_area(places) / 2.0
}

/// Returns twice the signed area of a polygon. Coordinates are taken relative to the first corner, because far from the
/// origin the products of absolute coordinates would cancel completely.
pub(crate) fn twice_area(corners: impl Iterator<Item = Vector2<f64>> + Clone) -> f64 {
    let Some(first) = corners.clone().next() else {
        return 0.0;
    };
    let from_first = corners.map(|corner| corner - first);
    let next = from_first.clone().skip(1);
    from_first.zip(next).map(|(a, b)| a.perp(&b)).sum()
}
