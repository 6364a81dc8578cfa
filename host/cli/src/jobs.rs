//! Threads that share the work of a command.

use clap::Args;

/// Options of commands whose work is shared by threads.
#[derive(Clone, Copy, Debug, Args)]
pub(crate) struct Jobs {
    /// Share the work among this many threads; the answer is the same for any number [default: one for each core]
    #[arg(long, value_name = "K", value_parser = clap::value_parser!(u16).range(1..=1024))]
    jobs: Option<u16>,
}

impl Jobs {
    /// Does the work with as many threads as are asked for. This thread is one of them.
    pub(crate) fn run<T: Send>(self, work: impl FnOnce() -> T + Send) -> T {
        let Some(jobs) = self.jobs else {
            return work();
        };
        let pool = |threads: usize| {
            let pool = rayon::ThreadPoolBuilder::new().num_threads(threads);
            pool.use_current_thread().build()
        };
        // A system that gives no more threads has this one.
        match pool(jobs.into()).or_else(|_| pool(1)) {
            Ok(pool) => pool.install(work),
            Err(_) => work(),
        }
    }
}
