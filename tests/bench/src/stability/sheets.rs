//! Errors of the folding map on whole Miura sheets: several sizes, spanning trees and precisions, and one sheet through
//! its whole motion.

use core::fmt::Write;

use foldpath::folding::{FoldingMap, rounding};
use foldpath::pattern::{CreasePattern, Edge};
use foldpath_core::Scalar;

use super::big::Big;
use super::kernel::{Star, degrees};
use super::patterns::Mesh;
use super::reference::{self, minus};
use super::trees::{Kind, Tree, worst};

/// A Miura sheet of 60 degrees, with its straight creases marked.
pub struct Sheet {
    /// Faces along each side.
    pub size: usize,
    /// The pattern.
    pub pattern: CreasePattern,
    level: Vec<bool>,
}

impl Sheet {
    /// Creates a sheet of `size` x `size` unit faces.
    ///
    /// # Panics
    /// Never.
    #[must_use]
    pub fn new(size: usize) -> Self {
        let pattern = CreasePattern::new(Mesh::even(size).drawing()).expect("a good sheet");
        let level = |edge: &Edge| {
            let [a, b] = edge.ends.map(|end| pattern.vertices()[end.index()].y);
            (a - b).abs() < 1e-9
        };
        let creases = pattern.creases().iter();
        let level = creases.map(|&edge| level(pattern.edge(edge))).collect();
        Self {
            size,
            pattern,
            level,
        }
    }

    /// Returns the fold angles of all creases by the angles of zigzag and straight ones.
    pub fn angles<T: Scalar>(&self, [zigzag, straight]: [T; 2]) -> Vec<T> {
        let creases = self.pattern.creases().iter().zip(&self.level);
        let angle = |(&edge, &level): (_, &bool)| {
            let sign = self.pattern.edge(edge).letter.sign();
            T::lit(sign) * if level { straight } else { zigzag }
        };
        creases.map(angle).collect()
    }

    /// Returns the distances between opposite corners at a zigzag angle, by the closed form. The sheet repeats itself,
    /// so that two steps of a small sheet, folded by the reference, give the distances.
    fn diagonals(&self, zigzag: &Big) -> [Big; 2] {
        let small = Self::new(2);
        // The straight angle of the closed form is rounded to `f64`, because the reference takes such angles.
        let straight = reference::straight(&sector(), zigzag).to_f64();
        let angles = small.angles([zigzag.to_f64(), straight]);
        let folded = reference::Folded::new(&small.pattern, &angles).expect("a sheet in one part");
        let step = |to| {
            minus(
                folded.vertex(&small.pattern, to),
                folded.vertex(&small.pattern, 0),
            )
        };
        let (across, up) = (step(2), step(6));
        #[allow(clippy::cast_precision_loss, reason = "a number of rows")]
        let half = Big::new(self.size as f64 / 2.0);
        [1.0, -1.0].map(|way| {
            let sum = [0, 1, 2].map(|k| &(&across[k] * &Big::new(way)) + &up[k]);
            &reference::length(&sum) * &half
        })
    }
}

fn sector() -> Big {
    Big::new(60_f64.to_radians())
}

/// Errors of one way of folding a sheet.
#[derive(Clone, Copy, Debug)]
pub struct Errors {
    /// Deformation.
    pub deformation: f64,
    /// Gap, in median edges.
    pub gap: f64,
    /// Relative error of the distance between opposite corners.
    pub corners: f64,
}

/// Returns the errors of one tree, with the angles of the closed form rounded to `A` and the folding in `T`.
#[must_use]
pub fn errors<A: Scalar, T: Scalar>(sheet: &Sheet, tree: &Tree, zigzag: &Big) -> Errors {
    // The exact zigzag angle is the one that the type `A` represents.
    let zigzag = Big::new(A::lit(zigzag.to_f64()).to_f64());
    let straight = reference::straight(&sector(), &zigzag).to_f64();
    let rounded = [zigzag.to_f64(), straight].map(|angle| T::lit(A::lit(angle).to_f64()));
    let folded = tree.fold(&sheet.pattern, &sheet.angles(rounded));
    let [deformation, gap] = folded.rigidity(&sheet.pattern);
    let n = sheet.size;
    let pairs = [[0, (n + 1) * (n + 1) - 1], [n, n * (n + 1)]];
    let measured = pairs.map(|ends| {
        let [a, b] = ends.map(|end| folded.vertex(end));
        (a - b).norm()
    });
    let truth = sheet.diagonals(&zigzag);
    let off = measured.iter().zip(&truth);
    let corners = worst(off.map(|(x, exact)| (&(&Big::new(*x) - exact) / exact).to_f64().abs()));
    Errors {
        deformation,
        gap,
        corners,
    }
}

