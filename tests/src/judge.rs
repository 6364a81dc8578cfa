//! Judges a planned path by the oracle: does the path keep everything that its plan says?

use core::f64::consts::PI;

use foldpath::motion::Motion;
use foldpath::planner::{Outcome, Plan};
use nalgebra::Vector3;

use crate::crossing::CONTACT;
use crate::second::Shape;
use crate::{Animation, Random, worst};

/// Amount by which the oracle may find more than the plan admits: rounding of sheets with hundreds of faces, in both.
const ROUNDING: f64 = 1e-9;
/// Closure residual from which on a path is called inexact if its goal closes to rounding.
const CLOSED: f64 = 1e-9;
/// Largest distance of the end of an exact path from a goal that closes, radians.
const AT_GOAL: f64 = 1e-9;
/// Tolerance of fold angles that are measured on positions, radians; the deformation of the sheet is added.
const SAME_ANGLE: f64 = 1e-6;
/// Number of points of a segment at which its closure is evaluated (`CLOSURES`) and at which it is folded (`FOLDED`).
const CLOSURES: u32 = 100;
const FOLDED: u32 = 3;
/// Fraction of a segment, before and after a knot, at which the sides of faces on each other are looked up.
const BESIDE: f64 = 0.01;
/// Tolerance of an angle against its assignment, radians.
const AGAINST: f64 = 1e-9;

/// The oracle's findings on a path.
#[derive(Debug, Default)]
pub struct Verdict {
    /// Errors of the path, and values that are worse than its plan says.
    pub disagreements: Vec<String>,
    /// `true` if the path closes to rounding and, if it is said to arrive, ends at its goal to rounding.
    pub exact: bool,
}

/// Returns `count` fractions of a segment, evenly spaced inside it.
fn places(count: u32) -> impl Iterator<Item = f64> {
    (1..=count).map(move |k| f64::from(k) / f64::from(count + 1))
}

/// Returns the number of pairs of faces that cross in a shape at these positions; `tear` is the largest tear of the
/// sheet. An overlap up to `contact` is contact.
#[allow(clippy::cast_precision_loss, reason = "a small count")]
fn crossings(shape: &Shape, positions: &[Vector3<f64>], tear: [f64; 2]) -> f64 {
    shape
        .sheet
        .crossings_beyond_tears(shape.angles, positions, tear)
        .len() as f64
}

/// Returns the sign of an edge's goal, 0 if it has none.
fn sign(goal: Option<f64>) -> f64 {
    goal.filter(|goal| goal.abs() > 0.0)
        .map_or(0.0, f64::signum)
}

/// Returns the face from which a sheet of one part is folded where deformation and gap are certified. `check` names it.
fn certified_face(motion: &Motion) -> usize {
    motion.pattern.tree().roots()[0].index()
}

