//! Options whose values have names.

use foldpath_core::{Interpolation, Objective};
use serde::{Serialize, Serializer};

use crate::planner::{Search, Solver, Symmetry, Timing, Vertices};
use crate::read::Straighten;

/// A type whose values have names on the command line and in JSON.
pub trait Named: Copy + PartialEq + 'static {
    /// Each name with its value, and what the value means in a phrase; no phrase if the name says it.
    const NAMES: &'static [(&'static str, Self, &'static str)];
}

/// Returns the name of a value; empty if it has none.
#[must_use]
pub fn name_of<T: Named>(value: T) -> &'static str {
    let found = T::NAMES.iter().find(|(_, named, _)| *named == value);
    found.map_or("", |(name, ..)| name)
}

/// Returns the value with a name, if there is one.
#[must_use]
pub fn value_of<T: Named>(name: &str) -> Option<T> {
    let found = T::NAMES.iter().find(|(known, ..)| *known == name);
    found.map(|(_, value, _)| *value)
}

/// Serialises a value as its name.
#[allow(
    clippy::trivially_copy_pass_by_ref,
    reason = "serde passes the field so"
)]
pub(super) fn by_name<T: Named, S: Serializer>(
    value: &T,
    serializer: S,
) -> Result<S::Ok, S::Error> {
    name_of(*value).serialize(serializer)
}

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
pub enum Frames {
    /// Fold angles and the positions of all vertices.
    #[default]
    Full,
    /// Fold angles alone.
    Angles,
}

impl Named for Symmetry {
    const NAMES: &'static [(&'static str, Self, &'static str)] = &[
        (
            "auto",
            Self::Auto,
            "One unknown for each group of creases that turn alike",
        ),
        ("off", Self::Off, "One unknown for each crease"),
    ];
}

impl Named for Vertices {
    const NAMES: &'static [(&'static str, Self, &'static str)] = &[
        (
            "essential",
            Self::Essential,
            "One vertex for each distinct closure condition",
        ),
        ("all", Self::All, "All vertices"),
    ];
}

impl Named for Switch {
    const NAMES: &'static [(&'static str, Self, &'static str)] =
        &[("on", Self::On, ""), ("off", Self::Off, "")];
}

impl Named for Option<Interpolation> {
    const NAMES: &'static [(&'static str, Self, &'static str)] = &[
        (
            "auto",
            None,
            "The interpolation that needs the fewest knots",
        ),
        (
            "half-angle",
            Some(Interpolation::HalfAngle),
            "Cubic Hermite in the tangent of half the fold angle",
        ),
        (
            "hermite",
            Some(Interpolation::Hermite),
            "Cubic Hermite in the fold angle",
        ),
        (
            "homogeneous",
            Some(Interpolation::Homogeneous),
            "Cubic Hermite in weighted cosine and sine of half the fold angle",
        ),
        (
            "linear",
            Some(Interpolation::Linear),
            "Linear in the fold angle",
        ),
    ];
}

impl Named for Timing {
    const NAMES: &'static [(&'static str, Self, &'static str)] = &[
        (
            "optimal",
            Self::Optimal,
            "As fast as the limits of the hinges allow",
        ),
        (
            "sparse",
            Self::Sparse,
            "A simple law with which few knots suffice",
        ),
    ];
}

impl Named for Frames {
    const NAMES: &'static [(&'static str, Self, &'static str)] = &[
        (
            "full",
            Self::Full,
            "Fold angles and the positions of all vertices",
        ),
        ("angles", Self::Angles, "Only fold angles"),
    ];
}

impl Named for Solver {
    const NAMES: &'static [(&'static str, Self, &'static str)] = &[
        ("lm", Self::LevenbergMarquardt, "Levenberg-Marquardt"),
        ("gradient", Self::Gradient, "Gradient steps"),
    ];
}

impl Named for Search {
    const NAMES: &'static [(&'static str, Self, &'static str)] = &[
        (
            "auto",
            Self::Auto,
            "Follow the motion, in phases where faces would cross otherwise",
        ),
        (
            "path",
            Self::Path,
            "Follow the motion with all creases turning at once",
        ),
        (
            "random",
            Self::Random,
            "The adaptive randomised search of Xi and Lien (GMU-CS-TR-2015-2)",
        ),
    ];
}

impl Named for Objective {
    const NAMES: &'static [(&'static str, Self, &'static str)] = &[
        ("max", Self::Max, "The worst vertex"),
        ("sum", Self::Sum, "The sum over all vertices"),
    ];
}

impl Named for Straighten {
    const NAMES: &'static [(&'static str, Self, &'static str)] = &[
        (
            "auto",
            Self::Auto,
            "If a vertex is off by more than rounding: by a tenth of the usual tolerance",
        ),
        ("on", Self::On, "Always"),
        ("off", Self::Off, "Never"),
    ];
}
