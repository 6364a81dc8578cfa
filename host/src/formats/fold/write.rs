//! Writes crease patterns and paths as FOLD files.
//!
//! Each key, and in paths each frame, has one line: large files stay readable and can be compared line by line.

use std::io::{self, Write};

use serde::{Serialize, Serializer};

use super::animation::interpolation_name;
use crate::pattern::{CreasePattern, Drawing, Edge};
use crate::planner::{Knot, Path};

/// Writes keys and values of a FOLD object in order.
struct Object<'a, W: Write> {
    out: &'a mut W,
    /// Text to write before the next key.
    before: &'static str,
    between: &'static str,
}

impl<'a, W: Write> Object<'a, W> {
    fn new(out: &'a mut W, between: &'static str) -> Self {
        Self {
            out,
            before: "",
            between,
        }
    }

    fn key(&mut self, key: &str) -> io::Result<&mut W> {
        write!(self.out, "{}\"{key}\":", self.before)?;
        self.before = self.between;
        Ok(self.out)
    }

    fn set(&mut self, key: &str, value: &(impl Serialize + ?Sized)) -> io::Result<()> {
        Ok(serde_json::to_writer(self.key(key)?, value)?)
    }

    fn list(
        &mut self,
        key: &str,
        items: impl IntoIterator<Item = impl Serialize>,
    ) -> io::Result<()> {
        let mut json = serde_json::Serializer::new(self.key(key)?);
        Ok(json.collect_seq(items)?)
    }
}

/// Writes a file of one object, with one line for each key.
fn file<W: Write>(
    out: &mut W,
    keys: impl FnOnce(&mut Object<'_, W>) -> io::Result<()>,
) -> io::Result<()> {
    out.write_all(b"{\n")?;
    keys(&mut Object::new(out, ",\n"))?;
    out.write_all(b"\n}\n")
}

/// Returns as a text the bytes that `write` writes.
fn text(write: impl FnOnce(&mut Vec<u8>) -> io::Result<()>) -> String {
    let mut text = Vec::new();
    // Writing to memory cannot fail, and JSON is UTF-8.
    let _complete = write(&mut text);
    String::from_utf8(text).unwrap_or_default()
}

/// Converts radians to the degrees that are written: 180 for π, and no negative zero.
fn degrees(radians: f64) -> f64 {
    radians.to_degrees() + 0.0
}

/// Formats a crease pattern with its goal angles as a FOLD file.
#[must_use]
pub fn pattern_text(title: &str, drawing: &Drawing) -> String {
    text(|out| write_pattern(title, drawing, out))
}

/// Writes a crease pattern with its goal angles, and with its faces if they are known, as a FOLD file.
///
/// # Errors
/// The errors of `out`.
pub fn write_pattern(title: &str, drawing: &Drawing, out: &mut impl Write) -> io::Result<()> {
    let vertices = drawing.vertices.iter().map(|v| [v.x, v.y]);
    let edges = || drawing.edges.iter();
    let goals = edges().map(|e| e.goal.map_or(0.0, degrees));
    file(out, |file| {
        header(file, title, "singleModel")?;
        file.list("vertices_coords", vertices)?;
        file.list("edges_vertices", edges().map(|e| e.ends))?;
        file.list("edges_assignment", edges().map(|e| e.letter.code()))?;
        file.list("edges_foldAngle", goals)?;
        match &drawing.faces {
            Some(faces) => file.list("faces_vertices", faces),
            None => Ok(()),
        }
    })
}

fn header(file: &mut Object<'_, impl Write>, title: &str, class: &str) -> io::Result<()> {
    let creator = concat!("foldpath ", env!("CARGO_PKG_VERSION"));
    file.set("file_spec", &1.2)?;
    file.set("file_creator", creator)?;
    file.set("file_classes", &[class])?;
    file.set("file_title", title)?;
    file.set("frame_classes", &["creasePattern"])?;
    file.set("frame_attributes", &["2D"])
}

/// Writes paths of one sheet as FOLD animations.
pub struct PathWriter<'a> {
    /// The file's title.
    pub title: &'a str,
    /// The flat sheet.
    pub pattern: &'a CreasePattern,
    /// `true` to write the positions of the vertices at every knot.
    pub vertices: bool,
    /// The seed that the path was planned with.
    pub seed: u64,
    /// Speed that no hinge exceeds, radians per second.
    pub max_speed: f64,
    /// Acceleration that no hinge exceeds, radians per second squared, if it was limited.
    pub max_acceleration: Option<f64>,
}

