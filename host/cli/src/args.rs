//! Arguments of the commands.

use core::str::FromStr;
use std::path::PathBuf;

use clap::{Args, Parser, Subcommand, ValueEnum};

use foldpath_firmware_sim::hinges::Drive;

use foldpath::planner;

/// Plans how a flat sheet with many hinges folds into a goal shape.
///
/// Exit status: 0 done; 1 ran well, but the answer is no; 2 bad input or usage.
#[derive(Debug, Parser)]
#[command(
    name = "foldpath",
    version,
    about,
    after_help = "\
Examples:
  foldpath generate miura --rows 5 --cols 5 -o miura.fold
  foldpath info miura.fold
  foldpath plan miura.fold -o path.fold
  foldpath check path.fold"
)]
pub(crate) struct Cli {
    #[command(subcommand)]
    pub(crate) command: Command,
    /// No notes and no bars on stderr
    #[arg(long, global = true)]
    pub(crate) quiet: bool,
}

#[derive(Debug, Subcommand)]
pub(crate) enum Command {
    /// Write a crease pattern of a known family with its goal
    Generate(Generate),
    /// Say what a crease pattern is, whether it will fold, and which hinges to drive
    Info(Info),
    /// Find a path from flat to the goal: the pattern's own angles, or else its letters folded all the
    /// way
    Plan(Box<Plan>),
    /// Judge a path afresh: rigidity, closure, signs and crossings, at its knots and between them
    Check(Check),
    /// Make a crease pattern of a folded shape, with its measured fold angles as the goal
    ///
    /// Faces are laid flat across their edges, all with the same side up: that of most faces as their vertices
    /// run counter-clockwise, or the side that the file's letters are for. A plain sheet is never cut. Where an
    /// inner vertex of a shape with a boundary has not 360 degrees round it the answer is no. What has no
    /// boundary, or goes round in a ring that no plane holds, is cut along edges. Folds of 180 degrees have no
    /// sign that could be measured: they get that of the file's letters or angles, or else are valleys, which is
    /// said. Edges without a letter that are flat to within 6e-6 degrees, or four times the largest angle defect
    /// let pass, get F.
    Unfold(Unfold),
    /// Write one self-contained page that shows a path
    View(View),
    /// Draw fold angles, errors and clearance along a path
    Plot(Plot),
    /// Write a path for a controller, a spreadsheet or a renderer, or its pattern as a drawing
    Export(Export),
    /// Send a path to a controller and follow what it does
    ///
    /// Ctrl-C slows the motion down along the path and holds it; a second one stops at once. Exit status: 0 the
    /// sheet is at the end of the path; 1 it was held, stopped or refused, a hinge stalled, or there is no
    /// controller that understands; 2 bad input or usage.
    Stream(Box<Stream>),
    /// Print the completions of a shell, for it to read
    Completions(Completions),
    /// Print the manual page, or write those of all commands
    Man(Man),
}

#[derive(Debug, Args)]
#[command(after_help = "\
Examples:
  foldpath generate miura --rows 11 --cols 11 -o miura.fold
  foldpath generate waterbomb --rows 8 --cols 10 -o waterbomb.fold")]
pub(crate) struct Generate {
    #[command(subcommand)]
    pub(crate) family: Family,
}

