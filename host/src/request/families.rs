//! The table of pattern families: what `foldpath generate`, designs of a batch, Python and the browser make by name.

use serde_json::{Map, Value};

use super::error::RequestError;
use super::table::{OptionInfo, OptionValue};
use crate::generate::{
    Kresling, Letters, Miura, ParameterError, Quad, Resch, SquareTwist, Waterbomb, Yoshimura,
};
use crate::pattern::Drawing;

/// A family of patterns: a row of the table.
#[derive(Clone, Copy, Debug)]
#[non_exhaustive]
pub struct FamilyInfo {
    /// Name, with `-` between its words.
    pub name: &'static str,
    /// Name in titles.
    pub title: &'static str,
    /// The first paragraph says what the sheet is.
    pub text: &'static str,
    /// Arguments of `foldpath generate NAME` that make examples.
    pub examples: &'static [&'static str],
    /// The parameters, in the units of the command line: degrees and fractions of a half turn.
    pub parameters: &'static [OptionInfo],
    drawing: fn(&Parameters) -> Result<Drawing, ParameterError>,
}

/// Values of the parameters of all families.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
struct Parameters {
    rows: usize,
    columns: usize,
    /// Radians.
    angle: f64,
    fold: f64,
    letters: Letters,
}

const ROWS: OptionInfo = OptionInfo::new("rows", usize::KIND);
const COLS: OptionInfo = OptionInfo {
    alias: "columns",
    ..OptionInfo::new("cols", usize::KIND)
};
const ANGLE: OptionInfo = OptionInfo::new("angle", f64::KIND);
const FOLD: OptionInfo = OptionInfo::new("fold", f64::KIND);
const LETTERS: OptionInfo = OptionInfo::new("letters", Letters::KIND);

