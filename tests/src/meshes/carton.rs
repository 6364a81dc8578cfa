//! Tuck cartons drawn for board: what lies on another flap is drawn a step apart from it, so that board as thick as the step
//! folds.

use core::f64::consts::FRAC_PI_2;

use foldpath::pattern::{Drawing, DrawnEdge, Letter};
use nalgebra::Vector2;

use crate::Random;

/// A carton with a tube, two dust flaps and a lid with a tuck at one end. Lengths are those of the sheet.
#[derive(Clone, Copy, Debug)]
pub struct Carton {
    /// Width and depth of the tube.
    pub width: f64,
    /// See `width`.
    pub depth: f64,
    /// Length of the tube.
    pub height: f64,
    /// Widths of the flap that closes the tube and of the tuck.
    pub glue: f64,
    /// See `glue`.
    pub tuck: f64,
    /// Distance of panels that lie on each other.
    pub step: f64,
}

/// Lines that end at common vertices.
#[derive(Default)]
struct Lines {
    vertices: Vec<Vector2<f64>>,
    edges: Vec<DrawnEdge>,
}

impl Lines {
    fn vertex(&mut self, [x, y]: [f64; 2]) -> usize {
        let at = Vector2::new(x, y);
        let known = self.vertices.iter().position(|it| (it - at).norm() < 1e-9);
        known.unwrap_or_else(|| {
            self.vertices.push(at);
            self.vertices.len() - 1
        })
    }

    fn line(&mut self, ends: [[f64; 2]; 2], folds: bool) {
        let ends = ends.map(|end| self.vertex(end));
        let letter = if folds {
            Letter::Valley
        } else {
            Letter::Boundary
        };
        self.edges.push(DrawnEdge {
            ends,
            letter,
            goal: folds.then_some(FRAC_PI_2),
        });
    }

    /// Draws a border along these places.
    fn border(&mut self, places: &[[f64; 2]]) {
        for ends in places.windows(2) {
            self.line([ends[0], ends[1]], false);
        }
    }
}

impl Carton {
    /// Draws the measures of a carton in millimetres.
    #[must_use]
    pub fn random(random: &mut Random) -> Self {
        let depth = random.uniform(20.0, 40.0);
        Self {
            width: random.uniform(40.0, 80.0),
            depth,
            height: random.uniform(40.0, 100.0),
            glue: random.uniform(6.0, 10.0),
            tuck: random.uniform(6.0, 10.0),
            step: random.uniform(0.3, 1.2),
        }
    }

    /// Returns the drawing, all creases valleys of 90 degrees. From left to right it has the flap that closes the tube from
    /// inside, back, side, front and side. The front and the lid are wider by a step, as the second side lies outside of the flap;
    /// the lid is shorter by a step, as its tuck lies inside of the back; and dust flaps begin a step below the lid.
    #[must_use]
    pub fn drawing(&self) -> Drawing {
        let Self { step, tuck, .. } = *self;
        let mut lines = Lines::default();
        let widths = [self.width, self.depth, self.width + step, self.depth];
        let mut x = [self.glue; 5];
        for (k, width) in widths.iter().enumerate() {
            x[k + 1] = x[k] + width;
        }
        let top = self.height;
        // The flap stays clear of dust flap and tuck.
        let clear = 3.0 * step;
        lines.line([[x[0], clear], [x[0], top]], true);
        lines.border(&[[x[0], 0.0], [x[0], clear], [0.0, clear + 4.0]]);
        lines.border(&[[0.0, clear + 4.0], [0.0, top - 4.0], [x[0], top]]);
        for &x in &x[1..4] {
            lines.line([[x, step], [x, top]], true);
            lines.border(&[[x, 0.0], [x, step]]);
        }
        lines.border(&[[x[4], step], [x[4], top]]);
        lines.border(&x.map(|x| [x, top]));
        lines.border(&[[x[0], 0.0], [x[1], 0.0]]);
        for side in [1, 3] {
            let [left, right] = [x[side], x[side + 1]];
            let [from, to] = [left + 2.0 * step + 1.0, right - 2.0 * step - 1.0];
            let end = -0.3 * self.width;
            lines.line([[from, step], [to, step]], true);
            lines.border(&[[left, step], [from, step], [from + 2.0, end]]);
            lines.border(&[
                [from + 2.0, end],
                [to - 2.0, end],
                [to, step],
                [right, step],
            ]);
        }
        let [left, right, end] = [x[2], x[3], step - self.depth];
        let [from, to] = [left + 2.0 * step + 0.5, right - 2.0 * step - 0.5];
        lines.line([[left, 0.0], [right, 0.0]], true);
        lines.line([[from, end], [to, end]], true);
        lines.border(&[[left, 0.0], [from, end], [from + 1.0, end - tuck]]);
        lines.border(&[[from + 1.0, end - tuck], [to - 1.0, end - tuck]]);
        lines.border(&[[to - 1.0, end - tuck], [to, end], [right, 0.0]]);
        Drawing {
            vertices: lines.vertices,
            edges: lines.edges,
            faces: None,
        }
    }
}
