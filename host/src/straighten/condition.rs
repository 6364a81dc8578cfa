//! Conditions on the vertices of a drawing, as equations whose left sides are lengths.

use core::f64::consts::PI;

use nalgebra::{Matrix2, Vector2};

use super::Limits;

/// Largest angle (radians) by which the creases round a vertex or hole may miss to fold flat if they are meant to.
const MAX_ANGLE_RAD: f64 = 0.0175;

/// A condition that vertices are meant to fulfil.
#[derive(Clone, Debug, PartialEq)]
pub(super) enum Condition {
    /// A vertex lies on the straight line through two others, once the sheet between them is folded flat.
    InLine {
        ends: [usize; 2],
        at: usize,
        /// The creases (each by its ends) that are crossed on the way from a face at the line to a face at the vertex;
        /// none in the flat sheet.
        creases: Vec<[usize; 2]>,
    },
    /// Two lines, given by two vertices each, are parallel.
    Parallel { lines: [[usize; 2]; 2] },
    /// The creases (each by its ends) that are crossed on the way round a vertex or hole fold flat: the reflections in
    /// them, one after the other, come to nothing. At a vertex this is the condition of T. Kawasaki, "On the relation
    /// between mountain-creases and valley-creases of a flat origami", 1989.
    FoldsFlat {
        creases: Vec<[usize; 2]>,
        /// The middle of the hole; `None` at a vertex, which all creases share.
        hole: Option<Vector2<f64>>,
    },
}

/// An equation: the length by which a condition is missed, and its derivatives by the places of vertices.
#[derive(Clone, Debug, Default)]
pub(super) struct Equation {
    pub(super) off: f64,
    /// No vertex occurs twice.
    pub(super) gradient: Vec<(usize, Vector2<f64>)>,
}

impl Equation {
    fn new(off: f64, terms: impl IntoIterator<Item = (usize, Vector2<f64>)>) -> Self {
        let mut gradient: Vec<(usize, Vector2<f64>)> = terms.into_iter().collect();
        gradient.sort_by_key(|(vertex, _)| *vertex);
        gradient.dedup_by(|(vertex, term), (kept, sum)| {
            let is_same = vertex == kept;
            if is_same {
                *sum += *term;
            }
            is_same
        });
        Self { off, gradient }
    }

    /// Returns the farthest move of a vertex in the least moves that fulfil this equation alone.
    pub(super) fn least_move(&self) -> f64 {
        let squares = self.gradient.iter().map(|(_, term)| term.norm_squared());
        let (sum, most) = squares.fold((0.0, 0.0), |(sum, most): (f64, f64), square| {
            (sum + square, most.max(square))
        });
        self.off.abs() * most.sqrt() / sum
    }
}

impl Condition {
    /// Returns the equations of the condition, for vertices at these places.
    pub(super) fn equations(&self, points: &[Vector2<f64>]) -> Vec<Equation> {
        match self {
            Self::InLine {
                ends: [a, b],
                at,
                creases,
            } => {
                let image = Image::of(points, creases, points[*at]);
                let along = points[*b] - points[*a];
                let from = image.at - points[*a];
                let normal = left_of(along.normalize());
                let part = along.dot(&from) / along.norm_squared();
                let mut terms = image.derivatives(points, creases, normal);
                terms.extend([
                    (*at, image.turned.tr_mul(&normal)),
                    (*a, normal * (part - 1.0)),
                    (*b, normal * -part),
                ]);
                vec![Equation::new(normal.dot(&from), terms)]
            }
            Self::Parallel { lines } => {
                let alongs = lines.map(|[a, b]| points[b] - points[a]);
                let lengths = alongs.map(|along| along.norm());
                let size = lengths[0].min(lengths[1]);
                let [one, other] = alongs.map(|along| along.normalize());
                let angle = one.perp(&other).atan2(one.dot(&other));
                let off = angle - PI * (angle / PI).round();
                let terms = [0, 1].into_iter().flat_map(|k| {
                    let sign = if k == 0 { -size } else { size };
                    turning(points, lines[k]).map(|(vertex, term)| (vertex, sign * term))
                });
                vec![Equation::new(size * off, terms)]
            }
            Self::FoldsFlat { creases, hole } => {
                let mut equations = vec![rotation(points, creases)];
                if let Some(middle) = hole {
                    equations.extend(translation(points, creases, *middle));
                }
                equations
            }
        }
    }

