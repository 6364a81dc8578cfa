//! Motions, and judging them.

use std::ffi::OsString;
use std::path::PathBuf;
use std::sync::Arc;
use std::time::Instant;

use foldpath::check::check_watched;
use foldpath::export::fold::motion_text;
use foldpath::folding::FoldingMap;
use foldpath::motion::Motion;
use foldpath::pattern::{EdgeId, FaceId, Unit};
use foldpath::plot::{Curves, svg};
use foldpath::progress::Watch;
use foldpath::read::check_unit;
use foldpath::request::{CheckJson, CheckRequest, LoadsJson, Request, ToleranceJson, timeout};
use foldpath::sensitivity::{Drive, Load, Loads, Tolerance};
use foldpath::view::{Scene, page};
use foldpath_cli::embed::{Source, export_motion, write_file, write_path};
use pyo3::prelude::*;
use pyo3::types::PyByteArray;

use crate::arrays::{from_bytes, numbers};
use crate::derivatives::{Asked, Two};
use crate::refusal::{error, usage};
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

    /// Returns the fold angle of each edge, or its rate, of those of the groups; nan for edges that are no hinge.
    fn of_edges<'a>(&'a self, groups: &'a [f64]) -> impl Iterator<Item = f64> + 'a {
        self.motion.members.iter().map(|member| {
            // The sum turns -0 into 0.
            member.map_or(f64::NAN, |member| {
                member.apply(groups[member.group.index()]) + 0.0
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
        numbers(py, knots.flat_map(|knot| self.of_edges(&knot.angles)))
    }

    /// Fold angles of the edges at times (seconds), radians: (T, E) numbers.
    fn at<'py>(&self, py: Python<'py>, times: &[u8]) -> Bound<'py, PyByteArray> {
        let configurations = from_bytes(times).map(|time| self.motion.at(time));
        let angles =
            configurations.flat_map(|knot| self.of_edges(&knot.angles).collect::<Vec<f64>>());
        let angles: Vec<f64> = py.detach(|| angles.collect());
        numbers(py, angles)
    }

    /// Rates of the edges at times (seconds), radians per second: (T, E) numbers.
    fn rates<'py>(&self, py: Python<'py>, times: &[u8]) -> Bound<'py, PyByteArray> {
        let rates = from_bytes(times).map(|time| self.motion.rates(time));
        let rates = rates.flat_map(|rates| self.of_edges(&rates).collect::<Vec<f64>>());
        let rates: Vec<f64> = py.detach(|| rates.collect());
        numbers(py, rates)
    }

    /// Crease group of each edge, and its sign, 1 or -1: (2, E) numbers, nan for edges that are no hinge.
    fn groups<'py>(&self, py: Python<'py>) -> Bound<'py, PyByteArray> {
        let members = || self.motion.members.iter();
        let groups = members().map(|member| member.map_or(f64::NAN, |it| f64::from(it.group.0)));
        let signs = members().map(|member| member.map_or(f64::NAN, |it| it.apply(1.0)));
        numbers(py, groups.chain(signs))
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

    /// The interactive page, with play if an error or a play is given, and with the torques of a load.
    fn page(
        &self,
        py: Python<'_>,
        error: Option<f64>,
        play: Option<f64>,
        load: Option<Loading>,
        is_forked: bool,
    ) -> PyResult<String> {
        let scale = match (error, play) {
            (None, None) => None,
            (error, play) => Some(Scale::of(py, error, play)?),
        };
        let (motion, load) = self.loaded(py, load)?;
        let made = waiting(py, Threads::of(None, is_forked), move |progress| {
            let watch = Watch::new(progress);
            let mut scene = Scene::of_path(&motion);
            if let Some(scale) = scale {
                let tolerance = Tolerance::of(&motion, watch).map_err(|no| no.to_string())?;
                scene = scene.with_tolerance(&motion, &tolerance, scale.error(&tolerance));
            }
            if let Some(load) = &load {
                let loads = Loads::least(&motion, load, watch).map_err(|no| no.to_string())?;
                scene = scene.with_torques(&motion, &loads);
            }
            Ok(page(&scene))
        })?;
        made.map_err(|text| self.refused(py, text))
    }

    /// A drawing of the curves of the motion, as SVG, with the torques of a load.
    fn plot(&self, py: Python<'_>, load: Option<Loading>, is_forked: bool) -> PyResult<String> {
        let (motion, load) = self.loaded(py, load)?;
        let made = waiting(py, Threads::of(None, is_forked), move |progress| {
            let mut curves = Curves::of_path_watched(&motion, progress);
            if let Some(load) = &load {
                let watch = Watch::new(progress);
                let loads = Loads::least(&motion, load, watch).map_err(|no| no.to_string())?;
                curves = curves.with_torques(&motion, &loads);
            }
            Ok(svg(&curves))
        })?;
        made.map_err(|text| self.refused(py, text))
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

    /// Edges of the hinges that drive the sheet at a time.
    fn drivers(&self, py: Python<'_>, time: f64) -> PyResult<Vec<usize>> {
        self.asked(py, time)?.driver_edges(py)
    }

    /// Rates at a time; see [`Asked::jvp`].
    fn jvp<'py>(
        &self,
        py: Python<'py>,
        time: f64,
        vertices: &[u8],
        drivers: &[u8],
    ) -> PyResult<Two<'py>> {
        self.asked(py, time)?.jvp(py, vertices, drivers)
    }

    /// Gradient at a time; see [`Asked::vjp`].
    fn vjp<'py>(
        &self,
        py: Python<'py>,
        time: f64,
        by_angles: &[u8],
        by_vertices: &[u8],
    ) -> PyResult<Two<'py>> {
        self.asked(py, time)?.vjp(py, by_angles, by_vertices)
    }

    /// The JSON of `foldpath tolerance`.
    fn tolerance(
        &self,
        py: Python<'_>,
        error: Option<f64>,
        play: Option<f64>,
        seconds: Option<f64>,
        jobs: Option<usize>,
        is_forked: bool,
    ) -> PyResult<String> {
        let scale = Scale::of(py, error, play)?;
        let deadline = deadline(py, seconds)?;
        let motion = Arc::clone(&self.motion);
        let found = waiting(py, Threads::of(jobs, is_forked), move |progress| {
            let watch = Watch::new(progress).until(deadline);
            let tolerance = Tolerance::of(&motion, watch).map_err(|no| no.to_string())?;
            let json = ToleranceJson::of(&motion, &tolerance, scale.error(&tolerance));
            Ok::<_, String>(serde_json::to_string(&json).unwrap_or_default())
        })?;
        found.map_err(|text| self.refused(py, text))
    }

    /// The JSON of `foldpath loads`.
    #[allow(
        clippy::too_many_arguments,
        reason = "the arguments of the call in Python"
    )]
    fn loads(
        &self,
        py: Python<'_>,
        load: Loading,
        drivers: Option<usize>,
        drives: Vec<(String, f64, f64)>,
        seconds: Option<f64>,
        jobs: Option<usize>,
        is_forked: bool,
    ) -> PyResult<String> {
        let drives = drives
            .into_iter()
            .map(|(name, stall_torque, degrees)| Drive {
                name,
                stall_torque,
                speed: degrees.to_radians(),
            });
        let drives: Vec<Drive> = drives.collect();
        if !drives
            .iter()
            .all(|drive| drive.stall_torque > 0.0 && drive.speed > 0.0)
        {
            return Err(usage(
                py,
                "drives: expected torques and speeds above 0".into(),
            ));
        }
        let (motion, load) = load.of(py, self)?;
        let deadline = deadline(py, seconds)?;
        let found = waiting(py, Threads::of(jobs, is_forked), move |progress| {
            let watch = Watch::new(progress).until(deadline);
            let loads = Loads::least_of(&motion, &load, drivers, watch);
            let loads = loads.map_err(|no| no.to_string())?;
            let json = LoadsJson::of(&motion, &loads, &drives);
            Ok::<_, String>(serde_json::to_string(&json).unwrap_or_default())
        })?;
        found.map_err(|text| self.refused(py, text))
    }
}

