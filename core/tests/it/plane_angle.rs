//! Is the Jacobian of closure by plane angles and places that of the product of the report's folding matrices? The
//! matrices are multiplied in complex arithmetic: the imaginary part of f(x + ih) over h is f'(x) without cancellation
//! (Squire and Trapp 1998).

use core::ops::{Add, Mul, Neg, Sub};

use foldpath_core::closure::{half_angles, residual_and_jacobian};
use foldpath_core::hole::residuals_and_jacobian;
use foldpath_core::plane_angle::{LoopColumn, loop_columns, star_columns};
use foldpath_core::{HalfAngle, LoopView, LoopsView, Scalar};
use foldpath_test_support::stars::Stars;
use foldpath_test_support::{Random, cast};
use nalgebra::Vector3;

/// Step along the imaginary axis; its square is far below any rounding.
const STEP: f64 = 1e-40;
/// Largest difference of a column, whose entries are of about 1.
const EQUAL: f64 = 1e-12;
const STARS: usize = 10_000;

#[derive(Clone, Copy, Debug, Default)]
struct Complex {
    re: f64,
    im: f64,
}

impl Complex {
    fn real(re: f64) -> Self {
        Self { re, im: 0.0 }
    }

    fn stepped(re: f64) -> Self {
        Self { re, im: STEP }
    }

    /// Cosine and sine, to first order in the imaginary part.
    fn cos_sin(self) -> [Self; 2] {
        let (sin, cos) = self.re.sin_cos();
        let at = |re: f64, slope: f64| Self {
            re,
            im: slope * self.im,
        };
        [at(cos, -sin), at(sin, cos)]
    }

    fn sqrt(self) -> Self {
        let re = self.re.sqrt();
        let im = self.im / (2.0 * re);
        Self { re, im }
    }

    fn over(self, other: Self) -> Self {
        let re = self.re / other.re;
        let im = (self.im - re * other.im) / other.re;
        Self { re, im }
    }
}

impl Add for Complex {
    type Output = Self;
    fn add(self, other: Self) -> Self {
        Self {
            re: self.re + other.re,
            im: self.im + other.im,
        }
    }
}

impl Neg for Complex {
    type Output = Self;
    fn neg(self) -> Self {
        Self {
            re: -self.re,
            im: -self.im,
        }
    }
}

impl Sub for Complex {
    type Output = Self;
    fn sub(self, other: Self) -> Self {
        self + -other
    }
}

impl Mul for Complex {
    type Output = Self;
    fn mul(self, other: Self) -> Self {
        Self {
            re: self.re * other.re - self.im * other.im,
            im: self.re * other.im + self.im * other.re,
        }
    }
}

type Matrix = [[Complex; 4]; 4];

fn times(a: &Matrix, b: &Matrix) -> Matrix {
    let sum =
        |i: usize, j: usize| (0..4).fold(Complex::default(), |sum, k| sum + a[i][k] * b[k][j]);
    core::array::from_fn(|i| core::array::from_fn(|j| sum(i, j)))
}

fn identity() -> Matrix {
    core::array::from_fn(|i| core::array::from_fn(|j| Complex::real(f64::from(u8::from(i == j)))))
}

fn moved_by(x: Complex, y: Complex) -> Matrix {
    let mut matrix = identity();
    matrix[0][3] = x;
    matrix[1][3] = y;
    matrix
}

fn about(axes: [usize; 2], angle: Complex) -> Matrix {
    let [cos, sin] = angle.cos_sin();
    let [a, b] = axes;
    let mut matrix = identity();
    (matrix[a][a], matrix[a][b]) = (cos, -sin);
    (matrix[b][a], matrix[b][b]) = (sin, cos);
    matrix
}

/// A crease with its fold angle.
#[derive(Clone, Copy)]
struct Crease {
    rho: Complex,
    alpha: Complex,
    at: [Complex; 2],
}

/// The folding matrix A B C B⁻¹ A⁻¹.
fn chi(crease: &Crease) -> Matrix {
    let [x, y] = crease.at;
    let factors = [
        about([0, 1], crease.alpha),
        about([1, 2], crease.rho),
        about([0, 1], -crease.alpha),
        moved_by(-x, -y),
    ];
    factors
        .iter()
        .fold(moved_by(x, y), |product, factor| times(&product, factor))
}

