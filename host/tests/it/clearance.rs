//! Tests the clearance of a sheet at rest against closed forms and against all pairs of faces.

use foldpath::collision::{ConvexPiece, Sweep, SweepOptions, SweepVerdict, distance};
use foldpath::folding::FoldingMap;
use foldpath::generate::Waterbomb;
use foldpath::pattern::{CreasePattern, Drawing, DrawnEdge, Letter};
use foldpath_core::{Curve, GroupId, Membership};
use nalgebra::{Vector2, Vector3};

/// Returns a row of unit squares.
fn strip(squares: usize) -> CreasePattern {
    #[allow(clippy::cast_precision_loss, reason = "a few")]
    let corner = |k: usize| Vector2::new((k / 2) as f64, (k % 2) as f64);
    let edge = |a, b, letter| DrawnEdge {
        ends: [a, b],
        letter,
        goal: None,
    };
    let across = (0..=squares).map(|k| {
        let border = k == 0 || k == squares;
        let letter = if border {
            Letter::Boundary
        } else {
            Letter::Valley
        };
        edge(2 * k, 2 * k + 1, letter)
    });
    let along = (0..2 * squares).map(|k| edge(k, k + 2, Letter::Boundary));
    let drawing = Drawing {
        vertices: (0..2 * squares + 2).map(corner).collect(),
        edges: across.chain(along).collect(),
        faces: None,
    };
    CreasePattern::new(drawing).unwrap()
}

/// Returns the smallest distance between faces without a common vertex, at these angles of the creases.
fn clearance(pattern: &CreasePattern, angles: &[f64]) -> Option<f64> {
    let members: Vec<_> = (0..).take(angles.len()).map(alone).collect();
    let still = angles.iter().map(|&angle| Curve::Angle([angle; 4]));
    let mut sweep = Sweep::new(pattern, &members, SweepOptions::default(), None);
    match sweep.sweep(&[still.collect()]) {
        SweepVerdict::Free(nearest) => nearest.map(|nearest| nearest.distance),
        other => panic!("{other:?}"),
    }
}

/// Returns the membership of a crease that is a group of its own.
fn alone(group: u32) -> Membership {
    Membership {
        group: GroupId(group),
        negative: false,
    }
}

/// The outer two of three squares stand up. First they are parallel, then they lean together until their rims meet.
#[test]
fn two_walls_are_as_far_apart_as_their_rims() {
    let pattern = strip(3);
    for degrees in [0.0, 45.0, 90.0, 100.0, 119.0, 119.999, 30.0] {
        let angle = f64::to_radians(degrees);
        // The walls are nearest at their feet until they lean in.
        let expected = (1.0 + 2.0 * angle.cos()).min(1.0);
        let found = clearance(&pattern, &[angle; 2]).unwrap();
        assert!(
            (found - expected).abs() < 1e-12,
            "{degrees}: {found}, {expected}"
        );
    }
    // Two squares share the vertices of their common edge, so there is no clearance.
    let pattern = strip(2);
    assert_eq!(clearance(&pattern, &[0.0]), None);
}

#[test]
fn boxes_leave_out_no_pair_that_is_nearest() {
    let waterbomb = Waterbomb {
        rows: 4,
        columns: 6,
        fold: 0.6,
    };
    let pattern = CreasePattern::new(waterbomb.drawing().unwrap()).unwrap();
    let tree = pattern.tree();
    let goals = pattern
        .creases()
        .iter()
        .map(|&e| pattern.edge(e).goal.unwrap());
    let goals: Vec<f64> = goals.collect();
    for part in [0.0, 0.3, 0.6, 1.0, 0.1] {
        let angles: Vec<f64> = goals.iter().map(|goal| part * goal).collect();
        let map = FoldingMap::new(&pattern, tree, &angles);
        let faces: Vec<_> = pattern.faces().iter().zip(map.poses()).collect();
        let corners = faces.iter().map(|(face, pose)| {
            let corners = face
                .iter()
                .map(|v| pose.apply(pattern.vertices()[v.index()]));
            (corners.collect::<Vec<_>>(), pose.r_wf.rotate(&Vector3::z()))
        });
        let placed: Vec<_> = corners.collect();
        let mut expected = f64::INFINITY;
        for a in 0..faces.len() {
            for b in (0..a).filter(|&b| !faces[a].0.iter().any(|v| faces[b].0.contains(v))) {
                let [a, b] = [&placed[a], &placed[b]].map(|(corners, normal)| ConvexPiece {
                    corners,
                    normal: *normal,
                });
                expected = expected.min(distance(&a, &b));
            }
        }
        let found = clearance(&pattern, &angles).unwrap();
        assert!(
            (found - expected).abs() < 1e-12,
            "{part}: {found}, {expected}"
        );
    }
}
