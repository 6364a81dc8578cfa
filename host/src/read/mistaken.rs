//! Recognises files of formats that are not read, and files whose name has the ending of another format.

use core::fmt;

use super::fold::A_DOCUMENT;
use super::{BYTE_ORDER_MARK, FileError, Format, stl};

/// Format that a file seems to have where it could not be read. `Display` makes a sentence with what to do about it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum Mistaken {
    /// A folded shape, OBJ or STL, which has to be unfolded.
    Shape(Format),
    /// A path for a controller.
    Trajectory,
    /// Another one, with what to do about it.
    Other(&'static str),
    /// None that is known, under a name whose ending says none either.
    Unknown,
}

impl fmt::Display for Mistaken {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Shape(format) => {
                let (file, name) = (format.described(), format.name().to_lowercase());
                write!(
                    f,
                    "it seems to be {file}, a folded shape: with a name in .{name} it can be unfolded"
                )
            }
            Self::Trajectory => f.write_str("it is a path for a controller, made of a FOLD file"),
            Self::Other(advice) => f.write_str(advice),
            Self::Unknown => f.write_str(ENDINGS),
        }
    }
}

/// Number of bytes at the beginning of a file by which its format is recognised.
const HEAD_BYTES: usize = 512;

const PIXELS: &str = "it is a picture of pixels, which has no lines: draw the creases over it in a drawing program, and export them as \
                      SVG or DXF";
const PAGE: &str = "PDF, AI and EPS are not read: export the drawing as SVG or DXF";
const ARCHIVE: &str = "it is an archive: unpack it, and take the drawing in it";
const CAD: &str = "such CAD files are not read: export the flat drawing as DXF or SVG, or the folded shape as OBJ or STL";
const MESH: &str = "such meshes are not read: export the folded shape as OBJ or STL";
const ORIEDITA: &str = "it seems to be a file of Oriedita: export the drawing as CP or FOLD, with a name in .cp or .fold";
const ORIHIME: &str = "it seems to be a file of Orihime or Oriedita: export the drawing as CP or FOLD, with a name in .cp or .fold";
const TREEMAKER: &str =
    "it seems to be a file of TreeMaker: export its crease pattern as FOLD or SVG";
const XML: &str =
    "it seems to be a drawing in XML: its name has to end in .svg, or in .opx if ORIPA wrote it";
const CP: &str = "it seems to be a CP drawing: its name has to end in .cp";
const DXF: &str = "it seems to be a DXF drawing: its name has to end in .dxf";
const ENDINGS: &str = "a name's ending says its format: .fold, .svg, .dxf, .cp or .opx, or for folded shapes .obj or .stl; all \
                       others are read as FOLD";

/// First bytes of files that are not read, from a position on. No file of a format that is read has them.
const SIGNATURES: [(usize, &[u8], &str); 18] = [
    (0, b"\x89PNG", PIXELS),
    (0, b"\xff\xd8\xff", PIXELS),
    (0, b"GIF8", PIXELS),
    (0, b"II*\0", PIXELS),
    (0, b"MM\0*", PIXELS),
    (8, b"WEBP", PIXELS),
    (4, b"ftyphei", PIXELS),
    (4, b"ftypmif1", PIXELS),
    (4, b"ftypavif", PIXELS),
    (0, b"%PDF", PAGE),
    (0, b"%!PS", PAGE),
    (0, b"PK\x03\x04", ARCHIVE),
    (0, b"\x1f\x8b", ARCHIVE),
    (0, b"7z\xbc\xaf", ARCHIVE),
    (0, b"Rar!", ARCHIVE),
    (0, b"ISO-10303-21", CAD),
    (0, b"AC10", CAD),
    (0, b"glTF", MESH),
];

/// Endings of names of files that are not read, in small letters.
const FOREIGN_ENDINGS: [(&[&str], &str); 8] = [
    // Before the archives, which many of these files are.
    (&["3mf", "blend", "glb", "gltf", "ply"], MESH),
    (
        &[
            "3dm", "dwg", "f3d", "fcstd", "iges", "igs", "ipt", "skp", "sldprt", "step", "stp",
        ],
        CAD,
    ),
    (
        &[
            "avif", "bmp", "gif", "heic", "jpeg", "jpg", "png", "tif", "tiff", "webp",
        ],
        PIXELS,
    ),
    (&["ai", "eps", "pdf", "ps"], PAGE),
    (&["7z", "gz", "rar", "svgz", "zip"], ARCHIVE),
    (&["ori"], ORIEDITA),
    (&["orh"], ORIHIME),
    (&["tmd5"], TREEMAKER),
];

impl FileError {
    /// Returns the format that the file seems to have, if the error can be that it is not the one as which the file was
    /// read. `head` has the bytes at the beginning of the file, of which the first 512 are looked at.
    #[must_use]
    pub fn mistaken(&self, head: &[u8]) -> Option<Mistaken> {
        let head = &head[..head.len().min(HEAD_BYTES)];
        let ending = self.path().extension().unwrap_or_default();
        let ending = ending.to_string_lossy().to_ascii_lowercase();
        let of_ending = (FOREIGN_ENDINGS.iter())
            .find(|(endings, _)| endings.contains(&ending.as_str()))
            .map(|(_, advice)| *advice);
        match self {
            Self::Expected { place, found, .. }
                if place == "vertices_coords" && found == "nothing" =>
            {
                (ending == "ori").then_some(Mistaken::Other(ORIEDITA))
            }
            Self::Expected { expected, .. } if expected != A_DOCUMENT => {
                signed(head).map(Mistaken::Other)
            }
            Self::Syntax { .. } | Self::Expected { .. } => of_ending
                .or_else(|| signed(head))
                .map(Mistaken::Other)
                .or_else(|| of_text(head, &ending)),
            _ => None,
        }
    }
}

/// Returns what to do about a file that is not read, by its first bytes.
fn signed(head: &[u8]) -> Option<&'static str> {
    let begins = |at: usize, bytes: &[u8]| head.get(at..).is_some_and(|it| it.starts_with(bytes));
    let mut known = SIGNATURES.iter();
    let (.., advice) = known.find(|(at, bytes, _)| begins(*at, bytes))?;
    Some(advice)
}

/// Returns the format that a text seems to have by its first line that is neither empty nor a comment with `#`.
fn of_text(head: &[u8], ending: &str) -> Option<Mistaken> {
    let text = String::from_utf8_lossy(head);
    let text = text.trim_start_matches(BYTE_ORDER_MARK);
    let mut lines = text.lines().map(str::trim);
    let first = lines.find(|line| !line.is_empty() && !line.starts_with('#'))?;
    let words = first.split_whitespace();
    let numbers = words.filter(|word| word.parse::<f64>().is_ok()).count();
    Some(Mistaken::Other(if first == "tree" {
        TREEMAKER
    } else if first == "ply" {
        MESH
    } else if first.starts_with("FPTJ") {
        return Some(Mistaken::Trajectory);
    } else if first.starts_with('<') {
        XML
    } else if first.starts_with("v ") && numbers >= 3 {
        return Some(Mistaken::Shape(Format::Obj));
    } else if ending == "stl" || stl::is_text(first) {
        return Some(Mistaken::Shape(Format::Stl));
    } else if numbers == 5 {
        CP
    } else if Format::of_content(head) == Format::Dxf {
        DXF
    } else if !first.starts_with('{') && !matches!(ending, "fold" | "json") {
        return Some(Mistaken::Unknown);
    } else {
        return None;
    }))
}
