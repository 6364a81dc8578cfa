//! Types of values that have names, or name an edge with angles, and letters of colours.

use foldpath_core::{Interpolation, Objective};
use serde_json::Value;

use super::order::Order;
use super::table::{Kind, OptionValue, word};
use crate::export::csv::Column;
use crate::export::joint_trajectory::Joints;
use crate::export::svg_pattern::Colour;
use crate::generate::Letters;
use crate::motion::{HINGE_PLANE, PlateSides, THICKNESS};
use crate::pattern::{Letter, Unit};
use crate::planner::{Search, Solver, Symmetry, Timing, Vertices};
use crate::read::{ColourLetters, LayerLetters, Straighten};
use crate::unfold::Cut;

/// Something that is done or not.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Switch {
    /// It is done.
    #[default]
    On,
    /// It is not done.
    Off,
}

/// Data that each knot of a written path stores.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[non_exhaustive]
pub enum Frames {
    /// Fold angles and the positions of all vertices.
    #[default]
    Full,
    /// Fold angles alone.
    Angles,
}

/// Value `I=DEG` of `--crease`, an edge and its angle, or `I=MIN..MAX` of `--limit`, an edge and the range of its angle.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct EdgeAngles<const N: usize> {
    /// Number of the edge, from 0.
    pub edge: usize,
    /// The fold angle, or the smallest and the largest one, degrees; finite.
    pub degrees: [f64; N],
}

impl<const N: usize> OptionValue for EdgeAngles<N> {
    const KIND: Kind = if N == 1 {
        Kind::EdgeAngle
    } else {
        Kind::EdgeRange
    };

    fn read(value: &Value) -> Result<Self, String> {
        let expected = match N {
            1 => "I=DEG, the number of an edge and an angle in degrees",
            _ => "I=MIN..MAX, the number of an edge and two angles in degrees",
        };
        word(value, expected, |word| {
            let (edge, angles) = word.split_once('=')?;
            let finite = |text: &str| {
                text.trim()
                    .parse()
                    .ok()
                    .filter(|degrees: &f64| degrees.is_finite())
            };
            let degrees: Vec<f64> = angles.split("..").map(finite).collect::<Option<_>>()?;
            Some(Self {
                edge: edge.trim().parse().ok()?,
                degrees: degrees.try_into().ok()?,
            })
        })
    }

    fn json(&self) -> Value {
        let degrees = self.degrees.map(|degrees| degrees.to_string());
        format!("{}={}", self.edge, degrees.join("..")).into()
    }
}

/// Gives lists their form on the command line and in JSON. An error names the part of the text that is wrong.
macro_rules! lists {
    ($($Type:ty),*) => {
        $(impl OptionValue for $Type {
            const KIND: Kind = Kind::Text;

            fn read(value: &Value) -> Result<Self, String> {
                let list = value.as_str().unwrap_or_default().parse::<Self>();
                list.map_err(|error| error.to_string())
            }

            fn json(&self) -> Value {
                self.to_string().into()
            }
        })*
    };
}

/// Thickness of plates.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Thickness {
    /// A length, in units of the sheet.
    Length(f64),
    /// As thick as the motion allows.
    Max,
}

impl OptionValue for Thickness {
    const KIND: Kind = Kind::NumberOrName;

    fn read(value: &Value) -> Result<Self, String> {
        word(value, "a length above 0, or max", |word| match word {
            "max" => Some(Self::Max),
            number => number
                .parse()
                .ok()
                .filter(|length| THICKNESS.contains(*length))
                .map(Self::Length),
        })
    }

    fn json(&self) -> Value {
        match self {
            Self::Length(length) => Value::from(*length),
            Self::Max => "max".into(),
        }
    }
}

/// Height of the hinge plane in a plate, over its thickness: 0 to 1.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct HingePlane(pub f64);

