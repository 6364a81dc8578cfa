//! The rows of the report's tables.

use core::time::Duration;

use foldpath::generate::{Miura, ParameterError, Quad, Waterbomb};
use foldpath::pattern::Drawing;

use super::search::{Accept, Settings};
use super::sheet::{Freedom, Sheet};
use super::tune::Tuning;

/// How much is measured.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Extent {
    /// A few rows, in seconds.
    Short,
    /// Everything, in minutes.
    Full,
}

/// A sheet of the report.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Kind {
    Miura,
    Quad,
    Waterbomb,
}

/// A row.
#[derive(Clone, Copy, Debug)]
pub struct Case {
    pub(super) kind: Kind,
    /// Rows and columns, as the report counts them.
    pub(super) size: [usize; 2],
    /// What is unknown.
    pub freedom: Freedom,
    /// On deformation.
    pub bound: f64,
    /// Seconds that the report's method may take.
    pub(super) limit: f64,
}

impl Case {
    /// Name of the sheet.
    #[must_use]
    pub fn name(&self) -> String {
        let [rows, columns] = self.size;
        let kind = match self.kind {
            Kind::Miura => "Miura",
            Kind::Quad => "Quad",
            Kind::Waterbomb => "waterbomb",
        };
        format!("{rows}x{columns} {kind}")
    }

    /// The sheet.
    #[must_use]
    pub fn sheet(&self) -> Sheet {
        Sheet::new(drawing(self.kind, self.size), self.freedom)
    }

    /// What the report's method accepts.
    #[must_use]
    pub fn accept(&self) -> Accept {
        Accept::Deformation(self.bound)
    }

    pub(super) fn tuning(&self, extent: Extent) -> Tuning {
        let limit = Duration::from_secs_f64(self.limit);
        match extent {
            Extent::Short => Tuning {
                ladder: &[5, 100],
                seeds: 3,
                limit: limit.min(Duration::from_secs(1)),
            },
            Extent::Full => Tuning {
                ladder: &[5, 10, 25, 100, 500, 2000],
                seeds: 10,
                limit,
            },
        }
    }
}

/// The sheets as the report folds them: Miura with sector angles of 60 degrees to 170 degrees, the waterbomb to
/// where its boundary lines turn 59 degrees more than its middle lines, and the quadrilaterals that do not fold.
pub(super) fn drawing(kind: Kind, [rows, columns]: [usize; 2]) -> Result<Drawing, ParameterError> {
    match kind {
        Kind::Miura => Miura {
            rows,
            columns,
            sector_angle: 60_f64.to_radians(),
            fold: 170.0 / 180.0,
        }
        .drawing(),
        Kind::Quad => Quad {
            rows,
            columns,
            fold: 0.0675,
        }
        .drawing(),
        Kind::Waterbomb => Waterbomb {
            rows,
            columns,
            fold: 0.522_504_840_831_969,
        }
        .drawing(),
    }
}

/// Seconds that a run of the report's method may take.
pub(super) const LIMIT: f64 = 60.0;
/// The same where it is asked for what it hardly can.
pub(super) const SHORT_LIMIT: f64 = 10.0;
/// The bound of Table 2.
const BOUND: f64 = 0.05;

/// Table 1: full DOF, and bounds.
pub(super) fn table_1(extent: Extent) -> Vec<Case> {
    let (kinds, bounds): (&[Kind], &[f64]) = match extent {
        Extent::Short => (&[Kind::Miura], &[0.05]),
        Extent::Full => (&[Kind::Miura, Kind::Quad], &[0.1, 0.05, 0.02, 0.01]),
    };
    let row = |kind, bound| Case {
        kind,
        size: [4, 4],
        freedom: Freedom::Full,
        bound,
        limit: SHORT_LIMIT,
    };
    let rows = kinds
        .iter()
        .flat_map(|&kind| bounds.iter().map(move |&bound| row(kind, bound)));
    rows.collect()
}

/// Table 2: symmetry and essential vertices. 11x11 is not in the report's.
pub(super) fn table_2(extent: Extent) -> Vec<Case> {
    let sheets: &[(Kind, [usize; 2])] = match extent {
        Extent::Short => &[(Kind::Miura, [3, 3]), (Kind::Waterbomb, [4, 6])],
        Extent::Full => &[
            (Kind::Miura, [3, 3]),
            (Kind::Miura, [5, 5]),
            (Kind::Miura, [11, 11]),
            (Kind::Miura, [24, 24]),
            (Kind::Waterbomb, [4, 6]),
            (Kind::Waterbomb, [8, 10]),
            (Kind::Waterbomb, [12, 22]),
        ],
    };
    let freedoms = [Freedom::Full, Freedom::Groups, Freedom::Essential];
    let rows = sheets.iter().flat_map(|&(kind, size)| {
        freedoms.map(|freedom| Case {
            kind,
            size,
            freedom,
            bound: BOUND,
            limit: LIMIT,
        })
    });
    rows.collect()
}

/// Paths closed to nine digits.
pub(super) fn accurate(extent: Extent) -> Vec<Case> {
    let full = [
        (Kind::Miura, [3, 3], Freedom::Full),
        (Kind::Miura, [3, 3], Freedom::Essential),
        (Kind::Miura, [24, 24], Freedom::Essential),
        (Kind::Waterbomb, [4, 6], Freedom::Full),
    ];
    let count = match extent {
        Extent::Short => 1,
        Extent::Full => full.len(),
    };
    let row = |&(kind, size, freedom): &(Kind, [usize; 2], Freedom)| Case {
        kind,
        size,
        freedom,
        bound: 1e-9,
        limit: SHORT_LIMIT,
    };
    full[..count].iter().map(row).collect()
}

/// Settings of a run that is drawn, not timed.
pub(super) fn drawn(case: &Case, accept: Accept, trial: &super::tune::Trial) -> Settings {
    Settings {
        algorithm: trial.algorithm,
        max_evaluations: trial.max_evaluations,
        accept,
        collision: true,
        seed: 0,
        limit: Duration::from_secs_f64(case.limit),
    }
}
