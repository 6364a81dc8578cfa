//! A sheet with the unknowns and closure conditions that a search works on.

use foldpath::folding::SpanningTree;
use foldpath::generate::ParameterError;
use foldpath::pattern::{CreasePattern, Drawing};
use foldpath::planner::{Goal, PlanOptions, Symmetry, Vertices};
use foldpath::symmetry::{CreaseGroups, ReducedStars};

/// What is unknown and what has to close: the columns SYM and EV of the report's Table 2.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Freedom {
    /// Every crease on its own, all real vertices: x/x.
    Full,
    /// Crease groups, all real vertices: o/x.
    Groups,
    /// Crease groups, essential vertices: o/o.
    Essential,
}

impl Freedom {
    /// As in the report's table.
    #[must_use]
    pub fn marks(self) -> &'static str {
        match self {
            Self::Full => "x/x",
            Self::Groups => "o/x",
            Self::Essential => "o/o",
        }
    }

    /// The same for foldpath.
    #[must_use]
    pub fn options(self) -> PlanOptions {
        PlanOptions {
            symmetry: match self {
                Self::Full => Symmetry::Off,
                Self::Groups | Self::Essential => Symmetry::Auto,
            },
            vertices: match self {
                Self::Full | Self::Groups => Vertices::All,
                Self::Essential => Vertices::Essential,
            },
            // The report's planner answers with angles.
            keep_vertices: false,
            ..PlanOptions::default()
        }
    }
}

/// A pattern, its goal, and what the search has to know beforehand. The report is given the crease groups.
#[derive(Clone, Debug)]
pub struct Sheet {
    /// The crease pattern.
    pub pattern: CreasePattern,
    /// Where it is to go.
    pub goal: Goal,
    /// The tree along which it is folded.
    pub tree: SpanningTree,
    /// The unknowns.
    pub groups: CreaseGroups,
    /// The conditions.
    pub stars: ReducedStars,
    /// Angle of each unknown at the goal, radians.
    pub goal_angles: Vec<f64>,
    /// What is unknown and what has to close.
    pub freedom: Freedom,
}

impl Sheet {
    /// A generated sheet.
    ///
    /// # Panics
    /// If the parameters are none of a sheet, or its goal leaves a crease free: the benchmark's mistake.
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
            tree: SpanningTree::from_central_face(&pattern),
            pattern,
            goal,
            groups,
            stars,
            goal_angles,
            freedom,
        }
    }
}
