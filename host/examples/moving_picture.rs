//! Draws a folding sheet as an animated SVG, which browsers play in an `<img>` too. Writes to stdout; without a pattern,
//! it draws the picture of the README. With a path and the number of one of its steps, counted from 1, it draws the sheet at
//! the end of the step.
//!
//! ```text
//! cargo run --release --example moving_picture -- pattern.fold > docs/pictures/miura-11x11-folding.svg
//! cargo run --release --example moving_picture -- path.fold 1 > step-1.svg
//! ```

use core::error::Error;
use core::fmt::Write;
use core::iter::{once, repeat_n};
use std::env::args_os;
use std::path::Path;

use foldpath::folding::shapes;
use foldpath::pattern::CreasePattern;
use foldpath::planner::{Goal, PlanOptions, plan};
use foldpath::read::fold::read_motion;
use foldpath::read::read_pattern;
use nalgebra::{Matrix3, Vector3};

const DEFAULT: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/../patterns/miura-11x11.fold");

/// Number of configurations drawn.
const FRAMES: usize = 24;
/// Number of configurations of a path from which that of a step is taken.
const STILLS: usize = 500;
/// Number of frames for which the sheet rests at each end.
const REST: usize = 6;
/// Time that a frame is shown, seconds.
const FRAME_S: f64 = 0.1;
/// Width of the picture, pixels.
const WIDTH: f64 = 640.0;
/// Space round the sheet, pixels.
const MARGIN: f64 = 8.0;
/// Direction to the eye round the z axis, from +x, degrees.
const AZIMUTH: f64 = -60.0;
/// Height of the eye above the plane of the flat sheet, degrees.
const ELEVATION: f64 = 40.0;
/// Largest distance from a plane of points that lie in it, units of the sheet.
const FLAT: f64 = 1e-6;
/// Colours of front and back in full light, red, green and blue from 0 to 255.
const FRONT: [f64; 3] = [240.0, 190.0, 110.0];
const BACK: [f64; 3] = [110.0, 150.0, 205.0];
/// Fraction of full light that every face receives, however it is turned.
const AMBIENT: f64 = 0.6;

fn main() -> Result<(), Box<dyn Error>> {
    let file = args_os().nth(1).unwrap_or_else(|| DEFAULT.into());
    if let Some(step) = args_os().nth(2) {
        let step = step.to_str().and_then(|step| step.parse().ok());
        let step = step.ok_or("expected the number of a step, such as 1")?;
        print!("{}", picture_of_step(Path::new(&file), step)?);
        return Ok(());
    }
    let pattern = read_pattern(Path::new(&file))?.pattern;
    let plan = plan(
        &pattern,
        &Goal::of_pattern(&pattern)?,
        &PlanOptions::default(),
    );
    let motion = plan.motion.ok_or("no motion leaves the flat sheet")?;

    // In the coordinates of the view, x points to the right, y up and z to the eye.
    let view = view();
    let seen = |shape: Vec<Vector3<f64>>| shape.iter().map(|point| view * point).collect();
    let frames: Vec<Vec<Vector3<f64>>> = shapes(&motion.resampled(FRAMES)).map(seen).collect();
    print!("{}", picture(&pattern, &frames)?);
    Ok(())
}

/// Draws the sheet of a path shortly before the end of a step, counted from 1: where layers come to lie on each other, they
/// are still apart there, so that the picture shows which one is in front.
pub(crate) fn picture_of_step(file: &Path, step: usize) -> Result<String, Box<dyn Error>> {
    let motion = read_motion(file)?;
    let ends = motion.phases.iter().copied().chain([motion.segments()]);
    let mut ends = ends.skip(step.saturating_sub(1));
    let knot = ends.next().filter(|_| step > 0);
    let knot = knot.ok_or_else(|| format!("the path has {} steps", motion.phases.len() + 1))?;
    let part = motion.knots[knot].time / motion.knots[motion.segments()].time;
    #[allow(
        clippy::cast_possible_truncation,
        clippy::cast_sign_loss,
        clippy::cast_precision_loss,
        reason = "a few hundred"
    )]
    let frame = (part * STILLS as f64) as usize;
    let view = view();
    let motion = motion.resampled(STILLS);
    let mut frames = shapes(&motion);
    let shape = frames.nth(frame.saturating_sub(2)).unwrap_or_default();
    let shape = shape.iter().map(|point| view * point).collect();
    Ok(picture(&motion.pattern, &[shape])?)
}

/// Returns the rotation from the sheet to the view.
fn view() -> Matrix3<f64> {
    let (azimuth, elevation) = (AZIMUTH.to_radians(), ELEVATION.to_radians());
    let level = Vector3::new(azimuth.cos(), azimuth.sin(), 0.0);
    let eye = level * elevation.cos() + Vector3::z() * elevation.sin();
    let right = Vector3::z().cross(&level);
    Matrix3::from_columns(&[right, eye.cross(&right), eye]).transpose()
}

