//! Derivatives of a folded sheet, as bytes.

use foldpath::pattern::{CreaseId, CreasePattern};
use foldpath::sensitivity::{Conditions, NoDerivative, Sensitivity};
use foldpath::{Vector2, Vector3};
use pyo3::prelude::*;
use pyo3::types::PyByteArray;

use crate::arrays::{from_bytes, numbers};
use crate::refusal::usage;

/// Two arrays.
pub(crate) type Two<'py> = (Bound<'py, PyByteArray>, Bound<'py, PyByteArray>);

/// A configuration whose derivatives are asked for.
pub(crate) struct Asked<'a> {
    pub(crate) pattern: &'a CreasePattern,
    /// Fold angle of each crease, radians.
    pub(crate) angles: Vec<f64>,
    /// Edges of the drivers; `None` for those that are chosen.
    pub(crate) drivers: Option<Vec<usize>>,
    /// Beginning of errors, such as `at 1 s, `.
    pub(crate) place: String,
}

impl Asked<'_> {
    /// Does something with the derivatives at the closed configuration nearest to the angles. With `driven`, the drivers have
    /// these angles there.
    fn at<T: Send>(
        &self,
        py: Python<'_>,
        driven: Option<&[f64]>,
        work: impl FnOnce(&mut Sensitivity<'_>) -> Result<T, NoDerivative> + Send,
    ) -> PyResult<T> {
        let drivers: Option<Vec<CreaseId>> = match &self.drivers {
            None => None,
            Some(edges) => Some(creases(self.pattern, edges).map_err(|text| usage(py, text))?),
        };
        let done = py.detach(|| {
            let conditions = Conditions::new(self.pattern);
            let conditions = conditions.ok_or("the sheet has too many creases".to_string())?;
            let at = match (drivers, driven) {
                (Some(drivers), Some(angles)) => {
                    Sensitivity::driven(&conditions, &self.angles, &drivers, angles)
                }
                (Some(drivers), None) => {
                    Sensitivity::at(&conditions, &self.angles).and_then(|at| at.driven_by(&drivers))
                }
                (None, _) => Sensitivity::at(&conditions, &self.angles),
            };
            at.and_then(|mut at| work(&mut at))
                .map_err(|no| no.to_string())
        });
        done.map_err(|text| usage(py, format!("{}{text}", self.place)))
    }

    /// Returns the edges of the drivers.
    pub(crate) fn driver_edges(&self, py: Python<'_>) -> PyResult<Vec<usize>> {
        let drivers = self.at(py, None, |at| Ok(at.drivers().to_vec()))?;
        let creases = self.pattern.creases();
        let edges = drivers.iter().map(|driver| creases[driver.index()].index());
        Ok(edges.collect())
    }

    /// Returns the fold angles, (E,), at which the sheet closes and the drivers have their angles.
    pub(crate) fn driven<'py>(
        &self,
        py: Python<'py>,
        angles: &[u8],
    ) -> PyResult<Bound<'py, PyByteArray>> {
        let driven: Vec<f64> = from_bytes(angles).collect();
        let closed = self.at(py, Some(&driven), |at| Ok(at.angles().to_vec()))?;
        Ok(numbers(py, by_edges(self.pattern, &closed)))
    }

    /// Returns rates of fold angles, (N, E), and of the folded vertices, (N, V, 3), for changes of the flat vertices, (N, V, 2),
    /// and of the drivers, (N, D).
    pub(crate) fn jvp<'py>(
        &self,
        py: Python<'py>,
        vertices: &[u8],
        drivers: &[u8],
    ) -> PyResult<Two<'py>> {
        let coordinates: Vec<f64> = from_bytes(vertices).collect();
        let vertices = coordinates.chunks_exact(2);
        let vertices: Vec<_> = vertices.map(|at| Vector2::new(at[0], at[1])).collect();
        let drivers: Vec<f64> = from_bytes(drivers).collect();
        check_finite(py, "vertices", coordinates.iter().copied())?;
        check_finite(py, "drivers", drivers.iter().copied())?;
        let rates = self.at(py, None, |at| {
            let vertices = vertices.chunks_exact(self.pattern.vertices().len());
            // Without drivers there is one list of none for each change.
            let driven = (0..).map(|k| k * at.drivers().len()..(k + 1) * at.drivers().len());
            let driven: Vec<_> = driven.take(vertices.len()).collect();
            let changes = vertices.zip(driven);
            let rates = changes.map(|(vertices, driven)| at.jvp(vertices, &drivers[driven]));
            rates.collect::<Result<Vec<_>, _>>()
        })?;
        let angles = rates
            .iter()
            .flat_map(|it| by_edges(self.pattern, &it.angles));
        let places = rates.iter().flat_map(|it| &it.places);
        let places = places.flat_map(|rate| [rate.x, rate.y, rate.z]);
        Ok((numbers(py, angles), numbers(py, places)))
    }

    /// Returns the gradients by the flat vertices, (N, V, 2), and by the drivers, (N, D), of what has these gradients by fold
    /// angles, (N, E), and by folded vertices, (N, V, 3).
    pub(crate) fn vjp<'py>(
        &self,
        py: Python<'py>,
        by_angles: &[u8],
        by_vertices: &[u8],
    ) -> PyResult<Two<'py>> {
        let by_edges: Vec<f64> = from_bytes(by_angles).collect();
        let by_places: Vec<f64> = from_bytes(by_vertices).collect();
        let hinges = self
            .pattern
            .edges()
            .iter()
            .map(|edge| edge.crease.is_some());
        let by_hinges = by_edges.iter().zip(hinges.cycle());
        let by_hinges = by_hinges.filter(|(_, is_hinge)| *is_hinge);
        check_finite(py, "angles", by_hinges.map(|(by, _)| *by))?;
        check_finite(py, "vertices", by_places.iter().copied())?;
        let by_places = by_places.chunks_exact(3);
        let by_places: Vec<_> = by_places
            .map(|by| Vector3::new(by[0], by[1], by[2]))
            .collect();
        let gradients = self.at(py, None, |at| {
            let by_edges = by_edges.chunks_exact(self.pattern.edges().len());
            let by_places = by_places.chunks_exact(self.pattern.vertices().len());
            let both = by_edges.zip(by_places).map(|(by_edges, by_places)| {
                let creases = self.pattern.creases().iter();
                let by_creases: Vec<f64> = creases.map(|edge| by_edges[edge.index()]).collect();
                at.vjp(&by_creases, by_places)
            });
            Ok(both.collect::<Vec<_>>())
        })?;
        let vertices = gradients.iter().flat_map(|it| &it.vertices);
        let vertices = vertices.flat_map(|by| [by.x, by.y]);
        let drivers = gradients.iter().flat_map(|it| it.drivers.iter().copied());
        Ok((numbers(py, vertices), numbers(py, drivers)))
    }
}

/// Checks that all numbers of an argument are finite.
fn check_finite(
    py: Python<'_>,
    name: &str,
    mut numbers: impl Iterator<Item = f64>,
) -> PyResult<()> {
    match numbers.find(|number| !number.is_finite()) {
        None => Ok(()),
        Some(found) => {
            let text = format!("{name}: expected finite numbers, found {found}");
            Err(usage(py, text))
        }
    }
}

/// Returns the creases of edges.
fn creases(pattern: &CreasePattern, edges: &[usize]) -> Result<Vec<CreaseId>, String> {
    let all = pattern.edges();
    let found = edges.iter().map(|&edge| {
        let crease = all.get(edge).and_then(|edge| edge.crease);
        crease.ok_or_else(|| format!("drivers: expected numbers of hinges, found {edge}"))
    });
    found.collect()
}

/// Returns numbers of creases as those of edges, nan for edges that are no hinge.
fn by_edges(pattern: &CreasePattern, of_creases: &[f64]) -> Vec<f64> {
    let edges = pattern.edges().iter();
    let of_edge = edges.map(|edge| edge.crease.map(|crease| of_creases[crease.index()]));
    of_edge.map(|number| number.unwrap_or(f64::NAN)).collect()
}
