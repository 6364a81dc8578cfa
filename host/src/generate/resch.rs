//! Generates Ron Resch's triangular tessellation.

use std::collections::{BTreeMap, HashMap};

use nalgebra::Vector2;

use super::{ParameterError, check_sizes, crease};
use crate::pattern::{Drawing, DrawnEdge};

/// Ron Resch's triangular tessellation: `rows` x `columns` stars, with smaller equilateral triangles between them. Each
/// star is an equilateral triangle with a centre, three valleys from the centre to its corners, and three mountains
/// half as long to the midpoints of its sides. A corner of each star is the midpoint of a side of the next star.
/// Midpoints are at distance 1 from the centre, corners at distance 2.
///
/// The goal has the stars tucked below, with the triangles between them closed to a plane. There valleys turn by 180,
/// sides by -90 and mountains by -60 degrees, and all vertices close. With the full symmetry of the tessellation this
/// configuration is isolated: the unknowns are the lattice constant and the position of a corner in the lattice, two in
/// all, and the sides of the two kinds of triangles between stars give two conditions. If each crease is an unknown of
/// its own, a motion leads from the flat sheet to this configuration.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Resch {
    /// Rows of stars, along y.
    pub rows: usize,
    /// Columns of stars, along x.
    pub columns: usize,
}

/// A point of the lattice, in units of (√3/2, 1/2).
type Point = (i32, i32);

/// Corners of a star about its centre.
const CORNERS: [Point; 3] = [(0, 4), (-2, -2), (2, -2)];
/// Midpoints of the star's sides; the k-th is opposite the k-th corner.
const MIDPOINTS: [Point; 3] = [(0, -2), (1, 1), (-1, 1)];
/// The triangles between stars: their corners relative to the centre of one star that they touch, and the relative
/// centres of all three stars that they touch.
const BETWEEN: [([Point; 3], [Point; 3]); 2] = [
    ([(1, 1), (2, 4), (0, 4)], [(0, 0), (3, 3), (0, 6)]),
    ([(1, 1), (2, -2), (3, 1)], [(0, 0), (3, 3), (3, -3)]),
];

const VALLEY_RAD: f64 = core::f64::consts::PI;
const SIDE_RAD: f64 = -core::f64::consts::FRAC_PI_2;
const MOUNTAIN_RAD: f64 = -core::f64::consts::FRAC_PI_3;

impl Resch {
    /// Returns the pattern with its goal.
    ///
    /// # Errors
    /// If a parameter is out of its range.
    pub fn drawing(&self) -> Result<Drawing, ParameterError> {
        check_sizes(self.rows, self.columns, 1)?;
        let mut builder = DrawingBuilder::default();
        #[allow(clippy::cast_possible_truncation, reason = "at most 3000")]
        #[allow(clippy::cast_possible_wrap, reason = "at most 3000")]
        let (rows, columns) = (self.rows as i32, self.columns as i32);
        let centre = |row: i32, column: i32| (3 * column, 6 * row + 3 * (column & 1));
        let is_star = |(x, y): Point| {
            let (column, above) = (x / 3, y - 3 * ((x / 3) & 1));
            x >= 0 && column < columns && above >= 0 && above / 6 < rows
        };
        for row in -1..=rows {
            for column in -1..=columns {
                let star = centre(row, column);
                if is_star(star) {
                    for k in 0..3 {
                        let [corner, midpoint] = [CORNERS[k], MIDPOINTS[k]];
                        builder.crease([star, add(star, corner)], VALLEY_RAD);
                        builder.crease([star, add(star, midpoint)], MOUNTAIN_RAD);
                        for other in [(k + 1) % 3, (k + 2) % 3] {
                            let half = [add(star, corner), add(star, MIDPOINTS[other])];
                            builder.side(half);
                        }
                    }
                }
                for (triangle, touches) in BETWEEN {
                    let touched = touches.iter().filter(|t| is_star(add(star, **t))).count();
                    if touched >= 2 {
                        let [a, b, c] = triangle.map(|p| add(star, p));
                        for side in [[a, b], [b, c], [c, a]] {
                            builder.side(side);
                        }
                    }
                }
            }
        }
        Ok(builder.into_drawing())
    }
}

fn add(a: Point, b: Point) -> Point {
    (a.0 + b.0, a.1 + b.1)
}

/// The drawing under construction, from points on a grid.
#[derive(Default)]
struct DrawingBuilder {
    index: HashMap<Point, usize>,
    drawing: Drawing,
    /// Sides of stars and of triangles between them, each with the number of faces found at it so far.
    sides: BTreeMap<[usize; 2], usize>,
}

impl DrawingBuilder {
    fn vertex(&mut self, point: Point) -> usize {
        let vertices = &mut self.drawing.vertices;
        *self.index.entry(point).or_insert_with(|| {
            let (x, y) = (f64::from(point.0), f64::from(point.1));
            vertices.push(Vector2::new(3_f64.sqrt() / 2.0 * x, y / 2.0));
            vertices.len() - 1
        })
    }

    fn crease(&mut self, ends: [Point; 2], goal: f64) {
        let ends = ends.map(|end| self.vertex(end));
        self.drawing.edges.push(crease(ends, goal));
    }

    /// Adds a side of a face. The side becomes a crease if it has a face on either side, else a boundary.
    fn side(&mut self, ends: [Point; 2]) {
        let mut ends = ends.map(|end| self.vertex(end));
        ends.sort_unstable();
        *self.sides.entry(ends).or_default() += 1;
    }

    fn into_drawing(mut self) -> Drawing {
        let sides = self.sides.into_iter().map(|(ends, faces)| match faces {
            2 => crease(ends, SIDE_RAD),
            _ => DrawnEdge::boundary(ends),
        });
        self.drawing.edges.extend(sides);
        self.drawing
    }
}
