//! Measured angles for telemetry: a window of hinges that goes round the sheet, so that no board needs memory for all.

use foldpath_core::wire::message::ToHost;

use crate::jog::Jog;

/// Largest number of hinges in a window.
const MAX_WINDOW_HINGES: u16 = 48;

/// The angles that were measured of some hinges in a tick.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Window {
    /// Number of the first hinge of the next window of the sheet.
    next: u16,
    /// Number of the first hinge of this window, its commanded angle if it is moved alone, and the number of hinges; 0 if
    /// there is nothing to tell.
    first: u16,
    target: Option<f32>,
    count: u16,
    pub(crate) angles: [[u8; 4]; MAX_WINDOW_HINGES as usize],
}

impl Window {
    pub(crate) const fn new() -> Self {
        Self {
            next: 0,
            first: 0,
            target: None,
            count: 0,
            angles: [[0; 4]; MAX_WINDOW_HINGES as usize],
        }
    }

    /// Begins a window: of the hinge alone that is watched or moved, or of the hinges behind the window before.
    #[inline(never)]
    pub(crate) fn begin(&mut self, alone: Option<u16>) {
        self.first = alone.unwrap_or(self.next);
        self.count = if alone.is_some() {
            1
        } else {
            MAX_WINDOW_HINGES
        };
        self.target = None;
    }

    /// Returns the number of the window's first hinge, which the sheet may not have.
    pub(crate) fn first(&self) -> usize {
        self.first.into()
    }

    /// Returns the place for the angle of a hinge, if the hinge is in the window.
    pub(crate) fn place(&mut self, hinge: u32) -> Option<&mut [u8; 4]> {
        let place = hinge.checked_sub(self.first.into())?;
        let angles = self.angles.get_mut(..usize::from(self.count))?;
        angles.get_mut(usize::try_from(place).ok()?)
    }

    /// Ends a window on a sheet of `hinges` hinges, of which one in the window was `measured` or none.
    pub(crate) fn end(&mut self, measured: bool, hinges: usize) {
        let hinges = u16::try_from(hinges).unwrap_or(u16::MAX);
        let next = self.first.saturating_add(self.count);
        self.next = if next < hinges { next } else { 0 };
        self.count = if measured {
            self.count.min(hinges.saturating_sub(self.first))
        } else {
            0
        };
    }

    /// Makes this the window of the hinge alone that is watched or moved: of its newest measured and its commanded angle.
    #[inline(never)]
    pub(crate) fn narrow(&mut self, jog: &Jog, fresh: u32) {
        let measured = jog.measured(fresh);
        self.target = jog.target().map(|target| target.angle);
        let [bytes, ..] = &mut self.angles;
        *bytes = measured.unwrap_or(f32::NAN).to_le_bytes();
        self.next = 0;
        self.count = u16::from(measured.is_some() || self.target.is_some());
    }

    /// Drops the window, because it was told or is too old.
    pub(crate) fn clear(&mut self) {
        self.count = 0;
    }

    /// Returns the message that tells this window at `time`, microseconds; `None` if there is nothing to tell.
    pub(crate) fn message(&self, time: u64) -> Option<ToHost<'_>> {
        let angles = self.angles.get(..usize::from(self.count))?;
        (!angles.is_empty()).then_some(ToHost::Measured {
            time,
            first: self.first,
            target: self.target,
            angles: angles.as_flattened(),
        })
    }
}