impl HingePlane {
    const NAMES: [(&'static str, f64); 3] = [("bottom", 0.0), ("middle", 0.5), ("top", 1.0)];
}

impl Default for HingePlane {
    fn default() -> Self {
        Self(0.5)
    }
}

impl OptionValue for HingePlane {
    const KIND: Kind = Kind::NumberOrName;

    fn read(value: &Value) -> Result<Self, String> {
        word(
            value,
            "middle, top, bottom or a fraction from 0 to 1",
            |word| {
                let named = Self::NAMES.iter().find(|(name, _)| *name == word);
                let fraction =
                    named.map_or_else(|| word.parse().ok(), |(_, fraction)| Some(*fraction));
                fraction
                    .filter(|fraction| HINGE_PLANE.contains(*fraction))
                    .map(Self)
            },
        )
    }

    #[allow(clippy::float_cmp, reason = "the numbers of the names")]
    fn json(&self) -> Value {
        let named = Self::NAMES.iter().find(|(_, fraction)| *fraction == self.0);
        named.map_or_else(|| Value::from(self.0), |(name, _)| (*name).into())
    }
}

lists!(ColourLetters, LayerLetters, Order);

impl OptionValue for Unit {
    const KIND: Kind = Kind::Names(&[
        (Self::Nanometre.name(), "Nanometres"),
        (Self::Micrometre.name(), "Micrometres"),
        (Self::Millimetre.name(), "Millimetres"),
        (Self::Centimetre.name(), "Centimetres"),
        (Self::Metre.name(), "Metres"),
        (Self::Inch.name(), "Inches"),
        (Self::Point.name(), "Points, 72 to an inch"),
    ]);

    fn read(value: &Value) -> Result<Self, String> {
        word(
            value,
            &Self::ALL.map(Self::name).join(", "),
            Self::from_name,
        )
    }

    fn json(&self) -> Value {
        self.name().into()
    }
}

/// Gives values of a type their names on the command line and in JSON, and says what each means; nothing if the name says
/// it.
macro_rules! named {
    ($($Type:ty { $($name:literal: $value:expr, $help:literal;)* })*) => {
        $(impl OptionValue for $Type {
            const KIND: Kind = Kind::Names(&[$(($name, $help)),*]);

            fn read(value: &Value) -> Result<Self, String> {
                word(value, &[$($name),*].join(", "), |word| match word {
                    $($name => Some($value),)*
                    _ => None,
                })
            }

            fn json(&self) -> Value {
                $(if *self == $value {
                    return $name.into();
                })*
                Value::Null
            }
        })*
    };
}

named! {
    Letter {
        "V": Self::Valley, "Valleys";
        "M": Self::Mountain, "Mountains";
        "F": Self::Flat, "Marks that stay flat";
        "U": Self::Unassigned, "Hinges that may turn either way";
    }
    Symmetry {
        "auto": Self::Auto, "One unknown for each group of creases that turn alike";
        "off": Self::Off, "One unknown for each crease";
    }
    Vertices {
        "essential": Self::Essential, "One vertex for each distinct closure condition";
        "all": Self::All, "All vertices";
    }
    Switch {
        "on": Self::On, "";
        "off": Self::Off, "";
    }
    Option<Interpolation> {
        "auto": None, "The interpolation that needs the fewest knots";
        "half-angle": Some(Interpolation::HalfAngle), "Cubic Hermite in the tangent of half the fold angle";
        "hermite": Some(Interpolation::Hermite), "Cubic Hermite in the fold angle";
        "homogeneous": Some(Interpolation::Homogeneous), "Cubic Hermite in weighted cosine and sine of half the fold angle";
        "linear": Some(Interpolation::Linear), "Linear in the fold angle";
    }
    Timing {
        "optimal": Self::Optimal, "As fast as the limits of the hinges allow";
        "sparse": Self::Sparse, "A simple law with which few knots suffice";
    }
    Frames {
        "full": Self::Full, "Fold angles and the positions of all vertices";
        "angles": Self::Angles, "Only fold angles";
    }
    Solver {
        "lm": Self::LevenbergMarquardt, "Levenberg-Marquardt";
        "gradient": Self::Gradient, "Gradient steps";
    }
    Search {
        "auto": Self::Auto, "Follow the motion, in phases where faces would cross otherwise";
        "path": Self::Path, "Follow the motion with all creases turning at once";
        "random": Self::Random, "The adaptive randomised search of Xi and Lien (GMU-CS-TR-2015-2)";
    }
    PlateSides {
        "taper": Self::Taper, "Slanted sides at hinges, along which neighbours touch at the largest angle";
        "inset": Self::Inset, "Upright sides that stay back from the hinges";
    }
    Letters {
        "foldable": Self::Foldable, "The sheet folds";
        "unfoldable": Self::Unfoldable, "The sheet does not fold; its goal is folded flat";
    }
    Column {
        "hinge": Self::Hinge, "Each hinge, named edge_I by the number of its edge";
        "group": Self::Group, "Each crease group, named group_G";
    }
    Joints {
        "all": Self::All, "All hinges";
        "drivers": Self::Drivers, "Those that drive the sheet near flat, as `info` names them; the others follow";
    }
    Colour {
        "letters": Self::Letters, "Colours of Origami Simulator: mountain red, valley blue and so on; the opacity is the goal angle";
        "groups": Self::Groups, "Crease groups, each with the range of its angles";
        "deformation": Self::Deformation, "Largest deformation of each face along the path";
        "plates": Self::Plates, "Layers to cut plates from a board: CUT, MOUNTAIN, VALLEY, HOLE and TEXT";
    }
    Objective {
        "max": Self::Max, "The worst vertex";
        "sum": Self::Sum, "The sum over all vertices";
    }
    Cut {
        "auto": Self::Auto, "Those that no plane holds whole";
        "none": Self::None, "None";
    }
    Straighten {
        "auto": Self::Auto, "If the sheet is not planned as it is drawn";
        "on": Self::On, "Always";
        "off": Self::Off, "Never";
    }
}
