//! Small sheets with hand-made paths.

use serde_json::{Value, json};

/// A sheet and its hinges.
pub struct HandMade {
    vertices: Vec<[f64; 2]>,
    edges: Vec<[usize; 2]>,
    faces: Vec<Vec<usize>>,
    /// Edges that turn, in the order in which paths list their angles.
    hinges: Vec<usize>,
}

/// A knot of a hand-made path.
pub struct HandKnot {
    /// Seconds since the start.
    pub time: f64,
    /// Fold angle of each hinge, degrees.
    pub angles: Vec<f64>,
    /// Rate of each hinge, degrees per second.
    pub rates: Vec<f64>,
}

impl HandMade {
    /// Returns a strip of three panels, the outer ones twice as long as the middle one is wide. Folded to one side they
    /// meet at cos(180° - ρ) = 1/4.
    #[must_use]
    pub fn strip() -> Self {
        Self::panels(&[-2.0, 0.0, 1.0, 3.0])
    }

    /// Returns a strip of panels between vertical lines at these x coordinates.
    #[must_use]
    pub fn panels(x: &[f64]) -> Self {
        let (lines, panels) = (x.len(), x.len() - 1);
        let sides = (0..lines).map(|k| [k, k + lines]);
        let rims = (0..panels).flat_map(|k| [[k, k + 1], [k + lines, k + 1 + lines]]);
        let row = |y: f64| x.iter().map(move |&x| [x, y]);
        Self {
            vertices: row(0.0).chain(row(1.0)).collect(),
            edges: sides.chain(rims).collect(),
            faces: (0..panels)
                .map(|k| vec![k, k + 1, k + 1 + lines, k + lines])
                .collect(),
            hinges: (1..panels).collect(),
        }
    }

    /// Returns three panels round one vertex, of 70°, 40° and 70°. Folded to one side the outer two meet at cos(180° -
    /// ρ) = tan 20° / tan 70°.
    #[must_use]
    pub fn fan() -> Self {
        Self::sectors(&[0.0, 70.0, 110.0, 180.0].map(|direction| (direction, 1.0)))
    }

    /// Returns triangles round one corner of the sheet between these rays: direction, degrees, and length.
    #[must_use]
    pub fn sectors(rays: &[(f64, f64)]) -> Self {
        let last = rays.len();
        let tips = rays.iter().map(|(direction, length)| {
            let (sin, cos) = direction.to_radians().sin_cos();
            [length * cos, length * sin]
        });
        let rim = (1..last).map(|k| [k, k + 1]);
        Self {
            vertices: [[0.0; 2]].into_iter().chain(tips).collect(),
            edges: (1..=last).map(|k| [0, k]).chain(rim).collect(),
            faces: (1..last).map(|k| vec![0, k, k + 1]).collect(),
            hinges: (1..last - 1).collect(),
        }
    }

    /// Returns two rows of `cells` trapezoids on both sides of a straight spine y = 0. The creases across the spine
    /// lean to the right and to the left by 60° in turn. Each vertex of the spine is flat-foldable, and the strip curls
    /// up as it folds. Order of the hinges: parts of the spine, then the creases across above it, then those below.
    #[must_use]
    pub fn arch(cells: usize) -> Self {
        let slope = 60_f64.to_radians().tan();
        let lean = |k: usize| if k.is_multiple_of(2) { 0.5 } else { -0.5 };
        let row = |y: f64| {
            let x = (0..=cells).zip((0..=cells).map(|k| 1.5 * k as f64));
            x.map(move |(k, x)| [x + lean(k) * y.abs() * 2.0 / slope, y])
        };
        let n = cells + 1;
        let across = |from: usize| (0..n).map(move |k| [n + k, from + k]);
        let along = |from: usize| (0..cells).map(move |k| [from + k, from + k + 1]);
        let edges: Vec<_> = (along(n).chain(across(2 * n)).chain(across(0)))
            .chain(along(0))
            .chain(along(2 * n))
            .collect();
        let quads = |low: usize| {
            (0..cells).map(move |k| vec![low + k, low + k + 1, low + n + k + 1, low + n + k])
        };
        let spine = 0..cells;
        let inner = |first: usize| first + 1..first + cells;
        Self {
            vertices: row(-1.0).chain(row(0.0)).chain(row(1.0)).collect(),
            edges,
            faces: quads(0).chain(quads(n)).collect(),
            hinges: spine.chain(inner(cells)).chain(inner(cells + n)).collect(),
        }
    }

    /// Returns for each hinge of an arch the ratio of tan(ρ/2) to that of the creases across. The ratio of a part of
    /// the spine is -cos 60° if the vertex before it leans right, and +cos 60° if that vertex leans left.
    #[must_use]
    pub fn arch_tangents(cells: usize) -> Vec<f64> {
        let spine = (0..cells).map(|k| if k.is_multiple_of(2) { -0.5 } else { 0.5 });
        spine.chain(vec![1.0; 2 * (cells - 1)]).collect()
    }

    /// Returns the path through these knots. Hinges have the assignment U.
    #[must_use]
    pub fn path(&self, interpolation: &str, knots: &[HandKnot]) -> Value {
        let spread = |of_hinges: &[f64]| {
            let mut edges = vec![0.0; self.edges.len()];
            let pairs = self.hinges.iter().zip(of_hinges);
            pairs.for_each(|(&edge, &value)| edges[edge] = value);
            edges
        };
        let frame = |knot: &HandKnot| {
            json!({
                "frame_classes": ["foldedForm"],
                "frame_parent": 0,
                "frame_inherit": true,
                "foldpath:time": knot.time,
                "edges_foldAngle": spread(&knot.angles),
                "foldpath:edges_foldAngleRate": spread(&knot.rates),
            })
        };
        let letter = |edge: usize| {
            if self.hinges.contains(&edge) {
                "U"
            } else {
                "B"
            }
        };
        json!({
            "file_spec": 1.2,
            "frame_classes": ["creasePattern"],
            "vertices_coords": self.vertices,
            "edges_vertices": self.edges,
            "edges_assignment": (0..self.edges.len()).map(letter).collect::<Vec<_>>(),
            "faces_vertices": self.faces,
            "foldpath:interpolation": interpolation,
            "file_frames": knots.iter().map(frame).collect::<Vec<_>>(),
        })
    }
}
