//! A parsed FOLD document, its frames with inheritance, and the places of its values for errors.

use std::path::{Path, PathBuf};

use super::json::{Json, Value};
use crate::read::FileError;

/// A parsed FOLD file.
pub(super) struct Document {
    pub(super) path: PathBuf,
    json: Json,
}

/// Description of a whole file, which errors expect.
pub(crate) const A_DOCUMENT: &str = "a FOLD object";

impl Document {
    pub(super) fn parse(path: &Path, bytes: &[u8]) -> Result<Self, FileError> {
        let path = path.to_path_buf();
        let text = bytes.strip_prefix("\u{feff}".as_bytes()).unwrap_or(bytes);
        match Json::parse(text) {
            Ok(json) if json.root().is_object() => Ok(Self { path, json }),
            Ok(json) => {
                let found = json.root().kind();
                Err(FileError::expected(&path, "the file", A_DOCUMENT, found))
            }
            Err(error) => Err(FileError::Syntax {
                path,
                line: error.line(),
                column: error.column(),
                // The parser's message repeats the position, which is cut off.
                message: match error.to_string().split_once(" at line ") {
                    _ if is_comment(text, error.line(), error.column()) => NO_COMMENTS.into(),
                    Some((message, _)) => message.into(),
                    None => error.to_string(),
                },
            }),
        }
    }