/// Rotation 2 sgn(w) (x, y, z) and translation of the product of the folding matrices. The quaternion is taken from its
/// largest component (Shepperd 1978), so that nothing cancels.
fn residuals(creases: &[Crease]) -> [[Complex; 3]; 2] {
    let l = creases
        .iter()
        .fold(identity(), |l, crease| times(&l, &chi(crease)));
    let one = Complex::real(1.0);
    let squares = [
        one + l[0][0] + l[1][1] + l[2][2],
        one + l[0][0] - l[1][1] - l[2][2],
        one - l[0][0] + l[1][1] - l[2][2],
        one - l[0][0] - l[1][1] + l[2][2],
    ];
    let largest = (0..4)
        .max_by(|&a, &b| squares[a].re.total_cmp(&squares[b].re))
        .unwrap();
    // Four times the products of the component with each component.
    let skew = |a: usize, b: usize| l[b][a] - l[a][b];
    let both = |a: usize, b: usize| l[b][a] + l[a][b];
    let products = match largest {
        0 => [squares[0], skew(1, 2), skew(2, 0), skew(0, 1)],
        1 => [skew(1, 2), squares[1], both(0, 1), both(0, 2)],
        2 => [skew(2, 0), both(0, 1), squares[2], both(1, 2)],
        _ => [skew(0, 1), both(0, 2), both(1, 2), squares[3]],
    };
    let four_times = squares[largest].sqrt() * Complex::real(2.0);
    let [w, x, y, z] = products.map(|product| product.over(four_times));
    let sign = Complex::real(if w.re < 0.0 { -2.0 } else { 2.0 });
    [[x, y, z].map(|v| v * sign), [l[0][3], l[1][3], l[2][3]]]
}

/// Derivatives of both residuals by the number that `step` makes complex.
fn derivatives(creases: &[Crease], step: impl Fn(&mut [Crease])) -> [Vector3<f64>; 2] {
    let mut creases = creases.to_vec();
    step(&mut creases);
    residuals(&creases).map(|part| Vector3::from(part.map(|value| value.im / STEP)))
}

fn half(angles: &[f64]) -> Vec<HalfAngle<f64>> {
    let mut half = vec![HalfAngle::default(); angles.len()];
    half_angles(angles, &mut half);
    half
}

fn assert_equal(column: Vector3<f64>, expected: Vector3<f64>, what: &str) {
    let difference = (column - expected).amax();
    assert!(
        difference <= EQUAL,
        "{what}: {column} is not {expected}, by {difference:e}"
    );
}

/// A random star or loop.
struct Case {
    stars: Stars<f64>,
    places: Vec<[f64; 2]>,
    angles: Vec<f64>,
    creases: Vec<Crease>,
}

impl Case {
    fn random(rng: &mut Random, degree: usize, is_loop: bool) -> Self {
        let unknowns = 1 + rng.below(degree);
        let stars = Stars::random(rng, unknowns, &[degree]);
        let angles: Vec<f64> = rng.angles(unknowns);
        let mut place = || match is_loop {
            true => cast([rng.uniform(-1.0, 1.0), rng.uniform(-1.0, 1.0)]),
            false => [0.0; 2],
        };
        let places: Vec<[f64; 2]> = (0..degree).map(|_| place()).collect();
        let spokes = stars.spokes.iter().zip(&places);
        let creases = spokes.map(|(spoke, at)| Crease {
            rho: Complex::real(spoke.fold_angle(&angles)),
            alpha: Complex::real(spoke.direction[1].atan2(spoke.direction[0])),
            at: at.map(Complex::real),
        });
        let creases = creases.collect();
        Self {
            stars,
            places,
            angles,
            creases,
        }
    }
}

fn judge_star(case: &Case) {
    let star = case.stars.view().iter().next().unwrap();
    let mut columns = vec![Vector3::zeros(); case.creases.len()];
    star_columns(star, &half(&case.angles), &mut columns).unwrap();
    let mut by_angle = columns.clone();
    residual_and_jacobian(star, &half(&case.angles), &mut by_angle).unwrap();
    for (k, column) in columns.iter().enumerate() {
        let alpha = case.creases[k].alpha.re;
        let [expected, _] =
            derivatives(&case.creases, |all| all[k].alpha = Complex::stepped(alpha));
        assert_equal(*column, expected, "plane angle");
        // The oracle itself: the column of the fold angle, which other tests judge by differences.
        let rho = case.creases[k].rho.re;
        let [fold, _] = derivatives(&case.creases, |all| all[k].rho = Complex::stepped(rho));
        let sign = if star.spokes[k].negative { -1.0 } else { 1.0 };
        assert_equal(by_angle[k] * sign, fold, "fold angle");
    }
}

