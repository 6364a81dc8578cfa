//! Generates a flat conical Kresling pattern.

use nalgebra::{Rotation3, Vector2, Vector3};

use super::{ParameterError, check, check_size, crease, number};
use crate::pattern::{Drawing, DrawnEdge};

/// A flat conical Kresling pattern: a regular polygon of `columns` sides as central panel, and round it `rows` rings of
/// triangles, with each ring's outer polygon rotated against its inner one.
///
/// The pattern has a goal that closes, but no motion leads to it: there are as many conditions as creases, and at the
/// goal the conditions are independent. (There is also no raised state in which the rings stay level, as in the
/// cylinder: for the given lengths of edges and with all N corners of a polygon alike, the flat state is the only one.)
/// The goal is symmetric under the rotation by one side combined with the reflection in the plane of the panel: the
/// corners of each outer polygon alternate above and below that plane, so N must be even.
///
/// Three spheres determine the place of a polygon's corner: two about the ends of the inner side that it is tied to,
/// one about its image under the symmetry, the next corner.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Kresling {
    /// Rings of triangles.
    pub rows: usize,
    /// Sides of the central panel.
    pub columns: usize,
}

/// Largest number of sides; with more, the rings beyond the second are too narrow to be seen.
const MAX_SIDES: usize = 24;
/// Height of the triangles on the inner polygon, relative to the least height with a second state.
const HEIGHT_RATIO: f64 = 1.4;
/// Rotation of an outer polygon against the inner one's sides, relative to the angle of one side at the centre.
const TWIST_RATIO: f64 = 0.25;
/// Steps of the search for a raised state, in the fold angle of a ring's inner sides. Each step is at most half a
/// degree wide; two states closer than that would be useless as goals.
const SEARCH_STEPS: u32 = 720;
/// Largest angle (radians) from level that still counts as the flat state.
const LEVEL_RAD: f64 = 0.05;
/// Number of bisections of a step, down to the resolution of the numbers.
const HALVINGS: u32 = 60;

impl Kresling {
    /// Returns the pattern with its goal.
    ///
    /// # Errors
    /// If a parameter is out of its range, or there are more rings than have a raised state.
    pub fn drawing(&self) -> Result<Drawing, ParameterError> {
        check_size("rows", self.rows, 1)?;
        check_size("cols", self.columns, 2)?;
        let is_allowed = (4..=MAX_SIDES).contains(&self.columns) && self.columns.is_multiple_of(2);
        let expected = "an even number of sides from 4 to 24";
        check(is_allowed, "cols", number(self.columns), expected)?;
        let mut flat = vec![Vector3::x()];
        let mut raised = flat.clone();
        for _ in 0..self.rows {
            let ring = self.next(flat[flat.len() - 1], raised[raised.len() - 1]);
            let Some((outer, outer_raised)) = ring else {
                return Err(ParameterError {
                    parameter: "rows",
                    expected: "as many rings as have a raised state, which are fewer",
                    found: number(self.rows),
                });
            };
            flat.push(outer);
            raised.push(outer_raised);
        }
        Ok(self.draw(&flat, &raised))
    }

    /// Returns the angle of a side at the centre, radians.
    fn side(&self) -> f64 {
        core::f64::consts::TAU / number(self.columns)
    }

    /// Returns corner k of a polygon whose first corner is given: rotated, and reflected for odd k if `reflects`.
    fn corner(&self, first: Vector3<f64>, k: usize, reflects: bool) -> Vector3<f64> {
        let angle = self.side() * number(k);
        let mut corner = Rotation3::from_axis_angle(&Vector3::z_axis(), angle) * first;
        if reflects && k % 2 == 1 {
            corner.z = -corner.z;
        }
        corner
    }

