//! Writes a path as a model of MuJoCo (MJCF) with a mesh file for each panel, which Drake loads as well.
//!
//! - A *panel* is a set of faces that are joined by edges that stay flat. It is a body.
//! - All bodies share the frame of the flat sheet, so that the sheet is flat where all joints are at 0.
//! - A spanning tree of the panels has a hinge joint for each of its creases, `crease_I` with the number I of the edge;
//!   its coordinate is the fold angle in radians, valley positive.
//! - Each crease off the tree is closed by two `connect` constraints at its ends.
//! - The hinges that drive the sheet near flat are in the tree wherever they can be, and have position actuators. If they
//!   are not known, every hinge of the tree has one.
//! - Meshes are the plates that the path was planned for, one for each convex part, smaller by 1e-5, or else thin slabs. Panels that share a
//!   vertex do not collide with each other, as the corners of slabs would touch.
//! - There is a keyframe for each knot, with the angles of the joints and of the actuators, and one named `start` a little
//!   off flat, where a sheet knows which way it folds.
//!
//! Lengths are in metres if the unit of the pattern is known, or else in units of the pattern.
//! Masses, stiffnesses and dampings are in proportion to the size of the sheet, so that the model behaves alike in any
//! unit of length. There is no gravity.
//!
//! Source: the MuJoCo documentation, "XML Reference".

use core::fmt::Write;
use std::collections::BTreeSet;
use std::path::Path;

use super::groups::drivers;
use super::mjcf_panels::{Joint, Panels};
use super::stl::plates_of;
use super::{Export, Made, Sink, escaped};
use crate::motion::Motion;
use crate::pattern::{CreasePattern, EdgeId, Unit, VertexId};
use crate::read::FileError;

/// Thickness of a panel, median edges.
const THICKNESS_EDGES: f64 = 0.002;
/// Stiffness of all actuators together over the moment of inertia of the sheet about its middle, per second squared. Each
/// has its share: an actuator that moves one panel of many would be too stiff for the time step otherwise.
const STIFFNESS_RATIO: f64 = 400.0;
/// Damping of all actuators together over the same moment, per second.
const ACTUATOR_DAMPING_RATIO: f64 = 40.0;
/// Damping of a hinge over the moment of inertia of a mean panel about an edge, per second.
const DAMPING_RATIO: f64 = 1.0;
/// Inertia that is added to a hinge over the moment of inertia of a mean panel about an edge.
const ARMATURE_RATIO: f64 = 0.1;
/// Part of the motion at which the keyframe `start` is.
const START_PART: f64 = 0.02;
/// Time step of the simulation, seconds.
const TIME_STEP_S: f64 = 0.001;

/// A model in several files.
#[derive(Clone, Debug)]
pub struct Model {
    /// Names and contents of the files; the first is `scene.xml`.
    pub files: Vec<(String, Vec<u8>)>,
    /// Number of panels.
    pub panels: usize,
    /// Number of hinge joints.
    pub joints: usize,
    /// Number of creases off the tree, each closed by two constraints.
    pub loops: usize,
    /// Edges of the hinges that have actuators.
    pub actuators: Vec<EdgeId>,
    /// `true` if the actuators are the hinges that drive the sheet near flat, `false` if these are not known.
    pub drivers_known: bool,
}

/// Makes the files.
pub(super) fn made(export: &Export<'_>, sink: &mut Sink<'_>) -> Result<Made, FileError> {
    let motion = export.motion()?;
    let metres = motion.in_unit(Unit::Metre);
    let metres = metres.as_ref().unwrap_or(motion);
    let model = made_of(metres, export.name, export.options.density)?;
    let driven = if model.drivers_known {
        "that drive the sheet near flat"
    } else {
        "of the tree, as it is not known which drive the sheet"
    };
    let lengths = lengths(motion.pattern.unit());
    let told = format!(
        "lengths in {lengths}, {} panels, {} hinge joints, {} loops, actuators on {} hinges {driven}",
        model.panels,
        model.joints,
        model.loops,
        model.actuators.len()
    );
    for (name, content) in model.files {
        sink(&name, content)?;
    }
    Ok(Made::told(told))
}

/// Makes the model of a motion.
///
/// # Errors
/// If the sheet has no area.
pub fn model(motion: &Motion, file: &Path) -> Result<Model, FileError> {
    made_of(motion, file, None)
}

