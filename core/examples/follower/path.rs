// Miura 3x3: 8 knots of 2 groups, 12 hinges, 14.248 s. Written by `foldpath export --to rust`.

/// How the motion between knots is made.
pub const INTERPOLATION: foldpath_core::Interpolation = foldpath_core::Interpolation::Homogeneous;
/// Number of crease groups.
pub const GROUPS: usize = 2;
/// Largest closure residual of a commanded configuration.
pub const CLOSURE: f32 = 2.123852e-6;
/// Seconds of the knots since the knot before, 0 at the first.
#[allow(clippy::approx_constant)]
pub const SPANS: &[f32] = &[
    0.0, 4.050696, 1.2614825, 1.5715609, 1.4153627, 1.8023404, 1.0113451, 3.1350207,
];
/// Fold angles in radians, a row a knot.
#[allow(clippy::approx_constant)]
pub const ANGLES: &[f32] = &[
    0.0, -0.0, 0.5515206, 0.2811038, 0.9482178, 0.50231063, 1.557619, 0.9167948, 2.052501,
    1.3803047, 2.4886527, 1.9511137, 2.642087, 2.1981118, 2.8274333, 2.5280542,
];
/// Their rates in radians per second.
#[allow(clippy::approx_constant)]
pub const RATES: &[f32] = &[
    0.0, -0.0, 0.27219725, 0.14411147, 0.35668632, 0.2113886, 0.3971818, 0.315253, 0.3021754,
    0.33480847, 0.18191178, 0.27803606, 0.124466494, 0.21037701, 0.0, -0.0,
];
/// Weights and their rates, a row a knot; none unless the interpolation has them.
#[allow(clippy::approx_constant)]
pub const WEIGHTS: &[[f32; 2]] = &[
    [1.0, 0.0], [1.0, 0.0], [1.0, 0.0], [0.9718016, -0.027518487], [1.0, -1.5308996e-17],
    [0.91851753, -0.059150472], [1.0, 0.0], [0.7936885, -0.09382161], [1.0, -5.2585446e-17],
    [0.6717634, -0.074744456], [1.0, 0.0], [0.57195896, -0.036229372], [1.0, 2.7553335e-17],
    [0.54389125, -0.020552734], [1.0, 0.0], [0.5180288, 0.0],
];
/// Limits of the groups.
#[allow(clippy::approx_constant)]
pub const LIMITS: &[foldpath_core::GroupLimits] = &[
    foldpath_core::GroupLimits { lower: -3.1415927, upper: 3.1415927, speed: 0.7853981, acceleration: 0.06981317 },
    foldpath_core::GroupLimits { lower: -3.1415927, upper: 3.1415927, speed: 0.7853981, acceleration: 0.06981317 },
];
/// Group and sign of each hinge.
#[allow(clippy::approx_constant)]
pub const HINGES: &[foldpath_core::Membership] = &[
    hinge(0, false), hinge(0, true), hinge(1, true), hinge(0, false), hinge(1, false),
    hinge(0, true), hinge(1, true), hinge(1, false), hinge(0, false), hinge(1, true),
    hinge(0, true), hinge(1, false),
];
/// Spokes of the essential vertices.
#[allow(clippy::approx_constant)]
pub const SPOKES: &[foldpath_core::Spoke<f32>] = &[
    spoke(1, true, [-1.0, -0.0]), spoke(0, false, [-0.5, -0.8660254]), spoke(1, false, [1.0, 0.0]),
    spoke(0, false, [-0.5, 0.8660254]),
];
/// Where the spokes of each vertex end.
#[allow(clippy::approx_constant)]
pub const ENDS: &[u32] = &[
    4,
];

#[allow(dead_code)]
const fn hinge(group: u32, negative: bool) -> foldpath_core::Membership {
    foldpath_core::Membership { group: foldpath_core::GroupId(group), negative }
}

#[allow(dead_code)]
const fn spoke(group: u32, negative: bool, direction: [f32; 2]) -> foldpath_core::Spoke<f32> {
    foldpath_core::Spoke { group: foldpath_core::GroupId(group), negative, direction }
}
