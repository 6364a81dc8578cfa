//! Bounds how long the plane through a side of each of two pieces in contact keeps the pieces apart.
//!
//! Two sides may cross in a point and slide along each other. Then no plane that is fixed to a piece separates the pieces
//! for long. The plane that contains both sides does, and turns with them. Seen from one piece, the corners of the other
//! move along parabolas, up to an error of third order. Then the normal of the plane, which is the product of the
//! directions of the two sides, is a polynomial of degree 2 in time, and the height of a corner over the plane one of
//! degree 4, which is never below the least of its Bernstein coefficients.

use nalgebra::Vector3;

use super::crossing::{Allowed, ConvexPiece};
use super::planes::{Change, Moving, Quadratic, Step, Turn, changes_of, turned};
use crate::collision::tolerances::MIN_LEAN;

/// Returns the Bernstein coefficients of the product of two polynomials of degree 2.
fn product(a: &Quadratic, b: &Quadratic) -> [f64; 5] {
    let dot = |i: usize, j: usize| a[i].dot(&b[j]);
    [
        dot(0, 0),
        f64::midpoint(dot(0, 1), dot(1, 0)),
        (dot(0, 2) + 4.0 * dot(1, 1) + dot(2, 0)) / 6.0,
        f64::midpoint(dot(1, 2), dot(2, 1)),
        dot(2, 2),
    ]
}

/// Returns the number of the corner behind another.
fn next(corner: usize, count: usize) -> usize {
    if corner + 1 < count { corner + 1 } else { 0 }
}

/// The planes through a side of a fixed piece and a side of a moving one that separate the pieces.
#[derive(Clone, Debug)]
pub(in crate::collision) struct SidePlanes<'a> {
    /// The turns, in order from the fixed piece.
    turns: &'a [Turn],
    normals: [Vector3<f64>; 2],
    /// Corners of the fixed piece, relative to its first.
    fixed: Vec<Vector3<f64>>,
    moving: Vec<Moving>,
    /// For each plane, the number of the side of each piece, and the sign of the product of their directions that leads
    /// from the fixed piece to the moving one.
    planes: Vec<([usize; 2], f64)>,
}

impl<'a> SidePlanes<'a> {
    /// Returns the planes that have `piece` on one side and `other` on the other, up to contact. The turns lead from
    /// `piece`, which is fixed, to `other`. Cost: O(product of corners).
    pub(in crate::collision) fn of(
        piece: &ConvexPiece<'_>,
        other: &ConvexPiece<'_>,
        turns: &'a [Turn],
        allowed: Allowed,
    ) -> Self {
        let origin = piece.corners[0];
        let mut all = Self {
            turns,
            normals: [piece.normal, other.normal],
            fixed: piece.corners.iter().map(|corner| corner - origin).collect(),
            moving: (other.corners.iter())
                .map(|corner| Moving::new(corner, turns).seen_from(origin))
                .collect(),
            planes: Vec::new(),
        };
        let sides = (0..all.fixed.len()).flat_map(|a| (0..all.moving.len()).map(move |b| [a, b]));
        let planes = sides.flat_map(|sides| all.parting(sides, allowed));
        all.planes = planes.collect();
        all
    }

    /// Returns the planes through a side of each piece that have the pieces on their two sides now: two, if both lie in one.
    fn parting(
        &self,
        [a, b]: [usize; 2],
        allowed: Allowed,
    ) -> impl Iterator<Item = ([usize; 2], f64)> + use<> {
        let [from, to] = [a, next(a, self.fixed.len())].map(|k| self.fixed[k]);
        let ends = [b, next(b, self.moving.len())].map(|k| self.moving[k].at);
        let normal = (to - from).cross(&(ends[1] - ends[0])).normalize();
        let depth = allowed.across_both(
            self.normals
                .map(|of_piece| of_piece.cross(&normal).norm())
                .iter()
                .sum(),
        );
        let range = |[low, high]: [f64; 2], height: f64| [low.min(height), high.max(height)];
        let none = [f64::INFINITY, f64::NEG_INFINITY];
        let height = |at: &Vector3<f64>| normal.dot(&(at - from));
        let fixed = self.fixed.iter().map(height).fold(none, range);
        let moving = self
            .moving
            .iter()
            .map(|corner| height(&corner.at))
            .fold(none, range);
        let apart = [(1.0, moving[0] - fixed[1]), (-1.0, fixed[0] - moving[1])];
        // False for the planes of parallel sides, which have no normal.
        let parting = apart.into_iter().filter(move |(_, apart)| *apart >= -depth);
        parting.map(move |(sign, _)| ([a, b], sign))
    }

