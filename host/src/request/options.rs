//! The tables of the options of planning, judging and reading.
//!
//! Each option stands here and nowhere else: clap's arguments, options by name, the JSON Schema, the Python signature and
//! the documents are made of these rows. Names and units are those of the command line: degrees and seconds.

use core::time::Duration;
use std::path::PathBuf;

use foldpath_core::{Interpolation, Objective};

use super::error::RequestError;
use super::order::Order;
use super::table::{self, options};
use super::values::{EdgeAngles, Frames, HingePlane, Switch, Thickness};
use crate::check::CheckOptions;
use crate::collision::CONTACT_EDGES;
use crate::export::csv::Column;
use crate::export::joint_trajectory::Joints;
use crate::export::svg_pattern::Colour;
use crate::export::{Drives, ExportOptions, USUAL_RESOLUTION_DEG};
use crate::folding::{BOUND, DEFAULT_BOUND};
use crate::motion::{GAP, MARGIN_DEG, PlateOptions, PlateSides};
use crate::pattern::{BEND_DEG, Letter, Unit};
use crate::planner::{
    DEFAULT_GOAL_TOLERANCE_DEG, DEFAULT_MAX_SPEED_DEG_PER_S, GOAL_TOLERANCE_DEG,
    MAX_ACCELERATION_DEG_PER_S2, MAX_SPEED_DEG_PER_S, PlanOptions, PlateRequest, Search, Solver,
    Symmetry, Timing, Vertices,
};
use crate::read::{ColourLetters, LayerLetters, ReadOptions, Straighten, TOLERANCE};
use crate::unfold::{Cut, DEFAULT_MAX_DEFECT_DEG, MAX_DEFECT_DEG, UnfoldOptions};
use crate::util::range::Range;

/// Largest error of a drive.
const RESOLUTION_DEG: Range = Range::from("degrees", 0.0).up_to(180.0);
/// Time by which drives and sensors are late.
const LATE_S: Range = Range::from("seconds", 0.0).up_to(60.0);
/// Width of a cut.
const KERF: Range = Range::from("a length", 0.0);
/// Density of a material.
const DENSITY_KG_PER_M3: Range = Range::above("kilograms per cubic metre", 0.0);
/// Time after which a command stops.
pub(super) const TIMEOUT_S: Range = Range::from("seconds", 0.0);

