//! Reads files: crease patterns, folded shapes, motions.
//!
//! The ending of a file's name selects the reader, or for bytes without a name their content. Every reader bounds the
//! memory and time that a file can ask for.

#[cfg(feature = "svg")]
mod colour;
mod cp;
mod curves;
mod drives;
#[cfg(feature = "dxf")]
mod dxf;
mod error;
pub mod fold;
mod format;
mod joint_names;
mod locate;
mod merge;
mod mistaken;
mod obj;
mod options;
#[cfg(feature = "svg")]
mod opx;
mod oripa;
mod segments;
mod stl;
#[cfg(feature = "svg")]
mod svg;

use std::fs::File;
use std::io::Read;
use std::path::Path;

pub use drives::parse_drives;
pub use error::FileError;
pub use format::Format;
pub use joint_names::JointNames;
pub use mistaken::Mistaken;
pub use options::{ColourLetters, LayerLetters, LettersError, ReadOptions, Straighten, TOLERANCE};

use crate::pattern::{CreasePattern, Unit};
use crate::progress::{Progress, Stage, Watch};
use crate::straighten::{self, straightened};
use crate::unfold::FoldedShape;

/// Reads a crease pattern from a file. The ending of the name selects the format: `.svg`, `.dxf`, `.cp`, `.opx` or `.obj`;
/// every other ending is read as FOLD.
///
/// # Errors
/// If the file cannot be read, is too large, or holds no flat crease pattern.
pub fn read_pattern(path: &Path) -> Result<fold::PatternFile, FileError> {
    parse_pattern(path, &read_file(path)?)
}

/// Reads the bytes of a file.
///
/// # Errors
/// If the file cannot be read, or is too large for its format.
pub fn read_file(path: &Path) -> Result<Vec<u8>, FileError> {
    read_bytes(path, Format::of_name(path).largest_file())
}

/// Reads the bytes of a source that has no file name, such as a pipe, and finds their format by
/// [`Format::of_content`]. `path` names the source in errors.
///
/// # Errors
/// If the source cannot be read, or has more bytes than a file of its format may have.
pub fn read_stream(path: &Path, source: impl Read) -> Result<(Vec<u8>, Format), FileError> {
    let mut bytes = Vec::new();
    let most = fold::MAX_FILE_BYTES;
    let read = source.take(most + 1).read_to_end(&mut bytes);
    read.map_err(FileError::io(path))?;
    let format = Format::of_content(&bytes);
    check_size(path, bytes.len(), format.largest_file())?;
    Ok((bytes, format))
}

/// Parses a crease pattern from the bytes of a file; `path` selects the format as in [`read_pattern`].
///
/// # Errors
/// If the bytes hold no flat crease pattern.
pub fn parse_pattern(path: &Path, bytes: &[u8]) -> Result<fold::PatternFile, FileError> {
    parse_pattern_with(path, bytes, &ReadOptions::default())
}

/// Parses a crease pattern as [`parse_pattern`] does, with options.
///
/// # Errors
/// If the bytes hold no flat crease pattern, or the format has no use for an option.
pub fn parse_pattern_with(
    path: &Path,
    bytes: &[u8],
    options: &ReadOptions,
) -> Result<fold::PatternFile, FileError> {
    parse_within(path, bytes, options, Watch::default())
}

/// Parses a crease pattern as [`parse_pattern`] does, until `progress` is cancelled. The repair of a drawing and the
/// check of its edges against each other end early; the other parts take time in proportion to the size of the file.
///
/// # Errors
/// If the bytes hold no flat crease pattern, or the call was cancelled.
pub fn parse_pattern_watched(
    path: &Path,
    bytes: &[u8],
    progress: &Progress,
) -> Result<fold::PatternFile, FileError> {
    let watch = Watch::new(progress);
    watch.begin(Stage::Reading);
    parse_within(path, bytes, &ReadOptions::default(), watch).map_err(|error| {
        if progress.is_cancelled() {
            let path = path.to_path_buf();
            return FileError::Cancelled { path };
        }
        error
    })
}

fn parse_within(
    path: &Path,
    bytes: &[u8],
    options: &ReadOptions,
    watch: Watch<'_>,
) -> Result<fold::PatternFile, FileError> {
    let format = options.format.unwrap_or_else(|| Format::of_name(path));
    options.check(path, format)?;
    let mut file = match format {
        #[cfg(feature = "svg")]
        Format::Svg => svg::parse_pattern(path, text(path, bytes)?, options, watch),
        #[cfg(feature = "svg")]
        Format::Opx => opx::parse_pattern(path, text(path, bytes)?, options, watch),
        #[cfg(feature = "dxf")]
        Format::Dxf => dxf::parse_pattern(path, bytes, options, watch),
        #[cfg(not(feature = "svg"))]
        Format::Svg | Format::Opx => Err(not_built(path, format, "svg")),
        #[cfg(not(feature = "dxf"))]
        Format::Dxf => Err(not_built(path, format, "dxf")),
        Format::Cp => cp::parse_pattern(path, text(path, bytes)?, options, watch),
        Format::Obj => obj::parse_pattern(path, text(path, bytes)?, watch),
        Format::Fold | Format::Stl => fold::parse_within(path, bytes, options, watch),
    }?;
    file.pattern = straightened_as_asked(file.pattern, options, watch);
    if let Some(unit) = options.unit {
        check_unit(path, file.pattern.unit(), unit)?;
        file.pattern.measured_in(Some(unit));
    }
    Ok(file)
}

