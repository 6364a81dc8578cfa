//! The sentences of the planner's reasons and notes, and of the findings of a check.

use foldpath::check::{Failure, GroupQuantity, Moment, RateLimit, SheetError};
use foldpath::collision::{Crossing, PlateError};
use foldpath::folding::Rigidity;
use foldpath::pattern::{ClosureSite, EdgeId, FaceId, VertexId};
use foldpath::planner::{
    FirstSteps, GroupsDropped, HingeAtLimit, Note, ProofOrder, Reason, Stop, TimeoutAt, Undecided,
    WorstClosure,
};
use foldpath::sensitivity::{NoDerivative, NoLoads, NoTolerance, PlayKind};
use foldpath_core::GroupId;

const FACES: [FaceId; 2] = [FaceId(3), FaceId(8)];

fn edges(count: u32) -> Vec<EdgeId> {
    (0..count).map(EdgeId).collect()
}

fn worst(site: ClosureSite) -> Option<WorstClosure> {
    Some(WorstClosure {
        site,
        edges: edges(3),
        residual: 0.0123,
    })
}

fn stops(stop: Stop) -> Reason {
    Reason::PathStops {
        reached: 0.4567,
        stop,
        at_flat: None,
        limited: None,
        worst: None,
    }
}

#[test]
fn reasons_are_sentences() {
    let rigidity = Rigidity {
        deformation: 0.02,
        gap: 0.03,
        twist: 0.04,
    };
    let crosses = Reason::Crosses {
        faces: FACES,
        reached: 0.5,
        free: 0.5,
        segment: 4,
        depth: 0.012,
    };
    let closure = "vertex 7 (creases: edges 0, 1, 2) does not close: residual 1.2e-2";
    let all = [
        (
            Reason::OutOfTime(TimeoutAt::ClosingGoal),
            "out of time while closing the goal".to_string(),
        ),
        (
            Reason::OutOfTime(TimeoutAt::PlacingKnots),
            "out of time while placing knots".into(),
        ),
        (
            Reason::OutOfTime(TimeoutAt::JudgingKnot(5)),
            "out of time while judging knot 5".into(),
        ),
        (
            Reason::OutOfTime(TimeoutAt::LookingForCrossings),
            "out of time while looking for crossings".into(),
        ),
        (
            Reason::OutOfTime(TimeoutAt::LookingForOtherWays),
            "out of time while looking for other ways to the goal".into(),
        ),
        (
            Reason::GoalNotClosed {
                goal: "the letters".into(),
                nearest: None,
                worst: None,
            },
            "no closed configuration was found near the letters".into(),
        ),
        (
            Reason::GoalNotClosed {
                goal: "the letters".into(),
                nearest: Some(1.0),
                worst: worst(ClosureSite::Vertex(VertexId(7))),
            },
            format!(
                "no closed configuration was found near the letters: the nearest found turns a crease 57.3 degrees \
                 from its goal; there {closure}"
            ),
        ),
        (
            Reason::PathStops {
                reached: 0.4567,
                stop: Stop::Closure,
                at_flat: None,
                limited: None,
                worst: worst(ClosureSite::Hole(VertexId(7))),
            },
            "as far as 45.7 % of the goal's angles: no closed configuration was found that follows (closure); going on \
             straight, the hole at vertex 7 (creases: edges 0, 1, 2) does not close: residual 1.2e-2"
                .into(),
        ),
        (
            Reason::PathStops {
                reached: 0.0,
                stop: Stop::Singular,
                at_flat: Some(FirstSteps::NotKnown),
                limited: None,
                worst: None,
            },
            "as far as 0.0 % of the goal's angles: no motion was found that leaves the flat sheet with these signs".into(),
        ),
        (
            Reason::PathStops {
                reached: 0.0,
                stop: Stop::Singular,
                at_flat: Some(FirstSteps::NoneProved(ProofOrder::First)),
                limited: None,
                worst: None,
            },
            "as far as 0.0 % of the goal's angles: no motion leaves the flat sheet with these signs (proved to first order)".into(),
        ),
        (
            Reason::PathStops {
                reached: 0.99999,
                stop: Stop::Singular,
                at_flat: Some(FirstSteps::Some {
                    locked: edges(2),
                    free: edges(1),
                }),
                limited: None,
                worst: None,
            },
            "as far as 99.9 % of the goal's angles: not all creases can turn with these signs; locked: edges 0, 1; free, as \
             lines that turn alone: edges 0"
                .into(),
        ),
        (
            Reason::PathStops {
                reached: 0.4567,
                stop: Stop::Limit(2),
                at_flat: None,
                limited: Some(HingeAtLimit {
                    edges: edges(14),
                    angle: 0.5,
                }),
                worst: None,
            },
            "as far as 45.7 % of the goal's angles: a hinge is at its limit of 28.6 degrees: edges 0, 1, 2, 3, 4, 5, 6, \
             7, 8, 9, 10, 11 and 2 more"
                .into(),
        ),
        (
            stops(Stop::Singular),
            "as far as 45.7 % of the goal's angles: no motion was found that leads on (singular)".into(),
        ),
        (
            stops(Stop::Nearest),
            "as far as 45.7 % of the goal's angles: the motion leads no nearer to the goal (closure)".into(),
        ),
        (
            stops(Stop::TooLong),
            "as far as 45.7 % of the goal's angles: the motion goes on without coming nearer to the goal (closure)"
                .into(),
        ),
        (
            stops(Stop::Timeout),
            "as far as 45.7 % of the goal's angles: out of time".into(),
        ),
        (
            Reason::ProofStops {
                reached: 0.4567,
                certified: 0.02,
                bound: 0.01,
            },
            "as far as 45.7 % of the goal's angles: the motion found beyond closes where it was looked at, but between \
             is certified only to 2.0e-2, over the bound of 1.0e-2"
                .into(),
        ),
        (
            Reason::NotCertified {
                certified: f64::INFINITY,
                bound: 0.01,
            },
            "the sheet keeps the bound at the knots, but between them it is certified only to inf, over the bound of \
             1.0e-2"
                .into(),
        ),
        (
            Reason::Deforms {
                whole: rigidity,
                closure: 0.05,
                essential: Rigidity::default(),
                bound: 0.01,
            },
            "measured at its knots, the whole sheet deforms by 2.000e-2 with gaps of 3.000e-2 and closure 5.000e-2, over the bound 1.000e-2; \
             its essential crease pattern by 0.000e0 with gaps of 0.000e0"
                .into(),
        ),
        (
            Reason::DeformsFromRim {
                rigidity,
                bound: 0.01,
            },
            "measured at its knots and folded from a face at its rim, the sheet deforms by 2.000e-2 with gaps of 3.000e-2, over the bound \
             1.000e-2"
                .into(),
        ),
        (
            Reason::TooManyKnots { budget: 20 },
            "the bound needs more than 20 knots with this interpolation".into(),
        ),
        (
            crosses.clone(),
            "faces 3 and 8 pass through each other beyond 25.00 % of the path (between knots 4 and 5: 1.2e-2 median \
             edges deep)"
                .into(),
        ),
        (
            Reason::CrossesAtKnot {
                faces: FACES,
                knot: 5,
            },
            "faces 3 and 8 pass through each other at knot 5".into(),
        ),
        (
            Reason::GoalCrosses {
                faces: FACES,
                path: Box::new(stops(Stop::Nearest)),
            },
            "at the goal faces 3 and 8 pass through each other; as far as 45.7 % of the goal's angles: the motion leads \
             no nearer to the goal (closure)"
                .into(),
        ),
        (
            Reason::NoFoldSequence,
            "no sequence of folds was found that is free of crossings".into(),
        ),
        (
            Reason::NoWayRound,
            "no way round the crossing was found".into(),
        ),
        (
            Reason::PlatesCross {
                faces: FACES,
                thickness: 0.25,
                segment: 4,
            },
            "panels 3 and 8 pass through each other between knots 4 and 5 if they are plates 0.25 thick".into(),
        ),
    ];
    for (reason, sentence) in all {
        assert_eq!(reason.to_string(), sentence);
    }
    let note = Note::EndsBeforeCrossing {
        residual: 1e-5,
        crossing: crosses,
        short: 0.01,
    };
    assert_eq!(
        note.to_string(),
        "the goal itself does not close (residual 1.0e-5), and near it faces 3 and 8 pass through each other beyond \
         25.00 % of the path (between knots 4 and 5: 1.2e-2 median edges deep): the path ends 0.573 degrees before"
    );
}

