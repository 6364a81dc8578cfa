//! Generates the square twist and its tessellation.

use nalgebra::Vector2;

use super::{ParameterError, check_angle, check_fold, check_sizes, crease};
use crate::pattern::{Drawing, DrawnEdge};

/// A tessellation of `rows` x `columns` square twists. A pleat of two parallel creases leaves each side of a unit
/// square at the angle α. The tiles are 2 x 2 units large and mirror their neighbours.
///
/// Each corner of a square is a flat-foldable vertex with four creases. Opposite creases turn by angles of equal size,
/// and the tangents of half the angles of neighbouring creases have the ratio τ or 1/τ, with τ = tan(π/4 - α/2). Round
/// the square, the ratios at its four corners have to multiply to 1. [`Letters::Foldable`] has each ratio twice: the
/// sides turn by (1, -τ, -1, τ) times one parameter, and the sheet folds rigidly. [`Letters::Unfoldable`] treats all
/// corners alike: as τ⁴ is not 1, there is no motion, although the goal, the sheet folded flat, closes.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SquareTwist {
    /// Twists along y.
    pub rows: usize,
    /// Twists along x.
    pub columns: usize,
    /// Angle α between the sides of the squares and their pleats, radians.
    pub angle: f64,
    /// Assignment of mountains and valleys.
    pub letters: Letters,
    /// Goal of foldable letters: fold angle of the creases that turn most, as a fraction of a half turn.
    pub fold: f64,
}

/// The two ways to letter a square twist.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Letters {
    /// Symmetric under half turns of the square with mountain and valley exchanged; the sheet folds.
    #[default]
    Foldable,
    /// Symmetric under quarter turns of the square; the sheet does not fold.
    Unfoldable,
}

/// Side length of a tile.
const TILE_LENGTH: f64 = 2.0;

/// Fold angles at the corner where side k of a square begins, in radians.
struct Corner {
    /// Fold angle of side k.
    side: f64,
    /// Fold angles of the pleat's crease beside side k, and of the crease beside the side before.
    pleats: [f64; 2],
}

impl SquareTwist {
    /// Returns the pattern with its goal.
    ///
    /// # Errors
    /// If a parameter is out of its range.
    pub fn drawing(&self) -> Result<Drawing, ParameterError> {
        check_sizes(self.rows, self.columns, 1)?;
        check_fold(self.fold)?;
        check_angle(self.angle)?;
        let mut drawing = Drawing::default();
        for row in 0..self.rows {
            for column in 0..self.columns {
                drawing.vertices.extend(self.corners(row, column));
            }
        }
        // Points on each border of the sheet: right, top, left, bottom.
        let mut borders: [Vec<usize>; 4] = Default::default();
        let [width, height] = [self.columns, self.rows].map(size);
        for (corner, [x, y]) in [[1.0, 0.0], [1.0, 1.0], [0.0, 1.0], [0.0, 0.0]]
            .into_iter()
            .enumerate()
        {
            borders[corner].push(drawing.vertices.len());
            borders[(corner + 3) % 4].push(drawing.vertices.len());
            drawing.vertices.push(Vector2::new(x * width, y * height));
        }
        for row in 0..self.rows {
            for column in 0..self.columns {
                self.add_twist(&mut drawing, &mut borders, row, column);
            }
        }
        for mut border in borders {
            let along = |&v: &usize| drawing.vertices[v].x + drawing.vertices[v].y;
            border.sort_by(|a, b| along(a).total_cmp(&along(b)));
            let sides = border.windows(2);
            let sides = sides.map(|ends| DrawnEdge::boundary([ends[0], ends[1]]));
            drawing.edges.extend(sides);
        }
        Ok(drawing)
    }

    /// Returns the corners of a square, starting with the corner at which side 0 begins. They run counter-clockwise if
    /// the tile is not mirrored.
    fn corners(&self, row: usize, column: usize) -> [Vector2<f64>; 4] {
        let (sin, cos) = self.angle.sin_cos();
        let first = Vector2::new(sin - cos, -cos - sin) / 2.0;
        let centre = Vector2::new(size(column), size(row)).add_scalar(TILE_LENGTH / 2.0);
        let sign = |index: usize| if index.is_multiple_of(2) { 1.0 } else { -1.0 };
        let mirror = Vector2::new(sign(column), sign(row));
        let mut corner = first;
        [0, 1, 2, 3].map(|_| {
            let place = centre + corner.component_mul(&mirror);
            corner = Vector2::new(-corner.y, corner.x);
            place
        })
    }

    fn add_twist(
        &self,
        drawing: &mut Drawing,
        borders: &mut [Vec<usize>; 4],
        row: usize,
        column: usize,
    ) {
        let first = 4 * (row * self.columns + column);
        for side in 0..4 {
            let next = (side + 1) % 4;
            let (begin, end) = (self.corner(side), self.corner(next));
            drawing
                .edges
                .push(crease([first + side, first + next], begin.side));
            // The pleats lead right, up, left, down; in a mirrored tile the opposite way.
            let mirrored = if side.is_multiple_of(2) { column } else { row } % 2 == 1;
            let way = if mirrored { (side + 2) % 4 } else { side };
            let neighbour = match way {
                0 if column + 1 < self.columns => Some(first + 4),
                1 if row + 1 < self.rows => Some(first + 4 * self.columns),
                2 if column > 0 => Some(first - 4),
                3 if row > 0 => Some(first - 4 * self.columns),
                _ => None,
            };
            for (corner, angle) in [(side, begin.pleats[0]), (next, end.pleats[1])] {
                match neighbour {
                    // A pleat between two tiles is drawn once, from the tile with the lower number.
                    Some(tile) if tile < first => {}
                    Some(tile) => drawing
                        .edges
                        .push(crease([first + corner, tile + corner], angle)),
                    None => {
                        let mut place = drawing.vertices[first + corner];
                        match way {
                            0 => place.x = size(self.columns),
                            1 => place.y = size(self.rows),
                            2 => place.x = 0.0,
                            _ => place.y = 0.0,
                        }
                        let vertex = drawing.vertices.len();
                        drawing.vertices.push(place);
                        drawing.edges.push(crease([first + corner, vertex], angle));
                        borders[way].push(vertex);
                    }
                }
            }
        }
    }

    /// Returns the goal at the corner where a side begins.
    fn corner(&self, side: usize) -> Corner {
        let half_turn = core::f64::consts::PI;
        if self.letters == Letters::Unfoldable {
            return Corner {
                side: half_turn,
                pleats: [-half_turn, half_turn],
            };
        }
        let large = self.fold * half_turn;
        let small = self.small(large);
        let sign = if side == 0 || side == 3 { 1.0 } else { -1.0 };
        if side.is_multiple_of(2) {
            Corner {
                side: sign * large,
                pleats: [-sign * small, sign * large],
            }
        } else {
            Corner {
                side: sign * small,
                pleats: [-sign * large, -sign * small],
            }
        }
    }

    /// For foldable letters, returns the fold angle of the creases that turn less if the others have `large` (radians).
    #[must_use]
    pub fn small(&self, large: f64) -> f64 {
        let ratio = (core::f64::consts::FRAC_PI_4 - self.angle / 2.0).tan();
        2.0 * (ratio * (large / 2.0).tan()).atan()
    }
}

/// Returns the length of `tiles` tiles.
#[allow(clippy::cast_precision_loss, reason = "at most thousands of tiles")]
fn size(tiles: usize) -> f64 {
    tiles as f64 * TILE_LENGTH
}
