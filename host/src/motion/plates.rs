//! Panels that are plates: their thickness, the place of the hinges in it, and the form of their sides.

use core::f64::consts::PI;

use foldpath_core::Curve;
use foldpath_core::bernstein::halves;

use super::Motion;
use crate::util::range::Range;

/// Thickness of plates.
pub const THICKNESS: Range = Range::above("a length", 0.0).up_to(1e50);
/// Distance of upright sides from their hinges.
pub const GAP: Range = Range::from("a length", 0.0);
/// Height of the hinge plane in a plate, over its thickness.
pub const HINGE_PLANE: Range = Range::from("a fraction", 0.0).up_to(1.0);
/// Angle by which plates may turn beyond the motion.
pub const MARGIN_DEG: Range = Range::from("degrees", 0.0).up_to(30.0);
/// Largest fold angle of a hinge between plates. The tapers of a hinge grow with the tangent of half its angle: at this
/// angle a plate on the closing side stays back by 11 times its height.
pub const MAX_PLATE_ANGLE_DEG: f64 = 170.0;

/// Accuracy with which the largest angle of a hinge is found, radians.
const ANGLE_RAD: f64 = 1e-12;
/// Largest number of successive halvings in this search.
const MAX_HALVINGS: u32 = 48;

/// Form of the sides of plates at hinges.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[non_exhaustive]
pub enum PlateSides {
    /// Slanted: two neighbours touch along their sides at the largest angle of the hinge.
    #[default]
    Taper,
    /// Upright: the plates stay back from the hinge, and a flexible film or tape joins them.
    Inset,
}

impl PlateSides {
    /// All forms.
    pub const ALL: [Self; 2] = [Self::Taper, Self::Inset];

    /// Returns the name of the form in files.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Self::Taper => "taper",
            Self::Inset => "inset",
        }
    }
}

/// Plates of which the panels of a sheet are made. Lengths are in units of the sheet.
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub struct PlateOptions {
    /// Thickness of the plates; finite and above 0.
    pub thickness: f64,
    /// Height of the hinge plane over the lower face of the plates, over the thickness: 0 to 1.
    pub hinge_plane: f64,
    /// Form of the sides at hinges.
    pub sides: PlateSides,
    /// Least distance of an upright side from its hinge, measured in the plate; 0 or more.
    pub gap: f64,
    /// Angle by which hinges could turn beyond the motion before plates touch, radians; 0 or more.
    pub margin: f64,
    /// `true` to cut off corners of plates that share a vertex and no hinge at it, where they would pass through each other.
    pub cuts_corners: bool,
}

impl PlateOptions {
    /// Returns plates of this thickness with tapered sides and hinges in the middle.
    #[must_use]
    pub fn of_thickness(thickness: f64) -> Self {
        Self {
            thickness,
            hinge_plane: 0.5,
            sides: PlateSides::default(),
            gap: 0.0,
            margin: 0.0,
            cuts_corners: false,
        }
    }

    /// Returns the depth of the plates below the hinge plane and their height above it.
    #[must_use]
    pub fn heights(&self) -> [f64; 2] {
        let below = self.hinge_plane * self.thickness;
        [below, self.thickness - below]
    }

    /// Returns the larger of depth and height: no point of a plate is farther from the hinge plane.
    #[must_use]
    pub fn reach(&self) -> f64 {
        let [below, above] = self.heights();
        below.max(above)
    }

    /// Returns these plates in a unit that is smaller by this factor.
    pub(super) fn scaled(self, factor: f64) -> Self {
        Self {
            thickness: factor * self.thickness,
            gap: factor * self.gap,
            ..self
        }
    }
}

crate::util::changed_one_by_one!(PlateOptions);

impl Motion {
    /// Returns the least and the largest fold angle of each crease over the whole motion, radians. Both are exact to 1e-12,
    /// and never too near to 0.
    #[must_use]
    pub fn angle_ranges(&self) -> Vec<[f64; 2]> {
        let mut of_groups: Vec<[f64; 2]> = match &self.knots[..] {
            [only] => only.angles.iter().map(|&angle| [angle; 2]).collect(),
            _ => vec![[f64::INFINITY, f64::NEG_INFINITY]; self.groups()],
        };
        for segment in 0..self.segments() {
            for (range, curve) in of_groups.iter_mut().zip(self.curves(segment)) {
                extend(range, &curve, MAX_HALVINGS);
            }
        }
        let of_crease = |&edge| {
            self.members[crate::pattern::EdgeId::index(edge)].map_or([0.0; 2], |member| {
                let [low, high] = of_groups[member.group.index()];
                if member.negative {
                    [-high, -low]
                } else {
                    [low, high]
                }
            })
        };
        self.pattern.creases().iter().map(of_crease).collect()
    }
}

/// Widens a range so that it contains the angles of a curve.
fn extend(range: &mut [f64; 2], curve: &Curve<f64>, halvings: u32) {
    for s in [0.0, 1.0] {
        let angle = curve.angle(s);
        *range = [range[0].min(angle), range[1].max(angle)];
    }
    let [low, high] = bounds(curve);
    if low >= range[0] - ANGLE_RAD && high <= range[1] + ANGLE_RAD || halvings == 0 {
        *range = [range[0].min(low), range[1].max(high)];
        return;
    }
    let parts = match curve {
        Curve::Angle(angle) => halves(angle).map(Curve::Angle),
        Curve::HalfAngle { cos, sin } => {
            let ([first, second], [first_sin, second_sin]) = (halves(cos), halves(sin));
            [(first, first_sin), (second, second_sin)]
                .map(|(cos, sin)| Curve::HalfAngle { cos, sin })
        }
    };
    for part in &parts {
        extend(range, part, halvings - 1);
    }
}

/// Returns bounds on the angles of a curve: those of its control points, or none if these exclude no angle.
fn bounds(curve: &Curve<f64>) -> [f64; 2] {
    let ends = |angles: [f64; 4]| {
        let start = [f64::INFINITY, f64::NEG_INFINITY];
        let wider = |[low, high]: [f64; 2], angle: &f64| [low.min(*angle), high.max(*angle)];
        angles.iter().fold(start, wider)
    };
    match curve {
        Curve::Angle(angle) => ends(*angle),
        Curve::HalfAngle { cos, sin } => {
            let [low, high] = ends(core::array::from_fn(|k| 2.0 * sin[k].atan2(cos[k])));
            if high - low < PI {
                [low, high]
            } else {
                [-PI, PI]
            }
        }
    }
}