#[derive(Debug, Subcommand)]
pub(crate) enum Family {
    /// Miura fold of rows x cols parallelograms with unit sides
    #[command(after_help = "\
Examples:
  foldpath generate miura --rows 11 --cols 11 -o miura.fold
  foldpath generate miura --rows 4 --cols 6 --angle 75 --fold 1 -o steep.fold")]
    Miura {
        #[command(flatten)]
        size: Size,
        /// Sector angle, degrees
        #[arg(long, default_value_t = 60.0)]
        angle: f64,
        /// Goal: fold angle of the zigzag creases over 180 degrees
        #[arg(long, default_value_t = 0.9)]
        fold: f64,
    },
    /// Waterbomb tessellation on rows x cols unit squares; rows are counted round the tube
    #[command(after_help = "\
Examples:
  foldpath generate waterbomb --rows 8 --cols 10 -o waterbomb.fold
  foldpath generate waterbomb --rows 4 --cols 6 --fold 0.3 -o wide.fold")]
    Waterbomb {
        #[command(flatten)]
        size: Size,
        /// Goal: fold angle of the boundary lines over 180 degrees
        #[arg(long, default_value_t = 0.5)]
        fold: f64,
    },
    /// Yoshimura pattern on rows x cols cells with one diagonal each
    #[command(after_help = "\
Examples:
  foldpath generate yoshimura --rows 4 --cols 4 -o yoshimura.fold
  foldpath generate yoshimura --rows 6 --cols 8 --angle 20 --fold 0.2 -o boom.fold")]
    Yoshimura {
        #[command(flatten)]
        size: Size,
        /// Angle between diagonals and straight creases, degrees
        #[arg(long, default_value_t = 30.0)]
        angle: f64,
        /// Goal: fold angle of the straight creases over 180 degrees
        #[arg(long, default_value_t = 0.25)]
        fold: f64,
    },
    /// Slender parallelograms with one diagonal each, all valley: cannot fold
    #[command(after_help = "\
Examples:
  foldpath generate quad -o quad.fold
  foldpath generate quad --rows 6 --cols 6 -o small-quad.fold")]
    Quad {
        /// Number of rows
        #[arg(long, default_value_t = 24)]
        rows: usize,
        /// Number of columns
        #[arg(long, default_value_t = 24)]
        cols: usize,
        /// File to write
        #[arg(short, long)]
        output: PathBuf,
        /// Goal: fold angle of the diagonals over 180 degrees
        #[arg(long, default_value_t = 0.0675)]
        fold: f64,
    },
    /// Square twists on rows x cols tiles that mirror their neighbours
    #[command(after_help = "\
Examples:
  foldpath generate square-twist -o twist.fold
  foldpath generate square-twist --rows 2 --cols 2 --letters unfoldable -o locked.fold")]
    SquareTwist {
        /// Number of rows
        #[arg(long, default_value_t = 1)]
        rows: usize,
        /// Number of columns
        #[arg(long, default_value_t = 1)]
        cols: usize,
        /// File to write
        #[arg(short, long)]
        output: PathBuf,
        /// Angle between a square's sides and its pleats, degrees
        #[arg(long, default_value_t = 60.0)]
        angle: f64,
        /// Letters that fold or, folded flat as their goal, do not
        #[arg(long, value_enum, default_value_t)]
        letters: TwistLetters,
        /// Goal of foldable letters: fold angle of the creases that turn most over 180 degrees
        #[arg(long, default_value_t = 0.5)]
        fold: f64,
    },
    /// Ron Resch's triangular tessellation of rows x cols stars, closed to a plane as its goal
    #[command(after_help = "\
Examples:
  foldpath generate resch -o resch.fold
  foldpath generate resch --rows 2 --cols 4 -o strip.fold")]
    Resch {
        /// Number of rows
        #[arg(long, default_value_t = 3)]
        rows: usize,
        /// Number of columns
        #[arg(long, default_value_t = 3)]
        cols: usize,
        /// File to write
        #[arg(short, long)]
        output: PathBuf,
    },
    /// Flat conical Kresling pattern: a polygon of cols sides in rows rings; its goal closes, no motion
    /// leads there
    #[command(after_help = "\
Examples:
  foldpath generate kresling -o kresling.fold
  foldpath generate kresling --rows 1 --cols 8 -o ring.fold")]
    Kresling {
        /// Number of rings
        #[arg(long, default_value_t = 2)]
        rows: usize,
        /// Number of sides of the panel, even
        #[arg(long, default_value_t = 6)]
        cols: usize,
        /// File to write
        #[arg(short, long)]
        output: PathBuf,
    },
}

#[derive(Clone, Copy, Debug, Default, ValueEnum)]
pub(crate) enum TwistLetters {
    #[default]
    Foldable,
    Unfoldable,
}

#[derive(Debug, Args)]
pub(crate) struct Size {
    /// Number of rows
    #[arg(long)]
    pub(crate) rows: usize,
    /// Number of columns
    #[arg(long)]
    pub(crate) cols: usize,
    /// File to write
    #[arg(short, long)]
    pub(crate) output: PathBuf,
}

