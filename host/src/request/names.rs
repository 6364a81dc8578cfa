//! Options whose values have names.

use foldpath_core::{Interpolation, Objective};
use serde_json::Value;

use super::table::{Kind, OptionValue, Shape, shape};
use crate::export::csv::Column;
use crate::export::svg_pattern::Colour;
use crate::generate::Letters;
use crate::planner::{Search, Solver, Symmetry, Timing, Vertices};
use crate::read::Straighten;

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

/// Gives values of a type their names on the command line and in JSON, and says what each means; nothing if the name says
/// it.
macro_rules! named {
    ($($Type:ty { $($name:literal: $value:expr, $help:literal;)* })*) => {
        $(impl OptionValue for $Type {
            const SHAPE: Shape = shape(Kind::Names(&[$(($name, $help)),*]));

            fn parse(word: &str) -> Result<Self, String> {
                match word {
                    $($name => Ok($value),)*
                    _ => Err(format!("expected {}", [$($name),*].join(", "))),
                }
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
    Letters {
        "foldable": Self::Foldable, "The sheet folds";
        "unfoldable": Self::Unfoldable, "The sheet does not fold; its goal is folded flat";
    }
    Column {
        "hinge": Self::Hinge, "Each hinge, named edge_I by the number of its edge";
        "group": Self::Group, "Each crease group, named group_G";
    }
    Colour {
        "letters": Self::Letters, "Colours of Origami Simulator: mountain red, valley blue and so on; the opacity is the goal angle";
        "groups": Self::Groups, "Crease groups, each with the range of its angles";
        "deformation": Self::Deformation, "Largest deformation of each face along the path";
    }
    Objective {
        "max": Self::Max, "The worst vertex";
        "sum": Self::Sum, "The sum over all vertices";
    }
    Straighten {
        "auto": Self::Auto, "If a vertex is off by more than rounding: by a tenth of the usual tolerance";
        "on": Self::On, "Always";
        "off": Self::Off, "Never";
    }
}
