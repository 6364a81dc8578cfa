//! Draws progress bars on a terminal, for work that takes over a second.

use core::time::Duration;
use std::io::{IsTerminal, stderr};
use std::sync::mpsc::{Receiver, RecvTimeoutError, channel};
use std::thread;

use indicatif::{ProgressBar, ProgressStyle};

use crate::args::Report;
use foldpath::progress::Progress;

/// Time after which a bar appears; shorter work has no bar.
pub(crate) const PATIENCE: Duration = Duration::from_secs(1);
/// Time between two updates of a bar.
pub(crate) const PACE: Duration = Duration::from_millis(100);
/// Position of a full bar.
const FULL_BAR: u64 = 1000;

/// Returns `true` if bars are drawn: on a terminal, unless `--quiet` or `--json` is given.
pub(crate) fn shown(report: &Report, quiet: bool) -> bool {
    !quiet && !report.json && stderr().is_terminal()
}

/// Does the work. If bars are shown, a second thread draws its progress meanwhile.
pub(crate) fn watched<T>(report: &Report, quiet: bool, work: impl FnOnce(&Progress) -> T) -> T {
    let progress = Progress::new();
    if !shown(report, quiet) {
        return work(&progress);
    }
    let (working, over) = channel();
    thread::scope(|scope| {
        let progress = &progress;
        scope.spawn(move || draw(progress, &over));
        let result = work(progress);
        drop(working);
        result
    })
}

/// Draws a bar until the work ends.
fn draw(progress: &Progress, over: &Receiver<()>) {
    let goes_on = |time| over.recv_timeout(time) == Err(RecvTimeoutError::Timeout);
    if !goes_on(PATIENCE) {
        return;
    }
    let bar = hidden_bar();
    loop {
        let (stage, part) = progress.now();
        show(&bar, stage.name(), part);
        if !goes_on(PACE) {
            break;
        }
    }
    bar.finish_and_clear();
}

/// Creates a bar on stderr that is not visible yet.
pub(crate) fn hidden_bar() -> ProgressBar {
    ProgressBar::new(FULL_BAR)
}

/// Sets what a bar shows.
pub(crate) fn set_style(bar: &ProgressBar, template: &str) {
    if let Ok(style) = ProgressStyle::with_template(template) {
        bar.set_style(style.progress_chars("=> "));
    }
}

/// Draws the name of the work and, if it is known, the fraction of the work that is done.
pub(crate) fn show(bar: &ProgressBar, what: &str, part: Option<f64>) {
    let template = match part {
        Some(_) => "{spinner} {elapsed} [{bar:30}] {percent:>3} % {msg}",
        None => "{spinner} {elapsed} {msg}",
    };
    set_style(bar, template);
    #[allow(
        clippy::cast_possible_truncation,
        clippy::cast_sign_loss,
        reason = "0 to 1000"
    )]
    bar.set_position((1e3 * part.unwrap_or(0.0)) as u64);
    bar.set_message(what.to_string());
    bar.tick();
}
