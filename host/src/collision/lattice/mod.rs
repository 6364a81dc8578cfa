//! Pairs of faces of a tessellation that move alike: one pair stands for all.

mod disk;
mod pairs;

pub(super) use pairs::CellPairs;
