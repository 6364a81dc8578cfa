//! One sheet, drawn in many ways: does it get one verdict? The way in which a drawing is written never changes what `plan`,
//! `check` and `info` say of it: a transform in the file, the numbers and the order of vertices and lines, a mirror image
//! with letters exchanged, scale, place and unit, and a turn before its coordinates are rounded to as many digits.

use core::f64::consts::PI;
use core::fmt::Write as _;
use core::time::Duration;
use std::path::Path;

use foldpath::check::{CheckOptions, check};
use foldpath::export::fold::motion_text;
use foldpath::pattern::{CreasePattern, Drawing, DrawnEdge, Letter};
use foldpath::planner::{Goal, Outcome, PlanOptions, forecast, plan};
use foldpath::progress::Watch;
use foldpath::read::parse_pattern;
use foldpath::symmetry::CreaseGroups;
use nalgebra::{Rotation2, Vector2};
use serde_json::json;

use super::Family;
use crate::meshes::renumbered;
use crate::{Random, path_file};

/// Number of decimals of a drawing; none for all digits.
type Decimals = Option<usize>;

/// A way to draw a sheet.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Way {
    /// As it is, in FOLD.
    AsItIs,
    /// In SVG, without a unit.
    Pixels,
    /// In SVG, in millimetres.
    Millimetres,
    /// In SVG, in a group that is turned, moved and scaled.
    Group,
    /// In CP, which has letters alone.
    Cp,
    /// In FOLD, with vertices and edges in another order, and edges from end to start.
    Renumbered,
    /// In FOLD, seen from the other side: mirrored, mountains and valleys exchanged.
    Mirrored,
    /// In FOLD, with all coordinates times 1000.
    Scaled,
    /// In FOLD, far from the origin.
    Shifted,
    /// In FOLD, turned by a quarter.
    QuarterTurned,
    /// In FOLD, turned by any angle before it is rounded.
    Turned,
    /// In SVG, in millimetres, turned by another angle before it is rounded, lines in another order.
    TurnedMillimetres,
}

impl Way {
    /// All ways; the others are compared with the first.
    pub const ALL: [Self; 12] = [
        Self::AsItIs,
        Self::Pixels,
        Self::Millimetres,
        Self::Group,
        Self::Cp,
        Self::Renumbered,
        Self::Mirrored,
        Self::Scaled,
        Self::Shifted,
        Self::QuarterTurned,
        Self::Turned,
        Self::TurnedMillimetres,
    ];

    /// Returns the name and the bytes of a file in which the sheet is drawn this way.
    fn file(
        self,
        sheet: &Drawing,
        decimals: Decimals,
        random: &mut Random,
    ) -> (&'static str, String) {
        let moved = |by: &dyn Fn(Vector2<f64>) -> Vector2<f64>| Drawing {
            vertices: sheet.vertices.iter().map(|at| by(*at)).collect(),
            ..sheet.clone()
        };
        let turned = |angle: f64| moved(&|at| Rotation2::new(angle) * at);
        match self {
            Self::AsItIs => ("sheet.fold", fold(sheet, decimals)),
            Self::Pixels => ("sheet.svg", svg(sheet, decimals, "", None)),
            Self::Millimetres => ("sheet.svg", svg(sheet, decimals, "mm", None)),
            Self::Group => {
                let group = "translate(12.5 -3) rotate(29) scale(1.7)";
                ("sheet.svg", svg(sheet, decimals, "mm", Some(group)))
            }
            Self::Cp => ("sheet.cp", cp(sheet, decimals)),
            Self::Renumbered => ("sheet.fold", fold(&renumbered(sheet, random), decimals)),
            Self::Mirrored => {
                let mut mirrored = moved(&|at| Vector2::new(-at.x, at.y));
                for edge in &mut mirrored.edges {
                    edge.letter = edge.letter.flipped();
                    edge.goal = edge.goal.map(|goal| -goal);
                }
                ("sheet.fold", fold(&mirrored, decimals))
            }
            Self::Scaled => {
                let scaled = rounded(sheet, decimals);
                let vertices = scaled.vertices.iter().map(|at| at * 1e3).collect();
                let decimals = decimals.map(|decimals| decimals.saturating_sub(3));
                (
                    "sheet.fold",
                    fold(&Drawing { vertices, ..scaled }, decimals),
                )
            }
            Self::Shifted => {
                let shifted = moved(&|at| at + Vector2::new(1e3, -2e4));
                ("sheet.fold", fold(&shifted, decimals))
            }
            Self::QuarterTurned => {
                let turned = moved(&|at| Vector2::new(-at.y, at.x));
                ("sheet.fold", fold(&turned, decimals))
            }
            Self::Turned => {
                let turned = turned(random.uniform(0.0, 2.0 * PI));
                ("sheet.fold", fold(&turned, decimals))
            }
            Self::TurnedMillimetres => {
                let turned = turned(random.uniform(0.0, 2.0 * PI));
                (
                    "sheet.svg",
                    svg(&renumbered(&turned, random), decimals, "mm", None),
                )
            }
        }
    }
}