/// Draws the frames one over the other, each shown in its turn.
fn picture(
    pattern: &CreasePattern,
    frames: &[Vec<Vector3<f64>>],
) -> Result<String, core::fmt::Error> {
    let points = || frames.iter().flatten();
    let low = points().fold(Vector3::repeat(f64::INFINITY), |low, point| low.inf(point));
    let high = points().fold(Vector3::repeat(f64::NEG_INFINITY), |high, point| {
        high.sup(point)
    });
    let scale = (WIDTH - 2.0 * MARGIN) / (high.x - low.x);
    let height = (high.y - low.y) * scale + 2.0 * MARGIN;

    let last = frames.len() - 1;
    let slots: Vec<usize> = repeat_n(0, REST)
        .chain(0..last)
        .chain(repeat_n(last, REST))
        .chain((1..=last).rev())
        .collect();
    #[allow(clippy::cast_precision_loss, reason = "a few dozen")]
    let duration = slots.len() as f64 * FRAME_S;

    let mut svg = String::new();
    writeln!(
        svg,
        "<svg xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"0 0 {WIDTH} {height:.0}\" \
         stroke=\"#333\" stroke-width=\".6\" stroke-linejoin=\"round\">"
    )?;
    for (number, frame) in frames.iter().enumerate() {
        // A program that does not play the picture shows the sheet half folded.
        let still = if number == frames.len() / 2 {
            "visible"
        } else {
            "hidden"
        };
        let shown = slots
            .iter()
            .map(|&slot| if slot == number { "visible" } else { "hidden" });
        let values: Vec<&str> = shown.collect();
        writeln!(
            svg,
            "<g visibility=\"{still}\"><animate attributeName=\"visibility\" calcMode=\"discrete\" \
             dur=\"{duration:.1}s\" repeatCount=\"indefinite\" values=\"{}\"/>",
            values.join(";")
        )?;
        let mut faces: Vec<Vec<Vector3<f64>>> = pattern
            .faces()
            .iter()
            .map(|face| face.iter().map(|vertex| frame[vertex.index()]).collect())
            .collect();
        faces.sort_by(|a, b| depth(a).total_cmp(&depth(b)));
        for face in &back_to_front(faces) {
            write!(svg, "<polygon fill=\"{}\" points=\"", fill(face))?;
            for (corner, point) in face.iter().enumerate() {
                let between = if corner == 0 { "" } else { " " };
                let x = (point.x - low.x) * scale + MARGIN;
                let y = (high.y - point.y) * scale + MARGIN;
                write!(svg, "{between}{x:.1},{y:.1}")?;
            }
            writeln!(svg, "\"/>")?;
        }
        writeln!(svg, "</g>")?;
    }
    writeln!(svg, "</svg>")?;
    Ok(svg)
}

/// Orders faces, given in the order of their depths, so that those behind the planes of others are drawn before these.
fn back_to_front(mut faces: Vec<Vec<Vector3<f64>>>) -> Vec<Vec<Vector3<f64>>> {
    let mut ordered = Vec::new();
    while !faces.is_empty() {
        let is_last = |a: &&Vec<Vector3<f64>>| {
            let lies_behind = |b: &Vec<_>| is_behind(b, a) && !is_behind(a, b);
            !faces.iter().any(lies_behind)
        };
        let next = faces.iter().position(|face| is_last(&face)).unwrap_or(0);
        ordered.push(faces.remove(next));
    }
    ordered
}

/// Returns `true` if a face lies behind the plane of another, or the other before its plane.
fn is_behind(face: &[Vector3<f64>], other: &[Vector3<f64>]) -> bool {
    let heights = |plane: &[Vector3<f64>], points: &[Vector3<f64>]| -> Vec<f64> {
        let normal = normal(plane);
        let up = normal * normal.z.signum();
        points
            .iter()
            .map(|point| up.dot(&(point - plane[0])))
            .collect()
    };
    let (below, above) = (heights(other, face), heights(face, other));
    below.iter().all(|height| *height <= FLAT) && below.iter().any(|height| *height < -FLAT)
        || above.iter().all(|height| *height >= -FLAT) && above.iter().any(|height| *height > FLAT)
}

/// Returns how near to the eye the middle of a face is.
fn depth(face: &[Vector3<f64>]) -> f64 {
    #[allow(clippy::cast_precision_loss, reason = "a few corners")]
    let corners = face.len() as f64;
    face.iter().map(|point| point.z).sum::<f64>() / corners
}

/// Returns the unit normal of a face.
fn normal(face: &[Vector3<f64>]) -> Vector3<f64> {
    // The sum over all corners is the normal of the polygon times twice its area (Newell's method).
    let next = face.iter().skip(1).chain(once(&face[0]));
    let normal: Vector3<f64> = face.iter().zip(next).map(|(a, b)| a.cross(b)).sum();
    normal.normalize()
}

/// Returns the colour of a face: its front or back, shaded by the angle to light from above on the left.
fn fill(face: &[Vector3<f64>]) -> String {
    let normal = normal(face);
    let colour = if normal.z > 0.0 { FRONT } else { BACK };
    let light = Vector3::new(-0.4, 0.6, 0.7).normalize();
    let towards_eye = normal * normal.z.signum();
    let shade = AMBIENT + (1.0 - AMBIENT) * towards_eye.dot(&light).max(0.0);
    let [red, green, blue] = colour.map(|part| part * shade);
    #[allow(
        clippy::cast_possible_truncation,
        clippy::cast_sign_loss,
        reason = "0 to 255"
    )]
    let byte = |part: f64| part.round() as u8;
    format!("#{:02x}{:02x}{:02x}", byte(red), byte(green), byte(blue))
}
