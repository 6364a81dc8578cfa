//! Tests generated families whose answer is not a plain plan: sheets that do not fold, and the reasons.

use foldpath::folding::{FoldingMap, Rigidity};
use foldpath::generate::{Kresling, Letters, Quad, Resch, SquareTwist};
use foldpath::pattern::{CreasePattern, Drawing};
use foldpath::planner::{Goal, Outcome, PlanOptions, Symmetry, plan};
use foldpath::symmetry::{CreaseGroups, ReducedStars, closure_of};
use foldpath_core::HalfAngle;
use foldpath_core::closure::{half_angles, residual_and_jacobian};
use nalgebra::{DMatrix, Rotation3, Unit, Vector3};

/// Closure residual below which a sheet is closed except for rounding errors.
const CLOSED: f64 = 1e-9;

fn pattern(drawing: Drawing) -> CreasePattern {
    CreasePattern::new(drawing).unwrap()
}

fn goal_angles(pattern: &CreasePattern) -> Vec<f64> {
    let goals = pattern.creases().iter().map(|&id| pattern.edge(id).goal);
    goals.map(Option::unwrap).collect()
}

fn closure_at(pattern: &CreasePattern, angles: &[f64]) -> f64 {
    let angles: Vec<_> = angles.iter().map(|&angle| Some(angle)).collect();
    closure_of(pattern, &angles).unwrap()
}

/// Returns the outcomes with crease groups and without.
fn outcomes(pattern: &CreasePattern) -> [Outcome; 2] {
    let goal = Goal::of_pattern(pattern).unwrap();
    [Symmetry::Auto, Symmetry::Off].map(|symmetry| {
        let options = PlanOptions::default().with(|it| it.symmetry = symmetry);
        plan(pattern, &goal, &options).outcome
    })
}

/// Returns the worst errors over twenty steps from flat to the goal, with all angles scaled alike.
fn scaled_to_goal(pattern: &CreasePattern) -> Rigidity {
    let tree = pattern.tree();
    let goal = goal_angles(pattern);
    let steps = (0..=20).map(|step| {
        let angles: Vec<f64> = goal.iter().map(|g| g * f64::from(step) / 20.0).collect();
        FoldingMap::new(pattern, tree, &angles).rigidity(pattern, tree)
    });
    steps.fold(Rigidity::default(), Rigidity::worse)
}

fn quad(size: usize) -> CreasePattern {
    let quad = Quad {
        rows: size,
        columns: size,
        fold: 0.0675,
    };
    pattern(quad.drawing().unwrap())
}

/// The report's Quad deforms by at most 0.1 % on the essential crease pattern, and by over 400 % on 24x24.
#[test]
fn quad_deforms_with_its_size() {
    let (small, large) = (quad(3), quad(24));
    for sheet in [&small, &large] {
        let groups = CreaseGroups::find(sheet);
        assert_eq!(groups.len(), 3);
        assert_eq!(
            ReducedStars::all(sheet, &groups)
                .essential()
                .vertices()
                .len(),
            1
        );
    }
    let (small, large) = (scaled_to_goal(&small), scaled_to_goal(&large));
    assert!(small.deformation <= 1e-3, "{small:?}");
    assert!(large.deformation > 4.0, "{large:?}");
    assert_eq!(quad(4).creases().len(), 24 + 16);
}

/// The letters leave no closed configuration within 0.2 radians of the goal. At each vertex two of three families of
/// creases have to stay flat, and the second largest goal angle is above 0.2 radians.
#[test]
fn quad_has_no_closed_configuration_near_its_goal() {
    let sheet = quad(24);
    let mut goal = goal_angles(&sheet);
    assert!(goal.iter().all(|angle| *angle > 0.0), "all valley");
    assert!(closure_at(&sheet, &goal) > 5e-3);
    goal.sort_by(f64::total_cmp);
    goal.dedup_by(|a, b| (*a - *b).abs() < 1e-12);
    assert_eq!(goal.len(), 3);
    assert!(goal[1] > 0.2, "{goal:?}");
    for outcome in outcomes(&sheet) {
        assert_ne!(outcome, Outcome::Planned);
    }
}