#[derive(Debug, Args)]
#[command(after_help = "\
Examples:
  foldpath info miura.fold
  foldpath info miura.fold --json")]
pub(crate) struct Info {
    /// Crease pattern: a FOLD file, or by its ending .svg (Origami Simulator's colours), .cp or .obj
    pub(crate) pattern: PathBuf,
    #[command(flatten)]
    pub(crate) report: Report,
}

#[derive(Debug, Args)]
#[command(after_help = "\
Examples:
  foldpath unfold path.fold -o unfolded.fold
  foldpath unfold path.fold --frame 3 -o third.fold --json")]
pub(crate) struct Unfold {
    /// Folded shape: a FOLD file with faces in space, or by its ending .obj (with Freeform Origami's crease
    /// comments) or .stl
    pub(crate) shape: PathBuf,
    /// Crease pattern to write, a FOLD file; nothing is written unless the shape unfolds
    #[arg(short, long)]
    pub(crate) output: PathBuf,
    /// Frame of a FOLD file, of which the key frame is 0 [default: the last folded form, or the key frame]
    #[arg(long, value_name = "N")]
    pub(crate) frame: Option<usize>,
    /// Angle defect of an inner vertex, and slope of a face out of its plane, that is taken for noise, degrees
    #[arg(long, default_value_t = 0.01, value_name = "DEG")]
    pub(crate) max_defect: f64,
    #[command(flatten)]
    pub(crate) report: Report,
}

#[derive(Debug, Args)]
pub(crate) struct Report {
    /// Print one JSON object on stdout
    #[arg(long)]
    pub(crate) json: bool,
}

#[derive(Debug, Args)]
#[command(allow_negative_numbers = true)]
#[command(after_help = "\
Examples:
  foldpath plan miura.fold -o path.fold
  foldpath plan miura.fold --fold 0.5 --max-accel 90 -o gentle.fold
  foldpath plan miura.fold --crease 4=-45 -o driven.fold
  foldpath plan miura.fold --symmetry off --collision off --json")]
