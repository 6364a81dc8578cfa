//! Prints errors: one line with file, place and what was expected, then the line of the file with the place underlined,
//! and a hint if there is one. Colours are used if stderr is a terminal that has them.

use core::any::Any;
use core::fmt::Display;
use core::ops::Range;
use std::borrow::Cow;
use std::io::Write;
use std::path::Path;

use annotate_snippets::{AnnotationKind, Group, Level, Renderer, Snippet};
use anstyle::{AnsiColor, Style};
use serde::Serialize;

use crate::args::Report;
use crate::standard::{source, text};
use crate::{Answer, CliError, hints};
use foldpath::pattern::LostLines;
use foldpath::request::RequestError;

/// Largest number of characters of a line that are shown.
const MAX_SHOWN_CHARS: usize = 72;
/// Number of characters shown before the place of an error, if the line is too long to be shown whole.
const CHARS_BEFORE: usize = 30;
/// Mark in place of characters that are not shown.
const CUT: &str = "...";

/// Red, for errors.
pub(crate) const BAD: Style = AnsiColor::Red.on_default().bold();
/// Yellow, for answers that are no.
pub(crate) const NO: Style = AnsiColor::Yellow.on_default().bold();
/// Green, for answers that are yes.
pub(crate) const YES: Style = AnsiColor::Green.on_default().bold();

/// Returns a text in a style. The stream that prints the text removes the style if it has no colours.
pub(crate) fn styled(style: Style, text: &str) -> String {
    format!("{style}{text}{style:#}")
}

/// Returns the text of an outcome in the style of a yes or a no.
pub(crate) fn outcome(good: bool, text: &str) -> String {
    styled(if good { YES } else { NO }, text)
}

/// Says how many lines of a drawing were left out, where the first is open, and how to keep them.
pub(crate) fn lost_lines(lost: &LostLines) -> String {
    // Seven digits, as drawing programs write them.
    let digits = |number: f64| format!("{number:.6e}").parse().unwrap_or(number);
    let [x, y] = lost.open_end.map(digits);
    let keep = match lost.kept_by {
        Some(tolerance) => format!("--tolerance {tolerance} keeps all"),
        None => "no --tolerance was found that keeps all".into(),
    };
    let lost = format!(
        "{} end in the open, up to {:.1e} long, the first at ({x}, {y})",
        lost.count, lost.longest
    );
    styled(NO, &lost) + "; " + &keep
}

/// Prints an error on stderr. A failure to write is ignored.
pub(crate) fn tell(error: &CliError) {
    let text = text_of(error);
    let _gone = writeln!(anstream::stderr(), "{text}");
}

/// Tells that the time of a command ran out before it had anything to tell of a file: the answer is not known.
pub(crate) fn out_of_time(file: &Path, no: impl Display, report: &Report) -> Answer {
    let error = CliError::Usage(format!("{}: {no}", source(file)));
    tell(&error);
    if report.json {
        tell_json(&error);
    }
    Ok(false)
}

/// Returns a sentence about a panic.
#[must_use]
pub fn panic_text(panic: &(dyn Any + Send)) -> String {
    let text = panic.downcast_ref::<String>().map(String::as_str);
    let text = text.or_else(|| panic.downcast_ref::<&str>().copied());
    format!("a defect of foldpath: {}", text.unwrap_or("panic"))
}

/// An error in the JSON of the command line.
#[derive(Serialize)]
pub(crate) struct ErrorJson<'a> {
    pub(crate) error: ErrorFields<'a>,
}

/// The fields of an error in JSON.
#[derive(Serialize)]
#[non_exhaustive]
pub struct ErrorFields<'a> {
    /// The file; empty if the error is about the arguments.
    pub file: String,
    /// Line in the file, from 1.
    pub line: Option<usize>,
    /// Column in the line, from 1.
    pub column: Option<usize>,
    message: Cow<'a, str>,
    /// Advice on correcting it, if there is any.
    pub hint: Option<String>,
}

impl<'a> ErrorFields<'a> {
    /// Returns what is told of an error.
    #[must_use]
    pub fn of(error: &CliError) -> Self {
        let (file, excerpt) = match error {
            CliError::Request(RequestError::Goal { file, .. }) => (file.clone(), None),
            _ => of_file(error).unwrap_or_default(),
        };
        Self {
            file,
            line: excerpt.as_ref().map(|excerpt| excerpt.line),
            column: excerpt.as_ref().map(|excerpt| excerpt.column),
            message: error.to_string().into(),
            hint: hints::hint(error),
        }
    }

