//! Reads scripts of disturbances of hinges. Each line is one event: `SECONDS supply PART`, `SECONDS stick HINGE`,
//! `SECONDS free HINGE`, `SECONDS jump HINGE RADIANS` (of its sensor) or `SECONDS turn HINGE RADIANS` (by a hand). Empty lines and text after a `#` are skipped.

use core::f64::consts::TAU;
use core::ops::RangeInclusive;
use std::path::Path;

use foldpath_firmware_sim::hinges::Trouble;

use crate::read::FileError;

/// Parses a script for `hinges` hinges; `file` names it in errors. Returns the events in order of time, each with its time in
/// microseconds.
///
/// # Errors
/// If a line has another form, or names a hinge that does not exist.
pub fn parse_script(
    file: &Path,
    text: &str,
    hinges: usize,
) -> Result<Vec<(u64, Trouble)>, FileError> {
    let mut events = Vec::new();
    for (number, line) in (1..).zip(text.lines()) {
        let line = line.split('#').next().unwrap_or_default().trim();
        if line.is_empty() {
            continue;
        }
        let event = event(line, hinges).ok_or_else(|| {
            let expected = format!(
                "SECONDS and supply 0..1, stick HINGE, free HINGE, jump HINGE RADIANS or turn HINGE RADIANS, with hinges below {hinges}"
            );
            FileError::expected(file, format!("line {number}"), expected, line)
        })?;
        events.push(event);
    }
    events.sort_by_key(|(time, _)| *time);
    Ok(events)
}

fn event(line: &str, hinges: usize) -> Option<(u64, Trouble)> {
    let words: Vec<&str> = line.split_whitespace().collect();
    let (seconds, what) = words.split_first()?;
    let number = |word: &str, range: RangeInclusive<f64>| {
        let number = word.parse().ok();
        number.filter(|number| range.contains(number))
    };
    let hinge = |word: &str| word.parse().ok().filter(|hinge| *hinge < hinges);
    let trouble = match *what {
        ["supply", part] => Trouble::Supply(number(part, 0.0..=1.0)?),
        ["stick", word] => Trouble::Stick(hinge(word)?),
        ["free", word] => Trouble::Free(hinge(word)?),
        ["jump", word, radians] => Trouble::Jump(hinge(word)?, number(radians, -TAU..=TAU)?),
        ["turn", word, radians] => Trouble::Turn(hinge(word)?, number(radians, -TAU..=TAU)?),
        _ => return None,
    };
    #[allow(
        clippy::cast_possible_truncation,
        clippy::cast_sign_loss,
        reason = "at most a million seconds, not negative"
    )]
    let micros = (1e6 * number(seconds, 0.0..=1e6)?) as u64;
    Some((micros, trouble))
}
