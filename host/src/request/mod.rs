//! Requests by name, and answers as JSON: what the command line, the Python package and a page in a browser share.
//!
//! A [`PlanRequest`] has the options of a plan by the names and in the units of the command line: degrees and seconds. It
//! becomes a [`PlanTask`] for a pattern that was read, and its answer a [`PlanJson`]. Requests to judge and to describe
//! are [`CheckRequest`] and [`PatternInfo`]. No file is read or written here: callers read patterns, and
//! [`PlanRequest::task`] asks its caller for the goals that a request names.
//!
//! ```
//! use std::path::Path;
//!
//! use foldpath::export::fold::write_pattern;
//! use foldpath::progress::Progress;
//! use foldpath::read::parse_pattern;
//! use foldpath::request::{Family, InputJson, PlanRequest, Request, RequestError};
//!
//! let family = Family::of(&serde_json::from_str(r#"{"family": "miura", "rows": 3, "cols": 3}"#)?)?;
//! let mut bytes = Vec::new();
//! write_pattern(&family.title(), &family.drawing()?, &mut bytes)?;
//! let name = Path::new("miura.fold");
//! let file = parse_pattern(name, &bytes)?;
//!
//! let mut request = PlanRequest::default();
//! request.set("bound", &1e-3.into())?;
//! request.set("symmetry", &"off".into())?;
//! let no_file = |path: &Path, _: &_| Err(RequestError::Usage(format!("no file {}", path.display())));
//! let task = request.task(name, &file, true, no_file)?;
//! let planned = task.run(&file, &Progress::new());
//! let input = InputJson::of(name, &bytes);
//! let json = serde_json::to_value(planned.json(&request, &input, &file))?;
//! assert_eq!(json["outcome"], "planned");
//! assert_eq!(json["options"]["bound"], 1e-3);
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```

mod check;
mod error;
mod families;
mod goal;
mod hints;
mod info;
mod names;
mod options;
mod plan;
mod plan_json;
mod table;
mod values;

pub use check::CheckJson;
pub use error::RequestError;
pub use families::{FAMILIES, Family, FamilyInfo};
pub use hints::radians_hint;
pub use info::{CauseJson, PatternInfo, PatternInfoJson, Room};
pub use names::{Frames, Switch};
pub use options::{CheckRequest, ExportRequest, PlanRequest, ReadingRequest, timeout};
pub use plan::{PlanTask, Planned};
pub use plan_json::{InputJson, PlanJson};
pub use table::{Kind, OptionInfo, OptionValue, Request, Row, Shape, paragraphs};
pub use values::{DrivenEdge, LimitedEdge};
