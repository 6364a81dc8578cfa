//! The plant that a simulated controller drives: hinges with drives and disturbances, and the sheet that they fold.

use std::collections::VecDeque;
use std::path::Path;
use std::sync::Arc;

use foldpath_core::follower::Measurement;
use foldpath_firmware_sim::hinges::{Drive, Hinges, Trouble};
use rand_pcg::Pcg64;

use super::{SimDevice, StreamPath};
use crate::export::traj::memberships;
use crate::folding::{FoldingMap, Rigidity};
use crate::motion::Motion;
use crate::pattern::CreasePattern;
use crate::read::FileError;

/// Hinges with drives in virtual time.
#[derive(Debug)]
pub struct Plant {
    hinges: Hinges<Pcg64>,
    /// Disturbances to come, each with its time in microseconds.
    script: VecDeque<(u64, Trouble)>,
    sheet: Option<FoldedSheet>,
}

/// The sheet that the hinges fold.
#[derive(Debug)]
struct FoldedSheet {
    pattern: Arc<CreasePattern>,
    map: FoldingMap,
    worst: Rigidity,
}

impl Plant {
    /// Makes the hinges of a path, which stand where the path begins. The noise of their drives is drawn from `seed`, and `script` has the
    /// disturbances with their times in microseconds.
    #[must_use]
    pub fn new(path: &StreamPath, drive: Drive, seed: u64, script: Vec<(u64, Trouble)>) -> Self {
        let mut hinges = Hinges::new(path.hinges(), drive, Pcg64::new(u128::from(seed), 2));
        if let Some(knot) = path.view().and_then(|view| view.knot(0)) {
            hinges.stand(knot.angles);
        }
        Self {
            hinges,
            script: script.into(),
            sheet: None,
        }
    }

    /// Adds the sheet of `file`, the FOLD file that the path was exported from.
    ///
    /// # Errors
    /// If the sheet has other hinges than the path.
    pub fn with_sheet(
        self,
        path: &StreamPath,
        sheet: Motion,
        file: &Path,
    ) -> Result<Self, FileError> {
        let hinges = memberships(&sheet, file)?;
        if hinges != path.hinges() {
            let place = "foldpath:edges_group";
            let sent = path.hinges().len();
            let expected = format!("the {sent} hinges of the path that is sent");
            let found = format!("{} hinges, or other groups of them", hinges.len());
            return Err(FileError::expected(file, place, expected, found));
        }
        let sheet = FoldedSheet {
            map: FoldingMap::flat(&sheet.pattern),
            pattern: sheet.pattern,
            worst: Rigidity::default(),
        };
        Ok(Self {
            sheet: Some(sheet),
            ..self
        })
    }

    /// Lets the hinges follow the angles commanded at `now` (microseconds) for a millisecond, and measures them.
    pub(super) fn turn(&mut self, now: u64, device: &mut SimDevice) {
        while let Some((_, trouble)) = self.script.pop_front_if(|(time, _)| *time <= now) {
            self.befall(trouble);
        }
        self.hinges.follow(device.follower().angles(), 1e-3);
        let mut measured = self.hinges.measured();
        device.drive(|_, _, _| measured.next().map(|(.., angle)| Measurement::from(angle)));
    }

    /// Lets a trouble befall the hinges now.
    pub fn befall(&mut self, trouble: Trouble) {
        self.hinges.befall(trouble);
    }

    /// Folds the sheet by the hinges' angles and measures its errors.
    pub(super) fn look(&mut self) {
        if let Some(sheet) = &mut self.sheet {
            sheet
                .map
                .fold(&sheet.pattern, sheet.pattern.tree(), &self.hinges.angles());
            let (pattern, tree) = (&sheet.pattern, sheet.pattern.tree());
            let mut now = sheet.map.rigidity(pattern, tree);
            // A hinge off the tree moves no face, and opens the sheet all the same.
            now.gap = now.gap.max(sheet.map.parting(pattern, tree));
            sheet.worst = sheet.worst.worse(now);
        }
    }

    /// Returns the largest errors of rigidity that the sheet had, if there is a sheet. The gap is also that of hinges off the
    /// tree along which it is folded.
    #[must_use]
    pub fn rigidity(&self) -> Option<Rigidity> {
        self.sheet.as_ref().map(|sheet| sheet.worst)
    }
}