pub(crate) struct Plan {
    /// Crease pattern: a FOLD file, or by its ending .svg (Origami Simulator's colours), .cp or .obj
    pub(crate) pattern: PathBuf,
    /// FOLD file of the same sheet whose angles are the goal
    #[arg(long, conflicts_with_all = ["fold", "crease"], help_heading = "Goal")]
    pub(crate) goal: Option<PathBuf>,
    /// Fold each crease by this fraction of a half turn, the way its letter says; 0 is the flat sheet, to which
    /// --via leads back
    #[arg(long, conflicts_with = "crease", help_heading = "Goal")]
    pub(crate) fold: Option<f64>,
    /// Drive one crease, an edge of the file counted from 0, to an angle in degrees; the others follow
    #[arg(long, value_name = "I=DEG", help_heading = "Goal")]
    pub(crate) crease: Option<DrivenEdge>,
    /// FOLD file of the same sheet whose angles the path passes through before the goal, at rest; several
    /// in the order given
    #[arg(long, value_name = "FILE", help_heading = "Goal")]
    pub(crate) via: Vec<PathBuf>,
    /// Path to write, a FOLD animation; nothing is written unless the goal is reached
    #[arg(short, long, help_heading = "Path written")]
    pub(crate) output: Option<PathBuf>,
    /// Keep the hinge at an edge of the file, counted from 0, within angles in degrees; repeatable
    #[arg(long, value_name = "I=MIN..MAX", help_heading = "Limits")]
    pub(crate) limit: Vec<LimitedEdge>,
    /// Bound on deformation (change of an edge's length over it), gap (over the median edge) and closure; where
    /// rounding alone may be over it, as of sheets 1e11 edges from the origin, a note says so
    #[arg(long, default_value_t = 0.01, help_heading = "Limits")]
    pub(crate) bound: f64,
    /// Find creases that turn alike and give them one unknown; off gives every crease its own
    #[arg(long, value_enum, default_value_t, help_heading = "Method")]
    pub(crate) symmetry: Symmetry,
    /// Vertices whose closure is solved: one for each distinct condition, or all
    #[arg(long, value_enum, default_value_t, help_heading = "Method")]
    pub(crate) vertices: Vertices,
    /// Plan on the essential crease pattern and reuse its path on the whole sheet; off plans on the
    /// closure of all vertices
    #[arg(long, value_enum, default_value_t, help_heading = "Method")]
    pub(crate) reuse: Reuse,
    /// Look for faces that pass through each other
    #[arg(long, value_enum, default_value_t, help_heading = "Crossings")]
    pub(crate) collision: Switch,
    /// Switch off what the search for crossings skips, to compare
    #[arg(
        long,
        value_enum,
        value_delimiter = ',',
        value_name = "LIST",
        help_heading = "Crossings"
    )]
    pub(crate) no_skip: Vec<Skip>,
    /// Motion between knots
    #[arg(long, value_enum, default_value_t, help_heading = "Path written")]
    pub(crate) interpolation: Interpolation,
    /// Speed that no hinge exceeds, degrees per second
    #[arg(
        long,
        default_value_t = 45.0,
        value_name = "DEG_PER_S",
        help_heading = "Limits"
    )]
    pub(crate) max_speed: f64,
    /// Acceleration that no hinge exceeds, degrees per second squared; the path then begins and ends at rest
    #[arg(long, value_name = "DEG_PER_S2", help_heading = "Limits")]
    pub(crate) max_accel: Option<f64>,
    /// How time runs along the path
    #[arg(long, value_enum, default_value_t, help_heading = "Path written")]
    pub(crate) pace: Pace,
    /// What of the path is judged
    #[arg(long, value_enum, default_value_t, help_heading = "Method")]
    pub(crate) judge: Judged,
    /// Knots that the path has at most
    #[arg(long, value_name = "N", help_heading = "Path written")]
    pub(crate) max_knots: Option<usize>,
    /// What each knot stores
    #[arg(long, value_enum, default_value_t, help_heading = "Path written")]
    pub(crate) frames: Frames,
    /// Solver
    #[arg(long, value_enum, default_value_t, help_heading = "Method")]
    pub(crate) solver: Solver,
    /// How to look for the path: along the motion, or by the report's adaptive randomised search
    #[arg(long, value_enum, default_value_t, help_heading = "Method")]
    pub(crate) search: Search,
    /// Objective of the randomised search: the worst vertex, or the sum over all
    #[arg(long, value_enum, default_value_t, help_heading = "Method")]
    pub(crate) objective: Objective,
    /// Seed of everything random
    #[arg(long, default_value_t = 0, help_heading = "Method")]
    pub(crate) seed: u64,
    /// Stop planning after this time
    #[arg(long, value_name = "SECONDS", help_heading = "Limits")]
    pub(crate) timeout: Option<f64>,
    #[command(flatten)]
    pub(crate) report: Report,
}

#[derive(Clone, Copy, Debug, Default, ValueEnum)]
pub(crate) enum Symmetry {
    #[default]
    Auto,
    Off,
}

#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, ValueEnum)]
pub(crate) enum Vertices {
    #[default]
    Essential,
    All,
}

#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, ValueEnum)]
pub(crate) enum Reuse {
    #[default]
    Auto,
    Off,
}

#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, ValueEnum)]
pub(crate) enum Switch {
    #[default]
    On,
    Off,
}

