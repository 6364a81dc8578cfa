//! The relative motion of two panels over a chain of hinges, as a dual quaternion.

use super::polynomial::{Number, Polynomial, Quaternion};
use super::{Hinge, Point};

/// Dual quaternion r + εd, of one degree for each hinge: the pose of the last panel seen from the first, up to a positive
/// factor. It rotates by r and moves by 2 d r* / |r|².
#[derive(Clone, Debug)]
pub(super) struct Chain<T> {
    r: Quaternion<T>,
    d: Quaternion<T>,
}

impl<T: Number> Chain<T> {
    /// Returns the chain over these hinges, from the first panel to the last.
    pub(super) fn new(hinges: &[Hinge]) -> Self {
        let [zero, one] = [0, 1].map(Polynomial::constant);
        let unit = Self {
            r: Quaternion([one, zero.clone(), zero.clone(), zero.clone()]),
            d: Quaternion([zero.clone(), zero.clone(), zero.clone(), zero]),
        };
        hinges.iter().fold(unit, |chain, hinge| {
            let turn = Self::of(hinge);
            Self {
                r: chain.r.times(&turn.r),
                d: chain.r.times(&turn.d).plus(&chain.d.times(&turn.r)),
            }
        })
    }

    /// Returns the rotation about the line of one hinge.
    fn of(hinge: &Hinge) -> Self {
        let of = |numbers: [i64; 2]| Polynomial(numbers.map(T::of).to_vec());
        let [x, y] = hinge.along.map(T::of);
        let [px, py] = hinge.start.map(T::of);
        let moment = px.times(&y).minus(&py.times(&x));
        let (cos, sin) = (of(hinge.cos), of(hinge.sin));
        let zero = || of([0, 0]);
        Self {
            r: Quaternion([
                cos.scaled(&T::of(hinge.length)),
                sin.scaled(&x),
                sin.scaled(&y),
                zero(),
            ]),
            d: Quaternion([zero(), zero(), zero(), sin.scaled(&moment)]),
        }
    }

    /// Returns the pose as matrices, in which all entries have two degrees for each hinge.
    pub(super) fn pose(&self) -> Pose<Polynomial<T>> {
        let turned_back = self.r.conjugate();
        let zero = || Polynomial::constant(0);
        let columns = [1, 2, 3].map(|axis| {
            let mut unit = Quaternion([zero(), zero(), zero(), zero()]);
            unit.0[axis] = Polynomial::constant(1);
            let turned = self.r.times(&unit).times(&turned_back);
            let torn = self.d.times(&unit).times(&turned_back);
            (
                vector(turned),
                vector(torn).map(|part| part.scaled(&T::of(2))),
            )
        });
        let shift = |pose: &Quaternion<T>, back: &Quaternion<T>| {
            vector(pose.times(back)).map(|part| part.scaled(&T::of(2)))
        };
        let [squares, ..] = self.r.times(&turned_back).0;
        let [x, y, z] = columns;
        Pose {
            rotation: [x.0, y.0, z.0],
            moments: [x.1, y.1],
            shift: shift(&self.d, &turned_back),
            shift_back: shift(&self.d.conjugate(), &self.r),
            weight: squares,
        }
    }
}

fn vector<T>(quaternion: Quaternion<T>) -> [Polynomial<T>; 3] {
    let [_, x, y, z] = quaternion.0;
    [x, y, z]
}

/// The pose of one panel seen from another, all entries up to one positive factor.
#[derive(Clone, Debug)]
pub(super) struct Pose<P> {
    /// Columns of the rotation.
    pub(super) rotation: [[P; 3]; 3],
    /// Moments of the lines through the flat origin along x and y.
    pub(super) moments: [[P; 3]; 2],
    pub(super) shift: [P; 3],
    /// Shift of the inverse.
    pub(super) shift_back: [P; 3],
    /// The factor.
    pub(super) weight: P,
}

impl<T: Number> Pose<Polynomial<T>> {
    /// Returns the height of a point of the second panel over the first.
    pub(super) fn height(&self, point: &Point) -> Polynomial<T> {
        let [x, y, _] = &self.rotation;
        combined(&point.map(T::of), [&x[2], &y[2], &self.shift[2]])
    }

    /// Returns the height of a point of the first panel over the second.
    pub(super) fn height_back(&self, point: &Point) -> Polynomial<T> {
        let z = &self.rotation[2];
        combined(&point.map(T::of), [&z[0], &z[1], &self.shift_back[2]])
    }

    /// Returns a polynomial that is zero where the line of an edge of the first panel and that of an edge of the second
    /// are in one plane: the reciprocal product of both lines.
    pub(super) fn passing(&self, first: [&Point; 2], second: [&Point; 2]) -> Polynomial<T> {
        let ([ax, ay, am], [bx, by, bm]) = (line::<T>(first), line::<T>(second));
        let ([x, y, z], [mx, my]) = (&self.rotation, &self.moments);
        let directed = combined(&[bx.clone(), by.clone(), T::of(0)], [&x[2], &y[2], &z[2]]);
        let turned = [0, 1].map(|k| {
            let factors = [bx.clone(), by.clone(), bm.clone()];
            combined(&factors, [&mx[k], &my[k], &z[k]])
        });
        combined(&[ax, ay, am], [&turned[0], &turned[1], &directed])
    }
}

/// Returns the direction of the line through two points of one weight, and its moment about the origin.
fn line<T: Number>(ends: [&Point; 2]) -> [T; 3] {
    let [[ax, ay, weight], [bx, by, _]] = ends.map(|end| end.map(T::of));
    let moment = ax.times(&by).minus(&ay.times(&bx));
    [
        bx.minus(&ax).times(&weight),
        by.minus(&ay).times(&weight),
        moment,
    ]
}

fn combined<T: Number>(factors: &[T; 3], parts: [&Polynomial<T>; 3]) -> Polynomial<T> {
    let [x, y, z] = [0, 1, 2].map(|k: usize| parts[k].scaled(&factors[k]));
    x.plus(&y).plus(&z)
}

impl<T: Number> Pose<Polynomial<T>> {
    /// Returns the pose at a time in units of 2^-`bits`.
    pub(super) fn at(&self, time: i64, bits: u32) -> Placed<T> {
        let [before, after] = [(1 << bits) - time, time].map(T::of);
        let value = |polynomial: &Polynomial<T>| {
            let (mut power, mut sum) = (T::of(1), T::of(0));
            for a in &polynomial.0 {
                sum = sum.times(&before).plus(&a.times(&power));
                power = power.times(&after);
            }
            sum
        };
        let vector = |parts: &[Polynomial<T>; 3]| parts.each_ref().map(value);
        Placed {
            x: vector(&self.rotation[0]),
            y: vector(&self.rotation[1]),
            shift: vector(&self.shift),
            weight: value(&self.weight),
        }
    }
}

/// A pose at one time, up to the factor `weight`.
pub(super) struct Placed<T> {
    pub(super) x: [T; 3],
    pub(super) y: [T; 3],
    pub(super) shift: [T; 3],
    pub(super) weight: T,
}
