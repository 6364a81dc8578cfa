//! Sheets that can be made arbitrarily extreme, and whose exact motion is known.

use foldpath::pattern::{Drawing, DrawnEdge, Letter};
use nalgebra::Vector2;

use super::big::Big;
use super::reference::straight;

/// A Miura sheet with rows and columns of any width. Every vertex still has the same star, so that the motion is that
/// of the even sheet.
#[derive(Clone, Debug)]
pub struct Mesh {
    /// Lengths of the zigzag creases, row by row.
    pub heights: Vec<f64>,
    /// Lengths of the straight creases, column by column.
    pub widths: Vec<f64>,
    /// Sector angle, radians.
    pub sector: f64,
    /// Goal fold angle of the zigzag creases, radians.
    pub zigzag: f64,
    /// The unit of length.
    pub scale: f64,
    /// Position of the first vertex along both axes, in the sheet's own units.
    pub shift: f64,
}

impl Mesh {
    /// Creates a sheet of `size` x `size` unit faces with a sector angle of 60 degrees, folded to 150 degrees.
    #[must_use]
    pub fn even(size: usize) -> Self {
        Self {
            heights: vec![1.0; size],
            widths: vec![1.0; size],
            sector: 60_f64.to_radians(),
            zigzag: 150_f64.to_radians(),
            scale: 1.0,
            shift: 0.0,
        }
    }

    /// Sets lengths that grow from 1 to `ratio` by a constant factor.
    #[must_use]
    pub fn with_ratio(mut self, ratio: f64) -> Self {
        #[allow(clippy::cast_precision_loss, reason = "a few rows")]
        for lengths in [&mut self.heights, &mut self.widths] {
            let steps = (lengths.len() - 1) as f64;
            for (k, length) in lengths.iter_mut().enumerate() {
                *length = ratio.powf(k as f64 / steps);
            }
        }
        self
    }

    /// Returns the fold angle of the straight creases at the goal, radians.
    #[must_use]
    pub fn straight(&self) -> f64 {
        straight(&Big::new(self.sector), &Big::new(self.zigzag)).to_f64()
    }

    /// Returns the pattern with its goal.
    #[must_use]
    pub fn drawing(&self) -> Drawing {
        let (sin, cos) = self.sector.sin_cos();
        let sums = |lengths: &[f64]| {
            let ends = lengths.iter().scan(0.0, |sum, length| {
                *sum += length;
                Some(*sum)
            });
            core::iter::once(0.0).chain(ends).collect::<Vec<f64>>()
        };
        let (across, up) = (sums(&self.widths), sums(&self.heights));
        let mut lean = vec![0.0];
        for (row, height) in self.heights.iter().enumerate() {
            let way = if row % 2 == 0 { 1.0 } else { -1.0 };
            lean.push(lean[row] + way * height * cos);
        }
        let place = |x: f64, y: f64| Vector2::new(x, y).map(|c| (c + self.shift) * self.scale);
        let rows = up.iter().zip(&lean);
        let vertices =
            rows.flat_map(|(y, lean)| across.iter().map(move |x| place(x + lean, y * sin)));
        let (rows, columns) = (self.heights.len(), self.widths.len());
        let mut drawing = Drawing {
            vertices: vertices.collect(),
            ..Drawing::default()
        };
        let index = |row: usize, column: usize| row * (columns + 1) + column;
        let straight = self.straight();
        let mut join = |ends, boundary: bool, mountain: bool, angle: f64| {
            let (letter, sign) = match mountain {
                true => (Letter::Mountain, -1.0),
                false => (Letter::Valley, 1.0),
            };
            drawing.edges.push(DrawnEdge {
                ends,
                letter: if boundary { Letter::Boundary } else { letter },
                goal: (!boundary).then_some(sign * angle),
            });
        };
        for row in 0..=rows {
            for column in 0..=columns {
                let even = column % 2 == 0;
                if row < rows {
                    let ends = [index(row, column), index(row + 1, column)];
                    join(ends, column == 0 || column == columns, even, self.zigzag);
                }
                if column < columns {
                    let ends = [index(row, column), index(row, column + 1)];
                    let mountain = even != (row % 2 == 0);
                    join(ends, row == 0 || row == rows, mountain, straight);
                }
            }
        }
        drawing
    }
}

/// Returns a disc of panels round one vertex, with creases at even angles, alternately mountain and valley.
#[must_use]
pub fn disc(degree: usize) -> Drawing {
    #[allow(clippy::cast_precision_loss, reason = "a few hundred creases")]
    let place = |k: usize| {
        let (sin, cos) = (core::f64::consts::TAU * k as f64 / degree as f64).sin_cos();
        Vector2::new(cos, sin)
    };
    let rim = (0..degree).map(place);
    let creases = (0..degree).map(|k| DrawnEdge {
        ends: [degree, k],
        letter: if k % 2 == 0 {
            Letter::Mountain
        } else {
            Letter::Valley
        },
        goal: None,
    });
    let border = (0..degree).map(|k| DrawnEdge {
        ends: [k, (k + 1) % degree],
        letter: Letter::Boundary,
        goal: None,
    });
    Drawing {
        vertices: rim.chain([Vector2::zeros()]).collect(),
        edges: creases.chain(border).collect(),
        faces: None,
    }
}
