//! Helpers that the tests of all packages share: seeded noise, stars, closed forms, commands in temporary folders, and
//! JSON documents.
//!
//! The crate depends on no package but `foldpath-core`, so that core's tests build without the host.

pub mod closed_form;
mod folder;
mod json;
mod precision;
mod random;
pub mod stars;

pub use folder::{Answer, Folder};
pub use json::{edited, numbers};
pub use precision::cast;
pub use random::Random;

use foldpath_core::acceptance::{Refusal, Setpoint, SheetView};
use foldpath_core::follower::{CheckedOptions, Follower, FollowerPosition, Measurement};
use foldpath_core::trajectory_file::TrajectoryFile;
use foldpath_core::{Curve, Membership, Scalar};

/// Returns the spans of knots that are `step` seconds apart: 0 at the first.
#[must_use]
pub fn spans<T: Scalar>(knots: usize, step: T) -> Vec<T> {
    let mut spans = vec![step; knots];
    if let Some(first) = spans.first_mut() {
        *first = T::zero();
    }
    spans
}

/// Returns the motion of a group in a file from knot number `segment` to the next knot; `None` if there is none.
#[must_use]
pub fn curve(file: &TrajectoryFile<'_>, segment: usize, group: usize) -> Option<Curve<f32>> {
    let next = segment.checked_add(1)?;
    let (from, to) = (file.node(segment, group)?, file.node(next, group)?);
    Some(Curve::between(
        file.interpolation(),
        file.span(next)?,
        from,
        to,
    ))
}

/// Asks a follower on this sheet whether it takes `next` as the setpoint behind `before`.
///
/// # Errors
/// The reason why it does not.
///
/// # Panics
/// If the follower does not take the sheet or `before`.
pub fn takes<T: Scalar, const GROUPS: usize>(
    sheet: &SheetView<'_, T>,
    before: Option<&Setpoint<T, GROUPS>>,
    next: &Setpoint<T, GROUPS>,
) -> Result<(), Refusal> {
    let mut follower = Follower::<T, GROUPS, 4>::new(CheckedOptions::default());
    let place = FollowerPosition {
        knot: before.unwrap_or(next).number,
        into: T::zero(),
    };
    follower.load(sheet, place).expect("a sheet");
    if let Some(before) = before {
        let taken = follower.accept(sheet, before.clone());
        taken.expect("a setpoint to begin at");
    }
    follower.accept(sheet, next.clone())
}

/// Measures one hinge alone, without a command for it.
pub trait Measure<T> {
    /// Takes the measured angle of this hinge.
    fn measure(
        &mut self,
        hinge: u32,
        membership: Membership,
        measurement: impl Into<Measurement<T>>,
    );
}

impl<T: Scalar, const GROUPS: usize, const KNOTS: usize> Measure<T> for Follower<T, GROUPS, KNOTS> {
    fn measure(
        &mut self,
        hinge: u32,
        membership: Membership,
        measurement: impl Into<Measurement<T>>,
    ) {
        let measurement = measurement.into();
        let member = [membership].into_iter();
        self.drive_from(hinge, member, |_, _, _| Some(measurement));
    }
}
