//! Tolerances and budgets of the search for crossings.
//!
//! First comes what counts as equal, touching or crossing; then the precision of places on the motion; then when and how
//! pairs are queried; then budgets. Names end in the unit: median edges, radians, ticks (2^-36 of a segment) or segments.
//! A ratio has no unit; its comment says of what to what. Limits on numbers of things begin with `MAX_`.

use super::sweep::motion::{SEGMENT, Tick};
use crate::util::range::Range;

/// Depth of contact that a user may choose.
pub const CONTACT_EDGES: Range = Range::from("median edges", 0.0).up_to(MAX_ROUNDING_EDGES);

/// Depth above which an overlap counts as a crossing; a shallower overlap is contact. It is measured within the planes of
/// the faces: they are in contact if they are apart once both are smaller by this all round.
pub(crate) const CROSSING_DEPTH_EDGES: f64 = 1e-6;
/// Sine of the angle between two faces below which they are layers, parallel but for rounding: their depth is measured
/// across them, not within.
pub(super) const MIN_LEAN: f64 = 5e-4;
/// Ratio of the depth that counts as a crossing to the size of the smaller of two faces, if that is less than
/// `CROSSING_DEPTH_EDGES`: faces however thin do not pass through others.
pub(super) const CROSSING_DEPTH_RATIO: f64 = 1e-3;
/// Ratio of the distance by which plates may fail to stay back from a hinge, for rounding, to the depth that counts as a
/// crossing.
pub(super) const KEPT_BACK_RATIO: f64 = 1e-3;
/// Ratio of a tear at a hinge to the thickness of plates up to which it may move the plates into each other there.
pub(super) const HINGE_TEAR_RATIO: f64 = 1e-3;
/// Smallest depth that two pieces in contact may gain until the next query, as a fraction of the depth up to which an
/// overlap is contact. Without it, pieces that rest on each other at that depth would be queried without end.
pub(super) const MIN_LEFT_RATIO: f64 = 0.005;
/// Ratio of a tear at a common vertex to the size of the smaller face up to which an overlap of the two faces may come
/// from the tear.
pub(super) const MAX_TEAR_RATIO: f64 = 0.5;
/// Largest part of the distance of two faces that the tears along a chain between them may use up; for nearer faces, the
/// chain follows the spanning tree, along which nothing is torn.
pub(super) const CHAIN_TEAR_RATIO: f64 = 0.25;
/// Ratio of the room that pieces at a torn side have, to the angle at which they may be in each other, from which on their
/// next query follows from that angle alone. With less room, steps would become ever shorter.
pub(super) const MIN_OPENING_RATIO: f64 = 0.25;
/// Ratio of the displacement that is attributed to rounded coordinates to the unit of their last digit: errors add up
/// along the chain of faces from one face to another.
pub(super) const CHAIN_ROUNDING_RATIO: f64 = 10.0;
/// Largest displacement that is attributed to rounded coordinates.
pub(super) const MAX_ROUNDING_EDGES: f64 = 1e-3;
/// Ratio of that displacement to the size of the smaller of two faces, if that is less.
pub(super) const MAX_ROUNDING_RATIO: f64 = 1e-3;
/// Ratio of a corner's distance from a plane to the tolerance up to which the corner is close to the plane.
pub(super) const CLOSE_TO_PLANE_RATIO: f64 = 1e3;
/// Ratio of the distance of two pieces to the tolerance up to which they are treated as touching: a plane then allows a
/// step of the square root of a tolerance.
pub(super) const TOUCHING_RATIO: f64 = 1e3;
/// Part of the distance of two pieces that stand still at a distance that they keep up to the next query.
pub(super) const KEPT_RATIO: f64 = 0.9;
/// Relative slack for rounding: a point that is behind a side by no more than this ratio of its length and offset
/// counts as ahead of it.
pub(super) const SIDE_ROUNDING_RATIO: f64 = 1e-9;
/// Largest angle between creases that count as parallel: such an error moves points a thousand edges away by less than
/// the depth that counts as a crossing.
pub(super) const PARALLEL_RAD: f64 = 1e-10;
/// Largest variation of a group over a segment for which the group counts as still.
pub(super) const STILL_RAD: f64 = 1e-9;
/// Largest turn of a lattice step at the end of a segment for which the step is treated as a translation (norm of the
/// residual).
pub(super) const TRANSLATION_RAD: f64 = 1e-3;
/// Ratio of the relative motion of faces to the tolerance up to which the faces may be at rest relative to each other
/// over a shorter part: the largest ratio by which a part is shorter than the segment.
pub(super) const NEARLY_AT_REST_RATIO: f64 = 64.0;
/// Largest coefficient of a curve: squares of sums of squares are still finite.
pub(super) const MAX_COEFFICIENT: f64 = 1e75;

