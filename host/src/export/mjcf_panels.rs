//! Panels of a sheet with the tree of hinges that joins them, and their meshes.

use core::fmt::Write;

use nalgebra::{Vector2, Vector3};

use crate::collision::{PlateMesh, Plates};
use crate::pattern::{CreasePattern, EdgeId, FaceId, VertexId};
use crate::util::union_find::UnionFind;

/// Part by which meshes of plates are smaller than the plates.
const SMALLER_RATIO: f64 = 1e-5;

/// A crease between two panels.
#[derive(Clone, Copy, Debug)]
pub(super) struct Joint {
    pub(super) edge: EdgeId,
    pub(super) parent: usize,
    pub(super) child: usize,
    /// An end of the crease.
    pub(super) pivot: VertexId,
    /// Unit direction about which a positive fold angle turns the child.
    pub(super) axis: Vector2<f64>,
}

/// Sets of faces that are joined by edges that stay flat, and the creases between them.
pub(super) struct Panels {
    /// Panel of each face.
    pub(super) of_face: Vec<usize>,
    /// Faces of each panel; the first names it.
    faces: Vec<Vec<FaceId>>,
    /// Panels, each after its parent and with its descendants next to it, with the joint that carries it.
    pub(super) order: Vec<(usize, Option<Joint>)>,
    /// Creases off the tree.
    pub(super) loops: Vec<Joint>,
}

impl Panels {
    /// Finds the panels. The tree that joins them has the hinges `first`, as far as these make no loop, and otherwise
    /// those of [`CreasePattern::tree`] as far as possible; its root is the panel of the central face.
    pub(super) fn of(pattern: &CreasePattern, first: &[EdgeId]) -> Self {
        let tree = pattern.tree();
        let steps = tree.steps().iter().chain(tree.loops());
        let steps = steps.map(|step| step.edge);
        let mut panels = Self::of_sets(pattern);
        let mut sets = UnionFind::new(panels.len());
        let mut in_tree = vec![false; pattern.edges().len()];
        for edge in first.iter().copied().chain(steps) {
            let data = pattern.edge(edge);
            if let (Some(_), Some(faces)) = (data.crease, data.inner_faces()) {
                let joined = faces.map(|face| panels.of_face[face.index()]);
                in_tree[edge.index()] |= sets.join(joined);
            }
        }
        let roots: Vec<usize> = tree
            .roots()
            .iter()
            .map(|root| panels.of_face[root.index()])
            .collect();
        panels.grow(pattern, &in_tree, &roots);
        panels
    }

    /// Groups the faces into panels, which are numbered by their first faces.
    fn of_sets(pattern: &CreasePattern) -> Self {
        let faces = pattern.panels();
        let mut of_face = vec![0; pattern.faces().len()];
        for (panel, faces) in faces.iter().enumerate() {
            faces.iter().for_each(|face| of_face[face.index()] = panel);
        }
        Self {
            of_face,
            faces,
            order: Vec::new(),
            loops: Vec::new(),
        }
    }

    /// Orders the panels from the roots outwards along the edges of the tree, depth first, and finds the loops.
    fn grow(&mut self, pattern: &CreasePattern, in_tree: &[bool], roots: &[usize]) {
        let joint = |edge: EdgeId, parent: usize, child: FaceId| {
            let ends = pattern.edge(edge).ends;
            // A positive turn about the edge's direction lifts its left side.
            let start = ends[usize::from(pattern.edge(edge).faces[0] != Some(child))];
            Joint {
                edge,
                parent,
                child: self.of_face[child.index()],
                pivot: start,
                axis: pattern.direction(edge, start),
            }
        };
        let mut around: Vec<Vec<Joint>> = vec![Vec::new(); self.faces.len()];
        let mut loops = Vec::new();
        for &edge in pattern.creases() {
            let Some([a, b]) = pattern.edge(edge).inner_faces() else {
                continue;
            };
            let [of_a, of_b] = [a, b].map(|face| self.of_face[face.index()]);
            if in_tree[edge.index()] {
                around[of_a].push(joint(edge, of_a, b));
                around[of_b].push(joint(edge, of_b, a));
            } else {
                loops.push(joint(edge, of_a, b));
            }
        }
        let mut done = vec![false; self.faces.len()];
        for &root in roots {
            let mut open = vec![(root, None)];
            while let Some((panel, joint)) = open.pop() {
                if core::mem::replace(&mut done[panel], true) {
                    continue;
                }
                self.order.push((panel, joint));
                let onwards = around[panel].iter().rev().filter(|next| !done[next.child]);
                open.extend(onwards.map(|next| (next.child, Some(*next))));
            }
        }
        self.loops = loops;
    }

    /// Number of panels.
    pub(super) fn len(&self) -> usize {
        self.faces.len()
    }