    /// Returns the key frame.
    pub(super) fn key_frame(&self) -> Frame<'_> {
        Frame {
            document: self,
            layers: vec![(self.json.root(), 0)],
        }
    }

    /// Returns the keys of the key frame and of the frames in `file_frames`.
    pub(super) fn keys(&self) -> impl Iterator<Item = &str> {
        let root = self.json.root();
        let frames = root.get("file_frames").and_then(|frames| frames.list());
        let objects = core::iter::once(root).chain(frames.into_iter().flatten());
        let keys = objects.flat_map(|object| object.members());
        keys.filter_map(|(key, _)| key.as_str())
    }

    /// Returns the frames in `file_frames`. Fails if one is no object, inherits from a frame that does not exist, or
    /// inherits from itself through other frames. Cost: linear in the number of frames.
    pub(super) fn frames(&self) -> Result<Frames<'_>, FileError> {
        let objects = match self.key_frame().own("file_frames") {
            Some(frames) => frames.list()?.collect(),
            None => Vec::new(),
        };
        let last = objects.len();
        let parents = objects.iter().enumerate();
        let parents = parents.map(|(index, frame)| self.parent(index, *frame, last));
        let parents: Vec<Option<usize>> = parents.collect::<Result<_, _>>()?;
        let classes = self.classes(&objects, &parents)?;
        Ok(Frames {
            document: self,
            objects,
            parents,
            classes,
        })
    }

    /// Returns the classes of the key frame and of each other frame. `parents` has the frame that each other frame
    /// inherits from.
    fn classes(
        &self,
        objects: &[Value<'_>],
        parents: &[Option<usize>],
    ) -> Result<Vec<Classes>, FileError> {
        let mut known = vec![None; objects.len() + 1];
        known[0] = Some(Classes::of(self.json.root(), Classes::default()));
        // Frames that were visited. A visited frame has known classes, unless it is in the chain that is being
        // followed.
        let mut seen = vec![false; objects.len() + 1];
        let mut chain = Vec::new();
        for number in 1..=objects.len() {
            let mut next = Some(number);
            while let Some(frame) = next.filter(|&frame| known[frame].is_none()) {
                if seen[frame] {
                    return Err(self.circle(objects, &chain, frame));
                }
                seen[frame] = true;
                chain.push(frame);
                next = parents[frame - 1];
            }
            let mut inherited = next.and_then(|frame| known[frame]).unwrap_or_default();
            while let Some(frame) = chain.pop() {
                inherited = Classes::of(objects[frame - 1], inherited);
                known[frame] = Some(inherited);
            }
        }
        Ok(known.into_iter().flatten().collect())
    }

    /// Makes the error that the last frame of a chain inherits from a frame of the same chain.
    fn circle(&self, objects: &[Value<'_>], chain: &[usize], parent: usize) -> FileError {
        let index = chain.last().map_or(0, |frame| frame - 1);
        let place = format!("file_frames[{index}].frame_parent");
        let expected = if parent == index + 1 {
            "another frame than this".into()
        } else {
            format!(
                "a frame that does not inherit from this, frame {}",
                index + 1
            )
        };
        let found = objects[index].get("frame_parent");
        let found = found.map_or("none".into(), |found| found.kind());
        self.expected(place, &expected, &found)
    }

    /// Returns the frame that frame `index` of `file_frames` inherits from, if any. The key frame is 0, and `last` is
    /// the last frame.
    fn parent(
        &self,
        index: usize,
        frame: Value<'_>,
        last: usize,
    ) -> Result<Option<usize>, FileError> {
        let place = format!("file_frames[{index}]");
        if !frame.is_object() {
            return Err(self.expected(place, "a frame", &frame.kind()));
        }
        if !frame.get("frame_inherit").is_some_and(|it| it.is_true()) {
            return Ok(None);
        }
        let parent = frame.get("frame_parent");
        let known = parent.and_then(|p| usize::try_from(p.as_u64()?).ok());
        let known = known.filter(|parent| *parent <= last);
        if known.is_some() {
            return Ok(known);
        }
        let place = format!("{place}.frame_parent");
        let found = parent.map_or("none".into(), |parent| parent.kind());
        Err(self.expected(
            place,
            &format!("the number of a frame, 0 to {last}"),
            &found,
        ))
    }

    pub(super) fn expected(&self, place: String, expected: &str, found: &str) -> FileError {
        FileError::expected(&self.path, place, expected, found)
    }
}

/// Message about a comment.
const NO_COMMENTS: &str = "JSON has no comments, expected the file without them";

/// Returns `true` if a comment begins at a position of a text, counted from 1.
fn is_comment(text: &[u8], line: usize, column: usize) -> bool {
    let mut lines = text.split(|byte| *byte == b'\n');
    let line = lines.nth(line.saturating_sub(1)).unwrap_or_default();
    // The parser may stop one sign before the comment, or at it.
    (1..=2).any(|back| {
        let from = column.saturating_sub(back).min(line.len());
        let rest = &line[from..];
        rest.starts_with(b"//") || rest.starts_with(b"/*")
    })
}

/// The classes of a frame that matter to this program.
#[derive(Clone, Copy, Default)]
pub(super) struct Classes {
    pub(super) crease_pattern: bool,
    pub(super) folded_form: bool,
}

impl Classes {
    /// Returns the classes that a frame names, or else the inherited classes.
    fn of(frame: Value<'_>, inherited: Self) -> Self {
        let Some(own) = frame.get("frame_classes").and_then(|it| it.list()) else {
            return inherited;
        };
        own.fold(Self::default(), |this, class| Self {
            crease_pattern: this.crease_pattern || class.as_str() == Some("creasePattern"),
            folded_form: this.folded_form || class.as_str() == Some("foldedForm"),
        })
    }
}

/// The frames in `file_frames`.
pub(super) struct Frames<'a> {
    document: &'a Document,
    objects: Vec<Value<'a>>,
    /// For each frame the number of the frame that it inherits from; the key frame is 0.
    parents: Vec<Option<usize>>,
    /// Classes of the key frame, number 0, and of the frames in `file_frames`, from number 1.
    pub(super) classes: Vec<Classes>,
}

impl<'a> Frames<'a> {
    pub(super) fn len(&self) -> usize {
        self.objects.len()
    }

