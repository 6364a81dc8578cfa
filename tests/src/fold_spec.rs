//! Is a file valid by the FOLD 1.2 specification alone?
//!
//! Source: E. Demaine, J. Ku, R. Lang, "FOLD Specification (version 1.2)". Differs from the source in one point: the
//! specification sets the fold angle of an unassigned crease (U) to 0, but a motion turns it, and frames inherit the
//! assignment.

use std::collections::HashSet;

use nalgebra::Vector3;
use serde_json::{Map, Value, from_value};

type Object = Map<String, Value>;

const FILE_KEYS: [&str; 7] = [
    "file_spec",
    "file_creator",
    "file_author",
    "file_title",
    "file_description",
    "file_classes",
    "file_frames",
];
const FRAME_KEYS: [&str; 20] = [
    "frame_author",
    "frame_title",
    "frame_description",
    "frame_classes",
    "frame_attributes",
    "frame_unit",
    "vertices_coords",
    "vertices_vertices",
    "vertices_edges",
    "vertices_faces",
    "edges_vertices",
    "edges_faces",
    "edges_assignment",
    "edges_foldAngle",
    "edges_length",
    "faces_vertices",
    "faces_edges",
    "faces_faces",
    "faceOrders",
    "edgeOrders",
];
const CHILD_KEYS: [&str; 2] = ["frame_parent", "frame_inherit"];
const FILE_CLASSES: &str = "singleModel multiModel animation diagrams";
const FRAME_CLASSES: &str = "creasePattern foldedForm graph linkage";
const ATTRIBUTES: &str = "2D 3D abstract manifold nonManifold orientable nonOrientable selfTouching \
     nonSelfTouching selfIntersecting nonSelfIntersecting cuts noCuts joins noJoins convexFaces nonConvexFaces";
/// Largest difference of equal angles, degrees; files have enough digits for it.
const SAME_ANGLE: f64 = 1e-6;

/// Returns a description of every violation of the specification; none if the file is valid.
#[must_use]
pub fn violations(file: &Value) -> Vec<String> {
    let mut judge = Judge::default();
    let Some(file) = file.as_object() else {
        return vec!["the file is no object".into()];
    };
    judge.keys("the file", file, &[&FILE_KEYS, &FRAME_KEYS]);
    judge.metadata("the file", file);
    let spec = file.get("file_spec").and_then(Value::as_f64);
    judge.expect(spec.is_some_and(|v| [1.0, 1.1, 1.2].contains(&v)), || {
        "file_spec".into()
    });
    judge.names("file_classes", file.get("file_classes"), FILE_CLASSES);
    judge.frame("the key frame", file);
    let empty = Vec::new();
    let frames = file
        .get("file_frames")
        .map_or(Some(&empty), Value::as_array);
    judge.expect(frames.is_some(), || "file_frames is no array".into());
    for (index, frame) in frames.into_iter().flatten().enumerate() {
        let name = format!("file_frames[{index}]");
        let Some(own) = frame.as_object() else {
            judge.expect(false, || format!("{name} is no object"));
            continue;
        };
        judge.keys(&name, own, &[&FRAME_KEYS, &CHILD_KEYS]);
        judge.metadata(&name, own);
        match resolved(file, index + 1, 0) {
            Some(whole) => judge.frame(&name, &whole),
            None => judge.expect(false, || format!("{name}: frame_parent or frame_inherit")),
        }
    }
    judge.violations
}

/// Returns a frame with everything that it inherits; `None` if a parent does not exist, or if parents form a cycle.
fn resolved(file: &Object, frame: usize, depth: usize) -> Option<Object> {
    let frames = file.get("file_frames")?.as_array()?;
    if frame == 0 {
        let of_frame = |(key, _): &(&String, &Value)| !key.starts_with("file_");
        let own = file.iter().filter(of_frame);
        return Some(
            own.map(|(key, value)| (key.clone(), value.clone()))
                .collect(),
        );
    }
    let own = frames.get(frame - 1)?.as_object()?;
    let inherits = own
        .get("frame_inherit")
        .map_or(Some(false), Value::as_bool)?;
    let parent = own.get("frame_parent").map(Value::as_u64);
    let parent = match parent {
        Some(parent) => Some(usize::try_from(parent?).ok()?),
        None => None,
    };
    if parent.is_some_and(|parent| parent > frames.len()) || depth > frames.len() {
        return None;
    }
    let mut whole = Object::new();
    if inherits {
        whole = resolved(file, parent?, depth + 1)?;
    }
    whole.extend(own.clone());
    Some(whole)
}

#[derive(Default)]
struct Judge {
    violations: Vec<String>,
}