    /// Returns `true` if the vertices were probably meant to fulfil the condition: if no vertex has to move farther than
    /// the reach, and no angle is far off.
    pub(super) fn is_meant(&self, points: &[Vector2<f64>], limits: Limits) -> bool {
        let is_turned = match self {
            Self::FoldsFlat { creases, .. } => angle_off(points, creases).abs() > MAX_ANGLE_RAD,
            _ => false,
        };
        // An equation that holds may have no derivatives: the creases may share the vertex that is to be in line.
        let is_near =
            |it: &Equation| it.off.abs() <= limits.exact || it.least_move() <= limits.reach;
        !is_turned && self.equations(points).iter().all(is_near)
    }

    /// Returns `true` if the condition is that two lines are parallel.
    pub(super) fn is_parallel(&self) -> bool {
        matches!(self, Self::Parallel { .. })
    }

    /// Returns the vertices on which the condition is laid, some more than once.
    pub(super) fn vertices(&self) -> impl Iterator<Item = usize> {
        let (pairs, line): (&[[usize; 2]], _) = match self {
            Self::InLine { ends, at, creases } => (creases, Some([ends[0], ends[1], *at])),
            Self::Parallel { lines } => (lines, None),
            Self::FoldsFlat { creases, .. } => (creases, None),
        };
        let line = line.into_iter().flatten();
        pairs.iter().flatten().copied().chain(line)
    }

    /// Returns the rank in which conditions are given up that contradict others, the first first.
    pub(super) fn rank(&self) -> u8 {
        match self {
            Self::Parallel { .. } => 0,
            Self::InLine { creases, .. } if !creases.is_empty() => 1,
            Self::FoldsFlat { hole: Some(_), .. } => 2,
            Self::FoldsFlat { hole: None, .. } => 3,
            Self::InLine { .. } => 4,
        }
    }
}

fn left_of(direction: Vector2<f64>) -> Vector2<f64> {
    Vector2::new(-direction.y, direction.x)
}

/// Returns the derivatives of a line's angle by its ends.
fn turning(points: &[Vector2<f64>], [a, b]: [usize; 2]) -> [(usize, Vector2<f64>); 2] {
    let along = points[b] - points[a];
    let term = left_of(along) / along.norm_squared();
    [(a, -term), (b, term)]
}

/// Returns the angles of the creases, taken with alternating signs, from the nearest multiple of half a turn.
fn angle_off(points: &[Vector2<f64>], creases: &[[usize; 2]]) -> f64 {
    let signs = [1.0, -1.0].into_iter().cycle();
    let angles = creases.iter().zip(signs).map(|([a, b], sign)| {
        let along = points[*b] - points[*a];
        sign * along.y.atan2(along.x)
    });
    let sum: f64 = angles.sum();
    sum - PI * (sum / PI).round()
}

/// Returns the equation that the reflections in the creases turn nothing.
fn rotation(points: &[Vector2<f64>], creases: &[[usize; 2]]) -> Equation {
    let lengths = creases
        .iter()
        .map(|[a, b]| (points[*b] - points[*a]).norm());
    let size = lengths.fold(f64::INFINITY, f64::min);
    let signs = [size, -size].into_iter().cycle();
    let terms = creases.iter().zip(signs).flat_map(|(crease, sign)| {
        turning(points, *crease).map(|(vertex, term)| (vertex, sign * term))
    });
    Equation::new(size * angle_off(points, creases), terms)
}

/// Returns the equations that the reflections in the creases leave the middle of the hole in its place.
fn translation(
    points: &[Vector2<f64>],
    creases: &[[usize; 2]],
    middle: Vector2<f64>,
) -> [Equation; 2] {
    let image = Image::of(points, creases, middle);
    let off = (image.at - middle) / 2.0;
    // Half the move, so that a crease alone that moves by one unit is off by one unit.
    let along = |axis: Vector2<f64>| image.derivatives(points, creases, axis / 2.0);
    [
        Equation::new(off.x, along(Vector2::x())),
        Equation::new(off.y, along(Vector2::y())),
    ]
}

/// The place to which reflections in creases take a point. The last crease reflects first.
struct Image {
    at: Vector2<f64>,
    /// The reflections without their translations, all together.
    turned: Matrix2<f64>,
    /// For each crease the place that it reflects, and the reflections that follow, without their translations.
    reflected: Vec<(Vector2<f64>, Matrix2<f64>)>,
}

