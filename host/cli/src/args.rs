//! Defines the command line with clap: commands, options and their values. The doc comments of these are the help texts
//! that users read.

use std::path::PathBuf;
use std::time::Instant;

use clap::{Args, Parser, Subcommand, ValueEnum};

use foldpath_firmware_sim::faults::Faults;
use foldpath_firmware_sim::hinges;

use crate::jobs::Jobs;
use crate::options::{FamilyArgs, Options, examples, formats};
use crate::values::{Gravity, Seeded, Shard, Spring, Target, above_zero, zero_or_above};
use foldpath::export::Format;
use foldpath::request::{
    CheckRequest, ExportRequest, PlanRequest, ReadingRequest, RequestError, UnfoldRequest, timeout,
};

/// Plans how a flat sheet with many hinges folds into a goal shape.
///
/// Exit status: 0 if the work is done; 1 if the command ran well, but the answer is no; 2 for bad input or usage.
#[derive(Debug, Parser)]
#[command(name = "foldpath", version, about, after_help = examples([
    "generate miura --rows 5 --cols 5 -o miura.fold",
    "info miura.fold",
    "plan miura.fold -o path.fold",
    "check path.fold",
]))]
pub(crate) struct Cli {
    #[command(subcommand)]
    pub(crate) command: Command,
    /// Print no notes and no progress bars on stderr
    #[arg(long, global = true)]
    pub(crate) quiet: bool,
}