impl Judge {
    fn expect(&mut self, holds: bool, what: impl FnOnce() -> String) {
        if !holds {
            self.violations.push(what());
        }
    }

    /// Requires every key to be of the specification, or an extension, which has a colon.
    fn keys(&mut self, name: &str, object: &Object, known: &[&[&str]]) {
        for key in object.keys() {
            let known = known.iter().any(|keys| keys.contains(&key.as_str()));
            self.expect(known || key.contains(':'), || {
                format!("{name}: unknown key {key}")
            });
        }
    }

    fn metadata(&mut self, name: &str, object: &Object) {
        for (key, value) in object {
            let word = key.split_once('_').map_or("", |parts| parts.1);
            let text = ["creator", "author", "title", "description", "unit"].contains(&word);
            self.expect(!text || value.is_string(), || {
                format!("{name}: {key} is no text")
            });
        }
    }

    /// Requires a list of names, each of them known or with a colon.
    fn names(&mut self, name: &str, list: Option<&Value>, known: &str) {
        let known = |name: &str| known.split(' ').any(|k| k == name) || name.contains(':');
        let good = |value: &Value| value.as_str().is_some_and(known);
        let holds = list.is_none_or(|v| v.as_array().is_some_and(|v| v.iter().all(good)));
        self.expect(holds, || format!("{name}: {list:?}"));
    }

    /// Judges a frame with everything that it inherits.
    fn frame(&mut self, name: &str, frame: &Object) {
        self.names(
            &format!("{name}: frame_classes"),
            frame.get("frame_classes"),
            FRAME_CLASSES,
        );
        let attributes = frame.get("frame_attributes");
        self.names(&format!("{name}: frame_attributes"), attributes, ATTRIBUTES);
        let Some(mesh) = Mesh::of(frame) else {
            self.expect(false, || format!("{name}: a list of it is of another kind"));
            return;
        };
        for kind in ["vertices_", "edges_", "faces_"] {
            let lists = frame.iter().filter(|(key, _)| key.starts_with(kind));
            let lengths: HashSet<_> = lists.map(|(_, v)| v.as_array().map(Vec::len)).collect();
            let one = lengths.len() <= 1 && !lengths.contains(&None);
            self.expect(one, || format!("{name}: lengths of {kind}..."));
        }
        self.references(name, &mesh);
        if self.violations.is_empty() {
            let is = |list: &str, word: &str| {
                let list = frame.get(list).and_then(Value::as_array);
                list.is_some_and(|list| list.iter().any(|entry| entry == word))
            };
            self.angles(name, &mesh);
            self.faces(name, &mesh);
            self.places(name, &mesh, is("frame_classes", "creasePattern"), &|word| {
                is("frame_attributes", word)
            });
        }
    }

    fn references(&mut self, name: &str, mesh: &Mesh) {
        let [vertices, edges] = [mesh.coords.len(), mesh.edges.len()];
        let good = |&[a, b]: &[usize; 2]| a != b && a < vertices && b < vertices;
        self.expect(mesh.edges.iter().all(good), || {
            format!("{name}: edges_vertices")
        });
        let good = |face: &Vec<usize>| face.len() >= 3 && face.iter().all(|&v| v < vertices);
        self.expect(mesh.faces.iter().all(good), || {
            format!("{name}: faces_vertices")
        });
        let good = |letter: &String| letter.len() == 1 && "BMVFUCJ".contains(letter.as_str());
        self.expect(mesh.letters.iter().all(good), || {
            format!("{name}: edges_assignment")
        });
        for (key, length) in [
            ("letters", mesh.letters.len()),
            ("angles", mesh.angles.len()),
        ] {
            let fits = length == edges || length == 0;
            self.expect(fits, || format!("{name}: {length} {key} of {edges} edges"));
        }
    }

    /// Requires angles within half a turn, with the signs of their assignments.
    fn angles(&mut self, name: &str, mesh: &Mesh) {
        for (edge, &angle) in mesh.angles.iter().enumerate() {
            let in_range = (-180.0..=180.0).contains(&angle);
            let letter = mesh.letters.get(edge).map_or("U", String::as_str);
            let signed = match letter {
                "V" => angle >= 0.0,
                "M" => angle <= 0.0,
                "U" => true,
                _ => angle.abs() <= 0.0,
            };
            self.expect(in_range && signed, || {
                format!("{name}: edges_foldAngle[{edge}]: {angle} degrees of {letter}")
            });
        }
    }

