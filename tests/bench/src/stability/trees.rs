//! Spanning trees of several kinds, and the folding map along them in either precision.

use std::collections::VecDeque;

use foldpath::pattern::{CreasePattern, FaceId};
use foldpath_core::{HalfAngle, Rotation, Scalar};
use nalgebra::{Vector2, Vector3};
use rand_core::{Rng, SeedableRng};
use rand_pcg::Pcg64;

/// Kind of a spanning tree of the faces.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Kind {
    /// The library's tree: breadth first from a central face.
    Central,
    /// Breadth first from the first face, which is in a corner.
    Corner,
    /// From the first face, each time across a random edge to a new face; seeded.
    Random,
    /// Depth first from the first face: nearly one strip of all faces.
    DepthFirst,
}

impl Kind {
    /// All kinds.
    pub const ALL: [Self; 4] = [Self::Central, Self::Corner, Self::Random, Self::DepthFirst];

    /// Returns the name of the kind.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::Central => "central face",
            Self::Corner => "corner face",
            Self::Random => "corner, random",
            Self::DepthFirst => "corner, depth first",
        }
    }
}

/// A face, the face from which it is reached, and the hinge between them.
#[derive(Clone, Copy, Debug)]
struct Step {
    face: usize,
    parent: usize,
    crease: Option<usize>,
    pivot: Vector2<f64>,
    axis: Vector2<f64>,
}

/// A spanning tree.
#[derive(Clone, Debug)]
pub struct Tree {
    root: usize,
    steps: Vec<Step>,
}

impl Tree {
    /// Creates the tree of this kind for a connected sheet.
    #[must_use]
    pub fn new(pattern: &CreasePattern, kind: Kind) -> Self {
        if kind == Kind::Central {
            let tree = pattern.tree();
            let steps = tree.steps().iter().map(|step| Step {
                face: step.face.index(),
                parent: step.parent.index(),
                crease: step.crease.map(|crease| crease.index()),
                pivot: step.pivot,
                axis: step.axis,
            });
            let root = tree.roots()[0].index();
            return Self {
                root,
                steps: steps.collect(),
            };
        }
        let mut rng = Pcg64::seed_from_u64(1);
        let mut done = vec![false; pattern.faces().len()];
        done[0] = true;
        // Edges of the faces that were reached, each with the face beyond.
        let mut open: VecDeque<_> = ways(pattern, 0).collect();
        let mut steps = Vec::with_capacity(done.len());
        loop {
            let next = match kind {
                Kind::Central | Kind::Corner => open.pop_front(),
                Kind::DepthFirst => open.pop_back(),
                Kind::Random if open.is_empty() => None,
                Kind::Random => {
                    let count = u64::try_from(open.len()).unwrap_or(u64::MAX);
                    let at = usize::try_from(rng.next_u64() % count).unwrap_or_default();
                    open.swap_remove_back(at)
                }
            };
            let Some(step) = next else {
                return Self { root: 0, steps };
            };
            if !core::mem::replace(&mut done[step.face], true) {
                steps.push(step);
                open.extend(ways(pattern, step.face));
            }
        }
    }

    /// Returns the number of faces on the longest path from the root.
    #[must_use]
    pub fn depth(&self) -> usize {
        let mut depths = vec![0; self.steps.len() + 1];
        for step in &self.steps {
            depths[step.face] = depths[step.parent] + 1;
        }
        depths.into_iter().max().unwrap_or_default()
    }

    /// Folds the sheet by the half angles of its creases, all in the precision of `T`, and returns the positions of all
    /// corners. Written as the library's folding map is.
    #[must_use]
    pub fn fold<T: Scalar>(&self, pattern: &CreasePattern, angles: &[T]) -> Folded {
        let halves: Vec<_> = angles.iter().map(|&angle| HalfAngle::of(angle)).collect();
        let zero = Vector3::from([T::zero(); 3]);
        let mut poses = vec![(Rotation::<T>::identity(), zero); self.steps.len() + 1];
        poses[self.root] = (Rotation::identity(), zero);
        let cast = |v: Vector2<f64>| [T::lit(v.x), T::lit(v.y)];
        for step in &self.steps {
            let (r_wp, p_w) = poses[step.parent];
            let pivot = cast(step.pivot);
            let half = step
                .crease
                .map_or_else(HalfAngle::default, |crease| halves[crease]);
            let r_wf = r_wp.across_crease(half, cast(step.axis)).renormalised();
            let fixed = r_wp.rotate_in_sheet(pivot) + p_w;
            poses[step.face] = (r_wf, fixed - r_wf.rotate_in_sheet(pivot));
        }
        let vertices = pattern.vertices().iter().zip(pattern.corners().iter());
        let places = vertices.map(|(&vertex, faces)| {
            let place = |face: &FaceId| {
                let (r_wf, p_w) = poses[face.index()];
                (r_wf.rotate_in_sheet(cast(vertex)) + p_w).map(T::to_f64)
            };
            faces.iter().map(place).collect()
        });
        Folded {
            places: places.collect(),
        }
    }
}

/// Returns the steps across the edges of a face.
fn ways(pattern: &CreasePattern, parent: usize) -> impl Iterator<Item = Step> {
    pattern.neighbours()[parent].iter().map(move |&(face, id)| {
        let edge = pattern.edge(id);
        // A positive rotation about the edge's direction lifts its left side.
        let start = edge.ends[usize::from(edge.faces[0] != Some(face))];
        Step {
            face: face.index(),
            parent,
            crease: edge.crease.map(|crease| crease.index()),
            pivot: pattern.vertices()[start.index()],
            axis: pattern.direction(id, start),
        }
    })
}

/// Positions of each vertex by all faces round it.
#[derive(Clone, Debug)]
pub struct Folded {
    places: Vec<Vec<Vector3<f64>>>,
}

impl Folded {
    /// Returns the position of a vertex by the first of its faces.
    #[must_use]
    pub fn vertex(&self, vertex: usize) -> Vector3<f64> {
        self.places[vertex][0]
    }

    /// Returns deformation, and gap over the median edge; NaN if a position is not finite.
    #[must_use]
    pub fn rigidity(&self, pattern: &CreasePattern) -> [f64; 2] {
        let gaps = self.places.iter().flat_map(|places| {
            let pairs = places.iter().enumerate();
            pairs.flat_map(|(k, a)| places[..k].iter().map(move |b| (a - b).norm()))
        });
        let changes = pattern.struts().map(|ends| {
            let [a, b] = ends.map(|end| self.vertex(end.index()));
            ((a - b).norm() / pattern.length(ends) - 1.0).abs()
        });
        [worst(changes), worst(gaps) / pattern.median_edge()]
    }
}

/// Returns the largest value, 0 for none; NaN if a value is NaN.
pub fn worst(values: impl Iterator<Item = f64>) -> f64 {
    values.fold(
        0.0,
        |worst, x| if x > worst || x.is_nan() { x } else { worst },
    )
}