/// Precision of the last free place: 2^-20 of a segment.
pub(super) const LAST_FREE_TICKS: Tick = 1 << 16;
/// Precision of the last free place for hinges that turn past half a turn.
pub(super) const OVERTURNED_SEGMENTS: f64 = 1e-6;
/// Number of bisections in the search for the place where a hinge turns past half a turn: to a millionth of a segment.
pub(super) const MAX_BISECTIONS: u32 = 20;

/// Ratio of the distance of two clusters to the larger one's radius up to which the clusters are split.
pub(super) const SPLIT_RATIO: f64 = 0.5;
/// Ratio of the distance of two pieces' spheres to the smaller one's radius up to which the pieces are measured
/// exactly.
pub(super) const MEASURE_RATIO: f64 = 0.5;
/// Number of tabulated times over which pairs represented by their cells have to stay apart.
pub(super) const APART_TIMES: usize = 1;
/// Number of tabulated times over which such pairs have to stay apart if they may be the nearest of all.
pub(super) const NEAREST_APART_TIMES: usize = 6;
/// Number of tabulated times ahead for which cells are woken.
pub(super) const WAKE_TIMES: usize = 4;
/// Approximate number of tabulated times in the whole motion; their number in a segment is a power of two.
pub(super) const TABULATED_TIMES: usize = 64;
/// Number of multiples of the step's length among which the next time is chosen, so that the queries of different pairs
/// coincide.
pub(super) const STEP_MULTIPLES: u64 = 4;
/// Number of small parts of the interval between tabulated times.
pub(super) const SMALL_PARTS: u32 = 64;
/// Number of parts of a segment over which third derivatives are bounded.
pub(super) const THIRD_DERIVATIVE_PARTS: u32 = 8;
/// Length of such a part.
pub(super) const THIRD_DERIVATIVE_PART_TICKS: Tick = SEGMENT / THIRD_DERIVATIVE_PARTS as Tick;
/// Limit on the deviation of a piece from its quadratic over an interval; intervals are shortened to meet it.
pub(super) const MAX_DEVIATION_EDGES: f64 = 1.0 / 8.0;
/// Shortest interval of the broad phase.
pub(super) const MIN_INTERVAL_TICKS: Tick = SEGMENT >> 14;
/// Cost of crossing a crease that turns, in the search for a chain of faces; crossing another edge costs 1.
pub(super) const TURNING_COST: u32 = 1 << 12;

/// Number of pairs for which ways of faces are looked for at once.
pub(super) const WAYS_AT_ONCE: usize = 1 << 12;

/// Number of short steps of a pair in a row after which the planes through a side of each piece are tried.
pub(super) const SIDES_AFTER: u32 = 8;
/// Number of short steps of a pair in a row after which planes are tried though the pieces do not touch.
pub(super) const PLANES_AFTER: u32 = 64;
/// Number of short steps of a pair in a row after which later times are looked at for a crossing, and again after as many.
pub(super) const LOOK_AHEAD_AFTER: u32 = 1 << 10;
/// Number of short steps of a pair in a row after which it is not known whether the pair crosses: pairs that get on do so
/// within a tenth as many.
pub(super) const MAX_SHORT_STEPS: u32 = 1 << 14;
/// Number of queries between two readings of the clock.
pub(super) const QUERIES_PER_CLOCK: u64 = 256;
/// Number of evaluations of the motion bound after which the search for the last safe time stops.
pub(super) const MAX_EVALUATIONS: usize = 2;
/// Largest number of differences of cells that are followed.
pub(super) const MAX_OFFSETS: usize = 6000;
/// Largest number of followers that share the pairs of a sheet, and of pieces that all of them have together: each has
/// copies of all pieces.
pub(super) const MAX_FOLLOWERS: usize = 8;
pub(super) const MAX_FOLLOWED_PIECES: usize = 1_000_000;
/// Number of times that a segment is halved to find comoving faces.
pub(super) const MAX_PARTINGS: usize = 6;
/// Largest number of hinges against one body for which each is compared with all others.
pub(super) const MAX_HINGES: usize = 1000;
/// Largest number of entries of the table of times, unless one time per segment takes more.
pub(super) const MAX_TABLE_ENTRIES: usize = 1 << 16;
/// Largest number of faces for which the distances between all faces are kept: 2^24 numbers.
pub(super) const MAX_FACES_OF_DISTANCES: usize = 1 << 12;
/// Number of corners up to which circles round the middle of two corners are tried.
pub(super) const MAX_CIRCLE_CORNERS: usize = 8;
/// Number of successive subdivisions of a curve that is not proved to be monotone.
pub(super) const MAX_SUBDIVISIONS: u32 = 8;
