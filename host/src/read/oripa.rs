//! Lines of ORIPA's drawings, which have a type: what CP and OPX files share.

use std::collections::BTreeMap;

use nalgebra::Vector2;

use super::segments::{LooseLines, MAX_LINES, Segment};
use crate::pattern::Letter;

/// The lines of a drawing in the order of the file.
#[derive(Default)]
pub(super) struct TypedLines {
    segments: Vec<Segment>,
    /// Number of lines of each type that is no crease.
    left_out: BTreeMap<i64, usize>,
}

impl TypedLines {
    /// Adds a line with the type that the file gives it: 1 contour, 2 mountain or 3 valley. Lines of other types are only
    /// counted. On the screen of ORIPA y points down, so this function negates y to show the sheet as it was drawn.
    /// Returns `None` if there are too many lines.
    pub(super) fn add(&mut self, kind: i64, [x0, y0, x1, y1]: [f64; 4]) -> Option<()> {
        let letter = match kind {
            1 => Letter::Boundary,
            2 => Letter::Mountain,
            3 => Letter::Valley,
            other => {
                *self.left_out.entry(other).or_default() += 1;
                return Some(());
            }
        };
        if self.segments.len() == MAX_LINES {
            return None;
        }
        self.segments.push(Segment {
            ends: [Vector2::new(x0, -y0), Vector2::new(x1, -y1)],
            letter,
            goal: None,
        });
        Some(())
    }

    /// Returns the lines with notes of those that were left out. `type_0` names the lines of type 0.
    pub(super) fn into_loose(self, type_0: &str) -> LooseLines {
        let left_out = self.left_out.into_iter().map(|(kind, count)| match kind {
            0 => format!("{type_0} (type 0) left out: {count}"),
            4 => format!("auxiliary lines (type 4) left out: {count}"),
            other => format!("lines of type {other}, taken as auxiliary, left out: {count}"),
        });
        LooseLines {
            segments: self.segments,
            y_down: true,
            notes: left_out.collect(),
            ..LooseLines::default()
        }
    }
}
