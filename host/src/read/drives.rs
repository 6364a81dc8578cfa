//! Reads tables of drives. Each line is one kind: its name, stall torque (newton metres) and speed without load (degrees per
//! second), parted by commas. Empty lines and text after a `#` are skipped, and so is a first line of headings.

use std::path::Path;

use super::FileError;
use crate::sensitivity::Drive;

/// Largest torque and speed of a drive.
const LARGEST: f64 = 1e9;

/// Parses a table of drives; `file` names it in errors.
///
/// # Errors
/// If a line has another form, a number is not above 0 and at most 1e9, or there is no drive.
pub fn parse_drives(file: &Path, text: &str) -> Result<Vec<Drive>, FileError> {
    let mut drives = Vec::new();
    let mut is_first = true;
    for (number, line) in (1..).zip(text.lines()) {
        let line = line.split('#').next().unwrap_or_default().trim();
        if line.is_empty() {
            continue;
        }
        let has_headings = is_first && !line.contains(|c: char| c.is_ascii_digit());
        is_first = false;
        if has_headings {
            continue;
        }
        let drive = drive(line).ok_or_else(|| {
            let expected = "NAME,STALL_TORQUE_NM,SPEED_DEG_PER_S, both numbers above 0";
            FileError::expected(file, format!("line {number}"), expected, line)
        })?;
        drives.push(drive);
    }
    if drives.is_empty() {
        let expected = "a line NAME,STALL_TORQUE_NM,SPEED_DEG_PER_S";
        return Err(FileError::expected(file, "the file", expected, "none"));
    }
    Ok(drives)
}

fn drive(line: &str) -> Option<Drive> {
    let parts: Vec<&str> = line.split(',').map(str::trim).collect();
    let [name, torque, speed] = parts.as_slice() else {
        return None;
    };
    let number = |text: &str| {
        let number: f64 = text.parse().ok()?;
        (number > 0.0 && number <= LARGEST).then_some(number)
    };
    Some(Drive {
        name: (!name.is_empty()).then(|| name.to_string())?,
        stall_torque: number(torque)?,
        speed: number(speed)?.to_radians(),
    })
}
