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
mod overlap;
mod pieces;
mod shape;
mod surface;
mod touching;

use nalgebra::Vector3;

use crate::folding::{FoldingMap, align_sheets};
use crate::pattern::{CreasePattern, Digits, Drawing, PatternError, Precision};
use crate::progress::{Progress, Watch};
use crate::symmetry::closure_of;
use crate::util::range::Range;
use angles::Creases;
use layout::Layout;
use overlap::ConvexFaces;
pub use shape::{FoldedShape, ShapeEdge, ShapeError};
use surface::Surface;
use touching::join_touching;

/// Largest deviation of a sheet that is folded back, over its size, that comes from the computation rather than the shape.
const MAX_ROUNDING_RATIO: f64 = 1e-9;

/// Largest number of overlapping layouts that are parted into pieces.
const MAX_PARTED: usize = 16;

/// Largest error of a shape that can be taken for noise.
pub const MAX_DEFECT_DEG: Range = Range::above("degrees", 0.0).up_to(10.0);
/// Default of [`UnfoldOptions::max_defect`], degrees.
pub const DEFAULT_MAX_DEFECT_DEG: f64 = 0.01;

/// Options of unfolding.
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub struct UnfoldOptions {
    /// Largest angle defect (radians) of an interior vertex that counts as developable, and largest slope of a corner
    /// out of the plane of its face. Defects that the rounding of coordinates explains, by their digits, count as
    /// developable as well, up to 1 degree.
    ///
    /// The default, 0.01 degrees, covers the rounding of coordinates with six digits on a sheet about ten edges across;
    /// a shape that was folded from paper by computation has defects of about 1e-13.
    pub max_defect: f64,
    /// Largest number of ways to cut a shape that are tried until one gives no overlap.
    pub attempts: usize,
    /// Which shapes are cut.
    pub cut: Cut,
}

/// Which shapes are cut so that they lie flat.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[non_exhaustive]
pub enum Cut {
    /// Those that no plane holds whole.
    #[default]
    Auto,
    /// None.
    None,
}

