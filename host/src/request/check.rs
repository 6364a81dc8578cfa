//! A verdict on a motion as JSON.
#![allow(missing_docs, reason = "docs/schema/check.json describes the keys")]

use serde::Serialize;

use crate::check::Verdict;
use crate::folding::SpanningTree;
use crate::motion::Motion;
use crate::pattern::CreasePattern;

/// A verdict on a motion, which serialises to the JSON object of `foldpath check --json`. Angles are in degrees, lengths in
/// the units of the sheet.
#[derive(Debug, Serialize)]
pub struct CheckJson {
    pub outcome: &'static str,
    pub reason: Option<String>,
    pub start: &'static str,
    pub undecided: Vec<String>,
    pub knots: usize,
    pub max_deformation: f64,
    pub max_gap: f64,
    pub max_closure: f64,
    pub max_bend: f64,
    pub certified_deformation: Option<f64>,
    pub certified_of: String,
    pub crossings: Vec<CrossingJson>,
    pub min_clearance: Option<f64>,
    pub contact_tolerance: f64,
    pub max_speed: f64,
    pub max_acceleration: Option<f64>,
}

/// Two faces that pass through each other.
#[derive(Debug, Serialize)]
pub struct CrossingJson {
    pub faces: [u32; 2],
    pub between_knots: [usize; 2],
    pub at: f64,
}

impl CheckJson {
    /// Returns the verdict on a motion for JSON.
    #[must_use]
    pub fn of(motion: &Motion, verdict: &Verdict) -> Self {
        let [failures, undecided] = [sentences(&verdict.failures), sentences(&verdict.undecided)];
        let reasons = if failures.is_empty() {
            &undecided
        } else {
            &failures
        };
        let rigidity = verdict.rigidity();
        let crossings = verdict.crossings.iter().map(|found| CrossingJson {
            faces: found.crossing.faces.map(|face| face.0),
            between_knots: found.between_knots,
            at: found.at,
        });
        Self {
            outcome: verdict.outcome().name(),
            reason: (!verdict.holds()).then(|| reasons.join("; ")),
            start: if motion.begins_flat() {
                "flat"
            } else {
                "folded"
            },
            undecided: undecided.clone(),
            knots: motion.knots.len(),
            max_deformation: rigidity.deformation,
            max_gap: rigidity.gap,
            max_closure: verdict.closure(),
            max_bend: verdict.max_bend.to_degrees(),
            certified_deformation: verdict.certified().map(|most| most.deformation),
            certified_of: certified_of(&motion.pattern),
            crossings: crossings.collect(),
            min_clearance: verdict.min_clearance,
            contact_tolerance: verdict.contact_tolerance,
            max_speed: verdict.rates.speed.to_degrees(),
            max_acceleration: verdict.rates.acceleration.map(f64::to_degrees),
        }
    }
}

/// Says which folding of a sheet is certified: on a sheet that does not quite close, others are torn elsewhere.
fn certified_of(pattern: &CreasePattern) -> String {
    let tree = SpanningTree::from_central_face(pattern);
    let roots: Vec<_> = tree.roots().iter().map(ToString::to_string).collect();
    match &roots[..] {
        [root] => format!("the sheet folded from face {root} outwards"),
        _ => format!("the sheets folded from faces {} outwards", roots.join(", ")),
    }
}

fn sentences(findings: &[impl ToString]) -> Vec<String> {
    findings.iter().map(ToString::to_string).collect()
}