    /// Returns frame `number` with all that it inherits; the key frame is 0.
    pub(super) fn get(&self, number: usize) -> Frame<'a> {
        let mut frame = self.own(number);
        let mut at = number;
        while let Some(&Some(parent)) = at.checked_sub(1).and_then(|index| self.parents.get(index))
        {
            frame.layers.extend(self.own(parent).layers);
            at = parent;
        }
        frame
    }

    /// Returns `true` if frame `number` is the frame `parent` or inherits from it.
    pub(super) fn inherits(&self, number: usize, parent: usize) -> bool {
        let above = |frame: &usize| *self.parents.get(frame.checked_sub(1)?)?;
        core::iter::successors(Some(number), above).any(|frame| frame == parent)
    }

    /// Returns frame `number` without inherited keys; the key frame is 0. The cost does not depend on the length of its
    /// chain of parents.
    pub(super) fn own(&self, number: usize) -> Frame<'a> {
        let object = number
            .checked_sub(1)
            .and_then(|index| self.objects.get(index));
        let object = object.map_or(self.document.json.root(), |object| *object);
        Frame {
            document: self.document,
            layers: vec![(object, number)],
        }
    }
}

/// Returns the prefix that names a frame in places, such as `file_frames[2].`; empty for the key frame.
fn prefix(frame: usize) -> String {
    match frame.checked_sub(1) {
        Some(index) => format!("file_frames[{index}]."),
        None => String::new(),
    }
}

/// A frame followed by the frames that it inherits from, each with its number; the key frame is 0.
pub(super) struct Frame<'a> {
    document: &'a Document,
    layers: Vec<(Value<'a>, usize)>,
}

impl<'a> Frame<'a> {
    /// Returns the value of a key, the frame's own or an inherited one.
    pub(super) fn get(&self, key: &'static str) -> Option<Located<'a>> {
        self.layers
            .iter()
            .find_map(|&layer| self.in_layer(layer, key))
    }

    /// Returns the value of a key that the frame itself has.
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

    /// Returns the value of a key, or an error if the key is missing.
    pub(super) fn require(&self, key: &'static str) -> Result<Located<'a>, FileError> {
        self.get(key).ok_or_else(|| self.missing(key, "a list"))
    }

    /// Makes the error that the frame lacks a key.
    pub(super) fn missing(&self, key: &str, expected: &str) -> FileError {
        self.expected(key, expected, "nothing")
    }

    /// Makes the error that another value was expected at a key.
    pub(super) fn expected(&self, key: &str, expected: &str, found: &str) -> FileError {
        let place = format!("{}{key}", self.prefix());
        self.document.expected(place, expected, found)
    }

    /// Returns the prefix of a place that begins with one of the frame's keys. The prefix names the frame that has the
    /// key, which may be inherited.
    pub(super) fn prefix_of(&self, place: &str) -> String {
        let keys = ["vertices_coords", "edges_vertices", "faces_vertices"];
        let key = keys.into_iter().find(|key| place.starts_with(key));
        let value = key.and_then(|key| self.get(key));
        value.map_or(String::new(), |value| prefix(value.frame))
    }

    /// Returns the prefix of places in this frame.
    pub(super) fn prefix(&self) -> String {
        self.layers
            .first()
            .map_or(String::new(), |&(_, frame)| prefix(frame))
    }
}

/// A value and its place in the document.
#[derive(Clone, Copy)]
pub(super) struct Located<'a> {
    document: &'a Document,
    value: Value<'a>,
    frame: usize,
    key: &'static str,
    /// Positions in the list of the key and in the list at that position: no list is nested deeper.
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

    /// Returns the entries of a list.
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

    /// Returns the entries of a list that must have `length` of them, one for each `of`.
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

    pub(super) fn flag(&self) -> Result<bool, FileError> {
        let flag = self.value.as_bool();
        flag.ok_or_else(|| self.expected("true or false"))
    }

    pub(super) fn text(&self) -> Result<&'a str, FileError> {
        self.value.as_str().ok_or_else(|| self.expected("a string"))
    }
}
