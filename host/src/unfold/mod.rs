//! Unfolds a folded shape to its crease pattern.
//!
//! Implements Algorithm 1 of [XiLien2015](crate#references) (section 6): faces are laid into the plane one after the
//! other, each across an edge of a face that already lies there. Differs from the source in three ways. All faces are
//! first turned to the same side of the paper: then of the two ways to attach a face the one beyond the edge is right,
//! and nothing has to be tried. Faces may be polygons. A surface is cut if it has no boundary, or if it is a ring that
//! no plane can hold.
//!
//! This module knows no file format and does no planning: [`unfold`] takes a [`FoldedShape`] and returns a [`Drawing`]
//! whose goal is that shape.

mod angles;
mod cuts;
mod layout;
mod shape;
mod surface;

use nalgebra::Vector3;

use crate::folding::{FoldingMap, align_sheets};
use crate::pattern::{CreasePattern, Digits, Drawing, PatternError, Precision};
use crate::progress::{Progress, Watch};
use crate::symmetry::closure_of;
use angles::Creases;
use layout::Layout;
pub use shape::{FoldedShape, ShapeEdge, ShapeError};
use surface::Surface;

/// Options of unfolding.
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub struct UnfoldOptions {
    /// Largest angle defect (radians) of an interior vertex that counts as developable, and largest slope of a corner
    /// out of the plane of its face.
    ///
    /// The default, 0.01 degrees, covers the rounding of coordinates with six digits on a sheet about ten edges across;
    /// a shape that was folded from paper by computation has defects of about 1e-13.
    pub max_defect: f64,
    /// Largest number of ways to cut a closed shape that are tried until one gives no overlap.
    pub attempts: usize,
}

impl Default for UnfoldOptions {
    fn default() -> Self {
        Self {
            max_defect: 0.01_f64.to_radians(),
            attempts: 64,
        }
    }
}

crate::util::changed_one_by_one!(UnfoldOptions);

/// Outcome of unfolding.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum Outcome {
    /// A crease pattern was found.
    Unfolded,
    /// The angles round an interior vertex do not sum to 360 degrees.
    NotDevelopable,
    /// The flat pattern would overlap itself.
    Overlap,
}

impl Outcome {
    /// Returns the outcome's name in reports.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::Unfolded => "unfolded",
            Self::NotDevelopable => "not_developable",
            Self::Overlap => "overlap",
        }
    }
}

/// Reason why a shape has no flat pattern. `Display` makes a sentence of it.
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub enum Reason {
    /// The angles round a vertex do not sum to a full turn.
    AngleDefect {
        /// Number of the vertex in the shape.
        vertex: usize,
        /// Position of the vertex.
        at: [f64; 3],
        /// A full turn less the sum of the angles, radians.
        defect: f64,
        /// Largest defect that counts as none, radians.
        max_defect: f64,
    },
    /// Faces lie on each other in the flat pattern.
    FacesOverlap {
        /// Numbers of the faces in the first way to cut the shape.
        faces: [usize; 2],
        /// Number of ways to cut the shape that were tried.
        ways: usize,
    },
}

impl core::fmt::Display for Reason {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        match *self {
            Self::AngleDefect {
                vertex,
                at: [x, y, z],
                defect,
                max_defect,
            } => {
                let [defect, most] = [defect, max_defect].map(f64::to_degrees);
                write!(
                    f,
                    "vertex {vertex} at ({x}, {y}, {z}): the angles round it sum to {:.6} degrees, angle defect \
                     {defect:.6} degrees; a sheet has 360 degrees there, to within {most}",
                    360.0 - defect,
                )
            }
            Self::FacesOverlap {
                faces: [a, b],
                ways,
            } => {
                write!(f, "faces {a} and {b} overlap or touch in the flat pattern")?;
                if ways > 1 {
                    write!(f, ", and others do in each of {ways} ways to cut the shape")?;
                }
                Ok(())
            }
        }
    }
}

