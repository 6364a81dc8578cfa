//! A sheet with the unknowns and closure conditions of a search.

use foldpath::generate::ParameterError;
use foldpath::pattern::{CreasePattern, Drawing};
use foldpath::planner::{Goal, PlanOptions, Symmetry, Vertices};
use foldpath::symmetry::{CreaseGroups, ReducedStars};

/// Kind of unknowns and closure conditions: the columns SYM and EV of the report's Table 2.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Freedom {
    /// Every crease an unknown, all real vertices: x/x.
    Full,
    /// Crease groups, all real vertices: o/x.
    Groups,
    /// Crease groups, essential vertices: o/o.
    Essential,
}

impl Freedom {
    /// Returns the marks in the report's table.
    #[must_use]
    pub fn marks(self) -> &'static str {
        match self {
            Self::Full => "x/x",
            Self::Groups => "o/x",
            Self::Essential => "o/o",
        }
    }

    /// Returns the options that give foldpath the same unknowns and conditions.
    #[must_use]
    pub fn options(self) -> PlanOptions {
        PlanOptions::default().with(|it| {
            it.symmetry = match self {
                Self::Full => Symmetry::Off,
                Self::Groups | Self::Essential => Symmetry::Auto,
            };
            it.vertices = match self {
                Self::Full | Self::Groups => Vertices::All,
                Self::Essential => Vertices::Essential,
            };
            it.keep_vertices = false;
        })
    }
}

/// A pattern, its goal, and what the search must know in advance. The report is given the crease groups.
#[derive(Clone, Debug)]
pub struct Sheet {
    /// The crease pattern.
    pub pattern: CreasePattern,
    /// The goal.
    pub goal: Goal,
    /// The unknowns.
    pub groups: CreaseGroups,
    /// The closure conditions.
    pub stars: ReducedStars,
    /// Angle of each unknown at the goal, radians.
    pub goal_angles: Vec<f64>,
    /// Kind of unknowns and closure conditions.
    pub freedom: Freedom,
}

impl Sheet {
    /// Creates the sheet of a generated drawing.
    ///
    /// # Panics
    /// If the parameters are invalid, or if the goal leaves a crease free: mistakes of the benchmark.
    #[must_use]
    pub fn new(drawing: Result<Drawing, ParameterError>, freedom: Freedom) -> Self {
        let pattern = CreasePattern::new(drawing.expect("parameters")).expect("a pattern");
        let goal = Goal::of_pattern(&pattern).expect("a goal");
        let groups = match freedom {
            Freedom::Full => CreaseGroups::trivial(&pattern),
            Freedom::Groups | Freedom::Essential => CreaseGroups::find(&pattern),
        };
        let all = ReducedStars::all(&pattern, &groups);
        let stars = match freedom {
            Freedom::Full | Freedom::Groups => all,
            Freedom::Essential => all.essential(),
        };
        let asked = groups.reduce(&goal.fold_angles).into_iter();
        let goal_angles = asked.collect::<Option<_>>().expect("every crease has one");
        Self {
            pattern,
            goal,
            groups,
            stars,
            goal_angles,
            freedom,
        }
    }
}