/// Returns a number rounded to decimals.
fn to_decimals(x: f64, decimals: Decimals) -> f64 {
    decimals.map_or(x, |decimals| format!("{x:.decimals$}").parse().unwrap_or(x))
}

fn rounded(sheet: &Drawing, decimals: Decimals) -> Drawing {
    let vertices = sheet.vertices.iter();
    Drawing {
        vertices: vertices
            .map(|at| at.map(|x| to_decimals(x, decimals)))
            .collect(),
        ..sheet.clone()
    }
}

/// Writes a FOLD file without faces.
fn fold(sheet: &Drawing, decimals: Decimals) -> String {
    let sheet = rounded(sheet, decimals);
    let vertices: Vec<[f64; 2]> = sheet.vertices.iter().map(|at| [at.x, at.y]).collect();
    let edges = || sheet.edges.iter();
    let degrees = |edge: &DrawnEdge| {
        edge.goal
            .map(|goal| to_decimals(goal.to_degrees(), Some(ANGLE_DECIMALS)))
    };
    json!({
        "file_spec": 1.1,
        "vertices_coords": vertices,
        "edges_vertices": edges().map(|edge| edge.ends).collect::<Vec<_>>(),
        "edges_assignment": edges().map(|edge| edge.letter.code()).collect::<Vec<_>>(),
        "edges_foldAngle": edges().map(degrees).collect::<Vec<_>>(),
    })
    .to_string()
}

/// Decimals of goal angles in degrees.
const ANGLE_DECIMALS: usize = 9;

/// Writes an SVG drawing, angles as opacity. Other lines than borders, mountains and valleys have the colours of Origami
/// Simulator.
fn svg(sheet: &Drawing, decimals: Decimals, unit: &str, group: Option<&str>) -> String {
    let sheet = rounded(sheet, decimals);
    let mut text = format!(
        "<svg xmlns=\"http://www.w3.org/2000/svg\" width=\"100{unit}\" height=\"100{unit}\" viewBox=\"0 0 100 100\">\n"
    );
    if let Some(group) = group {
        let _ = writeln!(text, "<g transform=\"{group}\">");
    }
    for edge in &sheet.edges {
        let [a, b] = edge.ends.map(|end| sheet.vertices[end]);
        let colour = match edge.letter {
            Letter::Mountain => "#ff0000",
            Letter::Valley => "#0000ff",
            Letter::Flat | Letter::Join => "#ffff00",
            Letter::Unassigned => "#ff00ff",
            Letter::Cut => "#00ff00",
            _ => "#000000",
        };
        let opacity = edge.goal.map_or(1.0, |goal| goal.abs() / PI);
        let _ = writeln!(
            text,
            "<line x1=\"{}\" y1=\"{}\" x2=\"{}\" y2=\"{}\" stroke=\"{colour}\" stroke-opacity=\"{}\"/>",
            a.x,
            -a.y,
            b.x,
            -b.y,
            to_decimals(opacity, Some(ANGLE_DECIMALS + 2))
        );
    }
    if group.is_some() {
        text += "</g>\n";
    }
    text + "</svg>\n"
}

/// Largest ratio of the unit of rounded coordinates to the shortest edge. A crossing may be no deeper than a thousandth of
/// a face, so that rounding which is coarser than a face allows may decide.
const MAX_UNIT_RATIO: f64 = 1e-4;

/// Returns the number of decimals with which a sheet is drawn. A sheet that is rounded already is written with its own
/// digits, because a turn would add digits that say nothing. Returns `None` if they are too few.
fn decimals(sheet: &Drawing, random: &mut Random) -> Option<Decimals> {
    let more = [Some(0), Some(1), Some(2), Some(3), None][random.below(5)];
    let lengths = sheet.edges.iter().map(|edge| {
        let [a, b] = edge.ends.map(|end| sheet.vertices[end]);
        (b - a).norm()
    });
    let shortest = lengths.fold(f64::INFINITY, f64::min);
    let pattern = CreasePattern::new(sheet.clone()).ok()?;
    let own = pattern.precision().length.unit();
    let places = |unit: f64| {
        (0..18_usize)
            .find(|&places| 0.1_f64.powi(i32::try_from(places).unwrap_or(0)) <= 1.001 * unit)
    };
    let least = places(MAX_UNIT_RATIO * shortest)?;
    let asked = more.map(|more| least + more);
    if own <= 0.0 {
        return Some(asked);
    }
    let own = places(own).filter(|own| *own >= least)?;
    Some(Some(asked.map_or(own, |asked| asked.min(own))))
}

/// Number of decimals that the coordinates of a sheet, which are below 10, may have in SVG, which is read in single
/// precision; and if they are shifted by 20,000, in double precision.
const SINGLE_DECIMALS: usize = 6;
const SHIFTED_DECIMALS: usize = 8;