/// Makes the table. A row has the family's text as documentation, its name and title, its parameters, of which those
/// without a default have to be given, its examples, and how the drawing is made.
macro_rules! families {
    ($(
        $(#[doc = $text:literal])+
        $name:literal $title:literal: [$($parameter:ident $about:literal $(= $default:expr)?),+], [$($example:literal),+]
        => $drawing:expr;
    )*) => {
        /// The families.
        pub const FAMILIES: &[FamilyInfo] = &[$(FamilyInfo {
            name: $name,
            title: $title,
            text: concat!($($text, "\n"),+),
            examples: &[$($example),+],
            parameters: &[$(OptionInfo { text: $about, $(default: || $default.into(),)? ..$parameter }),+],
            drawing: $drawing,
        }),*];
    };
}

families! {
    /// Miura fold of rows x cols parallelograms with sides of length 1
    "miura" "Miura": [
        ROWS "Number of rows", COLS "Number of columns", ANGLE "Sector angle, degrees" = 60.0,
        FOLD "Goal: fold angle of the zigzag creases, as a fraction of 180 degrees" = 0.9
    ], ["--rows 11 --cols 11 -o miura.fold", "--rows 4 --cols 6 --angle 75 --fold 1 -o steep.fold"]
    => |it| Miura { rows: it.rows, columns: it.columns, sector_angle: it.angle, fold: it.fold }.drawing();

    /// Waterbomb tessellation on rows x cols unit squares; rows are counted round the tube
    "waterbomb" "Waterbomb": [
        ROWS "Number of rows", COLS "Number of columns",
        FOLD "Goal: fold angle of the boundary lines, as a fraction of 180 degrees" = 0.5
    ], ["--rows 8 --cols 10 -o waterbomb.fold", "--rows 4 --cols 6 --fold 0.3 -o wide.fold"]
    => |it| Waterbomb { rows: it.rows, columns: it.columns, fold: it.fold }.drawing();

    /// Yoshimura pattern on rows x cols cells with one diagonal each
    "yoshimura" "Yoshimura": [
        ROWS "Number of rows", COLS "Number of columns",
        ANGLE "Angle between diagonals and straight creases, degrees" = 30.0,
        FOLD "Goal: fold angle of the straight creases, as a fraction of 180 degrees" = 0.25
    ], ["--rows 4 --cols 4 -o yoshimura.fold", "--rows 6 --cols 8 --angle 20 --fold 0.2 -o boom.fold"]
    => |it| Yoshimura { rows: it.rows, columns: it.columns, angle: it.angle, fold: it.fold }.drawing();

    /// Slender parallelograms with one diagonal each, all creases valley; this sheet cannot fold
    "quad" "Quad": [
        ROWS "Number of rows" = 24, COLS "Number of columns" = 24,
        FOLD "Goal: fold angle of the diagonals, as a fraction of 180 degrees" = 0.0675
    ], ["-o quad.fold", "--rows 6 --cols 6 -o small-quad.fold"]
    => |it| Quad { rows: it.rows, columns: it.columns, fold: it.fold }.drawing();

    /// Square twists on rows x cols tiles; each tile mirrors its neighbours
    "square-twist" "Square twist": [
        ROWS "Number of rows" = 1, COLS "Number of columns" = 1,
        ANGLE "Angle between the sides of a square and its pleats, degrees" = 60.0,
        LETTERS "Letters with which the sheet folds, or with which it does not" = "foldable",
        FOLD "Goal of foldable letters: fold angle of the creases that turn most, as a fraction of 180 degrees" = 0.5
    ], ["-o twist.fold", "--rows 2 --cols 2 --letters unfoldable -o locked.fold"]
    => |it| {
        let Parameters { rows, columns, angle, letters, fold } = *it;
        SquareTwist { rows, columns, angle, letters, fold }.drawing()
    };

    /// Ron Resch's triangular tessellation of rows x cols stars; its goal is closed to a plane
    "resch" "Resch": [ROWS "Number of rows" = 3, COLS "Number of columns" = 3],
    ["-o resch.fold", "--rows 2 --cols 4 -o strip.fold"]
    => |it| Resch { rows: it.rows, columns: it.columns }.drawing();

    /// Flat conical Kresling pattern: rows rings round a polygon of cols sides
    ///
    /// The goal closes, but no motion leads to it.
    "kresling" "Kresling": [ROWS "Number of rings" = 2, COLS "Number of sides of the polygon, even" = 6],
    ["-o kresling.fold", "--rows 1 --cols 8 -o ring.fold"]
    => |it| Kresling { rows: it.rows, columns: it.columns }.drawing();
}

impl Parameters {
    fn set(&mut self, info: &OptionInfo, value: &Value) -> Result<(), RequestError> {
        let set = match info.name {
            "rows" => OptionValue::read(value).map(|rows| self.rows = rows),
            "cols" => OptionValue::read(value).map(|columns| self.columns = columns),
            "angle" => OptionValue::read(value).map(|angle: f64| self.angle = angle.to_radians()),
            "fold" => OptionValue::read(value).map(|fold| self.fold = fold),
            _ => OptionValue::read(value).map(|letters| self.letters = letters),
        };
        set.map_err(|problem| info.refused(&problem))
    }
}

/// Returns title, such as `Miura 11x11`, and drawing of the pattern of a JSON object such as
/// `{"family": "miura", "rows": 3, "cols": 3}`. A parameter that is not there, or `null`, has its default.
///
/// # Errors
/// If there is no such family, a parameter is none of the family's or out of its range, or one is missing that has no
/// default.
pub fn generate(object: &Map<String, Value>) -> Result<(String, Drawing), RequestError> {
    let name = object
        .get("family")
        .and_then(Value::as_str)
        .unwrap_or("none");
    let Some(info) = FAMILIES.iter().find(|info| info.name == name) else {
        let names: Vec<&str> = FAMILIES.iter().map(|info| info.name).collect();
        let names = names.join(", ");
        let text = format!("family: expected one of {names}, found {name}");
        return Err(RequestError::Usage(text));
    };
    let mut parameters = Parameters::default();
    let mut missing = info.parameters.to_vec();
    for (name, value) in object.iter().filter(|(name, _)| *name != "family") {
        let called = |info: &&OptionInfo| [info.name, info.alias].contains(&name.as_str());
        match info.parameters.iter().find(called) {
            _ if value.is_null() => {}
            Some(parameter) => {
                parameters.set(parameter, value)?;
                missing.retain(|info| info.name != parameter.name);
            }
            None => {
                let known: Vec<&str> = info.parameters.iter().map(|info| info.name).collect();
                let problem = format!("expected one of the parameters {}", known.join(", "));
                return Err(RequestError::option(name, problem));
            }
        }
    }
    for parameter in &missing {
        match (parameter.default)() {
            Value::Null => return Err(parameter.refused("expected a value, found none")),
            value => parameters.set(parameter, &value)?,
        }
    }
    let Parameters { rows, columns, .. } = parameters;
    let title = format!("{} {rows}x{columns}", info.title);
    Ok((title, (info.drawing)(&parameters)?))
}