#[derive(Debug, Subcommand)]
pub(crate) enum Command {
    /// Write a crease pattern of a known family with its goal
    #[command(subcommand, after_help = examples([
        "generate miura --rows 11 --cols 11 -o miura.fold",
        "generate waterbomb --rows 8 --cols 10 -o waterbomb.fold",
    ]))]
    Generate(FamilyArgs),
    /// Describe a crease pattern: its parts, whether it will fold, and which hinges to drive
    Info(Info),
    /// Find a path from the flat sheet to a goal
    ///
    /// If no option names a goal, the goal is the pattern's own fold angles. If the pattern has none, all creases that
    /// are lettered M or V fold all the way, as their letters say.
    Plan(Box<Plan>),
    /// Judge a path afresh: rigidity, closure, signs and crossings, at the knots and between them
    Check(Check),
    /// Tell how exactly a sheet has to be made: the play that its hinges need if vertices are off
    ///
    /// Panels whose corners are off by an error do not close in general, and their hinges need play: small turns and shifts
    /// beside the fold. The worst case is over all errors of up to --error in each coordinate of each vertex, the expected
    /// value is the root mean square for independent uniform errors, both to first order and over the whole motion from the
    /// moment that a hinge is folded by 10 degrees. A turn by a radian counts as much as a shift by the median edge.
    ///
    /// Exit status: 0 for an answer; 1 if time runs out; 2 for bad input or usage.
    Tolerance(Tolerance),
    /// Tell how strong the drives of a sheet have to be, against gravity and springs
    ///
    /// The sheet is at rest at each moment; friction and acceleration are left out. A set of drivers has as many hinges as the
    /// sheet has degrees of freedom; the one whose largest torque is least is told.
    ///
    /// Exit status: 0 if each drive of --drives fits; 1 if one stalls, or time runs out; 2 for bad input or usage.
    Loads(Loads),
    /// Make a crease pattern of a folded shape, with its measured fold angles as the goal
    ///
    /// Faces are laid flat across their edges, all with the same side up: the side from which the vertices of most
    /// faces run counter-clockwise, or the side for which the file's letters are written. A plain sheet is never cut.
    /// Other shapes are cut along edges: those without a boundary, rings that cannot lie in a plane, and shapes with
    /// corners, vertices inside the sheet round which the angles do not sum to 360 degrees. From each corner a cut goes to
    /// the boundary, and the cuts are as short as is found. If the sheet overlaps itself however it is cut, it is cut into
    /// pieces.
    ///
    /// The sign of a fold by 180 degrees cannot be measured. Such a fold gets the sign of the file's letter or angle;
    /// without one it becomes a valley, and a note says so. An edge without a letter gets the letter F if it is flat to
    /// within 6e-6 degrees, or to within four times the largest angle defect that --max-defect accepts.
    Unfold(Unfold),
    /// Write one self-contained page that shows a path, or a crease pattern with the numbers of its edges
    ///
    /// With --error or --play, hinges are coloured by the play that they need, as `foldpath tolerance` tells it, and the vertices
    /// that matter most are marked. With --areal-density the page has curves of the torques that `foldpath loads` tells.
    View(View),
    /// Draw curves of fold angles, errors, clearance and torques along a path
    Plot(Plot),
    /// Export a path for a controller, a spreadsheet or a renderer, or its pattern as a drawing
    Export(Export),
    /// Plan many designs: JSON lines in, JSON lines out
    ///
    /// A line that is read is {"id":TEXT, "pattern":FILE, "plan":{OPTION:VALUE}, "path":FILE}; "pattern" may be a FOLD object
    /// as well. In its place, a line may have "generate" with a "family" and its parameters. "plan" and "path" may be left
    /// out. A line that is written is the answer of `foldpath plan --json` with id and "design" before it and "figures" behind
    /// it, or these with an "error".
    ///
    /// Each design is planned by itself. One that cannot be read, ends its process or hangs is told in its line.
    /// Results come in the order of the designs.
    ///
    /// Exit status: 0 if each design has a result, whatever it says; 2 for bad input or usage.
    Batch(Batch),
    /// Send a path to a controller and follow the motion
    ///
    /// Ctrl-C slows the motion down along the path and then holds it; a second Ctrl-C stops it at once.
    ///
    /// Exit status: 0 if the sheet is at the end of the path; 1 if the motion was held, stopped or refused, if a hinge
    /// stalled, or if there is no controller that understands; 2 for bad input or usage.
    Stream(Box<Stream>),
    /// Watch and move the hinges of a controller one by one, and write the map from hinges to channels
    ///
    /// Nothing moves from an unknown place: a hinge begins where it is measured, or where you say that it stands. It moves
    /// by 0.1 radians per second. Ctrl-C holds it.
    Drive(Drive),
    /// Give a controller a key, over a line that no stranger reaches
    ///
    /// From then on the controller takes only what `foldpath stream --key FILE` sends with the same key; a controller never
    /// takes another key over its line. The key goes over the line as it is. A file that does not exist is made, with a
    /// random key, and only its owner can read it.
    ///
    /// Exit status: 0 if the controller has the key; 1 if it takes none or does not answer; 2 for bad input or usage.
    Pair(Pair),
    /// Serve a simulated controller over TCP, in real time, for other clients
    ///
    /// The controller has room for 256 groups, 16,384 hinges, 4,096 spokes and 64 setpoints. Its hinges stand at 0, move as
    /// they are commanded, and are measured. It serves one client at a time, and runs until the process is ended; what a
    /// client leaves, the next one finds.
    Sim(Served),
    /// Print the completion script of a shell
    #[command(after_help = examples(["completions bash > foldpath.bash", "completions zsh > _foldpath"]))]
    Completions {
        /// Shell
        #[arg(value_enum)]
        shell: clap_complete::Shell,
    },
    /// Print the manual page, or write the manual pages of all commands
    #[command(after_help = examples(["man > foldpath.1", "man -o ."]))]
    Man {
        /// Folder into which a page for each command is written
        #[arg(short, long, value_name = "DIR")]
        output: Option<PathBuf>,
    },
}

/// Places at which an operator may say that a sheet stands.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub(crate) enum At {
    /// The beginning of the path
    Start,
    /// The flat sheet
    Flat,
    /// The goal: the last knot of the path in the file
    Goal,
    /// The angles that the controller measures; it forgets what it knew
    Measured,
}

