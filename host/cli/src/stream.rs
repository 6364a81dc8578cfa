//! Runs `foldpath stream`, which sends a path to a controller.

use core::sync::atomic::{AtomicU8, Ordering};
use std::io;
use std::sync::Arc;
use std::time::Instant;

use foldpath_core::follower::{Denial, Fault, Reason};
use foldpath_core::wire::message::ItemRefusal;
use indicatif::ProgressBar;
use serde::Serialize;

use crate::args::{At, Stream};
use crate::log::Log;
use crate::progress::{self, PACE, PATIENCE};
use crate::reach::{self, Host};
use crate::report::outcome;
use crate::standard::{Input, print_summary, shown, source};
use crate::values::{Seeded, Target};
use crate::{Answer, CliError, check_output, print_json, say};
use foldpath::folding::Rigidity;
use foldpath::stream::{
    self, Ending, Faulty, Link, Measured, Options, Outcome, Plant, Sim, Stands, StreamPath,
    Summary, Telemetry, Watcher, Wish,
};

#[derive(Serialize)]
struct StreamJson<'a> {
    outcome: &'a str,
    reason: Option<&'a str>,
    setpoints: u64,
    bytes_sent: u64,
    retransmitted: u64,
    refused: u64,
    max_closure: f64,
    duration: f64,
    /// Largest measured distance of a hinge from its command, degrees, and the hinge.
    max_lag: Option<f64>,
    lag_hinge: Option<usize>,
    /// Smoothed time of a round trip on the line, seconds.
    round_trip: Option<f64>,
    #[serde(skip_serializing_if = "Option::is_none")]
    max_deformation: Option<f64>,
    #[serde(skip_serializing_if = "Option::is_none")]
    max_gap: Option<f64>,
}

pub(crate) fn run(args: &Stream, quiet: bool) -> Answer {
    if let Some(log) = &args.log {
        let others = [&args.script, &args.sheet, &args.line.image, &args.line.key];
        let inputs = [&args.path].into_iter().chain(others.into_iter().flatten());
        check_output("--log", log, inputs)?;
    }
    let input = Input::of(&args.path)?;
    let name = input.name.clone();
    let path = StreamPath::read(&input.bytes()?, &name)?;
    let path = if args.reverse { path.reverse() } else { path };
    if let Some(at) = args.at {
        check_place(at, &path)?;
    }
    let driven = args.drives.is_some() || args.script.is_some() || args.sheet.is_some();
    if driven && !matches!(args.to, Target::Sim) {
        let what = "--drives, --script and --sheet: expected --to sim, whose hinges are simulated";
        return Err(CliError::Usage(what.into()));
    }
    let key = reach::key(&args.to, &args.line, quiet)?;
    let host = Host::new(key).map_err(CliError::Output)?;
    let bars = progress::shown(&args.report, quiet);
    let mut rigidity = None;
    let summary = match &args.to {
        Target::Sim => {
            let mut sim = if driven {
                Sim::driving(plant(args, &path)?)
            } else {
                Sim::new()
            };
            if let Some(key) = key {
                sim = sim.with_key(key);
            }
            let summary = session(&mut sim, args, &path, Host { id: 1, ..host }, bars, quiet)?;
            rigidity = sim.plant().and_then(Plant::rigidity);
            summary
        }
        to => match reach::open(to, &args.line, key)? {
            (_, Ok(mut link)) => session(&mut *link, args, &path, host, bars, quiet)?,
            (name, Err(error)) => {
                let mut summary = Summary::default();
                summary.reason = Some(Ending::Line(format!("{name}: {error}")));
                summary
            }
        },
    };
    report(args, &path, &summary, rigidity, quiet)?;
    Ok(summary.outcome == Outcome::Done)
}