/// Judges the path of `plan`, written as `path`, from flat towards a goal. `goal`: fold angle of each edge, radians,
/// whose sign is the assignment; `None` for an edge without a goal. `bound`: the bound on deformation and gap. `contact`:
/// overlap of faces up to which it is contact, over the median edge.
#[must_use]
pub fn judge(
    path: &Animation,
    goal: &[Option<f64>],
    plan: &Plan,
    bound: f64,
    contact: f64,
) -> Verdict {
    let sheet = &path.sheet;
    let mut disagreements = Vec::new();
    let mut limit = |what: &str, value: f64, limit: f64| {
        if value > limit || value.is_nan() {
            disagreements.push(format!("{what} {value:e}, expected {limit:e} at most"));
        }
    };
    let (Some(first), Some(last)) = (path.frames.first(), path.frames.last()) else {
        return Verdict::default();
    };
    // A plan that tears the sheet, or that ran out of time, vouches for nothing.
    if matches!(plan.outcome, Outcome::NotRigidlyFoldable | Outcome::Timeout) {
        return Verdict::default();
    }
    limit(
        "start off flat by",
        worst(first.angles.iter().map(|a| a.abs())),
        0.0,
    );
    let goals = last.angles.iter().zip(goal);
    let missed = worst(goals.filter_map(|(a, b)| Some((a - (*b)?).abs())));
    let arrives = plan.outcome == Outcome::Planned;
    if arrives {
        limit("off the goal by", missed, plan.arrival.error + ROUNDING);
    }
    let (stars, mut random) = (sheet.stars(), Random::new(path.frames.len() as u64));
    let other_tree = sheet.other_tree(&stars);
    // The plan bounds gap and deformation of the sheet as it is folded from this face.
    let root = plan.motion.as_ref().map_or(0, certified_face);
    let fold = |angles: &[f64]| sheet.fold_from(root, angles);
    let gaps = path.frames.iter();
    let tear = worst(gaps.map(|frame| sheet.gap(&fold(&frame.angles))));
    let mut closure = 0.0_f64;
    for (knot, frame) in path.frames.iter().enumerate() {
        let poses = fold(&frame.angles);
        let placed = sheet.positions(&poses);
        let mut limit =
            |what: &str, value, most| limit(&format!("knot {knot}: {what}"), value, most);
        let moved = |&v: &usize| (frame.vertices[v] - sheet.flat[v]).norm();
        limit(
            "the face that is certified moves by",
            worst(sheet.faces[root].iter().map(moved)) / sheet.median_edge(),
            ROUNDING,
        );
        let left = sheet.closure(&frame.angles);
        closure = closure.max(left);
        let admitted = |value: f64| value.min(bound) + ROUNDING;
        let shape = Shape {
            sheet,
            stars: &stars,
            angles: &frame.angles,
            root,
        };
        // Folded along another spanning tree the sheet may gape by the certified bound, or by the difference between
        // two trees.
        let most = shape
            .apart()
            .max(plan.certified_deformation().unwrap_or(0.0));
        let torn = |value: f64| admitted((other_tree * value).max(most));
        limit("closure", left, admitted(plan.errors.closure));
        limit("gap", sheet.gap(&poses), torn(plan.errors.rigidity.gap));
        for (what, positions) in [("by angles", &placed), ("of positions", &frame.vertices)] {
            let most = torn(plan.errors.rigidity.deformation + plan.errors.rigidity.gap);
            limit(
                &format!("deformation {what}"),
                sheet.deformation(positions),
                most,
            );
        }
        limit(
            "unflatness",
            sheet.unflatness(&frame.vertices),
            admitted(other_tree * plan.errors.rigidity.gap),
        );
        limit(
            "angles off positions by",
            sheet.angle_error(&frame.vertices, &frame.angles),
            SAME_ANGLE + other_tree * plan.errors.rigidity.gap / sheet.narrowest(),
        );
        shape.compare(&placed, sheet.gap(&poses), &mut random, &mut limit);
        let against = frame.angles.iter().zip(goal).map(|(a, b)| -a * sign(*b));
        limit("a crease against its letter by", worst(against), AGAINST);
        limit(
            "crossings",
            crossings(&shape, &frame.vertices, [tear, contact]),
            0.0,
        );
    }
    let certified = |value: Option<f64>, other: f64| {
        value.map_or(bound, |value| (other * value).min(bound)) + ROUNDING
    };
    // A path that misses the goal is not written, and nothing is claimed of it between its knots.
    let pairs = path.frames.windows(2).filter(|_| arrives);
    for (knot, pair) in pairs.enumerate() {
        let mut limit =
            |what: &str, value, most| limit(&format!("after knot {knot}: {what}"), value, most);
        limit("time back", pair[0].time - pair[1].time, 0.0);
        let shapes = |count| places(count).map(|s| path.motion.angles(knot, s));
        let closures = shapes(CLOSURES).map(|angles| sheet.closure_round(&stars, &angles));
        limit(
            "closure",
            worst(closures),
            certified(plan.certified_closure(), 1.0),
        );
        let against = |angles: Vec<f64>| {
            let turns = angles.into_iter().zip(goal);
            worst(turns.map(|(a, b)| (-a * sign(*b)).max(a.abs() - PI)))
        };
        let against = worst(shapes(CLOSURES).map(against));
        limit("against a letter or beyond half a turn", against, AGAINST);
        for angles in shapes(FOLDED) {
            let poses = fold(&angles);
            let (placed, gap) = (sheet.positions(&poses), sheet.gap(&poses));
            let most = certified(plan.certified_deformation(), other_tree);
            limit("gap", gap, most);
            limit("deformation", sheet.deformation(&placed), most);
            let shape = Shape {
                sheet,
                stars: &stars,
                angles: &angles,
                root,
            };
            shape.compare(&placed, gap, &mut random, &mut limit);
            limit(
                "crossings",
                crossings(&shape, &placed, [tear, contact]),
                0.0,
            );
        }
    }
    let shapes = path.frames.iter().enumerate().flat_map(|(knot, frame)| {
        let inside = (knot + 1 < path.frames.len()).then_some([BESIDE, 1.0 - BESIDE]);
        let inside = inside
            .into_iter()
            .flatten()
            .map(move |s| path.motion.angles(knot, s));
        core::iter::once(frame.angles.clone()).chain(inside)
    });
    let shapes: Vec<_> = shapes.map(|angles| fold(&angles)).collect();
    let torn = other_tree * worst(shapes.iter().map(|shape| sheet.gap(shape)));
    let passed = sheet
        .passed(&shapes, torn + (contact - CONTACT))
        .into_iter()
        .map(|(faces, shape)| {
            format!(
                "faces {faces:?} lay on each other and passed through each other after knot {}",
                (shape - 1) / 3
            )
        });
    disagreements.extend(passed);
    Verdict {
        disagreements,
        exact: closure <= CLOSED && (!arrives || missed <= AT_GOAL),
    }
}
