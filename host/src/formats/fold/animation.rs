//! Reads a path: a FOLD animation whose key frame is the flat pattern and whose frames are knots.

use std::path::Path;

use foldpath_core::{GroupId, Interpolation, Membership};
use nalgebra::Vector3;

use super::document::{Document, Frame, Located};
use super::pattern::{goals, pattern_of, points};
use crate::formats::FileError;
use crate::pattern::{CreasePattern, EdgeId};

/// A path as a file has it.
#[derive(Clone, Debug)]
pub struct PathFile {
    /// The file's title, or else its name.
    pub title: String,
    /// The flat sheet.
    pub pattern: CreasePattern,
    /// How the motion between knots is made.
    pub interpolation: Interpolation,
    /// For each edge its part in a crease group, `None` for none; empty if the file does not say.
    pub members: Vec<Option<Membership>>,
    /// The knots from start to goal.
    pub knots: Vec<PathKnot>,
}

impl PathFile {
    /// For each crease group an edge of it with its part in it.
    #[must_use]
    pub fn leaders(&self) -> Vec<Option<(EdgeId, Membership)>> {
        let indices = self.members.iter().flatten().map(|m| m.group.index());
        let mut leaders = vec![None; indices.max().map_or(0, |last| last + 1)];
        for (edge, member) in self.members.iter().enumerate() {
            if let Some(member) = *member {
                leaders[member.group.index()].get_or_insert((EdgeId::new(edge), member));
            }
        }
        leaders
    }
}

/// One stored configuration.
#[derive(Clone, Debug, PartialEq)]
pub struct PathKnot {
    /// Seconds since the start; the number of the knot if the file does not say.
    pub time: f64,
    /// Fold angle of every edge, radians.
    pub fold_angles: Vec<f64>,
    /// Rate of every edge, radians per second, if the file has them.
    pub rates: Option<Vec<f64>>,
    /// Positions of the vertices, if the file has them.
    pub vertices: Option<Vec<Vector3<f64>>>,
    /// Deformation, gap and closure that the file claims.
    pub claims: [Option<f64>; 3],
}

/// Reads a path.
///
/// # Errors
/// If the file cannot be read, its key frame is no flat crease pattern, or a frame is no knot.
pub fn read_path(path: &Path) -> Result<PathFile, FileError> {
    let document = Document::read(path)?;
    let key = document.key_frame();
    let pattern = pattern_of(&document, &key, goals(&key)?)?;
    let frames = document.frames()?;
    if frames.len() == 0 {
        return Err(document.expected(
            "file_frames".into(),
            "at least one knot (of a path; `foldpath plan` makes one of a crease pattern)",
            "none",
        ));
    }
    let knots: Vec<PathKnot> = (0..frames.len())
        .map(|index| knot(&frames.get(index)?, index, &pattern.pattern))
        .collect::<Result<_, _>>()?;
    for (index, pair) in knots.windows(2).enumerate() {
        if pair[0].time >= pair[1].time {
            let place = format!("file_frames[{}].foldpath:time", index + 1);
            let expected = format!("more than {} seconds", pair[0].time);
            return Err(document.expected(place, &expected, &pair[1].time.to_string()));
        }
    }
    let interpolation = interpolation(&key)?;
    let missing = knots.iter().position(|knot| knot.rates.is_none());
    if let (Interpolation::Hermite, Some(index)) = (interpolation, missing) {
        let place = format!("file_frames[{index}].foldpath:edges_foldAngleRate");
        return Err(document.expected(place, "the rates that \"hermite\" needs", "nothing"));
    }
    let members = members(&key, pattern.pattern.edges().len())?;
    Ok(PathFile {
        interpolation,
        title: pattern.title,
        pattern: pattern.pattern,
        members,
        knots,
    })
}

/// The name of an interpolation in files.
pub(super) fn interpolation_name(kind: Interpolation) -> &'static str {
    match kind {
        Interpolation::Linear => "linear",
        Interpolation::Hermite => "hermite",
        Interpolation::HalfAngle => "half-angle",
        Interpolation::Homogeneous => "homogeneous",
    }
}

fn interpolation(key: &Frame<'_>) -> Result<Interpolation, FileError> {
    let Some(name) = key.own("foldpath:interpolation") else {
        return Ok(Interpolation::Linear);
    };
    let known = [
        Interpolation::Hermite,
        Interpolation::HalfAngle,
        Interpolation::Linear,
    ];
    let text = name.text()?;
    let found = known
        .into_iter()
        .find(|kind| interpolation_name(*kind) == text);
    found.ok_or_else(|| name.expected("\"hermite\", \"half-angle\" or \"linear\""))
}

/// For each edge its crease group and sign; empty if the file does not say.
fn members(key: &Frame<'_>, edges: usize) -> Result<Vec<Option<Membership>>, FileError> {
    let (Some(groups), Some(signs)) = (
        key.own("foldpath:edges_group"),
        key.own("foldpath:edges_sign"),
    ) else {
        return Ok(Vec::new());
    };
    let groups = groups.entries_of(edges, "edge")?;
    let members = groups.zip(signs.entries_of(edges, "edge")?);
    members
        .map(|(group, sign)| {
            if group.is_null() {
                return Ok(None);
            }
            // No more groups than edges: what is allocated for them is bounded by the file.
            let index = group.index()?;
            let id = u32::try_from(index).ok().filter(|_| index < edges);
            let id = id.ok_or_else(|| group.expected(&format!("a group below {edges}")))?;
            let sign_value = sign.number()?;
            if (sign_value.abs() - 1.0).abs() > 0.0 {
                return Err(sign.expected("1 or -1"));
            }
            Ok(Some(Membership {
                group: GroupId(id),
                negative: sign_value < 0.0,
            }))
        })
        .collect()
}

fn knot(frame: &Frame<'_>, index: usize, pattern: &CreasePattern) -> Result<PathKnot, FileError> {
    let edges = pattern.edges().len();
    let own = |key: &'static str| frame.own(key);
    let list = frame.own("edges_foldAngle");
    let list = list.map_or_else(|| frame.require("edges_foldAngle"), Ok)?;
    let radians = |entry: Located<'_>| entry.number().map(f64::to_radians);
    let fold_angles = list
        .entries_of(edges, "edge")?
        .map(radians)
        .collect::<Result<_, _>>()?;
    let vertices = match own("vertices_coords") {
        Some(list) => {
            let _each_has_one = list.entries_of(pattern.vertices().len(), "vertex")?;
            Some(points(frame)?)
        }
        None => None,
    };
    let number = |key: &'static str| {
        own(key)
            .filter(|v| !v.is_null())
            .map(|v| v.number())
            .transpose()
    };
    #[allow(clippy::cast_precision_loss, reason = "paths have few knots")]
    let default_time = index as f64;
    let rates = match own("foldpath:edges_foldAngleRate") {
        Some(list) => Some(
            list.entries_of(edges, "edge")?
                .map(radians)
                .collect::<Result<_, _>>()?,
        ),
        None => None,
    };
    Ok(PathKnot {
        rates,
        time: number("foldpath:time")?.unwrap_or(default_time),
        fold_angles,
        vertices,
        claims: [
            number("foldpath:deformation")?,
            number("foldpath:gap")?,
            number("foldpath:closure")?,
        ],
    })
}
