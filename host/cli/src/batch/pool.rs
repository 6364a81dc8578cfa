//! The processes that plan designs, with the time that each design may take.

use core::time::Duration;
use std::collections::BTreeMap;
use std::ffi::OsString;
use std::io::{self, BufRead, BufReader, Write};
use std::process::{Child, ChildStdin, Command, ExitStatus, Stdio};
use std::sync::mpsc::{Receiver, RecvTimeoutError, Sender, channel};
use std::sync::{Condvar, Mutex, PoisonError};
use std::thread;

use indicatif::ProgressBar;

use super::design::{Designs, Task};
use super::results::{Counts, Head, Results};
use super::worker::failed;
use crate::CliError;
use crate::report::ErrorFields;

/// Largest number of results that wait for an earlier one to be written.
const MAX_WAITING: u64 = 1 << 14;
/// Time beyond its timeout after which a design counts as hanging: seconds, and a fraction of the timeout. Planning ends
/// at its timeout by itself; a machine may be too busy for that to be on time.
const PATIENCE: (f64, f64) = (5.0, 0.5);

/// Limits of a run.
pub(super) struct Limits<'a> {
    /// Number of processes.
    pub(super) jobs: usize,
    /// Time of designs that name none, seconds.
    pub(super) timeout: f64,
    /// Leaves out what depends on the clock.
    pub(super) stable: bool,
    /// The command that starts foldpath once more: a program and its first arguments.
    pub(super) program: &'a [OsString],
}

/// Number of results that are written. Workers wait for it if their designs are too far ahead.
struct Progress {
    /// Number of results that are written; `None` once the run is to end.
    written: Mutex<Option<u64>>,
    more: Condvar,
}

impl Progress {
    fn set(&self, written: Option<u64>) {
        *self.written.lock().unwrap_or_else(PoisonError::into_inner) = written;
        self.more.notify_all();
    }

    /// Waits until a result may be made. Returns `false` if the run is to end.
    fn wait_for(&self, place: u64) -> bool {
        let written = self.written.lock().unwrap_or_else(PoisonError::into_inner);
        let ahead = |written: &mut Option<u64>| {
            written.is_some_and(|written| place >= written + MAX_WAITING)
        };
        let written = self.more.wait_while(written, ahead);
        written.unwrap_or_else(PoisonError::into_inner).is_some()
    }
}

/// A result and its place, or the reason why no more can be made.
type Message = Result<(u64, String), CliError>;

/// Plans all designs and writes their results in order.
///
/// # Errors
/// If designs cannot be read, results not be written, or processes not be started.
pub(super) fn run<R: BufRead + Send>(
    designs: Designs<R>,
    mut results: Results,
    limits: &Limits<'_>,
    bar: &ProgressBar,
) -> Result<Counts, CliError> {
    let designs = Mutex::new(designs);
    let progress = Progress {
        written: Mutex::new(Some(0)),
        more: Condvar::new(),
    };
    let (sender, receiver) = channel();
    thread::scope(|scope| {
        for _ in 0..limits.jobs {
            let sender = sender.clone();
            let (designs, progress) = (&designs, &progress);
            scope.spawn(move || work(designs, limits, progress, &sender));
        }
        drop(sender);
        let counts = write(&receiver, &mut results, &progress, bar);
        progress.set(None);
        counts
    })
}

/// Writes results in order until there are no more.
fn write(
    receiver: &Receiver<Message>,
    results: &mut Results,
    progress: &Progress,
    bar: &ProgressBar,
) -> Result<Counts, CliError> {
    let mut counts = Counts::default();
    let mut waiting = BTreeMap::new();
    let mut next = 0;
    for message in receiver {
        let (place, result) = message?;
        waiting.insert(place, result);
        while let Some(result) = waiting.remove(&next) {
            results.write(&result)?;
            counts.add(&result);
            bar.inc(1);
            next += 1;
        }
        progress.set(Some(next));
    }
    Ok(counts)
}

/// Plans designs until there are no more.
fn work<R: BufRead>(
    designs: &Mutex<Designs<R>>,
    limits: &Limits<'_>,
    progress: &Progress,
    results: &Sender<Message>,
) {
    let mut worker = None;
    loop {
        let task = designs
            .lock()
            .unwrap_or_else(PoisonError::into_inner)
            .next_task();
        let message = match task {
            Ok(None) => return,
            Ok(Some(task)) if progress.wait_for(task.place) => result(&mut worker, &task, limits),
            Ok(Some(_)) => return,
            Err(error) => Err(CliError::Usage(format!(
                "the designs cannot be read: {error}"
            ))),
        };
        let ends = message.is_err();
        if results.send(message).is_err() || ends {
            return;
        }
    }
}