#[derive(Debug, Args)]
#[command(after_help = examples([
    "info miura.fold",
    "info miura.fold --edges",
    "info miura.fold --json --timeout 2",
]))]
pub(crate) struct Info {
    /// Crease pattern: a FOLD file, or a file that ends in .svg, .dxf, .cp, .opx or .obj
    ///
    /// In an SVG file the colours are those of Origami Simulator. In a DXF file layers have names such as CUT and VALLEY.
    pub(crate) pattern: PathBuf,
    /// List the edges: number, letter, goal angle, ends and names
    ///
    /// Numbers are those of all options and answers. Names are the ids of SVG and the layers of DXF. In JSON, `edges` is
    /// then the list instead of the number of edges.
    #[arg(long)]
    pub(crate) edges: bool,
    #[command(flatten)]
    pub(crate) until: Until,
    #[command(flatten)]
    pub(crate) reading: Options<ReadingRequest>,
    #[command(flatten)]
    pub(crate) report: Report,
}

#[derive(Debug, Args)]
#[command(after_help = examples([
    "unfold path.fold -o unfolded.fold",
    "unfold path.fold --frame 3 --unit mm -o third.fold --json",
]))]
pub(crate) struct Unfold {
    /// Folded shape: a FOLD file with faces in space, or a file that ends in .obj or .stl
    ///
    /// An OBJ file may have Freeform Origami's crease comments.
    pub(crate) shape: PathBuf,
    /// Crease pattern to write, a FOLD file; written only if the shape unfolds
    #[arg(short, long)]
    pub(crate) output: PathBuf,
    #[command(flatten)]
    pub(crate) request: Options<UnfoldRequest>,
    #[command(flatten)]
    pub(crate) report: Report,
}

#[derive(Debug, Args)]
#[command(after_help = examples([
    "batch designs.jsonl -o results.jsonl",
    "batch designs.jsonl -o results.jsonl --resume",
    "batch designs.jsonl --shard 0/3 -o results-0.jsonl",
]))]
pub(crate) struct Batch {
    /// Designs, one JSON object a line
    pub(crate) designs: PathBuf,
    /// File to write, one JSON object a line
    #[arg(short, long)]
    pub(crate) output: PathBuf,
    /// Number of designs that are planned at a time [default: one for each core]
    #[arg(long, value_name = "K")]
    pub(crate) jobs: Option<core::num::NonZeroU16>,
    /// Plan one part of N, numbered from 0
    ///
    /// A digest of its id says to which part a design belongs. All parts put together and sorted are the lines of one
    /// run, sorted.
    #[arg(long, value_name = "I/N")]
    pub(crate) shard: Option<Shard>,
    /// Go on with results that are there
    ///
    /// Designs whose ids are among the results are skipped. The rest of a line that an interrupted run has left is cut off.
    #[arg(long)]
    pub(crate) resume: bool,
    /// As --resume, but plan designs again whose result is an error
    ///
    /// Their results are removed from the file first.
    #[arg(long)]
    pub(crate) retry_errors: bool,
    /// Timeout of designs that name none, seconds
    #[arg(long, default_value_t = 60.0, value_name = "SECONDS")]
    pub(crate) timeout: f64,
    /// Leave out what depends on the clock, so that equal designs give equal bytes
    ///
    /// Results then have no times. A design whose time was up has no more than the outcome timeout.
    #[arg(long)]
    pub(crate) stable: bool,
    /// Be a process that plans the designs on stdin
    #[arg(long, hide = true)]
    pub(crate) worker: bool,
}

/// The time that a command has.
#[derive(Clone, Copy, Debug, Args)]
pub(crate) struct Until {
    /// Stop after this time, seconds, counted from the start of the command [default: no limit]
    ///
    /// The answer has what was found by then.
    #[arg(long, value_name = "SECONDS")]
    timeout: Option<f64>,
}

impl Until {
    /// Returns the end of the time that begins now.
    ///
    /// # Errors
    /// If the time is none.
    pub(crate) fn deadline(self) -> Result<Option<Instant>, RequestError> {
        Ok(timeout(self.timeout)?.and_then(|time| Instant::now().checked_add(time)))
    }
}

