//! Goals that a sheet is known to reach: those of driven creases, whose others rest or follow, and those of sheets whose
//! coordinates are rounded. The known motion is that of the goal which names every crease, or that of the exact sheet.

use core::f64::consts::TAU;
use core::time::Duration;
use std::sync::Arc;

use foldpath::check::{CheckOptions, check};
use foldpath::export::fold::motion_text;
use foldpath::motion::{Claims, Motion};
use foldpath::pattern::{CreaseId, CreasePattern, Drawing, DrawnEdge, Letter};
use foldpath::planner::{Goal, HingeLimit, Note, Outcome, Plan, PlanOptions, Strategy, plan};
use foldpath::read::read_pattern;
use foldpath_tests::{Random, meshes, path_file, pattern_file};
use nalgebra::{Rotation2, Vector2};
use rayon::prelude::*;

/// Time that a plan may take.
const TIMEOUT: Duration = Duration::from_secs(10);
/// Number of sheets of each kind.
const STARS: u64 = 500;
const LINES: u64 = 200;
const MESHES: u64 = 160;
const PHASED: u64 = 40;
const LIMITED: u64 = 40;
const VIA: u64 = 20;

fn options() -> PlanOptions {
    PlanOptions::default().with(|it| it.timeout = Some(TIMEOUT))
}

/// Plans a sheet to its own goal.
fn to_own_goal(pattern: &CreasePattern) -> Plan {
    plan(pattern, &Goal::of_pattern(pattern).unwrap(), &options())
}

/// Returns the same sheet without goal angles, and the goal of these edges driven to theirs.
fn driven(drawing: &Drawing, edges: &[usize]) -> (CreasePattern, Goal) {
    let mut plain = drawing.clone();
    plain.edges.iter_mut().for_each(|edge| edge.goal = None);
    let pattern = CreasePattern::new(plain).unwrap();
    let crease = |&edge: &usize| {
        let id = pattern.creases().iter().position(|id| id.index() == edge);
        (
            CreaseId::new(id.unwrap()),
            drawing.edges[edge].goal.unwrap(),
        )
    };
    let creases: Vec<(CreaseId, f64)> = edges.iter().map(crease).collect();
    let goal = Goal::of_creases(&pattern, &creases).unwrap();
    (pattern, goal)
}

/// Returns `true` if `check` holds a motion.
fn holds(motion: &Motion) -> bool {
    let file = path_file(&motion_text(motion)).unwrap();
    check(&file, &CheckOptions::default()).findings().is_empty()
}

/// Says how many sheets with a known motion were planned, and returns that share.
fn share(what: &str, known: &[(u64, Plan)]) -> f64 {
    let planned = |(_, plan): &&(u64, Plan)| plan.outcome == Outcome::Planned;
    for (seed, plan) in known.iter().filter(|it| !planned(it)) {
        let reason = plan.reason.as_ref().map(ToString::to_string);
        println!("{what} {seed}: {} {reason:?}", plan.outcome.name());
    }
    let count = known.iter().filter(planned).count();
    println!("{count} of {} {what} planned", known.len());
    #[allow(clippy::cast_precision_loss, reason = "small counts")]
    let share = count as f64 / known.len() as f64;
    share
}

/// A star of n creases has n - 3 degrees of freedom. If so many creases beside each other are driven, the other three have
/// at most two ways to follow.
#[test]
fn driven_stars_are_planned_as_their_whole_goals_are() {
    let known: Vec<(u64, Plan)> = (0..STARS)
        .into_par_iter()
        .filter_map(|seed| {
            let mut random = Random::stream(seed, 57);
            let drawing = core::iter::repeat_with(|| meshes::vertex(&mut random))
                .find(|drawing| drawing.vertices.len() > 5)?;
            let motion = to_own_goal(&CreasePattern::new(drawing.clone()).unwrap());
            if motion.outcome != Outcome::Planned || !holds(motion.motion.as_ref()?) {
                return None;
            }
            let edges: Vec<usize> = (0..drawing.vertices.len() - 4).collect();
            let (pattern, goal) = driven(&drawing, &edges);
            let plan = plan(&pattern, &goal, &options());
            let is_planned = plan.outcome == Outcome::Planned;
            assert!(!is_planned || holds(plan.motion.as_ref()?), "star {seed}");
            Some((seed, plan))
        })
        .collect();
    assert!(known.len() > 380, "{}", known.len());
    assert!(share("stars", &known) >= 1.0);
}

