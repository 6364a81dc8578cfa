//! Counts the instructions of the hot kernels by callgrind and compares them with stored figures:
//! `tests/instructions/run`.
//!
//! Times on a shared machine differ by a tenth from run to run; the number of instructions of a program on fixed input
//! does not. The figures hold for the toolchain in `rust-toolchain.toml`, the profile dist and x86-64 without further
//! features. glibc chooses instructions at run time; it is counted on a processor with AVX2.

mod callgrind;
mod figures;
mod kernels;

use std::process::ExitCode;

use clap::Parser;

use figures::Figures;
use kernels::Kernel;

/// Relative difference of a count from its stored figure that is not reported.
const TOLERANCE: f64 = 0.02;

/// Counts the instructions of the hot kernels and compares them with stored figures
#[derive(Parser)]
struct Arguments {
    /// Only these kernels
    kernels: Vec<String>,
    /// Leave out what takes more than a few seconds
    #[arg(long)]
    short: bool,
    /// Store what is counted
    #[arg(long)]
    write: bool,
    /// Run this kernel, once to warm up and then to be counted
    #[arg(long, hide = true)]
    only_run: Option<String>,
}

fn main() -> ExitCode {
    let arguments = Arguments::parse();
    if let Some(name) = &arguments.only_run {
        kernels::find(name).expect("a kernel").run();
        return ExitCode::SUCCESS;
    }
    if !cfg!(all(target_arch = "x86_64", target_os = "linux")) {
        println!("skipped: the figures are of x86-64 Linux");
        return ExitCode::SUCCESS;
    }
    match guard(&arguments) {
        Ok(true) => ExitCode::SUCCESS,
        Ok(false) => ExitCode::FAILURE,
        Err(error) => {
            eprintln!("error: {error}");
            ExitCode::from(2)
        }
    }
}

/// Counts, compares and prints. Returns `true` if no count has grown.
fn guard(arguments: &Arguments) -> Result<bool, String> {
    let named = |kernel: &&Kernel| {
        let names = &arguments.kernels;
        let wanted = names.is_empty() || names.iter().any(|name| name == kernel.name);
        wanted && !(arguments.short && kernel.long)
    };
    if let Some(unknown) = arguments
        .kernels
        .iter()
        .find(|name| kernels::find(name).is_none())
    {
        let names: Vec<_> = kernels::ALL.iter().map(|kernel| kernel.name).collect();
        return Err(format!(
            "kernel {unknown}: expected one of {}",
            names.join(", ")
        ));
    }
    let mut stored = Figures::read()?;
    println!("| kernel | work | instructions | stored | ratio |");
    println!("|---|---|---|---|---|");
    let mut news = Vec::new();
    for kernel in kernels::ALL.iter().filter(named) {
        let counted = callgrind::count(kernel)?;
        let figure = stored.of(kernel.name);
        let ratio = figure.map(|figure| counted / figure);
        let grown = ratio.is_none_or(|ratio| ratio > 1.0 + TOLERANCE);
        if grown || ratio.is_some_and(|ratio| ratio < 1.0 - TOLERANCE) {
            news.push((kernel.name, grown));
        }
        let show = |value: Option<f64>, digits| {
            value.map_or_else(|| "none".into(), |value| format!("{value:.digits$}"))
        };
        let (figure, ratio) = (show(figure, 0), show(ratio, 4));
        let Kernel { name, work, .. } = kernel;
        println!("| {name} | {work} | {counted:.0} | {figure} | {ratio} |");
        stored.set(kernel.name, counted);
    }
    println!(
        "\nInstructions a call, counted by callgrind under {}, profile dist. A figure that grows by more than \
         {:.0} % fails.",
        figures::TOOLCHAIN,
        100.0 * TOLERANCE
    );
    if arguments.write {
        stored.write()?;
        return Ok(true);
    }
    for (name, grown) in &news {
        let what = if *grown {
            "more than stored, or not stored yet"
        } else {
            "fewer than stored: store it, so that it stays"
        };
        eprintln!("{name}: {what} (tests/instructions/run --write {name})");
    }
    Ok(!news.iter().any(|(_, grown)| *grown))
}
