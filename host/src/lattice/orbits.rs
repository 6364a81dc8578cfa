//! The lattice of a tessellation: translations of the flat sheet under which all hinges turn alike, and the orbit and
//! cell of each face.

use nalgebra::Vector2;

use crate::pattern::{CreasePattern, EdgeId, FaceId};
use crate::util::csr::Csr;

/// The lattice of a sheet. It gives each face a coordinate: its *orbit* under the translations, and its *cell*.
///
/// # Why one face of each orbit stands for all
///
/// A *step* is a translation by t. Let the faces A = F₀, F₁, … Fₖ = B follow each other across hinges, and let the step
/// take each of these faces to a face of the sheet, and each of these hinges to a hinge of the same group and sign, or
/// a side that stays flat to such a side. The pose of B relative to A is the product of the turns about the hinges. The
/// images of the hinges turn by the same angles, about lines moved by t. So B + t moves relative to A + t as B does
/// relative to A, for any group angles. In other words: let `pose` take flat points to folded points; then the rigid
/// motion S that takes pose(A)(x) to pose(A + t)(x + t) is the same for all faces that such chains join. Nothing else
/// is required of the step: faces without an image, and parts of the sheet that no chain joins, may move otherwise, and
/// they have orbits of their own. There is one exception: if two faces of one orbit are joined by corresponding hinges
/// to a face X at the border and to a face Y, then X moves as Y does and belongs to the orbit of Y.
///
/// With two steps, some face A has its images A + t₁, A + t₂ and A + t₁ + t₂ in the sheet. Wherever the sheet closes,
/// the two paths to A + t₁ + t₂ show that S₁ and S₂ commute. So any path from a face to its image along steps gives
/// pose(A + i t₁ + j t₂)(x + i t₁ + j t₂) = S₁ⁱ S₂ʲ pose(A)(x), and pairs of faces of the same orbits and the same
/// difference of cells move alike. Other paths between cells may lead through places without a face: the formula holds
/// for the hinges there all the same.
///
/// Holes do not matter, because the sheet closes round them as well. These statements are exact for exact coordinates.
/// For other coordinates they hold to about the largest distance between a corner moved by a step and the corner that
/// counts as its image, times the square of the number of cells.
#[derive(Clone, Debug)]
pub struct Lattice {
    pub(super) steps: Vec<Vector2<f64>>,
    pub(super) orbits: Vec<Orbit>,
    pub(super) coords: Vec<LatticeCoord>,
    /// For each row of cells of each orbit the faces of the row, sorted by column.
    pub(super) rows: Csr<(i32, FaceId)>,
    pub(super) tree: Vec<Link>,
    pub(super) loops: Vec<Link>,
}

/// Orbit and cell of a face.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct LatticeCoord {
    /// The face's orbit.
    pub orbit: u32,
    /// The face's cell, counted in steps; the second number is 0 if there is only one step.
    pub cell: [i32; 2],
}

/// A class of faces that steps take to each other.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Orbit {
    /// A face of the orbit, as near to the middle of the sheet as any.
    pub representative: FaceId,
    /// Smallest coordinates of the orbit's cells.
    pub low: [i32; 2],
    /// Largest coordinates of the orbit's cells.
    pub high: [i32; 2],
    /// Index of the orbit's first row in the list of rows.
    pub(super) first_row: u32,
}

/// Two adjacent faces and the edge between them.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Link {
    /// The face that the path leaves.
    pub from: FaceId,
    /// The face that the path enters.
    pub to: FaceId,
    /// The edge between the two faces.
    pub edge: EdgeId,
}

impl Lattice {
    /// Returns the one or two steps, which lead to the cells [1, 0] and [0, 1].
    #[must_use]
    pub fn steps(&self) -> &[Vector2<f64>] {
        &self.steps
    }

    /// Returns the orbits; [`LatticeCoord::orbit`] is an index into this list.
    #[must_use]
    pub fn orbits(&self) -> &[Orbit] {
        &self.orbits
    }

    /// Returns the coordinate of each face.
    #[must_use]
    pub fn coords(&self) -> &[LatticeCoord] {
        &self.coords
    }