    /// Returns `true` if one of the planes keeps the pieces apart, up to contact, while the groups make these changes.
    pub(in crate::collision) fn hold(&self, changes: &[Change], allowed: Allowed) -> bool {
        if self.planes.is_empty() {
            return false;
        }
        let changes = changes_of(self.turns, changes);
        let turn = turned(self.turns, &changes);
        let corners = self.moving.iter();
        let steps: Vec<_> = corners.map(|it| it.step(self.turns, &changes)).collect();
        self.planes
            .iter()
            .any(|plane| self.parts(plane, &steps, turn, allowed))
    }

    /// Returns `true` if a plane has the pieces on its two sides all along a step over which the moving piece turns by
    /// `turn` radians at most.
    fn parts(
        &self,
        &([a, b], sign): &([usize; 2], f64),
        steps: &[Step],
        turn: f64,
        allowed: Allowed,
    ) -> bool {
        let from = self.fixed[a];
        let side = self.fixed[next(a, self.fixed.len())] - from;
        let ends = [b, next(b, steps.len())].map(|k| steps[k].at);
        let along: Quadratic = core::array::from_fn(|k| ends[1][k] - ends[0][k]);
        let normals = along.map(|along| sign * side.cross(&along));
        let [first, ..] = normals;
        let away = normals.map(|normal| (normal - first).norm());
        let away = away.into_iter().fold(0.0, f64::max);
        let least = first.norm() - away;
        // The planes of parallel sides may turn by any angle.
        if least <= MIN_LEAN * side.norm() * along[0].norm() {
            return false;
        }
        let turned = away / least;
        let lean = |piece: usize, turned: f64| {
            let sine = self.normals[piece].cross(&first).norm() / first.norm();
            (sine - turned).max(0.0)
        };
        let depth = allowed.across_both(lean(0, turned) + lean(1, turned + turn));
        let over = self
            .fixed
            .iter()
            .flat_map(|corner| normals.map(|normal| normal.dot(&(corner - from))))
            .fold(0.0, f64::max);
        steps.iter().all(|step| {
            let heights = product(&normals, &step.at.map(|at| at - from));
            let low = heights.into_iter().fold(f64::INFINITY, f64::min) - over;
            let spare = depth - step.error;
            let length = if spare > 0.0 {
                least
            } else {
                first.norm() + away
            };
            low >= -spare * length
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::collision::narrow::crossing::crossing_depth;
    use crate::collision::narrow::planes::rotated;
    use rand_pcg::Pcg64;
    use rand_pcg::rand_core::Rng;

    const WITHIN: f64 = 1e-6;

    /// Returns a random number between -1 and 1.
    fn noise(random: &mut Pcg64) -> f64 {
        f64::from(random.next_u32()) / f64::from(u32::MAX / 2) - 1.0
    }

    fn vector(random: &mut Pcg64) -> Vector3<f64> {
        Vector3::from_fn(|_, _| noise(random))
    }

    /// Returns a quadrilateral with a side through the origin, in a random direction, and its normal.
    fn quadrilateral(random: &mut Pcg64) -> ([Vector3<f64>; 4], Vector3<f64>) {
        let along = vector(random).normalize();
        let normal = along.cross(&vector(random)).normalize();
        let inwards = normal.cross(&along);
        let [before, after] = [(); 2].map(|()| 0.2 + noise(random).abs());
        let deep = 0.2 + noise(random).abs();
        let corners = [
            -before * along,
            after * along,
            after * along + deep * inwards,
            -before * along + deep * inwards,
        ];
        (corners, normal)
    }

    /// Returns a quadrilateral that is smaller by the depth of contact, and a little more for rounding, all round.
    fn smaller(corners: [Vector3<f64>; 4], normal: Vector3<f64>) -> [Vector3<f64>; 4] {
        core::array::from_fn(|k| {
            let [before, at, after] = [3, 0, 1].map(|step| corners[(k + step) % 4]);
            let [left, right] = [at - before, after - at].map(|side| side.normalize());
            let inwards = [left, right].map(|side| normal.cross(&side));
            // In the direction of a side, the offset of the other.
            let along =
                1.01 * WITHIN * (1.0 - inwards[0].dot(&inwards[1])) / inwards[0].dot(&right);
            at + 1.01 * WITHIN * inwards[1] + along * right
        })
    }

    /// Pieces whose sides cross in a point turn about the creases of random chains along random curves. Once they are
    /// smaller by the depth of contact, they are apart at many times of a step over which their planes hold. The planes of
    /// pieces that slide along each other hold for long steps.
    #[test]
    fn pieces_do_not_cross_while_a_plane_through_their_sides_holds() {
        let mut random = Pcg64::new(5, 1);
        let allowed = Allowed {
            within: WITHIN,
            ..Allowed::NOTHING
        };
        let (mut held, mut long, mut crossed) = (0, 0, 0);
        for round in 0..4000 {
            let (a, a_normal) = quadrilateral(&mut random);
            let (b, b_normal) = quadrilateral(&mut random);
            let fixed = ConvexPiece {
                corners: &a,
                normal: a_normal,
            };
            let moving = ConvexPiece {
                corners: &b,
                normal: b_normal,
            };
            let slides = round % 2 == 0;
            let count = if slides { 1 } else { 1 + round % 3 };
            // About the fixed side, or in the plane of both sides through the point that they share, the moving side stays
            // in contact.
            let across = (a[1] - a[0]).cross(&(b[1] - b[0]));
            let turns: Vec<_> = (0..count)
                .map(|k| Turn {
                    group: u32::try_from(k).unwrap(),
                    point: if slides {
                        Vector3::zeros()
                    } else {
                        vector(&mut random)
                    },
                    about: match round % 4 {
                        0 => (a[1] - a[0]).normalize(),
                        2 => across.normalize(),
                        _ => vector(&mut random).normalize(),
                    },
                })
                .collect();
            let planes = SidePlanes::of(&fixed, &moving, &turns, allowed);
            let size = 10_f64.powf(-4.0 * noise(&mut random).abs());
            let changes: Vec<_> = (0..count)
                .map(|_| Change {
                    by: size * noise(&mut random),
                    off: size * size * noise(&mut random).abs() * 1e-3,
                })
                .collect();
            let holds = planes.hold(&changes, allowed);
            held += u32::from(holds);
            long += u32::from(holds && slides && changes[0].by.abs() > 5e-3);
            for sample in 0..=40 {
                let part = f64::from(sample) / 40.0;
                let angle = |change: &Change| part * change.by + noise(&mut random) * change.off;
                let angles: Vec<_> = changes.iter().map(angle).collect();
                let corners = b.map(|corner| rotated(&turns, &angles, &corner));
                let normal = (corners[1] - corners[0])
                    .cross(&(corners[2] - corners[1]))
                    .normalize();
                let [a, b] = [(a, a_normal), (corners, normal)]
                    .map(|(corners, normal)| (smaller(corners, normal), normal));
                let [a, b] = [&a, &b].map(|(corners, normal)| ConvexPiece {
                    corners,
                    normal: *normal,
                });
                let depth = crossing_depth(&a, &b, 1e-12);
                crossed += u32::from(depth > 0.0);
                assert!(!holds || depth <= 0.0, "{round} at {part}: {depth:e}");
            }
        }
        assert!(
            held > 500 && long > 100 && crossed > 5000,
            "{held} {long} {crossed}"
        );
    }
}