/// Returns the error that this program was built without the reader of a format.
#[cfg(not(all(feature = "svg", feature = "dxf")))]
fn not_built(path: &Path, format: Format, feature: &str) -> FileError {
    let expected =
        format!("a format of this program, which was built without its feature `{feature}`");
    FileError::expected(path, "the file", expected, format.described())
}

/// Checks that a unit of lengths that the user tells does not contradict that of a file. `path` names the file in errors.
///
/// # Errors
/// If it does.
pub fn check_unit(path: &Path, unit: Option<Unit>, told: Unit) -> Result<(), FileError> {
    match unit {
        Some(unit) if unit != told => {
            let expected = format!("no unit, or {}", told.name());
            Err(FileError::expected(
                path,
                "the unit of lengths",
                expected,
                unit.name(),
            ))
        }
        _ => Ok(()),
    }
}

/// Straightens a pattern, or notes within which tolerance that may be done if it does not fold as it is.
fn straightened_as_asked(
    mut pattern: CreasePattern,
    options: &ReadOptions,
    watch: Watch<'_>,
) -> CreasePattern {
    let of_lines = pattern.straightens_within().unwrap_or_default();
    let usual = straighten::tolerance(&pattern).max(of_lines);
    let asked = options.tolerance.unwrap_or(usual);
    pattern.straighten_within(None);
    match options.straighten {
        Straighten::Off => {}
        // A large tolerance says that lines end in the wrong places, not that their directions are wrong.
        Straighten::Auto => pattern.straighten_within(Some(asked.min(usual))),
        Straighten::On => {
            if let Some((mut straight, how)) = straightened(&pattern, asked, watch) {
                straight.repaired(how.to_string());
                return straight;
            }
        }
    }
    pattern
}

/// Reads all bytes of a file. Reading stops after `most` + 1 bytes, because a device may deliver bytes without end.
///
/// # Errors
/// If the system reports an error, or the file has more than `most` bytes.
pub(crate) fn read_bytes(path: &Path, most: u64) -> Result<Vec<u8>, FileError> {
    let read = || {
        let file = File::open(path)?;
        let size = file.metadata()?.len().min(most);
        let mut bytes = Vec::with_capacity(usize::try_from(size).unwrap_or_default());
        file.take(most + 1).read_to_end(&mut bytes)?;
        Ok(bytes)
    };
    let bytes = read().map_err(FileError::io(path))?;
    check_size(path, bytes.len(), most)?;
    Ok(bytes)
}

/// Refuses a file of more than `most` bytes.
fn check_size(path: &Path, size: usize, most: u64) -> Result<(), FileError> {
    if u64::try_from(size).is_ok_and(|size| size <= most) {
        return Ok(());
    }
    let expected = format!("at most {} MiB", most >> 20);
    Err(FileError::expected(path, "the file", expected, "more"))
}

/// A folded shape read from a file.
#[derive(Clone, Debug)]
pub struct ShapeFile {
    /// The file's title, or else its name.
    pub title: String,
    /// The shape.
    pub shape: FoldedShape,
    /// Unit of lengths, if the file names one.
    pub unit: Option<Unit>,
    /// Assumptions made while reading, one sentence each.
    pub notes: Vec<String>,
}

/// Parses a folded shape from the bytes of a file. Without a `format`, the ending of the name selects it: `.obj` or `.stl`;
/// every other format is read as FOLD. In a FOLD file `frame` selects the frame to read; frame 0 is the key frame.
///
/// # Errors
/// If the bytes hold no faces in space, or if `frame` is given for a format without frames.
pub fn parse_shape(
    path: &Path,
    bytes: &[u8],
    format: Option<Format>,
    frame: Option<usize>,
) -> Result<ShapeFile, FileError> {
    let format = format.unwrap_or_else(|| Format::of_name(path));
    match (format, frame) {
        (Format::Obj, None) => obj::parse_shape(path, text(path, bytes)?),
        (Format::Stl, None) => stl::parse_shape(path, bytes),
        (Format::Obj | Format::Stl, Some(frame)) => {
            let expected = "a FOLD file, which has frames";
            let place = format!("frame {frame}");
            let found = format.described();
            Err(FileError::expected(path, place, expected, found))
        }
        _ => fold::parse_shape(path, bytes, frame),
    }
}

/// Returns the name of a file without its ending.
fn stem(path: &Path) -> String {
    let stem = path.file_stem().unwrap_or_default();
    stem.to_string_lossy().into_owned()
}

/// Decodes the bytes of a file as UTF-8, without a byte order mark.
fn text<'a>(path: &Path, bytes: &'a [u8]) -> Result<&'a str, FileError> {
    let text = str::from_utf8(bytes).map_err(|error| {
        let place = format!("byte {}", error.valid_up_to());
        FileError::expected(path, place, "text in UTF-8", "other bytes")
    })?;
    Ok(text.strip_prefix(BYTE_ORDER_MARK).unwrap_or(text))
}

/// Byte order mark, which some programs write at the beginning of a text.
const BYTE_ORDER_MARK: char = '\u{feff}';
