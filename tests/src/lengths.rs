//! The folded shape by nonlinear least squares on the vertices alone, without rigid motions of faces.
//!
//! A face keeps the distances between its corners and stays plane. A crease keeps the distance between a corner of each
//! of its faces, and the volume of the tetrahedron that these corners span with the crease; its fold angle gives both.
//! The sign of the volume tells a valley from a mountain. The Gauss-Newton method then finds the positions of the
//! vertices. The equations that remain unsolved measure how far the sheet is torn.

use nalgebra::{DMatrix, DVector, Vector3};

use crate::{Random, Sheet, worst};

/// Largest number of Gauss-Newton steps.
const STEPS: usize = 20;
/// Length of a step, over the median edge, after which the iteration ends.
const SETTLED: f64 = 1e-13;
/// Distance by which a vertex is moved before the first step, over its shortest edge.
const SPREAD: f64 = 0.01;
/// Damping added to the diagonal, over its largest entry.
const DAMPING: f64 = 1e-14;

/// One equation, whose error is in median edges.
enum Equation {
    /// The distance between two vertices.
    Distance {
        ends: [usize; 2],
        square: f64,
        scale: f64,
    },
    /// Six times the volume of a tetrahedron.
    Volume {
        corners: [usize; 4],
        volume: f64,
        scale: f64,
    },
}

/// The solution: positions and the error that remains.
pub struct Solved {
    /// Positions of the vertices.
    pub positions: Vec<Vector3<f64>>,
    /// Largest error of an equation, in median edges.
    pub left: f64,
}

impl Sheet {
    /// Returns the shape of these fold angles of the edges (radians) nearest to `near`, whose vertices are first moved
    /// at random; those of face 0 stay. `None` if the normal equations cannot be factorised.
    #[must_use]
    pub fn solved(
        &self,
        angles: &[f64],
        near: &[Vector3<f64>],
        random: &mut Random,
    ) -> Option<Solved> {
        let unit = self.median_edge();
        let equations = self.equations(angles, unit);
        let mut column = vec![None; self.flat.len()];
        let mut free = Vec::new();
        let within: Vec<bool> = (0..self.flat.len())
            .map(|vertex| self.faces.iter().any(|face| face.contains(&vertex)))
            .collect();
        for vertex in 0..self.flat.len() {
            if within[vertex] && !self.faces[0].contains(&vertex) {
                column[vertex] = Some(3 * free.len());
                free.push(vertex);
            }
        }
        let mut positions = near.to_vec();
        let mut shortest = vec![unit; self.flat.len()];
        for &[a, b] in &self.edges {
            let length = (self.flat[a] - self.flat[b]).norm();
            for end in [a, b] {
                shortest[end] = length.min(shortest[end]);
            }
        }
        for &vertex in &free {
            let mut noise = || random.uniform(-1.0, 1.0) * SPREAD * shortest[vertex];
            positions[vertex] += Vector3::new(noise(), noise(), noise());
        }
        if free.is_empty() {
            let left = worst(equations.iter().map(|e| e.error(&positions).0.abs()));
            return Some(Solved { positions, left });
        }
        for _ in 0..STEPS {
            let mut normal = DMatrix::zeros(3 * free.len(), 3 * free.len());
            let mut slope = DVector::zeros(3 * free.len());
            for equation in &equations {
                let (error, parts) = equation.error(&positions);
                for (i, row) in &parts {
                    let Some(at) = column[*i] else { continue };
                    for k in 0..3 {
                        slope[at + k] += row[k] * error;
                    }
                    for (j, other) in &parts {
                        let Some(beside) = column[*j] else { continue };
                        for (k, l) in (0..3).flat_map(|k| (0..3).map(move |l| (k, l))) {
                            normal[(at + k, beside + l)] += row[k] * other[l];
                        }
                    }
                }
            }
            let damping = DAMPING * normal.diagonal().max();
            for k in 0..normal.nrows() {
                normal[(k, k)] += damping;
            }
            let step = normal.cholesky()?.solve(&slope);
            for &vertex in &free {
                let at = column[vertex]?;
                positions[vertex] -= Vector3::new(step[at], step[at + 1], step[at + 2]);
            }
            if step.amax() <= SETTLED * unit {
                break;
            }
        }
        let left = worst(equations.iter().map(|e| e.error(&positions).0.abs()));
        Some(Solved { positions, left })
    }