/// Checks that the path begins where an operator says that the sheet stands.
fn check_place(at: At, path: &StreamPath) -> Result<(), CliError> {
    let (flat, goal) = (path.begins_flat(), path.begins_at_goal());
    let (said, place) = match at {
        At::Flat if !flat => ("flat", "flat"),
        At::Goal if !goal => ("goal", "at the goal"),
        _ => return Ok(()),
    };
    let what = if path.is_reversed() {
        "the path, with --reverse,"
    } else {
        "the path"
    };
    let (begins, instead) = match (flat, goal) {
        (true, _) => (
            "flat".to_string(),
            "--at flat, or turn the path round by --reverse",
        ),
        (_, true) => (
            "at the goal".to_string(),
            "--at goal, or leave --reverse out",
        ),
        (false, false) => {
            let angles = path
                .view()
                .and_then(|view| view.knot(0))
                .map(|knot| knot.angles);
            let angles = angles.unwrap_or_default().iter();
            let angles = angles.map(|angle| angle.to_degrees());
            let (group, most) =
                (0..).zip(angles).fold(
                    (0, 0.0_f32),
                    |a, b| {
                        if b.1.abs() > a.1.abs() { b } else { a }
                    },
                );
            (
                format!("folded, with group {group} at {most:.3} degrees"),
                "--at start if it stands there, or --at measured",
            )
        }
    };
    Err(CliError::Usage(format!(
        "--at {said}: {what} does not begin {place}, but {begins}; say {instead}"
    )))
}

/// Returns the hinges of a simulated controller.
fn plant(args: &Stream, path: &StreamPath) -> Result<Plant, CliError> {
    let events = match &args.script {
        Some(file) => Input::of(file)?.script(path.hinges().len())?,
        None => Vec::new(),
    };
    let Seeded { value, seed } = args.drives.unwrap_or_default();
    let plant = Plant::new(path, value, seed, events);
    Ok(match &args.sheet {
        Some(file) => {
            let input = Input::of(file)?;
            plant.with_sheet(path, input.motion()?, &input.name)?
        }
        None => plant,
    })
}

/// Runs a session with the faults and the log that were asked for, and with bars or quietly.
fn session(
    link: &mut dyn Link,
    args: &Stream,
    path: &StreamPath,
    host: Host,
    bars: bool,
    quiet: bool,
) -> Result<Summary, CliError> {
    let mut faulty;
    let mut link: &mut dyn Link = match args.faults {
        None => link,
        Some(Seeded { value, seed }) => {
            faulty = Faulty::new(link, value, seed);
            &mut faulty
        }
    };
    let pressed = Arc::new(AtomicU8::new(0));
    let count = Arc::clone(&pressed);
    // If no handler can be set, Ctrl-C ends the process, and the controller holds because it hears nothing more.
    let _default = ctrlc::set_handler(move || {
        count.fetch_add(1, Ordering::Relaxed);
    });
    // Before the first command, the hinges of the emulated board are nowhere.
    let emulated = matches!(args.to, Target::Qemu);
    let options = Options::default().with(|it| {
        it.resume = args.resume;
        it.unattended = args.unattended;
        it.stands = match args.at {
            None if emulated => Stands::AtStart,
            None => Stands::Known,
            Some(At::Measured) => Stands::Measured,
            Some(At::Start | At::Flat | At::Goal) => Stands::AtStart,
        };
        it.id = host.id;
        it.key = host.key;
        it.nonce = host.nonce;
    });
    let log = args.log.as_deref().map(Log::create).transpose()?;
    let mut watch = Watch {
        path,
        log,
        pressed: &pressed,
        begun: Instant::now(),
        shown: None,
        bar: bars.then(progress::hidden_bar),
        quiet,
    };
    let followed = watch
        .head()
        .and_then(|()| stream::run(&mut link, path, options, &mut watch));
    followed.map_err(|error| match &watch.log {
        Some(log) => log.failed(error),
        None => CliError::Output(error),
    })
}

/// Explains why a session ended, and with which options another one goes on.
fn explained(ending: &Ending) -> String {
    let advice = match ending {
        Ending::NoSession(failure) => return reach::no_session(*failure),
        Ending::Failed {
            reason: Reason::Fault(Fault::Stalled(_)),
            ..
        } => "; --resume goes on once it is free",
        Ending::Failed { .. } => "; --resume goes on from where it stands",
        Ending::Held(Reason::Silence) => {
            "; --resume goes on from where the sheet stands, and with --unattended also after the next silence"
        }
        Ending::Held(Reason::StopLine) => "; --resume goes on once it is let go",
        Ending::Held(_) | Ending::Stopped => "; --resume goes on from where the sheet stands",
        Ending::Denied(denial)
        | Ending::Refused {
            item: ItemRefusal::Path(denial),
            ..
        } => match denial {
            Denial::Jump(_) => "; --resume begins where it stands",
            Denial::Unknown(_) | Denial::Spread(_) => {
                "; --at flat, --at goal or --at start says where the sheet stands"
            }
            _ => "",
        },
        _ => "",
    };
    format!("{ending}{advice}")
}

