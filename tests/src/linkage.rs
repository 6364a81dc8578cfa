//! The sheet as a linkage of panels, closed by Gauss-Newton steps on the rigid motions of its faces. Knows nothing of stars,
//! loops round holes or folding maps: faces are joined along a spanning tree of its own, and each other edge has to agree with
//! the faces on both sides in six numbers.

use foldpath::pattern::CreasePattern;
use nalgebra::{
    DMatrix, DVector, Isometry3, Translation3, UnitQuaternion, Vector2, Vector3, Vector6,
};

/// Number of steps; each squares the error.
const STEPS: usize = 12;
/// Length of a step that ends them.
const DONE: f64 = 1e-13;
/// Singular values up to this part of the largest count as 0.
const RANK: f64 = 1e-7;
/// Step of central differences by the pattern: its square and the rounding over it are far below what is asked.
const DIFFERENCE: f64 = 1e-5;

/// An edge between two faces.
struct Joint {
    ends: [usize; 2],
    /// Faces to the left and to the right of the way from the first end to the second.
    faces: [usize; 2],
    /// Position among the creases; `None` if the edge stays flat.
    crease: Option<usize>,
    in_tree: bool,
}

/// Panels and the edges between them.
pub struct Linkage {
    faces: usize,
    joints: Vec<Joint>,
    /// Joints of the tree in the order in which faces are reached, with `true` if the face on the left is.
    tree: Vec<(usize, bool)>,
    creases: usize,
    /// Length that counts as much as a radian.
    pub unit: f64,
}

/// Play of each hinge: turns about the line across the hinge half way between its panels and about their common normal, then
/// shifts along the hinge and along these two. Turns in radians, shifts in units of the linkage.
pub type Play = [f64; 5];

/// A configuration: fold angle and play of each crease.
#[derive(Clone)]
pub struct Shape {
    /// Fold angle of each crease, radians.
    pub angles: Vec<f64>,
    /// Play of each crease.
    pub play: Vec<Play>,
}

/// Closure of all joints off the tree at a shape.
struct Closure {
    residual: DVector<f64>,
    by_angle: DMatrix<f64>,
    by_play: DMatrix<f64>,
}

impl Linkage {
    /// Joins the faces of a sheet.
    ///
    /// # Panics
    /// If the sheet is in several pieces.
    #[must_use]
    pub fn of(pattern: &CreasePattern) -> Self {
        let mut joints = Vec::new();
        for edge in pattern.edges() {
            if let Some(faces) = edge.inner_faces() {
                joints.push(Joint {
                    ends: edge.ends.map(|v| v.index()),
                    faces: faces.map(|f| f.index()),
                    crease: edge.crease.map(|crease| crease.index()),
                    in_tree: false,
                });
            }
        }
        let mut reached = vec![false; pattern.faces().len()];
        reached[0] = true;
        let mut tree = Vec::new();
        loop {
            let next = joints
                .iter()
                .position(|j| reached[j.faces[0]] != reached[j.faces[1]]);
            let Some(next) = next else { break };
            let left = !reached[joints[next].faces[0]];
            reached[joints[next].faces[usize::from(!left)]] = true;
            joints[next].in_tree = true;
            tree.push((next, left));
        }
        assert!(reached.iter().all(|it| *it), "a sheet in one piece");
        Self {
            faces: pattern.faces().len(),
            joints,
            tree,
            creases: pattern.creases().len(),
            unit: pattern.median_edge(),
        }
    }

    /// A shape without play.
    #[must_use]
    pub fn rigid(&self, angles: &[f64]) -> Shape {
        Shape {
            angles: angles.to_vec(),
            play: vec![[0.0; 5]; self.creases],
        }
    }

    /// Frame of a joint in the flat sheet, at its middle: x along it, y to the left.
    fn frame(&self, joint: &Joint, vertices: &[Vector2<f64>]) -> Isometry3<f64> {
        let [a, b] = joint.ends.map(|end| vertices[end]);
        let angle = (b - a).y.atan2((b - a).x);
        Isometry3::from_parts(
            Translation3::from(((a + b) / 2.0).push(0.0)),
            UnitQuaternion::from_axis_angle(&Vector3::z_axis(), angle),
        )
    }

