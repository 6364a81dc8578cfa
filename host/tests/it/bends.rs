//! Panels that bend: sheets that are locked with rigid panels fold if their panels may bend a little.

use foldpath::check::{CheckOptions, check};
use foldpath::export::fold::motion_text;
use foldpath::generate::{Letters, SquareTwist};
use foldpath::motion::Motion;
use foldpath::pattern::{CreasePattern, Letter};
use foldpath::planner::{Goal, Note, Outcome, Plan, PlanOptions, plan};
use foldpath::read::fold::parse_motion;

fn twist() -> CreasePattern {
    let twist = SquareTwist {
        rows: 1,
        columns: 1,
        angle: 30_f64.to_radians(),
        letters: Letters::Unfoldable,
        fold: 1.0,
    };
    CreasePattern::new(twist.drawing().unwrap()).unwrap()
}

fn folded(pattern: &CreasePattern, fold: f64, bend: f64) -> Plan {
    let options = PlanOptions::default().with(|it| it.bend = bend.to_radians());
    plan(pattern, &Goal::of_letters(pattern, fold).unwrap(), &options)
}

/// Writes a motion to a file and reads it.
fn reread(motion: &Motion) -> Motion {
    parse_motion("bent.fold".as_ref(), motion_text(motion).as_bytes()).unwrap()
}

fn holds(motion: &Motion, bend: f64) -> Result<(), String> {
    let options = CheckOptions::default().with(|it| it.bend = bend.to_radians());
    let verdict = check(motion, &options);
    if verdict.holds() {
        Ok(())
    } else {
        Err(verdict.findings().join("; "))
    }
}

#[test]
fn a_locked_twist_folds_with_panels_that_bend() {
    let pattern = twist();
    for fold in [0.25, 0.5] {
        let bent = folded(&pattern, fold, 90.0);
        assert_eq!(bent.outcome, Outcome::Planned, "{:?}", bent.reason);
        let most = bent.max_bend.to_degrees();
        let motion = reread(bent.motion.as_ref().unwrap());
        assert!(most > 5.0 && most < 60.0, "{most}");
        assert_eq!(holds(&motion, most), Ok(()));
        // The largest bend is told: with less, or with rigid panels, the path fails.
        for less in [0.0, most - 1.0] {
            let fault = holds(&motion, less).unwrap_err();
            assert!(fault.contains("bends its panel by"), "{fault}");
        }
        // Edges of the pattern keep their numbers and letters; the diagonals of eight quadrilaterals and more follow.
        let edges = motion.pattern.edges();
        for (drawn, edge) in pattern.edges().iter().zip(edges) {
            assert_eq!((drawn.ends, drawn.letter), (edge.ends, edge.letter));
        }
        let new = &edges[pattern.edges().len()..];
        assert!(new.iter().all(|edge| edge.letter.code() == 'J'));
        assert!(new.iter().any(|edge| edge.letter == Letter::Bend));
        assert_eq!(new.len(), pattern.virtual_edges());
        let faces = motion.pattern.faces().iter();
        assert!(faces.into_iter().all(|face| face.len() == 3));
    }
}

#[test]
fn a_smaller_limit_is_kept_or_refused() {
    let pattern = twist();
    let most = folded(&pattern, 0.25, 90.0).max_bend.to_degrees();
    let within = folded(&pattern, 0.25, most + 1.0);
    assert_eq!(within.outcome, Outcome::Planned);
    assert!(within.max_bend.to_degrees() <= most + 1.0);
    // A smaller one is refused, with the attempt that leads farthest and its bend. Rigid panels do not even leave flat.
    let limit = most / 4.0;
    let refused = folded(&pattern, 0.25, limit);
    assert_ne!(refused.outcome, Outcome::Planned);
    let bend = refused.max_bend.to_degrees();
    assert!(refused.reached > 0.05, "{}", refused.reached);
    assert!(
        bend > 0.9 * limit && bend <= limit + 1e-6,
        "{bend} of {limit}"
    );
    assert_eq!(
        holds(&reread(refused.motion.as_ref().unwrap()), limit + 1e-6),
        Ok(())
    );
}

#[test]
fn rigid_panels_are_told_which_bend_would_do() {
    let pattern = twist();
    let rigid = folded(&pattern, 0.25, 0.0);
    assert_eq!(rigid.outcome, Outcome::Partial);
    let hint = rigid.notes.iter().find_map(|note| match note {
        Note::WouldBend(most) => Some(most.to_degrees().ceil()),
        _ => None,
    });
    let hint = hint.expect("a bend");
    assert_eq!(folded(&pattern, 0.25, hint).outcome, Outcome::Planned);
}

/// A sheet that folds with rigid panels does not bend them.
#[test]
fn panels_bend_only_where_they_must() {
    let miura = foldpath::generate::Miura {
        rows: 3,
        columns: 3,
        sector_angle: 1.0,
        fold: 0.5,
    };
    let pattern = CreasePattern::new(miura.drawing().unwrap()).unwrap();
    let folded = folded(&pattern, 0.5, 90.0);
    assert_eq!(folded.outcome, Outcome::Planned);
    assert!(folded.max_bend <= 0.0);
    assert_eq!(
        folded.motion.unwrap().pattern.edges().len(),
        pattern.edges().len()
    );
}

/// A file that claims a smaller bend than it has is refused, whatever is allowed.
#[test]
fn a_false_claim_of_bend_is_found() {
    let bent = folded(&twist(), 0.25, 90.0);
    let mut motion = bent.motion.unwrap();
    motion.answer.as_mut().unwrap().bend /= 2.0;
    let fault = holds(&reread(&motion), 180.0).unwrap_err();
    assert!(fault.contains("bends its panel by"), "{fault}");
}

/// A free hinge and a valley that turn by the same angles: the valley turns against its letter between knots, though the
/// free hinge comes first.
#[test]
fn every_letter_of_a_group_is_judged() {
    let path = |letters: [&str; 2]| {
        let knot = |time: f64, angle: f64, rate: f64| {
            let both = |value: f64| [vec![value; 2], vec![0.0; 8]].concat();
            serde_json::json!({
                "frame_classes": ["foldedForm"], "frame_parent": 0, "frame_inherit": true,
                "edges_foldAngle": both(angle), "foldpath:time": time,
                "foldpath:edges_foldAngleRate": both(rate),
            })
        };
        let codes = [letters.as_slice(), &["B"; 8]].concat();
        let text = serde_json::json!({
            "file_spec": 1.2, "file_classes": ["animation"], "foldpath:interpolation": "hermite",
            "vertices_coords": [[0, 0], [1, 0], [2, 0], [3, 0], [0, 1], [1, 1], [2, 1], [3, 1]],
            "edges_vertices": [
                [1, 5], [2, 6], [0, 1], [1, 2], [2, 3], [4, 5], [5, 6], [6, 7], [0, 4], [3, 7]
            ],
            "edges_assignment": codes,
            "file_frames": [knot(0.0, 0.0, 20.0), knot(1.0, 10.0, -100.0), knot(2.0, 10.0, 100.0)],
        });
        parse_motion("path.fold".as_ref(), text.to_string().as_bytes()).unwrap()
    };
    for (letters, edge) in [(["U", "V"], 1), (["V", "U"], 0), (["V", "V"], 0)] {
        let fault = holds(&path(letters), 0.0).unwrap_err();
        let expected = format!("edge {edge} is lettered V, but turns to -1");
        assert!(fault.contains(&expected), "{letters:?}: {fault}");
    }
    assert_eq!(holds(&path(["U", "U"]), 0.0), Ok(()));
}
