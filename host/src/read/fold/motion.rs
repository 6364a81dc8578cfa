//! Reads a motion: a FOLD animation whose key frame is the flat pattern and whose other frames are knots.

use std::path::Path;
use std::sync::Arc;

use foldpath_core::{GroupId, Interpolation, Membership};
use nalgebra::Vector3;

use super::MAX_FILE_BYTES;
use super::document::{Document, Frame, Located};
use super::pattern::{PatternFile, goals, pattern_of, points};
use crate::motion::{
    Claims, GAP, GroupNaming, HINGE_PLANE, Knot, MARGIN_DEG, Motion, PlanAnswer, PlateOptions,
    PlateSides, THICKNESS, interpolation_name, leaders,
};
use crate::pattern::{CreasePattern, EdgeId};
use crate::progress::Watch;
use crate::read::{FileError, read_bytes};
use crate::util::range::Range;

/// The numbers of a frame, one for each edge.
struct EdgeKnot {
    /// Seconds since the start; the number of the knot if the file names no times.
    time: f64,
    /// Radians.
    angles: Vec<f64>,
    /// Radians per second, if the file has rates.
    rates: Option<Vec<f64>>,
    /// Weight of the homogeneous half angle and its rate per second, if the interpolation is homogeneous.
    weights: Option<Vec<[f64; 2]>>,
    /// Empty if the file has no positions.
    vertices: Vec<Vector3<f64>>,
    claims: Claims,
}

impl EdgeKnot {
    /// Returns `true` if an edge neither is folded nor turns.
    fn is_still(&self, edge: usize) -> bool {
        let rate = self.rates.as_ref().map_or(0.0, |rates| rates[edge]);
        self.angles[edge].abs() <= 0.0 && rate.abs() <= 0.0
    }

    /// Returns `true` if two edges turn exactly alike, or exactly against each other if `against` is set.
    fn turn_alike(&self, a: usize, b: usize, against: bool) -> bool {
        let sign = if against { -1.0 } else { 1.0 };
        let same = |a: f64, b: f64| (a - b).abs() <= 0.0;
        let rates = self.rates.as_ref();
        let weights = self.weights.as_ref();
        same(self.angles[a], sign * self.angles[b])
            && rates.is_none_or(|rates| same(rates[a], sign * rates[b]))
            && weights.is_none_or(|w| w[a].iter().zip(w[b]).all(|(&a, b)| same(a, b)))
    }

    /// Returns the knot of groups that turn as these edges do; `None` stands for a group without edges.
    fn of_groups(self, leaders: &[Option<(EdgeId, Membership)>]) -> Knot {
        let leaders = || leaders.iter();
        let of_groups = |numbers: &[f64]| -> Vec<f64> {
            let number =
                |(edge, member): &(EdgeId, Membership)| member.apply(numbers[edge.index()]);
            let groups = leaders().map(|leader| leader.as_ref().map_or(0.0, number));
            groups.collect()
        };
        let weights = self.weights.as_ref().map(|weights| {
            let weight = |leader: &Option<(EdgeId, _)>| {
                leader
                    .as_ref()
                    .map_or([1.0, 0.0], |(edge, _)| weights[edge.index()])
            };
            leaders().map(weight).collect()
        });
        Knot {
            time: self.time,
            angles: of_groups(&self.angles),
            rates: self.rates.as_deref().map(of_groups).unwrap_or_default(),
            weights: weights.unwrap_or_default(),
            vertices: self.vertices,
            claims: self.claims,
        }
    }
}

/// Reads a motion.
///
/// # Errors
/// If the file cannot be read, its key frame is no flat crease pattern, or a frame is no valid knot.
pub fn read_motion(path: &Path) -> Result<Motion, FileError> {
    parse_motion(path, &read_bytes(path, MAX_FILE_BYTES)?)
}