#[derive(Clone, Copy, Debug, Default, ValueEnum)]
pub(crate) enum Interpolation {
    /// What needs the fewest knots
    #[default]
    Auto,
    /// Cubic Hermite in the tangent of half the fold angle
    HalfAngle,
    /// Cubic Hermite in the fold angle
    Hermite,
    /// Cubic Hermite in weighted cosine and sine of half the fold angle
    Homogeneous,
    /// Straight lines in the fold angle
    Linear,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub(crate) enum Skip {
    /// Pairs of faces that move like another pair
    Symmetry,
    /// Pairs that cannot have come together since they were looked at
    Motion,
    /// Pairs whose bounding volumes are apart
    Bounds,
    /// Pairs joined by an edge
    Edges,
}

#[derive(Clone, Copy, Debug, Default, ValueEnum)]
pub(crate) enum Pace {
    /// As fast as the limits of the hinges allow
    #[default]
    Optimal,
    /// So that few knots suffice
    Sparse,
}

#[derive(Clone, Copy, Debug, Default, ValueEnum)]
pub(crate) enum Judged {
    /// The whole motion, certified between its knots
    #[default]
    Motion,
    /// Its knots alone, joined straight whatever the pace: a first look, sooner
    Knots,
}

#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, ValueEnum)]
pub(crate) enum Frames {
    /// Fold angles and the positions of all vertices
    #[default]
    Full,
    /// Fold angles alone
    Angles,
}

#[derive(Clone, Copy, Debug, Default, ValueEnum)]
pub(crate) enum Solver {
    /// Levenberg-Marquardt
    #[default]
    Lm,
    /// Gradient steps
    Gradient,
}

#[derive(Clone, Copy, Debug, Default, ValueEnum)]
pub(crate) enum Search {
    #[default]
    Path,
    Random,
}

#[derive(Clone, Copy, Debug, Default, ValueEnum)]
pub(crate) enum Objective {
    #[default]
    Max,
    Sum,
}

/// `I=DEG`.
#[derive(Clone, Copy, Debug)]
pub(crate) struct DrivenEdge {
    pub(crate) edge: usize,
    pub(crate) degrees: f64,
}

impl FromStr for DrivenEdge {
    type Err = &'static str;

    fn from_str(text: &str) -> Result<Self, Self::Err> {
        let parse = || {
            let (edge, degrees) = text.split_once('=')?;
            Some(Self {
                edge: edge.trim().parse().ok()?,
                degrees: degrees_of(degrees)?,
            })
        };
        parse().ok_or("expected I=DEG, the number of an edge and an angle in degrees")
    }
}

/// `I=MIN..MAX`.
#[derive(Clone, Copy, Debug)]
pub(crate) struct LimitedEdge {
    pub(crate) edge: usize,
    pub(crate) lower: f64,
    pub(crate) upper: f64,
}

impl FromStr for LimitedEdge {
    type Err = &'static str;

