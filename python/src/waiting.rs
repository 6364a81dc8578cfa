//! Long calls: a thread works, Python's other threads go on, and Ctrl-C ends the call.

use core::panic::AssertUnwindSafe;
use core::time::Duration;
use std::panic::catch_unwind;
use std::sync::Arc;
use std::sync::mpsc::{RecvTimeoutError, channel};
use std::thread;

use foldpath::progress::Progress;
use foldpath::util::parallel::alone;
use foldpath_cli::embed::panic_text;
use pyo3::exceptions::PyRuntimeError;
use pyo3::prelude::*;

/// Time after which signals are looked for again.
const PACE: Duration = Duration::from_millis(20);
/// Stack of a thread that works, bytes: that of a program's first thread, where the command works.
const STACK_BYTES: usize = 8 << 20;

/// Number of threads that share the work of a call.
#[derive(Clone, Copy, Debug)]
pub(crate) enum Threads {
    /// One for each core, in the pool of the process.
    All,
    /// So many, for this call.
    Some(usize),
}

impl Threads {
    /// Returns the threads of a call. `jobs` is their number, if one is asked for. A forked process has no pool, because
    /// threads do not survive a fork; there the work is not shared by default.
    pub(crate) fn of(jobs: Option<usize>, is_forked: bool) -> Self {
        match jobs {
            None if is_forked => Self::Some(1),
            None => Self::All,
            Some(jobs) => Self::Some(jobs),
        }
    }

    fn run<T: Send>(self, work: impl FnOnce() -> T + Send) -> T {
        match self {
            Self::All => work(),
            Self::Some(0 | 1) => alone(work),
            Self::Some(count) => {
                let pool = rayon::ThreadPoolBuilder::new().num_threads(count);
                match pool.build() {
                    Ok(pool) => pool.install(work),
                    // A system that gives no more threads has this one.
                    Err(_) => alone(work),
                }
            }
        }
    }
}

/// Does the work in a thread of its own and waits for it. If a signal's handler raises an exception meanwhile, as Ctrl-C
/// does, the work is cancelled and the exception is returned at once; the thread ends soon after.
///
/// # Errors
/// What a signal's handler raises, or a `RuntimeError` if the work panics.
pub(crate) fn waiting<T: Send + 'static>(
    py: Python<'_>,
    threads: Threads,
    work: impl FnOnce(&Progress) -> T + Send + 'static,
) -> PyResult<T> {
    let progress = Arc::new(Progress::new());
    let (sender, mut receiver) = channel();
    let shared = Arc::clone(&progress);
    let builder = thread::Builder::new()
        .name("foldpath".into())
        .stack_size(STACK_BYTES);
    builder.spawn(move || {
        let result = catch_unwind(AssertUnwindSafe(|| threads.run(|| work(&shared))));
        // Nobody waits any more if the call was cancelled.
        let _gone = sender.send(result);
    })?;
    loop {
        let (back, received) = py.detach(move || {
            let received = receiver.recv_timeout(PACE);
            (receiver, received)
        });
        receiver = back;
        match received {
            Ok(result) => {
                return result.map_err(|panic| PyRuntimeError::new_err(panic_text(&*panic)));
            }
            Err(RecvTimeoutError::Timeout) => {
                py.check_signals().inspect_err(|_| progress.cancel())?;
            }
            Err(RecvTimeoutError::Disconnected) => {
                return Err(PyRuntimeError::new_err(panic_text(&"the thread ended")));
            }
        }
    }
}