    /// Returns the first corner of the next polygon, flat and raised, from the first corner of a polygon.
    fn next(
        &self,
        inner: Vector3<f64>,
        inner_raised: Vector3<f64>,
    ) -> Option<(Vector3<f64>, Vector3<f64>)> {
        let half = self.side() / 2.0;
        let radius = inner.norm();
        let height = HEIGHT_RATIO * radius * half.sin() * half.tan();
        let twist = TWIST_RATIO * self.side();
        let outer_radius = (radius * half.cos() + height) / twist.cos();
        let turn = Rotation3::from_axis_angle(&Vector3::z_axis(), half + twist);
        let outer = turn * inner * (outer_radius / radius);

        let [near, far, long] = [
            (outer - inner).norm(),
            (outer - self.corner(inner, 1, false)).norm(),
            (self.corner(outer, 1, false) - outer).norm(),
        ];
        // Circle about the raised inner side on which the corner lies.
        let next = self.corner(inner_raised, 1, true);
        let axis = (next - inner_raised).normalize();
        let side = (next - inner_raised).norm();
        let along = (near * near - far * far + side * side) / (2.0 * side);
        let around = (near * near - along * along).sqrt();
        let centre = inner_raised + axis * along;
        let level = Vector3::new(centre.x, centre.y, 0.0);
        let level = (level - axis * level.dot(&axis)).normalize();
        let up = axis.cross(&level);
        let place = |angle: f64| centre + (level * angle.cos() + up * angle.sin()) * around;
        let excess = |angle: f64| {
            let corner = place(angle);
            (self.corner(corner, 1, true) - corner).norm() - long
        };
        let step = core::f64::consts::TAU / f64::from(SEARCH_STEPS);
        let starts = (0..SEARCH_STEPS).map(|k| (f64::from(k) + 0.5) * step - core::f64::consts::PI);
        let states = starts
            .filter(|start| excess(*start) * excess(start + step) < 0.0)
            .map(|start| {
                let (mut low, mut high) = (start, start + step);
                for _ in 0..HALVINGS {
                    let middle = f64::midpoint(low, high);
                    if excess(low) * excess(middle) <= 0.0 {
                        high = middle;
                    } else {
                        low = middle;
                    }
                }
                low
            });
        let raised = states.filter(|angle| angle.abs() > LEVEL_RAD);
        let gentlest = raised.min_by(|a, b| a.abs().total_cmp(&b.abs()))?;
        Some((outer, place(gentlest)))
    }

    fn draw(&self, flat: &[Vector3<f64>], raised: &[Vector3<f64>]) -> Drawing {
        let n = self.columns;
        let mut drawing = Drawing::default();
        let mut places = Vec::new();
        for (ring, (first, first_raised)) in flat.iter().zip(raised).enumerate() {
            for k in 0..n {
                drawing.vertices.push(self.corner(*first, k, false).xy());
                places.push(self.corner(*first_raised, k, ring > 0));
            }
        }
        let vertex = |ring: usize, k: usize| ring * n + k % n;
        for ring in 0..=self.rows {
            for k in 0..n {
                let side = [vertex(ring, k), vertex(ring, k + 1)];
                if ring == self.rows {
                    drawing.edges.push(DrawnEdge::boundary(side));
                    continue;
                }
                let outer = vertex(ring + 1, k);
                // The apex to the left of the side, towards the centre; the apex to its right is `outer`.
                let inside = match ring {
                    0 => vertex(0, k + 2),
                    _ => vertex(ring - 1, k + 1),
                };
                let before = vertex(ring + 1, k + n - 1);
                for (ends, apexes) in [
                    (side, [inside, outer]),
                    ([side[0], outer], [before, side[1]]),
                    ([side[1], outer], [side[0], vertex(ring + 1, k + 1)]),
                ] {
                    let goal = fold_angle(ends, apexes, &drawing.vertices, &places);
                    drawing.edges.push(crease(ends, goal));
                }
            }
        }
        drawing
    }
}

/// Returns the fold angle (radians) between two triangles, whose apexes lie to the left and right of their common edge in
/// either order, if the vertices are at `places`.
fn fold_angle(
    ends: [usize; 2],
    apexes: [usize; 2],
    flat: &[Vector2<f64>],
    places: &[Vector3<f64>],
) -> f64 {
    let [a, b] = ends;
    let [p, q] = apexes;
    let is_left = |v: usize| (flat[b] - flat[a]).perp(&(flat[v] - flat[a])) > 0.0;
    let (left, right) = if is_left(p) { (p, q) } else { (q, p) };
    let axis = (places[b] - places[a]).normalize();
    let across = |v: usize| {
        let arm = places[v] - places[a];
        arm - axis * axis.dot(&arm)
    };
    // A valley lifts the left side above the plane of the right one.
    let (left, right) = (across(left), across(right));
    axis.dot(&left.cross(&right)).atan2(-left.dot(&right))
}
