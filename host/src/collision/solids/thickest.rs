//! Finds how thick the plates of a sheet may be.

use std::sync::Arc;

use super::{PlateError, Plates, Trims};
use crate::collision::{Crossing, Place, SweepVerdict};
use crate::motion::{PlateOptions, PlateSides};
use crate::pattern::CreasePattern;
use crate::util::nan_max::diagonal;

/// Ratio of the upper value to the lower one with which the search ends.
const NEAR_ENOUGH: f64 = 1.01;
/// Ratio up to which upright plates of a range of thicknesses are proved at once, at first and at last.
const RANGES: [f64; 2] = [1.5, 1.002];
/// Ratio of the least thickness that is tried to the median edge.
const LEAST_EDGES: f64 = 1e-5;
/// Ratio of the thickness at which a panel is used up to the largest that is tried.
const USED_UP_ROOM: f64 = 1.005;
/// Number of halvings in the search for the thickness at which a panel is used up.
const HALVINGS: u32 = 40;

/// Answer of a search for crossings of plates of one thickness.
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub enum TooThick {
    /// These panels pass through each other, first at this place.
    Cross(Crossing, Place),
    /// The plates cannot be made.
    NotMade(PlateError),
}

/// The largest thickness of plates, between two bounds.
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub struct Thickest {
    /// Thickness up to which plates are proved to be free of crossings, units of the sheet; 0 if none is.
    pub proved: f64,
    /// Thickness at which they are not, and why; `None` if plates as thick as the sheet is wide are free.
    pub refuted: Option<(f64, TooThick)>,
    /// `true` if the search could not decide a thickness between the two.
    pub is_open: bool,
}

/// Answer of a search for crossings of plates.
enum Tried {
    Free,
    Refuted(TooThick),
    Open,
}

/// Finds how thick the plates of a sheet may be for a motion that needs these trims.
/// `search` looks for crossings of plates. Thicknesses beyond the first that fails are not looked at.
pub(crate) fn thickest(
    pattern: &CreasePattern,
    trims: &Trims,
    options: &PlateOptions,
    mut search: impl FnMut(Arc<Plates>) -> SweepVerdict,
) -> Thickest {
    let made = |least: f64, thickness: f64| {
        let options = options.with(|it| it.thickness = thickness);
        Plates::of_all(pattern, trims, &options, least)
    };
    let mut tried = |least: f64, thickness: f64| match made(least, thickness) {
        Err(error) => Tried::Refuted(TooThick::NotMade(error)),
        Ok(plates) => match search(Arc::new(plates)) {
            SweepVerdict::Free(_) => Tried::Free,
            SweepVerdict::Crossing { crossing, at, .. } => {
                Tried::Refuted(TooThick::Cross(crossing, at))
            }
            SweepVerdict::Undecided { .. } => Tried::Open,
        },
    };
    let least = LEAST_EDGES * pattern.median_edge();
    let mut found = Thickest {
        proved: 0.0,
        refuted: None,
        is_open: false,
    };
    // The thickness at which the first panel is used up, or else the width of the sheet.
    let mut most = diagonal(pattern.vertices());
    if let Err(error) = made(most, most) {
        let (mut low, mut last) = (0.0, error);
        for _ in 0..HALVINGS {
            let middle = f64::midpoint(low, most);
            match made(middle, middle) {
                Ok(_) => low = middle,
                Err(error) => (most, last) = (middle, error),
            }
        }
        found.refuted = Some((most, TooThick::NotMade(last)));
        if matches!(last, PlateError::TurnsTooFar { .. }) {
            return found;
        }
        // Something is left of the panel.
        most = low / USED_UP_ROOM;
    }
    let is_taper = options.sides == PlateSides::Taper;
    // Solids that contain the plates of all smaller thicknesses; a crossing of theirs refutes tapered plates alone.
    let mut next = most;
    while next >= least {
        let answer = tried(0.0, next);
        match answer {
            Tried::Free => {
                found.proved = next;
                break;
            }
            Tried::Refuted(why) if is_taper => found.refuted = Some((next, why)),
            Tried::Refuted(_) => {}
            Tried::Open => found.is_open = true,
        }
        next /= 2.0;
    }
    if is_taper {
        let mut high = found.refuted.map_or(found.proved, |(high, _)| high);
        while found.proved > 0.0 && high > NEAR_ENOUGH * found.proved {
            let middle = (found.proved * high).sqrt();
            match tried(0.0, middle) {
                Tried::Free => found.proved = middle,
                Tried::Refuted(why) => found.refuted = Some((middle, why)),
                Tried::Open => found.is_open = true,
            }
            if found.proved < middle {
                high = middle;
            }
        }
        found.is_open &= found
            .refuted
            .is_none_or(|(high, _)| high > NEAR_ENOUGH * found.proved);
        return found;
    }
    // Plates of one range of thicknesses after the other.
    found.is_open = false;
    let mut ratio = RANGES[0];
    while found.proved > 0.0 && found.proved < most {
        let next = (found.proved * ratio).min(most);
        if matches!(tried(found.proved, next), Tried::Free) {
            found.proved = next;
            ratio = (ratio * ratio).min(RANGES[0]);
        } else if ratio > RANGES[1] {
            ratio = ratio.sqrt();
        } else {
            break;
        }
    }
    if found.proved < most {
        let next = (found.proved.max(least) * NEAR_ENOUGH).min(most);
        match tried(next, next) {
            Tried::Refuted(why) => found.refuted = Some((next, why)),
            Tried::Free | Tried::Open => found.is_open = true,
        }
    }
    found
}
