//! Judges the motion of a plan whose panels are plates.

use std::sync::Arc;

use foldpath_core::Curve;

use crate::collision::{
    Crossing, Openness, Plates, SearchEffort, SearchedSheet, SweepVerdict, Thickest, TooThick,
    Trims, thickest,
};
use crate::motion::{Motion, PlateOptions};
use crate::pattern::FaceId;
use crate::planner::options::Thickness;
use crate::planner::plan::{Outcome, Plan};
use crate::planner::problem::PlanningProblem;
use crate::planner::reason::{Note, Reason, Undecided};
use crate::progress::Stage;

/// Looks for crossings of the plates that are asked for on the motion of a plan, or finds how thick they may be. Corners that
/// are in the way are cut off. The answer is no longer `Planned` if plates cross, cannot be made, or are not decided.
/// Returns a thickness, units of the sheet, at which they cross, if one is known.
pub(super) fn judge_plates(asked: &PlanningProblem<'_>, best: &mut Plan) -> Option<f64> {
    let (Some(request), Some(motion)) = (&asked.options.plates, &best.motion) else {
        return None;
    };
    if best.outcome != Outcome::Planned {
        best.notes.push(Note::PlatesNotJudged);
        return None;
    }
    let segments = 0..motion.segments();
    let judge = Judge {
        asked,
        motion,
        segments: segments
            .map(|segment| motion.curves(segment).collect())
            .collect(),
        openness: Openness {
            closure: best.certified_closure().unwrap_or(f64::INFINITY),
            gap: best.errors.rigidity.gap,
        },
        contact: best.crossings.contact_tolerance,
        is_max: request.thickness == Thickness::Max,
    };
    let mut judged = asked.stage(Stage::Crossings, || {
        let cut = || judge.judge(request.plates.with(|it| it.cuts_corners = true));
        // The first crossing ends a search, but many thicknesses take long.
        if judge.is_max {
            return cut();
        }
        let whole = judge.judge(request.plates);
        if !judge.is_corner_in_the_way(&whole.answer) {
            return whole;
        }
        let cut = cut();
        let is_free = matches!(cut.answer, Answer::Verdict(SweepVerdict::Free(_)));
        if is_free { cut } else { whole }
    });
    let crosses_at = judged.crosses_at();
    let corners_cut = Note::CornersCut(judged.corners_cut);
    if judged.corners_cut > 0 && !best.notes.contains(&corners_cut) {
        best.notes.push(corners_cut);
    }
    if let Answer::Thickest(found) = judged.answer {
        best.notes.push(Note::Thickest(found));
        best.max_thickness = found.refuted.map(|(refuted, _)| [found.proved, refuted]);
        judged.plates.thickness = found.proved;
    }
    match judged.no() {
        None => {
            best.thickness = Some(judged.plates.thickness);
            if let Answer::Verdict(SweepVerdict::Free(Some(clearance))) = judged.answer {
                best.crossings.clearance = Some(clearance);
            }
            if let Some(motion) = &mut best.motion {
                motion.plates = Some(judged.plates);
            }
        }
        Some((outcome, Reason::Undecided(open))) => {
            best.undecided.push(open);
            (best.outcome, best.reason) = (outcome, Some(Reason::Undecided(open)));
        }
        Some((outcome, reason)) => {
            if let (Some(_), Reason::PlatesCross { segment, .. }, Some(motion)) =
                (asked.plates, &reason, &mut best.motion)
            {
                // The search for phases takes the end of the motion for the place of the crossing.
                motion.knots.truncate(segment + 2);
                motion.phases.retain(|knot| knot <= segment);
            }
            (best.outcome, best.reason) = (outcome, Some(reason));
        }
    }
    crosses_at
}

/// Returns plates of this thickness as asked for, with corners cut off where the goal asks for it, for motions on which no hinge
/// turns past its goal; `None` if no plates are asked for, or they cannot be made.
pub(super) fn plates_asked_for(asked: &PlanningProblem<'_>, thickness: f64) -> Option<Plates> {
    let plates = asked.options.plates.as_ref()?.plates;
    let plates = plates.with(|it| it.thickness = thickness);
    let angles = asked.goal.fold_angles.iter();
    let angles = angles.map(|angle| angle.unwrap_or(0.0)).collect();
    let trims = Trims::until(asked.pattern, angles, &plates);
    Plates::new(asked.pattern, &trims, &plates).ok()
}

