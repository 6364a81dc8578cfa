//! Parts a layout that lies on itself into pieces that do not, as few as are found.

use std::collections::VecDeque;

use nalgebra::Vector2;

use super::layout::{Layout, Motion};
use super::overlap::ConvexFaces;
use super::surface::Surface;
use crate::util::csr::group_by_key;
use crate::util::union_find::UnionFind;

/// Largest number of overlapping pairs of faces with which a layout is parted: this for each face.
const MAX_OVERLAPS: usize = 64;

/// Budget of compared pairs of faces when pieces are put together.
const MAX_COMPARED: usize = 1 << 22;

/// Returns the layout with parts that lie on themselves cut into pieces. First pieces grow face by face, each as long as
/// nothing overlaps; flat panels stay whole. Then pieces are put together again wherever that gives no overlap. Returns
/// `None` if a plain sheet or a flat panel overlaps itself, or faces overlap too many others.
pub(super) fn parted(
    layout: &Layout,
    surface: &Surface,
    faces: &ConvexFaces,
    is_folded: impl Fn(usize) -> bool,
    touch: f64,
) -> Option<Layout> {
    let count = surface.faces.len();
    let (joined, parts, places) = layout.laid();
    let most = MAX_OVERLAPS * count;
    let overlaps = faces.overlaps(0..count, places, touch, most);
    if overlaps.len() == most {
        return None;
    }
    // Panels: faces that are joined across edges which are not folded.
    let mut panels = UnionFind::new(count);
    let mut beyond = Vec::new();
    for (index, edge) in surface.edges.iter().enumerate() {
        if let (Some([a, b]), true) = (edge.joint(), joined[index]) {
            beyond.extend([(a.face, b.face), (b.face, a.face)]);
            if !is_folded(index) {
                panels.join_to_smaller([a.face, b.face]);
            }
        }
    }
    let panels = panels.representatives();
    let plain = |face: usize| surface.is_plain(parts[face]);
    let same = |[a, b]: [usize; 2]| panels[a] == panels[b] || plain(a) && parts[a] == parts[b];
    if overlaps.iter().any(|pair| same(*pair)) {
        return None;
    }
    let both = overlaps.iter().flat_map(|&[a, b]| [[a, b], [b, a]]);
    let overlaps = group_by_key(count, both.map(|[a, b]| (panels[a], panels[b])));
    let beyond = group_by_key(count, beyond);
    let of_panels = group_by_key(count, (0..count).map(|face| (panels[face], face)));

    let mut pieces = vec![usize::MAX; count];
    let mut number = 0;
    for start in 0..count {
        if pieces[start] != usize::MAX {
            continue;
        }
        let mut open = VecDeque::from([start]);
        while let Some(face) = open.pop_front() {
            let blocked = |&other: &usize| pieces[other] == number;
            let panel = panels[face];
            if pieces[face] != usize::MAX || overlaps[panel].iter().any(blocked) {
                continue;
            }
            for &face in &of_panels[panel] {
                pieces[face] = number;
                open.extend(&beyond[face]);
            }
        }
        number += 1;
    }
    let mut assembly = Assembly {
        surface,
        faces,
        touch,
        of_pieces: vec![Vec::new(); number],
        pieces,
        places: places.to_vec(),
        compared: 0,
    };
    for (face, &piece) in assembly.pieces.iter().enumerate() {
        assembly.of_pieces[piece].push(face);
    }
    while assembly.put_together() {}
    let Assembly { pieces, places, .. } = assembly;
    Some(Layout::of_pieces(surface, numbered(&pieces), places, touch))
}

/// Returns the same pieces with numbers from 0, in the order of their first faces.
fn numbered(pieces: &[usize]) -> Vec<usize> {
    let mut names = vec![usize::MAX; pieces.len()];
    let mut next = 0;
    let named = pieces.iter().map(|&piece| {
        if names[piece] == usize::MAX {
            names[piece] = next;
            next += 1;
        }
        names[piece]
    });
    named.collect()
}

/// Pieces that are being put together.
struct Assembly<'a> {
    surface: &'a Surface,
    faces: &'a ConvexFaces,
    touch: f64,
    /// Faces of each piece.
    of_pieces: Vec<Vec<usize>>,
    /// For each face its piece.
    pieces: Vec<usize>,
    /// Places of all corners.
    places: Vec<Vector2<f64>>,
    /// Number of pairs of faces that were compared.
    compared: usize,
}

impl Assembly<'_> {
    /// Puts pieces together across each edge where that gives no overlap. Returns `true` if any were.
    fn put_together(&mut self) -> bool {
        let mut any = false;
        for edge in &self.surface.edges {
            let Some([a, b]) = edge.joint() else { continue };
            let [first, second] = [a, b].map(|side| self.pieces[side.face]);
            let pairs = self.of_pieces[first].len() * self.of_pieces[second].len();
            if first == second || self.compared + pairs > MAX_COMPARED {
                continue;
            }
            self.compared += pairs;
            let [to, from] =
                [a, b].map(|side| self.surface.corners(side).map(|corner| self.places[corner]));
            let motion = Motion::fit(from.into_iter().zip(to));
            let corners = self.of_pieces[second].iter();
            let corners = corners.flat_map(|&face| self.surface.corner_range(face));
            let before: Vec<_> = corners.map(|c| (c, self.places[c])).collect();
            for &(corner, place) in &before {
                self.places[corner] = motion.apply(place);
            }
            let both = [first, second].map(|piece| self.of_pieces[piece].as_slice());
            if self.faces.do_overlap(both, &self.places, self.touch) {
                for (corner, place) in before {
                    self.places[corner] = place;
                }
                continue;
            }
            for face in core::mem::take(&mut self.of_pieces[second]) {
                self.pieces[face] = first;
                self.of_pieces[first].push(face);
            }
            any = true;
        }
        any
    }
}
