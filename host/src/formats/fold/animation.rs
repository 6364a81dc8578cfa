//! Reads a path: a FOLD animation whose key frame is the flat pattern and whose other frames are knots.

use std::path::Path;

use foldpath_core::{Curve, GroupId, Interpolation, Membership, Node};
use nalgebra::Vector3;

use super::document::{Document, Frame, Located};
use super::pattern::{goals, pattern_of, points};
use crate::formats::FileError;
use crate::pattern::{CreasePattern, EdgeId};
use crate::progress::Watch;

/// A path read from a file.
#[derive(Clone, Debug)]
pub struct PathFile {
    /// The file's title, or else its name.
    pub title: String,
    /// The flat sheet.
    pub pattern: CreasePattern,
    /// Interpolation between knots.
    pub interpolation: Interpolation,
    /// Crease group and sign of each edge, `None` for edges in no group; empty if the file names no groups.
    pub members: Vec<Option<Membership>>,
    /// Speed that no hinge exceeds, radians per second; `None` if the file names none, infinite if it allows any speed.
    pub max_speed: Option<f64>,
    /// Acceleration that no hinge exceeds, radians per second squared; `None` if the file names none, infinite if it
    /// allows any acceleration.
    pub max_acceleration: Option<f64>,
    /// The knots from start to goal.
    pub knots: Vec<PathKnot>,
    /// Numbers of the knots at which another phase of the motion begins, in increasing order, without the first and the
    /// last knot.
    pub phases: Vec<usize>,
}

impl PathFile {
    /// Returns for each crease group the first edge of the group with its group and sign.
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

    /// Returns the edges whose curves show the motion of the sheet: one edge of each crease group with its sign. If the
    /// file has no groups, returns every crease.
    #[must_use]
    pub fn curves_shown(&self) -> Vec<(EdgeId, Option<Membership>)> {
        if self.members.is_empty() {
            let creases = self.pattern.creases().iter();
            return creases.map(|&edge| (edge, None)).collect();
        }
        let leaders = self.leaders().into_iter().flatten();
        leaders.map(|(edge, member)| (edge, Some(member))).collect()
    }

    /// Returns `true` if the motion between knots depends on rates.
    #[must_use]
    pub fn uses_rates(&self) -> bool {
        self.interpolation != Interpolation::Linear
    }

    /// Returns the motion of an edge over the segment between a knot and the next, with parameter 0 at the first knot
    /// and 1 at the second. Returns `None` if there is no such segment.
    #[must_use]
    pub fn curve(&self, segment: usize, edge: EdgeId) -> Option<Curve<f64>> {
        let (from, to) = (self.knots.get(segment)?, self.knots.get(segment + 1)?);
        let nodes = [from, to].map(|knot| knot.node(edge));
        let span = to.time - from.time;
        Some(Curve::between(self.interpolation, span, nodes[0], nodes[1]))
    }

    /// Returns the motion of every edge in a segment; see [`curve`](Self::curve).
    fn curves(&self, segment: usize) -> impl Iterator<Item = Curve<f64>> {
        let edges = (0..self.pattern.edges().len()).map(EdgeId::new);
        edges.filter_map(move |edge| self.curve(segment, edge))
    }

    /// Returns the configuration of a segment at parameter `s`, 0 to 1, without rates and positions.
    fn between(&self, segment: usize, s: f64) -> PathKnot {
        let [from, to] = [segment, segment + 1].map(|index| self.knots[index].time);
        PathKnot {
            time: from + s * (to - from),
            fold_angles: self.curves(segment).map(|curve| curve.angle(s)).collect(),
            rates: None,
            weights: None,
            vertices: None,
            claims: [None; 3],
        }
    }

    /// Returns this path with its knots replaced by `count` configurations (at least two) of the motion, evenly spaced
    /// in time from the first knot to the last. A configuration that falls on a knot is a copy of that knot. A path of
    /// one knot stays unchanged.
    #[must_use]
    pub fn resampled(&self, count: usize) -> Self {
        let mut resampled = self.clone();
        let [first, .., last] = self.knots.as_slice() else {
            return resampled;
        };
        let count = count.max(2);
        #[allow(clippy::cast_precision_loss, reason = "of what fits in memory")]
        let place = |index: usize| index as f64 / (count - 1) as f64;
        let configuration = |index: usize| {
            let time = first.time + place(index) * (last.time - first.time);
            let after = self.knots.partition_point(|knot| knot.time <= time);
            let after = after.clamp(1, self.knots.len() - 1);
            let [a, b] = [&self.knots[after - 1], &self.knots[after]];
            let s = (time - a.time) / (b.time - a.time);
            if s <= 0.0 {
                a.clone()
            } else if s >= 1.0 {
                b.clone()
            } else {
                self.between(after - 1, s)
            }
        };
        resampled.knots = (0..count).map(configuration).collect();
        resampled
    }