#[derive(Clone, Debug, Args)]
pub(crate) struct Report {
    /// Print the answer as one JSON object on stdout
    #[arg(long)]
    pub(crate) json: bool,
}

#[derive(Clone, Debug, Args)]
#[command(allow_negative_numbers = true)]
#[command(after_help = examples([
    "plan miura.fold -o path.fold",
    "plan miura.fold --fold 0.5 --max-accel 90 -o gentle.fold",
    "plan miura.fold --crease 4=-45 -o driven.fold",
    "plan miura.fold --symmetry off --collision off --json",
]))]
pub(crate) struct Plan {
    /// Crease pattern: a FOLD file, or a file that ends in .svg, .dxf, .cp, .opx or .obj
    ///
    /// In an SVG file the colours are those of Origami Simulator. In a DXF file layers have names such as CUT and VALLEY.
    pub(crate) pattern: PathBuf,
    #[command(flatten)]
    pub(crate) request: Options<PlanRequest>,
    /// Path to write, a FOLD animation; written only if the goal is reached
    #[arg(short, long, help_heading = "Path written", display_order = 0)]
    pub(crate) output: Option<PathBuf>,
    // Not listed among the options of an answer, which is the same for any number.
    #[command(flatten)]
    pub(crate) jobs: Jobs,
    #[command(flatten)]
    pub(crate) report: Report,
}

#[derive(Debug, Args)]
#[command(allow_negative_numbers = true)]
#[command(after_help = examples(["check path.fold", "check path.fold --bound 1e-6 --json"]))]
pub(crate) struct Check {
    /// Path, a FOLD animation
    pub(crate) path: PathBuf,
    #[command(flatten)]
    pub(crate) request: Options<CheckRequest>,
    #[command(flatten)]
    pub(crate) jobs: Jobs,
    #[command(flatten)]
    pub(crate) report: Report,
}

#[derive(Debug, Args)]
#[command(mut_group("scale", |scale| scale.required(true)))]
#[command(after_help = examples(["tolerance path.fold --error 0.001", "tolerance path.fold --play 0.002 --json"]))]
pub(crate) struct Tolerance {
    /// Path, a FOLD animation
    pub(crate) path: PathBuf,
    #[command(flatten)]
    pub(crate) scale: Scale,
    #[command(flatten)]
    pub(crate) until: Until,
    #[command(flatten)]
    pub(crate) jobs: Jobs,
    #[command(flatten)]
    pub(crate) report: Report,
}

/// The error of a sheet, or the play that its hinges have.
#[derive(Clone, Copy, Debug, Args)]
#[group(id = "scale", multiple = false)]
pub(crate) struct Scale {
    /// Largest error of each coordinate of each vertex, in the file's unit
    #[arg(long, value_name = "E", value_parser = above_zero)]
    pub(crate) error: Option<f64>,
    /// Largest play of a hinge, in the file's unit: tells the error that it allows
    #[arg(long, value_name = "P", value_parser = above_zero)]
    pub(crate) play: Option<f64>,
}

#[derive(Debug, Args)]
#[command(allow_negative_numbers = true)]
#[command(after_help = examples([
    "loads path.fold --areal-density 0.8 --unit mm",
    "loads path.fold --areal-density 0.8 --unit mm --gravity 0,-9.81,0 --spring 0.001 --json",
    "loads path.fold --areal-density 0.8 --unit mm --spring 4=0.02 --drivers 2",
]))]
pub(crate) struct Loads {
    /// Path, a FOLD animation
    pub(crate) path: PathBuf,
    /// Mass of the panels, kilograms per square metre
    #[arg(long, value_name = "KG_PER_M2", value_parser = zero_or_above)]
    pub(crate) areal_density: f64,
    #[command(flatten)]
    pub(crate) load: LoadArgs,
    /// Number of drivers [default: as many as the sheet has degrees of freedom]
    ///
    /// More drivers share the load so that the sum of the squares of their torques is least.
    #[arg(long, value_name = "N")]
    pub(crate) drivers: Option<usize>,
    #[command(flatten)]
    pub(crate) until: Until,
    /// Table of drives, a line NAME,STALL_TORQUE_NM,SPEED_DEG_PER_S for each: tells which fit
    #[arg(long, value_name = "FILE")]
    pub(crate) drives: Option<PathBuf>,
    #[command(flatten)]
    pub(crate) jobs: Jobs,
    #[command(flatten)]
    pub(crate) report: Report,
}