impl Image {
    fn of(points: &[Vector2<f64>], creases: &[[usize; 2]], mut at: Vector2<f64>) -> Self {
        let along = |[a, b]: [usize; 2]| (points[b] - points[a]).normalize();
        let mut turned = Matrix2::identity();
        let mut reflected = Vec::with_capacity(creases.len());
        for &crease in creases {
            reflected.push((Vector2::zeros(), turned));
            let along = along(crease);
            turned *= along * along.transpose() * 2.0 - Matrix2::identity();
        }
        for (&crease, (from, _)) in creases.iter().zip(&mut reflected).rev() {
            *from = at;
            let (start, along) = (points[crease[0]], along(crease));
            at = start + along * (2.0 * along.dot(&(at - start))) - (at - start);
        }
        Self {
            at,
            turned,
            reflected,
        }
    }

    /// Returns the derivatives of the image's component along an axis by the ends of the creases.
    fn derivatives(
        &self,
        points: &[Vector2<f64>],
        creases: &[[usize; 2]],
        axis: Vector2<f64>,
    ) -> Vec<(usize, Vector2<f64>)> {
        let mut terms = Vec::with_capacity(2 * creases.len());
        for (&[a, b], (reflected, after)) in creases.iter().zip(&self.reflected) {
            let along = points[b] - points[a];
            let (length, along) = (along.norm(), along.normalize());
            let normal = left_of(along);
            let from = reflected - points[a];
            // The image moves by `shift` times the move of `a` along the normal, and by `turn` times the angle by which
            // the crease turns.
            let shift = 2.0 * axis.dot(&(after * normal));
            let turn = normal * along.dot(&from) + along * normal.dot(&from);
            let turn = 2.0 * axis.dot(&(after * turn));
            terms.push((a, normal * (shift - turn / length)));
            terms.push((b, normal * (turn / length)));
        }
        terms
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Every derivative is that of central differences, where the condition holds.
    #[test]
    fn derivatives_are_those_of_differences() {
        let points: Vec<Vector2<f64>> = [
            [0.1, 0.2],
            [2.0, 0.3],
            [1.2, 0.9],
            [0.7, 2.6],
            [-0.59, 1.69],
            [1.5, 1.8],
            [2.45, 0.43],
            [1.9, 2.3],
        ]
        .map(Vector2::from)
        .to_vec();
        // The first two are parallel, and so are the last two. They differ in length, as the size of a
        // condition is that of its shortest line.
        let creases = vec![[0, 1], [4, 5], [2, 3], [7, 6]];
        let conditions = [
            Condition::InLine {
                ends: [0, 1],
                at: 2,
                creases: Vec::new(),
            },
            Condition::InLine {
                ends: [0, 1],
                at: 2,
                creases: vec![[7, 6], [2, 3], [4, 5]],
            },
            Condition::Parallel {
                lines: [[0, 1], [5, 4]],
            },
            Condition::FoldsFlat {
                creases: creases.clone(),
                hole: None,
            },
            Condition::FoldsFlat {
                creases,
                hole: Some(Vector2::new(0.9, 1.1)),
            },
        ];
        const STEP: f64 = 1e-6;
        for condition in conditions {
            let equations = condition.equations(&points);
            for vertex in 0..points.len() {
                for axis in 0..2 {
                    let moved = |by: f64| {
                        let mut points = points.clone();
                        points[vertex][axis] += by;
                        condition.equations(&points)
                    };
                    let differences = moved(STEP).into_iter().zip(moved(-STEP));
                    for (equation, (more, less)) in equations.iter().zip(differences) {
                        let terms = equation.gradient.iter().filter(|(it, _)| *it == vertex);
                        let found: f64 = terms.map(|(_, term)| term[axis]).sum();
                        let expected = (more.off - less.off) / (2.0 * STEP);
                        assert!(
                            (found - expected).abs() <= 1e-8,
                            "{condition:?}: {found} {expected}"
                        );
                    }
                }
            }
        }
    }

    /// The middle lines of a window and of the strip in it fold flat if one is as far left of the middle as the other is
    /// right of it.
    #[test]
    fn folds_round_a_hole_are_balanced() {
        let line = |x: f64| [Vector2::new(x, 0.0), Vector2::new(x, 1.0)];
        for off in [0.0, 0.25] {
            let points: Vec<Vector2<f64>> =
                [line(5.0 + off), line(0.0), line(5.0), line(10.0)].concat();
            let condition = Condition::FoldsFlat {
                creases: vec![[0, 1], [2, 3], [4, 5], [6, 7]],
                hole: Some(Vector2::new(5.0, 0.5)),
            };
            let offs: Vec<f64> = condition
                .equations(&points)
                .iter()
                .map(|it| it.off.abs())
                .collect();
            assert!(
                offs.iter()
                    .zip([0.0, off, 0.0])
                    .all(|(a, b)| (a - b).abs() < 1e-14),
                "{offs:?}"
            );
        }
    }
}
