//! The table of pattern families: what `foldpath generate`, designs of a batch, Python and the browser make by name.

use serde_json::{Map, Value};

use super::error::RequestError;
use super::table::{OptionInfo, OptionValue, Shape};
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
#[derive(Clone, Copy, Debug, PartialEq)]
struct Parameters {
    rows: usize,
    columns: usize,
    /// Radians.
    angle: f64,
    fold: f64,
    letters: Letters,
}

/// Returns a parameter; one whose default is `null` has to be given.
const fn parameter(
    name: &'static str,
    text: &'static str,
    shape: Shape,
    default: fn() -> Value,
) -> OptionInfo {
    OptionInfo {
        name,
        text,
        shape,
        default,
        ..OptionInfo::EMPTY
    }
}

const fn rows(text: &'static str, default: fn() -> Value) -> OptionInfo {
    parameter("rows", text, usize::SHAPE, default)
}

const fn columns(text: &'static str, default: fn() -> Value) -> OptionInfo {
    OptionInfo {
        alias: "columns",
        ..parameter("cols", text, usize::SHAPE, default)
    }
}

const fn angle(text: &'static str, default: fn() -> Value) -> OptionInfo {
    parameter("angle", text, f64::SHAPE, default)
}

const fn fold(text: &'static str, default: fn() -> Value) -> OptionInfo {
    parameter("fold", text, f64::SHAPE, default)
}

const ROWS: OptionInfo = OptionInfo {
    is_required: true,
    ..rows("Number of rows", || Value::Null)
};
const COLUMNS: OptionInfo = OptionInfo {
    is_required: true,
    ..columns("Number of columns", || Value::Null)
};