/// Load of a sheet, beside the mass of its panels.
#[derive(Debug, Args)]
pub(crate) struct LoadArgs {
    /// Face that is held [default: the first face of the spanning tree, in the middle of the sheet]
    #[arg(long, value_name = "FACE", requires = "areal_density")]
    pub(crate) fixed: Option<u32>,
    /// Acceleration of gravity, metres per second squared, in the frame of the drawing with the held face in its place
    /// [default: 0,0,-9.80665]
    #[arg(
        long,
        value_name = "X,Y,Z",
        allow_hyphen_values = true,
        requires = "areal_density"
    )]
    pub(crate) gravity: Option<Gravity>,
    /// Stiffness of a spring in each hinge that rests flat, newton metres per radian; I=NM_PER_RAD for the hinge at edge I alone;
    /// repeatable
    #[arg(long, value_name = "NM_PER_RAD", requires = "areal_density")]
    pub(crate) spring: Vec<Spring>,
    #[command(flatten)]
    pub(crate) reading: Options<ReadingRequest>,
}

#[derive(Debug, Args)]
#[command(allow_negative_numbers = true)]
#[command(after_help = examples([
    "plot path.fold -o plots.svg",
    "plot path.fold -o plots.png",
    "plot path.fold --areal-density 0.8 --unit mm -o torques.svg",
]))]
pub(crate) struct Plot {
    /// Path, a FOLD animation
    pub(crate) path: PathBuf,
    /// Picture to write, an SVG or PNG file by its ending .svg or .png
    #[arg(short, long)]
    pub(crate) output: PathBuf,
    #[command(flatten)]
    pub(crate) torques: Torques,
}

/// Torques that are drawn for those who ask.
#[derive(Debug, Args)]
pub(crate) struct Torques {
    /// Draw the torques of the drivers as well, as loads tells them: mass of the panels, kilograms per square metre
    #[arg(long, value_name = "KG_PER_M2", value_parser = zero_or_above)]
    pub(crate) areal_density: Option<f64>,
    #[command(flatten)]
    pub(crate) load: LoadArgs,
}

#[derive(Debug, Args)]
#[command(allow_negative_numbers = true)]
#[command(after_help = examples([
    "view path.fold -o path.html",
    "view path.fold --error 0.001 -o play.html",
    "view path.fold --areal-density 0.8 --unit mm -o torques.html",
    "view miura.fold -o miura.html",
]))]
pub(crate) struct View {
    /// Path, a FOLD animation; or any crease pattern
    pub(crate) path: PathBuf,
    /// Page to write, an HTML file
    #[arg(short, long)]
    pub(crate) output: PathBuf,
    #[command(flatten)]
    pub(crate) scale: Scale,
    #[command(flatten)]
    pub(crate) torques: Torques,
}

#[derive(Debug, Args)]
#[command(after_help = examples([
    "export path.fold --to traj -o path.traj",
    "export path.fold --to glb -o path.glb",
    "export path.fold --to csv --rate 50 --per hinge -o hinges.csv",
    "export path.fold --to mjcf -o model",
]))]
pub(crate) struct Export {
    /// Path, a FOLD animation; or for svg coloured by letters or groups, and for dxf, any crease pattern
    pub(crate) path: PathBuf,
    /// Format to write
    #[arg(long, value_parser = formats())]
    pub(crate) to: &'static Format,
    /// File to write; with obj, the name of the sequence or a folder; with mjcf and stl, a folder
    #[arg(short, long)]
    pub(crate) output: PathBuf,
    #[command(flatten)]
    pub(crate) request: Options<ExportRequest>,
    #[command(flatten)]
    pub(crate) reading: Options<ReadingRequest>,
}

