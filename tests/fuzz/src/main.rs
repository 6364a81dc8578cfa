//! Feeds one reader of files with libFuzzer's inputs. The environment variable READER names the reader.
#![no_main]

use std::path::Path;
use std::sync::LazyLock;

use foldpath::read::{FileError, fold, parse_pattern, parse_shape};
use foldpath::pattern::CreasePattern;
use foldpath::stream::StreamPath;
use foldpath::unfold::{UnfoldOptions, unfold};
use libfuzzer_sys::fuzz_target;

/// Feeds bytes to a reader, and formats the error if there is one.
type Reader = fn(&[u8]);

static READER: LazyLock<Reader> = LazyLock::new(|| {
    let name = std::env::var("READER").unwrap_or_default();
    match name.as_str() {
        "fold" => |bytes| drop(said(parse_pattern(Path::new("a.fold"), bytes))),
        "goal" => |bytes| goals_of(bytes, fold::GoalFrames::Last),
        "keyframes" => |bytes| goals_of(bytes, fold::GoalFrames::Each),
        "path" => |bytes| drop(said(fold::parse_motion(Path::new("a.fold"), bytes))),
        "svg" => |bytes| drop(said(parse_pattern(Path::new("a.svg"), bytes))),
        "dxf" => |bytes| drop(said(parse_pattern(Path::new("a.dxf"), bytes))),
        "cp" => |bytes| drop(said(parse_pattern(Path::new("a.cp"), bytes))),
        "opx" => |bytes| drop(said(parse_pattern(Path::new("a.opx"), bytes))),
        "obj" => |bytes| {
            said(parse_pattern(Path::new("a.obj"), bytes));
            unfolded("a.obj", bytes);
        },
        "stl" => |bytes| unfolded("a.stl", bytes),
        "traj" => |bytes| drop(said(StreamPath::read(bytes, Path::new("a.traj")))),
        "shape" => |bytes| unfolded("a.fold", bytes),
        _ => panic!("READER names none: {name}"),
    }
});

/// The sheet for which goals are read.
static SHEET: LazyLock<CreasePattern> = LazyLock::new(|| {
    let text = include_bytes!("../seeds/fold/square.fold");
    let file = parse_pattern(Path::new("square.fold"), text);
    file.expect("a pattern").pattern
});

fn said<T>(read: Result<T, FileError>) -> Option<T> {
    read.map_err(|error| error.to_string()).ok()
}

/// Reads a folded shape and unfolds it.
fn unfolded(name: &str, bytes: &[u8]) {
    if let Some(file) = said(parse_shape(Path::new(name), bytes, None, None)) {
        let laid = unfold(&file.shape, &UnfoldOptions::default());
        drop(laid.map_err(|error| error.to_string()));
    }
}

fuzz_target!(|bytes: &[u8]| READER(bytes));

/// Reads goals of a sheet from some frames.
fn goals_of(bytes: &[u8], frames: fold::GoalFrames) {
    said(fold::parse_goals(
        Path::new("a.fold"),
        bytes,
        &SHEET,
        frames,
    ));
}