    /// Returns this path with further configurations between its knots, without rates and positions, so that no hinge
    /// turns by much more than `step` (radians) from one configuration to the next.
    #[must_use]
    pub fn with_steps(&self, step: f64) -> Self {
        let mut knots: Vec<PathKnot> = self.knots.iter().take(1).cloned().collect();
        for (segment, pair) in self.knots.windows(2).enumerate() {
            let turned = |curve: Curve<f64>| {
                let parts = [0.0, 0.25, 0.5, 0.75, 1.0].map(|s| curve.angle(s));
                parts
                    .windows(2)
                    .map(|ends| (ends[1] - ends[0]).abs())
                    .sum::<f64>()
            };
            let most = self.curves(segment).map(turned).fold(0.0, f64::max);
            let parts = (most / step).ceil().clamp(1.0, MOST_STEPS);
            let mut part = 1.0;
            while part < parts {
                knots.push(self.between(segment, part / parts));
                part += 1.0;
            }
            knots.push(pair[1].clone());
        }
        Self {
            knots,
            phases: Vec::new(),
            ..self.clone()
        }
    }
}

/// Largest number of steps of a segment.
const MOST_STEPS: f64 = 1000.0;

/// One stored configuration.
#[derive(Clone, Debug, PartialEq)]
pub struct PathKnot {
    /// Seconds since the start; the number of the knot if the file names no times.
    pub time: f64,
    /// Fold angle of every edge, radians.
    pub fold_angles: Vec<f64>,
    /// Rate of every edge, radians per second, if the file has them.
    pub rates: Option<Vec<f64>>,
    /// Weight of the homogeneous half angle of every edge and its rate per second, in paths with that
    /// interpolation.
    pub weights: Option<Vec<[f64; 2]>>,
    /// Positions of the vertices, if the file has them.
    pub vertices: Option<Vec<Vector3<f64>>>,
    /// Deformation, gap and closure that the file claims for this knot.
    pub claims: [Option<f64>; 3],
}

impl PathKnot {
    /// Returns angle, rate and weight of an edge at this knot. The rate is 0 if the file has no rates, and the weight
    /// is 1 if it has no weights.
    ///
    /// # Panics
    /// If the sheet has no such edge.
    #[must_use]
    pub fn node(&self, edge: EdgeId) -> Node<f64> {
        let edge = edge.index();
        Node {
            angle: self.fold_angles[edge],
            rate: self.rates.as_ref().map_or(0.0, |rates| rates[edge]),
            weight: self.weights.as_ref().map_or([1.0, 0.0], |w| w[edge]),
        }
    }
}

/// Reads a path.
///
/// # Errors
/// If the file cannot be read, its key frame is no flat crease pattern, or a frame is no valid knot.
pub fn read_path(path: &Path) -> Result<PathFile, FileError> {
    path_of(&Document::read(path)?)
}

/// Parses a path from the bytes of a file; `path` names the file in errors. See [`read_path`].
///
/// # Errors
/// If the key frame is no flat crease pattern, or a frame is no valid knot.
pub fn parse_path(path: &Path, bytes: &[u8]) -> Result<PathFile, FileError> {
    path_of(&Document::parse(path, bytes)?)
}

fn path_of(document: &Document) -> Result<PathFile, FileError> {
    let key = document.key_frame();
    let pattern = pattern_of(document, &key, goals(&key)?.as_ref(), Watch::default())?;
    let frames = document.frames()?;
    if frames.len() == 0 {
        return Err(document.expected(
            "file_frames".into(),
            "at least one knot (of a path; `foldpath plan` makes one of a crease pattern)",
            "none",
        ));
    }
    let interpolation = interpolation(&key)?;
    // A knot must have its own lists: inherited lists could add up to many times the size of the file.
    let knots: Vec<PathKnot> = (0..frames.len())
        .map(|index| {
            let frame = frames.own(index + 1);
            knot(&frame, index, &pattern.pattern, interpolation)
        })
        .collect::<Result<_, _>>()?;
    for (index, pair) in knots.windows(2).enumerate() {
        if pair[0].time >= pair[1].time {
            let place = format!("file_frames[{}].foldpath:time", index + 1);
            let expected = format!("more than {} seconds", pair[0].time);
            return Err(document.expected(place, &expected, &pair[1].time.to_string()));
        }
    }
    let members = members(&key, pattern.pattern.edges().len())?;
    Ok(PathFile {
        interpolation,
        title: pattern.title,
        pattern: pattern.pattern,
        members,
        max_speed: rate_limit(&key, "foldpath:maxSpeed")?,
        max_acceleration: rate_limit(&key, "foldpath:maxAcceleration")?,
        phases: phases(&key, knots.len())?,
        knots,
    })
}

/// Returns the numbers of the knots at which another phase begins; none if the file names no phases.
fn phases(key: &Frame<'_>, knots: usize) -> Result<Vec<usize>, FileError> {
    let Some(list) = key.own("foldpath:phases") else {
        return Ok(Vec::new());
    };
    let mut before = 0;
    let phases = list.entries()?.map(|entry| {
        let knot = entry.index()?;
        if knot <= before || knot + 1 >= knots {
            return Err(
                entry.expected(&format!("a knot after number {before} and before the last"))
            );
        }
        before = knot;
        Ok(knot)
    });
    phases.collect()
}