impl Way {
    /// Returns `true` if a file of this kind holds the sheet with this number of decimals.
    fn holds(self, sheet: &Drawing, decimals: Decimals) -> bool {
        let within = |most: usize| decimals.is_some_and(|decimals| decimals <= most);
        match self {
            Self::Pixels | Self::Millimetres | Self::Group | Self::TurnedMillimetres => {
                within(SINGLE_DECIMALS)
            }
            Self::Cp => sheet.edges.iter().all(|edge| match edge.letter {
                Letter::Mountain | Letter::Valley => edge
                    .goal
                    .is_none_or(|goal| goal.abs().to_bits() == PI.to_bits()),
                letter => letter == Letter::Boundary,
            }),
            Self::Shifted => decimals.is_none() || within(SHIFTED_DECIMALS),
            _ => true,
        }
    }
}

/// Writes a CP drawing.
fn cp(sheet: &Drawing, decimals: Decimals) -> String {
    let sheet = rounded(sheet, decimals);
    let lines = sheet.edges.iter().map(|edge| {
        let [a, b] = edge.ends.map(|end| sheet.vertices[end]);
        let kind = match edge.letter {
            Letter::Mountain => 2,
            Letter::Valley => 3,
            _ => 1,
        };
        format!("{kind} {} {} {} {}\n", a.x, -a.y, b.x, -b.y)
    });
    lines.collect()
}

/// Answers for a drawing.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Said {
    /// The outcome of `plan`.
    pub plan: &'static str,
    /// The outcome of `check` on the path that was found.
    pub check: &'static str,
    /// The verdict of `info`.
    pub info: &'static str,
}

/// Asks for the verdicts on a file. Returns `None` if a plan ran out of time, which says nothing of the drawing.
fn said((name, text): &(&str, String), timeout: Duration) -> Result<Option<Said>, String> {
    let file =
        parse_pattern(Path::new(name), text.as_bytes()).map_err(|error| error.to_string())?;
    let goal = Goal::of_pattern(&file.pattern).map_err(|error| error.to_string())?;
    let options = PlanOptions::default().with(|it| it.timeout = Some(timeout));
    let planned = plan(&file.pattern, &goal, &options);
    if planned.outcome == Outcome::Timeout {
        return Ok(None);
    }
    let checked = match &planned.motion {
        Some(motion) if planned.outcome == Outcome::Planned => {
            let path = path_file(&motion_text(motion)).map_err(|error| error.to_string())?;
            check(&path, &CheckOptions::default()).outcome().name()
        }
        _ => "",
    };
    let groups = CreaseGroups::find(&file.pattern);
    let foreseen = forecast(&file.pattern, &groups, Watch::default()).foldability;
    Ok(Some(Said {
        plan: planned.outcome.name(),
        check: checked,
        info: foreseen.name(),
    }))
}

/// Results for all sheets.
#[derive(Debug, Default)]
pub struct Drawn {
    /// Number of sheets.
    pub sheets: usize,
    /// Number of drawings that were compared.
    pub drawings: usize,
    /// Number of drawings whose plan ran out of time.
    pub late: usize,
    /// Number of sheets that were planned as they are.
    pub planned: usize,
    /// Differences, each with family, seed and way.
    pub differences: Vec<String>,
}

/// Returns the families that are drawn in many ways.
pub fn families() -> impl Iterator<Item = &'static Family> {
    Family::ALL
        .iter()
        .filter(|family| !family.large && !family.varied)
}

/// Draws `count` sheets of these families in all ways, and compares what is said of them. The sheets have seeds from `seed` on.
#[must_use]
pub fn run(families: &[&Family], seed: u64, count: usize, timeout: Duration) -> Drawn {
    let mut drawn = Drawn::default();
    for (number, family) in (seed..).zip(families.iter().cycle()) {
        if drawn.sheets == count {
            break;
        }
        let sheet = family.sheet(number);
        let mut random = Random::stream(number, 53);
        let Some(decimals) = decimals(&sheet, &mut random) else {
            continue;
        };
        drawn.sheets += 1;
        let mut first = None;
        for way in Way::ALL
            .into_iter()
            .filter(|way| way.holds(&sheet, decimals))
        {
            let file = way.file(&sheet, decimals, &mut random);
            let said = match said(&file, timeout) {
                Ok(None) => {
                    drawn.late += 1;
                    continue;
                }
                Ok(Some(said)) => Ok(said),
                // The places in errors are those of the drawing.
                Err(error) => Err(error.split(':').next().unwrap_or_default().to_string()),
            };
            drawn.drawings += 1;
            match &first {
                None => {
                    drawn.planned +=
                        usize::from(said.as_ref().is_ok_and(|said| said.plan == "planned"));
                    first = Some((way, said));
                }
                Some((other, first)) if *first != said => drawn.differences.push(format!(
                    "{} {number} with {decimals:?} decimals: {way:?} {said:?}, {other:?} {first:?}",
                    family.name
                )),
                Some(_) => {}
            }
        }
    }
    drawn
}
