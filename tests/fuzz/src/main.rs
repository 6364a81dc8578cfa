//! One reader, which the environment variable READER names, fed by libFuzzer.
#![no_main]

use std::path::Path;
use std::sync::LazyLock;

use foldpath::formats::{FileError, fold, parse_pattern};
use foldpath::pattern::CreasePattern;
use libfuzzer_sys::fuzz_target;

/// Feeds bytes to a reader; an error is put in words.
type Reader = fn(&[u8]);

static READER: LazyLock<Reader> = LazyLock::new(|| {
    let name = std::env::var("READER").unwrap_or_default();
    match name.as_str() {
        "fold" => |bytes| drop(said(fold::parse_pattern(Path::new("a.fold"), bytes))),
        "goal" => |bytes| drop(said(fold::parse_goal(Path::new("a.fold"), bytes, &SHEET))),
        "path" => |bytes| drop(said(fold::parse_path(Path::new("a.fold"), bytes))),
        "svg" => |bytes| drop(said(parse_pattern(Path::new("a.svg"), bytes))),
        "cp" => |bytes| drop(said(parse_pattern(Path::new("a.cp"), bytes))),
        _ => panic!("READER names none: {name}"),
    }
});

/// The sheet that goals are read for.
static SHEET: LazyLock<CreasePattern> = LazyLock::new(|| {
    let text = include_bytes!("../seeds/fold/square.fold");
    let file = fold::parse_pattern(Path::new("square.fold"), text);
    file.expect("a pattern").pattern
});

fn said<T>(read: Result<T, FileError>) -> Option<T> {
    read.map_err(|error| error.to_string()).ok()
}

fuzz_target!(|bytes: &[u8]| READER(bytes));