#[test]
fn open_questions_are_sentences() {
    let crossings = |faces| Undecided::Crossings { faces, segment: 4 };
    for (question, sentence) in [
        (
            crossings(Some(FACES)),
            "crossings are not decided: the search gave up at the pair of faces 3 and 8 between knots 4 and 5",
        ),
        (
            crossings(None),
            "crossings are not decided: the search gave up between knots 4 and 5",
        ),
        (
            Undecided::CrossingsAtKnots { faces: 9000 },
            "crossings were looked for at knots alone: the search over the motion of 9000 faces gave up",
        ),
    ] {
        assert_eq!(question.to_string(), sentence);
        assert_eq!(Reason::Undecided(question).to_string(), sentence);
    }
}

#[test]
fn notes_are_sentences() {
    let dropped = |why| Note::GroupsDropped { groups: 4, why };
    let all = [
        (
            dropped(GroupsDropped::GoalNotClosed),
            "4 crease groups dropped: the goal does not close under them",
        ),
        (
            dropped(GroupsDropped::FoldsFarther),
            "4 crease groups dropped: the sheet folds farther without them",
        ),
        (
            dropped(GroupsDropped::LessDeformation),
            "4 crease groups dropped: without them less deformation is proved",
        ),
        (
            Note::OtherCompletions(1),
            "1 other closed configuration found has the driven creases at their angles; letters or more driven creases choose \
             between them",
        ),
        (
            Note::OtherCompletions(2),
            "2 other closed configurations found have the driven creases at their angles; letters or more driven creases \
             choose between them",
        ),
        (
            Note::NearlyClosed,
            "no exact motion leads to the goal, as coordinates are rounded; on the way the sheet nearly closes, within its \
             bound",
        ),
        (
            Note::RoughGroups {
                groups: 4,
                tolerance: 1e-3,
            },
            "4 crease groups: the sheet is symmetric only to 1e-3 of its median edge",
        ),
        (
            Note::Branches(3),
            "3 first steps found that leave the flat sheet with these signs; the path takes that which leads farthest",
        ),
        (
            Note::FoundAtRandom,
            "the path was found by the randomised search",
        ),
        (
            Note::Snapped { turned: 0.01 },
            "creases turned by up to 5.7e-1 degrees are folded as if the sheet folded flat exactly: its coordinates are \
             rounded",
        ),
        (
            Note::GoalMoved {
                goal: "the letters".into(),
                residual: 1e-5,
                moved: 0.01,
            },
            "not closed: the letters (residual 1.0e-5); moved to the nearest configuration found that is, 5.73e-1 \
             degrees away",
        ),
        (
            Note::GoalMoved {
                goal: "the letters".into(),
                residual: 1e-5,
                moved: 0.0,
            },
            "not closed: the letters (residual 1.0e-5); taken as it is, since the sheet closes there as nearly as its \
             bound allows",
        ),
        (
            Note::OverlapsAtGoal(1e-5),
            "at the goal faces are in each other by less than 1.0e-5 median edges",
        ),
        (
            Note::PartWay(0.608),
            "the way found leads along the letters to 0.608 of a half turn",
        ),
        (
            Note::NoAngles,
            "no goal angles are named, and folded flat by its letters the sheet was not planned",
        ),
        (
            Note::TurnTogether {
                faces: FACES,
                edges: edges(2),
            },
            "faces 3 and 8 meet as these hinges turn: edges 0, 1; in another order they may pass",
        ),
        (
            Note::NoLayerOrder((0..14).map(FaceId).collect()),
            "at the goal, which lies flat, faces 0, 1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11 and 2 more pass through each other in \
             whatever order they are stacked: with these letters no order of folds leads there",
        ),
        (
            Note::GoalItselfCrosses {
                faces: FACES,
                depth: 0.42,
            },
            "at the goal itself faces 3 and 8 are 4.2e-1 median edges in each other: no order of folds leads there",
        ),
        (
            Note::PlatesCrossAtGoal {
                faces: FACES,
                depth: 0.42,
                thickness: 1.5,
            },
            "at the goal itself panels 3 and 8, 1.5 thick, are 0.420 in each other, so that no other order of folds was \
             tried; panels that lie on each other have to be drawn a thickness apart",
        ),
        (
            Note::TurnedFreely {
                mountains: edges(1),
                valleys: edges(2),
            },
            "hinges that have neither goal nor letter turned as the sheet closes first, as mountains edges 0, as valleys \
             edges 0, 1; letters choose another way, if there is one",
        ),
        (
            Note::Deforming,
            "no exact motion leads to the goal; the sheet is taken there straight, deforming",
        ),
        (
            Note::Phases(3),
            "folded in 3 phases: all creases cannot turn at once",
        ),
        (
            Note::RingsFirst(edges(2)),
            "edges 0, 1 close a ring before the others fold",
        ),
        (
            Note::TurnsPast {
                edges: edges(1),
                by: 0.25,
            },
            "edges 0 turn up to 14.3 degrees past their goals and return, so that what is on them clears the rest",
        ),
        (
            Note::WouldBend(0.5),
            "the sheet would fold if its panels might bend by 28.6 degrees",
        ),
        (
            Note::ErrorsAddedUp { closure: 1e-5 },
            "vertices fail to close by up to 1.0e-5: at worst that adds up to more than the bound; what it does add up \
             to is certified of the sheet folded from its middle and from its rim alone",
        ),
    ];
    for (note, sentence) in all {
        assert_eq!(note.to_string(), sentence);
    }
}