impl Default for UnfoldOptions {
    fn default() -> Self {
        Self {
            max_defect: DEFAULT_MAX_DEFECT_DEG.to_radians(),
            attempts: 64,
            cut: Cut::Auto,
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
    /// No plane holds the shape whole, and it is not cut.
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
    /// The faces of a ring do not meet in the plane.
    RingStaysOpen {
        /// Ends of an edge at which they do not meet.
        ends: [usize; 2],
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
            Self::RingStaysOpen { ends } => {
                let edge = layout::edge_name(ends);
                write!(
                    f,
                    "the edge {edge}: its faces do not meet when all faces of their ring lie flat"
                )
            }
            Self::FacesOverlap {
                faces: [a, b],
                ways,
            } => {
                write!(f, "faces {a} and {b} overlap in the flat pattern")?;
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
    let creases = Creases::measure(shape, &mut surface, &mut notes);
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
    let nearly_plain = surface.nearly_plain();
    let kept_whole = |part: usize| options.cut == Cut::None || nearly_plain[part];
    if let Some((vertex, defect)) = surface.worst_corner(kept_whole) {
        unfolding.reason = Some(Reason::AngleDefect {
            vertex,
            at: shape.vertices[vertex].into(),
            defect,
            max_defect: options.max_defect,
        });
        return Ok(unfolding);
    }
    let faces = ConvexFaces::new(&surface)?;
    let unfolder = Unfolder {
        shape,
        surface: &surface,
        creases: &creases,
        faces: &faces,
        options,
        watch,
    };
    unfolder.unfold(&mut unfolding)?;
    Ok(unfolding)
}

/// A surface that is to be laid flat.
struct Unfolder<'a> {
    shape: &'a FoldedShape,
    surface: &'a Surface,
    creases: &'a Creases,
    faces: &'a ConvexFaces,
    options: &'a UnfoldOptions,
    watch: Watch<'a>,
}

impl Unfolder<'_> {
    /// Lays the surface flat. Each part is cut in other ways until it does not lie on itself. If every way overlaps, the
    /// layouts are parted into pieces, and the one with the fewest pieces is taken.
    fn unfold(&self, unfolding: &mut Unfolding) -> Result<(), ShapeError> {
        let surface = self.surface;
        let parts = surface.parts();
        let plain = (0..parts).all(|part| surface.is_plain(part));
        let tries = if plain || self.options.cut == Cut::None {
            1
        } else {
            self.options.attempts.max(1)
        };
        let mut attempts = vec![0; parts];
        let mut flat = vec![false; parts];
        let mut overlapping = Vec::new();
        for attempt in 0..tries {
            self.go_on(attempt, tries)?;
            let layout = Layout::new(self.shape, surface, self.creases, &attempts);
            if let (Cut::None, Some(ends)) = (self.options.cut, layout.first_cut(surface)) {
                unfolding.reason = Some(Reason::RingStaysOpen { ends });
                return Ok(());
            }
            let touch = layout.touch(surface);
            let mut overlap = None;
            for part in (0..parts).filter(|part| !flat[*part]).collect::<Vec<_>>() {
                match layout.overlap(surface, self.faces, part, touch) {
                    None => flat[part] = true,
                    Some(faces) => {
                        overlap = overlap.or(Some(faces));
                        attempts[part] += 1;
                    }
                }
            }
            // The first way to cut is the plainest, so its overlap is the one to report.
            let is_flat = match overlap {
                None => self.accept(&layout, unfolding, tries)?,
                Some(faces) => {
                    let ways = tries;
                    let reason = Reason::FacesOverlap { faces, ways };
                    unfolding.outcome = Outcome::Overlap;
                    unfolding.reason.get_or_insert(reason);
                    false
                }
            };
            if is_flat {
                return Ok(());
            }
            if overlap.is_none() {
                // The check of the pattern knows no parts.
                flat.fill(false);
                attempts.iter_mut().for_each(|it| *it += 1);
            }
            if overlapping.len() < MAX_PARTED {
                overlapping.push((layout, touch));
            }
        }
        if tries == 1 {
            return Ok(());
        }
        let is_folded = |edge: usize| self.creases.angles[edge].abs() > 0.0;
        let mut parted = Vec::new();
        for (attempt, (layout, touch)) in overlapping.iter().enumerate() {
            self.go_on(attempt, overlapping.len())?;
            let layout = pieces::parted(layout, surface, self.faces, is_folded, *touch);
            parted.extend(layout);
        }
        parted.sort_by_key(|layout| (layout.pieces(), layout.cuts(surface)));
        for layout in parted {
            self.go_on(0, 1)?;
            if self.accept(&layout, unfolding, tries)? {
                break;
            }
        }
        Ok(())
    }

    /// Tells how far the work is.
    ///
    /// # Errors
    /// If the call was cancelled.
    fn go_on(&self, done: usize, of: usize) -> Result<(), ShapeError> {
        if self.watch.is_over() {
            return Err(ShapeError::Cancelled);
        }
        self.watch.done(done, of);
        Ok(())
    }

    /// Makes the pattern of a layout, measures it against the shape and returns `true`, or returns `false` if the layout
    /// is no planar pattern.
    fn accept(
        &self,
        layout: &Layout,
        unfolding: &mut Unfolding,
        ways: usize,
    ) -> Result<bool, ShapeError> {
        let (shape, surface) = (self.shape, self.surface);
        let (mut drawing, sources) = layout.drawing(surface, self.creases);
        let mut targets = sources.iter().map(|&v| shape.vertices[v]).collect();
        join_touching(&mut drawing, &mut targets, layout.touch(surface));
        let pattern = match CreasePattern::watched(drawing.clone(), self.watch) {
            Ok(pattern) => pattern,
            Err(PatternError::Cancelled) => return Err(ShapeError::Cancelled),
            Err(error) => {
                if unfolding.reason.is_none() {
                    let faces = overlapping(&error, &drawing)
                        .ok_or_else(|| ShapeError::Pattern(error.to_string()))?;
                    unfolding.outcome = Outcome::Overlap;
                    unfolding.reason = Some(Reason::FacesOverlap { faces, ways });
                }
                return Ok(false);
            }
        };
        measure(shape, &pattern, &targets, unfolding);
        unfolding.outcome = Outcome::Unfolded;
        unfolding.reason = None;
        unfolding.cuts = layout.cuts(surface);
        unfolding.pieces = pattern.sheets();
        unfolding.precision = precision_of(shape, surface, &pattern, unfolding.deviation);
        unfolding.notes.extend(self.note_of_corners());
        unfolding.notes.extend(layout.notes(surface));
        unfolding.drawing = Some(drawing);
        Ok(true)
    }

    /// Returns a note of the corners to which the boundary is cut, or of angle defects that count as rounding.
    fn note_of_corners(&self) -> Vec<String> {
        let surface = self.surface;
        let mut notes = Vec::new();
        let open = |part: usize| !surface.closed[part];
        if let Some((vertex, defect)) = surface.worst_corner(open) {
            let corners = surface.corners.iter();
            let corners = corners.filter(|&&point| open(surface.part_of(point)));
            let [x, y, z]: [f64; 3] = self.shape.vertices[vertex].into();
            notes.push(format!(
                "corners, vertices inside a part with a boundary whose angles do not sum to 360 degrees: {} (farthest \
                 from it: vertex {vertex} at ({x}, {y}, {z}) with {:.6} degrees)",
                corners.count(),
                360.0 - defect.to_degrees()
            ));
        }
        let noise = surface.noise();
        if noise > self.options.max_defect {
            notes.push(format!(
                "angle defects up to {:.4} degrees are within the rounding of coordinates to {:.0e}, and taken for none",
                noise.to_degrees(),
                surface.length.unit()
            ));
        }
        notes
    }
}

/// Returns the precision of the flat sheet of a shape. Its lengths are as precise as the coordinates of the shape, and as the
/// sheet that is folded back. A unit of length moves a face by that unit, and turns it by the unit over its size.
fn precision_of(
    shape: &FoldedShape,
    surface: &Surface,
    pattern: &CreasePattern,
    deviation: Option<f64>,
) -> Precision {
    let off = deviation.filter(|off| *off > MAX_ROUNDING_RATIO);
    let off = Digits::of_unit(2.0 * off.unwrap_or_default() * shape.size());
    let length = surface.length.coarser(off);
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
    let mut angles = Creases::measure(shape, &mut surface, &mut notes).angles;
    angles.truncate(shape.edges.len());
    Ok(angles)
}

/// Records the size of the pattern and the errors of its goal against the shape. `targets` has for each vertex of the
/// drawing its place in the shape.
fn measure(
    shape: &FoldedShape,
    pattern: &CreasePattern,
    targets: &[Vector3<f64>],
    unfolding: &mut Unfolding,
) {
    let goals = pattern.creases().iter().map(|&id| pattern.edge(id).goal);
    let goals: Vec<Option<f64>> = goals.collect();
    unfolding.vertices = pattern.vertices().len();
    unfolding.creases = goals.len();
    unfolding.max_closure = closure_of(pattern, &goals);
    let angles: Vec<f64> = goals.iter().map(|goal| goal.unwrap_or(0.0)).collect();
    let folded = FoldingMap::new(pattern, pattern.tree(), &angles);
    let laid = align_sheets(pattern, folded.vertices(), targets);
    let off = laid.iter().zip(targets).map(|(a, b)| (a - b).norm());
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
