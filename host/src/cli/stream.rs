//! `foldpath stream`.

use std::io::{self, IsTerminal, Write};
use std::path::Path;
use std::sync::Arc;
use std::sync::atomic::{AtomicU8, Ordering};
use std::time::{Duration, Instant, SystemTime};

use foldpath_core::follower::State;
use serde::Serialize;

use super::args::{LineFaults, Stream, Target};
use super::{Answer, CliError, check_output, print, print_json, say};
use crate::formats::fold::read_path;
use crate::formats::{FileError, read_pattern, write_whole_with};
use crate::stream::{
    Link, Options, Outcome, Sim, StreamPath, Summary, Tcp, Telemetry, Watcher, Wish, run as follow,
};

/// Time between two lines of progress.
const PACE: Duration = Duration::from_millis(100);

#[derive(Serialize)]
struct StreamJson<'a> {
    outcome: &'a str,
    reason: Option<&'a str>,
    setpoints: u64,
    bytes_sent: u64,
    retransmitted: u64,
    refused: u64,
    max_closure: Option<f64>,
    duration: f64,
}

pub(super) fn run(args: &Stream) -> Answer {
    if let Some(log) = &args.log {
        check_output(&args.path, log)?;
        if let Some(pattern) = &args.pattern {
            check_output(pattern, log)?;
        }
    }
    let path = read(args)?;
    let quiet = args.report.quiet;
    if !quiet && path.residual(&vec![0.0; path.groups()]).is_none() {
        say("note: without --pattern the controller checks the closure of no vertex");
    }
    let pressed = Arc::new(AtomicU8::new(0));
    let count = Arc::clone(&pressed);
    // Without a handler Ctrl-C ends the process, and the controller holds for the silence.
    let _default = ctrlc::set_handler(move || {
        count.fetch_add(1, Ordering::Relaxed);
    });
    let watch = |log| Watch {
        path: &path,
        log,
        pressed: &pressed,
        shown: None,
        progress: !quiet && io::stderr().is_terminal(),
    };
    let options = |id| Options {
        resume: args.resume,
        id,
    };
    let summary = match (&args.to, args.faults) {
        (Target::Sim, faults) => {
            let LineFaults { faults, seed } = faults.unwrap_or_default();
            let sim = Sim::new(faults, seed);
            session(sim, &path, options(1), args.log.as_deref(), watch)?
        }
        (Target::Tcp(_), Some(_)) => {
            let text = "--faults: expected with --to sim alone";
            return Err(CliError::Usage(text.into()));
        }
        (Target::Tcp(address), None) => match Tcp::connect(address) {
            Ok(tcp) => session(tcp, &path, options(id()), args.log.as_deref(), watch)?,
            Err(error) => no_device(&format!("tcp:{address}: {error}")),
        },
    };
    report(args, &path, &summary)?;
    Ok(summary.outcome == Outcome::Done)
}

/// The path of a `.traj` file or a FOLD animation, told apart by how they begin.
fn read(args: &Stream) -> Result<StreamPath, CliError> {
    let bytes = std::fs::read(&args.path).map_err(|source| FileError::Io {
        path: args.path.clone(),
        source,
    })?;
    let is_traj = bytes.starts_with(&foldpath_core::trajectory_file::MAGIC);
    match &args.pattern {
        Some(_) if !is_traj => {
            let text = "--pattern: expected with a .traj file alone, a path has its pattern";
            Err(CliError::Usage(text.into()))
        }
        pattern if is_traj => {
            let file = pattern.as_ref().map(|file| read_pattern(file));
            let pattern = file.transpose()?.map(|file| file.pattern);
            Ok(StreamPath::of_traj(&bytes, pattern.as_ref(), &args.path)?)
        }
        _ => Ok(StreamPath::of_fold(&read_path(&args.path)?, &args.path)?),
    }
}

/// A number that other sessions hardly had.
fn id() -> u32 {
    let now = SystemTime::now().duration_since(SystemTime::UNIX_EPOCH);
    let [a, b, c, d, ..] = now.map_or(0, |now| now.as_micros()).to_le_bytes();
    u32::from_le_bytes([a, b, c, d]) ^ std::process::id().rotate_left(16)
}

fn no_device(reason: &str) -> Summary {
    Summary {
        outcome: Outcome::NoDevice,
        reason: Some(reason.into()),
        setpoints: 0,
        bytes_sent: 0,
        retransmitted: 0,
        refused: 0,
        max_closure: None,
        duration: 0,
    }
}