/// Knowledge of plates.
enum Answer {
    /// Plates of the thickness asked for.
    Verdict(SweepVerdict),
    /// Their largest thickness.
    Thickest(Thickest),
    /// The plates cannot be made.
    No(TooThick),
}

/// Plates that were judged.
struct Judged {
    plates: PlateOptions,
    corners_cut: usize,
    answer: Answer,
}

impl Judged {
    /// Returns a thickness at which plates are known to pass through each other.
    fn crosses_at(&self) -> Option<f64> {
        match self.answer {
            Answer::Verdict(SweepVerdict::Crossing { .. }) => Some(self.plates.thickness),
            Answer::Thickest(Thickest {
                refuted: Some((thickness, TooThick::Cross(..))),
                ..
            }) => Some(thickness),
            _ => None,
        }
    }

    /// Returns the outcome and the reason if the answer is no, or not known.
    fn no(&self) -> Option<(Outcome, Reason)> {
        let thickness = self.plates.thickness;
        let crosses = |crossing: Crossing, thickness: f64, segment: usize| {
            let reason = Reason::PlatesCross {
                faces: crossing.faces,
                thickness,
                segment,
            };
            (Outcome::Crossing(crossing), reason)
        };
        let not_known = |faces: Option<[FaceId; 2]>, segment: usize| {
            let open = Undecided::Plates { faces, segment };
            (Outcome::Undecided, Reason::Undecided(open))
        };
        let refuted = |why: &TooThick, thickness: f64| match why {
            TooThick::Cross(crossing, at) => crosses(*crossing, thickness, at.segment),
            TooThick::NotMade(error) => {
                (Outcome::MATERIAL_IN_THE_WAY, Reason::PlatesNotMade(*error))
            }
        };
        match &self.answer {
            Answer::Verdict(SweepVerdict::Free(_)) => None,
            Answer::Verdict(SweepVerdict::Crossing { crossing, at, .. }) => {
                Some(crosses(*crossing, thickness, at.segment))
            }
            Answer::Verdict(SweepVerdict::Undecided { faces, at }) => {
                Some(not_known(*faces, at.segment))
            }
            Answer::Thickest(found) if found.proved > 0.0 => None,
            Answer::Thickest(Thickest {
                refuted: Some((thickness, why)),
                is_open: false,
                ..
            }) => Some(refuted(why, *thickness)),
            Answer::Thickest(_) => Some(not_known(None, 0)),
            Answer::No(why) => Some(refuted(why, thickness)),
        }
    }
}

/// The motion on which plates are judged.
struct Judge<'a> {
    asked: &'a PlanningProblem<'a>,
    motion: &'a Motion,
    segments: Vec<Vec<Curve<f64>>>,
    openness: Openness,
    contact: f64,
    is_max: bool,
}

impl Judge<'_> {
    fn judge(&self, plates: PlateOptions) -> Judged {
        let trims = Trims::of(self.motion, &plates);
        let pattern = &self.motion.pattern;
        let answer = if self.is_max {
            Answer::Thickest(thickest(pattern, &trims, &plates, |plates| {
                self.search(plates)
            }))
        } else {
            match Plates::new(pattern, &trims, &plates) {
                Ok(plates) => Answer::Verdict(self.search(Arc::new(plates))),
                Err(error) => Answer::No(TooThick::NotMade(error)),
            }
        };
        let corners_cut = trims.corners_cut();
        Judged {
            plates: plates.with(|it| it.cuts_corners = corners_cut > 0),
            corners_cut,
            answer,
        }
    }

    fn search(&self, plates: Arc<Plates>) -> SweepVerdict {
        let memberships = self.motion.memberships();
        let (pattern, watch) = (&self.motion.pattern, self.asked.watch);
        let sheet = SearchedSheet::new(pattern, &memberships, Some(self.contact), watch);
        let plated = sheet.made_of(plates);
        let searched = plated.search(&self.segments, &SearchEffort::PLAN, self.openness);
        searched.verdict
    }

    /// Returns `true` if what is in the way is that panels which share a vertex pass through each other.
    fn is_corner_in_the_way(&self, answer: &Answer) -> bool {
        let Answer::Verdict(SweepVerdict::Crossing { crossing, .. }) = answer else {
            return false;
        };
        let faces = self.motion.pattern.faces();
        let [a, b] = crossing.faces.map(|face| &faces[face.index()]);
        a.iter().any(|vertex| b.contains(vertex))
    }
}
