//! Writes binary glTF 2.0: a path as an animation that any glTF viewer plays.
//!
//! The sheet is one mesh whose vertices move on straight lines from shape to shape. The first shape is the mesh, each
//! further shape is a morph target, and the animation blends from one to the next. Panels as nodes or bones would turn
//! without any error, but viewers draw thousands of nodes slowly, many viewers limit a mesh to 256 bones, and panels
//! that turn at constant rates separate along their edges between keys. A shape costs twelve bytes for each vertex. No
//! normals are written: a viewer then has to shade each panel flat.
//!
//! Plates are closed meshes over vertices of their own, with the edges of their faces as lines.
//!
//! The front of the paper, its back and its edges are three primitives over the same vertices, so that each has its own
//! colour. The sheet lies in x and y and is seen from its front, as viewers look along -z.
//!
//! Source: Khronos Group, "glTF 2.0 Specification", sections 3.7.2 (morph targets), 3.11 (animations) and 4.4 (binary
//! files). The JSON is written directly, because the types of a crate would take more lines.

use std::path::Path;

use nalgebra::Vector3;
use serde_json::{Value, json};

use super::stl::plates_of;
use super::{Export, Made, Sink, single};
use crate::folding::{STEP, shapes_with};
use crate::motion::Motion;
use crate::pattern::{FaceId, Unit, VertexId};
use crate::read::FileError;

/// Base colours: linear, opaque.
const FRONT: [f32; 4] = [0.95, 0.92, 0.85, 1.0];
const BACK: [f32; 4] = [0.35, 0.45, 0.62, 1.0];
const EDGES: [f32; 4] = [0.02, 0.02, 0.02, 1.0];

/// Enumeration values defined by the glTF specification.
const FLOAT: u32 = 5126;
const UNSIGNED_INT: u32 = 5125;
const VERTICES: u32 = 34962;
const INDICES: u32 = 34963;
const LINES: u32 = 1;
const TRIANGLES: u32 = 4;

/// Makes the file. A viewer moves vertices on straight lines between frames, so that hinges may turn only a little from one
/// frame to the next.
pub(super) fn made(export: &Export<'_>, sink: &mut Sink<'_>) -> Result<Made, FileError> {
    let motion = export.motion()?;
    let frames = export.resampled()?;
    let frames = frames.unwrap_or_else(|| motion.with_steps(STEP));
    // Lengths of glTF are metres.
    let frames = frames.in_unit(Unit::Metre).unwrap_or(frames);
    let faces = motion.pattern.faces().len();
    sink("", content(&frames, export.name)?)?;
    let frames = frames.knots.len();
    let what = if motion.plates.is_some() {
        ", as plates"
    } else {
        ""
    };
    Ok(Made::told(format!("{frames} frames, {faces} faces{what}")))
}

