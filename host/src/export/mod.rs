//! Writes crease patterns and motions in the formats of other programs and of controllers: [`FORMATS`] is the table of
//! what `foldpath export` makes. A format is a file of this folder with a row here.

pub mod csv;
mod cut_sheet;
#[cfg(feature = "dxf")]
mod dxf;
pub mod fold;
pub mod glb;
mod groups;
pub mod joint_trajectory;
pub mod mjcf;
mod mjcf_panels;
pub mod obj_sequence;
pub mod rust;
mod stl;
mod stuck_hinge;
pub mod svg_pattern;
pub mod traj;

use std::path::Path;

pub use stuck_hinge::{Drives, USUAL_RESOLUTION_DEG};

use crate::motion::Motion;
use crate::pattern::CreasePattern;
use crate::read::{FileError, JointNames};

/// A format that motions or patterns are exported to: a row of the table.
#[derive(Clone, Copy, Debug)]
#[non_exhaustive]
pub struct Format {
    /// Name, with `-` between its words.
    pub name: &'static str,
    /// Description in one sentence.
    pub text: &'static str,
    /// Kind of place for its content.
    pub place: Place,
    /// Names of the options that it takes.
    pub options: &'static [&'static str],
    /// Returns what it is made of, with these options.
    pub needs: fn(&ExportOptions) -> Needs,
    make: fn(&Export<'_>, &mut Sink<'_>) -> Result<Made, FileError>,
}

/// Place of the content of a format.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Place {
    /// One file.
    File,
    /// Files with fixed names in a folder.
    Folder,
    /// Numbered files: in a folder, or beside each other with a common beginning of their names.
    Sequence,
}

/// Things of which a format is made.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Needs {
    /// A path.
    Path,
    /// A crease pattern.
    Pattern,
    /// A path if there is one, and a crease pattern otherwise.
    PathOrPattern,
}

/// Options of exports. Each format takes some of them.
#[derive(Clone, Debug, Default, PartialEq)]
#[non_exhaustive]
pub struct ExportOptions {
    /// Rows a second, hertz; `None` for a row at each knot.
    pub rate: Option<f64>,
    /// Meaning of the columns of rows at a rate.
    pub per: csv::Column,
    /// Number of frames, evenly spaced in time; `None` for those that the format needs.
    pub frames: Option<usize>,
    /// Meaning of the colours of a drawing.
    pub colour: svg_pattern::Colour,
    /// Draws the numbers of the edges.
    pub numbers: bool,
    /// Largest gap that one stuck hinge may cost, median edges; `None` to keep the speed of the path.
    pub bound: Option<f64>,
    /// Drives on which it depends what a stuck hinge costs.
    pub drives: Drives,
    /// Places all plates in one file, folded as at the end of the path.
    pub assembled: bool,
    /// Width of the cut by which outlines are larger, half on each side, units of the sheet.
    pub kerf: f64,
    /// Density of the panels, kilograms per cubic metre; `None` for masses in proportion to the size of the sheet.
    pub density: Option<f64>,
    /// Hinges that are joints of a robot.
    pub joints: joint_trajectory::Joints,
    /// Names of the joints of all hinges; `None` for `crease_I` with the number I of the edge.
    pub names: Option<JointNames>,
}

crate::util::changed_one_by_one!(ExportOptions);

/// Thing that is exported.
#[derive(Clone, Copy, Debug)]
pub enum Source<'a> {
    /// A path.
    Motion(&'a Motion),
    /// A crease pattern with its title.
    Pattern(&'a str, &'a CreasePattern),
}

impl Source<'_> {
    /// Returns the title.
    #[must_use]
    pub fn title(&self) -> &str {
        match self {
            Self::Motion(motion) => &motion.title,
            Self::Pattern(title, _) => title,
        }
    }

    /// Returns the crease pattern, for a path that of its sheet.
    fn pattern(&self) -> &CreasePattern {
        match self {
            Self::Motion(motion) => &motion.pattern,
            Self::Pattern(_, pattern) => pattern,
        }
    }
}

/// An export of a path or a pattern.
#[derive(Clone, Copy, Debug)]
struct Export<'a> {
    source: Source<'a>,
    /// Name of the file that was read, for messages.
    name: &'a Path,
    options: &'a ExportOptions,
}

/// Takes the name and content of each file: no name for [`Place::File`], numbers for [`Place::Sequence`].
pub type Sink<'a> = dyn FnMut(&str, Vec<u8>) -> Result<(), FileError> + 'a;

/// Description of what was made.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
#[non_exhaustive]
pub struct Made {
    /// Description in words.
    pub told: String,
    /// Remarks for the user.
    pub notes: Vec<String>,
}

impl Made {
    fn told(told: String) -> Self {
        Self {
            told,
            notes: Vec::new(),
        }
    }
}

const fn path(_: &ExportOptions) -> Needs {
    Needs::Path
}

