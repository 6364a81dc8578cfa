//! Bounds how far a point beyond some hinges deviates from a quadratic curve over an interval of a motion.

/// Change of a group angle over an interval, radians.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct AngleVariation {
    /// Total variation.
    pub total: f64,
    /// Largest distance from a straight line in time; the total variation counts instead if it is less.
    pub nonlinearity: f64,
}

/// Ratio of the largest distance of a function from the quadratic through its values at 0, 1/2 and 1 to its largest
/// third derivative: √3/216.
pub(crate) const CUBIC_RATIO: f64 = 0.008_018_753_738_744_8;

/// Bound on the deviation of a point from the quadratic through its places at the beginning, half way and at the end of
/// an interval. The bound is a sum over the hinges on the way to the point.
///
/// Let x be a point beyond hinges 1 … n, whose angles vary by vₖ in total and differ from straight lines in time by up
/// to bₖ. Let Lₖ be the length of the way from hinge k to x from pivot to pivot, which no folding makes longer. If all
/// angles changed uniformly, the third derivative of x would be no more than Σⱼ Σₖ Σₗ vⱼ vₖ vₗ L(max(j, k, l)), and x
/// no farther than √3/216 of that from the quadratic. As they do not, x deviates by up to Σₖ bₖ Lₖ more, and so does
/// its place half way.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct DeviationBound {
    /// Sum of the variations of the angles, radians.
    variation: f64,
    /// Bound on the deviation of the rotation (chord on the unit sphere).
    rotation: f64,
    /// Bound on the deviation of the last pivot, units of the sheet.
    shift: f64,
}

impl DeviationBound {
    /// Returns the bound beyond a hinge at distance `way` from the last pivot.
    pub(crate) fn across(self, way: f64, angle: AngleVariation) -> Self {
        let AngleVariation {
            total,
            nonlinearity,
        } = angle;
        Self {
            variation: self.variation + total,
            shift: self.at(way),
            rotation: self.rotation
                + CUBIC_RATIO * ((self.variation + total).powi(3) - self.variation.powi(3))
                + 2.0 * nonlinearity.min(total),
        }
    }

    /// Returns a bound on the deviation of a point at distance `way` from the last pivot.
    pub(crate) fn at(self, way: f64) -> f64 {
        self.shift + self.rotation * way
    }

    /// Returns a bound on the deviation of the rotation.
    pub(super) fn rotation(self) -> f64 {
        self.rotation
    }
}