/// Makes the model of a motion whose panels have this density, kilograms per cubic metre; `None` for masses in proportion to
/// the size of the sheet.
fn made_of(motion: &Motion, file: &Path, density: Option<f64>) -> Result<Model, FileError> {
    let pattern = &motion.pattern;
    let drivers = drivers(pattern);
    let panels = Panels::of(pattern, &drivers);
    let plates = motion.plates.map(|_| plates_of(motion, file)).transpose()?;
    let thickness = plates
        .as_ref()
        .map_or(THICKNESS_EDGES * pattern.median_edge(), |plates| {
            plates.options.thickness
        });
    let masses = Masses::of(pattern, panels.len(), thickness, density).ok_or_else(|| {
        FileError::expected(file, "faces_vertices", "a sheet with an area", "none")
    })?;
    let meshes = panels.meshes(pattern, plates.as_ref(), thickness / 2.0);
    let joints: Vec<EdgeId> = panels.joints().map(|joint| joint.edge).collect();
    let known: Vec<EdgeId> = joints
        .iter()
        .copied()
        .filter(|edge| drivers.contains(edge))
        .collect();
    let drivers_known = !known.is_empty();
    let actuators = if drivers_known { known } else { joints.clone() };
    let scene = scene(motion, (&panels, &meshes), &masses, &actuators);
    let mut files = vec![("scene.xml".to_string(), scene.into_bytes())];
    for (name, mesh) in meshes.into_iter().flatten() {
        files.push((format!("{name}.obj"), mesh.into_bytes()));
    }
    Ok(Model {
        files,
        panels: panels.len(),
        joints: joints.len(),
        loops: panels.loops.len(),
        actuators,
        drivers_known,
    })
}

/// Densities and moments of inertia that scale with the sheet. The sheet has mass 1 for each square of its median edge.
struct Masses {
    /// Mass for each volume.
    density: f64,
    /// Moment of inertia of a mean panel about an edge.
    panel: f64,
    /// Moment of inertia of the sheet about its middle.
    sheet: f64,
}

impl Masses {
    /// Returns the masses of a sheet of this thickness, of this density or else of mass 1 for each square of the median edge.
    fn of(
        pattern: &CreasePattern,
        panels: usize,
        thickness: f64,
        density: Option<f64>,
    ) -> Option<Self> {
        let edge = pattern.median_edge();
        let density = density.unwrap_or(1.0 / (edge * edge * thickness));
        let triangles = pattern.triangles().items().iter().map(|triangle| {
            let [a, b, c] = triangle.map(|v| pattern.vertices()[v.index()]);
            ((b - a).perp(&(c - a)).abs() / 2.0, (a + b + c) / 3.0)
        });
        let triangles: Vec<_> = triangles.collect();
        let area: f64 = triangles.iter().map(|(area, _)| area).sum();
        if area.is_nan() || area <= 0.0 {
            return None;
        }
        let middle = triangles
            .iter()
            .map(|(area, at)| at * *area)
            .sum::<nalgebra::Vector2<f64>>()
            / area;
        let moments = triangles
            .iter()
            .map(|(area, at)| area * (at - middle).norm_squared());
        let mass_of_area = density * thickness;
        #[allow(clippy::cast_precision_loss, reason = "of what fits in memory")]
        let panel_area = area / panels as f64;
        let panel = mass_of_area * panel_area * panel_area / 3.0;
        Some(Self {
            density,
            panel,
            sheet: panel + mass_of_area * moments.sum::<f64>(),
        })
    }
}

fn scene(
    motion: &Motion,
    (panels, meshes): (&Panels, &[Vec<(String, String)>]),
    masses: &Masses,
    actuators: &[EdgeId],
) -> String {
    let pattern = &motion.pattern;
    let mut text = head(&motion.title, motion.pattern.unit(), masses);
    // Writing to memory cannot fail.
    for (name, _) in meshes.iter().flatten() {
        let _complete = writeln!(text, "    <mesh name=\"{name}\" file=\"{name}.obj\"/>");
    }
    text += "  </asset>\n  <worldbody>\n";
    bodies(&mut text, pattern, (panels, meshes));
    text += "  </worldbody>\n  <contact>\n";
    for [a, b] in sharing_vertices(pattern, panels) {
        let [a, b] = [a, b].map(|panel| panels.name(panel));
        let _complete = writeln!(text, "    <exclude body1=\"{a}\" body2=\"{b}\"/>");
    }
    text += "  </contact>\n  <equality>\n";
    for joint in &panels.loops {
        let edge = joint.edge;
        let [a, b] = [joint.parent, joint.child].map(|panel| panels.name(panel));
        for (end, vertex) in ["start", "end"].into_iter().zip(pattern.edge(edge).ends) {
            let anchor = place(pattern, vertex);
            let _complete = writeln!(
                text,
                "    <connect name=\"crease_{edge}_{end}\" body1=\"{a}\" body2=\"{b}\" anchor=\"{anchor}\"/>"
            );
        }
    }
    text += "  </equality>\n  <actuator>\n";
    #[allow(clippy::cast_precision_loss, reason = "of what fits in memory")]
    let share = masses.sheet / actuators.len().max(1) as f64;
    let (kp, kv) = (STIFFNESS_RATIO * share, ACTUATOR_DAMPING_RATIO * share);
    for edge in actuators {
        let _complete = writeln!(
            text,
            "    <position name=\"drive_{edge}\" joint=\"crease_{edge}\" kp=\"{kp}\" kv=\"{kv}\"/>"
        );
    }
    text += "  </actuator>\n  <keyframe>\n";
    keyframes(&mut text, motion, panels, actuators);
    text + "  </keyframe>\n</mujoco>\n"
}

