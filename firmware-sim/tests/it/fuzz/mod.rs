//! Does a controller execute only what was sent, whatever it is told? This test runs a few executions;
//! `examples/fuzz.rs` runs as many as are asked for.

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
    // Most faults can only be found behind a path that moves.
    assert!(
        tally.moved > EXECUTIONS / 4
            && tally.faulted > 0
            && tally.done > 0
            && tally.jogged > EXECUTIONS / 10,
        "{tally:?}"
    );
}

const EXECUTIONS: u64 = 10_000;
/// Executions that have found a fault: rates of a segment without duration, and a step shorter than the carry of the
/// compensated sum.
const FOUND: [u64; 2] = [741_034, 786_375];
