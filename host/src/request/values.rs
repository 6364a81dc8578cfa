//! Options that name an edge with angles.

use core::str::FromStr;

use serde::Serialize;

/// Value `I=DEG` of `--crease`: an edge and its angle in degrees.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
#[serde(into = "String")]
pub struct DrivenEdge {
    /// Number of the edge, from 0.
    pub edge: usize,
    /// Fold angle, degrees; finite.
    pub degrees: f64,
}

impl From<DrivenEdge> for String {
    fn from(driven: DrivenEdge) -> Self {
        format!("{}={}", driven.edge, driven.degrees)
    }
}

impl FromStr for DrivenEdge {
    type Err = &'static str;

    fn from_str(text: &str) -> Result<Self, Self::Err> {
        let parse = || {
            let (edge, degrees) = text.split_once('=')?;
            Some(Self {
                edge: edge.trim().parse().ok()?,
                degrees: degrees_of(degrees)?,
            })
        };
        parse().ok_or("expected I=DEG, the number of an edge and an angle in degrees")
    }
}

/// Value `I=MIN..MAX` of `--limit`: an edge and the range of its angle in degrees.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
#[serde(into = "String")]
pub struct LimitedEdge {
    /// Number of the edge, from 0.
    pub edge: usize,
    /// Smallest fold angle, degrees; finite.
    pub lower: f64,
    /// Largest fold angle, degrees; finite.
    pub upper: f64,
}

impl From<LimitedEdge> for String {
    fn from(limit: LimitedEdge) -> Self {
        format!("{}={}..{}", limit.edge, limit.lower, limit.upper)
    }
}

impl FromStr for LimitedEdge {
    type Err = &'static str;

    fn from_str(text: &str) -> Result<Self, Self::Err> {
        let parse = || {
            let (edge, range) = text.split_once('=')?;
            let (lower, upper) = range.split_once("..")?;
            Some(Self {
                edge: edge.trim().parse().ok()?,
                lower: degrees_of(lower)?,
                upper: degrees_of(upper)?,
            })
        };
        parse().ok_or("expected I=MIN..MAX, the number of an edge and two angles in degrees")
    }
}

fn degrees_of(text: &str) -> Option<f64> {
    let degrees: f64 = text.trim().parse().ok()?;
    degrees.is_finite().then_some(degrees)
}
