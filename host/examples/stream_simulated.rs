//! Sends a planned path to the simulated controller: `cargo run --release -p foldpath --example stream_simulated`.

use core::error::Error;
use std::io;
use std::path::Path;

use foldpath::export::traj::TrajFile;
use foldpath::generate::Miura;
use foldpath::pattern::CreasePattern;
use foldpath::planner::{Goal, PlanOptions, plan};
use foldpath::stream::{self, Options, Sim, StreamPath, Telemetry, Watcher, Wish};

/// Counts telemetry, and stops nothing.
struct Counter(usize);

impl Watcher for Counter {
    fn telemetry(&mut self, _: &Telemetry) -> io::Result<()> {
        self.0 += 1;
        Ok(())
    }

    fn wish(&mut self) -> Wish {
        Wish::Run
    }
}

fn main() -> Result<(), Box<dyn Error>> {
    let miura = Miura {
        rows: 6,
        columns: 6,
        sector_angle: 60_f64.to_radians(),
        fold: 0.9,
    };
    let pattern = CreasePattern::new(miura.drawing()?)?;
    let plan = plan(
        &pattern,
        &Goal::of_pattern(&pattern)?,
        &PlanOptions::default(),
    );
    let motion = plan.motion.ok_or("no motion was found")?;

    // The name of the file is for messages: nothing is written.
    let name = Path::new("miura-6x6.traj");
    let bytes = TrajFile::of(&motion, name)?.bytes;
    let path = StreamPath::read(&bytes, name)?;
    let mut counter = Counter(0);
    let options = Options {
        resume: false,
        id: 1,
    };
    let summary = stream::run(&mut Sim::new(), &path, options, &mut counter)?;
    println!(
        "{:?}: {} setpoints in {} bytes, {} messages of telemetry, closure at most {:.1e}",
        summary.outcome, summary.setpoints, summary.bytes_sent, counter.0, summary.max_closure
    );
    Ok(())
}