/// The load of a sheet, as `_load` in Python makes it.
#[derive(FromPyObject)]
#[pyo3(from_item_all)]
struct Loading {
    areal_density: f64,
    fixed: Option<u32>,
    gravity: [f64; 3],
    /// Stiffness of the spring in each hinge, and of those at single edges.
    spring: f64,
    springs: Vec<(u32, f64)>,
    unit: Option<String>,
}

impl Loading {
    /// Returns the load, and the motion in the unit that is named.
    fn of(self, py: Python<'_>, path: &Path) -> PyResult<(Motion, Load)> {
        let all = [
            ("areal_density", self.areal_density),
            ("spring", self.spring),
        ];
        let single = self
            .springs
            .iter()
            .map(|(_, stiffness)| ("spring", *stiffness));
        for (name, value) in all.into_iter().chain(single) {
            if !(value >= 0.0 && value.is_finite()) {
                let text = format!("{name}: expected a number from 0, found {value}");
                return Err(usage(py, text));
            }
        }
        if !self.gravity.iter().all(|part| part.is_finite()) {
            return Err(usage(py, "gravity: expected three finite numbers".into()));
        }
        let mut motion = Motion::clone(&path.motion);
        if let Some(name) = self.unit {
            let told = Unit::from_name(&name);
            let told = told.ok_or_else(|| usage(py, format!("unit: {name} is none")))?;
            check_unit(&path.name, motion.pattern.unit(), told)
                .map_err(|refused| error(py, refused))?;
            motion.measured_in(told);
        }
        let springs = self.springs.into_iter();
        let load = Load {
            areal_density: self.areal_density,
            fixed: self.fixed.map(FaceId),
            gravity: self.gravity.into(),
            spring: self.spring,
            springs: springs
                .map(|(edge, stiffness)| (EdgeId(edge), stiffness))
                .collect(),
        };
        Ok((motion, load))
    }
}