    /// Returns a message that is about no file.
    pub(crate) fn of_message(message: &'a str) -> Self {
        Self {
            file: String::new(),
            line: None,
            column: None,
            message: message.trim().into(),
            hint: None,
        }
    }
}

/// Prints an error as one JSON object on stdout. A failure to write is ignored.
pub(crate) fn tell_json(error: &CliError) {
    print_error(ErrorFields::of(error));
}

/// Prints a message about the arguments as one JSON object on stdout. A failure to write is ignored.
pub(crate) fn tell_usage_json(message: &str) {
    print_error(ErrorFields::of_message(message));
}

fn print_error(error: ErrorFields<'_>) {
    let _gone = crate::print_json(&ErrorJson { error });
}

/// Returns the name of the file that an error is about, and the place in its text.
fn of_file(error: &CliError) -> Option<(String, Option<Excerpt>)> {
    let (file, place) = match error {
        CliError::File(file) => (file, file.locate()),
        CliError::Piped { error, bytes } => {
            let text = text(bytes);
            let span = error.locate_in(&text);
            (&**error, span.map(|span| (text, span)))
        }
        _ => return None,
    };
    let excerpt = place.and_then(|(text, span)| Excerpt::of(&text, span));
    Some((file.path().display().to_string(), excerpt))
}

/// Returns the full text of an error, without the name of the command, colours and the last newline.
#[must_use]
pub fn plain_text(error: &CliError) -> String {
    let text = text_of(error);
    let text = anstream::adapter::strip_str(&text).to_string();
    text.trim_start_matches("foldpath: ").into()
}

/// Returns the full text of an error, with colours and without the last newline.
fn text_of(error: &CliError) -> String {
    let mut message = error.to_string();
    let (file, excerpt) = of_file(error).unwrap_or_default();
    if let Some(excerpt) = &excerpt {
        let name = format!("{file}: ");
        // A place that is a key or a list index is no position in the text yet, so line and column are added.
        if let Some(rest) = message
            .strip_prefix(&name)
            .filter(|rest| !rest.starts_with("line "))
        {
            let position = format!("{}:{}", excerpt.line, excerpt.column);
            message = format!("{file}:{position}: {rest}");
        }
    }
    let mut group = Group::with_level(Level::ERROR);
    if let Some(Excerpt {
        line, shown, mark, ..
    }) = excerpt
    {
        let snippet = Snippet::source(shown).line_start(line);
        group = group.element(snippet.annotation(AnnotationKind::Primary.span(mark)));
    }
    if let Some(hint) = hints::hint(error) {
        group = group.element(Level::NOTE.with_name("hint").message(hint));
    }
    let mut text = format!("{} {message}", styled(BAD, "foldpath:"));
    if !group.is_empty() {
        text += "\n";
        text += &Renderer::styled().render(&[group]);
    }
    text
}

/// Excerpt of a line of a file, with the place of an error.
#[derive(Debug, PartialEq)]
struct Excerpt {
    /// Line number, from 1.
    line: usize,
    /// Column in characters, from 1.
    column: usize,
    /// The line, or the part of the line round the place.
    shown: String,
    /// Bytes of `shown` to underline.
    mark: Range<usize>,
}

impl Excerpt {
    /// Returns the excerpt at these bytes of a text. If the bytes span several lines, only the first line counts.
    fn of(text: &str, span: Range<usize>) -> Option<Self> {
        let (before, rest) = text.split_at_checked(span.start)?;
        let start = before.rfind('\n').map_or(0, |newline| newline + 1);
        let head = &before[start..];
        let line_rest = rest.split('\n').next()?.trim_end_matches('\r');
        let marked = line_rest.get(..span.len()).unwrap_or(line_rest);
        // A line that is too long to be shown whole is cut at both ends.
        let length = head.chars().count();
        let whole = length + line_rest.chars().take(MAX_SHOWN_CHARS).count() <= MAX_SHOWN_CHARS;
        let (head, cut) = match head.char_indices().rev().nth(CHARS_BEFORE - 1) {
            Some((at, _)) if at > 0 && !whole => (&head[at..], CUT),
            _ => (head, ""),
        };
        let left = MAX_SHOWN_CHARS - head.chars().count().min(MAX_SHOWN_CHARS);
        let end = line_rest.char_indices().nth(left).map(|(at, _)| at);
        let tail = &line_rest[..end.unwrap_or(line_rest.len())];
        let mark = cut.len() + head.len();
        Some(Self {
            line: before.matches('\n').count() + 1,
            column: length + 1,
            mark: mark..mark + marked.len().min(tail.len()),
            shown: format!("{cut}{head}{tail}{}", if end.is_some() { CUT } else { "" }),
        })
    }
}