    /// Turn by half the fold angle, then the play, in the frame of a joint: from the right face to the left one.
    fn across(&self, joint: &Joint, shape: &Shape) -> [Isometry3<f64>; 2] {
        let Some(crease) = joint.crease else {
            return [Isometry3::identity(); 2];
        };
        let half = UnitQuaternion::from_axis_angle(&Vector3::x_axis(), shape.angles[crease] / 2.0);
        let [turn_y, turn_z, x, y, z] = shape.play[crease];
        let play = Isometry3::new(
            Vector3::new(x, y, z) * self.unit,
            Vector3::new(0.0, turn_y, turn_z),
        );
        let half = Isometry3::from_parts(Translation3::identity(), half);
        [half, play * half]
    }

    /// Pose of each face.
    fn poses(&self, vertices: &[Vector2<f64>], shape: &Shape) -> Vec<Isometry3<f64>> {
        let mut poses = vec![Isometry3::identity(); self.faces];
        for &(index, left) in &self.tree {
            let joint = &self.joints[index];
            let frame = self.frame(joint, vertices);
            let [half, rest] = self.across(joint, shape);
            let chi = frame * half * rest * frame.inverse();
            let [l, r] = joint.faces;
            if left {
                poses[l] = poses[r] * chi;
            } else {
                poses[r] = poses[l] * chi.inverse();
            }
        }
        poses
    }

    /// Position of each vertex as a face of the list that has it places it, with face `fixed` where it is in the flat sheet.
    #[must_use]
    pub fn places(
        &self,
        pattern: &CreasePattern,
        vertices: &[Vector2<f64>],
        shape: &Shape,
        fixed: usize,
    ) -> Vec<Vector3<f64>> {
        let poses = self.poses(vertices, shape);
        let back = poses[fixed].inverse();
        let mut places = vec![Vector3::zeros(); vertices.len()];
        for (face, corners) in pattern.faces().iter().enumerate() {
            for corner in corners {
                let flat = vertices[corner.index()].push(0.0);
                places[corner.index()] = (back * poses[face] * nalgebra::Point3::from(flat)).coords;
            }
        }
        places
    }

    /// Twists of a joint by its fold angle and its play, in space: turn and velocity of the origin.
    fn twists(&self, joint: &Joint, middle: &Isometry3<f64>) -> [Vector6<f64>; 6] {
        let at = middle.translation.vector;
        let axes = [Vector3::x(), Vector3::y(), Vector3::z()].map(|axis| middle.rotation * axis);
        debug_assert!(joint.crease.is_some());
        let turn = |axis: Vector3<f64>| {
            let v = at.cross(&axis);
            Vector6::new(axis.x, axis.y, axis.z, v.x, v.y, v.z)
        };
        let shift = |axis: Vector3<f64>| {
            let v = axis * self.unit;
            Vector6::new(0.0, 0.0, 0.0, v.x, v.y, v.z)
        };
        let [x, y, z] = axes;
        [turn(x), turn(y), turn(z), shift(x), shift(y), shift(z)]
    }

