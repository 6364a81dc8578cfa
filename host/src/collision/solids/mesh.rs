//! Closed meshes of plates.

use nalgebra::{Vector2, Vector3};

use super::{Plate, Plates, without_repeats};
use crate::pattern::{CreasePattern, FaceId, VertexId, triangulate};

/// A closed mesh in the frame of the flat sheet, whose triangles are counter-clockwise seen from outside.
#[derive(Clone, Debug, Default)]
pub struct PlateMesh {
    /// Positions of the vertices.
    pub vertices: Vec<Vector3<f64>>,
    /// The vertices of each triangle.
    pub triangles: Vec<[u32; 3]>,
}

impl PlateMesh {
    /// Returns the volume.
    #[must_use]
    pub fn volume(&self) -> f64 {
        let origin = self.vertices.first().copied().unwrap_or_default();
        let volumes = self.triangles.iter().map(|triangle| {
            let [a, b, c] = triangle.map(|vertex| self.vertices[vertex as usize] - origin);
            a.cross(&b).dot(&c) / 6.0
        });
        volumes.sum()
    }

    /// Returns the number of a vertex, which is added if it is new.
    fn vertex(&mut self, at: Vector3<f64>) -> u32 {
        let known = self.vertices.iter().position(|vertex| *vertex == at);
        let index = known.unwrap_or_else(|| {
            self.vertices.push(at);
            self.vertices.len() - 1
        });
        u32::try_from(index).unwrap_or(u32::MAX)
    }

    fn triangle(&mut self, [a, b, c]: [u32; 3]) {
        if a != b && b != c && c != a {
            self.triangles.push([a, b, c]);
        }
    }
}

/// All plates of a sheet as closed meshes, whose triangles hang on the forms of the panels and not on the thickness.
#[derive(Clone, Debug, Default)]
pub struct SheetMesh {
    /// Positions of the vertices in the frame of the flat sheet, each with a face that it moves with.
    pub vertices: Vec<(FaceId, Vector3<f64>)>,
    /// The vertices of each triangle, counter-clockwise seen from outside. Some have no area.
    pub triangles: Vec<[u32; 3]>,
    /// The edges of the lower and the upper faces of the plates.
    pub edges: Vec<[u32; 2]>,
    /// For each plate the number of triangles up to its end.
    pub ends: Vec<usize>,
}

impl Plates {
    /// Returns the meshes of all plates.
    #[must_use]
    pub fn sheet_mesh(&self, pattern: &CreasePattern) -> SheetMesh {
        let mut mesh = SheetMesh::default();
        for plate in &self.list {
            mesh.add(self, plate, pattern);
            mesh.ends.push(mesh.triangles.len());
        }
        mesh
    }

    /// Returns the mesh of the plate of this number in the [`list`](Self::list).
    #[must_use]
    pub fn mesh(&self, plate: usize) -> PlateMesh {
        let outlines = self.list[plate].outlines.iter().zip(&self.heights);
        let ring = |(outline, height): (&Vec<[Vector2<f64>; 2]>, &f64)| {
            let places = outline.iter().flatten();
            places.map(|at| at.push(*height)).collect()
        };
        PlateMesh::between(outlines.map(ring))
    }

    /// Returns the meshes of the convex parts of a plate.
    #[must_use]
    pub fn convex_meshes(&self, pattern: &CreasePattern, plate: usize) -> Vec<PlateMesh> {
        let plate = &self.list[plate];
        let parts = plate.parts.iter().map(|part| {
            let columns: Vec<_> = part
                .iter()
                .map(|&vertex| plate.places(pattern, vertex))
                .collect();
            let rings = self.heights.iter().enumerate().map(|(layer, height)| {
                let places = columns.iter().flat_map(|column| column[layer]);
                places.map(|at| at.push(*height)).collect()
            });
            PlateMesh::between(rings.collect::<Vec<_>>())
        });
        parts.collect()
    }
}