options! {
    /// Options of a plan. They serialise to the `options` of the answer, in this order.
    PlanRequest for PlanOptions {
        /// FOLD file of the same sheet whose fold angles are the goal
        goal: Option<PathBuf> = None, heading: "Goal", excludes: &["fold", "crease"] => |_, _| ();

        /// Fold each crease by this fraction of a half turn, as its letter says
        ///
        /// With 0 the goal is the flat sheet. Together with --via the path then leads back to flat.
        fold: Option<f64> = None, heading: "Goal", excludes: &["crease"],
            range: Some(Range::from("a fraction", 0.0).up_to(1.0)) => |_, _| ();

        /// Drive a crease, edge I of the file, to an angle in degrees while the others follow; repeatable
        ///
        /// Edges are counted from 0.
        crease: Vec<EdgeAngles<1>> = Vec::new(), heading: "Goal", value_name: "I=DEG" => |_, _| ();

        /// FOLD file of the same sheet with fold angles at which the path rests before the goal; repeatable
        ///
        /// The path passes through several such files in the order given.
        via: Vec<PathBuf> = Vec::new(), heading: "Goal", value_name: "FILE" => |_, _| ();

        /// Steps of edges that fold one after the other, such as "0-3 / 8-11 / 5=135,lid / 5", or a FOLD file of such steps
        ///
        /// In its step each edge goes to its goal angle, or to the angle given, in degrees; an edge may stand in several
        /// steps. A name, as the id of a shape or group in SVG or a layer in DXF, stands for all edges that have it; `info
        /// --edges` lists numbers and names. Edges that stand nowhere fold in a last step. Borders are skipped. The path rests
        /// between the steps. Hinges of other steps move only as closure requires. A name of digits and hyphens alone, or with one
        /// of the signs / , = in it, stands in quotation marks: '"0" / "a-b"'. In a FOLD file of the same sheet, whose name
        /// ends in .fold, each frame beside the key frame that has fold angles is a step.
        order: Option<Order> = None, heading: "Goal", value_name: "STEPS", excludes: &["crease", "via"] => |_, _| ();

        /// Largest number of orders to list in which the hinges of a net may fold, in the words of `--order`
        ///
        /// In any two of them some hinges fold in the opposite order. The path folds in the first. Orders are found if the
        /// hinges turn freely, as where no vertex lies inside the sheet and there is no hole that hinges go round.
        orders: Option<usize> = None, heading: "Goal", value_name: "N", excludes: &["order", "via"]
            => |plan, orders| plan.orders = orders.unwrap_or(0);

        /// Largest distance of a crease from its goal angle at the end of the path, degrees
        goal_tolerance: f64 = DEFAULT_GOAL_TOLERANCE_DEG, heading: "Goal", value_name: "DEG",
            range: Some(GOAL_TOLERANCE_DEG) => |plan, degrees| plan.goal_tolerance = degrees.to_radians();

        /// Make the panels plates of this thickness, in the drawing's unit, or as thick as the motion allows (max)
        ///
        /// The motion is that of the thin sheet; plates are trimmed at hinges as far as it needs, and are judged along it: no
        /// two of them may pass through each other. With max the answer names a thickness that is proved, and one at most 1 %
        /// larger that is not possible, with what is in the way.
        thickness: Option<Thickness> = None, heading: "Plates", value_name: "T" => |plan, thickness| {
            plan.plates = thickness.map(|thickness| match thickness {
                Thickness::Length(length) => PlateRequest::given(PlateOptions::of_thickness(length)),
                Thickness::Max => PlateRequest::thickest(PlateOptions::of_thickness(0.0)),
            });
        };

        /// Height of the hinges in the plates: middle, top, bottom, or a fraction of the thickness from the lower face
        hinge_plane: HingePlane = HingePlane::default(), heading: "Plates", value_name: "PLACE", requires: "thickness"
            => |plan, plane| plates(plan, |it| it.hinge_plane = plane.0);

        /// Sides of plates at hinges
        panels: PlateSides = PlateSides::default(), heading: "Plates", requires: "thickness"
            => |plan, sides| plates(plan, |it| it.sides = *sides);

        /// With --panels inset: least distance of the sides of plates from a hinge, in the drawing's unit
        gap: f64 = 0.0, heading: "Plates", value_name: "LENGTH", requires: "thickness", range: Some(GAP)
            => |plan, gap| plates(plan, |it| it.gap = *gap);

        /// Angle by which hinges could turn farther than the motion does before plates touch, degrees
        margin: f64 = 0.0, heading: "Plates", value_name: "DEG", requires: "thickness", range: Some(MARGIN_DEG)
            => |plan, degrees| plates(plan, |it| it.margin = degrees.to_radians());

        /// Keep the hinge at edge I of the file between two angles in degrees; repeatable
        ///
        /// Edges are counted from 0.
        limit: Vec<EdgeAngles<2>> = Vec::new(), heading: "Limits", value_name: "I=MIN..MAX" => |_, _| ();

        /// Write the path as far as it goes, even if the answer is no
        keep: bool = false, heading: "Path written", requires: "output" => |_, _| ();

        /// Unknowns of the plan: crease groups, or single creases
        symmetry: Symmetry = Symmetry::default(), heading: "Method";

        /// Vertices whose closure conditions are solved
        vertices: Vertices = Vertices::default(), heading: "Method";

        /// Earlier name of an option: `--reuse off` is `--vertices all`
        reuse: Symmetry = Symmetry::Auto, heading: "Method", is_earlier_name: true
            => |plan, reuse| if *reuse == Symmetry::Off { plan.vertices = Vertices::All };

        /// Search for faces that pass through each other
        collision: Switch = Switch::On, heading: "Crossings"
            => |plan, collision| plan.collision = *collision == Switch::On;

        /// Interpolation of the motion between knots
        interpolation: Option<Interpolation> = None, heading: "Path written";

        /// Largest speed of a hinge, degrees per second
        max_speed: f64 = DEFAULT_MAX_SPEED_DEG_PER_S, heading: "Limits", value_name: "DEG_PER_S",
            range: Some(MAX_SPEED_DEG_PER_S) => |plan, degrees| plan.max_speed = degrees.to_radians();

        /// Largest acceleration of a hinge, degrees per second squared [default: no limit]
        ///
        /// With such a limit the path begins and ends at rest.
        max_accel: Option<f64> = None, heading: "Limits", value_name: "DEG_PER_S2",
            range: Some(MAX_ACCELERATION_DEG_PER_S2)
            => |plan, degrees| plan.max_acceleration = degrees.map(f64::to_radians);

        /// Time law along the path
        pace: Timing = Timing::default(), heading: "Path written";

        /// Largest number of knots of the path [default: no limit]
        max_knots: Option<usize> = None, heading: "Path written", value_name: "N";

        /// Data that each knot stores
        frames: Frames = Frames::default(), heading: "Path written" => |_, _| ();

        /// Solver that closes the sheet
        solver: Solver = Solver::default(), heading: "Method";

        /// Method by which the path is found
        search: Search = Search::default(), heading: "Method";

        /// Objective by which the randomised search measures closure
        objective: Objective = Objective::default(), heading: "Method";

        /// Seed of all random numbers
        seed: u64 = 0, heading: "Method";
    } includes {
        /// Options of judging, which hold for the plan as well.
        check: CheckRequest => |plan, check| {
            (plan.bound, plan.bend, plan.contact) = (check.bound, check.bend, check.contact);
            plan.timeout = check.timeout;
        };

        /// Options of reading the pattern.
        reading: ReadingRequest => |_, _| ();
    }
}

