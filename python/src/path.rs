//! Motions, and judging them.

use std::ffi::OsString;
use std::path::PathBuf;
use std::sync::Arc;

use foldpath::check::check_watched;
use foldpath::export::fold::motion_text;
use foldpath::folding::FoldingMap;
use foldpath::motion::{Knot, Motion};
use foldpath::plot::{Curves, svg};
use foldpath::request::{CheckJson, CheckRequest, Request};
use foldpath::view::{Scene, page};
use foldpath_cli::embed::{Source, export_motion, write_file, write_path};
use pyo3::prelude::*;
use pyo3::types::PyByteArray;

use crate::arrays::{from_bytes, numbers};
use crate::refusal::error;
use crate::sheet::{edges, faces, request};
use crate::waiting::{Threads, waiting};

/// A motion.
#[pyclass(frozen, module = "foldpath._foldpath")]
pub(crate) struct Path {
    motion: Arc<Motion>,
    /// Name of its file, or of its pattern's, for messages.
    name: PathBuf,
}

impl Path {
    pub(crate) fn new(motion: Motion, name: PathBuf) -> Self {
        Self {
            motion: Arc::new(motion),
            name,
        }
    }

    fn of(py: Python<'_>, source: &Source) -> PyResult<Self> {
        let motion = py.detach(|| source.motion());
        let motion = motion.map_err(|refused| error(py, refused))?;
        Ok(Self::new(motion, source.name.clone()))
    }

    /// Returns the fold angle of each edge in a configuration, radians; nan for edges that are no hinge.
    fn angles<'a>(&'a self, knot: &'a Knot) -> impl Iterator<Item = f64> + 'a {
        self.motion.members.iter().map(|member| {
            // The sum turns -0 into 0.
            member.map_or(f64::NAN, |member| {
                member.apply(knot.angles[member.group.index()]) + 0.0
            })
        })
    }
}

#[pymethods]
impl Path {
    /// Reads a file.
    #[staticmethod]
    fn read(py: Python<'_>, path: PathBuf) -> PyResult<Self> {
        Self::of(py, &Source::of_file(&path))
    }

    /// Reads the bytes of a file.
    #[staticmethod]
    fn parse(py: Python<'_>, name: &str, bytes: &[u8]) -> PyResult<Self> {
        let source = Source::of_stream(name, bytes).map_err(|refused| error(py, refused))?;
        Self::of(py, &source)
    }

    /// The title.
    #[getter]
    fn title(&self) -> &str {
        &self.motion.title
    }

    /// The name of the file in messages.
    #[getter]
    fn file(&self) -> String {
        self.name.display().to_string()
    }

    /// Number of knots.
    #[getter]
    fn knots(&self) -> usize {
        self.motion.knots.len()
    }

    /// Number of edges.
    #[getter]
    fn edge_count(&self) -> usize {
        self.motion.members.len()
    }

    /// Number of vertices.
    #[getter]
    fn vertex_count(&self) -> usize {
        self.motion.pattern.vertices().len()
    }

    /// Vertices of the edges: (E, 2) integers.
    fn edges<'py>(&self, py: Python<'py>) -> Bound<'py, PyByteArray> {
        edges(py, &self.motion.pattern)
    }

    /// Vertices of the faces, counter-clockwise.
    fn faces(&self) -> Vec<Vec<usize>> {
        faces(&self.motion.pattern)
    }

    /// Times of the knots, seconds.
    fn times<'py>(&self, py: Python<'py>) -> Bound<'py, PyByteArray> {
        numbers(py, self.motion.knots.iter().map(|knot| knot.time))
    }

    /// Fold angles of the edges at the knots, radians: (K, E) numbers.
    fn fold_angles<'py>(&self, py: Python<'py>) -> Bound<'py, PyByteArray> {
        let knots = self.motion.knots.iter();
        numbers(py, knots.flat_map(|knot| self.angles(knot)))
    }

    /// Fold angles of the edges at times (seconds), radians: (T, E) numbers.
    fn at<'py>(&self, py: Python<'py>, times: &[u8]) -> Bound<'py, PyByteArray> {
        let configurations = from_bytes(times).map(|time| self.motion.at(time));
        let angles = configurations.flat_map(|knot| self.angles(&knot).collect::<Vec<f64>>());
        let angles: Vec<f64> = py.detach(|| angles.collect());
        numbers(py, angles)
    }

    /// Positions of the vertices at times (seconds): (T, V, 3) numbers.
    fn vertices<'py>(&self, py: Python<'py>, times: &[u8]) -> Bound<'py, PyByteArray> {
        let motion = &self.motion;
        let tree = motion.pattern.tree();
        let members = motion.memberships();
        let mut map = FoldingMap::flat(&motion.pattern);
        let shapes = from_bytes(times).flat_map(|time| {
            let angles = motion.at(time).angles;
            map.fold_groups(&motion.pattern, tree, &members, &angles);
            let vertices = map.vertices().iter();
            vertices
                .flat_map(|vertex| [vertex.x, vertex.y, vertex.z])
                .collect::<Vec<f64>>()
        });
        let shapes: Vec<f64> = py.detach(|| shapes.collect());
        numbers(py, shapes)
    }

    /// Writes the path file.
    fn save(&self, py: Python<'_>, path: PathBuf) -> PyResult<()> {
        py.detach(|| write_path(&self.motion, &path))
            .map_err(|refused| error(py, refused))
    }

    /// The text of the path file.
    fn text(&self, py: Python<'_>) -> String {
        py.detach(|| motion_text(&self.motion))
    }

    /// The interactive page.
    fn page(&self, py: Python<'_>) -> String {
        py.detach(|| page(&Scene::of_path(&self.motion)))
    }

    /// A drawing of the curves of the motion, as SVG.
    fn plot(&self, py: Python<'_>) -> PyResult<String> {
        let motion = Arc::clone(&self.motion);
        waiting(py, Threads::Some(1), move |progress| {
            svg(&Curves::of_path_watched(&motion, progress))
        })
    }

    /// Exports the motion. `arguments` are those of `foldpath export`.
    fn export(&self, py: Python<'_>, arguments: Vec<OsString>) -> PyResult<()> {
        py.detach(|| export_motion(&self.motion, &self.name, &arguments))
            .map_err(|refused| error(py, refused))
    }

    /// Judges the motion and returns the JSON of `foldpath check`. `options` is a JSON object of options by their names.
    fn check(
        &self,
        py: Python<'_>,
        options: &str,
        jobs: Option<usize>,
        is_forked: bool,
    ) -> PyResult<String> {
        let request: CheckRequest = request(py, options)?;
        let options = request.options().map_err(|refused| error(py, refused))?;
        let motion = Arc::clone(&self.motion);
        waiting(py, Threads::of(jobs, is_forked), move |progress| {
            let verdict = check_watched(&motion, &options, progress);
            serde_json::to_string(&CheckJson::of(&motion, &verdict)).unwrap_or_default()
        })
    }
}

/// Writes a text, whole or not at all.
#[pyfunction]
pub(crate) fn write_text(py: Python<'_>, path: PathBuf, text: &str) -> PyResult<()> {
    py.detach(|| write_file(&path, text.as_bytes()))
        .map_err(|refused| error(py, refused))
}
