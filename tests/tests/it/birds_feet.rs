//! Single vertices against the bird's foot theorem: a vertex leaves flat with all its creases turned along their letters
//! if, and only if, three creases of one letter are less than half a turn apart from each other all round, and another
//! crease has the other letter; or creases in line form a cross, which random directions never do.
//!
//! Source: Z. Abel, J. Cantarella, E. Demaine, D. Eppstein, T. Hull, J. Ku, R. Lang, T. Tachi, "Rigid origami vertices:
//! conditions and forcing sets", Journal of Computational Geometry 7(1), 2016.

use core::f64::consts::{PI, TAU};

use foldpath::generate::{Letters, SquareTwist};
use foldpath::pattern::{CreasePattern, Drawing, DrawnEdge, Letter};
use foldpath::planner::{
    CauseKind, Foldability, Goal, Outcome, PlanOptions, Reason, Strategy, forecast, plan,
};
use foldpath::progress::Watch;
use foldpath::symmetry::CreaseGroups;
use foldpath_tests::Random;
use foldpath_tests::campaign::Family;
use nalgebra::Vector2;

/// Angle by which sectors and half turns are told apart, radians: nearer ones are within the bound of a plan.
const CLEAR: f64 = 0.1;

/// Directions of 4 to 8 creases, counter-clockwise, and their letters.
fn vertex(random: &mut Random) -> (Vec<f64>, Vec<Letter>) {
    let count = random.whole(4, 8);
    loop {
        let mut ways: Vec<f64> = (0..count).map(|_| random.uniform(0.0, TAU)).collect();
        ways.sort_by(f64::total_cmp);
        let sector = |k: usize| (ways[(k + 1) % count] - ways[k]).rem_euclid(TAU);
        if (0..count).all(|k| (CLEAR..PI - CLEAR).contains(&sector(k))) {
            let letter = |_| {
                if random.chance(0.5) {
                    Letter::Mountain
                } else {
                    Letter::Valley
                }
            };
            let letters = (0..count).map(letter).collect();
            return (ways, letters);
        }
    }
}

/// Returns `Some(true)` if there is a bird's foot, `None` if that depends on a sector that is half a turn but for little.
fn has_foot(ways: &[f64], letters: &[Letter]) -> Option<bool> {
    let mut unclear = false;
    for letter in [Letter::Mountain, Letter::Valley] {
        let toes: Vec<f64> = (ways.iter().zip(letters))
            .filter(|(_, l)| **l == letter)
            .map(|(way, _)| *way)
            .collect();
        if toes.len() == ways.len() {
            continue;
        }
        for a in 0..toes.len() {
            for b in a + 1..toes.len() {
                for c in b + 1..toes.len() {
                    let sectors = [
                        toes[b] - toes[a],
                        toes[c] - toes[b],
                        toes[a] + TAU - toes[c],
                    ];
                    let widest = sectors.into_iter().fold(0.0, f64::max);
                    if widest < PI - CLEAR {
                        return Some(true);
                    }
                    unclear |= widest < PI + CLEAR;
                }
            }
        }
    }
    (!unclear).then_some(false)
}

fn drawn(ways: &[f64], letters: &[Letter]) -> CreasePattern {
    let rim = ways.iter().map(|way| Vector2::new(way.cos(), way.sin()));
    let count = ways.len();
    let spoke = |k: usize| DrawnEdge {
        ends: [0, k + 1],
        letter: letters[k],
        goal: None,
    };
    let side = |k: usize| DrawnEdge {
        ends: [k + 1, (k + 1) % count + 1],
        letter: Letter::Boundary,
        goal: None,
    };
    let drawing = Drawing {
        vertices: core::iter::once(Vector2::zeros()).chain(rim).collect(),
        edges: (0..count).map(spoke).chain((0..count).map(side)).collect(),
        faces: None,
    };
    CreasePattern::new(drawing).unwrap()
}

#[test]
fn vertices_leave_flat_if_they_have_a_birds_foot() {
    let mut random = Random::new(1);
    let [mut feet, mut folded, mut without] = [0; 3];
    for index in 0..1000 {
        let (ways, letters) = vertex(&mut random);
        let Some(foot) = has_foot(&ways, &letters) else {
            continue;
        };
        let pattern = drawn(&ways, &letters);
        let goal = Goal::of_letters(&pattern, 0.1).unwrap();
        let planned = plan(&pattern, &goal, &PlanOptions::default());
        let planned = planned.outcome == Outcome::Planned;
        let groups = CreaseGroups::find(&pattern);
        let foreseen = forecast(&pattern, &groups, Watch::default()).foldability;
        if foot {
            feet += 1;
            folded += usize::from(planned);
            assert_ne!(foreseen, Foldability::No, "{index}: {ways:?} {letters:?}");
        } else {
            without += 1;
            assert!(!planned, "{index}: {ways:?} {letters:?}");
            assert_ne!(
                foreseen,
                Foldability::Likely,
                "{index}: {ways:?} {letters:?}"
            );
        }
    }
    println!("{folded} of {feet} vertices with a bird's foot planned, none of {without} without");
    assert!(feet > 300 && without > 200, "{feet} {without}");
    // The nearest configuration in which no crease stays flat may not be reached from flat, and in some vertices a crease
    // turns by less than a tenth of the angle asked for while another one turns by all of it.
    assert!(100 * folded >= 91 * feet, "{folded} of {feet}");
}

