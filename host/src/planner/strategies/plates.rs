//! Judges the motion of a plan whose panels are plates.

use std::sync::Arc;

use crate::collision::{
    Openness, Place, Plates, SearchEffort, SearchedSheet, SweepVerdict, Thickest, TooThick,
    thickest,
};
use crate::motion::Motion;
use crate::planner::options::Thickness;
use crate::planner::plan::{Outcome, Plan};
use crate::planner::problem::PlanningProblem;
use crate::planner::reason::{Note, Reason, Undecided};
use crate::progress::Stage;

/// Looks for crossings of the plates that are asked for on the motion of a plan, or finds how thick they may be. The answer
/// is no longer `Planned` if plates cross, cannot be made, or are not decided.
pub(super) fn judge_plates(asked: &PlanningProblem<'_>, best: &mut Plan) {
    let (Some(asked_for), Some(motion)) = (&asked.options.plates, &best.motion) else {
        return;
    };
    if best.outcome != Outcome::Planned {
        best.notes.push(Note::PlatesNotJudged);
        return;
    }
    let mut options = asked_for.plates;
    let judge = Judge {
        asked,
        motion,
        segments: (0..motion.segments())
            .map(|segment| motion.curves(segment).collect())
            .collect(),
        openness: Openness {
            closure: best.certified_closure().unwrap_or(f64::INFINITY),
            gap: best.errors.rigidity.gap,
        },
        contact: best.crossings.contact_tolerance,
    };
    let ranges = motion.angle_ranges();
    let pattern = &motion.pattern;
    let verdict = match asked_for.thickness {
        Thickness::Given => match Plates::new(pattern, &ranges, &options) {
            Ok(plates) => judge.search(Arc::new(plates)),
            Err(error) => {
                let no = Reason::PlatesNotMade(error);
                (best.outcome, best.reason) = (Outcome::MATERIAL_IN_THE_WAY, Some(no));
                return;
            }
        },
        Thickness::Max => {
            let found = asked.stage(Stage::Crossings, || {
                thickest(pattern, &ranges, &options, |plates| judge.search(plates))
            });
            options.thickness = found.proved;
            let Thickest {
                proved,
                refuted,
                is_open,
            } = found;
            best.max_thickness = refuted.map(|(refuted, _)| [proved, refuted]);
            best.notes.push(Note::Thickest(found));
            if proved <= 0.0 {
                let (outcome, reason) = match refuted {
                    Some((thickness, TooThick::Cross(crossing, at))) if !is_open => {
                        let reason = Reason::PlatesCross {
                            faces: crossing.faces,
                            thickness,
                            segment: at.segment,
                        };
                        (Outcome::Crossing(crossing), reason)
                    }
                    Some((_, TooThick::NotMade(error))) if !is_open => {
                        (Outcome::MATERIAL_IN_THE_WAY, Reason::PlatesNotMade(error))
                    }
                    _ => {
                        let open = Undecided::Plates {
                            faces: None,
                            segment: 0,
                        };
                        best.undecided.push(open);
                        (Outcome::Undecided, Reason::Undecided(open))
                    }
                };
                (best.outcome, best.reason) = (outcome, Some(reason));
                return;
            }
            SweepVerdict::Free(None)
        }
    };
    match verdict {
        SweepVerdict::Free(clearance) => {
            if clearance.is_some() {
                best.crossings.clearance = clearance;
            }
        }
        SweepVerdict::Crossing {
            crossing,
            at: Place { segment, .. },
            ..
        } => {
            let thickness = options.thickness;
            best.reason = Some(Reason::PlatesCross {
                faces: crossing.faces,
                thickness,
                segment,
            });
            best.outcome = Outcome::Crossing(crossing);
            return;
        }
        SweepVerdict::Undecided { faces, at } => {
            best.undecided.push(Undecided::Plates {
                faces,
                segment: at.segment,
            });
            return;
        }
    }
    best.thickness = Some(options.thickness);
    if let Some(motion) = &mut best.motion {
        motion.plates = Some(options);
    }
}

/// What a search for crossings of plates needs.
struct Judge<'a> {
    asked: &'a PlanningProblem<'a>,
    motion: &'a Motion,
    segments: Vec<Vec<foldpath_core::Curve<f64>>>,
    openness: Openness,
    contact: f64,
}

impl Judge<'_> {
    fn search(&self, plates: Arc<Plates>) -> SweepVerdict {
        self.asked.stage(Stage::Crossings, || {
            let memberships = self.motion.memberships();
            let pattern = &self.motion.pattern;
            let sheet =
                SearchedSheet::new(pattern, &memberships, Some(self.contact), self.asked.watch);
            let sheet = sheet.made_of(plates);
            sheet
                .search(&self.segments, &SearchEffort::PLAN, self.openness)
                .verdict
        })
    }
}