/// A session with its log, which is written whole when the session has ended.
fn session<'a>(
    mut link: impl Link,
    path: &'a StreamPath,
    options: Options,
    log: Option<&Path>,
    watch: impl FnOnce(&'a mut dyn Write) -> Watch<'a>,
) -> Result<Summary, CliError> {
    todo_placeholder()
}

fn report(args: &Stream, path: &StreamPath, summary: &Summary) -> Result<(), CliError> {
    #[allow(clippy::cast_precision_loss, reason = "below 2⁵³ microseconds")]
    let duration = summary.duration as f64 / 1e6;
    let json = StreamJson {
        outcome: summary.outcome.name(),
        reason: summary.reason.as_deref(),
        setpoints: summary.setpoints,
        bytes_sent: summary.bytes_sent,
        retransmitted: summary.retransmitted,
        refused: summary.refused,
        max_closure: summary.max_closure,
        duration,
    };
    if args.report.json {
        return print_json(&json);
    }
    let mut text = format!("{}: {}\n", args.path.display(), json.outcome);
    if let Some(reason) = json.reason {
        text += &format!("  reason       {reason}\n");
    }
    let closure = json.max_closure.map_or("unknown".into(), |x| format!("{x:.1e}"));
    text += &format!(
        "  sent         {} of {} setpoints of {} groups, {} bytes, {} items again, {} refused\n  \
         closure      {closure} at the angles that were told\n  \
         time         {duration:.3} s\n",
        json.setpoints,
        path.times().len(),
        path.groups(),
        json.bytes_sent,
        json.retransmitted,
        json.refused,
    );
    if let Some(log) = &args.log {
        text += &format!("  log          {}\n", log.display());
    }
    print(&text)
}

/// Whoever ran the command looks on.
struct Watch<'a> {
    path: &'a StreamPath,
    log: Option<&'a mut dyn Write>,
    pressed: &'a AtomicU8,
    shown: Option<Instant>,
    progress: bool,
}

impl Watch<'_> {
    /// A line over the one before.
    fn show(&mut self, telemetry: &Telemetry) {
        let times = self.path.times();
        let time = |knot: usize| times.get(knot).copied().unwrap_or(0.0);
        let knot = usize::try_from(telemetry.place.knot).unwrap_or(usize::MAX);
        let end = time(times.len().saturating_sub(1)) - time(0);
        let part = 100.0 * (time(knot) - time(0) + telemetry.place.into) / end;
        let angles = telemetry.angles.iter().take(4);
        let angles: String = angles.map(|a| format!(" {:.1}", a.to_degrees())).collect();
        let more = if telemetry.angles.len() > 4 { " ..." } else { "" };
        let state = state(telemetry.state);
        let _gone = write!(
            io::stderr(),
            "\r\x1b[K{state}: {part:.0} %, knot {knot} of {}, groups at{angles}{more} degrees",
            times.len().saturating_sub(1),
        );
    }
}

impl Watcher for Watch<'_> {
    fn telemetry(&mut self, telemetry: &Telemetry) -> io::Result<()> {
        if let Some(log) = &mut self.log {
            let (time, state) = (telemetry.time, state(telemetry.state));
            write!(log, "{time},{state},{}", telemetry.place.knot)?;
            for angle in &telemetry.angles {
                write!(log, ",{angle}")?;
            }
            writeln!(log)?;
        }
        if self.progress && self.shown.is_none_or(|shown| shown.elapsed() >= PACE) {
            self.shown = Some(Instant::now());
            self.show(telemetry);
        }
        Ok(())
    }

    fn wish(&mut self) -> Wish {
        match self.pressed.load(Ordering::Relaxed) {
            0 => Wish::Run,
            1 => Wish::Stop,
            _ => Wish::Quit,
        }
    }
}

impl Drop for Watch<'_> {
    fn drop(&mut self) {
        if self.shown.is_some() {
            let _gone = writeln!(io::stderr());
        }
    }
}

/// The name of a state in the log.
fn state(state: State) -> &'static str {
    match state {
        State::Idle => "Idle",
        State::Ready => "Ready",
        State::Running => "Running",
        State::Holding => "Holding",
        State::Done => "Done",
        State::Faulted => "Faulted",
    }
}