options! {
    /// Options of judging a motion.
    CheckRequest for CheckOptions {
        /// Stop after this time, seconds, counted from the start of the command [default: no limit]
        timeout: Option<f64> = None, heading: "Limits", value_name: "SECONDS", range: Some(TIMEOUT_S)
            => |check, seconds| check.timeout = seconds.and_then(duration);

        /// Largest deformation, gap and closure residual that the path may have
        ///
        /// Deformation is the change of an edge's length over that length. Gap is the distance between the positions that
        /// faces give one vertex, over the median edge. A note says so if rounding alone may exceed the bound, as for
        /// sheets that lie 1e11 edge lengths from the origin.
        bound: f64 = DEFAULT_BOUND, heading: "Limits", range: Some(BOUND);

        /// Largest angle by which panels may bend about their diagonals, degrees
        ///
        /// A plan bends panels only if the sheet does not fold with rigid ones. Vertices close exactly; the path turns the
        /// diagonals, lettered J, and the largest bend found is told.
        bend: f64 = 0.0, heading: "Limits", value_name: "DEG", range: Some(BEND_DEG)
            => |check, degrees| check.bend = degrees.to_radians();

        /// Depth up to which faces may overlap that touch, in median edges, at most 0.001
        ///
        /// Without this option it follows from the digits of coordinates and goal angles: 1e-6, and ten times the unit to
        /// which they are rounded. In front of a small face, at most a thousandth of the face counts.
        contact: Option<f64> = None, heading: "Limits", value_name: "EDGES", range: Some(CONTACT_EDGES);
    }
}