/// Returns the misclosure of the corner of a square twist, by matrices. `tangents` are those of half the fold angles of
/// the sides k and k - 1, then of the creases of their pleats.
fn corner_misclosure(alpha: f64, tangents: [f64; 4]) -> f64 {
    let quarter = core::f64::consts::FRAC_PI_2;
    let directions = [alpha, alpha + quarter, -quarter, 0.0];
    let turns = directions.iter().zip(tangents).map(|(direction, tangent)| {
        let axis = Unit::new_normalize(Vector3::new(direction.cos(), direction.sin(), 0.0));
        Rotation3::from_axis_angle(&axis, 2.0 * tangent.atan())
    });
    let turn = turns.fold(Rotation3::identity(), |before, turn| before * turn);
    (turn.matrix() - nalgebra::Matrix3::identity()).norm()
}

#[test]
fn square_twist_folds_with_two_and_two() {
    for (rows, columns) in [(1, 1), (2, 3)] {
        for (degrees, fold) in [(20.0_f64, 0.3), (45.0, 0.9), (60.0, 0.5), (80.0, 0.7)] {
            let twist = SquareTwist {
                rows,
                columns,
                angle: degrees.to_radians(),
                letters: Letters::Foldable,
                fold,
            };
            let sheet = pattern(twist.drawing().unwrap());
            assert_eq!(sheet.real_vertices().count(), 4 * rows * columns);
            let goal = goal_angles(&sheet);
            assert!(closure_at(&sheet, &goal) < CLOSED);
            // All tangents stay in proportion along the motion.
            for part in [0.1, 0.5, 0.9] {
                let angles: Vec<f64> = goal
                    .iter()
                    .map(|angle| 2.0 * (part * (angle / 2.0).tan()).atan())
                    .collect();
                assert!(closure_at(&sheet, &angles) < CLOSED);
            }
            // Neighbouring pleats may meet if the sheet is folded farther.
            if fold <= 0.5 {
                assert_eq!(outcomes(&sheet), [Outcome::Planned; 2], "{degrees}");
            }
        }
    }
}

#[test]
fn square_twist_locks_with_four_alike() {
    for degrees in [20.0_f64, 45.0, 60.0, 80.0] {
        let twist = SquareTwist {
            rows: 1,
            columns: 1,
            angle: degrees.to_radians(),
            letters: Letters::Unfoldable,
            fold: 1.0,
        };
        let many = SquareTwist {
            rows: 2,
            columns: 3,
            ..twist
        };
        let [sheet, many] = [twist, many].map(|twist| pattern(twist.drawing().unwrap()));
        for sheet in [&sheet, &many] {
            assert!(closure_at(sheet, &goal_angles(sheet)) < CLOSED);
        }
        for outcome in outcomes(&sheet) {
            assert_ne!(outcome, Outcome::Planned);
        }
        // With these letters the tangent of each side of a square is τ times that of the side before it, or after it,
        // in the same direction at all corners. A corner does not close in the other direction.
        let tau = (core::f64::consts::FRAC_PI_4 - twist.angle / 2.0).tan();
        for t in [0.1, 1.0, 5.0] {
            assert!(corner_misclosure(twist.angle, [t, tau * t, t, -tau * t]) < CLOSED);
            assert!(corner_misclosure(twist.angle, [tau * t, t, tau * t, -t]) > 0.01);
        }
        assert!(tau.powi(4) < 0.9);
    }
}