#[derive(Debug, Args)]
#[command(after_help = examples([
    "stream path.traj --to sim --log log.csv",
    "stream path.traj --to sim --faults drop=0.1,flip=0.1,seed=7",
    "stream path.traj --to sim --drives lag=0.005,speed=4 --sheet path.fold",
    "stream path.traj --to serial:/dev/ttyUSB0 --reverse --at goal",
]))]
pub(crate) struct Stream {
    /// Path: a .traj file, as written by `foldpath export --to traj`
    pub(crate) path: PathBuf,
    /// Controller: sim, qemu, serial:DEVICE, tcp:HOST:PORT or tcp:PORT
    ///
    /// sim is a controller in this process, in virtual time. qemu runs the controller's image on an emulated board.
    /// serial:DEVICE is a controller behind a serial device, tcp:HOST:PORT one behind a network address, and tcp:PORT
    /// one behind a port of this machine.
    #[arg(long, value_name = "CONTROLLER")]
    pub(crate) to: Target,
    /// CSV file to write, with one row for each telemetry message
    ///
    /// Its columns are the time in microseconds, the state, the number of the knot at or before the position on the
    /// path, the commanded angle of each crease group in radians, and then those that host/FORMAT.md describes. Each row is
    /// in the file as soon as it has come.
    #[arg(long)]
    pub(crate) log: Option<PathBuf>,
    /// Undo whatever holds the sheet now, a stop or a fault as well, and continue from its present position
    ///
    /// This is a word for the beginning of the session. A later hold ends the session.
    #[arg(long)]
    pub(crate) resume: bool,
    /// Resume whenever the line was silent for so long that the controller holds, but never after a stop or a fault
    #[arg(long)]
    pub(crate) unattended: bool,
    /// Run the path backwards, from its end to its beginning
    ///
    /// With --resume, a run in the other direction that was interrupted turns back from where the sheet stands.
    #[arg(long)]
    pub(crate) reverse: bool,
    /// Say where the sheet stands, whatever the controller knows
    ///
    /// A controller that was just switched on does not know where the sheet stands. It measures the hinges if it can, and
    /// starts only near the beginning of the path. Otherwise somebody has to look and say so. With --resume, whatever
    /// holds the sheet is undone, and the path begins anew.
    #[arg(long, value_enum, value_name = "PLACE")]
    pub(crate) at: Option<At>,
    /// Faults to add to the line, such as drop=0.1,flip=0.1,double=0.1,reorder=0.1,seed=7
    ///
    /// Each number is a fraction of the frames, from 0 to 1: drop of those that get lost, flip of those of which one
    /// bit is changed, double of those that arrive twice, and reorder of those that are overtaken by others. Faults are
    /// drawn from the seed.
    #[arg(long)]
    pub(crate) faults: Option<Seeded<Faults>>,
    /// With sim: drives of the hinges, such as lag=0.005,speed=4,acceleration=200,seed=7
    ///
    /// Properties are lag (seconds), speed (radians per second), acceleration (torque over the inertia that it turns,
    /// radians per second squared), play and noise (both in radians). A property that is not given is that of an ideal
    /// drive. Noise is drawn from the seed.
    #[arg(long)]
    pub(crate) drives: Option<Seeded<hinges::Drive>>,
    /// With sim: script of events that disturb the hinges, one event on each line
    ///
    /// A line has the time in SECONDS and then one of: supply 0..1, stick HINGE, free HINGE, or jump HINGE RADIANS, an
    /// error of the hinge's sensor.
    #[arg(long)]
    pub(crate) script: Option<PathBuf>,
    /// With sim: path from which the .traj file was exported, to report how far from rigid its sheet was
    #[arg(long)]
    pub(crate) sheet: Option<PathBuf>,
    #[command(flatten)]
    pub(crate) line: LineArgs,
    #[command(flatten)]
    pub(crate) report: Report,
}

#[derive(Debug, Args)]
#[command(allow_negative_numbers = true)]
#[command(after_help = format!("\
Commands on hinges:
{}