#[allow(clippy::cast_precision_loss, reason = "below 2⁵³ microseconds")]
fn seconds(micros: u64) -> f64 {
    micros as f64 / 1e6
}

fn report(
    args: &Stream,
    path: &StreamPath,
    summary: &Summary,
    rigidity: Option<Rigidity>,
    quiet: bool,
) -> Result<(), CliError> {
    let duration = seconds(summary.duration);
    let reason = summary.reason.as_ref().map(explained);
    let json = StreamJson {
        outcome: summary.outcome.name(),
        reason: reason.as_deref(),
        setpoints: summary.setpoints,
        bytes_sent: summary.bytes_sent,
        retransmitted: summary.retransmitted,
        refused: summary.refused,
        max_closure: summary.max_closure,
        duration,
        max_lag: summary.lag.map(|lag| f64::from(lag.angle).to_degrees()),
        lag_hinge: summary.lag.map(|lag| lag.hinge),
        round_trip: summary.round_trip.map(seconds),
        max_deformation: rigidity.map(|rigidity| rigidity.deformation),
        max_gap: rigidity.map(|rigidity| rigidity.gap),
    };
    if args.report.json {
        return print_json(&json);
    }
    let outcome = outcome(summary.outcome == Outcome::Done, json.outcome);
    let mut text = format!("{}: {outcome}\n", source(&args.path));
    if let Some(reason) = json.reason {
        text += &format!("  reason       {reason}\n");
    }
    text += &format!(
        "  sent         {} of {} setpoints of {} groups, {} bytes, {} items again, {} refused\n  \
         closure      {:.1e} at the angles that were told\n  \
         time         {duration:.3} s\n",
        json.setpoints,
        path.times().len(),
        path.groups(),
        json.bytes_sent,
        json.retransmitted,
        json.refused,
        json.max_closure,
    );
    if let Some((lag, hinge)) = json.max_lag.zip(json.lag_hinge) {
        text += &format!("  lag          {lag:.3} degrees at most, of hinge {hinge}");
        if let Some(gap) = summary.lag.and_then(|lag| path.gap(lag.hinge, lag.angle)) {
            text += &format!(": a gap of {gap:.1e} if it was alone");
        }
        text += "\n";
    }
    if let Some(time) = json.round_trip {
        text += &format!("  round trip   {:.1} ms\n", 1e3 * time);
    }
    if let Some(Rigidity {
        deformation, gap, ..
    }) = rigidity
    {
        text += &format!(
            "  sheet        deformation {deformation:.1e}, gap {gap:.1e} of its hinges as they were\n"
        );
    }
    if let Some(log) = &args.log {
        text += &format!("  log          {}\n", shown(log));
    }
    print_summary(args.log.as_deref(), quiet, &text)
}

/// Watches a session for the user: writes the log, draws the bar and obeys Ctrl-C.
struct Watch<'a> {
    path: &'a StreamPath,
    log: Option<Log>,
    pressed: &'a AtomicU8,
    begun: Instant,
    shown: Option<Instant>,
    bar: Option<ProgressBar>,
    quiet: bool,
}

impl Watch<'_> {
    fn head(&mut self) -> io::Result<()> {
        let mut head = String::from("t_us,state,sequence");
        for group in 0..self.path.groups() {
            head += &format!(",group_{group}");
        }
        head += ",max_lag,lag_hinge,retransmitted,round_trip_us";
        for hinge in 0..self.path.hinges().len() {
            head += &format!(",hinge_{hinge}");
        }
        self.row(head)
    }

    fn row(&mut self, row: String) -> io::Result<()> {
        self.log
            .as_mut()
            .map_or(Ok(()), |log| log.row(&(row + "\n")))
    }

    /// Draws the progress of the motion.
    fn show(&self, bar: &ProgressBar, telemetry: &Telemetry) {
        let times = self.path.times();
        let time = |knot: usize| times.get(knot).copied().unwrap_or(0.0);
        let knot = usize::try_from(telemetry.place.knot).unwrap_or(usize::MAX);
        let end = time(times.len().saturating_sub(1));
        let part = (time(knot) + f64::from(telemetry.place.into)) / end;
        let angles = telemetry.angles.iter().take(4);
        let angles: String = angles.map(|a| format!(" {:.1}", a.to_degrees())).collect();
        let more = if telemetry.angles.len() > 4 {
            " ..."
        } else {
            ""
        };
        let last = times.len().saturating_sub(1);
        let lag = telemetry.lag.map_or_else(String::new, |lag| {
            format!(", lag {:.2} of hinge {}", lag.angle.to_degrees(), lag.hinge)
        });
        let trip = telemetry.round_trip.map_or_else(String::new, |time| {
            format!(", round trip {:.0} ms", 1e3 * seconds(time))
        });
        let again = telemetry.retransmitted;
        let what = format!(
            "{:?}, knot {knot} of {last}, groups at{angles}{more} degrees{lag}{trip}, {again} items again",
            telemetry.state
        );
        progress::show(bar, &what, Some(part));
    }
}

