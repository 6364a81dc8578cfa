//! Counts the repairs of a drawing and describes them in sentences.

use nalgebra::Vector2;

use super::missing_border::MissingBorder;
use super::near_lines::Misses;
use super::open_ends::Removed;
use super::perforation::Perforations;
use crate::pattern::rounded;

/// Open ends that were joined.
#[derive(Default)]
pub(super) struct Joined {
    pub(super) count: usize,
    /// Largest distance by which an end was moved.
    farthest: f64,
    /// Place to which the first end was moved.
    first: Vector2<f64>,
}

impl Joined {
    pub(super) fn add(&mut self, distance: f64, to: Vector2<f64>) {
        if self.count == 0 {
            self.first = to;
        }
        self.count += 1;
        self.farthest = self.farthest.max(distance);
    }
}

/// Numbers of repairs of each kind, and the largest distances by which ends were moved.
#[derive(Default)]
pub(super) struct Repairs {
    pub(super) short: usize,
    pub(super) moved: usize,
    pub(super) farthest: f64,
    pub(super) crossings: usize,
    pub(super) passed: usize,
    pub(super) twice: usize,
    pub(super) both_ways: usize,
    pub(super) to_vertices: Joined,
    pub(super) to_lines: Joined,
    /// Creases that were drawn in pieces.
    pub(super) perforations: Perforations,
    /// Cuts that were removed because they end inside a panel.
    pub(super) slits: Option<Removed>,
    /// Other lines that were removed because they end in the open.
    pub(super) removed: Option<Removed>,
    /// Vertices that are left near a line without meeting it.
    pub(super) misses: Option<Misses>,
    /// Points within this distance of each other are one place.
    pub(super) tolerance: f64,
    /// The tolerance that follows from the lines.
    pub(super) usual_tolerance: f64,
    /// Sides of the sheet where lines end in the open because no border is drawn.
    pub(super) missing_borders: Vec<MissingBorder>,
}

impl Repairs {
    /// Describes the repairs; lines left out because they end in the open are told elsewhere. `drawn` takes a place to
    /// the drawing's own coordinates.
    pub(super) fn in_words(&self, drawn: impl Fn(Vector2<f64>) -> [f64; 2]) -> Vec<String> {
        let &Self {
            short,
            moved,
            farthest,
            crossings,
            passed,
            twice,
            both_ways,
            ref to_vertices,
            ref to_lines,
            perforations,
            tolerance,
            ..
        } = self;
        let [x, y] = drawn(to_lines.first).map(rounded);
        let said = [
            (
                short,
                format!("lines shorter than the tolerance {tolerance:.3e} left out: {short}"),
            ),
            (
                moved,
                format!(
                    "ends of lines within the tolerance {tolerance:.3e} of each other joined: {moved}, \
                     moved by {farthest:.1e} at most"
                ),
            ),
            (
                crossings,
                format!("crossings without a vertex, both lines split there: {crossings}"),
            ),
            (
                passed,
                format!(
                    "lines that pass a vertex within the tolerance {tolerance:.3e} split there: {passed} \
                     places"
                ),
            ),
            (
                twice,
                format!(
                    "lines that lie on another left out: {twice} (kept is a cut before M or V, before \
                     U, before a border, before F)"
                ),
            ),
            (
                both_ways,
                format!("of them lettered M and V at one place, the first drawn kept: {both_ways}"),
            ),
            (
                perforations.pieces,
                format!(
                    "pieces of creases with gaps between them, joined along their lines: {} to {} lines, \
                     gaps of {:.1e} at most",
                    perforations.pieces, perforations.lines, perforations.largest_gap
                ),
            ),
            (
                to_vertices.count,
                format!(
                    "open ends joined to the one vertex near them: {}, moved by {:.1e} at most",
                    to_vertices.count, to_vertices.farthest
                ),
            ),
            (
                to_lines.count,
                format!(
                    "open ends joined to the line near them: {}, moved by {:.1e} at most, the first to \
                     ({x}, {y})",
                    to_lines.count, to_lines.farthest
                ),
            ),
        ];
        let said = said.into_iter().filter(|(count, _)| *count > 0);
        let said = said.map(|(_, words)| words);
        let slits = self.slits.iter().map(|slits| {
            let [x, y] = drawn(slits.open_end).map(rounded);
            format!(
                "cuts that end inside a panel, and part nothing, left out: {}, up to {:.1e} long, the first end at \
                 ({x}, {y})",
                slits.count, slits.longest
            )
        });
        let slits: Vec<String> = slits.collect();
        said.chain(slits)
            .chain(self.borders_in_words(drawn))
            .collect()
    }

    /// Names the sides where a border is missing.
    pub(super) fn borders_in_words(
        &self,
        drawn: impl Fn(Vector2<f64>) -> [f64; 2],
    ) -> impl Iterator<Item = String> {
        let borders = self.missing_borders.iter();
        borders.map(move |&MissingBorder { ends, lines }| {
            let [[x, y], [u, v]] = ends.map(|end| drawn(end).map(rounded));
            let place = if ends[0] == ends[1] {
                "all round the drawing".into()
            } else {
                format!("from ({x}, {y}) to ({u}, {v})")
            };
            format!("a border is missing {place}, where lines end in the open: {lines}")
        })
    }
}
