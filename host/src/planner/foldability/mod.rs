//! Stage "will it fold?": foresees from the flat sheet whether it folds, and names what is in the way.

pub(crate) mod cause;
pub(crate) mod certificate;
pub(crate) mod flat_cone;
pub(crate) mod forecast;
mod locked_loop;
mod products;
pub(crate) mod stacking;
