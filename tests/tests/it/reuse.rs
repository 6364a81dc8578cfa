//! Is path reuse real? The motion of a sheet of any size must be planned in a few groups at a few vertices, and must be
//! the motion that planning every crease finds.

use foldpath::planner::{Outcome, PlanOptions, Symmetry};
use foldpath_tests::closed_form::miura_straight;
use foldpath_tests::{Planned, goal_angles, worst};

#[test]
fn planning_a_miura_is_the_same_work_for_any_size() {
    let plan = |name: &str| Planned::new(name, &PlanOptions::default()).plan;
    let small = plan("miura-3x3");
    for name in ["miura-5x5", "miura-11x11", "miura-24x24"] {
        let large = plan(name);
        // The mean of many equal goal angles may be off in its last digits, which one more step corrects.
        let more = large.effort.iterations.abs_diff(small.effort.iterations);
        assert!(more <= 1, "{name}: {} iterations", large.effort.iterations);
        let more = large.effort.evaluations.abs_diff(small.effort.evaluations);
        assert!(
            more <= 2,
            "{name}: {} evaluations",
            large.effort.evaluations
        );
        assert_eq!(large.knots().len(), small.knots().len(), "{name}");
        let knots = large.knots().iter().zip(small.knots());
        let angles = knots.flat_map(|(large, small)| large.angles.iter().zip(&small.angles));
        let error = worst(angles.map(|(large, small)| (large - small).abs()));
        // Rounding may move a knot along the motion, but never by a whole step.
        assert!(error <= 1e-6, "{name}: {error:e}");
    }
}

/// Every crease is an unknown of its own. A Miura fold has only one motion, so that both plans must find it.
#[test]
fn planning_every_crease_finds_the_motion_of_the_groups() {
    let every_crease = PlanOptions::default().with(|it| it.symmetry = Symmetry::Off);
    for (name, creases) in [
        ("miura-3x3", 12),
        ("miura-5x5", 40),
        ("miura-11x11", 220),
        ("miura-24x24", 1104),
    ] {
        let grouped = Planned::new(name, &PlanOptions::default()).plan;
        let free = Planned::new(name, &every_crease);
        let (pattern, free) = (&free.file.pattern, &free.plan);
        assert_eq!(free.outcome, Outcome::Planned, "{name}: {:?}", free.reason);
        assert_eq!((grouped.reduced.groups, free.reduced.groups), (2, creases));

        let goals = goal_angles(name);
        let goals = pattern
            .creases()
            .iter()
            .map(|edge| goals[edge.index()].to_radians());
        let goals: Vec<f64> = goals.collect();
        let zigzag = worst(goals.iter().map(|a| a.abs()));
        for (index, knot) in free.knots().iter().enumerate() {
            let memberships = free.motion.as_ref().unwrap().memberships();
            let angles: Vec<f64> = memberships
                .iter()
                .map(|m| m.apply(knot.angles[m.group.index()]))
                .collect();
            let turned = worst(angles.iter().map(|a| a.abs()));
            let straight = miura_straight(60_f64.to_radians(), turned);
            let expected = |goal: f64| {
                let is_zigzag = (goal.abs() - zigzag).abs() < 1e-9;
                goal.signum() * if is_zigzag { turned } else { straight }
            };
            let errors = angles
                .iter()
                .zip(&goals)
                .map(|(angle, &goal)| (angle - expected(goal)).abs());
            let error = worst(errors);
            assert!(error <= 1e-9, "{name}, knot {index}: {error:e}");
        }
        let flat = free.knots()[0].angles.iter().map(|a| a.abs());
        assert!(worst(flat) <= 1e-9);
        assert!(worst([free.arrival.error, grouped.arrival.error]) <= 1e-9);
    }
}
