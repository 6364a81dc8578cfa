//! A FOLD document with the places of its values, for errors that point at them.

use std::path::{Path, PathBuf};

use super::json::{Json, Value};
use crate::formats::FileError;

/// A parsed FOLD file.
pub(super) struct Document {
    path: PathBuf,
    json: Json,
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
        match Json::parse(text) {
            Ok(json) if json.root().is_object() => Ok(Self { path, json }),
            Ok(json) => Err(FileError::Expected {
                path,
                place: "the file".into(),
                expected: "a FOLD object".into(),
                found: json.root().kind(),
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
            layers: vec![(self.json.root(), 0)],
        }
    }

    /// The frames beside the key frame.
    pub(super) fn frames(&self) -> Result<Frames<'_>, FileError> {
        let objects = match self.key_frame().own("file_frames") {
            Some(frames) => frames.list()?.collect(),
            None => Vec::new(),
        };
        Ok(Frames {
            document: self,
            objects,
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

/// The frames beside the key frame.
pub(super) struct Frames<'a> {
    document: &'a Document,
    objects: Vec<Value<'a>>,
}

impl<'a> Frames<'a> {
    pub(super) fn len(&self) -> usize {
        self.objects.len()
    }

    /// Frame `index` of `file_frames`, inheriting from its parents as it says.
    pub(super) fn get(&self, index: usize) -> Result<Frame<'a>, FileError> {
        let document = self.document;
        let mut layers = Vec::new();
        // Frame numbers count the key frame as 0.
        let mut number = index + 1;
        loop {
            if number == 0 {
                layers.push((document.json.root(), 0));
                break;
            }
            let place = || format!("file_frames[{}]", number - 1);
            let frame = self.objects.get(number - 1);
            let Some(frame) = frame.filter(|frame| frame.is_object()) else {
                let found = frame.map_or("none".into(), Value::kind);
                return Err(document.expected(place(), "a frame", &found));
            };
            layers.push((*frame, number));
            if !frame.get("frame_inherit").is_some_and(|it| it.is_true()) {
                break;
            }
            let parent = frame.get("frame_parent");
            let earlier = parent.and_then(|p| usize::try_from(p.as_u64()?).ok());
            // Parents come earlier, so that no chain of them is a circle.
            match earlier {
                Some(parent) if parent < number => number = parent,
                _ => {
                    let place = format!("{}.frame_parent", place());
                    let found = parent.map_or("none".into(), |parent| parent.kind());
                    return Err(document.expected(place, "the number of an earlier frame", &found));
                }
            }
        }
        Ok(Frame { document, layers })
    }
}

/// What stands before the keys of a frame, by its number, in places.
fn prefix(frame: usize) -> String {
    match frame.checked_sub(1) {
        Some(index) => format!("file_frames[{index}]."),
        None => String::new(),
    }
}

/// A frame and those it inherits from, each with its number; the key frame is 0.
pub(super) struct Frame<'a> {
    document: &'a Document,
    layers: Vec<(Value<'a>, usize)>,
}

impl<'a> Frame<'a> {
    /// The value of a key, its own or inherited.
    pub(super) fn get(&self, key: &'static str) -> Option<Located<'a>> {
        self.layers
            .iter()
            .find_map(|&layer| self.in_layer(layer, key))
    }

    /// The value of a key that the frame itself has.
    pub(super) fn own(&self, key: &'static str) -> Option<Located<'a>> {
        self.in_layer(*self.layers.first()?, key)
    }

    fn in_layer(
        &self,
        (object, frame): (Value<'a>, usize),
        key: &'static str,
    ) -> Option<Located<'a>> {
        Some(Located {
            document: self.document,
            value: object.get(key)?,
            frame,
            key,
            indices: [None; 2],
        })
    }

    /// The value of a key that must be there.
    pub(super) fn require(&self, key: &'static str) -> Result<Located<'a>, FileError> {
        self.get(key).ok_or_else(|| self.missing(key, "a list"))
    }

    /// That the frame lacks a key.
    pub(super) fn missing(&self, key: &str, expected: &str) -> FileError {
        let place = format!("{}{key}", self.prefix());
        self.document.expected(place, expected, "nothing")
    }

    /// What stands before the frame's keys in places.
    pub(super) fn prefix(&self) -> String {
        self.layers
            .first()
            .map_or(String::new(), |&(_, frame)| prefix(frame))
    }

    /// Whether the frame is of that class.
    pub(super) fn is_a(&self, class: &str) -> bool {
        let classes = self.own("frame_classes").and_then(|c| c.value.list());
        classes.is_some_and(|mut classes| classes.any(|c| c.as_str() == Some(class)))
    }
}

/// A value and its place.
#[derive(Clone, Copy)]
pub(super) struct Located<'a> {
    document: &'a Document,
    value: Value<'a>,
    frame: usize,
    key: &'static str,
    /// Positions in the list of the key and in the list there: nothing is nested deeper.
    indices: [Option<usize>; 2],
}

impl<'a> Located<'a> {
    fn place(&self) -> String {
        let indices = self.indices.iter().flatten();
        let indices: String = indices.map(|index| format!("[{index}]")).collect();
        format!("{}{}{indices}", prefix(self.frame), self.key)
    }

    pub(super) fn expected(&self, expected: &str) -> FileError {
        self.document
            .expected(self.place(), expected, &self.value.kind())
    }

    pub(super) fn is_null(&self) -> bool {
        self.value.is_null()
    }

    fn list(&self) -> Result<impl ExactSizeIterator<Item = Value<'a>> + use<'a>, FileError> {
        self.value.list().ok_or_else(|| self.expected("a list"))
    }

    /// The entries of a list.
    pub(super) fn entries(
        &self,
    ) -> Result<impl ExactSizeIterator<Item = Located<'a>> + use<'a>, FileError> {
        let list = *self;
        Ok(self.list()?.enumerate().map(move |(index, value)| Located {
            value,
            indices: match list.indices[0] {
                None => [Some(index), None],
                outer => [outer, Some(index)],
            },
            ..list
        }))
    }

    /// The entries of a list that must have `length` of them.
    pub(super) fn entries_of(
        &self,
        length: usize,
        of: &str,
    ) -> Result<impl ExactSizeIterator<Item = Located<'a>> + use<'a>, FileError> {
        let found = self.list()?.len();
        if found != length {
            let expected = format!("{length} entries, one for each {of}");
            let (place, found) = (self.place(), found.to_string());
            return Err(self.document.expected(place, &expected, &found));
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
