//! The rows of the report's tables.

use core::time::Duration;

use foldpath::generate::{Miura, ParameterError, Quad, Waterbomb};
use foldpath::pattern::Drawing;

use super::search::{Accept, Settings};
use super::sheet::{Freedom, Sheet};
use super::tune::Tuning;

/// Amount of work of the section.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Extent {
    /// A few rows, in seconds.
    Short,
    /// All rows, in minutes.
    Full,
}

/// A sheet of the report.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Kind {
    Miura,
    Quad,
    Waterbomb,
}

/// A row of a table.
#[derive(Clone, Copy, Debug)]
pub struct Case {
    pub(super) kind: Kind,
    /// Numbers of rows and columns, as the report counts them.
    pub(super) size: [usize; 2],
    /// Kind of unknowns and closure conditions.
    pub freedom: Freedom,
    /// Bound on deformation.
    pub bound: f64,
    /// Seconds that a run of the report's method may take.
    pub(super) limit: f64,
}

impl Case {
    /// Returns the name of the sheet.
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

    /// Returns the sheet.
    #[must_use]
    pub fn sheet(&self) -> Sheet {
        Sheet::new(drawing(self.kind, self.size), self.freedom)
    }

    /// Returns the condition under which the report's method accepts a configuration.
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

/// Returns the report's sheets with its goals: the Miura with sector angles of 60 degrees to 170 degrees; the waterbomb
/// until its boundary lines turn 59 degrees more than its middle lines; and the quadrilaterals, which do not fold.
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
/// Seconds that a run may take on rows that the report's method can hardly solve.
pub(super) const SHORT_LIMIT: f64 = 10.0;
/// Bound on deformation in Table 2.
const BOUND: f64 = 0.05;

/// Returns the rows of Table 1: full DOF, several bounds.
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

/// Returns the rows of Table 2: symmetry and essential vertices. The size 11x11 is not in the report's table.
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

/// Returns rows for paths that close to nine digits.
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

/// Returns the settings of a run for a figure, which is not timed.
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