/// Returns a limit on rates in radians, which the file has in degrees; infinite if it is null, `None` if it is missing.
fn rate_limit(key: &Frame<'_>, name: &'static str) -> Result<Option<f64>, FileError> {
    let Some(limit) = key.own(name) else {
        return Ok(None);
    };
    if limit.is_null() {
        return Ok(Some(f64::INFINITY));
    }
    let radians = limit.number()?.to_radians();
    if radians > 0.0 {
        Ok(Some(radians))
    } else {
        Err(limit.expected("a number above 0, or null for none"))
    }
}

/// Returns the name of an interpolation in files.
pub(crate) fn interpolation_name(kind: Interpolation) -> &'static str {
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
        Interpolation::Linear,
        Interpolation::Hermite,
        Interpolation::HalfAngle,
        Interpolation::Homogeneous,
    ];
    let text = name.text()?;
    let found = known
        .into_iter()
        .find(|kind| interpolation_name(*kind) == text);
    found.ok_or_else(|| name.expected("\"linear\", \"hermite\", \"half-angle\" or \"homogeneous\""))
}

/// Returns crease group and sign of each edge; empty if the file names no groups.
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
            // Group numbers are below the number of edges, so that the file's size bounds the memory allocated for
            // groups.
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

fn knot(
    frame: &Frame<'_>,
    index: usize,
    pattern: &CreasePattern,
    interpolation: Interpolation,
) -> Result<PathKnot, FileError> {
    let own = |key: &'static str| frame.own(key);
    let list = frame.require("edges_foldAngle")?;
    let edges = pattern.edges().len();
    let fold_angles = list.entries_of(edges, "edge")?.map(|entry| {
        let degrees = entry.number()?;
        if interpolation == Interpolation::HalfAngle && degrees.abs() >= 180.0 {
            return Err(entry.expected("less than half a turn, for \"half-angle\""));
        }
        Ok(degrees.to_radians())
    });
    let fold_angles = fold_angles.collect::<Result<_, _>>()?;
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
    Ok(PathKnot {
        rates: rates(frame, edges, interpolation)?,
        weights: weights(frame, pattern, interpolation)?,
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

/// Returns a list of a frame that the interpolation requires, or an error that describes the list as `what`.
fn needed<'a>(
    frame: &Frame<'a>,
    key: &'static str,
    what: &str,
    interpolation: Interpolation,
) -> Result<Located<'a>, FileError> {
    let expected = format!(
        "the {what} that \"{}\" needs",
        interpolation_name(interpolation)
    );
    frame.own(key).ok_or_else(|| frame.missing(key, &expected))
}

/// Reads the rate of every edge, radians per second. All interpolations but `"linear"` require rates.
fn rates(
    frame: &Frame<'_>,
    edges: usize,
    interpolation: Interpolation,
) -> Result<Option<Vec<f64>>, FileError> {
    let key = "foldpath:edges_foldAngleRate";
    let list = match interpolation {
        Interpolation::Linear => frame.own(key),
        _ => Some(needed(frame, key, "rates", interpolation)?),
    };
    let Some(list) = list else { return Ok(None) };
    let entries = list.entries_of(edges, "edge")?;
    let rates = entries.map(|entry| Ok(entry.number()?.to_radians()));
    Ok(Some(rates.collect::<Result<_, FileError>>()?))
}

/// Reads weight and rate of weight of every edge. Edges that are no hinge may have null instead.
fn weights(
    frame: &Frame<'_>,
    pattern: &CreasePattern,
    interpolation: Interpolation,
) -> Result<Option<Vec<[f64; 2]>>, FileError> {
    if interpolation != Interpolation::Homogeneous {
        return Ok(None);
    }
    let edges = pattern.edges();
    let list = |key, what| needed(frame, key, what, interpolation);
    let weights = list("foldpath:edges_weight", "weights")?;
    let rates = list("foldpath:edges_weightRate", "rates of weights")?;
    let weights = weights.entries_of(edges.len(), "edge")?;
    let pairs = weights
        .zip(rates.entries_of(edges.len(), "edge")?)
        .zip(edges);
    let pairs = pairs.map(|((weight, rate), edge)| {
        let silent = |entry: &Located<'_>| edge.crease.is_none() && entry.is_null();
        let number = |entry: &Located<'_>, null| {
            if silent(entry) {
                Ok(null)
            } else {
                entry.number()
            }
        };
        let value = number(&weight, 1.0)?;
        if value > 0.0 {
            Ok([value, number(&rate, 0.0)?])
        } else {
            Err(weight.expected("a number above 0"))
        }
    });
    Ok(Some(pairs.collect::<Result<_, FileError>>()?))
}