/// Six creases of a vertex, mountains and valleys in turn: each of them driven alone, there are closed configurations in which
/// the others turn by their letters, and ones that leave some of them all but flat. The sheet's symmetry is kept: creases of
/// one letter turn alike.
#[test]
fn creases_that_follow_turn_by_their_letters() {
    let rim = (0..6).map(|k| Rotation2::new(f64::from(k) * TAU / 6.0) * Vector2::x());
    let edge = |ends, letter| DrawnEdge {
        ends,
        letter,
        goal: None,
    };
    let borders = (0..6).map(|k| edge([k, (k + 1) % 6], Letter::Boundary));
    let letters = [Letter::Mountain, Letter::Valley].into_iter().cycle();
    let creases = (0..6).zip(letters).map(|(k, letter)| edge([6, k], letter));
    let drawing = Drawing {
        vertices: rim.chain([Vector2::zeros()]).collect(),
        edges: borders.chain(creases).collect(),
        faces: None,
    };
    let pattern = CreasePattern::new(drawing).unwrap();
    for degrees in [-20.0_f64, -60.0, -100.0, 60.0, 100.0] {
        let crease = CreaseId::new(usize::from(degrees > 0.0));
        let goal = Goal::of_creases(&pattern, &[(crease, degrees.to_radians())]).unwrap();
        let plan = plan(&pattern, &goal, &options());
        assert_eq!(plan.outcome, Outcome::Planned, "{degrees}: {plan:?}");
        assert_eq!(plan.arrival.flat_creases, 0, "{degrees}: {plan:?}");
        let motion = plan.motion.unwrap();
        let end = motion.crease_angles(motion.knots.len() - 1);
        let alike = end.iter().skip(crease.index() % 2).step_by(2);
        let off = |angle: &f64, degrees: f64| (angle - degrees.to_radians()).abs();
        for angle in alike {
            assert!(off(angle, degrees) <= 1e-9, "{degrees}: {end:?}");
        }
        // Three creases at 60 degrees close the three flaps between them: the closed form of a vertex of six equal sectors.
        if (degrees.abs() - 60.0).abs() < 1e-9 {
            let flap = end[1 - crease.index() % 2];
            let closed = -180.0 * degrees.signum();
            assert!(off(&flap, closed) <= 1e-5, "{degrees}: {end:?}");
        }
    }
}

/// A line that turns alone is driven alone at once, as with a goal in which all other creases rest.
#[test]
fn lines_that_turn_alone_are_driven_alone() {
    (0..LINES).into_par_iter().for_each(|seed| {
        let mut random = Random::stream(seed, 58);
        let sheet = meshes::line_alone(&mut random);
        let whole = to_own_goal(&CreasePattern::new(sheet.drawing.clone()).unwrap());
        assert_eq!(
            whole.outcome,
            Outcome::Planned,
            "sheet {seed}: {:?}",
            whole.reason
        );
        let edge = sheet.line[random.below(sheet.line.len())];
        let (pattern, goal) = driven(&sheet.drawing, &[edge]);
        let alone = plan(&pattern, &goal, &options());
        assert_eq!(
            alone.outcome,
            Outcome::Planned,
            "sheet {seed}: {:?}",
            alone.reason
        );
        // No other strategy was tried, so that it took as long as with the whole goal.
        let tried: Vec<Strategy> = alone.attempts.iter().map(|it| it.strategy).collect();
        assert_eq!(tried, [Strategy::DrivenAlone], "sheet {seed}");
        let motion = alone.motion.as_ref().unwrap();
        assert!(holds(motion), "sheet {seed}");
        let end = motion.crease_angles(motion.knots.len() - 1);
        for (id, angle) in pattern.creases().iter().zip(end) {
            let asked = sheet.drawing.edges[id.index()].goal.unwrap();
            assert!((asked - angle).abs() < 1e-9, "sheet {seed}, edge {id}");
        }
    });
}