#[test]
fn findings_are_sentences() {
    use foldpath::check::Undecided;
    let [vertex, at] = [
        ClosureSite::Vertex(VertexId(3)),
        ClosureSite::Vertex(VertexId(4)),
    ];
    let between = Moment::Between {
        segment: 2,
        s: 0.25,
    };
    let (claimed, found) = (1e-9, 2e-3);
    let failures = [
        (
            Failure::BoundIsNotANumber,
            "bound: expected a number, found NaN, which nothing exceeds",
        ),
        (
            Failure::GroupDiffers {
                knot: 1,
                edges: [EdgeId(2), EdgeId(5)],
                group: GroupId(0),
                quantity: GroupQuantity::Weight,
                values: [1.0, 0.5],
            },
            "knot 1: edges 2 and 5 are in group 0, but have weights of 1 and 0.5, signs applied",
        ),
        (
            Failure::FalseClaim {
                knot: 1,
                error: SheetError::Gap,
                claimed,
                found,
            },
            "knot 1: the file claims a gap of 1.000e-9, but it is 2.000e-3",
        ),
        (
            Failure::FalseRate {
                limit: RateLimit::Speed,
                claimed: 1.0_f64.to_radians(),
                found: f64::INFINITY,
            },
            "the file claims a largest speed of 1.000e0 degrees per second, but hinges change their speed at once",
        ),
        (
            Failure::FalseClearance {
                knot: 1,
                claimed,
                found,
            },
            "knot 1: the file claims a clearance of 1.000e-9, but it is 2.000e-3",
        ),
        (
            Failure::FalseBound { claimed, found },
            "the file says that it was planned within the bound 1.000e-9, but has errors of 2.000e-3",
        ),
        (
            Failure::OverBound {
                at: between,
                error: SheetError::Deformation,
                value: found,
                bound: claimed,
                open: Some((VertexId(7), 0.5)),
            },
            "between knots 2 and 3, at 0.250: deformation 2.000e-3 over the bound 1.000e-9; vertex 7 fails to close by \
             5.000e-1",
        ),
        (
            Failure::FailsToClose {
                at: Moment::Knot(1),
                site: Some(vertex),
                residual: found,
                bound: claimed,
            },
            "knot 1: vertex 3 fails to close by 2.000e-3, over the bound 1.000e-9",
        ),
        (
            Failure::Crosses {
                at: Moment::Knot(1),
                crossing: Crossing {
                    faces: [FaceId(1), FaceId(2)],
                    depth: 0.5,
                },
                depth_edges: 0.25,
            },
            "knot 1: faces 1 and 2 pass through each other, 2.500e-1 median edges deep",
        ),
        (
            Failure::PlatesCross {
                at: between,
                crossing: Crossing {
                    faces: [FaceId(1), FaceId(2)],
                    depth: 0.5,
                },
                thickness: 0.25,
            },
            "between knots 2 and 3, at 0.250: panels 1 and 2, plates 0.25 thick, pass through each other, 5.000e-1 deep",
        ),
        (
            Failure::PlatesNotMade(PlateError::TurnsTooFar {
                edge: EdgeId(4),
                angle: 3.0,
            }),
            "the hinge at edge 4 turns to 171.9 degrees: plates turn by at most 170",
        ),
        (
            Failure::PlatesNotMade(PlateError::UsedUp {
                face: FaceId(1),
                edge: EdgeId(4),
                thickness: 0.25,
            }),
            "panel 1 is used up at a thickness of 0.250000: its sides stay back so far from the hinges that nothing is left \
             at edge 4",
        ),
    ];
    for (failure, sentence) in failures {
        assert_eq!(failure.to_string(), sentence);
    }
    let undecided = [
        (
            Undecided::Plates {
                at: between,
                faces: Some([FaceId(1), FaceId(2)]),
            },
            "not certified: between knots 2 and 3, at 0.250, whether plates pass through each other takes too long to \
             tell: panels 1 and 2",
        ),
        (
            Undecided::Errors {
                segment: 2,
                site: Some(at),
                closure: 1e-3,
                error: found,
                bound: claimed,
            },
            "not certified: between knots 2 and 3, vertex 4 fails to close by up to 1.000e-3, and the sheet may deform or \
             tear by 2.000e-3, over the bound 1.000e-9",
        ),
        (
            Undecided::Angle {
                at: between,
                edge: EdgeId(6),
            },
            "not certified: between knots 2 and 3, at 0.250, the fold angle of edge 6 is not known, as its weights vanish",
        ),
        (
            Undecided::Clearance { knot: 1, claimed },
            "knot 1: the file claims a clearance of 1.000e-9, and measuring it would take too long",
        ),
        (
            Undecided::Crossings {
                at: between,
                faces: Some([FaceId(1), FaceId(2)]),
            },
            "not certified: between knots 2 and 3, at 0.250, whether faces pass through each other takes too long to tell: \
             faces 1 and 2",
        ),
        (
            Undecided::Unfinished {
                judged: 3,
                segments: 8,
            },
            "out of time before all was judged: closure is on 3 of 8 segments",
        ),
    ];
    for (open, sentence) in undecided {
        assert_eq!(open.to_string(), sentence);
    }
}

