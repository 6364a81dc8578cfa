//! Do rotations compose as their matrices do?

use foldpath_core::{HalfAngle, Rotation};
use nalgebra::Vector3;

#[test]
fn composition_matches_matrices_and_the_inverse_undoes() {
    let a = Rotation::about_crease(HalfAngle::of(0.7_f64), [0.6, 0.8]);
    let b = Rotation::about_crease(HalfAngle::of(-1.9), [-1.0, 0.0]);
    let difference = (a * b).matrix() - a.matrix() * b.matrix();
    assert!(difference.abs().max() < 1e-15);
    let across = a.across_crease(HalfAngle::of(-1.9), [-1.0, 0.0]);
    assert!((across.matrix() - a.matrix() * b.matrix()).abs().max() < 1e-15);
    let turned =
        (a * b).rotate_in_sheet([0.3, -2.0]) - (a * b).matrix() * Vector3::new(0.3, -2.0, 0.0);
    assert!(turned.norm() < 1e-15);
    let back = (a * b) * (a * b).inverse();
    assert!((back.w - 1.0).abs() < 1e-15 && back.v.norm() < 1e-15);
}
