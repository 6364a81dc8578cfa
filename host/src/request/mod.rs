//! Requests by name, and answers as JSON: what the command line, the Python package and a page in a browser share.
//!
//! A [`PlanRequest`] has the options of a plan by the names and in the units of the command line: degrees and seconds. It
//! becomes a [`PlanTask`] for a pattern that was read, and its answer a [`PlanJson`]. Requests to judge and to describe
//! are [`CheckRequest`] and [`PatternInfo`]. No file is read or written here: callers read patterns, and
//! [`PlanRequest::task`] asks its caller for the goals that a request names.
//!
//! ```
//! use core::time::Duration;
//! use std::path::Path;
//!
//! use foldpath::export::fold::pattern_text;
//! use foldpath::progress::Progress;
//! use foldpath::read::parse_pattern;
//! use foldpath::request::{InputJson, PlanJson, PlanRequest, Request, RequestError, generate};
//!
//! let (title, drawing) = generate(&serde_json::from_str(r#"{"family": "miura", "rows": 3, "cols": 3}"#)?)?;
//! let bytes = pattern_text(&title, &drawing).into_bytes();
//! let name = Path::new("miura.fold");
//! let file = parse_pattern(name, &bytes)?;
//!
//! let mut request = PlanRequest::default();
//! request.set("bound", &1e-3.into())?;
//! request.set("symmetry", &"off".into())?;
//! let no_file = |path: &Path, _: &_, _| Err(RequestError::Usage(format!("no file {}", path.display())));
//! let task = request.task(name, &file, true, no_file)?;
//! let planned = task.run(&file, Duration::ZERO, &Progress::new());
//! let input = InputJson::of(name, Some(&bytes));
//! let json = serde_json::to_value(PlanJson::of(&planned, &request, &input, &file, None))?;
//! assert_eq!(json["outcome"], "planned");
//! assert_eq!(json["options"]["bound"], 1e-3);
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```

mod answers;
mod error;
mod families;
mod hints;
mod options;
mod order;
mod plan;
mod suggestion;
mod table;
mod values;

pub use answers::{
    CauseJson, CheckJson, EdgeInfo, EdgesInfo, FiguresJson, InputJson, LoadsJson, PatternInfo,
    PlanJson, ToleranceJson, UnfoldJson,
};
pub use error::RequestError;
pub use families::{FAMILIES, FamilyInfo, generate};
pub use hints::radians_hint;
pub use options::{
    CheckRequest, ExportRequest, PlanRequest, ReadingRequest, UnfoldRequest, timeout,
};
pub use order::Order;
pub use plan::{NamedGoals, PlanTask, Planned};
pub use suggestion::{Suggestion, two_digits_above};
pub use table::{Kind, OptionInfo, Request, paragraphs};
pub use values::{EdgeAngles, Frames, Switch};