    /// Requires that sides of faces are edges, that every edge has at most one face on either side, and as many faces
    /// as its assignment says.
    fn faces(&mut self, name: &str, mesh: &Mesh) {
        let mut sides = HashSet::new();
        let undirected = |[a, b]: [usize; 2]| [a.min(b), a.max(b)];
        let edges: HashSet<_> = mesh.edges.iter().copied().map(undirected).collect();
        self.expect(edges.len() == mesh.edges.len(), || {
            format!("{name}: an edge twice")
        });
        for side in mesh.faces.iter().flat_map(|face| crate::sheet::sides(face)) {
            let edge = edges.contains(&undirected(side));
            self.expect(edge, || {
                format!("{name}: side {side:?} of a face is no edge")
            });
            let first = sides.insert(side);
            self.expect(first, || format!("{name}: side {side:?} of two faces"));
        }
        if mesh.faces.is_empty() {
            return;
        }
        for (edge, (&[a, b], letter)) in mesh.edges.iter().zip(&mesh.letters).enumerate() {
            let faces = [[a, b], [b, a]]
                .iter()
                .filter(|side| sides.contains(*side))
                .count();
            let good = match letter.as_str() {
                "B" => faces <= 1,
                "C" => true,
                _ => faces == 2,
            };
            self.expect(good, || {
                format!("{name}: edge {edge}, {letter}, has {faces} faces")
            });
        }
    }

    /// Requires coordinates as the attributes say. Faces of a crease pattern must run counter-clockwise, and faces of a
    /// folded form must meet at the angles in the file.
    fn places(&mut self, name: &str, mesh: &Mesh, flat: bool, is: &dyn Fn(&str) -> bool) {
        let in_plane = mesh
            .coords
            .iter()
            .all(|p| p.get(2).is_none_or(|z| z.abs() <= 0.0));
        self.expect(in_plane || !is("2D"), || {
            format!("{name}: 2D, with a z other than 0")
        });
        let in_space = mesh.coords.iter().all(|p| p.len() == 3);
        self.expect(in_space || !is("3D"), || format!("{name}: 3D, without a z"));
        for (index, face) in mesh.faces.iter().enumerate().filter(|_| flat) {
            let area = mesh.normal(face)[2];
            self.expect(area > 0.0, || {
                format!("{name}: faces_vertices[{index}] is clockwise")
            });
        }
        for (edge, &[a, b]) in mesh.edges.iter().enumerate().filter(|_| is("3D")) {
            let along = |side: [usize; 2]| {
                let mut faces = mesh.faces.iter();
                faces.find(|face| crate::sheet::sides(face).any(|s| s == side))
            };
            let (Some(left), Some(right)) = (along([a, b]), along([b, a])) else {
                continue;
            };
            let (l, r) = (mesh.normal(left), mesh.normal(right));
            let way = Vector3::from(mesh.point(b)) - Vector3::from(mesh.point(a));
            let turn = r
                .cross(&l)
                .dot(&way.normalize())
                .atan2(r.dot(&l))
                .to_degrees();
            let written = mesh.angles.get(edge).copied().unwrap_or(turn);
            let off = (turn - written).rem_euclid(360.0);
            let off = off.min(360.0 - off);
            self.expect(off <= SAME_ANGLE, || {
                format!("{name}: edge {edge} is at {turn}, written {written} degrees")
            });
        }
    }
}

/// The lists of a frame; a list that is absent is empty.
struct Mesh {
    coords: Vec<Vec<f64>>,
    edges: Vec<[usize; 2]>,
    letters: Vec<String>,
    angles: Vec<f64>,
    faces: Vec<Vec<usize>>,
}

impl Mesh {
    fn of(frame: &Object) -> Option<Self> {
        let list = |key| {
            frame
                .get(key)
                .cloned()
                .unwrap_or_else(|| Value::Array(Vec::new()))
        };
        let mesh = Self {
            coords: from_value(list("vertices_coords")).ok()?,
            edges: from_value(list("edges_vertices")).ok()?,
            letters: from_value(list("edges_assignment")).ok()?,
            angles: from_value(list("edges_foldAngle")).ok()?,
            faces: from_value(list("faces_vertices")).ok()?,
        };
        let dimensions = mesh.coords.iter().all(|p| (2..=3).contains(&p.len()));
        dimensions.then_some(mesh)
    }

    fn point(&self, vertex: usize) -> [f64; 3] {
        let place = &self.coords[vertex];
        [place[0], place[1], place.get(2).copied().unwrap_or(0.0)]
    }

    /// Returns the normal of a face, with twice the area of the face as its length (Newell's method).
    fn normal(&self, face: &[usize]) -> Vector3<f64> {
        let point = |vertex| Vector3::from(self.point(vertex));
        let origin = point(face[0]);
        let sides = crate::sheet::sides(face);
        sides
            .map(|[a, b]| (point(a) - origin).cross(&(point(b) - origin)))
            .sum()
    }
}
