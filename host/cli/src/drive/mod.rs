//! Runs `foldpath drive`, which watches and moves hinges one by one, and writes the map from hinges to channels.

mod command;
mod map;

use core::sync::atomic::{AtomicU8, Ordering};
use core::time::Duration;
use std::io::{self, BufRead, IsTerminal, Write};
use std::sync::Arc;
use std::sync::mpsc::{Receiver, RecvTimeoutError, channel};
use std::thread;

use foldpath_core::follower::{Denial, State};
use serde::Serialize;

use crate::args::Drive;
use crate::reach::{self, Host};
use crate::{Answer, CliError, print, print_json, say};
pub(crate) use command::HELP;
use command::{Command, radians};
use foldpath::stream::{Bench, BenchError, Jogged, Link, Seen, Way};
use map::{MapFile, Row, lacks};

/// Time for which a line of commands is waited for before signs of life are sent.
const PAUSE: Duration = Duration::from_millis(5);

/// Answer to a command.
#[derive(Serialize)]
struct Line {
    command: String,
    /// `done`, `held`, `ended`, `denied` or `no_device`.
    outcome: &'static str,
    message: String,
    hinge: Option<u16>,
    /// Angles at which the hinge is commanded to be and was measured, degrees.
    commanded: Option<f64>,
    measured: Option<f64>,
    /// Lines of the map that the command tells.
    channels: Vec<Row>,
}

impl Line {
    fn new(outcome: &'static str, message: impl Into<String>) -> Self {
        Self {
            command: String::new(),
            outcome,
            message: message.into(),
            hinge: None,
            commanded: None,
            measured: None,
            channels: Vec::new(),
        }
    }

    fn done(message: impl Into<String>) -> Self {
        Self::new("done", message)
    }

    fn denied(message: impl Into<String>) -> Self {
        Self::new("denied", message)
    }

    /// Tells where a hinge stands.
    fn seen(outcome: &'static str, seen: Seen, more: &str) -> Self {
        let degrees = |angle: Option<f32>| angle.map(|angle| f64::from(angle).to_degrees());
        // A sensor that has failed has no number in JSON.
        let (commanded, measured) = (
            degrees(seen.commanded),
            degrees(seen.measured.filter(|angle| angle.is_finite())),
        );
        let at = commanded.map_or_else(String::new, |angle| format!("commanded {angle:.3}, "));
        let is = match (measured, seen.measured) {
            (Some(angle), _) => format!("measured {angle:.3} degrees"),
            (None, Some(_)) => "measured at no number: its sensor fails".into(),
            (None, None) => "not measured".into(),
        };
        Self {
            hinge: Some(seen.hinge),
            commanded,
            measured,
            ..Self::new(outcome, format!("hinge {}: {at}{is}{more}", seen.hinge))
        }
    }

    fn channel(row: Row) -> Self {
        Self {
            hinge: Some(row.hinge),
            channels: vec![row],
            ..Self::done(row.to_string())
        }
    }
}

pub(crate) fn run(args: &Drive, quiet: bool) -> Answer {
    let commands = command::parse(&args.commands.join(" ")).map_err(CliError::Usage)?;
    let key = reach::key(&args.to, &args.line, quiet)?;
    let map = MapFile::read(args.map.as_deref(), args.rust.as_deref())?;
    let Host { id, nonce, key } = Host::new(key).map_err(CliError::Output)?;
    let (name, mut link) = reach::open(&args.to, &args.line, key)?;
    let bench = match &mut link {
        Ok(link) => Bench::open(&mut **link as &mut dyn Link, key, id, nonce).map_err(no_session),
        Err(error) => Err(format!("{name}: {error}")),
    };
    match bench {
        Ok(bench) => Desk::new(bench, map, args.json).work(commands),
        Err(reason) => {
            tell(args.json, &Line::new("no_device", reason))?;
            Ok(false)
        }
    }
}

fn tell(json: bool, line: &Line) -> Result<(), CliError> {
    if json {
        return print_json(line);
    }
    let text = match (line.outcome, line.command.as_str()) {
        ("done", _) | (_, "") => line.message.clone(),
        (outcome, command) => format!("{command}: {outcome}: {}", line.message),
    };
    print(&(text + "\n"))
}

/// A session, the map, and the operator.
struct Desk<'a> {
    bench: Bench<&'a mut dyn Link>,
    map: MapFile,
    json: bool,
    pressed: Arc<AtomicU8>,
}

