//! Plans.

use core::time::Duration;
use std::sync::Arc;
use std::time::Instant;

use foldpath::request::{PlanJson, PlanRequest, Planned, ReadingRequest};
use foldpath_cli::embed::task;
use pyo3::prelude::*;

use crate::path::Path;
use crate::refusal::{error, usage};
use crate::sheet::{Read, Sheet, request};
use crate::waiting::{Threads, waiting};

/// The answer to a request.
#[pyclass(frozen, module = "foldpath._foldpath")]
pub(crate) struct Answer {
    read: Arc<Read>,
    request: PlanRequest,
    planned: Planned,
    total: Duration,
}

#[pymethods]
impl Answer {
    /// Name of the outcome.
    #[getter]
    fn outcome(&self) -> &'static str {
        self.planned.plan.outcome.name()
    }

    /// Reason why the outcome is not `planned`.
    #[getter]
    fn reason(&self) -> Option<String> {
        self.planned.plan.reason.as_ref().map(ToString::to_string)
    }

    /// The motion, if one was found.
    fn path(&self) -> Option<Path> {
        let motion = self.planned.plan.motion.clone()?;
        Some(Path::new(motion, self.read.name.clone()))
    }

    /// The JSON of `foldpath plan`.
    fn json(&self) -> String {
        let input = self.read.input();
        let times = Some([self.read.time, Duration::ZERO, self.total]);
        let json = PlanJson::of(&self.planned, &self.request, input, &self.read.file, times);
        serde_json::to_string(&json).unwrap_or_default()
    }
}

/// Plans. `options` is a JSON object of options by their names. Their `timeout` holds for reading the sheet as well if
/// `reads` is `true`.
#[pyfunction]
pub(crate) fn plan(
    py: Python<'_>,
    sheet: &Sheet,
    options: &str,
    reads: bool,
    jobs: Option<usize>,
    is_forked: bool,
) -> PyResult<Answer> {
    let start = Instant::now();
    let read = Arc::clone(&sheet.read);
    let mut request: PlanRequest = request(py, options)?;
    if request.reading != ReadingRequest::default() {
        let text = "--tolerance, --straighten, --colors, --layers and --dashes: expected when the pattern is read";
        return Err(usage(py, text.into()));
    }
    request.reading = read.reading.clone();
    let task = task(&request, &read.name, &read.file).map_err(|refused| error(py, refused))?;
    let spent = if reads { read.time } else { Duration::ZERO };
    let shared = Arc::clone(&read);
    let planned = waiting(py, Threads::of(jobs, is_forked), move |progress| {
        task.run(&shared.file, spent, progress)
    })?;
    Ok(Answer {
        total: read.time + start.elapsed(),
        read,
        request,
        planned,
    })
}