    /// Returns the coordinate of a face.
    #[must_use]
    pub fn coord(&self, face: FaceId) -> LatticeCoord {
        self.coords[face.index()]
    }

    /// Returns the face of an orbit in a cell, if the sheet has it. Cost: logarithmic.
    #[must_use]
    pub fn face_at(&self, coord: LatticeCoord) -> Option<FaceId> {
        let orbit = self.orbits.get(coord.orbit as usize)?;
        let [column, row] = coord.cell;
        let row = self.row(orbit, row);
        let at = row.binary_search_by_key(&column, |&(column, _)| column);
        at.ok().map(|at| row[at].1)
    }

    /// Returns the faces of an orbit in a row of cells, with their columns in increasing order.
    pub(super) fn row(&self, orbit: &Orbit, row: i32) -> &[(i32, FaceId)] {
        if row < orbit.low[1] || row > orbit.high[1] {
            return &[];
        }
        &self.rows[orbit.first_row as usize + row.abs_diff(orbit.low[1]) as usize]
    }

    /// Returns for each step the smallest and the largest coordinate of any cell.
    pub(crate) fn extent(&self) -> [[i32; 2]; 2] {
        [0, 1].map(|k| {
            let low = self.orbits.iter().map(|orbit| orbit.low[k]).min();
            let high = self.orbits.iter().map(|orbit| orbit.high[k]).max();
            [low, high].map(Option::unwrap_or_default)
        })
    }

    /// Returns the translation from cell [0, 0] to this cell in the flat sheet.
    #[must_use]
    pub fn translation(&self, cell: [i32; 2]) -> Vector2<f64> {
        shift(&self.steps, cell)
    }

    /// Returns links that lead to the second and every further orbit from an earlier orbit, within one cell.
    #[must_use]
    pub fn tree(&self) -> &[Link] {
        &self.tree
    }

    /// Returns for each step a link that leads from one cell to the cell one step on.
    #[must_use]
    pub fn loops(&self) -> &[Link] {
        &self.loops
    }

    /// Returns a bound, in median edges, on the distance of a face from its position by the lattice, as seen from any
    /// other face, if all stars close to within `closure` (norm of the residual). The bound is infinite if the sheet
    /// has holes. Cost: O(orbits).
    ///
    /// Two paths between the faces, one along a spanning tree and one along the steps of the lattice, enclose at most
    /// the vertices that fit in the bounding box of the cells. Each enclosed vertex turns the part beyond it by its
    /// residual.
    #[must_use]
    pub fn lattice_deviation(&self, pattern: &CreasePattern, closure: f64) -> f64 {
        let ends = self.cells_across();
        let ways = self.steps.iter().zip(ends);
        let reach: f64 = ways.map(|(step, count)| step.norm() * count).sum();
        self.turn_deviation(pattern, closure) * reach / pattern.median_edge()
    }

    /// Returns a bound, in radians, on the angle by which a face is turned from its orientation by the lattice, as seen
    /// from any other face, if all stars close to within `closure`. The bound is infinite if the sheet has holes.
    #[must_use]
    pub fn turn_deviation(&self, pattern: &CreasePattern, closure: f64) -> f64 {
        if !pattern.holes().is_empty() {
            return f64::INFINITY;
        }
        let ends = self.cells_across();
        #[allow(clippy::cast_precision_loss, reason = "counts of vertices and faces")]
        let [vertices, faces, orbits] = [
            pattern.vertices().len(),
            pattern.faces().len(),
            self.orbits.len(),
        ]
        .map(|count| count as f64);
        closure * (vertices * orbits / faces * ends[0] * ends[1])
    }

    /// Returns the largest number of cells side by side along each step.
    fn cells_across(&self) -> [f64; 2] {
        let extent = self.extent();
        extent.map(|[low, high]| f64::from(high) - f64::from(low) + 1.0)
    }
}

/// Returns the sum of `counts[0]` times the first step and `counts[1]` times the second.
pub(super) fn shift(steps: &[Vector2<f64>], counts: [i32; 2]) -> Vector2<f64> {
    let parts = steps.iter().zip(counts);
    parts.map(|(step, count)| step * f64::from(count)).sum()
}
