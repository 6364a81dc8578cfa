//! Draws a folding sheet as a moving picture in SVG:
//! `cargo run --release -p foldpath --example moving_picture -- pattern.fold picture.svg`.

use core::error::Error;
use core::fmt::Write;
use std::path::Path;

use foldpath::folding::shapes;
use foldpath::planner::{Goal, PlanOptions, plan};
use foldpath::read::read_pattern;
use nalgebra::{Rotation3, Vector3};

/// Number of configurations, from flat to the goal.
const FRAMES: usize = 24;
/// Seconds from flat to the goal and back.
const PERIOD_S: f64 = 6.0;
/// Width of the picture.
const WIDTH: f64 = 640.0;
/// Colours of the front and of the back of the paper: red, green and blue.
const COLOURS: [[f64; 3]; 2] = [[236.0, 106.0, 76.0], [246.0, 232.0, 208.0]];

fn main() -> Result<(), Box<dyn Error>> {
    let mut arguments = std::env::args().skip(1);
    let (Some(pattern), Some(picture)) = (arguments.next(), arguments.next()) else {
        return Err("expected a crease pattern and the name of the picture".into());
    };
    let file = read_pattern(Path::new(&pattern))?;
    let goal = Goal::of_pattern(&file.pattern)?;
    let motion = plan(&file.pattern, &goal, &PlanOptions::default()).motion;
    let motion = motion.ok_or("no motion was found")?.resampled(FRAMES);

    // The sheet is seen from above and in front.
    let view = Rotation3::from_axis_angle(&Vector3::x_axis(), -0.9)
        * Rotation3::from_axis_angle(&Vector3::z_axis(), 0.5);
    let frames: Vec<Vec<Vector3<f64>>> = shapes(&motion)
        .map(|shape| shape.iter().map(|point| view * point).collect())
        .collect();
    let points = || frames.iter().flatten();
    let (low, high) = points().fold((frames[0][0], frames[0][0]), |(low, high), p| {
        (low.inf(p), high.sup(p))
    });
    let scale = WIDTH / (high.x - low.x);
    let height = scale * (high.y - low.y);

    let mut svg = format!(
        "<svg xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"-8 -8 {:.0} {:.0}\" stroke=\"#432\" \
         stroke-width=\"0.6\" stroke-linejoin=\"round\">\n",
        WIDTH + 16.0,
        height + 16.0
    );
    for (index, shape) in frames.iter().enumerate() {
        writeln!(svg, "<g visibility=\"hidden\">{}", shown(index))?;
        let faces = file.pattern.faces().iter().map(|face| {
            let corners: Vec<Vector3<f64>> = face.iter().map(|v| shape[v.index()]).collect();
            let middle =
                corners.iter().sum::<Vector3<f64>>() / corners.iter().map(|_| 1.0).sum::<f64>();
            (middle.z, corners)
        });
        let mut faces: Vec<(f64, Vec<Vector3<f64>>)> = faces.collect();
        // Faces behind are drawn first.
        faces.sort_by(|a, b| a.0.total_cmp(&b.0));
        for (_, corners) in faces {
            let normal = (corners[1] - corners[0])
                .cross(&(corners[2] - corners[1]))
                .normalize();
            let light = 0.65 + 0.35 * normal.z.abs();
            let [r, g, b] = COLOURS[usize::from(normal.z < 0.0)].map(|c| c * light);
            write!(svg, "<path fill=\"rgb({r:.0},{g:.0},{b:.0})\" d=\"M")?;
            for corner in corners {
                let (x, y) = (scale * (corner.x - low.x), scale * (high.y - corner.y));
                write!(svg, "{x:.1} {y:.1} ")?;
            }
            svg += "Z\"/>";
        }
        svg += "</g>\n";
    }
    svg += "</svg>\n";
    std::fs::write(&picture, &svg)?;
    println!("{picture}: {FRAMES} shapes, {} bytes", svg.len());
    Ok(())
}

/// Returns the animation that shows a frame on the way to the goal and on the way back.
fn shown(index: usize) -> String {
    let steps = 2 * FRAMES - 2;
    let visible = |step: usize| step == index || step == steps - index;
    let values: Vec<&str> = (0..steps)
        .map(|step| if visible(step) { "visible" } else { "hidden" })
        .collect();
    format!(
        "<animate attributeName=\"visibility\" calcMode=\"discrete\" dur=\"{PERIOD_S}s\" repeatCount=\"indefinite\" \
         values=\"{}\"/>",
        values.join(";")
    )
}