/// Result of unfolding a shape.
#[derive(Clone, Debug)]
pub struct Unfolding {
    /// Outcome of unfolding.
    pub outcome: Outcome,
    /// Reason why there is no pattern.
    pub reason: Option<Reason>,
    /// The flat sheet with the measured fold angles as its goal, if unfolded.
    pub drawing: Option<Drawing>,
    /// Precision of the flat sheet and its goal, which follows from that of the shape.
    pub precision: Precision,
    /// Number of vertices of the flat sheet, or of the shape if there is no flat sheet.
    pub vertices: usize,
    /// Number of faces.
    pub faces: usize,
    /// Number of hinges of the flat sheet, or of folded edges of the shape if there is no flat sheet.
    pub creases: usize,
    /// Number of edges between two faces along which the shape was cut.
    pub cuts: usize,
    /// Number of separate pieces of the flat sheet; 0 if there is no flat sheet.
    pub pieces: usize,
    /// Largest absolute angle defect (radians) of an interior vertex of the shape.
    pub max_angle_defect: f64,
    /// Largest closure residual of the pattern at the measured angles.
    pub max_closure: Option<f64>,
    /// Largest distance between a vertex of the pattern, folded by the measured angles, and the vertex of the shape,
    /// divided by the size of the shape.
    pub deviation: Option<f64>,
    /// Assumptions made and elements left out, one sentence each.
    pub notes: Vec<String>,
}

/// Unfolds a shape. Vertices keep their order where the shape is not cut, as do the edges that the shape names. Cost:
/// about linear, times the number of ways to cut that are tried.
///
/// # Errors
/// If the shape is no surface with two sides, made of flat faces.
pub fn unfold(shape: &FoldedShape, options: &UnfoldOptions) -> Result<Unfolding, ShapeError> {
    unfold_watched(shape, options, &Progress::default())
}

/// Unfolds a shape as [`unfold`] does, until `progress` is cancelled. The call ends after the present way to cut.
///
/// # Errors
/// If the shape is no surface with two sides, made of flat faces, or the call was cancelled.
pub fn unfold_watched(
    shape: &FoldedShape,
    options: &UnfoldOptions,
    progress: &Progress,
) -> Result<Unfolding, ShapeError> {
    let watch = Watch::new(progress);
    let mut notes = Vec::new();
    let mut surface = Surface::new(shape, options.max_defect, &mut notes)?;
    let creases = Creases::measure(shape, &mut surface, options.max_defect, &mut notes);
    let mut unfolding = Unfolding {
        outcome: Outcome::NotDevelopable,
        reason: None,
        drawing: None,
        precision: Precision::default(),
        vertices: surface.vertices(),
        faces: surface.faces.len(),
        creases: creases.hinges(),
        cuts: 0,
        pieces: 0,
        max_angle_defect: surface.max_defect(),
        max_closure: None,
        deviation: None,
        notes,
    };
    if let Some((vertex, defect)) = surface.not_developable(options.max_defect) {
        unfolding.reason = Some(Reason::AngleDefect {
            vertex,
            at: shape.vertices[vertex].into(),
            defect,
            max_defect: options.max_defect,
        });
        return Ok(unfolding);
    }
    let tries = if surface.is_disc() {
        1
    } else {
        options.attempts.max(1)
    };
    for attempt in 0..tries {
        if watch.is_over() {
            return Err(ShapeError::Cancelled);
        }
        watch.done(attempt, tries);
        let layout = Layout::new(shape, &surface, &creases, attempt, options.max_defect);
        let (drawing, sources) = layout.drawing(&surface, &creases);
        match CreasePattern::watched(drawing.clone(), watch) {
            Ok(pattern) => {
                measure(shape, &pattern, &sources, &mut unfolding);
                unfolding.outcome = Outcome::Unfolded;
                unfolding.reason = None;
                unfolding.cuts = layout.cuts(&surface);
                unfolding.pieces = pattern.sheets();
                unfolding.precision = precision_of(shape, &pattern);
                unfolding.notes.extend(layout.notes(&surface));
                unfolding.drawing = Some(drawing);
                return Ok(unfolding);
            }
            Err(PatternError::Cancelled) => return Err(ShapeError::Cancelled),
            // The first way to cut is the plainest, so its overlap is the one to report.
            Err(error) if unfolding.reason.is_none() => {
                let faces = overlapping(&error, &drawing)
                    .ok_or_else(|| ShapeError::Pattern(error.to_string()))?;
                unfolding.outcome = Outcome::Overlap;
                unfolding.reason = Some(Reason::FacesOverlap { faces, ways: tries });
            }
            Err(_) => {}
        }
    }
    Ok(unfolding)
}