/// Describes the lengths of the model of a motion whose lengths have this unit.
fn lengths(unit: Option<Unit>) -> &'static str {
    match unit {
        Some(_) => "metres",
        None => "units of the pattern",
    }
}

/// Returns the beginning of the model up to its assets.
fn head(title: &str, unit: Option<Unit>, masses: &Masses) -> String {
    // Drake refuses a model without a name.
    let title = match title.trim() {
        "" => "sheet".into(),
        title => escaped(title),
    };
    format!(
        "<!-- Written by foldpath {}. Lengths are in {}, angles in radians, valley positive. -->\n\
         <mujoco model=\"{title}\">\n  \
         <compiler angle=\"radian\" autolimits=\"true\"/>\n  \
         <option timestep=\"{TIME_STEP_S}\" gravity=\"0 0 0\" integrator=\"implicitfast\"/>\n  \
         <size memory=\"1G\"/>\n  \
         <default>\n    \
         <joint type=\"hinge\" damping=\"{}\" armature=\"{}\"/>\n    \
         <geom type=\"mesh\" density=\"{}\"/>\n    \
         <equality solref=\"0.002 1\" solimp=\"0.99 0.9999 0.001\"/>\n  \
         </default>\n  <asset>\n",
        env!("CARGO_PKG_VERSION"),
        lengths(unit),
        DAMPING_RATIO * masses.panel,
        ARMATURE_RATIO * masses.panel,
        masses.density,
    )
}

/// Writes a keyframe for each knot, and one that is a little off flat.
fn keyframes(text: &mut String, motion: &Motion, panels: &Panels, actuators: &[EdgeId]) {
    let joints: Vec<EdgeId> = panels.joints().map(|joint| joint.edge).collect();
    let mut key = |name: &str, motion: &Motion, index: usize| {
        let angles = |edges: &[EdgeId]| {
            let angles = edges
                .iter()
                .map(|&edge| motion.node(index, edge).angle.to_string());
            angles.collect::<Vec<_>>().join(" ")
        };
        let _complete = writeln!(
            text,
            "    <key name=\"{name}\" time=\"{}\" qpos=\"{}\" ctrl=\"{}\"/>",
            motion.knots[index].time,
            angles(&joints),
            angles(actuators)
        );
    };
    for index in 0..motion.knots.len() {
        key(&format!("knot_{index}"), motion, index);
    }
    if let [first, .., last] = &motion.knots[..] {
        let time = first.time + START_PART * (last.time - first.time);
        key("start", &motion.at_times([time]), 0);
    }
}

/// Writes the bodies, each inside its parent, in the order of [`Panels::joints`].
fn bodies(
    text: &mut String,
    pattern: &CreasePattern,
    (panels, meshes): (&Panels, &[Vec<(String, String)>]),
) {
    let mut open: Vec<usize> = Vec::new();
    for &(panel, joint) in &panels.order {
        let parent = joint.map(|joint: Joint| joint.parent);
        while open.last().copied() != parent {
            if open.pop().is_none() {
                break;
            }
            let _complete = writeln!(text, "    {}</body>", "  ".repeat(open.len()));
        }
        let margin = "  ".repeat(open.len());
        let name = panels.name(panel);
        let _complete = writeln!(text, "    {margin}<body name=\"{name}\">");
        if let Some(joint) = joint {
            let (edge, pivot) = (joint.edge, place(pattern, joint.pivot));
            let axis = joint.axis;
            let _complete = writeln!(
                text,
                "      {margin}<joint name=\"crease_{edge}\" pos=\"{pivot}\" axis=\"{} {} 0\"/>",
                axis.x, axis.y
            );
        }
        for (mesh, _) in &meshes[panel] {
            let _complete = writeln!(
                text,
                "      {margin}<geom name=\"{mesh}\" mesh=\"{mesh}\"/>"
            );
        }
        open.push(panel);
    }
    while open.pop().is_some() {
        let _complete = writeln!(text, "    {}</body>", "  ".repeat(open.len()));
    }
}

/// Returns the pairs of panels that share a vertex, each pair once.
fn sharing_vertices(pattern: &CreasePattern, panels: &Panels) -> BTreeSet<[usize; 2]> {
    let mut pairs = BTreeSet::new();
    for corners in pattern.corners().iter() {
        let round: BTreeSet<usize> = corners
            .iter()
            .map(|face| panels.of_face[face.index()])
            .collect();
        for &a in &round {
            pairs.extend(round.range(a + 1..).map(|&b| [a, b]));
        }
    }
    pairs
}

/// Returns the place of a vertex in the flat sheet.
fn place(pattern: &CreasePattern, vertex: VertexId) -> String {
    let at = pattern.vertices()[vertex.index()];
    format!("{} {} 0", at.x, at.y)
}
