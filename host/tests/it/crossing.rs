//! Tests the depth of crossings of two pieces: through each other, in contact, at a side.

use foldpath::collision::{ConvexPiece, crossing_depth, side_crossing_depth};
use nalgebra::Vector3;

fn depth(a: &[[f64; 3]], b: &[[f64; 3]]) -> f64 {
    let corners = |p: &[[f64; 3]]| p.iter().map(|&c| c.into()).collect::<Vec<Vector3<f64>>>();
    let (a, b) = (corners(a), corners(b));
    let piece = |corners: &'static [Vector3<f64>]| ConvexPiece {
        corners,
        normal: (corners[1] - corners[0])
            .cross(&(corners[2] - corners[0]))
            .normalize(),
    };
    crossing_depth(&piece(a.leak()), &piece(b.leak()), 1e-6)
}

const SQUARE: [[f64; 3]; 4] = [[0., 0., 0.], [1., 0., 0.], [1., 1., 0.], [0., 1., 0.]];

#[test]
fn squares_that_cross_along_their_middles_are_found_although_only_borders_meet() {
    let upright = [
        [0.5, 0., -0.5],
        [0.5, 1., -0.5],
        [0.5, 1., 0.5],
        [0.5, 0., 0.5],
    ];
    assert!((depth(&SQUARE, &upright) - 0.5).abs() < 1e-12);
}

#[test]
fn contact_is_no_crossing() {
    // Standing on the square, lying on it, touching it in a corner, sharing a side with it.
    for other in [
        [
            [0.5, 0.2, 0.],
            [0.5, 0.8, 0.],
            [0.5, 0.8, 1.],
            [0.5, 0.2, 1.],
        ],
        [
            [0.2, 0.2, 0.],
            [1.2, 0.2, 0.],
            [1.2, 1.2, 0.],
            [0.2, 1.2, 0.],
        ],
        [[1., 1., 0.], [2., 1., 0.5], [2., 2., 1.], [1., 2., 0.5]],
        [[0., 0., 0.], [1., 0., 0.], [1., 0., 1.], [0., 0., 1.]],
    ] {
        assert!(depth(&SQUARE, &other) <= 0.0, "{other:?}");
    }
}

#[test]
fn a_pair_that_shares_a_corner_crosses_only_if_it_goes_through() {
    let through = [[0., 0., 0.], [1., 1., -1.], [2., 2., 0.5], [1., 1., 1.]];
    let beside = [
        [0., 0., 0.],
        [-1., -1., -1.],
        [-2., -2., 0.5],
        [-1., -1., 1.],
    ];
    assert!(depth(&SQUARE, &through) > 0.5);
    assert!(depth(&SQUARE, &beside) <= 0.0);
}

#[test]
fn a_joint_that_goes_through_is_found_and_one_that_folds_back_is_not() {
    let corners = |p: [[f64; 3]; 4]| p.map(Vector3::from);
    let square = corners(SQUARE);
    let up = corners([[0.5, -1., 0.], [0.5, 2., 0.], [0.5, 2., 1.], [0.5, -1., 1.]]);
    let down = corners([
        [0.5, -1., 0.],
        [0.5, 2., 0.],
        [0.5, 2., -1.],
        [0.5, -1., -1.],
    ]);
    let piece = |corners| ConvexPiece {
        corners,
        normal: Vector3::x(),
    };
    let square = ConvexPiece {
        corners: &square,
        normal: Vector3::z(),
    };
    let side = [up[0], up[1]];
    let beside = [[0.5, 1., 0.], [0.5, 2., 0.]].map(Vector3::from);
    let (up, down) = (piece(&up), piece(&down));
    let depth = |pieces, side| side_crossing_depth(pieces, side, &square, 1e-6);
    assert!((depth([&up, &down], side) - 0.5).abs() < 1e-12);
    assert!(depth([&up, &up], side) <= 0.0);
    assert!(depth([&up, &down], beside) <= 0.0);
}

#[test]
fn a_joint_that_goes_round_the_border_is_no_crossing() {
    let square = SQUARE.map(Vector3::from);
    let square = ConvexPiece {
        corners: &square,
        normal: Vector3::z(),
    };
    // A plane, in two pieces, that rises to the left of x and falls to the right.
    let depth = |x: f64| {
        let at = |k: f64, y: f64| Vector3::new(k, y, 4e-6 * (x - k));
        let left = [at(-1., 0.), at(x, 0.), at(x, 1.), at(-1., 1.)];
        let right = [at(x, 0.), at(3., 0.), at(3., 1.), at(x, 1.)];
        let [left, right] = [&left, &right].map(|corners| ConvexPiece {
            corners,
            normal: Vector3::new(4e-6, 0., 1.).normalize(),
        });
        side_crossing_depth([&left, &right], [at(x, 0.), at(x, 1.)], &square, 1e-6)
    };
    assert!((depth(0.5) - 2e-6).abs() < 1e-12, "{}", depth(0.5));
    assert!(depth(0.999) <= 0.0);
}

#[test]
fn depth_is_measured() {
    let pierced = |z: f64| [[0.4, 0.4, z], [0.4, 0.4, z + 1.], [0.6, 0.6, z + 1.]];
    // The tip is 0.01 below the square; the segment that both share is shorter, and limits the depth.
    let found = depth(&SQUARE, &pierced(-0.01));
    assert!(found > 1e-3 && found <= 0.01, "{found}");
    assert!(depth(&SQUARE, &pierced(-1e-7)) <= 0.0);
}
