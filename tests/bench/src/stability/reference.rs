//! Exact values by other formulas than the code that is judged: 3x3 matrices of 192-bit numbers.

use std::collections::HashMap;

use foldpath::pattern::{CreasePattern, FaceId};

use super::big::Big;

/// A vector.
pub type Vector = [Big; 3];
/// A matrix as its rows.
type Matrix = [Vector; 3];

fn dot(a: &Vector, b: &Vector) -> Big {
    let [x, y, z] = [0, 1, 2].map(|k| &a[k] * &b[k]);
    &(&x + &y) + &z
}

/// Returns the difference of two vectors.
#[must_use]
pub fn minus(a: &Vector, b: &Vector) -> Vector {
    [0, 1, 2].map(|k| &a[k] - &b[k])
}

fn plus(a: &Vector, b: &Vector) -> Vector {
    [0, 1, 2].map(|k| &a[k] + &b[k])
}

/// Returns the length of a vector.
#[must_use]
pub fn length(v: &Vector) -> Big {
    dot(v, v).sqrt()
}

fn identity() -> Matrix {
    [0, 1, 2].map(|i| [0, 1, 2].map(|k| Big::new(f64::from(u8::from(i == k)))))
}

fn apply(matrix: &Matrix, v: &Vector) -> Vector {
    [0, 1, 2].map(|i| dot(&matrix[i], v))
}

fn product(a: &Matrix, b: &Matrix) -> Matrix {
    let columns = [0, 1, 2].map(|k| [0, 1, 2].map(|i| b[i][k].clone()));
    [0, 1, 2].map(|i| [0, 1, 2].map(|k| dot(&a[i], &columns[k])))
}

/// Returns the matrix of a rotation about a unit vector of the sheet's plane (Rodrigues).
fn turn([x, y]: &[Big; 2], [sin, cos]: &[Big; 2]) -> Matrix {
    let versine = &Big::new(1.0) - cos;
    let [xx, xy, yy] = [(x, x), (x, y), (y, y)].map(|(a, b)| &(a * b) * &versine);
    let (sx, sy) = (x * sin, y * sin);
    [
        [cos + &xx, xy.clone(), sy.clone()],
        [xy, cos + &yy, -&sx],
        [-&sy, sx, cos.clone()],
    ]
}

fn unit(direction: [Big; 2]) -> [Big; 2] {
    let [x, y] = &direction;
    let size = (&(x * x) + &(y * y)).sqrt();
    [x / &size, y / &size]
}

/// Returns the closure residual of a star: directions, which are normalised, and fold angles (radians), in order.
///
/// The residual is 2 sgn(w) v of the rotation L. The matrix gives w = √(1 + tr L)/2, and 4 w v is its skew part.
#[must_use]
pub fn residual(spokes: &[([f64; 2], f64)]) -> Vector {
    let turns = spokes.iter().map(|(direction, angle)| {
        turn(&unit(direction.map(Big::new)), &Big::new(*angle).sin_cos())
    });
    let l = turns.fold(identity(), |l, turn| product(&l, &turn));
    let trace = &(&l[0][0] + &l[1][1]) + &l[2][2];
    let twice_w = (&Big::new(1.0) + &trace).sqrt();
    [(2, 1), (0, 2), (1, 0)].map(|(i, k)| &(&l[i][k] - &l[k][i]) / &twice_w)
}

/// Returns the fold angle of a Miura's straight creases, by the closed form. All angles are in radians. A zigzag angle
/// that was rounded to more than half a turn gives a little more than half a turn.
#[must_use]
pub fn straight(sector: &Big, zigzag: &Big) -> Big {
    let two = Big::new(2.0);
    let [sin, cos] = (zigzag / &two).sin_cos();
    let [_, sector_cos] = sector.sin_cos();
    let half = (&(&sector_cos * &sin) / &cos).atan();
    let half = if cos.is_negative() {
        &half + &Big::pi()
    } else {
        half
    };
    &two * &half
}

/// A cache of the sines and cosines of angles.
struct Turns(HashMap<u64, [Big; 2]>);

impl Turns {
    fn of(&mut self, angle: f64) -> [Big; 2] {
        let turn = self.0.entry(angle.to_bits());
        turn.or_insert_with(|| Big::new(angle).sin_cos()).clone()
    }
}

/// A folded sheet.
pub struct Folded {
    /// Corners of each face.
    corners: Vec<Vec<Vector>>,
}

