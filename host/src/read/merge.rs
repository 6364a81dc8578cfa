//! Merges coincident vertices of faces that each have vertices of their own, as in STL files.
//!
//! Vertices are found in a uniform hash grid whose cells are as wide as the merging distance.

use std::collections::HashMap;

use nalgebra::Vector3;

use crate::unfold::FoldedShape;

/// Merging distance, as a fraction of the shape's size. Files of single precision write the same place with equal
/// numbers, and different places with numbers that differ by at least 6e-8 of the size.
const SAME_PLACE_RATIO: f64 = 1e-9;

/// Returns `true` if any vertex belongs to two faces, or if there are fewer than two faces.
pub(super) fn shares_vertices(faces: &[Vec<usize>]) -> bool {
    let last = faces.iter().flatten().max().map_or(0, |last| last + 1);
    let mut seen = vec![false; last];
    let mut twice = |&vertex: &usize| core::mem::replace(&mut seen[vertex], true);
    faces.len() < 2 || faces.iter().flatten().any(&mut twice)
}

/// Merges vertices at the same place and numbers them in the order in which the faces refer to them. A face that loses
/// a corner by merging has no area and is left out. Adds to `notes` how many vertices were merged and faces left out.
pub(super) fn merged(shape: FoldedShape, notes: &mut Vec<String>) -> FoldedShape {
    let near = SAME_PLACE_RATIO * shape.size();
    let mut places = Places {
        near,
        ..Places::default()
    };
    let mut names = vec![usize::MAX; shape.vertices.len()];
    let mut corners = 0_usize;
    let mut faces = Vec::with_capacity(shape.faces.len());
    let mut lost = 0_usize;
    for mut cycle in shape.faces {
        for corner in &mut cycle {
            let name = &mut names[*corner];
            if *name == usize::MAX {
                *name = places.name(shape.vertices[*corner]);
                corners += 1;
            }
            *corner = *name;
        }
        let mut sorted = cycle.clone();
        sorted.sort_unstable();
        if sorted.windows(2).any(|pair| pair[0] == pair[1]) {
            lost += 1;
        } else {
            faces.push(cycle);
        }
    }
    let Places { points, widest, .. } = places;
    if points.len() < corners {
        notes.push(format!(
            "vertices at the same place to within {near:.1e} made one: {corners} are {} (farthest apart \
             {widest:.1e}); what merely touches is joined thereby",
            points.len()
        ));
    }
    if lost > 0 {
        notes.push(format!(
            "faces with two corners at the same place, left out: {lost}"
        ));
    }
    FoldedShape {
        vertices: points,
        faces,
        edges: Vec::new(),
    }
}

/// Distinct places in space, in a hash grid whose cells are as wide as the merging distance `near`.
#[derive(Default)]
struct Places {
    near: f64,
    cells: HashMap<[i64; 3], Vec<usize>>,
    /// Numbers of the places by the bits of their coordinates: a fast path, as coincident vertices mostly have equal
    /// bits.
    exact: HashMap<[u64; 3], usize>,
    points: Vec<Vector3<f64>>,
    /// Largest distance between two points that were merged.
    widest: f64,
}

impl Places {
    /// Returns the number of a place, adding the place if it is new.
    fn name(&mut self, point: Vector3<f64>) -> usize {
        let bits = point.map(f64::to_bits).into();
        if let Some(&known) = self.exact.get(&bits) {
            return known;
        }
        let name = self.near_name(point);
        self.exact.insert(bits, name);
        name
    }

    /// Returns the number of a place whose coordinates have not occurred before bit by bit.
    fn near_name(&mut self, point: Vector3<f64>) -> usize {
        #[allow(
            clippy::cast_possible_truncation,
            reason = "saturates: shared cells cost time alone"
        )]
        let cell = point.map(|c| (c / self.near.max(f64::MIN_POSITIVE)).floor() as i64);
        for around in 0..27 {
            let step = |k: u32| i64::from(around / 3_u32.pow(k) % 3) - 1;
            let key = [0, 1, 2].map(|k| cell[k as usize].saturating_add(step(k)));
            for &known in self.cells.get(&key).into_iter().flatten() {
                let apart = (self.points[known] - point).norm();
                if apart <= self.near {
                    self.widest = self.widest.max(apart);
                    return known;
                }
            }
        }
        self.points.push(point);
        let name = self.points.len() - 1;
        self.cells.entry(cell.into()).or_default().push(name);
        name
    }
}
