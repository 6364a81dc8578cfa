//! A crease pattern that was read.

use core::iter::once;
use core::time::Duration;
use std::path::PathBuf;
use std::sync::{Arc, OnceLock};
use std::time::Instant;

use foldpath::folding::FoldingMap;
use foldpath::pattern::{CreasePattern, Unit};
use foldpath::progress::Watch;
use foldpath::read::fold::PatternFile;
use foldpath::request::{InputJson, PatternInfo, ReadingRequest, Request, UnfoldRequest, timeout};
use foldpath::sensitivity::Conditions;
use foldpath::symmetry::ReducedStars;
use foldpath_cli::embed::{CliError, Source, unfolded};
use foldpath_core::{HalfAngle, closure, hole};
use pyo3::prelude::*;
use pyo3::types::{PyByteArray, PyBytes};

use crate::arrays::{from_bytes, indices, numbers};
use crate::derivatives::{Asked, Two};
use crate::refusal::{error, usage};
use crate::waiting::{Threads, waiting};

/// A crease pattern that was read, with the bytes from which it was.
pub(crate) struct Read {
    pub(crate) name: PathBuf,
    bytes: Vec<u8>,
    pub(crate) reading: ReadingRequest,
    pub(crate) file: PatternFile,
    /// Time that reading took.
    pub(crate) time: Duration,
    input: OnceLock<InputJson>,
    stars: OnceLock<ReducedStars>,
}

impl Read {
    fn of(source: &Source, reading: ReadingRequest) -> Result<Self, CliError> {
        let start = Instant::now();
        let bytes = source.bytes()?.into_owned();
        let file = source.pattern(&bytes, &reading.options()?)?;
        Ok(Self {
            name: source.name.clone(),
            bytes,
            reading,
            file,
            time: start.elapsed(),
            input: OnceLock::new(),
            stars: OnceLock::new(),
        })
    }

    /// Returns name and digest of the file.
    pub(crate) fn input(&self) -> &InputJson {
        self.input
            .get_or_init(|| InputJson::of(&self.name, Some(&self.bytes)))
    }

    fn pattern(&self) -> &CreasePattern {
        &self.file.pattern
    }

    /// Returns stars and loops with every crease as an unknown.
    fn stars(&self) -> &ReducedStars {
        self.stars
            .get_or_init(|| ReducedStars::of_creases(self.pattern()))
    }
}

/// A crease pattern.
#[pyclass(frozen, module = "foldpath._foldpath")]
pub(crate) struct Sheet {
    pub(crate) read: Arc<Read>,
}

/// Residuals and the rows of a Jacobian: values, columns, ends of rows.
type ClosureBytes<'py> = [Bound<'py, PyByteArray>; 4];

#[pymethods]
impl Sheet {
    /// Reads a file. `options` is a JSON object.
    #[staticmethod]
    fn read(py: Python<'_>, path: PathBuf, options: &str) -> PyResult<Self> {
        let reading = request(py, options)?;
        Self::of(py, reading, move || Ok(Source::of_file(&path)))
    }

    /// Reads the bytes of a file whose format their content says.
    #[staticmethod]
    fn parse(py: Python<'_>, name: String, bytes: Vec<u8>, options: &str) -> PyResult<Self> {
        let reading = request(py, options)?;
        Self::of(py, reading, move || Source::of_stream(&name, &bytes))
    }

    /// Makes a pattern of a family, which is a JSON object.
    #[staticmethod]
    fn generate(py: Python<'_>, family: &str) -> PyResult<Self> {
        let object = serde_json::from_str(family).map_err(|error| usage(py, error.to_string()))?;
        Self::of(py, ReadingRequest::default(), move || {
            Source::of_family(&object)
        })
    }

    /// The title of the file, or else its name.
    #[getter]
    fn title(&self) -> &str {
        &self.read.file.title
    }

    /// The name of the file.
    #[getter]
    fn file(&self) -> String {
        self.read.name.display().to_string()
    }