impl Folded {
    /// Folds the sheet of a pattern, with its coordinates as they are, by the fold angles (radians) of its creases;
    /// `None` if the sheet is not connected.
    #[must_use]
    pub fn new(pattern: &CreasePattern, angles: &[f64]) -> Option<Self> {
        let mut turns = Turns(HashMap::new());
        let count = pattern.faces().len();
        let mut poses: Vec<Option<(Matrix, Vector)>> = vec![None; count];
        poses[0] = Some((identity(), [0.0; 3].map(Big::new)));
        let mut open = vec![0];
        let place = |v: usize| {
            let p = pattern.vertices()[v];
            [Big::new(p.x), Big::new(p.y), Big::new(0.0)]
        };
        while let Some(parent) = open.pop() {
            let (r, t) = poses[parent].clone()?;
            for &(face, edge) in &pattern.neighbours()[parent] {
                if poses[face.index()].is_some() {
                    continue;
                }
                let edge = pattern.edge(edge);
                // A valley lifts the face to the left of the direction along the edge.
                let left = edge.faces[0] == Some(FaceId::new(face.index()));
                let [from, to] = if left { [0, 1] } else { [1, 0] }.map(|k| edge.ends[k].index());
                let (pivot, along) = (place(from), minus(&place(to), &place(from)));
                let [x, y, _] = along;
                let angle = edge.crease.map_or(0.0, |crease| angles[crease.index()]);
                let turn = turn(&unit([x, y]), &turns.of(angle));
                let beyond = product(&r, &turn);
                let fixed = plus(&apply(&r, &pivot), &t);
                let moved = minus(&fixed, &apply(&beyond, &pivot));
                poses[face.index()] = Some((beyond, moved));
                open.push(face.index());
            }
        }
        let corners = pattern.faces().iter().zip(&poses).map(|(cycle, pose)| {
            let (r, t) = pose.as_ref()?;
            let corner = |v: &foldpath::pattern::VertexId| plus(&apply(r, &place(v.index())), t);
            Some(cycle.iter().map(corner).collect())
        });
        Some(Self {
            corners: corners.collect::<Option<_>>()?,
        })
    }

    /// Returns the positions of a vertex by all faces round it.
    fn places(&self, pattern: &CreasePattern, vertex: usize) -> Vec<&Vector> {
        let faces = pattern.corners()[vertex].iter();
        let place = |face: &FaceId| {
            let cycle = &pattern.faces()[face.index()];
            let at = cycle.iter().position(|v| v.index() == vertex);
            &self.corners[face.index()][at.expect("a corner of the face")]
        };
        faces.map(place).collect()
    }

    /// Returns the position of a vertex by the first of its faces.
    #[must_use]
    pub fn vertex(&self, pattern: &CreasePattern, vertex: usize) -> &Vector {
        self.places(pattern, vertex)[0]
    }

    /// Returns deformation and gap: the largest relative change of the length of an edge or diagonal, and the largest
    /// distance of two positions of a vertex over the median edge.
    #[must_use]
    pub fn rigidity(&self, pattern: &CreasePattern) -> [f64; 2] {
        let (mut deformation, mut gap) = (0.0_f64, 0.0_f64);
        for vertex in 0..pattern.vertices().len() {
            let places = self.places(pattern, vertex);
            for (k, a) in places.iter().enumerate() {
                for b in &places[..k] {
                    gap = gap.max(length(&minus(a, b)).to_f64());
                }
            }
        }
        for ends in pattern.struts() {
            let [a, b] = ends.map(|end| self.vertex(pattern, end.index()));
            let [p, q] = ends.map(|end| pattern.vertices()[end.index()]);
            let flat = [
                &Big::new(p.x) - &Big::new(q.x),
                &Big::new(p.y) - &Big::new(q.y),
            ];
            let [x, y] = &flat;
            let flat = (&(x * x) + &(y * y)).sqrt();
            let change = &(&length(&minus(a, b)) - &flat) / &flat;
            deformation = deformation.max(change.abs().to_f64());
        }
        [deformation, gap / pattern.median_edge()]
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use foldpath::generate::Miura;

    /// The closed form closes to 128 bits. If a single crease turns, the residual is that of its rotation.
    #[test]
    fn residuals_are_those_of_the_closed_form_and_of_a_single_turn() {
        let pattern = sheet();
        let zigzag = Big::new(2.0);
        let sector = Big::new(60_f64.to_radians());
        let folded = Folded::new(&pattern, &angles(&pattern, &zigzag, &sector)).unwrap();
        let [deformation, gap] = folded.rigidity(&pattern);
        // The angles are rounded to 53 bits, and so are the sheet's coordinates.
        assert!(
            deformation < 1e-14 && gap < 1e-14 && gap > 0.0,
            "{deformation} {gap}"
        );

        let [x, y, z] = residual(&[([0.6, 0.8], 1.0)]).map(|c| c.to_f64());
        let size = 2.0 * 0.5_f64.sin();
        let off = (x - 0.6 * size).abs() + (y - 0.8 * size).abs() + z.abs();
        assert!(off < 1e-15, "{off}");
    }

    /// A sheet that is torn on purpose has a gap.
    #[test]
    fn a_torn_sheet_has_a_gap() {
        let pattern = sheet();
        let mut angles = vec![0.0; pattern.creases().len()];
        angles[3] = 0.5;
        let [_, gap] = Folded::new(&pattern, &angles).unwrap().rigidity(&pattern);
        assert!(gap > 0.1);
    }

    fn sheet() -> CreasePattern {
        let miura = Miura {
            rows: 3,
            columns: 3,
            sector_angle: 60_f64.to_radians(),
            fold: 0.5,
        };
        CreasePattern::new(miura.drawing().unwrap()).unwrap()
    }

    fn angles(pattern: &CreasePattern, zigzag: &Big, sector: &Big) -> Vec<f64> {
        let straight = straight(sector, zigzag).to_f64();
        let edges = pattern.creases().iter().map(|&edge| pattern.edge(edge));
        let angle = |edge: &foldpath::pattern::Edge| {
            let [p, q] = edge.ends.map(|end| pattern.vertices()[end.index()]);
            let level = (p.y - q.y).abs() < 1e-9;
            edge.letter.sign() * if level { straight } else { zigzag.to_f64() }
        };
        edges.map(angle).collect()
    }
}
