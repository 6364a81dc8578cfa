//! The closure residual of a loop of faces round a hole, and its analytic Jacobian.
//!
//! Round a vertex the panels turn about axes through one point, and the rotations alone say whether they
//! meet again. Round a hole the axes lie anywhere: the product L of the rigid motions across the creases
//! met has to be the identity in rotation and in translation, six conditions. This is the folding map
//! of [XiLien2015](crate#references), section 3.2, closed to a cycle.
//!
//! Places are measured from a point near the middle of the loop in units of the loop's size, so that
//! both residuals are dimensionless: r of L's rotation as of a [star](crate::closure), and t, by which L
//! moves that point.
//!
//! With P and p the rotation and translation before crease k, a = P·axis and q = P·place + p, a turn of
//! that crease turns all that follows about a through q: ∂r/∂ρ = w a + a × v as of a star, and
//! ∂t/∂ρ = a × (t − q).

use nalgebra::Vector3;

use crate::closure::{derivative, positive};
use crate::{HalfAngle, Rotation, Scalar, Spoke, StarsView};

/// The creases that a way from face to face round a hole crosses, in order.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LoopView<'a, T> {
    /// The creases; the direction of each has the face that the way comes to on its left.
    pub spokes: &'a [Spoke<T>],
    /// For each a point of its line.
    pub places: &'a [[T; 2]],
}

/// A list of loops in three borrowed arrays: stars whose spokes have places.
#[derive(Clone, Copy, Debug)]
pub struct LoopsView<'a, T> {
    stars: StarsView<'a, T>,
    places: &'a [[T; 2]],
}

impl<'a, T: Scalar> LoopsView<'a, T> {
    /// No loop: a sheet without holes.
    #[must_use]
    pub fn none() -> Self {
        Self {
            stars: StarsView::none(),
            places: &[],
        }
    }

    /// A view of loops that lie one behind the other; loop i ends before spoke `ends[i]`.
    ///
    /// Returns `None` if the ends decrease or do not end with the last spoke, if not every spoke has a
    /// place, if a group is not below `unknowns`, or if a direction is not of length one.
    #[must_use]
    pub fn new(
        spokes: &'a [Spoke<T>],
        places: &'a [[T; 2]],
        ends: &'a [u32],
        unknowns: usize,
    ) -> Option<Self> {
        let stars = StarsView::new(spokes, ends, unknowns)?;
        (places.len() == spokes.len()).then_some(Self { stars, places })
    }

    /// Number of loops.
    #[must_use]
    pub fn len(&self) -> usize {
        self.stars.len()
    }

    /// Whether there is no loop at all.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.stars.is_empty()
    }

    /// Largest number of spokes in a loop.
    #[must_use]
    pub fn max_degree(&self) -> usize {
        self.stars.max_degree()
    }

    /// The loops in order.
    pub fn iter(&self) -> impl Iterator<Item = LoopView<'a, T>> + use<'a, T> {
        self.stars.iter().scan(self.places, |left, star| {
            let (places, rest) = left.split_at_checked(star.spokes.len())?;
            *left = rest;
            Some(LoopView {
                spokes: star.spokes,
                places,
            })
        })
    }
}

/// Residuals of rotation and translation (dimensionless): zero exactly where the loop closes.
///
/// `half_angles` has one entry for each unknown; a spoke whose group is not there counts as flat.
#[must_use]
pub fn residuals<T: Scalar>(
    cycle: LoopView<'_, T>,
    half_angles: &[HalfAngle<T>],
) -> [Vector3<T>; 2] {
    let mut motion = Motion::none();
    for (spoke, place) in cycle.spokes.iter().zip(cycle.places) {
        if let Some(half) = half_angles.get(spoke.group.index()) {
            motion.turn(half.signed(spoke.negative), spoke, place);
        }
    }
    [positive(motion.turned).v * T::TWO, motion.moved]
}

/// The residuals, and their derivatives by the fold angle of each spoke in `columns`: first those of
/// the rotation, then those of the translation.
///
/// Returns `None` if `columns` has not twice the length of the loop or a group is missing.
pub fn residuals_and_jacobian<T: Scalar>(
    cycle: LoopView<'_, T>,
    half_angles: &[HalfAngle<T>],
    columns: &mut [Vector3<T>],
) -> Option<[Vector3<T>; 2]> {
    let (turns, moves) = columns.split_at_mut_checked(cycle.spokes.len())?;
    if moves.len() != turns.len() {
        return None;
    }
    let spokes = || cycle.spokes.iter().zip(cycle.places);
    let mut motion = Motion::none();
    for ((spoke, place), (axis, through)) in spokes().zip(turns.iter_mut().zip(moves.iter_mut())) {
        *axis = motion.turned.rotate_in_sheet(spoke.direction);
        *through = motion.apply(place);
        let half = half_angles.get(spoke.group.index())?;
        motion.turn(half.signed(spoke.negative), spoke, place);
    }
    let closure = positive(motion.turned);
    for (spoke, (turn, shift)) in cycle.spokes.iter().zip(turns.iter_mut().zip(moves)) {
        let axis = if spoke.negative { -*turn } else { *turn };
        *turn = derivative(closure, &axis);
        *shift = axis.cross(&(motion.moved - *shift));
    }
    Some([closure.v * T::TWO, motion.moved])
}

/// The rigid motion of a face of the loop.
struct Motion<T> {
    turned: Rotation<T>,
    moved: Vector3<T>,
}

impl<T: Scalar> Motion<T> {
    fn none() -> Self {
        Self {
            turned: Rotation::identity(),
            moved: Vector3::new(T::zero(), T::zero(), T::zero()),
        }
    }

    fn apply(&self, place: &[T; 2]) -> Vector3<T> {
        self.turned.rotate_in_sheet(*place) + self.moved
    }

    /// On to the face behind a crease, whose line stays where it is.
    fn turn(&mut self, half: HalfAngle<T>, spoke: &Spoke<T>, place: &[T; 2]) {
        let before = self.apply(place);
        self.turned = self.turned.across_crease(half, spoke.direction);
        self.moved += before - self.apply(place);
    }
}