/// Returns the precision of the flat sheet of a shape: a unit of the shape's coordinates moves a face by that unit, and
/// turns it by the unit over its size.
fn precision_of(shape: &FoldedShape, pattern: &CreasePattern) -> Precision {
    let points = shape.vertices.iter().map(|&point| point.into());
    let length = Digits::of_coordinates(points, |_| false);
    Precision {
        length,
        angle: length.scaled(1.0 / pattern.median_edge()),
    }
}

/// Measures the fold angles (radians, valley positive) of a shape at the edges that it names; 0 at edges with one face.
///
/// # Errors
/// If the shape is no surface with two sides, made of flat faces.
pub(crate) fn fold_angles(shape: &FoldedShape) -> Result<Vec<f64>, ShapeError> {
    let (mut notes, UnfoldOptions { max_defect, .. }) = (Vec::new(), UnfoldOptions::default());
    let mut surface = Surface::new(shape, max_defect, &mut notes)?;
    let mut angles = Creases::measure(shape, &mut surface, max_defect, &mut notes).angles;
    angles.truncate(shape.edges.len());
    Ok(angles)
}

/// Records the size of the pattern and the errors of its goal against the shape. `sources` has for each vertex of the
/// drawing the vertex of the shape.
fn measure(
    shape: &FoldedShape,
    pattern: &CreasePattern,
    sources: &[usize],
    unfolding: &mut Unfolding,
) {
    let goals = pattern.creases().iter().map(|&id| pattern.edge(id).goal);
    let goals: Vec<Option<f64>> = goals.collect();
    unfolding.vertices = pattern.vertices().len();
    unfolding.creases = goals.len();
    unfolding.max_closure = closure_of(pattern, &goals);
    let angles: Vec<f64> = goals.iter().map(|goal| goal.unwrap_or(0.0)).collect();
    let folded = FoldingMap::new(pattern, pattern.tree(), &angles);
    let target: Vec<Vector3<f64>> = sources.iter().map(|&v| shape.vertices[v]).collect();
    let laid = align_sheets(pattern, folded.vertices(), &target);
    let off = laid.iter().zip(&target).map(|(a, b)| (a - b).norm());
    unfolding.deviation = Some(crate::util::nan_max::largest(off) / shape.size());
}

/// Returns two overlapping faces of a drawing, if the error is about an overlap.
fn overlapping(error: &PatternError, drawing: &Drawing) -> Option<[usize; 2]> {
    let at = |vertices: &[usize]| -> Vec<usize> {
        let faces = drawing.faces.iter().flatten().enumerate();
        let has = |cycle: &[usize]| vertices.iter().all(|vertex| cycle.contains(vertex));
        faces
            .filter(|(_, cycle)| has(cycle))
            .map(|(face, _)| face)
            .collect()
    };
    let ends = |edge: usize| drawing.edges[edge].ends;
    let [first, second] = match *error {
        PatternError::Crossing { edge, other } | PatternError::Duplicate { edge, other } => {
            [edge, other].map(|edge| at(&ends(edge)))
        }
        PatternError::OnEdge { edge, vertex } => [at(&ends(edge)), at(&[vertex])],
        PatternError::BrokenStar { vertex } => [(); 2].map(|()| at(&[vertex])),
        PatternError::Overlap { first, second, .. } => return Some([first, second]),
        _ => return None,
    };
    let first = *first.first()?;
    Some([first, second.into_iter().find(|other| *other != first)?])
}
