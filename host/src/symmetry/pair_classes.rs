//! Classes of pairs of faces that move alike, so that one pair of each class stands for all.

use core::ops::RangeInclusive;

use super::lattice::{Lattice, Orbit, Place};
use crate::pattern::FaceId;

/// The pairs of a face of one orbit and a face of another orbit, or of the same orbit, with a fixed difference of
/// cells.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct PairClass {
    /// The two orbits, the smaller first.
    pub orbits: [u32; 2],
    /// The second face's cell minus the first's. Within one orbit the offset leads to a later row, or to a later column
    /// of the same row, because the opposite offset gives the same pairs.
    pub offset: [i32; 2],
}

impl Lattice {
    /// Returns the class of a pair of faces, and the pair in the order of the class; `None` for a face and itself.
    #[must_use]
    pub fn class_of(&self, [a, b]: [FaceId; 2]) -> Option<(PairClass, [FaceId; 2])> {
        // The first face is the one of the earlier orbit, then of the earlier row, then of the earlier column.
        let order = |face| {
            let Place { orbit, cell } = self.place(face);
            (orbit, cell[1], cell[0])
        };
        let [first, second] = if order(a) <= order(b) { [a, b] } else { [b, a] };
        let (from, to) = (self.place(first), self.place(second));
        let class = PairClass {
            orbits: [from.orbit, to.orbit],
            offset: [0, 1].map(|k| to.cell[k] - from.cell[k]),
        };
        (a != b).then_some((class, [first, second]))
    }

    /// Iterates over all classes of pairs of faces, each once. If a row of cells has gaps, some classes may be empty;
    /// [`pair_of`](Self::pair_of) then returns `None`. Cost: O(classes + rows²).
    pub fn pair_classes(&self) -> impl Iterator<Item = PairClass> + '_ {
        let count = u32::try_from(self.orbits().len()).unwrap_or(u32::MAX);
        (0..count).flat_map(move |a| (a..count).flat_map(move |b| self.classes_between([a, b])))
    }

    fn classes_between(&self, orbits: [u32; 2]) -> impl Iterator<Item = PairClass> + '_ {
        let [a, b] = orbits.map(|orbit| &self.orbits()[orbit as usize]);
        let rows = b.low[1].saturating_sub(a.high[1])..=b.high[1].saturating_sub(a.low[1]);
        let same = orbits[0] == orbits[1];
        rows.flat_map(move |row| {
            let columns = self.columns_between([a, b], row);
            let offsets = columns.map(move |column| [column, row]);
            offsets.filter(move |&[column, row]| !same || (row, column) > (0, 0))
        })
        .map(move |offset| PairClass { orbits, offset })
    }

    /// Returns the range of differences of columns between faces of two orbits that are `rows` rows apart. If a row has
    /// gaps, the range may contain differences that do not occur. Cost: O(rows).
    pub(crate) fn columns_between(&self, [a, b]: [&Orbit; 2], rows: i32) -> RangeInclusive<i32> {
        let (mut low, mut high) = (i32::MAX, i32::MIN);
        let first = a.low[1].max(b.low[1].saturating_sub(rows));
        let last = a.high[1].min(b.high[1].saturating_sub(rows));
        for row in first..=last {
            let (from, to) = (self.row(a, row), self.row(b, row.saturating_add(rows)));
            if let (Some([a, b]), Some([c, d])) = (span(from), span(to)) {
                (low, high) = (low.min(c - b), high.max(d - a));
            }
        }
        low..=high
    }

    /// Returns, for each difference of rows from 0 on, the range of differences of columns between any two faces that
    /// many rows apart. If a row has gaps, a range may contain differences that do not occur. Cost: O(faces + rows²).
    pub(crate) fn columns_of_rows(&self) -> Vec<RangeInclusive<i32>> {
        let orbits = || self.orbits().iter();
        let first = orbits().map(|orbit| orbit.low[1]).min().unwrap_or_default();
        let last = orbits()
            .map(|orbit| orbit.high[1])
            .max()
            .unwrap_or_default();
        let rows = (first..=last).map(|row| {
            let spans = orbits().filter_map(|orbit| {
                (orbit.low[1]..=orbit.high[1])
                    .contains(&row)
                    .then(|| span(self.row(orbit, row)))
                    .flatten()
            });
            spans.reduce(|[a, b], [c, d]| [a.min(c), b.max(d)])
        });
        let rows: Vec<_> = rows.collect();
        let columns = (0..rows.len()).map(|apart| {
            let pairs = rows.iter().zip(&rows[apart..]);
            let both = pairs.filter_map(|(from, to)| Some((from.as_ref()?, to.as_ref()?)));
            let (low, high) = both.fold((i32::MAX, i32::MIN), |(low, high), ([a, b], [c, d])| {
                (low.min(c - b), high.max(d - a))
            });
            low..=high
        });
        columns.collect()
    }

    /// Returns a pair of faces of the class, if the sheet has one, preferably in the middle of the sheet and not at its
    /// border. Cost: logarithmic if there is a pair in the middle, else up to O(faces of the orbit) times a logarithm.
    #[must_use]
    pub fn pair_of(&self, class: PairClass) -> Option<[FaceId; 2]> {
        let [orbit, other] = class.orbits;
        let [dx, dy] = class.offset;
        let from = self.orbits().get(orbit as usize)?;
        let pair = |face: FaceId, [column, row]: [i32; 2]| {
            let cell = [column.checked_add(dx)?, row.checked_add(dy)?];
            let place = Place { orbit: other, cell };
            Some([face, self.face_at(place)?])
        };
        let middle = from.representative;
        pair(middle, self.place(middle).cell).or_else(|| {
            (from.low[1]..=from.high[1]).find_map(|row| {
                let mut faces = self.row(from, row).iter();
                faces.find_map(|&(column, face)| pair(face, [column, row]))
            })
        })
    }

    /// Returns the number of all pairs of faces of the sheet, which the classes represent.
    #[must_use]
    pub fn pairs(&self) -> u64 {
        let faces = self.places().len() as u64;
        faces * faces.saturating_sub(1) / 2
    }
}

/// Returns the first and last column of a row, or `None` if the row is empty.
fn span(row: &[(i32, FaceId)]) -> Option<[i32; 2]> {
    Some([row.first()?.0, row.last()?.0])
}
