//! Writes STL: the plates of a path for printers and mills, a file for each form, or all of them folded as at the end.
//!
//! Text STL, whose numbers have all their digits: binary files have single precision. Lengths are in millimetres if the unit
//! of the sheet is known, as programs that read STL expect, and otherwise in units of the sheet. Plates lie as in the flat
//! sheet, with their lower face below.

use core::fmt::Write;
use std::path::Path;

use nalgebra::{Rotation2, Vector2, Vector3};

use super::{Export, Made, Sink};
use crate::collision::{PlateMesh, Plates, Trims};
use crate::folding::FoldingMap;
use crate::motion::Motion;
use crate::pattern::Unit;
use crate::read::FileError;

/// Distance of corresponding points of plates that are equal, over the size of a plate.
const EQUAL_RATIO: f64 = 1e-9;

/// Note on a sheet without a unit.
pub(super) const UNKNOWN_UNIT: &str =
    "the unit of the sheet is not known: lengths are as they are drawn";

/// Makes the files.
pub(super) fn made(export: &Export<'_>, sink: &mut Sink<'_>) -> Result<Made, FileError> {
    let motion = in_millimetres(export.motion()?);
    let plates = plates_of(&motion, export.name)?;
    let unit = match motion.pattern.unit() {
        Some(_) => "millimetres",
        None => "units of the pattern",
    };
    let meshes: Vec<PlateMesh> = (0..plates.list.len())
        .map(|plate| plates.mesh(plate))
        .collect();
    let name = |plate: usize| format!("panel_{}", plates.list[plate].faces[0]);
    let mut made = if export.options.assembled {
        let pattern = &motion.pattern;
        let angles = motion.crease_angles(motion.knots.len() - 1);
        let map = FoldingMap::new(pattern, pattern.tree(), &angles);
        let mut text = String::new();
        for (plate, mesh) in meshes.iter().enumerate() {
            let pose = &map.poses()[plates.list[plate].faces[0].index()];
            solid(&mut text, &name(plate), mesh, |at| pose.carry(at));
        }
        sink("assembled.stl", text.into_bytes())?;
        Made::told(format!("{} plates as at the end of the path", meshes.len()))
    } else {
        let forms = forms(&plates, &meshes);
        let mut list = String::from("file,count,panels\n");
        for members in &forms {
            let file = format!("{}_x{}.stl", name(members[0]), members.len());
            let mut text = String::new();
            solid(&mut text, &name(members[0]), &meshes[members[0]], |at| *at);
            sink(&file, text.into_bytes())?;
            let panels: Vec<String> = (members.iter())
                .map(|&plate| plates.list[plate].faces[0].to_string())
                .collect();
            // Writing to memory cannot fail.
            let _complete = writeln!(list, "{file},{},{}", members.len(), panels.join(" "));
        }
        sink("panels.csv", list.into_bytes())?;
        Made::told(format!("{} plates in {} forms", meshes.len(), forms.len()))
    };
    made.told += &format!(", lengths in {unit}");
    if motion.pattern.unit().is_none() {
        made.notes.push(UNKNOWN_UNIT.into());
    }
    Ok(made)
}

/// Returns the motion with lengths in millimetres, if its unit is known.
fn in_millimetres(motion: &Motion) -> Motion {
    let scaled = motion.in_unit(Unit::Millimetre);
    scaled.unwrap_or_else(|| motion.clone())
}

/// Returns the plates of which a path says that its panels are made.
pub(super) fn plates_of(motion: &Motion, file: &Path) -> Result<Plates, FileError> {
    let options = motion.plates.ok_or_else(|| {
        let expected = "the thickness of plates (of a path; `foldpath plan --thickness` makes one)";
        FileError::expected(file, "foldpath:thickness", expected, "none")
    })?;
    let trims = Trims::of(motion, &options);
    Plates::new(&motion.pattern, &trims, &options).map_err(|error| {
        let expected = "plates that can be made";
        FileError::expected(file, "foldpath:thickness", expected, error.to_string())
    })
}

/// Adds a solid with its vertices at their images.
fn solid(
    text: &mut String,
    name: &str,
    mesh: &PlateMesh,
    image: impl Fn(&Vector3<f64>) -> Vector3<f64>,
) {
    // The sum turns -0 into 0.
    let line = |v: Vector3<f64>| format!("{} {} {}", v.x + 0.0, v.y + 0.0, v.z + 0.0);
    let places: Vec<Vector3<f64>> = mesh.vertices.iter().map(image).collect();
    let _complete = writeln!(text, "solid {name}");
    for triangle in &mesh.triangles {
        let [a, b, c] = triangle.map(|vertex| places[vertex as usize]);
        let normal = (b - a)
            .cross(&(c - a))
            .try_normalize(0.0)
            .unwrap_or_default();
        let _complete = writeln!(text, "facet normal {}\nouter loop", line(normal));
        for vertex in [a, b, c] {
            let _complete = writeln!(text, "vertex {}", line(vertex));
        }
        text.push_str("endloop\nendfacet\n");
    }
    let _complete = writeln!(text, "endsolid {name}");
}

/// Returns the plates in sets of equal ones, which a turn and a shift of the flat sheet take to each other.
fn forms(plates: &Plates, meshes: &[PlateMesh]) -> Vec<Vec<usize>> {
    let volumes: Vec<f64> = meshes.iter().map(PlateMesh::volume).collect();
    let mut forms: Vec<Vec<usize>> = Vec::new();
    for plate in 0..meshes.len() {
        let is_equal = |members: &&mut Vec<usize>| {
            let first = members[0];
            let near = (volumes[first] - volumes[plate]).abs() <= EQUAL_RATIO * volumes[plate];
            near && are_equal(plates, [first, plate])
        };
        match forms.iter_mut().find(is_equal) {
            Some(members) => members.push(plate),
            None => forms.push(vec![plate]),
        }
    }
    forms
}

/// Returns `true` if a turn and a shift of the flat sheet take the outlines of one plate to those of another.
fn are_equal(plates: &Plates, pair: [usize; 2]) -> bool {
    let [a, b] = pair.map(|plate| &plates.list[plate].outlines);
    let count = a[0].len();
    if count != b[0].len() {
        return false;
    }
    // The first side of the outline on the hinge plane tells the turn and the shift.
    let layer = plates.hinge_layer();
    let side = |outlines: &[Vec<[Vector2<f64>; 2]>], k: usize| {
        [
            outlines[layer][k % count][1],
            outlines[layer][(k + 1) % count][0],
        ]
    };
    let [from, to] = side(a, 0);
    let size = a[layer]
        .iter()
        .map(|[at, _]| (at - from).norm())
        .fold(0.0, f64::max);
    (0..count).any(|shift| {
        let [other_from, other_to] = side(b, shift);
        let turn = Rotation2::rotation_between(&(to - from), &(other_to - other_from));
        a.iter().zip(b).all(|(a, b)| {
            (0..count).all(|k| {
                let pairs = a[k].iter().zip(&b[(k + shift) % count]);
                pairs.into_iter().all(|(a, b)| {
                    let image = turn * (a - from) + other_from;
                    (image - b).norm() <= EQUAL_RATIO * size
                })
            })
        })
    })
}