    /// The unit of lengths, as FOLD names it; `None` if the file tells none.
    #[getter]
    fn unit(&self) -> Option<&'static str> {
        self.read.pattern().unit().map(Unit::name)
    }

    /// Repairs and assumptions made while reading, in sentences.
    #[getter]
    fn notes(&self) -> Vec<String> {
        let pattern = self.read.pattern();
        [pattern.repairs(), pattern.assumptions()].concat()
    }

    /// Positions of the vertices: (V, 2) numbers.
    fn vertices<'py>(&self, py: Python<'py>) -> Bound<'py, PyByteArray> {
        let vertices = self.read.pattern().vertices().iter();
        numbers(py, vertices.flat_map(|vertex| [vertex.x, vertex.y]))
    }

    /// Vertices of the edges: (E, 2) integers.
    fn edges<'py>(&self, py: Python<'py>) -> Bound<'py, PyByteArray> {
        edges(py, self.read.pattern())
    }

    /// Vertices of the faces, counter-clockwise.
    fn faces(&self) -> Vec<Vec<usize>> {
        faces(self.read.pattern())
    }

    /// FOLD's letter of each edge.
    #[getter]
    fn letters(&self) -> String {
        let edges = self.read.pattern().edges().iter();
        edges.map(|edge| edge.letter.code()).collect()
    }

    /// Goal angle of each edge, radians: (E) numbers, nan where there is none.
    fn goal<'py>(&self, py: Python<'py>) -> Bound<'py, PyByteArray> {
        let edges = self.read.pattern().edges().iter();
        numbers(
            py,
            edges.map(|edge| edge.crease.and(edge.goal).unwrap_or(f64::NAN)),
        )
    }

    /// Numbers of the edges that are hinges.
    fn hinges<'py>(&self, py: Python<'py>) -> Bound<'py, PyByteArray> {
        let creases = self.read.pattern().creases().iter();
        indices(py, creases.map(|edge| edge.index()))
    }

    /// Vertices whose conditions `closure` returns first, in their order.
    fn closure_vertices<'py>(&self, py: Python<'py>) -> Bound<'py, PyByteArray> {
        let vertices = self.read.stars().vertices().iter();
        indices(py, vertices.map(|vertex| vertex.index()))
    }

    /// Residuals at fold angles (radians, one for each edge), and their derivatives in compressed rows: by the angle of each
    /// edge, or by the coordinates of each vertex.
    fn closure<'py>(
        &self,
        py: Python<'py>,
        angles: &[u8],
        by_vertices: bool,
    ) -> PyResult<ClosureBytes<'py>> {
        let pattern = self.read.pattern();
        let x = self.of_creases(py, angles)?;
        let rows = py
            .detach(|| {
                let rows = jacobian(pattern, self.read.stars(), &x)?;
                if by_vertices {
                    rows.by_vertices(pattern, &x)
                } else {
                    Some(rows)
                }
            })
            .ok_or_else(|| usage(py, "a defect of foldpath: a hinge is missing".into()))?;
        Ok([
            numbers(py, rows.residuals),
            numbers(py, rows.values),
            indices(py, rows.columns),
            indices(py, rows.ends),
        ])
    }

    /// Fold angles near these (radians, one for each edge), at which the sheet closes and each driver, an edge, has its angle.
    fn driven<'py>(
        &self,
        py: Python<'py>,
        angles: &[u8],
        drivers: Vec<usize>,
        driven: &[u8],
    ) -> PyResult<Bound<'py, PyByteArray>> {
        self.asked(py, angles, drivers)?.driven(py, driven)
    }

    /// Positions of the folded vertices at fold angles: (V, 3) numbers.
    fn folded<'py>(&self, py: Python<'py>, angles: &[u8]) -> PyResult<Bound<'py, PyByteArray>> {
        let pattern = self.read.pattern();
        let x = self.of_creases(py, angles)?;
        let map = py.detach(|| FoldingMap::new(pattern, pattern.tree(), &x));
        let places = map.vertices().iter();
        Ok(numbers(py, places.flat_map(|at| [at.x, at.y, at.z])))
    }

    /// Rates at fold angles; see [`Asked::jvp`].
    fn jvp<'py>(
        &self,
        py: Python<'py>,
        angles: &[u8],
        drivers: Vec<usize>,
        vertices: &[u8],
        driven: &[u8],
    ) -> PyResult<Two<'py>> {
        self.asked(py, angles, drivers)?.jvp(py, vertices, driven)
    }

    /// Gradient at fold angles; see [`Asked::vjp`].
    fn vjp<'py>(
        &self,
        py: Python<'py>,
        angles: &[u8],
        drivers: Vec<usize>,
        by_angles: &[u8],
        by_vertices: &[u8],
    ) -> PyResult<Two<'py>> {
        self.asked(py, angles, drivers)?
            .vjp(py, by_angles, by_vertices)
    }

    /// The JSON of `foldpath info`.
    #[pyo3(signature = (seconds=None))]
    fn info(&self, py: Python<'_>, seconds: Option<f64>) -> PyResult<String> {
        let timeout = timeout(seconds).map_err(|refused| error(py, refused))?;
        let read = Arc::clone(&self.read);
        let text = waiting(py, Threads::Some(1), move |progress| {
            let deadline = timeout.and_then(|time| Instant::now().checked_add(time));
            let watch = Watch::new(progress).until(deadline);
            let mut info = PatternInfo::of(read.pattern(), watch);
            let source = Source::of_stream(&read.name.to_string_lossy(), &read.bytes);
            let motion = source.ok().and_then(|source| source.motion_of_sheet());
            motion.iter().for_each(|motion| info.moved_by(motion));
            serde_json::to_string(&info).unwrap_or_default()
        })?;
        Ok(text)
    }

    /// Name, bytes and options of reading, which make the same pattern again.
    fn source<'py>(&self, py: Python<'py>) -> (String, Bound<'py, PyBytes>, String) {
        let Read {
            name,
            bytes,
            reading,
            ..
        } = &*self.read;
        let options = serde_json::to_string(reading).unwrap_or_default();
        (name.display().to_string(), PyBytes::new(py, bytes), options)
    }
}