/// Options of what a controller follows.
const STUCK: &[&str] = &["bound", "resolution", "period", "delay", "brake"];

/// Options of the joints of a robot.
const JOINTS: &[&str] = &["joints", "names"];

/// The formats.
pub const FORMATS: &[Format] = &[
    Format {
        name: "traj",
        text: "File that a controller stores and follows: group angles and rates at the knots, with limits",
        place: Place::File,
        options: STUCK,
        needs: path,
        make: traj::made,
    },
    Format {
        name: "csv",
        text: "One row for each knot, or at a fixed rate: time in seconds and fold angles in degrees",
        place: Place::File,
        options: &["rate", "per"],
        needs: path,
        make: csv::made,
    },
    Format {
        name: "rust",
        text: "Contents of a .traj file as Rust constants, which need foldpath-core but no std",
        place: Place::File,
        options: STUCK,
        needs: path,
        make: rust::made,
    },
    Format {
        name: "obj",
        text: "Sequence of Wavefront OBJ files, one for each frame",
        place: Place::Sequence,
        options: &["frames"],
        needs: path,
        make: obj_sequence::made,
    },
    Format {
        name: "glb",
        text: "Binary glTF 2.0 with the motion as an animation",
        place: Place::File,
        options: &["frames"],
        needs: path,
        make: glb::made,
    },
    Format {
        name: "svg",
        text: "Coloured drawing of the crease pattern",
        place: Place::File,
        options: &["colour", "numbers", "kerf"],
        needs: |options| options.colour.needs(),
        make: svg_pattern::made,
    },
    #[cfg(feature = "dxf")]
    Format {
        name: "dxf",
        text: "Drawing of the flat sheet for CAD programs and laser cutters, with a layer for each fold side; of plates, their \
               outlines",
        place: Place::File,
        options: &["kerf"],
        needs: |_| Needs::PathOrPattern,
        make: dxf::made,
    },
    Format {
        name: "stl",
        text: "Plates for printers and mills: a folder with a file for each form, in millimetres, and a list with their numbers",
        place: Place::Folder,
        options: &["assembled"],
        needs: path,
        make: stl::made,
    },
    Format {
        name: "mjcf",
        text: "Model for MuJoCo and Drake: a folder with scene.xml and a mesh for each panel",
        place: Place::Folder,
        options: &["density"],
        needs: path,
        make: mjcf::made,
    },
    Format {
        name: "joint-trajectory",
        text: "ROS's trajectory_msgs/JointTrajectory in YAML: a joint for each hinge",
        place: Place::File,
        options: JOINTS,
        needs: path,
        make: joint_trajectory::made,
    },
    Format {
        name: "ros2-control",
        text: "Parameters of ros2_control in YAML: a controller that follows the trajectories of --to joint-trajectory",
        place: Place::File,
        options: JOINTS,
        needs: path,
        make: joint_trajectory::controllers_made,
    },
];

impl Format {
    /// Returns the format with this name, if there is one.
    #[must_use]
    pub fn named(name: &str) -> Option<&'static Self> {
        FORMATS.iter().find(|format| format.name == name)
    }

    /// Makes the content of a path or a pattern, file by file. `name` is that of the file that was read, for messages.
    ///
    /// # Errors
    /// If the source has no such form, or is a pattern and the format needs a path, or the sink fails.
    pub fn make(
        &self,
        source: Source<'_>,
        name: &Path,
        options: &ExportOptions,
        sink: &mut Sink<'_>,
    ) -> Result<Made, FileError> {
        let export = Export {
            source,
            name,
            options,
        };
        (self.make)(&export, sink)
    }
}

impl<'a> Export<'a> {
    /// Returns the path.
    fn motion(&self) -> Result<&'a Motion, FileError> {
        match self.source {
            Source::Motion(motion) => Ok(motion),
            Source::Pattern(..) => {
                let found = "a crease pattern";
                Err(FileError::expected(self.name, "the file", "a path", found))
            }
        }
    }

    /// Returns the path in the number of frames asked for, if a number is given.
    fn resampled(&self) -> Result<Option<Motion>, FileError> {
        let motion = self.motion()?;
        Ok(self.options.frames.map(|frames| motion.resampled(frames)))
    }
}

/// Rounds to single precision, in which other programs read drawings.
#[expect(clippy::cast_possible_truncation, reason = "rounding is the purpose")]
fn single(number: f64) -> f32 {
    number as f32
}

/// Escapes the characters that have a meaning in XML and drops those that XML forbids.
fn escaped(text: &str) -> String {
    let mut escaped = String::new();
    for c in text.chars() {
        match c {
            '<' => escaped += "&lt;",
            '&' => escaped += "&amp;",
            '>' => escaped += "&gt;",
            '"' => escaped += "&quot;",
            '\u{fffe}' | '\u{ffff}' => {}
            c if c.is_control() => escaped.push(' '),
            c => escaped.push(c),
        }
    }
    escaped
}
