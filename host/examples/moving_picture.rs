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

/// Draws the sheet of a path at the end of a step, counted from 1.
pub(crate) fn picture_of_step(file: &Path, step: usize) -> Result<String, Box<dyn Error>> {
    let motion = read_motion(file)?;
    let ends = motion.phases.iter().copied().chain([motion.segments()]);
    let mut ends = ends.skip(step.saturating_sub(1));
    let knot = ends.next().filter(|_| step > 0);
    let knot = knot.ok_or_else(|| format!("the path has {} steps", motion.phases.len() + 1))?;
    let view = view();
    let shape = shapes(&motion).nth(knot).unwrap_or_default();
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
        for face in &faces {
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

/// Returns how near to the eye the middle of a face is.
fn depth(face: &[Vector3<f64>]) -> f64 {
    #[allow(clippy::cast_precision_loss, reason = "a few corners")]
    let corners = face.len() as f64;
    face.iter().map(|point| point.z).sum::<f64>() / corners
}

/// Returns the colour of a face: its front or back, shaded by the angle to light from above on the left.
fn fill(face: &[Vector3<f64>]) -> String {
    // The sum over all corners is the normal of the polygon times twice its area (Newell's method).
    let next = face.iter().skip(1).chain(once(&face[0]));
    let normal: Vector3<f64> = face.iter().zip(next).map(|(a, b)| a.cross(b)).sum();
    let normal = normal.normalize();
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