impl PathWriter<'_> {
    /// Formats the path as a FOLD animation.
    #[must_use]
    pub fn text(&self, path: &Path) -> String {
        text(|out| self.write(path, out))
    }

    /// Writes the path as a FOLD animation.
    ///
    /// # Errors
    /// The errors of `out`.
    pub fn write(&self, path: &Path, out: &mut impl Write) -> io::Result<()> {
        let edges = || self.pattern.edges().iter();
        let vertices = self.pattern.vertices().iter().map(|v| [v.x, v.y]);
        let faces = self.pattern.faces().iter();
        let faces = faces.map(|f| f.iter().map(|v| v.0).collect::<Vec<_>>());
        let membership = |e: &Edge| Some(path.memberships[e.crease?.index()]);
        let groups = edges().map(|e| membership(e).map(|m| m.group.0));
        let signs = edges().map(|e| membership(e).map_or(0, |m| if m.negative { -1 } else { 1 }));
        let turns: Vec<usize> = edges()
            .map(|e| membership(e).map_or(0, |m| 1 + 2 * m.group.index() + usize::from(m.negative)))
            .collect();
        file(out, |file| {
            header(file, self.title, "animation")?;
            file.list("vertices_coords", vertices)?;
            file.list("edges_vertices", edges().map(|e| e.ends.map(|v| v.0)))?;
            file.list("edges_assignment", edges().map(|e| e.letter.code()))?;
            file.list("faces_vertices", faces)?;
            file.set(
                "foldpath:interpolation",
                interpolation_name(path.interpolation),
            )?;
            file.list("foldpath:edges_group", groups)?;
            file.list("foldpath:edges_sign", signs)?;
            file.set("foldpath:seed", &self.seed)?;
            file.set("foldpath:maxSpeed", &self.max_speed.to_degrees())?;
            let acceleration = self.max_acceleration.map(f64::to_degrees);
            file.set("foldpath:maxAcceleration", &acceleration)?;
            let inner = 1..path.knots.len().saturating_sub(1);
            let phases: Vec<_> = inner.filter(|&k| path.knots[k].ends_phase).collect();
            if !phases.is_empty() {
                file.list("foldpath:phases", phases)?;
            }
            let out = file.key("file_frames")?;
            let mut before = "[\n{";
            for knot in &path.knots {
                out.write_all(before.as_bytes())?;
                before = "},\n{";
                self.frame(knot, &turns, &mut Object::new(out, ","))?;
            }
            out.write_all(if path.knots.is_empty() {
                b"[\n\n]"
            } else {
                b"}\n]"
            })
        })
    }

    fn frame(
        &self,
        knot: &Knot,
        turns: &[usize],
        frame: &mut Object<'_, impl Write>,
    ) -> io::Result<()> {
        frame.set("frame_classes", &["foldedForm"])?;
        frame.set("frame_parent", &0)?;
        frame.set("frame_inherit", &true)?;
        frame.set("foldpath:time", &knot.time)?;
        if self.vertices {
            // A frame without positions inherits those of the flat sheet, and the attribute 2D with them.
            frame.set("frame_attributes", &["3D"])?;
            let vertices = knot.vertices.iter().map(|v| [v.x, v.y, v.z]);
            frame.list("vertices_coords", vertices)?;
        }
        spread_angles(frame, "edges_foldAngle", &knot.angles, turns)?;
        spread_angles(frame, "foldpath:edges_foldAngleRate", &knot.rates, turns)?;
        if !knot.weights.is_empty() {
            let part = |part: usize| knot.weights.iter().map(move |weight| weight[part]);
            spread_numbers(frame, "foldpath:edges_weight", part(0), turns)?;
            spread_numbers(frame, "foldpath:edges_weightRate", part(1), turns)?;
        }
        frame.set("foldpath:deformation", &knot.deformation)?;
        frame.set("foldpath:gap", &knot.gap)?;
        frame.set("foldpath:closure", &knot.closure)?;
        frame.set("foldpath:clearance", &None::<f64>)
    }
}

/// Writes an angle or rate of each group (radians) as one number for each edge, in degrees and with the edge's sign.
fn spread_angles(
    frame: &mut Object<'_, impl Write>,
    key: &str,
    groups: &[f64],
    turns: &[usize],
) -> io::Result<()> {
    let both = groups.iter().flat_map(|&value| [value, -value]);
    let values = [0.0].into_iter().chain(both).map(degrees);
    spread(frame, key, values.map(Some), turns)
}

/// Writes a number of each group as one number for each edge, without regard to signs; null for edges in no group.
fn spread_numbers(
    frame: &mut Object<'_, impl Write>,
    key: &str,
    groups: impl Iterator<Item = f64>,
    turns: &[usize],
) -> io::Result<()> {
    let values = groups.flat_map(|value| [Some(value); 2]);
    spread(frame, key, [None].into_iter().chain(values), turns)
}

/// Writes one of the values for each edge; `turns` has the index of each edge's value. The first value belongs to edges
/// in no group. Two values follow for each group, the second for edges that turn against the group. Each value is
/// formatted only once.
fn spread(
    frame: &mut Object<'_, impl Write>,
    key: &str,
    values: impl Iterator<Item = Option<f64>>,
    turns: &[usize],
) -> io::Result<()> {
    let texts: Vec<_> = values
        .map(|value| serde_json::to_string(&value).map(|text| format!(",{text}")))
        .collect::<Result<_, _>>()?;
    let out = frame.key(key)?;
    out.write_all(b"[")?;
    for (index, &turn) in turns.iter().enumerate() {
        // The first entry has no comma before it.
        out.write_all(&texts[turn].as_bytes()[usize::from(index == 0)..])?;
    }
    out.write_all(b"]")
}
