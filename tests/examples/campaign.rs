//! Runs a campaign and prints its summary to stdout: `cargo run --release -p foldpath-tests --example campaign --
//! stars|plans|paths|torn --count 1000 --seed 1`. `tests/campaign/run` runs all campaigns.

use core::time::Duration;
use std::path::{Path, PathBuf};
use std::process::ExitCode;
use std::time::Instant;

use clap::{Parser, Subcommand};
use foldpath::export::fold::pattern_text;
use foldpath::planner::PlanOptions;
use foldpath_tests::campaign::{Family, Report, paths, run, stars, torn};

/// Judges many seeded stars, plans or paths
#[derive(Parser)]
struct Arguments {
    #[command(subcommand)]
    what: What,
    /// How many
    #[arg(long, global = true, default_value_t = 1000)]
    count: u64,
    /// First seed
    #[arg(long, global = true, default_value_t = 1)]
    seed: u64,
}

#[derive(Subcommand)]
enum What {
    /// Closure, Jacobian and solvers on random stars, against 4x4 matrices
    Stars,
    /// Plans of seeded sheets, shared evenly by the families but for a smaller part of files, judged by check and by the
    /// oracle
    Plans {
        /// Only this family
        #[arg(long)]
        family: Option<String>,
        /// Seconds for each plan
        #[arg(long, default_value_t = 10.0)]
        timeout: f64,
        /// Folder for the patterns that were not planned or that are in dispute
        #[arg(long)]
        write: Option<PathBuf>,
    },
    /// Good paths, spoilt: check, exports and the follower
    Paths {
        /// Folder for those in dispute
        #[arg(long)]
        write: Option<PathBuf>,
    },
    /// Motions of torn sheets: does check find all crossings?
    Torn {
        /// Only this kind
        #[arg(long)]
        kind: Option<String>,
        /// Folder for those that cross and are said to hold
        #[arg(long)]
        write: Option<PathBuf>,
    },
}

fn main() -> std::io::Result<ExitCode> {
    let Arguments { what, count, seed } = Arguments::parse();
    let start = Instant::now();
    let good = match what {
        What::Stars => {
            let stars = stars::run(seed, count);
            println!("{stars}");
            stars.failures.is_empty()
        }
        What::Plans {
            family,
            timeout,
            write,
        } => {
            let report = plans(family.as_deref(), seed, count, timeout)?;
            println!("{report}");
            if let Some(folder) = write {
                write_plans(&report, &folder)?;
            }
            report.is_good()
        }
        What::Paths { write } => {
            let paths = paths::run(seed, count);
            println!("{paths}");
            if let Some(folder) = write {
                std::fs::create_dir_all(&folder)?;
                for (seed, _) in &paths.failures {
                    let text = paths::path_of(*seed).to_string();
                    std::fs::write(folder.join(format!("path-{seed}.fold")), text)?;
                }
            }
            paths.failures.is_empty()
        }
        What::Torn { kind, write } => {
            let torn = torn(kind.as_deref(), seed, count)?;
            println!("{torn}");
            if let Some(folder) = write {
                std::fs::create_dir_all(&folder)?;
                for (kind, judged) in torn.false_holds() {
                    let name = format!("{}-{}.fold", kind.name(), judged.seed);
                    std::fs::write(
                        folder.join(name),
                        torn::motion_of(*kind, judged.seed).to_string(),
                    )?;
                }
            }
            torn.is_good()
        }
    };
    eprintln!("{:?}", start.elapsed());
    Ok(if good {
        ExitCode::SUCCESS
    } else {
        ExitCode::FAILURE
    })
}

fn torn(only: Option<&str>, seed: u64, count: u64) -> std::io::Result<torn::Torn> {
    let wanted = |kind: &torn::Kind| only.is_none_or(|name| name == kind.name());
    let kinds: Vec<_> = torn::Kind::ALL.into_iter().filter(wanted).collect();
    if kinds.is_empty() {
        let names = torn::Kind::ALL.map(torn::Kind::name);
        return Err(std::io::Error::other(format!(
            "--kind: expected one of {}",
            names.join(", ")
        )));
    }
    let each = count.div_ceil(kinds.len() as u64);
    Ok(torn::run(&kinds, seed, each))
}

fn plans(only: Option<&str>, seed: u64, count: u64, timeout: f64) -> std::io::Result<Report> {
    let wanted = |family: &Family| only.is_none_or(|name| name == family.name);
    let families: Vec<Family> = Family::ALL.iter().copied().filter(wanted).collect();
    if families.is_empty() {
        let names: Vec<_> = Family::ALL.iter().map(|family| family.name).collect();
        return Err(std::io::Error::other(format!(
            "--family: expected one of {}",
            names.join(", ")
        )));
    }
    let options =
        PlanOptions::default().with(|it| it.timeout = Some(Duration::from_secs_f64(timeout)));
    let each = count.div_ceil(families.len() as u64);
    let tallies = families.iter().map(|&family| {
        eprintln!("{}", family.name);
        // Some patterns of files take all the time that they are given.
        let each = if family.real { each.div_ceil(4) } else { each };
        (family, run(family, seed, each, &options))
    });
    Ok(Report(tallies.collect()))
}

/// Writes the sheets that were not planned, and those in dispute, to a folder.
fn write_plans(report: &Report, folder: &Path) -> std::io::Result<()> {
    std::fs::create_dir_all(folder)?;
    for (family, tally) in &report.0 {
        let disputes = tally.disagreements.iter().chain(&tally.panics);
        let disputes = disputes.map(|(seed, _)| seed);
        for &seed in tally.others.values().flatten().chain(disputes) {
            for (otherwise, sheet) in ["", "-otherwise"].into_iter().zip(family.sheets(seed)) {
                let title = format!("{}-{seed}{otherwise}", family.name);
                let text = pattern_text(&title, &sheet);
                std::fs::write(folder.join(title + ".fold"), text)?;
            }
        }
    }
    Ok(())
}
