//! foldpath as a WebAssembly module: what the page of `web/` and the npm package call.
//!
//! Files come and go as bytes, options and answers as the JSON of the command line. Every call works on the caller's
//! thread until it is done, so that a page calls the module in a worker, and cancels a call by ending that worker.

mod told;

use core::fmt::Display;
use core::time::Duration;
use std::path::Path;
use std::sync::Arc;

use foldpath::check::check_watched;
use foldpath::export::fold::{motion_text, pattern_text, write_pattern};
use foldpath::export::svg_pattern::by_letters;
use foldpath::export::{ExportOptions, FORMATS, Place, Source};
use foldpath::motion::{Motion, PlanAnswer};
use foldpath::progress::Watch;
use foldpath::read::fold::{PatternFile, parse_motion};
use foldpath::read::{FileError, parse_pattern_with, parse_shape};
use foldpath::request::{
    self, CheckJson, CheckRequest, FAMILIES, InputJson, Kind, PatternInfo, PlanJson, PlanRequest,
    ReadingRequest, Request, RequestError, Suggestion,
};
use foldpath::unfold::{UnfoldOptions, unfold as unfold_shape};
use foldpath::view::{Scene, page};
use js_sys::{Error, Function, Reflect};
use serde_json::{Value, json};
use wasm_bindgen::prelude::*;
use web_time::Instant;

/// Returns the version of foldpath.
#[wasm_bindgen]
#[must_use]
pub fn version() -> String {
    env!("CARGO_PKG_VERSION").into()
}

/// Returns the pattern of a family as the text of a FOLD file. `family` is JSON such as
/// `{"family": "miura", "rows": 3, "cols": 3}`.
///
/// # Errors
/// If there is no such family, or a parameter is out of its range.
#[wasm_bindgen]
pub fn generate(family: &str) -> Result<String, JsError> {
    let object = serde_json::from_str(family).map_err(refusal)?;
    let (title, drawing) = request::generate(&object).map_err(refusal)?;
    Ok(pattern_text(&title, &drawing))
}

/// Lists the families that [`generate`] makes, as JSON: `name`, `title`, `text` and `parameters`, each with `name`, `text`,
/// the names that it may have (`names`, or `null` for numbers), and its `default`, or the value in the first example if it has
/// none.
#[wasm_bindgen]
#[must_use]
pub fn families() -> String {
    let families = FAMILIES.iter().map(|family| {
        let example: Vec<&str> = family.examples[0].split_whitespace().collect();
        let in_example = |name: &str| {
            let pair = (example.windows(2)).find(|pair| pair[0] == format!("--{name}"))?;
            pair[1].parse::<f64>().ok()
        };
        let parameters = family.parameters.iter().map(|parameter| {
            let names = match parameter.kind {
                Kind::Names(names) => names.iter().map(|(name, _)| *name).collect::<Vec<_>>().into(),
                _ => Value::Null,
            };
            let default = match (parameter.default)() {
                Value::Null => in_example(parameter.name).into(),
                value => value,
            };
            json!({ "name": parameter.name, "text": parameter.text, "names": names, "default": default })
        });
        let text = request::paragraphs(family.text).collect::<Vec<_>>().join(". ");
        let parameters: Vec<Value> = parameters.collect();
        json!({ "name": family.name, "title": family.title, "text": text, "parameters": parameters })
    });
    Value::from_iter(families).to_string()
}

/// Draws a crease pattern as SVG, coloured by its letters. `options` is a JSON object of reading options by their names.
///
/// # Errors
/// If the bytes hold no crease pattern, or an option cannot be met.
#[wasm_bindgen]
pub fn draw(name: &str, bytes: &[u8], options: &str) -> Result<String, JsError> {
    let file = read(name, bytes, &request(options)?)?;
    Ok(by_letters(&file.title, &file.pattern))
}

/// Describes a crease pattern as `foldpath info --json` does. `name` is that of its file, and tells the format; `options`
/// is a JSON object of reading options by their names.
///
/// # Errors
/// If the bytes hold no crease pattern, or an option cannot be met.
#[wasm_bindgen]
pub fn info(name: &str, bytes: &[u8], options: &str) -> Result<String, JsError> {
    let reading = request(options)?;
    let file = read(name, bytes, &reading)?;
    let info = PatternInfo::of(&file.pattern, Watch::default());
    serde_json::to_string(&info).map_err(refusal)
}

