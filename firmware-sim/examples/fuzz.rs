//! Fuzzes the controller with random executions, and with a model of what a controller may do.
//!
//! `CARGO_PROFILE_DEV_OPT_LEVEL=3 cargo run -p foldpath-firmware-sim --example fuzz -- 10000000 [SEED] [FIRST]` runs
//! that many executions, counted from number FIRST. This profile checks for overflow. A failure names its execution:
//! the same command with that number as FIRST and 1 execution repeats it.
//!
//! `-- lives 2000 [FIRST]` in place of the numbers runs whole lives of boards, up to the first that fails. A failure names its
//! seed, which FIRST takes.

#[path = "../tests/it/fuzz/execution.rs"]
mod execution;
#[path = "../tests/it/lives.rs"]
mod lives;
#[allow(dead_code, reason = "tests use more of the board")]
#[path = "../tests/it/machine.rs"]
mod machine;
#[path = "../tests/it/path.rs"]
mod path;
#[path = "../tests/it/fuzz/stream.rs"]
mod stream;
#[path = "../tests/it/fuzz/subject.rs"]
mod subject;

use std::env;
use std::panic::catch_unwind;
use std::process::ExitCode;
use std::time::Instant;

use execution::Tally;
use path::Path;

fn main() -> ExitCode {
    let mut words = env::args().skip(1).peekable();
    let of_lives = words.next_if_eq("lives").is_some();
    let mut numbers = words.map(|word| word.parse().expect("a number"));
    let mut next = |default: u64| numbers.next().unwrap_or(default);
    if of_lives {
        let (count, first) = (next(2000), next(0));
        let start = Instant::now();
        let tally = lives::live(first..first + count);
        println!(
            "{count} lives from {first}, {:?}\n{tally:?}",
            start.elapsed()
        );
        return ExitCode::SUCCESS;
    }
    let (executions, seed, first) = (next(1_000_000), next(0), next(0));
    let (path, start) = (Path::miura(), Instant::now());
    let (mut tally, mut failures) = (Tally::default(), 0);
    for number in first..first + executions {
        match catch_unwind(|| execution::run(&path, seed, number)) {
            Ok(one) => tally.add(one),
            Err(_) => {
                println!("execution {number} of seed {seed} failed");
                failures += 1;
            }
        }
        if failures == 10 {
            break;
        }
    }
    println!(
        "{executions} executions from {first}, seed {seed}, {failures} failures, {:?}",
        start.elapsed()
    );
    println!("{tally:?}");
    if failures == 0 {
        ExitCode::SUCCESS
    } else {
        ExitCode::FAILURE
    }
}
