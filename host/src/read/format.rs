//! Formats of files, told by the ending of a name or by content.

use std::path::Path;

use super::{BYTE_ORDER_MARK, fold, stl};

/// Format of a file that is read.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[non_exhaustive]
pub enum Format {
    /// FOLD, which is JSON.
    #[default]
    Fold,
    /// SVG drawing.
    Svg,
    /// DXF drawing, as text or binary.
    Dxf,
    /// CP drawing: a line of text for each line of the drawing.
    Cp,
    /// Drawing of ORIPA, which is XML.
    Opx,
    /// Wavefront OBJ.
    Obj,
    /// STL, as text or binary.
    Stl,
}

/// Number of bytes at the beginning of an XML document within which ORIPA's names are looked for.
const XML_HEAD_BYTES: usize = 4096;
/// First words of lines in an OBJ file.
const OBJ_WORDS: [&str; 9] = ["v", "vt", "vn", "f", "l", "o", "g", "mtllib", "usemtl"];

impl Format {
    /// Returns the format that the ending of a name says: `.svg`, `.dxf`, `.cp`, `.opx`, `.obj` or `.stl`; every other ending
    /// stands for FOLD.
    #[must_use]
    pub fn of_name(path: &Path) -> Self {
        let ending = path.extension().unwrap_or_default().to_string_lossy();
        match ending.to_ascii_lowercase().as_str() {
            "svg" => Self::Svg,
            "dxf" => Self::Dxf,
            "cp" => Self::Cp,
            "opx" => Self::Opx,
            "obj" => Self::Obj,
            "stl" => Self::Stl,
            _ => Self::Fold,
        }
    }

    /// Returns a description of a file of this format, such as `an SVG file`.
    #[must_use]
    pub fn described(self) -> String {
        let article = match self {
            Self::Fold | Self::Cp | Self::Dxf => "a",
            _ => "an",
        };
        format!("{article} {} file", self.name())
    }

    /// Returns the format that bytes without a name seem to have:
    ///
    /// 1. STL, if their number fits the count of triangles of a binary STL file, or if they begin with `solid`;
    /// 2. OPX, if they begin with `<` and ORIPA's or Java's names follow within 4096 bytes; else SVG, if they begin with
    ///    `<`;
    /// 3. DXF, if they begin with the words of its binary form, or with a line `0` and a line `SECTION`, after comments with
    ///    the code 999;
    /// 4. OBJ, if the first line that is neither empty nor a comment with `#` begins with a word of OBJ such as `v`;
    /// 5. CP, if this line begins with a number;
    /// 6. FOLD otherwise.
    #[must_use]
    pub fn of_content(bytes: &[u8]) -> Self {
        if stl::triangles(bytes).is_some() {
            return Self::Stl;
        }
        let head = &bytes[..bytes.len().min(XML_HEAD_BYTES)];
        let text = String::from_utf8_lossy(head);
        let text = text.trim_start_matches(BYTE_ORDER_MARK).trim_start();
        if text.starts_with('<') {
            let is_opx = text.contains("oripa") || text.contains("<java");
            return if is_opx { Self::Opx } else { Self::Svg };
        }
        if is_dxf(text) {
            return Self::Dxf;
        }
        let mut lines = text.lines().map(str::trim);
        let line = lines.find(|line| !line.is_empty() && !line.starts_with('#'));
        match line.and_then(|line| line.split_whitespace().next()) {
            Some(_) if stl::is_text(text) => Self::Stl,
            Some(word) if OBJ_WORDS.contains(&word) => Self::Obj,
            Some(word) if word.parse::<f64>().is_ok() => Self::Cp,
            _ => Self::Fold,
        }
    }

    /// Returns the name of the format.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::Fold => "FOLD",
            Self::Svg => "SVG",
            Self::Dxf => "DXF",
            Self::Cp => "CP",
            Self::Opx => "OPX",
            Self::Obj => "OBJ",
            Self::Stl => "STL",
        }
    }

    /// Returns the largest size of a file of this format, bytes.
    #[must_use]
    pub fn largest_file(self) -> u64 {
        match self {
            Self::Fold => fold::MAX_FILE_BYTES,
            Self::Dxf => 1 << 25,
            Self::Svg | Self::Opx => 1 << 26,
            Self::Cp | Self::Obj | Self::Stl => 1 << 28,
        }
    }
}

/// First words of a binary DXF file.
pub(super) const BINARY_DXF: &str = "AutoCAD Binary DXF";

/// Returns `true` if a text begins as a DXF file does.
fn is_dxf(text: &str) -> bool {
    let mut lines = text.lines().map(str::trim);
    loop {
        match (lines.next(), lines.next()) {
            (Some("999"), Some(_)) => {}
            (Some(code), value) => {
                return code.starts_with(BINARY_DXF) || (code, value) == ("0", Some("SECTION"));
            }
            _ => return false,
        }
    }
}