    /// Returns the name of a panel, `panel_F` with its first face F.
    pub(super) fn name(&self, panel: usize) -> String {
        format!("panel_{}", self.faces[panel][0])
    }

    /// Returns the joints of the tree in the order of the panels.
    pub(super) fn joints(&self) -> impl Iterator<Item = &Joint> {
        self.order.iter().filter_map(|(_, joint)| joint.as_ref())
    }

    /// Returns for each panel its meshes in Wavefront OBJ with their names: the convex parts of its plates or, without plates, a
    /// slab from `half` below the flat sheet to `half` above.
    pub(super) fn meshes(
        &self,
        pattern: &CreasePattern,
        plates: Option<&Plates>,
        half: f64,
    ) -> Vec<Vec<(String, String)>> {
        let of_panel = |panel: usize| {
            let name = self.name(panel);
            let Some(plates) = plates else {
                return vec![(name, self.mesh(pattern, panel, half))];
            };
            let mut of_panel: Vec<usize> = self.faces[panel]
                .iter()
                .map(|face| plates.of_face[face.index()])
                .collect();
            of_panel.sort_unstable();
            of_panel.dedup();
            let parts = of_panel
                .into_iter()
                .flat_map(|plate| plates.convex_meshes(pattern, plate));
            let parts: Vec<String> = parts.map(|mesh| obj(&mesh)).collect();
            match parts.len() {
                1 => parts.into_iter().map(|part| (name.clone(), part)).collect(),
                _ => (0..)
                    .zip(parts)
                    .map(|(k, part): (usize, _)| (format!("{name}_{k}"), part))
                    .collect(),
            }
        };
        (0..self.len()).map(of_panel).collect()
    }

    /// Returns a panel as a closed mesh in Wavefront OBJ: a slab from `half` below the flat sheet to `half` above.
    pub(super) fn mesh(&self, pattern: &CreasePattern, panel: usize, half: f64) -> String {
        let faces = &self.faces[panel];
        let mut corners: Vec<VertexId> = faces
            .iter()
            .flat_map(|face| &pattern.faces()[face.index()])
            .copied()
            .collect();
        corners.sort_unstable();
        corners.dedup();
        // Positions in the file are counted from 1, and those of the lower side follow those of the upper side.
        let upper = |vertex: VertexId| corners.binary_search(&vertex).unwrap_or_default() + 1;
        let lower = |vertex: VertexId| upper(vertex) + corners.len();
        let mut text = String::new();
        // Writing to memory cannot fail.
        for z in [half, -half] {
            for corner in &corners {
                let at = pattern.vertices()[corner.index()];
                let _complete = writeln!(text, "v {} {} {z}", at.x, at.y);
            }
        }
        for face in faces {
            for &[a, b, c] in &pattern.triangles()[face.index()] {
                let _complete = writeln!(text, "f {} {} {}", upper(a), upper(b), upper(c));
                let _complete = writeln!(text, "f {} {} {}", lower(c), lower(b), lower(a));
            }
            let ring = &pattern.faces()[face.index()];
            let next = ring.iter().cycle().skip(1);
            for (&a, &b) in ring.iter().zip(next) {
                if self.is_rim(pattern, panel, [a, b]) {
                    let _complete = writeln!(text, "f {} {} {}", upper(a), lower(a), lower(b));
                    let _complete = writeln!(text, "f {} {} {}", upper(a), lower(b), upper(b));
                }
            }
        }
        text
    }

    /// Returns `true` if the side of a face of the panel is a side of the panel, not one between two of its faces.
    fn is_rim(&self, pattern: &CreasePattern, panel: usize, ends: [VertexId; 2]) -> bool {
        let mut edges = pattern.stars()[ends[0].index()].iter();
        let edge = edges.find(|edge| pattern.edge(**edge).other_end(ends[0]) == ends[1]);
        let faces = edge.and_then(|edge| pattern.edge(*edge).inner_faces());
        faces.is_none_or(|faces| faces.iter().any(|face| self.of_face[face.index()] != panel))
    }
}

/// Returns a mesh in Wavefront OBJ, a little smaller than the plate: engines find solids that touch in each other.
fn obj(mesh: &PlateMesh) -> String {
    let mut text = String::new();
    #[allow(clippy::cast_precision_loss, reason = "a mean")]
    let middle = mesh.vertices.iter().sum::<Vector3<f64>>() / mesh.vertices.len().max(1) as f64;
    // Writing to memory cannot fail.
    for at in &mesh.vertices {
        let at = at + (middle - at) * SMALLER_RATIO;
        let _complete = writeln!(text, "v {} {} {}", at.x, at.y, at.z);
    }
    for [a, b, c] in mesh
        .triangles
        .iter()
        .map(|corners| corners.map(|corner| corner + 1))
    {
        let _complete = writeln!(text, "f {a} {b} {c}");
    }
    text
}
