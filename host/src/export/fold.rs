//! Writes crease patterns and motions as FOLD files.
//!
//! Each key, and in motions each frame, has one line: large files stay readable and can be compared line by line.

use std::io::{self, Write};

use serde::{Serialize, Serializer};

use crate::motion::{GroupNaming, Knot, Motion, interpolation_name};
use crate::pattern::{Drawing, Precision, Unit};

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
    text(|out| write_pattern(title, drawing, Precision::default(), None, out))
}

/// Writes a crease pattern with its goal angles, and with its faces if they are known, as a FOLD file. The file tells the
/// precision of its numbers if that is less than their digits say, and the unit of lengths if there is one.
///
/// # Errors
/// The errors of `out`.
pub fn write_pattern(
    title: &str,
    drawing: &Drawing,
    precision: Precision,
    unit: Option<Unit>,
    out: &mut impl Write,
) -> io::Result<()> {
    let vertices = drawing.vertices.iter().map(|v| [v.x, v.y]);
    let edges = || drawing.edges.iter();
    let goals = edges().map(|e| e.goal.map_or(0.0, degrees));
    file(out, |file| {
        header(file, title, "singleModel", unit)?;
        file.list("vertices_coords", vertices)?;
        file.list("edges_vertices", edges().map(|e| e.ends))?;
        file.list("edges_assignment", edges().map(|e| e.letter.code()))?;
        file.list("edges_foldAngle", goals)?;
        tell_precision(file, precision)?;
        match &drawing.faces {
            Some(faces) => file.list("faces_vertices", faces),
            None => Ok(()),
        }
    })
}

/// Writes the units of lengths and of angles in degrees, unless both are exact.
fn tell_precision(file: &mut Object<'_, impl Write>, precision: Precision) -> io::Result<()> {
    if precision == Precision::default() {
        return Ok(());
    }
    let Precision { length, angle } = precision;
    file.list("foldpath:precision", [length.unit(), degrees(angle.unit())])
}

fn header(
    file: &mut Object<'_, impl Write>,
    title: &str,
    class: &str,
    unit: Option<Unit>,
) -> io::Result<()> {
    let creator = concat!("foldpath ", env!("CARGO_PKG_VERSION"));
    file.set("file_spec", &1.2)?;
    file.set("file_creator", creator)?;
    file.set("file_classes", &[class])?;
    file.set("file_title", title)?;
    file.set("frame_classes", &["creasePattern"])?;
    file.set("frame_attributes", &["2D"])?;
    match unit {
        Some(unit) => file.set("frame_unit", unit.name()),
        None => Ok(()),
    }
}

/// Formats a motion as a FOLD animation.
#[must_use]
pub fn motion_text(motion: &Motion) -> String {
    text(|out| write_motion(motion, out))
}

/// Writes a motion as a FOLD animation: the key frame is the flat sheet, every other frame is a knot.
///
/// # Errors
/// The errors of `out`.
pub fn write_motion(motion: &Motion, out: &mut impl Write) -> io::Result<()> {
    let pattern = &motion.pattern;
    let edges = || pattern.edges().iter();
    let vertices = pattern.vertices().iter().map(|v| [v.x, v.y]);
    let named = || motion.named_members().iter();
    let groups = named().map(|member| member.map(|m| m.group.0));
    let signs = named().map(|member| member.map_or(0, |m| if m.negative { -1 } else { 1 }));
    let members = motion.members.iter();
    let turns: Vec<usize> = members
        .map(|member| member.map_or(0, |m| 1 + 2 * m.group.index() + usize::from(m.negative)))
        .collect();
    let limits = [
        ("foldpath:maxSpeed", motion.max_speed),
        ("foldpath:maxAcceleration", motion.max_acceleration),
    ];
    file(out, |file| {
        header(file, &motion.title, "animation", pattern.unit())?;
        file.list("vertices_coords", vertices)?;
        file.list("edges_vertices", edges().map(|e| e.ends))?;
        file.list("edges_assignment", edges().map(|e| e.letter.code()))?;
        file.list("faces_vertices", pattern.faces().iter())?;
        tell_precision(file, pattern.precision())?;
        file.set(
            "foldpath:interpolation",
            interpolation_name(motion.interpolation),
        )?;
        if motion.naming != GroupNaming::Unnamed {
            file.list("foldpath:edges_group", groups)?;
            file.list("foldpath:edges_sign", signs)?;
        }
        if let Some(seed) = motion.seed {
            file.set("foldpath:seed", &seed)?;
        }
        if let Some(answer) = &motion.answer {
            file.set("foldpath:outcome", &answer.outcome)?;
            file.set("foldpath:reached", &answer.reached)?;
            file.set("foldpath:bound", &answer.bound)?;
            file.set("foldpath:bend", &answer.bend.to_degrees())?;
        }
        for (key, limit) in limits {
            // JSON has no infinity: null stands for a limit that allows anything.
            if let Some(limit) = limit {
                file.set(key, &limit.to_degrees())?;
            }
        }
        if !motion.phases.is_empty() {
            file.list("foldpath:phases", &motion.phases)?;
        }
        if let Some(plates) = &motion.plates {
            file.set("foldpath:thickness", &plates.thickness)?;
            file.set("foldpath:hingePlane", &plates.hinge_plane)?;
            file.set("foldpath:panels", plates.sides.name())?;
            file.set("foldpath:panelGap", &plates.gap)?;
            file.set("foldpath:margin", &degrees(plates.margin))?;
            file.set("foldpath:cutsCorners", &plates.cuts_corners)?;
        }
        let out = file.key("file_frames")?;
        let mut before = "[\n{";
        for knot in &motion.knots {
            out.write_all(before.as_bytes())?;
            before = "},\n{";
            write_knot(knot, &turns, &mut Object::new(out, ","))?;
        }
        out.write_all(if motion.knots.is_empty() {
            b"[\n\n]"
        } else {
            b"}\n]"
        })
    })
}

fn write_knot(knot: &Knot, turns: &[usize], frame: &mut Object<'_, impl Write>) -> io::Result<()> {
    frame.set("frame_classes", &["foldedForm"])?;
    frame.set("frame_parent", &0)?;
    frame.set("frame_inherit", &true)?;
    frame.set("foldpath:time", &knot.time)?;
    if !knot.vertices.is_empty() {
        // A frame without positions inherits those of the flat sheet, and the attribute 2D with them.
        frame.set("frame_attributes", &["3D"])?;
        let vertices = knot.vertices.iter().map(|v| [v.x, v.y, v.z]);
        frame.list("vertices_coords", vertices)?;
    }
    spread_angles(frame, "edges_foldAngle", &knot.angles, turns)?;
    if !knot.rates.is_empty() {
        spread_angles(frame, "foldpath:edges_foldAngleRate", &knot.rates, turns)?;
    }
    if !knot.weights.is_empty() {
        let part = |part: usize| knot.weights.iter().map(move |weight| weight[part]);
        spread_numbers(frame, "foldpath:edges_weight", part(0), turns)?;
        spread_numbers(frame, "foldpath:edges_weightRate", part(1), turns)?;
    }
    frame.set("foldpath:deformation", &knot.claims.deformation)?;
    frame.set("foldpath:gap", &knot.claims.gap)?;
    frame.set("foldpath:closure", &knot.claims.closure)?;
    frame.set("foldpath:clearance", &knot.claims.clearance)
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