/// Parses a motion from the bytes of a file; `path` names the file in errors. See [`read_motion`].
///
/// # Errors
/// If the key frame is no flat crease pattern, or a frame is no valid knot.
pub fn parse_motion(path: &Path, bytes: &[u8]) -> Result<Motion, FileError> {
    let document = &Document::parse(path, bytes)?;
    let key = document.key_frame();
    let PatternFile { title, pattern } =
        pattern_of(document, &key, goals(&key)?.as_ref(), Watch::default())?;
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
    let knots: Vec<EdgeKnot> = (0..frames.len())
        .map(|index| {
            let frame = frames.own(index + 1);
            knot(&frame, index, &pattern, interpolation)
        })
        .collect::<Result<_, _>>()?;
    for (index, pair) in knots.windows(2).enumerate() {
        if pair[0].time >= pair[1].time {
            let place = format!("file_frames[{}].foldpath:time", index + 1);
            let expected = format!("more than {} seconds", pair[0].time);
            return Err(document.expected(place, &expected, &pair[1].time.to_string()));
        }
    }
    // Panels bend about the edges lettered J that turn.
    let turns = |edge: usize| !knots.iter().all(|knot| knot.is_still(edge));
    let turning: Vec<bool> = (0..pattern.edges().len()).map(turns).collect();
    let pattern = pattern.bent_along(&turning).unwrap_or(pattern);
    let named = named_members(&key, pattern.edges().len())?;
    let (members, naming) = match named {
        Some(named) if are_true(&named, &pattern, &knots) => (named, GroupNaming::Named),
        Some(named) => (
            own_groups(&pattern, &knots),
            GroupNaming::Contradicted(named),
        ),
        None => (own_groups(&pattern, &knots), GroupNaming::Unnamed),
    };
    let leaders = leaders(&members);
    Ok(Motion {
        title,
        pattern: Arc::new(pattern),
        members,
        naming,
        interpolation,
        max_speed: rate_limit(&key, "foldpath:maxSpeed")?,
        max_acceleration: rate_limit(&key, "foldpath:maxAcceleration")?,
        seed: seed(&key),
        answer: answer(&key)?,
        phases: phases(&key, knots.len())?,
        plates: plates(&key)?,
        knots: knots
            .into_iter()
            .map(|knot| knot.of_groups(&leaders))
            .collect(),
    })
}

/// Returns `true` if all edges of each named group turn exactly alike, and the edges without a group are no hinges and
/// stay flat.
fn are_true(named: &[Option<Membership>], pattern: &CreasePattern, knots: &[EdgeKnot]) -> bool {
    let leaders = leaders(named);
    let edges = pattern.edges().iter().zip(named).enumerate();
    edges.into_iter().all(|(edge, (data, member))| {
        let leader = member.and_then(|member| leaders[member.group.index()]);
        match (member, leader) {
            (Some(member), Some((leader, part))) => {
                let against = member.negative != part.negative;
                let mut knots = knots.iter();
                knots.all(|knot| knot.turn_alike(edge, leader.index(), against))
            }
            _ => data.crease.is_none() && knots.iter().all(|knot| knot.is_still(edge)),
        }
    })
}

/// Returns a group for each crease, and one for each other edge that does not stay flat.
fn own_groups(pattern: &CreasePattern, knots: &[EdgeKnot]) -> Vec<Option<Membership>> {
    let own = |group: usize| Membership {
        group: GroupId(EdgeId::new(group).0),
        negative: false,
    };
    let mut next = pattern.creases().len();
    let edges = pattern.edges().iter().enumerate();
    let members = edges.map(|(edge, data)| match data.crease {
        Some(crease) => Some(own(crease.index())),
        None if knots.iter().all(|knot| knot.is_still(edge)) => None,
        None => {
            next += 1;
            Some(own(next - 1))
        }
    });
    members.collect()
}

/// Returns the seed that the motion was planned with, if the file has one.
fn seed(key: &Frame<'_>) -> Option<u64> {
    let seed = key.own("foldpath:seed")?.index().ok()?;
    u64::try_from(seed).ok()
}

/// Returns the planner's answer, if the file has it.
fn answer(key: &Frame<'_>) -> Result<Option<PlanAnswer>, FileError> {
    let own = |name: &'static str| key.own(name);
    let (Some(outcome), Some(reached), Some(bound)) = (
        own("foldpath:outcome"),
        own("foldpath:reached"),
        own("foldpath:bound"),
    ) else {
        return Ok(None);
    };
    let (fraction, limit) = (reached.number()?, bound.number()?);
    if !(0.0..=1.0).contains(&fraction) {
        return Err(reached.expected("a fraction from 0 to 1"));
    }
    if limit <= 0.0 {
        return Err(bound.expected("a number above 0"));
    }
    let bend = own("foldpath:bend").map_or(Ok(0.0), |bend| {
        let degrees = bend.number()?;
        if (0.0..=180.0).contains(&degrees) {
            Ok(degrees.to_radians())
        } else {
            Err(bend.expected("degrees from 0 to 180"))
        }
    });
    Ok(Some(PlanAnswer {
        outcome: outcome.text()?.to_string(),
        reached: fraction,
        bound: limit,
        bend: bend?,
    }))
}