/// The error of a sheet, or the play that its hinges have.
#[derive(Clone, Copy)]
enum Scale {
    Error(f64),
    Play(f64),
}

impl Scale {
    fn of(py: Python<'_>, error: Option<f64>, play: Option<f64>) -> PyResult<Self> {
        let (name, value, scale) = match (error, play) {
            (Some(error), None) => ("error", error, Self::Error(error)),
            (None, Some(play)) => ("play", play, Self::Play(play)),
            _ => return Err(usage(py, "expected one of error and play".into())),
        };
        if value > 0.0 && value.is_finite() {
            return Ok(scale);
        }
        let text = format!("{name}: expected a number above 0, found {value}");
        Err(usage(py, text))
    }

    /// Returns the error that is named, or that a play allows; `None` if no error needs play.
    fn error(self, tolerance: &Tolerance) -> Option<f64> {
        match self {
            Self::Error(error) => Some(error),
            Self::Play(play) => tolerance.error_for(play),
        }
    }
}

impl Path {
    /// Returns a load, if one is given, and the motion that carries it.
    fn loaded(
        &self,
        py: Python<'_>,
        load: Option<Loading>,
    ) -> PyResult<(Arc<Motion>, Option<Load>)> {
        let Some(load) = load else {
            return Ok((Arc::clone(&self.motion), None));
        };
        let (motion, load) = load.of(py, self)?;
        Ok((Arc::new(motion), Some(load)))
    }

    /// Makes the error that a question has no answer.
    fn refused(&self, py: Python<'_>, text: String) -> PyErr {
        usage(py, format!("{}: {text}", self.name.display()))
    }

    /// The configuration at a time whose derivatives are asked for.
    fn asked(&self, py: Python<'_>, time: f64) -> PyResult<Asked<'_>> {
        if !time.is_finite() {
            let text = format!("t: expected a finite time, found {time}");
            return Err(usage(py, text));
        }
        Ok(Asked {
            pattern: &self.motion.pattern,
            angles: self.motion.at_times([time]).crease_angles(0),
            drivers: None,
            place: format!("at {time} s, "),
        })
    }
}

/// Returns the end of a time in seconds that begins now.
fn deadline(py: Python<'_>, seconds: Option<f64>) -> PyResult<Option<Instant>> {
    let timeout = timeout(seconds).map_err(|refused| error(py, refused))?;
    Ok(timeout.and_then(|time| Instant::now().checked_add(time)))
}

/// Reads a table of drives: name, stall torque (newton metres) and speed (degrees per second) of each.
#[pyfunction]
pub(crate) fn read_drives(py: Python<'_>, path: PathBuf) -> PyResult<Vec<(String, f64, f64)>> {
    let drives = Source::of_file(&path).drives();
    let drives = drives.map_err(|refused| error(py, refused))?.into_iter();
    Ok(drives
        .map(|drive| (drive.name, drive.stall_torque, drive.speed.to_degrees()))
        .collect())
}

/// Writes a text, whole or not at all.
#[pyfunction]
pub(crate) fn write_text(py: Python<'_>, path: PathBuf, text: &str) -> PyResult<()> {
    py.detach(|| write_file(&path, text.as_bytes()))
        .map_err(|refused| error(py, refused))
}
