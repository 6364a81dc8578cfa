//! Panels with windows, flaps, doors, slots and pop-ups in them.

use core::ops::Range;

use foldpath::pattern::{Drawing, DrawnEdge, Letter};
use nalgebra::Vector2;

use super::letter;
use crate::Random;

/// Largest distance from a crease at which something lies on it, and the least to what lies in a panel.
const NEAR_CREASE: f64 = 0.9;
const IN_PANEL: f64 = 1.0;
/// Distance from the border, and between things in one panel.
const MARGIN: f64 = 0.4;

/// Draws a strip of panels between parallel creases, with things cut into the panels and across the creases. Only the
/// creases of pop-ups depend on each other: their cross section is a parallelogram, so that all turn by the same angle.
#[must_use]
pub fn windows(random: &mut Random) -> Drawing {
    let panels = random.whole(2, 4);
    let height = random.uniform(4.0, 6.0);
    let mut x = vec![0.0];
    for panel in 0..panels {
        x.push(x[panel] + random.uniform(3.6, 5.0));
    }
    let mut sheet = Sheet::default();
    for &at in &[0.0, height] {
        let ends: Vec<_> = x.iter().map(|&x| [x, at]).collect();
        sheet.chain(&ends, None, Letter::Boundary);
    }
    for at in [0.0, x[panels]] {
        sheet.chain(&[[at, 0.0], [at, height]], None, Letter::Boundary);
    }
    // The ends of the pieces of each crease, in pairs.
    let mut pieces: Vec<Vec<f64>> = vec![vec![0.0, height]; panels + 1];
    let turns: Vec<f64> = (0..=panels).map(|_| turn(random, 20.0..70.0)).collect();
    for crease in 1..panels {
        let low = random.uniform(MARGIN, 0.4 * height);
        let high = random.uniform(0.6 * height, height - MARGIN);
        if random.chance(0.6) {
            let at = x[crease];
            let cut = sheet.across(random, at, [low, high], turns[crease]);
            pieces[crease].extend(cut);
        }
    }
    for panel in 0..panels {
        let [left, right] = [x[panel] + IN_PANEL, x[panel + 1] - IN_PANEL];
        let rows = random.whole(1, 2);
        #[allow(clippy::cast_precision_loss, reason = "1 or 2")]
        let row_height = (height - MARGIN) / rows as f64;
        for row in 0..rows {
            #[allow(clippy::cast_precision_loss, reason = "0 or 1")]
            let low = MARGIN + row as f64 * row_height;
            let room = [left, low, right, low + row_height - MARGIN];
            let is_whole = panel > 0 && pieces[panel].len() == 2;
            if is_whole && random.chance(0.2) {
                // A window that touches the crease to its left with a corner.
                let tip = [x[panel], (room[1] + room[3]) / 2.0];
                let corners = [tip, [left, room[1]], [left, room[3]], tip];
                sheet.chain(&corners, None, cut(random));
                pieces[panel].extend([tip[1]; 2]);
            } else {
                sheet.inside(random, room, 2);
            }
        }
    }
    for crease in 1..panels {
        let ends = &mut pieces[crease];
        ends.sort_by(f64::total_cmp);
        for piece in ends.chunks(2) {
            let ends = [[x[crease], piece[0]], [x[crease], piece[1]]];
            sheet.chain(&ends, Some(turns[crease]), Letter::Unassigned);
        }
    }
    sheet.0
}

/// Returns an angle in radians, of either sign, whose absolute value is in this range of degrees.
fn turn(random: &mut Random, degrees: Range<f64>) -> f64 {
    let side = if random.chance(0.5) { 1.0 } else { -1.0 };
    side * random.uniform(degrees.start, degrees.end).to_radians()
}

/// Returns one of the letters of a cut.
fn cut(random: &mut Random) -> Letter {
    if random.chance(0.5) {
        Letter::Boundary
    } else {
        Letter::Cut
    }
}

#[derive(Default)]
struct Sheet(Drawing);

