//! A FOLD document with the places of its values, for errors that point at them.

use std::path::{Path, PathBuf};

use serde_json::{Map, Value};

use crate::formats::FileError;

/// A parsed FOLD file.
pub(super) struct Document {
    path: PathBuf,
    root: Map<String, Value>,
}

impl Document {
    pub(super) fn read(path: &Path) -> Result<Self, FileError> {
        let text = std::fs::read(path).map_err(|source| FileError::Io {
            path: path.to_path_buf(),
            source,
        })?;
        Self::parse(path, &text)
    }

    pub(super) fn parse(path: &Path, text: &[u8]) -> Result<Self, FileError> {
        let path = path.to_path_buf();
        match serde_json::from_slice(text) {
            Ok(Value::Object(root)) => Ok(Self { path, root }),
            Ok(other) => Err(FileError::Expected {
                path,
                place: "the file".into(),
                expected: "a FOLD object".into(),
                found: kind(&other),
            }),
            Err(error) => Err(FileError::Syntax {
                path,
                line: error.line(),
                column: error.column(),
                // The parser says the position once more.
                message: match error.to_string().split_once(" at line ") {
                    Some((message, _)) => message.into(),
                    None => error.to_string(),
                },
            }),
        }
    }

    pub(super) fn path(&self) -> &Path {
        &self.path
    }

    /// The key frame.
    pub(super) fn key_frame(&self) -> Frame<'_> {
        Frame {
            document: self,
            layers: vec![(&self.root, String::new())],
        }
    }

    /// Number of frames beside the key frame.
    pub(super) fn frame_count(&self) -> Result<usize, FileError> {
        match self.key_frame().own("file_frames") {
            Some(frames) => Ok(frames.list()?.len()),
            None => Ok(0),
        }
    }

    /// Frame `index` of `file_frames`, inheriting from its parents as it says.
    pub(super) fn frame(&self, index: usize) -> Result<Frame<'_>, FileError> {
        let mut layers = Vec::new();
        // Frame numbers count the key frame as 0.
        let mut number = index + 1;
        loop {
            if number == 0 {
                layers.push((&self.root, String::new()));
                break;
            }
            let place = format!("file_frames[{}]", number - 1);
            let frames = self.root.get("file_frames").and_then(Value::as_array);
            let frame = frames.and_then(|f| f.get(number - 1));
            let Some(Value::Object(map)) = frame else {
                let found = frame.map_or("none".into(), kind);
                return Err(self.expected(place, "a frame", &found));
            };
            layers.push((map, place.clone() + "."));
            if map.get("frame_inherit") != Some(&Value::Bool(true)) {
                break;
            }
            let parent = map.get("frame_parent").and_then(Value::as_u64);
            let parent = parent.and_then(|p| usize::try_from(p).ok());
            // Parents come earlier, so that no chain of them is a circle.
            match parent {
                Some(parent) if parent < number => number = parent,
                _ => {
                    let place = format!("{place}.frame_parent");
                    let found = map.get("frame_parent").map_or("none".into(), kind);
                    return Err(self.expected(place, "the number of an earlier frame", &found));
                }
            }
        }
        Ok(Frame {
            document: self,
            layers,
        })
    }

    pub(super) fn expected(&self, place: String, expected: &str, found: &str) -> FileError {
        FileError::Expected {
            path: self.path.clone(),
            place,
            expected: expected.into(),
            found: found.into(),
        }
    }
}

/// A frame and those it inherits from.
pub(super) struct Frame<'a> {
    document: &'a Document,
    layers: Vec<(&'a Map<String, Value>, String)>,
}