/// Returns a mesh that folds, and the same turned and rounded to 3 or 4 digits.
fn exact_and_rounded(random: &mut Random) -> [Drawing; 2] {
    let mut exact = if random.chance(0.5) {
        meshes::flat_foldable(random)
    } else {
        meshes::strips(random)
    };
    let turn = Rotation2::new(random.uniform(0.0, TAU));
    if random.chance(0.5) {
        exact.vertices.iter_mut().for_each(|at| *at = turn * *at);
    }
    let unit = if random.chance(0.5) { 1e-3 } else { 1e-4 };
    let rounded = meshes::rounded(exact.clone(), unit);
    [exact, rounded]
}

/// The motion of the exact mesh, driven on the rounded one, is a known motion where `check` holds it.
#[test]
fn rounded_meshes_are_planned_where_a_motion_is_known() {
    let known: Vec<(u64, Plan)> = (0..MESHES)
        .into_par_iter()
        .filter_map(|seed| {
            let mut random = Random::stream(seed, 59);
            let [exact, rounded] =
                exact_and_rounded(&mut random).map(|drawing| CreasePattern::new(drawing).unwrap());
            let mut motion = to_own_goal(&exact).motion?;
            motion.pattern = Arc::new(rounded.clone());
            for knot in &mut motion.knots {
                knot.vertices.clear();
                knot.claims = Claims::default();
            }
            if !holds(&motion) {
                return None;
            }
            let plan = to_own_goal(&rounded);
            let is_planned = plan.outcome == Outcome::Planned;
            assert!(!is_planned || holds(plan.motion.as_ref()?), "mesh {seed}");
            Some((seed, plan))
        })
        .collect();
    assert!(known.len() > 120, "{}", known.len());
    assert!(share("meshes", &known) >= 0.98);
}

/// If creases have to turn one after the other, they do when each is driven to its angle, too.
#[test]
fn driven_creases_fold_in_phases() {
    let phases = |plan: &Plan| {
        plan.notes
            .iter()
            .any(|note| matches!(note, Note::Phases(_)))
    };
    let known: Vec<(u64, Plan)> = (0..PHASED)
        .into_par_iter()
        .filter_map(|seed| {
            let drawing = meshes::simple_folds(&mut Random::stream(seed, 60));
            let whole = to_own_goal(&CreasePattern::new(drawing.clone()).unwrap());
            if whole.outcome != Outcome::Planned || !phases(&whole) {
                return None;
            }
            let turned = |edge: &usize| drawing.edges[*edge].goal.is_some_and(|goal| goal != 0.0);
            let edges: Vec<usize> = (0..drawing.edges.len()).filter(turned).collect();
            let (pattern, goal) = driven(&drawing, &edges);
            Some((seed, plan(&pattern, &goal, &options())))
        })
        .collect();
    assert!(known.len() > 5, "{}", known.len());
    assert!(share("sheets folded in phases", &known) >= 1.0);
}

/// Returns the goal of a gate whose flaps are ajar.
fn ajar(random: &mut Random, pattern: &CreasePattern, goal: &Goal) -> Goal {
    let part = random.uniform(0.05, 0.3);
    let angles = goal.fold_angles.iter();
    let angles = angles.map(|angle| angle.map(|angle| part * angle));
    Goal::chosen(pattern, angles.collect(), "ajar".into())
}