/// Returns the bytes of a .glb file with the shapes of a path at its knots.
///
/// # Errors
/// If the file would be 4 GiB or longer, or if a coordinate does not fit single precision.
pub fn content(motion: &Motion, file: &Path) -> Result<Vec<u8>, FileError> {
    let pattern = &motion.pattern;
    let plates = motion.plates.map(|_| plates_of(motion, file)).transpose()?;
    let plates = plates.map(|plates| plates.sheet_mesh(pattern));
    let (front, back, edges): (Vec<u32>, Vec<u32>, Vec<u32>) = match &plates {
        None => {
            let triangles = pattern.triangles().items().iter();
            let front: Vec<u32> = triangles.flatten().map(|v| v.0).collect();
            let back = front.chunks(3).flat_map(|t| [t[0], t[2], t[1]]).collect();
            let edges = pattern.edges().iter().flat_map(|e| e.ends.map(|v| v.0));
            (front, back, edges.collect())
        }
        Some(mesh) => {
            let first = VertexId::new(pattern.vertices().len()).0;
            let numbers = |list: &[u32]| list.iter().map(|k| first + k).collect();
            let triangles = mesh.triangles.as_flattened();
            (
                numbers(triangles),
                Vec::new(),
                numbers(mesh.edges.as_flattened()),
            )
        }
    };
    let plates = plates.map(|mesh| mesh.vertices).unwrap_or_default();
    let points = pattern.vertices().len() + plates.len();
    let [knots, points] = [motion.knots.len(), points].map(|n| n as u64);
    let indices = (front.len() + back.len() + edges.len()) as u64;
    fits(4 * (knots * (3 * points + knots) + indices), file)?;

    let mut buffer = Buffer::default();
    let primitives = [(TRIANGLES, front), (TRIANGLES, back), (LINES, edges)];
    let primitives = (0..)
        .zip(primitives)
        .filter(|(_, (_, indices))| !indices.is_empty());
    let primitives: Vec<_> = primitives
        .map(|(material, (mode, indices))| (material, (mode, buffer.indices(&indices))))
        .collect();
    let (times, positions) = buffer.shapes(motion, &plates, file)?;
    let (base, targets) = positions.split_first().unwrap_or((&0, &[]));
    let targets = targets.iter().map(|target| json!({"POSITION": target}));
    let targets: Vec<Value> = targets.collect();
    let primitive = |(material, (mode, indices)): (usize, (u32, usize))| {
        let mut primitive = json!({
            "mode": mode, "indices": indices, "material": material, "attributes": {"POSITION": base},
        });
        if !targets.is_empty() {
            primitive["targets"] = json!(targets);
        }
        primitive
    };
    let material = |(name, colour): (&str, [f32; 4])| {
        json!({"name": name, "pbrMetallicRoughness": {
            "baseColorFactor": colour, "metallicFactor": 0.0, "roughnessFactor": 0.9,
        }})
    };
    let materials = [("front", FRONT), ("back", BACK), ("edges", EDGES)].map(material);
    let mut root = json!({
        "asset": {"version": "2.0", "generator": concat!("foldpath ", env!("CARGO_PKG_VERSION"))},
        "scene": 0,
        "scenes": [{"nodes": [0]}],
        "nodes": [{"mesh": 0, "name": motion.title}],
        "materials": materials,
        "meshes": [{"name": motion.title, "primitives": primitives.into_iter().map(primitive).collect::<Vec<_>>()}],
    });
    if !targets.is_empty() {
        let weights = buffer.steps(times.len());
        root["animations"] = json!([{
            "name": "fold",
            "samplers": [{"input": buffer.times(&times), "output": weights, "interpolation": "LINEAR"}],
            "channels": [{"sampler": 0, "target": {"node": 0, "path": "weights"}}],
        }]);
    }
    root["buffers"] = json!([{"byteLength": buffer.bytes.len()}]);
    root["bufferViews"] = json!(buffer.views);
    root["accessors"] = json!(buffer.accessors);
    let mut text = root.to_string().into_bytes();
    text.resize(text.len().next_multiple_of(4), b' ');
    packed(&text, &buffer.bytes, file)
}

/// Returns the displacement of each vertex from one shape to another, in single precision.
fn moves(
    from: &[Vector3<f64>],
    to: &[Vector3<f64>],
    file: &Path,
) -> Result<Vec<[f32; 3]>, FileError> {
    let moves = to
        .iter()
        .zip(from)
        .map(|(to, from)| (to - from).map(single).into());
    let moves: Vec<[f32; 3]> = moves.collect();
    match moves.iter().position(|p| p.iter().any(|x| !x.is_finite())) {
        None => Ok(moves),
        Some(vertex) => {
            let place = format!("vertices_coords[{vertex}]");
            let expected = "coordinates that single precision holds, for .glb";
            Err(FileError::expected(file, place, expected, "larger ones"))
        }
    }
}

/// Returns the length of a file or chunk as the 32-bit number that its header stores.
fn fits(length: u64, file: &Path) -> Result<u32, FileError> {
    u32::try_from(length).map_err(|_| {
        let expected = "vertices times frames that fit the 4 GiB of .glb";
        FileError::expected(file, "vertices_coords", expected, format!("{length} bytes"))
    })
}

/// Joins header, JSON chunk and binary chunk; each has a length that is a multiple of four bytes.
fn packed(text: &[u8], buffer: &[u8], file: &Path) -> Result<Vec<u8>, FileError> {
    let length = |bytes: usize| fits(bytes as u64, file).map(u32::to_le_bytes);
    let whole = 12 + 8 + text.len() + 8 + buffer.len();
    let mut bytes = Vec::with_capacity(whole);
    bytes.extend(b"glTF");
    bytes.extend(2_u32.to_le_bytes());
    bytes.extend(length(whole)?);
    for (kind, chunk) in [(b"JSON", text), (b"BIN\0", buffer)] {
        bytes.extend(length(chunk.len())?);
        bytes.extend(kind);
        bytes.extend(chunk);
    }
    Ok(bytes)
}