impl<'a> Desk<'a> {
    fn new(bench: Bench<&'a mut dyn Link>, map: MapFile, json: bool) -> Self {
        let pressed = Arc::new(AtomicU8::new(0));
        let count = Arc::clone(&pressed);
        // If no handler can be set, Ctrl-C ends the process, and the controller ends the motion because it hears nothing.
        let _default = ctrlc::set_handler(move || {
            count.fetch_add(1, Ordering::Relaxed);
        });
        Self {
            bench,
            map,
            json,
            pressed,
        }
    }

    /// Carries out the commands, or those on stdin if there are none.
    fn work(mut self, commands: Vec<(Command, String)>) -> Answer {
        if commands.is_empty() {
            return self.converse();
        }
        for (command, text) in commands {
            if command == Command::Quit {
                break;
            }
            if !self.answer(command, text)? {
                if self.map.changed {
                    say("note: the map was not written, because a command was not done");
                }
                return Ok(false);
            }
        }
        if self.map.changed
            && let Err(said) = self.map.save()?
        {
            say(&format!("note: {said}"));
            return Ok(false);
        }
        Ok(true)
    }

    /// Carries out the commands on stdin, one line after the other. Only on a terminal, a command that is wrong or is not
    /// done is no end.
    fn converse(&mut self) -> Answer {
        let prompts = io::stdin().is_terminal();
        let lines = lines();
        let mut all = true;
        'lines: loop {
            if prompts && !self.json {
                let mut out = io::stderr();
                let _gone = write!(out, "> ").and_then(|()| out.flush());
            }
            let Some(line) = self.next(&lines)? else {
                break;
            };
            let commands = match command::parse(&line) {
                Ok(commands) => commands,
                Err(wrong) if prompts => {
                    say(&format!("error: {wrong}"));
                    continue;
                }
                Err(wrong) => return Err(CliError::Usage(wrong)),
            };
            for (command, text) in commands {
                if command == Command::Quit {
                    break 'lines;
                }
                let done = self.answer(command, text)?;
                all &= done;
                if !done && !prompts {
                    break 'lines;
                }
                if !done {
                    break;
                }
            }
        }
        if self.map.changed {
            say("note: changes of the map were not saved");
        }
        Ok(all)
    }

    /// Waits for the next line, and keeps the session open; `None` at the end of stdin, or if Ctrl-C is pressed meanwhile.
    fn next(&mut self, lines: &Receiver<String>) -> Result<Option<String>, CliError> {
        self.pressed.store(0, Ordering::Relaxed);
        loop {
            match lines.recv_timeout(PAUSE) {
                Ok(line) => return Ok(Some(line)),
                Err(RecvTimeoutError::Disconnected) => return Ok(None),
                Err(RecvTimeoutError::Timeout) => {}
            }
            if self.pressed.load(Ordering::Relaxed) > 0 {
                return Ok(None);
            }
            // A session that is over is told by the next command.
            let _ = self.bench.round();
        }
    }

    /// Carries out a command and answers; returns `true` if it was done.
    fn answer(&mut self, command: Command, text: String) -> Answer {
        let line = match self.carry_out(command) {
            Ok(line) => line,
            Err(Refusal::Usage(error)) => return Err(error),
            Err(Refusal::Bench(BenchError::Denied {
                denial,
                state,
                hinges,
            })) => Line::denied(denied(command, denial, state, hinges)),
            Err(Refusal::Bench(error)) => Line::new("no_device", no_session(error)),
        };
        let line = Line {
            command: text,
            ..line
        };
        tell(self.json, &line)?;
        Ok(line.outcome == "done")
    }

    fn carry_out(&mut self, command: Command) -> Result<Line, Refusal> {
        Ok(match command {
            Command::Watch(hinge) => Line::seen("done", self.bench.watch(hinge)?, ""),
            Command::Jog(hinge, turn, from) => {
                let pressed = Arc::clone(&self.pressed);
                pressed.store(0, Ordering::Relaxed);
                let stops = || pressed.load(Ordering::Relaxed) > 0;
                let from = from.map(radians);
                // The board has the limits of the map with which it was built.
                let to = self.bench.end_of(hinge, from, turn.way())?;
                if let Some(why) = self.map.beyond(hinge, to) {
                    return Ok(Line::denied(why));
                }
                match self.bench.jog(hinge, from, Way::To(to), &stops)? {
                    Jogged::There(seen) => Line::seen("done", seen, ""),
                    Jogged::Held(seen) => Line::seen("held", seen, ""),
                    Jogged::Ended(seen) => {
                        let why = "; its motion has ended: it is blocked, its sign is wrong, or the stop line was drawn";
                        Line::seen("ended", seen, why)
                    }
                }
            }
            Command::Channel(hinge, channel) => self.map.channel(hinge, channel).into(),
            Command::Zero(hinge) => {
                if self.map.get(hinge).is_none() {
                    return Ok(Line::denied(lacks(hinge)));
                }
                let seen = self.bench.place(hinge)?;
                match seen.angle().filter(|angle| angle.is_finite()) {
                    Some(angle) => self.map.zero(hinge, angle).into(),
                    None => Line::denied(format!(
                        "nothing tells where hinge {hinge} stands; `jog {hinge} by 0 from DEGREES` says it"
                    )),
                }
            }
            Command::Sign(hinge, negative) => self.map.sign(hinge, negative).into(),
            Command::Limits(hinge, degrees) => self.map.limits(hinge, degrees.map(radians)).into(),
            Command::Show => {
                let rows = self.map.rows();
                let lines: Vec<String> = rows.iter().map(Row::to_string).collect();
                let text = if lines.is_empty() {
                    "the map is empty".into()
                } else {
                    lines.join("\n")
                };
                Line {
                    channels: rows,
                    ..Line::done(text)
                }
            }
            Command::Save if self.map.path.is_some() => {
                let saved = self.map.save().map_err(Refusal::Usage)?;
                saved.map_or_else(Line::denied, Line::done)
            }
            Command::Save => Line::denied("no map to write; start with --map FILE"),
            Command::Clear => {
                self.bench.clear()?;
                Line::done("the controller has no path and does not know where a sheet stands")
            }
            Command::Help => Line::done(HELP),
            Command::Quit => Line::done(""),
        })
    }
}

