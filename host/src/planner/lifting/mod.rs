//! Does the whole sheet keep the bound all along the path, free of crossings?
//!
//! One entry point: [`lift`](whole_sheet::lift).

pub(super) mod certified_motion;
pub(super) mod lifted;
pub(super) mod measured_motion;
pub(super) mod swept_motion;
pub(super) mod whole_sheet;