fn judge_loop(case: &Case) {
    let Stars {
        spokes,
        ends,
        unknowns,
    } = &case.stars;
    let loops = LoopsView::new(spokes, &case.places, ends, *unknowns).unwrap();
    let cycle = loops.iter().next().unwrap();
    let half = half(&case.angles);
    let mut columns = vec![LoopColumn::default(); spokes.len()];
    loop_columns(cycle, &half, &mut columns).unwrap();
    let mut by_angle = vec![Vector3::zeros(); 2 * spokes.len()];
    residuals_and_jacobian(cycle, &half, &mut by_angle).unwrap();
    for (k, column) in columns.iter().enumerate() {
        let Crease { alpha, at, .. } = case.creases[k];
        let [turn, moves] = derivatives(&case.creases, |all| {
            all[k].alpha = Complex::stepped(alpha.re);
        });
        assert_equal(column.turn, turn, "plane angle of a loop");
        assert_equal(column.turn_moves, moves, "translation by a plane angle");
        let [x, y] = spokes[k].direction;
        let [turn, moves] = derivatives(&case.creases, |all| {
            all[k].at = [
                at[0] - Complex::stepped(0.0) * Complex::real(y),
                at[1] + Complex::stepped(0.0) * Complex::real(x),
            ];
        });
        assert_equal(Vector3::zeros(), turn, "rotation by a place");
        assert_equal(column.shift, moves, "translation by a place");
    }
}

#[test]
fn columns_of_plane_angles_are_those_of_a_product_in_complex_numbers() {
    let mut rng = Random::new(60);
    for (degree, number) in (1..=12).cycle().zip(0..STARS) {
        // Each degree in turn, of twelve stars and then of twelve loops.
        let is_loop = number / 12 % 2 == 1;
        let case = Case::random(&mut rng, degree, is_loop);
        if is_loop {
            judge_loop(&case);
        } else {
            judge_star(&case);
        }
    }
}

fn turning_the_whole_star_turns_its_residual<T: Scalar>() {
    let mut rng = Random::new(61);
    for degree in (1..=12).cycle().take(120) {
        let stars = Stars::<T>::random(&mut rng, degree, &[degree]);
        let angles: Vec<T> = rng.angles(degree);
        let mut half = vec![HalfAngle::default(); degree];
        half_angles(&angles, &mut half);
        let star = stars.view().iter().next().unwrap();
        let mut columns = vec![Vector3::from([T::zero(); 3]); degree];
        star_columns(star, &half, &mut columns).unwrap();
        let sum = columns
            .iter()
            .fold(Vector3::from([T::zero(); 3]), |sum, column| sum + column);
        let residual = foldpath_core::closure::residual(star, &half);
        let normal = Vector3::new(T::zero(), T::zero(), T::one());
        let difference = sum - normal.cross(&residual);
        let rounding = 16.0 * degree as f64 * T::EPSILON.to_f64();
        assert!(difference.iter().all(|d| d.abs().to_f64() <= rounding));
    }
}

#[test]
fn a_star_that_is_turned_as_a_whole_turns_its_residual() {
    turning_the_whole_star_turns_its_residual::<f32>();
    turning_the_whole_star_turns_its_residual::<f64>();
}

#[test]
fn lists_of_another_length_and_missing_groups_have_no_columns() {
    let stars = Stars::<f64>::new(2, &[&[(0.0, 0, false), (90.0, 1, true)]]);
    let star = stars.view().iter().next().unwrap();
    let both = half(&[0.5, 0.25]);
    let places = [[0.0; 2]; 2];
    let cycle = LoopView {
        spokes: star.spokes,
        places: &places,
    };
    for (half, length) in [(&both[..], 1), (&both[..], 3), (&both[..1], 2)] {
        assert!(star_columns(star, half, &mut vec![Vector3::zeros(); length]).is_none());
        assert!(loop_columns(cycle, half, &mut vec![LoopColumn::default(); length]).is_none());
    }
    assert!(star_columns(star, &both, &mut [Vector3::zeros(); 2]).is_some());
    assert!(loop_columns(cycle, &both, &mut [LoopColumn::default(); 2]).is_some());
}