#[test]
fn reasons_for_no_derivative_play_or_torque_are_sentences() {
    let singular = NoDerivative::Singular { value: 1.54e-9 };
    let open = NoDerivative::Open { residual: 0.0123 };
    let leaves = NoDerivative::LeavesFoldability {
        residual: 0.2,
        of: 0.3,
    };
    let told = [
        (
            singular.to_string(),
            "the configuration is singular (smallest singular value 1.5e-9): the drivers do not determine the other hinges \
             there, as in the flat sheet",
        ),
        (
            open.to_string(),
            "the configuration does not close (residual 1.2e-2)",
        ),
        (
            leaves.to_string(),
            "the changed pattern does not fold: of its effect on closure, 3.0e-1 radians, 2.0e-1 are left",
        ),
        (
            NoDerivative::NotDrivers { size: 2 }.to_string(),
            "the drivers that are given do not determine the other hinges: expected 2 hinges that do",
        ),
        (
            NoTolerance::Flat.to_string(),
            "no hinge is folded by 10 degrees at any time, and nearer to flat play is not known to first order",
        ),
        (
            NoTolerance::Open {
                time: 1.5,
                cause: open,
            }
            .to_string(),
            "at 1.500 s, the configuration does not close (residual 1.2e-2)",
        ),
        (
            NoTolerance::TooLarge.to_string(),
            "the sheet has too many creases",
        ),
        (
            NoTolerance::Cancelled.to_string(),
            "time ran out before the play was found",
        ),
        (
            NoLoads::NoUnit.to_string(),
            "the file tells no unit of length, and torques need one",
        ),
        (
            NoLoads::Pieces { sheets: 2 }.to_string(),
            "expected a sheet in one piece, found 2",
        ),
        (
            NoLoads::NoFace {
                face: FaceId(9),
                faces: 9,
            }
            .to_string(),
            "face 9 does not exist, expected 0 to 8",
        ),
        (
            NoLoads::TooLarge.to_string(),
            "the sheet has too many creases",
        ),
        (NoLoads::Still.to_string(), "no hinge turns"),
        (
            NoLoads::Cancelled.to_string(),
            "time ran out before torques were found",
        ),
        (
            NoLoads::Size {
                size: 1,
                freedom: 2,
                hinges: 9,
            }
            .to_string(),
            "expected 2 to 9 drivers, from the degrees of freedom to all hinges, found 1",
        ),
        (
            NoLoads::NoHinge { edge: EdgeId(3) }.to_string(),
            "edge 3 is no hinge, and has no spring",
        ),
        (
            NoLoads::NoMotion {
                time: 0.0,
                cause: open,
            }
            .to_string(),
            "at 0.000 s, the configuration does not close (residual 1.2e-2)",
        ),
        (
            NoLoads::FreedomChanges {
                freedom: [1, 2],
                times: [0.0, 2.5],
            }
            .to_string(),
            "the degrees of freedom change: 1 at 0.000 s, 2 at 2.500 s; no set of drivers serves both",
        ),
        (
            NoLoads::NoDriversFound { size: 19 }.to_string(),
            "no set of 19 hinges was found that drives the sheet over the whole motion; not all were tried",
        ),
        (
            NoLoads::NoDrivers { size: 2 }.to_string(),
            "no set of 2 hinges drives the sheet over the whole motion",
        ),
    ];
    for (found, expected) in told {
        assert_eq!(found, expected);
    }
    let names = PlayKind::ALL.map(PlayKind::name);
    assert_eq!(names[3..], ["gap", "step"]);
}
