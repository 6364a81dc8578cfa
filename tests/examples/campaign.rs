//! Plans many seeded sheets and judges each path by the oracle:
//! `cargo run --release -p foldpath-tests --example campaign -- --count 1000 --seed 1`.

use core::time::Duration;
use std::path::PathBuf;

use clap::Parser;
use foldpath::formats::fold::pattern_text;
use foldpath::planner::PlanOptions;
use foldpath_tests::campaign::{Family, Report, run};

/// Plans many seeded sheets and judges each path by the oracle
#[derive(Parser)]
struct Arguments {
    /// Sheets, shared evenly by the families
    #[arg(long, default_value_t = 1000)]
    count: u64,
    /// First seed of every family
    #[arg(long, default_value_t = 1)]
    seed: u64,
    /// Only this family
    #[arg(long)]
    family: Option<String>,
    /// Seconds for each plan
    #[arg(long, default_value_t = 10.0)]
    timeout: f64,
    /// Folder for the patterns that were not planned
    #[arg(long)]
    write: Option<PathBuf>,
}

fn main() -> std::io::Result<()> {
    let arguments = Arguments::parse();
    let wanted = |family: &Family| {
        let only = arguments.family.as_deref();
        only.is_none_or(|name| name == family.name)
    };
    let families: Vec<Family> = Family::ALL.iter().copied().filter(wanted).collect();
    if families.is_empty() {
        let names: Vec<_> = Family::ALL.iter().map(|family| family.name).collect();
        return Err(std::io::Error::other(format!(
            "--family: expected one of {}",
            names.join(", ")
        )));
    }
    let options = PlanOptions {
        timeout: Some(Duration::from_secs_f64(arguments.timeout)),
        ..PlanOptions::default()
    };
    let each = arguments.count.div_ceil(families.len() as u64);
    let tallies = families
        .iter()
        .map(|&family| (family, run(family, arguments.seed, each, &options)));
    let report = Report(tallies.collect());
    print!("{report}");
    if let Some(folder) = arguments.write {
        std::fs::create_dir_all(&folder)?;
        for (family, tally) in &report.0 {
            for &seed in tally.others.values().flatten() {
                let title = format!("{}-{seed}", family.name);
                let text = pattern_text(&title, &family.sheet(seed));
                std::fs::write(folder.join(title + ".fold"), text)?;
            }
        }
    }
    Ok(())
}