/// Makes the table. A row has the family's text as documentation, its name and title, its parameters, its examples, and
/// how the drawing is made.
macro_rules! families {
    ($(
        $(#[doc = $text:literal])+
        $name:literal $title:literal: [$($parameter:expr),+], [$($example:literal),+] => $drawing:expr;
    )*) => {
        /// The families.
        pub const FAMILIES: &[FamilyInfo] = &[$(FamilyInfo {
            name: $name,
            title: $title,
            text: concat!($($text, "\n"),+),
            examples: &[$($example),+],
            parameters: &[$($parameter),+],
            drawing: $drawing,
        }),*];
    };
}

families! {
    /// Miura fold of rows x cols parallelograms with sides of length 1
    "miura" "Miura": [
        ROWS, COLUMNS,
        angle("Sector angle, degrees", || 60.0.into()),
        fold("Goal: fold angle of the zigzag creases, as a fraction of 180 degrees", || 0.9.into())
    ], ["--rows 11 --cols 11 -o miura.fold", "--rows 4 --cols 6 --angle 75 --fold 1 -o steep.fold"]
    => |it| Miura { rows: it.rows, columns: it.columns, sector_angle: it.angle, fold: it.fold }.drawing();

    /// Waterbomb tessellation on rows x cols unit squares; rows are counted round the tube
    "waterbomb" "Waterbomb": [
        ROWS, COLUMNS,
        fold("Goal: fold angle of the boundary lines, as a fraction of 180 degrees", || 0.5.into())
    ], ["--rows 8 --cols 10 -o waterbomb.fold", "--rows 4 --cols 6 --fold 0.3 -o wide.fold"]
    => |it| Waterbomb { rows: it.rows, columns: it.columns, fold: it.fold }.drawing();

    /// Yoshimura pattern on rows x cols cells with one diagonal each
    "yoshimura" "Yoshimura": [
        ROWS, COLUMNS,
        angle("Angle between diagonals and straight creases, degrees", || 30.0.into()),
        fold("Goal: fold angle of the straight creases, as a fraction of 180 degrees", || 0.25.into())
    ], ["--rows 4 --cols 4 -o yoshimura.fold", "--rows 6 --cols 8 --angle 20 --fold 0.2 -o boom.fold"]
    => |it| Yoshimura { rows: it.rows, columns: it.columns, angle: it.angle, fold: it.fold }.drawing();

    /// Slender parallelograms with one diagonal each, all creases valley; this sheet cannot fold
    "quad" "Quad": [
        rows("Number of rows", || 24.into()), columns("Number of columns", || 24.into()),
        fold("Goal: fold angle of the diagonals, as a fraction of 180 degrees", || 0.0675.into())
    ], ["-o quad.fold", "--rows 6 --cols 6 -o small-quad.fold"]
    => |it| Quad { rows: it.rows, columns: it.columns, fold: it.fold }.drawing();

    /// Square twists on rows x cols tiles; each tile mirrors its neighbours
    "square-twist" "Square twist": [
        rows("Number of rows", || 1.into()), columns("Number of columns", || 1.into()),
        angle("Angle between the sides of a square and its pleats, degrees", || 60.0.into()),
        parameter(
            "letters", "Letters with which the sheet folds, or with which it does not", Letters::SHAPE,
            || Letters::Foldable.json()
        ),
        fold(
            "Goal of foldable letters: fold angle of the creases that turn most, as a fraction of 180 degrees",
            || 0.5.into()
        )
    ], ["-o twist.fold", "--rows 2 --cols 2 --letters unfoldable -o locked.fold"]
    => |it| {
        let Parameters { rows, columns, angle, letters, fold } = *it;
        SquareTwist { rows, columns, angle, letters, fold }.drawing()
    };

    /// Ron Resch's triangular tessellation of rows x cols stars; its goal is closed to a plane
    "resch" "Resch": [
        rows("Number of rows", || 3.into()), columns("Number of columns", || 3.into())
    ], ["-o resch.fold", "--rows 2 --cols 4 -o strip.fold"]
    => |it| Resch { rows: it.rows, columns: it.columns }.drawing();

    /// Flat conical Kresling pattern: rows rings round a polygon of cols sides
    ///
    /// The goal closes, but no motion leads to it.
    "kresling" "Kresling": [
        rows("Number of rings", || 2.into()), columns("Number of sides of the polygon, even", || 6.into())
    ], ["-o kresling.fold", "--rows 1 --cols 8 -o ring.fold"]
    => |it| Kresling { rows: it.rows, columns: it.columns }.drawing();
}

/// A family with its parameters.
#[derive(Clone, Debug)]
pub struct Family {
    info: &'static FamilyInfo,
    parameters: Parameters,
}

impl Family {
    /// Returns the family with this name, with its defaults.
    ///
    /// # Errors
    /// If there is none.
    pub fn named(name: &str) -> Result<Self, RequestError> {
        let mut known = FAMILIES.iter();
        let Some(info) = known.find(|info| info.name == name) else {
            let names: Vec<&str> = FAMILIES.iter().map(|info| info.name).collect();
            let names = names.join(", ");
            let text = format!("family: expected one of {names}, found {name}");
            return Err(RequestError::Usage(text));
        };
        let mut family = Self {
            info,
            parameters: Parameters {
                rows: 0,
                columns: 0,
                angle: 0.0,
                fold: 0.0,
                letters: Letters::Foldable,
            },
        };
        for parameter in info.parameters.iter().filter(|info| !info.is_required) {
            family.set(parameter.name, &(parameter.default)())?;
        }
        Ok(family)
    }

    /// Returns the family of a JSON object such as `{"family": "miura", "rows": 3, "cols": 3}`. A parameter that is not
    /// there, or `null`, has its default.
    ///
    /// # Errors
    /// If there is no such family, a parameter is none of the family's, or one is missing that has no default.
    pub fn of(object: &Map<String, Value>) -> Result<Self, RequestError> {
        let name = object.get("family").and_then(Value::as_str);
        let mut family = Self::named(name.unwrap_or("none"))?;
        let given = object.iter().filter(|(name, _)| *name != "family");
        let mut missing: Vec<OptionInfo> = family.info.parameters.to_vec();
        missing.retain(|info| info.is_required);
        for (name, value) in given.filter(|(_, value)| !value.is_null()) {
            family.set(name, value)?;
            missing.retain(|info| !info.is_called(name));
        }
        match missing.first() {
            Some(missing) => Err(missing.refused("expected a value, found none")),
            None => Ok(family),
        }
    }

    /// Sets a parameter; see [`Request::set`](super::Request::set).
    ///
    /// # Errors
    /// If the family has no such parameter, or the value is of another kind.
    pub fn set(&mut self, name: &str, value: &Value) -> Result<(), RequestError> {
        let parameters = self.info.parameters;
        let Some(info) = parameters.iter().find(|info| info.is_called(name)) else {
            let known: Vec<&str> = parameters.iter().map(|info| info.name).collect();
            let known = known.join(", ");
            let problem = format!("expected one of the parameters {known}");
            return Err(RequestError::option(name, problem));
        };
        let it = &mut self.parameters;
        let set = match info.name {
            "rows" => OptionValue::read(value).map(|rows| it.rows = rows),
            "cols" => OptionValue::read(value).map(|columns| it.columns = columns),
            "angle" => OptionValue::read(value).map(|angle: f64| it.angle = angle.to_radians()),
            "fold" => OptionValue::read(value).map(|fold| it.fold = fold),
            _ => OptionValue::read(value).map(|letters| it.letters = letters),
        };
        set.map_err(|problem| info.refused(&problem))
    }

    /// Returns a title for people, such as `Miura 11x11`.
    #[must_use]
    pub fn title(&self) -> String {
        let Parameters { rows, columns, .. } = self.parameters;
        format!("{} {rows}x{columns}", self.info.title)
    }

    /// Returns the drawing of the pattern.
    ///
    /// # Errors
    /// If a parameter is out of its range.
    pub fn drawing(&self) -> Result<Drawing, RequestError> {
        Ok((self.info.drawing)(&self.parameters)?)
    }
}