Examples:
  foldpath drive --to serial:/dev/ttyUSB0 --map map.csv
  foldpath drive --to serial:/dev/ttyUSB0 jog 3 by 5
  foldpath drive --to sim --map map.csv channel 3 7 jog 3 to 10 zero 3 limits 3 -90 90",
    indented(crate::drive::HELP)))]
pub(crate) struct Drive {
    /// Controller: sim, qemu, serial:DEVICE, tcp:HOST:PORT or tcp:PORT
    ///
    /// sim is a controller in this process, in virtual time, whose hinges stand at 0 and are measured: a rehearsal.
    #[arg(long, value_name = "CONTROLLER")]
    pub(crate) to: Target,
    /// Map from hinges to channels to edit: a CSV file, angles in radians
    ///
    /// It is read if it is there, and has to be the one that the board runs with. It is written whole or not at all: by
    /// `save`, or at the end if all commands came as arguments and were done.
    #[arg(long, value_name = "FILE")]
    pub(crate) map: Option<PathBuf>,
    /// Rust source of the map, for the image of the board; written whenever the map is
    #[arg(long, value_name = "FILE", requires = "map")]
    pub(crate) rust: Option<PathBuf>,
    #[command(flatten)]
    pub(crate) line: LineArgs,
    /// Print the answer to each command as a JSON object, one on each line
    #[arg(long)]
    pub(crate) json: bool,
    /// Commands on hinges, one behind the other [default: lines of stdin]
    pub(crate) commands: Vec<String>,
}

/// Indents each line.
fn indented(text: &str) -> String {
    let lines: Vec<String> = text.lines().map(|line| format!("  {line}")).collect();
    lines.join("\n")
}

#[derive(Debug, Args)]
#[command(after_help = examples([
    "pair --to sim --key lab.key",
    "pair --to serial:/dev/ttyUSB0 --key lab.key",
]))]
pub(crate) struct Pair {
    /// Controller: sim or serial:DEVICE
    ///
    /// sim is a controller in this process, which is gone at its end: a rehearsal.
    #[arg(long, value_name = "CONTROLLER")]
    pub(crate) to: Target,
    /// File of the key: 32 hexadecimal digits
    ///
    /// If there is none, it is made with a random key. Make one for each controller: frames that were recorded with one
    /// controller could move another that has the same key and comes to the same nonce.
    #[arg(long, value_name = "FILE")]
    pub(crate) key: PathBuf,
    /// Speed of a serial line, baud
    #[arg(long, default_value_t = 115_200)]
    pub(crate) baud: u32,
}

#[derive(Debug, Args)]
#[command(after_help = examples([
    "sim --listen 4444",
    "sim --listen 0.0.0.0:4444 --key lab.key",
]))]
pub(crate) struct Served {
    /// Address: HOST:PORT, or PORT of this machine alone; port 0 stands for any free one
    ///
    /// The address is printed once the controller can be reached there.
    #[arg(long, value_name = "ADDR")]
    pub(crate) listen: String,
    /// File of the key that the controller has, as `foldpath pair` writes it
    #[arg(long, value_name = "FILE")]
    pub(crate) key: Option<PathBuf>,
}

/// Options of the line to a controller.
#[derive(Debug, Args)]
pub(crate) struct LineArgs {
    /// Image for qemu [default: the image of the workspace, which is built if it is missing]
    #[arg(long)]
    pub(crate) image: Option<PathBuf>,
    /// Speed of a serial line, baud
    #[arg(long, default_value_t = 115_200)]
    pub(crate) baud: u32,
    /// File of the key that the controller has as well, as `foldpath pair` writes it
    ///
    /// Every frame then has a tag that only owners of the key can make, and a counter, so that nobody else can move the
    /// sheet, with frames that were recorded either. sim and qemu start a controller that has the key.
    #[arg(long, value_name = "FILE")]
    pub(crate) key: Option<PathBuf>,
    /// With tcp: send without a key, so that anybody on the network may move its hinges
    #[arg(long, conflicts_with = "key")]
    pub(crate) insecure: bool,
}