impl SheetMesh {
    fn add(&mut self, plates: &Plates, plate: &Plate, pattern: &CreasePattern) {
        let face = plate.faces[0];
        // A corner that is cut off has two columns of vertices.
        let columns = plate.corners.iter().enumerate().flat_map(|(k, corner)| {
            let is_cut = plates.trims.cut(face, *corner).iter().any(|cut| *cut > 0.0);
            [0, 1]
                .into_iter()
                .skip(usize::from(!is_cut))
                .map(move |side| (k, side))
        });
        let columns: Vec<(usize, usize)> = columns.collect();
        let (first, count) = (self.vertices.len(), columns.len());
        let number = |layer: usize, column: usize| VertexId::new(first + layer * count + column).0;
        for (outline, height) in plate.outlines.iter().zip(&plates.heights) {
            let ring = columns
                .iter()
                .map(|&(k, side)| (face, outline[k][side].push(*height)));
            self.vertices.extend(ring);
        }
        let top = plates.heights.len() - 1;
        for column in 0..count {
            let next = (column + 1) % count;
            for layer in 0..top {
                let [a, b] = [column, next].map(|it| number(layer, it));
                let [d, c] = [column, next].map(|it| number(layer + 1, it));
                self.triangles.extend([[a, b, c], [a, c, d]]);
            }
            self.edges
                .extend([0, top].map(|layer| [column, next].map(|it| number(layer, it))));
        }
        // The last column of each corner.
        let lasts =
            (0..count).filter(|&k| columns[(k + 1) % count].0 != columns[k].0 || count == 1);
        let lasts: Vec<usize> = lasts.collect();
        let places = plate
            .corners
            .iter()
            .map(|corner| pattern.vertices()[corner.index()]);
        let whole = triangulate(&places.collect::<Vec<_>>()).unwrap_or_default();
        let whole = whole.into_iter().map(|corners| corners.map(|k| lasts[k]));
        let cut = lasts.iter().enumerate().filter_map(|(k, &last)| {
            let before = lasts[(k + lasts.len() - 1) % lasts.len()];
            let is_cut = last > 0 && columns[last - 1].0 == columns[last].0;
            is_cut.then(|| [before, last - 1, last])
        });
        for [a, b, c] in whole.chain(cut) {
            self.triangles
                .push([c, b, a].map(|column| number(0, column)));
            self.triangles
                .push([a, b, c].map(|column| number(top, column)));
        }
    }
}

impl PlateMesh {
    /// Returns the mesh between rings of as many places each, from the lowest to the highest. Places fall together where a
    /// corner is not cut off.
    fn between(rings: impl IntoIterator<Item = Vec<Vector3<f64>>>) -> Self {
        let mut mesh = Self::default();
        let rings: Vec<Vec<u32>> = rings
            .into_iter()
            .map(|ring| ring.into_iter().map(|at| mesh.vertex(at)).collect())
            .collect();
        for pair in rings.windows(2) {
            let [lower, upper] = [&pair[0], &pair[1]];
            let next = |k: usize| (k + 1) % lower.len();
            for k in 0..lower.len() {
                let [a, b, c, d] = [lower[k], lower[next(k)], upper[next(k)], upper[k]];
                mesh.triangle([a, b, c]);
                mesh.triangle([a, c, d]);
            }
        }
        if let [lowest, .., highest] = &rings[..] {
            for [a, b, c] in mesh.cap(lowest) {
                mesh.triangle([c, b, a]);
            }
            for corners in mesh.cap(highest) {
                mesh.triangle(corners);
            }
        }
        mesh
    }

    /// Returns the triangles of a flat ring of vertices, counter-clockwise seen from above.
    fn cap(&self, ring: &[u32]) -> Vec<[u32; 3]> {
        let ring = without_repeats(ring.to_vec());
        let places: Vec<Vector2<f64>> = ring
            .iter()
            .map(|&k| self.vertices[k as usize].xy())
            .collect();
        let triangles = triangulate(&places).unwrap_or_default();
        triangles
            .into_iter()
            .map(|corners| corners.map(|k| ring[k]))
            .collect()
    }
}