    fn equations(&self, angles: &[f64], unit: f64) -> Vec<Equation> {
        let mut equations = Vec::new();
        let distance = |a: usize, b: usize| {
            let square = (self.flat[a] - self.flat[b]).norm_squared();
            Equation::Distance {
                ends: [a, b],
                square,
                scale: 2.0 * square.sqrt() * unit,
            }
        };
        for face in &self.faces {
            let base = self.widest(face);
            let area = self.area(base);
            for k in 0..3 {
                equations.push(distance(base[k], base[(k + 1) % 3]));
            }
            for &corner in face.iter().filter(|corner| !base.contains(corner)) {
                equations.extend(base.map(|other| distance(corner, other)));
                equations.push(Equation::Volume {
                    corners: [base[0], base[1], base[2], corner],
                    volume: 0.0,
                    scale: area * unit,
                });
            }
        }
        for (edge, sides) in self.sides.iter().enumerate() {
            let [Some(left), Some(right)] = *sides else {
                continue;
            };
            let [a, b] = self.edges[edge];
            let along = self.flat[b] - self.flat[a];
            let length = along.norm();
            let way = along / length;
            // For each face the corner farthest from the crease: its coordinate along the crease, and its distance from
            // the crease.
            let wing = |face: usize| {
                let seen = self.faces[face].iter().map(|&corner| {
                    let from = self.flat[corner] - self.flat[a];
                    (corner, way.dot(&from), way.cross(&from).z.abs())
                });
                seen.max_by(|p, q| p.2.total_cmp(&q.2))
            };
            let (Some((c, x, height)), Some((d, y, other))) = (wing(left), wing(right)) else {
                continue;
            };
            let (sin, cos) = angles[edge].sin_cos();
            // With the left face in the plane, the corner of the right face lies at -other · cos; a valley lifts it.
            let square = (x - y).powi(2) + (height + other * cos).powi(2) + (other * sin).powi(2);
            equations.push(Equation::Distance {
                ends: [c, d],
                square,
                scale: 2.0 * (height + other) * unit,
            });
            equations.push(Equation::Volume {
                corners: [a, b, c, d],
                volume: length * height * other * sin,
                scale: length * height * unit,
            });
        }
        equations
    }

    /// Returns twice the area of the triangle of three corners.
    fn area(&self, [a, b, c]: [usize; 3]) -> f64 {
        let [p, q, r] = [a, b, c].map(|corner| self.flat[corner]);
        (q - p).cross(&(r - p)).z.abs()
    }

    /// Returns the three corners of a face that span the largest triangle.
    fn widest(&self, face: &[usize]) -> [usize; 3] {
        let n = face.len();
        let threes = (0..n).flat_map(|i| {
            (i + 1..n).flat_map(move |j| (j + 1..n).map(move |k| [face[i], face[j], face[k]]))
        });
        threes
            .max_by(|p, q| self.area(*p).total_cmp(&self.area(*q)))
            .expect("a face has three corners")
    }
}

impl Equation {
    /// Returns the error in median edges, and its derivatives by the positions of its vertices.
    fn error(&self, at: &[Vector3<f64>]) -> (f64, Vec<(usize, Vector3<f64>)>) {
        match *self {
            Self::Distance {
                ends: [a, b],
                square,
                scale,
            } => {
                let way = at[b] - at[a];
                let slope = way * (2.0 / scale);
                let error = (way.norm_squared() - square) / scale;
                (error, vec![(a, -slope), (b, slope)])
            }
            Self::Volume {
                corners: [a, b, c, d],
                volume,
                scale,
            } => {
                let [p, q, r] = [b, c, d].map(|corner| at[corner] - at[a]);
                let slopes = [q.cross(&r), r.cross(&p), p.cross(&q)].map(|slope| slope / scale);
                let error = (p.dot(&q.cross(&r)) - volume) / scale;
                let [to_b, to_c, to_d] = slopes;
                let to_a = -(to_b + to_c + to_d);
                (error, vec![(a, to_a), (b, to_b), (c, to_c), (d, to_d)])
            }
        }
    }
}