/// Returns the plates that the file names, if it names a thickness.
fn plates(key: &Frame<'_>) -> Result<Option<PlateOptions>, FileError> {
    let number = |name: &'static str, range: Range, default: f64| match key.own(name) {
        None => Ok(default),
        Some(entry) => {
            let number = entry.number()?;
            let is_good = range.contains(number);
            if is_good {
                Ok(number)
            } else {
                Err(entry.expected(&range.to_string()))
            }
        }
    };
    if key.own("foldpath:thickness").is_none() {
        return Ok(None);
    }
    let sides = key.own("foldpath:panels").map(|entry| {
        let name = entry.text()?;
        let sides = PlateSides::ALL
            .into_iter()
            .find(|sides| sides.name() == name);
        sides.ok_or_else(|| entry.expected("\"taper\" or \"inset\""))
    });
    let thickness = number("foldpath:thickness", THICKNESS, 0.0)?;
    let plates = PlateOptions::of_thickness(thickness);
    let [plane, gap] = [
        number("foldpath:hingePlane", HINGE_PLANE, plates.hinge_plane)?,
        number("foldpath:panelGap", GAP, plates.gap)?,
    ];
    let margin = number("foldpath:margin", MARGIN_DEG, 0.0)?.to_radians();
    let sides = sides.transpose()?.unwrap_or_default();
    let cuts = key
        .own("foldpath:cutsCorners")
        .map_or(Ok(false), |entry| entry.flag())?;
    Ok(Some(plates.with(|it| {
        (it.hinge_plane, it.gap, it.margin) = (plane, gap, margin);
        (it.sides, it.cuts_corners) = (sides, cuts);
    })))
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

/// Returns the group and sign that the file names for each edge; `None` if it names no groups.
fn named_members(
    key: &Frame<'_>,
    edges: usize,
) -> Result<Option<Vec<Option<Membership>>>, FileError> {
    let Some(groups) = key.own("foldpath:edges_group") else {
        return Ok(None);
    };
    let groups = groups.entries_of(edges, "edge")?;
    let signs = key.own("foldpath:edges_sign");
    let signs = signs
        .map(|signs| signs.entries_of(edges, "edge"))
        .transpose()?;
    // Groups without signs say that all hinges of a group turn by the same angle.
    let mut signs = signs.map(Iterator::fuse);
    let members = groups.map(|group| {
        let sign = signs.as_mut().and_then(Iterator::next);
        if group.is_null() {
            return Ok(None);
        }
        // Group numbers are below the number of edges, so that the file's size bounds the memory allocated for
        // groups.
        let index = group.index()?;
        let id = u32::try_from(index).ok().filter(|_| index < edges);
        let id = id.ok_or_else(|| group.expected(&format!("a group below {edges}")))?;
        let sign_value = sign.as_ref().map_or(Ok(1.0), Located::number)?;
        if let Some(sign) = sign
            && (sign_value.abs() - 1.0).abs() > 0.0
        {
            return Err(sign.expected("1 or -1"));
        }
        Ok(Some(Membership {
            group: GroupId(id),
            negative: sign_value < 0.0,
        }))
    });
    members.collect::<Result<_, FileError>>().map(Some)
}

fn knot(
    frame: &Frame<'_>,
    index: usize,
    pattern: &CreasePattern,
    interpolation: Interpolation,
) -> Result<EdgeKnot, FileError> {
    let own = |key: &'static str| frame.own(key);
    let list = frame.require("edges_foldAngle")?;
    let edges = pattern.edges().len();
    let angles = list.entries_of(edges, "edge")?.map(|entry| {
        let degrees = entry.number()?;
        if interpolation == Interpolation::HalfAngle && degrees.abs() >= 180.0 {
            return Err(entry.expected("less than half a turn, for \"half-angle\""));
        }
        Ok(degrees.to_radians())
    });
    let angles = angles.collect::<Result<_, _>>()?;
    let vertices = match own("vertices_coords") {
        Some(list) => {
            let _each_has_one = list.entries_of(pattern.vertices().len(), "vertex")?;
            points(frame)?
        }
        None => Vec::new(),
    };
    let number = |key: &'static str| {
        own(key)
            .filter(|v| !v.is_null())
            .map(|v| v.number())
            .transpose()
    };
    #[allow(clippy::cast_precision_loss, reason = "paths have few knots")]
    let default_time = index as f64;
    Ok(EdgeKnot {
        rates: rates(frame, edges, interpolation)?,
        weights: weights(frame, pattern, interpolation)?,
        time: number("foldpath:time")?.unwrap_or(default_time),
        angles,
        vertices,
        claims: Claims {
            deformation: number("foldpath:deformation")?,
            gap: number("foldpath:gap")?,
            closure: number("foldpath:closure")?,
            clearance: number("foldpath:clearance")?,
        },
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