/// The binary buffer, with the buffer views and accessors that describe it in the JSON.
#[derive(Default)]
struct Buffer {
    bytes: Vec<u8>,
    views: Vec<Value>,
    accessors: Vec<Value>,
}

impl Buffer {
    /// Appends numbers to the buffer as a view with an accessor. Returns the index of the accessor.
    fn add(
        &mut self,
        numbers: impl Iterator<Item = [u8; 4]>,
        target: Option<u32>,
        mut accessor: Value,
    ) -> usize {
        let start = self.bytes.len();
        self.bytes.extend(numbers.flatten());
        let length = self.bytes.len() - start;
        let mut view = json!({"buffer": 0, "byteOffset": start, "byteLength": length});
        if let Some(target) = target {
            view["target"] = json!(target);
        }
        accessor["bufferView"] = json!(self.views.len());
        self.views.push(view);
        self.accessors.push(accessor);
        self.accessors.len() - 1
    }

    /// Adds the shapes of a path: the first by its places, every other by its displacements from the first. Returns the
    /// time of each shape and the index of its accessor.
    fn shapes(
        &mut self,
        motion: &Motion,
        points: &[(FaceId, Vector3<f64>)],
        file: &Path,
    ) -> Result<(Vec<f32>, Vec<usize>), FileError> {
        let (mut times, mut positions): (Vec<f32>, _) = (Vec::new(), Vec::new());
        let mut base = vec![Vector3::zeros(); motion.pattern.vertices().len() + points.len()];
        for (knot, shape) in motion.knots.iter().zip(shapes_with(motion, points)) {
            let time = single(knot.time - motion.knots[0].time);
            // Skips a shape whose time rounds to that of the shape before, as glTF requires strictly increasing times.
            if times.last().is_some_and(|last| time <= *last) {
                continue;
            }
            positions.push(self.points(&moves(&base, &shape, file)?));
            times.push(time);
            if times.len() == 1 {
                base = shape;
            }
        }
        Ok((times, positions))
    }

    fn indices(&mut self, indices: &[u32]) -> usize {
        self.add(
            indices.iter().map(|index| index.to_le_bytes()),
            Some(INDICES),
            json!({"componentType": UNSIGNED_INT, "type": "SCALAR", "count": indices.len()}),
        )
    }

    fn points(&mut self, points: &[[f32; 3]]) -> usize {
        let extreme = |pick: fn(f32, f32) -> f32| {
            let points = points.iter().copied();
            points.reduce(|a, b| [0, 1, 2].map(|axis| pick(a[axis], b[axis])))
        };
        self.add(
            points.as_flattened().iter().map(|x| x.to_le_bytes()),
            Some(VERTICES),
            json!({
                "componentType": FLOAT, "type": "VEC3", "count": points.len(),
                "min": extreme(f32::min), "max": extreme(f32::max),
            }),
        )
    }

    fn times(&mut self, times: &[f32]) -> usize {
        self.add(
            times.iter().map(|time| time.to_le_bytes()),
            None,
            json!({
                "componentType": FLOAT, "type": "SCALAR", "count": times.len(),
                "min": [times.first()], "max": [times.last()],
            }),
        )
    }

    /// Adds the weights of the morph targets at each of `shapes` shapes: all zero at the first shape, and at shape s a
    /// weight of 1 for target s alone.
    fn steps(&mut self, shapes: usize) -> usize {
        let weight = move |shape, target| if shape == target { 1.0_f32 } else { 0.0 };
        let rows = (0..shapes).flat_map(|s| (1..shapes).map(move |t| weight(s, t).to_le_bytes()));
        self.add(
            rows,
            None,
            json!({"componentType": FLOAT, "type": "SCALAR", "count": shapes * (shapes - 1)}),
        )
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_file_of_4_gib_is_refused() {
        assert_eq!(fits(u64::from(u32::MAX), Path::new("a")).unwrap(), u32::MAX);
        assert_eq!(
            fits(1 << 32, Path::new("a.fold")).unwrap_err().to_string(),
            "a.fold: vertices_coords: expected vertices times frames that fit the 4 GiB of .glb, \
             found 4294967296 bytes"
        );
    }
}