    fn from_str(text: &str) -> Result<Self, Self::Err> {
        let parse = || {
            let (edge, range) = text.split_once('=')?;
            let (lower, upper) = range.split_once("..")?;
            Some(Self {
                edge: edge.trim().parse().ok()?,
                lower: degrees_of(lower)?,
                upper: degrees_of(upper)?,
            })
        };
        parse().ok_or("expected I=MIN..MAX, the number of an edge and two angles in degrees")
    }
}

fn degrees_of(text: &str) -> Option<f64> {
    let degrees: f64 = text.trim().parse().ok()?;
    degrees.is_finite().then_some(degrees)
}

impl Plan {
    /// The planner's options.
    pub(crate) fn options(&self) -> Result<planner::PlanOptions, crate::CliError> {
        let timeout = self.timeout.map(|seconds| {
            // Longer than a duration can be is no timeout.
            let timeout = core::time::Duration::try_from_secs_f64(seconds).ok();
            (seconds >= 0.0).then_some(timeout).ok_or_else(|| {
                let text = format!("--timeout: expected seconds from 0, found {seconds}");
                crate::CliError::Usage(text)
            })
        });
        let timeout = timeout.transpose()?.flatten();
        if !(self.max_speed >= 1e-6 && self.max_speed.is_finite()) {
            let found = self.max_speed;
            return Err(crate::CliError::Usage(format!(
                "--max-speed: expected at least 1e-6 degrees per second, found {found}"
            )));
        }
        if let Some(found) = self
            .max_accel
            .filter(|most| !(*most > 0.0 && most.is_finite()))
        {
            return Err(crate::CliError::Usage(format!(
                "--max-accel: expected degrees per second squared above 0, found {found}"
            )));
        }
        if !self.via.is_empty() && matches!(self.search, Search::Random) {
            return Err(crate::CliError::Usage(
                "--via: expected --search path, as the randomised search knows no phases".into(),
            ));
        }
        let skips = |skip| !self.no_skip.contains(&skip);
        let all = self.vertices == Vertices::All || self.reuse == Reuse::Off;
        let options = planner::PlanOptions {
            bound: self.bound,
            symmetry: match self.symmetry {
                Symmetry::Auto => planner::Symmetry::Auto,
                Symmetry::Off => planner::Symmetry::Off,
            },
            vertices: if all {
                planner::Vertices::All
            } else {
                planner::Vertices::Essential
            },
            judged: match self.judge {
                Judged::Motion => planner::Judged::Motion,
                Judged::Knots => planner::Judged::Knots,
            },
            collision: self.collision == Switch::On,
            skips: planner::Skips {
                symmetry: skips(Skip::Symmetry),
                motion: skips(Skip::Motion),
                bounds: skips(Skip::Bounds),
                edges: skips(Skip::Edges),
            },
            interpolation: match self.interpolation {
                Interpolation::Auto => None,
                Interpolation::HalfAngle => Some(foldpath_core::Interpolation::HalfAngle),
                Interpolation::Hermite => Some(foldpath_core::Interpolation::Hermite),
                Interpolation::Homogeneous => Some(foldpath_core::Interpolation::Homogeneous),
                Interpolation::Linear => Some(foldpath_core::Interpolation::Linear),
            },
            pace: match self.pace {
                Pace::Optimal => planner::Timing::Optimal,
                Pace::Sparse => planner::Timing::Sparse,
            },
            solver: match self.solver {
                Solver::Lm => planner::Solver::LevenbergMarquardt,
                Solver::Gradient => planner::Solver::Gradient,
            },
            search: match self.search {
                Search::Path => planner::Search::Path,
                Search::Random => planner::Search::Random,
            },
            objective: match self.objective {
                Objective::Max => planner::Objective::Max,
                Objective::Sum => planner::Objective::Sum,
            },
            seed: self.seed,
            max_speed: self.max_speed.to_radians(),
            max_acceleration: self.max_accel.map(f64::to_radians),
            max_knots: self.max_knots,
            timeout,
            ..planner::PlanOptions::default()
        };
        options
            .validate()
            .map_err(|option| crate::CliError::Options { option })?;
        Ok(options)
    }
}

#[derive(Debug, Args)]
#[command(allow_negative_numbers = true)]
#[command(after_help = "\
Examples:
  foldpath check path.fold
  foldpath check path.fold --bound 1e-6 --json")]
pub(crate) struct Check {
    /// Path, a FOLD animation
    pub(crate) path: PathBuf,
    /// Bound on deformation (change of an edge's length over it), gap (over the median edge) and closure; where
    /// rounding alone may be over it, as of sheets 1e11 edges from the origin, a note says so
    #[arg(long, default_value_t = 1e-3)]
    pub(crate) bound: f64,
    #[command(flatten)]
    pub(crate) report: Report,
}

#[derive(Debug, Args)]
#[command(after_help = "\
Examples:
  foldpath view path.fold -o path.html
  foldpath view gentle.fold -o gentle.html")]
pub(crate) struct View {
    /// Path, a FOLD animation
    pub(crate) path: PathBuf,
    /// Page to write, an HTML file
    #[arg(short, long)]
    pub(crate) output: PathBuf,
}

#[derive(Debug, Args)]
#[command(after_help = "\
Examples:
  foldpath plot path.fold -o plots.svg
  foldpath plot path.fold -o plots.png")]
pub(crate) struct Plot {
    /// Path, a FOLD animation
    pub(crate) path: PathBuf,
    /// Picture to write: .svg or .png
    #[arg(short, long)]
    pub(crate) output: PathBuf,
}

#[derive(Debug, Args)]
#[command(after_help = "\
Examples:
  foldpath export path.fold --to traj -o path.traj
  foldpath export path.fold --to glb -o path.glb
  foldpath export path.fold --to obj --frames 60 -o fold.obj
  foldpath export path.fold --to svg --colour groups -o groups.svg")]
pub(crate) struct Export {
    /// Path, a FOLD animation; for svg by letters or groups any crease pattern
    pub(crate) path: PathBuf,
    /// Format to write
    #[arg(long, value_enum)]
    pub(crate) to: ExportFormat,
    /// File to write; for obj the name of the sequence, or a folder
    #[arg(short, long)]
    pub(crate) output: PathBuf,
    /// With obj or glb: number of frames, evenly in time [default: obj the knots; glb the knots and as many
    /// between that no hinge turns by more than 6 degrees from one to the next]
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u16).range(2..=2000))]
    pub(crate) frames: Option<u16>,
    /// With svg: what colours say [default: letters]
    #[arg(long, value_enum)]
    pub(crate) colour: Option<Colour>,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub(crate) enum ExportFormat {
    /// What a controller stores and follows: group angles and rates at the knots, with limits
    Traj,
    /// A row a knot: seconds, and the fold angle of each crease group in degrees
    Csv,
    /// What a .traj file holds as constants of Rust, which need foldpath-core and no std
    Rust,
    /// A sequence of Wavefront OBJ files, one a frame
    Obj,
    /// Binary glTF 2.0 with the motion as an animation
    Glb,
    /// The crease pattern, coloured
    Svg,
}

