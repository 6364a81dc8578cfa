//! Leaves only those parts of a DXF file that have lines: two variables of the header, layers, blocks, and entities with
//! outlines. The crate `dxf` knows hundreds of other things, and refuses a file in which one of them is not as it expects.

use std::collections::BTreeMap;

use super::no_drawing;
use crate::read::error::{Wrong, quoted};

/// Largest number of things that a file lists, of which each takes one or two kilobytes.
pub(super) const MAX_LISTED: usize = 1 << 18;

/// Variables of the header that count: the version, and the unit.
const VARIABLES: [&[u8]; 2] = [b"$ACADVER", b"$INSUNITS"];
/// Sections that count.
const SECTIONS: [&[u8]; 4] = [b"HEADER", b"TABLES", b"BLOCKS", b"ENTITIES"];
/// Things that count in sections and tables.
const KEPT: [&[u8]; 18] = [
    b"SECTION",
    b"ENDSEC",
    b"EOF",
    b"TABLE",
    b"ENDTAB",
    b"LAYER",
    b"BLOCK",
    b"ENDBLK",
    b"LINE",
    b"LWPOLYLINE",
    b"POLYLINE",
    b"VERTEX",
    b"SEQEND",
    b"ARC",
    b"CIRCLE",
    b"ELLIPSE",
    b"SPLINE",
    b"INSERT",
];
/// Code of comments. Those beyond are of data that other programs attach.
const COMMENT: u32 = 999;

/// The parts of a file that have lines.
#[derive(Default)]
pub(super) struct Reduced {
    pub(super) bytes: Vec<u8>,
    /// For each line of `bytes` its number in the file, from 1.
    pub(super) lines: Vec<usize>,
    /// Numbers of things left out, by what they are.
    pub(super) left_out: BTreeMap<&'static str, usize>,
}

/// Returns the error that a file lists too much.
pub(super) fn too_long() -> Wrong {
    let expected = format!("at most {MAX_LISTED} things in the file");
    ("the file".into(), expected, "more".into())
}

/// Reduces the text of a file.
///
/// # Errors
/// If a line that has to be a code is no number, or the file lists too much.
pub(super) fn reduced(bytes: &[u8]) -> Result<Reduced, Wrong> {
    let mut reduced = Reduced::default();
    let mut lines = (1..).zip(bytes.split(|byte| *byte == b'\n'));
    let (mut section, mut in_layers, mut listed) = (Vec::new(), false, 0_usize);
    // `kept` until the next thing or variable, and `attached` within data of other programs.
    let (mut kept, mut attached) = (false, false);
    while let Some((number, line)) = lines.next() {
        let Some((_, value)) = lines.next() else {
            break;
        };
        let (code, value) = (
            line.trim_ascii(),
            value.strip_suffix(b"\r").unwrap_or(value),
        );
        let parsed = str::from_utf8(code)
            .ok()
            .and_then(|code| code.parse::<u32>().ok());
        let code = parsed.ok_or_else(|| {
            let found = quoted(&String::from_utf8_lossy(code));
            (
                format!("line {number}"),
                "the number of a group code".into(),
                found,
            )
        })?;
        let word = value.trim_ascii();
        if code == 0 {
            listed += 1;
            if listed > MAX_LISTED {
                return Err(too_long());
            }
            // The pair that follows has the name.
            let name = || {
                lines
                    .clone()
                    .nth(1)
                    .map_or(&b""[..], |(_, name)| name.trim_ascii())
            };
            if word == b"SECTION" {
                section = name().to_vec();
                in_layers = false;
            } else if word == b"TABLE" {
                in_layers = name() == b"LAYER";
            }
            let counts = SECTIONS.iter().any(|known| *known == section)
                && (section != b"TABLES" || in_layers || matches!(word, b"SECTION" | b"ENDSEC"));
            let is_kept = KEPT.contains(&word);
            if counts && !is_kept && section != b"TABLES" {
                *reduced.left_out.entry(named(word)).or_default() += 1;
            }
            (kept, attached) = (counts && is_kept || word == b"EOF", false);
            if word == b"ENDTAB" {
                in_layers = false;
            }
        } else if code == 9 && section == b"HEADER" {
            kept = VARIABLES.contains(&word);
        } else if code == 102 {
            attached = word.starts_with(b"{");
            continue;
        }
        if kept && !attached && code < COMMENT {
            reduced.bytes.extend(format!("{code}\n").bytes());
            reduced.bytes.extend(value);
            reduced.bytes.push(b'\n');
            reduced.lines.extend([number, number + 1]);
        }
    }
    if reduced.bytes.is_empty() {
        return Err(no_drawing("the file", "no section of one"));
    }
    Ok(reduced)
}

/// Returns what a thing is that has no lines.
fn named(word: &[u8]) -> &'static str {
    match word {
        b"TEXT" | b"MTEXT" | b"ATTRIB" | b"ATTDEF" => "texts",
        b"POINT" => "points",
        _ => "dimensions, fills and other things that are no lines",
    }
}
