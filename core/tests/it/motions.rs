//! Does `project_on_motions` project on the null space of the Jacobian? The foldings have one degree of freedom, whose
//! tangent is known in closed form.

use foldpath_core::closure::{half_angles, residual_and_jacobian};
use foldpath_core::least_squares::ClosureProblem;
use foldpath_core::levenberg_marquardt::project_on_motions;
use foldpath_core::{DenseNormalEquations, HalfAngle, Scalar, norm};
use foldpath_test_support::stars::{Stars, miura, miura_angles, waterbomb, waterbomb_angles};
use foldpath_test_support::{Random, cast};
use nalgebra::Vector3;

/// Returns the unit tangent of the curve `path` at `t`, to about 1e-10.
fn tangent<const N: usize>(path: impl Fn(f64) -> [f64; N], t: f64) -> [f64; N] {
    let h = f64::EPSILON.cbrt();
    let (before, after) = (path(t - h), path(t + h));
    let chord: [f64; N] = core::array::from_fn(|i| after[i] - before[i]);
    let length = chord.iter().map(|c| c * c).sum::<f64>().sqrt();
    chord.map(|c| c / length)
}

fn project<T: Scalar>(stars: &Stars<T>, x: &[T], direction: &mut [T]) {
    let n = stars.unknowns;
    let view = stars.view();
    let mut half = vec![HalfAngle::default(); n];
    let mut columns = vec![Vector3::repeat(T::zero()); view.max_degree()];
    let mut problem = ClosureProblem::new(view, &mut half, &mut columns).unwrap();
    let mut memory = vec![T::zero(); DenseNormalEquations::<T>::memory(n)];
    let mut equations = DenseNormalEquations::new(n, &mut memory).unwrap();
    problem.linearise(x, &mut equations);
    assert!(project_on_motions(&mut equations, direction));
}

/// Returns the largest ‖J d‖ of a star.
fn velocity<T: Scalar>(stars: &Stars<T>, x: &[T], direction: &[T]) -> f64 {
    let mut half = vec![HalfAngle::default(); x.len()];
    half_angles(x, &mut half);
    let velocities = stars.view().iter().map(|star| {
        let mut columns = vec![Vector3::repeat(T::zero()); star.spokes.len()];
        residual_and_jacobian(star, &half, &mut columns).unwrap();
        let spokes = star.spokes.iter().zip(&columns);
        let moved = spokes.map(|(spoke, column)| column * direction[spoke.group.index()]);
        norm(&moved.fold(Vector3::repeat(T::zero()), |sum, v| sum + v)).to_f64()
    });
    velocities.fold(0.0, f64::max)
}

/// At points of a path with one degree of freedom and unit tangent τ, the projection of d is (τ·d) τ.
fn projects_on_the_tangent<T: Scalar, const N: usize>(
    stars: &Stars<T>,
    path: impl Fn(f64) -> [f64; N],
    parameters: impl Iterator<Item = f64>,
) {
    let mut rng = Random::new(41);
    // Rounding leaves √ε. Damping leaves (λ/σ²)², which is at most 140²ε: for a waterbomb at t = 1 the squared singular
    // value σ² is 1/140 of the largest diagonal entry. In `f32` 140²ε is 7√ε.
    let tolerance = 8.0 * T::EPSILON.to_f64().sqrt();
    for t in parameters {
        let x: [T; N] = cast(path(t));
        let tangent = tangent(&path, t);
        let random: [f64; N] = core::array::from_fn(|_| rng.uniform(-0.5, 0.5));
        for direction in [random, tangent].map(cast::<T, N>) {
            let length: f64 = direction
                .iter()
                .zip(tangent)
                .map(|(d, t)| d.to_f64() * t)
                .sum();
            let mut projected = direction;
            project(stars, &x, &mut projected);
            for (projected, tangent) in projected.iter().zip(tangent) {
                let error = (projected.to_f64() - length * tangent).abs();
                assert!(
                    error <= tolerance,
                    "{error:e} at {t}: {direction:?} {projected:?}"
                );
            }
            assert!(velocity(stars, &x, &projected) <= tolerance);
        }
    }
}

fn on_known_paths<T: Scalar>() {
    let steps = || (1..=20).map(|step| f64::from(step) / 20.0);
    for sector in [30.0, 60.0] {
        let path = |major| miura_angles(sector, major);
        projects_on_the_tangent::<T, 2>(
            &miura(sector, false, false),
            path,
            steps().map(|s| 3.0 * s),
        );
    }
    // Near flat the singular values vanish with t, so that rounding in `f32` hides the null space.
    let steps = steps().filter(|&t| t >= 0.3);
    projects_on_the_tangent::<T, 4>(&waterbomb(), waterbomb_angles, steps);
}

#[test]
fn projection_is_the_part_along_the_motion() {
    on_known_paths::<f32>();
    on_known_paths::<f64>();
}