#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, ValueEnum)]
pub(crate) enum Colour {
    /// Mountain red, valley blue and so on, opacity the goal angle: what Origami Simulator reads
    #[default]
    Letters,
    /// Crease groups, with the angles they go through
    Groups,
    /// Largest deformation of each face along the path
    Deformation,
}

#[derive(Debug, Args)]
#[command(after_help = "\
Examples:
  foldpath completions bash > foldpath.bash
  foldpath completions zsh > _foldpath")]
pub(crate) struct Completions {
    /// Shell
    #[arg(value_enum)]
    pub(crate) shell: clap_complete::Shell,
}

#[derive(Debug, Args)]
#[command(after_help = "\
Examples:
  foldpath man > foldpath.1
  foldpath man -o .")]
pub(crate) struct Man {
    /// Folder to write a page for each command into
    #[arg(short, long, value_name = "DIR")]
    pub(crate) output: Option<PathBuf>,
}

#[derive(Debug, Args)]
#[command(after_help = "\
Examples:
  foldpath stream path.traj --to sim --log log.csv
  foldpath stream path.traj --to sim --faults drop=0.1,flip=0.1,seed=7
  foldpath stream path.traj --to sim --drives lag=0.005,speed=4 --sheet path.fold
  foldpath stream path.traj --to serial:/dev/ttyUSB0")]
pub(crate) struct Stream {
    /// Path: a .traj file, as `foldpath export --to traj` writes it
    pub(crate) path: PathBuf,
    /// Controller: sim (one in this process, in virtual time), qemu (its image on an emulated board),
    /// serial:DEVICE, tcp:HOST:PORT, or tcp:PORT on this machine
    #[arg(long, value_name = "CONTROLLER")]
    pub(crate) to: Target,
    /// CSV file to write, a row for each telemetry message: microseconds, state, number of the knot at or before
    /// the place on the path, and the commanded angle of each crease group in radians
    #[arg(long)]
    pub(crate) log: Option<PathBuf>,
    /// Go on from where the sheet stands, after a stop or a fault too
    #[arg(long)]
    pub(crate) resume: bool,
    /// Faults to add to the line, parts of its frames and a seed: drop=0.1,flip=0.1,double=0.1,reorder=0.1,seed=7
    #[arg(long)]
    pub(crate) faults: Option<LineFaults>,
    /// With sim: what its hinges' drives have, of lag (seconds), speed (radians a second), acceleration (torque over
    /// what is turned, radians a second squared), play and noise (radians): lag=0.005,speed=4,acceleration=200,seed=7
    #[arg(long)]
    pub(crate) drives: Option<Drives>,
    /// With sim: what befalls its hinges, a line an event: SECONDS and supply 0..1, stick HINGE, free HINGE or
    /// jump HINGE RADIANS (of its sensor)
    #[arg(long)]
    pub(crate) script: Option<PathBuf>,
    /// With sim: the path that the .traj file was exported from, to tell how far from rigid its sheet was
    #[arg(long)]
    pub(crate) sheet: Option<PathBuf>,
    /// Image for qemu [default: that of the workspace, built if there is none]
    #[arg(long)]
    pub(crate) image: Option<PathBuf>,
    /// Speed of a serial line
    #[arg(long, default_value_t = 115_200)]
    pub(crate) baud: u32,
    #[command(flatten)]
    pub(crate) report: Report,
}

