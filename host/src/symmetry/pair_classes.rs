//! Classes of pairs of faces that move alike.

use core::ops::RangeInclusive;

use super::lattice::{Lattice, Orbit, Place};
use crate::pattern::FaceId;

/// Pairs of a face of one orbit and a face of another, or of the same, so many cells on.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct PairClass {
    /// The orbits, the smaller first.
    pub orbits: [u32; 2],
    /// The second face's cell less the first's. Where the orbits are the same, it leads to a later row,
    /// or on in the same: the opposite means the same pairs.
    pub offset: [i32; 2],
}

impl Lattice {
    /// The class of a pair of faces, and the two in its order; `None` for a face and itself.
    #[must_use]
    pub fn class_of(&self, [a, b]: [FaceId; 2]) -> Option<(PairClass, [FaceId; 2])> {
        // From a later orbit, row or column of cells to an earlier one is the wrong way round.
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

    /// All classes of pairs of faces, each once, and where a row of cells has gaps perhaps some that are
    /// empty: then [`pair_of`](Self::pair_of) finds none. Cost: O(classes + rows²).
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

    /// Differences of columns of faces so many rows apart, and where a row has gaps perhaps others. Cost: O(rows).
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

    /// For each difference of rows from 0 on, differences of columns of faces so many rows apart, and where a row has
    /// gaps perhaps others. Cost: O(faces + rows²).
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

    /// A pair of faces of the class, in the middle of the sheet rather than at its border, if the sheet has
    /// one. Cost: O(faces of the orbit) times a logarithm, if it has none there.
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

    /// Number of pairs of faces of the sheet, which the classes stand for.
    #[must_use]
    pub fn pairs(&self) -> u64 {
        let faces = self.places().len() as u64;
        faces * faces.saturating_sub(1) / 2
    }
}

/// First and last column of a row.
fn span(row: &[(i32, FaceId)]) -> Option<[i32; 2]> {
    Some([row.first()?.0, row.last()?.0])
}