impl Sheet {
    /// Returns the fold angle of each crease of those of the edges.
    fn of_creases(&self, py: Python<'_>, angles: &[u8]) -> PyResult<Vec<f64>> {
        let pattern = self.read.pattern();
        let angles: Vec<f64> = from_bytes(angles).collect();
        if angles.len() != pattern.edges().len() {
            let text = format!(
                "angles: expected one for each of {} edges, found {}",
                pattern.edges().len(),
                angles.len()
            );
            return Err(usage(py, text));
        }
        let creases = pattern.creases().iter();
        let found = creases.map(|edge| {
            let angle = angles[edge.index()];
            let text = || format!("angles: expected a number for hinge {edge}, found {angle}");
            angle.is_finite().then_some(angle).ok_or_else(text)
        });
        let found: Result<_, String> = found.collect();
        found.map_err(|text| usage(py, text))
    }

    /// The configuration whose derivatives are asked for.
    fn asked(&self, py: Python<'_>, angles: &[u8], drivers: Vec<usize>) -> PyResult<Asked<'_>> {
        Ok(Asked {
            pattern: self.read.pattern(),
            angles: self.of_creases(py, angles)?,
            drivers: Some(drivers),
            place: String::new(),
        })
    }

    fn of(
        py: Python<'_>,
        reading: ReadingRequest,
        source: impl FnOnce() -> Result<Source, CliError> + Send,
    ) -> PyResult<Self> {
        let read = py.detach(|| Read::of(&source()?, reading));
        let read = read.map_err(|refused| error(py, refused))?;
        Ok(Self {
            read: Arc::new(read),
        })
    }
}

/// Unfolds a shape, a file or with `bytes` its content. Returns the JSON of `foldpath unfold`, notes, and the pattern if there
/// is one. `options` is a JSON object.
#[pyfunction]
pub(crate) fn unfold(
    py: Python<'_>,
    name: PathBuf,
    bytes: Option<Vec<u8>>,
    options: &str,
) -> PyResult<(String, Vec<String>, Option<Sheet>)> {
    let options: UnfoldRequest = request(py, options)?;
    let shape = name.clone();
    let found = waiting(py, Threads::Some(1), move |_| {
        let source = match bytes {
            Some(bytes) => Source::of_stream(&shape.to_string_lossy(), &bytes)?,
            None => Source::of_file(&shape),
        };
        unfolded(&source, &options)
    })?;
    let found = found.map_err(|refused| error(py, refused))?;
    let json = serde_json::to_string(&found.json).unwrap_or_default();
    let sheet = match found.pattern {
        None => None,
        Some(text) => Some(Sheet::parse(py, name.display().to_string(), text, "{}")?),
    };
    Ok((json, found.notes, sheet))
}

/// Returns the options of a JSON object.
pub(crate) fn request<R: Request>(py: Python<'_>, options: &str) -> PyResult<R> {
    let given = serde_json::from_str(options).map_err(|error| usage(py, error.to_string()))?;
    R::of(&given).map_err(|refused| error(py, refused))
}

/// Returns the vertices of the edges: (E, 2) integers.
pub(crate) fn edges<'py>(py: Python<'py>, pattern: &CreasePattern) -> Bound<'py, PyByteArray> {
    let edges = pattern.edges().iter();
    indices(
        py,
        edges.flat_map(|edge| edge.ends.map(|vertex| vertex.index())),
    )
}