/// Makes a crease pattern of a folded shape (OBJ, STL, FOLD), as the text of a FOLD file with the goal's fold angles.
///
/// # Errors
/// If the bytes hold no shape, or it cannot be laid flat.
#[wasm_bindgen]
pub fn unfold(name: &str, bytes: &[u8]) -> Result<String, JsError> {
    let path = Path::new(name);
    let file = parse_shape(path, bytes, None, None).map_err(|error| unread(&error, bytes))?;
    let unfolding = unfold_shape(&file.shape, &UnfoldOptions::default()).map_err(refusal)?;
    match (&unfolding.drawing, unfolding.reason) {
        (Some(drawing), _) => {
            let mut text = Vec::new();
            write_pattern(
                &file.title,
                drawing,
                unfolding.precision,
                file.unit,
                &mut text,
            )
            .map_err(refusal)?;
            Ok(String::from_utf8(text)?)
        }
        (None, Some(reason)) => Err(JsError::new(&format!("{name}: {reason}"))),
        (None, None) => Err(JsError::new(&format!("{name}: not unfolded"))),
    }
}

/// Judges a path as `foldpath check --json` does, from the bytes of its file. `options` is a JSON object of the options
/// `bound`, `bend` and `contact`.
///
/// # Errors
/// If the bytes hold no path, or an option cannot be met.
#[wasm_bindgen]
pub fn check(
    name: &str,
    bytes: &[u8],
    options: &str,
    told: Option<Function>,
) -> Result<String, JsError> {
    let request: CheckRequest = request(options)?;
    let options = request.options().map_err(refusal)?;
    let motion = parse_motion(Path::new(name), bytes).map_err(|error| unread(&error, bytes))?;
    let verdict = told::with(told, |progress| check_watched(&motion, &options, progress));
    serde_json::to_string(&CheckJson::of(&motion, &verdict)).map_err(refusal)
}

/// Returns the page of a path, as `foldpath view` writes it, from the bytes of its file.
///
/// # Errors
/// If the bytes hold no path.
#[wasm_bindgen]
pub fn view(name: &str, bytes: &[u8]) -> Result<String, JsError> {
    let motion = parse_motion(Path::new(name), bytes).map_err(|error| unread(&error, bytes))?;
    Ok(page(&Scene::of_path(&motion)))
}

/// Plans a crease pattern. `name` is the name of its file, and tells the format; `options` is a JSON object of the options
/// of `foldpath plan` by their names. `told` is called now and then with the stage (text) and the part of it that is done
/// (a number from 0 to 1, or `undefined`).
///
/// # Errors
/// If the bytes hold no crease pattern, or an option cannot be met. The error has `suggestions`, as [`Planned::suggestions`].
#[wasm_bindgen]
pub fn plan(
    name: &str,
    bytes: &[u8],
    options: &str,
    told: Option<Function>,
) -> Result<Planned, JsValue> {
    let start = Instant::now();
    let request: PlanRequest = request(options)?;
    let file = read(name, bytes, &request.reading)?;
    let no_file = |path: &Path, _: &_, _| {
        let text = format!(
            "{}: expected a goal in the pattern's own file, as this program opens no other",
            path.display()
        );
        Err(RequestError::Usage(text))
    };
    let path = Path::new(name);
    let task = (request.task(path, &file, true, no_file)).map_err(|error| unmet(&error))?;
    let read = start.elapsed();
    let planned = told::with(told, |progress| task.run(&file, read, progress));
    let input = InputJson::of(path, Some(bytes));
    let times = Some([read, Duration::ZERO, start.elapsed()]);
    let json = PlanJson::of(&planned, &request, &input, &file, times);
    let json = serde_json::to_string(&json).map_err(refusal)?;
    let suggestions = Suggestion::of_plan(&planned.plan, &file.pattern);
    let plan = planned.plan;
    let answer = PlanAnswer {
        outcome: plan.outcome.name().into(),
        reached: 0.0,
        bound: request.check.bound,
        bend: 0.0,
    };
    let flat = || Motion {
        answer: Some(answer),
        ..Motion::flat(&file.title, Arc::new(file.pattern))
    };
    Ok(Planned {
        json,
        suggestions: as_text(&suggestions),
        is_path: plan.motion.is_some(),
        motion: plan.motion.unwrap_or_else(flat),
    })
}