/// A flap beside a vertex that is locked turns alone: its crease runs from border to border.
#[test]
fn a_flap_turns_beside_a_locked_vertex() {
    let mut random = Random::new(2);
    let (mut locked, mut turned) = (0, 0);
    while locked < 100 {
        let (ways, letters) = vertex(&mut random);
        if has_foot(&ways, &letters) != Some(false) {
            continue;
        }
        locked += 1;
        let (count, star) = (ways.len(), drawn(&ways, &letters));
        let tip = 1.5 * (star.vertices()[1] + star.vertices()[2]);
        let mut vertices = star.vertices().to_vec();
        vertices.push(tip);
        let mut edges: Vec<DrawnEdge> = star
            .edges()
            .iter()
            .map(|edge| DrawnEdge {
                ends: edge.ends.map(|end| end.index()),
                letter: edge.letter,
                goal: None,
            })
            .collect();
        edges[count].letter = Letter::Valley;
        for end in [1, 2] {
            edges.push(DrawnEdge {
                ends: [end, count + 1],
                letter: Letter::Boundary,
                goal: None,
            });
        }
        let pattern = CreasePattern::new(Drawing {
            vertices,
            edges,
            faces: None,
        })
        .unwrap();
        let flap = pattern.edges()[count].crease.unwrap();
        let driven = Goal::of_creases(&pattern, &[(flap, 1.0)]).unwrap();
        let driven = plan(&pattern, &driven, &PlanOptions::default());
        assert_eq!(driven.outcome, Outcome::Planned, "{ways:?} {letters:?}");
        // Along the letters the flap turns about as far as is asked, and the creases of the vertex are named as flat.
        let letters = Goal::of_letters(&pattern, 0.4).unwrap();
        let plan = plan(&pattern, &letters, &PlanOptions::default());
        let falls_short =
            |outcome: Outcome| matches!(outcome, Outcome::NearGoal | Outcome::Partial);
        if !matches!(plan.reason, Some(Reason::NearGoal { .. })) {
            // The bound lets the vertex turn a little, all together by more than the flap.
            let tried = plan
                .attempts
                .iter()
                .map(|tried| (tried.strategy, tried.outcome));
            let alone =
                |(strategy, outcome)| strategy == Strategy::LinesAlone && falls_short(outcome);
            assert!(tried.into_iter().any(alone), "{ways:?}");
            continue;
        }
        turned += 1;
        assert_eq!(plan.arrival.flat_creases, count, "{ways:?}");
        let motion = plan.motion.as_ref().unwrap();
        let end = motion.node(motion.knots.len() - 1, pattern.creases()[flap.index()]);
        let far = (0.3 * PI..0.401 * PI).contains(&end.angle);
        assert!(far, "{ways:?}: {}", end.angle);
    }
    assert!(turned >= 85, "{turned}");
}

/// Twists whose letters lock them: each of the four corners has the ratio τ = tan(π/4 - α/2), or all of them 1/τ. Twists
/// and other networks of vertices with four creases that fold are not said to be locked.
#[test]
fn loops_of_modes_lock_and_are_named() {
    let locked = |pattern: &CreasePattern| {
        let groups = CreaseGroups::find(pattern);
        let causes = forecast(pattern, &groups, Watch::default()).causes;
        causes.into_iter().find_map(|cause| match cause.kind {
            CauseKind::LockedLoop(product) => Some((product, cause)),
            _ => None,
        })
    };
    for degrees in [10.0_f64, 30.0, 45.0, 62.0] {
        let angle = degrees.to_radians();
        for letters in [Letters::Foldable, Letters::Unfoldable] {
            let twist = SquareTwist {
                rows: 1,
                columns: 1,
                angle,
                letters,
                fold: 0.5,
            };
            let pattern = CreasePattern::new(twist.drawing().unwrap()).unwrap();
            let found = locked(&pattern);
            if letters == Letters::Foldable {
                assert!(found.is_none(), "{degrees}: {found:?}");
                continue;
            }
            let (product, cause) = found.expect("a loop");
            let expected = 4.0 * (PI / 4.0 - angle / 2.0).tan().ln();
            let off = (product.ln().abs() - expected.abs()).abs();
            assert!(off < 1e-9, "{degrees}: {product}");
            assert_eq!(
                (cause.vertices.len(), cause.edges.len()),
                (4, 12),
                "{degrees}"
            );
        }
    }
    for name in ["strips", "flat-foldable", "wide"] {
        let family = Family::ALL
            .iter()
            .find(|family| family.name == name)
            .unwrap();
        let count = if name == "wide" { 20 } else { 150 };
        for seed in 0..count {
            let pattern = CreasePattern::new(family.sheet(seed)).unwrap();
            let found = locked(&pattern);
            assert!(found.is_none(), "{name}, {seed}: {found:?}");
        }
    }
}
