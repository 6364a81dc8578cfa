//! What several tests share: seeded numbers, stars written in degrees, and foldings known in closed
//! form.
#![allow(dead_code, reason = "each test file uses its part")]

use core::f64::consts::PI;

use foldpath_core::{GroupId, Scalar, Spoke, StarView, StarsView, local_foldability_matrix};
use rand_core::Rng;
use rand_pcg::Pcg64;

/// The generator for a test's `seed`.
pub(crate) fn rng(seed: u64) -> Pcg64 {
    Pcg64::new(u128::from(seed), 0)
}

/// A number between `low` and `high`, both possible.
pub(crate) fn uniform(rng: &mut impl Rng, low: f64, high: f64) -> f64 {
    low + (high - low) * f64::from(rng.next_u32()) / f64::from(u32::MAX)
}

/// One of 0 .. `count`.
pub(crate) fn below(rng: &mut impl Rng, count: usize) -> usize {
    rng.next_u32() as usize % count
}

/// The numbers in another precision.
pub(crate) fn cast<T: Scalar, const N: usize>(values: [f64; N]) -> [T; N] {
    values.map(T::lit)
}

/// Stars that own their memory.
#[derive(Debug)]
pub(crate) struct Stars<T> {
    pub(crate) spokes: Vec<Spoke<T>>,
    pub(crate) ends: Vec<u32>,
    pub(crate) unknowns: usize,
}

impl<T: Scalar> Stars<T> {
    /// Each spoke by its plane angle in degrees, group and sign.
    pub(crate) fn new(unknowns: usize, stars: &[&[(f64, u32, bool)]]) -> Self {
        let mut all = Self {
            spokes: Vec::new(),
            ends: Vec::new(),
            unknowns,
        };
        for star in stars {
            all.spokes
                .extend(star.iter().map(|&(degrees, group, negative)| {
                    let (sin, cos) = degrees.to_radians().sin_cos();
                    Spoke {
                        group: GroupId(group),
                        negative,
                        direction: cast([cos, sin]),
                    }
                }));
            all.ends.push(u32::try_from(all.spokes.len()).unwrap());
        }
        all
    }

    /// Stars of these degrees, with random directions, signs and groups.
    pub(crate) fn random(rng: &mut impl Rng, unknowns: usize, degrees: &[usize]) -> Self {
        let stars: Vec<Vec<_>> = degrees
            .iter()
            .map(|&degree| {
                let mut angles: Vec<f64> = (0..degree).map(|_| uniform(rng, 0.0, 360.0)).collect();
                angles.sort_by(f64::total_cmp);
                let spoke = |angle| {
                    let group = u32::try_from(below(rng, unknowns)).unwrap();
                    (angle, group, below(rng, 2) == 0)
                };
                angles.into_iter().map(spoke).collect()
            })
            .collect();
        Self::new(
            unknowns,
            &stars.iter().map(Vec::as_slice).collect::<Vec<_>>(),
        )
    }

    pub(crate) fn view(&self) -> StarsView<'_, T> {
        StarsView::new(&self.spokes, &self.ends, self.unknowns).unwrap()
    }
}

/// `count` fold angles anywhere in a full turn.
pub(crate) fn random_angles<T: Scalar>(rng: &mut impl Rng, count: usize) -> Vec<T> {
    (0..count).map(|_| T::lit(uniform(rng, -PI, PI))).collect()
}

/// ‖L − I‖ (Frobenius) of the rotation part, from the report's 4x4 matrices.
pub(crate) fn foldability_error<T: Scalar>(star: StarView<'_, T>, unknowns: &[T]) -> f64 {
    let matrix = local_foldability_matrix(star, [T::zero(); 2], unknowns);
    let entry = |(i, j): (usize, usize)| {
        let identity = if i == j { 1.0 } else { 0.0 };
        matrix[(i, j)].to_f64() - identity
    };
    let places = (0..3).flat_map(|i| (0..3).map(move |j| (i, j)));
    places.map(|place| entry(place).powi(2)).sum::<f64>().sqrt()
}

/// A Miura vertex: group 0 are the zigzag creases (major), group 1 the straight ones (minor).
///
/// Of its four kinds in the pattern, `mirrored` ones point the zigzag the other way and `negated`
/// ones swap mountains and valleys.
pub(crate) fn miura<T: Scalar>(sector_degrees: f64, mirrored: bool, negated: bool) -> Stars<T> {
    let sector = if mirrored {
        180.0 - sector_degrees
    } else {
        sector_degrees
    };
    Stars::new(
        2,
        &[&[
            (0.0, 1, mirrored == negated),
            (sector, 0, negated),
            (180.0, 1, mirrored != negated),
            (360.0 - sector, 0, negated),
        ]],
    )
}

/// The closed form tan(minor/2) = cos(sector) tan(major/2): (major, minor) in radians.
pub(crate) fn miura_angles(sector_degrees: f64, major: f64) -> [f64; 2] {
    let cos = sector_degrees.to_radians().cos();
    [major, 2.0 * (cos * (major / 2.0).tan()).atan()]
}

/// The report's waterbomb: its centre and its corner star, with groups m, r, d, b.
pub(crate) fn waterbomb<T: Scalar>() -> Stars<T> {
    const M: u32 = 0;
    const R: u32 = 1;
    const D: u32 = 2;
    const B: u32 = 3;
    let spoke = |degrees, group| (degrees, group, false);
    let centre = [
        spoke(45.0, D),
        spoke(90.0, M),
        spoke(135.0, D),
        spoke(225.0, D),
        spoke(270.0, M),
        spoke(315.0, D),
    ];
    let corner = [
        spoke(0.0, R),
        spoke(45.0, D),
        spoke(90.0, B),
        spoke(135.0, D),
        spoke(180.0, R),
        spoke(270.0, M),
    ];
    Stars::new(4, &[&centre, &corner])
}

/// The waterbomb's closed form: m, r, d, b in radians at the parameter t in 0..1.
pub(crate) fn waterbomb_angles(t: f64) -> [f64; 4] {
    let m = 2.0 * t.atan();
    let r = 2.0 * (2.0 * t).atan();
    let d = -2.0 * (2_f64.sqrt() * t).atan();
    [m, r, d, 2.0 * r - m]
}