/// Explains why there is no session any more, and which options help.
fn no_session(error: BenchError) -> String {
    match error {
        BenchError::NoSession(failure) => reach::no_session(failure),
        error => error.to_string(),
    }
}

/// Explains why a controller in a state and with room for so many hinges does not carry a command out, and what to do.
fn denied(command: Command, denial: Denial, state: Option<State>, hinges: u16) -> String {
    match denial {
        Denial::Held => "the stop line holds the hinges; let it go, and then `clear`".into(),
        denial if command == Command::Clear => denial.to_string(),
        Denial::State if state == Some(State::Idle) => {
            "the controller knows where its sheet stands and holds its hinges there, and one that moves alone would \
             tear the sheet; take the sheet off, and let `clear` forget where it stands"
                .into()
        }
        Denial::State => {
            let state = state.map_or_else(String::new, |state| format!(" ({state:?})"));
            format!("the controller has a path or a fault{state}; `clear` drops it")
        }
        Denial::Range => format!(
            "expected a hinge below {hinges}, and an angle within the limits that the board has for it"
        ),
        Denial::Unknown(hinge) => {
            format!("nothing tells where hinge {hinge} stands; look, and add `from DEGREES`")
        }
        Denial::Jump(hinge) => format!(
            "hinge {hinge} stands elsewhere than was said, or beyond the limits that the board has for it"
        ),
        denial => denial.to_string(),
    }
}

/// Reason why a command has no answer of its own.
enum Refusal {
    Bench(BenchError),
    Usage(CliError),
}

impl From<BenchError> for Refusal {
    fn from(error: BenchError) -> Self {
        Self::Bench(error)
    }
}

impl From<Result<Row, String>> for Line {
    fn from(row: Result<Row, String>) -> Self {
        row.map_or_else(Line::denied, Line::channel)
    }
}

/// Reads stdin in a thread of its own, because a session needs signs of life meanwhile.
fn lines() -> Receiver<String> {
    let (sender, lines) = channel();
    thread::spawn(move || {
        for line in io::stdin().lock().lines().map_while(Result::ok) {
            if sender.send(line).is_err() {
                return;
            }
        }
    });
    lines
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_denial_says_what_to_do() {
        let watch = Command::Watch(3);
        let told = |command, denial| denied(command, denial, Some(State::Done), 64);
        assert!(told(watch, Denial::State).contains("a path or a fault (Done); `clear` drops it"));
        assert!(told(watch, Denial::Held).contains("the stop line holds the hinges"));
        assert!(told(watch, Denial::Range).contains("expected a hinge below 64"));
        let cleared = told(Command::Clear, Denial::State);
        assert_eq!(cleared, Denial::State.to_string());
    }
}
