//! Sends a planned path to a simulated controller, which runs the firmware's code in virtual time, and watches its
//! telemetry.
//!
//! ```text
//! cargo run --release --example stream_simulated
//! ```

use core::error::Error;
use std::io;
use std::path::Path;

use foldpath::export::traj::TrajFile;
use foldpath::generate::Miura;
use foldpath::pattern::CreasePattern;
use foldpath::planner::{Goal, PlanOptions, plan};
use foldpath::stream::{self, Options, Sim, StreamPath, Telemetry, Watcher, Wish};

/// Keeps the largest closure residual of the angles that the controller reports.
struct LargestClosure<'a> {
    path: &'a StreamPath,
    residual: f64,
}

impl Watcher for LargestClosure<'_> {
    fn telemetry(&mut self, telemetry: &Telemetry) -> io::Result<()> {
        self.residual = self.residual.max(self.path.residual(&telemetry.angles));
        Ok(())
    }

    /// Called again and again; `Wish::Stop` would slow the motion down and hold the sheet.
    fn wish(&mut self) -> Wish {
        Wish::Run
    }
}

fn main() -> Result<(), Box<dyn Error>> {
    let miura = Miura {
        rows: 4,
        columns: 4,
        sector_angle: 60_f64.to_radians(),
        fold: 0.9,
    };
    let pattern = CreasePattern::new(miura.drawing()?)?;
    let plan = plan(
        &pattern,
        &Goal::of_pattern(&pattern)?,
        &PlanOptions::default(),
    );
    let motion = plan.motion.ok_or("no motion leaves the flat sheet")?;

    // The name is for messages: no file is written.
    let name = Path::new("miura.traj");
    let path = StreamPath::read(&TrajFile::of(&motion, name)?.bytes, name)?;
    let mut watcher = LargestClosure {
        path: &path,
        residual: 0.0,
    };
    let options = Options::default().with(|it| it.id = 1);
    let summary = stream::run(&mut Sim::new(), &path, options, &mut watcher)?;

    println!("outcome          {}", summary.outcome.name());
    if let Some(reason) = &summary.reason {
        println!("reason           {reason}");
    }
    println!("largest closure  {:.1e}", watcher.residual);
    println!("setpoints        {}", summary.setpoints);
    println!("bytes sent       {}", summary.bytes_sent);
    Ok(())
}
