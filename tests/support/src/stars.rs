//! Stars that own their memory, and the vertices of the folds whose motions are known in closed form.

use foldpath_core::{GroupId, Scalar, Spoke, StarView, StarsView, local_foldability_matrix};

use crate::closed_form::{Waterbomb, miura_straight};
use crate::{Random, cast};

/// Stars that own their memory.
#[derive(Clone, Debug)]
pub struct Stars<T> {
    /// Spokes of all stars, one star after the other.
    pub spokes: Vec<Spoke<T>>,
    /// For each star the index into `spokes` behind its last spoke.
    pub ends: Vec<u32>,
    /// Number of groups, whose fold angles are the unknowns.
    pub unknowns: usize,
}

impl<T: Scalar> Stars<T> {
    /// Builds stars. Each is a list of spokes: plane angle in degrees, group, and `true` if the spoke folds against its
    /// group.
    ///
    /// # Panics
    ///
    /// Panics if there are more spokes than a u32 counts.
    #[must_use]
    pub fn new(unknowns: usize, stars: &[&[(f64, u32, bool)]]) -> Self {
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

    /// Draws one star for each of `degrees`, the numbers of spokes. Directions, signs and groups are random.
    ///
    /// # Panics
    ///
    /// Panics if there is a spoke but no unknown, or if either number exceeds `u32::MAX`.
    pub fn random(rng: &mut Random, unknowns: usize, degrees: &[usize]) -> Self {
        let stars: Vec<Vec<_>> = degrees
            .iter()
            .map(|&degree| {
                let mut angles: Vec<f64> = (0..degree).map(|_| rng.uniform(0.0, 360.0)).collect();
                angles.sort_by(f64::total_cmp);
                let spoke = |angle| {
                    let group = u32::try_from(rng.below(unknowns)).unwrap();
                    (angle, group, rng.below(2) == 0)
                };
                angles.into_iter().map(spoke).collect()
            })
            .collect();
        Self::new(
            unknowns,
            &stars.iter().map(Vec::as_slice).collect::<Vec<_>>(),
        )
    }

    /// Returns the stars as core's view.
    ///
    /// # Panics
    ///
    /// Panics if core refuses the stars because a spoke has no group or a direction is not a unit vector.
    #[must_use]
    pub fn view(&self) -> StarsView<'_, T> {
        StarsView::new(&self.spokes, &self.ends, self.unknowns).unwrap()
    }
}

/// Returns ‖L − I‖ (Frobenius norm) of the rotation part of a star's closure, by the report's 4x4 matrices. `unknowns`
/// are the fold angles of its groups, radians.
#[must_use]
pub fn foldability_error<T: Scalar>(star: StarView<'_, T>, unknowns: &[T]) -> f64 {
    let matrix = local_foldability_matrix(star, [T::zero(); 2], unknowns);
    let entry = |(i, j): (usize, usize)| {
        let identity = if i == j { 1.0 } else { 0.0 };
        matrix[(i, j)].to_f64() - identity
    };
    let places = (0..3).flat_map(|i| (0..3).map(move |j| (i, j)));
    places.map(|place| entry(place).powi(2)).sum::<f64>().sqrt()
}

/// Returns a Miura vertex. Group 0 are the zigzag creases (major), group 1 the straight creases (minor).
///
/// The pattern has four kinds of vertices: in `mirrored` ones the zigzag points the other way, and in `negated` ones
/// mountains and valleys are swapped.
#[must_use]
pub fn miura<T: Scalar>(sector_degrees: f64, mirrored: bool, negated: bool) -> Stars<T> {
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

/// Returns the fold angles of the groups of [`miura`], [major, minor] in radians, by the closed form.
#[must_use]
pub fn miura_angles(sector_degrees: f64, major: f64) -> [f64; 2] {
    [major, miura_straight(sector_degrees.to_radians(), major)]
}

/// Returns the two stars of the report's waterbomb: its centre and its corner. Groups, in this order: middle lines,
/// cross lines, diagonals, boundary lines.
#[must_use]
pub fn waterbomb<T: Scalar>() -> Stars<T> {
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

/// Returns the fold angles of the groups of [`waterbomb`], radians, by the closed form. `t` in 0..1 is the tangent of
/// half the angle of the middle lines.
#[must_use]
pub fn waterbomb_angles(t: f64) -> [f64; 4] {
    let Waterbomb {
        middle,
        cross,
        diagonal,
        boundary,
    } = Waterbomb::at(t);
    [middle, cross, diagonal, boundary]
}