/// A controller to send to.
#[derive(Clone, Debug)]
pub(crate) enum Target {
    Sim,
    Qemu,
    Serial(String),
    Tcp(String),
}

impl FromStr for Target {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        match text.split_once(':') {
            None if text == "sim" => Ok(Self::Sim),
            None if text == "qemu" => Ok(Self::Qemu),
            Some(("serial", device)) if !device.is_empty() => Ok(Self::Serial(device.into())),
            Some(("tcp", address)) if is_address(address) => Ok(Self::Tcp(address.into())),
            Some(("tcp", _)) => {
                Err("expected tcp:HOST:PORT or tcp:PORT, the port a number from 1 to 65535".into())
            }
            _ => Err("expected sim, qemu, serial:DEVICE, tcp:HOST:PORT or tcp:PORT".into()),
        }
    }
}

/// Whether it is `HOST:PORT`, with the colons of a host in brackets, or a port.
fn is_address(text: &str) -> bool {
    let (host, port) = match text.rsplit_once(':') {
        Some((host, port)) => (Some(host), port),
        None => (None, text),
    };
    let known = |host: &str| {
        let bare = host
            .strip_prefix('[')
            .and_then(|host| host.strip_suffix(']'));
        !host.is_empty() && (bare.is_some() || !host.contains(':'))
    };
    host.is_none_or(known) && port.parse::<u16>().is_ok_and(|port| port > 0)
}

/// Faults of a line.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct LineFaults {
    pub(crate) faults: foldpath_firmware_sim::faults::Faults,
    pub(crate) seed: u64,
}

impl FromStr for LineFaults {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let mut this = Self::default();
        for pair in pairs(text) {
            let (key, value) = pair?;
            let faults = &mut this.faults;
            let part = match key {
                "seed" => {
                    this.seed = seed(value)?;
                    continue;
                }
                "drop" => &mut faults.drop,
                "flip" => &mut faults.flip,
                "double" => &mut faults.double,
                "reorder" => &mut faults.reorder,
                _ => {
                    let expected = "drop, flip, double, reorder or seed";
                    return Err(format!("expected {expected}, found {key}"));
                }
            };
            let parsed = value.parse().ok().filter(|part| (0.0..=1.0).contains(part));
            *part = parsed.ok_or_else(|| format!("{key}: expected 0 to 1, found {value}"))?;
        }
        Ok(this)
    }
}

/// Drives of hinges.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Drives {
    pub(crate) drive: Drive,
    pub(crate) seed: u64,
}

impl FromStr for Drives {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let mut this = Self::default();
        for pair in pairs(text) {
            let (key, value) = pair?;
            let drive = &mut this.drive;
            let number = match key {
                "seed" => {
                    this.seed = seed(value)?;
                    continue;
                }
                "lag" => &mut drive.lag,
                "speed" => &mut drive.speed,
                "acceleration" => &mut drive.acceleration,
                "play" => &mut drive.play,
                "noise" => &mut drive.noise,
                _ => {
                    let expected = "lag, speed, acceleration, play, noise or seed";
                    return Err(format!("expected {expected}, found {key}"));
                }
            };
            let parsed = value.parse().ok().filter(|number| *number >= 0.0);
            *number = parsed.ok_or_else(|| format!("{key}: expected 0 or more, found {value}"))?;
        }
        Ok(this)
    }
}

/// The pairs of a list KEY=VALUE,KEY=VALUE.
fn pairs(text: &str) -> impl Iterator<Item = Result<(&str, &str), String>> {
    text.split(',').map(|pair| {
        pair.split_once('=')
            .ok_or_else(|| format!("expected KEY=VALUE, found {pair}"))
    })
}

fn seed(value: &str) -> Result<u64, String> {
    let seed = value.parse();
    seed.map_err(|_| format!("seed: expected a number, found {value}"))
}