options! {
    /// Options of reading a drawing of lines.
    ReadingRequest for ReadOptions {
        /// Distance within which lines of a drawing are meant to meet, in the drawing's own units
        ///
        /// By default it is a thousandth of the median line, but at most 1e-4 of the diagonal. Notes name the tolerance
        /// that keeps lines which end in the open. For SVG, DXF, CP and OPX files, and FOLD files without faces.
        tolerance: Option<f64> = None, heading: "Drawing", value_name: "LENGTH", range: Some(TOLERANCE);

        /// Move vertices a little, so that lines are straight or parallel and creases fold flat that nearly do
        ///
        /// No vertex moves farther than twice the tolerance. By default only sheets that do not fold as they are drawn are
        /// straightened. Notes tell how many vertices are moved, and by how much.
        straighten: Straighten = Straighten::Auto, heading: "Drawing", value_name: "WHEN";

        /// Frame of a FOLD file with the crease pattern; the key frame is 0
        ///
        /// By default it is the first frame of class creasePattern, or else the key frame. A note names other frames that
        /// have a crease pattern. Goals come only from folded frames that inherit from the frame.
        frame: Option<usize> = None, heading: "Drawing", value_name: "I";

        /// Unit of the lengths of a file that names none
        ///
        /// A unit that differs from that of the file is an error. Places, lengths, paths and models have the unit of the file.
        unit: Option<Unit> = None, heading: "Drawing", value_name: "UNIT";

        /// Letters of the colours of an SVG or DXF drawing, such as red=V,blue=M,#00ff00=V
        ///
        /// Colours are names of CSS or digits such as #00ff00; letters are B (border), M, V, F (flat), U (free), C (cut)
        /// and J (joins a panel). A colour that is not named counts as the nearest named colour of its hue; without one it
        /// has the meaning of Origami Simulator.
        colors: Option<ColourLetters> = None, heading: "Drawing", value_name: "NAME=LETTER,..."
            => |read, letters| read.colours = letters.clone().unwrap_or_default();

        /// Letters of the layers of a DXF drawing, such as CUT=C,CREASE=V
        ///
        /// Letters are those of `--colors`. A layer that is not named has the letter that its name says (words such as CUT,
        /// BORDER, MOUNTAIN, VALLEY, CREASE), or else its lines have the letters of their colours; notes tell which.
        layers: Option<LayerLetters> = None, heading: "Drawing", value_name: "NAME=LETTER,..."
            => |read, letters| read.layers = letters.clone().unwrap_or_default();

        /// Letter of the dashed lines of an SVG or DXF drawing, whatever their colour
        ///
        /// Without this option dashes mean nothing: a dashed line has the letter of its colour or layer.
        dashes: Option<Letter> = None, heading: "Drawing", value_name: "LETTER";
    }
}