/// Returns the vertices of the faces, counter-clockwise.
pub(crate) fn faces(pattern: &CreasePattern) -> Vec<Vec<usize>> {
    let faces = pattern.faces().iter();
    let faces = faces.map(|face| face.iter().map(|vertex| vertex.index()).collect());
    faces.collect()
}

/// Residuals, and their derivatives in compressed rows.
struct Rows {
    residuals: Vec<f64>,
    values: Vec<f64>,
    columns: Vec<usize>,
    /// Number of values before each row, and of all values.
    ends: Vec<usize>,
}

impl Rows {
    /// Returns the residuals with their derivatives by the coordinates of the vertices.
    fn by_vertices(self, pattern: &CreasePattern, x: &[f64]) -> Option<Self> {
        let mut rows = Self {
            residuals: Vec::new(),
            values: Vec::new(),
            columns: Vec::new(),
            ends: once(0).collect(),
        };
        let by_vertices = Conditions::new(pattern)?.by_vertices(x)?;
        for (residual, entries) in self
            .residuals
            .as_chunks::<3>()
            .0
            .iter()
            .zip(by_vertices.iter())
        {
            let columns: Vec<[f64; 3]> =
                entries.iter().map(|(_, column)| (*column).into()).collect();
            let coordinates = entries.iter().map(|(coordinate, _)| *coordinate as usize);
            rows.push(*residual, coordinates.zip(&columns));
        }
        Some(rows)
    }

    /// Adds the three rows of a residual, with the derivative by each of its edges.
    fn push<'a>(
        &mut self,
        residual: [f64; 3],
        derivatives: impl Iterator<Item = (usize, &'a [f64; 3])> + Clone,
    ) {
        self.residuals.extend(residual);
        for row in 0..3 {
            for (edge, derivative) in derivatives.clone() {
                self.columns.push(edge);
                self.values.push(derivative[row]);
            }
            self.ends.push(self.values.len());
        }
    }
}

/// Returns the residuals of all stars, and two for each loop, at the angles of the creases (radians), with their derivatives
/// by the angles of the edges.
fn jacobian(pattern: &CreasePattern, stars: &ReducedStars, x: &[f64]) -> Option<Rows> {
    let mut half_angles = vec![HalfAngle::default(); x.len()];
    closure::half_angles(x, &mut half_angles);
    let edge = |crease: usize| pattern.creases()[crease].index();
    let mut rows = Rows {
        residuals: Vec::new(),
        values: Vec::new(),
        columns: Vec::new(),
        ends: once(0).collect(),
    };
    let mut columns = Vec::new();
    for star in stars.view().iter() {
        columns.clear();
        columns.resize_with(star.spokes.len(), Default::default);
        let residual = closure::residual_and_jacobian(star, &half_angles, &mut columns)?;
        let derivatives: Vec<[f64; 3]> = columns.iter().map(|&column| column.into()).collect();
        let edges = star.spokes.iter().map(|spoke| edge(spoke.group.index()));
        rows.push(residual.into(), edges.zip(&derivatives));
    }
    for cycle in stars.loops().iter() {
        columns.clear();
        columns.resize_with(2 * cycle.spokes.len(), Default::default);
        let residuals = hole::residuals_and_jacobian(cycle, &half_angles, &mut columns)?;
        let derivatives: Vec<[f64; 3]> = columns.iter().map(|&column| column.into()).collect();
        let parts = derivatives.chunks(cycle.spokes.len().max(1));
        for (residual, derivatives) in residuals.into_iter().zip(parts) {
            let edges = cycle.spokes.iter().map(|spoke| edge(spoke.group.index()));
            rows.push(residual.into(), edges.zip(derivatives));
        }
    }
    Some(rows)
}