/// Returns the result of a design, by a worker that is started if there is none.
fn result(worker: &mut Option<Worker>, task: &Task, limits: &Limits<'_>) -> Message {
    let line = match &task.line {
        Ok(line) => line,
        Err(error) => {
            return Ok((
                task.place,
                failed(
                    &task.id,
                    task.design.as_ref(),
                    ErrorFields::of_message(error),
                ),
            ));
        }
    };
    let running = match worker {
        Some(worker) => worker,
        None => worker.insert(
            Worker::start(limits)
                .map_err(|error| CliError::Usage(format!("no process can be started: {error}")))?,
        ),
    };
    let timeout = task.timeout.unwrap_or(limits.timeout);
    let patience = Duration::try_from_secs_f64(PATIENCE.0 + (1.0 + PATIENCE.1) * timeout);
    let result = running
        .ask(&task.id, line, patience.ok())
        .unwrap_or_else(|failure| {
            *worker = None;
            failed(
                &task.id,
                task.design.as_ref(),
                ErrorFields::of_message(&failure),
            )
        });
    Ok((task.place, result))
}

/// A process that plans one design after the other.
struct Worker {
    process: Child,
    /// `None` once no more designs come.
    designs: Option<ChildStdin>,
    results: Receiver<String>,
}

impl Worker {
    fn start(limits: &Limits<'_>) -> io::Result<Self> {
        let [program, arguments @ ..] = limits.program else {
            return Err(io::ErrorKind::NotFound.into());
        };
        let mut command = Command::new(program);
        command
            .args(arguments)
            .args(["batch", "-", "-o", "-", "--worker"])
            .arg(format!("--timeout={}", limits.timeout));
        if limits.stable {
            command.arg("--stable");
        }
        // Each worker is one thread: the designs share the cores.
        command
            .env("RAYON_NUM_THREADS", "1")
            .stdin(Stdio::piped())
            .stdout(Stdio::piped())
            .stderr(Stdio::null());
        let mut process = command.spawn()?;
        let (sender, results) = channel();
        let designs = process.stdin.take();
        let output = process.stdout.take();
        thread::spawn(move || {
            // The thread ends with the process, or with those who wait for its results.
            for line in BufReader::new(output?).lines() {
                sender.send(line.ok()?).ok()?;
            }
            Some(())
        });
        Ok(Self {
            process,
            designs,
            results,
        })
    }

    /// Returns the result of a design, or why there is none; then the process has ended.
    fn ask(&mut self, id: &str, line: &str, patience: Option<Duration>) -> Result<String, String> {
        // If the process has ended, it has no result either.
        let _gone = self
            .designs
            .as_mut()
            .map(|designs| designs.write_all(format!("{line}\n").as_bytes()));
        let received = match patience {
            Some(patience) => self.results.recv_timeout(patience),
            None => self
                .results
                .recv()
                .map_err(|_| RecvTimeoutError::Disconnected),
        };
        let result = received.map_err(|error| match error {
            RecvTimeoutError::Timeout => {
                "a defect of foldpath: the design did not end at its timeout and was stopped".into()
            }
            RecvTimeoutError::Disconnected => {
                let status = self.process.wait();
                let how = status.map_or_else(
                    |error| error.to_string(),
                    |status: ExitStatus| status.to_string(),
                );
                format!("a defect of foldpath, or too little memory: its process ended ({how})")
            }
        })?;
        let found = serde_json::from_str::<Head>(&result);
        found
            .is_ok_and(|found| found.id == id)
            .then_some(result)
            .ok_or_else(|| "a defect of foldpath: its process answered something else".into())
    }
}

impl Drop for Worker {
    fn drop(&mut self) {
        // A process without a design ends with its input; one that hangs is stopped.
        self.designs = None;
        if !self
            .results
            .recv_timeout(Duration::from_millis(200))
            .is_err_and(|error| error == RecvTimeoutError::Disconnected)
        {
            let _gone = self.process.kill();
        }
        let _gone = self.process.wait();
    }
}