impl<'a> Frame<'a> {
    /// The value of a key, its own or inherited.
    pub(super) fn get(&self, key: &str) -> Option<Located<'a>> {
        self.layers
            .iter()
            .find_map(|layer| self.in_layer(layer, key))
    }

    /// The value of a key that the frame itself has.
    pub(super) fn own(&self, key: &str) -> Option<Located<'a>> {
        self.in_layer(self.layers.first()?, key)
    }

    fn in_layer(
        &self,
        (map, prefix): &(&'a Map<String, Value>, String),
        key: &str,
    ) -> Option<Located<'a>> {
        Some(Located {
            document: self.document,
            value: map.get(key)?,
            place: format!("{prefix}{key}"),
        })
    }

    /// The value of a key that must be there.
    pub(super) fn require(&self, key: &str) -> Result<Located<'a>, FileError> {
        self.get(key).ok_or_else(|| self.missing(key, "a list"))
    }

    /// That the frame lacks a key.
    pub(super) fn missing(&self, key: &str, expected: &str) -> FileError {
        let place = format!("{}{key}", self.prefix());
        self.document.expected(place, expected, "nothing")
    }

    /// What stands before the frame's keys in places.
    pub(super) fn prefix(&self) -> &str {
        self.layers.first().map_or("", |layer| &layer.1)
    }

    /// Whether the frame is of that class.
    pub(super) fn is_a(&self, class: &str) -> bool {
        let classes = self.own("frame_classes").and_then(|c| c.value.as_array());
        classes.is_some_and(|classes| classes.iter().any(|c| c.as_str() == Some(class)))
    }
}

/// A value and its place.
#[derive(Clone)]
pub(super) struct Located<'a> {
    document: &'a Document,
    value: &'a Value,
    place: String,
}

impl<'a> Located<'a> {
    pub(super) fn expected(&self, expected: &str) -> FileError {
        let (place, found) = (self.place.clone(), kind(self.value));
        self.document.expected(place, expected, &found)
    }

    pub(super) fn is_null(&self) -> bool {
        self.value.is_null()
    }

    pub(super) fn list(&self) -> Result<&'a [Value], FileError> {
        let list = self
            .value
            .as_array()
            .ok_or_else(|| self.expected("a list"))?;
        Ok(list)
    }

    /// The entries of a list.
    pub(super) fn entries(&self) -> Result<impl ExactSizeIterator<Item = Located<'a>>, FileError> {
        let (document, place) = (self.document, self.place.clone());
        Ok(self
            .list()?
            .iter()
            .enumerate()
            .map(move |(index, value)| Located {
                document,
                value,
                place: format!("{place}[{index}]"),
            }))
    }

    /// The entries of a list that must have `length` of them.
    pub(super) fn entries_of(
        &self,
        length: usize,
        of: &str,
    ) -> Result<impl ExactSizeIterator<Item = Located<'a>>, FileError> {
        let found = self.list()?.len();
        if found != length {
            let expected = format!("{length} entries, one for each {of}");
            let place = self.place.clone();
            return Err(self
                .document
                .expected(place, &expected, &format!("{found}")));
        }
        self.entries()
    }

    pub(super) fn number(&self) -> Result<f64, FileError> {
        let number = self.value.as_f64().filter(|n| n.is_finite());
        number.ok_or_else(|| self.expected("a number"))
    }

    pub(super) fn index(&self) -> Result<usize, FileError> {
        let index = self.value.as_u64().and_then(|i| u32::try_from(i).ok());
        index
            .map(|i| i as usize)
            .ok_or_else(|| self.expected("a whole number from 0"))
    }

    pub(super) fn text(&self) -> Result<&'a str, FileError> {
        self.value.as_str().ok_or_else(|| self.expected("a string"))
    }
}

/// What a value is, in words short enough for a message.
fn kind(value: &Value) -> String {
    match value {
        Value::Null => "null".into(),
        Value::Array(list) => format!("a list of {}", list.len()),
        Value::Object(_) => "an object".into(),
        Value::String(text) if text.chars().count() > 20 => {
            format!("\"{}...\"", text.chars().take(20).collect::<String>())
        }
        other => other.to_string(),
    }
}