options! {
    /// Options of exporting; each format takes some of them.
    ExportRequest for ExportOptions {
        /// With csv: rows a second, and one for the end [default: a row for each knot]
        ///
        /// The first column is the time t in seconds; angles are in degrees, valley positive.
        rate: Option<f64> = None, value_name: "HZ", range: Some(Range::above("a frequency in Hz", 0.0));

        /// With csv and --rate: what has a column
        per: Column = Column::Hinge, requires: "rate";

        /// With obj or glb: number of frames, 2 to 2000, evenly spaced in time
        ///
        /// By default obj has one frame for each knot. By default glb also has frames between the knots, so that no hinge
        /// turns by more than 6 degrees from one frame to the next.
        frames: Option<usize> = None, value_name: "N", range: Some(Range::from("a number of frames", 2.0).up_to(2000.0));

        /// With svg: meaning of the colours
        colour: Colour = Colour::Letters;

        /// With stl: one file with all plates, folded as at the end of the path
        assembled: bool = false;

        /// With dxf, or svg and --colour plates: width of the cut, by half of which outlines are larger, in the drawing's unit
        kerf: f64 = 0.0, value_name: "LENGTH", range: Some(KERF);

        /// With mjcf: density of the panels, kilograms per cubic metre
        ///
        /// Without it masses are in proportion to the size of the sheet.
        density: Option<f64> = None, value_name: "KG_PER_M3", range: Some(DENSITY_KG_PER_M3);

        /// With joint-trajectory or ros2-control: hinges that are joints
        joints: Joints = Joints::All;

        /// With joint-trajectory or ros2-control: names of the joints, a line for each hinge in the order of the edges
        ///
        /// By default the hinge at edge I is crease_I. There is a name for every hinge, also if `--joints drivers` leaves most of
        /// them out.
        names: Option<PathBuf> = None, value_name: "FILE" => |_, _| ();

        /// With svg: write the number of each edge at its middle, as `--crease` and `--limit` count them
        numbers: bool = false;

        /// With traj or rust: slow the path down, so that a hinge that sticks tears the sheet by no more than this gap
        ///
        /// The gap is the distance between the positions that faces give one vertex, over the median edge, once the
        /// controller has noticed and the motion rests. The file tells the controller the lag from which on it has to hold.
        /// Drives that are too coarse for the bound are an error. Without a bound the speed stays.
        bound: Option<f64> = None, range: Some(BOUND);

        /// With traj or rust: largest angle by which a drive is off its command at rest, or measured there, degrees
        resolution: f64 = USUAL_RESOLUTION_DEG, value_name: "DEG", range: Some(RESOLUTION_DEG)
            => |export, degrees| export.drives.resolution = degrees.to_radians();

        /// With traj or rust: longest time between two measurements of a hinge, seconds
        period: f64 = Drives::USUAL.period, value_name: "S", range: Some(LATE_S)
            => |export, seconds| export.drives.period = *seconds;

        /// With traj or rust: time by which drives follow late, seconds
        delay: f64 = Drives::USUAL.delay, value_name: "S", range: Some(LATE_S)
            => |export, seconds| export.drives.delay = *seconds;

        /// With traj or rust: loss of the speed in a second when the controller brakes, in full speeds
        brake: f64 = Drives::USUAL.brake, value_name: "PER_S", range: Some(Range::above("a rate in 1/s", 0.0))
            => |export, brake| export.drives.brake = *brake;
    }
}

options! {
    /// Options of unfolding a shape.
    UnfoldRequest for UnfoldOptions {
        /// Frame of a FOLD file; the key frame is 0 [default: the last folded form, or else the key frame]
        frame: Option<usize> = None, value_name: "N" => |_, _| ();

        /// Unit of the lengths of a shape whose file names none
        ///
        /// A unit that differs from that of the file is an error. The crease pattern has the unit.
        unit: Option<Unit> = None, value_name: "UNIT" => |_, _| ();

        /// Largest error of the shape that is taken for noise, degrees
        ///
        /// This bounds the angle defect of an inner vertex and the slope of a face out of its plane. Defects that the rounding
        /// of the file's coordinates explains, by their digits, are taken for noise as well.
        max_defect: f64 = DEFAULT_MAX_DEFECT_DEG, value_name: "DEG", range: Some(MAX_DEFECT_DEG)
            => |unfold, degrees| unfold.max_defect = degrees.to_radians();

        /// Which shapes are cut so that they lie flat
        cut: Cut = Cut::Auto, value_name: "WHICH";
    }
}

/// Changes the plates that are asked for, if there are some.
fn plates(plan: &mut PlanOptions, change: impl FnOnce(&mut PlateOptions)) {
    if let Some(request) = &mut plan.plates {
        *request = request.with(|it| change(it));
    }
}

/// Returns the time that a number of seconds allows; `None` for one that is too large for a `Duration`.
fn duration(seconds: f64) -> Option<Duration> {
    Duration::try_from_secs_f64(seconds).ok()
}

/// Returns the time that the option `timeout` allows, if it does.
///
/// # Errors
/// If the number of seconds is negative or not a number.
pub fn timeout(seconds: Option<f64>) -> Result<Option<Duration>, RequestError> {
    if let Some(found) = seconds.filter(|seconds| !TIMEOUT_S.contains(*seconds)) {
        let problem = format!("expected {TIMEOUT_S}, found {found}");
        return Err(RequestError::option("timeout", problem));
    }
    Ok(seconds.and_then(duration))
}