/// A goal on the way leaves the search for phases on: a gate whose flaps are both ajar closes one after the other.
#[test]
fn goals_on_the_way_leave_the_search_for_phases_on() {
    for seed in 0..VIA {
        let mut random = Random::stream(seed, 62);
        let pattern = CreasePattern::new(meshes::gate(&mut random)).unwrap();
        let mut goal = Goal::of_pattern(&pattern).unwrap();
        goal.via = vec![ajar(&mut random, &pattern, &goal)];
        let plan = plan(&pattern, &goal, &options());
        assert_eq!(
            plan.outcome,
            Outcome::Planned,
            "sheet {seed}: {:?}",
            plan.reason
        );
        assert!(holds(plan.motion.as_ref().unwrap()), "sheet {seed}");
    }
}

/// Each leg of a motion may need phases of its own: a gate closes, opens again until its flaps are ajar, and closes once more.
#[test]
fn every_leg_folds_in_phases() {
    for seed in 0..VIA {
        let mut random = Random::stream(seed, 64);
        let pattern = CreasePattern::new(meshes::gate(&mut random)).unwrap();
        let goal = Goal::of_pattern(&pattern).unwrap();
        let ajar = ajar(&mut random, &pattern, &goal);
        let goal = Goal {
            via: vec![goal.clone(), ajar],
            ..goal
        };
        let plan = plan(&pattern, &goal, &options());
        assert_eq!(
            plan.outcome,
            Outcome::Planned,
            "sheet {seed}: {:?}",
            plan.reason
        );
        let motion = plan.motion.as_ref().unwrap();
        assert!(holds(motion), "sheet {seed}");
        // Two ends of legs, and a stop on each of the three legs.
        assert_eq!(motion.phases.len(), 5, "sheet {seed}");
    }
}

/// The answer is the attempt that leads farthest by more than a hundredth, also if another one than the first is ended by faces
/// that cross.
#[test]
fn the_farthest_attempt_is_the_answer() {
    let file = pattern_file("pictures/quad-3x3").with_extension("svg");
    let pattern = read_pattern(&file).unwrap().pattern;
    let goal = Goal::of_letters(&pattern, 0.5).unwrap();
    let plan = plan(&pattern, &goal, &options());
    let attempts = plan.attempts.iter().map(|attempt| attempt.reached);
    let farthest = attempts.fold(0.0, f64::max);
    assert!(farthest > plan.attempts[0].reached + 0.1);
    assert!(plan.reached >= farthest - 0.01, "{farthest}: {plan:?}");
}

/// On a sheet whose hinges all turn freely, each goes to its goal, and the one with a limit to its limit.
#[test]
fn a_limit_stops_the_hinge_that_has_it_alone() {
    let stopped = (0..LIMITED).into_par_iter().filter(|&seed| {
        let mut random = Random::stream(seed, 61);
        let pattern = CreasePattern::new(meshes::roll(&mut random)).unwrap();
        let goal = Goal::of_pattern(&pattern).unwrap();
        let crease = random.below(pattern.creases().len());
        let limited = goal.fold_angles[crease].unwrap() / 2.0;
        let options = options().with(|it| {
            it.limits = vec![HingeLimit {
                crease: CreaseId::new(crease),
                lower: limited.min(0.0),
                upper: limited.max(0.0),
            }];
        });
        let plan = plan(&pattern, &goal, &options);
        let stop = plan
            .reason
            .as_ref()
            .map(ToString::to_string)
            .unwrap_or_default();
        if !stop.contains("a hinge is at its limit") {
            // Faces may cross on the way.
            assert!(
                matches!(plan.outcome, Outcome::Crossing(_)),
                "sheet {seed}: {stop}"
            );
            return false;
        }
        let motion = plan.motion.unwrap();
        let end = motion.crease_angles(motion.knots.len() - 1);
        for (index, (angle, asked)) in end.iter().zip(&goal.fold_angles).enumerate() {
            let expected = if index == crease {
                limited
            } else {
                asked.unwrap()
            };
            assert!(
                (angle - expected).abs() < 1e-9,
                "sheet {seed}, crease {index}"
            );
        }
        true
    });
    let stopped = stopped.count();
    println!("{stopped} of {LIMITED} sheets end at the limit");
    assert!(stopped > 10);
}
