//! Closed forms of the motions of pattern families, taken from the design and not from foldpath's generators.
//! All angles are in radians.

use core::f64::consts::SQRT_2;

/// Returns the fold angle of the straight creases of a Miura sheet whose zigzag creases have the
/// fold angle `zigzag`: tan(straight/2) = cos(sector) tan(zigzag/2).
#[must_use]
pub fn miura_straight(sector_angle: f64, zigzag: f64) -> f64 {
    2.0 * (sector_angle.cos() * (zigzag / 2.0).tan()).atan()
}

/// Returns the fold angle of the diagonals of a Yoshimura sheet whose straight creases have the fold angle `straight`
/// and enclose the angle `gamma` with the diagonals: cos d = cos²ψ (1 − T²)/(1 + T²) − sin²ψ with ψ = v/2, T = sin ψ
/// tan γ.
#[must_use]
pub fn yoshimura_diagonal(gamma: f64, straight: f64) -> f64 {
    let (sin, cos) = (straight / 2.0).sin_cos();
    let t = sin * gamma.tan();
    // Without cancellation near flat: 1 − cos d = 2 (sin²ψ + T²)/(1 + T²).
    let half = ((sin * sin + t * t) / (1.0 + t * t)).sqrt();
    let rest = (cos * cos / (1.0 + t * t)).sqrt();
    -2.0 * half.atan2(rest)
}

/// Fold angles of the waterbomb's symmetric motion at the parameter t = tan(m/2), with the angle m of the middle lines.
#[derive(Clone, Copy, Debug)]
pub struct Waterbomb {
    /// Fold angle of the middle lines.
    pub middle: f64,
    /// Fold angle of the cross lines.
    pub cross: f64,
    /// Fold angle of the diagonals, the only mountains.
    pub diagonal: f64,
    /// Fold angle of the boundary lines.
    pub boundary: f64,
}

impl Waterbomb {
    /// Returns the four fold angles at `t`.
    #[must_use]
    pub fn at(t: f64) -> Self {
        let [middle, cross] = [t, 2.0 * t].map(|u| 2.0 * u.atan());
        Self {
            middle,
            cross,
            diagonal: -2.0 * (SQRT_2 * t).atan(),
            boundary: 2.0 * cross - middle,
        }
    }

    /// Returns the fold angle of the crease between two points, `ends`, of the unit-square grid. Units of the pattern
    /// begin at even columns, and in every other pair of rows at odd ones.
    #[must_use]
    pub fn of_crease(&self, ends: [[f64; 2]; 2]) -> f64 {
        let [[x, y], [other_x, other_y]] = ends;
        let upright = (other_x - x).abs() < 0.5;
        let level = (other_y - y).abs() < 0.5;
        let at_unit_side = (x + (y.min(other_y) / 2.0).floor()) % 2.0 < 0.5;
        match (upright, level) {
            (true, _) if at_unit_side => self.boundary,
            (true, _) => self.middle,
            (_, true) => self.cross,
            _ => self.diagonal,
        }
    }
}