/// There are as many conditions as creases. At the goal they are independent, so the goal is isolated.
#[test]
fn kresling_has_a_goal_and_no_motion() {
    for (rows, columns) in [(1, 4), (1, 6), (2, 6), (2, 8), (3, 8), (1, 24)] {
        let sheet = pattern(Kresling { rows, columns }.drawing().unwrap());
        let goal = goal_angles(&sheet);
        assert!(closure_at(&sheet, &goal) < CLOSED, "{rows} {columns}");
        let turned = goal
            .iter()
            .fold(f64::MAX, |least, angle| least.min(angle.abs()));
        assert!(turned > 0.02, "each crease turns: {turned}");

        let groups = CreaseGroups::trivial(&sheet);
        let stars = ReducedStars::all(&sheet, &groups);
        let mut halves = vec![HalfAngle::of(0.0); groups.len()];
        let unknowns = groups.reduce(&goal.iter().map(|g| Some(*g)).collect::<Vec<_>>());
        let unknowns: Vec<f64> = unknowns.into_iter().map(Option::unwrap).collect();
        half_angles(&unknowns, &mut halves);
        let mut jacobian = DMatrix::zeros(3 * stars.vertices().len(), groups.len());
        for (row, star) in stars.view().iter().enumerate() {
            let mut columns = vec![Vector3::zeros(); star.spokes.len()];
            residual_and_jacobian(star, &halves, &mut columns).unwrap();
            for (spoke, column) in star.spokes.iter().zip(columns) {
                let mut place = jacobian.fixed_view_mut::<3, 1>(3 * row, spoke.group.index());
                place += column;
            }
        }
        assert!(jacobian.is_square());
        let singular = jacobian.singular_values();
        assert!(
            singular.min() > 1e-3 * singular.max(),
            "{rows} {columns}: {}",
            singular.min()
        );
        for outcome in outcomes(&sheet) {
            assert_eq!(outcome, Outcome::Partial);
        }
    }
}

/// The goal has its stars tucked below a plane of triangles. With each crease on its own, a motion leads to it.
#[test]
fn resch_closes_to_a_plane() {
    for (rows, columns) in [(1, 1), (1, 4), (3, 2), (3, 3)] {
        let sheet = pattern(Resch { rows, columns }.drawing().unwrap());
        let goal = goal_angles(&sheet);
        assert!(closure_at(&sheet, &goal) < CLOSED);
        // The triangles between stars lie in one plane when the sheet is folded.
        let tree = sheet.tree();
        let map = FoldingMap::new(&sheet, tree, &goal);
        let rigidity = map.rigidity(&sheet, tree);
        assert!(rigidity.gap < CLOSED, "{rigidity:?}");
        assert_eq!(outcomes(&sheet)[1], Outcome::Planned, "{rows} {columns}");
    }
}

#[test]
fn parameters_out_of_range_are_refused() {
    let twist = SquareTwist {
        rows: 1,
        columns: 1,
        angle: 1.0,
        letters: Letters::Foldable,
        fold: 0.5,
    };
    let quad = Quad {
        rows: 3,
        columns: 3,
        fold: 0.05,
    };
    let refused = [
        (
            Quad { rows: 0, ..quad }.drawing(),
            "rows: expected 1 to 3000, found 0",
        ),
        (
            Quad { fold: 0.2, ..quad }.drawing(),
            "fold: expected a fraction above 0 and at most 0.1, found 0.2",
        ),
        (
            SquareTwist {
                columns: 3001,
                ..twist
            }
            .drawing(),
            "cols: expected 1 to 3000, found 3001",
        ),
        (
            SquareTwist { fold: 0.0, ..twist }.drawing(),
            "fold: expected a fraction above 0 and at most 1, found 0",
        ),
        (
            SquareTwist {
                angle: f64::NAN,
                ..twist
            }
            .drawing(),
            "angle: expected 1 to 89 degrees, found NaN",
        ),
        (
            Resch {
                rows: 1,
                columns: 0,
            }
            .drawing(),
            "cols: expected 1 to 3000, found 0",
        ),
        (
            Kresling {
                rows: 1,
                columns: 5,
            }
            .drawing(),
            "cols: expected an even number of sides from 4 to 24, found 5",
        ),
        (
            Kresling {
                rows: 9,
                columns: 6,
            }
            .drawing(),
            "rows: expected as many rings as have a raised state, which are fewer, found 9",
        ),
    ];
    for (drawing, message) in refused {
        assert_eq!(drawing.unwrap_err().to_string(), message);
    }
}
