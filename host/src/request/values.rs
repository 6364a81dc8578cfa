//! Options that name an edge with angles, and letters of colours.

use serde_json::Value;

use super::table::{Kind, OptionValue, Shape, shape};
use crate::read::ColourLetters;

/// Value `I=DEG` of `--crease`: an edge and its angle in degrees.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct DrivenEdge {
    /// Number of the edge, from 0.
    pub edge: usize,
    /// Fold angle, degrees; finite.
    pub degrees: f64,
}

impl OptionValue for DrivenEdge {
    const SHAPE: Shape = shape(Kind::EdgeAngle);

    fn parse(word: &str) -> Result<Self, String> {
        let parsed = edge_of(word).and_then(|(edge, degrees)| {
            let degrees = degrees_of(degrees)?;
            Some(Self { edge, degrees })
        });
        let expected = "expected I=DEG, the number of an edge and an angle in degrees";
        parsed.ok_or_else(|| expected.into())
    }

    fn json(&self) -> Value {
        format!("{}={}", self.edge, self.degrees).into()
    }
}

/// Value `I=MIN..MAX` of `--limit`: an edge and the range of its angle in degrees.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LimitedEdge {
    /// Number of the edge, from 0.
    pub edge: usize,
    /// Smallest fold angle, degrees; finite.
    pub lower: f64,
    /// Largest fold angle, degrees; finite.
    pub upper: f64,
}

impl OptionValue for LimitedEdge {
    const SHAPE: Shape = shape(Kind::EdgeRange);

    fn parse(word: &str) -> Result<Self, String> {
        let parsed = edge_of(word).and_then(|(edge, range)| {
            let (lower, upper) = range.split_once("..")?;
            let [lower, upper] = [degrees_of(lower)?, degrees_of(upper)?];
            Some(Self { edge, lower, upper })
        });
        let expected = "expected I=MIN..MAX, the number of an edge and two angles in degrees";
        parsed.ok_or_else(|| expected.into())
    }

    fn json(&self) -> Value {
        format!("{}={}..{}", self.edge, self.lower, self.upper).into()
    }
}

/// Returns the number before `=` and what is behind it.
fn edge_of(word: &str) -> Option<(usize, &str)> {
    let (edge, rest) = word.split_once('=')?;
    Some((edge.trim().parse().ok()?, rest))
}

fn degrees_of(text: &str) -> Option<f64> {
    let degrees: f64 = text.trim().parse().ok()?;
    degrees.is_finite().then_some(degrees)
}

impl OptionValue for ColourLetters {
    const SHAPE: Shape = shape(Kind::Text);

    fn parse(word: &str) -> Result<Self, String> {
        word.parse()
            .map_err(|error: crate::read::ColourLettersError| error.to_string())
    }

    fn json(&self) -> Value {
        self.to_string().into()
    }

    /// The error names the part of the text that is wrong.
    fn read(value: &Value) -> Result<Self, String> {
        Self::parse(value.as_str().unwrap_or_default())
    }
}
