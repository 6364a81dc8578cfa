//! A controller that is told anything: `examples/fuzz.rs` runs as many executions as are asked for, this a few.

mod execution;
mod stream;
mod subject;

use execution::Tally;

use crate::path::Path;

#[test]
fn whatever_comes_nothing_is_executed_that_was_not_sent() {
    let path = Path::miura();
    let mut tally = Tally::default();
    for number in (0..EXECUTIONS).chain(FOUND) {
        tally.add(execution::run(&path, 0, number));
    }
    println!("{tally:?}");
    // Most of what is tried lies behind a path that moves.
    assert!(
        tally.moved > EXECUTIONS / 4 && tally.faulted > 0 && tally.done > 0,
        "{tally:?}"
    );
}

const EXECUTIONS: u64 = 10_000;
/// Executions that have found something: rates of a segment without time, a step shorter than what was carried.
const FOUND: [u64; 2] = [741_034, 786_375];