    fn closure(&self, vertices: &[Vector2<f64>], shape: &Shape) -> Closure {
        let poses = self.poses(vertices, shape);
        // The twists of each face by each joint that leads to it.
        let mut by_face: Vec<Vec<(usize, [Vector6<f64>; 6])>> = vec![Vec::new(); self.faces];
        let own = |joint: &Joint| {
            let frame = self.frame(joint, vertices);
            let [half, _] = self.across(joint, shape);
            self.twists(joint, &(poses[joint.faces[1]] * frame * half))
        };
        for &(index, left) in &self.tree {
            let joint = &self.joints[index];
            let [l, r] = joint.faces;
            let (from, to) = if left { (r, l) } else { (l, r) };
            let mut reached = by_face[from].clone();
            if let Some(crease) = joint.crease {
                let twists = own(joint);
                reached.push((crease, if left { twists } else { twists.map(|t| -t) }));
            }
            by_face[to] = reached;
        }
        let loops: Vec<&Joint> = self.joints.iter().filter(|joint| !joint.in_tree).collect();
        let mut closure = Closure {
            residual: DVector::zeros(6 * loops.len()),
            by_angle: DMatrix::zeros(6 * loops.len(), self.creases),
            by_play: DMatrix::zeros(6 * loops.len(), 5 * self.creases),
        };
        for (row, joint) in loops.into_iter().enumerate() {
            let frame = self.frame(joint, vertices);
            let [half, rest] = self.across(joint, shape);
            let [l, r] = joint.faces;
            let led = poses[r] * frame * half * rest;
            let there = poses[l] * frame;
            let at = there.translation.vector;
            // Turn and shift, at the joint, from where the left face is to where the joint leads.
            let turn = (led.rotation * there.rotation.inverse()).scaled_axis();
            let shift = (led.translation.vector - at) / self.unit;
            let mut rows = closure.residual.rows_mut(6 * row, 6);
            rows.rows_mut(0, 3).copy_from(&turn);
            rows.rows_mut(3, 3).copy_from(&shift);
            let mut add = |crease: usize, twists: &[Vector6<f64>; 6], sign: f64| {
                for (k, twist) in twists.iter().enumerate() {
                    let turn = twist.fixed_rows::<3>(0).into_owned();
                    let moved = (turn.cross(&at) + twist.fixed_rows::<3>(3)) / self.unit;
                    let (matrix, column) = match k {
                        0 => (&mut closure.by_angle, crease),
                        _ => (&mut closure.by_play, 5 * crease + k - 1),
                    };
                    for c in 0..3 {
                        matrix[(6 * row + c, column)] += sign * turn[c];
                        matrix[(6 * row + 3 + c, column)] += sign * moved[c];
                    }
                }
            };
            for (crease, twists) in &by_face[r] {
                add(*crease, twists, 1.0);
            }
            for (crease, twists) in &by_face[l] {
                add(*crease, twists, -1.0);
            }
            if let Some(crease) = joint.crease {
                add(crease, &own(joint), 1.0);
            }
        }
        closure
    }

    /// Largest residual without play.
    #[must_use]
    pub fn residual(&self, vertices: &[Vector2<f64>], angles: &[f64]) -> f64 {
        self.closure(vertices, &self.rigid(angles)).residual.amax()
    }

    /// Closes the sheet without play, by steps of least length that leave the `fixed` creases where they are.
    #[must_use]
    pub fn closed(&self, vertices: &[Vector2<f64>], start: &[f64], fixed: &[usize]) -> Vec<f64> {
        let mut shape = self.rigid(start);
        for _ in 0..STEPS {
            let Closure {
                residual,
                mut by_angle,
                ..
            } = self.closure(vertices, &shape);
            for &crease in fixed {
                by_angle.column_mut(crease).fill(0.0);
            }
            let moves = least(&by_angle, &residual);
            shape
                .angles
                .iter_mut()
                .zip(moves.iter())
                .for_each(|(a, m)| *a -= m);
            if moves.amax() <= DONE {
                break;
            }
        }
        shape.angles
    }

    /// An orthonormal basis of the motions that keep closure, a row for each crease.
    #[must_use]
    pub fn motions(&self, vertices: &[Vector2<f64>], angles: &[f64]) -> DMatrix<f64> {
        complement(
            &self
                .closure(vertices, &self.rigid(angles))
                .by_angle
                .transpose(),
        )
    }

    /// Creases whose angles determine all others at a closed configuration.
    #[must_use]
    pub fn drivers(&self, vertices: &[Vector2<f64>], angles: &[f64]) -> Vec<usize> {
        let mut left = self.motions(vertices, angles);
        let mut drivers = Vec::new();
        for _ in 0..left.ncols() {
            let lengths: Vec<f64> = left.row_iter().map(|row| row.norm()).collect();
            let longest = (0..lengths.len()).max_by(|&a, &b| lengths[a].total_cmp(&lengths[b]));
            let Some(driver) = longest else { break };
            drivers.push(driver);
            let unit = left.row(driver).transpose() / lengths[driver];
            left -= &left * &unit * unit.transpose();
        }
        drivers
    }