impl Sheet {
    /// Draws lines from place to place: creases with this goal, or else lines with this letter.
    fn chain(&mut self, places: &[[f64; 2]], goal: Option<f64>, other: Letter) {
        for pair in places.windows(2) {
            let ends = [self.vertex(pair[0]), self.vertex(pair[1])];
            self.0.edges.push(DrawnEdge {
                ends,
                letter: goal.map_or(other, letter),
                goal,
            });
        }
    }

    /// Returns the vertex at a place.
    fn vertex(&mut self, place: [f64; 2]) -> usize {
        let place = Vector2::from(place);
        let vertices = &mut self.0.vertices;
        let known = vertices.iter().position(|it| *it == place);
        known.unwrap_or_else(|| {
            vertices.push(place);
            vertices.len() - 1
        })
    }

    /// Draws something across a crease at `x`, between these heights. Returns the ends of the part of the crease that it
    /// takes away.
    fn across(
        &mut self,
        random: &mut Random,
        x: f64,
        [low, high]: [f64; 2],
        turn: f64,
    ) -> [f64; 2] {
        let letter = cut(random);
        let [a, b] = [(); 2].map(|()| random.uniform(0.3, NEAR_CREASE));
        let (left, right) = (x - a, x + b);
        match random.whole(0, 2) {
            // A window.
            0 => {
                let [bottom, top] = [low, high].map(|y| [[left, y], [x, y], [right, y]]);
                self.chain(&bottom, None, letter);
                self.chain(&top, None, letter);
                self.chain(&[bottom[0], top[0]], None, letter);
                self.chain(&[bottom[2], top[2]], None, letter);
                [low, high]
            }
            // A cut across the crease.
            1 => {
                self.chain(&[[left, low], [x, low], [right, low]], None, letter);
                [low, low]
            }
            // A pop-up: the crease moves from `x` to `back`, as far from the right end as `x` is from the left one.
            _ => {
                let back = right - a;
                for y in [low, high] {
                    let mut along = [left, x, back, right];
                    along.sort_by(f64::total_cmp);
                    self.chain(&along.map(|x| [x, y]), None, letter);
                }
                for (at, turn) in [(left, turn), (back, -turn), (right, turn)] {
                    self.chain(&[[at, low], [at, high]], Some(turn), letter);
                }
                [low, high]
            }
        }
    }

    /// Draws something into a panel that has this room, left, bottom, right and top, and again into that if it is a flap,
    /// as often as `depth` says.
    fn inside(&mut self, random: &mut Random, room: [f64; 4], depth: usize) {
        let [left, low, right, high] = room;
        let corners = [[left, low], [right, low], [right, high], [left, high]];
        let side = |k: usize| [corners[k % 4], corners[(k + 1) % 4]];
        let letter = cut(random);
        match random.whole(0, 5) {
            0 => {}
            // A window.
            1 => {
                for k in 0..4 {
                    self.chain(&side(k), None, letter);
                }
            }
            // A slot without width.
            2 => self.chain(&[corners[0], corners[2]], None, letter),
            // Two doors.
            3 => {
                let middle = random.uniform(0.4, 0.6) * (right - left) + left;
                for y in [low, high] {
                    self.chain(&[[left, y], [middle, y], [right, y]], None, letter);
                }
                self.chain(&[[middle, low], [middle, high]], None, letter);
                for k in [1, 3] {
                    let turn = turn(random, 10.0..150.0);
                    self.chain(&side(k), Some(turn), letter);
                }
            }
            // A flap.
            _ => {
                let hinge = random.whole(0, 3);
                let turn = turn(random, 10.0..150.0);
                for k in 0..4 {
                    self.chain(&side(k), (k == hinge).then_some(turn), letter);
                }
                if depth > 0 {
                    let inset = 0.2 * (right - left).min(high - low);
                    let room = [left + inset, low + inset, right - inset, high - inset];
                    self.inside(random, room, depth - 1);
                }
            }
        }
    }
}