/// The answer to a plan.
#[wasm_bindgen]
pub struct Planned {
    json: String,
    suggestions: String,
    /// `false` if no path was found.
    is_path: bool,
    /// The motion as far as it goes, or the flat sheet.
    motion: Motion,
}

#[wasm_bindgen]
impl Planned {
    /// The JSON object of `foldpath plan --json`.
    #[wasm_bindgen(getter)]
    #[must_use]
    pub fn json(&self) -> String {
        self.json.clone()
    }

    /// Changes of an option that may turn a no into a yes, as JSON: `option`, `value`, and the `sentence` before and after both.
    #[wasm_bindgen(getter)]
    #[must_use]
    pub fn suggestions(&self) -> String {
        self.suggestions.clone()
    }

    /// `true` if there is a path, as far as it goes.
    #[wasm_bindgen(getter)]
    #[must_use]
    pub fn has_path(&self) -> bool {
        self.is_path
    }

    /// Returns the page that shows the path, or the flat sheet with what is in the way.
    #[must_use]
    pub fn page(&self) -> String {
        page(&Scene::of_path(&self.motion))
    }

    /// Returns the path as a file: `fold` (as `foldpath plan --keep` writes it), a format of `foldpath export` that is one
    /// file, or `pattern` (an SVG drawing of the flat sheet, which needs no path).
    ///
    /// # Errors
    /// If there is no such format or no path, or the path has no such form.
    pub fn file(&self, format: &str) -> Result<Vec<u8>, JsError> {
        let (motion, name) = (&self.motion, Path::new("path.fold"));
        if !self.is_path && format != "pattern" {
            return Err(JsError::new("no path was found"));
        }
        if format == "fold" {
            return Ok(motion_text(motion).into_bytes());
        }
        let files = FORMATS.iter().filter(|known| known.place == Place::File);
        let known = if format == "pattern" { "svg" } else { format };
        let Some(row) = files.clone().find(|row| row.name == known) else {
            let names: Vec<&str> = files.map(|row| row.name).collect();
            let names = names.join(", ");
            let text = format!("expected fold, {names} or pattern, found {format}");
            return Err(JsError::new(&text));
        };
        let mut bytes = Vec::new();
        let mut sink = |_: &str, content| {
            bytes = content;
            Ok(())
        };
        let options = ExportOptions::default();
        row.make(Source::Motion(motion), name, &options, &mut sink)
            .map_err(refusal)?;
        Ok(bytes)
    }
}

fn read(name: &str, bytes: &[u8], reading: &ReadingRequest) -> Result<PatternFile, JsError> {
    let options = reading.options().map_err(refusal)?;
    parse_pattern_with(Path::new(name), bytes, &options).map_err(|error| unread(&error, bytes))
}

/// Returns the options of a JSON object; empty text has none.
fn request<R: Request>(options: &str) -> Result<R, JsError> {
    let options = if options.is_empty() { "{}" } else { options };
    let given = serde_json::from_str(options)
        .map_err(|error| JsError::new(&format!("options: {error}")))?;
    R::of(&given).map_err(refusal)
}

/// Returns suggestions as JSON.
///
/// # Panics
/// Never: a suggestion has only texts.
fn as_text(suggestions: &[Suggestion]) -> String {
    serde_json::to_string(suggestions).expect("texts are JSON")
}

/// Makes an error of a request that cannot be met. It has the hint in its message, and the change that may help.
fn unmet(error: &RequestError) -> JsValue {
    let hint = match error {
        RequestError::Option { hint, .. } => hint.as_ref(),
        _ => None,
    };
    let suggestions: Vec<Suggestion> = Suggestion::of_error(error).into_iter().collect();
    let error = Error::new(&with_hint(error, hint));
    // A property of a new object can always be set.
    let _ = Reflect::set(&error, &"suggestions".into(), &as_text(&suggestions).into());
    error.into()
}

/// Makes an error of bytes that cannot be read. It says which format they seem to have, if they are not what their name says.
fn unread(error: &FileError, bytes: &[u8]) -> JsError {
    JsError::new(&with_hint(error, error.mistaken(bytes)))
}

fn with_hint(error: impl Display, hint: Option<impl Display>) -> String {
    hint.map_or_else(|| error.to_string(), |hint| format!("{error} ({hint})"))
}

fn refusal(error: impl Display) -> JsError {
    JsError::new(&error.to_string())
}