    /// Closes the sheet with the least sum of squares of all play, over play and the fold angles of all but the `fixed`
    /// creases. These have to be drivers: a sheet that may move as a whole goes to where it needs least play, as flat.
    #[must_use]
    pub fn closed_with_play(
        &self,
        vertices: &[Vector2<f64>],
        start: &[f64],
        fixed: &[usize],
    ) -> Shape {
        let mut shape = self.rigid(start);
        for _ in 0..STEPS {
            let Closure {
                residual,
                mut by_angle,
                by_play,
            } = self.closure(vertices, &shape);
            for &crease in fixed {
                by_angle.column_mut(crease).fill(0.0);
            }
            let old =
                DVector::from_iterator(5 * self.creases, shape.play.iter().flatten().copied());
            // J dθ + G (s - old) = -r, with the least |s|.
            let right = &by_play * &old - &residual;
            let free = complement(&by_angle);
            let play = least(&(free.transpose() * &by_play), &(free.transpose() * &right));
            let moves = least(&by_angle, &(&right - &by_play * &play));
            shape
                .angles
                .iter_mut()
                .zip(moves.iter())
                .for_each(|(a, m)| *a += m);
            for (own, new) in shape.play.iter_mut().zip(play.as_slice().chunks(5)) {
                own.copy_from_slice(new);
            }
            if moves.amax().max((play - old).amax()) <= DONE {
                break;
            }
        }
        shape
    }

    /// Numbers of independent motions that keep closure if the hinges of `cut` may come apart.
    #[must_use]
    pub fn freedom(&self, vertices: &[Vector2<f64>], angles: &[f64], cut: &[usize]) -> usize {
        let closure = self.closure(vertices, &self.rigid(angles));
        let mut columns: Vec<DVector<f64>> = closure
            .by_angle
            .column_iter()
            .map(|c| c.into_owned())
            .collect();
        for &crease in cut {
            let play = closure.by_play.columns(5 * crease, 5);
            columns.extend(play.column_iter().map(|c| c.into_owned()));
        }
        let matrix = DMatrix::from_columns(&columns);
        matrix.ncols() - rank(&matrix)
    }

    /// A change of the vertices, near the one given, with which the sheet still folds to first order at these angles.
    #[must_use]
    pub fn foldable(
        &self,
        vertices: &[Vector2<f64>],
        angles: &[f64],
        change: &[Vector2<f64>],
    ) -> Vec<Vector2<f64>> {
        let shape = self.rigid(angles);
        let rows = self.closure(vertices, &shape).residual.len();
        let mut by_vertex = DMatrix::zeros(rows, 2 * vertices.len());
        for k in 0..2 * vertices.len() {
            let at = |step: f64| {
                let mut moved = vertices.to_vec();
                moved[k / 2][k % 2] += step * self.unit;
                self.closure(&moved, &shape).residual
            };
            let by = (at(DIFFERENCE) - at(-DIFFERENCE)) / (2.0 * DIFFERENCE * self.unit);
            by_vertex.set_column(k, &by);
        }
        let free = complement(&self.closure(vertices, &shape).by_angle);
        let left = free.transpose() * by_vertex;
        let change =
            DVector::from_iterator(2 * vertices.len(), change.iter().flat_map(|v| [v.x, v.y]));
        let kept = &change - least(&left, &(&left * &change));
        kept.as_slice()
            .chunks(2)
            .map(|v| Vector2::new(v[0], v[1]))
            .collect()
    }
}

/// The number of singular values that are not 0.
fn rank(matrix: &DMatrix<f64>) -> usize {
    let values = matrix.clone().svd(false, false).singular_values;
    let most = values.amax();
    values.iter().filter(|value| **value > RANK * most).count()
}

/// The least solution of least squares.
fn least(matrix: &DMatrix<f64>, right: &DVector<f64>) -> DVector<f64> {
    if matrix.is_empty() {
        return DVector::zeros(matrix.ncols());
    }
    let svd = matrix.clone().svd(true, true);
    let most = svd.singular_values.amax();
    if most <= f64::MIN_POSITIVE {
        return DVector::zeros(matrix.ncols());
    }
    svd.solve(right, RANK * most)
        .expect("both factors were asked for")
}

/// An orthonormal basis of what is orthogonal to the columns of a matrix.
fn complement(matrix: &DMatrix<f64>) -> DMatrix<f64> {
    let rows = matrix.nrows();
    let mut wide = DMatrix::zeros(rows, rows.max(matrix.ncols()));
    wide.columns_mut(0, matrix.ncols()).copy_from(matrix);
    let svd = wide.svd(true, false);
    let u = svd.u.expect("it was asked for");
    let most = svd.singular_values.amax();
    let free: Vec<_> = (0..rows)
        .filter(|&k| svd.singular_values[k] <= RANK * most)
        .map(|k| u.column(k).into_owned())
        .collect();
    if free.is_empty() {
        return DMatrix::zeros(rows, 0);
    }
    DMatrix::from_columns(&free)
}