/// Returns the table of sizes and trees.
#[must_use]
pub fn sizes(sizes: &[usize], csv: &mut String) -> String {
    let mut table = String::from(
        "| sheet | tree | depth | f64: deformation | gap | corners | f32: deformation | gap | corners | f32 angles in \
         f64: deformation | gap |\n|---|---|---|---|---|---|---|---|---|---|---|\n",
    );
    csv.push_str("size,tree,depth,numbers,deformation,gap,corners\n");
    let zigzag = degrees(150.0);
    for &size in sizes {
        let sheet = Sheet::new(size);
        for kind in Kind::ALL {
            eprintln!("{size}x{size}, {}", kind.name());
            let tree = Tree::new(&sheet.pattern, kind);
            let [double, single, mixed] = [
                errors::<f64, f64>(&sheet, &tree, &zigzag),
                errors::<f32, f32>(&sheet, &tree, &zigzag),
                errors::<f32, f64>(&sheet, &tree, &zigzag),
            ];
            let (name, depth) = (kind.name(), tree.depth());
            let _ok = writeln!(
                table,
                "| {size}x{size} | {name} | {depth} | {:.1e} | {:.1e} | {:.1e} | {:.1e} | {:.1e} | {:.1e} | {:.1e} | \
                 {:.1e} |",
                double.deformation,
                double.gap,
                double.corners,
                single.deformation,
                single.gap,
                single.corners,
                mixed.deformation,
                mixed.gap,
            );
            for (numbers, e) in [("f64", double), ("f32", single), ("f32 in f64", mixed)] {
                let Errors {
                    deformation,
                    gap,
                    corners,
                } = e;
                let _ok = writeln!(
                    csv,
                    "{size},{name},{depth},{numbers},{deformation:e},{gap:e},{corners:e}"
                );
            }
        }
    }
    table
}

/// Largest deformation and gap of a sheet over a motion.
#[derive(Clone, Copy, Debug, Default)]
pub struct Motion {
    /// Errors of the library's folding map, with angles solved by core in `f64`.
    pub double: [f64; 2],
    /// Bound on rounding errors that the library gives for it.
    pub allowed: [f64; 2],
    /// Errors of the folding map in `f32`, with angles solved by core in `f32`.
    pub single: [f64; 2],
    /// Errors of the library's folding map in `f64`, with angles solved in `f32`, as on a controller.
    pub mixed: [f64; 2],
}

/// Folds a sheet through zigzag angles (degrees); core solves for the straight angle.
#[must_use]
pub fn motion(sheet: &Sheet, zigzags: &[f64]) -> Motion {
    let tree = sheet.pattern.tree();
    let central = Tree::new(&sheet.pattern, Kind::Central);
    let bound = rounding(&sheet.pattern, tree);
    let mut motion = Motion {
        allowed: [bound.deformation, bound.gap],
        ..Motion::default()
    };
    let raise = |worst: &mut [f64; 2], found: [f64; 2]| {
        for (worst, found) in worst.iter_mut().zip(found) {
            if found > *worst || found.is_nan() {
                *worst = found;
            }
        }
    };
    let by_map = |angles: &[f64]| {
        let map = FoldingMap::new(&sheet.pattern, tree, angles);
        let rigidity = map.rigidity(&sheet.pattern, tree);
        [rigidity.deformation, rigidity.gap]
    };
    for &zigzag in zigzags {
        let zigzag = degrees(zigzag);
        let double = sheet.angles(Star::<f64>::miura(&sector()).closed(&zigzag));
        raise(&mut motion.double, by_map(&double));
        let single = sheet.angles(Star::<f32>::miura(&sector()).closed(&zigzag));
        let folded = central.fold(&sheet.pattern, &single);
        raise(&mut motion.single, folded.rigidity(&sheet.pattern));
        let mixed: Vec<_> = single.iter().map(|&angle| f64::from(angle)).collect();
        raise(&mut motion.mixed, by_map(&mixed));
    }
    motion
}
