//! Classes of pairs of faces that move alike, so that one pair of each class stands for all.

use core::ops::RangeInclusive;

use super::orbits::{Lattice, LatticeCoord, Orbit};
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

impl PairClass {
    /// Returns the class of the pairs of a face of orbit `a` and a face of orbit `b` whose cells have this difference.
    pub(crate) fn of_orbits([a, b]: [usize; 2], [column, row]: [i32; 2]) -> Self {
        let (orbits, offset) = if a <= b {
            ([a, b], [column, row])
        } else {
            ([b, a], [-column, -row])
        };
        Self {
            orbits: orbits.map(|orbit| FaceId::new(orbit).0),
            offset,
        }
    }
}

impl Lattice {
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

    /// Returns all differences of cells in the sheet, and perhaps others between them in a row; `None` if there are
    /// more than `most`. If the lattice is oblique to the sheet, these are few of the differences in their bounding
    /// box.
    pub(crate) fn offsets(&self, most: usize) -> Option<Vec<[i32; 2]>> {
        let mut offsets = Vec::new();
        for (row, columns) in (0..).zip(self.columns_of_rows()) {
            let low = *columns.start();
            let low = if row == 0 { low.max(0) } else { low };
            offsets.extend((low..=*columns.end()).map(|column| [column, row]));
            if offsets.len() > most {
                return None;
            }
        }
        Some(offsets)
    }

    /// Returns, for each difference of rows from 0 on, the range of differences of columns between any two faces that
    /// many rows apart. If a row has gaps, a range may contain differences that do not occur. Cost: O(faces + rows²).
    fn columns_of_rows(&self) -> Vec<RangeInclusive<i32>> {
        let [_, [first, last]] = self.extent();
        let rows = (first..=last).map(|row| {
            let orbits = self.orbits().iter();
            let spans = orbits.filter_map(|orbit| span(self.row(orbit, row)));
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

    /// Returns all pairs of faces of the class. Cost: O(faces of the orbit) times a logarithm.
    pub(crate) fn pairs_of(&self, class: PairClass) -> impl Iterator<Item = [FaceId; 2]> + '_ {
        let [orbit, other] = class.orbits;
        let [dx, dy] = class.offset;
        let from = self.orbits().get(orbit as usize);
        let rows = from.into_iter().flat_map(move |from| {
            let rows = from.low[1]..=from.high[1];
            rows.flat_map(move |row| {
                self.row(from, row)
                    .iter()
                    .map(move |&(column, face)| ([column, row], face))
            })
        });
        rows.filter_map(move |([column, row], face)| {
            let cell = [column.checked_add(dx)?, row.checked_add(dy)?];
            Some([face, self.face_at(LatticeCoord { orbit: other, cell })?])
        })
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
            let coord = LatticeCoord { orbit: other, cell };
            Some([face, self.face_at(coord)?])
        };
        let middle = from.representative;
        pair(middle, self.coord(middle).cell).or_else(|| {
            (from.low[1]..=from.high[1]).find_map(|row| {
                let mut faces = self.row(from, row).iter();
                faces.find_map(|&(column, face)| pair(face, [column, row]))
            })
        })
    }
}

/// Returns the first and last column of a row, or `None` if the row is empty.
fn span(row: &[(i32, FaceId)]) -> Option<[i32; 2]> {
    Some([row.first()?.0, row.last()?.0])
}