impl Watcher for Watch<'_> {
    fn slowed(&mut self, reason: Reason) {
        let note = || say(&format!("note: the motion is slow or at rest: {reason}"));
        match &self.bar {
            _ if self.quiet => {}
            Some(bar) => bar.suspend(note),
            None => note(),
        }
    }

    fn telemetry(&mut self, telemetry: &Telemetry) -> io::Result<()> {
        let (time, state) = (telemetry.time, telemetry.state);
        let mut row = format!("{time},{state:?},{}", telemetry.place.knot);
        // No angles are known before the first motion.
        for group in 0..self.path.groups() {
            let angle = telemetry.angles.get(group);
            row += ",";
            row += &angle.map_or_else(String::new, f32::to_string);
        }
        let lag = telemetry.lag.map(|lag| (lag.angle, lag.hinge));
        let lag = lag.map_or_else(|| ",".into(), |(angle, hinge)| format!("{angle},{hinge}"));
        let trip = telemetry
            .round_trip
            .map_or_else(String::new, |time| time.to_string());
        row += &format!(",{lag},{},{trip}", telemetry.retransmitted);
        let Measured { first, angles } = &telemetry.measured;
        for hinge in 0..self.path.hinges().len() {
            let angle = hinge
                .checked_sub(*first)
                .and_then(|place| angles.get(place));
            row += ",";
            row += &angle
                .filter(|angle| !angle.is_nan())
                .map_or_else(String::new, f32::to_string);
        }
        self.row(row)?;
        let due = self.begun.elapsed() >= PATIENCE
            && self.shown.is_none_or(|shown| shown.elapsed() >= PACE);
        if let Some(bar) = self.bar.as_ref().filter(|_| due) {
            self.show(bar, telemetry);
            self.shown = Some(Instant::now());
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
        if let Some(bar) = self.bar.take_if(|_| self.shown.is_some()) {
            bar.finish_and_clear();
        }
    }
}

#[cfg(test)]
mod tests {
    use foldpath_core::wire::sender::Failure;

    use super::*;

    #[test]
    fn a_reason_says_which_options_go_on() {
        let stalled = Ending::Failed {
            reason: Reason::Fault(Fault::Stalled(3)),
            stopped: true,
        };
        for (ending, text) in [
            (
                Ending::Held(Reason::HoldCommand),
                "a host has asked to hold; --resume goes on from where the sheet stands",
            ),
            (
                Ending::Held(Reason::StopLine),
                "the stop line was drawn; --resume goes on once it is let go",
            ),
            (
                Ending::Held(Reason::Silence),
                "the controller did not hear its host for a while; --resume goes on from where the sheet stands, and with \
                 --unattended also after the next silence",
            ),
            (
                stalled,
                "hinge 3 has stalled. The stop line holds the motion as well and has to be let go; --resume goes on once \
                 it is free",
            ),
            (
                Ending::Denied(Denial::Unknown(1)),
                "the controller does not know where group 1 stands, and measures none of its hinges; --at flat, --at goal \
                 or --at start says where the sheet stands",
            ),
            (
                Ending::NoSession(Failure::Lost),
                "the session is lost: the controller was reset, or another host came; --resume goes on from where the \
                 sheet stands",
            ),
            (
                Ending::NoSession(Failure::Silent),
                "the controller is silent",
            ),
            (
                Ending::OffPath(3),
                "the sheet stands at knot 3, not on this path",
            ),
        ] {
            assert_eq!(explained(&ending), text);
        }
    }
}
